//! The direction part: a tool direction into the angles of both rotary axes, both solutions at once.
//!
//! ```text
//!   Rot(m1, phi1) Rot(m2, phi2) v1 = v          m1 next to the work, m2 next to the tool
//!
//!            m1            Turning v1 about m2 draws one cone, turning v about m1 another; they meet in
//!            |  v          none, one or two directions c (or in all, when both shrink to m1):
//!            | /
//!            |/____ m2     c = A1 m1 + (K2/sd) e1 +- (S/sd) e2
//! ```
//!
//! This is Paden and Kahan's second subproblem, written without the difference of near-equal squares: close to the
//! pole of axis 1, where most programs run, the textbook form is wrong by 2e-2 deg in f32, this one by 4e-5 deg.
//! `S` is the Jacobian determinant of the map from angles to direction: joint speed ~ tilt speed / S.
//!
//! Cost: two square roots and three arctangents for both solutions.
//! Source: Duan, Lin, Zheng, Sun 2014, eq. (4) for the equation; the closed form replaces their elimination.

use super::definition::rounded;
use super::travel::wrap;
use super::{Class, Error};
use crate::geometry::{Rotation, Vector};
use crate::math::Real;

/// Directions missing the reachable band by no more than this are taken as its border: 1e-3 deg [rad].
pub const SNAP: f64 = 1e-3 * core::f64::consts::PI / 180.0;
/// Closer to the pole than this, axis 1 has no influence: [rad].
pub const SING: f64 = 1e-5;

/// How many solutions a direction has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Two,
    /// On the border of the reachable band.
    One,
    /// At the pole: axis 1 of the solver may stand anywhere and is held.
    Infinite,
    /// Out of reach: the angles are those of the nearest direction.
    None,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Two => "two",
            Self::One => "one",
            Self::Infinite => "infinite",
            Self::None => "none",
        }
    }
}

/// All solutions of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branches<R> {
    pub kind: Kind,
    /// What the direction misses the reachable band by [rad]; 0 inside.
    pub gap: R,
    /// Conditioning number S; 0 unless the kind is two or one.
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
    /// In the work frame, so that a direction needs no turning first.
    m1: Vector<R>,
    e1: Vector<R>,
    e2: Vector<R>,
    /// m1 . m2 and |m1 x m2|.
    d: R,
    sd: R,
    /// v1 . m2
    a2: R,
    /// A2 - d and A2 + d, from the differences of the vectors: exact where the tool stands along m1.
    c_plus: R,
    c_minus: R,
    psi: R,
    /// The reachable band of tilts from m1 [rad].
    pub lo: R,
    pub hi: R,
    has_pole: bool,
    has_far_pole: bool,
    /// |cos| and sin of the angle between v1 and m2.
    pub rho2: [R; 2],
    /// Below this S the two solutions are one.
    one: R,
    class: Class,
}

impl<R: Real> Direction<R> {
    /// `n1`, `n2`, `v1` unit vectors in the base frame; `to_work` turns a base vector into the work frame. In f64 and
    /// rounded once: in f32 the roundings of `d`, `sd` and `psi` would add up to half of what is allowed.
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
        let across = m1.cross(m2);
        let least = 1e-3;
        let e2 = across.unit(least).ok_or(Error::ParallelAxes)?;
        let sin_rho2 = m2.cross(v1).norm();
        if sin_rho2 < least {
            return Err(Error::ToolAlongAxis);
        }
        let (d, sd) = (m1.dot(m2), across.norm());
        let e1 = e2.cross(m1);
        let f1 = (m1 - m2 * d) * (1.0 / sd);
        let a2 = v1.dot(m2);
        let rho2 = Real::atan2(sin_rho2, a2);
        let delta = Real::atan2(sd, d);
        let lo = Real::abs(rho2 - delta);
        let hi = f64::PI - Real::abs(f64::PI - rho2 - delta);
        let is_double = R::EPSILON < R::of(1e-10);
        Ok(Self {
            m1: rounded(to_work * m1),
            e1: rounded(to_work * e1),
            e2: rounded(to_work * e2),
            d: R::of(d),
            sd: R::of(sd),
            a2: R::of(a2),
            c_plus: R::of((v1 - m1).dot(m2)),
            c_minus: R::of((v1 + m1).dot(m2)),
            psi: R::of(Real::atan2(-v1.dot(e2), v1.dot(f1))),
            lo: R::of(lo),
            hi: R::of(hi),
            has_pole: lo <= SNAP,
            has_far_pole: f64::PI - hi <= SNAP,
            rho2: [R::of(Real::abs(a2)), R::of(sin_rho2)],
            // S is the root of a difference that is good to one rounding.
            one: R::of(if is_double { 1e-9 } else { 1e-6 }),
            class,
        })
    }

    /// The axis of the solver next to the work, in the work frame.
    pub fn m1(&self) -> Vector<R> {
        self.m1
    }

    /// Which of [primary, secondary] is axis 1 of the solver, the one that a pole leaves free: 0 or 1.
    pub fn free(&self) -> usize {
        match self.class {
            Class::Head | Class::Mixed => 0,
            Class::Table => 1,
        }
    }

    /// Angles of the solver's axes as [primary, secondary].
    fn joints(&self, phi1: R, phi2: R) -> [R; 2] {
        match self.class {
            Class::Head => [wrap(phi1), wrap(phi2)],
            Class::Table => [wrap(-phi2), wrap(-phi1)],
            Class::Mixed => [wrap(-phi1), wrap(phi2)],
        }
    }

    /// Both solutions for the unit direction `v` in the work frame; `held` [rad] is where the free axis stays at a pole.
    pub fn solve(&self, v: Vector<R>, held: R) -> Branches<R> {
        let (vx, vy, a1) = (v.dot(self.e1), v.dot(self.e2), v.dot(self.m1));
        let flat = vx * vx + vy * vy;
        let s1 = flat.sqrt();
        let tilt = [a1.abs(), s1];
        let is_up = a1 >= R::ZERO;

        if s1 <= R::of(SING)
            && if is_up {
                self.has_pole
            } else {
                self.has_far_pole
            }
        {
            let phi2 = if is_up { R::ZERO } else { R::PI } - self.psi;
            let mut angles = self.joints(R::ZERO, phi2);
            if let Some(free) = angles.get_mut(self.free()) {
                *free = held;
            }
            return Branches {
                kind: Kind::Infinite,
                gap: R::ZERO,
                s: R::ZERO,
                angles: [angles; 2],
                tilt,
            };
        }

        let az = vy.atan2(vx);
        let k2 = self.k2(a1, flat);
        let squared = (s1 * self.sd - k2) * (s1 * self.sd + k2);
        if squared > R::ZERO {
            let s = squared.sqrt();
            if s > self.one {
                let k1 = a1 - self.d * self.a2;
                let (g1, g2) = (s.atan2(k2), s.atan2(k1));
                return Branches {
                    kind: Kind::Two,
                    gap: R::ZERO,
                    s,
                    angles: [
                        self.joints(wrap(az - g1), wrap(-g2 - self.psi)),
                        self.joints(wrap(az + g1), wrap(g2 - self.psi)),
                    ],
                    tilt,
                };
            }
        }
        // Only on or outside the border does the gap need the tilt itself.
        let rho1 = s1.atan2(a1);
        let gap = (self.lo - rho1).max(rho1 - self.hi).max(R::ZERO);
        let (s1, a1, k2) = if gap > R::ZERO {
            let (s1, a1) = rho1.clamp(self.lo, self.hi).sin_cos();
            (s1, a1, self.k2(a1, s1 * s1))
        } else {
            (s1, a1, k2)
        };
        let k1 = a1 - self.d * self.a2;
        let (g1, g2) = (R::ZERO.atan2(k2), R::ZERO.atan2(k1));
        let mut angles = self.joints(wrap(az - g1), wrap(-g2 - self.psi));
        if s1 <= R::of(SING)
            && let Some(free) = angles.get_mut(self.free())
        {
            *free = held;
        }
        Branches {
            kind: if gap > R::of(SNAP) {
                Kind::None
            } else {
                Kind::One
            },
            gap,
            s: R::ZERO,
            angles: [angles; 2],
            tilt,
        }
    }

    /// A2 - d A1, without cancellation near both poles. `flat` = 1 - A1^2.
    fn k2(&self, a1: R, flat: R) -> R {
        if a1 >= R::ZERO {
            self.c_plus + self.d * flat / (R::ONE + a1)
        } else {
            self.c_minus - self.d * flat / (R::ONE - a1)
        }
    }
}
