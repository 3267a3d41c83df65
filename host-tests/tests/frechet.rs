//! The distance in order of two polylines, against another hand: both cut into many short pieces, and the least leash of
//! all walks over their ends by dynamic programming (Eiter and Mannila 1994). It is never below the true distance, and
//! above it by at most the longest piece.

use hexstep_host::frechet::apart;
use hexstep_host::job::{Job, Task};
use hexstep_host::report::PathFigures;
use hexstep_host::run;
use hexstep_host::trace::Trace;

/// xorshift64*, seeded.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }
    /// 0 .. 1
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
    fn scale(&mut self, lo: f64, hi: f64) -> f64 {
        self.between(lo.ln(), hi.ln()).exp()
    }
    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}

fn length<const D: usize>(curve: &[[f64; D]]) -> f64 {
    curve
        .windows(2)
        .map(|ends| distance(&ends[0], &ends[1]))
        .sum()
}

/// The curve in pieces that are no longer than `longest`.
fn cut<const D: usize>(curve: &[[f64; D]], longest: f64) -> Vec<[f64; D]> {
    let mut pieces: Vec<[f64; D]> = curve.iter().take(1).copied().collect();
    for ends in curve.windows(2) {
        let parts = (distance(&ends[0], &ends[1]) / longest).ceil().max(1.0) as usize;
        for part in 1..=parts {
            let share = part as f64 / parts as f64;
            pieces.push(std::array::from_fn(|i| {
                ends[0][i] + share * (ends[1][i] - ends[0][i])
            }));
        }
    }
    pieces
}

/// The reference, and how much it may be above.
fn by_many_pieces<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> (f64, f64) {
    let piece = (length(a).max(length(b)) / 3000.0).max(1e-12);
    let (a, b) = (cut(a, piece), cut(b, piece));
    let mut row: Vec<f64> = Vec::new();
    for (i, p) in a.iter().enumerate() {
        let mut corner = f64::INFINITY;
        for (j, q) in b.iter().enumerate() {
            let off = distance(p, q);
            let above = if i > 0 { row[j] } else { f64::INFINITY };
            let left = if j > 0 { row[j - 1] } else { f64::INFINITY };
            let least = match (i, j) {
                (0, 0) => off,
                _ => off.max(above.min(left).min(corner)),
            };
            corner = above;
            match i {
                0 => row.push(least),
                _ => row[j] = least,
            }
        }
    }
    (row[row.len() - 1], piece)
}

/// `grain` and half a percent for the halving, and the pieces of the reference.
#[track_caller]
fn assert_agrees<const D: usize>(
    told: f64,
    a: &[[f64; D]],
    b: &[[f64; D]],
    grain: f64,
    case: &str,
) {
    let (reference, piece) = by_many_pieces(a, b);
    let (low, high) = (
        reference - piece - 2.0 * grain - 0.005 * reference,
        reference + 2.0 * grain + 0.01 * reference,
    );
    assert!(
        (low..=high).contains(&told),
        "{case}: {told}, by many pieces {reference} within {piece}"
    );
}

/// A random polyline of whole steps: one-step blocks, reversals, repeated points, longer moves.
fn random_polyline(r: &mut Random) -> Vec<[f64; 3]> {
    let count = 2 + r.below(79);
    let mut at = [0.0f64; 3];
    let mut before = at;
    let mut points = vec![at];
    for _ in 0..count {
        let from = at;
        match r.below(5) {
            0 => at[r.below(3)] += [-1.0, 1.0][r.below(2)],
            1 => {}
            2 => at = before,
            3 => at = at.map(|x| x + [-1.0, 0.0, 1.0][r.below(3)]),
            _ => at = at.map(|x| (x + r.between(-12.0, 12.0)).round()),
        }
        before = from;
        points.push(at);
    }
    points
}

/// The same with other points in it, moved by up to `by`.
fn shaken(curve: &[[f64; 3]], by: f64, r: &mut Random) -> Vec<[f64; 3]> {
    let most = r.scale(0.3, 20.0);
    let pieces = cut(curve, most);
    pieces
        .iter()
        .map(|p| p.map(|x| x + r.between(-by, by)))
        .collect()
}

#[test]
fn random_curves_are_as_far_apart_as_by_many_pieces() {
    for seed in 1..=50 {
        let r = &mut Random::new(seed);
        let polyline = random_polyline(r);
        let other = match r.below(3) {
            0 => shaken(&polyline, 0.5, r),
            1 => shaken(&polyline, r.scale(0.01, 30.0), r),
            _ => random_polyline(r),
        };

        let told = apart(&other, &polyline, false, 1e-4);

        assert_agrees(
            told.distance,
            &other,
            &polyline,
            1e-4,
            &format!("seed {seed}"),
        );
        assert!(told.cut <= told.distance);
        assert!(told.aside.iter().all(|a| a.distance <= told.distance));
    }
}

#[test]
fn the_largest_distances_of_points_are_those_of_the_curves_where_these_do_not_cross_themselves() {
    // A step aside at two thirds of a straight line, and a corner that is cut.
    let line = [[0.0, 0.0], [30.0, 0.0], [30.0, 30.0]];
    let motion = [
        [0.0, 0.0],
        [10.0, 0.0],
        [15.0, 1.5],
        [20.0, 0.0],
        [27.0, 0.0],
        [30.0, 3.0],
        [30.0, 30.0],
    ];

    let told = apart(&motion, &line, false, 1e-6);

    assert!(
        (told.distance - 4.5f64.sqrt()).abs() < 0.02,
        "{}",
        told.distance
    );
    assert!((told.cut - 4.5f64.sqrt()).abs() < 1e-9, "{}", told.cut);
    let aside = told.aside.iter().map(|a| a.distance).fold(0.0, f64::max);
    assert!((aside - 1.5).abs() < 1e-9, "{aside}");
}

#[test]
fn a_curve_is_compared_in_order() {
    // The same set of points, run the other way round in the middle.
    let there = [[0.0, 0.0], [10.0, 0.0]];
    let back_and_forth = [[0.0, 0.0], [8.0, 0.0], [2.0, 0.0], [10.0, 0.0]];

    let told = apart(&back_and_forth, &there, false, 1e-6).distance;

    assert!((told - 3.0).abs() < 0.02, "{told}");
}

#[test]
fn points_alone_and_no_points_at_all_have_a_distance_too() {
    let line = [[0.0], [4.0]];

    assert!((apart(&[[1.0]], &line, false, 1e-6).distance - 3.0).abs() < 0.01);
    assert!((apart(&line, &[[1.0]], false, 1e-6).distance - 3.0).abs() < 0.01);
    assert!((apart(&[[1.0]], &[[3.0]], false, 1e-6).distance - 2.0).abs() < 0.01);
    assert_eq!(apart::<1>(&[], &line, false, 1e-6).distance, 0.0);
    // It may have ended on the way.
    let half = apart(&[[0.0], [2.0]], &line, true, 1e-6);
    assert!(half.distance < 1e-4, "{}", half.distance);
}

/// A curve of many short chords at a large distance: thinned, or it would take chords times chords.
#[test]
fn a_distance_much_longer_than_chords_is_found_in_time() {
    let circle = |r: f64, n: usize| -> Vec<[f64; 2]> {
        let at = |k: usize| (k as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
        (0..=n).map(at).map(|(s, c)| [r * c, r * s]).collect()
    };

    let told = apart(&circle(20.0, 300_000), &circle(50.0, 10_000), false, 2e-5);

    assert!((29.9..30.4).contains(&told.distance), "{}", told.distance);
    assert!((29.9..30.4).contains(&told.cut), "{}", told.cut);
}

/// What the pulses say of the motors, by a walk of its own: at every step of any motor, each on the line between its own.
fn motion(trace: &Trace<6>) -> Vec<[f64; 6]> {
    let steps: [Vec<(u64, f64)>; 6] = std::array::from_fn(|motor| {
        let half =
            |s: hexstep_host::trace::Step| (s.time, s.position as f64 - 0.5 * f64::from(s.sign));
        trace.steps_of(motor).map(half).collect()
    });
    let mut times: Vec<u64> = steps.iter().flatten().map(|s| s.0).collect();
    times.sort_unstable();
    times.dedup();
    let at = |time: u64| -> [f64; 6] {
        std::array::from_fn(|motor| {
            let list = &steps[motor];
            let after = list.partition_point(|s| s.0 < time);
            match (after.checked_sub(1).map(|i| list[i]), list.get(after)) {
                (_, Some((t, x))) if *t == time => *x,
                (Some((t0, x0)), Some((t1, x1))) => {
                    x0 + (x1 - x0) * (time - t0) as f64 / (t1 - t0) as f64
                }
                (None, _) => 0.0,
                (Some(_), None) => trace.positions()[motor] as f64,
            }
        })
    };
    let mut motion = vec![[0.0; 6]];
    motion.extend(times.into_iter().map(at));
    motion.push(trace.positions().map(|x| x as f64));
    motion
}

/// Whole programs through the machine: what the report tells of them.
#[test]
fn reports_on_random_programs_tell_the_distance_by_many_pieces() {
    for seed in 1..=15 {
        let r = &mut Random::new(1000 + seed);
        let steps = r.scale(10.0, 10_000.0);
        let points: Vec<String> = random_polyline(r)
            .iter()
            .skip(1)
            .map(|p| {
                let [x, y, z] = p.map(|n| n / steps);
                format!("[{x}, {y}, {z}, 0, 0, 0]")
            })
            .collect();
        // A fast machine in steps: so that no program takes long.
        let six = |x: f64| format!("{:?}", [x / steps; 6]);
        // As fast in steps whatever their size, so that no program takes long.
        let text = format!(
            "kind = \"path\"\n[path]\nfeed = {}\ntolerance = 0.01\npoints = [{}]\n[machine]\n\
             steps_per_unit = {}\nmax_rate = {}\nacceleration = {}\njerk = {}\ntravel = {:?}\n",
            60.0 * 400.0 / steps,
            points.join(", "),
            six(steps * steps),
            six(4e3),
            six(4e4),
            six(1e6),
            [[-1e4, 1e4]; 6],
        );
        let job = Job::parse("some.toml", "some", text.as_bytes()).unwrap();
        let Task::Path(path) = &job.task else {
            panic!("a path");
        };

        let outcome = run::run(&job, &mut |_, _| {}).unwrap();
        let figures = PathFigures::of(&job, path, &outcome, 1.0);

        let mut polyline = vec![[0.0; 6]];
        polyline.extend(path.points.iter().map(|p| p.at));
        let motion: Vec<[f64; 6]> = motion(&outcome.trace)
            .iter()
            .map(|p| p.map(|n| n / steps))
            .collect();
        assert_agrees(
            figures.contour.largest,
            &motion,
            &polyline,
            2e-5,
            &format!("seed {seed}"),
        );
    }
}
