//! Instruction counts: the translator plugin (`host-tests/emulator/counter.c`), built here and loaded into QEMU.
//!
//! For each return of a watched function it logs `cost <function> <instructions> <cycles>`. Instructions are counted;
//! **cycles are a model**: arithmetic 1, load 2 (1 right behind another load), store 1, multiple load or store 1 + N,
//! taken branch + 2, and for an interrupt 12 to enter and 12 to leave.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::process::qemu_version;
use super::{Elf, EmulatorError};

/// The handler of the step interrupt, as the vector table names it.
pub const STEP_INTERRUPT: &str = "SysTick";
/// The handler of the serial line's interrupt: one call for each byte that arrives.
pub const SERIAL_INTERRUPT: &str = "USART1";
/// Cycles to enter and to leave an interrupt; part of the model.
pub const INTERRUPT_CYCLES: u32 = 12 + 12;

/// One call of a watched function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    pub instructions: u32,
    /// By the model; for the step interrupt with entry and exit.
    pub cycles: u32,
}

/// All calls of a watched function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    pub calls: u64,
    pub instructions: u64,
    pub cycles: u64,
    /// The call with the most instructions.
    pub worst: Cost,
}

impl Tally {
    pub(super) fn add(&mut self, cost: Cost) {
        self.calls += 1;
        self.instructions += u64::from(cost.instructions);
        self.cycles += u64::from(cost.cycles);
        self.worst.instructions = self.worst.instructions.max(cost.instructions);
        self.worst.cycles = self.worst.cycles.max(cost.cycles);
    }

    /// The tally of `costs`.
    pub fn of(costs: &[Cost]) -> Self {
        let mut tally = Self::default();
        for cost in costs {
            tally.add(*cost);
        }
        tally
    }

    /// Mean instructions a call; NaN without calls.
    pub fn mean_instructions(&self) -> f64 {
        self.instructions as f64 / self.calls as f64
    }

    /// Mean model cycles a call; NaN without calls.
    pub fn mean_cycles(&self) -> f64 {
        self.cycles as f64 / self.calls as f64
    }
}

/// The built plugin and the functions it watches.
#[derive(Clone, Debug)]
pub struct Counter {
    plugin: PathBuf,
    /// Watched functions; the first is the step interrupt.
    pub(super) functions: Vec<String>,
}

impl Counter {
    /// Compiles the plugin into `folder` and watches the step interrupt.
    pub fn build(folder: &Path) -> Result<Self, EmulatorError> {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("emulator/counter.c");
        let plugin = folder.join("counter.so");
        std::fs::create_dir_all(folder).map_err(|cause| EmulatorError::file(folder, cause))?;
        // QEMU 10 refuses plugins of interface version 1, QEMU 7.2 all others.
        let version = if qemu_version()? < 10 { 1 } else { 4 };
        let output = Command::new("cc")
            .args(["-O2", "-Wall", "-Wextra", "-shared", "-fPIC"])
            .arg(format!("-DPLUGIN_VERSION={version}"))
            .arg("-o")
            .arg(&plugin)
            .arg(&source)
            .output()
            .map_err(|_| EmulatorError::Missing {
                program: "cc",
                remedy: "on Debian: apt-get install gcc libc6-dev",
            })?;
        if !output.status.success() {
            return Err(EmulatorError::Compiler {
                output: String::from_utf8_lossy(&output.stderr).into_owned(),
            });
        }
        Ok(Self {
            plugin,
            functions: vec![STEP_INTERRUPT.to_string()],
        })
    }

    /// Also watches `function`; its number in [`Recording::tally`](super::Recording::tally).
    pub fn watch(&mut self, function: &str) -> usize {
        self.functions.push(function.to_string());
        self.functions.len() - 1
    }

    /// QEMU's argument: the plugin and the addresses of the watched functions in `elf`.
    pub(super) fn argument(&self, elf: &Elf) -> Result<String, EmulatorError> {
        let mut argument = self.plugin.display().to_string();
        for function in &self.functions {
            // An image without the step interrupt has other functions to watch.
            let address = match elf.function(function) {
                Ok(address) => address,
                Err(_) if function == STEP_INTERRUPT => 0,
                Err(error) => return Err(error),
            };
            argument += &format!(",watch={address:#x}");
        }
        Ok(argument)
    }
}
