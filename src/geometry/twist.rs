//! A screw axis or a velocity: linear and angular part in one frame.
//!
//! ```text
//! rotary  : w unit, q a point on the axis, pitch H:  v = -w x q + H w
//! linear  : w = 0, v unit direction
//! exp(xi th), rotary: R = Rot(w, th),  p = (I - R)(w x v) + w (w.v) th ;   linear: R = I, p = v th
//! ```
//!
//! `w x v` is the foot of the perpendicular from the origin on the axis, and `(I - R)(w x v)` is written out as
//! `(1 - cos) foot + sin (v - w (w.v))`, which builds no matrix and loses nothing at small angles.
//!
//! Source: Liu et al., "Kinematic modeling and automatic trajectory adjustment for mirror milling based on screw
//! theory" (2024), section 2; the notation is that of Murray, Li and Sastry.

use super::{Pose, Rotation, Vector};
use crate::math::Real;
use core::ops::{Add, Mul, Neg};

/// Shortest vector that is still taken as a direction.
pub const LEAST_DIRECTION: f64 = 1e-6;

/// Linear part `v` [mm per joint unit] of the body point at the origin, angular part `w` [rad per joint unit].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<R> {
    pub v: Vector<R>,
    pub w: Vector<R>,
}

impl<R: Real> Twist<R> {
    pub const ZERO: Self = Self {
        v: Vector::ZERO,
        w: Vector::ZERO,
    };

    /// Unit twist of a turning joint: `axis` any length from 1e-6, `point` on it [mm], `pitch` [mm/rad] (0: no screw).
    /// `None` if the axis is shorter or a number is not finite.
    pub fn rotary(axis: Vector<R>, point: Vector<R>, pitch: R) -> Option<Self> {
        let w = axis.unit(R::of(LEAST_DIRECTION))?;
        let v = point.cross(w) + w * pitch;
        v.is_finite().then_some(Self { v, w })
    }

    /// Unit twist of a sliding joint. `None` if the axis is shorter than 1e-6 or not finite.
    pub fn linear(axis: Vector<R>) -> Option<Self> {
        let v = axis.unit(R::of(LEAST_DIRECTION))?;
        Some(Self { v, w: Vector::ZERO })
    }

    /// The displacement after `theta` [rad or mm] along this unit twist.
    pub fn exp(self, theta: R) -> Pose<R> {
        if self.w == Vector::ZERO {
            return Pose {
                rotation: Rotation::IDENTITY,
                p: self.v * theta,
            };
        }
        let (sin, cos) = theta.sin_cos();
        let pitch = self.w.dot(self.v);
        let foot = self.w.cross(self.v);
        let across = self.v - self.w * pitch;
        Pose {
            rotation: Rotation::about(self.w, theta),
            p: foot * (R::ONE - cos) + across * sin + self.w * (pitch * theta),
        }
    }

    /// The same twist written in the frame in which `pose` is given (the adjoint map of `pose`).
    pub fn moved_by(self, pose: Pose<R>) -> Self {
        let w = pose.rotation * self.w;
        Self {
            v: pose.rotation * self.v + pose.p.cross(w),
            w,
        }
    }

    /// Velocity of the body point that is now at `point` [mm per joint unit].
    pub fn velocity_at(self, point: Vector<R>) -> Vector<R> {
        self.v + self.w.cross(point)
    }

    /// `[vx, vy, vz, wx, wy, wz]`.
    pub fn to_array(self) -> [R; 6] {
        let (v, w) = (self.v, self.w);
        [v.x, v.y, v.z, w.x, w.y, w.z]
    }
}

impl<R: Real> Add for Twist<R> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            v: self.v + o.v,
            w: self.w + o.w,
        }
    }
}

impl<R: Real> Neg for Twist<R> {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            v: -self.v,
            w: -self.w,
        }
    }
}

impl<R: Real> Mul<R> for Twist<R> {
    type Output = Self;
    fn mul(self, k: R) -> Self {
        Self {
            v: self.v * k,
            w: self.w * k,
        }
    }
}
