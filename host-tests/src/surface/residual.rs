//! What rows leave between them: an independent simulation of the ground profile.
//!
//! ```text
//!                      .-^-.             height of the ground over the line through the two groove centres,
//!     groove i  .   .-'     '-.   .  i+1   in the plane of the section u = const, along the mean normal
//!               '-.'           '.-'
//! ```
//!
//! At each station: the chords of all rows are put on the surface along its normal, the contact there gives the stripe
//! of each, and between neighbours the ground surface is S - H n with H the largest or the sum of the stripes, each
//! measured in its own tool plane.

use super::{Job, Part, Segment, SurfaceError};
use hexstep::cycles::surface_grinding::{Grinding, GrindingError, Model, Stripe};
use hexstep::geometry::Vector;
use hexstep::geometry::nurbs::{MAX_COUNT, NurbsError, Shape, Slice};

/// Points across a gap, and how much finer the surroundings of the highest are looked at.
const SAMPLES: usize = 129;
const FINER: i32 = 32;

/// A ground row.
#[derive(Clone, Debug, PartialEq)]
pub enum PathRow {
    Uv(Vec<[f64; 2]>),
    /// On or near the surface [mm]; taken at its foot points.
    Xyz(Vec<Vector<f64>>),
}

impl From<&Segment> for PathRow {
    fn from(segment: &Segment) -> Self {
        Self::Uv(segment.points.iter().map(|p| p.uv).collect())
    }
}

/// Heights in mm, places as (u, v) of the middle of the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Gaps looked at.
    pub samples: usize,
    pub min: f64,
    pub max: f64,
    pub mean: f64,
    pub std: f64,
    pub p01: f64,
    pub p99: f64,
    pub at_min: [f64; 2],
    pub at_max: [f64; 2],
    /// Height left at the edges of the part under the depth of the last row, where that row lies inside.
    pub edge_max: Option<f64>,
    /// Depth of the rows.
    pub depth_min: f64,
    pub depth_max: f64,
    /// The same heights counted from the deepest point of the gap.
    pub peak_to_valley: [f64; 2],
}

impl Residual {
    pub fn ratio(&self) -> f64 {
        self.max / self.min
    }
}

/// One gap: its residual and its peak to valley [mm], and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    pub uv: [f64; 2],
    pub height: f64,
    pub peak_to_valley: f64,
}

/// Simulates rows at `stations` places along u and sums up.
pub fn residual(
    part: &Part,
    job: &Job,
    rows: &[PathRow],
    stations: usize,
) -> Result<Residual, SurfaceError> {
    residual_of_gaps(part, job, rows, stations).map(|(residual, _)| residual)
}

/// Every gap that [`residual`] sums up, for maps and histograms.
pub fn gaps(
    part: &Part,
    job: &Job,
    rows: &[PathRow],
    stations: usize,
) -> Result<Vec<Gap>, SurfaceError> {
    let simulation = Simulation::new(part, job, rows)?;
    let mut gaps = Vec::new();
    for u in station_list(part, stations) {
        simulation.station(u, &mut gaps, &mut Edges::default())?;
    }
    Ok(gaps)
}

/// Both at once.
pub fn residual_of_gaps(
    part: &Part,
    job: &Job,
    rows: &[PathRow],
    stations: usize,
) -> Result<(Residual, Vec<Gap>), SurfaceError> {
    let simulation = Simulation::new(part, job, rows)?;
    let mut gaps = Vec::new();
    let mut edges = Edges::default();
    for u in station_list(part, stations) {
        simulation.station(u, &mut gaps, &mut edges)?;
    }
    Ok((summary(&gaps, &edges)?, gaps))
}

/// Whether rows keep a limit.
pub(super) enum Kept {
    Within(Box<Residual>, Vec<Gap>),
    /// A gap above it; further stations were not looked at.
    Above(Gap),
}

/// Like [`residual_of_gaps`], but done with the first station that has a gap above `limit`; `suspect` (u) is looked at
/// before all others.
pub(super) fn residual_within(
    part: &Part,
    job: &Job,
    rows: &[PathRow],
    stations: usize,
    limit: f64,
    suspect: f64,
) -> Result<Kept, SurfaceError> {
    let simulation = Simulation::new(part, job, rows)?;
    let highest = |gaps: &[Gap]| {
        let above = gaps.iter().filter(|gap| gap.height > limit);
        above.max_by(|a, b| a.height.total_cmp(&b.height)).copied()
    };
    let mut first = Vec::new();
    simulation.station(suspect, &mut first, &mut Edges::default())?;
    if let Some(gap) = highest(&first) {
        return Ok(Kept::Above(gap));
    }
    let mut gaps = Vec::new();
    let mut edges = Edges::default();
    for u in station_list(part, stations) {
        let before = gaps.len();
        simulation.station(u, &mut gaps, &mut edges)?;
        if let Some(gap) = highest(&gaps[before..]) {
            return Ok(Kept::Above(gap));
        }
    }
    let residual = Box::new(summary(&gaps, &edges)?);
    Ok(Kept::Within(residual, gaps))
}

fn station_list(part: &Part, stations: usize) -> impl Iterator<Item = f64> {
    let [lo, hi] = part.domain()[0];
    (0..stations).map(move |j| lo + (j as f64 + 0.5) / stations as f64 * (hi - lo))
}

fn summary(gaps: &[Gap], edges: &Edges) -> Result<Residual, SurfaceError> {
    let by_height = |a: &&Gap, b: &&Gap| a.height.total_cmp(&b.height);
    let (Some(least), Some(most)) = (gaps.iter().min_by(by_height), gaps.iter().max_by(by_height))
    else {
        return Err(SurfaceError::NoGap);
    };
    let mut heights: Vec<f64> = gaps.iter().map(|g| g.height).collect();
    heights.sort_by(f64::total_cmp);
    let count = heights.len() as f64;
    let mean = heights.iter().sum::<f64>() / count;
    let variance = heights.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / count;
    let share = |p: f64| {
        let place = p * (count - 1.0);
        let below = heights[place.floor() as usize];
        below + (heights[place.ceil() as usize] - below) * place.fract()
    };
    let valleys = || gaps.iter().map(|g| g.peak_to_valley);
    Ok(Residual {
        samples: gaps.len(),
        min: least.height,
        max: most.height,
        mean,
        std: variance.sqrt(),
        p01: share(0.01),
        p99: share(0.99),
        at_min: least.uv,
        at_max: most.uv,
        edge_max: edges.highest,
        depth_min: edges.depth[0],
        depth_max: edges.depth[1],
        peak_to_valley: [
            valleys().fold(f64::INFINITY, f64::min),
            valleys().fold(0.0, f64::max),
        ],
    })
}

/// What a simulation learns beside the gaps.
struct Edges {
    highest: Option<f64>,
    depth: [f64; 2],
}

impl Default for Edges {
    fn default() -> Self {
        Self {
            highest: None,
            depth: [f64::INFINITY, 0.0],
        }
    }
}

/// A row as points on the surface.
struct Polyline {
    uv: Vec<[f64; 2]>,
    s: Vec<Vector<f64>>,
}

/// Where a row crosses a station.
struct Crossing {
    v: f64,
    s: Vector<f64>,
    normal: Vector<f64>,
    /// Across the row in the surface.
    cross: Vector<f64>,
    stripe: Stripe<f64>,
}

struct Simulation<'a> {
    part: &'a Part,
    grinding: Grinding<f64>,
    rows: Vec<Polyline>,
}

impl<'a> Simulation<'a> {
    fn new(part: &'a Part, job: &Job, rows: &[PathRow]) -> Result<Self, SurfaceError> {
        let grinding = job.check()?;
        let grid = Grid::new(part)?;
        let rows: Result<Vec<Polyline>, SurfaceError> = rows
            .iter()
            .enumerate()
            .map(|(i, row)| polyline(part, &grid, row).map_err(|e| e.in_row(i as i64)))
            .collect();
        Ok(Self {
            part,
            grinding,
            rows: rows?,
        })
    }

    /// All gaps at one station.
    fn station(&self, u: f64, gaps: &mut Vec<Gap>, edges: &mut Edges) -> Result<(), SurfaceError> {
        let mut crossings = Vec::new();
        for (i, row) in self.rows.iter().enumerate() {
            for k in 1..row.uv.len() {
                let (a, b) = (row.uv[k - 1][0], row.uv[k][0]);
                // Half open, so that a point shared by two chords counts once.
                if (a <= u) != (b <= u) {
                    let crossing = self.crossing(row, k, u).map_err(|e| e.in_row(i as i64))?;
                    crossings.push(crossing);
                }
            }
        }
        crossings.sort_by(|a, b| a.v.total_cmp(&b.v));
        for Crossing { stripe, .. } in &crossings {
            let [least, most] = edges.depth;
            edges.depth = [least.min(stripe.h0), most.max(stripe.h0)];
        }
        let [lo, hi] = self.part.domain()[1];
        let slice = self.part.slice(u).map_err(|e| SurfaceError::at(e, u, lo))?;
        for i in 1..crossings.len() {
            let middle = 0.5 * (crossings[i - 1].v + crossings[i].v);
            if (lo..=hi).contains(&middle) {
                gaps.push(self.gap(u, &slice, &crossings, i - 1)?);
            }
        }
        if let (Some(first), Some(last)) = (crossings.first(), crossings.last()) {
            for (row, i, edge, inside) in [
                (first, 0, lo, first.v > lo),
                (last, crossings.len() - 1, hi, last.v < hi),
            ] {
                if inside {
                    let shape = self.shape(u, edge)?;
                    let left = row.stripe.h0 - self.removal(&crossings, i, shape.jet.s);
                    edges.highest = Some(edges.highest.unwrap_or(left).max(left));
                }
            }
        }
        Ok(())
    }

    fn shape(&self, u: f64, v: f64) -> Result<Shape<f64>, SurfaceError> {
        let shape = self.part.tool_shape(u, v);
        shape.map_err(|e| SurfaceError::at(e, u, v))
    }

    /// The point of the station whose normal meets the chord: Newton on the place along the chord and on v.
    fn crossing(&self, row: &Polyline, k: usize, u: f64) -> Result<Crossing, SurfaceError> {
        let ([ua, va], [ub, vb]) = (row.uv[k - 1], row.uv[k]);
        let start = row.s[k - 1];
        let chord = row.s[k] - start;
        let mut share = (u - ua) / (ub - ua);
        let mut v = va + share * (vb - va);
        let mut shape = self.shape(u, v)?;
        let mut moved = f64::INFINITY;
        for _ in 0..20 {
            let jet = &shape.jet;
            let off = start + chord * share - jet.s;
            let (r_u, r_v) = (off.dot(jet.s_u), off.dot(jet.s_v));
            let (c_u, c_v) = (chord.dot(jet.s_u), chord.dot(jet.s_v));
            let (d_u, d_v) = (
                off.dot(jet.s_uv) - jet.s_v.dot(jet.s_u),
                off.dot(jet.s_vv) - jet.s_v.dot(jet.s_v),
            );
            let det = c_u * d_v - c_v * d_u;
            let along = (r_v * d_u - r_u * d_v) / det;
            let change = (r_u * c_v - r_v * c_u) / det;
            if !(along.is_finite() && change.is_finite()) {
                return Err(SurfaceError::at(NurbsError::DegenerateNormal, u, v));
            }
            share += along;
            v += change;
            shape = self.shape(u, v)?;
            moved = change.abs() * shape.first[2].sqrt();
            if moved < 1e-11 {
                break;
            }
        }
        if moved > 1e-6 {
            return Err(SurfaceError::BadParameter(
                "path",
                "must keep to the surface: the normal there does not meet one of its chords",
            ));
        }
        let at = |e: GrindingError<f64>| SurfaceError::at(e, u, v);
        // The chord's direction in the surface, in coordinates (du, dv).
        let [e, f, g] = shape.first;
        let (c_u, c_v) = (chord.dot(shape.jet.s_u), chord.dot(shape.jet.s_v));
        let section = shape
            .along(g * c_u - f * c_v, e * c_v - f * c_u)
            .ok_or(at(NurbsError::DegenerateNormal.into()))?;
        Ok(Crossing {
            v,
            s: shape.jet.s,
            normal: shape.normal,
            cross: section.cross,
            stripe: self.grinding.stripe_on(&section).map_err(at)?,
        })
    }

    /// What the rows around gap `i` take away at a point of the surface.
    fn removal(&self, crossings: &[Crossing], i: usize, at: Vector<f64>) -> f64 {
        let near = &crossings[i.saturating_sub(3)..(i + 5).min(crossings.len())];
        let depths = near.iter().map(|c| c.stripe.depth((at - c.s).dot(c.cross)));
        match self.grinding.model {
            Model::Envelope => depths.fold(0.0, f64::max),
            Model::Additive => depths.sum(),
        }
    }

    fn gap(
        &self,
        u: f64,
        slice: &Slice<f64, MAX_COUNT>,
        crossings: &[Crossing],
        i: usize,
    ) -> Result<Gap, SurfaceError> {
        let [lo, hi] = self.part.domain()[1];
        let (left, right) = (&crossings[i], &crossings[i + 1]);
        let ground = |c: &Crossing| c.s - c.normal * self.removal(crossings, i, c.s);
        let base = ground(left);
        let line = ground(right) - base;
        let mean = left.normal + right.normal;
        let up = mean - line * (mean.dot(line) / line.dot(line));
        let up = up
            .unit(1e-9)
            .ok_or(SurfaceError::at(NurbsError::DegenerateNormal, u, left.v))?;
        let height = |v: f64| -> Result<f64, SurfaceError> {
            let (s, normal) = if (lo..=hi).contains(&v) {
                slice.place(v).map_err(|e| SurfaceError::at(e, u, v))?
            } else {
                let shape = self.shape(u, v)?;
                (shape.jet.s, shape.normal)
            };
            let ground = s - normal * self.removal(crossings, i, s);
            Ok((ground - base).dot(up))
        };
        let step = (right.v - left.v) / (SAMPLES - 1) as f64;
        let (mut highest, mut lowest, mut peak) = (f64::NEG_INFINITY, f64::INFINITY, 0);
        for k in 0..SAMPLES {
            let h = height(left.v + step * k as f64)?;
            lowest = lowest.min(h);
            if h > highest {
                (highest, peak) = (h, k);
            }
        }
        // Around the peak the profile rises to the cusp and falls behind it: by halves to its top.
        let middle = left.v + step * peak as f64;
        let at = |offset: i32| height(middle + step * f64::from(offset) / f64::from(FINER));
        let mut from = if peak == 0 { 0 } else { -FINER };
        let mut to = if peak + 1 == SAMPLES { 0 } else { FINER };
        while from < to {
            let before = (from + to).div_euclid(2);
            let (a, b) = (at(before)?, at(before + 1)?);
            highest = highest.max(a).max(b);
            if a < b {
                from = before + 1;
            } else {
                to = before;
            }
        }
        Ok(Gap {
            uv: [u, 0.5 * (left.v + right.v)],
            height: highest,
            peak_to_valley: highest - lowest,
        })
    }
}

fn polyline(part: &Part, grid: &Grid, row: &PathRow) -> Result<Polyline, SurfaceError> {
    let uv: Vec<[f64; 2]> = match row {
        PathRow::Uv(uv) => uv.clone(),
        PathRow::Xyz(points) => {
            let foot = |p: &Vector<f64>| grid.foot(part, *p);
            points.iter().map(foot).collect::<Result<_, _>>()?
        }
    };
    let s: Result<Vec<_>, SurfaceError> = uv
        .iter()
        .map(|[u, v]| match part.tool_shape(*u, *v) {
            Ok(shape) => Ok(shape.jet.s),
            Err(e) => Err(SurfaceError::at(e, *u, *v)),
        })
        .collect();
    Ok(Polyline { uv, s: s? })
}

/// Points of the surface from which the search for a foot point starts.
struct Grid {
    points: Vec<([f64; 2], Vector<f64>)>,
}

impl Grid {
    const SIDE: usize = 48;

    fn new(part: &Part) -> Result<Self, SurfaceError> {
        let [[u0, u1], [v0, v1]] = part.domain();
        let mut points = Vec::new();
        for i in 0..=Self::SIDE {
            for j in 0..=Self::SIDE {
                let u = u0 + (u1 - u0) * (i as f64 / Self::SIDE as f64);
                let v = v0 + (v1 - v0) * (j as f64 / Self::SIDE as f64);
                let (u, v) = (u.min(u1), v.min(v1));
                let jet = part.jet(u, v).map_err(|e| SurfaceError::at(e, u, v))?;
                points.push(([u, v], jet.s));
            }
        }
        Ok(Self { points })
    }

    /// (u, v) of the point of the surface, or of its continuation, that is nearest: Newton on both products with the
    /// tangents.
    fn foot(&self, part: &Part, p: Vector<f64>) -> Result<[f64; 2], SurfaceError> {
        if !p.is_finite() {
            return Err(GrindingError::BadPose.into());
        }
        let distance = |s: &Vector<f64>| (*s - p).dot(*s - p);
        let start = self
            .points
            .iter()
            .min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
        let Some(([mut u, mut v], _)) = start.copied() else {
            return Err(SurfaceError::NoGap);
        };
        for _ in 0..30 {
            let at = |e: NurbsError| SurfaceError::at(e, u, v);
            let shape = part.tool_shape(u, v).map_err(at)?;
            let jet = &shape.jet;
            let off = p - jet.s;
            let (r_u, r_v) = (off.dot(jet.s_u), off.dot(jet.s_v));
            let [e, f, g] = shape.first;
            let (a, b, c) = (
                e - off.dot(jet.s_uu),
                f - off.dot(jet.s_uv),
                g - off.dot(jet.s_vv),
            );
            let mut det = a * c - b * b;
            let (mut a, mut b, mut c) = (a, b, c);
            // Beyond a centre of curvature Newton would climb; the first form alone always descends.
            if det <= 0.0 || a <= 0.0 {
                (a, b, c) = (e, f, g);
                det = a * c - b * b;
            }
            let (du, dv) = ((c * r_u - b * r_v) / det, (a * r_v - b * r_u) / det);
            if !(du.is_finite() && dv.is_finite()) {
                return Err(at(NurbsError::DegenerateNormal));
            }
            u += du;
            v += dv;
            if du.abs() * e.sqrt() + dv.abs() * g.sqrt() < 1e-11 {
                break;
            }
        }
        Ok([u, v])
    }
}
