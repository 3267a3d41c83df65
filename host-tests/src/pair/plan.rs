//! Rows of a panel -> blocks of eight joints, or an error that says on which row and why.
//!
//! ```text
//!  lifted |<---------- transit, back above the next row -----------|
//!         | engage                                         retract |
//!         '------------------- row, trimmed ---------------------->'
//! ```
//!
//! Lifted, the cutter stands off the panel along its normal and the support on the other side, each by the same length.
//! The tolerances are shared between chords and corners as for any other poses, see [`crate::poses`].

use crate::job::{Job, JobError, PairJob, PairRow};
use crate::poses::CHORDS;
use crate::reference::matrix::{angle_deg, distance};
use hexstep::joints::Joints;
use hexstep::kinematics::ClPoint;
use hexstep::kinematics::chord::ChainSet;
use hexstep::kinematics::follow::{Feed, Follower, Guide, Refusal, Tolerance};
use hexstep::machines::two_sided::{AtWall, PairGuide};
use hexstep::path::points::left_for_corners;

/// A straight move of the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairBlock {
    /// It ends at `u`, 0 ..= 1, of the stretch to point `point` of its leg.
    pub point: usize,
    pub u: f64,
    /// Joints at its end [mm, deg].
    pub joints: [f64; 8],
    /// Least duration [s].
    pub duration: f64,
}

/// What a leg is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    Engage,
    /// A row of the job, by its index: trimmed live.
    Row(usize),
    Retract,
    Transit,
}

/// From standstill to standstill.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    pub what: What,
    pub blocks: Vec<PairBlock>,
}

/// What a pair will do.
#[derive(Clone, Debug)]
pub struct PairPlan {
    /// Joints above the start of the first row [mm, deg].
    pub start: [f64; 8],
    pub legs: Vec<Leg>,
    /// Wall that both sides are asked for [mm].
    pub wall: f64,
    /// Distance of the tips from the axes that turn, the larger [mm].
    pub lever: f64,
    /// What the planner may leave the contour by [mm].
    pub contour: f64,
    /// What the machine cannot turn to, largest on the rows [deg].
    pub residual: f64,
}

/// How the panel is milled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Milling {
    /// [mm]
    pub wall: f64,
    /// Along the rows [mm/s].
    pub feed: f64,
    /// Largest trim [mm]: within the travel all along the rows, both ways.
    pub amount: f64,
}

type Point = ClPoint<f64>;
type Set = ChainSet<8, f64>;

impl PairPlan {
    /// Joints for all rows of the job.
    ///
    /// # Errors
    /// What either side refuses, and `OutOfTravel` where a trim of the largest amount would leave the travel.
    pub fn of(job: &Job, pair: &PairJob, milling: &Milling) -> Result<Self, JobError> {
        let guide = |wall| PairGuide {
            machine: AtWall {
                pair: pair.pair,
                wall,
            },
            speeds: Some(Joints(std::array::from_fn(|i| {
                let joint = &pair.joints[i];
                joint.to_library(joint.limits.max_rate)
            }))),
        };
        let task = Task {
            job,
            pair,
            milling,
            milled: guide(milling.wall),
            lifted: guide(milling.wall + 2.0 * pair.lift),
        };
        let near = Joints(std::array::from_fn(|i| {
            pair.joints[i].to_library(pair.near[i])
        }));
        let above = |row: &PairRow| -> Vec<Point> {
            let lifted = row.points.iter().map(|at| task.off(at));
            lifted.collect()
        };
        let (mut legs, mut residual) = (Vec::new(), 0.0f64);
        let mut set = Set {
            q: near,
            at: pair.rows[0].points[0],
            singular: false,
        };
        let mut start = None;
        let mut from: Option<Point> = None;
        for (index, row) in pair.rows.iter().enumerate() {
            let over = above(row);
            let (first, last) = (over[0], over[over.len() - 1]);
            if let Some(from) = from {
                // Back above the row to come: as curved as it is, but no finer than it need be.
                let mut way = vec![from];
                way.extend(over.iter().rev().step_by(8));
                if way.last() != Some(&first) {
                    way.push(first);
                }
                let (blocks, end) =
                    task.follow(&task.lifted, &way, set, pair.transit, &row.name)?;
                set = end;
                legs.push(Leg {
                    what: What::Transit,
                    blocks,
                });
            } else {
                set = task.solve(&task.lifted, &first, &set, &row.name)?;
                start = Some(task.in_job_units(&set));
            }
            let engaged = task.solve(&task.milled, &row.points[0], &set, &row.name)?;
            legs.push(task.straight(What::Engage, &engaged));
            let (blocks, end) =
                task.follow(&task.milled, &row.points, engaged, milling.feed, &row.name)?;
            task.check_trims(row, &engaged)?;
            residual = residual.max(task.residual(row, &blocks));
            legs.push(Leg {
                what: What::Row(index),
                blocks,
            });
            set = task.solve(&task.lifted, &last, &end, &row.name)?;
            legs.push(task.straight(What::Retract, &set));
            from = Some(last);
        }
        let start = start.unwrap_or_default();
        let lever = lever(pair, &start, &legs);
        // On each side the joints that slide may add up with the one that turns.
        let contour = left_for_corners(pair.tip_tolerance, CHORDS, 2);
        let least = contour / left_for_corners(pair.axis_tolerance.to_radians(), CHORDS, 1);
        Ok(Self {
            start,
            legs,
            wall: milling.wall,
            lever: lever.max(least),
            contour,
            residual,
        })
    }

    /// Least time of all legs [s].
    pub fn duration(&self) -> f64 {
        let blocks = self.legs.iter().flat_map(|leg| &leg.blocks);
        blocks.map(|block| block.duration).sum()
    }
}

struct Task<'a> {
    job: &'a Job,
    pair: &'a PairJob,
    milling: &'a Milling,
    milled: PairGuide<f64>,
    lifted: PairGuide<f64>,
}

impl Task<'_> {
    /// The support's place when both sides are lifted.
    fn off(&self, at: &Point) -> Point {
        let p = at.p() - at.v() * self.pair.lift;
        // Its normal is a unit vector, and a lift is finite.
        Point::new(p, at.v()).unwrap_or(*at)
    }

    fn in_job_units(&self, set: &Set) -> [f64; 8] {
        std::array::from_fn(|i| self.pair.joints[i].from_library(set.q.0[i]))
    }

    fn solve(
        &self,
        guide: &PairGuide<f64>,
        at: &Point,
        before: &Set,
        row: &str,
    ) -> Result<Set, JobError> {
        let found = guide.solve(at, before);
        found.map_err(|error| self.pair.refuse(self.job, &error, row))
    }

    /// One straight move as fast as the joints can.
    fn straight(&self, what: What, to: &Set) -> Leg {
        let block = PairBlock {
            point: 1,
            u: 1.0,
            joints: self.in_job_units(to),
            duration: 0.0,
        };
        Leg {
            what,
            blocks: vec![block],
        }
    }

    fn follow(
        &self,
        guide: &PairGuide<f64>,
        points: &[Point],
        set: Set,
        feed: f64,
        row: &str,
    ) -> Result<(Vec<PairBlock>, Set), JobError> {
        let tolerance = Tolerance {
            tip: CHORDS * self.pair.tip_tolerance,
            axis: CHORDS * self.pair.axis_tolerance.to_radians(),
            subdivide: true,
        };
        let refuse = |index: usize, u: f64, why: &Refusal<_>| {
            let at = format!("{row}, on the way to point {index}, at {u:.4}");
            let (name, detail) = match why {
                Refusal::Machine(error) => return self.pair.refuse(self.job, error, &at),
                Refusal::AntiParallel => (
                    "AntiParallel",
                    "the normal turns by half a turn, which leaves the way open",
                ),
                Refusal::BadFeed => ("BadFeed", "the support stands still; remove the point"),
                Refusal::BadLimit => ("BadLimit", "a tolerance is not above 0"),
            };
            self.job.refuse("path", name, format!("{at}: {detail}"))
        };
        let follower = Follower::new(guide, tolerance, points[0], set);
        let mut follower = follower.map_err(|why| refuse(0, 0.0, &why))?;
        let mut blocks = Vec::new();
        for (index, to) in points.iter().enumerate().skip(1) {
            let pushed = follower.push(*to, None, Feed::Tip(feed));
            pushed.map_err(|refused| refuse(index, refused.u, &refused.why))?;
            while let Some(block) = follower.next_block() {
                if block.flags.reconfigure || block.flags.coarse {
                    let (name, detail) = if block.flags.coarse {
                        (
                            "Coarse",
                            "4096 parts of the stretch do not keep the tolerances; give points closer together",
                        )
                    } else {
                        (
                            "Reconfigure",
                            "a joint would wind back with the tool in the work",
                        )
                    };
                    let detail = format!("{row}, point {index}: {detail}");
                    return Err(self.job.refuse("path", name, detail));
                }
                blocks.push(PairBlock {
                    point: index,
                    u: block.u,
                    joints: self.in_job_units(&block.set),
                    duration: block.duration,
                });
            }
        }
        Ok((blocks, *follower.set()))
    }

    /// Largest angle between the wanted tool axes and the reached ones at the blocks' ends [deg].
    fn residual(&self, row: &PairRow, blocks: &[PairBlock]) -> f64 {
        let ends = blocks.iter().filter(|block| block.u >= 1.0);
        let off = ends.filter_map(|block| {
            let n = row.points.get(block.point)?.v().to_array();
            let [mill, support] = self.pair.tools(&block.joints);
            Some(angle_deg(mill.axis, n).max(angle_deg(support.axis, n.map(|x| -x))))
        });
        off.fold(0.0, f64::max)
    }

    /// Whether both sides have the travel for the largest trim either way, at every point of a row.
    fn check_trims(&self, row: &PairRow, start: &Set) -> Result<(), JobError> {
        let mut set = *start;
        for (index, at) in row.points.iter().enumerate() {
            set = self.solve(&self.milled, at, &set, &row.name)?;
            let (mill, support) = set.q.0.split_at(4);
            let part = |q: &[f64]| Joints(std::array::from_fn(|i| q[i]));
            for amount in [self.milling.amount, -self.milling.amount] {
                let joints = (&part(mill), &part(support));
                let trim = self.pair.pair.trim(at.v(), amount, joints);
                trim.map_err(|error| {
                    let at = format!("{}, point {index}, trimmed by {amount} mm", row.name);
                    self.pair.refuse(self.job, &error, &at)
                })?;
            }
        }
        Ok(())
    }
}

/// Way of either tip per radian of its own joint that turns, largest along the path [mm]: differences of the reference.
fn lever(pair: &PairJob, start: &[f64; 8], legs: &[Leg]) -> f64 {
    let blocks: Vec<&PairBlock> = legs.iter().flat_map(|leg| &leg.blocks).collect();
    let every = (blocks.len() / 300).max(1);
    let ends = blocks.iter().step_by(every).map(|block| &block.joints);
    let mut largest = 0.0f64;
    for joints in std::iter::once(start).chain(ends) {
        let here = pair.tools(joints);
        const H: f64 = 1e-3;
        let mut moved = *joints;
        for (joint, q) in pair.joints.iter().zip(&mut moved) {
            if joint.turns {
                *q += H;
            }
        }
        for (a, b) in here.iter().zip(pair.tools(&moved)) {
            largest = largest.max(distance(a.tip, b.tip) / H.to_radians());
        }
    }
    largest
}
