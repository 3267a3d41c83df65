//! A straight joint-space move, its limits, and the speed allowed at the corner before it.

use super::SAMPLE;
use crate::math::Real;

/// What each motor may do at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<const N: usize> {
    velocity: [f32; N],
    acceleration: [f32; N],
}

/// Slow enough for any machine: what stands until real limits are set.
impl<const N: usize> Default for Limits<N> {
    fn default() -> Self {
        Self {
            velocity: [1000.0; N],
            acceleration: [1000.0; N],
        }
    }
}

/// A limit that no motion can keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitError {
    /// The velocity of this motor is not a positive number, or beyond `most` steps/s.
    Velocity { motor: usize },
    /// The acceleration of this motor is not a positive number.
    Acceleration { motor: usize },
}

impl<const N: usize> Limits<N> {
    /// Velocities [steps/s], above 0 and at most `fastest`; accelerations [steps/s^2], above 0.
    pub fn new(
        velocity: [f32; N],
        acceleration: [f32; N],
        fastest: f32,
    ) -> Result<Self, LimitError> {
        for motor in 0..N {
            if !(velocity[motor] > 0.0 && velocity[motor] <= fastest) {
                return Err(LimitError::Velocity { motor });
            }
            if !(acceleration[motor] > 0.0 && acceleration[motor].is_finite()) {
                return Err(LimitError::Acceleration { motor });
            }
        }
        Ok(Self {
            velocity,
            acceleration,
        })
    }
}

/// Share of a joint's acceleration that the change of speed along a block may use; corners have the rest.
const ALONG: f32 = 0.75;

/// A straight move in joint space that is not over yet.
#[derive(Clone, Copy, Debug)]
pub struct Block<const N: usize> {
    /// Where it begins [steps].
    pub start: [i32; N],
    /// Steps from there to its end.
    pub steps: [i32; N],
    /// Time that it takes at speed 1 [s].
    pub length: f32,
    /// Highest speed, 0 ..= 1.
    pub nominal: f32,
    /// Largest change of speed in time [1/s].
    pub acceleration: f32,
    /// Largest speed at the corner before it.
    pub entry_limit: f32,
    /// Planned speed at its beginning and at its end.
    pub entry: f32,
    pub exit: f32,
}

impl<const N: usize> Block<N> {
    /// The move from `start` to `target` in `duration` [s] at the least; `None` if they are the same.
    pub fn new(
        limits: &Limits<N>,
        start: [i32; N],
        target: [i32; N],
        duration: f32,
    ) -> Option<Self> {
        // The difference of two i32 needs 33 bits; the controller refuses moves beyond 2^31.
        let steps: [i32; N] = core::array::from_fn(|i| target[i].wrapping_sub(start[i]));
        let mut length = 0f32;
        for i in 0..N {
            length = Real::max(length, (steps[i] as f32).abs() / limits.velocity[i]);
        }
        if length <= 0.0 {
            return None;
        }
        let mut acceleration = f32::MAX;
        for i in 0..N {
            let way = (steps[i] as f32).abs();
            if way > 0.0 {
                acceleration = Real::min(acceleration, limits.acceleration[i] * length / way);
            }
        }
        let nominal = if duration > length {
            length / duration
        } else {
            1.0
        };
        Some(Self {
            start,
            steps,
            length,
            nominal,
            acceleration: acceleration * ALONG,
            entry_limit: 0.0,
            entry: 0.0,
            exit: 0.0,
        })
    }

    pub fn end(&self) -> [i32; N] {
        core::array::from_fn(|i| self.start[i].wrapping_add(self.steps[i]))
    }
}

/// The largest speed at which no joint's velocity jumps at the corner by more than a quarter of its acceleration limit
/// gives in one sample.
pub fn junction<const N: usize>(limits: &Limits<N>, before: &Block<N>, after: &Block<N>) -> f32 {
    let mut speed = Real::min(before.nominal, after.nominal);
    for i in 0..N {
        let jump =
            (after.steps[i] as f32 / after.length - before.steps[i] as f32 / before.length).abs();
        let allowed = limits.acceleration[i] * (1.0 - ALONG) * SAMPLE;
        if jump * speed > allowed {
            speed = allowed / jump;
        }
    }
    speed
}
