//! `five_axis.*`: tool tip and axis into the joints of any five-axis machine, and back; error bounds; whole paths.
//!
//! The library speaks radians and checks what it is given; here degrees become radians, its errors faults.

mod machine;
mod path;
mod pose;

use super::{Answer, Fault, Field, Function, Kind, Length, Request, answer, request, schema};
use hexstep::machines::five_axis::PRESETS;
use schema::{RANGE, VECTOR};

const FINITE: &str = "finite";
const DIRECTION: &str = "not shorter than 1e-6";

/// The machine, section 4.1.
const MACHINE: &[Field] = &[
    Field::new("preset", Kind::Word(&PRESETS), "", "").optional(),
    Field::new("class", Kind::Word(&["head", "table", "mixed"]), "", "").optional(),
    Field::new("n1", VECTOR, "", DIRECTION).optional(),
    Field::new("n2", VECTOR, "", DIRECTION).optional(),
    Field::new("q1", VECTOR, "mm", FINITE).optional(),
    Field::new("q2", VECTOR, "mm", FINITE).optional(),
    Field::new("v1", VECTOR, "", DIRECTION).optional(),
    Field::new("t0", VECTOR, "mm", FINITE).optional(),
    Field::new("w0", VECTOR, "mm", FINITE).optional(),
    Field::new("rw", MATRIX, "", "a rotation, within 1e-4").optional(),
    Field::new("linear", MATRIX, "", "|det| of the directions >= 1e-3").optional(),
    Field::new("limits", LIMITS, "mm, deg", "lo <= hi").optional(),
    Field::new("weights", pair(), "", "> 0").optional(),
    Field::new("speeds", FIVE, "mm/s, deg/s", "> 0").optional(),
];
/// Three rows, or three directions.
const MATRIX: Kind = Kind::List(&VECTOR, Length::Exactly(3));
const FIVE: Kind = Kind::List(&Kind::Number, Length::Exactly(5));
const LIMITS: Kind = Kind::List(&Kind::OrNull(&RANGE), Length::Exactly(5));

const fn pair() -> Kind {
    Kind::List(&Kind::Number, Length::Exactly(2))
}

const ON: &[Field] = &[Field::new(
    "machine",
    Kind::Preset(&PRESETS, MACHINE),
    "",
    "",
)];
const TIP: &[Field] = &[Field::new("p", VECTOR, "mm", FINITE)];
const AXIS: &[Field] = &[Field::new("v", VECTOR, "", DIRECTION)];
const PREVIOUS: &[Field] = &[Field::new("previous", pair(), "deg", FINITE).or("[0, 0]")];
const JOINTS: &[Field] = &[Field::new("q", FIVE, "mm, deg", FINITE)];
const CL_POINT: Kind = Kind::Object(&[
    Field::new("p", VECTOR, "mm", FINITE),
    Field::new("v", VECTOR, "", DIRECTION),
]);
const TWO_POINTS: &[Field] = &[Field::new(
    "cl",
    Kind::List(&CL_POINT, Length::Exactly(2)),
    "",
    "",
)];
/// More than any input holds.
const MANY: usize = 100_000_000;
const POINTS: &[Field] = &[Field::new(
    "cl",
    Kind::List(&CL_POINT, Length::Between(1, MANY)),
    "",
    "",
)];
const SAMPLES: &[Field] = &[Field::new("samples", Kind::Integer, "", "1 .. 1000000").or("400")];
const FOLLOWING: &[Field] = &[
    Field::number("feed", "mm/s at the tip", "> 0"),
    Field::number("tol", "mm", "> 0").or("0.01"),
    Field::number("tau", "deg", "> 0").or("0.05"),
    Field::new("subdivide", Kind::Flag, "", "").or("true"),
    Field::new("choice", Kind::Word(&["greedy", "best"]), "", "").or("\"greedy\""),
    Field::new("window", Kind::Integer, "points", ">= 0; 0 = whole path").or("0"),
];

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "five_axis.branches",
        summary: "All rotary angles for a tool axis; travel is not looked at.",
        fields: &[ON, AXIS, PREVIOUS],
        f64: pose::branches::<f64>,
        f32: Some(pose::branches::<f32>),
    },
    Function {
        name: "five_axis.inverse",
        summary: "Joints for a tool tip and axis, chosen within travel nearest to the previous ones.",
        fields: &[ON, TIP, AXIS, PREVIOUS],
        f64: pose::inverse::<f64>,
        f32: Some(pose::inverse::<f32>),
    },
    Function {
        name: "five_axis.forward",
        summary: "Tool tip and axis of five joints.",
        fields: &[ON, JOINTS],
        f64: pose::forward::<f64>,
        f32: Some(pose::forward::<f32>),
    },
    Function {
        name: "five_axis.bound",
        summary: "Bounds and true errors of linear joint interpolation between two CL points.",
        fields: &[ON, TWO_POINTS, PREVIOUS, SAMPLES],
        f64: path::bound::<f64>,
        f32: Some(path::bound::<f32>),
    },
    Function {
        name: "five_axis.path",
        summary: "Joint blocks within tolerance along CL points, with durations.",
        fields: &[ON, POINTS, PREVIOUS, FOLLOWING],
        f64: path::path::<f64>,
        f32: Some(path::path::<f32>),
    },
];
