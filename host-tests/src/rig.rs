//! The board of memory: virtual step and direction pins, a virtual step timer, and the same step interrupt as on the
//! target, run as fast as the host can.
//!
//! ```text
//! foreground   feed: the job's own pipe, down to the segmenter    -> queue of Segment<N>
//!                                                                        |
//! wrap of the timer    Interpolator::tick -> PinPort -> Pins (embedded-hal) -> Trace
//! ```
//!
//! The foreground runs when the queue runs low and takes no time; how it is interleaved with the ticks cannot change a
//! pulse as long as the queue never runs dry, and when it does, that is counted as on the target.
//!
//! The timer is a SysTick: a wrap loads the period that was written before it, so a period written in the handler
//! holds from the next wrap on.

use crate::trace::Trace;
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use hexstep::stepper::{
    Interpolator, PinPort, SegmentQueue, SegmentSender, Segmenter, Shared, StepTimer, Timing,
};
use std::cell::Cell;

/// One pin of a port of memory: a bit of a byte.
pub struct Pin<'a> {
    port: &'a Cell<u8>,
    bit: u8,
}

impl<'a> Pin<'a> {
    /// All N pins of a port, pin i at bit i.
    pub fn all<const N: usize>(port: &'a Cell<u8>) -> [Self; N] {
        const { assert!(N <= 8, "a port of memory has eight bits") };
        std::array::from_fn(|i| Self { port, bit: 1 << i })
    }
}

impl ErrorType for Pin<'_> {
    type Error = Infallible;
}

impl OutputPin for Pin<'_> {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.port.set(self.port.get() & !self.bit);
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.port.set(self.port.get() | self.bit);
        Ok(())
    }
}

/// A SysTick of memory.
#[derive(Clone, Copy, Debug)]
struct SysTick {
    /// Time of the last wrap [counts].
    time: u64,
    /// Counts to the next wrap, and those loaded then.
    running: u32,
    reload: u32,
}

impl SysTick {
    fn new(period: u32) -> Self {
        Self {
            time: 0,
            running: period,
            reload: period,
        }
    }

    /// Runs to the next wrap; its time.
    #[inline]
    fn wrap(&mut self) -> u64 {
        self.time += u64::from(self.running);
        self.running = self.reload;
        self.time
    }
}

impl StepTimer for SysTick {
    #[inline]
    fn set_period(&mut self, counts: u32) {
        // A timer that never wraps would stand still for ever.
        self.reload = counts.max(1);
    }
}

/// What the foreground has to say when it was asked for more segments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// There is more to come.
    More,
    /// All has been sent.
    Done,
}

/// What a simulation has shown.
#[derive(Clone, Debug)]
pub struct Outcome<const N: usize> {
    pub trace: Trace<N>,
    /// Steps of each motor as the foreground's books have them.
    pub counts: [i32; N],
    /// Times that the queue ran dry in motion; must be 0.
    pub starved: u32,
}

/// Segments left in the queue when the foreground is asked for more.
const LOW: usize = 8;

/// Runs segments from `feed` until it is done and the last step is out. `feed` puts segments into the queue as long
/// as there is room; an error of it ends the simulation at once.
///
/// # Errors
/// Whatever `feed` returns.
pub fn simulate<const N: usize, E>(
    timing: Timing,
    mut feed: impl FnMut(&mut Segmenter<N>, &mut SegmentSender<'_, N>) -> Result<Feed, E>,
) -> Result<Outcome<N>, E> {
    let mut queue = SegmentQueue::<N>::new();
    let (mut sender, receiver) = queue.split();
    let shared = Shared::new();
    let mut segmenter = Segmenter::<N>::new(timing);
    let mut interpolator = Interpolator::new(receiver, &shared, timing.mode, timing.floor_period);

    let (levels, directions) = (Cell::new(0u8), Cell::new(0u8));
    let mut port = PinPort {
        steps: Pin::all::<N>(&levels),
        directions: Pin::all::<N>(&directions),
    };
    let mut timer = SysTick::new(timing.floor_period);
    let mut trace = Trace::new(timing.mode);
    trace.enable(true);
    let mut tick = |trace: &mut Trace<N>| {
        trace.tick(timer.wrap());
        interpolator.tick(&mut port, &mut timer);
        // In this order on the pins, too: the steps of the segment before come first.
        trace.steps(levels.get());
        trace.directions(directions.get());
    };

    loop {
        let state = feed(&mut segmenter, &mut sender)?;
        match state {
            Feed::More => {
                // At least one tick, so that a feed that found no room gets some.
                tick(&mut trace);
                while sender.len() > LOW {
                    tick(&mut trace);
                }
            }
            Feed::Done => break,
        }
    }
    while sender.len() > 0 || shared.now().remaining > 0 {
        tick(&mut trace);
    }
    // The last levels go out a tick after they were computed, and a pulse ends one later.
    for _ in 0..3 {
        tick(&mut trace);
    }
    trace.enable(false);
    Ok(Outcome {
        trace,
        counts: segmenter.counts(),
        starved: shared.starved(),
    })
}
