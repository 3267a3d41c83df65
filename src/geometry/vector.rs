//! Three numbers: a position [mm], an offset [mm] or a direction (unit length).

use crate::math::Real;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A column vector (x, y, z).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vector<R> {
    pub x: R,
    pub y: R,
    pub z: R,
}

impl<R: Real> Vector<R> {
    pub const ZERO: Self = Self::new(R::ZERO, R::ZERO, R::ZERO);
    pub const X: Self = Self::new(R::ONE, R::ZERO, R::ZERO);
    pub const Y: Self = Self::new(R::ZERO, R::ONE, R::ZERO);
    pub const Z: Self = Self::new(R::ZERO, R::ZERO, R::ONE);

    pub const fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    pub fn from_array([x, y, z]: [R; 3]) -> Self {
        Self { x, y, z }
    }

    pub fn to_array(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }

    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    pub fn norm(self) -> R {
        self.dot(self).sqrt()
    }

    /// The direction of this vector; `None` if it is shorter than `least` or not finite.
    pub fn unit(self, least: R) -> Option<Self> {
        let norm = self.norm();
        (norm.is_finite() && norm >= least && norm > R::ZERO).then(|| self * (R::ONE / norm))
    }

    /// Angle between the two vectors [rad], 0 ..= pi, exact near 0 and near pi alike.
    pub fn angle_to(self, other: Self) -> R {
        self.cross(other).norm().atan2(self.dot(other))
    }

    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<R: Real> Neg for Vector<R> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    fn mul(self, k: R) -> Self {
        Self::new(self.x * k, self.y * k, self.z * k)
    }
}

impl<R: Real> AddAssign for Vector<R> {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<R: Real> SubAssign for Vector<R> {
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
