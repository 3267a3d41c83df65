//! Hertz: force and curvatures to the ellipse of contact.
//!
//! ```text
//!      across C                     relative curvature in (feed, cross):
//!         |   .-'''-.               [ k_f + 1/R_rim    tau           ]     k_max at psi from the feed,
//!     b_c |.-'   a / '.             [ tau              k_c + 1/R_crown ]   the long axis a along k_min
//!         /   psi / .-'
//!        '-.___.-'----- feed T      b_c, a_f: half extents of the turned ellipse across and along the feed
//! ```
//!
//! Exact, by Carlson's integrals (see [`super::ellipse`]); the usual fits err by up to 6 % in the axes, 12 % in the
//! scallop. About 1 us on a PC. Source: K. L. Johnson, Contact Mechanics, 4.2.

use super::ellipse::Ellipse;
use super::{Field, GrindingError};
use crate::geometry::nurbs::Section;
use crate::math::Real;

/// An elastic body: modulus [MPa], Poisson's ratio 0 ..= 0.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material<R> {
    pub modulus: R,
    pub poisson: R,
}

/// The wheel's radii [mm], along the feed and along its axle; `None` where it is flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel<R> {
    pub rim: Option<R>,
    pub crown: Option<R>,
}

/// E* [MPa] of two bodies: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
pub fn effective_modulus<R: Real>(
    wheel: Material<R>,
    part: Material<R>,
) -> Result<R, GrindingError<R>> {
    let half = R::of(0.5);
    for (m, e, nu) in [
        (wheel, Field::E1, Field::Nu1),
        (part, Field::E2, Field::Nu2),
    ] {
        if !(m.modulus > R::ZERO && m.modulus.is_finite()) {
            return Err(GrindingError::BadMaterial(e));
        }
        if !(m.poisson >= R::ZERO && m.poisson <= half) {
            return Err(GrindingError::BadMaterial(nu));
        }
    }
    let soft = |m: Material<R>| (R::ONE - m.poisson * m.poisson) / m.modulus;
    Ok(R::ONE / (soft(wheel) + soft(part)))
}

impl<R: Real> Wheel<R> {
    /// Its curvatures (along the feed, across) [1/mm].
    pub fn curvatures(&self) -> Result<[R; 2], GrindingError<R>> {
        let curvature = |radius: Option<R>, field| match radius {
            None => Ok(R::ZERO),
            Some(r) if r > R::ZERO && r.is_finite() && (R::ONE / r).is_finite() => Ok(R::ONE / r),
            Some(_) => Err(GrindingError::BadParameter(field)),
        };
        Ok([
            curvature(self.rim, Field::RRim)?,
            curvature(self.crown, Field::RCrown)?,
        ])
    }
}

/// A wheel pressed on parts of any curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hertz<R> {
    force: R,
    e_star: R,
    /// Of the wheel, along and across.
    curvatures: [R; 2],
}

/// The ellipse of contact. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<R> {
    /// Principal relative curvatures [1/mm].
    pub k_max: R,
    pub k_min: R,
    /// Semi-axes, a >= b; a along k_min.
    pub a: R,
    pub b: R,
    /// Half extent across the feed.
    pub b_c: R,
    /// Half extent along the feed; a row must run past its end by as much to reach full depth there.
    pub a_f: R,
    /// Largest pressure [MPa].
    pub p0: R,
    /// By how much the bodies come nearer.
    pub approach: R,
    /// cos and sin of 2 psi.
    double: [R; 2],
}

impl<R: Real> Contact<R> {
    /// Direction of k_max from the feed [rad], (-pi/2, pi/2]; it is an axis.
    pub fn psi(&self) -> R {
        let [cos, sin] = self.double;
        sin.atan2(cos) * R::HALF
    }

    /// The contact within a wheel of this half width [mm], which must hold it.
    pub fn within(self, half_width: R) -> Result<Self, GrindingError<R>> {
        if !(half_width > R::ZERO && half_width.is_finite()) {
            return Err(GrindingError::BadParameter(Field::HalfWidth));
        }
        if self.b_c > half_width {
            return Err(GrindingError::FootprintTooLarge {
                b_c: self.b_c,
                half_width,
            });
        }
        Ok(self)
    }
}

impl<R: Real> Hertz<R> {
    /// A wheel pressed with `force` [N], `e_star` [MPa] from [`effective_modulus`].
    pub fn new(force: R, e_star: R, wheel: &Wheel<R>) -> Result<Self, GrindingError<R>> {
        let curvatures = wheel.curvatures()?;
        if !(force > R::ZERO && force.is_finite()) {
            return Err(GrindingError::BadParameter(Field::Force));
        }
        if !(e_star > R::ZERO && e_star.is_finite()) {
            return Err(GrindingError::BadMaterial(Field::E1));
        }
        Ok(Self {
            force,
            e_star,
            curvatures,
        })
    }

    pub fn force(&self) -> R {
        self.force
    }

    pub fn e_star(&self) -> R {
        self.e_star
    }

    /// Relative curvature across the feed, k_c + t_c [1/mm].
    pub fn across(&self, k_c: R) -> R {
        k_c + self.curvatures[1]
    }

    /// Whether the ellipse is small beside the bodies, as Hertz assumes: both half extents below a tenth of the smallest
    /// radius in play. Reported; it refuses nothing.
    pub fn is_small(&self, contact: &Contact<R>, k_f: R, k_c: R) -> bool {
        let [t_f, t_c] = self.curvatures;
        let sharpest = t_f.max(t_c).max(k_f.abs()).max(k_c.abs());
        contact.b_c.max(contact.a_f) * sharpest < R::of(0.1)
    }

    /// The contact where the part has these curvatures.
    pub fn on(&self, section: &Section<R>) -> Result<Contact<R>, GrindingError<R>> {
        self.at(section.k_f, section.k_c, section.tau)
    }

    /// The contact at curvatures along and across the feed and twist `tau` [1/mm].
    pub fn at(&self, k_f: R, k_c: R, tau: R) -> Result<Contact<R>, GrindingError<R>> {
        for (value, field) in [(k_f, Field::KF), (k_c, Field::KC), (tau, Field::Tau)] {
            if !value.is_finite() {
                return Err(GrindingError::BadParameter(field));
            }
        }
        let (m11, m22) = (k_f + self.curvatures[0], k_c + self.curvatures[1]);
        let middle = (m11 + m22) * R::HALF;
        let lean = (m11 - m22) * R::HALF;
        // Not hypot: in f32 that one computes in double precision, which the target has only in software.
        let spread = (lean * lean + tau * tau).sqrt();
        let k_max = middle + spread;
        // By the determinant: middle - spread would lose the small one beside the large one.
        let k_min = if k_max > R::ZERO {
            (m11 * m22 - tau * tau) / k_max
        } else {
            middle - spread
        };
        // Curvatures whose products overflow are those of no body.
        if !(k_min.is_finite() && k_max.is_finite()) {
            return Err(GrindingError::BadParameter(Field::KF));
        }
        if k_min <= R::ZERO {
            return Err(GrindingError::NoHertzContact { least: k_min });
        }
        let ratio = (k_max / k_min).max(R::ONE);
        if ratio > R::of(1e6) {
            return Err(GrindingError::LineContact { ratio });
        }

        let ellipse = Ellipse::solve(ratio);
        let b = cube_root(self.force * ellipse.r_d() / (R::PI * self.e_star * k_min));
        let a = b * ellipse.kappa;
        let load = R::of(1.5) * self.force / R::PI;

        let double = if spread > R::ZERO {
            [lean / spread, tau / spread]
        } else {
            [R::ONE, R::ZERO]
        };
        // cos^2 and sin^2 of psi; the smaller one not as a difference from one.
        let [cos, sin] = double;
        let large = (R::ONE + cos.abs()) * R::HALF;
        let small = sin * sin / (R::of(4.0) * large);
        let (cos2, sin2) = if cos >= R::ZERO {
            (large, small)
        } else {
            (small, large)
        };
        let (a2, b2) = (a * a, b * b);
        Ok(Contact {
            k_max,
            k_min,
            a,
            b,
            b_c: (b2 * sin2 + a2 * cos2).sqrt(),
            a_f: (b2 * cos2 + a2 * sin2).sqrt(),
            p0: load / (a * b),
            approach: load * ellipse.r_f() / (self.e_star * b),
            double,
        })
    }
}

/// Of a positive number: by logarithm, polished once. `libm::cbrtf` computes in double precision.
fn cube_root<R: Real>(x: R) -> R {
    let root = (x.ln() * R::of(1.0 / 3.0)).exp();
    let square = root * root;
    root - (root - x / square) * R::of(1.0 / 3.0)
}
