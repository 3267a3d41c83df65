//! The phase as a fraction of a turn, in integers.
//!
//! A phase that is added up in floating point loses a bit with every doubling of the turns. Here a turn is 2^64 counts,
//! sums wrap by themselves, and a segment's advance is divided among its poses without a remainder ([`Steps`]).

use crate::math::Real;

const COUNTS: f64 = 18_446_744_073_709_551_616.0;
/// A quarter turn and half of it, in counts.
const QUARTER: u64 = 1 << 62;
const EIGHTH: u64 = 1 << 61;

/// An angle modulo a full turn, in units of 2^-64 turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turn(u64);

impl Turn {
    pub const ZERO: Self = Self(0);

    /// The fraction of a number of turns; `turns` finite.
    pub fn of_turns<R: Real>(turns: R) -> Self {
        Self(fraction(turns - turns.floor()))
    }

    /// An angle [rad], finite.
    pub fn of_radians<R: Real>(angle: R) -> Self {
        Self::of_turns(angle / R::TAU)
    }

    /// In [0, 360) [deg]. What is within rounding of a full turn is 0.
    pub fn to_degrees<R: Real>(self) -> R {
        let limb = |shift: u32| R::of_i32(((self.0 >> shift) & 0xFFFF) as i32);
        let scale = R::of(1.0 / 65536.0);
        let turns = (((limb(0) * scale + limb(16)) * scale + limb(32)) * scale + limb(48)) * scale;
        let (full, degrees) = (R::of(360.0), turns * R::of(360.0));
        if degrees > full - R::of(1e-11).max(full * R::EPSILON) {
            R::ZERO
        } else {
            degrees
        }
    }

    /// Sine and cosine. The quarter turn is taken off in integers, so that multiples of 90 deg are exact.
    pub fn sin_cos<R: Real>(self) -> (R, R) {
        let quarter = self.0.wrapping_add(EIGHTH) / QUARTER;
        let rest = self.0.wrapping_sub(quarter.wrapping_mul(QUARTER)) as i64;
        // The lower half matters in f64 alone; its last bit is below every rounding.
        let high = R::of_i32((rest >> 32) as i32) * R::of(core::f64::consts::TAU / 4294967296.0);
        let low =
            R::of_i32((rest as u32 >> 1) as i32) * R::of(core::f64::consts::TAU * 2.0 / COUNTS);
        let (sin, cos) = (high + low).sin_cos();
        match quarter & 3 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    pub fn plus(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

/// A number in [0, 1) in units of 2^-64, sixteen bits at a time: each step is exact.
fn fraction<R: Real>(mut x: R) -> u64 {
    let mut counts = 0;
    for _ in 0..4 {
        x *= R::of(65536.0);
        let limb = x.to_i32().clamp(0, 0xFFFF);
        x -= R::of_i32(limb);
        counts = (counts << 16) | limb as u64;
    }
    counts
}

/// An advance in `count` equal steps: after j of them exactly `floor(advance j / count)` counts have been added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Steps {
    phase: Turn,
    /// Counts of one step, and what is left over in units of 1/count.
    step: u64,
    left: u32,
    carried: u32,
    count: u32,
    backwards: bool,
}

impl Steps {
    /// `turns` finite; `None` from 2^31 turns on. `count` at least 1 and below 2^31.
    pub fn new<R: Real>(phase: Turn, turns: R, count: u32) -> Option<Self> {
        let magnitude = turns.abs();
        if magnitude >= R::of(2147483648.0) {
            return None;
        }
        let whole = magnitude.floor();
        let counts = fraction(magnitude - whole);
        // Long division of whole * 2^64 + counts by the number of steps, in digits of 32 bits. The remainder is below
        // 2^31, so each dividend fits; whole turns of the quotient wrap away.
        let divisor = u64::from(count.max(1));
        let (mut step, mut left) = (0u64, 0u64);
        for digit in [whole.to_i32() as u64, counts >> 32, counts & 0xFFFF_FFFF] {
            let dividend = (left << 32) | digit;
            step = (step << 32) | (dividend / divisor);
            left = dividend % divisor;
        }
        Some(Self {
            phase,
            step,
            left: left as u32,
            carried: 0,
            count: count.max(1),
            backwards: turns < R::ZERO,
        })
    }

    /// No advance.
    pub fn still(phase: Turn) -> Self {
        Self {
            phase,
            step: 0,
            left: 0,
            carried: 0,
            count: 1,
            backwards: false,
        }
    }

    pub fn phase(&self) -> Turn {
        self.phase
    }

    pub fn advance(&mut self) {
        // Both terms are below 2^31.
        self.carried += self.left;
        let carry = self.carried >= self.count;
        if carry {
            self.carried -= self.count;
        }
        let moved = self.step.wrapping_add(u64::from(carry));
        self.phase = Turn(if self.backwards {
            self.phase.0.wrapping_sub(moved)
        } else {
            self.phase.0.wrapping_add(moved)
        });
    }

    /// The phase after all steps, from none of them.
    pub fn end<R: Real>(phase: Turn, turns: R) -> Turn {
        let counts = fraction(turns.abs() - turns.abs().floor());
        Turn(if turns < R::ZERO {
            phase.0.wrapping_sub(counts)
        } else {
            phase.0.wrapping_add(counts)
        })
    }
}
