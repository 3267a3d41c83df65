//! The figures of motion: worst shares of the limits over a thousand programs, times against the optimum, latencies. Run
//! by `cargo xtask bench`, which prints them beside their goals; the tests of this folder assert the same on fewer programs.

use super::rig::*;
use hexstep::planner::{Limits, PathSetting};

fn show(key: &str, value: f64) {
    println!("{key} {value}");
}

#[test]
#[ignore = "a minute in release: run by cargo xtask bench"]
fn figures_of_motion() {
    random_programs();
    single_moves();
    dense_paths();
    zigzags();
    latencies();
}

fn random_programs() {
    let (mut worst, mut over, mut squeezed) = ([0.0f64; 3], 0.0f64, 0);
    for seed in 1..=1000 {
        let program = random_program(seed);
        let (samples, planner) = run(&program, &[]);
        for (w, s) in worst.iter_mut().zip(shares(&samples, &program.limits)) {
            *w = w.max(s);
        }
        squeezed += planner.counters().squeezed;
        assert_eq!(*samples.last().unwrap(), end_of(&program), "seed {seed}");
        // How much more than the tolerance it takes, in steps of all joints, by halving.
        let (tolerance, step) = (f64::from(program.path.tolerance()), step_length(&program));
        let fits = |steps: f64| follows(&samples, &program, tolerance + steps * step).is_ok();
        if !fits(over) {
            let (mut lo, mut hi) = (over, 1.0);
            assert!(
                fits(hi),
                "seed {seed}: more than a step beside its tolerance"
            );
            for _ in 0..10 {
                let middle = 0.5 * (lo + hi);
                if fits(middle) {
                    hi = middle
                } else {
                    lo = middle
                }
            }
            over = hi;
        }
    }
    assert_eq!(squeezed, 0);
    show("motion_velocity_share", worst[0]);
    show("motion_acceleration_share", worst[1]);
    show("motion_jerk_share_corners", worst[2]);
    // Half a step of each joint comes with whole pulses.
    show("motion_contour_over_tolerance_steps", over + 0.5);
}

fn single_moves() {
    let mut r = Random::new(5);
    let (mut long, mut short) = (0.0f64, 0.0f64);
    for share in [0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 3.0, 10.0] {
        for _ in 0..50 {
            let Some(single) = Single::random(&mut r, share) else {
                continue;
            };
            let (samples, _) = run(&single.program, &[]);
            // The last millisecond is counted whole, but for the one in which it ends.
            let ratio = (time(&samples) - 1e-3) / single.best();
            // Where targets of whole steps leave less than the length asked for, the shorter move counts as such.
            let (a, j) = (single.acceleration, single.jerk);
            let worst = if 1.0 >= 2.0 * a * a * a / j / j {
                &mut long
            } else {
                &mut short
            };
            *worst = worst.max(ratio);
        }
    }
    show("motion_time_over_optimum_long", long);
    show("motion_time_over_optimum_short", short);
}

/// Time of a path of XY points [mm] at `feed` [mm/s] over that of its length and one pair of ramps; the largest share of
/// a jerk limit.
fn dense(points: impl Iterator<Item = [f64; 2]>, feed: f64, accel: f64) -> (f64, f64) {
    let limits = Limits::new([128_000.0; 6], [(accel * 320.0) as f32; 6], [32e6; 6]).unwrap();
    let mut length = 0.0;
    let mut last = [0.0; 2];
    let mut blocks = Vec::new();
    for p in points {
        let chord = (p[0] - last[0]).hypot(p[1] - last[1]);
        length += chord;
        last = p;
        let q = p.map(|x| (x * 320.0).round() as i32);
        blocks.push((
            [f64::from(q[0]), f64::from(q[1]), 0.0, 0.0, 0.0, 0.0],
            (chord / feed) as f32,
        ));
    }
    let program = Program {
        limits,
        path: PathSetting::new([1.0 / 320.0; 6], 0.01).unwrap(),
        blocks,
    };
    let (samples, _) = run(&program, &[]);
    let ramps = feed / accel + accel / 100_000.0;
    let jerk = shares(&samples, &limits)[2];
    (time(&samples) / (length / feed + ramps), jerk)
}

fn dense_paths() {
    let turn = 2.0 * std::f64::consts::PI;
    let circle = (1..=10_000).map(|k| {
        let t = f64::from(k) / 10_000.0 * turn;
        [50.0 * (t.cos() - 1.0), 50.0 * t.sin()]
    });
    let (ratio, jerk) = dense(circle, 100.0, 3000.0);
    show("motion_time_circle", ratio);
    let mut smooth = jerk;
    // The bonnet's contact of precession polishing: loops along a line, ell sin(theta) = 6 mm, a turn every 3 mm.
    let trochoid = (1..=6000).map(|k| {
        let t = f64::from(k) / 300.0;
        let angle = t * turn;
        [3.0 * t + 6.0 * (angle.cos() - 1.0), 6.0 * angle.sin()]
    });
    let (ratio, jerk) = dense(trochoid, 40.0, 3000.0);
    show("motion_time_trochoid", ratio);
    smooth = smooth.max(jerk);
    show("motion_jerk_share_smooth", smooth);
}

fn zigzags() {
    let (mut least, mut sum, mut count) = (f64::INFINITY, 0.0, 0.0);
    for tolerance in [0.003, 0.01, 0.03, 0.1, 0.3] {
        for seed in 1..=40 {
            let program = zigzag(seed, tolerance);
            let (samples, _) = run(&program, &[]);
            let gain = rest_to_rest(&program) / (time(&samples) - 1e-3);
            least = least.min(gain);
            sum += gain;
            count += 1.0;
        }
    }
    show("motion_zigzag_gain_least", least);
    show("motion_zigzag_gain_mean", sum / count);
}

/// The first sample that is somewhere else than without the event, by the 10 000th of a step: the instant at which the
/// acceleration begins to change.
fn leaves(plain: &[[f64; 6]], samples: &[[f64; 6]]) -> usize {
    let differs = |(p, s): (&[f64; 6], &[f64; 6])| (0..6).any(|i| (p[i] - s[i]).abs() > 1e-4);
    plain.iter().zip(samples).position(differs).expect("acts")
}

fn latencies() {
    let program = circles(60.0);
    let (plain, _) = run(&program, &[]);
    let mut r = Random::new(9);
    let (mut hold, mut change) = (0usize, 0usize);
    for k in 0..1000 {
        let at = 200 + r.below(plain.len() - 400);
        let events = [(at, Event::Hold), (at + 600, Event::Resume)];
        let (samples, planner) = run(&program, &events);
        hold = hold.max(leaves(&plain, &samples) - at);
        check(at as u64, &program, &samples, &planner, end_of(&program));
        if k < 100 {
            let factor = if k % 2 == 0 { 0.6 } else { 1.5 };
            let (samples, _) = run(&program, &[(at, Event::Feed(factor))]);
            change = change.max(leaves(&plain, &samples) - at);
        }
    }
    // The queue is kept five milliseconds ahead at most (controller/motion.rs).
    show("motion_hold_latency_ms", (hold + 5) as f64);
    show("motion_override_latency_ms", (change + 5) as f64);
}
