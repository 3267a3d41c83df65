//! The points of a joint path: written out, in a CSV file, or along a curve, each with how fast it is to be reached.
//!
//! A CSV file has a head line that names its columns, `d1` .. `theta3` or X Y Z A B C for joints (mm and degrees), `F`
//! for the feed of the block that ends in the point, `T` for its inverse time [1/min], `P` for a dwell behind it [s].
//! Cells are set apart by commas; what follows a `#` is a comment. A joint without a column stays at 0; an empty cell
//! says what the row before said of a joint, and the default of the path of everything else; the word `rapid` stands
//! for a feed. Reports call joints as the columns do, and `[machine]` may have as many numbers as there are such columns,
//! in the order of the motors.

use super::axes::MOTORS;
use super::csv::{Csv, cells};
use super::{JobError, Place};

/// How fast a point is to be reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// As fast as the joints allow.
    Rapid,
    /// G94 [mm/min or deg/min]: along the sliding joints if any of them moves, else along the turning ones.
    Feed(f64),
    /// G93 [1/min]: the block takes a minute divided by this.
    InverseTime(f64),
}

impl Pace {
    /// Ranges of the numbers in it.
    pub const FEEDS: (f64, f64) = (1e-6, 1e9);
    pub const INVERSE_TIMES: (f64, f64) = (1e-6, 1e9);
}

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Joints [mm, deg].
    pub at: [f64; 6],
    pub pace: Pace,
    /// Standstill at it [s]; 0 for none.
    pub dwell: f64,
}

/// A row of a CSV file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub at: [f64; 6],
    pub pace: Option<Pace>,
    pub dwell: f64,
    pub line: usize,
}

/// A column of a joint: its motor, and its name.
pub(super) type JointColumn = (usize, String);

/// Points that a path may have.
pub(super) const MOST_POINTS: usize = 1_000_000;

/// Longest dwell [s].
pub(super) const LONGEST_DWELL: f64 = 3600.0;

const LETTERS: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

#[derive(Clone, Copy, PartialEq)]
enum Column {
    Joint(usize),
    Feed,
    InverseTime,
    Dwell,
}

impl Column {
    fn named(name: &str) -> Option<Self> {
        let joint = |names: &[&str; 6]| names.iter().position(|known| *known == name);
        match name {
            "F" => Some(Self::Feed),
            "T" => Some(Self::InverseTime),
            "P" => Some(Self::Dwell),
            _ => joint(&MOTORS).or_else(|| joint(&LETTERS)).map(Self::Joint),
        }
    }
}

impl Csv {
    /// The columns that a head line of points names.
    fn point_columns(&self, line: usize, text: &str) -> Result<Vec<(Column, String)>, JobError> {
        let mut columns: Vec<(Column, String)> = Vec::new();
        for (place, name) in cells(line, text) {
            let Some(column) = Column::named(name) else {
                let detail = format!(
                    "no such column is known; expected are {} or {}, F, T and P, as names in the first line",
                    MOTORS.join(", "),
                    LETTERS.join(", ")
                );
                return Err(self.refuse(Some(place), Some(name), "UnknownField", detail));
            };
            if columns.iter().any(|(known, _)| *known == column) {
                let detail = "this column is there already; keep one of them".into();
                return Err(self.refuse(Some(place), Some(name), "Contradictory", detail));
            }
            columns.push((column, name.into()));
        }
        if !columns.iter().any(|(c, _)| matches!(c, Column::Joint(_))) {
            let place = Some(Place { line, column: 1 });
            let detail = format!("no column of a joint; add one of {}", MOTORS.join(", "));
            return Err(self.refuse(place, None, "MissingField", detail));
        }
        Ok(columns)
    }

    fn point(
        &self,
        columns: &[(Column, String)],
        (line, text): (usize, &str),
        before: &[f64; 6],
    ) -> Result<Row, JobError> {
        let mut row = Row {
            at: *before,
            pace: None,
            dwell: 0.0,
            line,
        };
        let cells = self.row((line, text), columns.len())?;
        for ((place, cell), (column, name)) in cells.zip(columns) {
            if cell.is_empty() {
                continue;
            }
            let pace = match column {
                Column::Joint(motor) => {
                    row.at[*motor] = self.number(place, name, cell)?;
                    continue;
                }
                Column::Dwell => {
                    row.dwell = self.ranged(place, name, cell, (0.0, LONGEST_DWELL))?;
                    continue;
                }
                Column::Feed if cell == "rapid" => Pace::Rapid,
                Column::Feed => Pace::Feed(self.ranged(place, name, cell, Pace::FEEDS)?),
                Column::InverseTime => {
                    Pace::InverseTime(self.ranged(place, name, cell, Pace::INVERSE_TIMES)?)
                }
            };
            if row.pace.replace(pace).is_some() {
                let detail = "this row has a feed and an inverse time; leave one of them empty";
                return Err(self.refuse(Some(place), Some(name), "Contradictory", detail.into()));
            }
        }
        Ok(row)
    }
}

/// The points of a CSV file, and its columns of joints.
///
/// # Errors
/// Everything that can be wrong with a cell, with its line and column.
pub(super) fn read_csv(csv: &Csv) -> Result<(Vec<Row>, Vec<JointColumn>), JobError> {
    let mut lines = csv.lines();
    let Some((line, head)) = lines.next() else {
        let detail =
            "it is empty; expected a line of column names, such as d1,d2,F, and at least one row";
        return Err(csv.refuse(None, None, "OutOfRange", detail.into()));
    };
    let columns = csv.point_columns(line, head)?;
    let mut rows: Vec<Row> = Vec::new();
    for (line, text) in lines {
        if rows.len() >= MOST_POINTS {
            let place = Some(Place { line, column: 1 });
            let detail = format!("more than {MOST_POINTS} points; split the path");
            return Err(csv.refuse(place, None, "OutOfRange", detail));
        }
        let before = rows.last().map_or([0.0; 6], |row| row.at);
        rows.push(csv.point(&columns, (line, text), &before)?);
    }
    if rows.is_empty() {
        let place = Some(Place { line, column: 1 });
        let detail = "no row follows the names of the columns; a path has at least one point";
        return Err(csv.refuse(place, None, "OutOfRange", detail.into()));
    }
    let joints = columns
        .into_iter()
        .filter_map(|(column, name)| match column {
            Column::Joint(motor) => Some((motor, name)),
            _ => None,
        });
    Ok((rows, joints.collect()))
}

/// A circle in two joints, from the start of the path on: `chords` of them make a turn, and there are `count`.
pub(super) fn circle(
    [u, v]: [usize; 2],
    radius: f64,
    chords: usize,
    count: usize,
) -> impl Iterator<Item = [f64; 6]> {
    (1..=count).map(move |k| {
        // Whole turns are taken off first, so that every one of them ends in the same point.
        let angle = std::f64::consts::TAU * (k % chords) as f64 / chords as f64;
        let mut at = [0.0; 6];
        at[u] = radius * (angle.cos() - 1.0);
        at[v] = radius * angle.sin();
        at
    })
}

/// A trochoid in two joints: a circle whose centre moves along the first of them by `pitch` in every turn.
pub(super) fn trochoid(
    axes: [usize; 2],
    radius: f64,
    pitch: f64,
    chords: usize,
    count: usize,
) -> impl Iterator<Item = [f64; 6]> {
    (1..)
        .zip(circle(axes, radius, chords, count))
        .map(move |(k, mut at): (usize, [f64; 6])| {
            at[axes[0]] += pitch * k as f64 / chords as f64;
            at
        })
}
