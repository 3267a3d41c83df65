//! Words of `$DRILL=` -> a checked grinding cycle.
//!
//! Lengths in mm, angles in degrees, here and nowhere below. A word changes one parameter; the line takes effect only if
//! the drill can be ground with all of them.

use super::words::{Decimal, number};
use crate::cycles::drill_point::{Cycle, Drill, DrillPointError, Parameters, Passes, Variant};
use crate::machines::drill_grinder::{DrillGrinder, StructureError};
use crate::math::Real;
use core::fmt::{self, Write};

/// A parameter: its letter, its name and its default, which is the first example of Li & Chen.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    pub letter: char,
    pub name: &'static str,
    pub default: f32,
}

const fn word(letter: char, name: &'static str, default: f32) -> Word {
    Word {
        letter,
        name,
        default,
    }
}

/// All words, in the order in which they are shown.
pub const WORDS: [Word; 19] = [
    word('D', "diameter", 9.9),
    word('W', "web", 1.63),
    word('P', "point_angle", 118.0),
    word('C', "chisel_angle", 50.0),
    word('R', "clearance", 10.0),
    word('F', "phi", 30.0),
    word('S', "stock", 0.3),
    word('A', "rough_depth", 0.03),
    word('B', "finish_depth", 0.01),
    word('N', "finish_passes", 3.0),
    word('K', "spark_out", 2.0),
    word('E', "clear", 3.0),
    word('O', "over", 2.0),
    word('H', "heel_angle", 60.0),
    word('Q', "mu_step", 0.8),
    word('V', "stroke_speed", 20.0),
    word('I', "infeed_speed", 2.0),
    word('L', "l1", 150.0),
    word('M', "l2", 40.0),
];

/// Why a line of words is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    UnknownWord(char),
    RepeatedWord(char),
    BadNumber(char),
    /// This count is not a whole number from 0 to 10000.
    NotWhole(&'static str),
    Drill(DrillPointError<f32>),
    Structure(StructureError),
}

/// The drill parameters as they stand, in mm and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillWords([f32; WORDS.len()]);

impl Default for DrillWords {
    fn default() -> Self {
        Self(WORDS.map(|w| w.default))
    }
}

impl DrillWords {
    /// These parameters with those of `text` (`D9.9,W1.63`) in their place. Nothing is checked but the words.
    pub fn with(&self, text: &str) -> Result<Self, Refusal> {
        let mut changed = *self;
        let mut seen = 0u32;
        for word in text.split(',') {
            let mut letters = word.chars();
            let letter = letters.next().unwrap_or(' ');
            let at = WORDS
                .iter()
                .position(|w| w.letter == letter)
                .ok_or(Refusal::UnknownWord(letter))?;
            if seen >> at & 1 != 0 {
                return Err(Refusal::RepeatedWord(letter));
            }
            seen |= 1 << at;
            let value = number(letters.as_str()).ok_or(Refusal::BadNumber(letter))?;
            if let Some(slot) = changed.0.get_mut(at) {
                *slot = value;
            }
        }
        Ok(changed)
    }

    /// The value of a word by its name; 0 for a name that is none.
    pub fn get(&self, name: &str) -> f32 {
        WORDS
            .iter()
            .zip(&self.0)
            .find(|(w, _)| w.name == name)
            .map_or(0.0, |(_, value)| *value)
    }

    /// The cycle and the arm that it is for; fails if the drill cannot be ground.
    pub fn build(&self) -> Result<(Cycle<f32>, DrillGrinder<f32>), Refusal> {
        let [d, w, p, c, r, f, s, a, b, n, k, e, o, h, q, v, i, l, m] = self.0;
        let count = |value: f32, name| {
            let whole = (0.0..=10_000.0).contains(&value) && value == Real::floor(value);
            whole.then_some(value as u32).ok_or(Refusal::NotWhole(name))
        };
        let drill = Drill {
            diameter: d,
            web: w,
            point_angle: p.to_radians(),
            chisel_angle: c.to_radians(),
            clearance: r.to_radians(),
        };
        // The drill's own checks come first: their order is that of the specification.
        drill.solve(f.to_radians()).map_err(Refusal::Drill)?;
        let machine = DrillGrinder::new(drill.point_angle, l, m).map_err(Refusal::Structure)?;
        let parameters = Parameters {
            drill,
            phi: f.to_radians(),
            touch: machine.home_tip(),
            passes: Passes {
                stock: s,
                rough_depth: a,
                finish_depth: b,
                finish_passes: count(n, "finish_passes")?,
                spark_out: count(k, "spark_out")?,
            },
            clear: e,
            over: o.to_radians(),
            heel_angle: h.to_radians(),
            mu_step: q.to_radians(),
            stroke_speed: v.to_radians(),
            infeed_speed: i,
            variant: Variant::Exact,
        };
        let cycle = Cycle::new(&parameters).map_err(Refusal::Drill)?;
        Ok((cycle, machine))
    }
}

/// `D9.9,W1.63,...`
impl fmt::Display for DrillWords {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (word, value)) in WORDS.iter().zip(&self.0).enumerate() {
            if i > 0 {
                f.write_char(',')?;
            }
            write!(f, "{}{}", word.letter, Decimal(*value))?;
        }
        Ok(())
    }
}

/// `Name field: what was expected`.
impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::UnknownWord(letter) => {
                write!(f, "UnknownField {letter}: expected one of ")?;
                WORDS.iter().try_for_each(|w| f.write_char(w.letter))
            }
            Refusal::RepeatedWord(letter) => write!(f, "RepeatedField {letter}: expected once"),
            Refusal::BadNumber(letter) => {
                write!(f, "BadNumber {letter}: expected a decimal number")
            }
            Refusal::NotWhole(name) => write!(
                f,
                "OutOfRange {name}: expected a whole number from 0 to 10000"
            ),
            Refusal::Drill(error) => {
                write!(f, "{}", error.name())?;
                if let Some(field) = error.field() {
                    write!(f, " {}", field.name())?;
                }
                match error {
                    DrillPointError::ClearanceTooSmall { least } => {
                        write!(f, " least {} deg", Decimal(least.to_degrees()))?
                    }
                    DrillPointError::PhiTooSmall { phi_min } => {
                        write!(f, " phi_min {} deg", Decimal(phi_min.to_degrees()))?
                    }
                    _ => {}
                }
                write!(f, ": {}", error.remedy())
            }
            Refusal::Structure(StructureError::NotFinite(name)) => {
                write!(f, "NotFinite {name}: expected a finite number")
            }
            Refusal::Structure(StructureError::OutOfRange(name)) => {
                write!(f, "OutOfRange {name}: expected a length of at least 0 mm")
            }
        }
    }
}
