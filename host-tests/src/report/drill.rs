//! The report on a drill point: motion, pulses, and the drill that they grind.

use super::motors::{Channel, Motors, end_cell, pulse_trains, told_end};
use super::{Cell, Feature, GroundDrill, Report, Stroke};
use crate::job::{DrillJob, Job, MOTORS, Phi};
use crate::plot::number;
use crate::run::Outcome;
use crate::trace::{Change, TICK_HZ, seconds};
use hexstep::cycles::drill_point::{Cycle, Variant};
use hexstep::stepper::StepMode;

/// Everything that a finished drill job says.
pub struct DrillFigures<'a> {
    pub job: &'a Job,
    pub drill: &'a DrillJob,
    pub outcome: &'a Outcome,
    pub motors: Motors,
    pub ground: GroundDrill,
    /// Time that the simulation itself took [s].
    pub wall: f64,
    warnings: Vec<String>,
    infeed: f64,
}

/// Window over which speeds and accelerations are rebuilt [s]: 20 ms hold ten steps from 500 steps/s on.
const WINDOW: f64 = 0.02;

impl<'a> DrillFigures<'a> {
    pub fn of(job: &'a Job, drill: &'a DrillJob, outcome: &'a Outcome, wall: f64) -> Self {
        let channels = Channel::of_axes(&drill.axes);
        let cycle = Cycle::new(&drill.parameters::<f64>());
        let cycle = cycle.expect("made when the job was read");
        let warning = cycle.stroke().warning();
        Self {
            motors: Motors::of(&outcome.trace, &channels, WINDOW),
            ground: GroundDrill::of(drill, &outcome.trace),
            job,
            drill,
            outcome,
            wall,
            warnings: warning.into_iter().map(|w| w.name().into()).collect(),
            infeed: cycle.plan().infeed,
        }
    }

    /// Whether every motor stands at its commanded count, nothing starved, and all motors keep their limits.
    pub fn is_sound(&self) -> bool {
        self.is_exact() && self.outcome.starved == 0 && self.motors.keep_limits()
    }

    fn is_exact(&self) -> bool {
        let commanded = self.outcome.counts.map(i64::from);
        commanded == self.outcome.trace.positions()
    }

    /// Time spent in strokes [s].
    fn grinding(&self) -> f64 {
        self.ground.strokes.iter().map(|s| s.to - s.from).sum()
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self) -> Vec<String> {
        let d = self.drill;
        let cone = self.ground.solution.cone;
        let trace = &self.outcome.trace;
        let mut lines = vec![
            format!(
                "drill    D {}  web {}  point {}°  chisel {}°  clearance {}°",
                d.diameter, d.web, d.point_angle, d.chisel_angle, d.clearance
            ),
            format!(
                "cone     phi {}°{}  theta {:.4}°  omega {:.4}°  C {:.4} {:.4} {:.4} mm",
                d.phi,
                if d.phi_chosen == Phi::Suggested {
                    " (chosen)"
                } else {
                    ""
                },
                cone.theta.to_degrees(),
                cone.omega.to_degrees(),
                cone.tip.x,
                cone.tip.y,
                cone.tip.z
            ),
            format!(
                "cycle    {} strokes on two flanks, infeed {:.4} mm; {:.1} s, of which {:.1} s grinding",
                self.ground.strokes.len(),
                self.infeed,
                seconds(trace.end()),
                self.grinding()
            ),
            self.motors.told_pulses(trace.ticks(), self.wall),
            told_end(self.is_exact(), self.outcome.starved),
            self.motors.told_limits(),
            String::new(),
            format!(
                "{:<8}{:>12}{:>12}{:>10}{:>22}{:>24}",
                "motor", "forward", "backward", "end", "speed of limit /s", "acceleration of limit"
            ),
        ];
        for f in &self.motors.figures {
            let (c, s) = (&f.channel, &f.statistics);
            let beside = |value: f64, limit: Option<f64>, digits: usize| {
                let limit = limit.unwrap_or(0.0);
                format!(
                    "{:.digits$} of {} {}",
                    value / c.steps_per_unit,
                    limit / c.steps_per_unit,
                    c.unit
                )
            };
            lines.push(format!(
                "{:<8}{:>12}{:>12}{:>10}{:>22}{:>24}",
                c.name,
                s.forward,
                s.backward,
                s.position,
                beside(f.rate, c.largest_rate, 1),
                beside(f.acceleration, c.largest_acceleration, 0)
            ));
        }
        lines.push(String::new());
        lines.push(format!(
            "{:<42}{:>12}{:>12}{:>12}",
            "ground with these pulses", "wanted", "ground", "off"
        ));
        for feature in self.ground.geometry() {
            let (digits, unit) = shown(&feature);
            let text = |x: Option<f64>| x.map_or("–".into(), |x| number(x, digits));
            lines.push(format!(
                "{:<42}{:>12}{:>12}{:>12}{unit}",
                feature.name,
                number(feature.wanted, digits),
                text(feature.found),
                text(feature.error())
            ));
        }
        for warning in &self.warnings {
            lines.push(format!("warning  {warning}: {}", told(warning)));
        }
        lines
    }

    /// The whole report.
    pub fn html(&self) -> String {
        let d = self.drill;
        let mut report = Report::new(
            &format!("Drill point {} mm, {}°", d.diameter, d.point_angle),
            &format!(
                "Job {}: from the drill's geometry to six pulse trains, and back from the pulses to the drill they grind.",
                self.job.name
            ),
        );
        self.overview(&mut report);
        self.drill_section(&mut report);
        self.motion_section(&mut report);
        self.pulse_section(&mut report);
        self.passes_section(&mut report);
        report.html()
    }

    fn overview(&self, report: &mut Report) {
        let trace = &self.outcome.trace;
        let (tip, turn) = self.ground.path_error();
        let cone = self.ground.solution.cone;
        let timing = &self.job.timing;
        let mut rows: Vec<(&str, Cell)> = vec![
            (
                "Cone",
                format!(
                    "φ {}°, θ {}°, ω {}°, tip from apex {} {} {} mm",
                    self.drill.phi,
                    number(cone.theta.to_degrees(), 4),
                    number(cone.omega.to_degrees(), 4),
                    number(cone.tip.x, 4),
                    number(cone.tip.y, 4),
                    number(cone.tip.z, 4)
                )
                .into(),
            ),
            (
                "Cycle",
                format!(
                    "{} strokes on two flanks, stock {} mm, infeed {} mm",
                    self.ground.strokes.len(),
                    self.drill.stock,
                    number(self.infeed, 4)
                )
                .into(),
            ),
            (
                "Machine time",
                format!(
                    "{} s, of which {} s grinding",
                    number(seconds(trace.end()), 1),
                    number(self.grinding(), 1)
                )
                .into(),
            ),
            (
                "Steps",
                format!(
                    "{} in {} ticks, {}",
                    number(self.motors.steps() as f64, 0),
                    number(trace.ticks() as f64, 0),
                    match timing.mode {
                        StepMode::Pulse => "one pulse for each step",
                        StepMode::BothEdge => "one edge for each step",
                    }
                )
                .into(),
            ),
            (
                "End",
                end_cell(self.is_exact()),
            ),
            (
                "Queue ran dry",
                Cell::Text(format!("{} times", self.outcome.starved)),
            ),
            (
                "Path",
                format!(
                    "tip within {} µm and orientation within {}° of the exact motion, motors on whole steps",
                    number(tip * 1e3, 2),
                    number(turn.to_degrees(), 5)
                )
                .into(),
            ),
        ];
        if self.drill.variant == Variant::Published {
            let note = "as published: the paper's own formulas, which are no rigid rotation";
            rows.push(("Motion", note.into()));
        }
        for warning in &self.warnings {
            rows.push(("Warning", format!("{warning}: {}", told(warning)).into()));
        }
        report.summary(&rows);
    }

    fn drill_section(&self, report: &mut Report) {
        report.section("The ground drill");
        report.figures(&[
            (
                self.ground.plan(430.0),
                "Lips blue, chisel edge red, thin lines of equal height 0.25 mm apart; the heel is drawn 60° behind the corner.",
            ),
            (
                self.ground.side(430.0),
                "Lips blue, chisel edge red; the thin curves are the flanks on the circumference, from the corner to the heel.",
            ),
        ]);
        let rows: Vec<Vec<Cell>> = self
            .ground
            .geometry()
            .iter()
            .map(|feature| {
                let (digits, unit) = shown(feature);
                let text = |x: Option<f64>| x.map_or("–".into(), |x| number(x, digits));
                vec![
                    feature.name.into(),
                    Cell::Number(format!("{}{unit}", number(feature.wanted, digits))),
                    Cell::Number(format!("{}{unit}", text(feature.found))),
                    Cell::Judged(
                        format!("{}{unit}", text(feature.error())),
                        feature.is_good(),
                    ),
                ]
            })
            .collect();
        report.table(
            "Simulated grinding with the joints that the pulses make",
            &["", "wanted", "ground", "off"],
            &rows,
        );
        report.text(
            "The wheel is a plane, fixed in the machine; each joint vector along the pulses is one cut, and the drill is what \
             all cuts leave. Angles are measured over a millimetre of flank, as an instrument does: the way from one \
             waypoint to the next is straight in the joints, which leaves facets of about a micrometre.",
        );
        report.figure(
            &self.ground.rim_chart(),
            "The clearance at the corner is the slope at the left end of this line.",
        );
        report.figure(
            &self.ground.error_chart(),
            "Positive is ground too deep. The waves come from the chords between waypoints.",
        );
    }

    fn motion_section(&self, report: &mut Report) {
        let end = seconds(self.outcome.trace.end());
        report.section("Motion");
        report.figure(
            &self
                .motors
                .position_chart("Slides, whole cycle", &[0, 1, 2], 0.0, end),
            "Positions rebuilt from the pulses.",
        );
        report.figure(
            &self
                .motors
                .position_chart("Wrist, whole cycle", &[3, 4, 5], 0.0, end),
            "theta3 turns by 180° from one flank to the other.",
        );
        if let Some((from, to)) = self.one_pass() {
            let caption = "The last pass but the spark-out strokes: approach, infeed, stroke, retraction, way back and indexing, on both flanks.";
            report.figure(
                &self
                    .motors
                    .position_chart("Slides, one pass", &[0, 1, 2], from, to),
                caption,
            );
            report.figure(
                &self
                    .motors
                    .position_chart("Wrist, one pass", &[3, 4, 5], from, to),
                "The same pass.",
            );
        }
        let (from, to) = self.one_pass().unwrap_or((0.0, end));
        for motor in 0..6 {
            report.figure(
                &self.motors.rate_chart(motor, from, to),
                if motor == 5 {
                    "Step rates over the same pass, rebuilt over windows of 20 ms, with the limits of the job."
                } else {
                    ""
                },
            );
        }
        report.figure(
            &self.motors.acceleration_chart(
                "Accelerations, one pass",
                &[0, 1, 2, 3, 4, 5],
                from,
                to,
            ),
            "As shares of each motor's limit, over windows of 20 ms.",
        );
        self.motors.limits_table(report);
    }

    fn pulse_section(&self, report: &mut Report) {
        report.section("Pulses");
        let trace = &self.outcome.trace;
        let names = MOTORS.map(String::from);
        let middle = self.ground.strokes.last();
        if let Some(stroke) = middle {
            let from = ((stroke.from + stroke.to) / 2.0 * TICK_HZ as f64) as u64;
            report.figure(
                &pulse_trains(trace, &names, "In a grinding stroke", from, from + TICK_HZ / 1000),
                "One millisecond in the middle of the last stroke. All pins of a tick change together.",
            );
        }
        if let Some(time) = self.first_reversal() {
            // From standstill to standstill: the first steps come a millisecond or more later.
            let span = TICK_HZ / 150;
            let from = time.saturating_sub(span / 3);
            report.figure(
                &pulse_trains(trace, &names, "At a change of direction", from, from + span),
                "The direction changes well before the first step the other way.",
            );
        }
        self.motors.counts_table(report);
        let t = &self.job.timing;
        self.motors
            .timing_table(report, t.least_period, t.setup, t.hold);
    }

    fn passes_section(&self, report: &mut Report) {
        report.section("Strokes");
        let rows: Vec<Vec<Cell>> = self
            .ground
            .strokes
            .iter()
            .enumerate()
            .map(stroke_row)
            .collect();
        report.table(
            "Every stroke as the pulses show it",
            &[
                "stroke",
                "flank",
                "from [s]",
                "to [s]",
                "µ [deg]",
                "stand-off [mm]",
                "mean stand-off [mm]",
                "tip error [µm]",
                "turn [0.001°]",
            ],
            &rows,
        );
    }

    /// From the approach to the end of the way back, both flanks, of a pass in the finishing passes [s].
    fn one_pass(&self) -> Option<(f64, f64)> {
        let strokes = &self.ground.strokes;
        let at = strokes
            .iter()
            .rposition(|stroke| stroke.flank == 1 && stroke.standoff > 1e-9)
            .unwrap_or(0);
        let first = strokes.get(at)?;
        // The next stroke on flank 1 begins where this pass has ended.
        let until = strokes
            .get(at + 2)
            .map_or(seconds(self.outcome.trace.end()), |s| s.from - 0.1);
        let before = if at == 0 { 0.0 } else { strokes[at - 1].to };
        Some(((first.from - 2.5).max(before), until))
    }

    /// Between the first stroke and the second: the change of directions that turns most motors [counts].
    fn first_reversal(&self) -> Option<u64> {
        let [first, second] = self.ground.strokes.get(..2)? else {
            return None;
        };
        let counts = |s: f64| (s * TICK_HZ as f64) as u64;
        let (state, events) = self.outcome.trace.events_from(counts(first.to));
        let mut mask = state.directions;
        let mut best = (0, None);
        for event in events.take_while(|event| event.time < counts(second.from)) {
            if let Change::Directions(new) = event.change {
                let turned = (new ^ mask).count_ones();
                if turned > best.0 {
                    best = (turned, Some(event.time));
                }
                mask = new;
            }
        }
        best.1
    }
}

fn stroke_row((index, s): (usize, &Stroke)) -> Vec<Cell> {
    let cell = |x: f64, digits: usize| Cell::Number(number(x, digits));
    vec![
        cell(index as f64 + 1.0, 0),
        cell(f64::from(s.flank), 0),
        cell(s.from, 2),
        cell(s.to, 2),
        Cell::Number(format!(
            "{} … {}",
            number(s.mu.0.to_degrees(), 2),
            number(s.mu.1.to_degrees(), 2)
        )),
        cell(s.standoff, 4),
        cell(s.standoff_found, 4),
        cell(s.tip_error * 1e3, 2),
        cell(s.turn_error.to_degrees() * 1e3, 2),
    ]
}

/// Digits and unit in which a feature is shown.
fn shown(feature: &Feature) -> (usize, &'static str) {
    if feature.unit == "deg" {
        (3, "°")
    } else {
        (4, " mm")
    }
}

fn told(warning: &str) -> &'static str {
    match warning {
        "HeelNotReached" => "the cone does not reach the heel, which is left as its tangent plane",
        "HeelBeyond90" => "the heel would be ground beyond 90° and is left as its tangent plane",
        _ => "",
    }
}
