//! The whole cycle: both flanks at every stand-off, as waypoints.
//!
//! ```text
//! for each stand-off e:                         duration
//!   approach   (mu_start, e + clear)            rapid
//!   infeed     (mu_start, e)                    clear / infeed speed
//!   stroke     mu_start -> mu_end at e          mu step / stroke speed, in equal segments
//!   retract    (mu_end, e + clear)              rapid
//!   return     mu_end -> mu_start at e + clear  rapid, back by the same waypoints
//!   index      roll by 90, then 180 deg         rapid
//!   the same for flank 2, rolled by 180 deg, then index back
//! ```
//!
//! The roll is about the drill's own axis. It is taken in quarter turns, so that no rounding decides its direction, and
//! turned back after flank 2, so that nothing winds up. It happens at mu_start: there the wheel's plane lies along
//! the lip and the lip, the foremost line of the turning drill, keeps the full clearance. A stand-off moves
//! the tip along (sin phi0, cos phi0, 0), the table's d2, and turns nothing.

use super::error::{DrillPointError, Field, check};
use super::flank::Flank;
use super::motion::{Motion, Variant};
use super::plan::{PassPlan, Passes};
use super::solve::{Drill, Solution};
use super::stroke::Stroke;
use crate::geometry::{Pose, Rotation, Vector, Waypoint};
use crate::math::Real;

/// Everything that a cycle is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<R> {
    pub drill: Drill<R>,
    /// Axis angle of the cone, the free choice [rad].
    pub phi: R,
    /// Where the finished tip stands at mu = 0, in the machine frame [mm].
    pub touch: Vector<R>,
    pub passes: Passes<R>,
    /// Stand-off added when retracted [mm], greater than 0.
    pub clear: R,
    /// mu before the lip and behind the last contact [rad].
    pub over: R,
    /// Plan angle of the heel behind the corner [rad].
    pub heel_angle: R,
    /// Largest mu between two waypoints of a stroke [rad].
    pub mu_step: R,
    /// Speed of mu in a stroke [rad/s], greater than 0.
    pub stroke_speed: R,
    /// Speed of the infeed [mm/s], greater than 0.
    pub infeed_speed: R,
    pub variant: Variant,
}

impl<R: Real> Parameters<R> {
    /// The usual values: 3 mm clear, 2 deg over, heel at 60 deg, 0.8 deg a waypoint (1 um and 0.001 deg with an arm of
    /// 150 mm), 20 deg/s, 2 mm/s.
    pub fn new(drill: Drill<R>, phi: R, touch: Vector<R>, stock: R) -> Self {
        let degrees = |x: f64| R::of(x).to_radians();
        Self {
            drill,
            phi,
            touch,
            passes: Passes::of(stock),
            clear: R::of(3.0),
            over: degrees(2.0),
            heel_angle: degrees(60.0),
            mu_step: degrees(0.8),
            stroke_speed: degrees(20.0),
            infeed_speed: R::TWO,
            variant: Variant::Exact,
        }
    }
}

/// A cycle under way: an iterator over its waypoints. A copy can be walked for checking.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle<R> {
    motion: Motion<R>,
    touch: Vector<R>,
    away: Vector<R>,
    clear: R,
    stroke: Stroke<R>,
    solution: Solution<R>,
    plan: PassPlan<R>,
    /// Segments of a stroke, and of the way back.
    segments: u32,
    back_segments: u32,
    infeed_duration: R,
    segment_duration: R,
    /// The next waypoint: stroke, flank, and place within the table above.
    pass: u32,
    flank: Side,
    place: Place,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    One,
    Two,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Approach,
    Infeed,
    /// The end of this segment, from 1.
    Stroke(u32),
    Retract,
    Back(u32),
    Quarter,
    Index,
}

/// How far the drill is rolled about its axis from flank 1, in quarter turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Roll {
    None,
    Quarter,
    Half,
}

impl Roll {
    fn of(side: Side) -> Self {
        match side {
            Side::One => Roll::None,
            Side::Two => Roll::Half,
        }
    }

    /// The rotation with this roll in front; exact, quarter turns only exchange axes.
    fn apply<R: Real>(self, Rotation { n, s, a }: Rotation<R>) -> Rotation<R> {
        match self {
            Roll::None => Rotation { n, s, a },
            Roll::Quarter => Rotation { n, s: a, a: -s },
            Roll::Half => Rotation { n, s: -s, a: -a },
        }
    }
}

impl<R: Real> Cycle<R> {
    /// Checks everything; after this nothing can fail.
    pub fn new(parameters: &Parameters<R>) -> Result<Self, DrillPointError<R>> {
        let p = parameters;
        let solution = p.drill.solve(p.phi)?;
        p.check_process()?;
        let plan = p.passes.plan(p.drill.point_angle)?;
        let cone = solution.cone;
        let flank = Flank::of(p.drill.diameter, p.drill.web, &cone)?;
        let stroke = Stroke::new(&cone, &flank, solution.chisel_end, p.heel_angle, p.over)?;
        let motion = Motion::new(&cone, p.drill.point_angle, p.variant)?;
        let range = stroke.end - stroke.start;
        let segments = pieces(range, p.mu_step);
        // Rapids are straight in the joints. Back along the waypoints of the stroke: a planner that rounds corners makes one
        // curve of them (3 um inside of them with an arm of 150 mm and 0.8 deg), and the drill stays as clear of the wheel
        // as it was drawn back. Corners of 5 deg would each be slowed down for, and a straight way from one end to the other,
        // no sooner at its end because d1 needs as long for either, strays by 5 mm.
        let back_segments = pieces(range, p.mu_step.min(R::of(2.0).to_radians()));
        let (sin_phi0, cos_phi0) = p.drill.half_point_angle().sin_cos();
        let infeed_duration = p.clear / p.infeed_speed;
        let segment_duration = range / R::of_i32(segments as i32) / p.stroke_speed;
        // What may overflow on the way is smaller than the squares in these norms.
        let finite = |x: R| x.is_finite();
        check(
            &[],
            &[
                (Field::Diameter, finite(cone.tip.norm())),
                (Field::Touch, finite(p.touch.norm())),
                (Field::Clear, finite((plan.infeed + p.clear).squared())),
                (Field::InfeedSpeed, finite(infeed_duration)),
                (Field::StrokeSpeed, finite(segment_duration)),
            ],
        )?;
        Ok(Self {
            motion,
            touch: p.touch,
            away: Vector::new(sin_phi0, cos_phi0, R::ZERO),
            clear: p.clear,
            stroke,
            solution,
            plan,
            segments,
            back_segments,
            infeed_duration,
            segment_duration,
            pass: 0,
            flank: Side::One,
            place: Place::Approach,
        })
    }

    pub fn solution(&self) -> &Solution<R> {
        &self.solution
    }

    pub fn stroke(&self) -> &Stroke<R> {
        &self.stroke
    }

    pub fn plan(&self) -> &PassPlan<R> {
        &self.plan
    }

    pub fn motion(&self) -> &Motion<R> {
        &self.motion
    }

    /// Stand-off added when retracted [mm].
    pub fn clear(&self) -> R {
        self.clear
    }

    /// Segments of one stroke.
    pub fn segments(&self) -> u32 {
        self.segments
    }

    /// The stroke that the next waypoint belongs to, from 0; the number of strokes when the cycle is over.
    pub fn pass(&self) -> u32 {
        self.pass
    }

    /// The drill's pose at `mu` [rad] and stand-off [mm], flank 1.
    pub fn pose(&self, mu: R, standoff: R) -> Pose<R> {
        let moved = self.motion.at(mu);
        Pose {
            rotation: moved.rotation,
            p: self.touch + (moved.p + self.away * standoff),
        }
    }

    /// mu at the end of piece `i` of `n` equal ones, from the start of the stroke; its ends are met exactly.
    fn mu(&self, i: u32, n: u32) -> R {
        let Stroke { start, end, .. } = self.stroke;
        if i >= n {
            end
        } else {
            start + (end - start) * (R::of_i32(i as i32) / R::of_i32(n as i32))
        }
    }

    fn waypoint(&self) -> Waypoint<R> {
        let e = self.plan.standoff(self.pass);
        let away = e + self.clear;
        let side = Roll::of(self.flank);
        let start = self.stroke.start;
        let (mu, standoff, roll, duration) = match self.place {
            Place::Approach => (start, away, side, R::ZERO),
            Place::Infeed => (start, e, side, self.infeed_duration),
            Place::Stroke(i) => (self.mu(i, self.segments), e, side, self.segment_duration),
            Place::Retract => (self.stroke.end, away, side, R::ZERO),
            Place::Back(i) => {
                let n = self.back_segments;
                (self.mu(n.saturating_sub(i), n), away, side, R::ZERO)
            }
            Place::Quarter => (start, away, Roll::Quarter, R::ZERO),
            Place::Index => (start, away, Roll::of(self.flank.other()), R::ZERO),
        };
        let pose = self.pose(mu, standoff);
        Waypoint {
            pose: Pose {
                rotation: roll.apply(pose.rotation),
                p: pose.p,
            },
            duration,
        }
    }

    fn advance(&mut self) {
        self.place = match self.place {
            Place::Approach => Place::Infeed,
            Place::Infeed => Place::Stroke(1),
            Place::Stroke(i) if i < self.segments => Place::Stroke(i + 1),
            Place::Stroke(_) => Place::Retract,
            Place::Retract => Place::Back(1),
            Place::Back(i) if i < self.back_segments => Place::Back(i + 1),
            Place::Back(_) => Place::Quarter,
            Place::Quarter => Place::Index,
            Place::Index => {
                let before = self.plan.standoff(self.pass);
                if self.flank == Side::Two {
                    self.pass += 1;
                }
                self.flank = self.flank.other();
                // Indexing ended where the approach would go unless the stand-off has changed.
                if self.plan.standoff(self.pass) == before {
                    Place::Infeed
                } else {
                    Place::Approach
                }
            }
        };
    }
}

impl<R: Real> Iterator for Cycle<R> {
    type Item = Waypoint<R>;

    fn next(&mut self) -> Option<Waypoint<R>> {
        if self.pass >= self.plan.strokes() {
            return None;
        }
        let waypoint = self.waypoint();
        self.advance();
        Some(waypoint)
    }
}

impl Side {
    fn other(self) -> Self {
        match self {
            Side::One => Side::Two,
            Side::Two => Side::One,
        }
    }
}

impl<R: Real> Parameters<R> {
    fn check_process(&self) -> Result<(), DrillPointError<R>> {
        let least_step = R::of(0.001).to_radians();
        let right = R::PI * R::HALF;
        check(
            &[
                (Field::Clear, self.clear),
                (Field::Over, self.over),
                (Field::HeelAngle, self.heel_angle),
                (Field::MuStep, self.mu_step),
                (Field::StrokeSpeed, self.stroke_speed),
                (Field::InfeedSpeed, self.infeed_speed),
                (Field::Touch, self.touch.x),
                (Field::Touch, self.touch.y),
                (Field::Touch, self.touch.z),
            ],
            &[
                (Field::Clear, self.clear > R::ZERO),
                (
                    Field::MuStep,
                    self.mu_step >= least_step && self.mu_step <= right,
                ),
                (Field::StrokeSpeed, self.stroke_speed > R::ZERO),
                (Field::InfeedSpeed, self.infeed_speed > R::ZERO),
            ],
        )
    }
}

/// How many equal pieces of at most `piece` make `range`: rounded up, but not by a rounding error.
fn pieces<R: Real>(range: R, piece: R) -> u32 {
    let ratio = range / piece;
    let count = (ratio - ratio * R::EPSILON * R::of(16.0)).ceil();
    // The range is below 2 pi and the piece at least 0.001 deg: at most 360 000.
    count.max(R::ONE).to_i32() as u32
}
