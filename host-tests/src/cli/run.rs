//! `hexstep run`, `hexstep list`, and `hexstep` alone: a job to its pulses, its report and its trace.
//!
//! Exit status: 0 when the job ran and every motor stands where it should; 1 when it ran and something is wrong, or a
//! file could not be written; 2 for bad input, of which nothing is left behind.

use crate::export::{self, Span};
use crate::files::write_whole;
use crate::job::{Job, JobError};
use crate::lines;
use crate::report::{Card, Finished, Standing, index, motor_names};
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
    pub text: &'static str,
}

macro_rules! delivered {
    ($name:literal) => {
        Delivered {
            name: $name,
            file: concat!("host-tests/jobs/", $name, ".toml"),
            text: include_str!(concat!("../../jobs/", $name, ".toml")),
        }
    };
}

/// The jobs that come with the program; the first is run when none is named.
pub const DELIVERED: &[Delivered] = &[
    delivered!("drill-point"),
    delivered!("counts"),
    delivered!("stop-to-stop"),
    delivered!("circle"),
    delivered!("trochoid"),
    delivered!("flexible"),
    delivered!("frustum"),
    delivered!("pole-crossing"),
    delivered!("arm-path"),
    delivered!("two-sided"),
    delivered!("dune-hard"),
    delivered!("dune-soft"),
    delivered!("shell-soft"),
    delivered!("precession-plane"),
    delivered!("precession-curved"),
    delivered!("mirror-panel"),
    delivered!("mirror-skin"),
    delivered!("mirror-bias"),
];

/// What `hexstep run` was asked for.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// A job file, or the name of a delivered job; `None` for the first of them.
    pub job: Option<String>,
    /// Folder for the results; `None` for `target/hexstep/JOB`.
    pub out: Option<PathBuf>,
    /// `None` for the start of one job, and for nothing of all.
    pub extent: Option<Extent>,
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
    let folder = request
        .out
        .clone()
        .unwrap_or_else(|| Path::new(FOLDER).join(&job.name));
    let ran = run_into(&job, &folder, request.extent.unwrap_or_default(), &bar);
    bar.finish_and_clear();
    let ran = match ran {
        Ok(ran) => ran,
        Err(error) => return refuse(&error),
    };

    let mut text = format!("job      {}\n", job.name);
    for line in &ran.finished.summary {
        text.push_str(line);
        text.push('\n');
    }
    text.push('\n');
    let status = match ran.written {
        Ok(lines) => {
            for line in lines {
                text.push_str(&line);
                text.push('\n');
            }
            if ran.finished.sound { SOUND } else { UNSOUND }
        }
        Err(error) => {
            unwritable(&folder, &error);
            UNSOUND
        }
    };
    say(&text);
    status
}

/// Writes the lines that make a machine do a job to standard output; returns the exit status.
pub fn lines(name: Option<&str>) -> u8 {
    match load(name).and_then(|job| lines::of(&job)) {
        Ok(lines) => {
            let mut text = lines.join("\n");
            text.push('\n');
            say(&text);
            SOUND
        }
        Err(error) => refuse(&error),
    }
}

/// Results of all jobs, and the page that shows them.
const FOLDER: &str = "target/hexstep";

/// Runs every delivered job and writes a page that shows them all; returns the worst exit status. Waves and steps are
/// written only when they are asked for.
pub fn run_all(request: &Request) -> u8 {
    run_each(request, DELIVERED)
}

/// The same with a list of one's own.
pub fn run_each(request: &Request, jobs: &[Delivered]) -> u8 {
    let root = request.out.clone().unwrap_or_else(|| FOLDER.into());
    let (mut cards, mut status) = (Vec::new(), SOUND);
    for (number, delivered) in (1..).zip(jobs) {
        let bar = progress_bar();
        bar.set_prefix(format!("{number}/{} {} ", jobs.len(), delivered.name));
        let start = Instant::now();
        let folder = root.join(delivered.name);
        let extent = request.extent.unwrap_or(Extent::Nothing);
        let ran = delivered
            .load()
            .and_then(|job| run_into(&job, &folder, extent, &bar));
        bar.finish_and_clear();
        let mut card = Card {
            name: delivered.name.into(),
            about: delivered.about(),
            standing: Standing::Failed,
            lines: Vec::new(),
            link: None,
            picture: None,
            wall: start.elapsed().as_secs_f64(),
        };
        let worst = match ran {
            Ok(ran) => {
                let is_figure = |line: &&String| line.contains("  ");
                let lines = ran.finished.summary.iter().take_while(|l| !l.is_empty());
                card.lines = lines.filter(is_figure).take(CARD_LINES).cloned().collect();
                card.picture = picture(&ran.finished.html);
                match ran.written {
                    Ok(_) => {
                        card.link = Some(format!("{}/report.html", delivered.name));
                        if ran.finished.sound {
                            card.standing = Standing::Sound;
                            SOUND
                        } else {
                            card.standing = Standing::Unsound;
                            UNSOUND
                        }
                    }
                    Err(error) => {
                        unwritable(&folder, &error);
                        UNSOUND
                    }
                }
            }
            Err(error) => {
                card.lines = vec![format!("refused  {error}")];
                refuse(&error)
            }
        };
        status = status.max(worst);
        let state = match card.standing {
            Standing::Sound => "ok",
            Standing::Unsound => "WRONG",
            Standing::Failed => "FAILED",
        };
        say(&format!(
            "{state:<7}{:<18}{:>7.1} s\n",
            card.name, card.wall
        ));
        cards.push(card);
    }
    let page = root.join("index.html");
    let html = index(&cards);
    let written = write_whole(&page, |out| out.write_all(html.as_bytes()));
    match written.and_then(|()| told("index", &page)) {
        Ok(line) => say(&format!("\n{line}\n")),
        Err(error) => {
            unwritable(&root, &error);
            status = status.max(UNSOUND);
        }
    }
    status
}

/// Lines of a summary that a card shows.
const CARD_LINES: usize = 9;
/// A larger picture would make the page slow.
const LARGEST_PICTURE: usize = 400_000;

/// The first picture of a report that is not too large.
fn picture(html: &str) -> Option<String> {
    let mut rest = html;
    while let Some(start) = rest.find("<svg") {
        let end = start + rest[start..].find("</svg>")? + "</svg>".len();
        if end - start <= LARGEST_PICTURE {
            return Some(rest[start..end].to_string());
        }
        rest = &rest[end..];
    }
    None
}

/// A job that has run to its end.
struct Ran {
    finished: Finished,
    /// Lines that tell what lies where.
    written: io::Result<Vec<String>>,
}

fn run_into(job: &Job, folder: &Path, extent: Extent, bar: &ProgressBar) -> Result<Ran, JobError> {
    bar.set_message("planning");
    let start = Instant::now();
    let mut is_running = false;
    let outcome = run::run(job, &mut |done, all| {
        if !is_running {
            bar.set_message("simulating");
            is_running = true;
        }
        bar.set_length(all);
        bar.set_position(done);
    })?;
    bar.set_message("measuring");
    let finished = Finished::of(job, &outcome, start.elapsed().as_secs_f64());
    bar.set_message("writing");
    let html = &finished.html;
    let written = match (&outcome.pair, job.pair()) {
        (Some(run), Some(pair)) => {
            write_results(folder, html, extent, &run.trace, &motor_names(pair))
        }
        _ => {
            // What has no motion has no waves.
            let moves = outcome.trace.ticks() > 0;
            let extent = if moves { extent } else { Extent::Nothing };
            write_results(folder, html, extent, &outcome.trace, &job.motor_names())
        }
    };
    Ok(Ran { finished, written })
}

/// Shows the delivered jobs, one line each.
pub fn list() -> u8 {
    let mut text = String::new();
    for job in DELIVERED {
        text.push_str(&format!("{:<18}{}\n", job.name, job.about()));
    }
    say(&text);
    SOUND
}

impl Delivered {
    fn load(&self) -> Result<Job, JobError> {
        let path = Path::new(self.file);
        // A copy in the folder where we are comes before the one built in: it may have been edited.
        if path.is_file() {
            Job::load(path)
        } else {
            Job::parse(self.file, self.name, self.text.as_bytes())
        }
    }

    /// The first sentence of the comment at the head of its file, which says what the job stands for.
    pub fn about(&self) -> String {
        let lines = self.text.lines().map_while(|line| line.strip_prefix("# "));
        first_sentence(&lines.collect::<Vec<_>>().join(" ")).into()
    }
}

/// Up to the first full stop with a capital letter behind it: so "Fig. 5" does not end a sentence. Without the stop.
fn first_sentence(text: &str) -> &str {
    let is_end = |at: &usize| {
        let mut behind = text[at + 1..].chars();
        behind.next() == Some(' ') && behind.next().is_some_and(char::is_uppercase)
    };
    let mut stops = text.match_indices('.').map(|(at, _)| at);
    match stops.find(is_end) {
        Some(end) => &text[..end],
        None => text.trim_end_matches('.'),
    }
}

/// The job file, if there is one of that name, else the delivered job.
fn load(name: Option<&str>) -> Result<Job, JobError> {
    let first = DELIVERED.first().filter(|_| name.is_none());
    let by_name = DELIVERED.iter().find(|job| Some(job.name) == name);
    let path = Path::new(name.unwrap_or_default());
    match first.or(by_name) {
        Some(delivered) if !path.is_file() => delivered.load(),
        _ => Job::load(path),
    }
}

/// Report and trace, each whole or not at all; lines that tell what lies where.
fn write_results<const N: usize>(
    folder: &Path,
    html: &str,
    extent: Extent,
    trace: &Trace<N>,
    names: &[String; N],
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
    let mut steps = [0u64; N];
    for pulse in trace.pulses().take_while(|pulse| pulse.time <= span.to) {
        for motor in bits::<N>(pulse.motors) {
            steps[motor] += 1;
        }
    }
    let counted: Vec<String> = names
        .iter()
        .zip(steps)
        .filter(|(name, _)| !name.is_empty())
        .map(|(name, n)| format!("{name} {n}"))
        .collect();
    lines.push(format!("         steps in them: {}", counted.join("  ")));
    Ok(lines)
}

/// From the beginning to the tick before the one that would be too much; the whole when it is not too much.
fn first_steps<const N: usize>(trace: &Trace<N>, most: usize) -> Span {
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
    if let Ok(style) = ProgressStyle::with_template("{prefix}{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    bar
}

fn unwritable(folder: &Path, error: &io::Error) {
    tell(&format!(
        "hexstep: {}: {error}; choose another folder with --out\n",
        folder.display()
    ));
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
