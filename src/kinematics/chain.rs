//! Joints -> pose of the tool in the work frame, for any serial machine: product of exponentials.
//!
//! ```text
//!                      tool chain                          g_t = (prod exp(xi_i th_i)) g_t(0)
//!          +-- joint -- joint -- ... -- tool frame, tip r_p, axis r_o
//!   bed ---+
//!          +-- joint -- ... -- work frame                  g_w = (prod exp(xi_j th_j)) g_w(0)
//!                      work chain
//!                                        g_wt = g_w^-1 g_t,   P = g_wt r_p,   O = R(g_wt) r_o
//! ```
//!
//! Joints are listed from the bed outwards; tool and work chain may be mixed in one list, only the order within each
//! chain counts. Every screw axis is given in bed coordinates with all joints at zero. A tip is carried through the
//! joints as one point, which costs a third of composing matrices.
//!
//! [`Series`] borrows its joints and takes any number of them; [`Chain`] owns `N` and speaks in `Joints<N>`.
//!
//! Source: Liu et al. (2024), equations of section 2 (see `geometry::twist`).

use crate::geometry::{Pose, Rotation, Twist, Vector};
use crate::joints::Joints;
use crate::math::Real;

/// Which of the two chains a joint belongs to: what it carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carries {
    Tool,
    Work,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Turns about its axis; its coordinate is in rad. With a pitch it is a screw.
    Rotary,
    /// Slides along its axis; its coordinate is in mm.
    Linear,
    /// Stands still: [`Chain::held`] has moved its displacement into the joints behind it.
    Held,
}

/// What is wrong with a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChainError {
    /// An axis is shorter than 1e-6.
    BadAxis,
    /// A number is not finite.
    NonFinite,
    /// A range with its lower end above the upper one.
    BadLimit,
    /// The tool axis in the tool frame is shorter than 1e-6.
    BadDirection,
    /// A home pose whose rotation is not one (1e-6).
    BadPose,
}

/// One joint: its unit twist in bed coordinates at home, and its travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint<R> {
    carries: Carries,
    motion: Motion,
    twist: Twist<R>,
    /// Foot of the perpendicular from the origin on the axis [mm]; zero for a linear joint.
    foot: Vector<R>,
    pitch: R,
    limits: Option<[R; 2]>,
}

impl<R: Real> Joint<R> {
    /// A joint that turns about `axis` (any length from 1e-6) through `point` [mm], and moves `pitch` [mm/rad] along it.
    pub fn rotary(
        carries: Carries,
        axis: Vector<R>,
        point: Vector<R>,
        pitch: R,
    ) -> Result<Self, ChainError> {
        if !(axis.is_finite() && point.is_finite() && pitch.is_finite()) {
            return Err(ChainError::NonFinite);
        }
        let twist = Twist::rotary(axis, point, pitch).ok_or(ChainError::BadAxis)?;
        Ok(Self::of_twist(carries, Motion::Rotary, twist))
    }

    /// A joint that slides along `axis` (any length from 1e-6).
    pub fn linear(carries: Carries, axis: Vector<R>) -> Result<Self, ChainError> {
        if !axis.is_finite() {
            return Err(ChainError::NonFinite);
        }
        let twist = Twist::linear(axis).ok_or(ChainError::BadAxis)?;
        Ok(Self::of_twist(carries, Motion::Linear, twist))
    }

    /// A joint that never moves: it fills a list to its length.
    pub fn held(carries: Carries) -> Self {
        Self::of_twist(carries, Motion::Held, Twist::ZERO)
    }

    /// A turning joint of a built-in machine, whose axis is a unit vector by construction.
    pub(crate) fn about(carries: Carries, axis: Vector<R>, point: Vector<R>) -> Self {
        let twist = Twist {
            v: point.cross(axis),
            w: axis,
        };
        Self::of_twist(carries, Motion::Rotary, twist)
    }

    /// A sliding joint of a built-in machine, whose axis is a unit vector by construction.
    pub(crate) fn along(carries: Carries, axis: Vector<R>) -> Self {
        let twist = Twist {
            v: axis,
            w: Vector::ZERO,
        };
        Self::of_twist(carries, Motion::Linear, twist)
    }

    fn of_twist(carries: Carries, motion: Motion, twist: Twist<R>) -> Self {
        Self {
            carries,
            motion,
            twist,
            foot: twist.w.cross(twist.v),
            pitch: twist.w.dot(twist.v),
            limits: None,
        }
    }

    /// The same joint with the travel `lo ..= hi` [mm or rad]; either end may be infinite.
    pub fn with_limits(mut self, [lo, hi]: [R; 2]) -> Result<Self, ChainError> {
        // The comparison is false for a NaN as well.
        if lo <= hi {
            self.limits = Some([lo, hi]);
            Ok(self)
        } else {
            Err(ChainError::BadLimit)
        }
    }

    pub fn carries(&self) -> Carries {
        self.carries
    }

    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// Unit twist in bed coordinates at home; zero for a held joint.
    pub fn twist(&self) -> Twist<R> {
        self.twist
    }

    /// Travel [mm or rad]; `None` is unlimited.
    pub fn limits(&self) -> Option<[R; 2]> {
        self.limits
    }

    /// +1 on the tool chain, -1 on the work chain: the sense in which the joint moves the tool against the work.
    pub fn sense(&self) -> R {
        match self.carries {
            Carries::Tool => R::ONE,
            Carries::Work => -R::ONE,
        }
    }

    /// Whether adding full turns leaves the machine where it is.
    pub fn repeats_every_turn(&self) -> bool {
        self.motion == Motion::Rotary && self.pitch.abs() <= R::of(1e-9)
    }

    /// Where the joint takes `x` [mm] at the coordinate `q`, whose sine and cosine are given.
    pub(crate) fn carry(&self, x: Vector<R>, q: R, trig: (R, R)) -> Vector<R> {
        match self.motion {
            Motion::Rotary => {
                let turned = self.turn(x - self.foot, trig) + self.foot;
                if self.pitch == R::ZERO {
                    turned
                } else {
                    turned + self.twist.w * (self.pitch * q)
                }
            }
            Motion::Linear => x + self.twist.v * q,
            Motion::Held => x,
        }
    }

    /// Direction `d` after the joint has turned (Rodrigues).
    pub(crate) fn turn(&self, d: Vector<R>, (sin, cos): (R, R)) -> Vector<R> {
        if self.motion != Motion::Rotary {
            return d;
        }
        let w = self.twist.w;
        d * cos + w.cross(d) * sin + w * (w.dot(d) * (R::ONE - cos))
    }

    /// Sine and cosine of the coordinate; those of zero unless the joint turns.
    pub(crate) fn trig(&self, q: R) -> (R, R) {
        match self.motion {
            Motion::Rotary => q.sin_cos(),
            _ => (R::ZERO, R::ONE),
        }
    }

    fn displacement(&self, q: R) -> Pose<R> {
        match self.motion {
            Motion::Held => Pose::IDENTITY,
            _ => self.twist.exp(q),
        }
    }
}

/// Any number of joints in series, borrowed. Coordinates are slices as long as the list; a missing one counts as the
/// end of the list.
#[derive(Clone, Copy, Debug)]
pub struct Series<'a, R> {
    pub joints: &'a [Joint<R>],
    /// Tool frame in the bed at home.
    pub tool_home: Pose<R>,
    /// Work frame in the bed at home.
    pub work_home: Pose<R>,
    /// Tip in the tool frame [mm].
    pub tip: Vector<R>,
    /// Tool axis in the tool frame, unit, from the tip into the body.
    pub axis: Vector<R>,
}

impl<R: Real> Series<'_, R> {
    fn frame(&self, carries: Carries, home: Pose<R>, q: &[R]) -> Pose<R> {
        self.joints
            .iter()
            .zip(q)
            .rev()
            .filter(|(joint, _)| joint.carries == carries)
            .fold(home, |pose, (joint, q)| joint.displacement(*q) * pose)
    }

    /// g_t: the tool frame in the bed.
    pub fn tool(&self, q: &[R]) -> Pose<R> {
        self.frame(Carries::Tool, self.tool_home, q)
    }

    /// g_w: the work frame in the bed.
    pub fn work(&self, q: &[R]) -> Pose<R> {
        self.frame(Carries::Work, self.work_home, q)
    }

    /// g_wt: the tool frame in the work frame.
    pub fn forward(&self, q: &[R]) -> Pose<R> {
        self.work(q).inverse() * self.tool(q)
    }

    /// Tip [mm] and unit tool axis in bed coordinates.
    pub fn tip_in_bed(&self, q: &[R]) -> (Vector<R>, Vector<R>) {
        let start = (
            self.tool_home.apply(self.tip),
            self.tool_home.rotation * self.axis,
        );
        self.joints
            .iter()
            .zip(q)
            .rev()
            .filter(|(joint, _)| joint.carries == Carries::Tool)
            .fold(start, |(p, o), (joint, q)| {
                let trig = joint.trig(*q);
                (joint.carry(p, *q, trig), joint.turn(o, trig))
            })
    }

    /// Tip [mm] and unit tool axis in the work frame.
    pub fn tip(&self, q: &[R]) -> (Vector<R>, Vector<R>) {
        let (p, o) = self.tip_in_bed(q);
        self.to_work(p, o, q)
    }

    /// A point and a direction of the bed, seen from the work frame.
    pub fn to_work(&self, p: Vector<R>, o: Vector<R>, q: &[R]) -> (Vector<R>, Vector<R>) {
        // The inverse of a product: each joint undone in turn, that next to the bed first.
        let (p, o) = self
            .joints
            .iter()
            .zip(q)
            .filter(|(joint, _)| joint.carries == Carries::Work)
            .fold((p, o), |(p, o), (joint, q)| {
                let (sin, cos) = joint.trig(*q);
                let back = (-sin, cos);
                (joint.carry(p, -*q, back), joint.turn(o, back))
            });
        let home = self.work_home.rotation.transposed();
        (home * (p - self.work_home.p), home * o)
    }

    /// The Jacobian: into `columns`, for each joint, the twist of the tool against the work, in bed coordinates, per
    /// unit of that joint [mm or rad].
    pub fn jacobian(&self, q: &[R], columns: &mut [Twist<R>]) {
        let (mut tool, mut work) = (Pose::IDENTITY, Pose::IDENTITY);
        for ((joint, q), column) in self.joints.iter().zip(q).zip(columns) {
            let before = match joint.carries {
                Carries::Tool => &mut tool,
                Carries::Work => &mut work,
            };
            *column = joint.twist.moved_by(*before) * joint.sense();
            *before = *before * joint.displacement(*q);
        }
    }
}

/// A machine of `N` joints in series: the two chains, their home poses, the tip and the tool axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<const N: usize, R = f32> {
    joints: [Joint<R>; N],
    tool_home: Pose<R>,
    work_home: Pose<R>,
    tip: Vector<R>,
    axis: Vector<R>,
}

impl<const N: usize, R: Real> Chain<N, R> {
    /// Joints from the bed outwards; tool frame at home = bed, work frame at home = bed, tip in the origin of the tool
    /// frame, tool axis z.
    pub fn new(joints: [Joint<R>; N]) -> Self {
        Self {
            joints,
            tool_home: Pose::IDENTITY,
            work_home: Pose::IDENTITY,
            tip: Vector::ZERO,
            axis: Vector::Z,
        }
    }

    /// A built-in machine, whose home poses are poses by construction.
    pub(crate) fn at(joints: [Joint<R>; N], tool_home: Pose<R>, work_home: Pose<R>) -> Self {
        Self {
            tool_home,
            work_home,
            ..Self::new(joints)
        }
    }

    /// The same chain with other tool and work frames at home (in the bed); rounded digits are made rotations again.
    pub fn with_homes(mut self, tool: Pose<R>, work: Pose<R>) -> Result<Self, ChainError> {
        for pose in [tool, work] {
            check_pose(&pose)?;
        }
        let exact = |pose: Pose<R>| Pose {
            rotation: pose.rotation.orthonormal(),
            p: pose.p,
        };
        self.tool_home = exact(tool);
        self.work_home = exact(work);
        Ok(self)
    }

    /// The same chain with another tip [mm] and tool axis (any length from 1e-6), both in the tool frame.
    pub fn with_tool(mut self, tip: Vector<R>, axis: Vector<R>) -> Result<Self, ChainError> {
        if !(tip.is_finite() && axis.is_finite()) {
            return Err(ChainError::NonFinite);
        }
        self.tip = tip;
        self.axis = axis
            .unit(R::of(crate::geometry::twist::LEAST_DIRECTION))
            .ok_or(ChainError::BadDirection)?;
        Ok(self)
    }

    /// The same chain with the travel `lo ..= hi` [mm or rad] of joint `index`; unchanged if there is no such joint.
    pub fn with_travel(mut self, index: usize, range: [R; 2]) -> Result<Self, ChainError> {
        if let Some(joint) = self.joints.get_mut(index) {
            *joint = joint.with_limits(range)?;
        }
        Ok(self)
    }

    pub fn joints(&self) -> &[Joint<R>; N] {
        &self.joints
    }

    /// The same chain, borrowed and without its length in the type.
    pub fn series(&self) -> Series<'_, R> {
        Series {
            joints: &self.joints,
            tool_home: self.tool_home,
            work_home: self.work_home,
            tip: self.tip,
            axis: self.axis,
        }
    }

    /// g_wt: the tool frame in the work frame.
    pub fn forward(&self, q: &Joints<N, R>) -> Pose<R> {
        self.series().forward(&q.0)
    }

    /// Tip [mm] and unit tool axis in the work frame.
    pub fn tip(&self, q: &Joints<N, R>) -> (Vector<R>, Vector<R>) {
        self.series().tip(&q.0)
    }

    /// The Jacobian as `N` twists of the tool against the work, in bed coordinates, each per unit of its joint.
    pub fn jacobian(&self, q: &Joints<N, R>) -> [Twist<R>; N] {
        let mut columns = [Twist::ZERO; N];
        self.series().jacobian(&q.0, &mut columns);
        columns
    }

    /// The same machine with joint `index` standing at `q` [mm or rad]: the joints behind it and the home pose of its
    /// chain are moved to where it takes them, and the joint itself no longer moves. Unchanged if there is no such joint.
    pub fn held(mut self, index: usize, q: R) -> Self {
        let Some(joint) = self.joints.get(index).copied() else {
            return self;
        };
        let moved = joint.displacement(q);
        for (i, other) in self.joints.iter_mut().enumerate() {
            if i > index && other.carries == joint.carries && other.motion != Motion::Held {
                let limits = other.limits;
                *other = Joint::of_twist(other.carries, other.motion, other.twist.moved_by(moved));
                other.limits = limits;
            }
            if i == index {
                *other = Joint::of_twist(joint.carries, Motion::Held, Twist::ZERO);
                other.limits = joint.limits;
            }
        }
        match joint.carries {
            Carries::Tool => self.tool_home = moved * self.tool_home,
            Carries::Work => self.work_home = moved * self.work_home,
        }
        self
    }
}

/// Finite, and a rotation within 1e-6 in each element: right-handed, its columns orthonormal. A pose printed with six
/// decimals passes.
pub fn check_pose<R: Real>(pose: &Pose<R>) -> Result<(), ChainError> {
    let Pose {
        rotation: Rotation { n, s, a },
        p,
    } = *pose;
    if !(n.is_finite() && s.is_finite() && a.is_finite() && p.is_finite()) {
        return Err(ChainError::NonFinite);
    }
    // Q (I + E) with a true rotation Q has the products I + 2 E, hence twice the tolerance of the elements. In f32 the
    // products themselves are only good to a few units of the last place.
    let tolerance = R::of(2e-6) + R::EPSILON * R::of(8.0);
    let off = [
        n.dot(n) - R::ONE,
        s.dot(s) - R::ONE,
        a.dot(a) - R::ONE,
        n.dot(s),
        s.dot(a),
        a.dot(n),
        n.cross(s).dot(a) - R::ONE,
    ];
    if off.iter().all(|x| x.abs() <= tolerance) {
        Ok(())
    } else {
        Err(ChainError::BadPose)
    }
}
