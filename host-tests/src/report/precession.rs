//! The report on a continuous precession: the curves of the paper's fifth figure, the axis, and the pulses.

use super::poses::PosesFigures;
use super::space::Space;
use super::{Cell, Report};
use crate::job::{Job, PrecessionJob};
use crate::plot::{Chart, Drawing, Pen, colour, number};
use crate::process::PrecessionMade;
use crate::run::Outcome;
use hexstep::cycles::precession::{Drive, Surface, contact_radius, rubbing_speed};

/// Everything that a finished precession says.
pub struct PrecessionFigures<'a> {
    pub job: &'a Job,
    pub precession: &'a PrecessionJob,
    pub made: &'a PrecessionMade,
    pub poses: PosesFigures<'a>,
}

impl<'a> PrecessionFigures<'a> {
    pub fn of(
        job: &'a Job,
        precession: &'a PrecessionJob,
        made: &'a PrecessionMade,
        outcome: &'a Outcome,
        wall: f64,
    ) -> Self {
        Self {
            job,
            precession,
            made,
            poses: PosesFigures::of(job, &made.poses, outcome, wall),
        }
    }

    /// Whether the pulses are right and every axis keeps its tilt.
    pub fn is_sound(&self) -> bool {
        self.poses.is_sound() && self.keeps_tilt()
    }

    /// Tilt between axis and normal, to rounding.
    pub fn keeps_tilt(&self) -> bool {
        self.made.tilt_error(self.precession.parameters.theta) < 1e-9
    }

    fn told_process(&self) -> String {
        let p = &self.precession.parameters;
        let phase = match p.drive {
            Drive::Time { rate } => {
                format!(
                    "{} turns a minute",
                    number(rate * 60.0 / std::f64::consts::TAU, 3)
                )
            }
            Drive::Distance { pitch } => format!("a turn every {} mm", number(pitch, 3)),
        };
        format!(
            "bonnet of {} mm, {} mm inward, tilted by {}°, {} mm/s, {phase}",
            number(p.bonnet_radius, 1),
            number(p.inward, 2),
            number(p.theta.to_degrees(), 2),
            number(p.feed, 2)
        )
    }

    fn told_poses(&self) -> String {
        let last = self.made.stances.last();
        let flags: Vec<_> = self.made.flags.names().collect();
        format!(
            "{} poses on {} points, {} s; the axis turns by at most {}° from pose to pose{}{}",
            number(self.made.stances.len() as f64, 0),
            self.precession.contacts.len(),
            number(last.map_or(0.0, |s| s.time), 3),
            number(self.made.largest_turn(), 3),
            if flags.is_empty() { "" } else { "; " },
            flags.join(", ")
        )
    }

    fn told_far(&self) -> String {
        let p = &self.precession.parameters;
        let speed = match p.drive {
            Drive::Time { rate } => rate.abs(),
            Drive::Distance { pitch } => std::f64::consts::TAU * p.feed / pitch.abs(),
        } * p.ell
            * p.theta.sin();
        format!(
            "{} mm long; it goes round at {} mm/s, {} the feed: {} loops",
            number(self.made.far_length(), 3),
            number(speed, 3),
            if speed > p.feed {
                "faster than"
            } else {
                "not faster than"
            },
            if speed > p.feed { "with" } else { "without" }
        )
    }

    fn told_tilt(&self) -> Cell {
        let off = self.made.tilt_error(self.precession.parameters.theta);
        let text = format!("off by at most {off:.1e}° from the one asked for");
        if self.keeps_tilt() {
            text.into()
        } else {
            Cell::Judged(text, false)
        }
    }

    fn told_spot(&self) -> String {
        let p = &self.precession.parameters;
        let rho = p.bonnet_radius - p.inward;
        let circle = contact_radius(p.bonnet_radius, p.inward, Surface::Plane);
        format!(
            "circle of {} mm on a plane; the bonnet rubs at {} mm/s in its middle",
            circle.map_or("–".into(), |r| number(r, 4)),
            number(rubbing_speed(self.precession.spindle, rho, p.theta), 1)
        )
    }

    /// Lines of the one-screen summary.
    pub fn summary(&self) -> Vec<String> {
        let mut lines = vec![
            format!("process  {}", self.told_process()),
            format!("poses    {}", self.told_poses()),
            format!("far      {}", self.told_far()),
        ];
        lines.extend(self.poses.summary());
        lines
    }

    /// The whole report.
    pub fn html(&self) -> String {
        let mut report = Report::new(
            &format!("Precession {}", self.job.name),
            "A bonnet along a surface while its axis turns about the normal: the space that it sweeps, the joints, and the pulses.",
        );
        report.summary(&[
            ("Process", self.told_process().into()),
            ("Poses", self.told_poses().into()),
            ("Far point", self.told_far().into()),
            ("Spot", self.told_spot().into()),
            ("Tilt", self.told_tilt()),
        ]);
        self.swept_section(&mut report);
        self.axis_section(&mut report);
        report.section("Pulses of the machine");
        self.poses.overview(&mut report);
        self.poses.error_section(&mut report);
        self.poses.joint_section(&mut report);
        self.poses.pose_section(&mut report);
        self.poses.pulse_section(&mut report);
        report.html()
    }

    fn swept_section(&self, report: &mut Report) {
        report.section("The space swept");
        let stances = &self.made.stances;
        let all = || {
            let ends = |s: &hexstep::cycles::precession::Stance<f64>| {
                [s.centre.to_array(), s.far.to_array()]
            };
            let contacts = self.precession.contacts.iter().map(|c| c.p.to_array());
            stances.iter().flat_map(ends).chain(contacts)
        };
        let far = Pen {
            colour: colour(1),
            width: 1.8,
            ..Pen::EDGE
        };
        let centre = Pen {
            colour: colour(0),
            width: 2.2,
            ..Pen::EDGE
        };
        let strip = Pen {
            colour: "#b9c0c8",
            width: 0.7,
            ..Pen::EDGE
        };
        let path = Pen {
            dash: "5 3",
            width: 1.2,
            ..Pen::EDGE
        };
        let every = (stances.len() / 110).max(1);
        let mut space = Space::of(all());
        for s in stances.iter().step_by(every) {
            space.path([s.centre.to_array(), s.far.to_array()], strip);
        }
        space.path(
            self.precession.contacts.iter().map(|c| c.p.to_array()),
            path,
        );
        space.path(stances.iter().map(|s| s.centre.to_array()), centre);
        space.path(stances.iter().map(|s| s.far.to_array()), far);
        // Of the paper's figure 5: (a) and (b) are of a plane, (c) and (d) of a curved surface.
        let mut turns = self.precession.contacts.windows(2);
        let is_plane = turns.all(|pair| pair[0].n.angle_to(pair[1].n) < 1e-9);
        let (above, aslant) = if is_plane { ("a", "b") } else { ("c", "d") };
        if let (Some(first), Some(last)) = (stances.first(), stances.last()) {
            space.name(first.centre.to_array(), first.far.to_array(), "A");
            space.name(first.far.to_array(), first.centre.to_array(), "C");
            let strip = (last.centre + last.far) * 0.5;
            let before = strip - (last.centre - first.centre) * 0.35;
            space.name(before.to_array(), strip.to_array(), "B");
        }
        report.figure(
            &space.svg("Swept space, isometric"),
            &format!(
                "Blue, C: the centre of the ball. Orange, A: the far point on its axis. Grey, B: the axis from one to the other, \
                 pose by pose. Dashed: the path on the surface. The paper's figure 5 ({aslant})."
            ),
        );

        let flat = |v: [f64; 3]| (v[0], v[1]);
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for v in all() {
            for i in 0..2 {
                lo[i] = lo[i].min(v[i]);
                hi[i] = hi[i].max(v[i]);
            }
        }
        let (wide, high) = (hi[0] - lo[0], (hi[1] - lo[1]).max(1e-9));
        let width = (460.0 * wide / high).clamp(320.0, 860.0);
        let mut drawing = Drawing::new("Swept space from above: x across, y up", width);
        for s in stances.iter().step_by(every) {
            let ends = [flat(s.centre.to_array()), flat(s.far.to_array())];
            drawing = drawing.line(ends, strip);
        }
        let low = lo[1] - 0.09 * high.max(0.3 * wide);
        drawing = drawing
            .line(stances.iter().map(|s| flat(s.centre.to_array())), centre)
            .line(stances.iter().map(|s| flat(s.far.to_array())), far)
            .dimension(
                (lo[0], low),
                (hi[0], low),
                &format!("{} mm", number(wide, 2)),
            );
        report.figure(
            &drawing.svg(),
            &format!(
                "The projection on the xy-plane, the paper's figure 5 ({above}); colours as above.{}",
                if is_plane {
                    " On a plane the far point draws a trochoid; it has loops where it goes round faster than the feed."
                } else {
                    ""
                }
            ),
        );
        let corner = |pick: fn(f64, f64) -> f64, start: f64| {
            let mut corner = [start; 3];
            for s in stances {
                for (c, x) in corner.iter_mut().zip(s.far.to_array()) {
                    *c = pick(*c, x);
                }
            }
            corner
        };
        let (least, most) = (
            corner(f64::min, f64::INFINITY),
            corner(f64::max, f64::NEG_INFINITY),
        );
        let rows: Vec<Vec<Cell>> = ["x", "y", "z"]
            .iter()
            .zip(least.iter().zip(most))
            .map(|(name, (least, most))| {
                vec![
                    (*name).into(),
                    Cell::Number(number(*least, 6)),
                    Cell::Number(number(most, 6)),
                ]
            })
            .collect();
        report.table(
            "Box of the far points [mm]",
            &["axis", "least", "largest"],
            &rows,
        );
    }

    fn axis_section(&self, report: &mut Report) {
        report.section("The axis");
        let stances = &self.made.stances;
        let phase = stances
            .iter()
            .map(|s| (s.time, s.phase.to_degrees::<f64>()));
        // A jump from 360 to 0 is no motion.
        let mut drawn: Vec<(f64, f64)> = Vec::new();
        for (time, phase) in phase {
            if drawn
                .last()
                .is_some_and(|last| (last.1 - phase).abs() > 180.0)
            {
                drawn.push((time, f64::NAN));
            }
            drawn.push((time, phase));
        }
        let chart = Chart::new("Phase of the precession", "time [s]", "deg")
            .size(860.0, 180.0)
            .y_range(0.0, 360.0)
            .line("phase", colour(2), drawn);
        report.figure(&chart.svg(), "");
        let mut chart = Chart::new("The axis P in the work frame", "time [s]", "")
            .size(860.0, 220.0)
            .y_range(-1.0, 1.05);
        for (index, name) in ["x", "y", "z"].into_iter().enumerate() {
            let of = |s: &hexstep::cycles::precession::Stance<f64>| s.axis.to_array()[index];
            chart = chart.line(name, colour(index), stances.iter().map(|s| (s.time, of(s))));
        }
        report.figure(
            &chart.svg(),
            "Components of the unit vector from the surface to the spindle.",
        );
    }
}
