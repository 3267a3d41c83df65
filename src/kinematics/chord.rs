//! How far the tool strays when the joints run linearly between two sets: measured at three places of the chord.
//!
//! For machines without a bound in closed form. The deviation from the way is looked at for u = 1/4, 1/2 and 3/4, and
//! the largest is taken 1.3 times. That serves while no joint turns by more than [`MOST_TURN`] from one set to the other
//! (on 2000 random moves the largest over the whole chord never exceeded the largest of the three by 1 %); beyond, nothing
//! is claimed, and the follower halves the stretch.
//!
//! [`Paced`] is a chain, or a machine made of one, with the speeds of its joints: the [`Guide`] that the follower asks.
//!
//! Source: section 6 of the five-axis specification, "optional cheaper acceptance".

use super::chain::{Chain, Motion, Series};
use super::follow::Guide;
use super::inverse::{Failure, Target, Tolerance};
use super::way::{ClPoint, Way};
use crate::joints::Joints;
use crate::math::Real;

/// Largest turn of a joint for which the three samples are taken at their word [rad].
pub const MOST_TURN: f64 = 0.1;

/// What the largest sample is multiplied with.
const MARGIN: f64 = 1.3;

/// Bounds of the tip error [mm] and of the tool's angle [rad] from `error(u)`, which gives both at a place 0 ..= 1 of the
/// chord.
pub fn sampled<R: Real>(mut error: impl FnMut(R) -> (R, R)) -> (R, Option<R>) {
    let (mut tip, mut angle) = (R::ZERO, R::ZERO);
    for u in [0.25, 0.5, 0.75] {
        let (off, turned) = error(R::of(u));
        tip = tip.max(off);
        angle = angle.max(turned);
    }
    (tip * R::of(MARGIN), Some(angle * R::of(MARGIN)))
}

/// Nothing is known of the chord: the stretch is to be halved.
pub fn unknown<R: Real>() -> (R, Option<R>) {
    (R::INFINITY, None)
}

/// The point of a chord of the joints at `u`.
pub fn between<const N: usize, R: Real>(
    from: &Joints<N, R>,
    to: &Joints<N, R>,
    u: R,
) -> Joints<N, R> {
    from.zip_map(to, |from, to| from + (to - from) * u)
}

/// Joints of a chain with the CL point that they reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainSet<const N: usize, R> {
    pub q: Joints<N, R>,
    pub at: ClPoint<R>,
    /// At a pole or on the border of what can be reached.
    pub singular: bool,
}

/// Bounds for a chord of a chain.
pub fn chain_bound<const N: usize, R: Real>(
    series: &Series<'_, R>,
    from: &ChainSet<N, R>,
    to: &ChainSet<N, R>,
) -> (R, Option<R>) {
    let most = R::of(MOST_TURN);
    let change = to.q.zip_map(&from.q, |to, from| to - from);
    let mut joints = series.joints.iter().zip(&change.0);
    let is_small = joints.all(|(joint, change)| {
        // False for a NaN as well.
        joint.motion() != Motion::Rotary || change.abs() <= most
    });
    let Some(way) = Way::new(from.at, to.at).filter(|_| is_small) else {
        return unknown();
    };
    // What the ends themselves miss (a side that cannot reach the direction) does not go away by halving.
    let miss = |set: &ChainSet<N, R>| {
        let (p, o) = series.tip(&set.q.0);
        ((p - set.at.p()).norm(), o.angle_to(set.at.v()))
    };
    let (ends_a, ends_b) = (miss(from), miss(to));
    let off = [ends_a.0.max(ends_b.0), ends_a.1.max(ends_b.1)];
    sampled(|u| {
        let (p, o) = series.tip(&between(&from.q, &to.q, u).0);
        let wanted = way.at(u);
        (
            ((p - wanted.p()).norm() - off[0]).max(R::ZERO),
            (o.angle_to(wanted.v()) - off[1]).max(R::ZERO),
        )
    })
}

/// A machine with the largest speeds of its joints [mm/s, rad/s], if they are limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paced<M, const N: usize, R> {
    pub machine: M,
    pub speeds: Option<Joints<N, R>>,
}

/// Any chain: damped Newton from the joints before, five conditions.
impl<const N: usize, R: Real> Guide<N, R> for Paced<Chain<N, R>, N, R> {
    type Course = Way<R>;
    type Set = ChainSet<N, R>;
    type Error = Failure<R>;

    fn solve(
        &self,
        at: &ClPoint<R>,
        before: &ChainSet<N, R>,
    ) -> Result<ChainSet<N, R>, Failure<R>> {
        let target = Target::TipAxis {
            p: at.p(),
            o: at.v(),
        };
        let found = self
            .machine
            .inverse(&target, &before.q, &Tolerance::default());
        found
            .map(|answer| ChainSet {
                q: answer.q,
                at: *at,
                singular: false,
            })
            .map_err(|refused| refused.why)
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
        chain_bound(&self.machine.series(), from, to)
    }

    fn is_reconfigured(
        &self,
        (_, from): (&ClPoint<R>, &ChainSet<N, R>),
        (_, to): (&ClPoint<R>, &ChainSet<N, R>),
    ) -> bool {
        winds(&self.machine.series(), &from.q.0, &to.q.0)
    }

    fn is_singular(&self, set: &ChainSet<N, R>) -> bool {
        set.singular
    }

    fn speeds(&self) -> Option<Joints<N, R>> {
        self.speeds
    }
}

/// Whether a turning joint goes by more than half a turn.
pub fn winds<R: Real>(series: &Series<'_, R>, from: &[R], to: &[R]) -> bool {
    let half = R::PI * R::of(1.0 + 1e-6);
    let mut joints = series.joints.iter().zip(from.iter().zip(to));
    joints.any(|(joint, (from, to))| joint.motion() == Motion::Rotary && (*to - *from).abs() > half)
}
