//! State, position and refusals as text. Every line ends with CR LF.

use crate::math::Real;
use crate::settings::AXES;
use core::fmt::{Display, Formatter, Result};
use fixed::types::I32F32;

/// What the machine is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    Idle,
    Run,
    Jog,
    /// In a feed hold, or on the way into it.
    Hold {
        moving: bool,
    },
    Alarm,
}

/// What senders take as proof of life, and of lost buffers.
pub const BANNER: &str = "\r\nGrbl 1.1h ['$' for help]\r\n";

/// A status report: `<State|MPos:...>`, positions shown in mm and degrees.
#[derive(Clone, Copy, Debug)]
pub struct Status<const N: usize = AXES> {
    pub state: State,
    /// From one snapshot [steps].
    pub positions: [I32F32; N],
    pub steps_per_unit: [f32; N],
    /// Free blocks of the planner, free bytes of the receiver.
    pub free: (usize, usize),
    /// Whether the work offset is told.
    pub offset: bool,
    /// Feed and rapid override [percent], when they are told.
    pub overrides: Option<(u8, u8)>,
}

impl<const N: usize> Display for Status<N> {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        let name = match self.state {
            State::Idle => "Idle",
            State::Run => "Run",
            State::Jog => "Jog",
            State::Hold { moving: false } => "Hold:0",
            State::Hold { moving: true } => "Hold:1",
            State::Alarm => "Alarm",
        };
        write!(out, "<{name}|MPos:")?;
        for i in 0..N {
            // In f64: a position of 2^31 steps has more digits than an f32.
            let value = self.positions[i].to_num::<f64>() / f64::from(self.steps_per_unit[i]);
            let comma = if i == 0 { "" } else { "," };
            // Rounded first, so that a hair below zero does not read -0.000.
            let thousandths = Real::round(value * 1000.0) as i64;
            let sign = if thousandths < 0 { "-" } else { "" };
            let size = thousandths.unsigned_abs();
            write!(out, "{comma}{sign}{}.{:03}", size / 1000, size % 1000)?;
        }
        write!(out, "|Bf:{},{}|FS:0,0", self.free.0, self.free.1)?;
        if self.offset {
            write!(out, "|WCO:0.000")?;
            for _ in 1..N {
                write!(out, ",0.000")?;
            }
        }
        if let Some((feed, rapid)) = self.overrides {
            write!(out, "|Ov:{feed},{rapid},100")?;
        }
        write!(out, ">\r\n")
    }
}
