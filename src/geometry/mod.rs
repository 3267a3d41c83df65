//! Vectors, rotations and rigid poses: the plain values that every stage above the joints speaks in.
//!
//! All are generic over [`Real`](crate::math::Real). Lengths in millimetres, angles in radians, right-handed frames.

pub mod nurbs;
pub mod pose;
pub mod rotation;
pub mod twist;
pub mod vector;
pub mod waypoint;

pub use nurbs::Nurbs;
pub use pose::Pose;
pub use rotation::Rotation;
pub use twist::Twist;
pub use vector::Vector;
pub use waypoint::Waypoint;
