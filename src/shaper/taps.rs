//! The shapers of all joints, delayed so that their means agree -> integer weights that sum to exactly one.

use super::design::{self, DELAYED_TAPS, Kind, Mode, Reason, TAPS, Weights};
use crate::math::Real;

/// Samples that are remembered for each joint, on the average: one with a longer shaper takes of what others leave.
pub const HISTORY: usize = 80;
/// Longest shaper of a joint [samples].
pub const LONGEST: u32 = 254;

/// The sum of all weights.
const ONE: i32 = 1 << WEIGHT_BITS;
pub(super) const WEIGHT_BITS: u32 = 30;

/// What a joint's command is shaped by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    pub kind: Kind,
    pub first: Mode<f32>,
    pub second: Option<Mode<f32>>,
}

/// Why a shaper was refused, and for which joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    pub joint: usize,
    pub reason: Reason,
}

/// Weights in units of 2^-30, with sum 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Taps<const K: usize> {
    delays: [u8; K],
    weights: [i32; K],
    pub count: u8,
}

impl<const K: usize> Taps<K> {
    /// The present sample alone.
    const THROUGH: Self = {
        let mut weights = [0; K];
        weights[0] = ONE;
        Self {
            delays: [0; K],
            weights,
            count: 1,
        }
    };

    fn of(weights: &Weights<f32, K>) -> Self {
        let mut taps = Self {
            delays: [0; K],
            weights: [0; K],
            count: weights.len() as u8,
        };
        let (mut left, mut largest) = (ONE, 0);
        for (k, (delay, weight)) in weights.iter().enumerate() {
            // Below 2^30, and delays up to LONGEST.
            let scaled = Real::round(*weight * ONE as f32) as i32;
            taps.delays[k] = *delay as u8;
            taps.weights[k] = scaled;
            left -= scaled;
            if scaled > taps.weights[largest] {
                largest = k;
            }
        }
        taps.weights[largest] += left;
        taps
    }

    pub fn iter(&self) -> impl Iterator<Item = (usize, i64)> + '_ {
        let all = self.delays.iter().zip(&self.weights);
        all.take(self.count.into())
            .map(|(delay, weight)| (usize::from(*delay), i64::from(*weight)))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Joint {
    pub first: Taps<DELAYED_TAPS>,
    pub second: Taps<TAPS>,
    /// Samples that are remembered, the present one included.
    pub samples: u8,
    /// Units of the ring are 2^(shift - 32) steps.
    pub shift: u8,
}

/// The shapers of N joints, worked out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Design<const N: usize> {
    pub(super) joints: [Joint; N],
    /// Samples after which a rest of the command is one of the output; 0: nothing is shaped.
    pub(super) length: u8,
}

impl<const N: usize> Design<N> {
    /// Nothing is shaped.
    pub const OFF: Self = Self {
        joints: [Joint {
            first: Taps::THROUGH,
            second: Taps::THROUGH,
            samples: 1,
            shift: 0,
        }; N],
        length: 0,
    };

    /// The shapers of joints that move no faster than `fastest` [steps/s].
    pub fn new(wishes: &[Wish; N], fastest: &[f32; N]) -> Result<Self, Refusal> {
        if wishes.iter().all(|wish| wish.kind == Kind::Off) {
            return Ok(Self::OFF);
        }
        let mut means = [0.0; N];
        for joint in 0..N {
            let [first, second] = shapers(&wishes[joint], joint)?;
            means[joint] = design::mean(&first) + design::mean(&second);
        }
        let latest = means.iter().fold(0.0, |a, b| Real::max(a, *b));
        let mut design = Self::OFF;
        let (mut all, mut longest) = (
            0,
            Refusal {
                joint: 0,
                reason: Reason::TooLong { samples: 0 },
            },
        );
        for joint in 0..N {
            let [first, second] = shapers(&wishes[joint], joint)?;
            let first = design::delayed(&first, Real::max(latest - means[joint], 0.0));
            let samples = design::length(&first) + design::length(&second);
            let reason = Reason::TooLong { samples };
            if samples > LONGEST {
                return Err(Refusal { joint, reason });
            }
            if samples > design.length() {
                design.length = samples as u8;
                longest = Refusal { joint, reason };
            }
            all += samples as usize + 1;
            design.joints[joint] = Joint {
                first: Taps::of(&first),
                second: Taps::of(&second),
                samples: samples as u8 + 1,
                shift: scale(fastest[joint], samples),
            };
        }
        if all > N * HISTORY {
            return Err(longest);
        }
        Ok(design)
    }

    /// Samples from the last of the command to the last of the output.
    pub fn length(&self) -> u32 {
        self.length.into()
    }
}

/// Both shapers of a joint.
fn shapers(wish: &Wish, joint: usize) -> Result<[Weights<f32, TAPS>; 2], Refusal> {
    let off = Mode::default();
    let (kind, second) = match &wish.second {
        Some(second) => (wish.kind, second),
        None => (Kind::Off, &off),
    };
    let refused = |reason| Refusal { joint, reason };
    Ok([
        design::sampled(wish.kind, &wish.first).map_err(refused)?,
        design::sampled(kind, second).map_err(refused)?,
    ])
}

/// The finest scale by which the way in so many samples, at a quarter more than the speed [steps/s], stays below 2^31.
fn scale(fastest: f32, samples: u32) -> u8 {
    let way = fastest * (1.25 * samples as f32 / design::RATE as f32);
    // Up to 10^7 steps/s, so below 2^22 steps.
    let bits = 32 - (way as u32).leading_zeros();
    (bits + 1) as u8
}
