//! Continuous precession as a job: the counts and curves of section 8 of its specification, and the pulses.

use crate::common::{parse, ran, with};
use hexstep_host::job::{Job, PrecessionJob, Task};
use hexstep_host::process::{Made, PrecessionMade};
use hexstep_host::report::PrecessionFigures;
use hexstep_host::run::Outcome;

const PLANE: &str = include_str!("../../jobs/precession-plane.toml");
const CURVED: &str = include_str!("../../jobs/precession-curved.toml");

fn parts<'a>(job: &'a Job, outcome: &'a Outcome) -> (&'a PrecessionJob, &'a PrecessionMade) {
    let (Task::Precession(precession), Some(Made::Precession(made))) = (&job.task, &outcome.made)
    else {
        panic!("a precession")
    };
    (precession, made)
}

fn figures<'a>(job: &'a Job, outcome: &'a Outcome) -> PrecessionFigures<'a> {
    let (precession, made) = parts(job, outcome);
    PrecessionFigures::of(job, precession, made, outcome, 1.0)
}

#[track_caller]
fn keeps_path(figures: &PrecessionFigures<'_>) {
    let poses = &figures.poses;
    assert!(poses.is_exact());
    assert_eq!(poses.outcome.starved, 0);
    assert!(poses.measured.tip <= 0.05 + poses.step());
    assert!(poses.measured.angle <= 0.05 + poses.angle_step());
    assert!(figures.is_sound());
}

#[test]
fn the_papers_plane_has_the_printed_poses_and_curves() {
    let text = with(PLANE, "points", "points = [[0, 0, 0], [60, 0, 0]]");
    let (job, outcome) = ran(&with(&text, "eps", "eps = 0.05"));

    let (_, made) = parts(&job, &outcome);

    assert_eq!((made.stances.len(), made.steps.as_slice()), (67, &[66][..]));
    assert!((made.far_length() - 276.125906).abs() < 5e-7);
    let xs = made.stances.iter().map(|s| s.far.x);
    let (least, most) = xs.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
        (lo.min(x), hi.max(x))
    });
    assert!((least + 14.469785).abs() < 5e-7 && (most - 103.436558).abs() < 5e-7);
    assert!((made.stances[3].far.y - 12.237492603).abs() < 1e-9);
    keeps_path(&figures(&job, &outcome));
}

#[test]
fn the_far_point_that_the_pulses_make_draws_the_trochoid() {
    let (job, outcome) = ran(PLANE);
    let figures = figures(&job, &outcome);

    keeps_path(&figures);
    // Section 5: v 5 mm/s, ell 127 mm, 20 deg, 30 deg/s, rho 39.5 mm.
    let (sin, cos) = 20f64.to_radians().sin_cos();
    let mut worst = 0f64;
    for sample in &figures.poses.measured.samples {
        let (tip, axis) = (sample.tool.tip, sample.tool.axis);
        // Where the ball is tells what time it is.
        let t = tip[0] / 5.0;
        let phase = (30.0 * t).to_radians();
        let wanted = [
            5.0 * t + 127.0 * sin * phase.cos(),
            127.0 * sin * phase.sin(),
            39.5 + 127.0 * cos,
        ];
        let off = (0..3).map(|i| (tip[i] + 127.0 * axis[i] - wanted[i]).powi(2));
        worst = worst.max(off.sum::<f64>().sqrt());
    }
    // 10 um of tip are 2 ms, and at 23 mm/s on the circle 0.05 mm; chord and direction are less.
    assert!(worst < 0.1, "{worst} mm");
    let html = figures.html();
    assert!(html.contains("Swept space, isometric") && html.contains("from above"));
}

#[test]
fn the_cylinder_has_the_printed_poses_and_runs_nearly_in_the_time_of_the_process() {
    let job = parse(&with(CURVED, "eps", "eps = 0.05")).expect("read");
    let Ok(Some(Made::Precession(made))) = Made::of(&job) else {
        panic!("a precession")
    };
    let last = made.stances.last().expect("poses");
    assert_eq!(made.stances.len(), 361);
    assert!(made.steps.iter().all(|steps| *steps == 30));
    assert!((last.time - 62.811917806).abs() < 1e-7);
    // The job gives nine decimals, a normal's last one is 2e-7 mm of the far point.
    assert!((last.far.x - 233.119019828).abs() < 1e-6);
    assert!(made.largest_turn() < 5.0);

    let (job, outcome) = ran(CURVED);
    let figures = figures(&job, &outcome);
    keeps_path(&figures);
    let late = figures.poses.time() - 62.811917806;
    assert!((0.0..0.02 * 62.8).contains(&late), "{late} s late");
}

#[test]
fn a_five_axis_head_polishes_as_well() {
    let cut = PLANE.find("# Joints in this order").expect("the machine");
    let text = format!(
        "{}[machine]\nmodel = \"head_ca\"\nsteps_per_unit = [800, 800, 800, 1000, 1000]\n\
         max_rate = [90, 90, 90, 60, 60]\nacceleration = [1500, 1500, 1500, 400, 400]\n\
         jerk = [40000, 40000, 40000, 12000, 12000]\n\
         travel = [[-400, 400], [-400, 400], [-400, 400], [-1080, 1080], [-120, 120]]\n",
        with(&PLANE[..cut], "near", "near = [0, 0, 0, 90, 20]")
    );

    let (job, outcome) = ran(&text);

    let figures = figures(&job, &outcome);
    keeps_path(&figures);
    // Two and a half turns of the axis are as many of C: a head without a wrist winds up.
    let turned = &figures.poses.motors.figures[3].statistics;
    assert!(turned.steps() > 890_000, "{}", turned.steps());
}

#[test]
fn a_single_point_with_a_dwell_is_polished_on_the_spot() {
    let text = with(PLANE, "points", "points = [[20, 0, 0]]");
    let text = with(&text, "normals", "normals = [[0, 0, 1]]");
    let text = with(&text, "eps", "eps = 0.01\ndwell = 6");

    let (job, outcome) = ran(&text);

    let figures = figures(&job, &outcome);
    let last = figures.made.stances.last().expect("poses");
    assert!((last.time - 6.0).abs() < 1e-12);
    assert!((last.phase.to_degrees::<f64>() - 180.0).abs() < 1e-9);
    keeps_path(&figures);
}
