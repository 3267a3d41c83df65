//! Drill -> cone: the inverse problem, in closed form.
//!
//! The lip is a generator of the cone, hence straight, and the flank has one tangent plane along all of it; slope m of
//! that plane across the lip follows from the clearance at the corner. Plane, point angle and the free axis angle phi
//! fix theta and omega. Where a cone's tangent plane contains a given direction, it does so along a whole generator:
//! the chisel angle therefore names the generator on which the tip lies, and the web sets the scale.
//!
//! Square roots of differences are written as products (sin^2 phi - sin^2 phi_min and the like), and lengths are
//! computed for a drill of radius 1, so that `f32` keeps its digits near the limits and no diameter overflows early.

use super::error::{DrillPointError, Field, check, within};
use super::flank::Flank;
use crate::geometry::Vector;
use crate::math::Real;

/// The geometry wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drill<R> {
    /// D [mm], greater than 0.
    pub diameter: R,
    /// W [mm], between 0 and D: the lips are parallel lines in plan view, each half of it from the axis.
    pub web: R,
    /// 2 phi0, the full point angle [rad], in (0, pi).
    pub point_angle: R,
    /// psi, the acute plan-view angle from the lip to the chisel edge at the tip [rad], in (0, pi/2).
    pub chisel_angle: R,
    /// alpha_f, the lip clearance in the tangent plane of the cylinder at the outer corner [rad], in (0, pi/2).
    pub clearance: R,
}

/// The grinding cone and where the drill's tip sits on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone<R> {
    /// Angle between the cone's axis and the drill's [rad].
    pub phi: R,
    /// Half angle of the cone [rad].
    pub theta: R,
    /// Plan-view angle from the plane of both axes to the lip [rad].
    pub omega: R,
    /// (Cx, Cy, Cz): the tip from the apex, in the cone frame [mm].
    pub tip: Vector<R>,
}

/// The cone for a drill, and what the solution says on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<R> {
    pub cone: Cone<R>,
    /// X, the tip from the apex along the lip's plan direction [mm].
    pub x: R,
    /// The flank's slope across the lip, plan view.
    pub m: R,
    /// The least phi that this clearance admits [rad].
    pub phi_min: R,
    /// xe, where the chisel edge ends and the lip begins, along the lip from the middle [mm].
    pub chisel_end: R,
}

/// A phi of whole degrees, and the heel clearance it gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suggestion<R> {
    pub degrees: i32,
    /// [rad]
    pub heel_clearance: R,
}

impl<R: Real> Cone<R> {
    /// The tip from the apex, in the lip frame: (X, Y, Z) [mm].
    pub fn tip_in_lip_frame(&self) -> Vector<R> {
        let (sin, cos) = self.omega.sin_cos();
        let c = self.tip;
        Vector::new(c.x * cos + c.y * sin, c.y * cos - c.x * sin, c.z)
    }

    /// The cone's axis in the lip frame, unit length, pointing into the drill.
    pub fn axis_in_lip_frame(&self) -> Vector<R> {
        axis(self.phi, self.omega)
    }

    /// Radius Rc of the tip's circle about the cone's axis [mm] and its phase mu0 [rad].
    pub fn circle(&self) -> (R, R) {
        let w = self.tip.x * self.phi.cos() - self.tip.z * self.phi.sin();
        (w.hypot(self.tip.y), self.tip.y.atan2(w))
    }
}

/// The axis of a cone in the lip frame.
pub(super) fn axis<R: Real>(phi: R, omega: R) -> Vector<R> {
    let (sin_phi, cos_phi) = phi.sin_cos();
    let (sin, cos) = omega.sin_cos();
    Vector::new(sin_phi * cos, -sin_phi * sin, cos_phi)
}

impl<R: Real> Drill<R> {
    /// phi0 [rad].
    pub fn half_point_angle(&self) -> R {
        self.point_angle * R::HALF
    }

    /// The cone that grinds this drill, for the axis angle `phi` [rad], 0 < phi < phi0.
    pub fn solve(&self, phi: R) -> Result<Solution<R>, DrillPointError<R>> {
        self.check(
            &[(Field::Phi, phi)],
            (Field::Phi, within(phi, self.half_point_angle())),
        )?;
        let m = self.slope()?;

        let (s, c) = self.half_point_angle().sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        let q = (R::ONE + (m * s).squared()).sqrt();
        let normal = Vector::new(-c, -m * s, s) * (R::ONE / q);

        // rr^2 - cos^2 phi = sin^2 phi - sin^2 phi_min, as a product.
        let sin_phi_min = m * s.squared() / q;
        if sin_phi < sin_phi_min {
            return Err(DrillPointError::PhiTooSmall {
                phi_min: sin_phi_min.asin(),
            });
        }
        let rise = ((sin_phi - sin_phi_min) * (sin_phi + sin_phi_min)).sqrt();
        let theta = (s / q).atan2(c) - rise.atan2(cos_phi);
        if theta <= R::ZERO {
            return Err(DrillPointError::PhiTooLarge);
        }
        let (sin_theta, cos_theta) = theta.sin_cos();
        let lip = Vector::new(s, R::ZERO, c);
        let a = lip * cos_theta + normal * sin_theta;
        let omega = (-a.y).atan2(a.x);

        let tip = self.generator_of_tip(a, phi, theta)?;
        let ratio = self.web / self.diameter;
        let tip = tip * (ratio / tip.y);
        if tip.x <= R::ZERO {
            return Err(DrillPointError::ApexOverAxis);
        }
        let chisel_end =
            chisel_end(a, cos_theta, tip.x, ratio, c / s).ok_or(DrillPointError::NoChiselEnd)?;
        if chisel_end >= ((R::ONE - ratio) * (R::ONE + ratio)).sqrt() {
            return Err(DrillPointError::NoLip);
        }

        let radius = self.diameter * R::HALF;
        let (sin, cos) = omega.sin_cos();
        let tip = tip * radius;
        let solution = Solution {
            cone: Cone {
                phi,
                theta,
                omega,
                tip: Vector::new(tip.x * cos - tip.y * sin, tip.x * sin + tip.y * cos, tip.z),
            },
            x: tip.x,
            m,
            phi_min: sin_phi_min.asin(),
            chisel_end: chisel_end * radius,
        };
        if solution.cone.tip.is_finite() {
            Ok(solution)
        } else {
            Err(DrillPointError::OutOfRange(Field::Diameter))
        }
    }

    /// The phi of whole degrees whose heel clearance, at `heel_angle` behind the corner, comes nearest to `target`
    /// [rad]; the smaller phi on a tie.
    pub fn suggest_phi(
        &self,
        heel_angle: R,
        target: R,
    ) -> Result<Suggestion<R>, DrillPointError<R>> {
        self.check(
            &[(Field::HeelAngle, heel_angle), (Field::Target, target)],
            (
                Field::HeelAngle,
                heel_angle >= R::ZERO && heel_angle <= R::PI,
            ),
        )?;
        self.slope()?;

        let mut best: Option<Suggestion<R>> = None;
        let phis = (1..90).map(|degrees| (degrees, R::of_i32(degrees).to_radians()));
        for (degrees, phi) in phis.take_while(|(_, phi)| *phi < self.half_point_angle()) {
            let heel = self
                .solve(phi)
                .and_then(|solution| Flank::of(self.diameter, self.web, &solution.cone))
                .map(|flank| flank.heel(heel_angle));
            let Ok(Some(heel)) = heel else { continue };
            let nearer = match best {
                None => true,
                Some(best) => {
                    (heel.clearance - target).abs() < (best.heel_clearance - target).abs()
                }
            };
            if nearer {
                best = Some(Suggestion {
                    degrees,
                    heel_clearance: heel.clearance,
                });
            }
        }
        best.ok_or(DrillPointError::NoPhi)
    }

    /// tan alpha(r) = m cos w + cot phi0 sin w, sin w = r0/r: the clearance at radius `r` [mm] along the lip [rad].
    /// `None` inside the web.
    pub fn clearance_at(&self, m: R, r: R) -> Option<R> {
        let sin_w = self.web * R::HALF / r;
        let cos_w = ((R::ONE - sin_w) * (R::ONE + sin_w)).sqrt();
        let tan = m * cos_w + sin_w / self.half_point_angle().tan();
        tan.is_finite().then(|| tan.atan())
    }

    /// All numbers of the drill and these more, then all ranges of the drill and this more.
    fn check(&self, more: &[(Field, R)], last: (Field, bool)) -> Result<(), DrillPointError<R>> {
        let right = R::PI * R::HALF;
        check(
            &[
                (Field::Diameter, self.diameter),
                (Field::Web, self.web),
                (Field::PointAngle, self.point_angle),
                (Field::ChiselAngle, self.chisel_angle),
                (Field::Clearance, self.clearance),
            ],
            &[],
        )?;
        check(
            more,
            &[
                (Field::Diameter, self.diameter > R::ZERO),
                (Field::Web, within(self.web, self.diameter)),
                (Field::PointAngle, within(self.point_angle, R::PI)),
                (Field::ChiselAngle, within(self.chisel_angle, right)),
                (Field::Clearance, within(self.clearance, right)),
                last,
            ],
        )
    }

    /// m, the flank's slope across the lip, from the clearance at the corner.
    fn slope(&self) -> Result<R, DrillPointError<R>> {
        let sin_w = self.web / self.diameter;
        let cos_w = ((R::ONE - sin_w) * (R::ONE + sin_w)).sqrt();
        let least = sin_w / self.half_point_angle().tan();
        let m = (self.clearance.tan() - least) / cos_w;
        if m >= R::ZERO && m.is_finite() {
            Ok(m)
        } else {
            Err(DrillPointError::ClearanceTooSmall {
                least: least.atan(),
            })
        }
    }

    /// Direction from the apex to the tip: the generator whose tangent plane contains the chisel edge.
    fn generator_of_tip(
        &self,
        a: Vector<R>,
        phi: R,
        theta: R,
    ) -> Result<Vector<R>, DrillPointError<R>> {
        let (sin_psi, cos_psi) = self.chisel_angle.sin_cos();
        let (sin_theta, cos_theta) = theta.sin_cos();
        let e = a.x * sin_psi + a.y * cos_psi;
        // amp^2 - sin^2 theta with amp^2 = cos^2 phi + e^2, as a sum without cancellation of the cosines.
        let rest = e.squared() + (phi + theta).cos() * (phi - theta).cos();
        if rest <= R::ZERO {
            return Err(DrillPointError::NoChisel);
        }
        let amp_squared = a.z.squared() + e.squared();
        let root = rest.sqrt();
        // tau = atan2(e, a_z) +- acos(sin theta/amp), by the addition theorems.
        let candidate = |root: R| {
            let sin_tau = (e * sin_theta + a.z * root) / amp_squared;
            let cos_tau = (a.z * sin_theta - e * root) / amp_squared;
            let normal = Vector::new(sin_tau * sin_psi, sin_tau * cos_psi, cos_tau);
            let g = (a - normal * sin_theta) * (R::ONE / cos_theta);
            (normal.z > R::ZERO && g.y > R::ZERO).then_some(g)
        };
        match (candidate(root), candidate(-root)) {
            (Some(g), None) | (None, Some(g)) => Ok(g),
            (None, None) => Err(DrillPointError::NoTip),
            (Some(_), Some(_)) => Err(DrillPointError::Ambiguous),
        }
    }
}

/// Inner end of the lip: where the line of lip 2, seen from the apex P0 + x P1, enters the cone of flank 1. Lengths
/// in units of the drill's radius; `r0` half the web, `k` = cot phi0.
fn chisel_end<R: Real>(a: Vector<R>, cos_theta: R, x: R, r0: R, k: R) -> Option<R> {
    let cos_squared = cos_theta.squared();
    let p0 = Vector::new(x, R::TWO * r0, x * k);
    let p1 = Vector::new(-R::ONE, R::ZERO, k);
    let form = |u: Vector<R>, v: Vector<R>| a.dot(u) * a.dot(v) - cos_squared * u.dot(v);
    let (square, half, constant) = (form(p1, p1), form(p0, p1), form(p0, p0));
    let discriminant = half.squared() - square * constant;
    if discriminant < R::ZERO {
        return None;
    }
    // The root with the larger magnitude has no cancellation; the other follows from their product.
    let sum = -(half + discriminant.sqrt().copysign(half));
    let enters = |x: R| {
        let p = p0 + p1 * x;
        let along = a.dot(p);
        let outer = a.z * along - cos_squared * p.z > R::ZERO;
        (x.is_finite() && x > R::ZERO && along > R::ZERO && outer).then_some(x)
    };
    match (enters(sum / square), enters(constant / sum)) {
        (Some(first), Some(second)) => Some(first.min(second)),
        (first, second) => first.or(second),
    }
}
