//! Frequency and damping of a vibration -> impulses in time -> weights of samples that sum to one.
//!
//! With `K = exp(-z pi / sqrt(1 - z^2))` and the damped period `T = 1 / (f sqrt(1 - z^2))`:
//!
//! ```text
//!  ZV    1, K           at 0, T/2          / (1 + K)         no vibration at f
//!  ZVD   1, 2 K, K^2    at 0, T/2, T       / (1 + K)^2       nor does it grow at once beside f: ZV twice
//!  EI    about 1/4, 1/2, 1/4 at 0, T/2, T                    5 % at f, below that over the widest range around it
//! ```
//!
//! An impulse between two samples is not interpolated, which would leave up to `(pi f / 1000)^2 / 2` of it as vibration:
//! it becomes the two real weights that have the very same effect on the mode `s = -z w + i w sqrt(1 - z^2)`.
//!
//! ```text
//!  a + b g = A g^x,    g = exp(-s/1000),  x in [0, 1):      a, b = A e^(x sigma) sin((1-x) v), A e^((x-1) sigma) sin(x v), both / sin v
//! ```
//!
//! Both are above 0 below half the sample rate; dividing all weights by their sum changes no zero. ZVD is the sampled ZV
//! convolved with itself, so its second zero is exact as well. Positive weights with sum 1 make every shaped position,
//! speed, acceleration and jerk a mean of commanded ones: no limit is exceeded that the command keeps.
//!
//! Sources: Singer & Seering, Preshaping command inputs to reduce system vibration, J. Dyn. Sys. Meas. Control 112
//! (1990), pp. 76-82 (ZV, ZVD); Singhose, Seering & Singer, Residual vibration reduction using vector diagrams to
//! generate shaped inputs, J. Mech. Design 116 (1994), pp. 654-659 (EI without damping); Singhose, Porter, Tuttle &
//! Singer, Vibration reduction using multi-hump input shapers, J. Dyn. Sys. Meas. Control 119 (1997), pp. 320-326 (its fit
//! for damped modes: within 5.1 % up to a damping of 0.3).

use crate::math::Real;
use heapless::Vec;

/// Samples in a second.
pub const RATE: u32 = 1000;

/// What EI leaves at its own frequency.
pub const TOLERANCE: f64 = 0.05;

/// Highest frequency [Hz]: the sampled command holds nothing at half its rate and above.
pub const MOST_HZ: f64 = 499.0;
/// Highest damping; for EI [`MOST_DAMPING_EI`].
pub const MOST_DAMPING: f64 = 0.9;
pub const MOST_DAMPING_EI: f64 = 0.3;

/// How a joint's command is shaped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    #[default]
    Off,
    Zv,
    Zvd,
    Ei,
}

impl Kind {
    /// The kind that a setting's number stands for.
    pub fn of(number: f32) -> Option<Self> {
        let all = [Self::Off, Self::Zv, Self::Zvd, Self::Ei];
        let index = Real::floor(number) as usize;
        all.get(index).copied().filter(|_| index as f32 == number)
    }
}

/// A vibration: its undamped frequency [Hz] and its damping ratio.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mode<R> {
    pub hz: R,
    pub damping: R,
}

/// Why there is no such shaper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Expected a number that stands for a [`Kind`].
    Kind,
    /// Expected a frequency above 0 and up to [`MOST_HZ`].
    Frequency,
    /// Expected a damping from 0 to [`MOST_DAMPING`], or [`MOST_DAMPING_EI`] for EI.
    Damping,
    /// Its last impulse comes after so many samples, more than the history holds.
    TooLong { samples: u32 },
}

impl Reason {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kind => "ShaperType",
            Self::Frequency => "ShaperFrequency",
            Self::Damping => "ShaperDamping",
            Self::TooLong { .. } => "ShaperTooLong",
        }
    }
}

/// Weights of samples so many samples ago, ascending; they sum to 1.
pub type Weights<R, const K: usize> = Vec<(u32, R), K>;

/// Most samples of one shaper, and of one that is delayed by a fraction of a sample as well.
pub const TAPS: usize = 6;
pub const DELAYED_TAPS: usize = 9;

impl<R: Real> Mode<R> {
    fn check(&self, kind: Kind) -> Result<(), Reason> {
        let most = match kind {
            Kind::Ei => MOST_DAMPING_EI,
            _ => MOST_DAMPING,
        };
        // Written so that what is no number is refused.
        if !(self.hz > R::ZERO && self.hz <= R::of(MOST_HZ)) {
            return Err(Reason::Frequency);
        }
        if !(self.damping >= R::ZERO && self.damping <= R::of(most)) {
            return Err(Reason::Damping);
        }
        Ok(())
    }

    /// `sqrt(1 - z^2)`
    fn root(&self) -> R {
        (R::ONE - self.damping.squared()).sqrt()
    }

    /// Damped period [samples].
    fn period(&self) -> R {
        R::of(RATE.into()) / (self.hz * self.root())
    }

    /// What the vibration loses in half a damped period.
    fn decay(&self) -> R {
        (-(self.damping * R::PI / self.root())).exp()
    }
}

/// The impulses of a shaper: time [samples] and share; they sum to 1.
pub fn impulses<R: Real>(kind: Kind, mode: &Mode<R>) -> Result<Vec<(R, R), 3>, Reason> {
    let mut list = Vec::new();
    // There is room for three.
    let mut put = |time: R, share: R| {
        let _ = list.push((time, share));
    };
    if kind == Kind::Off {
        put(R::ZERO, R::ONE);
        return Ok(list);
    }
    mode.check(kind)?;
    let (period, k) = (mode.period(), mode.decay());
    let half = R::HALF * period;
    match kind {
        Kind::Off => {}
        Kind::Zv => {
            put(R::ZERO, R::ONE / (R::ONE + k));
            put(half, k / (R::ONE + k));
        }
        Kind::Zvd => {
            let all = (R::ONE + k).squared();
            put(R::ZERO, R::ONE / all);
            put(half, R::TWO * k / all);
            put(period, k.squared() / all);
        }
        Kind::Ei => {
            let [first, last, middle] = extra_insensitive(mode.damping);
            put(R::ZERO, first);
            put(middle * period, R::ONE - first - last);
            put(period, last);
        }
    }
    Ok(list)
}

/// First and last share of EI, and the time of its middle one in damped periods.
fn extra_insensitive<R: Real>(z: R) -> [R; 3] {
    let v = TOLERANCE;
    if z == R::ZERO {
        // The exact solution, which the fit misses by 3e-4.
        let outer = R::of((1.0 + v) / 4.0);
        return [outer, outer, R::HALF];
    }
    // Polynomials in z; their coefficients depend on the tolerance.
    let fit = |c: [f64; 4]| ((R::of(c[3]) * z + R::of(c[2])) * z + R::of(c[1])) * z + R::of(c[0]);
    [
        fit([
            0.24968 + 0.24961 * v,
            0.80008 + 1.23328 * v,
            0.49599 + 3.17316 * v,
            0.0,
        ]),
        fit([
            0.25149 + 0.21474 * v,
            -0.83249 + 1.41498 * v,
            0.85181 - 4.90094 * v,
            0.0,
        ]),
        fit([
            0.5,
            (0.46159 + 8.57843 * v) * v,
            (4.26169 - 108.644 * v) * v,
            (1.75601 + 336.989 * v) * v,
        ]),
    ]
}

/// The shaper in samples: what it leaves of its vibration is what its impulses leave, exactly.
pub fn sampled<R: Real>(kind: Kind, mode: &Mode<R>) -> Result<Weights<R, TAPS>, Reason> {
    let base = if kind == Kind::Zvd { Kind::Zv } else { kind };
    let mut weights = Weights::new();
    for (time, share) in impulses(base, mode)? {
        if time > R::of(1e6) {
            return Err(Reason::TooLong { samples: 1_000_000 });
        }
        let whole = time.floor();
        let [near, far] = split(mode, time - whole);
        let at = whole.to_i32().unsigned_abs();
        add(&mut weights, at, share * near);
        add(&mut weights, at + 1, share * far);
    }
    let weights = even(weights);
    Ok(match kind {
        Kind::Zvd => even(convolved(&weights, &weights)),
        _ => weights,
    })
}

/// The weights of the samples before and after an impulse of 1 at `x` between them.
fn split<R: Real>(mode: &Mode<R>, x: R) -> [R; 2] {
    if x == R::ZERO {
        return [R::ONE, R::ZERO];
    }
    let omega = R::TAU * mode.hz / R::of(RATE.into());
    let (sigma, v) = (mode.damping * omega, mode.root() * omega);
    let sin = |angle: R| angle.sin_cos().0;
    let per = sin(v);
    [
        (sigma * x).exp() * sin((R::ONE - x) * v) / per,
        (sigma * (x - R::ONE)).exp() * sin(x * v) / per,
    ]
}

/// Both, one after the other.
pub fn convolved<R: Real, const A: usize, const B: usize, const K: usize>(
    first: &Weights<R, A>,
    second: &Weights<R, B>,
) -> Weights<R, K> {
    let mut both = Weights::new();
    for (far, share) in second {
        for (near, weight) in first {
            add(&mut both, far + near, *share * *weight);
        }
    }
    both
}

/// `weights` behind a delay of `samples`, the fraction of which is shared between two samples: its mean is exact.
pub fn delayed<R: Real, const A: usize, const K: usize>(
    weights: &Weights<R, A>,
    samples: R,
) -> Weights<R, K> {
    let whole = samples.floor();
    let mut delay = Weights::<R, 2>::new();
    add(
        &mut delay,
        whole.to_i32().unsigned_abs(),
        R::ONE - (samples - whole),
    );
    add(
        &mut delay,
        whole.to_i32().unsigned_abs() + 1,
        samples - whole,
    );
    convolved(weights, &delay)
}

/// Mean delay [samples].
pub fn mean<R: Real, const K: usize>(weights: &Weights<R, K>) -> R {
    weights.iter().fold(R::ZERO, |sum, (delay, weight)| {
        sum + R::of((*delay).into()) * *weight
    })
}

/// Delay of the last sample.
pub fn length<R, const K: usize>(weights: &Weights<R, K>) -> u32 {
    weights.iter().map(|(delay, _)| *delay).max().unwrap_or(0)
}

fn even<R: Real, const K: usize>(mut weights: Weights<R, K>) -> Weights<R, K> {
    let sum = weights.iter().fold(R::ZERO, |sum, (_, w)| sum + *w);
    for (_, weight) in &mut weights {
        *weight /= sum;
    }
    weights
}

/// Adds a weight, to the one of the same delay where there is one.
fn add<R: Real, const K: usize>(weights: &mut Weights<R, K>, delay: u32, weight: R) {
    if weight == R::ZERO {
        return;
    }
    match weights.iter_mut().find(|(d, _)| *d == delay) {
        Some((_, old)) => *old += weight,
        // Capacities are those of the widest shaper: at most two samples an impulse, three with a delay.
        None => {
            let fits = weights.push((delay, weight)).is_ok();
            debug_assert!(fits, "a shaper has at most {K} weights");
        }
    }
}
