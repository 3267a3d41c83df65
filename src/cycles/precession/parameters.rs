//! What a precession is made from, and the same checked and prepared.

use super::error::{Field, PrecessionError};
use super::spot::check_bonnet;
use super::turn::Turn;
use crate::geometry::Vector;
use crate::math::Real;

/// What drives the phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive<R> {
    /// Time: `rate` w2 [rad/s]; negative is clockwise seen from the spindle, 0 a constant lean.
    Time { rate: R },
    /// Distance: `pitch` [mm] of path for one turn, so that the texture does not depend on the feed; its sign is the sense.
    Distance { pitch: R },
}

/// How the reference direction `a`, from which the phase is counted, goes along the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Carried along with the normal without turning about it: the axis turns about the normal at exactly the set rate.
    Transport,
    /// The feed in the tangent plane (the paper's). At a corner the phase takes up the jump, so that the axis does not.
    FeedLocked,
}

/// Where the feed is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedAt {
    Contact,
    Centre,
}

/// On which side of the ball's centre the far point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FarEnd {
    Spindle,
    Surface,
}

/// Everything but the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<R> {
    /// Tilt between the axis and the normal [rad], 0 ..= 85 deg.
    pub theta: R,
    /// Rb [mm], greater than 0.
    pub bonnet_radius: R,
    /// Inward offset h [mm], 0 .. Rb.
    pub inward: R,
    /// v [mm/s], greater than 0.
    pub feed: R,
    pub feed_at: FeedAt,
    pub drive: Drive<R>,
    /// Phase at the first point [rad].
    pub alpha0: R,
    pub reference: Reference,
    /// First reference direction, any length; `None`: that of the first move.
    pub first_reference: Option<Vector<R>>,
    /// Distance from the ball's centre of the point whose chord error is bounded [mm], at least 0.
    pub ell: R,
    pub far_end: FarEnd,
    /// Chord tolerance at the far point [mm], greater than 0.
    pub eps: R,
    /// Largest turn of the axis in one step [rad], greater than 0.
    pub dpsi: R,
    /// Largest time of one step [s], greater than 0.
    pub dt_max: R,
    /// Speed at which the normal turns on the spot [rad/s], greater than 0.
    pub w_rot: R,
    /// Time at a path of a single point [s], greater than 0 there.
    pub dwell: R,
}

impl<R: Real> Default for Parameters<R> {
    /// The paper's plane where it gives figures: 20 deg, 5 mm/s, 5 turns a minute, 127 mm.
    fn default() -> Self {
        let degrees = |x: f64| R::of(x).to_radians();
        Self {
            theta: degrees(20.0),
            bonnet_radius: R::of(40.0),
            inward: R::HALF,
            feed: R::of(5.0),
            feed_at: FeedAt::Contact,
            drive: Drive::Time {
                rate: degrees(30.0),
            },
            alpha0: R::ZERO,
            reference: Reference::Transport,
            first_reference: None,
            ell: R::of(127.0),
            far_end: FarEnd::Spindle,
            eps: R::of(0.01),
            dpsi: degrees(5.0),
            dt_max: R::HALF,
            w_rot: degrees(20.0),
            dwell: R::ZERO,
        }
    }
}

impl<R: Real> Parameters<R> {
    /// The rows of the validation table that concern single numbers, from top to bottom, but for finiteness.
    pub(super) fn check_ranges(&self) -> Result<(), PrecessionError> {
        if !(self.theta >= R::ZERO && self.theta <= R::of(85.0).to_radians()) {
            return Err(PrecessionError::BadTilt);
        }
        check_bonnet(self.bonnet_radius, self.inward)?;
        if !(self.feed.is_finite() && self.feed > R::ZERO) {
            return Err(PrecessionError::BadFeedRate);
        }
        match self.drive {
            Drive::Time { rate } if !rate.is_finite() => return Err(PrecessionError::BadRate),
            Drive::Distance { pitch } if !pitch.is_finite() || pitch == R::ZERO => {
                return Err(PrecessionError::BadPitch);
            }
            _ => {}
        }
        let limits = [
            (Field::Eps, self.eps > R::ZERO),
            (Field::Dpsi, self.dpsi > R::ZERO),
            (Field::DtMax, self.dt_max > R::ZERO),
            (Field::WRot, self.w_rot > R::ZERO),
            (Field::Ell, self.ell >= R::ZERO),
        ];
        match limits.iter().find(|(_, good)| !good) {
            Some((field, _)) => Err(PrecessionError::BadLimit(*field)),
            None => Ok(()),
        }
    }

    pub(super) fn check_finite(&self) -> Result<(), PrecessionError> {
        let numbers = [
            (Field::BonnetRadius, self.bonnet_radius),
            (Field::Inward, self.inward),
            (Field::Eps, self.eps),
            (Field::Dpsi, self.dpsi),
            (Field::DtMax, self.dt_max),
            (Field::WRot, self.w_rot),
            (Field::Ell, self.ell),
            (Field::Dwell, self.dwell),
            (Field::Alpha0, self.alpha0),
        ];
        let number = numbers.iter().find(|(_, x)| !x.is_finite());
        let reference = self.first_reference.filter(|v| !v.is_finite());
        match number
            .map(|(field, _)| *field)
            .or(reference.map(|_| Field::Ref))
        {
            Some(field) => Err(PrecessionError::NonFinite { field, index: None }),
            None => Ok(()),
        }
    }
}

/// Checked parameters with what every pose needs of them. Nothing that uses them can fail for their sake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Process<R> {
    /// Sine and cosine of theta.
    pub(super) tilt: (R, R),
    /// Distance from the surface to the ball's centre [mm].
    pub(super) rho: R,
    pub(super) feed: R,
    pub(super) feed_at: FeedAt,
    pub(super) drive: Drive<R>,
    pub(super) phase: Turn,
    pub(super) reference: Reference,
    pub(super) first_reference: Option<Vector<R>>,
    /// The far point's distance along P [mm], with its sign.
    pub(super) reach: R,
    pub(super) eps: R,
    pub(super) dpsi: R,
    pub(super) dt_max: R,
    pub(super) w_rot: R,
    pub(super) dwell: R,
}

impl<R: Real> Process<R> {
    /// Checks the parameters in the order of the validation table: `BadTilt`, `BadBonnet`, `BadFeedRate`, `BadRate` or
    /// `BadPitch`, `BadLimit`, `NonFinite`. The dwell is looked at when a path turns out to be a single point.
    pub fn new(parameters: &Parameters<R>) -> Result<Self, PrecessionError> {
        parameters.check_ranges()?;
        parameters.check_finite()?;
        let p = parameters;
        Ok(Self {
            tilt: p.theta.sin_cos(),
            rho: p.bonnet_radius - p.inward,
            feed: p.feed,
            feed_at: p.feed_at,
            drive: p.drive,
            phase: Turn::of_radians(p.alpha0),
            reference: p.reference,
            first_reference: p.first_reference,
            reach: match p.far_end {
                FarEnd::Spindle => p.ell,
                FarEnd::Surface => -p.ell,
            },
            eps: p.eps,
            dpsi: p.dpsi,
            dt_max: p.dt_max,
            w_rot: p.w_rot,
            dwell: p.dwell,
        })
    }

    /// Into how many equal times a motion of `time` [s] is cut, while the phase turns at `wa` and the normal at `kd`
    /// [rad/s], so that the far point keeps to its chord tolerance and the axis to its step. Not yet rounded.
    ///
    /// The far point's acceleration is at most A, a chord of time dt strays by A dt^2 / 8, and the axis turns at most at
    /// |wa| sin theta + kd.
    pub(super) fn count(&self, time: R, wa: R, kd: R) -> R {
        let ((sin, cos), ell) = (self.tilt, self.reach.abs());
        let wa = wa.abs();
        let acceleration = (self.rho + ell * cos) * kd.squared() + ell * sin * (wa + kd).squared();
        let chord = time * (acceleration / (R::of(8.0) * self.eps)).sqrt();
        let axis = time * (wa * sin + kd) / self.dpsi;
        chord.max(axis).max(time / self.dt_max)
    }
}
