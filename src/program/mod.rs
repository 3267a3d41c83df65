//! Words of a line -> what is to be done: letters with numbers, all or nothing.

pub mod drill;
pub mod list;
pub mod processes;
pub mod words;

pub use drill::{DrillWords, Refusal};
