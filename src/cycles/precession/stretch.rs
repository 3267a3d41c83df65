//! One segment of the path: from a point to the next, or a turn on the spot, or a dwell.
//!
//! ```text
//! p(u) = p_i + u D                          t(u) = w cos(kappa u) - n_i sin(kappa u)     k = n_i x w
//! n(u) = n_i cos(kappa u) + w sin(kappa u)  (n, t, k) right-handed, k constant            w: where the normal turns to
//!
//! a(u) = ct t + ck k,   b(u) = ct k - ck t
//!   carried along: ct, ck constant
//!   feed-locked:   (ct, ck) = normalize(D_w cos - D_n sin, D_k),  the feed seen in that frame
//! ```
//!
//! Every pose is evaluated from its own u = j/N, no rotation is ever added to another.

use super::error::{Field, PrecessionError};
use super::frame::{LEAST_SINE, axis, in_tangent_plane, taken_up, tool_frame};
use super::parameters::{Drive, FeedAt, Process, Reference};
use super::turn::{Steps, Turn};
use crate::geometry::{Pose, Rotation, Vector, Waypoint};
use crate::math::Real;

/// What was noticed on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    /// Neighbouring normals differ by more than 30 deg.
    pub coarse_normals: bool,
    /// The feed ran along the normal; the reference was carried along instead.
    pub feed_along_normal: bool,
    /// The normal turned on the spot.
    pub pivot: bool,
    /// The point was the one before it once more.
    pub skipped: bool,
}

impl Flags {
    /// Those of either.
    pub fn or(self, other: Self) -> Self {
        Self {
            coarse_normals: self.coarse_normals || other.coarse_normals,
            feed_along_normal: self.feed_along_normal || other.feed_along_normal,
            pivot: self.pivot || other.pivot,
            skipped: self.skipped || other.skipped,
        }
    }

    /// The names of those raised, in alphabetical order.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        [
            (self.coarse_normals, "CoarseNormals"),
            (self.feed_along_normal, "FeedAlongNormal"),
            (self.pivot, "Pivot"),
            (self.skipped, "Skipped"),
        ]
        .into_iter()
        .filter_map(|(raised, name)| raised.then_some(name))
    }
}

/// What is carried from one segment to the next: the last point kept, and the moving frame there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Carried<R> {
    pub p: Vector<R>,
    pub n: Vector<R>,
    pub a: Vector<R>,
    pub phase: Turn,
    /// Running time [s].
    pub time: R,
}

/// One pose in full.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance<R> {
    /// The segment that ends here or is under way, from 0.
    pub segment: u32,
    /// Place within the segment, 0 ..= 1.
    pub u: R,
    /// Time from the pose before [s], 0 at the first.
    pub dt: R,
    /// Time from the first pose [s].
    pub time: R,
    pub phase: Turn,
    /// (a, b, n) in the work's frame.
    pub frame: Rotation<R>,
    /// C, the ball's centre [mm].
    pub centre: Vector<R>,
    /// P, from the surface to the spindle.
    pub axis: Vector<R>,
    /// F, the far point [mm].
    pub far: Vector<R>,
    tilt: (R, R),
    lean: (R, R),
}

impl<R: Real> Stance<R> {
    /// The F word of inverse-time feed [1/min]; 0 at the first pose.
    pub fn inverse_time(&self) -> R {
        if self.dt > R::ZERO {
            R::of(60.0) / self.dt
        } else {
            R::ZERO
        }
    }

    /// The turn-free tool frame T of a six-axis arm; its third column is P.
    pub fn tool(&self) -> Rotation<R> {
        tool_frame(&self.frame, self.tilt, self.lean)
    }

    /// The tool frame in the ball's centre, z along P, with the time from the pose before as its least duration.
    pub fn waypoint(&self) -> Waypoint<R> {
        Waypoint {
            pose: Pose {
                rotation: self.tool(),
                p: self.centre,
            },
            duration: self.dt,
        }
    }
}

/// How the reference direction lies in the frame (n, t, k).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Guide<R> {
    Carried { t: R, k: R },
    Feed { w: R, n: R, k: R },
}

/// A segment under way: an iterator over its poses. A copy can be walked for checking.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch<R> {
    segment: u32,
    flags: Flags,
    count: u32,
    done: u32,
    /// Reference and phase of the very first pose of a path, while it is still to come.
    lead: Option<(Vector<R>, Turn)>,
    p: Vector<R>,
    d: Vector<R>,
    n: Vector<R>,
    w: Vector<R>,
    k: Vector<R>,
    kappa: R,
    guide: Guide<R>,
    steps: Steps,
    /// When it starts, and how long it takes [s].
    start: R,
    time: R,
    tilt: (R, R),
    rho: R,
    reach: R,
}

/// Largest number of steps in one segment.
const MOST: f64 = 2147483648.0;

impl<R: Real> Stretch<R> {
    /// The segment from `from` to the point `p` with the unit normal `n`, and what is carried on from there; `None` if
    /// nothing moves. `index` is that of the point.
    pub(super) fn between(
        process: &Process<R>,
        from: &Carried<R>,
        p: Vector<R>,
        n: Vector<R>,
        index: u32,
    ) -> Result<Option<(Self, Carried<R>)>, PrecessionError> {
        let d = p - from.p;
        let kappa = angle_between(from.n, n);
        check_opposite(kappa, index)?;
        let length = match process.feed_at {
            FeedAt::Contact => d.norm(),
            FeedAt::Centre => (d + (n - from.n) * process.rho).norm(),
        };
        if !length.is_finite() {
            let field = Field::Points;
            let index = Some(index);
            return Err(PrecessionError::NonFinite { field, index });
        }
        let pivot = length <= R::of(1e-6);
        // In f32 equal normals of different length differ by rounding alone.
        if pivot && kappa <= R::of(1e-7).max(R::EPSILON * R::of(4.0)) {
            return Ok(None);
        }

        // Where the normal turns to. Nearly opposite normals leave little of the difference, so it is projected again.
        let turned = in_tangent_plane(n - from.n, from.n, R::ZERO)
            .and_then(|w| in_tangent_plane(w, from.n, R::ZERO));
        let (w, kappa) = turned.map_or((from.a, R::ZERO), |w| (w, kappa));
        let k = from.n.cross(w);
        let (sin, cos) = kappa.sin_cos();
        let mut flags = Flags {
            coarse_normals: kappa > R::of(30.0).to_radians(),
            pivot,
            ..Flags::default()
        };
        let mut phase = from.phase;
        let mut guide = None;
        if process.reference == Reference::FeedLocked && !pivot {
            guide = feed_guide(d, from.n, w, k, (sin, cos));
            flags.feed_along_normal = guide.is_none();
        }
        let guide = match guide {
            Some((guide, new)) => {
                phase = phase.plus(taken_up(from.a, new, from.n));
                guide
            }
            None => carried_guide(from.a, w, k),
        };

        let time = if pivot {
            kappa / process.w_rot
        } else {
            length / process.feed
        };
        let (rate, turns) = match process.drive {
            Drive::Time { rate } => (rate, rate / R::TAU * time),
            Drive::Distance { .. } if pivot => (R::ZERO, R::ZERO),
            Drive::Distance { pitch } => (R::TAU * process.feed / pitch, length / pitch),
        };
        let count = whole_count(process.count(time, rate, kappa / time), index)?;
        let too_many = PrecessionError::TooManyTurns { index };
        let steps = Steps::new(phase, turns, count).ok_or(too_many)?;

        let (ct, ck) = guide.at(sin, cos);
        let end = (w * cos - from.n * sin) * ct + k * ck;
        let carried = Carried {
            p,
            n,
            a: in_tangent_plane(end, n, R::ZERO).unwrap_or(end),
            phase: Steps::end(phase, turns),
            time: from.time + time,
        };
        let stretch = Self {
            segment: index.saturating_sub(1),
            flags,
            count,
            d,
            w,
            k,
            kappa,
            guide,
            steps,
            time,
            ..Self::standing(process, from)
        };
        Ok(Some((stretch, carried)))
    }

    /// At rest in one point for `time` [s], greater than 0.
    pub(super) fn dwell(
        process: &Process<R>,
        at: &Carried<R>,
        time: R,
    ) -> Result<Self, PrecessionError> {
        let (rate, turns) = match process.drive {
            Drive::Time { rate } => (rate, rate / R::TAU * time),
            Drive::Distance { .. } => (R::ZERO, R::ZERO),
        };
        let count = whole_count(process.count(time, rate, R::ZERO), 0)?;
        let too_many = PrecessionError::TooManyTurns { index: 0 };
        Ok(Self {
            count,
            steps: Steps::new(at.phase, turns, count).ok_or(too_many)?,
            time,
            ..Self::standing(process, at)
        })
    }

    /// No pose at all.
    pub(super) fn standing(process: &Process<R>, at: &Carried<R>) -> Self {
        Self {
            segment: 0,
            flags: Flags::default(),
            count: 0,
            done: 0,
            lead: None,
            p: at.p,
            d: Vector::ZERO,
            n: at.n,
            w: at.a,
            k: at.n.cross(at.a),
            kappa: R::ZERO,
            guide: Guide::Carried {
                t: R::ONE,
                k: R::ZERO,
            },
            steps: Steps::still(at.phase),
            start: at.time,
            time: R::ZERO,
            tilt: process.tilt,
            rho: process.rho,
            reach: process.reach,
        }
    }

    /// The same with the first pose of the path in front.
    pub(super) fn led(mut self, at: &Carried<R>) -> Self {
        self.lead = Some((at.a, at.phase));
        self
    }

    /// The same for a point that was skipped.
    pub(super) fn skipping(mut self, segment: u32) -> Self {
        self.segment = segment;
        self.flags.skipped = true;
        self
    }

    pub fn flags(&self) -> Flags {
        self.flags
    }

    /// N, the number of steps, the first pose of the path not counted.
    pub fn steps(&self) -> u32 {
        self.count
    }

    /// How long it takes [s].
    pub fn time(&self) -> R {
        self.time
    }

    fn stance(&self, (u, dt): (R, R), phase: Turn, frame: Rotation<R>) -> Stance<R> {
        let lean = phase.sin_cos();
        let axis = axis(&frame, self.tilt, lean);
        let centre = self.p + self.d * u + frame.a * self.rho;
        Stance {
            segment: self.segment,
            u,
            dt,
            time: self.start + self.time * u,
            phase,
            frame,
            centre,
            axis,
            far: centre + axis * self.reach,
            tilt: self.tilt,
            lean,
        }
    }
}

impl<R: Real> Iterator for Stretch<R> {
    type Item = Stance<R>;

    fn next(&mut self) -> Option<Stance<R>> {
        if let Some((a, phase)) = self.lead.take() {
            let frame = Rotation {
                n: a,
                s: self.n.cross(a),
                a: self.n,
            };
            let first = self.stance((R::ZERO, R::ZERO), phase, frame);
            return Some(Stance {
                segment: 0,
                ..first
            });
        }
        if self.done >= self.count {
            return None;
        }
        self.done += 1;
        self.steps.advance();
        let count = R::of_i32(self.count as i32);
        let u = R::of_i32(self.done as i32) / count;
        let (sin, cos) = (self.kappa * u).sin_cos();
        let (ct, ck) = self.guide.at(sin, cos);
        let t = self.w * cos - self.n * sin;
        let frame = Rotation {
            n: t * ct + self.k * ck,
            s: self.k * ct - t * ck,
            a: self.n * cos + self.w * sin,
        };
        Some(self.stance((u, self.time / count), self.steps.phase(), frame))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.count - self.done) as usize + usize::from(self.lead.is_some());
        (left, Some(left))
    }
}

impl<R: Real> ExactSizeIterator for Stretch<R> {}

impl<R: Real> Guide<R> {
    /// (ct, ck), a unit pair.
    fn at(&self, sin: R, cos: R) -> (R, R) {
        match *self {
            Self::Carried { t, k } => (t, k),
            Self::Feed { w, n, k } => unit_pair(w * cos - n * sin, k),
        }
    }
}

fn carried_guide<R: Real>(a: Vector<R>, w: Vector<R>, k: Vector<R>) -> Guide<R> {
    let (t, k) = unit_pair(a.dot(w), a.dot(k));
    Guide::Carried { t, k }
}

/// The feed in the frame (n, w, k), and its reference direction at the start; `None` where it comes within 1e-3 of the
/// normal at either end or, as the normal sweeps over it, between them.
fn feed_guide<R: Real>(
    d: Vector<R>,
    n: Vector<R>,
    w: Vector<R>,
    k: Vector<R>,
    (sin, cos): (R, R),
) -> Option<(Guide<R>, Vector<R>)> {
    let d = d.unit(R::ZERO)?;
    let least = R::of(LEAST_SINE);
    let (dw, dn, dk) = (d.dot(w), d.dot(n), d.dot(k));
    let dt = dw * cos - dn * sin;
    let at_an_end = dw.hypot(dk) < least || dt.hypot(dk) < least;
    let between = dw * dt <= R::ZERO && dk.abs() < least;
    if at_an_end || between {
        return None;
    }
    let guide = Guide::Feed {
        w: dw,
        n: dn,
        k: dk,
    };
    Some((guide, in_tangent_plane(d, n, R::ZERO)?))
}

fn unit_pair<R: Real>(x: R, y: R) -> (R, R) {
    let scale = R::ONE / (x * x + y * y).sqrt();
    (x * scale, y * scale)
}

/// Angle between two unit vectors, accurate at both ends of its range [rad].
fn angle_between<R: Real>(a: Vector<R>, b: Vector<R>) -> R {
    (b - a).norm().atan2((b + a).norm()) * R::TWO
}

pub(super) fn check_neighbours<R: Real>(
    a: Vector<R>,
    b: Vector<R>,
    index: u32,
) -> Result<(), PrecessionError> {
    check_opposite(angle_between(a, b), index)
}

fn check_opposite<R: Real>(angle: R, index: u32) -> Result<(), PrecessionError> {
    if angle > R::PI - R::of(1e-3) {
        Err(PrecessionError::AntiParallel { index })
    } else {
        Ok(())
    }
}

/// A count rounded up, but not by a rounding error.
fn whole_count<R: Real>(count: R, index: u32) -> Result<u32, PrecessionError> {
    let count = (count - R::of(1e-9)).ceil();
    if count < R::of(MOST) {
        Ok(count.max(R::ONE).to_i32() as u32)
    } else {
        Err(PrecessionError::TooManySteps { index })
    }
}
