//! What the motors and the path of a job may do: `[machine]`, and the tolerance of its contour.
//!
//! Every kind of job that moves joints reads its limits here, so that they mean the same everywhere. Units are those of
//! the joints: mm for the three that slide, degrees for the three that turn.

use super::reader::{Kind, Table};
use super::{JobError, Places};
use fixed::types::I32F32;
use hexstep::planner::{LONGEST_RISE, MOST_ACCELERATION, MOST_JERK, WEIGHT_RATIO};
use hexstep::stepper::Timing;

/// The motors of the drill grinder, in the order of every array in a job file.
pub const MOTORS: [&str; 6] = ["d1", "d2", "d3", "theta1", "theta2", "theta3"];

/// Motors from this one on turn.
pub const FIRST_TURNING: usize = 3;

/// Unit of a motor's joint.
pub fn unit(motor: usize) -> &'static str {
    if motor < FIRST_TURNING { "mm" } else { "deg" }
}

/// Parts of a step that a line tells: four digits behind the point.
pub const STEP_PARTS: u32 = 10_000;

/// What one motor can do, in the unit of its joint (mm or degrees).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// [steps/unit]
    pub steps_per_unit: f64,
    /// [unit/s]
    pub max_rate: f64,
    /// [unit/s2]
    pub acceleration: f64,
    /// [unit/s3]
    pub jerk: f64,
    /// [unit]
    pub travel: (f64, f64),
}

impl AxisLimits {
    /// Steps at `x` [unit], to the ten-thousandth of one that a line tells; `None` beyond the range of a step counter.
    pub fn steps_at(&self, x: f64) -> Option<I32F32> {
        let steps = x * self.steps_per_unit;
        if steps.is_nan() || steps.abs() >= f64::from(i32::MAX) {
            return None;
        }
        // As the machine reads the decimal number: the nearest 2^-32.
        let told = (steps * f64::from(STEP_PARTS)).round() as i128;
        let parts = i128::from(STEP_PARTS);
        let bits = ((told.abs() << 32) + parts / 2) / parts;
        Some(I32F32::from_bits((bits * told.signum()) as i64))
    }

    /// Ends of the travel as the machine knows them [steps].
    pub fn travel_steps(&self) -> (i32, i32) {
        // In f32, as its settings are; a cast saturates, which is what an end beyond the counter means.
        let at = |x: f64| (x as f32 * self.steps_per_unit as f32).round() as i32;
        (at(self.travel.0), at(self.travel.1))
    }
}

/// How far the contour of a path may leave it, and what that means for joints that turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contour {
    /// [mm]; 0 stops at every corner.
    pub tolerance: f64,
    /// [mm]; the same for corners of two rapids, if it is more.
    pub rapid_tolerance: f64,
    /// Distance of the tool from the axes of the turning joints [mm].
    pub lever: f64,
    /// Share of every limit that is kept for trims, 0 ..= 0.5.
    pub trim_share: f64,
    /// Largest trim of each motor [mm, deg].
    pub trim: [f64; 6],
}

impl Contour {
    /// What one unit of each joint weighs [mm]: 1 for one that slides, the lever's arc for one that turns.
    pub fn weights(&self) -> [f64; 6] {
        std::array::from_fn(|motor| {
            if motor < FIRST_TURNING {
                1.0
            } else {
                self.lever.to_radians()
            }
        })
    }

    /// Weighted length of one step of all joints that move, together [mm]: how far whole steps can be off.
    pub fn step(&self, axes: &[AxisLimits; 6], moves: [bool; 6]) -> f64 {
        let weights = self.weights();
        let of_step = |motor: usize| weights[motor] / axes[motor].steps_per_unit;
        let squares = (0..6)
            .filter(|motor| moves[*motor])
            .map(|motor| of_step(motor).powi(2));
        squares.sum::<f64>().sqrt()
    }
}

/// Keys of `[machine]` that [`read_axes`] reads.
pub(super) const AXES: &[&str] = &[
    "steps_per_unit",
    "max_rate",
    "acceleration",
    "jerk",
    "travel",
];
/// Keys of `[machine]` that [`read_contour`] reads.
pub(super) const CONTOUR: &[&str] = &["lever", "trim_share", "trim"];

/// Defaults of the machine's own table of settings.
const JERK: f64 = 40_000.0;
const LEVER: f64 = 150.0;
const TOLERANCE: f64 = 0.01;
const RAPID_TOLERANCE: f64 = 0.5;
const TRIM: f64 = 0.1;

/// `[machine]`: one number for each motor and key. `jerk` may be left out.
///
/// # Errors
/// `OutOfRange` for a number that no machine has; `Contradictory` for limits that would take longer than
/// [`LONGEST_RISE`] to build up.
pub(super) fn read_axes(
    machine: &Table<'_>,
    timing: &Timing,
    places: &Places,
) -> Result<[AxisLimits; 6], JobError> {
    read_joints(machine, std::array::from_fn(unit), timing, places)
}

/// The same for a path whose table names `joints`: one number for each of the six motors, or one for each of these. The
/// others stand still then, within a travel of a unit.
pub(super) fn read_axes_of(
    joints: &[usize],
    machine: &Table<'_>,
    timing: &Timing,
    places: &Places,
) -> Result<[AxisLimits; 6], JobError> {
    if machine.length("steps_per_unit") == Some(MOTORS.len()) {
        return read_axes(machine, timing, places);
    }
    macro_rules! some {
        ($count:literal) => {{
            let units: [&str; $count] = std::array::from_fn(|i| unit(joints[i]));
            read_joints(machine, units, timing, places)?.to_vec()
        }};
    }
    let own = match joints.len() {
        1 => some!(1),
        2 => some!(2),
        3 => some!(3),
        4 => some!(4),
        5 => some!(5),
        _ => return read_axes(machine, timing, places),
    };
    Ok(std::array::from_fn(|motor| {
        match joints.iter().position(|joint| *joint == motor) {
            Some(place) => own[place],
            None => AxisLimits {
                travel: (-1.0, 1.0),
                ..own[0]
            },
        }
    }))
}

/// The same for a machine of `N` joints with other units, mm or deg.
pub(super) fn read_joints<const N: usize>(
    machine: &Table<'_>,
    units: [&'static str; N],
    timing: &Timing,
    places: &Places,
) -> Result<[AxisLimits; N], JobError> {
    let steps =
        machine.numbers::<N>("steps_per_unit", Kind::positive(1e6, "steps per mm or deg"))?;
    let rates = machine.numbers::<N>("max_rate", Kind::positive(1e6, "mm/s or deg/s"))?;
    let accelerations =
        machine.numbers::<N>("acceleration", Kind::positive(1e8, "mm/s2 or deg/s2"))?;
    let jerks = if machine.has("jerk") {
        machine.numbers::<N>("jerk", Kind::positive(1e12, "mm/s3 or deg/s3"))?
    } else {
        [JERK; N]
    };
    let travels = machine.ranges::<N>("travel")?;
    for motor in 0..N {
        let refuse = |key: &str, name: &'static str, detail: String| {
            Err(places.refuse(&format!("machine.{key}[{motor}]"), name, detail))
        };
        let unit = units[motor];
        let (v, a, j) = (rates[motor], accelerations[motor], jerks[motor]);
        let rate = steps[motor] * v;
        let fastest = f64::from(timing.fastest());
        if rate > fastest {
            let detail = format!(
                "{v} {unit}/s times {} steps are {rate:.0} steps/s, more than the {fastest:.0} steps/s that the pulse time allows; lower max_rate or pulse_us",
                steps[motor],
            );
            return refuse("max_rate", "OutOfRange", detail);
        }
        let most = f64::from(MOST_ACCELERATION);
        if a * steps[motor] > most {
            let detail = format!(
                "{a} {unit}/s2 times {} steps are more than the {most:e} steps/s2 that the planner counts to; lower it",
                steps[motor]
            );
            return refuse("acceleration", "OutOfRange", detail);
        }
        let most = f64::from(MOST_JERK);
        if j * steps[motor] > most {
            let detail = format!(
                "{j} {unit}/s3 times {} steps are more than the {most:e} steps/s3 that the planner counts to; lower it",
                steps[motor]
            );
            return refuse("jerk", "OutOfRange", detail);
        }
        let longest = f64::from(LONGEST_RISE);
        if v > longest * a {
            let detail = format!(
                "{v} {unit}/s would take more than {longest} s to reach with {a} {unit}/s2; lower max_rate or raise acceleration"
            );
            return refuse("max_rate", "Contradictory", detail);
        }
        if a > longest * j {
            let detail = format!(
                "{a} {unit}/s2 would take more than {longest} s to reach with {j} {unit}/s3; lower acceleration or raise jerk"
            );
            return refuse("acceleration", "Contradictory", detail);
        }
    }
    Ok(std::array::from_fn(|motor| AxisLimits {
        steps_per_unit: steps[motor],
        max_rate: rates[motor],
        acceleration: accelerations[motor],
        jerk: jerks[motor],
        travel: travels[motor],
    }))
}

/// `lever`, `trim_share` and `trim` of `[machine]`, `tolerance` and `rapid_tolerance` of the path's table; all may be left out.
///
/// # Errors
/// `OutOfRange`; `Contradictory` where a step of one joint carries the tool a million times as far as one of another.
pub(super) fn read_contour(
    machine: &Table<'_>,
    path: &Table<'_>,
    axes: &[AxisLimits; 6],
    places: &Places,
) -> Result<Contour, JobError> {
    let contour = Contour {
        tolerance: path.number_or("tolerance", TOLERANCE, Kind::between(0.0, 10.0, "mm"))?,
        rapid_tolerance: path.number_or(
            "rapid_tolerance",
            RAPID_TOLERANCE,
            Kind::between(0.0, 10.0, "mm"),
        )?,
        lever: machine.number_or("lever", LEVER, Kind::between(0.001, 10_000.0, "mm"))?,
        trim_share: machine.number_or("trim_share", 0.0, Kind::between(0.0, 0.5, ""))?,
        trim: if machine.has("trim") {
            machine.numbers::<6>("trim", Kind::between(0.0, 10.0, "mm or deg"))?
        } else {
            [TRIM; 6]
        },
    };
    let weights = contour.weights();
    let of_step = |motor: usize| weights[motor] / axes[motor].steps_per_unit;
    let largest = (0..6).map(of_step).fold(0.0, f64::max);
    for motor in 0..6 {
        // A little less, since the machine compares in f32.
        if of_step(motor) * f64::from(WEIGHT_RATIO) * 0.999 < largest {
            let detail = format!(
                "a step carries the tool {:e} mm here and {largest:e} mm at another joint; at most {WEIGHT_RATIO:e} times as far is possible",
                of_step(motor)
            );
            let key = format!("machine.steps_per_unit[{motor}]");
            return Err(places.refuse(&key, "Contradictory", detail));
        }
    }
    Ok(contour)
}
