//! Angles that count their turns, and the travel of an axis.
//!
//! A plain f32 angle of ten turns is worth 2 um at a radius of 500 mm, so an angle is kept as whole turns and a
//! remainder. Sines and cosines see the remainder only.

use super::Error;
use crate::math::Real;

/// An angle as `turns` whole turns and a remainder in (-pi, pi] [rad].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turned<R> {
    pub turns: i32,
    pub angle: R,
}

impl<R: Real> Turned<R> {
    /// Splits a total angle [rad]. Beyond 2^31 turns the count saturates.
    pub fn from_total(total: R) -> Self {
        let turns = ((total - R::PI) / R::TAU).ceil();
        Self {
            turns: turns.to_i32(),
            angle: wrap(total - turns * R::TAU),
        }
    }

    /// The whole angle [rad].
    pub fn total(self) -> R {
        self.angle + R::TAU * R::of_i32(self.turns)
    }

    /// `self - other` [rad], exact in the turns.
    pub fn minus(self, other: Self) -> R {
        let turns = self.turns.saturating_sub(other.turns);
        (self.angle - other.angle) + R::TAU * R::of_i32(turns)
    }
}

/// An angle in (-2 pi, 2 pi] brought to (-pi, pi].
pub(super) fn wrap<R: Real>(angle: R) -> R {
    if angle > R::PI {
        angle - R::TAU
    } else if angle <= -R::PI {
        angle + R::TAU
    } else {
        angle
    }
}

/// The travel of one axis, ends included [mm or rad]; infinite ends mean no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel<R> {
    lo: R,
    hi: R,
    /// `lo` and `hi` widened by their own rounding: 180 deg in radians must admit pi, in f32 as well.
    least: R,
    most: R,
    is_limited: bool,
}

impl<R: Real> Travel<R> {
    /// From `limits` [mm or rad]; `None` is no limit. `field` names it in the error: NonFinite, BadLimit.
    pub fn new(limits: Option<[R; 2]>, field: &'static str) -> Result<Self, Error<R>> {
        let Some([lo, hi]) = limits else {
            let (lo, hi) = (-R::INFINITY, R::INFINITY);
            return Ok(Self {
                lo,
                hi,
                least: lo,
                most: hi,
                is_limited: false,
            });
        };
        if !lo.is_finite() || !hi.is_finite() {
            return Err(Error::NonFinite { field });
        }
        if lo > hi {
            return Err(Error::BadLimit { field });
        }
        let slack = |end: R| R::of(8.0) * R::EPSILON * end.abs().max(R::ONE);
        Ok(Self {
            lo,
            hi,
            least: lo - slack(lo),
            most: hi + slack(hi),
            is_limited: true,
        })
    }

    pub fn lo(&self) -> R {
        self.lo
    }

    pub fn hi(&self) -> R {
        self.hi
    }

    pub fn is_limited(&self) -> bool {
        self.is_limited
    }

    /// Whether `x` is within the travel, rounding of the ends allowed.
    pub fn holds(&self, x: R) -> bool {
        x >= self.least && x <= self.most
    }

    /// Of `angle` + whole turns the one nearest to `near` within the travel; `None` if there is none.
    /// `angle` in (-pi, pi]. When two are equally near, `angle` with the turns of `near`.
    pub fn nearest(&self, angle: R, near: Turned<R>) -> Option<Turned<R>> {
        let ahead = angle - near.angle;
        let by = if ahead > R::PI {
            -1
        } else if ahead < -R::PI {
            1
        } else {
            0
        };
        let found = Turned {
            turns: near.turns.saturating_add(by),
            angle,
        };
        if !self.is_limited {
            return Some(found);
        }
        let total = found.total();
        if self.holds(total) {
            return Some(self.within(found, total));
        }
        // The nearest inside is the outermost on the side that was left.
        let turns = if total > self.most {
            ((self.most - angle) / R::TAU).floor()
        } else {
            ((self.least - angle) / R::TAU).ceil()
        };
        let found = Turned {
            turns: turns.to_i32(),
            angle,
        };
        let total = found.total();
        self.holds(total).then(|| self.within(found, total))
    }

    /// Every representative within a limited travel, from the least up, but only `most` about `near` where there are
    /// more; for an unlimited travel the nearest to `near`.
    pub(super) fn all(
        &self,
        angle: R,
        near: Turned<R>,
        most: i32,
    ) -> impl Iterator<Item = Turned<R>> + '_ {
        let (first, count) = if self.is_limited {
            let lowest = ((self.least - angle) / R::TAU).ceil().to_i32();
            let highest = ((self.most - angle) / R::TAU).floor().to_i32();
            let count = highest.saturating_sub(lowest).saturating_add(1).max(0);
            let middle = near.turns.saturating_sub(most / 2);
            let first = middle.clamp(lowest, highest.saturating_sub(most - 1).max(lowest));
            (first, count.min(most))
        } else {
            (self.nearest(angle, near).map_or(near.turns, |t| t.turns), 1)
        };
        (0..count).filter_map(move |i| {
            let found = Turned {
                turns: first.saturating_add(i),
                angle,
            };
            let total = found.total();
            self.holds(total).then(|| self.within(found, total))
        })
    }

    /// `angle` held to the travel.
    pub fn clamp(&self, angle: Turned<R>) -> Turned<R> {
        let total = angle.total();
        if total < self.lo {
            Turned::from_total(self.lo)
        } else if total > self.hi {
            Turned::from_total(self.hi)
        } else {
            angle
        }
    }

    /// Takes off what `found` exceeds the true ends by, within their rounding.
    fn within(&self, found: Turned<R>, total: R) -> Turned<R> {
        let excess = total - total.clamp(self.lo, self.hi);
        Turned {
            turns: found.turns,
            angle: found.angle - excess,
        }
    }
}
