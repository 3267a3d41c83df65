//! Joint targets -> [`Sample`]: commanded positions, one a millisecond, within every joint's limits.
//!
//! ```text
//!  push(target, least time)                                    steps with a 32-bit fraction, s
//!     |  resample    chords that one line replaces within 0.42 of the tolerance become one block, of even length
//!     |  block       direction and length of the block; what every joint allows along it
//!     |  junction    the vertex before it: rounded through whole blocks, in a narrow zone, a corner, or a stop
//!     |  corner      a sharp vertex: passed at a speed of its own, rounded in time, swung out within the tolerance
//!     v  look_ahead  backward: highest speed at which each span may be entered
//!  ---- ring of 64 blocks ----
//!     |  run         cruise, ramp up, ramp down; hold, override, stop
//!     |  profile     s(t) on integers, jerk-limited, every ramp's distance exact before it starts
//!     |  trace       s -> joints: polygon and rounding, exact at every vertex that rests
//!     v  trim        offset of each joint, within its share of the limits
//!  next() -> Sample                                            steps with a 32-bit fraction
//!
//!  speed                 ramp up        cruise       ramp down, planned from its root backward
//!    |                  _-----_______________________-_
//!    |                _/                               \_        /----   corner: no acceleration at the vertex itself,
//!    |              _/                                   \_    _/        ramps right up to it and away from it
//!    |             /                                       \__/
//!    +------------+---|----|----|----|----|----|----|----|---+---> s
//!                       blocks of a smooth curve, crossed as one
//! ```
//!
//! A curve is rounded in path length, so its path does not depend on speed, hold or override. A sharp corner is rounded in
//! time: the motion is committed for its window (some 2 x 15 ms at 20 000 mm/s3), and passed more slowly it deviates less.
//! Instead of the moving average over s(t) that motion.md recommends, ramps are jerk-limited from the start, each with the
//! acceleration and jerk that the joints and blocks it crosses leave at its own highest speed (`Slack` in `ramp.rs`): a mean
//! over one time T for all is optimal only where T = a/j of the block at hand.
//!
//! What is left to gain: a jerk-limited optimum within the tolerance (by linear programming, offline) takes 10 to 15 % less on
//! zigzags and random short moves, for it lets the joints use the tolerance along whole legs.
//!
//! Cost on a Cortex-M4F: `planner_instructions_per_block` of `cargo xtask bench`; a third of it is the backward pass.
//!
//! Runs in the foreground. The path planned always ends in a standstill: input may pause at any time.

mod block;
mod corner;
mod junction;
mod limits;
mod look_ahead;
mod profile;
mod ramp;
mod resample;
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
use block::{Block, Last};
use corner::Corner;
use fixed::types::I32F32;
use limits::Scaled;
use look_ahead::{Factors, lesser};
use profile::TICK;
use resample::{Cone, End, Spacing};
use ring::Ring;
use run::{Passed, Plan, Runner, Wish};
use trace::Trace;
use trim::Trim;

/// Speeds of two chords that may become one line: within this ratio.
const SAME_SPEED: f32 = 1.25;
/// So many samples without a push, and the path may end where it does.
const QUIET: u8 = 24;
/// What whole steps may take off the length of a chord, or add to it.
const ROUNDING: f32 = 2.5;
/// Moves below this length are none: the next one, or the rest on whole steps at the end, makes up for them.
const TINY: f32 = 1.0e-3;
/// Chords that many tolerances long are not joined by others but on a straight line.
const SHORT: f32 = 30.0;
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

/// How a move joins the newest block. It lives for the length of one push.
#[allow(clippy::large_enum_variant)]
enum Join<const N: usize> {
    /// One line takes the place of both.
    Whole {
        cone: Cone<N>,
        line: Block<N>,
    },
    /// The line takes the move up to `at`; the rest begins the next one.
    Part {
        line: Block<N>,
        cone: Cone<N>,
        rest: Block<N>,
        at: [i64; N],
    },
    Apart,
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
    /// Where the path ends [2^-32 step].
    tail: [i64; N],
    /// Start of the newest block [2^-32 step], and what its chords allow.
    anchor: [i64; N],
    cone: Option<Cone<N>>,
    /// Start of the block before the newest, and what its chords allow, where it ends within a chord.
    behind: Option<([i64; N], Cone<N>)>,
    spacing: Spacing,
    /// Speed of the newest line when it was long enough to have one [length/ms]; 0 before.
    pace: f32,
    /// Samples since the last push with room for another.
    quiet: u8,

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
            tail: bits(&start),
            anchor: bits(&start),
            cone: None,
            behind: None,
            spacing: Spacing::NONE,
            pace: 0.0,
            quiet: 0,
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
    /// Chords of a smooth path are replaced by longer ones and rounded within the tolerance. A move to where the path ends
    /// already is taken and has no effect. Targets may lie between steps; a path that ends there comes to rest on the
    /// nearest whole steps.
    pub fn push(&mut self, target: [I32F32; N], duration: f32) -> Result<(), PushError> {
        match self.state {
            State::Lost => return Err(PushError::Lost),
            State::Stopping => return Err(PushError::Stopping),
            State::Running | State::Held => {}
        }
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(PushError::Duration);
        }
        let target = target.map(I32F32::to_bits);
        if target == self.tail {
            return Ok(());
        }
        let mut chord = self.block(&self.tail, &target, duration)?;
        if chord.length < TINY {
            return Ok(());
        }
        // Before anything changes: what the motion under way was planned for.
        let safe = match self.safe {
            Some(safe) => safe,
            None => self.runner.safe_vertex(&self.plan()),
        };
        self.safe = Some(safe);
        self.quiet = 0;
        let mut spacing = self.spacing;
        let full = self.ring.is_full();
        match self.join(&chord, &target, &mut spacing) {
            Join::Whole { cone, line } if self.takes(&line, safe) => {
                if self.pace <= 0.0 && line.length > 4.0 * ROUNDING {
                    self.pace = line.nominal;
                }
                self.cone = Some(cone);
                self.counters.merged = self.counters.merged.wrapping_add(1);
            }
            _ if full => return Err(PushError::Full),
            Join::Part {
                line,
                cone,
                rest,
                at,
            } if self.takes(&line, safe) => {
                self.behind = Some((self.anchor, cone));
                self.anchor = at;
                self.begin(rest, safe);
            }
            _ => {
                let turns = self
                    .ring
                    .len()
                    .checked_sub(1)
                    .and_then(|k| self.ring.get(k));
                if self.dwell == 0
                    && turns.is_some_and(|old| !junction::is_gentle(&self.weight, old, &chord))
                {
                    self.even_out(safe);
                    chord = self.swing_out(chord, &target, safe);
                }
                self.behind = None;
                self.anchor = self.tail;
                self.begin(chord, safe);
            }
        }
        self.spacing = spacing;
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
        // A full look-ahead says nothing of what comes.
        self.quiet = match self.ring.is_full() {
            true => 0,
            false => self.quiet.saturating_add(1),
        };
        let begins = self.quiet == 1 && self.runner.is_resting();
        if (self.quiet == QUIET || begins) && self.dwell == 0 {
            // The path may end here: its last lines are made for it.
            if !begins {
                let safe = self.runner.safe_vertex(&self.plan());
                self.even_out(safe);
            }
            self.complete();
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
    pub fn end(&self) -> [I32F32; N] {
        self.tail.map(I32F32::from_bits)
    }

    /// The whole steps nearest to where the path ends.
    pub fn end_steps(&self) -> [i32; N] {
        nearest_steps(&self.tail).map(|p| (p >> 32) as i32)
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
        self.tail = bits(&position);
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
        self.behind = None;
        self.dwell = 0;
        self.changed = None;
        self.safe = None;
        self.at_rest = true;
    }

    /// Direction and length of a block from `start` [2^-32 step].
    fn block(
        &self,
        start: &[i64; N],
        target: &[i64; N],
        duration: f32,
    ) -> Result<Block<N>, PushError> {
        let mut way = [0.0f32; N];
        let mut sum = 0.0f32;
        for i in 0..N {
            let bits = target[i].checked_sub(start[i]).ok_or(PushError::TooLong)?;
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
            end: *target,
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

    /// What becomes of the newest block and the move `chord` to `target` behind it. `spacing`: the length that lines are to have, as it is to be from now on.
    fn join(&self, chord: &Block<N>, target: &[i64; N], spacing: &mut Spacing) -> Join<N> {
        let n = self.ring.len();
        let tolerance = self.path.tolerance() * self.unit;
        let Some(old) = n.checked_sub(1).and_then(|k| self.ring.get(k)).copied() else {
            return Join::Apart;
        };
        let share = lesser(tolerance * resample::SHARE, tolerance - old.outside);
        if !self.may_change(n - 1) || self.dwell > 0 || share <= 0.0 {
            return Join::Apart;
        }
        if !self.is_alike(&old, chord) {
            *spacing = Spacing::NONE;
            return Join::Apart;
        }
        let weighted = |to: &[i64; N]| {
            let mut p = [0.0f32; N];
            for i in 0..N {
                p[i] = profile::length_of(to[i] - self.anchor[i]) * self.weight[i];
            }
            p
        };
        let first = self
            .cone
            .unwrap_or_else(|| Cone::new(&weighted(&self.tail), share));
        let way = weighted(target);
        let length = Real::sqrt(way.iter().fold(0.0f32, |s, x| s + x * x));
        let line = |to: &[i64; N], of: f32| {
            let duration = (old.duration + chord.duration * of) * 1.0e-3;
            let block = self.block(&self.anchor, to, duration).ok()?;
            Some(Block {
                tolerance: block.asked * (1.0 - resample::SHARE),
                stop: old.stop,
                dwell: old.dwell,
                outside: old.outside,
                ..block
            })
        };
        let end = spacing.end(old.length, length, chord.length);
        let mut joined = Join::Apart;
        match end {
            End::Later => {
                let cone = first.extended(&way, share);
                if let (Some(cone), Some(line)) = (cone, line(target, 1.0)) {
                    return Join::Whole { cone, line };
                }
                if cone.is_none() {
                    spacing.cut(old.length);
                }
            }
            End::Within(part) => {
                let at = core::array::from_fn(|i| {
                    self.tail[i] + scaled_way(target[i] - self.tail[i], part)
                });
                let rest = self
                    .block(&at, target, chord.duration * (1.0 - part) * 1.0e-3)
                    .ok()
                    .filter(|rest| rest.length > 0.0);
                if let (Some(cone), Some(line), Some(rest)) =
                    (first.extended(&weighted(&at), share), line(&at, part), rest)
                {
                    joined = Join::Part {
                        line,
                        cone,
                        rest,
                        at,
                    };
                }
            }
            End::Before => {}
        }
        // The newest line is complete.
        if let Some(before) = n.checked_sub(2).and_then(|k| self.ring.get(k)) {
            let last = match &joined {
                Join::Part { line, .. } => line,
                _ => &old,
            };
            let turn = junction::turn(&self.weight, &before.u, &last.u);
            let enough = self.enough(last, chord.length);
            spacing.follow(turn, before.length, last.length, tolerance, enough);
        }
        joined
    }

    /// Length of lines above which nothing is gained: chords enough in each, time enough to plan it, and the way to a stop
    /// within the look-ahead.
    fn enough(&self, line: &Block<N>, chord: f32) -> f32 {
        let steep = line.body.slack.at(0.0, 0.0);
        let v = lesser(line.nominal, line.body.v);
        let stop = steep.distance(v, 0.0);
        (v * resample::BEAT)
            .max(5.0 * chord)
            .max(stop * (1.0 / 48.0))
    }

    /// Whether a chord belongs to the newest line by its speed and tolerance.
    fn is_alike(&self, old: &Block<N>, chord: &Block<N>) -> bool {
        if old.rapid != chord.rapid || old.asked != chord.asked {
            return false;
        }
        let close = |a: f32, b: f32| a < SAME_SPEED * b && b < SAME_SPEED * a;
        if chord.rapid || close(old.nominal, chord.nominal) {
            return true;
        }
        // Between whole steps the length of a short chord is anything; what they make together is not.
        let whole = (old.length + chord.length) / (old.duration + chord.duration);
        let rounding = Real::abs(chord.length - chord.duration * whole) <= ROUNDING;
        rounding && (self.pace <= 0.0 || close(self.pace, whole))
    }

    /// Whether block `k` is neither run nor next.
    fn may_change(&self, k: usize) -> bool {
        let begun = !self.runner.is_resting() || self.runner.x > 0;
        !begun || k >= 2
    }

    /// Whether block `k` may be changed without a look at the motion under way, which can stop before vertex `safe`.
    fn is_open(&self, k: usize, safe: usize) -> bool {
        let begun = !self.runner.is_resting() || self.runner.x > 0;
        !begun || k >= 2 && k > safe
    }

    /// Lets `line` take the place of the newest block; where the motion under way has been planned up to there, only if it
    /// fits the new plan as well.
    fn takes(&mut self, line: &Block<N>, safe: usize) -> bool {
        let Some(k) = self.ring.len().checked_sub(1) else {
            return false;
        };
        if self.is_open(k, safe) {
            self.replace(*line);
            return true;
        }
        let (Some(old), Some(before)) = (
            self.ring.get(k).copied(),
            k.checked_sub(1).and_then(|b| self.ring.get(b)).copied(),
        ) else {
            return false;
        };
        self.replace(*line);
        if self.fits() {
            return true;
        }
        for (k, block) in [(k - 1, before), (k, old)] {
            if let Some(place) = self.ring.get_mut(k) {
                *place = block;
            }
        }
        self.changed = Some((2 * k).saturating_sub(2));
        self.backward();
        false
    }

    /// Whether the motion under way fits the plan; a ramp down to a former end is cut short where it may.
    fn fits(&mut self) -> bool {
        self.backward();
        let plan = self.plan();
        if self.state == State::Running
            && !self.runner.is_bound()
            && self.runner.descent_end().is_some()
            && let Some((eased, x, v)) = self.runner.eased()
            && plan.is_feasible(x, v)
            && self.runner.fits(&plan, Some(&eased))
        {
            self.runner.ease();
            self.counters.eased = self.counters.eased.wrapping_add(1);
            self.safe = None;
            return true;
        }
        self.runner.fits(&plan, None)
    }

    /// Before a corner, the line that leads up to it and the one before become alike, or one: a short rest of a curve
    /// would be rounded sharply.
    fn even_out(&mut self, safe: usize) {
        let n = self.ring.len();
        let (Some(last), Some(before)) = (
            n.checked_sub(1).and_then(|k| self.ring.get(k)).copied(),
            n.checked_sub(2).and_then(|k| self.ring.get(k)).copied(),
        ) else {
            return;
        };
        let alike = last.length > 0.75 * before.length;
        if alike || !self.is_open(n - 2, safe) || last.stop || last.d <= 0.0 {
            return;
        }
        let Some((anchor, cone)) = self.behind else {
            return;
        };
        let tolerance = self.path.tolerance() * self.unit;
        let mut way = [0.0f32; N];
        for i in 0..N {
            way[i] = profile::length_of(self.tail[i] - anchor[i]) * self.weight[i];
        }
        let share = lesser(tolerance * resample::SHARE, tolerance - before.outside);
        let duration = (before.duration + last.duration) * 1.0e-3;
        if cone.extended(&way, share).is_some()
            && let Ok(line) = self.block(&anchor, &self.tail, duration)
        {
            self.ring.drop_last();
            self.anchor = anchor;
            self.replace(Block {
                tolerance: before.tolerance,
                stop: before.stop,
                dwell: before.dwell,
                outside: before.outside,
                ..line
            });
            return;
        }
        // The border moves back along the line before it, which brings the old border beside the new line.
        let back = 0.5 * (before.length - last.length);
        let turn = junction::turn(&self.weight, &before.u, &last.u);
        let beside = turn * back * last.length / (back + last.length);
        if beside > 0.2 * last.tolerance {
            return;
        }
        let part = back / before.length;
        let at =
            core::array::from_fn(|i| before.end[i] - scaled_way(before.end[i] - anchor[i], part));
        let first = self.block(&anchor, &at, before.duration * (1.0 - part) * 1.0e-3);
        let second = self.block(
            &at,
            &self.tail,
            (last.duration + before.duration * part) * 1.0e-3,
        );
        let (Ok(first), Ok(second)) = (first, second) else {
            return;
        };
        if let Some(block) = self.ring.get_mut(n - 2) {
            *block = Block {
                tolerance: before.tolerance,
                stop: before.stop,
                dwell: before.dwell,
                outside: before.outside,
                ..first
            };
        }
        if n == 2 {
            self.enter();
        }
        self.anchor = at;
        self.shape(n - 2);
        self.replace(Block {
            tolerance: last.tolerance - beside,
            ..second
        });
    }

    /// What the newest block leaves to ramps, in full: nothing may follow it.
    fn complete(&mut self) {
        let Some(k) = self.ring.len().checked_sub(1) else {
            return;
        };
        let before = match k.checked_sub(1) {
            Some(before) => self.ring.get(before).map(|b| b.u),
            None => self.trace.before,
        };
        let Some(mut block) = self.ring.get(k).copied() else {
            return;
        };
        let limit = block::body(&self.scaled, before.as_ref(), &block, None, Last::Complete);
        block
            .body
            .limit((block.length - block.z).max(0.0), limit, true);
        if let Some(place) = self.ring.get_mut(k) {
            *place = block;
        }
        let changed = 2 * k + 1;
        self.changed = Some(self.changed.map_or(changed, |c| c.min(changed)));
    }

    /// Moves the corner at the end of the path outward, by half of what its rounding will stay inside: the path then passes
    /// near the programmed vertex, and uses the tolerance on both sides. Returns the chord from there.
    fn swing_out(&mut self, chord: Block<N>, target: &[i64; N], safe: usize) -> Block<N> {
        let n = self.ring.len();
        let Some(old) = n.checked_sub(1).and_then(|k| self.ring.get(k)).copied() else {
            return chord;
        };
        if old.rapid || chord.rapid || !self.is_open(n - 1, safe) {
            return chord;
        }
        let inside = lesser(old.tolerance, chord.tolerance);
        // A chord that others may join brings their deviation.
        let most = if chord.length < SHORT * inside {
            lesser(inside, chord.tolerance * (1.0 - resample::SHARE))
        } else {
            inside
        };
        let further = n.checked_sub(2).and_then(|k| self.ring.get(k)).map(|b| b.u);
        let turn = junction::turn(&self.weight, &old.u, &chord.u);
        if turn > junction::REVERSAL {
            return chord;
        }
        let (corner, _) = corner::passage(
            &self.scaled,
            further.as_ref(),
            &old,
            &chord,
            turn,
            inside + most,
            old.length,
        );
        let outside = lesser(most, corner.deviation(turn) * 0.5);
        if outside <= 0.0 {
            return chord;
        }
        let way = outside / turn;
        let at: [i64; N] = core::array::from_fn(|i| {
            self.tail[i] - profile::length_bits((chord.u[i] - old.u[i]) * way)
        });
        let line = self.block(&self.anchor, &at, old.duration * 1.0e-3);
        let moved = self.block(&at, target, chord.duration * 1.0e-3);
        let (Ok(line), Ok(moved)) = (line, moved) else {
            return chord;
        };
        self.tail = at;
        self.replace(Block {
            tolerance: old.tolerance,
            stop: old.stop,
            dwell: old.dwell,
            outside: old.outside,
            ..line
        });
        Block { outside, ..moved }
    }

    /// `line` takes the place of the newest block.
    fn replace(&mut self, line: Block<N>) {
        let Some(k) = self.ring.len().checked_sub(1) else {
            return;
        };
        if let Some(old) = self.ring.get_mut(k) {
            *old = line;
        }
        if k == 0 {
            self.enter();
        }
        self.shape(k);
    }

    /// A new block at the end of the path.
    fn begin(&mut self, mut block: Block<N>, safe: usize) {
        block.dwell = self.dwell;
        block.stop = self.dwell > 0 || self.ring.len() == 0;
        self.dwell = 0;
        self.cone = None;
        self.pace = 0.0;
        self.append(block, safe);
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
            block.corner = Corner::STOP;
            block.zone = block::Span {
                v: 0.0,
                through: false,
                ..block::Span::NONE
            };
            let limit = block::body(scaled, None, &block, None, Last::Provisional);
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
        junction::set_zone(scaled, further, &before, &mut block, None);
        // The hat of this vertex may reach into the zone before, whose far side is unknown only at the head.
        if k >= 2 && before.z > 0.0 {
            let beyond = match k.checked_sub(3) {
                Some(f) => self.ring.get(f).map(|b| b.u),
                None => self.trace.before,
            };
            if let Some(first) = self.ring.get(k - 2).copied() {
                let after = Some(&block);
                junction::set_zone(scaled, beyond.as_ref(), &first, &mut before, after);
            }
        }
        let limit = block::body(scaled, further, &before, Some(&block), Last::Provisional);
        before
            .body
            .limit((before.length - before.z - block.z).max(0.0), limit, true);
        let limit = block::body(scaled, Some(&before.u), &block, None, Last::Provisional);
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
        if self.fits() {
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
        let goes_on = self.state == State::Running && self.planned == self.wanted;
        if goes_on && self.runner.rises_on() {
            // Nothing is decided on the way up: what arrives meanwhile is planned in one pass at its end.
            return;
        }
        self.backward();
        if self.stale {
            if self.state != State::Running {
                self.stop_rising();
            }
            self.look_again();
        }
        if self.planned != self.wanted {
            self.adopt_override();
        }
    }

    /// A cruise is decided anew; a ramp down that the plan no longer asks for is cut short.
    fn look_again(&mut self) {
        // In the window of a corner nothing is decided anew; after it, all that came meanwhile.
        self.stale = self.runner.is_bound();
        if self.stale {
            return;
        }
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
        self.stale |= self.runner.is_bound();
        self.stop_rising();
        if let run::Mode::Cruise { .. } = self.runner.mode {
            self.look_again();
        }
    }

    /// Lets a ramp up go, unless what follows asks for its full length.
    fn stop_rising(&mut self) {
        if !self.runner.is_bound()
            && let Some((_, x, v)) = self.runner.eased()
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
        if self.runner.is_bound() {
            return;
        }
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
                // A ramp may have crossed several short blocks.
                while self.ring.len() > 1
                    && self.ring.get(0).is_some_and(|b| self.runner.x >= b.bits)
                {
                    self.leave();
                }
            }
            if time == 0 {
                break;
            }
        }
        let plan = plan(&self.ring, &self.planned, &self.wanted);
        self.runner.foresee(&plan);
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
            self.behind = None;
            self.counters.rests = self.counters.rests.wrapping_add(1);
            let here = self.tail;
            self.tail = nearest_steps(&here);
            self.anchor = self.tail;
            self.go_to_steps(&here);
        } else {
            if self.ring.get(0).is_some_and(|b| b.d <= 0.0) && !self.runner.is_bound() {
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
        let target = nearest_steps(&here);
        self.tail = target;
        self.anchor = target;
        self.state = State::Running;
        self.go_to_steps(&here);
        true
    }

    /// At rest at `here`, with nothing to do: a last short block to the whole steps `tail`, if they are elsewhere.
    fn go_to_steps(&mut self, here: &[i64; N]) {
        if *here == self.tail {
            return;
        }
        match self.block(here, &self.tail, 0.0) {
            Ok(mut block) => {
                block.stop = true;
                self.append(block, 0);
            }
            Err(_) => self.trace = Trace::at(self.tail),
        }
    }

    fn path_position(&self) -> [i64; N] {
        match self.ring.get(0) {
            Some(head) => self.trace.position(
                self.runner.x,
                head,
                self.ring.get(1),
                self.runner.window.as_ref(),
            ),
            None => *self.trace.base(),
        }
    }
}

/// Whole steps as positions [2^-32 step].
fn bits<const N: usize>(steps: &[i32; N]) -> [i64; N] {
    steps.map(|p| i64::from(p) << 32)
}

/// The whole steps nearest to a position [2^-32 step].
fn nearest_steps<const N: usize>(position: &[i64; N]) -> [i64; N] {
    position.map(|p| (p.saturating_add(1 << 31) >> 32) << 32)
}

/// A share, 0 ..= 1, of a way.
fn scaled_way(way: i64, share: f32) -> i64 {
    // Half a part in 2^24 of it, at most, is rounding.
    ((i128::from(way) * i128::from((share * 16_777_216.0) as i64)) >> 24) as i64
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
