//! Chords that one straight line replaces within the tolerance.
//!
//! ```text
//!            . p1     . p2
//!   anchor o==================> c     every point seen from the anchor allows directions within e / |p| of its own;
//!                 . p3                the ball (c, r) lies within all of them
//! ```
//!
//! Directions are weighted unit vectors; a new end is taken if its direction lies in the ball. In a plane curve the balls
//! are intervals and the test is exact (a circle merges up to a sagitta of e); in space it is on the safe side.

use crate::math::Real;

/// Directions that the chords merged so far allow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone<const N: usize> {
    centre: [f32; N],
    radius: f32,
}

fn length<const N: usize>(v: &[f32; N]) -> f32 {
    Real::sqrt(v.iter().fold(0.0f32, |s, x| s + x * x))
}

impl<const N: usize> Cone<N> {
    /// Of one chord with weighted way `p`, tolerance `e`.
    pub fn new(p: &[f32; N], e: f32) -> Self {
        let l = length(p);
        Self {
            centre: p.map(|x| x / l),
            radius: e / l,
        }
    }

    /// The cone when the chords up to the new end `p` (weighted, from the anchor) become one line; `None` when a point
    /// would lie farther than `e` from it. `last`: the newest chord.
    pub fn extended(&self, p: &[f32; N], last: &[f32; N], e: f32) -> Option<Self> {
        let l = length(p);
        let other = Self::new(p, e);
        let mut along = 0.0f32;
        let mut apart = 0.0f32;
        for i in 0..N {
            along += last[i] * other.centre[i];
            let d = other.centre[i] - self.centre[i];
            apart += d * d;
        }
        // No turning back, no sharp turn.
        if !(l > 0.0 && along > 0.9 * length(last)) {
            return None;
        }
        let apart = Real::sqrt(apart);
        if apart > self.radius {
            return None;
        }
        if apart + other.radius <= self.radius {
            return Some(other);
        }
        if apart + self.radius <= other.radius {
            return Some(*self);
        }
        // The largest ball within both.
        let radius = 0.5 * (self.radius + other.radius - apart);
        let share = (self.radius - radius) / apart;
        let mut centre = self.centre;
        for i in 0..N {
            centre[i] += share * (other.centre[i] - self.centre[i]);
        }
        Some(Self { centre, radius })
    }
}
