//! A panel milled from both sides -> its walls, without and with live trimming, for every filter time of the job.
//!
//! The eight motors of the two machines run elsewhere, see [`crate::pair`].

use super::BiasMade;
use crate::job::{Job, JobError, MirrorJob};
use crate::mirror::{Outcome, Simulation, Tick};

/// The walls of a job.
#[derive(Clone, Debug)]
pub struct MirrorMade {
    /// One for each filter time.
    pub milled: Vec<Milled>,
    pub bias: Option<BiasMade>,
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
