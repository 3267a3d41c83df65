//! The surface to be ground.

use hexstep::geometry::Vector;
use hexstep::geometry::nurbs::{MAX_COUNT, Nurbs, NurbsError};
use hexstep::math::Real;

/// Room for the largest net.
pub type Part<R = f64> = Nurbs<R, MAX_COUNT, MAX_COUNT>;

/// Dune: 200 x 150 mm, bicubic, 8 x 7, three weights of their own; convex, hollow and saddle places.
pub fn dune<R: Real>() -> Result<Box<Part<R>>, NurbsError> {
    const X: [f64; 8] = [0.0, 13.0, 40.0, 80.0, 120.0, 160.0, 187.0, 200.0];
    const Y: [f64; 7] = [0.0, 12.5, 37.5, 75.0, 112.5, 137.5, 150.0];
    const Z: [[f64; 7]; 8] = [
        [5.0, 4.0, 0.0, -5.0, 0.0, 4.0, 5.0],
        [5.0, 6.0, 4.0, 1.0, 4.0, 6.0, 5.0],
        [5.0, 7.0, 9.0, 9.0, 9.0, 7.0, 5.0],
        [5.0, 6.0, 6.0, 4.0, 6.0, 6.0, 5.0],
        [5.0, 2.0, -6.0, -13.0, -6.0, 2.0, 5.0],
        [5.0, 1.0, -9.0, -18.0, -9.0, 1.0, 5.0],
        [5.0, 3.0, -4.0, -10.0, -4.0, 3.0, 5.0],
        [5.0, 4.0, 0.0, -5.0, 0.0, 4.0, 5.0],
    ];
    const KNOTS_U: [f64; 12] = [0.0, 0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0];
    const KNOTS_V: [f64; 11] = [0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0];

    let points: Vec<_> = X
        .iter()
        .zip(&Z)
        .flat_map(|(x, row)| {
            Y.iter()
                .zip(row)
                .map(|(y, z)| Vector::new(R::of(*x), R::of(*y), R::of(*z)))
        })
        .collect();
    let mut weights = [R::ONE; 56];
    for (i, j, w) in [(2, 3, 1.2), (3, 2, 1.1), (5, 3, 0.9)] {
        weights[7 * i + j] = R::of(w);
    }
    let (knots_u, knots_v) = (KNOTS_U.map(R::of), KNOTS_V.map(R::of));
    Part::new([3, 3], [8, 7], [&knots_u, &knots_v], &points, &weights).map(Box::new)
}
