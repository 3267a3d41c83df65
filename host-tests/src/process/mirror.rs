//! A panel milled from both sides -> its walls, without and with live trimming, for every filter time of the job.
//!
//! With a bias, a first panel is milled on a machine whose walls are all off by the same, its gauge readings are learnt
//! from, and a second panel is milled with the correction, under other noise. The eight motors of the two machines run
//! elsewhere, see [`crate::pair`].

use crate::job::{BiasJob, Job, JobError, MirrorJob};
use crate::mirror::{Outcome, Simulation, Summary, TOLERANCE, Tick, mean};
use hexstep::cycles::mirror_bias::{Bias, BiasError};

/// The walls of a job.
#[derive(Clone, Debug)]
pub struct MirrorMade {
    /// One for each filter time.
    pub milled: Vec<Milled>,
    pub bias: Option<BiasMade>,
}

/// What the gauge taught.
#[derive(Clone, Debug)]
pub struct BiasMade {
    pub bias: Bias<f64>,
    /// What is added to the wall of the second panel [mm].
    pub correction: f64,
    /// Readings that were refused as outliers.
    pub outliers: usize,
    pub before: BiasedPanel,
    pub after: BiasedPanel,
}

/// A panel from a machine with a constant error.
#[derive(Clone, Debug)]
pub struct BiasedPanel {
    /// All ticks that count.
    pub rows: Summary,
    /// At the places of all rows, each the average of its gauge readings [mm].
    pub gauged: Vec<f64>,
}

impl BiasedPanel {
    /// Root of the mean square of what the gauged points are off `d` [mm].
    pub fn rms(&self, d: f64) -> f64 {
        let squares: f64 = self.gauged.iter().map(|wall| (wall - d).powi(2)).sum();
        (squares / self.gauged.len().max(1) as f64).sqrt()
    }

    /// Mills with walls that are off by `shift`; every reading goes to `gauge`.
    fn of(
        simulation: &Simulation,
        shift: f64,
        mut gauge: impl FnMut(f64),
    ) -> Result<Self, crate::mirror::SimulationError> {
        let mut rows = Summary::about(simulation.d, TOLERANCE);
        let outcome = simulation.watch(|k, tick| {
            if Simulation::counts(k) {
                rows.take(tick.trimmed + shift);
            }
        })?;
        let mut noise = simulation.gauge_noise();
        let points = outcome.trimmed.points.iter();
        let gauged = points.map(|wall| {
            let readings = simulation.readings(wall + shift, &mut noise);
            readings.iter().copied().for_each(&mut gauge);
            mean(&readings)
        });
        Ok(Self {
            gauged: gauged.collect(),
            rows,
        })
    }
}

impl BiasMade {
    fn of(job: &Job, simulation: &Simulation, wanted: &BiasJob) -> Result<Self, JobError> {
        // The parameters were checked when the job was read.
        let broken = |error| {
            let detail = format!("it cannot run: {error:?}");
            job.refuse("simulation", "BadLimit", detail)
        };
        let mut bias = wanted.bias;
        let mut outliers = 0;
        let before = BiasedPanel::of(simulation, wanted.offset, |reading| {
            let is_outlier = bias.take(reading) == Err(BiasError::Outlier);
            outliers += usize::from(is_outlier);
        })
        .map_err(broken)?;
        let Some(correction) = bias.correction() else {
            let detail = format!(
                "{outliers} readings are farther from the wanted wall than the gate, so nothing is learnt; that is no bias any more, mend the machine or widen the gate"
            );
            return Err(job.refuse("bias.gate", "Outlier", detail));
        };
        if simulation.d + correction <= 0.0 {
            let detail =
                format!("with the correction of {correction} mm no wall is left to ask for");
            return Err(job.refuse("simulation.d", "BadWall", detail));
        }
        let second = Simulation {
            seed: simulation.seed.wrapping_add(1),
            ..simulation.clone()
        };
        let after = BiasedPanel::of(&second, wanted.offset + correction, |_| {}).map_err(broken)?;
        Ok(Self {
            bias,
            correction,
            outliers,
            before,
            after,
        })
    }
}

/// What one filter time left.
#[derive(Clone, Debug)]
pub struct Milled {
    pub simulation: Simulation,
    pub outcome: Outcome,
    /// One for each row.
    pub rows: Vec<Row>,
    /// How many ticks left a wall of which thickness, untrimmed and trimmed, in [`Milled::CELLS`] cells.
    pub counts: [Vec<u32>; 2],
}

/// One row, thinned out for drawing.
#[derive(Clone, Debug)]
pub struct Row {
    /// [mm]
    pub y: f64,
    pub ticks: Vec<Tick>,
}

/// Ticks of a row that are drawn.
const DRAWN: u64 = 1500;

impl Milled {
    /// Cells of the histogram, from `d - SPAN` to `d + SPAN`.
    pub const CELLS: usize = 170;
    /// [mm]
    pub const SPAN: f64 = 0.17;
}

impl MirrorMade {
    pub(super) fn of(job: &Job, mirror: &MirrorJob) -> Result<Self, JobError> {
        let mut milled = Vec::with_capacity(mirror.simulations.len());
        for simulation in &mirror.simulations {
            let mut rows: Vec<Row> = Vec::new();
            let mut counts = [vec![0; Milled::CELLS], vec![0; Milled::CELLS]];
            let panel = &simulation.panel;
            let ticks = 2.0 * panel.start / (simulation.feed * simulation.dt);
            let every = (ticks as u64 / DRAWN).max(1);
            let outcome = simulation.watch(|k, tick| {
                if k == 0 {
                    let ticks = Vec::new();
                    rows.push(Row { y: tick.y, ticks });
                }
                if let Some(row) = rows.last_mut().filter(|_| k.is_multiple_of(every)) {
                    row.ticks.push(*tick);
                }
                if Simulation::counts(k) {
                    for (counts, wall) in counts.iter_mut().zip([tick.untrimmed, tick.trimmed]) {
                        let place = (wall - simulation.d + Milled::SPAN) / (2.0 * Milled::SPAN);
                        let cell = (place * Milled::CELLS as f64).floor();
                        // What lies beyond the picture is in the table all the same.
                        if let Some(count) = counts.get_mut(cell.max(0.0) as usize) {
                            *count += 1;
                        }
                    }
                }
            });
            // The parameters were checked when the job was read.
            let outcome = outcome.map_err(|error| {
                job.refuse(
                    "simulation",
                    "BadLimit",
                    format!("it cannot run: {error:?}"),
                )
            })?;
            milled.push(Milled {
                simulation: simulation.clone(),
                outcome,
                rows,
                counts,
            });
        }
        let bias = match (&mirror.bias, mirror.simulations.first()) {
            (Some(bias), Some(simulation)) => Some(BiasMade::of(job, simulation, bias)?),
            _ => None,
        };
        Ok(Self { milled, bias })
    }
}
