//! The ELF that is flashed, in the emulator.
use hexstep_host::emulator::{counter::*, *};
use std::time::Duration;

#[test]
fn bring_up() {
    let Some(firmware) = firmware_from_environment() else {
        eprintln!("skipped");
        return;
    };
    let mut options = Options::new(firmware);
    options.counter = Some(Counter::build(std::path::Path::new("/tmp/fwq")).unwrap());
    let t = std::time::Instant::now();
    let mut e = Emulator::boot(&options).unwrap();
    println!("{:?}", e.expect_banner().unwrap());
    println!(
        "{:?} {:?}",
        e.next_line(Duration::from_secs(5)),
        t.elapsed()
    );
    for c in ["1", "2", "3", "4"] {
        e.ask(c, Duration::from_secs(5)).unwrap();
        e.expect_idle(Duration::from_secs(100)).unwrap();
        let r = e.take_recording();
        println!(
            "{} {} {:?} {:?} {:?}",
            r.ticks(),
            r.changes().len(),
            &r.changes()[..5.min(r.changes().len())],
            r.tally(0),
            r.motion()
        );
        println!(
            "{} {:?} {:?}",
            r.most_stores_in_a_tick(),
            t.elapsed(),
            r.positions(false)
        );
        let t = Tally::of(r.costs(r.motion()));
        println!("{t:?} {} {}", t.mean_instructions(), t.mean_cycles());
    }
}
