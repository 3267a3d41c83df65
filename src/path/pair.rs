//! A two-sided machine: points of the panel's supported face -> a wall between both tips.

use super::points::{Mark, Pace, Process, Tooled};
use crate::geometry::Vector;
use crate::joints::Joints;
use crate::kinematics::ClPoint;
use crate::kinematics::chord::{ChainSet, Reach};
use crate::kinematics::follow::Feed;
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

/// A point of the supported face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePoint {
    /// [mm]
    pub p: Vector<f32>,
    /// From the support to the mill, any length from 1e-6.
    pub n: Vector<f32>,
    /// It is the first of a row.
    pub begins: bool,
}

/// Rows of a panel, milled point by point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelRows {
    /// Of the support along the face [mm/s].
    pub feed: f32,
    pub begun: bool,
}

/// Why a point is none: the names of the pair's own refusals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceError {
    NonFinite,
    BadNormal,
}

impl Process for PanelRows {
    type Point = FacePoint;
    type End = ClPoint<f32>;
    type Marks = core::option::IntoIter<Mark<ClPoint<f32>>>;
    type Error = FaceError;

    fn take(&mut self, point: &FacePoint) -> Result<Self::Marks, FaceError> {
        if !(point.p.is_finite() && point.n.is_finite()) {
            return Err(FaceError::NonFinite);
        }
        let end = ClPoint::new(point.p, point.n).ok_or(FaceError::BadNormal)?;
        let begins = point.begins || !self.begun;
        self.begun = true;
        let pace = if begins {
            Pace::Apart
        } else {
            Pace::Feed(Feed::Tip(self.feed))
        };
        Ok(Some(Mark { end, pace }).into_iter())
    }

    fn finish(&mut self) -> Result<Self::Marks, FaceError> {
        Ok(None.into_iter())
    }
}
