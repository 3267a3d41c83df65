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

use super::block::Span;
use super::ramp;
use super::ring::Ring;

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
        return span.v.min(programmed(k));
    }
    if span.length <= 0.0 {
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
    span.v.min(before).min(behind)
}

/// Where a ramp that starts in a span may lead, and within which limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    /// Spans ahead, and distance to its start.
    pub span: u16,
    pub way: f32,
    pub speed: f32,
    pub a: f32,
    pub j: f32,
    /// Speed not to be exceeded on the way.
    pub cap: f32,
}

/// From `way` before the end of `span` (with speed limit `cap`) to the start of the next span.
pub(super) fn adjacent(span: &Span, way: f32, cap: f32, next: Option<&Span>) -> Target {
    Target {
        span: 1,
        way,
        speed: next.map_or(0.0, |n| n.entry),
        a: span.a,
        j: span.j,
        cap,
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
        span: next.root + 1,
        way: way + next.root_way,
        speed: next.root_speed,
        a: span.a.min(next.root_a),
        j: span.j.min(next.root_j),
        cap: cap.min(next.root_cap),
    })
}

/// Plans spans from the last down to `first`; those before `changed` only as far as anything changes.
pub(super) fn plan<const N: usize>(
    ring: &mut Ring<N>,
    factors: &Factors,
    first: usize,
    changed: usize,
) {
    let mut next: Option<Span> = None;
    let mut next_cap = 0.0;
    for i in (first..2 * ring.len()).rev() {
        let own = cap(ring, i, factors);
        let Some(span) = ring.span_mut(i) else { return };
        let mut best = adjacent(span, span.length, own, next.as_ref());
        let mut entry = if span.through || i % 2 == 1 {
            ramp_to(&best).min(own)
        } else {
            best.speed.min(own)
        };
        if entry < own
            && let Some(far) = beyond(span, span.length, own, next.as_ref(), next_cap)
        {
            let other = ramp_to(&far).min(far.cap);
            if other > entry {
                entry = other;
                best = far;
            }
        }
        let planned = Span {
            entry,
            root: best.span,
            root_way: best.way,
            root_speed: best.speed,
            root_a: best.a,
            root_j: best.j,
            root_cap: best.cap,
            ..*span
        };
        let same = span.entry == entry
            && span.root == planned.root
            && span.root_way == planned.root_way
            && span.root_speed == planned.root_speed
            && span.root_a == planned.root_a
            && span.root_j == planned.root_j
            && span.root_cap == planned.root_cap;
        *span = planned;
        if same && i < changed {
            return;
        }
        next = Some(planned);
        next_cap = own;
    }
}

fn ramp_to(target: &Target) -> f32 {
    if target.way <= 0.0 {
        return target.speed;
    }
    ramp::fastest(target.way, target.speed, target.a, target.j)
}
