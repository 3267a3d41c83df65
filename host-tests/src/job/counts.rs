//! Jobs of kind `counts`: lines of six step counts, each with a duration and a preset.

use super::reader::{Kind, Table};
use super::{JobError, Places};
use crate::trace::TICK_HZ;
use hexstep::stepper::{CountError, CountLine, Preset, Timing};

/// Lines that run one after the other, each from standstill to standstill.
#[derive(Clone, Debug, PartialEq)]
pub struct CountsJob {
    pub lines: Vec<Line>,
}

/// One line of counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub counts: [i32; 6],
    /// [timer counts]
    pub duration: u64,
    pub preset: Preset,
}

impl CountsJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let mut lines = Vec::new();
        let mut from = [0; 6];
        for (index, table) in root.tables("line")?.iter().enumerate() {
            table.known(&["counts", "duration", "preset"])?;
            let bound = i64::from(CountLine::<6>::BOUND);
            let counts = table.wholes::<6>("counts", -bound, bound)?;
            let duration = table.number("duration", Kind::positive(86_400.0, "s"))?;
            let presets = ["published", "centred"];
            let preset = if table.has("preset") {
                table.word("preset", &presets)?
            } else {
                0
            };
            let line = Line {
                // Within the bound, which is far below 2^31.
                counts: counts.map(|count| count as i32),
                duration: (duration * TICK_HZ as f64).round() as u64,
                preset: [Preset::Published, Preset::Centred][preset],
            };
            CountLine::new(line.counts, line.duration, line.preset, timing, &from)
                .map_err(|error| refuse(places, index, &line, error))?;
            for (from, count) in from.iter_mut().zip(line.counts) {
                *from += count;
            }
            lines.push(line);
        }
        Ok(Self { lines })
    }
}

/// The error of a line that the stepper does not take, at the key that can mend it.
fn refuse(places: &Places, index: usize, line: &Line, error: CountError) -> JobError {
    let seconds = |counts: u64| counts as f64 / TICK_HZ as f64;
    let duration = seconds(line.duration);
    let (key, detail) = match error {
        CountError::OutOfRange { motor, bound } => (
            format!("counts[{motor}]"),
            format!("at most {bound} steps either way are possible in one line; split it"),
        ),
        CountError::Overflow { motor } => (
            format!("counts[{motor}]"),
            "the position after this line would leave the range of a step counter; reduce it"
                .into(),
        ),
        CountError::TooFast { least } => (
            "duration".into(),
            format!(
                "{duration} s is too short for the largest count; at least {:.6} s are needed with this pulse time",
                seconds(least)
            ),
        ),
        CountError::TooSlow { most } => (
            "duration".into(),
            format!(
                "{duration} s is too long; at most {:.3} s are possible, split the line",
                seconds(most)
            ),
        ),
    };
    places.refuse(&format!("line[{index}].{key}"), "OutOfRange", detail)
}
