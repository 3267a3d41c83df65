//! Pins -> trace -> motion: what was recorded comes back, and the motion in it can be read off.

use hexstep::stepper::StepMode;
use hexstep_host::export::{self, Span, nanoseconds};
use hexstep_host::trace::{Change, Event, Motion, TICK_HZ, Trace, seconds};

/// A plain generator of numbers, so that the cases are the same everywhere.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) % sides
    }
}

/// Puts a commanded position [steps] of each motor onto pins in pulse mode, `ticks` ticks of `period` counts: a step where
/// the nearest whole number changes, the pulse one tick wide.
fn play<const N: usize>(
    trace: &mut Trace<N>,
    period: u64,
    ticks: u64,
    position: impl Fn(usize, f64) -> f64,
) {
    let mut at = trace.positions();
    let mut directions = 0u8;
    let begin = trace.end();
    for k in 1..=ticks {
        let time = begin + k * period;
        trace.tick(time);
        let mut levels = 0;
        for motor in 0..N {
            let wanted = position(motor, seconds(time)).round() as i64;
            if wanted != at[motor] {
                let bit = 1 << motor;
                if wanted < at[motor] {
                    directions |= bit;
                    at[motor] -= 1;
                } else {
                    directions &= !bit;
                    at[motor] += 1;
                }
                levels |= bit;
            }
        }
        trace.directions(directions);
        trace.steps(levels);
    }
}

fn names<const N: usize>() -> [String; N] {
    std::array::from_fn(|motor| format!("m{motor}"))
}

#[test]
fn every_change_comes_back_with_its_tick_and_time() {
    for seed in 0..20 {
        let mut dice = Dice(seed);
        let mode = if seed % 2 == 0 {
            StepMode::Pulse
        } else {
            StepMode::BothEdge
        };
        let mut trace = Trace::<8>::new(mode);
        let mut expected = Vec::new();
        let (mut tick, mut time, mut period) = (0, 0, 100);
        let (mut levels, mut directions, mut enabled) = (0u8, 0u8, false);
        for _ in 0..50_000 {
            if dice.roll(50) == 0 {
                period = match dice.roll(4) {
                    0 => 0,
                    1 => 1 << dice.roll(40),
                    _ => 1 + dice.roll(5000),
                };
            }
            for _ in 0..=dice.roll(100) {
                time += period;
                tick += 1;
                trace.tick(time);
            }
            if dice.roll(100) == 0 {
                time += dice.roll(1 << 20);
                trace.at(time);
                enabled = !enabled;
                trace.enable(enabled);
                expected.push(Event {
                    tick,
                    time,
                    change: Change::Enable(enabled),
                });
            }
            let mask = dice.roll(256) as u8;
            if dice.roll(10) == 0 && mask != directions {
                directions = mask;
                trace.directions(mask);
                expected.push(Event {
                    tick,
                    time,
                    change: Change::Directions(mask),
                });
            }
            let new = if dice.roll(2) == 0 {
                0
            } else {
                dice.roll(256) as u8
            };
            trace.steps(new);
            if new != levels {
                levels = new;
                expected.push(Event {
                    tick,
                    time,
                    change: Change::Levels(new),
                });
            }
        }

        let read: Vec<Event> = trace.events().collect();

        assert_eq!(read.len(), expected.len(), "seed {seed}");
        assert!(read == expected, "seed {seed}");
        assert_eq!(trace.len(), expected.len() as u64);
        assert_eq!((trace.ticks(), trace.end()), (tick, time));
    }
}

#[test]
fn a_step_of_a_steady_motor_takes_at_most_four_bytes() {
    let mut trace = Trace::<6>::new(StepMode::Pulse);

    play(&mut trace, 2100, 400_000, |_, t| 1234.5 * t);
    let steps = trace.pulses().count();

    assert!(
        trace.stored_bytes() <= 4 * steps,
        "{} bytes, {steps} steps",
        trace.stored_bytes()
    );
}

#[test]
fn in_pulse_mode_only_rising_edges_step_and_in_both_edge_mode_every_edge_does() {
    let record = |mode| {
        let mut trace = Trace::<2>::new(mode);
        for (k, levels) in [0b01, 0b00, 0b11, 0b10, 0b11].into_iter().enumerate() {
            trace.tick(10 * (k as u64 + 1));
            trace.steps(levels);
        }
        trace
    };

    let pulse = record(StepMode::Pulse);
    let both = record(StepMode::BothEdge);

    assert_eq!(pulse.positions(), [3, 1]);
    assert_eq!(both.positions(), [5, 1]);
    let times = |trace: &Trace<2>, motor| -> Vec<u64> {
        trace.steps_of(motor).map(|step| step.time).collect()
    };
    assert_eq!(times(&pulse, 0), [10, 30, 50]);
    assert_eq!(times(&pulse, 1), [30]);
    assert_eq!(times(&both, 0), [10, 20, 30, 40, 50]);
}

#[test]
fn a_set_direction_bit_counts_backward() {
    let mut trace = Trace::<3>::new(StepMode::BothEdge);
    trace.tick(5);
    trace.directions(0b010);
    trace.steps(0b111);
    trace.tick(9);
    trace.directions(0b110);
    trace.steps(0b000);

    let signs: Vec<i8> = trace.steps_of(2).map(|step| step.sign).collect();

    assert_eq!(trace.positions(), [2, -2, 0]);
    assert_eq!(signs, [1, -1]);
}

#[test]
fn positions_at_any_time_are_those_of_a_plain_count() {
    let mut trace = Trace::<6>::new(StepMode::Pulse);
    play(&mut trace, 2800, 300_000, |motor, t| {
        3000.0 * (1.3 * t + motor as f64).sin() - 3000.0 * (motor as f64).sin()
    });
    let mut plain = Vec::new();
    for pulse in trace.pulses() {
        plain.push((pulse.time, pulse.positions));
    }
    let mut dice = Dice(7);

    for _ in 0..300 {
        let time = match dice.roll(2) {
            0 => dice.roll(trace.end() + 10_000),
            _ => plain[dice.roll(plain.len() as u64) as usize].0,
        };
        let counted = match plain.partition_point(|(t, _)| *t <= time) {
            0 => [0; 6],
            n => plain[n - 1].1,
        };

        assert_eq!(trace.positions_at(time), counted, "at {time}");
    }
}

#[test]
fn the_first_difference_of_two_traces_is_found() {
    let record = |late: u64| {
        let mut trace = Trace::<1>::new(StepMode::BothEdge);
        for k in 1..=1000u64 {
            trace.tick(k * 100 + if k == 777 { late } else { 0 });
            trace.steps((k % 2) as u8);
        }
        trace
    };

    assert_eq!(record(0).first_difference(&record(0)), None);
    let (ours, theirs) = record(0).first_difference(&record(1)).expect("they differ");

    assert_eq!(ours.map(|event| event.time), Some(77_700));
    assert_eq!(theirs.map(|event| event.time), Some(77_701));
}

#[test]
fn statistics_of_a_hand_made_trace_are_those_counted_by_hand() {
    let mut trace = Trace::<2>::new(StepMode::Pulse);
    let script: [(u64, u8, u8); 8] = [
        // time, directions, levels
        (100, 0, 0b01),
        (150, 0, 0b00),
        (180, 0, 0b01),
        (220, 0, 0b00),
        (250, 1, 0b00),
        (330, 1, 0b01),
        (360, 1, 0b00),
        (400, 3, 0b00),
    ];
    for (time, directions, levels) in script {
        trace.tick(time);
        trace.directions(directions);
        trace.steps(levels);
    }

    let [first, second] = trace.statistics();

    assert_eq!((first.forward, first.backward, first.position), (2, 1, 1));
    assert_eq!((first.lowest, first.highest, first.reversals), (0, 2, 1));
    assert_eq!((first.first, first.last), (Some(100), Some(330)));
    assert_eq!(first.least_gap, Some(80));
    assert_eq!((first.least_high, first.least_low), (Some(30), Some(30)));
    assert_eq!((first.least_setup, first.least_hold), (Some(80), Some(70)));
    // Its longest run in one direction is a single gap of 80 counts.
    assert_eq!(first.largest_rate, TICK_HZ as f64 / 80.0);
    assert_eq!((second.steps(), second.first), (0, None));
    assert_eq!((second.least_hold, second.largest_rate), (None, 0.0));
}

#[test]
fn a_trapezoid_of_speed_is_read_back_from_its_pulses() {
    // Up with 190 000 steps/s2 for 0.2 s to 38 000 steps/s, 0.3 s steady, down again; ticks of 1 MHz.
    let (a, ramp, steady) = (190_000.0, 0.2, 0.3);
    let top = a * ramp;
    let mut trace = Trace::<1>::new(StepMode::Pulse);
    play(&mut trace, 168, 710_000, |_, t| {
        let up = t.clamp(0.0, ramp);
        let along = (t - ramp).clamp(0.0, steady);
        let down = (t - ramp - steady).clamp(0.0, ramp);
        0.5 * a * up * up + top * along + top * down - 0.5 * a * down * down
    });

    let window = 0.02;
    let motion = Motion::rebuild(&trace, 0, window);

    let index = |t: f64| ((t - motion.start) / motion.cell).round() as usize;
    let at = |list: &[f64], t: f64| list[index(t)];
    for t in [0.04, 0.1, 0.16] {
        // An edge is up to 1 us late: the noise by the formula in motion.rs is below 0.1 % of a.
        assert!(
            (at(&motion.acceleration, t) - a).abs() < 0.005 * a,
            "at {t}"
        );
        assert!(
            (at(&motion.speed, t) - a * motion.time(index(t))).abs() < 0.001 * top,
            "at {t}"
        );
        let back = ramp + steady + t;
        assert!((at(&motion.acceleration, back) + a).abs() < 0.005 * a);
    }
    for t in [0.25, 0.35, 0.45] {
        assert!((at(&motion.speed, t) - top).abs() < 0.001 * top);
        assert!(at(&motion.acceleration, t).abs() < 0.005 * a);
    }
    // The half step before the first edge, and after the last, is not seen: 2 steps / window^2 of acceleration at the ends.
    assert!(Motion::largest(&motion.acceleration) < 1.001 * a + 2.0 / (window * window));
    assert!(Motion::largest(&motion.speed) < 1.0002 * top);
    assert!((trace.statistics()[0].largest_rate - top).abs() < 0.01 * top);
    let before_end = motion.position[motion.position.len() - 1];
    assert!((before_end - (top * (ramp + steady) - 0.5)).abs() < 1e-6);
}

#[test]
fn a_cubic_motion_gives_its_jerk() {
    // 100 000 t^3: jerk 600 000 steps/s3, through 0.6 s; ticks of 1 MHz, so that edges are nearly exact.
    let mut trace = Trace::<1>::new(StepMode::Pulse);
    play(&mut trace, 168, 600_000, |_, t| 100_000.0 * t * t * t);

    let motion = Motion::rebuild(&trace, 0, 0.1);

    for t in [0.3, 0.4, 0.5] {
        let index = ((t - motion.start) / motion.cell).round() as usize;
        let exact_time = motion.time(index);
        assert!(
            (motion.jerk[index] / 600_000.0 - 1.0).abs() < 0.02,
            "jerk at {t}"
        );
        assert!((motion.acceleration[index] / (600_000.0 * exact_time) - 1.0).abs() < 0.002);
        // A mean over the window lies j w^2 / 36 above the speed in its middle.
        let speed = 300_000.0 * exact_time * exact_time + 600_000.0 * 0.1 * 0.1 / 36.0;
        assert!((motion.speed[index] / speed - 1.0).abs() < 0.001);
    }
}

#[test]
fn a_stretch_rebuilt_alone_equals_the_same_stretch_of_the_whole() {
    let mut trace = Trace::<2>::new(StepMode::Pulse);
    play(&mut trace, 2100, 160_000, |motor, t| {
        5000.0 * (4.0 * t + motor as f64).sin() - 5000.0 * (motor as f64).sin()
    });

    let whole = Motion::rebuild(&trace, 1, 0.016);
    let from = TICK_HZ / 2;
    let part = Motion::rebuild_between(&trace, 1, 0.016, from, TICK_HZ);

    let shift = ((part.start - whole.start) / whole.cell).round() as usize;
    for (k, speed) in part.speed.iter().enumerate() {
        assert!((speed - whole.speed[shift + k]).abs() < 1.0, "sample {k}");
    }
    assert!((part.start - 0.5).abs() < part.cell);
}

#[test]
fn a_motor_at_rest_has_no_speed() {
    let mut trace = Trace::<2>::new(StepMode::Pulse);
    play(&mut trace, 2100, 8_000, |motor, t| {
        if motor == 0 { 3000.0 * t } else { 0.0 }
    });

    let motion = Motion::rebuild(&trace, 1, 0.01);

    assert!(!motion.speed.is_empty());
    assert_eq!(Motion::largest(&motion.speed), 0.0);
    assert_eq!(Motion::largest(&motion.position), 0.0);
}

#[test]
fn nanoseconds_give_every_count_back() {
    let mut dice = Dice(3);
    for k in 0..200_000u64 {
        let counts = if k < 100_000 {
            k
        } else {
            dice.roll(1 << 31) * 1000 + k
        };
        let ns = nanoseconds(counts);

        // A double holds the product of a whole day's nanoseconds to far less than half a count.
        assert_eq!((ns as f64 * 0.168).round() as u64, counts);
    }
    assert_eq!(nanoseconds(TICK_HZ), 1_000_000_000);
    assert_eq!(nanoseconds(21), 125);
}

#[test]
fn the_vcd_holds_every_edge_of_the_trace() {
    let mut trace = Trace::<6>::new(StepMode::Pulse);
    trace.enable(true);
    play(&mut trace, 2100, 20_000, |motor, t| {
        800.0 * (8.0 * t + motor as f64).sin() - 800.0 * (motor as f64).sin()
    });
    let mut file = Vec::new();

    export::vcd(&mut file, &trace, &names(), Span::ALL).expect("a vector takes all");

    let mut parser = vcd::Parser::new(&file[..]);
    let header = parser.parse_header().expect("a header");
    assert_eq!(header.timescale, Some((1, vcd::TimescaleUnit::NS)));
    let find = |name: &str| {
        header
            .find_var(&["hexstep", name])
            .unwrap_or_else(|| panic!("{name} is missing"))
            .code
    };
    let steps: Vec<_> = (0..6).map(|m| find(&format!("step_m{m}"))).collect();
    let directions: Vec<_> = (0..6).map(|m| find(&format!("dir_m{m}"))).collect();
    let enable = find("enable");
    let (mut time, mut negative, mut enabled) = (0, [false; 6], false);
    let mut read: Vec<Vec<(u64, i8)>> = vec![Vec::new(); 6];
    for command in parser {
        match command.expect("a command") {
            vcd::Command::Timestamp(t) => {
                assert!(t >= time, "time runs forward");
                time = t;
            }
            vcd::Command::ChangeScalar(code, value) => {
                let high = value == vcd::Value::V1;
                if code == enable {
                    enabled = high;
                }
                if let Some(motor) = directions.iter().position(|c| *c == code) {
                    negative[motor] = high;
                }
                if let Some(motor) = steps.iter().position(|c| *c == code)
                    && high
                {
                    read[motor].push((time, if negative[motor] { -1 } else { 1 }));
                }
            }
            _ => {}
        }
    }
    assert!(enabled);
    for (motor, read) in read.iter().enumerate() {
        let expected: Vec<(u64, i8)> = trace
            .steps_of(motor)
            .map(|step| (nanoseconds(step.time), step.sign))
            .collect();
        assert!(expected.len() > 100);
        assert!(*read == expected, "motor {motor}");
    }
}

#[test]
fn the_csv_holds_one_row_for_each_step() {
    let mut trace = Trace::<2>::new(StepMode::BothEdge);
    trace.tick(168_000_000);
    trace.directions(0b10);
    trace.steps(0b11);
    trace.tick(168_000_000 + 1680);
    trace.steps(0b01);
    let mut file = Vec::new();

    export::csv(
        &mut file,
        &trace,
        &["d1".into(), "theta3".into()],
        Span::ALL,
    )
    .expect("written");

    let text = String::from_utf8(file).expect("text");
    assert_eq!(
        text,
        "time_s,motor,direction,position\n\
         1.000000000,d1,1,1\n\
         1.000000000,theta3,-1,-1\n\
         1.000010000,theta3,-1,-2\n"
    );
}

#[test]
fn a_span_of_a_trace_is_written_alone() {
    let mut trace = Trace::<1>::new(StepMode::BothEdge);
    for k in 1..=10u64 {
        trace.tick(k * 1000);
        trace.steps((k % 2) as u8);
    }
    let mut file = Vec::new();

    let span = Span {
        from: 4000,
        to: 6000,
    };
    export::csv(&mut file, &trace, &names(), span).expect("written");

    let rows = String::from_utf8(file).expect("text").lines().count();
    assert_eq!(rows, 1 + 3);
}

#[test]
fn a_file_that_cannot_be_written_whole_leaves_nothing_behind() {
    let folder = std::env::temp_dir().join(format!("hexstep-whole-{}", std::process::id()));
    let path = folder.join("half.txt");

    let failed = hexstep_host::files::write_whole(&path, |out| {
        out.write_all(b"half of it")?;
        Err(std::io::Error::other("no more"))
    });

    assert!(failed.is_err());
    let left = std::fs::read_dir(&folder).expect("the folder").count();
    std::fs::remove_dir_all(&folder).expect("removed");
    assert_eq!(left, 0);
}
