//! Speeds at the corners: a backward pass so that every block can still slow down for what follows, then a forward pass
//! so that none starts faster than the one before it can get.

use super::Block;
use crate::math::Real;
use heapless::Deque;

/// Plans all blocks anew; the first one is at `speed` now and `left` of its length [s] is still to come.
pub fn plan<const N: usize, const B: usize>(
    blocks: &mut Deque<Block<N>, B>,
    speed: f32,
    left: f32,
) {
    let count = blocks.len();
    let mut exit = 0f32;
    for block in blocks.iter_mut().rev().take(count.saturating_sub(1)) {
        block.exit = exit;
        let reachable = Real::sqrt(exit * exit + 2.0 * block.acceleration * block.length);
        block.entry = Real::min(block.entry_limit, reachable);
        exit = block.entry;
    }
    let mut entry = speed;
    for (i, block) in blocks.iter_mut().enumerate() {
        if i == 0 {
            block.exit = exit;
        }
        let length = if i == 0 { left } else { block.length };
        block.entry = Real::min(block.entry, entry);
        let reachable = Real::sqrt(entry * entry + 2.0 * block.acceleration * length);
        block.exit = Real::min(block.exit, reachable);
        entry = block.exit;
    }
}
