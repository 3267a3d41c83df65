//! Process cycles: each turns the parameters of a process into timed tool poses. One file or folder each.
//!
//! | cycle | from | to |
//! |---|---|---|
//! | [`drill_point`] | a drill's geometry, nothing more | poses of the drill |
//! | [`precession`] | points with normals | poses of the bonnet |
//! | [`surface_grinding`] | points with normals, feed and curvature | poses of the wheel |
//! | [`mirror_milling`] | points with normals of the supported face | tips of both sides, the wall between them |
//!
//! [`mirror_trim`] and [`mirror_bias`] correct the last one while it runs, and from one panel to the next.
//!
//! All of them are a [`Process`]: parameters are checked when it is built, points when they are taken, so that walking the
//! [`Mark`]s cannot fail, and a copy can be walked for checking. State is O(1), whatever the length of the path.

pub mod drill_point;
pub mod mirror_bias;
pub mod mirror_milling;
pub mod mirror_trim;
pub mod precession;
pub mod surface_grinding;

use crate::kinematics::follow::Feed;

/// How a mark is come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace<R> {
    /// In the work, from the mark before.
    Feed(Feed<R>),
    /// Straight from the mark before, as fast as the joints go.
    Rapid,
    /// Drawn back from the mark before, across as fast as the joints go, and down.
    Apart,
}

/// Where the tool is to be: what the machine's kinematics takes as an end of its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark<E, R> {
    pub end: E,
    pub pace: Pace<R>,
}

/// A process: points in, timed ends of the tool's way out.
pub trait Process<R>: Clone {
    /// What is fed to it from outside; [`Infallible`](core::convert::Infallible) where the parameters say it all.
    type Point;
    type End;
    type Marks: Iterator<Item = Mark<Self::End, R>> + Clone;
    type Error;

    /// What a point adds; refused with nothing changed.
    fn take(&mut self, point: &Self::Point) -> Result<Self::Marks, Self::Error>;

    /// What is left when no more points come.
    fn finish(&mut self) -> Result<Self::Marks, Self::Error>;
}

/// The one mark of a point.
pub type OneMark<E, R> = core::option::IntoIter<Mark<E, R>>;
