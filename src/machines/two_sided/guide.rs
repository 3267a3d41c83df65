//! One side, or both with a wall between them, along CL points: what the follower asks.
//!
//! For a pair the CL points are those of the reference surface: the support's tip P and the normal n from the support to the
//! mill, in the work frame of side 1. Between two of them P runs on the straight line and n on the great circle; there
//!
//! ```text
//! mill:  P_T = P + d n, O_T = n          support:  P_H = P, O_H = -n
//! ```
//!
//! are what both sides are bound to, each for itself. The joints are those of the mill, then those of the support.

use super::{Pair, PairError, Side, SideError};
use crate::joints::Joints;
use crate::kinematics::ClPoint;
use crate::kinematics::chord::{
    ChainSet, Paced, Reach, bound_of, chain_bound, turns_little, unknown, winds,
};
use crate::math::Real;

/// CL points in the work frame of the side.
impl<const N: usize, R: Real> Reach<N, R> for Side<N, R> {
    type Error = SideError<N, R>;

    fn reach(
        &self,
        at: &ClPoint<R>,
        before: &Joints<N, R>,
    ) -> Result<ChainSet<N, R>, SideError<N, R>> {
        let found = self.inverse(at.p(), at.v(), before)?;
        Ok(ChainSet {
            q: found.q,
            at: *at,
            singular: self.is_singular(found.kind),
        })
    }

    fn bound(&self, from: &ChainSet<N, R>, to: &ChainSet<N, R>) -> (R, Option<R>) {
        chain_bound(&self.chain().series(), from, to)
    }

    fn winds(&self, from: &Joints<N, R>, to: &Joints<N, R>) -> bool {
        winds(&self.chain().series(), &from.0, &to.0)
    }
}

/// A pair with a wall between its tips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtWall<const N1: usize, const N2: usize, R = f32> {
    pub pair: Pair<N1, N2, R>,
    /// Wanted wall [mm], above 0.
    pub wall: R,
}

/// A pair of four axes a side, joints X1 Y1 Z1 B1 X2 Y2 Z2 B2: `Follower::new(&PairGuide { machine, speeds }, ...)`.
pub type PairGuide<R = f32> = Paced<AtWall<4, 4, R>, 8, R>;

impl<const N1: usize, const N2: usize, R: Real> AtWall<N1, N2, R> {
    /// Joints of the mill and of the support.
    fn parted<const N: usize>(q: &Joints<N, R>) -> (Joints<N1, R>, Joints<N2, R>) {
        const { assert!(N1 + N2 == N, "a pair has the joints of both sides") };
        let at = |i: usize| q.0.get(i).copied().unwrap_or_default();
        (
            Joints(core::array::from_fn(at)),
            Joints(core::array::from_fn(|i| at(N1 + i))),
        )
    }

    fn joined<const N: usize>(mill: &Joints<N1, R>, support: &Joints<N2, R>) -> Joints<N, R> {
        const { assert!(N1 + N2 == N, "a pair has the joints of both sides") };
        let mut q = Joints::default();
        for (q, of) in q.0.iter_mut().zip(mill.0.iter().chain(&support.0)) {
            *q = *of;
        }
        q
    }
}

/// CL points of the reference surface in the work frame of side 1. Fails as [`Pair::solve`] does, for both sides or none.
impl<const N1: usize, const N2: usize, const N: usize, R: Real> Reach<N, R> for AtWall<N1, N2, R> {
    type Error = PairError<N1, N2, R>;

    fn reach(
        &self,
        at: &ClPoint<R>,
        before: &Joints<N, R>,
    ) -> Result<ChainSet<N, R>, PairError<N1, N2, R>> {
        let (mill, support) = Self::parted(before);
        let found = self
            .pair
            .solve(at.p(), at.v(), self.wall, (&mill, &support))?;
        Ok(ChainSet {
            q: Self::joined(&found.mill.q, &found.support.q),
            at: *at,
            singular: self.pair.mill.is_singular(found.mill.kind)
                || self.pair.support.is_singular(found.support.kind),
        })
    }

    /// The larger of both sides' bounds; each side against its own tip and axis, less what it misses at the ends.
    fn bound(&self, from: &ChainSet<N, R>, to: &ChainSet<N, R>) -> (R, Option<R>) {
        let (mill, support) = (
            self.pair.mill().chain().series(),
            self.pair.support_chain.series(),
        );
        let (from_q, to_q) = (Self::parted(&from.q), Self::parted(&to.q));
        let is_small = turns_little(&mill, &from_q.0.0, &to_q.0.0)
            && turns_little(&support, &from_q.1.0, &to_q.1.0);
        if !is_small {
            return unknown();
        }
        let of_mill = bound_of(from, to, |q, wanted| {
            let (p, o) = mill.tip(&Self::parted(q).0.0);
            let tip = wanted.p() + wanted.v() * self.wall;
            ((p - tip).norm(), o.angle_to(wanted.v()))
        });
        let of_support = bound_of(from, to, |q, wanted| {
            let (q1, q2) = Self::parted(q);
            let (p, o) = support.tip_in_bed(&q2.0);
            let (p, o) = mill.to_work(p, o, &q1.0);
            ((p - wanted.p()).norm(), o.angle_to(-wanted.v()))
        });
        let axis = match (of_mill.1, of_support.1) {
            (Some(a), Some(b)) => Some(a.max(b)),
            _ => None,
        };
        (of_mill.0.max(of_support.0), axis)
    }

    fn winds(&self, from: &Joints<N, R>, to: &Joints<N, R>) -> bool {
        let (from, to) = (Self::parted(from), Self::parted(to));
        winds(&self.pair.mill().chain().series(), &from.0.0, &to.0.0)
            || winds(&self.pair.support_chain.series(), &from.1.0, &to.1.0)
    }
}
