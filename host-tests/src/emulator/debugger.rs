//! The little of the GDB remote protocol that is needed to break a running program on purpose.
//!
//! A packet is `$data#checksum`, two hexadecimal digits, and is answered by `+` and, but for a continue, by a packet.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use super::EmulatorError;

/// Registers by their numbers in the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    StackPointer = 13,
    ProgramCounter = 15,
}

/// A connection that holds the core; it runs again when this value goes.
pub struct Debugger {
    stream: UnixStream,
}

impl Debugger {
    /// Stops the core.
    pub(super) fn attach(socket: &Path) -> Result<Self, EmulatorError> {
        let failed = |cause| EmulatorError::Line { cause };
        let stream = UnixStream::connect(socket).map_err(failed)?;
        stream
            .set_read_timeout(Some(Duration::from_secs(30)))
            .map_err(failed)?;
        let mut debugger = Self { stream };
        debugger.ask("?")?;
        // QEMU takes single registers only from who has asked how they are numbered.
        debugger.ask("qXfer:features:read:target.xml:0,fff")?;
        Ok(debugger)
    }

    /// Sets a register of the stopped core.
    pub fn set(&mut self, register: Register, value: u32) -> Result<(), EmulatorError> {
        let bytes: String = value
            .to_le_bytes()
            .map(|byte| format!("{byte:02x}"))
            .concat();
        match self
            .ask(&format!("P{:x}={bytes}", register as u8))?
            .as_str()
        {
            "OK" => Ok(()),
            other => Err(EmulatorError::Debugger {
                answer: other.to_string(),
            }),
        }
    }

    /// The answer to a request. That the core has stopped is also told without having been asked; it is left out.
    fn ask(&mut self, request: &str) -> Result<String, EmulatorError> {
        self.send(request)?;
        loop {
            let answer = self.answer()?;
            if request == "?" || !answer.starts_with('T') {
                return Ok(answer);
            }
        }
    }

    fn answer(&mut self) -> Result<String, EmulatorError> {
        let mut answer = Vec::new();
        let mut byte = [0];
        // Everything before `$` acknowledges what was sent.
        loop {
            self.stream
                .read_exact(&mut byte)
                .map_err(|cause| EmulatorError::Line { cause })?;
            match byte[0] {
                b'$' => answer.clear(),
                b'#' => break,
                other => answer.push(other),
            }
        }
        self.stream
            .read_exact(&mut [0; 2])
            .and_then(|()| self.stream.write_all(b"+"))
            .map_err(|cause| EmulatorError::Line { cause })?;
        Ok(String::from_utf8_lossy(&answer).into_owned())
    }

    fn send(&mut self, request: &str) -> Result<(), EmulatorError> {
        let sum = request.bytes().fold(0u8, u8::wrapping_add);
        self.stream
            .write_all(format!("${request}#{sum:02x}").as_bytes())
            .map_err(|cause| EmulatorError::Line { cause })
    }
}

impl Drop for Debugger {
    fn drop(&mut self) {
        // Detaching lets the core run; if it fails, the emulator is gone already.
        let _ = self.ask("D");
    }
}
