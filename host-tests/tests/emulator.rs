//! The ELF that is flashed, booted in the emulator and spoken to over its serial line; its pulses held against those of
//! the machine in memory, tick for tick.
//!
//! `cargo xtask test` builds the firmware and names it in `HEXSTEP_FIRMWARE`. Without that these tests have nothing to
//! boot and say so.

mod common;

use common::Random;
use common::emulator::{ALLOW, JOB, ask, assert_equal_stretches, on_both, say_not_run, within};
use hexstep_host::duel::{self, contests};
use hexstep_host::emulator::{
    Elf, Emulator, Options, Pulses, Recording, Register, SKR_PRO, firmware_from_environment,
    image_from_environment,
};
use hexstep_host::job::{Job, Task};
use hexstep_host::lines::targets_of;
use hexstep_host::machine;
use hexstep_host::poses::Plan;
use hexstep_host::process::Made;
use hexstep_host::run;
use std::path::PathBuf;
use std::time::Duration;

/// A machine with a fifth of the usual resolution and ten times the usual acceleration, so that a cycle is done in a
/// million ticks and still has rates of 100 000 steps/s.
const COARSE: [&str; 18] = [
    "$100=200",
    "$101=200",
    "$102=200",
    "$103=400",
    "$104=400",
    "$105=400",
    "$110=15000",
    "$111=15000",
    "$112=15000",
    "$113=18000",
    "$114=18000",
    "$115=18000",
    "$120=4000",
    "$121=4000",
    "$122=4000",
    "$123=4000",
    "$124=4000",
    "$125=4000",
];
/// A small cycle: both flanks, two passes.
const SHORT: &str = "$DRILL=D9.9,W1.63,P118,C50,R10,F30,S0.03,A0.02,B0.01,N1,K0,V300,I100,Q2";
/// Where it leaves the motors of the coarse machine: retracted by 3 mm at mu = -2 deg, flank 1 in front; a fifth of
/// 2543, 3049, 157, 100, -1997, 3463.
const AFTER_SHORT: [i64; 8] = [509, 610, 31, 20, -399, 693, 0, 0];
const SOON: Duration = Duration::from_secs(30);

fn firmware() -> Option<PathBuf> {
    let firmware = firmware_from_environment();
    if firmware.is_none() {
        say_not_run("HEXSTEP_FIRMWARE");
    }
    firmware
}

fn boot(firmware: PathBuf) -> Emulator {
    common::emulator::boot(firmware, SKR_PRO)
}

/// Boots a firmware that may move.
fn boot_for_motion(firmware: PathBuf) -> Emulator {
    common::emulator::boot_for_motion(firmware, SKR_PRO)
}

/// Runs each line to rest in the emulator and in memory and holds the pulses of every line against each other; the
/// recordings.
#[track_caller]
fn assert_equal_pulses(emulator: &mut Emulator, lines: &[&str]) -> Vec<Recording> {
    let wanted: Vec<Pulses> = machine::with(|machine| {
        machine.ask(ALLOW);
        machine.take_trace();
        lines
            .iter()
            .map(|line| {
                let answer = machine.ask(line);
                assert!(answer.ends_with("ok\r\n"), "{line}: {answer}");
                Pulses::of_trace(&machine.take_trace())
            })
            .collect()
    });
    emulator.take_recording();

    let recordings: Vec<Recording> = lines
        .iter()
        .map(|line| {
            assert_eq!(ask(emulator, line), ["ok"], "{line}");
            emulator.expect_idle(JOB).unwrap();
            emulator.take_recording()
        })
        .collect();

    for ((line, wanted), recording) in lines.iter().zip(&wanted).zip(&recordings) {
        let difference = wanted.first_difference(&recording.pulses());
        assert_eq!(
            difference, None,
            "{line}: change, as in memory, as in the emulator"
        );
        assert!(
            recording.most_stores_in_a_tick() <= 1,
            "{line}: more than one store to a port in a tick"
        );
    }
    assert_eq!(ask(emulator, "$STAT"), ["[MSG:starved 0]", "ok"]);
    recordings
}

#[test]
fn the_firmware_starts_says_who_it_is_and_stands_at_zero() {
    let Some(firmware) = firmware() else { return };

    let mut emulator = Emulator::boot(&Options::new(firmware)).unwrap();

    assert_eq!(
        emulator.expect_banner().unwrap().last().unwrap(),
        "Grbl 1.1h ['$' for help]"
    );
    let fault = emulator.next_line(SOON).unwrap();
    assert!(
        fault.starts_with("[MSG:Clock fault: internal oscillator silent"),
        "{fault}"
    );
    let report = emulator.status(SOON).unwrap();
    assert!(
        report.starts_with("<Idle|MPos:0.000,0.000,0.000,0.000,0.000,0.000|"),
        "{report}"
    );
}

#[test]
fn with_a_failed_clock_nothing_moves_until_a_setting_allows_it() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot(firmware);

    let refused = ask(&mut emulator, "$SEG=5,5,5,5,5,5,0.01");
    emulator.expect_idle(SOON).unwrap();
    let before = emulator.take_recording();
    let allowed = [
        ask(&mut emulator, ALLOW),
        ask(&mut emulator, "$SEG=5,5,5,5,5,5,0.01"),
    ];
    emulator.expect_idle(SOON).unwrap();
    let after = emulator.take_recording();

    assert_eq!(refused.last().unwrap(), "error:56");
    assert_eq!(before.changes(), []);
    assert_eq!(allowed, [["ok"], ["ok"]]);
    assert_eq!(after.positions(false), [5, 5, 5, 5, 5, 5, 0, 0]);
}

#[test]
fn lines_of_counts_make_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);

    let recordings = assert_equal_pulses(
        &mut emulator,
        &[
            "$SEG=7,3,-5,1,0,2,0.01",
            "$SEG=7,3,-5,1,0,2,0.01,CENTRED",
            "$SEG=-7,-3,5,-1,0,-2,2",
            "$SEG=10000,-6180,3819,-2360,1459,901,0.1",
            "$SEG=-20000,20000,-20000,20000,-20000,20000,0.2,CENTRED",
            "$SEG=0,0,0,0,0,1,0.5",
        ],
    );

    assert_eq!(recordings[0].positions(false), [7, 3, -5, 1, 0, 2, 0, 0]);
    assert_eq!(
        recordings[3].positions(false),
        [10000, -6180, 3819, -2360, 1459, 901, 0, 0]
    );
}

#[test]
fn in_both_edge_mode_the_pulses_are_those_of_the_host_too() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);

    let recordings = assert_equal_pulses(
        &mut emulator,
        &[
            "$1010=1",
            "$SEG=7,3,-5,1,0,2,0.01",
            "$SEG=-20001,20001,-333,5000,1,20001,0.1",
            "$SEG=20001,-20001,333,-5000,-1,-20001,0.2",
        ],
    );

    assert_eq!(
        recordings[2].positions(true),
        [-20001, 20001, -333, 5000, 1, 20001, 0, 0]
    );
}

#[test]
fn a_drill_cycle_makes_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);

    let recordings = assert_equal_pulses(
        &mut emulator,
        &[&COARSE[..], &[SHORT, "$DRILL=RUN"]].concat(),
    );

    let report = emulator.status(SOON).unwrap();
    assert_eq!(recordings.last().unwrap().positions(false), AFTER_SHORT);
    // Steps over 200 a mm and 400 a degree; -399 and 693 steps lie on the half of a thousandth, told away from zero.
    assert!(
        report.starts_with("<Idle|MPos:2.545,3.050,0.155,0.050,-0.998,1.733|"),
        "{report}"
    );
}

#[test]
fn reversals_at_low_and_at_high_rate_are_those_of_the_host() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);

    // A stroke goes there and back on every motor: once at a few thousand steps a second, once at up to 100 000.
    let slow = [
        "$DRILL=S0.01,A0.02,B0.01,N0,K0,V30,I5,Q2,E0.2",
        "$DRILL=RUN",
    ];
    let fast = [
        "$DRILL=S0.02,A0.02,B0.01,N0,K0,V300,I20,Q2,E0.2",
        "$DRILL=RUN",
    ];
    assert_equal_pulses(&mut emulator, &[&COARSE[..], &slow, &fast].concat());
}

#[test]
fn refused_lines_are_answered_as_in_memory_and_move_nothing() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);
    let lines = [
        "$DRILL=D-1",
        "$DRILL=R4",
        "$DRILL=F3",
        "$DRILL=D10,W1.82,P140.74,C61.41,R19.87,F47.17",
        "$DRILL=N1.5",
        "$DRILL=Dnan",
        "$DRILL=X1",
        "$SEG=100000000,0,0,0,0,0,1",
        "$SEG=0,0,0,-100000,0,0,0.1",
        "$SEG=0,200001,0,0,0,0,10",
        "$SEG=1,2,3",
        "$0=0.5",
        "$999=1",
        "G0 X1",
    ];
    let wanted: Vec<String> = machine::with(|machine| {
        machine.ask(ALLOW);
        lines.iter().map(|line| machine.ask(line)).collect()
    });

    let answers: Vec<String> = lines
        .iter()
        .map(|line| {
            let lines = ask(&mut emulator, line);
            lines.iter().map(|line| format!("{line}\r\n")).collect()
        })
        .collect();

    assert_eq!(answers, wanted);
    emulator.expect_idle(SOON).unwrap();
    assert_eq!(emulator.take_recording().changes(), []);
}

#[test]
fn any_bytes_at_all_leave_a_machine_that_answers() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);
    // Every byte but soft reset, in an order without pattern, and far more of them than the buffer holds; then the end of
    // a hold that may be among them.
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let bytes: Vec<u8> = (0..20_000)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 32) as u8
        })
        .filter(|byte| *byte != 0x18)
        .collect();

    emulator.send_bytes(&bytes).unwrap();
    emulator.send_bytes(b"~\n").unwrap();

    emulator.expect_idle(JOB).unwrap();
    emulator.send("$STAT").unwrap();
    emulator
        .expect("counters", SOON, |line| line == "[MSG:starved 0]")
        .unwrap();
    assert_eq!(emulator.take_recording().motion(), 0..0);
}

#[test]
fn a_soft_reset_in_motion_stops_the_motors_and_keeps_their_count() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);
    for line in COARSE {
        assert_eq!(ask(&mut emulator, line), ["ok"], "{line}");
    }
    assert_eq!(ask(&mut emulator, SHORT), ["ok"]);
    emulator.take_recording();

    assert_eq!(ask(&mut emulator, "$DRILL=RUN"), ["ok"]);
    emulator
        .wait_for("motion", JOB, |recording| {
            recording.changes().len() > 10_000
        })
        .unwrap();
    emulator.send_bytes(&[0x18]).unwrap();
    let lines = emulator
        .expect("alarm and banner", SOON, |line| line.starts_with("Grbl"))
        .unwrap();
    let report = emulator.status(SOON).unwrap();
    let moved = emulator.take_recording();

    assert!(lines.iter().any(|line| line == "ALARM:3"), "{lines:?}");
    assert!(report.starts_with("<Alarm|MPos:"), "{report}");
    // The report tells the fraction of a step as well.
    let positions = moved.positions(false);
    for (motor, text) in report["<Alarm|MPos:".len()..]
        .split(['|', ','])
        .take(6)
        .enumerate()
    {
        let steps = text.parse::<f64>().unwrap() * if motor < 3 { 200.0 } else { 400.0 };
        assert!(
            (steps - positions[motor] as f64).abs() <= 1.5,
            "motor {motor}: {} steps put out, {text} reported",
            positions[motor]
        );
    }
    assert_eq!(ask(&mut emulator, "$DRILL=RUN"), ["error:9"]);
    emulator.status(SOON).unwrap();
    assert_eq!(
        emulator.take_recording().motion(),
        0..0,
        "nothing moves in alarm"
    );
    assert_eq!(ask(&mut emulator, "$X"), ["[MSG:Caution: Unlocked]", "ok"]);
    assert_eq!(ask(&mut emulator, "$DRILL=RUN"), ["ok"]);
    emulator.expect_idle(JOB).unwrap();
    let rest = emulator.take_recording().positions(false);
    let sum: Vec<i64> = positions.iter().zip(rest).map(|(a, b)| a + b).collect();
    assert_eq!(sum, AFTER_SHORT);
}

/// Breaks the firmware in motion and holds it to its safe state: all drivers off, no step pin active, for good.
#[track_caller]
fn assert_safe_state(firmware: PathBuf, last_words: &str, register: Register, value: u32) {
    let mut emulator = boot_for_motion(firmware);
    assert_eq!(
        ask(&mut emulator, "$SEG=50000,50000,50000,50000,50000,50000,1"),
        ["ok"]
    );
    emulator
        .wait_for("motion", JOB, |recording| recording.changes().len() > 1000)
        .unwrap();

    emulator.debug().unwrap().set(register, value).unwrap();

    emulator
        .expect(last_words, SOON, |line| line.starts_with(last_words))
        .unwrap();
    let recording = emulator.finish().unwrap();
    let last = recording.changes().last().unwrap();
    assert!(
        recording
            .changes()
            .iter()
            .any(|change| change.enabled == 0b11_1111)
    );
    assert_eq!((last.levels, last.enabled), (0, 0), "after the fault");
    assert!(recording.positions(false)[0] < 50_000, "the motion went on");
}

#[test]
fn a_stack_overflow_in_motion_ends_with_drivers_off_and_step_pins_low() {
    let Some(firmware) = firmware() else { return };

    // The stack is at the start of RAM: the next push leaves it.
    assert_safe_state(
        firmware,
        "[MSG:Hard fault",
        Register::StackPointer,
        0x2000_0000,
    );
}

#[test]
fn a_jump_to_nowhere_in_motion_ends_with_drivers_off_and_step_pins_low() {
    let Some(firmware) = firmware() else { return };

    assert_safe_state(
        firmware,
        "[MSG:Hard fault",
        Register::ProgramCounter,
        0x6000_0000,
    );
}

#[test]
fn a_panic_in_motion_ends_with_drivers_off_and_step_pins_low() {
    let Some(firmware) = firmware() else { return };
    let functions = Elf::read(&firmware).unwrap().functions();
    let (_, panic) = functions
        .iter()
        .find(|(name, _)| name.contains("rust_begin_unwind") || name.contains("panic_fmt"))
        .unwrap();

    assert_safe_state(firmware, "[MSG:Panic", Register::ProgramCounter, *panic);
}

/// Undoes the framing of defmt's log frames (reverse-zero-compressing COBS): read from the end, a byte tells which of
/// the seven bytes before it are zeros, or how many are none.
fn unframe(frame: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut rest = frame.iter().rev().copied();
    while let Some(code) = rest.next() {
        match code {
            0 => return None,
            1..=0x7f => {
                for bit in (0..7).rev() {
                    bytes.push(if code >> bit & 1 == 0 {
                        rest.next()?
                    } else {
                        0
                    });
                }
            }
            0x80..=0xfe => {
                bytes.push(0);
                for _ in 0..(code & 0x7f) + 7 {
                    bytes.push(rest.next()?);
                }
            }
            0xff => {
                for _ in 0..134 {
                    bytes.push(rest.next()?);
                }
            }
        }
    }
    bytes.reverse();
    Some(bytes)
}

#[test]
fn the_log_tells_the_board_the_clock_and_the_drivers_in_whole_frames() {
    let Some(firmware) = firmware() else { return };
    let log = std::env::temp_dir().join(format!("hexstep-log-{}", std::process::id()));
    let mut options = Options::new(firmware);
    options.log = Some(log.clone());
    let mut emulator = Emulator::boot(&options).unwrap();
    emulator.expect_banner().unwrap();

    assert_eq!(ask(&mut emulator, ALLOW), ["ok"]);
    assert_eq!(ask(&mut emulator, "$SEG=5,0,0,0,0,0,0.01"), ["ok"]);
    emulator.expect_idle(SOON).unwrap();
    emulator.finish().unwrap();
    let bytes = std::fs::read(&log).unwrap();
    std::fs::remove_file(&log).unwrap();

    let frames: Vec<Vec<u8>> = bytes
        .split(|byte| *byte == 0)
        .filter(|frame| !frame.is_empty())
        .map(|frame| unframe(frame).unwrap())
        .collect();
    assert_eq!(frames.len(), 2, "{frames:?}");
    let text = String::from_utf8_lossy(&frames[0]);
    assert!(text.contains("BTT SKR Pro v1.2"), "{text:?}");
    assert!(text.contains("internal oscillator silent"), "{text:?}");
    // The number of the message, then the answer: drivers on.
    assert_eq!(frames[1].get(2), Some(&1), "{frames:?}");
}

#[test]
fn the_image_behind_a_bootloader_starts_as_well() {
    let Some(image) = image_from_environment() else {
        say_not_run("HEXSTEP_FIRMWARE_BOOTLOADER");
        return;
    };
    let mut emulator = boot_for_motion(image);

    assert_eq!(ask(&mut emulator, "$SEG=3,0,0,0,0,-3,0.01"), ["ok"]);
    emulator.expect_idle(SOON).unwrap();

    let positions = emulator.take_recording().positions(false);
    assert_eq!(positions, [3, 0, 0, 0, 0, -3, 0, 0]);
}

/// A joint path of all kinds of moves, with holds, overrides and trims at given milliseconds; every fifth one is longer
/// than the look-ahead.
fn program(seed: u64) -> Vec<String> {
    let mut r = Random(seed);
    let mut lines = Vec::new();
    let mut at = 5 + r.whole(60);
    for _ in 0..1 + r.whole(5) {
        let hold = 1 + r.whole(120);
        match r.whole(5) {
            0 => {
                lines.push(format!("$CUE={at},HOLD"));
                lines.push(format!("$CUE={},RESUME", at + hold));
                at += hold;
            }
            1 => lines.push(format!("$CUE={at},FEED,{}", 10 + r.whole(191))),
            2 => lines.push(format!("$CUE={at},RAPID,{}", 5 + r.whole(96))),
            3 => lines.push(format!(
                "$CUE={at},TRIM,{},{}",
                r.whole(6),
                r.whole(41) - 20
            )),
            _ => lines.push(format!(
                "$CUE={at},FEED,{}",
                [50, 100, 200][r.whole(3) as usize]
            )),
        }
        at += 1 + r.whole(80);
    }
    let count = if seed.is_multiple_of(5) {
        120
    } else {
        3 + r.whole(30)
    };
    let mut q = [0i64; 6];
    let size = [3, 60, 1500][r.whole(3) as usize];
    for k in 0..count {
        match r.whole(4) {
            // All joints anywhere.
            0 => q = q.map(|x| (x + r.whole(2 * size + 1) - size).clamp(-4000, 4000)),
            // A smooth piece.
            1 | 2 => {
                for (i, x) in q.iter_mut().enumerate() {
                    let angle = k as f64 * 0.2 * (i + 1) as f64;
                    *x += (angle.cos() * size as f64 * 0.2) as i64;
                    *x = (*x).clamp(-4000, 4000);
                }
            }
            // One joint, there and back.
            _ => {
                let i = r.whole(6) as usize;
                q[i] = -q[i] + r.whole(3) - 1;
            }
        }
        let words: Vec<String> = q.iter().map(i64::to_string).collect();
        let ms = r.whole(25);
        lines.push(format!("$MOVE={},0.{:03}", words.join(","), ms));
    }
    lines.push("$MOVE=END".into());
    lines
}

#[test]
fn a_stretch_of_every_job_with_poses_makes_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    for name in [
        "pole-crossing",
        "arm-path",
        "two-sided",
        "dune-hard",
        "dune-soft",
        "shell-soft",
        "precession-plane",
        "precession-curved",
    ] {
        let file = format!("{}/jobs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        // Other strategies make no pulses.
        let text = std::fs::read_to_string(&file)
            .unwrap()
            .replace("compare = true", "compare = false");
        let job = Job::parse(&file, name, text.as_bytes()).unwrap();
        let made = Made::of(&job).unwrap();
        let poses = match &job.task {
            Task::Poses(poses) => poses.as_ref(),
            _ => made.as_ref().and_then(Made::poses).unwrap(),
        };
        let plan = Plan::of(&job, poses).unwrap();
        let settings = run::settings(&job, Some((poses, &plan))).unwrap();
        let targets = run::targets(&job, poses, &plan).unwrap();
        // The approach, and what half a second of the path holds.
        let (approach, path) = targets.split_at(1);
        let stretches = [approach, within(path, 0.5)];
        let mut emulator = boot_for_motion(firmware.clone());

        assert_equal_stretches(name, &mut emulator, &settings, &stretches);
    }
}

#[test]
fn a_stretch_of_every_path_of_joints_makes_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    for name in ["stop-to-stop", "circle", "trochoid", "flexible"] {
        let file = format!("{}/jobs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let job = Job::load(file.as_ref()).unwrap();
        let Task::Path(path) = &job.task else {
            panic!("{name} is a path");
        };
        let settings = run::settings(&job, None).unwrap();
        let targets = targets_of(path);
        let mut emulator = boot_for_motion(firmware.clone());

        let stretch = within(&targets, 0.3);
        assert_equal_stretches(name, &mut emulator, &settings, &[stretch]);
    }
}

/// The paths of the duel: dense curves, sharp corners of all kinds, three joints and six.
#[test]
fn a_stretch_of_every_path_of_the_duel_makes_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    for contest in contests() {
        let text = duel::job(&contest, 80.0, 20_000.0);
        let job = Job::parse(contest.name, contest.name, text.as_bytes()).unwrap();
        let Task::Path(path) = &job.task else {
            panic!("{} is a path", contest.name);
        };
        let settings = run::settings(&job, None).unwrap();
        let targets = targets_of(path);
        let mut emulator = boot_for_motion(firmware.clone());

        // In corners it takes several times as long as is programmed.
        let stretch = within(&targets, 0.3);
        assert_equal_stretches(contest.name, &mut emulator, &settings, &[stretch]);
    }
}

/// The first ten CL points of the frustum, faster and with larger steps than its job has: minutes become seconds.
#[test]
fn the_first_ten_points_of_the_frustum_make_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/jobs/frustum.toml"));
    let text: String = text
        .unwrap()
        .replace(
            "[1600, 1600, 1600, 5000, 5000]",
            "[160, 160, 160, 500, 500]",
        )
        .replace(
            "[  90,   90,   90,   30,   30]",
            "[600, 600, 600, 200, 200]",
        )
        .replace(
            "[1500, 1500, 1500,  400,  400]",
            "[9000, 9000, 9000, 3000, 3000]",
        )
        .replace(
            "[40000, 40000, 40000, 12000, 12000]",
            "[4e5, 4e5, 4e5, 1e5, 1e5]",
        )
        .replace("feed = 1000 ", "feed = 30000 ");
    let count = text
        .lines()
        .filter(|line| line.starts_with("    ["))
        .count();
    let text: String = text
        .lines()
        .scan(0, |seen, line| {
            *seen += usize::from(line.starts_with("    ["));
            Some((*seen, line))
        })
        .filter(|(seen, line)| *seen <= 10 || !line.starts_with("    ["))
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    assert_eq!(count, 13);
    let job = Job::parse("frustum.toml", "frustum", text.as_bytes()).unwrap();
    let Task::Poses(poses) = &job.task else {
        panic!("a job with poses")
    };
    let plan = Plan::of(&job, poses).unwrap();
    let settings = run::settings(&job, Some((poses, &plan))).unwrap();
    let targets = run::targets(&job, poses, &plan).unwrap();
    let (approach, path) = targets.split_at(1);

    assert_equal_stretches("frustum", &mut emulator, &settings, &[approach, path]);
}

#[test]
fn programs_with_holds_overrides_and_trims_make_the_pulses_of_the_host_tick_for_tick() {
    let Some(firmware) = firmware() else { return };
    let mut emulator = boot_for_motion(firmware);
    let mut settings: Vec<String> = COARSE.iter().map(|&line| line.into()).collect();
    settings.extend(["$1003=0.05".into(), "$1013=0.2".into()]);

    machine::with(|machine| {
        machine.ask(ALLOW);
        for line in &settings {
            assert!(machine.ask(line).ends_with("ok\r\n"));
            assert_eq!(ask(&mut emulator, line), ["ok"]);
        }
        let mut changes = 0;
        for seed in 1..=20 {
            let lines = program(seed);
            let (wanted, pulses) = on_both(machine, &mut emulator, &lines);
            let difference = wanted.first_difference(&pulses);
            assert_eq!(
                difference, None,
                "program {seed}: change, as in memory, as in the emulator"
            );
            changes += wanted.len();
            // Back to where it began, without trims.
            let back: Vec<String> = (0..6)
                .map(|motor| format!("$CUE=1,TRIM,{motor},0"))
                .chain([
                    "$MOVE=1,1,1,1,1,1,0.1".into(),
                    "$MOVE=0,0,0,0,0,0,0.1".into(),
                ])
                .chain(["$MOVE=END".into()])
                .collect();
            on_both(machine, &mut emulator, &back);
            assert_eq!(machine.controller.counts(), [0; 6], "program {seed}");
        }
        assert!(changes > 100_000, "{changes} edges are not much of a test");
        assert_eq!(machine.starved(), 0);
    });
    assert_eq!(ask(&mut emulator, "$STAT"), ["[MSG:starved 0]", "ok"]);
}
