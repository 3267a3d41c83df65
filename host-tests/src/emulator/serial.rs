//! The emulated serial line: a unix socket on which QEMU calls.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::EmulatorError;
use super::process::Process;

/// How long QEMU may take to start and open the line.
const START: Duration = Duration::from_secs(30);

/// Where QEMU is to call, in the emulator's folder.
pub(super) const SERIAL_SOCKET: &str = "serial";

pub(super) struct Serial {
    stream: UnixStream,
    lines: Receiver<String>,
}

impl Serial {
    /// Opens the socket on which QEMU will call.
    pub(super) fn listen(folder: &Path) -> Result<UnixListener, EmulatorError> {
        let path = folder.join(SERIAL_SOCKET);
        UnixListener::bind(&path).map_err(|cause| EmulatorError::file(&path, cause))
    }

    /// Waits for QEMU's call.
    pub(super) fn accept(
        listener: &UnixListener,
        process: &mut Process,
    ) -> Result<Self, EmulatorError> {
        let line_error = |cause| EmulatorError::Line { cause };
        listener.set_nonblocking(true).map_err(line_error)?;
        let end = Instant::now() + START;
        let stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    process.check()?;
                    if Instant::now() > end {
                        return Err(EmulatorError::Timeout {
                            waited_for: "call from QEMU on its serial line".to_string(),
                            limit: START,
                            seen: Vec::new(),
                        });
                    }
                    thread::sleep(Duration::from_millis(5));
                }
                Err(cause) => return Err(line_error(cause)),
            }
        };
        stream.set_nonblocking(false).map_err(line_error)?;
        // A firmware that no longer reads must not block the test for ever.
        stream
            .set_write_timeout(Some(Duration::from_secs(30)))
            .map_err(line_error)?;
        let reader = stream.try_clone().map_err(line_error)?;
        let (sender, lines) = channel();
        thread::spawn(move || read_lines(reader, &sender));
        Ok(Self { stream, lines })
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<(), EmulatorError> {
        self.stream
            .write_all(bytes)
            .map_err(|cause| EmulatorError::Line { cause })
    }

    pub(super) fn next_line(&mut self, limit: Duration) -> Result<String, EmulatorError> {
        self.lines.recv_timeout(limit).map_err(|error| match error {
            RecvTimeoutError::Timeout => EmulatorError::Timeout {
                waited_for: "line".to_string(),
                limit,
                seen: Vec::new(),
            },
            RecvTimeoutError::Disconnected => EmulatorError::Line {
                cause: ErrorKind::UnexpectedEof.into(),
            },
        })
    }
}

/// Splits what comes into lines at CR LF until the line closes. Empty lines are left out.
fn read_lines(mut reader: UnixStream, lines: &Sender<String>) {
    let mut pending = Vec::new();
    let mut buffer = [0; 4096];
    while let Ok(count @ 1..) = reader.read(&mut buffer) {
        for &byte in buffer.iter().take(count) {
            match byte {
                b'\n' => {
                    let line = String::from_utf8_lossy(&pending).into_owned();
                    pending.clear();
                    if !line.is_empty() && lines.send(line).is_err() {
                        return;
                    }
                }
                b'\r' => {}
                other => pending.push(other),
            }
        }
    }
}
