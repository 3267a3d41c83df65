//! A checked job -> its pulses, by the very controller that runs on the target.
//!
//! Everything that can be refused is refused before the first tick: the whole path is walked once through kinematics
//! and travel limits.

mod drill;
pub mod pair;
mod path;
pub mod poses;
pub(crate) mod settings;

pub use pair::{Reading, RunPair, RunRow};
pub use poses::targets;
pub use settings::settings;

use crate::job::{CountsJob, DrillJob, Job, JobError, MirrorJob, Task};
use crate::machine::{self, Machine};
use crate::mirror::Simulation;
use crate::pair::{Milling, PairPlan};
use crate::poses::Plan;
use crate::process::{Made, MirrorMade};
use crate::trace::{Trace, seconds};
use hexstep::cycles::drill_point::Cycle;
use hexstep::stepper::Preset;

/// What a run has shown.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub trace: Trace<6>,
    /// The same path without shapers, where the job has some: what they gain, and what they cost the contour.
    pub unshaped: Option<Trace<6>>,
    /// Steps of each motor as the foreground's books have them.
    pub counts: [i32; 6],
    /// Times that the queue ran dry in motion; must be 0.
    pub starved: u32,
    /// What poses became, and when their path began.
    pub poses: Option<RunPoses>,
    /// What a process became.
    pub made: Option<Made>,
    /// What both sides of a two-sided machine did; `trace` and `counts` are empty then.
    pub pair: Option<RunPair>,
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
    let made = Made::of(job)?;
    let poses_of = match &job.task {
        Task::Poses(poses) => Some(poses.as_ref()),
        _ => made.as_ref().and_then(Made::poses),
    };
    let plan = match poses_of {
        Some(poses) => {
            let plan = Plan::of(job, poses)?;
            let targets = poses::targets(job, poses, &plan)?;
            Some((poses, plan, targets))
        }
        None => None,
    };
    if let (Task::Mirror(mirror), Some(Made::Mirror(walls))) = (&job.task, &made) {
        let pair = run_pair(job, mirror, walls, progress)?;
        return Ok(Outcome {
            trace: Trace::new(job.timing.mode),
            unshaped: None,
            counts: [0; 6],
            starved: pair.as_ref().map_or(0, |pair| pair.starved),
            poses: None,
            made,
            pair,
        });
    }
    let planned = plan.as_ref().map(|(poses, plan, _)| (*poses, plan));
    let settings = settings::settings(job, planned)?;
    let path = match &job.task {
        Task::DrillPoint(drill) => Some((drill.as_ref(), drill::check(job, drill, &settings)?)),
        _ => None,
    };
    let (trace, counts, starved, start) = machine::with(|machine| {
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
        Ok((
            machine.take_trace(),
            machine.controller.counts(),
            machine.starved(),
            start,
        ))
    })?;
    let poses = plan.map(|(_, plan, _)| RunPoses { plan, start });
    Ok(Outcome {
        unshaped: unshaped(job)?,
        trace,
        counts,
        starved,
        poses,
        made,
        pair: None,
    })
}

/// The pulses of a path job with every shaper off; `None` where none is on.
fn unshaped(job: &Job) -> Result<Option<Trace<6>>, JobError> {
    let Task::Path(path) = &job.task else {
        return Ok(None);
    };
    if !path.shaping.is_on() {
        return Ok(None);
    }
    let mut bare = path.clone();
    bare.shaping = path.shaping.off();
    let mut job = job.clone();
    job.task = Task::Path(bare);
    run(&job, &mut |_, _| {}).map(|outcome| Some(outcome.trace))
}

/// How a simulated panel is milled by pulses: what its bias was found to be is corrected.
pub fn milling(simulation: &Simulation, walls: &MirrorMade) -> Milling {
    let correction = walls.bias.as_ref().map_or(0.0, |bias| bias.correction);
    Milling {
        wall: simulation.d + correction,
        feed: simulation.feed,
        amount: simulation.amount,
    }
}

/// Mills a panel, with the correction of the wall where one was learnt.
fn run_pair(
    job: &Job,
    mirror: &MirrorJob,
    walls: &MirrorMade,
    progress: Progress<'_>,
) -> Result<Option<RunPair>, JobError> {
    let (Some(pair), Some(simulation)) = (&mirror.pair, mirror.simulations.first()) else {
        // Nothing moves: the simulated walls are all there is.
        progress(1, 1);
        return Ok(None);
    };
    let plan = PairPlan::of(job, pair, &milling(simulation, walls))?;
    pair::run(job, pair, simulation, plan, progress).map(Some)
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
        (_, None) => {}
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
