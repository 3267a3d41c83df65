//! An arm along whole poses, in one branch, for the follower.
//!
//! The branch is chosen beforehand for the whole path ([`Stretch`](super::Stretch)); what leaves it, is singular, or out
//! of range is refused. The tip is that of a tool on the flange, the poses are those of its frame in a work frame.
//!
//! Source: specification of surface grinding, section 9, "Path".

use super::{Arm, Refusal};
use crate::geometry::Pose;
use crate::joints::Joints;
use crate::kinematics::PoseWay;
use crate::kinematics::chord::{MOST_TURN, between, sampled, unknown};
use crate::kinematics::follow::Guide;
use crate::kinematics::inverse::rotation_vector;
use crate::kinematics::way::Course;
use crate::math::Real;

/// An arm that keeps to one branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneBranch<R> {
    pub arm: Arm<R>,
    /// 0 ..= 7.
    pub branch: u8,
    /// Tool frame on the flange.
    pub tool: Pose<R>,
    /// Work frame in the base.
    pub work: Pose<R>,
    /// Largest joint speeds [rad/s], if they are limited.
    pub speeds: Option<Joints<6, R>>,
}

/// Joints [rad] with the pose that they reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmSet<R> {
    pub q: Joints<6, R>,
    /// Of the tool in the work frame.
    pub pose: Pose<R>,
}

impl<R: Real> OneBranch<R> {
    /// The flange in the base for a pose of the tool in the work frame.
    pub fn flange(&self, pose: &Pose<R>) -> Pose<R> {
        self.work * *pose * self.tool.inverse()
    }

    /// The tool in the work frame at these angles [rad].
    pub fn forward(&self, q: &Joints<6, R>) -> Pose<R> {
        self.work.inverse() * (self.arm.forward(q) * self.tool)
    }

    /// Joints for a pose in the branch, the full turns nearest to `before`.
    pub fn joints_at(
        &self,
        pose: &Pose<R>,
        before: &Joints<6, R>,
    ) -> Result<Joints<6, R>, Refusal> {
        let found = self.arm.inverse(&self.flange(pose), Some(before));
        let found = found.map_err(|_| Refusal::NotReached)?;
        let solution = found.branch(self.branch).ok_or(Refusal::NotReached)?;
        if solution.wrist_singular {
            Err(Refusal::WristSingular)
        } else if solution.elbow_singular {
            Err(Refusal::ElbowSingular)
        } else if solution.shoulder_singular {
            Err(Refusal::ShoulderSingular)
        } else if !solution.in_limits {
            Err(Refusal::OutOfTravel)
        } else {
            Ok(solution.q)
        }
    }
}

impl<R: Real> Guide<6, R> for OneBranch<R> {
    type Course = PoseWay<R>;
    type Set = ArmSet<R>;
    type Error = Refusal;

    fn solve(&self, at: &Pose<R>, before: &ArmSet<R>) -> Result<ArmSet<R>, Refusal> {
        let q = self.joints_at(at, &before.q)?;
        Ok(ArmSet { q, pose: *at })
    }

    fn joints(&self, set: &ArmSet<R>) -> Joints<6, R> {
        set.q
    }

    fn change(&self, from: &ArmSet<R>, to: &ArmSet<R>) -> Joints<6, R> {
        to.q.zip_map(&from.q, |to, from| to - from)
    }

    fn bound(&self, from: &ArmSet<R>, to: &ArmSet<R>, _length: R, _chord: R) -> (R, Option<R>) {
        let most = R::of(MOST_TURN);
        let is_small = self.change(from, to).0.iter().all(|q| q.abs() <= most);
        let Some(way) = PoseWay::new(from.pose, to.pose).filter(|_| is_small) else {
            return unknown();
        };
        sampled(|u| {
            let found = self.forward(&between(&from.q, &to.q, u));
            let wanted = way.at(u);
            let turned = rotation_vector(found.rotation * wanted.rotation.transposed());
            ((found.p - wanted.p).norm(), turned.norm())
        })
    }

    /// A full turn taken back: the branch itself never changes.
    fn is_reconfigured(
        &self,
        (_, from): (&Pose<R>, &ArmSet<R>),
        (_, to): (&Pose<R>, &ArmSet<R>),
    ) -> bool {
        let half = R::PI * R::of(1.0 + 1e-6);
        self.change(from, to).0.iter().any(|q| q.abs() > half)
    }

    /// Singular poses are refused.
    fn is_singular(&self, _set: &ArmSet<R>) -> bool {
        false
    }

    fn speeds(&self) -> Option<Joints<6, R>> {
        self.speeds
    }
}
