//! A path under continuous precession -> timed poses of the bonnet: the library's cycle, in `f64`.
//!
//! The tip of the machine's tool is the ball's centre C, its axis is P, and the x axis of an arm's tool that of the
//! turn-free frame, so that the last wrist joint does not wind up. Source: specification of continuous precession.

use crate::job::{Job, JobError, Model, Pace, PoseRow, PosesJob, PrecessionJob};
use hexstep::cycles::precession::{Flags, Stance};

/// What a precession has become.
#[derive(Clone, Debug)]
pub struct PrecessionMade {
    pub stances: Vec<Stance<f64>>,
    /// Steps of each segment.
    pub steps: Vec<u32>,
    pub flags: Flags,
    pub poses: PosesJob,
}

impl PrecessionMade {
    pub(super) fn of(job: &Job, precession: &PrecessionJob) -> Result<Self, JobError> {
        let cycle = precession.cycle(job)?;
        let segments: Vec<_> = cycle.segments().collect();
        let stances: Vec<Stance<f64>> = cycle.stances().collect();
        let is_arm = matches!(precession.machine.model, Model::Arm { .. });
        let row = |stance: &Stance<f64>| PoseRow {
            tip: stance.centre.to_array(),
            axis: stance.axis.to_array(),
            across: is_arm.then(|| stance.tool().n.to_array()),
            // The first pose has no stretch before it.
            pace: if stance.dt > 0.0 {
                Pace::InverseTime(stance.inverse_time())
            } else {
                Pace::Rapid
            },
        };
        let told = |stance: &Stance<f64>| {
            format!(
                "segment {} of the path, at {:.4} of it, {:.3} s",
                stance.segment, stance.u, stance.time
            )
        };
        let made = PosesJob::made(
            &precession.machine,
            &precession.motion,
            stances.iter().map(row).collect(),
            precession.points_key(),
            stances.iter().map(told).collect(),
        );
        Ok(Self {
            steps: segments.iter().map(|s| s.steps()).collect(),
            flags: segments
                .iter()
                .fold(Flags::default(), |flags, s| flags.or(s.flags())),
            stances,
            poses: made,
        })
    }

    /// Length of the polyline of far points [mm].
    pub fn far_length(&self) -> f64 {
        let pairs = self.stances.windows(2);
        pairs.map(|pair| (pair[1].far - pair[0].far).norm()).sum()
    }

    /// Largest turn of the axis between neighbouring poses [deg].
    pub fn largest_turn(&self) -> f64 {
        let turns = self
            .stances
            .windows(2)
            .map(|pair| pair[0].axis.angle_to(pair[1].axis));
        turns.fold(0.0, f64::max).to_degrees()
    }

    /// Largest difference of the axis's tilt to the normal from the one asked for [deg].
    pub fn tilt_error(&self, theta: f64) -> f64 {
        let tilts = self
            .stances
            .iter()
            .map(|s| (s.axis.angle_to(s.frame.a) - theta).abs());
        tilts.fold(0.0, f64::max).to_degrees()
    }
}
