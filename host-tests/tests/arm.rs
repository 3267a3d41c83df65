//! Six-axis arm: forward, eight branches, ranges, singular poses, one branch for a stretch.

mod common;

use common::{Matrix, Random, UNIT, difference, rounded_pose, times, widened_pose};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::machines::arm::{
    Arm, ArmError, DhRow, Lengths, Refusal, Stretch, forward_of_table, table,
};
use rs_opw_kinematics::kinematic_traits::{Kinematics as _, Pose as PeerPose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use std::f64::consts::{PI, TAU};

fn radians(degrees: [f64; 6]) -> Joints<6, f64> {
    Joints(degrees.map(f64::to_radians))
}

/// Smallest difference of two angles, turns left out [rad].
fn apart(a: f64, b: f64) -> f64 {
    ((a - b + PI).rem_euclid(TAU) - PI).abs()
}

fn random_joints(random: &mut Random, arm: &Arm<f64>) -> Joints<6, f64> {
    Joints(arm.limits().map(|[lo, hi]| random.between(lo, hi)))
}

/// Product of the six modified DH matrices of the ER3B, from the printed table.
fn reference(q: &Joints<6, f64>) -> Matrix {
    let rows = [
        (0.0, 0.0, 320.0),
        (50.0, -90.0, 0.0),
        (270.0, 0.0, 0.0),
        (70.0, -90.0, 299.0),
        (0.0, 90.0, 0.0),
        (0.0, -90.0, 78.5),
    ];
    let mut pose = UNIT;
    for ((a, alpha, d), theta) in rows.iter().zip(q.0) {
        let (sa, ca) = f64::to_radians(*alpha).sin_cos();
        let (st, ct) = theta.sin_cos();
        let link = [
            [ct, -st, 0.0, *a],
            [st * ca, ct * ca, -sa, -d * sa],
            [st * sa, ct * sa, ca, d * ca],
            [0.0, 0.0, 0.0, 1.0],
        ];
        pose = times(&pose, &link);
    }
    pose
}

fn pose_of(m: &Matrix) -> Pose<f64> {
    let column = |j: usize| Vector::new(m[0][j], m[1][j], m[2][j]);
    Pose {
        rotation: Rotation {
            n: column(0),
            s: column(1),
            a: column(2),
        },
        p: column(3),
    }
}

/// Specification of surface grinding, section 11: joints in degrees, rows of [R | p].
const PRINTED: [([f64; 6], [[f64; 4]; 3]); 5] = [
    (
        [0.0, -90.0, 0.0, 0.0, 90.0, 0.0],
        [
            [1.0, 0.0, 0.0, 349.0],
            [0.0, -1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0, 581.5],
        ],
    ),
    (
        [30.0, -60.0, 20.0, 40.0, -50.0, 120.0],
        [
            [-0.091007, -0.070804, 0.993330, 451.074535],
            [-0.580040, 0.814573, 0.004920, 215.794551],
            [-0.809488, -0.575723, -0.115201, 360.731454],
        ],
    ),
    (
        [-75.0, -120.0, 60.0, -100.0, 75.0, -200.0],
        [
            [-0.328382, -0.433640, -0.839119, -11.792810],
            [0.529593, 0.651079, -0.543716, -244.503810],
            [0.782110, -0.622939, 0.015850, 466.192863],
        ],
    ),
    (
        [170.0, 10.0, -40.0, 150.0, -120.0, 400.0],
        [
            [0.187951, 0.202648, 0.961045, -442.586399],
            [-0.792864, -0.546205, 0.270234, 112.555794],
            [0.579690, -0.812769, 0.058013, 53.727393],
        ],
    ),
    (
        [10.0, -45.0, 100.0, -30.0, 110.0, 15.0],
        [
            [-0.753132, 0.649884, -0.102186, 27.572053],
            [-0.528130, -0.689885, -0.495113, -32.590217],
            [-0.392262, -0.318918, 0.862799, 349.808534],
        ],
    ),
];

/// Half of the sixth decimal.
const PRINTED_DIGITS: f64 = 0.51e-6;

#[test]
fn the_flange_stands_where_the_specification_prints_it() {
    let arm = Arm::<f64>::er3b();
    for (degrees, rows) in PRINTED {
        let q = radians(degrees);
        let [r0, r1, r2] = rows;
        let printed = pose_of(&[r0, r1, r2, [0.0, 0.0, 0.0, 1.0]]);

        let closed = arm.forward(&q);
        let product = forward_of_table(&table(arm.lengths()), &q);

        assert!(
            difference(&closed, &printed) <= PRINTED_DIGITS,
            "{degrees:?}"
        );
        assert!(
            difference(&product, &printed) <= PRINTED_DIGITS,
            "{degrees:?}"
        );
    }
    // Upper arm vertical, forearm level: flange at (427.5, 0, 660), z forward.
    let level = arm.forward(&radians([0.0, -90.0, 0.0, 0.0, 0.0, 0.0]));
    assert!((level.p - Vector::new(427.5, 0.0, 660.0)).norm() < 1e-9);
    assert!((level.rotation.a - Vector::X).norm() < 1e-12);
}

#[test]
fn the_eight_branches_are_those_of_the_specification() {
    let arm = Arm::<f64>::er3b();
    let pose = arm.forward(&radians([30.0, -60.0, 20.0, 40.0, -50.0, 120.0]));

    let found = arm.inverse(&pose, None).expect("within reach");

    let printed = [
        ([30.0, -60.0, 20.0, -140.0, 50.0, -60.0], true),
        ([30.0, -60.0, 20.0, 40.0, -50.0, 120.0], true),
        (
            [
                30.0,
                45.106718,
                -173.647162,
                -38.115691,
                52.914485,
                173.658860,
            ],
            false,
        ),
        (
            [
                30.0,
                45.106718,
                -173.647162,
                141.884309,
                -52.914485,
                -6.341140,
            ],
            false,
        ),
        (
            [
                -150.0, 150.317310, -10.451094, 146.138262, 62.095141, 165.774768,
            ],
            false,
        ),
        (
            [
                -150.0, 150.317310, -10.451094, -33.861738, -62.095141, -14.225232,
            ],
            false,
        ),
        (
            [
                -150.0,
                -138.496762,
                -143.196068,
                82.819965,
                29.755225,
                -113.402820,
            ],
            false,
        ),
        (
            [
                -150.0,
                -138.496762,
                -143.196068,
                -97.180035,
                -29.755225,
                66.597180,
            ],
            false,
        ),
    ];
    assert_eq!(found.as_slice().len(), 8);
    for (number, (solution, (degrees, in_limits))) in
        found.as_slice().iter().zip(printed).enumerate()
    {
        assert_eq!(usize::from(solution.branch), number);
        assert_eq!(solution.in_limits, in_limits, "branch {number}");
        assert!(
            !solution.wrist_singular && !solution.elbow_singular && !solution.shoulder_singular
        );
        for (q, degrees) in solution.q.0.iter().zip(degrees) {
            assert!(
                (q.to_degrees() - degrees).abs() <= PRINTED_DIGITS,
                "branch {number}"
            );
        }
    }
}

#[test]
fn a_full_turn_brings_the_other_shoulder_into_range() {
    let arm = Arm::<f64>::er3b();
    let pose = arm.forward(&radians([10.0, -120.0, 60.0, 25.0, 60.0, -40.0]));

    let found = arm.inverse(&pose, None).expect("within reach");

    let in_range: Vec<u8> = found
        .as_slice()
        .iter()
        .filter(|s| s.in_limits)
        .map(|s| s.branch)
        .collect();
    assert_eq!(in_range, [0, 1, 6, 7]);
    let printed = [
        (
            6,
            [
                -170.0,
                -85.342507,
                164.670543,
                -158.005701,
                77.758005,
                -31.770920,
            ],
        ),
        (
            7,
            [
                -170.0, -85.342507, 164.670543, 21.994299, -77.758005, 148.229080,
            ],
        ),
    ];
    for (branch, degrees) in printed {
        let solution = found.branch(branch).expect("both shoulders reach");
        for (q, degrees) in solution.q.0.iter().zip(degrees) {
            assert!(
                (q.to_degrees() - degrees).abs() <= PRINTED_DIGITS,
                "branch {branch}"
            );
        }
    }
}

#[test]
fn the_tool_touches_the_corners_of_the_dune_surface() {
    // Work frame at (340, -75, 300), tool 110 long; u = 0 is the corner (0, 0, 5), u = 1 the corner (200, 0, 5).
    let arm = Arm::<f64>::er3b();
    let ends = [
        (
            [
                -10.002754, -89.170319, 30.774471, -5.330318, 57.711970, -7.180855,
            ],
            0.0,
        ),
        (
            [
                -6.336841, -46.160490, -26.583500, -4.772430, 72.295817, -4.902559,
            ],
            200.0,
        ),
    ];
    for (degrees, x) in ends {
        let flange = arm.forward(&radians(degrees));
        let tip = flange.p + flange.rotation.a * 110.0;
        let corner = Vector::new(340.0 + x, -75.0, 305.0);
        // Six decimals of a degree at 700 mm.
        assert!((tip - corner).norm() < 2e-5, "{tip:?}");
    }
}

#[test]
fn every_branch_of_every_pose_returns_to_that_pose() {
    let arm = Arm::<f64>::er3b();
    let mut random = Random(1);
    let mut worst = 0.0_f64;
    for _ in 0..20_000 {
        let q = random_joints(&mut random, &arm);
        let pose = pose_of(&reference(&q));

        let found = arm.inverse(&pose, Some(&q)).expect("it came from joints");

        let own = found.branch(arm.branch_of(&q)).expect("its own branch");
        assert!(own.in_limits);
        if !(own.wrist_singular || own.elbow_singular || own.shoulder_singular) {
            for (a, b) in own.q.0.iter().zip(q.0) {
                assert!((a - b).abs() < 1e-8, "seed 1: {own:?} from {q:?}");
            }
        }
        for solution in found.as_slice() {
            worst = worst.max(difference(&pose_of(&reference(&solution.q)), &pose));
            if !solution.elbow_singular && !solution.wrist_singular {
                assert_eq!(arm.branch_of(&solution.q), solution.branch);
            }
            for (joint, (q, [lo, hi])) in solution.q.0.iter().zip(arm.limits()).enumerate() {
                let inside = (lo - 1e-12..=hi + 1e-12).contains(q);
                assert!(inside || !solution.in_limits, "joint {joint}");
            }
        }
    }
    println!("largest residual of forward(inverse): {worst:.1e} (mm and direction cosines)");
    assert!(worst < 1e-8);
}

#[test]
fn the_solutions_are_those_of_the_peer() {
    // rs-opw-kinematics, parameters as the specification gives them.
    let arm = Arm::<f64>::er3b();
    let peer = OPWKinematics::new(peer_parameters());
    let mut random = Random(2);
    let (mut solutions, mut worst) = (0, 0.0_f64);
    for _ in 0..10_000 {
        let pose = arm.forward(&random_joints(&mut random, &arm));

        let own = arm.inverse(&pose, None).expect("it came from joints");
        let theirs = peer.inverse(&peer_pose(&pose));

        // Sets modulo full turns: each of ours among theirs, each of theirs among ours.
        let distance = |a: &[f64; 6], b: &[f64; 6]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| apart(*a, *b))
                .fold(0.0, f64::max)
        };
        for a in own.as_slice() {
            let nearest = theirs
                .iter()
                .map(|b| distance(&a.q.0, b))
                .fold(f64::INFINITY, f64::min);
            assert!(
                nearest < 1e-6,
                "seed 2: ours {a:?} is {nearest} from theirs {theirs:?}"
            );
            worst = worst.max(nearest);
            solutions += 1;
        }
        for b in &theirs {
            let nearest = own.as_slice().iter().map(|a| distance(&a.q.0, b));
            assert!(
                nearest.fold(f64::INFINITY, f64::min) < 1e-6,
                "seed 2: theirs {b:?}"
            );
        }
    }
    println!("{solutions} solutions on 10000 poses, largest difference {worst:.1e} rad");
}

fn peer_parameters() -> Parameters {
    Parameters {
        a1: 50.0,
        a2: -70.0,
        b: 0.0,
        c1: 320.0,
        c2: 270.0,
        c3: 299.0,
        c4: 78.5,
        offsets: [0.0, -90.0, -90.0, 0.0, 0.0, -180.0].map(f64::to_radians),
        sign_corrections: [1; 6],
        dof: 6,
    }
}

fn peer_pose(pose: &Pose<f64>) -> PeerPose {
    let Rotation { n, s, a } = pose.rotation;
    let columns = glam::DMat3::from_cols_array_2d(&[n.to_array(), s.to_array(), a.to_array()]);
    PeerPose {
        translation: glam::DVec3::from_array(pose.p.to_array()),
        rotation: glam::DQuat::from_mat3(&columns).normalize(),
    }
}

/// `cargo test --release -p host-tests --test arm -- --ignored --nocapture`
#[test]
#[ignore = "a measurement of time, meaningful in a release build on a quiet machine"]
fn a_pose_takes_no_longer_than_in_the_peer() {
    let arm = Arm::<f64>::er3b();
    let peer = OPWKinematics::new(peer_parameters());
    let mut random = Random(3);
    let poses: Vec<Pose<f64>> = (0..20_000)
        .map(|_| arm.forward(&random_joints(&mut random, &arm)))
        .collect();
    let peer_poses: Vec<PeerPose> = poses.iter().map(peer_pose).collect();
    let (mut own_time, mut peer_time) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..10 {
        let start = std::time::Instant::now();
        let count: usize = poses
            .iter()
            .map(|pose| {
                arm.inverse(pose, None)
                    .map_or(0, |found| found.as_slice().len())
            })
            .sum();
        own_time = own_time.min(start.elapsed().as_secs_f64());
        let start = std::time::Instant::now();
        let theirs: usize = peer_poses.iter().map(|pose| peer.inverse(pose).len()).sum();
        peer_time = peer_time.min(start.elapsed().as_secs_f64());
        assert_eq!(count, theirs);
    }
    let per_pose = 1e9 / poses.len() as f64;
    println!(
        "all branches of a pose: {:.0} ns, the peer {:.0} ns",
        own_time * per_pose,
        peer_time * per_pose
    );
    // Read by `cargo xtask bench`.
    println!("arm_against_peer_ratio {:.4}", own_time / peer_time);
    assert!(own_time <= peer_time);
}

/// The ER3B, then arms of random lengths that reach up to 1000 mm, all as f32 holds them.
fn precise_and_single(random: &mut Random, index: usize) -> (Arm<f64>, Arm<f32>) {
    if index == 0 {
        return (Arm::er3b(), Arm::er3b());
    }
    let mut length = |lo, hi| random.between(lo, hi) as f32;
    let small = Lengths {
        a1: length(0.0, 150.0),
        a2: length(150.0, 350.0),
        a3: length(-50.0, 100.0),
        d1: length(0.0, 350.0),
        d4: length(150.0, 350.0),
        d6: length(20.0, 100.0),
    };
    let wide = Lengths {
        a1: small.a1.into(),
        a2: small.a2.into(),
        a3: small.a3.into(),
        d1: small.d1.into(),
        d4: small.d4.into(),
        d6: small.d6.into(),
    };
    (
        Arm::new(wide, [[-PI, PI]; 6]).expect("an arm"),
        Arm::new(small, [[-std::f32::consts::PI, std::f32::consts::PI]; 6]).expect("an arm"),
    )
}

/// The table in the head of `machines/arm`: 101 000 random poses.
#[test]
fn single_precision_keeps_the_errors_of_the_table() {
    let mut random = Random(4);
    let [mut forward, mut inverse] = [0f64; 2];
    // Of forward(inverse): clear of a stretched or folded elbow, and anywhere.
    let [mut tip, mut turn, mut far_tip, mut far_turn] = [0f64; 4];
    for index in 0..101 {
        let (arm, small) = precise_and_single(&mut random, index);
        let Lengths { a3, d4, d6, .. } = *arm.lengths();
        for _ in 0..1000 {
            // The same f32 numbers go into both.
            let q32 = Joints(random_joints(&mut random, &arm).0.map(|x| x as f32));
            let q = Joints(q32.0.map(f64::from));
            let pose = arm.forward(&q);
            forward = forward.max((widened_pose(small.forward(&q32)).p - pose.p).norm());
            let given = rounded_pose(pose);
            let found = small.inverse(&given, Some(&q32));
            let found = found.expect("it came from joints");
            let exact = arm.inverse(&pose, Some(&q)).expect("it came from joints");
            for s in found.as_slice() {
                let reached = arm.forward(&Joints(s.q.0.map(f64::from)));
                let off = (reached.p - pose.p).norm();
                let turned = [
                    reached.rotation.a.angle_to(pose.rotation.a),
                    reached.rotation.n.angle_to(pose.rotation.n),
                ];
                let turned = turned[0].max(turned[1]).to_degrees();
                // Clear: 3 deg from a stretched or folded elbow.
                let beta = f64::from(s.q[2]) + d4.atan2(a3);
                if beta.sin().abs() > 3f64.to_radians().sin() {
                    (tip, turn) = (tip.max(off), turn.max(turned));
                } else {
                    (far_tip, far_turn) = (far_tip.max(off), far_turn.max(turned));
                }
                // Away: 20 deg from a singular wrist or elbow, 100 mm from axis 1.
                let least = 20f64.to_radians().sin();
                let wrist = pose.p - pose.rotation.a * d6;
                let away = f64::from(s.q[4]).sin().abs() > least && beta.sin().abs() > least;
                if away && wrist.x.hypot(wrist.y) > 100.0 {
                    let exact = exact.branch(s.branch).expect("the same branch");
                    for (a, b) in s.q.0.iter().zip(exact.q.0) {
                        inverse = inverse.max(apart(f64::from(*a), b));
                    }
                }
            }
        }
    }
    println!(
        "f32: forward {forward:.1e} mm, joints {inverse:.1e} rad away from singular poses, \
         forward(inverse) {tip:.1e} mm and {turn:.1e} deg, near a singular elbow {far_tip:.1e} mm and {far_turn:.1e} deg"
    );
    assert!(forward < 1e-3);
    assert!(inverse < 1e-5);
    assert!(tip < 1e-3);
    assert!(turn < 1e-4);
    // With the elbow stretched to rounding the pose itself is out of reach by that much.
    assert!(far_tip < 5e-3);
    assert!(far_turn < 1e-4);
}

#[test]
fn at_a_singular_wrist_the_fourth_joint_stays_and_the_sixth_takes_the_rest() {
    let arm = Arm::<f64>::er3b();
    for theta5 in [0.0, PI] {
        let q = Joints([0.3, -1.2, 0.4, 0.9, theta5, -0.5]);
        let pose = arm.forward(&q);
        let previous = Joints([0.3, -1.2, 0.4, 2.2, theta5, 0.1]);

        for (near, theta4) in [(Some(&previous), 2.2), (None, 0.0)] {
            let found = arm.inverse(&pose, near).expect("within reach");

            for solution in found.as_slice().iter().take(2) {
                assert!(solution.wrist_singular);
                assert!((solution.q[3] - theta4).abs() < 1e-12);
                assert!(difference(&arm.forward(&solution.q), &pose) < 1e-9);
            }
        }
    }
}

#[test]
fn close_to_a_singular_wrist_single_precision_still_reaches_the_pose() {
    let arm = Arm::<f32>::er3b();
    let exact = Arm::<f64>::er3b();
    let mut random = Random(5);
    for _ in 0..20_000 {
        let tilt = 10f64.powf(random.between(-9.0, -1.0));
        let q = [
            0.3,
            -1.2,
            0.4,
            random.between(-3.0, 3.0),
            tilt,
            random.between(-3.0, 3.0),
        ];
        let pose = exact.forward(&Joints(q));

        let found = arm
            .inverse(&rounded_pose(pose), None)
            .expect("within reach");

        for solution in found.as_slice() {
            let reached = exact.forward(&Joints(solution.q.0.map(f64::from)));
            let turned = reached.rotation.n.angle_to(pose.rotation.n);
            assert!(turned < 5e-6, "tilt {tilt}: turned by {turned}");
        }
    }
}

#[test]
fn on_axis_one_the_first_joint_stays() {
    let arm = Arm::<f64>::er3b();
    let down = Rotation {
        n: Vector::X,
        s: -Vector::Y,
        a: -Vector::Z,
    };
    let pose = Pose {
        rotation: down,
        p: Vector::new(0.0, 0.0, 700.0 - 78.5),
    };
    let previous = Joints([0.7, 0.0, 0.0, 0.0, 0.0, 0.0]);

    let found = arm.inverse(&pose, Some(&previous)).expect("within reach");

    for solution in found.as_slice() {
        assert!(solution.shoulder_singular);
        assert!((solution.q[0] - 0.7).abs() < 1e-12);
        assert!(difference(&arm.forward(&solution.q), &pose) < 1e-9);
    }
}

#[test]
fn a_folded_elbow_is_reached_and_flagged() {
    let arm = Arm::<f64>::er3b();
    // theta3 = 180 - 76.8236 deg folds the forearm back on the upper arm.
    let folded = PI - f64::atan2(299.0, 70.0);
    let pose = arm.forward(&Joints([0.2, -1.0, folded, 0.3, 0.8, -0.4]));

    let found = arm
        .inverse(&pose, None)
        .expect("the border of the reach belongs to it");

    let own = found.branch(0).expect("front");
    assert!(own.elbow_singular);
    assert!(difference(&arm.forward(&own.q), &pose) < 1e-6);
}

#[test]
fn what_no_shoulder_reaches_is_unreachable_and_what_is_no_pose_is_refused() {
    let arm = Arm::<f64>::er3b();
    let at = |x: f64| Pose {
        rotation: Rotation::IDENTITY,
        p: Vector::new(x, 0.0, 300.0),
    };

    assert_eq!(
        arm.inverse(&at(900.0), None).unwrap_err(),
        ArmError::Unreachable
    );
    assert_eq!(
        arm.inverse(&at(f64::NAN), None).unwrap_err(),
        ArmError::BadPose
    );
    let mut skew = at(400.0);
    skew.rotation.n.x += 3e-6;
    assert_eq!(arm.inverse(&skew, None).unwrap_err(), ArmError::BadPose);
    let mut mirrored = at(400.0);
    mirrored.rotation.n = -mirrored.rotation.n;
    assert_eq!(arm.inverse(&mirrored, None).unwrap_err(), ArmError::BadPose);
}

#[test]
fn only_the_front_shoulder_reaches_far_out() {
    let arm = Arm::<f64>::er3b();
    let pose = arm.forward(&radians([10.0, -45.0, -60.0, -30.0, 60.0, 15.0]));

    let found = arm.inverse(&pose, None).expect("within reach");

    let branches: Vec<u8> = found.as_slice().iter().map(|s| s.branch).collect();
    assert_eq!(branches, [0, 1, 2, 3]);
}

#[test]
fn an_arm_that_is_not_of_this_kind_has_no_closed_form() {
    let er3b = Arm::<f64>::er3b();
    let rows = table(er3b.lengths());
    let limits = *er3b.limits();
    assert_eq!(Arm::from_table(&rows, limits), Ok(er3b));

    let changed = |row: usize, change: fn(&mut DhRow<f64>)| {
        let mut rows = rows;
        change(&mut rows[row]);
        Arm::from_table(&rows, limits).unwrap_err()
    };

    assert_eq!(changed(1, |r| r.d = 5.0), ArmError::BadParameter { row: 1 });
    assert_eq!(
        changed(4, |r| r.alpha = 1.0),
        ArmError::BadParameter { row: 4 }
    );
    assert_eq!(
        changed(5, |r| r.d = f64::NAN),
        ArmError::BadParameter { row: 5 }
    );
    let short = Lengths {
        a2: 0.0,
        ..*er3b.lengths()
    };
    assert_eq!(
        Arm::new(short, limits),
        Err(ArmError::BadParameter { row: 2 })
    );
    let mut crossed = limits;
    crossed[3] = [1.0, -1.0];
    assert_eq!(
        Arm::new(*er3b.lengths(), crossed),
        Err(ArmError::BadLimit { joint: 3 })
    );
}

#[test]
fn a_stretch_keeps_one_branch_with_the_largest_margin() {
    let arm = Arm::<f64>::er3b();
    let start = radians([
        -10.002754, -89.170319, 30.774471, -5.330318, 57.711970, -7.180855,
    ]);
    let end = radians([
        -6.336841, -46.160490, -26.583500, -4.772430, 72.295817, -4.902559,
    ]);
    let mut stretch = Stretch::new(None);
    for i in 0..=24 {
        let q = start.zip_map(&end, |a, b| a + (b - a) * f64::from(i) / 24.0);
        stretch.add(&arm, &arm.forward(&q)).expect("poses");
    }

    let (branch, margin) = stretch.best().expect("branch 0 serves the whole row");

    assert_eq!(branch, 0);
    // Section 11: at least 37 deg to any range.
    assert!(margin.to_degrees() >= 37.0, "{}", margin.to_degrees());
    let last = stretch.joints(0).expect("it serves");
    assert!(
        last.zip_map(&end, |a, b| a - b)
            .0
            .iter()
            .all(|d| d.abs() < 1e-9)
    );
}

#[test]
fn a_stretch_that_no_branch_serves_tells_why_for_each() {
    let arm = Arm::<f64>::er3b();
    let far = arm.forward(&radians([10.0, -45.0, -60.0, -30.0, 60.0, 15.0]));
    let turned = arm.forward(&radians([50.0, -45.0, -60.0, -30.0, 60.0, 15.0]));
    let mut stretch = Stretch::new(None);

    stretch.add(&arm, &far).expect("a pose");
    stretch.add(&arm, &turned).expect("a pose");

    let none = stretch.best().expect_err("axis 1 jumps by 40 deg");
    assert_eq!(none.reasons[0], Some((1, Refusal::Jump { joint: 0 })));
    assert_eq!(none.reasons[2], Some((0, Refusal::OutOfTravel)));
    assert_eq!(none.reasons[7], Some((0, Refusal::NotReached)));
}

#[test]
fn as_a_kinematics_the_arm_stays_on_its_branch() {
    let arm = Arm::<f64>::er3b();
    let mut random = Random(6);
    for _ in 0..2_000 {
        let q = random_joints(&mut random, &arm);
        let near = Joints(q.0.map(|x| x + 0.01));

        let found = Kinematics::inverse(&arm, &arm.forward(&q), &near);

        let folded = (q[2] + f64::atan2(299.0, 70.0)).sin().abs() < 0.05;
        if q[4].abs() > 0.02 && !folded {
            let found = found.expect("it came from joints");
            let moved = found.zip_map(&q, |a, b| (a - b).abs());
            let wrist = arm.forward(&q).p - arm.forward(&q).rotation.a * 78.5;
            if wrist.x.hypot(wrist.y) > 10.0 {
                assert!(
                    moved.0.iter().all(|d| *d < 1e-6),
                    "seed 6: {found:?} from {q:?}"
                );
            }
        }
    }
}
