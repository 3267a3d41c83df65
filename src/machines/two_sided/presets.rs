//! The two reference machines. All joints are on the tool chains: bed -> X -> Y -> Z -> B (-> A) -> tool.
//!
//! | | X | Y | Z | B axis, through | A axis, through | tip at home | tool axis at home | work frame at home |
//! |---|---|---|---|---|---|---|---|---|
//! | M4 side 1 | +x | +y | +z | +y, (0,0,450) | | (0,0,50) | +z | origin (600,450,0), parallel |
//! | M4 side 2 | -x | +y | -z | +y, (0,0,-430) | | (0,0,-50) | -z | origin (600,450,0), turned 180 deg about y |
//! | M5 side 1 | +x | +y | +z | +y, (0,0,510) | +x, (0,0,450) | as M4 | +z | as M4 |
//! | M5 side 2 | -x | +y | -z | +y, (0,0,-490) | +x, (0,0,-430) | as M4 | -z | as M4 |
//!
//! The tool frame of side 2 is turned 180 deg about y, so that its own tool axis is z as well. No travel is given.
//!
//! Source: specification of mirror milling, section 8.

use super::{Pair, PairError};
use crate::geometry::{Pose, Rotation, Vector};
use crate::kinematics::chain::{Carries, Chain, ChainError, Joint};
use crate::math::Real;

#[derive(Clone, Copy)]
enum Face {
    Mill,
    Support,
}

impl Face {
    fn sign<R: Real>(self) -> R {
        match self {
            Self::Mill => R::ONE,
            Self::Support => -R::ONE,
        }
    }

    fn linears<R: Real>(self) -> [Joint<R>; 3] {
        let s = self.sign::<R>();
        [Vector::X * s, Vector::Y, Vector::Z * s].map(|axis| Joint::along(Carries::Tool, axis))
    }

    fn homes<R: Real>(self) -> (Pose<R>, Pose<R>) {
        let rotation = match self {
            Self::Mill => Rotation::IDENTITY,
            Self::Support => Rotation {
                n: -Vector::X,
                s: Vector::Y,
                a: -Vector::Z,
            },
        };
        let at = |x, y, z| Pose {
            rotation,
            p: Vector::new(R::of(x), R::of(y), z),
        };
        let tip = R::of(50.0) * self.sign();
        (at(0.0, 0.0, tip), at(600.0, 450.0, R::ZERO))
    }
}

fn about<R: Real>(axis: Vector<R>, z: f64) -> Joint<R> {
    let point = Vector::new(R::ZERO, R::ZERO, R::of(z));
    Joint::about(Carries::Tool, axis, point)
}

fn four<R: Real>(face: Face, b: f64) -> Chain<4, R> {
    let [x, y, z] = face.linears();
    let (tool, work) = face.homes();
    Chain::at([x, y, z, about(Vector::Y, b)], tool, work)
}

fn five<R: Real>(face: Face, b: f64, a: f64) -> Chain<5, R> {
    let [x, y, z] = face.linears();
    let (tool, work) = face.homes();
    Chain::at(
        [x, y, z, about(Vector::Y, b), about(Vector::X, a)],
        tool,
        work,
    )
}

/// Dimensions of a dual four-axis machine that is built as M4, mill first; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourAxes<R> {
    /// Turning axes: direction (any length from 1e-6) and a point.
    pub axes: [(Vector<R>, Vector<R>); 2],
    /// Height of the tips at home.
    pub tips: [R; 2],
    /// Origin of both work frames at home.
    pub origin: Vector<R>,
    /// Travel of X1 Y1 Z1 B1 X2 Y2 Z2 B2 [mm, rad]; infinite where there is none.
    pub travel: [[R; 2]; 8],
}

impl<R: Real> Default for FourAxes<R> {
    /// M4.
    fn default() -> Self {
        let at = |z| Vector::new(R::ZERO, R::ZERO, R::of(z));
        Self {
            axes: [(Vector::Y, at(450.0)), (Vector::Y, at(-430.0))],
            tips: [R::of(50.0), R::of(-50.0)],
            origin: Vector::new(R::of(600.0), R::of(450.0), R::ZERO),
            travel: [[-R::INFINITY, R::INFINITY]; 8],
        }
    }
}

impl<R: Real> FourAxes<R> {
    /// Milling and supporting side. Fails with `NonFinite`, `BadAxis` or `BadLimit`.
    pub fn chains(&self) -> Result<[Chain<4, R>; 2], ChainError> {
        let [mill, support] = [(Face::Mill, 0), (Face::Support, 1)].map(|(face, side)| {
            let (axis, point) = self.axes[side];
            let turning = Joint::rotary(Carries::Tool, axis, point, R::ZERO)?;
            let [x, y, z] = face.linears();
            let (mut tool, mut work) = face.homes();
            (tool.p.z, work.p) = (self.tips[side], self.origin);
            let mut chain = Chain::new([x, y, z, turning]).with_homes(tool, work)?;
            for (index, range) in self.travel.iter().skip(4 * side).take(4).enumerate() {
                chain = chain.with_travel(index, *range)?;
            }
            Ok(chain)
        });
        Ok([mill?, support?])
    }
}

/// Milling side of the dual four-axis machine: X, Y, Z, B.
pub fn m4_1<R: Real>() -> Chain<4, R> {
    four(Face::Mill, 450.0)
}

/// Support side of the dual four-axis machine: X, Y, Z, B.
pub fn m4_2<R: Real>() -> Chain<4, R> {
    four(Face::Support, -430.0)
}

/// Milling side of the dual five-axis machine: X, Y, Z, B, A.
pub fn m5_1<R: Real>() -> Chain<5, R> {
    five(Face::Mill, 510.0, 450.0)
}

/// Support side of the dual five-axis machine: X, Y, Z, B, A.
pub fn m5_2<R: Real>() -> Chain<5, R> {
    five(Face::Support, -490.0, -430.0)
}

/// The dual four-axis machine.
pub fn m4<R: Real>() -> Result<Pair<4, 4, R>, PairError<4, 4, R>> {
    Pair::new(m4_1(), m4_2())
}

/// The dual five-axis machine.
pub fn m5<R: Real>() -> Result<Pair<5, 5, R>, PairError<5, 5, R>> {
    Pair::new(m5_1(), m5_2())
}
