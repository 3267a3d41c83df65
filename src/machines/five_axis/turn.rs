//! Rotations as a five-axis machine uses them.

use crate::geometry::{Rotation, Vector};
use crate::math::Real;

/// A rotation about a unit vector, applied by Rodrigues' formula: one sine and cosine for all its uses.
#[derive(Clone, Copy)]
pub(super) struct Turn<R> {
    axis: Vector<R>,
    sin: R,
    cos: R,
}

impl<R: Real> Turn<R> {
    pub fn of(axis: Vector<R>, angle: R) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { axis, sin, cos }
    }

    pub fn apply(&self, y: Vector<R>) -> Vector<R> {
        let along = self.axis * (self.axis.dot(y) * (R::ONE - self.cos));
        y * self.cos + self.axis.cross(y) * self.sin + along
    }

    /// The rotation the other way.
    pub fn back(&self, y: Vector<R>) -> Vector<R> {
        Self {
            sin: -self.sin,
            ..*self
        }
        .apply(y)
    }
}

/// The rotation by the least angle that takes z to the unit vector `a`.
pub(super) fn least_rotation_to<R: Real>(a: Vector<R>) -> Rotation<R> {
    if a.z < R::of(-0.999) {
        // Near the opposite any half turn will do: about x, then the rest as from -z.
        let n = Vector::new(R::ONE, R::ZERO, R::ZERO);
        let s = a.cross(n).unit(R::HALF).unwrap_or(-Vector::Y);
        return Rotation {
            n: s.cross(a),
            s,
            a,
        };
    }
    let k = R::ONE / (R::ONE + a.z);
    Rotation {
        n: Vector::new(R::ONE - a.x * a.x * k, -a.x * a.y * k, -a.x),
        s: Vector::new(-a.x * a.y * k, R::ONE - a.y * a.y * k, -a.y),
        a,
    }
}
