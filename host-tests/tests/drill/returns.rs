//! The ways between the strokes of the delivered job, by its pulses: fast, even, and clear of the wheel.

use crate::common::*;
use hexstep::cycles::drill_point::Cycle;
use hexstep::geometry::Vector;
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep_host::job::{DrillJob, Job, Task};
use hexstep_host::run;
use hexstep_host::trace::{TICK_HZ, seconds};
use std::ops::Range;

/// Where all joints are in every millisecond [mm, deg], the job, and how long it took [s].
struct Run {
    drill: DrillJob,
    at: Vec<[f64; 6]>,
    time: f64,
}

fn delivered() -> Run {
    let file = format!("{}/jobs/drill-point.toml", env!("CARGO_MANIFEST_DIR"));
    let job = Job::load(file.as_ref()).unwrap();
    let outcome = run::run(&job, &mut |_, _| {}).unwrap();
    let Task::DrillPoint(drill) = job.task else {
        panic!("a drill");
    };
    let steps = drill.axes.map(|axis| axis.steps_per_unit);
    let trace = outcome.trace;
    let at = trace.rebuilt_every(TICK_HZ / 1000).into_iter();
    Run {
        at: at
            .map(|row| std::array::from_fn(|i| row[i] / steps[i]))
            .collect(),
        drill: *drill,
        time: seconds(trace.end()),
    }
}

/// Milliseconds to each side over which a speed is measured: a step of the finest joint is 0.06 mm/s or deg/s then.
const SIDE: usize = 8;

impl Run {
    /// Speed of each joint at a millisecond [mm/s, deg/s].
    fn speed(&self, k: usize) -> [f64; 6] {
        let (a, b) = (k.saturating_sub(SIDE), (k + SIDE).min(self.at.len() - 1));
        std::array::from_fn(|i| (self.at[b][i] - self.at[a][i]) * 1e3 / (b - a).max(1) as f64)
    }

    /// The ways from the end of a stroke back to its start: d1 rises by most of its travel.
    fn returns(&self) -> Vec<Range<usize>> {
        let mut found = Vec::new();
        let mut from = None;
        for k in 0..self.at.len() {
            let rises = self.speed(k)[0] > 0.1;
            match from {
                None if rises => from = Some(k),
                Some(start) if !rises => {
                    if self.at[k][0] - self.at[start][0] > 30.0 {
                        found.push(start..k);
                    }
                    from = None;
                }
                _ => {}
            }
        }
        found
    }
}

/// Largest of a list, and the least between the first and the last place where it is at half of that.
fn plateau(speeds: &[f64]) -> (f64, f64) {
    let top = speeds.iter().copied().fold(0.0, f64::max);
    let fast = |v: &f64| *v >= 0.5 * top;
    let first = speeds.iter().position(fast).unwrap();
    let last = speeds.iter().rposition(fast).unwrap();
    let least = speeds[first..=last].iter().copied().fold(top, f64::min);
    (top, least)
}

/// At corners of 5 deg each joint swung between a twelfth of its speed and all of it.
#[test]
fn every_joint_returns_in_one_sweep() {
    let run = delivered();
    let returns = run.returns();

    assert_eq!(returns.len(), 26);
    for (index, range) in returns.iter().enumerate() {
        let speeds: Vec<[f64; 6]> = range.clone().map(|k| run.speed(k)).collect();
        for joint in 0..6 {
            let one: Vec<f64> = speeds.iter().map(|v| v[joint].abs()).collect();
            let (top, least) = plateau(&one);
            assert!(
                least >= 0.5 * top,
                "return {index}, joint {joint}: {least} of {top} /s"
            );
        }
        // 65 mm of d1 at 60 mm/s, and both ramps.
        let (top, least) = plateau(&speeds.iter().map(|v| v[0]).collect::<Vec<_>>());
        assert!(
            top > 59.0 && least > 29.0,
            "return {index}: {least} of {top} mm/s"
        );
        assert!(
            range.len() < 1300,
            "return {index} takes {} ms",
            range.len()
        );
    }
    assert!(run.time <= 232.0, "{} s", run.time);
}

/// A vector of the lip frame in machine axes at mu = 0.
fn machine_axes(v: Vector<f64>) -> Vector<f64> {
    Vector::new(v.z, -v.x, -v.y)
}

/// Points of both flanks from the tip, up to the heel, machine frame at mu = 0 [mm].
fn flanks(drill: &DrillJob) -> Vec<Vector<f64>> {
    let (solution, flank) = drill.wanted();
    let tip = solution.cone.tip_in_lip_frame();
    let mut points = vec![Vector::ZERO];
    let r0 = flank.half_web();
    let heel = drill.heel_angle.to_radians();
    for i in 1..=12 {
        let radius = 0.5 * drill.diameter * f64::from(i) / 12.0;
        for k in 0..=48 {
            // Behind the lip; in the core all around, as far as the other flank has left it.
            let (from, angle) = if radius > r0 {
                (-(r0 / radius).asin(), heel)
            } else {
                (0.0, std::f64::consts::TAU)
            };
            let azimuth = from + angle * f64::from(k) / 48.0;
            let (x, y) = (radius * azimuth.cos(), radius * azimuth.sin());
            let (Some(v), other) = (flank.point(x, y), flank.point(-x, -y)) else {
                continue;
            };
            if other.is_some_and(|other| other.z > v.z + 1e-9) {
                continue;
            }
            let v = v - tip;
            points.push(machine_axes(v));
            points.push(machine_axes(Vector::new(-v.x, -v.y, v.z)));
        }
    }
    assert!(points.len() > 500);
    points
}

/// The wheel's face is the plane that the finished flanks lie against.
#[test]
fn the_drill_comes_back_as_clear_of_the_wheel_as_it_was_drawn_back() {
    let run = delivered();
    let cycle = Cycle::new(&run.drill.parameters::<f64>()).unwrap();
    let arm = run.drill.arm::<f64>();
    let points = flanks(&run.drill);
    // Through the lip, with its slope m; the finished tip stands at home.
    let (s, c) = (0.5 * run.drill.point_angle).to_radians().sin_cos();
    let m = cycle.solution().m;
    let q = (1.0 + m * m * s * s).sqrt();
    let normal = machine_axes(Vector::new(-c, -m * s, s) * (1.0 / q));
    let apex = arm.home_tip() - machine_axes(cycle.solution().cone.tip_in_lip_frame());
    // What a stand-off along d2 keeps clear.
    let share = normal.dot(arm.away());
    let clear_of_wheel = |at: &[f64; 6]| {
        let q = Joints(std::array::from_fn(|i| {
            if i < 3 { at[i] } else { at[i].to_radians() }
        }));
        let pose = arm.forward(&q);
        let r = pose.rotation;
        let of = |v: &Vector<f64>| {
            let p = pose.p + (r.n * v.x + r.s * v.y + r.a * v.z) - apex;
            p.dot(normal)
        };
        points.iter().map(of).fold(f64::INFINITY, f64::min)
    };

    let (mut returning, mut turning) = (f64::INFINITY, f64::INFINITY);
    for (index, range) in run.returns().into_iter().enumerate() {
        let standoff = cycle.plan().standoff(index as u32 / 2);
        let wanted = share * (standoff + run.drill.clear);
        // In the stroke before, the flank lies against the wheel.
        let stroke = clear_of_wheel(&run.at[range.start - 1500]);
        assert_close(stroke, share * standoff, 0.01);
        // Then the drill turns over; the next way is by d2.
        for k in range.start.. {
            let off = clear_of_wheel(&run.at[k]) - wanted;
            if range.contains(&k) {
                returning = returning.min(off);
            } else {
                turning = turning.min(off);
            }
            if k > range.end + 200 && run.speed(k)[5].abs() < 0.1 {
                break;
            }
        }
    }
    // A fifth of what a return may leave its path by: the planner's share of 3 mm is 0.05 mm.
    assert!(returning >= -0.01, "{returning} mm");
    // Before the lip, by 2 deg, it does not turn quite beside the wheel.
    assert!(turning >= -0.2, "{turning} mm");
}
