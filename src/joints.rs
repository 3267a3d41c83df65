//! N numbers, one for each axis; all arithmetic that walks over axes.

use crate::math::Real;
use core::ops::{Index, IndexMut};

/// Joint coordinates: [mm] for a joint that slides, [rad] for one that turns, unless the owner says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joints<const N: usize, R = f32>(pub [R; N]);

impl<const N: usize, R: Real> Default for Joints<N, R> {
    fn default() -> Self {
        Self([R::ZERO; N])
    }
}

impl<const N: usize, R: Real> Joints<N, R> {
    /// `f` of the two values of each axis.
    pub fn zip_map(&self, other: &Self, mut f: impl FnMut(R, R) -> R) -> Self {
        Self(core::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    /// Scalar product over the axes.
    pub fn dot(&self, other: &Self) -> R {
        self.0
            .iter()
            .zip(&other.0)
            .fold(R::ZERO, |sum, (a, b)| sum + *a * *b)
    }

    /// The nearest whole step of each axis, ties away from zero; `None` if one of them is not within `i32`.
    ///
    /// `steps_per_unit` in steps/mm or steps/rad. Rounding the absolute value and taking differences afterwards
    /// keeps rounding from adding up along a path.
    pub fn to_steps(&self, steps_per_unit: &Self) -> Option<[i32; N]> {
        let steps = self.zip_map(steps_per_unit, |q, scale| (q * scale).round());
        // 2^31 itself is a number of both types, and the first that an i32 does not hold.
        let limit = R::of(2_147_483_648.0);
        let fits = steps.0.iter().all(|x| *x < limit && *x >= -limit);
        fits.then(|| steps.0.map(R::to_i32))
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|x| x.is_finite())
    }
}

impl<const N: usize, R> Index<usize> for Joints<N, R> {
    type Output = R;
    fn index(&self, axis: usize) -> &R {
        &self.0[axis]
    }
}

impl<const N: usize, R> IndexMut<usize> for Joints<N, R> {
    fn index_mut(&mut self, axis: usize) -> &mut R {
        &mut self.0[axis]
    }
}
