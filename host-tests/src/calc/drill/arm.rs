//! The drill's motion and the arm that makes it: motion, joints, fk, chord.

use super::{finite, motion_of, require, variant};
use crate::calc::{Answer, Fault, Request};
use hexstep::cycles::drill_point::{Motion, Variant};
use hexstep::geometry::{Pose, Rotation};
use hexstep::joints::Joints;
use hexstep::kinematics::{Error, Kinematics};
use hexstep::machines::DrillGrinder;
use hexstep::machines::drill_grinder::StructureError;
use hexstep::math::Real;

impl From<StructureError> for Fault {
    fn from(error: StructureError) -> Self {
        let (name, field) = match error {
            StructureError::NotFinite(field) => ("NotFinite", field),
            StructureError::OutOfRange(field) => ("OutOfRange", field),
        };
        let expected = match field {
            "point_angle" => "between 0 and 180 deg",
            _ => "a length of at least 0 mm",
        };
        Fault::new(name, format!("{field} must be {expected}")).field(field)
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        match error {
            Error::NotFinite => Fault::new("NotFinite", "every number must be finite"),
            Error::OutOfReach => Fault::new("OutOfReach", "no joints reach this pose"),
        }
    }
}

pub fn motion<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    check_ranges::<R>(request)?;
    let motion = motion_of::<R>(request, variant(request))?;
    let moved = motion.at(angle(request, "mu")?);
    Ok(Answer::new()
        .vector("axis", motion.axis)
        .rotation("rotation", moved.rotation)
        .vector("displacement", moved.p)
        .number("rc", motion.radius)
        .degrees("mu0", motion.phase))
}

pub fn joints<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    check_ranges::<R>(request)?;
    let arm = arm::<R>(request)?;
    let mu = angle(request, "mu")?;
    let flank = request.integer("flank");
    require(flank == 1 || flank == 2, "flank", "1 or 2")?;
    let motion = motion_of::<R>(request, variant(request))?;
    let pose = tip(&motion, &arm, mu, request.number("standoff"));
    // Flank 2 is flank 1 rolled by half a turn about the drill.
    let Rotation { n, s, a } = pose.rotation;
    let rolled = match flank {
        2 => Rotation { n, s: -s, a: -a },
        _ => pose.rotation,
    };
    let previous = request.degrees("previous_theta1");
    let goal = Pose {
        rotation: rolled,
        p: pose.p,
    };
    let Joints([d1, d2, d3, theta1, theta2, theta3]) = arm.principal(&goal, previous)?;
    Ok(Answer::new()
        .degrees("theta1", theta1)
        .degrees("theta2", theta2)
        .degrees("theta3", theta3)
        .number("d1", d1)
        .number("d2", d2)
        .number("d3", d3)
        .vector("tip", pose.p)
        .rotation("rotation", pose.rotation))
}

pub fn fk<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    let length = |name| request.number::<R>(name);
    let turn = |name| request.degrees::<R>(name);
    let joints = Joints([
        length("d1"),
        length("d2"),
        length("d3"),
        turn("theta1"),
        turn("theta2"),
        turn("theta3"),
    ]);
    let pose = arm::<R>(request)?.forward(&joints);
    Ok(Answer::new()
        .rotation("rotation", pose.rotation)
        .vector("tip", pose.p))
}

/// Joint-linear motion between equally spaced samples of a stroke, against the exact pose.
pub fn chord<R: Real>(request: &Request) -> Result<Answer, Fault> {
    finite::<R>(request)?;
    let motion = motion_of::<R>(request, Variant::Exact)?;
    let arm = arm::<R>(request)?;
    let from = angle::<R>(request, "mu_from")?;
    let to = angle::<R>(request, "mu_to")?;
    let segments = request.integer("segments");
    let good = (1..=1_000_000).contains(&segments);
    require(good, "segments", "a whole number from 1 to 1000000")?;
    let step = (to - from) / R::of_i32(segments as i32);
    let exact = |mu| tip(&motion, &arm, mu, R::ZERO);

    let mut before = arm.inverse(&exact(from), &Joints::default())?;
    let (mut tip_error, mut orientation_error) = (R::ZERO, R::ZERO);
    for segment in 0..segments as i32 {
        let start = from + step * R::of_i32(segment);
        let after = arm.inverse(&exact(start + step), &before)?;
        for eighth in 1..8 {
            let u = R::of_i32(eighth) / R::of_i32(8);
            let reached = arm.forward(&before.zip_map(&after, |a, b| a + (b - a) * u));
            let wanted = exact(start + step * u);
            tip_error = tip_error.max((reached.p - wanted.p).norm());
            let turned = angle_between(reached.rotation, wanted.rotation);
            orientation_error = orientation_error.max(turned);
        }
        before = after;
    }
    Ok(Answer::new()
        .degrees("step", step)
        .number("tip_error", tip_error)
        .degrees("orientation_error", orientation_error))
}

fn arm<R: Real>(request: &Request) -> Result<DrillGrinder<R>, Fault> {
    Ok(DrillGrinder::new(
        request.degrees("point_angle"),
        request.number("l1"),
        request.number("l2"),
    )?)
}

/// The pose of flank 1 at `mu` and a stand-off, with the tip of the arm's home as the point of touch.
fn tip<R: Real>(motion: &Motion<R>, arm: &DrillGrinder<R>, mu: R, standoff: R) -> Pose<R> {
    let moved = motion.at(mu);
    Pose {
        rotation: moved.rotation,
        p: arm.home_tip() + (moved.p + arm.away() * standoff),
    }
}

/// The ranges of the cone and mu come before what only the published variant asks of cy.
fn check_ranges<R: Real>(request: &Request) -> Result<(), Fault> {
    motion_of::<R>(request, Variant::Exact)?;
    angle::<R>(request, "mu").map(|_| ())
}

/// An angle of the stroke, at most half a turn, in radians.
fn angle<R: Real>(request: &Request, name: &str) -> Result<R, Fault> {
    let degrees = request.number::<R>(name);
    let good = degrees.abs() <= R::of(180.0);
    require(good, name, "an angle from -180 to 180 deg")?;
    Ok(degrees.to_radians())
}

/// |A - B| of the columns is 2 sqrt 2 sin(angle/2): accurate for small angles too.
fn angle_between<R: Real>(a: Rotation<R>, b: Rotation<R>) -> R {
    let (n, s, c) = (a.n - b.n, a.s - b.s, a.a - b.a);
    let square = n.dot(n) + s.dot(s) + c.dot(c);
    let half_sine = (square / R::of(8.0)).sqrt();
    R::TWO * half_sine.min(R::ONE).asin()
}
