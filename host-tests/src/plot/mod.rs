//! Numbers -> SVG: line charts, pulse trains, outline drawings. Each is one `<svg>` element that needs nothing else.
//!
//! Lines may have millions of points: of those that fall into one column of pixels only the first, the lowest, the
//! highest and the last are drawn, so that no peak is lost and no file is large.

mod chart;
mod drawing;
mod histogram;
mod map;
mod strip;
mod waves;

pub use chart::Chart;
pub use drawing::{Drawing, Pen};
pub use histogram::Histogram;
pub use map::Map;
pub use strip::Strip;
pub use waves::Waves;

use std::fmt::Write;

/// Colours of motors 0, 1, ...: dark enough on white, told apart by eyes that mix red and green.
pub const PALETTE: [&str; 8] = [
    "#0b6fb8", "#d1570c", "#1b8f5a", "#a3478f", "#4b4bb5", "#8a6d00", "#2b8c9c", "#5f6670",
];
/// Text, axes, grid, limits.
pub const INK: &str = "#222";
const AXIS: &str = "#667";
const GRID: &str = "#e7e9ec";
const LIMIT: &str = "#c0182b";

/// The colour of motor or line `index`.
pub fn colour(index: usize) -> &'static str {
    PALETTE[index % PALETTE.len()]
}

/// Text made safe inside XML.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            c => safe.push(c),
        }
    }
    safe
}

/// An SVG under construction.
struct Canvas {
    body: String,
    width: f64,
    height: f64,
}

/// Where a text hangs on its point.
#[derive(Clone, Copy)]
enum Anchor {
    Start,
    Middle,
    End,
}

impl Canvas {
    fn new(width: f64, height: f64) -> Self {
        Self {
            body: String::new(),
            width,
            height,
        }
    }

    /// Appends; a `String` takes everything, so there is no failure to pass on.
    fn put(&mut self, piece: std::fmt::Arguments<'_>) {
        let _ = self.body.write_fmt(piece);
    }

    fn line(&mut self, from: (f64, f64), to: (f64, f64), stroke: &str, width: f64, dash: &str) {
        let dash = dash_attribute(dash);
        self.put(format_args!(
            r#"<line x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}" stroke="{stroke}" stroke-width="{width}"{dash}/>"#,
            from.0, from.1, to.0, to.1
        ));
    }

    fn text(&mut self, at: (f64, f64), anchor: Anchor, fill: &str, size: f64, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.put(format_args!(
            r#"<text x="{:.1}" y="{:.1}" text-anchor="{anchor}" fill="{fill}" font-size="{size}">{}</text>"#,
            at.0,
            at.1,
            escape(text)
        ));
    }

    /// The left and the lower axis of a plot between two corners, and what they are called.
    fn axes(
        &mut self,
        (left, top): (f64, f64),
        (right, bottom): (f64, f64),
        x_label: &str,
        y_label: &str,
    ) {
        self.line((left, top), (left, bottom), AXIS, 1.0, "");
        self.line((left, bottom), (right, bottom), AXIS, 1.0, "");
        let below = ((left + right) / 2.0, self.height - 7.0);
        self.text(below, Anchor::Middle, INK, 11.5, x_label);
        self.put(format_args!(
            r#"<g transform="translate(13 {:.1}) rotate(-90)">"#,
            (top + bottom) / 2.0
        ));
        self.text((0.0, 0.0), Anchor::Middle, INK, 11.5, y_label);
        self.put(format_args!("</g>"));
    }

    fn path(&mut self, data: &str, stroke: &str, width: f64, fill: &str, dash: &str) {
        let dash = dash_attribute(dash);
        self.put(format_args!(
            r#"<path d="{data}" fill="{fill}" stroke="{stroke}" stroke-width="{width}" stroke-linejoin="round"{dash}/>"#
        ));
    }

    fn rectangle(&mut self, at: (f64, f64), size: (f64, f64), fill: &str) {
        self.put(format_args!(
            r#"<rect x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}" fill="{fill}" shape-rendering="crispEdges"/>"#,
            at.0, at.1, size.0, size.1
        ));
    }

    /// The element; `label` tells in words what it shows.
    fn finish(self, label: &str) -> String {
        format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w:.0} {h:.0}" width="{w:.0}" height="{h:.0}" role="img" aria-label="{}" font-family="system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif">{}</svg>"#,
            escape(label),
            self.body,
            w = self.width,
            h = self.height
        )
    }
}

fn dash_attribute(dash: &str) -> String {
    if dash.is_empty() {
        String::new()
    } else {
        format!(r#" stroke-dasharray="{dash}""#)
    }
}

/// Path data of points in pixels; a point that is not finite interrupts the line.
fn path_data(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut data = String::new();
    let mut pen_down = false;
    let mut last = (i64::MIN, i64::MIN);
    for (x, y) in points {
        if !x.is_finite() || !y.is_finite() {
            pen_down = false;
            continue;
        }
        let rounded = ((x * 10.0).round() as i64, (y * 10.0).round() as i64);
        if pen_down && rounded == last {
            continue;
        }
        last = rounded;
        let _ = write!(
            data,
            "{}{} {}",
            if pen_down { 'L' } else { 'M' },
            rounded.0 as f64 / 10.0,
            rounded.1 as f64 / 10.0
        );
        pen_down = true;
    }
    data
}

/// Round places for ticks in `lo ..= hi`, about `count` of them, 1-2-5 apart, and the digits after the point they need.
fn ticks(lo: f64, hi: f64, count: usize) -> (Vec<f64>, usize) {
    let span = hi - lo;
    if !(span > 0.0 && span.is_finite()) || count == 0 {
        return (Vec::new(), 0);
    }
    let rough = span / count as f64;
    let magnitude = 10f64.powf(rough.log10().floor());
    // The round number nearest to the rough one, as a ratio: 1 up to 1.41, 2 up to 3.16, 5 up to 7.07.
    let ratio = rough / magnitude;
    let step = magnitude
        * match ratio * ratio {
            square if square < 2.0 => 1.0,
            square if square < 10.0 => 2.0,
            square if square < 50.0 => 5.0,
            _ => 10.0,
        };
    let digits = (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
    let first = (lo / step - 1e-9).ceil() as i64;
    let last = (hi / step + 1e-9).floor() as i64;
    let places = (first..=last).map(|k| k as f64 * step).collect();
    (places, digits)
}

/// A number with a fixed count of decimals, thousands set apart, a real minus sign.
pub fn number(value: f64, digits: usize) -> String {
    let plain = format!("{:.digits$}", value.abs());
    let (whole, fraction) = plain.split_once('.').unwrap_or((&plain, ""));
    let mut text = String::new();
    let zero = plain.bytes().all(|b| b == b'0' || b == b'.');
    if value < 0.0 && !zero {
        text.push('\u{2212}');
    }
    for (index, digit) in whole.chars().enumerate() {
        let left = whole.len() - index;
        if index > 0 && left.is_multiple_of(3) && whole.len() > 4 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    if !fraction.is_empty() {
        text.push('.');
        text.push_str(fraction);
    }
    text
}

/// Least and largest of the finite numbers.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |held, v| {
        Some(held.map_or((v, v), |(lo, hi): (f64, f64)| (lo.min(v), hi.max(v))))
    })
}
