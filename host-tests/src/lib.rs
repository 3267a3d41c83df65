//! The host side of hexstep: one more board, made of memory.

pub mod calc;
pub mod surface;
