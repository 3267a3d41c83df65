//! Wanted tool axis -> angles of the rotaries of one side, in closed form.
//!
//! ```text
//! list the rotaries from the work towards the tool; phi_i = k_i theta_i, k = -1 on the work chain, +1 on the tool chain
//!
//!   two:   Rot(m1, phi1) Rot(m2, phi2) u = v
//!   one:   Rot(w, phi) u = v, in the least-angle sense; the angle that is left is the residual
//!   none:  residual = angle(u, v)
//! ```
//!
//! Two rotaries are those of [`RotaryPair`], which has the closed form.
//!
//! Source: specification of mirror milling, section 4.

use crate::geometry::{Rotation, Vector};
use crate::kinematics::principal;
use crate::machines::rotary_pair::{LEAST_SINE, RotaryPair};
use crate::math::Real;

pub use crate::machines::rotary_pair::{AxesError, Kind, SNAP};

/// Angles `[phi1, phi2]` [rad] in (-pi, pi] of up to two solutions (of one rotary: phi1; of none: zeros).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction<R> {
    pub kind: Kind,
    /// Angle from the wanted direction to the reachable ones [rad]; with fewer than two rotaries the residual.
    pub gap: R,
    /// Jacobian determinant of the direction map (conditioning), 0 unless the kind is two; `None` with fewer than two
    /// rotaries.
    pub s: Option<R>,
    pub first: [R; 2],
    /// The other solution, of kind two only.
    pub second: Option<[R; 2]>,
}

/// The rotaries of a side, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heading<R> {
    None { u: Vector<R> },
    One(OneRotary<R>),
    Two(RotaryPair<R>),
}

impl<R: Real> Heading<R> {
    /// Two rotaries: axis next to the work, axis next to the tool, tool axis, all at home and of any length.
    pub fn two(m1: Vector<R>, m2: Vector<R>, u: Vector<R>) -> Result<Self, AxesError> {
        // Computed in f64, with lengths put right: in f32 they are off by a rounding.
        let fine = |v: Vector<R>| {
            let v = Vector::from_array(v.to_array().map(R::to_f64));
            v.unit(LEAST_SINE).unwrap_or(v)
        };
        RotaryPair::new(fine(m1), fine(m2), fine(u), Rotation::IDENTITY).map(Self::Two)
    }

    /// The answer for the unit direction `v`; `held` [rad]: the angle phi1 kept where any would serve.
    pub fn solve(&self, v: Vector<R>, held: R) -> Direction<R> {
        match self {
            Self::None { u } => Direction {
                kind: Kind::One,
                gap: u.angle_to(v),
                s: None,
                first: [R::ZERO; 2],
                second: None,
            },
            Self::One(axis) => axis.solve(v, held),
            Self::Two(axes) => {
                let found = axes.solve(v, principal(held));
                let [first, second] = found.phi;
                Direction {
                    kind: found.kind,
                    gap: found.gap,
                    s: Some(found.s),
                    first,
                    second: (found.kind == Kind::Two).then_some(second),
                }
            }
        }
    }
}

/// One rotary: it can bring the tool axis into the half plane of `w` and `v`, not to another tilt from `w`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneRotary<R> {
    w: Vector<R>,
    /// Part of u across w.
    across: Vector<R>,
    /// w x that part: the second direction of the plane that the tool axis turns in.
    ahead: Vector<R>,
    /// angle(u, w) [rad].
    tilt: R,
}

impl<R: Real> OneRotary<R> {
    /// Unit vectors: rotary axis and tool axis at home.
    pub fn new(w: Vector<R>, u: Vector<R>) -> Result<Self, AxesError> {
        let across = u - w * u.dot(w);
        if across.norm() < R::of(LEAST_SINE) {
            return Err(AxesError::ToolAlongAxis);
        }
        Ok(Self {
            w,
            across,
            ahead: w.cross(across),
            tilt: u.angle_to(w),
        })
    }

    fn solve(&self, v: Vector<R>, held: R) -> Direction<R> {
        let along = v.dot(self.w);
        let across = v - self.w * along;
        let sine = across.norm();
        let (kind, phi) = if sine < R::of(1e-6) {
            (Kind::Infinite, principal(held))
        } else {
            // w.(u' x v') is v' on w x u'.
            let phi = self.ahead.dot(across).atan2(self.across.dot(across));
            (Kind::One, principal(phi))
        };
        Direction {
            kind,
            gap: (sine.atan2(along) - self.tilt).abs(),
            s: None,
            first: [phi, R::ZERO],
            second: None,
        }
    }
}
