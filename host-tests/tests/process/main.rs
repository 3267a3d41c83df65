//! The processes of the papers as jobs: what they plan, what becomes pulses, what they refuse, and the page of them all.

mod all;
mod common;
mod csv;
mod mirror;
mod pair;
mod precession;
mod refused;
mod surface;
