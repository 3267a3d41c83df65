//! Process cycles: each turns the parameters of a process into waypoints. One file or folder each.
//!
//! A cycle's parameters are checked when it is built, so iterating cannot fail, and a copy can be walked for checking.

pub mod drill_point;
pub mod mirror_bias;
pub mod mirror_trim;
pub mod precession;
pub mod surface_grinding;
