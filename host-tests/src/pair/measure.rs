//! Pulses of a pair -> the wall between its tips, and the trim, through a forward map that shares nothing with the library.
//!
//! Every millisecond of a row both tools are rebuilt from the pulses, and the place of the reference surface is sought that
//! is nearest to the support: a point on the straight line between two given ones, its normal on the great circle. There
//!
//! ```text
//!   e = P_T - P_H     thickness = n.e     lateral = |e - (n.e) n|     anti-parallel error = angle(O_T, -O_H)
//!   trim = n.(P_H - P)                    wall left = thickness + trim - delta(x, y)        untrimmed: without the trim
//! ```

use crate::job::{PairJob, PairRow};
use crate::mirror::{Simulation, Summary, TOLERANCE};
use crate::reference::matrix::angle_deg;
use crate::run::RunPair;
use crate::trace::{TICK_HZ, seconds};

/// One look at both tools.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairSample {
    /// [s]
    pub time: f64,
    /// The support in the work frame of side 1 [mm].
    pub x: f64,
    pub y: f64,
    /// Between the tips, along and across the normal [mm].
    pub thickness: f64,
    pub lateral: f64,
    /// [deg]
    pub anti_parallel: f64,
    /// Of the support off the reference surface: along its normal, and across it off the row [mm].
    pub trim: f64,
    pub aside: f64,
    /// How far the panel gives way there [mm].
    pub delta: f64,
}

/// A row from its pulses.
#[derive(Clone, Debug)]
pub struct RowMeasured {
    /// Of the job.
    pub row: usize,
    /// One a millisecond.
    pub samples: Vec<PairSample>,
}

/// What the pulses made of all rows.
#[derive(Clone, Debug)]
pub struct PairMeasured {
    pub rows: Vec<RowMeasured>,
    /// What the machine is off by everywhere [mm]; no pulse tells of it.
    pub error: f64,
    /// Walls that are left, the first second of each row not counted.
    pub trimmed: Summary,
    pub untrimmed: Summary,
    /// Thickness between the tips, along the normals.
    pub thickness: Summary,
    /// Largest: across the normals [mm], tools not anti-parallel [deg], trim either way, support off its row [mm].
    pub lateral: f64,
    pub anti_parallel: f64,
    pub trim: f64,
    pub aside: f64,
}

type V = [f64; 3];

fn dot(a: V, b: V) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn plus(a: V, b: V, by: f64) -> V {
    std::array::from_fn(|i| a[i] + by * b[i])
}

/// Points and normals of a row.
struct Polyline(Vec<(V, V)>);

impl Polyline {
    fn of(row: &PairRow) -> Self {
        let points = row.points.iter();
        Self(
            points
                .map(|at| (at.p().to_array(), at.v().to_array()))
                .collect(),
        )
    }

    /// The stretch from `here` on that is nearest to `tip`, its point there and its normal.
    fn nearest(&self, tip: V, here: usize) -> Option<(usize, V, V)> {
        // A stretch may be shorter than what a millisecond takes.
        const AHEAD: usize = 8;
        let stretches = self.0.windows(2).enumerate().skip(here).take(AHEAD);
        let found = stretches.map(|(index, ends)| {
            let ((a, n0), (b, n1)) = (ends[0], ends[1]);
            let way = plus(b, a, -1.0);
            let length = dot(way, way);
            let along = dot(plus(tip, a, -1.0), way);
            let u = if length > 0.0 {
                (along / length).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let p = plus(a, way, u);
            let off = plus(tip, p, -1.0);
            (dot(off, off), index, p, between(n0, n1, u))
        });
        found
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, index, p, n)| (index, p, n))
    }
}

/// On the great circle from `a` to `b`.
fn between(a: V, b: V, u: f64) -> V {
    let angle = angle_deg(a, b).to_radians();
    let sine = angle.sin();
    if sine < 1e-9 {
        return a;
    }
    let (from, to) = ((angle * (1.0 - u)).sin() / sine, (angle * u).sin() / sine);
    std::array::from_fn(|i| a[i] * from + b[i] * to)
}

impl PairSample {
    /// Walls that are left, without and with what the trim moved.
    pub fn walls(&self, error: f64) -> [f64; 2] {
        let untrimmed = self.thickness - self.delta + error;
        [untrimmed, untrimmed + self.trim]
    }
}

impl PairMeasured {
    /// Looks at the pulses of a run on a machine that is off by `error` [mm] everywhere.
    pub fn of(pair: &PairJob, simulation: &Simulation, run: &RunPair, error: f64) -> Self {
        let every = TICK_HZ / 1000;
        let rebuilt = run.trace.rebuilt_every(every);
        let walls = || Summary::about(simulation.d, TOLERANCE);
        let mut found = Self {
            rows: Vec::new(),
            error,
            trimmed: walls(),
            untrimmed: walls(),
            thickness: Summary::about(run.plan.wall, TOLERANCE),
            lateral: 0.0,
            anti_parallel: 0.0,
            trim: 0.0,
            aside: 0.0,
        };
        for row in &run.rows {
            let line = Polyline::of(&pair.rows[row.row]);
            let first = row.start.div_ceil(every);
            let last = row.end / every;
            let mut here = 0;
            let mut samples = Vec::with_capacity((last.saturating_sub(first) + 1) as usize);
            for k in first..=last {
                let Some(steps) = rebuilt.get(k as usize) else {
                    break;
                };
                let joints =
                    std::array::from_fn(|i| steps[i] / pair.joints[i].limits.steps_per_unit);
                let [mill, support] = pair.tools(&joints);
                let Some((index, p, n)) = line.nearest(support.tip, here) else {
                    break;
                };
                here = index;
                let e = plus(mill.tip, support.tip, -1.0);
                let thickness = dot(e, n);
                let across = plus(e, n, -thickness);
                let off = plus(support.tip, p, -1.0);
                let trim = dot(off, n);
                let aside = plus(off, n, -trim);
                let [x, y, _] = support.tip;
                let sample = PairSample {
                    time: seconds(k * every),
                    x,
                    y,
                    thickness,
                    lateral: dot(across, across).sqrt(),
                    anti_parallel: angle_deg(mill.axis, support.axis.map(|x| -x)),
                    trim,
                    aside: dot(aside, aside).sqrt(),
                    delta: simulation.delta(x, y),
                };
                found.take(
                    &sample,
                    seconds((k - first) * every) >= simulation.settled(),
                );
                samples.push(sample);
            }
            found.rows.push(RowMeasured {
                row: row.row,
                samples,
            });
        }
        found
    }

    fn take(&mut self, sample: &PairSample, counts: bool) {
        self.thickness.take(sample.thickness);
        self.lateral = self.lateral.max(sample.lateral);
        self.anti_parallel = self.anti_parallel.max(sample.anti_parallel);
        self.trim = self.trim.max(sample.trim.abs());
        self.aside = self.aside.max(sample.aside);
        if counts {
            let [untrimmed, trimmed] = sample.walls(self.error);
            self.untrimmed.take(untrimmed);
            self.trimmed.take(trimmed);
        }
    }

    /// Walls that are left at the places of a panel, where the rows come by, without and with trimming.
    pub fn points(&self, places: &[f64]) -> Vec<[f64; 2]> {
        let mut found = Vec::new();
        for row in &self.rows {
            for place in places {
                let nearest = row.samples.iter().min_by(|a, b| {
                    let off = |sample: &PairSample| (sample.x - place).abs();
                    off(a).total_cmp(&off(b))
                });
                // A row that is run in part comes by a part of the places.
                if let Some(sample) = nearest.filter(|sample| (sample.x - place).abs() < 0.02) {
                    found.push(sample.walls(self.error));
                }
            }
        }
        found
    }
}
