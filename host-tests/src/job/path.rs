//! Jobs of kind `path`: points of all joints, each with a feed, an inverse time or none, and what six motors can do.
//!
//! ```text
//! points | [[point]] | file.csv | shape  -> PathPoint       points.rs
//!        -> steps within the travel, least durations        -> Block
//! ```

use super::axes::{
    AXES, AxisLimits, CONTOUR, Contour, FIRST_TURNING, MOTORS, read_axes_of, read_contour, unit,
};
use super::csv::Csv;
use super::cues::read_cues;
use super::points::{LONGEST_DWELL, MOST_POINTS, Pace, PathPoint, Row, circle, read_csv, trochoid};
use super::reader::{Kind, Table};
use super::shaping::{SHAPING, Shaping};
use super::{Job, JobError, Place, Places};
use fixed::types::I32F32;
use hexstep::joints::whole_steps;
use hexstep::protocol::cue::{Action, Cue};
use hexstep::stepper::Timing;
use std::ops::Range;

/// A path of joints. It begins where the machine stands: all joints at 0.
#[derive(Clone, Debug)]
pub struct PathJob {
    /// What the job calls the motors: the columns of its table, else their own names.
    pub names: [String; 6],
    /// The motors that the job has: those of its table's columns, else all.
    pub joints: Vec<usize>,
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
    /// The point [steps]; on whole ones where the path rests.
    pub steps: [I32F32; 6],
    /// Whether the feed counts for the joints that slide; else for those that turn.
    pub slides: bool,
    /// Their way [mm, or deg].
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

/// Share of the way of the joints that turn, at the tool, below which those that slide hardly move.
const HARDLY: f64 = 1e-4;

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
            "rapid_tolerance",
            "feed",
            "inverse_time",
            "rapid",
            "points",
            "file",
            "shape",
        ])?;
        let pace = read_pace(&path, "path", places)?;
        let Points {
            points,
            origin,
            names,
            mut joints,
        } = read_points(root, &path, pace, places)?;
        let axes = read_axes_of(&joints, &machine, timing, places)?;
        let contour = read_contour(&machine, &path, &axes, places)?;
        let shaping = Shaping::read(&joints, &names, &machine, places)?;
        let cues = read_cues(root, &names, &axes, &contour, places)?;
        for cue in &cues {
            if let Action::Trim { motor, .. } = cue.action {
                joints.push(motor);
            }
        }
        joints.sort_unstable();
        joints.dedup();
        let mut job = Self {
            shaping,
            names,
            joints,
            cues,
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
        let (mut moves, mut from) = ([false; 6], [I32F32::ZERO; 6]);
        for block in &self.blocks {
            for (motor, moves) in moves.iter_mut().enumerate() {
                *moves |= block.steps[motor] != from[motor];
            }
            from = block.steps;
        }
        moves
    }

    /// Whole steps where the path ends.
    pub fn end(&self) -> Option<[i32; 6]> {
        self.blocks.last().map(|block| whole_steps(&block.steps))
    }

    /// How far the contour may leave the path [mm]: by the tolerance of rapids where two of them follow each other (the first
    /// behind a feed may less; that is not told apart here).
    pub fn tolerance(&self) -> f64 {
        let rapid = |block: &Block| block.duration == 0.0;
        let contour = &self.contour;
        if self.blocks.windows(2).any(|pair| pair.iter().all(rapid)) {
            contour.tolerance.max(contour.rapid_tolerance)
        } else {
            contour.tolerance
        }
    }

    /// One step of all motors that move, as a length at the tool [mm].
    pub fn step(&self) -> f64 {
        self.contour.step(&self.axes, self.moves())
    }

    /// Whether an operator's cue drops the rest of the path, and whether one moves motors off it.
    pub fn is_stopped(&self) -> bool {
        self.has_cue(|action| matches!(action, Action::Stop))
    }

    /// Whether one lets motors rest where no point is, and so between steps.
    pub fn rests_anywhere(&self) -> bool {
        self.has_cue(|action| matches!(action, Action::Hold | Action::Stop))
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
                key: motor.map(|motor| self.names[motor].clone()),
                name,
                detail,
            },
        }
    }

    /// Steps and durations of all moves.
    fn to_blocks(&self, places: &Places) -> Result<Vec<Block>, JobError> {
        let mut blocks = Vec::with_capacity(self.points.len());
        let (mut from, mut from_steps, mut time) = ([0.0; 6], [I32F32::ZERO; 6], 0.0);
        for (index, point) in self.points.iter().enumerate() {
            let rests = point.dwell > 0.0 || index + 1 == self.points.len();
            let mut steps = [I32F32::ZERO; 6];
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
                let [nearest] = whole_steps(&[here]);
                if nearest < lower || nearest > upper {
                    let detail = format!(
                        "{} would go to {at} {}, beyond its travel of {} to {}; widen travel if the machine allows it, or change the point",
                        self.names[motor],
                        unit(motor),
                        axis.travel.0,
                        axis.travel.1
                    );
                    return refuse("OutOfTravel", detail);
                }
                let here = if rests { nearest.into() } else { here };
                if here.checked_sub(from_steps[motor]).is_none() {
                    let detail = "a move of more than 2^31 - 1 steps is not possible; put a point in between";
                    return refuse("OutOfRange", detail.into());
                }
                steps[motor] = here;
            }
            let block = self.block(&from, point, steps);
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

    /// One move. A feed counts along the joints that slide, unless they hardly move beside those that turn: it must not rush
    /// these. How short a move is, or how fine a step, does not matter.
    fn block(&self, from: &[f64; 6], point: &PathPoint, steps: [I32F32; 6]) -> Block {
        let weights = self.contour.weights();
        let way = |motors: Range<usize>| {
            let squares = motors.map(|i| (weights[i] * (point.at[i] - from[i])).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let slides = way(0..FIRST_TURNING) > HARDLY * way(FIRST_TURNING..6);
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
            slides,
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

/// Points, where they come from, and what their joints are called.
struct Points {
    points: Vec<PathPoint>,
    origin: Origin,
    names: [String; 6],
    joints: Vec<usize>,
}

impl Points {
    /// Points of all motors under their own names.
    fn of_all(points: Vec<PathPoint>, origin: Origin) -> Self {
        Self {
            points,
            origin,
            names: MOTORS.map(String::from),
            joints: (0..MOTORS.len()).collect(),
        }
    }
}

/// The points from the one place where they are given.
fn read_points(
    root: &Table<'_>,
    path: &Table<'_>,
    pace: Option<Pace>,
    places: &Places,
) -> Result<Points, JobError> {
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
            Ok(Points::of_all(evenly(at)?, Origin::Array))
        }
        Some("path.shape") => {
            let points = evenly(read_shape(path, places)?)?;
            Ok(Points::of_all(points, Origin::Shape))
        }
        Some("path.file") => {
            let csv = Csv::beside(places, "path.file", path.text("file")?)?;
            let (rows, columns) = read_csv(&csv)?;
            let point = |row: &Row| {
                let pace = paced(row.pace, "path.feed")?;
                let (at, dwell) = (row.at, row.dwell);
                Ok(PathPoint { at, pace, dwell })
            };
            let points = rows.iter().map(point).collect::<Result<_, JobError>>()?;
            let lines = rows.iter().map(|row| row.line).collect();
            let mut names = MOTORS.map(String::from);
            let mut joints: Vec<usize> = Vec::new();
            for (motor, name) in columns {
                names[motor] = name;
                joints.push(motor);
            }
            joints.sort_unstable();
            let origin = Origin::File {
                file: csv.name,
                lines,
            };
            Ok(Points {
                points,
                origin,
                names,
                joints,
            })
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
            Ok(Points::of_all(points, Origin::Tables))
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
