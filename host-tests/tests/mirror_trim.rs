//! Trimming a pair to a measured deformation: the joints, the stream, the simulated walls.
//!
//! Figures with a section number are those of the mirror-milling specification.

mod common;

use common::Random;
use hexstep::cycles::mirror_trim::{BadLimit, Flags, Parameters, Trimmer};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::chain::{Carries, Chain, Joint};
use hexstep::machines::two_sided::{Pair, PairError, SideError, m4, m5};
use hexstep_host::calc;
use hexstep_host::mirror::{Noise, Simulation, mean, sample_sigma};
use serde_json::{Value, json};

fn at(x: f64, y: f64, z: f64) -> Vector<f64> {
    Vector::new(x, y, z)
}

/// Support-side surface of the panel in w1, section 8: point and normal.
fn panel(x: f64, y: f64) -> (Vector<f64>, Vector<f64>) {
    let height = (4000.0f64 * 4000.0 - x * x).sqrt();
    (
        at(x, y, height - 4000.0),
        at(x, 0.0, height) * (1.0 / 4000.0),
    )
}

#[track_caller]
fn close(found: &[f64], printed: &[f64], digit: f64) {
    assert_eq!(found.len(), printed.len());
    for (a, b) in found.iter().zip(printed) {
        assert!(
            (a - b).abs() <= 0.501 * digit,
            "{found:?}, printed {printed:?}"
        );
    }
}

// ---- the pair, section 9 ----

#[test]
fn a_shift_along_the_normal_gives_the_printed_trims_and_turns_nothing() {
    let machine = m4::<f64>().unwrap();
    let (p, n) = panel(250.0, 100.0);
    let before = (&Joints([0.0; 4]), &Joints([0.0; 4]));
    let found = machine.solve(p, n, 1.5, before).unwrap();

    let trim = machine
        .trim(n, 0.1, (&found.mill.q, &found.support.q))
        .unwrap();

    close(&trim.mill.0, &[0.00625, 0.0, 0.099804496, 0.0], 1e-9);
    close(&trim.support.0, &[-0.00625, 0.0, -0.099804496, 0.0], 1e-9);
}

#[test]
fn a_tilt_gives_the_printed_trims_of_both_sides() {
    let machine = m4::<f64>().unwrap();
    let (p, n) = panel(250.0, 100.0);
    let before = (&Joints([0.0; 4]), &Joints([0.0; 4]));
    let old = machine.solve(p, n, 1.5, before).unwrap();
    let turned = Rotation::about(Vector::Y, 0.0004) * n;

    let new = machine
        .retrim(p, n, 1.5, (0.1, turned), (&old.mill.q, &old.support.q))
        .unwrap();

    let shown = |a: &Joints<4, f64>, b: &Joints<4, f64>| {
        [
            b[0] - a[0],
            b[1] - a[1],
            b[2] - a[2],
            (b[3] - a[3]).to_degrees(),
        ]
    };
    let printed = [0.166534009, 0.0, 0.089734939, 0.022918312];
    close(&shown(&old.mill.q, &new.mill.q), &printed, 1e-9);
    let printed = [0.145450930, 0.0, -0.109334837, 0.022918312];
    close(&shown(&old.support.q, &new.support.q), &printed, 1e-9);
}

/// Both tips go along with the panel, seen by the forward maps, and the direct form is the difference of two solutions.
#[test]
fn the_direct_form_moves_both_tips_with_the_panel() {
    let machine = m5::<f64>().unwrap();
    let mut random = Random(50);
    for _ in 0..300 {
        let (p, _) = panel(random.between(-450.0, 450.0), random.between(-350.0, 350.0));
        let n = at(random.between(-0.2, 0.2), random.between(-0.2, 0.2), 1.0);
        let delta = random.between(-0.4, 0.4);
        let home = (&Joints([0.0; 5]), &Joints([0.0; 5]));
        let old = machine.solve(p, n, 1.5, home).unwrap();
        let (q1, q2) = (old.mill.q, old.support.q);

        let trim = machine.trim(n, delta, (&q1, &q2)).unwrap();

        let shift = n.unit(0.1).unwrap() * delta;
        let moved = machine.forward(&plus(&q1, &trim.mill), &plus(&q2, &trim.support));
        let still = machine.forward(&q1, &q2);
        assert!((moved.p_t - still.p_t - shift).norm() < 1e-11);
        assert!((moved.p_h - still.p_h - shift).norm() < 1e-11);
        assert!((moved.o_t - still.o_t).norm() < 1e-14);
        let again = machine.retrim(p, n, 1.5, (delta, n), (&q1, &q2)).unwrap();
        for i in 0..5 {
            assert!((again.mill.q[i] - q1[i] - trim.mill[i]).abs() < 1e-10);
            assert!((again.support.q[i] - q2[i] - trim.support[i]).abs() < 1e-10);
        }
    }
}

fn plus<const N: usize>(a: &Joints<N, f64>, b: &Joints<N, f64>) -> Joints<N, f64> {
    Joints(std::array::from_fn(|i| a[i] + b[i]))
}

/// The panel lies on a turning table that the mill slides along: what the mill moves the panel by, the support follows.
#[test]
fn a_slide_under_the_panel_carries_the_support_along() {
    let slide = |carries, axis| Joint::linear(carries, axis).unwrap();
    let turn = |carries, axis, z: f64| Joint::rotary(carries, axis, at(0.0, 0.0, z), 0.0).unwrap();
    let table = turn(Carries::Work, at(0.0, 0.3, 1.0), 0.0);
    let under = slide(Carries::Work, at(1.0, 0.2, 0.1));
    let mill = Chain::new([
        table,
        under,
        slide(Carries::Tool, Vector::Y),
        slide(Carries::Tool, Vector::Z),
        turn(Carries::Tool, Vector::Y, 450.0),
    ]);
    let support = Chain::new([
        table,
        under,
        slide(Carries::Tool, Vector::X),
        slide(Carries::Tool, Vector::Y),
        turn(Carries::Tool, Vector::Y, -490.0),
        slide(Carries::Tool, Vector::Z),
    ])
    .with_homes(
        Pose {
            rotation: Rotation::about(Vector::Y, std::f64::consts::PI),
            p: at(0.0, 0.0, -50.0),
        },
        Pose::IDENTITY,
    )
    .unwrap();
    let pair = Pair::new(mill, support).unwrap();
    let mut random = Random(51);
    for _ in 0..300 {
        let q1 = Joints(std::array::from_fn(|_| random.between(-1.0, 1.0)));
        let mut q2 = Joints(std::array::from_fn(|_| random.between(-1.0, 1.0)));
        (q2[0], q2[1]) = (q1[0], q1[1]);
        let n = random.direction();
        let delta = random.between(-0.5, 0.5);

        let trim = pair.trim(n, delta, (&q1, &q2)).unwrap();

        assert_eq!((trim.support[0], trim.support[1]), (0.0, trim.mill[1]));
        let still = pair.forward(&q1, &q2);
        let moved = pair.forward(&plus(&q1, &trim.mill), &plus(&q2, &trim.support));
        assert!((moved.p_t - still.p_t - n * delta).norm() < 1e-11);
        assert!((moved.p_h - still.p_h - n * delta).norm() < 1e-11);
    }
}

#[test]
fn in_single_precision_the_direct_form_is_good_to_a_nanometre() {
    let double = m5::<f64>().unwrap();
    let single = m5::<f32>().unwrap();
    let mut random = Random(52);
    for _ in 0..1000 {
        let q = |random: &mut Random| -> Joints<5, f64> {
            let mut q = [0.0; 5];
            for (i, q) in q.iter_mut().enumerate() {
                let size = if i < 3 { 1000.0 } else { 0.5 };
                *q = f64::from(random.between(-size, size) as f32);
            }
            Joints(q)
        };
        let (q1, q2) = (q(&mut random), q(&mut random));
        let (n, delta) = (random.direction(), random.between(-0.3, 0.3));
        let narrow = |q: &Joints<5, f64>| Joints(q.0.map(|x| x as f32));

        let got = single
            .trim(
                common::rounded(n),
                delta as f32,
                (&narrow(&q1), &narrow(&q2)),
            )
            .unwrap();

        let wanted = double.trim(n, delta, (&q1, &q2)).unwrap();
        let pairs = wanted.mill.0.iter().zip(&got.mill.0);
        for (a, b) in pairs.chain(wanted.support.0.iter().zip(&got.support.0)) {
            assert!((a - f64::from(*b)).abs() < 1e-6, "{a} {b}");
        }
    }
}

#[test]
fn a_trim_beyond_the_travel_moves_neither_side() {
    let limited = |chain: Chain<4, f64>| {
        let mut joints = *chain.joints();
        joints[2] = joints[2].with_limits([-100.0, -50.0]).unwrap();
        let series = chain.series();
        Chain::new(joints)
            .with_homes(series.tool_home, series.work_home)
            .and_then(|c| c.with_tool(series.tip, series.axis))
            .unwrap()
    };
    let machine = m4::<f64>().unwrap();
    let support = *machine.support().chain();
    let pair = Pair::new(limited(*machine.mill().chain()), support).unwrap();
    let q = |z| Joints([600.0, 550.0, z, 0.0]);

    let far = pair.trim(Vector::Z, 0.1, (&q(-50.05), &q(0.0)));
    let bad = [
        pair.trim(Vector::ZERO, 0.1, (&q(-60.0), &q(0.0))),
        pair.trim(Vector::Z, f64::NAN, (&q(-60.0), &q(0.0))),
    ];

    let out = SideError::OutOfTravel { joint: 2 };
    assert_eq!(far.unwrap_err(), PairError::Mill(out));
    assert_eq!(bad[0].unwrap_err(), PairError::BadNormal);
    assert_eq!(bad[1].unwrap_err(), PairError::NonFinite);
    assert!(pair.trim(Vector::Z, 0.1, (&q(-60.0), &q(0.0))).is_ok());
}

// ---- the stream, sections 5 and 9 ----

fn usual() -> Parameters<f64> {
    Parameters {
        dt: 0.01,
        tau: 0.09,
        amount: 0.1,
        rate: 2.0,
        gate: 0.2,
        miss_max: 2,
    }
}

fn narrow(p: &Parameters<f64>) -> Parameters<f32> {
    Parameters {
        dt: p.dt as f32,
        tau: p.tau as f32,
        amount: p.amount as f32,
        rate: p.rate as f32,
        gate: p.gate as f32,
        miss_max: p.miss_max,
    }
}

#[test]
fn the_stream_answers_the_printed_line() {
    let mut trimmer = Trimmer::new(&usual()).unwrap();
    let m = [
        0.05, 0.08, 0.40, 0.10, -1.0, 0.15, 0.20, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25,
        -1.0, -1.0, -1.0, 0.10,
    ];
    let wanted = "0.02 R, 0.04 R, 0.053 O, 0.0577, 0.0577, 0.06693, 0.080237, 0.0972133, \
        .1 A, .1 A, .1 A, .1 A, .1 A, .1 A, .1 A, .1 A, .1 A, .1 AF, .1 AF";

    for (m, wanted) in m.iter().zip(wanted.split(", ")) {
        let (out, flags) = trimmer.tick((*m >= 0.0).then_some(*m));

        let (value, letters) = wanted.split_once(' ').unwrap_or((wanted, ""));
        assert!(
            (out - value.parse::<f64>().unwrap()).abs() < 1e-12,
            "{out} {wanted}"
        );
        let initials: String = flags.names().map(|name| &name[..1]).collect();
        assert_eq!(initials, letters.trim());
    }

    assert!((trimmer.filtered() - 0.169230336).abs() < 0.501e-9);
    assert!(trimmer.is_faulty());
}

/// A sensor that does whatever it likes: silent, stuck, noisy, at full scale, not a number.
fn wild(random: &mut Random) -> Option<f64> {
    match random.below(9) {
        0 => None,
        1 => Some(f64::NAN),
        2 => Some(f64::INFINITY),
        3 => Some(-1e300),
        4 => Some(1e30),
        5 => Some(random.between(-5.0, 5.0)),
        _ => Some(random.between(-0.3, 0.3)),
    }
}

#[test]
fn whatever_the_sensor_does_the_offset_is_bounded_in_amount_and_rate() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let parameters = Parameters {
            tau: random.between(0.001, 1.0),
            amount: random.between(0.01, 0.5),
            rate: random.between(0.1, 20.0),
            gate: random.between(0.05, 2.0),
            miss_max: random.below(50) as u32,
            ..usual()
        };
        let mut double = Trimmer::new(&parameters).unwrap();
        let mut single = Trimmer::new(&narrow(&parameters)).unwrap();
        let (step, step32) = (parameters.rate * 0.01, narrow(&parameters).rate * 0.01);
        let (mut before, mut before32) = (0.0, 0.0);
        let calm = random.below(3) == 0;
        for _ in 0..500 {
            let m = if calm {
                Some(random.between(-0.05, 0.05))
            } else {
                wild(&mut random)
            };

            let (out, _) = double.tick(m);
            let (out32, _) = single.tick(m.map(|m| m as f32));

            assert!(out.abs() <= parameters.amount, "seed {seed}");
            assert!((out - before).abs() <= step * (1.0 + 1e-12), "seed {seed}");
            assert!(out32.abs() <= parameters.amount as f32, "seed {seed}");
            // Beside the step itself half a digit of the sum.
            let digit = f32::EPSILON * parameters.amount as f32;
            assert!((out32 - before32).abs() <= step32 * 1.000_001 + digit);
            (before, before32) = (out, out32);
        }
    }
}

#[test]
fn silence_holds_the_offset_and_the_fault_stays_until_reset() {
    let mut trimmer = Trimmer::new(&usual()).unwrap();
    for _ in 0..10 {
        trimmer.tick(Some(0.05));
    }
    let held = trimmer.out();
    for i in 0..5 {
        let (out, flags) = trimmer.tick(None);
        assert_eq!(out, held);
        assert_eq!(flags.contains(Flags::FAULT), i >= 2, "miss {i}");
    }

    let (after, flags) = trimmer.tick(Some(0.06));

    assert_eq!(after, held);
    assert!(flags.contains(Flags::FAULT) && trimmer.is_faulty());
    trimmer.reset();
    assert_eq!(trimmer, Trimmer::new(&usual()).unwrap());
}

#[test]
fn a_sensor_stuck_at_full_scale_is_an_outlier_and_then_a_fault() {
    let mut trimmer = Trimmer::new(&usual()).unwrap();
    trimmer.tick(Some(0.01));
    let flags: Vec<Vec<&str>> = (0..4)
        .map(|_| trimmer.tick(Some(10.0)).1.names().collect())
        .collect();

    assert_eq!(flags[0], ["Outlier"]);
    assert_eq!(flags[1], ["Outlier"]);
    assert_eq!(flags[2], ["Outlier", "Fault"]);
    assert_eq!(flags[3], ["Outlier", "Fault"]);
    assert_eq!(trimmer.out(), 0.01);
}

#[test]
fn single_precision_follows_double_within_the_table() {
    let mut worst = 0.0f64;
    for seed in 100..130 {
        let mut random = Random(seed);
        let parameters = Parameters {
            tau: random.between(0.01, 1.0),
            amount: 0.3,
            rate: random.between(0.2, 5.0),
            ..usual()
        };
        let mut double = Trimmer::new(&parameters).unwrap();
        let mut single = Trimmer::new(&narrow(&parameters)).unwrap();
        for k in 0..5000 {
            let m = 0.2 * (f64::from(k) * 0.003).sin() + random.between(-0.05, 0.05);
            let m = m as f32;

            let (a, _) = double.tick(Some(m.into()));
            let (b, _) = single.tick(Some(m));

            worst = worst.max((a - f64::from(b)).abs());
        }
    }
    assert!(worst < 1e-7, "{worst}");
}

/// Section 5: noise passes with sigma sqrt(a / (2 - a)).
#[test]
fn noise_passes_by_the_root_of_a_over_two_less_a() {
    for tau in [0.05, 0.2, 1.0] {
        let parameters = Parameters {
            tau,
            amount: 10.0,
            rate: 1e3,
            gate: 10.0,
            ..usual()
        };
        let mut trimmer = Trimmer::new(&parameters).unwrap();
        let mut noise = Noise::new(7);
        let settled = (10.0 * tau / 0.01) as usize;
        let out: Vec<f64> = (0..200_000)
            .map(|_| trimmer.tick(Some(0.03 * noise.gauss())).0)
            .skip(settled)
            .collect();

        let a = 0.01 / (tau + 0.01);
        let wanted = 0.03 * (a / (2.0 - a)).sqrt();
        // Of 200 000 correlated values some 1000 count at the slowest: 3 %.
        assert!((sample_sigma(&out) / wanted - 1.0).abs() < 0.1, "tau {tau}");
    }
}

/// Section 5: the lag costs tau times the slope in time.
#[test]
fn the_lag_behind_a_ramp_is_tau_times_its_slope() {
    let parameters = Parameters {
        tau: 0.2,
        amount: 10.0,
        ..usual()
    };
    let mut trimmer = Trimmer::new(&parameters).unwrap();
    let slope = 0.05;
    let (mut m, mut out) = (0.0, 0.0);
    for k in 0..2000 {
        m = slope * 0.01 * f64::from(k);
        (out, _) = trimmer.tick(Some(m));
    }

    assert!((m - out - 0.2 * slope).abs() < 1e-9, "{}", m - out);
}

#[test]
fn parameters_that_are_no_limits_are_refused_by_name() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let p = usual();
        let cases = [
            ("dt", Parameters { dt: bad, ..p }),
            ("tau", Parameters { tau: bad, ..p }),
            ("amount", Parameters { amount: bad, ..p }),
            ("rate", Parameters { rate: bad, ..p }),
            ("gate", Parameters { gate: bad, ..p }),
        ];
        for (name, parameters) in cases {
            assert_eq!(Trimmer::new(&parameters).unwrap_err(), BadLimit(name));
        }
    }
}

// ---- the simulation, section 10 ----

#[test]
fn the_noise_is_the_printed_one() {
    let mut noise = Noise::new(1);
    assert_eq!(
        [noise.word(), noise.word(), noise.word()],
        [0x910a2dec89025cc1, 0xbeeb8da1658eec67, 0xf893a2eefb32555e]
    );
    let mut noise = Noise::new(1);
    let first = [noise.gauss(), noise.gauss(), noise.gauss()];
    close(&first, &[1.424348091, -0.618904260, -0.590766757], 1e-9);
}

#[test]
fn seed_1_gives_the_printed_table() {
    let outcome = Simulation::default().run().unwrap();

    let rows =
        |rows: &hexstep_host::mirror::Summary| [rows.mean(), rows.sigma(), rows.min(), rows.max()];
    let (without, with) = (&outcome.untrimmed, &outcome.trimmed);
    close(
        &rows(&without.rows),
        &[1.417974, 0.034612, 1.350000, 1.484299],
        1e-6,
    );
    close(
        &rows(&with.rows),
        &[1.500156, 0.004722, 1.484482, 1.518218],
        1e-6,
    );
    close(
        &[without.rows.within(), with.rows.within()],
        &[0.759883, 1.0],
        1e-6,
    );
    let points = [
        1.44100, 1.39963, 1.44100, 1.41183, 1.35000, 1.41183, 1.44100, 1.39963, 1.44100,
    ];
    close(&without.points, &points, 1e-5);
    let points = [
        1.49683, 1.50202, 1.49769, 1.50013, 1.49284, 1.50061, 1.50494, 1.49549, 1.50020,
    ];
    close(&with.points, &points, 1e-5);
    let spread = [mean(&without.points), sample_sigma(&without.points)];
    close(&spread, &[1.415216, 0.030459], 1e-6);
    let spread = [mean(&with.points), sample_sigma(&with.points)];
    close(&spread, &[1.498972, 0.003649], 1e-6);
    let good = |walls: &[f64]| walls.iter().filter(|w| (*w - 1.5).abs() <= 0.1).count();
    assert_eq!((good(&without.points), good(&with.points)), (6, 9));
    // "0.006 as gauged", section 11.
    let gauged = sample_sigma(&with.gauged);
    assert!((0.005..0.007).contains(&gauged), "{gauged}");
}

#[test]
fn other_seeds_give_the_printed_spreads() {
    for (seed, sigma) in [(2, 0.004769), (3, 0.004717), (4, 0.004709)] {
        let simulation = Simulation {
            seed,
            ..Simulation::default()
        };

        let outcome = simulation.run().unwrap();

        close(&[outcome.trimmed.rows.sigma()], &[sigma], 1e-6);
    }
}

#[test]
fn the_spread_has_its_least_near_a_second_of_filter_time() {
    let table = [
        (0.05, 0.00854),
        (0.1, 0.00654),
        (0.2, 0.00474),
        (0.5, 0.00312),
        (1.0, 0.00257),
        (2.0, 0.00313),
    ];
    for (tau, printed) in table {
        let sigmas: Vec<f64> = (1..=3)
            .map(|seed| {
                let simulation = Simulation {
                    seed,
                    tau,
                    ..Simulation::default()
                };
                simulation.run().unwrap().trimmed.rows.sigma()
            })
            .collect();
        close(&[mean(&sigmas)], &[printed], 1e-5);
    }
}

/// The walls of the simulation, seen tick by tick, keep to what the trimmer promises.
#[test]
fn every_tick_of_the_simulation_is_bounded_and_adds_up() {
    let simulation = Simulation::default();
    let mut ticks = 0;
    simulation
        .watch(|_, tick| {
            assert!(tick.out.abs() <= 0.3);
            assert!((tick.trimmed - tick.untrimmed - tick.out).abs() < 1e-15);
            ticks += 1;
        })
        .unwrap();

    assert_eq!(ticks, 3 * 18_001);
}

// ---- refusals, section 6 ----

fn ask(call: &str, request: &Value) -> (u8, Value) {
    let mut output = Vec::new();
    let status = calc::main(call, "f64", request.to_string().as_bytes(), &mut output).unwrap();
    (status, serde_json::from_slice(&output).unwrap())
}

#[track_caller]
fn refused(call: &str, base: &Value, changes: Value, error: &str, field: &str) {
    let mut request = base.clone();
    for (name, value) in changes.as_object().unwrap() {
        request[name] = value.clone();
    }
    let (status, answer) = ask(call, &request);

    assert_eq!(status, 2, "{request}");
    assert_eq!(answer["error"], error, "{request}: {answer}");
    assert_eq!(answer["field"], field, "{request}: {answer}");
    assert!(answer["detail"].as_str().unwrap().len() > 15, "{answer}");
}

#[test]
fn a_bad_trim_is_refused_by_name() {
    let base = json!({"machine": "m5", "p": [100, 50, -2], "n": [0.1, 0.05, 0.99], "d": 1.5, "delta": 0.1});
    let rows = [
        (json!({"d": 0}), "BadWall", "d"),
        (json!({"d": "nan"}), "BadWall", "d"),
        (json!({"delta": "inf"}), "NonFinite", "delta"),
        (json!({"p": [0, "nan", 0]}), "NonFinite", "p"),
        (json!({"n": [0, 0, 0]}), "BadNormal", "n"),
        (json!({"n_new": [0, 0, 1e-7]}), "BadNormal", "n_new"),
        (json!({"n_new": [0, 0, "inf"]}), "NonFinite", "n_new"),
        (json!({"n_max": 0}), "UnknownField", "n_max"),
    ];
    for (changes, error, field) in rows {
        refused("mirror.trim", &base, changes, error, field);
    }
}

#[test]
fn a_bad_stream_is_refused_by_name() {
    let base = json!({"dt": 0.01, "tau": 0.09, "amount": 0.1, "rate": 2, "gate": 0.2, "miss_max": 2, "m": [0]});
    for field in ["dt", "tau", "amount", "rate", "gate"] {
        for bad in [json!(0), json!(-1), json!("nan"), json!("inf")] {
            refused(
                "mirror.stream",
                &base,
                json!({field: bad}),
                "BadLimit",
                field,
            );
        }
    }
    refused(
        "mirror.stream",
        &base,
        json!({"miss_max": -1}),
        "BadLimit",
        "miss_max",
    );
    refused(
        "mirror.stream",
        &base,
        json!({"miss_max": 0.5}),
        "WrongType",
        "miss_max",
    );
    refused(
        "mirror.stream",
        &base,
        json!({"m": ["silence"]}),
        "WrongType",
        "m",
    );
}

#[test]
fn a_bad_simulation_is_refused_by_name() {
    let rows = [
        (json!({"d": -1}), "BadWall", "d"),
        (json!({"tau": 0}), "BadLimit", "tau"),
        (json!({"dt": 0}), "BadLimit", "dt"),
        (json!({"feed": 0}), "BadLimit", "feed"),
        (json!({"rate": "nan"}), "BadLimit", "rate"),
        (json!({"seed": -1}), "BadLimit", "seed"),
        (json!({"dt": 1e-9}), "BadLimit", "dt"),
        (json!({"dt": 10}), "BadLimit", "dt"),
        (json!({"force": "inf"}), "NonFinite", "force"),
        (json!({"noise": "nan"}), "NonFinite", "noise"),
    ];
    for (changes, error, field) in rows {
        refused("mirror.simulate", &json!({}), changes, error, field);
    }
    for large in [
        json!({"peak": 1e308}),
        json!({"d": 1e308}),
        json!({"gauge": 1e308}),
    ] {
        let (status, answer) = ask("mirror.simulate", &large);
        assert_eq!(
            (status, &answer["error"]),
            (2, &json!("OutOfRange")),
            "{large}"
        );
    }
}
