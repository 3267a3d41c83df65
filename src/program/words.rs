//! Readings and writings of numbers: decimal, with sign and point; no exponent, no names of numbers, nothing that is not
//! finite.
//!
//! Ours and not `core`'s, because the shortest digits and the correct rounding of every `f64` take 25 KiB of flash, and
//! seven digits are all that a setting has.

use core::fmt;
use fixed::types::I32F32;

/// A decimal number with sign and point.
pub fn number(text: &str) -> Option<f32> {
    // Beyond the largest f32 the cast gives infinity.
    let value = number64(text)? as f32;
    value.is_finite().then_some(value)
}

/// The same in double precision: exact to 15 digits, to the last place beyond.
pub fn number64(text: &str) -> Option<f64> {
    let (negative, digits) = match text.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let mut mantissa = 0u64;
    let mut scale = 1.0f64;
    let (mut point, mut seen) = (false, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                seen = true;
                let digit = u64::from(byte - b'0');
                match mantissa.checked_mul(10).and_then(|m| m.checked_add(digit)) {
                    Some(longer) if longer < 1 << 60 => {
                        mantissa = longer;
                        scale *= if point { 10.0 } else { 1.0 };
                    }
                    // A digit too many: it only counts before the point.
                    _ => scale *= if point { 1.0 } else { 0.1 },
                }
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    let value = mantissa as f64 / scale;
    (seen && value.is_finite()).then_some(if negative { -value } else { value })
}

/// A whole number with sign.
pub fn whole(text: &str) -> Option<i32> {
    text.parse().ok()
}

/// Why a number of steps is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadSteps {
    /// Not digits with a sign and a point.
    Malformed,
    /// More digits behind the point than [`STEP_PLACES`].
    TooLong,
    /// Beyond a step counter.
    OutOfRange,
}

/// Most digits behind the point of a number of steps: the last one is still more than 2^-32 of a step.
pub const STEP_PLACES: usize = 9;

/// A number of steps, to the nearest 2^-32 of one: no digit passes through a float.
pub fn steps(text: &str) -> Result<I32F32, BadSteps> {
    let (negative, digits) = match text.as_bytes() {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        rest => (false, rest),
    };
    let point = digits.iter().position(|byte| *byte == b'.');
    let (whole, behind) = match point {
        Some(at) => (&digits[..at], &digits[at + 1..]),
        None => (digits, &[][..]),
    };
    let is_number = whole.iter().chain(behind).all(u8::is_ascii_digit);
    if !is_number || whole.is_empty() && behind.is_empty() {
        return Err(BadSteps::Malformed);
    }
    if behind.len() > STEP_PLACES {
        return Err(BadSteps::TooLong);
    }
    let mut size = 0u64;
    for byte in whole {
        size = size * 10 + u64::from(byte - b'0');
        if size > 1 << 31 {
            return Err(BadSteps::OutOfRange);
        }
    }
    let (mut part, mut scale) = (0u64, 1u64);
    for byte in behind {
        part = part * 10 + u64::from(byte - b'0');
        scale *= 10;
    }
    // Below 10^9 * 2^32 < 2^62, and rounded to at most 2^32; the whole at most 2^31: no more than 2^63 + 2^32.
    let bits = (size << 32) + ((part << 32) + scale / 2) / scale;
    let bits = i128::from(bits);
    i64::try_from(if negative { -bits } else { bits })
        .map(I32F32::from_bits)
        .map_err(|_| BadSteps::OutOfRange)
}

/// Shows a number with the seven digits that an `f32` has, at most six of them behind the point.
#[derive(Clone, Copy, Debug)]
pub struct Decimal(pub f32);

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.0.is_finite() {
            return f.write_str("none");
        }
        let size = f64::from(if self.0 < 0.0 { -self.0 } else { self.0 });
        let (mut places, mut scale, mut limit) = (6usize, 1_000_000u64, 10.0);
        while places > 0 && size >= limit {
            places -= 1;
            scale /= 10;
            limit *= 10.0;
        }
        // The cast saturates, far beyond any setting.
        let shown = (size * scale as f64 + 0.5) as u64;
        let (ahead, mut behind) = (shown / scale, shown % scale);
        let sign = if self.0 < 0.0 && shown > 0 { "-" } else { "" };
        if behind == 0 {
            return write!(f, "{sign}{ahead}");
        }
        while behind % 10 == 0 {
            behind /= 10;
            places -= 1;
        }
        write!(f, "{sign}{ahead}.{behind:0places$}")
    }
}
