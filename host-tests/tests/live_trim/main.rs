//! Readings that arrive over the serial line while the Octopus's own firmware runs a program in the emulator: how soon
//! they show in the pulses, and what the machine does when the sensor fails.
//!
//! ```text
//!  reading -> USART1 interrupt -> flag -> tick of the trimmer, behind a sample -> next sample -> queue, 5 ms -> pulses
//!             its tick is in the recording                                                        compared with memory
//! ```
//!
//! `cargo xtask test` builds the firmware and names it in `HEXSTEP_FIRMWARE_OCTOPUS`. Without that there is nothing to
//! boot, which the tests say; what they ask of the machine in memory they ask all the same.

#[path = "../common/mod.rs"]
mod common;
mod faults;
mod latency;
mod rig;
