//! The report on a ground surface: its rows, what they leave by every strategy, and the rows that became pulses.

use super::poses::PosesFigures;
use super::space::Space;
use super::{Cell, Report};
use crate::job::{Job, SurfaceJob};
use crate::plot::{Histogram, Map, Pen, colour, number};
use crate::process::{Compared, SurfaceMade};
use crate::run::Outcome;
use crate::surface::{Gap, Strategy};

/// Everything that a finished surface job says.
pub struct SurfaceFigures<'a> {
    pub job: &'a Job,
    pub surface: &'a SurfaceJob,
    pub made: &'a SurfaceMade,
    pub poses: PosesFigures<'a>,
}

/// What the paper reports of its own surface, which it does not give: least and largest residual [um].
const PAPER_ISO: (f64, f64) = (21.6, 47.5);
const PAPER_ADAPTIVE: (f64, f64) = (24.1, 32.6);
/// Rows that are drawn of a plan.
const DRAWN: usize = 60;

impl<'a> SurfaceFigures<'a> {
    pub fn of(
        job: &'a Job,
        surface: &'a SurfaceJob,
        made: &'a SurfaceMade,
        outcome: &'a Outcome,
        wall: f64,
    ) -> Self {
        Self {
            job,
            surface,
            made,
            poses: PosesFigures::of(job, &made.poses, outcome, wall),
        }
    }

    /// Whether the pulses are right and nothing higher than the scallop is left.
    pub fn is_sound(&self) -> bool {
        self.poses.is_sound() && self.keeps_scallop()
    }

    pub fn keeps_scallop(&self) -> bool {
        let scallop = self.surface.grinding.process.scallop;
        let residual = &self.made.own.residual;
        residual.max <= scallop && residual.edge_max.is_none_or(|edge| edge <= scallop)
    }

    fn told_rows(&self) -> String {
        let plan = &self.made.own.plan;
        format!(
            "{}: {} rows ({} full) in {} segments, {} points, {} m",
            name(&self.made.own),
            plan.rows,
            plan.full_rows,
            plan.segments.len(),
            number(plan.points() as f64, 0),
            number(plan.path_length() / 1e3, 2)
        )
    }

    fn told_residual(&self) -> String {
        let r = &self.made.own.residual;
        format!(
            "{} to {} µm at {} stations, max/min {}; scallop asked for {} µm",
            number(r.min * 1e3, 2),
            number(r.max * 1e3, 2),
            self.surface.stations,
            number(r.ratio(), 3),
            number(self.surface.grinding.process.scallop * 1e3, 1)
        )
    }

    /// What straight rows leave, and how many of them keep the scallop.
    fn told_iso(&self) -> Option<String> {
        let is_iso = |c: &&Compared| matches!(c.strategy, Strategy::Iso(_)) && !c.is_fewest;
        let equal = self.strategies().find(is_iso)?;
        let fewest = self.strategies().find(|c| c.is_fewest)?;
        let own = self.made.own.plan.path_length();
        let more = (fewest.plan.path_length() / own - 1.0) * 100.0;
        let left = |c: &Compared| {
            let (min, max) = (c.residual.min * 1e3, c.residual.max * 1e3);
            format!("{} to {} µm", number(min, 2), number(max, 2))
        };
        let path = format!(
            "{} m, {} % {} path than those planned",
            number(fewest.plan.path_length() / 1e3, 2),
            number(more.abs(), 1),
            if more < 0.0 { "less" } else { "more" }
        );
        let told = format!("{} straight rows leave {}", equal.plan.rows, left(equal));
        let takes = format!("it takes {} to keep the scallop", fewest.plan.rows);
        Some(if fewest.plan.rows == equal.plan.rows {
            format!("{told}; {takes}: {path}")
        } else {
            format!("{told}; {takes}: {}, {path}", left(fewest))
        })
    }

    fn told_reach(&self) -> String {
        let reached = &self.made.reached;
        let branches: Vec<String> = (0..)
            .zip(reached.branches)
            .filter(|(_, count)| *count > 0)
            .map(|(branch, count): (usize, usize)| format!("{count} in branch {branch}"))
            .collect();
        format!(
            "every segment served in one branch each: {}; at least {}° from every limit; {} min of grinding",
            branches.join(", "),
            number(reached.margin.to_degrees(), 1),
            number(reached.time / 60.0, 1)
        )
    }

    fn told_ground(&self) -> String {
        let [first, last] = self.made.ground;
        format!(
            "rows {first} to {last} of {} as pulses, {} poses{}",
            self.made.own.plan.rows,
            self.made.poses.rows.len(),
            if self.surface.zigzag {
                ", every other one backwards"
            } else {
                ""
            }
        )
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = vec![
            format!("rows     {}", self.told_rows()),
            format!(
                "left     {}{}",
                self.told_residual(),
                if self.keeps_scallop() {
                    ""
                } else {
                    ": TOO MUCH"
                }
            ),
        ];
        lines.extend(self.told_iso().map(|told| format!("iso      {told}")));
        lines.extend([
            format!("arm      {}", self.told_reach()),
            format!("pulses   {}", self.told_ground()),
        ]);
        lines.extend(self.poses.summary());
        lines
    }

    /// The whole report.
    pub fn html(&self) -> String {
        let mut report = Report::new(
            &format!("Surface {}", self.job.name),
            "Curvature-adaptive rows on a free-form surface, what they leave between them, and some of them as pulses of a six-axis arm.",
        );
        let mut summary = vec![
            ("Rows", self.told_rows().into()),
            (
                "Left between them",
                if self.keeps_scallop() {
                    self.told_residual().into()
                } else {
                    Cell::Judged(self.told_residual(), false)
                },
            ),
        ];
        summary.extend(self.told_iso().map(|told| ("Straight rows", told.into())));
        summary.extend([
            ("Arm", self.told_reach().into()),
            ("Pulses", self.told_ground().into()),
        ]);
        report.summary(&summary);
        self.surface_section(&mut report);
        self.residual_section(&mut report);
        self.strategy_section(&mut report);
        report.section("Rows as pulses");
        self.poses.overview(&mut report);
        self.poses.space_section(&mut report);
        self.poses.error_section(&mut report);
        self.poses.joint_section(&mut report);
        self.poses.pulse_section(&mut report);
        report.html()
    }

    fn surface_section(&self, report: &mut Report) {
        report.section("The surface and its rows");
        let part = &self.surface.part;
        let [[u0, u1], [v0, v1]] = part.domain();
        let at = |u: f64, v: f64| part.jet(u, v).ok().map(|jet| jet.s.to_array());
        let along =
            |k: u32, lo: f64, hi: f64, of: u32| lo + (hi - lo) * f64::from(k) / f64::from(of);
        let grid: Vec<Vec<[f64; 3]>> = (0..=12)
            .map(|i| {
                let u = along(i, u0, u1, 12);
                (0..=60)
                    .filter_map(|j| at(u, along(j, v0, v1, 60)))
                    .collect()
            })
            .chain((0..=1).map(|j| {
                let v = along(j, v0, v1, 1);
                (0..=60)
                    .filter_map(|i| at(along(i, u0, u1, 60), v))
                    .collect()
            }))
            .collect();
        let mut space = Space::of(grid.iter().flatten().copied());
        for line in &grid {
            space.path(line.iter().copied(), Pen::THIN);
        }
        let plan = &self.made.own.plan;
        let every = plan.rows.div_ceil(DRAWN).max(1);
        let [first, last] = self.made.ground;
        let thin = Pen {
            colour: colour(0),
            width: 0.9,
            ..Pen::EDGE
        };
        let thick = Pen {
            colour: colour(1),
            width: 2.2,
            ..Pen::EDGE
        };
        let is_ground = |row: usize| (first..=last).contains(&row);
        for segment in &plan.segments {
            if segment.row % every == 0 && !is_ground(segment.row) {
                space.path(segment.points.iter().map(|p| p.s.to_array()), thin);
            }
        }
        for segment in plan.segments.iter().filter(|s| is_ground(s.row)) {
            space.path(segment.points.iter().map(|p| p.s.to_array()), thick);
        }
        report.figure(
            &space.svg("The surface, isometric"),
            &format!(
                "Blue: {} of the {} rows, cut off where they leave the part. Orange: rows {first} to {last}, which became pulses. \
                 Rows stand closer where the part bulges, since the stripe of the wheel is narrower there.",
                if every == 1 { "all".into() } else { format!("one in {every}") },
                plan.rows
            ),
        );
    }

    fn residual_section(&self, report: &mut Report) {
        report.section("What is left between the rows");
        let hi = self.surface.grinding.process.scallop * 1e3;
        let figures: Vec<(String, &str)> = self
            .strategies()
            .map(|compared| {
                let title = format!("Residual, {}", name(compared));
                (self.map(&title, &compared.gaps, hi), "")
            })
            .collect();
        report.figures(&figures);
        report.text(
            "Each cell shows the highest cusp in it, simulated from the planned chords by the ground profile itself; red is above \
             the scallop that was asked for. Axes are the parameters of the surface.",
        );
    }

    fn map(&self, title: &str, gaps: &[Gap], hi: f64) -> String {
        let [[u0, u1], [v0, v1]] = self.surface.part.domain();
        let columns = self.surface.stations.min(80);
        let rows = 70;
        let mut values: Vec<Option<f64>> = vec![None; columns * rows];
        let cell = |x: f64, lo: f64, hi: f64, n: usize| {
            (((x - lo) / (hi - lo) * n as f64).max(0.0) as usize).min(n - 1)
        };
        for gap in gaps {
            let place = cell(gap.uv[1], v0, v1, rows) * columns + cell(gap.uv[0], u0, u1, columns);
            let height = gap.height * 1e3;
            values[place] = Some(values[place].map_or(height, |held| held.max(height)));
        }
        // Where rows are wider apart than cells, what lies between belongs to the cell below, or above.
        for place in columns..values.len() {
            if values[place].is_none() {
                values[place] = values[place - columns];
            }
        }
        for place in (0..values.len().saturating_sub(columns)).rev() {
            if values[place].is_none() {
                values[place] = values[place + columns];
            }
        }
        Map::new(title, "u", "v")
            .size(430.0, 330.0)
            .range((u0, u1), (v0, v1))
            .cells(columns, rows, values)
            .scale((0.25 * hi / 5.0).round() * 5.0, hi, "µm")
            .svg()
    }

    fn strategies(&self) -> impl Iterator<Item = &Compared> {
        self.made.strategies.iter().filter_map(|s| s.as_ref().ok())
    }

    fn strategy_section(&self, report: &mut Report) {
        report.section("Strategies");
        let rows: Vec<Vec<Cell>> = self
            .strategies()
            .map(|compared| {
                let (plan, r) = (&compared.plan, &compared.residual);
                let um = |x: f64| Cell::Number(number(x * 1e3, 2));
                let scallop = self.surface.grinding.process.scallop;
                vec![
                    name(compared).into(),
                    Cell::Number(format!("{} ({})", plan.rows, plan.full_rows)),
                    Cell::Number(number(plan.points() as f64, 0)),
                    Cell::Number(number(plan.path_length() / 1e3, 2)),
                    um(r.min),
                    Cell::Judged(number(r.max * 1e3, 2), r.max <= scallop),
                    um(r.mean),
                    Cell::Number(number(r.ratio(), 3)),
                    um(r.peak_to_valley[1]),
                    r.edge_max.map_or("–".into(), um),
                ]
            })
            .collect();
        report.table(
            "Residual heights [µm]",
            &[
                "strategy",
                "rows (full)",
                "points",
                "path [m]",
                "min",
                "max",
                "mean",
                "max/min",
                "peak to valley",
                "edge",
            ],
            &rows,
        );
        for failed in self.made.strategies.iter().filter_map(|s| s.as_ref().err()) {
            report.text(&format!("A baseline cannot be planned here: {failed}."));
        }
        let most = self.strategies().map(|c| c.residual.max * 1e3);
        let hi = (most.fold(50.0, f64::max) / 5.0).ceil() * 5.0;
        for (index, compared) in self.strategies().enumerate() {
            let title = format!(
                "{}: max/min {}",
                name(compared),
                number(compared.residual.ratio(), 3)
            );
            let heights = compared.gaps.iter().map(|gap| gap.height * 1e3);
            let mut figure = Histogram::new(&title, "residual [µm]", (0.0, hi), 200, heights)
                .colour(colour(index))
                .limit(self.surface.grinding.process.scallop * 1e3, "scallop");
            figure = match compared.strategy {
                Strategy::Adaptive => {
                    figure.band(PAPER_ADAPTIVE.0, PAPER_ADAPTIVE.1, "paper, adaptive")
                }
                Strategy::Iso(_) => figure.band(PAPER_ISO.0, PAPER_ISO.1, "paper, iso"),
                Strategy::RowMin => figure,
            };
            report.figure(&figure.svg(), "");
        }
        report.text(
            "Shaded: the range that the paper reports for its own surface, which it does not give: iso-parametric rows 21.6 to \
             47.5 µm (2.20), adaptive rows 24.1 to 32.6 µm (1.35). Ranges of the residual are to be compared, not their place.",
        );
    }
}

fn name(compared: &Compared) -> String {
    match compared.strategy {
        Strategy::Adaptive => "adaptive".into(),
        Strategy::RowMin => "row minimum".into(),
        Strategy::Iso(count) if compared.is_fewest => format!("iso, {count} rows (fewest)"),
        Strategy::Iso(count) => format!("iso, {count} rows"),
    }
}
