//! Gauge readings of walls that are done -> what to add to the wall of the next pass.
//!
//! ```text
//! reading -> [ finite? ] -> [ within the gate of the wanted wall? ] -> mean     correction = wanted - mean, +-most
//!                `- NonFinite            `- Outlier                                 from the third reading on
//! ```
//!
//! A wrong tool length, support zero or calibration between the two work frames shifts all walls alike, and no trim along
//! the measured deformation can see it: the paper's trimmed walls spread by 0.012 mm and all lie 0.055 mm too thin, an rms
//! error of 0.056 mm, next to the 0.058 mm without trimming. What their mean is off by is known once some walls are gauged.
//!
//! Contract: lengths in mm; the state is a few numbers, whatever the count of readings; nothing moves by it but what the
//! caller adds to the wall it asks of [`Pair::solve`].
//!
//! Source: specification of mirror milling, section 11. The paper (Liu et al., 2024) has the readings and no correction.
//!
//! [`Pair::solve`]: crate::machines::two_sided::Pair::solve

use crate::math::Real;

/// Readings before there is a correction.
pub const LEAST_READINGS: u32 = 3;

/// Why a reading, or a bias as a whole, is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BiasError {
    /// The wanted wall is not a number above 0.
    BadWall,
    /// A bound is not a number above 0; its name.
    BadLimit(&'static str),
    /// The reading is not finite.
    NonFinite,
    /// The reading is farther from the wanted wall than the gate: a slip of the gauge, or another fault than a bias.
    Outlier,
}

/// What walls are found to be off by, on the average.
///
/// ```
/// use hexstep::cycles::mirror_bias::Bias;
///
/// let mut bias = Bias::<f32>::new(1.5, 0.1, 0.2).unwrap();
/// for reading in [1.44, 1.45, 1.46] {
///     bias.take(reading).unwrap();
/// }
/// assert!((bias.correction().unwrap() - 0.05).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bias<R> {
    wanted: R,
    most: R,
    gate: R,
    /// Of the readings less the wanted wall: small numbers, which keep their digits in `f32`.
    mean: R,
    /// What rounding dropped from it.
    dropped: R,
    readings: u32,
}

impl<R: Real> Bias<R> {
    /// For walls that should be `wanted`; a correction is at most `most` either way, a reading at most `gate` off [mm].
    pub fn new(wanted: R, most: R, gate: R) -> Result<Self, BiasError> {
        let is_good = |x: R| x.is_finite() && x > R::ZERO;
        if !is_good(wanted) {
            return Err(BiasError::BadWall);
        }
        if let Some((name, _)) = [("most", most), ("gate", gate)]
            .into_iter()
            .find(|(_, x)| !is_good(*x))
        {
            return Err(BiasError::BadLimit(name));
        }
        Ok(Self {
            wanted,
            most,
            gate,
            mean: R::ZERO,
            dropped: R::ZERO,
            readings: 0,
        })
    }

    /// Takes in a reading of the gauge [mm]. A refused one changes nothing.
    pub fn take(&mut self, reading: R) -> Result<(), BiasError> {
        if !reading.is_finite() {
            return Err(BiasError::NonFinite);
        }
        let off = reading - self.wanted;
        if off.abs() > self.gate {
            return Err(BiasError::Outlier);
        }
        // Beyond so many readings each weighs as much as the last that was counted.
        const MOST_READINGS: u32 = i32::MAX as u32;
        self.readings = self.readings.saturating_add(1).min(MOST_READINGS);
        let share = R::ONE / R::of_i32(self.readings as i32);
        let change = (off - self.mean) * share + self.dropped;
        let mean = self.mean + change;
        self.dropped = change - (mean - self.mean);
        self.mean = mean;
        Ok(())
    }

    /// What to add to the wall of the next pass [mm]; `None` before [`LEAST_READINGS`].
    pub fn correction(&self) -> Option<R> {
        (self.readings >= LEAST_READINGS).then(|| (-self.mean).clamp(-self.most, self.most))
    }

    /// Whether the walls are off by more than a correction may be: then something is broken that should be mended.
    pub fn is_beyond(&self) -> bool {
        self.readings >= LEAST_READINGS && self.mean.abs() > self.most
    }

    /// Readings taken in.
    pub fn readings(&self) -> u32 {
        self.readings
    }
}
