//! The arm both ways, joints to steps, chords.

use crate::common::*;
use fixed::types::I32F32;
use hexstep::cycles::drill_point::{Motion, Variant};
use hexstep::geometry::{Pose, Vector};
use hexstep::joints::{Joints, whole_steps};
use hexstep::kinematics::{Error, Kinematics};
use hexstep_host::reference::grinding::Arm;

fn pose_error(a: &Pose<f64>, b: &Pose<f64>) -> f64 {
    let (p, q) = (a.rotation, b.rotation);
    let columns = [a.p - b.p, p.n - q.n, p.s - q.s, p.a - q.a];
    columns.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

#[test]
fn inverse_and_forward_of_the_arm_agree_on_random_joints() {
    let arm = machine(118f64.to_radians());
    let mut random = Random(6);
    for _ in 0..2000 {
        let joints = Joints([
            random.between(-200.0, 200.0),
            random.between(-200.0, 200.0),
            random.between(-200.0, 200.0),
            random.between(-9.0, 9.0),
            random.between(-1.57, 1.57),
            random.between(-9.0, 9.0),
        ]);
        let near = joints.zip_map(&Joints([1.0; 6]), |q, _| q + random.between(-1.0, 1.0));

        let found = arm.inverse(&arm.forward(&joints), &near).unwrap();

        // The singular pose is at most 1/1000 rad away, which costs three digits.
        for i in 0..6 {
            assert_close(found[i], joints[i], 1e-9);
        }
    }
}

#[test]
fn the_arm_and_the_product_of_elementary_rotations_agree() {
    let point_angle = 118f64.to_radians();
    let arm = machine(point_angle);
    let reference = Arm {
        point_angle,
        l1: L1,
        l2: L2,
    };
    let mut random = Random(7);
    for _ in 0..500 {
        let joints: [f64; 6] = std::array::from_fn(|_| random.between(-7.0, 7.0));

        let pose = arm.forward(&Joints(joints));

        let (rotation, tip) = reference.forward(&joints);
        let columns = [pose.rotation.n, pose.rotation.s, pose.rotation.a].map(Vector::to_array);
        for i in 0..3 {
            assert_close(pose.p.to_array()[i], tip[i], 1e-12);
            for j in 0..3 {
                assert_close(columns[j][i], rotation[i][j], 1e-14);
            }
        }
    }
}

#[test]
fn at_the_singular_pose_theta1_stays_where_it_was() {
    let arm = machine(118f64.to_radians());
    let degrees = |d: [f64; 3], t: [f64; 3]| {
        let t = t.map(f64::to_radians);
        Joints([d[0], d[1], d[2], t[0], t[1], t[2]])
    };
    let joints = degrees([1.0, 2.0, 3.0], [20.0, 90.0, 50.0]);
    let pose = arm.forward(&joints);

    let kept = arm.inverse(&pose, &joints).unwrap();
    let fresh = arm.inverse(&pose, &Joints::default()).unwrap();

    for i in 0..6 {
        assert_close(kept[i], joints[i], 1e-9);
    }
    assert_close(fresh[3], 0.0, 0.0);
    assert_close(fresh[5].to_degrees(), 30.0, 1e-9);
    assert!(pose_error(&arm.forward(&fresh), &pose) < 1e-12);

    let below = degrees([1.0, 2.0, 3.0], [20.0, -90.0, 50.0]);
    let found = arm.inverse(&arm.forward(&below), &below).unwrap();
    for i in 0..6 {
        assert_close(found[i], below[i], 1e-9);
    }
}

#[test]
fn a_pose_that_is_not_finite_has_no_joints() {
    let arm = machine(118f64.to_radians());
    let mut pose = Pose::IDENTITY;
    pose.p.y = f64::NAN;
    let mut near = Joints::default();
    near[0] = f64::INFINITY;

    assert_eq!(
        arm.inverse(&pose, &Joints::default()),
        Err(Error::NotFinite)
    );
    assert_eq!(arm.inverse(&Pose::IDENTITY, &near), Err(Error::NotFinite));
}

#[test]
fn a_stand_off_moves_d2_alone_and_by_exactly_itself() {
    let point = 118f64.to_radians();
    let arm = machine(point);
    let motion = Motion::new(&printed_1(), point, Variant::Exact).unwrap();
    for mu in [-5.0, 0.0, 20.0, 60.0f64] {
        let moved = motion.at(mu.to_radians());
        let at = |e: f64| {
            let p = arm.home_tip() + moved.p + arm.away() * e;
            arm.inverse(&Pose { p, ..moved }, &Joints::default())
                .unwrap()
        };
        let change = at(0.7).zip_map(&at(0.0), |a, b| a - b);
        for (i, wanted) in [0.0, 0.7, 0.0, 0.0, 0.0, 0.0].iter().enumerate() {
            assert_close(change[i], *wanted, 1e-12);
        }
    }
}

/// Section 14: order d1 d2 d3 theta1 theta2 theta3, 0.001 mm and 0.0005 deg a step.
#[test]
fn joints_round_to_the_published_steps() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let motion = Motion::new(&solution.cone, wanted.point_angle, Variant::Exact).unwrap();
    let arm = machine(wanted.point_angle);
    let turn = 1.0 / 0.0005f64.to_radians();
    let scale = Joints([1000.0, 1000.0, 1000.0, turn, turn, turn]);

    let steps = [-2.0, -1.2, -0.4, 0.4f64].map(|mu| {
        let moved = motion.at(mu.to_radians());
        let p = arm.home_tip() + moved.p;
        let joints = arm
            .inverse(&Pose { p, ..moved }, &Joints::default())
            .unwrap();
        whole_steps(&joints.to_steps(&scale).unwrap())
    });

    let table = [
        [2543, 49, 157, 100, -1997, 3463],
        [1525, 37, 101, 67, -1198, 2078],
        [508, 15, 36, 25, -399, 693],
        [-508, -17, -38, -27, 399, -693],
    ];
    assert_eq!(steps, table);
    let first: [i32; 6] = std::array::from_fn(|i| steps[1][i] - steps[0][i]);
    assert_eq!(first, [-1018, -12, -56, -33, 799, -1385]);
}

#[test]
fn steps_have_fractions_and_know_their_limit() {
    let fixed = |x: f64| Joints([x]).to_steps(&Joints([1.0]));
    let steps = |x: f64| fixed(x).map(|steps| whole_steps(&steps));

    assert_eq!(
        [2.5, -2.25, 0.125].map(fixed),
        [2.5, -2.25, 0.125].map(|x| Some([I32F32::from_num(x)]))
    );
    // As the planner comes to rest: halves go up.
    assert_eq!(
        [2.5, -2.5, 0.5, -0.5].map(steps),
        [3, -2, 1, 0].map(|i| Some([i]))
    );
    assert_eq!(steps(2147483647.4), Some([i32::MAX]));
    assert_eq!(steps(2147483647.5), None);
    assert_eq!(steps(-2147483648.4), Some([i32::MIN]));
    assert_eq!(steps(-2147483649.0), None);
    assert_eq!(steps(f64::NAN), None);
    assert_eq!(Joints([3e9f32]).to_steps(&Joints([1.0])), None);
    // 300 mm and a bit of them, 10 000 steps/mm: a product in f32 is a quarter of a step.
    let (q, scale) = (300.000_03f32, 10_000.0f32);
    let [at] = Joints([q]).to_steps(&Joints([scale])).unwrap();
    let exact = f64::from(q) * f64::from(scale);
    assert!((at.to_num::<f64>() - exact).abs() < 1e-9, "{at} {exact}");
}

/// Section 9, micrometres and 0.001 deg; the largest over 64 places in each segment, by the reference arm.
#[test]
fn chords_of_the_stroke_stray_by_as_much_as_the_table_says() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let motion = Motion::new(&solution.cone, wanted.point_angle, Variant::Exact).unwrap();
    let arm = machine(wanted.point_angle);
    let reference = Arm {
        point_angle: wanted.point_angle,
        l1: L1,
        l2: L2,
    };
    let exact = |mu: f64| {
        let moved = motion.at(mu);
        Pose {
            p: arm.home_tip() + moved.p,
            ..moved
        }
    };
    let table = [
        (12, 37.28, 30.6, 0.006, 0.06),
        (20, 13.46, 11.0, 0.006, 0.06),
        (30, 5.987, 4.92, 0.0006, 0.006),
        (60, 1.498, 1.230, 0.0006, 0.0006),
        (74, 0.9853, 0.809, 0.00006, 0.0006),
        (75, 0.9592, 0.788, 0.00006, 0.0006),
        (120, 0.3748, 0.308, 0.00006, 0.0006),
        (240, 0.0937, 0.0770, 0.00006, 0.00006),
        (600, 0.0150, 0.0123, 0.00006, 0.00006),
    ];
    for (segments, tip, orientation, tip_tolerance, orientation_tolerance) in table {
        let sample = |i: i32| (f64::from(i) / f64::from(segments) * 60.0 - 5.0).to_radians();
        let (mut tip_error, mut turn_error) = (0f64, 0f64);
        let mut before = arm.inverse(&exact(sample(0)), &Joints::default()).unwrap();
        for i in 0..segments {
            let after = arm.inverse(&exact(sample(i + 1)), &before).unwrap();
            for k in 1..64 {
                let u = f64::from(k) / 64.0;
                let joints = before.zip_map(&after, |a, b| a + (b - a) * u);
                let wanted = exact(sample(i) + (sample(i + 1) - sample(i)) * u);
                let (off, turned) = reference_error(&reference, &joints.0, &wanted);
                tip_error = tip_error.max(off);
                turn_error = turn_error.max(turned);
            }
            before = after;
        }
        assert_close(tip_error * 1e3, tip, tip_tolerance);
        assert_close(
            turn_error.to_degrees() * 1e3,
            orientation,
            orientation_tolerance,
        );
    }
}
