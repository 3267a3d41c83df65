//! Every row of the validation tables that a job file can break, by its name, at its key and line.

use crate::common::{adding, parse, still, with};
use hexstep_host::process::Made;
use hexstep_host::run::run;

const SOFT: &str = include_str!("../../jobs/dune-soft.toml");
const SHELL: &str = include_str!("../../jobs/shell-soft.toml");
const PLANE: &str = include_str!("../../jobs/precession-plane.toml");
const PANEL: &str = include_str!("../../jobs/mirror-panel.toml");
const BIAS: &str = include_str!("../../jobs/mirror-bias.toml");

/// The text with this line in this table, in the place of the one that sets the same key.
#[track_caller]
fn changed(text: &str, table: &str, line: &str) -> String {
    let key = line.split(['=', ' ']).next().expect("a key");
    let head = text.find(&format!("[{table}]\n")).expect("the table");
    let end = text[head + 1..]
        .find("\n[")
        .map_or(text.len(), |at| head + 1 + at);
    let sets = |l: &str| {
        l.strip_prefix(key)
            .is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    let own = &text[head..end];
    if own.lines().any(sets) {
        let own = with(own, key, line);
        format!("{}{own}{}", &text[..head], &text[end..])
    } else {
        adding(text, table, line)
    }
}

/// Reading the job is refused by this name at this key, on the line that was put in.
#[track_caller]
fn refused(text: &str, table: &str, line: &str, name: &str, key: &str) {
    let text = changed(text, table, line);

    let error = parse(&text).map(|job| job.name).expect_err(line);

    assert_eq!(
        (error.name, error.key.as_deref()),
        (name, Some(key)),
        "{line}: {error}"
    );
    let place = error.place.unwrap_or_else(|| panic!("{line}: no place"));
    let first = 1 + text
        .lines()
        .position(|l| Some(l) == line.lines().next())
        .expect("the line");
    let last = first + line.lines().count();
    assert!((first..=last).contains(&place.line), "{line}: {error}");
    assert!(error.detail.len() > 15, "{error}");
    let told = error.to_string();
    assert!(
        told.starts_with(&format!("jobs/some.toml:{}:", place.line)),
        "{told}"
    );
}

#[test]
fn every_row_of_the_table_of_precession() {
    for (line, name) in [
        ("theta = -1", "BadTilt"),
        ("theta = 85.1", "BadTilt"),
        ("theta = nan", "BadTilt"),
        ("bonnet_radius = 0", "BadBonnet"),
        ("inward = 40", "BadBonnet"),
        ("inward = -0.1", "BadBonnet"),
        ("feed = 0", "BadFeedRate"),
        ("feed = inf", "BadFeedRate"),
        ("rate = nan", "BadRate"),
        ("eps = 0", "BadLimit"),
        ("dpsi = -1", "BadLimit"),
        ("dt_max = 0", "BadLimit"),
        ("w_rot = 0", "BadLimit"),
        ("ell = -1", "BadLimit"),
        ("alpha0 = nan", "NonFinite"),
        ("ref = [1, inf, 0]", "NonFinite"),
        ("ell_sign = 2", "BadLimit"),
    ] {
        let field = line.split(' ').next().unwrap();
        let key = match field {
            "inward" => "polishing.bonnet_radius".into(),
            field => format!("polishing.{field}"),
        };
        if field == "inward" {
            // The radius is told of both.
            let text = changed(PLANE, "polishing", line);
            let error = parse(&text).map(|job| job.name).expect_err(line);
            assert_eq!(
                (error.name, error.key.as_deref()),
                (name, Some(key.as_str()))
            );
            continue;
        }
        refused(PLANE, "polishing", line, name, &key);
    }
    for (line, name, key) in [
        ("points = []\nnormals = []", "BadPath", "path.points"),
        ("points = [[0, 0, 0]]", "BadPath", "path.points"),
        (
            "normals = [[0, 0, 1], [0, 0, 0]]",
            "BadNormal",
            "path.normals[1]",
        ),
        (
            "normals = [[0, 0, 1], [0, 0, nan]]",
            "BadNormal",
            "path.normals[1]",
        ),
        (
            "normals = [[0, 0, 1], [0, 0, -1]]",
            "AntiParallel",
            "path.normals[1]",
        ),
        (
            "points = [[0, 0, 0], [nan, 0, 0]]",
            "NonFinite",
            "path.points[1]",
        ),
    ] {
        let mut text = PLANE.to_string();
        if line.contains('\n') {
            text = text.replace("normals = [[0, 0, 1], [0, 0, 1]]\n", "");
        }
        refused(&text, "path", line, name, key);
    }
    let pitch = PLANE.replace("rate = 30", "pitch = 0");
    assert_eq!(
        parse(&pitch).map(|job| job.name).expect_err("pitch").name,
        "BadPitch"
    );
    let single = with(PLANE, "normals", "normals = [[0, 0, 1]]");
    let single = with(&single, "points", "points = [[0, 0, 0]]");
    let error = parse(&single).map(|job| job.name).expect_err("no dwell");
    assert_eq!(
        (error.name, error.key.as_deref()),
        ("BadDwell", Some("polishing.dwell"))
    );
}

#[test]
fn every_row_of_the_table_of_surface_grinding() {
    for (line, name) in [
        ("e1 = 0", "BadMaterial"),
        ("nu2 = 0.6", "BadMaterial"),
        ("e2 = nan", "BadMaterial"),
        ("force = 0", "BadParameter"),
        ("k = -1", "BadParameter"),
        ("rpm = 0", "BadParameter"),
        ("feed = inf", "BadParameter"),
        ("scallop = 0", "BadParameter"),
        ("eps = 0", "BadParameter"),
        ("l_max = nan", "BadParameter"),
        ("turn = 0", "BadParameter"),
        ("r_rim = 0", "BadParameter"),
        ("r_crown = -1", "BadParameter"),
        ("e_gap = 0", "BadParameter"),
        ("margin = 1", "BadParameter"),
        ("sense = 2", "BadParameter"),
        ("model = \"sum\"", "BadParameter"),
        ("depth_mode = \"deep\"", "BadParameter"),
        ("strategy = \"zigzag\"", "BadParameter"),
        ("step_mode = \"all\"", "BadParameter"),
        ("nodes = 4", "BadParameter"),
        ("seed = 1.5", "BadParameter"),
        ("seed = nan", "BadParameter"),
        ("half_width = 0", "BadParameter"),
        ("half_width = inf", "BadParameter"),
        ("e_lat = 0", "BadParameter"),
        ("strategy = \"iso\"", "BadParameter"),
    ] {
        let key = match line.split(' ').next().unwrap() {
            // Of iso rows the count is missing, which stands nowhere.
            "strategy" if line.contains("iso") => {
                let error = parse(&changed(SOFT, "grinding", line)).map(|job| job.name);
                let error = error.expect_err(line);
                assert_eq!(
                    (error.name, error.key.as_deref()),
                    (name, Some("grinding.count"))
                );
                continue;
            }
            key => format!("grinding.{key}"),
        };
        // "feed" and "eps" stand in this table alone.
        refused(SOFT, "grinding", line, name, &key);
    }
    for (line, name, key) in [
        ("degree = [6, 3]", "BadDegree", "surface.degree"),
        ("degree = [3, 0]", "BadDegree", "surface.degree"),
        (
            "knots_u = [0, 0, 0, 0, 0.25, 0.5, 0.4, 1, 1, 1, 1]",
            "BadKnots",
            "surface.knots_u",
        ),
        (
            "knots_v = [0, 0, 0, 0, 0.3, 0.3, 1, 1, 1]",
            "BadKnots",
            "surface.knots_v",
        ),
        (
            "knots_u = [0, 0, 0, 0, 0.25, nan, 0.75, 1, 1, 1, 1]",
            "BadKnots",
            "surface.knots_u",
        ),
        ("weights = [[1, 1]]", "BadNet", "surface.weights"),
    ] {
        refused(SHELL, "surface", line, name, key);
    }
    for weight in ["0", "-1", "nan"] {
        let rows = vec![format!("[{weight}, 1, 1, 1, 1, 1]"); 7].join(", ");
        let line = format!("weights = [{rows}]");
        refused(SHELL, "surface", &line, "BadWeight", "surface.weights");
    }
    let holed = SHELL.replacen("], [160,", "], [nan,", 1);
    let short = SHELL.replacen("    [[0, 0, ", "    [[1, 1, 1], [0, 0, ", 1);
    for text in [holed, short] {
        let error = parse(&text).map(|job| job.name).expect_err("a net");
        assert_eq!(
            (error.name, error.key.as_deref()),
            ("BadNet", Some("surface.points"))
        );
    }
    let flat = parse(&changed(SOFT, "grinding", "wheel = 3")).map(|job| job.name);
    assert_eq!(flat.expect_err("no such key").name, "UnknownField");
    let head = with(SOFT, "model", "model = \"head_ca\"");
    assert!(parse(&head).is_err(), "a wheel needs six joints");
}

/// A bilinear net over a rectangle, with the height of its last corner.
fn flat(x: f64, y: f64, z: f64) -> String {
    let start = SHELL.find("[surface]\n").expect("the table");
    let end = SHELL.find("[grinding]\n").expect("the next");
    let surface = format!(
        "[surface]\ndegree = [1, 1]\nknots_u = [0, 0, 1, 1]\nknots_v = [0, 0, 1, 1]\n\
         points = [[[0, 0, 0], [0, {y}, 0]], [[{x}, 0, 0], [{x}, {y}, {z}]]]\n"
    );
    format!("{}{surface}{}", &SHELL[..start], &SHELL[end..])
}

/// What a job can be refused for only when its rows are planned; together with the two tests before it, every row of
/// the table that a job file can break. (It evaluates no place outside the surface, `OutOfDomain`, and takes no pose,
/// `BadPose`: those two the calculators refuse.)
#[test]
fn every_row_of_the_table_of_surface_grinding_that_shows_in_planning() {
    let dune = with(
        &with(SOFT, "stations", "stations = 2"),
        "compare",
        "compare = false",
    );
    let plane = with(&flat(120.0, 90.0, 0.0), "compare", "compare = false");
    let wheel = |text: &str, line: &str| adding(text, "grinding", line);
    let collapsed = with(
        &plane,
        "points",
        "points = [[[0, 0, 0], [0, 0, 0]], [[120, 0, 0], [120, 0, 0]]]",
    );
    let narrow = {
        let range = ["[-1, 1]"; 6].join(", ");
        with(&dune, "travel", &format!("travel = [{range}]"))
    };
    for (what, text, name, key) in [
        (
            "a net without area",
            collapsed,
            "DegenerateNormal",
            "grinding",
        ),
        (
            "flat",
            wheel(&dune, "r_crown = \"flat\""),
            "NoHertzContact",
            "grinding.r_crown",
        ),
        (
            "almost flat",
            wheel(&plane, "r_crown = 1e9"),
            "LineContact",
            "grinding",
        ),
        (
            "narrow",
            wheel(&plane, "half_width = 0.3"),
            "FootprintTooLarge",
            "grinding.half_width",
        ),
        (
            "deep cusps",
            wheel(&dune, "scallop = 0.2"),
            "TooShallow",
            "grinding.scallop",
        ),
        (
            "low cusps of sums",
            wheel(&dune, "scallop = 0.001\nmodel = \"additive\""),
            "AdditiveBranch",
            "grinding.scallop",
        ),
        (
            "very low cusps",
            wheel(&plane, "scallop = 1e-9\nnodes = 5"),
            "TooManyRows",
            "grinding",
        ),
        (
            "from the edge",
            wheel(&dune, "seed = 0"),
            "FrontFold",
            "grinding",
        ),
        (
            "one row",
            with(&flat(120.0, 0.5, 0.0), "rows", "rows = [0, 0]"),
            "NoGap",
            "grinding",
        ),
        (
            "far",
            with(&dune, "work_origin", "work_origin = [900, 0, 300]"),
            "Unreachable",
            "machine.work_origin",
        ),
        ("no room", narrow, "NoBranch", "machine.work_origin"),
    ] {
        let error = parse(&text)
            .and_then(|job| run(&job, &mut |_, _| {}).map(|_| job.name))
            .expect_err(what);

        assert_eq!(
            (error.name, error.key.as_deref()),
            (name, Some(key)),
            "{what}: {error}"
        );
        assert!(error.detail.len() > 15, "{error}");
    }
}

#[test]
fn coarse_normals_and_the_other_flags_of_precession_are_accepted_and_told() {
    let text = with(PLANE, "normals", "normals = [[0, 0, 1], [0.6, 0, 0.8]]");
    let text = with(&text, "points", "points = [[0, 0, 0], [5, 0, 0]]");

    let job = parse(&text).expect("accepted");
    let Ok(Some(Made::Precession(made))) = Made::of(&job) else {
        panic!("a precession")
    };

    assert_eq!(made.flags.names().collect::<Vec<_>>(), ["CoarseNormals"]);
}

#[test]
fn every_row_of_the_table_of_mirror_milling_that_a_job_has() {
    for (line, name, key) in [
        ("d = 0", "BadWall", "simulation.d"),
        ("d = nan", "BadWall", "simulation.d"),
        ("dt = 0", "BadLimit", "simulation.dt"),
        ("tau = [0.2, 0]", "BadLimit", "simulation.tau[1]"),
        ("rate = -1", "BadLimit", "simulation.rate"),
        ("amount = nan", "BadLimit", "simulation.amount"),
        ("gate = 0", "BadLimit", "simulation.gate"),
        ("feed = 0", "BadLimit", "simulation.feed"),
        ("noise = inf", "NonFinite", "simulation.noise"),
        ("force = nan", "NonFinite", "simulation.force"),
        ("tau = []", "OutOfRange", "simulation.tau"),
        ("feed = 1e-5", "BadLimit", "simulation.dt"),
    ] {
        if line == "feed = 1e-5" {
            let text = changed(PANEL, "simulation", line);
            let error = parse(&text).map(|job| job.name).expect_err(line);
            assert_eq!((error.name, error.key.as_deref()), (name, Some(key)));
            continue;
        }
        refused(PANEL, "simulation", line, name, key);
    }
    for (line, name, key) in [
        ("peak = nan", "NonFinite", "panel.peak"),
        ("length = 0", "BadPanel", "panel.length"),
        ("rows = [-200, 400]", "BadPanel", "panel.rows"),
        ("places = []", "BadPanel", "panel.places"),
        ("start = 600", "BadPanel", "panel.start"),
    ] {
        refused(PANEL, "panel", line, name, key);
    }
    for (table, name) in [
        ("[path]\nrows = [0]\n", "Contradictory"),
        ("[stepper]\npulse_us = 2\n", "Contradictory"),
        ("[machine]\nmodel = \"arm\"\n", "MissingField"),
    ] {
        let text = format!("{}\n{table}", still(PANEL));
        let error = parse(&text).map(|job| job.name).expect_err(table);
        assert_eq!(error.name, name, "{error}");
    }
}

#[test]
fn what_is_wrong_with_the_pair_or_its_path_is_refused_by_name() {
    for (line, name, key) in [
        ("pair = \"m5\"", "TooManyJoints", "machine.pair"),
        ("pair = \"m6\"", "UnknownName", "machine.pair"),
        ("max_rate = [100, 100]", "WrongType", "machine.max_rate"),
        ("trim_share = 0", "OutOfRange", "machine.trim_share"),
        ("trim_share = 0.6", "OutOfRange", "machine.trim_share"),
        ("mill_tip = [0, 0, 50]", "UnknownField", "machine.mill_tip"),
    ] {
        refused(PANEL, "machine", line, name, key);
    }
    for (line, name, key) in [
        ("rows = [3]", "OutOfRange", "path.rows[0]"),
        ("rows = [0, 0.5]", "OutOfRange", "path.rows[1]"),
        ("rows = []", "OutOfRange", "path.rows"),
        ("from = -451", "OutOfRange", "path.from"),
        ("to = -450", "Contradictory", "path.to"),
        ("radius = 800", "OutOfRange", "path.radius"),
        ("wave = [10, 900]", "Contradictory", "path.wave"),
        ("lift = 0", "OutOfRange", "path.lift"),
        ("tip_tolerance = nan", "NotFinite", "path.tip_tolerance"),
        (
            "points = [[0, 0, 0], [9, 0, 0]]",
            "Contradictory",
            "path.rows",
        ),
    ] {
        let text = changed(PANEL, "path", line);
        let error = parse(&text).map(|job| job.name).expect_err(line);
        assert_eq!(
            (error.name, error.key.as_deref()),
            (name, Some(key)),
            "{error}"
        );
        assert!(error.place.is_some(), "{error}");
    }
    // The controller trims by whole milliseconds.
    for dt in ["0.0005", "0.0101", "0.2"] {
        let line = format!("dt = {dt}");
        refused(PANEL, "simulation", &line, "BadLimit", "simulation.dt");
    }
    let ten = parse(&with(PANEL, "pair", "pair = \"m5\"")).map(|job| job.name);
    let told = ten.expect_err("ten joints").to_string();
    assert!(
        told.contains("eight motors") && told.contains("mirror.solve"),
        "{told}"
    );
}

#[test]
fn points_and_normals_that_are_none_are_refused_by_name() {
    let (head, _) = PANEL.split_once("[path]").expect("a path");
    for (points, normals, name, key) in [
        (
            "[[0, 0, 0], [9, 0, nan]]",
            "[[0, 0, 1], [0, 0, 1]]",
            "NonFinite",
            "path.points[1]",
        ),
        (
            "[[0, 0, 0], [9, 0, 0]]",
            "[[0, 0, 1], [0, inf, 1]]",
            "NonFinite",
            "path.normals[1]",
        ),
        (
            "[[0, 0, 0], [9, 0, 0]]",
            "[[0, 0, 1e-7], [0, 0, 1]]",
            "BadNormal",
            "path.normals[0]",
        ),
        (
            "[[0, 0, 0], [9, 0, 0]]",
            "[[0, 0, 1]]",
            "OutOfRange",
            "path.normals",
        ),
        (
            "[[0, 0, 0], [9, 0]]",
            "[[0, 0, 1], [0, 0, 1]]",
            "WrongType",
            "path.points[1]",
        ),
        (
            "[[0, 0, 0], [9, 0, 2e6]]",
            "[[0, 0, 1], [0, 0, 1]]",
            "OutOfRange",
            "path.points[1]",
        ),
    ] {
        let text = format!("{head}[path]\npoints = {points}\nnormals = {normals}\n");

        let error = parse(&text).map(|job| job.name).expect_err(points);

        assert_eq!(
            (error.name, error.key.as_deref()),
            (name, Some(key)),
            "{error}"
        );
    }
}

#[test]
fn a_bias_that_is_none_is_refused_by_name() {
    for (line, name, key) in [
        ("offset = nan", "NonFinite", "bias.offset"),
        ("most = 0", "BadLimit", "bias.most"),
        ("most = inf", "BadLimit", "bias.most"),
        ("gate = -1", "BadLimit", "bias.gate"),
        ("readings = 9", "UnknownField", "bias.readings"),
    ] {
        refused(BIAS, "bias", line, name, key);
    }
}
