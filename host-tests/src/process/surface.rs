//! A free-form surface -> planned rows, what they leave by every strategy, joints for all of them, and poses of some.
//!
//! ```text
//!      lifted  .------------------.        between rows: up along the normal, across, down; as fast as the joints go
//!             |                    |
//!   row 230 --'                    '-- row 231, backwards where `zigzag` is set
//! ```
//!
//! A wheel that grinds backwards keeps its axle: only the feed turns round, so the sense changes and no joint winds.

use crate::job::{Job, JobError, Model, Pace, PoseRow, PosesJob, SurfaceJob};
use crate::surface::joints::{Refused, serve};
use crate::surface::{
    self, Fewest, Gap, PathRow, Plan, Residual, Segment, Strategy, SurfaceError, ToolPoint,
    fewest_iso, residual_of_gaps,
};
use hexstep::geometry::Vector;
use hexstep::joints::Joints;

/// A strategy, and what it leaves.
#[derive(Clone, Debug)]
pub struct Compared {
    pub strategy: Strategy,
    /// Whether the number of straight rows was searched: the fewest that keep the scallop.
    pub is_fewest: bool,
    pub plan: Plan,
    pub residual: Residual,
    pub gaps: Vec<Gap>,
}

/// How the arm reaches the rows of the plan.
#[derive(Clone, Debug)]
pub struct Reached {
    /// Segments served in each branch.
    pub branches: [usize; 8],
    /// Smallest distance of any joint to an end of its range [rad].
    pub margin: f64,
    /// Shortest time of all segments at the planned feed [s], lifts not counted.
    pub time: f64,
}

/// What a surface job has become.
#[derive(Clone, Debug)]
pub struct SurfaceMade {
    /// The job's own strategy first, then the baselines: straight rows last, as many as the own plan has and the fewest
    /// that keep the scallop. A baseline that cannot be planned has the error.
    pub strategies: Vec<Result<Compared, SurfaceError>>,
    /// The job's own plan and what it leaves.
    pub own: Compared,
    pub reached: Reached,
    /// Rows that become pulses, first and last.
    pub ground: [usize; 2],
    /// For every pose: whether the wheel grinds on the way to it.
    pub grinds: Vec<bool>,
    pub poses: PosesJob,
}

impl SurfaceMade {
    pub(super) fn of(job: &Job, surface: &SurfaceJob) -> Result<Self, JobError> {
        let refuse = |error: SurfaceError| surface.refuse(job, &error);
        let plan = Plan::new(&surface.part, &surface.grinding).map_err(refuse)?;
        let rows = plan.rows;
        // Simulations are what takes the time; the rows on the arm are found meanwhile.
        let (own, baselines, reached) = std::thread::scope(|scope| {
            let spacings = scope.spawn(move || spacings(surface));
            let straight = scope.spawn(move || straight(surface, rows));
            let reached = reach(job, surface, &plan);
            let own = simulate(surface, surface.grinding.strategy, plan);
            // A thread that fails here failed in planning, which has no other way to fail than its error.
            let joined = [spacings, straight].map(|thread| thread.join().unwrap_or_default());
            (own, joined.concat(), reached)
        });
        let own = own.map_err(refuse)?;
        let reached = reached?;
        let ground = rows_of(job, surface, &own.plan)?;
        let (rows, told, grinds) = path(job, surface, &own.plan, ground)?;
        let poses = PosesJob::made(&surface.machine, &surface.motion, rows, "path.rows", told);
        let mut strategies = vec![Ok(own.clone())];
        strategies.extend(baselines);
        Ok(Self {
            strategies,
            own,
            reached,
            ground,
            grinds,
            poses,
        })
    }
}

type Baselines = Vec<Result<Compared, SurfaceError>>;

/// The baselines whose spacing follows the surface, without the job's own strategy.
fn spacings(surface: &SurfaceJob) -> Baselines {
    let others = [Strategy::Adaptive, Strategy::RowMin].into_iter();
    others
        .filter(|other| surface.compare && *other != surface.grinding.strategy)
        .map(|strategy| compare(surface, strategy))
        .collect()
}

/// The baselines of straight rows at equal spacing: so many, where the job's own rows are no such ones, and the fewest
/// that keep the scallop.
fn straight(surface: &SurfaceJob, rows: usize) -> Baselines {
    if !surface.compare {
        return Vec::new();
    }
    let equal = match compare(surface, Strategy::Iso(rows)) {
        Ok(equal) => equal,
        Err(error) => return vec![Err(error)],
    };
    let (part, grinding) = (&surface.part, &surface.grinding);
    let fewest = fewest_iso(part, grinding, surface.stations, rows, &equal.residual);
    let fewest = fewest.map(Compared::from);
    match surface.grinding.strategy {
        Strategy::Iso(_) => vec![fewest],
        _ => vec![Ok(equal), fewest],
    }
}

impl From<Fewest> for Compared {
    fn from(fewest: Fewest) -> Self {
        Self {
            strategy: Strategy::Iso(fewest.rows),
            is_fewest: true,
            plan: fewest.plan,
            residual: fewest.residual,
            gaps: fewest.gaps,
        }
    }
}

fn compare(surface: &SurfaceJob, strategy: Strategy) -> Result<Compared, SurfaceError> {
    let grinding = surface::Job {
        strategy,
        ..surface.grinding
    };
    let plan = Plan::new(&surface.part, &grinding)?;
    simulate(surface, strategy, plan)
}

fn simulate(
    surface: &SurfaceJob,
    strategy: Strategy,
    plan: Plan,
) -> Result<Compared, SurfaceError> {
    let rows: Vec<PathRow> = plan.segments.iter().map(PathRow::from).collect();
    let grinding = &surface.grinding;
    let (residual, gaps) = residual_of_gaps(&surface.part, grinding, &rows, surface.stations)?;
    Ok(Compared {
        strategy,
        is_fewest: false,
        plan,
        residual,
        gaps,
    })
}

fn tool_length(surface: &SurfaceJob) -> f64 {
    match &surface.machine.model {
        Model::Arm { tool, .. } => tool.p.z,
        _ => 0.0,
    }
}

fn tool_points(
    job: &Job,
    surface: &SurfaceJob,
    segment: &Segment,
) -> Result<Vec<ToolPoint>, JobError> {
    let (work, tool) = (surface.machine.work(), tool_length(surface));
    let points = surface::poses(
        &surface.part,
        &surface.grinding,
        segment,
        &work,
        tool,
        surface.zigzag,
    );
    let mut points = points.map_err(|error| surface.refuse(job, &error))?;
    if is_backwards(surface, segment.row) {
        // The axle stays as it is: half a turn about the tool's z axis, which the flange shares.
        for point in &mut points {
            for rotation in [&mut point.tool.rotation, &mut point.flange.rotation] {
                (rotation.n, rotation.s) = (-rotation.n, -rotation.s);
            }
        }
    }
    Ok(points)
}

fn is_backwards(surface: &SurfaceJob, row: usize) -> bool {
    surface.zigzag && row % 2 == 1
}

/// Joints for every row of the plan, each in one branch.
fn reach(job: &Job, surface: &SurfaceJob, plan: &Plan) -> Result<Reached, JobError> {
    let Model::Arm { arm, .. } = &surface.machine.model else {
        let detail = "only an arm turns the wheel's axle as well".into();
        return Err(job.refuse("machine.model", "Contradictory", detail));
    };
    let near = |i: usize| surface.motion.near.get(i).copied().unwrap_or(0.0);
    let mut before = Joints(std::array::from_fn(|i| near(i).to_radians()));
    let mut reached = Reached {
        branches: [0; 8],
        margin: f64::INFINITY,
        time: 0.0,
    };
    for segment in &plan.segments {
        let points = tool_points(job, surface, segment)?;
        let flanges: Vec<_> = points.iter().map(|point| point.flange).collect();
        let served = serve(arm, &flanges, Some(before)).map_err(|refused: Refused| {
            let reasons = refused
                .reasons()
                .into_iter()
                .map(|(branch, point, why)| format!("branch {branch}: {why} at its point {point}"));
            let detail = format!(
                "row {}: {refused} ({})",
                segment.row,
                reasons.collect::<Vec<_>>().join(", ")
            );
            job.refuse("machine.work_origin", refused.name(), detail)
        })?;
        for pair in points.windows(2) {
            reached.time += (pair[1].tool.p - pair[0].tool.p).norm() / pair[0].feed;
        }
        if let Some(count) = reached.branches.get_mut(usize::from(served.branch)) {
            *count += 1;
        }
        reached.margin = reached.margin.min(served.margin);
        before = served.joints.last().copied().unwrap_or(before);
    }
    Ok(reached)
}

fn rows_of(job: &Job, surface: &SurfaceJob, plan: &Plan) -> Result<[usize; 2], JobError> {
    let last = plan.rows.saturating_sub(1);
    match surface.rows {
        None => Ok([plan.rows / 2, (plan.rows / 2 + 1).min(last)]),
        Some([_, to]) if to > last => {
            let detail = format!("the plan has the rows 0 to {last}, found {to}");
            Err(job.refuse("path.rows", "OutOfRange", detail))
        }
        Some(rows) => Ok(rows),
    }
}

type Path = (Vec<PoseRow>, Vec<String>, Vec<bool>);

/// The poses of some rows and of the lifts between them.
fn path(
    job: &Job,
    surface: &SurfaceJob,
    plan: &Plan,
    [first, last]: [usize; 2],
) -> Result<Path, JobError> {
    let (mut rows, mut told, mut grinds) = (Vec::new(), Vec::new(), Vec::new());
    let mut put = |row: PoseRow, what: String, grinding: bool| {
        rows.push(row);
        told.push(what);
        grinds.push(grinding);
    };
    let mut above: Option<(Vector<f64>, [f64; 2])> = None;
    for number in first..=last {
        let backwards = is_backwards(surface, number);
        let mut segments: Vec<&Segment> =
            plan.segments.iter().filter(|s| s.row == number).collect();
        if backwards {
            segments.reverse();
        }
        for segment in segments {
            let points = tool_points(job, surface, segment)?;
            let row = |point: &ToolPoint, lift: f64, pace: Pace| {
                let up = -point.tool.rotation.a;
                PoseRow {
                    tip: (point.tool.p + up * lift).to_array(),
                    axis: up.to_array(),
                    across: Some(point.tool.rotation.n.to_array()),
                    pace,
                }
            };
            let uv = |index: Option<usize>| {
                let index = index.unwrap_or(0);
                let index = if backwards {
                    segment.points.len().saturating_sub(1 + index)
                } else {
                    index
                };
                segment.points.get(index).map_or([0.0; 2], |p| p.uv)
            };
            let (Some(start), Some(end)) = (points.first(), points.last()) else {
                continue;
            };
            let over = row(start, surface.lift, Pace::Rapid);
            let here = (Vector::from_array(over.tip), uv(Some(0)));
            if let Some(from) = above {
                clear(job, surface, from, here, number)?;
            }
            put(over, format!("over row {number}"), false);
            put(
                row(start, 0.0, Pace::Rapid),
                format!("start of row {number}"),
                false,
            );
            for (index, pair) in points.windows(2).enumerate() {
                // The feed of a stretch is that of its start.
                let pace = Pace::Feed(pair[0].feed * 60.0);
                let what = format!("point {} of row {number}", index + 1);
                put(row(&pair[1], 0.0, pace), what, true);
            }
            let over = row(end, surface.lift, Pace::Rapid);
            above = Some((
                Vector::from_array(over.tip),
                uv(segment.points.len().checked_sub(1)),
            ));
            put(over, format!("over the end of row {number}"), false);
        }
    }
    Ok((rows, told, grinds))
}

/// Whether a lifted move stays above the part: at least half as high as it is lifted.
fn clear(
    job: &Job,
    surface: &SurfaceJob,
    (from, [u0, v0]): (Vector<f64>, [f64; 2]),
    (to, [u1, v1]): (Vector<f64>, [f64; 2]),
    row: usize,
) -> Result<(), JobError> {
    const PARTS: i32 = 64;
    for k in 0..=PARTS {
        let share = f64::from(k) / f64::from(PARTS);
        let (u, v) = (u0 + share * (u1 - u0), v0 + share * (v1 - v0));
        let shape = surface.part.tool_shape(u, v);
        let shape = shape.map_err(|e| surface.refuse(job, &SurfaceError::at(e, u, v)))?;
        let height = (from + (to - from) * share - shape.jet.s).dot(shape.normal);
        if height < 0.5 * surface.lift {
            let detail = format!(
                "on the way to row {row} the wheel would be {height:.3} mm above the part; lift more, or set zigzag = true"
            );
            return Err(job.refuse("path.lift", "OutOfRange", detail));
        }
    }
    Ok(())
}
