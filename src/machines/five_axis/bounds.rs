//! How far the tool strays when the joints run linearly between two solved poses: bounds that hold for every machine.
//!
//! The tip runs on the straight line and the axis on the great circle in the work frame; joints that run linearly
//! leave both by at most an eighth of the second derivative of the map between. With `a1`, `a2` the rotary steps [rad]
//! and `L` the length of the line:
//!
//! ```text
//!   head   Q = a1^2 r1 + 2 a1 a2 r2 + a2^2 r2                 r_k distances from axis k of what it carries
//!   table  Q = a1^2 r1 + 2 a1 (a2 r2 + L) + a2^2 r2 + 2 a2 L
//!   mixed  Q = a1^2 rw + 2 a1 L + a2^2 rh                     tip error <= Q / 8
//! ```
//!
//! Source: section 6 of the specification; checked on 2400 random moves of 400 random machines (true error / bound at
//! most 1, median 0.64 and 0.71).

use super::{Class, Error, FiveAxis, Kind, SING, Solution};
use crate::geometry::Vector;
use crate::joints::Joints;
use crate::kinematics::follow::Guide;
use crate::kinematics::{ClPoint, Way};
use crate::math::Real;

/// Largest errors between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<R> {
    /// Tip off the straight line [mm].
    pub tip: R,
    /// Tool axis off the great circle [rad]; `None` when the axes are more than 60 deg apart, where no bound is known.
    pub axis: Option<R>,
}

impl<R: Real> FiveAxis<R> {
    /// Bounds for the move from `a` to `b`, whose tips are `length` [mm] and whose unit tool axes are `chord` (length
    /// of their difference) apart.
    pub fn bounds(&self, a: &Solution<R>, b: &Solution<R>, length: R, chord: R) -> Bounds<R> {
        let [from1, from2] = a.rotary;
        let [to1, to2] = b.rotary;
        let a1 = to1.minus(from1).abs();
        let a2 = to2.minus(from2).abs();
        Bounds {
            tip: self.tip_bound(a, b, a1, a2, length),
            axis: self.axis_bound(a, b, a1, a2, chord),
        }
    }

    fn tip_bound(&self, a: &Solution<R>, b: &Solution<R>, a1: R, a2: R, length: R) -> R {
        let radius = |n: Vector<R>, y: Vector<R>| n.cross(y).norm();
        let larger = |n, y1, y2| radius(n, y1).max(radius(n, y2));
        let two = R::TWO;
        let q = match self.class {
            Class::Head => {
                let r2 = self.tool_radius;
                let r1 = larger(self.n1, a.inner, b.inner) + R::HALF * a2 * r2;
                a1 * a1 * r1 + two * a1 * a2 * r2 + a2 * a2 * r2
            }
            Class::Table => {
                let r2 = larger(self.n2, a.outer, b.outer);
                let turned = a2 * r2 + length;
                let r1 = larger(self.n1, a.inner, b.inner) + R::HALF * turned;
                a1 * a1 * r1 + two * a1 * turned + a2 * a2 * r2 + two * a2 * length
            }
            Class::Mixed => {
                let rw = larger(self.n1, a.outer, b.outer);
                a1 * a1 * rw + two * a1 * length + a2 * a2 * self.tool_radius
            }
        };
        q * R::of(0.125)
    }

    fn axis_bound(&self, a: &Solution<R>, b: &Solution<R>, a1: R, a2: R, chord: R) -> Option<R> {
        if chord > R::ONE {
            return None;
        }
        let (b1, b2) = match self.direction.free() {
            0 => (a1, a2),
            _ => (a2, a1),
        };
        let ([up_a, flat_a], [up_b, flat_b]) = (a.tilt, b.tilt);
        let [cos_rho2, sin_rho2] = self.direction.rho2;
        let slack = R::HALF * b2;
        let c1 = R::ONE.min(up_a.max(up_b) + slack);
        let sc = R::HALF.min((up_a * flat_a).max(up_b * flat_b) + slack);
        let f = b1 * b1 * sc + R::TWO * b1 * b2 * c1 * sin_rho2 + b2 * b2 * cos_rho2 * sin_rho2;
        Some(f * over_great_circle(chord))
    }
}

/// (1/cos(w/2) - 1) / w^2 for two unit vectors `chord` = 2 sin(w/2) apart, w to 60 deg, without the difference.
fn over_great_circle<R: Real>(chord: R) -> R {
    let sin2 = chord * chord * R::of(0.25);
    if chord < R::of(1e-4) {
        return R::of(0.125);
    }
    let cos = (R::ONE - sin2).sqrt();
    let w = R::TWO * (chord * R::HALF).asin();
    sin2 / (cos * (R::ONE + cos) * w * w)
}

impl<R: Real> Guide<5, R> for FiveAxis<R> {
    type Course = Way<R>;
    type Set = Solution<R>;
    type Error = Error<R>;

    fn solve(&self, at: &ClPoint<R>, before: &Solution<R>) -> Result<Solution<R>, Error<R>> {
        self.inverse(at.p(), at.v(), &before.rotary)
    }

    fn joints(&self, set: &Solution<R>) -> Joints<5, R> {
        set.joints()
    }

    fn change(&self, from: &Solution<R>, to: &Solution<R>) -> Joints<5, R> {
        let ([x0, y0, z0], [a0, b0]) = (from.linear, from.rotary);
        let ([x1, y1, z1], [a1, b1]) = (to.linear, to.rotary);
        Joints([x1 - x0, y1 - y0, z1 - z0, a1.minus(a0), b1.minus(b0)])
    }

    fn bound(&self, from: &Solution<R>, to: &Solution<R>, length: R, chord: R) -> (R, Option<R>) {
        let Bounds { tip, axis } = self.bounds(from, to, length, chord);
        (tip, axis)
    }

    /// A change of solution, unless the great circle leads through the pole, where the solutions meet and change
    /// numbers; or a rotary that goes more than half a turn.
    fn is_reconfigured(
        &self,
        (from, from_set): (&ClPoint<R>, &Solution<R>),
        (to, to_set): (&ClPoint<R>, &Solution<R>),
    ) -> bool {
        let ([a0, b0], [a1, b1]) = (from_set.rotary, to_set.rotary);
        let half = R::PI * R::of(1.0 + 1e-6);
        if a1.minus(a0).abs() > half || b1.minus(b0).abs() > half {
            return true;
        }
        let are_two = from_set.kind == Kind::Two && to_set.kind == Kind::Two;
        are_two && from_set.number != to_set.number && !self.leads_through_pole(from.v(), to.v())
    }

    fn is_singular(&self, set: &Solution<R>) -> bool {
        matches!(set.kind, Kind::Infinite | Kind::One)
    }

    fn speeds(&self) -> Option<Joints<5, R>> {
        self.speeds().copied()
    }
}

impl<R: Real> FiveAxis<R> {
    /// Whether the great circle from `a` to `b` passes the pole, or its opposite, within the singular distance.
    fn leads_through_pole(&self, a: Vector<R>, b: Vector<R>) -> bool {
        let m1 = self.direction.m1();
        let normal = a.cross(b);
        let size = normal.norm();
        let off = m1.dot(normal).abs();
        let is_between = a.cross(m1).dot(normal) * m1.cross(b).dot(normal) >= R::ZERO;
        off <= R::of(SING) * size + R::TWO * R::EPSILON && is_between
    }
}
