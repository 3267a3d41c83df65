//! Joint targets -> [`Sample`]: commanded positions, one a millisecond, within every joint's limits.
//!
//! ```text
//!  push(target, least time)                                    steps, s
//!     |  merge       chords that one line replaces within 0.4 of the tolerance become one block
//!     |  block       direction and length of the block; what every joint allows along it
//!     |  junction    the vertex before it: rounded through whole blocks, in a narrow zone, or a stop
//!     v  look_ahead  backward: highest speed at which each span may be entered
//!  ---- ring of 88 blocks ----
//!     |  run         cruise, ramp up, ramp down; hold, override, stop
//!     |  profile     s(t) on integers, jerk-limited, every ramp's distance exact before it starts
//!     |  trace       s -> joints: polygon and rounding, exact at every vertex that rests
//!     v  trim        offset of each joint, within its share of the limits
//!  next() -> Sample                                            steps with a 32-bit fraction
//!
//!  speed                 ramp up        cruise       ramp down, planned from its root backward
//!    |                  _-----_______________________-_
//!    |                _/                               \_        corner at constant speed
//!    |              _/                                   \_______/--
//!    +------------+---|----|----|----|----|----|----|----|-------|----> s
//!                       blocks of a smooth curve, crossed as one
//! ```
//!
//! The path is rounded in path length, so it does not depend on speed, hold or override; only the speed along it does.
//! Instead of the moving average over s(t) that motion.md recommends, ramps are jerk-limited from the start, each with the
//! acceleration and jerk of the joints and blocks it crosses: a mean over one time T for all is optimal only where
//! T = a/j of the block at hand, and takes 2.3 T where 1.9 T would do for a tenth of the length 2 a^3/j^2 (its ratio there is
//! 1.26, above the 1.25 asked for); with a ramp's own shape every straight move is optimal, at any length.
//!
//! Cost on a Cortex-M4F: 28 000 instructions a block of a dense curve at a full look-ahead, push and samples together
//! (`planner_instructions_per_block` of `cargo xtask bench`): half of it samples, a third the backward pass.
//!
//! Runs in the foreground. The path planned always ends in a standstill: input may pause at any time.

mod block;
mod junction;
mod limits;
mod look_ahead;
mod merge;
mod profile;
mod ramp;
mod ring;
mod run;
mod trace;
mod trim;

pub use limits::{
    LONGEST_RISE, Limits, LimitsError, MOST_ACCELERATION, MOST_JERK, MOST_VELOCITY, PathError,
    PathSetting, WEIGHT_RATIO,
};
pub use ring::BLOCKS;
pub use trim::MOST_TRIM;

use crate::math::Real;
use block::Block;
use fixed::types::I32F32;
use limits::Scaled;
use look_ahead::Factors;
use merge::Cone;
use profile::TICK;
use ring::Ring;
use run::{Passed, Plan, Runner, Wish};
use trace::Trace;
use trim::Trim;

/// Share of the tolerance for the merging of chords; rounding has the rest, and all of it where nothing is merged.
const MERGE_SHARE: f32 = 0.4;
/// Speeds of two chords that may become one line: within this ratio.
const SAME_SPEED: f32 = 1.25;
/// Merged chords grow by this factor from one to the next while the tolerance lets them.
const GROWTH: f32 = 1.1;
/// What they keep of the length at which the tolerance cut one.
const ROOM: f32 = 0.95;
/// Slowest programmed speed [length/ms]: below, a block would outlast the counters.
const SLOWEST: f32 = 1.0e-9;

/// Time from one sample to the next [s].
pub const SAMPLE: f32 = 1.0e-3;
pub const SAMPLES_PER_SECOND: u32 = 1000;

/// Commanded position of each joint at the end of the next millisecond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample<const N: usize> {
    /// [steps]
    pub position: [I32F32; N],
    /// At rest there: nothing needs to follow. On whole steps, except in a feed hold.
    pub last: bool,
}

/// Why a block was not taken; nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PushError {
    /// The look-ahead is full: come back after the next sample.
    Full,
    /// A controlled stop is under way: come back when the planner is idle.
    Stopping,
    /// The position is lost; [`Planner::reset`] sets it.
    Lost,
    /// Expected a duration that is finite and not negative.
    Duration,
    /// Longer than 2^31 - 1 steps, or than 2^31 lengths of the coarsest joint's step.
    TooLong,
}

/// Why a request was not taken; nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingError {
    /// Only at rest.
    Moving,
    /// Outside its range.
    Range,
}

/// What happened so far; all wrap at 2^32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Blocks taken, and how many of them became part of the one before.
    pub blocks: u32,
    pub merged: u32,
    /// Samples given [ms]; the first wrap is after 49.7 days of motion.
    pub samples: u32,
    /// Times that the path ran out and the joints came to rest.
    pub rests: u32,
    /// Ramps that had to be more than a hundredth steeper than planned: a handful in a day of overrides under way.
    pub squeezed: u32,
    /// Ramps down that an arriving block cut short.
    pub eased: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Running,
    Held,
    /// Slowing down to drop the rest.
    Stopping,
    Lost,
}

/// The planner of N joints.
pub struct Planner<const N: usize> {
    limits: Limits<N>,
    scaled: Scaled<N>,
    path: PathSetting<N>,
    /// Weights, the largest 1.
    weight: [f32; N],
    /// [length per mm]
    unit: f32,
    ring: Ring<N>,
    trace: Trace<N>,
    runner: Runner,
    state: State,
    planned: Factors,
    wanted: Factors,
    /// The first vertex before which the motion can stop whatever lies behind it; `None` until a push asks for it.
    safe: Option<usize>,
    /// First span that has changed since the last backward pass.
    changed: Option<usize>,
    /// The plan has changed since the motion was last decided.
    stale: bool,
    /// Where the path ends [steps].
    tail: [i32; N],
    /// Start of the newest block, and what its chords allow.
    anchor: [i32; N],
    cone: Option<Cone<N>>,
    /// Length up to which chords of a curve are merged.
    chord: f32,
    /// Standstill before the next block [ms].
    dwell: u32,
    trim: Trim<N>,
    trim_share: f32,
    trim_bound: [i32; N],
    /// The last sample said that nothing needs to follow.
    at_rest: bool,
    position: [I32F32; N],
    counters: Counters,
}

impl<const N: usize> Planner<N> {
    /// At rest at `start` [steps]; every step weighs 1 mm, tolerance 0.
    pub fn new(limits: Limits<N>, start: [i32; N]) -> Self {
        Self {
            limits,
            scaled: Scaled::new(&limits, 1.0),
            path: PathSetting::UNIT,
            weight: [1.0; N],
            unit: 1.0,
            ring: Ring::new(),
            trace: Trace::whole(start),
            runner: Runner::new(),
            state: State::Running,
            planned: Factors::ONE,
            wanted: Factors::ONE,
            safe: None,
            changed: None,
            stale: false,
            tail: start,
            anchor: start,
            cone: None,
            chord: f32::INFINITY,
            dwell: 0,
            trim: Trim::new(),
            trim_share: 0.0,
            trim_bound: [0; N],
            at_rest: true,
            position: start.map(I32F32::from_num),
            counters: Counters::default(),
        }
    }

    /// Weights and tolerance of the blocks to come. Weights change only at rest with nothing to do.
    pub fn set_path(&mut self, path: PathSetting<N>) -> Result<(), PathError> {
        if path.weight() != self.path.weight() && !self.is_idle() {
            return Err(PathError::Moving);
        }
        let most = path.weight().iter().fold(0.0f32, |m, w| m.max(*w));
        self.path = path;
        self.unit = 1.0 / most;
        self.weight = path.weight().map(|w| w / most);
        Ok(())
    }

    /// A straight move to `target` [steps], in no less than `duration` [s]; 0: as fast as the joints allow.
    ///
    /// Chords of a smooth path are merged and rounded within the tolerance. A move to where the path ends already is
    /// taken and has no effect.
    pub fn push(&mut self, target: [i32; N], duration: f32) -> Result<(), PushError> {
        match self.state {
            State::Lost => return Err(PushError::Lost),
            State::Stopping => return Err(PushError::Stopping),
            State::Running | State::Held => {}
        }
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(PushError::Duration);
        }
        if target == self.tail {
            return Ok(());
        }
        let start = self.tail.map(|p| i64::from(p) << 32);
        let mut block = self.block(&start, target, duration)?;
        // Before anything changes: what the motion under way was planned for.
        let safe = match self.safe {
            Some(safe) => safe,
            None => self.runner.safe_vertex(&self.plan()),
        };
        self.safe = Some(safe);
        if self.merge(&block, target, safe) {
            self.counters.merged = self.counters.merged.wrapping_add(1);
        } else {
            if self.ring.is_full() {
                return Err(PushError::Full);
            }
            block.dwell = self.dwell;
            block.stop = self.dwell > 0 || self.ring.len() == 0;
            self.dwell = 0;
            self.cone = None;
            self.anchor = self.tail;
            self.append(block, safe);
        }
        self.tail = target;
        self.counters.blocks = self.counters.blocks.wrapping_add(1);
        Ok(())
    }

    /// A standstill of `duration` [s] once the path so far has been run; up to 10^6 s.
    pub fn dwell(&mut self, duration: f32) -> Result<(), PushError> {
        if !(0.0..=1.0e6).contains(&duration) {
            return Err(PushError::Duration);
        }
        self.dwell = self
            .dwell
            .saturating_add(Real::ceil(duration * 1000.0) as u32);
        Ok(())
    }

    /// The next millisecond; `None` when at rest with nothing to do. Not an iterator: more may come after `None`.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Option<Sample<N>> {
        if self.state == State::Lost {
            return None;
        }
        self.replan();
        self.trim.advance();
        if !self.run() && self.at_rest && self.trim.is_settled() {
            return None;
        }
        self.safe = None;
        self.counters.samples = self.counters.samples.wrapping_add(1);
        self.counters.squeezed = self.runner.squeezed;
        let rests = self.runner.is_resting() && self.trim.is_settled();
        // At rest within a path it may go on at once, but need not.
        self.at_rest = rests;
        let path = self.path_position();
        let mut position = self.position;
        for i in 0..N {
            position[i] = I32F32::from_bits(path[i] + self.trim.offset(i));
        }
        self.position = position;
        let dwells = self.state == State::Running
            && match self.ring.get(0) {
                Some(head) => head.dwell > 0 && self.runner.x == 0,
                None => self.dwell > 0,
            };
        Some(Sample {
            position,
            last: rests && !dwells,
        })
    }

    /// Commanded position at the last sample [steps], trim included.
    pub fn position(&self) -> [I32F32; N] {
        self.position
    }

    /// At rest with nothing to do.
    pub fn is_idle(&self) -> bool {
        self.ring.len() == 0 && self.dwell == 0 && self.at_rest && self.trim.is_settled()
    }

    /// Whether the last sample left every joint at rest, on the path or at its end.
    pub fn is_at_rest(&self) -> bool {
        self.runner.is_resting() && self.trim.is_settled()
    }

    /// Blocks waiting, of [`BLOCKS`].
    pub fn len(&self) -> usize {
        self.ring.len()
    }

    /// Blocks that could be pushed now.
    pub fn room(&self) -> usize {
        BLOCKS - self.ring.len()
    }

    /// Whether a push may find no room.
    pub fn is_full(&self) -> bool {
        self.ring.is_full()
    }

    /// Whether the path itself moves, trims left aside.
    pub fn is_on_its_way(&self) -> bool {
        !self.runner.is_resting()
    }

    /// Where the path ends [steps], trim not included.
    pub fn end(&self) -> [i32; N] {
        self.tail
    }

    /// No block waits.
    pub fn is_empty(&self) -> bool {
        self.ring.len() == 0
    }

    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    pub fn limits(&self) -> &Limits<N> {
        &self.limits
    }

    /// New limits, for blocks pushed from now on.
    pub fn set_limits(&mut self, limits: Limits<N>) {
        self.limits = limits;
        self.scaled = Scaled::new(&self.limits, 1.0 - self.trim_share);
    }

    /// Feed hold: slows down along the path at once and rests on it; [`Planner::resume`] goes on.
    pub fn hold(&mut self) {
        if self.state == State::Running {
            self.state = State::Held;
            self.halt();
        }
    }

    /// Ends a feed hold.
    pub fn resume(&mut self) {
        if self.state == State::Held {
            self.state = State::Running;
            if self.runner.is_resting() {
                self.at_rest &= self.ring.len() == 0;
            } else {
                self.look_again();
            }
        }
    }

    pub fn is_held(&self) -> bool {
        self.state == State::Held
    }

    /// Controlled stop: slows down along the path, drops what is left of it, and rests on whole steps near by. The position
    /// stays known. Ends a jog, a probe move, and a program on reset.
    pub fn stop(&mut self) {
        if self.state == State::Lost {
            return;
        }
        self.dwell = 0;
        self.state = State::Stopping;
        self.halt();
    }

    /// Whether a controlled stop is under way.
    pub fn is_stopping(&self) -> bool {
        self.state == State::Stopping
    }

    /// Immediate stop: drops everything now; the position is lost until [`Planner::reset`].
    pub fn abort(&mut self) {
        self.state = State::Lost;
        self.drop_path();
    }

    /// Whether the position is lost.
    pub fn is_lost(&self) -> bool {
        self.state == State::Lost
    }

    /// Rests at `position` [steps] from now on, with an empty path: after homing, after a probe contact or an emergency stop
    /// whose latched position the stepper's books tell. Trim counts as part of the position.
    pub fn reset(&mut self, position: [i32; N]) {
        self.drop_path();
        self.trim = Trim::new();
        self.allow_trim(self.trim_share, self.trim_bound);
        self.trace = Trace::whole(position);
        self.tail = position;
        self.position = position.map(I32F32::from_num);
        self.state = State::Running;
    }

    /// Feed override, 0.1 ..= 2.
    pub fn set_feed_override(&mut self, factor: f32) -> Result<(), SettingError> {
        if !(0.1..=2.0).contains(&factor) {
            return Err(SettingError::Range);
        }
        self.wanted.feed = factor;
        self.override_changed();
        Ok(())
    }

    /// Rapid override, 0.05 ..= 1: a share of the speed that the joints allow.
    pub fn set_rapid_override(&mut self, factor: f32) -> Result<(), SettingError> {
        if !(0.05..=1.0).contains(&factor) {
            return Err(SettingError::Range);
        }
        self.wanted.rapid = factor;
        self.override_changed();
        Ok(())
    }

    /// Lets trims of up to `bound` steps of each joint (at most [`MOST_TRIM`]) use `share` (0 ..= 0.5) of its limits; paths
    /// get the rest. Only at rest; present trims stay.
    pub fn set_trim_limits(&mut self, bound: [i32; N], share: f32) -> Result<(), SettingError> {
        if !self.is_idle() {
            return Err(SettingError::Moving);
        }
        let bounded = bound.iter().all(|b| (0..=MOST_TRIM).contains(b));
        if !bounded || !(0.0..=0.5).contains(&share) {
            return Err(SettingError::Range);
        }
        self.trim_share = share;
        self.scaled = Scaled::new(&self.limits, 1.0 - share);
        self.allow_trim(share, bound);
        Ok(())
    }

    /// Offset of one joint [steps], reached at its own rate while the path runs; held to the bound. Returns what was taken.
    pub fn set_trim(&mut self, joint: usize, steps: i32) -> i32 {
        if self.trim_share <= 0.0 {
            return 0;
        }
        self.trim.set(joint, steps)
    }

    /// Offset that a joint has, or is on its way to [steps].
    pub fn trim(&self, joint: usize) -> i32 {
        self.trim.target(joint)
    }

    /// Fastest change of a joint's offset [steps/s]; 0 without a share of its limits.
    pub fn trim_rate(&self, joint: usize) -> f32 {
        self.trim.rate(joint)
    }

    /// Offsets on their way end at the next whole step.
    pub fn freeze_trims(&mut self) {
        self.trim.freeze();
    }

    fn allow_trim(&mut self, share: f32, bound: [i32; N]) {
        self.trim_bound = bound;
        let v = self.limits.velocity().map(|v| v * share * 1.0e-3);
        let a = self.limits.acceleration().map(|a| a * share * 1.0e-6);
        let j = self.limits.jerk().map(|j| j * share * 1.0e-9);
        self.trim.allow(&bound, &v, &a, &j);
    }

    fn plan(&self) -> Plan<'_, N> {
        plan(&self.ring, &self.planned, &self.wanted)
    }

    fn wish(&self) -> Wish {
        match self.state {
            State::Running => Wish::Go,
            _ => Wish::Halt,
        }
    }

    fn drop_path(&mut self) {
        self.ring.clear();
        self.runner.rest_at(0);
        self.cone = None;
        self.dwell = 0;
        self.changed = None;
        self.safe = None;
        self.at_rest = true;
    }

    /// Direction and length of a block from `start` [2^-32 step].
    fn block(
        &self,
        start: &[i64; N],
        target: [i32; N],
        duration: f32,
    ) -> Result<Block<N>, PushError> {
        let mut way = [0.0f32; N];
        let mut sum = 0.0f32;
        for i in 0..N {
            let bits = (i64::from(target[i]) << 32)
                .checked_sub(start[i])
                .ok_or(PushError::TooLong)?;
            if bits.unsigned_abs() >> 32 > i32::MAX as u64 {
                return Err(PushError::TooLong);
            }
            way[i] = profile::length_of(bits);
            let weighted = way[i] * self.weight[i];
            sum += weighted * weighted;
        }
        let length = Real::sqrt(sum);
        // 2^31, with room for the rounding of a path that ends a little behind it.
        if length >= 2.147e9 {
            return Err(PushError::TooLong);
        }
        let inverse = 1.0 / length;
        let milliseconds = duration * 1000.0;
        let rapid = milliseconds <= 0.0;
        Ok(Block {
            end: target,
            u: way.map(|w| w * inverse),
            length,
            bits: profile::length_bits(length).max(1),
            duration: milliseconds,
            nominal: if rapid {
                f32::INFINITY
            } else {
                (length / milliseconds).max(SLOWEST)
            },
            rapid,
            asked: self.path.tolerance() * self.unit,
            tolerance: self.path.tolerance() * self.unit,
            ..Block::EMPTY
        })
    }

    /// Whether the newest block takes in the move to `target`; before vertex `safe` the motion can stop.
    fn merge(&mut self, chord: &Block<N>, target: [i32; N], safe: usize) -> bool {
        let n = self.ring.len();
        // Targets are whole steps: half a step of the finest joint, at most, is their own doing.
        let tolerance = self.path.tolerance() * self.unit;
        let finest = self.weight.iter().fold(1.0f32, |m, w| m.min(*w));
        let tolerance = tolerance * MERGE_SHARE + 0.5 * finest.min(tolerance);
        // Once motion has begun, what it has been planned for stays.
        let begun = !self.runner.is_resting() || self.runner.x > 0;
        if n == 0 || begun && (n < 3 || n - 2 < safe) || self.dwell > 0 || tolerance <= 0.0 {
            return false;
        }
        let Some(old) = self.ring.get(n - 1) else {
            return false;
        };
        let same = old.rapid == chord.rapid
            && old.asked == chord.asked
            && (chord.rapid
                || (old.nominal < SAME_SPEED * chord.nominal
                    && chord.nominal < SAME_SPEED * old.nominal));
        if !same {
            return false;
        }
        // Chords of like length have the smoothest curve through them: each as long as the one before, and a little more,
        // with some room below the length at which the tolerance would cut them.
        let before = n.checked_sub(2).and_then(|b| self.ring.get(b));
        let curve = !old.stop && before.is_some_and(|b| junction::is_gentle(&self.weight, b, old));
        if curve && old.length + 0.5 * chord.length > self.chord {
            self.chord *= GROWTH;
            return false;
        }
        let smooth = junction::is_gentle(&self.weight, old, chord);
        let weighted = |from: &[i32; N]| {
            let mut p = [0.0f32; N];
            for i in 0..N {
                p[i] = (i64::from(target[i]) - i64::from(from[i])) as f32 * self.weight[i];
            }
            p
        };
        let last = weighted(&self.tail);
        let whole = weighted(&self.anchor);
        let first = self.cone.unwrap_or_else(|| {
            let mut p = [0.0f32; N];
            for i in 0..N {
                p[i] = old.u[i] * old.length * self.weight[i];
            }
            Cone::new(&p, tolerance)
        });
        let Some(cone) = first.extended(&whole, &last, tolerance) else {
            self.chord = if smooth {
                ROOM * old.length
            } else {
                f32::INFINITY
            };
            return false;
        };
        let start = self.anchor.map(|p| i64::from(p) << 32);
        let duration = (old.duration + chord.duration) * 1.0e-3;
        let Ok(mut block) = self.block(&start, target, duration) else {
            return false;
        };
        block.tolerance = block.asked * (1.0 - MERGE_SHARE);
        block.stop = old.stop;
        block.dwell = old.dwell;
        self.cone = Some(cone);
        if let Some(old) = self.ring.get_mut(n - 1) {
            *old = block;
        }
        if n == 1 {
            self.enter();
        }
        self.shape(n - 1);
        true
    }

    /// Adds a block behind the newest one; before vertex `safe` the motion can stop.
    fn append(&mut self, block: Block<N>, safe: usize) {
        self.ring.push(block);
        let k = self.ring.len() - 1;
        if k == 0 {
            self.enter();
        }
        self.shape(k);
        if k > 0 && k - 1 < safe {
            self.admit(k);
        }
    }

    /// Decides vertex `k` and the limits that depend on it: those of the zones `k - 1` and `k` and of the bodies on both
    /// sides of it.
    fn shape(&mut self, k: usize) {
        let changed = (2 * k).saturating_sub(2);
        self.changed = Some(self.changed.map_or(changed, |c| c.min(changed)));
        let Some(mut block) = self.ring.get(k).copied() else {
            return;
        };
        let (scaled, weight) = (&self.scaled, &self.weight);
        let before = k.checked_sub(1).and_then(|b| self.ring.get(b).copied());
        let Some(mut before) = before else {
            block.d = 0.0;
            block.z = 0.0;
            block.zone = block::Span {
                v: 0.0,
                through: false,
                ..block::Span::NONE
            };
            let limit = block::body(scaled, None, &block, None);
            block.body.limit(block.length, limit, true);
            if let Some(b) = self.ring.get_mut(k) {
                *b = block;
            }
            return;
        };
        // Direction and zone before the block before: in the ring, or behind us.
        let further = match k.checked_sub(2) {
            Some(f) => self.ring.get(f).map(|b| b.u),
            None => self.trace.before,
        };
        let room = if k == 1 {
            before.length * (1.0 - 1.0e-6) - profile::length_of(self.runner.x)
        } else {
            before.length
        };
        let further = further.as_ref();
        junction::decide(scaled, weight, further, &before, &mut block, room.max(0.0));
        junction::set_zone(scaled, weight, further, &before, &mut block, None);
        // The hat of this vertex may reach into the zone before, whose far side is unknown only at the head.
        if k >= 2 && before.z > 0.0 {
            let beyond = match k.checked_sub(3) {
                Some(f) => self.ring.get(f).map(|b| b.u),
                None => self.trace.before,
            };
            if let Some(first) = self.ring.get(k - 2).copied() {
                let after = Some(&block);
                junction::set_zone(scaled, weight, beyond.as_ref(), &first, &mut before, after);
            }
        }
        let limit = block::body(scaled, further, &before, Some(&block));
        before
            .body
            .limit((before.length - before.z - block.z).max(0.0), limit, true);
        let limit = block::body(scaled, Some(&before.u), &block, None);
        block
            .body
            .limit((block.length - block.z).max(0.0), limit, true);
        if let Some(b) = self.ring.get_mut(k - 1) {
            *b = before;
        }
        if let Some(b) = self.ring.get_mut(k) {
            *b = block;
        }
    }

    /// Vertex `k` lies so near that the motion under way may not fit its rounding. A ramp down to the former end is cut
    /// short where the new plan allows it; where nothing fits, the vertex stays the stop that it was.
    fn admit(&mut self, k: usize) {
        self.backward();
        let plan = self.plan();
        if self.state == State::Running
            && self.runner.descent_end().is_some()
            && let Some((eased, x, v)) = self.runner.eased()
            && plan.is_feasible(x, v)
            && self.runner.fits(&plan, Some(&eased))
        {
            self.runner.ease();
            self.counters.eased = self.counters.eased.wrapping_add(1);
            self.safe = None;
            return;
        }
        if self.runner.fits(&plan, None) {
            return;
        }
        if let Some(block) = self.ring.get_mut(k) {
            block.stop = true;
        }
        self.shape(k);
    }

    fn backward(&mut self) {
        if let Some(changed) = self.changed.take() {
            self.stale = true;
            look_ahead::plan(&mut self.ring, &self.planned, changed);
        }
    }

    /// Brings plan and motion up to date with what was pushed and asked for since the last sample.
    fn replan(&mut self) {
        if self.planned == self.wanted && self.runner.rises_on() {
            // Nothing is decided on the way up: what arrives meanwhile is planned in one pass at its end.
            return;
        }
        self.backward();
        if self.stale {
            self.look_again();
        }
        if self.planned != self.wanted {
            self.adopt_override();
        }
    }

    /// A cruise is decided anew; a ramp down that the plan no longer asks for is cut short.
    fn look_again(&mut self) {
        self.stale = false;
        let wish = self.wish();
        if let run::Mode::Cruise { .. } = self.runner.mode {
            let plan = plan(&self.ring, &self.planned, &self.wanted);
            self.runner.decide(&plan, wish);
        } else if wish == Wish::Go
            && self.runner.descent_end().is_some()
            && let Some((_, x, v)) = self.runner.eased()
            && x < self.runner.ramp_end()
            && self.plan().is_feasible(x, v)
        {
            self.runner.ease();
            self.counters.eased = self.counters.eased.wrapping_add(1);
        }
        self.safe = None;
    }

    fn halt(&mut self) {
        self.backward();
        self.stop_rising();
        if let run::Mode::Cruise { .. } = self.runner.mode {
            self.look_again();
        }
    }

    /// Lets a ramp up go, unless what follows asks for its full length.
    fn stop_rising(&mut self) {
        if let Some((_, x, v)) = self.runner.eased()
            && self.runner.descent_end().is_none()
            && self.plan().is_feasible(x, v)
        {
            self.runner.ease();
        }
    }

    fn override_changed(&mut self) {
        self.backward();
        self.adopt_override();
    }

    /// Plans with the wanted overrides as soon as the present speed leaves room for them; slows down meanwhile.
    fn adopt_override(&mut self) {
        let old = self.planned;
        let raised = old.not_above(&self.wanted);
        if !raised {
            self.stop_rising();
            if matches!(self.runner.mode, run::Mode::Ramp(_)) {
                return;
            }
        }
        self.planned = self.wanted;
        look_ahead::plan(&mut self.ring, &self.planned, usize::MAX);
        let (x, v) = (self.runner.x, self.runner.speed());
        if !raised && !self.runner.is_resting() && !self.plan().is_feasible(x, v) {
            self.planned = old;
            look_ahead::plan(&mut self.ring, &self.planned, usize::MAX);
        }
        self.look_again();
    }

    /// The oldest block becomes the one under way.
    fn enter(&mut self) {
        if let Some(head) = self.ring.get(0) {
            self.trace.enter(head);
        }
    }

    /// Runs on for a millisecond; whether anything happened.
    fn run(&mut self) -> bool {
        let mut time = TICK;
        let mut happened = false;
        // Every vertex may end its block within the millisecond.
        for _ in 0..=BLOCKS {
            let wish = self.wish();
            if self.runner.is_resting() && wish == Wish::Go {
                if self.ring.len() == 0 {
                    if self.dwell > 0 {
                        self.dwell -= 1;
                        return true;
                    }
                    return happened;
                }
                if let Some(head) = self.ring.get_mut(0)
                    && head.dwell > 0
                    && self.runner.x == 0
                {
                    head.dwell -= 1;
                    return true;
                }
            }
            if self.runner.is_resting() && self.state == State::Stopping {
                return self.settle() || happened;
            }
            if self.runner.is_resting() && wish == Wish::Halt {
                return happened;
            }
            happened = true;
            let plan = plan(&self.ring, &self.planned, &self.wanted);
            let (left, passed) = self.runner.advance(&plan, wish, time);
            time = left;
            if let Passed::Vertex = passed {
                self.leave();
            }
            if time == 0 {
                break;
            }
        }
        true
    }

    fn leave(&mut self) {
        let Some(head) = self.ring.get(0) else {
            return;
        };
        self.trace.leave(head);
        self.runner.leave(head.bits);
        self.ring.pop();
        self.changed = self.changed.map(|c| c.saturating_sub(2));
        if self.ring.len() == 0 {
            self.runner.rest_at(0);
            self.trace.before = None;
            self.cone = None;
            self.counters.rests = self.counters.rests.wrapping_add(1);
        } else {
            if self.ring.get(0).is_some_and(|b| b.d <= 0.0) {
                self.trace.before = None;
            }
            self.enter();
        }
    }

    /// At rest after a controlled stop: drops the path; a last short block leads to whole steps. Whether there is one.
    fn settle(&mut self) -> bool {
        let here = self.path_position();
        self.drop_path();
        self.at_rest = false;
        self.trace = Trace::at(here);
        // To the nearest step.
        let target = here.map(|p| ((p + (1 << 31)) >> 32) as i32);
        self.tail = target;
        self.anchor = target;
        self.state = State::Running;
        let exact = here
            .iter()
            .zip(&target)
            .all(|(p, t)| *p == i64::from(*t) << 32);
        if exact {
            return true;
        }
        match self.block(&here, target, 0.0) {
            Ok(mut block) => {
                block.stop = true;
                self.append(block, 0);
            }
            Err(_) => self.trace = Trace::whole(target),
        }
        true
    }

    fn path_position(&self) -> [i64; N] {
        match self.ring.get(0) {
            Some(head) => self.trace.position(self.runner.x, head, self.ring.get(1)),
            None => *self.trace.base(),
        }
    }
}

fn plan<'a, const N: usize>(
    ring: &'a Ring<N>,
    planned: &'a Factors,
    wanted: &'a Factors,
) -> Plan<'a, N> {
    Plan {
        ring,
        planned,
        wanted,
    }
}
