//! Mean, spread and range of walls.

/// Figures of many walls, taken in one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    wanted: f64,
    tolerance: f64,
    count: u64,
    within: u64,
    mean: f64,
    /// Sum of squared distances from the mean (Welford: no difference of large sums).
    squares: f64,
    min: f64,
    max: f64,
}

impl Summary {
    /// Counts the walls within `tolerance` [mm] of the `wanted` one [mm].
    pub fn about(wanted: f64, tolerance: f64) -> Self {
        Self {
            wanted,
            tolerance,
            count: 0,
            within: 0,
            mean: 0.0,
            squares: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
        }
    }

    pub fn take(&mut self, wall: f64) {
        self.count += 1;
        self.within += u64::from((wall - self.wanted).abs() <= self.tolerance);
        let off = wall - self.mean;
        self.mean += off / self.count as f64;
        self.squares += off * (wall - self.mean);
        self.min = self.min.min(wall);
        self.max = self.max.max(wall);
    }

    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Standard deviation of all of them (population).
    pub fn sigma(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    pub fn min(&self) -> f64 {
        self.min
    }

    pub fn max(&self) -> f64 {
        self.max
    }

    /// Fraction within the tolerance.
    pub fn within(&self) -> f64 {
        self.within as f64 / self.count as f64
    }
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation estimated from a sample (n - 1).
pub fn sample_sigma(values: &[f64]) -> f64 {
    let m = mean(values);
    let squares: f64 = values.iter().map(|x| (x - m) * (x - m)).sum();
    (squares / (values.len() as f64 - 1.0)).sqrt()
}
