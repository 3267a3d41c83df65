//! The contests of the duel: the points that all systems were given, and figures that a motion known in closed form has.

use hexstep::stepper::StepMode;
use hexstep_host::duel::{self, Contest, Figures, Steady};
use hexstep_host::report::ContourError;
use hexstep_host::trace::{TICK_HZ, Trace};
use std::f64::consts::SQRT_2;

fn contest(name: &str) -> Contest {
    let found = duel::contests().into_iter().find(|c| c.name == name);
    found.expect("a contest of that name")
}

#[test]
fn the_paths_are_those_that_the_others_were_given() {
    // Points, the last of them, and the length that was noted when they were made for all systems.
    for (name, count, end, length) in [
        ("a-circle", 10_000, [0.0, 0.0, 0.0], 125.663_711_02),
        ("b-circle", 216, [0.0, 0.0, 0.0], 94.217_866_17),
        ("c-raster", 10_019, [0.0, 9.5, 0.0], 1_050.123_612_82),
        ("d-zig90", 101, [142.835_57, SQRT_2, 0.0], 201.999_745_73),
        ("d-zig135", 101, [77.302_05, 1.847_76, 0.0], 202.000_085_99),
        (
            "e-random",
            500,
            [-9.073_32, -2.349_59, -11.247_8],
            125.736_311_73,
        ),
        ("f-square", 4, [0.0, 0.0, 0.0], 400.0),
        ("g-star", 36, [0.0, 0.0, 0.0], 1_439.999_953_07),
    ] {
        let points = contest(name).points;
        let mut from = [0.0; 6];
        let mut way = 0.0;
        for at in &points {
            let squares = at.iter().zip(&from).map(|(a, b)| (a - b).powi(2));
            way += squares.sum::<f64>().sqrt();
            from = *at;
        }
        println!("{name}: {} points to {from:?}, {way} mm", points.len());
        assert_eq!(points.len(), count, "{name}");
        assert!((way - length).abs() < 1e-7, "{name}: {way}");
        for (a, b) in from.iter().zip(end) {
            assert!((a - b).abs() < 2e-5, "{name}: {from:?}");
        }
    }
}

#[test]
fn every_contest_has_its_peers_and_one_with_all_joints() {
    let contests = duel::contests();
    let peers = duel::peers();

    assert_eq!(contests.len(), 16);
    assert_eq!(peers.len(), 64);
    for (three, six) in contests[..8].iter().zip(&contests[8..]) {
        assert_eq!(peers.iter().filter(|p| p.contest == three.name).count(), 8);
        assert!(six.name.starts_with(three.name) && six.points.len() == three.points.len());
        for (a, b) in three.points.iter().zip(&six.points) {
            assert_eq!(a[..3], b[..3]);
        }
        let turns = |joint: usize| six.points.iter().any(|p| p[joint] != 0.0);
        assert!((3..6).all(turns), "{}", six.name);
    }
}

/// 10 mm of one joint at 1000 steps/mm by x = 5 (1 - cos(w t)), w = 2 pi / s: speed 5 w, acceleration 5 w^2 at both ends.
#[test]
fn figures_of_a_cosine_are_its_own() {
    let (steps, w) = (1000.0, std::f64::consts::TAU);
    let mut trace = Trace::new(StepMode::BothEdge);
    for n in 0..10_000 {
        // Half steps are crossed on the way from n to n + 1.
        let x = (f64::from(n) + 0.5) / steps;
        let t = 1.0 + (1.0 - x / 5.0).acos() / w;
        trace.tick((t * TICK_HZ as f64) as u64);
        trace.steps(u8::from(n % 2 == 0));
    }
    let line = [[0.0; 6], [10.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
    let contour = ContourError::of(&trace, &line, &[steps; 6], &[1.0; 6], false);

    let f = Figures::of(&trace, steps, &contour, Steady::Legs(1, 0.4, 0.6));

    // Half a step at either end is missing.
    assert!((f.time - 0.5).abs() < 0.005, "{}", f.time);
    assert!(
        (f.velocity[0] / (5.0 * w) - 1.0).abs() < 1e-3,
        "{:?}",
        f.velocity
    );
    // The ends jump from rest to 5 w^2: rounded off by the filter, but half of it and more is left, and never more.
    let share = f.acceleration[0] / (5.0 * w * w);
    assert!(share > 0.7 && share < 1.01, "{share}");
    assert!(f.aside < 1e-6 && f.cut < 1e-6, "{f:?}");
    let (ripple, feed) = f.ripple.expect("it has a stretch");
    assert!(
        ripple < 0.04 && (feed / (5.0 * w) - 1.0).abs() < 0.02,
        "{ripple} {feed}"
    );
}
