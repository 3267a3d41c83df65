//! The functions of `math` that are our own in single precision, judged by the standard library in double.

mod common;

use common::Random;
use hexstep::math::Real;

/// Sine and cosine in f32 come from polynomials of their own; the standard library's f64 judges them.
#[test]
fn single_sines_and_cosines_are_within_a_digit() {
    let mut random = Random(8);
    let mut worst = 0f64;
    let angles = (0..400_000).map(|i| {
        let reach = if i % 2 == 0 { 3.2 } else { 9000.0 };
        random.between(-reach, reach) as f32
    });
    for x in angles.chain([0.0, -0.0, 8192.0, -8192.0, std::f32::consts::PI, 1e30]) {
        let (sin, cos) = Real::sin_cos(x);
        let (sin64, cos64) = f64::from(x).sin_cos();
        worst = worst.max((f64::from(sin) - sin64).abs());
        worst = worst.max((f64::from(cos) - cos64).abs());
    }
    println!("f32 sine and cosine: {worst:.2e}");
    assert!(worst <= 5.5e-8);
    for x in [f32::NAN, f32::INFINITY] {
        let (sin, cos) = Real::sin_cos(x);
        assert!(sin.is_nan() && cos.is_nan());
    }
}

/// Units of the last place of `exact` that `found` is off.
fn off(found: f32, exact: f64) -> f64 {
    let digit = f64::from((exact as f32).abs().next_up()) - f64::from((exact as f32).abs());
    (f64::from(found) - exact).abs() / digit
}

/// Evenly over the orders of magnitude from 1e-37 to 1e37, either sign.
fn any_size(random: &mut Random) -> f32 {
    let size = 10f64.powf(random.between(-37.0, 37.0)) as f32;
    if random.below(2) == 0 { size } else { -size }
}

#[test]
fn single_cube_roots_are_within_a_digit() {
    let mut random = Random(9);
    let mut worst = 0f64;
    for _ in 0..400_000 {
        let x = any_size(&mut random);
        worst = worst.max(off(Real::cbrt(x), f64::from(x).cbrt()));
    }
    println!("f32 cube root: {worst:.2} units of the last place");
    assert!(worst <= 1.0);
    for whole in [0.0f32, 1.0, -8.0, 27.0, 1000.0] {
        assert_eq!(Real::cbrt(whole), whole.cbrt());
    }
    assert!(Real::cbrt(f32::NAN).is_nan());
    assert_eq!(Real::cbrt(-f32::INFINITY), -f32::INFINITY);
}

#[test]
fn single_hypotenuses_are_within_one_and_a_fifth_of_a_digit_and_never_overflow_on_the_way() {
    let mut random = Random(10);
    let mut worst = 0f64;
    for _ in 0..400_000 {
        let x = any_size(&mut random);
        let y = x * random.between(-3.0, 3.0) as f32;
        worst = worst.max(off(Real::hypot(x, y), f64::from(x).hypot(y.into())));
    }
    println!("f32 hypotenuse: {worst:.2} units of the last place");
    assert!(worst <= 1.2);
    assert_eq!(Real::hypot(3.0f32, -4.0), 5.0);
    assert_eq!(Real::hypot(0.0f32, 0.0), 0.0);
    assert_eq!(Real::hypot(f32::INFINITY, 1.0), f32::INFINITY);
}
