//! Offsets while programs run: by `$TRIM` lines, by real-time bytes, and by a sensor's readings on a two-sided machine.

use hexstep::protocol::reading::{self, Record};
use hexstep_host::machine::{self, Machine};

/// A fifth of the motors' limits for trims.
const SHARE: &str = "$1013=0.2";
/// Period 10 ms, tau 0.09 s, amount 0.08 mm, rate 0.5 mm/s, gate 0.3 mm, 5 misses.
const FOLLOW: &str = "$TRIM=ON,10,0.09,0.08,0.5,0.3,5";

fn six<R>(body: impl FnOnce(&mut Machine<'_>) -> R) -> R {
    machine::with(|machine| {
        machine.ask("");
        assert_eq!(machine.ask(SHARE), "ok\r\n");
        body(machine)
    })
}

/// A two-sided machine, X Y Z B twice.
fn eight<R>(body: impl FnOnce(&mut Machine<'_, 8>) -> R) -> R {
    machine::with_motors(|machine| {
        machine.ask("");
        assert_eq!(machine.ask(SHARE), "ok\r\n");
        body(machine)
    })
}

/// Ticks at the floor of the tick rate that make so many milliseconds.
const fn ms(milliseconds: u64) -> u64 {
    40 * milliseconds
}

/// Starts a program of so many seconds in which X1 and X2 move, far slower than they might.
fn start(machine: &mut Machine<'_, 8>, seconds: i32) {
    for second in 1..=seconds {
        let x = 1000 * second;
        machine.say(&format!("$MOVE={x},0,0,0,{},0,0,0,1", -x));
    }
    machine.say("$MOVE=END");
    machine.run(ms(20));
    assert!(machine.heard().contains("ok"));
}

/// Lets the sensor speak every 10 ms for so many seconds of motion; what it says may depend on how often it has spoken.
fn speak(machine: &mut Machine<'_, 8>, seconds: f64, mut says: impl FnMut(u32) -> Option<f32>) {
    let end = machine.now() + (seconds * 168.0e6) as u64;
    let mut next = machine.now();
    let mut spoken = 0;
    while machine.now() < end {
        if machine.now() >= next {
            machine.put(&reading::encode(says(spoken)));
            spoken += 1;
            next += 1_680_000;
        }
        machine.step();
    }
}

#[test]
fn an_offset_asked_for_by_a_line_is_made_and_listed_and_taken_back() {
    six(|machine| {
        let answer = machine.ask("$TRIM=Z0.05");

        assert_eq!(answer, "ok\r\n");
        assert_eq!(machine.controller.counts(), [0, 0, 50, 0, 0, 0]);
        machine.ask("$TRIM=B-0.01");
        assert_eq!(
            machine.ask("$TRIM"),
            "[TRIM:0.0000,0.0000,0.0500,0.0000,-0.0100,0.0000]\r\nok\r\n"
        );
        assert_eq!(machine.controller.counts(), [0, 0, 50, 0, -20, 0]);
        assert_eq!(machine.ask("$TRIM=0"), "ok\r\n");
        assert_eq!(machine.controller.counts(), [0; 6]);
    });
}

#[test]
fn an_offset_that_cannot_be_is_refused_by_name() {
    six(|machine| {
        let refused = machine.ask("$TRIM=Z0.2");
        assert_eq!(
            refused,
            "[MSG:OutOfRange trim Z: expected at most 0.1 either way, see $1032]\r\nerror:52\r\n"
        );
        assert_eq!(machine.ask("$TRIM=U0.01"), "error:3\r\n");
        assert_eq!(machine.ask("$TRIM=Z"), "error:2\r\n");
        assert_eq!(machine.ask("$TRIM=ZNAN"), "error:2\r\n");
        machine.ask("$1013=0");
        assert!(machine.ask("$TRIM=Z0.05").ends_with("error:53\r\n"));
        assert_eq!(machine.controller.counts(), [0; 6]);
    });
}

#[test]
fn bytes_select_a_motor_and_move_it_by_micrometres() {
    six(|machine| {
        // Z is two on from X; a coarse and three fine steps up, one fine step down.
        machine.put(&[0xAC, 0xAC, 0xAA, 0xA8, 0xA8, 0xA8, 0xA9]);
        machine.run_to_rest();

        assert_eq!(machine.controller.counts(), [0, 0, 12, 0, 0, 0]);
        assert_eq!(machine.heard(), "[MSG:Trim Z +0.0120]\r\n");
        // Before X comes C.
        machine.put(&[0xAD, 0xAD, 0xAD, 0xAB]);
        machine.run_to_rest();
        assert_eq!(machine.heard(), "[MSG:Trim C -0.0100]\r\n");
        assert_eq!(machine.controller.counts(), [0, 0, 12, 0, 0, -20]);
        machine.put(&[0xAA, 0xAF]);
        machine.run_to_rest();
        assert_eq!(machine.controller.counts(), [0; 6]);
    });
}

#[test]
fn bytes_act_while_lines_wait_behind_a_program() {
    eight(|machine| {
        start(machine, 3);

        machine.put(&[0xAC, 0xAC, 0xAA, 0xAA]);
        machine.run(ms(200));
        let at = machine.take_trace().positions();

        assert_eq!(at[2], 20);
        assert!(at[0] > 0 && at[0] < 1000, "{at:?}");
        machine.run_to_rest();
        assert_eq!(
            machine.controller.counts(),
            [3000, 0, 20, 0, -3000, 0, 0, 0]
        );
    });
}

#[test]
fn bytes_never_leave_the_bound_of_the_offset() {
    six(|machine| {
        machine.put(&[0xAB; 255]);
        machine.run_to_rest();

        // $1030: 0.1 mm.
        assert_eq!(machine.controller.counts(), [-100, 0, 0, 0, 0, 0]);
    });
}

#[test]
fn a_frozen_offset_stays_where_it_was_on_its_way() {
    six(|machine| {
        // 0.001 of the acceleration, 16 ms of it: 6.4 steps/s.
        machine.ask("$1013=0.001");
        machine.say("$TRIM=X0.1");
        machine.run(ms(4000));

        machine.put(&[0xAE]);
        machine.run_to_rest();

        let at = machine.controller.counts()[0];
        assert!((10..=40).contains(&at), "{at}");
        let listed = machine.ask("$TRIM");
        assert!(
            listed.contains(&format!("[TRIM:0.{:04}", at * 10)),
            "{listed}"
        );
    });
}

#[test]
fn a_soft_reset_at_rest_keeps_the_position_and_forgets_the_offset() {
    six(|machine| {
        machine.ask("$TRIM=Z0.05");

        machine.put(&[0x18]);
        machine.run_to_rest();
        machine.heard();

        assert_eq!(machine.controller.counts(), [0, 0, 50, 0, 0, 0]);
        let listed = machine.ask("$TRIM");
        assert!(!listed.contains('5'), "{listed}");
    });
}

#[test]
fn a_record_says_what_was_put_in_and_nothing_when_a_bit_is_wrong() {
    let take = |bytes: &[u8]| {
        let mut record = Record::default();
        bytes.iter().fold(None, |last, byte| match *byte {
            reading::BEGIN => {
                record.begin();
                last
            }
            byte => record.push(byte - reading::DIGIT).or(last),
        })
    };
    for mm in [0.0f32, 0.0001, -0.0001, 0.05, -0.15, 3.2767, -3.2767] {
        let bytes = reading::encode(Some(mm));

        let value = take(&bytes).unwrap();

        assert!(bytes.iter().all(|byte| (0x80..0xC0).contains(byte)));
        assert!((reading::millimetres(value).unwrap() - mm).abs() < 1e-6);
        for byte in 1..9 {
            for bit in 0..3 {
                let mut wrong = bytes;
                wrong[byte] = reading::DIGIT + ((wrong[byte] - reading::DIGIT) ^ 1 << bit);
                assert_eq!(take(&wrong), None, "{mm}: digit {byte}, bit {bit}");
            }
            let mut short = bytes.to_vec();
            short.remove(byte);
            assert_eq!(take(&short), None, "{mm}: digit {byte} lost");
        }
    }
    for none in [None, Some(f32::NAN), Some(f32::INFINITY), Some(3.3)] {
        let value = take(&reading::encode(none)).unwrap();
        assert_eq!(reading::millimetres(value), None, "{none:?}");
    }
    // By long division of polynomials elsewhere: the check of 00 00 is d7, that of 01 f4 is 00.
    assert_eq!(
        reading::encode(Some(0.0)),
        [0xA6, 0xB8, 0xB8, 0xB8, 0xB8, 0xB8, 0xBB, 0xBA, 0xBF]
    );
    assert_eq!(
        reading::encode(Some(0.05)),
        [0xA6, 0xB8, 0xB8, 0xBB, 0xBF, 0xBA, 0xB8, 0xB8, 0xB8]
    );
}

#[test]
fn a_measured_shift_moves_both_sides_in_the_same_ticks() {
    eight(|machine| {
        assert_eq!(machine.ask(FOLLOW), "ok\r\n");
        start(machine, 4);

        speak(machine, 2.0, |_| Some(0.05));
        let pulses = machine.take_trace();

        // Normal +z of the work frame: Z1 along +z, Z2 along -z. 1000 steps/mm.
        let at = pulses.positions();
        assert_eq!((at[2], at[6]), (50, -50));
        assert_eq!((at[1], at[3], at[5], at[7]), (0, 0, 0, 0));
        let z1: Vec<u64> = pulses.steps_of(2).map(|step| step.time).collect();
        let z2: Vec<u64> = pulses.steps_of(6).map(|step| step.time).collect();
        assert_eq!(z1.len(), 50);
        assert_eq!(z1, z2);
    });
}

#[test]
fn a_shift_of_a_turned_panel_moves_x_and_z_along_its_normal() {
    eight(|machine| {
        // B of both sides at 5 deg: 10 000 steps.
        machine.ask("$SEG=0,0,0,10000,0,0,0,10000,4");
        assert_eq!(machine.ask(FOLLOW), "ok\r\n");
        for k in 1..=4 {
            machine.say(&format!("$MOVE=0,{},0,10000,0,0,0,10000,1", 1000 * k));
        }
        machine.say("$MOVE=END");
        machine.run(ms(20));

        speak(machine, 3.0, |_| Some(0.08));

        // 80 um: sin 5 deg = 0.0872, cos 5 deg = 0.9962; side 2 is mirrored in x and z.
        let at = machine.controller.counts();
        assert_eq!((at[0], at[2], at[4], at[6]), (7, 80, -7, -80));
    });
}

#[test]
fn a_sensor_that_falls_silent_holds_the_machine_and_the_offset() {
    eight(|machine| {
        assert_eq!(machine.ask(FOLLOW), "ok\r\n");
        start(machine, 10);
        speak(machine, 2.0, |_| Some(0.05));
        machine.take_trace();
        machine.heard();

        speak(machine, 1.0, |_| None);

        let heard = machine.heard();
        assert!(heard.contains("[MSG:Trim fault: "), "{heard}");
        machine.put(b"?");
        machine.run(3);
        assert!(machine.heard().starts_with("<Hold:0|"), "rests");
        let moved = machine.take_trace().positions();
        assert_eq!((moved[2], moved[6]), (0, 0));
        assert!(moved[0] < 300, "{moved:?}");
        // Without the stream the program goes on, its offset as it was.
        machine.put(&[0xAE, b'~']);
        machine.run_to_rest();
        let at = machine.controller.counts();
        assert_eq!(at, [10_000, 0, 50, 0, -10_000, 0, -50, 0]);
    });
}

#[test]
fn whatever_the_sensor_says_the_offset_stays_within_amount_and_rate() {
    eight(|machine| {
        assert_eq!(machine.ask("$TRIM=ON,10,0.02,0.08,0.5,9,50"), "ok\r\n");
        start(machine, 6);
        machine.take_trace();
        let mut state = 1u32;

        speak(machine, 4.0, |spoken| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match state >> 29 {
                0 => None,
                1 => Some(f32::NAN),
                2 => Some(f32::INFINITY),
                // Full scale for half a second, now one way, now the other.
                _ => Some(if spoken / 50 % 2 == 0 { 3.2 } else { -3.2 }),
            }
        });

        let trace = machine.take_trace();
        let (mut largest, mut fastest) = (0i64, 0.0f64);
        let times: Vec<[i64; 8]> = trace
            .positions_every(16_800_000)
            .map(|(_, positions)| positions)
            .collect();
        for pair in times.windows(2) {
            largest = largest.max(pair[1][2].abs());
            fastest = fastest.max((pair[1][2] - pair[0][2]).abs() as f64);
            // The pair moves, the wall does not; a step may fall to either side of the instant looked at.
            assert!((pair[1][2] + pair[1][6]).abs() <= 1);
        }
        // 0.08 mm; 0.5 mm/s is 50 steps in 0.1 s, one more at each end.
        assert!((60..=80).contains(&largest), "{largest} steps");
        assert!((40.0..=52.0).contains(&fastest), "{fastest} steps in 0.1 s");
    });
}

#[test]
fn a_stream_that_could_not_keep_its_promise_is_refused_by_name() {
    eight(|machine| {
        for (line, name) in [
            ("$TRIM=ON,0,0.09,0.08,0.5,0.3,5", "BadLimit period"),
            ("$TRIM=ON,10,0,0.08,0.5,0.3,5", "BadLimit tau"),
            ("$TRIM=ON,10,0.09,-1,0.5,0.3,5", "BadLimit amount"),
            ("$TRIM=ON,10,0.09,0.2,0.5,0.3,5", "BadLimit amount"),
            ("$TRIM=ON,10,0.09,0.08,0,0.3,5", "BadLimit rate"),
            ("$TRIM=ON,10,0.09,0.08,50,0.3,5", "BadLimit rate"),
            ("$TRIM=ON,10,0.09,0.08,0.5,0,5", "BadLimit gate"),
        ] {
            let answer = machine.ask(line);
            assert!(
                answer.contains(name) && answer.ends_with("error:52\r\n"),
                "{line}: {answer}"
            );
        }
        assert_eq!(machine.ask("$TRIM=ON,10,0.09,0.08,0.5,0.3"), "error:2\r\n");
        assert_eq!(
            machine.ask("$TRIM=ON,10,0.09,0.08,0.5,0.3,-1"),
            "error:4\r\n"
        );
        machine.ask("$376=7");
        assert!(machine.ask(FOLLOW).ends_with("error:53\r\n"));
    });
    six(|machine| assert!(machine.ask(FOLLOW).ends_with("error:53\r\n")));
}
