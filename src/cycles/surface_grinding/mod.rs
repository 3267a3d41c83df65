//! Grinds a free-form surface in rows: from the curvature under the wheel to the pitch of the rows and the step along them.
//!
//! ```text
//! geometry::nurbs::Section (k_f, k_c, tau)
//!   | contact   Hertz: the ellipse under the wheel       Contact  (a, b; half extents b_c across, a_f along)
//!   | removal   Preston: what a pass takes away          Stripe   h(y) = h0 (1 - y^2/b_c^2)
//!   | spacing   the pitch that leaves the wanted scallop Pitch
//!   | step      the chord that keeps to the tolerance    Step
//!   v pose      contact, normal, feed                    Pose of the wheel, of the flange
//! ```
//!
//! mm, N, MPa (= N/mm2), s, rad; curvatures in 1/mm, positive where a body bulges. Along is with the feed, across is the
//! wheel's axle. Everything here is one contact at a time and runs on the target; rows of a whole surface are planned by
//! the host with the same functions in `f64`.
//!
//! Source of the idea: Zhan, Jiang, Li, Wu, Curvature adaptive planning algorithm for robot surface grinding trajectory,
//! 2022, doi 10.3969/j.issn.1674-8085.2022.01.013; the equations are derived anew where the paper leaves them open.

mod contact;
mod ellipse;
mod error;
mod grinding;
mod pose;
mod removal;
mod rows;
mod spacing;
mod step;

pub use contact::{Contact, Hertz, Material, Wheel, effective_modulus};
pub use error::{Field, GrindingError};
pub use grinding::{Depth, Grinding, Job};
pub use pose::{flange, tool_pose, wheel_pose};
pub use removal::{Removal, Sense, Stripe};
pub use rows::{RowPoint, Rows};
pub use spacing::{Model, Pitch, pitch};
pub use step::{Limit, Step, StepLimits};
