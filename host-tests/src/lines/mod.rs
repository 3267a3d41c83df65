//! A job -> the lines of the serial protocol that make a machine do it: its settings, its kinematics, its process with
//! every point. Any sender that waits for the answer to each line can send them.
//!
//! ```text
//! drill-point  $DRILL=..., RUN                                    image skr-pro
//! counts       $SEG=...                                           any
//! path         $CUE=..., $MOVE=... for every target, END            any; without dwells
//! poses        $MOVE=... for every block, END                     any: the planning is the host's
//! precession   $PRECESS=..., RUN, $POINT=... for every point      skr-pro-arm
//! surface      $SURF=..., RUN, $POINT=... for every station       skr-pro-arm
//! mirror       $TRIM=ON,..., $MIRROR=..., RUN, $POINT=...         octopus; the sensor is the machine's
//! ```

mod points;

use crate::job::{AxisLimits, Block, DrillJob, Job, JobError, PathJob, PosesJob, Task};
use crate::poses::Plan;
use crate::run::settings::{self, Value, apply, axis_values, driver_values};
use crate::run::targets;
use crate::trace::seconds;
use fixed::types::I32F32;
use hexstep::cycles::drill_point::Variant;
use hexstep::path::Target;
use hexstep::program::drill::WORDS;
use hexstep::program::list::Word;
use hexstep::protocol::cue::Action;
use hexstep::settings::Settings;
use hexstep::stepper::Preset;

/// All lines of a job.
///
/// # Errors
/// `NotOffered` for a job whose machine no image of the firmware has, else those of planning.
pub fn of(job: &Job) -> Result<Vec<String>, JobError> {
    match &job.task {
        Task::DrillPoint(drill) => {
            let mut lines = setting_lines(&settings::settings(job, None)?);
            if drill.variant != Variant::Exact {
                let detail = "a machine grinds the exact variant; set it, or leave it out";
                return Err(job.refuse("cycle.variant", "NotOffered", detail.into()));
            }
            let word =
                |word: Word| format!("{}{}", word.letter, number(drill_word(drill, word.name)));
            lines.push(format!("$DRILL={}", WORDS.map(word).join(",")));
            lines.push("$DRILL=RUN".into());
            Ok(lines)
        }
        Task::Counts(counts) => {
            let mut lines = setting_lines(&settings::settings(job, None)?);
            lines.extend(counts.lines.iter().map(|line| {
                let words: Vec<String> = line.counts.iter().map(i32::to_string).collect();
                let preset = match line.preset {
                    Preset::Published => "PUBLISHED",
                    Preset::Centred => "CENTRED",
                };
                format!(
                    "$SEG={},{},{preset}",
                    words.join(","),
                    seconds(line.duration)
                )
            }));
            Ok(lines)
        }
        Task::Poses(poses) => moves(job, poses),
        Task::Precession(precession) => points::precession(job, precession),
        Task::Surface(surface) => points::surface(job, surface),
        Task::Mirror(mirror) => points::mirror(job, mirror),
        Task::Path(path) => joints(job, path),
    }
}

/// The value of a word of `$DRILL=`.
fn drill_word(drill: &DrillJob, name: &str) -> f64 {
    match name {
        "diameter" => drill.diameter,
        "web" => drill.web,
        "point_angle" => drill.point_angle,
        "chisel_angle" => drill.chisel_angle,
        "clearance" => drill.clearance,
        "phi" => drill.phi,
        "stock" => drill.stock,
        "rough_depth" => drill.rough_depth,
        "finish_depth" => drill.finish_depth,
        "finish_passes" => drill.finish_passes.into(),
        "spark_out" => drill.spark_out.into(),
        "clear" => drill.clear,
        "over" => drill.over,
        "heel_angle" => drill.heel_angle,
        "mu_step" => drill.mu_step,
        "stroke_speed" => drill.stroke_speed,
        "infeed_speed" => drill.infeed_speed,
        "l1" => drill.l1,
        "l2" => drill.l2,
        // There is no other; a test sends the lines of every job.
        _ => f64::NAN,
    }
}

/// Blocks of joints, planned by the host.
fn moves(job: &Job, poses: &PosesJob) -> Result<Vec<String>, JobError> {
    let plan = Plan::of(job, poses)?;
    let mut lines = setting_lines(&settings::settings(job, Some((poses, &plan)))?);
    let targets = targets(job, poses, &plan)?;
    let (approach, path) = targets.split_at(1.min(targets.len()));
    for stretch in [approach, path] {
        lines.extend(move_lines(stretch));
    }
    Ok(lines)
}

/// A path of joints, with what is to happen on the way.
fn joints(job: &Job, path: &PathJob) -> Result<Vec<String>, JobError> {
    if let Some(index) = path.points.iter().position(|point| point.dwell > 0.0) {
        let detail = "no line makes a path dwell; leave it out, or divide the job there";
        return Err(path.refuse_point(job, index, "NotOffered", detail.into()));
    }
    let mut lines = setting_lines(&settings::settings(job, None)?);
    let percent = |share: f32| (share * 100.0).round();
    lines.extend(path.cues.iter().map(|cue| {
        let action = match cue.action {
            Action::Hold => "HOLD".into(),
            Action::Resume => "RESUME".into(),
            Action::Stop => "STOP".into(),
            Action::Feed(share) => format!("FEED,{}", percent(share)),
            Action::Rapid(share) => format!("RAPID,{}", percent(share)),
            Action::Trim { motor, steps } => format!("TRIM,{motor},{steps}"),
        };
        format!("$CUE={},{action}", cue.at)
    }));
    lines.extend(move_lines(&targets_of(path)));
    Ok(lines)
}

/// Targets of a path of joints, without its dwells.
pub fn targets_of(path: &PathJob) -> Vec<Target<6>> {
    let target = |block: &Block| Target::new(block.steps, block.duration as f32);
    path.blocks.iter().map(target).collect()
}

/// A path of joints, from its first target to its end.
pub fn move_lines<const N: usize>(targets: &[Target<N>]) -> Vec<String> {
    let line = |target: &Target<N>| {
        let words = target.steps.map(steps).join(",");
        format!("$MOVE={words},{}", target.duration)
    };
    let end = std::iter::once("$MOVE=END".into());
    targets.iter().map(line).chain(end).collect()
}

/// Steps as the protocol reads them, to a ten-thousandth.
fn steps(at: I32F32) -> String {
    let text = format!("{at:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.into()
}

/// Lines that give a machine all of these settings, whatever it had before: in the order of [`hexstep::settings`], so
/// that none is refused for what another still is.
pub fn setting_lines<const N: usize>(settings: &Settings<N>) -> Vec<String> {
    // Rates, accelerations, jerks, by their first numbers: each is bounded by the next.
    const LIMITS: [u16; 3] = [110, 120, 800];
    let motors = N as u16;
    let is_limit = |number: u16| {
        let of = |first: &u16| (*first..first + motors).contains(&number);
        LIMITS.iter().any(of)
    };
    let to = |first: u16, value: &str| {
        let line = |number| format!("${number}={value}");
        (first..first + motors).map(line).collect::<Vec<_>>()
    };
    let line = |(number, value): (u16, f32)| format!("${number}={}", number_of(value));
    let mut set: Vec<String> = LIMITS.iter().flat_map(|n| to(*n, "0.000001")).collect();
    set.extend(to(1040, "-1000000000"));
    set.extend(to(1050, "1000000000"));
    // A shaper that is off takes any frequency and damping.
    set.extend(to(1200, "0"));
    let shapers = 1200..1200 + motors;
    let others = settings
        .all()
        .filter(|(n, _)| !is_limit(*n) && !shapers.contains(n) && *n != 1012);
    set.extend(others.map(line));
    for first in LIMITS.into_iter().rev().chain([1200]) {
        let own = first..first + motors;
        set.extend(settings.all().filter(|(n, _)| own.contains(n)).map(line));
    }
    set
}

/// Settings of motors in their own units, with a tolerance of the path [mm].
fn own_settings<const N: usize>(
    job: &Job,
    axes: &[AxisLimits],
    tolerance: f64,
    others: Vec<Value>,
) -> Result<Settings<N>, JobError> {
    let mut values = driver_values(job);
    values.extend(axis_values(axes));
    values.push((1003, tolerance as f32, "path.tip_tolerance".into()));
    values.extend(others);
    apply(job, values)
}

/// A number as the protocol reads it: no exponent, as many digits as it has.
fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

fn number_of(value: f32) -> String {
    format!("{value}")
}
