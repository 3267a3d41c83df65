//! A job file -> a checked [`Job`], or an error that names file, line, key, what was expected and what to do.
//!
//! ```text
//! bytes -> UTF-8 text -> TOML with places      reader.rs   BadFile, BadToml
//!       -> each table: known keys only         reader.rs   UnknownField, MissingField, WrongType, NotFinite
//!       -> values and their ranges             drill.rs, counts.rs, path.rs   OutOfRange, OutOfTravel, Contradictory,
//!                                                                       and the errors of the cycle
//! ```
//!
//! Nothing is computed from a file that is not right as a whole. Lengths in mm, angles in degrees, times in s, driver
//! times in microseconds; each key is told in `jobs/*.toml`.

mod axes;
mod counts;
mod csv;
mod cues;
mod drill;
mod mirror;
mod model;
mod pair;
mod path;
mod points;
mod poses;
mod precession;
mod reader;
mod shaping;
mod surface;

pub use axes::{AxisLimits, Contour, FIRST_TURNING, MOTORS, unit};
pub use counts::{CountsJob, Line};
pub use drill::{DrillJob, Phi};
pub use mirror::{BiasJob, MirrorJob};
pub use model::{Model, PoseJoint, PoseMachine};
pub use pair::{PairJob, PairRow};
pub use path::{Block, PathJob};
pub use points::{Pace, PathPoint};
pub use poses::{Motion, PoseRow, PosesJob};
pub use precession::PrecessionJob;
pub use shaping::{FlexibleJoint, SHAPERS, Shaping};
pub use surface::SurfaceJob;

use crate::machine::TICK_HZ;
use hexstep::stepper::{StepMode, Timing};
use reader::{Kind, Source, Table};
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// A job, checked as far as it can be without running it.
#[derive(Clone, Debug)]
pub struct Job {
    /// The file's name without folder and ending.
    pub name: String,
    pub task: Task,
    pub timing: Timing,
    places: Places,
}

#[derive(Clone, Debug)]
pub enum Task {
    /// Grinds a drill point: `kind = "drill-point"`.
    DrillPoint(Box<DrillJob>),
    /// Runs lines of step counts: `kind = "counts"`.
    Counts(CountsJob),
    /// Follows a path of joints: `kind = "path"`.
    Path(Box<PathJob>),
    /// Takes a tool through poses, on any machine: `kind = "poses"`.
    Poses(Box<PosesJob>),
    /// Grinds a free-form surface in rows: `kind = "surface"`.
    Surface(Box<SurfaceJob>),
    /// Polishes along a surface under continuous precession: `kind = "precession"`.
    Precession(Box<PrecessionJob>),
    /// Mills a panel from both sides: `kind = "mirror"`.
    Mirror(Box<MirrorJob>),
}

/// Where in which file something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Both from 1; columns in characters.
    pub line: usize,
    pub column: usize,
}

/// The places of all values of a file by their keys: `drill.web`, `machine.travel[3]`.
#[derive(Clone, Debug, Default)]
struct Places {
    file: String,
    by_key: BTreeMap<String, Place>,
}

/// Why a job is refused. Nothing has been computed or written then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobError {
    pub file: String,
    /// Unknown where a key is missing or has its default.
    pub place: Option<Place>,
    /// `table.key`, where a key is at fault.
    pub key: Option<String>,
    /// The error's name, such as `OutOfRange`.
    pub name: &'static str,
    /// What was found, what was expected and what to do.
    pub detail: String,
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(place) = self.place {
            write!(f, ":{}:{}", place.line, place.column)?;
        }
        if let Some(key) = &self.key {
            write!(f, ": {key}")?;
        }
        write!(f, ": {}: {}", self.name, self.detail)
    }
}

impl std::error::Error for JobError {}

const TABLES: &[&str] = &[
    "kind",
    "drill",
    "structure",
    "cycle",
    "machine",
    "stepper",
    "line",
    "path",
    "point",
    "cue",
    "joint",
    "surface",
    "grinding",
    "polishing",
    "simulation",
    "panel",
    "bias",
];

impl Job {
    /// Reads a job file.
    ///
    /// # Errors
    /// See [`JobError`]; `BadFile` when it cannot be read at all.
    pub fn load(path: &Path) -> Result<Self, JobError> {
        let file = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| JobError {
            file: file.clone(),
            place: None,
            key: None,
            name: "BadFile",
            detail: format!("it cannot be read ({error}); give the path of a job file, `hexstep list` shows some"),
        })?;
        let name = path
            .file_stem()
            .map_or_else(|| "job".into(), |stem| stem.to_string_lossy().into_owned());
        Self::parse(&file, &name, &bytes)
    }

    /// Reads a job from the bytes of a file; `file` is the name that errors carry, `name` that of the job.
    ///
    /// # Errors
    /// See [`JobError`].
    pub fn parse(file: &str, name: &str, bytes: &[u8]) -> Result<Self, JobError> {
        let source = Source::new(file, bytes)?;
        let document = source.document()?;
        let root = Table::root(&source, &document);
        root.known(TABLES)?;
        let kinds = [
            "drill-point",
            "counts",
            "path",
            "poses",
            "surface",
            "precession",
            "mirror",
        ];
        let kind = root.word("kind", &kinds)?;

        let mut places = Places {
            file: file.into(),
            by_key: BTreeMap::new(),
        };
        root.note_places(&mut places.by_key);
        let timing = timing(&root)?;
        let task = match kind {
            0 => {
                root.known_for(
                    kinds[kind],
                    &["kind", "drill", "structure", "cycle", "machine", "stepper"],
                )?;
                Task::DrillPoint(Box::new(DrillJob::read(&root, &timing, &places)?))
            }
            1 => {
                root.known_for(kinds[kind], &["kind", "line", "stepper"])?;
                Task::Counts(CountsJob::read(&root, &timing, &places)?)
            }
            3 => {
                root.known_for(
                    kinds[kind],
                    &["kind", "machine", "joint", "path", "stepper"],
                )?;
                Task::Poses(Box::new(PosesJob::read(&root, &timing, &places)?))
            }
            4 => {
                let tables = ["kind", "machine", "surface", "grinding", "path", "stepper"];
                root.known_for(kinds[kind], &tables)?;
                Task::Surface(Box::new(SurfaceJob::read(&root, &timing, &places)?))
            }
            5 => {
                let tables = ["kind", "machine", "joint", "polishing", "path", "stepper"];
                root.known_for(kinds[kind], &tables)?;
                Task::Precession(Box::new(PrecessionJob::read(&root, &timing, &places)?))
            }
            6 => {
                let tables = [
                    "kind",
                    "simulation",
                    "panel",
                    "bias",
                    "machine",
                    "joint",
                    "path",
                    "stepper",
                ];
                root.known_for(kinds[kind], &tables)?;
                Task::Mirror(Box::new(MirrorJob::read(&root, &timing, &places)?))
            }
            _ => {
                root.known_for(
                    kinds[kind],
                    &["kind", "machine", "path", "point", "cue", "stepper"],
                )?;
                Task::Path(Box::new(PathJob::read(&root, &timing, &places)?))
            }
        };
        Ok(Self {
            name: name.into(),
            task,
            timing,
            places,
        })
    }

    /// What the six motors are called; nothing where the job has none.
    pub fn motor_names(&self) -> [String; 6] {
        match self.machine() {
            Some(machine) => {
                let name = |i: usize| machine.joints.get(i).map(|joint| joint.name.clone());
                std::array::from_fn(|i| name(i).unwrap_or_default())
            }
            None => match &self.task {
                Task::Path(path) => std::array::from_fn(|i| match path.joints.contains(&i) {
                    true => path.names[i].clone(),
                    false => String::new(),
                }),
                _ => MOTORS.map(String::from),
            },
        }
    }

    /// The machine that takes a tool through poses, where the job has one.
    pub fn machine(&self) -> Option<&PoseMachine> {
        match &self.task {
            Task::Poses(poses) => Some(&poses.machine),
            Task::Surface(surface) => Some(&surface.machine),
            Task::Precession(precession) => Some(&precession.machine),
            Task::DrillPoint(_) | Task::Counts(_) | Task::Path(_) | Task::Mirror(_) => None,
        }
    }

    /// The pair of machines that mills a panel, where the job has one.
    pub fn pair(&self) -> Option<&PairJob> {
        match &self.task {
            Task::Mirror(mirror) => mirror.pair.as_ref(),
            _ => None,
        }
    }

    /// An error about the value at `key`, for what shows only when the job is worked out.
    pub fn refuse(&self, key: &str, name: &'static str, detail: String) -> JobError {
        self.places.refuse(key, name, detail)
    }
}

impl Places {
    fn refuse(&self, key: &str, name: &'static str, detail: String) -> JobError {
        // An element without a place of its own has that of its array.
        let array = key.split('[').next().unwrap_or(key);
        JobError {
            file: self.file.clone(),
            place: self
                .by_key
                .get(key)
                .or_else(|| self.by_key.get(array))
                .copied(),
            key: Some(key.into()),
            name,
            detail,
        }
    }
}

/// `[stepper]`: driver times and the step mode.
fn timing(root: &Table<'_>) -> Result<Timing, JobError> {
    let mut timing = Times::default();
    if let Some(table) = root.table_if_any("stepper")? {
        table.known(&["pulse_us", "setup_us", "hold_us", "mode"])?;
        // A tick lasts at least as long as a pulse, and at the floor of the tick rate 25 us.
        timing.pulse = table.number_or("pulse_us", timing.pulse, Kind::between(1.0, 25.0, "us"))?;
        timing.setup =
            table.number_or("setup_us", timing.setup, Kind::between(0.0, 1000.0, "us"))?;
        timing.hold = table.number_or("hold_us", timing.hold, Kind::between(0.0, 1000.0, "us"))?;
        let modes = ["pulse", "both-edge"];
        if table.has("mode") {
            timing.mode = match table.word("mode", &modes)? {
                0 => StepMode::Pulse,
                _ => StepMode::BothEdge,
            };
        }
    }
    // At most 10^6 ns.
    let ns = |us: f64| (us * 1000.0).ceil() as u32;
    Ok(Timing::from_ns(
        TICK_HZ,
        ns(timing.pulse),
        ns(timing.setup),
        ns(timing.hold),
        timing.mode,
    ))
}

/// Driver times [us]: what a TMC2209 or a DRV8825 asks for, with a margin.
struct Times {
    pulse: f64,
    setup: f64,
    hold: f64,
    mode: StepMode,
}

impl Default for Times {
    fn default() -> Self {
        Self {
            pulse: 2.0,
            setup: 2.0,
            hold: 2.0,
            mode: StepMode::Pulse,
        }
    }
}
