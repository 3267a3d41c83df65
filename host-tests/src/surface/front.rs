//! Rows as graphs v = f(u): each follows from the one before by the pitch that its gap needs.
//!
//! ```text
//!   v |  ---.___.---'''---   f_next = f +- dv(f*)        dv = d sqrt((E + 2 F f' + G f'^2)/W)
//!     |  - - - - - - - - -   f*     = f +- dv(f)/2       d the pitch for motion towards (1, f')
//!     |  ----.__.---''----   f
//!     +------------------ u
//! ```
//!
//! The march starts in the middle and runs both ways; a start on an edge would travel twice as far, and fronts focus.
//! A node stays while the cusp before it lies on the part, plus 0.3 of the local step; a row with no cusp on the part is not
//! begun. So the edge strip is nowhere more than half a pitch from a row, and no last row need be squeezed in.

use super::job::MAX_ROWS;
use super::spline::Spline;
use super::{Job, Part, Place, Strategy, SurfaceError};
use hexstep::cycles::surface_grinding::{Grinding, GrindingError};
use hexstep::geometry::nurbs::{NurbsError, Shape};

/// tan 60 deg: a front that leans more is about to fold.
const STEEPEST: f64 = 1.732_050_807_568_877_2;
/// How far the cusp may lie beyond the edge, in local steps.
const OVERRUN: f64 = 0.3;

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Counted from the seed; from 0 where there is none.
    pub number: i64,
    pub curve: Spline,
    /// The nodes that are ground.
    pub kept: Vec<bool>,
    /// The stretches of u that are ground, from clip to clip.
    pub spans: Vec<[f64; 2]>,
}

/// All rows of a part in the order of v.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    pub rows: Vec<Row>,
    /// Steps that were held to touching stripes.
    pub touching: usize,
}

impl Row {
    pub fn is_full(&self) -> bool {
        self.kept.iter().all(|k| *k)
    }

    fn full(number: i64, curve: Spline, domain: [f64; 2]) -> Self {
        Self {
            number,
            kept: vec![true; curve.nodes()],
            curve,
            spans: vec![domain],
        }
    }
}

impl Rows {
    /// The rows of a checked job.
    pub fn plan(part: &Part, job: &Job, grinding: &Grinding<f64>) -> Result<Self, SurfaceError> {
        let front = Front {
            part,
            grinding,
            domain: part.domain(),
            nodes: job.nodes,
            straight: job.strategy == Strategy::RowMin,
        };
        if let Strategy::Iso(count) = job.strategy {
            return front.iso(count);
        }
        let [lo, hi] = front.domain[1];
        let seed = front.curve(vec![lo + job.seed * (hi - lo); job.nodes]);
        let mut touching = 0;
        let down = front.march(&seed, -1, 0, &mut touching)?;
        let up = front.march(&seed, 1, down.len(), &mut touching)?;
        let mut rows: Vec<Row> = down.into_iter().rev().collect();
        rows.push(Row::full(0, seed, front.domain[0]));
        rows.extend(up);
        Ok(Self { rows, touching })
    }

    pub fn full(&self) -> usize {
        self.rows.iter().filter(|r| r.is_full()).count()
    }
}

struct Front<'a> {
    part: &'a Part,
    grinding: &'a Grinding<f64>,
    domain: [[f64; 2]; 2],
    nodes: usize,
    /// All nodes move by the smallest step.
    straight: bool,
}

impl Front<'_> {
    fn curve(&self, values: Vec<f64>) -> Spline {
        let [start, end] = self.domain[0];
        Spline::new(start, end, values)
    }

    /// Rows from the seed, not itself, towards growing (`side` = 1) or falling v; `before` rows exist already.
    fn march(
        &self,
        seed: &Spline,
        side: i64,
        before: usize,
        touching: &mut usize,
    ) -> Result<Vec<Row>, SurfaceError> {
        let sign = side as f64;
        let edge = if side > 0 {
            self.domain[1][1]
        } else {
            self.domain[1][0]
        };
        let mut rows: Vec<Row> = Vec::new();
        let mut curve = seed.clone();
        let mut kept = vec![true; self.nodes];
        for number in 1.. {
            let here = |e: SurfaceError| e.in_row(side * (number - 1));
            let moved = |from: &Spline, steps: &[f64], share: f64| {
                let values = from.values().iter().zip(steps);
                values.map(|(f, dv)| f + sign * share * dv).collect()
            };
            let first = self.steps(&curve, Some(&kept), &mut 0).map_err(here)?;
            let middle = self.curve(moved(&curve, &first, 0.5));
            let steps = self.steps(&middle, None, touching).map_err(here)?;
            let next = self.curve(moved(&curve, &steps, 1.0));

            // How far the cusp may still go, in the direction of the march.
            let room: Vec<f64> = (0..self.nodes)
                .map(|i| {
                    let (f, step) = (curve.values()[i], steps[i]);
                    sign * (edge - f) - (0.5 - OVERRUN) * step
                })
                .collect();
            // Without a cusp on the part the edge strip is narrower than half a pitch everywhere: nothing is missing.
            let inside = |(r, step): (&f64, &f64)| *r >= OVERRUN * step;
            if !room.iter().zip(&steps).any(inside) {
                break;
            }
            if before + rows.len() + 2 > MAX_ROWS {
                return Err(SurfaceError::TooManyRows);
            }
            kept = room.iter().map(|r| *r >= 0.0).collect();
            rows.push(Row {
                number: side * number,
                spans: spans(&next, &room),
                kept: kept.clone(),
                curve: next.clone(),
            });
            curve = next;
        }
        Ok(rows)
    }

    /// dv at every node of a curve. Where `kept` is given, its nodes must not lean too much.
    fn steps(
        &self,
        curve: &Spline,
        kept: Option<&[bool]>,
        touching: &mut usize,
    ) -> Result<Vec<f64>, SurfaceError> {
        let mut steps = Vec::with_capacity(self.nodes);
        for i in 0..self.nodes {
            let (u, local) = (curve.node(i), curve.at_node(i));
            let place = Place::at(u, local.value);
            let at = |error| SurfaceError::Grinding(error, place);
            let shape = self
                .part
                .tool_shape(u, local.value)
                .map_err(|e| at(e.into()))?;
            let slope = if self.straight { 0.0 } else { local.slope };
            let [e, f, g] = shape.first;
            if kept.is_some_and(|k| k[i]) && slope * slope * g > STEEPEST * STEEPEST * e {
                return Err(SurfaceError::FrontFold(place));
            }
            let section = shape
                .along(1.0, slope)
                .ok_or(at(NurbsError::DegenerateNormal.into()))?;
            let pitch = self.grinding.pitch_on(&section).map_err(at)?;
            *touching += usize::from(pitch.touching);
            let stretch = (e + 2.0 * f * slope + g * slope * slope).sqrt() / shape.area;
            steps.push(pitch.d * stretch);
        }
        if self.straight {
            let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
            steps.fill(least);
        }
        Ok(steps)
    }

    /// Straight rows at equal spacing, each half a spacing from the edge.
    fn iso(&self, count: usize) -> Result<Rows, SurfaceError> {
        let [lo, hi] = self.domain[1];
        let row = |i: usize| {
            let v = lo + (i as f64 + 0.5) / count as f64 * (hi - lo);
            let curve = self.curve(vec![v; self.nodes]);
            // Spacing asks nothing of the contact here, but there must be one.
            for i in 0..self.nodes {
                let u = curve.node(i);
                self.contact(u, v)?;
            }
            Ok(Row::full(i as i64, curve, self.domain[0]))
        };
        let rows: Result<_, SurfaceError> = (0..count).map(row).collect();
        Ok(Rows {
            rows: rows?,
            touching: 0,
        })
    }

    fn contact(&self, u: f64, v: f64) -> Result<(), SurfaceError> {
        let check = |shape: Shape<f64>| -> Result<(), GrindingError<f64>> {
            let section = shape.along(1.0, 0.0).ok_or(NurbsError::DegenerateNormal)?;
            self.grinding.stripe_on(&section).map(|_| ())
        };
        let shape = self.part.tool_shape(u, v).map_err(GrindingError::from);
        shape.and_then(check).map_err(|e| SurfaceError::at(e, u, v))
    }
}

/// The stretches of u where there is room, clipped where it ends between two nodes.
fn spans(curve: &Spline, room: &[f64]) -> Vec<[f64; 2]> {
    let clip = |i: usize| {
        let share = room[i] / (room[i] - room[i + 1]);
        curve.node(i) + share * (curve.node(i + 1) - curve.node(i))
    };
    let mut spans = Vec::new();
    let mut start = None;
    for i in 0..room.len() {
        let kept = room[i] >= 0.0;
        if kept && start.is_none() {
            start = Some(if i == 0 { curve.node(0) } else { clip(i - 1) });
        }
        if let Some(from) = start {
            if !kept {
                spans.push([from, clip(i - 1)]);
                start = None;
            } else if i + 1 == room.len() {
                spans.push([from, curve.node(i)]);
            }
        }
    }
    spans
}
