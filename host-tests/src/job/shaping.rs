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

/// As many entries as there are motors in a list, each at its motor's place; the others get a default.
macro_rules! spread {
    ($motors:expr, $default:expr, $read:ident ($($argument:expr),*), $table:expr) => {{
        let mut all = [$default; 6];
        let mut put = |found: &[_]| {
            for (motor, value) in $motors.iter().zip(found) {
                all[*motor] = *value;
            }
        };
        match $motors.len() {
            1 => put(&$table.$read::<1>($($argument),*)?),
            2 => put(&$table.$read::<2>($($argument),*)?),
            3 => put(&$table.$read::<3>($($argument),*)?),
            4 => put(&$table.$read::<4>($($argument),*)?),
            5 => put(&$table.$read::<5>($($argument),*)?),
            _ => put(&$table.$read::<6>($($argument),*)?),
        }
        all
    }};
}

fn numbers(
    motors: &[usize],
    machine: &Table<'_>,
    key: &str,
    default: f64,
    kind: Kind,
) -> Result<[f64; 6], JobError> {
    if !machine.has(key) {
        return Ok([default; 6]);
    }
    Ok(spread!(motors, default, numbers(key, kind), machine))
}

fn words(motors: &[usize], machine: &Table<'_>) -> Result<[usize; 6], JobError> {
    if !machine.has("shaper") {
        return Ok([0; 6]);
    }
    Ok(spread!(motors, 0, words("shaper", &SHAPERS), machine))
}

impl Shaping {
    /// All keys may be left out; `flexible` asks for `flexible_hz`. `joints` are those of the path's table, `names` what it
    /// calls the motors: as for the limits there is one entry for each of the six, or one for each of these.
    pub(super) fn read(
        joints: &[usize],
        names: &[String; 6],
        machine: &Table<'_>,
        places: &Places,
    ) -> Result<Self, JobError> {
        let six: Vec<usize> = (0..MOTORS.len()).collect();
        let own = match machine.length("steps_per_unit") {
            Some(length) if length == joints.len() => joints,
            _ => &six,
        };
        let damping = || Kind::between(0.0, MOST_DAMPING, "");
        let kinds = words(own, machine)?;
        let hz = numbers(
            own,
            machine,
            "shaper_hz",
            HZ,
            Kind::between(0.1, MOST_HZ, "Hz"),
        )?;
        let hz_2 = numbers(
            own,
            machine,
            "shaper_hz_2",
            0.0,
            Kind::between(0.0, MOST_HZ, "Hz"),
        )?;
        let damping_1 = numbers(own, machine, "shaper_damping", 0.0, damping())?;
        let damping_2 = numbers(own, machine, "shaper_damping_2", 0.0, damping())?;
        let flexible = if machine.has("flexible") {
            // By the names of the path's own joints, or those of the motors.
            let known: Vec<&str> = names.iter().map(String::as_str).chain(MOTORS).collect();
            let known = if names[..] == MOTORS {
                &MOTORS
            } else {
                &known[..]
            };
            Some(FlexibleJoint {
                motor: machine.word("flexible", known)? % MOTORS.len(),
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
