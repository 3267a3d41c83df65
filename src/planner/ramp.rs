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
//! Both ends are at zero acceleration, so a ramp may follow any other. For a straight move the chain *up, cruise, down* is
//! the time-optimal jerk-limited profile, at every length. Units: any length, ms.

use crate::math::Real;

/// Times `(t1, t2)` of a change of speed by `dv >= 0`.
pub(super) fn times(dv: f32, a: f32, j: f32) -> (f32, f32) {
    if dv * j <= a * a {
        (Real::sqrt(dv / j), 0.0)
    } else {
        let t1 = a / j;
        (t1, dv / a - t1)
    }
}

/// Distance that a ramp from `v1` to `v2`, or back, takes.
pub(super) fn distance(v1: f32, v2: f32, a: f32, j: f32) -> f32 {
    let dv = Real::abs(v2 - v1);
    if dv <= 0.0 {
        return 0.0;
    }
    let (t1, t2) = times(dv, a, j);
    0.5 * (v1 + v2) * (2.0 * t1 + t2)
}

/// The highest speed from which a ramp reaches `w` within `dist`.
pub(super) fn fastest(dist: f32, w: f32, a: f32, j: f32) -> f32 {
    if dist <= 0.0 {
        return w;
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
pub(super) fn slowest(dist: f32, v: f32, a: f32, j: f32) -> f32 {
    if distance(v, 0.0, a, j) <= dist {
        return 0.0;
    }
    // The distance has a maximum over the end speed: search from above, where it is monotone.
    let (mut hi, mut step) = (v, 0.5 * v);
    for _ in 0..12 {
        let trial = hi - step;
        if trial >= 0.0 && distance(v, trial, a, j) <= dist {
            hi = trial;
        }
        step *= 0.5;
    }
    hi
}

/// The highest speed up to `cap` to which a ramp from `v` may lead so that another still reaches `w` (or is not needed)
/// within `dist`; `v` itself when nothing higher fits.
pub(super) fn peak(dist: f32, v: f32, w: f32, cap: f32, a: f32, j: f32) -> f32 {
    if cap <= v {
        return v;
    }
    let taken = |p: f32| distance(v, p, a, j) + if p > w { distance(p, w, a, j) } else { 0.0 };
    // Room for rounding: the ramp down is started by its exact distance.
    let dist = dist * (1.0 - 4.0e-6);
    if taken(cap) <= dist {
        return cap;
    }
    let (mut lo, mut hi) = (v, cap);
    let (mut at_lo, mut at_hi) = (taken(v) - dist, taken(cap) - dist);
    if at_lo > 0.0 {
        return v;
    }
    // Illinois: false position that halves the weight of an end which stays.
    let mut side = 0;
    for _ in 0..14 {
        let mut p = (lo * at_hi - hi * at_lo) / (at_hi - at_lo);
        if !(p > lo && p < hi) {
            p = 0.5 * (lo + hi);
        }
        let excess = taken(p) - dist;
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
