//! Jobs of kind `precession`: a bonnet along points of a surface under continuous precession, on any machine.
//!
//! The points stand in the job, or in a CSV file with the columns x, y, z, nx, ny, nz.
//!
//! Numbers of the process are checked by the library's cycle, so that an error has the name that it has everywhere.

use super::csv::{Csv, Row};
use super::model::PoseMachine;
use super::points::MOST_POINTS;
use super::poses::{MOTION, Motion};
use super::reader::{Kind, Table};
use super::{Job, JobError, Place, Places};
use hexstep::cycles::precession::{
    Contact, Cycle, Drive, FarEnd, FeedAt, Field, Parameters, PrecessionError, Reference,
};
use hexstep::geometry::Vector;
use hexstep::stepper::Timing;

/// A path to be polished.
#[derive(Clone, Debug)]
pub struct PrecessionJob {
    pub parameters: Parameters<f64>,
    /// Points of the surface [mm] with their outward normals, in the work frame.
    pub contacts: Vec<Contact<f64>>,
    /// Speed of the bonnet about its own axis [rad/s].
    pub spindle: f64,
    pub machine: PoseMachine,
    pub motion: Motion,
    origin: Origin,
}

/// Where the points stand.
#[derive(Clone, Debug)]
enum Origin {
    Arrays,
    /// The file with the line of each point, and in each line the columns at which point and normal begin.
    File(String, Vec<[Place; 2]>),
}

const COLUMNS: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

const POLISHING: &[&str] = &[
    "theta",
    "bonnet_radius",
    "inward",
    "feed",
    "feed_at",
    "rate",
    "pitch",
    "alpha0",
    "reference",
    "ref",
    "ell",
    "ell_sign",
    "eps",
    "dpsi",
    "dt_max",
    "w_rot",
    "dwell",
    "spindle",
];

/// A job of more poses would fill the memory.
const MOST_POSES: u64 = 500_000;

impl PrecessionJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let machine = PoseMachine::read(root, timing, places)?;
        let polishing = root.table("polishing")?;
        polishing.known(POLISHING)?;
        let (parameters, spindle) = read_parameters(&polishing, places)?;
        let path = root.table("path")?;
        path.known(&[MOTION, &["points", "normals", "points_csv"]].concat())?;
        let (contacts, origin) = if path.has("points_csv") {
            from_file(&path, places)?
        } else {
            (inline(&path, places)?, Origin::Arrays)
        };
        let cycle =
            Cycle::new(&parameters, &contacts).map_err(|error| refusal(places, &origin, &error))?;
        let poses: u64 = cycle.segments().map(|s| u64::from(s.steps())).sum();
        if poses > MOST_POSES {
            let detail = format!(
                "the path needs {poses} poses, more than {MOST_POSES}; divide it, or raise eps, dpsi or dt_max"
            );
            return Err(places.refuse("polishing.eps", "BadLimit", detail));
        }
        if poses == 0 {
            let detail = "all points are the same place; give another, or a dwell for one alone";
            return Err(places.refuse(origin.key(), "BadPath", detail.into()));
        }
        Ok(Self {
            parameters,
            contacts,
            spindle,
            motion: Motion::read(&path, machine.joints.len())?,
            machine,
            origin,
        })
    }

    /// The key at which the points stand.
    pub fn points_key(&self) -> &'static str {
        self.origin.key()
    }

    /// The cycle, which was checked when the job was read.
    ///
    /// # Errors
    /// Those of the cycle.
    pub fn cycle(&self, job: &Job) -> Result<Cycle<'_, f64>, JobError> {
        let cycle = Cycle::new(&self.parameters, &self.contacts);
        cycle.map_err(|error| refusal(&job.places, &self.origin, &error))
    }
}

impl Origin {
    fn key(&self) -> &'static str {
        match self {
            Self::Arrays => "path.points",
            Self::File(..) => "path.points_csv",
        }
    }
}

fn inline(path: &Table<'_>, places: &Places) -> Result<Vec<Contact<f64>>, JobError> {
    let read = |key: &str| -> Result<Vec<Vector<f64>>, JobError> {
        let rows = path.lists(key)?.into_iter().enumerate();
        rows.map(|(index, row)| match row.as_slice() {
            [x, y, z] => Ok(Vector::new(*x, *y, *z)),
            other => {
                let key = format!("path.{key}[{index}]");
                let detail = format!("expected [x, y, z], found {} numbers", other.len());
                Err(places.refuse(&key, "WrongType", detail))
            }
        })
        .collect()
    };
    let (points, normals) = (read("points")?, read("normals")?);
    // Refused as a path without points: the checks before it still come first.
    Ok(if points.len() == normals.len() {
        let pairs = points.iter().zip(&normals);
        pairs.map(|(p, n)| Contact { p: *p, n: *n }).collect()
    } else {
        Vec::new()
    })
}

fn from_file(path: &Table<'_>, places: &Places) -> Result<(Vec<Contact<f64>>, Origin), JobError> {
    if let Some(other) = ["points", "normals"].iter().find(|key| path.has(key)) {
        let detail = format!("points_csv and {other} exclude each other");
        return Err(places.refuse(&format!("path.{other}"), "Contradictory", detail));
    }
    let csv = Csv::beside(places, "path.points_csv", path.text("points_csv")?)?;
    let rows = csv.table(COLUMNS, COLUMNS.len(), MOST_POINTS)?;
    let contact = |row: &Row<6>| Contact {
        p: Vector::from_array(row.three(0)),
        n: Vector::from_array(row.three(3)),
    };
    let contacts = rows.iter().map(contact).collect();
    let lines = rows.iter().map(|row| [row.place(0), row.place(3)]);
    Ok((contacts, Origin::File(csv.name, lines.collect())))
}

fn refusal(places: &Places, origin: &Origin, error: &PrecessionError) -> JobError {
    let (key, index) = match (error.field(), error.index()) {
        (Some(field @ (Field::Points | Field::Normals)), index) => (field.name(), index),
        (Some(field), _) => {
            let key = format!("polishing.{}", field.name());
            return places.refuse(&key, error.name(), error.remedy().into());
        }
        (None, index) => ("points", index),
    };
    let element = match index {
        Some(index) => format!("{key}[{index}]"),
        None => key.into(),
    };
    match origin {
        Origin::Arrays => places.refuse(
            &format!("path.{element}"),
            error.name(),
            error.remedy().into(),
        ),
        Origin::File(file, lines) => {
            let line = index.and_then(|index| lines.get(index as usize));
            JobError {
                file: file.clone(),
                place: line.map(|[point, normal]| if key == "normals" { *normal } else { *point }),
                key: Some(element),
                name: error.name(),
                detail: error.remedy().into(),
            }
        }
    }
}

fn read_parameters(table: &Table<'_>, places: &Places) -> Result<(Parameters<f64>, f64), JobError> {
    let number = |key: &str, default: f64| table.number_or(key, default, Kind::LOOSE);
    let degrees = |key: &str, default: f64| number(key, default).map(f64::to_radians);
    if table.has("pitch") && table.has("rate") {
        let detail = "pitch and rate exclude each other; keep one of them";
        return Err(places.refuse("polishing.pitch", "Contradictory", detail.into()));
    }
    let drive = if table.has("pitch") {
        Drive::Distance {
            pitch: table.number("pitch", Kind::LOOSE)?,
        }
    } else {
        Drive::Time {
            rate: degrees("rate", 30.0)?,
        }
    };
    let word = |key: &str, words: &[&str]| match table.has(key) {
        true => table.word(key, words),
        false => Ok(0),
    };
    let first_reference = match table.has("ref") {
        true => Some(Vector::from_array(table.numbers::<3>("ref", Kind::LOOSE)?)),
        false => None,
    };
    let far_end = match table.whole_or("ell_sign", 1, i64::MIN, i64::MAX)? {
        1 => FarEnd::Spindle,
        -1 => FarEnd::Surface,
        other => {
            let detail = format!("1, towards the spindle, or -1, below the surface; found {other}");
            return Err(places.refuse("polishing.ell_sign", "BadLimit", detail));
        }
    };
    let parameters = Parameters {
        theta: degrees("theta", 20.0)?,
        bonnet_radius: number("bonnet_radius", 40.0)?,
        inward: number("inward", 0.5)?,
        feed: number("feed", 5.0)?,
        feed_at: match word("feed_at", &["contact", "centre"])? {
            0 => FeedAt::Contact,
            _ => FeedAt::Centre,
        },
        drive,
        alpha0: degrees("alpha0", 0.0)?,
        reference: match word("reference", &["transport", "feed_locked"])? {
            0 => Reference::Transport,
            _ => Reference::FeedLocked,
        },
        first_reference,
        ell: number("ell", 127.0)?,
        far_end,
        eps: number("eps", 0.01)?,
        dpsi: degrees("dpsi", 5.0)?,
        dt_max: number("dt_max", 0.5)?,
        w_rot: degrees("w_rot", 20.0)?,
        dwell: number("dwell", 0.0)?,
    };
    let spindle = table.number_or("spindle", 0.0, Kind::between(-1e6, 1e6, "r/min"))?;
    Ok((parameters, spindle * std::f64::consts::TAU / 60.0))
}
