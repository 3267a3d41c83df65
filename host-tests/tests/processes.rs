//! Processes over the serial line: points in, pulses out, and the tool rebuilt from the pulses.

mod common;

use common::emulator::{ask, boot_for_motion, on_both, say_not_run};
use common::{arm_lines, pair_lines, trace_of_lines};
use hexstep::protocol::reading::encode;
use hexstep_host::emulator::{
    OCTOPUS, PinMap, SKR_PRO, arm_from_environment, octopus_from_environment,
};
use hexstep_host::job::Job;
use hexstep_host::machine::{self, Machine};
use hexstep_host::reference::matrix::{angle_deg, distance, translation};
use hexstep_host::reference::serial::{Forward, Serial, SerialJoint, ToolAt};
use hexstep_host::trace::{TICK_HZ, Trace};
use std::path::PathBuf;

const MS: u64 = TICK_HZ / 1000;

/// The ER3B of section 9 of the specification, with the tool and the work of `arm_lines`.
fn arm() -> Forward {
    Forward::Arm {
        rows: [
            [0.0, 0.0, 320.0],
            [50.0, -90.0, 0.0],
            [270.0, 0.0, 0.0],
            [70.0, -90.0, 299.0],
            [0.0, 90.0, 0.0],
            [0.0, -90.0, 78.5],
        ],
        tool: translation([0.0, 0.0, 160.0]),
        work: translation([310.0, 0.0, 200.0]),
    }
}

/// A side of M4 in its bed coordinates, seen from the work frame of side 1.
fn side(first: bool) -> Forward {
    let s = if first { 1.0 } else { -1.0 };
    let slides = |axis| SerialJoint {
        carries_work: false,
        turns: false,
        axis,
        point: [0.0; 3],
    };
    Forward::Serial(Serial {
        joints: vec![
            slides([s, 0.0, 0.0]),
            slides([0.0, 1.0, 0.0]),
            slides([0.0, 0.0, s]),
            SerialJoint {
                carries_work: false,
                turns: true,
                axis: [0.0, 1.0, 0.0],
                point: [0.0, 0.0, if first { 450.0 } else { -430.0 }],
            },
        ],
        tip: [0.0, 0.0, 50.0 * s],
        axis: [0.0, 0.0, s],
        work: translation([600.0, 450.0, 0.0]),
    })
}

fn with_arm<R>(body: impl FnOnce(&mut Machine<'_>) -> R) -> R {
    machine::with(|machine| {
        machine.ask("");
        trace_of_lines(machine, &arm_lines());
        body(machine)
    })
}

fn with_pair<R>(body: impl FnOnce(&mut Machine<'_, 8>) -> R) -> R {
    machine::with_motors(|machine| {
        machine.ask("");
        trace_of_lines(machine, &pair_lines());
        body(machine)
    })
}

fn lines(text: &[&str]) -> Vec<String> {
    text.iter().map(|line| (*line).into()).collect()
}

/// The arm's tool every millisecond, from the pulses.
fn tools(trace: &Trace<6>) -> Vec<ToolAt> {
    let scale = [2500.0, 2500.0, 2500.0, 2000.0, 2000.0, 1500.0];
    let arm = arm();
    let rows = trace.rebuilt_every(MS);
    rows.iter()
        .map(|steps| arm.at(&std::array::from_fn(|i| (steps[i] / scale[i]).to_radians())))
        .collect()
}

/// Both tips and axes in the work frame of side 1 every millisecond, for motors that stood at `from` [steps].
fn tips(trace: &Trace<8>, from: [i32; 8]) -> Vec<[ToolAt; 2]> {
    let scale = [400.0, 400.0, 800.0, 5000.0];
    let sides = [side(true), side(false)];
    let rows = trace.rebuilt_every(MS);
    rows.iter()
        .map(|steps| {
            std::array::from_fn(|k| {
                let at = |i: usize| (steps[4 * k + i] + f64::from(from[4 * k + i])) / scale[i];
                let q = std::array::from_fn(|i| match i {
                    0..3 => at(i),
                    3 => at(i).to_radians(),
                    _ => 0.0,
                });
                sides[k].at(&q)
            })
        })
        .collect()
}

/// The refusals of lines said one after the other, each asked of a process that has begun with `begin`.
fn refusals<const N: usize>(
    machine: &mut Machine<'_, N>,
    begin: &[&str],
    rows: &[(&str, &str, u8)],
) {
    for line in begin {
        assert_eq!(machine.ask(line), "ok\r\n", "{line}");
    }
    let counts = machine.controller.counts();
    for (line, name, number) in rows {
        let answer = machine.ask(line);
        assert!(
            answer.starts_with(&format!("[MSG:{name}")),
            "{line}: {answer}"
        );
        assert!(
            answer.ends_with(&format!("error:{number}\r\n")),
            "{line}: {answer}"
        );
        assert_eq!(
            machine.controller.counts(),
            counts,
            "{line} moved something"
        );
    }
}

/// Cruising speed of the tip [mm/s]: the median over the places of which `holds`.
fn cruise(tools: &[ToolAt], holds: impl Fn(&ToolAt) -> bool) -> f64 {
    let mut speeds: Vec<f64> = tools
        .windows(101)
        .filter(|w| holds(&w[0]) && holds(&w[100]))
        .map(|w| distance(w[0].tip, w[100].tip) / 0.1)
        .collect();
    assert!(speeds.len() > 100, "{} ms", speeds.len());
    speeds.sort_by(f64::total_cmp);
    speeds[speeds.len() / 2]
}

#[test]
fn a_precession_of_points_turns_the_axis_about_the_normal_as_the_paper_has_it() {
    with_arm(|machine| {
        machine.take_trace();

        let trace = trace_of_lines(
            machine,
            &lines(&[
                "$PRECESS=T20,V5,W30,L127,E0.05",
                "$PRECESS=RUN",
                "$POINT=0,0,0,0,0,1",
                "$POINT=60,0,0,0,0,2",
                "$POINT=60,20,0,0,0,1",
                "$POINT=END",
            ]),
        );

        // A(t) = (v t + ..): the phase is 6 deg for a millimetre of path, wherever the tool is and however fast.
        let tools = tools(&trace);
        let begins = tools
            .iter()
            .position(|t| distance(t.tip, [0.0, 0.0, 39.5]) < 0.05);
        let ends = tools
            .iter()
            .rposition(|t| distance(t.tip, [60.0, 20.0, 39.5]) < 0.05);
        let path = &tools[begins.unwrap()..=ends.unwrap()];
        assert!(path.len() > 16_000, "{} ms of 80 mm at 5 mm/s", path.len());
        let mut worst = [0.0f64; 3];
        for tool in path {
            let [x, y, z] = tool.tip;
            // The nearest place of both legs.
            let [on_first, on_second] = [x.clamp(0.0, 60.0), y.clamp(0.0, 20.0)];
            let first = distance(tool.tip, [on_first, 0.0, 39.5]);
            let second = distance(tool.tip, [60.0, on_second, 39.5]);
            let (off, s) = if first < second {
                (first, on_first)
            } else {
                (second, 60.0 + on_second)
            };
            let alpha = (6.0 * s).to_radians();
            let (sin, cos) = 20.0f64.to_radians().sin_cos();
            let wanted = [sin * alpha.cos(), sin * alpha.sin(), cos];
            worst[0] = worst[0].max(off);
            worst[1] = worst[1].max((z - 39.5).abs());
            worst[2] = worst[2].max(angle_deg(tool.axis, wanted));
        }
        // A step of a joint carries the tip by 0.004 mm, and 0.05 mm along the path are 0.1 deg of axis.
        assert!(worst[0] <= 0.055 && worst[1] <= 0.055, "{worst:?} mm");
        assert!(worst[2] <= 0.3, "{worst:?} deg");
        assert_eq!(machine.starved(), 0);
        // Drawn back along the tool by 10 mm.
        let last = tools.last().unwrap();
        assert!(
            (distance(last.tip, [60.0, 20.0, 39.5]) - 10.0).abs() < 0.05,
            "{last:?}"
        );
    });
}

#[test]
fn a_single_point_is_a_dwell_under_precession() {
    with_arm(|machine| {
        machine.take_trace();

        let trace = trace_of_lines(
            machine,
            &lines(&[
                "$PRECESS=B6,O0",
                "$PRECESS=RUN",
                "$POINT=20,0,5,0,0,1",
                "$POINT=END",
            ]),
        );

        // 30 deg/s for 6 s: half a turn, begun along x because nothing says otherwise.
        let tools = tools(&trace);
        let last = tools.last().unwrap();
        let (sin, cos) = 20.0f64.to_radians().sin_cos();
        assert!(distance(last.tip, [20.0, 0.0, 44.5]) < 0.03, "{last:?}");
        let opposite = [[-sin, 0.0, cos], [0.0, -sin, cos]];
        let off = opposite.map(|axis| angle_deg(last.axis, axis));
        assert!(off[0].min(off[1]) < 0.05, "{last:?}");
    });
}

/// Two rows on a flat part: the wheel's depth of 0.1 mm asks for 14.442929 mm/s, the first line of the table of section 11.
#[test]
fn rows_are_ground_at_the_feed_that_gives_their_depth_and_the_wheel_is_lifted_between_them() {
    with_arm(|machine| {
        machine.take_trace();

        let trace = trace_of_lines(
            machine,
            &lines(&[
                "$SURF=P0.1,Z1",
                "$SURF=RUN",
                "$POINT=0,0,10,0,0,1,1,0,0",
                "$POINT=60,0,10,0,0,1,1,0,0",
                "$POINT=ROW",
                "$POINT=60,5,10,0,0,1,-1,0,0",
                "$POINT=0,5,10,0,0,1,-1,0,0",
                "$POINT=END",
            ]),
        );

        let tools = tools(&trace);
        let in_work =
            |t: &ToolAt| (t.tip[2] - 10.0).abs() < 0.05 && t.tip[0] > 10.0 && t.tip[0] < 50.0;
        for row in [0.0, 5.0] {
            let speed = cruise(&tools, |t| in_work(t) && (t.tip[1] - row).abs() < 0.06);
            assert!(
                (speed / 14.442929 - 1.0).abs() < 0.005,
                "row {row}: {speed} mm/s"
            );
        }
        let ground = |t: &&ToolAt| in_work(t);
        for tool in tools.iter().filter(ground) {
            assert!(angle_deg(tool.axis, [0.0, 0.0, 1.0]) < 0.06, "{tool:?}");
            // The axle stays as it is, backwards too.
            let off = angle_deg(tool.across.unwrap(), [1.0, 0.0, 0.0]);
            assert!(off < 0.06, "{tool:?}");
        }
        let lifted = tools.iter().filter(|t| t.tip[1] > 1.0 && t.tip[1] < 4.0);
        assert!(lifted.clone().count() > 10);
        for tool in lifted {
            assert!(tool.tip[2] > 19.0, "across the work at {tool:?}");
        }
        assert_eq!(machine.starved(), 0);
    });
}

/// A pass over the panel of section 8, the wall rebuilt from the pulses of both sides.
#[test]
fn a_row_of_the_panel_has_its_wall_all_the_way() {
    with_pair(|machine| {
        machine.take_trace();
        let point = |x: f64| {
            let z = (4000.0f64.powi(2) - x * x).sqrt();
            format!("$POINT={x},100,{:.6},{x},0,{z:.6}", z - 4000.0)
        };
        let mut list = lines(&["$MIRROR=V100", "$MIRROR=ON,1.5"]);
        list.extend((0..=10).map(|k| point(-250.0 + 50.0 * f64::from(k))));
        list.push("$MIRROR=OFF".into());

        let trace = trace_of_lines(machine, &list);

        let tips = tips(&trace, [0; 8]);
        let radius = |t: &ToolAt| t.tip[0].hypot(t.tip[2] + 4000.0);
        let at_work: Vec<_> = tips
            .iter()
            .filter(|[mill, _]| mill.tip[0].abs() < 245.0 && radius(mill) < 4001.52)
            .collect();
        assert!(
            at_work.len() > 4800,
            "{} ms of 490 mm at 100 mm/s",
            at_work.len()
        );
        let mut worst = [0.0f64; 4];
        for [mill, support] in at_work {
            // Chords of 50 mm on this radius lie 0.078 mm below the face.
            let n = mill.axis;
            let e: [f64; 3] = std::array::from_fn(|i| mill.tip[i] - support.tip[i]);
            let along: f64 = (0..3).map(|i| e[i] * n[i]).sum();
            let lateral = distance(e, n.map(|x| x * along));
            let sags = (radius(support) - 3999.922 + 0.02).min(0.0).abs();
            let tilt = angle_deg(n, support.axis.map(|x| -x));
            for (worst, now) in worst
                .iter_mut()
                .zip([(along - 1.5).abs(), lateral, tilt, sags])
            {
                *worst = worst.max(now);
            }
        }
        // A step of Z is 0.00125 mm, one of X 0.0025; the contour may be left by 0.01 mm.
        assert!(worst[0] <= 0.006 && worst[1] <= 0.012, "{worst:?}");
        assert!(worst[2] <= 0.01 && worst[3] <= 0.0, "{worst:?}");
        assert_eq!(machine.starved(), 0);
    });
}

/// The paper's walls are 0.055 mm too thin all alike, and trimming cannot see it.
#[test]
fn walls_that_were_gauged_too_thin_are_milled_thicker_next_time() {
    with_pair(|machine| {
        let point = |x: f64| format!("$POINT={x},0,0,0,0,1");
        let mill = |machine: &mut Machine<'_, 8>| {
            machine.take_trace();
            let from = machine.controller.counts();
            let list = [
                "$MIRROR=RUN".into(),
                point(0.0),
                point(20.0),
                "$POINT=END".into(),
            ];
            let tips = tips(&trace_of_lines(machine, &list), from);
            // With flat normals the wall is the distance in z while the mill crosses the middle, not drawn back.
            let in_work = tips.iter().filter(|[mill, support]| {
                (mill.tip[0] - 10.0).abs() < 5.0 && mill.tip[2] - support.tip[2] < 5.0
            });
            let walls: Vec<f64> = in_work.map(|[m, s]| m.tip[2] - s.tip[2]).collect();
            walls.iter().sum::<f64>() / walls.len() as f64
        };
        assert_eq!(machine.ask("$MIRROR=V20"), "ok\r\n");

        let first = mill(machine);
        assert_eq!(machine.ask("$MIRROR=GAUGE,1.44,1.45"), "ok\r\n");
        let early = machine.ask("$MIRROR=BIAS");
        let refused = machine.ask("$MIRROR=GAUGE,1.44,0.9");
        assert_eq!(machine.ask("$MIRROR=GAUGE,1.445"), "ok\r\n");
        let learnt = machine.ask("$MIRROR=BIAS");
        let second = mill(machine);
        // Those of the corrected walls are still 0.005 mm off.
        machine.ask("$MIRROR=GAUGE,1.495,1.495,1.495");
        let third = mill(machine);

        assert!(early.starts_with("[BIAS:0|2]"), "{early}");
        assert!(refused.contains("[MSG:Outlier reading"), "{refused}");
        assert!(learnt.starts_with("[BIAS:0.055|3]"), "{learnt}");
        assert!((first - 1.5).abs() < 0.002, "{first}");
        assert!((second - 1.555).abs() < 0.002, "{second}");
        assert!((third - 1.56).abs() < 0.002, "{third}");
        machine.ask("$MIRROR=D1.4");
        assert!(machine.ask("$MIRROR=BIAS").starts_with("[BIAS:0|0]"));
    });
}

/// The lines of a process, said to memory and to a firmware in the emulator: the same pulses.
fn assert_equal_pulses<const N: usize>(
    machine: &mut Machine<'_, N>,
    firmware: PathBuf,
    pins: PinMap,
    settings: &[String],
    runs: &[Vec<String>],
) {
    let mut emulator = boot_for_motion(firmware, pins);
    for line in settings {
        assert_eq!(ask(&mut emulator, line), ["ok"], "{line}");
    }
    for lines in runs {
        let (wanted, pulses) = on_both(machine, &mut emulator, lines);

        let difference = wanted.first_difference(&pulses);
        assert_eq!(difference, None, "{}", lines[0]);
        assert!(wanted.len() > 3000, "{} edges", wanted.len());
    }
    assert_eq!(machine.starved(), 0);
    assert_eq!(ask(&mut emulator, "$STAT"), ["[MSG:starved 0]", "ok"]);
}

#[test]
fn the_arms_firmware_makes_the_pulses_of_memory_from_the_same_points() {
    let Some(firmware) = arm_from_environment() else {
        return say_not_run("HEXSTEP_FIRMWARE_ARM");
    };
    let runs = [
        lines(&[
            "$PRECESS=V40,W240,E0.1,X0.1,O3",
            "$PRECESS=RUN",
            "$POINT=0,0,0,0,0,1",
            "$POINT=20,0,0,0,0,1",
            "$POINT=30,0,-1,0.1,0,1",
            "$POINT=30,10,-1,0.1,0.05,1",
            "$POINT=END",
        ]),
        lines(&[
            "$SURF=P0.05,Z1,O2,Q20",
            "$SURF=RUN",
            "$POINT=0,0,0,0,0,1,1,0,0,0.005,-0.003,0.001",
            "$POINT=20,0,-1,0.1,0,1,1,0,-0.1,0.005,-0.003,0.001",
            "$POINT=ROW",
            "$POINT=20,2,-1,0.1,0,1,-1,0,0.1,0.005,-0.003,0.001",
            "$POINT=0,2,0,0,0,1,-1,0,0,0.005,-0.003,0.001",
            "$POINT=END",
        ]),
    ];
    with_arm(|machine| {
        assert_equal_pulses(machine, firmware, SKR_PRO, &arm_lines(), &runs);
    });
}

/// The lines of delivered jobs, cut short: settings and words whole, then their first points.
#[test]
fn the_arms_firmware_begins_delivered_jobs_with_the_pulses_of_memory() {
    let Some(firmware) = arm_from_environment() else {
        return say_not_run("HEXSTEP_FIRMWARE_ARM");
    };
    for (name, points) in [("precession-curved", 2), ("dune-soft", 7)] {
        let file = format!("{}/jobs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let all = hexstep_host::lines::of(&Job::load(file.as_ref()).unwrap()).unwrap();
        let begins = all
            .iter()
            .position(|line| line.starts_with("$POINT"))
            .unwrap();
        let (settings, rest) = all.split_at(begins - 2);
        let mut run = rest[..2 + points].to_vec();
        run.push("$POINT=END".into());
        let settings = [&["$1012=1".into()], settings].concat();
        machine::with(|machine| {
            machine.ask("");
            trace_of_lines(machine, &settings);
            assert_equal_pulses(machine, firmware.clone(), SKR_PRO, &settings, &[run]);
        });
    }
}

#[test]
fn the_octopus_mills_a_wall_with_the_pulses_of_memory() {
    let Some(firmware) = octopus_from_environment() else {
        return say_not_run("HEXSTEP_FIRMWARE_OCTOPUS");
    };
    let mut run = lines(&[
        "$MIRROR=V100,O3",
        "$MIRROR=GAUGE,1.45,1.45,1.45",
        "$MIRROR=ON,1.5",
    ]);
    run.extend((0..=3).map(|k| {
        let x = 25.0 * f64::from(k);
        let z = (4000.0f64.powi(2) - x * x).sqrt();
        format!("$POINT={x},100,{:.6},{x},0,{z:.6}", z - 4000.0)
    }));
    run.push("$MIRROR=OFF".into());
    with_pair(|machine| {
        assert_equal_pulses(machine, firmware, OCTOPUS, &pair_lines(), &[run]);
    });
}

#[test]
fn every_row_of_the_precession_table_is_refused_by_name_and_nothing_moves() {
    with_arm(|machine| {
        refusals(
            machine,
            &[],
            &[
                ("$PRECESS=T86", "BadTilt", 52),
                ("$PRECESS=TNAN", "BadTilt", 52),
                ("$PRECESS=R0", "BadBonnet", 52),
                ("$PRECESS=H40", "BadBonnet", 52),
                ("$PRECESS=V0", "BadFeedRate", 52),
                ("$PRECESS=VINF", "BadFeedRate", 52),
                ("$PRECESS=WINF", "BadRate", 52),
                ("$PRECESS=M1,P0", "BadPitch", 52),
                ("$PRECESS=E0", "BadLimit", 52),
                ("$PRECESS=D-1", "BadLimit", 52),
                ("$PRECESS=X0", "BadLimit", 52),
                ("$PRECESS=Q0", "BadLimit", 52),
                ("$PRECESS=L-1", "BadLimit", 52),
                ("$PRECESS=LINF", "NonFinite ell", 52),
                ("$PRECESS=ANAN", "NonFinite alpha0", 52),
                ("$PRECESS=C2", "OutOfRange feed_at", 52),
                ("$PRECESS=O-1", "OutOfRange clear", 52),
                ("$PRECESS=T20,T21", "RepeatedField T", 52),
                ("$PRECESS=Y1", "UnknownField Y", 52),
                ("$PRECESS=T2X", "BadNumber T", 52),
            ],
        );
        refusals(
            machine,
            &["$PRECESS=RUN"],
            &[
                ("$POINT=END", "BadPath point 0", 52),
                ("$POINT=0,0,0,0,0,0", "BadNormal point 0", 52),
                ("$POINT=0,0,0,0,0,NAN", "BadNormal point 0", 52),
                ("$POINT=NAN,0,0,0,0,1", "NonFinite point 0", 52),
            ],
        );
        refusals(
            machine,
            &["$POINT=0,0,0,0,0,1"],
            &[
                ("$POINT=0,0,0,0,0,-1", "AntiParallel point 1", 52),
                ("$POINT=900,0,0,0,0,1", "Unreachable point 1", 15),
            ],
        );
        // A single point without a dwell.
        refusals(machine, &[], &[("$POINT=END", "BadDwell point 1", 52)]);
        machine.ask("$PRECESS=STOP");
        let untouched = machine::with(|fresh| {
            fresh.ask("");
            fresh.ask("$PRECESS")
        });
        assert_eq!(machine.ask("$PRECESS"), untouched);
    });
}

#[test]
fn every_row_of_the_grinding_table_that_a_line_can_meet_is_refused_by_name() {
    with_arm(|machine| {
        refusals(
            machine,
            &[],
            &[
                ("$SURF=E0", "BadMaterial e1", 52),
                ("$SURF=M0.6", "BadMaterial nu2", 52),
                ("$SURF=F0", "BadParameter force", 52),
                ("$SURF=K0", "BadParameter k", 52),
                ("$SURF=S0", "BadParameter rpm", 52),
                ("$SURF=V0", "BadParameter feed", 52),
                ("$SURF=VNAN", "BadParameter feed", 52),
                ("$SURF=H0", "BadParameter scallop", 52),
                ("$SURF=Y1", "BadParameter margin", 52),
                ("$SURF=R-1", "BadParameter r_rim", 52),
                ("$SURF=W-1", "BadParameter half_width", 52),
                ("$SURF=P-1", "BadParameter depth", 52),
                ("$SURF=A2", "OutOfRange model", 52),
                ("$SURF=Q0", "OutOfRange clear", 52),
            ],
        );
        let run = ["$SURF=R10,C50,W0.5,H0.04", "$SURF=RUN"];
        refusals(
            machine,
            &run,
            &[
                ("$POINT=0,0,0,0,0,1", "BadPath point 0", 52),
                ("$POINT=0,0,0,0,0,1,0,0,1", "BadPose point 0", 52),
                ("$POINT=0,0,NAN,0,0,1,1,0,0", "BadPose point 0", 52),
                (
                    "$POINT=0,0,0,0,0,1,1,0,0,-0.2,0,0",
                    "NoHertzContact point 0",
                    52,
                ),
                (
                    "$POINT=0,0,0,0,0,1,1,0,0,0,-0.01999999,0",
                    "LineContact point 0",
                    52,
                ),
                (
                    "$POINT=0,0,0,0,0,1,1,0,0,0,-0.0199,0",
                    "FootprintTooLarge point 0",
                    52,
                ),
                (
                    "$POINT=0,0,0,0,0,1,1,0,0,0,-0.0155,0",
                    "TooShallow point 0",
                    52,
                ),
                ("$POINT=700,0,0,0,0,1,1,0,0", "Unreachable point 0", 15),
                ("$POINT=0,0,0,0,0,-1,1,0,0", "NoBranch point 0", 15),
            ],
        );
        machine.ask("$SURF=STOP");
        refusals(
            machine,
            &["$SURF=A1,H0.01", "$SURF=RUN"],
            &[("$POINT=0,0,0,0,0,1,1,0,0", "AdditiveBranch point 0", 52)],
        );
    });
}

#[test]
fn every_row_of_the_mirror_table_is_refused_by_name_and_neither_side_moves() {
    with_pair(|machine| {
        refusals(
            machine,
            &[],
            &[
                ("$MIRROR=D0", "BadWall", 52),
                ("$MIRROR=ON,-1", "BadWall", 52),
                ("$MIRROR=DNAN", "BadWall", 52),
                ("$MIRROR=V0", "BadLimit feed", 52),
                ("$KIN.B1=0,0,0,0,0,450", "BadAxis", 52),
                ("$KIN.B2=0,1,0,0,0,NAN", "NonFinite", 52),
            ],
        );
        refusals(
            machine,
            &["$MIRROR=RUN"],
            &[
                ("$POINT=0,0,0,0,0,0", "BadNormal point 0", 52),
                ("$POINT=NAN,0,0,0,0,1", "NonFinite point 0", 52),
                ("$POINT=0,0,0,0,0,INF", "NonFinite point 0", 52),
                // X1 would go to 1500 of 1300.
                ("$POINT=900,0,0,0,0,1", "OutOfTravel point 0 joint 0", 15),
                // Turned by 45 deg; 30 are there.
                ("$POINT=0,0,0,1,0,1", "OutOfTravel point 0 joint 3", 15),
            ],
        );
    });
}

#[test]
fn a_refused_point_loses_nothing_of_the_path() {
    let whole = |with_bad: bool| {
        with_arm(|machine| {
            machine.take_trace();
            for line in ["$PRECESS=E0.5,L50", "$PRECESS=RUN", "$POINT=0,0,0,0,0,1"] {
                assert_eq!(machine.ask(line), "ok\r\n");
            }
            if with_bad {
                // Its first poses could be run, its last one is out of reach.
                let answer = machine.ask("$POINT=900,0,0,0,0,1");
                assert!(answer.contains("Unreachable point 1"), "{answer}");
                assert!(machine.ask("$POINT=1,2,3,0,0,0").contains("BadNormal"));
            }
            let rest = lines(&["$POINT=10,0,0,0,0,1", "$POINT=END"]);
            trace_of_lines(machine, &rest).positions()
        })
    };

    assert_eq!(whole(true), whole(false));
}

#[test]
fn a_refused_point_does_not_use_up_the_begin_of_a_row() {
    with_arm(|machine| {
        machine.take_trace();
        for line in [
            "$SURF=RUN",
            "$POINT=0,0,10,0,0,1,1,0,0",
            "$POINT=20,0,10,0,0,1,1,0,0",
            "$POINT=ROW",
        ] {
            assert_eq!(machine.ask(line), "ok\r\n", "{line}");
        }
        assert!(machine.ask("$POINT=0,5,10,0,0,1,0,0,1").contains("BadPose"));

        let rest = lines(&[
            "$POINT=0,5,10,0,0,1,1,0,0",
            "$POINT=20,5,10,0,0,1,1,0,0",
            "$POINT=END",
        ]);
        let tools = tools(&trace_of_lines(machine, &rest));

        let across = tools.iter().filter(|t| t.tip[1] > 1.0 && t.tip[1] < 4.0);
        assert!(across.clone().count() > 10);
        assert!(across.clone().all(|t| t.tip[2] > 19.0), "lifted");
    });
}

#[test]
fn a_simulated_path_tells_its_time_and_moves_nothing() {
    with_arm(|machine| {
        let mut heard = String::new();
        for line in [
            "$PRECESS=E0.05,X1",
            "$PRECESS=SIM",
            "$POINT=0,0,0,0,0,1",
            "$POINT=60,0,0,0,0,1",
            "$POINT=END",
        ] {
            heard += &machine.ask(line);
        }

        // 12 s along the path, 10 mm in and 10 out at 5 mm/s.
        assert!(heard.contains("[MSG:Simulated: 2 points, "), "{heard}");
        assert!(heard.contains(" blocks, 16.00"), "{heard}");
        assert_eq!(machine.controller.counts(), [0; 6]);
        assert_eq!(machine.ask("$PRECESS=T19"), "ok\r\n", "it is at rest again");
    });
}

/// Held twice and run at other speeds in between: the path, and the axis's phase along it, are what they were.
#[test]
fn holds_and_overrides_do_not_take_the_tool_off_its_path() {
    with_arm(|machine| {
        for cue in [
            "$CUE=3500,HOLD",
            "$CUE=4200,RESUME",
            "$CUE=5000,FEED,200",
            "$CUE=5300,HOLD",
            "$CUE=5700,RESUME",
            "$CUE=6000,FEED,50",
        ] {
            assert_eq!(machine.ask(cue), "ok\r\n");
        }
        machine.take_trace();

        let trace = trace_of_lines(
            machine,
            &lines(&[
                "$PRECESS=T20,V10,W60,L100,E0.05,O0",
                "$PRECESS=RUN",
                "$POINT=0,0,0,0,0,1",
                "$POINT=40,0,0,0,0,1",
                "$POINT=END",
            ]),
        );

        let tools = tools(&trace);
        let begins = tools
            .iter()
            .position(|t| distance(t.tip, [0.0, 0.0, 39.5]) < 0.05);
        for tool in &tools[begins.unwrap()..] {
            let [x, y, z] = tool.tip;
            let alpha = (6.0 * x).to_radians();
            let (sin, cos) = 20.0f64.to_radians().sin_cos();
            let wanted = [sin * alpha.cos(), sin * alpha.sin(), cos];
            assert!(y.hypot(z - 39.5) < 0.055, "{tool:?}");
            assert!(angle_deg(tool.axis, wanted) < 0.3, "{tool:?}");
        }
        let at_rest = tools
            .windows(2)
            .filter(|w| distance(w[0].tip, w[1].tip) < 1e-4);
        assert!(at_rest.count() > 500, "it was held");
        assert!((tools.last().unwrap().tip[0] - 40.0).abs() < 0.02);
        assert_eq!(machine.starved(), 0);
    });
}

/// The panel has given way by 0.06 mm, and both sides follow it together while the pair mills.
#[test]
fn readings_trim_both_sides_of_a_pair_that_mills_from_points() {
    with_pair(|machine| {
        for line in [
            "$1013=0.2",
            "$TRIM=ON,10,0.1,0.1,0.5,0.2,50",
            "$MIRROR=V50,O0",
            "$MIRROR=RUN",
        ] {
            assert_eq!(machine.ask(line), "ok\r\n", "{line}");
        }
        machine.take_trace();
        for line in ["$POINT=0,0,0,0,0,1", "$POINT=100,0,0,0,0,1", "$POINT=END"] {
            machine.say(line);
        }
        // The sensor speaks every 5 ms, and the foreground does the rest.
        let reading = encode(Some(0.06));
        let mut said = 0;
        while said < 500 {
            machine.put(&reading);
            said += 1;
            let until = machine.now() + 5 * MS;
            while machine.now() < until {
                machine.step();
            }
        }
        machine.put(&[0xAE]);
        machine.run_to_rest();
        let trace = machine.take_trace();

        let tips = tips(&trace, [0; 8]);
        let mut shifted = 0;
        for [mill, support] in &tips {
            if (5.0..95.0).contains(&mill.tip[0]) {
                let wall = mill.tip[2] - support.tip[2];
                assert!((wall - 1.5).abs() < 0.004, "{mill:?} {support:?}");
                shifted += u32::from(support.tip[2] > 0.05);
            }
        }
        assert!(shifted > 1000, "{shifted} ms on the panel where it is");
        assert_eq!(machine.starved(), 0);
    });
}

#[test]
fn a_stop_ends_the_path_on_it_and_the_next_one_begins() {
    with_arm(|machine| {
        for line in ["$PRECESS=O0", "$PRECESS=RUN", "$POINT=0,0,0,0,0,1"] {
            assert_eq!(machine.ask(line), "ok\r\n");
        }
        machine.say("$POINT=60,0,0,0,0,1");
        machine.run(400_000);
        assert_eq!(machine.heard(), "ok\r\n", "it can be run, and is being run");
        assert_eq!(machine.ask("$PRECESS=STOP"), "ok\r\n");

        assert_eq!(machine.ask("$POINT=END"), "error:8\r\n");
        assert_eq!(machine.ask("$PRECESS=SIM"), "ok\r\n");
        assert_eq!(machine.starved(), 0);
    });
}

#[test]
fn a_soft_reset_ends_a_process_that_waits_for_points_and_keeps_the_position() {
    with_arm(|machine| {
        for line in ["$SURF=RUN", "$POINT=0,0,10,0,0,1,1,0,0"] {
            assert_eq!(machine.ask(line), "ok\r\n");
        }

        machine.put(&[0x18]);
        machine.run_to_rest();

        let banner = machine.heard();
        assert!(banner.contains("Grbl 1.1h"), "{banner}");
        assert!(!banner.contains("ALARM"), "{banner}");
        assert_eq!(machine.ask("$POINT=END"), "error:8\r\n");
        assert_eq!(machine.ask("$KIN.TOOL=150"), "ok\r\n", "it is at rest");
    });
}

#[test]
fn what_the_machine_is_not_is_said_and_what_it_is_is_shown() {
    machine::with(|machine| {
        machine.ask("");
        assert!(machine.ask("$KIN").starts_with("[KIN:GRIND3P3R|"));
        let answer = machine.ask("$PRECESS=RUN");
        assert_eq!(
            answer,
            "[MSG:Expected an arm, see $KIN=ARM6R]\r\nerror:53\r\n"
        );
        assert_eq!(machine.ask("$POINT=END"), "error:8\r\n");
        assert_eq!(machine.ask("$MIRROR=RUN"), "error:53\r\n");
        assert_eq!(machine.ask("$KIN=ARM6R"), "ok\r\n");
        assert_eq!(machine.ask("$KIN.TOOL=110"), "ok\r\n");
        assert_eq!(machine.ask("$KIN.TOOL=1,2"), "error:2\r\n");
        assert_eq!(machine.ask("$KIN.HEAT=1"), "error:3\r\n");
        let answer = machine.ask("$KIN.A=50,0,70");
        assert!(answer.starts_with("[MSG:BadParameter"), "{answer}");
        assert_eq!(
            machine.ask("$KIN"),
            "[KIN:ARM6R|A=50,270,70|D=320,299,78.5|TOOL=110|WORK=0,0,0|BRANCH=-1|AXIS=0.05]\r\nok\r\n"
        );
        machine.ask("$1003=0");
        let answer = machine.ask("$PRECESS=RUN");
        assert!(
            answer.starts_with("[MSG:BadLimit: expected a tolerance"),
            "{answer}"
        );
        let answer = machine.ask("$DRILL=RUN");
        assert!(
            answer.contains("[MSG:Drill: expected three motors that slide"),
            "{answer}"
        );
    });
    machine::with_motors::<8, _>(|machine| {
        machine.ask("");
        assert_eq!(
            machine.ask("$KIN"),
            "[KIN:MIRROR|B1=0,1,0,0,0,450|B2=0,1,0,0,0,-430|TIPS=50,-50|WORK=600,450,0]\r\nok\r\n"
        );
        assert_eq!(machine.ask("$PRECESS=RUN"), "error:53\r\n");
        assert_eq!(machine.ask("$MIRROR"), "[MIRROR:D1.5,V5,O10]\r\nok\r\n");
    });
}
