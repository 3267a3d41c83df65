//! The report on lines of counts: every line beside its ideal straight line, and the pulses.

use super::motors::{Channel, Motors, end_cell, pulse_trains};
use super::{Cell, Report};
use crate::job::{CountsJob, Job, Line, MOTORS};
use crate::plot::number;
use crate::run::Outcome;
use crate::trace::{Pulse, TICK_HZ, seconds};
use hexstep::stepper::{CountLine, Preset};

/// How one motor kept to the straight line of its counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    pub count: i32,
    /// Steps found, with sign.
    pub found: i64,
    /// Least and largest of steps made less the ideal line [steps], over all ticks of the line.
    pub least: f64,
    pub most: f64,
    /// What the rule guarantees (interpolation.md section 1).
    pub bounds: (f64, f64),
    /// Least and largest gap between two steps [ticks].
    pub gaps: Option<(u64, u64)>,
}

impl Deviation {
    /// Exact in number, and within the bounds at every tick.
    pub fn is_good(&self) -> bool {
        let rounding = 1e-9;
        i64::from(self.count) == self.found
            && self.least >= self.bounds.0 - rounding
            && self.most <= self.bounds.1 + rounding
    }
}

/// One line as its pulses show it.
#[derive(Clone, Debug)]
pub struct LineFigures {
    pub line: Line,
    /// The paper's MAX: ticks of the line, and counts per tick.
    pub ticks: u64,
    pub period: u32,
    /// First and last step [s].
    pub from: f64,
    pub to: f64,
    pub motors: [Deviation; 6],
}

/// Everything that a finished job of counts says.
pub struct CountsFigures<'a> {
    job: &'a Job,
    outcome: &'a Outcome,
    pub motors: Motors,
    pub lines: Vec<LineFigures>,
    wall: f64,
}

impl<'a> CountsFigures<'a> {
    pub fn of(job: &'a Job, counts: &CountsJob, outcome: &'a Outcome, wall: f64) -> Self {
        let channels = std::array::from_fn(|motor| Channel {
            name: MOTORS[motor].into(),
            unit: "steps",
            steps_per_unit: 1.0,
            largest_rate: Some(f64::from(job.timing.fastest())),
            largest_acceleration: None,
            largest_jerk: None,
        });
        Self {
            motors: Motors::of(&outcome.trace, &channels, 0.02),
            lines: lines(job, counts, outcome),
            job,
            outcome,
            wall,
        }
    }

    /// Every motor exactly at its count, on its line, and nothing starved.
    pub fn is_sound(&self) -> bool {
        self.outcome.starved == 0
            && self.outcome.counts.map(i64::from) == self.outcome.trace.positions()
            && self
                .lines
                .iter()
                .all(|line| line.motors.iter().all(Deviation::is_good))
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self) -> Vec<String> {
        let trace = &self.outcome.trace;
        let mut text = vec![
            format!(
                "pulses   {} steps in {} ticks, {:.3} s; simulated in {:.3} s, {:.1} million ticks/s",
                number(self.motors.steps() as f64, 0),
                number(trace.ticks() as f64, 0),
                seconds(trace.end()),
                self.wall,
                trace.ticks() as f64 / self.wall / 1e6
            ),
            format!("queue    ran dry {} times", self.outcome.starved),
        ];
        for (index, line) in self.lines.iter().enumerate() {
            text.push(String::new());
            text.push(format!(
                "line {}   {:?} preset, {} ticks of {} counts, {:.6} s to {:.6} s",
                index + 1,
                line.line.preset,
                line.ticks,
                line.period,
                line.from,
                line.to
            ));
            text.push(format!(
                "{:<8}{:>12}{:>12}{:>30}{:>26}",
                "motor", "asked", "made", "off the straight line", "allowed"
            ));
            for (motor, d) in line.motors.iter().enumerate() {
                text.push(format!(
                    "{:<8}{:>12}{:>12}{:>30}{:>26}",
                    MOTORS[motor],
                    d.count,
                    d.found,
                    format!("{:.6} … {:.6}", d.least, d.most),
                    format!("{:.6} … {:.6}", d.bounds.0, d.bounds.1)
                ));
            }
        }
        text
    }

    /// The whole report.
    pub fn html(&self) -> String {
        let trace = &self.outcome.trace;
        let mut report = Report::new(
            "Lines of counts",
            &format!(
                "Job {}: step counts to pulses by the ratio-integral rule.",
                self.job.name
            ),
        );
        let exact = self.outcome.counts.map(i64::from) == trace.positions();
        report.summary(&[
            (
                "Machine time",
                format!("{} s", number(seconds(trace.end()), 3)).into(),
            ),
            ("Steps", self.motors.told_steps(trace.ticks()).into()),
            ("End", end_cell(exact)),
            (
                "Queue ran dry",
                format!("{} times", self.outcome.starved).into(),
            ),
        ]);
        report.section("Lines");
        for (index, line) in self.lines.iter().enumerate() {
            let caption = format!(
                "Line {}: {} preset, {} ticks of {} counts, first step at {} s, last at {} s",
                index + 1,
                match line.line.preset {
                    Preset::Published => "published",
                    Preset::Centred => "centred",
                },
                number(line.ticks as f64, 0),
                line.period,
                number(line.from, 6),
                number(line.to, 6)
            );
            let rows: Vec<Vec<Cell>> = line.motors.iter().enumerate().map(deviation_row).collect();
            report.table(
                &caption,
                &[
                    "motor",
                    "asked",
                    "made",
                    "off the straight line [steps]",
                    "allowed [steps]",
                    "gaps [ticks]",
                ],
                &rows,
            );
        }
        report.text(
            "Steps made less those of the straight line from standstill to standstill, least and largest over all ticks; \
             what the rule allows follows from its preset. Gaps between two steps of a motor are only ever the two \
             whole numbers beside MAX over its count.",
        );
        report.section("Motion");
        let end = seconds(trace.end());
        report.figure(
            &self
                .motors
                .position_chart("Positions", &[0, 1, 2, 3, 4, 5], 0.0, end),
            "Rebuilt from the pulses.",
        );
        report.section("Pulses");
        let names = MOTORS.map(String::from);
        for (index, line) in self.lines.iter().enumerate() {
            // About twenty steps of the leading motor, from a little before the first.
            let largest = line
                .motors
                .iter()
                .map(|d| d.count.unsigned_abs())
                .max()
                .unwrap_or(1);
            let span = u64::from(line.period) * line.ticks / u64::from(largest.max(1)) * 20;
            let from = ((line.from * TICK_HZ as f64) as u64).saturating_sub(span / 20);
            let title = format!("Line {}, the first steps", index + 1);
            report.figure(&pulse_trains(trace, &names, &title, from, from + span), "");
        }
        self.motors.counts_table(&mut report);
        let t = &self.job.timing;
        self.motors
            .timing_table(&mut report, t.least_period, t.setup, t.hold);
        report.html()
    }
}

fn deviation_row((motor, d): (usize, &Deviation)) -> Vec<Cell> {
    let pair = |a: f64, b: f64| format!("{} … {}", number(a, 6), number(b, 6));
    vec![
        MOTORS[motor].into(),
        Cell::Number(number(f64::from(d.count), 0)),
        Cell::Judged(number(d.found as f64, 0), i64::from(d.count) == d.found),
        Cell::Judged(pair(d.least, d.most), d.is_good()),
        Cell::Number(pair(d.bounds.0, d.bounds.1)),
        Cell::Number(match d.gaps {
            Some((least, most)) if least == most => number(least as f64, 0),
            Some((least, most)) => {
                format!("{}, {}", number(least as f64, 0), number(most as f64, 0))
            }
            None => "–".into(),
        }),
    ]
}

/// Takes the pulses apart into the lines that they belong to.
fn lines(job: &Job, counts: &CountsJob, outcome: &Outcome) -> Vec<LineFigures> {
    let mut pulses = outcome.trace.pulses().peekable();
    let mut from = [0i32; 6];
    let mut figures = Vec::new();
    for line in &counts.lines {
        let checked = CountLine::new(line.counts, line.duration, line.preset, &job.timing, &from);
        let checked = checked.expect("checked when the job was read");
        let steps = line
            .counts
            .iter()
            .map(|count| count.unsigned_abs() as usize)
            .sum::<usize>();
        // Every line steps each motor its count of times and in one direction: so many pulses are its own.
        let mut taken = 0;
        let mut own = Vec::new();
        while taken < steps {
            let Some(pulse) = pulses.next() else { break };
            taken += pulse.motors.count_ones() as usize;
            own.push(pulse);
        }
        figures.push(line_figures(*line, &checked, &from, &own));
        for (from, count) in from.iter_mut().zip(line.counts) {
            *from += count;
        }
    }
    figures
}

fn line_figures(
    line: Line,
    checked: &CountLine<6>,
    from: &[i32; 6],
    own: &[Pulse<6>],
) -> LineFigures {
    let max = u64::from(checked.ticks());
    let largest = line
        .counts
        .iter()
        .map(|count| count.unsigned_abs())
        .max()
        .unwrap_or(0);
    let leader = line
        .counts
        .iter()
        .position(|count| count.unsigned_abs() == largest);
    let first_of_leader =
        leader.and_then(|motor| own.iter().find(|pulse| pulse.motors >> motor & 1 == 1));
    // MAX is a power of two times the largest count, k: the leader's first step comes at tick k by the published
    // preset, and at k/2 rounded up by the centred one. Hence tick 0 of the line.
    let ticks_a_step = if largest > 0 {
        max / u64::from(largest)
    } else {
        0
    };
    let first_tick = match line.preset {
        Preset::Published => ticks_a_step.saturating_sub(1).max(1),
        Preset::Centred => (max - max / 2).div_ceil(u64::from(largest.max(1))).max(1),
    };
    let zero = first_of_leader.map_or(0, |pulse| pulse.tick.saturating_sub(first_tick));

    let motors = std::array::from_fn(|motor| {
        let count = line.counts[motor];
        let ratio = f64::from(count.unsigned_abs()) / max.max(1) as f64;
        let (mut made, mut last) = (0i64, None);
        let mut gaps: Option<(u64, u64)> = None;
        // Before the first tick and after the last both are exactly on the line.
        let (mut least, mut most) = (0.0f64, 0.0f64);
        for pulse in own.iter().filter(|pulse| pulse.motors >> motor & 1 == 1) {
            let tick = pulse.tick.saturating_sub(zero);
            least = least.min(made as f64 - (tick as f64 - 1.0).max(0.0) * ratio);
            made += 1;
            most = most.max(made as f64 - tick as f64 * ratio);
            if let Some(before) = last {
                let gap: u64 = pulse.tick - before;
                let (lo, hi) = gaps.unwrap_or((gap, gap));
                gaps = Some((gap.min(lo), gap.max(hi)));
            }
            last = Some(pulse.tick);
        }
        let found = own
            .last()
            .map_or(0, |pulse| pulse.positions[motor] - i64::from(from[motor]));
        let bounds = match line.preset {
            _ if count == 0 => (0.0, 0.0),
            Preset::Published => (ratio - 1.0, ratio),
            Preset::Centred => (-0.5, 0.5),
        };
        Deviation {
            count,
            found,
            least,
            most,
            bounds,
            gaps,
        }
    });
    LineFigures {
        line,
        ticks: max,
        period: checked.period(),
        from: own.first().map_or(0.0, |pulse| seconds(pulse.time)),
        to: own.last().map_or(0.0, |pulse| seconds(pulse.time)),
        motors,
    }
}
