//! A trace -> VCD and CSV, for waveform viewers and for tables.
//!
//! The VCD holds `enable` and for each motor `step_NAME` and `dir_NAME` (1 = negative), in nanoseconds. A count of the
//! step timer is 125/21 ns, which no decimal unit holds exactly; times are rounded to the nearest nanosecond, and since
//! a count is nearly six of them, `round(ns * 0.168)` gives the count back exactly.
//!
//! Changes of one time stamp stand in the order of the pins: steps before directions, since a tick puts out the steps of
//! the segment before and then loads the next. They are never those of one motor: its direction stands for at least a tick
//! behind its step, even if no hold is asked for, so a reader may take them in any order.
//!
//! The CSV holds one row for each step: its time in seconds (9 decimals), the motor's name, its direction (1 or -1) and
//! its position after the step.

use crate::files::write_whole;
use crate::trace::{Change, TICK_HZ, Trace, bits};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use vcd::{SimulationCommand, TimescaleUnit, Value};

/// A time in whole nanoseconds, to the nearest.
pub fn nanoseconds(counts: u64) -> u64 {
    // 168 MHz: 125/21 ns a count. Whole seconds apart, so that nothing overflows: the rest is below 2^28 counts.
    let (whole, rest) = (counts / TICK_HZ, counts % TICK_HZ);
    whole * 1_000_000_000 + (rest * 1_000_000_000 + TICK_HZ / 2) / TICK_HZ
}

/// Which part of a trace is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First and last time [counts], both included.
    pub from: u64,
    pub to: u64,
}

impl Span {
    pub const ALL: Self = Self {
        from: 0,
        to: u64::MAX,
    };
}

/// Writes a trace as VCD; `names` are those of the motors, letters, digits and underscores only. A motor without a name
/// is left out.
///
/// # Errors
/// Those of the writer.
pub fn vcd<const N: usize>(
    out: impl Write,
    trace: &Trace<N>,
    names: &[String; N],
    span: Span,
) -> io::Result<()> {
    // The writer emits every change in small pieces.
    let mut buffer = BufWriter::with_capacity(1 << 20, out);
    let mut out = vcd::Writer::new(&mut buffer);
    out.version(concat!("hexstep ", env!("CARGO_PKG_VERSION")))?;
    out.comment("dir 1 = negative; count of the 168 MHz step timer = round(ns * 0.168)")?;
    out.comment("at one time: steps, then directions, never both of one motor")?;
    out.timescale(1, TimescaleUnit::NS)?;
    out.add_module("hexstep")?;
    let enable = out.add_wire(1, "enable")?;
    // Step and direction of every motor that has a name.
    let mut wires = [None; N];
    for (name, wires) in names.iter().zip(&mut wires) {
        if !name.is_empty() {
            let step = out.add_wire(1, &format!("step_{name}"))?;
            let direction = out.add_wire(1, &format!("dir_{name}"))?;
            *wires = Some((step, direction));
        }
    }
    out.upscope()?;
    out.enddefinitions()?;

    let (state, events) = trace.events_from(span.from);
    let start = nanoseconds(span.from);
    let (mut levels, mut mask) = (state.levels, state.directions);
    let bit = |mask: u8, motor: usize| Value::from(mask >> motor & 1 == 1);
    out.timestamp(start)?;
    out.begin(SimulationCommand::Dumpvars)?;
    out.change_scalar(enable, state.enabled)?;
    for motor in 0..N {
        if let Some((step, direction)) = wires[motor] {
            out.change_scalar(step, bit(levels, motor))?;
            out.change_scalar(direction, bit(mask, motor))?;
        }
    }
    out.end()?;

    let mut stamped = start;
    for event in events {
        if event.time > span.to {
            break;
        }
        let time = nanoseconds(event.time);
        if time != stamped {
            out.timestamp(time)?;
            stamped = time;
        }
        match event.change {
            Change::Levels(new) => {
                for motor in bits::<N>(new ^ levels) {
                    if let Some((step, _)) = wires[motor] {
                        out.change_scalar(step, bit(new, motor))?;
                    }
                }
                levels = new;
            }
            Change::Directions(new) => {
                for motor in bits::<N>(new ^ mask) {
                    if let Some((_, direction)) = wires[motor] {
                        out.change_scalar(direction, bit(new, motor))?;
                    }
                }
                mask = new;
            }
            Change::Enable(on) => out.change_scalar(enable, on)?,
        }
    }
    // The end of the trace belongs to it, even if nothing changes there.
    let end = nanoseconds(trace.end().min(span.to));
    if end > stamped {
        out.timestamp(end)?;
    }
    out.flush()
}

/// Writes the steps of a trace as CSV, one row for each step of each motor, in order of time, then of motor.
///
/// # Errors
/// Those of the writer.
pub fn csv<const N: usize>(
    out: impl Write,
    trace: &Trace<N>,
    names: &[String; N],
    span: Span,
) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, out);
    writeln!(out, "time_s,motor,direction,position")?;
    for pulse in trace.pulses_from(span.from) {
        if pulse.time > span.to {
            break;
        }
        let ns = nanoseconds(pulse.time);
        let (whole, rest) = (ns / 1_000_000_000, ns % 1_000_000_000);
        for motor in bits::<N>(pulse.motors) {
            let sign = if pulse.backward >> motor & 1 == 0 {
                1
            } else {
                -1
            };
            writeln!(
                out,
                "{whole}.{rest:09},{},{sign},{}",
                names[motor], pulse.positions[motor]
            )?;
        }
    }
    out.flush()
}

/// Writes a trace as a VCD file, whole or not at all.
///
/// # Errors
/// Those of the file system.
pub fn vcd_file<const N: usize>(
    path: &Path,
    trace: &Trace<N>,
    names: &[String; N],
    span: Span,
) -> io::Result<()> {
    write_whole(path, |out| vcd(out, trace, names, span))
}

/// Writes a trace as a CSV file, whole or not at all.
///
/// # Errors
/// Those of the file system.
pub fn csv_file<const N: usize>(
    path: &Path,
    trace: &Trace<N>,
    names: &[String; N],
    span: Span,
) -> io::Result<()> {
    write_whole(path, |out| csv(out, trace, names, span))
}
