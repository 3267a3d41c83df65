//! Waypoints -> segments: the foreground's pipe for a job that is a path of poses.
//!
//! ```text
//! Waypoint -> Kinematics::inverse -> Joints -> whole steps -> Planner -> a sample each millisecond -> Segmenter
//! ```
//!
//! The look-ahead is filled before every sample. That makes the pulses a function of the path alone: however the
//! foreground and the step interrupt are interleaved, the planner sees the same blocks at the same sample.

use crate::rig::Feed;
use hexstep::geometry::Waypoint;
use hexstep::joints::Joints;
use hexstep::kinematics::{self, Kinematics};
use hexstep::math::Real;
use hexstep::planner::{Planner, SAMPLES_PER_SECOND, Sample};
use hexstep::stepper::{SegmentSender, Segmenter};

/// Why a waypoint cannot be gone to. Its index counts from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathError {
    /// No joints reach its pose.
    Pose {
        waypoint: usize,
        error: kinematics::Error,
    },
    /// A joint would need more steps than a counter holds.
    Overflow { waypoint: usize },
}

/// Poses to whole steps: the joints' side of a path, without time.
#[derive(Clone, Debug)]
pub struct Stepwise<K, R, const N: usize> {
    pub kinematics: K,
    /// [steps/mm] or [steps/rad].
    pub steps_per_unit: Joints<N, R>,
    near: Joints<N, R>,
    waypoint: usize,
}

impl<K: Kinematics<N, R>, R: Real, const N: usize> Stepwise<K, R, N> {
    /// From the joints' zero on.
    pub fn new(kinematics: K, steps_per_unit: Joints<N, R>) -> Self {
        Self {
            kinematics,
            steps_per_unit,
            near: Joints::default(),
            waypoint: 0,
        }
    }

    /// Joints and whole steps of the next waypoint.
    ///
    /// # Errors
    /// See [`PathError`].
    pub fn next(&mut self, waypoint: &Waypoint<R>) -> Result<(Joints<N, R>, [i32; N]), PathError> {
        let index = self.waypoint;
        self.waypoint += 1;
        let joints = self.kinematics.inverse(&waypoint.pose, &self.near);
        let joints = joints.map_err(|error| PathError::Pose {
            waypoint: index,
            error,
        })?;
        self.near = joints;
        let steps = joints.to_steps(&self.steps_per_unit);
        let steps = steps.ok_or(PathError::Overflow { waypoint: index })?;
        Ok((joints, steps))
    }
}

/// The whole pipe; [`Pipeline::poll`] moves as much as there is room for.
pub struct Pipeline<I, K, R, const N: usize> {
    waypoints: Option<I>,
    stepwise: Stepwise<K, R, N>,
    planner: Planner<N>,
    sample: Option<Sample<N>>,
    taken: usize,
}

impl<I, K, R, const N: usize> Pipeline<I, K, R, N>
where
    I: Iterator<Item = Waypoint<R>>,
    K: Kinematics<N, R>,
    R: Real,
{
    pub fn new(waypoints: I, stepwise: Stepwise<K, R, N>, planner: Planner<N>) -> Self {
        Self {
            waypoints: Some(waypoints),
            stepwise,
            planner,
            sample: None,
            taken: 0,
        }
    }

    /// Waypoints taken so far.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// Fills the queue of segments as far as it goes.
    ///
    /// # Errors
    /// See [`PathError`]; what was sent before it still runs.
    pub fn poll(
        &mut self,
        segmenter: &mut Segmenter<N>,
        queue: &mut SegmentSender<'_, N>,
    ) -> Result<Feed, PathError> {
        let duration = segmenter.timing().hz / SAMPLES_PER_SECOND;
        loop {
            self.look_ahead()?;
            let Some(sample) = self.sample.take().or_else(|| self.planner.next()) else {
                return Ok(Feed::Done);
            };
            match segmenter.advance(&sample.position, duration, sample.last, queue) {
                Ok(true) => {}
                // A reversal has held up the last sample: it is sent once more.
                Ok(false) => self.sample = Some(sample),
                Err(_) => {
                    self.sample = Some(sample);
                    return Ok(Feed::More);
                }
            }
        }
    }

    fn look_ahead(&mut self) -> Result<(), PathError> {
        while let Some(waypoints) = &mut self.waypoints {
            if self.planner.is_full() {
                break;
            }
            let Some(waypoint) = waypoints.next() else {
                self.waypoints = None;
                break;
            };
            let (_, steps) = self.stepwise.next(&waypoint)?;
            // There is room, as was asked above.
            let _ = self.planner.push(steps, waypoint.duration.to_f32());
            self.taken += 1;
        }
        Ok(())
    }
}
