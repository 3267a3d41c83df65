//! The moving frame A = (a, b, c) on the surface, the axis in it, and the tool's frame.
//!
//! ```text
//! R = [ a | c x a | c ],      P = R (sin theta cos alpha, sin theta sin alpha, cos theta)
//! T = R Rz(alpha) Ry(theta) Rz(-alpha)
//! ```
//!
//! T is R tipped by the smallest rotation that brings its third column to P. It comes back to itself with every turn of
//! the phase; `R Rz(alpha) Ry(theta)`, which has the same P, would wind the last joint of a wrist by a turn each time.
//!
//! Source: Ji et al. (2012), equations (4)-(5), (7) and (11)-(15), corrected.

use super::error::PrecessionError;
use super::turn::Turn;
use crate::geometry::{Rotation, Vector};
use crate::math::Real;

/// Least sine of the angle between a reference direction and the normal.
pub(super) const LEAST_SINE: f64 = 1e-3;

/// The frame whose `a` is the unit direction `a` projected on the tangent plane of the unit normal `c`.
fn frame<R: Real>(a: Vector<R>, c: Vector<R>) -> Option<Rotation<R>> {
    let a = in_tangent_plane(a, c, R::ZERO)?;
    // Once more: the first projection leaves a rounding error divided by the sine.
    let a = in_tangent_plane(a, c, R::ZERO)?;
    Some(Rotation {
        n: a,
        s: c.cross(a),
        a: c,
    })
}

/// Unit projection of `v` on the tangent plane; `None` if it is shorter than `least`.
pub(super) fn in_tangent_plane<R: Real>(v: Vector<R>, c: Vector<R>, least: R) -> Option<Vector<R>> {
    (v - c * v.dot(c)).unit(least)
}

/// The frame for the unit normal `c` and a feed of any length: `a` is the feed projected on the tangent plane.
/// Fails with `FeedAlongNormal` when the sine of their angle is below 1e-3.
pub fn along_feed<R: Real>(feed: Vector<R>, c: Vector<R>) -> Result<Rotation<R>, PrecessionError> {
    feed.unit(R::of(1e-6))
        .and_then(|f| in_tangent_plane(f, c, R::of(LEAST_SINE)))
        .and_then(|a| frame(a, c))
        .ok_or(PrecessionError::FeedAlongNormal)
}

/// The frame for the unit normal `c` and a heading: the angle from +x to the xy-projection of `a` [rad].
///
/// Fails with `NormalDown` where the normal points below the xy-plane. Along a vertical wall `a` is the heading itself,
/// up or down such a wall it is vertical.
pub fn along_heading<R: Real>(heading: R, c: Vector<R>) -> Result<Rotation<R>, PrecessionError> {
    if c.z < R::of(-1e-9) {
        return Err(PrecessionError::NormalDown);
    }
    let (sin, cos) = heading.sin_cos();
    let rise = c.x * cos + c.y * sin;
    let up = c.z.max(R::ZERO);
    // The paper's vector times c_z, so that nothing blows up on a vertical wall.
    let a = Vector::new(up * cos, up * sin, -rise)
        .unit(R::of(1e-6))
        .unwrap_or(Vector::new(cos, sin, R::ZERO));
    frame(a, c).ok_or(PrecessionError::NormalDown)
}

/// The bonnet's axis P in the coordinates of `frame`'s own coordinates: tilt (sine, cosine), phase (sine, cosine).
pub fn axis<R: Real>(frame: &Rotation<R>, tilt: (R, R), phase: (R, R)) -> Vector<R> {
    let lean = frame.n * phase.1 + frame.s * phase.0;
    lean * tilt.0 + frame.a * tilt.1
}

/// The turn-free tool frame T; its third column is P. Tilt and phase as (sine, cosine).
pub fn tool_frame<R: Real>(frame: &Rotation<R>, tilt: (R, R), phase: (R, R)) -> Rotation<R> {
    let ((sin_tilt, cos_tilt), (sin, cos)) = (tilt, phase);
    let lean = frame.n * cos + frame.s * sin;
    let across = frame.s * cos - frame.n * sin;
    let tipped = lean * cos_tilt - frame.a * sin_tilt;
    Rotation {
        n: tipped * cos - across * sin,
        s: tipped * sin + across * cos,
        a: lean * sin_tilt + frame.a * cos_tilt,
    }
}

/// The paper's angles (Lx, Ly, Lz) [rad] of a frame, with R = Ry(Ly) Rx(Lx) Rz(Lz). For reading only: where the normal
/// lies along the y axis they are not unique (Ly is 0 there), so a frame is never rebuilt from them.
pub fn angles<R: Real>(frame: &Rotation<R>) -> [R; 3] {
    let Rotation { n: a, s: b, a: c } = *frame;
    // The arcsine of -c_y, without its loss of digits near +-90 deg.
    let lx = (-c.y).atan2(c.x.hypot(c.z));
    let singular = a.y.hypot(b.y) < R::of(1e-9).max(R::EPSILON * R::of(16.0));
    if singular {
        [lx, R::ZERO, (-b.x).atan2(a.x)]
    } else {
        [lx, c.x.atan2(c.z), a.y.atan2(b.y)]
    }
}

/// The first reference direction at the unit normal `c`: the first candidate that leaves a sine of 1e-3, else the
/// coordinate axis least aligned with the normal.
pub(super) fn first_reference<R: Real>(
    candidates: [Option<Vector<R>>; 2],
    c: Vector<R>,
) -> Vector<R> {
    let [x, y, z] = c.to_array().map(R::abs);
    let least = if x <= y && x <= z {
        Vector::X
    } else if y <= z {
        Vector::Y
    } else {
        Vector::Z
    };
    candidates
        .into_iter()
        .flatten()
        .find_map(|v| along_feed(v, c).ok())
        .or_else(|| frame(least, c))
        .map_or(least, |frame| frame.n)
}

/// The angle that the phase takes up when the reference changes from `old` to `new` at the normal `c`, so that the axis
/// stays where it is.
pub(super) fn taken_up<R: Real>(old: Vector<R>, new: Vector<R>, c: Vector<R>) -> Turn {
    Turn::of_radians(c.dot(new.cross(old)).atan2(new.dot(old)))
}
