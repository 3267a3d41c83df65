//! The ELF that is flashed, in the emulator.
use hexstep_host::emulator::{Counter, Emulator, Options, firmware_from_environment};
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
    println!("{:?} {:?}", e.next_line(Duration::from_secs(5)), t.elapsed());
    e.send("?hello").unwrap();
    println!("{:?}", e.next_line(Duration::from_secs(5)));
    println!("{:?}", e.expect("xxx", Duration::from_secs(1), |_| false).unwrap_err().to_string());
    let r = e.finish().unwrap();
    println!("{} {} {:?} {:?} {:?}", r.ticks(), r.changes().len(), &r.changes()[..5.min(r.changes().len())], r.tally(0), r.motion());
    println!("{} {:?}", r.most_stores_in_a_tick(), t.elapsed());
}
