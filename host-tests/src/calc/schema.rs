//! What a function of `hexstep calc` may be asked: its fields, and the check that comes before any formula.
//!
//! The check is made in the order that the interface promises: first every unknown field, then every missing one,
//! then every wrong type, then every unknown word; within each in the order of the request or of the table.

use super::Fault;
use hexstep::math::Real;
use serde_json::{Map, Value};

/// The form of a value.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A number, or one of the strings "nan", "inf", "-inf".
    Number,
    /// A whole number.
    Integer,
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
    /// An array, all of one kind.
    List(&'static Kind, Length),
    /// The value, or `null` with a meaning of its own.
    OrNull(&'static Kind),
    Object(&'static [Field]),
    /// The name of a preset, or an object; a wrong word is an `UnknownName`.
    Preset(&'static [&'static str], &'static [Field]),
    /// As `Preset`, but the function itself refuses unknown fields and words inside the object, by a name of its own.
    Open(&'static [&'static str], &'static [Field]),
    /// Anything: the function takes it apart and names its faults itself.
    Any,
}

/// How many entries an array has.
#[derive(Clone, Copy)]
pub enum Length {
    Any,
    Exactly(usize),
    Between(usize, usize),
}

/// Three numbers.
pub const VECTOR: Kind = Kind::List(&Kind::Number, Length::Exactly(3));
/// Numbers, as many as you like.
pub const NUMBERS: Kind = Kind::List(&Kind::Number, Length::Any);
/// `[lo, hi]`
pub const RANGE: Kind = Kind::List(&Kind::Number, Length::Exactly(2));

#[derive(Clone, Copy)]
enum Need {
    Required,
    Optional,
    /// JSON text of the value that stands for a field left out.
    Default(&'static str),
}

/// One field of a request: its name, form, unit, range and default.
#[derive(Clone, Copy)]
pub struct Field {
    pub name: &'static str,
    pub kind: Kind,
    pub unit: &'static str,
    pub range: &'static str,
    need: Need,
}

impl Field {
    /// A field that must be given, unless one of the two functions below is called on it.
    pub const fn new(
        name: &'static str,
        kind: Kind,
        unit: &'static str,
        range: &'static str,
    ) -> Self {
        Self {
            name,
            kind,
            unit,
            range,
            need: Need::Required,
        }
    }

    /// A required number.
    pub const fn number(name: &'static str, unit: &'static str, range: &'static str) -> Self {
        Self::new(name, Kind::Number, unit, range)
    }

    /// The same field with a default, written as JSON.
    pub const fn or(mut self, default: &'static str) -> Self {
        self.need = Need::Default(default);
        self
    }

    /// The same field, which may be left out.
    pub const fn optional(mut self) -> Self {
        self.need = Need::Optional;
        self
    }

    pub fn is_required(&self) -> bool {
        matches!(self.need, Need::Required)
    }

    pub fn default(&self) -> Option<&'static str> {
        match self.need {
            Need::Default(text) => Some(text),
            _ => None,
        }
    }

    fn null_means_something(&self) -> bool {
        matches!(self.kind, Kind::OrNull(_))
    }

    /// Whether the request gives this field; a `null` counts as left out unless it has a meaning.
    fn given<'a>(&self, object: &'a Map<String, Value>) -> Option<&'a Value> {
        object
            .get(self.name)
            .filter(|v| !v.is_null() || self.null_means_something())
    }
}

/// A number of a request, with the three strings that stand for what JSON cannot write.
pub fn number_of(value: &Value) -> Option<f64> {
    match value {
        Value::Number(n) => n.as_f64(),
        Value::String(s) => match s.as_str() {
            "nan" => Some(f64::NAN),
            "inf" => Some(f64::INFINITY),
            "-inf" => Some(f64::NEG_INFINITY),
            _ => None,
        },
        _ => None,
    }
}

/// A whole number of a request, exact as far as JSON text holds it (up to 2^64; beyond, the nearest f64).
pub fn integer_of(value: &Value) -> Option<i128> {
    let Value::Number(n) = value else { return None };
    if let Some(i) = n.as_i64() {
        return Some(i.into());
    }
    if let Some(u) = n.as_u64() {
        return Some(u.into());
    }
    let x = n.as_f64()?;
    // Saturates beyond i128, which is beyond every range as well.
    (x.is_finite() && x == x.trunc()).then_some(x as i128)
}

/// Whether every number of a value is finite, also as an `R`.
pub fn all_finite<R: Real>(kind: &Kind, value: &Value) -> bool {
    match (kind, value) {
        (Kind::Number, _) => number_of(value).is_none_or(|x| R::of(x).is_finite()),
        (Kind::List(inner, _), Value::Array(entries)) => {
            entries.iter().all(|entry| all_finite::<R>(inner, entry))
        }
        (Kind::OrNull(inner), _) => all_finite::<R>(inner, value),
        (
            Kind::Object(fields) | Kind::Preset(_, fields) | Kind::Open(_, fields),
            Value::Object(object),
        ) => fields
            .iter()
            .all(|f| f.given(object).is_none_or(|v| all_finite::<R>(&f.kind, v))),
        _ => true,
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Unknown,
    Missing,
    Type,
    Name,
}

/// All checks of one request against the fields of its function.
pub fn check(fields: &[&[Field]], object: &Map<String, Value>) -> Result<(), Fault> {
    for stage in [Stage::Unknown, Stage::Missing, Stage::Type, Stage::Name] {
        check_object(fields, object, stage, "")?;
    }
    Ok(())
}

fn check_object(
    fields: &[&[Field]],
    object: &Map<String, Value>,
    stage: Stage,
    path: &str,
) -> Result<(), Fault> {
    let all = || fields.iter().copied().flatten();
    if stage == Stage::Unknown
        && let Some(name) = object.keys().find(|k| all().all(|f| f.name != **k))
    {
        let known: Vec<_> = all().map(|f| f.name).collect();
        return Err(Fault::new(
            "UnknownField",
            format!(
                "there is no field {path}{name}; the fields are: {}",
                known.join(", ")
            ),
        )
        .field(name));
    }
    for field in all() {
        let path = format!("{path}{}", field.name);
        match field.given(object) {
            Some(value) => check_value(&field.kind, value, stage, field.name, &path)?,
            None if stage == Stage::Missing && field.is_required() => {
                return Err(Fault::new(
                    "MissingField",
                    format!(
                        "{path} is required: {}{}",
                        form(&field.kind),
                        bracketed(field.unit)
                    ),
                )
                .field(field.name));
            }
            None => {}
        }
    }
    Ok(())
}

fn check_value(
    kind: &Kind,
    value: &Value,
    stage: Stage,
    name: &str,
    path: &str,
) -> Result<(), Fault> {
    let typed = |good: bool| {
        if stage == Stage::Type && !good {
            let fault = Fault::new("WrongType", format!("{path} must be {}", form(kind)));
            return Err(fault.field(name));
        }
        Ok(())
    };
    let word = |words: &[&str], s: &str| {
        if stage == Stage::Name && !words.contains(&s) {
            let fault = Fault::new(
                "UnknownName",
                format!("{path} must be one of: {}", words.join(", ")),
            );
            return Err(fault.field(name));
        }
        Ok(())
    };
    match kind {
        Kind::Any => Ok(()),
        Kind::Number => typed(number_of(value).is_some()),
        Kind::Integer => typed(integer_of(value).is_some()),
        Kind::Flag => typed(value.is_boolean()),
        Kind::OrNull(_) if value.is_null() => Ok(()),
        Kind::OrNull(inner) => check_value(inner, value, stage, name, path),
        Kind::Word(words) => match value {
            Value::String(s) => word(words, s),
            _ => typed(false),
        },
        Kind::List(inner, length) => match value {
            Value::Array(entries) => {
                typed(length.allows(entries.len()))?;
                for (i, entry) in entries.iter().enumerate() {
                    check_value(inner, entry, stage, name, &format!("{path}[{i}]"))?;
                }
                Ok(())
            }
            _ => typed(false),
        },
        Kind::Object(fields) => match value {
            Value::Object(object) => check_object(&[fields], object, stage, &format!("{path}.")),
            _ => typed(false),
        },
        Kind::Preset(words, fields) => match value {
            Value::String(s) => word(words, s),
            Value::Object(object) => check_object(&[fields], object, stage, &format!("{path}.")),
            _ => typed(false),
        },
        Kind::Open(words, fields) => match value {
            Value::String(s) => word(words, s),
            Value::Object(object) => {
                for field in *fields {
                    let path = format!("{path}.{}", field.name);
                    match field.given(object) {
                        // Its words are the function's affair, but for the preset.
                        Some(_) if stage == Stage::Name && field.name != "preset" => {}
                        Some(v) => check_value(&field.kind, v, stage, field.name, &path)?,
                        None => {}
                    }
                }
                Ok(())
            }
            _ => typed(false),
        },
    }
}

impl Length {
    fn allows(self, length: usize) -> bool {
        match self {
            Length::Any => true,
            Length::Exactly(n) => length == n,
            Length::Between(lo, hi) => (lo..=hi).contains(&length),
        }
    }
}

/// The form of a kind in words.
pub fn form(kind: &Kind) -> String {
    match kind {
        Kind::Number => "a number".into(),
        Kind::Integer => "a whole number".into(),
        Kind::Flag => "true or false".into(),
        Kind::Word(words) => format!("one of {}", words.join(" | ")),
        Kind::OrNull(inner) => format!("{} or null", form(inner)),
        Kind::Object(_) => "an object".into(),
        Kind::Preset(..) | Kind::Open(..) => "the name of a preset or an object".into(),
        Kind::Any => "as described".into(),
        Kind::List(inner, length) => {
            let count = match length {
                Length::Any => String::new(),
                Length::Exactly(n) => format!("{n} entries, "),
                Length::Between(lo, hi) => format!("{lo} to {hi} entries, "),
            };
            format!("an array ({count}each {})", form(inner))
        }
    }
}

pub fn bracketed(unit: &str) -> String {
    if unit.is_empty() {
        String::new()
    } else {
        format!(" [{unit}]")
    }
}
