//! The longest chord along a row.
//!
//! ```text
//!   chord     L = 2 sqrt(2 R eps - eps^2)        R of the space curve: normal and in-plane curvature both count
//!   turn      L = (2/|k_n|) sin(turn/2)          of the normal from one point to the next
//!   lateral   L = 2 sqrt(2 R_g e - e^2)          in the plane only: such sag moves the row, and no force control takes it up
//!   l_max
//! ```
//!
//! The same on bulges and hollows. Source: the paper's equations of the constant chord error.

use super::{Field, GrindingError};
use crate::math::Real;

/// What bounds a step [mm, rad].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits<R> {
    /// Distance of chord and curve.
    pub eps: R,
    pub l_max: R,
    /// Turn of the normal.
    pub turn: R,
    /// Distance of chord and curve in the tangent plane; `None` = as large as you like.
    pub e_lat: Option<R>,
}

/// Which limit was the smallest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    LMax,
    Chord,
    Turn,
    Lateral,
}

impl Limit {
    pub const fn name(self) -> &'static str {
        match self {
            Limit::LMax => "l_max",
            Limit::Chord => "chord",
            Limit::Turn => "turn",
            Limit::Lateral => "lateral",
        }
    }
}

/// The longest step [mm], and the first limit that allows no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<R> {
    pub length: R,
    pub limit: Limit,
}

impl<R: Real> StepLimits<R> {
    pub fn check(&self) -> Result<(), GrindingError<R>> {
        for (value, field) in [
            (self.eps, Field::Eps),
            (self.l_max, Field::LMax),
            (self.turn, Field::Turn),
            (self.e_lat.unwrap_or(R::ONE), Field::ELat),
        ] {
            if !(value > R::ZERO && value.is_finite()) {
                return Err(GrindingError::BadParameter(field));
            }
        }
        Ok(())
    }

    /// The step along a curve of normal curvature `k_n` and geodesic (in-plane) curvature `k_g` [1/mm].
    pub fn step(&self, k_n: R, k_g: R) -> Result<Step<R>, GrindingError<R>> {
        self.check()?;
        for (value, field) in [(k_n, Field::KN), (k_g, Field::KG)] {
            if !value.is_finite() {
                return Err(GrindingError::BadParameter(field));
            }
        }
        let mut step = Step {
            length: self.l_max,
            limit: Limit::LMax,
        };
        let mut take = |length: Option<R>, limit| {
            if let Some(length) = length
                && length < step.length
            {
                step = Step { length, limit };
            }
        };
        take(
            chord((k_n * k_n + k_g * k_g).sqrt(), self.eps),
            Limit::Chord,
        );
        // Half a turn of the normal is the whole diameter; no chord is longer.
        let half = (self.turn * R::HALF).min(R::PI * R::HALF);
        take(finite(R::TWO * half.sin() / k_n.abs()), Limit::Turn);
        take(self.e_lat.and_then(|e| chord(k_g.abs(), e)), Limit::Lateral);
        Ok(step)
    }
}

/// The chord that sags by `sag` on a circle of this curvature; `None` if it is straight.
fn chord<R: Real>(curvature: R, sag: R) -> Option<R> {
    let radius = finite(R::ONE / curvature)?;
    if sag >= radius {
        return Some(R::TWO * radius);
    }
    finite(R::TWO * (sag * (R::TWO * radius - sag)).sqrt())
}

fn finite<R: Real>(x: R) -> Option<R> {
    x.is_finite().then_some(x)
}
