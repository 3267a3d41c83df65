//! Flange poses of a segment to the joints of the arm, in one branch.

use hexstep::geometry::Pose;
use hexstep::joints::Joints;
use hexstep::machines::arm::{Arm, ArmError, NoBranch, Refusal, Stretch};
use std::fmt;

/// A segment as the arm runs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Served {
    pub branch: u8,
    /// Joint angles [rad], one set for each pose.
    pub joints: Vec<Joints<6, f64>>,
    /// Smallest distance of any joint to an end of its range [rad].
    pub margin: f64,
}

/// Why the arm cannot run a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refused {
    NoBranch(NoBranch),
    BadPose { index: usize },
}

/// The branch with the largest margin that serves all poses, and its joints. `previous` are the joints before [rad].
pub fn serve(
    arm: &Arm<f64>,
    flanges: &[Pose<f64>],
    previous: Option<Joints<6, f64>>,
) -> Result<Served, Refused> {
    let mut stretch = Stretch::new(previous);
    let mut tracks = vec![Vec::new(); 8];
    for (index, flange) in flanges.iter().enumerate() {
        stretch
            .add(arm, flange)
            .map_err(|_: ArmError| Refused::BadPose { index })?;
        for (branch, track) in (0..8).zip(&mut tracks) {
            track.extend(stretch.joints(branch));
        }
    }
    let (branch, margin) = stretch.best().map_err(Refused::NoBranch)?;
    Ok(Served {
        branch,
        joints: tracks.swap_remove(usize::from(branch)),
        margin,
    })
}

impl Refused {
    /// The name under which every interface reports it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::NoBranch(refused) => {
                let out_of_reach =
                    |r: &Option<(u32, Refusal)>| matches!(r, Some((_, Refusal::NotReached)));
                if refused.reasons.iter().all(out_of_reach) {
                    "Unreachable"
                } else {
                    "NoBranch"
                }
            }
            Self::BadPose { .. } => "BadPose",
        }
    }

    /// Branch, index of the first pose that it fails at, and why.
    pub fn reasons(&self) -> Vec<(usize, u32, String)> {
        let Self::NoBranch(refused) = self else {
            return Vec::new();
        };
        let reasons = refused.reasons.iter().enumerate();
        reasons
            .filter_map(|(branch, reason)| {
                let (point, why) = (*reason)?;
                Some((branch, point, words(why)))
            })
            .collect()
    }
}

fn words(why: Refusal) -> String {
    match why {
        Refusal::NotReached => "out of reach".into(),
        Refusal::OutOfTravel => "a joint out of its range".into(),
        Refusal::WristSingular => "wrist singular".into(),
        Refusal::ElbowSingular => "elbow singular".into(),
        Refusal::ShoulderSingular => "shoulder singular".into(),
        Refusal::Jump { joint } => format!("joint {joint} jumps by more than 30 degrees"),
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoBranch(_) => write!(
                f,
                "no branch of the arm serves the whole row; move the part or the tool"
            ),
            Self::BadPose { index } => write!(f, "pose {index} is not finite or not a rotation"),
        }
    }
}
