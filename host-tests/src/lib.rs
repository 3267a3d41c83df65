//! The host side of hexstep: one more board, made of memory.

pub mod calc;
pub mod cli;
pub mod duel;
pub mod emulator;
pub mod export;
pub mod files;
pub mod flexible;
pub mod frechet;
pub mod job;
pub mod lines;
pub mod machine;
pub mod mirror;
pub mod pair;
pub mod pins;
pub mod plot;
pub mod poses;
pub mod process;
pub mod reference;
pub mod report;
pub mod run;
pub mod surface;
pub mod trace;
