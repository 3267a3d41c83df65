//! How many straight rows at equal spacing it takes to keep the scallop everywhere: the fewest, by simulation.
//!
//! A cusp grows as the square of the spacing, so `n sqrt(max / scallop)` rows are about right; from there the search
//! closes in on the number that keeps the scallop while one less does not. Most numbers fail at the station where the
//! last one did, which is looked at first: the search takes little more than two simulations.

use super::residual::{Kept, residual_within};
use super::{Gap, Job, MAX_ROWS, Part, PathRow, Plan, Residual, Strategy, SurfaceError};

/// The fewest straight rows.
#[derive(Clone, Debug)]
pub struct Fewest {
    pub rows: usize,
    pub plan: Plan,
    /// At most the scallop.
    pub residual: Residual,
    pub gaps: Vec<Gap>,
}

/// Searches from what so many straight rows leave: `rows` and their `residual` at `stations`.
///
/// # Errors
/// Those of planning and simulating; `TooManyRows` where more than [`MAX_ROWS`] would be needed.
pub fn fewest_iso(
    part: &Part,
    job: &Job,
    stations: usize,
    rows: usize,
    residual: &Residual,
) -> Result<Fewest, SurfaceError> {
    let scallop = job.process.scallop;
    // A highest cusp is never above the depth of the rows, so the product stays far below the largest usize.
    let scaled =
        |rows: usize, height: f64| (rows as f64 * (height / scallop).sqrt()).ceil() as usize;
    let mut suspect = residual.at_max[0];
    let mut next = scaled(rows, residual.max).max(2);
    // One row leaves no gap that could be judged.
    let mut too_few = 1;
    let mut found: Option<Fewest> = None;
    loop {
        if next > MAX_ROWS {
            return Err(SurfaceError::TooManyRows);
        }
        let job = Job {
            strategy: Strategy::Iso(next),
            ..*job
        };
        let plan = Plan::new(part, &job)?;
        let paths: Vec<PathRow> = plan.segments.iter().map(PathRow::from).collect();
        match residual_within(part, &job, &paths, stations, scallop, suspect)? {
            Kept::Above(gap) => {
                suspect = gap.uv[0];
                too_few = next;
                next = scaled(next, gap.height);
            }
            Kept::Within(residual, gaps) => {
                suspect = residual.at_max[0];
                let rows = next;
                next = scaled(rows, residual.max);
                found = Some(Fewest {
                    rows,
                    plan,
                    residual: *residual,
                    gaps,
                });
            }
        }
        next = next.max(too_few + 1);
        if let Some(fewest) = found.take_if(|fewest| fewest.rows == too_few + 1) {
            return Ok(fewest);
        }
        if let Some(fewest) = &found {
            next = next.min(fewest.rows - 1);
        }
    }
}
