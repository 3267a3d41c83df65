//! A sensor that fails while a program runs: silence, outliers, no number, broken records, stuck at full scale.
//!
//! What is no reading counts as a miss whether it comes or not, and misses are counted in the path's own time. So a run
//! with one good reading before its start, and then only such, has but one course: its pulses in the emulator must be
//! those of memory, and those of silence, tick for tick, whenever the bytes come.

use super::rig::*;
use hexstep::protocol::reading::{self, BEGIN, DIGIT};
use hexstep::protocol::report::State;
use hexstep_host::emulator::Pulses;
use hexstep_host::machine::Machine;
use std::cell::Cell;
use std::time::Duration;

/// The usual limits, a fifth of them for trims.
const SHARE: &str = "$1013=0.2";
/// Period 10 ms, tau 0.09 s, amount 0.08 mm, rate 0.5 mm/s, gate 0.3 mm, 20 misses.
const FOLLOW: &str = "$TRIM=ON,10,0.09,0.08,0.5,0.3,20";
/// The same for a sensor that is believed everything and may be silent for long.
const BELIEVE: &str = "$TRIM=ON,10,0.02,0.08,0.5,9,100000";
/// Beyond the amount, so that the trim goes to it.
const GOOD: f32 = 0.25;
const FULL_SCALE: f32 = 3.2767;
/// Amount [steps].
const AMOUNT: i64 = 80;
/// Ticks at the floor of the tick rate, 40 kHz, from one step of a trim to the next at 0.5 mm/s: 2 ms.
const GAP: f64 = 80.0;
/// Ticks without a step by which a machine is seen to rest: 50 ms or more, longer than any gap of the paths here.
const REST: u64 = 4_000;
const PERIOD: Duration = Duration::from_millis(3);

const FAULT: &str = "[MSG:Trim fault: ";

/// What the sensor sends as its k-th word after the good reading.
type Says = fn(u32) -> Vec<u8>;

/// The kinds of no reading.
const FAULTS: [(&str, Says); 5] = [
    ("silence", |_| Vec::new()),
    ("outliers", |k| {
        let far = [3.0, -3.0, 0.56, -0.06, 1.5];
        reading::encode(Some(far[k as usize % far.len()])).to_vec()
    }),
    ("no number", |k| {
        let none = [Some(f32::NAN), None, Some(f32::INFINITY)];
        reading::encode(none[k as usize % none.len()]).to_vec()
    }),
    ("broken records", broken),
    ("stuck at full scale", |_| {
        reading::encode(Some(FULL_SCALE)).to_vec()
    }),
];

/// A record that is none: a wrong digit, one short, one without its begin, no digits.
fn broken(k: u32) -> Vec<u8> {
    let mut bytes = reading::encode(Some(0.1)).to_vec();
    match k % 6 {
        0 => bytes[8] = DIGIT + ((bytes[8] - DIGIT) ^ 1),
        1 => bytes[3] = DIGIT + ((bytes[3] - DIGIT) ^ 4),
        2 => drop(bytes.remove(5)),
        3 => drop(bytes.remove(0)),
        4 => bytes[1..].fill(0xFF),
        _ => bytes = vec![BEGIN; 9],
    }
    bytes
}

/// X1 Y1 X2 Y2 move, Z and B rest: the steps of Z1 and Z2 are the trim and nothing else.
fn flat() -> Vec<String> {
    let at = |k: i32| [1000 * k, 500 * k, 0, 0, -1000 * k, -600 * k, 0, 0];
    (1..=3).map(|k| moved(at(k))).chain([end()]).collect()
}

/// All eight move, and the normal turns by 2 deg on the way.
fn turning() -> Vec<String> {
    let at = |k: i32| {
        let (x, b) = (1000 * k, 800 * k);
        [x, 500 * k, -300 * k, b, -x, -600 * k, 350 * k, b]
    };
    (1..=3).map(|k| moved(at(k))).chain([end()]).collect()
}

fn back() -> [String; 2] {
    [moved([0; 8]), end()]
}

/// A fifth of a second's way: 1000 steps of X1 are 5000 steps/s, eight ticks each, the floor of the tick rate.
fn moved(steps: [i32; 8]) -> String {
    let steps = steps.map(|steps| steps.to_string());
    format!("$MOVE={},0.2", steps.join(","))
}

fn end() -> String {
    "$MOVE=END".into()
}

/// Steps of a motor as tick and sign.
fn steps(pulses: &Pulses, motor: usize) -> Vec<(u64, i64)> {
    let mut before = 0;
    let mut steps = Vec::new();
    for pulse in pulses.iter() {
        if (pulse.levels & !before) >> motor & 1 != 0 {
            let backward = pulse.directions >> motor & 1 != 0;
            steps.push((pulse.tick, if backward { -1 } else { 1 }));
        }
        before = pulse.levels;
    }
    steps
}

fn way(pulses: &Pulses, motor: usize) -> i64 {
    steps(pulses, motor).iter().map(|step| step.1).sum()
}

/// Of pulses of the flat path: the trim of Z1, and in the same samples that of Z2 the other way, within amount and rate at
/// each step. Where it ends.
///
/// In a sample both sides go to the same place, but each rounds its increments for itself, one forward and one backward: now
/// and then one of them steps a tick of the step timer later.
#[track_caller]
fn assert_bounded(pulses: &Pulses, name: &str) -> i64 {
    let (z1, z2) = (steps(pulses, 2), steps(pulses, 6));
    assert_eq!(z1.len(), z2.len(), "{name}: both sides as many steps");
    for (one, two) in z1.iter().zip(&z2) {
        let is_mirrored = one.1 == -two.1 && one.0.abs_diff(two.0) <= 1;
        assert!(
            is_mirrored,
            "{name}: both sides in the same ticks: {one:?} {two:?}"
        );
    }
    let mut places: Vec<(u64, i64)> = Vec::new();
    for (tick, sign) in z1 {
        let at = places.last().map_or(0, |place| place.1) + sign;
        assert!(at.abs() <= AMOUNT, "{name}: {at} steps in tick {tick}");
        for (before, from) in &places {
            // Whole steps are asked for, one more or less than the way at the rate.
            let most = (tick - before) as f64 / GAP + 1.0;
            let way = (at - from).abs();
            assert!(
                way as f64 <= most,
                "{name}: {way} steps from {before} to {tick}"
            );
        }
        // So their means over 32 ms may go 17 steps in that time instead of 16; a tick lies between an instant and its pin.
        if let Some((before, from)) = places.last()
            && at - from == way_of(&places)
        {
            let gap = (tick - before + 1) as f64;
            assert!(gap >= GAP * 16.0 / 17.0, "{name}: {gap} ticks to {tick}");
        }
        places.push((tick, at));
    }
    places.last().map_or(0, |place| place.1)
}

/// The sign of the last step.
fn way_of(places: &[(u64, i64)]) -> i64 {
    match places {
        [.., (_, before), (_, last)] => last - before,
        [(_, last)] => *last,
        [] => 0,
    }
}

/// The three stretches of a run that a fault holds.
struct Held {
    /// To the hold.
    first: Pulses,
    /// Behind a resume alone, to the hold again.
    resumed: Pulses,
    /// Behind the freeze and a resume, to the end of the path.
    freed: Pulses,
}

impl Held {
    #[track_caller]
    fn assert_equals(&self, other: &Self, name: &str) {
        for (stretch, ours, theirs) in [
            ("to the hold", &self.first, &other.first),
            ("resumed", &self.resumed, &other.resumed),
            ("to the end", &self.freed, &other.freed),
        ] {
            assert_eq!(ours.first_difference(theirs), None, "{name}, {stretch}");
        }
    }

    /// Of the flat path.
    #[track_caller]
    fn assert_bounded(&self, name: &str) {
        assert_eq!(assert_bounded(&self.first, name), AMOUNT, "{name}");
        for after in [&self.resumed, &self.freed] {
            assert!(
                steps(after, 2).is_empty() && steps(after, 6).is_empty(),
                "{name}: moved when held"
            );
        }
        let ways = [&self.first, &self.resumed, &self.freed].map(|pulses| way(pulses, 0));
        assert!((1..2500).contains(&ways[0]), "{name}: {ways:?}");
        assert!(ways[1].abs() < 50, "{name}: {ways:?}");
        assert_eq!(ways.iter().sum::<i64>(), 3000, "{name}: {ways:?}");
    }
}

// ---- in memory ----

fn state(machine: &Machine<'_, 8>) -> State {
    machine.controller.state()
}

/// Runs until the machine rests in a hold and a while longer, the sensor speaking every 5 ms once the path moves.
#[track_caller]
fn run_to_hold(machine: &mut Machine<'_, 8>, says: Says) -> Pulses {
    let mut rest = 0;
    for step in 0..100_000 {
        // The last reading counts: none must overtake the good one before the path has taken that.
        if step >= 2000 && step % 200 == 0 {
            machine.put(&says(step / 200));
        }
        machine.step();
        rest = if state(machine) == (State::Hold { moving: false }) {
            rest + 1
        } else {
            0
        };
        if rest > 2000 {
            return Pulses::of_trace(&machine.take_trace());
        }
    }
    panic!("no hold");
}

fn held_in_memory(path: &[String], says: Says) -> Held {
    eight(|machine| {
        for line in [ALLOW, SHARE, FOLLOW] {
            assert!(machine.ask(line).ends_with("ok\r\n"), "{line}");
        }
        machine.put(&reading::encode(Some(GOOD)));
        machine.take_trace();
        path.iter().for_each(|line| machine.say(line));
        let first = run_to_hold(machine, says);
        let heard = machine.heard();
        assert_eq!(heard.matches(FAULT).count(), 1, "{heard}");
        machine.put(b"~");
        let resumed = run_to_hold(machine, says);
        machine.put(&[0xAE, b'~']);
        machine.run_to_rest();
        machine.run(3);
        Held {
            first,
            resumed,
            freed: Pulses::of_trace(&machine.take_trace()),
        }
    })
}

/// A run that nothing holds, the sensor at full scale from its first reading on.
fn full_scale_in_memory() -> Pulses {
    eight(|machine| {
        for line in [ALLOW, SHARE, BELIEVE] {
            assert!(machine.ask(line).ends_with("ok\r\n"), "{line}");
        }
        machine.put(&reading::encode(Some(FULL_SCALE)));
        machine.take_trace();
        let pulses = super::common::pulses_of_lines(machine, &flat());
        assert_eq!(state(machine), State::Idle);
        pulses
    })
}

#[test]
fn whatever_is_no_reading_holds_the_machine_as_silence_does() {
    let silence = held_in_memory(&flat(), |_| Vec::new());
    silence.assert_bounded("silence");

    for (name, says) in FAULTS {
        held_in_memory(&flat(), says).assert_equals(&silence, name);
    }
}

#[test]
fn a_sensor_at_full_scale_from_the_first_reading_on_moves_the_pair_to_the_amount_and_no_further() {
    let pulses = full_scale_in_memory();

    assert_eq!(assert_bounded(&pulses, "full scale"), AMOUNT);
    assert_eq!(way(&pulses, 0), 3000);
}

// ---- in the emulator ----

impl Octopus {
    /// Says a path at rest behind a first reading, and waits until it moves; its pulses begin the recording.
    fn begin(&mut self, follow: &str, first: f32, path: &[String]) {
        self.ask(follow);
        self.emulator.expect_idle(JOB).unwrap();
        self.emulator
            .send_bytes(&reading::encode(Some(first)))
            .unwrap();
        self.emulator.take_recording();
        path.iter().for_each(|line| drop(self.ask(line)));
        self.wait_for_ticks(0);
    }

    /// Lets the sensor speak until the motors have come to rest; how often it did.
    #[track_caller]
    fn speak_to_rest(&mut self, mut says: impl FnMut(u32) -> Vec<u8>) -> u32 {
        for k in 0.. {
            self.emulator.send_bytes(&says(k)).unwrap();
            std::thread::sleep(PERIOD);
            let rests = Cell::new(false);
            let look = |recording: &hexstep_host::emulator::Recording| {
                let motion = recording.motion();
                rests.set(!motion.is_empty() && recording.ticks() > motion.end + REST);
                true
            };
            self.emulator.wait_for("a look", JOB, look).unwrap();
            if rests.get() {
                return k + 1;
            }
        }
        unreachable!("more words than a u32 counts")
    }

    #[track_caller]
    fn expect_hold(&mut self) {
        for _ in 0..200 {
            let status = self.emulator.status(JOB).unwrap();
            if status.starts_with("<Hold:0|") {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("no hold");
    }

    /// Takes the trim back and goes to where all began.
    fn go_back(&mut self) {
        self.ask("$TRIM=0");
        self.emulator.expect_idle(JOB).unwrap();
        back().iter().for_each(|line| drop(self.ask(line)));
        self.emulator.expect_idle(JOB).unwrap();
    }

    #[track_caller]
    fn held(&mut self, path: &[String], name: &str, says: Says) -> Held {
        self.begin(FOLLOW, GOOD, path);
        let said = self.speak_to_rest(says);
        self.emulator
            .expect("the fault's message", JOB, |line| line.starts_with(FAULT))
            .unwrap();
        self.expect_hold();
        let recording = self.emulator.take_recording();
        let bytes = self.bytes_in_motion(&recording).len();
        let speaks = !says(0).is_empty();
        assert!(
            !speaks || bytes > 20 * READING,
            "{name}: {bytes} bytes of {said} words"
        );
        self.emulator.send_bytes(b"~").unwrap();
        self.expect_hold();
        let resumed = self.emulator.take_recording().pulses();
        self.emulator.send_bytes(&[0xAE, b'~']).unwrap();
        self.emulator.expect_idle(JOB).unwrap();
        let freed = self.emulator.take_recording().pulses();
        self.go_back();
        Held {
            first: recording.pulses(),
            resumed,
            freed,
        }
    }
}

#[test]
fn in_the_firmware_too_whatever_is_no_reading_holds_it_with_the_pulses_of_memory() {
    let Some(mut octopus) = Octopus::boot("faults") else {
        return;
    };
    octopus.ask(SHARE);
    let wanted = held_in_memory(&flat(), |_| Vec::new());

    for (name, says) in FAULTS {
        let made = octopus.held(&flat(), name, says);

        made.assert_bounded(name);
        made.assert_equals(&wanted, name);
    }

    let wanted = held_in_memory(&turning(), |_| Vec::new());
    let made = octopus.held(&turning(), "outliers, all turning", FAULTS[1].1);
    made.assert_equals(&wanted, "outliers, all turning");
}

#[test]
fn in_the_firmware_too_a_wild_sensor_moves_the_pair_within_amount_and_rate() {
    let Some(mut octopus) = Octopus::boot("wild") else {
        return;
    };
    octopus.ask(SHARE);

    octopus.begin(BELIEVE, FULL_SCALE, &flat());
    octopus.speak_to_rest(|_| reading::encode(Some(FULL_SCALE)).to_vec());
    let stuck = octopus.emulator.take_recording().pulses();
    octopus.go_back();
    octopus.begin(BELIEVE, FULL_SCALE, &flat());
    octopus.speak_to_rest(|k| match k % 7 {
        3 => reading::encode(None).to_vec(),
        5 => broken(k),
        // Now one way, now the other, long enough to get there.
        _ if k / 15 % 2 == 0 => reading::encode(Some(FULL_SCALE)).to_vec(),
        _ => reading::encode(Some(-FULL_SCALE)).to_vec(),
    });
    let wild = octopus.emulator.take_recording().pulses();

    assert_eq!(stuck.first_difference(&full_scale_in_memory()), None);
    assert_eq!(assert_bounded(&stuck, "stuck"), AMOUNT);
    assert_bounded(&wild, "wild");
    let turns = steps(&wild, 2)
        .windows(2)
        .filter(|pair| pair[0].1 != pair[1].1)
        .count();
    assert!(turns > 0, "never turned round");
    assert_eq!(way(&wild, 0), 3000);
}
