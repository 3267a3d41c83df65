//! A job that has run -> its report, whatever its kind.

use super::{
    CountsFigures, DrillFigures, MirrorFigures, PathFigures, PosesFigures, PrecessionFigures,
    SurfaceFigures,
};
use crate::job::{Job, Task};
use crate::process::Made;
use crate::run::Outcome;

/// What a finished job says.
pub struct Finished {
    /// Lines of the one-screen summary.
    pub summary: Vec<String>,
    /// The whole report.
    pub html: String,
    /// Whether everything is as it should be.
    pub sound: bool,
}

impl Finished {
    /// Measures the outcome of a job; `wall` is the time that the simulation took [s].
    ///
    /// # Panics
    /// If the outcome is that of another kind of job.
    pub fn of(job: &Job, outcome: &Outcome, wall: f64) -> Self {
        macro_rules! finished {
            ($figures:expr) => {{
                let figures = $figures;
                Self {
                    summary: figures.summary(),
                    html: figures.html(),
                    sound: figures.is_sound(),
                }
            }};
        }
        match (&job.task, &outcome.made) {
            (Task::DrillPoint(drill), _) => {
                finished!(DrillFigures::of(job, drill, outcome, wall))
            }
            (Task::Counts(counts), _) => finished!(CountsFigures::of(job, counts, outcome, wall)),
            (Task::Path(path), _) => finished!(PathFigures::of(job, path, outcome, wall)),
            (Task::Poses(poses), _) => finished!(PosesFigures::of(job, poses, outcome, wall)),
            (Task::Surface(surface), Some(Made::Surface(made))) => {
                finished!(SurfaceFigures::of(job, surface, made, outcome, wall))
            }
            (Task::Precession(precession), Some(Made::Precession(made))) => {
                finished!(PrecessionFigures::of(job, precession, made, outcome, wall))
            }
            (Task::Mirror(mirror), Some(Made::Mirror(made))) => {
                finished!(MirrorFigures::of(job, mirror, made, outcome, wall))
            }
            _ => panic!("a process leaves what it became"),
        }
    }
}
