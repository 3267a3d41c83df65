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

/// Bounds for a chord between two sets, from `off(joints, wanted)`: how far a tip [mm] and its axis [rad] are from where
/// they should be for a CL point.
///
/// What the ends themselves miss (a side that cannot reach the direction) does not count: it does not go away by halving.
pub fn bound_of<const N: usize, R: Real>(
    from: &ChainSet<N, R>,
    to: &ChainSet<N, R>,
    off: impl Fn(&Joints<N, R>, &ClPoint<R>) -> (R, R),
) -> (R, Option<R>) {
    let Some(way) = Way::new(from.at, to.at) else {
        return unknown();
    };
    let ends = [from, to].map(|set| off(&set.q, &set.at));
    let (tip, axis) = (ends[0].0.max(ends[1].0), ends[0].1.max(ends[1].1));
    sampled(|u| {
        let (p, o) = off(&between(&from.q, &to.q, u), &way.at(u));
        ((p - tip).max(R::ZERO), (o - axis).max(R::ZERO))
    })
}

/// Bounds for a chord of a chain.
pub fn chain_bound<const N: usize, R: Real>(
    series: &Series<'_, R>,
    from: &ChainSet<N, R>,
    to: &ChainSet<N, R>,
) -> (R, Option<R>) {
    if !turns_little(series, &from.q.0, &to.q.0) {
        return unknown();
    }
    bound_of(from, to, |q, wanted| {
        let (p, o) = series.tip(&q.0);
        ((p - wanted.p()).norm(), o.angle_to(wanted.v()))
    })
}

/// Whether no joint turns by more than [`MOST_TURN`].
pub fn turns_little<R: Real>(series: &Series<'_, R>, from: &[R], to: &[R]) -> bool {
    let most = R::of(MOST_TURN);
    let mut joints = series.joints.iter().zip(from.iter().zip(to));
    joints.all(|(joint, (from, to))| {
        // False for a NaN as well.
        joint.motion() != Motion::Rotary || (*to - *from).abs() <= most
    })
}

/// A machine with the largest speeds of its joints [mm/s, rad/s], if they are limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paced<M, const N: usize, R> {
    pub machine: M,
    pub speeds: Option<Joints<N, R>>,
}

/// A machine of which nothing but joints needs to be known from one CL point to the next: [`Paced`] makes a [`Guide`] of it.
pub trait Reach<const N: usize, R: Real> {
    type Error: Copy;

    /// Joints for a CL point, nearest to those before.
    fn reach(&self, at: &ClPoint<R>, before: &Joints<N, R>) -> Result<ChainSet<N, R>, Self::Error>;

    /// As [`Guide::bound`].
    fn bound(&self, from: &ChainSet<N, R>, to: &ChainSet<N, R>) -> (R, Option<R>);

    /// Whether a turning joint goes by more than half a turn.
    fn winds(&self, from: &Joints<N, R>, to: &Joints<N, R>) -> bool;
}

impl<M: Reach<N, R>, const N: usize, R: Real> Guide<N, R> for Paced<M, N, R> {
    type Course = Way<R>;
    type Set = ChainSet<N, R>;
    type Error = M::Error;

    fn solve(&self, at: &ClPoint<R>, before: &ChainSet<N, R>) -> Result<ChainSet<N, R>, M::Error> {
        self.machine.reach(at, &before.q)
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
        self.machine.bound(from, to)
    }

    fn is_reconfigured(
        &self,
        (_, from): (&ClPoint<R>, &ChainSet<N, R>),
        (_, to): (&ClPoint<R>, &ChainSet<N, R>),
    ) -> bool {
        self.machine.winds(&from.q, &to.q)
    }

    fn is_singular(&self, set: &ChainSet<N, R>) -> bool {
        set.singular
    }

    fn speeds(&self) -> Option<Joints<N, R>> {
        self.speeds
    }
}

/// Any chain: damped Newton from the joints before, five conditions.
impl<const N: usize, R: Real> Reach<N, R> for Chain<N, R> {
    type Error = Failure<R>;

    fn reach(&self, at: &ClPoint<R>, before: &Joints<N, R>) -> Result<ChainSet<N, R>, Failure<R>> {
        let target = Target::TipAxis {
            p: at.p(),
            o: at.v(),
        };
        let found = self.inverse(&target, before, &Tolerance::default());
        found
            .map(|answer| ChainSet {
                q: answer.q,
                at: *at,
                singular: false,
            })
            .map_err(|refused| refused.why)
    }

    fn bound(&self, from: &ChainSet<N, R>, to: &ChainSet<N, R>) -> (R, Option<R>) {
        chain_bound(&self.series(), from, to)
    }

    fn winds(&self, from: &Joints<N, R>, to: &Joints<N, R>) -> bool {
        winds(&self.series(), &from.0, &to.0)
    }
}

/// Whether a turning joint goes by more than half a turn.
pub fn winds<R: Real>(series: &Series<'_, R>, from: &[R], to: &[R]) -> bool {
    let half = R::PI * R::of(1.0 + 1e-6);
    let mut joints = series.joints.iter().zip(from.iter().zip(to));
    joints.any(|(joint, (from, to))| joint.motion() == Motion::Rotary && (*to - *from).abs() > half)
}
