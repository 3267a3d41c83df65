//! Backward over the spans: the highest speed at which each may be entered so that all that follows can be met.
//!
//! ```text
//!  speed
//!    |-----------\                      entry of a span = the highest speed from which one ramp reaches its *root*:
//!    |            \        /--          the next place where speed is given (a corner, a slower stretch, the end)
//!    |             \______/
//!    +--|--|--|--|--|------|---> s      spans in between have no say of their own, so a ramp runs on through hundreds
//!       k  entry    root                of chords as through one line
//! ```
//!
//! Speeds at borders are meant without acceleration; a ramp to a root obeys the least limits on its way and never exceeds
//! any speed limit on its way, for it only slows down. The forward half is done as the path is run (`run.rs`): a ramp up is
//! as high as still leaves room for the ramp down to the next root.

use super::block::{Span, Target};
use super::ramp::Slack;
use super::ring::Ring;
use crate::math::Real;

/// The lesser of two numbers that are numbers: a comparison, where `f32::min` is a call on the target.
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The greater of two.
pub(super) fn greater(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Overrides as factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factors {
    pub feed: f32,
    pub rapid: f32,
}

impl Factors {
    pub const ONE: Self = Self {
        feed: 1.0,
        rapid: 1.0,
    };

    pub fn not_above(&self, other: &Self) -> bool {
        self.feed <= other.feed && self.rapid <= other.rapid
    }
}

/// Speed limit of span `i` under overrides.
pub(super) fn cap<const N: usize>(ring: &Ring<N>, i: usize, factors: &Factors) -> f32 {
    let Some(span) = ring.span(i) else { return 0.0 };
    let programmed = |k: usize| match ring.get(k) {
        // A rapid runs as fast as the joints allow; its override is a share of that.
        Some(block) if block.rapid => block.body.v * factors.rapid,
        Some(block) => block.nominal * factors.feed,
        None => f32::INFINITY,
    };
    let k = i / 2;
    if !i.is_multiple_of(2) {
        return lesser(span.v, programmed(k));
    }
    if span.length <= 0.0 {
        // A stop, a corner, or a border that limits nothing.
        return span.v;
    }
    let before = k.checked_sub(1).map_or(f32::INFINITY, programmed);
    let behind = ring.get(k).map_or(f32::INFINITY, |b| {
        if b.rapid {
            f32::INFINITY
        } else {
            b.nominal * factors.feed
        }
    });
    lesser(span.v, lesser(before, behind))
}

/// The spans from one on: what stands at its end.
struct Ahead<'a> {
    next: Option<&'a Span>,
    cap: f32,
    /// Rise of ramps that end at its start.
    rise: f32,
}

/// From `way` before the end of `span` (with speed limit `cap`) to the start of the next span, a corner where `rise` is
/// above zero.
pub(super) fn adjacent(span: &Span, way: f32, cap: f32, next: Option<&Span>, rise: f32) -> Target {
    Target {
        span: 1,
        way,
        speed: next.map_or(0.0, |n| n.entry),
        slack: span.slack,
        cap,
        rise,
    }
}

/// The same to the root of the next span, if a ramp may run through both and the next has no speed of its own.
pub(super) fn beyond(
    span: &Span,
    way: f32,
    cap: f32,
    next: Option<&Span>,
    next_cap: f32,
) -> Option<Target> {
    let next = next?;
    if !span.through || !next.through || next.entry >= next_cap {
        return None;
    }
    Some(Target {
        span: next.root.span + 1,
        way: way + next.root.way,
        speed: next.root.speed,
        slack: span.slack.and(&next.root.slack),
        cap: lesser(cap, next.root.cap),
        rise: next.root.rise,
    })
}

/// Plans all spans from the last down; those before `changed` only as far as anything changes.
pub(super) fn plan<const N: usize>(ring: &mut Ring<N>, factors: &Factors, changed: usize) {
    let mut ahead_cap = 0.0;
    for i in (0..2 * ring.len()).rev() {
        let Some(span) = ring.span(i) else {
            return;
        };
        let ahead = Ahead {
            next: ring.span(i + 1),
            cap: ahead_cap,
            rise: ring.corner_at(i + 1).map_or(0.0, |c| c.rise),
        };
        let (own, (entry, root)) = match ahead.next {
            Some(next) if span.is_border() => (f32::INFINITY, carried(next, ahead.cap)),
            _ => {
                let own = cap(ring, i, factors);
                // Behind a corner the speed stays for a while, or rises.
                let calm = match i.checked_sub(1) {
                    Some(start) => ring.corner_at(start).map_or(0.0, |c| c.calm),
                    None => 0.0,
                };
                let way = span.length - calm;
                (own, entry(span, way, i % 2 == 1, own, &ahead))
            }
        };
        if i < changed && span.entry == entry && span.root == root {
            return;
        }
        if let Some(span) = ring.span_mut(i) {
            span.entry = entry;
            span.root = root;
        }
        if let Some(corner) = ring.corner_at_mut(i) {
            corner.rise = corner.time(entry);
        }
        ahead_cap = own;
    }
}

/// A border between two bodies, where the path is round: what stands behind it stands before it.
fn carried(next: &Span, next_cap: f32) -> (f32, Target) {
    let mut root = if next.through && next.entry < next_cap {
        next.root
    } else {
        Target {
            span: 0,
            way: 0.0,
            speed: next.entry,
            slack: Slack::ANY,
            cap: f32::INFINITY,
            rise: 0.0,
        }
    };
    root.span += 1;
    (next.entry, root)
}

/// Highest speed at the start of `span`, `way` before the end of which a ramp may begin, and the ramp that it stands for.
fn entry(span: &Span, way: f32, is_body: bool, own: f32, ahead: &Ahead<'_>) -> (f32, Target) {
    let near = adjacent(span, way, own, ahead.next, ahead.rise);
    if !(span.through || is_body) {
        return (lesser(near.speed, own), near);
    }
    let far = || {
        let far = beyond(span, way, own, ahead.next, ahead.cap)?;
        Some((lesser(ramp_to(&far), far.cap), far))
    };
    // No ramp over this length gains more than this, which needs no root (ramp.rs: its time is at least 2 sqrt(dv/j)).
    let bound = near.speed + Real::squared(0.5 * way / near.speed) / span.slack.j.0;
    let first = if bound < own { far() } else { None };
    if let Some(found) = first
        && found.0 >= bound
    {
        return found;
    }
    let entry = lesser(ramp_to(&near), own);
    if entry >= own {
        return (entry, near);
    }
    let far = if first.is_some() { first } else { far() };
    far.filter(|(other, _)| *other > entry)
        .unwrap_or((entry, near))
}

fn ramp_to(target: &Target) -> f32 {
    if target.way <= 0.0 {
        return target.speed;
    }
    target.steep().fastest(target.way, target.speed)
}
