//! What happens at a vertex: a hat through whole blocks, a narrow zone, or a stop.
//!
//! ```text
//!  tolerance e, turn D = |u2 - u1| (weighted):  deviation d D / 6 <= e   =>   d <= 6 e / D,  and d <= both blocks
//!
//!  wide     d is at least half of the longer block     vertices are control points of one B-spline; ramps run through
//!  narrow   d up to half of the shorter block          a zone of +-d: ramps run through where D is small, else the
//!                                                      speed is constant there
//!  stop     d = 0                                      tolerance 0, reversals, and corners that a stop passes sooner
//! ```

use super::block::{self, Block, SHARP, SMOOTH};
use super::limits::Scaled;
use super::ramp;
use crate::math::Real;

/// Deviation that is none: a thousandth of a step of the coarsest joint.
const NOTHING: f32 = 1.0e-3;
/// A narrow blend and a wide one must save this share of the time, for the other ends of their blocks are guessed.
const DOUBT: f32 = 0.005;
const WIDE_DOUBT: f32 = 0.25;
/// Turn up to which ramps run through a narrow zone, about 17 degrees.
const GENTLE: f32 = 0.3;

/// Weighted length of the difference of two directions.
pub(super) fn turn<const N: usize>(weight: &[f32; N], a: &[f32; N], b: &[f32; N]) -> f32 {
    let mut sum = 0.0f32;
    for i in 0..N {
        let d = (b[i] - a[i]) * weight[i];
        sum += d * d;
    }
    Real::sqrt(sum)
}

/// Decides the vertex at the start of `block`: sets `d`, `z`. `room`: how much of the end of `before` is still free.
pub(super) fn decide<const N: usize>(
    scaled: &Scaled<N>,
    weight: &[f32; N],
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &mut Block<N>,
    room: f32,
) {
    block.d = 0.0;
    block.z = 0.0;
    if block.stop {
        return;
    }
    let turn = turn(weight, &before.u, &block.u);
    let tolerance = before.tolerance.min(block.tolerance);
    let deviation = 6.0 * tolerance.max(NOTHING);
    let (l1, l2) = (before.length, block.length);
    let shorter = l1.min(l2);
    let mut d = shorter.min(room);
    if d * turn > deviation {
        d = deviation / turn;
    }
    if d >= 0.5 * l1.max(l2) {
        block.d = d;
        if turn <= GENTLE || !stop_is_sooner(scaled, further, before, block) {
            return;
        }
        block.d = 0.0;
    }
    d = d.min(0.5 * shorter).min(room);
    // A tolerance of zero rounds nothing but what is straight already.
    let exact = tolerance <= 0.0 && d < 0.25 * shorter.min(room);
    if exact || d < 1.0e-4 * shorter || d < 1.0e-6 {
        return;
    }
    block.d = d;
    block.z = d;
    if turn > GENTLE && stop_is_sooner(scaled, further, before, block) {
        block.d = 0.0;
        block.z = 0.0;
    }
}

/// Split of the limits in the zone at the start of `block`.
pub(super) fn is_gentle<const N: usize>(
    weight: &[f32; N],
    before: &Block<N>,
    block: &Block<N>,
) -> bool {
    turn(weight, &before.u, &block.u) <= GENTLE
}

/// Limits of the zone at the start of `block`, and whether ramps run through it.
pub(super) fn set_zone<const N: usize>(
    scaled: &Scaled<N>,
    weight: &[f32; N],
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &mut Block<N>,
    after: Option<&Block<N>>,
) {
    if block.z <= 0.0 {
        let through = block.d > 0.0;
        block.zone.length = 0.0;
        block.zone.v = if through { f32::INFINITY } else { 0.0 };
        block.zone.a = f32::INFINITY;
        block.zone.j = f32::INFINITY;
        block.zone.through = through;
        return;
    }
    let gentle = is_gentle(weight, before, block);
    let split = if gentle { SMOOTH } else { SHARP };
    let limit = block::zone(scaled, further, before, block, after, split);
    block.zone.limit(2.0 * block.z, limit, gentle);
}

/// Whether stopping at the exact corner takes less time than its blend at constant speed, from the middle of one block
/// to the middle of the other. A wide hat holds the speed of both halves; where the next one turns back, its third
/// derivative doubles.
fn stop_is_sooner<const N: usize>(
    scaled: &Scaled<N>,
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &Block<N>,
) -> bool {
    let wide = block.is_wide();
    let split = if wide { SMOOTH } else { SHARP };
    let mut zone = block::zone(scaled, further, before, block, None, split);
    if wide {
        zone.v *= 0.79;
    }
    let doubt = if wide { WIDE_DOUBT } else { DOUBT };
    let mut gain = 0.0;
    for side in [before, block] {
        // Straight, as if its other end were alike.
        let straight = Block { d: 0.0, ..*side };
        let limit = block::body(scaled, None, &straight, None);
        let top = side.nominal.min(limit.v);
        let slow = zone.v.min(top);
        let time = |from: f32, way: f32| {
            let v = ramp::fastest(way, from, limit.a, limit.j).min(top);
            let (t1, t2) = ramp::times(v - from, limit.a, limit.j);
            let ramped = ramp::distance(from, v, limit.a, limit.j);
            2.0 * t1 + t2 + (way - ramped).max(0.0) / v.max(1.0e-12)
        };
        let half = 0.5 * side.length;
        let held = if wide { half } else { block.d };
        let stopping = time(0.0, half);
        gain += stopping * (1.0 - doubt) - time(slow, half - held) - held / slow;
    }
    gain <= 0.0
}
