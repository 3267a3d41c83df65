//! A grinding job with everything that planning needs beside the process itself.

use super::SurfaceError;
use hexstep::cycles::surface_grinding::{
    self as process, Field, Grinding, GrindingError, StepLimits,
};

/// How rows are spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strategy {
    /// Every node has its own spacing, set by the contact in the middle of the gap.
    Adaptive,
    /// Straight rows at the smallest spacing of each.
    RowMin,
    /// So many straight rows at equal spacing of v.
    Iso(usize),
}

/// Where the points of a row stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepMode {
    /// One list of stations for all rows: neighbours sag together.
    Common,
    /// Each row its own list.
    Row,
}

/// Process and plan; lengths in mm, angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job {
    pub process: process::Job<f64>,
    /// Distance of chord and row.
    pub eps: f64,
    /// Lateral sag of a row by itself (step mode row).
    pub e_lat: f64,
    /// Difference of the lateral sags of two neighbours (step mode common).
    pub e_gap: f64,
    pub l_max: f64,
    /// Turn of the normal from point to point.
    pub turn: f64,
    pub strategy: Strategy,
    pub step_mode: StepMode,
    /// Nodes of a row, 5 ..= 4001.
    pub nodes: usize,
    /// Where the first row stands, as a share of the domain of v, 0 ..= 1.
    pub seed: f64,
    /// Half the width of the wheel, which must hold the patch at every point of a row; `None` is not checked.
    pub half_width: Option<f64>,
}

impl Job {
    /// Job A, the paper's table.
    pub fn hard() -> Self {
        Self {
            process: process::Job::hard(),
            eps: 0.1,
            e_lat: 0.003,
            e_gap: 0.001,
            l_max: 20.0,
            turn: 10f64.to_radians(),
            strategy: Strategy::Adaptive,
            step_mode: StepMode::Common,
            nodes: 201,
            seed: 0.5,
            half_width: None,
        }
    }

    /// Job B: the soft wheel.
    pub fn soft() -> Self {
        Self {
            process: process::Job::soft(),
            ..Self::hard()
        }
    }

    /// The checked process; then every other parameter is checked.
    pub fn check(&self) -> Result<Grinding<f64>, SurfaceError> {
        let grinding = Grinding::new(&self.process)?;
        StepLimits {
            eps: self.eps,
            l_max: self.l_max,
            turn: self.turn,
            e_lat: Some(self.e_lat),
        }
        .check()?;
        if !(self.e_gap > 0.0 && self.e_gap.is_finite()) {
            return Err(GrindingError::BadParameter(Field::EGap).into());
        }
        if self.half_width.is_some_and(|w| !(w > 0.0 && w.is_finite())) {
            return Err(GrindingError::BadParameter(Field::HalfWidth).into());
        }
        if let Strategy::Iso(rows) = self.strategy
            && !(2..=MAX_ROWS).contains(&rows)
        {
            return Err(SurfaceError::BadParameter("rows", "must be 2 to 20000"));
        }
        if !(5..=4001).contains(&self.nodes) {
            return Err(SurfaceError::BadParameter("nodes", "must be 5 to 4001"));
        }
        if !(0.0..=1.0).contains(&self.seed) {
            return Err(SurfaceError::BadParameter("seed", "must be 0 to 1"));
        }
        Ok(grinding)
    }
}

/// More rows than this are refused.
pub const MAX_ROWS: usize = 20_000;
