//! Points in, poses of the bonnet out.

use super::{Contact, Precession, PrecessionError, Stance, Stretch};
use crate::cycles::{Mark, Pace, Process};
use crate::geometry::{Pose, Rotation};
use crate::kinematics::follow::Feed;
use crate::math::Real;

/// Poses of the bonnet along a segment: the tip is the ball's centre, z points into the work, and the frame does not turn
/// about the axis, so that the last wrist joint of an arm does not wind up.
#[derive(Clone, Debug, PartialEq)]
pub struct BonnetMarks<R>(Stretch<R>);

impl<R: Real> Iterator for BonnetMarks<R> {
    type Item = Mark<Pose<R>, R>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next().map(|stance| mark(&stance))
    }
}

fn mark<R: Real>(stance: &Stance<R>) -> Mark<Pose<R>, R> {
    let tool = stance.tool();
    let a = -tool.a;
    Mark {
        end: Pose {
            rotation: Rotation {
                n: tool.n,
                s: a.cross(tool.n),
                a,
            },
            p: stance.centre,
        },
        // The first pose has no stretch before it.
        pace: if stance.dt > R::ZERO {
            Pace::Feed(Feed::Time(stance.dt))
        } else {
            Pace::Apart
        },
    }
}

impl<R: Real> Process<R> for Precession<R> {
    type Point = Contact<R>;
    type End = Pose<R>;
    type Marks = BonnetMarks<R>;
    type Error = PrecessionError;

    fn take(&mut self, point: &Contact<R>) -> Result<BonnetMarks<R>, PrecessionError> {
        self.push(*point).map(BonnetMarks)
    }

    fn finish(&mut self) -> Result<BonnetMarks<R>, PrecessionError> {
        Precession::finish(self).map(BonnetMarks)
    }
}
