//! Poses against what the words mean, by formulas that share nothing with the library's.

use crate::common::*;
use hexstep::cycles::precession::{
    Contact, Cycle, Drive, FarEnd, FeedAt, Flags, Parameters, Reference, Stance, Turn,
};
use hexstep::geometry::{Rotation, Vector};

/// Spherical interpolation by sines.
fn slerp(a: V, b: V, u: f64) -> V {
    let kappa = angle(a, b).to_radians();
    if kappa < 1e-7 {
        let n = a * (1.0 - u) + b * u;
        return n * (1.0 / n.norm());
    }
    (a * ((1.0 - u) * kappa).sin() + b * (u * kappa).sin()) * (1.0 / kappa.sin())
}

fn random_process(random: &mut Random, reference: Reference) -> Parameters<f64> {
    let drive = if random.word().is_multiple_of(2) {
        Drive::Time {
            rate: random.between(-2.0, 2.0),
        }
    } else {
        Drive::Distance {
            pitch: random.between(5.0, 40.0),
        }
    };
    Parameters {
        theta: random.between(0.0, 85f64.to_radians()),
        inward: random.between(0.0, 3.0),
        feed: random.between(1.0, 20.0),
        feed_at: FeedAt::Contact,
        drive,
        alpha0: random.between(-10.0, 10.0),
        reference,
        eps: 0.05,
        ..Parameters::default()
    }
}

/// For each pose but the first the kept ends of its segment, on the way, before and after.
fn walk(
    parameters: &Parameters<f64>,
    path: &[(V, V)],
    mut look: impl FnMut(&Stance<f64>, &Stance<f64>, (V, V), (V, V)),
) {
    let contacts: Vec<Contact<f64>> = path.iter().map(|(p, n)| Contact { p: *p, n: *n }).collect();
    let cycle = Cycle::new(parameters, &contacts).unwrap();
    let mut kept = path[0];
    let mut before: Option<Stance<f64>> = None;
    for (segment, end) in cycle.segments().zip(&path[1..]) {
        if segment.flags().skipped {
            continue;
        }
        for stance in segment {
            if let Some(before) = &before {
                look(before, &stance, kept, *end);
            }
            before = Some(stance);
        }
        kept = *end;
    }
}

#[test]
fn the_axis_leans_by_theta_from_a_normal_that_turns_evenly_and_the_centre_stands_rho_above_the_path()
 {
    for seed in 0..40 {
        let mut random = Random(seed);
        let reference = REFERENCES[seed as usize % 2];
        let parameters = random_process(&mut random, reference);
        let path = random.path(12);
        let rho = parameters.bonnet_radius - parameters.inward;

        walk(&parameters, &path, |_, stance, (p0, n0), (p1, n1)| {
            let n = slerp(n0, n1, stance.u);
            let lean = angle(stance.axis, n) - parameters.theta.to_degrees();
            assert!(lean.abs() < 1e-9, "seed {seed}: {lean}");
            let centre = p0 + (p1 - p0) * stance.u + n * rho;
            assert!((stance.centre - centre).norm() < 1e-9, "seed {seed}");
            let far = centre + stance.axis * 127.0;
            assert!((stance.far - far).norm() < 1e-9, "seed {seed}");
            assert!((stance.axis.norm() - 1.0).abs() < 1e-14, "seed {seed}");
        });
    }
}

/// No turn about the normal, by the definition of parallel transport: many small projections on the next tangent plane.
#[test]
fn transport_carries_the_reference_without_turning_it_about_the_normal() {
    const PARTS: u32 = 40_000;
    for seed in 100..104 {
        let mut random = Random(seed);
        let parameters = random_process(&mut random, Reference::Transport);
        let (p, n) = (random.point(100.0), random.direction());
        let turned = n + random.direction() * 0.9;
        let end = (p + random.point(10.0), turned * (1.0 / turned.norm()));

        walk(
            &parameters,
            &[(p, n), end],
            |first, stance, (_, n0), (_, n1)| {
                if stance.u != 1.0 || first.u != 0.0 && stance.segment != 0 {
                    return;
                }
                let start = {
                    let contacts = [(p, n), end].map(|(p, n)| Contact { p, n });
                    let cycle = Cycle::new(&parameters, &contacts).unwrap();
                    cycle.stances().next().unwrap().frame.n
                };
                let mut a = start;
                for i in 1..=PARTS {
                    let c = slerp(n0, n1, f64::from(i) / f64::from(PARTS));
                    a -= c * a.dot(c);
                    a = a * (1.0 / a.norm());
                }
                assert!(
                    angle(a, stance.frame.n) < 1e-3,
                    "seed {seed}: {}",
                    angle(a, stance.frame.n)
                );
            },
        );
    }
}

#[test]
fn in_transport_the_phase_advances_at_exactly_the_set_rate() {
    for seed in 200..220 {
        let mut random = Random(seed);
        let mut parameters = random_process(&mut random, Reference::Transport);
        let rate = random.between(-3.0, 3.0);
        parameters.drive = Drive::Time { rate };
        let path = path(random.path(10));

        for stance in stances(&parameters, &path) {
            let wanted = (parameters.alpha0 + rate * stance.time).to_degrees();
            let off = phase_distance(stance.phase.to_degrees(), wanted);
            assert!(off < 1e-9, "seed {seed}: {off}");
        }
    }
}

/// The axis, seen in its own frame, stands at the phase: cos from a, sin from b.
#[test]
fn the_reported_phase_is_the_angle_of_the_axis_about_the_normal() {
    for seed in 300..320 {
        let mut random = Random(seed);
        let parameters = random_process(&mut random, REFERENCES[seed as usize % 2]);
        let path = path(random.path(8));

        for stance in stances(&parameters, &path) {
            let Rotation { n: a, s: b, a: c } = stance.frame;
            assert!((a.cross(b) - c).norm() < 1e-13, "seed {seed}");
            assert!(a.dot(c).abs() < 1e-13 && (a.norm() - 1.0).abs() < 1e-13);
            if parameters.theta > 0.01 {
                let phase = stance.axis.dot(b).atan2(stance.axis.dot(a)).to_degrees();
                let off = phase_distance(phase, stance.phase.to_degrees());
                assert!(off < 1e-9, "seed {seed}: {off}");
            }
        }
    }
}

#[test]
fn feed_locked_the_reference_is_the_feed_in_the_tangent_plane() {
    let mut seen = 0;
    for seed in 400..440 {
        let mut random = Random(seed);
        let parameters = random_process(&mut random, Reference::FeedLocked);
        let path = random.path(8);

        walk(&parameters, &path, |_, stance, (p0, n0), (p1, n1)| {
            let d = p1 - p0;
            let along = |n: V| angle(d, n).to_radians().sin() < 2e-3;
            if d.norm() < 1e-5 || along(n0) || along(n1) || along(stance.frame.a) {
                return;
            }
            let c = stance.frame.a;
            let a = d - c * d.dot(c);
            assert!(angle(stance.frame.n, a) < 1e-9, "seed {seed}");
            seen += 1;
        });
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn the_axis_never_turns_by_more_than_a_step_whatever_the_path_does() {
    for seed in 500..560 {
        let mut random = Random(seed);
        let mut parameters = random_process(&mut random, REFERENCES[seed as usize % 2]);
        parameters.dpsi = random.between(1.0, 6.0f64).to_radians();
        let path = random.path(20);

        walk(&parameters, &path, |before, stance, (_, n0), (_, n1)| {
            // Feed-locked the reference turns about the normal by itself where the normal tilts, which no bound covers.
            if parameters.reference == Reference::FeedLocked && angle(n0, n1) > 1e-6 {
                return;
            }
            let turned = angle(before.axis, stance.axis);
            let limit = parameters.dpsi.to_degrees() * 1.000_001;
            assert!(turned <= limit, "seed {seed}: {turned} > {limit}");
        });
    }
}

/// A corner, a reversal, a turn on the spot: the last pose of a segment and the first of the next are one, so what is
/// left between neighbours is a step.
#[test]
fn a_feed_reversal_leaves_the_axis_where_it_is() {
    let zigzag = flat(&ZIGZAG);
    for reference in REFERENCES {
        let parameters = Parameters {
            reference,
            ..process::<f64>()
        };

        let poses = stances(&parameters, &zigzag);

        for pair in poses.windows(2) {
            let turned = angle(pair[0].axis, pair[1].axis);
            assert!(turned < 5.0, "{turned}");
        }
    }
}

/// A trochoid in closed form.
#[test]
fn on_a_plane_the_far_point_runs_on_a_trochoid_and_its_chords_keep_to_eps() {
    for (seed, reference) in (600..).zip(REFERENCES) {
        let mut random = Random(seed);
        let parameters = Parameters {
            drive: Drive::Time {
                rate: random.between(0.3, 2.0),
            },
            reference,
            eps: 0.02,
            ..Parameters::default()
        };
        let Drive::Time { rate } = parameters.drive else {
            unreachable!()
        };
        let radius = 127.0 * parameters.theta.sin();
        let height = 39.5 + 127.0 * parameters.theta.cos();
        let far = |t: f64| {
            v(
                5.0 * t + radius * (rate * t).cos(),
                radius * (rate * t).sin(),
                height,
            )
        };

        let poses = stances(&parameters, &flat(&[[0.0, 0.0], [90.0, 0.0]]));

        for pair in poses.windows(2) {
            assert!((pair[1].far - far(pair[1].time)).norm() < 1e-9);
            let middle = (pair[0].far + pair[1].far) * 0.5;
            let off = (far((pair[0].time + pair[1].time) / 2.0) - middle).norm();
            assert!(off <= 0.02 * 1.0001, "{off}");
        }
    }
}

/// On a curved path too: poses at half steps come from a path cut twice as fine.
#[test]
fn chords_keep_to_eps_while_the_normal_turns() {
    for seed in 700..720 {
        let mut random = Random(seed);
        let mut parameters = random_process(&mut random, Reference::Transport);
        parameters.dpsi = 3.0;
        parameters.dt_max = 1e6;
        parameters.eps = random.between(0.01, 0.3);
        let start = (random.point(100.0), random.direction());
        let turned = start.1 + random.direction() * 0.9;
        let path = path([start, (start.0 + random.point(9.0), turned)]);
        let count = counts(&parameters, &path)[0];
        let coarse = stances(&parameters, &path);
        let time = coarse.last().unwrap().time;
        parameters.dt_max = time / f64::from(2 * count);
        let fine = stances(&parameters, &path);
        if fine.len() != 2 * count as usize + 1 {
            continue;
        }

        for (i, pair) in coarse.windows(2).enumerate() {
            let middle = (pair[0].far + pair[1].far) * 0.5;
            let off = (fine[2 * i + 1].far - middle).norm();
            assert!(off <= parameters.eps * 1.0001, "seed {seed}: {off}");
        }
    }
}

#[test]
fn on_a_plane_both_references_give_the_same_poses() {
    for seed in 800..810 {
        let mut random = Random(seed);
        let base = random_process(&mut random, Reference::Transport);
        let points: Vec<[f64; 2]> = (0..9)
            .map(|_| [random.between(-30.0, 30.0), random.between(-30.0, 30.0)])
            .collect();
        let locked = Parameters {
            reference: Reference::FeedLocked,
            ..base
        };

        let one = stances(&base, &flat(&points));
        let other = stances(&locked, &flat(&points));

        assert_eq!(one.len(), other.len());
        for (a, b) in one.iter().zip(&other) {
            assert!((a.axis - b.axis).norm() < 1e-12, "seed {seed}");
            assert!((a.centre - b.centre).norm() < 1e-12, "seed {seed}");
        }
    }
}

#[test]
fn the_far_curve_has_loops_exactly_when_it_outruns_the_feed() {
    for (rate, loops) in [(0.114, false), (0.116, true)] {
        // 5 mm/s on a circle of 43.4366 mm: 0.11511 rad/s.
        let parameters = Parameters {
            drive: Drive::Time { rate },
            ..Parameters::default()
        };

        let poses = stances(&parameters, &flat(&[[0.0, 0.0], [600.0, 0.0]]));

        let backwards = poses.windows(2).any(|w| w[1].far.x < w[0].far.x);
        assert_eq!(backwards, loops);
    }
}

#[test]
fn the_tool_frame_is_tipped_by_theta_alone_and_never_winds_up() {
    for seed in 900..910 {
        let mut random = Random(seed);
        let parameters = random_process(&mut random, Reference::Transport);
        let path = path(random.path(4));

        for stance in stances(&parameters, &path) {
            let tool = stance.tool();
            assert!((tool.n.cross(tool.s) - tool.a).norm() < 1e-13);
            assert!((tool.a - stance.axis).norm() < 1e-13);
            // The angle of a rotation follows from its trace.
            let r = stance.frame;
            let trace = tool.n.dot(r.n) + tool.s.dot(r.s) + tool.a.dot(r.a);
            let tipped = ((trace - 1.0) / 2.0).clamp(-1.0, 1.0).acos();
            assert!((tipped - parameters.theta).abs() < 1e-6, "seed {seed}");
        }
    }
}

#[test]
fn after_a_full_turn_the_tool_frame_is_the_same() {
    let parameters = Parameters {
        dwell: 24.0,
        // An even number of steps.
        dt_max: 0.1,
        ..process::<f64>()
    };

    let poses = stances(&parameters, &flat(&[[0.0, 0.0]]));

    let half = poses.len() / 2;
    let (a, b) = (poses[0].tool(), poses[half].tool());
    assert!((poses[half].time - 12.0).abs() < 1e-12);
    assert!((a.n - b.n).norm() < 1e-12 && (a.s - b.s).norm() < 1e-12);
}

#[test]
fn the_feed_is_that_of_the_contact_or_of_the_centre_as_asked() {
    let path = cylinder::<f64>();
    let speed = |feed_at, point: fn(&Stance<f64>) -> V| {
        let parameters = Parameters {
            feed_at,
            ..process::<f64>()
        };
        let ends: Vec<_> = stances(&parameters, &path)
            .into_iter()
            .filter(|s| s.u == 1.0 || s.time == 0.0)
            .collect();
        let (a, b) = (&ends[4], &ends[5]);
        (point(b) - point(a)).norm() / (b.time - a.time)
    };

    let at_contact = speed(FeedAt::Contact, |s| s.centre - s.frame.a * 39.5);
    let at_centre = speed(FeedAt::Centre, |s| s.centre);

    assert!((at_contact - 5.0).abs() < 1e-9, "{at_contact}");
    assert!((at_centre - 5.0).abs() < 1e-9, "{at_centre}");
}

#[test]
fn the_far_point_below_the_surface_lies_on_the_same_axis() {
    let path = cylinder::<f64>();
    let below = Parameters {
        far_end: FarEnd::Surface,
        ..process::<f64>()
    };

    let one = stances(&process(), &path);
    let other = stances(&below, &path);

    for (a, b) in one.iter().zip(&other) {
        assert!(((a.far + b.far) * 0.5 - a.centre).norm() < 1e-12);
    }
}

#[test]
fn a_turn_on_the_spot_takes_its_angle_over_the_turning_speed() {
    let tip = v(0.0, 40f64.to_radians().sin(), 40f64.to_radians().cos());
    let contacts = path([(Vector::ZERO, Vector::Z), (Vector::ZERO, tip)]);
    for (drive, phase) in [
        (Drive::Time { rate: 1.0 }, 2f64.to_degrees()),
        (Drive::Distance { pitch: 8.0 }, 0.0),
    ] {
        let parameters = Parameters {
            drive,
            ..process::<f64>()
        };
        let cycle = Cycle::new(&parameters, &contacts).unwrap();

        let last = cycle.stances().last().unwrap();

        assert!((last.time - 2.0).abs() < 1e-12);
        assert!((last.phase.to_degrees::<f64>() - phase).abs() < 1e-9);
        assert!((last.frame.a - tip).norm() < 1e-12);
        let flags = cycle.segments().next().unwrap().flags();
        let names: Vec<_> = flags.names().collect();
        assert_eq!(names, ["CoarseNormals", "Pivot"]);
    }
}

/// Around a hollow as narrow as the ball the contact moves and the centre does not.
#[test]
fn a_centre_at_rest_is_a_turn_on_the_spot_when_the_feed_is_measured_there() {
    let n = |deg: f64| v(deg.to_radians().sin(), 0.0, deg.to_radians().cos());
    let contacts = path([(n(0.0) * -39.5, n(0.0)), (n(10.0) * -39.5, n(10.0))]);
    let parameters = Parameters {
        feed_at: FeedAt::Centre,
        ..process::<f64>()
    };
    let cycle = Cycle::new(&parameters, &contacts).unwrap();

    assert!(cycle.segments().next().unwrap().flags().pivot);
    assert!((cycle.stances().last().unwrap().time - 0.5).abs() < 1e-12);
    for stance in cycle.stances() {
        // The contact runs on the chord of the hollow: its height is the most that the centre strays.
        let sag = 39.5 * (1.0 - 5f64.to_radians().cos());
        assert!(stance.centre.norm() < 1.0001 * sag);
    }
}

#[test]
fn repeated_points_are_skipped_and_nothing_moves_there() {
    let once = flat::<f64>(&[[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]]);
    let again = flat(&[
        [0.0, 0.0],
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 0.0],
        [10.0, 5.0],
        [10.0, 5.0],
    ]);
    let parameters = process();

    let cycle = Cycle::new(&parameters, &again).unwrap();

    let steps: Vec<u32> = cycle.segments().map(|s| s.steps()).collect();
    let skipped: Vec<bool> = cycle.segments().map(|s| s.flags().skipped).collect();
    assert_eq!(skipped, [true, false, true, false, true]);
    assert_eq!([steps[1], steps[3]], *counts(&parameters, &once));
    let axes = |path| stances(&parameters, path).into_iter().map(|s| s.axis);
    assert!(axes(&once).eq(axes(&again)));
}

#[test]
fn a_path_of_equal_points_is_one_pose() {
    let same = flat::<f64>(&[[1.0, 2.0]; 3]);
    let cycle = Cycle::new(&process(), &same).unwrap();

    let poses: Vec<_> = cycle.stances().collect();

    assert_eq!(poses.len(), 1);
    assert_eq!(poses[0].dt, 0.0);
    let flags: Vec<Flags> = cycle.segments().map(|s| s.flags()).collect();
    assert_eq!(flags.len(), 2);
    assert!(flags.iter().all(|f| f.skipped));
}

#[test]
fn a_feed_along_the_normal_is_carried_along_and_flagged() {
    let contacts = path([
        (Vector::ZERO, Vector::Z),
        (v(5.0, 0.0, 0.0), Vector::Z),
        (v(5.0, 0.0, 5.0), Vector::Z),
        (v(0.0, 0.0, 5.0), Vector::Z),
    ]);
    let parameters = Parameters {
        reference: Reference::FeedLocked,
        ..process::<f64>()
    };
    let cycle = Cycle::new(&parameters, &contacts).unwrap();

    let along: Vec<bool> = cycle
        .segments()
        .map(|s| s.flags().feed_along_normal)
        .collect();

    assert_eq!(along, [false, true, false]);
    let poses: Vec<_> = cycle.stances().collect();
    for pair in poses.windows(2) {
        assert!(angle(pair[0].axis, pair[1].axis) < 5.0);
    }
}

/// The normal sweeps over the feed between two points, neither of which sees it: the feed gives no direction there.
#[test]
fn a_normal_that_sweeps_over_the_feed_turns_no_axis_round() {
    let contacts = path([
        (Vector::ZERO, v(0.0, -0.1, 1.0)),
        (v(0.0, 0.0, 5.0), v(0.0, 0.1, 1.0)),
    ]);
    let parameters = Parameters {
        reference: Reference::FeedLocked,
        ..process::<f64>()
    };
    let cycle = Cycle::new(&parameters, &contacts).unwrap();

    assert!(cycle.segments().next().unwrap().flags().feed_along_normal);
    let poses: Vec<_> = cycle.stances().collect();
    for pair in poses.windows(2) {
        assert!(angle(pair[0].axis, pair[1].axis) < 5.0);
    }
}

#[test]
fn without_tilt_the_axis_is_the_normal_and_the_phase_still_runs() {
    let parameters = Parameters {
        theta: 0.0,
        ..process::<f64>()
    };

    let poses = stances(&parameters, &cylinder());

    let mut phases = Vec::new();
    for stance in &poses {
        assert!((stance.axis - stance.frame.a).norm() < 1e-15);
        phases.push(stance.phase.to_degrees::<f64>());
    }
    assert!(phases.windows(2).all(|w| w[0] != w[1]));
}

#[test]
fn a_rate_of_zero_is_a_constant_lean() {
    let parameters = Parameters {
        drive: Drive::Time { rate: 0.0 },
        alpha0: 1.0,
        ..process::<f64>()
    };

    for stance in stances(&parameters, &flat(&ZIGZAG)) {
        let lean = v(
            parameters.theta.sin() * 1f64.cos(),
            parameters.theta.sin() * 1f64.sin(),
            parameters.theta.cos(),
        );
        assert!((stance.axis - lean).norm() < 1e-12);
    }
}

#[test]
fn the_first_reference_is_the_one_asked_for_else_the_first_move_else_an_axis() {
    let first = |reference: Option<V>, points: &[(V, V)]| {
        let parameters = Parameters {
            first_reference: reference,
            dwell: 1.0,
            ..process::<f64>()
        };
        stances(&parameters, &path(points.iter().copied()))[0]
            .frame
            .n
    };
    let (o, z) = (Vector::ZERO, Vector::Z);
    let tipped = v(0.0, 0.6, 0.8);
    let to = |x, y| v(x, y, 0.0);

    assert_eq!(
        first(Some(v(0.0, 2.0, 7.0)), &[(o, z), (to(3.0, 0.0), z)]),
        Vector::Y
    );
    // Along the normal: passed over.
    assert_eq!(first(Some(z), &[(o, z), (to(0.0, -3.0), z)]), -Vector::Y);
    assert_eq!(first(None, &[(o, z), (v(0.0, 0.0, 3.0), z)]), Vector::X);
    // The first move comes after a turn on the spot.
    let a = first(None, &[(o, z), (o, tipped), (to(0.0, 4.0), tipped)]);
    assert_eq!(a, Vector::Y);
    assert_eq!(first(None, &[(o, Vector::X)]), Vector::Y);
}

#[test]
fn turns_are_exact_at_the_quarters_and_close_between() {
    for (degrees, sin_cos) in [
        (0.0, (0.0, 1.0)),
        (90.0, (1.0, 0.0)),
        (180.0, (0.0, -1.0)),
        (270.0, (-1.0, 0.0)),
        (-90.0, (-1.0, 0.0)),
        (450.0, (1.0, 0.0)),
    ] {
        assert_eq!(Turn::of_turns(degrees / 360.0).sin_cos::<f64>(), sin_cos);
    }
    let mut random = Random(1);
    for _ in 0..2000 {
        let turns = random.between(-3.0, 3.0);
        let turn = Turn::of_turns(turns);
        let (sin, cos) = turn.sin_cos::<f64>();
        let angle = turns * std::f64::consts::TAU;
        assert!((sin - angle.sin()).abs() < 4e-15 && (cos - angle.cos()).abs() < 4e-15);
        let (sin, cos) = turn.sin_cos::<f32>();
        assert!((f64::from(sin) - angle.sin()).abs() < 2e-7);
        assert!((f64::from(cos) - angle.cos()).abs() < 2e-7);
    }
}
