//! A machine whose walls are all off by the same -> what the gauge readings of a first panel teach, and a second panel,
//! milled with the correction under other noise.

use crate::job::{BiasJob, Job, JobError};
use crate::mirror::{Simulation, Summary, TOLERANCE, mean};
use hexstep::cycles::mirror_bias::{Bias, BiasError};

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
    pub(super) fn of(
        job: &Job,
        simulation: &Simulation,
        wanted: &BiasJob,
    ) -> Result<Self, JobError> {
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
