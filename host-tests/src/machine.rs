//! The whole machine in memory: the same controller and step interrupt as on the target, with a serial line to talk to
//! and a trace of the pins.
//!
//! ```text
//! say("$DRILL=RUN") -> Receiver -> Controller::poll -> queue -> Interpolator::tick -> pins -> Trace
//!                                        |
//!                      heard()  <- answers
//! ```
//!
//! Time is that of the step timer. The foreground polls until it has nothing left to move, then one tick passes; how the
//! two are interleaved cannot change a pulse of a job, only when it begins.

use crate::pins::Pin;
use crate::trace::{self, Trace};
use hexstep::board::Board;
use hexstep::controller::{Controller, StreamError};
use hexstep::error::Error;
use hexstep::path::Target;
use hexstep::planner::{Limits, Planner};
use hexstep::program::processes::AllProcesses;
use hexstep::protocol::{ByteQueue, RealTime, Receiver};
use hexstep::settings::AXES;
use hexstep::stepper::{Interpolator, PinPort, SegmentQueue, Shared, StepMode, StepTimer, Timing};
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

/// Counts per second of the step timer: the core clock of the STM32F407.
pub const TICK_HZ: u32 = trace::TICK_HZ as u32;

/// What the foreground and the step interrupt of the memory board share.
struct Wires {
    heard: RefCell<VecDeque<u8>>,
    drivers: Cell<bool>,
    mode: Cell<StepMode>,
    /// Levels of the step pins and of the direction pins.
    levels: Cell<u8>,
    directions: Cell<u8>,
}

/// The foreground's side of the memory board.
pub struct MemoryBoard<'a>(&'a Wires);

impl Board for MemoryBoard<'_> {
    const TICK_HZ: u32 = TICK_HZ;

    fn send(&mut self, byte: u8) -> bool {
        self.0.heard.borrow_mut().push_back(byte);
        true
    }
    fn enable_drivers(&mut self, on: bool) {
        self.0.drivers.set(on);
    }
    fn set_step_mode(&mut self, mode: StepMode) {
        self.0.mode.set(mode);
    }
}

/// A controller of the memory board: it has room for all processes.
pub type MemoryController<'a, const N: usize> = Controller<'a, MemoryBoard<'a>, N, AllProcesses>;

/// What a stream is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StreamItem<const N: usize = AXES> {
    Target(Target<N>),
    /// A standstill behind what came before [s].
    Dwell(f32),
}

/// Why a stream has not run, or not to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    Start(Error),
    /// The item behind so many targets was not taken.
    Item(u64, StreamError),
}

/// A SysTick of memory: a period written in the handler counts from the wrap after the next one.
struct SysTick {
    now: u64,
    running: u32,
    reload: u32,
}

impl StepTimer for SysTick {
    #[inline(always)]
    fn set_period(&mut self, counts: u32) {
        self.reload = counts;
    }
}

/// Step and direction pins of all motors behind `embedded_hal`, as any other board has them.
type Pins<'a, const N: usize> = PinPort<Pin<'a>, Pin<'a>, N>;

/// A controller with its N motors. Made by [`with`] and [`with_motors`].
pub struct Machine<'a, const N: usize = AXES> {
    pub controller: MemoryController<'a, N>,
    interpolator: Interpolator<'a, N>,
    receiver: Receiver<'a>,
    shared: &'a Shared,
    flags: &'a RealTime,
    wires: &'a Wires,
    pins: Pins<'a, N>,
    timer: SysTick,
    mode: StepMode,
    /// What the pins did since it was last taken.
    pub trace: Trace<N>,
}

/// Builds a machine of six motors at rest at position 0, gives it to `body`, and takes it apart again.
pub fn with<R>(body: impl FnOnce(&mut Machine<'_>) -> R) -> R {
    with_motors(body)
}

/// The same with N motors: six, or eight for a two-sided machine.
pub fn with_motors<const N: usize, R>(body: impl FnOnce(&mut Machine<'_, N>) -> R) -> R {
    let (mut segments, mut bytes) = (SegmentQueue::new(), ByteQueue::new());
    let (shared, flags) = (Shared::new(), RealTime::new());
    let wires = Wires {
        heard: RefCell::default(),
        drivers: Cell::new(false),
        mode: Cell::new(StepMode::Pulse),
        levels: Cell::new(0),
        directions: Cell::new(0),
    };
    let (segment_sender, segment_receiver) = segments.split();
    let (byte_sender, byte_receiver) = bytes.split();
    let mut planner = Planner::new(Limits::default(), [0; N]);
    let rest = TICK_HZ / Timing::FLOOR_HZ;
    let mut machine = Machine {
        controller: Controller::new(
            MemoryBoard(&wires),
            &mut planner,
            byte_receiver,
            &flags,
            segment_sender,
            &shared,
        ),
        interpolator: Interpolator::new(segment_receiver, &shared, StepMode::Pulse, rest),
        receiver: Receiver::new(byte_sender, &flags),
        shared: &shared,
        flags: &flags,
        wires: &wires,
        pins: PinPort {
            steps: Pin::all(&wires.levels),
            directions: Pin::all(&wires.directions),
        },
        timer: SysTick {
            now: 0,
            running: rest,
            reload: rest,
        },
        mode: StepMode::Pulse,
        trace: Trace::new(StepMode::Pulse),
    };
    body(&mut machine)
}

impl<const N: usize> Machine<'_, N> {
    /// Puts bytes on the serial line, as they are.
    pub fn put(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.receiver.receive(*byte);
        }
    }

    /// Puts a line on the serial line.
    pub fn say(&mut self, line: &str) {
        self.put(line.as_bytes());
        self.put(b"\n");
    }

    /// The probe touches: what the interrupt of its pin does.
    pub fn touch(&mut self) {
        self.shared.latch();
        self.flags.raise(RealTime::TOUCH);
    }

    /// Everything answered since it was last asked for.
    pub fn heard(&mut self) -> String {
        let bytes: Vec<u8> = self.wires.heard.borrow_mut().drain(..).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }

    /// Says a line and waits until it is answered and the motors rest; the answer.
    pub fn ask(&mut self, line: &str) -> String {
        self.say(line);
        self.run_to_rest();
        self.heard()
    }

    /// One tick of the step timer, the foreground running first.
    pub fn step(&mut self) {
        self.controller.poll();
        self.tick();
    }

    /// Runs for so many ticks with the foreground busy elsewhere.
    pub fn neglect(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.tick();
        }
    }

    /// Runs for so many ticks.
    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.step();
        }
    }

    /// Runs until everything asked for is done. The foreground works until it has nothing left to move, then the motors
    /// run for a while that is shorter than what the queue holds.
    pub fn run_to_rest(&mut self) {
        self.run_to_rest_watched(|_| {});
    }

    /// The same, with a look at the controller whenever it has nothing left to move.
    pub fn run_to_rest_watched(&mut self, mut watch: impl FnMut(&MemoryController<'_, N>)) {
        loop {
            while self.controller.poll() {}
            watch(&self.controller);
            if self.controller.is_idle() {
                return;
            }
            // A segment has 40 ticks or more, but around a reversal, and the foreground stays a few of them ahead.
            for _ in 0..80 {
                self.tick();
            }
        }
    }

    /// Starts a stream, feeds it with `items` as they find room, and runs to rest; the number of targets taken.
    ///
    /// # Errors
    /// The refusal of the stream, or of an item; what came before has run.
    pub fn stream(
        &mut self,
        items: impl IntoIterator<Item = StreamItem<N>>,
        mut watch: impl FnMut(u64),
    ) -> Result<u64, Refusal> {
        self.controller.start_stream().map_err(Refusal::Start)?;
        let mut taken = 0;
        let mut refused = Ok(());
        'all: for item in items {
            loop {
                let pushed = match &item {
                    StreamItem::Target(target) => self.controller.push(target),
                    StreamItem::Dwell(duration) => self.controller.dwell(*duration).map(|()| true),
                };
                match pushed {
                    Ok(true) => break,
                    Ok(false) => {
                        while self.controller.poll() {}
                        // A millisecond at the floor of the tick rate: behind a hold the queue may hold but two.
                        for _ in 0..Timing::FLOOR_HZ / 1000 {
                            self.tick();
                        }
                        watch(taken);
                    }
                    Err(error) => {
                        refused = Err(Refusal::Item(taken, error));
                        break 'all;
                    }
                }
            }
            if matches!(item, StreamItem::Target(_)) {
                taken += 1;
            }
        }
        self.controller.end_stream();
        self.run_to_rest();
        refused.map(|()| taken)
    }

    /// Ticks at which the queue ran dry in motion.
    pub fn starved(&self) -> u32 {
        self.shared.starved()
    }

    /// Number of the segment that runs, or ran last (wraps).
    pub fn segment(&self) -> u32 {
        self.shared.now().sequence
    }

    /// Time since the machine was built [timer counts].
    pub fn now(&self) -> u64 {
        self.timer.now
    }

    /// Takes the trace out; a new one begins with the pins as they are.
    pub fn take_trace(&mut self) -> Trace<N> {
        let mut fresh = Trace::new(self.mode);
        fresh.at(self.timer.now);
        fresh.steps(self.wires.levels.get());
        fresh.directions(self.wires.directions.get());
        fresh.enable(self.wires.drivers.get());
        std::mem::replace(&mut self.trace, fresh)
    }

    #[inline(always)]
    fn tick(&mut self) {
        self.timer.now += u64::from(self.timer.running);
        self.timer.running = self.timer.reload;
        let mode = self.wires.mode.get();
        if mode != self.mode {
            self.mode = mode;
            self.interpolator.set_mode(mode);
            self.trace = Trace::new(mode);
            self.trace.at(self.timer.now);
        }
        self.trace.tick(self.timer.now);
        self.trace.enable(self.wires.drivers.get());
        self.interpolator.tick(&mut self.pins, &mut self.timer);
        // In this order on the pins, too: the steps of the segment before come first.
        self.trace.steps(self.wires.levels.get());
        self.trace.directions(self.wires.directions.get());
    }
}
