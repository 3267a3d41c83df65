//! Rows of a surface, ground point by point: contacts in, poses of the wheel with their feeds out.

use super::{Grinding, GrindingError, wheel_pose};
use crate::cycles::{Mark, OneMark, Pace, Process};
use crate::geometry::nurbs::Section;
use crate::geometry::{Pose, Vector};
use crate::kinematics::follow::Feed;
use crate::math::Real;

/// A contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowPoint<R> {
    /// [mm]
    pub p: Vector<R>,
    /// Outward normal, any length from 1e-6.
    pub n: Vector<R>,
    /// Which way the row goes, at right angles to the normal, any length from 1e-6.
    pub feed: Vector<R>,
    /// k_f, k_c, tau [1/mm].
    pub curvature: [R; 3],
    /// It is the first of a row.
    pub begins: bool,
}

/// Grinds row after row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rows<R> {
    grinding: Grinding<R>,
    half_width: R,
    feed: R,
    zigzag: bool,
    /// The way the wheel faces, and whether this row goes the other way; `None` before the first.
    facing: Option<(Vector<R>, bool)>,
}

impl<R: Real> Rows<R> {
    /// `half_width` of the wheel [mm], 0: not looked at; `feed` where the depth is not constant [mm/s]; `zigzag`: rows may
    /// go to and fro, and the wheel faces as it did before, so that its axle is not swung round between them.
    pub fn new(grinding: Grinding<R>, half_width: R, feed: R, zigzag: bool) -> Self {
        Self {
            grinding,
            half_width,
            feed,
            zigzag,
            facing: None,
        }
    }
}

impl<R: Real> Process<R> for Rows<R> {
    type Point = RowPoint<R>;
    type End = Pose<R>;
    type Marks = OneMark<Pose<R>, R>;
    type Error = GrindingError<R>;

    /// `BadPose` where normal and feed are no directions at right angles; else as the contact under the wheel fails.
    fn take(&mut self, point: &RowPoint<R>) -> Result<Self::Marks, GrindingError<R>> {
        let bad = GrindingError::BadPose;
        if !(point.p.is_finite() && point.n.is_finite() && point.feed.is_finite()) {
            return Err(bad);
        }
        // A few digits of a line are at right angles to a few digits; more than that is a mistake.
        const SKEW: f64 = 0.01;
        let least = R::of(1e-6);
        let n = point.n.unit(least).ok_or(bad)?;
        let along = point.feed.unit(least).ok_or(bad)?;
        let lean = along.dot(n);
        if lean.abs() > R::of(SKEW) {
            return Err(bad);
        }
        let feed = (along - n * lean).unit(R::HALF).ok_or(bad)?;
        let [k_f, k_c, tau] = point.curvature;
        let section = Section {
            feed,
            cross: n.cross(feed),
            k_f,
            k_c,
            tau,
        };
        let mut contact = self.grinding.hertz.on(&section)?;
        if self.half_width > R::ZERO {
            contact = contact.within(self.half_width)?;
        }
        // The pitch was the planner's business; whether there is one is ours.
        self.grinding.pitch_on(&section)?;
        let speed = self.grinding.feed(&contact, self.feed)?;
        let mut pose = wheel_pose(point.p, n, &section)?;
        let begins = point.begins || self.facing.is_none();
        let is_back = match self.facing {
            Some((facing, _)) if begins => self.zigzag && facing.dot(feed) < R::ZERO,
            Some((_, is_back)) => is_back,
            None => false,
        };
        if is_back {
            // Half a turn about the tool's z axis.
            (pose.rotation.n, pose.rotation.s) = (-pose.rotation.n, -pose.rotation.s);
        }
        self.facing = Some((pose.rotation.n, is_back));
        let pace = if begins {
            Pace::Apart
        } else {
            Pace::Feed(Feed::Tip(speed))
        };
        Ok(Some(Mark { end: pose, pace }).into_iter())
    }

    fn finish(&mut self) -> Result<Self::Marks, GrindingError<R>> {
        Ok(None.into_iter())
    }
}
