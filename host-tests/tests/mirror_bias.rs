//! Gauge readings -> a correction of the wall. The readings are those of the paper's two tables, nine points three times.

use hexstep::cycles::mirror_bias::{Bias, BiasError};
use hexstep::math::Real;

/// Table with trimming: one row a reading, one column a point.
const TRIMMED: [[f64; 9]; 3] = [
    [1.43, 1.44, 1.45, 1.44, 1.43, 1.47, 1.44, 1.45, 1.46],
    [1.43, 1.44, 1.45, 1.44, 1.44, 1.46, 1.44, 1.45, 1.47],
    [1.43, 1.44, 1.42, 1.44, 1.44, 1.47, 1.43, 1.45, 1.46],
];
const UNTRIMMED: [[f64; 9]; 3] = [
    [1.47, 1.40, 1.41, 1.47, 1.46, 1.44, 1.47, 1.48, 1.45],
    [1.46, 1.39, 1.42, 1.46, 1.46, 1.45, 1.47, 1.48, 1.46],
    [1.46, 1.38, 1.42, 1.46, 1.46, 1.44, 1.47, 1.48, 1.45],
];

fn learnt<R: Real>(table: &[[f64; 9]; 3]) -> Bias<R> {
    let mut bias = Bias::new(R::of(1.5), R::of(0.1), R::of(0.2)).unwrap();
    for reading in table.iter().flatten() {
        bias.take(R::of(*reading)).unwrap();
    }
    bias
}

/// Means of the points, and the root of the mean square of what they are off 1.5 when `shift` is added.
fn rms(table: &[[f64; 9]; 3], shift: f64) -> f64 {
    let means = (0..9).map(|i| (table[0][i] + table[1][i] + table[2][i]) / 3.0);
    let squares: f64 = means.map(|mean| (mean + shift - 1.5).powi(2)).sum();
    (squares / 9.0).sqrt()
}

#[test]
fn the_papers_readings_ask_for_the_correction_that_their_mean_lacks() {
    let trimmed = learnt::<f64>(&TRIMMED).correction().unwrap();
    let untrimmed = learnt::<f64>(&UNTRIMMED).correction().unwrap();

    assert_eq!(format!("{trimmed:.4} {untrimmed:.4}"), "0.0552 0.0511");
    assert!((trimmed - (1.5 - 39.01 / 27.0)).abs() < 1e-12);
}

#[test]
fn with_the_correction_the_rms_error_falls_to_the_spread() {
    let correction = learnt::<f64>(&TRIMMED).correction().unwrap();

    // Section 11: 0.0564 off nominal, 0.01187 about their own mean.
    assert_eq!(format!("{:.4}", rms(&TRIMMED, 0.0)), "0.0564");
    assert_eq!(format!("{:.5}", rms(&TRIMMED, correction)), "0.01187");
}

#[test]
fn in_single_precision_the_correction_is_the_same_within_a_tenth_of_a_micrometre() {
    let single = learnt::<f32>(&TRIMMED).correction().unwrap();
    let mut long = Bias::<f32>::new(1.5, 0.1, 0.2).unwrap();
    for k in 0..1_000_000 {
        long.take(if k % 2 == 0 { 1.4 } else { 1.5 }).unwrap();
    }

    assert!((f64::from(single) - 0.0551852).abs() < 1e-7, "{single}");
    let long = long.correction().unwrap();
    assert!((long - 0.05).abs() < 1e-6, "after a million: {long}");
}

#[test]
fn there_is_no_correction_before_the_third_reading() {
    let mut bias = Bias::<f64>::new(1.5, 0.1, 0.2).unwrap();

    for expected in [None, None] {
        assert_eq!(bias.correction(), expected);
        bias.take(1.46).unwrap();
    }
    assert_eq!(bias.correction(), None);
    bias.take(1.46).unwrap();

    assert!((bias.correction().unwrap() - 0.04).abs() < 1e-12);
}

#[test]
fn a_reading_that_cannot_be_is_refused_by_name_and_changes_nothing() {
    let mut bias = learnt::<f64>(&TRIMMED);
    let before = bias;

    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(bias.take(bad), Err(BiasError::NonFinite));
    }
    for far in [1.29, 1.71, 0.0, 14.5] {
        assert_eq!(bias.take(far), Err(BiasError::Outlier));
    }
    assert_eq!(bias, before);
    assert_eq!(bias.readings(), 27);
}

#[test]
fn a_correction_stays_within_its_bound_and_says_that_it_is_not_enough() {
    for (reading, correction) in [(1.35, 0.1), (1.65, -0.1)] {
        let mut bias = Bias::<f64>::new(1.5, 0.1, 0.2).unwrap();
        for _ in 0..3 {
            bias.take(reading).unwrap();
        }
        assert_eq!(bias.correction(), Some(correction));
        assert!(bias.is_beyond());
    }
    assert!(!learnt::<f64>(&TRIMMED).is_beyond());
}

#[test]
fn bounds_that_are_none_are_refused_by_name() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Bias::new(bad, 0.1, 0.2), Err(BiasError::BadWall));
        assert_eq!(Bias::new(1.5, bad, 0.2), Err(BiasError::BadLimit("most")));
        assert_eq!(Bias::new(1.5, 0.1, bad), Err(BiasError::BadLimit("gate")));
    }
}
