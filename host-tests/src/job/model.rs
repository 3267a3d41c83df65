//! `[machine]` of a job with poses -> the machine: what turns poses into joints, and the same machine written down once
//! more for the reference that checks the pulses.

use super::axes::{AXES, AxisLimits, read_joints};
use super::reader::{Kind, Table};
use super::{JobError, Places};
use crate::reference::matrix::{Matrix, translation};
use crate::reference::serial::{ER3B, Forward, Serial, SerialJoint, two_sided};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::chain::{Carries, Chain, ChainError, Joint};
use hexstep::kinematics::chord::Paced;
use hexstep::machines::arm::{Lengths, table};
use hexstep::machines::five_axis::{self, Class, Definition, FiveAxis, PRESETS, preset};
use hexstep::machines::two_sided::{self, Side};
use hexstep::machines::{Arm, arm};
use hexstep::stepper::Timing;

/// Motors of the controller.
pub const MOTORS: usize = 6;

/// A machine that poses can be given to, with the speeds of its joints.
#[derive(Clone, Debug)]
pub enum Model {
    FiveAxis(Box<FiveAxis<f64>>),
    /// The branch is chosen for the whole path.
    Arm {
        arm: Box<Arm<f64>>,
        tool: Pose<f64>,
        speeds: Joints<6, f64>,
    },
    Side(Box<Paced<Side<6, f64>, 6, f64>>),
    Chain(Box<Paced<Chain<6, f64>, 6, f64>>),
}

/// A joint of the machine, and the motor of the same number.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseJoint {
    pub name: String,
    pub turns: bool,
    pub limits: AxisLimits,
}

impl PoseJoint {
    pub fn unit(&self) -> &'static str {
        if self.turns { "deg" } else { "mm" }
    }

    /// A value of the library [mm, rad] in the unit of the job [mm, deg], and back.
    pub fn from_library(&self, q: f64) -> f64 {
        if self.turns { q.to_degrees() } else { q }
    }

    pub fn to_library(&self, q: f64) -> f64 {
        if self.turns { q.to_radians() } else { q }
    }
}

/// The machine of a job with poses.
#[derive(Clone, Debug)]
pub struct PoseMachine {
    /// As the job names it, with the side of a two-sided machine.
    pub name: String,
    pub model: Model,
    /// One to six; the motors behind them stand still.
    pub joints: Vec<PoseJoint>,
    pub forward: Forward,
}

const FIVE_AXIS: &[&str] = &[
    "class",
    "primary_axis",
    "primary_point",
    "secondary_axis",
    "secondary_point",
    "tool_axis",
    "tip",
    "work_origin",
];
const ARM: &[&str] = &[
    "a1",
    "a2",
    "a3",
    "d1",
    "d4",
    "d6",
    "tool_length",
    "work_origin",
];
const SIDE: &[&str] = &["pair", "side"];
const CHAIN: &[&str] = &["tip", "tool_axis", "work_origin"];

/// Coordinates that are taken for meant [mm].
const FAR: f64 = 100_000.0;
pub(super) const LENGTH: Kind = Kind::between(-FAR, FAR, "mm");

/// What the machine is made of before its joints have limits.
struct Reader<'a> {
    machine: &'a Table<'a>,
    root: &'a Table<'a>,
    timing: &'a Timing,
    places: &'a Places,
}

impl PoseMachine {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let machine = root.table("machine")?;
        let models: Vec<&str> = PRESETS
            .into_iter()
            .chain(["five-axis", "arm", "two-sided", "chain"])
            .collect();
        let index = machine.word("model", &models)?;
        let name = models[index];
        let reader = Reader {
            machine: &machine,
            root,
            timing,
            places,
        };
        let known = |keys: &[&str]| machine.known(&[&["model"], AXES, keys].concat());
        if name != "chain" && root.has("joint") {
            let detail = "only a machine with model = \"chain\" has a list of joints; remove it";
            return Err(places.refuse("joint", "UnknownField", detail.into()));
        }
        let read = match name {
            "arm" => {
                known(ARM)?;
                reader.arm()?
            }
            "two-sided" => {
                known(SIDE)?;
                reader.side()?
            }
            "chain" => {
                known(CHAIN)?;
                reader.chain()?
            }
            _ => {
                known(FIVE_AXIS)?;
                reader.five_axis(name)?
            }
        };
        let name = format!("{name} {}", read.name).trim_end().into();
        Ok(Self { name, ..read })
    }
}

impl Reader<'_> {
    fn refuse(&self, key: &str, name: &'static str, detail: &str) -> JobError {
        let key = format!("machine.{key}");
        self.places.refuse(&key, name, detail.into())
    }

    fn vector(&self, key: &str, default: Vector<f64>) -> Result<Vector<f64>, JobError> {
        if !self.machine.has(key) {
            return Ok(default);
        }
        self.machine
            .numbers::<3>(key, LENGTH)
            .map(Vector::from_array)
    }

    /// Limits of the joints with these names; those with `true` turn.
    fn joints(&self, kinds: &[(String, bool)]) -> Result<Vec<PoseJoint>, JobError> {
        let limits = match kinds.len() {
            1 => self.limits::<1>(kinds)?,
            2 => self.limits::<2>(kinds)?,
            3 => self.limits::<3>(kinds)?,
            4 => self.limits::<4>(kinds)?,
            5 => self.limits::<5>(kinds)?,
            _ => self.limits::<6>(kinds)?,
        };
        let joints = kinds.iter().zip(limits);
        Ok(joints
            .map(|((name, turns), limits)| PoseJoint {
                name: name.clone(),
                turns: *turns,
                limits,
            })
            .collect())
    }

    fn limits<const N: usize>(
        &self,
        kinds: &[(String, bool)],
    ) -> Result<Vec<AxisLimits>, JobError> {
        let unit = |joint: usize| match kinds.get(joint) {
            Some((_, true)) => "deg",
            _ => "mm",
        };
        let units: [&'static str; N] = std::array::from_fn(unit);
        let limits = read_joints::<N>(self.machine, units, self.timing, self.places)?;
        Ok(limits.to_vec())
    }

    fn five_axis(&self, name: &str) -> Result<PoseMachine, JobError> {
        let is_custom = name == "five-axis";
        // A machine of one's own starts from any preset; what makes it one must be said.
        let start = preset::<f64>(if is_custom { "head_ca" } else { name });
        let mut machine: Definition<f64> = start.expect("a name from the list of presets");
        if is_custom {
            for key in ["class", "primary_axis", "secondary_axis"] {
                if !self.machine.has(key) {
                    let detail = "it is missing; a five-axis machine of your own needs class, primary_axis and secondary_axis";
                    return Err(self.refuse(key, "MissingField", detail));
                }
            }
        }
        if self.machine.has("class") {
            let classes = [Class::Head, Class::Table, Class::Mixed];
            machine.class = classes[self.machine.word("class", &["head", "table", "mixed"])?];
        }
        machine.n1 = self.vector("primary_axis", machine.n1)?;
        machine.n2 = self.vector("secondary_axis", machine.n2)?;
        machine.q1 = self.vector("primary_point", machine.q1)?;
        machine.q2 = self.vector("secondary_point", machine.q2)?;
        machine.v1 = self.vector("tool_axis", machine.v1)?;
        machine.t0 = self.vector("tip", machine.t0)?;
        machine.w0 = self.vector("work_origin", machine.w0)?;

        let letters: [&str; 2] = match name {
            "s45" => ["C", "B"],
            "five-axis" => ["primary", "secondary"],
            _ => {
                // head_ab: primary A, secondary B.
                let letter = |back: usize| match name.as_bytes()[name.len() - back] {
                    b'a' => "A",
                    b'b' => "B",
                    _ => "C",
                };
                [letter(2), letter(1)]
            }
        };
        let names = ["X", "Y", "Z", letters[0], letters[1]];
        let kinds: Vec<_> = names
            .iter()
            .enumerate()
            .map(|(i, name)| (name.to_string(), i >= 3))
            .collect();
        let joints = self.joints(&kinds)?;
        let library = |joint: &PoseJoint, x: f64| joint.to_library(x);
        machine.limits = std::array::from_fn(|i| {
            let joint = &joints[i];
            let (lo, hi) = joint.limits.travel;
            Some([library(joint, lo), library(joint, hi)])
        });
        machine.speeds = Some(std::array::from_fn(|i| {
            library(&joints[i], joints[i].limits.max_rate)
        }));
        let checked = FiveAxis::new(&machine).map_err(|error| self.five_axis_error(&error))?;
        Ok(PoseMachine {
            name: String::new(),
            model: Model::FiveAxis(Box::new(checked)),
            joints,
            forward: Forward::FiveAxis(Box::new(machine)),
        })
    }

    fn five_axis_error(&self, error: &five_axis::Error<f64>) -> JobError {
        use five_axis::Error;
        let (key, detail) = match error {
            Error::ParallelAxes => (
                "secondary_axis",
                "the rotary axes, as the tool and the work see them, are parallel; turn one of them",
            ),
            Error::ToolAlongAxis => (
                "tool_axis",
                "the tool lies along the axis next to it, which could only turn it about itself",
            ),
            Error::BadDirection { .. } => ("tool_axis", "it is shorter than 1e-6"),
            Error::BadAxis { field: "n1" } => ("primary_axis", "it is shorter than 1e-6"),
            Error::BadAxis { .. } => ("secondary_axis", "it is shorter than 1e-6"),
            _ => ("model", "the machine cannot be computed with"),
        };
        self.refuse(key, error.name(), detail)
    }

    fn arm(&self) -> Result<PoseMachine, JobError> {
        let number = |key, default| self.machine.number_or(key, default, LENGTH);
        let er3b = *Arm::<f64>::er3b().lengths();
        let lengths = Lengths {
            a1: number("a1", er3b.a1)?,
            a2: number("a2", er3b.a2)?,
            a3: number("a3", er3b.a3)?,
            d1: number("d1", er3b.d1)?,
            d4: number("d4", er3b.d4)?,
            d6: number("d6", er3b.d6)?,
        };
        let tool_length = number("tool_length", 0.0)?;
        let origin = self.vector("work_origin", Vector::ZERO)?;
        let kinds: Vec<_> = (1..=6).map(|i| (format!("J{i}"), true)).collect();
        let joints = self.joints(&kinds)?;
        let range = |joint: &PoseJoint| {
            let (lo, hi) = joint.limits.travel;
            [lo.to_radians(), hi.to_radians()]
        };
        let limits: [[f64; 2]; 6] = std::array::from_fn(|i| range(&joints[i]));
        let made = Arm::new(lengths, limits).map_err(|error| {
            let (key, detail) = match error {
                arm::ArmError::BadParameter { row: 2 } => {
                    ("a2", "the upper arm has no length; give more than 1e-6 mm")
                }
                _ => ("d4", "the forearm has no length; give more than 1e-6 mm"),
            };
            self.refuse(key, "BadParameter", detail)
        })?;
        let is_own = ["a1", "a2", "a3", "d1", "d4", "d6"]
            .iter()
            .any(|key| self.machine.has(key));
        let rows = if is_own {
            table(&lengths).map(|row| [row.a, row.alpha.to_degrees(), row.d])
        } else {
            ER3B
        };
        Ok(PoseMachine {
            name: String::new(),
            model: Model::Arm {
                arm: Box::new(made),
                tool: Pose {
                    rotation: Rotation::IDENTITY,
                    p: Vector::new(0.0, 0.0, tool_length),
                },
                speeds: Joints(std::array::from_fn(|i| {
                    joints[i].limits.max_rate.to_radians()
                })),
            },
            joints,
            forward: Forward::Arm {
                rows,
                tool: translation([0.0, 0.0, tool_length]),
                work: translation(origin.to_array()),
            },
        })
    }

    fn side(&self) -> Result<PoseMachine, JobError> {
        let pairs = ["m4", "m5"];
        let pair = self.machine.word("pair", &pairs)?;
        let side = self.machine.word("side", &["mill", "support", "both"])?;
        let chain = match (pair, side) {
            (_, 2) => {
                let detail = format!(
                    "both sides of {} have {} joints and this controller has {MOTORS} motors; give each side a controller and a job of its own, side = \"mill\" and side = \"support\"; kind = \"mirror\" runs both sides of m4 on eight motors",
                    pairs[pair],
                    8 + 2 * pair
                );
                return Err(self.refuse("side", "TooManyJoints", &detail));
            }
            (0, 0) => padded(&two_sided::m4_1()),
            (0, _) => padded(&two_sided::m4_2()),
            (_, 0) => padded(&two_sided::m5_1()),
            _ => padded(&two_sided::m5_2()),
        };
        let names = ["X", "Y", "Z", "B", "A"];
        let kinds: Vec<_> = names
            .iter()
            .enumerate()
            .take(4 + pair)
            .map(|(i, name)| (name.to_string(), i >= 3))
            .collect();
        let joints = self.joints(&kinds)?;
        let chain = self.limited(chain, &joints)?;
        let machine = Side::new(chain).map_err(|error| {
            let name = error.name();
            self.refuse("pair", name, "the side cannot be computed with")
        })?;
        let name = format!("{}-{}", pairs[pair], ["mill", "support"][side.min(1)]);
        let serial = two_sided(&name).expect("a name from the list above");
        Ok(PoseMachine {
            name,
            model: Model::Side(Box::new(Paced {
                machine,
                speeds: Some(speeds(&joints)),
            })),
            joints,
            forward: Forward::Serial(serial),
        })
    }

    fn chain(&self) -> Result<PoseMachine, JobError> {
        let tables = self.root.tables("joint")?;
        if tables.len() > MOTORS {
            let detail = format!(
                "{} joints are given and this controller has {MOTORS} motors",
                tables.len()
            );
            return Err(self.places.refuse("joint", "TooManyJoints", detail));
        }
        let (mut kinds, mut serial) = (Vec::new(), Vec::new());
        let mut list = [Joint::held(Carries::Tool); MOTORS];
        for (index, table) in tables.iter().enumerate() {
            let read = read_joint(table, index, self.places)?;
            kinds.push((read.name, read.serial.turns));
            list[index] = read.joint;
            serial.push(read.serial);
        }
        let joints = self.joints(&kinds)?;
        let tip = self.vector("tip", Vector::ZERO)?;
        let axis = self.vector("tool_axis", Vector::Z)?;
        let origin = self.vector("work_origin", Vector::ZERO)?;
        let at = Pose {
            rotation: Rotation::IDENTITY,
            p: origin,
        };
        let chain = Chain::new(list)
            .with_homes(Pose::IDENTITY, at)
            .and_then(|chain| chain.with_tool(tip, axis))
            .map_err(|error: ChainError| match error {
                ChainError::BadDirection => {
                    self.refuse("tool_axis", "BadDirection", "it is shorter than 1e-6")
                }
                _ => self.refuse("model", "BadPose", "the machine cannot be computed with"),
            })?;
        let machine = self.limited(chain, &joints)?;
        Ok(PoseMachine {
            name: String::new(),
            model: Model::Chain(Box::new(Paced {
                machine,
                speeds: Some(speeds(&joints)),
            })),
            joints,
            forward: Forward::Serial(Serial {
                joints: serial,
                tip: tip.to_array(),
                axis: axis.to_array(),
                work: translation(origin.to_array()),
            }),
        })
    }

    /// The chain with the travels of its joints.
    fn limited(
        &self,
        chain: Chain<6, f64>,
        joints: &[PoseJoint],
    ) -> Result<Chain<6, f64>, JobError> {
        joints
            .iter()
            .enumerate()
            .try_fold(chain, |chain, (index, of)| {
                let (lo, hi) = of.limits.travel;
                let travel = [of.to_library(lo), of.to_library(hi)];
                chain.with_travel(index, travel).map_err(|_| {
                    self.refuse(&format!("travel[{index}]"), "BadLimit", "expected lo < hi")
                })
            })
    }
}

impl PoseMachine {
    /// Work frame of an arm in its base.
    pub fn work(&self) -> Pose<f64> {
        let p = match &self.forward {
            Forward::Arm { work, .. } => shift(work),
            _ => Vector::ZERO,
        };
        Pose {
            rotation: Rotation::IDENTITY,
            p,
        }
    }
}

/// A joint of a list, as the library and as the reference have it.
pub(super) struct ListedJoint {
    pub name: String,
    pub joint: Joint<f64>,
    pub serial: SerialJoint,
}

/// `[[joint]]` number `index`.
///
/// # Errors
/// `BadAxis` where its axis is none.
pub(super) fn read_joint(
    table: &Table<'_>,
    index: usize,
    places: &Places,
) -> Result<ListedJoint, JobError> {
    table.known(&["name", "carries", "motion", "axis", "point"])?;
    let name = if table.has("name") {
        table.text("name")?.to_string()
    } else {
        format!("J{}", index + 1)
    };
    let carries_work = table.word("carries", &["tool", "work"])? == 1;
    let carries = [Carries::Tool, Carries::Work][usize::from(carries_work)];
    let turns = table.word("motion", &["linear", "rotary"])? == 1;
    let axis = table.numbers::<3>("axis", LENGTH)?;
    let point = if turns && table.has("point") {
        table.numbers::<3>("point", LENGTH)?
    } else if table.has("point") {
        let key = format!("joint[{index}].point");
        let detail = "a joint that slides has no point; remove it".into();
        return Err(places.refuse(&key, "UnknownField", detail));
    } else {
        [0.0; 3]
    };
    let joint = if turns {
        let at = Vector::from_array(point);
        Joint::rotary(carries, Vector::from_array(axis), at, 0.0)
    } else {
        Joint::linear(carries, Vector::from_array(axis))
    };
    let joint = joint.map_err(|_| {
        let key = format!("joint[{index}].axis");
        let detail = "it is shorter than 1e-6; give a direction".into();
        places.refuse(&key, "BadAxis", detail)
    })?;
    Ok(ListedJoint {
        name,
        joint,
        serial: SerialJoint {
            carries_work,
            turns,
            axis,
            point,
        },
    })
}

fn shift(m: &Matrix) -> Vector<f64> {
    Vector::new(m[0][3], m[1][3], m[2][3])
}

fn speeds(joints: &[PoseJoint]) -> Joints<6, f64> {
    // A joint that is not there does not move: any speed will do.
    let speed = |joint: &PoseJoint| joint.to_library(joint.limits.max_rate);
    Joints(std::array::from_fn(|i| joints.get(i).map_or(1.0, speed)))
}

/// The same machine with joints that never move behind those it has.
fn padded<const N: usize>(chain: &Chain<N, f64>) -> Chain<6, f64> {
    let mut list = [Joint::held(Carries::Tool); MOTORS];
    for (to, from) in list.iter_mut().zip(chain.joints()) {
        *to = *from;
    }
    let series = chain.series();
    Chain::new(list)
        .with_homes(series.tool_home, series.work_home)
        .and_then(|made| made.with_tool(series.tip, series.axis))
        .expect("the homes and the tool of a chain that exists")
}
