//! A straight joint-space move, and what every joint allows along it.
//!
//! ```text
//!            zone of vertex k        body of block k        zone of vertex k+1
//!  --- block k-1 ---|-------------|---------------------|-----------|--- block k+1 ---
//!                   -z     V_k   +z                     -z'  V_k+1  +z'
//! ```
//!
//! The path is the polygon through the vertices, rounded in *path length* by one cubic B-spline kernel at each vertex:
//! with unit directions `u`, turn `du = u_k - u_{k-1}` and half-width `d`,
//!
//! ```text
//!  q'' (s) = sum over k of  du_k * hat_d(s - S_k)          hat_d: triangle of half-width d and area 1
//!  q   (s) = V_k + u_k x + du_k r_d(x) + du_{k+1} r_d'(L - x)      r_d(x) = (d - x)^3 / (6 d^2) for x < d, else 0
//! ```
//!
//! One vertex alone gives the blend of the table in motion.md (control points at -2d, -d, 0, d, 2d); equal chords with
//! `d` = chord give the uniform cubic B-spline with the vertices as control points; a straight line stays straight and
//! evenly run whatever its vertices. `d` never exceeds the shorter neighbour, so no more than two hats overlap.
//!
//! Lengths `s` weigh each joint by its tip-equivalent [one unit = a step of the joint with the largest weight]; times
//! are ms. A span's limits keep, for every joint with `m1, m2, m3` the largest `|q'|, |q''|, |q'''|` in it,
//! `v m1 <= v_i`, `v^2 m2 + A m1 <= a_i`, `v^3 m3 + 3 v A m2 + J m1 <= j_i` (motion.md, rule 2).

use super::corner::Corner;
use super::limits::Scaled;
use super::look_ahead::{greater, lesser};
use super::ramp::{Slack, Steep};
use crate::math::Real;

/// A stretch of path with one set of limits, and what the look-ahead knows of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Length; 0 where two hats meet and there is nothing between.
    pub length: f32,
    /// Hard speed limit from all joints.
    pub v: f32,
    pub slack: Slack,
    /// Whether a ramp may run on through both of its ends; else only one that begins within it.
    pub through: bool,
    /// Highest speed at its start, without acceleration, from which all that follows can be met.
    pub entry: f32,
    /// The ramp that `entry` stands for.
    pub root: Target,
}

/// Where a ramp that starts in a span may lead, and the least limits on the way there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    /// Spans ahead, and distance to its start.
    pub span: u16,
    pub way: f32,
    pub speed: f32,
    pub slack: Slack,
    /// Speed not to be exceeded on the way.
    pub cap: f32,
    /// What the ramp must take for its acceleration to come and go, where it ends at a corner.
    pub rise: f32,
}

impl Target {
    /// Limits of a ramp there.
    pub fn steep(&self) -> Steep {
        self.slack.at(self.cap, self.rise)
    }
}

impl Span {
    pub const NONE: Self = Self {
        length: 0.0,
        v: f32::INFINITY,
        slack: Slack::ANY,
        through: true,
        entry: 0.0,
        root: Target {
            span: 1,
            way: 0.0,
            speed: 0.0,
            slack: Slack::ANY,
            cap: 0.0,
            rise: 0.0,
        },
    };

    /// Without length, and no stop: nothing but the border of the bodies on both sides.
    pub fn is_border(&self) -> bool {
        self.length <= 0.0 && self.through && self.v == f32::INFINITY
    }

    pub fn limit(&mut self, length: f32, limit: Limit, through: bool) {
        self.length = length;
        self.v = limit.v;
        self.slack = limit.slack;
        self.through = through;
    }
}

/// A block in the ring. The vertex at its start belongs to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<const N: usize> {
    /// Position at the end [2^-32 step].
    pub end: [i64; N],
    /// Direction [steps per unit length].
    pub u: [f32; N],
    /// Length, and the same in units of 2^-32.
    pub length: f32,
    pub bits: i64,
    /// Least time [ms].
    pub duration: f32,
    /// Programmed speed [length/ms]; infinite for a rapid.
    pub nominal: f32,
    pub rapid: bool,
    /// Contour tolerance [length]: as set, and what of it rounding may use.
    pub asked: f32,
    pub tolerance: f32,
    /// Half-width of the hat at its start; 0: a corner.
    pub d: f32,
    /// Half-width of the zone around its start; 0 where the hat reaches into whole blocks.
    pub z: f32,
    /// How far the vertex at its start lies outside of the programmed one [length].
    pub outside: f32,
    /// The corner at its start, where there is no hat.
    pub corner: Corner,
    /// Standstill before it [ms].
    pub dwell: u32,
    /// Its start stays a stop, whatever follows.
    pub stop: bool,
    pub zone: Span,
    pub body: Span,
}

impl<const N: usize> Block<N> {
    pub const EMPTY: Self = Self {
        end: [0; N],
        u: [0.0; N],
        length: 0.0,
        bits: 0,
        duration: 0.0,
        nominal: 0.0,
        rapid: true,
        asked: 0.0,
        tolerance: 0.0,
        d: 0.0,
        z: 0.0,
        outside: 0.0,
        corner: Corner::STOP,
        dwell: 0,
        stop: false,
        zone: Span::NONE,
        body: Span::NONE,
    };

    /// Whether the hat at its start reaches through whole blocks.
    pub fn is_wide(&self) -> bool {
        self.d > 0.0 && self.z <= 0.0
    }
}

/// Derivatives of one joint along a span, as large as they get there.
#[derive(Clone, Copy, Default)]
struct Slopes {
    m1: f32,
    m2: f32,
    m3: f32,
    /// What comes to `|q'''|` where one of two hats is alone, for a stretch that may be far shorter than a sample.
    alone: f32,
}

/// How much of such a stretch a sample feels at speed v: `alone` counts `min(1, stretch (1/v + 1/length))` times. A third
/// difference is a mean over 3 ms, with a weight of 3/4 in its middle (and something on the safe side); shorter blocks bring one such stretch each.
#[derive(Clone, Copy)]
struct Short {
    stretch: f32,
    length: f32,
}

impl Short {
    const NONE: Self = Self {
        stretch: 0.0,
        length: 1.0,
    };

    fn felt(&self, v: f32) -> f32 {
        (self.stretch * (1.0 / v + 1.0 / self.length)).min(1.0)
    }
}

/// Highest speed along a span, and what that leaves to ramps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    pub v: f32,
    pub slack: Slack,
}

/// How much of acceleration and jerk the curvature may use up at the highest speed; the rest is for ramps.
#[derive(Clone, Copy)]
struct Split {
    a: f32,
    j: f32,
}

/// Where ramps run through: a ramp has its highest acceleration where it is far from its highest speed, so little need be
/// left for it there.
const SMOOTH: Split = Split { a: 0.96, j: 0.8 };

/// Ramps take at most that many times as long as on a straight line, if a little less speed can do it.
const MOST_TIME: f32 = 2.2;

/// What one joint asks of its limits along a span: `q'`, `q''`, `3 q''` and `q'''` over its acceleration or jerk.
#[derive(Clone, Copy, Default)]
struct Shares {
    along_a: f32,
    round_a: f32,
    along_j: f32,
    mixed_j: f32,
    round_j: f32,
    /// What a short stretch adds to `q'''`, which is felt the less the faster it is passed: over `v^2`.
    short_j: f32,
}

/// Speeds at the ends of a span that no ramp crosses; infinite where ramps do.
#[derive(Clone, Copy)]
struct Ends {
    start: f32,
    end: f32,
    length: f32,
    is_newest: bool,
}

impl Ends {
    const OPEN: Self = Self {
        start: f32::INFINITY,
        end: f32::INFINITY,
        length: 0.0,
        is_newest: false,
    };

    /// Highest speed in the span: `v + J t^2 / 2` with `J t^3 / 6` no more than its length. `slow_j`: 1/J.
    fn reach(&self, slow_j: f32) -> f32 {
        let v = lesser(self.start, self.end);
        if v < f32::INFINITY {
            v + 1.651 * Real::cbrt(Real::squared(self.length) / slow_j)
        } else {
            v
        }
    }
}

/// Speed limit of a span, and what it leaves to every ramp in it that leads to that speed or a lower one.
///
/// ```text
///  near its upper end, y before it, a ramp has   a = J y,   v = V - J y^2 / 2      (y up to A / J)
///  to be kept there                              v^2 q'' + a q' <= a_i,    v^3 q''' + 3 v a q'' + J q' <= j_i
/// ```
///
/// A ramp to a lower speed, and the lower half of each, have less speed at the same acceleration.
fn limit<const N: usize>(
    scaled: &Scaled<N>,
    slopes: &[Slopes; N],
    short: Short,
    spare: f32,
    ends: Ends,
) -> Limit {
    let split = SMOOTH;
    let (mut r1, mut r2, mut r3) = (0.0f32, 0.0f32, 0.0f32);
    let mut r4 = 0.0f32;
    for (i, s) in slopes.iter().enumerate() {
        r1 = greater(r1, s.m1 * scaled.inverse_v[i]);
        r2 = greater(r2, s.m2 * scaled.inverse_a[i]);
        r3 = greater(r3, s.m3 * scaled.inverse_j[i]);
        r4 = greater(r4, s.alone * scaled.inverse_j[i]);
    }
    let most = 1.0 / r1;
    let mut v = most;
    if v * v * r2 > split.a {
        v = Real::sqrt(split.a / r2);
    }
    if v * v * v * r3 > split.j {
        v = Real::cbrt(split.j / r3);
    }
    let felt = v * v * v * r4 * short.felt(v);
    if felt > split.j {
        // The share felt falls with v^2 at the least, and with v^3 when all is felt.
        let less = v * Real::sqrt(split.j / felt);
        v = less.max(Real::cbrt(split.j / r4).min(v));
    }
    let felt = short.felt(v);
    let mut r3 = 0.0f32;
    for (i, s) in slopes.iter().enumerate() {
        r3 = greater(r3, (s.m3 + s.alone * felt) * scaled.inverse_j[i]);
    }
    let used = v * v * v * r3;
    if used > split.j {
        v *= Real::sqrt(split.j / used);
    }
    let felt = short.felt(v);
    let mut shares = [Shares::default(); N];
    let (mut slow_a, mut slow_j, mut slower_j) = (0.0f32, 0.0f32, 0.0f32);
    for (i, s) in slopes.iter().enumerate() {
        slow_j = greater(slow_j, s.m1 * scaled.inverse_j[i] / spare);
    }
    // Next to a stop or a corner no ramp is faster than this when it leaves the span, whatever its highest speed.
    let reach = ends.reach(slow_j);
    let near = reach < v && r2 > 0.0;
    if near {
        v = reach;
    }
    for (i, s) in slopes.iter().enumerate() {
        let inverse_j = scaled.inverse_j[i];
        let share = Shares {
            along_a: s.m1 * scaled.inverse_a[i],
            round_a: s.m2 * scaled.inverse_a[i],
            along_j: s.m1 * inverse_j / spare,
            mixed_j: 3.0 * s.m2 * inverse_j,
            round_j: s.m3 * inverse_j,
            short_j: s.alone * felt * v * inverse_j,
        };
        slow_a = greater(slow_a, share.along_a);
        slower_j = greater(
            slower_j,
            share.along_j / (1.0 - v * v * (v * share.round_j + share.short_j)),
        );
        shares[i] = share;
    }
    let mut slack = Slack {
        a: (slow_a, 0.0),
        j: (slow_j, 0.0),
    };
    if r2 > 0.0 {
        // The newest block changes with the next one: what it leaves is not looked for, only bounded.
        let (mut a, mut j) = if ends.is_newest {
            at_once(&shares, v)
        } else {
            ramps(&shares, v, 1.0 / slow_a, 1.0 / slower_j)
        };
        // Speed is worth little where it leaves nothing to get there.
        for _ in 0..3 {
            let straight = Steep::new(1.0 / slow_a, 1.0 / slow_j, 0.0);
            let slower = Steep::new(a, j, 0.0);
            if near || ends.is_newest || slower.time(v) < MOST_TIME * straight.time(v) {
                break;
            }
            v *= 0.96;
            (a, j) = ramps(&shares, v, 1.0 / slow_a, 1.0 / slow_j);
        }
        if near {
            slack.a.0 = 1.0 / a;
            slack.j.0 = 1.0 / j;
            v = most;
        } else {
            slack.a.1 = (1.0 / a - slow_a) / (v * v);
            slack.j.1 = (1.0 / j - slow_j) / (v * v);
        }
    }
    Limit { v, slack }
}

/// Acceleration and jerk, `a` and `j` at most, of ramps up to speed `v` where the path turns.
///
/// A ramp that is all jerk has `a = p sqrt(v J)` and `w = v (1 - p^2 / 2)` at the share p of its rise, so each joint bounds
/// `sqrt(J)` there by a line and a parabola. One that holds its acceleration from p on asks for no more behind, and
/// takes `(p + 1/p) sqrt(v / J)`.
fn ramps<const N: usize>(shares: &[Shares; N], v: f32, a: f32, j: f32) -> (f32, f32) {
    let mut x = Real::sqrt(j);
    let root = Real::sqrt(v);
    let (mut best, mut chosen) = (f32::INFINITY, (a, j));
    for (p, time) in RISE {
        let w = v * (1.0 - 0.5 * p * p);
        let along = p * root;
        for s in shares {
            if s.along_a > 0.0 {
                let left = 1.0 - w * (w * s.round_a);
                if along * x * s.along_a > left {
                    x = left / (along * s.along_a);
                }
            }
            let left = 1.0 - w * w * (w * s.round_j + s.short_j);
            let mixed = along * w * s.mixed_j;
            if x * (mixed + x * s.along_j) > left {
                // Newton, from above on a convex function: what it may leave is far below the room taken.
                for _ in 0..2 {
                    x = (s.along_j * x * x + left) / (2.0 * s.along_j * x + mixed);
                }
                x *= 0.998;
            }
        }
        if time < best * x {
            best = time / x;
            chosen = (lesser(a, along * x), x * x);
        }
    }
    chosen
}

/// The same as if the acceleration came at the highest speed.
fn at_once<const N: usize>(shares: &[Shares; N], v: f32) -> (f32, f32) {
    let (mut slow_a, mut slow_j) = (0.0f32, 0.0f32);
    for s in shares {
        slow_a = greater(slow_a, s.along_a / (1.0 - v * v * s.round_a));
        // Half of what the curvature leaves of the jerk goes to 3 v A q''.
        let left = 1.0 - v * v * (v * s.round_j + s.short_j);
        slow_a = greater(slow_a, 2.0 * v * s.mixed_j / left);
    }
    let a = 1.0 / slow_a;
    for s in shares {
        let left = 1.0 - v * v * (v * s.round_j + s.short_j) - v * a * s.mixed_j;
        slow_j = greater(slow_j, s.along_j / left);
    }
    (a, 1.0 / slow_j)
}

/// Shares of a rise at which limits are looked at, and `p + 1/p` where an acceleration may be held.
const RISE: [(f32, f32); 4] = [(0.25, 4.25), (0.5, 2.5), (0.75, 2.0833), (1.0, 2.0)];

fn middle(a: f32, b: f32) -> f32 {
    0.5 * Real::abs(a + b)
}

/// What may come behind the newest block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Last {
    /// Another one: its limits are only bounded.
    Provisional,
    /// Nothing.
    Complete,
}

/// Limits of the body of `block`, between `before` and `after` where there are such.
pub(super) fn body<const N: usize>(
    scaled: &Scaled<N>,
    before: Option<&[f32; N]>,
    block: &Block<N>,
    after: Option<&Block<N>>,
    last: Last,
) -> Limit {
    let start = before.filter(|_| block.is_wide());
    let end = after.filter(|b| b.is_wide());
    let d = end.map_or(0.0, |b| b.d);
    let overlap = start.is_some() && end.is_some() && block.d + d > block.length;
    let mut short = Short::NONE;
    if overlap {
        short.stretch = 2.0 * block.length - d - block.d;
        short.length = block.length;
    }
    let mut slopes = [Slopes::default(); N];
    for (i, s) in slopes.iter_mut().enumerate() {
        let u = block.u[i];
        s.m1 = Real::abs(u);
        let (mut first, mut second) = (0.0, 0.0);
        if let Some(before) = start {
            s.m1 = Real::max(s.m1, middle(before[i], u));
            let curvature = (u - before[i]) / block.d;
            s.m2 = Real::abs(curvature);
            first = curvature / block.d;
        }
        if let Some(after) = end {
            s.m1 = Real::max(s.m1, middle(after.u[i], u));
            let curvature = (after.u[i] - u) / d;
            s.m2 = Real::max(s.m2, Real::abs(curvature));
            second = curvature / d;
        }
        if overlap {
            s.m3 = Real::abs(second - first);
            s.alone = Real::max(Real::max(Real::abs(first), Real::abs(second)) - s.m3, 0.0);
        } else {
            s.m3 = Real::max(Real::abs(first), Real::abs(second));
        }
    }
    // Corners at either end need some of the jerk.
    let share = after.map_or(1.0, |b| b.corner.share);
    let ends = Ends {
        start: if block.d > 0.0 {
            f32::INFINITY
        } else {
            block.corner.v
        },
        end: match after {
            Some(after) if after.d > 0.0 => f32::INFINITY,
            Some(after) => after.corner.v,
            None => 0.0,
        },
        length: block.length,
        is_newest: after.is_none() && last == Last::Provisional,
    };
    let spare = lesser(share, block.corner.share);
    limit(scaled, &slopes, short, spare, ends)
}

/// Limits of the zone at the start of `block`; `before` is the block before it (with the direction `further` before
/// that), `after` the one behind it.
pub(super) fn zone<const N: usize>(
    scaled: &Scaled<N>,
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &Block<N>,
    after: Option<&Block<N>>,
) -> Limit {
    let further = further.filter(|_| before.is_wide());
    let after = after.filter(|b| b.is_wide());
    let mut slopes = [Slopes::default(); N];
    for (i, s) in slopes.iter_mut().enumerate() {
        let (u0, u1) = (before.u[i], block.u[i]);
        s.m1 = Real::max(Real::abs(u0), Real::abs(u1));
        let curvature = Real::abs(u1 - u0) / block.d;
        s.m2 = curvature;
        s.m3 = curvature / block.d;
        // Hats of the neighbours that reach in from either side; a sum bounds them all.
        if let Some(further) = further {
            s.m1 = Real::max(s.m1, middle(further[i], u0));
            let curvature = Real::abs(u0 - further[i]) / before.d;
            s.m2 = Real::max(s.m2, curvature);
            s.m3 += curvature / before.d;
        }
        if let Some(after) = after {
            s.m1 = Real::max(s.m1, middle(after.u[i], u1));
            let curvature = Real::abs(after.u[i] - u1) / after.d;
            s.m2 = Real::max(s.m2, curvature);
            s.m3 += curvature / after.d;
        }
    }
    limit(scaled, &slopes, Short::NONE, 1.0, Ends::OPEN)
}
