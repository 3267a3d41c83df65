//! `[path]` of a pair -> points and normals of the rows: a part of the panel's rows on a surface, or as they are given.

use super::super::points::MOST_POINTS;
use super::super::reader::{Kind, Table};
use super::super::{JobError, Places};
use super::PairRow;
use crate::mirror::{Simulation, Surface};
use hexstep::geometry::Vector;
use hexstep::kinematics::ClPoint;

/// The rows that are milled.
pub(super) fn read(
    path: &Table<'_>,
    simulation: &Simulation,
    places: &Places,
) -> Result<Vec<PairRow>, JobError> {
    let by_points = path.has("points") || path.has("normals");
    if by_points {
        for key in ["rows", "from", "to", "radius", "wave"] {
            if path.has(key) {
                let detail = format!("points and normals are the row; remove {key}");
                return Err(places.refuse(&format!("path.{key}"), "Contradictory", detail));
            }
        }
        return Ok(vec![given_row(path, places)?]);
    }
    let panel = &simulation.panel;
    let surface = read_surface(path, panel.start, places)?;
    let last = panel.rows.len().saturating_sub(1);
    let rows = match path.has("rows") {
        true => path.list("rows")?,
        false => vec![(last / 2) as f64],
    };
    let along = Kind::between(-panel.start, panel.start, "mm, on the row");
    let from = path.number_or("from", -panel.start, along)?;
    let to = path.number_or("to", panel.start, along)?;
    if from >= to {
        let detail = format!("expected from < to, found {from} and {to}");
        return Err(places.refuse("path.to", "Contradictory", detail));
    }
    if rows.is_empty() {
        let detail = "no row; remove rows for the middle one".into();
        return Err(places.refuse("path.rows", "OutOfRange", detail));
    }
    let mut made = Vec::with_capacity(rows.len());
    for (index, number) in rows.iter().enumerate() {
        let y = (number.fract() == 0.0 && *number >= 0.0)
            .then(|| panel.rows.get(*number as usize))
            .flatten();
        let Some(y) = y else {
            let detail =
                format!("rows of the panel are counted from 0 to {last} here, found {number}");
            let key = format!("path.rows[{index}]");
            return Err(places.refuse(&key, "OutOfRange", detail));
        };
        let parts = ((to - from) / surface.spacing()).ceil().max(1.0);
        let points: Option<Vec<_>> = (0..=parts as u32)
            .map(|k| surface.at(from + (to - from) * f64::from(k) / parts, *y))
            .collect();
        let Some(points) = points.filter(|points| points.len() <= MOST_POINTS) else {
            let detail = format!("the row takes more than {MOST_POINTS} points; mill less of it");
            return Err(places.refuse("path.to", "OutOfRange", detail));
        };
        made.push(PairRow {
            name: format!("row y = {y} mm"),
            points,
        });
    }
    Ok(made)
}

fn read_surface(path: &Table<'_>, start: f64, places: &Places) -> Result<Surface, JobError> {
    if path.has("wave") {
        if path.has("radius") {
            let detail = "radius and wave exclude each other; keep one of them".into();
            return Err(places.refuse("path.wave", "Contradictory", detail));
        }
        let [height, length] = path.numbers("wave", Kind::positive(1e5, "mm"))?;
        if height > 0.1 * length {
            let detail = format!("{height} mm over {length} mm is steeper than any panel");
            return Err(places.refuse("path.wave", "OutOfRange", detail));
        }
        return Ok(Surface::Wave { height, length });
    }
    let radius = path.number_or("radius", 4000.0, Kind::positive(1e6, "mm"))?;
    if radius < 2.0 * start {
        let detail = format!("a row of {start} mm each way would turn down by more than 30 deg");
        return Err(places.refuse("path.radius", "OutOfRange", detail));
    }
    Ok(Surface::Cylinder { radius })
}

/// `points` and `normals` of the surface, as measured.
fn given_row(path: &Table<'_>, places: &Places) -> Result<PairRow, JobError> {
    let (points, normals) = (path.lists("points")?, path.lists("normals")?);
    if points.len() != normals.len() || !(2..=MOST_POINTS).contains(&points.len()) {
        let detail = format!(
            "expected 2 to {MOST_POINTS} points and a normal for each, found {} and {}",
            points.len(),
            normals.len()
        );
        return Err(places.refuse("path.normals", "OutOfRange", detail));
    }
    let vector = |key: &str, index: usize, list: &[f64]| {
        let refuse = |name, detail| {
            let key = format!("path.{key}[{index}]");
            Err(places.refuse(&key, name, detail))
        };
        let [x, y, z] = list else {
            let detail = format!("expected three numbers, found {}", list.len());
            return refuse("WrongType", detail);
        };
        match [x, y, z].iter().find(|x| !x.is_finite()) {
            Some(x) => refuse("NonFinite", format!("expected finite numbers, found {x}")),
            None if [x, y, z].iter().any(|x| x.abs() > 1e5) => {
                refuse("OutOfRange", "a coordinate is beyond 1e5 mm".into())
            }
            None => Ok(Vector::new(*x, *y, *z)),
        }
    };
    let mut row = PairRow {
        name: "the given points".into(),
        points: Vec::with_capacity(points.len()),
    };
    for (index, (p, n)) in points.iter().zip(&normals).enumerate() {
        let (p, n) = (vector("points", index, p)?, vector("normals", index, n)?);
        let Some(at) = ClPoint::new(p, n) else {
            let key = format!("path.normals[{index}]");
            let detail = "it is shorter than 1e-6; give a direction from support to mill".into();
            return Err(places.refuse(&key, "BadNormal", detail));
        };
        row.points.push(at);
    }
    Ok(row)
}
