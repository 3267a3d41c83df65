//! Words of `$DRILL=` -> a checked grinding cycle.
//!
//! Lengths in mm, angles in degrees, here and nowhere below. A word changes one parameter; the line takes effect only if
//! the drill can be ground with all of them.

use super::list::{self, BadWord, Word, word};
use super::words::Decimal;
use crate::cycles::drill_point::{Cycle, Drill, DrillPointError, Parameters, Passes, Variant};
use crate::machines::drill_grinder::{DrillGrinder, StructureError};
use core::fmt;

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
    Word(BadWord),
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
        list::change(&WORDS, &self.0, text)
            .map(Self)
            .map_err(Refusal::Word)
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
        let count = |value, name| list::whole(value, name, 10_000).map_err(Refusal::Word);
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
        list::write(&WORDS, &self.0, f)
    }
}

/// `Name field: what was expected`.
impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Word(bad) => list::explain(&WORDS, *bad, f),
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
