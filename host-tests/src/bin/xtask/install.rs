//! What the tasks need beside Rust: the target's library, the emulator, a C compiler for the instruction counter.

use super::build::TARGET;
use super::run::{Outcome, is_installed, run};
use std::process::Command;

/// Programs and the Debian package each comes in.
const PROGRAMS: [(&str, &str); 2] = [
    ("qemu-system-arm", "qemu-system-arm"),
    ("cc", "gcc libc6-dev"),
];

/// Installs what is missing, or says how.
pub fn everything() -> Outcome<()> {
    target()?;
    let packages: Vec<&str> = PROGRAMS
        .iter()
        .filter(|(program, _)| !is_installed(program))
        .flat_map(|(_, packages)| packages.split(' '))
        .collect();
    if packages.is_empty() {
        return Ok(());
    }
    let list = packages.join(" ");
    if !is_root() || !is_installed("apt-get") {
        return Err(format!(
            "missing programs. On Debian or Ubuntu run:\n    sudo apt-get install --no-install-recommends {list}"
        ));
    }
    println!("installing {list}");
    run(Command::new("apt-get").arg("update"))?;
    run(Command::new("apt-get")
        .env("DEBIAN_FRONTEND", "noninteractive")
        .args(["install", "-y", "--no-install-recommends"])
        .args(packages))
}

/// The target's core library, by rustup; another installation of Rust may bring it along.
fn target() -> Outcome<()> {
    let Ok(output) = Command::new("rustup")
        .args(["target", "list", "--installed"])
        .output()
    else {
        return Ok(());
    };
    if String::from_utf8_lossy(&output.stdout)
        .lines()
        .any(|line| line == TARGET)
    {
        return Ok(());
    }
    run(Command::new("rustup").args(["target", "add", TARGET]))
}

fn is_root() -> bool {
    Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
