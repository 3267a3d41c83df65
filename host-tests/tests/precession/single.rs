//! Single precision against double, within the table of section 7.

use crate::common::*;
use hexstep::cycles::precession::{Contact, Cycle, Drive, Parameters, Precession, Stance, Turn};
use hexstep::geometry::Vector;

const CENTRE: f64 = 5e-4;
const FAR: f64 = 1e-3;
const AXIS: f64 = 2e-4;
const TILT: f64 = 1e-4;
const PHASE_PER_TURN: f64 = 1e-4;

fn single(p: &Parameters<f64>) -> Parameters<f32> {
    Parameters {
        theta: p.theta as f32,
        bonnet_radius: p.bonnet_radius as f32,
        inward: p.inward as f32,
        feed: p.feed as f32,
        feed_at: p.feed_at,
        drive: match p.drive {
            Drive::Time { rate } => Drive::Time { rate: rate as f32 },
            Drive::Distance { pitch } => Drive::Distance {
                pitch: pitch as f32,
            },
        },
        alpha0: p.alpha0 as f32,
        reference: p.reference,
        first_reference: p.first_reference.map(rounded),
        ell: p.ell as f32,
        far_end: p.far_end,
        eps: p.eps as f32,
        dpsi: p.dpsi as f32,
        dt_max: p.dt_max as f32,
        w_rot: p.w_rot as f32,
        dwell: p.dwell as f32,
    }
}

/// The largest errors over a path, each as a part of what the table allows.
fn worst(p: &Parameters<f64>, path64: &[(V, V)]) -> [f64; 5] {
    let double = stances(p, &path(path64.iter().copied()));
    let got = stances(&single(p), &path::<f32>(path64.iter().copied()));
    let counts64 = counts(p, &path(path64.iter().copied()));
    let counts32 = counts(&single(p), &path::<f32>(path64.iter().copied()));
    for (a, b) in counts64.iter().zip(&counts32) {
        assert!(a.abs_diff(*b) <= 1, "{a} {b} steps");
    }
    if counts64 != counts32 {
        return [0.0; 5];
    }
    let mut worst = [0.0; 5];
    let mut turned = 0.0;
    let mut before = double[0].phase.to_degrees::<f64>();
    for (a, b) in double.iter().zip(&got) {
        let phase = a.phase.to_degrees::<f64>();
        turned += phase_distance(phase, before) / 360.0;
        before = phase;
        let errors = errors(a, b, p, turned);
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = error.max(*worst);
        }
    }
    worst
}

fn errors(a: &Stance<f64>, b: &Stance<f32>, p: &Parameters<f64>, turned: f64) -> [f64; 5] {
    let phase = phase_distance(a.phase.to_degrees(), b.phase.to_degrees::<f32>().into());
    // The first turn counts as a whole one.
    let phase_allowed = PHASE_PER_TURN * (1.0 + turned);
    let phase_term = phase.min(phase_allowed) * p.theta.sin();
    let far_allowed = FAR + p.ell * phase_term.to_radians();
    [
        (a.centre - widened(b.centre)).norm() / CENTRE,
        (a.far - widened(b.far)).norm() / far_allowed,
        angle(a.axis, widened(b.axis)) / (AXIS + phase_term),
        phase / phase_allowed,
        (angle(widened(b.axis), widened(b.frame.a)) - p.theta.to_degrees()).abs() / TILT,
    ]
}

#[test]
fn single_precision_keeps_to_the_table_along_the_printed_paths() {
    let cylinder: Vec<_> = cylinder::<f64>().iter().map(|c| (c.p, c.n)).collect();
    let zigzag: Vec<_> = flat::<f64>(&ZIGZAG).iter().map(|c| (c.p, c.n)).collect();
    for reference in REFERENCES {
        for path in [&cylinder, &zigzag] {
            let parameters = Parameters {
                reference,
                ..process()
            };
            let worst = worst(&parameters, path);
            assert!(worst.iter().all(|w| *w < 1.0), "{worst:?}");
        }
    }
}

#[test]
fn single_precision_keeps_to_the_table_with_coordinates_of_a_metre() {
    let mut all = [0.0f64; 5];
    for seed in 0..40 {
        let mut random = Random(seed);
        let parameters = Parameters {
            theta: random.between(0.0, 1.4),
            alpha0: random.between(0.0, 6.0),
            ell: random.between(0.0, 200.0),
            drive: Drive::Time {
                rate: random.between(-1.0, 1.0),
            },
            ..process()
        };
        // Points and normals that single precision holds, so that input rounding is not counted as error.
        let n = |random: &mut Random| {
            let u = widened(rounded::<f32>(random.direction()));
            v(u.x, u.y, u.z.abs() + 1.0)
        };
        let mut p = random.point(950.0);
        let path: Vec<(V, V)> = (0..8)
            .map(|_| {
                p += random.point(7.0);
                (
                    widened(rounded::<f32>(p)),
                    widened(rounded::<f32>(n(&mut random))),
                )
            })
            .collect();

        let worst = worst(&parameters, &path);

        assert!(worst.iter().all(|w| *w < 1.0), "seed {seed}: {worst:?}");
        for (all, worst) in all.iter_mut().zip(worst) {
            *all = all.max(worst);
        }
    }
    // The paths were really compared.
    assert!(all.iter().all(|w| *w > 0.0), "{all:?}");
}

#[test]
fn a_day_of_polishing_loses_nothing_of_the_phase() {
    // 7/128 turn in a segment of 7/16 mm: single precision holds both, and 172 800 of them are 9450 turns.
    let parameters = Parameters::<f32> {
        drive: Drive::Distance { pitch: 8.0 },
        ..Parameters::default()
    };
    let mut precession = Precession::new(&parameters).unwrap();
    let at = |x: f32| Contact {
        p: Vector::new(x, 0.0, 0.0),
        n: Vector::Z,
    };
    precession.push(at(0.0)).unwrap();

    let mut last = None;
    for i in 1..=172_800 {
        let stretch = precession.push(at((i % 2) as f32 * 0.4375)).unwrap();
        last = stretch.last();
    }

    assert_eq!(last.unwrap().phase, Turn::ZERO);
}

#[test]
fn one_long_dwell_turns_evenly_to_its_last_pose() {
    let parameters = Parameters::<f32> {
        drive: Drive::Time { rate: 0.25 },
        dwell: 86_400.0,
        dpsi: 0.05,
        eps: 10.0,
        dt_max: 0.5,
        ..Parameters::default()
    };
    let point = flat::<f32>(&[[0.0, 0.0]]);
    let cycle = Cycle::new(&parameters, &point).unwrap();

    let mut before: Option<Turn> = None;
    let step = (0.125f64 / std::f64::consts::TAU) * 360.0;
    let mut poses = 0;
    for stance in cycle.stances() {
        if let Some(before) = before {
            let moved = phase_distance(stance.phase.to_degrees(), before.to_degrees());
            assert!((moved - step).abs() < 1e-6, "{moved} instead of {step}");
        }
        before = Some(stance.phase);
        poses += 1;
    }
    assert_eq!(poses, 172_801);
}
