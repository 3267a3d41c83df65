//! Line charts: many lines over one horizontal axis, with limits drawn in.

use super::{Anchor, Canvas, GRID, INK, LIMIT, number, path_data, range, ticks};

struct Line {
    name: String,
    colour: String,
    points: Vec<(f64, f64)>,
}

struct Limit {
    name: String,
    y: f64,
}

/// A chart of lines; see the page of [`plot`](super).
pub struct Chart {
    title: String,
    x_label: String,
    y_label: String,
    size: (f64, f64),
    lines: Vec<Line>,
    limits: Vec<Limit>,
    x_range: Option<(f64, f64)>,
    y_range: Option<(f64, f64)>,
}

pub(super) const LEFT: f64 = 66.0;
pub(super) const RIGHT: f64 = 16.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 40.0;

impl Chart {
    /// An empty chart, 860 by 260 pixels. Labels carry their unit: `"time [s]"`.
    pub fn new(title: &str, x_label: &str, y_label: &str) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            size: (860.0, 260.0),
            lines: Vec::new(),
            limits: Vec::new(),
            x_range: None,
            y_range: None,
        }
    }

    /// Width and height in pixels.
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width, height);
        self
    }

    /// Adds a line; a point that is not finite interrupts it.
    pub fn line(
        mut self,
        name: &str,
        colour: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.lines.push(Line {
            name: name.into(),
            colour: colour.into(),
            points: points.into_iter().collect(),
        });
        self
    }

    /// Adds a dashed horizontal line at `y`.
    pub fn limit(mut self, name: &str, y: f64) -> Self {
        self.limits.push(Limit {
            name: name.into(),
            y,
        });
        self
    }

    /// Fixes the horizontal range; what lies outside is cut off.
    pub fn x_range(mut self, lo: f64, hi: f64) -> Self {
        self.x_range = Some((lo, hi));
        self
    }

    /// Fixes the vertical range.
    pub fn y_range(mut self, lo: f64, hi: f64) -> Self {
        self.y_range = Some((lo, hi));
        self
    }

    /// The chart as one `<svg>` element.
    pub fn svg(&self) -> String {
        let (width, height) = self.size;
        let mut canvas = Canvas::new(width, height);
        let (x_lo, x_hi) = spread(self.x_range.or_else(|| {
            range(
                self.lines
                    .iter()
                    .flat_map(|line| line.points.iter().map(|p| p.0)),
            )
        }));
        let inside = |x: f64| x >= x_lo && x <= x_hi;
        let (y_lo, y_hi) = match self.y_range {
            Some(range) => spread(Some(range)),
            None => {
                let lines = self.lines.iter().flat_map(|line| {
                    line.points
                        .iter()
                        .filter(|p| inside(p.0))
                        .map(|point| point.1)
                });
                let (lo, hi) = spread(range(lines.chain(self.limits.iter().map(|l| l.y))));
                let air = 0.06 * (hi - lo);
                (lo - air, hi + air)
            }
        };
        let (right, bottom) = (width - RIGHT, height - BOTTOM);
        let x_pixel = |x: f64| LEFT + (x - x_lo) / (x_hi - x_lo) * (right - LEFT);
        let y_pixel = |y: f64| bottom - (y - y_lo) / (y_hi - y_lo) * (bottom - TOP);

        // Grid and tick labels first, so that lines lie on top.
        let (x_ticks, x_digits) = ticks(x_lo, x_hi, (width / 90.0) as usize);
        for x in x_ticks {
            let px = x_pixel(x);
            canvas.line((px, TOP), (px, bottom), GRID, 1.0, "");
            let label = number(x, x_digits);
            canvas.text((px, bottom + 15.0), Anchor::Middle, INK, 11.0, &label);
        }
        let (y_ticks, y_digits) = ticks(y_lo, y_hi, ((bottom - TOP) / 32.0) as usize);
        for y in y_ticks {
            let py = y_pixel(y);
            let zero = y == 0.0;
            canvas.line(
                (LEFT, py),
                (right, py),
                if zero { "#b9bec5" } else { GRID },
                1.0,
                "",
            );
            let label = number(y, y_digits);
            canvas.text((LEFT - 7.0, py + 4.0), Anchor::End, INK, 11.0, &label);
        }
        canvas.axes((LEFT, TOP), (right, bottom), &self.x_label, &self.y_label);

        for line in &self.lines {
            let points = thinned(
                line.points
                    .iter()
                    .filter(|p| !p.0.is_finite() || inside(p.0))
                    .map(|(x, y)| (x_pixel(*x), y_pixel(*y).clamp(TOP - 2.0, bottom + 2.0))),
            );
            canvas.path(&path_data(points), &line.colour, 1.4, "none", "");
        }
        for limit in &self.limits {
            let y = y_pixel(limit.y);
            if (TOP..=bottom).contains(&y) {
                canvas.line((LEFT, y), (right, y), LIMIT, 1.2, "6 4");
                // A name stands on its line, or hangs below it where another line is close above.
                let mut others = self.limits.iter().map(|other| y - y_pixel(other.y));
                let is_close = others.any(|above| above > 0.0 && above < 14.0);
                let text = if is_close { y + 11.0 } else { y - 4.0 };
                canvas.text((right - 4.0, text), Anchor::End, LIMIT, 10.5, &limit.name);
            }
        }

        canvas.put(format_args!(r#"<g font-weight="600">"#));
        canvas.text((LEFT, 17.0), Anchor::Start, INK, 12.5, &self.title);
        canvas.put(format_args!("</g>"));
        self.legend(&mut canvas, right);
        canvas.finish(&self.title)
    }

    /// Names of the lines in one row at the top right; a single line needs none.
    fn legend(&self, canvas: &mut Canvas, right: f64) {
        if self.lines.len() < 2 {
            return;
        }
        let mut x = right;
        for line in self.lines.iter().rev() {
            // 6.4 px a character at this size is on the safe side in every font of the list.
            let text = line.name.chars().count() as f64 * 6.4;
            canvas.text((x, 17.0), Anchor::End, INK, 11.0, &line.name);
            let stop = x - text - 5.0;
            canvas.line((stop - 16.0, 13.0), (stop, 13.0), &line.colour, 2.4, "");
            x = stop - 28.0;
        }
    }
}

/// A range that is not empty.
fn spread(range: Option<(f64, f64)>) -> (f64, f64) {
    match range {
        Some((lo, hi)) if lo.is_finite() && hi.is_finite() && hi > lo => (lo, hi),
        Some((lo, _)) if lo.is_finite() => (lo - 1.0, lo + 1.0),
        _ => (0.0, 1.0),
    }
}

/// First, lowest, highest and last point of each column of pixels, in the order in which they came.
fn thinned(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    let mut column: Vec<(f64, f64)> = Vec::new();
    let mut place = i64::MIN;
    for point in points {
        let here = if point.0.is_finite() {
            point.0.floor() as i64
        } else {
            i64::MAX
        };
        if here != place {
            flush(&mut column, &mut kept);
            place = here;
        }
        // First, lowest and highest so far, last: three suffice besides the newest.
        column.push(point);
        if column.len() > 64 {
            let few = extremes(&column);
            column = few;
        }
    }
    flush(&mut column, &mut kept);
    kept
}

fn flush(column: &mut Vec<(f64, f64)>, kept: &mut Vec<(f64, f64)>) {
    kept.extend(extremes(column));
    column.clear();
}

fn extremes(column: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if column.len() <= 4 {
        return column.to_vec();
    }
    let by_height = |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
    let lowest = column.iter().enumerate().min_by(by_height);
    let highest = column.iter().enumerate().max_by(by_height);
    let mut places = vec![0, column.len() - 1];
    places.extend([lowest, highest].into_iter().flatten().map(|(i, _)| i));
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|i| column[i]).collect()
}
