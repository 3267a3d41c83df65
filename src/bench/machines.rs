//! Poses to joints.

use core::hint::black_box;

use hexstep::cycles::drill_point::{Cycle, Drill, Parameters};
use hexstep::cycles::mirror_trim::{self, Flags, Trimmer};
use hexstep::geometry::{Pose, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::machines::arm::{Arm, Branches as ArmBranches};
use hexstep::machines::drill_grinder::DrillGrinder;
use hexstep::machines::five_axis::{self, Branches, FiveAxis, Solution, Turned};
use hexstep::machines::two_sided::{self, Pair, PairSolution};
use hexstep::math::Real;

use crate::{ROUNDS, share};

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

/// Tool direction to both pairs of rotary angles.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_five_axis_solve(
    machine: &FiveAxis<f32>,
    v: Vector<f32>,
    near: &[Turned<f32>; 2],
) -> Branches<f32> {
    machine.branches(v, near)
}

/// Tool tip and direction to five joints: both solutions, the choice, the linear part.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_five_axis_full(
    machine: &FiveAxis<f32>,
    p: Vector<f32>,
    v: Vector<f32>,
    near: &[Turned<f32>; 2],
) -> Option<Solution<f32>> {
    machine.inverse(p, v, near).ok()
}

/// Flange pose to all eight branches.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_arm_ik(
    arm: &Arm<f32>,
    pose: &Pose<f32>,
    near: &Joints<6, f32>,
) -> Option<ArmBranches<f32>> {
    arm.inverse(pose, Some(near)).ok()
}

/// A place of the panel to the joints of both five-axis sides.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_mirror_pair(
    pair: &Pair<5, 5, f32>,
    at: &Place,
    near: &PairSolution<5, 5, f32>,
) -> Option<PairSolution<5, 5, f32>> {
    pair.solve(at.p, at.n, at.d, (&near.mill.q, &near.support.q))
        .ok()
}

/// A reading of the panel's shift to the offset of both sides.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_trim_tick(trimmer: &mut Trimmer<f32>, measured: Option<f32>) -> (f32, Flags) {
    trimmer.tick(measured)
}

/// A whole control tick: the trimmer, both sides' joints, their trims with every check, and the sum.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_trim_full_tick(
    (pair, trimmer): (&Pair<5, 5, f32>, &mut Trimmer<f32>),
    measured: Option<f32>,
    at: &Place,
    near: &PairSolution<5, 5, f32>,
) -> Option<(Joints<5, f32>, Joints<5, f32>)> {
    let (delta, flags) = trimmer.tick(measured);
    if flags.contains(Flags::FAULT) {
        return None;
    }
    let path = pair
        .solve(at.p, at.n, at.d, (&near.mill.q, &near.support.q))
        .ok()?;
    let (mill, support) = (path.mill.q, path.support.q);
    let trim = pair.trim(at.n, delta, (&mill, &support)).ok()?;
    Some((
        mill.zip_map(&trim.mill, |q, trim| q + trim),
        support.zip_map(&trim.support, |q, trim| q + trim),
    ))
}

/// Poses of a stroke, one after the other.
#[inline(never)]
pub fn drill_grinder() {
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
        let Some(joints) = bench_drill_pose(black_box(&machine), black_box(&pose), &near) else {
            panic!("a pose was refused");
        };
        near = black_box(joints);
    }
}

/// Tilts from 3 to 60 deg all round, on a head, two tables and the slanted machine, all with pivots and travel.
#[inline(never)]
pub fn five_axis() {
    for name in ["head_ca", "table_ac", "mixed_cb", "s45"] {
        let Some(mut definition) = five_axis::preset::<f32>(name) else {
            panic!("no such preset");
        };
        definition.q1 = Vector::new(10.0, -20.0, -150.0);
        definition.q2 = Vector::new(-5.0, 15.0, 230.0);
        definition.t0 = Vector::new(0.0, 0.0, 40.0);
        definition.w0 = Vector::new(100.0, 50.0, -30.0);
        let reach = Some([-2000.0, 2000.0]);
        let turning = Some([-7.0, 7.0]);
        definition.limits = [reach, reach, reach, turning, turning];
        let Ok(machine) = FiveAxis::new(&definition) else {
            panic!("no such machine");
        };
        let mut near = [Turned::default(); 2];
        for round in 0..ROUNDS / 4 {
            let (tilt, around) = (0.05 + share(round, 5), round as f32 * 0.4);
            let ((st, ct), (sa, ca)) = (tilt.sin_cos(), around.sin_cos());
            let v = black_box(Vector::new(st * ca, st * sa, ct));
            let p = black_box(Vector::new(120.0 * ca, 90.0 * sa, 10.0 * share(round, 7)));
            let branches = bench_five_axis_solve(black_box(&machine), v, &near);
            let _ = black_box(branches);
            let Some(solution) = bench_five_axis_full(black_box(&machine), p, v, &near) else {
                panic!("a pose was refused");
            };
            near = black_box(solution).rotary;
        }
    }
}

/// Poses all over the work space, each within a few degrees of the next.
#[inline(never)]
pub fn arm() {
    let arm = Arm::<f32>::er3b();
    let mut near = Joints([0.0; 6]);
    for round in 0..ROUNDS {
        let (a, b, c) = (share(round, 64), share(round, 9), share(round, 5));
        let q = Joints([
            2.4 * a - 1.2,
            -1.2 + 0.6 * b,
            0.3 + 0.5 * c,
            1.5 * b - 0.7,
            0.4 + 0.8 * a,
            2.0 * c - 1.0,
        ]);
        let pose = arm.forward(&q);
        let branches = bench_arm_ik(black_box(&arm), black_box(&pose), &near);
        if black_box(branches).is_none() {
            panic!("a pose was refused");
        }
        near = q;
    }
}

/// The support's point [mm], the normal and the wall [mm].
struct Place {
    p: Vector<f32>,
    n: Vector<f32>,
    d: f32,
}

/// Rows over a panel that is curved both ways, with readings that wander, one in eight missing, one in eight far off.
#[inline(never)]
pub fn two_sided() {
    let Ok(pair) = two_sided::m5::<f32>() else {
        panic!("no such machine");
    };
    let parameters = mirror_trim::Parameters {
        dt: 0.01,
        tau: 0.2,
        amount: 0.2,
        rate: 0.5,
        gate: 0.25,
        miss_max: 5,
    };
    let (Ok(mut alone), Ok(mut within)) = (Trimmer::new(&parameters), Trimmer::new(&parameters))
    else {
        panic!("no such trimmer");
    };
    let start = Place {
        p: Vector::ZERO,
        n: Vector::Z,
        d: 1.5,
    };
    let zero = Joints([0.0; 5]);
    let Ok(mut near) = pair.solve(start.p, start.n, start.d, (&zero, &zero)) else {
        panic!("a place was refused");
    };
    for round in 0..ROUNDS {
        let (x, y) = (600.0 * share(round, 16) - 300.0, 40.0 * (round / 16) as f32);
        let at = Place {
            p: Vector::new(x, y, -x * x / 8000.0 - y * y / 3000.0),
            n: Vector::new(x / 4000.0, y / 1500.0, 1.0),
            d: 1.5,
        };
        let Some(found) = bench_mirror_pair(black_box(&pair), black_box(&at), &near) else {
            panic!("a place was refused");
        };
        near = black_box(found);
        let measured = match round % 8 {
            3 => None,
            6 => Some(1.0),
            _ => Some(0.15 * share(round, 6) + 0.003 * x / 300.0),
        };
        let _ = black_box(bench_trim_tick(&mut alone, black_box(measured)));
        let tick = (black_box(&pair), &mut within);
        let moved = bench_trim_full_tick(tick, black_box(measured), black_box(&at), &near);
        if black_box(moved).is_none() {
            panic!("a tick was refused");
        }
    }
}
