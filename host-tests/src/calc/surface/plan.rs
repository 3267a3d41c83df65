//! `surface.plan` and `surface.residual`: whole surfaces, on the host in f64.

use super::super::answer::number;
use super::super::machine::read_pose;
use super::super::request::{read, read_vector};
use super::super::{Answer, Fault, Request, arm};
use super::given::{bad, fault_of_plan, job, part};
use crate::surface::{self, Job, PathRow, Plan, Residual, Segment, joints};
use hexstep::geometry::{Pose, Vector};
use hexstep::machines::arm::Arm;
use serde_json::{Value, json};

fn stations(request: &Request) -> Result<usize, Fault> {
    let stations = usize::try_from(request.integer("stations")).unwrap_or(0);
    if (1..=10_000).contains(&stations) {
        Ok(stations)
    } else {
        Err(bad("stations", "must be 1 to 10000"))
    }
}

pub fn plan(request: &Request) -> Result<Answer, Fault> {
    let part = part::<f64>(request)?;
    let job = job::<f64>(request)?;
    let stations = stations(request)?;
    let cell = Cell::read(request)?;
    let plan = Plan::new(&part, &job).map_err(fault_of_plan)?;
    let residual = match request.flag("measure") {
        true => {
            let rows: Vec<PathRow> = plan.segments.iter().map(PathRow::from).collect();
            let residual = surface::residual(&part, &job, &rows, stations);
            Some(members(&residual.map_err(fault_of_plan)?))
        }
        false => None,
    };
    let answer = Answer::new()
        .put("rows", &plan.rows)
        .put("full_rows", &plan.full_rows)
        .put("segments", &plan.segments.len())
        .put("points", &plan.points())
        .put("touching", &plan.touching)
        .number("path_length", plan.path_length())
        .number("largest_step", plan.largest_step())
        .value("residual", residual.map_or(Value::Null, Value::Object));
    if !request.flag("path") {
        return Ok(answer);
    }
    let mut path: Vec<Value> = plan.segments.iter().map(segment_value).collect();
    if let Some(cell) = cell {
        cell.add_joints(&part, &job, &plan, &mut path)?;
    }
    Ok(answer.put("path", &path))
}

fn segment_value(segment: &Segment) -> Value {
    let vectors = |of: &dyn Fn(&surface::Point) -> Vector<f64>| -> Vec<[Value; 3]> {
        let points = segment.points.iter();
        points.map(|p| of(p).to_array().map(number)).collect()
    };
    let uv: Vec<_> = segment.points.iter().map(|p| p.uv.map(number)).collect();
    json!({
        "row": segment.row,
        "uv": uv,
        "xyz": vectors(&|p| p.s),
        "normal": vectors(&|p| p.normal),
    })
}

/// The arm and where the part stands before it.
struct Cell {
    arm: Arm<f64>,
    work: Pose<f64>,
    tool: f64,
}

impl Cell {
    /// Checked whether joints are asked for or not.
    fn read(request: &Request) -> Result<Option<Self>, Fault> {
        let arm = arm::closed_form::<f64>(request)?;
        let tool = request.number::<f64>("tool");
        if !tool.is_finite() {
            return Err(bad("tool", "must be finite [mm]"));
        }
        let rows = request.value("frame").unwrap_or(&Value::Null);
        let work = read_pose::<f64>(rows).map_err(|_| {
            let detail = "frame must be [[R, p], [0 0 0 1]], finite, with a rotation R (1e-6)";
            Fault::new("BadPose", detail).field("frame")
        })?;
        if !request.flag("joints") {
            return Ok(None);
        }
        if !request.flag("path") {
            return Err(bad("joints", "needs path: true"));
        }
        Ok(Some(Self { arm, work, tool }))
    }

    fn add_joints(
        &self,
        part: &surface::Part,
        job: &Job,
        plan: &Plan,
        path: &mut [Value],
    ) -> Result<(), Fault> {
        let mut previous = None;
        for (index, (segment, value)) in plan.segments.iter().zip(path).enumerate() {
            let poses = surface::poses(part, job, segment, &self.work, self.tool, false)
                .map_err(fault_of_plan)?;
            let flanges: Vec<_> = poses.iter().map(|p| p.flange).collect();
            let stretch = joints::serve(&self.arm, &flanges, previous).map_err(|refused| {
                let fault = Fault::new(refused.name(), refused.to_string());
                let fault = fault.with("index", index).with("row", segment.row);
                let reasons = refused.reasons().into_iter().map(
                    |(branch, point, why)| json!({"branch": branch, "index": point, "reason": why}),
                );
                fault.with("branches", reasons.collect::<Vec<_>>())
            })?;
            previous = stretch.joints.last().copied();
            let q: Vec<_> = stretch
                .joints
                .iter()
                .map(|q| q.0.map(|x| number(x.to_degrees())))
                .collect();
            value["branch"] = json!(stretch.branch);
            value["q"] = json!(q);
            value["margin"] = number(stretch.margin.to_degrees());
        }
        Ok(())
    }
}

pub fn residual(request: &Request) -> Result<Answer, Fault> {
    let rows = path(request)?;
    let part = part::<f64>(request)?;
    let job = job::<f64>(request)?;
    let stations = stations(request)?;
    if let Some(index) = rows.iter().position(|row| !is_finite(row)) {
        let fault = bad("path", "must hold finite numbers");
        return Err(fault.with("index", index));
    }
    let residual = surface::residual(&part, &job, &rows, stations).map_err(fault_of_plan)?;
    let members = members(&residual).into_iter();
    Ok(members.fold(Answer::new(), |answer, (name, value)| {
        answer.value(&name, value)
    }))
}

fn is_finite(row: &PathRow) -> bool {
    match row {
        PathRow::Uv(uv) => uv.iter().flatten().all(|x| x.is_finite()),
        PathRow::Xyz(xyz) => xyz.iter().all(|p| p.is_finite()),
    }
}

fn members(r: &Residual) -> serde_json::Map<String, Value> {
    let valleys = r.peak_to_valley;
    let value = json!({
        "samples": r.samples,
        "min": r.min,
        "max": r.max,
        "mean": r.mean,
        "std": r.std,
        "ratio": r.ratio(),
        "p01": r.p01,
        "p99": r.p99,
        "at_min": r.at_min,
        "at_max": r.at_max,
        "edge_max": r.edge_max,
        "depth_min": r.depth_min,
        "depth_max": r.depth_max,
        "peak_to_valley": {"min": valleys[0], "max": valleys[1]},
    });
    match value {
        Value::Object(members) => members,
        _ => serde_json::Map::new(),
    }
}

/// The rows of a request. What `surface.plan` answers is taken as well: of its members only the points count.
fn path(request: &Request) -> Result<Vec<PathRow>, Fault> {
    let wrong = || {
        let detail =
            "path must be an array of rows, each [[u, v], ...], {\"uv\": ...} or {\"xyz\": ...}";
        Fault::new("WrongType", detail).field("path")
    };
    let Some(Value::Array(rows)) = request.value("path") else {
        return Err(wrong());
    };
    let row = |value: &Value| -> Result<PathRow, Fault> {
        match value {
            Value::Array(points) => uv(points).ok_or_else(wrong),
            Value::Object(object) => {
                const OTHERS: [&str; 7] = ["uv", "xyz", "row", "normal", "branch", "q", "margin"];
                if let Some(key) = object.keys().find(|k| !OTHERS.contains(&k.as_str())) {
                    let detail = format!("a row has no member {key}; give uv or xyz");
                    return Err(Fault::new("UnknownField", detail).field(key));
                }
                match (object.get("uv"), object.get("xyz")) {
                    (Some(Value::Array(points)), _) => uv(points).ok_or_else(wrong),
                    (None, Some(Value::Array(points))) => {
                        let points: Option<Vec<_>> = points.iter().map(read_vector).collect();
                        points.map(PathRow::Xyz).ok_or_else(wrong)
                    }
                    _ => Err(wrong()),
                }
            }
            _ => Err(wrong()),
        }
    };
    let index = |(i, value)| row(value).map_err(|fault| fault.with("index", i));
    rows.iter().enumerate().map(index).collect()
}

fn uv(points: &[Value]) -> Option<PathRow> {
    let pair = |value: &Value| match value.as_array()?.as_slice() {
        [u, v] => Some([read(u)?, read(v)?]),
        _ => None,
    };
    points
        .iter()
        .map(pair)
        .collect::<Option<_>>()
        .map(PathRow::Uv)
}
