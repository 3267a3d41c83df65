//! Chords that one straight line replaces within a share of the tolerance, and how long such lines should be.
//!
//! ```text
//!            . p1     . p2
//!   anchor o==================> c     every point seen from the anchor allows directions within e / |p| of its own;
//!                 . p3                the ball (c, r) lies within all of them
//! ```
//!
//! Directions are weighted unit vectors; a new end is taken if its direction lies in the ball, and if it does not fall back
//! behind a point before it by more than e. In a plane curve the balls are intervals and the test is exact (a circle is
//! replaced up to a sagitta of e); in space it is on the safe side. Distance decides, never the angle of a chord: chords of
//! a step or two point anywhere.
//!
//! The lines that replace a curve are the control polygon of one spline (`block.rs`), whose third derivative is smooth only
//! where they are of like length. So a line ends where its length is due, within a chord if need be, and that length follows
//! the curvature seen so far:
//!
//! ```text
//!  sagitta  k h^2 / 8,  spline inside its polygon  k h^2 / 6   ==>   h = sqrt(2.6 e / k)  keeps both within their shares
//! ```

use super::look_ahead::{greater, lesser};
use crate::math::Real;

/// Share of the tolerance for the replaced chords; rounding has the rest, and all of it where nothing is replaced. A spline
/// uses the two as 1/8 to 1/6 (above).
pub(super) const SHARE: f32 = 0.42;
/// Shortest lines that the tolerance is not needed for [ms]: those of a curve are no longer, so that all are alike, and
/// never shorter than 1/48 of the way in which the motion can stop.
pub(super) const BEAT: f32 = 8.0;
/// Length of the lines from curvature and tolerance: `h^2 = 2.6 e / k`, a tenth below what the shares allow.
const LENGTH: f32 = 2.6;
/// Lines grow and shrink by at most this factor from one to the next where the path is curved.
const GROWTH: f32 = 1.2;
/// Lines grow where the curve allows lines longer by that.
const LONGER: f32 = 1.15;
/// Where its curvature would allow lines that much longer, it counts as straight, and lines grow faster.
const STRAIGHT: f32 = 16.0;
/// What is kept of the length at which the tolerance cut a line.
const ROOM: f32 = 0.9;
/// Chords shorter than this share of a line are cut; longer ones end where they end, for points between them lie
/// noticeably inside the curve.
const FINE: f32 = 0.25;
/// Turn from one line to the next that is a corner, not a curve; about 40 degrees.
const CORNER: f32 = 0.7;

/// Directions that the chords replaced so far allow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone<const N: usize> {
    centre: [f32; N],
    radius: f32,
    /// Distance of the farthest point from the anchor.
    reach: f32,
}

fn length<const N: usize>(v: &[f32; N]) -> f32 {
    Real::sqrt(v.iter().fold(0.0f32, |s, x| s + x * x))
}

impl<const N: usize> Cone<N> {
    /// Of one chord with weighted way `p`, tolerance `e`.
    pub fn new(p: &[f32; N], e: f32) -> Self {
        let l = length(p);
        let inverse = 1.0 / l;
        Self {
            centre: p.map(|x| x * inverse),
            radius: e * inverse,
            reach: l,
        }
    }

    /// The cone when the chords up to the new end `p` (weighted, from the anchor) become one line; `None` when a point
    /// would lie farther than `e` from it, or past its end.
    pub fn extended(&self, p: &[f32; N], e: f32) -> Option<Self> {
        let l = length(p);
        if !(l > 0.0 && l + e >= self.reach) {
            return None;
        }
        let mut other = Self::new(p, e);
        other.reach = other.reach.max(self.reach);
        let mut apart = 0.0f32;
        for i in 0..N {
            let d = other.centre[i] - self.centre[i];
            apart += d * d;
        }
        let apart = Real::sqrt(apart);
        if apart > self.radius {
            return None;
        }
        if apart + other.radius <= self.radius {
            return Some(other);
        }
        if apart + self.radius <= other.radius {
            return Some(Self {
                reach: other.reach,
                ..*self
            });
        }
        // The largest ball within both.
        let radius = 0.5 * (self.radius + other.radius - apart);
        let share = (self.radius - radius) / apart;
        let mut centre = self.centre;
        for i in 0..N {
            centre[i] += share * (other.centre[i] - self.centre[i]);
        }
        Some(Self {
            centre,
            radius,
            reach: other.reach,
        })
    }
}

/// What is known of the curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spacing {
    /// Length that lines are to have; infinite where nothing is known.
    length: f32,
    /// Lines without a turn so far: one or two may be where a curve turns from one side to the other.
    straight: u8,
}

/// Where a line ends that a chord would make longer than it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// Not yet.
    Later,
    /// At this share of the new chord.
    Within(f32),
    /// Where the new chord begins.
    Before,
}

impl Spacing {
    pub const NONE: Self = Self {
        length: f32::INFINITY,
        straight: 0,
    };

    /// `old`, `new`: length of the line without the chord and with it; `chord`: that of the chord.
    pub fn end(&self, old: f32, new: f32, chord: f32) -> End {
        let due = self.length;
        if new <= due || new <= old {
            End::Later
        } else if chord <= FINE * due {
            End::Within(((due - old) / (new - old)).clamp(0.0, 1.0))
        } else if new - due > due - old {
            End::Before
        } else {
            End::Later
        }
    }

    /// The tolerance has ended a line of this length.
    pub fn cut(&mut self, length: f32) {
        self.length = self.length.min(ROOM * length);
    }

    /// A line of length `h` is complete, which turns by `turn` from the one before it, of length `before`. `enough`: length
    /// above which nothing is gained.
    pub fn follow(&mut self, turn: f32, before: f32, h: f32, tolerance: f32, enough: f32) {
        if turn > CORNER {
            *self = Self::NONE;
            return;
        }
        let square = LENGTH * tolerance * 0.5 * (before + h);
        self.straight = if square >= turn * h * h * (STRAIGHT * STRAIGHT) {
            self.straight.saturating_add(1)
        } else {
            0
        };
        self.length = if self.straight >= 4 {
            2.0 * h
        } else {
            let most = if turn > 0.0 {
                Real::sqrt(square / turn)
            } else {
                enough
            };
            // Lines alike are worth more than lines a little longer; a turn is known to a few hundredths only.
            let due = if self.length < f32::INFINITY {
                self.length
            } else {
                h
            };
            // What is enough keeps lines from growing, and makes none shorter.
            let longer = lesser(most, enough);
            if most < due {
                greater(most, due / GROWTH)
            } else if longer > due * LONGER {
                lesser(longer, due * GROWTH)
            } else {
                due
            }
        };
    }
}
