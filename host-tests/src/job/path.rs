//! Jobs of kind `path`: points of all joints, each with a feed, an inverse time or none, and what six motors can do.
//!
//! ```text
//! points | [[point]] | file.csv | shape  -> PathPoint       points.rs
//!        -> whole steps within the travel, least durations  -> Block
//! ```

use super::axes::{
    AXES, AxisLimits, CONTOUR, Contour, FIRST_TURNING, MOTORS, read_axes, read_contour, unit,
};
use super::csv::Csv;
use super::cues::read_cues;
use super::points::{LONGEST_DWELL, MOST_POINTS, Pace, PathPoint, Row, circle, read_csv, trochoid};
use super::reader::{Kind, Table};
use super::shaping::{SHAPING, Shaping};
use super::{Job, JobError, Place, Places};
use hexstep::protocol::cue::{Action, Cue};
use hexstep::stepper::Timing;

/// A path of joints. It begins where the machine stands: all joints at 0.
#[derive(Clone, Debug)]
pub struct PathJob {
    pub axes: [AxisLimits; 6],
    pub contour: Contour,
    pub shaping: Shaping,
    pub points: Vec<PathPoint>,
    pub cues: Vec<Cue>,
    /// One for each point.
    pub blocks: Vec<Block>,
    origin: Origin,
}

/// A straight move to a point, as the machine is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The point, on whole steps.
    pub steps: [i32; 6],
    /// Way of the joints that the feed counts for [mm, or deg where only joints that turn move].
    pub length: f64,
    /// Least time of the move [s]; 0 for a rapid.
    pub duration: f64,
}

/// Where the points come from.
#[derive(Clone, Debug)]
enum Origin {
    /// `points = [[...], ...]`
    Array,
    /// `[[point]]`
    Tables,
    Shape,
    /// A CSV file with the line of each point.
    File {
        file: String,
        lines: Vec<usize>,
    },
}

/// Longest time that a job may ask for: a day [s].
const LONGEST: f64 = 86_400.0;

impl PathJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let [machine, path] = [root.table("machine")?, root.table("path")?];
        machine.known(&[AXES, CONTOUR, SHAPING].concat())?;
        path.known(&[
            "tolerance",
            "feed",
            "inverse_time",
            "rapid",
            "points",
            "file",
            "shape",
        ])?;
        let axes = read_axes(&machine, timing, places)?;
        let contour = read_contour(&machine, &path, &axes, places)?;
        let pace = read_pace(&path, "path", places)?;
        let (points, origin) = read_points(root, &path, pace, places)?;
        let mut job = Self {
            cues: read_cues(root, &axes, &contour, places)?,
            shaping: Shaping::read(&machine, places)?,
            axes,
            contour,
            points,
            blocks: Vec::new(),
            origin,
        };
        job.blocks = job.to_blocks(places)?;
        Ok(job)
    }

    /// The motors that the path moves.
    pub fn moves(&self) -> [bool; 6] {
        let (mut moves, mut from) = ([false; 6], [0; 6]);
        for block in &self.blocks {
            for (motor, moves) in moves.iter_mut().enumerate() {
                *moves |= block.steps[motor] != from[motor];
            }
            from = block.steps;
        }
        moves
    }

    /// One step of all motors that move, as a length at the tool [mm].
    pub fn step(&self) -> f64 {
        self.contour.step(&self.axes, self.moves())
    }

    /// Whether an operator's cue drops the rest of the path, and whether one moves motors off it.
    pub fn is_stopped(&self) -> bool {
        self.has_cue(|action| matches!(action, Action::Stop))
    }

    pub fn is_trimmed(&self) -> bool {
        self.has_cue(|action| matches!(action, Action::Trim { .. }))
    }

    fn has_cue(&self, is: impl Fn(&Action) -> bool) -> bool {
        self.cues.iter().any(|cue| is(&cue.action))
    }

    /// An error about a point, where it is written.
    pub fn refuse_point(
        &self,
        job: &Job,
        index: usize,
        name: &'static str,
        detail: String,
    ) -> JobError {
        self.refuse(&job.places, index, None, name, detail)
    }

    fn refuse(
        &self,
        places: &Places,
        index: usize,
        motor: Option<usize>,
        name: &'static str,
        detail: String,
    ) -> JobError {
        let element = motor.map_or(String::new(), |motor| format!("[{motor}]"));
        match &self.origin {
            Origin::Array => places.refuse(&format!("path.points[{index}]{element}"), name, detail),
            Origin::Tables => places.refuse(&format!("point[{index}].at{element}"), name, detail),
            Origin::Shape => {
                let detail = format!("{detail} (at its point {})", index + 1);
                places.refuse("path.shape", name, detail)
            }
            Origin::File { file, lines } => JobError {
                file: file.clone(),
                place: lines.get(index).map(|line| Place {
                    line: *line,
                    column: 1,
                }),
                key: motor.map(|motor| MOTORS[motor].into()),
                name,
                detail,
            },
        }
    }

    /// Whole steps and durations of all moves.
    fn to_blocks(&self, places: &Places) -> Result<Vec<Block>, JobError> {
        let mut blocks = Vec::with_capacity(self.points.len());
        let (mut from, mut from_steps, mut time) = ([0.0; 6], [0i32; 6], 0.0);
        for (index, point) in self.points.iter().enumerate() {
            let mut steps = [0; 6];
            for motor in 0..6 {
                let refuse = |name: &'static str, detail: String| {
                    Err(self.refuse(places, index, Some(motor), name, detail))
                };
                let (axis, at) = (&self.axes[motor], point.at[motor]);
                let Some(here) = axis.steps_at(at) else {
                    let detail = format!(
                        "{at} {} are more than the 2^31 steps that a motor can count; correct it",
                        unit(motor)
                    );
                    return refuse("OutOfRange", detail);
                };
                let (lower, upper) = axis.travel_steps();
                if here < lower || here > upper {
                    let detail = format!(
                        "{} would go to {at} {}, beyond its travel of {} to {}; widen travel if the machine allows it, or change the point",
                        MOTORS[motor],
                        unit(motor),
                        axis.travel.0,
                        axis.travel.1
                    );
                    return refuse("OutOfTravel", detail);
                }
                if i64::from(here).abs_diff(from_steps[motor].into()) > i32::MAX as u64 {
                    let detail = "a move of more than 2^31 - 1 steps is not possible; put a point in between";
                    return refuse("OutOfRange", detail.into());
                }
                steps[motor] = here;
            }
            let block = self.block(&from, &from_steps, point, steps);
            // No motor takes less time than its own speed gives, whatever is programmed.
            let slowest = (0..6)
                .map(|motor| (point.at[motor] - from[motor]).abs() / self.axes[motor].max_rate)
                .fold(block.duration, f64::max);
            time += slowest + point.dwell;
            if time > LONGEST {
                let detail = format!(
                    "the job would take {time:e} s up to here; at most {LONGEST} s, a day, are simulated; raise the feed or shorten the path"
                );
                return Err(self.refuse(places, index, None, "OutOfRange", detail));
            }
            (from, from_steps) = (point.at, steps);
            blocks.push(block);
        }
        Ok(blocks)
    }

    /// One move. A feed counts along the joints that slide if any of them makes a step, so that a slide that hardly
    /// moves does not rush those that turn; else along those that turn.
    fn block(
        &self,
        from: &[f64; 6],
        from_steps: &[i32; 6],
        point: &PathPoint,
        steps: [i32; 6],
    ) -> Block {
        let slides = (0..FIRST_TURNING).any(|motor| steps[motor] != from_steps[motor]);
        let counted = if slides {
            0..FIRST_TURNING
        } else {
            FIRST_TURNING..6
        };
        let squares = counted.map(|motor| (point.at[motor] - from[motor]).powi(2));
        let length = squares.sum::<f64>().sqrt();
        let duration = match point.pace {
            Pace::Rapid => 0.0,
            Pace::Feed(feed) => length / feed * 60.0,
            Pace::InverseTime(rate) => 60.0 / rate,
        };
        Block {
            steps,
            length,
            duration,
        }
    }
}

/// `feed`, `inverse_time` or `rapid = true` of a table, at most one of them.
fn read_pace(table: &Table<'_>, path: &str, places: &Places) -> Result<Option<Pace>, JobError> {
    let both = |key: &str, other: &str| {
        let detail = format!("{key} and {other} exclude each other; keep one of them");
        Err(places.refuse(&format!("{path}.{key}"), "Contradictory", detail))
    };
    let positive = |(_, most): (f64, f64), unit| Kind::positive(most, unit);
    let mut pace = None;
    if table.has("feed") {
        let kind = positive(Pace::FEEDS, "mm/min or deg/min");
        pace = Some(Pace::Feed(table.number("feed", kind)?));
    }
    if table.has("inverse_time") {
        let kind = positive(Pace::INVERSE_TIMES, "1/min");
        let rate = table.number("inverse_time", kind)?;
        if pace.replace(Pace::InverseTime(rate)).is_some() {
            return both("inverse_time", "feed");
        }
    }
    if table.flag("rapid")? && pace.replace(Pace::Rapid).is_some() {
        return both("rapid", "feed or inverse_time");
    }
    Ok(pace)
}

/// The points from the one place where they are given.
fn read_points(
    root: &Table<'_>,
    path: &Table<'_>,
    pace: Option<Pace>,
    places: &Places,
) -> Result<(Vec<PathPoint>, Origin), JobError> {
    let sources = ["points", "file", "shape"];
    let mut given: Vec<String> = sources
        .iter()
        .filter(|key| path.has(key))
        .map(|key| format!("path.{key}"))
        .collect();
    if root.has("point") {
        given.push("point".into());
    }
    if let [_, second, ..] = given.as_slice() {
        let detail = format!(
            "the points are given twice, by {}; keep one of them",
            given.join(" and ")
        );
        return Err(places.refuse(second, "Contradictory", detail));
    }
    // Where a point does not say how fast, the path does.
    let paced = |own: Option<Pace>, key: &str| {
        own.or(pace).ok_or_else(|| {
            let detail = "nothing says how fast; add feed, inverse_time or rapid = true to [path], or to every point";
            places.refuse(key, "MissingField", detail.into())
        })
    };
    let evenly = |at: Vec<[f64; 6]>| {
        let pace = paced(None, "path.feed")?;
        let point = |at| PathPoint {
            at,
            pace,
            dwell: 0.0,
        };
        Ok(at.into_iter().map(point).collect())
    };
    match given.first().map(String::as_str) {
        Some("path.points") => {
            let at = path.rows::<6>("points", MOST_POINTS)?;
            Ok((evenly(at)?, Origin::Array))
        }
        Some("path.shape") => Ok((evenly(read_shape(path, places)?)?, Origin::Shape)),
        Some("path.file") => {
            let csv = Csv::beside(places, "path.file", path.text("file")?)?;
            let rows = read_csv(&csv)?;
            let point = |row: &Row| {
                let pace = paced(row.pace, "path.feed")?;
                let (at, dwell) = (row.at, row.dwell);
                Ok(PathPoint { at, pace, dwell })
            };
            let points = rows.iter().map(point).collect::<Result<_, JobError>>()?;
            let lines = rows.iter().map(|row| row.line).collect();
            Ok((
                points,
                Origin::File {
                    file: csv.name,
                    lines,
                },
            ))
        }
        Some(_) => {
            let mut points = Vec::new();
            for (index, table) in root.tables("point")?.iter().enumerate() {
                table.known(&["at", "feed", "inverse_time", "rapid", "dwell"])?;
                let name = format!("point[{index}]");
                let own = read_pace(table, &name, places)?;
                points.push(PathPoint {
                    at: table.numbers::<6>("at", Kind::ANY)?,
                    pace: paced(own, &format!("{name}.feed"))?,
                    dwell: table.number_or("dwell", 0.0, Kind::between(0.0, LONGEST_DWELL, "s"))?,
                });
            }
            Ok((points, Origin::Tables))
        }
        None => {
            let detail = "a path has no points; add points = [[...], ...], file or shape to [path], or tables [[point]]";
            Err(places.refuse("path.points", "MissingField", detail.into()))
        }
    }
}

/// `shape = { kind = "circle", ... }`: a curve as many chords.
fn read_shape(path: &Table<'_>, places: &Places) -> Result<Vec<[f64; 6]>, JobError> {
    let shape = path.table("shape")?;
    let is_trochoid = shape.word("kind", &["circle", "trochoid"])? == 1;
    let keys = ["kind", "axes", "radius", "chords", "turns", "pitch"];
    shape.known(&keys[..if is_trochoid { 6 } else { 5 }])?;
    let axes = if shape.has("axes") {
        shape.words::<2>("axes", &MOTORS)?
    } else {
        [0, 1]
    };
    if axes[0] == axes[1] {
        let detail = format!(
            "{0} and {0} span no plane; name two joints",
            MOTORS[axes[0]]
        );
        return Err(places.refuse("path.shape.axes", "Contradictory", detail));
    }
    let radius = shape.number("radius", Kind::positive(10_000.0, "mm or deg"))?;
    let most = MOST_POINTS as i64;
    // Within 3 ..= 10^6.
    let chords = shape.whole("chords", 3, most)? as usize;
    let turns = shape.number_or(
        "turns",
        1.0,
        Kind::between(1.0 / chords as f64, most as f64 / chords as f64, "turns"),
    )?;
    let count = (turns * chords as f64).round() as usize;
    Ok(if is_trochoid {
        let pitch = shape.number("pitch", Kind::between(-10_000.0, 10_000.0, "mm or deg"))?;
        trochoid(axes, radius, pitch, chords, count).collect()
    } else {
        circle(axes, radius, chords, count).collect()
    })
}
