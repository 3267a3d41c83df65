//! Figures and tables -> one HTML page that needs nothing else: no network, no script, and it prints well.

mod bias;
mod bounds;
mod contour;
mod counts;
mod drill;
mod finished;
mod ground;
mod index;
mod mirror;
mod motors;
mod outline;
mod pair;
mod path;
mod poses;
mod precession;
mod ruling;
mod shaping;
mod space;
mod surface;

pub use bounds::Bounds;
pub use contour::ContourError;
pub use counts::{CountsFigures, Deviation, LineFigures};
pub use drill::DrillFigures;
pub use finished::Finished;
pub use ground::{Feature, GroundDrill, Stroke};
pub use index::{Card, Standing, index};
pub use mirror::MirrorFigures;
pub use motors::{Channel, MotorFigures, Motors, Quantity, pulse_trains, window_for};
pub use pair::{PairFigures, motor_names};
pub use path::PathFigures;
pub use poses::PosesFigures;
pub use precession::PrecessionFigures;
pub use ruling::{Limit, Ruler, Ruling};
pub use shaping::ShapingFigures;
pub use space::Space;
pub use surface::SurfaceFigures;

use crate::plot::escape;
use std::fmt::Write;

/// A page under construction: title, then whatever is added, in order.
pub struct Report {
    title: String,
    body: String,
    open_section: bool,
}

/// How a cell of a table stands.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    Text(String),
    /// Set flush right, digits of equal width.
    Number(String),
    /// A figure that is judged: within its limit or not.
    Judged(String, bool),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

const STYLE: &str = "\
:root{color-scheme:light}\
body{margin:0 auto;max-width:60rem;padding:2rem 1.5rem 4rem;background:#fff;color:#1d2329;\
font:15px/1.55 system-ui,'Segoe UI','Helvetica Neue',Arial,sans-serif}\
h1{font-size:1.7rem;line-height:1.25;margin:0 0 .2rem;font-weight:650}\
h2{font-size:1.2rem;margin:2.4rem 0 .6rem;padding-top:.6rem;border-top:1px solid #dfe3e8;font-weight:650}\
p{margin:.5rem 0;max-width:46rem}\
p.lead{color:#56606b;margin-bottom:1.2rem}\
figure{margin:1.2rem 0}figure svg{max-width:100%;height:auto;display:block}\
figcaption{color:#56606b;font-size:.87rem;max-width:46rem;margin-top:.3rem}\
.row{display:flex;flex-wrap:wrap;gap:1rem;align-items:flex-end}.row figure{margin:.6rem 0;flex:1 1 24rem}\
.table{overflow-x:auto;margin:.8rem 0 1.2rem}\
table{border-collapse:collapse;font-size:.87rem;font-variant-numeric:tabular-nums}\
th{text-align:left;font-weight:600;color:#3b444d;border-bottom:1.5px solid #aab2bb;padding:.3rem .9rem .3rem 0;vertical-align:bottom}\
td{border-bottom:1px solid #e7e9ec;padding:.28rem .9rem .28rem 0;vertical-align:top}\
th.n,td.n{text-align:right;white-space:nowrap}\
td.good{color:#14683f}td.bad{color:#b3121f;font-weight:600}\
caption{caption-side:top;text-align:left;font-weight:600;padding-bottom:.35rem}\
table.summary td:first-child{color:#56606b;padding-right:1.6rem}\
@media print{body{font-size:10pt;max-width:none;padding:0}h2{break-after:avoid}\
figure,table,tr{break-inside:avoid}.table{overflow:visible}@page{margin:16mm}}";

impl Report {
    /// A page with a title and one line below it.
    pub fn new(title: &str, lead: &str) -> Self {
        let mut report = Self {
            title: title.into(),
            body: String::new(),
            open_section: false,
        };
        report.put(format_args!(
            "<h1>{}</h1>\n<p class=\"lead\">{}</p>\n",
            escape(title),
            escape(lead)
        ));
        report
    }

    /// Appends; a `String` takes everything, so there is no failure to pass on.
    fn put(&mut self, piece: std::fmt::Arguments<'_>) {
        let _ = self.body.write_fmt(piece);
    }

    /// Begins a section.
    pub fn section(&mut self, title: &str) {
        if self.open_section {
            self.put(format_args!("</section>\n"));
        }
        self.put(format_args!("<section>\n<h2>{}</h2>\n", escape(title)));
        self.open_section = true;
    }

    /// A paragraph.
    pub fn text(&mut self, text: &str) {
        self.put(format_args!("<p>{}</p>\n", escape(text)));
    }

    /// A figure: an `<svg>` element as `plot` makes it, and what it shows.
    pub fn figure(&mut self, svg: &str, caption: &str) {
        self.put(format_args!("<figure>{svg}"));
        if !caption.is_empty() {
            self.put(format_args!("<figcaption>{}</figcaption>", escape(caption)));
        }
        self.put(format_args!("</figure>\n"));
    }

    /// Figures side by side where the page is wide enough.
    pub fn figures(&mut self, figures: &[(String, &str)]) {
        self.put(format_args!("<div class=\"row\">\n"));
        for (svg, caption) in figures {
            self.figure(svg, caption);
        }
        self.put(format_args!("</div>\n"));
    }

    /// Names and values in two columns.
    pub fn summary(&mut self, rows: &[(&str, Cell)]) {
        self.put(format_args!(
            "<div class=\"table\"><table class=\"summary\"><tbody>\n"
        ));
        for (name, value) in rows {
            let row = [Cell::Text((*name).into()), value.clone()];
            self.row(&row);
        }
        self.put(format_args!("</tbody></table></div>\n"));
    }

    /// A table: a caption, the head, the rows. A column is set flush right when its first row holds a number.
    pub fn table(&mut self, caption: &str, head: &[&str], rows: &[Vec<Cell>]) {
        self.put(format_args!(
            "<div class=\"table\"><table><caption>{}</caption><thead><tr>",
            escape(caption)
        ));
        for (column, name) in head.iter().enumerate() {
            let is_number = rows
                .first()
                .and_then(|row| row.get(column))
                .is_some_and(|cell| !matches!(cell, Cell::Text(_)));
            let class = if is_number { " class=\"n\"" } else { "" };
            self.put(format_args!("<th{class}>{}</th>", escape(name)));
        }
        self.put(format_args!("</tr></thead><tbody>\n"));
        for row in rows {
            self.row(row);
        }
        self.put(format_args!("</tbody></table></div>\n"));
    }

    fn row(&mut self, row: &[Cell]) {
        self.put(format_args!("<tr>"));
        for cell in row {
            let (class, text) = match cell {
                Cell::Text(text) => ("", text),
                Cell::Number(text) => ("n", text),
                Cell::Judged(text, true) => ("n good", text),
                Cell::Judged(text, false) => ("n bad", text),
            };
            if class.is_empty() {
                self.put(format_args!("<td>{}</td>", escape(text)));
            } else {
                self.put(format_args!("<td class=\"{class}\">{}</td>", escape(text)));
            }
        }
        self.put(format_args!("</tr>\n"));
    }

    /// The whole page.
    pub fn html(mut self) -> String {
        if self.open_section {
            self.put(format_args!("</section>\n"));
        }
        format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
            escape(&self.title),
            self.body
        )
    }
}
