//! How often which value -> bars, with the ranges that others have reached beside them.

use super::{Anchor, Canvas, GRID, INK, LIMIT, number, ticks};

/// A histogram under construction.
pub struct Histogram {
    title: String,
    x_label: String,
    size: (f64, f64),
    x: (f64, f64),
    shares: Vec<f64>,
    colour: String,
    bands: Vec<(f64, f64, String)>,
    limits: Vec<(f64, String)>,
}

const LEFT: f64 = 66.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 40.0;

impl Histogram {
    /// Values in cells of equal width from `x.0` to `x.1`.
    pub fn new(
        title: &str,
        x_label: &str,
        x: (f64, f64),
        cells: usize,
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        let mut counts = vec![0u32; cells];
        let mut all = 0u32;
        for value in values {
            all += 1;
            let cell = (value - x.0) / (x.1 - x.0) * cells as f64;
            // Below the first cell a cast would say 0.
            if cell >= 0.0
                && let Some(count) = counts.get_mut(cell as usize)
            {
                *count += 1;
            }
        }
        Self::of_counts(title, x_label, x, &counts, all)
    }

    /// The same from counts that were taken elsewhere, of `all` values.
    pub fn of_counts(title: &str, x_label: &str, x: (f64, f64), counts: &[u32], all: u32) -> Self {
        let share = |count: &u32| f64::from(*count) / f64::from(all.max(1)) * 100.0;
        Self {
            title: title.into(),
            x_label: x_label.into(),
            size: (860.0, 190.0),
            x,
            shares: counts.iter().map(share).collect(),
            colour: super::colour(0).into(),
            bands: Vec::new(),
            limits: Vec::new(),
        }
    }

    /// Pixels.
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width, height);
        self
    }

    pub fn colour(mut self, colour: &str) -> Self {
        self.colour = colour.into();
        self
    }

    /// A range that somebody else has reached.
    pub fn band(mut self, lo: f64, hi: f64, name: &str) -> Self {
        self.bands.push((lo, hi, name.into()));
        self
    }

    pub fn limit(mut self, x: f64, name: &str) -> Self {
        self.limits.push((x, name.into()));
        self
    }

    /// The histogram as one `<svg>` element.
    pub fn svg(&self) -> String {
        let (width, height) = self.size;
        let mut canvas = Canvas::new(width, height);
        let (right, bottom) = (width - RIGHT, height - BOTTOM);
        let (x_lo, x_hi) = self.x;
        // Bars end below the names of bands and limits.
        let names = match (self.bands.is_empty(), self.limits.is_empty()) {
            (_, false) => 32.0,
            (false, true) => 18.0,
            (true, true) => 8.0,
        };
        let air = (bottom - TOP) / (bottom - TOP - names).max(1.0);
        let most = self.shares.iter().copied().fold(1e-9, f64::max) * air;
        let x_pixel = |x: f64| LEFT + ((x - x_lo) / (x_hi - x_lo)).clamp(0.0, 1.0) * (right - LEFT);
        let y_pixel = |y: f64| bottom - y / most * (bottom - TOP);
        for (lo, hi, name) in &self.bands {
            let (a, b) = (x_pixel(*lo), x_pixel(*hi));
            canvas.rectangle((a, TOP), (b - a, bottom - TOP), "#f3ead3");
            canvas.text(
                ((a + b) / 2.0, TOP + 13.0),
                Anchor::Middle,
                "#7a6420",
                10.5,
                name,
            );
        }
        let (places, digits) = ticks(0.0, most, ((bottom - TOP) / 28.0) as usize);
        for y in places {
            let py = y_pixel(y);
            canvas.line((LEFT, py), (right, py), GRID, 1.0, "");
            let label = number(y, digits);
            canvas.text((LEFT - 7.0, py + 4.0), Anchor::End, INK, 11.0, &label);
        }
        let cell = (right - LEFT) / self.shares.len().max(1) as f64;
        for (k, share) in self.shares.iter().enumerate() {
            if *share > 0.0 {
                let y = y_pixel(*share).min(bottom - 0.8);
                let at = (LEFT + k as f64 * cell, y);
                canvas.rectangle(at, ((cell - 0.4).max(0.6), bottom - y), &self.colour);
            }
        }
        let (places, digits) = ticks(x_lo, x_hi, (width / 80.0) as usize);
        for x in places {
            let label = number(x, digits);
            canvas.text(
                (x_pixel(x), bottom + 15.0),
                Anchor::Middle,
                INK,
                11.0,
                &label,
            );
        }
        for (x, name) in &self.limits {
            let px = x_pixel(*x);
            canvas.line((px, TOP), (px, bottom), LIMIT, 1.2, "6 4");
            let (at, anchor) = if px > (LEFT + right) / 2.0 + 250.0 {
                (px - 4.0, Anchor::End)
            } else {
                (px + 4.0, Anchor::Start)
            };
            canvas.text((at, TOP + 27.0), anchor, LIMIT, 10.5, name);
        }
        canvas.axes((LEFT, TOP), (right, bottom), &self.x_label, "share [%]");
        canvas.put(format_args!(r#"<g font-weight="600">"#));
        canvas.text((LEFT, 17.0), Anchor::Start, INK, 12.5, &self.title);
        canvas.put(format_args!("</g>"));
        canvas.finish(&self.title)
    }
}
