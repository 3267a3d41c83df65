//! What a gauge taught of a machine that mills too thin or too thick, beside the paper's tables.

use super::{Cell, Report};
use crate::mirror::{mean, sample_sigma};
use crate::plot::number;
use crate::process::{BiasMade, BiasedPanel};

/// What was learnt and what it did, for the wanted wall `d` [mm].
pub(super) fn told(bias: &BiasMade, d: f64) -> String {
    format!(
        "{} gauge readings{}: walls {} mm, rms off {}; with {} mm on the wall: {} mm, rms off {} (paper, trimmed: 1.4448, 0.0564)",
        bias.bias.readings(),
        match bias.outliers {
            0 => String::new(),
            n => format!(", {n} outliers refused"),
        },
        number(mean(&bias.before.gauged), 4),
        number(bias.before.rms(d), 4),
        signed(bias.correction),
        number(mean(&bias.after.gauged), 4),
        number(bias.after.rms(d), 4)
    )
}

/// Both panels beside the paper's tables.
pub(super) fn section(report: &mut Report, bias: &BiasMade, d: f64) {
    report.section("The bias that trimming cannot see");
    let row = |name: &str, panel: &BiasedPanel, is_judged: bool| {
        let digits = |x: f64, n: usize| Cell::Number(number(x, n));
        let within = format!("{} %", number(panel.rows.within() * 100.0, 3));
        vec![
            Cell::Text(name.into()),
            digits(mean(&panel.gauged), 4),
            digits(sample_sigma(&panel.gauged), 5),
            digits(panel.rms(d), 4),
            match is_judged {
                true => Cell::Judged(within, panel.rows.within() >= 1.0),
                false => Cell::Number(within),
            },
        ]
    };
    let printed = |name: &str, figures: [&str; 4]| {
        let mut cells = vec![Cell::Text(name.into())];
        cells.extend(figures.map(|figure| Cell::Number(figure.into())));
        cells
    };
    report.table(
        "Gauged points [mm]; within: all ticks of the rows that count",
        &["", "mean", "sigma (n \u{2212} 1)", "rms off", "within"],
        &[
            printed(
                "paper, without trimming",
                ["1.4489", "0.02853", "0.0578", "\u{2013}"],
            ),
            printed(
                "paper, with trimming",
                ["1.4448", "0.01260", "0.0564", "\u{2013}"],
            ),
            row("first panel, trimmed", &bias.before, false),
            row("second panel, trimmed and corrected", &bias.after, true),
        ],
    );
    report.text(&format!(
        "The machine of this job is off by the same everywhere, as the paper's was. Trimming narrows the spread and leaves \
         the rms error. What the gauge readings of the first panel lack on the average, {} mm, is added to the wall of the \
         second, which is milled under other noise.",
        signed(bias.correction)
    ));
}

fn signed(x: f64) -> String {
    let sign = if x < 0.0 { "" } else { "+" };
    format!("{sign}{}", number(x, 4))
}
