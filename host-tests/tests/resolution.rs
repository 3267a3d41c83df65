//! What must not matter to a path, through the whole machine: how fine its steps are, and into how many chords it was cut.

use hexstep_host::job::{Job, Task};
use hexstep_host::report::PathFigures;
use hexstep_host::run;
use hexstep_host::trace::seconds;

/// Time [s] and deviation beyond tolerance and half a step [mm] of one turn of a circle of 5 mm at 10 mm/s.
fn circle(steps: u32, chords: u32, tolerance: f64) -> (f64, f64) {
    let all = |x: u32| format!("[{x}, {x}, {x}, {x}, {x}, {x}]");
    let text = format!(
        "kind = \"path\"\n[machine]\nsteps_per_unit = {}\nmax_rate = {}\nacceleration = {}\njerk = {}\n\
         travel = [[-20, 20], [-20, 20], [-20, 20], [-20, 20], [-20, 20], [-20, 20]]\n\
         [path]\nfeed = 600\ntolerance = {tolerance}\nshape = {{ kind = \"circle\", radius = 5, chords = {chords} }}\n",
        all(steps),
        all(12),
        all(400),
        all(10_000),
    );
    let job = Job::parse("some.toml", "some", text.as_bytes()).expect("it is right");
    let outcome = run::run(&job, &mut |_, _| {}).expect("it runs");
    let Task::Path(path) = &job.task else {
        panic!("a path");
    };
    let figures = PathFigures::of(&job, path, &outcome, 0.0);
    assert!(figures.is_exact());
    let over = figures.contour.largest - tolerance - 0.5 * path.step();
    (seconds(outcome.trace.end()), over)
}

#[test]
fn finer_steps_and_more_chords_never_make_a_path_slower_or_less_true() {
    let resolutions = [10, 80, 1000, 10_000];
    let cuts = [100, 1000, 10_000];
    for tolerance in [0.01, 0.05] {
        let table = resolutions.map(|steps| cuts.map(|chords| circle(steps, chords, tolerance)));

        let time = |r: usize, c: usize| table[r][c].0;
        for (r, steps) in resolutions.iter().enumerate() {
            for (c, chords) in cuts.iter().enumerate() {
                let told = format!("{steps} steps/mm, {chords} chords, tolerance {tolerance}");
                if r > 0 {
                    let coarser = time(r - 1, c);
                    assert!(
                        time(r, c) <= 1.01 * coarser,
                        "{told}: {} after {coarser} s",
                        time(r, c)
                    );
                }
                if c > 0 {
                    let fewer = time(r, c - 1);
                    assert!(
                        time(r, c) <= 1.01 * fewer,
                        "{told}: {} after {fewer} s",
                        time(r, c)
                    );
                }
                assert!(
                    table[r][c].1 <= 0.0,
                    "{told}: {} mm too far off",
                    table[r][c].1
                );
            }
        }
    }
}
