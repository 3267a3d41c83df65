//! Every figure that the specification prints.

use crate::common::*;
use hexstep::cycles::precession::{
    Cycle, Drive, Parameters, Reference, Stance, Surface, Turn, along_feed, along_heading, angles,
    axis, contact_radius, rubbing_speed, tool_frame,
};
use hexstep::geometry::Rotation;

/// Section 8, single poses: frame, axis and reported angles.
#[track_caller]
fn single_pose(frame: Rotation<f64>, theta: f64, alpha: f64, p: &str, reported: &str) {
    let tilt = theta.to_radians().sin_cos();
    let phase = Turn::of_turns(alpha / 360.0).sin_cos();

    let got = axis(&frame, tilt, phase);

    printed_vector(p, got);
    let [lx, ly, lz] = angles(&frame).map(f64::to_degrees);
    printed_vector(reported, v(lx, ly, lz));
    assert!((tool_frame(&frame, tilt, phase).a - got).norm() < 1e-15);
}

fn heading(n: V, gamma: f64) -> Rotation<f64> {
    along_heading(gamma.to_radians(), n.unit(1e-6).unwrap()).unwrap()
}

#[test]
fn single_poses_are_those_of_the_table() {
    let up = v(0.0, 0.0, 1.0);
    let slope = v(0.2, 0.3, 0.87f64.sqrt());
    single_pose(
        heading(up, 0.0),
        20.0,
        0.0,
        "0.342020143 0 0.939692621",
        "0 0 0",
    );
    single_pose(
        heading(up, 0.0),
        20.0,
        90.0,
        "0 0.342020143 0.939692621",
        "0 0 0",
    );
    single_pose(
        heading(slope, 50.0),
        20.0,
        60.0,
        "0.061119959 0.591211850 0.804197052",
        "-17.457603124 12.102250419 48.556424801",
    );
    single_pose(
        heading(slope, 130.0),
        20.0,
        60.0,
        "-0.141335577 0.241988254 0.959930174",
        "-17.457603124 12.102250419 127.027894981",
    );
    single_pose(
        heading(v(0.5, -0.5, 0.5f64.sqrt()), 85.0),
        20.0,
        0.0,
        "0.494921809 -0.183232048 0.849398858",
        "30 35.264389683 104.614870109",
    );
    single_pose(
        heading(v(1.0, 0.0, 0.0), 30.0),
        20.0,
        45.0,
        "0.939692621 0.241844763 -0.241844763",
        "0 90 0",
    );
    let fed = along_feed(v(1.0, 1.0, 0.0), v(0.0, -0.6, 0.8)).unwrap();
    single_pose(
        fed,
        15.0,
        200.0,
        "-0.134616539 -0.756400170 0.640107156",
        "36.869897646 0 38.659808254",
    );
}

#[test]
fn the_turn_free_frame_of_row_3_is_the_printed_one() {
    let frame = heading(v(0.2, 0.3, 0.87f64.sqrt()), 50.0);

    let tool = tool_frame(
        &frame,
        20f64.to_radians().sin_cos(),
        60f64.to_radians().sin_cos(),
    );

    printed_vector("0.600023671 0.715080366 -0.358652567", frame.n);
    printed_vector("0.577002424 0.636508019 -0.511786815", tool.n);
    printed_vector("-0.814452302 0.495304038 -0.302227327", tool.s);
}

#[track_caller]
fn pose(stance: &Stance<f64>, t: &str, phase: &str, c: &str, f: &str) {
    printed(t, stance.time);
    printed(phase, stance.phase.to_degrees());
    printed_vector(c, stance.centre);
    printed_vector(f, stance.far);
}

#[test]
fn the_plane_of_the_paper_gives_the_printed_poses() {
    let parameters = Parameters {
        dt_max: 1.0,
        ..process::<f64>()
    };
    let line = flat(&[[0.0, 0.0], [60.0, 0.0]]);

    let poses = stances(&parameters, &line);

    assert_eq!(poses.len(), 67);
    pose(
        &poses[0],
        "0",
        "0",
        "0 0 39.5",
        "43.436558202 0 158.840962840",
    );
    let text = "44.148965013 4.128907357 158.840962840";
    pose(
        &poses[1],
        "0.181818182",
        "5.454545455",
        "0.909090909 0 39.5",
        text,
    );
    let text = "44.404345120 12.237492603 158.840962840";
    pose(
        &poses[3],
        "0.545454545",
        "16.363636364",
        "2.727272727 0 39.5",
        text,
    );
    pose(
        &poses[66],
        "12",
        "0",
        "60 0 39.5",
        "103.436558202 0 158.840962840",
    );
    for stance in &poses[1..] {
        printed("0.181818182", stance.dt);
        assert!((stance.inverse_time() - 330.0).abs() < 1e-9);
    }
    let far = || poses.iter().map(|s| s.far);
    printed("-14.469785", far().map(|f| f.x).fold(1e9, f64::min));
    printed("103.436558", far().map(|f| f.x).fold(-1e9, f64::max));
    printed("-43.387359", far().map(|f| f.y).fold(1e9, f64::min));
    printed("43.387359", far().map(|f| f.y).fold(-1e9, f64::max));
    let length = far().zip(far().skip(1)).map(|(a, b)| (b - a).norm()).sum();
    printed("276.125906", length);
}

#[test]
fn the_chord_and_the_axis_step_rule_the_count_in_turn() {
    let line = flat(&[[0.0, 0.0], [60.0, 0.0]]);
    let fine = Parameters {
        dt_max: 1.0,
        eps: 0.01,
        ..Parameters::default()
    };
    let coarse = Parameters {
        eps: 0.5,
        dpsi: 2f64.to_radians(),
        ..fine
    };

    assert_eq!(counts(&fine, &line), [147]);
    assert_eq!(counts(&coarse, &line), [62]);
}

#[test]
fn the_convex_cylinder_gives_the_printed_poses() {
    let cylinder = cylinder::<f64>();

    let poses = stances(&process(), &cylinder);

    assert_eq!(counts(&process(), &cylinder), [30; 12]);
    assert_eq!(poses.len(), 361);
    let table = [
        (
            1,
            "0.174477549",
            "5.234326484",
            "-168.876592151 0 -5.524245970",
            "-0.172019996 0.031202227 0.984599178",
            "-190.723131667 3.962682819 119.519849677",
        ),
        (
            30,
            "5.234326484",
            "157.029794515",
            "-143.478899861 0 7.691493699",
            "-0.682528176 0.133474182 0.718567973",
            "-230.159978170 16.951221162 98.949626291",
        ),
        (
            100,
            "17.447754946",
            "163.432648384",
            "-78.237953682 0 30.101212947",
            "-0.535692817 0.097524393 0.838762302",
            "-146.270941414 12.385597850 136.624025274",
        ),
        (
            360,
            "62.811917806",
            "84.357534183",
            "169.75 0 -5.984375415",
            "0.498968660 0.340362988 0.796983885",
            "233.119019828 43.226099446 95.232577971",
        ),
    ];
    for (i, t, phase, c, p, f) in table {
        pose(&poses[i], t, phase, c, f);
        printed_vector(p, poses[i].axis);
    }
}

#[test]
fn both_references_end_a_zigzag_alike_but_for_the_reported_phase() {
    let zigzag = flat(&ZIGZAG);
    for (reference, phase) in [(Reference::Transport, "12"), (Reference::FeedLocked, "192")] {
        let parameters = Parameters {
            reference,
            ..process::<f64>()
        };

        let poses = stances(&parameters, &zigzag);

        assert_eq!(counts(&parameters, &zigzag), [33, 3, 33]);
        let last = poses.last().unwrap();
        printed("12.4", last.time);
        printed(phase, last.phase.to_degrees());
        printed_vector("0.334546183 0.071109986 0.939692621", last.axis);
        printed_vector("42.487365190 11.030968259 158.840962840", last.far);
    }
}

#[test]
fn the_distance_drives_the_phase_to_two_and_a_half_turns() {
    let corner = flat(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]);
    let parameters = Parameters {
        drive: Drive::Distance { pitch: 8.0 },
        ..process::<f64>()
    };

    let poses = stances(&parameters, &corner);

    assert_eq!(counts(&parameters, &corner), [82, 82]);
    let last = poses.last().unwrap();
    printed("4", last.time);
    assert!(phase_distance(last.phase.to_degrees(), 180.0) < 1e-9);
}

#[test]
fn spot_radii_and_rubbing_speed_are_the_printed_ones() {
    let radius = |surface| contact_radius(40.0, 0.5, surface).unwrap();
    printed("6.304760106", radius(Surface::Plane));
    printed("5.926361188", radius(Surface::Convex(300.0)));
    printed("6.765466003", radius(Surface::Concave(300.0)));
    let w1 = 1000.0 * std::f64::consts::TAU / 60.0;
    printed("1414.742493", rubbing_speed(w1, 39.5, 20f64.to_radians()));
}

/// Section 5: on a plane the phase step could be 4 asin(sqrt(eps / (2 ell sin theta))); the bound is a little shorter.
#[test]
fn the_chord_bound_is_less_than_three_permille_shorter_than_need_be() {
    let line = flat(&[[0.0, 0.0], [6000.0, 0.0]]);
    let ell_sin = 127.0 * 20f64.to_radians().sin();
    for eps in [0.001, 0.01, 0.1, 0.5] {
        let parameters = Parameters {
            eps,
            dpsi: 1.0,
            dt_max: 1e3,
            ..Parameters::default()
        };

        let count = counts(&parameters, &line)[0];

        let exact = 4.0 * (eps / (2.0 * ell_sin)).sqrt().asin();
        let turn = 1200.0 * 30f64.to_radians();
        let longer = exact / (turn / f64::from(count));
        assert!((1.0..1.003).contains(&longer), "{eps}: {longer}");
    }
}

#[test]
fn waypoints_hold_the_turn_free_frame_in_the_centre() {
    let cylinder = cylinder::<f64>();
    let cycle = Cycle::new(&process(), &cylinder).unwrap();

    let waypoints: Vec<_> = cycle.clone().collect();

    assert_eq!(waypoints.len(), 361);
    for (waypoint, stance) in waypoints.iter().zip(cycle.stances()) {
        assert_eq!(waypoint.pose.rotation, stance.tool());
        assert_eq!(waypoint.pose.p, stance.centre);
        assert_eq!(waypoint.duration, stance.dt);
    }
}
