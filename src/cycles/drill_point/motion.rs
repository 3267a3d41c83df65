//! mu -> the drill's rotation and the displacement of its tip.
//!
//! Exact: a rigid rotation about the cone's axis K = -tom(a), with v from the apex to the tip, in machine axes:
//!
//! ```text
//! Rot = Rot(K, mu),   p(mu) - p(0) = (Rot - I) v
//! ```
//!
//! As published, equations (4)-(6) and (8)-(10): K is tilted, and the tip goes on a circle of another radius about an
//! axis that is not turned by omega. It is no rigid rotation (up to 0.25 mm off at the tip in the paper's example 1)
//! and serves for comparison only.

use super::error::{DrillPointError, Field, check, within};
use super::solve::{Cone, axis};
use super::tom;
use crate::geometry::{Pose, Rotation, Vector};
use crate::math::Real;

/// Which formulas turn mu into a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    #[default]
    Exact,
    /// For comparison only.
    Published,
}

/// The motion of a drill about a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<R> {
    /// K, unit length, machine frame.
    pub axis: Vector<R>,
    /// Radius of the tip's circle [mm] and its phase [rad].
    pub radius: R,
    pub phase: R,
    path: Path<R>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Path<R> {
    /// The two vectors of (Rot - I) v = sin mu K x v + (1 - cos mu) K x (K x v).
    Exact {
        across: Vector<R>,
        inward: Vector<R>,
    },
    /// Sine and cosine of phi.
    Published { sin_phi: R, cos_phi: R },
}

impl<R: Real> Motion<R> {
    /// `point_angle` [rad] of the drill is used by the published variant only.
    pub fn new(
        cone: &Cone<R>,
        point_angle: R,
        variant: Variant,
    ) -> Result<Self, DrillPointError<R>> {
        let right = R::PI * R::HALF;
        check(
            &[
                (Field::PointAngle, point_angle),
                (Field::Phi, cone.phi),
                (Field::Theta, cone.theta),
                (Field::Omega, cone.omega),
                (Field::Cx, cone.tip.x),
                (Field::Cy, cone.tip.y),
                (Field::Cz, cone.tip.z),
            ],
            &[
                (Field::PointAngle, within(point_angle, R::PI)),
                (Field::Phi, within(cone.phi, right)),
                (Field::Theta, within(cone.theta, right)),
                (Field::Omega, cone.omega.abs() < right),
            ],
        )?;
        Ok(match variant {
            Variant::Exact => Self::exact(cone),
            Variant::Published => Self::published(cone, point_angle)?,
        })
    }

    fn exact(cone: &Cone<R>) -> Self {
        let k = -tom(axis(cone.phi, cone.omega));
        let v = tom(cone.tip_in_lip_frame());
        let across = k.cross(v);
        let (radius, phase) = cone.circle();
        Self {
            axis: k,
            radius,
            phase,
            path: Path::Exact {
                across,
                inward: k.cross(across),
            },
        }
    }

    fn published(cone: &Cone<R>, point_angle: R) -> Result<Self, DrillPointError<R>> {
        let (sin_phi, cos_phi) = cone.phi.sin_cos();
        let (sin, cos) = cone.omega.sin_cos();
        let scale = ((cos * cos_phi).squared() + sin_phi.squared()).sqrt();
        let axis = Vector::new(-cos_phi * cos, sin_phi * cos, -sin_phi * sin) * (R::ONE / scale);
        let tan = (point_angle * R::HALF).tan();
        let stretch = (R::ONE / (tan * cos).squared() + R::ONE).sqrt();
        let radius = cone.tip.x * cone.theta.sin() * stretch;
        let on_circle = cone.tip.y.abs() <= radius;
        if !on_circle {
            return Err(DrillPointError::OutOfRange(Field::Cy));
        }
        let phase = if radius > R::ZERO {
            (cone.tip.y / radius).asin()
        } else {
            R::ZERO
        };
        Ok(Self {
            axis,
            radius,
            phase,
            path: Path::Published { sin_phi, cos_phi },
        })
    }

    /// Rotation from mu = 0, and as `p` the tip's displacement p(mu) - p(0) [mm], machine frame.
    pub fn at(&self, mu: R) -> Pose<R> {
        let p = match self.path {
            Path::Exact { across, inward } => {
                // 1 - cos mu without cancellation.
                let versine = R::TWO * (mu * R::HALF).sin().squared();
                across * mu.sin() + inward * versine
            }
            Path::Published { sin_phi, cos_phi } => {
                let (sin0, cos0) = self.phase.sin_cos();
                let (sin, cos) = (mu - self.phase).sin_cos();
                let (u, v) = (cos0 - cos, sin0 + sin);
                Vector::new(sin_phi * u, cos_phi * u, v) * self.radius
            }
        };
        Pose {
            rotation: Rotation::about(self.axis, mu),
            p,
        }
    }
}
