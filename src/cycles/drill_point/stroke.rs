//! Where the contact with the wheel begins and ends: the range of mu.
//!
//! A point P of the flank, from the apex, is ground at mu = nu(P) - nu(corner), nu its angle about the cone's axis.

use super::error::{DrillPointError, Field, check};
use super::flank::Flank;
use super::solve::Cone;
use crate::geometry::Vector;
use crate::math::Real;

/// Angles of mu [rad].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke<R> {
    /// Where the lip's inner end is ground: 0 for a lip that is a generator.
    pub lip_inner: R,
    pub tip: R,
    pub chisel_far: R,
    /// `None` if the cone does not reach the heel.
    pub heel: Option<R>,
    pub start: R,
    pub end: R,
}

/// A heel that does not count for the end of the stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeelWarning {
    /// The cone does not reach it.
    NotReached,
    /// It would be ground beyond mu = 90 deg.
    Beyond90,
}

impl HeelWarning {
    /// The name under which every interface reports it.
    pub const fn name(self) -> &'static str {
        match self {
            HeelWarning::NotReached => "HeelNotReached",
            HeelWarning::Beyond90 => "HeelBeyond90",
        }
    }
}

impl<R: Real> Stroke<R> {
    /// The stroke that grinds `flank` by `cone`, from `over` before the lip to `over` behind the last contact;
    /// `chisel_end` xe [mm], `heel_angle` and `over` [rad].
    pub fn new(
        cone: &Cone<R>,
        flank: &Flank<R>,
        chisel_end: R,
        heel_angle: R,
        over: R,
    ) -> Result<Self, DrillPointError<R>> {
        let right = R::PI * R::HALF;
        check(
            &[(Field::HeelAngle, heel_angle), (Field::Over, over)],
            &[
                (
                    Field::HeelAngle,
                    heel_angle >= R::ZERO && heel_angle <= R::PI,
                ),
                (Field::Over, over >= R::ZERO && over <= right),
            ],
        )?;
        let (sin_phi, cos_phi) = cone.phi.sin_cos();
        let (sin, cos) = cone.omega.sin_cos();
        let e_w = Vector::new(cos_phi * cos, -cos_phi * sin, -sin_phi);
        let e_y = Vector::new(sin, cos, R::ZERO);
        let seen = |x: R, y: R| {
            let p = flank.point(x, y).ok_or(DrillPointError::OffCone)?;
            Ok((p.dot(e_w), p.dot(e_y)))
        };
        let r0 = flank.half_web();
        let corner = seen(flank.corner_x(), -r0)?;
        // The difference of both angles as one, which leaves no turns to take off.
        let contact = |x: R, y: R| {
            let (w, y) = seen(x, y)?;
            let across = y * corner.0 - w * corner.1;
            Ok(across.atan2(w * corner.0 + y * corner.1))
        };
        let chisel_far = contact(-chisel_end, r0)?;
        let heel = match flank.heel(heel_angle) {
            Some(heel) => Some(contact(heel.at.0, heel.at.1)?),
            None => None,
        };
        let last = match heel {
            Some(heel) if heel <= right => chisel_far.max(heel),
            _ => chisel_far,
        };
        Ok(Self {
            lip_inner: contact(chisel_end, -r0)?,
            tip: contact(R::ZERO, R::ZERO)?,
            chisel_far,
            heel,
            start: -over,
            end: last + over,
        })
    }

    pub fn warning(&self) -> Option<HeelWarning> {
        match self.heel {
            None => Some(HeelWarning::NotReached),
            Some(heel) if heel > R::PI * R::HALF => Some(HeelWarning::Beyond90),
            Some(_) => None,
        }
    }
}
