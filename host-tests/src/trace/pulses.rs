//! Events -> steps: the edges that move a motor, with their sign.

use super::{Events, Trace, bits};

/// The steps of one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulse<const N: usize> {
    pub tick: u64,
    /// [counts]
    pub time: u64,
    /// Motors that step, bit i = motor i.
    pub motors: u8,
    /// Those of them that step backward.
    pub backward: u8,
    /// Positions after it [steps].
    pub positions: [i64; N],
}

/// One step of one motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    pub tick: u64,
    /// [counts]
    pub time: u64,
    /// 1 or -1.
    pub sign: i8,
    /// Position after it [steps].
    pub position: i64,
}

/// The steps of all motors in order.
#[derive(Clone, Debug)]
pub struct Pulses<'a, const N: usize> {
    events: Events<'a, N>,
}

impl<const N: usize> Iterator for Pulses<'_, N> {
    type Item = Pulse<N>;

    #[inline]
    fn next(&mut self) -> Option<Pulse<N>> {
        loop {
            let event = self.events.next()?;
            let motors = self.events.stepping();
            if motors != 0 {
                let state = self.events.state();
                return Some(Pulse {
                    tick: event.tick,
                    time: event.time,
                    motors,
                    backward: motors & state.directions,
                    positions: state.positions,
                });
            }
        }
    }
}

impl<const N: usize> Trace<N> {
    /// The steps of all motors, one item for each instant at which at least one motor steps.
    pub fn pulses(&self) -> Pulses<'_, N> {
        Pulses {
            events: self.events(),
        }
    }

    /// The steps at `time` [counts] and later.
    pub fn pulses_from(&self, time: u64) -> Pulses<'_, N> {
        Pulses {
            events: self.events_from(time).1,
        }
    }

    /// The steps of one motor; none for a motor that the trace does not have.
    pub fn steps_of(&self, motor: usize) -> impl Iterator<Item = Step> + '_ {
        self.pulses().filter_map(move |pulse| pulse.step_of(motor))
    }
}

impl<const N: usize> Pulse<N> {
    /// The step of one motor, if it steps here.
    pub fn step_of(&self, motor: usize) -> Option<Step> {
        bits::<N>(self.motors)
            .any(|stepping| stepping == motor)
            .then(|| Step {
                tick: self.tick,
                time: self.time,
                sign: if self.backward >> motor & 1 == 0 {
                    1
                } else {
                    -1
                },
                position: self.positions[motor],
            })
    }
}

impl<const N: usize> Trace<N> {
    /// Time [counts] and positions [steps] every `counts` counts from 0 to the end of the trace.
    pub fn positions_every(&self, counts: u64) -> impl Iterator<Item = (u64, [i64; N])> + '_ {
        let counts = counts.max(1);
        let mut pulses = self.pulses().peekable();
        let mut positions = [0; N];
        (0..=self.end() / counts).map(move |k| {
            let time = k * counts;
            while let Some(pulse) = pulses.next_if(|pulse| pulse.time <= time) {
                positions = pulse.positions;
            }
            (time, positions)
        })
    }
}
