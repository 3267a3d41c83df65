//! What cannot wait: reset, hold, overrides, status; and the stop of a queue run dry.

use super::{Controller, Job};
use crate::board::Board;
use crate::error::Alarm;
use crate::program::processes::Processes;
use crate::protocol::RealTime;
use crate::protocol::report::{self, State, Status};
use core::fmt::Write;
use fixed::types::I32F32;

/// Room that a status report needs.
const STATUS: usize = 260;

impl<B: Board, const N: usize, P: Processes<N>> Controller<'_, B, N, P> {
    pub(super) fn serve_real_time(&mut self) -> bool {
        let reset = self.flags.take(RealTime::RESET);
        if reset {
            self.reset();
        }
        if self.flags.take(RealTime::OVERFLOW) {
            self.reader.spoil();
        }
        let touched = self.flags.take(RealTime::TOUCH);
        if touched {
            self.touched();
        }
        let hold = self.flags.take(RealTime::HOLD);
        if hold {
            self.hold();
        }
        let cancel = self.flags.take(RealTime::JOG_CANCEL);
        if cancel && matches!(self.job, Job::Jog) {
            self.stop_motion();
        }
        let resume = self.flags.take(RealTime::RESUME);
        if resume {
            self.resume();
        }
        let overrides = self.flags.overrides();
        let changed = overrides != self.overrides;
        if changed {
            self.overrides = overrides;
            self.say_overrides = true;
            self.apply_overrides();
        }
        let status = self.answers.room() >= STATUS && self.flags.take(RealTime::STATUS);
        if status {
            self.report_status();
        }
        let trimmed = self.serve_trims();
        reset || trimmed || touched || hold || cancel || resume || changed || status
    }

    /// Feed hold: slows down on the path and waits there; a jog is dropped instead.
    pub fn hold(&mut self) {
        match self.job {
            Job::Jog | Job::Probe => self.stop_motion(),
            // Runs from rest to rest as a whole.
            Job::Counts(_) => {}
            _ => self.planner.hold(),
        }
    }

    /// Ends a hold; starts a stream that waits for more.
    pub fn resume(&mut self) {
        if self.planner.is_held() {
            self.planner.resume();
        } else if let Job::Stream { begun, .. } | Job::Process { begun, .. } = &mut self.job {
            *begun = true;
        }
    }

    /// Soft reset: everything queued is dropped. At rest, in a hold too, the position stays trusted.
    fn reset(&mut self) {
        while self.bytes.dequeue().is_some() {}
        self.reader.clear();
        self.answers.clear();
        self.flags.reset_overrides();
        self.cues.clear();
        if self.stopping.is_some() || self.resetting {
            return;
        }
        let gives = !self.planner.is_at_rest() || !self.shaper.is_settled();
        let rests = !gives && self.pending.is_none() && self.motors_rest();
        if !rests {
            self.stop_now(Alarm::StoppedInMotion);
        } else if self.is_moving() || self.planner.is_held() {
            // A path that has not begun, or is held, is dropped.
            self.job = Job::None;
            self.processes.stop();
            self.planner.stop();
            self.resetting = true;
        } else {
            self.absorb_trims();
            self.banner();
        }
    }

    /// Stops the motors at the next tick; the position is lost. The rest follows in [`Self::finish_stop`] once the
    /// interrupt has done so.
    pub(super) fn stop_now(&mut self, alarm: Alarm) {
        self.shared.stop();
        self.stopping = Some(alarm);
        self.planner.abort();
        self.shaper.clear();
        self.job = Job::None;
        self.processes.stop();
        self.pending = None;
        self.ahead.clear();
        self.cues.clear();
    }

    /// Once the interrupt has stopped and dropped the queue: books and planner stand where the motors are.
    pub(super) fn finish_stop(&mut self) -> bool {
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
        self.forget_trims();
        if let Some(alarm) = self.stopping.take() {
            self.raise(alarm);
        }
        self.banner();
        true
    }

    pub(super) fn raise(&mut self, alarm: Alarm) {
        self.alarm = Some(alarm);
        self.answers.line(format_args!("ALARM:{}", alarm.number()));
    }

    pub(super) fn watch_starvation(&mut self) {
        let starved = self.shared.starved();
        if starved != self.starved {
            self.starved = starved;
            self.answers
                .line(format_args!("[MSG:Segment queue ran dry, position lost]"));
            self.stop_now(Alarm::StoppedInMotion);
        }
    }

    pub(super) fn banner(&mut self) {
        self.say_offset = true;
        self.say_overrides = true;
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
        let state = self.state();
        let positions = match state {
            State::Run | State::Jog | State::Hold { .. } => {
                self.segmenter.positions_at(self.shared.now())
            }
            State::Idle | State::Alarm => None,
        }
        .unwrap_or(whole);
        let offset = core::mem::take(&mut self.say_offset);
        let overrides = (!offset && self.say_overrides).then_some(self.overrides);
        self.say_overrides &= overrides.is_none();
        let status = Status {
            state,
            positions,
            steps_per_unit: self.settings.steps_per_unit(),
            free: (
                self.planner.room(),
                self.bytes.capacity() - self.bytes.len(),
            ),
            offset,
            overrides,
        };
        let _ = write!(self.answers, "{status}");
    }
}
