//! Speed over time along the path, on integers: cruise and ramps, evaluated exactly where they stand.
//!
//! ```text
//!  position  x   2^-32 length       s(t) = s0 + (v0 + (a0/2 + c t) t) t,   c = jerk/6
//!  speed     v   2^-48 length/ms    v(t) = v0 + (a0 + 3 c t) t
//!  time      t   2^-22 ms
//! ```
//!
//! The state at the end of a phase is the start of the next, so nothing ever jumps; the distance of a ramp is known to the
//! last bit before it starts, which is how a ramp down comes to end on its point exactly. Lengths are below 2^31, speeds
//! below 2^15 a millisecond (limits.rs: at most 10^4 steps/ms a joint).

use super::ramp::Steep;

/// Times have that many bits behind the millisecond: at 100 steps a millisecond, the last one is a 40 000th of a step.
const FRACTION: u32 = 22;
/// One millisecond.
pub(super) const TICK: u64 = 1 << FRACTION;

const LENGTH: f32 = 4_294_967_296.0;
const SPEED: f32 = 281_474_976_710_656.0;

/// A length as 2^-32.
pub(super) fn length_bits(x: f32) -> i64 {
    (x * LENGTH) as i64
}

pub(super) fn length_of(bits: i64) -> f32 {
    bits as f32 * (1.0 / LENGTH)
}

pub(super) fn speed_bits(v: f32) -> i64 {
    (v * SPEED) as i64
}

pub(super) fn speed_of(bits: i64) -> f32 {
    bits as f32 * (1.0 / SPEED)
}

/// Way at constant speed [2^-32]; `time` may be negative.
pub(super) fn way(v: i64, time: i64) -> i64 {
    // A way may exceed 2^15: shifted to 2^-32 before it is cut to 64 bits.
    ((i128::from(v) * i128::from(time)) >> (16 + FRACTION)) as i64
}

/// Time over a way at constant speed.
pub(super) fn time_over(way: i64, v: i64) -> f32 {
    /// Length 2^-32 over speed 2^-48 per ms, as time.
    const TIME: f32 = (1u64 << (16 + FRACTION)) as f32;
    way as f32 / v.max(1) as f32 * TIME
}

/// The same to the last bit, where a sum of times must come out; `way` above 0.
pub(super) fn exact_time_over(way: i64, v: i64) -> i64 {
    let time = (u128::from(way.unsigned_abs()) << (16 + FRACTION)) / u128::from(v.max(1).unsigned_abs());
    i64::try_from(time).unwrap_or(i64::MAX)
}

/// `a * t`, with t in units of `FRACTION`.
fn scale(a: i64, t: u64) -> i64 {
    ((i128::from(a) * i128::from(t)) >> FRACTION) as i64
}

/// `a / t`, with t in units of `FRACTION`.
fn unscale(a: i64, t: u64) -> i64 {
    if t == 0 {
        return 0;
    }
    // |a| below 2^63: the quotient's whole part, then 22 more bits of the remainder (t is below 2^41: two rises of 100 s).
    let (whole, rest) = (a.unsigned_abs() / t, a.unsigned_abs() % t);
    let bits =
        whole.saturating_mul(1 << FRACTION).min(1 << 62) as i64 + ((rest << FRACTION) / t) as i64;
    if a < 0 { -bits } else { bits }
}

/// `way` / `length`, in units of 2^-40, exact but for what is cut off; `length` above 0.
pub(super) fn direction(way: i64, length: i64) -> i64 {
    let (size, length) = (way.unsigned_abs(), length.unsigned_abs());
    let bits = if length < 1 << 44 && size >> 22 < length {
        // Twenty bits at a time: a division of 64 bits costs the target a twentieth of one of 128.
        let (whole, rest) = match size < length {
            true => (0, size),
            false => (size / length, size % length),
        };
        let (high, rest) = ((rest << 20) / length, (rest << 20) % length);
        (whole << 40) + (high << 20) + (rest << 20) / length
    } else {
        ((u128::from(size) << 40) / u128::from(length)) as u64
    } as i64;
    if way < 0 { -bits } else { bits }
}

fn time_bits(t: f32) -> u64 {
    // A rise of 100 s a limit: below 2^18 ms.
    (t * TICK as f32) as u64
}

/// A stretch of constant jerk.
#[derive(Clone, Copy, Debug, Default)]
struct Phase {
    length: u64,
    /// Acceleration at the start [2^-48 length/ms^2], and a sixth of the jerk [2^-48 length/ms^3].
    acceleration: i64,
    sixth: i64,
}

impl Phase {
    fn way(&self, v: i64, t: u64) -> i64 {
        let slope = (self.acceleration >> 1) + scale(self.sixth, t);
        way(v + scale(slope, t), t.cast_signed())
    }

    fn speed(&self, v: i64, t: u64) -> i64 {
        v + scale(self.acceleration + 3 * scale(self.sixth, t), t)
    }

    fn acceleration(&self, t: u64) -> i64 {
        self.acceleration + 6 * scale(self.sixth, t)
    }
}

/// A change of speed under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramp {
    phases: [Phase; 3],
    at: u8,
    /// Time within the phase.
    t: u64,
    /// Position and speed at the start of the phase.
    start: (i64, i64),
    /// Speed at the end of the ramp.
    end_speed: i64,
    /// Acceleration and jerk allowed [length/ms^2, length/ms^3].
    pub acceleration: f32,
    pub jerk: f32,
}

impl Ramp {
    /// From speed `v` to speed `w` (bits), starting at position `x`.
    pub fn new(x: i64, v: i64, w: i64, steep: &Steep) -> Self {
        let dv = w - v;
        let (t1, t2) = steep.times(speed_of(dv.abs()));
        let t1 = time_bits(t1).max(1);
        let t2 = time_bits(t2);
        let top = unscale(dv, t1 + t2);
        let sixth = unscale(top, t1) / 6;
        Self {
            phases: [
                Phase {
                    length: t1,
                    acceleration: 0,
                    sixth,
                },
                Phase {
                    length: t2,
                    acceleration: top,
                    sixth: 0,
                },
                Phase {
                    length: t1,
                    acceleration: top,
                    sixth: -sixth,
                },
            ],
            at: 0,
            t: 0,
            start: (x, v),
            end_speed: w,
            acceleration: steep.a,
            jerk: steep.j,
        }
    }

    fn phase(&self) -> Phase {
        self.phases
            .get(usize::from(self.at))
            .copied()
            .unwrap_or_default()
    }

    pub fn position(&self) -> i64 {
        self.start.0 + self.phase().way(self.start.1, self.t)
    }

    pub fn speed(&self) -> i64 {
        self.phase().speed(self.start.1, self.t)
    }

    pub fn end_speed(&self) -> i64 {
        self.end_speed
    }

    /// Whether it slows down.
    pub fn slows(&self) -> bool {
        self.phases.iter().any(|p| p.acceleration < 0)
    }

    /// Time to its end.
    pub fn left(&self) -> u64 {
        let phases = self.phases.iter().skip(usize::from(self.at));
        phases.map(|phase| phase.length).sum::<u64>() - self.t
    }

    /// Position at the end.
    pub fn end(&self) -> i64 {
        let mut whole = *self;
        // Three phases.
        while !whole.step(u64::MAX).0 {}
        whole.start.0
    }

    /// Distance of a ramp that starts at zero.
    pub fn way(v: i64, w: i64, steep: &Steep) -> i64 {
        Self::new(0, v, w, steep).end()
    }

    /// Runs on for at most `time`, to the end of the present phase at the farthest: whether the ramp is over, and the
    /// time left.
    pub fn step(&mut self, time: u64) -> (bool, u64) {
        let phase = self.phase();
        let left = phase.length - self.t;
        if left > time {
            self.t += time;
            return (false, 0);
        }
        let v = phase.speed(self.start.1, phase.length);
        self.start = (
            self.start.0 + phase.way(self.start.1, phase.length),
            if self.at >= 2 { self.end_speed } else { v },
        );
        self.at += 1;
        self.t = 0;
        (self.at > 2, time - left)
    }

    /// The origin of positions moves forward by `x`.
    pub fn rebase(&mut self, x: i64) {
        self.start.0 -= x;
    }

    /// Lets the acceleration go as fast as the jerk allows: what is left is at constant speed.
    pub fn eased(&self) -> Self {
        let phase = self.phase();
        let (x, v) = (self.position(), self.speed());
        let a = phase.acceleration(self.t);
        if self.at == 2 {
            return *self;
        }
        let t = time_bits(speed_of(a.abs()) / self.jerk).max(1);
        let sixth = -unscale(a, t) / 6;
        let last = Phase {
            length: t,
            acceleration: a,
            sixth,
        };
        Self {
            phases: [Phase::default(), Phase::default(), last],
            at: 2,
            t: 0,
            start: (x, v),
            end_speed: last.speed(v, t).max(0),
            acceleration: self.acceleration,
            jerk: self.jerk,
        }
    }
}
