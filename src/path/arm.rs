//! A six-axis arm with a process's tool on its flange: points on a surface -> poses of the tool.
//!
//! ```text
//! precession   p, n               -> stretch of poses: the ball's centre C, axis P, turn-free frame
//! grinding     p, n, feed, k      -> the wheel's pose: z = -n, x = feed; the feed from the contact where depth is constant
//! ```
//!
//! The tool frame's z axis points out of the flange into the work, against the tool axis.

use super::points::Tooled;
use crate::cycles::precession::{BonnetMarks, Contact, Precession, PrecessionError};
use crate::cycles::surface_grinding::{GrindingError, RowPoint, Rows};
use crate::cycles::{Mark, OneMark, Process};
use crate::geometry::{Pose, Vector};
use crate::joints::Joints;
use crate::kinematics::follow::Guide;
use crate::machines::arm::{ArmSet, OneBranch, Refusal};

impl Tooled<6> for OneBranch<f32> {
    /// Of the branches that reach the first pose, the one with the least turning from where the arm stands.
    fn choose(&mut self, first: &Pose<f32>, near: &Joints<6>) -> Result<bool, Refusal> {
        let found = self.arm.inverse(&self.flange(first), Some(near));
        let found = found.map_err(|_| Refusal::NotReached)?;
        let way = |q: &Joints<6>| {
            let change = q.zip_map(near, |to, from| to - from);
            change.dot(&change)
        };
        let good = found.as_slice().iter().filter(|s| {
            s.in_limits && !s.wrist_singular && !s.elbow_singular && !s.shoulder_singular
        });
        let best = good.min_by(|a, b| way(&a.q).total_cmp(&way(&b.q)));
        if let Some(best) = best {
            self.branch = best.branch;
        }
        Ok(best.is_some())
    }

    fn reach(&self, at: &Pose<f32>, near: &Joints<6>) -> Result<ArmSet<f32>, Refusal> {
        let before = ArmSet {
            q: *near,
            pose: *at,
        };
        self.solve(at, &before)
    }

    /// Along the tool.
    fn draw_back(
        &self,
        at: &Pose<f32>,
        set: &ArmSet<f32>,
        clear: f32,
    ) -> Result<Joints<6>, Refusal> {
        let back = Pose {
            p: at.p - at.rotation.a * clear,
            ..*at
        };
        self.joints_at(&back, &set.q)
    }
}

/// A point of the surface, as it is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// [mm]
    pub p: Vector<f32>,
    /// Outward normal, any length from 1e-6.
    pub n: Vector<f32>,
    /// Which way the row goes, where that counts.
    pub feed: Option<Vector<f32>>,
    /// k_f, k_c, tau [1/mm].
    pub curvature: [f32; 3],
    /// It is the first of a row.
    pub begins: bool,
}

/// What an arm's tool does.
// One of them at a time, in the place of the largest.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum ArmWork {
    Precession(Precession<f32>),
    Grinding(Rows<f32>),
}

/// Why a point cannot be worked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorkError {
    Precession(PrecessionError),
    Grinding(GrindingError<f32>),
    /// Rows are for grinding; a precession is one path.
    NoRows,
    /// No feed direction was given.
    NoFeed,
}

/// Marks of one point.
// One at a time, in the place of the largest.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
pub enum ArmMarks {
    Bonnet(BonnetMarks<f32>),
    Wheel(OneMark<Pose<f32>, f32>),
}

impl Iterator for ArmMarks {
    type Item = Mark<Pose<f32>, f32>;

    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Self::Bonnet(marks) => marks.next(),
            Self::Wheel(marks) => marks.next(),
        }
    }
}

impl Process<f32> for ArmWork {
    type Point = SurfacePoint;
    type End = Pose<f32>;
    type Marks = ArmMarks;
    type Error = WorkError;

    fn take(&mut self, point: &SurfacePoint) -> Result<ArmMarks, WorkError> {
        match self {
            Self::Precession(precession) => {
                if point.begins && precession.has_point() {
                    return Err(WorkError::NoRows);
                }
                let contact = Contact {
                    p: point.p,
                    n: point.n,
                };
                let marks = precession.take(&contact).map_err(WorkError::Precession)?;
                Ok(ArmMarks::Bonnet(marks))
            }
            Self::Grinding(rows) => {
                let contact = RowPoint {
                    p: point.p,
                    n: point.n,
                    feed: point.feed.ok_or(WorkError::NoFeed)?,
                    curvature: point.curvature,
                    begins: point.begins,
                };
                let marks = rows.take(&contact).map_err(WorkError::Grinding)?;
                Ok(ArmMarks::Wheel(marks))
            }
        }
    }

    fn finish(&mut self) -> Result<ArmMarks, WorkError> {
        match self {
            Self::Precession(precession) => Process::finish(precession)
                .map(ArmMarks::Bonnet)
                .map_err(WorkError::Precession),
            Self::Grinding(rows) => rows
                .finish()
                .map(ArmMarks::Wheel)
                .map_err(WorkError::Grinding),
        }
    }
}

impl WorkError {
    /// The name under which every interface reports it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Precession(error) => error.name(),
            Self::Grinding(error) => error.name(),
            Self::NoRows | Self::NoFeed => "BadPath",
        }
    }

    /// What was expected, as a sentence.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::Precession(error) => error.remedy(),
            Self::Grinding(error) => error.remedy(),
            Self::NoRows => "a precession is one path; end it with $POINT=END and run another",
            Self::NoFeed => {
                "a point to be ground needs nine numbers or twelve: place, normal, direction of the row, and k_f, k_c, tau"
            }
        }
    }
}
