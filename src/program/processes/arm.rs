//! A six-axis arm: `$KIN=ARM6R`, `$PRECESS` and `$SURF`.
//!
//! | parameter | unit | what |
//! |---|---|---|
//! | `A` a1, a2, a3; `D` d1, d4, d6 | mm | the arm's lengths, those of an ER3B unless set; its ranges are `$1040`, `$1050` |
//! | `TOOL` | mm | from the flange to the tip: the bonnet's centre, the wheel's contact |
//! | `WORK` x, y, z | mm | the work's origin in the base, axes parallel |
//! | `BRANCH` | | 0 ..= 7, or -1: the one with the least turning to the first point |
//! | `AXIS` | deg | how far the tool may lean from where it should |

use super::fed::{Begun, Fed, Machine, Told};
use super::given::{Given, MOST, Numbers, Parameter, parameter, vector};
use super::precess::{self, PRECESS};
use super::surf::{self, SURF};
use super::{Order, Standing, say};
use crate::error::Error;
use crate::geometry::{Pose, Vector};
use crate::joints::Joints;
use crate::kinematics::follow::Tolerance;
use crate::machines::arm::{Arm, Lengths, OneBranch, Refusal};
use crate::math::Real;
use crate::path::arm::{ArmWork, SurfacePoint, WorkError};
use crate::path::points::{PointPath, Shop, left_for_corners};
use crate::program::list::whole;
use core::fmt::Write;

const KIN: [Parameter; 6] = [
    parameter("A", 0, 3),
    parameter("D", 3, 3),
    parameter("TOOL", 6, 1),
    parameter("WORK", 7, 3),
    parameter("BRANCH", 10, 1),
    parameter("AXIS", 11, 1),
];

/// Share of the tolerances that the chords of the joints may use; the rest is for the planner's corners.
const CHORDS: f32 = 0.85;
/// Where nobody says otherwise, the branch is chosen.
const ANY: f32 = -1.0;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Asked {
    #[default]
    Precess,
    Surf,
}

/// An arm with its tools, fed with points.
pub type ArmProcesses = Fed<Arm6, 6>;

/// An arm with its tools.
pub struct Arm6 {
    /// The arm is the machine; else the motors are what they were.
    pub(super) is_chosen: bool,
    numbers: Numbers<12>,
    precess: Given<{ PRECESS.len() }>,
    surf: Given<{ SURF.len() }>,
    asked: Asked,
}

impl Default for Arm6 {
    fn default() -> Self {
        Self {
            is_chosen: true,
            numbers: Numbers {
                table: &KIN,
                values: [
                    50.0, 270.0, 70.0, 320.0, 299.0, 78.5, 0.0, 0.0, 0.0, 0.0, ANY, 0.05,
                ],
            },
            precess: Given::new(&PRECESS),
            surf: Given::new(&SURF),
            asked: Asked::Precess,
        }
    }
}

/// The lengths of the arm, its tool, and where the work is.
fn lengths(values: &[f32; 12]) -> Lengths<f32> {
    let [a1, a2, a3, d1, d4, d6, ..] = *values;
    Lengths {
        a1,
        a2,
        a3,
        d1,
        d4,
        d6,
    }
}

fn check_kin(values: &[f32; 12], out: &mut dyn Write) -> Result<(), Error> {
    let full = [[-1.0, 1.0]; 6];
    let [.., branch, axis] = *values;
    let good = Arm::new(lengths(values), full).is_ok()
        && values.iter().all(|value| value.is_finite())
        && (branch == ANY || whole(branch, "branch", 7).is_ok())
        && axis > 0.0;
    if good {
        return Ok(());
    }
    say(
        out,
        format_args!(
            "BadParameter: expected finite lengths, a2 and the forearm above 0 mm, BRANCH -1 to 7, AXIS above 0 deg"
        ),
    );
    Err(Error::ValueRange)
}

impl Arm6 {
    fn kin(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        let machine = if self.is_chosen { "ARM6R" } else { "GRIND3P3R" };
        if (name, value) == ("KIN", None) {
            let _ = write!(out, "[KIN:{machine}");
            self.numbers.write(out);
            let _ = out.write_str("]\r\n");
            return Ok(Order::Done);
        }
        if !is_idle {
            return Err(Error::NotIdle);
        }
        match (name, value) {
            ("KIN", Some("ARM6R")) => self.is_chosen = true,
            ("KIN", Some(_)) => return Err(Error::Unavailable),
            (_, Some(value)) => {
                let name = name.strip_prefix("KIN.").ok_or(Error::UnknownCommand)?;
                let changed = self.numbers.with(name, value)?;
                check_kin(&changed, out)?;
                self.numbers.values = changed;
            }
            _ => return Err(Error::UnknownCommand),
        }
        Ok(Order::Done)
    }

    /// The arm as it stands.
    fn guide(&self, standing: &Standing<6>) -> Result<OneBranch<f32>, Error> {
        let Standing { scale, .. } = standing;
        let ends = |steps: &[i32; 6]| scale.joints(steps).0;
        let (lower, upper) = (ends(&scale.lower), ends(&scale.upper));
        let limits = core::array::from_fn(|i| [lower[i], upper[i]]);
        let values = &self.numbers.values;
        let arm = Arm::new(lengths(values), limits).map_err(|_| Error::ValueRange)?;
        let [_, _, _, _, _, _, tool, x, y, z, branch, _] = *values;
        let at = |p| Pose {
            p,
            ..Pose::IDENTITY
        };
        Ok(OneBranch {
            arm,
            // Beyond the eight until it is chosen.
            branch: branch.max(0.0) as u8,
            tool: at(Vector::new(0.0, 0.0, tool)),
            work: at(Vector::new(x, y, z)),
            speeds: Some(Joints(standing.speeds)),
        })
    }

    /// Largest way of the tip per unit of each joint [mm per rad].
    fn levers(&self) -> [f32; 6] {
        let Lengths {
            a1, a2, a3, d4, d6, ..
        } = lengths(&self.numbers.values);
        let [_, _, _, _, _, _, tool, ..] = self.numbers.values;
        let wrist = Real::abs(d6) + Real::abs(tool);
        let elbow = Real::sqrt(a3 * a3 + d4 * d4) + wrist;
        let shoulder = Real::abs(a2) + elbow;
        // About its own axis the tool does not move.
        [Real::abs(a1) + shoulder, shoulder, elbow, wrist, wrist, 0.0]
    }
}

impl Machine<6> for Arm6 {
    type Work = ArmWork;
    type Tool = OneBranch<f32>;

    fn all_turn(&self) -> bool {
        self.is_chosen
    }

    fn obey(
        &mut self,
        name: &str,
        value: Option<&str>,
        is_idle: bool,
        out: &mut dyn Write,
    ) -> Result<Order, Error> {
        let order = match name {
            "PRECESS" => self
                .precess
                .obey(name, value, is_idle, out, |values, out| {
                    precess::built(values, out).map(|_| ())
                })?,
            "SURF" => self.surf.obey(name, value, is_idle, out, |values, out| {
                surf::built(values, out).map(|_| ())
            })?,
            "MIRROR" => return Err(Error::Unavailable),
            _ => return self.kin(name, value, is_idle, out),
        };
        if let Order::Run { .. } = order {
            if !self.is_chosen {
                say(out, format_args!("Expected an arm, see $KIN=ARM6R"));
                return Err(Error::Unavailable);
            }
            self.asked = match name {
                "SURF" => Asked::Surf,
                _ => Asked::Precess,
            };
        }
        Ok(order)
    }

    fn begin(
        &mut self,
        standing: &Standing<6>,
        _: bool,
        out: &mut dyn Write,
    ) -> Result<Begun<ArmWork, OneBranch<f32>, 6>, Error> {
        let (work, [clear, plunge]) = match self.asked {
            Asked::Precess => {
                let (made, ways) = precess::built(&self.precess.values, out)?;
                (ArmWork::Precession(made), ways)
            }
            Asked::Surf => {
                let (rows, ways) = surf::built(&self.surf.values, out)?;
                (ArmWork::Grinding(rows), ways)
            }
        };
        let tool = self.guide(standing)?;
        let [.., branch, axis] = self.numbers.values;
        let shop = Shop {
            tool,
            scale: standing.scale,
            tolerance: Tolerance {
                tip: CHORDS * standing.tolerance,
                axis: CHORDS * axis.to_radians(),
                subdivide: true,
            },
            is_chosen: branch != ANY,
            clear,
            plunge,
        };
        let near = standing.scale.joints(&standing.at);
        // Where a joint hardly moves the tip, the tool's axis still feels it.
        let contour = left_for_corners(standing.tolerance, CHORDS, 7);
        let least = contour / (left_for_corners(1.0, CHORDS, 1) * axis.to_radians());
        let levers = self.levers();
        let weight = core::array::from_fn(|i| {
            Real::max(levers[i], least) / standing.scale.steps_per_unit[i]
        });
        Ok(Begun {
            path: PointPath::new(shop, work, near),
            weight,
            contour,
        })
    }

    fn point(numbers: &[f32; MOST], count: usize, begins: bool) -> Result<SurfacePoint, Error> {
        if !matches!(count, 6 | 9 | MOST) {
            return Err(Error::BadNumber);
        }
        let [.., k_f, k_c, tau] = *numbers;
        Ok(SurfacePoint {
            p: vector(numbers, 0),
            n: vector(numbers, 3),
            feed: (count >= 9).then(|| vector(numbers, 6)),
            curvature: [k_f, k_c, tau],
            begins,
        })
    }
}

impl Told for WorkError {
    fn name(&self) -> &'static str {
        self.name()
    }

    fn remedy(&self) -> &'static str {
        self.remedy()
    }
}

impl Told for Refusal {
    fn name(&self) -> &'static str {
        match self {
            Self::NotReached => "Unreachable",
            Self::OutOfTravel => "OutOfTravel",
            _ => "NoBranch",
        }
    }

    fn remedy(&self) -> &'static str {
        match self {
            Self::NotReached => "no joints of the branch reach this pose",
            Self::OutOfTravel => "a joint would leave its range, see $1040 and $1050",
            Self::WristSingular => "the wrist is stretched, within 1 deg",
            Self::ElbowSingular => "the elbow is stretched or folded, within 1 deg",
            Self::ShoulderSingular => "the wrist is above the base, within 1 mm of its axis",
            Self::Jump { .. } => "a joint would jump by more than 30 deg",
        }
    }

    fn joint(&self) -> Option<usize> {
        match self {
            Self::Jump { joint } => Some(usize::from(*joint)),
            _ => None,
        }
    }
}
