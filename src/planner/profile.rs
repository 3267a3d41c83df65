//! Speed over time inside the blocks: runs through them one millisecond at a time.
//!
//! With `v` the speed now, `e` the planned exit speed and `L` what is left of the block, the next speed is the largest
//! `w <= v + alpha dt` from which `e` can still be reached:
//!
//! ```text
//!   L = (v + w) dt / 2 + (w^2 - e^2) / (2 alpha)
//! ```

use super::{BLOCKS, Block, SAMPLE, look_ahead};
use crate::math::Real;
use fixed::types::I32F32;
use heapless::Deque;

/// Where every motor is commanded to be at the end of a millisecond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample<const N: usize> {
    /// [steps]
    pub position: [I32F32; N],
    /// At rest there, on whole steps.
    pub last: bool,
}

/// What the planner is in the middle of.
pub(super) struct Run<const N: usize> {
    speed: f32,
    /// How far into the first block, in units of 2^-62 of it.
    done: u64,
    position: [I32F32; N],
}

const WHOLE: u64 = 1 << 62;

impl<const N: usize> Run<N> {
    pub fn new(start: [i32; N]) -> Self {
        Self {
            speed: 0.0,
            done: 0,
            position: start.map(I32F32::from_num),
        }
    }

    pub fn plan(&self, blocks: &mut Deque<Block<N>, BLOCKS>) {
        let left = blocks.front().map_or(0.0, |block| self.left(block));
        look_ahead::plan(blocks, self.speed, left);
    }

    /// What is left of the running block [s at speed 1].
    fn left(&self, block: &Block<N>) -> f32 {
        ((WHOLE - self.done) as f32) * (1.0 / WHOLE as f32) * block.length
    }

    pub fn next(&mut self, blocks: &mut Deque<Block<N>, BLOCKS>) -> Option<Sample<N>> {
        blocks.front()?;
        let mut time = SAMPLE;
        while let Some(block) = blocks.front() {
            let left = self.left(block);
            let a = block.acceleration;
            let half = 0.5 * a * time;
            // The equation of the head, solved for w.
            let square =
                half * half + block.exit * block.exit + 2.0 * a * left - a * self.speed * time;
            let braked = Real::sqrt(Real::max(square, 0.0)) - half;
            let goal = Real::min(
                Real::min(self.speed + a * time, block.nominal),
                Real::max(braked, 0.0),
            );
            let next = Real::max(goal, self.speed - a * time);
            let way = 0.5 * (self.speed + next) * time;
            if way < left && (next > 0.0 || self.speed > 0.0) && left > SETTLED * block.length {
                self.speed = next;
                self.done = (self.done + (way / block.length * WHOLE as f32) as u64).min(WHOLE);
                self.position = position(block, self.done);
                return Some(Sample {
                    position: self.position,
                    last: false,
                });
            }
            // The block is over within this sample; the next one has the rest of the time.
            let mean = 0.5 * (self.speed + block.exit);
            let used = if mean > 0.0 { left / mean } else { 0.0 };
            time = Real::max(time - used, 0.0);
            self.speed = block.exit;
            self.done = 0;
            self.position = block.end().map(I32F32::from_num);
            let stands = self.speed <= 0.0;
            blocks.pop_front();
            if stands {
                return Some(Sample {
                    position: self.position,
                    last: true,
                });
            }
        }
        self.speed = 0.0;
        Some(Sample {
            position: self.position,
            last: true,
        })
    }
}

/// A share of a block so small that it is over.
const SETTLED: f32 = 1e-7;

fn position<const N: usize>(block: &Block<N>, done: u64) -> [I32F32; N] {
    core::array::from_fn(|i| {
        // 31 bits of steps times 62 bits.
        let way = (i128::from(block.steps[i]) * i128::from(done)) >> 30;
        I32F32::from_bits((i64::from(block.start[i]) << 32).wrapping_add(way as i64))
    })
}
