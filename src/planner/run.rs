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
use super::corner::Corner;
use super::look_ahead::{self, Factors, adjacent, beyond, lesser};
use super::profile::{self, Ramp, TICK};
use super::ramp::{Climb, Slack, Steep};
use super::ring::Ring;

/// A change of speed below this share is not worth a ramp.
const WORTH: f32 = 2.0e-3;
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
    steep: Steep,
}

/// The time around the passage of a corner in which nothing is decided anew.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// Time since the passage, and half of the window [a 2^22th ms].
    pub t: i64,
    pub half: i64,
    /// Speed of the passage [2^-48 length/ms].
    pub v: i64,
    /// The corner's second block is the head.
    pub passed: bool,
}

impl Window {
    fn run(window: &mut Option<Self>, time: u64) {
        if let Some(w) = window {
            w.t += time.cast_signed();
            if w.t >= w.half && w.passed {
                *window = None;
            }
        }
    }
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
    pub window: Option<Window>,
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

    /// Rise of ramps that end at the start of span `i`.
    fn rise(&self, i: usize) -> f32 {
        self.ring.corner_at(i).map_or(0.0, |c| c.rise)
    }

    /// Way before the start of span `i` in which the speed v must stay, where no ramp down leads to it.
    fn calm(&self, i: usize, v: f32) -> f32 {
        self.ring.corner_at(i).map_or(0.0, |c| c.calm_at(v))
    }

    /// Where a ramp down may lead from `way` before the end of span `i`.
    fn targets(&self, i: usize, way: f32, v: f32) -> (Option<Target>, Option<Target>) {
        let Some(span) = self.ring.span(i) else {
            return (None, None);
        };
        let next = self.ring.span(i + 1);
        let cap = self.cap(i);
        let corner = self.ring.corner_at(i + 1);
        let mut near = adjacent(span, way, cap, next, corner);
        let fits = |t: &Target| v <= t.speed || t.steep().distance(v, t.speed) <= t.way;
        if let Some(corner) = corner
            && !fits(&near)
        {
            let others = look_ahead::slower(&near, corner);
            near = others.into_iter().find(fits).unwrap_or(near);
        }
        (Some(near), beyond(span, way, cap, next, self.cap(i + 1)))
    }

    /// The nearest span whose start a ramp from `v`, `way` before the end of span `i`, can reach at a speed fit for it.
    /// Roots know the best ramps from the borders of spans; this finds the others.
    fn descent(&self, i: usize, mut way: f32, v: f32) -> Option<Target> {
        let mut span = self.ring.span(i)?;
        let mut slack = span.slack;
        for m in i + 1.. {
            let next = self.ring.span(m);
            let w = next.map_or(0.0, |n| n.entry);
            let rise = self.rise(m);
            if v > w && slack.at(v, rise).distance(v, w) <= way {
                return Some(Target {
                    span: (m - i) as u16,
                    way,
                    speed: w,
                    slack,
                    cap: v,
                    rise,
                });
            }
            let next = next?;
            if !span.through || !next.through || v > next.v * 1.001 {
                return None;
            }
            slack = slack.and(&next.slack);
            way += next.length;
            span = next;
        }
        None
    }

    /// Whether speed `v` without acceleration at `x` leaves room for all that follows.
    pub fn is_feasible(&self, x: i64, v: f32) -> bool {
        let i = self.locate(x);
        let way = profile::length_of(self.start(i + 1) - x);
        if self.ring.span(i + 1).is_some_and(|n| v <= n.entry) && way >= self.calm(i + 1, v) {
            return true;
        }
        let (near, far) = self.targets(i, way, v);
        let by_root = [near, far.filter(|t| v <= t.cap * USABLE)]
            .into_iter()
            .flatten()
            .any(|t| {
                v <= t.speed && t.rise <= 0.0
                    || v > t.speed && t.steep().distance(v, t.speed) <= t.way * 0.999
            });
        by_root || self.descent(i, way * 0.999, v).is_some()
    }
}

impl Runner {
    pub const fn new() -> Self {
        Self {
            x: 0,
            v: 0,
            mode: Mode::Rest,
            window: None,
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
        self.window = None;
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
        let first = plan.locate(self.x);
        for i in first..=plan.locate(end - 1) {
            let Some(span) = plan.ring.span(i) else { break };
            // No ramp leads through a corner.
            if i > first && plan.ring.corner_at(i).is_some() {
                return false;
            }
            let steep = span.slack.at(most, 0.0);
            let within =
                ramp.is_none_or(|r| r.acceleration <= steep.a * 1.001 && r.jerk <= steep.j * 1.001);
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
        let mut slack = span.slack;
        let mut way = profile::length_of(plan.start(i + 1) - x);
        // To some speed in between may take an eighth more than to rest.
        let to_rest = |v: f32, slack: &Slack| slack.at(v, 0.0).distance(v, 0.0) * 1.125;
        let mut needed = to_rest(v, &slack);
        let mut known = slack;
        while needed > way {
            i += 1;
            let Some(next) = plan.ring.span(i) else {
                return plan.ring.len();
            };
            if span.through && next.through {
                way += next.length;
                slack = slack.and(&next.slack);
                // Less slack only adds to what is needed: looked at again where that would do.
                if needed <= way && known != slack {
                    needed = to_rest(v, &slack);
                    known = slack;
                }
            } else {
                v = lesser(v, next.entry);
                slack = next.slack;
                // No ramp down begins in the window behind a corner.
                way = next.length - i.checked_sub(1).map_or(0.0, |k| plan.calm(k, v));
                needed = to_rest(v, &slack);
                known = slack;
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
                    let needed = profile::time_over(left, self.v);
                    if left > 0 && needed >= time as f32 {
                        self.x += profile::way(self.v, time.cast_signed());
                        self.x = self.x.min(until);
                        Window::run(&mut self.window, time);
                        time = 0;
                    } else {
                        if left > 0 {
                            let taken = (needed as u64).min(time);
                            Window::run(&mut self.window, taken);
                            time -= taken;
                            self.x = until;
                        }
                        match then {
                            Some(d) => {
                                self.ramp_to(d.speed, &d.steep);
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
                    Window::run(&mut self.window, time - left);
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
        if let Some(w) = &mut self.window {
            w.passed = true;
            if w.t >= w.half {
                self.window = None;
            }
        }
        match &mut self.mode {
            Mode::Rest => self.x = 0,
            Mode::Cruise { until, .. } => *until -= bits,
            Mode::Ramp(ramp) => ramp.rebase(bits),
        }
    }

    fn ramp_to(&mut self, w: f32, steep: &Steep) {
        self.mode = Mode::Ramp(Ramp::new(self.x, self.v, profile::speed_bits(w), steep));
    }

    /// After a sample: whether a corner is near enough for its window to open before the next one. From there on speed and
    /// time of the passage are known.
    pub fn foresee<const N: usize>(&mut self, plan: &Plan<'_, N>) {
        let (Some(corner), Some(head)) = (plan.ring.corner_at(2), plan.ring.get(0)) else {
            return;
        };
        if self.window.is_some_and(|w| !w.passed) {
            return;
        }
        let left = head.bits - self.x;
        let speed = self.speed();
        if left > profile::length_bits(2.0 * corner.calm + 2.0 * speed + 1.0) {
            return;
        }
        let (v, time) = match &self.mode {
            Mode::Ramp(ramp) => {
                let v = ramp.end_speed();
                let behind = head.bits - ramp.end();
                if behind > profile::length_bits(corner.calm) {
                    return;
                }
                let behind = profile::exact_time_over(behind.max(0), v);
                (v, ramp.left().cast_signed().saturating_add(behind))
            }
            Mode::Cruise { until, then: None } if *until + NEAR >= head.bits => {
                (self.v, profile::exact_time_over(left.max(0), self.v))
            }
            _ => return,
        };
        let entry = plan.ring.span(2).map_or(0.0, |corner| corner.entry);
        // What has arrived since a ramp down began may have lowered the entry; the corner itself allows its speed.
        let most = match &self.mode {
            Mode::Ramp(ramp) if ramp.slows() => corner.v,
            _ => entry,
        };
        if profile::speed_of(v) > most * (1.0 + WORTH) {
            // A ramp down is still to come.
            return;
        }
        let half = (corner.time(profile::speed_of(v)) * TICK as f32) as i64;
        if v > 0 && time <= half + TICK.cast_signed() {
            self.window = Some(Window {
                t: -time,
                half,
                v,
                passed: false,
            });
        }
    }

    /// Whether nothing may be decided anew now.
    pub fn is_bound(&self) -> bool {
        self.window.is_some()
    }

    /// Way up to the end of the window behind a corner; 0 elsewhere.
    fn calm_left(&self) -> i64 {
        match &self.window {
            Some(w) => profile::way(self.v, w.half - w.t) + 1,
            None => 0,
        }
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
        if self.window.is_some() && wish == Wish::Halt {
            let until = self.x + self.calm_left();
            self.cruise(until.min(end));
            return;
        }
        if wish == Wish::Halt {
            if self.v == 0 {
                self.mode = Mode::Rest;
            } else {
                self.slow_to(plan, i, way, end, v, 0.0);
            }
            return;
        }
        let cap = look_ahead::cap(plan.ring, i, plan.wanted).min(plan.cap(i));
        if v > cap * (1.0 + WORTH) && v > 1.0e-9 && self.window.is_none() {
            self.slow_to(plan, i, way, end, v, cap);
            return;
        }
        // While lower overrides wait for room, nothing rises.
        let settled = plan.planned.not_above(plan.wanted);
        if settled && v < cap * (1.0 - WORTH) || self.v == 0 {
            let rise = self
                .window
                .map_or(0.0, |w| w.half as f32 * (1.0 / TICK as f32));
            let passed = self.window.is_none_or(|w| w.passed);
            let top = peak(plan, i, span, way, v, cap, rise);
            if passed && top > v * (1.0 + WORTH) && top > 1.0e-12 {
                let steep = limits_up(plan, i, span, way, v, top, rise);
                self.ramp_to(top, &steep);
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
                // A quarter of a sample's worth of jerk is a speed that comes and goes at once.
                let j = plan.ring.span(i).map_or(0.0, |s| s.slack.at(0.0, 0.0).j);
                self.v = profile::speed_bits(0.25 * j).max(1 << 20);
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
        let (near, far) = plan.targets(i, way, v);
        let far = far.filter(|t| v <= t.cap * USABLE && t.speed < v);
        let mut best: Option<(i64, i64, Target)> = None;
        let fits = |t: &Target| t.steep().distance(v, t.speed) <= t.way;
        let other = if [near, far].iter().flatten().any(fits) {
            None
        } else {
            plan.descent(i, way, v)
        };
        for target in [near, far, other].into_iter().flatten() {
            let w = profile::speed_bits(target.speed);
            let needed = if self.v > w {
                Ramp::way(self.v, w, &target.steep())
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
        let mut steep = target.steep();
        // Not before the window of a corner is over.
        let earliest = match &self.window {
            Some(_) => self.x + self.calm_left(),
            None => self.x,
        };
        let start = if start < earliest && self.window.is_some() {
            let needed = at - start;
            let given = at - earliest;
            if given < needed - (needed >> 7) || given <= 0 {
                self.squeezed = self.squeezed.wrapping_add(1);
            }
            // Taken up again there.
            self.cruise(earliest.min(end));
            return;
        } else {
            start
        };
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
            steep = Steep {
                a: steep.a * times,
                j: steep.j * times * times,
                rise: steep.rise / times,
            };
        }
        let descent = Descent {
            speed: target.speed,
            steep,
        };
        if start <= self.x {
            self.ramp_to(descent.speed, &steep);
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
        let (mut slack, mut reach) = (first.slack, way);
        let mut through = first.through;
        let mut w = w;
        let mut k = i + 1;
        while slack.at(v, 0.0).distance(v, w) > reach {
            match plan.ring.span(k) {
                // Only what may be entered at this speed may be crossed while slowing down gently.
                Some(next) if through && next.through && v <= next.v * USABLE => {
                    slack = slack.and(&next.slack);
                    reach += next.length;
                    through = next.through;
                    k += 1;
                }
                Some(next) => {
                    // A corner lies ahead, at constant speed or a lower one: as slow as may be until there, but not crawling.
                    let steep = slack.at(v, 0.0);
                    let reach = reach - plan.calm(k, v);
                    w = steep.slowest(reach, v).max(w).max(0.3 * next.entry.min(v));
                    if steep.distance(v, w) > reach {
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
        let steep = slack.at(v, 0.0);
        let after = self.x + Ramp::way(self.v, w_bits, &steep);
        if w > 0.0 && w < v && !plan.is_feasible(after, w) {
            let (near, far) = plan.targets(i, way, v);
            let fitting = [far, near].into_iter().flatten().find(|t| {
                t.speed < v && v <= t.cap * USABLE && t.steep().distance(v, t.speed) <= t.way
            });
            let bound = plan.ring.span(i + 1).is_none_or(|n| v > n.entry);
            match fitting {
                Some(t) if bound => self.ramp_to(t.speed, &t.steep()),
                _ => self.follow(plan, i, way, end, v),
            }
            return;
        }
        if w >= v * (1.0 - WORTH) {
            self.follow(plan, i, way, end, v);
        } else {
            self.ramp_to(w, &steep);
        }
    }
}

/// The highest speed to ramp up to from `v`, `way` before the end of span `i`, with a given rise.
fn peak<const N: usize>(
    plan: &Plan<'_, N>,
    i: usize,
    span: &Span,
    mut way: f32,
    v: f32,
    mut cap: f32,
    rise: f32,
) -> f32 {
    let mut slack = span.slack;
    let mut through = span.through;
    let mut best = v;
    let mut m = i + 1;
    loop {
        let climb =
            |to: f32, way: f32, cap: f32, slack: &Slack, down: f32, corner: Option<&Corner>| {
                Climb {
                    way,
                    from: v,
                    to,
                    cap,
                    up: slack.at(cap, rise),
                    down: slack.at(cap, down),
                    corner: corner.copied(),
                }
                .peak()
            };
        let Some(next) = plan.ring.span(m) else {
            return best.max(climb(0.0, way, cap, &slack, 0.0, None));
        };
        let corner = plan.ring.corner_at(m);
        let near = |cap: f32| climb(next.entry, way, cap, &slack, plan.rise(m), corner);
        if next.entry < cap {
            let here = Span {
                slack,
                through,
                ..*span
            };
            best = best.max(near(cap));
            if let Some(t) = beyond(&here, way, cap, Some(next), plan.cap(m)) {
                best = best.max(climb(t.speed, t.way, t.cap, &t.slack, t.rise, None));
            }
            if best >= next.entry * (1.0 - 1.0e-6) {
                return best;
            }
            // A slower stretch: up to its speed, and on through it.
            cap = next.entry;
        }
        let steep = slack.at(cap, rise);
        if steep.distance(v, cap) <= (way - plan.calm(m, cap)) * (1.0 - 4.0e-6) {
            return best.max(cap);
        }
        if !(through && next.through) {
            return best.max(near(cap));
        }
        through = next.through;
        slack = slack.and(&next.slack);
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
    rise: f32,
) -> Steep {
    let mut slack = span.slack;
    let mut m = i + 1;
    loop {
        let steep = slack.at(w, rise);
        if steep.distance(v, w) <= way {
            return steep;
        }
        match plan.ring.span(m) {
            Some(next) if next.through => {
                slack = slack.and(&next.slack);
                way += next.length;
                m += 1;
            }
            _ => return steep,
        }
    }
}
