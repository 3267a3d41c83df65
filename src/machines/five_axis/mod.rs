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
//! Lengths in mm, angles in rad. The linear part is computed from the angles as they will be sent, so the tip is exact
//! whatever the direction's error.
//!
//! Errors against a forward map in f64, largest of 100 000 random poses on 100 random machines and all presets, pivots
//! and coordinates to 1000 mm (measured again by `host-tests/tests/five_axis.rs`):
//!
//! | | f64 | f32 |
//! |---|---|---|
//! | tip | < 1e-9 mm | 6.8e-4 mm; 1.3e-3 mm where linear joints run to 5 m |
//! | direction | < 1e-9 deg | 8.7e-5 deg; 2.8e-5 deg near the pole of the presets |
//! | joint angle | | 5.1e-5 deg / S |
//!
//! Cost on a Cortex-M4F in f32: 600 instructions for the direction, both solutions; 1800 for a whole inverse with choice,
//! linear part and travel (`five_axis_*_instructions` of `cargo xtask bench`); 430 for the bounds.
//!
//! ```
//! use hexstep::geometry::Vector;
//! use hexstep::machines::five_axis::{FiveAxis, Turned, direction, preset};
//!
//! let machine = FiveAxis::new(&preset::<f64>("table_ac").unwrap())?;
//! let axis = direction(Vector::new(0.3, 0.4, 0.8), "v")?;
//! let before = [0.2, 0.5].map(Turned::from_total);
//! let solution = machine.inverse(Vector::new(10.0, 20.0, 30.0), axis, &before)?;
//! let (tip, _) = machine.forward(&solution.joints())?;
//! assert!((tip - Vector::new(10.0, 20.0, 30.0)).norm() < 1e-9);
//! # Ok::<(), hexstep::machines::five_axis::Error<f64>>(())
//! ```
//!
//! Source: Duan, Lin, Zheng, Sun: General modelling and processing of the rotary motion of five-axis CNC, 2014;
//! the copy has lost its equations, the model is rebuilt in the specification.

mod bounds;
mod definition;
mod direction;
mod error;
mod presets;
mod travel;
mod turn;
mod window;

pub use bounds::Bounds;
pub use definition::{Definition, direction};
pub use direction::{Branches, Kind, SING, SNAP};
pub use error::{Axis, Error};
pub use presets::{PRESETS, preset};
pub use travel::{Travel, Turned};
pub use window::{Layer, PathChoice};

use crate::geometry::{Pose, Rotation, Vector};
use crate::joints::Joints;
use crate::kinematics::{self, ClPoint, Kinematics};
use crate::math::Real;
use direction::Direction;
use turn::{Turn, least_rotation_to};

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

impl<R: Real> FiveAxis<R> {
    pub fn class(&self) -> Class {
        self.class
    }

    /// Reachable tilts of the tool from the axis next to the work, [lo, hi] [rad]. lo > 0: the pole itself is out of
    /// reach.
    pub fn band(&self) -> [R; 2] {
        self.direction.band()
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
