//! The foreground's work on a process: points put in, and their blocks one by one, looked at first, then on their way.
//!
//! Each machine is fed as the controller feeds it: the next line comes as soon as the one before is answered, so it waits
//! until the blocks of that one are gone. Each process runs as it usually does, then over stretches that need many parts,
//! and last with a tolerance below all rounding, where one call halves a stretch down to its finest part before it refuses
//! the point: more than that there is not to do in a call.

use core::fmt::{self, Write};
use core::hint::black_box;

use hexstep::error::Error;
use hexstep::joints::Joints;
use hexstep::path::Scale;
use hexstep::program::processes::{
    ArmProcesses, Order, PairProcesses, Processes, Progress, Standing,
};

/// A block of precession.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_precession_block(arm: &mut ArmProcesses, out: &mut dyn Write) -> Progress<6> {
    arm.next(out)
}

/// A block of grinding. In another order than the function above: of two that are the same the linker would keep one.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_grinding_block(out: &mut dyn Write, arm: &mut ArmProcesses) -> Progress<6> {
    arm.next(out)
}

/// A block of both sides.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_mirror_block(pair: &mut PairProcesses, out: &mut dyn Write) -> Progress<8> {
    pair.next(out)
}

/// A line with a point for the arm.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_arm_point(
    arm: &mut ArmProcesses,
    value: &str,
    out: &mut dyn Write,
) -> Result<Order, Error> {
    Processes::<6>::obey(arm, "POINT", Some(value), false, out)
}

/// A line with a point for the pair.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_pair_point(
    pair: &mut PairProcesses,
    value: &str,
    out: &mut dyn Write,
) -> Result<Order, Error> {
    Processes::<8>::obey(pair, "POINT", Some(value), false, out)
}

/// What is said is not listened to.
struct Nobody;

impl Write for Nobody {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        black_box(text);
        Ok(())
    }
}

/// How near the tip keeps to its path [mm]: as delivered, for many parts, and below what rounding leaves.
const USUAL: f32 = 0.05;
const FINE: f32 = 0.005;
const TOO_FINE: f32 = 2e-5;

/// A ball over the edge of a hill, carried and locked.
const PRECESSION: [&str; 12] = [
    "PRECESS=T20,V5,W30,L127,E0.05",
    "PRECESS=RUN",
    "POINT=0,0,0,0,0,1",
    "POINT=12,0,0,0,0,2",
    "POINT=16,2,-0.4,0.1,0,1",
    "POINT=16,6,-0.6,0.1,0.05,1",
    "POINT=END",
    "PRECESS=F1,M1,P20",
    "PRECESS=RUN",
    "POINT=0,0,0,0,0,1",
    "POINT=8,3,-0.2,0.1,0,1",
    "POINT=END",
];

/// Poses far apart: each stretch of the joints has many parts.
const LONG_PRECESSION: [&str; 6] = [
    "PRECESS=F0,M0,W5,V40,E30,D90,X10",
    "PRECESS=RUN",
    "POINT=0,-60,0,0,0,1",
    "POINT=60,0,-10,0.3,0,1",
    "POINT=0,60,0,-0.1,0.2,1",
    "POINT=END",
];

const SHORT_PRECESSION: [&str; 4] = [
    "PRECESS=F0,M0,W5,V40,E30,D90,X0.02",
    "PRECESS=RUN",
    "POINT=0,0,0,0,0,1",
    "POINT=4,0,0,0,0,1",
];

/// Rows there and back on a curved part.
const GRINDING: [&str; 9] = [
    "SURF=P0.05,Z1",
    "SURF=RUN",
    "POINT=0,0,0,0,0,1,1,0,0,0.005,-0.003,0.001",
    "POINT=20,0,-1,0.1,0,1,1,0,-0.1,0.004,-0.002,0.001",
    "POINT=40,1,-4,0.2,0,1,1,0,-0.2,0.002,-0.001,0.002",
    "POINT=ROW",
    "POINT=40,3,-4,0.2,0,1,-1,0,0.2,0.005,-0.003,0.001",
    "POINT=0,3,0,0,0,1,-1,0,0,0.005,-0.003,0.001",
    "POINT=END",
];

/// Across the work space in one stretch, and round while the place hardly changes.
const LONG_GRINDING: [&str; 6] = [
    "SURF=P0",
    "SURF=RUN",
    "POINT=-60,-150,0,-0.2,0.1,1,1,0,0.2",
    "POINT=90,150,-30,0.2,-0.1,1,0,1,0.1",
    "POINT=91,150,-30,0.2,-0.1,1,1,0.2,-0.18",
    "POINT=END",
];

const SHORT_GRINDING: [&str; 4] = [
    "SURF=P0.05",
    "SURF=RUN",
    "POINT=0,0,0,0,0,1,1,0,0,0.005,-0.003,0.001",
    "POINT=4,0,-0.1,0.01,0,1,1,0,0,0.005,-0.003,0.001",
];

/// A row of the panel of 1000 x 750 mm with a radius of 4000 mm, and a piece of one beside it.
const MIRROR: [&str; 12] = [
    "MIRROR=V100",
    "MIRROR=ON,1.5",
    "POINT=-450,100,-25.3931,-450,0,3974.607",
    "POINT=-300,100,-11.2659,-300,0,3988.734",
    "POINT=-150,100,-2.8135,-150,0,3997.187",
    "POINT=0,100,0,0,0,4000",
    "POINT=150,100,-2.8135,150,0,3997.187",
    "POINT=450,100,-25.3931,450,0,3974.607",
    "POINT=ROW",
    "POINT=300,140,-11.2659,300,0,3988.734",
    "POINT=150,140,-2.8135,150,0,3997.187",
    "POINT=END",
];

/// Nearly the whole travel of the turning axes in one stretch.
const LONG_MIRROR: [&str; 5] = [
    "MIRROR=V100",
    "MIRROR=ON,2.2",
    "POINT=-400,100,0,-0.4,0.02,1",
    "POINT=400,300,0,0.4,0.1,1",
    "POINT=END",
];

const SHORT_MIRROR: [&str; 4] = [
    "MIRROR=V100",
    "MIRROR=ON,1.5",
    "POINT=0,100,0,0,0,1",
    "POINT=40,100,-1,0.05,0.02,1",
];

/// A machine that stands at home.
fn standing<const N: usize>(
    steps_per_unit: [f32; N],
    travel: [[f32; 2]; N],
    speeds: [f32; N],
    tolerance: f32,
) -> Standing<N> {
    let end = |k: usize| core::array::from_fn(|i| (travel[i][k] * steps_per_unit[i]) as i32);
    Standing {
        scale: Scale {
            steps_per_unit: Joints(steps_per_unit),
            lower: end(0),
            upper: end(1),
        },
        at: [0; N],
        speeds,
        tolerance,
    }
}

/// Says the lines of a run; whether all points were taken.
fn run<P: Processes<N>, const N: usize>(
    processes: &mut P,
    standing: &Standing<N>,
    lines: &[&str],
    point: impl Fn(&mut P, &str, &mut dyn Write) -> Result<Order, Error>,
    next: impl Fn(&mut P, &mut dyn Write) -> Progress<N>,
) -> bool {
    let mut is_running = false;
    for line in lines {
        let (name, value) = line.split_once('=').unwrap_or((line, ""));
        let order = match name {
            "POINT" => point(processes, black_box(value), &mut Nobody),
            _ => processes.obey(name, Some(value), true, &mut Nobody),
        };
        match order {
            Ok(Order::Run { .. }) => {
                if processes.start(standing, &mut Nobody).is_err() {
                    panic!("a process does not start");
                }
                is_running = true;
            }
            // Its answer is waited for, not its blocks.
            Ok(Order::Point) => loop {
                match black_box(next(processes, &mut Nobody)) {
                    Progress::Taken => break,
                    Progress::Refused(_) => {
                        processes.stop();
                        return false;
                    }
                    Progress::Over => panic!("a process ends early"),
                    _ => {}
                }
            },
            Ok(_) => {}
            Err(_) => panic!("a line was refused"),
        }
        if is_running && value == "END" {
            while black_box(next(processes, &mut Nobody)) != Progress::Over {}
            processes.stop();
            is_running = false;
        }
    }
    true
}

/// The ER3B with a tool of 160 mm.
#[inline(never)]
pub fn arm() {
    let mut arm = ArmProcesses::default();
    for (name, value) in [("KIN.TOOL", "160"), ("KIN.WORK", "310,0,200")] {
        if Processes::<6>::obey(&mut arm, name, Some(value), true, &mut Nobody).is_err() {
            panic!("no such arm");
        }
    }
    let degrees = |of: [f32; 6]| of.map(f32::to_radians);
    let (lower, upper) = (
        degrees([-175.0, -142.0, -73.0, -178.0, -132.0, -720.0]),
        degrees([175.0, 64.0, 165.0, 178.0, 132.0, 720.0]),
    );
    let at = |tolerance| {
        standing(
            [2500.0, 2500.0, 2500.0, 2000.0, 2000.0, 1500.0].map(f32::to_degrees),
            core::array::from_fn(|i| [lower[i], upper[i]]),
            degrees([60.0, 60.0, 60.0, 75.0, 75.0, 90.0]),
            tolerance,
        )
    };
    for (lines, tolerance) in [
        (&PRECESSION[..], USUAL),
        (&LONG_PRECESSION, FINE),
        (&SHORT_PRECESSION, TOO_FINE),
    ] {
        let is_taken = run(
            &mut arm,
            &at(tolerance),
            lines,
            bench_arm_point,
            bench_precession_block,
        );
        if is_taken != (tolerance > TOO_FINE) {
            panic!("a precession was misjudged");
        }
    }
    for (lines, tolerance) in [
        (&GRINDING[..], USUAL),
        (&LONG_GRINDING, FINE),
        (&SHORT_GRINDING, TOO_FINE),
    ] {
        let is_taken = run(
            &mut arm,
            &at(tolerance),
            lines,
            bench_arm_point,
            |arm, out| bench_grinding_block(out, arm),
        );
        if is_taken != (tolerance > TOO_FINE) {
            panic!("a row was misjudged");
        }
    }
}

/// M4.
#[inline(never)]
pub fn pair() {
    let mut pair = PairProcesses::default();
    let turn = [-30f32.to_radians(), 30f32.to_radians()];
    let (y, z) = ([-100.0, 1000.0], [-200.0, 200.0]);
    let (per_side, speeds) = (
        [400.0, 400.0, 800.0, 5000f32.to_degrees()],
        [300.0, 300.0, 100.0, 20f32.to_radians()],
    );
    let both = |side: [f32; 4]| core::array::from_fn(|i| side[i % 4]);
    for (lines, tolerance) in [
        (&MIRROR[..], 0.2 * USUAL),
        (&LONG_MIRROR, FINE),
        (&SHORT_MIRROR, TOO_FINE),
    ] {
        let standing = standing(
            both(per_side),
            [[-100.0, 1300.0], y, z, turn, [-1300.0, 100.0], y, z, turn],
            both(speeds),
            tolerance,
        );
        let is_taken = run(
            &mut pair,
            &standing,
            lines,
            bench_pair_point,
            bench_mirror_block,
        );
        if is_taken != (tolerance > TOO_FINE) {
            panic!("a wall was misjudged");
        }
    }
}
