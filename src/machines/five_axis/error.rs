//! What can be wrong with a five-axis machine or with what is asked of it.

use crate::joints::Joints;

/// A joint of a five-axis machine, in the order of its joint values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
    Z,
    Primary,
    Secondary,
}

impl Axis {
    pub const ALL: [Self; 5] = [Self::X, Self::Y, Self::Z, Self::Primary, Self::Secondary];

    pub fn name(self) -> &'static str {
        match self {
            Self::X => "X",
            Self::Y => "Y",
            Self::Z => "Z",
            Self::Primary => "primary",
            Self::Secondary => "secondary",
        }
    }
}

/// Why a machine or a pose is refused. Nothing moves, no partial result exists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error<R> {
    /// A number is NaN or infinite, or too large to be computed with.
    NonFinite { field: &'static str },
    /// A tool direction is shorter than 1e-6.
    BadDirection { field: &'static str },
    /// The direction of an axis is shorter than 1e-6, or `rw` is not a rotation.
    BadAxis { field: &'static str },
    /// The rotary axes are parallel: |m1 x m2| < 1e-3.
    ParallelAxes,
    /// The axis next to the tool is parallel to the tool: |m2 x v1| < 1e-3.
    ToolAlongAxis,
    /// |det E| < 1e-3 for unit directions of the linear axes.
    LinearAxesDependent,
    /// A travel with lo > hi, a weight or a speed <= 0.
    BadLimit { field: &'static str },
    /// No joint angles give this direction. `gap` [rad] is missing to the band of reachable tilts; `nearest` are the
    /// joints [mm, rad] of the nearest direction, with the tip in place, travel not looked at.
    Unreachable { gap: R, nearest: Joints<5, R> },
    /// Every solution, or the chosen one's linear part, leaves the travel of this axis.
    OutOfTravel { axis: Axis },
}

impl<R> Error<R> {
    /// The name that the specification gives.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NonFinite { .. } => "NonFinite",
            Self::BadDirection { .. } => "BadDirection",
            Self::BadAxis { .. } => "BadAxis",
            Self::ParallelAxes => "ParallelAxes",
            Self::ToolAlongAxis => "ToolAlongAxis",
            Self::LinearAxesDependent => "LinearAxesDependent",
            Self::BadLimit { .. } => "BadLimit",
            Self::Unreachable { .. } => "Unreachable",
            Self::OutOfTravel { .. } => "OutOfTravel",
        }
    }
}
