//! Bands of colour over time: which of some kinds held when.

use super::chart::{LEFT, RIGHT};
use super::{AXIS, Anchor, Canvas, INK, number, ticks};

struct Lane {
    name: String,
    /// From, to, and the kind in between.
    stretches: Vec<(f64, f64, usize)>,
    /// Names and colours.
    kinds: Vec<(String, String)>,
}

/// Lanes of colour, each with its legend, that lie below a [`Chart`](super::Chart) of the same range.
pub struct Strip {
    title: String,
    x_label: String,
    range: (f64, f64),
    lanes: Vec<Lane>,
}

const WIDTH: f64 = 860.0;
const TOP: f64 = 26.0;
const LEGEND: f64 = 18.0;
const BAND: f64 = 18.0;
const GAP: f64 = 8.0;
const BOTTOM: f64 = 38.0;

impl Strip {
    /// No lanes yet.
    pub fn new(title: &str, x_label: &str, lo: f64, hi: f64) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            range: (lo, hi),
            lanes: Vec::new(),
        }
    }

    /// Adds a lane: stretches with an index into its kinds, of which each has a name and a colour.
    pub fn lane(
        mut self,
        name: &str,
        kinds: impl IntoIterator<Item = (String, String)>,
        stretches: impl IntoIterator<Item = (f64, f64, usize)>,
    ) -> Self {
        self.lanes.push(Lane {
            name: name.into(),
            stretches: stretches.into_iter().collect(),
            kinds: kinds.into_iter().collect(),
        });
        self
    }

    /// The lanes as one `<svg>` element.
    pub fn svg(&self) -> String {
        let (lo, hi) = self.range;
        let bottom = TOP + self.lanes.len() as f64 * (LEGEND + BAND + GAP);
        let mut canvas = Canvas::new(WIDTH, bottom + BOTTOM);
        let right = WIDTH - RIGHT;
        let pixel = |t: f64| LEFT + ((t - lo) / (hi - lo)).clamp(0.0, 1.0) * (right - LEFT);
        for (index, lane) in self.lanes.iter().enumerate() {
            let legend = TOP + index as f64 * (LEGEND + BAND + GAP) + 11.0;
            let mut x = LEFT;
            for (name, colour) in &lane.kinds {
                canvas.rectangle((x, legend - 9.0), (11.0, 11.0), colour);
                canvas.text((x + 16.0, legend), Anchor::Start, INK, 11.0, name);
                x += 34.0 + 6.4 * name.chars().count() as f64;
            }
            let top = legend + LEGEND - 11.0;
            let middle = (LEFT - 7.0, top + 0.5 * BAND + 4.0);
            canvas.text(middle, Anchor::End, INK, 11.0, &lane.name);
            for (from, to, kind) in columns(lane, &pixel) {
                let colour = lane.kinds.get(kind).map_or("none", |kind| &kind.1);
                canvas.rectangle((from, top), (to - from, BAND), colour);
            }
        }
        let (places, digits) = ticks(lo, hi, (WIDTH / 90.0) as usize);
        for t in places {
            canvas.line(
                (pixel(t), bottom - GAP),
                (pixel(t), bottom - 2.0),
                AXIS,
                1.0,
                "",
            );
            let label = number(t, digits);
            canvas.text((pixel(t), bottom + 12.0), Anchor::Middle, INK, 11.0, &label);
        }
        let below = ((LEFT + right) / 2.0, bottom + BOTTOM - 8.0);
        canvas.text(below, Anchor::Middle, INK, 11.5, &self.x_label);
        canvas.put(format_args!(r#"<g font-weight="600">"#));
        canvas.text((LEFT, 17.0), Anchor::Start, INK, 12.5, &self.title);
        canvas.put(format_args!("</g>"));
        canvas.finish(&self.title)
    }
}

/// Stretches in pixels, however many there are in time: each column of pixels has the kind that held longest in it.
fn columns(lane: &Lane, pixel: &dyn Fn(f64) -> f64) -> Vec<(f64, f64, usize)> {
    let count = WIDTH as usize;
    let mut held = vec![vec![0.0f64; lane.kinds.len()]; count];
    for (from, to, kind) in &lane.stretches {
        let (from, to) = (pixel(*from), pixel(*to));
        let mut x = from;
        while x < to {
            let column = (x as usize).min(count - 1);
            let end = to.min((column + 1) as f64);
            if let Some(width) = held[column].get_mut(*kind) {
                *width += end - x;
            }
            x = end.max(x + 1e-6);
        }
    }
    let mut columns: Vec<(f64, f64, usize)> = Vec::new();
    for (column, kinds) in held.iter().enumerate() {
        let longest = kinds.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let Some((kind, _)) = longest.filter(|(_, width)| **width > 0.0) else {
            continue;
        };
        let (from, to) = (column as f64, (column + 1) as f64);
        match columns.last_mut() {
            Some(last) if last.2 == kind && last.1 == from => last.1 = to,
            _ => columns.push((from, to, kind)),
        }
    }
    columns
}
