//! One pose: `five_axis.branches`, `five_axis.inverse`, `five_axis.forward`.

use super::machine::{cl_point, fault, joints, machine, outer, previous};
use super::{Answer, Fault, Request, answer};
use hexstep::geometry::Vector;
use hexstep::joints::Joints;
use hexstep::math::Real;
use serde_json::{Value, json};

pub fn branches<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let machine = machine::<R>(request)?;
    let v = cl_point(Vector::ZERO, request.vector("v"))?.v();
    let branches = machine.branches(v, &previous(request));
    let mut solutions = Vec::new();
    for [primary, secondary] in branches.solutions() {
        let q = Joints([R::ZERO, R::ZERO, R::ZERO, *primary, *secondary]);
        let (_, reached) = machine.forward(&q).map_err(|e| fault(&e))?;
        solutions.push(json!({
            "primary": answer::number(primary.to_degrees()),
            "secondary": answer::number(secondary.to_degrees()),
            "direction_error": answer::number(angle(reached, v).to_degrees()),
        }));
    }
    Ok(Answer::new()
        .put("kind", branches.kind.name())
        .degrees("gap", branches.gap)
        .number("s", branches.s)
        .numbers("band", machine.band().map(R::to_degrees))
        .value("solutions", Value::Array(solutions)))
}

pub fn inverse<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let machine = machine::<R>(request)?;
    let at = cl_point::<R>(request.vector("p"), request.vector("v"))?;
    let solution = machine
        .inverse(at.p(), at.v(), &previous(request))
        .map_err(|e| fault(&e))?;
    let q = solution.joints();
    let (p, v) = machine.forward(&q).map_err(|e| fault(&e))?;
    Ok(Answer::new()
        .numbers("q", outer(&q))
        .put("kind", solution.kind.name())
        .put("solution", &solution.number)
        .degrees("cost", solution.cost)
        .degrees("gap", solution.gap)
        .number("s", solution.s)
        .number("tip_error", (p - at.p()).norm())
        .degrees("direction_error", angle(v, at.v())))
}

pub fn forward<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let machine = machine::<R>(request)?;
    let (p, v) = machine.forward(&joints(request)).map_err(|e| fault(&e))?;
    Ok(Answer::new().vector("p", p).vector("v", v))
}

/// Between two directions [rad].
pub fn angle<R: Real>(a: Vector<R>, b: Vector<R>) -> R {
    a.cross(b).norm().atan2(a.dot(b))
}
