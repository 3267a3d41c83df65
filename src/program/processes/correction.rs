//! `$MIRROR=GAUGE,...`: what a gauge says of the walls of the last run -> what is added to those of the next.

use super::say;
use crate::cycles::mirror_bias::{Bias, BiasError, LEAST_READINGS};
use crate::error::Error;
use crate::program::list::reading;
use crate::program::words::Decimal;
use core::fmt::Write;

/// Largest correction of the wall [mm].
const MOST: f32 = 0.2;
/// A reading farther from the wall that was asked for is none of it [mm].
const GATE: f32 = 0.5;

/// What is added to a wall, run by run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Correction {
    /// Of the run under way or of the last one [mm].
    base: f32,
    /// What the walls that it milled were found to be off by.
    bias: Option<Bias<f32>>,
}

impl Correction {
    /// What is added to the walls of the next run [mm].
    pub fn of_next(&self) -> f32 {
        let learnt = self.bias.and_then(|bias| bias.correction());
        (self.base + learnt.unwrap_or(0.0)).clamp(-MOST, MOST)
    }

    /// A run begins: later readings are of the walls that it mills.
    pub fn begin(&mut self) {
        self.base = self.of_next();
        self.bias = None;
    }

    /// All readings of a line, or none.
    pub fn gauge(&mut self, wall: f32, text: &str, out: &mut dyn Write) -> Result<(), Error> {
        let mut bias = match self.bias {
            Some(bias) => bias,
            None => Bias::new(wall, MOST, GATE).map_err(|_| Error::ValueRange)?,
        };
        for word in text.split(',') {
            let reading = reading(word).ok_or(Error::BadNumber)?;
            bias.take(reading).map_err(|error| {
                let (name, expected) = match error {
                    BiasError::Outlier => ("Outlier", "within 0.5 mm of the wall"),
                    _ => ("NonFinite", "finite numbers"),
                };
                say(out, format_args!("{name} reading: expected {expected}"));
                Error::ValueRange
            })?;
        }
        if bias.is_beyond() {
            say(
                out,
                format_args!(
                    "Beyond: the walls are off by more than {} mm; mend the machine, only so much is corrected",
                    Decimal(MOST)
                ),
            );
        }
        self.bias = Some(bias);
        Ok(())
    }

    pub fn show(&self, out: &mut dyn Write) {
        let readings = self.bias.map_or(0, |bias| bias.readings());
        let _ = write!(out, "[BIAS:{}|{readings}]\r\n", Decimal(self.of_next()));
        if readings < LEAST_READINGS {
            say(
                out,
                format_args!("Learnt from {LEAST_READINGS} readings on, see $MIRROR=GAUGE"),
            );
        }
    }
}
