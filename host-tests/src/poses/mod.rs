//! Poses -> joint blocks within the tolerances, for every machine; and back from the pulses to the tool.
//!
//! ```text
//! PosesJob -> plan    Follower over the machine's Guide   -> joint blocks, durations, levers
//!          -> run::poses  the controller of the target    -> pulses
//!          -> measure reference::Forward on the pulses    -> how far tip and tool were off
//! ```

mod measure;
mod plan;

pub use measure::{Measured, Sample};
pub use plan::{CHORDS, Plan, PlannedBlock};
