//! Commanded positions -> the same, shaped so that they do not excite a vibration: one sample in, one out.
//!
//! ```text
//!                  +--> w0 p(t) + w1 p(t - d1) + ...  = first --> the same again = second --> out
//!   p(t) --> ring -+                                                (a second vibration, if there is one)
//!                  the last 128 samples
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
//! report of a path tells.
//!
//! **Memory.** The ring holds 32-bit positions at a scale by which the joint's fastest way through the ring fits;
//! differences wrap rightly. 128 samples hold ZVD and EI down to 8 Hz, ZV down to 4 Hz, two vibrations whose lengths
//! add up to 127 ms.
//!
//! Runs in the foreground, between planner and segmenter. Cost: about 10 instructions a weight, up to nine for one
//! vibration and 54 for two, each joint and millisecond; none when off.
#![deny(clippy::float_arithmetic)]

pub mod design;
mod taps;

pub use design::{Kind, Mode, Reason};
pub use taps::{Design, HISTORY, Refusal, Wish};

use fixed::types::I32F32;
use taps::{Joint, WEIGHT_BITS};

/// Shapes the positions of N joints.
pub struct Shaper<const N: usize> {
    design: Design<N>,
    ring: [[i32; N]; HISTORY],
    /// Where the newest sample is.
    at: usize,
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
            ring: [[0; N]; HISTORY],
            at: 0,
            left: 0,
            newest: [I32F32::ZERO; N],
        }
    }

    /// Other shapers. Only at rest: what is under way ends where it is.
    pub fn set(&mut self, design: Design<N>) {
        self.design = design;
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
        if self.left == 0 {
            let rest = self.design.scaled(&self.newest);
            self.ring.fill(rest);
        }
        self.left = if moved {
            self.design.length
        } else {
            self.left - 1
        };
        self.newest = *position;
        self.at = (self.at + 1) % HISTORY;
        if let Some(row) = self.ring.get_mut(self.at) {
            *row = self.design.scaled(position);
        }
        core::array::from_fn(|i| {
            let behind = self.behind(i);
            I32F32::from_bits(position[i].to_bits() - behind)
        })
    }

    /// How far a joint's output is behind its command [2^-32 steps].
    fn behind(&self, i: usize) -> i64 {
        let Joint {
            first,
            second,
            shift,
        } = &self.design.joints[i];
        let at = |delay: usize| {
            // Delays add up to less than HISTORY.
            let row = self.ring.get(self.at.wrapping_sub(delay) % HISTORY);
            row.map_or(0, |row| row[i])
        };
        let now = at(0);
        // A difference is below 2^31, its mean with positive weights of sum 2^30 below 2^61.
        let mean = |from: usize| -> i64 {
            let far = first
                .iter()
                .map(|(delay, weight)| i64::from(now.wrapping_sub(at(from + delay))) * weight);
            far.sum()
        };
        if second.count == 1 {
            // Units of 2^(shift - 32 - 30) steps; the shift is 22 at most.
            return mean(0) >> (WEIGHT_BITS - u32::from(*shift));
        }
        // Two bits more than the ring has, so that the mean of both stays below 2^63.
        let both = second
            .iter()
            .map(|(delay, weight)| (mean(delay) >> (WEIGHT_BITS - 2)) * weight);
        let both: i64 = both.sum();
        both >> (WEIGHT_BITS + 2 - u32::from(*shift))
    }
}

impl<const N: usize> Default for Shaper<N> {
    fn default() -> Self {
        Self::new()
    }
}
