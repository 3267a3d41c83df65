//! Poses of a job -> joint blocks, all of them or an error that says at which pose and why.
//!
//! The tolerances are shared: chords of joints may stray by [`CHORDS`] of them, and the planner, which rounds the corners
//! between the chords, has what [`left_for_corners`] leaves.

use crate::job::{Job, JobError, Model, Pace, PoseMachine, PoseRow, PosesJob};
use crate::reference::matrix::distance;
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::chord::ChainSet;
use hexstep::kinematics::follow::{End, Feed, Follower, Guide, Refusal, Tolerance};
use hexstep::kinematics::inverse::{Failure, Target};
use hexstep::kinematics::way::Course;
use hexstep::kinematics::{ClPoint, PoseWay, Way, inverse};
use hexstep::machines::arm::{self, Arm, ArmSet, OneBranch};
use hexstep::machines::five_axis::{self, Axis, FiveAxis, Layer, PathChoice, Solution, Turned};
use hexstep::machines::two_sided::SideError;
use hexstep::path::points::left_for_corners;

/// Share of both tolerances that the chords of the joints may use.
pub const CHORDS: f64 = 0.85;

/// A straight move of the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedBlock {
    /// It is part of the stretch from pose `segment` to the next, and ends at `u` of it, 0 ..= 1.
    pub segment: usize,
    pub u: f64,
    /// Joints at its end [mm, deg]; joints that the machine has not are 0.
    pub joints: [f64; 6],
    /// Least duration [s].
    pub duration: f64,
    /// The joint whose speed stretches it; `None` when the feed rules.
    pub limited_by: Option<usize>,
    /// It ends at a pole or on the border of what can be reached.
    pub singular: bool,
}

/// What a job will do.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Joints of the first pose [mm, deg].
    pub start: [f64; 6],
    pub blocks: Vec<PlannedBlock>,
    /// How far a unit of each joint carries the tip at most, along this path [mm per mm or deg].
    pub levers: [f64; 6],
    /// What the planner may leave the contour by, in joints weighed with `levers` [mm].
    pub contour: f64,
    /// The arm's branch.
    pub branch: Option<u8>,
    /// What a machine with too few joints that turn leaves of the direction, largest at the blocks' ends [deg]; 0 for
    /// all others.
    pub residual: f64,
}

/// States that the choice of solutions keeps for a pose, and poses that it looks ahead.
const STATES: usize = 64;
const WINDOW: usize = 1024;

type Blocks = ([f64; 6], Vec<PlannedBlock>);

impl Plan {
    /// Joints for every pose of the job.
    ///
    /// # Errors
    /// Every refusal of the machine and of the follower, at the pose that the stretch leads to.
    pub fn of(job: &Job, poses: &PosesJob) -> Result<Self, JobError> {
        let machine = &poses.machine;
        let tolerance = Tolerance {
            tip: CHORDS * poses.tip_tolerance,
            axis: CHORDS * poses.axis_tolerance.to_radians(),
            subdivide: true,
        };
        let task = Walk {
            job,
            poses,
            tolerance,
        };
        let mut branch = None;
        let (start, blocks) = match &machine.model {
            Model::FiveAxis(five) => task.five_axis(five)?,
            Model::Arm { arm, tool, speeds } => {
                let (number, walked) = task.arm(arm, *tool, *speeds)?;
                branch = Some(number);
                walked
            }
            Model::Side(side) => task.side(side)?,
            Model::Chain(chain) => task.chain(chain)?,
        };
        let residual = match &machine.model {
            Model::Side(_) => task.residual(&start, &blocks)?,
            _ => 0.0,
        };
        let levers = levers(machine, &start, &blocks);
        let turning = machine.joints.iter().filter(|joint| joint.turns).count();
        let contour = left_for_corners(poses.tip_tolerance, CHORDS, turning as u8 + 1);
        // Where the tip lies on an axis it does not feel the turn, but the tool does.
        let least = contour / left_for_corners(poses.axis_tolerance, CHORDS, 1);
        let levers = std::array::from_fn(|i| match machine.joints.get(i) {
            Some(joint) if joint.turns => levers[i].max(least),
            _ => 1.0,
        });
        Ok(Self {
            start,
            blocks,
            levers,
            contour,
            branch,
            residual,
        })
    }

    /// Least time of the whole path [s].
    pub fn duration(&self) -> f64 {
        self.blocks.iter().map(|block| block.duration).sum()
    }
}

/// Reading a path through the eyes of a machine.
struct Walk<'a> {
    job: &'a Job,
    poses: &'a PosesJob,
    tolerance: Tolerance<f64>,
}

impl Walk<'_> {
    fn near(&self) -> [f64; 6] {
        std::array::from_fn(|i| {
            let joint = self.poses.machine.joints.get(i);
            joint.map_or(0.0, |joint| joint.to_library(self.poses.near[i]))
        })
    }

    fn cl(&self, index: usize) -> Result<ClPoint<f64>, JobError> {
        let row = &self.poses.rows[index];
        let made = ClPoint::new(Vector::from_array(row.tip), Vector::from_array(row.axis));
        made.ok_or_else(|| self.refuse(index, "BadDirection", "no tool axis".into()))
    }

    fn refuse(&self, index: usize, name: &'static str, detail: String) -> JobError {
        self.poses.refuse(self.job, index, name, detail)
    }

    fn joint(&self, index: usize) -> &str {
        let joint = self.poses.machine.joints.get(index);
        joint.map_or("a joint", |joint| joint.name.as_str())
    }

    fn out_of_travel(&self, joint: usize) -> (&'static str, String) {
        let of = self.poses.machine.joints.get(joint);
        let (lo, hi) = of.map_or((0.0, 0.0), |joint| joint.limits.travel);
        let detail = format!(
            "{} would leave its travel of {lo} to {hi}; widen machine.travel[{joint}] if the machine allows it, move the work, or choose other joints for the first pose with near",
            self.joint(joint)
        );
        ("OutOfTravel", detail)
    }

    fn five_axis(&self, machine: &five_axis::FiveAxis<f64>) -> Result<Blocks, JobError> {
        let [_, _, _, primary, secondary, _] = self.near();
        let near = [primary, secondary].map(Turned::from_total);
        let first = self.cl(0)?;
        let told = |error: &five_axis::Error<f64>| match error {
            five_axis::Error::Unreachable { gap, .. } => (
                error.name(),
                format!(
                    "no angles give this tool axis: it misses the reachable tilts by {:.6} deg",
                    gap.to_degrees()
                ),
            ),
            five_axis::Error::OutOfTravel { axis } => {
                let joint = Axis::ALL.iter().position(|known| known == axis);
                self.out_of_travel(joint.unwrap_or(0))
            }
            other => (other.name(), "the machine cannot take this pose".into()),
        };
        let refused = |index: usize, error: &five_axis::Error<f64>| {
            let (name, detail) = told(error);
            self.refuse(index, name, detail)
        };
        if self.poses.chooses_best {
            let chosen = self.choose(machine, near, refused)?;
            let first_set = chosen[0];
            let end = |index| Ok((self.cl(index)?, Some(chosen[index])));
            return self.follow(machine, first, first_set, end, told);
        }
        let set = machine.inverse(first.p(), first.v(), &near);
        let set = set.map_err(|error| refused(0, &error))?;
        self.follow(machine, first, set, self.greedy(), told)
    }

    /// The CL points alone: their joints are those nearest to the ones before.
    fn greedy<S>(&self) -> impl Fn(usize) -> Result<(ClPoint<f64>, Option<S>), JobError> {
        |index| Ok((self.cl(index)?, None))
    }

    /// Joints of every pose with the least turning over the whole path.
    fn choose(
        &self,
        machine: &FiveAxis<f64>,
        near: [Turned<f64>; 2],
        refused: impl Fn(usize, &five_axis::Error<f64>) -> JobError,
    ) -> Result<Vec<Solution<f64>>, JobError> {
        let count = self.poses.rows.len();
        let mut layers = vec![Layer::<f64, STATES>::empty(); count.min(WINDOW)];
        let mut choice = PathChoice::new(machine, &mut layers, near);
        let mut chosen: Vec<Solution<f64>> = Vec::with_capacity(count);
        for index in 0..count {
            if choice.is_full()
                && let Some(solution) = choice.pop()
            {
                let solution = solution.map_err(|error| refused(chosen.len(), &error))?;
                chosen.push(solution);
            }
            let at = self.cl(index)?;
            let pushed = choice.push(at.p(), at.v());
            pushed.map_err(|error| refused(index, &error))?;
        }
        while let Some(solution) = choice.pop() {
            let solution = solution.map_err(|error| refused(chosen.len(), &error))?;
            chosen.push(solution);
        }
        Ok(chosen)
    }

    /// Largest angle between the tool axes that are wanted and those of the reference at the blocks' ends [deg].
    fn residual(&self, start: &[f64; 6], blocks: &[PlannedBlock]) -> Result<f64, JobError> {
        let machine = &self.poses.machine;
        let axis = |joints: &[f64; 6]| {
            let q = std::array::from_fn(|i| {
                let joint = machine.joints.get(i);
                joint.map_or(0.0, |joint| joint.to_library(joints[i]))
            });
            Vector::from_array(machine.forward.at(&q).axis)
        };
        let mut largest = axis(start).angle_to(self.cl(0)?.v());
        for block in blocks {
            let ends = (self.cl(block.segment)?, self.cl(block.segment + 1)?);
            // A stretch that was followed has a way.
            if let Some(way) = Way::new(ends.0, ends.1) {
                largest = largest.max(axis(&block.joints).angle_to(way.at(block.u).v()));
            }
        }
        Ok(largest.to_degrees())
    }

    fn side(&self, machine: &SideGuide) -> Result<Blocks, JobError> {
        let first = self.cl(0)?;
        let told = |error: &SideError<6, f64>| match error {
            SideError::OutOfTravel { joint } => self.out_of_travel(*joint),
            SideError::Unreachable { gap, .. } => (
                "Unreachable",
                format!(
                    "no angles give this tool axis: it misses the reachable tilts by {:.6} deg",
                    gap.to_degrees()
                ),
            ),
            other => (other.name(), "the machine cannot take this pose".into()),
        };
        let found = machine
            .machine
            .inverse(first.p(), first.v(), &Joints(self.near()));
        self.follow_from(machine, first, found.map(|found| found.q), told)
    }

    fn chain(&self, machine: &ChainGuide) -> Result<Blocks, JobError> {
        let first = self.cl(0)?;
        let told = |error: &Failure<f64>| match error {
            Failure::OutOfTravel { joint } => self.out_of_travel(*joint),
            Failure::NoConvergence(report) => (
                "Unreachable",
                format!(
                    "no joints were found from those before (nearest approach: tip {:.6} mm, axis {:.6} deg off); move the pose into reach, or start nearer with near",
                    report.tip_error,
                    report.direction_error.to_degrees()
                ),
            ),
            Failure::BadDirection => ("BadDirection", "no tool axis".into()),
            _ => ("NonFinite", "the machine cannot take this pose".into()),
        };
        let target = Target::TipAxis {
            p: first.p(),
            o: first.v(),
        };
        let found = machine.machine.inverse(
            &target,
            &Joints(self.near()),
            &inverse::Tolerance::default(),
        );
        let found = found.map(|found| found.q).map_err(|refused| refused.why);
        self.follow_from(machine, first, found, told)
    }

    /// From the joints found for the first pose on, each solution near the one before.
    fn follow_from<M>(
        &self,
        machine: &M,
        first: ClPoint<f64>,
        found: Result<Joints<6, f64>, M::Error>,
        told: impl Fn(&M::Error) -> (&'static str, String),
    ) -> Result<Blocks, JobError>
    where
        M: Guide<6, f64, Course = Way<f64>, Set = ChainSet<6, f64>>,
    {
        let q = found.map_err(|error| {
            let (name, detail) = told(&error);
            self.refuse(0, name, detail)
        })?;
        let set = ChainSet {
            q,
            at: first,
            singular: false,
        };
        self.follow(machine, first, set, self.greedy(), told)
    }

    fn arm(
        &self,
        arm: &Arm<f64>,
        tool: Pose<f64>,
        speeds: Joints<6, f64>,
    ) -> Result<(u8, Blocks), JobError> {
        let near = Joints(self.near());
        let mut guide = OneBranch {
            arm: *arm,
            branch: 0,
            tool,
            work: self.poses.machine.work(),
            speeds: Some(speeds),
        };
        let poses: Vec<Pose<f64>> = self.poses.rows.iter().map(arm_pose).collect();
        // The branch is chosen along the whole path, not at its given poses alone: they may lie far apart.
        const PARTS: usize = 64;
        let mut stretch = arm::Stretch::new(Some(near));
        let add = |stretch: &mut arm::Stretch<f64>, pose: &Pose<f64>, index| {
            let added = stretch.add(arm, &guide.flange(pose));
            added.map_err(|_| self.refuse(index, "BadPose", "it is no pose".into()))
        };
        add(&mut stretch, &poses[0], 0)?;
        for (index, pair) in poses.windows(2).enumerate() {
            let Some(way) = PoseWay::new(pair[0], pair[1]) else {
                return Err(self.anti_parallel(index + 1));
            };
            for k in 1..=PARTS {
                let at = way.at(k as f64 / PARTS as f64);
                add(&mut stretch, &at, index + 1)?;
            }
        }
        let (branch, _) = stretch.best().map_err(|none| {
            let reasons = (0..).zip(none.reasons).filter_map(|(branch, why)| {
                let (at, why) = why?;
                let at = at as f64 / PARTS as f64;
                Some(format!("branch {branch}: {} at {at:.2}", self.told_arm(&why).0))
            });
            let last = none.reasons.iter().flatten().map(|(at, _)| *at).max();
            let index = (last.unwrap_or(0) as usize).div_ceil(PARTS);
            let detail = format!(
                "no branch of the arm serves the whole path, this pose is the last that one comes near ({}; places count the poses); move the work, or split the path",
                reasons.collect::<Vec<_>>().join(", ")
            );
            self.refuse(index.min(poses.len() - 1), "NoBranch", detail)
        })?;
        guide.branch = branch;
        let told = |why: &arm::Refusal| self.told_arm(why);
        let q = guide.joints_at(&poses[0], &near).map_err(|why| {
            let (name, detail) = told(&why);
            self.refuse(0, name, detail)
        })?;
        let set = ArmSet { q, pose: poses[0] };
        let walked = self.follow(
            &guide,
            poses[0],
            set,
            |index| Ok((poses[index], None)),
            told,
        )?;
        Ok((branch, walked))
    }

    fn told_arm(&self, why: &arm::Refusal) -> (&'static str, String) {
        use arm::Refusal;
        let near_singular = "the arm comes within a degree (or a millimetre) of a singular pose";
        match why {
            Refusal::NotReached => ("Unreachable", "it is out of the arm's reach".into()),
            Refusal::OutOfTravel => (
                "OutOfTravel",
                "a joint would leave its travel; widen machine.travel, or move the work".into(),
            ),
            Refusal::WristSingular => ("WristSingular", near_singular.into()),
            Refusal::ElbowSingular => ("ElbowSingular", near_singular.into()),
            Refusal::ShoulderSingular => ("ShoulderSingular", near_singular.into()),
            Refusal::Jump { joint } => (
                "Jump",
                format!("{} would jump", self.joint(usize::from(*joint))),
            ),
        }
    }

    fn anti_parallel(&self, index: usize) -> JobError {
        let detail = "the tool is turned by half a turn from the pose before, which leaves the way open; give a pose between them";
        self.refuse(index, "AntiParallel", detail.into())
    }

    /// All blocks from the first pose to the last.
    fn follow<M, const N: usize>(
        &self,
        machine: &M,
        first: End<M::Course, f64>,
        set: M::Set,
        end: impl Fn(usize) -> Result<(End<M::Course, f64>, Option<M::Set>), JobError>,
        told: impl Fn(&M::Error) -> (&'static str, String),
    ) -> Result<Blocks, JobError>
    where
        M: Guide<N, f64>,
    {
        let start = self.in_job_units(&machine.joints(&set));
        let refuse = |index: usize, u: f64, why: &Refusal<M::Error>| {
            let (name, detail) = match why {
                Refusal::AntiParallel => return self.anti_parallel(index),
                Refusal::BadFeed => (
                    "BadFeed",
                    "the tip stands still, so its feed gives no time".into(),
                ),
                Refusal::BadLimit => ("BadLimit", "a tolerance is not above 0".into()),
                Refusal::Machine(error) => told(error),
            };
            self.refuse(index, name, format!("{}: {detail}", place(index, u)))
        };
        let follower = Follower::new(machine, self.tolerance, first, set);
        let mut follower = follower.map_err(|why| refuse(0, 0.0, &why))?;
        let mut blocks = Vec::new();
        for (index, row) in self.poses.rows.iter().enumerate().skip(1) {
            let feed = match row.pace {
                Pace::Feed(feed) => Feed::Tip(feed / 60.0),
                Pace::InverseTime(rate) => Feed::Time(60.0 / rate),
                // Joints as fast as they can: no pose asks for it.
                Pace::Rapid => Feed::Time(1e-9),
            };
            let (to, chosen) = end(index)?;
            let pushed = follower.push(to, chosen, feed);
            pushed.map_err(|refused| refuse(index, refused.u, &refused.why))?;
            while let Some(block) = follower.next_block() {
                let at = place(index, block.u);
                if block.flags.reconfigure {
                    let detail = format!(
                        "{at}: the joints would change to another solution or wind back, with the tool in the work; split the path there"
                    );
                    return Err(self.refuse(index, "Reconfigure", detail));
                }
                if block.flags.coarse {
                    let detail = format!(
                        "{at}: joints turn so fast beside a pole that 4096 parts of the stretch do not keep the tolerance; lead the path through the pole or farther from it, or raise tip_tolerance and axis_tolerance"
                    );
                    return Err(self.refuse(index, "Coarse", detail));
                }
                blocks.push(PlannedBlock {
                    segment: index - 1,
                    u: block.u,
                    joints: self.in_job_units(&block.joints),
                    duration: block.duration,
                    limited_by: block.limited_by,
                    singular: block.flags.singular,
                });
            }
        }
        Ok((start, blocks))
    }

    fn in_job_units<const N: usize>(&self, q: &Joints<N, f64>) -> [f64; 6] {
        std::array::from_fn(|i| match (self.poses.machine.joints.get(i), q.0.get(i)) {
            (Some(joint), Some(q)) => joint.from_library(*q),
            _ => 0.0,
        })
    }
}

type SideGuide =
    hexstep::kinematics::chord::Paced<hexstep::machines::two_sided::Side<6, f64>, 6, f64>;
type ChainGuide =
    hexstep::kinematics::chord::Paced<hexstep::kinematics::chain::Chain<6, f64>, 6, f64>;

fn place(index: usize, u: f64) -> String {
    match index {
        0 => "pose 0".into(),
        _ if u >= 1.0 => format!("pose {index}"),
        _ => format!("between pose {} and pose {index}, at {u:.4}", index - 1),
    }
}

/// The tool frame of an arm: z out of the flange, against the tool axis.
fn arm_pose(row: &PoseRow) -> Pose<f64> {
    let a = -Vector::from_array(row.axis);
    // Set when the job is read.
    let n = Vector::from_array(row.across.unwrap_or([1.0, 0.0, 0.0]));
    Pose {
        rotation: Rotation {
            n,
            s: a.cross(n),
            a,
        },
        p: Vector::from_array(row.tip),
    }
}

/// Way of the tip per unit of each joint, largest along the path [mm per mm or deg]: differences of the reference.
fn levers(machine: &PoseMachine, start: &[f64; 6], blocks: &[PlannedBlock]) -> [f64; 6] {
    let library = |joints: &[f64; 6]| -> [f64; 6] {
        std::array::from_fn(|i| {
            let joint = machine.joints.get(i);
            joint.map_or(0.0, |joint| joint.to_library(joints[i]))
        })
    };
    let mut levers = [0.0f64; 6];
    // Between neighbouring blocks next to nothing changes: a few hundred places are enough.
    let every = (blocks.len() / 300).max(1);
    let ends = blocks.iter().step_by(every).map(|block| &block.joints);
    for joints in std::iter::once(start).chain(ends) {
        let q = library(joints);
        let here = machine.forward.at(&q).tip;
        for (i, joint) in machine.joints.iter().enumerate() {
            let mut moved = q;
            let h = 1e-4;
            moved[i] += h;
            let way = distance(machine.forward.at(&moved).tip, here) / h;
            let per_unit = if joint.turns { way.to_radians() } else { way };
            levers[i] = levers[i].max(per_unit);
        }
    }
    levers
}
