//! The firmware's own ELF, booted in QEMU: lines in and out, and every store to the step and direction pins.
//!
//! ```text
//! test -- line --> unix socket --> USART1 --> firmware --> stores to GPIO
//!   ^                                                        |  QEMU's log of unimplemented devices
//!   '-- trace: levels and directions, tick by tick <-- pins <-'
//! ```
//!
//! The chip's GPIO blocks are no devices of QEMU's machine; it logs each store to them with its value and in order.
//! The log is read while it is written, so nothing grows on the disk. The instruction counter (`counter.rs`), a
//! plugin of QEMU's translator, writes one line for each return of a watched function into the same log, so both
//! are in one order.
//!
//! Time in the emulator is instructions (`-icount`), so every run of the same bytes is the same, but what reaches the
//! serial line is paced by the host: compare pulses relative to the first edge.
//!
//! Nothing here waits without a limit, and the emulator is ended when its owner goes, or by its own time limit when
//! the whole test was killed.

pub mod counter;
pub mod debugger;
pub mod elf;
pub mod error;
pub mod pins;
mod process;
mod serial;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

pub use counter::{Counter, Tally};
pub use debugger::{Debugger, Register};
pub use elf::Elf;
pub use error::EmulatorError;
pub use pins::{Change, OCTOPUS, PinMap, Pulse, Pulses, Recording, SKR_PRO};

use process::Process;
use serial::Serial;

/// What to boot and what to watch.
#[derive(Clone, Debug)]
pub struct Options {
    pub firmware: PathBuf,
    /// Which pins are whose.
    pub pins: PinMap,
    /// Counts the instructions of these functions; `None` runs without the plugin.
    pub counter: Option<Counter>,
    /// Where the frames of USART2 go; nowhere if `None`.
    pub log: Option<PathBuf>,
    /// The emulator ends itself after this time, whatever happens to its owner.
    pub lifetime: Duration,
}

impl Options {
    /// Boots `firmware`, watches the pins of the SKR Pro, counts nothing, lives for twenty minutes at most.
    pub fn new(firmware: impl Into<PathBuf>) -> Self {
        Self {
            firmware: firmware.into(),
            pins: SKR_PRO,
            counter: None,
            log: None,
            lifetime: Duration::from_secs(20 * 60),
        }
    }
}

/// The firmware to test as named by the environment variable `HEXSTEP_FIRMWARE`; `None` when that is not set.
pub fn firmware_from_environment() -> Option<PathBuf> {
    std::env::var_os("HEXSTEP_FIRMWARE").map(PathBuf::from)
}

/// The same firmware, linked behind the board's bootloader: `HEXSTEP_FIRMWARE_BOOTLOADER`.
pub fn image_from_environment() -> Option<PathBuf> {
    std::env::var_os("HEXSTEP_FIRMWARE_BOOTLOADER").map(PathBuf::from)
}

/// The firmware for a six-axis arm: `HEXSTEP_FIRMWARE_ARM`.
pub fn arm_from_environment() -> Option<PathBuf> {
    std::env::var_os("HEXSTEP_FIRMWARE_ARM").map(PathBuf::from)
}

/// The firmware for the Octopus with its eight motors: `HEXSTEP_FIRMWARE_OCTOPUS`.
pub fn octopus_from_environment() -> Option<PathBuf> {
    std::env::var_os("HEXSTEP_FIRMWARE_OCTOPUS").map(PathBuf::from)
}

/// Time for one answer on a busy computer.
const ANSWER: Duration = Duration::from_secs(30);

/// A running emulator. Ends with this value.
pub struct Emulator {
    serial: Serial,
    recording: Arc<Mutex<Recording>>,
    process: Process,
    /// The sockets.
    folder: TemporaryFolder,
}

impl Emulator {
    /// Boots the firmware. Returns once QEMU has opened the serial line; the banner may still be to come.
    pub fn boot(options: &Options) -> Result<Self, EmulatorError> {
        let elf = Elf::read(&options.firmware)?;
        let folder = TemporaryFolder::create()?;
        let listener = Serial::listen(folder.path())?;
        let mut recording = Recording::new(options.pins);
        recording.watch(options.counter.as_ref());
        let recording = Arc::new(Mutex::new(recording));
        let mut process = Process::start(options, &elf, folder.path(), Arc::clone(&recording))?;
        let serial = Serial::accept(&listener, &mut process)?;
        Ok(Self {
            serial,
            recording,
            process,
            folder,
        })
    }

    /// Sends `line` and a line end.
    pub fn send(&mut self, line: &str) -> Result<(), EmulatorError> {
        self.serial.send(format!("{line}\n").as_bytes())
    }

    /// Sends bytes as they are, for real-time commands and for bad input.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> Result<(), EmulatorError> {
        self.serial.send(bytes)
    }

    /// The next line the firmware sends, without its end.
    pub fn next_line(&mut self, limit: Duration) -> Result<String, EmulatorError> {
        self.serial
            .next_line(limit)
            .map_err(|error| self.explain(error))
    }

    /// Lines up to and including the first that `is_wanted` accepts; `what` names it in the error.
    pub fn expect(
        &mut self,
        what: &str,
        limit: Duration,
        is_wanted: impl Fn(&str) -> bool,
    ) -> Result<Vec<String>, EmulatorError> {
        let end = Instant::now() + limit;
        let mut lines = Vec::new();
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self.serial.next_line(left) {
                Ok(line) => {
                    let found = is_wanted(&line);
                    lines.push(line);
                    if found {
                        return Ok(lines);
                    }
                }
                Err(EmulatorError::Timeout { .. }) => {
                    let error = EmulatorError::Timeout {
                        waited_for: what.to_string(),
                        limit,
                        seen: lines,
                    };
                    return Err(self.explain(error));
                }
                Err(error) => return Err(self.explain(error)),
            }
        }
    }

    /// Waits for the start-up banner; the lines before it and itself.
    pub fn expect_banner(&mut self) -> Result<Vec<String>, EmulatorError> {
        self.expect("banner `Grbl ...`", ANSWER, |line| {
            line.starts_with("Grbl ")
        })
    }

    /// Sends `line` and waits for its answer, `ok` or `error:...`; all lines up to and including it.
    pub fn ask(&mut self, line: &str, limit: Duration) -> Result<Vec<String>, EmulatorError> {
        self.send(line)?;
        self.expect(&format!("answer to {line:?}"), limit, |answer| {
            answer == "ok" || answer.starts_with("error:")
        })
    }

    /// Asks for a status report and waits for it.
    pub fn status(&mut self, limit: Duration) -> Result<String, EmulatorError> {
        self.send_bytes(b"?")?;
        let lines = self.expect("status report `<...>`", limit, |line| {
            line.starts_with('<') && line.ends_with('>')
        })?;
        Ok(lines.last().cloned().unwrap_or_default())
    }

    /// Asks for status reports until one starts with `<Idle`; that report.
    pub fn expect_idle(&mut self, limit: Duration) -> Result<String, EmulatorError> {
        let end = Instant::now() + limit;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let report = self.status(ANSWER)?;
            if report.starts_with("<Idle") {
                return Ok(report);
            }
            if left.is_zero() {
                return Err(self.explain(EmulatorError::Timeout {
                    waited_for: "status `<Idle`".to_string(),
                    limit,
                    seen: vec![report],
                }));
            }
            std::thread::sleep(Duration::from_millis(50).min(left));
        }
    }

    /// What the pins have done so far; the recording starts anew, at the levels where it stands.
    ///
    /// Only what QEMU has logged by now is in it: ask for a status report first, then all stores made before the
    /// report was sent are.
    pub fn take_recording(&self) -> Recording {
        match self.recording.lock() {
            Ok(mut recording) => recording.take(),
            Err(poisoned) => poisoned.into_inner().take(),
        }
    }

    /// Waits until `is_reached` holds of the recording; `what` names it in the error.
    pub fn wait_for(
        &self,
        what: &str,
        limit: Duration,
        is_reached: impl Fn(&Recording) -> bool,
    ) -> Result<(), EmulatorError> {
        let end = Instant::now() + limit;
        loop {
            let reached = match self.recording.lock() {
                Ok(recording) => is_reached(&recording),
                Err(poisoned) => is_reached(&poisoned.into_inner()),
            };
            if reached {
                return Ok(());
            }
            if Instant::now() > end {
                return Err(self.explain(EmulatorError::Timeout {
                    waited_for: what.to_string(),
                    limit,
                    seen: Vec::new(),
                }));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Stops the core, to be looked at or broken; it runs again when the debugger goes.
    pub fn debug(&self) -> Result<Debugger, EmulatorError> {
        Debugger::attach(&self.folder.path().join(process::DEBUGGER_SOCKET))
    }

    /// Ends the emulator; its recording, complete to the last store.
    pub fn finish(mut self) -> Result<Recording, EmulatorError> {
        self.process.end()?;
        Ok(self.take_recording())
    }

    /// Adds what QEMU itself said to an error.
    fn explain(&self, error: EmulatorError) -> EmulatorError {
        self.process.explain(error)
    }
}

/// A directory of its own that goes with this value.
pub(crate) struct TemporaryFolder(PathBuf);

impl TemporaryFolder {
    pub(crate) fn create() -> Result<Self, EmulatorError> {
        use std::sync::atomic::{AtomicU32, Ordering};
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("hexstep-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|cause| EmulatorError::file(&path, cause))?;
        Ok(Self(path))
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // Nothing is left to do about a folder that cannot be removed.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
