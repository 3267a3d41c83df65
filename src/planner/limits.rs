//! What the machine and the path allow, checked once: nothing downstream can fail on a number.

/// Largest velocity [steps/s]; 10 million, ten thousand steps a sample.
pub const MOST_VELOCITY: f32 = 1.0e7;
/// Largest acceleration [steps/s^2].
pub const MOST_ACCELERATION: f32 = 1.0e10;
/// Largest jerk [steps/s^3].
pub const MOST_JERK: f32 = 1.0e13;
/// Longest time that a limit may take to build up: velocity by acceleration, acceleration by jerk [s].
pub const LONGEST_RISE: f32 = 100.0;

/// What one joint may do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const N: usize> {
    velocity: [f32; N],
    acceleration: [f32; N],
    jerk: [f32; N],
}

/// Slow enough for any machine: what stands until real limits are set.
impl<const N: usize> Default for Limits<N> {
    fn default() -> Self {
        Self {
            velocity: [1000.0; N],
            acceleration: [1000.0; N],
            jerk: [10_000.0; N],
        }
    }
}

/// Why limits were refused, and for which joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitsError {
    /// Expected a number above 0 and up to [`MOST_VELOCITY`].
    Velocity { joint: usize },
    /// Expected a number above 0 and up to [`MOST_ACCELERATION`].
    Acceleration { joint: usize },
    /// Expected a number above 0 and up to [`MOST_JERK`].
    Jerk { joint: usize },
    /// Velocity / acceleration and acceleration / jerk must not exceed [`LONGEST_RISE`].
    Contradictory { joint: usize },
}

impl<const N: usize> Limits<N> {
    /// Velocity [steps/s], acceleration [steps/s^2], and jerk [steps/s^3] of each joint; all positive and finite.
    pub fn new(
        velocity: [f32; N],
        acceleration: [f32; N],
        jerk: [f32; N],
    ) -> Result<Self, LimitsError> {
        let within = |x: f32, most: f32| x > 0.0 && x <= most;
        for joint in 0..N {
            let (v, a, j) = (velocity[joint], acceleration[joint], jerk[joint]);
            if !within(v, MOST_VELOCITY) {
                return Err(LimitsError::Velocity { joint });
            }
            if !within(a, MOST_ACCELERATION) {
                return Err(LimitsError::Acceleration { joint });
            }
            if !within(j, MOST_JERK) {
                return Err(LimitsError::Jerk { joint });
            }
            if v > LONGEST_RISE * a || a > LONGEST_RISE * j {
                return Err(LimitsError::Contradictory { joint });
            }
        }
        Ok(Self {
            velocity,
            acceleration,
            jerk,
        })
    }

    /// [steps/s]
    pub fn velocity(&self) -> &[f32; N] {
        &self.velocity
    }

    /// [steps/s^2]
    pub fn acceleration(&self) -> &[f32; N] {
        &self.acceleration
    }

    /// [steps/s^3]
    pub fn jerk(&self) -> &[f32; N] {
        &self.jerk
    }
}

/// What deviation means: how far a step of each joint carries the tool, and how far it may stray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSetting<const N: usize> {
    weight: [f32; N],
    tolerance: f32,
}

/// Why a path setting was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathError {
    /// Expected a positive number, and no two weights more than [`WEIGHT_RATIO`] apart.
    Weight { joint: usize },
    /// Expected 0 or a positive number.
    Tolerance,
    /// Weights change the measure of length: only at rest.
    Moving,
}

/// Largest ratio of two weights.
pub const WEIGHT_RATIO: f32 = 1.0e6;

impl<const N: usize> PathSetting<N> {
    pub(super) const UNIT: Self = Self {
        weight: [1.0; N],
        tolerance: 0.0,
    };

    /// `weight`: tip-equivalent length of one step of each joint [mm]. `tolerance`: how far the contour may leave the
    /// programmed path [mm]; 0 stops at every corner.
    pub fn new(weight: [f32; N], tolerance: f32) -> Result<Self, PathError> {
        let most = weight.iter().fold(0.0f32, |m, w| m.max(*w));
        for (joint, w) in weight.iter().enumerate() {
            if !(*w > 0.0 && w.is_finite() && *w * WEIGHT_RATIO >= most && most > 1.0e-20) {
                return Err(PathError::Weight { joint });
            }
        }
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(PathError::Tolerance);
        }
        Ok(Self { weight, tolerance })
    }

    /// [mm per step]
    pub fn weight(&self) -> &[f32; N] {
        &self.weight
    }

    /// [mm]
    pub fn tolerance(&self) -> f32 {
        self.tolerance
    }
}

/// Inverses of the limits per millisecond, as the passes use them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaled<const N: usize> {
    /// 1 / velocity [ms/step].
    pub inverse_v: [f32; N],
    /// 1 / acceleration [ms^2/step].
    pub inverse_a: [f32; N],
    /// 1 / jerk [ms^3/step].
    pub inverse_j: [f32; N],
}

impl<const N: usize> Scaled<N> {
    /// `share` of each limit.
    pub fn new(limits: &Limits<N>, share: f32) -> Self {
        let v = limits.velocity.map(|v| v * share * 1.0e-3);
        let a = limits.acceleration.map(|a| a * share * 1.0e-6);
        let j = limits.jerk.map(|j| j * share * 1.0e-9);
        Self {
            inverse_v: v.map(|v| 1.0 / v),
            inverse_a: a.map(|a| 1.0 / a),
            inverse_j: j.map(|j| 1.0 / j),
        }
    }
}
