//! B-spline basis functions with two derivatives, over clamped knots.

use super::{MAX_DEGREE, NurbsError, Side};
use crate::math::Real;

/// The knots of one parameter: degree p, n control points, n + p + 1 knots.
///
/// The ends are repeated p + 1 times, so only what lies between one copy of each is kept: n - p + 1 <= N values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knots<R, const N: usize> {
    degree: usize,
    /// Number of the last of the kept values, n - p.
    last: usize,
    breaks: [R; N],
    lo: R,
    hi: R,
}

/// The p + 1 functions that do not vanish at a parameter.
pub(super) struct Basis<R> {
    /// Number of the control point of the first of them.
    pub first: usize,
    count: usize,
    /// Each with its value and its first and second derivative.
    functions: [[R; 3]; MAX_DEGREE + 1],
}

impl<R> Basis<R> {
    pub fn functions(&self) -> &[[R; 3]] {
        self.functions.get(..self.count).unwrap_or(&[])
    }
}

impl<R: Real, const N: usize> Knots<R, N> {
    /// The knots of `count` control points, checked: number, order, finite, clamped, inner ones at most p times.
    pub fn new(degree: usize, count: usize, knots: &[R], side: Side) -> Result<Self, NurbsError> {
        let bad = Err(NurbsError::BadKnots(side));
        if knots.len() != count + degree + 1 || !knots.iter().all(|k| k.is_finite()) {
            return bad;
        }
        let (Some(first), Some(last)) = (knots.first(), knots.last()) else {
            return bad;
        };
        let (head, tail) = (knots.get(..=degree), knots.get(knots.len() - degree - 1..));
        let same = |end: Option<&[R]>, value: &R| end.is_some_and(|e| e.iter().all(|k| k == value));
        if !same(head, first) || !same(tail, last) || last <= first {
            return bad;
        }
        if knots.iter().zip(knots.iter().skip(1)).any(|(a, b)| a > b) {
            return bad;
        }
        let Some(inner) = knots.get(degree + 1..count) else {
            return bad;
        };
        // p + 1 equal ones in order: a knot and the p-th after it.
        let inside = |k: &R| k > first && k < last;
        if !inner.iter().all(inside)
            || inner
                .iter()
                .zip(inner.iter().skip(degree))
                .any(|(a, b)| a == b)
        {
            return bad;
        }
        let mut breaks = [*last; N];
        let kept = knots.get(degree..=count).unwrap_or(&[]);
        if kept.len() > N {
            return Err(NurbsError::BadNet);
        }
        for (slot, knot) in breaks.iter_mut().zip(kept) {
            *slot = *knot;
        }
        Ok(Self {
            degree,
            last: count - degree,
            breaks,
            lo: *first,
            hi: *last,
        })
    }

    /// First and last value.
    pub fn domain(&self) -> [R; 2] {
        [self.lo, self.hi]
    }

    /// The value `index` places after the first one; the ends repeat without end.
    fn knot(&self, index: usize) -> R {
        match self.breaks.get(index) {
            Some(knot) if index < self.last => *knot,
            _ => self.hi,
        }
    }

    /// Number i of the non-empty span with kept[i] <= t < kept[i + 1]; the last value belongs to the last of them.
    fn span(&self, t: R) -> usize {
        let (mut lo, mut hi) = (0, self.last);
        while hi - lo > 1 {
            let middle = (lo + hi) / 2;
            if self.knot(middle) <= t {
                lo = middle;
            } else {
                hi = middle;
            }
        }
        lo
    }

    pub fn holds(&self, t: R) -> Result<(), NurbsError> {
        if self.lo <= t && t <= self.hi {
            Ok(())
        } else {
            Err(NurbsError::OutOfDomain)
        }
    }

    /// All functions that do not vanish at `t`, which the domain must hold. (Checked apart, since a `Result` of them would
    /// be copied twice, which on the target costs as much as the functions.)
    ///
    /// The triangle of Cox and de Boor with its derivatives: from the functions n of degree r - 1, each divided by the
    /// width of its support, follow those of degree r and their slopes r (n_(j-1) - n_j).
    pub fn basis(&self, t: R) -> Basis<R> {
        let span = self.span(t);
        // Distances to the knots around t: left[j] to the j-th at or before it, right[j] to the j-th behind it.
        let mut left = [R::ZERO; MAX_DEGREE + 1];
        let mut right = [R::ZERO; MAX_DEGREE + 1];
        for j in 1..=MAX_DEGREE {
            if j > self.degree {
                break;
            }
            left[j] = t - self.knot((span + 1).saturating_sub(j));
            right[j] = self.knot(span + j) - t;
        }
        let mut functions = [[R::ZERO; 3]; MAX_DEGREE + 1];
        functions[0][0] = R::ONE;
        let mut degree = R::ZERO;
        for r in 1..=MAX_DEGREE {
            if r > self.degree {
                break;
            }
            degree += R::ONE;
            let (mut carried, mut value_before, mut slope_before) = (R::ZERO, R::ZERO, R::ZERO);
            for j in 0..r {
                let (to_left, to_right) = (left[r - j], right[j + 1]);
                let per_width = R::ONE / (to_left + to_right);
                let [value, slope, _] = functions[j];
                let (value, slope) = (value * per_width, slope * per_width);
                functions[j] = [
                    carried + to_right * value,
                    degree * (value_before - value),
                    degree * (slope_before - slope),
                ];
                carried = to_left * value;
                (value_before, slope_before) = (value, slope);
            }
            functions[r] = [carried, degree * value_before, degree * slope_before];
        }
        Basis {
            first: span,
            count: self.degree + 1,
            functions,
        }
    }
}
