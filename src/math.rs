//! The one file that names the float library.
//!
//! Geometry, kinematics and process cycles are generic over [`Real`]: `f32` on the target, `f64` when the host
//! plans or checks. Below the joints everything is `f32`. Each function here calls `libm` by name, because a
//! method such as `x.sin()` would take the host's own library there, and host and target would no longer agree
//! bit for bit.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number: `f32` or `f64`, with its functions from `libm`. Angles in radians.
pub trait Real:
    Copy
    + PartialEq
    + PartialOrd
    + Debug
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + DivAssign
    + 'static
{
    const ZERO: Self;
    const ONE: Self;
    const TWO: Self;
    const HALF: Self;
    const PI: Self;
    /// A full turn, 2 pi.
    const TAU: Self;
    const INFINITY: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;

    /// The nearest representable number; meant for constants.
    fn of(x: f64) -> Self;
    fn of_i32(x: i32) -> Self;
    fn to_f64(self) -> f64;
    fn to_f32(self) -> f32;
    /// Without its fraction; held to the range of `i32`, and 0 for what is not a number.
    fn to_i32(self) -> i32;
    fn is_finite(self) -> bool;

    fn sqrt(self) -> Self;
    /// In `f32` within one unit of the last place.
    fn cbrt(self) -> Self;
    fn abs(self) -> Self;
    fn floor(self) -> Self;
    fn ceil(self) -> Self;
    /// To the nearest integer, ties away from zero.
    fn round(self) -> Self;
    fn sin(self) -> Self;
    fn cos(self) -> Self;
    fn tan(self) -> Self;
    fn asin(self) -> Self;
    fn acos(self) -> Self;
    fn atan(self) -> Self;
    fn atan2(self, x: Self) -> Self;
    /// Root of the sum of the squares, which do not overflow; in `f32` within 1.2 units of the last place.
    fn hypot(self, other: Self) -> Self;
    fn exp(self) -> Self;
    fn ln(self) -> Self;
    fn pow(self, exponent: Self) -> Self;
    /// Magnitude of `self`, sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// Remainder of the division, with the sign of `self`.
    fn rem(self, divisor: Self) -> Self;

    /// Sine and cosine together; in `f32` within 5.5e-8 and some thirty times cheaper on the target than one after the
    /// other (see `single_sin_cos` in the source).
    fn sin_cos(self) -> (Self, Self);

    fn squared(self) -> Self {
        self * self
    }

    /// The lesser of the two; the other one when one of them is not a number.
    fn min(self, other: Self) -> Self {
        if other < self || !self.is_number() {
            other
        } else {
            self
        }
    }

    /// The greater of the two; the other one when one of them is not a number.
    fn max(self, other: Self) -> Self {
        if other > self || !self.is_number() {
            other
        } else {
            self
        }
    }

    /// `self` held to `lo ..= hi`.
    fn clamp(self, lo: Self, hi: Self) -> Self {
        self.max(lo).min(hi)
    }

    fn is_number(self) -> bool {
        self.partial_cmp(&self).is_some()
    }

    fn to_radians(self) -> Self {
        self * (Self::PI / Self::of(180.0))
    }

    fn to_degrees(self) -> Self {
        self * (Self::of(180.0) / Self::PI)
    }
}

macro_rules! real {
    ($t:ident, $sqrt:ident $cbrt:path, $abs:ident $floor:ident $ceil:ident $round:ident $sin:ident $cos:ident $tan:ident
     $asin:ident $acos:ident $atan:ident $atan2:ident $hypot:path, $exp:ident $ln:ident $pow:ident $copysign:ident
     $rem:ident $sin_cos:path) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;
            const HALF: Self = 0.5;
            const PI: Self = core::$t::consts::PI;
            const TAU: Self = core::$t::consts::TAU;
            const INFINITY: Self = $t::INFINITY;
            const EPSILON: Self = $t::EPSILON;

            fn of(x: f64) -> Self {
                x as $t
            }
            fn of_i32(x: i32) -> Self {
                x as $t
            }
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn to_f32(self) -> f32 {
                self as f32
            }
            fn to_i32(self) -> i32 {
                self as i32
            }
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            fn sqrt(self) -> Self {
                libm::$sqrt(self)
            }
            fn cbrt(self) -> Self {
                $cbrt(self)
            }
            fn abs(self) -> Self {
                libm::$abs(self)
            }
            fn floor(self) -> Self {
                libm::$floor(self)
            }
            fn ceil(self) -> Self {
                libm::$ceil(self)
            }
            fn round(self) -> Self {
                libm::$round(self)
            }
            fn sin(self) -> Self {
                libm::$sin(self)
            }
            fn cos(self) -> Self {
                libm::$cos(self)
            }
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }
            fn tan(self) -> Self {
                libm::$tan(self)
            }
            fn asin(self) -> Self {
                libm::$asin(self)
            }
            fn acos(self) -> Self {
                libm::$acos(self)
            }
            fn atan(self) -> Self {
                libm::$atan(self)
            }
            fn atan2(self, x: Self) -> Self {
                libm::$atan2(self, x)
            }
            fn hypot(self, other: Self) -> Self {
                $hypot(self, other)
            }
            fn exp(self) -> Self {
                libm::$exp(self)
            }
            fn ln(self) -> Self {
                libm::$ln(self)
            }
            fn pow(self, exponent: Self) -> Self {
                libm::$pow(self, exponent)
            }
            fn copysign(self, sign: Self) -> Self {
                libm::$copysign(self, sign)
            }
            fn rem(self, divisor: Self) -> Self {
                libm::$rem(self, divisor)
            }
        }
    };
}

real!(f32, sqrtf single_cbrt, fabsf floorf ceilf roundf sinf cosf tanf asinf acosf atanf atan2f single_hypot, expf logf powf copysignf fmodf single_sin_cos);
real!(f64, sqrt libm::cbrt, fabs floor ceil round sin cos tan asin acos atan atan2 libm::hypot, exp log pow copysign fmod libm::sincos);

/// Sine and cosine of `x` [rad] in single precision alone, each within 5.5e-8, less than the last digit of 1.
///
/// libm computes its `f32` sine in double precision, which a Cortex-M4F has in software only: 2200 instructions for
/// both, and an inverse kinematics needs several. Sums and products of `f32` are the same bits on host and target.
///
/// `x` less the nearest multiple of pi/2, in three parts of which the first two times that multiple are exact; then the
/// minimax polynomials of (sin x - x)/x^3 (largest error times x^2: 4e-9) and (cos x - 1 + x^2/2)/x^4 (times x^4: 1e-10)
/// in x^2 up to 0.786^2.
fn single_sin_cos(x: f32) -> (f32, f32) {
    // 8 and 10 bits: exact when multiplied by a whole number below 2^13.
    const HIGH: f32 = 1.570_312_5;
    const MIDDLE: f32 = 1014.0 / (1 << 21) as f32;
    const LOW: f32 = 3.139_164_8e-7;
    const LARGEST: f32 = 8192.0;

    if x.is_nan() || libm::fabsf(x) > LARGEST {
        return libm::sincosf(x);
    }
    let quarter = (x * core::f32::consts::FRAC_2_PI + libm::copysignf(0.5, x)) as i32;
    let n = quarter as f32;
    // Both differences are exact; what rounding the third loses is `rest`.
    let near = x - n * HIGH - n * MIDDLE;
    let r = near - n * LOW;
    let rest = (near - r) - n * LOW;

    let z = r * r;
    let sin = r + (r * z * (-0.166_666_55 + z * (0.008_332_175 + z * -0.000_195_168_06)) + rest);
    let half = 0.5 * z;
    let most = 1.0 - half;
    let small = z * z * (0.041_666_647 + z * (-0.001_388_736_3 + z * 0.000_024_437_899));
    let cos = most + (((1.0 - most) - half) + (small - r * rest));
    match quarter & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Cube root of `x` in single precision alone: libm's divides twice in double precision, 1500 instructions on the target,
/// and the planner needs hundreds a millisecond.
///
/// A third of the exponent, with the best constant for its bits, is good to 3.2 %; Halley's step cubes that error.
fn single_cbrt(x: f32) -> f32 {
    /// Bits of 1 less a third of them, less what makes the error alike on both sides.
    const THIRD: u32 = 709_958_130;
    // No sum of three of them overflows.
    const SMALL: f32 = 1.0e-30;
    const LARGE: f32 = 1.0e30;

    let size = libm::fabsf(x);
    if !(SMALL..LARGE).contains(&size) {
        return libm::cbrtf(x);
    }
    let mut root = f32::from_bits(size.to_bits() / 3 + THIRD);
    for _ in 0..2 {
        let cube = root * root * root;
        // As a correction: its own rounding is that of a small part.
        root += root * ((size - cube) / (cube + cube + size));
    }
    libm::copysignf(root, x)
}

/// Root of the sum of two squares in single precision alone; libm's is in double precision.
fn single_hypot(x: f32, y: f32) -> f32 {
    const SMALL: f32 = 1.0e-30;
    const LARGE: f32 = 1.0e30;

    let squares = x * x + y * y;
    if (SMALL..LARGE).contains(&squares) {
        libm::sqrtf(squares)
    } else {
        libm::hypotf(x, y)
    }
}
