//! What the lines of processes have in common: words, numbers of a point, parameters of a machine.

use super::{Order, say};
use crate::error::Error;
use crate::geometry::Vector;
use crate::program::list::{self, Word, reading};
use crate::program::words::Decimal;
use core::fmt::Write;

/// The numbers of a point: place, normal, and more for some.
pub const MOST: usize = 12;

/// A line with a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointLine {
    Row,
    End,
    /// This many numbers are there.
    Numbers([f32; MOST], usize),
}

impl PointLine {
    pub fn read(text: &str) -> Result<Self, Error> {
        match text {
            "ROW" => return Ok(Self::Row),
            "END" => return Ok(Self::End),
            _ => {}
        }
        let mut numbers = [0.0; MOST];
        let mut count = 0;
        for word in text.split(',') {
            *numbers.get_mut(count).ok_or(Error::BadNumber)? =
                reading(word).ok_or(Error::BadNumber)?;
            count += 1;
        }
        if count < 6 {
            return Err(Error::BadNumber);
        }
        Ok(Self::Numbers(numbers, count))
    }
}

/// The vector whose numbers begin at `first`.
pub fn vector(numbers: &[f32; MOST], first: usize) -> Vector<f32> {
    let at = |i: usize| numbers.get(first + i).copied().unwrap_or_default();
    Vector::new(at(0), at(1), at(2))
}

/// Parameters of a process in their table.
#[derive(Clone, Copy, Debug)]
pub struct Given<const K: usize> {
    pub table: &'static [Word; K],
    pub values: [f32; K],
}

impl<const K: usize> Given<K> {
    pub fn new(table: &'static [Word; K]) -> Self {
        Self {
            table,
            values: table.map(|word| word.default),
        }
    }

    /// The line behind the process's name: shows, sets what `check` accepts, or says what is to be done. `check` writes
    /// what it has against the values.
    pub fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
        check: impl Fn(&[f32; K], &mut dyn Write) -> Result<(), Error>,
    ) -> Result<Order, Error> {
        let text = match value {
            None => {
                let _ = write!(out, "[{name}:");
                let _ = list::write(self.table, &self.values, out);
                let _ = out.write_str("]\r\n");
                return Ok(Order::Done);
            }
            Some("STOP") => return Ok(Order::Stop),
            Some(_) if !is_idle => return Err(Error::NotIdle),
            Some("RUN") => return Ok(Order::Run { sim: false }),
            Some("SIM") => return Ok(Order::Run { sim: true }),
            Some(text) => text,
        };
        let changed = list::change(self.table, &self.values, text).map_err(|bad| {
            let _ = out.write_str("[MSG:");
            let _ = list::explain(self.table, bad, out);
            let _ = out.write_str("]\r\n");
            Error::ValueRange
        })?;
        check(&changed, out)?;
        self.values = changed;
        Ok(Order::Done)
    }

    /// A number by its name; NaN, which every check refuses, for a name that is none.
    pub fn get(values: &[f32; K], table: &[Word; K], name: &str) -> f32 {
        let found = table.iter().zip(values).find(|(word, _)| word.name == name);
        found.map_or(f32::NAN, |(_, value)| *value)
    }
}

/// A parameter of the machine: its name, and where its numbers stand.
pub struct Parameter {
    pub name: &'static str,
    pub first: usize,
    pub count: usize,
}

/// Numbers of the machine with their names.
pub struct Numbers<const K: usize> {
    pub table: &'static [Parameter],
    pub values: [f32; K],
}

impl<const K: usize> Numbers<K> {
    /// The values with those of one parameter replaced.
    pub fn with(&self, name: &str, text: &str) -> Result<[f32; K], Error> {
        let parameter = self.table.iter().find(|p| p.name == name);
        let parameter = parameter.ok_or(Error::UnknownCommand)?;
        let mut changed = self.values;
        let mut words = text.split(',');
        let places = changed.get_mut(parameter.first..parameter.first + parameter.count);
        for place in places.unwrap_or_default() {
            *place = words.next().and_then(reading).ok_or(Error::BadNumber)?;
        }
        match words.next() {
            None => Ok(changed),
            Some(_) => Err(Error::BadNumber),
        }
    }

    /// `TOOL=160|WORK=0,350,250`
    pub fn write(&self, out: &mut dyn Write) {
        for parameter in self.table {
            let _ = write!(out, "|{}=", parameter.name);
            let values = self.values.iter().skip(parameter.first);
            for (i, value) in values.take(parameter.count).enumerate() {
                let comma = if i == 0 { "" } else { "," };
                let _ = write!(out, "{comma}{}", Decimal(*value));
            }
        }
    }
}

pub(super) fn bad_choice(name: &str, out: &mut dyn Write) -> Error {
    say(
        out,
        format_args!("OutOfRange {name}: expected the number of one of its choices, from 0 on"),
    );
    Error::ValueRange
}

/// How far a tool is drawn back, and how fast it comes.
pub(super) fn check_clear(clear: f32, plunge: f32, out: &mut dyn Write) -> Result<(), Error> {
    if (0.0..=1000.0).contains(&clear) && plunge > 0.0 && plunge.is_finite() {
        return Ok(());
    }
    say(
        out,
        format_args!("OutOfRange clear: expected 0 to 1000 mm, at a speed above 0 mm/s"),
    );
    Err(Error::ValueRange)
}

pub(super) const fn parameter(name: &'static str, first: usize, count: usize) -> Parameter {
    Parameter { name, first, count }
}
