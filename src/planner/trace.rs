//! Length along the head block -> position of every joint: the geometry of block.rs, evaluated.

use super::block::Block;
use super::profile;
use super::run::Window;

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

/// A half-width and its inverse, as integers: what is rounded here only scales the hat, alike at every sample.
struct Hat {
    d: i64,
    /// 2^48 / d.
    inverse: u64,
}

impl Hat {
    fn new(d: f32) -> Self {
        Self {
            d: profile::length_bits(d),
            inverse: if d > 0.0 {
                (281_474_976_710_656.0 / d) as u64
            } else {
                0
            },
        }
    }

    /// (d - x)^3 / (6 d^2) for x < d, else 0; lengths in bits. No float: its rounding would be a jerk of its own.
    fn bulge(&self, x: i64) -> i64 {
        let left = self.d - x;
        if left <= 0 {
            return 0;
        }
        // left / d as Q0.32, its square, and the cube times d (below 2^63 since left is).
        let share = ((left as u128 * u128::from(self.inverse)) >> 48) as u64;
        let share = share.min(1 << 32);
        let square = ((u128::from(share) * u128::from(share)) >> 32) as u64;
        ((left as u128 * u128::from(square)) >> 32) as i64 / 6
    }
}

/// Direction as 2^-40 step per length.
fn direction_bits(u: f32) -> i64 {
    (u * 1_099_511_627_776.0) as i64
}

/// Way along a direction [2^-32 step].
fn along(direction: i64, x: i64) -> i64 {
    ((i128::from(direction) * i128::from(x)) >> 40) as i64
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
            let way = block.end[i] - self.base[i];
            self.direction[i] = profile::direction(way, block.bits.max(1));
        }
    }

    /// The head block is over: its end is where the next one starts.
    pub fn leave(&mut self, block: &Block<N>) {
        self.base = block.end;
        self.before = Some(block.u);
    }

    /// Position of every joint [2^-32 step] at `x` in `head`.
    pub fn position(
        &self,
        x: i64,
        head: &Block<N>,
        next: Option<&Block<N>>,
        window: Option<&Window>,
    ) -> [i64; N] {
        let mut q = self.base;
        for i in 0..N {
            q[i] += along(self.direction[i], x);
        }
        let start = Hat::new(head.d).bulge(x);
        if start > 0
            && let Some(before) = &self.before
        {
            for i in 0..N {
                q[i] += along(direction_bits(head.u[i] - before[i]), start);
            }
        }
        if let Some(next) = next {
            let end = Hat::new(next.d).bulge(head.bits - x);
            if end > 0 {
                for i in 0..N {
                    q[i] += along(direction_bits(next.u[i] - head.u[i]), end);
                }
            }
        }
        if let Some(window) = window {
            let (from, to) = match (window.passed, &self.before, next) {
                (true, Some(before), _) => (before, &head.u),
                (false, _, Some(next)) => (&head.u, &next.u),
                _ => return q,
            };
            // The triangle in time, as a length at the speed of the passage.
            let half = profile::way(window.v, window.half);
            let beside = profile::way(window.v, window.t.abs());
            let round = Hat::new(profile::length_of(half)).bulge(beside);
            if round > 0 {
                for i in 0..N {
                    q[i] += along(direction_bits(to[i] - from[i]), round);
                }
            }
        }
        q
    }
}
