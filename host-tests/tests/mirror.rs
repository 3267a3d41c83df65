//! Two-sided machines: forward map, wall, closed form of one side and of both.

mod common;

use common::{
    Matrix, Random, UNIT, exponential, matrix, rigid_inverse, rounded, through, times, widened,
};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::kinematics::chain::{Carries, Chain, Joint, Motion};
use hexstep::machines::two_sided::{
    Kind, Pair, PairError, Side, SideError, WallLimits, m4, m4_1, m4_2, m5, m5_1,
};
use hexstep::math::Real;
use std::f64::consts::PI;

const HALF_OF_THE_NINTH_DIGIT: f64 = 0.51e-9;

fn at(x: f64, y: f64, z: f64) -> Vector<f64> {
    Vector::new(x, y, z)
}

/// Support-side surface of the panel in w1, section 8: point and normal.
fn panel(x: f64, y: f64) -> (Vector<f64>, Vector<f64>) {
    let height = (4000.0 * 4000.0 - x * x).sqrt();
    (
        at(x, y, height - 4000.0),
        at(x, 0.0, height) * (1.0 / 4000.0),
    )
}

/// Joints in mm and degrees, as the specification prints them.
fn shown<const N: usize>(q: &Joints<N, f64>) -> [f64; N] {
    std::array::from_fn(|i| if i < 3 { q[i] } else { q[i].to_degrees() })
}

fn given<const N: usize>(printed: [f64; N]) -> Joints<N, f64> {
    Joints(std::array::from_fn(|i| {
        if i < 3 {
            printed[i]
        } else {
            printed[i].to_radians()
        }
    }))
}

#[track_caller]
fn assert_printed(found: &[f64], printed: &[f64]) {
    assert_eq!(found.len(), printed.len());
    for (a, b) in found.iter().zip(printed) {
        assert!(
            (a - b).abs() < HALF_OF_THE_NINTH_DIGIT,
            "{found:?}, printed {printed:?}"
        );
    }
}

/// g_t and g_w by series exponentials: no code of the library.
fn reference<const N: usize>(chain: &Chain<N, f64>, q: &Joints<N, f64>) -> [Matrix; 2] {
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

/// Tip and axis in the side's own work frame, by the reference.
fn reached<const N: usize>(
    chain: &Chain<N, f64>,
    q: &Joints<N, f64>,
) -> (Vector<f64>, Vector<f64>) {
    let [tool, work] = reference(chain, q);
    let relative = times(&rigid_inverse(&work), &tool);
    let series = chain.series();
    (
        through(&relative, series.tip, 1.0),
        through(&relative, series.axis, 0.0),
    )
}

#[test]
fn the_pairs_stand_where_the_specification_prints_them() {
    let machine = m4::<f64>().expect("a machine");
    let at_home = (&Joints([0.0; 4]), &Joints([0.0; 4]));
    let rows = [
        (
            panel(0.0, 100.0),
            [600.0, 550.0, -48.5, 0.0],
            [-600.0, 550.0, -50.0, 0.0],
        ),
        (
            panel(-400.0, 100.0),
            [159.85, 550.0, -70.562795575, -5.739170477],
            [-238.0, 550.0, -31.854522326, -5.739170477],
        ),
        (
            panel(250.0, 100.0),
            [875.09375, 550.0, -57.105091320, 3.583321698],
            [-826.25, 550.0, -42.922769379, 3.583321698],
        ),
        (
            panel(500.0, 100.0),
            [1150.1875, 550.0, -83.022101631, 7.180755781],
            [-1052.5, 550.0, -21.607404770, 7.180755781],
        ),
    ];
    for ((p, n), q1, q2) in rows {
        let found = machine.solve(p, n, 1.5, at_home).expect("within reach");

        assert_printed(&shown(&found.mill.q), &q1);
        assert_printed(&shown(&found.support.q), &q2);
        assert!(found.mill.residual < 1e-11 && found.support.residual < 1e-11);
        let wall = machine
            .forward(&found.mill.q, &found.support.q)
            .wall(Some(n))
            .expect("a normal");
        assert!((wall.thickness - 1.5).abs() < 1e-9 && wall.lateral < 1e-9);
        assert!(wall.anti_parallel < 1e-11);
    }
}

#[test]
fn a_tilt_that_four_axes_cannot_follow_leaves_the_wall_exact_and_the_residual_known() {
    let (p, n) = (at(100.0, 50.0, -2.0), at(0.1, 0.05, 0.99));
    let four = m4::<f64>().expect("a machine");

    let found = four
        .solve(p, n, 1.5, (&Joints([0.0; 4]), &Joints([0.0; 4])))
        .expect("every position is reached");

    let q1 = [740.350040484, 500.075279050, -52.534599207, 5.767888898];
    let q2 = [-661.810491734, 500.0, -49.923868171, 5.767888898];
    assert_printed(&shown(&found.mill.q), &q1);
    assert_printed(&shown(&found.support.q), &q2);
    for residual in [found.mill.residual, found.support.residual] {
        assert_printed(&[residual.to_degrees()], &[2.876656294]);
    }
    assert!(found.mill.is_off_direction() && found.support.is_off_direction());
    let tips = four.forward(&found.mill.q, &found.support.q);
    let wall = tips.wall(Some(n)).expect("a normal");
    assert!((wall.thickness - 1.5).abs() < 1e-9 && wall.lateral < 1e-9);
    assert!(wall.anti_parallel < 1e-11);

    let five = m5::<f64>().expect("a machine");
    let found = five
        .solve(p, n, 1.5, (&Joints([0.0; 5]), &Joints([0.0; 5])))
        .expect("within reach");
    let q1 = [
        746.329306955,
        520.149692299,
        -53.339861142,
        5.767888898,
        -2.876656294,
    ];
    let q2 = [
        -655.828692469,
        480.929307413,
        -50.704055442,
        5.767888898,
        -2.876656294,
    ];
    assert_printed(&shown(&found.mill.q), &q1);
    assert_printed(&shown(&found.support.q), &q2);
    assert_eq!((found.mill.residual, found.support.residual), (0.0, 0.0));
    assert!(!found.mill.is_off_direction());
}

#[test]
fn the_forward_maps_and_the_wall_are_those_of_the_specification() {
    let four = m4::<f64>().expect("a machine");
    let tips = four.forward(
        &given([700.0, 500.0, 10.0, 5.0]),
        &given([-690.0, 500.0, 12.0, 5.0]),
    );
    assert_printed(&tips.p_t.to_array(), &[65.137702901, 50.0, 61.522120763]);
    assert_printed(&tips.o_t.to_array(), &[0.087155743, 0.0, 0.996194698]);
    assert_printed(&tips.p_h.to_array(), &[123.119182244, 50.0, -63.446014725]);
    let wall = tips.wall(None).expect("the cutter axis");
    assert_printed(
        &[wall.thickness, wall.lateral, wall.length],
        &[119.439175106, 68.652532977, 137.763880732],
    );
    assert!(wall.anti_parallel < 1e-12);
    let limits = WallLimits::default();
    assert!(wall.is_lateral(&limits) && !wall.is_not_anti_parallel(&limits));

    let five = m5::<f64>().expect("a machine");
    let tips = five.forward(
        &given([700.0, 500.0, 10.0, 5.0, -4.0]),
        &given([-690.0, 500.0, 12.0, 5.0, -4.0]),
    );
    assert_printed(
        &tips.p_t.to_array(),
        &[59.993281140, 22.097410502, 62.721110964],
    );
    assert_printed(
        &tips.p_h.to_array(),
        &[128.267850146, 76.507460023, -64.596471322],
    );
    assert!(tips.wall(Some(Vector::ZERO)).is_none());
}

/// Section 9: work chain X, B; tool chain Y, A, and the quill W beyond A.
fn generic_side() -> Chain<5, f64> {
    let slide = |carries, axis| Joint::linear(carries, axis).expect("an axis");
    let turn =
        |carries, axis, z| Joint::rotary(carries, axis, at(0.0, 0.0, z), 0.0).expect("an axis");
    Chain::new([
        slide(Carries::Work, Vector::X),
        turn(Carries::Work, Vector::Y, -100.0),
        slide(Carries::Tool, Vector::Y),
        turn(Carries::Tool, Vector::X, 300.0),
        slide(Carries::Tool, Vector::Z),
    ])
}

#[test]
fn linears_may_stand_anywhere_even_beyond_a_rotary() {
    let side = Side::new(generic_side()).expect("a side");

    let found = side
        .solutions(at(20.0, 30.0, 40.0), at(0.2, 0.1, 0.97), &Joints([0.0; 5]))
        .expect("within reach");

    let degrees = |q: &Joints<5, f64>| [q[0], q[1].to_degrees(), q[2], q[3].to_degrees(), q[4]];
    assert_eq!(found.kind, Kind::Two);
    let printed = [
        -8.683325557,
        168.349700562,
        -24.639778081,
        -174.234447810,
        843.905989125,
    ];
    assert_printed(&degrees(&found.first), &printed);
    let printed = [
        8.683325557,
        -11.650299438,
        56.135343378,
        -5.765552190,
        39.838442057,
    ];
    assert_printed(&degrees(&found.second.expect("two")), &printed);
}

/// A side with `rotaries` rotaries and three linears in random order on random chains, axes as rounded to f32.
/// `None` where an arrangement is useless by the rules.
fn random_side<const N: usize>(
    random: &mut Random,
    rotaries: usize,
) -> Option<(Side<N, f64>, Side<N, f32>)> {
    let mut turns: [bool; N] = std::array::from_fn(|i| i < rotaries);
    for i in (1..N).rev() {
        turns.swap(i, random.below(i + 1));
    }
    let kinds: [_; N] = std::array::from_fn(|i| {
        let carries = [Carries::Tool, Carries::Work][random.below(2)];
        let axis = rounded(random.direction());
        let point = rounded(random.point(300.0));
        let wide = (widened(axis), widened(point));
        if turns[i] {
            (
                Joint::rotary(carries, wide.0, wide.1, 0.0).expect("an axis"),
                Joint::rotary(carries, axis, point, 0.0).expect("an axis"),
            )
        } else {
            (
                Joint::linear(carries, wide.0).expect("an axis"),
                Joint::linear(carries, axis).expect("an axis"),
            )
        }
    });
    let poses = (random.pose(200.0), random.pose(200.0));
    let homes = (
        common::widened_pose(common::rounded_pose(poses.0)),
        common::widened_pose(common::rounded_pose(poses.1)),
    );
    let tool = (rounded(random.point(100.0)), rounded(random.direction()));
    let tool = (widened(tool.0), widened(tool.1));
    let chain = Chain::new(kinds.map(|k| k.0))
        .with_homes(homes.0, homes.1)
        .and_then(|c| c.with_tool(tool.0, tool.1))
        .expect("a chain");
    let chain32 = Chain::new(kinds.map(|k| k.1))
        .with_homes(common::rounded_pose(homes.0), common::rounded_pose(homes.1))
        .and_then(|c| c.with_tool(rounded(tool.0), rounded(tool.1)))
        .expect("a chain");
    // Far from the refusals, where the figures of the specification are meant.
    let linears: Vec<Vector<f64>> = chain
        .joints()
        .iter()
        .filter(|j| j.motion() == Motion::Linear)
        .map(|j| j.twist().v)
        .collect();
    let spread = linears[0].dot(linears[1].cross(linears[2])).abs();
    (spread > 0.3).then_some(())?;
    // Rotaries closer than this to parallel lose direction in f32 in proportion: 1.1e-4 deg at a sine of 0.18.
    let turns: Vec<Vector<f64>> = chain
        .joints()
        .iter()
        .filter(|j| j.motion() == Motion::Rotary)
        .map(|j| j.twist().w)
        .collect();
    if let [m1, m2] = turns[..] {
        (m1.cross(m2).norm() > 0.25).then_some(())?;
    }
    Some((Side::new(chain).ok()?, Side::new(chain32).ok()?))
}

fn random_machines<const N: usize>(
    seed: u64,
    count: usize,
    rotaries: usize,
) -> Vec<(Side<N, f64>, Side<N, f32>)> {
    let mut random = Random(seed);
    let mut machines = Vec::new();
    while machines.len() < count {
        machines.extend(random_side(&mut random, rotaries));
    }
    machines
}

#[test]
fn both_solutions_of_any_two_rotaries_reach_the_tip_and_the_axis() {
    let mut random = Random(20);
    let (mut tip_error, mut axis_error, mut two, mut none) = (0.0_f64, 0.0_f64, 0, 0);
    for (side, _) in random_machines::<5>(21, 100, 2) {
        for _ in 0..100 {
            let (p, o) = (random.point(400.0), random.direction());

            let found = match side.solutions(p, o, &Joints([0.0; 5])) {
                Ok(found) => found,
                // A linear beyond a rotary can fall into the plane of the others.
                Err(SideError::LinearAxesDependent) => continue,
                Err(error) => panic!("seed 20, 21: {error:?}"),
            };

            two += usize::from(found.kind == Kind::Two);
            none += usize::from(found.kind == Kind::None);
            for q in [Some(found.first), found.second].into_iter().flatten() {
                let (tip, axis) = reached(side.chain(), &q);
                // The tip suffers where the linears nearly lie in a plane.
                let size = q.0.iter().fold(1000.0_f64, |m, x| m.max(x.abs()));
                tip_error = tip_error.max((tip - p).norm() / size * 1000.0);
                let off = (axis.angle_to(o) - found.gap).abs();
                axis_error = axis_error.max(off.to_degrees());
            }
        }
    }
    println!(
        "{two} of kind two, {none} out of reach; tip {tip_error:.1e} mm, axis against the gap {axis_error:.1e} deg"
    );
    assert!(two > 3_000 && none > 1_000);
    assert!(tip_error < 1e-9 && axis_error < 1e-9);
}

#[test]
fn the_gap_is_the_least_that_any_angles_leave() {
    let mut random = Random(22);
    for (side, _) in random_machines::<5>(23, 20, 2) {
        let rotaries: Vec<usize> = (0..5)
            .filter(|i| side.chain().joints()[*i].motion() == Motion::Rotary)
            .collect();
        for _ in 0..5 {
            let o = random.direction();
            let Ok(found) = side.solutions(Vector::ZERO, o, &Joints([0.0; 5])) else {
                continue;
            };
            // Brute force over both angles, in steps of 3 deg.
            let mut least = f64::INFINITY;
            for i in 0..120 {
                for j in 0..120 {
                    let mut q = Joints([0.0; 5]);
                    q[rotaries[0]] = f64::from(i) * PI / 60.0;
                    q[rotaries[1]] = f64::from(j) * PI / 60.0;
                    least = least.min(side.forward(&q).1.angle_to(o));
                }
            }
            assert!(
                least >= found.gap - 1e-9,
                "seed 22, 23: {least} under {}",
                found.gap
            );
            assert!(
                least <= found.gap + 0.05,
                "seed 22, 23: {least} over {}",
                found.gap
            );
        }
    }
}

#[test]
fn one_rotary_leaves_the_least_angle_and_none_leaves_all_of_it() {
    let mut random = Random(24);
    for (side, _) in random_machines::<4>(25, 50, 1) {
        let rotary = (0..4)
            .find(|i| side.chain().joints()[*i].motion() == Motion::Rotary)
            .expect("one");
        for _ in 0..20 {
            let (p, o) = (random.point(400.0), random.direction());
            let Ok(found) = side.solutions(p, o, &Joints([0.0; 4])) else {
                continue;
            };
            let (tip, axis) = reached(side.chain(), &found.first);
            let size = found.first.0.iter().fold(1000.0_f64, |m, x| m.max(x.abs()));
            assert!((tip - p).norm() < 1e-12 * size);
            assert!((axis.angle_to(o) - found.gap).abs() < 1e-9);
            assert_eq!((found.kind, found.s, found.second), (Kind::One, None, None));
            let least = (0..3600)
                .map(|i| {
                    let mut q = Joints([0.0; 4]);
                    q[rotary] = f64::from(i) * PI / 1800.0;
                    side.forward(&q).1.angle_to(o)
                })
                .fold(f64::INFINITY, f64::min);
            assert!(least >= found.gap - 1e-9 && least < found.gap + 2e-3);
        }
    }
    for (side, _) in random_machines::<3>(26, 20, 0) {
        let (p, o) = (random.point(400.0), random.direction());
        let found = side.solutions(p, o, &Joints([0.0; 3])).expect("always");
        let (tip, axis) = reached(side.chain(), &found.first);
        assert!((tip - p).norm() < 1e-8);
        assert!((axis.angle_to(o) - found.gap).abs() < 1e-12);
    }
}

#[test]
fn single_precision_keeps_the_accuracy_of_the_specification() {
    // Section 7: 100 000 random poses on 100 random machines, coordinates to 1000 mm.
    let mut random = Random(30);
    let (mut tip, mut direction, mut gap, mut compared) = (0.0_f64, 0.0_f64, 0.0_f64, 0);
    let zero = Joints([0.0_f32; 5]);
    for (side, side32) in random_machines::<5>(31, 100, 2) {
        for _ in 0..1_000 {
            let (p, o) = (rounded(random.point(400.0)), rounded(random.direction()));
            let Ok(found) = side32.solutions(p, o, &zero) else {
                continue;
            };
            let Ok(exact) = side.solutions(widened(p), widened(o), &Joints([0.0; 5])) else {
                continue;
            };
            let least = exact.s.unwrap_or(0.0);
            let clear = least > 1e-3 || exact.gap > 1e-3;
            if clear {
                assert_eq!(found.kind, exact.kind, "seed 30, 31");
                gap = gap.max((f64::from(found.gap) - exact.gap).abs().to_degrees());
            }
            for q in [Some(found.first), found.second].into_iter().flatten() {
                // The same machine, exactly: its f32 numbers in f64.
                let q = Joints(q.0.map(f64::from));
                // Linears near to one plane magnify the rounding of the tip's place; three times is allowed here.
                let spread = [Vector::X, Vector::Y, Vector::Z].iter().all(|axis| {
                    let moved = side.linear_shift(*axis, &q);
                    moved.is_ok_and(|moved| moved.0.iter().all(|x| x.abs() < 3.0))
                });
                if q.0.iter().any(|x| x.abs() > 1000.0) || !spread {
                    continue;
                }
                let (reached_p, reached_o) = side.forward(&q);
                tip = tip.max((reached_p - widened(p)).norm());
                if found.kind != Kind::None {
                    let off = reached_o.angle_to(widened(o)).to_degrees();
                    // Within the snap of the pole and of the border the direction is held back on purpose.
                    if found.kind == Kind::Two {
                        direction = direction.max(off);
                    }
                }
                compared += 1;
            }
        }
    }
    println!(
        "f32, {compared} solutions: tip {tip:.1e} mm, direction {direction:.1e} deg, gap {gap:.1e} deg"
    );
    assert!(compared > 50_000);
    assert!(tip < 1e-3);
    assert!(direction < 1e-4);
    assert!(gap < 1e-4);
}

#[test]
fn single_precision_keeps_the_wall_of_both_reference_machines() {
    let (four, four32) = (
        m4::<f64>().expect("a machine"),
        m4::<f32>().expect("a machine"),
    );
    let (five, five32) = (
        m5::<f64>().expect("a machine"),
        m5::<f32>().expect("a machine"),
    );
    let mut random = Random(32);
    let (mut tip, mut thickness, mut residual) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..20_000 {
        let (p, n) = panel(random.between(-500.0, 500.0), random.between(-375.0, 375.0));
        let n = n + random.point(0.05);
        let (p32, n32) = (rounded(p), rounded(n));
        let n = widened(n32).unit(0.5).expect("about one");
        let p = widened(p32);
        // The wall between the very joints that are sent, measured exactly, and as f32 measures it.
        let wide = |q: &[f32]| q.iter().map(|x| f64::from(*x)).collect::<Vec<_>>();

        let zero = (&Joints([0.0_f32; 4]), &Joints([0.0_f32; 4]));
        let found = four32.solve(p32, n32, 1.5, zero).expect("within reach");
        let exact = four.solve(p, n, 1.5, (&Joints([0.0; 4]), &Joints([0.0; 4])));
        let exact = exact.expect("within reach");
        residual = residual.max(
            (f64::from(found.mill.residual) - exact.mill.residual)
                .abs()
                .to_degrees(),
        );
        let q1 = Joints(std::array::from_fn(|i| wide(&found.mill.q.0)[i]));
        let q2 = Joints(std::array::from_fn(|i| wide(&found.support.q.0)[i]));
        let tips = four.forward(&q1, &q2);
        tip = tip
            .max((tips.p_t - (p + n * 1.5)).norm())
            .max((tips.p_h - p).norm());
        let own = four32
            .forward(&found.mill.q, &found.support.q)
            .wall(Some(n32))
            .expect("n");
        let wall = tips.wall(Some(n)).expect("n");
        thickness = thickness.max((f64::from(own.thickness) - wall.thickness).abs());

        let zero = (&Joints([0.0_f32; 5]), &Joints([0.0_f32; 5]));
        let found = five32.solve(p32, n32, 1.5, zero).expect("within reach");
        let q1 = Joints(std::array::from_fn(|i| wide(&found.mill.q.0)[i]));
        let q2 = Joints(std::array::from_fn(|i| wide(&found.support.q.0)[i]));
        let tips = five.forward(&q1, &q2);
        tip = tip
            .max((tips.p_t - (p + n * 1.5)).norm())
            .max((tips.p_h - p).norm());
        let own = five32
            .forward(&found.mill.q, &found.support.q)
            .wall(Some(n32))
            .expect("n");
        let wall = tips.wall(Some(n)).expect("n");
        thickness = thickness.max((f64::from(own.thickness) - wall.thickness).abs());
        assert!(tips.o_t.angle_to(n).to_degrees() < 1e-4);
    }
    println!(
        "f32, M4 and M5: tip {tip:.1e} mm, thickness {thickness:.1e} mm, residual {residual:.1e} deg"
    );
    assert!(tip < 1e-3 && thickness < 5e-4 && residual < 1e-4);
}

#[test]
fn the_solution_chosen_is_the_one_near_the_joints_before() {
    let side = Side::new(generic_side()).expect("a side");
    let (p, o) = (at(20.0, 30.0, 40.0), at(0.2, 0.1, 0.97));
    let near = |b: f64, a: f64| Joints([0.0, b.to_radians(), 0.0, a.to_radians(), 0.0]);
    let solve = |near| side.inverse(p, o, &near).expect("within reach").q;

    assert!((solve(near(0.0, 0.0))[1].to_degrees() + 11.650299438).abs() < 1e-8);
    assert!((solve(near(150.0, -170.0))[1].to_degrees() - 168.349700562).abs() < 1e-8);
    // A turn further on: the same solution, a turn further on.
    assert!((solve(near(360.0, 360.0))[1].to_degrees() - 348.349700562).abs() < 1e-8);
    let pose = side.chain().forward(&solve(near(0.0, 0.0)));
    let back = Kinematics::inverse(&side, &pose, &near(0.0, 0.0)).expect("within reach");
    assert!((back[4] - 39.838442057).abs() < 1e-8);
}

#[test]
fn travel_decides_between_the_solutions_and_then_refuses_by_name() {
    let (p, o) = (at(20.0, 30.0, 40.0), at(0.2, 0.1, 0.97));
    let limited = |index: usize, range: [f64; 2]| {
        let mut joints = *generic_side().joints();
        joints[index] = joints[index].with_limits(range).expect("a range");
        let side = Side::new(Chain::new(joints)).expect("a side");
        side.inverse(p, o, &Joints([0.0; 5]))
    };

    // B = -11.65 deg is beyond its travel: the far solution is taken, one turn down.
    let found = limited(1, [-6.0, -0.3]).expect("the other solution fits").q;
    assert!((found[1].to_degrees() - (168.349700562 - 360.0)).abs() < 1e-8);
    assert_eq!(
        limited(1, [0.0, 1.0]),
        Err(SideError::OutOfTravel { joint: 1 })
    );
    assert_eq!(
        limited(4, [0.0, 39.0]),
        Err(SideError::OutOfTravel { joint: 4 })
    );
}

#[test]
fn at_the_pole_the_axis_next_to_the_work_is_held() {
    // Table C and a slanted head: v = z leaves C free.
    let joints = [
        Joint::rotary(Carries::Work, Vector::Z, Vector::ZERO, 0.0),
        Joint::linear(Carries::Tool, Vector::X),
        Joint::linear(Carries::Tool, Vector::Y),
        Joint::linear(Carries::Tool, Vector::Z),
        Joint::rotary(Carries::Tool, at(0.0, 1.0, 1.0), at(0.0, 0.0, 350.0), 0.0),
    ]
    .map(|joint| joint.expect("an axis"));
    let side = Side::new(Chain::new(joints)).expect("a side");
    let before = Joints([0.4_f64, 0.0, 0.0, 0.0, 0.2]);

    let found = side
        .inverse(at(50.0, 0.0, 10.0), Vector::Z, &before)
        .expect("the pole");

    assert_eq!(found.kind, Kind::Infinite);
    assert!((found.q[0] - 0.4).abs() < 1e-12 && found.q[4].abs() < 1e-12);
    let (tip, axis) = reached(side.chain(), &found.q);
    assert!((tip - at(50.0, 0.0, 10.0)).norm() < 1e-9 && axis.angle_to(Vector::Z) < 1e-12);
    // Its travel clamps what is held.
    let mut short = joints;
    short[0] = short[0].with_limits([1.0, 2.0]).expect("a range");
    let side = Side::new(Chain::new(short)).expect("a side");
    let found = side
        .inverse(Vector::ZERO, Vector::Z, &before)
        .expect("the pole");
    assert!((found.q[0] - 1.0).abs() < 1e-12);
    // Beyond the band: refused, with the gap and the nearest pose, whose tip is exact.
    let o = at(0.9, 0.3, -0.1);
    let p = at(1.0, 2.0, 3.0);
    let side = Side::new(Chain::new(joints)).expect("a side");
    let Err(SideError::Unreachable { gap, nearest }) = side.inverse(p, o, &before) else {
        panic!("it is 6 deg beyond");
    };
    assert_printed(&[gap.to_degrees()], &[6.017284864]);
    let (tip, axis) = reached(side.chain(), &nearest);
    assert!((tip - p).norm() < 1e-9 && (axis.angle_to(o) - gap).abs() < 1e-9);
}

#[test]
fn a_pole_of_one_rotary_holds_its_angle() {
    let side = Side::new(m4_1::<f64>()).expect("a side");
    let before = Joints([0.0, 0.0, 0.0, 0.3]);

    let found = side
        .inverse(Vector::ZERO, Vector::Y, &before)
        .expect("positions are always reached");

    assert_eq!(found.kind, Kind::Infinite);
    assert_eq!(found.q[3], 0.3);
    assert!((found.residual - PI / 2.0).abs() < 1e-12);
}

#[test]
fn a_rotary_table_shared_by_both_sides_is_set_by_the_mill_and_known_to_the_support() {
    // The panel turns on C under both; the mill tilts by B, the support by its own B and A.
    let slide = |axis| Joint::linear(Carries::Tool, axis).expect("an axis");
    let turn = |carries, axis, point| Joint::rotary(carries, axis, point, 0.0).expect("an axis");
    let table = turn(Carries::Work, at(0.0, 0.3, 1.0), at(30.0, 20.0, 0.0));
    let work = Pose {
        rotation: Rotation::about(Vector::X, 0.1),
        p: at(600.0, 450.0, 0.0),
    };
    let under = Pose {
        rotation: Rotation::about(Vector::Y, PI),
        p: at(590.0, 440.0, 5.0),
    };
    let home = |z: f64, up: f64| Pose {
        rotation: if up > 0.0 {
            Rotation::IDENTITY
        } else {
            Rotation::about(Vector::Y, PI)
        },
        p: at(0.0, 0.0, z),
    };
    let mill = Chain::new([
        table,
        slide(Vector::X),
        slide(Vector::Y),
        slide(Vector::Z),
        turn(Carries::Tool, Vector::Y, at(0.0, 0.0, 450.0)),
    ])
    .with_homes(home(50.0, 1.0), work)
    .expect("poses");
    let support = Chain::new([
        table,
        slide(-Vector::X),
        slide(Vector::Y),
        slide(-Vector::Z),
        turn(Carries::Tool, Vector::Y, at(0.0, 0.0, -490.0)),
        turn(Carries::Tool, Vector::X, at(0.0, 0.0, -430.0)),
    ])
    .with_homes(home(-50.0, -1.0), under)
    .expect("poses");
    let pair = Pair::new(mill, support).expect("a pair");
    let mut random = Random(40);
    let mut solved = 0;
    for _ in 0..500 {
        let p = random.point(200.0);
        let n = at(random.between(-0.4, 0.4), random.between(-0.4, 0.4), 1.0);
        let d = random.between(0.5, 5.0);

        let Ok(found) = pair.solve(p, n, d, (&Joints([0.0; 5]), &Joints([0.0; 6]))) else {
            continue;
        };

        solved += 1;
        let (q1, q2) = (found.mill.q, found.support.q);
        assert_eq!(q2[0], q1[0], "one table, one angle");
        // Both tips by the reference, in the frame that the table carries.
        let [tool1, work1] = reference(&mill, &q1);
        let [tool2, _] = reference(&support, &q2);
        let back = rigid_inverse(&work1);
        let unit = n.unit(0.1).expect("a normal");
        let p_t = through(&times(&back, &tool1), Vector::ZERO, 1.0);
        let p_h = through(&times(&back, &tool2), Vector::ZERO, 1.0);
        let o_t = through(&times(&back, &tool1), Vector::Z, 0.0);
        let o_h = through(&times(&back, &tool2), Vector::Z, 0.0);
        assert!(
            (p_h - p).norm() < 1e-9 && (p_t - p - unit * d).norm() < 1e-9,
            "seed 40"
        );
        assert!(
            o_t.angle_to(unit) < 1e-9 && o_h.angle_to(-unit) < 1e-9,
            "seed 40"
        );
        let wall = pair.forward(&q1, &q2).wall(Some(n)).expect("a normal");
        assert!((wall.thickness - d).abs() < 1e-9 && wall.lateral < 1e-9);
    }
    assert!(solved > 300, "{solved}");

    // A work joint that the mill does not have cannot carry the same panel.
    let lonely = Pair::new(m5_1::<f64>(), support);
    assert_eq!(
        lonely.unwrap_err(),
        PairError::WorkChainsDiffer { joint: 0 }
    );
}

#[test]
fn a_table_that_only_the_mill_lists_moves_the_panel_for_both() {
    // The panel rides on X of the mill; the support stands in the bed.
    let slide = |carries, axis| Joint::linear(carries, axis).expect("an axis");
    let mill = Chain::new([
        slide(Carries::Work, Vector::X),
        slide(Carries::Tool, Vector::Y),
        slide(Carries::Tool, Vector::Z),
    ]);
    let support = Chain::new([
        slide(Carries::Tool, Vector::X),
        slide(Carries::Tool, Vector::Y),
        slide(Carries::Tool, Vector::Z),
    ])
    .with_tool(Vector::ZERO, -Vector::<f64>::Z)
    .expect("an axis");
    let pair = Pair::new(mill, support).expect("a pair");

    let found = pair
        .solve(
            at(10.0, 20.0, 30.0),
            Vector::Z,
            2.0,
            (&Joints([0.0; 3]), &Joints([0.0; 3])),
        )
        .expect("within reach");

    assert_eq!(found.mill.q.0, [-10.0, 20.0, 32.0]);
    assert_eq!(found.support.q.0, [0.0, 20.0, 30.0]);
    let wall = pair
        .forward(&found.mill.q, &found.support.q)
        .wall(None)
        .expect("an axis");
    assert_eq!((wall.thickness, wall.lateral), (2.0, 0.0));
}

#[test]
fn a_shift_of_the_tip_moves_the_linears_alone() {
    // Section 9, trim: delta 0.1 along n at panel(250, 100), both sides.
    let machine = m4::<f64>().expect("a machine");
    let (p, n) = panel(250.0, 100.0);
    let zero = (&Joints([0.0; 4]), &Joints([0.0; 4]));
    let found = machine.solve(p, n, 1.5, zero).expect("within reach");

    // The work frame stands parallel to the bed, so n is its own direction in bed coordinates.
    let mill = machine
        .mill()
        .linear_shift(n * 0.1, &found.mill.q)
        .expect("numbers");
    let support = machine
        .support()
        .linear_shift(n * 0.1, &found.support.q)
        .expect("numbers");

    assert_printed(&mill.0, &[0.00625, 0.0, 0.099804496, 0.0]);
    assert_printed(&support.0, &[-0.00625, 0.0, -0.099804496, 0.0]);
}

#[test]
fn useless_arrangements_are_refused_by_name() {
    let slides = [Vector::X, Vector::Y, Vector::<f64>::Z]
        .map(|axis| Joint::linear(Carries::Tool, axis).expect("an axis"));
    let [x, y, z] = slides;
    let turn = |axis| Joint::rotary(Carries::Tool, axis, Vector::ZERO, 0.0).expect("an axis");
    let (a, b, c) = (turn(Vector::X), turn(Vector::Y), turn(Vector::Z));
    let nearly_a = turn(at(1.0, 0.0, 5e-4));

    let three = Side::new(Chain::new([x, y, z, a, b, c]));
    assert_eq!(three.unwrap_err(), SideError::TooManyRotaries);
    let two = Side::new(Chain::new([x, y, a]));
    assert_eq!(two.unwrap_err(), SideError::NeedThreeLinears);
    let four = Side::new(Chain::new([x, y, z, x]));
    assert_eq!(four.unwrap_err(), SideError::NeedThreeLinears);
    let flat = Side::new(Chain::new([x, y, x]));
    assert_eq!(flat.unwrap_err(), SideError::LinearAxesDependent);
    let parallel = Side::new(Chain::new([x, y, z, a, nearly_a]));
    assert_eq!(parallel.unwrap_err(), SideError::ParallelAxes);
    let along = Side::new(Chain::new([x, y, z, a, c]));
    assert_eq!(along.unwrap_err(), SideError::ToolAlongAxis);
    let alone = Side::new(Chain::new([x, y, z, c]));
    assert_eq!(alone.unwrap_err(), SideError::ToolAlongAxis);
}

#[test]
fn bad_targets_are_refused_by_name_and_neither_side_moves() {
    let machine = m5::<f64>().expect("a machine");
    let zero = (&Joints([0.0; 5]), &Joints([0.0; 5]));
    let solve = |p, n, d| machine.solve(p, n, d, zero).unwrap_err();

    for d in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(solve(Vector::ZERO, Vector::Z, d), PairError::BadWall);
    }
    assert_eq!(
        solve(at(f64::NAN, 0.0, 0.0), Vector::Z, 1.0),
        PairError::NonFinite
    );
    assert_eq!(
        solve(Vector::ZERO, Vector::Z * 1e-7, 1.0),
        PairError::BadNormal
    );
    let far = at(f64::MAX, f64::MAX, f64::MAX);
    let side = Side::new(generic_side()).expect("a side");
    let refused = side.inverse(far, at(0.2, 0.1, 0.97), &Joints([0.0; 5]));
    assert_eq!(refused, Err(SideError::NonFinite));
    let lost = Joints([f64::NAN, 0.0, 0.0, 0.0, 0.0]);
    let refused = machine.solve(Vector::ZERO, Vector::Z, 1.0, (&lost, zero.1));
    assert_eq!(refused.unwrap_err(), PairError::Mill(SideError::NonFinite));
    // The support alone runs out of travel.
    let mut joints = *m4_2::<f64>().joints();
    joints[2] = joints[2].with_limits([-40.0, 0.0]).expect("a range");
    let series = m4_2::<f64>();
    let series = series.series();
    let short = Chain::new(joints)
        .with_homes(series.tool_home, series.work_home)
        .expect("poses");
    let pair = Pair::new(m4_1(), short).expect("a pair");
    let (p, n) = panel(0.0, 100.0);
    let refused = pair.solve(p, n, 1.5, (&Joints([0.0; 4]), &Joints([0.0; 4])));
    assert_eq!(
        refused.unwrap_err(),
        PairError::Support(SideError::OutOfTravel { joint: 2 })
    );
}

#[test]
fn kinds_agree_between_both_precisions_for_the_reference_machines() {
    fn kinds<R: Real>(directions: &[Vector<f64>]) -> Vec<Kind> {
        let side = Side::new(m5_1::<R>()).expect("a side");
        let zero = Joints([R::ZERO; 5]);
        directions
            .iter()
            .map(|o| {
                let o = Vector::new(R::of(o.x), R::of(o.y), R::of(o.z));
                side.solutions(Vector::ZERO, o, &zero).expect("always").kind
            })
            .collect()
    }
    let directions = [
        Vector::Z,
        at(0.2, 0.1, 0.97),
        at(1.0, 0.0, 1.0),
        // Along B, the axis next to the work: the pole.
        Vector::Y,
        -Vector::Y,
        at(1e-3, 1.0, 0.0),
    ];

    let (fine, coarse) = (kinds::<f64>(&directions), kinds::<f32>(&directions));

    assert_eq!(fine, coarse);
    assert_eq!(fine[3], Kind::Infinite);
    assert_eq!(fine[0], Kind::Two);
}
