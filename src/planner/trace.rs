//! Length along the head block -> position of every joint: the geometry of block.rs, evaluated.

use super::block::Block;
use super::profile;

/// Where the head block lies.
#[derive(Clone, Copy)]
pub(super) struct Trace<const N: usize> {
    /// Start of the head block [2^-32 step].
    base: [i64; N],
    /// Its direction [2^-40 step per length], so that a length of 2^20 ends within 2^-21 step of its vertex.
    direction: [i64; N],
    /// Direction of the block before.
    pub before: Option<[f32; N]>,
}

/// (d - x)^3 / (6 d^2) for x < d, else 0; lengths in bits.
fn bulge(d: f32, x: i64) -> f32 {
    let left = d - profile::length_of(x);
    if left <= 0.0 || d <= 0.0 {
        return 0.0;
    }
    let share = left / d;
    share * share * left * (1.0 / 6.0)
}

impl<const N: usize> Trace<N> {
    pub fn at(base: [i64; N]) -> Self {
        Self {
            base,
            direction: [0; N],
            before: None,
        }
    }

    pub fn base(&self) -> &[i64; N] {
        &self.base
    }

    pub fn whole(position: [i32; N]) -> Self {
        Self::at(position.map(|p| i64::from(p) << 32))
    }

    /// `block` is the head from now on.
    pub fn enter(&mut self, block: &Block<N>) {
        for i in 0..N {
            let way = (i64::from(block.end[i]) << 32) - self.base[i];
            self.direction[i] = ((i128::from(way) << 40) / i128::from(block.bits.max(1))) as i64;
        }
    }

    /// The head block is over: its end is where the next one starts.
    pub fn leave(&mut self, block: &Block<N>) {
        self.base = block.end.map(|p| i64::from(p) << 32);
        self.before = Some(block.u);
    }

    /// Position of every joint [2^-32 step] at `x` in `head`.
    pub fn position(&self, x: i64, head: &Block<N>, next: Option<&Block<N>>) -> [i64; N] {
        let mut q = self.base;
        for i in 0..N {
            q[i] += ((i128::from(self.direction[i]) * i128::from(x)) >> 40) as i64;
        }
        let start = bulge(head.d, x);
        if start > 0.0
            && let Some(before) = &self.before
        {
            for i in 0..N {
                q[i] += profile::length_bits((head.u[i] - before[i]) * start);
            }
        }
        if let Some(next) = next {
            let end = bulge(next.d, head.bits - x);
            if end > 0.0 {
                for i in 0..N {
                    q[i] += profile::length_bits((next.u[i] - head.u[i]) * end);
                }
            }
        }
        q
    }
}
