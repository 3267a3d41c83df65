//! A process of the papers -> what a machine and a report need of it: poses of the tool, and the figures of the process.
//!
//! ```text
//! SurfaceJob    -> rows, residuals of all strategies, joints for every row; poses of the rows that become pulses
//! PrecessionJob -> poses from the library's cycle, and the curves that centre and far point draw
//! MirrorJob     -> walls with and without trimming, and what a gauge teaches; its eight motors run elsewhere (`pair`)
//! ```

mod bias;
mod mirror;
mod precession;
mod surface;

pub use bias::{BiasMade, BiasedPanel};
pub use mirror::{Milled, MirrorMade, Row};
pub use precession::PrecessionMade;
pub use surface::{Compared, Reached, SurfaceMade};

use crate::job::{Job, JobError, PosesJob, Task};

/// What a process has become.
#[derive(Clone, Debug)]
pub enum Made {
    Surface(Box<SurfaceMade>),
    Precession(Box<PrecessionMade>),
    Mirror(Box<MirrorMade>),
}

impl Made {
    /// Works out the process of a job; `None` for a job that is none.
    ///
    /// # Errors
    /// The names of the process, at the key that is to blame.
    pub fn of(job: &Job) -> Result<Option<Self>, JobError> {
        Ok(Some(match &job.task {
            Task::Surface(surface) => Self::Surface(Box::new(SurfaceMade::of(job, surface)?)),
            Task::Precession(precession) => {
                Self::Precession(Box::new(PrecessionMade::of(job, precession)?))
            }
            Task::Mirror(mirror) => Self::Mirror(Box::new(MirrorMade::of(job, mirror)?)),
            Task::DrillPoint(_) | Task::Counts(_) | Task::Path(_) | Task::Poses(_) => {
                return Ok(None);
            }
        }))
    }

    /// The poses that become pulses.
    pub fn poses(&self) -> Option<&PosesJob> {
        match self {
            Self::Surface(made) => Some(&made.poses),
            Self::Precession(made) => Some(&made.poses),
            Self::Mirror(_) => None,
        }
    }
}
