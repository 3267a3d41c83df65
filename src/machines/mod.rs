//! Machines: what their axes are, where their zero is, and their closed-form kinematics. One file or folder each.

pub mod drill_grinder;
pub mod five_axis;

pub use drill_grinder::DrillGrinder;
pub use five_axis::FiveAxis;
