//! A machine fed with points: the same for every machine and process.

use super::given::{MOST, PointLine};
use super::{Order, Processes, Progress, Standing, say};
use crate::cycles::Process;
use crate::error::Error;
use crate::kinematics::follow::{End, Guide};
use crate::machines::two_sided::Pair;
use crate::path::points::{Fault, PointPath, Step, Tooled};
use crate::path::{PathError, Scale, Target};
use crate::planner::PathSetting;
use core::fmt::Write;

/// Name and remedy of what a machine or a process refuses.
pub trait Told {
    fn name(&self) -> &'static str;
    fn remedy(&self) -> &'static str;
    /// The joint to blame.
    fn joint(&self) -> Option<usize> {
        None
    }
}

/// The error of a machine's tool.
type ErrorOf<T, const M: usize> = <T as Guide<M, f32>>::Error;

/// A path that can begin.
pub struct Begun<P, T, const M: usize>
where
    P: Process<f32, End = End<T::Course, f32>>,
    T: Tooled<M>,
{
    pub path: PointPath<P, T, M>,
    /// How far a step of each motor carries the tip [mm].
    pub weight: [f32; M],
    /// How far the planner may leave the path [mm].
    pub contour: f32,
}

/// What is a machine's own.
pub trait Machine<const M: usize>: Default {
    type Work: Process<f32, End = End<<Self::Tool as Guide<M, f32>>::Course, f32>>;
    type Tool: Tooled<M>;

    fn all_turn(&self) -> bool {
        false
    }

    /// As [`Processes::obey`], but for points.
    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error>;

    /// The path that the last [`Order::Run`] is about.
    fn begin(
        &mut self,
        standing: &Standing<M>,
        sim: bool,
        out: &mut dyn Write,
    ) -> Result<Begun<Self::Work, Self::Tool, M>, Error>;

    /// A point of so many numbers; `begins`: it is the first of a row.
    fn point(
        numbers: &[f32; MOST],
        count: usize,
        begins: bool,
    ) -> Result<<Self::Work as Process<f32>>::Point, Error>;

    fn pair(&self, _: &Scale<M>, _: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        Err(Error::Unavailable)
    }
}

/// A machine of M motors, and the path that its points make.
pub struct Fed<W: Machine<M>, const M: usize> {
    pub(super) machine: W,
    sim: bool,
    /// The next point begins a row.
    begins: bool,
    /// A point that came while the blocks of the one before were still on their way.
    queued: Option<PointLine>,
    path: Option<Running<W::Work, W::Tool, M>>,
}

impl<W: Machine<M>, const M: usize> Default for Fed<W, M> {
    fn default() -> Self {
        Self {
            machine: W::default(),
            sim: false,
            begins: false,
            queued: None,
            path: None,
        }
    }
}

impl<W: Machine<M>, const M: usize> Fed<W, M>
where
    <W::Work as Process<f32>>::Error: Told,
    ErrorOf<W::Tool, M>: Told,
{
    fn point(&mut self, text: &str, out: &mut dyn Write) -> Result<Order, Error> {
        let line = PointLine::read(text)?;
        match &self.path {
            None => Err(Error::NotIdle),
            Some(_) if line == PointLine::Row => {
                self.begins = true;
                Ok(Order::Done)
            }
            Some(running) if running.path.is_drained() => self.put(line, out),
            Some(_) => {
                self.queued = Some(line);
                Ok(Order::Point)
            }
        }
    }

    fn put(&mut self, line: PointLine, out: &mut dyn Write) -> Result<Order, Error> {
        let path = self.path.as_mut().ok_or(Error::NotIdle)?;
        match line {
            PointLine::Numbers(numbers, count) => {
                let point = W::point(&numbers, count, self.begins)?;
                path.take(Some(&point), out)
            }
            PointLine::Row | PointLine::End => path.take(None, out),
        }
    }
}

impl<W: Machine<M>, const M: usize, const N: usize> Processes<N> for Fed<W, M>
where
    <W::Work as Process<f32>>::Error: Told,
    ErrorOf<W::Tool, M>: Told,
{
    fn all_turn(&self) -> bool {
        self.machine.all_turn()
    }

    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        match (name, value) {
            ("POINT", Some(text)) => return self.point(text, out),
            ("MIRROR", Some("OFF")) => return self.point("END", out),
            _ => {}
        }
        let order = self.machine.obey(name, value, is_idle, out)?;
        if let Order::Run { sim } = order {
            if N != M {
                return Err(Error::Unavailable);
            }
            self.sim = sim;
        }
        Ok(order)
    }

    fn start(
        &mut self,
        standing: &Standing<N>,
        out: &mut dyn Write,
    ) -> Result<PathSetting<N>, Error> {
        let own = standing.of_first().ok_or(Error::Unavailable)?;
        let begun = self.machine.begin(&own, self.sim, out)?;
        let all = core::array::from_fn(|i| begun.weight.get(i).copied().unwrap_or(1.0));
        let setting = PathSetting::new(all, begun.contour).map_err(|_| {
            say(
                out,
                format_args!("BadLimit: expected a tolerance of at least 0.0001 mm, see $1003"),
            );
            Error::ValueRange
        })?;
        self.begins = false;
        self.queued = None;
        self.path = Some(Running::new(begun.path, self.sim));
        Ok(setting)
    }

    fn next(&mut self, out: &mut dyn Write) -> Progress<N> {
        let Some(path) = &mut self.path else {
            return Progress::Over;
        };
        match (path.next(out), self.queued) {
            (Progress::Waits, Some(line)) => {
                self.queued = None;
                match self.put(line, out) {
                    Ok(_) => Progress::Busy,
                    Err(error) => Progress::Refused(error),
                }
            }
            (Progress::Taken, _) => {
                self.begins = false;
                Progress::Taken
            }
            (progress, _) => progress.on_all(),
        }
    }

    fn owes_answer(&self) -> bool {
        let is_trying = |running: &Running<_, _, M>| running.path.is_trying();
        self.queued.is_some() || self.path.as_ref().is_some_and(is_trying)
    }

    fn stop(&mut self) {
        self.path = None;
        self.queued = None;
    }

    fn pair(&self, scale: &Scale<N>, out: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        let own = scale.first().ok_or(Error::Unavailable)?;
        self.machine.pair(&own, out)
    }
}

/// A path under way, and what it comes to.
struct Running<P, T, const M: usize>
where
    P: Process<f32, End = End<T::Course, f32>>,
    T: Tooled<M>,
{
    path: PointPath<P, T, M>,
    sim: bool,
    blocks: u32,
    /// Least time of all blocks [us].
    time: u64,
}

impl<P, T, const M: usize> Running<P, T, M>
where
    P: Process<f32, End = End<T::Course, f32>>,
    T: Tooled<M>,
    P::Error: Told,
    T::Error: Told,
{
    fn new(path: PointPath<P, T, M>, sim: bool) -> Self {
        Self {
            path,
            sim,
            blocks: 0,
            time: 0,
        }
    }

    /// Puts a point in, or `None` behind the last one.
    fn take(&mut self, point: Option<&P::Point>, out: &mut dyn Write) -> Result<Order, Error> {
        match self.path.take(point) {
            Ok(()) => Ok(Order::Point),
            Err(fault) => Err(refuse(self.path.points(), &fault, out)),
        }
    }

    fn next(&mut self, out: &mut dyn Write) -> Progress<M> {
        match self.path.step() {
            Step::Waits if self.path.is_complete() => {
                if self.sim {
                    let ms = (self.time + 500) / 1000;
                    say(
                        out,
                        format_args!(
                            "Simulated: {} points, {} blocks, {}.{:03} s at least, rapids not counted",
                            self.path.points(),
                            self.blocks,
                            ms / 1000,
                            ms % 1000
                        ),
                    );
                }
                Progress::Over
            }
            Step::Waits => Progress::Waits,
            Step::Looked => Progress::Busy,
            Step::Taken => Progress::Taken,
            Step::Refused(fault) => Progress::Refused(refuse(self.path.points(), &fault, out)),
            Step::Target(target) => self.count(target),
        }
    }

    fn count(&mut self, target: Target<M>) -> Progress<M> {
        self.blocks = self.blocks.saturating_add(1);
        // A block of more than an hour counts as one of an hour.
        self.time += u64::from((target.duration * 1e6 + 0.5) as u32);
        if self.sim {
            Progress::Busy
        } else {
            Progress::Target(target)
        }
    }
}

/// Says why the point `index` cannot be worked.
fn refuse<P: Told, M: Told>(index: u32, fault: &Fault<P, M>, out: &mut dyn Write) -> Error {
    let (name, remedy) = match fault {
        Fault::Process(error) => (error.name(), error.remedy()),
        Fault::Machine(error) => (error.name(), error.remedy()),
        Fault::Path(PathError::OutOfReach) => ("OutOfReach", "a motor would leave its counter"),
        Fault::Path(PathError::OutOfTravel { .. }) => (
            "OutOfTravel",
            "a joint would leave its travel, see $1040 and $1050",
        ),
        Fault::NoBranch => (
            "NoBranch",
            "in every branch a joint would leave its range, or the arm is singular",
        ),
        Fault::AntiParallel => (
            "AntiParallel",
            "neighbouring tool axes must not be opposite; insert points between them",
        ),
        Fault::BadFeed => ("BadLimit", "feed and tolerances must be greater than 0"),
        Fault::Reconfigure => (
            "Reconfigure",
            "the joints would change to another solution with the tool in the work; begin a row there",
        ),
        Fault::Coarse => (
            "Coarse",
            "joints turn too fast beside a pole; lead the path farther from it, or widen $1003",
        ),
    };
    let joint = match fault {
        Fault::Machine(error) => error.joint(),
        Fault::Path(PathError::OutOfTravel { joint }) => Some(*joint),
        _ => None,
    };
    let _ = write!(out, "[MSG:{name} point {index}");
    if let Some(joint) = joint {
        let _ = write!(out, " joint {joint}");
    }
    let _ = write!(out, ": {remedy}]\r\n");
    match fault {
        Fault::Process(_) | Fault::BadFeed => Error::ValueRange,
        _ => Error::BeyondTravel,
    }
}
