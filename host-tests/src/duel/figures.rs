//! Pulses -> the figures by which all controllers are compared.
//!
//! A pulse stands for the middle between two whole steps, and between its pulses a joint's position is linear. On a grid of
//! 0.25 ms it is filtered by a Gaussian and derived by that Gaussian's own derivatives: sigma 2 ms for the speed, 4 ms for
//! the acceleration, 8 ms for the jerk. Other controllers were judged so, which is why the filter is not that of reports.
//! At 80 steps per mm a flawless motion shows up to a tenth too much jerk through it, at 1000 below a hundredth.

use super::paths::Steady;
use crate::report::ContourError;
use crate::trace::{Trace, seconds};

/// Figures of a motion. Joints in their units, seconds.
#[derive(Clone, Debug, Default)]
pub struct Figures {
    /// From the first pulse to the last.
    pub time: f64,
    /// Largest of each joint.
    pub velocity: [f64; 6],
    pub acceleration: [f64; 6],
    pub jerk: [f64; 6],
    /// Largest distance of the motion from the path in order [mm].
    pub aside: f64,
    /// Largest distance of a programmed point from the motion in order [mm].
    pub cut: f64,
    /// How far apart both are as a whole [mm].
    pub apart: f64,
    /// (largest - least) / mean of the speed where the feed should be constant, the worst stretch; and the mean there.
    pub ripple: Option<(f64, f64)>,
}

/// Grid [s], and rest shown before the first and behind the last pulse.
const CELL: f64 = 0.25e-3;
const AIR: f64 = 0.06;
/// Widths of the filters for the first, the second and the third derivative [s].
const SIGMA: [f64; 3] = [2e-3, 4e-3, 8e-3];

impl Figures {
    pub fn of(trace: &Trace<6>, steps: f64, contour: &ContourError, steady: Steady) -> Self {
        let mut knots: [Vec<(f64, f64)>; 6] = Default::default();
        for (motor, knots) in knots.iter_mut().enumerate() {
            let at = |step: crate::trace::Step| {
                let place = step.position as f64 - 0.5 * f64::from(step.sign);
                (seconds(step.time), place / steps)
            };
            knots.extend(trace.steps_of(motor).map(at));
        }
        let firsts = knots.iter().filter_map(|knots| knots.first());
        let lasts = knots.iter().filter_map(|knots| knots.last());
        let first = firsts.map(|knot| knot.0).fold(f64::INFINITY, f64::min);
        let last = lasts.map(|knot| knot.0).fold(f64::NEG_INFINITY, f64::max);
        let mut figures = Self {
            aside: contour.aside,
            cut: contour.cut,
            apart: contour.largest,
            ..Self::default()
        };
        if first > last {
            return figures;
        }
        figures.time = last - first;
        let cells = ((last - first + 2.0 * AIR) / CELL).ceil() as usize;
        let places = knots.map(|knots| on_grid(&knots, first - AIR, cells));
        let filters = [0, 1, 2].map(|order| filter(SIGMA[order], order));
        let largest = |list: &[f64]| list.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let mut speeds = vec![0.0; cells];
        for (motor, places) in places.iter().enumerate() {
            let velocity = derived(places, &filters[0]);
            figures.velocity[motor] = largest(&velocity);
            figures.acceleration[motor] = largest(&derived(places, &filters[1]));
            figures.jerk[motor] = largest(&derived(places, &filters[2]));
            // Feeds count along the joints that slide.
            if motor < crate::job::FIRST_TURNING {
                for (sum, v) in speeds.iter_mut().zip(velocity) {
                    *sum += v * v;
                }
            }
        }
        for speed in &mut speeds {
            *speed = speed.sqrt();
        }
        figures.ripple = ripple(&speeds, &places[0], steady);
        figures
    }

    /// The largest of all joints.
    pub fn largest(of: &[f64; 6]) -> f64 {
        of.iter().fold(0.0, |most, x| most.max(*x))
    }
}

/// Positions on the grid; level before the first knot and behind the last.
fn on_grid(knots: &[(f64, f64)], start: f64, cells: usize) -> Vec<f64> {
    let mut next = 0;
    let at = |k: usize| {
        let t = start + k as f64 * CELL;
        while next < knots.len() && knots[next].0 <= t {
            next += 1;
        }
        match (next.checked_sub(1).map(|i| knots[i]), knots.get(next)) {
            (Some((t0, x0)), Some((t1, x1))) => x0 + (x1 - x0) * (t - t0) / (t1 - t0),
            (Some((_, x)), None) | (None, Some(&(_, x))) => x,
            (None, None) => 0.0,
        }
    };
    (0..cells).map(at).collect()
}

/// A derivative of a Gaussian on the grid, of order one, two or three for 0, 1, 2.
fn filter(sigma: f64, order: usize) -> Vec<f64> {
    let half = (6.0 * sigma / CELL).ceil() as i64;
    let bells = (-half..=half).map(|k| {
        let u = k as f64 * CELL / sigma;
        (u, (-0.5 * u * u).exp())
    });
    let bells: Vec<(f64, f64)> = bells.collect();
    let sum: f64 = bells.iter().map(|(_, g)| g).sum();
    let derivative = |(u, g): (f64, f64)| {
        let g = g / sum;
        match order {
            0 => -u / sigma * g,
            1 => (u * u - 1.0) / sigma.powi(2) * g,
            _ => (3.0 * u - u.powi(3)) / sigma.powi(3) * g,
        }
    };
    bells.into_iter().map(derivative).collect()
}

fn derived(places: &[f64], filter: &[f64]) -> Vec<f64> {
    let Some((first, last)) = places.first().zip(places.last()) else {
        return Vec::new();
    };
    let half = filter.len() / 2;
    // From the first place, so that the filter's rounding does not show.
    let mut padded = vec![0.0; half];
    padded.extend(places.iter().map(|x| x - first));
    padded.extend(std::iter::repeat_n(last - first, half));
    let at = |window: &[f64]| {
        let products = window.iter().rev().zip(filter).map(|(x, g)| x * g);
        products.sum::<f64>()
    };
    padded.windows(filter.len()).map(at).collect()
}

fn ripple(speeds: &[f64], first_joint: &[f64], steady: Steady) -> Option<(f64, f64)> {
    let way: f64 = speeds.iter().sum();
    let mut so_far = 0.0;
    let shares: Vec<f64> = speeds
        .iter()
        .map(|speed| {
            so_far += speed;
            so_far / way
        })
        .collect();
    // The stretch of each sample, where it lies in one.
    let stretch = |k: usize| match steady {
        Steady::Nowhere => None,
        Steady::Legs(legs, from, to) => {
            let place = shares[k] * f64::from(legs);
            let within = place.fract();
            (within > from && within < to).then_some(place as usize)
        }
        Steady::Between(from, to) => (first_joint[k] > from && first_joint[k] < to).then_some(0),
    };
    let mut worst: Option<f64> = None;
    let mut means = Vec::new();
    let mut run: Vec<f64> = Vec::new();
    let mut inside = None;
    for k in 0..=speeds.len() {
        let here = if k < speeds.len() { stretch(k) } else { None };
        if here != inside && !run.is_empty() {
            let mean = run.iter().sum::<f64>() / run.len() as f64;
            let most = run.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
            let least = run.iter().fold(f64::INFINITY, |a, b| a.min(*b));
            let ripple = (most - least) / mean;
            worst = Some(worst.map_or(ripple, |worst| worst.max(ripple)));
            means.push(mean);
            run.clear();
        }
        inside = here;
        if here.is_some() {
            run.push(speeds[k]);
        }
    }
    worst.map(|worst| (worst, means.iter().sum::<f64>() / means.len() as f64))
}
