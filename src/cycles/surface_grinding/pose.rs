//! The wheel's pose at a contact: its z axis into the part, its x axis with the feed, the axle across.

use super::GrindingError;
use crate::geometry::nurbs::{Section, Shape};
use crate::geometry::{Pose, Rotation, Vector};
use crate::math::Real;

/// Pose of the wheel's contact point in the work frame [mm]: z = -n, x = T, y = z x x = -C.
pub fn tool_pose<R: Real>(
    shape: &Shape<R>,
    section: &Section<R>,
) -> Result<Pose<R>, GrindingError<R>> {
    wheel_pose(shape.jet.s, shape.normal, section)
}

/// The same from a place [mm] and the unit normal there.
pub fn wheel_pose<R: Real>(
    at: Vector<R>,
    normal: Vector<R>,
    section: &Section<R>,
) -> Result<Pose<R>, GrindingError<R>> {
    let pose = Pose {
        rotation: Rotation {
            n: section.feed,
            s: -section.cross,
            a: -normal,
        },
        p: at,
    };
    check(&pose)?;
    Ok(pose)
}

/// Pose of the flange that holds a tool `length` [mm] long, in the frame in which `work` is given.
pub fn flange<R: Real>(
    work: &Pose<R>,
    tool: &Pose<R>,
    length: R,
) -> Result<Pose<R>, GrindingError<R>> {
    let tip = *work * *tool;
    let pose = Pose {
        p: tip.p - tip.rotation.a * length,
        ..tip
    };
    check(&pose)?;
    Ok(pose)
}

/// Finite, and a rotation to 1e-6 (in f32, 1e-5).
fn check<R: Real>(pose: &Pose<R>) -> Result<(), GrindingError<R>> {
    let Rotation { n, s, a } = pose.rotation;
    let near = R::of(1e-6).max(R::EPSILON * R::of(100.0));
    let is = |v: Vector<R>, w: Vector<R>, product: R| (v.dot(w) - product).abs() <= near;
    let good = pose.p.is_finite()
        && is(n, n, R::ONE)
        && is(s, s, R::ONE)
        && is(n, s, R::ZERO)
        && is(n.cross(s), a, R::ONE)
        && is(a, a, R::ONE);
    if good {
        Ok(())
    } else {
        Err(GrindingError::BadPose)
    }
}
