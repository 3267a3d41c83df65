//! Pulses of a motor -> deflection of a flexible joint behind it: a mass on a spring, in closed form from step to step.
//!
//! ```text
//!   motor x --/\/\/--[ mass y ]       e = y - x:    e'' + 2 z w e' + w^2 e = -x''
//! ```
//!
//! A step of `h` leaves the mass where it is: `e` falls by `h`, and the damper gives the mass `2 z w h` of speed. Between
//! steps the deflection swings freely. What is left of its amplitude when the motor rests is the residual vibration.

use crate::trace::{Trace, seconds};

/// A mass on a spring with a damper, moved by the spring's other end.
#[derive(Clone, Copy, Debug)]
pub struct Flexible {
    /// Undamped angular frequency [1/s], damping ratio.
    omega: f64,
    damping: f64,
    /// Deflection [unit] and its speed [unit/s].
    deflection: f64,
    speed: f64,
}

impl Flexible {
    /// At rest. Frequency in Hz; damping below 1.
    pub fn new(hz: f64, damping: f64) -> Self {
        Self {
            omega: std::f64::consts::TAU * hz,
            damping,
            deflection: 0.0,
            speed: 0.0,
        }
    }

    /// The motor moves by `h` at once.
    pub fn step(&mut self, h: f64) {
        self.deflection -= h;
        self.speed += 2.0 * self.damping * self.omega * h;
        // The speed is that of the mass less that of the motor, which rests between its steps.
    }

    /// Swings for `dt` [s].
    pub fn swing(&mut self, dt: f64) {
        let sigma = self.damping * self.omega;
        let damped = self.omega * (1.0 - self.damping * self.damping).sqrt();
        let (sin, cos) = (damped * dt).sin_cos();
        let decay = (-sigma * dt).exp();
        let (e, v) = (self.deflection, self.speed);
        let other = (v + sigma * e) / damped;
        self.deflection = decay * (e * cos + other * sin);
        self.speed =
            decay * ((other * damped - sigma * e) * cos - (e * damped + sigma * other) * sin);
    }

    pub fn deflection(&self) -> f64 {
        self.deflection
    }

    /// How far it would swing from now on, but for what damping takes.
    pub fn amplitude(&self) -> f64 {
        let damped = self.omega * (1.0 - self.damping * self.damping).sqrt();
        let other = (self.speed + self.damping * self.omega * self.deflection) / damped;
        self.deflection.hypot(other)
    }
}

/// The deflection behind one motor of a trace.
#[derive(Clone, Debug, Default)]
pub struct Swing {
    /// Time [s] and deflection [unit], every half millisecond and for a while behind the last step.
    pub samples: Vec<(f64, f64)>,
    /// The largest deflection either way [unit].
    pub largest: f64,
    /// Amplitude when the motor has made its last step [unit].
    pub residual: f64,
    /// Time of that step [s].
    pub end: f64,
}

impl Swing {
    /// Behind `motor`, which makes `steps` a unit; shown until `rest` [s] after its last step.
    pub fn of<const N: usize>(
        trace: &Trace<N>,
        motor: usize,
        steps: f64,
        mut joint: Flexible,
        rest: f64,
    ) -> Self {
        const EVERY: f64 = 0.5e-3;
        let mut swing = Self::default();
        let (mut now, mut shown) = (0.0, 0u32);
        let mut until = |time: f64, joint: &mut Flexible, swing: &mut Self| {
            // Every half millisecond on the way, then at the instant itself.
            while f64::from(shown) * EVERY < time {
                let at = f64::from(shown) * EVERY;
                joint.swing(at - now);
                now = at;
                shown += 1;
                swing.samples.push((at, joint.deflection()));
                swing.largest = swing.largest.max(joint.deflection().abs());
            }
            joint.swing(time - now);
            now = time;
        };
        for step in trace.steps_of(motor) {
            swing.end = seconds(step.time);
            until(swing.end, &mut joint, &mut swing);
            joint.step(f64::from(step.sign) / steps);
        }
        swing.residual = joint.amplitude();
        until(swing.end + rest, &mut joint, &mut swing);
        swing
    }
}
