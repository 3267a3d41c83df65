//! A checked job -> its pulses, by the very controller that runs on the target.
//!
//! Everything that can be refused is refused before the first tick: the whole path is walked once through kinematics
//! and travel limits.

mod drill;
mod path;
pub mod poses;
mod settings;

pub use poses::targets;
pub use settings::settings;

use crate::job::{CountsJob, DrillJob, Job, JobError, Task};
use crate::machine::{self, Machine};
use crate::poses::Plan;
use crate::trace::{Trace, seconds};
use hexstep::cycles::drill_point::Cycle;
use hexstep::stepper::Preset;

/// What a run has shown.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub trace: Trace<6>,
    /// Steps of each motor as the foreground's books have them.
    pub counts: [i32; 6],
    /// Times that the queue ran dry in motion; must be 0.
    pub starved: u32,
    /// What poses became, and when their path began.
    pub poses: Option<RunPoses>,
}

/// The run of a job with poses.
#[derive(Clone, Debug)]
pub struct RunPoses {
    pub plan: Plan,
    /// When the first pose had been reached and the path began [counts].
    pub start: u64,
}

/// Receives how far a job has come: done, of all.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

/// Runs a job to its end on the machine in memory.
///
/// # Errors
/// A [`JobError`] with the key at fault: the path leaves the travel of a joint, or cannot be followed.
pub fn run(job: &Job, progress: Progress<'_>) -> Result<Outcome, JobError> {
    let plan = match &job.task {
        Task::Poses(poses) => {
            let plan = Plan::of(job, poses)?;
            let targets = poses::targets(job, poses, &plan)?;
            Some((poses, plan, targets))
        }
        _ => None,
    };
    let settings = settings::settings(job, plan.as_ref().map(|(_, plan, _)| plan))?;
    let path = match &job.task {
        Task::DrillPoint(drill) => Some((drill.as_ref(), drill::check(job, drill, &settings)?)),
        Task::Counts(_) | Task::Path(_) | Task::Poses(_) => None,
    };
    machine::with(|machine| {
        let configured = machine.controller.configure(settings);
        configured.map_err(|error| refused(job, &format!("error {}", error.number())))?;
        // The banner, which nobody has asked for, and the step mode, which the interrupt takes over between motions.
        machine.run_to_rest();
        machine.run(1);
        machine.heard();
        let mut start = 0;
        if let Some((poses, plan, targets)) = &plan {
            start = poses::run(job, poses, plan, targets, machine, progress)?;
        } else {
            run_task(job, path, machine, progress)?;
        }
        // The last levels go out a tick after they were computed, and a pulse ends one later.
        machine.run(3);
        Ok(Outcome {
            counts: machine.controller.counts(),
            starved: machine.starved(),
            trace: machine.take_trace(),
            poses: plan.map(|(_, plan, _)| RunPoses { plan, start }),
        })
    })
}

fn run_task(
    job: &Job,
    path: Option<(&DrillJob, Cycle<f32>)>,
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<(), JobError> {
    match (&job.task, path) {
        (Task::Path(path), _) => path::run(job, path, machine, progress)?,
        (Task::Counts(counts), _) => run_counts(job, counts, machine, progress)?,
        (_, Some((drill, cycle))) => drill::run(job, drill, cycle, machine, progress)?,
        (Task::DrillPoint(_) | Task::Poses(_), None) => {}
    }
    Ok(())
}

fn run_counts(
    job: &Job,
    counts: &CountsJob,
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<(), JobError> {
    let all = counts.lines.len() as u64;
    for (done, line) in (1..).zip(&counts.lines) {
        let preset = match line.preset {
            Preset::Published => "PUBLISHED",
            Preset::Centred => "CENTRED",
        };
        let words: Vec<String> = line.counts.iter().map(i32::to_string).collect();
        let duration = seconds(line.duration);
        let answer = machine.ask(&format!("$SEG={},{duration},{preset}", words.join(",")));
        answered(job, &answer)?;
        progress(done, all);
    }
    Ok(())
}

/// The machine has checked the job once more, and should have found nothing.
fn answered(job: &Job, answer: &str) -> Result<(), JobError> {
    if answer.trim() == "ok" {
        Ok(())
    } else {
        Err(refused(job, answer.trim()))
    }
}

fn refused(job: &Job, answer: &str) -> JobError {
    job.refuse("kind", "Refused", format!("the machine answers: {answer}"))
}
