//! Mirror milling simulated: a panel that gives way, a noisy sensor, the trimmer, and the wall that is left.
//!
//! ```text
//! for each row y, tick k:   x = -450 + feed dt k
//!   delta(x, y)  --+-- noise -->[ Trimmer ]--> out
//!                  '--> wall = d + out - delta         (untrimmed: out = 0)
//! then: nine points of the walls, gauged three times each
//! ```
//!
//! The deformation and the errors are this project's model (the paper gives measurements only): the support head pushes
//! the panel towards the mill, most in its middle and not at its edges,
//!
//! ```text
//! delta(x, y) = peak (F / 100 N) cos(pi x / 1000) cos(pi y / 750)
//! ```
//!
//! and the panel follows it. Source: specification of mirror milling, section 10.

mod noise;
mod statistics;
mod surface;

pub use noise::Noise;
pub use statistics::{Summary, mean, sample_sigma};
pub use surface::Surface;

use hexstep::cycles::mirror_trim::{BadLimit, Parameters, Trimmer};
use std::f64::consts::PI;

/// Ticks at the start of a row that do not count.
const SKIPPED: u64 = 100;
/// Tolerance of the wall [mm].
pub const TOLERANCE: f64 = 0.1;
/// At a tick of 10 ms half a second without a reading; the model's noise never comes near.
pub const MISS_MAX: u32 = 50;
/// Gauge readings of each point, and what the gauge shows [mm].
pub const READINGS: usize = 3;
const GAUGE_STEP: f64 = 0.01;
/// The gauge's noise is a stream of its own.
const GAUGE_SEED: u64 = 1000;
/// A row of more ticks takes too long.
const MOST_TICKS: f64 = 1e7;

/// The panel and where it is milled and measured; its middle is the origin. Lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    pub length: f64,
    pub width: f64,
    /// Shift of its middle at 100 N.
    pub peak: f64,
    /// Rows, in the order in which they are milled.
    pub rows: Vec<f64>,
    /// Points of a row at which the wall is looked at.
    pub places: Vec<f64>,
    /// A row runs from -start to start.
    pub start: f64,
}

impl Default for Panel {
    /// Section 10: 1000 x 750 mm, nine points.
    fn default() -> Self {
        Self {
            length: 1000.0,
            width: 750.0,
            peak: 0.15,
            rows: vec![-200.0, 0.0, 200.0],
            places: vec![-300.0, 0.0, 300.0],
            start: 450.0,
        }
    }
}

impl Panel {
    /// The name of what is wrong with it.
    fn fault(&self) -> Option<&'static str> {
        let lies = |x: &f64, most: f64| x.is_finite() && x.abs() <= most;
        let fits = |list: &[f64], most: f64| {
            !list.is_empty() && list.len() < 100 && list.iter().all(|x| lies(x, most))
        };
        [
            ("length", self.length > 0.0 && self.length.is_finite()),
            ("width", self.width > 0.0 && self.width.is_finite()),
            (
                "start",
                self.start > 0.0 && lies(&self.start, 0.5 * self.length),
            ),
            ("rows", fits(&self.rows, 0.5 * self.width)),
            ("places", fits(&self.places, self.start)),
        ]
        .iter()
        .find(|(_, good)| !good)
        .map(|(name, _)| *name)
    }
}

/// What is simulated. Lengths in mm, times in s, force in N.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    pub seed: u64,
    /// Wanted wall.
    pub d: f64,
    pub force: f64,
    /// Standard deviation of the sensor.
    pub noise: f64,
    /// Standard deviation of the gauge.
    pub gauge: f64,
    pub feed: f64,
    pub dt: f64,
    pub tau: f64,
    pub amount: f64,
    pub rate: f64,
    /// A reading farther from the filtered ones does not count.
    pub gate: f64,
    pub panel: Panel,
}

impl Default for Simulation {
    /// Section 10, seed 1.
    fn default() -> Self {
        Self {
            seed: 1,
            d: 1.5,
            force: 100.0,
            noise: 0.03,
            gauge: 0.01,
            feed: 5.0,
            dt: 0.01,
            tau: 0.2,
            amount: 0.3,
            rate: 0.5,
            gate: 0.25,
            panel: Panel::default(),
        }
    }
}

/// Why nothing can be simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SimulationError {
    /// The wall is not a number above zero.
    BadWall,
    BadLimit(&'static str),
    /// Rows or places that are not on the panel.
    BadPanel(&'static str),
    NonFinite(&'static str),
    /// A row would take more than 10 million ticks, or not more than the 100 that do not count.
    BadRow,
}

/// The walls of one way of milling.
#[derive(Clone, Debug, PartialEq)]
pub struct Walls {
    /// All ticks that count.
    pub rows: Summary,
    /// Walls at the places of all rows, row by row.
    pub points: Vec<f64>,
    /// The same as gauged: averages of three readings.
    pub gauged: Vec<f64>,
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub untrimmed: Walls,
    pub trimmed: Walls,
}

/// One tick of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    pub x: f64,
    pub y: f64,
    pub delta: f64,
    pub measured: f64,
    pub out: f64,
    /// Walls without and with trimming.
    pub untrimmed: f64,
    pub trimmed: f64,
}

impl Simulation {
    /// Shift of the panel towards the mill [mm] at a place of it [mm].
    pub fn delta(&self, x: f64, y: f64) -> f64 {
        let Panel {
            length,
            width,
            peak,
            ..
        } = self.panel;
        peak * (self.force / 100.0) * (PI * x / length).cos() * (PI * y / width).cos()
    }

    /// Whether a tick of a row counts: at its start the trimmer finds its way in.
    pub fn counts(tick: u64) -> bool {
        tick >= SKIPPED
    }

    /// Time at the start of a row that does not count [s].
    pub fn settled(&self) -> f64 {
        SKIPPED as f64 * self.dt
    }

    pub fn run(&self) -> Result<Outcome, SimulationError> {
        self.watch(|_, _| {})
    }

    /// Runs, and shows every tick with its number within the row.
    pub fn watch(&self, mut show: impl FnMut(u64, &Tick)) -> Result<Outcome, SimulationError> {
        let (trimmer, ticks) = self.check()?;
        let start = self.panel.start;
        let place = |x: &f64| ((x + start) / (self.feed * self.dt)).round() as u64;
        let looked_at: Vec<u64> = self.panel.places.iter().map(place).collect();
        let mut noise = Noise::new(self.seed);
        let mut walls = [(); 2].map(|()| (Summary::about(self.d, TOLERANCE), Vec::new()));
        for y in self.panel.rows.iter().copied() {
            let mut trimmer = trimmer;
            for k in 0..=ticks {
                let x = -start + self.feed * self.dt * k as f64;
                let delta = self.delta(x, y);
                let measured = delta + self.noise * noise.gauss();
                let (out, _) = trimmer.tick(Some(measured));
                let tick = Tick {
                    x,
                    y,
                    delta,
                    measured,
                    out,
                    untrimmed: self.d - delta,
                    trimmed: self.d + out - delta,
                };
                show(k, &tick);
                for ((rows, points), wall) in walls.iter_mut().zip([tick.untrimmed, tick.trimmed]) {
                    if Self::counts(k) {
                        rows.take(wall);
                    }
                    if looked_at.contains(&k) {
                        points.push(wall);
                    }
                }
            }
        }
        let mut gauge = self.gauge_noise();
        let [untrimmed, trimmed] = walls.map(|(rows, points)| {
            let gauged = points.iter().map(|wall| self.gauged(*wall, &mut gauge));
            Walls {
                gauged: gauged.collect(),
                rows,
                points,
            }
        });
        Ok(Outcome { untrimmed, trimmed })
    }

    fn gauged(&self, wall: f64, noise: &mut Noise) -> f64 {
        mean(&self.readings(wall, noise))
    }

    /// The gauge's noise: a stream of its own.
    pub fn gauge_noise(&self) -> Noise {
        Noise::new(self.seed.wrapping_add(GAUGE_SEED))
    }

    /// What the gauge shows of a wall [mm].
    pub fn readings(&self, wall: f64, noise: &mut Noise) -> [f64; READINGS] {
        [(); READINGS].map(|()| {
            let shown = (wall + self.gauge * noise.gauss()) / GAUGE_STEP;
            shown.round() * GAUGE_STEP
        })
    }

    /// The trimmer and the number of the last tick of a row.
    ///
    /// # Errors
    /// What is wrong with the parameters; then nothing is simulated.
    pub fn check(&self) -> Result<(Trimmer<f64>, u64), SimulationError> {
        if !(self.d.is_finite() && self.d > 0.0) {
            return Err(SimulationError::BadWall);
        }
        let trimmer = Trimmer::new(&Parameters {
            dt: self.dt,
            tau: self.tau,
            amount: self.amount,
            rate: self.rate,
            gate: self.gate,
            miss_max: MISS_MAX,
        })
        .map_err(|BadLimit(name)| SimulationError::BadLimit(name))?;
        if !(self.feed.is_finite() && self.feed > 0.0) {
            return Err(SimulationError::BadLimit("feed"));
        }
        let numbers = [
            ("force", self.force),
            ("peak", self.panel.peak),
            ("noise", self.noise),
            ("gauge", self.gauge),
        ];
        if let Some((name, _)) = numbers.iter().find(|(_, x)| !x.is_finite()) {
            return Err(SimulationError::NonFinite(name));
        }
        if let Some(name) = self.panel.fault() {
            return Err(SimulationError::BadPanel(name));
        }
        // The last tick that does not lie beyond the row, but for rounding.
        let ticks = (2.0 * self.panel.start / (self.feed * self.dt) + 1e-9).floor();
        if ticks > MOST_TICKS || ticks < SKIPPED as f64 {
            return Err(SimulationError::BadRow);
        }
        Ok((trimmer, ticks as u64))
    }
}
