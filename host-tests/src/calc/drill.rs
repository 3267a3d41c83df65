//! `drill.*`: the conical drill point, from geometry to grinding parameters to joints, and back.
//!
//! The library speaks radians and checks what it is given; here degrees become radians, its errors faults.

mod arm;
mod point;

use super::{Fault, Field, Function, Kind, Request};
use hexstep::cycles::drill_point::{Cone, Drill, DrillPointError, Motion, Variant};
use hexstep::geometry::Vector;
use hexstep::math::Real;

const LENGTH: &str = "> 0";
const RIGHT: &str = "0 < .. < 90";

const DIAMETER: Field = Field::number("diameter", "mm", LENGTH);
const WEB: Field = Field::number("web", "mm", "0 < .. < diameter");
const POINT_ANGLE: Field = Field::number("point_angle", "deg", "0 < .. < 180");
const HEEL_ANGLE: Field = Field::number("heel_angle", "deg", "0 .. 180").or("60");
/// The drill as it is wanted, without phi.
const DRILL: &[Field] = &[
    DIAMETER,
    WEB,
    POINT_ANGLE,
    Field::number("chisel_angle", "deg", RIGHT),
    Field::number("clearance", "deg", RIGHT),
];
/// The grinding parameters but Cz.
const CONE: &[Field] = &[
    Field::number("phi", "deg", RIGHT),
    Field::number("theta", "deg", RIGHT),
    Field::number("omega", "deg", "-90 < .. < 90"),
    Field::number("cx", "mm", ""),
    Field::number("cy", "mm", ""),
];
/// The drill's dimensions that the forward problem needs beside them.
const SIZE: &[Field] = &[DIAMETER, WEB];
const CZ: &[Field] = &[Field::number("cz", "mm", ""), POINT_ANGLE];
const MU: &[Field] = &[Field::number("mu", "deg", "-180 .. 180")];
const VARIANT: &[Field] =
    &[Field::new("variant", Kind::Word(&["exact", "published"]), "", "").or("\"exact\"")];
const STRUCTURE: &[Field] = &[
    Field::number("l1", "mm", ">= 0"),
    Field::number("l2", "mm", ">= 0"),
];
const HEEL: &[Field] = &[HEEL_ANGLE];

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "drill.solve",
        summary: "The grinding cone for a drill and an axis angle phi.",
        fields: &[
            DRILL,
            &[Field::number("phi", "deg", "0 < .. < point_angle/2")],
            HEEL,
        ],
        f64: point::solve::<f64>,
        f32: Some(point::solve::<f32>),
    },
    Function {
        name: "drill.forward",
        summary: "The geometry of the drill that a cone grinds.",
        fields: &[SIZE, CONE, HEEL],
        f64: point::forward::<f64>,
        f32: Some(point::forward::<f32>),
    },
    Function {
        name: "drill.suggest_phi",
        summary: "The phi of whole degrees whose heel clearance comes nearest to a target.",
        fields: &[DRILL, HEEL, &[Field::number("target", "deg", "").or("25")]],
        f64: point::suggest_phi::<f64>,
        f32: Some(point::suggest_phi::<f32>),
    },
    Function {
        name: "drill.motion",
        summary: "Rotation and tip displacement at the grinding rotation mu.",
        fields: &[CONE, CZ, MU, VARIANT],
        f64: arm::motion::<f64>,
        f32: Some(arm::motion::<f32>),
    },
    Function {
        name: "drill.joints",
        summary: "The arm's six joints at the grinding rotation mu.",
        fields: &[
            CONE,
            CZ,
            MU,
            VARIANT,
            STRUCTURE,
            &[
                Field::number("standoff", "mm", "").or("0"),
                Field::new("flank", Kind::Integer, "", "1 or 2").or("1"),
                Field::number("previous_theta1", "deg", "kept at the singular pose").or("0"),
            ],
        ],
        f64: arm::joints::<f64>,
        f32: Some(arm::joints::<f32>),
    },
    Function {
        name: "drill.fk",
        summary: "The drill's pose at six joint values.",
        fields: &[
            &[
                Field::number("theta1", "deg", ""),
                Field::number("theta2", "deg", ""),
                Field::number("theta3", "deg", ""),
                Field::number("d1", "mm", ""),
                Field::number("d2", "mm", ""),
                Field::number("d3", "mm", ""),
                POINT_ANGLE,
            ],
            STRUCTURE,
        ],
        f64: arm::fk::<f64>,
        f32: Some(arm::fk::<f32>),
    },
    Function {
        name: "drill.range",
        summary: "Where contact with the wheel begins and ends, in mu.",
        fields: &[
            SIZE,
            CONE,
            HEEL,
            &[Field::number("over", "deg", "0 .. 90").or("2")],
        ],
        f64: point::range::<f64>,
        f32: Some(point::range::<f32>),
    },
    Function {
        name: "drill.plan",
        summary: "The passes that take an axial stock, and the stand-off after each infeed.",
        fields: &[&[
            Field::number("stock", "mm", LENGTH),
            POINT_ANGLE,
            Field::number("rough_depth", "mm", LENGTH).or("0.03"),
            Field::number("finish_depth", "mm", LENGTH).or("0.01"),
            Field::new("finish_passes", Kind::Integer, "", "0 .. 10000").or("3"),
            Field::new("spark_out", Kind::Integer, "", "0 .. 10000").or("2"),
        ]],
        f64: point::plan::<f64>,
        f32: Some(point::plan::<f32>),
    },
    Function {
        name: "drill.chord",
        summary: "The largest error of joint-linear motion between samples of a stroke.",
        fields: &[
            CONE,
            CZ,
            STRUCTURE,
            &[
                Field::number("mu_from", "deg", "-180 .. 180"),
                Field::number("mu_to", "deg", "-180 .. 180"),
                Field::new("segments", Kind::Integer, "", "1 .. 1000000"),
            ],
        ],
        f64: arm::chord::<f64>,
        f32: Some(arm::chord::<f32>),
    },
];

impl<R: Real> From<DrillPointError<R>> for Fault {
    fn from(error: DrillPointError<R>) -> Self {
        let fault = match error {
            DrillPointError::ClearanceTooSmall { least } => {
                figure(error, "least", least.to_degrees())
            }
            DrillPointError::PhiTooSmall { phi_min } => {
                figure(error, "phi_min", phi_min.to_degrees())
            }
            _ => Fault::new(error.name(), error.remedy()),
        };
        match error.field() {
            Some(field) => fault.field(field.name()),
            None => fault,
        }
    }
}

fn figure<R: Real>(error: DrillPointError<R>, name: &'static str, degrees: R) -> Fault {
    let degrees = degrees.to_f64();
    let detail = format!("{}: {degrees:.6} deg", error.remedy());
    Fault::new(error.name(), detail).with(name, degrees)
}

/// Every number must be finite, before any range is looked at; the first that is not is named.
fn finite<R: Real>(request: &Request) -> Result<(), Fault> {
    match request.not_finite::<R>() {
        None => Ok(()),
        Some(name) => {
            let detail = format!("{name} must be a finite number");
            Err(Fault::new("NotFinite", detail).field(name))
        }
    }
}

fn require(good: bool, field: &str, expected: &str) -> Result<(), Fault> {
    if good {
        Ok(())
    } else {
        Err(Fault::new("OutOfRange", format!("{field} must be {expected}")).field(field))
    }
}

fn drill<R: Real>(request: &Request) -> Drill<R> {
    Drill {
        diameter: request.number("diameter"),
        web: request.number("web"),
        point_angle: request.degrees("point_angle"),
        chisel_angle: request.degrees("chisel_angle"),
        clearance: request.degrees("clearance"),
    }
}

/// The cone of a request; Cz is 0 where the request has none.
fn cone<R: Real>(request: &Request) -> Cone<R> {
    let cz = request.maybe_number("cz").unwrap_or(R::ZERO);
    Cone {
        phi: request.degrees("phi"),
        theta: request.degrees("theta"),
        omega: request.degrees("omega"),
        tip: Vector::new(request.number("cx"), request.number("cy"), cz),
    }
}

fn motion_of<R: Real>(request: &Request, variant: Variant) -> Result<Motion<R>, Fault> {
    Ok(Motion::new(
        &cone(request),
        request.degrees("point_angle"),
        variant,
    )?)
}

fn variant(request: &Request) -> Variant {
    match request.word("variant") {
        "published" => Variant::Published,
        _ => Variant::Exact,
    }
}
