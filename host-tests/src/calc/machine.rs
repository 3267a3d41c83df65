//! What the calculators of chains and arms share: a machine read from a request, poses, joint values.

use super::answer::number;
use super::request::{read, read_vector};
use super::schema::{RANGE, VECTOR};
use super::{Fault, Field, Kind, Length};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::chain::{Carries, Chain, ChainError, Joint, Motion, Series, check_pose};
use hexstep::machines::two_sided;
use hexstep::math::Real;
use serde_json::Value;

/// Four rows of four numbers.
pub const POSE: Kind = Kind::List(&ROW, Length::Exactly(4));
const ROW: Kind = Kind::List(&Kind::Number, Length::Exactly(4));

const JOINT: Kind = Kind::Object(&[
    Field::new("name", Kind::Any, "", "its index if left out").optional(),
    Field::new("chain", Kind::Word(&["tool", "work"]), "", "").or("\"tool\""),
    Field::new("type", Kind::Word(&["rotary", "linear"]), "", ""),
    Field::new(
        "axis",
        VECTOR,
        "",
        "bed coordinates at home, longer than 1e-6",
    ),
    Field::new("point", VECTOR, "mm", "on the axis; rotary").or("[0,0,0]"),
    Field::new("pitch", Kind::Number, "mm/rad", "rotary").or("0"),
    Field::new(
        "limits",
        Kind::OrNull(&RANGE),
        "mm or deg",
        "null: unlimited",
    )
    .optional(),
]);

pub const CHAIN_PRESETS: &[&str] = &["m4_1", "m4_2", "m5_1", "m5_2"];

pub const CHAIN_FIELDS: &[Field] = &[
    Field::new(
        "joints",
        Kind::List(&JOINT, Length::Any),
        "",
        "from the bed outwards: name, chain, type, axis, point, pitch, limits",
    ),
    Field::new("tool_home", POSE, "mm", "a pose").optional(),
    Field::new("work_home", POSE, "mm", "a pose").optional(),
    Field::new("r_p", VECTOR, "mm", "tip in the tool frame").or("[0,0,0]"),
    Field::new("r_o", VECTOR, "", "tool axis in the tool frame").or("[0,0,1]"),
];

pub const CHAIN: Kind = Kind::Preset(CHAIN_PRESETS, CHAIN_FIELDS);

/// A chain of any length.
pub struct Machine<R> {
    names: Vec<String>,
    joints: Vec<Joint<R>>,
    tool_home: Pose<R>,
    work_home: Pose<R>,
    tip: Vector<R>,
    axis: Vector<R>,
}

impl<R: Real> Machine<R> {
    /// From a value that the schema [`CHAIN`] has passed.
    pub fn read(value: &Value) -> Result<Self, Fault> {
        match value.as_str() {
            Some("m4_1") => return Ok(Self::of(&two_sided::m4_1())),
            Some("m4_2") => return Ok(Self::of(&two_sided::m4_2())),
            Some("m5_1") => return Ok(Self::of(&two_sided::m5_1())),
            Some(_) => return Ok(Self::of(&two_sided::m5_2())),
            None => {}
        }
        let empty = Vec::new();
        let list = value["joints"].as_array().unwrap_or(&empty);
        let mut joints = Vec::new();
        let mut names = Vec::new();
        for (index, entry) in list.iter().enumerate() {
            let joint = read_joint(entry).map_err(|(error, field)| {
                chain_fault(error, field, &format!("joints[{index}].{field}")).with("index", index)
            })?;
            joints.push(joint);
            names.push(match &entry["name"] {
                Value::Null => index.to_string(),
                Value::String(name) => name.clone(),
                other => other.to_string(),
            });
        }
        let home = |field: &'static str| match &value[field] {
            Value::Null => Ok(Pose::IDENTITY),
            rows => match read_pose(rows) {
                Ok(pose) => Ok(Pose {
                    rotation: pose.rotation.orthonormal(),
                    p: pose.p,
                }),
                Err(error) => Err(chain_fault(error, field, field)),
            },
        };
        let (tool_home, work_home) = (home("tool_home")?, home("work_home")?);
        let tip = read_vector(&value["r_p"]).unwrap_or(Vector::ZERO);
        let axis = read_vector(&value["r_o"]).unwrap_or(Vector::Z);
        for (field, v) in [("r_p", tip), ("r_o", axis)] {
            if !v.is_finite() {
                return Err(chain_fault(ChainError::NonFinite, field, field));
            }
        }
        let axis = axis
            .unit(R::of(1e-6))
            .ok_or_else(|| chain_fault(ChainError::BadDirection, "r_o", "r_o"))?;
        Ok(Self {
            names,
            joints,
            tool_home,
            work_home,
            tip,
            axis,
        })
    }

    fn of<const N: usize>(chain: &Chain<N, R>) -> Self {
        let series = chain.series();
        let names = ["X", "Y", "Z", "B", "A"];
        Self {
            names: names.iter().take(N).map(|s| s.to_string()).collect(),
            joints: series.joints.to_vec(),
            tool_home: series.tool_home,
            work_home: series.work_home,
            tip: series.tip,
            axis: series.axis,
        }
    }

    pub fn series(&self) -> Series<'_, R> {
        Series {
            joints: &self.joints,
            tool_home: self.tool_home,
            work_home: self.work_home,
            tip: self.tip,
            axis: self.axis,
        }
    }

    pub fn joints(&self) -> &[Joint<R>] {
        &self.joints
    }

    pub fn name(&self, index: usize) -> &str {
        self.names.get(index).map_or("", String::as_str)
    }

    /// The same chain with `N` joints, filled up with joints that stand still; `None` if it is longer.
    pub fn padded<const N: usize>(&self) -> Option<Chain<N, R>> {
        if self.joints.len() > N {
            return None;
        }
        let still = Joint::held(Carries::Tool);
        let joints = std::array::from_fn(|i| self.joints.get(i).copied().unwrap_or(still));
        Chain::new(joints)
            .with_homes(self.tool_home, self.work_home)
            .and_then(|chain| chain.with_tool(self.tip, self.axis))
            .ok()
    }

    /// Joint values of a request, in mm and degrees, one for each joint, as mm and radians. Zeros if left out.
    pub fn read_joints(&self, value: Option<&Value>, field: &str) -> Result<Vec<R>, Fault> {
        let Some(value) = value else {
            return Ok(vec![R::ZERO; self.joints.len()]);
        };
        let q: Vec<R> = value
            .as_array()
            .map(|entries| entries.iter().filter_map(read).collect())
            .unwrap_or_default();
        if q.len() != self.joints.len() {
            let detail = format!(
                "{field} must hold one value for each joint: {} of them, not {}",
                self.joints.len(),
                q.len()
            );
            return Err(Fault::new("WrongType", detail).field(field));
        }
        if let Some(index) = q.iter().position(|x| !x.is_finite()) {
            return Err(non_finite(field).with("index", index));
        }
        let turned = |(joint, x): (&Joint<R>, R)| match joint.motion() {
            Motion::Rotary => x.to_radians(),
            _ => x,
        };
        Ok(self.joints.iter().zip(q).map(turned).collect())
    }

    /// Joint values in mm and radians as an answer prints them.
    pub fn joint_values(&self, q: &[R]) -> Vec<Value> {
        let shown = |(joint, x): (&Joint<R>, &R)| match joint.motion() {
            Motion::Rotary => number(x.to_degrees()),
            _ => number(*x),
        };
        self.joints.iter().zip(q).map(shown).collect()
    }

    pub fn out_of_travel(&self, joint: usize) -> Fault {
        let name = self.name(joint);
        let range = self.joints.get(joint).and_then(Joint::limits);
        let unit = match self.joints.get(joint).map(Joint::motion) {
            Some(Motion::Rotary) => "deg",
            _ => "mm",
        };
        let range = range.map_or(String::new(), |limits| {
            let [lo, hi] = limits.map(|x| if unit == "deg" { x.to_degrees() } else { x });
            format!(": {} ..= {} {unit}", lo.to_f64(), hi.to_f64())
        });
        let detail = format!("the pose needs axis {name} beyond its travel{range}");
        Fault::new("OutOfTravel", detail)
            .with("axis", name)
            .with("index", joint)
    }
}

/// The `N` values of a fixed-length machine.
pub fn fixed<const N: usize, R: Real>(q: &[R]) -> Joints<N, R> {
    Joints(std::array::from_fn(|i| {
        q.get(i).copied().unwrap_or(R::ZERO)
    }))
}

fn read_joint<R: Real>(entry: &Value) -> Result<Joint<R>, (ChainError, &'static str)> {
    let carries = match entry["chain"].as_str() {
        Some("work") => Carries::Work,
        _ => Carries::Tool,
    };
    let axis = read_vector(&entry["axis"]).unwrap_or(Vector::ZERO);
    if !axis.is_finite() {
        return Err((ChainError::NonFinite, "axis"));
    }
    let rotary = entry["type"].as_str() == Some("rotary");
    let joint = if rotary {
        let point = read_vector(&entry["point"]).unwrap_or(Vector::ZERO);
        if !point.is_finite() {
            return Err((ChainError::NonFinite, "point"));
        }
        let pitch: R = read(&entry["pitch"]).unwrap_or(R::ZERO);
        if !pitch.is_finite() {
            return Err((ChainError::NonFinite, "pitch"));
        }
        Joint::rotary(carries, axis, point, pitch)
    } else {
        Joint::linear(carries, axis)
    }
    .map_err(|error| (error, "axis"))?;
    match entry["limits"].as_array().map(Vec::as_slice) {
        Some([lo, hi]) => {
            let ends = [lo, hi].map(|end| {
                let x: R = read(end).unwrap_or(R::ZERO);
                if rotary { x.to_radians() } else { x }
            });
            if ends.iter().any(|end| !end.is_number()) {
                return Err((ChainError::NonFinite, "limits"));
            }
            joint.with_limits(ends).map_err(|error| (error, "limits"))
        }
        _ => Ok(joint),
    }
}

fn chain_fault(error: ChainError, field: &str, path: &str) -> Fault {
    let (name, what) = match error {
        ChainError::BadAxis => ("BadAxis", "must be longer than 1e-6"),
        ChainError::NonFinite => ("NonFinite", "must be finite"),
        ChainError::BadLimit => ("BadLimit", "must be [lo, hi] with lo <= hi"),
        ChainError::BadDirection => ("BadDirection", "must be longer than 1e-6"),
        ChainError::BadPose => ("BadPose", "must be [[R, p], [0 0 0 1]] with a rotation R"),
    };
    Fault::new(name, format!("{path} {what}")).field(field)
}

pub fn non_finite(field: &str) -> Fault {
    chain_fault(ChainError::NonFinite, field, field)
}

pub fn bad_direction(field: &str) -> Fault {
    chain_fault(ChainError::BadDirection, field, field)
}

/// A pose of four rows that the schema [`POSE`] has passed, checked to be one.
pub fn read_pose<R: Real>(rows: &Value) -> Result<Pose<R>, ChainError> {
    let m: [[R; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| read(&rows[i][j]).unwrap_or(R::ZERO)));
    let column = |j: usize| Vector::new(m[0][j], m[1][j], m[2][j]);
    let pose = Pose {
        rotation: Rotation {
            n: column(0),
            s: column(1),
            a: column(2),
        },
        p: column(3),
    };
    if m[3].iter().any(|x| !x.is_finite()) {
        return Err(ChainError::NonFinite);
    }
    check_pose(&pose)?;
    if m[3] == [R::ZERO, R::ZERO, R::ZERO, R::ONE] {
        Ok(pose)
    } else {
        Err(ChainError::BadPose)
    }
}

/// A pose as four rows.
pub fn pose_rows<R: Real>(pose: &Pose<R>) -> [[Value; 4]; 4] {
    let t = pose.rotation.transposed();
    let row = |r: Vector<R>, p: R| [number(r.x), number(r.y), number(r.z), number(p)];
    [
        row(t.n, pose.p.x),
        row(t.s, pose.p.y),
        row(t.a, pose.p.z),
        [0, 0, 0, 1].map(Value::from),
    ]
}
