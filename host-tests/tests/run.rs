//! The command line: what it writes, what it refuses, and that nothing is left behind when it does.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own for one test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("hexstep-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("made");
        Self(path)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.0.join(name), bytes).expect("written");
    }

    /// Every file below, seen from here.
    fn files(&self) -> Vec<String> {
        fn walk(folder: &Path, root: &Path, found: &mut Vec<String>) {
            for entry in std::fs::read_dir(folder).expect("a folder") {
                let path = entry.expect("an entry").path();
                if path.is_dir() {
                    walk(&path, root, found);
                } else {
                    let short = path.strip_prefix(root).expect("below").to_string_lossy();
                    found.push(short.replace('\\', "/"));
                }
            }
        }
        let mut found = Vec::new();
        walk(&self.0, &self.0, &mut found);
        found.sort();
        found
    }

    /// The program, called here.
    fn hexstep(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_hexstep"))
            .args(arguments)
            .current_dir(&self.0)
            .output()
            .expect("it starts")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("text")
}

#[test]
fn a_delivered_job_runs_from_any_folder_and_writes_three_files() {
    let folder = Folder::new("counts");

    let output = folder.hexstep(&["run", "counts"]);

    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let base = "target/hexstep/counts";
    assert_eq!(
        folder.files(),
        ["report.html", "trace.csv", "trace.vcd"].map(|name| format!("{base}/{name}"))
    );
    let summary = text(&output.stdout);
    assert!(
        summary.contains(&format!("{base}/report.html")),
        "{summary}"
    );
    assert!(summary.lines().count() <= 45, "one screen");
}

#[test]
fn the_edges_in_the_waves_are_as_many_as_the_summary_says() {
    let folder = Folder::new("edges");
    folder.write(
        "some.toml",
        b"kind = \"counts\"\n[[line]]\ncounts = [900, -70, 0, 33, 1, -899]\nduration = 0.05\n",
    );

    let output = folder.hexstep(&["run", "some.toml", "--out", "here"]);

    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let vcd = std::fs::read_to_string(folder.0.join("here/trace.vcd")).expect("written");
    let summary = text(&output.stdout);
    for (name, count) in [
        ("d1", 900),
        ("d2", 70),
        ("d3", 0),
        ("theta1", 33),
        ("theta2", 1),
        ("theta3", 899),
    ] {
        // $var wire 1 CODE step_NAME $end
        let definition = vcd
            .lines()
            .find(|line| line.contains(&format!(" step_{name} ")));
        let code = definition
            .expect("defined")
            .split(' ')
            .nth(3)
            .expect("a code");
        let body = vcd.split("$enddefinitions").nth(1).expect("a body");
        let rises = body
            .lines()
            .filter(|line| *line == format!("1{code}"))
            .count();
        assert_eq!(rises, count, "{name}");
        assert!(summary.contains(&format!("{name} {count}")), "{summary}");
    }
    let rows = std::fs::read_to_string(folder.0.join("here/trace.csv")).expect("written");
    assert_eq!(rows.lines().count(), 1 + 900 + 70 + 33 + 1 + 899);
}

#[test]
fn bad_jobs_end_with_status_2_and_leave_nothing_behind() {
    let drill = include_str!("../jobs/drill-point.toml");
    let beyond = drill.replace("[-100, 200]", "[-100, 100]");
    let small = drill.replace("clearance = 10 ", "clearance = 4 ");
    let cases: [(&str, &[u8], &[&str]); 8] = [
        ("empty.toml", b"", &["empty.toml: BadFile"]),
        (
            "binary.toml",
            b"\x7fELF\x02\x01\x01\0\xff\xfe\xfd",
            &["binary.toml", "BadFile"],
        ),
        (
            "nan.toml",
            b"kind = \"counts\"\n[[line]]\ncounts = [1,2,3,4,5,6]\nduration = nan\n",
            &["nan.toml:4:12: line[0].duration: NotFinite"],
        ),
        (
            "key.toml",
            b"kind = \"counts\"\nspeed = 3\n",
            &["key.toml:2:1: speed: UnknownField"],
        ),
        (
            "range.toml",
            b"kind = \"counts\"\n[[line]]\ncounts = [99999999999,2,3,4,5,6]\nduration = 1\n",
            &["range.toml:3:11: line[0].counts[0]: OutOfRange"],
        ),
        (
            "syntax.toml",
            b"kind = counts\n",
            &["syntax.toml:1:", "BadToml"],
        ),
        (
            "small.toml",
            small.as_bytes(),
            &[
                "small.toml:",
                "drill.clearance: ClearanceTooSmall",
                "5.649863",
            ],
        ),
        (
            "travel.toml",
            beyond.as_bytes(),
            &["travel.toml:", "machine.travel[5]: OutOfTravel"],
        ),
    ];
    for (name, bytes, told) in cases {
        let folder = Folder::new(name);
        folder.write(name, bytes);

        let output = folder.hexstep(&["run", name, "--out", "results"]);

        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{name}: {error}");
        for part in told {
            assert!(error.contains(part), "{name}: {error}");
        }
        assert!(output.stdout.is_empty(), "{name}");
        assert_eq!(folder.files(), [name], "{name} leaves nothing behind");
    }
}

#[test]
fn a_missing_job_and_a_wrong_option_are_bad_input_too() {
    let folder = Folder::new("missing");

    for arguments in [
        &["run", "no-such-job"][..],
        &["run"],
        &["walk"],
        &["run", "counts", "--trace", "some"],
    ] {
        let output = folder.hexstep(arguments);

        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(!output.stderr.is_empty());
    }
    assert!(folder.files().is_empty());
}

#[test]
fn results_that_cannot_be_written_are_told_and_end_with_status_1() {
    let folder = Folder::new("blocked");
    folder.write("file", b"in the way");
    folder.write(
        "some.toml",
        b"kind = \"counts\"\n[[line]]\ncounts = [9,0,0,0,0,0]\nduration = 0.01\n",
    );

    let output = folder.hexstep(&["run", "some.toml", "--out", "file/results"]);

    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("--out"));
    assert_eq!(folder.files(), ["file", "some.toml"]);
}

#[test]
fn the_delivered_jobs_are_listed_and_help_shows_examples() {
    let folder = Folder::new("list");

    let list = text(&folder.hexstep(&["list"]).stdout);
    let help = text(&folder.hexstep(&["--help"]).stdout);
    let run_help = text(&folder.hexstep(&["run", "--help"]).stdout);

    for name in [
        "drill-point",
        "counts",
        "dune-hard",
        "precession-plane",
        "mirror-panel",
    ] {
        let lines = list.lines().filter(|line| line.starts_with(name));
        assert_eq!(lines.count(), 1, "{name} in\n{list}");
    }
    assert!(list.lines().all(|line| line.len() > 40), "{list}");
    assert!(
        help.contains("Examples:") && help.contains("hexstep run"),
        "{help}"
    );
    assert!(run_help.contains("Exit status"), "{run_help}");
}

#[test]
fn the_trace_can_be_left_out() {
    let folder = Folder::new("no-trace");
    folder.write(
        "some.toml",
        b"kind = \"counts\"\n[[line]]\ncounts = [9,0,0,0,0,0]\nduration = 0.01\n",
    );

    let output = folder.hexstep(&["run", "some.toml", "--trace", "none", "--out", "out"]);

    assert_eq!(output.status.code(), Some(0));
    assert_eq!(folder.files(), ["out/report.html", "some.toml"]);
}

#[test]
fn a_path_in_a_table_beside_its_job_runs_or_is_refused_by_the_tables_own_line() {
    let folder = Folder::new("table");
    let circle = include_str!("../jobs/circle.toml");
    let job: String = circle
        .lines()
        .map(|line| match line.starts_with("shape") {
            true => "file = \"table.csv\"\n".into(),
            false => format!("{line}\n"),
        })
        .collect();
    std::fs::create_dir_all(folder.0.join("jobs")).expect("made");
    folder.write("jobs/some.toml", job.as_bytes());
    folder.write("jobs/table.csv", b"d1,theta1,F\n-1,2,\n-2,,60\n");

    let right = folder.hexstep(&["run", "jobs/some.toml", "--trace", "none", "--out", "out"]);
    folder.write("jobs/table.csv", b"d1,theta1,F\n-1,2,\n-2,91,60\n");
    let wrong = folder.hexstep(&["run", "jobs/some.toml", "--out", "none"]);

    assert_eq!(right.status.code(), Some(0), "{}", text(&right.stderr));
    assert!(text(&right.stdout).contains("2 blocks"));
    let error = text(&wrong.stderr);
    assert_eq!(wrong.status.code(), Some(2), "{error}");
    assert!(
        error.contains("table.csv:3:1: theta1: OutOfTravel"),
        "{error}"
    );
    assert_eq!(
        folder.files(),
        ["jobs/some.toml", "jobs/table.csv", "out/report.html"]
    );
}
