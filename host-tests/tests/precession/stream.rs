//! Points that arrive one at a time.

use crate::common::*;
use hexstep::cycles::precession::{
    Contact, Cycle, Parameters, Precession, PrecessionError, Stance,
};
use hexstep::geometry::Vector;

fn streamed(parameters: &Parameters<f64>, path: &[Contact<f64>]) -> Vec<Stance<f64>> {
    let mut precession = Precession::new(parameters).unwrap();
    let mut poses = Vec::new();
    for contact in path {
        poses.extend(precession.push(*contact).unwrap());
    }
    poses.extend(precession.finish().unwrap());
    poses
}

#[test]
fn points_one_at_a_time_give_the_poses_of_the_whole_path() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let parameters = Parameters {
            reference: REFERENCES[seed as usize % 2],
            // A stream cannot look beyond the next point for the first move.
            first_reference: Some(random.direction()),
            dwell: 3.0,
            ..process()
        };
        let points = 1 + random.word() as usize % 12;
        let path = path(random.path(points));

        assert_eq!(
            streamed(&parameters, &path),
            stances(&parameters, &path),
            "seed {seed}"
        );
    }
}

#[test]
fn a_refused_point_emits_no_pose_and_changes_nothing() {
    let mut precession = Precession::<f64>::new(&process()).unwrap();
    let [a, b, c] = [0.0, 5.0, 9.0].map(|x| Contact {
        p: v(x, 0.0, 0.0),
        n: Vector::Z,
    });
    precession.push(a).unwrap();
    precession.push(b).unwrap();
    let before = precession.clone();
    let bad = [
        Contact {
            n: Vector::ZERO,
            ..c
        },
        Contact { n: -Vector::Z, ..c },
        Contact {
            p: v(f64::NAN, 0.0, 0.0),
            ..c
        },
        Contact {
            p: v(1e200, 0.0, 0.0),
            ..c
        },
        Contact {
            p: v(1e12, 0.0, 0.0),
            ..c
        },
    ];

    let errors = bad.map(|contact| precession.push(contact).unwrap_err().name());

    assert_eq!(
        errors,
        [
            "BadNormal",
            "AntiParallel",
            "NonFinite",
            "NonFinite",
            "BadLimit"
        ]
    );
    assert_eq!(precession, before);
    assert!(precession.push(c).unwrap().steps() > 0);
}

#[test]
fn a_stream_without_a_point_has_no_end() {
    let precession = Precession::<f64>::new(&Parameters::default()).unwrap();

    assert_eq!(precession.finish().unwrap_err(), PrecessionError::BadPath);
}

#[test]
fn a_copy_of_a_cycle_can_be_walked_for_checking() {
    let path = cylinder::<f64>();
    let mut cycle = Cycle::new(&process(), &path).unwrap();
    cycle.nth(40);

    let copy = cycle.clone();

    assert_eq!(copy.count(), 361 - 41);
    assert_eq!(cycle.count(), 361 - 41);
}

#[test]
fn between_points_a_stream_holds_less_than_256_bytes() {
    let size = size_of::<Precession<f32>>();

    assert!(size <= 256, "{size}");
}
