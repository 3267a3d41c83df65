//! Jobs -> pulses on the board of memory: exact ends, kept limits, nothing starved.

use hexstep_host::job::{Job, Task};
use hexstep_host::run::{Scalar, run};
use hexstep_host::trace::{TICK_HZ, seconds};

const DRILL: &str = include_str!("../jobs/drill-point.toml");
const COUNTS: &str = include_str!("../jobs/counts.toml");

#[test]
fn speed() {
    let job = Job::parse("x", "x", DRILL.as_bytes()).expect("right");
    let start = std::time::Instant::now();
    let outcome = run(&job, Scalar::F32, &mut |_, _| {}).expect("runs");
    let spent = start.elapsed().as_secs_f64();
    let t = &outcome.trace;
    eprintln!(
        "{} ticks {} s  {:.1} Mticks/s  {:.1} s machine, {} events {} bytes starved {} {:?} {:?}",
        t.ticks(),
        spent,
        t.ticks() as f64 / spent / 1e6,
        seconds(t.end()),
        t.len(),
        t.stored_bytes(),
        outcome.starved,
        outcome.counts,
        t.positions()
    );
    for s in t.statistics() {
        eprintln!("{s:?}");
    }
}
