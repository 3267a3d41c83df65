//! Processes fed with points: their lines, and their blocks on the way to the planner.

use super::lines::Done;
use super::{Controller, Job};
use crate::board::Board;
use crate::error::Error;
use crate::program::processes::{Order, Processes, Progress, Standing};

/// Room that a refusal needs.
const ANSWER: usize = 360;

impl<B: Board, const N: usize, P: Processes<N>> Controller<'_, B, N, P> {
    /// A line of a process.
    pub(super) fn obey_process(&mut self, name: &str, value: Option<&str>) -> Result<Done, Error> {
        let is_idle = !self.is_moving() && !self.planner.is_held();
        if name == "POINT" && !matches!(self.job, Job::Process { .. }) {
            return Err(Error::NotIdle);
        }
        let order = self
            .processes
            .obey(name, value, is_idle, &mut self.answers)?;
        match order {
            Order::Done => {
                if is_idle {
                    self.settings.turn_all(self.processes.all_turn());
                }
            }
            Order::Stop => self.stop_motion(),
            Order::Run { sim } => self.start_process(sim)?,
            Order::Point => {
                let Job::Process { waits, .. } = &mut self.job else {
                    return Err(Error::NotIdle);
                };
                *waits = false;
                return Ok(Done::Later);
            }
        }
        Ok(Done::Now)
    }

    fn start_process(&mut self, sim: bool) -> Result<(), Error> {
        self.may_move()?;
        let standing = Standing {
            scale: self.scale(),
            at: self.planner.end_steps(),
            speeds: self.settings.speeds(),
            tolerance: self.settings.tolerance(),
        };
        self.contour = Some(self.processes.start(&standing, &mut self.answers)?);
        self.cuts = false;
        if !sim {
            self.switch_on();
        }
        self.job = Job::Process {
            begun: false,
            waits: true,
        };
        Ok(())
    }

    /// One block of the process's point: looked at, or on its way.
    pub(super) fn feed_process(&mut self) -> bool {
        let Job::Process { waits: false, .. } = self.job else {
            return false;
        };
        if self.planner.is_full() || self.planner.is_held() || self.answers.room() < ANSWER {
            return false;
        }
        match self.processes.next(&mut self.answers) {
            Progress::Busy => {}
            Progress::Taken => self.answers.line(format_args!("ok")),
            Progress::Target(target) => {
                // There is room, and all of the point was looked at before.
                let _ = self.push_target(&target);
            }
            Progress::Refused(error) => {
                self.answers.line(format_args!("error:{}", error.number()));
                self.want_point();
            }
            Progress::Waits => self.want_point(),
            Progress::Over => {
                self.processes.stop();
                self.job = Job::None;
            }
        }
        true
    }

    fn want_point(&mut self) {
        if let Job::Process { waits, .. } = &mut self.job {
            *waits = true;
        }
    }

    /// Ends the process; a line that waits for its answer has one.
    pub(super) fn end_process(&mut self) {
        if self.processes.owes_answer() {
            self.answers
                .line(format_args!("error:{}", Error::NotIdle.number()));
        }
        self.processes.stop();
        self.job = Job::None;
    }
}
