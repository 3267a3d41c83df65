//! Boards: all that is written for one circuit board. Modules of the binary; the library cannot see them.
//!
//! A board is a pin table (`skr_pro.rs`) on a chip (`stm32f407/`). A new board on the same chip is one file, one
//! line here and one feature in `Cargo.toml`.
//!
//! `unsafe` occurs in this folder alone. Each use is preceded by the fact that makes it sound.

pub mod stm32f407;

#[cfg(feature = "skr-pro")]
#[path = "skr_pro.rs"]
mod board;

#[cfg(feature = "octopus")]
#[path = "octopus.rs"]
mod board;

/// The pins of the board this binary is built for.
pub use board::BOARD;

/// Motors of the board.
pub const MOTORS: usize = BOARD.motors.len();

/// What the machine on this board knows beyond grinding drills.
#[cfg(feature = "skr-pro-arm")]
pub type Processes = hexstep::program::processes::ArmProcesses;
#[cfg(feature = "octopus")]
pub type Processes = hexstep::program::processes::PairProcesses;
#[cfg(not(any(feature = "skr-pro-arm", feature = "octopus")))]
pub type Processes = hexstep::program::processes::NoProcesses;
