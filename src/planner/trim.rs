//! A bounded, rate-limited offset for each joint, added while a program runs.
//!
//! ```text
//!  target --> slope at most r --> mean over 32 ms --> mean over 32 ms --> offset
//!
//!  speed <= r,   acceleration <= 2 r / T,   jerk <= 4 r / T^2,    T = 32 ms (a slope that turns from -r to r is the worst)
//! ```
//!
//! All in integers: means of 32 samples keep a constant exactly, so an offset ends on its whole step.

/// Samples of each mean.
const BOX: usize = 32;
/// Largest offset [steps].
pub const MOST_TRIM: i32 = 1 << 14;

/// The offsets of all joints.
pub(super) struct Trim<const N: usize> {
    /// All in units of 2^-16 step, below 2^30.
    target: [i32; N],
    slope: [i32; N],
    rate: [i32; N],
    first: [[i32; BOX]; N],
    /// Sums of 32 values, below 2^35; of 32 such sums, below 2^40.
    first_sum: [i64; N],
    second: [[i64; BOX]; N],
    second_sum: [i64; N],
    at: usize,
    /// Samples until all means are full of one value.
    settling: u16,
    bound: [i32; N],
}

impl<const N: usize> Trim<N> {
    pub const fn new() -> Self {
        Self {
            target: [0; N],
            slope: [0; N],
            rate: [0; N],
            first: [[0; BOX]; N],
            first_sum: [0; N],
            second: [[0; BOX]; N],
            second_sum: [0; N],
            at: 0,
            settling: 0,
            bound: [0; N],
        }
    }

    /// Largest offset of each joint [steps], and the share of velocity, acceleration and jerk [per ms] that it may use.
    pub fn allow(&mut self, bound: &[i32; N], v: &[f32; N], a: &[f32; N], j: &[f32; N]) {
        self.bound = bound.map(|b| b.clamp(0, MOST_TRIM));
        let t = BOX as f32;
        for i in 0..N {
            let rate = v[i].min(0.5 * a[i] * t).min(0.25 * j[i] * t * t);
            self.rate[i] = (rate * 65_536.0) as i32;
        }
    }

    /// New offset of one joint [steps]; held to the bound. Returns what was taken.
    pub fn set(&mut self, joint: usize, steps: i32) -> i32 {
        let (Some(target), Some(bound)) = (self.target.get_mut(joint), self.bound.get(joint))
        else {
            return 0;
        };
        let steps = steps.clamp(-bound, *bound);
        *target = steps << 16;
        self.settling = 2 * BOX as u16;
        steps
    }

    /// Offset of one joint to come [steps].
    pub fn target(&self, joint: usize) -> i32 {
        self.target.get(joint).map_or(0, |target| target >> 16)
    }

    /// Fastest change of one joint's offset [steps/s].
    pub fn rate(&self, joint: usize) -> f32 {
        self.rate
            .get(joint)
            .map_or(0.0, |rate| *rate as f32 * (1000.0 / 65_536.0))
    }

    /// Every offset ends at the whole step nearest to where its slope is.
    pub fn freeze(&mut self) {
        if self.is_settled() {
            return;
        }
        for (target, slope) in self.target.iter_mut().zip(&self.slope) {
            *target = (*slope + (1 << 15)) >> 16 << 16;
        }
        self.settling = 2 * BOX as u16;
    }

    pub fn is_settled(&self) -> bool {
        self.settling == 0
    }

    /// Offset of one joint in units of 2^-32 step.
    pub fn offset(&self, joint: usize) -> i64 {
        // 2^-16 step times 1024.
        self.second_sum.get(joint).map_or(0, |s| s << 6)
    }

    /// One millisecond later.
    pub fn advance(&mut self) {
        if self.settling == 0 {
            return;
        }
        self.at = (self.at + 1) % BOX;
        let mut arrived = true;
        for i in 0..N {
            let way = self.target[i] - self.slope[i];
            self.slope[i] += way.clamp(-self.rate[i], self.rate[i]);
            arrived &= self.slope[i] == self.target[i] || self.rate[i] == 0;
            if let Some(old) = self.first[i].get_mut(self.at) {
                self.first_sum[i] += i64::from(self.slope[i] - *old);
                *old = self.slope[i];
            }
            if let Some(old) = self.second[i].get_mut(self.at) {
                self.second_sum[i] += self.first_sum[i] - *old;
                *old = self.first_sum[i];
            }
        }
        if arrived {
            self.settling -= 1;
        } else {
            self.settling = 2 * BOX as u16;
        }
    }
}
