//! Surface grinding as a job: figures of section 11 of its specification, rows on the arm, the bounds of the issue.

use crate::common::{adding, parse, ran, with};
use hexstep_host::job::{Job, SurfaceJob, Task};
use hexstep_host::process::{Compared, Made, SurfaceMade};
use hexstep_host::report::SurfaceFigures;
use hexstep_host::run::{Outcome, run};
use hexstep_host::surface::Strategy;

const HARD: &str = include_str!("../../jobs/dune-hard.toml");
const SOFT: &str = include_str!("../../jobs/dune-soft.toml");
const SHELL: &str = include_str!("../../jobs/shell-soft.toml");

fn coarse(text: &str, stations: usize) -> String {
    with(text, "stations", &format!("stations = {stations}"))
}

/// The same without the baselines.
fn alone(text: &str, stations: usize) -> String {
    with(&coarse(text, stations), "compare", "compare = false")
}

fn parts<'a>(job: &'a Job, outcome: &'a Outcome) -> (&'a SurfaceJob, &'a SurfaceMade) {
    let (Task::Surface(surface), Some(Made::Surface(made))) = (&job.task, &outcome.made) else {
        panic!("a surface job")
    };
    (surface, made)
}

fn figures<'a>(job: &'a Job, outcome: &'a Outcome) -> SurfaceFigures<'a> {
    let (surface, made) = parts(job, outcome);
    SurfaceFigures::of(job, surface, made, outcome, 1.0)
}

fn of(made: &SurfaceMade, is: fn(&Strategy) -> bool) -> &Compared {
    let mut strategies = made.strategies.iter().filter_map(|s| s.as_ref().ok());
    strategies
        .find(|c| is(&c.strategy))
        .expect("it was planned")
}

/// The fewest straight rows that keep the scallop.
fn fewest(made: &SurfaceMade) -> &Compared {
    let mut strategies = made.strategies.iter().filter_map(|s| s.as_ref().ok());
    strategies.find(|c| c.is_fewest).expect("it was searched")
}

/// The bounds of the issue: adaptive rows max/min at most 1.03, all at most 0.040 mm, edges as well.
#[track_caller]
fn keeps_bounds(compared: &Compared) {
    let r = &compared.residual;
    assert!(r.ratio() <= 1.03, "max/min {}", r.ratio());
    assert!(r.max <= 0.040, "max {}", r.max);
    assert!(r.edge_max.is_none_or(|edge| edge <= 0.040), "{r:?}");
}

/// Pulses: every motor exactly at its count, nothing starved, the wheel on its rows to the tolerance and a step.
#[track_caller]
fn keeps_rows(figures: &SurfaceFigures<'_>) {
    let poses = &figures.poses;
    assert!(poses.is_exact());
    assert_eq!(poses.outcome.starved, 0);
    assert!(poses.measured.samples.len() > 10_000, "10 s and more");
    assert!(
        poses.measured.tip <= 0.02 + poses.step(),
        "tip off by {} mm",
        poses.measured.tip
    );
    assert!(
        poses.measured.angle <= 0.05 + poses.angle_step(),
        "tool off by {} deg",
        poses.measured.angle
    );
    assert!(figures.is_sound());
}

#[test]
fn the_soft_job_leaves_what_the_table_says_and_its_rows_run_on_the_arm() {
    let (job, outcome) = ran(&coarse(SOFT, 60));
    let figures = figures(&job, &outcome);

    let adaptive = of(figures.made, |s| matches!(s, Strategy::Adaptive));
    let rowmin = of(figures.made, |s| matches!(s, Strategy::RowMin));
    let iso = of(figures.made, |s| matches!(s, Strategy::Iso(_)));
    let fewest = fewest(figures.made);
    keeps_bounds(adaptive);
    // Section 11, job B; rows +-1, path +-0.5 %.
    assert!(adaptive.plan.rows.abs_diff(103) <= 1);
    assert!((adaptive.plan.path_length() / 1e3 - 19.54).abs() < 0.1);
    assert!(rowmin.plan.rows.abs_diff(103) <= 1);
    // Extremes of 241 stations lie in the corners between those of 60.
    assert!((rowmin.residual.ratio() / 2.391 - 1.0).abs() < 0.05);
    assert!((iso.residual.ratio() / 4.591 - 1.0).abs() < 0.05);
    assert!((iso.residual.max * 1e3 / 51.46 - 1.0).abs() < 0.02);
    // The table tries 113 rows, then 118; path +-0.5 % for so many rows.
    let rows = fewest.plan.rows;
    assert!((114..=118).contains(&rows) && fewest.residual.max <= 0.040);
    assert!((fewest.residual.ratio() / 4.625 - 1.0).abs() < 0.05);
    let metres = 23.88 / 118.0 * rows as f64;
    assert!((fewest.plan.path_length() / 1e3 / metres - 1.0).abs() < 0.005);
    keeps_rows(&figures);
    // Section 11: branch 0 serves every row with 37 deg to any limit.
    assert_eq!(
        figures.made.reached.branches[0],
        adaptive.plan.segments.len()
    );
    assert!(figures.made.reached.margin.to_degrees() >= 37.0);
    let html = figures.html();
    for told in [
        "paper, adaptive",
        "paper, iso",
        "Residual, iso",
        " rows (fewest)",
        "isometric",
    ] {
        assert!(html.contains(told), "{told}");
    }
    let takes = format!("it takes {rows} to keep the scallop");
    let summary = figures.summary();
    assert!(summary.iter().any(|l| l.contains(&takes)), "{summary:?}");
}

#[test]
fn the_hard_job_keeps_the_bounds_and_two_of_its_rows_run_on_the_arm() {
    let (job, outcome) = ran(&alone(HARD, 12));
    let figures = figures(&job, &outcome);

    keeps_bounds(&figures.made.own);
    let plan = &figures.made.own.plan;
    assert!(plan.rows.abs_diff(468) <= 1);
    assert!(plan.full_rows.abs_diff(406) <= 4);
    assert!((plan.path_length() / 1e3 - 89.57).abs() < 0.45);
    keeps_rows(&figures);
}

#[test]
fn a_second_surface_keeps_the_same_bounds_without_tuning() {
    let (job, outcome) = ran(SHELL);
    let figures = figures(&job, &outcome);

    assert_eq!(figures.surface.surface, "own");
    keeps_bounds(&figures.made.own);
    keeps_rows(&figures);
    // It is no easy surface: straight rows of the same number are far from even.
    let iso = of(figures.made, |s| matches!(s, Strategy::Iso(_)));
    assert!(iso.residual.ratio() > 1.5, "{:?}", iso.residual);
}

#[test]
fn every_ground_pose_stands_square_on_the_part_with_its_axle_across_the_row() {
    let job = parse(&alone(SOFT, 2)).expect("read");
    let Ok(Some(Made::Surface(made))) = Made::of(&job) else {
        panic!("a surface")
    };

    let rows = &made.poses.rows;
    let mut ground = 0;
    for (pair, grinds) in rows.windows(2).zip(made.grinds.iter().skip(1)) {
        if !grinds {
            continue;
        }
        ground += 1;
        let way: [f64; 3] = std::array::from_fn(|i| pair[1].tip[i] - pair[0].tip[i]);
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let length = dot(way, way).sqrt();
        let x = pair[0].across.expect("an arm");
        // A chord of at most 20 mm on curves of 90 mm radius and more leaves its tangent by 7 deg at most.
        let along = dot(way, x) / length;
        assert!(along.abs() > 0.99, "the feed is along x of the tool");
        assert!(dot(way, pair[0].axis).abs() / length < 0.12);
        assert!(dot(x, pair[0].axis).abs() < 1e-9);
        // The axle does not turn round with the feed.
        assert!(x[0] > 0.0, "{x:?}");
    }
    assert!(ground > 100);
    let [first, last] = made.ground;
    assert_eq!((first, last), (50, 52));
}

#[test]
fn a_lift_that_does_not_clear_the_part_is_refused_with_its_height() {
    // Without a zigzag the wheel goes back over the whole part, 7 mm hill included.
    let text = with(&alone(SOFT, 2), "zigzag", "zigzag = false");

    let low = parse(&with(&text, "lift", "lift = 2")).expect("read");
    let error = run(&low, &mut |_, _| {}).expect_err("it would collide");
    let high = ran(&with(&text, "lift", "lift = 30"));

    assert_eq!(
        (error.name, error.key.as_deref()),
        ("OutOfRange", Some("path.lift"))
    );
    assert!(error.detail.contains("above the part"), "{error}");
    assert!(figures(&high.0, &high.1).poses.is_sound());
}

#[test]
fn rows_that_the_plan_has_not_are_refused() {
    let text = with(&alone(SOFT, 2), "rows", "rows = [101, 103]");

    let job = parse(&text).expect("read");
    let error = run(&job, &mut |_, _| {}).expect_err("rows 0 to 102");

    assert_eq!(
        (error.name, error.key.as_deref()),
        ("OutOfRange", Some("path.rows"))
    );
    let line = 1 + text.lines().position(|l| l.starts_with("rows")).unwrap();
    assert_eq!(error.place.map(|place| place.line), Some(line));
}

#[test]
fn a_part_out_of_reach_is_refused_with_a_reason_for_each_branch() {
    let text = with(
        &alone(SOFT, 2),
        "work_origin",
        "work_origin = [900, 0, 300]",
    );

    let job = parse(&text).expect("read");
    let error = run(&job, &mut |_, _| {}).expect_err("too far");

    assert_eq!(error.name, "Unreachable");
    assert!(error.detail.contains("branch 7: out of reach"), "{error}");
}

#[test]
fn a_plan_that_cannot_be_is_refused_by_the_name_of_the_process() {
    let soft = alone(SOFT, 2);
    for (line, name) in [
        ("seed = 0", "FrontFold"),
        ("r_crown = \"flat\"", "NoHertzContact"),
        ("scallop = 0.2", "TooShallow"),
        ("strategy = \"iso\"\ncount = 1", "BadParameter"),
    ] {
        let text = adding(&soft, "grinding", line);

        let error = parse(&text).and_then(|job| run(&job, &mut |_, _| {}).map(|_| job));

        assert_eq!(error.expect_err(line).name, name, "{line}");
    }
}
