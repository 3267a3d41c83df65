//! `shaper.*`: impulses of an input shaper, their weights on samples of a millisecond, and the vibration that they leave.
//!
//! ```text
//!  V(f, z) = exp(-z w t_n) | sum_k A_k exp(z w t_k) exp(i w sqrt(1 - z^2) t_k) |,   w = 2 pi f
//! ```
//!
//! of the vibration that an unshaped impulse leaves (Singer & Seering 1990). `residual` is that of the weights which the
//! machine uses, `ideal` that of the impulses of the formulas.

use super::{Answer, Fault, Field, Function, Kind, Request};
use crate::job::SHAPERS;
use heapless::Vec as List;
use hexstep::math::Real;
use hexstep::shaper::design::{self, Mode, RATE, Weights};
use hexstep::shaper::{self, LONGEST, Reason};

const SHAPER: &[Field] = &[
    Field::new("type", Kind::Word(&["off", "zv", "zvd", "ei"]), "", ""),
    Field::number("frequency", "Hz", "above 0, below 500 (499)"),
    Field::number("damping", "", "0 to 0.9; 0.3 with ei").or("0"),
    Field::new(
        "frequency2",
        Kind::Number,
        "Hz",
        "as frequency; a second vibration",
    )
    .optional(),
    Field::number("damping2", "", "as damping").or("0"),
];

const CURVE: &[Field] = &[
    Field::new(
        "range",
        super::schema::RANGE,
        "Hz",
        "above 0; left out: half to one and a half of frequency",
    )
    .optional(),
    Field::new("points", Kind::Integer, "", "2 to 100000").or("101"),
    Field::new(
        "mode_damping",
        Kind::Number,
        "",
        "0 to 0.9; left out: damping",
    )
    .optional(),
];

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "shaper.impulses",
        summary: "Times and shares of a shaper's impulses, and their weights on samples of a millisecond.",
        fields: &[SHAPER],
        f64: impulses::<f64>,
        f32: Some(impulses::<f32>),
    },
    Function {
        name: "shaper.residual",
        summary: "Vibration left by a shaper over a range of frequencies, in percent of the unshaped one.",
        fields: &[SHAPER, CURVE],
        f64: residual::<f64>,
        f32: Some(residual::<f32>),
    },
];

/// A shaper worked out, one vibration or two.
struct Shaper<R> {
    /// Time [samples] and share.
    ideal: Vec<(R, R)>,
    sampled: Weights<R, 36>,
}

impl<R: Real> Shaper<R> {
    fn of(request: &Request) -> Result<Self, Fault> {
        if let Some(field) = request.not_finite::<R>() {
            let detail = format!("{field} must be finite; give numbers");
            return Err(Fault::new("NonFinite", detail).field(field));
        }
        let kind = match SHAPERS
            .iter()
            .position(|name| *name == request.word("type"))
        {
            Some(1) => shaper::Kind::Zv,
            Some(2) => shaper::Kind::Zvd,
            Some(3) => shaper::Kind::Ei,
            _ => shaper::Kind::Off,
        };
        let mode = |hz: &str, damping: &str| Mode {
            hz: request.number(hz),
            damping: request.number(damping),
        };
        let first = mode("frequency", "damping");
        let refused = |suffix: &'static str| move |reason: Reason| refuse(reason, suffix);
        let one = design::impulses(kind, &first).map_err(refused(""))?;
        let near = design::sampled(kind, &first).map_err(refused(""))?;
        let mut other: List<(R, R), 3> = List::new();
        let _ = other.push((R::ZERO, R::ONE));
        let mut far = Weights::new();
        let _ = far.push((0, R::ONE));
        if request.is_given("frequency2") {
            let second = mode("frequency2", "damping2");
            other = design::impulses(kind, &second).map_err(refused("2"))?;
            far = design::sampled(kind, &second).map_err(refused("2"))?;
        }
        let mut ideal: Vec<(R, R)> = other
            .iter()
            .flat_map(|(t, a)| one.iter().map(|(u, b)| (*t + *u, *a * *b)))
            .collect();
        ideal.sort_by(|a, b| a.0.to_f64().total_cmp(&b.0.to_f64()));
        let sampled: Weights<R, 36> = design::convolved(&near, &far);
        let samples = design::length(&sampled);
        if samples > LONGEST {
            return Err(refuse(Reason::TooLong { samples }, ""));
        }
        Ok(Self { ideal, sampled })
    }

    fn put(&self, answer: Answer) -> Answer {
        let second = R::of(RATE.into());
        let mean = self.ideal.iter().fold(R::ZERO, |sum, (t, a)| sum + *t * *a);
        let last = self.ideal.last().map_or(R::ZERO, |(t, _)| *t);
        // Less than the machine's own weights hold is none.
        let mut weights: Vec<(u32, R)> = self.sampled.iter().copied().collect();
        weights.retain(|(_, weight)| *weight > R::of(1e-6));
        weights.sort_by_key(|(delay, _)| *delay);
        answer
            .numbers("times", self.ideal.iter().map(|(t, _)| *t / second))
            .numbers("shares", self.ideal.iter().map(|(_, a)| *a))
            .number("duration", last / second)
            .number("delay", mean / second)
            .put(
                "samples",
                &weights.iter().map(|(delay, _)| *delay).collect::<Vec<_>>(),
            )
            .numbers("weights", weights.iter().map(|(_, weight)| *weight))
    }

    /// Residual vibration [%] of what the machine does, and of the formulas' impulses.
    fn left(&self, hz: R, damping: R) -> [R; 2] {
        let sampled = self.sampled.iter().map(|(t, a)| (R::of((*t).into()), *a));
        [
            vibration(sampled, hz, damping),
            vibration(self.ideal.iter().copied(), hz, damping),
        ]
    }
}

fn vibration<R: Real>(impulses: impl Iterator<Item = (R, R)> + Clone, hz: R, damping: R) -> R {
    let omega = R::TAU * hz / R::of(RATE.into());
    let damped = omega * (R::ONE - damping * damping).sqrt();
    let end = impulses.clone().fold(R::ZERO, |end, (t, _)| end.max(t));
    let (mut re, mut im) = (R::ZERO, R::ZERO);
    for (t, a) in impulses {
        let size = a * (damping * omega * (t - end)).exp();
        re += size * (damped * t).cos();
        im += size * (damped * t).sin();
    }
    R::of(100.0) * re.hypot(im)
}

fn refuse(reason: Reason, suffix: &'static str) -> Fault {
    let (field, detail) = match reason {
        Reason::Kind => (
            "type",
            "there is no such shaper; take off, zv, zvd or ei".into(),
        ),
        Reason::Frequency => (
            "frequency",
            format!(
                "a frequency must be above 0 and at most {} Hz, below half of 1000 samples a second",
                design::MOST_HZ
            ),
        ),
        Reason::Damping => (
            "damping",
            format!(
                "a damping must be from 0 to {}, with ei to {}",
                design::MOST_DAMPING,
                design::MOST_DAMPING_EI
            ),
        ),
        Reason::TooLong { samples } => (
            "frequency",
            format!("this shaper lasts {samples} ms, more than {LONGEST}; raise the frequency"),
        ),
    };
    Fault::new(reason.name(), detail).field(&format!("{field}{suffix}"))
}

fn impulses<R: Real>(request: &Request) -> Result<Answer, Fault> {
    Ok(Shaper::<R>::of(request)?.put(Answer::new()))
}

fn residual<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let shaper = Shaper::<R>::of(request)?;
    let frequency: R = request.number("frequency");
    let range = match request.numbers::<R>("range").as_slice() {
        [lo, hi] => [*lo, *hi],
        _ => [R::HALF * frequency, R::of(1.5) * frequency],
    };
    let [lo, hi] = range;
    if !(lo > R::ZERO && hi >= lo && hi <= R::of(1e6)) {
        let detail = "a range of frequencies must be [lo, hi] with 0 < lo <= hi <= 1e6 Hz";
        return Err(Fault::new("BadRange", detail).field("range"));
    }
    let points = request.integer("points");
    if !(2..=100_000).contains(&points) {
        let detail = "points must be 2 to 100000";
        return Err(Fault::new("BadRange", detail).field("points"));
    }
    let damping = request
        .maybe_number("mode_damping")
        .unwrap_or_else(|| request.number("damping"));
    if !(damping >= R::ZERO && damping <= R::of(design::MOST_DAMPING)) {
        let detail = "mode_damping must be from 0 to 0.9";
        return Err(Fault::new(Reason::Damping.name(), detail).field("mode_damping"));
    }
    let last = points as i32 - 1;
    let frequencies: Vec<R> = (0..=last)
        .map(|k| lo + (hi - lo) * R::of_i32(k) / R::of_i32(last))
        .collect();
    let curve: Vec<[R; 2]> = frequencies
        .iter()
        .map(|f| shaper.left(*f, damping))
        .collect();
    let [at, ideal] = shaper.left(frequency, damping);
    let answer = Answer::new()
        .number("at_frequency", at)
        .number("ideal_at_frequency", ideal)
        .numbers("frequencies", frequencies)
        .numbers("residual", curve.iter().map(|v| v[0]))
        .numbers("ideal", curve.iter().map(|v| v[1]));
    Ok(shaper.put(answer))
}
