//! Six-axis arm with a spherical wrist: flange pose <-> six joint angles, all eight branches in closed form.
//!
//! ```text
//!                a2            modified DH (Craig): T_i = RotX(alpha_(i-1)) TransX(a_(i-1)) RotZ(theta_i) TransZ(d_i)
//!          (2)--------(3)
//!    a1   /            |  a3     i   a_(i-1)  alpha_(i-1)  d_i        X forward, Y down, from axis 2,
//!   +----+             +--.      1   0          0          d1         in the plane of the arm:
//!   |  d1               d4 \     2   a1       -90          0
//!   |                       (W)  3   a2         0          0          W = a2 e^(i theta2) + L3 e^(i (theta2 + beta))
//!  (1) base            wrist |   4   a3       -90          d4         L3 e^(i phi) = a3 + i d4,  beta = theta3 + phi
//!                         d6 v   5   0         90          0
//!                      flange    6   0        -90          d6
//! ```
//!
//! Branch number = 4 (shoulder back) + 2 (beta < 0) + (theta5 < 0). The planar part multiplies complex numbers instead of
//! adding angles and taking their sines, so that all eight branches need 19 arctangents and no sine. The last angle is
//! read from a row of the wrist that is well conditioned at every pose, whatever theta4 is.
//!
//! Flange pose in the base frame, mm; angles in rad, theta as tabled (zero offset).
//!
//! Errors in f32 against f64, largest of 101 000 random poses of the ER3B and 100 random arms that reach to 1000 mm, all
//! branches (measured again by `host-tests/tests/arm.rs`; in f64 forward(inverse) is within 1e-8 mm):
//!
//! | | f32 |
//! |---|---|
//! | flange of the forward map | 1.5e-4 mm |
//! | flange, forward(inverse) | 6.6e-4 mm; 3.5e-3 mm within 3 deg of a stretched or folded elbow |
//! | direction, forward(inverse) | 7.6e-5 deg at every pose |
//! | joint angle, away from singular poses | 3.5e-6 rad |
//!
//! Cost on a Cortex-M4F in f32: 7600 instructions for all branches (`arm_ik_instructions` of `cargo xtask bench`).
//!
//! Source: specification of surface grinding, section 9; ER3B dimensions from the table of the paper (its columns corrected).

use crate::geometry::{Pose, Rotation, Vector};
use crate::joints::Joints;
use crate::kinematics::chain::check_pose;
use crate::kinematics::{Error, Kinematics, nearest_turn, principal};
use crate::math::Real;

mod guide;
mod stretch;

pub use guide::{ArmSet, OneBranch};
pub use stretch::{NoBranch, Refusal, Stretch};

/// Singular below one degree: sin(1 deg).
const SIN_ONE_DEGREE: f64 = 0.017_452_406_437_283_51;

/// One row of the table: `a` [mm] and `alpha` [rad] of the link before, `d` [mm] along the joint axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DhRow<R> {
    pub a: R,
    pub alpha: R,
    pub d: R,
}

/// What is wrong with an arm or a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArmError {
    /// The table does not describe this kind of arm, or a link has no length; `row` counts from 0.
    BadParameter { row: usize },
    /// A range with its lower end above the upper one, or not a number; `joint` counts from 0.
    BadLimit { joint: usize },
    /// The pose is not finite or its rotation is not one (1e-6).
    BadPose,
    /// Neither shoulder reaches the wrist point.
    Unreachable,
}

/// The lengths of the arm [mm]; names as in the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths<R> {
    pub a1: R,
    pub a2: R,
    pub a3: R,
    pub d1: R,
    pub d4: R,
    pub d6: R,
}

/// One of the eight ways to reach a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<R> {
    /// 0 ..= 7: 4 shoulder back + 2 elbow (beta < 0) + 1 wrist (theta5 < 0).
    pub branch: u8,
    /// Joint angles [rad], with the full turns that fit the range, nearest to the previous joints.
    pub q: Joints<6, R>,
    /// All angles are within their ranges; if not, the angles that do not fit are in (-pi, pi].
    pub in_limits: bool,
    /// |sin theta5| < sin 1 deg.
    pub wrist_singular: bool,
    /// |sin beta| < sin 1 deg: stretched or folded.
    pub elbow_singular: bool,
    /// The wrist point is within 1 mm of axis 1.
    pub shoulder_singular: bool,
}

impl<R: Real> Solution<R> {
    const NONE: Self = Self {
        branch: 0,
        q: Joints([R::ZERO; 6]),
        in_limits: false,
        wrist_singular: false,
        elbow_singular: false,
        shoulder_singular: false,
    };
}

/// The branches that reach a pose, in the order of their numbers: eight, or four when only one shoulder reaches.
#[derive(Clone, Copy, Debug)]
pub struct Branches<R> {
    list: [Solution<R>; 8],
    len: usize,
}

impl<R: Real> Branches<R> {
    pub fn as_slice(&self) -> &[Solution<R>] {
        self.list.get(..self.len).unwrap_or(&self.list)
    }

    /// The solution of this branch.
    pub fn branch(&self, number: u8) -> Option<&Solution<R>> {
        self.as_slice().iter().find(|s| s.branch == number)
    }

    fn push(&mut self, solution: Solution<R>) {
        if let Some(slot) = self.list.get_mut(self.len) {
            *slot = solution;
            self.len += 1;
        }
    }
}

/// An arm with its ranges; everything that does not depend on the pose is computed here once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm<R = f32> {
    lengths: Lengths<R>,
    limits: [[R; 2]; 6],
    /// L3 = |a3 + i d4| and its angle phi.
    l3: R,
    phi: R,
    cos_phi: R,
    sin_phi: R,
    /// a2^2 + L3^2, and 1/(2 a2 L3).
    squares: R,
    per_product: R,
}

/// Table of the arm in the drawing: alpha 0, -90, 0, -90, 90, -90 deg, all else zero but the six lengths.
pub fn table<R: Real>(lengths: &Lengths<R>) -> [DhRow<R>; 6] {
    let right = R::PI * R::HALF;
    let row = |a, alpha, d| DhRow { a, alpha, d };
    let zero = R::ZERO;
    [
        row(zero, zero, lengths.d1),
        row(lengths.a1, -right, zero),
        row(lengths.a2, zero, zero),
        row(lengths.a3, -right, lengths.d4),
        row(zero, right, zero),
        row(zero, -right, lengths.d6),
    ]
}

/// Flange pose of any six-row table at the angles `q` [rad]: the product of the T_i, nothing assumed.
pub fn forward_of_table<R: Real>(rows: &[DhRow<R>; 6], q: &Joints<6, R>) -> Pose<R> {
    rows.iter()
        .zip(&q.0)
        .fold(Pose::IDENTITY, |base, (row, theta)| {
            let (sa, ca) = row.alpha.sin_cos();
            let (st, ct) = theta.sin_cos();
            let z = Vector::new(R::ZERO, -sa, ca);
            let across = Vector::new(R::ZERO, ca, sa);
            let link = Pose {
                rotation: Rotation {
                    n: Vector::X * ct + across * st,
                    s: Vector::X * -st + across * ct,
                    a: z,
                },
                p: Vector::X * row.a + z * row.d,
            };
            base * link
        })
}

impl<R: Real> Arm<R> {
    /// An arm of these lengths and ranges [lo, hi] of theta [rad].
    pub fn new(lengths: Lengths<R>, limits: [[R; 2]; 6]) -> Result<Self, ArmError> {
        let Lengths {
            a1,
            a2,
            a3,
            d1,
            d4,
            d6,
        } = lengths;
        for (row, value) in [d1, a1, a2, a3, d4, d6].iter().enumerate() {
            if !value.is_finite() {
                return Err(ArmError::BadParameter { row: row.min(5) });
            }
        }
        let l3 = (a3 * a3 + d4 * d4).sqrt();
        let least = R::of(1e-6);
        for (row, length) in [(2, a2.abs()), (3, l3)] {
            if length < least {
                return Err(ArmError::BadParameter { row });
            }
        }
        for (joint, [lo, hi]) in limits.iter().enumerate() {
            // False for a NaN as well.
            if !matches!(
                lo.partial_cmp(hi),
                Some(core::cmp::Ordering::Less | core::cmp::Ordering::Equal)
            ) {
                return Err(ArmError::BadLimit { joint });
            }
        }
        Ok(Self::prepare(lengths, limits))
    }

    fn prepare(lengths: Lengths<R>, limits: [[R; 2]; 6]) -> Self {
        let Lengths { a2, a3, d4, .. } = lengths;
        let l3 = (a3 * a3 + d4 * d4).sqrt();
        Self {
            lengths,
            limits,
            l3,
            phi: d4.atan2(a3),
            cos_phi: a3 / l3,
            sin_phi: d4 / l3,
            squares: a2 * a2 + l3 * l3,
            per_product: R::HALF / (a2 * l3),
        }
    }

    /// The same from a table; alpha must be 0, -90, 0, -90, 90, -90 deg, and zero must be what [`table`] has zero
    /// (1e-9 rad and mm in f64).
    pub fn from_table(rows: &[DhRow<R>; 6], limits: [[R; 2]; 6]) -> Result<Self, ArmError> {
        let [r1, r2, r3, r4, _, r6] = rows;
        let lengths = Lengths {
            a1: r2.a,
            a2: r3.a,
            a3: r4.a,
            d1: r1.d,
            d4: r4.d,
            d6: r6.d,
        };
        let tolerance = R::of(1e-9).max(R::EPSILON * R::of(8.0));
        for (row, (given, own)) in rows.iter().zip(&table(&lengths)).enumerate() {
            let off = [given.a - own.a, given.alpha - own.alpha, given.d - own.d];
            if !off.iter().all(|x| x.abs() <= tolerance) {
                return Err(ArmError::BadParameter { row });
            }
        }
        Self::new(lengths, limits)
    }

    /// ER3B: 3 kg, 0.6 m. The 320 is read as the base height and the 50 as the forward shoulder offset.
    pub fn er3b() -> Self {
        let lengths = Lengths {
            a1: R::of(50.0),
            a2: R::of(270.0),
            a3: R::of(70.0),
            d1: R::of(320.0),
            d4: R::of(299.0),
            d6: R::of(78.5),
        };
        let limits = ER3B_DEGREES.map(|range| range.map(|degrees| R::of(degrees).to_radians()));
        Self::prepare(lengths, limits)
    }

    pub fn lengths(&self) -> &Lengths<R> {
        &self.lengths
    }

    /// Ranges of theta [rad].
    pub fn limits(&self) -> &[[R; 2]; 6] {
        &self.limits
    }

    /// Flange pose in the base frame at the angles `q` [rad].
    pub fn forward(&self, q: &Joints<6, R>) -> Pose<R> {
        let Joints([q1, q2, q3, q4, q5, q6]) = *q;
        let Lengths {
            a1,
            a2,
            a3,
            d1,
            d4,
            d6,
        } = self.lengths;
        let (s1, c1) = q1.sin_cos();
        let (s2, c2) = q2.sin_cos();
        let (s23, c23) = (q2 + q3).sin_cos();
        let (s4, c4) = q4.sin_cos();
        let (s5, c5) = q5.sin_cos();
        let (s6, c6) = q6.sin_cos();
        let frame = Frame3::new((c1, s1), (c23, s23));
        // M = RotZ(theta4) RotY(-theta5) RotZ(theta6), by columns.
        let column = |x: R, y: R, z: R| {
            let (row0, row1) = (c5 * x - s5 * z, y);
            frame.outward(
                c4 * row0 - s4 * row1,
                s4 * row0 + c4 * row1,
                s5 * x + c5 * z,
            )
        };
        let rotation = Rotation {
            n: column(c6, s6, R::ZERO),
            s: column(-s6, c6, R::ZERO),
            a: column(R::ZERO, R::ZERO, R::ONE),
        };
        let forward = a1 + a2 * c2 + a3 * c23 - d4 * s23;
        let height = d1 - a2 * s2 - a3 * s23 - d4 * c23;
        let wrist = Vector::new(c1 * forward, s1 * forward, height);
        Pose {
            rotation,
            p: wrist + rotation.a * d6,
        }
    }

    /// All branches that reach the flange pose. `previous` [rad] chooses the full turns, and the free angle at an exactly
    /// singular pose; without it turns nearest to zero. Branches outside their ranges are returned as well, marked.
    pub fn inverse(
        &self,
        pose: &Pose<R>,
        previous: Option<&Joints<6, R>>,
    ) -> Result<Branches<R>, ArmError> {
        check_pose(pose).map_err(|_| ArmError::BadPose)?;
        let zero = Joints::default();
        let previous = match previous {
            Some(q) if q.is_finite() => q,
            _ => &zero,
        };
        let wrist = pose.p - pose.rotation.a * self.lengths.d6;
        // Not hypot: that one computes in double precision, which the target has only in software.
        let rho = (wrist.x * wrist.x + wrist.y * wrist.y).sqrt();
        let mut branches = Branches {
            list: [Solution::NONE; 8],
            len: 0,
        };
        let front = if rho < R::of(1e-6) {
            // On axis 1 every direction serves: both shoulders keep the previous one.
            let (s, c) = previous[0].sin_cos();
            let theta = principal(previous[0]);
            [(theta, c, s), (theta, c, s)]
        } else {
            let theta = wrist.y.atan2(wrist.x);
            let (c, s) = (wrist.x / rho, wrist.y / rho);
            [(theta, c, s), (principal(theta + R::PI), -c, -s)]
        };
        for ((back, (theta1, c1, s1)), reach) in (0..).step_by(4).zip(front).zip([rho, -rho]) {
            let x = reach - self.lengths.a1;
            let y = self.lengths.d1 - wrist.z;
            let cos_beta = (x * x + y * y - self.squares) * self.per_product;
            // A stretched or folded arm lands on one only up to rounding.
            if cos_beta.abs() > R::ONE + R::EPSILON * R::of(16.0) {
                continue;
            }
            let cos_beta = cos_beta.clamp(-R::ONE, R::ONE);
            let sin_beta = ((R::ONE - cos_beta) * (R::ONE + cos_beta)).sqrt();
            let beta = sin_beta.atan2(cos_beta);
            let theta1 = self.fit(0, theta1, previous[0]);
            let shoulder_singular = rho < R::ONE;
            for (elbow, sin_beta, beta) in [(0, sin_beta, beta), (2, -sin_beta, -beta)] {
                let (c2, s2) = self.upper_arm(x, y, cos_beta, sin_beta);
                let theta2 = self.fit(1, s2.atan2(c2), previous[1]);
                let theta3 = self.fit(2, principal(beta - self.phi), previous[2]);
                // e^(i theta3) = e^(i (beta - phi)), then theta2 added by another product.
                let c3 = cos_beta * self.cos_phi + sin_beta * self.sin_phi;
                let s3 = sin_beta * self.cos_phi - cos_beta * self.sin_phi;
                let c23 = c2 * c3 - s2 * s3;
                let s23 = s2 * c3 + c2 * s3;
                let frame = Frame3::new((c1, s1), (c23, s23));
                let wrist = Wrist::new(&frame, &pose.rotation, previous[3]);
                for (flip, angles) in [(0, wrist.up), (1, wrist.flipped)] {
                    let [q4, q5, q6] = angles;
                    let theta4 = self.fit(3, q4, previous[3]);
                    let theta5 = self.fit(4, q5, previous[4]);
                    let theta6 = self.fit(5, q6, previous[5]);
                    branches.push(Solution {
                        branch: back + elbow + flip,
                        q: Joints([theta1.0, theta2.0, theta3.0, theta4.0, theta5.0, theta6.0]),
                        in_limits: theta1.1
                            && theta2.1
                            && theta3.1
                            && theta4.1
                            && theta5.1
                            && theta6.1,
                        wrist_singular: wrist.sine < R::of(SIN_ONE_DEGREE),
                        elbow_singular: sin_beta.abs() < R::of(SIN_ONE_DEGREE),
                        shoulder_singular,
                    });
                }
            }
        }
        if branches.len == 0 {
            Err(ArmError::Unreachable)
        } else {
            Ok(branches)
        }
    }

    /// The number of the branch that the arm stands in at the angles `q` [rad].
    pub fn branch_of(&self, q: &Joints<6, R>) -> u8 {
        let Joints([_, q2, q3, _, q5, _]) = *q;
        let Lengths { a1, a2, a3, d4, .. } = self.lengths;
        let (s23, c23) = (q2 + q3).sin_cos();
        let (_, c2) = q2.sin_cos();
        let reach = a1 + a2 * c2 + a3 * c23 - d4 * s23;
        let is = |number, holds| if holds { number } else { 0 };
        is(4, reach < R::ZERO)
            + is(2, principal(q3 + self.phi) < R::ZERO)
            + is(1, principal(q5) < R::ZERO)
    }

    /// Cosine and sine of theta2: (X + iY) / (a2 + L3 e^(i beta)), a quotient of two numbers of equal length.
    fn upper_arm(&self, x: R, y: R, cos_beta: R, sin_beta: R) -> (R, R) {
        let re = self.lengths.a2 + self.l3 * cos_beta;
        let im = self.l3 * sin_beta;
        let (c, s) = (x * re + y * im, y * re - x * im);
        let length = (c * c + s * s).sqrt();
        // The wrist on axis 2 (a folded arm of equal links): any theta2 serves.
        if length <= R::of(1e-12) {
            (R::ONE, R::ZERO)
        } else {
            (c / length, s / length)
        }
    }

    /// The representative of an angle in (-pi, pi] that lies in the range of joint `index`, nearest to `previous`.
    /// Without one, the angle as it is and `false`.
    pub(crate) fn fit(&self, index: usize, angle: R, previous: R) -> (R, bool) {
        let Some([lo, hi]) = self.limits.get(index) else {
            return (angle, false);
        };
        fit_turns(angle, previous, *lo, *hi)
    }
}

/// `angle` plus the whole turns that bring it nearest to `previous` within `lo ..= hi`; `false`, and the angle
/// unchanged, if none do. A rounding error beyond the end of the range is within it.
fn fit_turns<R: Real>(angle: R, previous: R, lo: R, hi: R) -> (R, bool) {
    let slack = R::EPSILON * R::of(32.0);
    let (lo, hi) = (lo - slack, hi + slack);
    if lo <= angle && angle <= hi && (angle - previous).abs() <= R::PI {
        return (angle, true);
    }
    let least = ((lo - angle) / R::TAU).ceil();
    let most = ((hi - angle) / R::TAU).floor();
    if least > most {
        return (angle, false);
    }
    let turns = ((previous - angle) / R::TAU).round().clamp(least, most);
    (angle + turns * R::TAU, true)
}

/// Axes of frame 3 in the base, in the form that separates the shoulder from the elbow.
struct Frame3<R> {
    c1: R,
    s1: R,
    c23: R,
    s23: R,
}

impl<R: Real> Frame3<R> {
    fn new((c1, s1): (R, R), (c23, s23): (R, R)) -> Self {
        Self { c1, s1, c23, s23 }
    }

    /// A direction of the base in the wrist's frame: RotX(90) R03^T v.
    fn inward(&self, v: Vector<R>) -> [R; 3] {
        let ahead = self.c1 * v.x + self.s1 * v.y;
        [
            self.c23 * ahead - self.s23 * v.z,
            self.s1 * v.x - self.c1 * v.y,
            -self.s23 * ahead - self.c23 * v.z,
        ]
    }

    /// The way back.
    fn outward(&self, m0: R, m1: R, m2: R) -> Vector<R> {
        let ahead = self.c23 * m0 - self.s23 * m2;
        Vector::new(
            self.c1 * ahead + self.s1 * m1,
            self.s1 * ahead - self.c1 * m1,
            -self.s23 * m0 - self.c23 * m2,
        )
    }
}

/// The two ways of the wrist: theta4, theta5, theta6 in (-pi, pi].
struct Wrist<R> {
    up: [R; 3],
    flipped: [R; 3],
    /// |sin theta5|.
    sine: R,
}

impl<R: Real> Wrist<R> {
    /// From M = RotZ(theta4) RotY(-theta5) RotZ(theta6). The third column gives theta4 and theta5; then row 1 of
    /// RotZ(-theta4) M is (sin theta6, cos theta6, 0), whatever theta5 is.
    fn new(frame: &Frame3<R>, r: &Rotation<R>, previous: R) -> Self {
        let [m02, m12, m22] = frame.inward(r.a);
        let [m00, m10, _] = frame.inward(r.n);
        let [m01, m11, _] = frame.inward(r.s);
        let sine = (m02 * m02 + m12 * m12).sqrt();
        let theta5 = sine.atan2(m22);
        let six = |c4: R, s4: R| (c4 * m10 - s4 * m00).atan2(c4 * m11 - s4 * m01);
        // Below this the column holds rounding only.
        let least = R::of(1e-9).max(R::EPSILON * R::of(8.0));
        if sine < least {
            // Axes 4 and 6 in line: both ways keep the previous theta4, and theta6 takes the rest.
            let (s4, c4) = previous.sin_cos();
            let theta4 = principal(previous);
            let theta6 = six(c4, s4);
            return Self {
                up: [theta4, theta5, theta6],
                flipped: [theta4, -theta5, theta6],
                sine,
            };
        }
        let theta4 = (-m12).atan2(-m02);
        let theta6 = six(-m02 / sine, -m12 / sine);
        Self {
            up: [theta4, theta5, theta6],
            flipped: [
                principal(theta4 + R::PI),
                -theta5,
                principal(theta6 + R::PI),
            ],
            sine,
        }
    }
}

/// Ranges of the ER3B [deg].
const ER3B_DEGREES: [[f64; 2]; 6] = [
    [-175.0, 175.0],
    [-142.0, 64.0],
    [-73.0, 165.0],
    [-178.0, 178.0],
    [-132.0, 132.0],
    [-720.0, 720.0],
];

/// Poses of the flange; the branch of the joints before is kept, ranges are not looked at.
impl<R: Real> Kinematics<6, R> for Arm<R> {
    fn forward(&self, joints: &Joints<6, R>) -> Pose<R> {
        Arm::forward(self, joints)
    }

    fn inverse(&self, pose: &Pose<R>, near: &Joints<6, R>) -> Result<Joints<6, R>, Error> {
        if !near.is_finite() {
            return Err(Error::NotFinite);
        }
        let found = Arm::inverse(self, pose, Some(near)).map_err(|error| match error {
            ArmError::BadPose => Error::NotFinite,
            _ => Error::OutOfReach,
        })?;
        let solution = found
            .branch(self.branch_of(near))
            .ok_or(Error::OutOfReach)?;
        Ok(solution.q.zip_map(near, |q, near| nearest_turn(q, near)))
    }
}
