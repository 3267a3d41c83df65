//! N numbers, one for each axis; all arithmetic that walks over axes.

use crate::math::Real;
use core::ops::{Index, IndexMut};
use fixed::types::I32F32;

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

    /// Where the axes stand in steps, to 2^-32 of one; `None` if one of them is beyond what a step counter holds.
    ///
    /// `steps_per_unit` in steps/mm or steps/rad. The product of two `f32` is exact in `f64`; as an `f32` it would be half
    /// a step off from 2^23 steps on, and such roundings are corners to a planner.
    pub fn to_steps(&self, steps_per_unit: &Self) -> Option<[I32F32; N]> {
        let mut steps = [I32F32::ZERO; N];
        for i in 0..N {
            steps[i] = fixed_steps(self.0[i].to_f64() * steps_per_unit.0[i].to_f64())?;
        }
        Some(steps)
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|x| x.is_finite())
    }
}

/// Steps to the nearest 2^-32 of one, as far as `f64` tells them; `None` if their whole is not within `i32`.
pub fn fixed_steps(steps: f64) -> Option<I32F32> {
    // In f64 the last whole step and a half is a number of its own.
    let fits = (-2_147_483_648.5..2_147_483_647.5).contains(&steps);
    // The cast saturates: half a step beyond the counter is its end.
    fits.then(|| I32F32::from_bits(Real::round(steps * 4_294_967_296.0) as i64))
}

/// The nearest whole steps, those above where two are as near: what a path that ends between steps comes to rest on.
pub fn whole_steps<const N: usize>(steps: &[I32F32; N]) -> [i32; N] {
    // Half a step more than 2^31 - 1 saturates; the shift of what is left fits.
    steps.map(|at| (at.to_bits().saturating_add(1 << 31) >> 32) as i32)
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
