//! Input shaping: weights against the formulas' own zeros, the integer filter against its weights, and machines with a
//! simulated flexible joint behind a motor, judged by their pulses.

mod common;

use common::Random;
use fixed::types::I32F32;
use hexstep::joints::whole_steps;
use hexstep::protocol::report::State;
use hexstep::shaper::design::{Kind, Mode};
use hexstep::shaper::{Design, HISTORY, Refusal, Shaper, Wish};
use hexstep_host::calc;
use hexstep_host::flexible::{Flexible, Swing};
use hexstep_host::job::{Job, JobError, Task};
use hexstep_host::machine::{self, Machine};
use hexstep_host::report::PathFigures;
use hexstep_host::run;
use hexstep_host::trace::Trace;

/// Ticks in a millisecond, at least.
const MS: u64 = 40;
const FASTEST: [f32; 6] = [200_000.0; 6];

fn wish(kind: Kind, hz: f32, damping: f32) -> Wish {
    Wish {
        kind,
        first: Mode { hz, damping },
        second: None,
    }
}

fn shaper(wishes: [Wish; 6]) -> Shaper<6> {
    let mut shaper = Shaper::new();
    shaper.set(Design::new(&wishes, &FASTEST).expect("it fits"));
    shaper
}

/// What a unit step of `height` steps in all joints becomes, until it has settled.
fn response(wishes: [Wish; 6], height: I32F32) -> Vec<[f64; 6]> {
    let mut shaper = shaper(wishes);
    let mut rows = Vec::new();
    loop {
        let row = shaper.push(&[height; 6]);
        rows.push(row.map(|p| p.to_num::<f64>() / height.to_num::<f64>()));
        if shaper.is_settled() {
            assert_eq!(row, [height; 6], "exact at the end");
            return rows;
        }
    }
}

/// Amplitude that a step response, one sample a millisecond, leaves of a vibration when it has ended, over that of a bare
/// step when it is made: V of the papers.
fn residual(response: &[f64], hz: f64, damping: f64) -> f64 {
    let (mut shaped, mut bare) = (Flexible::new(hz, damping), Flexible::new(hz, damping));
    bare.step(1.0);
    let mut before = 0.0;
    for at in response {
        shaped.swing(1e-3);
        shaped.step(at - before);
        before = *at;
    }
    shaped.amplitude() / bare.amplitude()
}

fn one(kind: Kind, hz: f64, damping: f64) -> Vec<f64> {
    let wishes = [wish(kind, hz as f32, damping as f32); 6];
    let rows = response(wishes, I32F32::from_num(100));
    rows.iter().map(|row| row[0]).collect()
}

#[test]
fn what_a_shaper_leaves_of_its_vibration_is_what_the_papers_say_whatever_the_period_in_samples() {
    let (mut worst, mut worst_ei) = (0.0f64, 0.0f64);
    for tenth in (140..4000).step_by(37) {
        for damping in [0.0, 0.02, 0.1, 0.25] {
            let hz = f64::from(tenth) / 10.0;
            worst = worst.max(residual(&one(Kind::Zv, hz, damping), hz, damping));
            worst = worst.max(residual(&one(Kind::Zvd, hz, damping), hz, damping));
            worst_ei = worst_ei.max(residual(&one(Kind::Ei, hz, damping), hz, damping));
        }
    }
    println!("at the frequency: ZV, ZVD {worst:.1e}, EI {worst_ei:.4}");
    // Positions of the ring are 2^-17 of a step here, of 100.
    assert!(worst < 2e-6, "{worst}");
    assert!(worst_ei < 0.051, "{worst_ei}");
}

#[test]
fn linear_interpolation_would_leave_ten_times_more_at_a_hundred_hertz() {
    // 103 Hz: half a period is 4.854 ms.
    let hz = 103.0f64;
    let half = 500.0 / hz;
    let x = half.fract();
    let mut linear = vec![0.5; half as usize];
    linear.push(0.5 + 0.5 * (1.0 - x));
    linear.push(1.0);

    let (linear, ours) = (
        residual(&linear, hz, 0.0),
        residual(&one(Kind::Zv, hz, 0.0), hz, 0.0),
    );
    assert!(linear > 0.01, "{linear}");
    assert!(ours < 1e-6, "{ours}");
}

#[test]
fn beside_the_frequency_zvd_and_ei_leave_less_than_zv() {
    for damping in [0.0, 0.05] {
        for (share, zv, zvd, ei) in [(0.85, 0.26, 0.066, 0.045), (1.15, 0.26, 0.066, 0.045)] {
            let hz = 25.0;
            let at = |kind| residual(&one(kind, hz, damping), hz * share, damping);
            let [a, b, c] = [Kind::Zv, Kind::Zvd, Kind::Ei].map(at);
            println!("damping {damping}, {share} of 25 Hz: ZV {a:.4}, ZVD {b:.4}, EI {c:.4}");
            assert!(a < zv && b < zvd && c < ei);
            assert!(a > 3.0 * b && b > c);
        }
    }
}

#[test]
fn two_vibrations_are_both_gone() {
    let two = Wish {
        kind: Kind::Zvd,
        first: Mode {
            hz: 25.0,
            damping: 0.03,
        },
        second: Some(Mode {
            hz: 61.0,
            damping: 0.01,
        }),
    };
    let rows = response([two; 6], I32F32::from_num(100));
    let response: Vec<f64> = rows.iter().map(|row| row[0]).collect();

    for (hz, damping) in [(25.0, 0.03), (61.0, 0.01)] {
        let left = residual(&response, hz, damping);
        assert!(left < 3e-6, "{hz} Hz: {left}");
    }
    assert!(residual(&response, 25.0 * 1.15, 0.03) < 0.07);
}

#[test]
fn joints_stay_in_step_whatever_shapes_them() {
    let mut wishes = [Wish::default(); 6];
    wishes[0] = wish(Kind::Zvd, 25.3, 0.05);
    wishes[1] = wish(Kind::Zv, 31.7, 0.2);
    wishes[2] = wish(Kind::Ei, 44.4, 0.1);
    wishes[3] = Wish {
        second: Some(Mode {
            hz: 77.7,
            damping: 0.02,
        }),
        ..wish(Kind::Zv, 55.5, 0.0)
    };
    let mut shaper = shaper(wishes);

    // Even speed: all lag by the same.
    let mut last = [I32F32::ZERO; 6];
    for ms in 1..200 {
        last = shaper.push(&[I32F32::from_num(20 * ms); 6]);
    }
    let spread = last.iter().max().expect("six") - *last.iter().min().expect("six");
    let lag = 20.0 * 199.0 - last[4].to_num::<f64>();
    println!(
        "lag {:.3} ms, spread {:.1e} steps",
        lag / 20.0,
        spread.to_num::<f64>()
    );
    // Weights are rounded to f32 and 2^-30, a ring's position to 2^-16 step.
    assert!(spread < I32F32::from_num(0.001), "{last:?}");
    assert!(
        (lag / 20.0 - 18.22).abs() < 0.5,
        "about half a period: {lag}"
    );
}

#[test]
fn off_gives_back_the_very_sample() {
    let mut shaper = Shaper::<6>::new();
    let mut random = Random(5);
    for _ in 0..1000 {
        let at = std::array::from_fn(|_| I32F32::from_bits(random.word() as i64 >> 8));
        assert_eq!(shaper.push(&at), at);
        assert!(shaper.is_settled());
    }
}

#[test]
fn the_end_is_exact_after_any_command_with_any_rest_in_between() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let kinds = [Kind::Off, Kind::Zv, Kind::Zvd, Kind::Ei];
        let wishes = std::array::from_fn(|_| Wish {
            kind: kinds[random.below(4)],
            first: Mode {
                hz: random.between(26.0, 300.0) as f32,
                damping: random.between(0.0, 0.3) as f32,
            },
            second: (random.below(2) == 0).then_some(Mode {
                hz: random.between(40.0, 300.0) as f32,
                damping: random.between(0.0, 0.3) as f32,
            }),
        });
        let mut shaper = shaper(wishes);
        let mut at = [I32F32::from_num(random.whole(1 << 29)); 6];
        shaper.begin_at(&at);
        let (mut low, mut high) = (at, at);
        for _ in 0..5 {
            // What the ring still holds of the way before counts as well.
            for _ in 0..random.below(200) {
                let by = I32F32::from_bits(random.whole(200 << 32) - (100 << 32));
                at = at.map(|p| p + by);
                low = std::array::from_fn(|i| low[i].min(at[i]));
                high = std::array::from_fn(|i| high[i].max(at[i]));
                let out = shaper.push(&at);
                // A mean of positions with positive weights; the ring rounds to a 2^-14 of a step.
                let slack = I32F32::from_bits(1 << 18);
                let within = (0..6).all(|i| out[i] >= low[i] - slack && out[i] <= high[i] + slack);
                assert!(within, "seed {seed}");
            }
            // Half of the rests are too short to settle in.
            let mut out = at;
            for _ in 0..random.below(400) {
                out = shaper.push(&at);
            }
            while !shaper.is_settled() {
                out = shaper.push(&at);
            }
            assert_eq!(out, at, "seed {seed}");
        }
    }
}

#[test]
fn what_no_shaper_can_be_is_refused_by_name() {
    let design = |w: Wish| Design::new(&[Wish::default(), w, Wish::default(), w, w, w], &FASTEST);
    let reason = |w| {
        design(w)
            .map(|_| ())
            .map_err(|r: Refusal| (r.joint, r.reason.name()))
    };

    for hz in [0.0, -25.0, 500.0, 499.5, f32::NAN, f32::INFINITY, -0.0] {
        let refused = reason(wish(Kind::Zv, hz, 0.0));
        assert_eq!(refused, Err((1, "ShaperFrequency")), "{hz}");
    }
    for damping in [-0.01, 0.91, 1.0, f32::NAN, f32::INFINITY] {
        let refused = reason(wish(Kind::Zvd, 25.0, damping));
        assert_eq!(refused, Err((1, "ShaperDamping")), "{damping}");
    }
    assert_eq!(
        reason(wish(Kind::Ei, 25.0, 0.31)),
        Err((1, "ShaperDamping"))
    );
    assert_eq!(reason(wish(Kind::Zv, 1e-9, 0.0)), Err((1, "ShaperTooLong")));
    assert_eq!(reason(wish(Kind::Zvd, 3.9, 0.0)), Err((1, "ShaperTooLong")));
    for kind in [Kind::Zv, Kind::Zvd] {
        assert!(design(wish(kind, 499.0, 0.9)).is_ok());
    }
    let second = Wish {
        second: Some(Mode {
            hz: 5.0,
            damping: 0.0,
        }),
        ..wish(Kind::Zvd, 30.0, 0.0)
    };
    assert_eq!(reason(second), Err((1, "ShaperTooLong")));
}

#[test]
fn the_lowest_frequencies_are_those_of_the_page() {
    let all = |kind, hz| Design::new(&[wish(kind, hz, 0.0); 6], &FASTEST).is_ok();
    let single = |kind, hz| {
        let mut wishes = [Wish::default(); 6];
        wishes[2] = wish(kind, hz, 0.0);
        Design::new(&wishes, &FASTEST).is_ok()
    };
    assert_eq!(HISTORY, 80);
    for (kind, all_from, one_from) in [
        (Kind::Zvd, 12.9, 7.5),
        (Kind::Ei, 12.9, 7.5),
        (Kind::Zv, 6.4, 3.8),
    ] {
        assert!(all(kind, all_from) && !all(kind, 0.97 * all_from));
        assert!(single(kind, one_from) && !single(kind, 0.97 * one_from));
    }
}

// ---- machines ----

/// A motor that is up to speed within 20 ms, half a period of 25 Hz: as bad for a joint of 25 Hz as can be.
const FAST: [&str; 4] = ["$110=3000", "$800=10000000", "$120=2500", "$1003=0"];

fn ask(m: &mut Machine<'_>, lines: &[&str]) {
    for line in lines {
        assert_eq!(m.ask(line), "ok\r\n", "{line}");
    }
}

fn ready(m: &mut Machine<'_>, lines: &[&str]) {
    m.run(10);
    m.heard();
    ask(m, &FAST);
    ask(m, lines);
    m.take_trace();
}

/// The pulses of 3 mm there, at 50 mm/s, with these settings.
fn fast_move(lines: &[&str]) -> Trace<6> {
    machine::with(|m| {
        ready(m, lines);
        m.say("$MOVE=3000,0,0,0,0,0,0");
        m.say("$MOVE=END");
        m.run_to_rest();
        m.run(3);
        assert_eq!(m.controller.counts(), [3000, 0, 0, 0, 0, 0]);
        assert_eq!(m.starved(), 0);
        m.take_trace()
    })
}

fn left(trace: &Trace<6>, hz: f64, damping: f64) -> f64 {
    Swing::of(trace, 0, 1000.0, Flexible::new(hz, damping), 0.1).residual
}

#[test]
fn a_flexible_joint_of_25_hertz_comes_to_rest_behind_a_fast_move() {
    let bare = fast_move(&[]);
    for (name, lines, at, beside) in [
        ("ZV", &["$1200=1"][..], 0.05, 0.30),
        ("ZVD", &["$1200=2"], 0.05, 0.15),
        ("EI", &["$1200=3"], 0.055, 0.15),
        ("ZVD 25, 60", &["$1230=60", "$1200=2"], 0.05, 0.15),
    ] {
        let shaped = fast_move(lines);
        let share = |hz: f64| left(&shaped, hz, 0.0) / left(&bare, hz, 0.0);
        let [low, mid, high] = [0.85 * 25.0, 25.0, 1.15 * 25.0].map(share);
        println!(
            "{name}: unshaped {:.3} {:.3} {:.3} mm, left {:.2} %, {:.2} %, {:.2} %",
            left(&bare, 21.25, 0.0),
            left(&bare, 25.0, 0.0),
            left(&bare, 28.75, 0.0),
            100.0 * low,
            100.0 * mid,
            100.0 * high
        );
        assert!(left(&bare, 25.0, 0.0) > 0.1, "the bare move shakes");
        assert!(mid <= at, "{name}: {mid}");
        assert!(low <= beside && high <= beside, "{name}: {low}, {high}");
    }
}

#[test]
fn a_damped_joint_and_a_second_vibration_come_to_rest_as_well() {
    let bare = fast_move(&[]);
    let damped = fast_move(&["$1220=0.1", "$1200=2"]);
    assert!(left(&damped, 25.0, 0.1) < 0.05 * left(&bare, 25.0, 0.1));

    let two = fast_move(&["$1210=25", "$1230=60", "$1240=0.02", "$1200=1"]);
    for (hz, damping) in [(25.0, 0.0), (60.0, 0.02)] {
        let share = left(&two, hz, damping) / left(&bare, hz, damping);
        println!(
            "{hz} Hz: unshaped {:.4} mm, left {:.2} %",
            left(&bare, hz, damping),
            100.0 * share
        );
        assert!(share < 0.05, "{hz} Hz: {share}");
    }
}

/// ZVD at 25 Hz on X, ZV at 40 Hz on Y, EI with two vibrations on A, the others delayed.
const SHAPED: [&str; 6] = [
    "$1200=2", "$1211=40", "$1201=1", "$1213=40", "$1233=80", "$1203=3",
];

fn move_lines(targets: &[[i32; 6]], seconds: f32) -> String {
    let mut text = String::new();
    for target in targets {
        let words: Vec<String> = target.iter().map(i32::to_string).collect();
        text += &format!("$MOVE={},{seconds}\n", words.join(","));
    }
    text
}

#[test]
fn every_count_is_kept_after_random_programs_with_holds_overrides_and_stops() {
    for seed in 0..40 {
        let mut random = Random(0x5ae + seed);
        machine::with(|m| {
            ready(m, &SHAPED);
            m.say("$1003=0.02");
            m.run_to_rest();
            m.heard();
            for _ in 0..3 {
                let targets: Vec<[i32; 6]> = (0..1 + random.below(12))
                    .map(|_| std::array::from_fn(|_| random.whole(12_000) as i32 - 6000))
                    .collect();
                let stops = random.below(3) == 0;
                m.put(move_lines(&targets, 0.2).as_bytes());
                m.say("$MOVE=END");
                for _ in 0..random.below(6) {
                    m.run(MS * random.below(200) as u64);
                    match random.below(4) {
                        0 => m.put(&[0x91]),
                        1 => m.put(&[0x92]),
                        2 => m.put(&[0x90]),
                        _ => {
                            m.put(b"!");
                            m.run(MS * random.below(150) as u64);
                            m.put(b"~");
                        }
                    }
                }
                if stops {
                    m.controller.stop_motion();
                }
                m.put(b"~");
                m.run_to_rest();
                m.run(3);

                assert_eq!(m.controller.state(), State::Idle, "seed {seed}");
                let end = m.controller.planner().end_steps();
                assert_eq!(m.controller.counts(), end, "seed {seed}");
                assert_eq!(m.trace.positions(), end.map(i64::from), "seed {seed}");
                let rests = m.controller.planner().position();
                assert_eq!(whole_steps(&rests), end, "seed {seed}");
                assert!(stops || rests == end.map(I32F32::from_num), "seed {seed}");
                if !stops {
                    assert_eq!(Some(&end), targets.last(), "seed {seed}");
                }
                assert_eq!(m.starved(), 0, "seed {seed}");
            }
        });
    }
}

#[test]
fn a_hold_rests_on_the_path_with_nothing_on_its_way_and_goes_on_to_the_end() {
    machine::with(|m| {
        ready(m, &SHAPED);
        m.put(move_lines(&[[9000, 4000, -3000, 2000, 1000, 500]], 0.5).as_bytes());
        m.say("$MOVE=END");
        m.run(MS * 250);
        m.put(b"!");
        m.run(MS * 5);
        assert_eq!(m.controller.state(), State::Hold { moving: true });
        m.run_to_rest();
        assert_eq!(m.controller.state(), State::Hold { moving: false });
        let (held, on_path) = (m.trace.positions(), m.controller.planner().position());
        for (count, wanted) in held.iter().zip(on_path) {
            assert!((*count as f64 - wanted.to_num::<f64>()).abs() <= 0.51);
        }

        // A reset there is one at rest: the position is kept.
        m.put(&[0x18]);
        m.run_to_rest();
        m.run(MS);
        assert_eq!(m.controller.state(), State::Idle);
        assert_eq!(m.controller.counts().map(i64::from), m.trace.positions());

        m.put(move_lines(&[[0; 6]], 0.2).as_bytes());
        m.say("$MOVE=END");
        m.run_to_rest();
        assert_eq!(m.controller.counts(), [0; 6]);
    });
}

#[test]
fn a_reset_while_the_shaper_still_gives_is_one_in_motion() {
    machine::with(|m| {
        ready(m, &["$1210=13", "$1200=2"]);
        m.say("$MOVE=500,0,0,0,0,0");
        m.say("$MOVE=END");
        while !m.controller.planner().is_idle() || m.controller.counts()[0] == 0 {
            m.step();
        }
        m.heard();
        assert_eq!(m.controller.state(), State::Run);
        m.run_to_rest();
        assert_eq!(m.controller.counts()[0], 500);

        m.say("$MOVE=0,0,0,0,0,0");
        m.say("$MOVE=END");
        m.run(MS * 60);
        while !m.controller.planner().is_idle() {
            m.step();
        }
        m.put(&[0x18]);
        m.run_to_rest();
        assert_eq!(m.controller.state(), State::Alarm);
        let stopped = m.controller.counts();
        assert_eq!(stopped.map(i64::from), m.trace.positions());
        assert_ne!(stopped[0], 0);
        m.heard();
        assert!(m.ask("$X").ends_with("ok\r\n"));

        // From where it stopped, with nothing of what was under way.
        m.say("$MOVE=1000,0,0,0,0,0");
        m.say("$MOVE=END");
        m.run_to_rest();
        assert_eq!(m.controller.counts()[0], 1000);
        assert_eq!(m.starved(), 0);
    });
}

#[test]
fn a_jog_that_is_cancelled_and_lines_of_counts_end_where_they_say() {
    use hexstep::path::Target;
    machine::with(|m| {
        ready(m, &SHAPED);
        let jog = Target::whole([20_000, 5000, 0, 0, 0, 0], 0.0);
        assert_eq!(m.controller.jog(&jog), Ok(true));
        m.run(MS * 150);
        m.put(&[0x85]);
        m.run_to_rest();
        assert_eq!(m.controller.state(), State::Idle);
        let end = m.controller.planner().end_steps();
        assert_eq!(m.controller.counts(), end);
        assert!(end[0] < 20_000);

        // A line of counts runs as the rule says, shaped or not.
        let shaped = m.take_trace();
        drop(shaped);
        ask(m, &["$SEG=700,300,-500,100,0,200,0.5"]);
        let with = m.take_trace();
        ask(
            m,
            &[
                "$1200=0",
                "$1201=0",
                "$1203=0",
                "$SEG=700,300,-500,100,0,200,0.5",
            ],
        );
        let without = m.take_trace();
        let steps = |t: &Trace<6>| {
            t.pulses()
                .map(|p| (p.motors, p.backward))
                .collect::<Vec<_>>()
        };
        assert_eq!(steps(&with), steps(&without));
    });
}

#[test]
fn with_shaping_off_again_not_one_pulse_is_changed() {
    let run = |lines: &[&str]| {
        machine::with(|m| {
            ready(m, lines);
            m.say("$MOVE=3000,1000,-500,200,0,77,0.3");
            m.say("$MOVE=0,1000,-500,200,50,0,0.3");
            m.say("$MOVE=END");
            m.run_to_rest();
            let pulses: Vec<_> = m.trace.pulses().map(|p| (p.time, p.motors)).collect();
            let first = pulses[0].0;
            pulses
                .into_iter()
                .map(|(t, motors)| (t - first, motors))
                .collect::<Vec<_>>()
        })
    };
    let never = run(&["$1210=30", "$1220=0.1", "$1230=50"]);
    let off = run(&["$1210=30", "$1200=2", "$1200=0"]);
    let on = run(&["$1210=30", "$1200=2"]);
    assert_eq!(never, off);
    assert_ne!(never, on);
}

#[test]
fn settings_that_are_no_shaper_are_refused_by_name_and_change_nothing() {
    machine::with(|m| {
        ready(m, &[]);
        for (line, name, error) in [
            ("$1200=4", "ShaperType X", 52),
            ("$1201=1.5", "ShaperType Y", 52),
            ("$1200=-1", "ShaperType X", 4),
            ("$1210=0", "ShaperFrequency X", 0),
            ("$1210=-25", "ShaperFrequency X", 4),
            ("$1212=500", "ShaperFrequency Z", 52),
            ("$1210=nan", "", 2),
            ("$1210=1e3", "", 2),
            ("$1220=0.91", "ShaperDamping X", 52),
            ("$1220=-0.1", "ShaperDamping X", 4),
            ("$1231=500", "ShaperFrequency Y", 52),
            ("$1240=1", "ShaperDamping X", 52),
            ("$1206=1", "", 3),
        ] {
            let answer = m.ask(line);
            assert!(answer.contains(name), "{line}: {answer}");
            assert!(
                error == 0 || answer.ends_with(&format!("error:{error}\r\n")),
                "{line}: {answer}"
            );
        }
        ask(m, &["$1210=3", "$1220=0.5"]);
        assert!(m.ask("$1200=2").contains("[MSG:ShaperTooLong X: 386 ms"));
        ask(m, &["$1210=25"]);
        let answer = m.ask("$1200=3");
        assert!(answer.contains("[MSG:ShaperDamping X"), "{answer}");
        assert!(answer.contains("; see $1200 $1220 $1240]"), "{answer}");
        ask(m, &["$1200=2"]);
        assert!(m.ask("$1210=3").contains("[MSG:ShaperTooLong X"));
        assert_eq!(m.controller.settings().get(1210), Some(25.0));

        m.say("$MOVE=5000,0,0,0,0,0");
        m.say("$MOVE=END");
        m.run(MS * 20);
        m.heard();
        m.say("$1200=1");
        m.run(MS * 10);
        assert_eq!(m.heard(), "", "lines wait for the end of the motion");
        m.run_to_rest();
        assert_eq!(m.heard(), "error:8\r\n", "and the motors still run then");
        assert_eq!(m.controller.settings().get(1200), Some(2.0));
        assert_eq!(m.controller.counts()[0], 5000);
    });
}

// ---- jobs ----

const FLEXIBLE: &str = include_str!("../jobs/flexible.toml");

fn job(text: &str) -> Result<Job, JobError> {
    Job::parse("jobs/flexible.toml", "flexible", text.as_bytes())
}

#[test]
fn the_job_of_a_flexible_joint_shows_what_shaping_gains_and_what_it_costs_the_contour() {
    let job = job(FLEXIBLE).expect("it is right");
    let Task::Path(path) = &job.task else {
        panic!("a path")
    };
    let outcome = run::run(&job, &mut |_, _| {}).expect("it runs");

    let figures = PathFigures::of(&job, path, &outcome, 0.0);

    assert!(figures.is_sound());
    let shaping = figures.shaping.as_ref().expect("it has shapers");
    let share = shaping.share().expect("it has a flexible joint");
    println!(
        "left {:.2} %, contour error of the shaping {:.1} um",
        100.0 * share,
        shaping.error.largest * 1e3
    );
    assert!(share < 0.02, "{share}");
    // It is told, and it is what the contour is off beside the tolerance and a step. Most of it is where d1 turns round:
    // with a fourth of its command 20 ms early and a fourth as late, at up to 2500 mm/s2, it turns 0.25 mm short.
    assert!(shaping.error.largest > 0.2 && shaping.error.largest < 0.255);
    assert!(shaping.error.cut > 0.2, "the point is not reached");
    assert!(figures.contour.largest > figures.path.contour.tolerance + figures.path.step());
    let (summary, page) = (figures.summary().join("\n"), figures.html());
    for text in ["off the unshaped one by at most", "% are left"] {
        assert!(summary.contains(text) && page.contains(text), "{text}");
    }
    assert!(page.contains("A joint of 25.0 Hz behind d1"));
}

#[test]
fn a_straight_move_is_not_led_off_its_line_by_shapers_of_one_kind() {
    let points = FLEXIBLE.find("points = [").expect("there");
    let end = points + FLEXIBLE[points..].find("\n]").expect("there") + 2;
    let text = format!(
        "{}points = [[9, 4, 0, 0, 0, 0]]{}",
        &FLEXIBLE[..points],
        &FLEXIBLE[end..]
    );
    for (shapers, most) in [
        ("\"zvd\", \"zvd\", \"off\"", 0.002),
        // Means agree, but ramps are rounded in different ways.
        ("\"zvd\", \"off\", \"off\"", 0.6),
    ] {
        let text = text.replace("\"zvd\", \"off\", \"off\"", shapers);
        let job = job(&text).expect("it is right");
        let Task::Path(path) = &job.task else {
            panic!("a path")
        };
        let outcome = run::run(&job, &mut |_, _| {}).expect("it runs");
        let figures = PathFigures::of(&job, path, &outcome, 0.0);
        let error = figures.shaping.as_ref().expect("shapers").error.largest;
        println!("{shapers}: {:.1} um", error * 1e3);

        assert!(error < most, "{shapers}: {error}");
        assert!(figures.is_sound());
    }
}

#[test]
fn shapers_of_a_job_that_cannot_be_are_refused_at_their_keys() {
    for (from, to, key, name) in [
        (
            "\"zvd\", \"off\"",
            "\"zvx\", \"off\"",
            "machine.shaper[0]",
            "UnknownName",
        ),
        (
            "[       25,",
            "[      500,",
            "machine.shaper_hz[0]",
            "OutOfRange",
        ),
        (
            "[       25,",
            "[      -25,",
            "machine.shaper_hz[0]",
            "OutOfRange",
        ),
        (
            "[       25,",
            "[      nan,",
            "machine.shaper_hz[0]",
            "NotFinite",
        ),
        (
            "[     0.02,",
            "[     0.95,",
            "machine.shaper_damping[0]",
            "OutOfRange",
        ),
        (
            "flexible_hz = 25",
            "",
            "machine.flexible_hz",
            "MissingField",
        ),
        ("flexible = \"d1\"", "", "machine.flexible", "MissingField"),
        (
            "flexible = \"d1\"",
            "flexible = \"d9\"",
            "machine.flexible",
            "UnknownName",
        ),
    ] {
        assert!(FLEXIBLE.contains(from), "{from}");
        let error = job(&FLEXIBLE.replacen(from, to, 1))
            .map(|job| job.name)
            .expect_err("refused");
        assert_eq!(
            (error.key.as_deref(), error.name),
            (Some(key), name),
            "{to}"
        );
    }
    // What only the machine can tell.
    for (from, to, name) in [
        ("[       25,", "[        3,", "ShaperTooLong"),
        ("[     0.02,     0,", "[     0.4,     0,", ""),
    ] {
        let job = job(&FLEXIBLE.replacen(from, to, 1)).expect("each number is right");
        match run::run(&job, &mut |_, _| {}) {
            Err(error) => assert_eq!(
                (error.key.as_deref(), error.name),
                (Some("machine.shaper[0]"), name)
            ),
            Ok(_) => assert_eq!(name, ""),
        }
    }
}

/// The answer's weights as impulses on a mass on a spring that is integrated in steps of 0.1 us, without a formula of its
/// motion.
#[test]
fn the_calculator_agrees_with_a_mass_on_a_spring() {
    for (kind, hz, damping) in [("zv", 25.0, 0.0), ("zvd", 33.3, 0.05), ("ei", 61.7, 0.1)] {
        let request = format!(
            "{{\"type\":\"{kind}\",\"frequency\":{hz},\"damping\":{damping},\"points\":9}}"
        );
        let mut output = Vec::new();
        let status = calc::main("shaper.residual", "f64", request.as_bytes(), &mut output);
        assert_eq!(status.expect("written"), 0);
        let answer: serde_json::Value = serde_json::from_slice(&output).expect("JSON");
        let list = |name: &str| -> Vec<f64> {
            let entries = answer[name].as_array().expect("a list").iter();
            entries.map(|x| x.as_f64().expect("a number")).collect()
        };
        let (samples, weights) = (list("samples"), list("weights"));
        for (f, left) in list("frequencies").into_iter().zip(list("residual")) {
            // e' = v, v' = -2 z w v - w^2 e, by the midpoint rule.
            let (omega, dt) = (std::f64::consts::TAU * f, 1e-7);
            let (mut e, mut v) = (0.0f64, 0.0f64);
            let mut now = 0.0;
            for (delay, weight) in samples.iter().zip(&weights) {
                let ticks = ((delay * 1e-3 - now) / dt).round() as u64;
                for _ in 0..ticks {
                    let (em, vm) = (
                        e + 0.5 * dt * v,
                        v + 0.5 * dt * (-2.0 * damping * omega * v - omega * omega * e),
                    );
                    e += dt * vm;
                    v += dt * (-2.0 * damping * omega * vm - omega * omega * em);
                }
                now = delay * 1e-3;
                v += weight;
            }
            // An impulse of 1 leaves an amplitude of 1 in damped units.
            let damped = omega * (1.0f64 - damping * damping).sqrt();
            let amplitude = (damped * e).hypot(v + damping * omega * e);
            assert!(
                (100.0 * amplitude - left).abs() < 0.01,
                "{kind} {f}: {amplitude} {left}"
            );
        }
    }
}
