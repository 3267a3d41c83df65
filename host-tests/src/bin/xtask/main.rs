//! `cargo xtask`: build, flash, test and measure the firmware.

mod bench;
mod board;
mod build;
mod duel;
mod figures;
mod flash;
mod install;
mod run;
mod test;

use board::Board;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Build, flash, test and measure the firmware.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build the firmware for a board; print flash and RAM use.
    Build {
        #[arg(long, value_enum)]
        board: Board,
        /// Leave room for the board's bootloader and write the image that it loads (firmware.bin).
        #[arg(long)]
        bootloader: bool,
    },
    /// Build the firmware and write it into a board with probe-rs, st-flash or openocd.
    Flash {
        #[arg(long, value_enum)]
        board: Board,
        /// Keep the board's bootloader, write the image behind it.
        #[arg(long)]
        bootloader: bool,
    },
    /// Format, lints, documentation, all tests, and the firmware itself in the emulator.
    ///
    /// Installs what is missing: the Rust target with rustup, and, as root on Debian, qemu-system-arm and gcc. Otherwise
    /// it says which command does. CI runs this.
    Test,
    /// Measure the figures of the project beside their goals; also written to target/hexstep/bench.json.
    ///
    /// Instructions are counted in the emulator on the firmware's own code and do not depend on the machine; cycles are
    /// a model; ticks per second are this machine's.
    Bench {
        #[arg(long, value_enum, default_value_t = Board::SkrPro)]
        board: Board,
        /// Only the functions counted in the bench program; writes no file.
        #[arg(long)]
        functions: bool,
    },
    /// Run the paths of the motion duel on the machine in memory; print times, limits, distances and ripple, judged from
    /// the pulses, beside goals, bounds and other controllers; also written to target/hexstep/duel.json.
    Duel {
        #[command(flatten)]
        request: duel::Request,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Build { board, bootloader } => build::task(board, bootloader),
        Task::Flash { board, bootloader } => flash::task(board, bootloader),
        Task::Test => test::task(),
        Task::Bench { board, functions } => bench::task(board, functions),
        Task::Duel { request } => duel::task(&request),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error}");
            ExitCode::FAILURE
        }
    }
}
