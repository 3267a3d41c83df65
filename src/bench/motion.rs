//! From joint targets to segments.

use core::hint::black_box;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use fixed::types::I32F32;
use hexstep::math::Real;
use hexstep::planner::{Limits, PathSetting, Planner, Sample};
use hexstep::stepper::port::PinAt;
use hexstep::stepper::{
    Channel, Interpolator, Kind, RegisterPort, Segment, SegmentQueue, SegmentSender, Segmenter,
    SetResetRegister, Shared, StepMode, StepTimer, Timing,
};

use crate::ROUNDS;
use crate::boards::{BOARD, MOTORS};

const TICK_HZ: u32 = 168_000_000;
/// Blocks of the dense path: six times the look-ahead, the last two thirds of them counted.
const BLOCKS: u32 = 600;
const WARM_UP: u32 = 200;

/// Registers of memory in place of those of the board's ports, and as many.
type Pins<'a> = RegisterPort<
    Register<'a>,
    { BOARD.step_ports().count },
    { BOARD.direction_ports().count },
    { 1 << MOTORS },
>;

#[derive(Clone, Copy)]
struct Register<'a>(&'a AtomicU32);

impl SetResetRegister for Register<'_> {
    #[inline(always)]
    fn write(&mut self, word: u32) {
        self.0.store(word, Relaxed);
    }
}

impl StepTimer for Register<'_> {
    #[inline(always)]
    fn set_period(&mut self, counts: u32) {
        self.0.store(counts.wrapping_sub(1) & 0x00FF_FFFF, Relaxed);
    }
}

/// What the step interrupt does in a tick.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_turn(
    interpolator: &mut Interpolator<'_, MOTORS>,
    pins: &mut Pins<'_>,
    timer: &mut Register<'_>,
) {
    interpolator.tick(pins, timer);
}

/// Ticks in each of which all motors turn round together and a latch is served: no tick has more to do.
#[inline(never)]
pub fn turns(queue: &mut SegmentQueue<MOTORS>) {
    const ALL: u8 = u8::MAX >> (8 - MOTORS);
    let (mut sender, receiver) = queue.split();
    let (shared, memory) = (Shared::new(), AtomicU32::new(0));
    let mut register = Register(&memory);
    let mut interpolator = Interpolator::new(receiver, &shared, StepMode::Pulse, 4200);
    // Which pin is whose makes no difference to the stores.
    let at = |ports: usize| {
        let pin = move |i: usize| PinAt {
            register: i % ports,
            pin: i as u8,
            inverted: false,
        };
        core::array::from_fn::<_, MOTORS, _>(pin)
    };
    let mut pins = Pins::new(
        [register; BOARD.step_ports().count],
        &at(BOARD.step_ports().count),
        [register; BOARD.direction_ports().count],
        &at(BOARD.direction_ports().count),
    );
    for round in 0..ROUNDS {
        let segment = Segment {
            ticks: 1,
            kind: Kind::Motion,
            directions: if round % 2 == 0 { ALL } else { 0 },
            period: 240 + round,
            channels: core::array::from_fn(|i| Channel {
                accumulator: !(round << i),
                increment: 1 << (20 + i),
            }),
        };
        if sender.enqueue(black_box(segment)).is_err() {
            panic!("the queue is full");
        }
        shared.latch();
        bench_turn(&mut interpolator, &mut pins, &mut register);
        if shared.latched().is_none() || !sender.is_empty() {
            panic!("the tick did something else");
        }
    }
}

/// One sample of the planner to one segment.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_segment(
    segmenter: &mut Segmenter<MOTORS>,
    target: &[I32F32; MOTORS],
    sender: &mut SegmentSender<'_, MOTORS>,
) -> bool {
    segmenter
        .advance(target, TICK_HZ / 1000, false, sender)
        .is_ok()
}

/// One block into the look-ahead.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_planner_push(planner: &mut Planner<MOTORS>, target: [I32F32; MOTORS], time: f32) -> bool {
    planner.push(target, time).is_ok()
}

/// One millisecond out of the planner.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_planner_next(planner: &mut Planner<MOTORS>) -> Option<Sample<MOTORS>> {
    planner.next()
}

/// A smooth path of six motors, up to 100 kHz, one of them turning round on the way.
#[inline(never)]
pub fn segments(
    queue: &'static mut SegmentQueue<MOTORS>,
    segmenter: &'static mut MaybeUninit<Segmenter<MOTORS>>,
) {
    let (mut sender, mut receiver) = queue.split();
    let timing = Timing::from_ns(TICK_HZ, 1000, 1000, 1000, StepMode::Pulse);
    let segmenter = segmenter.write(Segmenter::new(timing));
    let mut target = [I32F32::ZERO; MOTORS];
    for round in 0..ROUNDS as i32 {
        for (i, position) in (0..).zip(&mut target) {
            let speed = 10 * (i + 5) - if i == 3 { 3 * round } else { round / 8 * i };
            *position += I32F32::from_num(speed) + I32F32::from_bits(0x1234_5678);
        }
        let sent = bench_segment(segmenter, black_box(&target), &mut sender);
        if !black_box(sent) {
            panic!("the queue is full");
        }
        while receiver.dequeue().is_some() {}
    }
}

/// Chords of 1 mm on a winding curve at 1 m/s, which the joints do not allow: a block takes 1.7 ms. All joints move. The look-ahead is kept full, and the bends are too tight for chords to be merged, which
/// would spare the planner work.
#[inline(never)]
pub fn dense_path(planner: &'static mut MaybeUninit<Planner<MOTORS>>) {
    // 200 steps/mm, 20 m/s^2, 5000 m/s^3, 0.004 mm.
    let limits = Limits::new([300_000.0; MOTORS], [4.0e6; MOTORS], [1.0e9; MOTORS]);
    let path = PathSetting::new([1.0 / 200.0; MOTORS], 0.004);
    let (Ok(limits), Ok(path)) = (limits, path) else {
        panic!("no such limits");
    };
    let planner = planner.write(Planner::new(limits, [0; MOTORS]));
    if planner.set_path(path).is_err() {
        panic!("no such path");
    }
    let (mut heading, mut x, mut y) = (0.0f32, 0.0f32, 0.0f32);
    for round in 0..BLOCKS {
        let s = round as f32;
        // Radius 60 to 120 mm.
        heading += (3.0 + Real::sin(s / 40.0)) / 240.0;
        x += 200.0 * Real::cos(heading);
        y += 200.0 * Real::sin(heading);
        let (a, b) = (1000.0 * Real::sin(heading), 700.0 * Real::cos(s / 29.0));
        let (z, c) = (700.0 * Real::sin(s / 31.0), 200.0 * Real::cos(s / 57.0));
        let all = [x, y, z, a, b, c, -x, c];
        let target =
            core::array::from_fn(|i| I32F32::from_num(all.get(i).map_or(0, |q| *q as i32)));
        let is_counted = round >= WARM_UP;
        while planner.is_full() {
            let sample = if is_counted {
                bench_planner_next(planner)
            } else {
                planner.next()
            };
            let _ = black_box(sample);
        }
        let taken = if is_counted {
            bench_planner_push(planner, black_box(target), black_box(0.001))
        } else {
            planner.push(target, 0.001).is_ok()
        };
        if !black_box(taken) {
            panic!("a block was refused");
        }
    }
    if planner.counters().merged > BLOCKS / 20 {
        panic!("the chords were merged");
    }
}
