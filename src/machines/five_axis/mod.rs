//! Five-axis machines of every kind: tool tip and tool axis into three linear and two rotary joints.
//!
//! ```text
//!   dual head            dual table            mixed            bed - linear axes - rotaries, on either side
//!
//!    X1 o X2 |            tool |               X2 |             H  what the head does to the tool
//!       tool v                 v             tool v             G  what the table does to the work
//!    ---work---          X1 o X2(work)         X1(work)         X_k(y) = q_k + Rot(n_k, th_k)(y - q_k)
//!
//!   G(w0 + Rw p) = E x + H(t0)         tip p and axis v in the work frame
//!   G_R Rw v     = H_R v1              x the linear joints, E their directions
//! ```
//!
//! Everything about the machine is written in the base frame at home: axes by any unit vector `n1`, `n2` and a point
//! (pivot) `q1`, `q2`, the tool axis `v1` from tip to spindle, the tip `t0`, the work origin `w0`. Angles are
//! right-handed about `n1`, `n2`, applied to what the axis carries. Primary is the axis nearer the bed; in a mixed
//! machine it is the table.
//!
//! Lengths in mm, angles in rad. An inverse costs two sines and cosines on top of the direction part; the linear
//! part is computed from the angles as they will be sent, so the tip is exact whatever the direction's error.
//!
//! Errors of `forward(inverse)`: f64 1e-9 mm and 1e-9 deg; f32 1e-3 mm and 1e-4 deg for coordinates and pivots to
//! 1000 mm (`host-tests/tests/five_axis.rs` measures them).
//!
//! Source: Duan, Lin, Zheng, Sun: General modelling and processing of the rotary motion of five-axis CNC, 2014;
//! the copy has lost its equations, the model is rebuilt in the specification.

mod bounds;
mod direction;
mod error;
mod presets;
mod travel;
mod window;

pub use bounds::Bounds;
pub use direction::{Branches, Kind, SING, SNAP};
pub use error::{Axis, Error};
pub use presets::{PRESETS, preset};
pub use travel::{Travel, Turned};
pub use window::{Layer, PathChoice};

use crate::geometry::{Pose, Rotation, Vector};
use crate::joints::Joints;
use crate::kinematics::follow::ClPoint;
use crate::kinematics::{self, Kinematics};
use crate::math::Real;
use direction::Direction;

/// Which side of the machine turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Both rotaries carry the tool.
    Head,
    /// Both rotaries carry the work.
    Table,
    /// The primary carries the work, the secondary the tool.
    Mixed,
}

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

/// A checked machine with everything computed that does not depend on the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiveAxis<R> {
    class: Class,
    n1: Vector<R>,
    n2: Vector<R>,
    q1: Vector<R>,
    q2: Vector<R>,
    v1: Vector<R>,
    t0: Vector<R>,
    w0: Vector<R>,
    rw: Rotation<R>,
    linear: [Vector<R>; 3],
    /// Rows of the inverse of E.
    inverse: [Vector<R>; 3],
    direction: Direction<R>,
    travel: [Travel<R>; 5],
    weights: [R; 2],
    speeds: Option<Joints<5, R>>,
    /// q2 - q1, t0 - q2, w0 - q (q of the first rotary that the work meets, 0 for a head).
    q21: Vector<R>,
    tool: Vector<R>,
    work: Vector<R>,
    /// What is left to add before E^-1: all that does not turn.
    fixed: Vector<R>,
    /// Distance of the tip from the secondary axis [mm].
    tool_radius: R,
    /// Costs closer than this [rad] are equal.
    tie: R,
}

/// One set of joints for a pose, and how it was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<R> {
    /// X, Y, Z [mm].
    pub linear: [R; 3],
    /// Primary and secondary.
    pub rotary: [Turned<R>; 2],
    pub kind: Kind,
    /// 1 or 2.
    pub number: u8,
    /// Weighted change of the rotaries from the previous ones [rad].
    pub cost: R,
    /// What the direction misses the reachable band by [rad], 1e-3 deg at most.
    pub gap: R,
    /// Conditioning number S of the direction; 0 at a pole or on the border.
    pub s: R,
    tilt: [R; 2],
    /// Lever arms that the error bound needs: of the work about its first axis, of what it meets next.
    outer: Vector<R>,
    inner: Vector<R>,
}

impl<R: Real> Solution<R> {
    /// X, Y, Z [mm], primary, secondary [rad], turns added.
    pub fn joints(&self) -> Joints<5, R> {
        let [x, y, z] = self.linear;
        let [primary, secondary] = self.rotary;
        Joints([x, y, z, primary.total(), secondary.total()])
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

    pub fn class(&self) -> Class {
        self.class
    }

    /// Reachable tilts of the tool from the axis next to the work, [lo, hi] [rad]. lo > 0: the pole itself is out of
    /// reach.
    pub fn band(&self) -> [R; 2] {
        [self.direction.lo, self.direction.hi]
    }

    /// Travel of X, Y, Z, primary, secondary [mm, rad].
    pub fn travel(&self) -> &[Travel<R>; 5] {
        &self.travel
    }

    /// Largest joint speeds [mm/s, rad/s].
    pub fn speeds(&self) -> Option<&Joints<5, R>> {
        self.speeds.as_ref()
    }

    /// Tip [mm] and unit tool axis in the work frame, of joints [mm, rad]. Fails with NonFinite.
    pub fn forward(&self, q: &Joints<5, R>) -> Result<(Vector<R>, Vector<R>), Error<R>> {
        let (p, v) = self.tool_at(q);
        match q.is_finite() && p.is_finite() && v.is_finite() {
            true => Ok((p, v)),
            false => Err(Error::NonFinite { field: "q" }),
        }
    }

    fn tool_at(&self, q: &Joints<5, R>) -> (Vector<R>, Vector<R>) {
        let Joints([x, y, z, primary, secondary]) = *q;
        let turn1 = Turn::of(self.n1, Turned::from_total(primary).angle);
        let turn2 = Turn::of(self.n2, Turned::from_total(secondary).angle);
        let [lx, ly, lz] = self.linear;
        let moved = lx * x + ly * y + lz * z;
        let (tip, axis) = match self.class {
            Class::Head => (
                moved + self.q1 + turn1.apply(self.q21 + turn2.apply(self.tool)),
                turn1.apply(turn2.apply(self.v1)),
            ),
            Class::Table => {
                let y = turn1.back(moved + self.t0 - self.q1) - self.q21;
                (self.q2 + turn2.back(y), turn2.back(turn1.back(self.v1)))
            }
            Class::Mixed => {
                let y = moved + self.q21 + turn2.apply(self.tool);
                (self.q1 + turn1.back(y), turn1.back(turn2.apply(self.v1)))
            }
        };
        let to_work = self.rw.transposed();
        (to_work * (tip - self.w0), to_work * axis)
    }

    /// The tool's pose in the work frame: its third column is the tool axis, its origin the tip. At home it is turned
    /// from the base by the least rotation that takes z to `v1`. Fails with NonFinite.
    pub fn pose(&self, q: &Joints<5, R>) -> Result<Pose<R>, Error<R>> {
        let (p, _) = self.forward(q)?;
        let rotation = self.rotation(q);
        Ok(Pose { rotation, p })
    }

    fn rotation(&self, q: &Joints<5, R>) -> Rotation<R> {
        let Joints([_, _, _, primary, secondary]) = *q;
        let turn1 = Turn::of(self.n1, Turned::from_total(primary).angle);
        let turn2 = Turn::of(self.n2, Turned::from_total(secondary).angle);
        let to_work = self.rw.transposed();
        let column = |v: Vector<R>| {
            to_work
                * match self.class {
                    Class::Head => turn1.apply(turn2.apply(v)),
                    Class::Table => turn2.back(turn1.back(v)),
                    Class::Mixed => turn1.back(turn2.apply(v)),
                }
        };
        let home = least_rotation_to(self.v1);
        Rotation {
            n: column(home.n),
            s: column(home.s),
            a: column(home.a),
        }
    }

    /// All angles for the unit tool axis `v` (work frame); travel is not looked at. At a pole the free axis stays at
    /// its previous angle. `previous` = [primary, secondary].
    pub fn branches(&self, v: Vector<R>, previous: &[Turned<R>; 2]) -> Branches<R> {
        let [primary, secondary] = previous;
        let held = match self.direction.free() {
            0 => primary.angle,
            _ => secondary.angle,
        };
        self.direction.solve(v, held)
    }

    /// Joints for the tip `p` [mm] and the unit tool axis `v` in the work frame, of least weighted rotary change from
    /// `previous` within travel. See [`direction`] for making a unit vector.
    ///
    /// Fails with Unreachable, OutOfTravel, or NonFinite when `p` is not finite or overflows on the way.
    pub fn inverse(
        &self,
        p: Vector<R>,
        v: Vector<R>,
        previous: &[Turned<R>; 2],
    ) -> Result<Solution<R>, Error<R>> {
        let branches = self.branches(v, previous);
        if branches.kind == Kind::None {
            return Err(self.unreachable(p, &branches, previous));
        }
        let chosen = self.choose(&branches, previous)?;
        self.place(p, &branches, chosen)
    }

    /// The joints of a chosen solution: linear part and travel.
    fn place(
        &self,
        p: Vector<R>,
        branches: &Branches<R>,
        chosen: Chosen<R>,
    ) -> Result<Solution<R>, Error<R>> {
        let Linear { x, outer, inner } = self.linear_part(p, &chosen.rotary);
        if !x.iter().all(|x| x.is_finite()) {
            return Err(Error::NonFinite { field: "p" });
        }
        for ((x, travel), axis) in x.iter().zip(&self.travel).zip(Axis::ALL) {
            if !travel.holds(*x) {
                return Err(Error::OutOfTravel { axis });
            }
        }
        Ok(Solution {
            linear: x,
            rotary: chosen.rotary,
            kind: branches.kind,
            number: chosen.number,
            cost: chosen.cost,
            gap: branches.gap,
            s: branches.s,
            tilt: branches.tilt,
            outer,
            inner,
        })
    }

    fn choose(
        &self,
        branches: &Branches<R>,
        previous: &[Turned<R>; 2],
    ) -> Result<Chosen<R>, Error<R>> {
        let [first, second] = branches.angles;
        let one = self.represent(branches.kind, first, previous, 1);
        if branches.kind != Kind::Two {
            return one;
        }
        match (one, self.represent(branches.kind, second, previous, 2)) {
            (Ok(one), Ok(two)) if two.cost < one.cost - self.tie => Ok(two),
            (Err(_), Ok(two)) => Ok(two),
            (one, _) => one,
        }
    }

    /// The representative of one solution nearest to `previous` within travel.
    fn represent(
        &self,
        kind: Kind,
        [primary, secondary]: [R; 2],
        previous: &[Turned<R>; 2],
        number: u8,
    ) -> Result<Chosen<R>, Error<R>> {
        let [_, _, _, travel1, travel2] = &self.travel;
        let [previous1, previous2] = *previous;
        let is_free = |axis| kind == Kind::Infinite && self.direction.free() == axis;
        let th1 = match is_free(0) {
            true => Some(travel1.clamp(previous1)),
            false => travel1.nearest(primary, previous1),
        };
        let th1 = th1.ok_or(Error::OutOfTravel {
            axis: Axis::Primary,
        })?;
        let th2 = match is_free(1) {
            true => Some(travel2.clamp(previous2)),
            false => travel2.nearest(secondary, previous2),
        };
        let th2 = th2.ok_or(Error::OutOfTravel {
            axis: Axis::Secondary,
        })?;
        Ok(Chosen {
            rotary: [th1, th2],
            number,
            cost: self.cost(previous, &[th1, th2]),
        })
    }

    /// Weighted rotary change [rad].
    pub fn cost(&self, from: &[Turned<R>; 2], to: &[Turned<R>; 2]) -> R {
        let ([w1, w2], [from1, from2], [to1, to2]) = (self.weights, from, to);
        w1 * to1.minus(*from1).abs() + w2 * to2.minus(*from2).abs()
    }

    fn linear_part(&self, p: Vector<R>, [th1, th2]: &[Turned<R>; 2]) -> Linear<R> {
        let turn1 = Turn::of(self.n1, th1.angle);
        let turn2 = Turn::of(self.n2, th2.angle);
        let outer = self.work + self.rw * p;
        let (sum, inner) = match self.class {
            Class::Head => {
                let inner = self.q21 + turn2.apply(self.tool);
                (outer - turn1.apply(inner), inner)
            }
            Class::Table => {
                let inner = self.q21 + turn2.apply(outer);
                (turn1.apply(inner), inner)
            }
            Class::Mixed => (turn1.apply(outer) - turn2.apply(self.tool), Vector::ZERO),
        };
        let sum = sum + self.fixed;
        Linear {
            x: self.inverse.map(|row| row.dot(sum)),
            outer,
            inner,
        }
    }

    fn unreachable(
        &self,
        p: Vector<R>,
        branches: &Branches<R>,
        previous: &[Turned<R>; 2],
    ) -> Error<R> {
        let [angles, _] = branches.angles;
        let rotary = match self.represent(branches.kind, angles, previous, 1) {
            Ok(chosen) => chosen.rotary,
            // Beyond travel too: the figure is for the reader, it is never moved to.
            Err(_) => angles.map(|angle| Turned { turns: 0, angle }),
        };
        let [x, y, z] = self.linear_part(p, &rotary).x;
        let [primary, secondary] = rotary;
        let nearest = Joints([x, y, z, primary.total(), secondary.total()]);
        match nearest.is_finite() {
            true => Error::Unreachable {
                gap: branches.gap,
                nearest,
            },
            false => Error::NonFinite { field: "p" },
        }
    }
}

/// Only the tip and the tool axis (the third column) of a pose are asked for: five joints leave the turn about the
/// tool open. Travel is looked at.
impl<R: Real> Kinematics<5, R> for FiveAxis<R> {
    fn forward(&self, joints: &Joints<5, R>) -> Pose<R> {
        let (p, _) = self.tool_at(joints);
        let rotation = self.rotation(joints);
        Pose { rotation, p }
    }

    fn inverse(
        &self,
        pose: &Pose<R>,
        near: &Joints<5, R>,
    ) -> Result<Joints<5, R>, kinematics::Error> {
        let at = ClPoint::new(pose.p, pose.rotation.a).ok_or(kinematics::Error::NotFinite)?;
        if !near.is_finite() {
            return Err(kinematics::Error::NotFinite);
        }
        let Joints([_, _, _, primary, secondary]) = *near;
        let near = [primary, secondary].map(Turned::from_total);
        match self.inverse(at.p(), at.v(), &near) {
            Ok(solution) => Ok(solution.joints()),
            Err(Error::NonFinite { .. }) => Err(kinematics::Error::NotFinite),
            Err(_) => Err(kinematics::Error::OutOfReach),
        }
    }
}

/// A rotary pair within travel, with the solution's number and its cost [rad].
#[derive(Clone, Copy, Debug)]
struct Chosen<R> {
    rotary: [Turned<R>; 2],
    number: u8,
    cost: R,
}

struct Linear<R> {
    x: [R; 3],
    outer: Vector<R>,
    inner: Vector<R>,
}

/// A rotation about a unit vector, applied by Rodrigues' formula: one sine and cosine for all its uses.
#[derive(Clone, Copy)]
struct Turn<R> {
    axis: Vector<R>,
    sin: R,
    cos: R,
}

impl<R: Real> Turn<R> {
    fn of(axis: Vector<R>, angle: R) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { axis, sin, cos }
    }

    fn apply(&self, y: Vector<R>) -> Vector<R> {
        let along = self.axis * (self.axis.dot(y) * (R::ONE - self.cos));
        y * self.cos + self.axis.cross(y) * self.sin + along
    }

    /// The rotation the other way.
    fn back(&self, y: Vector<R>) -> Vector<R> {
        Self {
            sin: -self.sin,
            ..*self
        }
        .apply(y)
    }
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

fn rounded<R: Real>(v: Vector<f64>) -> Vector<R> {
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

/// The rotation by the least angle that takes z to the unit vector `a`.
fn least_rotation_to<R: Real>(a: Vector<R>) -> Rotation<R> {
    if a.z < R::of(-0.999) {
        // Near the opposite any half turn will do: about x, then the rest as from -z.
        let n = Vector::new(R::ONE, R::ZERO, R::ZERO);
        let s = a.cross(n).unit(R::HALF).unwrap_or(-Vector::Y);
        return Rotation {
            n: s.cross(a),
            s,
            a,
        };
    }
    let k = R::ONE / (R::ONE + a.z);
    Rotation {
        n: Vector::new(R::ONE - a.x * a.x * k, -a.x * a.y * k, -a.x),
        s: Vector::new(-a.x * a.y * k, R::ONE - a.y * a.y * k, -a.y),
        a,
    }
}
