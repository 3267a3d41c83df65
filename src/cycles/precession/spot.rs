//! The polishing spot: its radius, and how fast the bonnet rubs in its middle.
//!
//! ```text
//! convex  S:  D = S + Rb - h,   q = h (2 S - h) / 2D,    r^2 = q (2 Rb - q)       q: height of the ball's cap
//! concave S:  D = S - Rb + h,   q = h (2 Rb - h) / 2D,   r^2 = q (2 S - q)        q: height of the hollow's cap
//! ```
//!
//! Both are the usual circle of two spheres, with the cap's height worked out by hand: in f32 the difference of two
//! squares would lose half the digits.

use super::error::{Field, PrecessionError};
use crate::math::Real;

/// The surface around the contact; radii [mm], greater than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface<R> {
    Plane,
    Convex(R),
    Concave(R),
}

/// Radius [mm] of the circle in which the undeformed ball of radius `bonnet_radius`, pressed in by `inward` [mm], cuts the surface.
pub fn contact_radius<R: Real>(
    bonnet_radius: R,
    inward: R,
    surface: Surface<R>,
) -> Result<R, PrecessionError> {
    let (ball, h) = (bonnet_radius, inward);
    check_bonnet(ball, h)?;
    let squared = match surface {
        Surface::Plane => h * (R::TWO * ball - h),
        Surface::Convex(s) => {
            check_finite(s)?;
            if R::TWO * s <= h || s <= R::ZERO {
                return Err(PrecessionError::BonnetTooLarge);
            }
            let cap = h * (R::TWO * s - h) / (R::TWO * (s + ball - h));
            cap * (R::TWO * ball - cap)
        }
        Surface::Concave(s) => {
            check_finite(s)?;
            if s <= ball {
                return Err(PrecessionError::BonnetTooLarge);
            }
            let cap = h * (R::TWO * ball - h) / (R::TWO * (s - ball + h));
            cap * (R::TWO * s - cap)
        }
    };
    Ok(squared.max(R::ZERO).sqrt())
}

/// Speed of the bonnet's skin over the surface in the middle of the spot [mm/s], feed not counted: w1 rho sin theta, for
/// a spin `w1` [rad/s], a distance `rho` [mm] from centre to surface and a tilt `theta` [rad]. Its direction is
/// n x (a cos alpha + b sin alpha).
pub fn rubbing_speed<R: Real>(w1: R, rho: R, theta: R) -> R {
    w1 * rho * theta.sin()
}

pub(super) fn check_bonnet<R: Real>(radius: R, inward: R) -> Result<(), PrecessionError> {
    let good = radius > R::ZERO && inward >= R::ZERO && inward < radius;
    if good {
        Ok(())
    } else {
        Err(PrecessionError::BadBonnet)
    }
}

fn check_finite<R: Real>(radius: R) -> Result<(), PrecessionError> {
    if radius.is_finite() {
        Ok(())
    } else {
        Err(PrecessionError::NonFinite {
            field: Field::SurfaceRadius,
            index: None,
        })
    }
}
