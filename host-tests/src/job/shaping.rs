//! `shaper` and `flexible` of `[machine]`: what the motors' commands are shaped by, and a flexible joint to show it on.

use super::axes::MOTORS;
use super::reader::{Kind, Table};
use super::{JobError, Places};
use hexstep::shaper::design::{MOST_DAMPING, MOST_HZ};

/// Shapers of six motors, as the machine's settings have them, and a simulated joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Shaping {
    /// 0 off, 1 ZV, 2 ZVD, 3 EI, for each motor.
    pub kinds: [usize; 6],
    /// Frequency [Hz] and damping of the vibration, and of a second one where its frequency is not 0.
    pub first: [(f64, f64); 6],
    pub second: [(f64, f64); 6],
    pub flexible: Option<FlexibleJoint>,
}

/// A mass on a spring behind one motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlexibleJoint {
    pub motor: usize,
    /// [Hz]
    pub hz: f64,
    pub damping: f64,
}

/// Keys of `[machine]` that [`Shaping::read`] reads.
pub(super) const SHAPING: &[&str] = &[
    "shaper",
    "shaper_hz",
    "shaper_damping",
    "shaper_hz_2",
    "shaper_damping_2",
    "flexible",
    "flexible_hz",
    "flexible_damping",
];

/// Names of the shapers in a job file, by their numbers.
pub const SHAPERS: [&str; 4] = ["off", "zv", "zvd", "ei"];

/// Default of the machine's own table of settings [Hz].
const HZ: f64 = 25.0;

impl Shaping {
    /// All keys may be left out; `flexible` asks for `flexible_hz`.
    pub(super) fn read(machine: &Table<'_>, places: &Places) -> Result<Self, JobError> {
        let numbers = |key: &str, default: f64, kind: Kind| {
            if machine.has(key) {
                machine.numbers::<6>(key, kind)
            } else {
                Ok([default; 6])
            }
        };
        let damping = || Kind::between(0.0, MOST_DAMPING, "");
        let kinds = if machine.has("shaper") {
            machine.words::<6>("shaper", &SHAPERS)?
        } else {
            [0; 6]
        };
        let hz = numbers("shaper_hz", HZ, Kind::between(0.1, MOST_HZ, "Hz"))?;
        let hz_2 = numbers("shaper_hz_2", 0.0, Kind::between(0.0, MOST_HZ, "Hz"))?;
        let damping_1 = numbers("shaper_damping", 0.0, damping())?;
        let damping_2 = numbers("shaper_damping_2", 0.0, damping())?;
        let flexible = if machine.has("flexible") {
            Some(FlexibleJoint {
                motor: machine.word("flexible", &MOTORS)?,
                hz: machine.number("flexible_hz", Kind::between(0.1, MOST_HZ, "Hz"))?,
                damping: machine.number_or("flexible_damping", 0.0, damping())?,
            })
        } else if machine.has("flexible_hz") || machine.has("flexible_damping") {
            let detail =
                "a flexible joint needs the motor that it is behind; add flexible = \"d1\"";
            return Err(places.refuse("machine.flexible", "MissingField", detail.into()));
        } else {
            None
        };
        Ok(Self {
            kinds,
            first: std::array::from_fn(|i| (hz[i], damping_1[i])),
            second: std::array::from_fn(|i| (hz_2[i], damping_2[i])),
            flexible,
        })
    }

    /// Whether any motor's command is shaped.
    pub fn is_on(&self) -> bool {
        self.kinds.iter().any(|kind| *kind != 0)
    }

    /// The same with every shaper off.
    pub fn off(&self) -> Self {
        Self {
            kinds: [0; 6],
            ..self.clone()
        }
    }
}
