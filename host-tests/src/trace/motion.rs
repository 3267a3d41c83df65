//! Steps -> motion: position, speed, acceleration and jerk of a motor, rebuilt from its pulses alone.
//!
//! An edge from n to n+1 says that the commanded position crosses n + 1/2 at that instant. The straight lines between
//! those crossings are averaged over cells of equal time, and in a window of 2 m + 1 cells around each cell
//! (m = [`HALF_WINDOW`]) the cubic of least squares is laid; its derivatives in the middle are the answer (Savitzky and
//! Golay 1964, the closed forms for a cubic):
//!
//! ```text
//! S_k = sum i^k,  i = -m .. m          T_k = sum i^k y_i
//! c1 = (S6 T1 - S4 T3) / (S2 S6 - S4^2)          speed        = c1 / cell
//! c2 = (S0 T2 - S2 T0) / (S0 S4 - S2^2)          acceleration = 2 c2 / cell^2
//! c3 = (S2 T3 - S4 T1) / (S2 S6 - S4^2)          jerk         = 6 c3 / cell^3
//! ```
//!
//! How good: a cubic motion is returned exactly; a corner of the speed is rounded over a window. An edge is late by up to
//! a tick, so at rate v and tick time t the position is uncertain by e = v t of a step; averaged over the n edges of a
//! window w that leaves about 30 e / (w^2 sqrt n) of noise in the acceleration and 320 e / (w^3 sqrt n) in the jerk. A window
//! should hold ten steps at least where acceleration is judged. At rest the position stays half a step
//! short of the whole one: no edge tells more, and within a window of a start or a stop the acceleration may be
//! 2 steps / w^2 off.

use super::{TICK_HZ, Trace};

/// Cells to either side of the middle one in a window.
pub const HALF_WINDOW: usize = 8;

/// One motor's motion on an even grid of times. All lists have the same length; steps and seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Time of the first sample [s].
    pub start: f64,
    /// Time between samples [s]: the window divided by 2 [`HALF_WINDOW`].
    pub cell: f64,
    /// [steps]
    pub position: Vec<f64>,
    /// [steps/s]
    pub speed: Vec<f64>,
    /// [steps/s2]
    pub acceleration: Vec<f64>,
    /// [steps/s3]
    pub jerk: Vec<f64>,
}

impl Motion {
    /// The motion of `motor` over the whole trace, with a window of `window` seconds. A motor that the trace does not
    /// have, or a window that is not positive, gives no samples.
    pub fn rebuild<const N: usize>(trace: &Trace<N>, motor: usize, window: f64) -> Self {
        Self::rebuild_between(trace, motor, window, 0, trace.end())
    }

    /// The same, from time `from` to `to` [counts].
    pub fn rebuild_between<const N: usize>(
        trace: &Trace<N>,
        motor: usize,
        window: f64,
        from: u64,
        to: u64,
    ) -> Self {
        let cell = window / (2 * HALF_WINDOW) as f64;
        let hertz = TICK_HZ as f64;
        let counts = cell * hertz;
        let empty = Self {
            start: 0.0,
            cell,
            position: Vec::new(),
            speed: Vec::new(),
            acceleration: Vec::new(),
            jerk: Vec::new(),
        };
        if !(counts >= 1.0 && counts.is_finite()) || motor >= N || to <= from {
            return empty;
        }
        // Half a window more on either side, so that the fit at the rim rests on real samples.
        let margin = (window * hertz) as u64;
        let first = from.saturating_sub(margin);
        let last = to.saturating_add(margin).min(trace.end().max(to));
        let cells = ((last - first) as f64 / counts).ceil() as usize;
        let mean = Self::cell_means(trace, motor, first, counts, cells);

        let skip = ((from - first) as f64 / counts).floor() as usize;
        let kept = (((to - first) as f64 / counts).ceil() as usize).min(mean.len());
        let mut motion = Self {
            start: (first as f64 + (skip as f64 + 0.5) * counts) / hertz,
            ..empty
        };
        for middle in skip..kept {
            let [speed, acceleration, jerk] = fit(&mean, middle);
            motion.position.push(mean[middle]);
            motion.speed.push(speed / cell);
            motion.acceleration.push(acceleration / (cell * cell));
            motion.jerk.push(jerk / (cell * cell * cell));
        }
        motion
    }

    /// Averages of the line through the crossings over `cells` cells of `counts` counts from `first` on [steps].
    fn cell_means<const N: usize>(
        trace: &Trace<N>,
        motor: usize,
        first: u64,
        counts: f64,
        cells: usize,
    ) -> Vec<f64> {
        // One crossing before the stretch, if there is any near, so that its first line starts where it should: two
        // windows back are far enough for any motion that the window can resolve.
        let reach = (counts * 4.0 * HALF_WINDOW as f64) as u64;
        let begin = first.saturating_sub(reach);
        let (state, _) = trace.events_from(begin);
        let mut crossings = trace
            .pulses_from(begin)
            .filter_map(|pulse| pulse.step_of(motor))
            .map(|step| {
                (
                    step.time as f64 - first as f64,
                    step.position as f64 - 0.5 * f64::from(step.sign),
                )
            });

        let resting = state.positions[motor] as f64;
        let mut mean = Vec::with_capacity(cells);
        // The line under way, from (t0, x0) to (t1, x1); before the first crossing and after the last it is level.
        let mut next = crossings.next();
        let (mut t0, mut x0) = (f64::NEG_INFINITY, next.map_or(resting, |(_, x)| x));
        for cell in 0..cells {
            let (mut t, end) = (cell as f64 * counts, (cell + 1) as f64 * counts);
            let mut area = 0.0;
            while t < end {
                while let Some((t1, x1)) = next.filter(|(t1, _)| *t1 <= t) {
                    (t0, x0) = (t1, x1);
                    next = crossings.next();
                }
                let (until, slope) = match next {
                    Some((t1, x1)) if t0.is_finite() => (t1.min(end), (x1 - x0) / (t1 - t0)),
                    Some((t1, _)) => (t1.min(end), 0.0),
                    None => (end, 0.0),
                };
                let middle = 0.5 * (t + until);
                let x = if slope == 0.0 {
                    x0
                } else {
                    x0 + slope * (middle - t0)
                };
                area += x * (until - t);
                t = until;
            }
            mean.push(area / counts);
        }
        mean
    }

    /// Time of sample `index` [s].
    pub fn time(&self, index: usize) -> f64 {
        self.start + index as f64 * self.cell
    }

    /// Pairs of time [s] and one of the lists.
    pub fn timed<'a>(&'a self, list: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        list.iter().enumerate().map(|(i, y)| (self.time(i), *y))
    }

    /// Largest magnitude in one of the lists.
    pub fn largest(list: &[f64]) -> f64 {
        list.iter().fold(0.0, |held: f64, y| held.max(y.abs()))
    }
}

/// First, second and third derivative by cell of the cubic around `middle`; the ends of the list are held.
fn fit(y: &[f64], middle: usize) -> [f64; 3] {
    let m = HALF_WINDOW as f64;
    let s0 = 2.0 * m + 1.0;
    let (mut s2, mut s4, mut s6) = (0.0, 0.0, 0.0);
    let (mut t0, mut t1, mut t2, mut t3) = (0.0, 0.0, 0.0, 0.0);
    // Measured from the middle, so that large positions cost no digits.
    let origin = y[middle];
    let at = |index: usize| y[index.min(y.len() - 1)] - origin;
    for k in 1..=HALF_WINDOW {
        let i = k as f64;
        let (i2, i3) = (i * i, i * i * i);
        s2 += 2.0 * i2;
        s4 += 2.0 * i2 * i2;
        s6 += 2.0 * i3 * i3;
        let (before, after) = (at(middle.saturating_sub(k)), at(middle + k));
        t0 += after + before;
        t1 += (after - before) * i;
        t2 += (after + before) * i2;
        t3 += (after - before) * i3;
    }
    let odd = s2 * s6 - s4 * s4;
    let even = s0 * s4 - s2 * s2;
    [
        (s6 * t1 - s4 * t3) / odd,
        2.0 * (s0 * t2 - s2 * t0) / even,
        6.0 * (s2 * t3 - s4 * t1) / odd,
    ]
}
