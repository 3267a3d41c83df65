//! Pulses and a programmed path -> how far the joints are off the path, at every instant.
//!
//! The joints, rebuilt from the pulses at every instant at which one steps, and the polyline of the programmed points are
//! both weighted to mm at the tool and compared in order (`frechet.rs`).

use crate::frechet;
use crate::trace::{Trace, bits, seconds};
use std::collections::VecDeque;

/// Most instants that are looked at: of more, those are left out that follow too soon on the one before.
const MOST: u64 = 4_000_000;
/// How exact distances are [mm].
const GRAIN: f64 = 2e-5;

/// The distance of the joints from the path over time.
#[derive(Clone, Debug, Default)]
pub struct ContourError {
    /// Time [s] and distance from the path in order [mm].
    pub samples: Vec<(f64, f64)>,
    /// The straight move that each sample has come to.
    pub blocks: Vec<usize>,
    /// Joints at these samples [unit].
    pub joints: Vec<[f64; 6]>,
    /// How far apart both lie, run through in order (Fréchet distance) [mm].
    pub largest: f64,
    /// Largest distance of a sample from the path [mm].
    pub aside: f64,
    /// Largest distance of a programmed point from the motion [mm].
    pub cut: f64,
}

impl ContourError {
    /// Compares a trace with the polyline through `points` [unit]; `steps` are steps per unit, `weights` mm per unit. With
    /// `ends_early` the motion may end anywhere on it.
    pub fn of(
        trace: &Trace<6>,
        points: &[[f64; 6]],
        steps: &[f64; 6],
        weights: &[f64; 6],
        ends_early: bool,
    ) -> Self {
        let weighted = |at: &[f64; 6]| std::array::from_fn(|i| at[i] * weights[i]);
        let vertices: Vec<[f64; 6]> = points.iter().map(weighted).collect();
        let (times, joints) = instants(trace, steps);
        let motion: Vec<[f64; 6]> = joints.iter().map(weighted).collect();
        let apart = frechet::apart(&motion, &vertices, ends_early, GRAIN);
        let aside = &apart.aside;
        Self {
            samples: aside.iter().map(|a| (times[a.point], a.distance)).collect(),
            blocks: aside.iter().map(|a| a.chord).collect(),
            joints: aside.iter().map(|a| joints[a.point]).collect(),
            largest: apart.distance,
            aside: aside.iter().fold(0.0, |most, a| most.max(a.distance)),
            cut: apart.cut,
        }
    }
}

/// Times [s] and joints [unit] wherever a motor steps: each on the line through its crossings of half steps, and on whole
/// steps before the first and behind the last of them.
fn instants(trace: &Trace<6>, steps: &[f64; 6]) -> (Vec<f64>, Vec<[f64; 6]>) {
    // Crossings of each motor: time [counts] and place [steps].
    let mut crossings: [VecDeque<(u64, f64)>; 6] = Default::default();
    let mut when: Vec<u64> = Vec::new();
    for pulse in trace.pulses() {
        when.push(pulse.time);
        for motor in bits::<6>(pulse.motors) {
            if let Some(step) = pulse.step_of(motor) {
                let at = step.position as f64 - 0.5 * f64::from(step.sign);
                crossings[motor].push_back((step.time, at));
            }
        }
    }
    let (first, last) = (when.first().copied(), when.last().copied());
    let least = (last.unwrap_or(0) - first.unwrap_or(0)) / MOST;
    let mut before: [(u64, f64); 6] = [(0, 0.0); 6];
    let mut begun = [false; 6];
    let mut times = vec![seconds(first.unwrap_or(0))];
    let mut joints = vec![[0.0; 6]];
    let mut kept = 0;
    for time in when {
        // The first instant of a motor, and every one that is not too soon.
        let mut at = [0.0; 6];
        for motor in 0..6 {
            let queue = &mut crossings[motor];
            while let Some(passed) = queue.front().copied().filter(|c| c.0 <= time) {
                before[motor] = passed;
                begun[motor] = true;
                queue.pop_front();
            }
            let (t0, x0) = before[motor];
            let x = match queue.front() {
                _ if t0 == time => x0,
                Some((t1, x1)) if begun[motor] => {
                    x0 + (x1 - x0) * (time - t0) as f64 / (t1 - t0) as f64
                }
                Some(_) => 0.0,
                None if begun[motor] => trace.positions()[motor] as f64,
                None => 0.0,
            };
            at[motor] = x / steps[motor];
        }
        if time - kept >= least {
            kept = time;
            times.push(seconds(time));
            joints.push(at);
        }
    }
    times.push(seconds(last.unwrap_or(0)));
    joints.push(std::array::from_fn(|i| {
        trace.positions()[i] as f64 / steps[i]
    }));
    (times, joints)
}
