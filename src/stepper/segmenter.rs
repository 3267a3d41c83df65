//! Commanded position of each motor at the end of a sample -> [`Segment`], and the books that make it exact.
//!
//! The books ([`Stance`]) hold what the interrupt's accumulators hold, by arithmetic: a count of steps put out and a
//! 32-bit fraction. Every increment is the way from *commanded, as actually representable* to *wanted*, so nothing
//! accumulates: what a segment leaves undone, in way and in time, goes into the next one.
//!
//! ```text
//!  leader:   d_L steps in tau counts, k ticks a step:   X = k d_L ticks,   ticks = round(X),   period = tau / X
//!  others:   inc_i = 2^32 d_i / X,  never above the leader's 2^32 / k
//! ```
//!
//! The leader's ratio `1/k` is exact, so its pulses are even. While speed changes, X is rounded down to whole ticks: every
//! segment ends at the sample's instant, the others where they should be, the leader less than a tick behind. At constant
//! speed the period is `tau / X` with X unrounded: the tick does not depend on the rounding, pulses are even across borders
//! too, and the segment ends up to half a tick beside its instant, on the same straight line. What is left undone, in
//! way and in time, goes into the next sample.
//!
//! `k` is the least power of two that keeps the tick rate at its floor; when a step would take more than 128 ticks, the
//! segment ticks at the floor and all ratios are plain `d / ticks`. (interpolation.md section 3.)
#![deny(clippy::float_arithmetic)]

use super::interpolator::Instant;
use super::{AT_REST, Channel, Kind, Mask, Segment, SegmentSender, Timing};
use fixed::types::I32F32;

/// Segments that one [`Segmenter::advance`] may need: a stretch before a reversal, and two periods.
pub const SEGMENTS_PER_SAMPLE: usize = 3;

/// Instants that can be looked up: all segments in the queue, the running one, and those just over.
const REMEMBERED: usize = 2 * super::QUEUE;

/// Half a step in units of 2^-32: step boundaries lie at half steps.
const HALF: i64 = 1 << 31;

/// Most ticks from one step of the leader to the next before a segment falls back to plain ratios. At 128 ticks a
/// jitter of one tick stays below one per cent.
const LONGEST_STEP: u32 = 128;

/// Ways below 2^-20 step are left undone (and carried on) rather than turning a motor round for nothing.
const NEGLIGIBLE: i64 = 1 << 12;

/// Most ticks in a segment: leaves room for rounding up within 16 bits.
const MOST_TICKS: u64 = 65_000;

/// Where one motor stands: the interrupt's accumulator, known by arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stance {
    /// Steps put out.
    count: i32,
    accumulator: u32,
    negative: bool,
}

impl Stance {
    const fn at(count: i32) -> Self {
        Self {
            count,
            accumulator: AT_REST,
            negative: false,
        }
    }

    /// Commanded position plus half a step, in units of 2^-32 step.
    fn total(&self) -> i64 {
        let fraction = if self.negative {
            !self.accumulator
        } else {
            self.accumulator
        };
        (i64::from(self.count) << 32) | i64::from(fraction)
    }

    fn position(&self) -> I32F32 {
        I32F32::from_bits(self.total() - HALF)
    }

    /// The motor turns round where it is: the complement of the accumulator says the same position the other way.
    fn turn(&mut self) {
        self.negative = !self.negative;
        self.accumulator = !self.accumulator;
    }

    /// The first `ticks` >= 1 ticks at this increment make no step: a motor that would step earlier loses the way that
    /// it is ahead, and the next sample makes up for it.
    fn hold_back(&mut self, ticks: u32, increment: &mut u32) {
        *increment = (*increment).min(u32::MAX / ticks);
        self.accumulator = self.accumulator.min(u32::MAX - ticks * *increment);
    }

    /// What a segment does to this motor; whether it steps.
    fn run(&mut self, inc: u32, ticks: u16) -> bool {
        // 2^32 + 2^32 * 2^16 stays below 2^64.
        let sum = u64::from(self.accumulator) + u64::from(inc) * u64::from(ticks);
        self.accumulator = sum as u32;
        let steps = (sum >> 32) as i32;
        self.count = self
            .count
            .wrapping_add(if self.negative { -steps } else { steps });
        steps != 0
    }
}

/// How long the pins of one motor have stood when the next segment is loaded [timer counts]: never more than the truth,
/// saturating.
///
/// ```text
///  tick:    load A     |          |          | load B     |          |
///  length:      before     A          A          A            B           the reload acts one tick late
///           turn       first step of A ...     last of A   first of B
/// ```
#[derive(Clone, Copy)]
struct Since {
    /// Since the last step, which comes out one tick after its carry.
    step: u32,
    /// Since the direction changed, counted from one tick behind it up to the first instant at which the next segment
    /// can step: the tick itself is left to the time that the handler takes from step pins to direction pins.
    turn: u32,
}

impl Since {
    const LONG_AGO: Self = Self {
        step: u32::MAX,
        turn: u32::MAX,
    };
    const NOW: Self = Self { step: 0, turn: 0 };

    /// A segment has been sent, and left `motor` behind; `first` is the length of its first tick, that of the segment
    /// before.
    fn pass(&mut self, segment: (u16, u32), first: u32, motor: &Stance, inc: u32, steps: bool) {
        let (ticks, period) = (u32::from(segment.0), segment.1);
        self.step = match motor.accumulator.checked_div(inc) {
            // The ticks since the carry have added what is in the accumulator now.
            Some(since) if steps => since.saturating_mul(period),
            _ => (ticks - 1)
                .saturating_mul(period)
                .saturating_add(first)
                .saturating_add(self.step),
        };
        self.turn = self.turn.saturating_add(ticks.saturating_mul(period));
    }
}

/// What the foreground remembers of a segment in order to tell where the motors were at any of its ticks.
#[derive(Clone, Copy)]
struct Entry<const N: usize> {
    ticks: u16,
    start: [Stance; N],
    increments: [u32; N],
}

/// A segment, and how many of its ticks should be a timer count longer for it to end in time.
#[derive(Clone, Copy)]
struct Plan<const N: usize> {
    segment: Segment<N>,
    longer: u16,
}

/// Turns samples into segments; owns the books of N motors. Foreground only.
pub struct Segmenter<const N: usize> {
    timing: Timing,
    motors: [Stance; N],
    since: [Since; N],
    /// Period of the last segment, which the first tick of the next one still has.
    period: u32,
    /// The last sample's target, and the way to it from the one before.
    commanded: ([I32F32; N], [i64; N]),
    /// Wanted time not yet spent [timer counts]; negative when ahead.
    time_owed: i64,
    /// Segments sent so far (wraps); the number of the last one.
    sent: u32,
    memory: [Entry<N>; REMEMBERED],
}

/// The queue has no room for a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

impl<const N: usize> Segmenter<N> {
    /// All motors at rest at position 0, directions positive: what [`Interpolator::new`](super::Interpolator) has.
    pub fn new(timing: Timing) -> Self {
        let start = [Stance::at(0); N];
        let entry = Entry {
            ticks: 0,
            start,
            increments: [0; N],
        };
        Self {
            timing,
            motors: start,
            since: [Since::LONG_AGO; N],
            period: timing.floor_period,
            commanded: ([I32F32::ZERO; N], [0; N]),
            time_owed: 0,
            sent: 0,
            memory: [entry; REMEMBERED],
        }
    }

    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// New driver timing; only at rest.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
    }

    /// Steps put out by each motor once all that was sent has run.
    pub fn counts(&self) -> [i32; N] {
        self.motors.map(|m| m.count)
    }

    /// Number of the last segment sent (wraps).
    pub fn sent(&self) -> u32 {
        self.sent
    }

    /// Commanded position of each motor, as actually represented by its accumulator.
    pub fn positions(&self) -> [I32F32; N] {
        self.motors.map(|m| m.position())
    }

    /// What the interrupt's accumulators hold once all that was sent has run.
    pub fn accumulators(&self) -> [u32; N] {
        self.motors.map(|m| m.accumulator)
    }

    /// Where every motor was at an instant of the interrupt; `None` if that is too long ago.
    pub fn positions_at(&self, instant: Instant) -> Option<[I32F32; N]> {
        self.stances_at(instant)
            .map(|motors| motors.map(|m| m.position()))
    }

    /// Renumbers the present positions: motor i reads `counts[i]` from now on. Only at rest; nothing moves.
    pub fn set_counts(&mut self, counts: [i32; N]) {
        for (motor, count) in self.motors.iter_mut().zip(counts) {
            motor.count = count;
        }
        // Instants of the time before would be told in the old numbers.
        self.forget();
    }

    /// After a stop at `instant`: the books go back to where the motors really are, and a preset puts every motor
    /// half a step away from both its edges again. The queue must be empty.
    pub fn recover(
        &mut self,
        instant: Instant,
        queue: &mut SegmentSender<'_, N>,
    ) -> Result<(), Full> {
        if queue.capacity() - queue.len() < SEGMENTS_PER_SAMPLE {
            return Err(Full);
        }
        if let Some(motors) = self.stances_at(instant) {
            self.motors = motors;
        }
        // They may have stepped and turned just now; the ticks since then are those at rest.
        self.since = [Since::NOW; N];
        self.period = self.timing.floor_period;
        self.sent = instant.sequence;
        self.time_owed = 0;
        self.settle(queue);
        Ok(())
    }

    /// Sends the motors to `target` within `duration` timer counts; `last` when they rest there afterwards.
    ///
    /// Returns whether they are there; `false` only ever after a last sample that a reversal or the timing's limit
    /// has held up, and the caller sends it once more. A sample faster than the timing allows takes longer; no step is
    /// lost. Needs room for [`SEGMENTS_PER_SAMPLE`] segments and one more, else [`Full`] and nothing changes.
    pub fn advance(
        &mut self,
        target: &[I32F32; N],
        duration: u32,
        last: bool,
        queue: &mut SegmentSender<'_, N>,
    ) -> Result<bool, Full> {
        if queue.capacity() - queue.len() <= SEGMENTS_PER_SAMPLE {
            return Err(Full);
        }
        self.time_owed += i64::from(duration);
        let constant = self.is_constant(target);
        let plan = self.plan(target, last, constant);
        if let Some(plan) = self.hold_directions(plan, queue) {
            self.send_in_time(plan, queue);
        }
        let arrived = !last || self.is_at(target);
        if last && arrived {
            self.rest(queue);
        }
        Ok(arrived)
    }

    /// Whether every motor has come as close to `target` as increments can bring it: a fraction of a step, far from
    /// any edge.
    fn is_at(&self, target: &[I32F32; N]) -> bool {
        self.motors.iter().zip(target).all(|(motor, target)| {
            (target.to_bits() - motor.position().to_bits()).unsigned_abs() <= MOST_TICKS
        })
    }

    /// Whether no motor's speed differs from that of the sample before by more than 1/256 of the leader's: then half a
    /// tick along the line leads less than a thousandth of a step astray.
    fn is_constant(&mut self, target: &[I32F32; N]) -> bool {
        let (before, way_before) = &self.commanded;
        let way: [i64; N] =
            core::array::from_fn(|i| target[i].to_bits().wrapping_sub(before[i].to_bits()));
        let longest = way.iter().map(|d| d.unsigned_abs()).max().unwrap_or(0);
        let constant = way
            .iter()
            .zip(way_before)
            .all(|(d, b)| d.abs_diff(*b) <= longest >> 8);
        self.commanded = (*target, way);
        constant
    }

    /// The segment from here to `target`: ratios, ticks, period, wanted directions. Nothing is changed.
    fn plan(&self, target: &[I32F32; N], last: bool, constant: bool) -> Plan<N> {
        let timing = &self.timing;
        let mut way = [0i64; N];
        let mut longest = 0u64;
        for (i, way) in way.iter_mut().enumerate() {
            let d = target[i].to_bits() - self.motors[i].position().to_bits();
            if d.unsigned_abs() > NEGLIGIBLE as u64 {
                *way = d;
                longest = longest.max(d.unsigned_abs());
            }
        }
        let tau = self.time_owed.max(i64::from(timing.least_period)) as u64;
        let floor_ticks = (tau / u64::from(timing.floor_period)).clamp(1, MOST_TICKS);

        // Ticks a step of the leader, 2^shift.
        let mut shift = timing.mode.least_gap().trailing_zeros();
        while (longest << shift) < floor_ticks << 32 && (1 << shift) < LONGEST_STEP {
            shift += 1;
        }
        let x = longest << shift;
        let exact = !last && x >= floor_ticks << 32 && x >> 32 < MOST_TICKS;

        let mut segment = Segment {
            ticks: 1,
            kind: Kind::Motion,
            directions: self.directions(),
            period: timing.floor_period,
            channels: [Channel::at(0); N],
        };
        let counts = if exact {
            self.exact_ratios(&mut segment, &way, longest, shift, tau, constant)
        } else {
            self.plain_ratios(&mut segment, &way, longest, floor_ticks);
            tau
        };
        // tau is below 2^32 counts (25 s at 168 MHz).
        let counts = counts.min(u64::from(u32::MAX)) as u32;
        let ticks = u32::from(segment.ticks);
        segment.period = (counts / ticks).max(timing.least_period);
        let longer = counts.saturating_sub(segment.period * ticks).min(ticks - 1) as u16;

        for (i, d) in way.iter().enumerate() {
            let negative = *d < 0;
            if *d != 0 && negative != self.motors[i].negative {
                segment.directions ^= 1 << i;
            }
        }
        Plan { segment, longer }
    }

    /// Ratios by the leader's `1/k`, k = 2^shift; returns the time that they take, in timer counts.
    fn exact_ratios(
        &self,
        segment: &mut Segment<N>,
        way: &[i64; N],
        longest: u64,
        shift: u32,
        tau: u64,
        constant: bool,
    ) -> u64 {
        let x = longest << shift; // ticks, Q32.32, at least one floor's worth, below 2^48
        // To the nearest along a straight line; else down, so that the leader never runs ahead of its corner.
        let ticks = if constant {
            (x + (1 << 31)) >> 32
        } else {
            x >> 32
        };
        segment.ticks = ticks as u16;
        let x = if constant { x } else { ticks << 32 };
        // 2^78 / x, between 2^30 and 2^46: one division for all motors.
        let reciprocal = (1u64 << 62) / (x >> 16);
        let top = if shift == 0 {
            u32::MAX
        } else {
            1 << (32 - shift)
        };
        // Equals of the leader take its ratio, or they would stutter by a tick: those that reach its way by the end of
        // the segment, and on a straight line those that miss it by an eighth of a tick.
        let equal = if constant {
            longest.saturating_sub(1 << (29 - shift))
        } else {
            x >> shift
        };
        for (i, d) in way.iter().enumerate() {
            let d = d.unsigned_abs();
            if d >= equal && d != 0 {
                segment.channels[i].increment = top;
            } else {
                let inc = ((u128::from(d) * u128::from(reciprocal)) >> 46) as u64;
                segment.channels[i].increment = inc.min(u64::from(top)) as u32;
            }
        }
        if constant {
            // ticks / X of tau: ticks is below 2^16, tau held below 2^31.
            let tau = tau.min(1 << 31);
            ((tau * ticks) << 16) / (x >> 16)
        } else {
            tau
        }
    }

    /// Plain `d / ticks`, at the floor of the tick rate or as many as the leader needs.
    fn plain_ratios(
        &self,
        segment: &mut Segment<N>,
        way: &[i64; N],
        longest: u64,
        floor_ticks: u64,
    ) {
        // Two ticks a step, so that every ratio fits both modes.
        let needed = (longest >> 31) + u64::from(longest != 0);
        let ticks = needed.clamp(floor_ticks, MOST_TICKS);
        segment.ticks = ticks as u16;
        for (i, d) in way.iter().enumerate() {
            let inc = (d.unsigned_abs() + ticks / 2) / ticks;
            segment.channels[i].increment = inc.min(1 << 31) as u32;
        }
    }

    /// Keeps the old direction of a reversing motor for the hold time after its last step: where that is not over yet, a
    /// first stretch runs without it. Returns what is left of the segment.
    fn hold_directions(
        &mut self,
        plan: Plan<N>,
        queue: &mut SegmentSender<'_, N>,
    ) -> Option<Plan<N>> {
        let segment = plan.segment;
        let mut held = segment.directions ^ self.directions();
        for i in 0..N {
            if self.hold_missing(i) == 0 {
                held &= !(1 << i);
            }
        }
        let missing = self.hold_ticks(held, segment.period);
        if missing == 0 {
            return Some(plan);
        }
        let stretch = missing.min(u32::from(segment.ticks)) as u16;
        let mut first = segment;
        first.ticks = stretch;
        first.directions ^= held;
        for (i, channel) in first.channels.iter_mut().enumerate() {
            if held >> i & 1 != 0 {
                channel.increment = 0;
            }
        }
        self.send(first, queue);
        let left = segment.ticks - stretch;
        (left > 0).then(|| Plan {
            segment: Segment {
                ticks: left,
                ..segment
            },
            longer: plan.longer.min(left - 1),
        })
    }

    /// Timer counts for which the direction of motor i must still be held. At least one behind a step, so that no pin
    /// of a motor changes together with another.
    fn hold_missing(&self, i: usize) -> u32 {
        self.timing.hold.max(1).saturating_sub(self.since[i].step)
    }

    /// Ticks at `period` after which the directions of these motors may change, if none of them steps.
    pub(super) fn hold_ticks(&self, motors: Mask, period: u32) -> u32 {
        let missing = (0..N)
            .filter(|i| motors >> i & 1 != 0)
            .map(|i| self.hold_missing(i))
            .max()
            .unwrap_or(0);
        match missing {
            0 => 0,
            // The first tick has the length of those before.
            _ => 1 + missing.saturating_sub(self.period).div_ceil(period),
        }
    }

    /// Sends a planned segment so that it ends in time: whole counts a tick add up to as much as half a count for each
    /// tick. Where that is more than an eighth of a tick, the last ticks go in a segment of their own, a count longer.
    fn send_in_time(&mut self, plan: Plan<N>, queue: &mut SegmentSender<'_, N>) {
        let Plan {
            mut segment,
            longer,
        } = plan;
        let shorter = segment.ticks - longer;
        if u32::from(longer.min(shorter)) <= segment.period / 8 {
            segment.period += u32::from(longer > shorter);
            self.send(segment, queue);
        } else {
            self.send(
                Segment {
                    ticks: shorter,
                    ..segment
                },
                queue,
            );
            let period = segment.period + 1;
            self.send(
                Segment {
                    ticks: longer,
                    period,
                    ..segment
                },
                queue,
            );
        }
    }

    /// The motors rest: one tick without motion, behind which the queue may run dry.
    fn rest(&mut self, queue: &mut SegmentSender<'_, N>) {
        let segment = Segment {
            ticks: 1,
            kind: Kind::Rest,
            directions: self.directions(),
            period: self.timing.floor_period,
            channels: [Channel::at(0); N],
        };
        self.send(segment, queue);
        self.time_owed = 0;
    }

    /// Puts the accumulators to rest on the whole steps that have been put out.
    pub(super) fn settle(&mut self, queue: &mut SegmentSender<'_, N>) {
        let accumulators = self
            .motors
            .map(|m| if m.negative { !AT_REST } else { AT_REST });
        self.preset(
            accumulators,
            self.directions(),
            1,
            self.timing.floor_period,
            queue,
        );
        self.time_owed = 0;
    }

    /// Loads the accumulators and sets directions; the motors rest for `ticks`.
    pub(super) fn preset(
        &mut self,
        accumulators: [u32; N],
        directions: Mask,
        ticks: u16,
        period: u32,
        queue: &mut SegmentSender<'_, N>,
    ) {
        for (i, motor) in self.motors.iter_mut().enumerate() {
            let negative = directions >> i & 1 != 0;
            if negative != motor.negative {
                motor.turn();
                self.since[i].turn = 0;
            }
            motor.accumulator = accumulators[i];
        }
        let segment = Segment {
            ticks,
            kind: Kind::Rest,
            directions,
            period,
            channels: [Channel::at(0); N],
        };
        self.send(segment, queue);
    }

    pub(super) fn directions(&self) -> Mask {
        self.motors
            .iter()
            .enumerate()
            .fold(0, |mask, (i, m)| mask | u8::from(m.negative) << i)
    }

    /// Enters a segment in the books and queues it: motors whose direction differs turn round, none steps before its
    /// direction has been set up, and the accumulators begin as the books have them. The caller has made sure of the
    /// room.
    pub(super) fn send(&mut self, mut segment: Segment<N>, queue: &mut SegmentSender<'_, N>) {
        let turning = segment.directions ^ self.directions();
        let ticks = u32::from(segment.ticks);
        for i in 0..N {
            let (motor, since) = (&mut self.motors[i], &mut self.since[i]);
            let channel = &mut segment.channels[i];
            let mut wait = 0;
            if turning >> i & 1 != 0 {
                motor.turn();
                since.turn = 0;
                // Never in the tick right behind a step.
                wait = 1;
            }
            let missing = self.timing.setup.saturating_sub(since.turn);
            if missing > 0 {
                wait = missing.div_ceil(segment.period);
            }
            if wait > 0 {
                motor.hold_back(wait.min(ticks), &mut channel.increment);
            }
            channel.accumulator = motor.accumulator;
        }
        self.sent = self.sent.wrapping_add(1);
        if let Some(entry) = self.memory.get_mut(self.sent as usize % REMEMBERED) {
            *entry = Entry {
                ticks: segment.ticks,
                start: self.motors,
                increments: segment.channels.map(|channel| channel.increment),
            };
        }
        let span = (segment.ticks, segment.period);
        for i in 0..N {
            let inc = segment.channels[i].increment;
            let steps = self.motors[i].run(inc, segment.ticks);
            self.since[i].pass(span, self.period, &self.motors[i], inc, steps);
        }
        self.period = segment.period;
        self.time_owed -= i64::from(segment.ticks) * i64::from(segment.period);
        let sent = queue.enqueue(segment);
        debug_assert!(sent.is_ok(), "the caller makes room");
    }

    fn stances_at(&self, instant: Instant) -> Option<[Stance; N]> {
        if instant.sequence == self.sent && instant.remaining == 0 {
            return Some(self.motors);
        }
        if self.sent.wrapping_sub(instant.sequence) as usize >= REMEMBERED {
            return None;
        }
        let entry = self.memory.get(instant.sequence as usize % REMEMBERED)?;
        let done = u32::from(entry.ticks).saturating_sub(instant.remaining) as u16;
        let mut motors = entry.start;
        for (i, motor) in motors.iter_mut().enumerate() {
            motor.run(entry.increments[i], done);
        }
        Some(motors)
    }

    /// Makes every instant so far read as the present stance.
    fn forget(&mut self) {
        let entry = Entry {
            ticks: 0,
            start: self.motors,
            increments: [0; N],
        };
        self.memory = [entry; REMEMBERED];
    }
}
