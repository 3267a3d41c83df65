//! The foreground pipe on one screen: [`Controller::poll`] moves data one hop at a time and never waits.
//!
//! Order of a poll: what the operator wants now (reset, status), answers out, segments in, then one target, and when no
//! path is running, one line. A sample is taken only when the look-ahead is full or the path is over, so the pulses of a
//! job do not depend on how fast the foreground runs.

use crate::board::Board;
use crate::cycles::drill_point::Cycle;
use crate::error::{Alarm, Error};
use crate::machines::drill_grinder::DrillGrinder;
use crate::path::{DrillPath, PathError, Scale};
use crate::planner::{Planner, Sample};
use crate::program::DrillWords;
use crate::program::words::Decimal;
use crate::protocol::report::{self, State};
use crate::protocol::system::{self, Command};
use crate::protocol::{LineReader, RealTime};
use crate::settings::{AXES, Settings};
use crate::stepper::interpolator::Instant;
use crate::stepper::{CountError, CountLine, Preset, SegmentSender, Segmenter, Shared};
use core::fmt::Write;
use fixed::types::I32F32;
use heapless::Deque;

/// Bytes of answers that can wait for the serial line.
const ANSWERS: usize = 2048;

/// The longest answer to one line: all settings.
const LONGEST_ANSWER: usize = 1400;

/// A ground flank shows a micrometre: the contour of a drill is kept to it, whatever is set for other paths [mm].
const DRILL_TOLERANCE: f32 = 0.001;

/// What moves the motors.
// The largest variant is the usual one, and there is one job at a time, not on the heap.
#[allow(clippy::large_enum_variant)]
enum Job {
    None,
    /// Walks a copy of the path before anything moves; the answer to the line waits for it.
    Check {
        path: DrillPath,
        walk: DrillPath,
    },
    Path(DrillPath),
    Counts(CountLine<AXES>),
}

/// Everything above the segment queue. One for a machine, driven by `poll` alone.
pub struct Controller<'a, B: Board> {
    pub board: B,
    settings: Settings,
    drill: DrillWords,
    flags: &'a RealTime,
    bytes: heapless::spsc::Consumer<'a, u8>,
    reader: LineReader,
    answers: Answers,
    job: Job,
    planner: Planner<AXES>,
    /// A sample that found no room in the queue.
    pending: Option<Sample<AXES>>,
    segmenter: Segmenter<AXES>,
    segments: SegmentSender<'a, AXES>,
    shared: &'a Shared,
    alarm: Option<Alarm>,
    /// A stop on its way: the interrupt has been told.
    stopping: Option<Alarm>,
    starved: u32,
    say_offset: bool,
    drivers_on: bool,
    started: bool,
}

impl<'a, B: Board> Controller<'a, B> {
    /// A controller at rest at position 0. `bytes` and `flags` come from the serial interrupt, `segments` and `shared` go
    /// to the step interrupt.
    pub fn new(
        board: B,
        bytes: heapless::spsc::Consumer<'a, u8>,
        flags: &'a RealTime,
        segments: SegmentSender<'a, AXES>,
        shared: &'a Shared,
    ) -> Self {
        let settings = Settings::default();
        // The defaults are within their own ranges; a test holds them to it.
        let limits = settings.limits(B::TICK_HZ).unwrap_or_default();
        Self {
            board,
            drill: DrillWords::default(),
            flags,
            bytes,
            reader: LineReader::default(),
            answers: Answers(Deque::new()),
            job: Job::None,
            planner: {
                let mut planner = Planner::new(limits, [0; AXES]);
                if let Some(path) = settings.path(DRILL_TOLERANCE) {
                    // At rest, so it is taken.
                    let _ = planner.set_path(path);
                }
                planner
            },
            pending: None,
            segmenter: Segmenter::new(settings.timing(B::TICK_HZ)),
            segments,
            shared,
            alarm: None,
            stopping: None,
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
        moved |= self.send_answers();
        if self.stopping.is_some() {
            return self.finish_stop() || moved;
        }
        self.watch_starvation();
        moved |= self.feed_segments();
        moved |= self.feed_planner();
        if matches!(self.job, Job::None) && self.planner.is_idle() && self.pending.is_none() {
            moved |= self.take_line();
        }
        moved
    }

    /// Whether everything that was asked for has been done and all motors rest.
    pub fn is_idle(&self) -> bool {
        self.state() != State::Run && self.bytes.is_empty() && self.answers.0.is_empty()
    }

    pub fn state(&self) -> State {
        if self.alarm.is_some() {
            State::Alarm
        } else if self.is_moving() {
            State::Run
        } else {
            State::Idle
        }
    }

    /// Steps put out by each motor once all that is queued has run.
    pub fn counts(&self) -> [i32; AXES] {
        self.segmenter.counts()
    }

    /// What the accumulators of the step interrupt hold then.
    pub fn accumulators(&self) -> [u32; AXES] {
        self.segmenter.accumulators()
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Strokes begun and strokes in all, while a drill is being ground.
    pub fn progress(&self) -> Option<(u32, u32)> {
        match &self.job {
            Job::Path(path) => Some(path.progress()),
            _ => None,
        }
    }

    fn is_moving(&self) -> bool {
        let at = self.shared.now();
        !matches!(self.job, Job::None)
            || !self.planner.is_idle()
            || self.pending.is_some()
            || !self.segments.is_empty()
            || at
                != (Instant {
                    sequence: self.segmenter.sent(),
                    remaining: 0,
                })
    }

    // ---- for a host that needs no text ----

    /// Takes all settings at once; refused while something moves.
    pub fn configure(&mut self, settings: Settings) -> Result<(), Error> {
        if self.is_moving() {
            return Err(Error::NotIdle);
        }
        let limits = settings.limits(B::TICK_HZ).map_err(|_| Error::ValueRange)?;
        self.segmenter.set_timing(settings.timing(B::TICK_HZ));
        self.board.set_step_mode(settings.step_mode());
        self.planner.set_limits(limits);
        if let Some(path) = settings.path(DRILL_TOLERANCE) {
            // At rest, as was asked above, so it is taken.
            let _ = self.planner.set_path(path);
        }
        self.settings = settings;
        Ok(())
    }

    /// Grinds; the whole path is walked before anything moves, and the line `$DRILL=RUN` that this stands for is answered
    /// when that is done.
    pub fn start_drill(
        &mut self,
        cycle: Cycle<f32>,
        machine: DrillGrinder<f32>,
    ) -> Result<(), Error> {
        self.may_move()?;
        let scale = self.scale();
        let path = DrillPath::new(cycle, machine, scale, scale.joints(&self.planner.end()));
        self.job = Job::Check {
            walk: path.clone(),
            path,
        };
        Ok(())
    }

    // ---- what cannot wait ----

    fn serve_real_time(&mut self) -> bool {
        let reset = self.flags.take(RealTime::RESET);
        if reset {
            self.reset();
        }
        if self.flags.take(RealTime::OVERFLOW) {
            self.reader.spoil();
        }
        let status = self.answers.room() >= 200 && self.flags.take(RealTime::STATUS);
        if status {
            self.report_status();
        }
        reset || status
    }

    /// Soft reset: everything queued is dropped. At rest the position stays trusted.
    fn reset(&mut self) {
        while self.bytes.dequeue().is_some() {}
        self.reader.clear();
        self.answers.0.clear();
        if self.stopping.is_some() {
            return;
        }
        if matches!(self.job, Job::Check { .. }) {
            self.job = Job::None;
        }
        if self.is_moving() {
            self.stop(Alarm::StoppedInMotion);
        } else {
            self.banner();
        }
    }

    /// Stops the motors at the next tick. The rest follows in [`Self::finish_stop`] once the interrupt has done so.
    fn stop(&mut self, alarm: Alarm) {
        self.shared.stop();
        self.stopping = Some(alarm);
        self.job = Job::None;
        self.pending = None;
    }

    /// Once the interrupt has stopped and dropped the queue: books and planner stand where the motors are.
    fn finish_stop(&mut self) -> bool {
        let Some(at) = self.shared.latched() else {
            return false;
        };
        if !self.shared.is_halted() || !self.segments.is_empty() {
            return false;
        }
        self.shared.release();
        if self.segmenter.recover(at, &mut self.segments).is_err() {
            return false;
        }
        self.planner.reset(self.segmenter.counts());
        if let Some(alarm) = self.stopping.take() {
            self.alarm = Some(alarm);
            self.answers.line(format_args!("ALARM:{}", alarm.number()));
        }
        self.banner();
        true
    }

    fn watch_starvation(&mut self) {
        let starved = self.shared.starved();
        if starved != self.starved {
            self.starved = starved;
            self.answers
                .line(format_args!("[MSG:Segment queue ran dry, position lost]"));
            self.stop(Alarm::StoppedInMotion);
        }
    }

    fn banner(&mut self) {
        self.say_offset = true;
        let _ = self.answers.write_str(report::BANNER);
        if let Some(fault) = self.board.clock_fault() {
            self.answers.line(format_args!(
                "[MSG:Clock fault: {fault}; $1012=1 allows motion]"
            ));
        }
        if self.alarm.is_some() {
            self.answers.line(format_args!("[MSG:'$H'|'$X' to unlock]"));
        }
    }

    fn report_status(&mut self) {
        // At rest whole steps are told, not the millionth of a step that an increment could not say.
        let whole = self.segmenter.counts().map(I32F32::from_num);
        let positions = match self.state() {
            State::Run => self.segmenter.positions_at(self.shared.now()),
            _ => None,
        }
        .unwrap_or(whole);
        let free = (
            self.planner.room(),
            self.bytes.capacity() - self.bytes.len(),
        );
        let with_offset = core::mem::take(&mut self.say_offset);
        let steps = self.settings.steps_per_unit();
        let state = self.state();
        let _ = report::status(
            &mut self.answers,
            state,
            &positions,
            &steps,
            free,
            with_offset,
        );
    }

    fn send_answers(&mut self) -> bool {
        let before = self.answers.room();
        while let Some(byte) = self.answers.0.front() {
            if !self.board.send(*byte) {
                break;
            }
            self.answers.0.pop_front();
        }
        self.answers.room() != before
    }

    // ---- motion ----

    /// Planner -> segmenter, or a line of counts, as far as the queue has room.
    fn feed_segments(&mut self) -> bool {
        let before = self.segmenter.sent();
        if let Job::Counts(line) = &mut self.job {
            if line.feed(&mut self.segmenter, &mut self.segments) {
                self.job = Job::None;
                self.planner.reset(self.segmenter.counts());
            }
        } else {
            let complete = !matches!(self.job, Job::Path(_));
            while complete || self.planner.is_full() || self.pending.is_some() {
                let Some(sample) = self.pending.take().or_else(|| self.planner.next()) else {
                    break;
                };
                let duration = B::TICK_HZ / crate::planner::SAMPLES_PER_SECOND;
                let sent = self.segmenter.advance(
                    &sample.position,
                    duration,
                    sample.last,
                    &mut self.segments,
                );
                if sent != Ok(true) {
                    // No room, or not there yet: the same target once more.
                    self.pending = Some(sample);
                }
                if sent.is_err() {
                    break;
                }
            }
        }
        self.segmenter.sent() != before
    }

    /// Path -> planner, one target at a time.
    fn feed_planner(&mut self) -> bool {
        match &mut self.job {
            Job::Path(path) if !self.planner.is_full() => match path.next() {
                Some(Ok(target)) => {
                    // There is room: it was asked for above.
                    let _ = self.planner.push(target.steps, target.duration);
                }
                // The whole path was walked before it began, so an error cannot come here.
                Some(Err(_)) | None => self.job = Job::None,
            },
            Job::Check { walk, .. } => match walk.next() {
                Some(Ok(_)) => {}
                Some(Err(error)) => {
                    self.job = Job::None;
                    let error = self.refuse_path(error);
                    self.answers.line(format_args!("error:{}", error.number()));
                }
                None => {
                    if let Job::Check { path, .. } = core::mem::replace(&mut self.job, Job::None) {
                        self.job = Job::Path(path);
                        self.switch_on();
                        self.answers.line(format_args!("ok"));
                    }
                }
            },
            _ => return false,
        }
        true
    }

    fn switch_on(&mut self) {
        if !self.drivers_on {
            self.drivers_on = true;
            self.board.enable_drivers(true);
        }
    }

    // ---- lines ----

    fn take_line(&mut self) -> bool {
        if self.answers.room() < LONGEST_ANSWER {
            return false;
        }
        let mut taken = false;
        while let Some(byte) = self.bytes.dequeue() {
            taken = true;
            let Some(line) = self.reader.push(byte) else {
                continue;
            };
            let done = match line {
                Ok(line) => system::parse(&line).and_then(|command| self.execute(command)),
                Err(_) => Err(Error::LineTooLong),
            };
            match done {
                Ok(Done::Now) => self.answers.line(format_args!("ok")),
                Ok(Done::Later) => {}
                Err(error) => self.answers.line(format_args!("error:{}", error.number())),
            }
            break;
        }
        taken
    }

    fn execute(&mut self, command: Command<'_>) -> Result<Done, Error> {
        match command {
            Command::Nothing => {}
            Command::Help => {
                self.answers.line(format_args!(
                    "[HLP:$$ $n=v $I $X $STAT $SEG= $DRILL $DRILL= $DRILL=RUN ? ctrl-x]"
                ));
            }
            Command::Settings => {
                for (number, value) in self.settings.all() {
                    self.answers
                        .line(format_args!("${number}={}", Decimal(value)));
                }
            }
            Command::Set { number, value } => self.set(number, value)?,
            Command::Info => {
                self.answers
                    .line(format_args!("[VER:1.1h.20261122:hexstep]"));
                let (blocks, bytes) = (crate::planner::BLOCKS, self.bytes.capacity());
                self.answers
                    .line(format_args!("[OPT:,{blocks},{bytes},{AXES},0]"));
                self.answers.line(format_args!("[AXS:6:XYZABC]"));
            }
            Command::Unlock => {
                if self.alarm.take().is_some() {
                    self.answers.line(format_args!("[MSG:Caution: Unlocked]"));
                }
            }
            Command::Counters => {
                self.answers
                    .line(format_args!("[MSG:starved {}]", self.shared.starved()));
            }
            Command::DrillShow => self.answers.line(format_args!("[DRILL:{}]", self.drill)),
            Command::DrillSet(words) => {
                let changed = self
                    .drill
                    .with(words)
                    .and_then(|words| words.build().map(|_| words));
                self.drill = changed.map_err(|refusal| {
                    self.answers.line(format_args!("[MSG:{refusal}]"));
                    Error::ValueRange
                })?;
            }
            Command::DrillRun => {
                let (cycle, machine) = self.drill.build().map_err(|refusal| {
                    self.answers.line(format_args!("[MSG:{refusal}]"));
                    Error::ValueRange
                })?;
                self.start_drill(cycle, machine)?;
                return Ok(Done::Later);
            }
            Command::Counts {
                counts,
                seconds,
                preset,
            } => {
                self.may_move()?;
                let line = self.count_line(counts, seconds, preset)?;
                self.job = Job::Counts(line);
                self.switch_on();
            }
        }
        Ok(Done::Now)
    }

    fn may_move(&mut self) -> Result<(), Error> {
        if self.alarm.is_some() {
            return Err(Error::Locked);
        }
        if self.board.clock_fault().is_some() && !self.settings.allows_internal_clock() {
            self.answers.line(format_args!(
                "[MSG:Clock fault: motion refused; $1012=1 allows it]"
            ));
            return Err(Error::SystemLocked);
        }
        Ok(())
    }

    fn set(&mut self, number: u16, value: f32) -> Result<(), Error> {
        if self.is_moving() {
            return Err(Error::NotIdle);
        }
        self.settings.set(number, value, B::TICK_HZ)?;
        self.segmenter.set_timing(self.settings.timing(B::TICK_HZ));
        self.board.set_step_mode(self.settings.step_mode());
        if let Ok(limits) = self.settings.limits(B::TICK_HZ) {
            self.planner.set_limits(limits);
        }
        Ok(())
    }

    fn scale(&self) -> Scale<AXES> {
        let (lower, upper) = self.settings.travel();
        Scale {
            steps_per_unit: crate::joints::Joints(self.settings.steps_per_joint_unit()),
            lower,
            upper,
        }
    }

    fn count_line(
        &mut self,
        counts: [i32; AXES],
        seconds: f64,
        preset: Preset,
    ) -> Result<CountLine<AXES>, Error> {
        let from = self.segmenter.counts();
        let timing = *self.segmenter.timing();
        if !(0.0..=1e6).contains(&seconds) {
            self.answers.line(format_args!(
                "[MSG:OutOfRange duration: expected 0 to 1000000 s]"
            ));
            return Err(Error::ValueRange);
        }
        let duration = (seconds * f64::from(B::TICK_HZ) + 0.5) as u64;
        let line = CountLine::new(counts, duration, preset, &timing, &from)
            .map_err(|error| self.refuse_counts(error))?;
        let end = core::array::from_fn(|i| from[i].wrapping_add(counts[i]));
        match self.scale().beyond(&end) {
            Some(joint) => Err(self.refuse_path(PathError::OutOfTravel { joint })),
            None => Ok(line),
        }
    }

    fn refuse_counts(&mut self, error: CountError) -> Error {
        let hz = u64::from(B::TICK_HZ);
        // Milliseconds, rounded up for a least and down for a most.
        match error {
            CountError::OutOfRange { motor, bound } => {
                self.answers.line(format_args!(
                    "[MSG:OutOfRange count {motor}: expected at most {bound} either way]"
                ));
                Error::ValueRange
            }
            CountError::Overflow { motor } => {
                self.answers.line(format_args!(
                    "[MSG:OutOfRange count {motor}: the step counter would overflow]"
                ));
                Error::ValueRange
            }
            CountError::TooFast { least } => {
                let ms = (least * 1000).div_ceil(hz);
                self.answers.line(format_args!(
                    "[MSG:TooFast duration: expected at least {ms} ms]"
                ));
                Error::StepRate
            }
            CountError::TooSlow { most } => {
                let ms = most * 1000 / hz;
                self.answers.line(format_args!(
                    "[MSG:TooSlow duration: expected at most {ms} ms]"
                ));
                Error::ValueRange
            }
        }
    }

    /// Says why a path cannot be run.
    fn refuse_path(&mut self, error: PathError) -> Error {
        match error {
            PathError::OutOfReach => self
                .answers
                .line(format_args!("[MSG:OutOfReach: no joints reach this pose]")),
            PathError::OutOfTravel { joint } => {
                let lower = self.settings.get(1040 + joint as u16).unwrap_or_default();
                let upper = self.settings.get(1050 + joint as u16).unwrap_or_default();
                self.answers.line(format_args!(
                    "[MSG:OutOfTravel joint {joint}: travel is {} to {}, see ${} and ${}]",
                    Decimal(lower),
                    Decimal(upper),
                    1040 + joint,
                    1050 + joint
                ));
            }
        }
        Error::BeyondTravel
    }
}

/// When a line is answered.
enum Done {
    Now,
    Later,
}

/// Text on its way out. What does not fit is cut off: every writer makes sure of its room first.
struct Answers(Deque<u8, ANSWERS>);

impl Answers {
    fn room(&self) -> usize {
        ANSWERS - self.0.len()
    }

    fn line(&mut self, text: core::fmt::Arguments<'_>) {
        let _ = self.write_fmt(text);
        let _ = self.write_str("\r\n");
    }
}

impl Write for Answers {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        text.bytes()
            .try_for_each(|byte| self.0.push_back(byte).map_err(|_| core::fmt::Error))
    }
}
