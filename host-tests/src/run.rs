//! A checked job -> its pulses.
//!
//! Everything that can be refused is refused before the first tick: the whole path is walked once through kinematics
//! and travel limits.

use crate::job::{CountsJob, DrillJob, Job, JobError, MOTORS, Task};
use crate::pipeline::{PathError, Pipeline, Stepwise};
use crate::rig::{self, Feed, Outcome};
use hexstep::cycles::drill_point::Cycle;
use hexstep::joints::Joints;
use hexstep::machines::DrillGrinder;
use hexstep::math::Real;
use hexstep::planner::{LimitError, Limits, Planner};
use hexstep::stepper::CountLine;
use std::convert::Infallible;

/// The type in which geometry and kinematics are computed; motion is f32 and integers in either case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scalar {
    /// As on the target: the same pulses, tick for tick.
    #[default]
    F32,
    F64,
}

/// Receives how much of a job has been taken into the pipe: done, of all.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

/// Runs a job to its end.
///
/// # Errors
/// A [`JobError`] with the key at fault: the path leaves the travel of a joint, or cannot be followed.
pub fn run(job: &Job, scalar: Scalar, progress: Progress<'_>) -> Result<Outcome<6>, JobError> {
    match (&job.task, scalar) {
        (Task::DrillPoint(drill), Scalar::F32) => run_drill::<f32>(job, drill, progress),
        (Task::DrillPoint(drill), Scalar::F64) => run_drill::<f64>(job, drill, progress),
        (Task::Counts(counts), _) => Ok(run_counts(job, counts, progress)),
    }
}

/// The drill grinder's motors as a path sees them: kinematics, and steps per mm or rad.
pub fn stepwise<R: Real>(drill: &DrillJob) -> Stepwise<DrillGrinder<R>, R, 6> {
    let scale = std::array::from_fn(|motor| {
        let steps = R::of(drill.axes[motor].steps_per_unit);
        // The last three joints turn: degrees in the file, radians inside.
        if motor < 3 {
            steps
        } else {
            steps / R::ONE.to_radians()
        }
    });
    Stepwise::new(drill.arm(), Joints(scale))
}

fn run_drill<R: Real>(
    job: &Job,
    drill: &DrillJob,
    progress: Progress<'_>,
) -> Result<Outcome<6>, JobError> {
    let cycle = Cycle::new(&drill.parameters::<R>());
    let cycle = cycle.expect("made in both scalars when the job was read");
    let targets = check_travel(job, drill, cycle.clone())?;
    let limits = planner_limits(job, drill)?;

    let all = targets.len() as u64;
    let mut pipeline = Pipeline::new(cycle, stepwise::<R>(drill), Planner::new(limits, [0; 6]));
    let outcome = rig::simulate(job.timing, |segmenter, sender| {
        let feed = pipeline.poll(segmenter, sender);
        progress(pipeline.taken() as u64, all);
        feed
    });
    outcome.map_err(|error| path_error(job, error))
}

/// The whole steps of every waypoint, all of them within the travel of their joints.
///
/// # Errors
/// `OutOfTravel` at `machine.travel`, or what the kinematics has to say.
fn check_travel<R: Real>(
    job: &Job,
    drill: &DrillJob,
    cycle: Cycle<R>,
) -> Result<Vec<[i32; 6]>, JobError> {
    let mut stepwise = stepwise::<R>(drill);
    let mut targets = Vec::new();
    for waypoint in cycle {
        let (_, steps) = stepwise
            .next(&waypoint)
            .map_err(|error| path_error(job, error))?;
        targets.push(steps);
    }
    for motor in 0..6 {
        let axis = &drill.axes[motor];
        let unit = if motor < 3 { "mm" } else { "deg" };
        // The path begins at zero.
        let positions = || targets.iter().map(|steps| steps[motor]).chain([0]);
        let lowest = f64::from(positions().min().unwrap_or(0)) / axis.steps_per_unit;
        let highest = f64::from(positions().max().unwrap_or(0)) / axis.steps_per_unit;
        let (lo, hi) = axis.travel;
        if lowest < lo || highest > hi {
            let detail = format!(
                "{} goes from {lowest:.3} to {highest:.3} {unit}, beyond its travel of {lo} to {hi} {unit}; widen travel if the machine allows it, or change [structure] or [cycle]",
                MOTORS[motor]
            );
            return Err(job.refuse(&format!("machine.travel[{motor}]"), "OutOfTravel", detail));
        }
    }
    Ok(targets)
}

fn path_error(job: &Job, error: PathError) -> JobError {
    match error {
        PathError::Pose { waypoint, .. } => job.refuse(
            "structure",
            "OutOfReach",
            format!("no joints reach waypoint {waypoint} of the cycle; check l1 and l2"),
        ),
        PathError::Overflow { waypoint } => job.refuse(
            "machine.steps_per_unit",
            "OutOfRange",
            format!(
                "waypoint {waypoint} of the cycle needs more than 2^31 steps; reduce steps_per_unit"
            ),
        ),
    }
}

fn planner_limits(job: &Job, drill: &DrillJob) -> Result<Limits<6>, JobError> {
    let velocity = drill
        .axes
        .map(|axis| (axis.steps_per_unit * axis.max_rate) as f32);
    let acceleration = drill
        .axes
        .map(|axis| (axis.steps_per_unit * axis.acceleration) as f32);
    Limits::new(velocity, acceleration, job.timing.fastest() as f32).map_err(|error| {
        let (key, motor) = match error {
            LimitError::Velocity { motor } => ("max_rate", motor),
            LimitError::Acceleration { motor } => ("acceleration", motor),
        };
        job.refuse(
            &format!("machine.{key}[{motor}]"),
            "OutOfRange",
            "no motion keeps this limit; give a larger or smaller number".into(),
        )
    })
}

fn run_counts(job: &Job, counts: &CountsJob, progress: Progress<'_>) -> Outcome<6> {
    let all = counts.lines.len() as u64;
    let mut lines = counts.lines.iter();
    let mut running: Option<CountLine<6>> = None;
    let mut done = 0;
    let outcome = rig::simulate::<6, Infallible>(job.timing, |segmenter, sender| {
        loop {
            if let Some(line) = &mut running {
                if !line.feed(segmenter, sender) {
                    return Ok(Feed::More);
                }
                done += 1;
                progress(done, all);
            }
            let Some(next) = lines.next() else {
                return Ok(Feed::Done);
            };
            let line = CountLine::new(
                next.counts,
                next.duration,
                next.preset,
                &job.timing,
                &segmenter.counts(),
            );
            running = Some(line.expect("checked when the job was read"));
        }
    });
    match outcome {
        Ok(outcome) => outcome,
        Err(never) => match never {},
    }
}
