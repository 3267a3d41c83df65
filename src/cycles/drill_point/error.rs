//! Why a drill cannot be ground as asked.

use crate::math::Real;

/// A parameter of the drill point, by the name it has in every interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    Diameter,
    Web,
    PointAngle,
    ChiselAngle,
    Clearance,
    Phi,
    Theta,
    Omega,
    Cx,
    Cy,
    Cz,
    HeelAngle,
    Target,
    Over,
    MuStep,
    Stock,
    RoughDepth,
    FinishDepth,
    FinishPasses,
    SparkOut,
    Clear,
    StrokeSpeed,
    InfeedSpeed,
    Touch,
}

impl Field {
    pub const fn name(self) -> &'static str {
        match self {
            Field::Diameter => "diameter",
            Field::Web => "web",
            Field::PointAngle => "point_angle",
            Field::ChiselAngle => "chisel_angle",
            Field::Clearance => "clearance",
            Field::Phi => "phi",
            Field::Theta => "theta",
            Field::Omega => "omega",
            Field::Cx => "cx",
            Field::Cy => "cy",
            Field::Cz => "cz",
            Field::HeelAngle => "heel_angle",
            Field::Target => "target",
            Field::Over => "over",
            Field::MuStep => "mu_step",
            Field::Stock => "stock",
            Field::RoughDepth => "rough_depth",
            Field::FinishDepth => "finish_depth",
            Field::FinishPasses => "finish_passes",
            Field::SparkOut => "spark_out",
            Field::Clear => "clear",
            Field::StrokeSpeed => "stroke_speed",
            Field::InfeedSpeed => "infeed_speed",
            Field::Touch => "touch",
        }
    }

    /// What is expected of it, as a sentence.
    pub const fn expected(self) -> &'static str {
        match self {
            Field::Diameter => {
                "diameter must be greater than 0 mm, and a length that a drill can have"
            }
            Field::Web => "web must be greater than 0 mm and less than the diameter",
            Field::PointAngle => "point_angle, the full angle, must be between 0 and 180 deg",
            Field::ChiselAngle => {
                "chisel_angle must be between 0 and 90 deg; where a drawing gives more than 90 deg, its supplement (180 deg less it) is expected"
            }
            Field::Clearance => "clearance must be between 0 and 90 deg",
            Field::Phi => {
                "phi must be greater than 0 deg and less than half the point angle (less than 90 deg where a cone is given)"
            }
            Field::Theta => "theta must be between 0 and 90 deg",
            Field::Omega => "omega must be between -90 and 90 deg",
            Field::Cx => "cx must be a length that the cone can have",
            Field::Cy => {
                "cy must not exceed the radius of the published circle; use the exact variant"
            }
            Field::Cz => "cz must be a length that the cone can have",
            Field::HeelAngle => "heel_angle must be between 0 and 180 deg",
            Field::Target => "target must be an angle",
            Field::Over => "over must be at least 0 and at most 90 deg",
            Field::MuStep => "mu_step must be between 0.001 and 90 deg",
            Field::Stock => "stock must be greater than 0 mm",
            Field::RoughDepth => {
                "rough_depth must be greater than 0 mm, and not so small that 10000 passes are exceeded"
            }
            Field::FinishDepth => {
                "finish_depth must be greater than 0 mm, and not so small that 10000 passes are exceeded"
            }
            Field::FinishPasses => "finish_passes must be a whole number from 0 to 10000",
            Field::SparkOut => "spark_out must be a whole number from 0 to 10000",
            Field::Clear => "clear must be greater than 0 mm",
            Field::StrokeSpeed => "stroke_speed must be greater than 0",
            Field::InfeedSpeed => "infeed_speed must be greater than 0 mm/s",
            Field::Touch => "touch must be a place in the machine frame",
        }
    }
}

/// Why a drill cannot be ground as asked; nothing has been computed then. Angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DrillPointError<R> {
    NotFinite(Field),
    OutOfRange(Field),
    /// The flank would fall below the lip right behind it; `least` is the least admissible clearance.
    ClearanceTooSmall {
        least: R,
    },
    /// No cone with so small an axis angle has this clearance; `phi_min` is the least.
    PhiTooSmall {
        phi_min: R,
    },
    PhiTooLarge,
    /// No tangent plane of the cone has this chisel edge angle.
    NoChisel,
    /// The wanted clearance and chisel angle exclude each other.
    NoTip,
    /// Two tips fit; never seen.
    Ambiguous,
    ApexOverAxis,
    /// The cone is too small for flank 1 to reach the inner end of lip 2.
    NoChiselEnd,
    /// The chisel edge takes the whole radius.
    NoLip,
    /// A point of the drill that the cone does not reach.
    OffCone,
    /// No whole degree of phi gives a feasible drill whose heel the cone reaches.
    NoPhi,
}

impl<R> DrillPointError<R> {
    /// The name under which every interface reports it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::NotFinite(_) => "NotFinite",
            Self::OutOfRange(_) => "OutOfRange",
            Self::ClearanceTooSmall { .. } => "ClearanceTooSmall",
            Self::PhiTooSmall { .. } => "PhiTooSmall",
            Self::PhiTooLarge => "PhiTooLarge",
            Self::NoChisel => "NoChisel",
            Self::NoTip => "NoTip",
            Self::Ambiguous => "Ambiguous",
            Self::ApexOverAxis => "ApexOverAxis",
            Self::NoChiselEnd => "NoChiselEnd",
            Self::NoLip => "NoLip",
            Self::OffCone => "OffCone",
            Self::NoPhi => "NoPhi",
        }
    }

    /// The parameter to look at, where there is one.
    pub const fn field(&self) -> Option<Field> {
        match self {
            Self::NotFinite(field) | Self::OutOfRange(field) => Some(*field),
            Self::ClearanceTooSmall { .. } => Some(Field::Clearance),
            Self::PhiTooSmall { .. } | Self::PhiTooLarge => Some(Field::Phi),
            _ => None,
        }
    }

    /// What was expected and what to do, as a sentence; the figures stand in the error itself.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::NotFinite(_) => "every number must be finite",
            Self::OutOfRange(field) => field.expected(),
            Self::ClearanceTooSmall { .. } => {
                "with so small a clearance the flank would fall below the lip behind it; raise clearance to the least value given here"
            }
            Self::PhiTooSmall { .. } => {
                "no cone with so small an axis angle gives this clearance; raise phi to the least value given here"
            }
            Self::PhiTooLarge => "phi must be less than half the point angle; lower phi",
            Self::NoChisel => {
                "no tangent plane of the cone has this chisel angle; change chisel_angle or phi"
            }
            Self::NoTip => {
                "this clearance and this chisel angle exclude each other; change clearance or chisel_angle"
            }
            Self::Ambiguous => "two tips fit these angles; change phi a little",
            Self::ApexOverAxis => "the cone's apex lies beyond the drill's axis; change phi",
            Self::NoChiselEnd => {
                "the cone is too small for one flank to reach the inner end of the other lip; raise phi or chisel_angle"
            }
            Self::NoLip => {
                "the chisel edge would take the whole radius; reduce web or raise chisel_angle"
            }
            Self::OffCone => {
                "the cone does not reach the tip or the outer corner; check the cone's parameters"
            }
            Self::NoPhi => {
                "no whole degree of phi below half the point angle gives a drill that can be ground and a heel that the cone reaches"
            }
        }
    }
}

/// Names the first number that is not finite, else the first range that does not hold.
pub(super) fn check<R: Real>(
    numbers: &[(Field, R)],
    ranges: &[(Field, bool)],
) -> Result<(), DrillPointError<R>> {
    if let Some((field, _)) = numbers.iter().find(|(_, x)| !x.is_finite()) {
        return Err(DrillPointError::NotFinite(*field));
    }
    match ranges.iter().find(|(_, holds)| !holds) {
        Some((field, _)) => Err(DrillPointError::OutOfRange(*field)),
        None => Ok(()),
    }
}

/// Whether `x` lies between 0 and `limit`, both excluded.
pub(super) fn within<R: Real>(x: R, limit: R) -> bool {
    x > R::ZERO && x < limit
}
