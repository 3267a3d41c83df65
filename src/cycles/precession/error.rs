//! Why a precession cannot be run as asked.

/// A number of the request, by the name it has in every interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    Theta,
    BonnetRadius,
    Inward,
    Feed,
    Rate,
    Pitch,
    Alpha0,
    Alpha,
    Ref,
    Direction,
    Heading,
    Ell,
    Eps,
    Dpsi,
    DtMax,
    WRot,
    Dwell,
    Points,
    Normals,
    SurfaceRadius,
    Spindle,
}

impl Field {
    pub const fn name(self) -> &'static str {
        match self {
            Field::Theta => "theta",
            Field::BonnetRadius => "bonnet_radius",
            Field::Inward => "inward",
            Field::Feed => "feed",
            Field::Rate => "rate",
            Field::Pitch => "pitch",
            Field::Alpha0 => "alpha0",
            Field::Alpha => "alpha",
            Field::Ref => "ref",
            Field::Direction => "direction",
            Field::Heading => "heading",
            Field::Ell => "ell",
            Field::Eps => "eps",
            Field::Dpsi => "dpsi",
            Field::DtMax => "dt_max",
            Field::WRot => "w_rot",
            Field::Dwell => "dwell",
            Field::Points => "points",
            Field::Normals => "normals",
            Field::SurfaceRadius => "surface_radius",
            Field::Spindle => "spindle",
        }
    }
}

/// Why a precession was refused; no pose of the refused call or segment has been emitted then. `index` counts the
/// points from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrecessionError {
    BadTilt,
    BadBonnet,
    BadFeedRate,
    BadRate,
    BadPitch,
    BadLimit(Field),
    /// No point at all, or not one normal for each point.
    BadPath,
    BadNormal {
        index: u32,
    },
    /// The normals of point `index` and of the one before it are opposite.
    AntiParallel {
        index: u32,
    },
    BadDwell,
    NonFinite {
        field: Field,
        index: Option<u32>,
    },
    /// The limits ask for more than 2^31 steps in one segment.
    TooManySteps {
        index: u32,
    },
    /// The phase makes more than 2^31 turns in one segment.
    TooManyTurns {
        index: u32,
    },
    /// The feed runs along the normal: it gives no direction in the tangent plane.
    FeedAlongNormal,
    /// A heading needs a normal that does not point below the xy-plane.
    NormalDown,
    /// The bonnet does not fit into the hollow, or swallows the bump.
    BonnetTooLarge,
}

impl PrecessionError {
    /// The name under which every interface reports it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::BadTilt => "BadTilt",
            Self::BadBonnet => "BadBonnet",
            Self::BadFeedRate => "BadFeedRate",
            Self::BadRate | Self::TooManyTurns { .. } => "BadRate",
            Self::BadPitch => "BadPitch",
            Self::BadLimit(_) | Self::TooManySteps { .. } => "BadLimit",
            Self::BadPath => "BadPath",
            Self::BadNormal { .. } => "BadNormal",
            Self::AntiParallel { .. } => "AntiParallel",
            Self::BadDwell => "BadDwell",
            Self::NonFinite { .. } => "NonFinite",
            Self::FeedAlongNormal => "FeedAlongNormal",
            Self::NormalDown => "NormalDown",
            Self::BonnetTooLarge => "BonnetTooLarge",
        }
    }

    /// The number to look at, where there is one.
    pub const fn field(&self) -> Option<Field> {
        match self {
            Self::BadTilt => Some(Field::Theta),
            Self::BadBonnet => Some(Field::BonnetRadius),
            Self::BadFeedRate => Some(Field::Feed),
            Self::BadRate | Self::TooManyTurns { .. } => Some(Field::Rate),
            Self::BadPitch => Some(Field::Pitch),
            Self::BadLimit(field) => Some(*field),
            Self::BadPath => Some(Field::Points),
            Self::BadNormal { .. } | Self::AntiParallel { .. } => Some(Field::Normals),
            Self::BadDwell => Some(Field::Dwell),
            Self::NonFinite { field, .. } => Some(*field),
            Self::TooManySteps { .. } => None,
            Self::FeedAlongNormal => Some(Field::Direction),
            Self::NormalDown => Some(Field::Heading),
            Self::BonnetTooLarge => Some(Field::SurfaceRadius),
        }
    }

    /// The point at fault, from 0.
    pub const fn index(&self) -> Option<u32> {
        match self {
            Self::BadNormal { index }
            | Self::AntiParallel { index }
            | Self::TooManySteps { index }
            | Self::TooManyTurns { index } => Some(*index),
            Self::NonFinite { index, .. } => *index,
            _ => None,
        }
    }

    /// What was expected and what to do, as a sentence.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::BadTilt => "theta, the tilt between axis and normal, must be from 0 to 85 deg",
            Self::BadBonnet => {
                "bonnet_radius must be greater than 0 mm, and inward at least 0 and less than it"
            }
            Self::BadFeedRate => "feed must be finite and greater than 0 mm/s",
            Self::BadRate => "rate must be a finite angular speed; 0 is a constant lean",
            Self::BadPitch => {
                "pitch, the path length of one turn, must be finite and not 0 mm; for a constant lean leave it out and set rate to 0"
            }
            Self::BadLimit(Field::Ell) => {
                "ell must be at least 0 mm, on the side told by a sign of its own"
            }
            Self::BadLimit(_) => "eps, dpsi, dt_max and w_rot must be greater than 0",
            Self::BadPath => "give at least one point, and exactly one normal for each",
            Self::BadNormal { .. } => "a normal must be finite and longer than 1e-6",
            Self::AntiParallel { .. } => {
                "neighbouring normals must not be opposite; insert points between them"
            }
            Self::BadDwell => "a single point needs a dwell greater than 0 s",
            Self::NonFinite { .. } => "every number must be finite",
            Self::TooManySteps { .. } => {
                "one segment would need more than 2^31 steps; raise eps, dpsi or dt_max, or the feed"
            }
            Self::TooManyTurns { .. } => {
                "the phase would make more than 2^31 turns in one segment; lower rate or raise pitch"
            }
            Self::FeedAlongNormal => {
                "the feed must not run along the normal (sine of the angle at least 1e-3); give another direction"
            }
            Self::NormalDown => {
                "a heading needs a normal that does not point below the xy-plane; give a direction instead"
            }
            Self::BonnetTooLarge => {
                "a hollow must be wider than the bonnet, and a bump wider than half the inward offset"
            }
        }
    }
}
