//! Preston: what one pass of an ellipse takes away.
//!
//! dh = k p v dt with the half-ellipsoid pressure of Hertz, integrated along the feed for an ellipse at any angle, is
//! exactly a parabola:
//!
//! ```text
//!   h(y) = h0 (1 - y^2/b_c^2),   h0 = (3/4) K F / b_c,   K = 1e6 k v / v_w [1/MPa],   v = v_s + sense v_w
//! ```
//!
//! Its area (4/3) b_c h0 = K F does not depend on curvature: a hollow gets a wide shallow stripe, a bulge a narrow deep one.
//! Source: the paper's equations 1, 2, 9 to 11, integrated here for any angle.

use super::{Field, GrindingError};
use crate::math::Real;

/// Whether the rim runs against the feed, with it, or the feed is neglected beside the rim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sense {
    Against,
    With,
    #[default]
    Neglected,
}

impl Sense {
    fn factor<R: Real>(self) -> R {
        match self {
            Sense::Against => R::ONE,
            Sense::With => -R::ONE,
            Sense::Neglected => R::ZERO,
        }
    }
}

/// A wheel turning and moving over the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Removal<R> {
    /// Rim speed v_s [mm/s].
    pub rim_speed: R,
    /// Speed of the rim over the part, v [mm/s].
    pub speed: R,
    /// K [1/MPa]
    pub k_mpa: R,
    /// 1e6 k [1/MPa]
    preston: R,
    sense: Sense,
    force: R,
}

/// What one row takes away: h0 (1 - y^2/b_c^2) for |y| < b_c. All in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripe<R> {
    /// Half its width.
    pub b_c: R,
    /// Its depth in the middle.
    pub h0: R,
}

impl<R: Real> Stripe<R> {
    /// Depth at the distance `y` from the middle.
    pub fn depth(&self, y: R) -> R {
        if y.abs() < self.b_c {
            let share = y / self.b_c;
            self.h0 * (R::ONE - share * share)
        } else {
            R::ZERO
        }
    }

    /// Conformity: curvature of the groove over relative curvature across, `across` = k_c + t_c [1/mm]; `None` if that is 0.
    /// Hertz with Preston describes one pass only up to about 1; it is reported and stops nothing.
    pub fn conformity(&self, across: R) -> Option<R> {
        let chi = R::TWO * self.h0 / (self.b_c * self.b_c) / across;
        chi.is_finite().then_some(chi)
    }
}

impl<R: Real> Removal<R> {
    /// `k` is Preston's coefficient [1/Pa], `rpm` turns a minute of a wheel of `rim` [mm], `feed` v_w [mm/s], `force` [N].
    pub fn new(
        force: R,
        k: R,
        rim: R,
        rpm: R,
        feed: R,
        sense: Sense,
    ) -> Result<Self, GrindingError<R>> {
        for (value, field) in [
            (force, Field::Force),
            (k, Field::K),
            (rim, Field::RRim),
            (rpm, Field::Rpm),
            (feed, Field::Feed),
        ] {
            if !(value > R::ZERO && value.is_finite()) {
                return Err(GrindingError::BadParameter(field));
            }
        }
        let rim_speed = R::TAU * rim * rpm / R::of(60.0);
        let speed = rim_speed + sense.factor::<R>() * feed;
        let preston = R::of(1e6) * k;
        let k_mpa = preston * speed / feed;
        if !(speed > R::ZERO && k_mpa.is_finite()) {
            return Err(GrindingError::BadParameter(Field::Feed));
        }
        Ok(Self {
            rim_speed,
            speed,
            k_mpa,
            preston,
            sense,
            force,
        })
    }

    /// The stripe of a contact that is `b_c` [mm] wide to each side.
    pub fn stripe(&self, b_c: R) -> Stripe<R> {
        Stripe {
            b_c,
            h0: R::of(0.75) * self.area() / b_c,
        }
    }

    /// Section of any stripe, K F [mm2].
    pub fn area(&self) -> R {
        self.k_mpa * self.force
    }

    /// The feed [mm/s] at which one pass is `depth` [mm] deep.
    pub fn feed_for(&self, b_c: R, depth: R) -> Result<R, GrindingError<R>> {
        let c = R::of(0.75) * self.preston * self.force / b_c;
        let feed = c * self.rim_speed / (depth - c * self.sense.factor());
        if depth > R::ZERO && feed > R::ZERO && feed.is_finite() {
            Ok(feed)
        } else {
            Err(GrindingError::BadParameter(Field::TargetDepth))
        }
    }

    /// Equal passes that reach `depth` [mm] at about the feed given, and the feed [mm/s] of each: n = ceil(depth/h0).
    pub fn passes(&self, b_c: R, depth: R) -> Result<(i32, R), GrindingError<R>> {
        // Checks depth.
        self.feed_for(b_c, depth)?;
        let ratio = (depth / self.stripe(b_c).h0).ceil();
        if ratio >= R::of(1e9) {
            return Err(GrindingError::BadParameter(Field::TargetDepth));
        }
        let passes = ratio.to_i32().max(1);
        let feed = self.feed_for(b_c, depth / R::of_i32(passes))?;
        Ok((passes, feed))
    }
}
