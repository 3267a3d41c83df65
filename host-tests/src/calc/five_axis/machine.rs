//! The machine of a request, the checks that come before it, and the library's errors as faults.

use super::{Fault, Request, answer, request, schema};
use hexstep::geometry::{Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::ClPoint;
use hexstep::machines::five_axis::{self, Class, Definition, Error, FiveAxis, Turned, preset};
use hexstep::math::Real;
use serde_json::{Map, Value};

/// Every number of the request is finite; then every direction long enough; then the machine.
///
/// The table of errors is applied from top to bottom over the whole request, so a number that is not finite anywhere
/// comes before a short direction anywhere.
pub fn machine<R: Real>(request: &Request) -> Result<FiveAxis<R>, Fault> {
    for field in [
        "machine", "p", "v", "q", "cl", "previous", "feed", "tol", "tau",
    ] {
        if let Some(value) = request.value(field) {
            check_finite::<R>(value, field)?;
        }
    }
    if let Some(v) = request.maybe_vector::<R>("v") {
        five_axis::direction(v, "v").map_err(|e| fault(&e))?;
    }
    for (index, point) in request.list("cl").iter().enumerate() {
        let v = point.get("v").and_then(request::read_vector::<R>);
        if let Some(v) = v {
            five_axis::direction(v, "v").map_err(|e| fault(&e).with("index", index))?;
        }
    }
    let definition = match request.value("machine") {
        Some(Value::Object(object)) => definition(object)?,
        name => named(name)?,
    };
    FiveAxis::new(&definition).map_err(|error| fault(&error))
}

fn named<R: Real>(name: Option<&Value>) -> Result<Definition<R>, Fault> {
    let name = name.and_then(Value::as_str).unwrap_or("");
    // The schema has checked the name.
    preset(name).ok_or_else(|| {
        Fault::new("UnknownName", format!("there is no machine {name}")).field("machine")
    })
}

fn definition<R: Real>(object: &Map<String, Value>) -> Result<Definition<R>, Fault> {
    let given = |name: &str| object.get(name).filter(|v| !v.is_null());
    let mut machine: Definition<R> = match given("preset") {
        Some(name) => named(Some(name))?,
        None => {
            if let Some(name) = ["class", "n1", "n2"]
                .into_iter()
                .find(|n| given(n).is_none())
            {
                let detail = format!("machine.{name} is required unless machine.preset is given");
                return Err(Fault::new("MissingField", detail).field(name));
            }
            named(Some(&Value::from("head_ca")))?
        }
    };
    match given("class").and_then(Value::as_str) {
        Some("head") => machine.class = Class::Head,
        Some("table") => machine.class = Class::Table,
        Some("mixed") => machine.class = Class::Mixed,
        _ => {}
    }
    for (name, place) in [
        ("n1", &mut machine.n1),
        ("n2", &mut machine.n2),
        ("q1", &mut machine.q1),
        ("q2", &mut machine.q2),
        ("v1", &mut machine.v1),
        ("t0", &mut machine.t0),
        ("w0", &mut machine.w0),
    ] {
        if let Some(v) = given(name).and_then(request::read_vector) {
            *place = v;
        }
    }
    if let Some([n, s, a]) = given("rw").and_then(three) {
        // Rows as they are written, columns as they are kept.
        machine.rw = Rotation { n, s, a }.transposed();
    }
    if let Some(linear) = given("linear").and_then(three) {
        machine.linear = linear;
    }
    if let Some(Value::Array(limits)) = given("limits") {
        for (axis, (place, limit)) in machine.limits.iter_mut().zip(limits).enumerate() {
            let range = limit.as_array().map(|ends| numbers::<R>(ends));
            *place = match range.as_deref() {
                Some([lo, hi]) => Some([inner(axis, *lo), inner(axis, *hi)]),
                _ => None,
            };
        }
    }
    if let Some([w1, w2]) = given("weights")
        .and_then(Value::as_array)
        .map(|w| numbers(w))
        .as_deref()
    {
        machine.weights = [*w1, *w2];
    }
    if let Some(speeds) = given("speeds").and_then(Value::as_array) {
        let mut all = [R::ZERO; 5];
        for (axis, (place, speed)) in all.iter_mut().zip(numbers::<R>(speeds)).enumerate() {
            *place = inner(axis, speed);
        }
        machine.speeds = Some(all);
    }
    Ok(machine)
}

fn numbers<R: Real>(values: &[Value]) -> Vec<R> {
    values.iter().filter_map(request::read).collect()
}

fn three<R: Real>(value: &Value) -> Option<[Vector<R>; 3]> {
    match value.as_array()?.as_slice() {
        [a, b, c] => Some([
            request::read_vector(a)?,
            request::read_vector(b)?,
            request::read_vector(c)?,
        ]),
        _ => None,
    }
}

/// A joint value as the library has it: degrees of the rotaries in radians.
fn inner<R: Real>(axis: usize, x: R) -> R {
    if axis < 3 { x } else { x.to_radians() }
}

/// Joint values as the interface has them: degrees.
pub fn outer<R: Real>(joints: &Joints<5, R>) -> [R; 5] {
    let Joints([x, y, z, primary, secondary]) = *joints;
    [x, y, z, primary.to_degrees(), secondary.to_degrees()]
}

pub fn joints<R: Real>(request: &Request) -> Joints<5, R> {
    let mut q = Joints::default();
    for (axis, (place, x)) in q.0.iter_mut().zip(request.numbers::<R>("q")).enumerate() {
        *place = inner(axis, x);
    }
    q
}

pub fn previous<R: Real>(request: &Request) -> [Turned<R>; 2] {
    match request.numbers::<R>("previous").as_slice() {
        [primary, secondary] => [*primary, *secondary].map(from_degrees),
        _ => Default::default(),
    }
}

/// Whole turns come off in degrees, where they are exact.
fn from_degrees<R: Real>(angle: R) -> Turned<R> {
    let turn = R::of(360.0);
    let turns = ((angle - R::of(180.0)) / turn).ceil();
    let rest = Turned::from_total((angle - turns * turn).to_radians());
    Turned {
        turns: rest.turns.saturating_add(turns.to_f64() as i32),
        ..rest
    }
}

/// The CL point of a checked object with `p` and `v`.
pub fn cl_point<R: Real>(p: Vector<R>, v: Vector<R>) -> Result<ClPoint<R>, Fault> {
    let unit = five_axis::direction(v, "v").map_err(|e| fault(&e))?;
    ClPoint::new(p, unit).ok_or_else(|| fault(&Error::<R>::NonFinite { field: "p" }))
}

/// Refuses the first number that is not finite in the scalar of the calculation.
fn check_finite<R: Real>(value: &Value, field: &str) -> Result<(), Fault> {
    match value {
        Value::Array(entries) => {
            for (index, entry) in entries.iter().enumerate() {
                let checked = check_finite::<R>(entry, field);
                match field {
                    "cl" => checked.map_err(|fault| fault.with("index", index))?,
                    _ => checked?,
                }
            }
            Ok(())
        }
        Value::Object(members) => members
            .iter()
            .try_for_each(|(name, value)| check_finite::<R>(value, name)),
        _ => match schema::number_of(value) {
            Some(x) if !R::of(x).is_finite() => Err(fault(&Error::<R>::NonFinite {
                field: schema_name(field),
            })),
            _ => Ok(()),
        },
    }
}

/// The field's name with the lifetime that the library's errors want.
fn schema_name(field: &str) -> &'static str {
    let own = super::FUNCTIONS
        .iter()
        .flat_map(|f| f.fields.iter().copied().flatten());
    let all = own
        .chain(super::MACHINE)
        .chain(super::TIP)
        .chain(super::AXIS);
    all.map(|f| f.name)
        .find(|name| *name == field)
        .unwrap_or("cl")
}

/// The library's error as the interface answers it.
pub fn fault<R: Real>(error: &Error<R>) -> Fault {
    let detail = match error {
        Error::NonFinite { field } => {
            format!("{field} must hold finite numbers, not too large to be computed with")
        }
        Error::BadDirection { field } => {
            format!("{field} is a direction: it must not be shorter than 1e-6")
        }
        Error::BadAxis { field: "rw" } => {
            "rw must be a rotation within 1e-4: three unit rows at right angles, right-handed".into()
        }
        Error::BadAxis { field } => {
            format!("{field} is the direction of an axis: it must not be shorter than 1e-6")
        }
        Error::ParallelAxes => "the rotary axes are parallel: |n1 x n2| must be at least 1e-3".into(),
        Error::ToolAlongAxis => {
            "the rotary axis next to the tool is parallel to it: the sine between them must be at least 1e-3"
                .into()
        }
        Error::LinearAxesDependent => {
            "the linear axes lie in one plane: |det| of their directions must be at least 1e-3".into()
        }
        Error::BadLimit { field: "limits" } => "limits must be [lo, hi] with lo <= hi".into(),
        Error::BadLimit { field } => format!("{field} must be above 0"),
        Error::Unreachable { gap, .. } => format!(
            "the direction is {} deg outside the band that the machine reaches; tilt the tool by as much",
            gap.to_degrees().to_f64()
        ),
        Error::OutOfTravel { axis } => format!(
            "every solution leaves the travel of {}; widen its limits or move the work",
            axis.name()
        ),
    };
    let fault = Fault::new(error.name(), detail);
    match error {
        Error::NonFinite { field }
        | Error::BadDirection { field }
        | Error::BadAxis { field }
        | Error::BadLimit { field } => fault.field(field),
        Error::Unreachable { gap, nearest } => {
            let nearest: Vec<Value> = outer(nearest).into_iter().map(answer::number).collect();
            fault
                .with("gap", answer::number(gap.to_degrees()))
                .with("nearest", nearest)
        }
        Error::OutOfTravel { axis } => fault.with("axis", axis.name()),
        _ => fault,
    }
}
