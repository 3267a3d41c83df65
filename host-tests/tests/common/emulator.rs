//! A firmware in the emulator beside the machine in memory: the same lines to both, the same pulses from both.

use super::pulses_of_lines;
use hexstep::joints::whole_steps;
use hexstep::path::Target;
use hexstep::settings::Settings;
use hexstep_host::emulator::{Emulator, Options, PinMap, Pulses};
use hexstep_host::lines::{move_lines, setting_lines};
use hexstep_host::machine::{self, Machine};
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

/// The emulator has no crystal, so the firmware must be told that it may move all the same.
pub const ALLOW: &str = "$1012=1";
/// For a job of some seconds of machine time on a busy computer.
pub const JOB: Duration = Duration::from_secs(900);

/// Straight to standard error: what a passing test prints is not shown otherwise.
pub fn say_not_run(variable: &str) {
    let _ = writeln!(
        std::io::stderr(),
        "not run in the emulator: {variable} names no firmware; `cargo xtask test` builds it and runs this test"
    );
}

#[track_caller]
pub fn boot(firmware: PathBuf, pins: PinMap) -> Emulator {
    let mut options = Options::new(firmware);
    options.pins = pins;
    let mut emulator = Emulator::boot(&options).unwrap();
    emulator.expect_banner().unwrap();
    emulator
}

/// Boots a firmware that may move.
#[track_caller]
pub fn boot_for_motion(firmware: PathBuf, pins: PinMap) -> Emulator {
    let mut emulator = boot(firmware, pins);
    assert_eq!(ask(&mut emulator, ALLOW), ["ok"]);
    emulator
}

/// The answer to a line, without what was said of itself before.
#[track_caller]
pub fn ask(emulator: &mut Emulator, line: &str) -> Vec<String> {
    let mut lines = emulator.ask(line, JOB).unwrap();
    lines.retain(|line| !line.starts_with('<') && !line.starts_with("[MSG:Clock fault: "));
    lines
}

/// Every line to both machines; the pulses of both.
#[track_caller]
pub fn on_both<const N: usize>(
    machine: &mut Machine<'_, N>,
    emulator: &mut Emulator,
    lines: &[String],
) -> (Pulses, Pulses) {
    machine.take_trace();
    emulator.take_recording();
    let wanted = pulses_of_lines(machine, lines);
    for line in lines {
        assert_eq!(ask(emulator, line), ["ok"], "{line}");
    }
    emulator.expect_idle(JOB).unwrap();
    (wanted, emulator.take_recording().pulses())
}

/// Gives both machines these settings and runs targets on both, each stretch of them to rest: the same pulses, edge for edge,
/// and motors where the last target has them. How many edges there were.
#[track_caller]
pub fn assert_equal_stretches<const N: usize>(
    name: &str,
    emulator: &mut Emulator,
    settings: &Settings<N>,
    stretches: &[&[Target<N>]],
) -> usize {
    machine::with_motors::<N, _>(|machine| {
        machine.ask(ALLOW);
        for line in setting_lines(settings) {
            assert!(machine.ask(&line).ends_with("ok\r\n"), "{name}: {line}");
            assert_eq!(ask(emulator, &line), ["ok"], "{name}: {line}");
        }
        let mut edges = 0;
        for stretch in stretches {
            let lines = move_lines(stretch);
            let (wanted, pulses) = on_both(machine, emulator, &lines);
            let difference = wanted.first_difference(&pulses);
            assert_eq!(
                difference, None,
                "{name}: change, as in memory, as in the emulator"
            );
            edges += wanted.len();
        }
        assert_eq!(machine.starved(), 0, "{name}");
        let last = stretches.last().and_then(|stretch| stretch.last());
        let end = whole_steps(&last.unwrap().steps);
        assert_eq!(machine.controller.counts(), end, "{name}");
        assert_eq!(ask(emulator, "$STAT"), ["[MSG:starved 0]", "ok"], "{name}");
        edges
    })
}

/// The targets that `seconds` of the least times hold, the one that ends beyond them included.
pub fn within<const N: usize>(targets: &[Target<N>], seconds: f32) -> &[Target<N>] {
    let mut left = seconds;
    let begun = targets.iter().take_while(|target| {
        let fits = left > 0.0;
        left -= target.duration;
        fits
    });
    let count = begun.count();
    &targets[..count]
}
