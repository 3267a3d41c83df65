//! `mirror.*`: two-sided machines, one side and both.
//!
//! Source: specification of mirror milling, sections 2 to 4.

pub mod trim;

use super::answer::number;
use super::machine::{CHAIN, Machine, bad_direction, fixed, non_finite};
use super::schema::{NUMBERS, VECTOR};
use super::{Answer, Fault, Field, Function, Kind, Request};
use hexstep::joints::Joints;
use hexstep::kinematics::chain::{Chain, Joint, Motion};
use hexstep::machines::two_sided::{
    self, Kind as Solutions, Pair, PairError, Side, SideError, Wall, WallLimits,
};
use hexstep::math::Real;
use serde_json::{Value, json};

/// Longest list of one side: three linears and two rotaries of its own, five work joints shared with the other side.
const LONGEST: usize = 10;

const PAIR: Field = Field::new(
    "machine",
    Kind::Preset(
        &["m4", "m5"],
        &[
            Field::new("side1", CHAIN, "", "the mill"),
            Field::new("side2", CHAIN, "", "the support"),
        ],
    ),
    "",
    "m4 | m5, or {side1, side2}",
);

const LIMITS: &[Field] = &[
    Field::number("lateral_max", "mm", "").or("0.01"),
    Field::number("antiparallel_max", "deg", "").or("0.05"),
];

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "mirror.forward",
        summary: "Both tips and the wall between them, in the work frame of side 1.",
        fields: &[
            &[
                PAIR,
                Field::new("q1", NUMBERS, "mm or deg", "one for each joint"),
                Field::new("q2", NUMBERS, "mm or deg", "one for each joint"),
                Field::new("n", VECTOR, "", "from support to mill; O_T if left out").optional(),
            ],
            LIMITS,
        ],
        f64: forward::<f64>,
        f32: Some(forward::<f32>),
    },
    Function {
        name: "mirror.side",
        summary: "Every way of one side to a tip and axis in its own work frame; limits are not looked at.",
        fields: &[&[
            Field::new(
                "machine",
                CHAIN,
                "",
                "three linears and at most two rotaries",
            ),
            Field::new("p", VECTOR, "mm", "tip"),
            Field::new("o", VECTOR, "", "axis"),
            Field::new("previous", NUMBERS, "mm or deg", "holds at a pole").optional(),
        ]],
        f64: side::<f64>,
        f32: Some(side::<f32>),
    },
    Function {
        name: "mirror.solve",
        summary: "Joints of both sides for a support point, a normal and a wall.",
        fields: &[
            &[
                PAIR,
                Field::new("p", VECTOR, "mm", "support point P"),
                Field::new("n", VECTOR, "", "normal, from support to mill"),
                Field::number("d", "mm", "wall, > 0"),
                Field::new("previous1", NUMBERS, "mm or deg", "0 if left out").optional(),
                Field::new("previous2", NUMBERS, "mm or deg", "0 if left out").optional(),
            ],
            LIMITS,
        ],
        f64: solve::<f64>,
        f32: Some(solve::<f32>),
    },
];

fn sides<R: Real>(request: &Request) -> Result<(Machine<R>, Machine<R>), Fault> {
    let machine = request.value("machine").unwrap_or(&Value::Null);
    let (first, second) = match machine.as_str() {
        Some("m4") => (Value::from("m4_1"), Value::from("m4_2")),
        Some(_) => (Value::from("m5_1"), Value::from("m5_2")),
        None => (machine["side1"].clone(), machine["side2"].clone()),
    };
    let side = |value: &Value, number: u8| {
        Machine::read(value).map_err(|fault: Fault| fault.with("side", number))
    };
    Ok((side(&first, 1)?, side(&second, 2)?))
}

fn limits<R: Real>(request: &Request) -> Result<WallLimits<R>, Fault> {
    for field in ["lateral_max", "antiparallel_max"] {
        if !request.number::<R>(field).is_number() {
            return Err(non_finite(field));
        }
    }
    Ok(WallLimits {
        lateral: request.number("lateral_max"),
        anti_parallel: request.degrees("antiparallel_max"),
    })
}

fn bad_normal() -> Fault {
    Fault::new("BadNormal", "n must be longer than 1e-6").field("n")
}

fn flags<R: Real>(wall: &Wall<R>, limits: &WallLimits<R>) -> Vec<&'static str> {
    let mut flags = Vec::new();
    if wall.is_lateral(limits) {
        flags.push("Lateral");
    }
    if wall.is_not_anti_parallel(limits) {
        flags.push("AntiParallel");
    }
    flags
}

fn forward<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (mill, support) = sides::<R>(request)?;
    let q1 = mill.read_joints(request.value("q1"), "q1")?;
    let q2 = support.read_joints(request.value("q2"), "q2")?;
    let n = request.maybe_vector::<R>("n");
    if n.is_some_and(|n| !n.is_finite()) {
        return Err(non_finite("n"));
    }
    let limits = limits(request)?;
    let tips = two_sided::tips(&mill.series(), &q1, &support.series(), &q2);
    let wall = tips.wall(n).ok_or_else(bad_normal)?;
    Ok(Answer::new()
        .vector("p_t", tips.p_t)
        .vector("o_t", tips.o_t)
        .vector("p_h", tips.p_h)
        .vector("o_h", tips.o_h)
        .number("thickness", wall.thickness)
        .number("lateral", wall.lateral)
        .number("length", wall.length)
        .degrees("antiparallel", wall.anti_parallel)
        .put("flags", &flags(&wall, &limits)))
}

/// The chain at its longest, filled with joints that stand still; what a longer one has too many of.
fn padded<R: Real>(machine: &Machine<R>) -> Result<Chain<LONGEST, R>, Fault> {
    machine.padded().ok_or_else(|| {
        let turns = |joint: &&Joint<R>| joint.motion() == Motion::Rotary;
        if machine.joints().iter().filter(turns).count() > 2 {
            arrangement("TooManyRotaries")
        } else {
            arrangement("NeedThreeLinears")
        }
    })
}

fn arrangement(name: &str) -> Fault {
    let detail = match name {
        "TooManyRotaries" => "a side has at most two rotaries; use chain.inverse for more",
        "NeedThreeLinears" => {
            "a side has exactly three linears; use chain.inverse for another number"
        }
        "LinearAxesDependent" => "the three linear directions must span space (|det| >= 1e-3)",
        "ParallelAxes" => "the two rotary axes must not be parallel (sine >= 1e-3)",
        _ => "the tool must not lie along the rotary axis next to it (sine >= 1e-3)",
    };
    Fault::new(name, detail).field("machine")
}

fn side_fault<const N: usize, R: Real>(machine: &Machine<R>, error: SideError<N, R>) -> Fault {
    match error {
        SideError::TooManyRotaries => arrangement("TooManyRotaries"),
        SideError::NeedThreeLinears => arrangement("NeedThreeLinears"),
        SideError::LinearAxesDependent => arrangement("LinearAxesDependent"),
        SideError::ParallelAxes => arrangement("ParallelAxes"),
        SideError::ToolAlongAxis => arrangement("ToolAlongAxis"),
        SideError::NonFinite => non_finite("p"),
        SideError::BadDirection => bad_direction("o"),
        SideError::OutOfTravel { joint } => machine.out_of_travel(joint),
        SideError::Unreachable { gap, nearest } => {
            let gap = gap.to_degrees();
            let detail = format!(
                "the two rotaries miss the direction by {} deg; tilt the axis towards what they reach",
                gap.to_f64()
            );
            Fault::new("Unreachable", detail)
                .with("gap", number(gap))
                .with("nearest", machine.joint_values(&nearest.0))
        }
    }
}

fn side<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let machine = Machine::<R>::read(request.value("machine").unwrap_or(&Value::Null))?;
    let prepared = Side::new(padded(&machine)?).map_err(|error| side_fault(&machine, error))?;
    let previous = machine.read_joints(request.value("previous"), "previous")?;
    let (p, o) = (request.vector::<R>("p"), request.vector::<R>("o"));
    for (field, v) in [("p", p), ("o", o)] {
        if !v.is_finite() {
            return Err(non_finite(field));
        }
    }
    let found = prepared
        .solutions(p, o, &fixed(&previous))
        .map_err(|error| side_fault(&machine, error))?;
    let kind = match found.kind {
        Solutions::Two => "two",
        Solutions::One => "one",
        Solutions::Infinite => "infinite",
        Solutions::None => "none",
    };
    let solutions: Vec<Value> = [Some(found.first), found.second]
        .iter()
        .flatten()
        .map(|q: &Joints<LONGEST, R>| {
            let (tip, axis) = prepared.forward(q);
            json!({
                "q": machine.joint_values(&q.0),
                "tip_error": number((tip - p).norm()),
                "direction_error": number(axis.angle_to(o).to_degrees()),
            })
        })
        .collect();
    let off = found.gap > R::of(two_sided::direction::SNAP);
    let flags: &[&str] = if off { &["Residual"] } else { &[] };
    Ok(Answer::new()
        .put("kind", kind)
        .degrees("gap", found.gap)
        .maybe_number("s", found.s)
        .put("flags", flags)
        .put("solutions", &solutions))
}

fn solve<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (mill, support) = sides::<R>(request)?;
    let pair = Pair::new(padded(&mill)?, padded(&support)?)
        .map_err(|error| pair_fault(&mill, &support, error))?;
    let q1 = mill.read_joints(request.value("previous1"), "previous1")?;
    let q2 = support.read_joints(request.value("previous2"), "previous2")?;
    let limits = limits(request)?;
    let (p, n, d) = (
        request.vector::<R>("p"),
        request.vector::<R>("n"),
        request.number::<R>("d"),
    );
    if !(d.is_finite() && d > R::ZERO) {
        return Err(pair_fault(
            &mill,
            &support,
            PairError::<LONGEST, LONGEST, R>::BadWall,
        ));
    }
    for (field, v) in [("p", p), ("n", n)] {
        if !v.is_finite() {
            return Err(non_finite(field));
        }
    }
    let found = pair
        .solve(p, n, d, (&fixed(&q1), &fixed(&q2)))
        .map_err(|error| pair_fault(&mill, &support, error))?;
    let (q1, q2) = (found.mill.q, found.support.q);
    let tips = pair.forward(&q1, &q2);
    let n = n.unit(R::of(1e-6)).ok_or_else(bad_normal)?;
    let wall = tips.wall(Some(n)).ok_or_else(bad_normal)?;
    let mut flags = flags(&wall, &limits);
    if found.mill.is_off_direction() || found.support.is_off_direction() {
        flags.push("Residual");
    }
    let residual = [found.mill.residual, found.support.residual].map(R::to_degrees);
    let tip_error = [(tips.p_t - (p + n * d)).norm(), (tips.p_h - p).norm()];
    Ok(Answer::new()
        .put("q1", &mill.joint_values(&q1.0))
        .put("q2", &support.joint_values(&q2.0))
        .numbers("residual", residual)
        .numbers("tip_error", tip_error)
        .number("thickness", wall.thickness)
        .number("lateral", wall.lateral)
        .degrees("antiparallel", wall.anti_parallel)
        .put("flags", &flags))
}

fn pair_fault<const N1: usize, const N2: usize, R: Real>(
    mill: &Machine<R>,
    support: &Machine<R>,
    error: PairError<N1, N2, R>,
) -> Fault {
    match error {
        PairError::BadWall => {
            Fault::new("BadWall", "d must be a finite wall above 0 mm").field("d")
        }
        PairError::BadNormal => bad_normal(),
        PairError::NonFinite => non_finite("p"),
        PairError::WorkChainsDiffer { joint } => {
            let detail = format!(
                "work joint {} of side 2 must also be a work joint of side 1, in the same order: there is one panel",
                support.name(joint)
            );
            Fault::new("WorkChainsDiffer", detail)
                .field("machine")
                .with("index", joint)
        }
        PairError::Mill(error) => side_fault(mill, error).with("side", 1),
        PairError::Support(error) => side_fault(support, error).with("side", 2),
    }
}
