//! The report on a path of joints: what every joint did, and how far the contour is off.

use super::bounds::Bounds;
use super::contour::ContourError;
use super::motors::{Channel, Motors, Quantity, end_cell, told_end, window_for};
use super::ruling::{Limit, RULES, Ruler, Ruling};
use super::shaping::ShapingFigures;
use super::{Cell, Report};
use crate::job::{FIRST_TURNING, Job, Pace, PathJob};
use crate::plot::{Chart, Drawing, Pen, Strip, colour, number};
use crate::run::Outcome;
use crate::trace::seconds;
use hexstep::protocol::cue::{Action, Cue};

/// Everything that a finished path job says.
pub struct PathFigures<'a> {
    pub job: &'a Job,
    pub path: &'a PathJob,
    pub outcome: &'a Outcome,
    /// Figures of the motors that the job has.
    pub motors: Motors,
    pub contour: ContourError,
    pub bounds: Bounds,
    pub ruling: Ruling,
    /// What the shapers do, where the job has some.
    pub shaping: Option<ShapingFigures<'a>>,
    /// Time that the simulation itself took [s].
    pub wall: f64,
}

impl<'a> PathFigures<'a> {
    pub fn of(job: &'a Job, path: &'a PathJob, outcome: &'a Outcome, wall: f64) -> Self {
        let mut channels = Channel::of_axes(&path.axes);
        for (channel, name) in channels.iter_mut().zip(&path.names) {
            channel.name = name.clone();
        }
        let window = window_for(&path.axes, path.moves());
        let mut motors = Motors::of(&outcome.trace, &channels, window);
        motors.half_steps = if path.rests_anywhere() { 2.0 } else { 1.0 };
        let figures = motors.figures.into_iter().enumerate();
        let has = figures.filter(|(motor, _)| path.joints.contains(motor));
        motors.figures = has.map(|(_, figures)| figures).collect();
        // The path begins at rest at 0.
        let mut points = vec![[0.0; 6]];
        points.extend(path.points.iter().map(|point| point.at));
        let contour = ContourError::of(
            &outcome.trace,
            &points,
            &path.axes.map(|axis| axis.steps_per_unit),
            &path.contour.weights(),
            path.is_stopped(),
        );
        let span = span_of(&motors);
        Self {
            ruling: Ruling::of(path, &motors, &contour, span),
            bounds: Bounds::of(path),
            motors,
            contour,
            shaping: ShapingFigures::of(path, outcome),
            job,
            path,
            outcome,
            wall,
        }
    }

    /// Whether every motor stands where the path ends, nothing starved, and contour and limits are kept.
    pub fn is_sound(&self) -> bool {
        self.wrongs().is_empty()
    }

    /// Everything that is not as it should be, in words.
    fn wrongs(&self) -> Vec<String> {
        let mut wrongs = Vec::new();
        if !self.is_exact() {
            wrongs.push("motors not at their commanded counts".into());
        }
        if self.outcome.starved > 0 {
            wrongs.push(format!("queue ran dry {} times", self.outcome.starved));
        }
        if !self.keeps_contour() {
            wrongs.push(format!(
                "{} µm off the path, {} µm allowed",
                number(self.contour.largest * 1e3, 2),
                number(self.allowed() * 1e3, 2)
            ));
        }
        wrongs.extend(self.motors.worst());
        wrongs
    }

    fn told_verdict(&self) -> String {
        match self.wrongs().as_slice() {
            [] => "as it should be: counts, contour and limits are kept".into(),
            wrongs => format!("WRONG: {}", wrongs.join("; ")),
        }
    }

    /// Whether every motor stands at its commanded count, and that is the end of the path (unless it was stopped before,
    /// or a motor was trimmed).
    pub fn is_exact(&self) -> bool {
        let counts = self.outcome.counts;
        let end = self.path.end();
        let free = self.path.is_stopped() || self.path.is_trimmed();
        counts.map(i64::from) == self.outcome.trace.positions() && (free || Some(counts) == end)
    }

    /// Tolerance and one step [mm], and what shaping takes the path off: what the contour may be off.
    pub fn allowed(&self) -> f64 {
        let shaping = self.shaping.as_ref().map_or(0.0, |s| s.error.largest);
        self.path.tolerance() + self.path.step() + shaping
    }

    /// Whether the contour is within [`Self::allowed`]; a trim is meant to leave it.
    pub fn keeps_contour(&self) -> bool {
        self.path.is_trimmed() || self.contour.largest <= self.allowed()
    }

    /// From the first step to the last [s].
    pub fn time(&self) -> f64 {
        let (from, to) = self.span();
        to - from
    }

    /// Time of the first step and of the last [s].
    fn span(&self) -> (f64, f64) {
        span_of(&self.motors)
    }

    /// Least times of all blocks that have one, and all dwells [s].
    pub fn programmed(&self) -> f64 {
        let blocks = self.path.blocks.iter().map(|block| block.duration);
        let dwells = self.path.points.iter().map(|point| point.dwell);
        blocks.chain(dwells).sum()
    }

    fn rapids(&self) -> usize {
        let points = self.path.points.iter();
        points.filter(|point| point.pace == Pace::Rapid).count()
    }

    /// Figures of motors that step.
    fn moving(&self) -> Vec<usize> {
        let moves = |figure: &usize| self.motors.figures[*figure].statistics.steps() > 0;
        (0..self.motors.figures.len()).filter(moves).collect()
    }

    fn slides(&self, figure: &usize) -> bool {
        self.path.joints[*figure] < FIRST_TURNING
    }

    fn name(&self, figure: usize) -> &str {
        &self.motors.figures[figure].channel.name
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self) -> Vec<String> {
        let trace = &self.outcome.trace;
        let mut lines = vec![
            format!("verdict  {}", self.told_verdict()),
            format!("path     {}", self.told_path()),
            format!("time     {}", self.told_time()),
            format!("bounds   {}", self.told_bounds()),
            format!("ruled    {}", self.told_ruling()),
            self.motors.told_pulses(trace.ticks(), self.wall),
            format!(
                "contour  off the path by at most {:.2} µm, points by {:.2} µm; tolerance {:.2} µm and a step of {:.2} µm{}{}",
                self.contour.largest * 1e3,
                self.contour.cut * 1e3,
                self.path.tolerance() * 1e3,
                self.path.step() * 1e3,
                self.told_share(),
                if self.keeps_contour() {
                    ""
                } else {
                    ": TOO MUCH"
                }
            ),
            told_end(self.is_exact(), self.outcome.starved),
        ];
        if let Some(shaping) = &self.shaping {
            lines.extend(shaping.lines());
        }
        lines.push(String::new());
        lines.extend(self.motors.limits_in_lines("motor"));
        lines
    }

    fn told_limit(&self) -> &'static str {
        if self.shaping.is_some() {
            "tolerance; tolerance, a step and shaping"
        } else {
            "tolerance; tolerance and a step"
        }
    }

    /// What of the contour error may be the shapers'.
    fn told_share(&self) -> String {
        self.shaping.as_ref().map_or_else(String::new, |shaping| {
            format!(", {} µm by shaping", number(shaping.error.largest * 1e3, 2))
        })
    }

    fn told_path(&self) -> String {
        let sum = |range: std::ops::Range<usize>| -> f64 {
            let mut from = [0.0; 6];
            let mut sum = 0.0;
            for point in &self.path.points {
                let squares = range.clone().map(|i| (point.at[i] - from[i]).powi(2));
                sum += squares.sum::<f64>().sqrt();
                from = point.at;
            }
            sum
        };
        let cues = match self.path.cues.len() {
            0 => String::new(),
            1 => ", 1 cue".into(),
            n => format!(", {n} cues"),
        };
        format!(
            "{} blocks ({} rapid), {} mm of sliding, {} deg of turning{cues}",
            number(self.path.points.len() as f64, 0),
            number(self.rapids() as f64, 0),
            number(sum(0..FIRST_TURNING), 1),
            number(sum(FIRST_TURNING..6), 1),
        )
    }

    fn told_time(&self) -> String {
        let programmed = self.programmed();
        let what = if self.rapids() == 0 {
            "programmed"
        } else {
            "programmed beside the rapids"
        };
        format!(
            "{} s from the first step to the last, {} s {what}",
            number(self.time(), 3),
            number(programmed, 3)
        )
    }

    fn told_bounds(&self) -> String {
        let beside = |bound: f64| {
            let share = 100.0 * self.time() / bound.max(1e-9);
            format!("{} % of the {} s", number(share, 1), number(bound, 3))
        };
        let cues = if self.path.cues.is_empty() {
            ""
        } else {
            "; without the cues"
        };
        format!(
            "it took {} of its feed and ramps, {} of its blocks from rest to rest{cues}",
            beside(self.bounds.feed),
            beside(self.bounds.rest)
        )
    }

    fn told_ruling(&self) -> String {
        let times = self.ruling.times();
        let all: f64 = times.iter().map(|(_, time)| time).sum();
        let told = times.iter().take(5).map(|(ruler, time)| {
            format!(
                "{} {} %",
                self.told_ruler(*ruler),
                number(100.0 * time / all, 0)
            )
        });
        match times.len() {
            0 => "nothing moved".into(),
            _ => told.collect::<Vec<_>>().join(", "),
        }
    }

    fn told_ruler(&self, ruler: Ruler) -> String {
        match ruler {
            Ruler::Feed => "feed".into(),
            Ruler::Joint(figure, limit) => format!("{} of {}", limit.name(), self.name(figure)),
            Ruler::Nothing => "nothing".into(),
        }
    }

    /// The whole report.
    pub fn html(&self) -> String {
        let mut report = Report::new(
            &format!("Path {}", self.job.name),
            "From points of all joints to pulse trains, and back from the pulses to the motion of every joint.",
        );
        self.overview(&mut report);
        self.contour_section(&mut report);
        if let Some(shaping) = &self.shaping {
            shaping.section(&mut report);
        }
        self.motion_section(&mut report);
        self.pulse_section(&mut report);
        report.html()
    }

    fn overview(&self, report: &mut Report) {
        let trace = &self.outcome.trace;
        let contour = format!(
            "at most {} µm off, programmed points at most {} µm; tolerance {} µm and a step of {} µm{}",
            number(self.contour.largest * 1e3, 2),
            number(self.contour.cut * 1e3, 2),
            number(self.path.tolerance() * 1e3, 2),
            number(self.path.step() * 1e3, 2),
            self.told_share()
        );
        let verdict = self.told_verdict();
        let mut rows: Vec<(&str, Cell)> = vec![
            (
                "Verdict",
                if self.is_sound() {
                    verdict.into()
                } else {
                    Cell::Judged(verdict, false)
                },
            ),
            ("Path", self.told_path().into()),
            ("Time", self.told_time().into()),
            ("Bounds", self.told_bounds().into()),
            ("Ruled", self.told_ruling().into()),
            ("Steps", self.motors.told_steps(trace.ticks()).into()),
            (
                "Contour",
                if self.keeps_contour() {
                    contour.into()
                } else {
                    Cell::Judged(contour, false)
                },
            ),
            ("End", end_cell(self.is_exact())),
            (
                "Queue ran dry",
                format!("{} times", self.outcome.starved).into(),
            ),
        ];
        rows.extend(self.shaping.iter().flat_map(ShapingFigures::rows));
        for cue in &self.path.cues {
            rows.push(("Cue", self.told_cue(cue).into()));
        }
        report.summary(&rows);
        self.motors.limits_table(report);
    }

    fn contour_section(&self, report: &mut Report) {
        report.section("Contour");
        if let Some((u, v)) = self.plane() {
            report.figure(
                &self.drawing(u, v),
                "The programmed points joined by straight lines, grey, under the path of the pulses; the dot is the start.",
            );
        }
        let (from, to) = self.shown();
        let tolerance = self.path.tolerance() * 1e3;
        let micrometres = self.contour.samples.iter().map(|(t, e)| (*t, e * 1e3));
        let mut chart = Chart::new("Contour error", "time [s]", "off the path [µm]")
            .size(860.0, 200.0)
            .x_range(from, to)
            .y_range(0.0, 1.15 * (self.allowed().max(self.contour.largest) * 1e3))
            .line("contour error", colour(0), micrometres)
            .limit(self.told_limit(), self.allowed() * 1e3);
        if tolerance > 0.0 {
            // A step above it stands the label of both.
            chart = chart.limit("", tolerance);
        }
        report.figure(
            &chart.svg(),
            "Distance of the joints, as the pulses make them, from the straight lines between the programmed points, both \
             run through in order; angles weigh as arcs at the lever's length. Below a step it is the grid of whole steps \
             that shows.",
        );
    }

    fn motion_section(&self, report: &mut Report) {
        report.section("Motion");
        let (from, to) = self.shown();
        if self.moving().iter().any(|figure| self.slides(figure)) {
            report.figure(
                &self.speed_chart(from, to),
                "The feed as the pulses show it.",
            );
        }
        report.figure(
            &self.ruling_strip(from, to),
            &format!(
                "Which limit was nearest: the feed, or the largest share that a joint had of its velocity, acceleration or \
                 jerk within half a window; nothing ruled where all were below {} %.",
                number(RULES * 100.0, 0)
            ),
        );
        self.ruling_table(report);
        let moving = self.moving();
        for (index, motor) in moving.iter().enumerate() {
            for quantity in Quantity::ALL {
                let caption = if index == 0 && quantity == Quantity::Jerk {
                    format!(
                        "All rebuilt from the pulses alone, over windows of {} ms; the limits are those of the job.",
                        number(self.motors.window * 1e3, 0)
                    )
                } else {
                    String::new()
                };
                report.figure(&self.motors.chart(*motor, quantity, from, to), &caption);
            }
        }
        let still: Vec<&str> = (0..self.motors.figures.len())
            .filter(|figure| !moving.contains(figure))
            .map(|figure| self.name(figure))
            .collect();
        if !still.is_empty() {
            report.text(&format!("At rest all the time: {}.", still.join(", ")));
        }
    }

    fn pulse_section(&self, report: &mut Report) {
        let (names, timing) = (self.job.motor_names(), &self.job.timing);
        let trace = &self.outcome.trace;
        self.motors
            .pulse_section(report, trace, &names, self.span(), timing);
    }

    /// Stretch of time that charts show [s]: the motion with a little rest around it.
    fn shown(&self) -> (f64, f64) {
        let (from, to) = self.span();
        let air = 0.02 * (to - from) + 0.005;
        ((from - air).max(0.0), to + air)
    }

    /// Speed along the joints that slide, and the feed where there is but one.
    fn speed_chart(&self, from: f64, to: f64) -> String {
        let sliding = (0..self.motors.figures.len()).filter(|figure| self.slides(figure));
        let figures: Vec<_> = sliding.map(|figure| &self.motors.figures[figure]).collect();
        let Some(motion) = figures.first().map(|f| &f.motion) else {
            return String::new();
        };
        let names: Vec<&str> = figures.iter().map(|f| f.channel.name.as_str()).collect();
        let speeds = (0..motion.speed.len()).map(|k| {
            let squares = figures
                .iter()
                .map(|f| (f.motion.speed[k] / f.channel.steps_per_unit).powi(2));
            (motion.time(k), squares.sum::<f64>().sqrt())
        });
        let title = format!("Speed along {}", names.join(", "));
        let mut chart = Chart::new(&title, "time [s]", "mm/s")
            .size(860.0, 180.0)
            .x_range(from, to)
            .line("speed", colour(0), speeds);
        let feeds = self.path.points.iter().map(|point| point.pace);
        let mut feeds = feeds.collect::<Vec<_>>();
        feeds.dedup();
        if let [Pace::Feed(feed)] = feeds.as_slice() {
            chart = chart.limit("programmed feed", feed / 60.0);
        }
        chart.svg()
    }

    /// What ruled over time, by limit and by joint.
    fn ruling_strip(&self, from: f64, to: f64) -> String {
        let grey = || "#dde1e5".to_string();
        let mut limits = vec![("feed".to_string(), FEED.to_string())];
        limits.extend(
            Limit::ALL
                .iter()
                .zip(LIMITS)
                .map(|(l, c)| (l.name().into(), c.into())),
        );
        limits.push(("nothing".into(), grey()));
        let by_limit = self.ruling.stretches.iter().map(|(from, to, ruler)| {
            let kind = match ruler {
                Ruler::Feed => 0,
                Ruler::Joint(_, limit) => {
                    1 + Limit::ALL.iter().position(|l| l == limit).unwrap_or(0)
                }
                Ruler::Nothing => 1 + Limit::ALL.len(),
            };
            (*from, *to, kind)
        });
        let joints = 0..self.motors.figures.len();
        let mut names: Vec<(String, String)> = joints
            .map(|figure| (self.name(figure).into(), colour(figure).into()))
            .collect();
        names.push(("none".into(), grey()));
        let none = names.len() - 1;
        let by_joint = self.ruling.stretches.iter().map(|(from, to, ruler)| {
            let kind = match ruler {
                Ruler::Joint(figure, _) => *figure,
                _ => none,
            };
            (*from, *to, kind)
        });
        Strip::new("What ruled", "time [s]", from, to)
            .lane("what", limits, by_limit)
            .lane("of", names, by_joint)
            .svg()
    }

    /// Shares of time.
    fn ruling_table(&self, report: &mut Report) {
        let times = self.ruling.times();
        let all: f64 = times.iter().map(|(_, time)| time).sum();
        let row = |(ruler, time): &(Ruler, f64)| {
            vec![
                Cell::Text(self.told_ruler(*ruler)),
                Cell::Number(number(*time, 3)),
                Cell::Number(number(100.0 * time / all, 1)),
            ]
        };
        let rows: Vec<Vec<Cell>> = times.iter().map(row).collect();
        report.table(
            "What ruled for how long",
            &["limit", "time [s]", "share [%]"],
            &rows,
        );
    }

    /// The two joints that are drawn against each other: the first two that slide, else the first two that turn.
    fn plane(&self) -> Option<(usize, usize)> {
        let moving = self.moving();
        let (sliding, turning): (Vec<usize>, Vec<usize>) =
            moving.into_iter().partition(|figure| self.slides(figure));
        [sliding, turning]
            .into_iter()
            .find_map(|motors| match motors.as_slice() {
                [u, v, ..] => Some((*u, *v)),
                _ => None,
            })
    }

    fn drawing(&self, u: usize, v: usize) -> String {
        let title = format!("{} across, {} up", self.name(u), self.name(v));
        let unit = self.motors.figures[u].channel.unit;
        let (u, v) = (self.path.joints[u], self.path.joints[v]);
        let programmed = self
            .path
            .points
            .iter()
            .map(|point| (point.at[u], point.at[v]));
        let programmed = std::iter::once((0.0, 0.0)).chain(programmed);
        let made = self.contour.joints.iter().map(|at| (at[u], at[v]));
        let corners: Vec<(f64, f64)> = programmed.clone().collect();
        let extent = |list: &dyn Fn(&(f64, f64)) -> f64| {
            let least = corners.iter().map(list).fold(f64::INFINITY, f64::min);
            let most = corners.iter().map(list).fold(f64::NEG_INFINITY, f64::max);
            most - least
        };
        let (wide, high) = (extent(&|p| p.0), extent(&|p| p.1));
        // At most 420 pixels high, and as wide as the page where the path is flat.
        let width = (420.0 * wide / high.max(1e-9)).clamp(300.0, 860.0);
        let (low, left) = corners.iter().fold((0.0f64, 0.0f64), |(low, left), p| {
            (low.min(p.1), left.min(p.0))
        });
        Drawing::new(&title, width)
            .line(
                programmed,
                Pen {
                    colour: "#c3c9d0",
                    width: 4.0,
                    ..Pen::EDGE
                },
            )
            .line(
                made,
                Pen {
                    colour: colour(0),
                    width: 1.2,
                    ..Pen::EDGE
                },
            )
            .circle(
                (0.0, 0.0),
                0.006 * wide.max(high),
                Pen {
                    fill: crate::plot::INK,
                    ..Pen::EDGE
                },
            )
            .dimension(
                (left, low - 0.06 * high.max(0.1 * wide)),
                (left + wide, low - 0.06 * high.max(0.1 * wide)),
                &format!("{} {unit}", number(wide, 1)),
            )
            .svg()
    }

    fn told_cue(&self, cue: &Cue) -> String {
        let what = match cue.action {
            Action::Hold => "hold".into(),
            Action::Resume => "resume".into(),
            Action::Feed(factor) => format!("feed override {:.0} %", factor * 100.0),
            Action::Rapid(factor) => format!("rapid override {:.0} %", factor * 100.0),
            Action::Trim { motor, steps } => format!(
                "trim of {} by {steps} steps",
                self.path.names.get(motor).map_or("?", String::as_str)
            ),
            Action::Stop => "controlled stop".into(),
        };
        format!(
            "{what} at {} ms of the motion",
            number(f64::from(cue.at), 0)
        )
    }
}

/// Colours of what rules: the feed, and the limits of joints in their order.
const FEED: &str = "#1b8f5a";
const LIMITS: [&str; 3] = ["#0b6fb8", "#e08a1e", "#a3478f"];

/// Time of the first step and of the last [s].
fn span_of(motors: &Motors) -> (f64, f64) {
    let steps = motors.figures.iter().map(|f| &f.statistics);
    let first = steps.clone().filter_map(|s| s.first).min();
    let last = steps.filter_map(|s| s.last).max();
    (seconds(first.unwrap_or(0)), seconds(last.unwrap_or(0)))
}
