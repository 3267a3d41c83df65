//! NURBS surfaces: a parameter pair (u, v) to the point, its derivatives, the normal and the curvatures.
//!
//! ```text
//!   S(u,v) = sum N_i(u) N_j(v) w_ij P_ij / sum N_i(u) N_j(v) w_ij
//!
//!   Nurbs --jet(u, v)--> Jet (S and its derivatives) --shape()--> Shape (normal, both forms) --along(du, dv)--> Section
//! ```
//!
//! Lengths in mm, curvatures in 1/mm, **positive where the surface bulges towards the side that the normal shows to**.
//! Fixed size and no allocation: a net of 32 x 32 takes 16.3 KiB in `f32`. Degrees 1 ..= 5, clamped knots, positive weights.
//!
//! Accuracy: 1e-9 in `f64`; in `f32`, on a part of 200 mm, 1e-4 mm, 1e-5 for the normal, 1e-3 for curvatures (+1e-6 /mm).
//!
//! Source: L. Piegl, W. Tiller, The NURBS Book, equations 2.5, 2.9, 4.20; second derivatives and curvatures by
//! differentiating the homogeneous surface (w S, w).

mod basis;
mod shape;
mod slice;

pub use shape::{Section, Shape};
pub use slice::Slice;

use super::Vector;
use crate::math::Real;
use basis::{Basis, Knots};

/// The highest degree in either parameter.
pub const MAX_DEGREE: usize = 5;
/// The most control points in either direction.
pub const MAX_COUNT: usize = 32;

/// One of the two parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    U,
    V,
}

/// Why there is no such surface, or no such point on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NurbsError {
    /// A degree outside 1 ..= 5.
    BadDegree(Side),
    /// Fewer than degree + 1 control points in a direction, more than 32 or than there is room for, not
    /// rectangular, or one that is not finite.
    BadNet,
    /// Knots: wrong number, falling, not finite, not clamped, or one inside repeated more often than the degree.
    BadKnots(Side),
    /// A weight that is not finite or not greater than 0.
    BadWeight,
    /// (u, v) lies outside the domain.
    OutOfDomain,
    /// |S_u x S_v| < 1e-9 |S_u| |S_v|: there is no normal.
    DegenerateNormal,
}

impl NurbsError {
    /// The part of the description to look at, by its name in every interface.
    pub const fn field(self) -> Option<&'static str> {
        match self {
            Self::BadDegree(Side::U) => Some("degree_u"),
            Self::BadDegree(Side::V) => Some("degree_v"),
            Self::BadNet => Some("points"),
            Self::BadKnots(Side::U) => Some("knots_u"),
            Self::BadKnots(Side::V) => Some("knots_v"),
            Self::BadWeight => Some("weights"),
            Self::OutOfDomain | Self::DegenerateNormal => None,
        }
    }

    /// The name under which every interface reports it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BadDegree(_) => "BadDegree",
            Self::BadNet => "BadNet",
            Self::BadKnots(_) => "BadKnots",
            Self::BadWeight => "BadWeight",
            Self::OutOfDomain => "OutOfDomain",
            Self::DegenerateNormal => "DegenerateNormal",
        }
    }

    /// What was expected, as a sentence.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::BadDegree(_) => "degrees must be 1 to 5",
            Self::BadNet => {
                "the net must be rectangular, with at least degree + 1 and at most 32 finite points in each direction, and as many weights"
            }
            Self::BadKnots(_) => {
                "knots must be finite and not falling, points + degree + 1 of them, first and last repeated degree + 1 times, inner ones at most degree times"
            }
            Self::BadWeight => "weights must be finite and greater than 0",
            Self::OutOfDomain => "u and v must lie between the first and the last of their knots",
            Self::DegenerateNormal => {
                "the surface has no normal where S_u and S_v are parallel or vanish; use another place or parametrisation"
            }
        }
    }
}

/// Two numbers, of u and of v.
pub type Pair<T> = [T; 2];

/// A surface with room for NU x NV control points.
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs<R, const NU: usize, const NV: usize> {
    u: Knots<R, NU>,
    v: Knots<R, NV>,
    /// (x, y, z, w), row by row: the first index runs along u.
    net: [[[R; 4]; NV]; NU],
    /// The normal is -(S_u x S_v).
    reversed: bool,
}

/// The point at (u, v) with its derivatives [mm].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<R> {
    pub s: Vector<R>,
    pub s_u: Vector<R>,
    pub s_v: Vector<R>,
    pub s_uu: Vector<R>,
    pub s_uv: Vector<R>,
    pub s_vv: Vector<R>,
}

/// (w S, w), or a derivative of it: named numbers and not an array, so that they stay in registers.
#[derive(Clone, Copy, Debug)]
struct Homogeneous<R> {
    p: Vector<R>,
    w: R,
}

impl<R: Real> Homogeneous<R> {
    const ZERO: Self = Self {
        p: Vector::ZERO,
        w: R::ZERO,
    };

    fn add(&mut self, other: Self, share: R) {
        self.p += other.p * share;
        self.w += other.w * share;
    }
}

impl<R: Real, const NU: usize, const NV: usize> Nurbs<R, NU, NV> {
    /// A surface of `counts` control points with their `weights`, both row by row (the rows run along v, one for each
    /// step along u; all weights are 1 if there are none). Checked from degree to weights; the first fault is returned.
    pub fn new(
        degrees: Pair<usize>,
        counts: Pair<usize>,
        knots: Pair<&[R]>,
        points: &[Vector<R>],
        weights: &[R],
    ) -> Result<Self, NurbsError> {
        for (degree, side) in degrees.iter().zip([Side::U, Side::V]) {
            if !(1..=MAX_DEGREE).contains(degree) {
                return Err(NurbsError::BadDegree(side));
            }
        }
        let [nu, nv] = counts;
        let fits = |n: usize, p: usize, room: usize| n > p && n <= MAX_COUNT.min(room);
        if !fits(nu, degrees[0], NU)
            || !fits(nv, degrees[1], NV)
            || points.len() != nu * nv
            || !(weights.is_empty() || weights.len() == points.len())
            || !points.iter().all(|p| p.is_finite())
        {
            return Err(NurbsError::BadNet);
        }
        let u = Knots::new(degrees[0], nu, knots[0], Side::U)?;
        let v = Knots::new(degrees[1], nv, knots[1], Side::V)?;
        if !weights.iter().all(|w| w.is_finite() && *w > R::ZERO) {
            return Err(NurbsError::BadWeight);
        }
        let mut net = [[[R::ZERO; 4]; NV]; NU];
        let mut weights = weights.iter();
        for (row, from) in net.iter_mut().zip(points.chunks(nv)) {
            for (slot, p) in row.iter_mut().zip(from) {
                let w = weights.next().copied().unwrap_or(R::ONE);
                *slot = [p.x, p.y, p.z, w];
            }
        }
        Ok(Self {
            u,
            v,
            net,
            reversed: false,
        })
    }

    /// The same surface with its normal on the other side.
    pub fn reversed(mut self) -> Self {
        self.reversed = !self.reversed;
        self
    }

    /// [u_first, u_last] and [v_first, v_last].
    pub fn domain(&self) -> Pair<[R; 2]> {
        [self.u.domain(), self.v.domain()]
    }

    /// The point at (u, v) and its derivatives.
    pub fn jet(&self, u: R, v: R) -> Result<Jet<R>, NurbsError> {
        self.u.holds(u)?;
        self.v.holds(v)?;
        let along_u = self.u.basis(u);
        let along_v = self.v.basis(v);
        // Counted from a point of the net near by, so that second derivatives, whose weights are hundreds and cancel, do not
        // carry the rounding of the whole part's size.
        let middle = |along: &Basis<R>| along.first + along.functions().len() / 2;
        let near = self.net.get(middle(&along_u));
        let near = near.and_then(|row| row.get(middle(&along_v)));
        let [x0, y0, z0, _] = near.copied().unwrap_or([R::ZERO; 4]);
        let origin = Vector::new(x0, y0, z0);
        let zero = Homogeneous::ZERO;
        let (mut a, mut a_u, mut a_v) = (zero, zero, zero);
        let (mut a_uu, mut a_uv, mut a_vv) = (zero, zero, zero);
        let rows = self.net.get(along_u.first..).unwrap_or(&[]);
        for (row, [n, n_u, n_uu]) in rows.iter().zip(along_u.functions()) {
            let (mut c, mut c_v, mut c_vv) = (zero, zero, zero);
            let points = row.get(along_v.first..).unwrap_or(&[]);
            for ([x, y, z, w], [n, n_v, n_vv]) in points.iter().zip(along_v.functions()) {
                let point = Homogeneous {
                    p: (Vector::new(*x, *y, *z) - origin) * *w,
                    w: *w,
                };
                c.add(point, *n);
                c_v.add(point, *n_v);
                c_vv.add(point, *n_vv);
            }
            a.add(c, *n);
            a_u.add(c, *n_u);
            a_uu.add(c, *n_uu);
            a_v.add(c_v, *n);
            a_uv.add(c_v, *n_u);
            a_vv.add(c_vv, *n);
        }
        // Differentiating w S = A by the product rule, with w > 0 as a mean of positive weights.
        let per_w = R::ONE / a.w;
        let s = a.p * per_w;
        let s_u = (a_u.p - s * a_u.w) * per_w;
        let s_v = (a_v.p - s * a_v.w) * per_w;
        Ok(Jet {
            s: s + origin,
            s_u,
            s_v,
            s_uu: (a_uu.p - s_u * (R::TWO * a_u.w) - s * a_uu.w) * per_w,
            s_uv: (a_uv.p - s_v * a_u.w - s_u * a_v.w - s * a_uv.w) * per_w,
            s_vv: (a_vv.p - s_v * (R::TWO * a_v.w) - s * a_vv.w) * per_w,
        })
    }

    /// Normal and curvatures at (u, v).
    pub fn shape(&self, u: R, v: R) -> Result<Shape<R>, NurbsError> {
        self.jet(u, v)?.shape(self.reversed)
    }

    /// As [`Self::shape`], and beyond the edge its continuation, **for tool centres only**: rows that run off the part have
    /// their centres there. It is no part of the surface and must not be shown as such.
    ///
    /// From the nearest edge point by the second-order Taylor polynomial over 3 % of the domain's width, straight beyond;
    /// second derivatives keep the edge value.
    pub fn tool_shape(&self, u: R, v: R) -> Result<Shape<R>, NurbsError> {
        let [[u0, u1], [v0, v1]] = self.domain();
        let (at_u, at_v) = (u.clamp(u0, u1), v.clamp(v0, v1));
        let edge = self.jet(at_u, at_v)?;
        let (du, dv) = (u - at_u, v - at_v);
        if du == R::ZERO && dv == R::ZERO {
            return edge.shape(self.reversed);
        }
        if !(du.is_finite() && dv.is_finite()) {
            return Err(NurbsError::OutOfDomain);
        }
        let curved = R::of(0.03);
        let bend_u = du.clamp(-curved * (u1 - u0), curved * (u1 - u0));
        let bend_v = dv.clamp(-curved * (v1 - v0), curved * (v1 - v0));
        let Jet {
            s,
            s_u,
            s_v,
            s_uu,
            s_uv,
            s_vv,
        } = edge;
        // x^2/2 up to the end of the bend, its tangent beyond.
        let square = |d: R, bend: R| bend * (d - bend * R::HALF);
        let jet = Jet {
            s: s + s_u * du
                + s_v * dv
                + s_uu * square(du, bend_u)
                + s_uv * (du * dv)
                + s_vv * square(dv, bend_v),
            s_u: s_u + s_uu * bend_u + s_uv * dv,
            s_v: s_v + s_uv * du + s_vv * bend_v,
            ..edge
        };
        jet.shape(self.reversed)
    }
}
