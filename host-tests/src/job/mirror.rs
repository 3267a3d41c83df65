//! Jobs of kind `mirror`: a panel between mill and support, simulated with and without live trimming, and milled by the
//! pulses of both machines where the job has a `[machine]`.

use super::reader::{Kind, Table};
use super::{JobError, PairJob, Places};
use crate::mirror::{Panel, Simulation, SimulationError};
use hexstep::cycles::mirror_bias::{Bias, BiasError};
use hexstep::stepper::Timing;

/// What is simulated: the same panel and noise with each filter time.
#[derive(Clone, Debug)]
pub struct MirrorJob {
    /// One for each filter time; at least one.
    pub simulations: Vec<Simulation>,
    /// The machines, where there are some; they trim with the first filter time.
    pub pair: Option<PairJob>,
    pub bias: Option<BiasJob>,
}

/// A constant error of the machine, and what is learnt of it from the gauge.
#[derive(Clone, Copy, Debug)]
pub struct BiasJob {
    /// What every wall is off by [mm].
    pub offset: f64,
    /// Nothing learnt yet.
    pub bias: Bias<f64>,
}

const SIMULATION: &[&str] = &[
    "seed", "d", "force", "noise", "gauge", "feed", "dt", "tau", "amount", "rate", "gate",
];
const PANEL: &[&str] = &["length", "width", "peak", "rows", "places", "start"];

/// Filter times of one job.
const MOST_TIMES: usize = 12;

impl MirrorJob {
    pub(super) fn read(
        root: &Table<'_>,
        timing: &Timing,
        places: &Places,
    ) -> Result<Self, JobError> {
        let table = root.table("simulation")?;
        table.known(SIMULATION)?;
        let default = Simulation::default();
        let number = |key: &str, default: f64| table.number_or(key, default, Kind::LOOSE);
        let seed = table.whole_or("seed", 1, 0, i64::MAX)?;
        let common = Simulation {
            seed: seed.unsigned_abs(),
            d: number("d", default.d)?,
            force: number("force", default.force)?,
            noise: number("noise", default.noise)?,
            gauge: number("gauge", default.gauge)?,
            feed: number("feed", default.feed)?,
            dt: number("dt", default.dt)?,
            amount: number("amount", default.amount)?,
            rate: number("rate", default.rate)?,
            gate: number("gate", default.gate)?,
            panel: match root.table_if_any("panel")? {
                Some(panel) => read_panel(&panel)?,
                None => Panel::default(),
            },
            ..default
        };
        let times = match table.has("tau") {
            true => table.list("tau")?,
            false => vec![default.tau],
        };
        if times.is_empty() || times.len() > MOST_TIMES {
            let detail = format!(
                "expected 1 to {MOST_TIMES} filter times, found {}",
                times.len()
            );
            return Err(places.refuse("simulation.tau", "OutOfRange", detail));
        }
        let mut simulations = Vec::with_capacity(times.len());
        for (index, tau) in times.into_iter().enumerate() {
            let simulation = Simulation {
                tau,
                ..common.clone()
            };
            simulation
                .check()
                .map_err(|error| refusal(places, &error, index))?;
            simulations.push(simulation);
        }
        let first = &simulations[0];
        let bias = match root.table_if_any("bias")? {
            Some(table) => Some(read_bias(&table, first, places)?),
            None => None,
        };
        let pair = if root.has("machine") {
            Some(read_pair(root, first, timing, places)?)
        } else {
            for key in ["path", "joint", "stepper"] {
                if root.has(key) {
                    let detail = "without a [machine] nothing moves; add one, or remove this";
                    return Err(places.refuse(key, "Contradictory", detail.into()));
                }
            }
            None
        };
        Ok(Self {
            simulations,
            pair,
            bias,
        })
    }
}

fn read_pair(
    root: &Table<'_>,
    simulation: &Simulation,
    timing: &Timing,
    places: &Places,
) -> Result<PairJob, JobError> {
    let period = simulation.dt * 1000.0;
    let is_whole =
        (period - period.round()).abs() < 1e-6 && (1.0..=100.0).contains(&period.round());
    if !is_whole {
        let detail = format!(
            "the controller trims every whole number of milliseconds from 1 to 100, found {period} ms"
        );
        return Err(places.refuse("simulation.dt", "BadLimit", detail));
    }
    PairJob::read(root, simulation, timing, places)
}

fn read_bias(
    table: &Table<'_>,
    simulation: &Simulation,
    places: &Places,
) -> Result<BiasJob, JobError> {
    table.known(&["offset", "most", "gate"])?;
    let number = |key: &str, default: f64| table.number_or(key, default, Kind::LOOSE);
    let offset = table.number("offset", Kind::LOOSE)?;
    if !offset.is_finite() {
        let detail = "offset must be finite".into();
        return Err(places.refuse("bias.offset", "NonFinite", detail));
    }
    let made = Bias::new(simulation.d, number("most", 0.1)?, number("gate", 0.25)?);
    let bias = made.map_err(|error| match error {
        BiasError::BadLimit(name) => {
            let detail = format!("{name} must be finite and above 0");
            places.refuse(&format!("bias.{name}"), "BadLimit", detail)
        }
        // The wall was checked with the simulation.
        _ => places.refuse("simulation.d", "BadWall", "it is no wall".into()),
    })?;
    Ok(BiasJob { offset, bias })
}

fn read_panel(table: &Table<'_>) -> Result<Panel, JobError> {
    table.known(PANEL)?;
    let default = Panel::default();
    let number = |key: &str, default: f64| table.number_or(key, default, Kind::LOOSE);
    let list = |key: &str, default: Vec<f64>| match table.has(key) {
        true => table.list(key),
        false => Ok(default),
    };
    Ok(Panel {
        length: number("length", default.length)?,
        width: number("width", default.width)?,
        peak: number("peak", default.peak)?,
        rows: list("rows", default.rows)?,
        places: list("places", default.places)?,
        start: number("start", default.start)?,
    })
}

fn refusal(places: &Places, error: &SimulationError, time: usize) -> JobError {
    let key_of = |name: &str| match name {
        "tau" => format!("simulation.tau[{time}]"),
        "length" | "width" | "peak" | "rows" | "places" | "start" => format!("panel.{name}"),
        name => format!("simulation.{name}"),
    };
    match error {
        SimulationError::BadWall => {
            let detail = "the wall must be finite and above 0 mm";
            places.refuse("simulation.d", "BadWall", detail.into())
        }
        SimulationError::BadLimit(name) => {
            let detail = format!("{name} must be finite and above 0");
            places.refuse(&key_of(name), "BadLimit", detail)
        }
        SimulationError::NonFinite(name) => {
            let detail = format!("{name} must be finite");
            places.refuse(&key_of(name), "NonFinite", detail)
        }
        SimulationError::BadPanel(name) => {
            let detail = "rows and places must lie on the panel, at least one and at most 99 of each, places within the row from -start to start";
            places.refuse(&key_of(name), "BadPanel", detail.into())
        }
        SimulationError::BadRow => {
            let detail = "a row must take from 100 to 10 million ticks; change feed, dt or start";
            places.refuse("simulation.dt", "BadLimit", detail.into())
        }
    }
}
