//! Poses into joints: what every machine offers, and how a path of poses is followed.

pub mod follow;
