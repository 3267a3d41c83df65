//! Segments of a plan to poses of the wheel and of the flange, with the feed of each stretch.

use super::plan::Segment;
use super::{Job, Part, SurfaceError};
use hexstep::cycles::surface_grinding::{GrindingError, Sense, flange, tool_pose};
use hexstep::geometry::Pose;
use hexstep::geometry::nurbs::NurbsError;

/// One point of a segment as the machine sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPoint {
    /// Contact point, z into the part, x with the feed, in the work frame [mm].
    pub tool: Pose<f64>,
    /// Of the flange, in the frame that the work frame is given in [mm].
    pub flange: Pose<f64>,
    /// Speed over the part here [mm/s].
    pub feed: f64,
}

/// The poses of a segment in the order in which they are ground.
///
/// `work` is the part's frame in the machine, `tool` the length of the tool from the flange [mm]. With `zigzag` rows of
/// odd number are ground from their end: the feed turns round and with it the sense.
pub fn poses(
    part: &Part,
    job: &Job,
    segment: &Segment,
    work: &Pose<f64>,
    tool: f64,
    zigzag: bool,
) -> Result<Vec<ToolPoint>, SurfaceError> {
    let back = zigzag && segment.row % 2 == 1;
    let mut job = *job;
    if back {
        job.process.sense = match job.process.sense {
            Sense::Against => Sense::With,
            Sense::With => Sense::Against,
            Sense::Neglected => Sense::Neglected,
        };
    }
    let grinding = job.check()?;
    let towards = if back { -1.0 } else { 1.0 };
    let mut list = Vec::with_capacity(segment.points.len());
    for point in &segment.points {
        let [u, v] = point.uv;
        let at = |e: GrindingError<f64>| SurfaceError::at(e, u, v).in_row(segment.row as i64);
        let shape = part.tool_shape(u, v).map_err(|e| at(e.into()))?;
        let section = shape
            .along(towards, towards * point.slope)
            .ok_or(at(NurbsError::DegenerateNormal.into()))?;
        let contact = grinding.hertz.on(&section).map_err(at)?;
        let contact = match job.half_width {
            Some(half_width) => contact.within(half_width).map_err(at)?,
            None => contact,
        };
        let pose = tool_pose(&shape, &section).map_err(at)?;
        list.push(ToolPoint {
            tool: pose,
            flange: flange(work, &pose, tool).map_err(at)?,
            feed: grinding.feed(&contact, job.process.feed).map_err(at)?,
        });
    }
    if back {
        list.reverse();
    }
    Ok(list)
}
