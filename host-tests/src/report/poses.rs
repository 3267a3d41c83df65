//! The report on a job with poses: the tool in space, the joints that move it, and how far it was off, from the pulses.

use super::motors::{Channel, Motors, Quantity, told_end, window_for};
use super::space::Space;
use super::{Cell, Report};
use crate::job::{AxisLimits, Job, Pace, PosesJob};
use crate::plot::{Chart, Pen, colour, number};
use crate::poses::{CHORDS, Measured};
use crate::run::{Outcome, RunPoses};
use crate::trace::seconds;

/// Everything that a finished job with poses says.
pub struct PosesFigures<'a> {
    pub job: &'a Job,
    pub poses: &'a PosesJob,
    pub outcome: &'a Outcome,
    pub run: &'a RunPoses,
    pub motors: Motors,
    pub measured: Measured,
    /// Time that the simulation itself took [s].
    pub wall: f64,
}

/// Poses that the table of joints has at most.
const MOST_ROWS: usize = 40;

impl<'a> PosesFigures<'a> {
    /// # Panics
    /// If the outcome is that of another kind of job.
    pub fn of(job: &'a Job, poses: &'a PosesJob, outcome: &'a Outcome, wall: f64) -> Self {
        let run = outcome.poses.as_ref();
        let run = run.expect("a job with poses leaves its plan");
        let idle = AxisLimits {
            steps_per_unit: 1.0,
            max_rate: 1.0,
            acceleration: 1.0,
            jerk: 1.0,
            travel: (0.0, 0.0),
        };
        let joints = &poses.machine.joints;
        let axes: [AxisLimits; 6] =
            std::array::from_fn(|i| joints.get(i).map_or(idle, |joint| joint.limits));
        let mut channels = Channel::of_axes(&axes);
        for (i, channel) in channels.iter_mut().enumerate() {
            match joints.get(i) {
                Some(joint) => {
                    channel.name = joint.name.clone();
                    channel.unit = joint.unit();
                }
                None => {
                    channel.name = format!("motor {}", i + 1);
                    channel.unit = "steps";
                    channel.largest_rate = None;
                    channel.largest_acceleration = None;
                    channel.largest_jerk = None;
                }
            }
        }
        let moves = std::array::from_fn(|i| i < joints.len());
        let mut motors = Motors::of(&outcome.trace, &channels, window_for(&axes, moves));
        // What the machine has not is not shown.
        motors.figures.truncate(joints.len());
        Self {
            motors,
            measured: Measured::of(poses, &outcome.trace, run.start),
            job,
            poses,
            outcome,
            run,
            wall,
        }
    }

    /// Whether every motor stands at its commanded count, nothing starved, tip and tool kept to their tolerances, and the
    /// joints to their limits.
    pub fn is_sound(&self) -> bool {
        self.is_exact()
            && self.outcome.starved == 0
            && self.keeps_tip()
            && self.keeps_angle()
            && self.motors.keep_limits()
    }

    pub fn is_exact(&self) -> bool {
        self.outcome.counts.map(i64::from) == self.outcome.trace.positions()
    }

    /// How far the tip goes for one step, of the joint where that is most [mm].
    pub fn step(&self) -> f64 {
        let joints = self.poses.machine.joints.iter().zip(self.run.plan.levers);
        let steps = joints.map(|(joint, lever)| lever / joint.limits.steps_per_unit);
        steps.fold(0.0, f64::max)
    }

    /// How far the tool turns for one step, of the joint where that is most [deg].
    pub fn angle_step(&self) -> f64 {
        let joints = self.poses.machine.joints.iter().filter(|joint| joint.turns);
        let steps = joints.map(|joint| 1.0 / joint.limits.steps_per_unit);
        steps.fold(0.0, f64::max)
    }

    pub fn keeps_tip(&self) -> bool {
        self.measured.tip <= self.poses.tip_tolerance + self.step()
    }

    pub fn keeps_angle(&self) -> bool {
        self.measured.angle <= self.allowed_angle()
    }

    /// Tolerance, one step, and what the machine cannot turn to [deg].
    fn allowed_angle(&self) -> f64 {
        self.poses.axis_tolerance + self.angle_step() + self.run.plan.residual
    }

    /// From the start of the path to the last step [s].
    pub fn time(&self) -> f64 {
        let (from, to) = self.span();
        to - from
    }

    pub(super) fn span(&self) -> (f64, f64) {
        let last = self.motors.figures.iter().filter_map(|f| f.statistics.last);
        let start = self.run.start;
        (
            seconds(start),
            seconds(last.max().unwrap_or(start).max(start)),
        )
    }

    pub(super) fn told_path(&self) -> String {
        let rows = &self.poses.rows;
        let length: f64 = rows
            .windows(2)
            .map(|pair| crate::reference::matrix::distance(pair[0].tip, pair[1].tip))
            .sum();
        let mut paces: Vec<Pace> = rows.iter().skip(1).map(|row| row.pace).collect();
        paces.dedup();
        let pace = match paces.as_slice() {
            [Pace::Feed(feed)] => format!(", {} mm/min", number(*feed, 0)),
            [Pace::InverseTime(rate)] => format!(", {} times a minute", number(*rate, 3)),
            _ => ", several feeds".into(),
        };
        format!(
            "{} poses, {} mm of tip{pace}; {} straight moves of the joints",
            rows.len(),
            number(length, 1),
            number(self.run.plan.blocks.len() as f64, 0)
        )
    }

    pub(super) fn told_time(&self) -> String {
        let planned = self.run.plan.duration();
        let limited = self
            .run
            .plan
            .blocks
            .iter()
            .filter(|block| block.limited_by.is_some())
            .count();
        let mut text = format!(
            "{} s, {} s by feed and joint speeds",
            number(self.time(), 3),
            number(planned, 3)
        );
        if limited > 0 {
            let mut names: Vec<&str> = Vec::new();
            for joint in self.run.plan.blocks.iter().filter_map(|b| b.limited_by) {
                let name = self.name(joint);
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            text.push_str(&format!(
                "; in {limited} moves the speed of {} rules instead of the feed",
                names.join(", ")
            ));
        }
        text
    }

    pub(super) fn told_tip(&self) -> String {
        format!(
            "off by at most {} µm (rms {} µm); tolerance {} µm and a step of {} µm",
            number(self.measured.tip * 1e3, 3),
            number(self.measured.tip_rms * 1e3, 3),
            number(self.poses.tip_tolerance * 1e3, 1),
            number(self.step() * 1e3, 2)
        )
    }

    pub(super) fn told_angle(&self) -> String {
        let residual = self.run.plan.residual;
        let cannot = if residual > 1e-3 {
            format!(
                ", and {}° that this machine cannot turn to",
                number(residual, 5)
            )
        } else {
            String::new()
        };
        format!(
            "off by at most {}°; tolerance {}° and a step of {}°{cannot}",
            number(self.measured.angle, 5),
            number(self.poses.axis_tolerance, 4),
            number(self.angle_step(), 5)
        )
    }

    pub(super) fn told_machine(&self) -> String {
        let joints = &self.poses.machine.joints;
        let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
        let mut text = format!("{}: {}", self.poses.machine.name, names.join(", "));
        if let Some(branch) = self.run.plan.branch {
            text.push_str(&format!("; branch {branch} of 8 for the whole path"));
        }
        text
    }

    fn name(&self, joint: usize) -> &str {
        let joints = &self.poses.machine.joints;
        joints.get(joint).map_or("?", |joint| joint.name.as_str())
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self) -> Vec<String> {
        let trace = &self.outcome.trace;
        let judged = |good: bool| if good { "" } else { ": TOO MUCH" };
        let mut lines = vec![
            format!("machine  {}", self.told_machine()),
            format!("path     {}", self.told_path()),
            format!("time     {}", self.told_time()),
            self.motors.told_pulses(trace.ticks(), self.wall),
            format!("tip      {}{}", self.told_tip(), judged(self.keeps_tip())),
            format!(
                "tool     {}{}",
                self.told_angle(),
                judged(self.keeps_angle())
            ),
            told_end(self.is_exact(), self.outcome.starved),
            self.motors.told_limits(),
            String::new(),
        ];
        lines.extend(self.motors.limits_in_lines("joint"));
        lines
    }

    /// The whole report.
    pub fn html(&self) -> String {
        let mut report = Report::new(
            &format!("Poses {}", self.job.name),
            "From poses of the tool to joints and pulses, and back from the pulses to the tool by an independent forward map.",
        );
        self.overview(&mut report);
        self.space_section(&mut report);
        self.error_section(&mut report);
        self.joint_section(&mut report);
        self.pose_section(&mut report);
        self.pulse_section(&mut report);
        report.html()
    }

    pub(super) fn overview(&self, report: &mut Report) {
        let judged = |text: String, good: bool| match good {
            true => Cell::Text(text),
            false => Cell::Judged(text, false),
        };
        report.summary(&[
            ("Machine", self.told_machine().into()),
            ("Path", self.told_path().into()),
            ("Time", self.told_time().into()),
            (
                "Approach",
                format!(
                    "{} s from joint zero to the first pose",
                    number(seconds(self.run.start), 3)
                )
                .into(),
            ),
            ("Tip", judged(self.told_tip(), self.keeps_tip())),
            ("Tool", judged(self.told_angle(), self.keeps_angle())),
            (
                "Steps",
                self.motors.told_steps(self.outcome.trace.ticks()).into(),
            ),
            (
                "End",
                judged(
                    if self.is_exact() {
                        "every motor exactly at its commanded count".into()
                    } else {
                        "motors not at their commanded counts".into()
                    },
                    self.is_exact(),
                ),
            ),
            (
                "Queue ran dry",
                format!("{} times", self.outcome.starved).into(),
            ),
            ("Limits", self.motors.limits_cell()),
        ]);
        self.motors.limits_table(report);
        report.text("Largest values of the whole run, approach included.");
    }

    pub(super) fn space_section(&self, report: &mut Report) {
        report.section("The tool in space");
        let rows = &self.poses.rows;
        let mut space = Space::of(rows.iter().map(|row| row.tip));
        let samples = &self.measured.samples;
        // Evenly in time, so that the crowding shows where the tool is slow.
        let every = (samples.len() / 90).max(1);
        for sample in samples.iter().step_by(every) {
            space.tool(sample.tool.tip, sample.tool.axis, Pen::THIN);
        }
        let every = (samples.len() / 4000).max(1);
        let made = samples.iter().step_by(every).map(|sample| sample.tool.tip);
        space.path(
            made,
            Pen {
                colour: colour(0),
                width: 1.8,
                ..Pen::EDGE
            },
        );
        let shown = (rows.len() / 60).max(1);
        for row in rows.iter().step_by(shown) {
            space.tool(
                row.tip,
                row.axis,
                Pen {
                    colour: colour(1),
                    width: 1.4,
                    ..Pen::EDGE
                },
            );
            space.dot(row.tip, colour(1));
        }
        report.figure(
            &space.svg("Tip and tool axis in the work frame, isometric"),
            "Blue: the tip as the pulses make it. Orange: the poses of the job, with the tool axis from the tip into the \
             body. Grey: the tool axis at even intervals of time, from the pulses.",
        );
    }

    pub(super) fn error_section(&self, report: &mut Report) {
        report.section("Errors of tip and tool");
        let (from, to) = self.span();
        let allowed = (self.poses.tip_tolerance + self.step()) * 1e3;
        let samples = &self.measured.samples;
        let chart = Chart::new("Tip off the path", "time [s]", "µm")
            .size(860.0, 220.0)
            .x_range(from, to)
            .y_range(0.0, 1.15 * allowed.max(self.measured.tip * 1e3))
            .line(
                "tip",
                colour(0),
                samples.iter().map(|s| (s.time, s.tip * 1e3)),
            )
            .limit("tolerance and a step", allowed)
            .limit("tolerance", self.poses.tip_tolerance * 1e3);
        report.figure(
            &chart.svg(),
            &format!(
                "Every millisecond the joints, as the pulses make them, are taken forward by a map that shares no code with \
                 the solver, and compared with the straight lines between the poses. Chords of the joints may use {}\u{a0}% of the \
                 tolerance, the rounding of their corners lies where they stray least.",
                number(CHORDS * 100.0, 0)
            ),
        );
        let largest = self.measured.angle.max(1e-6);
        let allowed = self.allowed_angle();
        // A tolerance that is far away would flatten the line.
        let near = largest > 0.2 * allowed;
        let mut chart = Chart::new("Tool off its direction", "time [s]", "deg")
            .size(860.0, 200.0)
            .x_range(from, to)
            .y_range(
                0.0,
                1.15 * if near { allowed.max(largest) } else { largest },
            )
            .line("tool", colour(1), samples.iter().map(|s| (s.time, s.angle)));
        if near {
            chart = chart.limit("tolerance and a step", allowed);
        }
        report.figure(
            &chart.svg(),
            &format!(
                "Against the direction at the same place of the path; tolerance {}°.",
                number(self.poses.axis_tolerance, 4)
            ),
        );
    }

    pub(super) fn joint_section(&self, report: &mut Report) {
        report.section("Joints");
        let (from, to) = self.span();
        let joints = self.poses.machine.joints.iter().enumerate();
        let (turning, sliding): (Vec<_>, Vec<_>) = joints.partition(|(_, joint)| joint.turns);
        for (title, list) in [
            ("Joints that slide", sliding),
            ("Joints that turn", turning),
        ] {
            let motors: Vec<usize> = list.iter().map(|(i, _)| *i).collect();
            if !motors.is_empty() {
                let chart = self.motors.position_chart(title, &motors, from, to);
                report.figure(&chart, "");
            }
        }
        for motor in 0..self.motors.figures.len() {
            let chart = self.motors.chart(motor, Quantity::Speed, from, to);
            report.figure(&chart, "");
        }
        let all: Vec<usize> = (0..self.motors.figures.len()).collect();
        let chart = self
            .motors
            .acceleration_chart("Accelerations", &all, from, to);
        report.figure(&chart, "All rebuilt from the pulses alone.");
    }

    pub(super) fn pose_section(&self, report: &mut Report) {
        report.section("Poses and their joints");
        let plan = &self.run.plan;
        let joints = &self.poses.machine.joints;
        let mut head = vec!["pose".to_string()];
        head.extend(["X", "Y", "Z", "I", "J", "K"].map(String::from));
        head.extend(joints.iter().map(|j| format!("{} [{}]", j.name, j.unit())));
        head.push("moves".into());
        let ends = |index: usize| match index.checked_sub(1) {
            None => (Some(plan.start), 0),
            Some(segment) => {
                let own = plan.blocks.iter().filter(|b| b.segment == segment);
                (own.clone().next_back().map(|b| b.joints), own.count())
            }
        };
        let rows: Vec<Vec<Cell>> = self
            .poses
            .rows
            .iter()
            .enumerate()
            .take(MOST_ROWS)
            .map(|(index, row)| {
                let (at, moves) = ends(index);
                let mut cells = vec![Cell::Number(index.to_string())];
                cells.extend(row.tip.map(|x| Cell::Number(number(x, 3))));
                cells.extend(row.axis.map(|x| Cell::Number(number(x, 4))));
                let at = at.unwrap_or_default();
                cells.extend((0..joints.len()).map(|i| Cell::Number(number(at[i], 4))));
                cells.push(Cell::Number(moves.to_string()));
                cells
            })
            .collect();
        let caption = if self.poses.rows.len() > MOST_ROWS {
            format!("The first {MOST_ROWS} of {} poses", self.poses.rows.len())
        } else {
            "Poses [mm] and the joints that reach them".into()
        };
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        report.table(&caption, &head, &rows);
    }

    pub(super) fn pulse_section(&self, report: &mut Report) {
        let (names, timing) = (self.job.motor_names(), &self.job.timing);
        let trace = &self.outcome.trace;
        self.motors
            .pulse_section(report, trace, &names, self.span(), timing);
    }
}
