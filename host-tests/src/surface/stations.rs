//! Where the points of the rows stand: equal shares of a density that holds every limit.
//!
//! ```text
//!   q(u) = max( sqrt(|r' x r''|/(8 eps |r'|)), |r'|/l_max, |dn/du|/turn, sqrt(lateral/(8 e)) )
//! ```
//!
//! for the space curve r(u) = S(u, f(u)). Sag along the normal is taken up by force control; sag in the surface moves the
//! row and changes the pitch. With one list for all rows neighbours sag together, and only the difference counts.

use super::front::{Row, Rows};
use super::spline::Local;
use super::{Job, Part, StepMode, SurfaceError};
use hexstep::geometry::Vector;
use hexstep::geometry::nurbs::Shape;

/// Growth of the density until no chord exceeds its tolerance.
const REFINEMENT: f64 = 1.02;
/// More points than this are refused, in one list and in all rows together.
const MAX_STATIONS: f64 = 100_000.0;
const MAX_POINTS: usize = 5_000_000;
/// Places inside a chord where its sag is measured.
const PROBES: usize = 7;

/// The list of each row, or one for all.
pub enum Stations {
    Common(Vec<f64>),
    Each(Vec<Vec<f64>>),
}

impl Stations {
    pub fn place(part: &Part, job: &Job, rows: &Rows) -> Result<Self, SurfaceError> {
        let measured: Result<Vec<Vec<Demand>>, SurfaceError> = rows
            .rows
            .iter()
            .map(|row| demands(part, row).map_err(|e| e.in_row(row.number)))
            .collect();
        let measured = measured?;
        match job.step_mode {
            StepMode::Common => {
                let mut density = vec![0f64; job.nodes];
                for (i, (row, demands)) in rows.rows.iter().zip(&measured).enumerate() {
                    let before = i.checked_sub(1).map(|b| (&rows.rows[b], &measured[b]));
                    for (node, demand) in demands.iter().enumerate() {
                        if !row.kept[node] {
                            continue;
                        }
                        let mut q = demand.chord(job);
                        if let Some((_, other)) = before.filter(|(r, _)| r.kept[node]) {
                            let differ = (demand.sag - other[node].sag).abs();
                            q = q.max((differ / (8.0 * job.e_gap)).sqrt());
                        }
                        density[node] = density[node].max(q);
                    }
                }
                let worst = |list: &[f64]| {
                    rows.rows.iter().try_fold(0f64, |worst, row| {
                        Ok(worst.max(largest_sag(part, row, list)?))
                    })
                };
                let most = MAX_POINTS as f64 / rows.rows.len() as f64;
                if shares(&rows.rows[0], &density).is_none_or(|list| list.len() as f64 > most) {
                    return Err(TOO_MANY);
                }
                Ok(Self::Common(refined(&rows.rows[0], density, job, worst)?))
            }
            StepMode::Row => {
                let mut points = 0;
                let lists: Result<_, SurfaceError> = rows
                    .rows
                    .iter()
                    .zip(&measured)
                    .map(|(row, demands)| {
                        let density = demands
                            .iter()
                            .map(|d| d.chord(job).max((d.sag.abs() / (8.0 * job.e_lat)).sqrt()));
                        let list = refined(row, density.collect(), job, |list| {
                            largest_sag(part, row, list)
                        })?;
                        points += list.len();
                        if points > MAX_POINTS {
                            Err(TOO_MANY)
                        } else {
                            Ok(list)
                        }
                    })
                    .collect();
                Ok(Self::Each(lists?))
            }
        }
    }

    /// The list of row `i`.
    pub fn of(&self, i: usize) -> &[f64] {
        match self {
            Self::Common(list) => list,
            Self::Each(lists) => &lists[i],
        }
    }
}

/// What a row asks of its points at a node.
struct Demand {
    /// |r' x r''|/|r'| [mm]: twice the sag of a unit step in u is a quarter of it.
    bow: f64,
    speed: f64,
    /// |dn/du| [rad]
    turn: f64,
    /// The part of the bow in the surface, signed.
    sag: f64,
}

impl Demand {
    fn chord(&self, job: &Job) -> f64 {
        let chord = (self.bow / (8.0 * job.eps)).sqrt();
        chord.max(self.speed / job.l_max).max(self.turn / job.turn)
    }
}

fn demands(part: &Part, row: &Row) -> Result<Vec<Demand>, SurfaceError> {
    let curve = &row.curve;
    (0..curve.nodes())
        .map(|i| {
            let (u, local) = (curve.node(i), curve.at_node(i));
            let shape = part
                .tool_shape(u, local.value)
                .map_err(|e| SurfaceError::at(e, u, local.value))?;
            Ok(demand(&shape, local))
        })
        .collect()
}

fn demand(shape: &Shape<f64>, Local { slope, bend, .. }: Local) -> Demand {
    let jet = &shape.jet;
    let velocity = jet.s_u + jet.s_v * slope;
    let acceleration =
        jet.s_uu + jet.s_uv * (2.0 * slope) + jet.s_vv * (slope * slope) + jet.s_v * bend;
    let speed = velocity.norm();
    let turning = velocity.cross(acceleration);
    // n' in the tangent plane, by its products with S_u and S_v.
    let [e, f, g] = shape.first;
    let [l, m, n] = shape.second;
    let (p, q) = (l + m * slope, m + n * slope);
    let squared = (g * p * p - 2.0 * f * p * q + e * q * q) / (shape.area * shape.area);
    Demand {
        bow: turning.norm() / speed,
        speed,
        turn: squared.max(0.0).sqrt(),
        sag: turning.dot(shape.normal) / speed,
    }
}

/// Stations at equal shares of the density, the density raised until no chord sags too much.
fn refined(
    row: &Row,
    mut density: Vec<f64>,
    job: &Job,
    worst: impl Fn(&[f64]) -> Result<f64, SurfaceError>,
) -> Result<Vec<f64>, SurfaceError> {
    // The density is bounded below by l_max; a thousand times as dense is beyond any smooth surface.
    for _ in 0..350 {
        let list = shares(row, &density).ok_or(TOO_MANY)?;
        if worst(&list)? <= job.eps {
            return Ok(list);
        }
        density.iter_mut().for_each(|q| *q *= REFINEMENT);
    }
    Err(SurfaceError::BadParameter(
        "eps",
        "cannot be kept to on this surface: it has an edge or a kink; ask for more",
    ))
}

const TOO_MANY: SurfaceError = SurfaceError::BadParameter(
    "eps",
    "and e_lat, e_gap, l_max, turn ask for too many points: more than 100000 in a row or 5000000 in all",
);

/// `None` if they are too many.
fn shares(row: &Row, density: &[f64]) -> Option<Vec<f64>> {
    let node = |i: usize| row.curve.node(i);
    let mut sums = vec![0.0];
    for i in 1..density.len() {
        let area = 0.5 * (density[i - 1] + density[i]) * (node(i) - node(i - 1));
        sums.push(sums[i - 1] + area);
    }
    let total = sums[density.len() - 1];
    // Also for what is not a number.
    if total.is_nan() || total > MAX_STATIONS {
        return None;
    }
    let count = (total.ceil() as usize).max(1);
    let mut stations = vec![node(0)];
    let mut i = 0;
    for k in 1..count {
        let target = total * k as f64 / count as f64;
        while i + 2 < sums.len() && sums[i + 1] < target {
            i += 1;
        }
        let share = (target - sums[i]) / (sums[i + 1] - sums[i]);
        stations.push(node(i) + share * (node(i + 1) - node(i)));
    }
    stations.push(node(density.len() - 1));
    Some(stations)
}

/// Largest distance of the row from its chords, over what is ground of it.
fn largest_sag(part: &Part, row: &Row, stations: &[f64]) -> Result<f64, SurfaceError> {
    let place = |u: f64| -> Result<Vector<f64>, SurfaceError> {
        let v = row.curve.at(u).value;
        let shape = part.tool_shape(u, v);
        Ok(shape.map_err(|e| SurfaceError::at(e, u, v))?.jet.s)
    };
    let mut worst = 0f64;
    for pair in stations.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        if !row.spans.iter().any(|[a, b]| from < *b && to > *a) {
            continue;
        }
        let (start, end) = (place(from)?, place(to)?);
        let chord = end - start;
        let squared = chord.dot(chord);
        for k in 1..=PROBES {
            let u = from + (to - from) * k as f64 / (PROBES + 1) as f64;
            let off = place(u)? - start;
            let sag = off - chord * (off.dot(chord) / squared);
            worst = worst.max(sag.norm());
        }
    }
    Ok(worst)
}
