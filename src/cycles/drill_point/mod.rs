//! Grinds the conical point of a two-flute right-hand drill: from the drill's geometry to waypoints.
//!
//! ```text
//! Drill (D, W, 2 phi0, psi, alpha_f) + phi
//!   | solve     closed form                       Cone    (phi, theta, omega; tip from apex Cx, Cy, Cz)
//!   | flank     the flank that a cone leaves      Ground  (the geometry back again)
//!   | stroke    where contact begins and ends     Stroke  (mu_start, mu_end)
//!   | plan      stock into passes                 PassPlan (stand-offs)
//!   | motion    rotation about the cone's axis    Motion  (mu -> rotation and tip displacement)
//!   v cycle     both flanks at every stand-off    Waypoints
//! ```
//!
//! Frames, all right-handed, lengths in mm, angles in rad:
//!
//! * *Cone frame*: origin at the cone's apex, z along the drill from tip to shank, the cone's axis (sin phi, 0, cos phi).
//! * *Lip frame*: the cone frame turned by +omega about z. The lip's direction is (sin phi0, 0, cos phi0), the cone's
//!   axis a = (sin phi cos omega, -sin phi sin omega, cos phi), the tip at (X, Y, Z). Tip-centred, lip 1 is the line
//!   y = -r0, x > 0, its flank on the +y side; flank 2 is flank 1 turned by 180 deg about z.
//! * *Machine frame* at mu = 0: `tom(v) = (v_z, -v_x, -v_y)` of the lip frame.
//!
//! mu is the grinding rotation: 0 with the lip in the wheel's plane, growing towards the heel.
//!
//! Source: Li & Chen, Research on kinematic synthesis of a robot manipulator for drill grinding (equations are cited
//! by its numbers); Armarego & Rotenberg, Int. J. Mach. Tool Des. Res. 13 (1973) 155-164 for the definitions.

mod cycle;
mod error;
mod flank;
mod motion;
mod plan;
mod process;
mod solve;
mod stroke;

pub use cycle::{Cycle, Parameters};
pub use error::{DrillPointError, Field};
pub use flank::{Flank, Ground, Heel, Surface};
pub use motion::{Motion, Variant};
pub use plan::{MAX_STROKES, PassPlan, Passes};
pub use process::DrillMarks;
pub use solve::{Cone, Drill, Solution, Suggestion};
pub use stroke::{HeelWarning, Stroke};

use crate::geometry::Vector;
use crate::math::Real;

/// A vector of the lip frame in the machine frame at mu = 0.
pub fn tom<R: Real>(v: Vector<R>) -> Vector<R> {
    Vector::new(v.z, -v.x, -v.y)
}
