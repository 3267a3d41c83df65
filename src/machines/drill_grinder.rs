//! The drill grinder: three slides and a spherical wrist that carries the drill, 3P3R.
//!
//! ```text
//!   z, d1 up          seen from above          the table is swivelled so that d2 is
//!   |                                          the horizontal normal of the lip:
//!   |   n: tip -> shank                          d2 > 0 leaves the wheel
//!   o------> x
//!    \                tip <---- L1 ---- wrist centre, L2 beside the pillar
//!     y                                  theta1 about z, theta2 about y, theta3 about the drill
//! ```
//!
//! Joints, in the order of the motors: `d1, d2, d3` [mm], `theta1, theta2, theta3` [rad]. All zero is home: the drill
//! points along -x, its tip at (-L1, -L2, 0). With R = Rz(theta1) Ry(theta2) Rx(theta3), columns n, s, a:
//!
//! ```text
//! p  = (Dx, Dy, d1) + Rz(theta1) (0, -L2, 0) + R (-L1, 0, 0)
//! Dx = sin phi0 d2 - cos phi0 d3,   Dy = cos phi0 d2 + sin phi0 d3
//! ```
//!
//! Branch: cos theta2 >= 0. It is singular at theta2 = +-90 deg, where theta1 keeps its value.
//!
//! Source: Li & Chen, Research on kinematic synthesis of a robot manipulator for drill grinding, equations (2) and
//! (11)-(16); arctangents of two arguments throughout.

use crate::geometry::{Pose, Rotation, Vector};
use crate::joints::Joints;
use crate::kinematics::{Error, Kinematics, nearest_turn, principal};
use crate::math::Real;

/// The arm's structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillGrinder<R> {
    /// Sine and cosine of half the point angle, by which the table is swivelled.
    sin_phi0: R,
    cos_phi0: R,
    l1: R,
    l2: R,
}

/// A structure that is no arm; the field by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StructureError {
    NotFinite(&'static str),
    OutOfRange(&'static str),
}

impl<R: Real> DrillGrinder<R> {
    /// `point_angle` 2 phi0 of the drill to which the table is set [rad], in (0, pi); `l1` from the wrist to the
    /// drill's tip and `l2` of the wrist's offset [mm], at least 0.
    pub fn new(point_angle: R, l1: R, l2: R) -> Result<Self, StructureError> {
        let fields = [("point_angle", point_angle), ("l1", l1), ("l2", l2)];
        if let Some((name, _)) = fields.iter().find(|(_, x)| !x.is_finite()) {
            return Err(StructureError::NotFinite(name));
        }
        let good = [
            point_angle > R::ZERO && point_angle < R::PI,
            l1 >= R::ZERO,
            l2 >= R::ZERO,
        ];
        if let Some(((name, _), _)) = fields.iter().zip(good).find(|(_, good)| !good) {
            return Err(StructureError::OutOfRange(name));
        }
        let (sin_phi0, cos_phi0) = (point_angle * R::HALF).sin_cos();
        Ok(Self {
            sin_phi0,
            cos_phi0,
            l1,
            l2,
        })
    }

    /// The tip's place at home, in the machine frame [mm].
    pub fn home_tip(&self) -> Vector<R> {
        Vector::new(-self.l1, -self.l2, R::ZERO)
    }

    /// The direction of positive d2 in the machine frame: straight away from the wheel.
    pub fn away(&self) -> Vector<R> {
        Vector::new(self.sin_phi0, self.cos_phi0, R::ZERO)
    }

    /// The joints that reach a pose, angles in (-pi, pi]; `theta1` [rad] is kept where the pose leaves it free.
    pub fn principal(&self, pose: &Pose<R>, theta1: R) -> Result<Joints<6, R>, Error> {
        let Rotation { n, s, a } = pose.rotation;
        let p = pose.p;
        let finite = [n, s, a, p].iter().all(|v| v.is_finite()) && theta1.is_finite();
        if !finite {
            return Err(Error::NotFinite);
        }
        let h = n.x.hypot(n.y);
        // Below this the direction of n in the plane is rounding noise. 1e-9 for f64; f32 needs 2e-6, which turns the
        // drill by 0.0001 deg at most.
        let singular = h < R::of(1e-9).max(R::EPSILON * R::of(16.0));
        let theta1 = if singular { theta1 } else { n.y.atan2(n.x) };
        let (s1, c1) = theta1.sin_cos();
        let (theta2, theta3) = if !singular {
            (
                (-n.z).atan2(n.x * c1 + n.y * s1),
                (a.x * s1 - a.y * c1).atan2(-s.x * s1 + s.y * c1),
            )
        } else if n.z < R::ZERO {
            ((-n.z).atan2(h), theta1 + s.x.atan2(s.y))
        } else {
            ((-n.z).atan2(h), (-s.x).atan2(s.y) - theta1)
        };
        let (s2, c2) = theta2.sin_cos();
        let x = p.x + self.l1 * c1 * c2 - self.l2 * s1;
        let y = p.y + self.l1 * s1 * c2 + self.l2 * c1;
        let joints = Joints([
            p.z - self.l1 * s2,
            self.sin_phi0 * x + self.cos_phi0 * y,
            self.sin_phi0 * y - self.cos_phi0 * x,
            principal(theta1),
            theta2,
            principal(theta3),
        ]);
        if joints.is_finite() {
            Ok(joints)
        } else {
            Err(Error::OutOfReach)
        }
    }
}

impl<R: Real> Kinematics<6, R> for DrillGrinder<R> {
    fn forward(&self, joints: &Joints<6, R>) -> Pose<R> {
        let Joints([d1, d2, d3, theta1, theta2, theta3]) = *joints;
        let (s1, c1) = theta1.sin_cos();
        let (s2, c2) = theta2.sin_cos();
        let (s3, c3) = theta3.sin_cos();
        let rotation = Rotation {
            n: Vector::new(c1 * c2, s1 * c2, -s2),
            s: Vector::new(c1 * s2 * s3 - s1 * c3, s1 * s2 * s3 + c1 * c3, c2 * s3),
            a: Vector::new(c1 * s2 * c3 + s1 * s3, s1 * s2 * c3 - c1 * s3, c2 * c3),
        };
        let table = Vector::new(
            self.sin_phi0 * d2 - self.cos_phi0 * d3,
            self.cos_phi0 * d2 + self.sin_phi0 * d3,
            d1,
        );
        let pillar = Vector::new(self.l2 * s1, -self.l2 * c1, R::ZERO);
        Pose {
            rotation,
            p: table + pillar - rotation.n * self.l1,
        }
    }

    fn inverse(&self, pose: &Pose<R>, near: &Joints<6, R>) -> Result<Joints<6, R>, Error> {
        if !near.is_finite() {
            return Err(Error::NotFinite);
        }
        let mut joints = self.principal(pose, near[3])?;
        for turning in [3, 5] {
            joints[turning] = nearest_turn(joints[turning], near[turning]);
        }
        Ok(joints)
    }
}
