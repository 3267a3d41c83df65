//! A path run with its shapers and without them -> how much stiller its flexible joint stands, and how far the shaped path
//! is off the unshaped one.

use super::contour::ContourError;
use super::{Cell, Report};
use crate::flexible::{Flexible, Swing};
use crate::job::{PathJob, SHAPERS, unit};
use crate::plot::{Chart, colour, number};
use crate::run::Outcome;
use crate::trace::{TICK_HZ, Trace};

/// What the shapers of a path do.
pub struct ShapingFigures<'a> {
    path: &'a PathJob,
    /// Distance of the shaped path from the unshaped one, both run through in order.
    pub error: ContourError,
    /// Deflection of the flexible joint, unshaped and shaped, where the job has one.
    pub swings: Option<[Swing; 2]>,
}

/// The deflection is shown so long behind the last step [s].
const REST: f64 = 0.2;

impl<'a> ShapingFigures<'a> {
    /// `None` for a path without shapers.
    pub fn of(path: &'a PathJob, outcome: &Outcome) -> Option<Self> {
        let unshaped = outcome.unshaped.as_ref()?;
        let steps = path.axes.map(|axis| axis.steps_per_unit);
        let mut points = joints(unshaped, &steps);
        points.dedup();
        let weights = path.contour.weights();
        Some(Self {
            path,
            // Both get the same commands, so both end where these do.
            error: ContourError::of(&outcome.trace, &points, &steps, &weights, false),
            swings: path.shaping.flexible.map(|joint| {
                [unshaped, &outcome.trace].map(|trace| {
                    let behind = Flexible::new(joint.hz, joint.damping);
                    Swing::of(trace, joint.motor, steps[joint.motor], behind, REST)
                })
            }),
        })
    }

    /// Residual vibration, of that of the unshaped path.
    pub fn share(&self) -> Option<f64> {
        let [unshaped, shaped] = self.swings.as_ref()?;
        Some(shaped.residual / unshaped.residual)
    }

    /// Lines of the summary.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("shaping  {}", self.told_error())];
        lines.extend(self.told_gain().map(|gain| format!("         {gain}")));
        lines
    }

    fn told_shapers(&self) -> String {
        let shaping = &self.path.shaping;
        let of = |motor: usize| {
            let told = |(hz, damping): (f64, f64)| {
                format!("{} Hz with damping {}", number(hz, 1), number(damping, 3))
            };
            let second = match shaping.second[motor] {
                (hz, _) if hz <= 0.0 => String::new(),
                second => format!(" and {}", told(second)),
            };
            let kind = SHAPERS[shaping.kinds[motor]].to_uppercase();
            let first = told(shaping.first[motor]);
            format!("{} {kind} at {first}{second}", self.path.names[motor])
        };
        let on = (0..6).filter(|motor| shaping.kinds[*motor] != 0);
        on.map(of).collect::<Vec<_>>().join("; ")
    }

    fn told_error(&self) -> String {
        format!(
            "the shaped path is off the unshaped one by at most {} µm; {}",
            number(self.error.largest * 1e3, 1),
            self.told_shapers()
        )
    }

    fn told_gain(&self) -> Option<String> {
        let joint = self.path.shaping.flexible?;
        let [unshaped, shaped] = self.swings.as_ref()?;
        Some(format!(
            "a joint of {} Hz behind {} swings by {} µm at the end, unshaped by {} µm: {} % are left; at most {} and {} µm on the way",
            number(joint.hz, 1),
            self.path.names[joint.motor],
            number(shaped.residual * 1e3, 2),
            number(unshaped.residual * 1e3, 2),
            number(100.0 * shaped.residual / unshaped.residual, 2),
            number(shaped.largest * 1e3, 1),
            number(unshaped.largest * 1e3, 1),
        ))
    }

    pub fn rows(&self) -> Vec<(&'static str, Cell)> {
        let mut rows = vec![("Shaping", self.told_error().into())];
        rows.extend(self.told_gain().map(|gain| ("Flexible joint", gain.into())));
        rows
    }

    /// The section of the report.
    pub fn section(&self, report: &mut Report) {
        report.section("Shaping");
        if let Some(chart) = self.deflection() {
            report.figure(
                &chart,
                "Deflection of a mass on a spring behind the motor, computed from the pulses of both runs in closed form; \
                 the lines go on behind the last step.",
            );
        }
        let error = self.error.samples.iter().map(|(t, e)| (*t, e * 1e3));
        let chart = Chart::new(
            "Contour error of the shaping",
            "time [s]",
            "off the unshaped path [µm]",
        )
        .size(860.0, 180.0)
        .line("shaped", colour(1), error);
        report.figure(
            &chart.svg(),
            "Distance of the shaped path from the unshaped one, both from pulses and run through in order. On a straight \
             line there is none; around corners and on curves each joint rounds its own way in time, and where it turns \
             round without a rest it does so short of the point.",
        );
    }

    /// The picture of the gain.
    pub fn deflection(&self) -> Option<String> {
        let joint = self.path.shaping.flexible?;
        let [unshaped, shaped] = self.swings.as_ref()?;
        let unit = unit(joint.motor);
        let (label, scale) = if unit == "mm" {
            ("deflection [µm]", 1e3)
        } else {
            ("deflection [deg]", 1.0)
        };
        let scaled = |swing: &Swing| -> Vec<(f64, f64)> {
            swing.samples.iter().map(|(t, e)| (*t, e * scale)).collect()
        };
        let title = format!(
            "A joint of {} Hz behind {}",
            number(joint.hz, 1),
            self.path.names[joint.motor]
        );
        let chart = Chart::new(&title, "time [s]", label)
            .size(860.0, 260.0)
            .line("unshaped", "#b9bec5", scaled(unshaped))
            .line("shaped", colour(0), scaled(shaped));
        Some(chart.svg())
    }
}

/// Joints of a trace, every half millisecond [unit].
fn joints(trace: &Trace<6>, steps: &[f64; 6]) -> Vec<[f64; 6]> {
    const MOST: u64 = 1_000_000;
    let every = (TICK_HZ / 2000).max(trace.end() / MOST);
    let rows = trace.rebuilt_every(every).into_iter();
    rows.map(|row| std::array::from_fn(|i| row[i] / steps[i]))
        .collect()
}
