//! From joint targets to segments.

use core::hint::black_box;
use core::mem::MaybeUninit;

use fixed::types::I32F32;
use hexstep::math::Real;
use hexstep::planner::{Limits, PathSetting, Planner, Sample};
use hexstep::stepper::{SegmentQueue, SegmentSender, Segmenter, StepMode, Timing};

use crate::ROUNDS;
use crate::boards::MOTORS;

const TICK_HZ: u32 = 168_000_000;
/// Blocks of the dense path: six times the look-ahead, the last two thirds of them counted.
const BLOCKS: u32 = 600;
const WARM_UP: u32 = 200;

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
