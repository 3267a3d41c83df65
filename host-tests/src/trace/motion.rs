//! Steps -> motion: position, speed, acceleration and jerk of a motor, rebuilt from its pulses alone.
//!
//! An edge from n to n+1 says that the commanded position crosses n + 1/2 at that instant. The straight lines between
//! those crossings are averaged over cells of equal time, and in a window of 2 m + 1 cells around each cell
//! (m = [`HALF_WINDOW`]) polynomials of least squares are laid: a straight line for the speed, a parabola for the
//! acceleration, a cubic for the jerk (Savitzky and Golay 1964, in closed form):
//!
//! ```text
//! S_k = sum i^k,  i = -m .. m          T_k = sum i^k y_i
//! speed        =   T1 / S2                                   / cell
//! acceleration = 2 (S0 T2 - S2 T0) / (S0 S4 - S2^2)          / cell^2
//! jerk         = 6 (S2 T3 - S4 T1) / (S2 S6 - S4^2)          / cell^3
//! ```
//!
//! Each is thus a mean of the true speed, acceleration or jerk over the window with weights that are nowhere negative:
//! what keeps a limit does not show above it. The price: a corner is rounded over a window, and where the jerk is j the
//! speed is read j w^2 / 36 too high.
//!
//! Noise: an edge is late by up to a tick, so at rate v and tick time t the position is uncertain by e = v t of a step;
//! averaged over the n edges of a window w that leaves about 30 e / (w^2 sqrt n) of noise in the acceleration and
//! 320 e / (w^3 sqrt n) in the jerk. A window should hold ten steps at least where acceleration is judged. At rest the
//! position stays half a step short of the whole one: no edge tells more, and within a window of a start or a stop the
//! acceleration may be 2 steps / w^2 off.

use super::{Step, TICK_HZ, Trace, bits};

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

    /// The motions of all motors over the whole trace, in one walk over it.
    pub fn rebuild_all<const N: usize>(trace: &Trace<N>, window: f64) -> [Self; N] {
        let Some(grid) = Grid::new(trace, window, 0, trace.end()) else {
            return std::array::from_fn(|_| Self::empty(window));
        };
        let mut lines = std::array::from_fn(|_| Line::new(grid, 0.0));
        for pulse in trace.pulses() {
            for (motor, line) in lines.iter_mut().enumerate() {
                if let Some(step) = pulse.step_of(motor) {
                    line.cross(&step);
                }
            }
        }
        lines.map(|line| Self::fitted(&line.finish(), grid, window))
    }

    /// The motion of one motor from time `from` to `to` [counts].
    pub fn rebuild_between<const N: usize>(
        trace: &Trace<N>,
        motor: usize,
        window: f64,
        from: u64,
        to: u64,
    ) -> Self {
        let Some(grid) = Grid::new(trace, window, from, to).filter(|_| motor < N) else {
            return Self::empty(window);
        };
        // One crossing before the stretch, if there is any near, so that its first line starts where it should: two
        // windows back are far enough for any motion that the window can resolve.
        let reach = (grid.counts * 4.0 * HALF_WINDOW as f64) as u64;
        let begin = grid.first.saturating_sub(reach);
        let (state, _) = trace.events_from(begin);
        let mut line = Line::new(grid, state.positions[motor] as f64);
        for pulse in trace.pulses_from(begin) {
            if let Some(step) = pulse.step_of(motor) {
                line.cross(&step);
                if line.is_full() {
                    break;
                }
            }
        }
        Self::fitted(&line.finish(), grid, window)
    }

    fn empty(window: f64) -> Self {
        Self {
            start: 0.0,
            cell: window / (2 * HALF_WINDOW) as f64,
            position: Vec::new(),
            speed: Vec::new(),
            acceleration: Vec::new(),
            jerk: Vec::new(),
        }
    }

    fn fitted(mean: &[f64], grid: Grid, window: f64) -> Self {
        let mut motion = Self::empty(window);
        let cell = motion.cell;
        motion.start =
            (grid.first as f64 + (grid.skip as f64 + 0.5) * grid.counts) / TICK_HZ as f64;
        for middle in grid.skip..grid.kept.min(mean.len()) {
            let [speed, acceleration, jerk] = fit(mean, middle);
            motion.position.push(mean[middle]);
            motion.speed.push(speed / cell);
            motion.acceleration.push(acceleration / (cell * cell));
            motion.jerk.push(jerk / (cell * cell * cell));
        }
        motion
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

/// The cells of a stretch of time.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// Time of the first cell's beginning [counts], and the length of a cell.
    first: u64,
    counts: f64,
    cells: usize,
    /// Cells asked for: from `skip` to before `kept`. Those beside them serve the fit.
    skip: usize,
    kept: usize,
}

impl Grid {
    /// `None` for a window that is not positive, or a stretch that is empty.
    fn new<const N: usize>(trace: &Trace<N>, window: f64, from: u64, to: u64) -> Option<Self> {
        let hertz = TICK_HZ as f64;
        let counts = window * hertz / (2 * HALF_WINDOW) as f64;
        if !(counts >= 1.0 && counts.is_finite()) || to <= from {
            return None;
        }
        // A window more on either side, so that the fit at the rim rests on real samples.
        let margin = (window * hertz) as u64;
        let first = from.saturating_sub(margin);
        let last = to.saturating_add(margin).min(trace.end().max(to));
        let cell_of = |time: u64| (time - first) as f64 / counts;
        Some(Self {
            first,
            counts,
            cells: cell_of(last).ceil() as usize,
            skip: cell_of(from).floor() as usize,
            kept: cell_of(to).ceil() as usize,
        })
    }
}

/// The line through the crossings of one motor, averaged over the cells of a grid as it grows.
struct Line {
    grid: Grid,
    /// Where it ends by now: counts from the grid's beginning, and steps.
    t: f64,
    x: f64,
    /// Whether there has been a crossing; before it the line is level.
    begun: bool,
    /// Means of the cells that are full; integral over the cell under way.
    mean: Vec<f64>,
    area: f64,
}

impl Line {
    /// At rest at `x` until the first crossing.
    fn new(grid: Grid, x: f64) -> Self {
        Self {
            grid,
            t: 0.0,
            x,
            begun: false,
            mean: Vec::with_capacity(grid.cells),
            area: 0.0,
        }
    }

    fn is_full(&self) -> bool {
        self.mean.len() >= self.grid.cells
    }

    fn cross(&mut self, step: &Step) {
        let t = step.time as f64 - self.grid.first as f64;
        let x = step.position as f64 - 0.5 * f64::from(step.sign);
        if !self.begun {
            // From the first crossing back the line is level.
            self.x = x;
            self.begun = true;
            self.t = t.min(0.0);
        }
        self.draw(t, x);
    }

    /// Draws the line on to (t, x).
    fn draw(&mut self, t: f64, x: f64) {
        let Grid { counts, cells, .. } = self.grid;
        let slope = if t > self.t {
            (x - self.x) / (t - self.t)
        } else {
            0.0
        };
        let (t0, x0) = (self.t, self.x);
        let mut from = t0.max(0.0);
        while from < t && self.mean.len() < cells {
            let end = (self.mean.len() + 1) as f64 * counts;
            let until = end.min(t);
            self.area += (x0 + slope * (0.5 * (from + until) - t0)) * (until - from);
            if until >= end {
                self.mean.push(self.area / counts);
                self.area = 0.0;
            }
            from = until;
        }
        (self.t, self.x) = (t, x);
    }

    /// Level to the end of the grid.
    fn finish(mut self) -> Vec<f64> {
        let Grid { counts, cells, .. } = self.grid;
        // A cell more than there are, so that rounding leaves none open.
        let (end, x) = ((cells + 1) as f64 * counts, self.x);
        self.draw(end.max(self.t), x);
        self.mean
    }
}

impl<const N: usize> Trace<N> {
    /// Positions of all motors every `counts` counts from 0 to the end of the trace [steps]: on the line through the
    /// crossings of half steps, and on whole steps before the first and after the last of them.
    pub fn rebuilt_every(&self, counts: u64) -> Vec<[f64; N]> {
        let counts = counts.max(1);
        let length = (self.end() / counts + 1) as usize;
        let mut rebuilt = vec![[0.0; N]; length];
        // The last crossing of each motor: its time and place; at first, rest at zero.
        let mut last: [Option<(u64, f64)>; N] = [None; N];
        for pulse in self.pulses() {
            for motor in bits::<N>(pulse.motors) {
                let Some(step) = pulse.step_of(motor) else {
                    continue;
                };
                let x1 = step.position as f64 - 0.5 * f64::from(step.sign);
                if let Some((t0, x0)) = last[motor] {
                    let slope = (x1 - x0) / (pulse.time - t0).max(1) as f64;
                    for k in t0.div_ceil(counts)..pulse.time.div_ceil(counts) {
                        rebuilt[k as usize][motor] = x0 + slope * (k * counts - t0) as f64;
                    }
                }
                last[motor] = Some((pulse.time, x1));
            }
        }
        let end = self.positions();
        for motor in 0..N {
            let first = last[motor].map_or(0, |(t0, _)| t0.div_ceil(counts) as usize);
            for row in rebuilt.iter_mut().skip(first) {
                row[motor] = end[motor] as f64;
            }
        }
        rebuilt
    }
}

/// First, second and third derivative by cell around `middle`; the ends of the list are held.
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
        t1 / s2,
        2.0 * (s0 * t2 - s2 * t0) / even,
        6.0 * (s2 * t3 - s4 * t1) / odd,
    ]
}
