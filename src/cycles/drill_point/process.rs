//! No points in, all poses of the drill out: the parameters say everything.

use super::Cycle;
use crate::cycles::{Mark, Pace, Process};
use crate::geometry::Pose;
use crate::kinematics::follow::Feed;
use crate::math::Real;
use core::convert::Infallible;

/// The strokes that are left.
#[derive(Clone, Debug, PartialEq)]
pub struct DrillMarks<R>(Cycle<R>);

impl<R> DrillMarks<R> {
    /// The cycle as far as it has come.
    pub fn rest(&self) -> &Cycle<R> {
        &self.0
    }
}

impl<R: Real> Iterator for DrillMarks<R> {
    type Item = Mark<Pose<R>, R>;

    fn next(&mut self) -> Option<Self::Item> {
        let waypoint = self.0.next()?;
        Some(Mark {
            end: waypoint.pose,
            pace: if waypoint.duration > R::ZERO {
                Pace::Feed(Feed::Time(waypoint.duration))
            } else {
                Pace::Rapid
            },
        })
    }
}

impl<R: Real> Process<R> for Cycle<R> {
    type Point = Infallible;
    type End = Pose<R>;
    type Marks = DrillMarks<R>;
    type Error = Infallible;

    fn take(&mut self, point: &Infallible) -> Result<DrillMarks<R>, Infallible> {
        match *point {}
    }

    fn finish(&mut self) -> Result<DrillMarks<R>, Infallible> {
        Ok(DrillMarks(self.clone()))
    }
}
