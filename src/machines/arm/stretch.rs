//! Poses of one stretch of path -> the branch that serves all of them.
//!
//! A row keeps one branch for all its points, since changing it swings the arm. Each branch is followed through the
//! poses with its own full turns; it drops out at the first pose that it does not reach, that is singular, out of
//! range, or more than 30 deg in a joint away from the pose before. Of those left the one with the largest margin to
//! any range wins.
//!
//! Source: specification of surface grinding, section 9, "Path".

use super::{Arm, ArmError};
use crate::geometry::Pose;
use crate::joints::Joints;
use crate::math::Real;

/// Why a branch does not serve a stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The pose is out of reach in this branch.
    NotReached,
    /// No full turn brings a joint into its range.
    OutOfTravel,
    WristSingular,
    ElbowSingular,
    ShoulderSingular,
    /// A joint would move by more than 30 deg from the pose before; `joint` counts from 0.
    Jump {
        joint: u8,
    },
}

/// No branch serves all poses: for each of the eight the index of the first pose that it fails at, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoBranch {
    pub reasons: [Option<(u32, Refusal)>; 8],
}

/// Largest step of a joint between two poses [rad]: 30 deg.
const JUMP: f64 = core::f64::consts::PI / 6.0;

#[derive(Clone, Copy, Debug)]
struct Track<R> {
    last: Option<Joints<6, R>>,
    /// Smallest distance to the end of a range so far [rad].
    margin: R,
    refused: Option<(u32, Refusal)>,
}

/// Follows the eight branches through the poses of a stretch.
#[derive(Clone, Copy, Debug)]
pub struct Stretch<R> {
    tracks: [Track<R>; 8],
    count: u32,
}

impl<R: Real> Stretch<R> {
    /// `start`: joints before the stretch [rad]; they choose the full turns of its first pose.
    pub fn new(start: Option<Joints<6, R>>) -> Self {
        Self {
            tracks: [Track {
                last: start,
                margin: R::INFINITY,
                refused: None,
            }; 8],
            count: 0,
        }
    }

    /// Follows one more pose. Fails only if the pose is none ([`ArmError::BadPose`]).
    pub fn add(&mut self, arm: &Arm<R>, pose: &Pose<R>) -> Result<(), ArmError> {
        let found = match arm.inverse(pose, None) {
            Ok(branches) => Some(branches),
            Err(ArmError::Unreachable) => None,
            Err(error) => return Err(error),
        };
        for (number, track) in (0..).zip(&mut self.tracks) {
            if track.refused.is_some() {
                continue;
            }
            let solution = found.as_ref().and_then(|list| list.branch(number));
            let refusal = match solution {
                None => Some(Refusal::NotReached),
                Some(s) if s.wrist_singular => Some(Refusal::WristSingular),
                Some(s) if s.elbow_singular => Some(Refusal::ElbowSingular),
                Some(s) if s.shoulder_singular => Some(Refusal::ShoulderSingular),
                Some(s) if !s.in_limits => Some(Refusal::OutOfTravel),
                Some(s) => track.follow(arm, s.q, self.count > 0),
            };
            track.refused = refusal.map(|why| (self.count, why));
        }
        self.count = self.count.saturating_add(1);
        Ok(())
    }

    /// The branch for the whole stretch and its smallest distance to any range [rad].
    pub fn best(&self) -> Result<(u8, R), NoBranch> {
        let mut best: Option<(u8, R)> = None;
        for (number, track) in (0..).zip(&self.tracks) {
            if track.refused.is_none() && best.is_none_or(|(_, margin)| track.margin > margin) {
                best = Some((number, track.margin));
            }
        }
        best.ok_or(NoBranch {
            reasons: self.tracks.map(|track| track.refused),
        })
    }

    /// Joints of a branch at the last pose [rad], as long as it serves.
    pub fn joints(&self, branch: u8) -> Option<Joints<6, R>> {
        let track = self.tracks.get(usize::from(branch))?;
        if track.refused.is_none() && self.count > 0 {
            track.last
        } else {
            None
        }
    }
}

impl<R: Real> Track<R> {
    fn follow(&mut self, arm: &Arm<R>, mut q: Joints<6, R>, has_before: bool) -> Option<Refusal> {
        if let Some(last) = self.last {
            for (joint, (angle, last)) in (0..).zip(q.0.iter_mut().zip(&last.0)) {
                *angle = arm.fit(usize::from(joint), *angle, *last).0;
                if has_before && (*angle - *last).abs() > R::of(JUMP) {
                    return Some(Refusal::Jump { joint });
                }
            }
        }
        for (angle, [lo, hi]) in q.0.iter().zip(arm.limits()) {
            self.margin = self.margin.min((*angle - *lo).min(*hi - *angle));
        }
        self.last = Some(q);
        None
    }
}
