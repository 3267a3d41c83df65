//! Processes that are fed with points over the serial line, and the machines they run on.
//!
//! | line | what it does |
//! |---|---|
//! | `$KIN` | shows the kinematics with its parameters (a `?` in a line is a real-time byte) |
//! | `$KIN=ARM6R`, `$KIN.TOOL=160` | chooses it; sets a parameter. At rest only |
//! | `$PRECESS`, `$PRECESS=T20,V5` | shows, sets the parameters; so do `$SURF` and `$MIRROR` |
//! | `$PRECESS=RUN`, `=SIM`, `=STOP` | points follow and are run, or looked at only; a controlled stop |
//! | `$POINT=x,y,z,i,j,k,...` | a point [mm] and its normal, and what else the process wants; answered once it can be run |
//! | `$POINT=ROW`, `$POINT=END` | the next point begins a row; there are no more |
//!
//! What an image of the firmware knows of it, its board says: [`NoProcesses`], [`ArmProcesses`] or [`PairProcesses`].

mod all;
mod arm;
mod correction;
mod fed;
mod given;
mod pair;
mod precess;
mod surf;

pub use all::AllProcesses;
pub use arm::ArmProcesses;
pub use fed::Fed;
pub use pair::{MIRROR, PairProcesses};
pub use precess::PRECESS;
pub use surf::SURF;

use crate::error::Error;
use crate::machines::two_sided::Pair;
use crate::path::{Scale, Target};
use crate::planner::PathSetting;
use core::fmt::Write;

/// What a line of a process comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// All is done.
    Done,
    /// Points follow: to be run, or to be looked at only.
    Run { sim: bool },
    /// The process is to stop.
    Stop,
    /// A point has been put in; [`Processes::next`] tells what becomes of it.
    Point,
}

/// Where the machine stands and what it can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing<const N: usize> {
    pub scale: Scale<N>,
    /// [steps]
    pub at: [i32; N],
    /// Largest speeds [mm/s, rad/s].
    pub speeds: [f32; N],
    /// How far the tip may leave its path [mm].
    pub tolerance: f32,
}

impl<const N: usize> Standing<N> {
    /// Of the first M motors alone; `None` if there are fewer.
    fn of_first<const M: usize>(&self) -> Option<Standing<M>> {
        Some(Standing {
            scale: self.scale.first()?,
            at: *self.at.first_chunk()?,
            speeds: *self.speeds.first_chunk()?,
            tolerance: self.tolerance,
        })
    }
}

/// What has become of the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress<const N: usize> {
    /// The next point is wanted.
    Waits,
    /// The point is still being looked at.
    Busy,
    /// It can be run: its line is to be answered.
    Taken,
    /// It cannot; why has been said.
    Refused(Error),
    Target(Target<N>),
    /// Behind the last point.
    Over,
}

impl<const M: usize> Progress<M> {
    /// The same of all N motors; those beyond the first M stay at zero.
    fn on_all<const N: usize>(self) -> Progress<N> {
        match self {
            Self::Target(target) => Progress::Target(Target {
                steps: core::array::from_fn(|i| target.steps.get(i).copied().unwrap_or_default()),
                duration: target.duration,
                free: target.free,
            }),
            Self::Waits => Progress::Waits,
            Self::Busy => Progress::Busy,
            Self::Taken => Progress::Taken,
            Self::Refused(error) => Progress::Refused(error),
            Self::Over => Progress::Over,
        }
    }
}

/// What a machine knows beyond grinding drills.
pub trait Processes<const N: usize>: Default {
    /// Whether all motors turn, as those of an arm do.
    fn all_turn(&self) -> bool {
        false
    }

    /// Obeys `$name` or `$name=value`. What a refusal has to say is written to `out`.
    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error>;

    /// Begins the process whose line asked for it: how far its path may be left, joint by joint.
    fn start(
        &mut self,
        standing: &Standing<N>,
        out: &mut dyn Write,
    ) -> Result<PathSetting<N>, Error>;

    /// One block more.
    fn next(&mut self, out: &mut dyn Write) -> Progress<N>;

    /// Whether a line waits for its answer.
    fn owes_answer(&self) -> bool;

    /// Forgets the path under way.
    fn stop(&mut self);

    /// The two-sided machine that readings trim.
    fn pair(&self, _: &Scale<N>, _: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        Err(Error::Unavailable)
    }
}

/// None at all.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProcesses;

impl<const N: usize> Processes<N> for NoProcesses {
    fn obey(
        &mut self,
        _: &str,
        _: Option<&str>,
        _: bool,
        _: &mut dyn Write,
    ) -> Result<Order, Error> {
        Err(Error::Unavailable)
    }

    fn start(&mut self, _: &Standing<N>, _: &mut dyn Write) -> Result<PathSetting<N>, Error> {
        Err(Error::Unavailable)
    }

    fn next(&mut self, _: &mut dyn Write) -> Progress<N> {
        Progress::Over
    }

    fn owes_answer(&self) -> bool {
        false
    }

    fn stop(&mut self) {}
}

/// Says a line that nobody has asked for.
fn say(out: &mut dyn Write, text: core::fmt::Arguments<'_>) {
    // What does not fit is cut off: the caller has made sure of room.
    let _ = write!(out, "[MSG:{text}]\r\n");
}
