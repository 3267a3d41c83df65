//! Lines -> what is to be done, and their answers.

use super::answers::LONGEST_ANSWER;
use super::trims::{Follow, letter};
use super::{Controller, Job, StreamError};
use crate::board::Board;
use crate::error::Error;
use crate::path::{PathError, Target};
use crate::program::processes::Processes;
use crate::program::words::{BadSteps, Decimal, STEP_PLACES};
use crate::protocol::cue::{Cue, CueError};
use crate::protocol::system::{self, Command};
use crate::settings::{LETTERS, Settings};
use crate::shaper::design::{MOST_DAMPING, MOST_DAMPING_EI, MOST_HZ};
use crate::shaper::{HISTORY, LONGEST, Reason, Refusal};
use crate::stepper::{CountError, CountLine, Preset};
use core::fmt::Arguments;
use fixed::types::I32F32;

/// When a line is answered.
pub(super) enum Done {
    Now,
    Later,
}

impl<B: Board, const N: usize, P: Processes<N>> Controller<'_, B, N, P> {
    /// Whether a line may be taken now: at rest, or as the next target of a stream.
    pub(super) fn takes_lines(&self) -> bool {
        let free = match &self.job {
            Job::None => {
                self.planner.is_idle() && self.shaper.is_settled() && self.pending.is_none()
            }
            Job::Stream { waiting, .. } => waiting.is_none(),
            Job::Process { .. } => !self.processes.owes_answer(),
            _ => false,
        };
        free && !self.planner.is_held() && !self.resetting
    }

    pub(super) fn take_line(&mut self) -> bool {
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

    fn execute(&mut self, command: Command<'_, N>) -> Result<Done, Error> {
        match command {
            Command::Nothing => {}
            Command::Help => {
                self.answers.line(format_args!(
                    "[HLP:$$ $n=v $I $X $STAT $SEG= $MOVE= $CUE= $TRIM $TRIM= $DRILL $DRILL= $DRILL=RUN|SIM $KIN $PRECESS $SURF $MIRROR $POINT= ? ! ~ ctrl-x]"
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
                    .line(format_args!("[OPT:,{blocks},{bytes},{N},0]"));
                let letters = LETTERS.get(..N).unwrap_or(LETTERS);
                self.answers.line(format_args!("[AXS:{N}:{letters}]"));
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
            Command::DrillRun { sim } => {
                let (cycle, machine) = self.drill.build().map_err(|refusal| {
                    self.answers.line(format_args!("[MSG:{refusal}]"));
                    Error::ValueRange
                })?;
                self.walk_drill(cycle, machine, sim)?;
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
            Command::Move { steps, duration } => {
                let target = Target::new(steps, duration);
                return self.take_target(target).map(|()| Done::Later);
            }
            Command::BadMove { motor, why } => return Err(self.refuse_steps(motor, why)),
            Command::MoveEnd => {
                if !matches!(self.job, Job::Stream { .. }) {
                    return Err(Error::NotIdle);
                }
                self.end_stream();
            }
            Command::Process { name, value } => return self.obey_process(name, value),
            Command::TrimShow => self.list_trims(),
            Command::TrimZero => self.remove_trims(),
            Command::Trim { motor, value } => self.trim(motor, value)?,
            Command::TrimOn {
                period,
                numbers: [tau, amount, rate, gate],
                misses,
            } => self.follow(Follow {
                period,
                tau,
                amount,
                rate,
                gate,
                miss_max: u32::try_from(misses).map_err(|_| Error::Negative)?,
            })?,
            Command::TrimOff => self.unfollow(),
            Command::Cue { at, action } => self.add_cue(Cue { at, action }).map_err(|error| {
                let expected = match error {
                    CueError::Full => format_args!("at most 16 cues"),
                    CueError::Order => {
                        format_args!("cues in the order of their times, before the motion")
                    }
                    CueError::Range => format_args!(
                        "feed 10 to 200, rapid 5 to 100 percent, trim of motor 0 to {}",
                        N - 1
                    ),
                };
                self.answers
                    .line(format_args!("[MSG:{error:?} cue: expected {expected}]"));
                Error::ValueRange
            })?,
        }
        Ok(Done::Now)
    }

    /// A target from a line; starts a stream if there is none. Its line is answered once it has found room.
    fn take_target(&mut self, target: Target<N>) -> Result<(), Error> {
        if let Some(joint) = self.scale().beyond(&target.steps) {
            return Err(self.refuse_path(PathError::OutOfTravel { joint }));
        }
        if !matches!(self.job, Job::Stream { .. }) {
            self.start_stream()?;
        }
        if let Job::Stream { waiting, .. } = &mut self.job {
            *waiting = Some(target);
        }
        Ok(())
    }

    /// The answer to a line whose target has been offered to the planner.
    pub(super) fn answer_push(&mut self, pushed: Result<bool, StreamError>) {
        let expected = match pushed {
            Ok(_) => {
                self.answers.line(format_args!("ok"));
                return;
            }
            Err(StreamError::Duration) => "a duration of 0 s or more",
            Err(StreamError::TooLong) => "a way below 2147483648 steps",
            Err(StreamError::NotStarted | StreamError::OutOfTravel { .. }) => "a machine at rest",
        };
        self.answers
            .line(format_args!("[MSG:OutOfRange target: expected {expected}]"));
        self.answers
            .line(format_args!("error:{}", Error::ValueRange.number()));
    }

    /// Whether a motion may begin: nothing else is under way, nothing is locked.
    pub(super) fn may_move(&mut self) -> Result<(), Error> {
        let rests = self.planner.is_idle() && self.shaper.is_settled();
        if !matches!(self.job, Job::None) || !rests || self.planner.is_held() {
            return Err(Error::NotIdle);
        }
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
        let mut settings = self.settings.clone();
        if let Err(error) = settings.put(number, value) {
            if let Some(refusal) = Settings::<N>::shaper_of(number) {
                self.say_shaper(refusal, format_args!(""));
            }
            return Err(error);
        }
        settings.check(B::TICK_HZ).map_err(|conflict| {
            match conflict.shaper() {
                Some(refusal) => self.say_shaper(refusal, format_args!("; {conflict}")),
                None => self
                    .answers
                    .line(format_args!("[MSG:${number} refused: {conflict}]")),
            }
            conflict.error()
        })?;
        self.configure(settings)
    }

    /// Why a shaper's setting is refused, by name, and what bounds it.
    fn say_shaper(&mut self, refusal: Refusal, bounds: Arguments<'_>) {
        let (name, letter) = (refusal.reason.name(), letter(refusal.joint));
        match refusal.reason {
            Reason::Kind => self.answers.line(format_args!(
                "[MSG:{name} {letter}: expected 0 off, 1 ZV, 2 ZVD, 3 EI{bounds}]"
            )),
            Reason::Frequency => self.answers.line(format_args!(
                "[MSG:{name} {letter}: expected 0.1 to {} Hz, below half of 1000 samples a second{bounds}]",
                Decimal(MOST_HZ as f32)
            )),
            Reason::Damping => self.answers.line(format_args!(
                "[MSG:{name} {letter}: expected 0 to {}, for EI to {}{bounds}]",
                Decimal(MOST_DAMPING as f32),
                Decimal(MOST_DAMPING_EI as f32)
            )),
            Reason::TooLong { samples } => self.answers.line(format_args!(
                "[MSG:{name} {letter}: {samples} ms, expected at most {LONGEST}, {} of all motors; higher frequencies are shorter{bounds}]",
                (HISTORY - 1) * N
            )),
        }
    }

    fn count_line(
        &mut self,
        counts: [i32; N],
        seconds: f64,
        preset: Preset,
    ) -> Result<CountLine<N>, Error> {
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
        let end: [i32; N] = core::array::from_fn(|i| from[i].wrapping_add(counts[i]));
        match self.scale().beyond(&end.map(I32F32::from_num)) {
            Some(joint) => Err(self.refuse_path(PathError::OutOfTravel { joint })),
            None => Ok(line),
        }
    }

    fn refuse_steps(&mut self, motor: usize, why: BadSteps) -> Error {
        match why {
            BadSteps::Malformed => {
                self.answers.line(format_args!(
                    "[MSG:BadNumber target {motor}: expected steps as a decimal number]"
                ));
                Error::BadNumber
            }
            BadSteps::TooLong => {
                self.answers.line(format_args!(
                    "[MSG:BadNumber target {motor}: expected at most {STEP_PLACES} digits behind the point]"
                ));
                Error::BadNumber
            }
            BadSteps::OutOfRange => {
                self.answers.line(format_args!(
                    "[MSG:OutOfRange target {motor}: expected -2147483648 to less than 2147483648 steps]"
                ));
                Error::ValueRange
            }
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
    pub(super) fn refuse_path(&mut self, error: PathError) -> Error {
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
