//! A machine as it is written down, the checks, and the constants that are computed once.

use super::direction::Direction;
use super::travel::Travel;
use super::{Class, Error, FiveAxis};
use crate::geometry::{Rotation, Vector};
use crate::joints::Joints;
use crate::math::Real;

/// A machine as it is written down; [`FiveAxis::new`] checks it. Base frame at home, mm and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Definition<R> {
    pub class: Class,
    /// Directions of the rotary axes; any length from 1e-6 up.
    pub n1: Vector<R>,
    pub n2: Vector<R>,
    /// A point on each.
    pub q1: Vector<R>,
    pub q2: Vector<R>,
    /// Tool axis, tip -> spindle, and tool tip.
    pub v1: Vector<R>,
    pub t0: Vector<R>,
    /// Work origin, and the rotation of the work frame.
    pub w0: Vector<R>,
    pub rw: Rotation<R>,
    /// Directions in which X, Y, Z move the tool relative to the work.
    pub linear: [Vector<R>; 3],
    /// X, Y, Z, primary, secondary; `None` is no limit.
    pub limits: [Option<[R; 2]>; 5],
    /// What a radian of the primary and of the secondary costs when a solution is chosen.
    pub weights: [R; 2],
    /// Largest joint speeds [mm/s, rad/s]; `None` is no limit.
    pub speeds: Option<[R; 5]>,
}

impl<R: Real> FiveAxis<R> {
    /// Checks a definition and computes its constants, in f64, in the order NonFinite, BadDirection, BadAxis, ParallelAxes, ToolAlongAxis,
    /// LinearAxesDependent, BadLimit.
    pub fn new(machine: &Definition<R>) -> Result<Self, Error<R>> {
        check_finite(machine)?;
        let class = machine.class;
        let [q1, q2, t0, w0] = [machine.q1, machine.q2, machine.t0, machine.w0].map(exact);
        let unit = |v, field| direction(exact(v), field);
        let axis = |v, field| unit(v, field).map_err(|_| Error::BadAxis { field });
        let v1 = unit(machine.v1, "v1").map_err(|_| Error::BadDirection { field: "v1" })?;
        let n1 = axis(machine.n1, "n1")?;
        let n2 = axis(machine.n2, "n2")?;
        let rw = proper(machine.rw).ok_or(Error::BadAxis { field: "rw" })?;
        let [lx, ly, lz] = machine.linear;
        let linear @ [lx, ly, lz] = [
            axis(lx, "linear")?,
            axis(ly, "linear")?,
            axis(lz, "linear")?,
        ];
        let direction = Direction::new(class, n1, n2, v1, rw.transposed())?;
        let det = lx.dot(ly.cross(lz));
        if Real::abs(det) < 1e-3 {
            return Err(Error::LinearAxesDependent);
        }
        let inverse = [ly.cross(lz), lz.cross(lx), lx.cross(ly)].map(|row| row * (1.0 / det));

        let [x, y, z, primary, secondary] = machine.limits;
        let travel = [
            Travel::new(x, "limits")?,
            Travel::new(y, "limits")?,
            Travel::new(z, "limits")?,
            Travel::new(primary, "limits")?,
            Travel::new(secondary, "limits")?,
        ];
        if machine.weights.iter().any(|w| *w <= R::ZERO) {
            return Err(Error::BadLimit { field: "weights" });
        }
        if machine.speeds.iter().flatten().any(|s| *s <= R::ZERO) {
            return Err(Error::BadLimit { field: "speeds" });
        }

        let (work, fixed) = match class {
            Class::Head => (w0 - q1, Vector::ZERO),
            Class::Table => (w0 - q2, q1 - t0),
            Class::Mixed => (w0 - q1, q1 - q2),
        };
        let tool = t0 - q2;
        Ok(Self {
            class,
            n1: rounded(n1),
            n2: rounded(n2),
            q1: machine.q1,
            q2: machine.q2,
            v1: rounded(v1),
            t0: machine.t0,
            w0: machine.w0,
            rw: Rotation {
                n: rounded(rw.n),
                s: rounded(rw.s),
                a: rounded(rw.a),
            },
            linear: linear.map(rounded),
            inverse: inverse.map(rounded),
            direction,
            travel,
            weights: machine.weights,
            speeds: machine.speeds.map(Joints),
            q21: rounded(q2 - q1),
            tool: rounded(tool),
            work: rounded(work),
            fixed: rounded(fixed),
            tool_radius: R::of(n2.cross(tool).norm()),
            tie: R::of(1e-12).max(R::of(8.0) * R::EPSILON),
        })
    }
}

/// `v` as a unit vector, whatever its length from 1e-6 up; `field` names it in the error.
pub fn direction<R: Real>(v: Vector<R>, field: &'static str) -> Result<Vector<R>, Error<R>> {
    if !v.is_finite() {
        return Err(Error::NonFinite { field });
    }
    if let Some(unit) = v.unit(R::of(1e-6)) {
        return Ok(unit);
    }
    // Too short, or so long that its square overflows.
    let largest = v.x.abs().max(v.y.abs()).max(v.z.abs());
    let scaled = Vector::new(v.x / largest, v.y / largest, v.z / largest);
    (largest > R::ONE)
        .then(|| scaled.unit(R::HALF))
        .flatten()
        .ok_or(Error::BadDirection { field })
}

fn check_finite<R: Real>(m: &Definition<R>) -> Result<(), Error<R>> {
    let vectors = [
        (m.n1, "n1"),
        (m.n2, "n2"),
        (m.q1, "q1"),
        (m.q2, "q2"),
        (m.v1, "v1"),
        (m.t0, "t0"),
        (m.w0, "w0"),
        (m.rw.n, "rw"),
        (m.rw.s, "rw"),
        (m.rw.a, "rw"),
    ];
    let linear = m.linear.iter().map(|l| (*l, "linear"));
    if let Some((_, field)) = vectors.into_iter().chain(linear).find(|v| !v.0.is_finite()) {
        return Err(Error::NonFinite { field });
    }
    let lists = [
        (
            m.limits.iter().flatten().flatten().all(|x| x.is_finite()),
            "limits",
        ),
        (m.weights.iter().all(|x| x.is_finite()), "weights"),
        (m.speeds.iter().flatten().all(|x| x.is_finite()), "speeds"),
    ];
    match lists.iter().find(|list| !list.0) {
        Some((_, field)) => Err(Error::NonFinite { field }),
        None => Ok(()),
    }
}

fn exact<R: Real>(v: Vector<R>) -> Vector<f64> {
    Vector::from_array(v.to_array().map(R::to_f64))
}

pub(super) fn rounded<R: Real>(v: Vector<f64>) -> Vector<R> {
    Vector::from_array(v.to_array().map(R::of))
}

/// `rotation` with its last digits put right; `None` unless it is one within 1e-4.
fn proper<R: Real>(rotation: Rotation<R>) -> Option<Rotation<f64>> {
    let least = 0.5;
    let n = exact(rotation.n).unit(least)?;
    let s = exact(rotation.s);
    let s = (s - n * n.dot(s)).unit(least)?;
    let a = n.cross(s);
    let is_near = |x: Vector<f64>, y: Vector<R>| (x - exact(y)).norm() <= 1e-4;
    (is_near(n, rotation.n) && is_near(s, rotation.s) && is_near(a, rotation.a))
        .then_some(Rotation { n, s, a })
}
