//! Machines: what their axes are, where their zero is, and their closed-form kinematics. One file each.

pub mod drill_grinder;

pub use drill_grinder::DrillGrinder;
