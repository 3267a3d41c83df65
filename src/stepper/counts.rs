//! A line of integer step counts, run as such: the paper's own hand-over from planning computer to controller.
//!
//! The line starts and ends at rest. It takes `MAX = k max |M|` ticks, k a power of two, and section 1 of
//! interpolation.md holds literally, preset included. The carry form runs on increments of 32 bits; each stretch of at
//! most `2^32 / MAX` ticks starts from the books, so the sum stays within one part in MAX above the exact one and every
//! step comes at the tick at which the compare form makes it, for lines of up to [`MOST_TICKS`] ticks.
#![deny(clippy::float_arithmetic)]

use super::segmenter::{Full, SEGMENTS_PER_SAMPLE};
use super::{AT_REST, Channel, Kind, Mask, Preset, Segment, SegmentSender, Segmenter, Timing};

/// Longest line in ticks: stretches then still have 256 ticks.
pub const MOST_TICKS: u64 = 1 << 24;

/// Why a line of counts is refused. Nothing has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CountError {
    /// A count beyond what a line can carry; `least` is the bound on its magnitude.
    OutOfRange { motor: usize, bound: u32 },
    /// The duration is too short for the largest count: at least `least` timer counts are needed.
    TooFast { least: u64 },
    /// The duration would need a tick longer than the timer has, or more ticks than a line may have: `most` counts.
    TooSlow { most: u64 },
    /// The end position would leave the range of a step counter.
    Overflow { motor: usize },
}

/// A checked line of counts on its way into the queue.
#[derive(Clone, Debug)]
pub struct CountLine<const N: usize> {
    counts: [i32; N],
    preset: Preset,
    /// Ticks of the line.
    max: u32,
    period: u32,
    done: u32,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Hold,
    Preset,
    Run,
    Settle,
    Over,
}

impl<const N: usize> CountLine<N> {
    /// Largest magnitude of a count.
    pub const BOUND: u32 = (MOST_TICKS / 2) as u32;

    /// A line of `counts` steps that takes `duration` timer counts (rounded to whole counts per tick), from positions
    /// `from`.
    pub fn new(
        counts: [i32; N],
        duration: u64,
        preset: Preset,
        timing: &Timing,
        from: &[i32; N],
    ) -> Result<Self, CountError> {
        for motor in 0..N {
            if counts[motor].unsigned_abs() > Self::BOUND {
                return Err(CountError::OutOfRange {
                    motor,
                    bound: Self::BOUND,
                });
            }
            if from[motor].checked_add(counts[motor]).is_none() {
                return Err(CountError::Overflow { motor });
            }
        }
        let largest = counts.iter().map(|m| m.unsigned_abs()).max().unwrap_or(0);
        let mut max = u64::from(largest) * u64::from(timing.mode.least_gap());
        if max == 0 {
            return Ok(Self {
                counts,
                preset,
                max: 0,
                period: timing.floor_period,
                done: 0,
                stage: Stage::Over,
            });
        }
        let least = max * u64::from(timing.least_period);
        if duration < least {
            return Err(CountError::TooFast { least });
        }
        // Twice as many ticks while they stay at or below the floor of the tick rate.
        while duration > max * u64::from(timing.floor_period) {
            max *= 2;
        }
        if max > MOST_TICKS {
            return Err(CountError::TooSlow {
                most: MOST_TICKS * u64::from(timing.floor_period),
            });
        }
        Ok(Self {
            counts,
            preset,
            max: max as u32,
            period: ((duration + max / 2) / max) as u32,
            done: 0,
            stage: Stage::Hold,
        })
    }

    /// Ticks from the first to the last of the line, the paper's MAX.
    pub fn ticks(&self) -> u32 {
        self.max
    }

    /// Timer counts per tick.
    pub fn period(&self) -> u32 {
        self.period
    }

    /// Puts as many segments as there is room for into the queue; `true` when the line has been sent whole.
    pub fn feed(&mut self, segmenter: &mut Segmenter<N>, queue: &mut SegmentSender<'_, N>) -> bool {
        while self.stage != Stage::Over {
            if self.send_one(segmenter, queue).is_err() {
                return false;
            }
        }
        true
    }

    fn send_one(
        &mut self,
        segmenter: &mut Segmenter<N>,
        queue: &mut SegmentSender<'_, N>,
    ) -> Result<(), Full> {
        if queue.capacity() - queue.len() < SEGMENTS_PER_SAMPLE {
            return Err(Full);
        }
        let directions = self.directions(segmenter.directions());
        match self.stage {
            Stage::Hold => {
                // The old directions stand until their hold time is over.
                // The longest hold has 168 000 counts, 700 of the shortest ticks.
                let ticks = segmenter.hold_ticks(Mask::MAX, self.period).min(60_000) as u16;
                if ticks > 0 {
                    segmenter.send(
                        self.segment(Kind::Rest, ticks, segmenter.directions()),
                        queue,
                    );
                }
                self.stage = Stage::Preset;
            }
            Stage::Preset => {
                // The first step may come with the first tick of the line, one tick after these.
                let ticks = segmenter
                    .timing()
                    .setup
                    .div_ceil(self.period)
                    .clamp(1, 60_000) as u16;
                let accumulators = core::array::from_fn(|i| self.exact(i, 0) as u32);
                segmenter.preset(accumulators, directions, ticks, self.period, queue);
                self.stage = Stage::Run;
            }
            Stage::Run => {
                // 2^32 / MAX ticks keep the carry form exact; no stretch lasts longer than about a millisecond, so that
                // a stop or a latch never waits for a long one.
                let millisecond = (segmenter.timing().hz / 1000 / self.period).max(1);
                let exact_for = (u32::MAX / self.max).max(1);
                let ticks = millisecond
                    .min(exact_for)
                    .min(60_000)
                    .min(self.max - self.done);
                let mut segment = self.segment(Kind::Motion, ticks as u16, directions);
                let accumulators = segmenter.accumulators();
                for i in 0..N {
                    segment.channels[i].increment = self.increment(i, accumulators[i], ticks);
                }
                segmenter.send(segment, queue);
                self.done += ticks;
                if self.done == self.max {
                    self.stage = Stage::Settle;
                }
            }
            Stage::Settle => {
                segmenter.settle(queue);
                self.stage = Stage::Over;
            }
            Stage::Over => {}
        }
        Ok(())
    }

    /// The exact sum of motor i after `ticks` ticks, preset included, in units of 2^-32 step, rounded up.
    fn exact(&self, i: usize, ticks: u32) -> u64 {
        let r = u64::from(self.counts[i].unsigned_abs());
        if r == 0 {
            return u64::from(AT_REST);
        }
        if self.steps_always(i) {
            // Loses one part in 2^32 a tick, at most 2^24 in all, and so carries at every one.
            return u64::from(u32::MAX);
        }
        let preset = match self.preset {
            Preset::Published => r,
            Preset::Centred => u64::from(self.max / 2),
        };
        // preset + ticks r is below 2^24 (1 + 2^24); times 2^32 it needs 81 bits.
        let sum = u128::from(preset + u64::from(ticks) * r) << 32;
        sum.div_ceil(u128::from(self.max)) as u64
    }

    /// The increment that takes motor i from `accumulator` to at or just above the exact sum, `ticks` ticks on.
    fn increment(&self, i: usize, accumulator: u32, ticks: u32) -> u32 {
        if self.counts[i] == 0 {
            return 0;
        }
        if self.steps_always(i) {
            return u32::MAX;
        }
        let now = self.exact(i, self.done);
        let goal = self.exact(i, self.done + ticks);
        // The accumulator holds the low 32 bits of a sum at or less than 2^32 / MAX above `now`.
        let above = u64::from(accumulator.wrapping_sub(now as u32));
        (goal - now)
            .saturating_sub(above)
            .div_ceil(u64::from(ticks)) as u32
    }

    /// Ratio 1, in both-edge mode: no increment of 32 bits says so.
    fn steps_always(&self, i: usize) -> bool {
        self.counts[i].unsigned_abs() == self.max
    }

    fn directions(&self, before: Mask) -> Mask {
        let mut mask = before;
        for (i, m) in self.counts.iter().enumerate() {
            if *m != 0 {
                mask = mask & !(1 << i) | u8::from(*m < 0) << i;
            }
        }
        mask
    }

    fn segment(&self, kind: Kind, ticks: u16, directions: Mask) -> Segment<N> {
        Segment {
            ticks,
            kind,
            directions,
            period: self.period,
            channels: [Channel::at(0); N],
        }
    }
}
