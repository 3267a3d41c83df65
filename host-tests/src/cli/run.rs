//! `hexstep run`, `hexstep list`, and `hexstep` alone: a job to its pulses, its report and its trace.
//!
//! Exit status: 0 when the job ran and every motor stands where it should; 1 when it ran and something is wrong, or a
//! file could not be written; 2 for bad input, of which nothing is left behind.

use crate::export::{self, Span};
use crate::files::write_whole;
use crate::job::{Job, JobError, Task};
use crate::report::{CountsFigures, DrillFigures, PathFigures, PosesFigures};
use crate::run;
use crate::trace::{Trace, bits, seconds};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A job that comes with the program.
pub struct Delivered {
    pub name: &'static str,
    /// Its file, seen from the root of the repository.
    pub file: &'static str,
    text: &'static str,
}

/// The jobs that come with the program; the first is run when none is named.
pub const DELIVERED: &[Delivered] = &[
    Delivered {
        name: "drill-point",
        file: "host-tests/jobs/drill-point.toml",
        text: include_str!("../../jobs/drill-point.toml"),
    },
    Delivered {
        name: "counts",
        file: "host-tests/jobs/counts.toml",
        text: include_str!("../../jobs/counts.toml"),
    },
    Delivered {
        name: "stop-to-stop",
        file: "host-tests/jobs/stop-to-stop.toml",
        text: include_str!("../../jobs/stop-to-stop.toml"),
    },
    Delivered {
        name: "circle",
        file: "host-tests/jobs/circle.toml",
        text: include_str!("../../jobs/circle.toml"),
    },
    Delivered {
        name: "trochoid",
        file: "host-tests/jobs/trochoid.toml",
        text: include_str!("../../jobs/trochoid.toml"),
    },
    Delivered {
        name: "frustum",
        file: "host-tests/jobs/frustum.toml",
        text: include_str!("../../jobs/frustum.toml"),
    },
    Delivered {
        name: "pole-crossing",
        file: "host-tests/jobs/pole-crossing.toml",
        text: include_str!("../../jobs/pole-crossing.toml"),
    },
    Delivered {
        name: "arm-path",
        file: "host-tests/jobs/arm-path.toml",
        text: include_str!("../../jobs/arm-path.toml"),
    },
    Delivered {
        name: "two-sided",
        file: "host-tests/jobs/two-sided.toml",
        text: include_str!("../../jobs/two-sided.toml"),
    },
];

/// What `hexstep run` was asked for.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// A job file, or the name of a delivered job; `None` for the first of them.
    pub job: Option<String>,
    /// Folder for the results; `None` for `target/hexstep/JOB`.
    pub out: Option<PathBuf>,
    pub extent: Extent,
}

/// How much of a job `trace.vcd` and `trace.csv` hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extent {
    /// The first [`MOST_STEPS`] steps of all motors together: about 100 MB, which waveform viewers still like.
    #[default]
    Start,
    All,
    Nothing,
}

/// Steps written by [`Extent::Start`].
pub const MOST_STEPS: usize = 4_000_000;

/// Exit statuses.
pub const SOUND: u8 = 0;
pub const UNSOUND: u8 = 1;
pub const BAD_INPUT: u8 = 2;

/// Runs a job; returns the exit status.
pub fn run(request: &Request) -> u8 {
    let job = match load(request.job.as_deref()) {
        Ok(job) => job,
        Err(error) => return refuse(&error),
    };
    let bar = progress_bar();
    let start = Instant::now();
    let outcome = run::run(&job, &mut |done, all| {
        bar.set_length(all);
        bar.set_position(done);
    });
    let wall = start.elapsed().as_secs_f64();
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            bar.finish_and_clear();
            return refuse(&error);
        }
    };

    bar.set_message("measuring");
    let (lines, html, sound) = match &job.task {
        Task::DrillPoint(drill) => {
            let figures = DrillFigures::of(&job, drill, &outcome, wall);
            (figures.summary(), figures.html(), figures.is_sound())
        }
        Task::Counts(counts) => {
            let figures = CountsFigures::of(&job, counts, &outcome, wall);
            (figures.summary(), figures.html(), figures.is_sound())
        }
        Task::Path(path) => {
            let figures = PathFigures::of(&job, path, &outcome, wall);
            (figures.summary(), figures.html(), figures.is_sound())
        }
        Task::Poses(poses) => {
            let figures = PosesFigures::of(&job, poses, &outcome, wall);
            (figures.summary(), figures.html(), figures.is_sound())
        }
    };
    let folder = request
        .out
        .clone()
        .unwrap_or_else(|| Path::new("target/hexstep").join(&job.name));
    bar.set_message("writing");
    let written = write_results(
        &folder,
        &html,
        request.extent,
        &outcome.trace,
        &job.motor_names(),
    );
    bar.finish_and_clear();

    let mut text = format!("job      {}\n", job.name);
    for line in &lines {
        text.push_str(line);
        text.push('\n');
    }
    text.push('\n');
    let status = match written {
        Ok(lines) => {
            for line in lines {
                text.push_str(&line);
                text.push('\n');
            }
            if sound { SOUND } else { UNSOUND }
        }
        Err(error) => {
            tell(&format!(
                "hexstep: {}: {error}; choose another folder with --out\n",
                folder.display()
            ));
            UNSOUND
        }
    };
    say(&text);
    status
}

/// Shows the delivered jobs.
pub fn list() -> u8 {
    let mut text = String::new();
    for job in DELIVERED {
        text.push_str(&format!("{:<14}{}\n", job.name, job.file));
        // The comment at the head of the file tells what it is.
        for line in job.text.lines().take_while(|line| line.starts_with("# ")) {
            text.push_str(&format!(
                "{:14}{}\n",
                "",
                line.trim_start_matches(['#', ' '])
            ));
        }
    }
    say(&text);
    SOUND
}

/// The job file, if there is one of that name, else the delivered job.
fn load(name: Option<&str>) -> Result<Job, JobError> {
    let first = DELIVERED.first().filter(|_| name.is_none());
    let by_name = DELIVERED.iter().find(|job| Some(job.name) == name);
    let path = match (name, first) {
        (Some(name), _) => Path::new(name),
        (None, Some(first)) => Path::new(first.file),
        (None, None) => Path::new(""),
    };
    match first.or(by_name) {
        // A copy in the folder where we are comes before the one built in: it may have been edited.
        Some(delivered) if !path.is_file() => {
            Job::parse(delivered.file, delivered.name, delivered.text.as_bytes())
        }
        _ => Job::load(path),
    }
}

/// Report and trace, each whole or not at all; lines that tell what lies where.
fn write_results(
    folder: &Path,
    html: &str,
    extent: Extent,
    trace: &Trace<6>,
    names: &[String; 6],
) -> io::Result<Vec<String>> {
    let report = folder.join("report.html");
    write_whole(&report, |out| out.write_all(html.as_bytes()))?;
    let mut lines = vec![told("report", &report)?];
    let span = match extent {
        Extent::Nothing => return Ok(lines),
        Extent::All => Span::ALL,
        Extent::Start => first_steps(trace, MOST_STEPS),
    };
    let (vcd, csv) = (folder.join("trace.vcd"), folder.join("trace.csv"));
    export::vcd_file(&vcd, trace, names, span)?;
    export::csv_file(&csv, trace, names, span)?;
    lines.extend([told("waves", &vcd)?, told("steps", &csv)?]);
    if span != Span::ALL {
        lines.push(format!(
            "         both hold the first {:.3} s; --trace all writes everything",
            seconds(span.to)
        ));
    }
    let mut steps = [0u64; 6];
    for pulse in trace.pulses().take_while(|pulse| pulse.time <= span.to) {
        for motor in bits::<6>(pulse.motors) {
            steps[motor] += 1;
        }
    }
    let counted: Vec<String> = names
        .iter()
        .zip(steps)
        .map(|(name, n)| format!("{name} {n}"))
        .collect();
    lines.push(format!("         steps in them: {}", counted.join("  ")));
    Ok(lines)
}

/// From the beginning to the tick before the one that would be too much; the whole when it is not too much.
fn first_steps(trace: &Trace<6>, most: usize) -> Span {
    let mut steps = 0;
    let mut to = 0;
    for pulse in trace.pulses() {
        steps += pulse.motors.count_ones() as usize;
        if steps > most {
            return Span { from: 0, to };
        }
        to = pulse.time;
    }
    Span::ALL
}

fn told(what: &str, path: &Path) -> io::Result<String> {
    let bytes = std::fs::metadata(path)?.len();
    Ok(format!("{what:<9}{} ({})", path.display(), size(bytes)))
}

fn size(bytes: u64) -> String {
    if bytes < 1_000_000 {
        format!("{} kB", bytes.div_ceil(1000))
    } else {
        format!("{:.1} MB", bytes as f64 / 1e6)
    }
}

fn progress_bar() -> ProgressBar {
    let bar = ProgressBar::new(0);
    // The template is a constant: it is right or wrong for good.
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    bar.set_message("simulating");
    bar
}

fn refuse(error: &JobError) -> u8 {
    tell(&format!("hexstep: {error}\n"));
    BAD_INPUT
}

/// To standard output; when that is closed there is nobody left to tell.
fn say(text: &str) {
    let _ = io::stdout().lock().write_all(text.as_bytes());
}

/// To standard error.
fn tell(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}
