//! The foreground's costly functions, called one by one with interrupts never started, so that `cargo xtask bench` can
//! count their instructions in the emulator. Linked with the same profile as the firmware; never flashed.
//!
//! Each `bench_` function is called at least [`ROUNDS`] times on inputs that differ from call to call. The last one to be
//! called is [`end::bench_end`], once.
#![no_std]
#![no_main]
// The board comes along for its panic and fault handlers; the rest of it is not used here.
#![allow(dead_code)]

#[path = "../boards/mod.rs"]
mod boards;
mod cycles;
mod end;
mod machines;
mod motion;
mod processes;

use core::mem::MaybeUninit;

use boards::MOTORS;
use cortex_m_rt::entry;
use hexstep::planner::Planner;
use hexstep::stepper::{SegmentQueue, Segmenter};

/// Calls of each function.
const ROUNDS: u32 = 64;

#[entry]
fn main() -> ! {
    static mut SEGMENTS: SegmentQueue<MOTORS> = SegmentQueue::new();
    static mut SEGMENTER: MaybeUninit<Segmenter<MOTORS>> = MaybeUninit::uninit();
    static mut PLANNER: MaybeUninit<Planner<MOTORS>> = MaybeUninit::uninit();

    motion::turns(SEGMENTS);
    motion::segments(SEGMENTS, SEGMENTER);
    motion::dense_path(PLANNER);
    machines::drill_grinder();
    machines::five_axis();
    machines::arm();
    machines::two_sided();
    cycles::drill_point();
    cycles::precession();
    cycles::surface();
    processes::arm();
    processes::pair();
    end::bench_end();
    loop {
        cortex_m::asm::wfi();
    }
}

/// The round's place among `of` values from 0 to 1, over and over.
fn share(round: u32, of: u32) -> f32 {
    (round % of) as f32 / (of - 1) as f32
}
