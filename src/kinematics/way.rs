//! The way between two ends: the tip on the straight line, the tool on the shortest turn.
//!
//! An end is a CL point (a tool tip and a tool axis) or, where the turn about the tool counts too, a whole pose.

use super::inverse::rotation_vector;
use crate::geometry::{Pose, Rotation, Vector};
use crate::math::Real;

/// A way that can be followed.
pub trait Course<R>: Copy {
    type End: Copy;

    /// `None` when the turn is half a turn: then no shortest one is meant.
    fn new(from: Self::End, to: Self::End) -> Option<Self>;

    /// Between the tips [mm].
    fn length(&self) -> R;

    /// The end at `u`, 0 ..= 1; the last one itself at 1.
    fn at(&self, u: R) -> Self::End;

    /// Tip of an end [mm].
    fn tip(end: &Self::End) -> Vector<R>;

    /// Chord of the turn between two ends: 2 sin(angle / 2).
    fn chord(from: &Self::End, to: &Self::End) -> R;
}

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
        <Self as Course<R>>::new(from, to)
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
        Course::at(self, u)
    }
}

impl<R: Real> Course<R> for Way<R> {
    type End = ClPoint<R>;

    /// `None` when the axes are opposite: then no great circle is meant.
    fn new(from: ClPoint<R>, to: ClPoint<R>) -> Option<Self> {
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

    fn length(&self) -> R {
        self.length
    }

    fn at(&self, u: R) -> ClPoint<R> {
        if u >= R::ONE {
            return self.to;
        }
        let (sin, cos) = (self.angle * u).sin_cos();
        ClPoint {
            p: self.from.p + (self.to.p - self.from.p) * u,
            v: self.from.v * cos + self.across * sin,
        }
    }

    fn tip(end: &ClPoint<R>) -> Vector<R> {
        end.p
    }

    fn chord(from: &ClPoint<R>, to: &ClPoint<R>) -> R {
        (to.v - from.v).norm()
    }
}

/// The way between two poses: the tip on the straight line, the tool turning evenly about one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseWay<R> {
    from: Pose<R>,
    to: Pose<R>,
    /// Unit axis of the turn; 0 when there is none.
    axis: Vector<R>,
    angle: R,
    length: R,
}

impl<R: Real> PoseWay<R> {
    /// `None` when the turn is half a turn: then either sense would do.
    pub fn new(from: Pose<R>, to: Pose<R>) -> Option<Self> {
        <Self as Course<R>>::new(from, to)
    }

    /// Of the turn [rad].
    pub fn angle(&self) -> R {
        self.angle
    }
}

impl<R: Real> Course<R> for PoseWay<R> {
    type End = Pose<R>;

    fn new(from: Pose<R>, to: Pose<R>) -> Option<Self> {
        let turn = rotation_vector(to.rotation * from.rotation.transposed());
        let angle = turn.norm();
        if angle > R::PI - R::of(1e-6).max(R::of(8.0) * R::EPSILON) {
            return None;
        }
        Some(Self {
            from,
            to,
            axis: turn.unit(R::EPSILON * R::EPSILON).unwrap_or(Vector::ZERO),
            angle,
            length: (to.p - from.p).norm(),
        })
    }

    fn length(&self) -> R {
        self.length
    }

    fn at(&self, u: R) -> Pose<R> {
        if u >= R::ONE {
            return self.to;
        }
        Pose {
            rotation: Rotation::about(self.axis, self.angle * u) * self.from.rotation,
            p: self.from.p + (self.to.p - self.from.p) * u,
        }
    }

    fn tip(end: &Pose<R>) -> Vector<R> {
        end.p
    }

    fn chord(from: &Pose<R>, to: &Pose<R>) -> R {
        // The columns' differences have the squares 8 sin^2(angle / 2) together.
        let (a, b) = (from.rotation, to.rotation);
        let square = |v: Vector<R>| v.dot(v);
        let sum = square(b.n - a.n) + square(b.s - a.s) + square(b.a - a.a);
        (sum * R::HALF).sqrt()
    }
}
