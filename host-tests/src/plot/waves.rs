//! Pulse trains as a logic analyser shows them: one lane for each signal.

use super::{AXIS, Anchor, Canvas, GRID, INK, number, path_data, ticks};

struct Lane {
    name: String,
    colour: String,
    start: bool,
    changes: Vec<(f64, bool)>,
}

/// Digital signals over a common time axis.
pub struct Waves {
    title: String,
    x_label: String,
    range: (f64, f64),
    width: f64,
    lanes: Vec<Lane>,
}

const LEFT: f64 = 86.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 40.0;
const LANE: f64 = 22.0;
const SWING: f64 = 14.0;

impl Waves {
    /// No lanes yet; time from `lo` to `hi` in the unit that the label names.
    pub fn new(title: &str, x_label: &str, lo: f64, hi: f64) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            range: (lo, hi),
            width: 860.0,
            lanes: Vec::new(),
        }
    }

    /// Adds a lane: the level at the start of the range, then each change in order.
    pub fn lane(
        mut self,
        name: &str,
        colour: &str,
        start: bool,
        changes: impl IntoIterator<Item = (f64, bool)>,
    ) -> Self {
        self.lanes.push(Lane {
            name: name.into(),
            colour: colour.into(),
            start,
            changes: changes.into_iter().collect(),
        });
        self
    }

    /// The trains as one `<svg>` element.
    pub fn svg(&self) -> String {
        let (lo, hi) = self.range;
        let bottom = TOP + LANE * self.lanes.len() as f64 + 6.0;
        let mut canvas = Canvas::new(self.width, bottom + BOTTOM);
        let right = self.width - RIGHT;
        let pixel = |t: f64| LEFT + ((t - lo) / (hi - lo)).clamp(0.0, 1.0) * (right - LEFT);

        let (places, digits) = ticks(lo, hi, 9);
        for t in places {
            canvas.line((pixel(t), TOP), (pixel(t), bottom), GRID, 1.0, "");
            let label = number(t, digits);
            canvas.text((pixel(t), bottom + 15.0), Anchor::Middle, INK, 11.0, &label);
        }
        for (index, lane) in self.lanes.iter().enumerate() {
            let low = TOP + LANE * (index + 1) as f64 - 3.0;
            let height = |level: bool| if level { low - SWING } else { low };
            canvas.text((LEFT - 8.0, low - 3.0), Anchor::End, INK, 11.0, &lane.name);
            let mut level = lane.start;
            let mut points = vec![(LEFT, height(level))];
            for (t, new) in lane.changes.iter().filter(|(t, _)| *t >= lo && *t <= hi) {
                points.push((pixel(*t), height(level)));
                points.push((pixel(*t), height(*new)));
                level = *new;
            }
            points.push((right, height(level)));
            canvas.path(&path_data(points), &lane.colour, 1.2, "none", "");
        }
        canvas.line((LEFT, TOP), (LEFT, bottom), AXIS, 1.0, "");
        canvas.line((LEFT, bottom), (right, bottom), AXIS, 1.0, "");
        let middle = (LEFT + right) / 2.0;
        canvas.text(
            (middle, bottom + BOTTOM - 7.0),
            Anchor::Middle,
            INK,
            11.5,
            &self.x_label,
        );
        canvas.put(format_args!(r#"<g font-weight="600">"#));
        canvas.text((LEFT, 17.0), Anchor::Start, INK, 12.5, &self.title);
        canvas.put(format_args!("</g>"));
        canvas.finish(&self.title)
    }
}
