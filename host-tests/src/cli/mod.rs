//! What the binary `hexstep` does, command by command.

pub mod run;
