//! A rigid position and orientation.

use super::{Rotation, Vector};
use crate::math::Real;
use core::ops::Mul;

/// Where a frame stands in another: `p` its origin [mm], `rotation` its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<R> {
    pub rotation: Rotation<R>,
    pub p: Vector<R>,
}

impl<R: Real> Pose<R> {
    pub const IDENTITY: Self = Self {
        rotation: Rotation::IDENTITY,
        p: Vector::ZERO,
    };

    pub fn inverse(self) -> Self {
        let rotation = self.rotation.transposed();
        Self {
            rotation,
            p: -(rotation * self.p),
        }
    }

    /// A point given in this frame, in the frame that the pose is given in.
    pub fn apply(self, point: Vector<R>) -> Vector<R> {
        self.p + self.rotation * point
    }
}

impl<R: Real> Mul for Pose<R> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            rotation: self.rotation * other.rotation,
            p: self.apply(other.p),
        }
    }
}
