//! One pose on a path, and how soon it may be reached.

use super::Pose;

/// A pose and the least time in which it may be reached from the waypoint before.
///
/// Feed crosses the kinematics as a time, because a time means the same on both sides of it and mm/min does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint<R> {
    /// Of the tool in the machine frame [mm].
    pub pose: Pose<R>,
    /// Least time from the waypoint before [s]; 0 for a rapid, which only the joints' own limits bind.
    pub duration: R,
}
