//! Delivered jobs, changed line by line, and run.

use hexstep_host::job::{Job, JobError};
use hexstep_host::run::{Outcome, run};
use std::path::PathBuf;

/// The text with the line that begins with `key` replaced.
#[track_caller]
pub fn with(text: &str, key: &str, line: &str) -> String {
    let is_it = |l: &&str| {
        l.strip_prefix(key)
            .is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    assert!(text.lines().any(|l| is_it(&l)), "no line of {key}");
    let lines = text.lines().map(|l| if is_it(&l) { line } else { l });
    lines.collect::<Vec<_>>().join("\n")
}

/// The text with a line put behind the head of a table.
#[track_caller]
pub fn adding(text: &str, table: &str, line: &str) -> String {
    let head = format!("[{table}]\n");
    assert!(text.contains(&head), "no table {table}");
    text.replacen(&head, &format!("{head}{line}\n"), 1)
}

pub fn parse(text: &str) -> Result<Job, JobError> {
    Job::parse("jobs/some.toml", "some", text.as_bytes())
}

#[track_caller]
pub fn ran(text: &str) -> (Job, Outcome) {
    let job = parse(text).unwrap_or_else(|error| panic!("{error}"));
    let outcome = run(&job, &mut |_, _| {}).unwrap_or_else(|error| panic!("{error}"));
    (job, outcome)
}

/// A mirror job without its machines: only simulated.
#[track_caller]
pub fn still(text: &str) -> &str {
    let (still, _) = text.split_once("# Joints in this order").expect("machines");
    still
}

/// A folder of its own for one test, removed at the end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("hexstep-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("made");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
