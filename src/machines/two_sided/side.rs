//! One side: tip and tool axis in its work frame <-> its joints, in closed form.
//!
//! Any arrangement of three linears and at most two rotaries on the two chains. The rotaries follow from the direction
//! alone ([`super::direction`]); with them known and the linears at zero the tip misses its place by
//!
//! ```text
//! b = g_w0(p) - g_t0(r_p)          and       M x = b,   M_j = k_j (rotations between bed and axis j on its chain) dir_j
//! ```
//!
//! With all linears next to the bed M is constant and its inverse is prepared. The linears are computed from the rotary
//! angles as they will be sent, so that the tip is exact whatever the direction leaves.
//!
//! Source: specification of mirror milling, section 4.

use super::direction::{AxesError, Direction, Heading, Kind, OneRotary, SNAP};
use crate::geometry::twist::LEAST_DIRECTION;
use crate::geometry::{Pose, Vector};
use crate::joints::Joints;
use crate::kinematics::chain::{Carries, Chain, Joint, Motion};
use crate::kinematics::{Error, Kinematics, principal};
use crate::math::Real;

/// Least |det M| of the three linear directions.
const LEAST_DETERMINANT: f64 = 1e-3;

/// What is wrong with a side or a target; `joint` counts from 0 in its list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SideError<const N: usize, R> {
    TooManyRotaries,
    NeedThreeLinears,
    LinearAxesDependent,
    ParallelAxes,
    ToolAlongAxis,
    /// The tip, the axis or the previous joints are not finite, or so large that the answer would not be.
    NonFinite,
    /// The wanted axis is shorter than 1e-6.
    BadDirection,
    /// The two rotaries miss the direction by `gap` [rad]; `nearest` is the pose that comes closest, its tip exact.
    Unreachable {
        gap: R,
        nearest: Joints<N, R>,
    },
    OutOfTravel {
        joint: usize,
    },
}

impl<const N: usize, R> SideError<N, R> {
    /// The name under which every interface reports it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::TooManyRotaries => "TooManyRotaries",
            Self::NeedThreeLinears => "NeedThreeLinears",
            Self::LinearAxesDependent => "LinearAxesDependent",
            Self::ParallelAxes => "ParallelAxes",
            Self::ToolAlongAxis => "ToolAlongAxis",
            Self::NonFinite => "NonFinite",
            Self::BadDirection => "BadDirection",
            Self::Unreachable { .. } => "Unreachable",
            Self::OutOfTravel { .. } => "OutOfTravel",
        }
    }

    /// What was expected, as a sentence.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::TooManyRotaries => "a side may have two axes that turn at most",
            Self::NeedThreeLinears => "a side needs three axes that slide",
            Self::LinearAxesDependent => "three sliding axes must not lie in a plane",
            Self::ParallelAxes => "two turning axes must not be parallel",
            Self::ToolAlongAxis => "the tool must not lie along the axis that turns it",
            Self::NonFinite => "every number must be finite, and within reach of its digits",
            Self::BadDirection => "a direction must be longer than 1e-6",
            Self::Unreachable { .. } => "no angles give this tool axis",
            Self::OutOfTravel { .. } => "a joint would leave its travel, see $1040 and $1050",
        }
    }
}

/// All the ways to one target, rotaries in (-pi, pi], limits not looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideSolutions<const N: usize, R> {
    pub kind: Kind,
    /// Angle of the direction that cannot be reached [rad]; with fewer than two rotaries the residual.
    pub gap: R,
    /// Conditioning of two rotaries, else `None`.
    pub s: Option<R>,
    pub first: Joints<N, R>,
    pub second: Option<Joints<N, R>>,
}

/// The chosen way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideSolution<const N: usize, R> {
    pub q: Joints<N, R>,
    pub kind: Kind,
    /// Angle between the wanted and the reached axis [rad]; zero where two rotaries reach it.
    pub residual: R,
}

impl<const N: usize, R: Real> SideSolution<N, R> {
    /// The residual is above 1e-3 deg: the pose is carried out, and the direction suffers.
    pub fn is_off_direction(&self) -> bool {
        self.residual > R::of(SNAP)
    }
}

/// A side, prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side<const N: usize, R = f32> {
    chain: Chain<N, R>,
    heading: Heading<R>,
    /// Indices and senses of the free rotaries, from the work towards the tool.
    rotaries: [Option<(usize, R)>; 2],
    /// Inverse of M by rows, where no rotary lies between the bed and a linear.
    inverse: Option<[Vector<R>; 3]>,
}

impl<const N: usize, R: Real> Side<N, R> {
    /// Prepares a chain with exactly three linears and at most two rotaries; held joints do not count.
    pub fn new(chain: Chain<N, R>) -> Result<Self, SideError<N, R>> {
        let joints = chain.joints();
        let count = |motion| joints.iter().filter(|j| j.motion() == motion).count();
        if count(Motion::Rotary) > 2 {
            return Err(SideError::TooManyRotaries);
        }
        if count(Motion::Linear) != 3 {
            return Err(SideError::NeedThreeLinears);
        }
        let mut rotaries = [None; 2];
        let on = |carries| {
            joints
                .iter()
                .enumerate()
                .filter(move |(_, j)| j.motion() == Motion::Rotary && j.carries() == carries)
                .map(|(index, j)| (index, j.sense()))
        };
        let order = on(Carries::Work).rev().chain(on(Carries::Tool));
        for (slot, found) in rotaries.iter_mut().zip(order) {
            *slot = Some(found);
        }
        let axis = |slot: Option<(usize, R)>| {
            slot.and_then(|(index, _)| joints.get(index))
                .map(|joint| joint.twist().w)
        };
        let series = chain.series();
        let u = series.tool_home.rotation * series.axis;
        let heading = match (axis(rotaries[0]), axis(rotaries[1])) {
            (Some(m1), Some(m2)) => Heading::two(m1, m2, u)?,
            (Some(w), None) => Heading::One(OneRotary::new(w, u)?),
            _ => Heading::None { u },
        };
        let mut side = Self {
            chain,
            heading,
            rotaries,
            inverse: None,
        };
        let columns = side.columns(&[(R::ZERO, R::ONE); N]);
        let inverse = invert(columns)?;
        if !side.turns_a_linear() {
            side.inverse = Some(inverse);
        }
        Ok(side)
    }

    pub fn chain(&self) -> &Chain<N, R> {
        &self.chain
    }

    /// Whether a solution of this kind stands at a pole, or of two rotaries on the border of what they can reach. One
    /// rotary has one solution everywhere else, and that is nothing to warn of.
    pub fn is_singular(&self, kind: Kind) -> bool {
        kind == Kind::Infinite || kind == Kind::One && matches!(self.heading, Heading::Two(_))
    }

    /// Tip [mm] and unit tool axis in this side's work frame.
    pub fn forward(&self, q: &Joints<N, R>) -> (Vector<R>, Vector<R>) {
        self.chain.tip(q)
    }

    /// Every way to bring the tip to `p` [mm] and the tool axis to `o` (any length from 1e-6), both in this side's work
    /// frame. `previous` is held at a pole and by held joints. Of kind none: the nearest direction.
    pub fn solutions(
        &self,
        p: Vector<R>,
        o: Vector<R>,
        previous: &Joints<N, R>,
    ) -> Result<SideSolutions<N, R>, SideError<N, R>> {
        let direction = self.direction(p, o, previous, self.held(previous))?;
        let place = |phi| -> Result<_, SideError<N, R>> {
            let mut q = self.with_rotaries(previous, phi);
            self.place(p, &mut q)?;
            Ok(q)
        };
        Ok(SideSolutions {
            kind: direction.kind,
            gap: direction.gap,
            s: direction.s,
            first: place(direction.first)?,
            second: direction.second.map(place).transpose()?,
        })
    }

    /// The way nearest to `previous`: of each solution the full turns within the travel that are nearest, then the
    /// least sum of rotary steps; a tie goes to solution 1. Checks the travel of every joint.
    pub fn inverse(
        &self,
        p: Vector<R>,
        o: Vector<R>,
        previous: &Joints<N, R>,
    ) -> Result<SideSolution<N, R>, SideError<N, R>> {
        // At a pole the axis next to the work stays where it is, or at the end of its travel nearest to that.
        let held = self.rotaries[0]
            .and_then(|(index, _)| self.chain.joints().get(index))
            .and_then(|joint| joint.limits())
            .map_or(self.held(previous), |[lo, hi]| {
                self.held(previous).clamp(lo, hi)
            });
        let direction = self.direction(p, o, previous, held)?;
        let two = matches!(self.heading, Heading::Two(_));
        if two && direction.kind == Kind::None {
            let mut nearest = self.with_rotaries(previous, direction.first);
            self.place(p, &mut nearest)?;
            return Err(SideError::Unreachable {
                gap: direction.gap,
                nearest,
            });
        }
        let first = self.within_turns(self.with_rotaries(previous, direction.first), previous);
        let second = direction
            .second
            .map(|phi| self.within_turns(self.with_rotaries(previous, phi), previous));
        let mut q = match (first, second) {
            (Ok((q1, cost1)), Some(Ok((q2, cost2)))) => {
                if cost2 < cost1 - R::of(1e-12) {
                    q2
                } else {
                    q1
                }
            }
            (Ok((q, _)), _) | (Err(_), Some(Ok((q, _)))) => q,
            (Err(error), _) => return Err(error),
        };
        self.place(p, &mut q)?;
        for (index, (joint, q)) in self.chain.joints().iter().zip(&q.0).enumerate() {
            let outside = joint
                .limits()
                .is_some_and(|[lo, hi]| !(lo <= *q && *q <= hi));
            if outside && joint.motion() == Motion::Linear {
                return Err(SideError::OutOfTravel { joint: index });
            }
        }
        Ok(SideSolution {
            q,
            kind: direction.kind,
            residual: direction.gap,
        })
    }

    /// Changes of the linears that move the tip by `shift` [mm, bed coordinates] against the work, rotaries as in `q`;
    /// zero for all other joints. Exact, because the linears act linearly.
    pub fn linear_shift(
        &self,
        shift: Vector<R>,
        q: &Joints<N, R>,
    ) -> Result<Joints<N, R>, SideError<N, R>> {
        if !(shift.is_finite() && q.is_finite()) {
            return Err(SideError::NonFinite);
        }
        let mut moved = Joints([R::ZERO; N]);
        self.set_linears(shift, &self.trig(q), &mut moved)?;
        Ok(moved)
    }

    fn direction(
        &self,
        p: Vector<R>,
        o: Vector<R>,
        previous: &Joints<N, R>,
        held: R,
    ) -> Result<Direction<R>, SideError<N, R>> {
        if !(p.is_finite() && o.is_finite() && previous.is_finite()) {
            return Err(SideError::NonFinite);
        }
        let o = o
            .unit(R::of(LEAST_DIRECTION))
            .ok_or(SideError::BadDirection)?;
        let v = self.chain.series().work_home.rotation * o;
        let sense = self.rotaries[0].map_or(R::ONE, |(_, sense)| sense);
        Ok(self.heading.solve(v, held * sense))
    }

    /// The angle of the rotary next to the work, zero without one.
    fn held(&self, previous: &Joints<N, R>) -> R {
        self.rotaries[0]
            .and_then(|(index, _)| previous.0.get(index).copied())
            .unwrap_or(R::ZERO)
    }

    /// `previous` with the rotaries at `theta_i = k_i phi_i` and the linears at zero.
    fn with_rotaries(&self, previous: &Joints<N, R>, phi: [R; 2]) -> Joints<N, R> {
        let mut q = *previous;
        for (joint, q) in self.chain.joints().iter().zip(&mut q.0) {
            if joint.motion() == Motion::Linear {
                *q = R::ZERO;
            }
        }
        for (rotary, phi) in self.rotaries.iter().zip(phi) {
            if let Some((index, sense)) = rotary
                && let Some(q) = q.0.get_mut(*index)
            {
                // -pi, which the sign makes of pi, is the same place.
                *q = principal(phi * *sense);
            }
        }
        q
    }

    /// The rotaries of `q` with the full turns within their travel nearest to `previous`, and the sum of their steps [rad].
    fn within_turns(
        &self,
        mut q: Joints<N, R>,
        previous: &Joints<N, R>,
    ) -> Result<(Joints<N, R>, R), SideError<N, R>> {
        let mut cost = R::ZERO;
        let joints = self.chain.joints();
        for (index, ((joint, q), before)) in
            joints.iter().zip(&mut q.0).zip(&previous.0).enumerate()
        {
            if joint.motion() != Motion::Rotary {
                continue;
            }
            // A screw that turns fully has moved on: the turn it is asked for is the only one.
            let turns = if joint.repeats_every_turn() {
                let wanted = ((*before - *q) / R::TAU).round();
                match joint.limits() {
                    None => wanted,
                    Some([lo, hi]) => {
                        let least = ((lo - *q) / R::TAU).ceil();
                        let most = ((hi - *q) / R::TAU).floor();
                        if least > most {
                            return Err(SideError::OutOfTravel { joint: index });
                        }
                        wanted.clamp(least, most)
                    }
                }
            } else {
                if joint
                    .limits()
                    .is_some_and(|[lo, hi]| !(lo <= *q && *q <= hi))
                {
                    return Err(SideError::OutOfTravel { joint: index });
                }
                R::ZERO
            };
            *q += turns * R::TAU;
            cost += (*q - *before).abs();
        }
        Ok((q, cost))
    }

    /// Sets the linears of `q` so that the tip stands at `p`; they must be zero on entry.
    fn place(&self, p: Vector<R>, q: &mut Joints<N, R>) -> Result<(), SideError<N, R>> {
        let series = self.chain.series();
        let trig = self.trig(q);
        let carried = |start: Vector<R>, carries| {
            series
                .joints
                .iter()
                .zip(&q.0)
                .zip(&trig)
                .rev()
                .filter(|((joint, _), _)| {
                    joint.carries() == carries && joint.motion() == Motion::Rotary
                })
                .fold(start, |x, ((joint, q), trig)| joint.carry(x, *q, *trig))
        };
        let work = carried(series.work_home.apply(p), Carries::Work);
        let tool = carried(series.tool_home.apply(series.tip), Carries::Tool);
        self.set_linears(work - tool, &trig, q)?;
        // Coordinates near the end of the number range overflow on the way.
        if q.is_finite() {
            Ok(())
        } else {
            Err(SideError::NonFinite)
        }
    }

    fn set_linears(
        &self,
        b: Vector<R>,
        trig: &[(R, R); N],
        q: &mut Joints<N, R>,
    ) -> Result<(), SideError<N, R>> {
        let rows = match self.inverse {
            Some(rows) => rows,
            None => invert(self.columns(trig))?,
        };
        let linears = self
            .chain
            .joints()
            .iter()
            .zip(&mut q.0)
            .filter(|(joint, _)| joint.motion() == Motion::Linear);
        for ((_, q), row) in linears.zip(rows) {
            *q = row.dot(b);
        }
        Ok(())
    }

    fn trig(&self, q: &Joints<N, R>) -> [(R, R); N] {
        let mut trig = [(R::ZERO, R::ONE); N];
        for ((slot, joint), q) in trig.iter_mut().zip(self.chain.joints()).zip(&q.0) {
            *slot = joint.trig(*q);
        }
        trig
    }

    /// Columns of M in the order of the list.
    fn columns(&self, trig: &[(R, R); N]) -> [Vector<R>; 3] {
        let joints = self.chain.joints();
        let mut columns = [Vector::ZERO; 3];
        let linears = joints
            .iter()
            .enumerate()
            .filter(|(_, joint)| joint.motion() == Motion::Linear);
        for (column, (index, joint)) in columns.iter_mut().zip(linears) {
            *column = joints
                .iter()
                .zip(trig)
                .take(index)
                .rev()
                .filter(|(before, _)| before.carries() == joint.carries())
                .fold(joint.twist().v * joint.sense(), |d, (before, trig)| {
                    before.turn(d, *trig)
                });
        }
        columns
    }

    /// Whether some linear lies beyond a rotary of its chain.
    fn turns_a_linear(&self) -> bool {
        let joints = self.chain.joints();
        joints.iter().enumerate().any(|(index, joint)| {
            joint.motion() == Motion::Linear
                && joints.iter().take(index).any(|before: &Joint<R>| {
                    before.motion() == Motion::Rotary && before.carries() == joint.carries()
                })
        })
    }
}

/// Rows of the inverse of the matrix with these columns.
fn invert<const N: usize, R: Real>(
    [a, b, c]: [Vector<R>; 3],
) -> Result<[Vector<R>; 3], SideError<N, R>> {
    let bc = b.cross(c);
    let determinant = a.dot(bc);
    if determinant.abs() < R::of(LEAST_DETERMINANT) {
        return Err(SideError::LinearAxesDependent);
    }
    let k = R::ONE / determinant;
    Ok([bc * k, c.cross(a) * k, a.cross(b) * k])
}

impl<const N: usize, R> From<AxesError> for SideError<N, R> {
    fn from(error: AxesError) -> Self {
        match error {
            AxesError::ParallelAxes => Self::ParallelAxes,
            AxesError::ToolAlongAxis => Self::ToolAlongAxis,
        }
    }
}

/// Poses are those of the tool frame in this side's work frame; of the orientation only the tool axis counts.
impl<const N: usize, R: Real> Kinematics<N, R> for Side<N, R> {
    fn forward(&self, joints: &Joints<N, R>) -> Pose<R> {
        self.chain.forward(joints)
    }

    fn inverse(&self, pose: &Pose<R>, near: &Joints<N, R>) -> Result<Joints<N, R>, Error> {
        let series = self.chain.series();
        let (p, o) = (pose.apply(series.tip), pose.rotation * series.axis);
        match Side::inverse(self, p, o, near) {
            Ok(solution) => Ok(solution.q),
            Err(SideError::NonFinite) => Err(Error::NotFinite),
            Err(_) => Err(Error::OutOfReach),
        }
    }
}
