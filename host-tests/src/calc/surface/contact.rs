//! `surface.hertz` and `surface.removal`: one contact.

use super::super::answer::number;
use super::super::{Answer, Fault, Request};
use super::given::{fault_of_grinding, job, process};
use hexstep::cycles::surface_grinding::{Contact, Field, Grinding, GrindingError};
use hexstep::math::Real;
use serde_json::Value;

fn contact<R: Real>(request: &Request) -> Result<(Grinding<R>, Contact<R>), Fault> {
    let grinding = Grinding::new(&process::<R>(&job::<R>(request)?)).map_err(fault_of_grinding)?;
    // Before the contact is looked at: it is refused for its own sake.
    let half_width = request.maybe_number::<R>("half_width");
    if half_width.is_some_and(|w| !(w > R::ZERO && w.is_finite())) {
        return Err(fault_of_grinding(GrindingError::<R>::BadParameter(
            Field::HalfWidth,
        )));
    }
    let k = |name: &str| request.number::<R>(name);
    let contact = grinding
        .hertz
        .at(k("k_f"), k("k_c"), k("tau"))
        .map_err(fault_of_grinding)?;
    let contact = match half_width {
        Some(half_width) => contact.within(half_width).map_err(fault_of_grinding)?,
        None => contact,
    };
    Ok((grinding, contact))
}

pub fn hertz<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (grinding, c) = contact::<R>(request)?;
    Ok(Answer::new()
        .number("a", c.a)
        .number("b", c.b)
        .degrees("psi", c.psi())
        .number("b_c", c.b_c)
        .number("a_f", c.a_f)
        .number("p0", c.p0)
        .number("approach", c.approach)
        .number("k_min", c.k_min)
        .number("k_max", c.k_max)
        .number("ratio", c.k_max / c.k_min)
        .number("e_star", grinding.hertz.e_star())
        .put(
            "small",
            &grinding
                .hertz
                .is_small(&c, request.number("k_f"), request.number("k_c")),
        ))
}

/// The stripe of the job's feed, whatever its depth mode: constant depth is reached by another feed.
pub fn removal<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (grinding, c) = contact::<R>(request)?;
    let removal = &grinding.removal;
    let stripe = removal.stripe(c.b_c);
    let places: Vec<R> = match request.is_given("y") {
        true => request.numbers("y"),
        false => vec![R::ZERO, c.b_c * R::HALF, c.b_c],
    };
    if let Some(index) = places.iter().position(|y| !y.is_finite()) {
        let fault = fault_of_grinding(GrindingError::<R>::BadParameter(Field::Y));
        return Err(fault.with("index", index));
    }
    let profile: Vec<[Value; 2]> = places
        .iter()
        .map(|y| [number(*y), number(stripe.depth(*y))])
        .collect();
    let across = grinding.hertz.across(request.number("k_c"));
    let answer = Answer::new()
        .number("b_c", c.b_c)
        .number("v_s", removal.rim_speed)
        .number("v", removal.speed)
        .number("k_mpa", removal.k_mpa)
        .number("h0", stripe.h0)
        .number("area", removal.area())
        .maybe_number("chi", stripe.conformity(across))
        .put("profile", &profile);
    let Some(depth) = request.maybe_number::<R>("target_depth") else {
        return Ok(answer
            .put("feed_for_target", &Value::Null)
            .put("passes", &Value::Null)
            .put("feed_per_pass", &Value::Null));
    };
    let feed = removal.feed_for(c.b_c, depth).map_err(fault_of_grinding)?;
    let (passes, per_pass) = removal.passes(c.b_c, depth).map_err(fault_of_grinding)?;
    Ok(answer
        .number("feed_for_target", feed)
        .put("passes", &passes)
        .number("feed_per_pass", per_pass))
}
