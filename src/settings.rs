//! What a user may set: one table of numbers, names, units, ranges and defaults.
//!
//! Numbers follow Grbl 1.1 and grblHAL where one exists; from 1000 on they are ours. An axis setting stands for as many
//! numbers as there are motors, six or eight: X Y Z A B C U V. They are d1 d2 d3 theta1 theta2 theta3 on the drill grinder,
//! and X1 Y1 Z1 B1 X2 Y2 Z2 B2 on the two-sided machine.
//!
//! The first three motors slide; `$376` tells which of the others turn, bit 0 for motor 3. The unit of a motor's settings
//! follows from it: a changed bit changes what its other numbers mean, not the numbers.
//!
//! Some settings bound each other: a pulse width bounds the step rates, a jerk the acceleration. Who has a whole set puts
//! it in and checks it once; line by line, no consistent set is refused in this order: `$110 ...`, `$120 ...`, `$800 ...`
//! to next to nothing, the travel to its widest and the shapers `$1200 ...` off, then all the others, then `$800 ...`,
//! `$120 ...`, `$110 ...` and `$1200 ...` to what they are to be.

use crate::error::Error;
use crate::math::Real;
use crate::planner::{Limits, LimitsError, MOST_JERK, MOST_TRIM, PathSetting};
use crate::shaper::design::{MOST_DAMPING, MOST_HZ};
use crate::shaper::{Design, Kind, Mode, Reason, Refusal, Wish};
use crate::stepper::{StepMode, Timing};
use core::fmt::{self, Display, Formatter};

/// Motors of the usual machine.
pub const AXES: usize = 6;

/// Most motors: each axis setting leaves room for so many numbers before the next row begins.
pub const MOST_AXES: usize = 8;

/// Letters of the motors, in their order.
pub const LETTERS: &str = "XYZABCUV";

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
/// Lowest frequency that may be set; what a shaper can hold is above it [Hz].
const LEAST_HZ: f32 = 0.1;

/// The table, ascending.
pub const TABLE: [Row; 22] = [
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
    // Its default goes by the number of motors, see `default_turning`.
    single(
        376,
        "motors that turn (mask, bit 0 for the fourth motor)",
        "",
        (0.0, 31.0),
        7.0,
    ),
    axis(
        800,
        "jerk, 0 for no limit",
        "mm/s3, deg/s3",
        (0.0, 1e12),
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
        1005,
        "tolerance of rapids, but the first behind a feed, if more than that of the contour",
        "mm",
        (0.0, 10.0),
        0.5,
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
    axis(
        1200,
        "shaper (0 off, 1 ZV, 2 ZVD, 3 EI for 5 %)",
        "",
        (0.0, 3.0),
        (0.0, 0.0),
    ),
    axis(
        1210,
        "frequency of the vibration",
        "Hz",
        (LEAST_HZ, MOST_HZ as f32),
        (25.0, 25.0),
    ),
    axis(
        1220,
        "damping of the vibration",
        "",
        (0.0, MOST_DAMPING as f32),
        (0.0, 0.0),
    ),
    axis(
        1230,
        "frequency of a second vibration (0: none)",
        "Hz",
        (0.0, MOST_HZ as f32),
        (0.0, 0.0),
    ),
    axis(
        1240,
        "damping of the second vibration",
        "",
        (0.0, MOST_DAMPING as f32),
        (0.0, 0.0),
    ),
];

/// Numbers of the rows that code refers to.
const PULSE: usize = 0;
const SETUP: usize = 1;
const STEPS: usize = 2;
const RATE: usize = 3;
const ACCELERATION: usize = 4;
const TURNING: usize = 5;
const JERK: usize = 6;
const TOLERANCE: usize = 7;
const LEVER: usize = 8;
const RAPID_TOLERANCE: usize = 9;
const MODE: usize = 10;
const HOLD: usize = 11;
const INTERNAL_CLOCK: usize = 12;
const TRIM_SHARE: usize = 13;
const TRIM_BOUND: usize = 14;
const LOWER: usize = 15;
const UPPER: usize = 16;
const SHAPER: usize = 17;
const SHAPER_HZ: usize = 18;
const SHAPER_DAMPING: usize = 19;
const SECOND_HZ: usize = 20;
const SECOND_DAMPING: usize = 21;

/// Motors before this one slide.
const FIRST_TURNING: usize = 3;

/// Which motors turn unless somebody says otherwise, as a mask from motor 0 on: all but the first three of six; of the
/// eight of a two-sided machine, the last one of each side.
const fn default_turning(motors: usize) -> u8 {
    if motors > AXES {
        0b1000_1000
    } else {
        0b11_1000
    }
}

/// Settings that do not bear each other. Displayed, it names them all by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// The rows, the one to begin with first: a lower limit and a wider travel are always taken.
    rows: &'static [usize],
    motor: usize,
    cause: Cause,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// One bounds the other.
    Bound,
    /// More steps a second are asked for than fit in with pulses of this width and mode: both.
    Rates { asked: u32, fit: u32 },
    /// There is no such shaper, or no room for it beside the others.
    Shaper(Refusal),
}

impl Conflict {
    pub fn error(&self) -> Error {
        match self.cause {
            Cause::Rates { .. } => Error::StepRate,
            Cause::Bound | Cause::Shaper(_) => Error::ValueRange,
        }
    }

    /// The shaper that cannot be, if it is one.
    pub fn shaper(&self) -> Option<Refusal> {
        match self.cause {
            Cause::Shaper(refusal) => Some(refusal),
            _ => None,
        }
    }

    /// The numbers of the settings, the one to begin with first.
    pub fn numbers(&self) -> impl Iterator<Item = u16> {
        // Of eight at the most.
        let motor = self.motor as u16;
        self.rows.iter().map(move |row| TABLE[*row].number + motor)
    }
}

impl Display for Conflict {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        out.write_str("see")?;
        for number in self.numbers() {
            write!(out, " ${number}")?;
        }
        match self.cause {
            Cause::Rates { asked, fit } => {
                write!(out, ": {asked} steps/s, and $0 $1010 allow {fit}")
            }
            Cause::Bound | Cause::Shaper(_) => Ok(()),
        }
    }
}

/// The values: a row of the table has one for each axis, a single one its first.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings<const N: usize = AXES> {
    values: [[f32; N]; TABLE.len()],
    /// All motors turn, whatever `$376` says: those of an arm.
    all_turn: bool,
}

impl<const N: usize> Default for Settings<N> {
    fn default() -> Self {
        const { assert!(N >= FIRST_TURNING && N <= MOST_AXES) };
        let turning = default_turning(N);
        let mut values = TABLE.map(|row| {
            core::array::from_fn(|i| {
                if turning >> i & 1 == 0 {
                    row.default.0
                } else {
                    row.default.1
                }
            })
        });
        values[TURNING] = [f32::from(turning >> FIRST_TURNING); N];
        Self {
            values,
            all_turn: false,
        }
    }
}

impl<const N: usize> Settings<N> {
    /// Whether all motors turn, as those of an arm do: it changes what their numbers mean, not the numbers.
    pub fn turn_all(&mut self, all: bool) {
        self.all_turn = all;
    }

    /// Largest speed of each motor [mm/s, rad/s].
    pub fn speeds(&self) -> [f32; N] {
        let scale = self.steps_per_joint_unit();
        core::array::from_fn(|i| {
            let steps = self.values[RATE][i] / 60.0 * self.values[STEPS][i];
            steps / scale[i]
        })
    }

    /// How far the tool may leave its path [mm].
    pub fn tolerance(&self) -> f32 {
        self.values[TOLERANCE][0]
    }

    /// How far rapids clear of the work may leave their way [mm].
    pub fn rapid_tolerance(&self) -> f32 {
        self.values[RAPID_TOLERANCE][0]
    }

    /// The value behind a `$` number.
    pub fn get(&self, number: u16) -> Option<f32> {
        let (row, axis) = find::<N>(number)?;
        Some(self.values[row][axis])
    }

    /// Stores a value that is within its own range, whatever the others are. Some bound each other: [`Self::check`]
    /// looks at them all once a whole set has been put in.
    pub fn put(&mut self, number: u16, value: f32) -> Result<(), Error> {
        let (row, axis) = find::<N>(number).ok_or(Error::UnknownCommand)?;
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
        if row == TURNING && !is_mask(value, N - FIRST_TURNING) {
            return Err(Error::ValueRange);
        }
        if row == SHAPER && Kind::of(value).is_none() {
            return Err(Error::ValueRange);
        }
        self.values[row][axis] = value;
        Ok(())
    }

    /// Whether the settings bear each other.
    pub fn check(&self, hz: u32) -> Result<(), Conflict> {
        let conflict = |rows, motor, cause| Err(Conflict { rows, motor, cause });
        match self.limits(hz) {
            // Within the table's ranges a rate is above 0, and faster than any pulse before it is beyond the planner.
            Err(LimitsError::Velocity { joint }) => {
                let asked = self.step_rates()[joint] as u32;
                let fit = self.timing(hz).fastest();
                return conflict(&[RATE, STEPS], joint, Cause::Rates { asked, fit });
            }
            Err(LimitsError::Acceleration { joint }) => {
                return conflict(&[ACCELERATION, STEPS], joint, Cause::Bound);
            }
            Err(LimitsError::Jerk { joint }) => {
                return conflict(&[JERK, STEPS], joint, Cause::Bound);
            }
            Err(LimitsError::Contradictory { joint }) => {
                return conflict(&[RATE, ACCELERATION, JERK], joint, Cause::Bound);
            }
            Ok(_) => {}
        }
        let (lower, upper) = self.travel();
        if let Some(motor) = lower.iter().zip(upper).position(|(lo, hi)| *lo > hi) {
            return conflict(&[LOWER, UPPER], motor, Cause::Bound);
        }
        match self.shapers() {
            Ok(_) => Ok(()),
            Err(refusal) => {
                let rows: &[usize] = match refusal.reason {
                    Reason::Kind => &[SHAPER],
                    Reason::Frequency => &[SHAPER, SHAPER_HZ, SECOND_HZ],
                    Reason::Damping => &[SHAPER, SHAPER_DAMPING, SECOND_DAMPING],
                    Reason::TooLong { .. } => {
                        &[SHAPER, SHAPER_HZ, SHAPER_DAMPING, SECOND_HZ, SECOND_DAMPING]
                    }
                };
                conflict(rows, refusal.joint, Cause::Shaper(refusal))
            }
        }
    }

    /// Largest step rate of each motor [steps/s].
    fn step_rates(&self) -> [f32; N] {
        core::array::from_fn(|i| self.values[RATE][i] / 60.0 * self.values[STEPS][i])
    }

    /// All numbers with their values, ascending.
    pub fn all(&self) -> impl Iterator<Item = (u16, f32)> + '_ {
        TABLE.iter().zip(&self.values).flat_map(|(row, values)| {
            let count = if row.per_axis { N } else { 1 };
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

    /// Motors that turn, bit i for motor i; the others slide.
    pub fn turning(&self) -> u8 {
        if self.all_turn {
            return 0xff;
        }
        (self.values[TURNING][0] as u8) << FIRST_TURNING
    }

    /// Whether the first six motors are those of a drill grinder.
    pub fn has_drill_grinder(&self) -> bool {
        self.turning() & 0b11_1111 == default_turning(AXES) && N >= AXES
    }

    /// What each motor may do, in steps.
    pub fn limits(&self, hz: u32) -> Result<Limits<N>, LimitsError> {
        let steps = self.values[STEPS];
        let velocity = self.step_rates();
        let fastest = self.timing(hz).fastest() as f32;
        if let Some(joint) = velocity.iter().position(|v| *v > fastest) {
            return Err(LimitsError::Velocity { joint });
        }
        Limits::new(
            velocity,
            core::array::from_fn(|i| self.values[ACCELERATION][i] * steps[i]),
            core::array::from_fn(|i| self.jerk(i) * steps[i]),
        )
    }

    /// Jerk of a joint [unit/s^3]: where it is switched off, that which brings the acceleration within a sixteenth of a sample;
    /// no ramp of the planner is shorter.
    fn jerk(&self, joint: usize) -> f32 {
        let off = self.values[ACCELERATION][joint] * 16_000.0;
        match self.values[JERK][joint] {
            jerk if jerk > 0.0 => jerk,
            _ => Real::min(off, MOST_JERK / self.values[STEPS][joint]),
        }
    }

    /// How far each step carries the tool, and how far the tool may leave the path: the tolerance set, or `most` [mm].
    pub fn path(&self, most: f32) -> Option<PathSetting<N>> {
        let mut weight = self.steps_per_joint_unit().map(|steps| 1.0 / steps);
        let turning = self.turning();
        for (i, weight) in weight.iter_mut().enumerate() {
            if turning >> i & 1 != 0 {
                *weight *= self.values[LEVER][0];
            }
        }
        PathSetting::new(weight, Real::min(self.values[TOLERANCE][0], most)).ok()
    }

    /// Share of each motor's limits that is kept for trims.
    pub fn trim_share(&self) -> f32 {
        self.values[TRIM_SHARE][0]
    }

    /// Largest trim of each motor [steps].
    pub fn trim_bound(&self) -> [i32; N] {
        let bound = |i| Real::round(self.values[TRIM_BOUND][i] * self.values[STEPS][i]) as i32;
        core::array::from_fn(|i| bound(i).min(MOST_TRIM))
    }

    /// What the motors' commands are shaped by.
    pub fn shapers(&self) -> Result<Design<N>, Refusal> {
        let mut wishes = [Wish::default(); N];
        for (joint, wish) in wishes.iter_mut().enumerate() {
            let mode = |hz: usize, damping: usize| Mode {
                hz: self.values[hz][joint],
                damping: self.values[damping][joint],
            };
            let second = mode(SECOND_HZ, SECOND_DAMPING);
            *wish = Wish {
                kind: Kind::of(self.values[SHAPER][joint]).ok_or(Refusal {
                    joint,
                    reason: Reason::Kind,
                })?,
                first: mode(SHAPER_HZ, SHAPER_DAMPING),
                second: (second.hz > 0.0).then_some(second),
            };
        }
        Design::new(&wishes, &self.step_rates())
    }

    /// Why a value beyond the range of its own is refused, if the number is one of a shaper.
    pub fn shaper_of(number: u16) -> Option<Refusal> {
        let (row, joint) = find::<N>(number)?;
        let reason = match row {
            SHAPER => Reason::Kind,
            SHAPER_HZ | SECOND_HZ => Reason::Frequency,
            SHAPER_DAMPING | SECOND_DAMPING => Reason::Damping,
            _ => return None,
        };
        Some(Refusal { joint, reason })
    }

    /// Steps per mm or degree.
    pub fn steps_per_unit(&self) -> [f32; N] {
        self.values[STEPS]
    }

    /// Steps per mm or radian: the joints' own units.
    pub fn steps_per_joint_unit(&self) -> [f32; N] {
        let mut steps = self.values[STEPS];
        let turning = self.turning();
        for (i, steps) in steps.iter_mut().enumerate() {
            if turning >> i & 1 != 0 {
                *steps *= 180.0 / core::f32::consts::PI;
            }
        }
        steps
    }

    /// Lower and upper end of each axis [steps].
    pub fn travel(&self) -> ([i32; N], [i32; N]) {
        let steps = self.values[STEPS];
        // Casts saturate, which is what an end beyond the counter means.
        let at = |row: usize| {
            core::array::from_fn(|i| Real::round(self.values[row][i] * steps[i]) as i32)
        };
        (at(LOWER), at(UPPER))
    }
}

/// Whether a value is a whole number of at most `bits` bits.
fn is_mask(value: f32, bits: usize) -> bool {
    let mask = value as u32;
    mask as f32 == value && mask >> bits == 0
}

/// Row and axis of a `$` number.
fn find<const N: usize>(number: u16) -> Option<(usize, usize)> {
    TABLE.iter().enumerate().find_map(|(i, row)| {
        let axis = usize::from(number.checked_sub(row.number)?);
        let count = if row.per_axis { N } else { 1 };
        (axis < count).then_some((i, axis))
    })
}
