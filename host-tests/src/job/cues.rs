//! `[[cue]]`: what an operator does while a job runs, at given milliseconds of its motion.

use super::axes::{AxisLimits, Contour, MOTORS};
use super::reader::{Kind, Table};
use super::{JobError, Places};
use hexstep::planner::MOST_TRIM;
use hexstep::protocol::cue::{Action, CUES, Cue};

/// Latest time of a cue: a day [ms].
const LATEST: i64 = 86_400_000;

/// Reads all tables `[[cue]]`, in the order of their times.
///
/// # Errors
/// `OutOfRange` for a number, an order of times or a count of cues that the machine does not take; `Contradictory` for
/// a hold that nothing ends and a trim for which no share of the limits is kept.
pub(super) fn read_cues(
    root: &Table<'_>,
    names: &[String; 6],
    axes: &[AxisLimits; 6],
    contour: &Contour,
    places: &Places,
) -> Result<Vec<Cue>, JobError> {
    let mut cues: Vec<Cue> = Vec::new();
    // The hold that is in force, by its index.
    let mut held = None;
    for (index, table) in root.tables_if_any("cue")?.iter().enumerate() {
        let refuse = |key: &str, name: &'static str, detail: String| {
            Err(places.refuse(&format!("cue[{index}].{key}"), name, detail))
        };
        if index >= CUES {
            let detail = format!("at most {CUES} cues are possible; remove some");
            return refuse("at_ms", "OutOfRange", detail);
        }
        // Within the range of u32.
        let at = table.whole("at_ms", 0, LATEST)? as u32;
        if let Some(last) = cues.last().filter(|last| last.at > at) {
            let detail = format!(
                "{at} ms is before the {} ms of the cue above; put them in the order of their times",
                last.at
            );
            return refuse("at_ms", "OutOfRange", detail);
        }
        let actions = ["hold", "resume", "feed", "rapid", "trim", "stop"];
        let action = table.word("action", &actions)?;
        table.known(match action {
            2 | 3 => &["at_ms", "action", "percent"],
            4 => &["at_ms", "action", "motor", "steps"],
            _ => &["at_ms", "action"],
        })?;
        let percent = |least: f64, most: f64| {
            let kind = Kind::between(least, most, "percent");
            Ok((table.number("percent", kind)? / 100.0) as f32)
        };
        let action = match action {
            0 => {
                held = Some(index);
                Action::Hold
            }
            1 => {
                held = None;
                Action::Resume
            }
            2 => Action::Feed(percent(10.0, 200.0)?),
            3 => Action::Rapid(percent(5.0, 100.0)?),
            4 => {
                // By the names of the path's own joints, or those of the motors.
                let own = names.iter().map(String::as_str);
                let others = MOTORS.iter().copied().filter(|_| names[..] != MOTORS[..]);
                let known: Vec<&str> = own.chain(others).collect();
                let motor = table.word("motor", &known)? % MOTORS.len();
                if contour.trim_share <= 0.0 {
                    let detail = "a trim needs a share of the motors' limits; set trim_share in [machine], such as 0.1";
                    return refuse("action", "Contradictory", detail.into());
                }
                let bound = contour.trim[motor] * axes[motor].steps_per_unit;
                // At most MOST_TRIM, which an i32 holds.
                let bound = bound.round().min(f64::from(MOST_TRIM)) as i64;
                let steps = table.whole("steps", -bound, bound)?;
                Action::Trim {
                    motor,
                    steps: steps as i32,
                }
            }
            _ => {
                held = None;
                Action::Stop
            }
        };
        cues.push(Cue { at, action });
    }
    if let Some(index) = held {
        let detail =
            "nothing ends this hold; add a cue with action = \"resume\" or \"stop\" behind it";
        let key = format!("cue[{index}].action");
        return Err(places.refuse(&key, "Contradictory", detail.into()));
    }
    Ok(cues)
}
