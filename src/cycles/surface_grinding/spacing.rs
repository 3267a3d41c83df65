//! The pitch of neighbouring rows that leaves a scallop of the wanted height.
//!
//! ```text
//!        height at y = h0 - H(y) + k_c y (d - y)/2     over the line through the two groove centres
//!
//!    envelope     .^.                additive   .^.   .^.         H = the larger stripe, or their sum
//!       '-.     .'   '.     .-'        '-.    .'   '-'   '.   .-'
//!    y = 0 '---'   d/2 '---'  d           '--'  d-b_c  b_c '-'
//! ```
//!
//! Neglected: arc length against the tool plane's y. Against the exact circle d errs by about -k_c h0/2, below 0.1 %.

use super::{Field, GrindingError, Stripe};
use crate::math::Real;

/// How the stripes of neighbouring rows combine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// The deeper of the two (the paper).
    #[default]
    Envelope,
    /// Their sum, which is what Preston's law says.
    Additive,
}

/// Distance of two rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pitch<R> {
    /// [mm]
    pub d: R,
    /// Held to 2 b_c: the stripes only touch, and the scallop is lower than asked for.
    pub touching: bool,
}

/// The pitch of rows of this stripe on a section of curvature `k_c` [1/mm] that leaves a `scallop` [mm].
pub fn pitch<R: Real>(
    model: Model,
    stripe: Stripe<R>,
    k_c: R,
    scallop: R,
) -> Result<Pitch<R>, GrindingError<R>> {
    let Stripe { b_c, h0 } = stripe;
    for (value, field) in [(b_c, Field::BC), (h0, Field::H0), (scallop, Field::Scallop)] {
        if !(value > R::ZERO && value.is_finite()) {
            return Err(GrindingError::BadParameter(field));
        }
    }
    if !k_c.is_finite() {
        return Err(GrindingError::BadParameter(Field::KC));
    }
    if h0 <= scallop {
        return Err(GrindingError::TooShallow { h0, scallop });
    }
    let widest = R::TWO * b_c;
    let d = match model {
        Model::Envelope => {
            let effective = h0 + k_c * b_c * b_c * R::HALF;
            // So hollow that no cusp stands out of it.
            if effective <= R::ZERO {
                widest
            } else {
                widest * (scallop / effective).sqrt()
            }
        }
        Model::Additive => {
            // With e = d - b_c:  h0 (e/b_c)^2 + k_c b_c e/2 = scallop, and x = e/b_c.
            let bend = k_c * b_c * b_c * R::HALF;
            let root = (bend * bend + R::of(4.0) * h0 * scallop).sqrt();
            // The root of the form that does not cancel.
            let x = if bend > R::ZERO {
                R::TWO * scallop / (bend + root)
            } else {
                (root - bend) / (R::TWO * h0)
            };
            if x < R::of(core::f64::consts::SQRT_2 - 1.0) {
                return Err(GrindingError::AdditiveBranch { h0, scallop });
            }
            b_c * (R::ONE + x)
        }
    };
    if d >= widest {
        return Ok(Pitch {
            d: widest,
            touching: true,
        });
    }
    Ok(Pitch { d, touching: false })
}
