//! A job with poses -> its pulses: all joints to the first pose, a standstill, then every block of the path.

use super::{Progress, refused};
use crate::job::{AxisLimits, Contour, Job, JobError, PosesJob};
use crate::machine::{Machine, Refusal, StreamItem};
use crate::poses::Plan;
use fixed::types::I32F32;
use hexstep::joints::whole_steps;
use hexstep::path::Target;

/// The limits of all motors in the units of the machine's settings, and its contour: there three motors slide and three
/// turn with one lever for all. Here every motor is told in millimetres of tip: its unit is the arc that its own lever
/// makes, and the lever of the settings, in degrees, makes the same of the three that count as turning.
pub fn limits(poses: &PosesJob, plan: &Plan) -> ([AxisLimits; 6], Contour) {
    let idle = AxisLimits {
        steps_per_unit: 1.0,
        max_rate: 1.0,
        acceleration: 1.0,
        jerk: 1.0,
        travel: (-1.0, 1.0),
    };
    let axes = std::array::from_fn(|i| {
        let Some(joint) = poses.machine.joints.get(i) else {
            return idle;
        };
        let (own, lever) = (&joint.limits, plan.levers[i]);
        AxisLimits {
            steps_per_unit: own.steps_per_unit / lever,
            max_rate: own.max_rate * lever,
            acceleration: own.acceleration * lever,
            jerk: own.jerk * lever,
            travel: (own.travel.0 * lever, own.travel.1 * lever),
        }
    });
    let contour = Contour {
        tolerance: plan.contour,
        // Tip and tool keep to their tolerances all the way.
        rapid_tolerance: 0.0,
        lever: 1.0f64.to_degrees(),
        trim_share: 0.0,
        trim: [0.0; 6],
    };
    (axes, contour)
}

/// A place of the joints in steps.
///
/// # Errors
/// `OutOfTravel` where a joint leaves its travel, at the pose that the stretch leads to.
pub fn steps(
    job: &Job,
    poses: &PosesJob,
    joints: &[f64; 6],
    index: usize,
) -> Result<[I32F32; 6], JobError> {
    let mut steps = [I32F32::ZERO; 6];
    for (motor, (joint, at)) in poses.machine.joints.iter().zip(joints).enumerate() {
        let (lo, hi) = joint.limits.travel;
        let refuse = |detail: String| Err(poses.refuse(job, index, "OutOfTravel", detail));
        // A rounding of the ends is within the travel.
        if *at < lo - 1e-9 || *at > hi + 1e-9 {
            return refuse(format!(
                "{} would go to {at:.6} {}, beyond its travel of {lo} to {hi}",
                joint.name,
                joint.unit()
            ));
        }
        let Some(place) = joint.limits.steps_at(*at) else {
            return refuse(format!("{} leaves the range of a step counter", joint.name));
        };
        steps[motor] = place;
    }
    Ok(steps)
}

/// All targets: the first pose, and the path from there. Both end in a standstill, on whole steps.
///
/// # Errors
/// As [`steps`].
pub fn targets(job: &Job, poses: &PosesJob, plan: &Plan) -> Result<Vec<Target<6>>, JobError> {
    let mut targets = Vec::with_capacity(plan.blocks.len() + 1);
    let start = steps(job, poses, &plan.start, 0)?;
    targets.push(Target::whole(whole_steps(&start), 0.0));
    for block in &plan.blocks {
        targets.push(Target::new(
            steps(job, poses, &block.joints, block.segment + 1)?,
            block.duration as f32,
        ));
    }
    if let Some(last) = targets.last_mut() {
        last.steps = whole_steps(&last.steps).map(I32F32::from);
    }
    Ok(targets)
}

/// Runs the path; returns when it began [counts].
///
/// # Errors
/// `Refused` where the machine does not take a block.
pub fn run(
    job: &Job,
    poses: &PosesJob,
    plan: &Plan,
    targets: &[Target<6>],
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<u64, JobError> {
    let all = targets.len() as u64;
    let (approach, path) = targets.split_at(1.min(targets.len()));
    let mut stream = |machine: &mut Machine<'_>, items: &[Target<6>], before: u64| {
        let list = items.iter().copied().map(StreamItem::Target);
        let streamed = machine.stream(list, |taken| progress((before + taken).min(all), all));
        match streamed {
            Ok(_) => Ok(()),
            Err(Refusal::Start(error)) => Err(refused(job, &format!("error {}", error.number()))),
            Err(Refusal::Item(taken, error)) => {
                let index = match (before + taken).checked_sub(1) {
                    Some(block) => plan
                        .blocks
                        .get(block as usize)
                        .map_or(0, |block| block.segment + 1),
                    None => 0,
                };
                let detail = format!("the machine answers: {error:?}");
                Err(poses.refuse(job, index, "Refused", detail))
            }
        }
    };
    stream(machine, approach, 0)?;
    let start = machine.now();
    stream(machine, path, 1)?;
    Ok(start)
}
