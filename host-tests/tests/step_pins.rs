//! Direction set-up and hold, rebuilt from the edges of the pins, whatever is sent to the machine: targets to and fro,
//! lines of counts, both step modes, six motors and eight.

use hexstep_host::machine::{self, Machine};
use hexstep_host::trace::{Change, TICK_HZ, Trace, bits};

/// What the pins of one trace have kept [timer counts]; `None` where nothing of the kind happened.
#[derive(Clone, Copy, Debug, Default)]
struct Kept {
    /// Least time from a change of direction to the next step.
    setup: Option<u64>,
    /// Least time from a step to the next change of direction.
    hold: Option<u64>,
    turns: usize,
}

/// Walks over the pins' levels and nothing else.
fn kept<const N: usize>(trace: &Trace<N>, both_edges: bool) -> Kept {
    let mut kept = Kept::default();
    let (mut levels, mut directions) = (0u8, 0u8);
    let (mut stepped, mut turned) = ([None::<u64>; N], [None::<u64>; N]);
    let mut events = trace.events().peekable();
    // The pins as the trace found them.
    while let Some(event) = events.next_if(|event| event.tick == 0) {
        match event.change {
            Change::Levels(new) => levels = new,
            Change::Directions(new) => directions = new,
            Change::Enable(_) => {}
        }
    }
    for event in events {
        match event.change {
            Change::Levels(new) => {
                let edges = if both_edges {
                    new ^ levels
                } else {
                    new & !levels
                };
                for motor in bits::<N>(edges) {
                    if let Some(at) = turned[motor].take() {
                        let setup = event.time - at;
                        kept.setup = Some(kept.setup.map_or(setup, |least| least.min(setup)));
                    }
                    stepped[motor] = Some(event.time);
                }
                levels = new;
            }
            Change::Directions(new) => {
                for motor in bits::<N>(new ^ directions) {
                    kept.turns += 1;
                    turned[motor] = Some(event.time);
                    if let Some(at) = stepped[motor] {
                        let hold = event.time - at;
                        kept.hold = Some(kept.hold.map_or(hold, |least| least.min(hold)));
                    }
                }
                directions = new;
            }
            Change::Enable(_) => {}
        }
    }
    kept
}

/// A number from 0 to below `below`, the next one of its row.
struct Random(u64);

impl Random {
    fn below(&mut self, below: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 20) % below
    }
}

/// Driver times and how the motors may move.
#[derive(Clone, Copy, Debug)]
struct Case {
    both_edges: bool,
    setup_us: u32,
    hold_us: u32,
    /// [steps/s], [steps/s2], [steps/s3]
    rate: u64,
    acceleration: u64,
    jerk: u64,
}

#[track_caller]
fn ask<const N: usize>(machine: &mut Machine<'_, N>, line: &str) {
    let heard = machine.ask(line);
    assert_eq!(heard.trim(), "ok", "{line}");
}

fn set_up<const N: usize>(machine: &mut Machine<'_, N>, case: &Case) {
    machine.ask("");
    for motor in 0..N {
        for (first, value) in [(110, 1), (120, 1), (800, 1)] {
            ask(machine, &format!("${}={value}", first + motor));
        }
        ask(machine, &format!("${}=100", 100 + motor));
        ask(machine, &format!("${}=-100000", 1040 + motor));
        ask(machine, &format!("${}=100000", 1050 + motor));
    }
    // Rapids would round off turns of a few steps.
    ask(machine, "$1005=0");
    ask(machine, "$0=1");
    ask(machine, &format!("$29={}", case.setup_us));
    ask(machine, &format!("$1011={}", case.hold_us));
    ask(machine, &format!("$1010={}", u8::from(case.both_edges)));
    for motor in 0..N {
        ask(machine, &format!("${}={}", 800 + motor, case.jerk / 100));
        ask(
            machine,
            &format!("${}={}", 120 + motor, case.acceleration / 100),
        );
        ask(
            machine,
            &format!("${}={}", 110 + motor, case.rate * 60 / 100),
        );
    }
    // The mode changes with the first tick behind it.
    machine.run(2);
    machine.take_trace();
}

/// Sends lines, each once the one before is answered, and runs to rest.
fn send<const N: usize>(machine: &mut Machine<'_, N>, lines: &[String]) {
    for line in lines {
        machine.say(line);
        let mut heard = String::new();
        while !heard.contains("ok") && !heard.contains("error") {
            machine.run(20);
            heard += &machine.heard();
        }
        assert_eq!(heard.trim(), "ok", "{line}");
    }
    machine.run_to_rest();
}

/// Asserts that everything went where it was sent, and that every direction was set up and held; direction changes.
#[track_caller]
fn judge<const N: usize>(machine: &mut Machine<'_, N>, case: &Case, end: [i64; N]) -> usize {
    assert_eq!(machine.starved(), 0, "{case:?}");
    let trace = machine.take_trace();
    assert_eq!(machine.controller.counts().map(i64::from), end, "{case:?}");
    assert_eq!(trace.positions(), end, "{case:?}");
    let kept = kept(&trace, case.both_edges);
    let counts = |us: u32| u64::from(us) * TICK_HZ / 1_000_000;
    assert!(
        kept.setup
            .is_none_or(|least| least >= counts(case.setup_us)),
        "{case:?}: {kept:?}"
    );
    // Never together with a step, even if no hold is asked for.
    assert!(
        kept.hold
            .is_none_or(|least| least >= counts(case.hold_us).max(1)),
        "{case:?}: {kept:?}"
    );
    kept.turns
}

/// To and fro by a few steps and by many, some motors together and some apart.
fn zigzag<const N: usize>(random: &mut Random, at: &mut [i64; N], moves: usize) -> Vec<String> {
    let mut lines = Vec::new();
    for _ in 0..moves {
        let reach = [3, 8, 60, 700][random.below(4) as usize];
        for at in at.iter_mut() {
            if random.below(3) != 0 {
                *at += random.below(2 * reach + 1) as i64 - reach as i64;
            }
        }
        let words = at.map(|steps| steps.to_string()).join(",");
        lines.push(format!("$MOVE={words},0"));
    }
    lines.push("$MOVE=END".into());
    lines
}

fn run_case<const N: usize>(case: &Case, seed: u64) -> usize {
    machine::with_motors::<N, _>(|machine| {
        set_up(machine, case);
        let mut random = Random(seed);
        let mut at = [0i64; N];
        for round in 0..4 {
            if round % 2 == 0 {
                let lines = zigzag(&mut random, &mut at, 25);
                send(machine, &lines);
            } else {
                for _ in 0..5 {
                    let way: [i64; N] = std::array::from_fn(|_| random.below(41) as i64 - 20);
                    let longest = way.iter().map(|m| m.unsigned_abs()).max().unwrap_or(0);
                    // Slower than any tick can be, or nearly as fast as they come.
                    let seconds =
                        longest as f64 / [900.0, 40_000.0, 150_000.0][random.below(3) as usize];
                    let words = way.map(|steps| steps.to_string()).join(",");
                    machine.say(&format!("$SEG={words},{:.7}", seconds + 1e-6));
                    (0..N).for_each(|i| at[i] += way[i]);
                }
                machine.run_to_rest();
                assert!(!machine.heard().contains("error"), "{case:?}");
            }
        }
        judge(machine, case, at)
    })
}

/// Both ends of both settings, and between [us].
const TIMES: [u32; 5] = [0, 1, 24, 400, 1000];

fn all_cases(seed: u64, run: impl Fn(&Case, u64) -> usize) {
    let mut turns = 0;
    for both_edges in [false, true] {
        for setup_us in TIMES {
            for hold_us in TIMES {
                for (rate, acceleration, jerk) in [
                    (3_000, 40_000, 4_000_000),
                    (50_000, 2_000_000, 2_000_000_000),
                    (340_000, 50_000_000, 100_000_000_000),
                ] {
                    let case = Case {
                        both_edges,
                        setup_us,
                        hold_us,
                        rate,
                        acceleration,
                        jerk,
                    };
                    turns += run(
                        &case,
                        seed ^ u64::from(setup_us) << 20 ^ u64::from(hold_us) << 8 ^ rate,
                    );
                }
            }
        }
    }
    assert!(turns > 1000, "{turns}");
}

#[test]
fn six_motors_keep_the_direction_times_in_random_programs() {
    all_cases(0x5EED_0001, run_case::<6>);
}

#[test]
fn eight_motors_keep_the_direction_times_in_random_programs() {
    all_cases(0x5EED_0008, run_case::<8>);
}

/// A fast line behind a slow one, at once: the tick in which the direction changes still has the length of those before.
#[test]
fn a_line_of_counts_holds_the_directions_of_the_line_before() {
    machine::with(|machine| {
        machine.ask("");
        for line in ["$1011=24", "$29=1"] {
            ask(machine, line);
        }
        machine.take_trace();

        machine.say("$SEG=1000,0,0,0,0,0,0.005");
        machine.say("$SEG=-10,0,0,0,0,0,0.05");
        machine.run_to_rest();

        let kept = kept(&machine.take_trace(), false);
        assert_eq!(kept.turns, 1);
        // 24 us.
        assert!(kept.hold.unwrap() >= 4032, "{kept:?}");
    });
}

/// What is set up for longer than its own sample is still not stepped by the next one, which is faster.
#[test]
fn a_long_set_up_outlasts_the_sample_that_turned() {
    let case = Case {
        both_edges: false,
        setup_us: 900,
        hold_us: 500,
        rate: 50_000,
        acceleration: 2_000_000,
        jerk: 2_000_000_000,
    };
    machine::with(|machine| {
        set_up(machine, &case);
        let targets = [
            "0,0,0,-2850,0,1722",
            "0,0,0,-2850,0,1717",
            "0,0,0,-2846,0,1719",
        ];
        let mut lines: Vec<String> = targets.map(|words| format!("$MOVE={words},0")).into();
        lines.push("$MOVE=END".into());

        send(machine, &lines);

        assert!(judge(machine, &case, [0, 0, 0, -2846, 0, 1719]) > 2);
    });
}

/// Two samples of waiting at every corner: nothing is lost, the motion is later, and it ends.
#[test]
fn a_wait_of_two_samples_makes_a_zigzag_later_and_loses_nothing() {
    let mut times = Vec::new();
    for (setup_us, hold_us) in [(1, 1), (1000, 1000)] {
        let case = Case {
            both_edges: true,
            setup_us,
            hold_us,
            rate: 50_000,
            acceleration: 2_000_000,
            jerk: 2_000_000_000,
        };
        machine::with(|machine| {
            set_up(machine, &case);
            let begin = machine.now();
            let mut lines: Vec<String> = (0..40)
                .map(|k| format!("$MOVE={0},{0},{0},{0},{0},{0},0", 100 * (k % 2)))
                .collect();
            lines.push("$MOVE=END".into());

            send(machine, &lines);

            times.push(machine.now() - begin);
            assert!(judge(machine, &case, [100; 6]) >= 6 * 38);
        });
    }
    assert!(times[1] > times[0], "{times:?}");
}

/// Resets in the midst of a wait, holds, and lines behind them: the books go back to where the motors are, and what was
/// set up or held is not forgotten.
#[test]
fn stops_and_holds_at_any_time_keep_the_direction_times_and_the_count() {
    let mut turns = 0;
    for (seed, setup_us, hold_us) in [
        (1, 1, 1),
        (2, 24, 400),
        (3, 1000, 0),
        (4, 400, 1000),
        (5, 1000, 1000),
    ] {
        let case = Case {
            both_edges: seed % 2 == 0,
            setup_us,
            hold_us,
            rate: 50_000,
            acceleration: 4_000_000,
            jerk: 4_000_000_000,
        };
        machine::with(|machine| {
            set_up(machine, &case);
            let mut random = Random(seed * 0x9E37_79B9);
            for _ in 0..40 {
                let mut at = machine.controller.counts().map(i64::from);
                for line in zigzag(&mut random, &mut at, 8) {
                    machine.say(&line);
                }
                machine.run(random.below(6000));
                machine.put(b"!");
                machine.run(random.below(400));
                machine.put(b"~");
                machine.run(random.below(3000));
                if random.below(2) == 0 {
                    machine.put(&[0x18]);
                    machine.run(random.below(20));
                    machine.run_to_rest();
                    machine.ask("$X");
                    let way: [i64; 6] = std::array::from_fn(|_| random.below(41) as i64 - 20);
                    let words = way.map(|steps| steps.to_string()).join(",");
                    ask(machine, &format!("$SEG={words},0.01"));
                } else {
                    machine.run_to_rest();
                }
                machine.heard();
            }
            let end = machine.controller.counts().map(i64::from);
            turns += judge(machine, &case, end);
        });
    }
    assert!(turns > 500, "{turns}");
}
