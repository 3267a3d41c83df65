//! Job files: what is right is read as meant; what is wrong is refused by file, line, key, name and remedy.

use hexstep::cycles::drill_point::Variant;
use hexstep::stepper::{Preset, StepMode};
use hexstep_host::job::{Job, JobError, Phi, Place, Task};

const DRILL: &str = include_str!("../jobs/drill-point.toml");
const COUNTS: &str = include_str!("../jobs/counts.toml");

fn parse(text: &str) -> Result<Job, JobError> {
    Job::parse("jobs/some.toml", "some", text.as_bytes())
}

/// The drill job with one line changed: the first that begins with `key` followed by a space or `=`.
#[track_caller]
fn with(key: &str, line: &str) -> String {
    let mut found = false;
    let changed: Vec<&str> = DRILL
        .lines()
        .map(|old| {
            let hit = !found && old.split([' ', '=']).next() == Some(key);
            found |= hit;
            if hit { line } else { old }
        })
        .collect();
    assert!(found, "{key} is in the file");
    changed.join("\n")
}

/// The line, from 1, on which a text first stands.
fn line_of(text: &str, part: &str) -> usize {
    1 + text
        .lines()
        .position(|line| line.contains(part))
        .expect("it stands there")
}

#[track_caller]
fn refused(text: &str) -> JobError {
    let error = parse(text).map(|job| job.name).expect_err("it is refused");
    assert_eq!(error.file, "jobs/some.toml");
    assert!(error.detail.len() > 10, "{error}");
    error
}

#[test]
fn the_delivered_drill_job_is_the_papers_first_example() {
    let job = parse(DRILL).expect("it is right");

    let Task::DrillPoint(drill) = &job.task else {
        panic!("a drill point")
    };
    assert_eq!(
        (
            drill.diameter,
            drill.web,
            drill.point_angle,
            drill.chisel_angle,
            drill.clearance,
            drill.phi
        ),
        (9.9, 1.63, 118.0, 50.0, 10.0, 30.0)
    );
    assert_eq!((drill.l1, drill.l2, drill.stock), (150.0, 40.0, 0.3));
    assert_eq!(
        drill.axes.map(|axis| axis.steps_per_unit),
        [1000.0, 1000.0, 1000.0, 2000.0, 2000.0, 2000.0]
    );
    assert_eq!(
        (drill.variant, drill.phi_chosen),
        (Variant::Exact, Phi::Given)
    );
    assert_eq!(job.timing.mode, StepMode::Pulse);
    // Rates as the motors see them stay below 200 kHz.
    assert!(
        drill
            .axes
            .iter()
            .all(|axis| axis.steps_per_unit * axis.max_rate <= 200_000.0)
    );
    // Printed in drill-grinding.md section 11.
    let (solution, _) = drill.wanted();
    assert!((solution.cone.theta.to_degrees() - 29.107892).abs() < 5e-7);
    assert!((solution.cone.tip.y - 1.065296).abs() < 5e-7);
}

#[test]
fn the_delivered_counts_are_read_in_order() {
    let job = parse(COUNTS).expect("it is right");

    let Task::Counts(counts) = &job.task else {
        panic!("counts")
    };
    assert_eq!(counts.lines.len(), 3);
    assert_eq!(
        counts.lines[0].counts,
        [100_000, 61_803, 38_197, 23_607, 14_590, 9_017]
    );
    assert_eq!(counts.lines[0].duration, 336_000_000);
    assert_eq!(counts.lines[1].preset, Preset::Centred);
    assert_eq!(counts.lines[2].counts, [7, 3, -5, 1, 0, 2]);
    assert_eq!(counts.lines[2].preset, Preset::Published);
}

#[test]
fn what_a_cycle_may_leave_out_has_its_published_default() {
    let given = [
        "rough_depth",
        "finish_depth",
        "finish_passes",
        "spark_out",
        "clear",
        "over",
        "heel_angle",
        "mu_step",
        "variant",
    ];
    let text: String = DRILL
        .lines()
        .filter(|line| !given.contains(&line.split(' ').next().unwrap_or("")))
        .map(|line| format!("{line}\n"))
        .collect();

    let short = parse(&text).expect("it is right");

    let (Task::DrillPoint(short), Task::DrillPoint(full)) =
        (short.task, parse(DRILL).expect("right").task)
    else {
        panic!("drill points")
    };
    assert_eq!(short, full);
}

#[test]
fn phi_auto_takes_the_suggested_angle() {
    let job = parse(&with("phi", "phi = \"auto\"")).expect("it is right");

    let Task::DrillPoint(drill) = job.task else {
        panic!("a drill point")
    };
    // drill-grinding.md section 5: 23 degrees for the paper's first example.
    assert_eq!((drill.phi, drill.phi_chosen), (23.0, Phi::Suggested));
}

/// Each row: the key as it stands in the file, the changed line, the key and the name of the error.
const BAD_LINES: &[(&str, &str, &str, &str)] = &[
    // Shape.
    ("web", "wbe = 1.63", "drill.wbe", "UnknownField"),
    ("l1", "l1 = 150\nl3 = 2", "structure.l3", "UnknownField"),
    ("web", "web = \"1.63\"", "drill.web", "WrongType"),
    ("web", "web = true", "drill.web", "WrongType"),
    ("web", "web = [1.63]", "drill.web", "WrongType"),
    ("web", "web = 2024-01-01", "drill.web", "WrongType"),
    ("web", "", "drill.web", "MissingField"),
    ("l2", "", "structure.l2", "MissingField"),
    ("stock", "", "cycle.stock", "MissingField"),
    ("travel", "", "machine.travel", "MissingField"),
    (
        "finish_passes",
        "finish_passes = 3.0",
        "cycle.finish_passes",
        "WrongType",
    ),
    (
        "finish_passes",
        "finish_passes = nan",
        "cycle.finish_passes",
        "NotFinite",
    ),
    ("kind", "kind = \"drill\"", "kind", "UnknownName"),
    ("kind", "kind = 1", "kind", "WrongType"),
    ("phi", "phi = \"best\"", "drill.phi", "UnknownName"),
    (
        "variant",
        "variant = \"rigid\"",
        "cycle.variant",
        "UnknownName",
    ),
    ("mode", "mode = \"edge\"", "stepper.mode", "UnknownName"),
    (
        "kind",
        "kind = \"drill-point\"\n[[line]]\ncounts = [1,2,3,4,5,6]",
        "line",
        "UnknownField",
    ),
    (
        "max_rate",
        "max_rate = [60, 60, 60, 60, 60, 75]\njerk = [1e5, 1e5, 0, 1e5, 1e5, 1e5]",
        "machine.jerk[2]",
        "OutOfRange",
    ),
    (
        "acceleration",
        "acceleration = [1500, 1500, 1500, 2000, 2000, 4.9e6]",
        "machine.acceleration[5]",
        "Contradictory",
    ),
    (
        "max_rate",
        "max_rate = [60, 60, 60, 60, 60]",
        "machine.max_rate",
        "WrongType",
    ),
    (
        "max_rate",
        "max_rate = [60, 60, 60, 60, \"60\", 60]",
        "machine.max_rate[4]",
        "WrongType",
    ),
    (
        "travel",
        "travel = [[-100, 20], [-60], [-60, 20], [-60, 60], [-60, 60], [-100, 200]]",
        "machine.travel[1]",
        "WrongType",
    ),
    // Numbers.
    ("diameter", "diameter = nan", "drill.diameter", "NotFinite"),
    ("diameter", "diameter = inf", "drill.diameter", "NotFinite"),
    (
        "diameter",
        "diameter = 1e999",
        "drill.diameter",
        "NotFinite",
    ),
    ("phi", "phi = -inf", "drill.phi", "NotFinite"),
    (
        "max_rate",
        "max_rate = [60, 60, 60, 60, 60, nan]",
        "machine.max_rate[5]",
        "NotFinite",
    ),
    ("l1", "l1 = -1", "structure.l1", "OutOfRange"),
    ("l2", "l2 = 1e7", "structure.l2", "OutOfRange"),
    (
        "steps_per_unit",
        "steps_per_unit = [0, 1, 1, 1, 1, 1]",
        "machine.steps_per_unit[0]",
        "OutOfRange",
    ),
    (
        "acceleration",
        "acceleration = [1, -1, 1, 1, 1, 1]",
        "machine.acceleration[1]",
        "OutOfRange",
    ),
    (
        "max_rate",
        "max_rate = [60, 60, 600, 60, 60, 60]",
        "machine.max_rate[2]",
        "OutOfRange",
    ),
    (
        "travel",
        "travel = [[-100, 20], [-60, 20], [-60, 20], [60, 60], [-60, 60], [-100, 200]]",
        "machine.travel[3]",
        "OutOfRange",
    ),
    (
        "pulse_us",
        "pulse_us = 26",
        "stepper.pulse_us",
        "OutOfRange",
    ),
    (
        "setup_us",
        "setup_us = -1",
        "stepper.setup_us",
        "OutOfRange",
    ),
    (
        "spark_out",
        "spark_out = -1",
        "cycle.spark_out",
        "OutOfRange",
    ),
    (
        "spark_out",
        "spark_out = 99999999999999999999",
        "cycle.spark_out",
        "OutOfRange",
    ),
    (
        "stroke_speed",
        "stroke_speed = 0",
        "cycle.stroke_speed",
        "OutOfRange",
    ),
    (
        "infeed_speed",
        "infeed_speed = -2",
        "cycle.infeed_speed",
        "OutOfRange",
    ),
    // drill-grinding.md section 3.1, and 7.
    ("diameter", "diameter = 0", "drill.diameter", "OutOfRange"),
    (
        "diameter",
        "diameter = -9.9",
        "drill.diameter",
        "OutOfRange",
    ),
    ("web", "web = 9.9", "drill.web", "OutOfRange"),
    ("web", "web = 0", "drill.web", "OutOfRange"),
    (
        "point_angle",
        "point_angle = 180",
        "drill.point_angle",
        "OutOfRange",
    ),
    (
        "chisel_angle",
        "chisel_angle = 130",
        "drill.chisel_angle",
        "OutOfRange",
    ),
    (
        "clearance",
        "clearance = 90",
        "drill.clearance",
        "OutOfRange",
    ),
    ("phi", "phi = 59", "drill.phi", "OutOfRange"),
    ("phi", "phi = 0", "drill.phi", "OutOfRange"),
    (
        "clearance",
        "clearance = 4",
        "drill.clearance",
        "ClearanceTooSmall",
    ),
    ("phi", "phi = 3", "drill.phi", "PhiTooSmall"),
    ("stock", "stock = 0", "cycle.stock", "OutOfRange"),
    (
        "rough_depth",
        "rough_depth = 0",
        "cycle.rough_depth",
        "OutOfRange",
    ),
    (
        "finish_depth",
        "finish_depth = -0.01",
        "cycle.finish_depth",
        "OutOfRange",
    ),
    ("clear", "clear = 0", "cycle.clear", "OutOfRange"),
    ("over", "over = -1", "cycle.over", "OutOfRange"),
    ("mu_step", "mu_step = 0", "cycle.mu_step", "OutOfRange"),
    (
        "heel_angle",
        "heel_angle = 200",
        "cycle.heel_angle",
        "OutOfRange",
    ),
];

#[test]
fn every_bad_line_is_refused_at_its_own_line_and_key() {
    for (key, line, at, name) in BAD_LINES {
        let text = with(key, line);

        let error = refused(&text);

        assert_eq!(
            (error.key.as_deref(), error.name),
            (Some(*at), *name),
            "{line}: {error}"
        );
        if *name == "MissingField" {
            // It stands nowhere: the table that should hold it is named.
            assert!(error.place.is_some(), "{line}: {error}");
        } else {
            let last = line.lines().last().expect("a line");
            let expected = if *at == "line" { "[[line]]" } else { last };
            let place = error
                .place
                .unwrap_or_else(|| panic!("{line}: no place in {error}"));
            assert_eq!(place.line, line_of(&text, expected), "{error}");
        }
    }
}

#[test]
fn the_place_is_that_of_the_value_itself() {
    let error = refused(&with("max_rate", "max_rate = [60, 60, 60, 60, nan, 60]"));

    let line = line_of(DRILL, "max_rate");
    assert_eq!(error.place, Some(Place { line, column: 29 }));
    let told = error.to_string();
    assert!(
        told.starts_with(&format!(
            "jobs/some.toml:{line}:29: machine.max_rate[4]: NotFinite: "
        )),
        "{told}"
    );
}

#[test]
fn drills_that_exclude_themselves_are_refused_by_name_with_the_key_to_change() {
    // Printed in drill-grinding.md section 14.
    let cases = [
        (
            ["10", "1.82", "140.74", "61.41", "19.87", "47.17"],
            "NoTip",
            "drill.clearance",
        ),
        (
            ["10", "1.09", "120.99", "40.78", "8.76", "28.56"],
            "NoChiselEnd",
            "drill.phi",
        ),
    ];
    for ([d, w, point, chisel, clearance, phi], name, key) in cases {
        let rest = &DRILL[DRILL.find("[structure]").expect("a structure")..];
        let text = format!(
            "kind = \"drill-point\"\n[drill]\ndiameter = {d}\nweb = {w}\npoint_angle = {point}\nchisel_angle = {chisel}\n\
             clearance = {clearance}\nphi = {phi}\n{rest}"
        );

        let error = refused(&text);

        assert_eq!(
            (error.name, error.key.as_deref()),
            (name, Some(key)),
            "{error}"
        );
        assert!(error.place.is_some(), "{error}");
    }
}

#[test]
fn errors_carry_the_figures_that_the_specification_promises() {
    let told = |key, line| refused(&with(key, line)).to_string();

    assert!(told("clearance", "clearance = 4").contains("5.649863"));
    assert!(told("phi", "phi = 3").contains("3.297673"));
    assert!(told("chisel_angle", "chisel_angle = 130").contains("supplement"));
}

#[test]
fn what_is_no_job_file_at_all_is_refused() {
    let cases: [(&[u8], &str); 8] = [
        (b"", "BadFile"),
        (b"  \n\t\n", "BadFile"),
        (b"\x7fELF\x01\x01\x01\0\0\0\xff\xfe", "BadFile"),
        (b"kind = \"counts\"\0", "BadFile"),
        (b"kind = ", "BadToml"),
        (b"just some words", "BadToml"),
        (b"kind = \"counts\"\nkind = \"counts\"", "BadToml"),
        (b"[drill]\nweb = 1", "MissingField"),
    ];
    for (bytes, name) in cases {
        let error = Job::parse("x.toml", "x", bytes)
            .map(|job| job.name)
            .expect_err("it is refused");

        assert_eq!(error.name, name, "{error}");
    }
    let missing = Job::load("no/such/file.toml".as_ref())
        .map(|job| job.name)
        .expect_err("no file");
    assert_eq!(
        (missing.name, missing.file.as_str()),
        ("BadFile", "no/such/file.toml")
    );
}

#[test]
fn a_syntax_error_has_its_line_and_column() {
    let error = refused("kind = \"counts\"\n\n[[line]]\ncounts = [1, 2,, 3]\n");

    assert_eq!(error.name, "BadToml");
    assert_eq!(
        error.place,
        Some(Place {
            line: 4,
            column: 16
        })
    );
}

#[test]
fn bad_lines_of_counts_are_refused() {
    let cases = [
        (
            "counts = [1, 2, 3, 4, 5]\nduration = 1",
            "line[0].counts",
            "WrongType",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6, 7]\nduration = 1",
            "line[0].counts",
            "WrongType",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6.5]\nduration = 1",
            "line[0].counts[5]",
            "WrongType",
        ),
        (
            "counts = [1, 2, 3, 4, 5, nan]\nduration = 1",
            "line[0].counts[5]",
            "NotFinite",
        ),
        (
            "counts = [1, 2, 9000000000000000000, 4, 5, 6]\nduration = 1",
            "line[0].counts[2]",
            "OutOfRange",
        ),
        (
            "counts = [1, 2, 92233720368547758070, 4, 5, 6]\nduration = 1",
            "line[0].counts[2]",
            "OutOfRange",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6]",
            "line[0].duration",
            "MissingField",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6]\nduration = 0",
            "line[0].duration",
            "OutOfRange",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6]\nduration = inf",
            "line[0].duration",
            "NotFinite",
        ),
        (
            "counts = [100000, 2, 3, 4, 5, 6]\nduration = 0.1",
            "line[0].duration",
            "OutOfRange",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6]\nduration = 1\npreset = \"half\"",
            "line[0].preset",
            "UnknownName",
        ),
        (
            "counts = [1, 2, 3, 4, 5, 6]\nduration = 1\nrate = 4",
            "line[0].rate",
            "UnknownField",
        ),
    ];
    for (line, key, name) in cases {
        let error = refused(&format!("kind = \"counts\"\n[[line]]\n{line}\n"));

        assert_eq!(
            (error.key.as_deref(), error.name),
            (Some(key), name),
            "{line}: {error}"
        );
        assert!(error.place.is_some(), "{error}");
    }
    for text in [
        "kind = \"counts\"",
        "kind = \"counts\"\nline = []",
        "kind = \"counts\"\nline = [3]",
        "kind = \"counts\"\nline = 3",
    ] {
        assert_eq!(refused(text).key.as_deref(), Some("line"), "{text}");
    }
}

#[test]
fn no_sequence_of_bytes_makes_the_reader_panic() {
    // A plain generator; the seed is the case.
    for seed in 0..3000u64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut roll = |sides: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as usize % sides
        };
        let mut bytes = if seed % 2 == 0 { DRILL } else { COUNTS }
            .as_bytes()
            .to_vec();
        for _ in 0..1 + roll(4) {
            let at = roll(bytes.len());
            match roll(4) {
                0 => bytes[at] = roll(256) as u8,
                1 => bytes.truncate(at.max(1)),
                2 => bytes.insert(at, b"[]=.,\"-+e1\n\xff"[roll(12)]),
                _ => {
                    let end = (at + roll(30)).min(bytes.len());
                    bytes.drain(at..end);
                    bytes.push(b'\n');
                }
            }
        }

        if let Err(error) = Job::parse("x.toml", "x", &bytes) {
            assert!(!error.to_string().is_empty());
        }
    }
}
