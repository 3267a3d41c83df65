//! Jobs of kind `surface`: a part, how it is ground, and the arm that does it.
//!
//! ```text
//! [surface]   a NURBS surface, or "dune"             -> Part; control points also from a CSV file
//! [grinding]  wheel, materials, process, planning    -> surface::Job, checked
//! [path]      the rows that become pulses, lifts     -> rows, planned when the job is run
//! [machine]   an arm: a wheel needs all six joints
//! ```
//!
//! Numbers of the process are checked by the process itself, so that an error has the name that it has everywhere.

use super::csv::Csv;
use super::model::{Model, PoseMachine};
use super::poses::{MOTION, Motion};
use super::reader::{Kind, Table};
use super::{Job, JobError, Places};
use crate::surface::{self, Part, StepMode, Strategy, SurfaceError, dune};
use hexstep::cycles::surface_grinding::{Depth, Model as Combining, Sense};
use hexstep::geometry::Vector;
use hexstep::geometry::nurbs::{MAX_COUNT, NurbsError};
use hexstep::stepper::Timing;
use std::collections::BTreeMap;

/// A surface to be ground.
#[derive(Clone, Debug)]
pub struct SurfaceJob {
    /// `dune`, or `own` for one that is written out.
    pub surface: &'static str,
    pub part: Box<Part>,
    /// Process and planning.
    pub grinding: surface::Job,
    /// Places along u at which the ground profile is simulated.
    pub stations: usize,
    /// Whether the other strategies are planned and simulated as well.
    pub compare: bool,
    pub machine: PoseMachine,
    pub motion: Motion,
    /// Rows that become pulses, first and last; `None` for two in the middle.
    pub rows: Option<[usize; 2]>,
    /// Every other row is ground backwards.
    pub zigzag: bool,
    /// How far the wheel is lifted between rows [mm].
    pub lift: f64,
}

const SURFACE: &[&str] = &[
    "shape",
    "degree",
    "knots_u",
    "knots_v",
    "points",
    "points_csv",
    "weights",
];
/// Of a file with control points: numbers of the point along u and v from 0, the point [mm], its weight.
const COLUMNS: [&str; 6] = ["i", "j", "x", "y", "z", "w"];
const GRINDING: &[&str] = &[
    "preset",
    "e1",
    "nu1",
    "e2",
    "nu2",
    "r_rim",
    "r_crown",
    "half_width",
    "force",
    "k",
    "rpm",
    "feed",
    "scallop",
    "margin",
    "sense",
    "model",
    "depth_mode",
    "depth",
    "eps",
    "e_lat",
    "e_gap",
    "l_max",
    "turn",
    "seed",
    "nodes",
    "strategy",
    "count",
    "step_mode",
    "stations",
    "compare",
];

impl SurfaceJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let machine = PoseMachine::read(root, timing, places)?;
        if !matches!(machine.model, Model::Arm { .. }) {
            let detail =
                "the axle of a wheel has a direction, which takes six joints; give model = \"arm\"";
            return Err(places.refuse("machine.model", "Contradictory", detail.into()));
        }
        let (surface, part) = read_part(&root.table("surface")?, places)?;
        let table = root.table("grinding")?;
        table.known(GRINDING)?;
        let grinding = read_grinding(&table, places)?;
        let path = root.table("path")?;
        path.known(&[MOTION, &["rows", "zigzag", "lift"]].concat())?;
        let most = surface::MAX_ROWS as i64;
        let rows = if path.has("rows") {
            let [first, last] = path.wholes::<2>("rows", 0, most)?;
            if first > last {
                let detail = format!("expected first <= last, found [{first}, {last}]");
                return Err(places.refuse("path.rows", "OutOfRange", detail));
            }
            Some([first as usize, last as usize])
        } else {
            None
        };
        Ok(Self {
            surface,
            part,
            grinding,
            stations: table.whole_or("stations", 60, 2, 2000)? as usize,
            compare: !table.has("compare") || table.flag("compare")?,
            motion: Motion::read(&path, machine.joints.len())?,
            machine,
            rows,
            zigzag: path.flag("zigzag")?,
            lift: path.number_or("lift", 5.0, Kind::positive(1000.0, "mm"))?,
        })
    }

    /// An error of planning, at the key that it is about.
    pub fn refuse(&self, job: &Job, error: &SurfaceError) -> JobError {
        refusal(&job.places, error)
    }
}

fn refusal(places: &Places, error: &SurfaceError) -> JobError {
    // A place on the surface names the surface; a parameter its own key.
    let key = match error.field() {
        Some("rows") => "grinding.count".into(),
        Some(field) => format!("grinding.{field}"),
        None if matches!(error.name(), "BadMaterial" | "NoHertzContact") => {
            "grinding.r_crown".into()
        }
        None => "grinding".into(),
    };
    places.refuse(&key, error.name(), error.to_string())
}

fn read_part(table: &Table<'_>, places: &Places) -> Result<(&'static str, Box<Part>), JobError> {
    table.known(SURFACE)?;
    let refuse = |error: NurbsError| {
        let key = match (error.name(), error.field()) {
            (_, Some("degree_u" | "degree_v")) => "surface.degree".into(),
            (_, Some(field)) => format!("surface.{field}"),
            ("BadDegree", None) => "surface.degree".into(),
            _ => "surface.points".into(),
        };
        places.refuse(&key, error.name(), error.remedy().into())
    };
    if table.has("shape") {
        table.word("shape", &["dune"])?;
        if let Some(other) = SURFACE.iter().skip(1).find(|key| table.has(key)) {
            let detail = format!("shape = \"dune\" and {other} exclude each other");
            return Err(places.refuse(&format!("surface.{other}"), "Contradictory", detail));
        }
        return Ok(("dune", dune().map_err(refuse)?));
    }
    let [p, q] = table.wholes::<2>("degree", i64::MIN, i64::MAX)?;
    let degree = [p, q].map(|d| usize::try_from(d).unwrap_or(0));
    let (knots_u, knots_v) = (table.list("knots_u")?, table.list("knots_v")?);
    if table.has("points_csv") {
        let net = net_of_file(table, places)?;
        let part = Part::new(
            degree,
            net.counts,
            [&knots_u, &knots_v],
            &net.points,
            &net.weights,
        );
        // Of the net as a whole; what is wrong with one point was told with its line.
        let part = part.map_err(|error| match error.name() {
            "BadNet" => {
                let detail = format!("{}: {}", net.file, error.remedy());
                places.refuse("surface.points_csv", error.name(), detail)
            }
            _ => refuse(error),
        })?;
        return Ok(("own", Box::new(part)));
    }
    let net = table.net("points")?;
    let width = net.first().map_or(0, Vec::len);
    let mut points = Vec::new();
    for (i, row) in net.iter().enumerate() {
        for (j, point) in row.iter().enumerate() {
            let [x, y, z] = point.as_slice() else {
                let key = format!("surface.points[{i}][{j}]");
                let detail = format!("expected a point [x, y, z], found {} numbers", point.len());
                return Err(places.refuse(&key, "WrongType", detail));
            };
            points.push(Vector::new(*x, *y, *z));
        }
    }
    // A net that is not rectangular is handed on empty, so that it is refused in its turn.
    if net.iter().any(|row| row.len() != width) {
        points.clear();
    }
    let counts = [net.len(), width];
    let mut fits = true;
    let weights = if table.has("weights") {
        let rows = table.lists("weights")?;
        fits = rows.len() == counts[0] && rows.iter().all(|row| row.len() == width);
        if fits {
            rows.concat()
        } else {
            vec![1.0; points.len() + 1]
        }
    } else {
        Vec::new()
    };
    let part = Part::new(degree, counts, [&knots_u, &knots_v], &points, &weights);
    let part = part.map_err(|error| {
        let refused = refuse(error);
        if fits || error.name() != "BadNet" {
            return refused;
        }
        places.refuse("surface.weights", refused.name, refused.detail)
    })?;
    Ok(("own", Box::new(part)))
}

/// Control points of a file.
struct Net {
    file: String,
    counts: [usize; 2],
    points: Vec<Vector<f64>>,
    /// None where the file has no column of them.
    weights: Vec<f64>,
}

/// Every (i, j) of a rectangle once, in any order.
fn net_of_file(table: &Table<'_>, places: &Places) -> Result<Net, JobError> {
    if let Some(other) = ["points", "weights"].iter().find(|key| table.has(key)) {
        let detail = format!("points_csv and {other} exclude each other");
        return Err(places.refuse(&format!("surface.{other}"), "Contradictory", detail));
    }
    let csv = Csv::beside(places, "surface.points_csv", table.text("points_csv")?)?;
    let rows = csv.table(COLUMNS, 5, MAX_COUNT * MAX_COUNT)?;
    let mut net: BTreeMap<[usize; 2], (Vector<f64>, Option<f64>)> = BTreeMap::new();
    for row in &rows {
        let refuse = |column: usize, name, detail| {
            csv.refuse(Some(row.place(column)), Some(COLUMNS[column]), name, detail)
        };
        let mut at = [0; 2];
        for (column, slot) in at.iter_mut().enumerate() {
            let number = row.number(column).unwrap_or(f64::NAN);
            let most = (MAX_COUNT - 1) as f64;
            if !((0.0..=most).contains(&number) && number.fract() == 0.0) {
                let detail = format!("expected a whole number from 0 to {most}, found {number}");
                return Err(refuse(column, "BadNet", detail));
            }
            // Whole and small.
            *slot = number as usize;
        }
        let point = row.three(2);
        if let Some(column) = point.iter().position(|x| !x.is_finite()) {
            let detail = format!("expected a finite number, found {}", point[column]);
            return Err(refuse(2 + column, "BadNet", detail));
        }
        let weight = row.number(5);
        if weight.is_some_and(|w| !(w.is_finite() && w > 0.0)) {
            let detail = "expected a finite weight above 0".into();
            return Err(refuse(5, "BadWeight", detail));
        }
        if net
            .insert(at, (Vector::from_array(point), weight))
            .is_some()
        {
            let detail = format!("the control point ({}, {}) is there already", at[0], at[1]);
            return Err(refuse(0, "BadNet", detail));
        }
    }
    let count = |k: usize| net.keys().map(|at| at[k] + 1).max().unwrap_or(0);
    let counts = [count(0), count(1)];
    let all = (0..counts[0]).flat_map(|i| (0..counts[1]).map(move |j| [i, j]));
    if let Some([i, j]) = all.into_iter().find(|at| !net.contains_key(at)) {
        let detail = format!(
            "the control point ({i}, {j}) is missing; expected every i from 0 to {} with every j from 0 to {}",
            counts[0] - 1,
            counts[1] - 1
        );
        return Err(csv.refuse(None, None, "BadNet", detail));
    }
    Ok(Net {
        file: csv.name,
        counts,
        points: net.values().map(|(point, _)| *point).collect(),
        weights: net.values().filter_map(|(_, weight)| *weight).collect(),
    })
}

fn read_grinding(table: &Table<'_>, places: &Places) -> Result<surface::Job, JobError> {
    let mut job = surface::Job::hard();
    if table.has("preset") && table.word("preset", &["hard", "soft"])? == 1 {
        job = surface::Job::soft();
    }
    let number = |key: &str, slot: &mut f64| -> Result<(), JobError> {
        *slot = table.number_or(key, *slot, Kind::LOOSE)?;
        Ok(())
    };
    let process = &mut job.process;
    number("e1", &mut process.wheel_material.modulus)?;
    number("nu1", &mut process.wheel_material.poisson)?;
    number("e2", &mut process.part_material.modulus)?;
    number("nu2", &mut process.part_material.poisson)?;
    // 0 is a flat wheel, which has no radius.
    for (key, slot) in [
        ("r_rim", &mut process.wheel.rim),
        ("r_crown", &mut process.wheel.crown),
    ] {
        if table.is_word(key) {
            table.word(key, &["flat"])?;
            *slot = None;
        } else if table.has(key) {
            *slot = Some(table.number(key, Kind::LOOSE)?);
        }
    }
    number("force", &mut process.force)?;
    number("k", &mut process.k)?;
    number("rpm", &mut process.rpm)?;
    number("feed", &mut process.feed)?;
    number("scallop", &mut process.scallop)?;
    number("margin", &mut process.margin)?;
    if table.has("sense") {
        process.sense = match table.whole("sense", i64::MIN, i64::MAX)? {
            0 => Sense::Neglected,
            1 => Sense::Against,
            -1 => Sense::With,
            other => {
                let detail = format!("sense must be -1, 0 or 1, found {other}");
                return Err(places.refuse("grinding.sense", "BadParameter", detail));
            }
        };
    }
    let choice = |key: &str, words: &[&str]| -> Result<Option<usize>, JobError> {
        if !table.has(key) {
            return Ok(None);
        }
        table.word(key, words).map(Some).map_err(|error| JobError {
            // Of a process, an unknown mode has a name of its own.
            name: if error.name == "UnknownName" {
                "BadParameter"
            } else {
                error.name
            },
            ..error
        })
    };
    match choice("model", &["envelope", "additive"])? {
        Some(0) => process.model = Combining::Envelope,
        Some(_) => process.model = Combining::Additive,
        None => {}
    }
    let mut depth = 0.08;
    number("depth", &mut depth)?;
    match choice("depth_mode", &["constant_feed", "constant_depth"])? {
        Some(0) => process.depth = Depth::ConstantFeed,
        Some(_) => process.depth = Depth::Constant(depth),
        None => {}
    }
    number("eps", &mut job.eps)?;
    number("e_lat", &mut job.e_lat)?;
    number("e_gap", &mut job.e_gap)?;
    number("l_max", &mut job.l_max)?;
    let mut turn = job.turn.to_degrees();
    number("turn", &mut turn)?;
    job.turn = turn.to_radians();
    number("seed", &mut job.seed)?;
    if table.has("nodes") {
        let nodes = table.whole("nodes", i64::MIN, i64::MAX)?;
        job.nodes = usize::try_from(nodes).unwrap_or(0);
    }
    let count = if table.has("count") {
        usize::try_from(table.whole("count", i64::MIN, i64::MAX)?).unwrap_or(0)
    } else {
        0
    };
    match choice("strategy", &["adaptive", "rowmin", "iso"])? {
        Some(1) => job.strategy = Strategy::RowMin,
        Some(2) => job.strategy = Strategy::Iso(count),
        _ => {}
    }
    match choice("step_mode", &["common", "row"])? {
        Some(0) => job.step_mode = StepMode::Common,
        Some(_) => job.step_mode = StepMode::Row,
        None => {}
    }
    if table.has("half_width") {
        job.half_width = Some(table.number("half_width", Kind::LOOSE)?);
    }
    job.check().map_err(|error| refusal(places, &error))?;
    Ok(job)
}
