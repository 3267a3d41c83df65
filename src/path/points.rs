//! Points of a process from outside -> targets: each point is walked to its end before anything of it moves.
//!
//! ```text
//!            take            next, a copy first               next
//!  point --> Process::Marks --> Walker: follower, steps --> Checked --> Walker --> Target
//!               |                  | refused: process and walker as they were before the point
//!               '- one point may be many marks: the poses of a stretch of precession
//!
//!   drawn back  .------------------.        before the first mark, between rows, behind the last one
//!               |                  |
//!       row ----'                  '---- row
//! ```
//!
//! One call of [`PointPath::step`] solves one block, so the foreground is never away for long, however many a point needs.

use super::{PathError, Scale, Target};
use crate::cycles::{Mark, Pace, Process};
use crate::joints::Joints;
use crate::kinematics::follow::{Block, End, Follower, Guide, Refusal, State, Tolerance};
use crate::math::Real;
use heapless::Deque;

/// A machine with the tool of a process.
pub trait Tooled<const M: usize>: Guide<M, f32> + Sized {
    /// Makes up its mind, before the first mark, about what then stays for the whole path; `false` if nothing will do.
    fn choose(
        &mut self,
        first: &End<Self::Course, f32>,
        near: &Joints<M>,
    ) -> Result<bool, Self::Error>;

    /// Joints of a mark that no motion in the work leads to, nearest to `near`.
    fn reach(
        &self,
        at: &End<Self::Course, f32>,
        near: &Joints<M>,
    ) -> Result<Self::Set, Self::Error>;

    /// The same with the tool drawn back from the work by `clear` [mm].
    fn draw_back(
        &self,
        at: &End<Self::Course, f32>,
        set: &Self::Set,
        clear: f32,
    ) -> Result<Joints<M>, Self::Error>;
}

/// Why a point is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault<P, M> {
    Process(P),
    Machine(M),
    Path(PathError),
    /// Whatever the machine might choose leaves a range, or is singular there.
    NoBranch,
    /// Tool axes that are opposite: no shortest turn leads from one to the other.
    AntiParallel,
    /// A feed or a tolerance that is none.
    BadFeed,
    /// The joints would change to another solution, or wind back, with the tool in the work.
    Reconfigure,
    /// Joints turn so fast beside a pole that the finest blocks do not keep the tolerance.
    Coarse,
}

/// What does not change along a path.
#[derive(Clone, Debug)]
pub struct Shop<T, const M: usize> {
    pub tool: T,
    pub scale: Scale<M>,
    pub tolerance: Tolerance<f32>,
    /// Nothing is left for the tool to choose.
    pub is_chosen: bool,
    /// How far the tool is drawn back between rows, before the first mark and behind the last one [mm].
    pub clear: f32,
    /// How fast it goes into the work [mm/s].
    pub plunge: f32,
}

/// Targets that wait behind one mark: out of the work, across, in again.
const HELD: usize = 3;

/// A walk over marks.
struct Walker<T, I, const M: usize>
where
    T: Tooled<M>,
{
    state: Option<State<T, M, f32>>,
    /// Joints at the last target.
    near: Joints<M>,
    marks: Option<I>,
    held: Deque<Target<M>, HELD>,
    /// Behind the last mark the tool is drawn back.
    closes: bool,
}

// Not derived: the machine itself need not be one to copy.
impl<T, I: Clone, const M: usize> Clone for Walker<T, I, M>
where
    T: Tooled<M>,
{
    fn clone(&self) -> Self {
        Self {
            state: self.state,
            near: self.near,
            marks: self.marks.clone(),
            held: self.held.clone(),
            closes: self.closes,
        }
    }
}

type FaultOf<P, T, const M: usize> = Fault<<P as Process<f32>>::Error, <T as Guide<M, f32>>::Error>;

impl<T, const M: usize> Shop<T, M>
where
    T: Tooled<M>,
{
    fn target<P>(
        &self,
        joints: &Joints<M>,
        duration: f32,
    ) -> Result<Target<M>, Fault<P, T::Error>> {
        self.scale.target(joints, duration).map_err(Fault::Path)
    }

    fn of_block<P>(&self, block: &Block<M, f32, T::Set>) -> Result<Target<M>, Fault<P, T::Error>> {
        if block.flags.reconfigure {
            return Err(Fault::Reconfigure);
        }
        if block.flags.coarse {
            return Err(Fault::Coarse);
        }
        self.target(&block.joints, block.duration)
    }
}

fn refused<P, E>(why: Refusal<E>) -> Fault<P, E> {
    match why {
        Refusal::AntiParallel => Fault::AntiParallel,
        Refusal::BadFeed | Refusal::BadLimit => Fault::BadFeed,
        Refusal::Machine(why) => Fault::Machine(why),
    }
}

impl<T, I, const M: usize> Walker<T, I, M>
where
    T: Tooled<M>,
    I: Iterator<Item = Mark<End<T::Course, f32>, f32>> + Clone,
{
    /// The next target; `None` when more points are wanted.
    fn next<P>(&mut self, shop: &Shop<T, M>) -> Option<Result<Target<M>, Fault<P, T::Error>>> {
        loop {
            if let Some(target) = self.held.pop_front() {
                return Some(Ok(target));
            }
            if let Some(state) = self.state {
                let mut follower = Follower::resume(&shop.tool, shop.tolerance, state);
                if let Some(stepped) = follower.step() {
                    let block = match stepped {
                        Ok(block) => block,
                        Err(why) => return Some(Err(refused(why.why))),
                    };
                    self.state = Some(follower.state());
                    self.near = block.joints;
                    return Some(shop.of_block(&block));
                }
            }
            let came = match self.marks.as_mut().and_then(Iterator::next) {
                Some(mark) => self.come_to(shop, mark),
                None if core::mem::take(&mut self.closes) => self.leave(shop),
                None => return None,
            };
            if let Err(fault) = came {
                return Some(Err(fault));
            }
        }
    }

    fn come_to<P>(
        &mut self,
        shop: &Shop<T, M>,
        mark: Mark<End<T::Course, f32>, f32>,
    ) -> Result<(), Fault<P, T::Error>> {
        let end = mark.end;
        if let (Some(state), Pace::Feed(feed)) = (self.state, mark.pace) {
            let mut follower = Follower::resume(&shop.tool, shop.tolerance, state);
            follower.lead(end, feed).map_err(|why| refused(why.why))?;
            self.state = Some(follower.state());
        } else {
            let is_apart = mark.pace != Pace::Rapid && shop.clear > 0.0;
            if is_apart {
                self.leave(shop)?;
            }
            let set = shop.tool.reach(&end, &self.near).map_err(Fault::Machine)?;
            let joints = shop.tool.joints(&set);
            let mut duration = 0.0;
            if is_apart {
                let back = shop.tool.draw_back(&end, &set, shop.clear);
                self.hold(shop.target(&back.map_err(Fault::Machine)?, 0.0)?);
                duration = shop.clear / shop.plunge;
            }
            self.hold(shop.target(&joints, duration)?);
            self.near = joints;
            self.state = Some(State::at(end, set));
        }
        Ok(())
    }

    /// Out of the work, if the tool is in it.
    fn leave<P>(&mut self, shop: &Shop<T, M>) -> Result<(), Fault<P, T::Error>> {
        let Some(state) = self.state else {
            return Ok(());
        };
        if shop.clear > 0.0 {
            let back = shop.tool.draw_back(state.end(), state.set(), shop.clear);
            let back = back.map_err(Fault::Machine)?;
            self.hold(shop.target(&back, shop.clear / shop.plunge)?);
            self.near = back;
        }
        Ok(())
    }

    fn hold(&mut self, target: Target<M>) {
        // At most three are asked for, and none is left from before.
        let _ = self.held.push_back(target);
    }
}

/// What a call of [`PointPath::step`] came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step<const M: usize, F> {
    /// Nothing to do until a point comes, or, behind the last one, at all.
    Waits,
    /// One more block of the point has been looked at.
    Looked,
    /// All of the point can be run; its targets come next.
    Taken,
    /// The point cannot be run. All is as before it.
    Refused(F),
    Target(Target<M>),
}

/// The path of a process that comes point by point.
pub struct PointPath<P, T, const M: usize>
where
    P: Process<f32, End = End<T::Course, f32>>,
    T: Tooled<M>,
{
    shop: Shop<T, M>,
    process: P,
    real: Walker<T, P::Marks, M>,
    trial: Option<Trial<P, T, M>>,
    points: u32,
    complete: bool,
}

/// A point on trial.
struct Trial<P, T, const M: usize>
where
    P: Process<f32, End = End<T::Course, f32>>,
    T: Tooled<M>,
{
    /// The process behind the point.
    process: P,
    marks: P::Marks,
    /// Looks ahead of the real walk.
    walk: Walker<T, P::Marks, M>,
    last: bool,
}

impl<P, T, const M: usize> PointPath<P, T, M>
where
    P: Process<f32, End = End<T::Course, f32>>,
    T: Tooled<M>,
{
    /// A path that begins at the joints `near`.
    pub fn new(shop: Shop<T, M>, process: P, near: Joints<M>) -> Self {
        Self {
            shop,
            process,
            real: Walker {
                state: None,
                near,
                marks: None,
                held: Deque::new(),
                closes: false,
            },
            trial: None,
            points: 0,
            complete: false,
        }
    }

    /// Points taken so far.
    pub fn points(&self) -> u32 {
        self.points
    }

    /// The last point has been taken.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Whether nothing is left of the points taken so far.
    pub fn is_drained(&self) -> bool {
        let real = &self.real;
        let has_blocks = real.state.as_ref().is_some_and(State::has_stretch);
        let has_marks = real
            .marks
            .as_ref()
            .is_some_and(|m| m.clone().next().is_some());
        self.trial.is_none() && !(has_blocks || has_marks || real.closes || !real.held.is_empty())
    }

    /// Whether a point has not been answered yet.
    pub fn is_trying(&self) -> bool {
        self.trial.is_some()
    }

    /// The next point, `None` behind the last one: only while [`Self::step`] waits.
    pub fn take(&mut self, point: Option<&P::Point>) -> Result<(), FaultOf<P, T, M>> {
        let mut process = self.process.clone();
        let marks = match point {
            Some(point) => process.take(point),
            None => process.finish(),
        }
        .map_err(Fault::Process)?;
        if self.real.state.is_none()
            && !self.shop.is_chosen
            && let Some(first) = marks.clone().next()
        {
            let chosen = self.shop.tool.choose(&first.end, &self.real.near);
            if !chosen.map_err(Fault::Machine)? {
                return Err(Fault::NoBranch);
            }
        }
        let mut walk = self.real.clone();
        walk.marks = Some(marks.clone());
        walk.closes = point.is_none();
        self.trial = Some(Trial {
            process,
            marks,
            walk,
            last: point.is_none(),
        });
        Ok(())
    }

    /// One block more.
    pub fn step(&mut self) -> Step<M, FaultOf<P, T, M>> {
        let Some(trial) = &mut self.trial else {
            // Walked before.
            return match self.real.next::<P::Error>(&self.shop) {
                Some(Ok(target)) => Step::Target(target),
                Some(Err(_)) | None => Step::Waits,
            };
        };
        match trial.walk.next(&self.shop) {
            Some(Ok(_)) => Step::Looked,
            Some(Err(fault)) => {
                self.trial = None;
                Step::Refused(fault)
            }
            None => {
                if let Some(trial) = self.trial.take() {
                    self.process = trial.process;
                    self.real.marks = Some(trial.marks);
                    self.real.closes = trial.last;
                    self.complete = trial.last;
                    self.points = self.points.saturating_add(u32::from(!trial.last));
                }
                Step::Taken
            }
        }
    }
}

/// What the planner may leave of a path whose chords use `chords` of the tolerance [mm].
///
/// Along a chord, u = 0 .. 1, what the chord strays by and what the planner rounds off its ends add up to
/// 4 e u (1 - u) + c (1 - u / u0)^2 with u0 up to 1/2, never more than the larger of e and c; only where the planner merges
/// chords does it stray in the middle of one, by 0.4 of its own tolerance. It measures in the joints, and parts of that may
/// add up in the tip: one of all joints that slide and one of each that turns, `groups` in all.
pub fn left_for_corners<R: Real>(tolerance: R, chords: R, groups: u8) -> R {
    const MERGED: f64 = 0.4;
    (R::ONE - chords) / R::of(MERGED) * tolerance / R::of_i32(i32::from(groups)).sqrt()
}
