//! Rows of a panel between two sides: points of its supported face in, ways of the pair out.
//!
//! A mark is the support's tip P and the normal n from the support to the mill; the machine sets its cutter to P + d n
//! against it ([`AtWall`](crate::machines::two_sided::AtWall)). At the begin of a row both tools are drawn back.
//!
//! Source: specification of mirror milling, section 3, "Trajectory generation".

use super::{Mark, OneMark, Pace, Process};
use crate::geometry::Vector;
use crate::kinematics::ClPoint;
use crate::kinematics::follow::Feed;
use crate::math::Real;

/// A point of the supported face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePoint<R> {
    /// [mm]
    pub p: Vector<R>,
    /// From the support to the mill, any length from 1e-6.
    pub n: Vector<R>,
    /// It is the first of a row.
    pub begins: bool,
}

/// Why a point is none: the names of the pair's own refusals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceError {
    NonFinite,
    BadNormal,
}

/// Mills row after row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelRows<R> {
    feed: R,
    begun: bool,
}

impl<R: Real> PanelRows<R> {
    /// `feed` of the support along the face [mm/s].
    pub fn new(feed: R) -> Self {
        Self { feed, begun: false }
    }
}

impl<R: Real> Process<R> for PanelRows<R> {
    type Point = FacePoint<R>;
    type End = ClPoint<R>;
    type Marks = OneMark<ClPoint<R>, R>;
    type Error = FaceError;

    fn take(&mut self, point: &FacePoint<R>) -> Result<Self::Marks, FaceError> {
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
