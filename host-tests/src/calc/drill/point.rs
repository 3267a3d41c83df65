//! The drill's point: solve, forward, suggest_phi, range, plan.

use super::{cone, drill, finite, require};
use crate::calc::{Answer, Fault, Request};
use hexstep::cycles::drill_point::{Flank, Ground, Passes, Stroke};
use hexstep::math::Real;

pub fn solve<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    let (drill, phi, heel_angle) = (
        drill::<R>(request),
        request.degrees("phi"),
        request.degrees::<R>("heel_angle"),
    );
    let solution = drill.solve(phi)?;
    heel_in_range(heel_angle)?;
    let flank = Flank::of(drill.diameter, drill.web, &solution.cone)?;
    let half_chisel = solution.chisel_end.hypot(drill.web * R::HALF);
    let mid = drill.diameter * R::of(0.25);
    let clearance_mid = if half_chisel < mid {
        drill.clearance_at(solution.m, mid)
    } else {
        None
    };
    let (rc, mu0) = solution.cone.circle();
    let cone = solution.cone;
    Ok(Answer::new()
        .number::<R>("phi", request.number("phi"))
        .degrees("theta", cone.theta)
        .degrees("omega", cone.omega)
        .number("cx", cone.tip.x)
        .number("cy", cone.tip.y)
        .number("cz", cone.tip.z)
        .number("x", solution.x)
        .number("m", solution.m)
        .degrees("phi_min", solution.phi_min)
        .number("chisel_end", solution.chisel_end)
        .number("chisel_length", half_chisel * R::TWO)
        .maybe_degrees("clearance_mid", clearance_mid)
        .maybe_degrees(
            "heel_clearance",
            flank.heel(heel_angle).map(|h| h.clearance),
        )
        .number("rc", rc)
        .degrees("mu0", mu0))
}

pub fn forward<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (flank, ground, heel_angle) = ground::<R>(request)?;
    let heel = flank.heel(heel_angle);
    Ok(Answer::new()
        .degrees("point_angle", ground.point_angle)
        .degrees("point_angle_chord", ground.point_angle_chord)
        .degrees("chisel_angle", ground.chisel_angle)
        .degrees("clearance", ground.clearance)
        .maybe_degrees("clearance_mid", ground.clearance_mid)
        .number("cz", ground.cz)
        .number("m", ground.m)
        .number("y", ground.y)
        .number("chisel_end", ground.chisel_end)
        .number("chisel_end_height", ground.chisel_end_height)
        .number("chisel_length", ground.chisel_length)
        .maybe_degrees("heel_clearance", heel.map(|h| h.clearance))
        .maybe_number("heel_drop", heel.map(|h| h.drop)))
}

pub fn suggest_phi<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    let suggestion = drill::<R>(request)
        .suggest_phi(request.degrees("heel_angle"), request.degrees("target"))?;
    Ok(Answer::new()
        .put("phi", &suggestion.degrees)
        .degrees("heel_clearance", suggestion.heel_clearance))
}

pub fn range<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (flank, ground, heel_angle) = ground::<R>(request)?;
    let over = request.degrees("over");
    let stroke = Stroke::new(&cone(request), &flank, ground.chisel_end, heel_angle, over)?;
    let warnings: Vec<_> = stroke.warning().iter().map(|w| w.name()).collect();
    Ok(Answer::new()
        .degrees("lip_inner", stroke.lip_inner)
        .degrees("tip", stroke.tip)
        .degrees("chisel_far", stroke.chisel_far)
        .maybe_degrees("heel", stroke.heel)
        .degrees("mu_start", stroke.start)
        .degrees("mu_end", stroke.end)
        .put("warnings", &warnings))
}

pub fn plan<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    // A count beyond u32 is beyond the range as well.
    let count = |name: &str| u32::try_from(request.integer(name)).unwrap_or(u32::MAX);
    let passes = Passes::<R> {
        stock: request.number("stock"),
        rough_depth: request.number("rough_depth"),
        finish_depth: request.number("finish_depth"),
        finish_passes: count("finish_passes"),
        spark_out: count("spark_out"),
    };
    let plan = passes.plan(request.degrees("point_angle"))?;
    Ok(Answer::new()
        .number("infeed", plan.infeed)
        .put("rough_passes", &plan.rough_passes)
        .number("rough_depth", plan.rough_depth)
        .put("finish_passes", &plan.finish_passes)
        .number("finish_depth", plan.finish_depth)
        .put("spark_out", &plan.spark_out)
        .numbers("standoffs", plan.standoffs()))
}

/// The flank of a request, measured, and the heel angle.
fn ground<R: Real>(request: &Request) -> Result<(Flank<R>, Ground<R>, R), Fault> {
    finite::<R>(request)?;
    let heel_angle = request.degrees("heel_angle");
    let flank = Flank::of(
        request.number("diameter"),
        request.number("web"),
        &cone(request),
    )?;
    heel_in_range(heel_angle)?;
    let ground = flank.ground()?;
    Ok((flank, ground, heel_angle))
}

fn heel_in_range<R: Real>(heel_angle: R) -> Result<(), Fault> {
    let good = heel_angle >= R::ZERO && heel_angle <= R::PI;
    require(good, "heel_angle", "an angle from 0 to 180 deg")
}
