//! Pose -> joints for a machine without a closed form: damped Newton on the Jacobian of screws.
//!
//! ```text
//! e  = [ tip wanted - tip ; turn wanted ]                 in bed coordinates, lengths divided by L = 100 mm
//! J  = one column a joint: [ velocity of the tip ; w ]    linear joints scaled by L as well
//! dq = J^T (J J^T + mu I)^-1 e                            a 6 x 6 system, however many joints
//! ```
//!
//! A step that lessens the error as the linear model promised divides `mu` by up to twenty, so that close to the answer
//! the step is Newton's; a trial that does not lessen the error is not taken, and raises `mu` until the step is short
//! and safe. A redundant machine gets the step of least norm; one with too few joints comes as near as it can, and the
//! answer counts only when both tolerances hold. With five conditions (tip and axis) the turn about the tool axis is
//! left free: its row is replaced by the identity.
//!
//! The method is Levenberg and Marquardt's with Nielsen's rule for the damping; the Jacobian is that of `kinematics::chain`.

use super::chain::{Chain, ChainError, Series, check_pose};
use super::{Error, Kinematics};
use crate::geometry::{Pose, Rotation, Twist, Vector};
use crate::joints::Joints;
use crate::math::Real;

/// Length that stands against one radian [mm]: about the arm of the machines at hand. It shapes the damping and the
/// choice among redundant joints, not the answer.
const LENGTH: f64 = 100.0;

/// What the tool shall reach, in the work frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target<R> {
    /// Six conditions: the tool frame.
    Pose(Pose<R>),
    /// Five conditions: the tip [mm] and the tool axis (any length from 1e-6).
    TipAxis { p: Vector<R>, o: Vector<R> },
}

/// When the search ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<R> {
    /// Largest distance of the tip [mm].
    pub tip: R,
    /// Largest angle of the orientation (six conditions) or the axis (five) [rad].
    pub angle: R,
    /// Largest number of trial steps.
    pub iterations: u32,
}

impl<R: Real> Default for Tolerance<R> {
    /// 1e-9 mm and 1e-9 deg in f64. In f32 1e-3 mm and 1e-4 deg, what coordinates of 1000 mm allow.
    fn default() -> Self {
        let fine = R::EPSILON.to_f64() < 1e-12;
        let (tip, degrees) = if fine { (1e-9, 1e-9) } else { (1e-3, 1e-4) };
        Self {
            tip: R::of(tip),
            angle: R::of(degrees).to_radians(),
            iterations: 50,
        }
    }
}

/// Where a search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<R> {
    /// Trial steps taken.
    pub iterations: u32,
    /// Distance of the tip from the wanted one [mm].
    pub tip_error: R,
    /// Angle of the orientation, or of the axis, from the wanted one [rad].
    pub direction_error: R,
}

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Failure<R> {
    /// The tolerances were not met. The joints then hold the nearest approach, and the report says how near it is.
    NoConvergence(Report<R>),
    /// The answer lies outside the travel of this joint.
    OutOfTravel { joint: usize },
    /// The target, the start or a tolerance is not a number, or a tolerance is negative.
    NonFinite,
    /// The wanted axis is shorter than 1e-6.
    BadDirection,
    /// The wanted pose holds no rotation.
    BadPose,
}

/// Joints and the report that belongs to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<const N: usize, R> {
    pub q: Joints<N, R>,
    pub report: Report<R>,
}

/// Joints that were refused, with the reason: for [`Failure::NoConvergence`] the nearest approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused<const N: usize, R> {
    pub nearest: Joints<N, R>,
    pub why: Failure<R>,
}

impl<const N: usize, R: Real> Chain<N, R> {
    /// Joints that bring the tool to `target`, found from `near` (the joints before): the solution that lies closest on
    /// the way, within the travel. Never an answer outside `tolerance`.
    pub fn inverse(
        &self,
        target: &Target<R>,
        near: &Joints<N, R>,
        tolerance: &Tolerance<R>,
    ) -> Result<Answer<N, R>, Refused<N, R>> {
        let mut q = *near;
        let (mut columns, mut trial) = ([Twist::ZERO; N], [R::ZERO; N]);
        match solve(
            &self.series(),
            target,
            &mut q.0,
            &mut columns,
            &mut trial,
            tolerance,
        ) {
            Ok(report) => Ok(Answer { q, report }),
            Err(why) => Err(Refused { nearest: q, why }),
        }
    }
}

/// Six conditions, at the default tolerance.
impl<const N: usize, R: Real> Kinematics<N, R> for Chain<N, R> {
    fn forward(&self, joints: &Joints<N, R>) -> Pose<R> {
        Chain::forward(self, joints)
    }

    fn inverse(&self, pose: &Pose<R>, near: &Joints<N, R>) -> Result<Joints<N, R>, Error> {
        match Chain::inverse(self, &Target::Pose(*pose), near, &Tolerance::default()) {
            Ok(answer) => Ok(answer.q),
            Err(refused) if refused.why == Failure::NonFinite => Err(Error::NotFinite),
            Err(_) => Err(Error::OutOfReach),
        }
    }
}

/// The search on borrowed storage, for any number of joints: `q` holds the start and then the answer; `columns` and
/// `trial` are work space as long as `q`.
pub fn solve<R: Real>(
    series: &Series<'_, R>,
    target: &Target<R>,
    q: &mut [R],
    columns: &mut [Twist<R>],
    trial: &mut [R],
    tolerance: &Tolerance<R>,
) -> Result<Report<R>, Failure<R>> {
    let wanted = Wanted::new(series, target)?;
    let bounds = [tolerance.tip, tolerance.angle];
    if !q.iter().all(|x| x.is_finite()) || !bounds.iter().all(|t| *t >= R::ZERO) {
        return Err(Failure::NonFinite);
    }
    let length = R::of(LENGTH);
    // Nearly Newton's step from the start; what fails raises it, ever faster.
    let mut damping = R::of(1e-3);
    let mut raise = R::TWO;
    let mut state = wanted.error(series, q);
    series.jacobian(q, columns);
    let mut iterations = 0;
    while !state.within(tolerance) && iterations < tolerance.iterations {
        iterations += 1;
        let step = Step::new(
            columns.iter().take(q.len()),
            &state,
            damping,
            wanted.is_axis(),
        );
        // No joint turns by more than a radian (or slides by more than its share of it) in one step.
        let largest = columns
            .iter()
            .zip(q.iter())
            .filter(|(column, _)| column.w != Vector::ZERO)
            .fold(R::ZERO, |most, (column, _)| {
                most.max(step.along(column, &state).abs())
            });
        let shorten = R::ONE / largest.max(R::ONE);
        for ((to, from), column) in trial.iter_mut().zip(q.iter()).zip(columns.iter()) {
            let mut dq = step.along(column, &state);
            if column.w == Vector::ZERO {
                dq *= length;
            }
            *to = *from + dq * shorten;
        }
        let after = wanted.error(series, trial);
        let before = state.cost();
        if after.cost() < before {
            // Nielsen: how much of the decrease that the linear model promised came true.
            let came_true =
                (before - after.cost()) / (before - step.left_over).max(R::EPSILON * before);
            let bend = R::TWO * came_true.min(R::ONE) - R::ONE;
            damping *= (R::ONE - bend * bend * bend).max(R::of(0.05));
            raise = R::TWO;
            for (to, from) in q.iter_mut().zip(trial.iter()) {
                *to = *from;
            }
            state = after;
            series.jacobian(q, columns);
        } else {
            damping = damping.max(R::EPSILON) * raise;
            raise *= R::TWO;
        }
    }
    let report = Report {
        iterations,
        tip_error: state.tip_error(),
        direction_error: state.turn.norm(),
    };
    if !state.within(tolerance) {
        return Err(Failure::NoConvergence(report));
    }
    within_travel(series, q)?;
    Ok(report)
}

/// Brings joints that repeat into their travel by full turns, the fewest that do; names the first that stays outside.
fn within_travel<R: Real>(series: &Series<'_, R>, q: &mut [R]) -> Result<(), Failure<R>> {
    for (index, (joint, q)) in series.joints.iter().zip(q).enumerate() {
        let Some([lo, hi]) = joint.limits() else {
            continue;
        };
        if joint.repeats_every_turn() {
            if *q > hi {
                *q -= R::TAU * ((*q - hi) / R::TAU).ceil();
            } else if *q < lo {
                *q += R::TAU * ((lo - *q) / R::TAU).ceil();
            }
        }
        if !(lo <= *q && *q <= hi) {
            return Err(Failure::OutOfTravel { joint: index });
        }
    }
    Ok(())
}

/// The checked target: tip and either the whole rotation or the axis, in the work frame.
enum Wanted<R> {
    Pose { p: Vector<R>, rotation: Rotation<R> },
    Axis { p: Vector<R>, o: Vector<R> },
}

/// How far the tool is from its target, in bed coordinates.
struct State<R> {
    /// Tip now [mm].
    tip: Vector<R>,
    /// From the tip to where it shall be [mm].
    shift: Vector<R>,
    /// The turn that is missing: axis times angle [rad].
    turn: Vector<R>,
    /// Tool axis now.
    axis: Vector<R>,
}

impl<R: Real> State<R> {
    fn tip_error(&self) -> R {
        self.shift.norm()
    }

    fn cost(&self) -> R {
        let shift = self.shift * R::of(1.0 / LENGTH);
        shift.dot(shift) + self.turn.dot(self.turn)
    }

    fn within(&self, tolerance: &Tolerance<R>) -> bool {
        self.tip_error() <= tolerance.tip && self.turn.norm() <= tolerance.angle
    }
}

impl<R: Real> Wanted<R> {
    fn new(series: &Series<'_, R>, target: &Target<R>) -> Result<Self, Failure<R>> {
        match target {
            Target::Pose(pose) => {
                check_pose(pose).map_err(|error| match error {
                    ChainError::NonFinite => Failure::NonFinite,
                    _ => Failure::BadPose,
                })?;
                Ok(Self::Pose {
                    p: pose.apply(series.tip),
                    rotation: pose.rotation.orthonormal(),
                })
            }
            Target::TipAxis { p, o } => {
                if !(p.is_finite() && o.is_finite()) {
                    return Err(Failure::NonFinite);
                }
                let o = o
                    .unit(R::of(crate::geometry::twist::LEAST_DIRECTION))
                    .ok_or(Failure::BadDirection)?;
                Ok(Self::Axis { p: *p, o })
            }
        }
    }

    fn is_axis(&self) -> bool {
        matches!(self, Self::Axis { .. })
    }

    fn error(&self, series: &Series<'_, R>, q: &[R]) -> State<R> {
        let (tool, work) = (series.tool(q), series.work(q));
        let tip = tool.apply(series.tip);
        let axis = tool.rotation * series.axis;
        match self {
            Self::Pose { p, rotation } => State {
                tip,
                shift: work.apply(*p) - tip,
                turn: rotation_vector(work.rotation * *rotation * tool.rotation.transposed()),
                axis,
            },
            Self::Axis { p, o } => State {
                tip,
                shift: work.apply(*p) - tip,
                turn: turn_between(axis, work.rotation * *o),
                axis,
            },
        }
    }
}

/// `(J J^T + mu I)^-1 e` of one step; the joints' share is read off with [`Step::along`].
struct Step<R> {
    shift: Vector<R>,
    turn: Vector<R>,
    /// Cost that the linear model leaves after the full step.
    left_over: R,
    free_axis: bool,
}

impl<R: Real> Step<R> {
    fn new<'a>(
        columns: impl Iterator<Item = &'a Twist<R>>,
        state: &State<R>,
        mu: R,
        free_axis: bool,
    ) -> Self {
        let mut a = [[R::ZERO; 6]; 6];
        for column in columns {
            let c = scaled(column, state, free_axis);
            for (row, ci) in a.iter_mut().zip(c) {
                for (cell, cj) in row.iter_mut().zip(c) {
                    *cell += ci * cj;
                }
            }
        }
        let trace = (0..6).fold(R::ZERO, |sum, i| sum + a[i][i]);
        // The least damping keeps a machine with fewer joints than conditions solvable.
        let mu = mu + trace * R::EPSILON * R::of(64.0);
        for i in 0..6 {
            a[i][i] += mu;
        }
        if free_axis {
            // No column and no error has a part along the axis: the identity there decouples that row.
            let o = state.axis.to_array();
            for i in 0..3 {
                for j in 0..3 {
                    a[3 + i][3 + j] += o[i] * o[j];
                }
            }
        }
        let shift = state.shift * R::of(1.0 / LENGTH);
        let e = [
            shift.x,
            shift.y,
            shift.z,
            state.turn.x,
            state.turn.y,
            state.turn.z,
        ];
        let y = cholesky_solve(a, e);
        Self {
            shift: Vector::new(y[0], y[1], y[2]),
            turn: Vector::new(y[3], y[4], y[5]),
            left_over: y.iter().fold(R::ZERO, |sum, y| sum + (mu * *y).squared()),
            free_axis,
        }
    }

    /// Share of a joint: its column times the solution; rad, or units of [`LENGTH`] for a linear joint.
    fn along(&self, column: &Twist<R>, state: &State<R>) -> R {
        let c = scaled(column, state, self.free_axis);
        self.shift.dot(Vector::new(c[0], c[1], c[2])) + self.turn.dot(Vector::new(c[3], c[4], c[5]))
    }
}

/// Column of a joint about the tip, lengths in units of [`LENGTH`].
fn scaled<R: Real>(column: &Twist<R>, state: &State<R>, free_axis: bool) -> [R; 6] {
    let v = column.velocity_at(state.tip);
    let v = if column.w == Vector::ZERO {
        v
    } else {
        v * R::of(1.0 / LENGTH)
    };
    let w = if free_axis {
        column.w - state.axis * column.w.dot(state.axis)
    } else {
        column.w
    };
    [v.x, v.y, v.z, w.x, w.y, w.z]
}

/// Solves the symmetric positive definite system `a x = b`; a pivot lost to rounding is replaced by the smallest that counts.
fn cholesky_solve<R: Real>(mut a: [[R; 6]; 6], mut b: [R; 6]) -> [R; 6] {
    let least = (0..6).fold(R::ZERO, |most, i| most.max(a[i][i])) * R::EPSILON;
    let least = least.max(R::of(1e-30));
    for i in 0..6 {
        for j in 0..=i {
            let mut sum = a[i][j];
            for k in 0..j {
                sum -= a[i][k] * a[j][k];
            }
            a[i][j] = if i == j {
                sum.max(least).sqrt()
            } else {
                sum / a[j][j]
            };
        }
    }
    for i in 0..6 {
        for k in 0..i {
            b[i] -= a[i][k] * b[k];
        }
        b[i] /= a[i][i];
    }
    for i in (0..6).rev() {
        for k in i + 1..6 {
            b[i] -= a[k][i] * b[k];
        }
        b[i] /= a[i][i];
    }
    b
}

/// Axis times angle [rad] of a rotation, the angle in 0 ..= pi. By way of the quaternion with its largest component
/// first, which stays exact at small turns and at half turns.
pub fn rotation_vector<R: Real>(r: Rotation<R>) -> Vector<R> {
    let Rotation { n, s, a } = r;
    let (w, v) = if n.x + s.y + a.z > R::ZERO {
        let skew = Vector::new(s.z - a.y, a.x - n.z, n.y - s.x);
        (R::ONE + n.x + s.y + a.z, skew)
    } else if n.x >= s.y && n.x >= a.z {
        let x = R::ONE + n.x - s.y - a.z;
        (s.z - a.y, Vector::new(x, s.x + n.y, a.x + n.z))
    } else if s.y >= a.z {
        let y = R::ONE - n.x + s.y - a.z;
        (a.x - n.z, Vector::new(s.x + n.y, y, a.y + s.z))
    } else {
        let z = R::ONE - n.x - s.y + a.z;
        (n.y - s.x, Vector::new(a.x + n.z, a.y + s.z, z))
    };
    let sine = v.norm();
    if sine == R::ZERO {
        return Vector::ZERO;
    }
    // The quaternion and its negative are the same turn: take the one below half a turn.
    let angle = R::TWO * sine.atan2(w.abs());
    let v = if w < R::ZERO { -v } else { v };
    v * (angle / sine)
}

/// The shortest turn from one unit vector to another, axis times angle [rad]; about any perpendicular if they are opposite.
fn turn_between<R: Real>(from: Vector<R>, to: Vector<R>) -> Vector<R> {
    let cross = from.cross(to);
    let (sine, cosine) = (cross.norm(), from.dot(to));
    let angle = sine.atan2(cosine);
    if sine > R::of(1e-30) {
        return cross * (angle / sine);
    }
    if cosine >= R::ZERO {
        return Vector::ZERO;
    }
    // Any perpendicular serves; the one off the smallest component is never short.
    let aside = if from.x.abs() <= from.y.abs() && from.x.abs() <= from.z.abs() {
        Vector::X
    } else if from.y.abs() <= from.z.abs() {
        Vector::Y
    } else {
        Vector::Z
    };
    from.cross(aside)
        .unit(R::ZERO)
        .map_or(Vector::ZERO, |v| v * R::PI)
}
