//! `surface.*`: curvature, contact, removal, spacing and step of surface grinding; whole plans and what they leave.
//!
//! Source: specification of surface grinding; the formulas are the library's, planning and simulation the host's.

mod contact;
mod given;
mod local;
mod plan;

use super::machine::POSE;
use super::schema::{NUMBERS, VECTOR};
use super::{Field, Function, Kind, Length, arm};

const PAIR: Kind = Kind::List(&Kind::Number, Length::Exactly(2));

const SURFACE: Field = Field::new(
    "surface",
    Kind::Preset(
        &["dune"],
        &[
            Field::new("degree_u", Kind::Integer, "", "1..5"),
            Field::new("degree_v", Kind::Integer, "", "1..5"),
            Field::new("knots_u", NUMBERS, "", "clamped"),
            Field::new("knots_v", NUMBERS, "", "clamped"),
            Field::new(
                "points",
                Kind::List(&Kind::List(&VECTOR, Length::Any), Length::Any),
                "mm",
                "rows along u, each a row of points along v",
            ),
            Field::new("weights", Kind::List(&NUMBERS, Length::Any), "", "> 0").optional(),
        ],
    ),
    "",
    "dune, or {degree_u, degree_v, knots_u, knots_v, points, weights}",
)
.or("\"dune\"");

const RADIUS: Kind = Kind::OrNull(&Kind::Number);

/// Without defaults: those of the preset stand.
const JOB: Field = Field::new(
    "job",
    Kind::Open(
        &["a", "b"],
        &[
            Field::new("preset", Kind::Word(&["a", "b"]), "", "").optional(),
            Field::new("r_rim", RADIUS, "mm", "> 0; null: flat").optional(),
            Field::new("r_crown", RADIUS, "mm", "> 0; null: flat").optional(),
            Field::number("force", "N", "> 0").optional(),
            Field::number("e1", "MPa", "> 0").optional(),
            Field::number("nu1", "", "0..0.5").optional(),
            Field::number("e2", "MPa", "> 0").optional(),
            Field::number("nu2", "", "0..0.5").optional(),
            Field::number("k", "1/Pa", "> 0").optional(),
            Field::number("rpm", "1/min", "> 0").optional(),
            Field::number("feed", "mm/s", "> 0").optional(),
            Field::new("sense", Kind::Integer, "", "-1, 0, 1").optional(),
            Field::number("scallop", "mm", "> 0").optional(),
            Field::number("margin", "", "0 <= margin < 1").optional(),
            Field::number("eps", "mm", "> 0").optional(),
            Field::number("e_lat", "mm", "> 0").optional(),
            Field::number("e_gap", "mm", "> 0").optional(),
            Field::number("l_max", "mm", "> 0").optional(),
            Field::number("turn", "deg", "> 0").optional(),
            Field::new("model", Kind::Word(&["envelope", "additive"]), "", "").optional(),
            Field::new(
                "depth_mode",
                Kind::Word(&["constant_feed", "constant_depth"]),
                "",
                "",
            )
            .optional(),
            Field::number("depth", "mm", "> 0; of constant_depth").optional(),
            Field::new(
                "strategy",
                Kind::Word(&["adaptive", "rowmin", "iso"]),
                "",
                "",
            )
            .optional(),
            Field::new("rows", Kind::Integer, "", "2..20000; iso only").optional(),
            Field::new("step_mode", Kind::Word(&["common", "row"]), "", "").optional(),
            Field::new("nodes", Kind::Integer, "", "5..4001").optional(),
            Field::number("seed", "", "0..1").optional(),
        ],
    ),
    "",
    "a, b, or an object of overrides, with or without a preset",
)
.or("\"a\"");

const CONTACT: &[Field] = &[
    JOB,
    Field::number("k_f", "1/mm", "along the feed").or("0"),
    Field::number("k_c", "1/mm", "across").or("0"),
    Field::number("tau", "1/mm", "twist").or("0"),
    Field::number(
        "half_width",
        "mm",
        "> 0, of the wheel; left out: not checked",
    )
    .optional(),
];

const STATIONS: Field = Field::new("stations", Kind::Integer, "", "1..10000").or("60");

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "surface.nurbs",
        summary: "Points, derivatives, normals and curvatures of a surface.",
        fields: &[&[
            SURFACE,
            Field::new("uv", Kind::List(&PAIR, Length::Any), "", "in the domain"),
            Field::new("direction", PAIR, "", "of the feed: du, dv").or("[1,0]"),
        ]],
        f64: local::nurbs::<f64>,
        f32: Some(local::nurbs::<f32>),
    },
    Function {
        name: "surface.hertz",
        summary: "The ellipse of contact between wheel and part.",
        fields: &[CONTACT],
        f64: contact::hertz::<f64>,
        f32: Some(contact::hertz::<f32>),
    },
    Function {
        name: "surface.removal",
        summary: "The stripe that one pass takes away, and the feed for a depth.",
        fields: &[
            CONTACT,
            &[
                Field::new("y", NUMBERS, "mm", "left out: 0, b_c/2, b_c").optional(),
                Field::number("target_depth", "mm", "> 0").optional(),
            ],
        ],
        f64: contact::removal::<f64>,
        f32: Some(contact::removal::<f32>),
    },
    Function {
        name: "surface.spacing",
        summary: "The pitch of rows that leaves a scallop.",
        fields: &[&[
            Field::number("b_c", "mm", "> 0, half the stripe"),
            Field::number("h0", "mm", "> 0, its depth"),
            Field::number("k_c", "1/mm", "across").or("0"),
            Field::number("scallop", "mm", "> 0").or("0.04"),
            Field::number("margin", "", "0 <= margin < 1").or("0"),
            Field::new("model", Kind::Word(&["envelope", "additive"]), "", "").or("\"envelope\""),
        ]],
        f64: local::spacing::<f64>,
        f32: Some(local::spacing::<f32>),
    },
    Function {
        name: "surface.step",
        summary: "The longest chord along a row, and what limits it.",
        fields: &[&[
            Field::number("k_n", "1/mm", "normal curvature of the row").or("0"),
            Field::number("k_g", "1/mm", "geodesic curvature").or("0"),
            Field::number("eps", "mm", "> 0").or("0.1"),
            Field::number("l_max", "mm", "> 0").or("20"),
            Field::number("turn", "deg", "> 0").or("10"),
            Field::number("e_lat", "mm", "> 0; left out: no lateral limit").optional(),
        ]],
        f64: local::step::<f64>,
        f32: Some(local::step::<f32>),
    },
    Function {
        name: "surface.plan",
        summary: "All rows of a surface, what they leave, and the joints of the arm.",
        fields: &[&[
            SURFACE,
            JOB,
            STATIONS,
            Field::new("measure", Kind::Flag, "", "simulate the residual").or("true"),
            Field::new("path", Kind::Flag, "", "answer the points").or("false"),
            Field::new("joints", Kind::Flag, "", "and the joints; needs path").or("false"),
            arm::ARM,
            Field::new("frame", POSE, "mm", "work frame in the base")
                .or("[[1,0,0,340],[0,1,0,-75],[0,0,1,300],[0,0,0,1]]"),
            Field::number("tool", "mm", "from flange to contact").or("110"),
        ]],
        f64: plan::plan,
        f32: None,
    },
    Function {
        name: "surface.residual",
        summary: "What given rows leave between them.",
        fields: &[&[
            SURFACE,
            JOB,
            Field::new(
                "path",
                Kind::Any,
                "mm",
                "rows as polylines, each [[u, v], ...], {uv: ...} or {xyz: ...}",
            ),
            STATIONS,
        ]],
        f64: plan::residual,
        f32: None,
    },
];
