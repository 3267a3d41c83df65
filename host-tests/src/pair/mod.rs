//! A pair of machines on eight motors: rows of the panel -> joint blocks of both sides; and back from the pulses to the wall.
//!
//! ```text
//! PairRow -> plan       Follower over the library's PairGuide    -> blocks of eight joints, leg by leg
//!         -> run::pair  the controller of the target, the sensor's readings arriving while a row runs -> pulses
//!         -> measure    the reference on the pulses, both sides  -> wall, lateral and anti-parallel error, trim
//! ```

mod measure;
mod plan;

pub use measure::{PairMeasured, PairSample, RowMeasured};
pub use plan::{Leg, Milling, PairBlock, PairPlan, What};
