//! What a request gives: the surface, the job, curvatures; and how faults of the process are named.

use super::super::request::read;
use super::super::{Fault, Kind, Request, schema};
use crate::surface::{Job, Part, StepMode, Strategy, SurfaceError, dune};
use hexstep::cycles::surface_grinding::{
    self as process, Depth, GrindingError, Material, Model, Sense, Wheel,
};
use hexstep::geometry::Vector;
use hexstep::geometry::nurbs::NurbsError;
use hexstep::math::Real;
use serde_json::{Map, Value};

pub fn fault_of_surface(error: NurbsError) -> Fault {
    let fault = Fault::new(error.name(), error.remedy());
    match error.field() {
        Some(field) => fault.field(field),
        None => fault,
    }
}

pub fn fault_of_grinding<R: Real>(error: GrindingError<R>) -> Fault {
    let fault = match error.field() {
        Some(field) => {
            let name = field.name();
            Fault::new(error.name(), format!("{name}: {}", error.remedy())).field(name)
        }
        None => Fault::new(error.name(), error.remedy()),
    };
    let figure = |x: R| super::super::answer::number(x);
    match error {
        GrindingError::NoHertzContact { least } => fault.with("least", figure(least)),
        GrindingError::LineContact { ratio } => fault.with("ratio", figure(ratio)),
        GrindingError::FootprintTooLarge { b_c, .. } => fault.with("b_c", figure(b_c)),
        GrindingError::TooShallow { h0, .. } | GrindingError::AdditiveBranch { h0, .. } => {
            fault.with("h0", figure(h0))
        }
        _ => fault,
    }
}

pub fn fault_of_plan(error: SurfaceError) -> Fault {
    let mut fault = Fault::new(error.name(), error.to_string());
    if let Some(field) = error.field() {
        fault = fault.field(field);
    }
    let place = error.place();
    if let Some([u, v]) = place.uv {
        let uv = [u, v].map(super::super::answer::number);
        fault = fault.with("uv", uv.to_vec());
    }
    match place.row {
        Some(row) => fault.with("row", row),
        None => fault,
    }
}

pub fn bad(field: &str, expected: &str) -> Fault {
    Fault::new("BadParameter", format!("{field} {expected}")).field(field)
}

/// The surface of a request.
pub fn part<R: Real>(request: &Request) -> Result<Box<Part<R>>, Fault> {
    let Some(Value::Object(object)) = request.value("surface") else {
        return dune().map_err(fault_of_surface);
    };
    let degree = |name: &str| {
        let degree = object.get(name).and_then(schema::integer_of);
        degree.and_then(|d| usize::try_from(d).ok()).unwrap_or(0)
    };
    let numbers = |value: &Value| -> Vec<R> {
        let list = value.as_array().map_or(&[][..], Vec::as_slice);
        list.iter().filter_map(read).collect()
    };
    let list = |name: &str| object.get(name).and_then(Value::as_array);
    let knots = |name: &str| object.get(name).map(numbers).unwrap_or_default();

    let rows = list("points").map_or(&[][..], Vec::as_slice);
    let width = |row: &Value| row.as_array().map_or(0, Vec::len);
    let counts = [rows.len(), rows.first().map_or(0, width)];
    // A net that is not rectangular is handed on empty, so that it is refused in its turn.
    let points: Vec<Vector<R>> = if rows.iter().all(|r| width(r) == counts[1]) {
        let points = rows.iter().filter_map(Value::as_array).flatten();
        let read = |p: &Value| super::super::request::read_vector(p);
        points.filter_map(read).collect()
    } else {
        Vec::new()
    };
    let weights: Vec<R> = match list("weights") {
        None => Vec::new(),
        Some(rows) if rows.len() == counts[0] && rows.iter().all(|r| width(r) == counts[1]) => {
            rows.iter().flat_map(numbers).collect()
        }
        Some(_) => vec![R::ONE; points.len() + 1],
    };
    let (knots_u, knots_v) = (knots("knots_u"), knots("knots_v"));
    Part::new(
        [degree("degree_u"), degree("degree_v")],
        counts,
        [&knots_u, &knots_v],
        &points,
        &weights,
    )
    .map(Box::new)
    .map_err(fault_of_surface)
}

/// The job of a request, checked whole; its numbers are rounded to `R`.
pub fn job<R: Real>(request: &Request) -> Result<Job, Fault> {
    let empty = Map::new();
    let (preset, object) = match request.value("job") {
        Some(Value::String(preset)) => (preset.as_str(), &empty),
        Some(Value::Object(object)) => {
            let preset = object.get("preset").and_then(Value::as_str);
            (preset.unwrap_or("a"), object)
        }
        _ => ("a", &empty),
    };
    let mut job = if preset == "b" {
        Job::soft()
    } else {
        Job::hard()
    };
    let given = Given { object };

    // Materials and parameters are checked together below, materials first; here only what has no number of its own.
    let number = |name: &str, slot: &mut f64| {
        if let Some(x) = given.value(name).and_then(read::<R>) {
            *slot = x.to_f64();
        }
    };
    let material = |e: &str, nu: &str, slot: &mut Material<f64>| {
        number(e, &mut slot.modulus);
        number(nu, &mut slot.poisson);
    };
    let process = &mut job.process;
    material("e1", "nu1", &mut process.wheel_material);
    material("e2", "nu2", &mut process.part_material);
    process::effective_modulus(process.wheel_material, process.part_material)
        .map_err(fault_of_grinding)?;
    given.refuse_unknown_keys()?;
    process.wheel = Wheel {
        rim: given.radius::<R>("r_rim", process.wheel.rim),
        crown: given.radius::<R>("r_crown", process.wheel.crown),
    };
    number("force", &mut process.force);
    number("k", &mut process.k);
    number("rpm", &mut process.rpm);
    number("feed", &mut process.feed);
    number("scallop", &mut process.scallop);
    number("margin", &mut process.margin);
    match given.integer("sense") {
        None => {}
        Some(0) => process.sense = Sense::Neglected,
        Some(1) => process.sense = Sense::Against,
        Some(-1) => process.sense = Sense::With,
        Some(_) => return Err(bad("sense", "must be -1, 0 or 1")),
    }
    process.model = given.choice("model", process.model, &MODELS)?;
    let mut depth = 0.08;
    number("depth", &mut depth);
    if !(depth > 0.0 && depth.is_finite()) {
        return Err(bad("depth", "must be finite and greater than 0 mm"));
    }
    process.depth = given.choice(
        "depth_mode",
        process.depth,
        &[
            ("constant_feed", Depth::ConstantFeed),
            ("constant_depth", Depth::Constant(depth)),
        ],
    )?;
    number("eps", &mut job.eps);
    number("e_lat", &mut job.e_lat);
    number("e_gap", &mut job.e_gap);
    number("l_max", &mut job.l_max);
    if let Some(turn) = given.value("turn").and_then(read::<R>) {
        job.turn = turn.to_radians().to_f64();
    }
    number("seed", &mut job.seed);
    if let Some(nodes) = given.integer("nodes") {
        job.nodes = usize::try_from(nodes).unwrap_or(0);
    }
    let rows = given
        .integer("rows")
        .map(|n| usize::try_from(n).unwrap_or(0));
    if rows.is_some_and(|n| !(2..=20_000).contains(&n)) {
        return Err(bad("rows", "must be 2 to 20000"));
    }
    job.strategy = given.choice(
        "strategy",
        job.strategy,
        &[
            ("adaptive", Strategy::Adaptive),
            ("rowmin", Strategy::RowMin),
            // Without a number it is refused as 0 rows.
            ("iso", Strategy::Iso(rows.unwrap_or(0))),
        ],
    )?;
    job.step_mode = given.choice(
        "step_mode",
        job.step_mode,
        &[("common", StepMode::Common), ("row", StepMode::Row)],
    )?;
    job.check().map_err(fault_of_plan)?;
    Ok(job)
}

pub const MODELS: [(&str, Model); 2] =
    [("envelope", Model::Envelope), ("additive", Model::Additive)];

/// The members that a job gives.
struct Given<'a> {
    object: &'a Map<String, Value>,
}

impl Given<'_> {
    fn value(&self, name: &str) -> Option<&Value> {
        self.object.get(name).filter(|v| !v.is_null())
    }

    fn integer(&self, name: &str) -> Option<i128> {
        self.value(name).and_then(schema::integer_of)
    }

    /// `null` is a flat wheel; left out, the preset's radius stands.
    fn radius<R: Real>(&self, name: &str, preset: Option<f64>) -> Option<f64> {
        match self.object.get(name) {
            None => preset,
            Some(value) => read::<R>(value).map(R::to_f64),
        }
    }

    fn choice<T: Copy>(&self, name: &str, preset: T, words: &[(&str, T)]) -> Result<T, Fault> {
        let Some(word) = self.value(name).and_then(Value::as_str) else {
            return Ok(preset);
        };
        let found = words.iter().find(|(w, _)| *w == word);
        found.map(|(_, value)| *value).ok_or_else(|| {
            let known: Vec<_> = words.iter().map(|(w, _)| *w).collect();
            bad(name, &format!("must be one of: {}", known.join(", ")))
        })
    }

    fn refuse_unknown_keys(&self) -> Result<(), Fault> {
        let Kind::Open(_, fields) = super::JOB.kind else {
            return Ok(());
        };
        let unknown = |key: &&String| fields.iter().all(|f| f.name != key.as_str());
        match self.object.keys().find(unknown) {
            None => Ok(()),
            Some(key) => {
                let known: Vec<_> = fields.iter().map(|f| f.name).collect();
                Err(bad(
                    key,
                    &format!("is no member of a job; they are: {}", known.join(", ")),
                ))
            }
        }
    }
}

/// The process in `R`.
pub fn process<R: Real>(job: &Job) -> process::Job<R> {
    let p = &job.process;
    let material = |m: Material<f64>| Material {
        modulus: R::of(m.modulus),
        poisson: R::of(m.poisson),
    };
    process::Job {
        wheel: Wheel {
            rim: p.wheel.rim.map(R::of),
            crown: p.wheel.crown.map(R::of),
        },
        wheel_material: material(p.wheel_material),
        part_material: material(p.part_material),
        force: R::of(p.force),
        k: R::of(p.k),
        rpm: R::of(p.rpm),
        feed: R::of(p.feed),
        sense: p.sense,
        scallop: R::of(p.scallop),
        margin: R::of(p.margin),
        model: p.model,
        depth: match p.depth {
            Depth::ConstantFeed => Depth::ConstantFeed,
            Depth::Constant(depth) => Depth::Constant(R::of(depth)),
        },
    }
}
