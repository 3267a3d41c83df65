//! Everything a change must pass.

use super::board::Board;
use super::build::{FIRMWARE, TARGET, firmware};
use super::install;
use super::run::{Outcome, cargo, run};
use std::process::Command;
use std::time::Instant;

pub fn task() -> Outcome<()> {
    install::everything()?;
    let elf = firmware(Board::SkrPro, FIRMWARE, false)?;
    let behind_bootloader = firmware(Board::SkrPro, FIRMWARE, true)?;
    let arm = firmware(Board::SkrProArm, FIRMWARE, false)?;
    let octopus = firmware(Board::Octopus, FIRMWARE, false)?;

    let mut failed = Vec::new();
    let mut step = |name: &'static str, command: &mut Command| {
        println!("\n== {name}");
        let start = Instant::now();
        let result = run(command);
        println!(
            "== {name}: {} ({:.0} s)",
            if result.is_ok() { "passed" } else { "FAILED" },
            start.elapsed().as_secs_f32()
        );
        if result.is_err() {
            failed.push(name);
        }
    };
    step("format", cargo().args(["fmt", "--all", "--", "--check"]));
    step(
        "lints, host",
        cargo().args([
            "clippy",
            "--workspace",
            "--all-targets",
            "--",
            "-D",
            "warnings",
        ]),
    );
    for (name, board) in [
        ("lints, target", Board::SkrPro),
        ("lints, target in an arm", Board::SkrProArm),
        ("lints, target with eight motors", Board::Octopus),
    ] {
        step(
            name,
            cargo()
                .args(["clippy", "--package", "hexstep", "--bins", "--lib"])
                .args(["--profile", "firmware", "--target", TARGET])
                .args(["--features", board.feature()])
                .args(["--", "-D", "warnings"]),
        );
    }
    step(
        "documentation",
        cargo()
            .args(["doc", "--workspace", "--no-deps"])
            .env("RUSTDOCFLAGS", "-D warnings"),
    );
    step(
        "documentation examples",
        cargo().args(["test", "--package", "hexstep", "--doc"]),
    );
    step(
        "tests, with the firmware in the emulator",
        cargo()
            .args(["test", "--package", "host-tests", "--no-fail-fast"])
            .env("HEXSTEP_FIRMWARE", &elf)
            .env("HEXSTEP_FIRMWARE_ARM", &arm)
            .env("HEXSTEP_FIRMWARE_OCTOPUS", &octopus)
            .env("HEXSTEP_FIRMWARE_BOOTLOADER", &behind_bootloader),
    );
    if failed.is_empty() {
        println!("\nall passed");
        Ok(())
    } else {
        Err(format!("failed: {}", failed.join(", ")))
    }
}
