//! The foreground's costly functions, called one by one with interrupts never started, so that `cargo xtask bench` can
//! count their instructions in the emulator. Linked with the same profile as the firmware; never flashed.
//!
//! Each `bench_` function is called [`ROUNDS`] times on inputs that differ from call to call; the last one last.
#![no_std]
#![no_main]
// The board comes along for its panic and fault handlers; the rest of it is not used here.
#![allow(dead_code)]

mod boards;

use core::hint::black_box;
use core::mem::MaybeUninit;

use boards::MOTORS;
use cortex_m_rt::entry;
use fixed::types::I32F32;
use hexstep::cycles::drill_point::{Cycle, Drill, Parameters, Solution};
use hexstep::cycles::surface_grinding::{Contact, Grinding, Job};
use hexstep::geometry::nurbs::{Nurbs, Section};
use hexstep::geometry::{Pose, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::machines::drill_grinder::DrillGrinder;
use hexstep::stepper::{SegmentQueue, SegmentSender, Segmenter, StepMode, Timing};

/// Calls of each function.
const ROUNDS: u32 = 64;
const TICK_HZ: u32 = 168_000_000;

/// Grinding parameters from a drill's geometry.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_drill_solve(drill: &Drill<f32>, phi: f32) -> Option<Solution<f32>> {
    drill.solve(phi).ok()
}

/// Pose to six joints.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_drill_pose(
    machine: &DrillGrinder<f32>,
    pose: &Pose<f32>,
    near: &Joints<6, f32>,
) -> Option<Joints<6, f32>> {
    machine.inverse(pose, near).ok()
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

/// A point of a rational bicubic surface, its normal and its curvatures along a direction.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_nurbs_eval(surface: &Nurbs<f32, 8, 7>, u: f32, v: f32) -> Option<Section<f32>> {
    surface.shape(u, v).ok()?.along(1.0, 0.25)
}

/// The ellipse of contact.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_hertz(grinding: &Grinding<f32>, section: &Section<f32>) -> Option<Contact<f32>> {
    grinding.hertz.on(section).ok()
}

#[entry]
fn main() -> ! {
    static mut SEGMENTS: SegmentQueue<MOTORS> = SegmentQueue::new();
    static mut SEGMENTER: MaybeUninit<Segmenter<MOTORS>> = MaybeUninit::uninit();

    for round in 0..ROUNDS {
        let small = round as f32 * 0.001;
        let drill = Drill {
            diameter: 9.9 + small,
            web: 1.63,
            point_angle: 118f32.to_radians(),
            chisel_angle: 50f32.to_radians(),
            clearance: 10f32.to_radians() + small,
        };
        let _ = black_box(bench_drill_solve(
            black_box(&drill),
            black_box(30f32.to_radians()),
        ));
    }
    drill_poses();
    segments(SEGMENTS, SEGMENTER);
    surface();
    loop {
        cortex_m::asm::wfi();
    }
}

/// Poses of a stroke, one after the other.
fn drill_poses() {
    let drill = Drill {
        diameter: 9.9,
        web: 1.63,
        point_angle: 118f32.to_radians(),
        chisel_angle: 50f32.to_radians(),
        clearance: 10f32.to_radians(),
    };
    let Ok(machine) = DrillGrinder::new(drill.point_angle, 150.0, 40.0) else {
        panic!("no such machine");
    };
    let parameters = Parameters::new(drill, 30f32.to_radians(), machine.home_tip(), 0.3);
    let Ok(cycle) = Cycle::new(&parameters) else {
        panic!("no such cycle");
    };
    let mut near = Joints([0.0; 6]);
    for round in 0..ROUNDS {
        let pose = cycle.pose(round as f32 * 0.01, 0.1);
        if let Some(joints) = bench_drill_pose(black_box(&machine), black_box(&pose), &near) {
            near = black_box(joints);
        }
    }
}

/// A smooth path of six motors, up to 100 kHz, one of them turning round on the way.
fn segments(
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

/// Places all over a wavy part of 210 x 180 mm, and the contacts there.
fn surface() {
    let mut points = [Vector::ZERO; 56];
    let mut weights = [1.0; 56];
    for (i, (point, weight)) in (0u8..).zip(points.iter_mut().zip(&mut weights)) {
        let (along, across) = (f32::from(i / 7), f32::from(i % 7));
        let height = f32::from(i * 37 % 11);
        *point = Vector::new(30.0 * along, 30.0 * across, height);
        *weight = 1.0 + 0.02 * height;
    }
    let knots_u = [0.0, 0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0];
    let knots_v = [0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0];
    let surface = Nurbs::new([3, 3], [8, 7], [&knots_u, &knots_v], &points, &weights);
    let (Ok(surface), Ok(grinding)) = (surface, Grinding::new(&Job::hard())) else {
        panic!("no such surface");
    };
    for round in 0..ROUNDS as u8 {
        let (u, v) = (f32::from(round % 8) / 7.0, f32::from(round / 8) / 7.0);
        let section = bench_nurbs_eval(&surface, black_box(u), black_box(v));
        let _ = black_box(section);
    }
    // Relative curvatures from 1 : 1.4 to 1 : 40, at all angles.
    for round in 0..ROUNDS as u8 {
        let (x, y) = (f32::from(round % 8) / 7.0, f32::from(round / 8) / 7.0);
        let section = Section {
            feed: Vector::X,
            cross: Vector::Y,
            k_f: 0.02 * x - 0.01,
            k_c: 0.08 * y * y - 0.0175,
            tau: 0.008 * (x - y),
        };
        let _ = black_box(bench_hertz(black_box(&grinding), black_box(&section)));
    }
}
