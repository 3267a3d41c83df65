//! From one speed to another without a jump of acceleration: distance, and its inverses.
//!
//! ```text
//!  a ^    _________           dv <= a^2/j:  t1 = sqrt(dv/j), t2 = 0        (the peak stays below a)
//!    |   /         \          else          t1 = a/j,        t2 = dv/a - t1
//!    |  /           \
//!    +--+--+------+--+--> t   time     2 t1 + t2
//!       t1    t2    t1        distance (v1 + v2)/2 * time                  (the profile is point symmetric)
//! ```
//!
//! A ramp that begins or ends at a corner takes at least the corner's own time for t1, its *rise* (`corner.rs`).
//!
//! Both ends are at zero acceleration, so a ramp may follow any other. For a straight move the chain *up, cruise, down* is
//! the time-optimal jerk-limited profile, at every length. Units: any length, ms.

use super::corner::Corner;
use super::look_ahead::{greater, lesser};
use crate::math::Real;

/// What a ramp may do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steep {
    pub a: f32,
    pub j: f32,
    /// Shortest time in which its acceleration builds up, and goes.
    pub rise: f32,
}

impl Steep {
    pub fn new(a: f32, j: f32, rise: f32) -> Self {
        // An acceleration that is reached within the rise limits the jerk.
        let j = if j * rise > a { a / rise } else { j };
        Self { a, j, rise }
    }

    /// Times `(t1, t2)` of a change of speed by `dv >= 0`.
    pub fn times(&self, dv: f32) -> (f32, f32) {
        let &Self { a, j, rise } = self;
        if dv * j <= a * a {
            let t1 = Real::sqrt(dv / j);
            (greater(t1, rise), 0.0)
        } else {
            let t1 = a / j;
            (t1, dv / a - t1)
        }
    }

    /// Time of a change of speed by `dv >= 0`.
    pub fn time(&self, dv: f32) -> f32 {
        let (t1, t2) = self.times(dv);
        2.0 * t1 + t2
    }

    /// Distance that a ramp from `v1` to `v2`, or back, takes.
    pub fn distance(&self, v1: f32, v2: f32) -> f32 {
        let dv = Real::abs(v2 - v1);
        if dv <= 0.0 {
            return 0.0;
        }
        0.5 * (v1 + v2) * self.time(dv)
    }

    /// The highest speed from which a ramp reaches `w` within `dist`.
    pub fn fastest(&self, dist: f32, w: f32) -> f32 {
        let &Self { a, j, rise } = self;
        if dist <= 0.0 {
            return w;
        }
        if rise > 0.0 {
            let dv = dist / rise - 2.0 * w;
            if dv <= j * rise * rise {
                return w + greater(dv, 0.0) * (1.0 - 1.0e-6);
            }
        }
        let rise = a / j;
        let dv = if dist <= (2.0 * w + a * rise) * rise {
            // x = sqrt(dv): x^3 + 2 w x = q. Newton from above on a convex function never passes the root.
            let q = dist * Real::sqrt(j);
            let p = 2.0 * w;
            let mut x = Real::cbrt(q);
            if q < x * p {
                x = q / p;
            }
            for _ in 0..3 {
                let square = x * x;
                x = (2.0 * square * x + q) / (3.0 * square + p);
            }
            x * x
        } else {
            // dv^2/(2a) + b dv = c, in the form that does not cancel.
            let b = w / a + 0.5 * rise;
            let c = dist - w * rise;
            2.0 * c / (b + Real::sqrt(b * b + 2.0 * c / a))
        };
        w + dv * (1.0 - 1.0e-6)
    }

    /// The lowest speed that a ramp from `v` reaches within `dist`.
    pub fn slowest(&self, dist: f32, v: f32) -> f32 {
        if self.distance(v, 0.0) <= dist {
            return 0.0;
        }
        // The distance has a maximum over the end speed: search from above, where it is monotone.
        let (mut hi, mut step) = (v, 0.5 * v);
        for _ in 0..12 {
            let trial = hi - step;
            if trial >= 0.0 && self.distance(v, trial) <= dist {
                hi = trial;
            }
            step *= 0.5;
        }
        hi
    }
}

/// Where a ramp up begins and what comes behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Climb {
    /// Way up and down together.
    pub way: f32,
    /// Speed now, at the end, and never to be exceeded.
    pub from: f32,
    pub to: f32,
    pub cap: f32,
    pub up: Steep,
    pub down: Steep,
    /// The corner at the end: where no ramp down leads there, its window is crossed at constant speed.
    pub corner: Option<Corner>,
}

impl Climb {
    fn taken(&self, p: f32) -> f32 {
        let behind = if p > self.to {
            self.down.distance(p, self.to)
        } else {
            self.corner.map_or(0.0, |c| c.calm_at(p))
        };
        self.up.distance(self.from, p) + behind
    }

    /// The highest speed to which a ramp may lead so that another still reaches the end (or is not needed); the speed now
    /// when nothing higher fits.
    pub fn peak(&self) -> f32 {
        let (v, cap) = (self.from, self.cap);
        if cap <= v {
            return v;
        }
        // Room for rounding: the ramp down is started by its exact distance.
        let dist = self.way * (1.0 - 4.0e-6);
        if self.taken(cap) <= dist {
            return cap;
        }
        let (mut lo, mut hi) = (v, cap);
        let (mut at_lo, mut at_hi) = (self.taken(v) - dist, self.taken(cap) - dist);
        if at_lo > 0.0 {
            return v;
        }
        if self.to > v && self.to < cap {
            // The calm way ends with it.
            let at = self.taken(self.to) - dist;
            if at > 0.0 {
                (hi, at_hi) = (self.to, at);
            } else {
                let next = self.to * (1.0 + 1.0e-6);
                let at = self.taken(next) - dist;
                if at > 0.0 {
                    return self.to;
                }
                (lo, at_lo) = (next, at);
            }
        }
        // Illinois: false position that halves the weight of an end which stays.
        let mut side = 0;
        for _ in 0..14 {
            let mut p = (lo * at_hi - hi * at_lo) / (at_hi - at_lo);
            if !(p > lo && p < hi) {
                p = 0.5 * (lo + hi);
            }
            let excess = self.taken(p) - dist;
            if excess > 0.0 {
                hi = p;
                at_hi = excess;
                if side == 1 {
                    at_lo *= 0.5;
                }
                side = 1;
            } else {
                lo = p;
                at_lo = excess;
                if side == -1 {
                    at_hi *= 0.5;
                }
                side = -1;
                if excess > -1.0e-4 * dist {
                    break;
                }
            }
        }
        lo
    }
}

/// What a span leaves to ramps, by the highest speed of the ramp: `1/a` and `1/j` as straight lines over its square. Both
/// curves are convex (`1/j` within a hundredth), so between rest and the span's own speed limit that is the safe side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slack {
    /// `1/a = a.0 + a.1 v^2`
    pub a: (f32, f32),
    /// `1/j = j.0 + j.1 v^2`
    pub j: (f32, f32),
}

impl Slack {
    pub const ANY: Self = Self {
        a: (0.0, 0.0),
        j: (0.0, 0.0),
    };

    pub fn at(&self, top: f32, rise: f32) -> Steep {
        let a = 1.0 / (self.a.0 + self.a.1 * top * top);
        // A rise of less than a sixteenth of a sample is none (and keeps the integers of profile.rs in range).
        let j = lesser(1.0 / (self.j.0 + self.j.1 * top * top), 16.0 * a);
        Steep::new(a, j, rise)
    }

    /// What both leave.
    pub fn and(&self, other: &Self) -> Self {
        Self {
            a: (greater(self.a.0, other.a.0), greater(self.a.1, other.a.1)),
            j: (greater(self.j.0, other.j.0), greater(self.j.1, other.j.1)),
        }
    }
}
