//! What is to be traced, and the machine that traces it: waypoints -> joint targets in steps.
//!
//! Targets lie where the path is, between steps too: only a standstill rests on whole ones, and the planner sees to that. A
//! target rounded to a step is a corner that the path does not have.

pub mod arm;
pub mod pair;
pub mod points;

use crate::cycles::drill_point::{Cycle, DrillMarks};
use crate::cycles::{Pace, Process};
use crate::joints::{Joints, whole_steps};
use crate::kinematics::Kinematics;
use crate::kinematics::follow::Feed;
use crate::machines::drill_grinder::DrillGrinder;
use fixed::types::I32F32;

/// Why a waypoint cannot be a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathError {
    /// The pose is beyond what the machine can reach.
    OutOfReach,
    /// This joint would leave its travel.
    OutOfTravel { joint: usize },
}

/// A target of all joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target<const N: usize> {
    /// Where [steps].
    pub steps: [I32F32; N],
    /// The least time to it [s]; 0: a rapid.
    pub duration: f32,
    /// How far the way to it may be left [mm], within what is set for rapids; 0 where only the tolerance of the path will do.
    /// Right behind a target at a feed it is not free, whatever this says.
    pub free: f32,
}

impl<const N: usize> Target<N> {
    /// A target that nothing but its duration is known of: a rapid is free to leave its way as far as is set.
    pub fn new(steps: [I32F32; N], duration: f32) -> Self {
        Self {
            steps,
            duration,
            free: if duration > 0.0 { 0.0 } else { f32::INFINITY },
        }
    }

    /// The same on whole steps.
    pub fn whole(steps: [i32; N], duration: f32) -> Self {
        Self::new(steps.map(I32F32::from_num), duration)
    }
}

/// What turns joints into steps, and how far they may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale<const N: usize> {
    /// Steps per mm or radian.
    pub steps_per_unit: Joints<N>,
    /// Ends of the travel [steps].
    pub lower: [i32; N],
    pub upper: [i32; N],
}

/// A drill cycle on its machine. An iterator of targets; a copy can be walked for checking.
#[derive(Clone, Debug)]
pub struct DrillPath {
    marks: DrillMarks<f32>,
    machine: DrillGrinder<f32>,
    scale: Scale<6>,
    /// Joints of the last target: turns and the singular pose are chosen near them.
    near: Joints<6>,
    begun: bool,
    held: Option<Target<6>>,
}

/// Share of the retraction that ways clear of the wheel may take up with their roundings: 0.05 mm of 3 mm.
const SHARE: f32 = 1.0 / 60.0;

/// The joint that moves the drill straight away from the wheel.
const D2: usize = 1;

impl DrillPath {
    /// The cycle, starting from joints `near`.
    pub fn new(
        mut cycle: Cycle<f32>,
        machine: DrillGrinder<f32>,
        scale: Scale<6>,
        near: Joints<6>,
    ) -> Self {
        let Ok(marks) = cycle.finish();
        Self {
            marks,
            machine,
            scale,
            near,
            begun: false,
            held: None,
        }
    }

    /// Strokes begun so far, and how many there are.
    pub fn progress(&self) -> (u32, u32) {
        (self.marks.rest().pass(), self.marks.rest().plan().strokes())
    }
}

impl Iterator for DrillPath {
    type Item = Result<Target<6>, PathError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(target) = self.held.take() {
            return Some(Ok(target));
        }
        let mark = self.marks.next()?;
        let joints = match self.machine.inverse(&mark.end, &self.near) {
            Ok(joints) => joints,
            Err(_) => return Some(Err(PathError::OutOfReach)),
        };
        let duration = match mark.pace {
            Pace::Feed(Feed::Time(time)) => time,
            _ => 0.0,
        };
        let mut target = match self.scale.target(&joints, duration) {
            Ok(target) => target,
            Err(error) => return Some(Err(error)),
        };
        if duration <= 0.0 {
            target.free = SHARE * self.marks.rest().clear();
        }
        let from = self.near;
        self.near = joints;
        if !self.begun {
            self.begun = true;
            // Away from the wheel before anything turns, wherever the machine stands.
            // Not a bit sooner: that way is not free.
            if from[D2] < joints[D2] {
                let mut away = from;
                away[D2] = joints[D2];
                self.held = Some(target);
                return Some(self.scale.target(&away, 0.0));
            }
        }
        Some(Ok(target))
    }
}

impl<const N: usize> Scale<N> {
    /// Steps for joints, or which of them would leave its travel. The way there is not free.
    pub fn target(&self, joints: &Joints<N>, duration: f32) -> Result<Target<N>, PathError> {
        let steps = joints
            .to_steps(&self.steps_per_unit)
            .ok_or(PathError::OutOfReach)?;
        match self.beyond(&steps) {
            Some(joint) => Err(PathError::OutOfTravel { joint }),
            None => Ok(Target {
                steps,
                duration,
                free: 0.0,
            }),
        }
    }

    /// The first `M` motors alone; `None` if there are fewer.
    pub fn first<const M: usize>(&self) -> Option<Scale<M>> {
        Some(Scale {
            steps_per_unit: Joints(*self.steps_per_unit.0.first_chunk()?),
            lower: *self.lower.first_chunk()?,
            upper: *self.upper.first_chunk()?,
        })
    }

    /// The first joint that is not within its travel, rounded to whole steps as for a standstill there.
    pub fn beyond(&self, steps: &[I32F32; N]) -> Option<usize> {
        let steps = whole_steps(steps);
        (0..N).find(|i| steps[*i] < self.lower[*i] || steps[*i] > self.upper[*i])
    }

    /// Joints at whole steps.
    pub fn joints(&self, steps: &[i32; N]) -> Joints<N> {
        Joints(core::array::from_fn(|i| {
            steps[i] as f32 / self.steps_per_unit[i]
        }))
    }
}
