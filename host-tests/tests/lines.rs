//! The lines of a job, said to the machine in memory: it does what the job says, and what the host would have done.

mod common;

use common::trace_of_lines;
use hexstep::program::words::{self, BadSteps};
use hexstep::settings::Settings;
use hexstep_host::job::{Job, Task};
use hexstep_host::lines::{self, move_lines, targets_of};
use hexstep_host::machine;
use hexstep_host::process::Made;
use hexstep_host::reference::matrix::{angle_deg, distance};
use hexstep_host::run;
use hexstep_host::trace::{TICK_HZ, Trace};

fn job(name: &str) -> Job {
    let file = format!("{}/jobs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Job::load(file.as_ref()).unwrap()
}

/// What six motors do when all lines of a job are said to them.
fn said(lines: &[String]) -> Trace<6> {
    machine::with(|machine| {
        machine.ask("");
        machine.take_trace();
        let trace = trace_of_lines(machine, lines);
        assert_eq!(machine.starved(), 0);
        trace
    })
}

/// A job whose planning is the host's, or which the machine has of its own: the same counts as when the host runs it.
#[test]
fn the_lines_of_a_job_end_where_the_job_ends() {
    for name in [
        "drill-point",
        "counts",
        "trochoid",
        "flexible",
        "two-sided",
        "arm-path",
    ] {
        let job = job(name);

        let trace = said(&lines::of(&job).unwrap());

        let wanted = run::run(&job, &mut |_, _| {}).unwrap();
        assert_eq!(trace.positions(), wanted.counts.map(i64::from), "{name}");
    }
}

/// Digits of a line become the nearest 2^-32 of a step, and what the host prints is what it runs.
#[test]
fn fractions_of_steps_pass_a_line_unchanged() {
    let read = |text: &str| words::steps(text).unwrap().to_bits();

    assert_eq!(read("9000.25"), (9000 << 32) + (1 << 30));
    assert_eq!(read("-0.000000001"), -4);
    assert_eq!(read("-4000.5"), -(4000 << 32) - (1 << 31));
    assert_eq!([read("+.5"), read("1."), read("-0")], [1 << 31, 1 << 32, 0]);
    // A float would have lost them: 2^31 - 1 and 53 bits behind.
    assert_eq!(read("2147483647.999999999"), i64::MAX - 3);
    assert_eq!(read("-2147483648"), i64::MIN);
    for (text, why) in [
        ("", BadSteps::Malformed),
        ("-", BadSteps::Malformed),
        ("1.2.3", BadSteps::Malformed),
        ("0x10", BadSteps::Malformed),
        ("0.0000000000", BadSteps::TooLong),
        ("2147483648", BadSteps::OutOfRange),
        ("-2147483648.000000001", BadSteps::OutOfRange),
    ] {
        assert_eq!(words::steps(text), Err(why), "{text}");
    }
    let Task::Path(path) = job("trochoid").task else {
        panic!("a path");
    };
    let targets = targets_of(&path);
    let lines = move_lines(&targets);
    let mut between = 0;
    for (target, line) in targets.iter().zip(&lines) {
        assert!(line.len() < 200, "{line}");
        let (_, numbers) = line.split_once('=').unwrap();
        for (at, word) in target.steps.iter().zip(numbers.split(',')) {
            assert_eq!(words::steps(word), Ok(*at), "{line}");
            between += usize::from(at.frac() != 0);
        }
    }
    assert!(between > targets.len());
}

/// The poses that the host plans in f64 from the job, and those that the machine makes of the same points in f32: the tool
/// comes by all of them.
#[test]
fn an_arm_makes_of_a_jobs_points_the_poses_that_the_host_plans() {
    for name in ["precession-plane", "precession-curved", "dune-soft"] {
        let job = job(name);
        let made = Made::of(&job).unwrap().unwrap();
        let poses = made.poses().unwrap();
        let forward = &poses.machine.forward;

        let trace = said(&lines::of(&job).unwrap());

        let at = |steps: &[f64; 6]| {
            forward.at(&std::array::from_fn(|i| {
                let limits = &poses.machine.joints[i].limits;
                (steps[i] / limits.steps_per_unit).to_radians()
            }))
        };
        let tools: Vec<_> = trace.rebuilt_every(TICK_HZ / 1000).iter().map(at).collect();
        // In their order: each is sought behind the one before.
        let mut from = 0;
        let (mut tip, mut axis) = (0.0f64, 0.0f64);
        for row in &poses.rows {
            // Lifts between rows are the machine's own.
            if row.pace == hexstep_host::job::Pace::Rapid && name == "dune-soft" {
                continue;
            }
            let off = |k: &usize| distance(tools[*k].tip, row.tip);
            let ahead = tools.len().min(from + 12_000);
            let near = (from..ahead)
                .min_by(|a, b| off(a).total_cmp(&off(b)))
                .unwrap();
            tip = tip.max(off(&near));
            axis = axis.max(angle_deg(tools[near].axis, row.axis));
            from = near;
        }
        // Tolerances of these jobs: 0.05 mm and 0.05 deg; a millisecond of the way at 20 mm/s is 0.02 mm.
        assert!(tip <= 0.06, "{name}: {tip} mm");
        assert!(axis <= 0.2, "{name}: {axis} deg");
    }
}

#[test]
fn a_pair_mills_the_rows_of_a_job_and_follows_no_sensor_that_is_silent() {
    let job = job("mirror-skin");
    let Task::Mirror(mirror) = &job.task else {
        panic!("a mirror job");
    };
    let pair = mirror.pair.as_ref().unwrap();
    let wall = mirror.simulations[0].d;
    let mut list = lines::of(&job).unwrap();
    list.retain(|line| !line.starts_with("$TRIM=ON"));

    let trace = machine::with_motors::<8, _>(|machine| {
        machine.ask("");
        machine.take_trace();
        let trace = trace_of_lines(machine, &list);
        assert_eq!(machine.starved(), 0);
        trace
    });

    let steps: Vec<f64> = pair
        .joints
        .iter()
        .map(|j| j.limits.steps_per_unit)
        .collect();
    let rows = trace.rebuilt_every(TICK_HZ / 1000);
    let tips: Vec<_> = rows
        .iter()
        .map(|row| pair.tools(&std::array::from_fn(|i| row[i] / steps[i])))
        .collect();
    let mut milled = 0;
    for pair in tips.windows(2) {
        let [mill, support] = pair[1];
        let apart = distance(mill.tip, support.tip);
        // Along a row, not on the way in or out.
        let along = (support.tip[0] - pair[0][1].tip[0]).abs();
        if apart < wall + 1.0 && along > 0.003 {
            milled += 1;
            assert!((apart - wall).abs() < 0.006, "{apart} mm apart");
        }
    }
    // Two rows of 120 mm at 4 mm/s.
    assert!(
        (55_000..70_000).contains(&milled),
        "{milled} ms in the panel"
    );
}

/// Settings that bear each other, from next to nothing to the ends of their ranges.
fn some_settings(random: &mut impl FnMut() -> f64) -> Settings {
    loop {
        let mut settings = Settings::<6>::default();
        let mut put = |number: u16, value: f64| settings.put(number, value as f32).unwrap();
        put(0, 1.0 + 24.0 * random());
        put(1010, (2.0 * random()).floor());
        put(29, 1000.0 * random());
        put(1011, 1000.0 * random());
        for motor in 0..6 {
            let mut share = |least: f64, most: f64| least * (most / least).powf(random());
            put(100 + motor, share(1e-3, 1e5));
            put(110 + motor, share(1e-3, 1e5));
            put(120 + motor, share(1e-3, 1e5));
            put(800 + motor, share(1e-3, 1e8));
            put(1040 + motor, -share(1.0, 1e9));
            put(1050 + motor, share(1.0, 1e9));
        }
        for motor in 0..6 {
            if random() < 0.3 {
                let end = settings.get(1050 + motor).unwrap();
                settings.put(1040 + motor, end / 2.0).unwrap();
            }
        }
        if settings.check(machine::TICK_HZ).is_ok() {
            return settings;
        }
    }
}

/// Line by line, and whatever the machine had before: no line meets a setting of before that it does not bear.
#[test]
fn the_lines_of_any_settings_are_taken_after_those_of_any_others() {
    let mut state = 0x0DDB_1A5E_5BAD_5EED_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    machine::with(|machine| {
        machine.ask("");
        for _ in 0..60 {
            let wanted = some_settings(&mut random);

            for line in lines::setting_lines(&wanted) {
                assert_eq!(machine.ask(&line), "ok\r\n", "{line}");
            }

            for ((number, has), (_, wants)) in machine.controller.settings().all().zip(wanted.all())
            {
                // A decimal is read to the last place but one of an f32.
                let near = (has - wants).abs() <= 2e-7 * wants.abs();
                assert!(near || number == 1012, "${number}: {has} for {wants}");
            }
        }
    });
}

#[test]
fn what_no_machine_can_be_told_by_lines_is_said() {
    let refused = lines::of(&job("stop-to-stop")).unwrap_err();
    assert_eq!(refused.name, "NotOffered");
    assert!(refused.key.unwrap().starts_with("point[0]"));
    assert!(refused.detail.contains("dwell"));
}
