//! Cone -> drill: the flank that a cone leaves, and the geometry measured on it.
//!
//! Serves for verification, and for parameters that were rounded or measured, whose lip is not quite a generator.
//! The flank's height over tip-centred (x, y) is where the line parallel to the drill's axis enters the cone:
//!
//! ```text
//! x' = X + x, y' = Y + y, b = a_x x' + a_y y', A = a_z^2 - cos^2 theta, B = a_z b, C = b^2 - cos^2 theta (x'^2 + y'^2)
//! S = cos theta sqrt(b^2 + A (x'^2 + y'^2))                                     the root of B^2 - A C
//! z = -C/(B + S)  if B + S > 0, else (S - B)/A;   b + a_z z > 0
//! ```
//!
//! The first form stays accurate when phi is near theta, where A is near 0.

use super::error::{DrillPointError, Field, check, within};
use super::solve::{Cone, axis};
use crate::geometry::Vector;
use crate::math::Real;

/// Flank 1 of a drill of given diameter and web, ground by a given cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flank<R> {
    axis: Vector<R>,
    cos_squared: R,
    /// A above.
    bend: R,
    /// X and Y: the tip from the apex, plan view [mm].
    x: R,
    y: R,
    /// R and r0 [mm].
    radius: R,
    half_web: R,
}

/// A point of the flank: its height above the apex [mm] and its slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface<R> {
    pub z: R,
    /// dz/dx and dz/dy.
    pub slope_x: R,
    pub slope_y: R,
}

/// The heel, behind the corner on the drill's circumference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heel<R> {
    /// Circumferential slope [rad].
    pub clearance: R,
    /// How much farther towards the shank than the corner [mm].
    pub drop: R,
    /// Tip-centred place in plan view [mm].
    pub(super) at: (R, R),
}

/// What the ground drill measures. Lengths in mm, angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground<R> {
    /// Cz, the tip above the apex.
    pub cz: R,
    /// Y, the apex line's offset; half the web where the lip is a generator.
    pub y: R,
    /// At the outer corner.
    pub point_angle: R,
    /// Of the lip from its inner end to the corner.
    pub point_angle_chord: R,
    pub chisel_angle: R,
    /// At the outer corner.
    pub clearance: R,
    /// At half the radius; `None` where the chisel edge reaches it.
    pub clearance_mid: Option<R>,
    /// Slope across the lip at the corner.
    pub m: R,
    /// xe
    pub chisel_end: R,
    /// The chisel edge's end above the tip.
    pub chisel_end_height: R,
    pub chisel_length: R,
}

impl<R: Real> Flank<R> {
    /// The flank left by a cone; its Cz is not needed, it follows.
    pub fn of(diameter: R, web: R, cone: &Cone<R>) -> Result<Self, DrillPointError<R>> {
        let right = R::PI * R::HALF;
        let squares = |length: R| (length * R::of(16.0)).squared().is_finite();
        check(
            &[
                (Field::Diameter, diameter),
                (Field::Web, web),
                (Field::Phi, cone.phi),
                (Field::Theta, cone.theta),
                (Field::Omega, cone.omega),
                (Field::Cx, cone.tip.x),
                (Field::Cy, cone.tip.y),
            ],
            &[
                (Field::Diameter, diameter > R::ZERO),
                (Field::Web, within(web, diameter)),
                (Field::Phi, within(cone.phi, right)),
                (Field::Theta, within(cone.theta, right)),
                (Field::Omega, cone.omega.abs() < right),
                // Heights are computed with squares of lengths.
                (Field::Diameter, squares(diameter)),
                (Field::Cx, squares(cone.tip.x)),
                (Field::Cy, squares(cone.tip.y)),
            ],
        )?;
        let tip = cone.tip_in_lip_frame();
        Ok(Self {
            axis: axis(cone.phi, cone.omega),
            cos_squared: cone.theta.cos().squared(),
            // cos^2 phi - cos^2 theta
            bend: (cone.theta - cone.phi).sin() * (cone.theta + cone.phi).sin(),
            x: tip.x,
            y: tip.y,
            radius: diameter * R::HALF,
            half_web: web * R::HALF,
        })
    }

    /// The flank over tip-centred (x, y) [mm], lip frame; `None` where the cone is not reached.
    pub fn surface(&self, x: R, y: R) -> Option<Surface<R>> {
        let (x, y) = (self.x + x, self.y + y);
        let a = self.axis;
        let b = a.x * x + a.y * y;
        let plan = x.squared() + y.squared();
        let under = b.squared() + self.bend * plan;
        // Beside the cone it is negative, the root is no number, and so nothing below is finite.
        let root = (self.cos_squared * under).sqrt();
        let sum = a.z * b + root;
        let z = if sum > R::ZERO {
            (self.cos_squared * plan - b.squared()) / sum
        } else {
            (root - a.z * b) / self.bend
        };
        let along = b + a.z * z;
        let steep = a.z * along - self.cos_squared * z;
        let surface = Surface {
            z,
            slope_x: (self.cos_squared * x - a.x * along) / steep,
            slope_y: (self.cos_squared * y - a.y * along) / steep,
        };
        let finite =
            surface.z.is_finite() && surface.slope_x.is_finite() && surface.slope_y.is_finite();
        (along > R::ZERO && finite).then_some(surface)
    }

    /// The same as a vector from the apex, lip frame [mm].
    pub fn point(&self, x: R, y: R) -> Option<Vector<R>> {
        let surface = self.surface(x, y)?;
        Some(Vector::new(self.x + x, self.y + y, surface.z))
    }

    /// Measures the drill.
    pub fn ground(&self) -> Result<Ground<R>, DrillPointError<R>> {
        let tip = self
            .surface(R::ZERO, R::ZERO)
            .ok_or(DrillPointError::OffCone)?;
        let corner_x = self.corner_x();
        let corner = self
            .surface(corner_x, -self.half_web)
            .ok_or(DrillPointError::OffCone)?;
        let chisel_end = self.chisel_end()?;
        let end = self
            .surface(chisel_end, -self.half_web)
            .ok_or(DrillPointError::NoChiselEnd)?;
        let half_chisel = chisel_end.hypot(self.half_web);
        let mid_radius = self.radius * R::HALF;
        let clearance_mid = if half_chisel < mid_radius {
            self.clearance_at(mid_radius)
        } else {
            None
        };
        let ground = Ground {
            cz: tip.z,
            y: self.y,
            point_angle: R::TWO * R::ONE.atan2(corner.slope_x),
            point_angle_chord: R::TWO * (corner_x - chisel_end).atan2(corner.z - end.z),
            chisel_angle: tip.slope_x.atan2(tip.slope_y),
            clearance: self
                .clearance_at(self.radius)
                .ok_or(DrillPointError::OffCone)?,
            clearance_mid,
            m: corner.slope_y,
            chisel_end,
            chisel_end_height: end.z - tip.z,
            chisel_length: R::TWO * half_chisel,
        };
        let lengths = ground.cz.is_finite() && ground.chisel_length.is_finite();
        lengths
            .then_some(ground)
            .ok_or(DrillPointError::OutOfRange(Field::Diameter))
    }

    /// alpha at radius `r` on the lip [rad]; `None` inside the web or off the cone.
    pub fn clearance_at(&self, r: R) -> Option<R> {
        let along = ((r - self.half_web) * (r + self.half_web)).sqrt();
        let at = self.surface(along, -self.half_web)?;
        Some((at.slope_x * (self.half_web / r) + at.slope_y * (along / r)).atan())
    }

    /// The heel at the plan angle `heel_angle` [rad] behind the corner; `None` if the cone does not reach it.
    pub fn heel(&self, heel_angle: R) -> Option<Heel<R>> {
        let azimuth = heel_angle - (self.half_web / self.radius).asin();
        let (sin, cos) = azimuth.sin_cos();
        let at = (self.radius * cos, self.radius * sin);
        let heel = self.surface(at.0, at.1)?;
        let corner = self.surface(self.corner_x(), -self.half_web)?;
        Some(Heel {
            clearance: (heel.slope_y * cos - heel.slope_x * sin).atan(),
            drop: heel.z - corner.z,
            at,
        })
    }

    /// Where lip 1 meets the circumference: x, tip-centred [mm]; y is -r0.
    pub fn corner_x(&self) -> R {
        ((self.radius - self.half_web) * (self.radius + self.half_web)).sqrt()
    }

    /// r0 [mm].
    pub fn half_web(&self) -> R {
        self.half_web
    }

    /// xe: where flank 1 on lip 1 is as high as on lip 2, so that the chisel edge ends. z(x, -r0) - z(-x, r0) is
    /// negative at the middle; the first change of sign is bracketed by steps of 5 %, then halved to the last bit.
    fn chisel_end(&self) -> Result<R, DrillPointError<R>> {
        let difference = |x: R| {
            let lip = self.surface(x, -self.half_web)?;
            let other = self.surface(-x, self.half_web)?;
            Some(lip.z - other.z)
        };
        let tip = self
            .surface(R::ZERO, R::ZERO)
            .ok_or(DrillPointError::OffCone)?;
        // r0/(4 tan psi), and a start of the same order where psi is no acute angle.
        let start = self.half_web * tip.slope_y / (tip.slope_x * R::of(4.0));
        let mut hi = if start.is_finite() && start > R::ZERO {
            start
        } else {
            self.half_web * R::of(0.01)
        };
        let mut lo = R::ZERO;
        let limit = self.corner_x();
        loop {
            if hi >= limit {
                return Err(DrillPointError::NoChiselEnd);
            }
            match difference(hi) {
                None => return Err(DrillPointError::NoChiselEnd),
                Some(d) if d >= R::ZERO => break,
                Some(_) => {}
            }
            lo = hi;
            hi *= R::of(1.05);
            // A start too small to grow would never end.
            if hi <= lo {
                return Err(DrillPointError::NoChiselEnd);
            }
        }
        loop {
            let mid = (lo + hi) * R::HALF;
            if mid <= lo || mid >= hi {
                return Ok(hi);
            }
            match difference(mid) {
                Some(d) if d < R::ZERO => lo = mid,
                _ => hi = mid,
            }
        }
    }
}
