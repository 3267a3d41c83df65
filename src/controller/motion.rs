//! Jobs, streams, jogs and probe moves -> planner -> shaper -> segmenter -> queue.

use super::{Controller, Job};
use crate::board::Board;
use crate::cycles::drill_point::Cycle;
use crate::error::{Alarm, Error};
use crate::machines::drill_grinder::DrillGrinder;
use crate::math::Real;
use crate::path::{DrillPath, Target};
use crate::planner::{PathSetting, PushError, SAMPLES_PER_SECOND, Sample};
use crate::program::processes::Processes;
use crate::program::words::Decimal;
use crate::protocol::cue::{Action, Cue, CueError};
use crate::settings::AXES;
use crate::shaper::design::RATE;
use fixed::types::I32F32;

// The planner's samples are the shaper's.
const _: () = assert!(RATE == SAMPLES_PER_SECOND);

/// A ground flank shows a micrometre: the contour of a drill is kept to it, whatever is set for other paths [mm].
const DRILL_TOLERANCE: f32 = 0.001;

/// Milliseconds that the queue is kept ahead of the motors, the running one included: so much later a hold or an
/// override shows. The foreground may be busy for one less.
pub(super) const LEAD: usize = 5;

/// A stream under way whose input pauses runs on, towards the standstill that its plan ends in, before the queue holds
/// less than this [ms].
const LOW_WATER: usize = 4;

/// How a probe move ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probed<const N: usize = AXES> {
    /// Contact: where all motors were in the tick behind it [steps].
    Contact([I32F32; N]),
    /// The target was reached without contact.
    Missed,
}

/// Why a target was not taken; nothing has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StreamError {
    /// No stream has been started, or it has been stopped.
    NotStarted,
    /// This joint would leave its travel.
    OutOfTravel { joint: usize },
    /// Expected a duration that is finite and not negative.
    Duration,
    /// A way of more than 2^31 - 1 steps.
    TooLong,
}

impl<B: Board, const N: usize, P: Processes<N>> Controller<'_, B, N, P> {
    // ---- what can be asked for ----

    /// Grinds; the whole path is walked before anything moves, and the line `$DRILL=RUN` that this stands for is answered
    /// when that is done.
    pub fn start_drill(
        &mut self,
        cycle: Cycle<f32>,
        machine: DrillGrinder<f32>,
    ) -> Result<(), Error> {
        self.walk_drill(cycle, machine, false)
    }

    /// The same, or with `sim` no more than the walk: its least time is told.
    pub(super) fn walk_drill(
        &mut self,
        cycle: Cycle<f32>,
        machine: DrillGrinder<f32>,
        sim: bool,
    ) -> Result<(), Error> {
        self.may_move()?;
        // The drill grinder is the first six motors: three that slide and three that turn.
        let scale = self.scale().first();
        let Some(scale) = scale.filter(|_| self.settings.has_drill_grinder()) else {
            self.answers.line(format_args!(
                "[MSG:Drill: expected three motors that slide and three that turn, see $376]"
            ));
            return Err(Error::ValueRange);
        };
        self.begin(DRILL_TOLERANCE);
        let end = self.planner.end_steps();
        let near = scale.joints(&core::array::from_fn(|i| end.get(i).copied().unwrap_or(0)));
        let path = DrillPath::new(cycle, machine, scale, near);
        self.job = Job::Check {
            walk: path.clone(),
            path,
            time: 0.0,
            sim,
        };
        Ok(())
    }

    /// Starts a path of joint targets that come one by one through [`Self::push`]. Motion begins when the look-ahead is
    /// full, when [`Self::end_stream`] is called, or on [`Self::resume`].
    pub fn start_stream(&mut self) -> Result<(), Error> {
        self.may_move()?;
        self.begin(f32::INFINITY);
        self.switch_on();
        self.job = Job::Stream {
            begun: false,
            waiting: None,
        };
        Ok(())
    }

    /// One more target of the stream or the jog; `Ok(false)` when there is no room now or a hold is in force: offer it
    /// again later.
    pub fn push(&mut self, target: &Target<N>) -> Result<bool, StreamError> {
        if !matches!(self.job, Job::Stream { waiting: None, .. } | Job::Jog) {
            return Err(StreamError::NotStarted);
        }
        if let Some(joint) = self.scale().beyond(&target.steps) {
            return Err(StreamError::OutOfTravel { joint });
        }
        if self.planner.is_full() || self.planner.is_held() {
            return Ok(false);
        }
        self.push_target(target)
    }

    /// A standstill of `duration` [s] behind what the stream has so far.
    pub fn dwell(&mut self, duration: f32) -> Result<(), StreamError> {
        if !matches!(self.job, Job::Stream { waiting: None, .. }) {
            return Err(StreamError::NotStarted);
        }
        self.planner
            .dwell(duration)
            .map_err(|_| StreamError::Duration)
    }

    /// The stream is complete: what has been pushed runs to its end.
    pub fn end_stream(&mut self) {
        if matches!(self.job, Job::Stream { .. }) {
            self.job = Job::None;
        }
    }

    /// A jog: moves at once, ignores overrides, and ends within its braking distance on [`Self::stop_motion`] or a hold.
    /// More jogs may be pushed while it runs.
    pub fn jog(&mut self, target: &Target<N>) -> Result<bool, Error> {
        let begins = !matches!(self.job, Job::Jog);
        if begins {
            self.may_move()?;
        }
        if self.scale().beyond(&target.steps).is_some() {
            return Err(Error::BeyondTravel);
        }
        if begins {
            self.begin(f32::INFINITY);
            self.switch_on();
            self.job = Job::Jog;
            self.apply_overrides();
        }
        self.push(target).map_err(|_| Error::ValueRange)
    }

    /// Moves towards `target` until the probe touches: the motors slow down along the path, and [`Self::probed`] tells
    /// where they were at contact. The pin's interrupt calls [`Shared::latch`](crate::stepper::Shared::latch) and raises
    /// [`RealTime::TOUCH`](crate::protocol::RealTime::TOUCH).
    pub fn probe(&mut self, target: &Target<N>) -> Result<(), Error> {
        self.may_move()?;
        if self.scale().beyond(&target.steps).is_some() || target.steps == self.planner.end() {
            return Err(Error::InvalidTarget);
        }
        self.probed = None;
        if self.board.touches() {
            self.raise(Alarm::ProbeTouchesAtStart);
            return Err(Error::Locked);
        }
        self.begin(f32::INFINITY);
        self.switch_on();
        self.job = Job::Probe;
        self.apply_overrides();
        self.push_target(target)
            .map(|_| ())
            .map_err(|_| Error::ValueRange)
    }

    /// How the last probe move ended; `None` before the first, and while one is under way.
    pub fn probed(&self) -> Option<Probed<N>> {
        self.probed.filter(|_| !matches!(self.job, Job::Probe))
    }

    /// Controlled stop: slows down along the path, drops the rest of it and rests on whole steps; the position stays
    /// known. A line of counts is no path; it runs to its end.
    pub fn stop_motion(&mut self) {
        match self.job {
            Job::Counts(_) => return,
            // Ends by itself, with what it has found.
            Job::Probe | Job::Jog => {}
            Job::Process { .. } => self.end_process(),
            _ => self.job = Job::None,
        }
        if !self.planner.is_idle() || self.planner.is_held() {
            self.planner.stop();
        }
    }

    /// Offset of a motor [steps], reached at its own rate while programs run. Returns what was taken, within the bound of
    /// `$1030`; 0 while `$1013` gives trims no share of the limits.
    pub fn set_trim(&mut self, motor: usize, steps: i32) -> i32 {
        self.planner.set_trim(motor, steps)
    }

    /// Adds what is to happen at a given millisecond of the next motion. Only at rest.
    pub fn add_cue(&mut self, cue: Cue) -> Result<(), CueError> {
        if self.is_moving() {
            return Err(CueError::Order);
        }
        self.cues.add(cue)
    }

    // ---- how it is done ----

    /// Before a motion: how far its contour may leave the path [mm].
    fn begin(&mut self, most: f32) {
        self.contour = self.settings.path(most);
        self.cuts = false;
    }

    pub(super) fn push_target(&mut self, target: &Target<N>) -> Result<bool, StreamError> {
        let cuts = target.duration > 0.0;
        if let Some(contour) = &self.contour {
            // Out of the work to the end, then elsewhere: else a short way out would be no more than a part of the next one.
            let most = if self.cuts || cuts { 0.0 } else { target.free };
            let free = Real::min(most, self.settings.rapid_tolerance());
            let tolerance = Real::max(free, contour.tolerance());
            if let Ok(path) = PathSetting::new(*contour.weight(), tolerance) {
                // Its weights change at rest alone, so it is taken.
                let _ = self.planner.set_path(path);
            }
        }
        match self.planner.push(target.steps, target.duration) {
            Ok(()) => {
                self.cuts = cuts;
                Ok(true)
            }
            Err(PushError::Full) => Ok(false),
            Err(PushError::Stopping | PushError::Lost) => Err(StreamError::NotStarted),
            Err(PushError::Duration) => Err(StreamError::Duration),
            Err(PushError::TooLong) => Err(StreamError::TooLong),
        }
    }

    /// The planner's overrides: those in force, but none for jogs and probe moves.
    pub(super) fn apply_overrides(&mut self) {
        let (feed, rapid) = match self.job {
            Job::Jog | Job::Probe => (100, 100),
            _ => self.overrides,
        };
        // Within their ranges: the receiver holds them there.
        let _ = self.planner.set_feed_override(f32::from(feed) / 100.0);
        let _ = self.planner.set_rapid_override(f32::from(rapid) / 100.0);
    }

    /// The probe's pin has changed: its interrupt has asked for the positions.
    pub(super) fn touched(&mut self) {
        if matches!(self.job, Job::Probe) && self.probed.is_none() {
            self.touching = true;
            self.planner.stop();
        }
    }

    /// Planner -> shaper -> segmenter, or a line of counts, as far as the queue has room.
    pub(super) fn feed_segments(&mut self) -> bool {
        let before = self.segmenter.sent();
        if let Job::Counts(line) = &mut self.job {
            if line.feed(&mut self.segmenter, &mut self.segments) {
                self.job = Job::None;
                self.planner.reset(self.segmenter.counts());
                self.restart_trims();
            }
        } else {
            while self.lead() < LEAD {
                let Some(sample) = self.pending.take().or_else(|| self.take_sample()) else {
                    break;
                };
                let sent = self.segmenter.advance(
                    &sample.position,
                    B::TICK_HZ / SAMPLES_PER_SECOND,
                    sample.last,
                    &mut self.segments,
                );
                if sent.is_ok() {
                    // There is room: the lead is below its bound.
                    let _ = self.ahead.push_back(self.segmenter.sent());
                }
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

    /// Milliseconds in the queue, the running one included.
    fn lead(&mut self) -> usize {
        let now = self.shared.now();
        while let Some(end) = self.ahead.front() {
            // Numbers wrap; those in the queue are close to each other.
            let left = end.wrapping_sub(now.sequence).cast_signed();
            if left > 0 || left == 0 && now.remaining > 0 {
                break;
            }
            self.ahead.pop_front();
        }
        self.ahead.len()
    }

    /// The next millisecond, when it may be taken: with all of the look-ahead known, or none of it to come.
    fn take_sample(&mut self) -> Option<Sample<N>> {
        let flows = match &self.job {
            Job::Path(_) => self.planner.is_full(),
            Job::Stream { begun, .. } | Job::Process { begun, .. } => {
                self.planner.is_full()
                    || self.planner.is_held()
                    || *begun && self.ahead.len() < LOW_WATER
            }
            _ => true,
        };
        let halts = self.planner.is_held() || self.planner.is_stopping();
        if !flows || self.planner.is_idle() && !halts && self.shaper.is_settled() {
            return None;
        }
        while let Some(action) = self.cues.due() {
            self.act(action);
        }
        self.shaper.begin_at(&self.planner.position());
        let sample = self.planner.next();
        // Not at rest: a sensor's noise would never let the motors come to it.
        if sample.is_some() && self.planner.is_on_its_way() {
            self.tick_trims();
        }
        let sample = self.shaped(sample);
        let held = self.planner.is_held();
        if let Job::Stream { begun, .. } | Job::Process { begun, .. } = &mut self.job {
            *begun = sample.is_some() || *begun && held;
        }
        let sample = sample.or_else(|| {
            // In a hold, time goes on towards the cue that ends it.
            (held && !self.cues.is_empty()).then(|| Sample {
                position: self.planner.position(),
                last: true,
            })
        });
        if sample.is_some() {
            self.cues.tick();
        }
        sample
    }

    /// The shaped sample; behind the planner's last one, as many as the shaper takes to come to rest there.
    fn shaped(&mut self, sample: Option<Sample<N>>) -> Option<Sample<N>> {
        let Sample { position, last } = match sample {
            Some(sample) => sample,
            None if self.shaper.is_settled() => return None,
            None => Sample {
                position: self.planner.position(),
                last: true,
            },
        };
        let position = self.shaper.push(&position);
        Some(Sample {
            position,
            last: last && self.shaper.is_settled(),
        })
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Hold => self.hold(),
            Action::Resume => self.resume(),
            // Both within their ranges: a cue has been looked at when it was taken.
            Action::Feed(factor) => {
                let _ = self.planner.set_feed_override(factor);
            }
            Action::Rapid(factor) => {
                let _ = self.planner.set_rapid_override(factor);
            }
            Action::Trim { motor, steps } => {
                self.set_trim(motor, steps);
            }
            Action::Stop => self.stop_motion(),
        }
    }

    /// Path -> planner, one target at a time.
    pub(super) fn feed_planner(&mut self) -> bool {
        match &mut self.job {
            Job::Path(path) if !self.planner.is_full() => match path.next() {
                Some(Ok(target)) => {
                    let target = self.on_all_motors(&target);
                    // There is room, and the path was walked before it began.
                    let _ = self.push_target(&target);
                }
                // The whole path was walked before it began, so an error cannot come here.
                Some(Err(_)) | None => self.job = Job::None,
            },
            Job::Stream { waiting, .. } if !self.planner.is_full() && !self.planner.is_held() => {
                let Some(target) = waiting.take() else {
                    return false;
                };
                let pushed = self.push_target(&target);
                self.answer_push(pushed);
            }
            Job::Process { .. } => return self.feed_process(),
            Job::Check { walk, time, .. } => match walk.next() {
                Some(Ok(target)) => *time += target.duration,
                Some(Err(error)) => {
                    self.job = Job::None;
                    let error = self.refuse_path(error);
                    self.answers.line(format_args!("error:{}", error.number()));
                }
                None => {
                    let job = core::mem::replace(&mut self.job, Job::None);
                    if let Job::Check {
                        path, time, sim, ..
                    } = job
                    {
                        if sim {
                            self.answers.line(format_args!(
                                "[MSG:Simulated: {} strokes, {} s at least, rapids not counted]",
                                path.progress().1,
                                Decimal(time)
                            ));
                        } else {
                            self.job = Job::Path(path);
                            self.switch_on();
                        }
                        self.answers.line(format_args!("ok"));
                    }
                }
            },
            _ => return false,
        }
        true
    }

    /// What is to be said and put back when a motion has ended; the contact of a probe as soon as it is known.
    pub(super) fn finish_motion(&mut self) -> bool {
        if self.touching
            && let Some(at) = self.shared.latched()
        {
            self.touching = false;
            self.probed = self.segmenter.positions_at(at).map(Probed::Contact);
        }
        if self.planner.is_stopping() {
            return false;
        }
        let open = matches!(
            self.job,
            Job::Check { .. }
                | Job::Path(_)
                | Job::Stream { .. }
                | Job::Process { .. }
                | Job::Counts(_)
        );
        let gives = !self.planner.is_idle() || !self.shaper.is_settled() || self.pending.is_some();
        if open || gives || self.planner.is_held() {
            return false;
        }
        if !self.motors_rest() {
            return false;
        }
        let ended = !matches!(self.job, Job::None);
        if ended {
            if matches!(self.job, Job::Probe) {
                self.probed = self.probed.or(Some(Probed::Missed));
            }
            self.job = Job::None;
        }
        if ended || self.cues.has_begun() {
            self.cues.clear();
            self.apply_overrides();
        }
        let reset = core::mem::take(&mut self.resetting);
        if reset {
            self.absorb_trims();
            self.banner();
        }
        ended || reset
    }

    /// A target of the first six motors; the others stay where they are.
    fn on_all_motors(&self, target: &Target<AXES>) -> Target<N> {
        let end = self.planner.end();
        Target {
            steps: core::array::from_fn(|i| target.steps.get(i).copied().unwrap_or(end[i])),
            duration: target.duration,
            free: target.free,
        }
    }

    pub(super) fn switch_on(&mut self) {
        if !self.drivers_on {
            self.drivers_on = true;
            self.board.enable_drivers(true);
        }
    }
}
