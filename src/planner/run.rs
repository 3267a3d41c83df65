//! Runs along the path: cruise, ramp up as far as the next ramp down allows, ramp down to the next root.
//!
//! ```text
//!             ease: acceleration goes first (push, hold, override)
//!           +-------------------------------+
//!           v                               |
//!  Rest -> decide -> Cruise -> event -> Ramp (3 phases) -> decide ...      event: end of span, or start of a ramp down
//! ```
//!
//! Decisions are taken without acceleration only. Taking a planned ramp down early is always safe; so are a ramp up that
//! ends early and any slowing that leaves the next planned ramp its room.

use super::block::{Span, Target};
use super::look_ahead::{self, Factors, adjacent, beyond, lesser};
use super::profile::{self, Ramp};
use super::ramp;
use super::ring::Ring;

/// A change of speed below this share is not worth a ramp.
const WORTH: f32 = 2.0e-3;
/// Length 2^-32 over speed 2^-48 per ms, as time 2^-20 ms.
const TIME: f32 = (1u64 << 36) as f32;
/// A limit passed by less than this factor is kept.
const USABLE: f32 = 1.002;
/// Events within one millisecond before the rest is left to the next one.
const MOST_EVENTS: usize = 400;
/// Lengths below this are none (2^-20).
const NEAR: i64 = 1 << 12;

#[derive(Clone, Copy, Debug)]
pub(super) enum Mode {
    Rest,
    /// Constant speed up to `until`; there a ramp starts, or another span.
    Cruise {
        until: i64,
        then: Option<Descent>,
    },
    Ramp(Ramp),
}

/// A ramp down to come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Descent {
    speed: f32,
    a: f32,
    j: f32,
}

/// What the runner is asked to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wish {
    Go,
    Halt,
}

/// What happened on the way.
pub(super) enum Passed {
    Nothing,
    /// The head block is over.
    Vertex,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Runner {
    /// Position in the head block [2^-32].
    pub x: i64,
    /// Speed while resting or cruising [2^-48 per ms].
    v: i64,
    pub mode: Mode,
    /// Ramps that had to be a hundredth steeper than the limits: never, unless limits or tolerance were changed under way.
    pub squeezed: u32,
}

/// The plan in force and the wanted overrides.
pub(super) struct Plan<'a, const N: usize> {
    pub ring: &'a Ring<N>,
    pub planned: &'a Factors,
    pub wanted: &'a Factors,
}

impl<const N: usize> Plan<'_, N> {
    fn cap(&self, i: usize) -> f32 {
        look_ahead::cap(self.ring, i, self.planned)
    }

    /// Position of the start of span `i` (or of the end of the path), from the start of the head.
    fn start(&self, i: usize) -> i64 {
        let mut sum = 0i64;
        for k in 0..i / 2 {
            sum += self.ring.get(k).map_or(0, |b| b.bits);
        }
        let z = self
            .ring
            .get(i / 2)
            .map_or(0, |b| profile::length_bits(b.z));
        if i.is_multiple_of(2) {
            sum - z
        } else {
            sum + z
        }
    }

    /// The span in which `x` lies; one that begins at `x` rather than one that ends there.
    fn locate(&self, x: i64) -> usize {
        let mut sum = 0i64;
        for k in 0..self.ring.len() {
            let Some(block) = self.ring.get(k) else { break };
            if x < sum + profile::length_bits(block.z) {
                return 2 * k;
            }
            sum += block.bits;
            let z = self
                .ring
                .get(k + 1)
                .map_or(0, |b| profile::length_bits(b.z));
            if x < sum - z || k + 1 == self.ring.len() {
                return 2 * k + 1;
            }
        }
        1
    }

    /// Where a ramp down may lead from `way` before the end of span `i`.
    fn targets(&self, i: usize, way: f32) -> (Option<Target>, Option<Target>) {
        let Some(span) = self.ring.span(i) else {
            return (None, None);
        };
        let next = self.ring.span(i + 1);
        let cap = self.cap(i);
        (
            Some(adjacent(span, way, cap, next)),
            beyond(span, way, cap, next, self.cap(i + 1)),
        )
    }

    /// The nearest span whose start a ramp from `v`, `way` before the end of span `i`, can reach at a speed fit for it.
    /// Roots know the best ramps from the borders of spans; this finds the others.
    fn descent(&self, i: usize, mut way: f32, v: f32) -> Option<Target> {
        let mut span = self.ring.span(i)?;
        let (mut a, mut j) = (span.a, span.j);
        for m in i + 1.. {
            let next = self.ring.span(m);
            let w = next.map_or(0.0, |n| n.entry);
            if v > w && ramp::distance(v, w, a, j) <= way {
                return Some(Target {
                    span: (m - i) as u16,
                    way,
                    speed: w,
                    a,
                    j,
                    cap: v,
                });
            }
            let next = next?;
            if !span.through || !next.through || v > next.v * 1.001 {
                return None;
            }
            a = lesser(a, next.a);
            j = lesser(j, next.j);
            way += next.length;
            span = next;
        }
        None
    }

    /// Whether speed `v` without acceleration at `x` leaves room for all that follows.
    pub fn is_feasible(&self, x: i64, v: f32) -> bool {
        let i = self.locate(x);
        if self.ring.span(i + 1).is_some_and(|n| v <= n.entry) {
            return true;
        }
        let way = profile::length_of(self.start(i + 1) - x);
        let (near, far) = self.targets(i, way);
        let by_root = [near, far.filter(|t| v <= t.cap * USABLE)]
            .into_iter()
            .flatten()
            .any(|t| v <= t.speed || ramp::distance(v, t.speed, t.a, t.j) <= t.way * 0.999);
        by_root || self.descent(i, way * 0.999, v).is_some()
    }
}

impl Runner {
    pub const fn new() -> Self {
        Self {
            x: 0,
            v: 0,
            mode: Mode::Rest,
            squeezed: 0,
        }
    }

    pub fn is_resting(&self) -> bool {
        matches!(self.mode, Mode::Rest)
    }

    /// Speed now [length/ms].
    pub fn speed(&self) -> f32 {
        profile::speed_of(match &self.mode {
            Mode::Ramp(ramp) => ramp.speed(),
            _ => self.v,
        })
    }

    pub fn rest_at(&mut self, x: i64) {
        self.x = x;
        self.v = 0;
        self.mode = Mode::Rest;
    }

    /// End of the ramp under way, if it slows down.
    pub fn descent_end(&self) -> Option<i64> {
        match &self.mode {
            Mode::Ramp(ramp) if ramp.slows() => Some(ramp.end()),
            _ => None,
        }
    }

    /// End of any ramp under way.
    pub fn ramp_end(&self) -> i64 {
        match &self.mode {
            Mode::Ramp(ramp) => ramp.end(),
            _ => self.x,
        }
    }

    /// Whether the motion under way (or `other`, in its place) keeps the limits and leaves room for all that follows.
    pub fn fits<const N: usize>(&self, plan: &Plan<'_, N>, other: Option<&Ramp>) -> bool {
        let ramp = match (&self.mode, other) {
            (_, Some(ramp)) => Some(ramp),
            (Mode::Ramp(ramp), None) => Some(ramp),
            _ => None,
        };
        let (end, speed) = match ramp {
            Some(ramp) => (ramp.end(), profile::speed_of(ramp.end_speed())),
            None => (self.x, self.speed()),
        };
        let most = self.speed().max(speed);
        // A ramp that ends on a border does not reach into what begins there.
        for i in plan.locate(self.x)..=plan.locate(end - 1) {
            let Some(span) = plan.ring.span(i) else { break };
            let within =
                ramp.is_none_or(|r| r.acceleration <= span.a * 1.001 && r.jerk <= span.j * 1.001);
            // A stop has no length; nor has a hat through whole blocks, which limits nothing by itself.
            let asks = span.length > 0.0 || span.v <= 0.0;
            if asks && (most > span.v * 1.001 || !within) {
                return false;
            }
        }
        speed <= 0.0 || plan.is_feasible(end, speed)
    }

    /// The first vertex before which the motion can come to rest within the limits, whatever lies behind it.
    pub fn safe_vertex<const N: usize>(&self, plan: &Plan<'_, N>) -> usize {
        if self.is_resting() && self.x == 0 {
            return 0;
        }
        let (x, mut v) = match &self.mode {
            Mode::Ramp(ramp) => (ramp.end(), profile::speed_of(ramp.end_speed())),
            _ => (self.x, self.speed()),
        };
        let mut i = plan.locate(x);
        let Some(mut span) = plan.ring.span(i) else {
            return plan.ring.len();
        };
        let (mut a, mut j) = (span.a, span.j);
        let mut way = profile::length_of(plan.start(i + 1) - x);
        // To some speed in between may take an eighth more than to rest.
        let to_rest = |v, a, j| ramp::distance(v, 0.0, a, j) * 1.125;
        let mut needed = to_rest(v, a, j);
        while needed > way {
            i += 1;
            let Some(next) = plan.ring.span(i) else {
                return plan.ring.len();
            };
            if span.through && next.through {
                way += next.length;
                if next.a < a || next.j < j {
                    (a, j) = (lesser(a, next.a), lesser(j, next.j));
                    needed = to_rest(v, a, j);
                }
            } else {
                v = lesser(v, next.entry);
                (a, j, way) = (next.a, next.j, next.length);
                needed = to_rest(v, a, j);
            }
            span = next;
        }
        i / 2 + 1
    }

    /// Whether a ramp up goes on for all of the next millisecond.
    pub fn rises_on(&self) -> bool {
        match &self.mode {
            Mode::Ramp(ramp) => !ramp.slows() && ramp.left() > profile::TICK,
            _ => false,
        }
    }

    /// Where the acceleration could be gone, and the speed there.
    pub fn eased(&self) -> Option<(Ramp, i64, f32)> {
        match &self.mode {
            Mode::Ramp(ramp) => {
                let eased = ramp.eased();
                Some((eased, eased.end(), profile::speed_of(eased.end_speed())))
            }
            _ => None,
        }
    }

    pub fn ease(&mut self) {
        if let Mode::Ramp(ramp) = &self.mode {
            self.mode = Mode::Ramp(ramp.eased());
        }
    }

    /// Runs on for at most `time`; returns the time left, which is above zero at rest or when a vertex was passed.
    pub fn advance<const N: usize>(
        &mut self,
        plan: &Plan<'_, N>,
        wish: Wish,
        mut time: u64,
    ) -> (u64, Passed) {
        for _ in 0..MOST_EVENTS {
            if time == 0 {
                break;
            }
            match self.mode {
                Mode::Rest => {
                    if wish == Wish::Halt {
                        return (time, Passed::Nothing);
                    }
                    self.decide(plan, wish);
                    if self.is_resting() {
                        return (time, self.passed(plan));
                    }
                }
                Mode::Cruise { until, then } => {
                    let left = until - self.x;
                    let needed = left as f32 / self.v.max(1) as f32 * TIME;
                    if left > 0 && needed >= time as f32 {
                        self.x += ((i128::from(self.v) * i128::from(time)) >> 36) as i64;
                        self.x = self.x.min(until);
                        time = 0;
                    } else {
                        if left > 0 {
                            time -= (needed as u64).min(time);
                            self.x = until;
                        }
                        match then {
                            Some(d) => {
                                self.ramp_to(d.speed, d.a, d.j);
                            }
                            None => {
                                if let Passed::Vertex = self.passed(plan) {
                                    return (time, Passed::Vertex);
                                }
                                self.decide(plan, wish);
                            }
                        }
                    }
                }
                Mode::Ramp(mut ramp) => {
                    let (over, left) = ramp.step(time);
                    time = left;
                    self.x = ramp.position();
                    if over {
                        self.v = ramp.end_speed();
                        self.mode = if self.v == 0 {
                            Mode::Rest
                        } else {
                            Mode::Cruise {
                                until: self.x,
                                then: None,
                            }
                        };
                    } else {
                        self.mode = Mode::Ramp(ramp);
                    }
                }
            }
            if let Passed::Vertex = self.passed(plan) {
                return (time, Passed::Vertex);
            }
        }
        (time, Passed::Nothing)
    }

    /// Whether the head block is over.
    fn passed<const N: usize>(&mut self, plan: &Plan<'_, N>) -> Passed {
        let Some(head) = plan.ring.get(0) else {
            return Passed::Nothing;
        };
        if self.is_resting() && self.x + NEAR > head.bits {
            self.x = head.bits;
        }
        if self.x < head.bits {
            return Passed::Nothing;
        }
        if plan.ring.len() == 1 && !self.is_resting() {
            if self.x == head.bits && matches!(self.mode, Mode::Ramp(_)) {
                return Passed::Nothing;
            }
            // Rounding of a ramp down may pass the end by a bit; nothing lies behind it.
            if self.v > 1 << 24 {
                self.squeezed = self.squeezed.wrapping_add(1);
            }
            if !matches!(self.mode, Mode::Ramp(_)) || self.x > head.bits + NEAR {
                self.rest_at(head.bits);
            } else {
                self.x = head.bits;
                return Passed::Nothing;
            }
        }
        Passed::Vertex
    }

    /// The head block has gone; positions count from the start of the next.
    pub fn leave(&mut self, bits: i64) {
        self.x -= bits;
        match &mut self.mode {
            Mode::Rest => self.x = 0,
            Mode::Cruise { until, .. } => *until -= bits,
            Mode::Ramp(ramp) => ramp.rebase(bits),
        }
    }

    fn ramp_to(&mut self, w: f32, a: f32, j: f32) {
        self.mode = Mode::Ramp(Ramp::new(self.x, self.v, profile::speed_bits(w), a, j));
    }

    fn cruise(&mut self, until: i64) {
        self.mode = Mode::Cruise { until, then: None };
    }

    /// Without acceleration: what next?
    pub fn decide<const N: usize>(&mut self, plan: &Plan<'_, N>, wish: Wish) {
        let i = plan.locate(self.x);
        let Some(span) = plan.ring.span(i) else {
            self.rest_at(self.x);
            return;
        };
        let v = profile::speed_of(self.v);
        let end = plan.start(i + 1);
        let way = profile::length_of(end - self.x);
        if wish == Wish::Halt {
            if self.v == 0 {
                self.mode = Mode::Rest;
            } else {
                self.slow_to(plan, i, way, end, v, 0.0);
            }
            return;
        }
        let cap = look_ahead::cap(plan.ring, i, plan.wanted).min(plan.cap(i));
        if v > cap * (1.0 + WORTH) && v > 1.0e-9 {
            self.slow_to(plan, i, way, end, v, cap);
            return;
        }
        // While lower overrides wait for room, nothing rises.
        let settled = plan.planned.not_above(plan.wanted);
        if settled && v < cap * (1.0 - WORTH) || self.v == 0 {
            let top = peak(plan, i, span, way, v, cap);
            if top > v * (1.0 + WORTH) && top > 1.0e-12 {
                let (a, j) = limits_up(plan, i, span, way, v, top);
                self.ramp_to(top, a, j);
                return;
            }
        }
        self.follow(plan, i, way, end, v);
    }

    /// Keeps the speed up to the end of the span or to where a ramp down must start.
    fn follow<const N: usize>(&mut self, plan: &Plan<'_, N>, i: usize, way: f32, end: i64, v: f32) {
        if self.v == 0 {
            // Nothing fits any more.
            self.mode = Mode::Rest;
            if end - self.x < NEAR {
                self.x = end;
            } else {
                self.v = 1 << 20;
                self.cruise(end);
            }
            return;
        }
        if let Some(next) = plan.ring.span(i + 1)
            && v <= next.entry * (1.0 + 4.0e-6)
        {
            self.cruise(end);
            return;
        }
        // On the way to a root no span's own limit may be passed, and nothing here asks for more speed.
        let (near, far) = plan.targets(i, way);
        let far = far.filter(|t| v <= t.cap * USABLE && t.speed < v);
        let mut best: Option<(i64, i64, Target)> = None;
        let fits = |t: &Target| ramp::distance(v, t.speed, t.a, t.j) <= t.way;
        let other = if [near, far].iter().flatten().any(fits) {
            None
        } else {
            plan.descent(i, way, v)
        };
        for target in [near, far, other].into_iter().flatten() {
            let w = profile::speed_bits(target.speed);
            let needed = if self.v > w {
                Ramp::way(self.v, w, target.a, target.j)
            } else {
                0
            };
            let at = plan.start(i + usize::from(target.span));
            if best.is_none_or(|(start, _, _)| at - needed > start) {
                best = Some((at - needed, at, target));
            }
        }
        let Some((start, at, target)) = best else {
            self.cruise(end);
            return;
        };
        let (mut a, mut j) = (target.a, target.j);
        if start < self.x {
            let needed = profile::length_of(at - start);
            let given = profile::length_of(at - self.x);
            if given < needed * (1.0 - 1.0e-2) {
                self.squeezed = self.squeezed.wrapping_add(1);
            }
            if given <= 0.0 {
                self.cruise(end);
                return;
            }
            let times = needed / given * (1.0 + 1.0e-6);
            a *= times;
            j *= times * times;
        }
        let descent = Descent {
            speed: target.speed,
            a,
            j,
        };
        if start <= self.x {
            self.ramp_to(descent.speed, a, j);
        } else {
            self.mode = Mode::Cruise {
                until: start,
                then: Some(descent),
            };
        }
    }

    /// Slows to `w` now, for no reason of the path.
    fn slow_to<const N: usize>(
        &mut self,
        plan: &Plan<'_, N>,
        i: usize,
        way: f32,
        end: i64,
        v: f32,
        w: f32,
    ) {
        let Some(first) = plan.ring.span(i) else {
            return;
        };
        let (mut a, mut j, mut reach) = (first.a, first.j, way);
        let mut through = first.through;
        let mut w = w;
        let mut k = i + 1;
        while ramp::distance(v, w, a, j) > reach {
            match plan.ring.span(k) {
                // Only what may be entered at this speed may be crossed while slowing down gently.
                Some(next) if through && next.through && v <= next.v * USABLE => {
                    a = lesser(a, next.a);
                    j = lesser(j, next.j);
                    reach += next.length;
                    through = next.through;
                    k += 1;
                }
                Some(next) => {
                    // A corner lies ahead, at constant speed or a lower one: as slow as may be until there, but not crawling.
                    w = ramp::slowest(reach, v, a, j)
                        .max(w)
                        .max(0.3 * next.entry.min(v));
                    if ramp::distance(v, w, a, j) > reach {
                        w = v;
                    }
                    break;
                }
                None => {
                    // The planned stop is as soon.
                    self.follow(plan, i, way, end, v);
                    return;
                }
            }
        }
        // What the path asks for next must still fit behind it, else that is taken now.
        let w_bits = profile::speed_bits(w);
        let after = self.x + Ramp::way(self.v, w_bits, a, j);
        if w > 0.0 && w < v && !plan.is_feasible(after, w) {
            let (near, far) = plan.targets(i, way);
            let fitting = [far, near].into_iter().flatten().find(|t| {
                t.speed < v && v <= t.cap * USABLE && ramp::distance(v, t.speed, t.a, t.j) <= t.way
            });
            let bound = plan.ring.span(i + 1).is_none_or(|n| v > n.entry);
            match fitting {
                Some(t) if bound => self.ramp_to(t.speed, t.a, t.j),
                _ => self.follow(plan, i, way, end, v),
            }
            return;
        }
        if w >= v * (1.0 - WORTH) {
            self.follow(plan, i, way, end, v);
        } else {
            self.ramp_to(w, a, j);
        }
    }
}

/// The highest speed to ramp up to from `v`, `way` before the end of span `i`.
fn peak<const N: usize>(
    plan: &Plan<'_, N>,
    i: usize,
    span: &Span,
    mut way: f32,
    v: f32,
    mut cap: f32,
) -> f32 {
    let (mut a, mut j) = (span.a, span.j);
    let mut through = span.through;
    let mut m = i + 1;
    loop {
        let Some(next) = plan.ring.span(m) else {
            return ramp::peak(way, v, 0.0, cap, a, j);
        };
        let near = || ramp::peak(way, v, next.entry, cap, a, j);
        if next.entry < cap {
            let here = Span {
                a,
                j,
                through,
                ..*span
            };
            return match beyond(&here, way, cap, Some(next), plan.cap(m)) {
                Some(t) => ramp::peak(t.way, v, t.speed, t.cap, t.a, t.j).max(near()),
                None => near(),
            };
        }
        if ramp::distance(v, cap, a, j) <= way * (1.0 - 4.0e-6) {
            return cap;
        }
        if !(through && next.through) {
            return near();
        }
        through = next.through;
        a = lesser(a, next.a);
        j = lesser(j, next.j);
        cap = cap.min(plan.cap(m));
        way += next.length;
        m += 1;
    }
}

/// Least limits over the spans that a ramp up from `v` to `w` crosses.
fn limits_up<const N: usize>(
    plan: &Plan<'_, N>,
    i: usize,
    span: &Span,
    mut way: f32,
    v: f32,
    w: f32,
) -> (f32, f32) {
    let (mut a, mut j) = (span.a, span.j);
    let mut m = i + 1;
    while ramp::distance(v, w, a, j) > way {
        let Some(next) = plan.ring.span(m) else { break };
        if !next.through {
            break;
        }
        a = lesser(a, next.a);
        j = lesser(j, next.j);
        way += next.length;
        m += 1;
    }
    (a, j)
}
