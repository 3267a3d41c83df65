//! A measured shift of the panel -> how far every joint of both sides moves for it.
//!
//! At the support point the panel is found shifted by delta along n, perhaps with another normal n':
//!
//! ```text
//! P_H' = P_H + delta n,  O_H' = -n'         P_T' = P_H' + d n',  O_T' = n'
//! n' = n:  trim = M^-1 (delta n_bed),  n_bed = R(g_w) n,   rotaries stay          (direct form)
//! else:    both sides solved again from where they stand, trim = new - old
//! ```
//!
//! The difference of two solutions loses 1e-4 mm in f32, the direct form nothing. A tilt of the normal moves the linears by
//! pivot length times tilt: 0.0004 rad at 400 mm is more than a usual shift, so a measured tilt wants far more filtering.
//!
//! Source: specification of mirror milling, section 5; the paper's equations (23)-(26) are missing from its copy.

use super::{Pair, PairError, PairSolution, SideError};
use crate::geometry::Vector;
use crate::geometry::twist::LEAST_DIRECTION;
use crate::joints::Joints;
use crate::kinematics::chain::{Carries, Chain, Joint, Motion};
use crate::math::Real;

/// Trims of both sides [mm or rad], one value a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trim<const N1: usize, const N2: usize, R> {
    pub mill: Joints<N1, R>,
    pub support: Joints<N2, R>,
}

impl<const N1: usize, const N2: usize, R: Real> Pair<N1, N2, R> {
    /// The direct form: what the joints at `q1`, `q2` move by to shift both tips by `delta` [mm] along the normal `n` (any
    /// length from 1e-6, in the work frame of side 1). Fails with `OutOfTravel` where a trimmed joint would leave its
    /// travel; then neither side has a trim.
    pub fn trim(
        &self,
        n: Vector<R>,
        delta: R,
        (q1, q2): (&Joints<N1, R>, &Joints<N2, R>),
    ) -> Result<Trim<N1, N2, R>, PairError<N1, N2, R>> {
        if !(delta.is_finite() && n.is_finite()) {
            return Err(PairError::NonFinite);
        }
        let n = n.unit(R::of(LEAST_DIRECTION)).ok_or(PairError::BadNormal)?;
        let bed = self.mill.chain().series().work(&q1.0).rotation;
        let shift = bed * n * delta;
        let mill = self
            .mill
            .linear_shift(shift, q1)
            .and_then(|trim| within(self.mill.chain(), q1, trim))
            .map_err(PairError::Mill)?;
        let support = self
            .support
            .linear_shift(shift + self.carried_along(q1, &mill), q2)
            .map(|trim| self.with_shared(trim, &mill))
            .and_then(|trim| within(&self.support_chain, q2, trim))
            .map_err(PairError::Support)?;
        Ok(Trim { mill, support })
    }

    /// How far the mill's trim moves the panel itself in the bed [mm]: its slides on the work chain carry it along, and
    /// the support must follow.
    fn carried_along(&self, q1: &Joints<N1, R>, trim: &Joints<N1, R>) -> Vector<R> {
        let joints = self.mill.chain().joints();
        let on_work = |joint: &&Joint<R>| joint.carries() == Carries::Work;
        let mut moved = Vector::ZERO;
        for (index, (joint, trim)) in joints.iter().zip(&trim.0).enumerate() {
            if !on_work(&joint) || joint.motion() != Motion::Linear {
                continue;
            }
            let direction = joints
                .iter()
                .zip(&q1.0)
                .take(index)
                .rev()
                .filter(|(before, _)| on_work(before))
                .fold(joint.twist().v, |d, (before, q)| {
                    before.turn(d, before.trig(*q))
                });
            moved += direction * *trim;
        }
        moved
    }

    /// The support's trim with that of the joints which the mill sets.
    fn with_shared(&self, mut trim: Joints<N2, R>, mill: &Joints<N1, R>) -> Joints<N2, R> {
        for (twin, trim) in self.shared.iter().zip(&mut trim.0) {
            if let Some(set) = twin.and_then(|twin| mill.0.get(twin)) {
                *trim = *set;
            }
        }
        trim
    }

    /// Both sides solved again for a panel shifted by `delta` [mm] along `n`, its normal now `turned`, wall `d` [mm]: from
    /// the untrimmed joints `before`, so on the same branch. Fails as [`Pair::solve`] does.
    pub fn retrim(
        &self,
        p: Vector<R>,
        n: Vector<R>,
        d: R,
        (delta, turned): (R, Vector<R>),
        before: (&Joints<N1, R>, &Joints<N2, R>),
    ) -> Result<PairSolution<N1, N2, R>, PairError<N1, N2, R>> {
        if !(delta.is_finite() && n.is_finite()) {
            return Err(PairError::NonFinite);
        }
        let n = n.unit(R::of(LEAST_DIRECTION)).ok_or(PairError::BadNormal)?;
        self.solve(p + n * delta, turned, d, before)
    }
}

fn within<const N: usize, R: Real>(
    chain: &Chain<N, R>,
    q: &Joints<N, R>,
    trim: Joints<N, R>,
) -> Result<Joints<N, R>, SideError<N, R>> {
    for (joint, ((part, q), trim)) in chain.joints().iter().zip(&q.0).zip(&trim.0).enumerate() {
        let moved = *q + *trim;
        let outside = part
            .limits()
            .is_some_and(|[lo, hi]| !(lo <= moved && moved <= hi));
        if outside && *trim != R::ZERO {
            return Err(SideError::OutOfTravel { joint });
        }
    }
    Ok(trim)
}
