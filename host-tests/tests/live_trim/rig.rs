//! The Octopus's firmware in the emulator with a look at its serial interrupt, and lines said to it and to memory alike.

use hexstep_host::emulator::counter::SERIAL_INTERRUPT;
use hexstep_host::emulator::{
    Counter, Emulator, OCTOPUS, Options, Recording, octopus_from_environment,
};
use hexstep_host::machine::{self, Machine};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// For a job of some seconds of machine time on a busy computer.
pub const JOB: Duration = Duration::from_secs(300);
/// The emulator has no crystal, so the firmware must be told that it may move all the same.
pub const ALLOW: &str = "$1012=1";
/// Bytes of a reading.
pub const READING: usize = 9;

/// A two-sided machine in memory, X Y Z B twice.
pub fn eight<R>(body: impl FnOnce(&mut Machine<'_, 8>) -> R) -> R {
    machine::with_motors(|machine| {
        machine.ask("");
        body(machine)
    })
}

/// The firmware that listens.
pub struct Octopus {
    pub emulator: Emulator,
    /// Number of the serial interrupt among the watched functions.
    serial: usize,
}

impl Octopus {
    /// Boots what the environment names; `None`, and a word to the reader, if it names nothing. `name` is the test's own.
    #[track_caller]
    pub fn boot(name: &str) -> Option<Self> {
        let Some(firmware) = octopus_from_environment() else {
            // Straight to standard error: what a passing test prints is not shown otherwise.
            let _ = writeln!(
                std::io::stderr(),
                "not run in the emulator: HEXSTEP_FIRMWARE_OCTOPUS names no firmware; `cargo xtask test` builds it and runs this test"
            );
            return None;
        };
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let mut counter = Counter::build(&folder).unwrap();
        let serial = counter.watch(SERIAL_INTERRUPT);
        let mut options = Options::new(firmware);
        options.pins = OCTOPUS;
        options.counter = Some(counter);
        let mut emulator = Emulator::boot(&options).unwrap();
        emulator.expect_banner().unwrap();
        let mut octopus = Self { emulator, serial };
        octopus.ask(ALLOW);
        Some(octopus)
    }

    /// Says a line, which must be taken; what was told before its answer.
    #[track_caller]
    pub fn ask(&mut self, line: &str) -> Vec<String> {
        let mut lines = self.emulator.ask(line, JOB).unwrap();
        assert_eq!(lines.pop().as_deref(), Some("ok"), "{line}");
        lines
    }

    /// Waits until the recording has so many ticks behind its first step.
    #[track_caller]
    pub fn wait_for_ticks(&self, ticks: u64) {
        self.emulator
            .wait_for("so many ticks of motion", JOB, |recording| {
                let motion = recording.motion();
                !motion.is_empty() && recording.ticks() > motion.start + ticks
            })
            .unwrap();
    }

    /// Ticks in which bytes have arrived from the first step to the last, counted from the first.
    pub fn bytes_in_motion(&self, recording: &Recording) -> Vec<u64> {
        let motion = recording.motion();
        let ends = recording.ends(self.serial).iter();
        ends.filter(|tick| motion.contains(*tick))
            .map(|tick| tick - motion.start)
            .collect()
    }
}
