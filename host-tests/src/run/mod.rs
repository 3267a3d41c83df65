//! A checked job -> its pulses, by the very controller that runs on the target.
//!
//! Everything that can be refused is refused before the first tick: the whole path is walked once through kinematics
//! and travel limits.

mod drill;
mod path;
mod settings;

use crate::job::{CountsJob, Job, JobError, Task};
use crate::machine::{self, Machine};
use crate::trace::{Trace, seconds};
use hexstep::stepper::Preset;

/// What a run has shown.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub trace: Trace<6>,
    /// Steps of each motor as the foreground's books have them.
    pub counts: [i32; 6],
    /// Times that the queue ran dry in motion; must be 0.
    pub starved: u32,
}

/// Receives how far a job has come: done, of all.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

/// Runs a job to its end on the machine in memory.
///
/// # Errors
/// A [`JobError`] with the key at fault: the path leaves the travel of a joint, or cannot be followed.
pub fn run(job: &Job, progress: Progress<'_>) -> Result<Outcome, JobError> {
    let settings = settings::settings(job)?;
    let path = match &job.task {
        Task::DrillPoint(drill) => Some((drill, drill::check(job, drill, &settings)?)),
        Task::Counts(_) | Task::Path(_) => None,
    };
    machine::with(|machine| {
        let configured = machine.controller.configure(settings);
        configured.map_err(|error| refused(job, &format!("error {}", error.number())))?;
        // The banner, which nobody has asked for, and the step mode, which the interrupt takes over between motions.
        machine.run_to_rest();
        machine.run(1);
        machine.heard();
        match (&job.task, path) {
            (Task::Path(path), _) => path::run(job, path, machine, progress)?,
            (Task::Counts(counts), _) => run_counts(job, counts, machine, progress)?,
            (_, Some((drill, cycle))) => drill::run(job, drill, cycle, machine, progress)?,
            (Task::DrillPoint(_), None) => {}
        }
        // The last levels go out a tick after they were computed, and a pulse ends one later.
        machine.run(3);
        Ok(Outcome {
            counts: machine.controller.counts(),
            starved: machine.starved(),
            trace: machine.take_trace(),
        })
    })
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
