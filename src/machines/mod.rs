//! Machines: what their axes are, where their zero is, and their closed-form kinematics. One file or folder each, and
//! [`rotary_pair`], the closed form that machines with two rotaries share.

pub mod arm;
pub mod drill_grinder;
pub mod five_axis;
pub mod rotary_pair;
pub mod two_sided;

pub use arm::Arm;
pub use drill_grinder::DrillGrinder;
pub use five_axis::FiveAxis;
