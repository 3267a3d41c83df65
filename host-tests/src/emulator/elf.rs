//! The little of ELF that is needed: addresses of functions, sizes in flash and RAM, the image as raw bytes.

use std::path::{Path, PathBuf};

use super::EmulatorError;

/// Where the chip's flash begins.
pub const FLASH_START: u32 = 0x0800_0000;
const FLASH_END: u32 = FLASH_START + 0x10_0000;
const RAM_START: u32 = 0x2000_0000;
const RAM_END: u32 = RAM_START + 0x2_0000;

/// A 32-bit little-endian ARM executable.
pub struct Elf {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// One loadable stretch of memory.
struct Program {
    file_offset: u32,
    address: u32,
    load_address: u32,
    file_size: u32,
    memory_size: u32,
}

impl Elf {
    pub fn read(path: &Path) -> Result<Self, EmulatorError> {
        let bytes = std::fs::read(path).map_err(|cause| EmulatorError::file(path, cause))?;
        let elf = Self {
            path: path.to_path_buf(),
            bytes,
        };
        // Magic, 32 bits, little endian; machine 40 is ARM.
        if !elf.bytes.starts_with(b"\x7fELF\x01\x01") || elf.half(18) != Some(40) {
            return Err(elf.broken("not a 32-bit ARM ELF file"));
        }
        if elf.programs().is_empty() {
            return Err(elf.broken("no loadable part"));
        }
        Ok(elf)
    }

    /// Address of a function, without the bit that marks Thumb code.
    pub fn function(&self, name: &str) -> Result<u32, EmulatorError> {
        self.functions()
            .into_iter()
            .find_map(|(found, address)| (found == name).then_some(address))
            .ok_or_else(|| EmulatorError::NoSymbol {
                name: name.to_string(),
            })
    }

    /// Names and addresses of all functions.
    pub fn functions(&self) -> Vec<(String, u32)> {
        const SYMBOL_TABLE: u32 = 2;
        const FUNCTION: u8 = 2;
        let mut functions = Vec::new();
        for section in self.sections() {
            if self.word(section + 4) != Some(SYMBOL_TABLE) {
                continue;
            }
            let (Some(start), Some(size), Some(names)) = (
                self.word(section + 16),
                self.word(section + 20),
                self.word(section + 24)
                    .and_then(|link| self.sections().nth(link as usize)),
            ) else {
                continue;
            };
            let names = self.word(names + 16).unwrap_or(0);
            for symbol in (start..start.saturating_add(size)).step_by(16) {
                let symbol = symbol as usize;
                let is_function = self
                    .bytes
                    .get(symbol + 12)
                    .is_some_and(|info| info & 15 == FUNCTION);
                if let (true, Some(name), Some(address)) =
                    (is_function, self.word(symbol), self.word(symbol + 4))
                {
                    functions.push((self.text(names as usize + name as usize), address & !1));
                }
            }
        }
        functions
    }

    /// First address of the image in flash: the vector table.
    pub fn flash_start(&self) -> u32 {
        self.programs()
            .iter()
            .filter(|program| in_flash(program.load_address) && program.file_size > 0)
            .map(|program| program.load_address)
            .min()
            .unwrap_or(FLASH_START)
    }

    /// Bytes of flash the image takes.
    pub fn flash_bytes(&self) -> u32 {
        self.programs()
            .iter()
            .filter(|program| in_flash(program.load_address))
            .map(|program| program.file_size)
            .sum()
    }

    /// Bytes of RAM that statics take; the stack comes on top.
    pub fn ram_bytes(&self) -> u32 {
        self.programs()
            .iter()
            .filter(|program| (RAM_START..RAM_END).contains(&program.address))
            .map(|program| program.memory_size)
            .sum()
    }

    /// The flash contents from [`Elf::flash_start`] on, gaps filled with the value of erased flash.
    pub fn image(&self) -> Vec<u8> {
        let start = self.flash_start();
        let mut image = Vec::new();
        for program in self.programs() {
            let from = program.file_offset as usize;
            let to = from + program.file_size as usize;
            let (true, Some(bytes)) = (in_flash(program.load_address), self.bytes.get(from..to))
            else {
                continue;
            };
            let at = (program.load_address - start) as usize;
            if image.len() < at + bytes.len() {
                image.resize(at + bytes.len(), 0xFF);
            }
            if let Some(place) = image.get_mut(at..at + bytes.len()) {
                place.copy_from_slice(bytes);
            }
        }
        image
    }

    fn programs(&self) -> Vec<Program> {
        const LOAD: u32 = 1;
        let (Some(table), Some(size), Some(count)) = (self.word(28), self.half(42), self.half(44))
        else {
            return Vec::new();
        };
        (0..usize::from(count))
            .map(|i| table as usize + i * usize::from(size))
            .filter(|at| self.word(*at) == Some(LOAD))
            .filter_map(|at| {
                Some(Program {
                    file_offset: self.word(at + 4)?,
                    address: self.word(at + 8)?,
                    load_address: self.word(at + 12)?,
                    file_size: self.word(at + 16)?,
                    memory_size: self.word(at + 20)?,
                })
            })
            .collect()
    }

    /// Offsets of the section headers.
    fn sections(&self) -> impl Iterator<Item = usize> + '_ {
        let table = self.word(32).unwrap_or(0) as usize;
        let size = self.half(46).unwrap_or(0);
        let count = self.half(48).unwrap_or(0);
        (0..usize::from(count)).map(move |i| table + i * usize::from(size))
    }

    fn half(&self, at: usize) -> Option<u16> {
        let bytes = self.bytes.get(at..at.checked_add(2)?)?;
        Some(u16::from_le_bytes(bytes.try_into().ok()?))
    }

    fn word(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    }

    fn text(&self, at: usize) -> String {
        let bytes = self.bytes.get(at..).unwrap_or(&[]);
        let end = bytes
            .iter()
            .position(|byte| *byte == 0)
            .unwrap_or(bytes.len());
        String::from_utf8_lossy(bytes.get(..end).unwrap_or(&[])).into_owned()
    }

    fn broken(&self, reason: &'static str) -> EmulatorError {
        EmulatorError::NotFirmware {
            path: self.path.clone(),
            reason,
        }
    }
}

fn in_flash(address: u32) -> bool {
    (FLASH_START..FLASH_END).contains(&address)
}
