//! Poses -> joint blocks: halves a stretch of the path until the straight joint-space move keeps to the tolerances.
//!
//! ```text
//!   from -----------u------------ to      the tip on the straight line, the tool axis on the great circle
//!   |--------|--------|-----------------| pending; the first is solved, bounded, emitted or halved again
//!   0       1/4      1/2                1
//! ```
//!
//! Every part is a whole number of 2^-12 of the stretch, so the pending intervals need no stack: behind a point `k` /
//! 4096 waits the interval as wide as the lowest set bit of `k`. The deepest interval is emitted with the flag coarse.
//!
//! A block lasts as long as the tip feed or the inverse time asks for, and longer where a joint would exceed its speed:
//! near a pole the tool slows down, and the block names the joint.
//!
//! A stretch is walked twice: [`Follower::push`] walks it to its end and refuses it as a whole, saying where; only then
//! [`Follower::next`] emits. So nothing of a failing stretch is ever emitted.
//!
//! Source: sections 5 and 6 of the five-axis specification.

use super::way::Course;
use crate::joints::Joints;
use crate::math::Real;

/// Parts of a stretch: depth 12.
const PARTS: u16 = 1 << 12;

/// An end of a course.
pub type End<C, R> = <C as Course<R>>::End;

/// What a machine with `N` joints offers to be followed along poses.
pub trait Guide<const N: usize, R: Real> {
    /// What leads from pose to pose: [`Way`](super::Way) between CL points, [`PoseWay`](super::PoseWay) between whole
    /// poses.
    type Course: Course<R>;
    /// A solved set of joints, with all that the bounds need.
    type Set: Copy;
    type Error: Copy;

    /// Joints for an end of the course, nearest to those before.
    fn solve(
        &self,
        at: &End<Self::Course, R>,
        before: &Self::Set,
    ) -> Result<Self::Set, Self::Error>;

    /// Joint values [mm, rad].
    fn joints(&self, set: &Self::Set) -> Joints<N, R>;

    /// `to - from`, joint by joint [mm, rad], exact in the turns.
    fn change(&self, from: &Self::Set, to: &Self::Set) -> Joints<N, R>;

    /// Bounds of the tip error [mm] and the tool axis error [rad] when the joints run linearly between two ends,
    /// whose tips are `length` [mm] and whose tools are a turn of `chord`
    /// (2 sin(angle / 2)) apart. No axis bound where
    /// none is known.
    fn bound(&self, from: &Self::Set, to: &Self::Set, length: R, chord: R) -> (R, Option<R>);

    /// Whether no continuous joint motion along this stretch leads from one set to the other: the solution changes, or
    /// a turn is wound back.
    fn is_reconfigured(
        &self,
        from: (&End<Self::Course, R>, &Self::Set),
        to: (&End<Self::Course, R>, &Self::Set),
    ) -> bool;

    /// Whether the set stands at a pole or on the border of what can be reached.
    fn is_singular(&self, set: &Self::Set) -> bool;

    /// Largest joint speeds [mm/s, rad/s]; `None` is no limit.
    fn speeds(&self) -> Option<Joints<N, R>>;
}

/// How fast a stretch is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Feed<R> {
    /// Speed of the tip [mm/s].
    Tip(R),
    /// Time of the whole stretch [s]; inverse time is 60 / this.
    Time(R),
}

/// How closely the joints follow the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<R> {
    /// Of the tip [mm].
    pub tip: R,
    /// Of the tool axis [rad].
    pub axis: R,
    /// False: every stretch is one block, coarse where a bound is exceeded.
    pub subdivide: bool,
}

/// Why a stretch is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal<E> {
    /// The axes at both ends are opposite: no great circle is meant.
    AntiParallel,
    /// The feed is not above 0 or not finite, or the tip stands still and no joint speed is known.
    BadFeed,
    /// A tolerance is not above 0 or not finite.
    BadLimit,
    Machine(E),
}

/// Which stretch was refused, where on it (0 ..= 1), and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused<R, E> {
    /// Stretches count from 0: stretch i leads to CL point i + 1.
    pub segment: u32,
    pub u: R,
    pub why: Refusal<E>,
}

/// What a block warns of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// It ends at a pole or on the border of what can be reached.
    pub singular: bool,
    /// A bound exceeds its tolerance: the narrowest interval, or no subdivision wanted.
    pub coarse: bool,
    /// Its ends are not joined by a continuous motion: retract the tool first.
    pub reconfigure: bool,
}

/// A straight joint-space move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block<const N: usize, R, S> {
    /// The stretch it is part of, from 0, and where on it the block ends (0 ..= 1].
    pub segment: u32,
    pub u: R,
    /// Joints at its end [mm, rad].
    pub joints: Joints<N, R>,
    pub set: S,
    /// Duration [s], >= 0.
    pub duration: R,
    /// The joint whose speed stretches the duration; `None` when the feed rules.
    pub limited_by: Option<usize>,
    pub flags: Flags,
}

/// The stretch being emitted.
#[derive(Clone, Copy, Debug)]
struct Stretch<C, R, S> {
    way: C,
    /// Joints chosen for the end beforehand.
    end: Option<S>,
    feed: Feed<R>,
    /// One block, whatever the bounds say.
    is_whole: bool,
    is_reconfigured: bool,
    /// Parts done.
    done: u16,
}

/// A stretch of machine `M`.
type StretchOf<M, const N: usize, R> =
    Stretch<<M as Guide<N, R>>::Course, R, <M as Guide<N, R>>::Set>;

/// Where a follower stands, for those who keep the machine elsewhere: [`Follower::resume`] goes on from here.
pub struct State<M, const N: usize, R: Real>
where
    M: Guide<N, R>,
{
    /// End of the last block.
    at: End<M::Course, R>,
    set: M::Set,
    /// End of the last stretch taken in.
    target: End<M::Course, R>,
    stretch: Option<StretchOf<M, N, R>>,
    segment: u32,
}

// Not derived: the machine itself need not be one to copy.
impl<M, const N: usize, R: Real> Clone for State<M, N, R>
where
    M: Guide<N, R>,
{
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, const N: usize, R: Real> Copy for State<M, N, R> where M: Guide<N, R> {}

impl<M, const N: usize, R: Real> State<M, N, R>
where
    M: Guide<N, R>,
{
    /// At rest at a solved end.
    pub fn at(start: End<M::Course, R>, set: M::Set) -> Self {
        Self {
            at: start,
            set,
            target: start,
            stretch: None,
            segment: 0,
        }
    }

    /// Joints at the end of the last block.
    pub fn set(&self) -> &M::Set {
        &self.set
    }

    /// End of the last stretch taken in.
    pub fn end(&self) -> &End<M::Course, R> {
        &self.target
    }

    /// Whether blocks of a stretch are left.
    pub fn has_stretch(&self) -> bool {
        self.stretch.is_some()
    }
}

/// Follows poses stretch by stretch, from the last solved set.
pub struct Follower<'a, M, const N: usize, R: Real>
where
    M: Guide<N, R>,
{
    machine: &'a M,
    tolerance: Tolerance<R>,
    state: State<M, N, R>,
}

impl<M, const N: usize, R: Real> core::fmt::Debug for Follower<'_, M, N, R>
where
    M: Guide<N, R>,
{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        // The machine's own types need not be shown.
        f.debug_struct("Follower")
            .field("segment", &self.state.segment)
            .finish_non_exhaustive()
    }
}

impl<'a, M, const N: usize, R: Real> Follower<'a, M, N, R>
where
    M: Guide<N, R>,
{
    /// Starts at a solved CL point. Fails with BadLimit.
    pub fn new(
        machine: &'a M,
        tolerance: Tolerance<R>,
        start: End<M::Course, R>,
        set: M::Set,
    ) -> Result<Self, Refusal<M::Error>> {
        let is_good = |x: R| x > R::ZERO && x.is_finite();
        if !is_good(tolerance.tip) || !is_good(tolerance.axis) {
            return Err(Refusal::BadLimit);
        }
        Ok(Self::resume(machine, tolerance, State::at(start, set)))
    }

    /// Goes on where a follower of the same machine stood.
    pub fn resume(machine: &'a M, tolerance: Tolerance<R>, state: State<M, N, R>) -> Self {
        Self {
            machine,
            tolerance,
            state,
        }
    }

    pub fn state(&self) -> State<M, N, R> {
        self.state
    }

    /// Joints at the end of the last block.
    pub fn set(&self) -> &M::Set {
        &self.state.set
    }

    /// Takes in the stretch to the next pose, when all blocks of the one before have been emitted; `end` gives its
    /// joints if they have been chosen before. The stretch is walked to its end: when it is refused, nothing has
    /// changed and nothing of it will be emitted. Returns false, and does nothing, while blocks are left.
    pub fn push(
        &mut self,
        to: End<M::Course, R>,
        end: Option<M::Set>,
        feed: Feed<R>,
    ) -> Result<bool, Refused<R, M::Error>> {
        if self.state.stretch.is_some() {
            return Ok(false);
        }
        let segment = self.state.segment;
        let refuse = |u, why| Refused { segment, u, why };
        let mut stretch = self
            .stretch_to(to, end, feed)
            .map_err(|why| refuse(R::ZERO, why))?;
        if let Some(end) = end {
            let is_far = |from: &M::Set| {
                let change = self.machine.change(from, &end);
                change
                    .0
                    .iter()
                    .any(|q| q.abs() > R::of(1e4) * R::EPSILON * self.reach(&end))
            };
            stretch.is_reconfigured = self
                .machine
                .is_reconfigured((&self.state.at, &self.state.set), (&to, &end));
            if !stretch.is_reconfigured && !stretch.is_whole {
                let before = self.walk(stretch)?;
                let greedy = self
                    .machine
                    .solve(&to, &before)
                    .map_err(|why| refuse(R::ONE, Refusal::Machine(why)))?;
                stretch.is_reconfigured = is_far(&greedy);
            }
            stretch.is_whole |= stretch.is_reconfigured;
        }
        self.walk(stretch)?;
        self.state.stretch = Some(stretch);
        self.state.target = to;
        Ok(true)
    }

    /// The next block of the stretch; `None` when the next CL point is wanted.
    pub fn next_block(&mut self) -> Option<Block<N, R, M::Set>> {
        // The walk in `push` went through here before: a refusal cannot be.
        self.step().and_then(Result::ok)
    }

    /// Takes in the stretch to the next pose without walking it, for those who walk a copy of the follower: one block
    /// at a time by [`Self::step`], so that none of it takes long. What was left of the stretch before is dropped.
    pub fn lead(
        &mut self,
        to: End<M::Course, R>,
        feed: Feed<R>,
    ) -> Result<(), Refused<R, M::Error>> {
        let segment = self.state.segment;
        let stretch = self.stretch_to(to, None, feed).map_err(|why| Refused {
            segment,
            u: R::ZERO,
            why,
        })?;
        self.state.stretch = Some(stretch);
        self.state.target = to;
        Ok(())
    }

    /// The next block of the stretch, or why there is none: then the stretch is dropped.
    // The types are those of the machine at hand; a name for them would have to carry all of its parameters.
    #[allow(clippy::type_complexity)]
    pub fn step(&mut self) -> Option<Result<Block<N, R, M::Set>, Refused<R, M::Error>>> {
        let state = &mut self.state;
        let stretch = state.stretch.as_mut()?;
        let walked = advance(
            self.machine,
            &self.tolerance,
            state.segment,
            &mut state.at,
            &mut state.set,
            stretch,
        );
        if walked.is_err() || stretch.done >= PARTS {
            state.stretch = None;
            state.segment = state.segment.saturating_add(1);
        }
        Some(walked)
    }

    /// A measure of the joints' size, so that rounding can be told from change.
    fn reach(&self, set: &M::Set) -> R {
        let joints = self.machine.joints(set);
        joints.0.iter().fold(R::ONE, |most, q| most.max(q.abs()))
    }

    // The types are those of the machine at hand; a name for them would have to carry all of its parameters.
    #[allow(clippy::type_complexity)]
    fn stretch_to(
        &self,
        to: End<M::Course, R>,
        end: Option<M::Set>,
        feed: Feed<R>,
    ) -> Result<StretchOf<M, N, R>, Refusal<M::Error>> {
        let (Feed::Tip(amount) | Feed::Time(amount)) = feed;
        let shift = M::Course::tip(&to) - M::Course::tip(&self.state.target);
        let is_still = shift.norm() <= R::ZERO;
        let has_speeds = self.machine.speeds().is_some();
        let needs_speeds = matches!(feed, Feed::Tip(_)) && is_still;
        if amount <= R::ZERO || !amount.is_finite() || (needs_speeds && !has_speeds) {
            return Err(Refusal::BadFeed);
        }
        Ok(Stretch {
            way: M::Course::new(self.state.target, to).ok_or(Refusal::AntiParallel)?,
            end,
            feed,
            is_whole: !self.tolerance.subdivide,
            is_reconfigured: false,
            done: 0,
        })
    }

    /// Walks a stretch without emitting; returns the set before its last block.
    fn walk(&self, mut stretch: StretchOf<M, N, R>) -> Result<M::Set, Refused<R, M::Error>> {
        let (mut at, mut set) = (self.state.at, self.state.set);
        let mut before = set;
        while stretch.done < PARTS {
            before = set;
            advance(
                self.machine,
                &self.tolerance,
                self.state.segment,
                &mut at,
                &mut set,
                &mut stretch,
            )?;
        }
        Ok(before)
    }
}

/// The next block of `stretch` from the set `set` at the point `at`, both of which it moves on.
fn advance<M, const N: usize, R: Real>(
    machine: &M,
    tolerance: &Tolerance<R>,
    segment: u32,
    at: &mut End<M::Course, R>,
    set: &mut M::Set,
    stretch: &mut StretchOf<M, N, R>,
) -> Result<Block<N, R, M::Set>, Refused<R, M::Error>>
where
    M: Guide<N, R>,
{
    let done = stretch.done;
    // The pending interval behind `done`: as wide as its lowest set bit; the whole stretch at first.
    let mut parts = match done {
        0 => PARTS,
        _ => done & done.wrapping_neg(),
    };
    if stretch.is_whole {
        parts = PARTS;
    }
    loop {
        let end = done.saturating_add(parts);
        let to = stretch.way.at(fraction(end));
        let solved = match stretch.end {
            Some(chosen) if end >= PARTS => Ok(chosen),
            _ => machine.solve(&to, set),
        };
        let next = solved.map_err(|why| Refused {
            segment,
            u: fraction(end),
            why: Refusal::Machine(why),
        })?;

        let length = stretch.way.length() * fraction::<R>(parts);
        let chord = M::Course::chord(at, &to);
        let (tip, axis) = machine.bound(set, &next, length, chord);
        let is_within = tip <= tolerance.tip && axis.is_some_and(|axis| axis <= tolerance.axis);
        if !is_within && !stretch.is_whole && parts > 1 {
            parts /= 2;
            continue;
        }

        let (duration, limited_by) = duration(machine, stretch, set, &next, parts);
        let is_reconfigured =
            stretch.is_reconfigured || machine.is_reconfigured((at, set), (&to, &next));
        let flags = Flags {
            singular: machine.is_singular(&next),
            // While the tool is retracted no bound is meant, unless every block is to be judged.
            coarse: !(is_within || stretch.is_reconfigured && tolerance.subdivide),
            reconfigure: is_reconfigured,
        };
        stretch.done = end;
        *at = to;
        *set = next;
        return Ok(Block {
            segment,
            u: fraction(end),
            joints: machine.joints(&next),
            set: next,
            duration,
            limited_by,
            flags,
        });
    }
}

/// The time of a block [s], and the joint that stretches it.
fn duration<M, const N: usize, R: Real>(
    machine: &M,
    stretch: &StretchOf<M, N, R>,
    from: &M::Set,
    to: &M::Set,
    parts: u16,
) -> (R, Option<usize>)
where
    M: Guide<N, R>,
{
    let share = fraction::<R>(parts);
    let mut duration = match stretch.feed {
        Feed::Tip(speed) => stretch.way.length() * share / speed,
        Feed::Time(time) => time * share,
    };
    let mut limited_by = None;
    if let Some(speeds) = machine.speeds() {
        let change = machine.change(from, to);
        for (joint, (change, speed)) in change.0.iter().zip(&speeds.0).enumerate() {
            let least = change.abs() / *speed;
            if least > duration {
                duration = least;
                limited_by = Some(joint);
            }
        }
    }
    (duration, limited_by)
}

fn fraction<R: Real>(parts: u16) -> R {
    R::of_i32(i32::from(parts)) * R::of(1.0 / PARTS as f64)
}
