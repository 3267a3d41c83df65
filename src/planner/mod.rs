//! Whole-step targets -> [`Block`]s -> a commanded position every millisecond: acceleration-limited, looking ahead.
//!
//! ```text
//!   speed rho        nominal ___________
//!   (1 = the fastest  /                 \___ junction ___
//!    joint at its    /                                   \        each block: rho^2 changes by at most
//!    limit)     ____/                                     \____   2 alpha * length; the last one ends at 0
//!               entry
//! ```
//!
//! The length of a block is the time [s] that its slowest joint needs at its velocity limit, so `rho <= 1` keeps every
//! velocity limit. Passes, in order: `push` sets a block's own limits and the speed allowed at its first corner
//! ([`block`]); [`look_ahead`] goes backward and then forward over all blocks not yet begun; [`profile`] runs through
//! them a millisecond at a time. The plan always ends in a standstill: when input pauses, the motors stop on the path.
//!
//! Limits kept: each joint's velocity; each joint's acceleration, counted over a millisecond, where the corners of the
//! polyline take one quarter and the change of speed three. Jerk is not limited here; `profile` is the place for it.

pub mod block;
pub mod look_ahead;
pub mod profile;

pub use block::{Block, LimitError, Limits};
pub use profile::Sample;

use crate::stepper::segmenter::Full;
use heapless::Deque;
use profile::Run;

/// Blocks that the planner looks ahead over.
pub const BLOCKS: usize = 64;

/// Time between two samples [s], and how many there are in a second.
pub const SAMPLE: f32 = 1e-3;
pub const SAMPLES_PER_SECOND: u32 = 1000;

/// Blocks ahead of N motors, and the one that runs.
pub struct Planner<const N: usize> {
    limits: Limits<N>,
    blocks: Deque<Block<N>, BLOCKS>,
    /// Where the last block pushed ends [steps].
    end: [i32; N],
    run: Run<N>,
}

impl<const N: usize> Planner<N> {
    /// At rest at `start` [steps].
    pub fn new(limits: Limits<N>, start: [i32; N]) -> Self {
        Self {
            limits,
            blocks: Deque::new(),
            end: start,
            run: Run::new(start),
        }
    }

    /// A straight move in joint space to `target` [steps], taking `duration` [s] at the least (0: as fast as the limits
    /// allow). A move to the present end does nothing. [`Full`] while the look-ahead has no room.
    pub fn push(&mut self, target: [i32; N], duration: f32) -> Result<(), Full> {
        if self.blocks.is_full() {
            return Err(Full);
        }
        let Some(mut block) = Block::new(&self.limits, self.end, target, duration) else {
            return Ok(());
        };
        block.entry_limit = match self.blocks.back() {
            Some(before) => block::junction(&self.limits, before, &block),
            None => 0.0,
        };
        self.end = target;
        // There is room: it was checked above.
        let _ = self.blocks.push_back(block);
        self.run.plan(&mut self.blocks);
        Ok(())
    }

    /// The commanded position one millisecond on; `None` at rest with nothing to do.
    // Not an iterator: after `None` more may come.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Option<Sample<N>> {
        self.run.next(&mut self.blocks)
    }

    /// Whether nothing moves and nothing is planned.
    pub fn is_idle(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Whether a push would find no room.
    pub fn is_full(&self) -> bool {
        self.blocks.is_full()
    }

    /// Blocks that could be pushed now.
    pub fn room(&self) -> usize {
        BLOCKS - self.blocks.len()
    }

    /// Where the last block pushed ends [steps].
    pub fn end(&self) -> [i32; N] {
        self.end
    }

    /// Drops everything; the motors stand at `position` [steps]. For a stop that was made without the planner.
    pub fn reset(&mut self, position: [i32; N]) {
        self.blocks.clear();
        self.end = position;
        self.run = Run::new(position);
    }

    /// New limits; for blocks pushed from now on.
    pub fn set_limits(&mut self, limits: Limits<N>) {
        self.limits = limits;
    }
}
