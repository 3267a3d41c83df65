//! Following CL points: tolerances, feeds, poles, refusals.

// Each test file uses a part of what they share.
#[allow(dead_code)]
mod five_axis_shared;

use five_axis_shared::*;
use hexstep::kinematics::ClPoint;
use hexstep::kinematics::follow::{Feed, Follower, Guide, Refusal, Tolerance};
use hexstep::machines::five_axis::{Definition, Error, FiveAxis, Solution, Turned, preset};
use hexstep_host::reference::five_axis::*;
use serde_json::{Value, json};

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

/// What the target computes with: near and through the pole, in f32, every block keeps its tolerance.
#[test]
fn in_single_precision_paths_about_the_pole_keep_their_tolerance() {
    for name in ["head_ca", "table_ac", "mixed_ca", "s45"] {
        for aside in [0.0f32, 1e-6, 1e-4, 1e-2] {
            let definition = preset::<f32>(name).unwrap();
            let wide = preset::<f64>(name).unwrap();
            let machine = FiveAxis::new(&definition).unwrap();
            let at = |x: f32, v: [f32; 3]| {
                ClPoint::new(vector([x, 20.0, 5.0]), vector(v)).expect("CL point")
            };
            let from = at(0.0, [0.2, aside, 1.0]);
            let to = at(30.0, [-0.2, aside, 1.0]);
            let zero = [0.0, 0.0].map(Turned::from_total);
            let start = machine.inverse(from.p(), from.v(), &zero).unwrap();
            let tolerance = Tolerance {
                tip: 0.01,
                axis: 0.05f32.to_radians(),
                subdivide: true,
            };
            let mut follower = Follower::new(&machine, tolerance, from, start).unwrap();
            follower.push(to, None, Feed::Tip(10.0)).unwrap();
            let widened = |at: &ClPoint<f32>| ClPoint::new(widen(at.p()), widen(at.v())).unwrap();
            let path = [widened(&from), widened(&to)];

            let (mut u, mut before, mut coarse) = (0.0, start.joints(), 0);
            while let Some(block) = follower.next_block() {
                coarse += usize::from(block.flags.coarse);
                for i in 1..=8 {
                    let part = f64::from(i) / 8.0;
                    let q = std::array::from_fn(|j| {
                        let (a, b) = (f64::from(before[j]), f64::from(block.joints[j]));
                        a + (b - a) * part
                    });
                    let (p, v) = reference_forward(&wide, &q);
                    let wanted = between(&path, u + (f64::from(block.u) - u) * part);
                    let tip = distance(p, wanted.p().to_array());
                    let axis = angle_deg(v, wanted.v().to_array());
                    let is_kept = tip <= 0.0101 && axis <= 0.0502;
                    assert!(
                        is_kept || block.flags.coarse,
                        "{name} {aside}: {tip} mm, {axis} deg"
                    );
                }
                (u, before) = (f64::from(block.u), block.joints);
            }
            assert_eq!(u, 1.0);
            // Half a turn of the free axis within a part of 2^-12 is more than the narrowest interval can hide; it is
            // said, and only there.
            assert!(coarse <= 8, "{name} {aside}: {coarse} coarse");
        }
    }
}
