//! Continuous precession: poses against the printed figures, against their definition, in single precision; refusals.
//!
//! Figures with a section number are those of the specification of continuous precession.

mod common;
mod definition;
mod printed;
mod refused;
#[path = "../common/mod.rs"]
mod shared;
mod single;
mod stream;
