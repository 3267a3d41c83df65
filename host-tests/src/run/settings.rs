//! What a job says of its machine -> the machine's settings, each under its number.

use crate::job::{AxisLimits, Contour, Job, JobError, PosesJob, Shaping, Task};
use crate::machine::TICK_HZ;
use crate::poses::Plan;
use crate::trace::seconds;
use hexstep::settings::Settings;
use hexstep::shaper::design::{MOST_DAMPING, MOST_DAMPING_EI, MOST_HZ};
use hexstep::shaper::{HISTORY, LONGEST, Reason};
use hexstep::stepper::StepMode;

/// A number of the machine's table, a value, and the key of the job that it comes from.
pub(crate) type Value = (u16, f32, String);

/// The settings of the machine that a job describes; `plan` are its poses and what they became.
///
/// # Errors
/// `OutOfRange` at the key whose value the machine does not take.
pub fn settings(job: &Job, plan: Option<(&PosesJob, &Plan)>) -> Result<Settings, JobError> {
    let mut values = driver_values(job);
    match &job.task {
        Task::DrillPoint(drill) => values.extend(axis_values(&drill.axes)),
        Task::Path(path) => {
            values.extend(axis_values(&path.axes));
            values.extend(contour_values(&path.contour, "path"));
            values.extend(shaping_values(&path.shaping));
        }
        Task::Poses(_) | Task::Surface(_) | Task::Precession(_) => {
            if let Some((poses, plan)) = plan {
                let (axes, contour) = super::poses::limits(poses, plan);
                values.extend(axis_values(&axes));
                values.extend(contour_values(&contour, "path"));
            }
        }
        // Its pair has eight motors and settings of its own.
        Task::Mirror(_) => {}
        // A line of counts knows no unit and no limit but those of its own.
        Task::Counts(_) => {
            let free = AxisLimits {
                steps_per_unit: 1.0,
                max_rate: 1000.0,
                acceleration: 1000.0,
                jerk: 40_000.0,
                travel: (-1e9, 1e9),
            };
            values.extend(axis_values(&[free; 6]));
        }
    }
    apply(job, values)
}

/// The settings of a machine with these values.
///
/// # Errors
/// `OutOfRange` at the key whose value the machine does not take.
pub(crate) fn apply<const N: usize>(
    job: &Job,
    values: Vec<Value>,
) -> Result<Settings<N>, JobError> {
    let mut settings = Settings::default();
    // As a set: in no order could all values that bound each other meet only those they are to be with.
    for (number, value, key) in &values {
        settings.put(*number, *value).map_err(|error| {
            if let Some(refusal) = Settings::<N>::shaper_of(*number) {
                return job.refuse(key, refusal.reason.name(), told_refusal(refusal.reason));
            }
            let detail = format!(
                "the machine does not take this value (${number}, error {}); see `$$` for its ranges",
                error.number()
            );
            job.refuse(key, "OutOfRange", detail)
        })?;
    }
    settings.check(TICK_HZ).map_err(|conflict| {
        let first = conflict.numbers().next();
        let blamed = values.iter().find(|(number, ..)| Some(*number) == first);
        let key = blamed.map_or("stepper", |(.., key)| key);
        if let Some(refusal) = conflict.shaper() {
            let detail = format!("{}; {conflict}", told_refusal(refusal.reason));
            return job.refuse(key, refusal.reason.name(), detail);
        }
        let detail = format!(
            "the machine does not take these values together, {conflict} (error {})",
            conflict.error().number()
        );
        job.refuse(key, "OutOfRange", detail)
    })?;
    Ok(settings)
}

/// Why there is no such shaper, and what to do.
fn told_refusal(reason: Reason) -> String {
    match reason {
        Reason::Kind => "there is no such shaper; take off, zv, zvd or ei".into(),
        Reason::Frequency => {
            format!(
                "expected a frequency from 0.1 to {MOST_HZ} Hz, below half of 1000 samples a second"
            )
        }
        Reason::Damping => {
            format!("expected a damping from 0 to {MOST_DAMPING}, for ei to {MOST_DAMPING_EI}")
        }
        Reason::TooLong { samples } => format!(
            "a shaper of {samples} ms is longer than {LONGEST} ms, or all together are longer than {} ms; raise the frequency or shape fewer joints",
            (HISTORY - 1) * 6
        ),
    }
}

/// `[stepper]`
pub(crate) fn driver_values(job: &Job) -> Vec<Value> {
    let us = |counts: u32| (seconds(counts.into()) * 1e6) as f32;
    let timing = &job.timing;
    let both = f32::from(u8::from(timing.mode == StepMode::BothEdge));
    vec![
        (0, us(timing.least_period), "stepper.pulse_us".into()),
        (29, us(timing.setup), "stepper.setup_us".into()),
        (1011, us(timing.hold), "stepper.hold_us".into()),
        (1010, both, "stepper.mode".into()),
    ]
}

/// `[machine]`: the limits of all motors.
pub(crate) fn axis_values(axes: &[AxisLimits]) -> Vec<Value> {
    let mut values = Vec::new();
    for (motor, axis) in (0u16..).zip(axes) {
        let key = |name: &str| format!("machine.{name}[{motor}]");
        values.extend([
            (
                100 + motor,
                axis.steps_per_unit as f32,
                key("steps_per_unit"),
            ),
            (800 + motor, axis.jerk as f32, key("jerk")),
            (120 + motor, axis.acceleration as f32, key("acceleration")),
            (110 + motor, (axis.max_rate * 60.0) as f32, key("max_rate")),
            (1040 + motor, axis.travel.0 as f32, key("travel")),
            (1050 + motor, axis.travel.1 as f32, key("travel")),
        ]);
    }
    values
}

/// `[machine]` and the path's table: what the contour may do.
fn contour_values(contour: &Contour, path: &str) -> Vec<Value> {
    let mut values = vec![
        (1003, contour.tolerance as f32, format!("{path}.tolerance")),
        (1004, contour.lever as f32, "machine.lever".into()),
        (
            1005,
            contour.rapid_tolerance as f32,
            format!("{path}.rapid_tolerance"),
        ),
        (1013, contour.trim_share as f32, "machine.trim_share".into()),
    ];
    values.extend((0u16..).zip(contour.trim).map(|(motor, trim)| {
        let key = format!("machine.trim[{motor}]");
        (1030 + motor, trim as f32, key)
    }));
    values
}

/// `[machine]`: what the commands are shaped by. A shaper is switched on when it has all of its numbers.
fn shaping_values(shaping: &Shaping) -> Vec<Value> {
    let mut values = Vec::new();
    for (number, name, of) in [
        (1210, "shaper_hz", shaping.first.map(|mode| mode.0)),
        (1220, "shaper_damping", shaping.first.map(|mode| mode.1)),
        (1230, "shaper_hz_2", shaping.second.map(|mode| mode.0)),
        (1240, "shaper_damping_2", shaping.second.map(|mode| mode.1)),
        (1200, "shaper", shaping.kinds.map(|kind| kind as f64)),
    ] {
        values.extend((0u16..).zip(of).map(|(motor, value)| {
            let key = format!("machine.{name}[{motor}]");
            (number + motor, value as f32, key)
        }));
    }
    values
}
