//! The motion duel: the same paths through this machine and through other controllers, judged by their pulses.
//!
//! ```text
//! paths.rs   a seed, a formula                 -> Contest: points, feed, goal, bound
//!              as a job of kind "path"         -> the machine in memory -> pulses
//! figures.rs pulses                            -> time, largest speed, acceleration, jerk, distances, ripple
//! peers.rs   cases/duel/peers.csv              -> the same of the others
//! ```
//!
//! Limits for all: 200 mm/s, 1000 mm/s2, a tolerance of 0.01 mm; jerk 20 000 mm/s3 where it is known, and 10^7, with which
//! a machine is next to one that has no limit of it. Joints that turn have the same numbers in degrees.

mod figures;
mod paths;
mod peers;

pub use figures::Figures;
pub use paths::{Contest, Steady, contests};
pub use peers::{Peer, REVISIONS, peers};

use crate::job::{Job, JobError, Task};
use crate::report::{Bounds, ContourError};
use crate::run::{self, Progress};

/// [mm/s], [mm/s2] and [mm], or deg.
pub const VELOCITY: f64 = 200.0;
pub const ACCELERATION: f64 = 1000.0;
pub const TOLERANCE: f64 = 0.01;
/// Jerks that are run [mm/s3]: the first is that of goals and bounds, the second has next to no limit.
pub const JERKS: [f64; 2] = [20_000.0, 1e7];
/// Steps per mm that are run.
pub const STEPS: [f64; 2] = [80.0, 1000.0];

/// What a contest became.
#[derive(Clone, Debug)]
pub struct Run {
    pub figures: Figures,
    pub bounds: Bounds,
}

/// Runs a contest with these steps per unit and this jerk, and judges its pulses.
///
/// # Errors
/// Those of a job.
pub fn run(
    contest: &Contest,
    steps: f64,
    jerk: f64,
    progress: Progress<'_>,
) -> Result<Run, JobError> {
    let text = job(contest, steps, jerk);
    let job = Job::parse(
        &format!("{}.toml", contest.name),
        contest.name,
        text.as_bytes(),
    )?;
    let outcome = run::run(&job, progress)?;
    let Task::Path(path) = &job.task else {
        return Err(job.refuse("kind", "Refused", "a contest is a path".into()));
    };
    let mut points = vec![[0.0; 6]];
    points.extend(&contest.points);
    let contour = ContourError::of(
        &outcome.trace,
        &points,
        &[steps; 6],
        &path.contour.weights(),
        false,
    );
    Ok(Run {
        figures: Figures::of(&outcome.trace, steps, &contour, contest.steady),
        bounds: Bounds::of(path),
    })
}

/// The job file of a contest.
pub fn job(contest: &Contest, steps: f64, jerk: f64) -> String {
    let points: Vec<String> = contest.points.iter().map(|p| format!("{p:?}")).collect();
    format!(
        "kind = \"path\"\n[path]\ntolerance = {TOLERANCE}\nfeed = {:?}\npoints = [{}]\n[machine]\nsteps_per_unit = {:?}\n\
         max_rate = {:?}\nacceleration = {:?}\njerk = {:?}\ntravel = {:?}\n",
        contest.feed,
        points.join(",\n"),
        [steps; 6],
        [VELOCITY; 6],
        [ACCELERATION; 6],
        [jerk; 6],
        [[-300.0, 300.0]; 6],
    )
}
