//! The boards, as far as building and flashing are concerned.

/// A board the firmware is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Board {
    /// BTT SKR Pro v1.2 (STM32F407ZG, six motors)
    SkrPro,
    /// BTT SKR Pro v1.2 in a six-axis arm: precession, surface grinding
    SkrProArm,
    /// BTT Octopus v1.1 with an STM32F407ZG (eight motors)
    Octopus,
}

impl Board {
    /// The cargo feature that selects it.
    pub fn feature(self) -> &'static str {
        match self {
            Board::SkrPro => "skr-pro",
            Board::SkrProArm => "skr-pro-arm",
            Board::Octopus => "octopus",
        }
    }

    /// Bytes of flash that its bootloader takes.
    pub fn bootloader_bytes(self) -> u32 {
        match self {
            Board::SkrPro | Board::SkrProArm | Board::Octopus => 0x8000,
        }
    }

    /// The chip's name for probe-rs.
    pub fn probe_chip(self) -> &'static str {
        match self {
            Board::SkrPro | Board::SkrProArm | Board::Octopus => "STM32F407ZGTx",
        }
    }

    /// openocd's file for the chip.
    pub fn openocd_target(self) -> &'static str {
        match self {
            Board::SkrPro | Board::SkrProArm | Board::Octopus => "target/stm32f4x.cfg",
        }
    }
}
