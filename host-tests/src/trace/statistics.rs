//! Events -> the figures of each motor: counts, gaps, pulse widths, direction set-up and hold.

use super::{Change, TICK_HZ, Trace, bits};
use hexstep::stepper::StepMode;
use std::collections::VecDeque;

/// Gaps over which the largest rate is taken: long enough that a tick more or less does not show, short enough that a
/// peak does.
pub const RATE_GAPS: usize = 64;

/// What one motor did over the whole trace. Times in counts of the step timer; `None` where nothing of the kind
/// happened.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorStatistics {
    /// Steps in the positive and in the negative direction.
    pub forward: u64,
    pub backward: u64,
    /// The difference of the two, and the extremes that it went through.
    pub position: i64,
    pub lowest: i64,
    pub highest: i64,
    /// Time of the first and of the last step.
    pub first: Option<u64>,
    pub last: Option<u64>,
    /// Times at which a step went the other way than the one before it.
    pub reversals: u64,
    /// Least time between two steps, whatever their directions.
    pub least_gap: Option<u64>,
    /// Largest rate [steps/s] over [`RATE_GAPS`] successive gaps in one direction; over fewer if no run is as long.
    pub largest_rate: f64,
    /// Least time that the step pin stood high, and low between two pulses. Pulse mode only.
    pub least_high: Option<u64>,
    pub least_low: Option<u64>,
    /// Least time from a change of the direction pin to the next step, and from a step to the next change.
    pub least_setup: Option<u64>,
    pub least_hold: Option<u64>,
}

impl MotorStatistics {
    pub fn steps(&self) -> u64 {
        self.forward + self.backward
    }
}

#[derive(Default)]
struct Watch {
    figures: MotorStatistics,
    rose: Option<u64>,
    fell: Option<u64>,
    turned: Option<u64>,
    last_backward: bool,
    run: VecDeque<u64>,
}

impl Watch {
    fn step(&mut self, time: u64, backward: bool) {
        let figures = &mut self.figures;
        if let Some(last) = figures.last {
            least(&mut figures.least_gap, time - last);
            if backward != self.last_backward {
                figures.reversals += 1;
                self.run.clear();
            }
        }
        self.last_backward = backward;
        figures.first.get_or_insert(time);
        figures.last = Some(time);
        if backward {
            figures.backward += 1;
            figures.position -= 1;
        } else {
            figures.forward += 1;
            figures.position += 1;
        }
        figures.lowest = figures.lowest.min(figures.position);
        figures.highest = figures.highest.max(figures.position);
        if let Some(turned) = self.turned.take() {
            least(&mut figures.least_setup, time - turned);
        }

        if self.run.len() > RATE_GAPS {
            self.run.pop_front();
        }
        self.run.push_back(time);
    }

    /// Rate over the gaps held, if they are as many as `gaps` [steps/s].
    fn rate(&self, gaps: usize) -> f64 {
        let (Some(first), Some(last)) = (self.run.front(), self.run.back()) else {
            return 0.0;
        };
        let held = self.run.len() - 1;
        if held < gaps || last <= first {
            return 0.0;
        }
        held as f64 * TICK_HZ as f64 / (last - first) as f64
    }
}

fn least(slot: &mut Option<u64>, value: u64) {
    *slot = Some(slot.map_or(value, |held| held.min(value)));
}

impl<const N: usize> Trace<N> {
    /// The figures of every motor, in one walk over the events.
    pub fn statistics(&self) -> [MotorStatistics; N] {
        let mut watches: [Watch; N] = core::array::from_fn(|_| Watch::default());
        // A motor whose longest run is short gets the rate of its longest run; its gaps are few, so all are tried.
        let mut short_rates = [(0usize, 0.0f64); N];
        let mut events = self.events();
        let (mut levels, mut directions) = (0, 0);
        while let Some(event) = events.next() {
            match event.change {
                Change::Levels(new) => {
                    if self.mode() == StepMode::Pulse {
                        for motor in bits::<N>(new & !levels) {
                            let watch = &mut watches[motor];
                            if let Some(fell) = watch.fell {
                                least(&mut watch.figures.least_low, event.time - fell);
                            }
                            watch.rose = Some(event.time);
                        }
                        for motor in bits::<N>(levels & !new) {
                            let watch = &mut watches[motor];
                            if let Some(rose) = watch.rose {
                                least(&mut watch.figures.least_high, event.time - rose);
                            }
                            watch.fell = Some(event.time);
                        }
                    }
                    levels = new;
                }
                Change::Directions(new) => {
                    for motor in bits::<N>(new ^ directions) {
                        let watch = &mut watches[motor];
                        watch.turned = Some(event.time);
                        if let Some(last) = watch.figures.last {
                            least(&mut watch.figures.least_hold, event.time - last);
                        }
                    }
                    directions = new;
                }
                Change::Enable(_) => {}
            }
            for motor in bits::<N>(events.stepping()) {
                let watch = &mut watches[motor];
                watch.step(event.time, directions >> motor & 1 == 1);
                let full = watch.rate(RATE_GAPS);
                watch.figures.largest_rate = watch.figures.largest_rate.max(full);
                if watch.figures.largest_rate == 0.0 {
                    let gaps = watch.run.len() - 1;
                    let best = &mut short_rates[motor];
                    let rate = watch.rate(1);
                    if gaps > best.0 || (gaps == best.0 && rate > best.1) {
                        *best = (gaps, rate);
                    }
                }
            }
        }
        core::array::from_fn(|motor| {
            let mut figures = watches[motor].figures;
            if figures.largest_rate == 0.0 {
                figures.largest_rate = short_rates[motor].1;
            }
            figures
        })
    }
}
