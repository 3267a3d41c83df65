//! Values over a plane -> coloured cells with a scale beside them.

use super::{AXIS, Anchor, Canvas, INK, number, ticks};

/// A map under construction: `columns` x `rows` cells, row by row from below; `None` is left white.
pub struct Map {
    title: String,
    labels: (String, String),
    size: (f64, f64),
    cells: (usize, usize),
    values: Vec<Option<f64>>,
    x: (f64, f64),
    y: (f64, f64),
    scale: (f64, f64),
    unit: String,
}

const LEFT: f64 = 56.0;
const RIGHT: f64 = 76.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 40.0;

/// From low to high; each tells from its neighbours in brightness as well.
const STOPS: [[f64; 3]; 6] = [
    [68.0, 30.0, 105.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [190.0, 220.0, 80.0],
    [253.0, 231.0, 37.0],
];
/// What lies above the scale.
const OVER: &str = "#c3232e";

impl Map {
    pub fn new(title: &str, x_label: &str, y_label: &str) -> Self {
        Self {
            title: title.into(),
            labels: (x_label.into(), y_label.into()),
            size: (420.0, 330.0),
            cells: (0, 0),
            values: Vec::new(),
            x: (0.0, 1.0),
            y: (0.0, 1.0),
            scale: (0.0, 1.0),
            unit: String::new(),
        }
    }

    /// Pixels.
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width, height);
        self
    }

    pub fn range(mut self, x: (f64, f64), y: (f64, f64)) -> Self {
        (self.x, self.y) = (x, y);
        self
    }

    pub fn cells(mut self, columns: usize, rows: usize, values: Vec<Option<f64>>) -> Self {
        self.cells = (columns, rows);
        self.values = values;
        self
    }

    /// Values at the ends of the colours; above the upper one a cell is red.
    pub fn scale(mut self, lo: f64, hi: f64, unit: &str) -> Self {
        self.scale = (lo, hi);
        self.unit = unit.into();
        self
    }

    /// The map as one `<svg>` element.
    pub fn svg(&self) -> String {
        let (width, height) = self.size;
        let mut canvas = Canvas::new(width, height);
        let (right, bottom) = (width - RIGHT, height - BOTTOM);
        let (columns, rows) = self.cells;
        let (w, h) = (
            (right - LEFT) / columns.max(1) as f64,
            (bottom - TOP) / rows.max(1) as f64,
        );
        for row in 0..rows {
            let mut column = 0;
            // Neighbours of one colour are one rectangle.
            while column < columns {
                let colour_at = |column: usize| {
                    let value = self.values.get(row * columns + column).copied().flatten();
                    value.map(|value| self.colour(value))
                };
                let colour = colour_at(column);
                let mut end = column + 1;
                while end < columns && colour_at(end) == colour {
                    end += 1;
                }
                if let Some(colour) = colour {
                    let at = (LEFT + column as f64 * w, bottom - (row as f64 + 1.0) * h);
                    // A little larger, so that no seam shows.
                    canvas.rectangle(at, ((end - column) as f64 * w + 0.3, h + 0.3), &colour);
                }
                column = end;
            }
        }
        let (x_lo, x_hi) = self.x;
        let (y_lo, y_hi) = self.y;
        let (places, digits) = ticks(x_lo, x_hi, ((right - LEFT) / 70.0) as usize);
        for x in places {
            let px = LEFT + (x - x_lo) / (x_hi - x_lo) * (right - LEFT);
            canvas.line((px, bottom), (px, bottom + 4.0), AXIS, 1.0, "");
            canvas.text(
                (px, bottom + 16.0),
                Anchor::Middle,
                INK,
                11.0,
                &number(x, digits),
            );
        }
        let (places, digits) = ticks(y_lo, y_hi, ((bottom - TOP) / 40.0) as usize);
        for y in places {
            let py = bottom - (y - y_lo) / (y_hi - y_lo) * (bottom - TOP);
            canvas.line((LEFT - 4.0, py), (LEFT, py), AXIS, 1.0, "");
            canvas.text(
                (LEFT - 7.0, py + 4.0),
                Anchor::End,
                INK,
                11.0,
                &number(y, digits),
            );
        }
        canvas.axes((LEFT, TOP), (right, bottom), &self.labels.0, &self.labels.1);
        self.bar(&mut canvas, right + 16.0, bottom);
        canvas.put(format_args!(r#"<g font-weight="600">"#));
        canvas.text((LEFT, 17.0), Anchor::Start, INK, 12.5, &self.title);
        canvas.put(format_args!("</g>"));
        canvas.finish(&self.title)
    }

    fn bar(&self, canvas: &mut Canvas, left: f64, bottom: f64) {
        const PARTS: u32 = 60;
        let (lo, hi) = self.scale;
        let top = TOP + 14.0;
        for k in 0..PARTS {
            let share = (f64::from(k) + 0.5) / f64::from(PARTS);
            let part = (bottom - top) / f64::from(PARTS);
            let y = bottom - (f64::from(k) + 1.0) * part;
            let colour = self.colour(lo + share * (hi - lo));
            canvas.rectangle((left, y), (12.0, part + 0.3), &colour);
        }
        canvas.rectangle((left, TOP), (12.0, 11.0), OVER);
        canvas.text((left + 17.0, TOP + 9.0), Anchor::Start, INK, 10.5, "over");
        let (places, digits) = ticks(lo, hi, 7);
        for value in places {
            let y = bottom - (value - lo) / (hi - lo) * (bottom - top);
            canvas.text(
                (left + 17.0, y + 4.0),
                Anchor::Start,
                INK,
                10.5,
                &number(value, digits),
            );
        }
        canvas.text((left, bottom + 16.0), Anchor::Start, INK, 11.0, &self.unit);
    }

    fn colour(&self, value: f64) -> String {
        let (lo, hi) = self.scale;
        if value > hi {
            return OVER.into();
        }
        // In 64 steps: neighbours that look the same are the same.
        let share = ((value - lo) / (hi - lo) * 64.0).round() / 64.0;
        let place = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
        let below = (place as usize).min(STOPS.len() - 2);
        let part = place - below as f64;
        let [r, g, b]: [u8; 3] = std::array::from_fn(|i| {
            // 0 ..= 255, as the stops are.
            (STOPS[below][i] + part * (STOPS[below + 1][i] - STOPS[below][i])).round() as u8
        });
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
