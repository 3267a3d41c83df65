//! Pin levels -> a trace: what N step/direction channels did, tick by tick, in about three bytes a step.
//!
//! A trace is written by whoever plays the board (the host rig, or the stores captured in the emulator) and read by
//! everything that judges: it holds levels and not steps, so that pulse widths and set-up times can be judged too.
//!
//! ```text
//! tick(time)             a step-timer event: the tick index grows by one
//!   steps(levels)        the step pins now stand at `levels`, bit i = motor i
//!   directions(mask)     the direction pins now stand at `mask`, bit set = negative
//!   enable(on)           the drivers were switched
//!      |
//!      v  events()       every change, in order
//!         pulses()       the changes that are steps        (pulses.rs)
//!         positions_at   whole steps at any time
//!         statistics()   counts, gaps, widths, set-up      (statistics.rs)
//!         Motion         speed, acceleration and jerk      (motion.rs)
//! ```
//!
//! Events of one tick stand in the order of the pins: steps, then directions, never both of one motor.
//!
//! Time is a count of the step timer since the trace began, [`TICK_HZ`] counts a second, never a float.
//!
//! Storage: events lie in blocks of 64 KiB, each of which opens with the full state, so that a block can be read
//! without those before it. Within a block a level change is a byte for the ticks since the event before and a byte
//! for the levels (two for the ticks after a pause); the end of a pulse is one byte. Time is not stored as long as the ticks keep their period; where
//! it changes, a record of three short numbers does.

mod motion;
mod pulses;
mod statistics;

pub use motion::{HALF_WINDOW, Motion};
pub use pulses::{Pulse, Pulses, Step};
pub use statistics::{MotorStatistics, RATE_GAPS};

use hexstep::stepper::StepMode;

/// Counts of the step timer in a second: the core clock of the STM32F407.
pub const TICK_HZ: u64 = 168_000_000;

/// Seconds of a time in counts.
pub fn seconds(counts: u64) -> f64 {
    counts as f64 / TICK_HZ as f64
}

/// One change of the pins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Ticks begun when it happened; 0 before the first tick.
    pub tick: u64,
    /// Counts of the step timer since the trace began.
    pub time: u64,
    pub change: Change,
}

/// What changed: always the whole new state of that kind of pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Levels of the step pins, bit i = motor i.
    Levels(u8),
    /// Levels of the direction pins, bit set = negative.
    Directions(u8),
    /// Drivers on or off.
    Enable(bool),
}

/// Everything known at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State<const N: usize> {
    pub tick: u64,
    pub time: u64,
    /// Counts between ticks, as the storage last noted it.
    period: u64,
    pub levels: u8,
    pub directions: u8,
    pub enabled: bool,
    /// Whole steps put out since the trace began.
    pub positions: [i64; N],
}

impl<const N: usize> State<N> {
    const START: Self = Self {
        tick: 0,
        time: 0,
        period: 0,
        levels: 0,
        directions: 0,
        enabled: false,
        positions: [0; N],
    };

    /// Takes a change over; the motors that step by it.
    fn apply(&mut self, mode: StepMode, change: Change) -> u8 {
        match change {
            Change::Levels(levels) => {
                let stepping = match mode {
                    StepMode::Pulse => levels & !self.levels,
                    StepMode::BothEdge => levels ^ self.levels,
                };
                self.levels = levels;
                for motor in bits::<N>(stepping) {
                    self.positions[motor] += if self.directions >> motor & 1 == 0 {
                        1
                    } else {
                        -1
                    };
                }
                stepping
            }
            Change::Directions(mask) => {
                self.directions = mask;
                0
            }
            Change::Enable(on) => {
                self.enabled = on;
                0
            }
        }
    }
}

/// The motors whose bit is set.
pub fn bits<const N: usize>(mask: u8) -> impl Iterator<Item = usize> {
    let mut rest = mask as u32 & ((1 << N) - 1);
    core::iter::from_fn(move || {
        let motor = rest.trailing_zeros() as usize;
        rest &= rest.wrapping_sub(1);
        (motor < 32).then_some(motor)
    })
}

/// Bytes of a block; one record is at most [`RECORD`] long.
const BLOCK: usize = 1 << 16;
const RECORD: usize = 40;

// Record heads. 0x00..=0x3f: ticks since the event before, then a byte of levels. 0x40..=0x7f: the same ticks, and all
// levels fall. 0xc0..=0xff: the upper six of fourteen bits of ticks, then the lower eight, then a byte of levels.
const FALL: u8 = 0x40;
const LONG: u8 = 0xc0;
const SYNC: u8 = 0x80;
const DIRECTIONS: u8 = 0x81;
const DISABLE: u8 = 0x82;
const ENABLE: u8 = 0x83;
const SHORT_TICKS: u64 = 0x3f;
const LONG_TICKS: u64 = 0x3fff;

#[derive(Clone, Debug)]
struct Block<const N: usize> {
    start: State<N>,
    bytes: Vec<u8>,
}

/// What N step/direction channels did, N = 1 ..= 8. See the module's page.
#[derive(Clone, Debug)]
pub struct Trace<const N: usize> {
    mode: StepMode,
    blocks: Vec<Block<N>>,
    events: u64,
    /// The pins as they stand; tick and time of the event last stored.
    stored: State<N>,
    /// The tick under way: its index, its time, and the counts since the tick before.
    tick: u64,
    time: u64,
    period: u64,
}

impl<const N: usize> Trace<N> {
    const MOTORS_FIT_A_BYTE: () = assert!(1 <= N && N <= 8);

    /// An empty trace at tick 0, time 0: all pins low, all directions positive, drivers off, positions 0.
    pub fn new(mode: StepMode) -> Self {
        let () = Self::MOTORS_FIT_A_BYTE;
        Self {
            mode,
            blocks: Vec::new(),
            events: 0,
            stored: State::START,
            tick: 0,
            time: 0,
            period: 0,
        }
    }

    pub fn mode(&self) -> StepMode {
        self.mode
    }

    // ---- recording -------------------------------------------------------------------------------------------

    /// A tick begins at `time`, in counts since the trace began; what is recorded next happens in it. A time before
    /// the one last given counts as that one.
    #[inline]
    pub fn tick(&mut self, time: u64) {
        let time = time.max(self.time);
        self.period = time - self.time;
        self.time = time;
        self.tick += 1;
    }

    /// Time passes without a tick, as when the foreground switches the drivers.
    pub fn at(&mut self, time: u64) {
        self.time = time.max(self.time);
    }

    /// The step pins now stand at `levels`. Nothing is stored when they stood so already.
    #[inline]
    pub fn steps(&mut self, levels: u8) {
        if levels != self.stored.levels {
            self.store(Change::Levels(levels));
        }
    }

    /// The direction pins now stand at `mask`, bit set = negative.
    #[inline]
    pub fn directions(&mut self, mask: u8) {
        if mask != self.stored.directions {
            self.store(Change::Directions(mask));
        }
    }

    /// The drivers are now on or off.
    pub fn enable(&mut self, on: bool) {
        if on != self.stored.enabled {
            self.store(Change::Enable(on));
        }
    }

    fn store(&mut self, change: Change) {
        let full = |block: &Block<N>| block.bytes.len() + RECORD > BLOCK;
        if self.blocks.last().is_none_or(full) {
            self.blocks.push(Block {
                start: self.stored,
                bytes: Vec::with_capacity(BLOCK),
            });
        }
        let Some(block) = self.blocks.last_mut() else {
            return;
        };

        let ticks = self.tick - self.stored.tick;
        let counts = self.time - self.stored.time;
        let even = counts == ticks * self.stored.period;
        let levels = matches!(change, Change::Levels(_));
        // What the head of the event itself says of the ticks, and whether its long form is needed for that.
        let (told, long) = if even && levels && ticks <= LONG_TICKS {
            (ticks, ticks > SHORT_TICKS)
        } else {
            if ticks > 0 || counts > 0 {
                block.bytes.push(SYNC);
                for number in [ticks, counts, self.period] {
                    push_number(&mut block.bytes, number);
                }
                self.stored.period = self.period;
            }
            (0, false)
        };
        match change {
            Change::Levels(levels) if long => {
                block
                    .bytes
                    .extend([LONG | (told >> 8) as u8, told as u8, levels]);
            }
            Change::Levels(0) => block.bytes.push(FALL | told as u8),
            Change::Levels(levels) => block.bytes.extend([told as u8, levels]),
            Change::Directions(mask) => block.bytes.extend([DIRECTIONS, mask]),
            Change::Enable(on) => block.bytes.push(if on { ENABLE } else { DISABLE }),
        }
        self.stored.tick = self.tick;
        self.stored.time = self.time;
        self.stored.apply(self.mode, change);
        self.events += 1;
    }

    // ---- reading ---------------------------------------------------------------------------------------------

    /// Ticks begun so far.
    pub fn ticks(&self) -> u64 {
        self.tick
    }

    /// Time of the last tick [counts].
    pub fn end(&self) -> u64 {
        self.time
    }

    /// Number of events.
    pub fn len(&self) -> u64 {
        self.events
    }

    pub fn is_empty(&self) -> bool {
        self.events == 0
    }

    /// Bytes that the events take.
    pub fn stored_bytes(&self) -> usize {
        self.blocks.iter().map(|block| block.bytes.len()).sum()
    }

    /// Positions at the end [steps].
    pub fn positions(&self) -> [i64; N] {
        self.stored.positions
    }

    /// Every change, in the order in which it happened.
    pub fn events(&self) -> Events<'_, N> {
        self.events_after_block(0)
    }

    /// The state just before the first event at or after `time`, and the events from there on.
    pub fn events_from(&self, time: u64) -> (State<N>, Events<'_, N>) {
        // The last block that begins before `time` holds that event, or the block after it does.
        let block = self
            .blocks
            .partition_point(|block| block.start.time < time)
            .saturating_sub(1);
        let mut events = self.events_after_block(block);
        loop {
            let state = events.state;
            let here = events.clone();
            match events.next() {
                Some(event) if event.time < time => {}
                _ => return (state, here),
            }
        }
    }

    /// Positions at `time`, steps of that very instant included [steps].
    pub fn positions_at(&self, time: u64) -> [i64; N] {
        self.events_from(time.saturating_add(1)).0.positions
    }

    /// The first place where two traces part, with the event of each there; `None` when they are equal tick for tick.
    pub fn first_difference(&self, other: &Self) -> Option<(Option<Event>, Option<Event>)> {
        let (mut ours, mut theirs) = (self.events(), other.events());
        loop {
            match (ours.next(), theirs.next()) {
                (None, None) => return None,
                (a, b) if a == b => {}
                parted => return Some(parted),
            }
        }
    }

    fn events_after_block(&self, block: usize) -> Events<'_, N> {
        let mut blocks = self.blocks.get(block..).unwrap_or(&[]).iter();
        let first = blocks.next();
        Events {
            mode: self.mode,
            state: first.map_or(self.stored, |block| block.start),
            stepping: 0,
            bytes: first.map_or(&[], |block| &block.bytes),
            blocks,
        }
    }
}

/// The changes of a trace in order.
#[derive(Clone, Debug)]
pub struct Events<'a, const N: usize> {
    mode: StepMode,
    state: State<N>,
    stepping: u8,
    bytes: &'a [u8],
    blocks: std::slice::Iter<'a, Block<N>>,
}

impl<const N: usize> Events<'_, N> {
    /// The state after the event last returned.
    pub fn state(&self) -> &State<N> {
        &self.state
    }

    /// The motors that stepped by the event last returned.
    pub fn stepping(&self) -> u8 {
        self.stepping
    }

    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(*first)
    }

    fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        Some(number)
    }

    fn advance(&mut self, ticks: u64) {
        self.state.tick += ticks;
        self.state.time += ticks * self.state.period;
    }
}

impl<const N: usize> Iterator for Events<'_, N> {
    type Item = Event;

    #[inline]
    fn next(&mut self) -> Option<Event> {
        let change = loop {
            let Some(head) = self.byte() else {
                self.bytes = &self.blocks.next()?.bytes;
                continue;
            };
            match head {
                SYNC => {
                    self.state.tick += self.number()?;
                    self.state.time += self.number()?;
                    self.state.period = self.number()?;
                }
                DIRECTIONS => break Change::Directions(self.byte()?),
                DISABLE => break Change::Enable(false),
                ENABLE => break Change::Enable(true),
                long if long & LONG == LONG => {
                    let lower = self.byte()?;
                    self.advance(u64::from(long & !LONG) << 8 | u64::from(lower));
                    break Change::Levels(self.byte()?);
                }
                fall if fall & FALL != 0 => {
                    self.advance(u64::from(fall) & SHORT_TICKS);
                    break Change::Levels(0);
                }
                ticks => {
                    self.advance(u64::from(ticks) & SHORT_TICKS);
                    break Change::Levels(self.byte()?);
                }
            }
        };
        self.stepping = self.state.apply(self.mode, change);
        Some(Event {
            tick: self.state.tick,
            time: self.state.time,
            change,
        })
    }
}

/// Seven bits a byte, the least first, the top bit set while more follow: at most ten bytes, so that the longest
/// record, three numbers, their head and an event, has 33 bytes.
fn push_number(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}
