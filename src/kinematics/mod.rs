//! Pose <-> Joints: what every machine shares.

pub mod chain;
pub mod inverse;
