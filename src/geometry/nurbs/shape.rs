//! The surface around one point: normal, both fundamental forms, curvatures along and across a direction.

use super::{Jet, NurbsError};
use crate::geometry::Vector;
use crate::math::Real;

/// Normal and forms at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape<R> {
    pub jet: Jet<R>,
    /// Outward unit normal.
    pub normal: Vector<R>,
    /// First form E, F, G [mm2].
    pub first: [R; 3],
    /// Second form L, M, N [mm], of the sign that makes a bulge positive.
    pub second: [R; 3],
    /// sqrt(E G - F^2) = |S_u x S_v| [mm2].
    pub area: R,
    /// 1, or -1 if the normal is reversed.
    side: R,
}

/// What a tool meets that moves in a direction: its axes and the curvatures along, across, and the twist [1/mm].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section<R> {
    /// Unit direction of motion, T.
    pub feed: Vector<R>,
    /// Across it in the tangent plane, C = n x T.
    pub cross: Vector<R>,
    pub k_f: R,
    pub k_c: R,
    pub tau: R,
}

impl<R: Real> Jet<R> {
    pub(super) fn shape(self, reversed: bool) -> Result<Shape<R>, NurbsError> {
        let normal = self.s_u.cross(self.s_v);
        let (e, f, g) = (
            self.s_u.dot(self.s_u),
            self.s_u.dot(self.s_v),
            self.s_v.dot(self.s_v),
        );
        // |S_u x S_v|^2 rather than E G - F^2, which cancels where the two are nearly parallel.
        let w = normal.dot(normal);
        // Also true for what is not a number.
        if !(w > R::ZERO && w >= R::of(1e-18) * e * g && w.is_finite()) {
            return Err(NurbsError::DegenerateNormal);
        }
        let area = w.sqrt();
        let side = if reversed { -R::ONE } else { R::ONE };
        let normal = normal * (side / area);
        Ok(Shape {
            jet: self,
            normal,
            first: [e, f, g],
            second: [
                -self.s_uu.dot(normal),
                -self.s_uv.dot(normal),
                -self.s_vv.dot(normal),
            ],
            area,
            side,
        })
    }
}

impl<R: Real> Shape<R> {
    /// Axes and curvatures for motion towards (du, dv); `None` if that is no direction.
    pub fn along(&self, du: R, dv: R) -> Option<Section<R>> {
        let [e, f, g] = self.first;
        let [l, m, n] = self.second;
        let (along, across) = (e * du + f * dv, f * du + g * dv);
        let squared = along * du + across * dv;
        if !(squared > R::ZERO && squared.is_finite()) {
            return None;
        }
        let per_length = R::ONE / squared.sqrt();
        // Coordinates of T and C in (S_u, S_v).
        let (a1, b1) = (du * per_length, dv * per_length);
        let turn = self.side * per_length / self.area;
        let (a2, b2) = (-across * turn, along * turn);
        let feed = self.jet.s_u * a1 + self.jet.s_v * b1;
        let form = |a: R, b: R, c: R, d: R| l * (a * c) + m * (a * d + b * c) + n * (b * d);
        Some(Section {
            feed,
            cross: self.normal.cross(feed),
            k_f: form(a1, b1, a1, b1),
            k_c: form(a2, b2, a2, b2),
            tau: form(a1, b1, a2, b2),
        })
    }

    /// Mean curvature H [1/mm].
    pub fn mean(&self) -> R {
        let [e, f, g] = self.first;
        let [l, m, n] = self.second;
        (e * n - R::TWO * f * m + g * l) / (R::TWO * self.area * self.area)
    }

    /// Gauss curvature K [1/mm2].
    pub fn gauss(&self) -> R {
        let [l, m, n] = self.second;
        (l * n - m * m) / (self.area * self.area)
    }

    /// Principal curvatures k1 >= k2 [1/mm].
    pub fn principal(&self) -> [R; 2] {
        let mean = self.mean();
        let half = (mean * mean - self.gauss()).max(R::ZERO).sqrt();
        [mean + half, mean - half]
    }
}
