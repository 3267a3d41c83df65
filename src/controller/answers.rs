//! Text on its way to the serial line.

use core::fmt::{Arguments, Result, Write};
use heapless::Deque;

/// Bytes of answers that can wait for the serial line.
const ANSWERS: usize = 2048;

/// The longest answer to one line: all settings.
pub(super) const LONGEST_ANSWER: usize = 1700;

/// What does not fit is cut off: every writer makes sure of its room first.
pub(super) struct Answers(Deque<u8, ANSWERS>);

impl Answers {
    pub const fn new() -> Self {
        Self(Deque::new())
    }

    pub fn room(&self) -> usize {
        ANSWERS - self.0.len()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn line(&mut self, text: Arguments<'_>) {
        let _ = self.write_fmt(text);
        let _ = self.write_str("\r\n");
    }

    /// Hands bytes over as long as they are taken; whether any was.
    pub fn send(&mut self, mut take: impl FnMut(u8) -> bool) -> bool {
        let before = self.0.len();
        while let Some(byte) = self.0.front() {
            if !take(*byte) {
                break;
            }
            self.0.pop_front();
        }
        self.0.len() != before
    }
}

impl Write for Answers {
    fn write_str(&mut self, text: &str) -> Result {
        text.bytes()
            .try_for_each(|byte| self.0.push_back(byte).map_err(|_| core::fmt::Error))
    }
}
