//! One side along CL points, for the follower.

use super::{Kind, Side, SideError};
use crate::joints::Joints;
use crate::kinematics::chord::{ChainSet, Paced, chain_bound, winds};
use crate::kinematics::follow::Guide;
use crate::kinematics::{ClPoint, Way};
use crate::math::Real;

/// CL points in the work frame of the side.
impl<const N: usize, R: Real> Guide<N, R> for Paced<Side<N, R>, N, R> {
    type Course = Way<R>;
    type Set = ChainSet<N, R>;
    type Error = SideError<N, R>;

    fn solve(
        &self,
        at: &ClPoint<R>,
        before: &ChainSet<N, R>,
    ) -> Result<ChainSet<N, R>, SideError<N, R>> {
        let found = self.machine.inverse(at.p(), at.v(), &before.q)?;
        Ok(ChainSet {
            q: found.q,
            at: *at,
            singular: matches!(found.kind, Kind::Infinite | Kind::One),
        })
    }

    fn joints(&self, set: &ChainSet<N, R>) -> Joints<N, R> {
        set.q
    }

    fn change(&self, from: &ChainSet<N, R>, to: &ChainSet<N, R>) -> Joints<N, R> {
        to.q.zip_map(&from.q, |to, from| to - from)
    }

    fn bound(
        &self,
        from: &ChainSet<N, R>,
        to: &ChainSet<N, R>,
        _length: R,
        _chord: R,
    ) -> (R, Option<R>) {
        chain_bound(&self.machine.chain().series(), from, to)
    }

    fn is_reconfigured(
        &self,
        (_, from): (&ClPoint<R>, &ChainSet<N, R>),
        (_, to): (&ClPoint<R>, &ChainSet<N, R>),
    ) -> bool {
        winds(&self.machine.chain().series(), &from.q.0, &to.q.0)
    }

    fn is_singular(&self, set: &ChainSet<N, R>) -> bool {
        set.singular
    }

    fn speeds(&self) -> Option<Joints<N, R>> {
        self.speeds
    }
}
