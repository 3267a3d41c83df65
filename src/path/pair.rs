//! A two-sided machine with its two tools.

use super::points::Tooled;
use crate::joints::Joints;
use crate::kinematics::ClPoint;
use crate::kinematics::chord::{ChainSet, Reach};
use crate::machines::two_sided::{AtWall, PairError, PairGuide};

impl Tooled<8> for PairGuide<f32> {
    /// A pair has no choice.
    fn choose(&mut self, _: &ClPoint<f32>, _: &Joints<8>) -> Result<bool, PairError<4, 4, f32>> {
        Ok(true)
    }

    fn reach(
        &self,
        at: &ClPoint<f32>,
        near: &Joints<8>,
    ) -> Result<ChainSet<8, f32>, PairError<4, 4, f32>> {
        self.machine.reach(at, near)
    }

    /// Both sides, each along its tool.
    fn draw_back(
        &self,
        at: &ClPoint<f32>,
        set: &ChainSet<8, f32>,
        clear: f32,
    ) -> Result<Joints<8>, PairError<4, 4, f32>> {
        let apart = AtWall {
            wall: self.machine.wall + 2.0 * clear,
            ..self.machine
        };
        let back = ClPoint::new(at.p() - at.v() * clear, at.v()).ok_or(PairError::NonFinite)?;
        apart.reach(&back, &set.q).map(|set| set.q)
    }
}
