//! Pulses and a programmed path -> how far the joints are off the path, at every instant.
//!
//! The joints, rebuilt from the pulses, and the polyline of the programmed points are both weighted to mm at the tool.
//! The place on the path is followed along it from sample to sample and never looked for as a whole, so that a path that
//! crosses itself, or runs back over itself, is compared with the stretch that is being run:
//!
//! ```text
//!            slack          reach = 1.5 |x_i - x_i-1| + slack
//!          <-------+---------------------------->
//!   - - - - -------o----------------------------- - - -   path, by its length
//!                place of sample i-1
//! ```

use crate::trace::{TICK_HZ, Trace, seconds};

/// Time between samples [counts], and most samples of a trace.
const EVERY: u64 = TICK_HZ / 2000;
const MOST: u64 = 1_000_000;

/// The distance of the joints from the path over time.
#[derive(Clone, Debug, Default)]
pub struct ContourError {
    /// Time [s] and distance [mm].
    pub samples: Vec<(f64, f64)>,
    /// Joints at these samples [unit].
    pub joints: Vec<[f64; 6]>,
    /// The largest distance [mm].
    pub largest: f64,
}

impl ContourError {
    /// Compares a trace with the polyline through `points` [unit]; `steps` are steps per unit, `weights` mm per unit.
    /// `slack` [mm]: how far the place on the path may be off, a few times the tolerance and a step.
    pub fn of(
        trace: &Trace<6>,
        points: &[[f64; 6]],
        steps: &[f64; 6],
        weights: &[f64; 6],
        slack: f64,
    ) -> Self {
        let weighted = |at: &[f64; 6]| std::array::from_fn(|i| at[i] * weights[i]);
        let vertices: Vec<[f64; 6]> = points.iter().map(weighted).collect();
        let Some(first) = vertices.first() else {
            return Self::default();
        };
        let mut place = Place {
            segment: 0,
            along: 0.0,
        };
        let mut last = *first;
        let mut contour = Self::default();
        let every = EVERY.max(trace.end() / MOST);
        for (index, row) in (0u64..).zip(trace.rebuilt_every(every)) {
            let joints = std::array::from_fn(|i| row[i] / steps[i]);
            let x = weighted(&joints);
            let reach = 1.5 * distance(&x, &last) + slack;
            let off = place.follow(&vertices, &x, slack, reach);
            last = x;
            contour.samples.push((seconds(index * every), off));
            contour.joints.push(joints);
            contour.largest = contour.largest.max(off);
        }
        contour
    }
}

/// A place on a polyline: a segment, and the length from its beginning [mm].
#[derive(Clone, Copy, Debug)]
struct Place {
    segment: usize,
    along: f64,
}

impl Place {
    /// Moves to the point nearest to `x` between `back` before and `reach` behind this place, the last of them where
    /// several are as near; its distance.
    fn follow(&mut self, vertices: &[[f64; 6]], x: &[f64; 6], back: f64, reach: f64) -> f64 {
        let from = self.moved_back(vertices, back);
        // Length that is left from `from` on.
        let mut left = back + reach;
        let mut best = (f64::INFINITY, from);
        let mut begin = from.along;
        for (segment, ends) in vertices.windows(2).enumerate().skip(from.segment) {
            let length = distance(&ends[0], &ends[1]);
            let end = length.min(begin + left);
            let along = if length > 0.0 {
                let dot: f64 = (0..6)
                    .map(|i| (x[i] - ends[0][i]) * (ends[1][i] - ends[0][i]))
                    .sum();
                (dot / length).clamp(begin, end.max(begin))
            } else {
                0.0
            };
            let share = if length > 0.0 { along / length } else { 0.0 };
            let nearest = std::array::from_fn(|i| ends[0][i] + share * (ends[1][i] - ends[0][i]));
            let off = distance(x, &nearest);
            if off <= best.0 + 1e-9 {
                best = (off, Place { segment, along });
            }
            left -= length - begin;
            begin = 0.0;
            if left <= 0.0 {
                break;
            }
        }
        if best.0.is_infinite() {
            // A path of a single point.
            return vertices.first().map_or(0.0, |vertex| distance(x, vertex));
        }
        *self = best.1;
        best.0
    }

    fn moved_back(mut self, vertices: &[[f64; 6]], mut by: f64) -> Self {
        while by > self.along && self.segment > 0 {
            by -= self.along;
            self.segment -= 1;
            self.along = distance(&vertices[self.segment], &vertices[self.segment + 1]);
        }
        self.along = (self.along - by).max(0.0);
        self
    }
}

fn distance(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}
