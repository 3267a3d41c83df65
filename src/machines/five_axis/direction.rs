//! The direction part: a tool direction into the angles of both rotary axes, both solutions at once.
//!
//! The closed form is that of [`RotaryPair`]; this says which of its axes is which of the machine's:
//!
//! | class | m1, next to the work | m2, next to the tool | primary, secondary |
//! |---|---|---|---|
//! | head | n1 | n2 | phi1, phi2 |
//! | table | n2 | n1 | -phi2, -phi1 |
//! | mixed | n1 | n2 | -phi1, phi2 |

use super::travel::wrap;
use super::{Class, Error};
use crate::geometry::{Rotation, Vector};
use crate::machines::rotary_pair::{AxesError, RotaryPair};
use crate::math::Real;

pub use crate::machines::rotary_pair::{Kind, SING, SNAP};

/// All solutions of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branches<R> {
    pub kind: Kind,
    /// What the direction misses the reachable band by [rad]; 0 inside.
    pub gap: R,
    /// Conditioning number S; 0 unless the kind is two.
    pub s: R,
    /// [primary, secondary] in (-pi, pi] [rad], solution 1 first. Unless the kind is two, both are the same.
    pub angles: [[R; 2]; 2],
    /// |m1 . v| and |m1 x v| of the direction asked for: what the error bound needs.
    pub(super) tilt: [R; 2],
}

impl<R> Branches<R> {
    /// The different solutions: two, or one.
    pub fn solutions(&self) -> &[[R; 2]] {
        match self.kind {
            Kind::Two => &self.angles,
            _ => self.angles.first_chunk::<1>().map_or(&[], |one| one),
        }
    }
}

/// The constants of a machine's direction part, computed once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Direction<R> {
    pair: RotaryPair<R>,
    /// |cos| and sin of the angle between v1 and m2.
    pub rho2: [R; 2],
    class: Class,
}

impl<R: Real> Direction<R> {
    /// `n1`, `n2`, `v1` unit vectors in the base frame; `to_work` turns a base vector into the work frame.
    pub fn new(
        class: Class,
        n1: Vector<f64>,
        n2: Vector<f64>,
        v1: Vector<f64>,
        to_work: Rotation<f64>,
    ) -> Result<Self, Error<R>> {
        let (m1, m2) = match class {
            Class::Head | Class::Mixed => (n1, n2),
            Class::Table => (n2, n1),
        };
        let pair = RotaryPair::new(m1, m2, v1, to_work).map_err(|error| match error {
            AxesError::ParallelAxes => Error::ParallelAxes,
            AxesError::ToolAlongAxis => Error::ToolAlongAxis,
        })?;
        Ok(Self {
            pair,
            rho2: [R::of(Real::abs(v1.dot(m2))), R::of(m2.cross(v1).norm())],
            class,
        })
    }

    /// The axis of the solver next to the work, in the work frame.
    pub fn m1(&self) -> Vector<R> {
        self.pair.m1()
    }

    /// The reachable band of tilts from m1 [rad].
    pub fn band(&self) -> [R; 2] {
        self.pair.band()
    }

    /// Which of [primary, secondary] is axis 1 of the solver, the one that a pole leaves free: 0 or 1.
    pub fn free(&self) -> usize {
        match self.class {
            Class::Head | Class::Mixed => 0,
            Class::Table => 1,
        }
    }

    /// Angles of the solver's axes as [primary, secondary].
    fn joints(&self, [phi1, phi2]: [R; 2]) -> [R; 2] {
        match self.class {
            Class::Head => [phi1, phi2],
            Class::Table => [wrap(-phi2), wrap(-phi1)],
            Class::Mixed => [wrap(-phi1), phi2],
        }
    }

    /// Both solutions for the unit direction `v` in the work frame; `held` [rad] is where the free axis stays at a pole.
    pub fn solve(&self, v: Vector<R>, held: R) -> Branches<R> {
        let phi1 = match self.class {
            Class::Head => held,
            Class::Table | Class::Mixed => -held,
        };
        let found = self.pair.solve(v, phi1);
        let [first, second] = found.phi;
        Branches {
            kind: found.kind,
            gap: found.gap,
            s: found.s,
            angles: [self.joints(first), self.joints(second)],
            tilt: found.tilt,
        }
    }
}
