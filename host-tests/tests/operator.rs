//! What an operator does while the machine runs, by real-time bytes, lines and the library's interface; judged by the
//! pulses.

use hexstep::controller::Probed;
use hexstep::path::Target;
use hexstep::protocol::report::State;
use hexstep_host::machine::{self, Machine};

/// A square in all joints with a long first side; ends where it began but for joint 0.
const SIDES: [[i32; 6]; 4] = [
    [9000, 4000, -3000, 2000, 1000, 500],
    [9000, -4000, 3000, 2000, -1000, 500],
    [2000, -4000, 0, 0, 0, 0],
    [700, 0, 0, 0, 0, 0],
];
/// Ticks in a millisecond, at least.
const MS: u64 = 40;

fn lines(sides: &[[i32; 6]], seconds: f32) -> String {
    let mut text = String::new();
    for side in sides {
        let words: Vec<String> = side.iter().map(i32::to_string).collect();
        text += &format!("$MOVE={},{seconds}\n", words.join(","));
    }
    text
}

fn ready(m: &mut Machine<'_>) {
    m.run(10);
    m.heard();
}

/// Runs until nothing moves, a hold included.
fn settle(m: &mut Machine<'_>) {
    m.run_to_rest();
    m.run(3);
}

#[track_caller]
fn assert_ends_at(m: &Machine<'_>, end: [i32; 6]) {
    assert_eq!(m.controller.counts(), end);
    assert_eq!(m.trace.positions(), end.map(i64::from));
    assert_eq!(m.starved(), 0);
    assert_eq!(m.controller.planner().counters().squeezed, 0);
}

fn has_not_stepped(m: &Machine<'_>) -> bool {
    m.trace.pulses().next().is_none()
}

fn status(m: &mut Machine<'_>) -> String {
    m.heard();
    m.put(b"?");
    m.run(5);
    m.heard()
}

#[test]
fn lines_of_targets_run_as_one_path_once_it_is_complete() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES, 0.2).as_bytes());
        settle(m);
        assert!(has_not_stepped(m), "the path may still go on");
        assert_eq!(m.controller.state(), State::Run);

        m.say("$MOVE=END");
        settle(m);

        assert_eq!(m.heard(), "ok\r\nok\r\nok\r\nok\r\nok\r\n");
        assert_ends_at(m, SIDES[3]);
    });
}

#[test]
fn a_stream_starts_on_cycle_start_and_an_input_that_pauses_ends_at_rest_on_the_path() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES[..2], 0.2).as_bytes());
        m.run(2000);
        assert!(has_not_stepped(m));
        m.put(b"~");
        m.run(MS * 2000);

        assert_eq!(m.trace.positions(), SIDES[1].map(i64::from));
        assert_eq!(m.starved(), 0, "a pause of the input is no overrun");
        m.put(lines(&SIDES[2..], 0.2).as_bytes());
        m.say("$MOVE=END");
        settle(m);
        assert_ends_at(m, SIDES[3]);
    });
}

#[test]
fn a_target_that_is_refused_leaves_the_stream_as_it_was() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES[..1], 0.2).as_bytes());
        m.run(100);
        m.heard();
        for (line, name, error) in [
            ("$MOVE=200001,0,0,0,0,0", "OutOfTravel joint 0", "error:15"),
            ("$MOVE=1,0,0,0,0,0,-1", "OutOfRange target", "error:52"),
            ("$MOVE=1,0,0,0,0", "", "error:2"),
            ("$MOVE=1,0,0,0,0,x", "BadNumber target 5", "error:2"),
            ("$MOVE=1,0,.,0,0,0", "BadNumber target 2", "error:2"),
            ("$MOVE=1,1e3,0,0,0,0", "BadNumber target 1", "error:2"),
            (
                "$MOVE=1,0,0,1.0000000001,0,0",
                "BadNumber target 3",
                "error:2",
            ),
            (
                "$MOVE=2147483648,0,0,0,0,0",
                "OutOfRange target 0",
                "error:52",
            ),
            (
                "$MOVE=0,-2147483648.1,0,0,0,0",
                "OutOfRange target 1",
                "error:52",
            ),
            (
                "$MOVE=99999999999999999999,0,0,0,0,0",
                "OutOfRange target 0",
                "error:52",
            ),
            (
                "$MOVE=200000.5,0,0,0,0,0",
                "OutOfTravel joint 0",
                "error:15",
            ),
            ("$MOVE=1,0,0,0,0,0,1,1", "", "error:2"),
            ("$110=100", "", "error:8"),
            ("$SEG=1,0,0,0,0,0,1", "", "error:8"),
            ("$DRILL=RUN", "", "error:8"),
            ("$CUE=1,HOLD", "Order cue", "error:52"),
        ] {
            m.say(line);
            m.run(100);
            let answer = m.heard();
            assert!(
                answer.contains(name) && answer.ends_with(&format!("{error}\r\n")),
                "{line}: {answer}"
            );
        }
        m.say("$MOVE=END");
        settle(m);
        assert_ends_at(m, SIDES[0]);
    });
}

#[test]
fn bad_cues_are_refused_by_name_and_good_ones_wait_for_the_motion() {
    machine::with(|m| {
        ready(m);
        for (line, error) in [
            ("$CUE=-1,HOLD", "error:4"),
            ("$CUE=1,DANCE", "error:3"),
            ("$CUE=1", "error:2"),
            ("$CUE=1,FEED", "error:2"),
            ("$CUE=1,FEED,5", "error:52"),
            ("$CUE=1,RAPID,101", "error:52"),
            ("$CUE=1,TRIM,6,1", "error:52"),
            ("$CUE=1,HOLD,1", "error:2"),
        ] {
            let answer = m.ask(line);
            assert!(
                answer.ends_with(&format!("{error}\r\n")),
                "{line}: {answer}"
            );
        }
        assert_eq!(m.ask("$CUE=50,FEED,50"), "ok\r\n");
        assert!(m.ask("$CUE=49,HOLD").contains("Order cue"));
        for at in 51..66 {
            assert_eq!(m.ask(&format!("$CUE={at},FEED,60")), "ok\r\n");
        }
        assert!(m.ask("$CUE=99,HOLD").contains("Full cue"));
        assert!(has_not_stepped(m));
    });
}

/// Time of the last edge [ms].
fn last_edge(m: &Machine<'_>) -> u64 {
    m.trace.events().last().map_or(0, |e| e.tick / MS)
}

#[test]
fn a_hold_slows_down_waits_lets_no_line_through_and_goes_on_to_the_same_end() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES, 0.4).as_bytes());
        m.say("$MOVE=END");
        m.run(MS * 300);
        m.put(b"!");
        m.run(2);
        assert_eq!(m.controller.state(), State::Hold { moving: true });
        settle(m);
        assert_eq!(m.controller.state(), State::Hold { moving: false });
        let held = m.trace.positions();
        assert_ne!(held, SIDES[3].map(i64::from));
        let before = last_edge(m);
        m.heard();

        m.say("$STAT");
        m.run(MS * 100);
        assert!(status(m).starts_with("<Hold:0|"));
        assert_eq!(m.trace.positions(), held);
        assert_eq!(last_edge(m), before);

        m.put(b"~");
        settle(m);
        assert!(m.heard().ends_with("[MSG:starved 0]\r\nok\r\n"));
        assert_ends_at(m, SIDES[3]);
    });
}

#[test]
fn a_hold_takes_effect_within_ten_milliseconds_of_its_byte() {
    machine::with(|m| {
        ready(m);
        // A long straight move at constant speed: 20 000 steps/s on joint 0.
        m.say("$MOVE=60000,0,0,0,0,0,1.5");
        m.say("$MOVE=END");
        m.run(MS * 700);
        let byte = m.now();
        m.put(b"!");
        settle(m);

        let edges: Vec<u64> = m.trace.steps_of(0).map(|step| step.time).collect();
        let at = byte;
        // The first gap that is longer than those before.
        let gaps: Vec<u64> = edges.windows(2).map(|w| w[1] - w[0]).collect();
        let behind = edges.iter().position(|t| *t >= at).unwrap();
        let usual = gaps[behind - 100..behind].iter().max().unwrap();
        let slower = (behind..gaps.len()).find(|i| gaps[*i] > usual + usual / 1000);
        let late = edges[slower.unwrap()] - at;
        let ms = late as f64 / f64::from(machine::TICK_HZ) * 1e3;
        assert!(ms <= 10.0, "{ms} ms");
    });
}

#[test]
fn a_reset_in_a_hold_at_rest_loses_no_step_and_drops_the_path() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES, 0.4).as_bytes());
        m.say("$MOVE=END");
        m.run(MS * 300);
        m.put(b"!");
        settle(m);
        let held = m.trace.positions();
        m.heard();
        m.put(&[0x18]);
        settle(m);

        assert_eq!(m.heard(), "\r\nGrbl 1.1h ['$' for help]\r\n");
        assert_eq!(m.controller.state(), State::Idle);
        assert_eq!(m.trace.positions(), held);
        assert_eq!(m.controller.counts().map(i64::from), held);
        // The machine knows where it is: home is home.
        m.say("$MOVE=0,0,0,0,0,0");
        m.say("$MOVE=END");
        settle(m);
        assert_ends_at(m, [0; 6]);
    });
}

#[test]
fn a_controlled_stop_keeps_the_position_and_drops_the_path() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES, 0.4).as_bytes());
        m.say("$MOVE=END");
        m.run(MS * 300);
        m.controller.stop_motion();
        settle(m);

        assert_eq!(m.controller.state(), State::Idle);
        assert_eq!(
            m.trace.positions(),
            m.controller.counts().map(i64::from),
            "known to the step"
        );
        assert_ne!(m.controller.counts(), SIDES[3]);
        assert_eq!(m.controller.planner().end(), m.controller.counts());
        m.put(lines(&SIDES[3..], 0.0).as_bytes());
        m.say("$MOVE=END");
        settle(m);
        assert_ends_at(m, SIDES[3]);
    });
}

/// Machine time of the path under these bytes, given at 300 ms [s].
fn time_with(bytes: &[u8]) -> f64 {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES, 1.0).as_bytes());
        m.say("$MOVE=END");
        m.run(MS * 300);
        m.put(bytes);
        settle(m);
        assert_ends_at(m, SIDES[3]);
        let last = m.trace.pulses().last().unwrap().time;
        last as f64 / f64::from(machine::TICK_HZ)
    })
}

#[test]
fn override_bytes_scale_the_feed_within_their_range_even_when_sent_as_utf_8() {
    let plain = time_with(b"");
    assert!((4.0..4.2).contains(&plain), "{plain} s");

    // Twice as fast at the most.
    let left = plain - 0.3;
    let fast = time_with(&[0x91; 30]);
    let fast_utf_8 = time_with(&[0xC2, 0x91].repeat(30));
    let slow = time_with(&[0x92; 5]);
    let back = time_with(&[0x92, 0x92, 0x90]);
    let fine = time_with(&[0x94; 10]);

    assert!((fast - (0.3 + left / 2.0)).abs() < 0.15, "{fast} s");
    assert!((fast_utf_8 - fast).abs() < 1e-9);
    assert!((slow - (0.3 + left * 2.0)).abs() < 0.15, "{slow} s");
    assert!((back - plain).abs() < 0.02, "{back} s");
    assert!((fine - (0.3 + left / 0.9)).abs() < 0.15, "{fine} s");
}

#[test]
fn a_foreground_that_is_late_in_motion_is_counted_told_and_stops_the_machine_in_alarm() {
    machine::with(|m| {
        ready(m);
        m.put(lines(&SIDES, 0.4).as_bytes());
        m.say("$MOVE=END");
        m.run(MS * 300);
        m.heard();
        // Four milliseconds are in the queue behind the running one.
        m.neglect(MS * 3);
        m.run(1);
        assert_eq!(m.starved(), 0);
        m.neglect(MS * 50);
        let there = m.trace.positions();
        m.run(500);

        assert_eq!(m.starved(), 1);
        let heard = m.heard();
        assert!(
            heard.starts_with("[MSG:Segment queue ran dry, position lost]\r\nALARM:3\r\n"),
            "{heard}"
        );
        assert_eq!(m.trace.positions(), there, "no step comes after it");
        assert_eq!(m.controller.state(), State::Alarm);
        assert_eq!(m.controller.counts().map(i64::from), there);
        assert!(m.ask("$STAT").contains("[MSG:starved 1]"));
        assert!(m.ask("$MOVE=0,0,0,0,0,0").ends_with("error:9\r\n"));
    });
}

#[test]
fn a_rapid_override_slows_rapids_only() {
    let time = |seconds: f32, byte: u8| {
        machine::with(|m| {
            ready(m);
            m.put(&[byte]);
            m.put(lines(&[[60_000, 0, 0, 0, 0, 0]], seconds).as_bytes());
            m.say("$MOVE=END");
            settle(m);
            assert_ends_at(m, [60_000, 0, 0, 0, 0, 0]);
            m.trace.pulses().last().unwrap().time as f64 / f64::from(machine::TICK_HZ)
        })
    };

    let (feed, rapid) = (time(2.0, 0x95), time(0.0, 0x95));
    let (feed_slow, rapid_slow) = (time(2.0, 0x97), time(0.0, 0x97));

    assert!((feed_slow - feed).abs() < 1e-9);
    // 60 mm at 50 mm/s, and at a quarter of that; ramps of 400 mm/s2.
    assert!((rapid - 1.33).abs() < 0.05, "{rapid}");
    assert!((rapid_slow - 4.84).abs() < 0.1, "{rapid_slow}");
}

#[test]
fn a_reset_puts_the_overrides_back() {
    machine::with(|m| {
        ready(m);
        m.put(&[0x91, 0x97]);
        m.put(b"??");
        m.run(5);
        let first = status(m);
        assert!(first.contains("|Ov:110,25,100>"), "{first}");
        assert!(!status(m).contains("|Ov:"), "only once");
        m.put(&[0x18]);
        m.run(20);
        status(m);
        let reset = status(m);
        assert!(reset.contains("|Ov:100,100,100>"), "{reset}");
    });
}

fn target(steps: [i32; 6], duration: f32) -> Target<6> {
    Target::whole(steps, duration)
}

#[test]
fn a_jog_moves_at_once_flows_into_the_next_ignores_overrides_and_ends_where_it_is_cancelled() {
    machine::with(|m| {
        ready(m);
        m.put(&[0x92; 9]);
        m.run(5);
        assert_eq!(
            m.controller.jog(&target([20_000, 0, 0, 0, 0, 0], 1.0)),
            Ok(true)
        );
        assert_eq!(
            m.controller.jog(&target([40_000, 0, 0, 0, 0, 0], 1.0)),
            Ok(true)
        );
        m.run(MS * 1000);
        assert_eq!(m.controller.state(), State::Jog);
        assert!(status(m).starts_with("<Jog|"));
        let there = m.trace.positions()[0];
        assert!((18_000..20_500).contains(&there), "{there}");
        m.say("$MOVE=1,0,0,0,0,0");
        m.run(100);
        assert_eq!(m.heard(), "", "waits for the end of the jog");
        settle(m);
        assert_eq!(m.trace.positions()[0], 40_000);
        m.put(&[0x18]);
        settle(m);

        assert_eq!(m.controller.jog(&target([0; 6], 2.0)), Ok(true));
        m.run(MS * 500);
        let before = m.trace.positions()[0];
        m.put(&[0x85]);
        settle(m);
        let after = m.trace.positions()[0];
        // 20 mm/s, 400 mm/s2 and 40 000 mm/s3: half a mm of braking, and what was queued.
        assert!((300..1200).contains(&(before - after)), "{before} {after}");
        assert_eq!(m.controller.state(), State::Idle);
        assert_eq!(i64::from(m.controller.counts()[0]), after);

        assert_eq!(
            m.controller.jog(&target([200_001, 0, 0, 0, 0, 0], 0.0)),
            Err(hexstep::error::Error::BeyondTravel)
        );
        assert_eq!(m.controller.jog(&target([0; 6], 2.0)), Ok(true));
        m.run(MS * 100);
        m.put(b"!");
        settle(m);
        assert_eq!(m.controller.state(), State::Idle, "a hold drops a jog");
        assert_eq!(m.starved(), 0);
    });
}

#[test]
fn a_probe_move_stops_and_tells_where_every_motor_was_at_contact() {
    machine::with(|m| {
        ready(m);
        let far = target([20_000, -10_000, 0, 0, 0, 5000], 2.0);
        assert_eq!(m.controller.probe(&far), Ok(()));
        m.run(MS * 700);
        assert_eq!(m.controller.probed(), None);
        let at = m.trace.positions();
        m.touch();
        settle(m);

        let Some(Probed::Contact(contact)) = m.controller.probed() else {
            panic!("{:?}", m.controller.probed());
        };
        for i in 0..6 {
            let steps = contact[i].to_num::<f64>();
            // Positions lie within a step of the pulses; a millisecond's way is ten steps here.
            assert!(
                (steps - at[i] as f64).abs() <= 1.5,
                "motor {i}: {steps} {at:?}"
            );
        }
        let end = m.trace.positions();
        assert!(end[0] > at[0] + 50 && end[0] < 15_000, "{end:?}");
        assert_eq!(m.controller.counts().map(i64::from), end);
        assert_eq!(m.controller.state(), State::Idle);

        // No contact: the target is reached.
        assert_eq!(m.controller.probe(&target([0; 6], 1.0)), Ok(()));
        settle(m);
        assert_eq!(m.controller.probed(), Some(Probed::Missed));
        assert_ends_at(m, [0; 6]);
        // A touch outside a probe move does nothing.
        m.touch();
        m.run(10);
        assert_eq!(m.controller.state(), State::Idle);
        assert_eq!(
            m.controller.probe(&target([0; 6], 1.0)),
            Err(hexstep::error::Error::InvalidTarget)
        );
    });
}

#[test]
fn a_trim_shifts_a_motor_by_whole_steps_while_a_program_runs() {
    machine::with(|m| {
        ready(m);
        for line in [
            "$1013=0.2",
            "$1031=0.05",
            "$CUE=200,TRIM,1,30",
            "$CUE=300,TRIM,1,99",
        ] {
            assert_eq!(m.ask(line), "ok\r\n", "{line}");
        }
        m.put(lines(&SIDES, 0.4).as_bytes());
        m.say("$MOVE=END");
        settle(m);
        // 0.05 mm at the most.
        assert_ends_at(m, [700, 50, 0, 0, 0, 0]);
    });
}

#[test]
fn cues_of_hold_and_resume_reach_the_same_end_by_the_same_path() {
    let run = |cues: &[&str]| {
        machine::with(|m| {
            ready(m);
            for cue in cues {
                assert_eq!(m.ask(cue), "ok\r\n");
            }
            m.put(lines(&SIDES, 0.3).as_bytes());
            m.say("$MOVE=END");
            settle(m);
            assert_ends_at(m, SIDES[3]);
            m.trace.pulses().last().unwrap().time as f64 / f64::from(machine::TICK_HZ)
        })
    };
    let plain = run(&[]);
    let held = run(&[
        "$CUE=100,HOLD",
        "$CUE=1100,RESUME",
        "$CUE=1300,HOLD",
        "$CUE=1310,RESUME",
    ]);
    let stopped_later = run(&["$CUE=90000,STOP"]);
    assert!(held > plain + 0.9, "{held} {plain}");
    assert!((stopped_later - plain).abs() < 1e-9);
}

#[test]
fn a_dwell_in_a_stream_takes_its_time() {
    machine::with(|m| {
        ready(m);
        m.controller.start_stream().unwrap();
        m.controller
            .push(&target([100, 0, 0, 0, 0, 0], 0.1))
            .unwrap();
        m.controller.dwell(1.0).unwrap();
        m.controller
            .push(&target([200, 0, 0, 0, 0, 0], 0.1))
            .unwrap();
        m.controller.end_stream();
        settle(m);
        let times: Vec<u64> = m.trace.pulses().map(|p| p.time).collect();
        let gap = times.windows(2).map(|w| w[1] - w[0]).max().unwrap();
        let seconds = gap as f64 / f64::from(machine::TICK_HZ);
        // The first and the last half step of a ramp take up to 0.02 s.
        assert!((1.0..1.05).contains(&seconds), "{seconds} s");
    });
}
