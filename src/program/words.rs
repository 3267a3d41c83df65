//! Readings of numbers: decimal, with sign and point; no exponent, no names of numbers, nothing that is not finite.

/// A decimal number with sign and point; no exponent, no names of numbers.
pub fn number(text: &str) -> Option<f32> {
    let value = decimal(text)?.parse::<f32>().ok()?;
    value.is_finite().then_some(value)
}

/// The same, to 16 digits.
pub fn number64(text: &str) -> Option<f64> {
    let value = decimal(text)?.parse::<f64>().ok()?;
    value.is_finite().then_some(value)
}

fn decimal(text: &str) -> Option<&str> {
    text.bytes()
        .all(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.'))
        .then_some(text)
}

/// A whole number with sign.
pub fn whole(text: &str) -> Option<i32> {
    text.parse().ok()
}
