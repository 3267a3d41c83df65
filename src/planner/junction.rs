//! What happens at a vertex: a hat through whole blocks, a narrow zone, a corner, or a stop.
//!
//! ```text
//!  tolerance e, turn D = |u2 - u1| (weighted):  deviation d D / 6 <= e   =>   d <= 6 e / D,  and d <= both blocks
//!
//!  wide     d is at least half of the longer block     vertices are control points of one B-spline; ramps run through
//!  narrow   d up to half of the shorter block, D small  a zone of +-d: ramps run through
//!  corner   D large                                     rounded in time, at a speed of its own (`corner.rs`)
//!  stop     tolerance 0, and where nothing is sooner
//! ```

use super::block::{self, Block};
use super::corner::{self, Corner};
use super::limits::Scaled;
use super::look_ahead::lesser;
use super::ramp::Slack;
use crate::math::Real;

/// Deviation that is none: a thousandth of a step of the coarsest joint.
const NOTHING: f32 = 1.0e-3;
/// A wide blend in a sharp turn must save this share of the time, for the other ends of its blocks are guessed.
const WIDE_DOUBT: f32 = 0.45;
/// Turn from which a corner is a way back, about 177 degrees.
pub(super) const REVERSAL: f32 = 1.9993;
/// Turn above which a hat through whole blocks is not looked at, about 74 degrees.
const SHARPEST: f32 = 1.2;
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

/// Decides the vertex at the start of `block`: sets `d`, `z`, `corner`. `further`: the direction before `before`; `room`: how
/// much of the end of `before` is still free.
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
    block.corner = Corner::STOP;
    if block.stop {
        return;
    }
    // Nothing else is rounded in the window of a corner.
    let room = lesser(room, before.length - before.corner.calm);
    let turn = turn(weight, &before.u, &block.u);
    let tolerance = before.tolerance.min(block.tolerance);
    let deviation = 6.0 * tolerance.max(NOTHING);
    let (l1, l2) = (before.length, block.length);
    let shorter = l1.min(l2);
    let mut d = shorter.min(room);
    if d * turn > deviation {
        d = deviation / turn;
    }
    if d >= 0.5 * l1.max(l2) && turn <= GENTLE {
        block.d = d;
        return;
    }
    let narrow = d.min(0.5 * shorter).min(room);
    if turn <= GENTLE {
        // A tolerance of zero rounds nothing but what is straight already.
        let exact = tolerance <= 0.0 && narrow < 0.25 * shorter.min(room);
        if !(exact || narrow < 1.0e-4 * shorter || narrow < 1.0e-6) {
            block.d = narrow;
            block.z = narrow;
        }
        return;
    }
    // A way back reaches its point.
    let inside = if turn > REVERSAL {
        0.0
    } else {
        tolerance + block.outside
    };
    let (corner, time) = corner::passage(scaled, further, before, block, turn, inside, room);
    if d >= 0.5 * l1.max(l2) && turn <= SHARPEST {
        block.d = d;
        if held_time(scaled, further, before, block) < time[0] * (1.0 - WIDE_DOUBT) {
            return;
        }
        block.d = 0.0;
    }
    block.corner = corner;
}

/// Whether the turn from `before` to `block` is no corner.
pub(super) fn is_gentle<const N: usize>(
    weight: &[f32; N],
    before: &Block<N>,
    block: &Block<N>,
) -> bool {
    turn(weight, &before.u, &block.u) <= GENTLE
}

/// Limits of the zone at the start of `block`; a narrow one has a small turn, and ramps run through it.
pub(super) fn set_zone<const N: usize>(
    scaled: &Scaled<N>,
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &mut Block<N>,
    after: Option<&Block<N>>,
) {
    if block.z <= 0.0 {
        let through = block.d > 0.0;
        block.zone.length = 0.0;
        block.zone.v = if through {
            f32::INFINITY
        } else {
            block.corner.v
        };
        block.zone.slack = Slack::ANY;
        block.zone.through = through;
        return;
    }
    let limit = block::zone(scaled, further, before, block, after);
    block.zone.limit(2.0 * block.z, limit, true);
}

/// Time of both blocks where the hat between them holds its speed [ms]; where the next one turns back, its third derivative doubles.
fn held_time<const N: usize>(
    scaled: &Scaled<N>,
    further: Option<&[f32; N]>,
    before: &Block<N>,
    block: &Block<N>,
) -> f32 {
    let zone = block::zone(scaled, further, before, block, None);
    let v = 0.79 * zone.v;
    before.length / v.min(before.nominal) + block.length / v.min(block.nominal)
}
