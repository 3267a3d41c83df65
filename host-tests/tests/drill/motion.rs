//! The tip's path, exact and as published.

use crate::common::*;
use hexstep::cycles::drill_point::{DrillPointError, Field, Motion, Variant};

#[test]
fn the_vector_form_and_the_closed_form_of_the_tips_path_agree() {
    for cone in [
        printed_1(),
        printed_2(),
        example_1::<f64>().0.solve(0.4).unwrap().cone,
    ] {
        let motion = Motion::new(&cone, 118f64.to_radians(), Variant::Exact).unwrap();
        let w = cone.tip.x * cone.phi.cos() - cone.tip.z * cone.phi.sin();
        let radius = w.hypot(cone.tip.y);
        let mu0 = cone.tip.y.atan2(w);
        for degrees in -180..=180 {
            let mu = f64::from(degrees).to_radians();
            let u = mu0.cos() - (mu - mu0).cos();
            let v = mu0.sin() + (mu - mu0).sin();
            let (sin_phi, cos_phi) = cone.phi.sin_cos();
            let (sin, cos) = cone.omega.sin_cos();
            let closed = [
                radius * sin_phi * u,
                radius * (cos_phi * cos * u + sin * v),
                radius * (cos * v - cos_phi * sin * u),
            ];

            let p = motion.at(mu).p.to_array();

            for i in 0..3 {
                assert_close(p[i], closed[i], 1e-12);
            }
        }
        assert_close(motion.radius, radius, 1e-12);
        assert_close(motion.phase, mu0, 1e-12);
    }
}

/// Section 6.2, in micrometres.
#[test]
fn the_published_tip_path_is_off_by_as_much_as_the_table_says() {
    let angles = [-5.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0f64];
    let table = [
        (
            printed_1(),
            [21.2, 21.2, 42.5, 84.9, 126.8, 167.9, 207.6, 245.7],
        ),
        (
            printed_2(),
            [10.5, 10.5, 21.1, 42.4, 63.4, 84.0, 103.9, 122.9],
        ),
    ];
    for (cone, row) in table {
        let point = 118f64.to_radians();
        let exact = Motion::new(&cone, point, Variant::Exact).unwrap();
        let published = Motion::new(&cone, point, Variant::Published).unwrap();
        for (mu, wanted) in angles.iter().zip(row) {
            let mu = mu.to_radians();
            let off = (exact.at(mu).p - published.at(mu).p).norm();
            // Half of the last digit; the table's 245.7 is 245.646.
            assert_close(off * 1000.0, wanted, 0.055);
        }
    }
}

#[test]
fn a_tip_outside_the_published_circle_is_refused_by_that_variant_alone() {
    let cone = printed(30.0, 29.1, 3.8, [3.75, 2.2, 2.51]);
    let point = 118f64.to_radians();

    assert_eq!(
        Motion::new(&cone, point, Variant::Published),
        Err(DrillPointError::OutOfRange(Field::Cy))
    );
    assert!(Motion::new(&cone, point, Variant::Exact).is_ok());
}
