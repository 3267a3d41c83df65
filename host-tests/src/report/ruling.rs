//! Motions and the place on the path -> which limit ruled when: the feed, or a joint's velocity, acceleration or jerk.
//!
//! At each sample the motion is measured by its shares of all limits, as rebuilt from the pulses, and the largest share
//! rules if it is at least [`RULES`]. A window rounds acceleration off, and jerk, which jumps from limit to limit, even
//! more: what was reached within half a window around an instant counts for it.

use super::contour::ContourError;
use super::motors::{Motors, Quantity};
use crate::job::{FIRST_TURNING, PathJob};
use std::collections::VecDeque;

/// Share of a limit from which on it counts as reached.
pub const RULES: f64 = 0.8;

/// What ruled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ruler {
    Feed,
    /// A figure of [`Motors`] and its limit.
    Joint(usize, Limit),
    Nothing,
}

/// Limits of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limit {
    Velocity,
    Acceleration,
    Jerk,
}

impl Limit {
    pub const ALL: [Self; 3] = [Self::Velocity, Self::Acceleration, Self::Jerk];

    pub fn name(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Jerk => "jerk",
        }
    }

    fn quantity(self) -> Quantity {
        match self {
            Self::Velocity => Quantity::Speed,
            Self::Acceleration => Quantity::Acceleration,
            Self::Jerk => Quantity::Jerk,
        }
    }
}

/// What ruled over time.
#[derive(Clone, Debug, Default)]
pub struct Ruling {
    /// From, to [s], and what ruled in between; without gaps.
    pub stretches: Vec<(f64, f64, Ruler)>,
}

impl Ruling {
    /// `motors` are the figures of the path's joints; `(from, to)` is the time from the first step to the last [s].
    pub fn of(
        path: &PathJob,
        motors: &Motors,
        contour: &ContourError,
        (from, to): (f64, f64),
    ) -> Self {
        let mut ruling = Self::default();
        let Some(first) = motors.figures.first() else {
            return ruling;
        };
        let (motion, samples) = (&first.motion, first.motion.speed.len());
        let half = (0.5 * motors.window / motion.cell).round() as usize;
        // Shares by figure and limit.
        let mut shares: Vec<(Ruler, Vec<f64>)> = Vec::new();
        for (figure, f) in motors.figures.iter().enumerate() {
            for limit in Limit::ALL {
                let c = &f.channel;
                let most = match limit {
                    Limit::Velocity => c.largest_rate,
                    Limit::Acceleration => c.largest_acceleration,
                    Limit::Jerk => c.largest_jerk,
                };
                let Some(most) = most.filter(|most| *most > 0.0) else {
                    continue;
                };
                let list = limit.quantity().of(&f.motion);
                let list: Vec<f64> = list.iter().map(|x| x.abs() / most).collect();
                let list = match limit {
                    Limit::Velocity => list,
                    _ => largest_within(&list, half),
                };
                shares.push((Ruler::Joint(figure, limit), list));
            }
        }
        let mut place = 0;
        for k in 0..samples {
            let t = motion.time(k);
            if t < from || t > to {
                continue;
            }
            while place + 1 < contour.samples.len() && contour.samples[place + 1].0 <= t {
                place += 1;
            }
            let block = contour.blocks.get(place).copied().unwrap_or(0);
            let mut best = (feed_share(path, motors, block, k), Ruler::Feed);
            for (ruler, list) in &shares {
                if list[k] > best.0 {
                    best = (list[k], *ruler);
                }
            }
            let ruler = if best.0 >= RULES {
                best.1
            } else {
                Ruler::Nothing
            };
            let (begin, end) = (t - 0.5 * motion.cell, t + 0.5 * motion.cell);
            match ruling.stretches.last_mut() {
                Some(last) if last.2 == ruler => last.1 = end.min(to),
                _ => ruling.stretches.push((begin.max(from), end.min(to), ruler)),
            }
        }
        ruling
    }

    /// Time of each ruler [s], the longest first.
    pub fn times(&self) -> Vec<(Ruler, f64)> {
        let mut times: Vec<(Ruler, f64)> = Vec::new();
        for (from, to, ruler) in &self.stretches {
            match times.iter_mut().find(|(known, _)| known == ruler) {
                Some((_, time)) => *time += to - from,
                None => times.push((*ruler, to - from)),
            }
        }
        times.sort_by(|a, b| b.1.total_cmp(&a.1));
        times
    }
}

/// Speed at a sample as a share of the feed of a block: of the joints that it counts for. 0 where there is no feed.
fn feed_share(path: &PathJob, motors: &Motors, block: usize, sample: usize) -> f64 {
    let Some(told) = path
        .blocks
        .get(block)
        .filter(|block| block.duration > 0.0 && block.length > 0.0)
    else {
        return 0.0;
    };
    let counted = path.joints.iter().zip(&motors.figures);
    let counted = counted.filter(|(motor, _)| (**motor < FIRST_TURNING) == told.slides);
    let squares = counted.map(|(_, f)| (f.motion.speed[sample] / f.channel.steps_per_unit).powi(2));
    squares.sum::<f64>().sqrt() * told.duration / told.length
}

/// The largest of each value and those up to `half` before and behind it.
fn largest_within(list: &[f64], half: usize) -> Vec<f64> {
    // Candidates: places whose values fall from front to back.
    let mut candidates: VecDeque<usize> = VecDeque::new();
    let mut largest = Vec::with_capacity(list.len());
    let mut next = 0;
    for middle in 0..list.len() {
        while next < list.len() && next <= middle + half {
            while candidates
                .back()
                .is_some_and(|back| list[*back] <= list[next])
            {
                candidates.pop_back();
            }
            candidates.push_back(next);
            next += 1;
        }
        while candidates
            .front()
            .is_some_and(|front| front + half < middle)
        {
            candidates.pop_front();
        }
        largest.push(candidates.front().map_or(0.0, |front| list[*front]));
    }
    largest
}
