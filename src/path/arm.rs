//! A six-axis arm with a process's tool on its flange: points on a surface -> poses of the tool.
//!
//! ```text
//! precession   p, n               -> stretch of poses: the ball's centre C, axis P, turn-free frame
//! grinding     p, n, feed, k      -> the wheel's pose: z = -n, x = feed; the feed from the contact where depth is constant
//! ```
//!
//! The tool frame's z axis points out of the flange into the work, against the tool axis.

use super::points::{Mark, Pace, Process, Tooled};
use crate::cycles::precession::{Contact, Precession, PrecessionError, Stance, Stretch};
use crate::cycles::surface_grinding::{Grinding, GrindingError, wheel_pose};
use crate::geometry::nurbs::Section;
use crate::geometry::{Pose, Rotation, Vector};
use crate::joints::Joints;
use crate::kinematics::follow::{Feed, Guide};
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

/// Rows of a surface, ground point by point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rows {
    pub grinding: Grinding<f32>,
    /// Half the wheel's width [mm]; 0: not looked at.
    pub half_width: f32,
    /// Where the depth is not constant [mm/s].
    pub feed: f32,
    /// Every other row backwards: the wheel's axle stays as it is.
    pub zigzag: bool,
    pub rows: u32,
}

/// What an arm's tool does.
// One of them at a time, in the place of the largest.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum ArmWork {
    Precession(Precession<f32>),
    Grinding(Rows),
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
#[derive(Clone, Debug, PartialEq)]
pub enum ArmMarks {
    Stretch(Stretch<f32>),
    One(Option<Mark<Pose<f32>>>),
}

impl Iterator for ArmMarks {
    type Item = Mark<Pose<f32>>;

    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Self::Stretch(stretch) => stretch.next().map(|stance| bonnet(&stance)),
            Self::One(mark) => mark.take(),
        }
    }
}

/// The bonnet's pose.
fn bonnet(stance: &Stance<f32>) -> Mark<Pose<f32>> {
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
        pace: if stance.dt > 0.0 {
            Pace::Feed(Feed::Time(stance.dt))
        } else {
            Pace::Apart
        },
    }
}

impl Process for ArmWork {
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
                let stretch = precession.push(contact).map_err(WorkError::Precession)?;
                Ok(ArmMarks::Stretch(stretch))
            }
            Self::Grinding(rows) => rows.mark(point).map(|mark| ArmMarks::One(Some(mark))),
        }
    }

    fn finish(&mut self) -> Result<ArmMarks, WorkError> {
        match self {
            Self::Precession(precession) => {
                let rest = precession.finish().map_err(WorkError::Precession)?;
                Ok(ArmMarks::Stretch(rest))
            }
            Self::Grinding(_) => Ok(ArmMarks::One(None)),
        }
    }
}

impl Rows {
    fn mark(&mut self, point: &SurfacePoint) -> Result<Mark<Pose<f32>>, WorkError> {
        let feed = point.feed.ok_or(WorkError::NoFeed)?;
        let bad = WorkError::Grinding(GrindingError::BadPose);
        if !(point.p.is_finite() && point.n.is_finite() && feed.is_finite()) {
            return Err(bad);
        }
        // Seven digits of a line are unit vectors at right angles to seven digits; more than that is a mistake.
        const SKEW: f32 = 0.01;
        let n = point.n.unit(1e-6).ok_or(bad)?;
        let along = feed.unit(1e-6).ok_or(bad)?;
        if along.dot(n).abs() > SKEW {
            return Err(bad);
        }
        let feed = (along - n * along.dot(n)).unit(0.5).ok_or(bad)?;
        let [k_f, k_c, tau] = point.curvature;
        let section = Section {
            feed,
            cross: n.cross(feed),
            k_f,
            k_c,
            tau,
        };
        let of_grinding = WorkError::Grinding;
        let grinding = &self.grinding;
        let mut contact = grinding.hertz.on(&section).map_err(of_grinding)?;
        if self.half_width > 0.0 {
            contact = contact.within(self.half_width).map_err(of_grinding)?;
        }
        grinding.pitch_on(&section).map_err(of_grinding)?;
        let speed = grinding.feed(&contact, self.feed).map_err(of_grinding)?;
        let rows = self
            .rows
            .wrapping_add(u32::from(point.begins || self.rows == 0));
        let mut pose = wheel_pose(point.p, n, &section).map_err(of_grinding)?;
        if self.zigzag && rows % 2 == 0 {
            // Half a turn about the tool's z axis.
            pose.rotation.n = -pose.rotation.n;
            pose.rotation.s = -pose.rotation.s;
        }
        let begins = rows != self.rows;
        self.rows = rows;
        Ok(Mark {
            end: pose,
            pace: if begins {
                Pace::Apart
            } else {
                Pace::Feed(Feed::Tip(speed))
            },
        })
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
