//! Plans the rows of a whole surface and simulates what they leave, in `f64` on the host.
//!
//! ```text
//! Part (NURBS) + Job
//!   | front      rows as graphs v = f_i(u), marched from the seed       Rows
//!   | stations   points along them, chord and lateral sag kept          (u lists)
//!   | plan       rows clipped at the edge, in segments                  Plan (polylines)
//!   | poses      wheel and flange poses, feed                           -> joints (arm)
//!   v residual   an independent simulation of the ground profile        Residual
//! ```
//!
//! Contact, removal, spacing and the surface itself are those of the library. mm, N, MPa, s, rad.
//! One thread: rows of the hard job on Dune well below a second, residual at 60 stations below two.

mod error;
mod fewest;
mod front;
mod job;
pub mod joints;
mod part;
mod plan;
mod poses;
mod residual;
mod spline;
mod stations;

pub use error::{Place, SurfaceError};
pub use fewest::{Fewest, fewest_iso};
pub use front::{Row, Rows};
pub use job::{Job, MAX_ROWS, StepMode, Strategy};
pub use part::{Part, dune};
pub use plan::{Plan, Point, Segment};
pub use poses::{ToolPoint, poses};
pub use residual::{Gap, PathRow, Residual, gaps, residual, residual_of_gaps};
