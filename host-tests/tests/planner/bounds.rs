//! The planner at the bound: against stopping at every vertex, against one block for a straight line, against length over
//! feed, at resolutions, chords, tolerances and limits of every decade.

use super::rig::*;
use hexstep::planner::{Limits, PathSetting};

/// Two to eighty blocks: zigzags, bends, near-straight ways, in 1 to 6 joints of 10 to 10 000 steps/mm, jerk 10^3 to 10^8,
/// tolerance 0 to 2 mm, at a feed or as rapids.
fn any_program(seed: u64) -> Program<6> {
    let mut r = Random::new(seed * 7919 + 13);
    let joints = 1 + r.below(6);
    let steps = r.scale(10.0, 10_000.0);
    let (v, a) = (r.scale(20.0, 500.0), r.scale(100.0, 10_000.0));
    let j = r.scale(1e3, 1e8).max(a / 50.0);
    let alike = r.unit() < 0.5;
    let (mut lv, mut la, mut lj) = ([0.0f32; 6], [0.0f32; 6], [0.0f32; 6]);
    for i in 0..6 {
        let factor = if alike { 1.0 } else { r.scale(0.2, 5.0) };
        la[i] = (a * steps * factor).min(1e10) as f32;
        lv[i] = ((v * steps * factor).min(1e7) as f32).min(99.0 * la[i]);
        lj[i] = ((j * steps * factor).min(1e13) as f32).max(la[i] / 99.0);
    }
    let tolerance = [0.0, 0.001, 0.01, 0.05, 0.3, 2.0][r.below(6)];
    let count = 2 + r.below(79);
    let least = r.scale(0.005, 5.0);
    let most = least * r.scale(1.0001, 30.0);
    let bend = [1.0, 0.3, 0.08, 0.05][r.below(4)];
    let feed = (r.unit() < 0.5).then(|| r.scale(0.05, 1.5) * v);
    let length = |d: &[f64; 6]| d.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
    let mut at = [0.0f64; 6];
    let mut way = [0.0f64; 6];
    way[..joints].fill_with(|| r.between(-1.0, 1.0));
    let mut blocks = Vec::new();
    for _ in 0..count {
        let mut other = [0.0f64; 6];
        other[..joints].fill_with(|| r.between(-1.0, 1.0));
        // Now and then a near-straight way has a corner.
        let turn = if bend == 0.05 && r.unit() < 0.2 {
            1.0
        } else {
            bend
        };
        let (l1, l2) = (length(&way), length(&other));
        way = std::array::from_fn(|i| way[i] / l1 * (1.0 - turn) + other[i] / l2 * turn);
        let scale = r.scale(least, most) * steps / length(&way);
        let before = at;
        at = std::array::from_fn(|i| at[i] + way[i] * scale);
        if r.unit() < 0.3 {
            at = at.map(f64::round);
        }
        let chord = length(&std::array::from_fn(|i| at[i] - before[i])) / steps;
        blocks.push((at, feed.map_or(0.0, |feed| (chord / feed) as f32)));
    }
    if let Some(last) = blocks.last_mut() {
        last.0 = last.0.map(f64::round);
    }
    Program {
        limits: Limits::new(lv, la, lj).unwrap(),
        path: PathSetting::new([(1.0 / steps) as f32; 6], tolerance).unwrap(),
        blocks,
    }
}

/// Limits and contour without exception; of a hundred programs at most four are slower than stopping, by a quarter at most, and
/// all together take far less.
#[test]
fn programs_of_every_decade_keep_their_limits_and_are_faster_than_stopping() {
    let (mut slower, mut count, mut ratios) = (0, 0, 0.0);
    for seed in seeds(300) {
        let program = any_program(seed);

        let (samples, planner) = run(&program, &[]);

        let s = shares(&samples, &program.limits);
        assert!(
            s[0] <= 1.01 && s[1] <= 1.01 && s[2] <= 1.03,
            "seed {seed}: shares of the limits {s:?}"
        );
        let most = f64::from(program.path.tolerance()) * 1.0001 + 0.05 * step_length(&program);
        assert_eq!(follows(&samples, &program, most), Ok(()), "seed {seed}");
        assert_eq!(*samples.last().unwrap(), end_of(&program), "seed {seed}");
        assert_eq!(planner.counters().squeezed, 0, "seed {seed}");
        // The last millisecond is counted whole, but for the one in which it ends.
        let ratio = (time(&samples) - 1e-3) / rest_to_rest(&program);
        assert!(ratio < 1.25, "seed {seed}: {ratio} of stopping");
        slower += usize::from(ratio > 1.001);
        count += 1;
        ratios += ratio.ln();
    }
    assert!(
        slower * 25 <= count,
        "{slower} of {count} slower than stopping"
    );
    let mean = (ratios / f64::from(u32::try_from(count).unwrap())).exp();
    assert!(mean < 0.62, "{mean} of stopping, in the mean");
}

fn limits(steps: f64) -> Limits<6> {
    let all = |x: f64| [(x * steps) as f32; 6];
    Limits::new(all(200.0), all(1000.0), all(20_000.0)).unwrap()
}

/// A path of XY points [mm] from the origin at a feed [mm/s]; on whole steps, or on them at its end alone.
fn path_of(points: &[[f64; 2]], steps: f64, tolerance: f64, feed: f64, whole: bool) -> Program<6> {
    let mut last = [0.0; 2];
    let blocks = points.iter().enumerate().map(|(k, p)| {
        let chord = (p[0] - last[0]).hypot(p[1] - last[1]);
        last = *p;
        let mut q = [p[0] * steps, p[1] * steps, 0.0, 0.0, 0.0, 0.0];
        if whole || k + 1 == points.len() {
            q = q.map(f64::round);
        }
        (q, (chord / feed) as f32)
    });
    Program {
        limits: limits(steps),
        path: PathSetting::new([(1.0 / steps) as f32; 6], tolerance as f32).unwrap(),
        blocks: blocks.collect(),
    }
}

/// 40 to 4000 steps/mm, chords of 5 um to 1 mm; a slope whose ends are whole steps.
#[test]
fn a_straight_line_in_chords_takes_no_longer_than_one_block() {
    for steps in [40.0, 80.0, 160.0, 400.0, 1000.0, 4000.0] {
        for (x, y) in [(20.0, 0.0), (20.0, 7.0), (20.0, 20.0), (9.0, 18.0)] {
            for chord in [0.005, 0.01, 0.1, 1.0] {
                let n = (f64::hypot(x, y) / chord) as usize;
                let point = |k: usize| {
                    let part = k as f64 / n as f64;
                    [x * part, y * part]
                };
                let points: Vec<_> = (1..=n).map(point).collect();
                let (whole, _) = run(&path_of(&[[x, y]], steps, 0.01, 100.0, false), &[]);

                let (chords, _) = run(&path_of(&points, steps, 0.01, 100.0, false), &[]);

                let ratio = time(&chords) / time(&whole);
                assert!(ratio <= 1.01, "{steps}/mm, {chord} mm, ({x}, {y}): {ratio}");
            }
        }
    }
}

/// Chords of one to three steps point anywhere; a hundredth of a millimetre in them at 160 steps/mm is a line all the same
/// where the tolerance is above their rounding.
#[test]
fn a_line_of_chords_on_whole_steps_is_a_line() {
    let point = |k: usize| [f64::from(k as u32) * 0.0094, f64::from(k as u32) * 0.0034];
    let points: Vec<_> = (1..=2000).map(point).collect();
    let (whole, _) = run(&path_of(&points[1999..], 160.0, 0.02, 100.0, true), &[]);

    let (chords, _) = run(&path_of(&points, 160.0, 0.02, 100.0, true), &[]);

    assert!(time(&chords) <= 1.01 * time(&whole) + 1e-3);
}

/// Speed within a thousandth of the feed between the ramps, and time of length over feed and the ramps, whatever the
/// resolution and the chords; the exact circle within the tolerance.
#[test]
fn circles_run_at_their_feed_at_any_resolution_and_number_of_chords() {
    for steps in [10.0, 80.0, 1000.0, 10_000.0] {
        for (radius, feed) in [(2.0, 15.0), (5.0, 35.0), (20.0, 50.0), (50.0, 100.0)] {
            for n in [300, 1000, 10_000, 20_000] {
                let point = |k: usize| {
                    let t = std::f64::consts::TAU * k as f64 / n as f64;
                    [radius * (t.cos() - 1.0), radius * t.sin()]
                };
                let points: Vec<_> = (1..=n).map(point).collect();

                let (samples, _) = run(&path_of(&points, steps, 0.01, feed, false), &[]);

                let length = std::f64::consts::TAU * radius;
                // No ramp reaches the acceleration below 50 mm/s.
                let ramps = if feed < 50.0 {
                    2.0 * f64::sqrt(feed / 20_000.0)
                } else {
                    feed / 1000.0 + 0.05
                };
                let ratio = time(&samples) / (length / feed + ramps);
                let what = format!("r {radius}, {n} chords, {steps}/mm");
                assert!(ratio <= 1.05, "{what}: {ratio} of the time");
                let speed =
                    |w: &[[f64; 6]]| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]) / steps * 1000.0;
                let speeds: Vec<f64> = samples.windows(2).map(speed).collect();
                let middle = &speeds[speeds.len() * 3 / 10..speeds.len() * 7 / 10];
                let (low, high) = middle
                    .iter()
                    .fold((f64::MAX, 0.0f64), |(l, h), v| (l.min(*v), h.max(*v)));
                assert!(high - low <= 2e-3 * high, "{what}: {low} to {high} mm/s");
            }
        }
    }
}

/// Zigzags of 2 mm, a square of 100 mm: a tenth, a tenth and a hundredth below stopping in the corners.
#[test]
fn corners_are_passed_within_the_tolerance_without_a_stop() {
    let zigzag = |turn: f64| {
        let (mut p, half) = ([0.0; 2], (turn / 2.0).to_radians());
        let next = |k: usize| {
            let side = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            p = [p[0] + 2.0 * half.cos(), p[1] + side * 2.0 * half.sin()];
            p
        };
        (0..101).map(next).collect::<Vec<_>>()
    };
    let square = vec![[100.0, 0.0], [100.0, 100.0], [0.0, 100.0], [0.0, 0.0]];
    for (points, feed, most) in [
        (zigzag(90.0), 100.0, 0.91),
        (zigzag(135.0), 100.0, 0.925),
        (square, 166.7, 0.992),
    ] {
        for steps in [80.0, 1000.0] {
            let program = path_of(&points, steps, 0.01, feed, false);

            let (samples, _) = run(&program, &[]);

            let ratio = time(&samples) / rest_to_rest(&program);
            assert!(ratio <= most, "{ratio} of stopping");
            let s = shares(&samples, &program.limits);
            assert!(s[1] <= 1.01 && s[2] <= 1.03, "{s:?}");
        }
    }
}

#[test]
fn a_larger_tolerance_makes_a_corner_no_slower() {
    let corner = [[5.0, 0.0], [5.0 + 4.33, 2.5]];
    let mut before = f64::MAX;
    for tolerance in [0.0, 0.003, 0.01, 0.05, 0.3, 1.0] {
        let (samples, _) = run(&path_of(&corner, 400.0, tolerance, 1000.0, false), &[]);
        let now = time(&samples);
        assert!(
            now <= 1.03 * before,
            "tolerance {tolerance}: {now} after {before}"
        );
        before = before.min(now);
    }
}

#[test]
fn a_way_back_reaches_its_point() {
    let back = path_of(&[[10.0, 0.0], [0.0, 0.0]], 400.0, 0.3, 100.0, false);

    let (samples, _) = run(&back, &[]);

    let farthest = samples.iter().map(|s| s[0]).fold(0.0, f64::max);
    assert!((4000.0 - farthest).abs() < 0.5, "{farthest}");
}

/// A path may end between steps: it rests on the nearest ones.
#[test]
fn an_end_between_steps_rests_on_whole_ones() {
    let mut program = path_of(&[[1.0, 0.5], [2.0, 0.0]], 100.0, 0.01, 50.0, false);
    program.blocks[1].0 = [200.4, -0.6, 0.0, 0.0, 0.0, 0.0];

    let (samples, planner) = run(&program, &[]);

    assert_eq!(samples.last(), Some(&[200.0, -1.0, 0.0, 0.0, 0.0, 0.0]));
    assert!(planner.is_idle());
}
