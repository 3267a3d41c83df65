//! From the last byte of a reading to the first pulse that its trim has moved.
//!
//! The run without a reading is known from memory, tick for tick, with the time of each tick and the segment it belongs
//! to. Up to where the two part they are the same, so what the emulator's run shows at a tick has the time that the tick
//! has in memory. Z1 and Z2 run in odd ratios to the tick, 10 us, and the trim comes at 80 steps/ms, so that even the first
//! trimmed segment, which carries a 1024th of that, moves a pulse by a tick.

use super::rig::*;
use hexstep::protocol::reading;
use hexstep_host::emulator::Pulses;
use hexstep_host::machine::Machine;
use hexstep_host::trace;

/// A segment of a path, and what the queue is kept ahead [ms].
const SEGMENT: f64 = 1.0;
const QUEUE: f64 = 5.0;

/// A tick each so many milliseconds, tau 0.1 ms, amount 2 mm, rate 80 mm/s; no reading for long is no fault.
fn follow(period: u32) -> String {
    format!("$TRIM=ON,{period},0.0001,2,80,9,1000000")
}

/// 1000 of its steps.
const READING_MM: f32 = 1.0;
/// X1 50 000 steps/s, Z1 13 700, X2 -40 000, Z2 17 300, a fifth of a second; all motors move.
const PATH: [&str; 2] = [
    "$MOVE=10000,1111,2740,777,-8000,-1331,3460,-333,0.2",
    "$MOVE=END",
];
const BACK: [&str; 2] = ["$MOVE=0,0,0,0,0,0,0,0,0.2", "$MOVE=END"];
/// Ticks of the path in which a reading may come so that what it does shows before the path ends.
const EARLIEST: u64 = 2_000;
const LATEST: u64 = 17_000;

/// Limits far above the usual ones for the motors that slide, and half of them for trims.
fn settings() -> Vec<String> {
    let motor = |i: usize| {
        [
            format!("${}=12000", 110 + i),
            format!("${}=20000", 120 + i),
            format!("${}=10000000", 800 + i),
            format!("${}=3", 1030 + i),
        ]
    };
    ["$1013=0.5".to_string()]
        .into_iter()
        .chain([0, 1, 2, 4, 5, 6].into_iter().flat_map(motor))
        .collect()
}

/// A run in memory.
struct Run {
    pulses: Pulses,
    /// Steps of the machine before the one that makes the first step.
    lead: u64,
    /// Of each tick from the first step on: its time [counts], and the segment that runs from it on.
    ticks: Vec<(u64, u32)>,
}

impl Run {
    /// Runs the path without a reading.
    fn plain(period: u32) -> Self {
        eight(|machine| Self::make(machine, period, None))
    }

    /// Runs the path with a reading behind the tick `at` from the first step on.
    fn trimmed(&self, period: u32, at: u64) -> Self {
        let reading = (self.lead + at + 1) as usize;
        eight(|machine| Self::make(machine, period, Some(reading)))
    }

    fn make(machine: &mut Machine<'_, 8>, period: u32, reading: Option<usize>) -> Self {
        for line in settings().into_iter().chain([follow(period)]) {
            assert!(machine.ask(&line).ends_with("ok\r\n"), "{line}");
        }
        machine.take_trace();
        PATH.iter().for_each(|line| machine.say(line));
        let mut ticks = Vec::new();
        while !(ticks.len() > 100 && machine.controller.is_idle()) {
            if reading == Some(ticks.len()) {
                machine.put(&reading::encode(Some(READING_MM)));
            }
            machine.step();
            ticks.push((machine.now(), machine.segment()));
        }
        let trace = machine.take_trace();
        let lead = trace.pulses().next().unwrap().tick - 1;
        ticks.drain(..lead as usize);
        Self {
            pulses: Pulses::of_trace(&trace),
            lead,
            ticks,
        }
    }

    /// Time from tick to tick [ms].
    fn milliseconds(&self, from: u64, to: u64) -> f64 {
        let time = |tick: u64| trace::seconds(self.ticks[tick as usize].0);
        1e3 * (time(to) - time(from))
    }

    /// The first tick whose pulses are not those of `other`.
    #[track_caller]
    fn parts_from(&self, other: &Pulses) -> u64 {
        let (_, ours, theirs) = self.pulses.first_difference(other).expect("no trim seen");
        ours.into_iter()
            .chain(theirs)
            .map(|pulse| pulse.tick)
            .min()
            .unwrap()
    }

    /// What lies between the tick in which the reading's last byte came and the first pulse that it moved.
    #[track_caller]
    fn latency(&self, byte: u64, trimmed: &Pulses) -> Latency {
        let parts = self.parts_from(trimmed);
        assert!(parts > byte, "moved before it was read");
        // What the pins show was computed in the tick before.
        let segment = self.ticks[parts as usize - 1].1;
        let begin = self.ticks.partition_point(|tick| tick.1 < segment) as u64;
        Latency {
            pulse: self.milliseconds(byte, parts),
            segment: self.milliseconds(byte, begin),
        }
    }
}

/// [ms]
#[derive(Clone, Copy, Debug)]
struct Latency {
    /// To the first pulse that is not where it would have been without the reading.
    pulse: f64,
    /// To the begin of the segment that this pulse belongs to.
    segment: f64,
}

fn worst(latencies: &[Latency]) -> Latency {
    let most = |of: fn(&Latency) -> f64| latencies.iter().map(of).fold(0.0, f64::max);
    Latency {
        pulse: most(|latency| latency.pulse),
        segment: most(|latency| latency.segment),
    }
}

/// One reading in each of so many runs of the firmware in the emulator, each at another instant. What follows the
/// reading is held against memory too, to the end of the run.
fn in_the_emulator(octopus: &mut Octopus, readings: u64) -> Vec<Latency> {
    let plain = Run::plain(1);
    for line in settings() {
        octopus.ask(&line);
    }
    (0..readings)
        .map(|k| {
            octopus.ask(&follow(1));
            octopus.emulator.expect_idle(JOB).unwrap();
            octopus.emulator.take_recording();
            PATH.iter().for_each(|line| drop(octopus.ask(line)));
            // The emulator goes on while the bytes are on their way: when exactly they come is the computer's choice.
            octopus.wait_for_ticks(EARLIEST + k * 1_009 % 8_000);
            octopus
                .emulator
                .send_bytes(&reading::encode(Some(READING_MM)))
                .unwrap();
            octopus.wait_for_ticks(plain.ticks.len() as u64 + 10_000);
            octopus.emulator.expect_idle(JOB).unwrap();
            let recording = octopus.emulator.take_recording();
            let bytes = octopus.bytes_in_motion(&recording);
            let byte = *bytes.last().expect("came behind the motion");
            assert!(bytes.len() >= READING, "{bytes:?}");
            assert!(byte < LATEST, "the computer is too busy: tick {byte}");
            let pulses = recording.pulses();
            assert_as_in_memory(&plain, byte, &pulses);

            octopus.ask("$TRIM=0");
            octopus.emulator.expect_idle(JOB).unwrap();
            BACK.iter().for_each(|line| drop(octopus.ask(line)));
            octopus.emulator.expect_idle(JOB).unwrap();
            plain.latency(byte, &pulses)
        })
        .collect()
}

/// The foreground of memory takes a sample in the very tick that makes room for it, the firmware's some ticks later; a
/// reading that comes in between counts a sample earlier there.
#[track_caller]
fn assert_as_in_memory(plain: &Run, byte: u64, pulses: &Pulses) {
    const FOREGROUND: u64 = 40;
    let is_made = |at: u64| {
        let run = plain.trimmed(1, at);
        run.pulses.first_difference(pulses).is_none()
    };
    assert!(
        is_made(byte) || is_made(byte - FOREGROUND),
        "a reading behind tick {byte}: not the pulses of memory"
    );
}

/// A reading in each tick of `milliseconds`.
fn in_memory(period: u32, milliseconds: u64) -> Vec<Latency> {
    let plain = Run::plain(period);
    let middle = plain.ticks.len() as u64 / 2;
    (middle..middle + 100 * milliseconds)
        .map(|at| plain.latency(at, &plain.trimmed(period, at).pulses))
        .collect()
}

#[test]
fn a_reading_is_in_the_pulses_within_the_queue_and_two_segments_whenever_it_comes() {
    let worst = worst(&in_memory(1, 2));

    assert!(worst.segment > QUEUE, "{worst:?}: the queue is not 5 ms");
    assert!(worst.segment <= QUEUE + SEGMENT, "{worst:?}");
    assert!(worst.pulse <= QUEUE + 2.0 * SEGMENT, "{worst:?}");
}

#[test]
fn a_reading_waits_for_the_next_tick_of_its_stream_and_no_longer() {
    const PERIOD: u32 = 4;
    let waits = f64::from(PERIOD - 1) * SEGMENT;

    let worst = worst(&in_memory(PERIOD, 5));

    assert!(worst.segment > QUEUE + waits, "{worst:?}");
    assert!(worst.segment <= QUEUE + SEGMENT + waits, "{worst:?}");
}

#[test]
fn in_the_firmware_too_a_reading_is_in_the_pulses_within_the_queue_and_two_segments() {
    let Some(mut octopus) = Octopus::boot("latency") else {
        return;
    };

    let latencies = in_the_emulator(&mut octopus, 6);

    for latency in latencies {
        assert!(latency.segment > QUEUE - SEGMENT, "{latency:?}");
        assert!(latency.pulse <= QUEUE + 2.0 * SEGMENT, "{latency:?}");
    }
}

#[test]
#[ignore = "more than a minute in the emulator: run by cargo xtask bench"]
fn figure_of_the_latency() {
    let mut octopus = Octopus::boot("latency-figure").expect("HEXSTEP_FIRMWARE_OCTOPUS");

    let latencies = in_the_emulator(&mut octopus, 20);

    println!("trim_latency_ms {}", worst(&latencies).pulse);
}
