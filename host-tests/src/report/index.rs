//! All jobs that have run -> one page with a card for each.

use crate::plot::escape;
use std::fmt::Write;

/// How a job stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    Sound,
    Unsound,
    /// It was refused, or its results could not be written.
    Failed,
}

/// What the page says of a job.
pub struct Card {
    pub name: String,
    /// One line about it.
    pub about: String,
    pub standing: Standing,
    /// Lines of its summary, `label    text`.
    pub lines: Vec<String>,
    /// Its report, seen from the page.
    pub link: Option<String>,
    /// An `<svg>` element of its report.
    pub picture: Option<String>,
    /// Time that it took [s].
    pub wall: f64,
}

const STYLE: &str = "\
:root{color-scheme:light}\
body{margin:0 auto;max-width:76rem;padding:2rem 1.5rem 4rem;background:#f5f6f8;color:#1d2329;\
font:15px/1.5 system-ui,'Segoe UI','Helvetica Neue',Arial,sans-serif}\
h1{font-size:1.7rem;margin:0 0 .2rem;font-weight:650}\
p.lead{color:#56606b;margin:.2rem 0 1.4rem}\
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(22rem,1fr));gap:1.1rem}\
.card{background:#fff;border:1px solid #dfe3e8;border-radius:6px;padding:1rem 1.1rem;display:flex;flex-direction:column}\
.card h2{font-size:1.05rem;margin:0;font-weight:650;display:flex;justify-content:space-between;gap:1rem}\
.card a{color:#0b5a9c;text-decoration:none}.card a:hover{text-decoration:underline}\
.card p{margin:.35rem 0;color:#3b444d;font-size:.9rem}\
.picture{height:12.5rem;margin:.5rem 0;display:flex;align-items:center;justify-content:center;overflow:hidden}\
.picture svg{max-width:100%;max-height:100%;width:100%;height:100%}\
.card dl{margin:.3rem 0 0;font-size:.82rem;display:grid;grid-template-columns:auto 1fr;column-gap:.8rem;row-gap:.15rem}\
.card dt{color:#6b747d}.card dd{margin:0;overflow-wrap:anywhere}\
.state{font-size:.8rem;font-weight:600;white-space:nowrap}\
.good{color:#14683f}.bad{color:#b3121f}\
@media print{body{background:#fff}.card{break-inside:avoid}}";

/// The page.
pub fn index(cards: &[Card]) -> String {
    let mut body = String::new();
    let sound = cards
        .iter()
        .filter(|card| card.standing == Standing::Sound)
        .count();
    let wall: f64 = cards.iter().map(|card| card.wall).sum();
    // A `String` takes everything.
    let _ = writeln!(
        body,
        "<h1>hexstep: all jobs</h1>\n<p class=\"lead\">{sound} of {} as they should be; {wall:.0} s.</p>\n<div class=\"cards\">",
        cards.len()
    );
    for card in cards {
        put(&mut body, card);
    }
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>hexstep: all jobs</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}</div>\n</body>\n</html>\n"
    )
}

fn put(body: &mut String, card: &Card) {
    let (class, state) = match card.standing {
        Standing::Sound => ("good", "as it should be"),
        Standing::Unsound => ("bad", "something is wrong"),
        Standing::Failed => ("bad", "failed"),
    };
    let name = escape(&card.name);
    let title = match &card.link {
        Some(link) => format!("<a href=\"{}\">{name}</a>", escape(link)),
        None => name,
    };
    let _ = writeln!(
        body,
        "<div class=\"card\"><h2>{title}<span class=\"state {class}\">{state}</span></h2><p>{}</p>",
        escape(&card.about)
    );
    if let Some(picture) = &card.picture {
        let _ = writeln!(body, "<div class=\"picture\">{picture}</div>");
    }
    let _ = write!(body, "<dl>");
    for line in &card.lines {
        let (label, text) = line.split_once("  ").unwrap_or(("", line));
        let _ = write!(
            body,
            "<dt>{}</dt><dd>{}</dd>",
            escape(label.trim()),
            escape(text.trim())
        );
    }
    let _ = writeln!(body, "</dl></div>");
}
