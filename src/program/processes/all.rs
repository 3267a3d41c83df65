//! Everything, for a board that has room for it: six motors are a drill grinder until an arm is chosen, eight a pair.

use super::{ArmProcesses, Order, PairProcesses, Processes, Progress, Standing};
use crate::error::Error;
use crate::machines::two_sided::Pair;
use crate::path::Scale;
use crate::planner::PathSetting;
use crate::settings::AXES;
use core::fmt::Write;

/// An arm's and a pair's.
pub struct AllProcesses {
    arm: ArmProcesses,
    pair: PairProcesses,
}

impl Default for AllProcesses {
    fn default() -> Self {
        let mut arm = ArmProcesses::default();
        arm.machine.is_chosen = false;
        Self {
            arm,
            pair: PairProcesses::default(),
        }
    }
}

/// The method of whichever has so many motors.
macro_rules! of_motors {
    ($self:ident . $method:ident ( $($argument:expr),* )) => {
        if N > AXES {
            Processes::<N>::$method(&mut $self.pair, $($argument),*)
        } else {
            Processes::<N>::$method(&mut $self.arm, $($argument),*)
        }
    };
}

impl<const N: usize> Processes<N> for AllProcesses {
    fn all_turn(&self) -> bool {
        N == AXES && self.arm.machine.is_chosen
    }

    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        of_motors!(self.obey(name, value, is_idle, out))
    }

    fn start(
        &mut self,
        standing: &Standing<N>,
        out: &mut dyn Write,
    ) -> Result<PathSetting<N>, Error> {
        of_motors!(self.start(standing, out))
    }

    fn next(&mut self, out: &mut dyn Write) -> Progress<N> {
        of_motors!(self.next(out))
    }

    fn owes_answer(&self) -> bool {
        Processes::<N>::owes_answer(&self.pair) || Processes::<N>::owes_answer(&self.arm)
    }

    fn stop(&mut self) {
        of_motors!(self.stop())
    }

    fn pair(&self, scale: &Scale<N>, out: &mut dyn Write) -> Result<Pair<4, 4, f32>, Error> {
        Processes::<N>::pair(&self.pair, scale, out)
    }
}
