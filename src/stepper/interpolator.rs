//! Segment -> step levels, in the step interrupt: the ratio-integral rule in its carry form. Integers only.
//!
//! ```text
//! tick k:  put out the levels computed at tick k-1        (constant time from timer to pin)
//!          segment over? load the next one                (directions change here, after the last step of the old one;
//!                                                          accumulators and increments are copied as they are)
//!          (acc[i], carry) = acc[i] + inc[i]              carry = motor i steps, seen at the pin at tick k+1
//! ```
//!
//! With `inc = ceil(R 2^32 / MAX)` and `acc` started at `inc`, step k comes at exactly the tick at which the compare form
//! of [`Rule`](super::Rule) makes it, for `MAX <= 65535` (interpolation.md section 2 has the proof).
//!
//! Nothing here can panic, divide, wait or lock. Deadline: the shortest tick, [`LEAST_TICK`](super::LEAST_TICK) timer
//! counts. A tick that comes late is not lost: SysTick stays pending, and all motors are late together.
#![deny(
    clippy::float_arithmetic,
    clippy::integer_division,
    clippy::indexing_slicing
)]

use super::{AT_REST, Channel, Kind, Mask, SegmentReceiver, StepMode, StepPort, StepTimer};
use core::sync::atomic::{
    AtomicU32,
    Ordering::{Relaxed, SeqCst},
    compiler_fence,
};

/// Does something for each motor, the last one first, for as many as there are: a motor that does not exist is one that
/// `get` does not find, which the compiler knows. Written out, because a loop would stay one where the rest of the
/// program is compiled for size.
macro_rules! each_motor {
    ($motor:ident => $action:expr) => {
        each_motor!($motor => $action; 7, 6, 5, 4, 3, 2, 1, 0)
    };
    ($motor:ident => $action:expr; $($number:literal),*) => {
        $({
            const $motor: usize = $number;
            $action
        })*
    };
}

/// What the interrupt and the foreground tell each other: single words, each written by one side.
///
/// The interrupt cannot be interrupted by the foreground, so plain loads and stores are enough.
#[derive(Debug, Default)]
pub struct Shared {
    /// Ticks left in the present segment in the low 16 bits; above them what the foreground asks for,
    /// [`Shared::LATCH`] and [`Shared::STOP`], cleared by the interrupt when done. One word, so that the common tick
    /// tests both at once.
    remaining: AtomicU32,
    /// Segments loaded so far (wraps).
    sequence: AtomicU32,
    /// `sequence` and `remaining` at the tick that served the last request.
    latched: [AtomicU32; 2],
    /// 1 after a stop, until the foreground lets the interrupt go on.
    halted: AtomicU32,
    /// How often the queue ran dry in motion. Must stay 0.
    starved: AtomicU32,
}

/// An instant of the interpolator: which segment, and how many of its ticks were still to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instant {
    pub sequence: u32,
    pub remaining: u32,
}

impl Shared {
    const LATCH: u32 = 1 << 16;
    const STOP: u32 = 1 << 17;
    const TICKS: u32 = 0xFFFF;

    pub const fn new() -> Self {
        Self {
            remaining: AtomicU32::new(0),
            sequence: AtomicU32::new(0),
            latched: [const { AtomicU32::new(0) }; 2],
            halted: AtomicU32::new(0),
            starved: AtomicU32::new(0),
        }
    }

    /// Asks for the positions of all motors at the next tick; see [`Shared::latched`].
    pub fn latch(&self) {
        self.remaining.fetch_or(Self::LATCH, Relaxed);
    }

    /// Asks for a stop at the next tick: no further step, positions latched, queued segments dropped.
    pub fn stop(&self) {
        self.remaining.fetch_or(Self::STOP, Relaxed);
    }

    /// The instant latched by the last request, or `None` while it has not been served.
    pub fn latched(&self) -> Option<Instant> {
        (self.remaining.load(Relaxed) <= Self::TICKS).then(|| Instant {
            sequence: self.latched[0].load(Relaxed),
            remaining: self.latched[1].load(Relaxed),
        })
    }

    /// The present instant, as read by the foreground or by an interrupt below the step interrupt.
    pub fn now(&self) -> Instant {
        loop {
            let sequence = self.sequence.load(Relaxed);
            let remaining = self.remaining.load(Relaxed) & Self::TICKS;
            // The step interrupt may have loaded a segment between the two reads; it cannot do so twice in a row.
            if self.sequence.load(Relaxed) == sequence {
                return Instant {
                    sequence,
                    remaining,
                };
            }
        }
    }

    /// Whether the interrupt has stopped and drops what is queued.
    pub fn is_halted(&self) -> bool {
        self.halted.load(Relaxed) != 0
    }

    /// Lets the interrupt take segments again; called once the queue is empty.
    pub fn release(&self) {
        self.halted.store(0, Relaxed);
    }

    /// How often the queue ran dry in motion.
    pub fn starved(&self) -> u32 {
        self.starved.load(Relaxed)
    }
}

/// The state of N motors between two ticks. Owned by the step interrupt.
///
/// The order of the fields is the order of use: the hot ones stay within reach of one base register.
#[repr(C)]
pub struct Interpolator<'a, const N: usize> {
    channels: [Channel; N],
    /// Levels of the step pins that the next tick puts out.
    levels: u32,
    /// Levels that outlive a tick: none in pulse mode, all in both-edge mode.
    kept: u32,
    shared: &'a Shared,
    moving: bool,
    directions: Mask,
    queue: SegmentReceiver<'a, N>,
    rest_period: u32,
}

impl<'a, const N: usize> Interpolator<'a, N> {
    /// Motors at rest on whole steps, all directions positive. `rest_period` [timer counts] is the tick while idle.
    pub fn new(
        queue: SegmentReceiver<'a, N>,
        shared: &'a Shared,
        mode: StepMode,
        rest_period: u32,
    ) -> Self {
        const { assert!(N >= 1 && N <= 8, "a mask has eight bits") };
        Self {
            channels: [Channel::at(AT_REST); N],
            levels: 0,
            kept: kept(mode),
            shared,
            moving: false,
            directions: 0,
            queue,
            rest_period,
        }
    }

    /// Changes the step mode; only between motions, with the step interrupt not running.
    pub fn set_mode(&mut self, mode: StepMode) {
        self.kept = kept(mode);
        self.levels &= self.kept;
    }

    /// One tick. The step interrupt calls this and nothing else.
    #[inline(always)]
    pub fn tick(&mut self, port: &mut impl StepPort, timer: &mut impl StepTimer) {
        port.emit(self.levels);
        let shared = self.shared;
        let mut remaining = shared.remaining.load(Relaxed).wrapping_sub(1);
        // No tick left (the difference wraps), or a request above the ticks.
        if remaining >= Shared::TICKS {
            remaining = self.turn(port, timer);
        }
        shared.remaining.store(remaining, Relaxed);

        let mut steps = 0;
        each_motor!(I => add(self.channels.get_mut(I), &mut steps));
        self.levels = (self.levels & self.kept) ^ steps;
    }

    /// The rare tick: a segment is over, or the foreground wants something. Returns the ticks left after
    /// this one.
    ///
    /// Out of line, so that the common tick saves no registers for it.
    #[cold]
    #[inline(never)]
    fn turn(&mut self, port: &mut impl StepPort, timer: &mut impl StepTimer) -> u32 {
        let shared = self.shared;
        let word = shared.remaining.load(Relaxed);
        let remaining = word & Shared::TICKS;
        if word != remaining {
            shared.latched[0].store(shared.sequence.load(Relaxed), Relaxed);
            shared.latched[1].store(remaining, Relaxed);
            if word & Shared::STOP != 0 {
                shared.halted.store(1, Relaxed);
                return self.rest(timer);
            }
            if remaining != 0 {
                return remaining - 1;
            }
        }
        // Read in place and taken out afterwards: copying a segment costs more than all the rest here.
        let Some(segment) = self.queue.peek() else {
            if self.moving {
                shared
                    .starved
                    .store(shared.starved.load(Relaxed).wrapping_add(1), Relaxed);
            }
            return self.rest(timer);
        };
        if shared.halted.load(Relaxed) != 0 {
            let _ = self.queue.dequeue();
            return self.rest(timer);
        }
        shared
            .sequence
            .store(shared.sequence.load(Relaxed).wrapping_add(1), Relaxed);
        timer.set_period(segment.period);
        if segment.directions != self.directions {
            self.directions = segment.directions;
            port.direct(segment.directions.into());
        }
        self.moving = segment.kind == Kind::Motion;
        let ticks = u32::from(segment.ticks).wrapping_sub(1) & Shared::TICKS;
        let (ours, theirs) = (&mut self.channels, &segment.channels);
        each_motor!(I => load(ours.get_mut(I), theirs.get(I)));
        let _ = self.queue.dequeue();
        ticks
    }

    /// No motion for one tick.
    #[inline(always)]
    fn rest(&mut self, timer: &mut impl StepTimer) -> u32 {
        for channel in &mut self.channels {
            channel.increment = 0;
        }
        self.moving = false;
        timer.set_period(self.rest_period);
        0
    }
}

/// Adds a motor's increment and shifts the carry into the mask of steps. Motor 0 comes last and ends in bit 0.
#[inline(always)]
fn add(channel: Option<&mut Channel>, steps: &mut u32) {
    let Some(channel) = channel else {
        return;
    };
    // One 64-bit addition, (steps : acc) + (steps : inc): the low half is the accumulator, and its carry is shifted
    // into the mask from the right. Two instructions on the target.
    let sum = join(*steps, channel.accumulator).wrapping_add(join(*steps, channel.increment));
    channel.accumulator = sum as u32;
    *steps = (sum >> 32) as u32;
    // One motor after the other: fetching them all ahead would need registers that must be saved first.
    compiler_fence(SeqCst);
}

#[inline(always)]
fn load(ours: Option<&mut Channel>, theirs: Option<&Channel>) {
    if let (Some(ours), Some(theirs)) = (ours, theirs) {
        *ours = *theirs;
    }
}

#[inline(always)]
fn join(high: u32, low: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

const fn kept(mode: StepMode) -> u32 {
    match mode {
        StepMode::Pulse => 0,
        StepMode::BothEdge => u32::MAX,
    }
}
