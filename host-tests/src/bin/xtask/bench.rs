//! Measures the figures: the step interrupt in the shipped program, foreground functions in the bench program, sizes,
//! and the host's own speed.

use super::board::Board;
use super::build::{self, BENCH, FIRMWARE};
use super::figures::{FIGURES, Measured};
use super::install;
use super::run::{Outcome, cargo, shown};
use hexstep_host::emulator::{Counter, Elf, Emulator, OCTOPUS, Options, Recording, Tally};
use hexstep_host::machine;
use hexstep_host::surface::{self, PathRow, SurfaceError};
use std::path::Path;
use std::time::{Duration, Instant};

/// Core clock [Hz], in which model cycles are counted.
const CORE_HZ: f64 = 168.0e6;
/// Calls of each function of the bench program.
const ROUNDS: u64 = 64;
/// Longest time one run may take in the emulator.
const PATIENCE: Duration = Duration::from_secs(300);
/// Pulse time of 1 us and no more: ticks as short as the firmware allows, 240 timer counts.
const FASTEST: &str = "$0=1";
/// Time for 100 000 steps in ticks of 240 counts, two a step and one a step, a hair above the least.
const PULSE_SECONDS: f64 = 100_000.0 * 2.0 * 240.0 / CORE_HZ + 1e-6;
const EDGE_SECONDS: f64 = 100_000.0 * 240.0 / CORE_HZ + 1e-6;

/// `only_functions`: nothing but the functions of the bench program, and no file is written.
pub fn task(board: Board, only_functions: bool) -> Outcome<()> {
    install::everything()?;
    let bench = build::firmware(board, BENCH, false)?;
    let folder = bench.parent().unwrap_or(Path::new("."));
    let counter = Counter::build(folder).map_err(|error| error.to_string())?;

    let mut measured = Measured::default();
    if only_functions {
        functions(&bench, counter, &mut measured)?;
        return verdict(&measured.print(false));
    }
    let firmware = build::firmware(board, FIRMWARE, false)?;
    step_interrupt(&firmware, &counter, &mut measured)?;
    let arm = build::firmware(Board::SkrProArm, FIRMWARE, false)?;
    sizes(&arm, &mut measured, "arm_flash_bytes", "arm_ram_bytes")?;
    let octopus = build::firmware(Board::Octopus, FIRMWARE, false)?;
    eight_motors(&octopus, &counter, &mut measured)?;
    functions(&bench, counter, &mut measured)?;
    sizes(
        &firmware,
        &mut measured,
        "firmware_flash_bytes",
        "firmware_ram_bytes",
    )?;
    host_speed(&mut measured)?;
    planning(&mut measured)?;
    peer(&mut measured)?;
    motion(&mut measured)?;
    trim_latency(&octopus, &mut measured)?;

    println!();
    let missed = measured.print(true);
    println!(
        "\nInstructions are counted in the emulator; cycles are a model (memory without wait states)."
    );
    let path = folder.join("bench.json");
    measured.write(&path)?;
    println!("written to {}", path.display());
    verdict(&missed)
}

fn verdict(missed: &[&str]) -> Outcome<()> {
    if missed.is_empty() {
        Ok(())
    } else {
        Err(format!("goals not reached: {}", missed.join(", ")))
    }
}

/// W1 to W4 on the shipped program's own handler, in all ticks from the first edge to the last.
fn step_interrupt(elf: &Path, counter: &Counter, measured: &mut Measured) -> Outcome<()> {
    let mut options = Options::new(elf);
    options.counter = Some(counter.clone());
    let mut session = Session::start(&options)?;
    session.ask(FASTEST)?;

    let w1 = session.run("W1, six motors together", [100_000; 6], PULSE_SECONDS)?;
    measured.set("isr_w1_instructions", w1.tally.mean_instructions())?;
    measured.set(
        "isr_w1_worst_instructions",
        w1.tally.worst.instructions.into(),
    )?;
    measured.set("isr_w1_cycles_model", w1.tally.mean_cycles())?;
    measured.set("isr_w1_worst_cycles_model", w1.tally.worst.cycles.into())?;
    measured.set("isr_w1_instructions_per_step_pulse", w1.per_step())?;

    let golden = [-100_000, -61_803, -38_197, -23_607, -14_590, -9_017];
    let w2 = session.run("W2, golden ratios", golden, PULSE_SECONDS)?;
    measured.set("isr_w2_instructions", w2.tally.mean_instructions())?;
    measured.set(
        "isr_w2_worst_instructions",
        w2.tally.worst.instructions.into(),
    )?;

    let w3 = session.run("W3, one motor", [100_000, 0, 0, 0, 0, 0], PULSE_SECONDS)?;
    measured.set("isr_w3_instructions", w3.tally.mean_instructions())?;
    measured.set(
        "isr_w3_worst_instructions",
        w3.tally.worst.instructions.into(),
    )?;

    let three = [-100_000, 100_000, 100_000, 0, 0, 0];
    let w4 = session.run("W4, three motors", three, PULSE_SECONDS)?;
    measured.set("isr_w4_instructions", w4.tally.mean_instructions())?;
    measured.set(
        "isr_w4_worst_instructions",
        w4.tally.worst.instructions.into(),
    )?;

    let turn = session.turn_round::<6>("six motors to and fro")?;
    measured.set(
        "isr_turn_worst_instructions",
        turn.worst.instructions.into(),
    )?;

    let load = session.run("six motors at 100 kHz", [-100_000; 6], 1.0)?;
    measured.set("isr_load_100khz_six", load.tally.cycles as f64 / CORE_HZ)?;

    session.ask("$1010=1")?;
    session.both_edges = true;
    let edges = session.run("W1, both edges", [100_000; 6], EDGE_SECONDS)?;
    measured.set("isr_w1_instructions_per_step_both_edge", edges.per_step())
}

/// W1 with eight motors on four ports: the handler in the Octopus's program.
fn eight_motors(elf: &Path, counter: &Counter, measured: &mut Measured) -> Outcome<()> {
    let mut options = Options::new(elf);
    options.counter = Some(counter.clone());
    options.pins = OCTOPUS;
    let mut session = Session::start(&options)?;
    session.ask(FASTEST)?;
    let w1 = session.run("W1, eight motors together", [100_000; 8], PULSE_SECONDS)?;
    measured.set("isr_eight_w1_instructions", w1.tally.mean_instructions())?;
    measured.set("isr_eight_w1_cycles_model", w1.tally.mean_cycles())?;
    let turn = session.turn_round::<8>("eight motors to and fro")?;
    measured.set(
        "isr_eight_turn_worst_instructions",
        turn.worst.instructions.into(),
    )?;
    sizes(elf, measured, "octopus_flash_bytes", "octopus_ram_bytes")
}

/// A run of the step interrupt.
struct Run {
    tally: Tally,
    steps: i64,
}

impl Run {
    fn per_step(&self) -> f64 {
        self.tally.instructions as f64 / self.steps as f64
    }
}

/// A booted firmware that may move.
struct Session {
    emulator: Emulator,
    both_edges: bool,
}

impl Session {
    fn start(options: &Options) -> Outcome<Self> {
        let mut emulator = Emulator::boot(options).map_err(|error| error.to_string())?;
        emulator
            .expect_banner()
            .map_err(|error| error.to_string())?;
        let mut session = Self {
            emulator,
            both_edges: false,
        };
        // The emulator has no crystal; its step timer runs at the right speed all the same.
        session.ask("$1012=1")?;
        Ok(session)
    }

    fn ask(&mut self, line: &str) -> Outcome<()> {
        let answer = self
            .emulator
            .ask(line, PATIENCE)
            .map_err(|error| error.to_string())?;
        match answer.last().map(String::as_str) {
            Some("ok") => Ok(()),
            _ => Err(format!(
                "{line}: the firmware answered {}",
                answer.join(" ")
            )),
        }
    }

    /// Runs a line of counts; what the step interrupt cost in it.
    fn run<const N: usize>(&mut self, name: &str, counts: [i32; N], seconds: f64) -> Outcome<Run> {
        println!("{name} ...");
        let _ = self.emulator.take_recording();
        let words: Vec<String> = counts.iter().map(i32::to_string).collect();
        self.ask(&format!("$SEG={},{seconds:.7}", words.join(",")))?;
        self.emulator
            .expect_idle(PATIENCE)
            .map_err(|error| error.to_string())?;
        let recording = self.emulator.take_recording();
        self.check(&recording, counts)?;
        Ok(Run {
            tally: Tally::of(recording.costs(recording.motion())),
            steps: counts
                .iter()
                .map(|count| i64::from(count.unsigned_abs()))
                .sum(),
        })
    }

    /// Sends all motors to and fro together; what the step interrupt cost in it.
    fn turn_round<const N: usize>(&mut self, name: &str) -> Outcome<Tally> {
        println!("{name} ...");
        // Targets are places: from where the lines of counts have left the motors, first to the origin.
        self.go::<N>(&[0])?;
        let _ = self.emulator.take_recording();
        let places: Vec<i32> = (0..40).map(|k| 50 * (k % 2)).collect();
        self.go::<N>(&places)?;
        let recording = self.emulator.take_recording();
        self.check(&recording, [50; N])?;
        let together = |turned: u8| turned.count_ones() as usize == N;
        let mut before = 0;
        let turns = recording.changes().iter().filter(|change| {
            let turned = change.directions ^ before;
            before = change.directions;
            together(turned)
        });
        match turns.count() {
            38.. => Ok(Tally::of(recording.costs(recording.motion()))),
            turns => Err(format!("{name}: turned together {turns} times only")),
        }
    }

    /// Sends all motors to one place after the other.
    fn go<const N: usize>(&mut self, places: &[i32]) -> Outcome<()> {
        for place in places {
            let words = [*place; N].map(|steps| steps.to_string());
            self.ask(&format!("$MOVE={},0", words.join(",")))?;
        }
        self.ask("$MOVE=END")?;
        self.emulator
            .expect_idle(PATIENCE)
            .map(drop)
            .map_err(|error| error.to_string())
    }

    /// A figure of a run that went wrong would be worthless.
    fn check<const N: usize>(&self, recording: &Recording, counts: [i32; N]) -> Outcome<()> {
        let made = recording.positions(self.both_edges);
        for (motor, (made, wanted)) in made.iter().zip(counts).enumerate() {
            if *made != i64::from(wanted) {
                return Err(format!(
                    "motor {motor} made {made} steps instead of {wanted}"
                ));
            }
        }
        Ok(())
    }
}

/// Figures that are the mean instructions of one function in the bench program.
const FUNCTIONS: [(&str, &str); 13] = [
    ("segment_instructions", "bench_segment"),
    ("planner_instructions_per_sample", "bench_planner_next"),
    ("five_axis_solve_instructions", "bench_five_axis_solve"),
    ("five_axis_full_instructions", "bench_five_axis_full"),
    ("arm_ik_instructions", "bench_arm_ik"),
    ("mirror_pair_instructions", "bench_mirror_pair"),
    ("trim_tick_instructions", "bench_trim_tick"),
    ("trim_full_tick_instructions", "bench_trim_full_tick"),
    ("drill_pose_instructions", "bench_drill_pose"),
    ("drill_solve_instructions", "bench_drill_solve"),
    ("precession_pose_instructions", "bench_precession_pose"),
    ("nurbs_eval_instructions", "bench_nurbs_eval"),
    ("hertz_instructions", "bench_hertz"),
];

/// Figures that are the mean and the worst instructions of one function in the bench program: work on a process.
const BLOCKS: [(&str, &str, &str); 3] = [
    (
        "precession_block_instructions",
        "precession_block_worst_instructions",
        "bench_precession_block",
    ),
    (
        "grinding_block_instructions",
        "grinding_block_worst_instructions",
        "bench_grinding_block",
    ),
    (
        "mirror_block_instructions",
        "mirror_block_worst_instructions",
        "bench_mirror_block",
    ),
];

/// Instructions of functions in the bench program.
fn functions(elf: &Path, mut counter: Counter, measured: &mut Measured) -> Outcome<()> {
    println!("functions of the foreground ...");
    let numbers = FUNCTIONS.map(|(key, function)| (key, counter.watch(function)));
    let (push, next) = (counter.watch("bench_planner_push"), numbers[1].1);
    let blocks = BLOCKS.map(|(mean, worst, function)| (mean, worst, counter.watch(function)));
    let points = ["bench_arm_point", "bench_pair_point"].map(|function| counter.watch(function));
    let turn = counter.watch("bench_turn");
    let end = counter.watch("bench_end");
    let mut options = Options::new(elf);
    options.counter = Some(counter);
    let emulator = Emulator::boot(&options).map_err(|error| error.to_string())?;
    emulator
        .wait_for("end of the bench program", PATIENCE, |recording| {
            recording.tally(end).calls > 0
        })
        .map_err(|error| error.to_string())?;
    let recording = emulator.take_recording();
    for (key, number) in numbers {
        let tally = enough(recording.tally(number), key)?;
        measured.set(key, tally.mean_instructions())?;
    }
    for (mean, worst, number) in blocks {
        let tally = enough(recording.tally(number), mean)?;
        measured.set(mean, tally.mean_instructions())?;
        measured.set(worst, tally.worst.instructions.into())?;
    }
    let turn = enough(recording.tally(turn), "bench_turn")?.worst;
    measured.set(
        "isr_turn_latch_worst_instructions",
        turn.instructions.into(),
    )?;
    measured.set("isr_turn_latch_worst_cycles_model", turn.cycles.into())?;
    let cycles = blocks.map(|(.., number)| recording.tally(number).worst.cycles);
    let points = points.map(|number| recording.tally(number).worst.instructions);
    measured.set("process_block_worst_cycles_model", largest(&cycles))?;
    measured.set("point_line_worst_instructions", largest(&points))?;
    // What a block costs from its push to its last sample.
    let (push, next) = (recording.tally(push), recording.tally(next));
    let blocks = push.calls as f64;
    let planner = (push.instructions + next.instructions) as f64;
    measured.set("planner_push_instructions", push.mean_instructions())?;
    measured.set("planner_instructions_per_block", planner / blocks)?;
    measured.set("planner_samples_per_block", next.calls as f64 / blocks)
}

/// A mean of few calls would say little.
fn enough(tally: Tally, key: &str) -> Outcome<Tally> {
    match tally.calls {
        ROUNDS.. => Ok(tally),
        calls => Err(format!("{key}: only {calls} calls")),
    }
}

/// NaN, which no figure may be, of none.
fn largest(costs: &[u32]) -> f64 {
    let most = costs.iter().filter(|cost| **cost > 0).max();
    most.map_or(f64::NAN, |most| f64::from(*most))
}

fn sizes(
    elf: &Path,
    measured: &mut Measured,
    flash: &'static str,
    ram: &'static str,
) -> Outcome<()> {
    let elf = Elf::read(elf).map_err(|error| error.to_string())?;
    measured.set(flash, elf.flash_bytes().into())?;
    measured.set(ram, elf.ram_bytes().into())
}

/// The same step interrupt in memory, with its pins traced.
fn host_speed(measured: &mut Measured) -> Outcome<()> {
    println!("the host's simulation ...");
    let (ticks, seconds) = machine::with(|machine| {
        machine.ask("");
        machine.ask(FASTEST);
        machine.trace = machine.take_trace();
        let before = machine.trace.ticks();
        let start = Instant::now();
        let mut ticks = 0;
        for round in 0..40 {
            let sign = if round % 2 == 0 { "" } else { "-" };
            machine.ask(&format!(
                "$SEG={sign}100000,{sign}61803,{sign}38197,{sign}23607,{sign}14590,{sign}9017,{PULSE_SECONDS:.7}"
            ));
            ticks += machine.take_trace().ticks();
        }
        (ticks - before, start.elapsed().as_secs_f64())
    });
    measured.set("host_ticks_per_second", ticks as f64 / seconds)
}

/// Rows and residual of the surface Dune, each the best of three.
fn planning(measured: &mut Measured) -> Outcome<()> {
    println!("planning of surfaces ...");
    let part = surface::dune().map_err(|error| error.name().to_string())?;
    for (job, key) in [
        (surface::Job::hard(), "surface_rows_hard_seconds"),
        (surface::Job::soft(), "surface_rows_soft_seconds"),
    ] {
        let grinding = job.check().map_err(|error| error.to_string())?;
        let plan = || surface::Rows::plan(&part, &job, &grinding).map(drop);
        measured.set(key, best_of_three(plan)?)?;
    }
    let job = surface::Job::hard();
    let plan = surface::Plan::new(&part, &job).map_err(|error| error.to_string())?;
    let rows: Vec<PathRow> = plan.segments.iter().map(PathRow::from).collect();
    let simulate = || surface::residual(&part, &job, &rows, 60).map(drop);
    measured.set("surface_residual_hard_seconds", best_of_three(simulate)?)
}

/// The arm against the crate rs-opw-kinematics, both in one run of a test, which alone may link that crate.
fn peer(measured: &mut Measured) -> Outcome<()> {
    println!("the arm and its peer ...");
    // If the test fails for being slower, the ratio still stands there.
    let said = said_by("arm", "a_pose_takes_no_longer_than_in_the_peer", &[])?;
    said.set("arm_against_peer_ratio", measured)
}

/// Limits, times and latencies of motion.
fn motion(measured: &mut Measured) -> Outcome<()> {
    println!("motion: a thousand programs ...");
    let said = said_by("planner", "figures::figures_of_motion", &[])?;
    if !said.passed {
        return Err(format!("{} failed", said.command));
    }
    let mut figures = FIGURES.iter().filter(|f| f.key.starts_with("motion_"));
    figures.try_for_each(|figure| said.set(figure.key, measured))
}

/// Readings over the serial line of the Octopus's program, and when they show.
fn trim_latency(octopus: &Path, measured: &mut Measured) -> Outcome<()> {
    println!("readings over the serial line ...");
    let firmware = [("HEXSTEP_FIRMWARE_OCTOPUS", octopus)];
    let said = said_by("live_trim", "latency::figure_of_the_latency", &firmware)?;
    if !said.passed {
        return Err(format!("{} failed", said.command));
    }
    said.set("trim_latency_ms", measured)
}

/// What a test has printed: a line `key value` for each of its figures.
struct Said {
    command: String,
    passed: bool,
    text: String,
}

impl Said {
    fn set(&self, key: &'static str, measured: &mut Measured) -> Outcome<()> {
        let value = self.text.lines().find_map(|line| {
            let (name, value) = line.split_once(' ')?;
            (name == key).then(|| value.trim().parse().ok())?
        });
        let value = value.ok_or_else(|| format!("{} gave no {key}", self.command))?;
        measured.set(key, value)
    }
}

/// Runs a test that the daily loop leaves out, in release, with what it shall find in its environment.
fn said_by(file: &str, test: &str, environment: &[(&str, &Path)]) -> Outcome<Said> {
    let mut command = cargo();
    command
        .args(["test", "--quiet", "--release", "--package", "host-tests"])
        .args(["--test", file, "--", "--ignored", "--nocapture", "--exact"])
        .arg(test)
        .envs(environment.iter().copied());
    let output = command
        .output()
        .map_err(|error| format!("{}: {error}", shown(&command)))?;
    Ok(Said {
        command: shown(&command),
        passed: output.status.success(),
        text: String::from_utf8_lossy(&output.stdout).into_owned(),
    })
}

fn best_of_three(work: impl Fn() -> Result<(), SurfaceError>) -> Outcome<f64> {
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        work().map_err(|error| error.to_string())?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}
