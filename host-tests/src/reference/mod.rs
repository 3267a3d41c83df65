//! References in f64 that share no code with the library: what a result is compared with.

pub mod five_axis;
pub mod grinding;
pub mod matrix;
pub mod serial;
