//! Five-axis machines and the following of CL points, against the specification's numbers and against a forward map
//! of 4x4 matrices and quaternions that shares no code with the library.

use hexstep::geometry::{Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::follow::{
    Block, ClPoint, Feed, Follower, Guide, Refusal, Refused, Tolerance,
};
use hexstep::machines::five_axis::{
    self, Axis, Class, Definition, Error, FiveAxis, Kind, Layer, PRESETS, PathChoice, Solution,
    Turned, preset,
};
use hexstep::math::Real;
use serde_json::{Value, json};

// ---- numbers of the specification ----

#[test]
fn twelve_machines_give_the_printed_joints_of_both_solutions() {
    let cases: Value = read_cases("five_axis_machines.json");
    let v = unit([0.3, 0.2, 0.9]);

    for case in cases["machines"].as_array().expect("rows") {
        let name = case["machine"].as_str().expect("name");
        let machine = FiveAxis::new(&with_pivots(name)).expect("machine");
        let branches = machine.branches(v, &angles([0.0, 0.0]));
        near(branches.s, case["s"].as_f64().unwrap(), 6, name);
        assert_eq!(branches.kind, Kind::Two, "{name}");
        for (i, row) in case["solutions"].as_array().unwrap().iter().enumerate() {
            let row: Vec<f64> = row
                .as_array()
                .unwrap()
                .iter()
                .map(|x| x.as_f64().unwrap())
                .collect();
            let near_it = angles([row[3], row[4]]);

            let found = machine
                .inverse(vector([40.0, -30.0, 25.0]), v, &near_it)
                .expect(name);

            assert_eq!(usize::from(found.number), i + 1, "{name}");
            all_near(&degrees(&found.joints()), &row, 6, name);
            all_near(&branches.angles[i].map(f64::to_degrees), &row[3..], 6, name);
        }
    }
}

#[test]
fn the_slanted_machine_gives_the_printed_directions() {
    let machine = FiveAxis::new(&preset::<f64>("s45").unwrap()).unwrap();
    let at = |v: [f64; 3]| machine.branches(unit(v), &angles([12.0, 0.0]));
    let deg = |a: [f64; 2]| a.map(f64::to_degrees);

    all_near(
        &machine.band().map(f64::to_degrees),
        &[0.0, 90.0],
        9,
        "band",
    );

    let pole = at([0.0, 0.0, 1.0]);
    assert_eq!(pole.kind, Kind::Infinite);
    all_near(&deg(pole.angles[0]), &[12.0, 0.0], 9, "pole");

    let two = at([1.0, 0.0, 1.0]);
    assert_eq!(two.kind, Kind::Two);
    all_near(
        &deg(two.angles[0]),
        &[155.530199479, -65.530199479],
        9,
        "101",
    );
    all_near(&deg(two.angles[1]), &[24.469800521, 65.530199479], 9, "101");
    near(two.s, 0.455089861, 9, "101");

    let two = at([0.1, 0.2, 0.95]);
    all_near(
        &deg(two.angles[0]),
        &[109.897894343, -18.773364035],
        9,
        "tilted",
    );
    all_near(
        &deg(two.angles[1]),
        &[-56.767791989, 18.773364035],
        9,
        "tilted",
    );
    near(two.s, 0.160912789, 9, "tilted");

    let close = at([1e-4, 0.0, 1.0]);
    assert_eq!(close.kind, Kind::Two);
    all_near(
        &deg(close.angles[0]),
        &[179.997135211, -0.008102847],
        9,
        "close",
    );
    all_near(
        &deg(close.angles[1]),
        &[0.002864789, 0.008102847],
        9,
        "close",
    );
    near(close.s, 7.0711e-5, 9, "close");

    let border = at([1.0, 0.0, 0.0]);
    assert_eq!((border.kind, border.s), (Kind::One, 0.0));
    all_near(&deg(border.angles[0]), &[90.0, 180.0], 9, "border");

    let none = at([0.9, 0.3, -0.1]);
    assert_eq!(none.kind, Kind::None);
    near(none.gap.to_degrees(), 6.017284864, 9, "gap");
    all_near(&deg(none.angles[0]), &[71.565051177, 180.0], 9, "nearest");
}

#[test]
fn the_slanted_machine_with_its_tool_along_y_reaches_the_same_band() {
    let definition = Definition {
        v1: Vector::Y,
        ..preset::<f64>("s45").unwrap()
    };

    let machine = FiveAxis::new(&definition).unwrap();

    all_near(
        &machine.band().map(f64::to_degrees),
        &[0.0, 90.0],
        9,
        "band",
    );
}

#[test]
fn the_previous_joints_decide_between_the_solutions() {
    let machine = FiveAxis::new(&preset::<f64>("s45").unwrap()).unwrap();
    let (p, v) = (vector([100.0, 50.0, 200.0]), unit([0.1, 0.2, 0.95]));

    for previous in [[0.0, 0.0], [0.0, 20.0]] {
        let found = machine.inverse(p, v, &angles(previous)).unwrap();
        let row = [
            176.273936809,
            -46.933782547,
            190.689820520,
            -56.767791989,
            18.773364035,
        ];
        all_near(&degrees(&found.joints()), &row, 9, "second");
    }
    let found = machine.inverse(p, v, &angles([170.0, 0.0])).unwrap();
    let row = [
        -160.697297931,
        86.322993345,
        190.689820520,
        109.897894343,
        -18.773364035,
    ];
    all_near(&degrees(&found.joints()), &row, 9, "first");
}

#[test]
fn a_solution_outside_the_travel_is_never_chosen() {
    let mut definition = preset::<f64>("table_ac").unwrap();
    definition.limits = limits([[-30.0, 120.0], [-360.0, 360.0]]);
    let machine = FiveAxis::new(&definition).unwrap();

    for previous in [[10.0, 0.0], [10.0, 300.0]] {
        let found = machine
            .inverse(
                vector([10.0, 20.0, 30.0]),
                unit([0.3, 0.4, 0.8]),
                &angles(previous),
            )
            .unwrap();

        let row = [-4.0, 2.755994488, 37.099925800, 32.005383208, 36.869897646];
        all_near(&degrees(&found.joints()), &row, 9, "limits");
    }
}

#[test]
fn bounds_and_true_errors_are_the_printed_ones() {
    let head = Definition {
        q1: vector([0.0, 0.0, 300.0]),
        q2: vector([0.0, 0.0, 250.0]),
        ..preset("head_ca").unwrap()
    };
    let table = Definition {
        q1: vector([0.0, 0.0, -100.0]),
        q2: vector([0.0, 0.0, -100.0]),
        ..preset("table_ac").unwrap()
    };
    let rows: [(Definition<f64>, [[f64; 3]; 4], [f64; 4]); 3] = [
        (
            head,
            [
                [0.0; 3],
                [0.1, 0.1, 0.98],
                [5.0, 0.0, 0.0],
                [0.12, 0.05, 0.98],
            ],
            [0.99150426, 0.70800570, 0.22457888, 0.16090102],
        ),
        (
            table,
            [
                [50.0, 0.0, 0.0],
                [0.1, 0.2, 0.97],
                [50.0, 10.0, 0.0],
                [0.05, 0.2, 0.97],
            ],
            [0.94627398, 0.24864521, 0.13093363, 0.08923281],
        ),
        (
            preset("s45").unwrap(),
            [
                [100.0, 0.0, 200.0],
                [0.2, 0.1, 0.97],
                [100.0, 10.0, 200.0],
                [0.2, 0.15, 0.96],
            ],
            [0.80737750, 0.05399813, 0.12449769, 0.08881786],
        ),
    ];
    for (definition, [p0, v0, p1, v1], printed) in rows {
        let machine = FiveAxis::new(&definition).unwrap();
        let (from, to) = (cl(p0, v0), cl(p1, v1));
        let a = machine
            .inverse(from.p(), from.v(), &angles([0.0, 0.0]))
            .unwrap();
        let b = machine.inverse(to.p(), to.v(), &a.rotary).unwrap();

        let bounds = machine.bounds(
            &a,
            &b,
            (to.p() - from.p()).norm(),
            (to.v() - from.v()).norm(),
        );
        let (tip, axis) = true_errors(&definition, (&from, &a), (&to, &b), 400);

        let found = [bounds.tip, tip, bounds.axis.unwrap().to_degrees(), axis];
        all_near(&found, &printed, 8, "bounds");
    }
}

#[test]
fn the_frustum_takes_the_printed_joints_points_and_time() {
    let path = frustum();
    all_near(
        &path[0].p().to_array(),
        &[259.805807, -250.0, 1.961161],
        6,
        "tip 0",
    );
    all_near(
        &path[2].p().to_array(),
        &[256.933752, 256.933752, 1.961161],
        6,
        "tip 2",
    );
    all_near(
        &path[2].v().to_array(),
        &[-0.138675, -0.138675, 0.980581],
        6,
        "axis 2",
    );
    let s45 = preset::<f64>("s45").unwrap();
    let corner = [0.0, 0.0, 350.0];
    let head = Definition {
        q1: vector(corner),
        q2: vector(corner),
        ..preset("head_ca").unwrap()
    };
    let table = preset("table_ab").unwrap();
    let mixed = Definition {
        q2: vector(corner),
        ..preset("mixed_ba").unwrap()
    };

    for (machine, tol, count) in [
        (&s45, 0.1, 245),
        (&s45, 0.01, 517),
        (&s45, 0.001, 2053),
        (&head, 0.01, 261),
        (&table, 0.01, 133),
        (&mixed, 0.01, 133),
    ] {
        let blocks = follow(machine, &path, tol, 0.05, [0.0, 0.0]).expect("frustum");

        assert_eq!(blocks.len() + 1, count, "{:?} at {tol}", machine.class);
        let time: f64 = blocks.iter().map(|b| b.duration).sum();
        near(time, 123.602419, 6, "time");
    }

    let blocks = follow(&s45, &path, 0.01, 0.05, [0.0, 0.0]).unwrap();
    let per_segment = |i| blocks.iter().filter(|b| b.segment == i).count();
    assert_eq!(
        (per_segment(0), per_segment(1), per_segment(2)),
        (1, 64, 64)
    );
    let first = blocks.iter().find(|b| b.segment == 1).unwrap();
    assert_eq!(first.u, 1.0 / 64.0);
    let row = [217.612133, 226.852274, -4.775910, -6.295594, -15.949879];
    all_near(&degrees(&first.joints), &row, 6, "u = 1/64");
    near(first.duration, 7.036e-3, 6, "corner block");
    near(60.0 / first.duration, 8527.603, 3, "inverse time");
    for (i, row) in [
        (
            0,
            [214.980555, 229.842292, -4.835602, -5.682713, -16.020845],
        ),
        (
            1,
            [293.270153, -29.182887, -4.835602, -50.682713, -16.020845],
        ),
        (
            2,
            [165.470798, -267.700454, -4.835602, -95.682713, -16.020845],
        ),
        (
            11,
            [165.470798, -267.700454, -4.835602, -365.682713, -16.020845],
        ),
    ] {
        let end = blocks.iter().rfind(|b| b.segment == i).unwrap();
        all_near(&degrees(&end.joints), &row, 6, "CL point");
    }
    let largest = corner_errors(&s45, &path);
    all_near(&largest, &[26.2246, 29.4909], 4, "half a corner, tip");
}

#[test]
fn the_windowed_choice_finds_the_cheaper_path_that_the_greedy_one_misses() {
    let (definition, path) = trap();
    let machine = FiveAxis::new(&definition).unwrap();
    let start = angles([0.0, 5.0]);

    let mut greedy: Vec<Solution<f64>> = Vec::new();
    for at in &path {
        let before = greedy.last().map_or(start, |s| s.rotary);
        greedy.push(machine.inverse(at.p(), at.v(), &before).unwrap());
    }
    let best = choose_path::<f64, 8>(&machine, &path, 3, start);

    let rotary = |s: &Solution<f64>| degrees(&s.joints())[3..].to_vec();
    let cost = |path: &[Solution<f64>]| path.iter().map(|s| s.cost.to_degrees()).sum::<f64>();
    all_near(&rotary(&greedy[0]), &[14.036243, 11.998611], 6, "greedy");
    all_near(&rotary(&greedy[1]), &[14.036243, 24.613598], 6, "greedy");
    all_near(&rotary(&greedy[2]), &[189.462322, -39.043262], 6, "greedy");
    near(cost(&greedy), 272.732780, 6, "greedy");
    all_near(&rotary(&best[0]), &[-165.963757, -11.998611], 6, "best");
    all_near(&rotary(&best[1]), &[-165.963757, -24.613598], 6, "best");
    all_near(&rotary(&best[2]), &[-170.537678, -39.043262], 6, "best");
    near(cost(&best), 214.580940, 6, "best");
}

// ---- always ----

#[test]
fn both_solutions_lead_back_to_the_pose_on_every_machine() {
    let mut random = Random::new(1);
    for i in 0..400 {
        let definition = random_machine(&mut random, i);
        let machine = FiveAxis::new(&definition).expect("machine");
        for _ in 0..40 {
            let (p, v) = random_pose(&mut random);
            let branches = machine.branches(v, &angles([0.0, 0.0]));
            let [lo, hi] = machine.band();
            if branches.kind == Kind::None {
                assert!(branches.gap > five_axis::SNAP && branches.gap <= lo.max(3.15 - hi));
                continue;
            }
            for (number, [primary, secondary]) in (1..).zip(branches.solutions()) {
                let near_it = [primary, secondary].map(|a| Turned::from_total(*a));

                let found = machine.inverse(p, v, &near_it).expect("reachable");

                assert_eq!(found.number, number);
                let (p_back, v_back) = reference_forward(&definition, &found.joints().0);
                assert!(distance(p_back, p.to_array()) < 1e-9, "machine {i}");
                let off = angle_deg(v_back, v.to_array()) - branches.gap.to_degrees();
                assert!(off < 1e-9, "machine {i}: {off}");
                let (p_own, v_own) = machine.forward(&found.joints()).unwrap();
                assert!(
                    distance(p_own.to_array(), p.to_array()) < 1e-9,
                    "machine {i}"
                );
                assert!(angle_deg(v_own.to_array(), v_back) < 1e-9, "machine {i}");
                let pose = machine.pose(&found.joints()).unwrap();
                assert!(distance(pose.rotation.a.to_array(), v_back) < 1e-12);
                let n = pose.rotation.n;
                assert!(
                    distance(
                        pose.rotation.a.cross(n).to_array(),
                        pose.rotation.s.to_array()
                    ) < 1e-12
                );
            }
        }
    }
}

#[test]
fn no_direction_outside_the_band_is_reached_by_any_angles() {
    let mut random = Random::new(2);
    for i in 0..60 {
        let definition = random_machine(&mut random, i);
        let machine = FiveAxis::new(&definition).unwrap();
        for _ in 0..200 {
            let q = [
                0.0,
                0.0,
                0.0,
                random.within(-4.0, 4.0),
                random.within(-4.0, 4.0),
            ];

            let (_, v) = reference_forward(&definition, &q);
            let branches = machine.branches(unit(v), &angles([0.0, 0.0]));

            assert_ne!(branches.kind, Kind::None, "machine {i}, joints {q:?}");
        }
    }
}

/// The table of section 8: the same machines and poses in f32, judged by the f64 reference map. Coordinates to
/// 1000 mm means the linear joints as well; beyond, with joints to 5 m, an f32 no longer holds them as well.
#[test]
fn single_precision_keeps_the_errors_of_the_table() {
    let mut random = Random::new(3);
    let [mut tip, mut far_tip, mut direction, mut joint] = [0f64; 4];
    let (mut compared, mut near_count) = (0, 0);
    for i in 0..113 {
        // Both precisions get the machine that f32 can hold.
        let wide = round_machine(&match PRESETS.get(i) {
            Some(name) => with_pivots(name),
            None => random_machine(&mut random, i),
        });
        let single = FiveAxis::new(&narrow(&wide)).unwrap();
        let double = FiveAxis::new(&wide).unwrap();
        for _ in 0..900 {
            let (p, v) = random_pose(&mut random);
            let p32 = vector(p.to_array().map(|x| x as f32));
            let v32 = five_axis::direction(vector(v.to_array().map(|x| x as f32)), "v").unwrap();
            let (p, v) = (widen(p32), unit(widen(v32).to_array()));
            let previous = [random.within(-170.0, 170.0), random.within(-170.0, 170.0)];
            let previous32 = previous.map(|a| Turned::from_total(a.to_radians() as f32));

            let expected = double.inverse(p, v, &angles(previous));
            let found = single.inverse(p32, v32, &previous32);

            let (expected, found) = match (expected, found) {
                (Ok(expected), Ok(found)) => (expected, found),
                (
                    Err(Error::Unreachable { gap, .. }),
                    Err(Error::Unreachable { gap: gap32, .. }),
                ) => {
                    assert!((gap - f64::from(gap32)).abs() < 2e-6, "{gap} {gap32}");
                    continue;
                }
                (Err(Error::Unreachable { gap, .. }), Ok(_)) => {
                    assert!(gap < 10.0 * five_axis::SNAP, "gap {gap}");
                    continue;
                }
                (expected, found) => panic!("machine {i}: {expected:?} {found:?}"),
            };
            // The joints as sent: radians in f32, turns apart.
            let [x, y, z] = found.linear.map(f64::from);
            let [th1, th2] = found.rotary.map(|t| f64::from(t.angle));
            let (p_back, v_back) = reference_forward(&wide, &[x, y, z, th1, th2]);
            let is_near = [x, y, z].iter().all(|x| x.abs() <= 1000.0);
            let off = distance(p_back, p.to_array());
            let place = if is_near { &mut tip } else { &mut far_tip };
            *place = place.max(off);
            near_count += usize::from(is_near);
            direction = direction.max(angle_deg(v_back, v.to_array()));
            if expected.s < 1e-3 {
                continue;
            }
            assert_eq!(found.kind, expected.kind);
            let margin = (expected.cost - f64::from(found.cost)).abs();
            assert!(
                margin < 2e-5 / expected.s,
                "machine {i}: costs differ by {margin}"
            );
            if found.number == expected.number {
                compared += 1;
                for (narrow, wide) in found.rotary.iter().zip(&expected.rotary) {
                    let off = f64::from(narrow.angle) - wide.angle;
                    let off = off - std::f64::consts::TAU * (off / std::f64::consts::TAU).round();
                    joint = joint.max(off.abs().to_degrees() * expected.s);
                }
            }
        }
    }
    println!(
        "f32: tip {tip:.2e} mm ({near_count} poses), {far_tip:.2e} mm beyond 1000 mm, direction {direction:.2e} deg, joint {joint:.2e} deg / S, {compared} poses"
    );
    assert!(compared > 50_000);
    assert!(near_count > 20_000);
    assert!(tip <= 1e-3 && far_tip <= 2e-3 && direction <= 1e-4 && joint <= 1e-4);
}

/// Every tilt from 1e-7 rad to 0.1 rad about the pole, where the textbook form fails.
#[test]
fn near_the_pole_single_precision_keeps_the_direction() {
    let mut random = Random::new(4);
    let mut worst = 0f64;
    for name in PRESETS {
        let wide = round_machine(&with_pivots(name));
        let single = FiveAxis::new(&narrow(&wide)).unwrap();
        for _ in 0..4000 {
            let tilt = 10f64.powf(random.within(-7.0, -1.0));
            let az = random.within(-3.2, 3.2);
            let v = unit([tilt.sin() * az.cos(), tilt.sin() * az.sin(), tilt.cos()]);
            let v32 = vector(v.to_array().map(|x| x as f32));
            let v32 = five_axis::direction(v32, "v").unwrap();
            let branches = single.branches(v32, &[Turned::default(); 2]);
            for [th1, th2] in branches.solutions() {
                let q = [0.0, 0.0, 0.0, f64::from(*th1), f64::from(*th2)];
                let (_, back) = reference_forward(&wide, &q);
                let off = angle_deg(back, widen(v32).to_array());
                let held = branches.kind == Kind::Infinite;
                assert!(!held || off <= five_axis::SING.to_degrees() * 1.1);
                worst = if held { worst } else { worst.max(off) };
            }
        }
    }
    println!("f32 near the pole: {worst:.2e} deg");
    assert!(worst <= 4e-5);
}

/// Sine and cosine in f32 come from polynomials of their own; the standard library's f64 judges them.
#[test]
fn single_sines_and_cosines_are_within_1e_7() {
    let mut random = Random::new(8);
    let mut worst = 0f64;
    let angles = (0..400_000).map(|i| {
        let reach = if i % 2 == 0 { 3.2 } else { 9000.0 };
        random.within(-reach, reach) as f32
    });
    for x in angles.chain([0.0, -0.0, 8192.0, -8192.0, std::f32::consts::PI, 1e30]) {
        let (sin, cos) = Real::sin_cos(x);
        let (sin64, cos64) = f64::from(x).sin_cos();
        worst = worst.max((f64::from(sin) - sin64).abs());
        worst = worst.max((f64::from(cos) - cos64).abs());
    }
    println!("f32 sine and cosine: {worst:.2e}");
    assert!(worst <= 1e-7);
    for x in [f32::NAN, f32::INFINITY] {
        let (sin, cos) = Real::sin_cos(x);
        assert!(sin.is_nan() && cos.is_nan());
    }
}

#[test]
fn bounds_hold_against_dense_sampling_on_every_machine() {
    let mut random = Random::new(5);
    let (mut count, mut worst) = (0, [0f64; 2]);
    for i in 0..200 {
        let definition = random_machine(&mut random, i);
        let machine = FiveAxis::new(&definition).unwrap();
        for _ in 0..6 {
            let (p, v) = random_pose(&mut random);
            let reach = 10f64.powf(random.within(-1.0, 1.7));
            let tilt = 10f64.powf(random.within(-2.5, -0.4));
            let to_p = p + random.vector() * reach;
            let to_v = unit((v + random.vector() * tilt).to_array());
            let (from, to) = (
                ClPoint::new(p, v).unwrap(),
                ClPoint::new(to_p, to_v).unwrap(),
            );
            let Ok(a) = machine.inverse(from.p(), from.v(), &angles([0.0, 0.0])) else {
                continue;
            };
            let Ok(b) = machine.inverse(to.p(), to.v(), &a.rotary) else {
                continue;
            };
            let chord = (to.v() - from.v()).norm();

            let bounds = machine.bounds(&a, &b, (to.p() - from.p()).norm(), chord);
            let (tip, axis) = true_errors(&definition, (&from, &a), (&to, &b), 60);

            let axis_bound = bounds.axis.expect("below 60 deg").to_degrees();
            assert!(
                tip <= bounds.tip * 1.000001 + 1e-9,
                "machine {i}: {tip} {}",
                bounds.tip
            );
            assert!(
                axis <= axis_bound * 1.000001 + 1e-9,
                "machine {i}: {axis} {axis_bound}"
            );
            worst = [
                worst[0].max(tip / bounds.tip),
                worst[1].max(axis / axis_bound),
            ];
            count += 1;
        }
    }
    println!("{count} moves, true / bound at most {worst:.3?}");
    assert!(count > 500);
}

#[test]
fn followed_paths_keep_tip_and_axis_within_tolerance_on_every_machine() {
    let mut random = Random::new(6);
    let mut count = 0;
    for i in 0..150 {
        let definition = random_machine(&mut random, i);
        let (p, v) = random_pose(&mut random);
        let to_p = p + random.vector() * 20.0;
        let to_v = unit((v + random.vector() * 0.2).to_array());
        let path = [
            ClPoint::new(p, v).unwrap(),
            ClPoint::new(to_p, to_v).unwrap(),
        ];
        let Ok(blocks) = follow(&definition, &path, 0.02, 0.05, [0.0, 0.0]) else {
            continue;
        };
        let machine = FiveAxis::new(&definition).unwrap();
        let first = machine.inverse(p, v, &angles([0.0, 0.0])).unwrap();

        let mut before = (0.0, first);
        for block in blocks {
            if !block.flags.coarse {
                let (a, b) = (between(&path, before.0), between(&path, block.u));
                let (tip, axis) = true_errors(&definition, (&a, &before.1), (&b, &block.set), 12);
                assert!(
                    tip <= 0.02 && axis <= 0.05,
                    "machine {i}: {tip} mm, {axis} deg"
                );
                count += 1;
            }
            before = (block.u, block.set);
        }
        assert_eq!(before.0, 1.0);
    }
    assert!(count > 1000);
}

#[test]
fn an_exact_choice_is_never_dearer_than_greedy_and_equals_brute_force() {
    let mut random = Random::new(7);
    let mut gained = 0;
    for i in 0..120 {
        let mut definition = preset::<f64>(PRESETS[i % 13]).unwrap();
        let (a, c) = (random.within(40.0, 200.0), random.within(181.0, 500.0));
        definition.limits = limits(match i % 3 {
            0 => [[-c, c], [-a.max(120.0), a.max(120.0)]],
            1 => [[-a.max(120.0), a.max(120.0)], [-c, c]],
            _ => [[-c, c], [-c, c]],
        });
        definition.weights = [random.within(0.2, 3.0), 1.0];
        let machine = FiveAxis::new(&definition).unwrap();
        let path: Vec<_> = (0..5)
            .map(|_| {
                cl(
                    [0.0; 3],
                    [random.within(-0.6, 0.6), random.within(-0.6, 0.6), 1.0],
                )
            })
            .collect();
        let reachable = path
            .iter()
            .all(|at| machine.inverse(at.p(), at.v(), &angles([0.0; 2])).is_ok());
        if !reachable {
            continue;
        }
        let start = angles([0.0, 0.0]);

        let best = choose_path::<f64, 64>(&machine, &path, path.len(), start);
        let windowed = choose_path::<f64, 64>(&machine, &path, 2, start);

        let cost: f64 = best.iter().map(|s| s.cost).sum();
        let expected = brute_force(&machine, &definition, &path, [0.0, 0.0]);
        assert!((cost - expected).abs() < 1e-9, "{i}: {cost} {expected}");
        let windowed: f64 = windowed.iter().map(|s| s.cost).sum();
        let mut before = start;
        let mut greedy = 0.0;
        for at in &path {
            let found = machine.inverse(at.p(), at.v(), &before).unwrap();
            (before, greedy) = (found.rotary, greedy + found.cost);
        }
        assert!(cost <= greedy + 1e-9 && cost <= windowed + 1e-9);
        gained += usize::from(cost < greedy - 1e-6);
    }
    assert!(gained > 5, "only {gained} paths gained");
}

// ---- following: poles, feeds, refusals ----

#[test]
fn a_path_through_the_pole_holds_the_free_axis_and_is_no_reconfiguration() {
    for name in ["head_ca", "table_ac", "mixed_ca", "head_cb", "s45"] {
        let definition = preset::<f64>(name).unwrap();
        let path = [
            cl([0.0; 3], [0.2, 0.1, 1.0]),
            cl([30.0, 0.0, 0.0], [-0.2, -0.1, 1.0]),
        ];

        let blocks = follow(&definition, &path, 0.01, 0.05, [0.0, 0.0]).unwrap();

        assert!(
            blocks
                .iter()
                .all(|b| !b.flags.reconfigure && !b.flags.coarse),
            "{name}"
        );
        let largest = blocks.windows(2).map(|pair| {
            let change = (0..5).map(|j| (pair[1].joints[j] - pair[0].joints[j]).abs());
            change.skip(3).fold(0.0, f64::max)
        });
        assert!(largest.fold(0.0, f64::max) < 0.4, "{name}");
    }
}

#[test]
fn near_a_pole_the_tool_slows_down_to_the_speed_of_the_named_joint() {
    let mut definition = preset::<f64>("head_ca").unwrap();
    definition.q1 = vector([0.0, 0.0, 300.0]);
    definition.q2 = vector([0.0, 0.0, 250.0]);
    let speeds = [100.0, 100.0, 100.0, 60f64.to_radians(), 60f64.to_radians()];
    definition.speeds = Some(speeds);
    let path = [
        cl([0.0; 3], [0.2, 0.001, 1.0]),
        cl([20.0, 0.0, 0.0], [-0.2, 0.001, 1.0]),
    ];

    let blocks = follow(&definition, &path, 0.01, 0.05, [0.0, 0.0]).unwrap();

    let machine = FiveAxis::new(&definition).unwrap();
    let mut before = machine
        .inverse(path[0].p(), path[0].v(), &angles([0.0, 0.0]))
        .unwrap()
        .joints();
    for block in &blocks {
        for (j, speed) in speeds.iter().enumerate() {
            let asked = (block.joints[j] - before[j]).abs();
            assert!(
                asked <= speed * block.duration * 1.000001,
                "joint {j} at u = {}",
                block.u
            );
        }
        before = block.joints;
    }
    let slowed = blocks.iter().filter(|b| b.limited_by == Some(3)).count();
    assert!(slowed > 5, "{slowed} blocks limited by C");
    let time: f64 = blocks.iter().map(|b| b.duration).sum();
    assert!(time > 20.0 / FEED * 1.1);
}

#[test]
fn inverse_time_gives_each_block_its_share_of_the_stretch() {
    let machine = FiveAxis::new(&preset::<f64>("s45").unwrap()).unwrap();
    let path = frustum();
    let start = machine
        .inverse(path[1].p(), path[1].v(), &angles([0.0, 0.0]))
        .unwrap();
    let mut follower = Follower::new(&machine, tolerance(0.01, 0.05), path[1], start).unwrap();

    follower.push(path[2], None, Feed::Time(3.0)).unwrap();
    let blocks: Vec<_> = std::iter::from_fn(|| follower.next_block()).collect();

    let time: f64 = blocks.iter().map(|b| b.duration).sum();
    assert!((time - 3.0).abs() < 1e-12);
    assert_eq!(blocks.len(), 64);
}

#[test]
fn a_tip_that_stands_still_needs_joint_speeds() {
    let mut definition = preset::<f64>("head_ca").unwrap();
    let path = [cl([0.0; 3], [0.2, 0.1, 1.0]), cl([0.0; 3], [0.2, 0.3, 1.0])];

    let refused = follow(&definition, &path, 0.01, 0.05, [0.0, 0.0]).unwrap_err();
    definition.speeds = Some([100.0, 100.0, 100.0, 1.0, 1.0]);
    let blocks = follow(&definition, &path, 0.01, 0.05, [0.0, 0.0]).unwrap();

    assert_eq!(refused.why, Refusal::BadFeed);
    assert!(
        blocks
            .iter()
            .all(|b| b.duration > 0.0 && b.limited_by.is_some())
    );
}

#[test]
fn a_failing_stretch_emits_nothing_and_says_where_it_fails() {
    // The great circle dips below the table's plane in the middle: tilt 100 deg, out of the band of 90 deg.
    let machine = FiveAxis::new(&preset::<f64>("s45").unwrap()).unwrap();
    let path = [
        cl([0.0; 3], [1.0, 0.0, 0.02]),
        cl([10.0, 0.0, 0.0], [0.5, 0.8, 0.02]),
        cl([20.0, 0.0, 0.0], [0.0, 1.0, -0.3]),
    ];
    let start = machine
        .inverse(path[0].p(), path[0].v(), &angles([0.0, 0.0]))
        .unwrap();
    let mut follower = Follower::new(&machine, tolerance(0.01, 0.05), path[0], start).unwrap();

    assert!(follower.push(path[1], None, Feed::Tip(FEED)).unwrap());
    while follower.next_block().is_some() {}
    let refused = follower.push(path[2], None, Feed::Tip(FEED)).unwrap_err();

    assert!(
        matches!(refused.why, Refusal::Machine(Error::Unreachable { .. })),
        "{refused:?}"
    );
    assert_eq!(refused.segment, 1);
    assert!(refused.u > 0.0 && refused.u <= 1.0);
    assert!(follower.next_block().is_none());
}

#[test]
fn a_change_of_solution_while_the_tip_moves_is_one_block_flagged_reconfigure() {
    let (definition, path) = trap();
    let machine = FiveAxis::new(&definition).unwrap();
    // Joints as the greedy choice has them: solution 2 twice, then solution 1.
    let mut chosen: Vec<Solution<f64>> = Vec::new();
    for at in &path {
        let before = chosen.last().map_or(angles([0.0, 5.0]), |s| s.rotary);
        chosen.push(machine.inverse(at.p(), at.v(), &before).unwrap());
    }
    let mut follower = Follower::new(&machine, tolerance(0.01, 0.05), path[0], chosen[0]).unwrap();

    follower
        .push(path[1], Some(chosen[1]), Feed::Tip(10.0))
        .unwrap();
    let smooth: Vec<_> = std::iter::from_fn(|| follower.next_block()).collect();
    follower
        .push(path[2], Some(chosen[2]), Feed::Tip(10.0))
        .unwrap();
    let jump: Vec<_> = std::iter::from_fn(|| follower.next_block()).collect();

    assert!(!smooth.is_empty() && smooth.iter().all(|b| !b.flags.reconfigure));
    assert_eq!(jump.len(), 1);
    assert!(jump[0].flags.reconfigure);
}

#[test]
fn opposite_axes_have_no_path_between_them() {
    let path = [
        cl([0.0; 3], [0.0, 0.1, 1.0]),
        cl([5.0, 0.0, 0.0], [0.0, -0.1, -1.0]),
    ];

    let refused = follow(&preset("head_ca").unwrap(), &path, 0.01, 0.05, [0.0, 0.0]).unwrap_err();

    assert_eq!(refused.why, Refusal::AntiParallel);
}

#[test]
fn feeds_and_tolerances_not_above_zero_are_refused() {
    let machine = FiveAxis::new(&preset::<f64>("head_ca").unwrap()).unwrap();
    let at = cl([0.0; 3], [0.0, 0.1, 1.0]);
    let set = machine
        .inverse(at.p(), at.v(), &angles([0.0, 0.0]))
        .unwrap();

    for (tip, axis) in [
        (0.0, 0.1),
        (0.1, -1.0),
        (f64::NAN, 0.1),
        (0.1, f64::INFINITY),
    ] {
        let refused = Follower::new(&machine, tolerance(tip, axis), at, set).unwrap_err();
        assert_eq!(refused, Refusal::BadLimit);
    }
    for feed in [0.0, -3.0, f64::NAN, f64::INFINITY] {
        for feed in [Feed::Tip(feed), Feed::Time(feed)] {
            let mut follower = Follower::new(&machine, tolerance(0.1, 0.1), at, set).unwrap();
            let refused = follower.push(cl([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]), None, feed);
            assert_eq!(refused.unwrap_err().why, Refusal::BadFeed);
        }
    }
}

// ---- refusals of machines and poses, by name ----

#[test]
fn wrong_machines_are_refused_by_the_name_of_what_is_wrong() {
    let good = preset::<f64>("head_ca").unwrap();
    let nan = vector([0.0, f64::NAN, 0.0]);
    let tiny = vector([1e-7, 0.0, 0.0]);
    let almost = vector([0.0, 0.0009, 1.0]);
    let wrong: Vec<(&str, Definition<f64>)> = vec![
        ("NonFinite", Definition { q1: nan, ..good }),
        (
            "NonFinite",
            Definition {
                n2: nan,
                v1: tiny,
                ..good
            },
        ),
        (
            "NonFinite",
            Definition {
                speeds: Some([f64::INFINITY; 5]),
                ..good
            },
        ),
        (
            "NonFinite",
            Definition {
                weights: [1.0, f64::NAN],
                ..good
            },
        ),
        (
            "NonFinite",
            Definition {
                limits: limits([[0.0, f64::NAN], [0.0, 1.0]]),
                ..good
            },
        ),
        (
            "BadDirection",
            Definition {
                v1: tiny,
                n1: tiny,
                ..good
            },
        ),
        ("BadAxis", Definition { n1: tiny, ..good }),
        (
            "BadAxis",
            Definition {
                rw: Rotation {
                    n: Vector::Y,
                    ..Rotation::IDENTITY
                },
                ..good
            },
        ),
        ("ParallelAxes", Definition { n2: almost, ..good }),
        (
            "ToolAlongAxis",
            Definition {
                v1: vector([-1.0, 0.0, 0.0005]),
                ..good
            },
        ),
        (
            "LinearAxesDependent",
            Definition {
                linear: [Vector::X, Vector::Y, vector([1.0, 1.0, 0.0009])],
                ..good
            },
        ),
        (
            "BadLimit",
            Definition {
                limits: limits([[1.0, -1.0], [0.0, 1.0]]),
                ..good
            },
        ),
        (
            "BadLimit",
            Definition {
                weights: [0.0, 1.0],
                ..good
            },
        ),
        (
            "BadLimit",
            Definition {
                speeds: Some([1.0, 1.0, 0.0, 1.0, 1.0]),
                ..good
            },
        ),
    ];
    for (name, definition) in wrong {
        let error = FiveAxis::new(&definition).unwrap_err();
        assert_eq!(error.name(), name, "{definition:?}");
    }
    assert!(
        FiveAxis::new(&Definition {
            n2: vector([0.0, 0.002, 1.0]),
            ..good
        })
        .is_ok()
    );
}

#[test]
fn wrong_poses_are_refused_by_name_with_axis_gap_and_nearest() {
    let mut definition = preset::<f64>("s45").unwrap();
    definition.limits[0] = Some([-100.0, 100.0]);
    let machine = FiveAxis::new(&definition).unwrap();
    let zero = angles([0.0, 0.0]);
    let p = vector([100.0, 50.0, 200.0]);

    assert_eq!(
        machine.inverse(p, unit([0.1, 0.2, 0.95]), &zero),
        Err(Error::OutOfTravel { axis: Axis::X })
    );
    let Err(Error::Unreachable { gap, nearest }) =
        machine.inverse(p, unit([0.9, 0.3, -0.1]), &zero)
    else {
        panic!("reached");
    };
    near(gap.to_degrees(), 6.017284864, 9, "gap");
    all_near(
        &degrees(&nearest)[3..],
        &[71.565051177, 180.0],
        9,
        "nearest",
    );
    for v in [[1e-7, 0.0, 0.0], [0.0; 3]] {
        let refused = five_axis::direction(vector(v), "v").unwrap_err();
        assert_eq!(refused.name(), "BadDirection");
    }
    let refused = five_axis::direction(vector([f64::NAN, 0.0, 1.0]), "v").unwrap_err();
    assert_eq!(refused.name(), "NonFinite");
    let huge = five_axis::direction(vector([1e300, 0.0, 1e300]), "v").unwrap();
    assert!((huge.norm() - 1.0).abs() < 1e-12);
    let far = machine.inverse(vector([f64::MAX, f64::MAX, f64::MAX]), Vector::Z, &zero);
    assert!(far.is_err());
    let bad = machine
        .forward(&Joints([0.0, f64::NAN, 0.0, 0.0, 0.0]))
        .unwrap_err();
    assert_eq!(bad.name(), "NonFinite");
}

#[test]
fn turns_are_kept_apart_from_the_angle() {
    for total in [
        0.0,
        3.0,
        -3.0,
        10.0,
        -10.0,
        1000.0,
        -0.1,
        700.0 * std::f64::consts::TAU,
    ] {
        let turned = Turned::from_total(total);
        assert!(turned.angle > -std::f64::consts::PI && turned.angle <= std::f64::consts::PI);
        assert!((turned.total() - total).abs() < 1e-11, "{total}");
    }
    // Ten turns on: the same tip to the bit, in f32.
    let machine = FiveAxis::new(&preset::<f32>("table_ac").unwrap()).unwrap();
    let v = five_axis::direction(vector([0.3f32, 0.2, 0.9]), "v").unwrap();
    let p = vector([400.0f32, 300.0, 20.0]);
    let near_zero = machine.inverse(
        p,
        v,
        &[
            Turned {
                turns: 0,
                angle: 0.4,
            },
            Turned {
                turns: 0,
                angle: 1.0,
            },
        ],
    );
    let near_ten = machine.inverse(
        p,
        v,
        &[
            Turned {
                turns: 0,
                angle: 0.4,
            },
            Turned {
                turns: 10,
                angle: 1.0,
            },
        ],
    );
    let (near_zero, near_ten) = (near_zero.unwrap(), near_ten.unwrap());
    assert_eq!(near_zero.linear, near_ten.linear);
    assert_eq!(near_ten.rotary[1].turns, 10 + near_zero.rotary[1].turns);
}

// ---- helpers ----

/// F 1000 mm/min.
const FEED: f64 = 1000.0 / 60.0;

fn read_cases(name: &str) -> Value {
    let path = format!("{}/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("case file");
    serde_json::from_str(&text).expect("JSON")
}

fn vector<R: Real>(x: [R; 3]) -> Vector<R> {
    Vector::from_array(x)
}

fn unit(x: [f64; 3]) -> Vector<f64> {
    five_axis::direction(vector(x), "v").expect("direction")
}

fn cl(p: [f64; 3], v: [f64; 3]) -> ClPoint<f64> {
    ClPoint::new(vector(p), vector(v)).expect("CL point")
}

fn angles(degrees: [f64; 2]) -> [Turned<f64>; 2] {
    degrees.map(|a| Turned::from_total(a.to_radians()))
}

fn limits(rotary: [[f64; 2]; 2]) -> [Option<[f64; 2]>; 5] {
    let [primary, secondary] = rotary.map(|l| Some(l.map(f64::to_radians)));
    [None, None, None, primary, secondary]
}

fn degrees(joints: &Joints<5, f64>) -> [f64; 5] {
    let Joints([x, y, z, a, b]) = *joints;
    [x, y, z, a.to_degrees(), b.to_degrees()]
}

fn tolerance(tip: f64, axis_deg: f64) -> Tolerance<f64> {
    Tolerance {
        tip,
        axis: axis_deg.to_radians(),
        subdivide: true,
    }
}

/// `found` printed with `digits` decimals is `printed`.
#[track_caller]
fn near(found: f64, printed: f64, digits: i32, what: &str) {
    let unit = 10f64.powi(-digits);
    assert!(
        (found - printed).abs() <= 0.5001 * unit,
        "{what}: {found:.12} is not {printed}"
    );
}

#[track_caller]
fn all_near(found: &[f64], printed: &[f64], digits: i32, what: &str) {
    assert_eq!(found.len(), printed.len());
    for (found, printed) in found.iter().zip(printed) {
        near(*found, *printed, digits, what);
    }
}

/// The pivots of section 9's table of machines.
fn with_pivots(name: &str) -> Definition<f64> {
    let base = preset::<f64>(name).expect("preset");
    if name == "s45" {
        return base;
    }
    let (q1, q2) = match base.class {
        Class::Head => ([0.0, 0.0, 250.0], [10.0, 0.0, 200.0]),
        Class::Table => ([0.0, 0.0, -50.0], [0.0, 20.0, -50.0]),
        Class::Mixed => ([0.0, 0.0, -50.0], [10.0, 0.0, 200.0]),
    };
    Definition {
        q1: vector(q1),
        q2: vector(q2),
        w0: vector([5.0, -8.0, 12.0]),
        ..base
    }
}

/// Section 9's path: 13 CL points about the frustum.
fn frustum() -> Vec<ClPoint<f64>> {
    let s = (100.0f64 / 500.0).atan();
    let turned = |angle: f64, [x, y, z]: [f64; 3]| {
        let (sin, cos) = angle.to_radians().sin_cos();
        [x * cos - y * sin, x * sin + y * cos, z]
    };
    let axis = [-s.sin(), 0.0, s.cos()];
    let foot = |y: f64| [250.0 + 10.0 * s.cos(), y, 10.0 * s.sin()];
    let mut path = vec![cl(foot(-250.0), axis)];
    for side in 0..4 {
        let at = 90.0 * f64::from(side);
        path.push(cl(turned(at, foot(250.0)), turned(at, axis)));
        // About the vertical corner edge at (250, 250).
        let [x, y, z] = turned(45.0, [10.0 * s.cos(), 0.0, 10.0 * s.sin()]);
        path.push(cl(
            turned(at, [250.0 + x, 250.0 + y, z]),
            turned(at + 45.0, axis),
        ));
        path.push(cl(turned(at + 90.0, foot(-250.0)), turned(at + 90.0, axis)));
    }
    path
}

fn trap() -> (Definition<f64>, Vec<ClPoint<f64>>) {
    let mut definition = preset::<f64>("head_ca").unwrap();
    definition.limits = limits([[-270.0, 270.0], [-110.0, 25.0]]);
    let path = vec![
        cl([0.0, 0.0, 0.0], [0.05, -0.2, 0.97]),
        cl([5.0, 0.0, 0.0], [0.1, -0.4, 0.9]),
        cl([10.0, 0.0, 0.0], [0.1, -0.6, 0.75]),
    ];
    (definition, path)
}

/// True tip error and tip bound of the frustum's first half corner, undivided.
fn corner_errors(definition: &Definition<f64>, path: &[ClPoint<f64>]) -> [f64; 2] {
    let machine = FiveAxis::new(definition).unwrap();
    let a = machine
        .inverse(path[1].p(), path[1].v(), &angles([0.0, 0.0]))
        .unwrap();
    let b = machine
        .inverse(path[2].p(), path[2].v(), &a.rotary)
        .unwrap();
    let chord = (path[2].v() - path[1].v()).norm();
    let bounds = machine.bounds(&a, &b, (path[2].p() - path[1].p()).norm(), chord);
    let (tip, axis) = true_errors(definition, (&path[1], &a), (&path[2], &b), 400);
    near(axis, 0.84113, 5, "half a corner, axis");
    near(
        bounds.axis.unwrap().to_degrees(),
        0.85159,
        5,
        "half a corner, axis bound",
    );
    [tip, bounds.tip]
}

type Followed = Result<Vec<Block<5, f64, Solution<f64>>>, Refused<f64, Error<f64>>>;

/// All blocks of a path after its first point, greedy choice.
fn follow(
    definition: &Definition<f64>,
    path: &[ClPoint<f64>],
    tip: f64,
    axis_deg: f64,
    previous: [f64; 2],
) -> Followed {
    let machine = FiveAxis::new(definition).expect("machine");
    let at = |why| Refused {
        segment: 0,
        u: 0.0,
        why,
    };
    let start = machine
        .inverse(path[0].p(), path[0].v(), &angles(previous))
        .map_err(|error| at(Refusal::Machine(error)))?;
    let mut follower =
        Follower::new(&machine, tolerance(tip, axis_deg), path[0], start).map_err(at)?;
    let mut blocks = Vec::new();
    for to in &path[1..] {
        follower.push(*to, None, Feed::Tip(FEED))?;
        blocks.extend(std::iter::from_fn(|| follower.next_block()));
    }
    Ok(blocks)
}

fn choose_path<R: Real, const S: usize>(
    machine: &FiveAxis<R>,
    path: &[ClPoint<R>],
    window: usize,
    start: [Turned<R>; 2],
) -> Vec<Solution<R>> {
    let mut layers = vec![Layer::<R, S>::empty(); window];
    let mut choice = PathChoice::new(machine, &mut layers, start);
    let mut chosen = Vec::new();
    for at in path {
        if choice.is_full() {
            chosen.push(choice.pop().unwrap().unwrap());
        }
        assert!(choice.push(at.p(), at.v()).unwrap());
    }
    while let Some(solution) = choice.pop() {
        chosen.push(solution.unwrap());
    }
    assert!(choice.is_exact());
    assert_eq!(chosen.len(), path.len());
    chosen
}

/// Least cost [rad] over every chain of solutions and turns, by trying them all; a pole holds primary or secondary.
fn brute_force(
    machine: &FiveAxis<f64>,
    definition: &Definition<f64>,
    path: &[ClPoint<f64>],
    from: [f64; 2],
) -> f64 {
    let Some((first, rest)) = path.split_first() else {
        return 0.0;
    };
    let branches = machine.branches(first.v(), &angles([0.0, 0.0]));
    assert_eq!(branches.kind, Kind::Two);
    let mut best = f64::INFINITY;
    for [a, b] in branches.solutions() {
        let turns = |angle: f64, limit: Option<[f64; 2]>| {
            let [lo, hi] = limit.unwrap();
            (-3..=3)
                .map(move |k| angle + f64::from(k) * std::f64::consts::TAU)
                .filter(move |x| (lo..=hi).contains(x))
        };
        for a in turns(*a, definition.limits[3]) {
            for b in turns(*b, definition.limits[4]) {
                let [w1, w2] = definition.weights;
                let step = w1 * (a - from[0]).abs() + w2 * (b - from[1]).abs();
                best = best.min(step + brute_force(machine, definition, rest, [a, b]));
            }
        }
    }
    best
}

/// The point at `u` of a straight line and a great circle.
fn between(path: &[ClPoint<f64>], u: f64) -> ClPoint<f64> {
    let (a, b) = (path[0], path[1]);
    let w = angle_deg(a.v().to_array(), b.v().to_array()).to_radians();
    let v = if w < 1e-9 {
        b.v()
    } else {
        a.v() * (((1.0 - u) * w).sin() / w.sin()) + b.v() * ((u * w).sin() / w.sin())
    };
    ClPoint::new(a.p() + (b.p() - a.p()) * u, v).unwrap()
}

/// Largest errors of the linear joint move, tip [mm] and axis [deg], at u = 1/n .. (n-1)/n.
fn true_errors(
    definition: &Definition<f64>,
    (from, a): (&ClPoint<f64>, &Solution<f64>),
    (to, b): (&ClPoint<f64>, &Solution<f64>),
    samples: u32,
) -> (f64, f64) {
    let (mut tip, mut axis) = (0f64, 0f64);
    for i in 1..samples {
        let u = f64::from(i) / f64::from(samples);
        let (qa, qb) = (a.joints(), b.joints());
        let q: [f64; 5] = std::array::from_fn(|j| qa[j] + (qb[j] - qa[j]) * u);
        let (p, v) = reference_forward(definition, &q);
        let wanted = between(&[*from, *to], u);
        tip = tip.max(distance(p, wanted.p().to_array()));
        axis = axis.max(angle_deg(v, wanted.v().to_array()));
    }
    (tip, axis)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot: f64 = (0..3).map(|i| a[i] * b[i]).sum();
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    distance(cross, [0.0; 3]).atan2(dot).to_degrees()
}

type Matrix = [[f64; 4]; 4];

/// Tip and axis of joints [mm, rad]: 4x4 matrices of each axis from unit quaternions, inverted and multiplied.
fn reference_forward(m: &Definition<f64>, q: &[f64; 5]) -> ([f64; 3], [f64; 3]) {
    let mut shift = [0.0; 3];
    for (direction, x) in m.linear.iter().zip(q) {
        let norm = distance(direction.to_array(), [0.0; 3]);
        for (shift, d) in shift.iter_mut().zip(direction.to_array()) {
            *shift += d / norm * x;
        }
    }
    let moved = translation(shift);
    let x1 = about(m.n1.to_array(), m.q1.to_array(), q[3]);
    let x2 = about(m.n2.to_array(), m.q2.to_array(), q[4]);
    let one = translation([0.0; 3]);
    let (head, table) = match m.class {
        Class::Head => (multiply(&x1, &x2), one),
        Class::Table => (one, multiply(&x1, &x2)),
        Class::Mixed => (x2, x1),
    };
    let (n, s, a) = (m.rw.n, m.rw.s, m.rw.a);
    let work = [
        [n.x, s.x, a.x, m.w0.x],
        [n.y, s.y, a.y, m.w0.y],
        [n.z, s.z, a.z, m.w0.z],
        [0.0, 0.0, 0.0, 1.0],
    ];
    // work frame <- base: inverse of (table * work).
    let back = inverted(&multiply(&table, &work));
    let tool = multiply(&back, &multiply(&moved, &head));
    let norm = distance(m.v1.to_array(), [0.0; 3]);
    let apply = |x: [f64; 3], w: f64| {
        std::array::from_fn(|i| (0..3).map(|j| tool[i][j] * x[j]).sum::<f64>() + tool[i][3] * w)
    };
    (
        apply(m.t0.to_array(), 1.0),
        apply(m.v1.to_array().map(|x| x / norm), 0.0),
    )
}

fn translation([x, y, z]: [f64; 3]) -> Matrix {
    [
        [1.0, 0.0, 0.0, x],
        [0.0, 1.0, 0.0, y],
        [0.0, 0.0, 1.0, z],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn about(n: [f64; 3], q: [f64; 3], angle: f64) -> Matrix {
    let norm = distance(n, [0.0; 3]);
    let (s, w) = (angle / 2.0).sin_cos();
    let [x, y, z] = n.map(|n| n / norm * s);
    let turn = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
            0.0,
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
            0.0,
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
            0.0,
        ],
        [0.0, 0.0, 0.0, 1.0],
    ];
    multiply(
        &translation(q),
        &multiply(&turn, &translation(q.map(|q| -q))),
    )
}

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn inverted(m: &Matrix) -> Matrix {
    let mut out = translation([0.0; 3]);
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = m[j][i];
        }
        out[i][3] = -(0..3).map(|k| m[k][i] * m[k][3]).sum::<f64>();
    }
    out
}

/// Machines of all classes, axes and tool along any direction, pivots to 1000 mm.
fn random_machine(random: &mut Random, i: usize) -> Definition<f64> {
    let base = preset::<f64>(PRESETS[i % 13]).unwrap();
    loop {
        let definition = Definition {
            n1: random.vector(),
            n2: random.vector(),
            q1: random.vector() * 1000.0,
            q2: random.vector() * 1000.0,
            v1: random.vector(),
            t0: random.vector() * 1000.0,
            w0: random.vector() * 1000.0,
            rw: random.frame(),
            linear: {
                // Not quite at right angles, and left-handed as often as not.
                let Rotation { n, s, a } = random.frame();
                let sign = random.within(-1.0, 1.0).signum();
                [n, s, a * sign].map(|axis| axis + random.vector() * 0.1)
            },
            limits: [None; 5],
            ..base
        };
        let sines = [
            unit(definition.n1.to_array())
                .cross(unit(definition.n2.to_array()))
                .norm(),
            unit(definition.n2.to_array())
                .cross(unit(definition.v1.to_array()))
                .norm(),
            unit(definition.n1.to_array())
                .cross(unit(definition.v1.to_array()))
                .norm(),
        ];
        if sines.iter().all(|s| *s > 0.2) {
            return definition;
        }
    }
}

fn random_pose(random: &mut Random) -> (Vector<f64>, Vector<f64>) {
    (random.vector() * 1000.0, unit(random.vector().to_array()))
}

fn widen(v: Vector<f32>) -> Vector<f64> {
    vector(v.to_array().map(f64::from))
}

fn narrow(m: &Definition<f64>) -> Definition<f32> {
    let v = |v: Vector<f64>| vector(v.to_array().map(|x| x as f32));
    Definition {
        class: m.class,
        n1: v(m.n1),
        n2: v(m.n2),
        q1: v(m.q1),
        q2: v(m.q2),
        v1: v(m.v1),
        t0: v(m.t0),
        w0: v(m.w0),
        rw: Rotation {
            n: v(m.rw.n),
            s: v(m.rw.s),
            a: v(m.rw.a),
        },
        linear: m.linear.map(v),
        limits: m.limits.map(|l| l.map(|l| l.map(|x| x as f32))),
        weights: m.weights.map(|x| x as f32),
        speeds: None,
    }
}

/// What is left of a machine in f32; its unit vectors are unit again in f64.
fn round_machine(m: &Definition<f64>) -> Definition<f64> {
    let m = narrow(m);
    Definition {
        class: m.class,
        n1: widen(m.n1),
        n2: widen(m.n2),
        q1: widen(m.q1),
        q2: widen(m.q2),
        v1: widen(m.v1),
        t0: widen(m.t0),
        w0: widen(m.w0),
        rw: {
            let n = unit(widen(m.rw.n).to_array());
            let a = unit(n.cross(widen(m.rw.s)).to_array());
            Rotation {
                n,
                s: a.cross(n),
                a,
            }
        },
        linear: m.linear.map(widen),
        limits: m.limits.map(|l| l.map(|l| l.map(f64::from))),
        weights: m.weights.map(f64::from),
        speeds: None,
    }
}

/// xorshift64*: seeded, the same everywhere.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11;
        lo + (hi - lo) * bits as f64 / (1u64 << 53) as f64
    }

    fn frame(&mut self) -> Rotation<f64> {
        let n = unit(self.vector().to_array());
        let a = unit(n.cross(self.vector()).to_array());
        Rotation {
            n,
            s: a.cross(n),
            a,
        }
    }

    /// In the unit ball, not near its centre.
    fn vector(&mut self) -> Vector<f64> {
        loop {
            let v = vector([
                self.within(-1.0, 1.0),
                self.within(-1.0, 1.0),
                self.within(-1.0, 1.0),
            ]);
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v;
            }
        }
    }
}

/// The trait is what the follower sees of the machine; here it must say the same as the machine itself.
#[test]
fn the_guide_of_a_machine_says_what_the_machine_says() {
    let machine = FiveAxis::new(&preset::<f64>("s45").unwrap()).unwrap();
    let (a, b) = (
        cl([1.0, 2.0, 3.0], [0.1, 0.2, 1.0]),
        cl([4.0, 2.0, 3.0], [0.2, 0.2, 1.0]),
    );
    let start = machine.inverse(a.p(), a.v(), &angles([0.0, 0.0])).unwrap();

    let end = machine.solve(&b, &start).unwrap();

    assert_eq!(end, machine.inverse(b.p(), b.v(), &start.rotary).unwrap());
    let change = machine.change(&start, &end);
    for j in 0..5 {
        assert!((change[j] - (end.joints()[j] - start.joints()[j])).abs() < 1e-12);
    }
}

// ---- the calculators ----

/// The examples of the interface and every error by name; a case lists the members it is about.
#[test]
fn the_calculators_answer_their_examples_and_name_their_errors() {
    let cases = read_cases("five_axis_calc.json");

    for case in cases.as_array().expect("cases") {
        let (function, request) = (case["function"].as_str().unwrap(), &case["request"]);
        let expected = &case["answer"];

        let (status, answer) = calculate(function, "f64", request);

        let is_error = expected.get("error").is_some();
        assert_eq!(status, if is_error { 2 } else { 0 }, "{request}\n{answer}");
        assert_holds(
            &answer,
            expected,
            &format!("{function} {request}\n{answer}"),
        );
        assert!(!is_error || answer["detail"].as_str().unwrap().len() > 10);
    }
}

#[test]
fn the_calculators_answer_the_frustum_and_say_which_joint_slows_it() {
    let cl: Vec<Value> = frustum()
        .iter()
        .map(|at| json!({"p": at.p().to_array(), "v": at.v().to_array()}))
        .collect();
    let request = json!({"machine": "s45", "cl": cl, "feed": FEED});
    let slow = json!({
        "machine": {"preset": "s45", "speeds": [1e3, 1e3, 1e3, 50, 50]}, "cl": cl, "feed": FEED,
    });

    let (status, answer) = calculate("five_axis.path", "f64", &request);
    let (_, slowed) = calculate("five_axis.path", "f64", &slow);
    let (_, best) = calculate("five_axis.path", "f64", &with(&request, "choice", "best"));
    let (status32, single) = calculate("five_axis.path", "f32", &request);

    assert_eq!((status, status32), (0, 0));
    let segments = [1, 64, 64, 1, 64, 64, 1, 64, 64, 1, 64, 64];
    assert_eq!(answer["per_segment"], json!(segments));
    let expected = json!({"count": 517, "total_time": 123.602419});
    assert_holds(&answer, &expected, "frustum");
    let blocks = |answer: &Value| answer["blocks"].as_array().unwrap().clone();
    let corner = blocks(&answer)[2].clone();
    assert_holds(
        &corner,
        &json!({
            "segment": 1,
            "q": [217.612133, 226.852274, -4.775910, -6.295594, -15.949879],
            "flags": [],
            "limited_by": "feed",
        }),
        "corner",
    );
    near(
        corner["inverse_time"].as_f64().unwrap(),
        8527.603,
        3,
        "inverse time",
    );
    assert_eq!(blocks(&slowed)[2]["limited_by"], "primary");
    assert!(slowed["total_time"].as_f64().unwrap() > 126.0);
    assert_eq!(best["count"], 517);
    // Twice the f32 rounding of a bound near its tolerance may split a block more or less.
    let count = single["count"].as_i64().unwrap();
    assert!((count - 517).abs() <= 16, "{count}");
}

fn calculate(function: &str, scalar: &str, request: &Value) -> (u8, Value) {
    let mut output = Vec::new();
    let input = request.to_string();
    let status = hexstep_host::calc::main(function, scalar, input.as_bytes(), &mut output);
    let answer = serde_json::from_slice(&output).expect("the answer is JSON");
    (status.expect("memory does not fail"), answer)
}

fn with(request: &Value, name: &str, value: &str) -> Value {
    let mut request = request.clone();
    request[name] = value.into();
    request
}

/// Every member of `expected` is in `answer`, numbers to the digits printed and to six at least.
#[track_caller]
fn assert_holds(answer: &Value, expected: &Value, what: &str) {
    match (answer, expected) {
        (Value::Object(answer), Value::Object(expected)) => {
            for (name, expected) in expected {
                let answer = answer
                    .get(name)
                    .unwrap_or_else(|| panic!("no {name}: {what}"));
                assert_holds(answer, expected, what);
            }
        }
        (Value::Array(answer), Value::Array(expected)) => {
            assert_eq!(answer.len(), expected.len(), "{what}");
            for (answer, expected) in answer.iter().zip(expected) {
                assert_holds(answer, expected, what);
            }
        }
        (Value::Number(answer), Value::Number(number)) => {
            let text = number.to_string();
            let digits = text
                .split_once('.')
                .map_or(0, |(_, decimals)| decimals.len());
            let digits = i32::try_from(digits.max(6)).unwrap();
            near(
                answer.as_f64().unwrap(),
                number.as_f64().unwrap(),
                digits,
                what,
            );
        }
        _ => assert_eq!(answer, expected, "{what}"),
    }
}
