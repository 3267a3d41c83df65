//! `hexstep`: run jobs, and ask the calculators.

use clap::{Parser, Subcommand};
use hexstep_host::calc;
use std::io::{self, Write};
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    version,
    about = "Six motors in exact step synchrony: jobs and calculators on a PC"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Ask a calculator: JSON on standard input, JSON on standard output
    #[command(after_help = CALC_EXAMPLES)]
    Calc(Calc),
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
        Command::Calc(arguments) => run_calc(arguments),
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
