//! Cubic spline over equidistant nodes, not-a-knot at both ends: the third derivative does not jump at the second
//! and the last but one node.

/// A twice differentiable curve through its nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    start: f64,
    width: f64,
    values: Vec<f64>,
    /// Second derivatives at the nodes.
    bends: Vec<f64>,
}

/// Value, slope and bend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    pub value: f64,
    pub slope: f64,
    pub bend: f64,
}

impl Spline {
    /// At least five values, evenly over `start ..= end`.
    pub fn new(start: f64, end: f64, values: Vec<f64>) -> Self {
        let n = values.len();
        debug_assert!(n >= 5);
        let width = (end - start) / (n - 1) as f64;
        // Twice the second difference each: m[i-1] + 4 m[i] + m[i+1] = 6 (f[i-1] - 2 f[i] + f[i+1]) / h^2.
        let load: Vec<f64> = values
            .windows(3)
            .map(|w| 6.0 * (w[0] - 2.0 * w[1] + w[2]) / (width * width))
            .collect();
        let mut bends = vec![0.0; n];
        // m[0] = 2 m[1] - m[2] makes the second equation 6 m[1] = its load; the same at the other end.
        bends[1] = load[0] / 6.0;
        bends[n - 2] = load[n - 3] / 6.0;
        // Elimination between these two.
        let mut pivots = vec![0.0; n];
        for i in 2..n - 2 {
            let (before, factor) = if i == 2 {
                (bends[1], 0.0)
            } else {
                (bends[i - 1], pivots[i - 1])
            };
            let pivot = 1.0 / (4.0 - factor);
            pivots[i] = pivot;
            bends[i] = (load[i - 1] - before) * pivot;
        }
        for i in (2..n - 2).rev() {
            bends[i] -= pivots[i] * bends[i + 1];
        }
        bends[0] = 2.0 * bends[1] - bends[2];
        bends[n - 1] = 2.0 * bends[n - 2] - bends[n - 3];
        Self {
            start,
            width,
            values,
            bends,
        }
    }

    pub fn nodes(&self) -> usize {
        self.values.len()
    }

    pub fn node(&self, i: usize) -> f64 {
        self.start + self.width * i as f64
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    pub fn at(&self, x: f64) -> Local {
        let last = self.values.len() - 2;
        let i = (((x - self.start) / self.width).max(0.0) as usize).min(last);
        let (h, right) = (self.width, (x - self.node(i)) / self.width);
        let left = 1.0 - right;
        let (f0, f1) = (self.values[i], self.values[i + 1]);
        let (m0, m1) = (self.bends[i], self.bends[i + 1]);
        let square = h * h / 6.0;
        Local {
            value: left * f0
                + right * f1
                + square * ((left * left - 1.0) * left * m0 + (right * right - 1.0) * right * m1),
            slope: (f1 - f0) / h
                + h / 6.0 * ((1.0 - 3.0 * left * left) * m0 + (3.0 * right * right - 1.0) * m1),
            bend: left * m0 + right * m1,
        }
    }

    /// Value, slope and bend at node `i`.
    pub fn at_node(&self, i: usize) -> Local {
        let x = self.node(i);
        Local {
            value: self.values[i],
            ..self.at(x)
        }
    }
}
