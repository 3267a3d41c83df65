//! Pose <-> joints.
//!
//! A kinematics knows geometry and nothing else: no limits, no homing, no speeds. *Near* is the joint vector that
//! comes before on the path: of the joint vectors that reach a pose, the inverse returns the one on its own branch
//! whose turning joints are within half a turn of `near`, and where a joint is free (a singular pose) it stays put.

pub mod chain;
pub mod chord;
pub mod follow;
pub mod inverse;
pub mod way;

pub use way::{ClPoint, Course, PoseWay, Way};

use crate::geometry::Pose;
use crate::joints::Joints;
use crate::math::Real;

pub trait Kinematics<const N: usize, R: Real> {
    /// The tool's pose in the machine frame [mm] at these joints [mm, rad].
    fn forward(&self, joints: &Joints<N, R>) -> Pose<R>;

    /// The joints [mm, rad] that reach a pose, nearest to `near`.
    fn inverse(&self, pose: &Pose<R>, near: &Joints<N, R>) -> Result<Joints<N, R>, Error>;
}

/// Why a pose has no joints.
///
/// As wide as a number: beside a single byte, joints in a `Result` are copied byte by byte (140 instructions a copy).
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// The pose or the joints before it hold a number that is not finite.
    NotFinite,
    /// No joints reach the pose.
    OutOfReach,
}

/// The angle that differs from `angle` by whole turns and lies within half a turn of `near` [rad].
pub fn nearest_turn<R: Real>(angle: R, near: R) -> R {
    angle + R::TAU * ((near - angle) / R::TAU).round()
}

/// The same angle in (-pi, pi] [rad].
pub fn principal<R: Real>(angle: R) -> R {
    // A sum of two angles of this range needs one turn at most: no division there.
    let near = if angle.abs() < R::of(9.0) {
        angle
    } else {
        nearest_turn(angle, R::ZERO)
    };
    if near > R::PI {
        near - R::TAU
    } else if near <= -R::PI {
        (near + R::TAU).min(R::PI)
    } else {
        near
    }
}
