//! A checked job -> its pulses, by the very controller that runs on the target.
//!
//! Everything that can be refused is refused before the first tick: the whole path is walked once through kinematics
//! and travel limits.

use crate::job::{AxisLimits, CountsJob, DrillJob, Job, JobError, MOTORS, Task};
use crate::machine::{self, Machine, TICK_HZ};
use crate::trace::{Trace, seconds};
use hexstep::cycles::drill_point::Cycle;
use hexstep::joints::Joints;
use hexstep::machines::DrillGrinder;
use hexstep::path::{DrillPath, PathError, Scale};
use hexstep::settings::Settings;
use hexstep::stepper::{Preset, StepMode};

/// What a run has shown.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub trace: Trace<6>,
    /// Steps of each motor as the foreground's books have them.
    pub counts: [i32; 6],
    /// Times that the queue ran dry in motion; must be 0.
    pub starved: u32,
}

/// Receives how far a job has come: done, of all.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

/// Runs a job to its end on the machine in memory.
///
/// # Errors
/// A [`JobError`] with the key at fault: the path leaves the travel of a joint, or cannot be followed.
pub fn run(job: &Job, progress: Progress<'_>) -> Result<Outcome, JobError> {
    let settings = settings(job)?;
    let path = match &job.task {
        Task::DrillPoint(drill) => Some((drill, check_travel(job, drill, &settings)?)),
        Task::Counts(_) => None,
    };
    machine::with(|machine| {
        let configured = machine.controller.configure(settings);
        configured.map_err(|error| refused(job, &format!("error {}", error.number())))?;
        // The banner, which nobody has asked for, and the step mode, which the interrupt takes over between motions.
        machine.run_to_rest();
        machine.run(1);
        machine.heard();
        match (&job.task, path) {
            (Task::Counts(counts), _) => run_counts(job, counts, machine, progress)?,
            (_, Some((drill, cycle))) => run_drill(job, drill, cycle, machine, progress)?,
            (Task::DrillPoint(_), None) => {}
        }
        // The last levels go out a tick after they were computed, and a pulse ends one later.
        machine.run(3);
        Ok(Outcome {
            counts: machine.controller.counts(),
            starved: machine.starved(),
            trace: machine.take_trace(),
        })
    })
}

fn run_drill(
    job: &Job,
    drill: &DrillJob,
    cycle: Cycle<f32>,
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<(), JobError> {
    let started = machine.controller.start_drill(cycle, drill.arm());
    started.map_err(|error| refused(job, &format!("error {}", error.number())))?;
    machine.run_to_rest_watched(|controller| {
        if let Some((done, all)) = controller.progress() {
            progress(done.into(), all.into());
        }
    });
    answered(job, &machine.heard())
}

fn run_counts(
    job: &Job,
    counts: &CountsJob,
    machine: &mut Machine<'_>,
    progress: Progress<'_>,
) -> Result<(), JobError> {
    let all = counts.lines.len() as u64;
    for (done, line) in (1..).zip(&counts.lines) {
        let preset = match line.preset {
            Preset::Published => "PUBLISHED",
            Preset::Centred => "CENTRED",
        };
        let words: Vec<String> = line.counts.iter().map(i32::to_string).collect();
        let duration = seconds(line.duration);
        let answer = machine.ask(&format!("$SEG={},{duration},{preset}", words.join(",")));
        answered(job, &answer)?;
        progress(done, all);
    }
    Ok(())
}

/// The machine has checked the job once more, and should have found nothing.
fn answered(job: &Job, answer: &str) -> Result<(), JobError> {
    if answer.trim() == "ok" {
        Ok(())
    } else {
        Err(refused(job, answer.trim()))
    }
}

fn refused(job: &Job, answer: &str) -> JobError {
    job.refuse("kind", "Refused", format!("the machine answers: {answer}"))
}

/// The settings of the machine that a job describes.
fn settings(job: &Job) -> Result<Settings, JobError> {
    let mut settings = Settings::default();
    let us = |counts: u32| (seconds(counts.into()) * 1e6) as f32;
    let timing = &job.timing;
    let mut values: Vec<(u16, f32, String)> = vec![
        (0, us(timing.least_period), "stepper.pulse_us".into()),
        (29, us(timing.setup), "stepper.setup_us".into()),
        (1011, us(timing.hold), "stepper.hold_us".into()),
        (
            1010,
            f32::from(u8::from(timing.mode == StepMode::BothEdge)),
            "stepper.mode".into(),
        ),
    ];
    let axes = match &job.task {
        Task::DrillPoint(drill) => drill.axes,
        // A line of counts knows no unit and no limit but those of its own.
        Task::Counts(_) => {
            [AxisLimits {
                steps_per_unit: 1.0,
                max_rate: 1000.0,
                acceleration: 1000.0,
                travel: (-1e9, 1e9),
            }; 6]
        }
    };
    for (motor, axis) in (0u16..).zip(&axes) {
        let key = |name: &str| format!("machine.{name}[{motor}]");
        values.extend([
            // What is to be fast later would be too fast with the steps of before.
            (110 + motor, 1.0, key("max_rate")),
            (
                100 + motor,
                axis.steps_per_unit as f32,
                key("steps_per_unit"),
            ),
            (110 + motor, (axis.max_rate * 60.0) as f32, key("max_rate")),
            (120 + motor, axis.acceleration as f32, key("acceleration")),
            (1040 + motor, axis.travel.0 as f32, key("travel")),
            (1050 + motor, axis.travel.1 as f32, key("travel")),
        ]);
    }
    for (number, value, key) in values {
        settings.set(number, value, TICK_HZ).map_err(|error| {
            let detail = format!(
                "the machine does not take this value (${number}, error {}); see `$$` for its ranges",
                error.number()
            );
            job.refuse(&key, "OutOfRange", detail)
        })?;
    }
    Ok(settings)
}

/// The cycle, once its whole path is known to lie within the travel of every joint.
///
/// # Errors
/// `OutOfTravel` at `machine.travel`, or what the kinematics has to say.
fn check_travel(job: &Job, drill: &DrillJob, settings: &Settings) -> Result<Cycle<f32>, JobError> {
    let cycle = Cycle::new(&drill.parameters::<f32>());
    let cycle = cycle.expect("made when the job was read");
    let unlimited = Scale {
        steps_per_unit: Joints(settings.steps_per_joint_unit()),
        lower: [i32::MIN; 6],
        upper: [i32::MAX; 6],
    };
    let arm: DrillGrinder<f32> = drill.arm();
    // The path begins at zero.
    let (mut lowest, mut highest) = ([0i32; 6], [0i32; 6]);
    for target in DrillPath::new(cycle.clone(), arm, unlimited, Joints::default()) {
        let target = target.map_err(|error| path_error(job, error))?;
        for motor in 0..6 {
            lowest[motor] = lowest[motor].min(target.steps[motor]);
            highest[motor] = highest[motor].max(target.steps[motor]);
        }
    }
    let (lower, upper) = settings.travel();
    for motor in 0..6 {
        if lowest[motor] < lower[motor] || highest[motor] > upper[motor] {
            let axis = &drill.axes[motor];
            let unit = if motor < 3 { "mm" } else { "deg" };
            let place = |steps: i32| f64::from(steps) / axis.steps_per_unit;
            let detail = format!(
                "{} goes from {:.3} to {:.3} {unit}, beyond its travel of {} to {} {unit}; widen travel if the machine allows it, or change [structure] or [cycle]",
                MOTORS[motor],
                place(lowest[motor]),
                place(highest[motor]),
                axis.travel.0,
                axis.travel.1
            );
            return Err(job.refuse(&format!("machine.travel[{motor}]"), "OutOfTravel", detail));
        }
    }
    Ok(cycle)
}

fn path_error(job: &Job, error: PathError) -> JobError {
    let (key, detail) = match error {
        PathError::OutOfReach => (
            "structure",
            "no joints within the range of a step counter reach a pose of the cycle; check l1, l2 and steps_per_unit",
        ),
        PathError::OutOfTravel { .. } => (
            "machine.travel",
            "the path leaves the range of a step counter",
        ),
    };
    job.refuse(key, "OutOfReach", detail.into())
}
