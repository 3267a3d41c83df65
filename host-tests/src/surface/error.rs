//! Why a surface cannot be planned or simulated, and where.

use hexstep::cycles::surface_grinding::GrindingError;
use hexstep::geometry::nurbs::NurbsError;
use std::fmt;

/// What went wrong, with the place.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceError {
    Grinding(GrindingError<f64>, Place),
    /// A parameter of planning, by its name, and what is expected of it.
    BadParameter(&'static str, &'static str),
    TooManyRows,
    /// The front leans over 60 degrees to the row direction.
    FrontFold(Place),
    /// No station has two rows.
    NoGap,
}

/// A place on the part or in a path, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    pub uv: Option<[f64; 2]>,
    /// Row, counted from the seed when planning and from 0 in a path.
    pub row: Option<i64>,
}

impl Place {
    pub const NONE: Self = Self {
        uv: None,
        row: None,
    };

    pub fn at(u: f64, v: f64) -> Self {
        Self {
            uv: Some([u, v]),
            row: None,
        }
    }

    pub fn row(self, row: i64) -> Self {
        Self {
            row: Some(row),
            ..self
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.uv, self.row) {
            (Some([u, v]), Some(row)) => write!(f, " at (u, v) = ({u:.6}, {v:.6}), row {row}"),
            (Some([u, v]), None) => write!(f, " at (u, v) = ({u:.6}, {v:.6})"),
            (None, Some(row)) => write!(f, " in row {row}"),
            (None, None) => Ok(()),
        }
    }
}

impl SurfaceError {
    /// The name under which every interface reports it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Grinding(error, _) => error.name(),
            Self::BadParameter(..) => "BadParameter",
            Self::TooManyRows => "TooManyRows",
            Self::FrontFold(_) => "FrontFold",
            Self::NoGap => "NoGap",
        }
    }

    pub fn field(&self) -> Option<&'static str> {
        match self {
            Self::Grinding(error, _) => error.field().map(|f| f.name()),
            Self::BadParameter(field, _) => Some(field),
            _ => None,
        }
    }

    pub fn place(&self) -> Place {
        match self {
            Self::Grinding(_, place) | Self::FrontFold(place) => *place,
            _ => Place::NONE,
        }
    }

    pub fn at(error: impl Into<GrindingError<f64>>, u: f64, v: f64) -> Self {
        Self::Grinding(error.into(), Place::at(u, v))
    }

    /// The same, in this row.
    pub fn in_row(self, row: i64) -> Self {
        match self {
            Self::Grinding(error, place) => Self::Grinding(error, place.row(row)),
            Self::FrontFold(place) => Self::FrontFold(place.row(row)),
            other => other,
        }
    }
}

impl From<GrindingError<f64>> for SurfaceError {
    fn from(error: GrindingError<f64>) -> Self {
        Self::Grinding(error, Place::NONE)
    }
}

impl From<NurbsError> for SurfaceError {
    fn from(error: NurbsError) -> Self {
        Self::Grinding(error.into(), Place::NONE)
    }
}

impl fmt::Display for SurfaceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Grinding(error, place) => {
                if let Some(field) = error.field() {
                    write!(f, "{}: ", field.name())?;
                }
                write!(f, "{}{place}", error.remedy())
            }
            Self::BadParameter(field, expected) => write!(f, "{field} {expected}"),
            Self::TooManyRows => {
                write!(
                    f,
                    "more than 20000 rows; ask for a larger scallop or a smaller part"
                )
            }
            Self::FrontFold(place) => write!(
                f,
                "the front of rows leans more than 60 degrees{place}; choose another seed or swap u and v"
            ),
            Self::NoGap => write!(
                f,
                "no station has two rows with their middle on the part; give at least two neighbouring rows"
            ),
        }
    }
}

impl std::error::Error for SurfaceError {}
