//! What a user may set: one table of numbers, names, units, ranges and defaults.
//!
//! Numbers follow Grbl 1.1 and grblHAL where one exists; from 1000 on they are ours. An axis setting stands for six
//! numbers, one for each motor: X Y Z A B C, or d1 d2 d3 theta1 theta2 theta3 on the drill grinder.

use crate::error::Error;
use crate::math::Real;
use crate::planner::{Limits, LimitsError, MOST_TRIM, PathSetting};
use crate::stepper::{StepMode, Timing};

/// Motors of the controller.
pub const AXES: usize = 6;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// `$` number; of the first axis, if there is one for each.
    pub number: u16,
    pub per_axis: bool,
    pub name: &'static str,
    pub unit: &'static str,
    pub range: (f32, f32),
    /// Default of the sliding and of the turning axes (the same for a single setting).
    pub default: (f32, f32),
}

const fn single(
    number: u16,
    name: &'static str,
    unit: &'static str,
    range: (f32, f32),
    default: f32,
) -> Row {
    Row {
        number,
        per_axis: false,
        name,
        unit,
        range,
        default: (default, default),
    }
}

const fn axis(
    number: u16,
    name: &'static str,
    unit: &'static str,
    range: (f32, f32),
    default: (f32, f32),
) -> Row {
    Row {
        number,
        per_axis: true,
        name,
        unit,
        range,
        default,
    }
}

const POSITIVE: f32 = 1e-6;
const LARGE: f32 = 1e9;

/// The table, ascending.
pub const TABLE: [Row; 15] = [
    single(0, "step pulse", "us", (1.0, 25.0), 2.0),
    single(29, "direction set-up", "us", (0.0, 1000.0), 1.0),
    axis(
        100,
        "steps per unit",
        "1/mm, 1/deg",
        (POSITIVE, 1e6),
        (1000.0, 2000.0),
    ),
    axis(
        110,
        "maximum rate",
        "mm/min, deg/min",
        (POSITIVE, LARGE),
        (3000.0, 3600.0),
    ),
    axis(
        120,
        "acceleration",
        "mm/s2, deg/s2",
        (POSITIVE, LARGE),
        (400.0, 400.0),
    ),
    axis(
        800,
        "jerk",
        "mm/s3, deg/s3",
        (POSITIVE, 1e12),
        (40_000.0, 40_000.0),
    ),
    single(1003, "contour tolerance", "mm", (0.0, 10.0), 0.01),
    single(
        1004,
        "lever of the turning axes: their tool's distance",
        "mm",
        (0.001, 10_000.0),
        150.0,
    ),
    single(
        1010,
        "step mode (0 pulse, 1 both edges)",
        "",
        (0.0, 1.0),
        0.0,
    ),
    single(1011, "direction hold", "us", (0.0, 1000.0), 1.0),
    single(
        1012,
        "motion on the internal oscillator (0 refused, 1 allowed)",
        "",
        (0.0, 1.0),
        0.0,
    ),
    single(
        1013,
        "share of the motors' limits that is kept for trims (0: no trims)",
        "",
        (0.0, 0.5),
        0.0,
    ),
    axis(1030, "largest trim", "mm, deg", (0.0, 10.0), (0.1, 0.1)),
    axis(
        1040,
        "travel, lower end",
        "mm, deg",
        (-LARGE, LARGE),
        (-200.0, -360.0),
    ),
    axis(
        1050,
        "travel, upper end",
        "mm, deg",
        (-LARGE, LARGE),
        (200.0, 360.0),
    ),
];

/// Numbers of the rows that code refers to.
const PULSE: usize = 0;
const SETUP: usize = 1;
const STEPS: usize = 2;
const RATE: usize = 3;
const ACCELERATION: usize = 4;
const JERK: usize = 5;
const TOLERANCE: usize = 6;
const LEVER: usize = 7;
const MODE: usize = 8;
const HOLD: usize = 9;
const INTERNAL_CLOCK: usize = 10;
const TRIM_SHARE: usize = 11;
const TRIM_BOUND: usize = 12;
const LOWER: usize = 13;
const UPPER: usize = 14;

/// Axes from this one on turn.
const FIRST_TURNING: usize = 3;

/// The values: a row of the table has one for each axis, a single one its first.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    values: [[f32; AXES]; TABLE.len()],
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            values: TABLE.map(|row| {
                core::array::from_fn(|i| {
                    if i < FIRST_TURNING {
                        row.default.0
                    } else {
                        row.default.1
                    }
                })
            }),
        }
    }
}

impl Settings {
    /// The value behind a `$` number.
    pub fn get(&self, number: u16) -> Option<f32> {
        let (row, axis) = find(number)?;
        Some(self.values[row][axis])
    }

    /// Stores a value; refused with nothing changed if it is out of range, or if the whole would not work.
    pub fn set(&mut self, number: u16, value: f32, hz: u32) -> Result<(), Error> {
        let (row, axis) = find(number).ok_or(Error::UnknownCommand)?;
        let Row {
            range: (lo, hi), ..
        } = TABLE[row];
        if value < 0.0 && lo >= 0.0 {
            return Err(Error::Negative);
        }
        if row == PULSE && value < lo {
            return Err(Error::PulseTooShort);
        }
        if value <= 0.0 && lo > 0.0 {
            return Err(Error::NotPositive);
        }
        if !(value >= lo && value <= hi) {
            return Err(Error::ValueRange);
        }
        let mut changed = self.clone();
        changed.values[row][axis] = value;
        changed.limits(hz).map_err(|e| match e {
            LimitsError::Velocity { .. } => Error::StepRate,
            _ => Error::ValueRange,
        })?;
        let (lower, upper) = changed.travel();
        if lower.iter().zip(upper).any(|(lo, hi)| *lo > hi) {
            return Err(Error::ValueRange);
        }
        *self = changed;
        Ok(())
    }

    /// All numbers with their values, ascending.
    pub fn all(&self) -> impl Iterator<Item = (u16, f32)> + '_ {
        TABLE.iter().zip(&self.values).flat_map(|(row, values)| {
            let count = if row.per_axis { AXES } else { 1 };
            (row.number..).zip(values.iter().copied()).take(count)
        })
    }

    /// Times of the drivers, for a step timer of `hz` counts per second.
    pub fn timing(&self, hz: u32) -> Timing {
        let ns = |row: usize| Real::round(self.values[row][0] * 1000.0) as u32;
        Timing::from_ns(hz, ns(PULSE), ns(SETUP), ns(HOLD), self.step_mode())
    }

    pub fn step_mode(&self) -> StepMode {
        if self.values[MODE][0] >= 0.5 {
            StepMode::BothEdge
        } else {
            StepMode::Pulse
        }
    }

    /// Whether motors may run although the clock failed.
    pub fn allows_internal_clock(&self) -> bool {
        self.values[INTERNAL_CLOCK][0] >= 0.5
    }

    /// What each motor may do, in steps.
    pub fn limits(&self, hz: u32) -> Result<Limits<AXES>, LimitsError> {
        let steps = self.values[STEPS];
        let velocity: [f32; AXES] =
            core::array::from_fn(|i| self.values[RATE][i] / 60.0 * steps[i]);
        let fastest = self.timing(hz).fastest() as f32;
        if let Some(joint) = velocity.iter().position(|v| *v > fastest) {
            return Err(LimitsError::Velocity { joint });
        }
        Limits::new(
            velocity,
            core::array::from_fn(|i| self.values[ACCELERATION][i] * steps[i]),
            core::array::from_fn(|i| self.values[JERK][i] * steps[i]),
        )
    }

    /// How far each step carries the tool, and how far the tool may leave the path: the tolerance set, or `most` [mm].
    pub fn path(&self, most: f32) -> Option<PathSetting<AXES>> {
        let mut weight = self.steps_per_joint_unit().map(|steps| 1.0 / steps);
        for turning in &mut weight[FIRST_TURNING..] {
            *turning *= self.values[LEVER][0];
        }
        PathSetting::new(weight, Real::min(self.values[TOLERANCE][0], most)).ok()
    }

    /// Share of each motor's limits that is kept for trims.
    pub fn trim_share(&self) -> f32 {
        self.values[TRIM_SHARE][0]
    }

    /// Largest trim of each motor [steps].
    pub fn trim_bound(&self) -> [i32; AXES] {
        let bound = |i| Real::round(self.values[TRIM_BOUND][i] * self.values[STEPS][i]) as i32;
        core::array::from_fn(|i| bound(i).min(MOST_TRIM))
    }

    /// Steps per mm or degree.
    pub fn steps_per_unit(&self) -> [f32; AXES] {
        self.values[STEPS]
    }

    /// Steps per mm or radian: the joints' own units.
    pub fn steps_per_joint_unit(&self) -> [f32; AXES] {
        let mut steps = self.values[STEPS];
        for turning in &mut steps[FIRST_TURNING..] {
            *turning *= 180.0 / core::f32::consts::PI;
        }
        steps
    }

    /// Lower and upper end of each axis [steps].
    pub fn travel(&self) -> ([i32; AXES], [i32; AXES]) {
        let steps = self.values[STEPS];
        // Casts saturate, which is what an end beyond the counter means.
        let at = |row: usize| {
            core::array::from_fn(|i| Real::round(self.values[row][i] * steps[i]) as i32)
        };
        (at(LOWER), at(UPPER))
    }
}

/// Row and axis of a `$` number.
fn find(number: u16) -> Option<(usize, usize)> {
    TABLE.iter().enumerate().find_map(|(i, row)| {
        let axis = usize::from(number.checked_sub(row.number)?);
        let count = if row.per_axis { AXES } else { 1 };
        (axis < count).then_some((i, axis))
    })
}
