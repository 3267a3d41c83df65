//! `surface.nurbs`, `surface.spacing`, `surface.step`: one place at a time.

use super::super::answer::number;
use super::super::{Answer, Fault, Request};
use super::given::{MODELS, bad, fault_of_grinding, fault_of_surface, part};
use hexstep::cycles::surface_grinding::{Field, GrindingError, Model, StepLimits, Stripe, pitch};
use hexstep::geometry::Vector;
use hexstep::geometry::nurbs::NurbsError;
use hexstep::math::Real;
use serde_json::{Value, json};

pub fn nurbs<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let part = part::<R>(request)?;
    let direction = request.numbers::<R>("direction");
    let (du, dv) = match direction.as_slice() {
        [du, dv] if (*du * *du + *dv * *dv).sqrt() >= R::of(1e-6) => (*du, *dv),
        _ => (R::ZERO, R::ZERO),
    };
    if !(du.is_finite() && dv.is_finite()) || (du == R::ZERO && dv == R::ZERO) {
        return Err(bad("direction", "must be finite and longer than 1e-6"));
    }
    let mut points: Vec<Value> = Vec::new();
    for (index, pair) in request.list("uv").iter().enumerate() {
        let at = |e: NurbsError| fault_of_surface(e).field("uv").with("index", index);
        let read = |i: usize| super::super::request::read::<R>(&pair[i]).unwrap_or(R::ZERO);
        let shape = part.shape(read(0), read(1)).map_err(at)?;
        let section = shape
            .along(du, dv)
            .ok_or_else(|| at(NurbsError::DegenerateNormal))?;
        let vector = |v: Vector<R>| v.to_array().map(number).to_vec();
        let [k1, k2] = shape.principal();
        let jet = &shape.jet;
        points.push(json!({
            "s": vector(jet.s),
            "s_u": vector(jet.s_u),
            "s_v": vector(jet.s_v),
            "s_uu": vector(jet.s_uu),
            "s_uv": vector(jet.s_uv),
            "s_vv": vector(jet.s_vv),
            "n": vector(shape.normal),
            "k_f": number(section.k_f),
            "k_c": number(section.k_c),
            "tau": number(section.tau),
            "k1": number(k1),
            "k2": number(k2),
        }));
    }
    Ok(Answer::new().put("points", &points))
}

pub fn spacing<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let figure = |name: &str| request.number::<R>(name);
    let (k_c, margin) = (figure("k_c"), figure("margin"));
    let stripe = Stripe {
        b_c: figure("b_c"),
        h0: figure("h0"),
    };
    if !(margin >= R::ZERO && margin < R::ONE) {
        return Err(fault_of_grinding(GrindingError::<R>::BadParameter(
            Field::Margin,
        )));
    }
    let word = request.word("model");
    let model = MODELS.iter().find(|(w, _)| *w == word);
    let model = model.map_or(Model::Envelope, |(_, m)| *m);
    let scallop = figure("scallop") * (R::ONE - margin);
    let pitch = pitch(model, stripe, k_c, scallop).map_err(fault_of_grinding)?;
    let exact = match (model, pitch.touching) {
        (Model::Envelope, false) => circle_pitch(
            stripe.b_c.to_f64(),
            stripe.h0.to_f64(),
            k_c.to_f64(),
            scallop.to_f64(),
        ),
        _ => None,
    };
    Ok(Answer::new()
        .number("pitch", pitch.d)
        .put("touching", &pitch.touching)
        .maybe_number("exact", exact.map(R::of)))
}

/// Arc length between two rows on a circular section of curvature `k` at which the cusp stands `scallop` above the chord of
/// the groove centres, each groove measured in the tool plane of its own contact. `None` beyond touching stripes.
fn circle_pitch(b: f64, h0: f64, k: f64, scallop: f64) -> Option<f64> {
    // The circle in the tool plane of a contact, and the ground on it, below the contact.
    let ground = |y: f64| {
        let root = 1.0 - k * k * y * y;
        let circle = -k * y * y / (1.0 + root.max(0.0).sqrt());
        (root >= 0.0).then_some(circle - h0 * (1.0 - y * y / (b * b)))
    };
    let excess = |d: f64| -> Option<f64> {
        // The right one of two contacts that stand to both sides of x = 0, turned by half the angle between them.
        let (sin, cos) = (k * d / 2.0).sin_cos();
        let x = if k == 0.0 { d / 2.0 } else { sin / k };
        // y of the point on x = 0: x + y cos + z sin = 0.
        let mut y = -x / cos;
        for _ in 0..200 {
            let next = -(x + ground(y)? * sin) / cos;
            let change = (next - y).abs();
            y = next;
            if change < 1e-15 * b {
                break;
            }
        }
        Some(-y * sin + (ground(y)? + h0) * cos - scallop)
    };
    let (mut lo, mut hi) = (0.0, 2.0 * b);
    if excess(hi)? < 0.0 {
        return None;
    }
    for _ in 0..200 {
        let middle = 0.5 * (lo + hi);
        if excess(middle)? < 0.0 {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    Some(0.5 * (lo + hi))
}

pub fn step<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let limits = StepLimits {
        eps: request.number::<R>("eps"),
        l_max: request.number("l_max"),
        turn: request.degrees("turn"),
        e_lat: request.maybe_number("e_lat"),
    };
    let step = limits
        .step(request.number("k_n"), request.number("k_g"))
        .map_err(fault_of_grinding)?;
    Ok(Answer::new()
        .number("step", step.length)
        .put("limited_by", step.limit.name()))
}
