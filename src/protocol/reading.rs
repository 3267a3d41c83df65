//! A sensor's reading as real-time bytes: taken out of the stream on arrival, so that it passes the lines of a program
//! that wait for room.
//!
//! ```text
//! 0xA6, then eight digits 0xB8 + d, d = 0 ..= 7, the first one the highest:
//!
//!   24 bits = value (i16, units of 0.1 um; -32768: the sensor has none) * 256 + check
//!   check   = CRC-8 of the value's two bytes, the high one first; polynomial 0x07, start 0xFF
//! ```
//!
//! All of these bytes have no other meaning in Grbl and grblHAL. A record that has lost a byte is thus never taken for a
//! command, and one that is wrong in any way is no reading at all; a new 0xA6 begins a new record. Other bytes may stand
//! between. None of them is above 0xBF, so a sender that speaks UTF-8 can send them: its 0xC2 is dropped.

use crate::math::Real;

/// Begins a record.
pub const BEGIN: u8 = 0xA6;
/// The digit 0; eight digits follow each other.
pub const DIGIT: u8 = 0xB8;
/// Digits of a record.
const DIGITS: u8 = 8;
/// Units per mm.
const UNITS: f32 = 10_000.0;
/// Stands for no reading.
const NONE: i16 = i16::MIN;

/// The record of a reading [mm, -3.2767 ..= 3.2767]; what is not finite or beyond that is sent as none.
pub fn encode(reading: Option<f32>) -> [u8; 9] {
    let units = reading.map(|mm| Real::round(mm * UNITS));
    let value = match units {
        Some(units) if (-32767.0..=32767.0).contains(&units) => units as i16,
        _ => NONE,
    };
    let [high, low] = value.to_be_bytes();
    let bits = u32::from_be_bytes([0, high, low, check([high, low])]);
    core::array::from_fn(|i| match i {
        0 => BEGIN,
        _ => DIGIT + (bits >> (24 - 3 * i) & 7) as u8,
    })
}

/// The reading behind a value [mm]; `None` for none.
pub fn millimetres(value: i16) -> Option<f32> {
    (value != NONE).then(|| f32::from(value) / UNITS)
}

/// Collects the digits of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Record {
    bits: u32,
    /// Digits still to come.
    left: u8,
}

impl Record {
    /// [`BEGIN`] has arrived.
    pub fn begin(&mut self) {
        *self = Self {
            bits: 0,
            left: DIGITS,
        };
    }

    /// A digit, 0 ..= 7; the value, when it was the last one and the check is right.
    pub fn push(&mut self, digit: u8) -> Option<i16> {
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        self.bits = self.bits << 3 | u32::from(digit & 7);
        let [_, high, low, sum] = self.bits.to_be_bytes();
        let whole = self.left == 0 && sum == check([high, low]);
        whole.then(|| i16::from_be_bytes([high, low]))
    }
}

fn check(bytes: [u8; 2]) -> u8 {
    let mut crc = 0xFFu8;
    for byte in bytes {
        crc ^= byte;
        for _ in 0..8 {
            crc = crc << 1 ^ if crc & 0x80 != 0 { 0x07 } else { 0 };
        }
    }
    crc
}
