//! A rotation, kept as the three columns of its matrix: the images of the x, y and z axes.
//!
//! A matrix and not a quaternion, because every user of it reads columns: the arm of the drill grinder names them
//! n, s, a, and the tool axis of a five-axis machine is the third.

use super::Vector;
use crate::math::Real;
use core::ops::Mul;

/// A proper rotation; `n`, `s`, `a` are the images of the x, y and z axes (Paul's names).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<R> {
    pub n: Vector<R>,
    pub s: Vector<R>,
    pub a: Vector<R>,
}

impl<R: Real> Rotation<R> {
    pub const IDENTITY: Self = Self {
        n: Vector::X,
        s: Vector::Y,
        a: Vector::Z,
    };

    /// Rotation about the unit vector `axis` by `angle` [rad] (Rodrigues).
    pub fn about(axis: Vector<R>, angle: R) -> Self {
        let (sin, cos) = angle.sin_cos();
        let turn =
            |v: Vector<R>| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (R::ONE - cos));
        Self {
            n: turn(Vector::X),
            s: turn(Vector::Y),
            a: turn(Vector::Z),
        }
    }

    /// The rotation back.
    pub fn transposed(self) -> Self {
        Self {
            n: Vector::new(self.n.x, self.s.x, self.a.x),
            s: Vector::new(self.n.y, self.s.y, self.a.y),
            a: Vector::new(self.n.z, self.s.z, self.a.z),
        }
    }
}

impl<R: Real> Rotation<R> {
    /// The rotation nearest to one that was given with rounded digits: Newton's step for the polar factor, twice.
    /// Without it the transpose is not quite the inverse: six decimals are worth a micrometre at one metre.
    pub fn orthonormal(self) -> Self {
        // R (3 I - R^T R) / 2, which squares the deviation of a matrix that is nearly a rotation.
        let improve = |r: Self| {
            let product = r.transposed() * r;
            let column = |c: Vector<R>, e: Vector<R>| r * ((e * R::of(3.0) - c) * R::HALF);
            Self {
                n: column(product.n, Vector::X),
                s: column(product.s, Vector::Y),
                a: column(product.a, Vector::Z),
            }
        };
        improve(improve(self))
    }
}

/// `rotation * vector`: the vector turned.
impl<R: Real> Mul<Vector<R>> for Rotation<R> {
    type Output = Vector<R>;
    fn mul(self, v: Vector<R>) -> Vector<R> {
        self.n * v.x + self.s * v.y + self.a * v.z
    }
}

/// `first * then`, read as matrices: the right one acts first.
impl<R: Real> Mul for Rotation<R> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            n: self * other.n,
            s: self * other.s,
            a: self * other.a,
        }
    }
}
