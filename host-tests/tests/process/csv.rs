//! Points of a process from a CSV file beside the job: the same as those in the job, and every fault with its place.

use crate::common::{Folder, with};
use hexstep_host::job::{Job, JobError, Task};
use hexstep_host::run::run;

const PLANE: &str = include_str!("../../jobs/precession-plane.toml");
const CURVED: &str = include_str!("../../jobs/precession-curved.toml");
const SHELL: &str = include_str!("../../jobs/shell-soft.toml");

/// The text without the array at `key`, whose closing bracket stands alone or on its line.
#[track_caller]
fn without(text: &str, key: &str) -> String {
    let start = text.find(&format!("\n{key} = [")).expect("the key") + 1;
    let line = text[start..].lines().next().expect("a line");
    let end = if line.ends_with("]]") {
        start + line.len()
    } else {
        start + text[start..].find("\n]").expect("its end") + 2
    };
    format!("{}{}", &text[..start], &text[end + 1..])
}

/// A job that reads its points from `points.csv` in the place of its own.
fn with_file(text: &str, table: &str, keys: &[&str]) -> String {
    let text = keys
        .iter()
        .fold(text.to_string(), |text, key| without(&text, key));
    let head = format!("[{table}]\n");
    text.replacen(&head, &format!("{head}points_csv = \"points.csv\"\n"), 1)
}

fn load(folder: &Folder, job: &str, csv: &[u8]) -> Result<Job, JobError> {
    std::fs::write(folder.0.join("points.csv"), csv).expect("written");
    std::fs::write(folder.0.join("some.toml"), job).expect("written");
    Job::load(&folder.0.join("some.toml"))
}

/// Each fault: the file, its line and column, the key and the name of the error.
type Fault = (
    &'static str,
    Option<(usize, usize)>,
    Option<&'static str>,
    &'static str,
);

#[track_caller]
fn refused(folder: &Folder, job: &str, (csv, place, key, name): &Fault) {
    let error = load(folder, job, csv.as_bytes())
        .map(|job| job.name)
        .expect_err(csv);

    let told = format!("{csv}: {error}");
    assert!(error.file.ends_with("points.csv"), "{told}");
    let found = error.place.map(|place| (place.line, place.column));
    assert_eq!(
        (found, error.key.as_deref(), error.name),
        (*place, *key, *name),
        "{told}"
    );
    assert!(error.detail.len() > 15, "{told}");
}

/// What is refused whatever the file is for, at the key of the job that names it.
#[track_caller]
fn refused_at_the_key(folder: &Folder, job: &str, table: &str, other: &str) {
    let key = format!("{table}.points_csv");
    let there = load(folder, job, b"\xff\xfe")
        .map(|job| job.name)
        .expect_err("no text");
    assert_eq!((there.name, there.place), ("BadFile", None), "{there}");
    assert!(there.file.ends_with("points.csv"), "{there}");

    let elsewhere = job.replace("points.csv", "no/such.csv");
    let missing = load(folder, &elsewhere, b"")
        .map(|job| job.name)
        .expect_err("no file");
    assert_eq!(
        (missing.name, missing.key.as_deref()),
        ("BadFile", Some(key.as_str())),
        "{missing}"
    );
    let path = folder.0.join("no/such.csv").display().to_string();
    assert!(missing.detail.contains(&path), "{missing}");
    let line = 1 + elsewhere
        .lines()
        .position(|l| l.contains("no/such.csv"))
        .expect("it");
    assert_eq!(missing.place.map(|place| place.line), Some(line));

    let head = format!("[{table}]\n");
    let both = job.replacen(&head, &format!("{head}{other}\n"), 1);
    let both = load(folder, &both, b"")
        .map(|job| job.name)
        .expect_err("both");
    assert_eq!(both.name, "Contradictory", "{both}");

    let number = job.replace("\"points.csv\"", "3");
    let number = load(folder, &number, b"")
        .map(|job| job.name)
        .expect_err("a number");
    assert_eq!((number.name, number.key), ("WrongType", Some(key)));
}

fn contacts(job: &Job) -> Vec<[f64; 6]> {
    let Task::Precession(precession) = &job.task else {
        panic!("a precession")
    };
    let six = |p: [f64; 3], n: [f64; 3]| [p[0], p[1], p[2], n[0], n[1], n[2]];
    let contacts = precession.contacts.iter();
    contacts
        .map(|c| six(c.p.to_array(), c.n.to_array()))
        .collect()
}

#[test]
fn a_path_of_precession_from_a_file_is_the_one_that_stands_in_the_job() {
    let folder = Folder::new("precession-csv");
    let inline = Job::parse("some.toml", "some", CURVED.as_bytes()).expect("delivered");
    let mut csv = String::from("# a spreadsheet may change the order\nnx,ny,nz, x,y,z\r\n");
    for [x, y, z, nx, ny, nz] in contacts(&inline) {
        csv.push_str(&format!("{nx},{ny},{nz}, {x},{y},{z}\r\n\r\n"));
    }

    let job = with_file(CURVED, "path", &["points", "normals"]);
    let loaded = load(&folder, &job, csv.as_bytes()).expect("it is right");

    assert_eq!(contacts(&loaded), contacts(&inline));
    assert_eq!(contacts(&loaded).len(), 13);
}

#[test]
fn a_bad_file_of_a_precession_is_refused_by_line_and_column() {
    let folder = Folder::new("precession-bad-csv");
    let job = with_file(PLANE, "path", &["points", "normals"]);
    for fault in [
        ("", None, None, "OutOfRange"),
        ("# nothing\n", None, None, "OutOfRange"),
        ("x,y,z,nx,ny,nz\n", None, Some("points"), "BadPath"),
        ("x,y,z,nx,ny,k\n", Some((1, 13)), Some("k"), "UnknownField"),
        ("x,y,z,nx,ny,x\n", Some((1, 13)), Some("x"), "Contradictory"),
        ("x,y,z,nx,ny\n", Some((1, 1)), Some("nz"), "MissingField"),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n1,0,0,0,0\n",
            Some((3, 1)),
            None,
            "WrongType",
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n\n1, two,0,0,0,1\n",
            Some((4, 4)),
            Some("y"),
            "WrongType",
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n1,,0,0,0,1\n",
            Some((3, 3)),
            Some("y"),
            "WrongType",
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n1,nan,0,0,0,1\n",
            Some((3, 1)),
            Some("points[1]"),
            "NonFinite",
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n1,0,0,0,0,inf\n",
            Some((3, 7)),
            Some("normals[1]"),
            "BadNormal",
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n9,0,0,0,0,0\n",
            Some((3, 7)),
            Some("normals[1]"),
            "BadNormal",
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n9,0,0,0,0,-1\n",
            Some((3, 7)),
            Some("normals[1]"),
            "AntiParallel",
        ),
    ] {
        refused(&folder, &job, &fault);
    }
    refused_at_the_key(&folder, &job, "path", "normals = [[0, 0, 1]]");
    // One point needs a dwell, which is a key of the job.
    let error = load(&folder, &job, b"x,y,z,nx,ny,nz\n0,0,0,0,0,1\n").map(|job| job.name);
    let error = error.expect_err("no dwell");
    assert_eq!(
        (error.name, error.key.as_deref()),
        ("BadDwell", Some("polishing.dwell"))
    );
    // What shows only on the machine names the file's key as well.
    let far = load(
        &folder,
        &job,
        b"x,y,z,nx,ny,nz\n0,0,0,0,0,1\n9000,0,0,0,0,1\n",
    )
    .expect("read");
    let error = run(&far, &mut |_, _| {}).expect_err("out of reach");
    assert_eq!(error.key.as_deref(), Some("path.points_csv"), "{error}");
    assert!(error.place.is_some(), "{error}");
}

fn net(job: &Job) -> Vec<[f64; 3]> {
    let Task::Surface(surface) = &job.task else {
        panic!("a surface")
    };
    let places =
        (0..=10).flat_map(|i| (0..=10).map(move |j| (0.1 * f64::from(i), 0.1 * f64::from(j))));
    let at = |(u, v)| surface.part.jet(u, v).expect("inside").s.to_array();
    places.map(at).collect()
}

/// The control points of the shell as a file, by columns.
fn shell_rows() -> Vec<String> {
    let start = SHELL.find("points = [").expect("the net");
    let rows = SHELL[start..].lines().skip(1).take_while(|l| *l != "]");
    let mut found = Vec::new();
    for (i, row) in rows.enumerate() {
        for (j, point) in row.split("], [").enumerate() {
            let point = point.trim_matches([' ', '[', ']', ',']).replace(' ', "");
            found.push(format!("{i},{j},{point}"));
        }
    }
    found
}

#[test]
fn a_net_from_a_file_is_the_one_that_stands_in_the_job_in_any_order_and_with_weights() {
    let folder = Folder::new("net-csv");
    let inline = Job::parse("some.toml", "some", SHELL.as_bytes()).expect("delivered");
    let job = with_file(SHELL, "surface", &["points"]);
    let mut rows = shell_rows();
    assert_eq!(rows.len(), 42);
    let plain = format!("i,j,x,y,z\n{}\n", rows.join("\n"));
    rows.reverse();
    let even = format!("i,j,x,y,z,w\n{},2.5\n", rows.join(",2.5\n"));
    let weighted = even.replacen(",2.5\n", ",5\n", 3);

    for csv in [&plain, &even] {
        let loaded = load(&folder, &job, csv.as_bytes()).expect("it is right");
        for (a, b) in net(&loaded)
            .iter()
            .flatten()
            .zip(net(&inline).iter().flatten())
        {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
    let other = load(&folder, &job, weighted.as_bytes()).expect("it is right");
    assert_ne!(net(&other), net(&inline));
}

#[test]
fn a_bad_file_of_a_net_is_refused_by_line_and_column() {
    let folder = Folder::new("net-bad-csv");
    let job = with_file(SHELL, "surface", &["points"]);
    for fault in [
        ("", None, None, "OutOfRange"),
        ("i,j,x,y\n", Some((1, 1)), Some("z"), "MissingField"),
        ("i,j,x,y,z,u\n", Some((1, 11)), Some("u"), "UnknownField"),
        ("i,j,x,y,z,i\n", Some((1, 11)), Some("i"), "Contradictory"),
        ("i,j,x,y,z\n0,0,0,0\n", Some((2, 1)), None, "WrongType"),
        (
            "i,j,x,y,z\n0,0,0,0,0\n0,1,0,O,0\n",
            Some((3, 7)),
            Some("y"),
            "WrongType",
        ),
        (
            "i,j,x,y,z\n0,0,0,0,0\n0,0,1,1,1\n",
            Some((3, 1)),
            Some("i"),
            "BadNet",
        ),
        ("i,j,x,y,z\n0,32,0,0,0\n", Some((2, 3)), Some("j"), "BadNet"),
        (
            "i,j,x,y,z\n0.5,0,0,0,0\n",
            Some((2, 1)),
            Some("i"),
            "BadNet",
        ),
        ("i,j,x,y,z\n-1,0,0,0,0\n", Some((2, 1)), Some("i"), "BadNet"),
        (
            "i,j,x,y,z\n0,nan,0,0,0\n",
            Some((2, 3)),
            Some("j"),
            "BadNet",
        ),
        (
            "i,j,x,y,z\n0,0,0,nan,0\n",
            Some((2, 7)),
            Some("y"),
            "BadNet",
        ),
        (
            "i,j,x,y,z,w\n0,0,0,0,0,0\n",
            Some((2, 11)),
            Some("w"),
            "BadWeight",
        ),
        (
            "i,j,x,y,z,w\n0,0,0,0,0,inf\n",
            Some((2, 11)),
            Some("w"),
            "BadWeight",
        ),
        ("i,j,x,y,z\n0,0,0,0,0\n1,1,1,1,1\n", None, None, "BadNet"),
    ] {
        refused(&folder, &job, &fault);
    }
    refused_at_the_key(&folder, &job, "surface", "weights = [[1]]");
    // Too few for the degree, and none at all: of the net as a whole.
    for csv in ["i,j,x,y,z\n0,0,0,0,0\n", "i,j,x,y,z\n"] {
        let error = load(&folder, &job, csv.as_bytes())
            .map(|job| job.name)
            .expect_err(csv);
        assert_eq!(
            (error.name, error.key.as_deref()),
            ("BadNet", Some("surface.points_csv"))
        );
    }
    let shell = format!("i,j,x,y,z\n{}\n", shell_rows().join("\n"));
    let knots = with(&job, "knots_u", "knots_u = [0, 0, 1, 1]");
    let error = load(&folder, &knots, shell.as_bytes())
        .map(|job| job.name)
        .expect_err("knots");
    assert_eq!(
        (error.name, error.key.as_deref()),
        ("BadKnots", Some("surface.knots_u"))
    );
}
