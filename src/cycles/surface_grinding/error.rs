//! Why a surface cannot be ground as asked.

use crate::geometry::nurbs::NurbsError;

/// A parameter of the job, by the name it has in every interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    RRim,
    RCrown,
    Force,
    E1,
    Nu1,
    E2,
    Nu2,
    K,
    Rpm,
    Feed,
    Scallop,
    Margin,
    Eps,
    ELat,
    EGap,
    LMax,
    Turn,
    Depth,
    TargetDepth,
    KF,
    KC,
    KN,
    KG,
    Tau,
    HalfWidth,
    BC,
    H0,
    Y,
}

impl Field {
    pub const fn name(self) -> &'static str {
        match self {
            Field::RRim => "r_rim",
            Field::RCrown => "r_crown",
            Field::Force => "force",
            Field::E1 => "e1",
            Field::Nu1 => "nu1",
            Field::E2 => "e2",
            Field::Nu2 => "nu2",
            Field::K => "k",
            Field::Rpm => "rpm",
            Field::Feed => "feed",
            Field::Scallop => "scallop",
            Field::Margin => "margin",
            Field::Eps => "eps",
            Field::ELat => "e_lat",
            Field::EGap => "e_gap",
            Field::LMax => "l_max",
            Field::Turn => "turn",
            Field::Depth => "depth",
            Field::TargetDepth => "target_depth",
            Field::KF => "k_f",
            Field::KC => "k_c",
            Field::KN => "k_n",
            Field::KG => "k_g",
            Field::Tau => "tau",
            Field::HalfWidth => "half_width",
            Field::BC => "b_c",
            Field::H0 => "h0",
            Field::Y => "y",
        }
    }

    /// What is expected of it, as a sentence.
    pub const fn expected(self) -> &'static str {
        match self {
            Field::RRim | Field::RCrown => {
                "a radius of the wheel must be finite and greater than 0 mm; leave it out where the wheel is flat"
            }
            Field::E1 | Field::E2 => "an elastic modulus must be finite and greater than 0 MPa",
            Field::Nu1 | Field::Nu2 => "Poisson's ratio must be from 0 to 0.5",
            Field::Margin => "margin must be at least 0 and less than 1",
            Field::Feed => {
                "feed must be finite and greater than 0 mm/s, and less than the rim speed if it is with the rim"
            }
            Field::KF | Field::KC | Field::KN | Field::KG | Field::Tau => {
                "a curvature must be finite [1/mm]"
            }
            Field::Y => "y must be finite [mm]",
            Field::TargetDepth => {
                "target_depth must be finite, greater than 0 mm, and more than the wheel takes away at any feed"
            }
            _ => "it must be finite and greater than 0",
        }
    }
}

/// Why a surface cannot be ground as asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GrindingError<R> {
    /// The surface, or a place on it.
    Surface(NurbsError),
    BadMaterial(Field),
    BadParameter(Field),
    /// The bodies do not touch in an ellipse: `least` is their smaller relative curvature [1/mm], not positive.
    NoHertzContact {
        least: R,
    },
    /// The ellipse is so long that it is a line: `ratio` of the relative curvatures is over 1e6.
    LineContact {
        ratio: R,
    },
    /// Half the ellipse, `b_c` [mm], is wider than half the wheel.
    FootprintTooLarge {
        b_c: R,
        half_width: R,
    },
    /// A pass is not deeper than the scallop that it may leave [mm].
    TooShallow {
        h0: R,
        scallop: R,
    },
    /// Summed stripes overlap so far that the hump between the rows is no cusp any more.
    AdditiveBranch {
        h0: R,
        scallop: R,
    },
    /// A pose or a direction that is not finite, or axes that are no rotation.
    BadPose,
}

impl<R> GrindingError<R> {
    /// The name under which every interface reports it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Surface(error) => error.name(),
            Self::BadMaterial(_) => "BadMaterial",
            Self::BadParameter(_) => "BadParameter",
            Self::NoHertzContact { .. } => "NoHertzContact",
            Self::LineContact { .. } => "LineContact",
            Self::FootprintTooLarge { .. } => "FootprintTooLarge",
            Self::TooShallow { .. } => "TooShallow",
            Self::AdditiveBranch { .. } => "AdditiveBranch",
            Self::BadPose => "BadPose",
        }
    }

    /// The parameter to look at, where there is one.
    pub const fn field(&self) -> Option<Field> {
        match self {
            Self::BadMaterial(field) | Self::BadParameter(field) => Some(*field),
            Self::FootprintTooLarge { .. } => Some(Field::HalfWidth),
            Self::TooShallow { .. } | Self::AdditiveBranch { .. } => Some(Field::Scallop),
            _ => None,
        }
    }

    /// What was expected and what to do, as a sentence; the figures stand in the error itself.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::Surface(error) => error.remedy(),
            Self::BadMaterial(field) | Self::BadParameter(field) => field.expected(),
            Self::NoHertzContact { .. } => {
                "the wheel is flatter than the hollow it stands in and touches in no ellipse; take smaller radii, of rim and crown both"
            }
            Self::LineContact { .. } => {
                "one relative curvature is over a million times the other, which is contact along a line; crown the wheel more"
            }
            Self::FootprintTooLarge { .. } => {
                "the ellipse is wider than the wheel; take less force, a stiffer or a wider wheel"
            }
            Self::TooShallow { .. } => {
                "one pass takes away no more than the scallop may be high; grind deeper (slower, harder) or ask for a smaller scallop"
            }
            Self::AdditiveBranch { .. } => {
                "for so small a scallop the hump of the overlap would stand above the cusps; ask for more than 0.1716 of the depth, or use the envelope"
            }
            Self::BadPose => {
                "normal and feed must be finite unit vectors at right angles, the pose a rotation and a finite place"
            }
        }
    }
}

impl<R> From<NurbsError> for GrindingError<R> {
    fn from(error: NurbsError) -> Self {
        Self::Surface(error)
    }
}
