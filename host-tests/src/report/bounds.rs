//! A path of joints -> the times that its own limits allow: length over feed with a ramp at either end, and the sum of its
//! blocks from rest to rest.
//!
//! ```text
//!   speed |      ____________             |    _     _    _
//!         |     /            \            |   / \   / \  / \
//!         |____/              \____       |__/   \_/   \/   \__
//!           length / feed, two ramps         rest to rest
//! ```
//!
//! No motion with these limits is faster than the first along a line without corners, and none needs to be slower than
//! the second. A ramp to speed v with acceleration a and jerk j takes v / a + a / j, or 2 sqrt(v / j) where v is reached
//! before a; half of it is what it costs beside running at v from the start. Velocity, acceleration and jerk along a
//! block are those that none of its joints exceeds.

use crate::job::PathJob;

/// Times of a path [s]; operators' cues are not in them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// All blocks at their feed, or as fast as their joints go, and ramps from and to every standstill.
    pub feed: f64,
    /// All blocks from rest to rest.
    pub rest: f64,
}

/// What a block may do, its length being 1.
#[derive(Clone, Copy)]
struct Along {
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

impl Bounds {
    pub fn of(path: &PathJob) -> Self {
        let mut bounds = Self::default();
        let share = 1.0 - path.contour.trim_share;
        let mut from = [0.0; 6];
        // Blocks since the last standstill.
        let mut run: Vec<Along> = Vec::new();
        for (point, block) in path.points.iter().zip(&path.blocks) {
            let slowest = |limit: &dyn Fn(usize) -> f64| {
                let times = (0..6).map(|i| share * limit(i) / (point.at[i] - from[i]).abs());
                times.fold(f64::INFINITY, f64::min)
            };
            let along = Along {
                velocity: slowest(&|i| path.axes[i].max_rate).min(1.0 / block.duration),
                acceleration: slowest(&|i| path.axes[i].acceleration),
                jerk: slowest(&|i| path.axes[i].jerk),
            };
            if point.at != from {
                bounds.rest += optimum(1.0, along);
                run.push(along);
            }
            if point.dwell > 0.0 {
                bounds.feed += at_feed(&run) + point.dwell;
                bounds.rest += point.dwell;
                run.clear();
            }
            from = point.at;
        }
        bounds.feed += at_feed(&run);
        bounds
    }
}

/// Blocks from a standstill to the next [s].
fn at_feed(run: &[Along]) -> f64 {
    let (Some(first), Some(last)) = (run.first(), run.last()) else {
        return 0.0;
    };
    let whole: f64 = run.iter().map(|along| 1.0 / along.velocity).sum();
    let ramps = 0.5 * (ramp(*first) + ramp(*last));
    if ramps <= whole {
        return whole + ramps;
    }
    // Too short for its speed: measured by the time at that speed, along whichever end is the quicker.
    let scaled = |along: &Along| Along {
        velocity: 1.0,
        acceleration: along.acceleration / along.velocity,
        jerk: along.jerk / along.velocity,
    };
    optimum(whole, scaled(first)).min(optimum(whole, scaled(last)))
}

/// Time to come from rest to the velocity [s].
fn ramp(along: Along) -> f64 {
    let (v, a, j) = (along.velocity, along.acceleration, along.jerk);
    if v * j < a * a {
        2.0 * (v / j).sqrt()
    } else {
        v / a + a / j
    }
}

/// Least time of a way from rest to rest [s].
fn optimum(way: f64, along: Along) -> f64 {
    let velocity = along.velocity;
    let at = |velocity: f64| ramp(Along { velocity, ..along });
    if velocity * at(velocity) <= way {
        return way / velocity + at(velocity);
    }
    // The largest speed that a ramp up and a ramp down leave room for.
    let (mut low, mut high) = (0.0, velocity);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if middle * at(middle) <= way {
            low = middle;
        } else {
            high = middle;
        }
    }
    2.0 * at(low)
}
