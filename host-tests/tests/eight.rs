//! Eight motors: a two-sided machine's X Y Z B twice. In memory, and the Octopus's own firmware in the emulator.

mod common;

use common::emulator::{
    ALLOW, JOB, ask, assert_equal_stretches, boot_for_motion, say_not_run, within,
};
use common::pulses_of_lines;
use hexstep::settings::Settings;
use hexstep_host::emulator::{OCTOPUS, Pulses, octopus_from_environment};
use hexstep_host::job::{Job, Task};
use hexstep_host::machine::{self, Machine};
use hexstep_host::pair::{PairPlan, What};
use hexstep_host::process::Made;
use hexstep_host::run;

/// Lines of counts: all motors, each alone at another rate, both presets.
const COUNTS: [&str; 4] = [
    "$SEG=1000,-1000,1000,-1000,1000,-1000,1000,-1000,0.05",
    "$SEG=987,-610,377,-233,144,-89,55,-34,0.06,CENTRED",
    "$SEG=0,0,0,0,0,0,0,777,0.04",
    "$SEG=-1987,1610,-1377,1233,-1144,1089,-1055,257,0.1",
];

/// A path of eight joints that turn round at different times.
fn path() -> Vec<String> {
    let mut lines: Vec<String> = (1..=60)
        .map(|k| {
            let at = |i: usize| {
                let angle = 0.1 * f64::from(k) * (1.0 + 0.3 * i as f64);
                (3000.0 * angle.sin()) as i32
            };
            let steps: Vec<String> = (0..8).map(|i| at(i).to_string()).collect();
            format!("$MOVE={},0.02", steps.join(","))
        })
        .collect();
    lines.push("$MOVE=END".into());
    lines
}

/// Runs lines that may belong to one stream.
fn run(machine: &mut Machine<'_, 8>, lines: &[String]) -> Pulses {
    machine.take_trace();
    pulses_of_lines(machine, lines)
}

fn with_eight<R>(body: impl FnOnce(&mut Machine<'_, 8>) -> R) -> R {
    machine::with_motors(|machine| {
        machine.ask("");
        body(machine)
    })
}

#[test]
fn eight_motors_make_the_counts_of_a_line() {
    with_eight(|machine| {
        machine.take_trace();

        let answer = machine.ask("$SEG=1000,-500,250,-125,63,-31,15,-7,0.5");

        assert_eq!(answer, "ok\r\n");
        let made = machine.take_trace().positions();
        assert_eq!(made, [1000, -500, 250, -125, 63, -31, 15, -7]);
    });
}

#[test]
fn a_line_with_the_numbers_of_six_motors_is_refused_by_eight() {
    with_eight(|machine| {
        for line in [
            "$SEG=1,2,3,4,5,6,0.1",
            "$MOVE=1,2,3,4,5,6,0.1",
            "$MOVE=1,2,3,4,5,6,7,8,0.1,9",
        ] {
            assert_eq!(machine.ask(line), "error:2\r\n", "{line}");
        }
        assert_eq!(machine.controller.counts(), [0; 8]);
    });
}

#[test]
fn all_eight_end_a_path_where_it_ends() {
    with_eight(|machine| {
        let pulses = run(machine, &path());

        assert!(pulses.len() > 10_000);
        let end = std::array::from_fn(|i| {
            let angle = 6.0 * (1.0 + 0.3 * i as f64);
            (3000.0 * angle.sin()) as i32
        });
        assert_eq!(machine.controller.counts(), end);
        assert_eq!(machine.starved(), 0);
    });
}

#[test]
fn the_status_report_and_the_build_info_name_eight_axes() {
    with_eight(|machine| {
        machine.ask("$SEG=1000,0,0,2000,0,0,0,-1000,0.5");

        machine.put(b"?");
        machine.run(3);

        let report = machine.heard();
        assert!(
            report.starts_with("<Idle|MPos:1.000,0.000,0.000,1.000,0.000,0.000,0.000,-0.500|"),
            "{report}"
        );
        assert!(
            report.contains("|WCO:0.000,0.000,0.000,0.000,0.000,0.000,0.000,0.000"),
            "{report}"
        );
        let info = machine.ask("$I");
        assert!(info.contains("[AXS:8:XYZABCUV]"), "{info}");
        assert!(info.contains(",8,0]"), "{info}");
    });
}

#[test]
fn each_axis_setting_has_eight_numbers_and_no_ninth() {
    with_eight(|machine| {
        let all = machine.ask("$$");

        assert!(all.ends_with("ok\r\n"));
        for row in [100, 110, 120, 800, 1030, 1040, 1050] {
            for axis in 0..8 {
                assert!(all.contains(&format!("${}=", row + axis)), "{row} {axis}");
            }
            assert_eq!(machine.ask(&format!("${}=1", row + 8)), "error:3\r\n");
        }
        assert_eq!(machine.ask("$107=250"), "ok\r\n");
        assert!(machine.ask("$$").contains("\r\n$107=250\r\n"));
    });
}

#[test]
fn the_last_motor_of_each_side_turns_unless_the_mask_says_otherwise() {
    let mut settings = Settings::<8>::default();

    let steps = settings.steps_per_joint_unit();
    settings.put(376, 0.0).unwrap();
    let sliding = settings.steps_per_joint_unit();

    // 1000 steps/mm; 2000 steps/deg are 114 592 steps/rad.
    for (motor, steps) in steps.iter().enumerate() {
        if motor == 3 || motor == 7 {
            assert!((steps - 114_591.56).abs() < 0.1, "motor {motor}: {steps}");
        } else {
            assert_eq!(*steps, 1000.0, "motor {motor}");
        }
    }
    assert_eq!(sliding[3], 2000.0);
    assert_eq!(sliding[7], 2000.0);
}

#[test]
fn a_mask_of_motors_that_do_not_exist_is_refused() {
    let mut eight = Settings::<8>::default();
    let mut six = Settings::<6>::default();

    for bad in [32.0, 1.5] {
        assert!(eight.put(376, bad).is_err(), "{bad}");
    }
    assert!(eight.put(376, 31.0).is_ok());
    assert!(six.put(376, 8.0).is_err());
    assert_eq!(six.get(376), Some(7.0));
}

#[test]
fn a_drill_is_ground_by_the_first_six_while_the_others_stand_still() {
    const SHORT: &str = "$DRILL=D9.9,W1.63,P118,C50,R10,F30,S0.03,A0.02,B0.01,N1,K0,V300,I100,Q2";
    let coarse: Vec<String> = (0..6)
        .flat_map(|i| {
            let (steps, rate) = if i < 3 { (200, 15_000) } else { (400, 18_000) };
            [
                format!("${}={steps}", 100 + i),
                format!("${}={rate}", 110 + i),
                format!("${}=4000", 120 + i),
            ]
        })
        .collect();
    let six = machine::with(|machine| {
        for line in &coarse {
            machine.ask(line);
        }
        machine.ask(SHORT);
        assert!(machine.ask("$DRILL=RUN").ends_with("ok\r\n"));
        machine.controller.counts()
    });

    with_eight(|machine| {
        for line in &coarse {
            machine.ask(line);
        }
        machine.ask(SHORT);

        // The fifth and the sixth motor slide on a two-sided machine.
        let refused = machine.ask("$DRILL=RUN");
        machine.ask("$376=7");
        machine.ask("$SEG=0,0,0,0,0,0,40,-30,0.1");
        let answer = machine.ask("$DRILL=RUN");

        assert!(refused.contains("see $376]\r\nerror:52"), "{refused}");
        assert_eq!(answer, "ok\r\n");
        let counts = machine.controller.counts();
        assert_eq!(counts[..6], six);
        assert_eq!(counts[6..], [40, -30]);
    });
}

#[test]
fn the_octopus_makes_the_pulses_of_the_host_tick_for_tick_on_eight_motors() {
    let Some(firmware) = octopus_from_environment() else {
        return say_not_run("HEXSTEP_FIRMWARE_OCTOPUS");
    };
    let mut emulator = boot_for_motion(firmware, OCTOPUS);
    let jobs: Vec<Vec<String>> = COUNTS
        .iter()
        .map(|line| vec![line.to_string()])
        .chain([path()])
        .collect();

    with_eight(|machine| {
        machine.ask(ALLOW);
        let mut changes = 0;
        for job in &jobs {
            let wanted = run(machine, job);
            emulator.take_recording();
            for line in job {
                assert_eq!(ask(&mut emulator, line), ["ok"], "{line}");
            }
            emulator.expect_idle(JOB).unwrap();
            let recording = emulator.take_recording();

            let difference = wanted.first_difference(&recording.pulses());
            assert_eq!(
                difference, None,
                "{}: change, as in memory, as in the emulator",
                job[0]
            );
            assert_eq!(recording.most_stores_in_a_tick(), 1, "one store a port");
            changes += wanted.len();
        }
        assert!(changes > 20_000, "{changes} edges are not much of a test");
        assert_eq!(machine.starved(), 0);
    });
}

/// Both sides go in and begin their first row; counted from where that begins, for all the way to it would take the emulator
/// minutes.
#[test]
fn a_stretch_of_every_mirror_job_makes_the_pulses_of_the_host_on_the_octopus() {
    let Some(firmware) = octopus_from_environment() else {
        return say_not_run("HEXSTEP_FIRMWARE_OCTOPUS");
    };
    for name in ["mirror-panel", "mirror-skin", "mirror-bias"] {
        let file = format!("{}/jobs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let job = Job::load(file.as_ref()).unwrap();
        let (Task::Mirror(mirror), Some(Made::Mirror(walls))) =
            (&job.task, Made::of(&job).unwrap())
        else {
            panic!("{name} mills no panel");
        };
        let (pair, simulation) = (mirror.pair.as_ref().unwrap(), &mirror.simulations[0]);
        let plan = PairPlan::of(&job, pair, &run::milling(simulation, &walls)).unwrap();
        let mut settings = run::pair::settings(&job, pair, simulation, &plan).unwrap();
        let [engage, row, ..] = &plan.legs[..] else {
            panic!("{name} has no row");
        };
        assert_eq!([engage.what, row.what], [What::Engage, What::Row(0)]);
        let start = run::pair::target(&job, pair, &plan.start, 0.0).unwrap();
        let legs = [engage, row].map(|leg| {
            let mut targets = run::pair::targets(&job, pair, leg).unwrap();
            for target in &mut targets {
                target.steps = std::array::from_fn(|i| target.steps[i] - start.steps[i]);
            }
            targets
        });
        for (motor, at) in (0u16..).zip(plan.start) {
            for end in [1040 + motor, 1050 + motor] {
                let left = settings.get(end).unwrap() - at as f32;
                settings.put(end, left).unwrap();
            }
        }
        let mut emulator = boot_for_motion(firmware.clone(), OCTOPUS);

        let stretches = [&legs[0][..], within(&legs[1], 1.0)];
        let edges = assert_equal_stretches(name, &mut emulator, &settings, &stretches);

        assert!(stretches[1].len() > 1, "a corner is part of it");
        assert!(edges > 20_000, "{edges} edges are not much of a test");
    }
}
