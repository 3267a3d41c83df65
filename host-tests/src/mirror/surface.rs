//! The support-side surface of a panel as points and normals.

use hexstep::geometry::Vector;
use hexstep::kinematics::ClPoint;

/// A surface that bends along x alone, so that machines which turn about y can follow its normals; z = 0 and the normal
/// upright at x = 0. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Crown towards the mill: z = sqrt(R^2 - x^2) - R (section 8).
    Cylinder { radius: f64 },
    /// Crown in the middle and troughs beside it: z = h (cos(2 pi x / L) - 1). This project's own.
    Wave { height: f64, length: f64 },
}

/// What straight lines between the points may leave of the surface [mm].
const CHORD: f64 = 0.0005;

impl Surface {
    /// Distance of points along x [mm].
    pub fn spacing(&self) -> f64 {
        let bend = match self {
            Self::Cylinder { radius } => 1.0 / radius,
            Self::Wave { height, length } => height * (std::f64::consts::TAU / length).powi(2),
        };
        (8.0 * CHORD / bend).sqrt().min(20.0)
    }

    /// Point and normal, from support to mill. `None` beyond the surface.
    pub fn at(&self, x: f64, y: f64) -> Option<ClPoint<f64>> {
        let (z, slope) = match self {
            Self::Cylinder { radius } => {
                let height = (radius * radius - x * x).sqrt();
                (height - radius, -x / height)
            }
            Self::Wave { height, length } => {
                let k = std::f64::consts::TAU / length;
                let (sin, cos) = (k * x).sin_cos();
                (height * (cos - 1.0), -height * k * sin)
            }
        };
        ClPoint::new(Vector::new(x, y, z), Vector::new(-slope, 0.0, 1.0))
    }
}
