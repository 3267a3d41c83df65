//! Points and tool axes in space -> an isometric picture: x to the lower right, y to the upper right, z up.

use crate::plot::{Drawing, Pen};

type V = [f64; 3];

/// A picture under construction.
pub struct Space {
    drawing: Vec<(Vec<(f64, f64)>, Stroke)>,
    dots: Vec<((f64, f64), String)>,
    names: Vec<((f64, f64), String)>,
    /// Length of a drawn tool axis, and of the arrows of the frame [mm].
    length: f64,
    /// Where the frame is drawn.
    corner: V,
}

struct Stroke {
    colour: String,
    width: f64,
    fill: String,
    dash: String,
}

impl Stroke {
    fn of(pen: Pen<'_>) -> Self {
        Self {
            colour: pen.colour.into(),
            width: pen.width,
            fill: pen.fill.into(),
            dash: pen.dash.into(),
        }
    }

    fn pen(&self) -> Pen<'_> {
        Pen {
            colour: &self.colour,
            width: self.width,
            fill: &self.fill,
            dash: &self.dash,
        }
    }
}

/// On the sheet, seen from (1, -1, 1).
fn project([x, y, z]: V) -> (f64, f64) {
    let (sin, cos) = 30f64.to_radians().sin_cos();
    ((x + y) * cos, z + (y - x) * sin)
}

impl Space {
    /// A picture of what lies about these tips.
    pub fn of(tips: impl IntoIterator<Item = V>) -> Self {
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for tip in tips {
            for i in 0..3 {
                lo[i] = lo[i].min(tip[i]);
                hi[i] = hi[i].max(tip[i]);
            }
        }
        let extent = (0..3).map(|i| (hi[i] - lo[i]).powi(2)).sum::<f64>().sqrt();
        Self {
            drawing: Vec::new(),
            dots: Vec::new(),
            names: Vec::new(),
            length: (0.16 * extent).max(1.0),
            corner: lo.map(|x| if x.is_finite() { x } else { 0.0 }),
        }
    }

    pub fn path(&mut self, points: impl IntoIterator<Item = V>, pen: Pen<'_>) {
        let points = points.into_iter().map(project).collect();
        self.drawing.push((points, Stroke::of(pen)));
    }

    /// A tool: a line from its tip along its axis.
    pub fn tool(&mut self, tip: V, axis: V, pen: Pen<'_>) {
        let end = std::array::from_fn(|i| tip[i] + axis[i] * self.length);
        self.path([tip, end], pen);
    }

    pub fn dot(&mut self, at: V, colour: &str) {
        self.dots.push((project(at), colour.into()));
    }

    /// A name a little outside of `at`, on the line from `from` through it.
    pub fn name(&mut self, from: V, at: V, name: &str) {
        let beyond = std::array::from_fn(|i| at[i] + 0.09 * (at[i] - from[i]));
        self.names.push((project(beyond), name.into()));
    }

    /// The picture as one `<svg>` element.
    pub fn svg(&self, title: &str) -> String {
        let corners = || self.drawing.iter().flat_map(|(points, _)| points);
        let extent = |of: &dyn Fn(&(f64, f64)) -> f64| {
            let least = corners().map(of).fold(f64::INFINITY, f64::min);
            let most = corners().map(of).fold(f64::NEG_INFINITY, f64::max);
            (most - least).max(1e-9)
        };
        let (wide, high) = (extent(&|p| p.0), extent(&|p| p.1));
        // At most 520 pixels high, and as wide as the page where the picture is flat.
        let width = (520.0 * wide / high).clamp(360.0, 860.0);
        let mut drawing = Drawing::new(title, width);
        // The frame stands to the left of everything, on the floor.
        let least = corners().map(|p| p.0).fold(f64::INFINITY, f64::min);
        let (_, floor) = project(self.corner);
        let foot = corners().map(|p| p.1).fold(floor, f64::min);
        let arrow = 0.5 * self.length;
        let origin = (least - 1.6 * arrow, foot + 0.6 * arrow);
        for (name, axis) in [
            ("x", [1.0, 0.0, 0.0]),
            ("y", [0.0, 1.0, 0.0]),
            ("z", [0.0, 0.0, 1.0]),
        ] {
            let (dx, dy) = project(axis.map(|a: f64| a * arrow));
            let end = (origin.0 + dx, origin.1 + dy);
            drawing = drawing.line([origin, end], Pen::EDGE);
            drawing = drawing.text((origin.0 + 1.25 * dx, origin.1 + 1.25 * dy), name);
        }
        for (points, stroke) in &self.drawing {
            drawing = drawing.line(points.iter().copied(), stroke.pen());
        }
        for (at, name) in &self.names {
            drawing = drawing.text(*at, name);
        }
        // Two pixels in the drawing's own unit.
        let radius = 2.4 * wide.max(1e-9) / width;
        for (at, colour) in &self.dots {
            let pen = Pen {
                colour,
                width: 1.0,
                fill: colour,
                dash: "",
            };
            drawing = drawing.circle(*at, radius, pen);
        }
        drawing.svg()
    }
}
