//! Writes the firmware into a board, with the first tool that is installed.

use super::board::Board;
use super::build::{FIRMWARE, firmware, write_image};
use super::run::{Outcome, is_installed, run, shown};
use hexstep_host::emulator::Elf;
use std::path::Path;
use std::process::Command;

pub fn task(board: Board, bootloader: bool) -> Outcome<()> {
    let elf = firmware(board, FIRMWARE, bootloader)?;
    let image = write_image(&elf)?;
    let start = Elf::read(&elf)
        .map_err(|error| error.to_string())?
        .flash_start();
    let mut tools = [
        probe_rs(board, &elf),
        st_flash(&image, start),
        openocd(board, &elf),
    ];
    for command in &mut tools {
        if is_installed(&command.get_program().to_string_lossy()) {
            println!("{}", shown(command));
            return run(command);
        }
    }
    let ways: Vec<String> = tools
        .iter()
        .map(|command| format!("    {}", shown(command)))
        .collect();
    let mut text = String::from(
        "none of probe-rs, st-flash, openocd is installed. Any of these writes the firmware:\n",
    );
    text += &ways.join("\n");
    text += "\nor build with --bootloader and copy the image to the SD card as firmware.bin";
    Err(text)
}

fn probe_rs(board: Board, elf: &Path) -> Command {
    let mut command = Command::new("probe-rs");
    command
        .args(["download", "--verify", "--chip", board.probe_chip()])
        .arg(elf);
    command
}

fn st_flash(image: &Path, start: u32) -> Command {
    let mut command = Command::new("st-flash");
    command
        .args(["--reset", "write"])
        .arg(image)
        .arg(format!("{start:#010x}"));
    command
}

fn openocd(board: Board, elf: &Path) -> Command {
    let mut command = Command::new("openocd");
    command
        .args([
            "-f",
            "interface/stlink.cfg",
            "-f",
            board.openocd_target(),
            "-c",
        ])
        .arg(format!("program {} verify reset exit", elf.display()));
    command
}
