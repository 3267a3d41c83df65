//! Single precision against double.

use crate::common::*;
use hexstep::cycles::drill_point::{Motion, Variant};
use hexstep::geometry::{Pose, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::math::Real;
use hexstep_host::reference::grinding::Arm;

/// Largest errors of a stroke in f32 against f64, solve included: tip [um], orientation [0.001 deg], both through the
/// joints and the reference arm in f64.
fn single_precision_error(fields: [f64; 6]) -> Option<(f64, f64)> {
    let [d, w, point, chisel, clearance, phi] = fields;
    let exact = drill::<f64>(d, w, point, chisel, clearance);
    let single = drill::<f32>(d, w, point, chisel, clearance);
    let exact = exact.solve(phi.to_radians()).ok()?;
    let single = single.solve(Real::to_radians(phi as f32)).ok()?;
    let point_angle = point.to_radians();
    let exact = Motion::new(&exact.cone, point_angle, Variant::Exact).unwrap();
    let single_angle = Real::to_radians(point as f32);
    let single = Motion::new(&single.cone, single_angle, Variant::Exact).unwrap();
    let arm = machine(single_angle);
    let reference = Arm {
        point_angle,
        l1: L1,
        l2: L2,
    };
    let mut near = Joints::<6, f32>::default();
    let (mut tip, mut turn) = (0f64, 0f64);
    for degrees in -5..=70 {
        let moved = single.at(Real::to_radians(degrees as f32));
        let p = arm.home_tip() + moved.p + arm.away() * 0.1;
        near = arm.inverse(&Pose { p, ..moved }, &near).unwrap();
        let moved = exact.at(f64::from(degrees).to_radians());
        let half = point_angle / 2.0;
        let away = Vector::new(half.sin(), half.cos(), 0.0) * 0.1;
        let wanted = Pose {
            p: home_tip() + moved.p + away,
            ..moved
        };
        let (off, turned) = reference_error(&reference, &near.0.map(f64::from), &wanted);
        tip = tip.max(off);
        turn = turn.max(turned);
    }
    Some((tip * 1e3, turn.to_degrees() * 1e3))
}

/// Measured with this very test; libm gives the same on every host. The goal is 1 um and 0.001 deg.
#[test]
fn single_precision_keeps_the_tip_within_a_micrometre() {
    let mut rows = vec![
        single_precision_error([9.9, 1.63, 118.0, 50.0, 10.0, 30.0]).unwrap(),
        single_precision_error([7.0, 1.03, 118.0, 50.0, 12.0, 40.0]).unwrap(),
    ];
    let (mut tips, mut turns, mut beyond) = (Vec::new(), Vec::new(), 0);
    let mut random = Random(8);
    for _ in 0..400 {
        let fields = random.drill();
        let Some((tip, turn)) = single_precision_error(fields) else {
            continue;
        };
        turns.push(turn);
        // Where clearance and chisel angle all but exclude each other the apex runs away, and the rounding of the
        // inputs alone moves it by more than this; such a cone is larger than any grinder.
        let angles = [2, 3, 4].map(|i| fields[i]);
        let wanted = drill::<f64>(fields[0], fields[1], angles[0], angles[1], angles[2]);
        let apex = wanted
            .solve(fields[5].to_radians())
            .unwrap()
            .cone
            .tip
            .norm();
        if apex < 10.0 * fields[0] {
            tips.push(tip);
        } else {
            beyond += 1;
        }
    }
    tips.sort_by(f64::total_cmp);
    turns.sort_by(f64::total_cmp);
    rows.push((tips[tips.len() / 2], turns[turns.len() / 2]));
    rows.push((tips[tips.len() - 1], turns[turns.len() - 1]));

    //           tip [um]  orientation [0.001 deg]
    let kept = [
        (0.026, 0.0055), // example 1
        (0.028, 0.0090), // example 2
        (0.024, 0.0080), // random drills, median
        (0.211, 0.0210), // random drills, worst
    ];
    for (row, kept) in rows.iter().zip(kept) {
        assert!(
            row.0 <= kept.0 && row.1 <= kept.1,
            "{rows:?} beyond {kept:?}"
        );
    }
    assert!(
        beyond <= 8 && tips.len() > 300,
        "{beyond} of {}",
        tips.len()
    );
}

#[test]
fn a_cycle_in_single_precision_follows_the_one_in_double_waypoint_by_waypoint() {
    let (single, single_arm) = example_cycle::<f32>();
    let (double, _) = example_cycle::<f64>();
    let reference = Arm {
        point_angle: 118f64.to_radians(),
        l1: L1,
        l2: L2,
    };
    let joints = joints_of(&single, &single_arm);
    assert_eq!(joints.len(), double.clone().count());

    for ((joints, duration), wanted) in joints.iter().zip(double) {
        let joints = joints.0.map(f64::from);
        let (off, turned) = reference_error(&reference, &joints, &wanted.pose);
        assert!(
            off < 0.1e-3 && turned.to_degrees() < 0.05e-3,
            "{off:e} {turned:e}"
        );
        assert_close(f64::from(*duration), wanted.duration, 1e-6);
    }
}
