//! Rigid displacements as 4x4 matrices from unit quaternions, on plain arrays. Shares nothing with the library.

pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

pub fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot: f64 = (0..3).map(|i| a[i] * b[i]).sum();
    let cross = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    distance(cross, [0.0; 3]).atan2(dot).to_degrees()
}

/// Rows of a displacement.
pub type Matrix = [[f64; 4]; 4];

/// A shift [mm].
pub fn translation([x, y, z]: [f64; 3]) -> Matrix {
    [
        [1.0, 0.0, 0.0, x],
        [0.0, 1.0, 0.0, y],
        [0.0, 0.0, 1.0, z],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

/// A turn by `angle` [rad] about the axis `n` (any length) through `q`.
pub fn about(n: [f64; 3], q: [f64; 3], angle: f64) -> Matrix {
    let norm = distance(n, [0.0; 3]);
    let (s, w) = (angle / 2.0).sin_cos();
    let [x, y, z] = n.map(|n| n / norm * s);
    let turn = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
            0.0,
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
            0.0,
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
            0.0,
        ],
        [0.0, 0.0, 0.0, 1.0],
    ];
    multiply(
        &translation(q),
        &multiply(&turn, &translation(q.map(|q| -q))),
    )
}

/// a b
pub fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// The inverse of a rigid displacement.
pub fn inverted(m: &Matrix) -> Matrix {
    let mut out = translation([0.0; 3]);
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] = m[j][i];
        }
        out[i][3] = -(0..3).map(|k| m[k][i] * m[k][3]).sum::<f64>();
    }
    out
}
