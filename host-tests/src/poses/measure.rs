//! Pulses -> how far the tool was off its path, through a forward map that shares nothing with the library.
//!
//! Every millisecond the joints, as the pulses make them, are taken forward, and the place of the path is sought that is
//! nearest in tip and direction together, each by its tolerance. The error of both is that against this one place.

use crate::job::{PoseRow, PosesJob};
use crate::reference::matrix::{angle_deg, distance};
use crate::reference::serial::ToolAt;
use crate::trace::{TICK_HZ, Trace, seconds};

/// One look at the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// [s]
    pub time: f64,
    pub tool: ToolAt,
    /// Tip off the path [mm], tool off its direction [deg].
    pub tip: f64,
    pub angle: f64,
}

/// What the pulses made of a path.
#[derive(Clone, Debug)]
pub struct Measured {
    /// One a millisecond, from the start of the path to its end.
    pub samples: Vec<Sample>,
    /// Largest errors [mm, deg].
    pub tip: f64,
    pub angle: f64,
    /// Root of the mean of the squares [mm].
    pub tip_rms: f64,
}

type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: V, b: V) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn norm(a: V) -> f64 {
    dot(a, a).sqrt()
}

fn scaled(a: V, by: f64) -> V {
    a.map(|x| x * by)
}

fn add(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] + b[i])
}

/// `v` turned about the unit vector `k`.
fn turned(v: V, k: V, angle: f64) -> V {
    let (sin, cos) = angle.sin_cos();
    let along = dot(k, v) * (1.0 - cos);
    add(
        add(scaled(v, cos), scaled(cross(k, v), sin)),
        scaled(k, along),
    )
}

/// Axis (unit, or zero) and angle [rad] of the shortest turn from one tool to another.
fn turn_between(from: &PoseRow, to: &PoseRow) -> (V, f64) {
    match (from.across, to.across) {
        (Some(x0), Some(x1)) => frames_between(from.axis, x0, to.axis, x1),
        _ => {
            let normal = cross(from.axis, to.axis);
            let size = norm(normal);
            let angle = size.atan2(dot(from.axis, to.axis));
            let axis = if size > 1e-15 {
                scaled(normal, 1.0 / size)
            } else {
                [0.0; 3]
            };
            (axis, angle)
        }
    }
}

/// The same for frames given by two of their axes each, by the quaternion of the turn (Shepperd's largest component).
fn frames_between(z0: V, x0: V, z1: V, x1: V) -> (V, f64) {
    let (y0, y1) = (cross(z0, x0), cross(z1, x1));
    // R = sum of (new axis) (old axis)^T
    let r = |i: usize, j: usize| x1[i] * x0[j] + y1[i] * y0[j] + z1[i] * z0[j];
    let trace = r(0, 0) + r(1, 1) + r(2, 2);
    let squares = [trace, r(0, 0), r(1, 1), r(2, 2)];
    let largest = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b]));
    let skew = [r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)];
    let (w, v) = match largest {
        Some(0) | None => (1.0 + trace, skew),
        Some(k) => {
            let i = k - 1;
            let mut v = [0.0; 3];
            for (j, v) in v.iter_mut().enumerate() {
                *v = if i == j {
                    1.0 + 2.0 * r(i, i) - trace
                } else {
                    r(i, j) + r(j, i)
                };
            }
            (skew[i], v)
        }
    };
    let size = norm(v);
    if size < 1e-15 {
        return ([0.0; 3], 0.0);
    }
    let (w, v) = if w < 0.0 {
        (-w, scaled(v, -1.0))
    } else {
        (w, v)
    };
    (scaled(v, 1.0 / size), 2.0 * size.atan2(w))
}

/// A stretch from pose to pose.
struct Stretch<'a> {
    from: &'a PoseRow,
    to: &'a PoseRow,
    way: V,
    length: f64,
    /// Axis and angle of the turn [rad].
    axis: V,
    angle: f64,
}

/// What a millimetre and a radian weigh.
struct Weights {
    tip: f64,
    angle: f64,
}

impl<'a> Stretch<'a> {
    fn new(from: &'a PoseRow, to: &'a PoseRow) -> Self {
        let way = sub(to.tip, from.tip);
        let (axis, angle) = turn_between(from, to);
        Self {
            from,
            to,
            way,
            length: norm(way),
            axis,
            angle,
        }
    }

    /// Wanted tip, axis and x axis at `u`.
    fn at(&self, u: f64) -> (V, V, Option<V>) {
        let tip = add(self.from.tip, scaled(self.way, u));
        let turn = |v| turned(v, self.axis, self.angle * u);
        (tip, turn(self.from.axis), self.from.across.map(turn))
    }

    /// The nearest place: tip and turn each have theirs, and the weighted mean of both is the best of all as long as the
    /// errors are small.
    fn nearest(&self, tool: &ToolAt, weights: &Weights) -> f64 {
        let by_tip = weights.tip * self.length;
        let by_turn = weights.angle * self.angle;
        let (tip, turn) = (by_tip * by_tip, by_turn * by_turn);
        if tip + turn <= 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        if tip > 0.0 {
            let along = dot(sub(tool.tip, self.from.tip), self.way);
            sum += tip * along / (self.length * self.length);
        }
        if turn > 0.0 {
            let back = match (self.from.across, tool.across) {
                (Some(x0), Some(x1)) => {
                    let (axis, angle) = frames_between(self.from.axis, x0, tool.axis, x1);
                    dot(axis, self.axis) * angle
                }
                _ => {
                    let across = cross(self.axis, self.from.axis);
                    dot(tool.axis, across).atan2(dot(tool.axis, self.from.axis))
                }
            };
            sum += turn * back / self.angle;
        }
        (sum / (tip + turn)).clamp(0.0, 1.0)
    }

    /// Errors at `u` [mm, deg].
    fn off(&self, tool: &ToolAt, u: f64) -> (f64, f64) {
        let (tip, axis, across) = if u >= 1.0 {
            (self.to.tip, self.to.axis, self.to.across)
        } else {
            self.at(u)
        };
        let angle = match (across, tool.across) {
            (Some(x0), Some(x1)) => frames_between(axis, x0, tool.axis, x1).1.to_degrees(),
            _ => angle_deg(axis, tool.axis),
        };
        (distance(tip, tool.tip), angle)
    }
}

/// The tool at joints of a job [mm, deg].
pub fn tool_at(poses: &PosesJob, joints: &[f64; 6]) -> ToolAt {
    let machine = &poses.machine;
    let q = std::array::from_fn(|i| {
        let joint = machine.joints.get(i);
        joint.map_or(0.0, |joint| joint.to_library(joints[i]))
    });
    machine.forward.at(&q)
}

impl Measured {
    /// Looks at the pulses from `from` [counts] on.
    pub fn of(poses: &PosesJob, trace: &Trace<6>, from: u64) -> Self {
        let stretches: Vec<Stretch<'_>> = poses
            .rows
            .windows(2)
            .map(|pair| Stretch::new(&pair[0], &pair[1]))
            .collect();
        let weights = Weights {
            tip: 1.0 / poses.tip_tolerance,
            angle: 1.0 / poses.axis_tolerance.to_radians(),
        };
        let every = TICK_HZ / 1000;
        let steps: [f64; 6] = std::array::from_fn(|i| {
            let joint = poses.machine.joints.get(i);
            joint.map_or(1.0, |joint| joint.limits.steps_per_unit)
        });
        let mut here = 0;
        let mut samples = Vec::new();
        let first = from.div_ceil(every);
        for (k, row) in (0u64..).zip(trace.rebuilt_every(every)) {
            if k < first {
                continue;
            }
            let joints = std::array::from_fn(|i| row[i] / steps[i]);
            let tool = tool_at(poses, &joints);
            // The path is run through in order: of this stretch and those right behind it the one that fits best. The
            // next ones are looked at as well, for a stretch may be shorter than a millisecond.
            let last = (here + 8).min(stretches.len());
            let mut best: Option<(f64, usize, f64, f64)> = None;
            for (index, stretch) in stretches.iter().enumerate().take(last).skip(here) {
                let u = stretch.nearest(&tool, &weights);
                let (tip, angle) = stretch.off(&tool, u);
                let cost =
                    (tip * weights.tip).powi(2) + (angle.to_radians() * weights.angle).powi(2);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, index, tip, angle));
                }
            }
            let Some((_, index, tip, angle)) = best else {
                break;
            };
            here = index;
            samples.push(Sample {
                time: seconds(k * every),
                tool,
                tip,
                angle,
            });
        }
        let largest = |f: fn(&Sample) -> f64| samples.iter().map(f).fold(0.0, f64::max);
        let squares: f64 = samples.iter().map(|s| s.tip * s.tip).sum();
        Self {
            tip: largest(|s| s.tip),
            angle: largest(|s| s.angle),
            tip_rms: (squares / samples.len().max(1) as f64).sqrt(),
            samples,
        }
    }
}
