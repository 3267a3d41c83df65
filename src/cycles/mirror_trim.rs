//! Trims a two-sided machine while it runs: measured shift of the panel -> bounded, rate-limited offset along the normal.
//!
//! ```text
//! m ->[ gate ]->[ filter ]----->[ amount ]--------->[ rate ]---> out, both sides, the same tick
//!        |        y += a (m-y)    z = +-amount        |  out += +-rate dt at most
//!        `- miss --> more than miss_max: fault, out is held until reset
//! ```
//!
//! The gate drops readings that are missing, not finite, or further than `gate` from the filtered value. Whatever the
//! sensor does, |out| <= amount and |out_k - out_(k-1)| <= rate dt: a wrong reading can only move the pair, slowly and a
//! little. Because the same value goes to both sides in the same tick, noise moves the pair but not the wall it cuts;
//! it shows only as far as the real panel does not follow.
//!
//! tau: noise passes with sigma sqrt(a / (2 - a)), the lag costs tau * feed * slope of the deformation.
//!
//! Contract: lengths in mm, times in s; one call a control tick, at most 80 instructions on the target in f32, no state but
//! a few numbers. How an offset along the normal becomes joints: `machines::two_sided`, [`Pair::trim`].
//!
//! Source: specification of mirror milling, section 5, streaming form. The paper (Liu et al., 2024) trims from a measured
//! pose and gives neither rate, filter nor bounds.
//!
//! [`Pair::trim`]: crate::machines::two_sided::Pair::trim

use crate::math::Real;

/// How a trimmer behaves; every number greater than 0 and finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<R> {
    /// Time between two ticks [s].
    pub dt: R,
    /// Time constant of the filter [s].
    pub tau: R,
    /// Largest offset [mm].
    pub amount: R,
    /// Largest speed of the offset [mm/s].
    pub rate: R,
    /// Largest distance of a reading from the filtered value [mm].
    pub gate: R,
    /// Misses in a row that are borne; one more is a fault.
    pub miss_max: u32,
}

/// `BadLimit`: a parameter is not greater than 0 or not finite; its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadLimit(pub &'static str);

/// What a tick ran into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(u8);

impl Flags {
    /// The reading was further than the gate from the filtered value.
    pub const OUTLIER: Self = Self(1);
    /// The filtered value is beyond the largest offset.
    pub const AMOUNT: Self = Self(2);
    /// Too many misses in a row: the offset is held, the machine must feed-hold.
    pub const FAULT: Self = Self(4);
    /// The offset is on its way, as fast as it may.
    pub const RATE: Self = Self(8);

    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The names of those raised, in the order in which a tick meets them.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        [
            (Self::OUTLIER, "Outlier"),
            (Self::AMOUNT, "Amount"),
            (Self::FAULT, "Fault"),
            (Self::RATE, "Rate"),
        ]
        .into_iter()
        .filter_map(move |(flag, name)| self.contains(flag).then_some(name))
    }

    fn raise(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// The trimmer of one machine.
///
/// ```
/// use hexstep::cycles::mirror_trim::{Flags, Parameters, Trimmer};
///
/// let parameters = Parameters { dt: 0.01, tau: 0.09, amount: 0.1, rate: 2.0, gate: 0.2, miss_max: 2 };
/// let mut trimmer = Trimmer::<f32>::new(&parameters).unwrap();
/// let (out, flags) = trimmer.tick(Some(0.05));
/// assert_eq!(out, 0.02);
/// assert!(flags.contains(Flags::RATE));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trimmer<R> {
    /// a = dt / (tau + dt).
    share: R,
    amount: R,
    /// rate dt [mm].
    step: R,
    gate: R,
    miss_max: u32,
    filtered: R,
    /// What rounding dropped from the filtered value.
    dropped: R,
    out: R,
    misses: u32,
    primed: bool,
    fault: bool,
}

impl<R: Real> Trimmer<R> {
    pub fn new(parameters: &Parameters<R>) -> Result<Self, BadLimit> {
        let p = parameters;
        let limits = [
            ("dt", p.dt),
            ("tau", p.tau),
            ("amount", p.amount),
            ("rate", p.rate),
            ("gate", p.gate),
        ];
        let good = |x: R| x.is_finite() && x > R::ZERO;
        if let Some((name, _)) = limits.iter().find(|(_, x)| !good(*x)) {
            return Err(BadLimit(name));
        }
        Ok(Self {
            share: p.dt / (p.tau + p.dt),
            amount: p.amount,
            step: p.rate * p.dt,
            gate: p.gate,
            miss_max: p.miss_max,
            filtered: R::ZERO,
            dropped: R::ZERO,
            out: R::ZERO,
            misses: 0,
            primed: false,
            fault: false,
        })
    }

    /// One control tick with the shift measured since the last one [mm], `None` for no reading; what is not finite counts
    /// as none. The offset [mm] for both sides.
    pub fn tick(&mut self, measured: Option<R>) -> (R, Flags) {
        let mut flags = Flags::default();
        let reading = measured.filter(|m| m.is_finite()).and_then(|m| {
            let off = m - self.filtered;
            if !self.primed {
                Some((m, R::ZERO))
            } else if off.abs() > self.gate {
                flags.raise(Flags::OUTLIER);
                None
            } else {
                // With a long tau the share is hardly more than a digit of the sum; what rounding drops is kept.
                let change = self.share * off + self.dropped;
                let filtered = self.filtered + change;
                Some((filtered, change - (filtered - self.filtered)))
            }
        });
        if let Some((filtered, dropped)) = reading {
            self.filtered = filtered;
            self.dropped = dropped;
            self.primed = true;
            self.misses = 0;
        } else {
            self.misses = self.misses.saturating_add(1);
            self.fault |= self.misses > self.miss_max;
        }

        let mut wanted = self.filtered;
        if wanted.abs() > self.amount {
            wanted = self.amount.copysign(wanted);
            flags.raise(Flags::AMOUNT);
        }
        if self.fault {
            flags.raise(Flags::FAULT);
            return (self.out, flags);
        }
        let way = wanted - self.out;
        if way.abs() > self.step {
            self.out += self.step.copysign(way);
            flags.raise(Flags::RATE);
        } else {
            // Not out + way: that may round to beyond the amount.
            self.out = wanted;
        }
        (self.out, flags)
    }

    /// The offset of the last tick [mm].
    pub fn out(&self) -> R {
        self.out
    }

    /// The filtered reading [mm].
    pub fn filtered(&self) -> R {
        self.filtered
    }

    /// Whether the offset is held for want of readings.
    pub fn is_faulty(&self) -> bool {
        self.fault
    }

    /// Forgets all readings and the fault; the offset starts again from zero, so the machine must stand at its untrimmed
    /// joints.
    pub fn reset(&mut self) {
        self.filtered = R::ZERO;
        self.dropped = R::ZERO;
        self.out = R::ZERO;
        self.misses = 0;
        self.primed = false;
        self.fault = false;
    }
}
