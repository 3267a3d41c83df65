//! `$` lines -> [`Command`], and the readings of numbers.

use super::Line;
use super::cue::Action;
use crate::error::Error;
use crate::program::words::{self, BadSteps, number, number64, whole};
use crate::settings::{AXES, LETTERS};
use crate::stepper::Preset;
use fixed::types::I32F32;

/// What a line asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command<'a, const N: usize = AXES> {
    Nothing,
    Help,
    Settings,
    Set {
        number: u16,
        value: f32,
    },
    Info,
    Unlock,
    Counters,
    DrillShow,
    /// `sim`: walked through only, for its time and its limits.
    DrillRun {
        sim: bool,
    },
    /// Comma-separated words, a letter and a number each.
    DrillSet(&'a str),
    Counts {
        counts: [i32; N],
        seconds: f64,
        preset: Preset,
    },
    /// The next target of a stream [steps], and the least time to it [s] (0: a rapid).
    Move {
        steps: [I32F32; N],
        duration: f32,
    },
    /// A target whose number for this motor is none.
    BadMove {
        motor: usize,
        why: BadSteps,
    },
    MoveEnd,
    TrimShow,
    /// An offset [mm or deg].
    Trim {
        motor: usize,
        value: f32,
    },
    TrimZero,
    /// Readings trim: period [ms], tau [s], amount [mm], rate [mm/s], gate [mm], misses.
    TrimOn {
        period: i32,
        numbers: [f32; 4],
        misses: i32,
    },
    TrimOff,
    /// A process's own line: `name` or `name=value`.
    Process {
        name: &'a str,
        value: Option<&'a str>,
    },
    Cue {
        /// Milliseconds of the motion.
        at: u32,
        action: Action,
    },
}

/// Reads a line, all or nothing.
pub fn parse<const N: usize>(line: &Line) -> Result<Command<'_, N>, Error> {
    let Some(rest) = line.strip_prefix('$') else {
        return if line.is_empty() || line == "%" {
            Ok(Command::Nothing)
        } else {
            Err(Error::Unsupported)
        };
    };
    Ok(match rest {
        "" => Command::Help,
        "$" => Command::Settings,
        "I" => Command::Info,
        "X" => Command::Unlock,
        "STAT" => Command::Counters,
        "DRILL" => Command::DrillShow,
        "TRIM" => Command::TrimShow,
        "TRIM=0" => Command::TrimZero,
        "TRIM=OFF" => Command::TrimOff,
        "DRILL=RUN" => Command::DrillRun { sim: false },
        "DRILL=SIM" => Command::DrillRun { sim: true },
        "MOVE=END" => Command::MoveEnd,
        "KIN" | "PRECESS" | "SURF" | "MIRROR" => Command::Process {
            name: rest,
            value: None,
        },
        _ => {
            let (name, value) = rest.split_once('=').ok_or(Error::UnknownCommand)?;
            let is_process = matches!(name, "KIN" | "PRECESS" | "SURF" | "MIRROR" | "POINT");
            match name {
                _ if is_process || name.starts_with("KIN.") => Command::Process {
                    name,
                    value: Some(value),
                },
                "DRILL" => Command::DrillSet(value),
                "SEG" => counts(value)?,
                "MOVE" => target(value)?,
                "CUE" => cue(value)?,
                "TRIM" => trim(value)?,
                _ => Command::Set {
                    number: whole(name)
                        .and_then(|n| u16::try_from(n).ok())
                        .ok_or(Error::UnknownCommand)?,
                    value: number(value).ok_or(Error::BadNumber)?,
                },
            }
        }
    })
}

fn counts<const N: usize>(text: &str) -> Result<Command<'_, N>, Error> {
    let mut words = text.split(',');
    let mut counts = [0; N];
    for count in &mut counts {
        *count = words.next().and_then(whole).ok_or(Error::BadNumber)?;
    }
    let seconds = words.next().and_then(number64).ok_or(Error::BadNumber)?;
    let preset = match words.next() {
        None | Some("PUBLISHED") => Preset::Published,
        Some("CENTRED") => Preset::Centred,
        Some(_) => return Err(Error::BadNumber),
    };
    match words.next() {
        None => Ok(Command::Counts {
            counts,
            seconds,
            preset,
        }),
        Some(_) => Err(Error::BadNumber),
    }
}

fn target<const N: usize>(text: &str) -> Result<Command<'_, N>, Error> {
    let mut list = text.split(',');
    let mut steps = [I32F32::ZERO; N];
    for motor in 0..N {
        match words::steps(list.next().ok_or(Error::BadNumber)?) {
            Ok(at) => steps[motor] = at,
            Err(why) => return Ok(Command::BadMove { motor, why }),
        }
    }
    let duration = match list.next() {
        None => 0.0,
        Some(word) => number(word).ok_or(Error::BadNumber)?,
    };
    match list.next() {
        None => Ok(Command::Move { steps, duration }),
        Some(_) => Err(Error::BadNumber),
    }
}

/// `Z0.05`, or `ON,period,tau,amount,rate,gate,misses`.
fn trim<const N: usize>(text: &str) -> Result<Command<'_, N>, Error> {
    if let Some(words) = text.strip_prefix("ON,") {
        let mut words = words.split(',');
        let mut word = || words.next().ok_or(Error::BadNumber);
        let period = whole(word()?).ok_or(Error::BadNumber)?;
        let mut numbers = [0.0; 4];
        for value in &mut numbers {
            *value = number(word()?).ok_or(Error::BadNumber)?;
        }
        let misses = whole(word()?).ok_or(Error::BadNumber)?;
        return match words.next() {
            None => Ok(Command::TrimOn {
                period,
                numbers,
                misses,
            }),
            Some(_) => Err(Error::BadNumber),
        };
    }
    let mut rest = text.chars();
    let motor = rest
        .next()
        .and_then(|letter| LETTERS.find(letter))
        .filter(|motor| *motor < N)
        .ok_or(Error::UnknownCommand)?;
    let value = number(rest.as_str()).ok_or(Error::BadNumber)?;
    Ok(Command::Trim { motor, value })
}

/// `ms,HOLD`, `RESUME`, `STOP`, `FEED,percent`, `RAPID,percent`, `TRIM,motor,steps`.
fn cue<const N: usize>(text: &str) -> Result<Command<'_, N>, Error> {
    let mut words = text.split(',');
    let at = words.next().and_then(whole).ok_or(Error::BadNumber)?;
    let at = u32::try_from(at).map_err(|_| Error::Negative)?;
    let name = words.next().ok_or(Error::BadNumber)?;
    let mut value = || words.next().and_then(whole).ok_or(Error::BadNumber);
    let action = match name {
        "HOLD" => Action::Hold,
        "RESUME" => Action::Resume,
        "STOP" => Action::Stop,
        "FEED" => Action::Feed(value()? as f32 / 100.0),
        "RAPID" => Action::Rapid(value()? as f32 / 100.0),
        "TRIM" => {
            let motor = usize::try_from(value()?).map_err(|_| Error::Negative)?;
            Action::Trim {
                motor,
                steps: value()?,
            }
        }
        _ => return Err(Error::UnknownCommand),
    };
    match words.next() {
        None => Ok(Command::Cue { at, action }),
        Some(_) => Err(Error::BadNumber),
    }
}
