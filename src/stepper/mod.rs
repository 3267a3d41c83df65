//! Commanded positions -> [`Segment`] -> pulses: the ratio-integral method, exact in number and even in time.
//!
//! ```text
//!  planner sample (position of each motor, 1 ms apart)
//!     |  Segmenter       foreground: distance and time -> ticks, period, increments; keeps the books
//!     |  CountLine       foreground: a line of integer counts, as the paper hands it over
//!     v                                        ---- queue of Segment<N> ----
//!     |  Interpolator    step interrupt: acc += inc for each motor, the carry is a step
//!     v  StepPort        all pins of a port in one store
//! ```
//!
//! [`Segment`] is the whole contract between the foreground and the interrupt. The interrupt never counts steps: the
//! number of the segment and of the tick within it are enough, because the foreground knows every accumulator by
//! arithmetic. That is also why a segment says where the accumulators begin: a motor that turns round, or waits for its
//! direction to be set up, costs the interrupt nothing. Source of the rule: Li & Chen, *Research on kinematic synthesis of a robot manipulator for drill
//! grinding*, section 3.1; everything else is described in spec `interpolation.md`.

pub mod counts;
pub mod interpolator;
pub mod port;
pub mod rule;
pub mod segmenter;

pub use counts::{CountError, CountLine};
pub use interpolator::{Interpolator, Shared};
pub use port::{PinPort, RegisterPort, SetResetRegister, StepPort, StepTimer};
pub use rule::{Preset, Rule};
pub use segmenter::{Segmenter, Stance};

/// Slots of the segment queue. At 1 ms each they hold over 60 ms of motion: three times what interpolation.md asks for.
pub const QUEUE: usize = 64;

/// The queue between the foreground and the step interrupt.
pub type SegmentQueue<const N: usize> = heapless::spsc::Queue<Segment<N>, QUEUE>;
/// The foreground's end of it.
pub type SegmentSender<'a, const N: usize> = heapless::spsc::Producer<'a, Segment<N>>;
/// The interrupt's end of it.
pub type SegmentReceiver<'a, const N: usize> = heapless::spsc::Consumer<'a, Segment<N>>;

/// One bit for each motor, motor 0 in bit 0. Eight motors at the most.
pub type Mask = u8;

/// A stretch of motion at constant rate, about 1 ms long, computed ahead by the foreground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment<const N: usize> {
    /// Ticks in this segment, at least 1.
    pub ticks: u16,
    /// What the queue may do behind it.
    pub kind: Kind,
    /// Direction of each motor: a set bit means towards negative.
    pub directions: Mask,
    /// Timer counts per tick; the first tick has yet the length of those before.
    pub period: u32,
    /// Where each motor begins and how fast it goes.
    pub channels: [Channel; N],
}

/// One motor of a segment. Accumulator and increment side by side, because one load fetches both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Channel {
    /// Where the accumulator begins. The foreground knows where the segment before has left it: there, or turned round,
    /// held back, preset. So no tick has to do any of that.
    pub accumulator: u32,
    /// Steps per tick in units of 2^-32, at most 2^31 in pulse mode. `u32::MAX` stands for a step at every tick: the
    /// carry comes at each as long as the accumulator is not below the ticks of the segment.
    pub increment: u32,
}

impl Channel {
    /// No motion.
    pub const fn at(accumulator: u32) -> Self {
        Self {
            accumulator,
            increment: 0,
        }
    }
}

/// An accumulator at rest: half a step from either edge (interpolation.md section 3).
pub const AT_REST: u32 = 1 << 31;

/// What may come behind a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// More motion: running dry behind it is starvation.
    Motion,
    /// Anything: the motors rest (all increments are zero), and the queue may run dry.
    Rest,
}

/// When the step pins change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum StepMode {
    /// A step is one pulse, one tick wide; at most one step in two ticks.
    #[default]
    Pulse,
    /// Every step toggles its pin; at most one step a tick (drivers that step on both edges).
    BothEdge,
}

impl StepMode {
    /// Least ticks from one step to the next.
    pub const fn least_gap(self) -> u32 {
        match self {
            StepMode::Pulse => 2,
            StepMode::BothEdge => 1,
        }
    }
}

/// Times that the drivers ask for, in counts of the step timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// Counts per second of the step timer.
    pub hz: u32,
    /// Shortest tick: the step-pulse time.
    pub least_period: u32,
    /// Longest tick: the floor of the tick rate, so that minor motors stay smooth at low speed.
    pub floor_period: u32,
    /// From a change of direction to the first step in it.
    pub setup: u32,
    /// From the last step in a direction to the change of it.
    pub hold: u32,
    pub mode: StepMode,
}

impl Timing {
    /// Floor of the tick rate [1/s].
    pub const FLOOR_HZ: u32 = 40_000;

    /// Timing from driver times in nanoseconds.
    pub const fn from_ns(
        hz: u32,
        pulse_ns: u32,
        setup_ns: u32,
        hold_ns: u32,
        mode: StepMode,
    ) -> Self {
        let floor_period = hz / Self::FLOOR_HZ;
        let least = counts_of_ns(hz, pulse_ns);
        // The handler itself needs about 110 model cycles a tick (interpolation.md section 6); shorter ticks would
        // starve the foreground.
        let least = if least < LEAST_TICK {
            LEAST_TICK
        } else {
            least
        };
        Self {
            hz,
            least_period: if least > floor_period {
                floor_period
            } else {
                least
            },
            floor_period,
            setup: counts_of_ns(hz, setup_ns),
            hold: counts_of_ns(hz, hold_ns),
            mode,
        }
    }

    /// The highest step rate of one motor [steps/s].
    pub const fn fastest(&self) -> u32 {
        self.hz / (self.least_period * self.mode.least_gap())
    }
}

/// Shortest tick in timer counts that leaves the foreground half of the processor.
pub const LEAST_TICK: u32 = 240;

/// Nanoseconds in timer counts, rounded up.
const fn counts_of_ns(hz: u32, ns: u32) -> u32 {
    // 2^32 ns * 2^32 Hz stays below 2^64.
    ((hz as u64 * ns as u64).div_ceil(1_000_000_000)) as u32
}
