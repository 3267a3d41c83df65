//! Stock -> passes: the stand-off of every stroke.
//!
//! The axial stock S on the lip is an infeed E = S sin phi0 along the lip's normal. Roughing passes of equal depth
//! come first, then finishing passes, then spark-out strokes at stand-off 0.

use super::error::{DrillPointError, Field, check, within};
use crate::math::Real;

/// The most passes of one kind; more is taken for a mistake in a depth.
pub const MAX_STROKES: u32 = 10_000;

/// How the stock is to be taken. Depths are typical of tool grinding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passes<R> {
    /// S, along the drill [mm], greater than 0.
    pub stock: R,
    /// Largest depth of a roughing pass, along the lip's normal [mm], greater than 0.
    pub rough_depth: R,
    /// Depth of a finishing pass [mm], greater than 0.
    pub finish_depth: R,
    pub finish_passes: u32,
    /// Strokes without infeed at the end.
    pub spark_out: u32,
}

/// The passes as planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassPlan<R> {
    /// E [mm].
    pub infeed: R,
    pub rough_passes: u32,
    /// [mm]; 0 without roughing passes.
    pub rough_depth: R,
    pub finish_passes: u32,
    /// [mm]
    pub finish_depth: R,
    pub spark_out: u32,
}

impl<R: Real> Passes<R> {
    /// `stock` [mm] taken with the usual depths: 0.03 mm roughing, three times 0.01 mm finishing, two spark-outs.
    pub fn of(stock: R) -> Self {
        Self {
            stock,
            rough_depth: R::of(0.03),
            finish_depth: R::of(0.01),
            finish_passes: 3,
            spark_out: 2,
        }
    }

    /// The plan for a drill of this point angle [rad].
    pub fn plan(&self, point_angle: R) -> Result<PassPlan<R>, DrillPointError<R>> {
        check(
            &[
                (Field::Stock, self.stock),
                (Field::PointAngle, point_angle),
                (Field::RoughDepth, self.rough_depth),
                (Field::FinishDepth, self.finish_depth),
            ],
            &[
                (Field::PointAngle, within(point_angle, R::PI)),
                (Field::Stock, self.stock > R::ZERO),
                (Field::RoughDepth, self.rough_depth > R::ZERO),
                (Field::FinishDepth, self.finish_depth > R::ZERO),
                (Field::FinishPasses, self.finish_passes <= MAX_STROKES),
                (Field::SparkOut, self.spark_out <= MAX_STROKES),
            ],
        )?;

        let infeed = self.stock * (point_angle * R::HALF).sin();
        let finish = self.finish_depth * R::of_i32(self.finish_passes as i32);
        let rough = infeed - finish;
        // Rounding alone is no reason for a pass of no depth.
        if rough > infeed * R::EPSILON * R::of(16.0) {
            let count = count(rough, self.rough_depth, Field::RoughDepth)?;
            Ok(PassPlan {
                infeed,
                rough_passes: count,
                rough_depth: rough / R::of_i32(count as i32),
                finish_passes: self.finish_passes,
                finish_depth: self.finish_depth,
                spark_out: self.spark_out,
            })
        } else {
            let count = count(infeed, self.finish_depth, Field::FinishDepth)?;
            Ok(PassPlan {
                infeed,
                rough_passes: 0,
                rough_depth: R::ZERO,
                finish_passes: count,
                finish_depth: infeed / R::of_i32(count as i32),
                spark_out: self.spark_out,
            })
        }
    }
}

/// How many passes of at most `depth` take `total`: rounded up, but not by a rounding error.
fn count<R: Real>(total: R, depth: R, field: Field) -> Result<u32, DrillPointError<R>> {
    let ratio = total / depth;
    let passes = (ratio - ratio * R::EPSILON * R::of(16.0))
        .ceil()
        .max(R::ONE);
    if passes <= R::of(MAX_STROKES.into()) {
        // At most MAX_STROKES, at least 1.
        Ok(passes.to_i32() as u32)
    } else {
        Err(DrillPointError::OutOfRange(field))
    }
}

impl<R: Real> PassPlan<R> {
    /// Strokes on each flank.
    pub fn strokes(&self) -> u32 {
        // Three counts of at most MAX_STROKES each.
        self.rough_passes + self.finish_passes + self.spark_out
    }

    /// Stand-off of stroke `i`, from 0, after its infeed [mm]; 0 from the last finishing pass on.
    pub fn standoff(&self, i: u32) -> R {
        let times = |n: u32, depth: R| R::of_i32(n as i32) * depth;
        let done = i.saturating_add(1);
        match self.rough_passes.checked_sub(done) {
            Some(left) => {
                times(left, self.rough_depth) + times(self.finish_passes, self.finish_depth)
            }
            None => {
                let done = done - self.rough_passes;
                times(self.finish_passes.saturating_sub(done), self.finish_depth)
            }
        }
    }

    /// The stand-offs of all strokes in turn [mm].
    pub fn standoffs(self) -> impl Iterator<Item = R> + Clone {
        (0..self.strokes()).map(move |i| self.standoff(i))
    }
}
