//! Jobs of kind `poses`: where the tool shall be, on any machine, and what its motors can do.
//!
//! ```text
//! poses | file.csv -> PoseRow       tip [mm], tool axis from the tip into the body, x axis of the tool for an arm
//!                  -> joints        poses::plan, when the job is run: there a pose may turn out to be unreachable
//! ```
//!
//! A CSV file has a head line that names its columns: X Y Z I J K, for an arm U V W too, and F for the feed [mm/min] or
//! T for the inverse time [1/min] of the stretch that ends in the pose. What follows a `#` is a comment.

use super::csv::{Csv, cells};
use super::model::{Model, PoseMachine};
use super::points::MOST_POINTS;
use super::reader::{Kind, Table};
use super::{Job, JobError, Pace, Place, Places};
use hexstep::geometry::Vector;
use hexstep::stepper::Timing;

/// Poses that a machine runs through.
#[derive(Clone, Debug)]
pub struct PosesJob {
    pub machine: PoseMachine,
    pub rows: Vec<PoseRow>,
    /// How far the tip may leave the straight lines between the poses [mm], and the tool the turns [deg].
    pub tip_tolerance: f64,
    pub axis_tolerance: f64,
    /// Of the solutions of a five-axis machine those with the least turning over the whole path, and not at every pose
    /// the nearest.
    pub chooses_best: bool,
    /// Joints near which those of the first pose are chosen [mm, deg].
    pub near: Vec<f64>,
    origin: Origin,
}

/// A pose as it is written down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRow {
    /// [mm]
    pub tip: [f64; 3],
    /// Unit, from the tip into the body.
    pub axis: [f64; 3],
    /// For an arm: x axis of the tool, unit and at right angles to `axis`.
    pub across: Option<[f64; 3]>,
    /// Of the stretch that ends here; of the first pose it is not used.
    pub pace: Pace,
}

#[derive(Clone, Debug)]
enum Origin {
    Array,
    /// The file with the line of each pose.
    File(String, Vec<usize>),
    /// By a process, from what stands at this key; what each pose is.
    Made(&'static str, Vec<String>),
}

/// The widest row: tip, axis, x axis.
type Numbers = [f64; 9];

struct Found {
    numbers: Vec<Numbers>,
    paces: Vec<Option<Pace>>,
    origin: Origin,
}

impl PosesJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let machine = PoseMachine::read(root, timing, places)?;
        let path = root.table("path")?;
        path.known(&[MOTION, &["feed", "inverse_time", "choice", "poses", "file"]].concat())?;
        let is_arm = matches!(machine.model, Model::Arm { .. });
        let pace = default_pace(&path, places)?;
        let chooses_best = path.has("choice") && path.word("choice", &["nearest", "best"])? == 1;
        if chooses_best && !matches!(machine.model, Model::FiveAxis(_)) {
            let detail = "only a five-axis machine chooses so; an arm keeps one branch, all others the nearest joints";
            return Err(places.refuse("path.choice", "UnknownName", detail.into()));
        }
        let motion = Motion::read(&path, machine.joints.len())?;
        let found = match (path.has("poses"), path.has("file")) {
            (true, false) => inline(&path, is_arm)?,
            (false, true) => from_file(&path, is_arm, places)?,
            (both, _) => {
                let (name, detail) = if both {
                    (
                        "Contradictory",
                        "poses and file exclude each other; keep one of them",
                    )
                } else {
                    (
                        "MissingField",
                        "no poses; add poses = [[x, y, z, i, j, k], ...] or file = \"poses.csv\"",
                    )
                };
                return Err(places.refuse("path.poses", name, detail.into()));
            }
        };
        let mut job = Self {
            machine,
            rows: Vec::with_capacity(found.numbers.len()),
            tip_tolerance: motion.tip_tolerance,
            axis_tolerance: motion.axis_tolerance,
            chooses_best,
            near: motion.near,
            origin: found.origin,
        };
        if found.numbers.len() < 2 {
            let detail = "a path has at least two poses".into();
            return Err(job.refuse_in(places, 0, "OutOfRange", detail));
        }
        for (index, (numbers, given)) in found.numbers.iter().zip(found.paces).enumerate() {
            let pace = given.or(pace).or((index == 0).then_some(Pace::Feed(1.0)));
            let Some(pace) = pace else {
                let detail = "no feed; add feed = (mm/min) or inverse_time = (1/min) to [path], or a column F or T";
                return Err(job.refuse_in(places, index, "MissingField", detail.into()));
            };
            let row = checked(numbers, is_arm, pace);
            let row =
                row.map_err(|(name, detail)| job.refuse_in(places, index, name, detail.into()))?;
            job.rows.push(row);
        }
        Ok(job)
    }

    /// Poses that a process has made from what stands at `key`; `told` says of each pose what it is.
    pub(crate) fn made(
        machine: &PoseMachine,
        motion: &Motion,
        rows: Vec<PoseRow>,
        key: &'static str,
        told: Vec<String>,
    ) -> Self {
        Self {
            machine: machine.clone(),
            rows,
            tip_tolerance: motion.tip_tolerance,
            axis_tolerance: motion.axis_tolerance,
            chooses_best: false,
            near: motion.near.clone(),
            origin: Origin::Made(key, told),
        }
    }

    /// An error about a pose, where it is written.
    pub fn refuse(&self, job: &Job, index: usize, name: &'static str, detail: String) -> JobError {
        self.refuse_in(&job.places, index, name, detail)
    }

    fn refuse_in(
        &self,
        places: &Places,
        index: usize,
        name: &'static str,
        detail: String,
    ) -> JobError {
        match &self.origin {
            Origin::Array => places.refuse(&format!("path.poses[{index}]"), name, detail),
            Origin::Made(key, told) => {
                let what = told.get(index).map_or("", String::as_str);
                places.refuse(key, name, format!("{detail} ({what})"))
            }
            Origin::File(file, lines) => JobError {
                file: file.clone(),
                place: lines.get(index).map(|line| Place {
                    line: *line,
                    column: 1,
                }),
                key: Some(format!("pose {index}")),
                name,
                detail,
            },
        }
    }
}

/// Keys of `[path]` that [`Motion::read`] reads.
pub(super) const MOTION: &[&str] = &["tip_tolerance", "axis_tolerance", "near"];

/// How a machine follows poses, wherever they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// [mm]
    pub tip_tolerance: f64,
    /// [deg]
    pub axis_tolerance: f64,
    /// [mm, deg]
    pub near: Vec<f64>,
}

impl Motion {
    pub(super) fn read(path: &Table<'_>, joints: usize) -> Result<Self, JobError> {
        Ok(Self {
            tip_tolerance: path.number_or("tip_tolerance", 0.01, Kind::positive(10.0, "mm"))?,
            axis_tolerance: path.number_or("axis_tolerance", 0.05, Kind::positive(10.0, "deg"))?,
            near: read_near(path, joints)?,
        })
    }
}

fn default_pace(path: &Table<'_>, places: &Places) -> Result<Option<Pace>, JobError> {
    match (path.has("feed"), path.has("inverse_time")) {
        (true, true) => {
            let detail = "feed and inverse_time exclude each other; keep one of them".into();
            Err(places.refuse("path.inverse_time", "Contradictory", detail))
        }
        (true, _) => {
            let kind = Kind::positive(Pace::FEEDS.1, "mm/min");
            Ok(Some(Pace::Feed(path.number("feed", kind)?)))
        }
        (_, true) => {
            let kind = Kind::positive(Pace::INVERSE_TIMES.1, "1/min");
            Ok(Some(Pace::InverseTime(path.number("inverse_time", kind)?)))
        }
        _ => Ok(None),
    }
}

fn read_near(path: &Table<'_>, joints: usize) -> Result<Vec<f64>, JobError> {
    if !path.has("near") {
        return Ok(vec![0.0; joints]);
    }
    let any = Kind::between(-1e6, 1e6, "mm or deg");
    Ok(match joints {
        1 => path.numbers::<1>("near", any)?.to_vec(),
        2 => path.numbers::<2>("near", any)?.to_vec(),
        3 => path.numbers::<3>("near", any)?.to_vec(),
        4 => path.numbers::<4>("near", any)?.to_vec(),
        5 => path.numbers::<5>("near", any)?.to_vec(),
        _ => path.numbers::<6>("near", any)?.to_vec(),
    })
}

fn inline(path: &Table<'_>, is_arm: bool) -> Result<Found, JobError> {
    let numbers: Vec<Numbers> = if is_arm {
        path.rows::<9>("poses", MOST_POINTS)?
    } else {
        let rows = path.rows::<6>("poses", MOST_POINTS)?;
        rows.into_iter().map(widened).collect()
    };
    Ok(Found {
        paces: vec![None; numbers.len()],
        numbers,
        origin: Origin::Array,
    })
}

fn widened([x, y, z, i, j, k]: [f64; 6]) -> Numbers {
    [x, y, z, i, j, k, 0.0, 0.0, 0.0]
}

/// A row that says where the tool is, or the name and the detail of what is wrong with it.
fn checked(
    [x, y, z, i, j, k, u, v, w]: &Numbers,
    is_arm: bool,
    pace: Pace,
) -> Result<PoseRow, (&'static str, &'static str)> {
    let tip = [*x, *y, *z];
    if tip.iter().any(|x| x.abs() > 1e6) {
        return Err(("OutOfRange", "a coordinate is beyond 1e6 mm"));
    }
    let axis = Vector::new(*i, *j, *k).unit(1e-6);
    let axis = axis.ok_or(("BadDirection", "the tool axis is shorter than 1e-6"))?;
    let mut across = None;
    if is_arm {
        let x = Vector::new(*u, *v, *w).unit(1e-6);
        let x = x.ok_or(("BadDirection", "the tool's x axis is shorter than 1e-6"))?;
        // Digits that were rounded are put right; an x axis that is none is not guessed.
        let along = axis.dot(x);
        if along.abs() > 1e-3 {
            return Err((
                "BadPose",
                "the tool's x axis is not at right angles to its axis",
            ));
        }
        let x = (x - axis * along).unit(0.5);
        across = Some(
            x.ok_or(("BadPose", "the tool's x axis is none"))?
                .to_array(),
        );
    }
    Ok(PoseRow {
        tip,
        axis: axis.to_array(),
        across,
        pace,
    })
}

const COLUMNS: [&str; 11] = ["X", "Y", "Z", "I", "J", "K", "U", "V", "W", "F", "T"];
const FEED: usize = 9;
const INVERSE_TIME: usize = 10;

fn from_file(path: &Table<'_>, is_arm: bool, places: &Places) -> Result<Found, JobError> {
    let csv = Csv::beside(places, "path.file", path.text("file")?)?;
    let refuse = |place, key: Option<&str>, error: &'static str, detail: String| {
        csv.refuse(place, key, error, detail)
    };
    let mut lines = csv.lines();
    let wanted = if is_arm { 9 } else { 6 };

    let Some((head_line, head)) = lines.next() else {
        let detail = "it is empty; expected a line of column names, X,Y,Z,I,J,K, and two rows";
        return Err(refuse(None, None, "OutOfRange", detail.into()));
    };
    let mut columns: Vec<usize> = Vec::new();
    for (place, cell) in cells(head_line, head) {
        let column = COLUMNS.iter().position(|known| *known == cell);
        let column = column.filter(|column| *column < wanted || *column >= FEED);
        let Some(column) = column else {
            let detail = format!(
                "no such column is known here; expected are {}, F and T",
                COLUMNS[..wanted].join(", ")
            );
            return Err(refuse(Some(place), Some(cell), "UnknownField", detail));
        };
        if columns.contains(&column) {
            let detail = "this column is there already; keep one of them".into();
            return Err(refuse(Some(place), Some(cell), "Contradictory", detail));
        }
        columns.push(column);
    }
    if let Some(missing) = (0..wanted).find(|column| !columns.contains(column)) {
        let place = Some(Place {
            line: head_line,
            column: 1,
        });
        let detail = format!("the column is missing; add {}", COLUMNS[missing]);
        return Err(refuse(
            place,
            Some(COLUMNS[missing]),
            "MissingField",
            detail,
        ));
    }

    let (mut numbers, mut paces, mut places_of) = (Vec::new(), Vec::new(), Vec::new());
    for (line, text) in lines {
        let start = Some(Place { line, column: 1 });
        if numbers.len() >= MOST_POINTS {
            let detail = format!("more than {MOST_POINTS} poses; split the path");
            return Err(refuse(start, None, "OutOfRange", detail));
        }
        let (mut row, mut pace) = ([0.0; 9], None);
        for ((place, cell), column) in csv.row((line, text), columns.len())?.zip(&columns) {
            let name = COLUMNS[*column];
            if cell.is_empty() && *column >= FEED {
                continue;
            }
            let x = if *column < FEED {
                csv.number(place, name, cell)?
            } else {
                csv.ranged(place, name, cell, Pace::FEEDS)?
            };
            let given = match *column {
                FEED => Pace::Feed(x),
                INVERSE_TIME => Pace::InverseTime(x),
                column => {
                    row[column] = x;
                    continue;
                }
            };
            if pace.replace(given).is_some() {
                let detail = "this row has a feed and an inverse time; leave one of them empty";
                return Err(refuse(
                    Some(place),
                    Some(name),
                    "Contradictory",
                    detail.into(),
                ));
            }
        }
        numbers.push(row);
        paces.push(pace);
        places_of.push(line);
    }
    Ok(Found {
        numbers,
        paces,
        origin: Origin::File(csv.name, places_of),
    })
}
