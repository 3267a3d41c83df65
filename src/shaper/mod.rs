//! Commanded positions -> the same, shaped so that they do not excite a vibration: one sample in, one out.
//!
//! ```text
//!                  +--> w0 p(t) + w1 p(t - d1) + ...  = first --> the same again = second --> out
//!   p(t) --> ring -+                                                (a second vibration, if there is one)
//!                  the last samples
//!
//!   out = p(t) - sum_a v_a ( sum_b w_b (p(t) - p(t - a - b)) )        sums of 2^-30 weights, exactly 1
//! ```
//!
//! Every difference is 0 once the command has rested for the length of the shaper: the end is the command's own, to the
//! last bit, and so is every count. Weights are computed when settings change ([`design`]); here all is integers, the
//! same on host and target.
//!
//! **In step.** A shaper delays by its mean, `T/4` for ZV, `T/2` for the others without damping. All joints get the mean
//! of the slowest: those with less are delayed by whole samples and a share of one. So joints stay in step as long as
//! speeds are even; where they change, each joint rounds its own way, and the tool leaves the path by as much as the
//! report of a path tells; a joint that turns round without a rest does so short of its point. The same shaper on all joints keeps straight lines straight.
//!
//! **Memory.** A ring for each joint, as long as its shaper, of 32-bit positions at a scale by which the joint's fastest
//! way through its ring fits; differences wrap rightly. All rings share [`HISTORY`] samples a joint. Without damping that is
//! ZVD or EI on all joints down to 12.9 Hz, on one of six, the others delayed, down to 7.5 Hz; ZV down to half of that.
//!
//! Runs in the foreground, between planner and segmenter. Cost of a joint and millisecond: nine products for one
//! vibration, 54 for two, at most; none when off or at rest.
#![deny(clippy::float_arithmetic)]

// Weights are worked out in floats when settings change; the filter below knows none.
#[allow(clippy::float_arithmetic)]
pub mod design;
#[allow(clippy::float_arithmetic)]
mod taps;

pub use design::{Kind, Mode, Reason};
pub use taps::{Design, HISTORY, LONGEST, Refusal, Wish};

use fixed::types::I32F32;
use taps::{Joint, WEIGHT_BITS};

/// Shapes the positions of N joints.
pub struct Shaper<const N: usize> {
    design: Design<N>,
    /// The joints' rings, one behind the other.
    rings: [[i32; N]; HISTORY],
    /// Where the newest sample of each is.
    at: [u8; N],
    /// Samples until the ring holds but one position.
    left: u8,
    /// The newest sample of the command.
    newest: [I32F32; N],
}

impl<const N: usize> Shaper<N> {
    /// Off, at rest at 0.
    pub const fn new() -> Self {
        Self {
            design: Design::OFF,
            rings: [[0; N]; HISTORY],
            at: [0; N],
            left: 0,
            newest: [I32F32::ZERO; N],
        }
    }

    /// Other shapers. Only at rest: what is under way ends where it is.
    pub fn set(&mut self, design: Design<N>) {
        self.design = design;
        self.at = [0; N];
        self.left = 0;
    }

    /// Forgets what is under way, after a stop at once.
    pub fn clear(&mut self) {
        self.left = 0;
    }

    /// Whether the output rests where the command does.
    pub fn is_settled(&self) -> bool {
        self.left == 0
    }

    /// Where a command begins, if the one before has been shaped to its end.
    pub fn begin_at(&mut self, position: &[I32F32; N]) {
        if self.left == 0 {
            self.newest = *position;
        }
    }

    /// A millisecond of the command [steps]; the shaped one.
    pub fn push(&mut self, position: &[I32F32; N]) -> [I32F32; N] {
        let moved = *position != self.newest;
        if self.design.length == 0 || self.left == 0 && !moved {
            return *position;
        }
        let begins = self.left == 0;
        self.left = if moved {
            self.design.length
        } else {
            self.left - 1
        };
        let mut shaped = *position;
        let mut rings = self.rings.as_flattened_mut();
        for (i, joint) in self.design.joints.iter().enumerate() {
            let (ring, others) = rings.split_at_mut(joint.samples.into());
            rings = others;
            if begins {
                ring.fill(joint.scaled(self.newest[i]));
            }
            let next = self.at[i] + 1;
            self.at[i] = if next < joint.samples { next } else { 0 };
            let at = usize::from(self.at[i]);
            if let Some(newest) = ring.get_mut(at) {
                *newest = joint.scaled(position[i]);
            }
            shaped[i] = I32F32::from_bits(position[i].to_bits() - joint.behind(ring, at));
        }
        self.newest = *position;
        shaped
    }
}

impl Joint {
    /// A position as the ring holds it: the low bits of what may be far away.
    fn scaled(&self, position: I32F32) -> i32 {
        (position.to_bits() >> self.shift) as i32
    }

    /// How far the output is behind its command [2^-32 steps]; the newest sample stands `at` a place of the ring.
    fn behind(&self, ring: &[i32], at: usize) -> i64 {
        let ago = |delay: usize| {
            // Delays add up to less than the ring has.
            let place = if delay <= at { at } else { at + ring.len() };
            ring.get(place - delay).copied().unwrap_or(0)
        };
        let now = ago(0);
        // A difference is below 2^31, its mean by positive weights of sum 2^30 below 2^61.
        let mean = |from: usize| -> i64 {
            let terms = self.first.iter();
            let terms = terms
                .map(|(delay, weight)| i64::from(now.wrapping_sub(ago(from + delay))) * weight);
            terms.sum()
        };
        if self.second.count == 1 {
            // Units of 2^(shift - 32 - 30) steps; the shift is 23 at most.
            return mean(0) >> (WEIGHT_BITS - u32::from(self.shift));
        }
        // Two bits more than the ring has: the mean of both stays below 2^63.
        let terms = self.second.iter();
        let terms = terms.map(|(delay, weight)| (mean(delay) >> (WEIGHT_BITS - 2)) * weight);
        let both: i64 = terms.sum();
        both >> (WEIGHT_BITS + 2 - u32::from(self.shift))
    }
}

impl<const N: usize> Default for Shaper<N> {
    fn default() -> Self {
        Self::new()
    }
}
