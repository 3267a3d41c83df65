//! hexstep: bytes enter, pulses leave.
//!
//! ```text
//! bytes
//!   | serial interrupt     protocol::Receiver      u8, real-time flags
//!   v                                              ---- queue of u8 ----
//!   | foreground           protocol                bytes    -> Line
//!   |  Controller::poll    path        <- cycles   Motion   -> Waypoint (pose, duration)
//!   |                      kinematics  <- machines Pose     -> Joints<N>
//!   |                      planner                 Joints   -> Block<N>
//!   |                      shaper                  Sample   -> Sample           each a millisecond
//!   |                      stepper::Segmenter      Sample   -> Segment<N>       float ends here
//!   v                                              ---- queue of Segment<N> ----
//!   | step interrupt       stepper::Interpolator   Segment  -> levels
//!   v                      stepper::StepPort <- boards      -> pins
//! ```
//!
//! The downward arrow is the flow of data and the only direction in which `use` points. The library has no statics,
//! no `unsafe` and no operating system; it compiles unchanged for the target and for the host.
#![no_std]
#![forbid(unsafe_code)]

// In the order in which data flows; blank lines keep it.

pub mod board;

pub mod controller;

pub mod protocol;

pub mod program;

pub mod path;

pub mod cycles;

pub mod kinematics;

pub mod machines;

pub mod planner;

pub mod shaper;

pub mod stepper;

// The base, which every stage may use.
pub mod error;
pub mod geometry;
pub mod joints;
pub mod math;
pub mod settings;
