//! Screw chains: exponentials, forward map, Jacobian, damped Newton, joints held at a value.

mod common;

use common::{
    Random, UNIT, difference, exponential, matrix, rigid_inverse, rounded, rounded_pose, through,
    times,
};
use hexstep::geometry::{Pose, Twist, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::chain::{Carries, Chain, ChainError, Joint, Motion};
use hexstep::kinematics::inverse::{Failure, Target, Tolerance, rotation_vector};
use hexstep::kinematics::{Error, Kinematics};
use hexstep::machines::arm::Arm;
use hexstep::machines::two_sided::{m5_1, m5_2};
use std::f64::consts::{FRAC_PI_2, PI};

const HALF_OF_THE_NINTH_DIGIT: f64 = 0.51e-9;

fn at(x: f64, y: f64, z: f64) -> Vector<f64> {
    Vector::new(x, y, z)
}

/// A joint of random kind and axis; screws, turning and sliding joints on both chains.
fn random_joint(random: &mut Random) -> Joint<f64> {
    let carries = [Carries::Tool, Carries::Work][random.below(2)];
    let axis = random.direction() * random.between(0.1, 5.0);
    match random.below(3) {
        0 => Joint::linear(carries, axis).expect("an axis"),
        1 => Joint::rotary(carries, axis, random.point(500.0), 0.0).expect("an axis"),
        _ => {
            let pitch = random.between(-20.0, 20.0);
            Joint::rotary(carries, axis, random.point(500.0), pitch).expect("an axis")
        }
    }
}

fn random_chain<const N: usize>(random: &mut Random) -> Chain<N, f64> {
    let joints = std::array::from_fn(|_| random_joint(random));
    Chain::new(joints)
        .with_homes(random.pose(500.0), random.pose(500.0))
        .and_then(|chain| chain.with_tool(random.point(100.0), random.direction()))
        .expect("poses and an axis")
}

fn random_values<const N: usize>(random: &mut Random, chain: &Chain<N, f64>) -> Joints<N, f64> {
    Joints(std::array::from_fn(|i| match chain.joints()[i].motion() {
        Motion::Rotary => random.between(-3.0, 3.0),
        _ => random.between(-300.0, 300.0),
    }))
}

/// g_t and g_w as products of series exponentials.
fn reference<const N: usize>(chain: &Chain<N, f64>, q: &Joints<N, f64>) -> [common::Matrix; 2] {
    let series = chain.series();
    [
        (Carries::Tool, series.tool_home),
        (Carries::Work, series.work_home),
    ]
    .map(|(carries, home)| {
        let product = chain
            .joints()
            .iter()
            .zip(q.0)
            .filter(|(joint, _)| joint.carries() == carries)
            .fold(UNIT, |m, (joint, q)| {
                let twist = joint.twist();
                times(&m, &exponential(twist.v, twist.w, q))
            });
        times(&product, &matrix(&home))
    })
}

#[test]
fn the_exponentials_are_those_of_the_specification() {
    // Section 9: axis y through (0,0,450), 30 deg.
    let tilt = Twist::rotary(Vector::Y, at(0.0, 0.0, 450.0), 0.0).expect("an axis");
    assert_eq!(tilt.to_array(), [-450.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let p = tilt.exp(30f64.to_radians()).p;
    assert!((p - at(-225.0, 0.0, 60.288568297)).norm() < HALF_OF_THE_NINTH_DIGIT);
    // Axis z through (10,20,0), pitch 1.5 mm/rad, 90 deg.
    let screw = Twist::rotary(Vector::Z, at(10.0, 20.0, 0.0), 1.5).expect("an axis");
    assert_eq!(screw.to_array(), [20.0, -10.0, 1.5, 0.0, 0.0, 1.0]);
    let p = screw.exp(FRAC_PI_2).p;
    assert!((p - at(30.0, 10.0, 2.356194490)).norm() < HALF_OF_THE_NINTH_DIGIT);
    // A linear joint moves along its axis and turns nothing.
    let slide = Twist::linear(at(0.0, 3.0, 4.0)).expect("an axis");
    assert!((slide.exp(10.0).p - at(0.0, 6.0, 8.0)).norm() < 1e-14);
}

#[test]
fn an_axis_that_is_none_gives_no_twist() {
    assert_eq!(Twist::rotary(at(0.0, 0.0, 0.9e-6), Vector::ZERO, 0.0), None);
    assert_eq!(Twist::linear(at(f64::NAN, 0.0, 1.0)), None);
    assert_eq!(
        Twist::rotary(Vector::Z, at(f64::INFINITY, 0.0, 0.0), 0.0),
        None
    );
    let none = Joint::linear(Carries::Tool, Vector::<f64>::ZERO);
    assert_eq!(none.unwrap_err(), ChainError::BadAxis);
    let far = Joint::rotary(Carries::Tool, Vector::Z, at(f64::NAN, 0.0, 0.0), 0.0);
    assert_eq!(far.unwrap_err(), ChainError::NonFinite);
    let slide = Joint::linear(Carries::Tool, Vector::<f64>::Z).expect("an axis");
    assert_eq!(slide.with_limits([1.0, -1.0]), Err(ChainError::BadLimit));
    assert_eq!(
        slide.with_limits([f64::NAN, 1.0]),
        Err(ChainError::BadLimit)
    );
    let mut skew = Pose::IDENTITY;
    skew.rotation.n = at(1.0, 0.1, 0.0);
    let chain = Chain::new([slide]);
    assert_eq!(
        chain.with_homes(skew, Pose::IDENTITY),
        Err(ChainError::BadPose)
    );
    let no_axis = chain.with_tool(Vector::ZERO, Vector::ZERO);
    assert_eq!(no_axis, Err(ChainError::BadDirection));
}

#[test]
fn the_exponential_of_any_twist_is_that_of_its_series() {
    let mut random = Random(1);
    for _ in 0..5_000 {
        let joint = random_joint(&mut random);
        let theta = random.between(-7.0, 7.0);
        let twist = joint.twist();

        let own = matrix(&twist.exp(theta));

        let series = exponential(twist.v, twist.w, theta);
        for (a, b) in own.iter().flatten().zip(series.iter().flatten()) {
            assert!((a - b).abs() < 1e-9, "seed 1: {joint:?} by {theta}");
        }
    }
}

#[test]
fn frames_tip_and_axis_of_any_chain_are_the_products_of_exponentials() {
    let mut random = Random(2);
    let mut worst = 0.0_f64;
    for _ in 0..2_000 {
        let chain = random_chain::<7>(&mut random);
        let q = random_values(&mut random, &chain);
        let series = chain.series();

        let pose = chain.forward(&q);
        let (p, o) = chain.tip(&q);

        let [tool, work] = reference(&chain, &q);
        let relative = times(&rigid_inverse(&work), &tool);
        for (a, b) in matrix(&pose)
            .iter()
            .flatten()
            .zip(relative.iter().flatten())
        {
            worst = worst.max((a - b).abs());
        }
        worst = worst.max((p - through(&relative, series.tip, 1.0)).norm());
        worst = worst.max((o - through(&relative, series.axis, 0.0)).norm());
    }
    println!("largest difference to the series: {worst:.1e}");
    assert!(worst < 1e-9);
}

#[test]
fn each_column_of_the_jacobian_is_the_motion_of_the_tool_against_the_work() {
    let mut random = Random(3);
    for _ in 0..500 {
        let chain = random_chain::<6>(&mut random);
        let q = random_values(&mut random, &chain);

        let columns = chain.jacobian(&q);

        // Central difference of tip and axis, seen from the bed through the work frame of the middle.
        let work = chain.series().work(&q.0);
        let (p, o) = chain.tip(&q);
        for (j, column) in columns.iter().enumerate() {
            let h = 1e-5;
            let moved = |by: f64| {
                let mut q = q;
                q[j] += by;
                chain.tip(&q)
            };
            let ((p1, o1), (p0, o0)) = (moved(h), moved(-h));
            let dp = work.rotation * (p1 - p0) * (0.5 / h);
            let d_o = work.rotation * (o1 - o0) * (0.5 / h);
            let v = column.velocity_at(work.apply(p));
            assert!((v - dp).norm() < 1e-4, "seed 3: joint {j}: {v:?} {dp:?}");
            let turned = column.w.cross(work.rotation * o);
            assert!((turned - d_o).norm() < 1e-8, "seed 3: joint {j}");
        }
    }
}

#[test]
fn a_held_joint_is_the_same_machine_with_one_joint_less() {
    let mut random = Random(4);
    for _ in 0..1_000 {
        let chain = random_chain::<6>(&mut random);
        let q = random_values(&mut random, &chain);
        let index = random.below(6);

        let held = chain.held(index, q[index]);

        assert_eq!(held.joints()[index].motion(), Motion::Held);
        let mut other = q;
        other[index] = 12345.0;
        assert!(
            difference(&held.forward(&other), &chain.forward(&q)) < 1e-9,
            "seed 4"
        );
    }
}

/// The ER3B as six screws, from its drawing at theta = 0: no DH row.
fn er3b_as_screws() -> Chain<6, f64> {
    let turn = |axis, point| Joint::rotary(Carries::Tool, axis, point, 0.0).expect("an axis");
    let back = -Vector::<f64>::Z;
    let joints = [
        turn(Vector::Z, Vector::ZERO),
        turn(Vector::Y, at(50.0, 0.0, 320.0)),
        turn(Vector::Y, at(320.0, 0.0, 320.0)),
        turn(back, at(390.0, 0.0, 0.0)),
        turn(Vector::Y, at(390.0, 0.0, 21.0)),
        turn(back, at(390.0, 0.0, 0.0)),
    ];
    let home = Arm::<f64>::er3b().forward(&Joints([0.0; 6]));
    assert!((home.p - at(390.0, 0.0, 21.0 - 78.5)).norm() < 1e-9);
    Chain::new(joints)
        .with_homes(home, Pose::IDENTITY)
        .expect("poses")
}

#[test]
fn the_arm_as_six_screws_is_the_arm() {
    let (arm, screws) = (Arm::<f64>::er3b(), er3b_as_screws());
    let mut random = Random(5);
    for _ in 0..2_000 {
        let q = Joints(std::array::from_fn(|_| random.between(-3.0, 3.0)));
        assert!(difference(&screws.forward(&q), &arm.forward(&q)) < 1e-9);
    }
}

#[test]
fn newton_reaches_every_pose_of_the_arm_from_a_tenth_of_a_radian_away() {
    let chain = er3b_as_screws();
    let mut random = Random(6);
    let (mut iterations, mut most) = (0, 0);
    for _ in 0..2_000 {
        let q: Joints<6, f64> = Joints(std::array::from_fn(|_| random.between(-2.5, 2.5)));
        let near = Joints(q.0.map(|x| x + random.between(-0.1, 0.1)));
        let pose = chain.forward(&q);

        let found = Chain::inverse(&chain, &Target::Pose(pose), &near, &Tolerance::default());
        let answer =
            found.unwrap_or_else(|refused| panic!("seed 6: {q:?} from {near:?}: {refused:?}"));

        assert!(difference(&chain.forward(&answer.q), &pose) < 2e-9);
        iterations += answer.report.iterations;
        most = most.max(answer.report.iterations);
    }
    println!(
        "{:.1} iterations a pose, at most {most}",
        f64::from(iterations) / 2000.0
    );
}

#[test]
fn newton_never_answers_wrongly_from_anywhere() {
    // Starts at random, a quarter of the targets out of reach: an answer is right or is refused, with what it reached.
    let chain = er3b_as_screws();
    let mut random = Random(7);
    let (mut found, mut refused) = (0, 0);
    for i in 0..2_000 {
        let q: Joints<6, f64> = Joints(std::array::from_fn(|_| random.between(-3.0, 3.0)));
        let near = Joints(std::array::from_fn(|_| random.between(-3.0, 3.0)));
        let mut pose = chain.forward(&q);
        if i % 4 == 0 {
            pose.p = pose.p * 3.0;
        }

        match Chain::inverse(&chain, &Target::Pose(pose), &near, &Tolerance::default()) {
            Ok(answer) => {
                found += 1;
                assert!(difference(&chain.forward(&answer.q), &pose) < 2e-9);
            }
            Err(answer) => {
                refused += 1;
                let Failure::NoConvergence(report) = answer.why else {
                    panic!("seed 7: {answer:?}");
                };
                let reached = chain.forward(&answer.nearest);
                let tip = (reached.p - pose.p).norm();
                assert!((tip - report.tip_error).abs() < 1e-9);
                let turn = reached.rotation.transposed() * pose.rotation;
                let angle = rotation_vector(turn).norm();
                assert!((angle - report.direction_error).abs() < 1e-7);
                assert!(report.tip_error > 1e-9 || report.direction_error > 1e-12);
            }
        }
    }
    println!(
        "from anywhere: {found} reached, {refused} refused of which about 500 are out of reach"
    );
    assert!(found > 1_000);
}

#[test]
fn five_conditions_leave_the_turn_about_the_tool_free() {
    let chain = m5_1::<f64>();
    let (p, o) = (at(100.0, 50.0, -2.0), at(0.1, 0.05, 0.99));
    let near = Joints([700.0, 500.0, 0.0, 0.0, 0.0]);

    let answer = Chain::inverse(
        &chain,
        &Target::TipAxis { p, o },
        &near,
        &Tolerance::default(),
    )
    .expect("the machine has five axes");

    // calc.md, chain.inverse.
    let printed = [746.178749, 520.074413, -54.830386, 5.767889, -2.876656];
    let [x, y, z, b, a] = answer.q.0;
    let shown = [x, y, z, b.to_degrees(), a.to_degrees()];
    for (a, b) in shown.iter().zip(printed) {
        assert!((a - b).abs() < 0.51e-6, "{shown:?}");
    }
    // A redundant chain: the arm with its sixth joint turning freely.
    let arm = er3b_as_screws();
    let mut random = Random(8);
    for _ in 0..500 {
        let q: Joints<6, f64> = Joints(std::array::from_fn(|_| random.between(-2.5, 2.5)));
        let near = Joints(q.0.map(|x| x + random.between(-0.1, 0.1)));
        let (p, o) = arm.tip(&q);
        let answer = Chain::inverse(
            &arm,
            &Target::TipAxis { p, o },
            &near,
            &Tolerance::default(),
        );
        let (tip, axis) = arm.tip(&answer.expect("reachable").q);
        assert!((tip - p).norm() < 2e-9 && axis.angle_to(o) < 1e-10);
    }
}

#[test]
fn a_chain_with_seven_joints_takes_the_shortest_step_and_one_with_four_answers_only_what_it_can() {
    let mut random = Random(9);
    let mut solved = 0;
    for _ in 0..300 {
        let chain = random_chain::<7>(&mut random);
        let q = random_values(&mut random, &chain);
        let near = Joints(std::array::from_fn(|i| q[i] + random.between(-0.02, 0.02)));
        let pose = chain.forward(&q);
        if let Ok(answer) =
            Chain::inverse(&chain, &Target::Pose(pose), &near, &Tolerance::default())
        {
            solved += 1;
            assert!(
                difference(&chain.forward(&answer.q), &pose) < 1e-8,
                "seed 9"
            );
        }
    }
    // Seven random joints can all be sliding or screws along the same way; nearly all are not.
    assert!(solved > 240, "{solved} of 300");

    let four = hexstep::machines::two_sided::m4_1::<f64>();
    let reachable = Joints([700.0, 500.0, 10.0, 0.1]);
    let near = Joints([690.0, 495.0, 0.0, 0.0]);
    let (p, o) = four.tip(&reachable);
    let target = Target::TipAxis { p, o };
    let answer =
        Chain::inverse(&four, &target, &near, &Tolerance::default()).expect("it was there");
    assert!(
        answer
            .q
            .zip_map(&reachable, |a, b| a - b)
            .0
            .iter()
            .all(|d| d.abs() < 1e-8)
    );
    let sideways = Target::TipAxis {
        p,
        o: at(0.1, 0.05, 0.99),
    };
    let refused = Chain::inverse(&four, &sideways, &near, &Tolerance::default()).unwrap_err();
    assert!(matches!(refused.why, Failure::NoConvergence(_)));
}

#[test]
fn travel_is_kept_by_full_turns_or_refused_by_name() {
    let turn = Joint::rotary(Carries::Tool, Vector::<f64>::Z, Vector::ZERO, 0.0).expect("an axis");
    let slide = Joint::linear(Carries::Tool, Vector::<f64>::Z).expect("an axis");
    let limited = |lo: f64, hi: f64| {
        Chain::new([
            turn.with_limits([lo, hi]).expect("a range"),
            slide.with_limits([-10.0, 10.0]).expect("a range"),
        ])
    };
    let target = |angle: f64, z: f64| {
        Target::Pose(
            Twist::linear(Vector::Z).expect("an axis").exp(z) * {
                Twist::rotary(Vector::Z, Vector::ZERO, 0.0)
                    .expect("an axis")
                    .exp(angle)
            },
        )
    };
    let solve = |chain: &Chain<2, f64>, angle, z| {
        Chain::inverse(
            chain,
            &target(angle, z),
            &Joints([0.0; 2]),
            &Tolerance::default(),
        )
    };

    let turned = solve(&limited(3.0, 9.0), -0.5, 5.0).expect("one turn up");
    assert!((turned.q[0] - (2.0 * PI - 0.5)).abs() < 1e-9);
    let refused = solve(&limited(1.0, 2.0), -0.5, 5.0).unwrap_err();
    assert_eq!(refused.why, Failure::OutOfTravel { joint: 0 });
    let refused = solve(&limited(-1.0, 1.0), -0.5, 15.0).unwrap_err();
    assert_eq!(refused.why, Failure::OutOfTravel { joint: 1 });
}

#[test]
fn numbers_that_are_none_are_refused() {
    let chain = m5_2::<f64>();
    let zero = Joints([0.0; 5]);
    let solve = |p, o, near: &Joints<5, f64>, tolerance: Tolerance<f64>| {
        Chain::inverse(&chain, &Target::TipAxis { p, o }, near, &tolerance).map_err(|r| r.why)
    };
    let usual = Tolerance::default();

    assert_eq!(
        solve(at(f64::NAN, 0.0, 0.0), Vector::Z, &zero, usual),
        Err(Failure::NonFinite)
    );
    assert_eq!(
        solve(Vector::ZERO, Vector::ZERO, &zero, usual),
        Err(Failure::BadDirection)
    );
    let lost = Joints([f64::INFINITY, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        solve(Vector::ZERO, Vector::Z, &lost, usual),
        Err(Failure::NonFinite)
    );
    let strange = Tolerance {
        tip: f64::NAN,
        ..usual
    };
    assert_eq!(
        solve(Vector::ZERO, Vector::Z, &zero, strange),
        Err(Failure::NonFinite)
    );
    let mut skew = Pose::IDENTITY;
    skew.rotation.s = at(0.0, 2.0, 0.0);
    let refused = Chain::inverse(&chain, &Target::Pose(skew), &zero, &usual).unwrap_err();
    assert_eq!(refused.why, Failure::BadPose);
    assert_eq!(
        Kinematics::inverse(&chain, &skew, &zero),
        Err(Error::OutOfReach)
    );
}

#[test]
fn a_half_turn_away_the_search_still_moves() {
    // Exactly opposite axes have no shortest turn; any perpendicular must do.
    let chain = m5_1::<f64>();
    let near = Joints([600.0, 450.0, 0.0, 0.0, 0.0]);
    let target = Target::TipAxis {
        p: at(0.0, 0.0, 0.0),
        o: -Vector::Z,
    };

    let answer = Chain::inverse(&chain, &target, &near, &Tolerance::default()).expect("reachable");

    let (tip, axis) = chain.tip(&answer.q);
    assert!(tip.norm() < 2e-9 && axis.angle_to(-Vector::Z) < 1e-10);
}

#[test]
fn the_rotation_vector_is_exact_at_small_turns_and_at_half_turns() {
    let mut random = Random(10);
    for angle in [0.0, 1e-12, 1e-7, 0.3, 1.7, 3.0, PI - 1e-9, PI] {
        for _ in 0..200 {
            let axis = random.direction();
            let turn = Twist::rotary(axis, Vector::ZERO, 0.0)
                .expect("an axis")
                .exp(angle);
            let v = rotation_vector(turn.rotation);
            // At half a turn both axes are right.
            let off = (v - axis * angle).norm().min((v + axis * angle).norm());
            let same = if angle > 3.1 {
                off
            } else {
                (v - axis * angle).norm()
            };
            assert!(
                same < 1e-14 + 1e-15 * angle.max(1.0) * 20.0,
                "seed 10: {angle}: {same}"
            );
        }
    }
}

#[test]
fn single_precision_stays_within_a_thousandth_of_a_millimetre() {
    let mut random = Random(11);
    let (mut forward, mut solved) = (0.0_f64, 0);
    for _ in 0..2_000 {
        let mut joints32 = Vec::new();
        let chain = {
            // The same f32 numbers describe both machines.
            let joints: [Joint<f64>; 6] = std::array::from_fn(|i| {
                let carries = [Carries::Tool, Carries::Work][random.below(2)];
                let axis = rounded(random.direction());
                let point = rounded(random.point(150.0));
                let wide = |v| common::widened(v);
                if i < 3 {
                    joints32.push(Joint::linear(carries, axis).expect("an axis"));
                    Joint::linear(carries, wide(axis)).expect("an axis")
                } else {
                    joints32.push(Joint::rotary(carries, axis, point, 0.0).expect("an axis"));
                    Joint::rotary(carries, wide(axis), wide(point), 0.0).expect("an axis")
                }
            });
            Chain::new(joints)
        };
        let chain32 = Chain::new(std::array::from_fn(|i| joints32[i]));
        let q32: Joints<6, f32> = Joints(std::array::from_fn(|i| {
            let most = if i < 3 { 200.0 } else { 3.0 };
            random.between(-most, most) as f32
        }));
        let q = Joints(q32.0.map(f64::from));

        let pose = chain.forward(&q);
        let pose32 = chain32.forward(&q32);
        forward = forward.max((common::widened(pose32.p) - pose.p).norm());

        let near = Joints(q32.0.map(|x| x + 0.02));
        let target = Target::Pose(rounded_pose(pose));
        let tolerance = Tolerance::default();
        if let Ok(answer) = Chain::inverse(&chain32, &target, &near, &tolerance) {
            solved += 1;
            let reached = chain.forward(&Joints(answer.q.0.map(f64::from)));
            assert!((reached.p - pose.p).norm() < 2e-3, "seed 11");
        }
    }
    println!("f32: forward {forward:.1e} mm; inverse {solved} of 2000 within 1e-3 mm and 1e-4 deg");
    assert!(forward < 1e-3);
    assert!(solved > 1_900);
}
