//! `chain.*`: any serial machine of screws, forward and by damped Newton.
//!
//! Source: specification of mirror milling, section 2.

use super::answer::number;
use super::machine::{CHAIN, Machine, POSE, bad_direction, non_finite, pose_rows, read_pose};
use super::schema::{NUMBERS, VECTOR};
use super::{Answer, Fault, Field, Function, Kind, Request};
use hexstep::geometry::Twist;
use hexstep::kinematics::chain::ChainError;
use hexstep::kinematics::inverse::{Failure, Report, Target, Tolerance, solve};
use hexstep::math::Real;
use serde_json::Value;

const MACHINE: Field = Field::new(
    "machine",
    CHAIN,
    "",
    "m4_1 | m4_2 | m5_1 | m5_2, or {joints, tool_home, work_home, r_p, r_o}",
);

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "chain.forward",
        summary: "Frames, tip and axis of a chain of any length.",
        fields: &[&[
            MACHINE,
            Field::new("q", NUMBERS, "mm or deg", "one for each joint"),
        ]],
        f64: forward::<f64>,
        f32: Some(forward::<f32>),
    },
    Function {
        name: "chain.inverse",
        summary: "Joints of a chain of any length for a pose (six conditions) or a tip and axis (five).",
        fields: &[&[
            MACHINE,
            Field::new("pose", POSE, "mm", "either this").optional(),
            Field::new("p", VECTOR, "mm", "or tip").optional(),
            Field::new("o", VECTOR, "", "and axis").optional(),
            Field::new("previous", NUMBERS, "mm or deg", "start; 0 if left out").optional(),
            Field::number("tol", "mm", ">= 0; 1e-9 if left out (f32: 1e-3)").optional(),
            Field::number("tol_angle", "deg", ">= 0; 1e-9 if left out (f32: 1e-4)").optional(),
            Field::new("max_iterations", Kind::Integer, "", "0..1000000").or("50"),
        ]],
        f64: inverse::<f64>,
        f32: Some(inverse::<f32>),
    },
];

fn machine<R: Real>(request: &Request) -> Result<Machine<R>, Fault> {
    Machine::read(request.value("machine").unwrap_or(&Value::Null))
}

fn forward<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let machine = machine::<R>(request)?;
    let q = machine.read_joints(request.value("q"), "q")?;
    let series = machine.series();
    let (p, o) = series.tip(&q);
    let twists: Vec<_> = machine
        .joints()
        .iter()
        .map(|joint| joint.twist().to_array().map(number))
        .collect();
    Ok(Answer::new()
        .put("pose", &pose_rows(&series.forward(&q)))
        .vector("p", p)
        .vector("o", o)
        .put("tool", &pose_rows(&series.tool(&q)))
        .put("work", &pose_rows(&series.work(&q)))
        .put("twists", &twists))
}

fn inverse<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let missing = |field: &str, detail: &str| Fault::new("MissingField", detail).field(field);
    let (p, o) = (request.maybe_vector("p"), request.maybe_vector("o"));
    let wanted = (request.value("pose"), p, o);
    match wanted {
        (None, None, None) => {
            return Err(missing("pose", "pose is required, or p and o instead"));
        }
        (None, Some(_), None) => return Err(missing("o", "o is required with p")),
        (None, None, Some(_)) => return Err(missing("p", "p is required with o")),
        (Some(_), Some(_), _) | (Some(_), _, Some(_)) => {
            let detail = "give either pose, or p and o, not both";
            return Err(Fault::new("WrongType", detail).field("pose"));
        }
        _ => {}
    }
    let machine = machine::<R>(request)?;
    let mut q = machine.read_joints(request.value("previous"), "previous")?;
    let target = match wanted {
        (Some(rows), ..) => Target::Pose(read_pose(rows).map_err(|error| match error {
            ChainError::NonFinite => non_finite("pose"),
            _ => bad_pose(),
        })?),
        (None, p, o) => {
            let (p, o) = (p.unwrap_or_default(), o.unwrap_or_default());
            if !p.is_finite() {
                return Err(non_finite("p"));
            }
            if !o.is_finite() {
                return Err(non_finite("o"));
            }
            Target::TipAxis { p, o }
        }
    };
    let tolerance = tolerance(request)?;
    let mut columns = vec![Twist::ZERO; q.len()];
    let mut trial = q.clone();
    let report = solve(
        &machine.series(),
        &target,
        &mut q,
        &mut columns,
        &mut trial,
        &tolerance,
    )
    .map_err(|failure| match failure {
        Failure::NoConvergence(report) => no_convergence(&machine, &q, &report),
        Failure::OutOfTravel { joint } => machine.out_of_travel(joint),
        Failure::NonFinite => non_finite("tol"),
        Failure::BadDirection => bad_direction("o"),
        Failure::BadPose => bad_pose(),
    })?;
    Ok(Answer::new()
        .put("q", &machine.joint_values(&q))
        .put("iterations", &report.iterations)
        .number("tip_error", report.tip_error)
        .degrees("direction_error", report.direction_error))
}

fn bad_pose() -> Fault {
    let detail = "pose must be [[R, p], [0 0 0 1]] with a rotation R (1e-6)";
    Fault::new("BadPose", detail).field("pose")
}

fn no_convergence<R: Real>(machine: &Machine<R>, q: &[R], report: &Report<R>) -> Fault {
    let detail = format!(
        "after {} iterations the tip is {:.3e} mm and the direction {:.3e} deg away; start nearer, allow more iterations, \
         or ask for a pose within reach",
        report.iterations,
        report.tip_error.to_f64(),
        report.direction_error.to_degrees().to_f64(),
    );
    Fault::new("NoConvergence", detail)
        .with("nearest", machine.joint_values(q))
        .with("tip_error", number(report.tip_error))
        .with(
            "direction_error",
            number(report.direction_error.to_degrees()),
        )
}

fn tolerance<R: Real>(request: &Request) -> Result<Tolerance<R>, Fault> {
    let mut tolerance = Tolerance::default();
    let given = |field: &str| -> Result<Option<R>, Fault> {
        match request.maybe_number::<R>(field) {
            Some(x) if !x.is_finite() => Err(non_finite(field)),
            Some(x) if x < R::ZERO => {
                let detail = format!("{field} must not be negative");
                Err(Fault::new("BadLimit", detail).field(field))
            }
            x => Ok(x),
        }
    };
    if let Some(tip) = given("tol")? {
        tolerance.tip = tip;
    }
    if let Some(angle) = given("tol_angle")? {
        tolerance.angle = angle.to_radians();
    }
    let iterations = request.integer("max_iterations");
    tolerance.iterations = u32::try_from(iterations)
        .ok()
        .filter(|i| *i <= 1_000_000)
        .ok_or_else(|| {
            let detail = "max_iterations must lie in 0..1000000";
            Fault::new("BadLimit", detail).field("max_iterations")
        })?;
    Ok(tolerance)
}
