//! Five-axis machines against the specification's numbers and against a forward map of 4x4 matrices and quaternions
//! that shares no code with the library.

// Each test file uses a part of what they share.
#[allow(dead_code)]
mod five_axis_shared;

use five_axis_shared::*;
use hexstep::geometry::{Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::ClPoint;
use hexstep::machines::five_axis::{
    self, Axis, Definition, Error, FiveAxis, Kind, Layer, PRESETS, PathChoice, Solution, Turned,
    preset,
};
use hexstep::math::Real;
use hexstep_host::reference::five_axis::*;
use serde_json::Value;

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
    type Row = (Definition<f64>, [[f64; 3]; 4], [f64; 4]);
    let rows: [Row; 3] = [
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

fn read_cases(name: &str) -> Value {
    let path = format!("{}/cases/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).expect("case file");
    serde_json::from_str(&text).expect("JSON")
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
