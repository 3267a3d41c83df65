//! `[machine]` and `[path]` of a mirror job: the pair of machines that mills the panel for real, on eight motors.
//!
//! ```text
//! [machine] pair = "m4"  |  "own" + [[joint]] x 8    -> Pair with its travels, and the same once more for the reference
//! [path]    rows, from, to  |  points, normals       -> PairRow: points and normals of the support-side surface
//! ```
//!
//! The controller trims both sides along the joints' directions of the pair M4, so an own pair may stand and reach
//! elsewhere, but its joints must go the same ways.

use super::axes::{AXES, read_joints};
use super::model::{LENGTH, PoseJoint, read_joint};
use super::points::MOST_POINTS;
use super::reader::{Kind, Table};
use super::{Job, JobError, Places};
use crate::mirror::{Simulation, Surface};
use crate::reference::matrix::translation;
use crate::reference::serial::{Serial, ToolAt, tools_at, two_sided};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::kinematics::ClPoint;
use hexstep::kinematics::chain::{Carries, Chain, Joint};
use hexstep::machines::two_sided::{self as library, Pair, PairError, SideError};
use hexstep::stepper::Timing;

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

const OWN: &[&str] = &["mill_tip", "support_tip", "work_origin"];
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
        let (chains, forward) = match pair {
            0 => built_in(),
            _ => read_own(root, &machine, places)?,
        };
        let joints: Vec<PoseJoint> = limits
            .into_iter()
            .enumerate()
            .map(|(i, limits)| PoseJoint {
                name: NAMES[i].into(),
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
            rows: read_rows(&path, simulation, places)?,
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

type Chains = [Chain<SIDE, f64>; 2];

fn built_in() -> (Chains, [Serial; 2]) {
    let forward = ["m4-mill", "m4-support"].map(|name| two_sided(name).expect("it is built in"));
    ([library::m4_1(), library::m4_2()], forward)
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

/// `[[joint]]` eight times: the mill's, then the support's.
fn read_own(
    root: &Table<'_>,
    machine: &Table<'_>,
    places: &Places,
) -> Result<(Chains, [Serial; 2]), JobError> {
    let tables = root.tables("joint")?;
    if tables.len() != MOTORS {
        let detail = format!(
            "expected the four joints of the mill and then the four of the support, found {}",
            tables.len()
        );
        return Err(places.refuse("joint", "WrongType", detail));
    }
    let (chains, serials) = built_in();
    let [mut mill, mut support] = serials;
    let wanted = mill.joints.iter().chain(&support.joints).cloned();
    let wanted: Vec<_> = wanted.collect();
    let mut list = Vec::with_capacity(MOTORS);
    for (index, (table, wanted)) in tables.iter().zip(&wanted).enumerate() {
        let read = read_joint(table, index, places)?;
        let length = read.serial.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        let axis = read.serial.axis.map(|x| x / length);
        let off = (0..3).map(|i| (axis[i] - wanted.axis[i]).abs());
        let goes_so = read.serial.turns == wanted.turns
            && !read.serial.carries_work
            && off.fold(0.0, f64::max) < 1e-6;
        if !goes_so {
            let detail = format!(
                "the controller trims along the joints of the pair M4: {} carries the tool and {} {:?}, with the numbers of your machine in point, mill_tip, support_tip and work_origin",
                NAMES[index],
                if wanted.turns {
                    "turns about"
                } else {
                    "slides along"
                },
                wanted.axis
            );
            return Err(places.refuse(&format!("joint[{index}]"), "Contradictory", detail));
        }
        list.push(read);
    }
    let vector = |key: &str, default: [f64; 3]| match machine.has(key) {
        true => machine.numbers::<3>(key, LENGTH),
        false => Ok(default),
    };
    let tips = [
        vector("mill_tip", mill.tip)?,
        vector("support_tip", support.tip)?,
    ];
    let origin = vector("work_origin", [600.0, 450.0, 0.0])?;
    let frame = |rotation: Rotation<f64>, [x, y, z]: [f64; 3]| Pose {
        rotation,
        p: Vector::new(x, y, z),
    };
    let chain = |side: usize| {
        let preset = chains[side].series();
        let (tool, work) = (preset.tool_home.rotation, preset.work_home.rotation);
        let mut joints = [Joint::held(Carries::Tool); SIDE];
        for (slot, read) in joints.iter_mut().zip(&list[side * SIDE..]) {
            *slot = read.joint;
        }
        let homed = Chain::new(joints).with_homes(frame(tool, tips[side]), frame(work, origin));
        homed.map_err(|_| {
            let detail = "the machine cannot be computed with".into();
            places.refuse("machine.work_origin", "BadPose", detail)
        })
    };
    let made = [chain(0)?, chain(1)?];
    for (side, serial) in [&mut mill, &mut support].into_iter().enumerate() {
        let own = list.iter().skip(side * SIDE).take(SIDE);
        serial.joints = own.map(|read| read.serial).collect();
        serial.tip = tips[side];
        let shift = translation(origin);
        for (row, shifted) in serial.work.iter_mut().zip(shift) {
            row[3] = shifted[3];
        }
    }
    Ok((made, [mill, support]))
}

fn read_rows(
    path: &Table<'_>,
    simulation: &Simulation,
    places: &Places,
) -> Result<Vec<PairRow>, JobError> {
    let by_points = path.has("points") || path.has("normals");
    if by_points {
        for key in ["rows", "from", "to", "radius", "wave"] {
            if path.has(key) {
                let detail = format!("points and normals are the row; remove {key}");
                return Err(places.refuse(&format!("path.{key}"), "Contradictory", detail));
            }
        }
        return Ok(vec![given_row(path, places)?]);
    }
    let panel = &simulation.panel;
    let surface = read_surface(path, panel.start, places)?;
    let last = panel.rows.len().saturating_sub(1);
    let rows = match path.has("rows") {
        true => path.list("rows")?,
        false => vec![(last / 2) as f64],
    };
    let along = Kind::between(-panel.start, panel.start, "mm, on the row");
    let from = path.number_or("from", -panel.start, along)?;
    let to = path.number_or("to", panel.start, along)?;
    if from >= to {
        let detail = format!("expected from < to, found {from} and {to}");
        return Err(places.refuse("path.to", "Contradictory", detail));
    }
    if rows.is_empty() {
        let detail = "no row; remove rows for the middle one".into();
        return Err(places.refuse("path.rows", "OutOfRange", detail));
    }
    let mut made = Vec::with_capacity(rows.len());
    for (index, number) in rows.iter().enumerate() {
        let y = (number.fract() == 0.0 && *number >= 0.0)
            .then(|| panel.rows.get(*number as usize))
            .flatten();
        let Some(y) = y else {
            let detail =
                format!("rows of the panel are counted from 0 to {last} here, found {number}");
            let key = format!("path.rows[{index}]");
            return Err(places.refuse(&key, "OutOfRange", detail));
        };
        let parts = ((to - from) / surface.spacing()).ceil().max(1.0);
        let points: Option<Vec<_>> = (0..=parts as u32)
            .map(|k| surface.at(from + (to - from) * f64::from(k) / parts, *y))
            .collect();
        let Some(points) = points.filter(|points| points.len() <= MOST_POINTS) else {
            let detail = format!("the row takes more than {MOST_POINTS} points; mill less of it");
            return Err(places.refuse("path.to", "OutOfRange", detail));
        };
        made.push(PairRow {
            name: format!("row y = {y} mm"),
            points,
        });
    }
    Ok(made)
}

fn read_surface(path: &Table<'_>, start: f64, places: &Places) -> Result<Surface, JobError> {
    if path.has("wave") {
        if path.has("radius") {
            let detail = "radius and wave exclude each other; keep one of them".into();
            return Err(places.refuse("path.wave", "Contradictory", detail));
        }
        let [height, length] = path.numbers("wave", Kind::positive(1e5, "mm"))?;
        if height > 0.1 * length {
            let detail = format!("{height} mm over {length} mm is steeper than any panel");
            return Err(places.refuse("path.wave", "OutOfRange", detail));
        }
        return Ok(Surface::Wave { height, length });
    }
    let radius = path.number_or("radius", 4000.0, Kind::positive(1e6, "mm"))?;
    if radius < 2.0 * start {
        let detail = format!("a row of {start} mm each way would turn down by more than 30 deg");
        return Err(places.refuse("path.radius", "OutOfRange", detail));
    }
    Ok(Surface::Cylinder { radius })
}

/// `points` and `normals` of the surface, as measured.
fn given_row(path: &Table<'_>, places: &Places) -> Result<PairRow, JobError> {
    let (points, normals) = (path.lists("points")?, path.lists("normals")?);
    if points.len() != normals.len() || !(2..=MOST_POINTS).contains(&points.len()) {
        let detail = format!(
            "expected 2 to {MOST_POINTS} points and a normal for each, found {} and {}",
            points.len(),
            normals.len()
        );
        return Err(places.refuse("path.normals", "OutOfRange", detail));
    }
    let vector = |key: &str, index: usize, list: &[f64]| {
        let refuse = |name, detail| {
            let key = format!("path.{key}[{index}]");
            Err(places.refuse(&key, name, detail))
        };
        let [x, y, z] = list else {
            let detail = format!("expected three numbers, found {}", list.len());
            return refuse("WrongType", detail);
        };
        match [x, y, z].iter().find(|x| !x.is_finite()) {
            Some(x) => refuse("NonFinite", format!("expected finite numbers, found {x}")),
            None if [x, y, z].iter().any(|x| x.abs() > 1e5) => {
                refuse("OutOfRange", "a coordinate is beyond 1e5 mm".into())
            }
            None => Ok(Vector::new(*x, *y, *z)),
        }
    };
    let mut row = PairRow {
        name: "the given points".into(),
        points: Vec::with_capacity(points.len()),
    };
    for (index, (p, n)) in points.iter().zip(&normals).enumerate() {
        let (p, n) = (vector("points", index, p)?, vector("normals", index, n)?);
        let Some(at) = ClPoint::new(p, n) else {
            let key = format!("path.normals[{index}]");
            let detail = "it is shorter than 1e-6; give a direction from support to mill".into();
            return Err(places.refuse(&key, "BadNormal", detail));
        };
        row.points.push(at);
    }
    Ok(row)
}
