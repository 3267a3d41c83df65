//! The plan of a surface: its rows, clipped at the edge, as polylines.

use super::front::{Row, Rows};
use super::stations::Stations;
use super::{Job, Part, SurfaceError};
use hexstep::geometry::Vector;

/// A point of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub uv: [f64; 2],
    /// dv/du of the row here.
    pub slope: f64,
    pub s: Vector<f64>,
    pub normal: Vector<f64>,
}

/// A stretch of a row that is ground without lifting the wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Number of the row in the plan, from 0 at the lowest v.
    pub row: usize,
    pub points: Vec<Point>,
}

/// All rows of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub rows: usize,
    /// Rows that run from edge to edge.
    pub full_rows: usize,
    pub segments: Vec<Segment>,
    /// Spacings that were held to touching stripes.
    pub touching: usize,
}

impl Plan {
    pub fn new(part: &Part, job: &Job) -> Result<Self, SurfaceError> {
        let grinding = job.check()?;
        let rows = Rows::plan(part, job, &grinding)?;
        Self::of_rows(part, job, &rows)
    }

    /// The polylines of rows that were planned before.
    pub fn of_rows(part: &Part, job: &Job, rows: &Rows) -> Result<Self, SurfaceError> {
        let stations = Stations::place(part, job, rows)?;
        let mut segments = Vec::new();
        for (i, row) in rows.rows.iter().enumerate() {
            for span in &row.spans {
                segments.push(Segment {
                    row: i,
                    points: polyline(part, row, stations.of(i), *span)
                        .map_err(|e| e.in_row(row.number))?,
                });
            }
        }
        Ok(Self {
            rows: rows.rows.len(),
            full_rows: rows.full(),
            segments,
            touching: rows.touching,
        })
    }

    pub fn points(&self) -> usize {
        self.segments.iter().map(|s| s.points.len()).sum()
    }

    /// Length of all chords [mm].
    pub fn path_length(&self) -> f64 {
        self.chords().sum()
    }

    /// The longest chord [mm].
    pub fn largest_step(&self) -> f64 {
        self.chords().fold(0.0, f64::max)
    }

    fn chords(&self) -> impl Iterator<Item = f64> {
        let pairs = self.segments.iter().flat_map(|s| s.points.windows(2));
        pairs.map(|p| (p[1].s - p[0].s).norm())
    }
}

/// The points of a row from clip to clip. A clip lies on the chord between the stations around it, not on the row:
/// so a partial row stays parallel to its neighbour, which runs straight there.
fn polyline(
    part: &Part,
    row: &Row,
    stations: &[f64],
    [from, to]: [f64; 2],
) -> Result<Vec<Point>, SurfaceError> {
    let mut points = Vec::new();
    let mut push = |u: f64, v: f64, slope: f64| -> Result<(), SurfaceError> {
        let shape = part
            .tool_shape(u, v)
            .map_err(|e| SurfaceError::at(e, u, v))?;
        points.push(Point {
            uv: [u, v],
            slope,
            s: shape.jet.s,
            normal: shape.normal,
        });
        Ok(())
    };
    for (i, u) in stations.iter().enumerate() {
        let local = row.curve.at(*u);
        if let Some(before) = i.checked_sub(1).map(|b| stations[b]) {
            // Both clips may lie between the same two stations.
            for clip in [from, to] {
                if before < clip && clip < *u {
                    let start = row.curve.at(before).value;
                    let slope = (local.value - start) / (u - before);
                    push(clip, start + slope * (clip - before), slope)?;
                }
            }
        }
        if from <= *u && *u <= to {
            push(*u, local.value, local.slope)?;
        }
    }
    Ok(points)
}
