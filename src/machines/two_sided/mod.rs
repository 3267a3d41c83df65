//! Two-sided machine: a mill and a support head on the two faces of a thin panel.
//!
//! ```text
//!        side 1, mill       |\            P_T = P_H + d n        e = P_T - P_H
//!            ====O_T==> tip | | tip <==O_H====                   thickness     n.e
//!                      P_T  | |  P_H          side 2, support    lateral       |e - (n.e) n|
//!                           |/ panel                             anti-parallel angle(O_T, -O_H)
//!                     <-- n
//! ```
//!
//! (O points from the tip into the body: against the arrows.) Each side is a machine of its own: a work chain from the
//! bed to its work frame and a tool chain from the bed to cutter or support. All results are in the work frame of side 1.
//! Both tips are taken into the bed and from there into that frame, so the work chains may stand anywhere.
//!
//! A joint on a work chain that both sides share is listed on both, first in the same order on each work chain. Side 1
//! sets it; for side 2 it is a known value, and that side needs three linears and up to two rotaries besides.
//!
//! Errors in f32 against f64, largest of 100 000 random poses on 100 random sides and of 20 000 on both reference
//! machines, coordinates to 1000 mm (measured again by `host-tests/tests/mirror.rs`; in f64 the tip is within 1e-9 mm):
//!
//! | | random sides | reference machines |
//! |---|---|---|
//! | tip, forward(inverse) | 7.0e-4 mm | 1.4e-4 mm |
//! | direction, both solutions | 6.7e-5 deg | below 1e-4 deg |
//! | gap or residual | 2.0e-5 deg | 8.1e-6 deg |
//! | thickness from two forward maps | | 8.9e-5 mm |
//!
//! Cost on a Cortex-M4F in f32: 5100 instructions for both five-axis sides; 6800 with a trimmer tick and the trims.
//!
//! Source: Liu, Wang, Li, Ding, Bo, Xiao, Wang, "Kinematic modeling and automatic trajectory adjustment for mirror
//! milling based on screw theory" (2024), sections 2 and 3; the presets are the specification's (section 8).

pub mod direction;
mod guide;
mod presets;
mod side;
mod trim;

pub use direction::Kind;
pub use guide::{AtWall, PairGuide};
pub use presets::{FourAxes, m4, m4_1, m4_2, m5, m5_1, m5_2};
pub use side::{Side, SideError, SideSolution, SideSolutions};
pub use trim::Trim;

use crate::geometry::twist::LEAST_DIRECTION;
use crate::geometry::{Pose, Vector};
use crate::joints::Joints;
use crate::kinematics::chain::{Carries, Chain, Joint, Motion, Series};
use crate::math::Real;

/// Which side failed, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairError<const N1: usize, const N2: usize, R> {
    /// The wall is not a number above zero.
    BadWall,
    /// The normal is shorter than 1e-6.
    BadNormal,
    NonFinite,
    /// Side 2 has a work joint that is not also one of side 1.
    WorkChainsDiffer {
        joint: usize,
    },
    Mill(SideError<N1, R>),
    Support(SideError<N2, R>),
}

impl<const N1: usize, const N2: usize, R> PairError<N1, N2, R> {
    /// The name under which every interface reports it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::BadWall => "BadWall",
            Self::BadNormal => "BadNormal",
            Self::NonFinite => "NonFinite",
            Self::WorkChainsDiffer { .. } => "WorkChainsDiffer",
            Self::Mill(error) => error.name(),
            Self::Support(error) => error.name(),
        }
    }

    /// What was expected, as a sentence.
    pub const fn remedy(&self) -> &'static str {
        match self {
            Self::BadWall => "the wall must be finite and above 0 mm",
            Self::BadNormal => "a normal must be longer than 1e-6",
            Self::NonFinite => "every number must be finite",
            Self::WorkChainsDiffer { .. } => "both sides must share their work chain",
            Self::Mill(error) => error.remedy(),
            Self::Support(error) => error.remedy(),
        }
    }
}

/// Both tips [mm] and unit tool axes (tip into body) in the work frame of side 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tips<R> {
    pub p_t: Vector<R>,
    pub o_t: Vector<R>,
    pub p_h: Vector<R>,
    pub o_h: Vector<R>,
}

/// What stands between the tips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall<R> {
    /// Along the normal [mm].
    pub thickness: R,
    /// Across the normal [mm].
    pub lateral: R,
    /// Distance of the tips [mm].
    pub length: R,
    /// Angle between the cutter axis and the support axis reversed [rad].
    pub anti_parallel: R,
}

/// Above these a wall is flagged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLimits<R> {
    /// [mm]
    pub lateral: R,
    /// [rad]
    pub anti_parallel: R,
}

impl<R: Real> Default for WallLimits<R> {
    /// 0.01 mm and 0.05 deg.
    fn default() -> Self {
        Self {
            lateral: R::of(0.01),
            anti_parallel: R::of(0.05).to_radians(),
        }
    }
}

impl<R: Real> Tips<R> {
    /// The wall along `n` (any length from 1e-6, from support to mill); without it along the cutter axis.
    /// `None` if the normal is too short or not finite.
    pub fn wall(&self, n: Option<Vector<R>>) -> Option<Wall<R>> {
        let n = match n {
            Some(n) => n.unit(R::of(LEAST_DIRECTION))?,
            None => self.o_t,
        };
        let e = self.p_t - self.p_h;
        let thickness = n.dot(e);
        Some(Wall {
            thickness,
            lateral: (e - n * thickness).norm(),
            length: e.norm(),
            anti_parallel: self.o_t.angle_to(-self.o_h),
        })
    }
}

impl<R: Real> Wall<R> {
    pub fn is_lateral(&self, limits: &WallLimits<R>) -> bool {
        self.lateral > limits.lateral
    }

    pub fn is_not_anti_parallel(&self, limits: &WallLimits<R>) -> bool {
        self.anti_parallel > limits.anti_parallel
    }
}

/// Joints of both sides for one place of the panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairSolution<const N1: usize, const N2: usize, R> {
    pub mill: SideSolution<N1, R>,
    pub support: SideSolution<N2, R>,
}

/// The machine: mill of `N1` joints, support of `N2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<const N1: usize, const N2: usize, R = f32> {
    mill: Side<N1, R>,
    /// Prepared with the shared joints at zero.
    support: Side<N2, R>,
    /// The support with its shared joints free.
    support_chain: Chain<N2, R>,
    /// For each joint of side 2 the joint of side 1 that it is.
    shared: [Option<usize>; N2],
    /// Side 1's work frame seen from side 2's, where no work joint moves either.
    at_rest: Option<Pose<R>>,
}

impl<const N1: usize, const N2: usize, R: Real> Pair<N1, N2, R> {
    /// A pair from the chains of mill and support. Work joints of the support are shared with the mill: same screw axes
    /// in the same order, else [`PairError::WorkChainsDiffer`].
    pub fn new(mill: Chain<N1, R>, support: Chain<N2, R>) -> Result<Self, PairError<N1, N2, R>> {
        let is_work =
            |joint: &Joint<R>| joint.carries() == Carries::Work && joint.motion() != Motion::Held;
        let mut of_mill = mill
            .joints()
            .iter()
            .enumerate()
            .filter(|(_, joint)| is_work(joint));
        let mut shared = [None; N2];
        let mut held = support;
        for (index, (joint, slot)) in support.joints().iter().zip(&mut shared).enumerate() {
            if is_work(joint) {
                let (twin, _) = of_mill
                    .next()
                    .filter(|(_, other)| same_screw(other, joint))
                    .ok_or(PairError::WorkChainsDiffer { joint: index })?;
                *slot = Some(twin);
                held = held.held(index, R::ZERO);
            }
        }
        let rests = !mill.joints().iter().any(is_work);
        let (w1, w2) = (mill.series().work_home, support.series().work_home);
        Ok(Self {
            mill: Side::new(mill).map_err(PairError::Mill)?,
            support: Side::new(held).map_err(PairError::Support)?,
            support_chain: support,
            shared,
            at_rest: rests.then(|| w2.inverse() * w1),
        })
    }

    pub fn mill(&self) -> &Side<N1, R> {
        &self.mill
    }

    /// The support, its shared joints held at zero.
    pub fn support(&self) -> &Side<N2, R> {
        &self.support
    }

    /// Both tips and axes in the work frame of side 1.
    pub fn forward(&self, q1: &Joints<N1, R>, q2: &Joints<N2, R>) -> Tips<R> {
        let support = self.support_chain.series();
        tips(&self.mill.chain().series(), &q1.0, &support, &q2.0)
    }

    /// Joints of both sides for the support point `p` [mm], the normal `n` (any length from 1e-6, from support to mill)
    /// and the wall `d` [mm], in the work frame of side 1: `P_H = p`, `O_H = -n`, `P_T = p + d n`, `O_T = n`. Each side
    /// from its previous joints. No joints at all if either side fails.
    pub fn solve(
        &self,
        p: Vector<R>,
        n: Vector<R>,
        d: R,
        previous: (&Joints<N1, R>, &Joints<N2, R>),
    ) -> Result<PairSolution<N1, N2, R>, PairError<N1, N2, R>> {
        if !(d.is_finite() && d > R::ZERO) {
            return Err(PairError::BadWall);
        }
        if !(p.is_finite() && n.is_finite()) {
            return Err(PairError::NonFinite);
        }
        let n = n.unit(R::of(LEAST_DIRECTION)).ok_or(PairError::BadNormal)?;
        let mill = self
            .mill
            .inverse(p + n * d, n, previous.0)
            .map_err(PairError::Mill)?;
        let support = self
            .solve_support(p, -n, &mill.q, previous.1)
            .map_err(PairError::Support)?;
        Ok(PairSolution { mill, support })
    }

    /// Support tip and axis given in the work frame of side 1, whose joints are known.
    fn solve_support(
        &self,
        p: Vector<R>,
        o: Vector<R>,
        q1: &Joints<N1, R>,
        previous: &Joints<N2, R>,
    ) -> Result<SideSolution<N2, R>, SideError<N2, R>> {
        if let Some(pose) = self.at_rest {
            return self
                .support
                .inverse(pose.apply(p), pose.rotation * o, previous);
        }
        let bed = self.mill.chain().series().work(&q1.0);
        let (p, o) = (bed.apply(p), bed.rotation * o);
        let mut q2 = *previous;
        let mut chain = self.support_chain;
        let mut has_shared = false;
        for (index, (twin, q)) in self.shared.iter().zip(&mut q2.0).enumerate() {
            if let Some(value) = twin.and_then(|twin| q1.0.get(twin)) {
                *q = *value;
                chain = chain.held(index, *value);
                has_shared = true;
            }
        }
        let (p, o) = chain.series().to_work(p, o, &q2.0);
        if has_shared {
            Side::new(chain)?.inverse(p, o, &q2)
        } else {
            self.support.inverse(p, o, &q2)
        }
    }
}

/// Both tips and axes of any two chains in the work frame of the first, at the joints `q1` and `q2`.
pub fn tips<R: Real>(mill: &Series<'_, R>, q1: &[R], support: &Series<'_, R>, q2: &[R]) -> Tips<R> {
    let (p_t, o_t) = mill.tip(q1);
    let (p_h, o_h) = support.tip_in_bed(q2);
    let (p_h, o_h) = mill.to_work(p_h, o_h, q1);
    Tips { p_t, o_t, p_h, o_h }
}

fn same_screw<R: Real>(a: &Joint<R>, b: &Joint<R>) -> bool {
    let difference = a.twist() + -b.twist();
    let tolerance = R::of(1e-9).max(R::EPSILON * R::of(1000.0));
    a.motion() == b.motion() && difference.v.norm() <= tolerance && difference.w.norm() <= tolerance
}
