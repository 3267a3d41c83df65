//! `[machine]` and `[path]` of a mirror job: the pair of machines that mills the panel for real, on eight motors.
//!
//! ```text
//! [machine] pair = "m4"  |  "own" + [[joint]] x 8    -> Pair with its travels, and the same once more for the reference
//! [path]    rows, from, to  |  points, normals       -> PairRow: points and normals of the support-side surface
//! ```
//!
//! The controller trims both sides along the joints' directions of the pair M4, so an own pair may stand and reach
//! elsewhere, but its joints must go the same ways.

mod own;
mod rows;

use super::axes::{AXES, read_joints};
use super::model::PoseJoint;
use super::reader::{Kind, Table};
use super::{Job, JobError, Places};
use crate::mirror::Simulation;
use crate::reference::serial::{Serial, ToolAt, tools_at};
use hexstep::kinematics::ClPoint;
use hexstep::kinematics::chain::Chain;
use hexstep::machines::two_sided::{Pair, PairError, SideError};
use hexstep::stepper::Timing;
use own::{OWN, Written};

/// Motors of the pair: X1 Y1 Z1 B1 X2 Y2 Z2 B2.
pub const MOTORS: usize = 8;
/// Joints of a side.
const SIDE: usize = 4;
const NAMES: [&str; MOTORS] = ["X1", "Y1", "Z1", "B1", "X2", "Y2", "Z2", "B2"];

/// The machines, and what they mill.
#[derive(Clone, Debug)]
pub struct PairJob {
    pub name: &'static str,
    /// Eight.
    pub joints: Vec<PoseJoint>,
    /// With the travels of its joints.
    pub pair: Pair<SIDE, SIDE, f64>,
    forward: [Serial; 2],
    /// How far each tip [mm] and each tool [deg] may leave its path.
    pub tip_tolerance: f64,
    pub axis_tolerance: f64,
    /// Joints near which those of the first pose are chosen [mm, deg].
    pub near: [f64; MOTORS],
    /// How far both tools stand off between rows [mm], and how fast they go there [mm/s].
    pub lift: f64,
    pub transit: f64,
    /// Share of every motor's limits that is kept for trims.
    pub trim_share: f64,
    pub rows: Vec<PairRow>,
}

/// A row to be milled.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRow {
    /// What it is called: its y [mm], or that its points are given.
    pub name: String,
    /// Points of the support-side surface, and its normals from support to mill, in the work frame of side 1.
    pub points: Vec<ClPoint<f64>>,
}

const PATH: &[&str] = &[
    "tip_tolerance",
    "axis_tolerance",
    "near",
    "lift",
    "transit",
    "rows",
    "from",
    "to",
    "radius",
    "wave",
    "points",
    "normals",
];

impl PairJob {
    pub(super) fn read(
        root: &Table<'_>,
        simulation: &Simulation,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let machine = root.table("machine")?;
        let pair = machine.word("pair", &["m4", "m5", "own"])?;
        if pair == 1 {
            let detail = "the dual five-axis pair has ten joints and a controller has at most eight motors, so it cannot keep both sides in step; its poses are to be had by `hexstep calc mirror.solve`, and each side alone by kind = \"poses\" with model = \"two-sided\"";
            return Err(places.refuse("machine.pair", "TooManyJoints", detail.into()));
        }
        let own: &[&str] = if pair == 2 { OWN } else { &[] };
        machine.known(&[&["pair", "trim_share"], AXES, own].concat())?;
        if pair != 2 && root.has("joint") {
            let detail = "only a machine with pair = \"own\" has a list of joints; remove it";
            return Err(places.refuse("joint", "UnknownField", detail.into()));
        }
        let units = std::array::from_fn(|i| if turns(i) { "deg" } else { "mm" });
        let limits = read_joints::<MOTORS>(&machine, units, timing, places)?;
        let Written {
            chains,
            forward,
            names,
        } = match pair {
            0 => own::built_in(),
            _ => own::read(root, &machine, places)?,
        };
        let joints: Vec<PoseJoint> = limits
            .into_iter()
            .enumerate()
            .map(|(i, limits)| PoseJoint {
                name: names[i].clone(),
                turns: turns(i),
                limits,
            })
            .collect();
        let [mill, support] = chains;
        let limited = |chain, first: usize| limited(chain, &joints, first, places);
        let made = Pair::new(limited(mill, 0)?, limited(support, SIDE)?);
        let made = made.map_err(|error| {
            let detail = "no joints can be computed for these axes";
            places.refuse("joint", error.name(), detail.into())
        })?;
        let path = root.table("path")?;
        path.known(PATH)?;
        let near = match path.has("near") {
            true => path.numbers("near", Kind::between(-1e6, 1e6, "mm or deg"))?,
            false => [0.0; MOTORS],
        };
        let share = Kind::between(0.001, 0.5, "");
        Ok(Self {
            name: ["m4", "m5", "own"][pair],
            joints,
            pair: made,
            forward,
            tip_tolerance: path.number_or("tip_tolerance", 0.005, Kind::positive(10.0, "mm"))?,
            axis_tolerance: path.number_or("axis_tolerance", 0.02, Kind::positive(10.0, "deg"))?,
            near,
            lift: path.number_or("lift", 5.0, Kind::positive(1000.0, "mm"))?,
            transit: path.number_or("transit", 50.0, Kind::positive(1e5, "mm/s"))?,
            trim_share: machine.number_or("trim_share", 0.2, share)?,
            rows: rows::read(&path, simulation, places)?,
        })
    }

    /// Both tools at joints of the job [mm, deg], in the work frame of side 1, by the reference.
    pub fn tools(&self, joints: &[f64; MOTORS]) -> [ToolAt; 2] {
        let mut q = *joints;
        for (q, joint) in q.iter_mut().zip(&self.joints) {
            *q = joint.to_library(*q);
        }
        let [mill, support] = &self.forward;
        tools_at([mill, support], &q[..SIDE], &q[SIDE..])
    }

    /// What refuses a place of the panel: a name, a key, and what is wrong.
    pub fn told(&self, error: &PairError<SIDE, SIDE, f64>) -> (&'static str, String, String) {
        let (side, joint) = match error {
            PairError::Mill(SideError::OutOfTravel { joint }) => ("the mill", *joint),
            PairError::Support(SideError::OutOfTravel { joint }) => ("the support", joint + SIDE),
            other => {
                let detail = "the pair cannot take this place".into();
                return (other.name(), "path".into(), detail);
            }
        };
        let Some(of) = self.joints.get(joint) else {
            return ("OutOfTravel", "machine.travel".into(), side.into());
        };
        let (lo, hi) = of.limits.travel;
        let detail = format!(
            "{side}'s {} would leave its travel of {lo} to {hi} {}, so both sides stay; widen it if the machine allows, or mill less",
            of.name,
            of.unit()
        );
        ("OutOfTravel", format!("machine.travel[{joint}]"), detail)
    }

    pub(crate) fn refuse(
        &self,
        job: &Job,
        error: &PairError<SIDE, SIDE, f64>,
        at: &str,
    ) -> JobError {
        let (name, key, detail) = self.told(error);
        job.refuse(&key, name, format!("{at}: {detail}"))
    }
}

fn turns(motor: usize) -> bool {
    motor % SIDE == SIDE - 1
}

fn limited(
    chain: Chain<SIDE, f64>,
    joints: &[PoseJoint],
    first: usize,
    places: &Places,
) -> Result<Chain<SIDE, f64>, JobError> {
    let own = joints.iter().skip(first).take(SIDE).enumerate();
    own.into_iter().try_fold(chain, |chain, (index, joint)| {
        let (lo, hi) = joint.limits.travel;
        let travel = [joint.to_library(lo), joint.to_library(hi)];
        chain.with_travel(index, travel).map_err(|_| {
            let key = format!("machine.travel[{}]", first + index);
            places.refuse(&key, "BadLimit", "expected lo < hi".into())
        })
    })
}
