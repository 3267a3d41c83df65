//! What the pulses of both machines made of a panel: joints, speeds, the wall between the tips, and the trim.

use super::mirror::told_walls;
use super::motors::{Channel, Motors, end_cell, told_end, window_for};
use super::{Cell, Report};
use crate::job::{AxisLimits, Job, PairJob};
use crate::mirror::{Simulation, TOLERANCE};
use crate::pair::{PairMeasured, PairSample, RowMeasured};
use crate::plot::{Chart, colour, number};
use crate::run::RunPair;
use crate::trace::{Trace, seconds};
use hexstep::machines::two_sided::WallLimits;

/// The figures of a pair.
pub struct PairFigures<'a> {
    pub job: &'a Job,
    pub pair: &'a PairJob,
    pub simulation: &'a Simulation,
    pub run: &'a RunPair,
    pub motors: Motors,
    pub measured: PairMeasured,
}

impl<'a> PairFigures<'a> {
    /// Measures the pulses of a run on a machine that is off by `error` [mm] everywhere.
    pub fn of(
        job: &'a Job,
        pair: &'a PairJob,
        simulation: &'a Simulation,
        run: &'a RunPair,
        error: f64,
    ) -> Self {
        let axes: [AxisLimits; 8] = std::array::from_fn(|i| pair.joints[i].limits);
        let channels: [Channel; 8] = std::array::from_fn(|i| {
            let (joint, axis) = (&pair.joints[i], &axes[i]);
            let steps = axis.steps_per_unit;
            Channel {
                name: joint.name.clone(),
                unit: joint.unit(),
                steps_per_unit: steps,
                largest_rate: Some(axis.max_rate * steps),
                largest_acceleration: Some(axis.acceleration * steps),
                largest_jerk: Some(axis.jerk * steps),
            }
        });
        Self {
            motors: Motors::of(&run.trace, &channels, window_for(&axes, [true; 8])),
            measured: PairMeasured::of(pair, simulation, run, error),
            job,
            pair,
            simulation,
            run,
        }
    }

    /// Whether every motor stands at its commanded count, nothing starved, the tips kept their distance, and every trimmed
    /// wall is within its tolerance.
    pub fn is_sound(&self) -> bool {
        self.is_exact()
            && self.run.starved == 0
            && self.keeps_tips()
            && self.measured.trim <= self.simulation.amount + self.allowed()
            && self.measured.trimmed.within() >= 1.0
            && self.motors.keep_limits()
    }

    /// Trims are taken back at the end of each row: the counts are those of the plan.
    pub fn is_exact(&self) -> bool {
        let counts = self.run.counts;
        counts.map(i64::from) == self.run.trace.positions() && counts == self.run.wanted
    }

    /// Thickness, lateral and anti-parallel error of the tips.
    pub fn keeps_tips(&self) -> bool {
        let (thickness, limits) = (&self.measured.thickness, WallLimits::<f64>::default());
        let wall = self.run.plan.wall;
        let off = (thickness.max() - wall).max(wall - thickness.min());
        off <= 2.0 * self.allowed()
            && self.measured.lateral <= limits.lateral
            && self.measured.anti_parallel <= limits.anti_parallel.to_degrees()
    }

    /// What a tip may be off: its tolerance, and a step of every joint of its side [mm].
    fn allowed(&self) -> f64 {
        let joints = self.pair.joints.iter().take(4);
        let steps = joints.map(|joint| {
            let lever = if joint.turns {
                self.run.plan.lever.to_radians()
            } else {
                1.0
            };
            lever / joint.limits.steps_per_unit
        });
        self.pair.tip_tolerance + steps.sum::<f64>()
    }

    fn told_rows(&self) -> String {
        let names: Vec<&str> = self.pair.rows.iter().map(|row| row.name.as_str()).collect();
        let readings: usize = self.run.rows.iter().map(|row| row.readings.len()).sum();
        let time: f64 = self
            .run
            .rows
            .iter()
            .map(|row| seconds(row.end - row.start))
            .sum();
        format!(
            "{}: {} s at {} mm/s, {} readings of the sensor while they ran",
            names.join(", "),
            number(time, 2),
            number(self.simulation.feed, 2),
            number(readings as f64, 0)
        )
    }

    fn told_tips(&self) -> String {
        let m = &self.measured;
        let wall = self.run.plan.wall;
        let off = (m.thickness.max() - wall).max(wall - m.thickness.min());
        format!(
            "{} ± {} mm apart along the normal, asked for {}, off by at most {} µm; across it {} µm, anti-parallel within {}°",
            number(m.thickness.mean(), 6),
            number(m.thickness.sigma(), 6),
            number(wall, 6),
            number(off * 1e3, 2),
            number(m.lateral * 1e3, 2),
            number(m.anti_parallel, 5)
        )
    }

    fn told_trim(&self) -> String {
        format!(
            "at most {} mm of {}, the same on both sides; support within {} µm of its row",
            number(self.measured.trim, 4),
            self.simulation.amount,
            number(self.measured.aside * 1e3, 2)
        )
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self, wall: f64) -> Vec<String> {
        let judged = |good: bool| if good { "" } else { ": TOO MUCH" };
        let m = &self.measured;
        let tips = judged(self.keeps_tips());
        let mut lines = vec![
            format!("milled   {}", self.told_rows()),
            self.motors.told_pulses(self.run.trace.ticks(), wall),
            format!("tips     {}{tips}", self.told_tips()),
            format!("trim     {}", self.told_trim()),
            format!("pulses untrimmed   {}", told_walls(&m.untrimmed)),
            format!("pulses trimmed     {}", told_walls(&m.trimmed)),
            told_end(self.is_exact(), self.run.starved),
            self.motors.told_limits(),
            String::new(),
        ];
        lines.extend(self.motors.limits_in_lines("joint"));
        lines
    }

    /// All that the report shows of the pulses.
    pub fn sections(&self, report: &mut Report) {
        report.section("Both machines, from their pulses");
        let judged = |text: String, good: bool| match good {
            true => Cell::Text(text),
            false => Cell::Judged(text, false),
        };
        let m = &self.measured;
        report.summary(&[
            ("Rows", self.told_rows().into()),
            ("Tips", judged(self.told_tips(), self.keeps_tips())),
            ("Trim", self.told_trim().into()),
            ("Wall untrimmed", told_walls(&m.untrimmed).into()),
            (
                "Wall trimmed",
                judged(told_walls(&m.trimmed), m.trimmed.within() >= 1.0),
            ),
            ("Machine", self.told_machine().into()),
            (
                "Steps",
                self.motors.told_steps(self.run.trace.ticks()).into(),
            ),
            ("End", end_cell(self.is_exact())),
            (
                "Queue ran dry",
                format!("{} times", self.run.starved).into(),
            ),
        ]);
        report.text(
            "The controller of the target runs eight motors; while a row runs, the sensor's readings arrive on its serial line, \
             seen where the pulses have taken the support. Every millisecond both tools are rebuilt from the pulses by a \
             forward map that shares no code with the solver. Wall left = thickness between the tips + trim of the support off \
             the reference surface \u{2212} how far the panel has given way there; untrimmed: without the trim.",
        );
        for row in &m.rows {
            self.row_section(report, row);
        }
        self.tip_section(report);
        self.joint_section(report);
    }

    fn told_machine(&self) -> String {
        let plan = &self.run.plan;
        let blocks: usize = plan.legs.iter().map(|leg| leg.blocks.len()).sum();
        let mut text = format!(
            "{}: X, Y, Z, B on each side; {} straight moves of all eight joints, both tips within {} µm",
            self.pair.name,
            number(blocks as f64, 0),
            number(self.pair.tip_tolerance * 1e3, 1)
        );
        if plan.residual > 1e-3 {
            text.push_str(&format!(
                "; it cannot turn to {}° of the normals, alike on both sides",
                number(plan.residual, 5)
            ));
        }
        if self.measured.error.abs() > 0.0 {
            text.push_str(&format!(
                "; every wall is off by {} mm, of which no pulse tells",
                self.measured.error
            ));
        }
        text
    }

    fn row_section(&self, report: &mut Report, row: &RowMeasured) {
        let name = self
            .pair
            .rows
            .get(row.row)
            .map_or("", |row| row.name.as_str());
        let (d, error) = (self.simulation.d, self.measured.error);
        let thin = (row.samples.len() / 3000).max(1);
        let samples = || row.samples.iter().step_by(thin);
        let worst = samples()
            .flat_map(|sample| sample.walls(error))
            .map(|wall| (wall - d).abs())
            .fold(1.1 * TOLERANCE, f64::max);
        let along = |value: fn(&PairSample, f64) -> f64| {
            samples().map(move |sample| (sample.x, value(sample, error)))
        };
        let chart = Chart::new(
            &format!("Wall left by the pulses, {name}"),
            "x [mm]",
            "wall [mm]",
        )
        .size(860.0, 200.0)
        .y_range(d - 1.08 * worst, d + 1.08 * worst)
        .line("untrimmed", colour(1), along(|s, e| s.walls(e)[0]))
        .line("trimmed", colour(0), along(|s, e| s.walls(e)[1]))
        .limit("wanted + tolerance", d + TOLERANCE)
        .limit("wanted \u{2212} tolerance", d - TOLERANCE);
        report.figure(&chart.svg(), "");
        let um = 1e3;
        let heard = self.run.rows.iter().find(|run| run.row == row.row);
        let readings = heard.map_or(&[][..], |run| &run.readings);
        let chart = Chart::new(&format!("Trim shown by the pulses, {name}"), "x [mm]", "µm")
            .size(860.0, 220.0)
            .line(
                "readings",
                "#c3c9d0",
                readings
                    .iter()
                    .step_by((readings.len() / 3000).max(1))
                    .map(|reading| (reading.x, reading.measured * um)),
            )
            .line(
                "deformation",
                colour(1),
                samples().map(|sample| (sample.x, sample.delta * um)),
            )
            .line(
                "trim",
                colour(0),
                samples().map(|sample| (sample.x, sample.trim * um)),
            );
        report.figure(&chart.svg(), "");
    }

    fn tip_section(&self, report: &mut Report) {
        let wall = self.run.plan.wall;
        let rows = &self.measured.rows;
        let Some(row) = rows.get(rows.len() / 2) else {
            return;
        };
        let name = self.pair.rows.get(row.row).map_or("", |row| &row.name);
        let thin = (row.samples.len() / 6000).max(1);
        let samples = || row.samples.iter().step_by(thin);
        let chart = Chart::new(&format!("Between the tips, {name}"), "x [mm]", "µm")
            .size(860.0, 200.0)
            .line(
                "thickness off",
                colour(0),
                samples().map(|sample| (sample.x, (sample.thickness - wall) * 1e3)),
            )
            .line(
                "across the normal",
                colour(1),
                samples().map(|sample| (sample.x, sample.lateral * 1e3)),
            );
        report.figure(
            &chart.svg(),
            "Noise of the sensor moves the pair, not the distance of its tips: both sides take the same trim in the same tick. \
             What is left are whole steps and the chords of the joints.",
        );
    }

    fn joint_section(&self, report: &mut Report) {
        report.section("Joints of both sides");
        let (from, to) = self.span();
        for (title, motors) in [
            ("X1 and X2, along the rows", [0, 4]),
            ("Y1 and Y2, across them", [1, 5]),
            ("Z1 and Z2", [2, 6]),
            ("B1 and B2", [3, 7]),
        ] {
            let places = self.motors.position_chart(title, &motors, from, to);
            report.figure(&places, "");
            let speeds = self.motors.speed_chart("Their speeds", &motors, from, to);
            report.figure(&speeds, "");
        }
        self.motors.limits_table(report);
        let names = motor_names(self.pair);
        let (trace, timing): (&Trace<8>, _) = (&self.run.trace, &self.job.timing);
        let row = self.run.rows.last();
        let span = row.map_or((from, to), |row| (seconds(row.start), seconds(row.end)));
        self.motors
            .pulse_section(report, trace, &names, span, timing);
    }

    /// From the first row's start to the last one's end [s].
    fn span(&self) -> (f64, f64) {
        let (first, last) = (self.run.rows.first(), self.run.rows.last());
        let from = first.map_or(0, |row| row.start);
        let to = last.map_or(from, |row| row.end);
        (seconds(from), seconds(to))
    }
}

/// What the eight motors are called.
pub fn motor_names(pair: &PairJob) -> [String; 8] {
    std::array::from_fn(|i| pair.joints[i].name.clone())
}
