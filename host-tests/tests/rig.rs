use hexstep_host::job::{Job, Task};
use hexstep_host::report::*;
use hexstep_host::run::{Scalar, run};

const DRILL: &str = include_str!("../jobs/drill-point.toml");

#[test]
fn speed() {
    let job = Job::parse("x", "drill-point", DRILL.as_bytes()).expect("right");
    let outcome = run(&job, Scalar::F32, &mut |_, _| {}).expect("runs");
    let Task::DrillPoint(d) = &job.task else {
        panic!()
    };
    let start = std::time::Instant::now();
    let f = DrillFigures::of(&job, d, &outcome, 1.0);
    eprintln!("{:?}", start.elapsed());
    for l in f.summary() {
        eprintln!("{l}");
    }
    std::fs::write("/tmp/x_rig.html", f.html()).unwrap();
    eprintln!("{:?}", start.elapsed());
}
