//! The blocks of the look-ahead, oldest first, in a fixed array.

use super::block::{Block, Span};
use super::corner::Corner;

/// Blocks in the look-ahead, as many as motion.md asks for: lines of a curve are no shorter than a 48th of the way to a stop.
pub const BLOCKS: usize = 64;

/// Spans are numbered from the head: span 2k is the zone at the start of block k, 2k + 1 its body.
pub(super) struct Ring<const N: usize> {
    blocks: [Block<N>; BLOCKS],
    head: usize,
    len: usize,
}

impl<const N: usize> Ring<N> {
    pub const fn new() -> Self {
        Self {
            blocks: [Block::EMPTY; BLOCKS],
            head: 0,
            len: 0,
        }
    }

    pub fn len(&self) -> usize {
        self.len
    }

    pub fn is_full(&self) -> bool {
        self.len == BLOCKS
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Of block `k` <= [`BLOCKS`] in the array; without a division.
    fn place(&self, k: usize) -> usize {
        let place = self.head + k;
        if place < BLOCKS {
            place
        } else {
            place - BLOCKS
        }
    }

    pub fn get(&self, k: usize) -> Option<&Block<N>> {
        if k >= self.len {
            return None;
        }
        self.blocks.get(self.place(k))
    }

    pub fn get_mut(&mut self, k: usize) -> Option<&mut Block<N>> {
        if k >= self.len {
            return None;
        }
        let place = self.place(k);
        self.blocks.get_mut(place)
    }

    /// Nothing happens when full: the caller has looked.
    pub fn push(&mut self, block: Block<N>) {
        if self.len < BLOCKS {
            self.len += 1;
            if let Some(last) = self.get_mut(self.len - 1) {
                *last = block;
            }
        }
    }

    pub fn pop(&mut self) {
        if self.len > 0 {
            self.head = self.place(1);
            self.len -= 1;
        }
    }

    /// Takes the newest block out.
    pub fn drop_last(&mut self) {
        self.len = self.len.saturating_sub(1);
    }

    pub fn span(&self, i: usize) -> Option<&Span> {
        let block = self.get(i / 2)?;
        Some(if i.is_multiple_of(2) {
            &block.zone
        } else {
            &block.body
        })
    }

    pub fn span_mut(&mut self, i: usize) -> Option<&mut Span> {
        let block = self.get_mut(i / 2)?;
        Some(if i.is_multiple_of(2) {
            &mut block.zone
        } else {
            &mut block.body
        })
    }

    /// The corner that span `i` stands for, if it is one that is passed.
    pub fn corner_at(&self, i: usize) -> Option<&Corner> {
        if !i.is_multiple_of(2) {
            return None;
        }
        let corner = &self.get(i / 2)?.corner;
        corner.is_passed().then_some(corner)
    }

    pub fn corner_at_mut(&mut self, i: usize) -> Option<&mut Corner> {
        if !i.is_multiple_of(2) {
            return None;
        }
        let corner = &mut self.get_mut(i / 2)?.corner;
        corner.is_passed().then_some(corner)
    }
}
