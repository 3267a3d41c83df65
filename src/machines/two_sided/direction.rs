//! Wanted tool axis -> angles of the rotaries of one side, in closed form.
//!
//! ```text
//! list the rotaries from the work towards the tool; phi_i = k_i theta_i, k = -1 on the work chain, +1 on the tool chain
//!
//!   two:   Rot(m1, phi1) Rot(m2, phi2) u = v
//!   one:   Rot(w, phi) u = v, in the least-angle sense; the angle that is left is the residual
//!   none:  residual = angle(u, v)
//!
//!     v         az, rho1: longitude and tilt of v about m1;  g1: how far c is from the plane of m1 and m2
//!      \  c     c = Rot(m2, phi2) u lies on the cone of u about m2 and on that of v about m1
//!   m1--\-/--m2
//! ```
//!
//! The intermediate vector is `c = A1 m1 + (K2/sd) e1 +- (S/sd) e2`: Paden and Kahan's second subproblem with three
//! arctangents for both solutions. `K2 = A2 - d A1` is formed without cancellation, so that in f32 the direction is
//! good to 4e-5 deg at the pole of axis 1 too.
//!
//! Sources: specification of five-axis machines, section 2 (two rotaries); of mirror milling, section 4.

use crate::geometry::Vector;
use crate::kinematics::principal;
use crate::math::Real;

/// Directions this near to the reachable band count as reached: 1e-3 deg.
pub const SNAP: f64 = 1e-3 / 180.0 * core::f64::consts::PI;
/// Tilt from the pole of axis 1 below which its angle is held [rad].
const SINGULAR: f64 = 1e-5;
/// Least sine between two rotary axes, and between the outer axis and the tool axis.
const LEAST_SINE: f64 = 1e-3;

/// How many solutions a direction has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Two,
    One,
    /// At the pole of the axis next to the work: its angle is held.
    Infinite,
    /// Beyond reach; the nearest direction is given instead.
    None,
}

/// What makes an arrangement of rotaries useless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxesError {
    /// The two rotary axes are parallel (sine below 1e-3).
    ParallelAxes,
    /// The tool lies along the rotary axis next to it (sine below 1e-3).
    ToolAlongAxis,
}

/// Angles `[phi1, phi2]` [rad] in (-pi, pi] of up to two solutions (of one rotary: phi1; of none: zeros).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction<R> {
    pub kind: Kind,
    /// Angle from the wanted direction to the reachable ones [rad]; with fewer than two rotaries the residual.
    pub gap: R,
    /// Jacobian determinant of the direction map (conditioning), 0 unless the kind is two or one; `None` with
    /// fewer than two rotaries.
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
    Two(TwoRotaries<R>),
}

impl<R: Real> Heading<R> {
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
            Self::Two(axes) => axes.solve(v, held),
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

/// Two rotaries: constants of the closed form, named as in the specification.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoRotaries<R> {
    m1: Vector<R>,
    e1: Vector<R>,
    e2: Vector<R>,
    d: R,
    sd: R,
    a2: R,
    c_plus: R,
    c_minus: R,
    psi: R,
    lo: R,
    hi: R,
}

impl<R: Real> TwoRotaries<R> {
    /// Unit vectors: the axis next to the work, the axis next to the tool, the tool axis, all at home. Computed in f64
    /// and rounded once: in f32 the roundings of the constants alone would use up half of what is allowed.
    pub fn new(m1: Vector<R>, m2: Vector<R>, u: Vector<R>) -> Result<Self, AxesError> {
        let fine = |v: Vector<R>| {
            let v = Vector::new(v.x.to_f64(), v.y.to_f64(), v.z.to_f64());
            v.unit(LEAST_SINE).unwrap_or(v)
        };
        let rounded = |v: Vector<f64>| Vector::new(R::of(v.x), R::of(v.y), R::of(v.z));
        let (m1, m2, u) = (fine(m1), fine(m2), fine(u));
        let cross = m1.cross(m2);
        let sd = cross.norm();
        if sd < LEAST_SINE {
            return Err(AxesError::ParallelAxes);
        }
        if m2.cross(u).norm() < LEAST_SINE {
            return Err(AxesError::ToolAlongAxis);
        }
        let e2 = cross * (1.0 / sd);
        let e1 = e2.cross(m1);
        // (m1 - d m2)/sd, as the third side of the right-handed triple: no difference of near-equal vectors.
        let f1 = m2.cross(e2);
        let (tilt, delta) = (u.angle_to(m2), m1.angle_to(m2));
        Ok(Self {
            m1: rounded(m1),
            e1: rounded(e1),
            e2: rounded(e2),
            d: R::of(m1.dot(m2)),
            sd: R::of(sd),
            a2: R::of(u.dot(m2)),
            // A2 -+ d: the vectors are subtracted first, which is exact when they are close.
            c_plus: R::of((u - m1).dot(m2)),
            c_minus: R::of((u + m1).dot(m2)),
            psi: R::of(Real::atan2(-u.dot(e2), u.dot(f1))),
            lo: R::of(Real::abs(tilt - delta)),
            hi: R::of(f64::PI - Real::abs(f64::PI - tilt - delta)),
        })
    }

    /// Tilts from m1 that can be reached [rad].
    pub fn band(&self) -> [R; 2] {
        [self.lo, self.hi]
    }

    fn solve(&self, v: Vector<R>, held: R) -> Direction<R> {
        let (vx, vy, a1) = (v.dot(self.e1), v.dot(self.e2), v.dot(self.m1));
        let s1 = (vx * vx + vy * vy).sqrt();
        let (k1, k2) = self.k(a1, s1);
        let (minus, plus) = (s1 * self.sd - k2, s1 * self.sd + k2);
        // Inside the band exactly where the product is positive: the tilt itself is needed outside only.
        let inside = minus * plus;
        let gap = if inside > R::ZERO {
            R::ZERO
        } else {
            let tilt = s1.atan2(a1);
            (self.lo - tilt).max(tilt - self.hi).max(R::ZERO)
        };
        let snap = R::of(SNAP);
        if gap > snap {
            return self.nearest(vx, vy, s1.atan2(a1), gap, held);
        }
        let singular = R::of(SINGULAR);
        let at_pole = if a1 > R::ZERO {
            self.lo <= snap
        } else {
            R::PI - self.hi <= snap
        };
        if s1 <= singular && at_pole {
            let half = if a1 > R::ZERO { R::ZERO } else { R::PI };
            return Direction {
                kind: Kind::Infinite,
                gap,
                s: Some(R::ZERO),
                first: [principal(held), principal(half - self.psi)],
                second: None,
            };
        }
        let s = inside.max(R::ZERO).sqrt();
        let az = vy.atan2(vx);
        let (g1, g2) = (s.atan2(k2), s.atan2(k1));
        let least = if R::EPSILON.to_f64() < 1e-12 {
            1e-9
        } else {
            1e-6
        };
        let one = s <= R::of(least);
        Direction {
            kind: if one { Kind::One } else { Kind::Two },
            gap,
            s: Some(s),
            first: [principal(az - g1), principal(-g2 - self.psi)],
            second: (!one).then(|| [principal(az + g1), principal(g2 - self.psi)]),
        }
    }

    /// K1 and K2 of a direction with the cosine and sine of its tilt.
    fn k(&self, a1: R, s1: R) -> (R, R) {
        let squared = s1 * s1;
        let k2 = if a1 >= R::ZERO {
            self.c_plus + self.d * (squared / (R::ONE + a1))
        } else {
            self.c_minus - self.d * (squared / (R::ONE - a1))
        };
        (a1 - self.d * self.a2, k2)
    }

    /// The direction of the band nearest to one outside it: same longitude, tilt clamped.
    fn nearest(&self, vx: R, vy: R, tilt: R, gap: R, held: R) -> Direction<R> {
        let (s1, a1) = tilt.clamp(self.lo, self.hi).sin_cos();
        let (k1, k2) = self.k(a1, s1);
        let (g1, g2) = (R::ZERO.atan2(k2), R::ZERO.atan2(k1));
        let phi1 = if s1 <= R::of(SINGULAR) {
            held
        } else {
            vy.atan2(vx) - g1
        };
        Direction {
            kind: Kind::None,
            gap,
            s: Some(R::ZERO),
            first: [principal(phi1), principal(-g2 - self.psi)],
            second: None,
        }
    }
}
