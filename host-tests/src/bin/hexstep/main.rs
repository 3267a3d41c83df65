//! `hexstep`: run jobs, and ask the calculators.

use clap::{Parser, Subcommand};
use hexstep_host::calc;
use hexstep_host::cli::run::{self as jobs, Extent};
use std::io::{self, Write};
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    version,
    about = "Six motors in exact step synchrony: jobs and calculators on a PC",
    after_help = EXAMPLES
)]
struct Arguments {
    /// Without a command the delivered job drill-point is run
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Run a job: simulate every pulse, write report, waves and steps
    #[command(after_help = RUN_EXAMPLES)]
    Run(Run),
    /// Show the jobs that come with the program
    List,
    /// Print the lines that make a machine do a job: settings, kinematics, process, points
    #[command(after_help = LINES_EXAMPLES)]
    Lines {
        /// A job file, or the name of a delivered job (see `hexstep list`)
        job: String,
    },
    /// Ask a calculator: JSON on standard input, JSON on standard output
    #[command(after_help = CALC_EXAMPLES)]
    Calc(Calc),
}

#[derive(clap::Args)]
struct Run {
    /// A job file, or the name of a delivered job (see `hexstep list`)
    #[arg(required_unless_present = "all", conflicts_with = "all")]
    job: Option<String>,
    /// Run every delivered job, and write index.html with a card for each
    #[arg(long)]
    all: bool,
    /// Folder for the results [default: target/hexstep/JOB, with --all target/hexstep]
    #[arg(long, value_name = "DIR")]
    out: Option<std::path::PathBuf>,
    /// How much of the job trace.vcd and trace.csv hold: its first 4 million steps, all, or no such files
    /// [default: start, with --all none]
    #[arg(long, value_enum)]
    trace: Option<ExtentName>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ExtentName {
    Start,
    All,
    None,
}

#[derive(clap::Args)]
struct Calc {
    /// TOPIC.FUNCTION, such as drill.solve
    #[arg(required_unless_present = "list")]
    function: Option<String>,
    /// The type in which geometry and kinematics are computed: f64 or f32
    #[arg(long, default_value = "f64")]
    scalar: String,
    /// Show every function with its fields, units, ranges and defaults
    #[arg(long)]
    list: bool,
}

const EXAMPLES: &str = r#"Examples:
  hexstep                                  grind the delivered drill point
  hexstep list                             show the delivered jobs
  hexstep run --all                        run them all, and write a page that shows them
  hexstep run counts                       run lines of step counts
  hexstep run my-drill.toml --out results  run a job of your own
  hexstep lines precession-plane           print what makes a machine do it
  hexstep calc --list                      show every calculator
  hexstep calc --help                      how to ask them"#;

const RUN_EXAMPLES: &str = r#"Exit status: 0 all motors where they should be, within limits and tolerances; 1 something is wrong with the result; 2 bad input, nothing written.

Examples:
  hexstep run drill-point
  hexstep run --all
  hexstep run host-tests/jobs/counts.toml
  hexstep run my-drill.toml --out results --trace none"#;

const LINES_EXAMPLES: &str = r#"Send them with any sender that waits for the answer to each line. A refused one has changed nothing.

Examples:
  hexstep lines drill-point                      for the image skr-pro
  hexstep lines precession-curved > polish.txt   for skr-pro-arm: points of the surface, the rest is the machine's work
  hexstep lines mirror-panel                     for octopus; readings of the sensor come between the lines"#;

const CALC_EXAMPLES: &str = r#"Lengths in mm, angles in degrees, times in s. One object is one case; an array of objects is answered by an array.
Exit status: 0 every case answered; 2 bad input, told as {"error": NAME, "detail": SENTENCE}.

Examples:
  echo '{"counts": [7, 3, -5, 1, 0, 2]}' | hexstep calc interp.pulses
  echo '{"diameter": 9.9, "web": 1.63, "point_angle": 118, "chisel_angle": 50, "clearance": 10, "phi": 30}' \
      | hexstep calc drill.solve
  hexstep calc drill.fk --scalar f32 < cases.json > answers.json
  hexstep calc --list"#;

fn main() -> ExitCode {
    let status = match Arguments::parse().command {
        None => jobs::run(&jobs::Request::default()),
        Some(Command::Run(arguments)) => {
            let request = jobs::Request {
                job: arguments.job,
                out: arguments.out,
                extent: arguments.trace.map(|extent| match extent {
                    ExtentName::Start => Extent::Start,
                    ExtentName::All => Extent::All,
                    ExtentName::None => Extent::Nothing,
                }),
            };
            if arguments.all {
                jobs::run_all(&request)
            } else {
                jobs::run(&request)
            }
        }
        Some(Command::List) => jobs::list(),
        Some(Command::Lines { job }) => jobs::lines(Some(&job)),
        Some(Command::Calc(arguments)) => run_calc(arguments),
    };
    ExitCode::from(status)
}

fn run_calc(arguments: Calc) -> u8 {
    let output = io::stdout().lock();
    let result = match arguments.function {
        Some(function) if !arguments.list => {
            calc::main(&function, &arguments.scalar, io::stdin().lock(), output)
        }
        _ => calc::list(io::BufWriter::new(output)).map(|()| calc::ANSWERED),
    };
    result.unwrap_or_else(|error| {
        // Standard error may be closed too; there is nobody left to tell.
        let _ = writeln!(io::stderr(), "hexstep calc: {error}");
        calc::BAD_INPUT
    })
}
