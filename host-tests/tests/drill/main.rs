//! The drill: from its geometry to joints, and the point that simulated grinding leaves.
//!
//! Figures with a section number are those of the drill-grinding specification.

mod arm;
mod common;
mod cycle;
mod ground;
mod motion;
mod point;
mod returns;
mod single;
