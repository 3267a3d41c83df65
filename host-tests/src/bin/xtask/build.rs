//! Builds the firmware and tells its size.

use super::board::Board;
use super::run::{Outcome, cargo, shown};
use hexstep_host::emulator::Elf;
use std::path::{Path, PathBuf};
use std::process::Stdio;

pub const TARGET: &str = "thumbv7em-none-eabihf";
/// The program that is shipped.
pub const FIRMWARE: &str = "hexstep-firmware";
/// Functions of the library, called one by one to be measured. Never flashed.
pub const BENCH: &str = "hexstep-bench";

const FLASH_BYTES: u32 = 1024 * 1024;
const RAM_BYTES: u32 = 128 * 1024;

pub fn task(board: Board, bootloader: bool) -> Outcome<()> {
    let elf = firmware(board, FIRMWARE, bootloader)?;
    let image = write_image(&elf)?;
    print_size(&elf)?;
    println!("ELF    {}", elf.display());
    println!("image  {}", image.display());
    if bootloader {
        println!("Copy the image to the SD card as firmware.bin and restart the board.");
    }
    Ok(())
}

/// Builds program `name` for `board`; the path of its ELF, which no other build overwrites.
pub fn firmware(board: Board, name: &str, bootloader: bool) -> Outcome<PathBuf> {
    let mut command = cargo();
    command
        .args(["rustc", "--package", "hexstep", "--bin", name])
        .args(["--profile", "firmware", "--target", TARGET])
        .args(["--features", board.feature()])
        .arg("--message-format=json-render-diagnostics")
        .env("DEFMT_LOG", "info");
    if bootloader {
        command.args(["--", "-C"]);
        command.arg(format!(
            "link-arg=--defsym=BOOTLOADER_BYTES={}",
            board.bootloader_bytes()
        ));
    }
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("cargo: {error}"))?;
    if !output.status.success() {
        return Err(format!("{} failed", shown(&command)));
    }
    let built = String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|message| message.get("executable")?.as_str().map(PathBuf::from))
        .next_back()
        .ok_or("cargo did not say where it put the firmware")?;
    let suffix = if bootloader { "-bootloader" } else { "" };
    let elf = folder(&built)?.join(format!("{name}-{}{suffix}.elf", board.feature()));
    std::fs::copy(&built, &elf).map_err(|error| format!("{}: {error}", elf.display()))?;
    Ok(elf)
}

/// `hexstep` in cargo's target folder, where `built` lies in `TARGET/PROFILE`.
fn folder(built: &Path) -> Outcome<PathBuf> {
    let target = built
        .ancestors()
        .nth(3)
        .ok_or("cargo put the firmware in an unexpected place")?;
    let folder = target.join("hexstep");
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}

/// Writes the raw image beside the ELF.
pub fn write_image(elf: &Path) -> Outcome<PathBuf> {
    let read = Elf::read(elf).map_err(|error| error.to_string())?;
    let image = elf.with_extension("bin");
    std::fs::write(&image, read.image())
        .map_err(|error| format!("{}: {error}", image.display()))?;
    Ok(image)
}

fn print_size(elf: &Path) -> Outcome<()> {
    let read = Elf::read(elf).map_err(|error| error.to_string())?;
    for (what, bytes, of) in [
        ("flash", read.flash_bytes(), FLASH_BYTES),
        ("RAM", read.ram_bytes(), RAM_BYTES),
    ] {
        let share = 100.0 * f64::from(bytes) / f64::from(of);
        println!("{what:6} {bytes:7} bytes of {of:7} ({share:.1} %)");
    }
    println!("flash starts at {:#010x}", read.flash_start());
    Ok(())
}
