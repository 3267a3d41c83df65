//! A drill job -> its pulses: the whole path is walked once before anything moves.

use super::{Progress, answered, refused};
use crate::job::{DrillJob, Job, JobError, MOTORS, unit};
use crate::machine::Machine;
use hexstep::cycles::drill_point::Cycle;
use hexstep::joints::{Joints, whole_steps};
use hexstep::machines::DrillGrinder;
use hexstep::path::{DrillPath, PathError, Scale};
use hexstep::settings::Settings;

/// Grinds.
///
/// # Errors
/// `Refused`, should the machine find what [`check`] has not.
pub fn run(
    job: &Job,
    drill: &DrillJob,
    cycle: Cycle<f32>,
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<(), JobError> {
    let started = machine.controller.start_drill(cycle, drill.arm());
    started.map_err(|error| refused(job, &format!("error {}", error.number())))?;
    machine.run_to_rest_watched(|controller| {
        if let Some((done, all)) = controller.progress() {
            progress(done.into(), all.into());
        }
    });
    answered(job, &machine.heard())
}

/// The cycle, once its whole path is known to lie within the travel of every joint.
///
/// # Errors
/// `OutOfTravel` at `machine.travel`, or what the kinematics has to say.
pub fn check(job: &Job, drill: &DrillJob, settings: &Settings) -> Result<Cycle<f32>, JobError> {
    let cycle = Cycle::new(&drill.parameters::<f32>());
    let cycle = cycle.expect("made when the job was read");
    let unlimited = Scale {
        steps_per_unit: Joints(settings.steps_per_joint_unit()),
        lower: [i32::MIN; 6],
        upper: [i32::MAX; 6],
    };
    let arm: DrillGrinder<f32> = drill.arm();
    // The path begins at zero.
    let (mut lowest, mut highest) = ([0i32; 6], [0i32; 6]);
    for target in DrillPath::new(cycle.clone(), arm, unlimited, Joints::default()) {
        let target = target.map_err(|error| path_error(job, error))?;
        let nearest = whole_steps(&target.steps);
        for motor in 0..6 {
            lowest[motor] = lowest[motor].min(nearest[motor]);
            highest[motor] = highest[motor].max(nearest[motor]);
        }
    }
    let (lower, upper) = settings.travel();
    for motor in 0..6 {
        if lowest[motor] < lower[motor] || highest[motor] > upper[motor] {
            let axis = &drill.axes[motor];
            let unit = unit(motor);
            let place = |steps: i32| f64::from(steps) / axis.steps_per_unit;
            let detail = format!(
                "{} goes from {:.3} to {:.3} {unit}, beyond its travel of {} to {} {unit}; widen travel if the machine allows it, or change [structure] or [cycle]",
                MOTORS[motor],
                place(lowest[motor]),
                place(highest[motor]),
                axis.travel.0,
                axis.travel.1
            );
            return Err(job.refuse(&format!("machine.travel[{motor}]"), "OutOfTravel", detail));
        }
    }
    Ok(cycle)
}

fn path_error(job: &Job, error: PathError) -> JobError {
    let (key, detail) = match error {
        PathError::OutOfReach => (
            "structure",
            "no joints within the range of a step counter reach a pose of the cycle; check l1, l2 and steps_per_unit",
        ),
        PathError::OutOfTravel { .. } => (
            "machine.travel",
            "the path leaves the range of a step counter",
        ),
    };
    job.refuse(key, "OutOfReach", detail.into())
}
