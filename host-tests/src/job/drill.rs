//! Jobs of kind `drill-point`: the drill, the arm, the cycle, and what its six motors can do.

use super::axes::{AXES, AxisLimits, read_axes};
use super::reader::{Kind, Table};
use super::{JobError, Places};
use hexstep::cycles::drill_point::{
    Cycle, Drill, DrillPointError, Field, Flank, MAX_STROKES, Parameters, Passes, Solution, Variant,
};
use hexstep::geometry::Vector;
use hexstep::machines::DrillGrinder;
use hexstep::math::Real;
use hexstep::stepper::Timing;

/// How phi was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phi {
    Given,
    /// By the heel clearance it gives: `phi = "auto"`.
    Suggested,
}

/// A drill point to be ground. Lengths in mm, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct DrillJob {
    pub diameter: f64,
    pub web: f64,
    pub point_angle: f64,
    pub chisel_angle: f64,
    pub clearance: f64,
    pub phi: f64,
    pub phi_chosen: Phi,
    pub l1: f64,
    pub l2: f64,
    pub stock: f64,
    pub rough_depth: f64,
    pub finish_depth: f64,
    pub finish_passes: u32,
    pub spark_out: u32,
    pub clear: f64,
    pub over: f64,
    pub heel_angle: f64,
    pub mu_step: f64,
    pub stroke_speed: f64,
    pub infeed_speed: f64,
    pub variant: Variant,
    pub axes: [AxisLimits; 6],
}

const DRILL: &[&str] = &[
    "diameter",
    "web",
    "point_angle",
    "chisel_angle",
    "clearance",
    "phi",
];
const STRUCTURE: &[&str] = &["l1", "l2"];
const CYCLE: &[&str] = &[
    "stock",
    "rough_depth",
    "finish_depth",
    "finish_passes",
    "spark_out",
    "clear",
    "over",
    "heel_angle",
    "mu_step",
    "stroke_speed",
    "infeed_speed",
    "variant",
];

/// Longest arm and largest drill that are taken for meant [mm].
const LONGEST: f64 = 10_000.0;

impl DrillJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let [drill, structure, cycle, machine] = [
            root.table("drill")?,
            root.table("structure")?,
            root.table("cycle")?,
            root.table("machine")?,
        ];
        drill.known(DRILL)?;
        structure.known(STRUCTURE)?;
        cycle.known(CYCLE)?;
        machine.known(AXES)?;

        // Ranges that the cycle itself checks, with better words, are left to it.
        let any = Kind::ANY;
        let arm = Kind::between(0.0, LONGEST, "mm");
        let strokes = i64::from(MAX_STROKES);
        let auto = drill.is_word("phi");
        if auto {
            drill.word("phi", &["auto"])?;
        }
        let mut job = Self {
            diameter: drill.number("diameter", any)?,
            web: drill.number("web", any)?,
            point_angle: drill.number("point_angle", any)?,
            chisel_angle: drill.number("chisel_angle", any)?,
            clearance: drill.number("clearance", any)?,
            phi: if auto { 0.0 } else { drill.number("phi", any)? },
            phi_chosen: if auto { Phi::Suggested } else { Phi::Given },
            l1: structure.number("l1", arm)?,
            l2: structure.number("l2", arm)?,
            stock: cycle.number("stock", any)?,
            rough_depth: cycle.number_or("rough_depth", 0.03, any)?,
            finish_depth: cycle.number_or("finish_depth", 0.01, any)?,
            finish_passes: cycle.whole_or("finish_passes", 3, 0, strokes)? as u32,
            spark_out: cycle.whole_or("spark_out", 2, 0, strokes)? as u32,
            clear: cycle.number_or("clear", 3.0, any)?,
            over: cycle.number_or("over", 2.0, any)?,
            heel_angle: cycle.number_or("heel_angle", 60.0, any)?,
            mu_step: cycle.number_or("mu_step", 0.8, any)?,
            stroke_speed: cycle.number_or("stroke_speed", 20.0, Kind::positive(3600.0, "deg/s"))?,
            infeed_speed: cycle.number_or("infeed_speed", 2.0, Kind::positive(1000.0, "mm/s"))?,
            variant: if cycle.has("variant") && cycle.word("variant", &["exact", "published"])? == 1
            {
                Variant::Published
            } else {
                Variant::Exact
            },
            axes: read_axes(&machine, timing, places)?,
        };

        if auto {
            let angles = (job.heel_angle.to_radians(), 25f64.to_radians());
            let suggested = job.drill::<f64>().suggest_phi(angles.0, angles.1);
            let suggested = suggested.map_err(|error| job.refuse(places, &error))?;
            job.phi = f64::from(suggested.degrees);
        }
        let parameters = job.parameters::<f64>();
        Cycle::new(&parameters).map_err(|error| job.refuse(places, &error))?;
        // The target computes in f32, which near a limit may find what f64 does not.
        Cycle::new(&job.parameters::<f32>()).map_err(|error| job.refuse(places, &error))?;
        Ok(job)
    }

    /// The drill, in radians.
    pub fn drill<R: Real>(&self) -> Drill<R> {
        Drill {
            diameter: R::of(self.diameter),
            web: R::of(self.web),
            point_angle: R::of(self.point_angle).to_radians(),
            chisel_angle: R::of(self.chisel_angle).to_radians(),
            clearance: R::of(self.clearance).to_radians(),
        }
    }

    /// The arm that grinds it.
    pub fn arm<R: Real>(&self) -> DrillGrinder<R> {
        let drill = self.drill::<R>();
        let arm = DrillGrinder::new(drill.point_angle, R::of(self.l1), R::of(self.l2));
        arm.expect("the point angle and the structure were checked when the job was read")
    }

    /// The cycle's parameters; the finished tip stands at the arm's home.
    pub fn parameters<R: Real>(&self) -> Parameters<R> {
        let degrees = |x: f64| R::of(x).to_radians();
        let touch = Vector::new(-R::of(self.l1), -R::of(self.l2), R::ZERO);
        Parameters {
            passes: Passes {
                stock: R::of(self.stock),
                rough_depth: R::of(self.rough_depth),
                finish_depth: R::of(self.finish_depth),
                finish_passes: self.finish_passes,
                spark_out: self.spark_out,
            },
            clear: R::of(self.clear),
            over: degrees(self.over),
            heel_angle: degrees(self.heel_angle),
            mu_step: degrees(self.mu_step),
            stroke_speed: degrees(self.stroke_speed),
            infeed_speed: R::of(self.infeed_speed),
            variant: self.variant,
            ..Parameters::new(self.drill(), degrees(self.phi), touch, R::of(self.stock))
        }
    }

    /// The wanted geometry in f64: cone and flank.
    pub fn wanted(&self) -> (Solution<f64>, Flank<f64>) {
        let drill = self.drill::<f64>();
        let solution = drill.solve(self.phi.to_radians());
        let solution = solution.expect("solved when the job was read");
        let flank = Flank::of(drill.diameter, drill.web, &solution.cone);
        (solution, flank.expect("made when the job was read"))
    }

    /// An error of the cycle, at the key that is to be changed.
    fn refuse<R: Real>(&self, places: &Places, error: &DrillPointError<R>) -> JobError {
        let field = error.field().unwrap_or(match error {
            DrillPointError::NoChisel => Field::ChiselAngle,
            DrillPointError::NoTip => Field::Clearance,
            DrillPointError::NoLip => Field::Web,
            _ => Field::Phi,
        });
        let name = field.name();
        let table = if DRILL.contains(&name) {
            "drill"
        } else {
            "cycle"
        };
        let degrees = |x: &R| x.to_f64().to_degrees();
        let figure = match error {
            DrillPointError::ClearanceTooSmall { least } => {
                format!(
                    " (at least {:.6} deg; found {})",
                    degrees(least),
                    self.clearance
                )
            }
            DrillPointError::PhiTooSmall { phi_min } => {
                format!(
                    " (at least {:.6} deg; found {})",
                    degrees(phi_min),
                    self.phi
                )
            }
            _ => match self.value(field) {
                Some(value) => format!(" (found {value})"),
                None => String::new(),
            },
        };
        places.refuse(
            &format!("{table}.{name}"),
            error.name(),
            format!("{}{figure}", error.remedy()),
        )
    }

    /// The number given for a field.
    fn value(&self, field: Field) -> Option<f64> {
        Some(match field {
            Field::Diameter => self.diameter,
            Field::Web => self.web,
            Field::PointAngle => self.point_angle,
            Field::ChiselAngle => self.chisel_angle,
            Field::Clearance => self.clearance,
            Field::Phi if self.phi_chosen == Phi::Given => self.phi,
            Field::Stock => self.stock,
            Field::RoughDepth => self.rough_depth,
            Field::FinishDepth => self.finish_depth,
            Field::Clear => self.clear,
            Field::Over => self.over,
            Field::HeelAngle => self.heel_angle,
            Field::MuStep => self.mu_step,
            _ => return None,
        })
    }
}
