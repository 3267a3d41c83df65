//! Jobs with joint paths: read as meant, refused by name and place, run to the step, and reported as the pulses show it.

use hexstep::protocol::cue::{Action, Cue};
use hexstep_host::job::{Job, JobError, Pace, PathJob, Task};
use hexstep_host::report::{Limit, MotorFigures, PathFigures, Ruler};
use hexstep_host::run::{self, Outcome};
use hexstep_host::trace::seconds;
use std::path::PathBuf;

const CIRCLE: &str = include_str!("../jobs/circle.toml");
const TROCHOID: &str = include_str!("../jobs/trochoid.toml");
const STOPS: &str = include_str!("../jobs/stop-to-stop.toml");

/// Six equal motors: 100 steps a unit, 50 units/s, 500 units/s2, 10 000 units/s3.
const MACHINE: &str = "\
[machine]
steps_per_unit = [100, 100, 100, 100, 100, 100]
max_rate = [50, 50, 50, 50, 50, 50]
acceleration = [500, 500, 500, 500, 500, 500]
jerk = [10000, 10000, 10000, 10000, 10000, 10000]
travel = [[-100, 100], [-100, 100], [-100, 100], [-100, 100], [-100, 100], [-100, 100]]
";

/// A job on [`MACHINE`] with these lines below `[path]`, and tables behind them.
fn job_of(path: &str, tables: &str) -> String {
    format!("kind = \"path\"\n{MACHINE}[path]\n{path}\n{tables}")
}

fn parse(text: &str) -> Result<Job, JobError> {
    Job::parse("jobs/some.toml", "some", text.as_bytes())
}

#[track_caller]
fn path_of(job: &Job) -> &PathJob {
    match &job.task {
        Task::Path(path) => path,
        _ => panic!("a path"),
    }
}

/// Reads and runs a job that is right.
#[track_caller]
fn ran(text: &str) -> (Job, Outcome) {
    let job = parse(text).expect("it is right");
    let outcome = run::run(&job, &mut |_, _| {}).expect("it runs");
    (job, outcome)
}

/// Exact counts at the end of the path, nothing starved, the contour within tolerance and a step, limits kept.
#[track_caller]
fn assert_sound(figures: &PathFigures<'_>) {
    let end = figures.path.end().expect("a block");
    assert_eq!(figures.outcome.counts, end);
    assert_eq!(figures.outcome.trace.positions(), end.map(i64::from));
    assert_eq!(figures.outcome.starved, 0);
    assert!(
        figures.contour.largest <= figures.allowed(),
        "{} mm off, {} allowed",
        figures.contour.largest,
        figures.allowed()
    );
    assert!(figures.is_sound());
    for motor in &figures.motors.figures {
        assert_keeps_limits(motor, figures.motors.window);
    }
}

/// Velocity and acceleration within 2 %, jerk within 10 %, and what half a step can look like within a window.
#[track_caller]
fn assert_keeps_limits(f: &MotorFigures, window: f64) {
    let c = &f.channel;
    let [v, a, j] = [c.largest_rate, c.largest_acceleration, c.largest_jerk]
        .map(|limit| limit.expect("a limit"));
    assert!(f.rate <= 1.02 * v, "{}: {} of {v} steps/s", c.name, f.rate);
    let most = 1.02 * a + 2.9 / window.powi(2);
    assert!(
        f.acceleration <= most,
        "{}: {} of {a} steps/s2",
        c.name,
        f.acceleration
    );
    let most = 1.10 * j + 26.3 / window.powi(3);
    assert!(f.jerk <= most, "{}: {} of {j} steps/s3", c.name, f.jerk);
}

// ---- what is right is read as meant ----

#[test]
fn points_written_as_rows_share_the_feed_of_the_path() {
    let text = job_of(
        "feed = 600\npoints = [[1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 9]]",
        "",
    );

    let job = parse(&text).expect("it is right");

    let path = path_of(&job);
    assert_eq!(path.points[0].at, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert!(path.points.iter().all(|p| p.pace == Pace::Feed(600.0)));
    assert_eq!(path.end(), Some([100, 200, 300, 400, 500, 900]));
    // G94: along the joints that slide while one of them moves, at 10 mm/s; then along those that turn, at 10 deg/s.
    assert!((path.blocks[0].duration - 14f64.sqrt() / 10.0).abs() < 1e-12);
    assert!((path.blocks[1].duration - 0.3).abs() < 1e-12);
}

#[test]
fn a_slide_that_hardly_moves_does_not_rush_the_joints_that_turn() {
    let text = job_of(
        "feed = 600\npoints = [[0.0001, 0, 0, 30, 0, 0], [0.0011, 0, 0, 30, 0, 0]]",
        "",
    );

    let job = parse(&text).expect("it is right");

    assert!((path_of(&job).blocks[0].duration - 3.0).abs() < 1e-12);
    // Alone it has its own feed, a tenth of a step or not.
    assert!((path_of(&job).blocks[1].duration - 1e-4).abs() < 1e-12);
}

#[test]
fn points_keep_their_fractions_of_steps_where_the_path_goes_on_and_none_where_it_rests() {
    let text = job_of(
        "feed = 600",
        "[[point]]\nat = [0.12345678, -0.0025, 0, 0, 0, 0]\n\
         [[point]]\nat = [1.0049, 0, 0, 0, 0, 0]\ndwell = 0.1\n\
         [[point]]\nat = [2.0051, 0, 0, 0, 0, 100.004]\n",
    );

    let job = parse(&text).expect("it is right");

    let path = path_of(&job);
    let steps = |k: usize| path.blocks[k].steps.map(|at| at.to_num::<f64>());
    let [a, b, ..] = steps(0);
    assert!(
        (a - 12.3457).abs() < 1e-9 && (b + 0.25).abs() < 1e-9,
        "{a} {b}"
    );
    assert_eq!(steps(1), [100.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // 10 000.4 steps are the last of the travel: rounded, as the motor would.
    assert_eq!(steps(2), [201.0, 0.0, 0.0, 0.0, 0.0, 10_000.0]);
    let beyond = text.replace("100.004", "100.006");
    assert_eq!(parse(&beyond).unwrap_err().name, "OutOfTravel");
}

#[test]
fn rapids_leave_corners_among_themselves_by_their_own_tolerance_and_no_other_corner() {
    let corner = |first: &str, second: &str, tolerance: f64| {
        let text = job_of(
            &format!("tolerance = 0.01\nrapid_tolerance = {tolerance}"),
            &format!(
                "[[point]]\nat = [20, 0, 0, 0, 0, 0]\n{first}\n\
                 [[point]]\nat = [20, 20, 0, 0, 0, 0]\n{second}\n"
            ),
        );
        let (job, outcome) = ran(&text);
        let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
        assert_sound(&figures);
        (figures.contour.largest, figures.time())
    };
    // The way out of the work is not free; the one behind it may be left, but not where it begins.
    let out = |tolerance: f64| {
        let text = job_of(
            &format!("tolerance = 0.01\nrapid_tolerance = {tolerance}\nrapid = true"),
            "[[point]]\nat = [20, 0, 0, 0, 0, 0]\nfeed = 3000\n\
             [[point]]\nat = [20, 0.1, 0, 0, 0, 0]\n[[point]]\nat = [0, 0.1, 0, 0, 0, 0]\n",
        );
        let (job, outcome) = ran(&text);
        let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
        assert_sound(&figures);
        figures.contour.largest
    };
    let (rapid, feed) = ("rapid = true", "feed = 3000");

    let (off, time) = corner(rapid, rapid, 0.5);
    let (exact_off, exact_time) = corner(rapid, rapid, 0.0);
    let (cut_off, _) = corner(rapid, feed, 0.5);
    let (in_off, _) = corner(feed, rapid, 0.5);

    // A step of 0.01 mm either way.
    assert!(off > 0.3 && off <= 0.51, "{off} mm");
    assert!(exact_off.max(cut_off).max(in_off).max(out(0.5)) <= 0.02);
    assert!(time < 0.97 * exact_time, "{time} s, {exact_time} s exactly");
}

#[test]
fn every_point_may_have_a_pace_and_a_dwell_of_its_own() {
    let text = job_of(
        "feed = 60",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]\n\
         [[point]]\nat = [2, 0, 0, 0, 0, 0]\ninverse_time = 30\ndwell = 0.5\n\
         [[point]]\nat = [3, 0, 0, 0, 0, 0]\nrapid = true\n\
         [[point]]\nat = [4, 0, 0, 0, 0, 0]\nfeed = 120\n",
    );

    let job = parse(&text).expect("it is right");

    let path = path_of(&job);
    let durations: Vec<f64> = path.blocks.iter().map(|b| b.duration).collect();
    assert_eq!(durations, [1.0, 2.0, 0.0, 0.5]);
    assert_eq!(path.points[1].dwell, 0.5);
    assert_eq!(path.points[0].dwell, 0.0);
}

#[test]
fn limits_tolerance_and_lever_have_the_defaults_of_the_machines_own_table() {
    let text = job_of("rapid = true\npoints = [[1, 0, 0, 0, 0, 0]]", "")
        .replace("jerk = [10000, 10000, 10000, 10000, 10000, 10000]\n", "");

    let job = parse(&text).expect("it is right");

    let path = path_of(&job);
    assert!(path.axes.iter().all(|axis| axis.jerk == 40_000.0));
    assert_eq!((path.contour.tolerance, path.contour.lever), (0.01, 150.0));
    assert_eq!(path.contour.rapid_tolerance, 0.5);
}

#[test]
fn the_trochoid_is_the_far_point_of_the_papers_tool() {
    let job = parse(TROCHOID).expect("it is right");

    let path = path_of(&job);
    // precession-polishing.md section 8: ell sin(theta), 12 s a turn and 5 mm/s; started at phase 0.
    let radius = 127.0 * 20f64.to_radians().sin();
    assert_eq!(path.points.len(), 4000);
    for (k, point) in (1..).zip(&path.points) {
        let time = 12.0 * f64::from(k) / 2000.0;
        let phase = std::f64::consts::TAU * 5.0 / 60.0 * time;
        assert!((point.at[0] - (5.0 * time + radius * (phase.cos() - 1.0))).abs() < 1e-6);
        assert!((point.at[1] - radius * phase.sin()).abs() < 1e-6);
    }
    let time: f64 = path.blocks.iter().map(|b| b.duration).sum();
    assert!((time - 24.0).abs() < 1e-9);
}

// ---- CSV ----

/// A folder with a job and a table beside it, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, csv: &[u8]) -> Self {
        let path = std::env::temp_dir().join(format!("hexstep-path-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("made");
        let job = job_of("feed = 600\nfile = \"table.csv\"", "");
        std::fs::write(path.join("job.toml"), job).expect("written");
        std::fs::write(path.join("table.csv"), csv).expect("written");
        Self(path)
    }

    fn load(&self) -> Result<Job, JobError> {
        Job::load(&self.0.join("job.toml"))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_csv_file_beside_the_job_gives_points_feeds_inverse_times_and_dwells() {
    let folder = Folder::new(
        "right",
        b"# made by hand\n d1, theta3 ,F,T,P  # names\n1,10,,,\n\n2,,300,,0.25\n,20,,60,\n0,0,rapid,,\n",
    );

    let job = folder.load().expect("it is right");

    let path = path_of(&job);
    let joints: Vec<(f64, f64)> = path.points.iter().map(|p| (p.at[0], p.at[5])).collect();
    assert_eq!(joints, [(1.0, 10.0), (2.0, 10.0), (2.0, 20.0), (0.0, 0.0)]);
    let paces: Vec<Pace> = path.points.iter().map(|p| p.pace).collect();
    assert_eq!(
        paces,
        [
            Pace::Feed(600.0),
            Pace::Feed(300.0),
            Pace::InverseTime(60.0),
            Pace::Rapid
        ]
    );
    assert_eq!(path.points[1].dwell, 0.25);
}

#[test]
fn columns_may_have_the_letters_of_g_code() {
    let folder = Folder::new("letters", b"\xef\xbb\xbfC,X,Z\r\n1,2,3\r\n");

    let job = folder.load().expect("it is right");

    assert_eq!(path_of(&job).points[0].at, [2.0, 0.0, 3.0, 0.0, 0.0, 1.0]);
}

/// Three columns: three motors, under the names of the columns and with a number each.
#[test]
fn a_job_has_the_joints_of_its_table_and_no_others() {
    let folder = Folder::new("three", b"X,Z,C\n20,1,5\n20,3,9\n0,0,0\n");
    let text = "kind = \"path\"\n[path]\nfeed = 600\nfile = \"table.csv\"\n[machine]\n\
        steps_per_unit = [80, 400, 100]\nmax_rate = [200, 50, 60]\nacceleration = [1000, 500, 600]\n\
        jerk = [20000, 10000, 12000]\ntravel = [[-1, 300], [-1, 30], [-90, 90]]\n";
    std::fs::write(folder.0.join("job.toml"), text).expect("written");
    let job = folder.load().expect("it is right");

    let outcome = run::run(&job, &mut |_, _| {}).expect("it runs");
    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);

    assert_eq!(job.motor_names(), ["X", "", "Z", "", "", "C"]);
    assert_eq!(path_of(&job).blocks[0].steps, [1600, 0, 400, 0, 0, 500]);
    assert!(figures.is_sound(), "{:?}", figures.summary());
    let told = format!("{}\n{}", figures.summary().join("\n"), figures.html());
    for name in [
        "X: speed",
        "C: jerk",
        "step Z",
        "C [deg]",
        "Speed along X, Z",
    ] {
        assert!(told.contains(name), "{name}");
    }
    for name in [
        "d1:", "step d", "theta", "motor1", "motor5", "step Y", "step B",
    ] {
        assert!(!told.contains(name), "{name}");
    }
    let mut vcd = Vec::new();
    let span = hexstep_host::export::Span::ALL;
    hexstep_host::export::vcd(&mut vcd, &outcome.trace, &job.motor_names(), span).expect("memory");
    let vcd = String::from_utf8(vcd).expect("text");
    assert!(vcd.contains(" step_C ") && vcd.contains(" dir_X "));
    assert_eq!(vcd.matches("$var").count(), 7, "{vcd:.600}");
}

#[test]
fn a_job_with_numbers_for_neither_its_joints_nor_all_motors_is_refused() {
    let folder = Folder::new("two", b"X,Y,Z\n20,1,5\n");
    let text = "kind = \"path\"\n[path]\nfeed = 600\nfile = \"table.csv\"\n[machine]\nsteps_per_unit = [80, 400]\n";
    std::fs::write(folder.0.join("job.toml"), text).expect("written");

    let error = folder.load().expect_err("two numbers for three joints");

    assert_eq!(error.name, "WrongType");
    assert_eq!(error.key.as_deref(), Some("machine.steps_per_unit"));
    assert!(error.detail.contains('3'), "{}", error.detail);
}

/// Each row: the file, the line and column, the key and the name of its error.
type BadTable = (
    &'static [u8],
    Option<(usize, usize)>,
    Option<&'static str>,
    &'static str,
);

const BAD_TABLES: &[BadTable] = &[
    (b"", None, None, "OutOfRange"),
    (b"# nothing\n", None, None, "OutOfRange"),
    (b"\xff\xfe\x00", None, None, "BadFile"),
    (b"d1,d2\n", Some((1, 1)), None, "OutOfRange"),
    (b"d1,d4\n1,2\n", Some((1, 4)), Some("d4"), "UnknownField"),
    (b"1,2,3,4,5,6\n", Some((1, 1)), Some("1"), "UnknownField"),
    (b"d1,X\n1,2\n", Some((1, 4)), Some("X"), "Contradictory"),
    (b"F,T\n1,2\n", Some((1, 1)), None, "MissingField"),
    (b"d1,d2\n1,2\n3\n", Some((3, 1)), None, "WrongType"),
    (b"d1\n1\n2,3\n", Some((3, 1)), None, "WrongType"),
    (b"d1,d2\n1, two\n", Some((2, 4)), Some("d2"), "WrongType"),
    (b"d1\n\nnan\n", Some((3, 1)), Some("d1"), "NotFinite"),
    (b"d1\ninf\n", Some((2, 1)), Some("d1"), "NotFinite"),
    (b"d1\n1e400\n", Some((2, 1)), Some("d1"), "NotFinite"),
    (b"d1,F\n1,0\n", Some((2, 3)), Some("F"), "OutOfRange"),
    (b"d1,F\n1,-5\n", Some((2, 3)), Some("F"), "OutOfRange"),
    (b"d1,F\n1,2e9\n", Some((2, 3)), Some("F"), "OutOfRange"),
    (b"d1,T\n1,0\n", Some((2, 3)), Some("T"), "OutOfRange"),
    (b"d1,F,T\n1,2,3\n", Some((2, 5)), Some("T"), "Contradictory"),
    (b"d1,P\n1,-1\n", Some((2, 3)), Some("P"), "OutOfRange"),
    (
        b"d1,d2\n1,2\n# so far\n3,100.1\n",
        Some((4, 1)),
        Some("d2"),
        "OutOfTravel",
    ),
    (b"d1\n1e300\n", Some((2, 1)), Some("d1"), "OutOfRange"),
];

#[test]
fn a_bad_csv_file_is_refused_by_its_own_name_line_and_column() {
    for (index, (csv, place, key, name)) in BAD_TABLES.iter().enumerate() {
        let folder = Folder::new(&format!("bad-{index}"), csv);

        let error = folder
            .load()
            .map(|job| job.name)
            .expect_err("it is refused");

        let told = format!("{}: {error}", String::from_utf8_lossy(csv));
        assert!(error.file.ends_with("table.csv"), "{told}");
        let found = error.place.map(|place| (place.line, place.column));
        assert_eq!(
            (found, error.key.as_deref(), error.name),
            (*place, *key, *name),
            "{told}"
        );
        assert!(error.detail.len() > 10, "{told}");
    }
}

#[test]
fn a_csv_file_that_is_not_there_is_told() {
    let error = parse(&job_of("feed = 600\nfile = \"no-such.csv\"", "")).expect_err("refused");

    assert_eq!(
        (error.key.as_deref(), error.name),
        (Some("path.file"), "BadFile")
    );
    assert!(error.place.is_some(), "{error}");
    assert!(
        error.detail.starts_with("jobs/no-such.csv cannot be read"),
        "{error}"
    );
}

// ---- what is wrong is refused by name, line and key ----

/// Each row: lines below `[path]`, tables behind them, the text on whose line the error is, its key and name.
const BAD_PATHS: &[(&str, &str, &str, &str, &str)] = &[
    ("feed = 60", "", "", "path.points", "MissingField"),
    (
        "points = [[1, 0, 0, 0, 0, 0]]",
        "",
        "",
        "path.feed",
        "MissingField",
    ),
    (
        "feed = 60\npoints = []",
        "",
        "points",
        "path.points",
        "OutOfRange",
    ),
    (
        "feed = 60\npoints = 3",
        "",
        "points",
        "path.points",
        "WrongType",
    ),
    (
        "feed = 60\npoints = [[1, 2, 3]]",
        "",
        "points",
        "path.points[0]",
        "WrongType",
    ),
    (
        "feed = 60\npoints = [\n[1, 0, 0, 0, 0, 0],\n[1, nan, 0, 0, 0, 0]]",
        "",
        "nan",
        "path.points[1][1]",
        "NotFinite",
    ),
    (
        "feed = 60\npoints = [\n[1, 0, 0, 0, 0, 0],\n[1, 0, 0, 0, 0, -100.01]]",
        "",
        "-100.01",
        "path.points[1][5]",
        "OutOfTravel",
    ),
    (
        "feed = 60\npoints = [[1e300, 0, 0, 0, 0, 0]]",
        "",
        "1e300",
        "path.points[0][0]",
        "OutOfRange",
    ),
    (
        "feed = 0\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "feed",
        "path.feed",
        "OutOfRange",
    ),
    (
        "feed = -1\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "feed",
        "path.feed",
        "OutOfRange",
    ),
    (
        "feed = nan\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "feed",
        "path.feed",
        "NotFinite",
    ),
    (
        "feed = 1e10\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "feed",
        "path.feed",
        "OutOfRange",
    ),
    (
        "feed = 1e-6\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "points",
        "path.points[0]",
        "OutOfRange",
    ),
    (
        "feed = 60\ninverse_time = 2\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "inverse_time",
        "path.inverse_time",
        "Contradictory",
    ),
    (
        "feed = 60\nrapid = true\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "rapid",
        "path.rapid",
        "Contradictory",
    ),
    (
        "rapid = 1\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "rapid",
        "path.rapid",
        "WrongType",
    ),
    (
        "feed = 60\npoints = [[1, 0, 0, 0, 0, 0]]\nfile = \"x.csv\"",
        "",
        "file",
        "path.file",
        "Contradictory",
    ),
    (
        "feed = 60\npoints = [[1, 0, 0, 0, 0, 0]]",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]",
        "[[point]]",
        "point",
        "Contradictory",
    ),
    (
        "tolerance = -0.1\nfeed = 60\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "tolerance",
        "path.tolerance",
        "OutOfRange",
    ),
    (
        "rapid_tolerance = 10.1\nfeed = 60\npoints = [[1, 0, 0, 0, 0, 0]]",
        "",
        "rapid_tolerance",
        "path.rapid_tolerance",
        "OutOfRange",
    ),
    ("speed = 3", "", "speed", "path.speed", "UnknownField"),
    ("feed = 60\nfile = 3", "", "file", "path.file", "WrongType"),
    (
        "feed = 60\nfile = \"\"",
        "",
        "file",
        "path.file",
        "WrongType",
    ),
    (
        "feed = 60\nshape = { kind = \"spiral\" }",
        "",
        "shape",
        "path.shape.kind",
        "UnknownName",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 0, chords = 9 }",
        "",
        "shape",
        "path.shape.radius",
        "OutOfRange",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 9, chords = 2 }",
        "",
        "shape",
        "path.shape.chords",
        "OutOfRange",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 9, chords = 1000, turns = 1001 }",
        "",
        "shape",
        "path.shape.turns",
        "OutOfRange",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 9, chords = 9, pitch = 1 }",
        "",
        "shape",
        "path.shape.pitch",
        "UnknownField",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 9, chords = 9, axes = [\"d1\", \"d1\"] }",
        "",
        "shape",
        "path.shape.axes",
        "Contradictory",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 9, chords = 9, axes = [\"d1\", \"d4\"] }",
        "",
        "shape",
        "path.shape.axes[1]",
        "UnknownName",
    ),
    (
        "feed = 60\nshape = { kind = \"circle\", radius = 60, chords = 90 }",
        "",
        "shape",
        "path.shape",
        "OutOfTravel",
    ),
    (
        "",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]\n",
        "",
        "point[0].feed",
        "MissingField",
    ),
    (
        "feed = 60",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]\n[[point]]\nat = [1, 0, 0, 200, 0, 0] # here",
        "here",
        "point[1].at[3]",
        "OutOfTravel",
    ),
    (
        "feed = 60",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]\ndwell = -1",
        "dwell",
        "point[0].dwell",
        "OutOfRange",
    ),
    (
        "feed = 60",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]\nrapid = true\nfeed = 3 # here",
        "rapid",
        "point[0].rapid",
        "Contradictory",
    ),
    (
        "feed = 60",
        "[[point]]\nat = [1, 0, 0, 0, 0, 0]\npause = 1",
        "pause",
        "point[0].pause",
        "UnknownField",
    ),
    (
        "feed = 60",
        "[[line]]\ncounts = 1",
        "[[line]]",
        "line",
        "UnknownField",
    ),
];

#[test]
fn a_bad_path_is_refused_by_line_key_and_name() {
    for (path, tables, on, key, name) in BAD_PATHS {
        let text = job_of(path, tables);

        let error = parse(&text).map(|job| job.name).expect_err("it is refused");

        let told = format!("{path}\n{tables}\n{error}");
        assert_eq!(
            (error.key.as_deref(), error.name),
            (Some(*key), *name),
            "{told}"
        );
        assert_eq!(error.file, "jobs/some.toml", "{told}");
        if !on.is_empty() {
            let below = 1 + text
                .lines()
                .position(|line| line == "[path]")
                .expect("there");
            let line = text
                .lines()
                .skip(below)
                .position(|line| line.contains(on))
                .expect("it stands there");
            let found = error.place.map(|place| place.line);
            assert_eq!(found, Some(1 + below + line), "{told}");
        }
        assert!(error.detail.len() > 10, "{told}");
    }
}

/// Each row: a line of `[machine]` and what stands there instead, the key and the name of the error.
const BAD_MACHINES: &[(&str, &str, &str, &str)] = &[
    (
        "max_rate",
        "[0, 1, 1, 1, 1, 1]",
        "max_rate[0]",
        "OutOfRange",
    ),
    (
        "max_rate",
        "[1, -1, 1, 1, 1, 1]",
        "max_rate[1]",
        "OutOfRange",
    ),
    (
        "max_rate",
        "[1, 1, nan, 1, 1, 1]",
        "max_rate[2]",
        "NotFinite",
    ),
    (
        "max_rate",
        "[1, 1, 1, inf, 1, 1]",
        "max_rate[3]",
        "NotFinite",
    ),
    (
        "max_rate",
        "[1, 1, 1, 1, 3000, 1]",
        "max_rate[4]",
        "OutOfRange",
    ),
    (
        "acceleration",
        "[0, 1, 1, 1, 1, 1]",
        "acceleration[0]",
        "OutOfRange",
    ),
    (
        "acceleration",
        "[500, 500, 500, 500, 500, 1e9]",
        "acceleration[5]",
        "OutOfRange",
    ),
    // More than 100 s to the speed, or to the acceleration.
    (
        "acceleration",
        "[500, 500, 500, 500, 500, 0.1]",
        "max_rate[5]",
        "Contradictory",
    ),
    (
        "jerk",
        "[1, 10000, 10000, 10000, 10000, 10000]",
        "acceleration[0]",
        "Contradictory",
    ),
    (
        "jerk",
        "[1e4, 0, 1e4, 1e4, 1e4, 1e4]",
        "jerk[1]",
        "OutOfRange",
    ),
    (
        "jerk",
        "[1e4, 1e4, nan, 1e4, 1e4, 1e4]",
        "jerk[2]",
        "NotFinite",
    ),
    (
        "jerk",
        "[1e4, 1e4, 1e12, 1e4, 1e4, 1e4]",
        "jerk[2]",
        "OutOfRange",
    ),
    ("jerk", "[1e4, 1e4]", "jerk", "WrongType"),
    (
        "travel",
        "[[0, 0], [0, 1], [0, 1], [0, 1], [0, 1], [0, 1]]",
        "travel[0]",
        "OutOfRange",
    ),
    (
        "travel",
        "[[0, 1], [1, 0], [0, 1], [0, 1], [0, 1], [0, 1]]",
        "travel[1]",
        "OutOfRange",
    ),
    (
        "steps_per_unit",
        "[1e-5, 100, 100, 100, 100, 100]",
        "steps_per_unit[1]",
        "Contradictory",
    ),
    (
        "steps_per_unit",
        "[1e9, 1, 1, 1, 1, 1]",
        "steps_per_unit[0]",
        "OutOfRange",
    ),
];

#[test]
fn bad_limits_are_refused_by_line_key_and_name() {
    for (line, value, key, name) in BAD_MACHINES {
        let right = job_of("feed = 60\npoints = [[1, 0, 0, 0, 0, 0]]", "");
        let text: String = right
            .lines()
            .map(|old| match old.strip_prefix(line) {
                Some(rest) if rest.starts_with(" =") => format!("{line} = {value}\n"),
                _ => format!("{old}\n"),
            })
            .collect();

        let error = parse(&text).map(|job| job.name).expect_err("it is refused");

        let key = format!("machine.{key}");
        assert_eq!(
            (error.key.as_deref(), error.name),
            (Some(key.as_str()), *name),
            "{error}"
        );
        let at = text
            .lines()
            .position(|line| line.starts_with(key[8..].split('[').next().expect("a key")));
        assert_eq!(
            error.place.map(|place| place.line),
            at.map(|n| n + 1),
            "{error}"
        );
    }
}

const BAD_CUES: &[(&str, &str, &str)] = &[
    (
        "at_ms = -1\naction = \"hold\"",
        "cue[0].at_ms",
        "OutOfRange",
    ),
    (
        "at_ms = 1.5\naction = \"hold\"",
        "cue[0].at_ms",
        "WrongType",
    ),
    ("action = \"hold\"", "cue[0].at_ms", "MissingField"),
    (
        "at_ms = 1\naction = \"wait\"",
        "cue[0].action",
        "UnknownName",
    ),
    (
        "at_ms = 1\naction = \"hold\"",
        "cue[0].action",
        "Contradictory",
    ),
    (
        "at_ms = 9\naction = \"hold\"\n[[cue]]\nat_ms = 8\naction = \"resume\"",
        "cue[1].at_ms",
        "OutOfRange",
    ),
    (
        "at_ms = 1\naction = \"feed\"",
        "cue[0].percent",
        "MissingField",
    ),
    (
        "at_ms = 1\naction = \"feed\"\npercent = 9",
        "cue[0].percent",
        "OutOfRange",
    ),
    (
        "at_ms = 1\naction = \"feed\"\npercent = 201",
        "cue[0].percent",
        "OutOfRange",
    ),
    (
        "at_ms = 1\naction = \"rapid\"\npercent = 101",
        "cue[0].percent",
        "OutOfRange",
    ),
    (
        "at_ms = 1\naction = \"stop\"\npercent = 50",
        "cue[0].percent",
        "UnknownField",
    ),
    (
        "at_ms = 1\naction = \"trim\"\nmotor = \"d9\"\nsteps = 1",
        "cue[0].motor",
        "UnknownName",
    ),
    (
        "at_ms = 1\naction = \"trim\"\nmotor = \"d1\"\nsteps = 1",
        "cue[0].action",
        "Contradictory",
    ),
];

#[test]
fn bad_cues_are_refused_by_key_and_name() {
    for (cue, key, name) in BAD_CUES {
        let tables = format!("[[cue]]\n{cue}\n");

        let error = parse(&job_of("feed = 60\npoints = [[1, 0, 0, 0, 0, 0]]", &tables))
            .map(|job| job.name)
            .expect_err("it is refused");

        assert_eq!(
            (error.key.as_deref(), error.name),
            (Some(*key), *name),
            "{error}"
        );
    }
    let many = "[[cue]]\nat_ms = 1\naction = \"resume\"\n".repeat(17);
    let error = parse(&job_of("feed = 60\npoints = [[1, 0, 0, 0, 0, 0]]", &many));
    assert_eq!(
        error.expect_err("refused").key.as_deref(),
        Some("cue[16].at_ms")
    );
}

// ---- what runs ----

#[test]
fn points_at_one_place_reversals_and_moves_of_a_step_are_run_exactly() {
    for tolerance in ["0", "0.01", "1"] {
        let text = job_of(
            &format!(
                "tolerance = {tolerance}\nfeed = 1200\npoints = [\n\
                 [0, 0, 0, 0, 0, 0], [10, 0, 0, 0, 0, 0], [10, 0, 0, 0, 0, 0], [10.000000001, 0, 0, 0, 0, 0],\n\
                 [0, 0, 0, 0, 0, 0], [10, 0, 0, 0, 0, 0], [10.01, 0, 0, 0, 0, 0], [10, 0, 0, 0, 0, 0],\n\
                 [10, 0.01, 0, 0, 0, 0], [10, 0.01, 0, 5, 0, -5], [10, 0.01, 0, 5, 0.01, -5]]"
            ),
            "",
        );

        let (job, outcome) = ran(&text);

        let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
        assert_sound(&figures);
        assert_eq!(outcome.counts, [1000, 1, 0, 500, 1, -500]);
        if tolerance == "0" {
            // There, back, there, a step on and back: no way is cut short.
            assert_eq!(figures.motors.figures[0].statistics.steps(), 3002);
        }
    }
}

#[test]
fn a_path_that_moves_nothing_ends_where_it_began() {
    let (job, outcome) = ran(&job_of("feed = 60\npoints = [[0, 0, 0, 0, 0, 1e-9]]", ""));

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    assert!(figures.is_sound());
    assert_eq!(outcome.trace.pulses().count(), 0);
    // It is told like any other.
    assert!(!figures.html().contains("NaN"));
}

#[test]
fn a_feed_beyond_all_limits_runs_at_the_limits() {
    let (job, outcome) = ran(&job_of("feed = 1e9\npoints = [[50, 0, 0, 0, 0, 0]]", ""));

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    assert_sound(&figures);
    // Rest to rest with v 50, a 500, j 10 000: L/v + v/a + a/j, but for the first and the last half step, j t^3 / 6 long.
    let half = (6.0f64 * 0.005 / 10_000.0).cbrt();
    let time = 50.0 / 50.0 + 50.0 / 500.0 + 500.0 / 10_000.0 - 2.0 * half;
    assert!((figures.time() - time).abs() < 0.003, "{}", figures.time());
}

#[test]
fn an_inverse_time_gives_a_block_its_time_and_a_dwell_stands_still() {
    let text = job_of(
        "inverse_time = 30\ntolerance = 0.01",
        "[[point]]\nat = [20, 0, 0, 40, 0, 0]\ndwell = 1.5\n[[point]]\nat = [0, 0, 0, 0, 0, 10]\n",
    );

    let (job, outcome) = ran(&text);

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    assert_sound(&figures);
    // Twice 2 s, of which theta1 makes 20 deg/s: v/a + a/j more for its ramps, each time.
    let ramps = 20.0 / 500.0 + 500.0 / 10_000.0;
    let most = 5.5 + 2.0 * ramps;
    assert!(
        figures.time() >= 5.45 && figures.time() <= most + 0.02,
        "{} s, {most} expected",
        figures.time()
    );
    assert!((figures.programmed() - 5.5).abs() < 1e-9);
}

#[test]
fn the_circle_takes_its_length_over_feed_and_the_ramps() {
    let (job, outcome) = ran(CIRCLE);

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    assert_sound(&figures);
    // 50 mm/s with 1000 mm/s2 and 20 000 mm/s3: two ramps, each half of which is lost.
    let ideal = std::f64::consts::TAU * 50.0 / 50.0 + 50.0 / 1000.0 + 1000.0 / 20_000.0;
    let time = figures.time();
    println!(
        "circle: {time:.3} s, {:.4} of length/feed and ramps",
        time / ideal
    );
    assert!(
        time <= 1.05 * ideal && time >= 0.995 * ideal,
        "{time} s, {ideal} s expected"
    );
}

#[test]
fn the_trochoid_takes_its_inverse_times_and_the_ramps() {
    let (job, outcome) = ran(TROCHOID);

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    assert_sound(&figures);
    // It starts and ends at 23.3 mm/s with 500 mm/s2 and 10 000 mm/s3.
    let ideal = 24.0 + 23.3 / 500.0 + 500.0 / 10_000.0;
    let time = figures.time();
    println!(
        "trochoid: {time:.3} s, {:.4} of the times and ramps",
        time / ideal
    );
    assert!(
        time <= 1.05 * ideal && time >= 0.995 * ideal,
        "{time} s, {ideal} s expected"
    );
}

#[test]
fn the_moves_from_stop_to_stop_take_the_optimal_times() {
    let (job, outcome) = ran(STOPS);

    let path = path_of(&job);
    let figures = PathFigures::of(&job, path, &outcome, 1.0);
    assert_sound(&figures);
    // Every move alone, along its straight line, by the joint that takes longest: L/v + v/a + a/j holds for all of them,
    // as each is long enough to reach its speed; a move with a feed takes at least its time, and its ramps.
    let mut from = [0.0; 6];
    let mut ideal = 0.0;
    for (point, block) in path.points.iter().zip(&path.blocks) {
        let way: Vec<f64> = (0..6).map(|i| (point.at[i] - from[i]).abs()).collect();
        let least = |limit: &dyn Fn(usize) -> f64| {
            (0..6)
                .filter(|i| way[*i] > 0.0)
                .map(|i| limit(i) / way[i])
                .fold(f64::INFINITY, f64::min)
        };
        // As shares of the way: speed, acceleration and jerk.
        let mut v = least(&|i| path.axes[i].max_rate);
        let a = least(&|i| path.axes[i].acceleration);
        let j = least(&|i| path.axes[i].jerk);
        if block.duration > 0.0 {
            v = v.min(1.0 / block.duration);
        }
        ideal += 1.0 / v + v / a + a / j + point.dwell;
        from = point.at;
    }
    // A move that is so short that it never runs at a steady speed would differ.
    let bounds = figures.bounds;
    assert!((bounds.rest - ideal).abs() < 1e-6 * ideal, "{bounds:?}");
    assert!(bounds.feed < bounds.rest);
    let time = figures.time();
    println!(
        "stop to stop: {time:.3} s, {:.4} of the optimum",
        time / ideal
    );
    assert!(
        time <= 1.01 * ideal && time >= 0.99 * ideal,
        "{time} s, {ideal} s expected"
    );
}

#[test]
fn a_hold_and_its_resume_lead_to_the_same_end_on_the_same_path() {
    let shape = "feed = 1800\nshape = { kind = \"circle\", radius = 20, chords = 2000 }";
    let (_, plain) = ran(&job_of(shape, ""));
    for at in [40, 700, 2500, 4150] {
        let cues = format!(
            "[[cue]]\nat_ms = {at}\naction = \"hold\"\n[[cue]]\nat_ms = {}\naction = \"resume\"\n",
            at + 600
        );

        let (job, held) = ran(&job_of(shape, &cues));

        let path = path_of(&job);
        assert_eq!(
            path.cues[0],
            Cue {
                at,
                action: Action::Hold
            }
        );
        let figures = PathFigures::of(&job, path, &held, 1.0);
        assert_sound(&figures);
        assert_eq!(held.counts, plain.counts);
        let longer = seconds(held.trace.end()) - seconds(plain.trace.end());
        // It stands for what the stop and the start of 0.1 s each leave of the 0.6 s.
        assert!(
            (0.3..0.9).contains(&longer),
            "{longer} s longer for a hold at {at} ms"
        );
        // The same steps in the same order for each motor; only their times differ.
        for motor in 0..6 {
            let signs = |outcome: &Outcome| -> Vec<i8> {
                outcome
                    .trace
                    .steps_of(motor)
                    .map(|step| step.sign)
                    .collect()
            };
            assert_eq!(
                signs(&held),
                signs(&plain),
                "motor {motor}, hold at {at} ms"
            );
        }
    }
}

#[test]
fn an_override_changes_the_time_and_not_the_path() {
    let shape = "feed = 900\nshape = { kind = \"circle\", radius = 20, chords = 2000 }";
    // A thousand steps a unit: with a hundred it is the grid of whole steps that limits the speed.
    let fine = |text: String| {
        text.replace(
            "[100, 100, 100, 100, 100, 100]",
            "[1e3, 1e3, 1e3, 1e3, 1e3, 1e3]",
        )
    };
    let (_, plain) = ran(&fine(job_of(shape, "")));
    let cue = "[[cue]]\nat_ms = 0\naction = \"feed\"\npercent = 200\n";

    let (job, fast) = ran(&fine(job_of(shape, cue)));

    assert_sound(&PathFigures::of(&job, path_of(&job), &fast, 1.0));
    let ratio = seconds(plain.trace.end()) / seconds(fast.trace.end());
    assert!((1.9..2.0).contains(&ratio), "{ratio}");
}

#[test]
fn a_stop_rests_on_the_path_and_drops_the_rest() {
    let cue = "[[cue]]\nat_ms = 1000\naction = \"stop\"\n";

    let (job, outcome) = ran(&job_of("feed = 600\npoints = [[50, 25, 0, 0, 0, 0]]", cue));

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    assert!(figures.is_sound(), "{:?}", outcome.counts);
    // About 1 s at 10 mm/s.
    assert!(
        (800..1000).contains(&outcome.counts[0]),
        "{:?}",
        outcome.counts
    );
    assert_eq!(outcome.counts.map(i64::from), outcome.trace.positions());
    assert_eq!((outcome.counts[0] - 2 * outcome.counts[1]).abs() / 2, 0);
}

#[test]
fn a_trim_offsets_its_motor_by_whole_steps_beside_the_path() {
    let text = job_of(
        "feed = 600\npoints = [[50, 25, 0, 0, 0, 0]]",
        "[[cue]]\nat_ms = 1000\naction = \"trim\"\nmotor = \"d3\"\nsteps = -7\n",
    )
    .replace("[path]", "trim_share = 0.1\n[path]");

    let (job, outcome) = ran(&text);

    assert_eq!(outcome.trace.positions(), [5000, 2500, -7, 0, 0, 0]);
    assert!(PathFigures::of(&job, path_of(&job), &outcome, 1.0).is_sound());
}

// ---- what is told ----

#[test]
fn the_report_shows_every_joint_that_moves_with_its_limits_and_the_contour() {
    let (job, outcome) = ran(&job_of(
        "feed = 1200\npoints = [[20, 0, 0, 0, 0, 0], [20, 10, 0, 30, 0, 0]]",
        "",
    ));

    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    let html = figures.html();

    for joint in ["d1", "d2", "theta1"] {
        for quantity in ["position", "speed", "acceleration", "jerk"] {
            assert!(
                html.contains(&format!("{joint}: {quantity}")),
                "{joint} {quantity}"
            );
        }
    }
    assert!(!html.contains("d3: speed"));
    assert!(html.contains("At rest all the time: d3, theta2, theta3."));
    assert!(html.contains("Contour error") && html.contains("tolerance and a step"));
    // Three joints with two limit lines each for speed, acceleration and jerk; the labels of the first of each pair.
    assert_eq!(html.matches(">limit</text>").count(), 9);
    assert!(!html.contains("NaN") && !html.contains("inf "));
    assert!(figures.summary().len() <= 20);
}

#[test]
fn a_contour_that_is_left_is_told() {
    // Run with a tolerance of 1 mm, judged as if it had been 0.01 mm: the corner is cut by more.
    let points = "feed = 1200\npoints = [[30, 0, 0, 0, 0, 0], [30, 30, 0, 0, 0, 0]]";
    let wide = parse(&job_of(&format!("tolerance = 1\n{points}"), "")).expect("right");
    let outcome = run::run(&wide, &mut |_, _| {}).expect("runs");
    let tight = parse(&job_of(&format!("tolerance = 0.01\n{points}"), "")).expect("right");

    let figures = PathFigures::of(&tight, path_of(&tight), &outcome, 1.0);

    assert!(figures.contour.largest > 0.1, "{}", figures.contour.largest);
    assert!(!figures.keeps_contour() && !figures.is_sound());
    let as_run = PathFigures::of(&wide, path_of(&wide), &outcome, 1.0);
    assert!(as_run.is_sound());
    // Nearest to the corner when the tolerance is just used: a corner of 90 degrees, cut by at most 1 mm and a step.
    assert!(as_run.contour.largest <= 1.0 + 0.02);
}

/// Legs that turn by 170 degrees lie beside each other for a long way, a little more than a step apart near the corners.
#[test]
fn a_star_of_sharp_corners_is_compared_leg_by_leg() {
    let mut at = [0.0f64; 2];
    let legs: Vec<String> = (0..36)
        .map(|k| {
            let (s, c) = (170.0 * f64::from(k)).to_radians().sin_cos();
            at = [at[0] + 40.0 * c, at[1] + 40.0 * s];
            format!("[{:.5}, {:.5}, 0, 0, 0, 0]", at[0], at[1])
        })
        .collect();
    let machine = MACHINE
        .replace("[100, 100, 100,", "[80, 80, 80,")
        .replace("[50, 50, 50,", "[200, 200, 200,");
    let text = format!(
        "kind = \"path\"\n{machine}[path]\nfeed = 6000\npoints = [{}]\n",
        legs.join(", ")
    );

    let (job, outcome) = ran(&text);
    let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);

    assert!(figures.contour.largest <= figures.allowed());
    assert!(figures.contour.cut <= figures.contour.largest);
    assert!(figures.keeps_contour());
}

/// One verdict wherever a job is judged: by limits, too, with the motor, the time and the place.
#[test]
fn limits_that_are_exceeded_are_told_with_motor_time_and_place() {
    let points = "feed = 2400\npoints = [[30, 10, 0, 0, 0, 0]]";
    let job = parse(&job_of(points, "")).expect("right");
    let outcome = run::run(&job, &mut |_, _| {}).expect("runs");
    let slow = MACHINE.replace("[50, 50, 50,", "[50, 8, 50,");
    let slow = format!("kind = \"path\"\n{slow}[path]\n{points}\n");
    let slow = parse(&slow).expect("right");

    let kept = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
    let exceeded = PathFigures::of(&slow, path_of(&slow), &outcome, 1.0);

    assert!(kept.is_sound() && kept.summary()[0].contains("as it should be"));
    assert!(!exceeded.is_sound());
    // 40 mm/s along a line whose second joint takes a part of 1 / sqrt 10.
    let verdict = &exceeded.summary()[0];
    for part in [
        "WRONG",
        "d2 has 12.65 mm/s of speed for 8.00",
        "8.16 allowed",
        "where d1 ",
    ] {
        assert!(verdict.contains(part), "{part} in {verdict}");
    }
    let html = exceeded.html();
    assert!(html.contains("12.65 of 8.00, allowed 8.16") && html.contains("WRONG: d2 has"));
}

#[test]
fn pins_are_shown_where_motors_step() {
    // At rest in the middle of the time.
    let (job, outcome) = ran(&job_of(
        "feed = 1200",
        "[[point]]\nat = [5, 0, 0, 0, 0, 0]\ndwell = 30\n[[point]]\nat = [9, 3, 0, 0, 0, 0]\n",
    ));

    let html = PathFigures::of(&job, path_of(&job), &outcome, 1.0).html();

    let pins = html.split("aria-label=\"Pins\"").nth(1).expect("a figure");
    let pins = pins.split("</svg>").next().expect("its end");
    // A lane at rest is a line from left to right; both motors of the last move step.
    let moves = |lane: &&str| {
        lane.split('"')
            .next()
            .is_some_and(|data| data.matches('L').count() > 2)
    };
    assert!(
        pins.split("<path d=\"").skip(1).filter(moves).count() >= 2,
        "{pins}"
    );
}

#[test]
fn what_ruled_is_the_feed_or_the_limit_that_a_joint_was_at() {
    let shares = |text: &str| {
        let (job, outcome) = ran(text);
        let figures = PathFigures::of(&job, path_of(&job), &outcome, 1.0);
        let times = figures.ruling.times();
        let all: f64 = times.iter().map(|(_, time)| time).sum();
        assert!(
            (all - figures.time()).abs() < 0.01,
            "{all} of {}",
            figures.time()
        );
        let (first, time) = times[0];
        (first, time / all, figures.html())
    };

    // 5 s at 10 mm/s and ramps of a tenth of a second; then two joints of which the second is the slower.
    let (by_feed, share, html) = shares(&job_of("feed = 600\npoints = [[50, 0, 0, 0, 0, 0]]", ""));
    let (by_joint, other, _) = shares(&job_of("rapid = true\npoints = [[20, 80, 0, 0, 0, 0]]", ""));
    // Corners all along: jerk.
    let zigzag: Vec<String> = (1..60)
        .map(|k| format!("[{}, {}, 0, 0, 0, 0]", k, k % 2))
        .collect();
    let (by_jerk, most, _) = shares(&job_of(
        &format!("feed = 3000\npoints = [{}]", zigzag.join(", ")),
        "",
    ));

    assert_eq!(by_feed, Ruler::Feed);
    assert!(share > 0.95, "{share}");
    assert!(html.contains("What ruled") && html.contains("What ruled for how long"));
    assert_eq!(by_joint, Ruler::Joint(1, Limit::Velocity));
    assert!(other > 0.8, "{other}");
    assert!(
        matches!(by_jerk, Ruler::Joint(_, Limit::Jerk)),
        "{by_jerk:?}"
    );
    assert!(most > 0.4, "{most}");
}
