//! The axis ratio kappa = a/b of a Hertz ellipse from the ratio of the relative curvatures, exactly.
//!
//! ```text
//!   k_max/k_min = R_D(0, kappa^2, 1) / R_D(0, 1, kappa^2)
//!
//!   a_0 = kappa, g_0 = 1:   a_(n+1) = (a_n + g_n)/2,  g_(n+1) = sqrt(a_n g_n)   ->   M, the mean of Gauss
//!   q_1 = (a_0 - g_0) / 2 (a_0 + g_0),  q_(n+1) = q_n (a_n - g_n) / 2 (a_n + g_n),  s = q_1 + q_2 + ...
//!   R_D(0, 1, kappa^2) = 3 pi (1 + s) / (4 M kappa^2),   R_D(0, kappa^2, 1) = 3 pi (1 - s) / (4 M)
//! ```
//!
//! Both integrals need the same mean (exchanging its two numbers changes the sign of the first difference alone), so one
//! loop of square roots gives the ratio kappa^2 (1 - s)/(1 + s). Nothing cancels near kappa = 1, where s is (kappa - 1)/4.
//!
//! Source: B. C. Carlson, Digital Library of Mathematical Functions 19.8(i), 19.22.10.

use crate::math::Real;

/// The two integrals at one axis ratio.
pub(super) struct Ellipse<R> {
    /// a/b >= 1.
    pub kappa: R,
    /// The mean of kappa and 1.
    mean: R,
    s: R,
}

impl<R: Real> Ellipse<R> {
    fn new(kappa: R) -> Self {
        let (mut a, mut g) = (kappa, R::ONE);
        let (mut q, mut s) = (R::ONE, R::ZERO);
        // The difference is squared each time: from 1e4 : 1 six rounds reach the precision of f64.
        for _ in 0..10 {
            let (sum, difference) = (a + g, a - g);
            q = q * R::HALF * difference / sum;
            s += q;
            // What is left of s is below q^2, of the mean below the square of the difference / 8.
            if q * R::of(1024.0) <= R::EPSILON {
                break;
            }
            g = (a * g).sqrt();
            a = sum * R::HALF;
        }
        Self {
            kappa,
            mean: (a + g) * R::HALF,
            s,
        }
    }

    /// The ellipse of bodies whose relative curvatures stand as `ratio` = k_max/k_min, 1 ..= 1e6.
    pub fn solve(ratio: R) -> Self {
        let mut log = R::of(2.0 / 3.0) * ratio.ln();
        // So near to a circle the first term of the series is exact to 1e-7 of the difference.
        if ratio < R::ONE + R::of(1e-6).max(R::of(100.0) * R::EPSILON) {
            return Self::new(log.exp());
        }
        // Newton on ln kappa. The fit of Brewe and Hamrock starts it within 4 %, the power 2/3 near the circle within less.
        if ratio > R::of(3.0) {
            log *= R::of(3.0 / core::f64::consts::PI);
        }
        let mut ellipse = Self::new(log.exp());
        for _ in 0..8 {
            let Self { kappa, s, .. } = ellipse;
            let squared = kappa * kappa;
            let (less, more) = (R::ONE - s, R::ONE + s);
            let off = (squared * less / (more * ratio)).ln();
            // d ln(ratio) / d ln(kappa) from the derivatives of K and E; 4 s/(kappa^2 - 1) is 1/2 at the circle.
            let slope = R::TWO + R::of(4.0) * s / ((squared - R::ONE) * less * more) - less / more;
            let change = off / slope;
            log -= change;
            if log <= R::ZERO {
                log = R::EPSILON;
            }
            ellipse = Self::new(log.exp());
            // The error left is about the square of the change.
            if change * change < R::EPSILON {
                break;
            }
        }
        ellipse
    }

    /// R_D(0, 1, kappa^2).
    pub fn r_d(&self) -> R {
        R::of(0.75) * R::PI * (R::ONE + self.s) / (self.mean * self.kappa * self.kappa)
    }

    /// b R_F(0, b^2, a^2), which is R_F(0, 1, kappa^2) = pi / 2 M.
    pub fn r_f(&self) -> R {
        R::HALF * R::PI / self.mean
    }
}
