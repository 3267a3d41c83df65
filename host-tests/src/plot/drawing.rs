//! Outline drawings with one scale for both axes: shapes, dimensions, angles. Lengths in the drawing's own unit, y up.

use super::{Anchor, Canvas, INK, escape, path_data};

/// How a shape is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen<'a> {
    pub colour: &'a str,
    /// Line width in pixels.
    pub width: f64,
    /// Fill colour, or `"none"`.
    pub fill: &'a str,
    /// Lengths of dashes and gaps in pixels, or empty.
    pub dash: &'a str,
}

impl Pen<'_> {
    /// A visible edge.
    pub const EDGE: Self = Self {
        colour: INK,
        width: 1.6,
        fill: "none",
        dash: "",
    };
    /// A thin line: outlines that matter less.
    pub const THIN: Self = Self {
        colour: "#7a828c",
        width: 0.8,
        fill: "none",
        dash: "",
    };
    /// An axis or a line of symmetry.
    pub const CENTRE: Self = Self {
        colour: "#7a828c",
        width: 0.8,
        fill: "none",
        dash: "12 3 2 3",
    };
}

type Point = (f64, f64);

enum Shape {
    Line(Vec<Point>, String, f64, String, String),
    Text(Point, Side, String),
    /// Centre, radius, from, to [rad], label.
    Angle(Point, f64, f64, f64, String),
    /// Ends and label.
    Dimension(Point, Point, String),
}

#[derive(Clone, Copy)]
enum Side {
    Left,
    Middle,
    Right,
}

/// A drawing to scale.
pub struct Drawing {
    title: String,
    width: f64,
    shapes: Vec<Shape>,
}

const MARGIN: f64 = 46.0;
const TOP: f64 = 34.0;

impl Drawing {
    /// An empty drawing of `width` pixels; its height follows from what it shows.
    pub fn new(title: &str, width: f64) -> Self {
        Self {
            title: title.into(),
            width,
            shapes: Vec::new(),
        }
    }

    /// Adds a line through points; one that is not finite interrupts it.
    pub fn line(mut self, points: impl IntoIterator<Item = Point>, pen: Pen<'_>) -> Self {
        self.shapes.push(Shape::Line(
            points.into_iter().collect(),
            pen.colour.into(),
            pen.width,
            pen.fill.into(),
            pen.dash.into(),
        ));
        self
    }

    /// Adds a circle.
    pub fn circle(self, centre: Point, radius: f64, pen: Pen<'_>) -> Self {
        let points = (0..=180).map(|k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 180.0).sin_cos();
            (centre.0 + radius * cos, centre.1 + radius * sin)
        });
        self.line(points, pen)
    }

    /// Adds a text centred on a point.
    pub fn text(self, at: Point, text: &str) -> Self {
        self.text_on(at, Side::Middle, text)
    }

    /// Adds a text that begins at a point.
    pub fn text_right_of(self, at: Point, text: &str) -> Self {
        self.text_on(at, Side::Right, text)
    }

    /// Adds a text that ends at a point.
    pub fn text_left_of(self, at: Point, text: &str) -> Self {
        self.text_on(at, Side::Left, text)
    }

    fn text_on(mut self, at: Point, side: Side, text: &str) -> Self {
        self.shapes.push(Shape::Text(at, side, text.into()));
        self
    }

    /// Adds an arc from one direction to the other [rad], counted anticlockwise, with arrow ends and a label in its middle.
    pub fn angle(mut self, centre: Point, radius: f64, from: f64, to: f64, label: &str) -> Self {
        self.shapes
            .push(Shape::Angle(centre, radius, from, to, label.into()));
        self
    }

    /// Adds a dimension line between two points with a label.
    pub fn dimension(mut self, from: Point, to: Point, label: &str) -> Self {
        self.shapes.push(Shape::Dimension(from, to, label.into()));
        self
    }

    /// The drawing as one `<svg>` element.
    pub fn svg(&self) -> String {
        let (lo, hi) = self.bounds();
        let scale = (self.width - 2.0 * MARGIN) / (hi.0 - lo.0);
        let height = TOP + (hi.1 - lo.1) * scale + MARGIN * 0.6;
        let mut canvas = Canvas::new(self.width, height);
        let pixel = |p: Point| (MARGIN + (p.0 - lo.0) * scale, TOP + (hi.1 - p.1) * scale);
        for shape in &self.shapes {
            match shape {
                Shape::Line(points, colour, width, fill, dash) => {
                    let data = path_data(points.iter().map(|p| pixel(*p)));
                    canvas.path(&data, colour, *width, fill, dash);
                }
                Shape::Text(at, side, text) => {
                    let (x, y) = pixel(*at);
                    let anchor = match side {
                        Side::Left => Anchor::End,
                        Side::Middle => Anchor::Middle,
                        Side::Right => Anchor::Start,
                    };
                    halo(&mut canvas, (x, y + 4.0), anchor, text);
                }
                Shape::Angle(centre, radius, from, to, label) => {
                    let on = |angle: f64, r: f64| {
                        pixel((centre.0 + r * angle.cos(), centre.1 + r * angle.sin()))
                    };
                    let arc =
                        (0..=60).map(|k| on(from + (to - from) * f64::from(k) / 60.0, *radius));
                    canvas.path(&path_data(arc), ARROW, 1.0, "none", "");
                    // Arrows along the tangents, pointing outwards at both ends; pixels have y down.
                    let turn = (to - from).signum();
                    for (angle, sign) in [(*from, -turn), (*to, turn)] {
                        let tip = on(angle, *radius);
                        let along = (-angle.sin() * sign, -angle.cos() * sign);
                        arrow(&mut canvas, tip, along);
                    }
                    let middle = 0.5 * (from + to);
                    let (x, y) = on(middle, *radius);
                    let (dx, dy) = (middle.cos(), -middle.sin());
                    let half = label.chars().count() as f64 * 3.2;
                    let at = (x + dx * (half + 6.0), y + dy * 12.0 + 4.0);
                    halo(&mut canvas, at, Anchor::Middle, label);
                }
                Shape::Dimension(from, to, label) => {
                    let (a, b) = (pixel(*from), pixel(*to));
                    canvas.line(a, b, ARROW, 1.0, "");
                    let length = (b.0 - a.0).hypot(b.1 - a.1).max(1e-9);
                    let along = ((b.0 - a.0) / length, (b.1 - a.1) / length);
                    arrow(&mut canvas, b, along);
                    arrow(&mut canvas, a, (-along.0, -along.1));
                    let middle = ((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0 + 4.0);
                    halo(&mut canvas, middle, Anchor::Middle, label);
                }
            }
        }
        canvas.put(format_args!(r#"<g font-weight="600">"#));
        canvas.text((12.0, 17.0), Anchor::Start, INK, 12.5, &self.title);
        canvas.put(format_args!("</g>"));
        canvas.finish(&self.title)
    }

    /// Corners of the smallest rectangle around everything.
    fn bounds(&self) -> (Point, Point) {
        let mut lo = (f64::INFINITY, f64::INFINITY);
        let mut hi = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let mut take = |p: Point| {
            if p.0.is_finite() && p.1.is_finite() {
                lo = (lo.0.min(p.0), lo.1.min(p.1));
                hi = (hi.0.max(p.0), hi.1.max(p.1));
            }
        };
        for shape in &self.shapes {
            match shape {
                Shape::Line(points, ..) => points.iter().copied().for_each(&mut take),
                Shape::Text(at, ..) => take(*at),
                Shape::Angle(centre, radius, from, to, _) => {
                    for k in 0..=8 {
                        let angle = from + (to - from) * f64::from(k) / 8.0;
                        take((
                            centre.0 + radius * angle.cos(),
                            centre.1 + radius * angle.sin(),
                        ));
                    }
                }
                Shape::Dimension(from, to, _) => {
                    take(*from);
                    take(*to);
                }
            }
        }
        if !(lo.0 < hi.0 && lo.1 <= hi.1) {
            return ((0.0, 0.0), (1.0, 1.0));
        }
        (lo, hi)
    }
}

const ARROW: &str = "#4a5560";

/// A solid arrow head with its tip at `tip`, pointing `along` (unit length, pixels).
fn arrow(canvas: &mut Canvas, tip: Point, along: Point) {
    let (length, half) = (8.0, 2.4);
    let back = (tip.0 - along.0 * length, tip.1 - along.1 * length);
    let side = (-along.1 * half, along.0 * half);
    let mut data = path_data([
        tip,
        (back.0 + side.0, back.1 + side.1),
        (back.0 - side.0, back.1 - side.1),
    ]);
    data.push('Z');
    canvas.path(&data, ARROW, 0.5, ARROW, "");
}

/// A text with a white rim, readable across lines.
fn halo(canvas: &mut Canvas, at: Point, anchor: Anchor, text: &str) {
    let anchor = match anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    canvas.put(format_args!(
        r##"<text x="{:.1}" y="{:.1}" text-anchor="{anchor}" font-size="11.5" fill="{INK}" stroke="#fff" stroke-width="4" paint-order="stroke">{}</text>"##,
        at.0,
        at.1,
        escape(text)
    ));
}
