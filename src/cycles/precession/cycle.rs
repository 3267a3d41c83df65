//! The whole path at once: its segments, its poses, its waypoints.

use super::error::PrecessionError;
use super::parameters::Parameters;
use super::stream::{Contact, Precession};
use super::stretch::{Stance, Stretch};
use crate::geometry::Waypoint;
use crate::math::Real;

/// A precession along a path that lies ready: an iterator over its waypoints. A copy can be walked for checking.
///
/// A waypoint is the turn-free tool frame in the ball's centre, its z axis along P, in the work's frame; its duration the
/// time of the step, 0 for the first.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle<'a, R> {
    stances: Stances<'a, R>,
}

impl<'a, R: Real> Cycle<'a, R> {
    /// Checks everything, in the order of the validation table; after this nothing can fail.
    pub fn new(
        parameters: &Parameters<R>,
        contacts: &'a [Contact<R>],
    ) -> Result<Self, PrecessionError> {
        let mut precession = Precession::for_path(parameters, contacts)?;
        let (first, rest) = contacts.split_first().ok_or(PrecessionError::BadPath)?;
        precession.push(*first)?;
        let segments = Segments {
            precession,
            contacts: rest,
            dwells: rest.is_empty(),
        };
        let stances = Stances {
            segments,
            current: None,
        };
        Ok(Self { stances })
    }

    /// What is left of the cycle, pose by pose in full.
    pub fn stances(&self) -> Stances<'a, R> {
        self.stances.clone()
    }

    /// The segments not yet begun: one for each move, the dwell for a path of a single point.
    pub fn segments(&self) -> impl Iterator<Item = Stretch<R>> + use<'a, R> {
        self.stances.segments.clone()
    }
}

impl<R: Real> Iterator for Cycle<'_, R> {
    type Item = Waypoint<R>;

    fn next(&mut self) -> Option<Waypoint<R>> {
        self.stances.next().map(|stance| stance.waypoint())
    }
}

/// The poses of a cycle in full.
#[derive(Clone, Debug, PartialEq)]
pub struct Stances<'a, R> {
    segments: Segments<'a, R>,
    current: Option<Stretch<R>>,
}

impl<R: Real> Iterator for Stances<'_, R> {
    type Item = Stance<R>;

    fn next(&mut self) -> Option<Stance<R>> {
        loop {
            if let Some(stance) = self.current.as_mut().and_then(Iterator::next) {
                return Some(stance);
            }
            self.current = Some(self.segments.next()?);
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Segments<'a, R> {
    precession: Precession<R>,
    /// Those still to come; the first one has been pushed.
    contacts: &'a [Contact<R>],
    /// A single point, whose dwell is still to come.
    dwells: bool,
}

impl<R: Real> Iterator for Segments<'_, R> {
    type Item = Stretch<R>;

    /// Every push was tried when the cycle was built, so none of them ends it early.
    fn next(&mut self) -> Option<Stretch<R>> {
        let Some((next, rest)) = self.contacts.split_first() else {
            let dwells = core::mem::take(&mut self.dwells);
            return dwells.then(|| self.precession.finish().ok()).flatten();
        };
        let stretch = self.precession.push(*next).ok()?;
        self.contacts = rest;
        if rest.is_empty() && !self.precession.has_begun() {
            // All points were the same: the one pose is still owed.
            return self.precession.finish().ok();
        }
        Some(stretch)
    }
}
