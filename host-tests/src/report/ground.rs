//! The joints that the pulses make -> the drill they grind: strokes, path error, simulated grinding, measured geometry.

use crate::job::DrillJob;
use crate::reference::grinding::{Arm, Measured, Simulation, Wheel};
use crate::trace::{TICK_HZ, Trace, seconds};
use hexstep::cycles::drill_point::{Cycle, Flank, Solution};
use hexstep::geometry::Vector;

/// Time between two joint vectors at which the wheel is let cut [counts]: 4 ms, 0.08 deg at 20 deg/s. Facets of 0.1 deg
/// are 0.0015 um high (drill-grinding.md section 4).
const STEP: u64 = TICK_HZ / 250;

/// Half the side of the square over which slopes are measured, as a share of the drill's radius: about a millimetre
/// of flank for a 10 mm drill, as an instrument takes it.
pub const MEASURED_OVER: f64 = 0.1;

/// Plan angle of the heel behind the corner at which its clearance is measured [rad].
pub const HEEL: f64 = std::f64::consts::FRAC_PI_3;

/// One grinding stroke as the pulses show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// First and last time [s].
    pub from: f64,
    pub to: f64,
    /// 1 or 2.
    pub flank: u8,
    /// Stand-off as planned, and on average over the stroke [mm].
    pub standoff: f64,
    pub standoff_found: f64,
    /// Where mu began and ended [rad].
    pub mu: (f64, f64),
    /// Largest distance of the tip from the exact motion [mm], and largest turn away from it [rad].
    pub tip_error: f64,
    pub turn_error: f64,
}

/// One figure of the ground point, wanted and found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    pub name: &'static str,
    /// `"deg"` or `"mm"`.
    pub unit: &'static str,
    pub wanted: f64,
    /// `None` where the ground drill does not have it.
    pub found: Option<f64>,
}

impl Feature {
    /// Found less wanted.
    pub fn error(&self) -> Option<f64> {
        self.found.map(|found| found - self.wanted)
    }

    /// Whether it is right within a tenth of a degree or 5 um: the tolerances of good drills are ten times as wide.
    pub fn is_good(&self) -> bool {
        let tolerance = if self.unit == "deg" { 0.1 } else { 0.005 };
        self.error().is_some_and(|error| error.abs() <= tolerance)
    }
}

/// What the pulses have ground.
pub struct GroundDrill {
    pub strokes: Vec<Stroke>,
    pub solution: Solution<f64>,
    pub wanted: Flank<f64>,
    pub simulation: Simulation,
    pub measured: Measured,
    /// 2 Y, from the tip's place where mu passes through 0 in the last stroke on flank 1 [mm].
    pub web: Option<f64>,
}

/// A joint vector seen as a place in the cycle.
struct Seen {
    time: f64,
    mu: f64,
    flank: u8,
    /// Stand-off, and the distance from the motion beside it [mm].
    standoff: f64,
    beside: f64,
    /// Turn away from the motion [rad].
    turn: f64,
    tip: [f64; 3],
}

impl GroundDrill {
    /// Rebuilds the joints from the pulses and grinds with them.
    pub fn of(drill: &DrillJob, trace: &Trace<6>) -> Self {
        let (solution, wanted) = drill.wanted();
        let arm = Arm {
            point_angle: drill.point_angle.to_radians(),
            l1: drill.l1,
            l2: drill.l2,
        };
        let from_apex = [solution.x, drill.web / 2.0, solution.cone.tip.z];
        let wheel = Wheel::set_up(&arm, solution.m, from_apex);
        let mut simulation = Simulation::new(arm, wheel, drill.diameter, drill.web);

        let cycle = Cycle::new(&drill.parameters::<f64>());
        let cycle = cycle.expect("made when the job was read");
        let mut watch = Watch {
            drill,
            cycle: &cycle,
            before: None,
            open: None,
            strokes: Vec::new(),
            crossing: None,
        };
        // The path is judged on whole steps, where a motor may stand; the wheel cuts on the line that the steps draw,
        // as a motor turns on between them.
        let lines = trace.rebuilt_every(STEP);
        for ((time, positions), line) in trace.positions_every(STEP).zip(&lines) {
            let on_steps = joints(drill, &positions.map(|steps| steps as f64));
            watch.look(see(drill, &cycle, &arm, seconds(time), &on_steps));
            // Until the first stroke the drill comes from home, where the finished point would touch.
            if !watch.strokes.is_empty() || watch.open.is_some() {
                simulation.cut(&joints(drill, line));
            }
        }
        watch.close();
        let measured = simulation.measure();
        Self {
            web: watch.crossing.map(|z| 2.0 * (wheel.point[2] - z)),
            strokes: watch.strokes,
            solution,
            wanted,
            simulation,
            measured,
        }
    }

    /// Every figure of the point as (name, wanted, found, unit): what the drill was asked to be, and what it is.
    pub fn geometry(&self) -> Vec<Feature> {
        let (r0, r) = self.simulation.dimensions();
        let corner = (r * r - r0 * r0).sqrt();
        let lip =
            |(zx, zy): (f64, f64)| (2.0 * 1f64.atan2(zx), ((zx * r0 + zy * corner) / r).atan());
        let chisel = |(zx, zy): (f64, f64)| zx.atan2(zy);
        let heel = |(zx, zy): (f64, f64), at: (f64, f64)| ((zy * at.0 - zx * at.1) / r).atan();

        let mut features = Vec::new();
        let mut angle = |name, wanted: f64, found: Option<f64>| {
            features.push(Feature {
                name,
                unit: "deg",
                wanted: wanted.to_degrees(),
                found: found.map(f64::to_degrees),
            });
        };
        let at = (corner, -r0);
        if let Some(wanted) = self.wanted_slopes(at) {
            // Behind the lip and inside the circumference.
            let found = self.slopes(at, (-1.0, 1.0)).map(lip);
            angle("point angle", lip(wanted).0, found.map(|f| f.0));
            angle(
                "lip clearance at the corner",
                lip(wanted).1,
                found.map(|f| f.1),
            );
        }
        if let Some(wanted) = self.wanted_slopes((0.0, 0.0)) {
            let found = self.slopes((0.0, 0.0), (0.0, 0.0));
            angle("chisel edge angle", chisel(wanted), found.map(chisel));
        }
        let azimuth = HEEL - (r0 / r).asin();
        let (sin, cos) = azimuth.sin_cos();
        let at = (r * cos, r * sin);
        if let Some(wanted) = self.wanted_slopes(at) {
            // Before the heel and inside the circumference.
            let found = self.slopes(at, (sin - cos, -cos - sin));
            angle(
                "heel clearance, 60 deg behind the corner",
                heel(wanted, at),
                found.map(|f| heel(f, at)),
            );
        }
        let mut length = |name, wanted, found| {
            features.push(Feature {
                name,
                unit: "mm",
                wanted,
                found,
            });
        };
        length("web between the lips", 2.0 * r0, self.web);
        if let Ok(ground) = self.wanted.ground() {
            length(
                "chisel edge length",
                ground.chisel_length,
                self.measured.chisel_length,
            );
        }
        length("height of the tip", 0.0, Some(self.measured.tip_height));
        length(
            "height of lip 1 over lip 2 at the corner",
            0.0,
            Some(self.measured.lip_height_difference),
        );
        features
    }

    fn wanted_slopes(&self, at: (f64, f64)) -> Option<(f64, f64)> {
        let surface = self.wanted.surface(at.0, at.1)?;
        Some((surface.slope_x, surface.slope_y))
    }

    /// Largest tip error [mm] and turn [rad] over all strokes.
    pub fn path_error(&self) -> (f64, f64) {
        self.strokes.iter().fold((0.0, 0.0), |(tip, turn), stroke| {
            (
                f64::max(tip, stroke.tip_error),
                f64::max(turn, stroke.turn_error),
            )
        })
    }

    /// Slopes of flank 1 at a tip-centred point: those wanted there, and the slope of the plane of least squares
    /// through the error in a square beside it, on the sides that `into` gives (-1, 0 or 1 squares' halves along x
    /// and y). Waves that are shorter than the square are not taken for a slope.
    fn slopes(&self, at: (f64, f64), into: (f64, f64)) -> Option<(f64, f64)> {
        let wanted = self.wanted_slopes(at)?;
        let (_, radius) = self.simulation.dimensions();
        let reach = MEASURED_OVER * radius;
        let (x, y) = (at.0 + into.0 * reach, at.1 + into.1 * reach);
        let (mut squares, mut along) = (0.0, (0.0, 0.0));
        // A square grid is its own mirror image, so that its middle is the point and the two slopes do not mix.
        for i in -8..=8i32 {
            for j in -8..=8i32 {
                let (dx, dy) = (f64::from(i) / 8.0 * reach, f64::from(j) / 8.0 * reach);
                let error = self.flank_error(x + dx, y + dy)?;
                squares += dx * dx;
                along.0 += dx * error;
                along.1 += dy * error;
            }
        }
        Some((wanted.0 + along.0 / squares, wanted.1 + along.1 / squares))
    }

    /// Height of the ground flank less that of the wanted one at tip-centred (x, y) [mm]; `None` off the cone.
    pub fn flank_error(&self, x: f64, y: f64) -> Option<f64> {
        let wanted = self.wanted.surface(x, y)?.z - self.solution.cone.tip.z;
        Some(self.simulation.flank(0, x, y) - wanted)
    }
}

/// Joints [mm, rad] at these step counts.
fn joints(drill: &DrillJob, positions: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|motor| {
        let value = positions[motor] / drill.axes[motor].steps_per_unit;
        if motor < 3 { value } else { value.to_radians() }
    })
}

/// Where in the motion about the cone a joint vector stands; `None` while the drill is being indexed.
fn see(
    drill: &DrillJob,
    cycle: &Cycle<f64>,
    arm: &Arm,
    time: f64,
    joints: &[f64; 6],
) -> Option<Seen> {
    use std::f64::consts::PI;
    // Flank 2 is flank 1 with half a turn about the drill's own axis: theta3 less 180 deg.
    let second = joints[5] > PI / 2.0;
    let mut unrolled = *joints;
    if second {
        unrolled[5] -= PI;
    }
    let (rotation, tip) = arm.forward(&unrolled);
    let k = cycle.motion().axis;
    // Sine of mu along K and cosine from the trace; what is left over is a turn away from the motion.
    let skew = Vector::new(
        rotation[2][1] - rotation[1][2],
        rotation[0][2] - rotation[2][0],
        rotation[1][0] - rotation[0][1],
    ) * 0.5;
    let trace = rotation[0][0] + rotation[1][1] + rotation[2][2];
    let mu = k.dot(skew).atan2((trace - 1.0) / 2.0);
    let turn = {
        let exact = cycle.pose(mu, 0.0).rotation;
        let columns = [exact.n, exact.s, exact.a];
        // Columns of a rotation against those of another: the largest distance bounds the turn between them.
        let distance = |j: usize| {
            let c = columns[j];
            let d = [
                rotation[0][j] - c.x,
                rotation[1][j] - c.y,
                rotation[2][j] - c.z,
            ];
            d.iter().map(|x| x * x).sum::<f64>()
        };
        // For a small turn by angle t the squared distances of the three columns add up to 2 t^2.
        ((distance(0) + distance(1) + distance(2)) / 2.0).sqrt()
    };
    if turn > 1f64.to_radians() {
        return None;
    }
    let exact = cycle.pose(mu, 0.0).p;
    let away = arm_away(drill);
    let d = Vector::new(tip[0] - exact.x, tip[1] - exact.y, tip[2] - exact.z);
    let standoff = d.dot(away);
    Some(Seen {
        time,
        mu,
        flank: if second { 2 } else { 1 },
        standoff,
        beside: (d - away * standoff).norm(),
        turn,
        tip,
    })
}

/// Positive d2 in the machine frame: straight away from the wheel.
fn arm_away(drill: &DrillJob) -> Vector<f64> {
    let (s, c) = (drill.point_angle.to_radians() / 2.0).sin_cos();
    Vector::new(s, c, 0.0)
}

/// Finds the strokes in a stream of joint vectors.
struct Watch<'a> {
    drill: &'a DrillJob,
    cycle: &'a Cycle<f64>,
    before: Option<Seen>,
    open: Option<(Stroke, f64, u32)>,
    strokes: Vec<Stroke>,
    /// Height of the tip where mu last passed through 0 on flank 1 in a stroke.
    crossing: Option<f64>,
}

impl Watch<'_> {
    fn look(&mut self, seen: Option<Seen>) {
        let Some(seen) = seen else {
            self.close();
            self.before = None;
            return;
        };
        let Some(before) = self.before.take() else {
            self.before = Some(seen);
            return;
        };
        // A stroke is mu growing at a planned stand-off; infeed and retraction keep mu, the way back lets it fall.
        let speed = (seen.mu - before.mu) / (seen.time - before.time);
        let planned = self
            .cycle
            .plan()
            .standoffs()
            .min_by(|a, b| {
                (a - seen.standoff)
                    .abs()
                    .total_cmp(&(b - seen.standoff).abs())
            })
            .unwrap_or(0.0);
        let near = (seen.standoff - planned).abs() < 0.2 * self.drill.finish_depth.min(0.05);
        if near && speed > 0.02 * self.drill.stroke_speed.to_radians() {
            let (stroke, sum, count) = self.open.get_or_insert((
                Stroke {
                    from: before.time,
                    to: seen.time,
                    flank: seen.flank,
                    standoff: planned,
                    standoff_found: 0.0,
                    mu: (before.mu, seen.mu),
                    tip_error: 0.0,
                    turn_error: 0.0,
                },
                0.0,
                0,
            ));
            stroke.to = seen.time;
            stroke.mu.1 = seen.mu;
            let error = seen.beside.hypot(seen.standoff - planned);
            stroke.tip_error = stroke.tip_error.max(error);
            stroke.turn_error = stroke.turn_error.max(seen.turn);
            *sum += seen.standoff;
            *count += 1;
            if seen.flank == 1 && before.mu < 0.0 && seen.mu >= 0.0 {
                let share = -before.mu / (seen.mu - before.mu);
                self.crossing = Some(before.tip[2] + share * (seen.tip[2] - before.tip[2]));
            }
        } else {
            self.close();
        }
        self.before = Some(seen);
    }

    fn close(&mut self) {
        if let Some((mut stroke, sum, count)) = self.open.take() {
            stroke.standoff_found = sum / f64::from(count.max(1));
            // A few samples beside a corner are no stroke.
            if stroke.mu.1 - stroke.mu.0 > 0.05 {
                self.strokes.push(stroke);
            }
        }
    }
}
