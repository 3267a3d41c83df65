//! The ratio-integral rule in its compare form: the reference that the carry form is proved against.
//!
//! ```text
//! s = acc[i] + R[i];   if s >= MAX { step; acc[i] = s - MAX } else { acc[i] = s }
//! ```
//!
//! `R[i] = |M[i]|`, `MAX >= max R[i]`, `acc[i]` preset to `R[i]` (the paper) or to `MAX / 2`. After k ticks motor i has
//! made `floor((preset + k R) / MAX)` steps, so after MAX ticks exactly `R[i]`, never more than one step away from the
//! straight line, with gaps of `floor(MAX/R)` or `ceil(MAX/R)` ticks. (Paper 001 prints the test as `R/MAX >= 1`,
//! which would only ever move the longest axis.)

/// What the accumulators hold before the first tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Preset {
    /// `R[i]`, as the paper has it: deviation from the line between -1 and +R/MAX steps.
    #[default]
    Published,
    /// `floor(MAX / 2)`: deviation at most half a step either way.
    Centred,
}

/// A move of N motors, one tick after another. An iterator of step masks (motor 0 in bit 0).
#[derive(Clone, Debug)]
pub struct Rule<const N: usize> {
    r: [u64; N],
    acc: [u64; N],
    max: u64,
    left: u64,
}

/// Largest step count of a move: twice it still fits the accumulator.
pub const LARGEST_COUNT: u64 = 1 << 62;

impl<const N: usize> Rule<N> {
    /// The rule for signed step counts `m` spread over `max` ticks; `None` if a count exceeds 2^62 or `max`, or if
    /// `max` exceeds 2^62. `max = 0` stands for the largest count, as in the paper.
    pub fn new(m: &[i64; N], max: u64, preset: Preset) -> Option<Self> {
        let r: [u64; N] = core::array::from_fn(|i| m[i].unsigned_abs());
        let largest = r.iter().copied().max().unwrap_or(0);
        let max = if max == 0 { largest } else { max };
        if largest > max || max > LARGEST_COUNT {
            return None;
        }
        let acc = match preset {
            Preset::Published => r,
            Preset::Centred => [max / 2; N],
        };
        Some(Self {
            r,
            acc,
            max,
            left: max,
        })
    }

    /// The accumulators as they stand.
    pub fn accumulators(&self) -> &[u64; N] {
        &self.acc
    }
}

impl<const N: usize> Iterator for Rule<N> {
    type Item = u8;

    fn next(&mut self) -> Option<u8> {
        self.left = self.left.checked_sub(1)?;
        let mut steps = 0;
        for (i, (acc, r)) in self.acc.iter_mut().zip(&self.r).enumerate() {
            // At most 2 * 2^62, so the sum cannot wrap.
            *acc += r;
            if *acc >= self.max {
                *acc -= self.max;
                steps |= 1 << i;
            }
        }
        Some(steps)
    }
}
