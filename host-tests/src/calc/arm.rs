//! `arm.*`: the six-axis arm, forward and all its branches.
//!
//! Source: specification of surface grinding, section 9.

use super::answer::number;
use super::machine::{POSE, pose_rows, read_pose};
use super::request::read;
use super::schema::RANGE;
use super::{Answer, Fault, Field, Function, Kind, Length, Request};
use hexstep::joints::Joints;
use hexstep::machines::arm::{Arm, ArmError, DhRow, forward_of_table, table};
use hexstep::math::Real;
use serde_json::{Value, json};

const SIX: Kind = Kind::List(&Kind::Number, Length::Exactly(6));

const DH_ROW: Kind = Kind::Object(&[
    Field::number("a", "mm", "of the link before"),
    Field::number("alpha", "deg", "of the link before"),
    Field::number("d", "mm", ""),
]);

pub(super) const ARM: Field = Field::new(
    "arm",
    Kind::Preset(
        &["er3b"],
        &[
            Field::new("preset", Kind::Word(&["er3b"]), "", "").optional(),
            Field::new("dh", Kind::List(&DH_ROW, Length::Exactly(6)), "", "").optional(),
            Field::new("limits", Kind::List(&RANGE, Length::Exactly(6)), "deg", "").optional(),
        ],
    ),
    "",
    "er3b, or {dh: six rows {a, alpha, d}, limits: six [lo, hi]}, or a preset with overrides",
)
.or("\"er3b\"");

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "arm.fk",
        summary: "Pose of the flange in the base, from the six joint angles.",
        fields: &[&[ARM, Field::new("q", SIX, "deg", "")]],
        f64: fk::<f64>,
        f32: Some(fk::<f32>),
    },
    Function {
        name: "arm.ik",
        summary: "All branches that reach a flange pose.",
        fields: &[&[
            ARM,
            Field::new("pose", POSE, "mm", "flange in the base"),
            Field::new("previous", SIX, "deg", "left out: turns nearest to 0").optional(),
        ]],
        f64: ik::<f64>,
        f32: Some(ik::<f32>),
    },
];

/// The `arm` of a request: its table, and its ranges [rad] where they are known.
struct Description<R> {
    rows: [DhRow<R>; 6],
    limits: Option<[[R; 2]; 6]>,
}

fn describe<R: Real>(request: &Request) -> Result<Description<R>, Fault> {
    let er3b = Arm::<R>::er3b();
    let own = Description {
        rows: table(er3b.lengths()),
        limits: Some(*er3b.limits()),
    };
    let Some(Value::Object(object)) = request.value("arm") else {
        return Ok(own);
    };
    let given = |name: &str| object.get(name).filter(|v| !v.is_null());
    let has_preset = given("preset").is_some();
    let mut arm = own;
    match given("dh") {
        Some(rows) => {
            for (i, row) in arm.rows.iter_mut().enumerate() {
                let figure = |name: &str| read::<R>(&rows[i][name]).unwrap_or(R::ZERO);
                *row = DhRow {
                    a: figure("a"),
                    alpha: figure("alpha").to_radians(),
                    d: figure("d"),
                };
                if ![row.a, row.alpha, row.d].iter().all(|x| x.is_finite()) {
                    return Err(bad("dh", format!("dh[{i}] must be finite")).with("index", i));
                }
            }
        }
        None if has_preset => {}
        None => {
            let detail = "arm.dh is required without a preset: six rows {a, alpha, d}";
            return Err(Fault::new("MissingField", detail).field("dh"));
        }
    }
    match given("limits") {
        Some(ranges) => {
            let end = |i: usize, j: usize| read::<R>(&ranges[i][j]).unwrap_or(R::ZERO);
            let limits = std::array::from_fn(|i| [end(i, 0), end(i, 1)].map(R::to_radians));
            if let Some(i) = limits
                .iter()
                .position(|[lo, hi]: &[R; 2]| lo > hi || !lo.is_number() || !hi.is_number())
            {
                let detail = format!("limits[{i}] must be [lo, hi] with lo <= hi");
                return Err(bad("limits", detail).with("index", i));
            }
            arm.limits = Some(limits);
        }
        None if has_preset => {}
        None => arm.limits = None,
    }
    Ok(arm)
}

fn bad(field: &str, detail: impl Into<String>) -> Fault {
    Fault::new("BadParameter", detail).field(field)
}

fn angles<R: Real>(request: &Request, field: &str) -> Result<Joints<6, R>, Fault> {
    let values = request.numbers::<R>(field);
    if let Some(i) = values.iter().position(|x| !x.is_finite()) {
        return Err(bad(field, format!("{field}[{i}] must be finite")).with("index", i));
    }
    let value = |i: usize| values.get(i).copied().unwrap_or(R::ZERO).to_radians();
    Ok(Joints(std::array::from_fn(value)))
}

fn fk<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let arm = describe::<R>(request)?;
    let q = angles(request, "q")?;
    // The closed form where the table allows it, as on the device; any other table by its product.
    let pose = match arm.limits.map(|limits| Arm::from_table(&arm.rows, limits)) {
        Some(Ok(arm)) => arm.forward(&q),
        _ => forward_of_table(&arm.rows, &q),
    };
    Ok(Answer::new().put("pose", &pose_rows(&pose)))
}

/// The arm of a request, which must be one that has a closed form.
pub(super) fn closed_form<R: Real>(request: &Request) -> Result<Arm<R>, Fault> {
    let arm = describe::<R>(request)?;
    let Some(limits) = arm.limits else {
        let detail = "arm.limits is required without a preset: six [lo, hi] in degrees";
        return Err(Fault::new("MissingField", detail).field("limits"));
    };
    Arm::from_table(&arm.rows, limits).map_err(|error| match error {
        ArmError::BadParameter { row } => bad(
            "dh",
            format!(
                "dh[{row}]: the closed form needs alpha 0, -90, 0, -90, 90, -90, zeros where er3b has them, \
                 and links longer than 0; describe any other arm as a chain"
            ),
        )
        .with("index", row),
        other => bad("limits", format!("{other:?}")),
    })
}

fn ik<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let arm = closed_form::<R>(request)?;
    let rows = request.value("pose").unwrap_or(&Value::Null);
    let pose = read_pose::<R>(rows).map_err(|_| {
        let detail = "pose must be [[R, p], [0 0 0 1]], finite, with a rotation R (1e-6)";
        Fault::new("BadPose", detail).field("pose")
    })?;
    let previous = match request.is_given("previous") {
        true => Some(angles(request, "previous")?),
        false => None,
    };
    let branches = arm
        .inverse(&pose, previous.as_ref())
        .map_err(|error| match error {
            ArmError::Unreachable => Fault::new(
                "Unreachable",
                "neither shoulder reaches the wrist point; bring the pose nearer to the base, or away from its axis",
            ),
            _ => Fault::new("BadPose", "pose must be finite, with a rotation (1e-6)").field("pose"),
        })?;
    let solutions: Vec<Value> = branches
        .as_slice()
        .iter()
        .map(|s| {
            json!({
                "branch": s.branch,
                "q": s.q.0.map(|x| number(x.to_degrees())),
                "in_limits": s.in_limits,
                "wrist_singular": s.wrist_singular,
                "elbow_singular": s.elbow_singular,
                "shoulder_singular": s.shoulder_singular,
            })
        })
        .collect();
    Ok(Answer::new().put("solutions", &solutions))
}
