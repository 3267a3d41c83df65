//! A pair of machines -> its pulses, by the controller of the target with eight motors: legs from standstill to standstill,
//! and on the rows a sensor that speaks on the serial line while the program runs.
//!
//! ```text
//!    pins --> where the support is --> delta(x, y) + noise --> 0xA6, 8 digits --> Trimmer --> both sides
//! ```
//!
//! The sensor looks at the panel where the pulses have taken the support, every `dt` of the machine's time.

use super::settings::{Value, apply, axis_values, driver_values};
use super::{Progress, refused};
use crate::job::{Job, JobError, PairJob};
use crate::machine::{self, Machine};
use crate::mirror::{MISS_MAX, Noise, Simulation};
use crate::pair::{Leg, PairBlock, PairPlan, What};
use crate::trace::{TICK_HZ, Trace};
use fixed::types::I32F32;
use hexstep::joints::whole_steps;
use hexstep::path::Target;
use hexstep::protocol::reading;
use hexstep::settings::Settings;
use hexstep::stepper::Timing;

/// What a run has shown.
#[derive(Clone, Debug)]
pub struct RunPair {
    pub plan: PairPlan,
    pub trace: Trace<8>,
    /// Steps of each motor as the foreground's books have them.
    pub counts: [i32; 8],
    /// What they should be at the end: the last place of the plan, all trims taken back.
    pub wanted: [i32; 8],
    /// Times that the queue ran dry in motion; must be 0.
    pub starved: u32,
    pub rows: Vec<RunRow>,
}

/// A row that has been milled.
#[derive(Clone, Debug)]
pub struct RunRow {
    /// Of the job.
    pub row: usize,
    /// When its motion began and ended [counts].
    pub start: u64,
    pub end: u64,
    pub readings: Vec<Reading>,
}

/// One reading of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// When it was sent [counts].
    pub time: u64,
    /// Where the support was [mm].
    pub x: f64,
    pub y: f64,
    /// How far the panel has given way there, and what the sensor says [mm].
    pub delta: f64,
    pub measured: f64,
}

/// Mills all rows.
///
/// # Errors
/// What the machine refuses: settings, a stream of readings that could not keep its promise, a target.
pub fn run(
    job: &Job,
    pair: &PairJob,
    simulation: &Simulation,
    plan: PairPlan,
    progress: Progress<'_>,
) -> Result<RunPair, JobError> {
    let settings = settings(job, pair, simulation, &plan)?;
    let mut start = target(job, pair, &plan.start, 0.0)?;
    rest(&mut start);
    let legs = plan.legs.iter().map(|leg| targets(job, pair, leg));
    let legs: Vec<Vec<Target<8>>> = legs.collect::<Result<_, _>>()?;
    let wanted = legs.last().and_then(|leg| leg.last()).unwrap_or(&start);
    let wanted = whole_steps(&wanted.steps);
    let all: u64 = legs.iter().map(|leg| leg.len() as u64).sum();
    machine::with_motors::<8, _>(|machine| {
        let configured = machine.controller.configure(settings);
        configured.map_err(|error| refused(job, &format!("error {}", error.number())))?;
        machine.run_to_rest();
        machine.run(1);
        machine.heard();
        let mut sensor = Sensor::new(pair, simulation);
        let mut done = 0;
        stream(job, machine, &[start], None, &mut |_| {})?;
        let mut rows = Vec::new();
        for (leg, targets) in plan.legs.iter().zip(&legs) {
            let mut told = |taken: u64| progress((done + taken).min(all), all);
            if let What::Row(row) = leg.what {
                follow(job, machine, simulation)?;
                let start = machine.now();
                sensor.begin(start);
                stream(job, machine, targets, Some(&mut sensor), &mut told)?;
                rows.push(RunRow {
                    row,
                    start,
                    end: machine.now(),
                    readings: std::mem::take(&mut sensor.readings),
                });
                answered(job, machine, "$TRIM=0")?;
            } else {
                stream(job, machine, targets, None, &mut told)?;
            }
            done += targets.len() as u64;
        }
        // The last levels go out a tick after they were computed, and a pulse ends one later.
        machine.run(3);
        Ok(RunPair {
            trace: machine.take_trace(),
            counts: machine.controller.counts(),
            wanted,
            starved: machine.starved(),
            rows,
            plan,
        })
    })
}

/// The settings of a pair's machine.
///
/// # Errors
/// `OutOfRange` at the key whose value the machine does not take.
pub fn settings(
    job: &Job,
    pair: &PairJob,
    simulation: &Simulation,
    plan: &PairPlan,
) -> Result<Settings<8>, JobError> {
    let limits: Vec<_> = pair.joints.iter().map(|joint| joint.limits).collect();
    let mut values: Vec<Value> = driver_values(job);
    values.extend(axis_values(&limits));
    values.extend([
        (1003, plan.contour as f32, "path.tip_tolerance".into()),
        (1004, plan.lever as f32, "machine".into()),
        // Both tips keep to their tolerance all the way.
        (1005, 0.0, "path.tip_tolerance".into()),
        (1013, pair.trim_share as f32, "machine.trim_share".into()),
    ]);
    for (motor, joint) in (0u16..).zip(&pair.joints) {
        let most = if joint.turns { 0.0 } else { simulation.amount };
        // A rounding of the amount is not less than it.
        let most = (most * (1.0 + 1e-6)) as f32;
        values.push((1030 + motor, most, "simulation.amount".into()));
    }
    apply(job, values)
}

/// A place of all joints [mm, deg] in steps, to be reached in `duration` [s] at least.
///
/// # Errors
/// `OutOfTravel` where a joint leaves the range of a step counter.
pub fn target(
    job: &Job,
    pair: &PairJob,
    joints: &[f64; 8],
    duration: f64,
) -> Result<Target<8>, JobError> {
    let mut steps = [I32F32::ZERO; 8];
    for ((motor, joint), at) in pair.joints.iter().enumerate().zip(joints) {
        let Some(place) = joint.limits.steps_at(*at) else {
            let key = format!("machine.steps_per_unit[{motor}]");
            let detail = format!("{} leaves the range of a step counter", joint.name);
            return Err(job.refuse(&key, "OutOfTravel", detail));
        };
        steps[motor] = place;
    }
    Ok(Target::new(steps, duration as f32))
}

/// A standstill is on whole steps.
fn rest(target: &mut Target<8>) {
    target.steps = whole_steps(&target.steps).map(I32F32::from);
}

/// All targets of a leg, which ends in a standstill.
///
/// # Errors
/// As [`target`].
pub fn targets(job: &Job, pair: &PairJob, leg: &Leg) -> Result<Vec<Target<8>>, JobError> {
    let blocks = leg.blocks.iter();
    let targets = blocks.map(|block: &PairBlock| target(job, pair, &block.joints, block.duration));
    let mut targets: Vec<Target<8>> = targets.collect::<Result<_, _>>()?;
    if let Some(last) = targets.last_mut() {
        rest(last);
    }
    Ok(targets)
}

/// Asks for live trims.
fn follow(
    job: &Job,
    machine: &mut Machine<'_, 8>,
    simulation: &Simulation,
) -> Result<(), JobError> {
    let s = simulation;
    // Whole, as read.
    let period = (s.dt * 1000.0).round();
    let line = format!(
        "$TRIM=ON,{period},{},{},{},{},{MISS_MAX}",
        s.tau as f32, s.amount as f32, s.rate as f32, s.gate as f32
    );
    answered(job, machine, &line)
}

fn answered(job: &Job, machine: &mut Machine<'_, 8>, line: &str) -> Result<(), JobError> {
    let answer = machine.ask(line);
    if answer.trim() == "ok" {
        return Ok(());
    }
    // A stream that could not keep its promise names the number that is to blame.
    for (name, key) in [
        ("period", "dt"),
        ("tau", "tau"),
        ("amount", "amount"),
        ("rate", "rate"),
        ("gate", "gate"),
    ] {
        if answer.contains(&format!("BadLimit {name}:")) {
            let detail = format!("the machine answers: {}", answer.trim());
            return Err(job.refuse(&format!("simulation.{key}"), "BadLimit", detail));
        }
    }
    Err(refused(job, &format!("{line}: {}", answer.trim())))
}

/// Runs targets to rest; the sensor speaks meanwhile.
fn stream(
    job: &Job,
    machine: &mut Machine<'_, 8>,
    targets: &[Target<8>],
    mut sensor: Option<&mut Sensor<'_>>,
    told: &mut dyn FnMut(u64),
) -> Result<(), JobError> {
    let started = machine.controller.start_stream();
    started.map_err(|error| refused(job, &format!("error {}", error.number())))?;
    let mut on = |machine: &mut Machine<'_, 8>| {
        while machine.controller.poll() {}
        if let Some(sensor) = &mut sensor {
            sensor.speak(machine);
        }
        // A millisecond at the floor of the tick rate.
        machine.neglect(u64::from(Timing::FLOOR_HZ / 1000));
    };
    for (taken, target) in (0..).zip(targets) {
        while !machine
            .controller
            .push(target)
            .map_err(|error| refused(job, &format!("{error:?} at target {taken}")))?
        {
            on(machine);
            told(taken);
        }
    }
    machine.controller.end_stream();
    while !machine.controller.is_idle() {
        on(machine);
    }
    let heard = machine.heard();
    if heard.contains("Trim fault") {
        return Err(refused(job, heard.trim()));
    }
    Ok(())
}

/// A sensor beside the support.
struct Sensor<'a> {
    pair: &'a PairJob,
    simulation: &'a Simulation,
    noise: Noise,
    /// When it began, how often it has spoken, and how long it waits between [counts].
    start: u64,
    spoken: u64,
    every: u64,
    readings: Vec<Reading>,
}

impl<'a> Sensor<'a> {
    fn new(pair: &'a PairJob, simulation: &'a Simulation) -> Self {
        Self {
            pair,
            simulation,
            noise: Noise::new(simulation.seed),
            start: 0,
            spoken: 0,
            every: (simulation.dt * TICK_HZ as f64).round() as u64,
            readings: Vec::new(),
        }
    }

    fn begin(&mut self, now: u64) {
        (self.start, self.spoken) = (now, 0);
    }

    /// Says what it sees, when it is time to.
    fn speak(&mut self, machine: &mut Machine<'_, 8>) {
        let now = machine.now();
        if now < self.start + self.spoken * self.every {
            return;
        }
        self.spoken += 1;
        let positions = machine.trace.positions();
        let joints = std::array::from_fn(|i| {
            positions[i] as f64 / self.pair.joints[i].limits.steps_per_unit
        });
        let [_, support] = self.pair.tools(&joints);
        let [x, y, _] = support.tip;
        let delta = self.simulation.delta(x, y);
        let measured = delta + self.simulation.noise * self.noise.gauss();
        machine.put(&reading::encode(Some(measured as f32)));
        self.readings.push(Reading {
            time: now,
            x,
            y,
            delta,
            measured,
        });
    }
}
