//! The QEMU process: its command line, its log, its end.

use std::io::{BufRead, BufReader, ErrorKind};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::serial::SERIAL_SOCKET;
use super::{Elf, EmulatorError, Options, Recording, elf};

pub const QEMU: &str = "qemu-system-arm";
const REMEDY: &str = "on Debian: apt-get install qemu-system-arm";
/// Where QEMU waits for a debugger, in the emulator's folder.
pub(super) const DEBUGGER_SOCKET: &str = "debugger";
/// Lines of QEMU's own that are kept for error messages.
const KEPT_LINES: usize = 20;

pub(super) struct Process {
    child: Child,
    reader: Option<JoinHandle<()>>,
    said: Arc<Mutex<Vec<String>>>,
}

/// Major version of the installed QEMU.
pub fn qemu_version() -> Result<u32, EmulatorError> {
    let missing = || EmulatorError::Missing {
        program: QEMU,
        remedy: REMEDY,
    };
    let output = Command::new(QEMU)
        .arg("--version")
        .output()
        .map_err(|_| missing())?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.split_whitespace()
        .skip_while(|word| *word != "version")
        .nth(1)
        .and_then(|version| version.split('.').next()?.parse().ok())
        .ok_or_else(missing)
}

impl Process {
    /// Starts QEMU on `options.firmware`; the log is read into `recording` from now on.
    pub(super) fn start(
        options: &Options,
        elf: &Elf,
        folder: &Path,
        recording: Arc<Mutex<Recording>>,
    ) -> Result<Self, EmulatorError> {
        // Both machines carry the STM32F405; the older one lost its RAM size in later versions.
        let machine = if qemu_version()? < 10 {
            "netduinoplus2"
        } else {
            "olimex-stm32-h405"
        };
        // `timeout` ends QEMU even when this process is killed, and with SIGKILL when it hangs.
        let mut command = Command::new("timeout");
        command
            .arg("--kill-after=1")
            .arg(options.lifetime.as_secs().max(1).to_string())
            .arg(QEMU)
            .args(["-M", machine, "-display", "none", "-monitor", "none"])
            // Without instruction counting the emulated time is off by orders of magnitude.
            .args(["-icount", "shift=3,sleep=off"])
            .arg("-chardev")
            .arg(format!(
                "socket,id=line,path={},server=off",
                folder.join(SERIAL_SOCKET).display()
            ))
            .args(["-serial", "chardev:line"])
            .arg("-serial")
            .arg(match &options.log {
                Some(path) => format!("file:{}", path.display()),
                None => "null".to_string(),
            })
            .arg("-chardev")
            .arg(format!(
                "socket,id=debugger,path={},server=on,wait=off",
                folder.join(DEBUGGER_SOCKET).display()
            ))
            .args(["-gdb", "chardev:debugger"])
            .arg("-kernel")
            .arg(&options.firmware);
        if elf.flash_start() != elf::FLASH_START {
            command
                .arg("-global")
                .arg(format!("armv7m.init-nsvtor={:#x}", elf.flash_start()));
        }
        match &options.counter {
            Some(counter) => {
                command.args(["-d", "unimp,plugin"]);
                command.arg("-plugin").arg(counter.argument(elf)?);
            }
            None => {
                command.args(["-d", "unimp"]);
            }
        }
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| match error.kind() {
                ErrorKind::NotFound => EmulatorError::Missing {
                    program: "timeout",
                    remedy: "it is part of GNU coreutils",
                },
                _ => EmulatorError::Line { cause: error },
            })?;
        let said = Arc::new(Mutex::new(Vec::new()));
        let reader = child.stderr.take().map(|log| {
            let said = Arc::clone(&said);
            thread::spawn(move || read_log(log, &recording, &said))
        });
        Ok(Self {
            child,
            reader,
            said,
        })
    }

    /// An error if QEMU has ended.
    pub(super) fn check(&mut self) -> Result<(), EmulatorError> {
        match self.child.try_wait() {
            Ok(Some(status)) => Err(EmulatorError::Ended {
                status: status.to_string(),
                said: self.said(),
            }),
            _ => Ok(()),
        }
    }

    /// Ends QEMU and waits until its log has been read to the end.
    pub(super) fn end(&mut self) -> Result<(), EmulatorError> {
        self.stop();
        if let Some(reader) = self.reader.take() {
            // The thread cannot panic; if it did, there is a recording up to there.
            let _ = reader.join();
        }
        Ok(())
    }

    /// Asks `timeout` to end QEMU, which it does within a second.
    fn stop(&mut self) {
        let end = Instant::now() + Duration::from_secs(5);
        let id = self.child.id().to_string();
        // The standard library can only send SIGKILL, which would leave QEMU behind.
        let _ = Command::new("sh")
            .args(["-c", "kill -TERM \"$0\" 2>/dev/null", &id])
            .status();
        while Instant::now() < end {
            match self.child.try_wait() {
                Ok(None) => thread::sleep(Duration::from_millis(5)),
                _ => return,
            }
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Adds the end of QEMU, if it has come, to an error of the line.
    pub(super) fn explain(&self, error: EmulatorError) -> EmulatorError {
        match error {
            EmulatorError::Line { cause } => EmulatorError::Ended {
                status: cause.to_string(),
                said: self.said(),
            },
            other => other,
        }
    }

    fn said(&self) -> String {
        match self.said.lock() {
            Ok(said) => said.join("\n"),
            Err(poisoned) => poisoned.into_inner().join("\n"),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if !matches!(self.child.try_wait(), Ok(Some(_))) {
            self.stop();
        }
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

/// Pause between two looks at the log. QEMU writes some 40 lines in it, of the 800 that the pipe holds; waking up for each
/// of them would take both sides more time than all the rest.
const PAUSE: Duration = Duration::from_millis(1);

/// Reads QEMU's log until it ends: stores to pins and counts into `recording`, QEMU's own words into `said`.
fn read_log(log: ChildStderr, recording: &Mutex<Recording>, said: &Mutex<Vec<String>>) {
    let mut log = BufReader::with_capacity(1 << 16, log);
    let mut line = Vec::with_capacity(128);
    while matches!(log.fill_buf(), Ok([_, ..])) {
        // One lock for all lines that are there; none while waiting for the next.
        let Ok(mut recording) = recording.lock() else {
            return;
        };
        while !log.buffer().is_empty() {
            line.clear();
            if log.read_until(b'\n', &mut line).is_err() {
                return;
            }
            if !recording.read_line(&line)
                && let Ok(mut said) = said.lock()
            {
                said.push(String::from_utf8_lossy(&line).trim_end().to_string());
                let surplus = said.len().saturating_sub(KEPT_LINES);
                said.drain(..surplus);
            }
        }
        drop(recording);
        thread::sleep(PAUSE);
    }
}
