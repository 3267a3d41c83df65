//! Sharp corners: passed at a speed, rounded in time.
//!
//! ```text
//!   q(t) = polygon(s(t)) + v du r(t - t_k)           r(t) = (T - |t|)^3 / (6 T^2) for |t| < T, else 0
//!
//!   u1 ----->.        the polygon is passed at speed v with no acceleration; its jump of velocity v du, du = u2 - u1, is
//!             \       spread over the window +-T by a triangle of area 1:
//!          r > \         acceleration  v du / T at the most        jerk  -+ v du / T^2       deviation  |v du| T / 6
//!               v u2
//! ```
//!
//! Ramps run right up to the corner and away from it; in the window they add `j u1` before and `j u2` behind. Where a joint
//! turns back these have the sign that its own rounding lacks, so that a reversal carries its acceleration through the
//! standstill. What makes that safe: within the window a ramp's acceleration only goes (before the corner) or only comes
//! (behind it), so ramps that end or begin at a corner take at least T for that (their *rise*), and where none does, the speed
//! is constant. Time and speed are tied: with `K` the jerk left for rounding, `T = sqrt(v D / K)`, so that a corner passed more
//! slowly than planned deviates less.
//!
//! The polygon's vertex may lie outside of the programmed one by as much as the rounding stays inside of it: the
//! tolerance is then used on both sides. Motion within a window is not changed by hold or override: they wait for its end.

use super::block::Block;
use super::limits::Scaled;
use super::look_ahead::{greater, lesser};
use super::ramp::{Climb, Steep};
use crate::math::Real;

/// A corner's bond between speed and time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// `T = max(sqrt(v D / K), v R)`: turn over jerk left to rounding [ms^3 / length], turn over acceleration [ms^2 / length].
    by_jerk: f32,
    by_acceleration: f32,
    /// Highest speed; 0: a stop.
    pub v: f32,
    /// Way of its window before and behind it, at its highest speed.
    pub calm: f32,
    /// T at the speed of entry that the look-ahead has found [ms].
    pub rise: f32,
    /// What its ramps may use of the jerk.
    pub share: f32,
}

/// Shares of the jerk that ramps at a corner may use: what is left is for rounding.
const SHARES: [f32; 3] = [1.0, 0.8, 0.6];
/// Two windows within a sample would add up in it [ms].
const SHORTEST: f32 = 0.7;
/// Room for rounding of numbers and for time in whole samples.
const SPARE: f32 = 0.985;
/// A corner passed must save this share of the time of a stop, for the other ends of its blocks are guessed.
const DOUBT: f32 = 0.002;

impl Corner {
    pub const STOP: Self = Self {
        by_jerk: 0.0,
        by_acceleration: 0.0,
        v: 0.0,
        calm: 0.0,
        rise: 0.0,
        share: 1.0,
    };

    pub fn is_passed(&self) -> bool {
        self.v > 0.0
    }

    /// Way of its window before or behind it at constant speed v.
    pub fn calm_at(&self, v: f32) -> f32 {
        v * self.time(v)
    }

    /// How far the rounding stays inside of the polygon at its highest speed.
    pub fn deviation(&self, turn: f32) -> f32 {
        self.v * turn * self.time(self.v) * (1.0 / 6.0)
    }

    /// T for a passage at speed v [ms].
    pub fn time(&self, v: f32) -> f32 {
        greater(
            greater(Real::sqrt(v * self.by_jerk), v * self.by_acceleration),
            SHORTEST,
        )
    }
}

/// A straight block, for guesses of its time.
struct Leg {
    way: f32,
    a: f32,
    j: f32,
    top: f32,
}

impl Leg {
    /// With speed `v` at both ends, and ramps of a given rise.
    fn alike(&self, v: f32, rise: f32, share: f32) -> f32 {
        let steep = Steep::new(self.a, self.j * share, rise);
        let half = 0.5 * self.way;
        let p = lesser(steep.fastest(half, v), self.top);
        let ramp = if p > v { steep.time(p - v) } else { 0.0 };
        2.0 * (ramp + greater(half - steep.distance(v, p), 0.0) / greater(p, 1.0e-12))
    }

    /// From rest to the speed of a corner, through whose window no ramp up leads.
    fn after_stop(&self, corner: &Corner, rise: f32) -> f32 {
        let (v, share) = (corner.v, corner.share);
        let up = Steep::new(self.a, self.j * share, 0.0);
        let down = Steep::new(self.a, self.j * share, rise);
        let climb = Climb {
            way: self.way,
            from: 0.0,
            to: v,
            cap: self.top,
            up,
            down,
            corner: Some(*corner),
        };
        let p = climb.peak();
        let lower = lesser(v, p);
        let ramps = up.time(p) + if p > v { down.time(p - v) } else { 0.0 };
        let ramped = up.distance(0.0, p) + down.distance(p, lower);
        ramps + greater(self.way - ramped, 0.0) / greater(p, 1.0e-12)
    }
}

/// The passage from `before` to `block`, and its time from the middle of one to the middle of the other; a stop where that is
/// as soon. `further`: the direction before `before`; `turn`: weighted length of `du`; `deviation`: how far the rounding may
/// stay inside of the polygon; `room`: how much of the end of `before` is free.
pub(super) fn passage<const N: usize>(
    scaled: &Scaled<N>,
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &Block<N>,
    turn: f32,
    deviation: f32,
    room: f32,
) -> (Corner, [f32; 2]) {
    let straight = |u: &[f32; N]| {
        let (mut a, mut j, mut v) = (0.0f32, 0.0f32, 0.0f32);
        for i in 0..N {
            let m = Real::abs(u[i]);
            v = greater(v, m * scaled.inverse_v[i]);
            a = greater(a, m * scaled.inverse_a[i]);
            j = greater(j, m * scaled.inverse_j[i]);
        }
        (1.0 / v, a, j)
    };
    let (v1, a1, j1) = straight(&before.u);
    let (v2, a2, j2) = straight(&block.u);
    let half1 = lesser(0.5 * before.length, room);
    let half2 = 0.5 * block.length;
    let (top1, top2) = (lesser(before.nominal, v1), lesser(block.nominal, v2));
    let leg1 = Leg {
        way: before.length,
        a: 1.0 / a1,
        j: 1.0 / j1,
        top: top1,
    };
    let leg2 = Leg {
        way: block.length,
        a: 1.0 / a2,
        j: 1.0 / j2,
        top: top2,
    };
    // Twice the half that ends at the corner, as if the other end were alike; and as if that were a stop.
    let stopping = [leg1.alike(0.0, 0.0, 1.0) + leg2.alike(0.0, 0.0, 1.0); 2];
    let mut best = stopping.map(|t| t * (1.0 - DOUBT));
    let mut found = Corner::STOP;
    if deviation <= 0.0 || turn <= 0.0 {
        return (found, best);
    }
    let per_turn = 1.0 / turn;
    // The rounding of the vertex before may reach into the window: its share of each joint's jerk.
    let mut busy = [0.0f32; N];
    for share in SHARES {
        for _ in 0..2 {
            // Jerk left to rounding along du / D, and acceleration.
            let (mut least_k, mut least_a) = (0.0f32, 0.0f32);
            for i in 0..N {
                let n = (block.u[i] - before.u[i]) * per_turn;
                let m = Real::abs(n) * scaled.inverse_j[i];
                // J u1 + K n before, J u2 - K n behind, with as little as no ramp.
                let used = |u: f32, leg: f32, same: bool| match same {
                    true => Real::abs(u) * share / leg * scaled.inverse_j[i],
                    false => 0.0,
                };
                let used1 = used(before.u[i], j1, before.u[i] * n > 0.0);
                let used2 = used(block.u[i], j2, block.u[i] * n < 0.0);
                let left = SPARE - greater(used1 + busy[i], used2);
                if m > 0.0 {
                    least_k = greater(least_k, m / greater(left, 1.0e-3));
                    least_a = greater(least_a, Real::abs(n) * scaled.inverse_a[i]);
                }
            }
            let mut corner = Corner {
                by_jerk: turn * least_k,
                by_acceleration: turn * least_a / SPARE,
                share,
                ..Corner::STOP
            };
            // Deviation v D T / 6: v^(3/2) D^(3/2) / (6 sqrt K), or v^2 D^2 / (6 A).
            let six = 6.0 * deviation;
            let mut v = Real::cbrt(six * six / least_k) * per_turn;
            v = lesser(v, Real::sqrt(six / (turn * corner.by_acceleration)));
            v = lesser(v, lesser(top1, top2));
            // The window's way, v T + J T^3 / 6, within half of each block.
            let jerk = greater(share / j1, share / j2);
            let most = 0.98 * lesser(half1, half2);
            let window = |v: f32| {
                let t = corner.time(v);
                (t, t * (v + jerk * t * t * (1.0 / 6.0)))
            };
            for _ in 0..4 {
                let (_, way) = window(v);
                if way <= most {
                    break;
                }
                // It grows with v^(3/2) to v^2.
                v *= Real::cbrt(Real::squared(most / way)) * 0.98;
            }
            let (t, way) = window(v);
            if way > most {
                break;
            }
            if let Some(further) = further.filter(|_| before.is_wide() && busy[0] <= 0.0) {
                let reach = way - (before.length - before.d);
                if reach > 0.0 {
                    let (w, a) = (v + 0.5 * jerk * t * t, jerk * t);
                    let by = w * (w * w + 3.0 * a * reach) / Real::squared(before.d);
                    for i in 0..N {
                        let du = Real::abs(before.u[i] - further[i]);
                        busy[i] = du * by * scaled.inverse_j[i];
                    }
                    continue;
                }
            }
            corner.v = v;
            corner.calm = way;
            let passing = [
                leg1.alike(v, t, share) + leg2.alike(v, t, share),
                leg1.after_stop(&corner, t) + leg2.after_stop(&corner, t),
            ];
            if passing[0] < best[0] && passing[1] < best[1] {
                best = passing;
                found = corner;
            }
            break;
        }
    }
    (found, best)
}
