//! A curve u = const of the surface: a third of the work where many of its points are wanted.

use super::basis::Knots;
use super::{Nurbs, NurbsError};
use crate::geometry::Vector;
use crate::math::Real;

/// The curve u = const, with the normals of the surface along it.
#[derive(Clone, Debug)]
pub struct Slice<'a, R, const NV: usize> {
    v: &'a Knots<R, NV>,
    /// (w S, w) and its derivative by u, as control points along v.
    net: [[[R; 4]; 2]; NV],
    side: R,
}

impl<R: Real, const NU: usize, const NV: usize> Nurbs<R, NU, NV> {
    pub fn slice(&self, u: R) -> Result<Slice<'_, R, NV>, NurbsError> {
        self.u.holds(u)?;
        let along = self.u.basis(u);
        let mut net = [[[R::ZERO; 4]; 2]; NV];
        let rows = self.net.get(along.first..).unwrap_or(&[]);
        for (row, [n, n_u, _]) in rows.iter().zip(along.functions()) {
            for ([value, slope], [x, y, z, w]) in net.iter_mut().zip(row) {
                let point = [*x * *w, *y * *w, *z * *w, *w];
                for k in 0..4 {
                    value[k] += point[k] * *n;
                    slope[k] += point[k] * *n_u;
                }
            }
        }
        Ok(Slice {
            v: &self.v,
            net,
            side: if self.reversed { -R::ONE } else { R::ONE },
        })
    }
}

impl<R: Real, const NV: usize> Slice<'_, R, NV> {
    /// Point [mm] and outward unit normal.
    pub fn place(&self, v: R) -> Result<(Vector<R>, Vector<R>), NurbsError> {
        self.v.holds(v)?;
        let along = self.v.basis(v);
        let zero = [R::ZERO; 4];
        let (mut a, mut a_u, mut a_v) = (zero, zero, zero);
        let points = self.net.get(along.first..).unwrap_or(&[]);
        for ([value, slope], [n, n_v, _]) in points.iter().zip(along.functions()) {
            for k in 0..4 {
                a[k] += value[k] * *n;
                a_u[k] += slope[k] * *n;
                a_v[k] += value[k] * *n_v;
            }
        }
        let per_w = R::ONE / a[3];
        let part = |h: [R; 4]| Vector::new(h[0], h[1], h[2]);
        let s = part(a) * per_w;
        let s_u = (part(a_u) - s * a_u[3]) * per_w;
        let s_v = (part(a_v) - s * a_v[3]) * per_w;
        let normal = s_u.cross(s_v);
        let w = normal.dot(normal);
        // Also true for what is not a number.
        if !(w > R::ZERO && w >= R::of(1e-18) * s_u.dot(s_u) * s_v.dot(s_v) && w.is_finite()) {
            return Err(NurbsError::DegenerateNormal);
        }
        Ok((s, normal * (self.side / w.sqrt())))
    }
}
