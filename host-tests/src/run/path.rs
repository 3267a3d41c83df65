//! A path job -> its pulses: every block is pushed into the controller's stream, and every cue comes at its millisecond.

use super::{Progress, refused};
use crate::job::{Block, Job, JobError, PathJob, PathPoint};
use crate::machine::{Machine, Refusal, StreamItem};
use hexstep::controller::StreamError;
use hexstep::path::Target;

/// Follows the path from standstill to standstill.
///
/// # Errors
/// `Refused` at the point that the machine does not take.
pub fn run(
    job: &Job,
    path: &PathJob,
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<(), JobError> {
    for cue in &path.cues {
        let added = machine.controller.add_cue(*cue);
        added.map_err(|error| refused(job, &format!("{error:?} at a cue")))?;
    }
    let all = path.blocks.len() as u64;
    let items = path.blocks.iter().zip(&path.points).flat_map(items);
    let streamed = machine.stream(items, |taken| progress(taken.min(all), all));
    match streamed {
        Ok(_) => Ok(()),
        // An operator's stop drops the rest.
        Err(Refusal::Item(_, StreamError::NotStarted)) if path.is_stopped() => Ok(()),
        Err(Refusal::Item(taken, error)) => {
            let detail = format!("the machine answers: {error:?}");
            Err(path.refuse_point(job, taken as usize, "Refused", detail))
        }
        Err(Refusal::Start(error)) => Err(refused(job, &format!("error {}", error.number()))),
    }
}

fn items((block, point): (&Block, &PathPoint)) -> impl Iterator<Item = StreamItem> {
    let target = StreamItem::Target(Target::new(block.steps, block.duration as f32));
    let dwell = (point.dwell > 0.0).then_some(StreamItem::Dwell(point.dwell as f32));
    std::iter::once(target).chain(dwell)
}
