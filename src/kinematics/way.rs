//! CL points (a tool tip and a tool axis each) and the way between two of them.

use crate::geometry::Vector;
use crate::math::Real;

/// A tool tip [mm] and a unit tool axis, tip -> spindle, in the work frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClPoint<R> {
    p: Vector<R>,
    v: Vector<R>,
}

impl<R: Real> ClPoint<R> {
    /// `v` of any length from 1e-6 up. `None` when a number is not finite or `v` is shorter.
    pub fn new(p: Vector<R>, v: Vector<R>) -> Option<Self> {
        let v = v.unit(R::of(1e-6))?;
        p.is_finite().then_some(Self { p, v })
    }

    pub fn p(&self) -> Vector<R> {
        self.p
    }

    pub fn v(&self) -> Vector<R> {
        self.v
    }
}

/// The way between two CL points: the tip on the straight line, the tool axis on the great circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way<R> {
    from: ClPoint<R>,
    to: ClPoint<R>,
    /// In the plane of both axes, at right angles to `from.v`; 0 when they are the same.
    across: Vector<R>,
    angle: R,
    length: R,
}

impl<R: Real> Way<R> {
    /// `None` when the axes are opposite: then no great circle is meant.
    pub fn new(from: ClPoint<R>, to: ClPoint<R>) -> Option<Self> {
        if (from.v + to.v).norm() < R::of(1e-6) {
            return None;
        }
        let normal = from.v.cross(to.v);
        let across = normal.cross(from.v).unit(R::EPSILON * R::EPSILON);
        Some(Self {
            from,
            to,
            across: across.unwrap_or(Vector::ZERO),
            angle: normal.norm().atan2(from.v.dot(to.v)),
            length: (to.p - from.p).norm(),
        })
    }

    /// Between the tips [mm].
    pub fn length(&self) -> R {
        self.length
    }

    /// Between the tool axes [rad].
    pub fn angle(&self) -> R {
        self.angle
    }

    /// The CL point at `u`, 0 ..= 1; the end itself at 1.
    pub fn at(&self, u: R) -> ClPoint<R> {
        if u >= R::ONE {
            return self.to;
        }
        let (sin, cos) = (self.angle * u).sin_cos();
        ClPoint {
            p: self.from.p + (self.to.p - self.from.p) * u,
            v: self.from.v * cos + self.across * sin,
        }
    }
}
