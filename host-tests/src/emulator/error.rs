//! Why the emulator could not do what a test asked for.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What went wrong, in terms of the emulator.
#[derive(Debug)]
pub enum EmulatorError {
    /// A program that is needed is not installed.
    Missing {
        program: &'static str,
        /// How to install it on Debian.
        remedy: &'static str,
    },
    /// A file cannot be read, written or created.
    File { path: PathBuf, cause: io::Error },
    /// The file is not an ELF of the target.
    NotFirmware { path: PathBuf, reason: &'static str },
    /// The ELF has no symbol of this name.
    NoSymbol { name: String },
    /// The C compiler refused the plugin.
    Compiler { output: String },
    /// QEMU did not do what the debugger asked for.
    Debugger { answer: String },
    /// The serial line broke.
    Line { cause: io::Error },
    /// What was waited for did not come in time.
    Timeout {
        waited_for: String,
        limit: Duration,
        /// The lines that came instead.
        seen: Vec<String>,
    },
    /// QEMU ended by itself.
    Ended {
        /// Its exit status in words.
        status: String,
        /// The last that it said.
        said: String,
    },
}

impl EmulatorError {
    pub(crate) fn file(path: &Path, cause: io::Error) -> Self {
        Self::File {
            path: path.to_path_buf(),
            cause,
        }
    }
}

impl fmt::Display for EmulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { program, remedy } => {
                write!(f, "`{program}` is not installed; {remedy}")
            }
            Self::File { path, cause } => write!(f, "{}: {cause}", path.display()),
            Self::NotFirmware { path, reason } => {
                write!(f, "{}: not a firmware image: {reason}", path.display())
            }
            Self::NoSymbol { name } => write!(f, "the firmware has no function `{name}`"),
            Self::Compiler { output } => write!(f, "the C compiler refused the plugin:\n{output}"),
            Self::Debugger { answer } => write!(f, "the debugger's request was answered {answer}"),
            Self::Line { cause } => write!(f, "the emulator's serial line broke: {cause}"),
            Self::Timeout {
                waited_for,
                limit,
                seen,
            } => {
                write!(f, "no {waited_for} within {} s", limit.as_secs_f32())?;
                match seen.as_slice() {
                    [] => write!(f, "; the firmware said nothing"),
                    lines => {
                        write!(f, "; {} other lines came, the last:", lines.len())?;
                        for line in lines.iter().rev().take(10).rev() {
                            write!(f, "\n    {line}")?;
                        }
                        Ok(())
                    }
                }
            }
            Self::Ended { status, said } => write!(f, "the emulator ended ({status}): {said}"),
        }
    }
}

impl std::error::Error for EmulatorError {}
