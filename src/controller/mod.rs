//! The foreground pipe on one screen: [`Controller::poll`] moves data one hop at a time and never waits.
//!
//! Order of a poll: what the operator wants now (reset, hold, override, status), answers out, segments in, then one
//! target, and when no path is running, one line. A sample is taken only when the look-ahead is full or the path is over,
//! so the pulses of a job do not depend on how fast the foreground runs.
//!
//! ```text
//!  Idle --job, stream, jog, probe--> Run --path over--> Idle
//!           hold |  ^ resume     \--stop (controlled)-> Idle, position kept
//!                v  |             \-reset, starvation-> Alarm, position lost
//!               Hold --reset at rest--> Idle, position kept
//! ```

mod answers;
mod lines;
mod motion;
mod process;
mod real_time;
mod trims;

pub use motion::{Probed, StreamError};

use crate::board::Board;
use crate::error::{Alarm, Error};
use crate::path::{DrillPath, Scale, Target};
use crate::planner::{PathSetting, Planner, Sample};
use crate::program::DrillWords;
use crate::program::processes::{NoProcesses, Processes};
use crate::protocol::cue::Cues;
use crate::protocol::report::State;
use crate::protocol::{LineReader, RealTime};
use crate::settings::{AXES, Settings};
use crate::shaper::Shaper;
use crate::stepper::interpolator::Instant;
use crate::stepper::{CountLine, SegmentSender, Segmenter, Shared};
use answers::Answers;
use heapless::Deque;
use trims::Trims;

/// What moves the motors.
// The largest variant is the usual one, and there is one job at a time, not on the heap.
#[allow(clippy::large_enum_variant)]
enum Job<const N: usize> {
    None,
    /// Walks a copy of the path before anything moves; the answer to the line waits for it.
    Check {
        path: DrillPath,
        walk: DrillPath,
        /// Least time so far [s].
        time: f32,
        /// It is not to be run.
        sim: bool,
    },
    Path(DrillPath),
    /// Targets come from outside, one by one.
    Stream {
        /// Samples are taken: the look-ahead has been full, or somebody asked for motion.
        begun: bool,
        /// A target that found no room; its line is answered when it has some.
        waiting: Option<Target<N>>,
    },
    /// Like a stream that has begun; any hold drops it.
    Jog,
    /// Points of a process come from outside, one by one.
    Process {
        /// As in a stream.
        begun: bool,
        /// The next point is wanted.
        waits: bool,
    },
    /// One move that ends at a contact.
    Probe,
    Counts(CountLine<N>),
}

/// Everything above the segment queue of N motors, with the processes P. One for a machine, driven by `poll` alone.
pub struct Controller<'a, B: Board, const N: usize = AXES, P: Processes<N> = NoProcesses> {
    pub board: B,
    settings: Settings<N>,
    drill: DrillWords,
    processes: P,
    flags: &'a RealTime,
    bytes: heapless::spsc::Consumer<'a, u8>,
    reader: LineReader,
    answers: Answers,
    job: Job<N>,
    /// What a step of each motor carries the tool, and how far the path under way may be left where its ways
    /// are not free; `None` before the first.
    contour: Option<PathSetting<N>>,
    /// The last target was at a feed: a rapid behind it leads out of the work.
    cuts: bool,
    /// Lent, because it is most of the RAM: built in its place, it is on the stack but once.
    planner: &'a mut Planner<N>,
    /// A sample that found no room in the queue.
    pending: Option<Sample<N>>,
    shaper: Shaper<N>,
    segmenter: Segmenter<N>,
    segments: SegmentSender<'a, N>,
    shared: &'a Shared,
    /// Number of the last segment of each millisecond in the queue.
    ahead: Deque<u32, { motion::LEAD }>,
    alarm: Option<Alarm>,
    /// A stop on its way: the interrupt has been told.
    stopping: Option<Alarm>,
    /// A reset on its way: the banner comes when the motors rest on whole steps.
    resetting: bool,
    cues: Cues<N>,
    trims: Trims<N>,
    probed: Option<Probed<N>>,
    /// The probe has touched; where is not known yet.
    touching: bool,
    /// Overrides in force [percent].
    overrides: (u8, u8),
    say_overrides: bool,
    starved: u32,
    say_offset: bool,
    drivers_on: bool,
    started: bool,
}

impl<'a, B: Board, const N: usize, P: Processes<N>> Controller<'a, B, N, P> {
    /// A controller at rest at position 0. `planner` may be anything, it begins anew; `bytes` and
    /// `flags` come from the serial interrupt, `segments` and `shared` go to the step interrupt.
    pub fn new(
        board: B,
        planner: &'a mut Planner<N>,
        bytes: heapless::spsc::Consumer<'a, u8>,
        flags: &'a RealTime,
        segments: SegmentSender<'a, N>,
        shared: &'a Shared,
    ) -> Self {
        let processes = P::default();
        let mut settings = Settings::<N>::default();
        settings.turn_all(processes.all_turn());
        // The defaults are within their own ranges; a test holds them to it.
        planner.reset([0; N]);
        // At most eight, as the settings have it.
        flags.set_motors(N as u8);
        planner.set_limits(settings.limits(B::TICK_HZ).unwrap_or_default());
        Self {
            board,
            drill: DrillWords::default(),
            processes,
            flags,
            bytes,
            reader: LineReader::default(),
            answers: Answers::new(),
            job: Job::None,
            contour: None,
            cuts: false,
            planner,
            pending: None,
            shaper: Shaper::new(),
            segmenter: Segmenter::new(settings.timing(B::TICK_HZ)),
            segments,
            shared,
            ahead: Deque::new(),
            alarm: None,
            stopping: None,
            resetting: false,
            cues: Cues::new(),
            trims: Trims::new(),
            probed: None,
            touching: false,
            overrides: (100, 100),
            say_overrides: true,
            starved: 0,
            say_offset: true,
            drivers_on: false,
            started: false,
            settings,
        }
    }

    /// Moves data one hop; whether anything moved. Call it again and again; it never waits.
    pub fn poll(&mut self) -> bool {
        if !self.started {
            self.started = true;
            self.banner();
        }
        let mut moved = self.serve_real_time();
        moved |= self.answers.send(|byte| self.board.send(byte));
        if self.stopping.is_some() {
            return self.finish_stop() || moved;
        }
        self.watch_starvation();
        moved |= self.feed_segments();
        moved |= self.feed_planner();
        moved |= self.finish_motion();
        if self.takes_lines() {
            moved |= self.take_line();
        }
        moved
    }

    /// Whether there is nothing to do until somebody asks for more: all done and at rest, held at rest, or with a stream
    /// that has not begun.
    pub fn is_idle(&self) -> bool {
        let waits = match self.state() {
            State::Run => !self.waits_for_targets(),
            State::Jog | State::Hold { moving: true } => true,
            // Lines wait for the resume.
            State::Hold { moving: false } => !self.cues.is_empty(),
            State::Idle | State::Alarm => !self.bytes.is_empty(),
        };
        !waits && self.answers.is_empty()
    }

    pub fn state(&self) -> State {
        if self.alarm.is_some() {
            State::Alarm
        } else if self.planner.is_held() {
            State::Hold {
                moving: !self.planner.is_at_rest()
                    || !self.shaper.is_settled()
                    || !self.motors_rest(),
            }
        } else if !self.is_moving() {
            State::Idle
        } else if matches!(self.job, Job::Jog) {
            State::Jog
        } else {
            State::Run
        }
    }

    fn waits_for_targets(&self) -> bool {
        let waits = matches!(
            self.job,
            Job::Stream {
                begun: false,
                waiting: None
            } | Job::Process {
                begun: false,
                waits: true
            }
        );
        waits && !self.planner.is_full() && self.motors_rest() && self.bytes.is_empty()
    }

    /// Steps put out by each motor once all that is queued has run.
    pub fn counts(&self) -> [i32; N] {
        self.segmenter.counts()
    }

    /// What the accumulators of the step interrupt hold then.
    pub fn accumulators(&self) -> [u32; N] {
        self.segmenter.accumulators()
    }

    pub fn settings(&self) -> &Settings<N> {
        &self.settings
    }

    pub fn planner(&self) -> &Planner<N> {
        self.planner
    }

    /// Strokes begun and strokes in all, while a drill is being ground.
    pub fn progress(&self) -> Option<(u32, u32)> {
        match &self.job {
            Job::Path(path) => Some(path.progress()),
            _ => None,
        }
    }

    fn is_moving(&self) -> bool {
        !matches!(self.job, Job::None)
            || !self.planner.is_idle()
            || self.pending.is_some()
            || !self.shaper.is_settled()
            || !self.motors_rest()
    }

    /// Whether the step interrupt has run all that it was given.
    fn motors_rest(&self) -> bool {
        let end = Instant {
            sequence: self.segmenter.sent(),
            remaining: 0,
        };
        self.segments.is_empty() && self.shared.now() == end
    }

    /// Takes all settings at once; refused while something moves.
    pub fn configure(&mut self, settings: Settings<N>) -> Result<(), Error> {
        if self.is_moving() || self.planner.is_held() {
            return Err(Error::NotIdle);
        }
        let limits = settings.limits(B::TICK_HZ).map_err(|_| Error::ValueRange)?;
        let shapers = settings.shapers().map_err(|_| Error::ValueRange)?;
        self.shaper.set(shapers);
        self.segmenter.set_timing(settings.timing(B::TICK_HZ));
        self.board.set_step_mode(settings.step_mode());
        self.planner.set_limits(limits);
        // At rest, as was asked above, and within the table's ranges.
        let _ = self
            .planner
            .set_trim_limits(settings.trim_bound(), settings.trim_share());
        self.settings = settings;
        Ok(())
    }

    fn scale(&self) -> Scale<N> {
        let (lower, upper) = self.settings.travel();
        Scale {
            steps_per_unit: crate::joints::Joints(self.settings.steps_per_joint_unit()),
            lower,
            upper,
        }
    }
}
