//! TOML -> values with places, strictly: known keys, right types, finite numbers, nothing guessed.

use super::{JobError, Place};
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A file's text and name.
pub(super) struct Source<'a> {
    file: &'a str,
    text: &'a str,
    /// Where each line begins [bytes].
    lines: Vec<usize>,
}

impl<'a> Source<'a> {
    pub fn new(file: &'a str, bytes: &'a [u8]) -> Result<Self, JobError> {
        let refuse = |place, detail: &str| {
            Err(JobError {
                file: file.into(),
                place,
                key: None,
                name: "BadFile",
                detail: detail.into(),
            })
        };
        match std::str::from_utf8(bytes) {
            Ok(text) if text.trim().is_empty() => refuse(
                None,
                "it is empty; a job file is TOML text that begins with kind = \"drill-point\", kind = \"counts\" or kind = \"path\"",
            ),
            Ok(text) if text.contains('\0') => refuse(
                None,
                "it holds bytes that no text has; a job file is TOML text in UTF-8",
            ),
            Ok(text) => {
                let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
                let lines = std::iter::once(0)
                    .chain(ends.map(|(at, _)| at + 1))
                    .collect();
                Ok(Self { file, text, lines })
            }
            Err(error) => {
                let good = String::from_utf8_lossy(&bytes[..error.valid_up_to()]).into_owned();
                let place = place_of(&good, good.len());
                refuse(
                    Some(place),
                    "it is not text in UTF-8; a job file is TOML text",
                )
            }
        }
    }

    pub fn document(&self) -> Result<Spanned<DeTable<'a>>, JobError> {
        DeTable::parse(self.text).map_err(|error| JobError {
            file: self.file.into(),
            place: error.span().map(|span| self.place(&span)),
            key: None,
            name: "BadToml",
            detail: format!(
                "{}; a line is `key = value`, a table begins with `[name]`",
                error.message().trim().replace('\n', ", ")
            ),
        })
    }

    fn place(&self, span: &Range<usize>) -> Place {
        // By the table of lines, so that a file of many points takes no time.
        let line = self.lines.partition_point(|begin| *begin <= span.start);
        let begin = self.lines[line.saturating_sub(1)];
        let within = place_of(&self.text[begin..], span.start - begin);
        Place {
            line,
            column: within.column,
        }
    }
}

fn place_of(text: &str, offset: usize) -> Place {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line_start = before
        .iter()
        .rposition(|b| *b == b'\n')
        .map_or(0, |n| n + 1);
    Place {
        line: 1 + before.iter().filter(|b| **b == b'\n').count(),
        // Continuation bytes of a character are not counted.
        column: 1 + before[line_start..]
            .iter()
            .filter(|b| **b & 0xc0 != 0x80)
            .count(),
    }
}

/// The range in which a number is right.
#[derive(Clone, Copy)]
pub(super) struct Kind {
    above: f64,
    least: f64,
    most: f64,
    unit: &'static str,
}

impl Kind {
    /// Any finite number: its range is checked elsewhere.
    pub const ANY: Self = Self {
        above: f64::NEG_INFINITY,
        least: f64::NEG_INFINITY,
        most: f64::INFINITY,
        unit: "",
    };

    /// Any number, even none and infinite ones: a process names what is wrong with it in its own words.
    pub const LOOSE: Self = Self {
        above: f64::NAN,
        ..Self::ANY
    };

    /// `least ..= most`
    pub const fn between(least: f64, most: f64, unit: &'static str) -> Self {
        Self {
            above: f64::NEG_INFINITY,
            least,
            most,
            unit,
        }
    }

    /// Greater than 0, at most `most`.
    pub const fn positive(most: f64, unit: &'static str) -> Self {
        Self {
            above: 0.0,
            least: f64::NEG_INFINITY,
            most,
            unit,
        }
    }

    fn is_loose(&self) -> bool {
        self.above.is_nan()
    }

    fn holds(&self, x: f64) -> bool {
        x > self.above && x >= self.least && x <= self.most
    }

    fn told(&self) -> String {
        let Self {
            above,
            least,
            most,
            unit,
        } = self;
        if *above == 0.0 {
            format!("a number greater than 0 and at most {most} {unit}")
        } else {
            format!("a number from {least} to {most} {unit}")
        }
    }
}

type Entry<'a, 's> = (&'s Range<usize>, &'a DeValue<'a>);

/// An element of an array: its key, its place in the text, its value.
type Element<'a> = (String, Range<usize>, &'a DeValue<'a>);

/// A table of the file, or the whole of it.
pub(super) struct Table<'a> {
    source: &'a Source<'a>,
    /// `""` for the root, else the table's name with a point.
    path: String,
    entries: &'a DeTable<'a>,
    place: Place,
}

impl<'a> Table<'a> {
    pub fn root(source: &'a Source<'a>, document: &'a Spanned<DeTable<'a>>) -> Self {
        Self {
            source,
            path: String::new(),
            entries: document.get_ref(),
            place: Place { line: 1, column: 1 },
        }
    }

    fn refuse(
        &self,
        place: Option<Place>,
        key: &str,
        name: &'static str,
        detail: String,
    ) -> JobError {
        JobError {
            file: self.source.file.into(),
            place,
            key: Some(format!("{}{key}", self.path)),
            name,
            detail,
        }
    }

    /// Refuses any key that is not in the list.
    pub fn known(&self, keys: &[&str]) -> Result<(), JobError> {
        self.check_known(keys, "no such key is known here")
    }

    /// The same at the root, for tables that another kind of job has.
    pub fn known_for(&self, kind: &str, keys: &[&str]) -> Result<(), JobError> {
        self.check_known(keys, &format!("a job of kind \"{kind}\" has no such table"))
    }

    fn check_known(&self, keys: &[&str], why: &str) -> Result<(), JobError> {
        let strangers = self
            .entries
            .keys()
            .filter(|key| !keys.contains(&key.get_ref().as_ref()));
        // The first in the file, not in the alphabet.
        match strangers.min_by_key(|key| key.span().start) {
            None => Ok(()),
            Some(key) => {
                let place = Some(self.source.place(&key.span()));
                let detail = format!(
                    "{why}; expected are {}; remove it or correct its spelling",
                    keys.join(", ")
                );
                Err(self.refuse(place, key.get_ref(), "UnknownField", detail))
            }
        }
    }

    pub fn has(&self, key: &str) -> bool {
        self.entries.get(key).is_some()
    }

    fn entry(
        &self,
        key: &str,
        expected: &str,
    ) -> Result<(Range<usize>, &'a DeValue<'a>), JobError> {
        match self.entries.get(key) {
            Some(value) => Ok((value.span(), value.get_ref())),
            None => {
                let detail = format!("it is missing; add {key} = {expected}");
                Err(self.refuse(Some(self.place), key, "MissingField", detail))
            }
        }
    }

    fn wrong_type(
        &self,
        span: &Range<usize>,
        key: &str,
        expected: &str,
        found: &DeValue<'_>,
    ) -> JobError {
        let detail = format!("expected {expected}, found {}", told(found));
        self.refuse(Some(self.source.place(span)), key, "WrongType", detail)
    }

    /// A table within this one.
    pub fn table(&self, key: &str) -> Result<Table<'a>, JobError> {
        match self.table_if_any(key)? {
            Some(table) => Ok(table),
            None => {
                let detail = format!(
                    "the table [{}{key}] is missing; add it with its keys",
                    self.path
                );
                Err(self.refuse(None, key, "MissingField", detail))
            }
        }
    }

    pub fn table_if_any(&self, key: &str) -> Result<Option<Table<'a>>, JobError> {
        let Some(value) = self.entries.get(key) else {
            return Ok(None);
        };
        match value.get_ref() {
            DeValue::Table(entries) => Ok(Some(Table {
                source: self.source,
                path: format!("{}{key}.", self.path),
                entries,
                place: self.source.place(&value.span()),
            })),
            found => Err(self.wrong_type(&value.span(), key, &format!("a table, [{key}]"), found)),
        }
    }

    /// The tables of an array of tables, at least one.
    pub fn tables(&self, key: &str) -> Result<Vec<Table<'a>>, JobError> {
        let (span, value) = self.entry(key, &format!("..., as tables [[{key}]]"))?;
        let expected = format!("at least one table [[{key}]]");
        let DeValue::Array(items) = value else {
            return Err(self.wrong_type(&span, key, &expected, value));
        };
        if items.is_empty() {
            let place = Some(self.source.place(&span));
            return Err(self.refuse(place, key, "OutOfRange", format!("expected {expected}")));
        }
        let mut tables = Vec::new();
        for (index, item) in items.iter().enumerate() {
            match item.get_ref() {
                DeValue::Table(entries) => tables.push(Table {
                    source: self.source,
                    path: format!("{}{key}[{index}].", self.path),
                    entries,
                    place: self.source.place(&item.span()),
                }),
                found => return Err(self.wrong_type(&item.span(), key, &expected, found)),
            }
        }
        Ok(tables)
    }

    /// The same, or none at all.
    pub fn tables_if_any(&self, key: &str) -> Result<Vec<Table<'a>>, JobError> {
        if self.has(key) {
            self.tables(key)
        } else {
            Ok(Vec::new())
        }
    }

    /// A string that is not empty.
    pub fn text(&self, key: &str) -> Result<&'a str, JobError> {
        let (span, value) = self.entry(key, "a string")?;
        match value {
            DeValue::String(text) if !text.is_empty() => Ok(text),
            found => Err(self.wrong_type(&span, key, "a string that is not empty", found)),
        }
    }

    /// `true` or `false`; `false` where it is left out.
    pub fn flag(&self, key: &str) -> Result<bool, JobError> {
        match self
            .entries
            .get(key)
            .map(|value| (value.span(), value.get_ref()))
        {
            None => Ok(false),
            Some((_, DeValue::Boolean(flag))) => Ok(*flag),
            Some((span, found)) => Err(self.wrong_type(&span, key, "true or false", found)),
        }
    }

    /// A number, whole or not.
    pub fn number(&self, key: &str, kind: Kind) -> Result<f64, JobError> {
        let (span, value) = self.entry(key, "a number")?;
        self.number_of(key, (&span, value), kind)
    }

    pub fn number_or(&self, key: &str, default: f64, kind: Kind) -> Result<f64, JobError> {
        if self.has(key) {
            self.number(key, kind)
        } else {
            Ok(default)
        }
    }

    fn number_of(
        &self,
        key: &str,
        (span, value): Entry<'_, '_>,
        kind: Kind,
    ) -> Result<f64, JobError> {
        let place = Some(self.source.place(span));
        let read = match value {
            DeValue::Float(number) => number.as_str().parse::<f64>().ok(),
            DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
                .ok()
                .map(|whole| whole as f64),
            found => return Err(self.wrong_type(span, key, "a number", found)),
        };
        match read {
            Some(x) if kind.is_loose() => Ok(x),
            Some(x) if x.is_finite() && kind.holds(x) => Ok(x),
            Some(x) if x.is_finite() => {
                let detail = format!("expected {}, found {x}", kind.told());
                Err(self.refuse(place, key, "OutOfRange", detail))
            }
            _ => {
                let detail = format!("expected a finite number, found {}", told(value));
                Err(self.refuse(place, key, "NotFinite", detail))
            }
        }
    }

    /// A whole number from `least` to `most`.
    pub fn whole(&self, key: &str, least: i64, most: i64) -> Result<i64, JobError> {
        let (span, value) = self.entry(key, "a whole number")?;
        self.whole_of(key, (&span, value), least, most)
    }

    pub fn whole_or(
        &self,
        key: &str,
        default: i64,
        least: i64,
        most: i64,
    ) -> Result<i64, JobError> {
        if self.has(key) {
            self.whole(key, least, most)
        } else {
            Ok(default)
        }
    }

    fn whole_of(
        &self,
        key: &str,
        (span, value): Entry<'_, '_>,
        least: i64,
        most: i64,
    ) -> Result<i64, JobError> {
        let DeValue::Integer(number) = value else {
            if let DeValue::Float(float) = value
                && float.as_str().parse::<f64>().is_ok_and(|x| !x.is_finite())
            {
                let detail = format!("expected a whole number, found {}", told(value));
                return Err(self.refuse(Some(self.source.place(span)), key, "NotFinite", detail));
            }
            return Err(self.wrong_type(span, key, "a whole number", value));
        };
        match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(whole) if (least..=most).contains(&whole) => Ok(whole),
            _ => {
                let detail =
                    format!("expected a whole number from {least} to {most}, found {number}");
                Err(self.refuse(Some(self.source.place(span)), key, "OutOfRange", detail))
            }
        }
    }

    /// One of some words, by its index.
    pub fn word(&self, key: &str, words: &[&str]) -> Result<usize, JobError> {
        let choice = words
            .iter()
            .map(|word| format!("\"{word}\""))
            .collect::<Vec<_>>()
            .join(" or ");
        let (span, value) = self.entry(key, &choice)?;
        let DeValue::String(found) = value else {
            return Err(self.wrong_type(&span, key, &choice, value));
        };
        words.iter().position(|word| word == found).ok_or_else(|| {
            let detail = format!("expected {choice}, found \"{found}\"");
            self.refuse(Some(self.source.place(&span)), key, "UnknownName", detail)
        })
    }

    /// An array of N of some words, by their indices.
    pub fn words<const N: usize>(&self, key: &str, words: &[&str]) -> Result<[usize; N], JobError> {
        let mut found = [0; N];
        for (index, (key, span, value)) in found.iter_mut().zip(self.elements::<N>(key, "names")?) {
            let choice = words.join(", ");
            let DeValue::String(word) = value else {
                let expected = format!("one of the names {choice}");
                return Err(self.wrong_type(&span, &key, &expected, value));
            };
            *index = words
                .iter()
                .position(|known| known == word)
                .ok_or_else(|| {
                    let detail = format!("expected one of {choice}, found \"{word}\"");
                    self.refuse(Some(self.source.place(&span)), &key, "UnknownName", detail)
                })?;
        }
        Ok(found)
    }

    /// Whether the value is a string.
    pub fn is_word(&self, key: &str) -> bool {
        self.entries
            .get(key)
            .is_some_and(|value| value.get_ref().is_str())
    }

    fn elements<const N: usize>(&self, key: &str, of: &str) -> Result<[Element<'a>; N], JobError> {
        let (span, value) = self.entry(key, &format!("an array of {N} {of}"))?;
        self.elements_of(key, (&span, value), of)
    }

    fn elements_of<const N: usize>(
        &self,
        key: &str,
        (span, value): Entry<'a, '_>,
        of: &str,
    ) -> Result<[Element<'a>; N], JobError> {
        let expected = format!("an array of {N} {of}");
        let DeValue::Array(items) = value else {
            return Err(self.wrong_type(span, key, &expected, value));
        };
        let elements: Vec<_> = items
            .iter()
            .enumerate()
            .map(|(index, item)| (format!("{key}[{index}]"), item.span(), item.get_ref()))
            .collect();
        let found = elements.len();
        elements.try_into().map_err(|_| {
            let detail = format!("expected {expected}, found {found}");
            self.refuse(Some(self.source.place(span)), key, "WrongType", detail)
        })
    }

    /// Elements of an array; `None` where there is none.
    pub fn length(&self, key: &str) -> Option<usize> {
        match self.entries.get(key)?.get_ref() {
            DeValue::Array(items) => Some(items.len()),
            _ => None,
        }
    }

    /// An array of any numbers, as many as there are.
    pub fn list(&self, key: &str) -> Result<Vec<f64>, JobError> {
        let (span, value) = self.entry(key, "an array of numbers")?;
        self.list_of(key, (&span, value))
    }

    fn list_of(&self, key: &str, (span, value): Entry<'a, '_>) -> Result<Vec<f64>, JobError> {
        let DeValue::Array(items) = value else {
            return Err(self.wrong_type(span, key, "an array of numbers", value));
        };
        let number = |(index, item): (usize, &Spanned<DeValue<'a>>)| {
            let key = format!("{key}[{index}]");
            self.number_of(&key, (&item.span(), item.get_ref()), Kind::LOOSE)
        };
        items.iter().enumerate().map(number).collect()
    }

    /// An array of arrays of any numbers.
    pub fn lists(&self, key: &str) -> Result<Vec<Vec<f64>>, JobError> {
        let expected = "an array of arrays of numbers";
        let (span, value) = self.entry(key, expected)?;
        self.lists_of(key, (&span, value))
    }

    fn lists_of(&self, key: &str, (span, value): Entry<'a, '_>) -> Result<Vec<Vec<f64>>, JobError> {
        let DeValue::Array(items) = value else {
            return Err(self.wrong_type(span, key, "an array of arrays of numbers", value));
        };
        let list = |(index, item): (usize, &Spanned<DeValue<'a>>)| {
            self.list_of(&format!("{key}[{index}]"), (&item.span(), item.get_ref()))
        };
        items.iter().enumerate().map(list).collect()
    }

    /// Rows of rows of any numbers: a net of points.
    pub fn net(&self, key: &str) -> Result<Vec<Vec<Vec<f64>>>, JobError> {
        let expected = "an array of rows of points [x, y, z]";
        let (span, value) = self.entry(key, expected)?;
        let DeValue::Array(items) = value else {
            return Err(self.wrong_type(&span, key, expected, value));
        };
        let row = |(index, item): (usize, &Spanned<DeValue<'a>>)| {
            self.lists_of(&format!("{key}[{index}]"), (&item.span(), item.get_ref()))
        };
        items.iter().enumerate().map(row).collect()
    }

    /// An array of at least one and at most `most` arrays of N numbers.
    pub fn rows<const N: usize>(&self, key: &str, most: usize) -> Result<Vec<[f64; N]>, JobError> {
        let expected = format!("an array of 1 to {most} arrays of {N} numbers");
        let (span, value) = self.entry(key, &expected)?;
        let DeValue::Array(items) = value else {
            return Err(self.wrong_type(&span, key, &expected, value));
        };
        if items.is_empty() || items.len() > most {
            let place = Some(self.source.place(&span));
            let detail = format!("expected {expected}, found {}", items.len());
            return Err(self.refuse(place, key, "OutOfRange", detail));
        }
        let mut rows = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let key = format!("{key}[{index}]");
            let entry = (&item.span(), item.get_ref());
            let mut row = [0.0; N];
            let elements = self.elements_of::<N>(&key, entry, "numbers")?;
            for (number, (key, span, value)) in row.iter_mut().zip(elements) {
                *number = self.number_of(&key, (&span, value), Kind::ANY)?;
            }
            rows.push(row);
        }
        Ok(rows)
    }

    /// An array of N numbers.
    pub fn numbers<const N: usize>(&self, key: &str, kind: Kind) -> Result<[f64; N], JobError> {
        let mut numbers = [0.0; N];
        for (number, (key, span, value)) in
            numbers.iter_mut().zip(self.elements::<N>(key, "numbers")?)
        {
            *number = self.number_of(&key, (&span, value), kind)?;
        }
        Ok(numbers)
    }

    /// An array of N whole numbers.
    pub fn wholes<const N: usize>(
        &self,
        key: &str,
        least: i64,
        most: i64,
    ) -> Result<[i64; N], JobError> {
        let mut numbers = [0; N];
        for (number, (key, span, value)) in numbers
            .iter_mut()
            .zip(self.elements::<N>(key, "whole numbers")?)
        {
            *number = self.whole_of(&key, (&span, value), least, most)?;
        }
        Ok(numbers)
    }

    /// An array of N ranges `[lo, hi]`, lo < hi.
    pub fn ranges<const N: usize>(&self, key: &str) -> Result<[(f64, f64); N], JobError> {
        let mut ranges = [(0.0, 0.0); N];
        for (range, (key, span, value)) in ranges
            .iter_mut()
            .zip(self.elements::<N>(key, "ranges [lo, hi]")?)
        {
            let place = Some(self.source.place(&span));
            let DeValue::Array(ends) = value else {
                return Err(self.wrong_type(&span, &key, "a range [lo, hi]", value));
            };
            let [lo, hi] = ends.as_ref() else {
                let detail = format!("expected a range [lo, hi], found {} numbers", ends.len());
                return Err(self.refuse(place, &key, "WrongType", detail));
            };
            let lo = self.number_of(&key, (&lo.span(), lo.get_ref()), Kind::ANY)?;
            let hi = self.number_of(&key, (&hi.span(), hi.get_ref()), Kind::ANY)?;
            if lo >= hi {
                let detail = format!("expected lo < hi, found [{lo}, {hi}]");
                return Err(self.refuse(place, &key, "OutOfRange", detail));
            }
            *range = (lo, hi);
        }
        Ok(ranges)
    }

    /// The places of all values below this table, by their keys.
    pub fn note_places(&self, places: &mut BTreeMap<String, Place>) {
        for (key, value) in self.entries {
            note(
                self.source,
                format!("{}{}", self.path, key.get_ref()),
                value,
                places,
            );
        }
    }
}

fn note(
    source: &Source<'_>,
    key: String,
    value: &Spanned<DeValue<'_>>,
    places: &mut BTreeMap<String, Place>,
) {
    match value.get_ref() {
        DeValue::Table(entries) => {
            for (name, value) in entries {
                note(source, format!("{key}.{}", name.get_ref()), value, places);
            }
        }
        DeValue::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                note(source, format!("{key}[{index}]"), item, places);
            }
        }
        _ => {}
    }
    places.insert(key, source.place(&value.span()));
}

/// A value as a person would name it.
fn told(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) if text.chars().count() > 40 => "a long string".into(),
        DeValue::String(text) => format!("the string {text:?}"),
        DeValue::Integer(number) => format!("{number}"),
        DeValue::Float(number) => format!("{number}"),
        DeValue::Boolean(truth) => format!("{truth}"),
        DeValue::Datetime(_) => "a date".into(),
        DeValue::Array(items) => format!("an array of {}", items.len()),
        DeValue::Table(_) => "a table".into(),
    }
}
