//! `mirror.trim`, `mirror.stream`, `mirror.simulate`: trimming a pair to a measured deformation.
//!
//! Source: specification of mirror milling, sections 5, 6 and 10.

use super::{PAIR, padded, pair_fault, sides};
use crate::calc::machine::{Machine, fixed, non_finite};
use crate::calc::request::read;
use crate::calc::schema::{NUMBERS, VECTOR};
use crate::calc::{Answer, Fault, Field, Function, Kind, Length, Request};
use crate::mirror::{Panel, Simulation, SimulationError, Walls, mean, sample_sigma};
use hexstep::cycles::mirror_trim::{BadLimit, Flags, Parameters, Trimmer};
use hexstep::joints::Joints;
use hexstep::machines::two_sided::{Pair, PairError};
use hexstep::math::Real;
use serde_json::{Value, json};

const READING: Kind = Kind::OrNull(&Kind::Number);
const POSITIVE: &str = "> 0";

pub const FUNCTIONS: &[Function] = &[
    Function {
        name: "mirror.trim",
        summary: "What every joint of both sides moves by for a panel shifted along its normal.",
        fields: &[&[
            PAIR,
            Field::new("p", VECTOR, "mm", "support point P"),
            Field::new("n", VECTOR, "", "normal, from support to mill"),
            Field::number("d", "mm", "wall, > 0"),
            Field::number("delta", "mm", "shift along n"),
            Field::new("n_new", VECTOR, "", "n and the direct form if left out").optional(),
            Field::new("previous1", NUMBERS, "mm or deg", "0 if left out").optional(),
            Field::new("previous2", NUMBERS, "mm or deg", "0 if left out").optional(),
        ]],
        f64: trim::<f64>,
        f32: Some(trim::<f32>),
    },
    Function {
        name: "mirror.stream",
        summary: "The trimmer's offset and flags, tick by tick.",
        fields: &[&[
            Field::number("dt", "s", POSITIVE),
            Field::number("tau", "s", POSITIVE),
            Field::number("amount", "mm", POSITIVE),
            Field::number("rate", "mm/s", POSITIVE),
            Field::number("gate", "mm", POSITIVE),
            Field::new("miss_max", Kind::Integer, "ticks", ">= 0"),
            Field::new(
                "m",
                Kind::List(&READING, Length::Any),
                "mm",
                "a reading a tick; null or not finite: a miss",
            ),
        ]],
        f64: stream::<f64>,
        f32: Some(stream::<f32>),
    },
    Function {
        name: "mirror.simulate",
        summary: "Walls of a panel that gives way, with and without trimming; as milled and as gauged.",
        fields: &[&[
            Field::new("seed", Kind::Integer, "", "0 .. 2^64").or("1"),
            Field::number("d", "mm", POSITIVE).or("1.5"),
            Field::number("force", "N", "").or("100"),
            Field::number("peak", "mm", "shift of the middle at 100 N").or("0.15"),
            Field::number("noise", "mm", "of the sensor").or("0.03"),
            Field::number("gauge", "mm", "noise of the gauge").or("0.01"),
            Field::number("feed", "mm/s", POSITIVE).or("5"),
            Field::number("dt", "s", POSITIVE).or("0.01"),
            Field::number("tau", "s", POSITIVE).or("0.2"),
            Field::number("amount", "mm", POSITIVE).or("0.3"),
            Field::number("rate", "mm/s", POSITIVE).or("0.5"),
        ]],
        f64: simulate,
        f32: None,
    },
];

fn trim<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let (mill, support) = sides::<R>(request)?;
    let refused = |error| pair_fault(&mill, &support, error);
    let pair = Pair::new(padded(&mill)?, padded(&support)?).map_err(refused)?;
    let before1 = mill.read_joints(request.value("previous1"), "previous1")?;
    let before2 = support.read_joints(request.value("previous2"), "previous2")?;
    let (p, n, d) = (
        request.vector::<R>("p"),
        request.vector::<R>("n"),
        request.number::<R>("d"),
    );
    if !(d.is_finite() && d > R::ZERO) {
        return Err(refused(PairError::BadWall));
    }
    let delta = request.number::<R>("delta");
    if !delta.is_finite() {
        return Err(non_finite("delta"));
    }
    let turned = request.maybe_vector::<R>("n_new");
    for (field, v) in [("p", p), ("n", n), ("n_new", turned.unwrap_or(n))] {
        if !v.is_finite() {
            return Err(non_finite(field));
        }
    }
    let of_turned = |fault: Fault| match (&turned, fault.error.as_str()) {
        (Some(_), "BadNormal") => {
            Fault::new("BadNormal", "n_new must be longer than 1e-6").field("n_new")
        }
        _ => fault,
    };
    let old = pair
        .solve(p, n, d, (&fixed(&before1), &fixed(&before2)))
        .map_err(refused)?;
    let (q1, q2) = (old.mill.q, old.support.q);
    let (trim1, trim2) = match turned {
        None => {
            let trim = pair.trim(n, delta, (&q1, &q2)).map_err(refused)?;
            (trim.mill, trim.support)
        }
        Some(turned) => {
            let new = pair
                .retrim(p, n, d, (delta, turned), (&q1, &q2))
                .map_err(|error| of_turned(refused(error)))?;
            (minus(&new.mill.q, &q1), minus(&new.support.q, &q2))
        }
    };
    let (new1, new2) = (plus(&q1, &trim1), plus(&q2, &trim2));
    if !(new1.is_finite() && new2.is_finite()) {
        return Err(too_large());
    }
    let joints = |machine: &Machine<R>, q: &[R]| machine.joint_values(q);
    Ok(Answer::new()
        .put("q1", &joints(&mill, &q1.0))
        .put("q2", &joints(&support, &q2.0))
        .put("q1_new", &joints(&mill, &new1.0))
        .put("q2_new", &joints(&support, &new2.0))
        .put("trim1", &joints(&mill, &trim1.0))
        .put("trim2", &joints(&support, &trim2.0)))
}

fn too_large() -> Fault {
    Fault::new(
        "OutOfRange",
        "the figures are too large; scale the request down",
    )
}

fn plus<const N: usize, R: Real>(a: &Joints<N, R>, b: &Joints<N, R>) -> Joints<N, R> {
    Joints(std::array::from_fn(|i| a[i] + b[i]))
}

fn minus<const N: usize, R: Real>(a: &Joints<N, R>, b: &Joints<N, R>) -> Joints<N, R> {
    Joints(std::array::from_fn(|i| a[i] - b[i]))
}

fn bad_limit(field: &str) -> Fault {
    let detail = format!("{field} must be finite and greater than 0");
    Fault::new("BadLimit", detail).field(field)
}

fn stream<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let misses = request.integer("miss_max");
    let mut trimmer = Trimmer::new(&Parameters {
        dt: request.number::<R>("dt"),
        tau: request.number("tau"),
        amount: request.number("amount"),
        rate: request.number("rate"),
        gate: request.number("gate"),
        // More than there can be ticks is as good as any.
        miss_max: misses.clamp(0, u32::MAX.into()) as u32,
    })
    .map_err(|BadLimit(name)| bad_limit(name))?;
    if misses < 0 {
        let detail = "miss_max must be a whole number of ticks, at least 0";
        return Err(Fault::new("BadLimit", detail).field("miss_max"));
    }
    let readings = request.list("m").iter().map(read::<R>);
    let (out, flags): (Vec<R>, Vec<Flags>) = readings.map(|m| trimmer.tick(m)).unzip();
    let flags: Vec<Vec<&str>> = flags.iter().map(|f| f.names().collect()).collect();
    Ok(Answer::new()
        .numbers("out", out)
        .put("flags", &flags)
        .number("filtered", trimmer.filtered())
        .put("fault", &trimmer.is_faulty()))
}

fn simulate(request: &Request) -> Result<Answer, Fault> {
    let seed = request.integer("seed");
    let Ok(seed) = u64::try_from(seed) else {
        let detail = "seed must be a whole number from 0 to 2^64 - 1";
        return Err(Fault::new("BadLimit", detail).field("seed"));
    };
    let simulation = Simulation {
        seed,
        d: request.number("d"),
        force: request.number("force"),
        noise: request.number("noise"),
        gauge: request.number("gauge"),
        feed: request.number("feed"),
        dt: request.number("dt"),
        tau: request.number("tau"),
        amount: request.number("amount"),
        rate: request.number("rate"),
        panel: Panel {
            peak: request.number("peak"),
            ..Panel::default()
        },
        ..Simulation::default()
    };
    let outcome = simulation.run().map_err(|error| match error {
        SimulationError::BadWall => {
            Fault::new("BadWall", "d must be a finite wall above 0 mm").field("d")
        }
        SimulationError::BadLimit(name) => bad_limit(name),
        SimulationError::NonFinite(name) | SimulationError::BadPanel(name) => non_finite(name),
        SimulationError::BadRow => Fault::new(
            "BadLimit",
            "a row of 900 mm must take from 100 to 10 million ticks; change feed or dt",
        )
        .field("dt"),
    })?;
    if ![&outcome.untrimmed, &outcome.trimmed].into_iter().all(fits) {
        return Err(too_large());
    }
    Ok(Answer::new()
        .value("untrimmed", walls(&outcome.untrimmed))
        .value("trimmed", walls(&outcome.trimmed)))
}

fn fits(walls: &Walls) -> bool {
    let spread = [sample_sigma(&walls.points), sample_sigma(&walls.gauged)];
    walls.rows.sigma().is_finite() && spread.iter().all(|x| x.is_finite())
}

fn walls(walls: &Walls) -> Value {
    let rows = &walls.rows;
    json!({
        "rows": {
            "mean": rows.mean(),
            "sigma": rows.sigma(),
            "min": rows.min(),
            "max": rows.max(),
            "within": rows.within(),
        },
        "points": walls.points,
        "points_mean": mean(&walls.points),
        "points_sigma": sample_sigma(&walls.points),
        "gauged": walls.gauged,
        "gauged_mean": mean(&walls.gauged),
        "gauged_sigma": sample_sigma(&walls.gauged),
    })
}
