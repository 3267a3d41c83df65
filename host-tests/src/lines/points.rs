//! Processes that run on the machine itself: their words, and every point.

use super::{number, own_settings, setting_lines};
use crate::job::{
    Job, JobError, MirrorJob, Model, PoseMachine, PosesJob, PrecessionJob, SurfaceJob,
};
use crate::mirror::MISS_MAX;
use crate::poses::Plan;
use crate::process::Made;
use crate::surface::{self, Segment};
use hexstep::cycles::precession::{Drive, FarEnd, FeedAt, Reference};
use hexstep::cycles::surface_grinding::{Depth, Model as Combining, Sense};
use hexstep::geometry::Vector;
use hexstep::program::list::Word;
use hexstep::program::processes::{PRECESS, SURF};
use hexstep::settings::Settings;

fn three(v: Vector<f64>) -> String {
    v.to_array().map(number).join(",")
}

fn words<const K: usize>(name: &str, table: &[Word; K], value: impl Fn(&str) -> f64) -> String {
    let word = |word: &Word| format!("{}{}", word.letter, number(value(word.name)));
    let words: Vec<String> = table.iter().map(word).collect();
    format!("${name}={}", words.join(","))
}

/// The arm of a job as lines, and the branch that its path has on the host.
fn arm(
    job: &Job,
    machine: &PoseMachine,
    poses: &PosesJob,
    tolerances: [f64; 2],
) -> Result<Vec<String>, JobError> {
    let Model::Arm { arm, tool, .. } = &machine.model else {
        let detail =
            "on the machine itself this process has an arm; on others the host plans its blocks";
        return Err(job.refuse("machine.model", "NotOffered", detail.into()));
    };
    let branch = Plan::of(job, poses)?.branch.unwrap_or(0);
    let of = arm.lengths();
    let axes: Vec<_> = machine.joints.iter().map(|joint| joint.limits).collect();
    let [tip, axis] = tolerances;
    let settings: Settings<6> = own_settings(job, &axes, tip, Vec::new())?;
    let mut lines = vec![
        "$KIN=ARM6R".into(),
        format!("$KIN.A={}", [of.a1, of.a2, of.a3].map(number).join(",")),
        format!("$KIN.D={}", [of.d1, of.d4, of.d6].map(number).join(",")),
        format!("$KIN.TOOL={}", number(tool.p.z)),
        format!("$KIN.WORK={}", three(machine.work().p)),
        format!("$KIN.BRANCH={branch}"),
        format!("$KIN.AXIS={}", number(axis)),
    ];
    // Which motors turn is the arm's business.
    let own = setting_lines(&settings).into_iter();
    lines.extend(own.filter(|line| !line.starts_with("$376=")));
    Ok(lines)
}

/// The poses of a process on the host: they tell the branch.
fn made_of(job: &Job) -> Result<Made, JobError> {
    let made = Made::of(job)?;
    made.ok_or_else(|| job.refuse("kind", "NotOffered", "it is no process".into()))
}

pub fn precession(job: &Job, precession: &PrecessionJob) -> Result<Vec<String>, JobError> {
    let made = made_of(job)?;
    let Made::Precession(made) = &made else {
        return Err(job.refuse("kind", "NotOffered", "it is no precession".into()));
    };
    let motion = &precession.motion;
    let tolerances = [motion.tip_tolerance, motion.axis_tolerance];
    let mut lines = arm(job, &precession.machine, &made.poses, tolerances)?;
    let p = &precession.parameters;
    let reference = p.first_reference.unwrap_or(Vector::ZERO);
    lines.push(words("PRECESS", &PRECESS, |name| match name {
        "theta" => p.theta.to_degrees(),
        "bonnet_radius" => p.bonnet_radius,
        "inward" => p.inward,
        "feed" => p.feed,
        "feed_at" => f64::from(u8::from(p.feed_at == FeedAt::Centre)),
        "drive" => f64::from(u8::from(matches!(p.drive, Drive::Distance { .. }))),
        "rate" => match p.drive {
            Drive::Time { rate } => rate.to_degrees(),
            Drive::Distance { .. } => 0.0,
        },
        "pitch" => match p.drive {
            Drive::Time { .. } => 60.0,
            Drive::Distance { pitch } => pitch,
        },
        "alpha0" => p.alpha0.to_degrees(),
        "reference" => f64::from(u8::from(p.reference == Reference::FeedLocked)),
        "ref_x" => reference.x,
        "ref_y" => reference.y,
        "ref_z" => reference.z,
        "ell" => p.ell,
        "far_end" => f64::from(u8::from(p.far_end == FarEnd::Surface)),
        "eps" => p.eps,
        "dpsi" => p.dpsi.to_degrees(),
        "dt_max" => p.dt_max,
        "w_rot" => p.w_rot.to_degrees(),
        "dwell" => p.dwell,
        // As the host has it: no way in, no way out.
        _ => 0.0,
    }));
    lines.push("$PRECESS=RUN".into());
    let points = precession.contacts.iter();
    lines.extend(points.map(|c| format!("$POINT={},{}", three(c.p), three(c.n))));
    lines.push("$POINT=END".into());
    Ok(lines)
}

pub fn surface(job: &Job, surface: &SurfaceJob) -> Result<Vec<String>, JobError> {
    let process = &surface.grinding.process;
    if surface.zigzag && process.sense != Sense::Neglected {
        let detail = "rows to and fro change the sense, and a machine knows but one; neglect it, or grind one way";
        return Err(job.refuse("grinding.sense", "NotOffered", detail.into()));
    }
    let made = made_of(job)?;
    let Made::Surface(made) = &made else {
        return Err(job.refuse("kind", "NotOffered", "it is no surface".into()));
    };
    let motion = &surface.motion;
    let tolerances = [motion.tip_tolerance, motion.axis_tolerance];
    let mut lines = arm(job, &surface.machine, &made.poses, tolerances)?;
    lines.push(words("SURF", &SURF, |name| match name {
        "r_rim" => process.wheel.rim.unwrap_or(0.0),
        "r_crown" => process.wheel.crown.unwrap_or(0.0),
        "half_width" => surface.grinding.half_width.unwrap_or(0.0),
        "e1" => process.wheel_material.modulus,
        "nu1" => process.wheel_material.poisson,
        "e2" => process.part_material.modulus,
        "nu2" => process.part_material.poisson,
        "force" => process.force,
        "k" => process.k * 1e12,
        "rpm" => process.rpm,
        "sense" => match process.sense {
            Sense::Neglected => 0.0,
            Sense::Against => 1.0,
            Sense::With => 2.0,
        },
        "scallop" => process.scallop,
        "margin" => process.margin,
        "model" => f64::from(u8::from(process.model == Combining::Additive)),
        "depth" => match process.depth {
            Depth::ConstantFeed => 0.0,
            Depth::Constant(depth) => depth,
        },
        "zigzag" => f64::from(u8::from(surface.zigzag)),
        "clear" => surface.lift,
        // "feed" and "plunge"
        _ => process.feed,
    }));
    lines.push("$SURF=RUN".into());
    let [first, last] = made.ground;
    for number in first..=last {
        let segments = made.own.plan.segments.iter().filter(|s| s.row == number);
        let mut segments: Vec<&Segment> = segments.collect();
        let is_back = surface.zigzag && number % 2 == 1;
        if is_back {
            segments.reverse();
        }
        for segment in segments {
            lines.push("$POINT=ROW".into());
            lines.extend(segment_lines(job, surface, segment, is_back)?);
        }
    }
    lines.push("$POINT=END".into());
    Ok(lines)
}

/// Contacts of a segment: place, normal, direction and curvatures.
fn segment_lines(
    job: &Job,
    surface: &SurfaceJob,
    segment: &Segment,
    is_back: bool,
) -> Result<Vec<String>, JobError> {
    let towards = if is_back { -1.0 } else { 1.0 };
    let line = |point: &surface::Point| {
        let [u, v] = point.uv;
        let section = surface.part.tool_shape(u, v).map(|shape| {
            let section = shape.along(towards, towards * point.slope);
            section.map(|section| (shape, section))
        });
        let Ok(Some((shape, section))) = section else {
            let detail = format!("no normal at u = {u:.4}, v = {v:.4}");
            return Err(job.refuse("surface", "DegenerateNormal", detail));
        };
        Ok(format!(
            "$POINT={},{},{},{}",
            three(shape.jet.s),
            three(shape.normal),
            three(section.feed),
            [section.k_f, section.k_c, section.tau]
                .map(number)
                .join(",")
        ))
    };
    let points = segment.points.iter();
    let mut lines: Vec<String> = points.map(line).collect::<Result<_, _>>()?;
    if is_back {
        lines.reverse();
    }
    Ok(lines)
}

pub fn mirror(job: &Job, mirror: &MirrorJob) -> Result<Vec<String>, JobError> {
    let Some(pair) = mirror.pair.as_ref().filter(|pair| pair.name == "m4") else {
        let detail = "lines are for the pair m4; a panel without [machine] is simulated only";
        return Err(job.refuse("machine.pair", "NotOffered", detail.into()));
    };
    let simulation = &mirror.simulations[0];
    let axes: Vec<_> = pair.joints.iter().map(|joint| joint.limits).collect();
    let mut others = vec![(1013, pair.trim_share as f32, "machine.trim_share".into())];
    for (motor, joint) in (0u16..).zip(&pair.joints) {
        let most = if joint.turns { 0.0 } else { simulation.amount };
        // A rounding of the amount is not less than it.
        others.push((
            1030 + motor,
            (most * (1.0 + 1e-6)) as f32,
            "simulation.amount".into(),
        ));
    }
    let settings: Settings<8> = own_settings(job, &axes, pair.tip_tolerance, others)?;
    let mut lines = setting_lines(&settings);
    lines.push(format!(
        "$TRIM=ON,{},{},{MISS_MAX}",
        (simulation.dt * 1000.0).round(),
        [
            simulation.tau,
            simulation.amount,
            simulation.rate,
            simulation.gate
        ]
        .map(number)
        .join(",")
    ));
    lines.push(format!(
        "$MIRROR=D{},V{},O{}",
        number(simulation.d),
        number(simulation.feed),
        number(pair.lift)
    ));
    lines.push("$MIRROR=RUN".into());
    for row in &pair.rows {
        lines.push("$POINT=ROW".into());
        let points = row.points.iter();
        lines.extend(
            points.map(|point| format!("$POINT={},{}", three(point.p()), three(point.v()))),
        );
    }
    lines.push("$POINT=END".into());
    Ok(lines)
}
