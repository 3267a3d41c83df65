//! State, position and refusals as text. Every line ends with CR LF.

use crate::math::Real;
use crate::settings::AXES;
use core::fmt::{Result, Write};
use fixed::types::I32F32;

/// What the machine is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Idle,
    Run,
    Alarm,
}

/// What senders take as proof of life, and of lost buffers.
pub const BANNER: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";

/// `<State|MPos:...>`: positions from one snapshot [steps], shown in mm and degrees.
pub fn status(
    out: &mut impl Write,
    state: State,
    positions: &[I32F32; AXES],
    steps_per_unit: &[f32; AXES],
    free: (usize, usize),
    with_offset: bool,
) -> Result {
    let name = match state {
        State::Idle => "Idle",
        State::Run => "Run",
        State::Alarm => "Alarm",
    };
    write!(out, "<{name}|MPos:")?;
    for i in 0..AXES {
        // In f64: a position of 2^31 steps has more digits than an f32.
        let value = positions[i].to_num::<f64>() / f64::from(steps_per_unit[i]);
        let comma = if i == 0 { "" } else { "," };
        // Rounded first, so that a hair below zero does not read -0.000.
        let thousandths = Real::round(value * 1000.0) as i64;
        let sign = if thousandths < 0 { "-" } else { "" };
        let size = thousandths.unsigned_abs();
        write!(out, "{comma}{sign}{}.{:03}", size / 1000, size % 1000)?;
    }
    write!(out, "|Bf:{},{}|FS:0,0", free.0, free.1)?;
    if with_offset {
        write!(out, "|WCO:0.000,0.000,0.000,0.000,0.000,0.000")?;
    }
    write!(out, ">\r\n")
}
