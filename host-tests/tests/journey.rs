//! Bytes in, six pulse trains out: the whole machine in memory.

use hexstep_host::machine;

/// A small drill cycle that the machine is done with in seconds: both flanks, two passes, one spark-out.
const SHORT: &str = "$DRILL=D9.9,W1.63,P118,C50,R10,F30,S0.03,A0.02,B0.01,N1,K1,V120,I20,Q2";

#[test]
fn a_machine_says_its_banner_first_and_stands_at_zero() {
    machine::with(|m| {
        m.run(10);
        assert_eq!(m.heard(), "\r\nGrbl 1.1h ['$' for help]\r\n");

        m.put(b"?");
        m.run(10);
        let status = m.heard();
        assert!(
            status.starts_with("<Idle|MPos:0.000,0.000,0.000,0.000,0.000,0.000|"),
            "{status}"
        );
        assert!(status.contains("|WCO:"), "the first report says the offset");
        m.put(b"?");
        m.run(10);
        assert!(!m.heard().contains("|WCO:"));
    });
}

#[test]
fn a_line_of_counts_puts_every_motor_where_it_says() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        assert_eq!(m.ask("$SEG=7,3,-5,1,0,2,0.01"), "ok\r\n");
        assert_eq!(
            m.ask("$SEG=10000,-6180,3819,-2360,1459,901,0.5,CENTRED"),
            "ok\r\n"
        );

        assert_eq!(
            m.controller.counts(),
            [10007, -6177, 3814, -2359, 1459, 903]
        );
        assert_eq!(m.trace.positions(), [10007, -6177, 3814, -2359, 1459, 903]);
        assert_eq!(m.starved(), 0);
        m.put(b"?");
        m.run(5);
        assert!(
            m.heard()
                .starts_with("<Idle|MPos:10.007,-6.177,3.814,-1.180,0.730,0.452|")
        );
    });
}

#[test]
fn every_line_gets_one_answer_and_a_pair_of_ends_counts_once() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        for (bytes, answer) in [
            ("\r\n", "ok\r\n"),
            ("\r", "ok\r\n"),
            ("( a comment with ? in it )\n", "ok\r\n"),
            ("; another\n", "ok\r\n"),
            ("G0 X1\n", "error:20\r\n"),
            ("$FOO\n", "error:3\r\n"),
            ("$999=1\n", "error:3\r\n"),
            ("$0=abc\n", "error:2\r\n"),
            ("$100=-1\n", "error:4\r\n"),
            ("$0=0.5\n", "error:6\r\n"),
            ("$110=1e3\n", "error:2\r\n"),
            ("$0=1e3\n", "error:2\r\n"),
            ("$SEG=1,2,3\n", "error:2\r\n"),
            ("$SEG=1,2,3,4,5,x,1\n", "error:2\r\n"),
            ("$SEG=1,2,3,4,5,6,1,7\n", "error:2\r\n"),
            ("$100 = 1000\n", "ok\r\n"),
        ] {
            m.put(bytes.as_bytes());
            m.run_to_rest();
            let heard: String = m
                .heard()
                .lines()
                .filter(|l| !l.starts_with('<'))
                .map(|l| format!("{l}\r\n"))
                .collect();
            assert_eq!(heard, answer, "{bytes:?}");
        }
        let long = "G".repeat(300);
        assert_eq!(m.ask(&long), "error:11\r\n");
        assert_eq!(m.ask(""), "ok\r\n");
        assert!(m.trace.is_empty(), "nothing moved");
    });
}

#[test]
fn a_setting_that_another_one_bounds_is_refused_by_the_name_of_both() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        for (line, answer) in [
            (
                "$0=5",
                "[MSG:$0 refused: see $113 $103: 120000 steps/s, and $0 $1010 allow 100000]\r\nerror:12\r\n",
            ),
            // In both-edge mode pulses of 5 us fit, and then the mode cannot go back.
            ("$1010=1", "ok\r\n"),
            ("$0=5", "ok\r\n"),
            (
                "$1010=0",
                "[MSG:$1010 refused: see $113 $103: 120000 steps/s, and $0 $1010 allow 100000]\r\nerror:12\r\n",
            ),
            (
                "$110=900000",
                "[MSG:$110 refused: see $110 $100: 15000000 steps/s, and $0 $1010 allow 200000]\r\nerror:12\r\n",
            ),
            (
                "$800=1",
                "[MSG:$800 refused: see $110 $120 $800]\r\nerror:52\r\n",
            ),
            (
                "$1042=201",
                "[MSG:$1042 refused: see $1042 $1052]\r\nerror:52\r\n",
            ),
            (
                "$801=1000000000000",
                "[MSG:$801 refused: see $801 $101]\r\nerror:52\r\n",
            ),
        ] {
            assert_eq!(m.ask(line), answer, "{line}");
        }
    });
}

#[test]
fn a_refused_line_of_counts_says_why_and_moves_nothing() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        for (line, name, error) in [
            (
                "$SEG=100000000,0,0,0,0,0,1",
                "OutOfRange count 0",
                "error:52",
            ),
            ("$SEG=0,0,0,-100000,0,0,0.1", "TooFast duration", "error:12"),
            ("$SEG=5,0,0,0,0,0,900000", "TooSlow duration", "error:52"),
            (
                "$SEG=0,200001,0,0,0,0,10",
                "OutOfTravel joint 1",
                "error:15",
            ),
            ("$SEG=1,0,0,0,0,0,-1", "OutOfRange duration", "error:52"),
        ] {
            let answer = m.ask(line);
            assert!(
                answer.contains(name) && answer.ends_with(&format!("{error}\r\n")),
                "{line}: {answer}"
            );
        }
        assert!(m.trace.is_empty(), "nothing moved");
    });
}

#[test]
fn a_refused_drill_is_named_with_its_field_and_changes_nothing() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        let before = m.ask("$DRILL");
        for (words, expected) in [
            ("D-1", "OutOfRange diameter"),
            ("W9.9", "OutOfRange web"),
            ("P180", "OutOfRange point_angle"),
            (
                "C130",
                "OutOfRange chisel_angle: chisel_angle must be between 0 and 90 deg; where a drawing gives",
            ),
            ("R90", "OutOfRange clearance"),
            ("F59", "OutOfRange phi"),
            ("R4", "ClearanceTooSmall clearance least 5.64986"),
            ("F3", "PhiTooSmall phi phi_min 3.29767"),
            ("D10,W1.82,P140.74,C61.41,R19.87,F47.17", "NoTip"),
            ("D10,W1.09,P120.99,C40.78,R8.76,F28.56", "NoChiselEnd"),
            ("S0", "OutOfRange stock"),
            ("N1.5", "OutOfRange finish_passes"),
            ("V0", "OutOfRange stroke_speed"),
            ("L-1", "OutOfRange l1"),
            ("X1", "UnknownField X"),
            ("D1,D2", "RepeatedField D"),
            ("Dnan", "NotFinite diameter"),
            ("D1e2", "BadNumber D"),
            ("D", "BadNumber D"),
        ] {
            let answer = m.ask(&format!("$DRILL={words}"));
            assert!(
                answer.starts_with(&format!("[MSG:{expected}")),
                "{words}: {answer}"
            );
            assert!(answer.ends_with("]\r\nerror:52\r\n"), "{words}: {answer}");
        }
        assert_eq!(m.ask("$DRILL"), before);
        assert!(m.trace.is_empty(), "nothing moved");
    });
}

#[test]
fn a_drill_cycle_ends_at_its_last_pose_with_nothing_lost() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        assert_eq!(m.ask(SHORT), "ok\r\n");

        assert_eq!(m.ask("$DRILL=RUN"), "ok\r\n");

        assert_eq!(m.starved(), 0);
        let counts = m.controller.counts();
        assert_eq!(m.trace.positions(), counts.map(i64::from));
        // Retracted by 3 mm at mu = -2 deg, flank 1 in front. mu = -2 is the first row of the worked pulses.
        assert_eq!(counts, [2543, 3049, 157, 100, -1997, 3463]);
        m.put(b"?");
        m.run(5);
        assert!(
            m.heard()
                .starts_with("<Idle|MPos:2.543,3.049,0.157,0.050,-0.999,1.732|")
        );
    });
}

#[test]
fn a_drill_beyond_the_travel_is_refused_before_anything_moves() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        assert_eq!(m.ask(SHORT), "ok\r\n");
        assert_eq!(m.ask("$1040=-30"), "ok\r\n");
        let answer = m.ask("$DRILL=RUN");
        assert!(
            answer.starts_with("[MSG:OutOfTravel joint 0: travel is -30 to 200"),
            "{answer}"
        );
        assert!(answer.ends_with("error:15\r\n"), "{answer}");
        assert!(m.trace.is_empty());
    });
}

#[test]
fn a_soft_reset_in_motion_stops_at_once_locks_and_knows_where_it_stopped() {
    machine::with(|m| {
        m.run(10);
        m.heard();
        m.ask(SHORT);
        m.say("$DRILL=RUN");
        m.run(60_000);
        assert_eq!(m.heard(), "ok\r\n");
        let before = m.trace.ticks();
        m.put(&[0x18]);
        m.run(500);
        let last = m.trace.events().last().unwrap();
        // The foreground asks, the next tick stops; in pulse mode the one after that ends the pulse.
        assert!(
            last.tick <= before + 3,
            "last edge {} ticks after the byte",
            last.tick - before
        );

        let heard = m.heard();
        assert_eq!(
            heard,
            "ALARM:3\r\n\r\nGrbl 1.1h ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n"
        );
        assert_eq!(m.controller.counts().map(i64::from), m.trace.positions());
        assert!(m.ask("$DRILL=RUN").ends_with("error:9\r\n"));
        assert_eq!(m.ask("$X"), "[MSG:Caution: Unlocked]\r\nok\r\n");
        assert_eq!(m.ask("$DRILL=RUN"), "ok\r\n");
        assert_eq!(m.controller.counts(), [2543, 3049, 157, 100, -1997, 3463]);
        assert_eq!(m.trace.positions(), m.controller.counts().map(i64::from));
        assert_eq!(m.starved(), 0);
    });
}

#[test]
fn a_soft_reset_at_rest_keeps_the_position_and_raises_no_alarm() {
    machine::with(|m| {
        m.run(10);
        m.ask("$SEG=100,0,0,0,0,0,0.1");
        m.heard();
        m.put(b"G1 half a li\x18");
        m.run(50);
        assert_eq!(m.heard(), "\r\nGrbl 1.1h ['$' for help]\r\n");
        m.put(b"?");
        m.run(5);
        assert!(m.heard().starts_with("<Idle|MPos:0.100,0.000,"));
    });
}

#[test]
fn a_machine_in_both_edge_mode_steps_to_the_same_place() {
    machine::with(|m| {
        m.run(10);
        assert_eq!(m.ask("$1010=1").lines().last(), Some("ok"));
        m.ask(SHORT);
        m.ask("$DRILL=RUN");
        assert_eq!(m.controller.counts(), [2543, 3049, 157, 100, -1997, 3463]);
        assert_eq!(m.trace.positions(), m.controller.counts().map(i64::from));
    });
}
