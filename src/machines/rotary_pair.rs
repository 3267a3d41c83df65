//! Two rotary axes in series: a wanted direction of the tool -> both angles, both solutions at once.
//!
//! ```text
//!   Rot(m1, phi1) Rot(m2, phi2) u = v           m1 next to the work, m2 next to the tool
//!
//!     v         c = Rot(m2, phi2) u lies on the cone of u about m2 and on that of v about m1; the cones meet in
//!      \  c     none, one or two directions (or in all, when both shrink to m1):
//!   m1--\-/--m2
//!               c = A1 m1 + (K2/sd) e1 +- (S/sd) e2
//! ```
//!
//! Paden and Kahan's second subproblem, written without the difference of near-equal squares: `K2 = A2 - d A1` is formed
//! without cancellation. Close to the pole of axis 1, where most programs run, the textbook form is wrong by 2e-2 deg in
//! f32, this one by 4e-5 deg. `S` is the Jacobian determinant of the map from angles to direction: joint speed is about
//! tilt speed / S.
//!
//! Cost: two square roots and three arctangents for both solutions.
//!
//! Sources: specification of five-axis machines, section 2; of mirror milling, section 4. Duan, Lin, Zheng, Sun 2014,
//! eq. (4) for the equation; the closed form replaces their elimination.

use crate::geometry::{Rotation, Vector};
use crate::kinematics::principal;
use crate::math::Real;

/// Directions missing the reachable band by no more than this are taken as its border: 1e-3 deg [rad].
pub const SNAP: f64 = 1e-3 * core::f64::consts::PI / 180.0;
/// Closer to the pole than this, axis 1 has no influence: [rad].
pub const SING: f64 = 1e-5;
/// Least sine between two rotary axes, and between the axis next to the tool and the tool axis.
pub const LEAST_SINE: f64 = 1e-3;

/// How many solutions a direction has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Two,
    /// On the border of the reachable band.
    One,
    /// At the pole of the axis next to the work, which may stand anywhere and is held.
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

/// What makes an arrangement of rotaries useless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxesError {
    /// The two rotary axes are parallel (sine below 1e-3).
    ParallelAxes,
    /// The tool lies along the rotary axis next to it (sine below 1e-3).
    ToolAlongAxis,
}

/// All solutions of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles<R> {
    pub kind: Kind,
    /// Angle from the wanted direction to the reachable ones [rad]; 0 inside.
    pub gap: R,
    /// Conditioning number S; 0 unless the kind is two.
    pub s: R,
    /// [phi1, phi2] in (-pi, pi] [rad], solution 1 first. Unless the kind is two, both are the same.
    pub phi: [[R; 2]; 2],
    /// |m1 . v| and |m1 x v|.
    pub tilt: [R; 2],
}

/// The constants of the closed form, named as in the specification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryPair<R> {
    /// In the frame in which directions are given, so that they need no turning first.
    m1: Vector<R>,
    e1: Vector<R>,
    e2: Vector<R>,
    /// m1 . m2 and |m1 x m2|.
    d: R,
    sd: R,
    /// u . m2
    a2: R,
    /// A2 - d and A2 + d, from the differences of the vectors: exact where the tool stands along m1.
    c_plus: R,
    c_minus: R,
    psi: R,
    /// The reachable band of tilts from m1 [rad].
    lo: R,
    hi: R,
    has_pole: bool,
    has_far_pole: bool,
    /// Below this S the two solutions are one.
    one: R,
}

impl<R: Real> RotaryPair<R> {
    /// Unit vectors, all at home: the axis next to the work, the axis next to the tool, the tool axis. `to_work` turns them
    /// into the frame in which directions will be given.
    ///
    /// In f64 and rounded once: in f32 the roundings of `d`, `sd` and `psi` would add up to half of what is allowed.
    pub fn new(
        m1: Vector<f64>,
        m2: Vector<f64>,
        u: Vector<f64>,
        to_work: Rotation<f64>,
    ) -> Result<Self, AxesError> {
        let across = m1.cross(m2);
        let e2 = across.unit(LEAST_SINE).ok_or(AxesError::ParallelAxes)?;
        let sine = m2.cross(u).norm();
        if sine < LEAST_SINE {
            return Err(AxesError::ToolAlongAxis);
        }
        let (d, sd) = (m1.dot(m2), across.norm());
        let e1 = e2.cross(m1);
        // (m1 - d m2)/sd, as the third side of the right-handed triple: no difference of near-equal vectors.
        let f1 = m2.cross(e2);
        let a2 = u.dot(m2);
        let (tilt, delta) = (Real::atan2(sine, a2), Real::atan2(sd, d));
        let lo = Real::abs(tilt - delta);
        let hi = f64::PI - Real::abs(f64::PI - tilt - delta);
        let rounded = |v: Vector<f64>| Vector::from_array((to_work * v).to_array().map(R::of));
        let is_double = R::EPSILON < R::of(1e-10);
        Ok(Self {
            m1: rounded(m1),
            e1: rounded(e1),
            e2: rounded(e2),
            d: R::of(d),
            sd: R::of(sd),
            a2: R::of(a2),
            c_plus: R::of((u - m1).dot(m2)),
            c_minus: R::of((u + m1).dot(m2)),
            psi: R::of(Real::atan2(-u.dot(e2), u.dot(f1))),
            lo: R::of(lo),
            hi: R::of(hi),
            has_pole: lo <= SNAP,
            has_far_pole: f64::PI - hi <= SNAP,
            // S is the root of a difference that is good to one rounding.
            one: R::of(if is_double { 1e-9 } else { 1e-6 }),
        })
    }

    /// The axis next to the work, in the frame of the directions.
    pub fn m1(&self) -> Vector<R> {
        self.m1
    }

    /// Tilts from m1 that can be reached [rad].
    pub fn band(&self) -> [R; 2] {
        [self.lo, self.hi]
    }

    /// Both solutions for the unit direction `v`; `held` in (-pi, pi] [rad] is where phi1 stays at a pole.
    pub fn solve(&self, v: Vector<R>, held: R) -> Angles<R> {
        let (vx, vy, a1) = (v.dot(self.e1), v.dot(self.e2), v.dot(self.m1));
        let flat = vx * vx + vy * vy;
        let s1 = flat.sqrt();
        let tilt = [a1.abs(), s1];
        let is_up = a1 >= R::ZERO;

        let has_pole = if is_up {
            self.has_pole
        } else {
            self.has_far_pole
        };
        if s1 <= R::of(SING) && has_pole {
            let half = if is_up { R::ZERO } else { R::PI };
            return Angles {
                kind: Kind::Infinite,
                gap: R::ZERO,
                s: R::ZERO,
                phi: [[held, principal(half - self.psi)]; 2],
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
                return Angles {
                    kind: Kind::Two,
                    gap: R::ZERO,
                    s,
                    phi: [
                        [principal(az - g1), principal(-g2 - self.psi)],
                        [principal(az + g1), principal(g2 - self.psi)],
                    ],
                    tilt,
                };
            }
        }
        // Only on or outside the border does the gap need the tilt itself.
        let rho1 = s1.atan2(a1);
        let gap = (self.lo - rho1).max(rho1 - self.hi).max(R::ZERO);
        let (s1, a1, k2) = if gap > R::ZERO {
            // The nearest direction of the band: same longitude, tilt clamped.
            let (s1, a1) = rho1.clamp(self.lo, self.hi).sin_cos();
            (s1, a1, self.k2(a1, s1 * s1))
        } else {
            (s1, a1, k2)
        };
        let k1 = a1 - self.d * self.a2;
        let (g1, g2) = (R::ZERO.atan2(k2), R::ZERO.atan2(k1));
        let phi1 = if s1 <= R::of(SING) {
            held
        } else {
            principal(az - g1)
        };
        Angles {
            kind: if gap > R::of(SNAP) {
                Kind::None
            } else {
                Kind::One
            },
            gap,
            s: R::ZERO,
            phi: [[phi1, principal(-g2 - self.psi)]; 2],
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
