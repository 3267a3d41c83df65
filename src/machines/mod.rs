//! Machines: each turns poses of the tool into its own joints. One folder or file a machine.

pub mod five_axis;

pub use five_axis::FiveAxis;
