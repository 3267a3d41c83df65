//! Stroke, passes, and the cycle's waypoints.

use crate::common::*;
use hexstep::cycles::drill_point::{Flank, Passes, Stroke};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::math::Real;

#[test]
fn the_stroke_of_example_1_ends_behind_its_last_contact() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let flank = Flank::of(wanted.diameter, wanted.web, &solution.cone).unwrap();

    let stroke = Stroke::new(
        &solution.cone,
        &flank,
        solution.chisel_end,
        60f64.to_radians(),
        2f64.to_radians(),
    )
    .unwrap();

    assert_close(stroke.tip.to_degrees(), 21.210, 5e-4);
    assert_close(stroke.chisel_far.to_degrees(), 50.739, 5e-4);
    assert_close(stroke.heel.unwrap().to_degrees(), 61.496, 5e-4);
    assert_close(stroke.start.to_degrees(), -2.0, 1e-12);
    assert_close(stroke.end.to_degrees(), 63.496, 5e-4);
    assert_close(stroke.lip_inner, 0.0, 1e-9);
}

#[test]
fn a_heel_beyond_the_cone_is_a_warning_and_does_not_lengthen_the_stroke() {
    let (wanted, _) = example_1::<f64>();
    let solution = wanted.solve(45f64.to_radians()).unwrap();
    let flank = Flank::of(wanted.diameter, wanted.web, &solution.cone).unwrap();

    let stroke = Stroke::new(&solution.cone, &flank, solution.chisel_end, 1.05, 0.0).unwrap();

    assert_eq!(stroke.warning().map(|w| w.name()), Some("HeelNotReached"));
    assert_eq!(stroke.end, stroke.chisel_far);
}

/// Section 7.
#[test]
fn the_passes_take_the_stock_in_the_published_stand_offs() {
    let plan = Passes::of(0.30f64).plan(118f64.to_radians()).unwrap();

    let wanted = [
        0.228756, 0.200363, 0.171969, 0.143575, 0.115181, 0.086788, 0.058394, 0.03, 0.02, 0.01,
        0.0, 0.0, 0.0,
    ];
    assert_eq!(plan.standoffs().count(), wanted.len());
    for (got, wanted) in plan.standoffs().zip(wanted) {
        assert_close(got, wanted, 6e-7);
    }
    assert_close(plan.infeed, 0.257150, 5e-7);
    assert_close(plan.rough_depth, 0.028394, 5e-7);
    assert_eq!(
        (plan.rough_passes, plan.finish_passes, plan.spark_out),
        (8, 3, 2)
    );
}

#[test]
fn a_small_stock_is_finished_without_roughing_and_rounding_adds_no_pass() {
    fn counts<R: Real>(stock: f64, point_angle: f64, finish_passes: u32) -> (u32, u32) {
        let passes = Passes {
            finish_passes,
            ..Passes::of(R::of(stock))
        };
        let plan = passes.plan(R::of(point_angle).to_radians()).unwrap();
        assert_eq!(plan.standoff(plan.strokes() - 1), R::ZERO);
        (plan.rough_passes, plan.finish_passes)
    }
    // sin 30 deg is a hair below one half: E = 0.15 = 3 x 0.01 + 4 x 0.03, or 5 x 0.03, or one finishing pass.
    for [rough, only_rough, small] in [
        [
            counts::<f64>(0.3, 60.0, 3),
            counts::<f64>(0.3, 60.0, 0),
            counts::<f64>(0.02, 60.0, 3),
        ],
        [
            counts::<f32>(0.3, 60.0, 3),
            counts::<f32>(0.3, 60.0, 0),
            counts::<f32>(0.02, 60.0, 3),
        ],
    ] {
        assert_eq!(rough, (4, 3));
        assert_eq!(only_rough, (5, 0));
        assert_eq!(small, (0, 1));
    }
    assert_eq!(counts::<f64>(0.06, 60.0, 3), (0, 3));
    assert_eq!(counts::<f64>(0.0601, 60.0, 3), (1, 3));
}

#[test]
fn a_cycle_walks_both_flanks_at_every_stand_off_in_the_order_of_its_table() {
    let (cycle, arm) = example_cycle::<f64>();
    let plan = *cycle.plan();
    let joints = joints_of(&cycle, &arm);
    let segments = cycle.segments() as usize;
    assert_eq!(segments, 82, "65.5 deg in steps of 0.8 deg");

    // Infeeds alone are timed by the infeed speed: 3 mm at 2 mm/s.
    let infeeds: Vec<_> = (0..joints.len()).filter(|i| joints[*i].1 == 1.5).collect();

    assert_eq!(infeeds.len(), 2 * plan.strokes() as usize);
    let start = arm
        .inverse(&cycle.pose(cycle.stroke().start, 0.0), &Joints::default())
        .unwrap();
    for (stroke, i) in infeeds.iter().enumerate() {
        let e = plan.standoff(stroke as u32 / 2);
        let roll = if stroke % 2 == 0 {
            0.0
        } else {
            180f64.to_radians()
        };
        let wanted = Joints([
            start[0],
            start[1] + e,
            start[2],
            start[3],
            start[4],
            start[5] + roll,
        ]);
        // From retracted by d2 alone, the stroke after it timed by mu, then out by d2 alone.
        for axis in 0..6 {
            assert_close(joints[*i].0[axis], wanted[axis], 1e-9);
            let clear = if axis == 1 { 3.0 } else { 0.0 };
            assert_close(joints[i - 1].0[axis] - wanted[axis], clear, 1e-9);
            let (last, out) = (joints[i + segments].0, joints[i + segments + 1].0);
            assert_close(out[axis] - last[axis], clear, 1e-9);
        }
        let strokes = &joints[i + 1..=i + segments];
        let duration: f64 = strokes.iter().map(|(_, t)| t).sum();
        assert_close(duration * 20.0, 65.496, 1e-3);
        assert_eq!(joints[i + segments + 1].1, 0.0);
    }
}

#[test]
fn the_cycle_indexes_in_quarter_turns_at_mu_start_and_winds_nothing_up() {
    let (cycle, arm) = example_cycle::<f64>();
    let joints = joints_of(&cycle, &arm);

    let quarter = std::f64::consts::FRAC_PI_2;
    let mut turns = Vec::new();
    for pair in joints.windows(2) {
        let turned = pair[1].0[5] - pair[0].0[5];
        assert!(turned.abs() < quarter + 1e-9);
        if turned.abs() > 0.5 {
            assert_close(turned.abs(), quarter, 1e-9);
            for axis in 0..5 {
                assert_close(pair[1].0[axis], pair[0].0[axis], 1e-9);
            }
            turns.push(turned.signum());
        }
    }

    let pattern = [1.0, 1.0, -1.0, -1.0];
    assert_eq!(turns.len(), 4 * cycle.plan().strokes() as usize);
    assert!(
        turns
            .iter()
            .enumerate()
            .all(|(i, turn)| *turn == pattern[i % 4])
    );
    let (first, last) = (joints[0].0, joints[joints.len() - 1].0);
    assert_close(first[5], last[5], 1e-9);
    assert_close(last[1] - first[1], -cycle.plan().standoff(0), 1e-9);
}

#[test]
fn a_copy_of_a_cycle_under_way_goes_on_alike_and_an_ended_one_stays_ended() {
    let (mut cycle, _) = example_cycle::<f32>();
    let whole: Vec<_> = cycle.clone().collect();
    for waypoint in &whole[..1000] {
        assert_eq!(cycle.next().as_ref(), Some(waypoint));
    }

    assert!(cycle.clone().eq(whole[1000..].iter().copied()));

    assert_eq!(cycle.by_ref().count(), whole.len() - 1000);
    assert_eq!((cycle.next(), cycle.pass()), (None, 13));
}
