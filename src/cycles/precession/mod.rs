//! Continuous precession of a ball-shaped polishing bonnet: from a surface path with normals to timed tool poses.
//!
//! ```text
//!            F  far point, ell from C along P            points with normals
//!           /                                              | push       one point at a time, O(1) state
//!       P  / theta   n                                     v
//!         /  .      ^      P turns about n at w2         Stretch        N equal times between two points
//!        /  .       |      while C follows the path        | next       one pose, from u = j/N
//!     __/_. ________|                                      v
//!    /  C          \|      C = p + rho n, rho = Rb - h   Stance         phase, frame, C, P, F, tool frame
//!   |   o           |      P = R (sin t cos a,             |
//!    \_____________/            sin t sin a, cos t)        v
//!  ========p=============  surface                       Waypoint
//! ```
//!
//! The bonnet (radius Rb) is pressed in by h and spins about its own axis P, which leans by a constant theta from the
//! normal n and is turned about n while the bonnet is fed along the path: scratches change direction all the time.
//!
//! Frames: the work's, in which points and normals are given, and A = (a, b, n) in the ball's centre, `a` a reference
//! direction in the tangent plane and `b = n x a`. P points away from the surface. Right-handed; lengths in mm, angles in
//! rad, times in s. The phase is an integer fraction of a turn ([`Turn`]): a day of polishing loses nothing of it.
//!
//! Between two points the contact moves straight, the normal turns about `k = n_i x n_(i+1)` by kappa at a constant rate,
//! and `a` is carried along without turning about the normal, so P is continuous for every path: corners, doubled-back
//! passes, turns on the spot.
//!
//! Source: Ji, Chen, Jin, Zhang, Research on motion model for gasbag polishing with continuous precession process
//! (2012), equations (1)-(15); its (7) and (14) have a cosine too many and (15) loses a quadrant. Contact offset, timing,
//! step bounds, corners and pivots are this project's own.

mod cycle;
mod error;
mod frame;
mod parameters;
mod process;
mod spot;
mod stream;
mod stretch;
mod turn;

pub use cycle::{Cycle, Stances};
pub use error::{Field, PrecessionError};
pub use frame::{along_feed, along_heading, angles, axis, tool_frame};
pub use parameters::{Drive, FarEnd, FeedAt, Parameters, Process, Reference};
pub use process::BonnetMarks;
pub use spot::{Surface, contact_radius, rubbing_speed};
pub use stream::{Contact, Precession};
pub use stretch::{Flags, Stance, Stretch};
pub use turn::Turn;
