//! Parameters of a process as words of a line: `D9.9,W1.63` changes two of them, all or nothing.

use super::words::{Decimal, number};
use core::fmt::{self, Write};

/// A parameter: its letter, its name and its default.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    pub letter: char,
    pub name: &'static str,
    pub default: f32,
}

pub(super) const fn word(letter: char, name: &'static str, default: f32) -> Word {
    Word {
        letter,
        name,
        default,
    }
}

/// Why a line of words is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BadWord {
    Unknown(char),
    Repeated(char),
    /// Not a decimal number, nor `NAN`, `INF` or `-INF`, which the process refuses by its own name.
    Number(char),
    /// This count or choice is not a whole number from 0 to `most`.
    NotWhole {
        name: &'static str,
        most: u32,
    },
}

/// A decimal number, or one of those that no process takes.
pub fn reading(text: &str) -> Option<f32> {
    match text {
        "NAN" => Some(f32::NAN),
        "INF" => Some(f32::INFINITY),
        "-INF" => Some(f32::NEG_INFINITY),
        _ => number(text),
    }
}

/// Puts the words of `text` into their places of `values`, which is left as it was if one of them is refused.
pub fn change<const K: usize>(
    table: &[Word; K],
    values: &[f32; K],
    text: &str,
) -> Result<[f32; K], BadWord> {
    let mut changed = *values;
    fill(table, &mut changed, text)?;
    Ok(changed)
}

/// Out of line: one for tables of any length.
fn fill(table: &[Word], changed: &mut [f32], text: &str) -> Result<(), BadWord> {
    let mut seen = 0u32;
    for word in text.split(',') {
        let mut letters = word.chars();
        let letter = letters.next().unwrap_or(' ');
        let at = table
            .iter()
            .position(|w| w.letter == letter)
            .ok_or(BadWord::Unknown(letter))?;
        if seen >> at & 1 != 0 {
            return Err(BadWord::Repeated(letter));
        }
        seen |= 1 << at;
        let value = reading(letters.as_str()).ok_or(BadWord::Number(letter))?;
        if let Some(slot) = changed.get_mut(at) {
            *slot = value;
        }
    }
    Ok(())
}

/// `D9.9,W1.63,...`
pub fn write(table: &[Word], values: &[f32], out: &mut dyn Write) -> fmt::Result {
    for (i, (word, value)) in table.iter().zip(values).enumerate() {
        if i > 0 {
            out.write_char(',')?;
        }
        write!(out, "{}{}", word.letter, Decimal(*value))?;
    }
    Ok(())
}

/// `Name field: what was expected`.
pub fn explain(table: &[Word], bad: BadWord, out: &mut dyn Write) -> fmt::Result {
    match bad {
        BadWord::Unknown(letter) => {
            write!(out, "UnknownField {letter}: expected one of ")?;
            table.iter().try_for_each(|w| out.write_char(w.letter))
        }
        BadWord::Repeated(letter) => write!(out, "RepeatedField {letter}: expected once"),
        BadWord::Number(letter) => write!(out, "BadNumber {letter}: expected a decimal number"),
        BadWord::NotWhole { name, most } => write!(
            out,
            "OutOfRange {name}: expected a whole number from 0 to {most}"
        ),
    }
}

/// `value` as one of the whole numbers 0 ..= `most`.
pub fn whole(value: f32, name: &'static str, most: u32) -> Result<u32, BadWord> {
    let whole = value as u32;
    let is_whole = whole as f32 == value && whole <= most;
    is_whole
        .then_some(whole)
        .ok_or(BadWord::NotWhole { name, most })
}
