//! The firmware: wiring only. Takes the board, splits the two queues, gives each context its ends, loops.
//!
//! | context | owns |
//! |---|---|
//! | step interrupt (never masked) | `Interpolator`, the pins |
//! | serial interrupt | `Receiver` |
//! | foreground, here | `Controller`, which owns everything else |
#![no_std]
#![no_main]

mod boards;

use boards::{MOTORS, Processes};
use core::mem::MaybeUninit;

use boards::stm32f407::{Hardware, REST_PERIOD};
use cortex_m_rt::entry;
use hexstep::controller::Controller;
use hexstep::planner::{Limits, Planner};
use hexstep::protocol::{ByteQueue, RealTime, Receiver};
use hexstep::stepper::{Interpolator, SegmentQueue, Shared, StepMode};

static REAL_TIME: RealTime = RealTime::new();
static SHARED: Shared = Shared::new();

#[entry]
fn main() -> ! {
    static mut BYTES: ByteQueue = ByteQueue::new();
    static mut SEGMENTS: SegmentQueue<MOTORS> = SegmentQueue::new();
    static mut PLANNER: MaybeUninit<Planner<MOTORS>> = MaybeUninit::uninit();
    static mut CONTROLLER: MaybeUninit<Controller<'static, Hardware, MOTORS, Processes>> =
        MaybeUninit::uninit();

    let (bytes_in, bytes_out) = BYTES.split();
    let (segments_in, segments_out) = SEGMENTS.split();
    let receiver = Receiver::new(bytes_in, &REAL_TIME);
    let interpolator = Interpolator::new(segments_out, &SHARED, StepMode::default(), REST_PERIOD);
    let Some(hardware) = Hardware::start(receiver, interpolator) else {
        panic!("started twice");
    };
    let planner = built(PLANNER, || Planner::new(Limits::default(), [0; MOTORS]));
    let controller = built(CONTROLLER, || {
        Controller::new(
            hardware,
            planner,
            bytes_out,
            &REAL_TIME,
            segments_in,
            &SHARED,
        )
    });
    loop {
        let moved = controller.poll();
        controller.board.poll();
        if !moved {
            controller.board.sleep();
        }
    }
}

/// Puts a large value into its place. Out of line: it is on the stack first, and two of them in one function would be
/// there together.
#[inline(never)]
fn built<T>(place: &'static mut MaybeUninit<T>, build: impl FnOnce() -> T) -> &'static mut T {
    place.write(build())
}
