//! Jobs with poses: machines of every kind, followed, run to pulses, and measured through a forward map of another hand.

use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::chain::{Carries, Chain, Joint};
use hexstep::kinematics::chord::{ChainSet, Paced};
use hexstep::kinematics::follow::{Feed, Follower, Guide, Tolerance};
use hexstep::kinematics::inverse::rotation_vector;
use hexstep::kinematics::{ClPoint, Course, PoseWay, Way, inverse};
use hexstep::machines::Arm;
use hexstep::machines::arm::{ArmSet, OneBranch};
use hexstep_host::cli::run::DELIVERED;
use hexstep_host::job::{Job, JobError, PosesJob, Task};
use hexstep_host::poses::{Measured, Plan};
use hexstep_host::reference::five_axis::Random;
use hexstep_host::reference::matrix::{angle_deg, distance};
use hexstep_host::reference::serial::Forward;
use hexstep_host::report::PosesFigures;
use hexstep_host::run::{self, Outcome};
use std::path::Path;

fn near(found: f64, wanted: f64, digits: i32, what: &str) {
    let slack = 0.5000001 * 10f64.powi(-digits);
    assert!(
        (found - wanted).abs() <= slack,
        "{what}: {found} and not {wanted}"
    );
}

fn all_near(found: &[f64], wanted: &[f64], digits: i32, what: &str) {
    assert!(found.len() >= wanted.len(), "{what}");
    for (i, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        near(*found, *wanted, digits, &format!("{what}, {i}"));
    }
}

fn text_of(name: &str) -> String {
    let delivered = DELIVERED.iter().find(|job| job.name == name).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    std::fs::read_to_string(root.join(delivered.file)).unwrap()
}

fn parse(text: &str) -> Result<Job, JobError> {
    Job::parse("job.toml", "job", text.as_bytes())
}

fn poses(job: &Job) -> &PosesJob {
    match &job.task {
        Task::Poses(poses) => poses,
        _ => panic!("not a job with poses"),
    }
}

fn plan(text: &str) -> Result<(Job, Plan), JobError> {
    let job = parse(text)?;
    let plan = Plan::of(&job, poses(&job))?;
    Ok((job, plan))
}

fn run_job(job: &Job) -> Outcome {
    run::run(job, &mut |_, _| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// What a text becomes, with one line of it exchanged: the line that begins so.
fn with_line(text: &str, begins: &str, line: &str) -> String {
    let mut found = false;
    let lines = text.lines().map(|old| {
        if old.starts_with(begins) {
            found = true;
            line
        } else {
            old
        }
    });
    let text = lines.collect::<Vec<_>>().join("\n");
    assert!(found, "no line begins with {begins}");
    text
}

/// The same with other poses.
fn with_poses(text: &str, rows: &[&[f64]]) -> String {
    let (head, rest) = text.split_once("poses = [\n").unwrap();
    let (_, tail) = rest.split_once("\n]\n").unwrap();
    let rows: Vec<String> = rows.iter().map(|row| format!("{row:?}")).collect();
    format!("{head}poses = [\n{}\n]\n{tail}", rows.join(",\n"))
}

/// Runs a job and holds what its pulses show against what it may do; returns the tip error [mm].
#[track_caller]
fn judge(job: &Job) -> f64 {
    let outcome = run_job(job);
    let poses = poses(job);
    let figures = PosesFigures::of(job, poses, &outcome, 1.0);
    assert!(figures.is_exact() && outcome.starved == 0);
    let measured = &figures.measured;
    assert!(
        measured.tip <= poses.tip_tolerance + figures.step(),
        "tip {} mm",
        measured.tip
    );
    assert!(figures.keeps_angle(), "tool {} deg", measured.angle);
    for motor in &figures.motors.figures {
        assert!(figures.motors.keeps_limits(motor), "{}", motor.channel.name);
    }
    // Nothing jumps: no joint goes farther in a millisecond than its speed allows, but for the grid of whole steps.
    let every = hexstep_host::machine::TICK_HZ as u64 / 1000;
    let rebuilt = outcome.trace.rebuilt_every(every);
    for (i, joint) in poses.machine.joints.iter().enumerate() {
        let most = joint.limits.max_rate * joint.limits.steps_per_unit * 1e-3;
        let largest = rebuilt
            .windows(2)
            .map(|pair| (pair[1][i] - pair[0][i]).abs())
            .fold(0.0, f64::max);
        assert!(
            largest <= 1.002 * most + 1.0,
            "{}: {largest} steps in a millisecond, {most} allowed",
            joint.name
        );
    }
    // The path is run to its end: the last sample stands at the last pose.
    let (last, row) = (measured.samples.last().unwrap(), poses.rows.last().unwrap());
    assert!(distance(last.tool.tip, row.tip) <= poses.tip_tolerance + figures.step());
    measured.tip
}

#[test]
fn the_frustum_takes_the_points_and_joints_of_the_specification_and_its_pulses_keep_its_tolerance()
{
    let job = parse(&text_of("frustum")).unwrap();
    let outcome = run_job(&job);
    let plan = &outcome.poses.as_ref().unwrap().plan;

    // Section 9, tolerance 0.01 mm.
    assert_eq!(plan.blocks.len() + 1, 517);
    let ends = |segment| plan.blocks.iter().rfind(|b| b.segment == segment).unwrap();
    for (found, wanted) in [
        (
            plan.start,
            [165.470798, -267.700454, -4.835602, -5.682713, -16.020845],
        ),
        (
            ends(0).joints,
            [214.980555, 229.842292, -4.835602, -5.682713, -16.020845],
        ),
        (
            ends(1).joints,
            [293.270153, -29.182887, -4.835602, -50.682713, -16.020845],
        ),
        (
            ends(2).joints,
            [165.470798, -267.700454, -4.835602, -95.682713, -16.020845],
        ),
        (
            ends(11).joints,
            [165.470798, -267.700454, -4.835602, -365.682713, -16.020845],
        ),
    ] {
        all_near(&found, &wanted, 6, "joints");
    }
    let first = plan.blocks.iter().find(|b| b.segment == 1).unwrap();
    let row = [217.612133, 226.852274, -4.775910, -6.295594, -15.949879];
    all_near(&first.joints, &row, 6, "u = 1/64");
    // Where no joint is too slow the feed gives the time: 500 mm at 1000 mm/min.
    near(plan.blocks[0].duration, 30.0, 9, "a side");
    // In the corners a joint is, and the block says which.
    assert!(first.duration > 7.036e-3 && first.limited_by.is_some());

    let figures = PosesFigures::of(&job, poses(&job), &outcome, 1.0);
    assert!(figures.is_exact() && outcome.starved == 0);
    assert!(
        figures.measured.tip <= 0.01 + figures.step(),
        "{} mm",
        figures.measured.tip
    );
    // Not by luck: without the halving the corners would be off by 26.2 mm, and the path is more than its corners.
    assert!(figures.measured.samples.len() > 100_000 && figures.measured.tip > 0.002);
    for motor in &figures.motors.figures {
        assert!(figures.motors.keeps_limits(motor), "{}", motor.channel.name);
    }
}

#[test]
fn a_pole_is_crossed_passed_and_crossed_back_without_a_jump() {
    let job = parse(&text_of("pole-crossing")).unwrap();
    let (_, plan) = plan(&text_of("pole-crossing")).unwrap();

    // Straight through the pole: C has no reason to move. Past it, C makes most of half a turn and the tip waits for it.
    let of = |segment| plan.blocks.iter().filter(move |b| b.segment == segment);
    assert!(of(0).all(|b| (b.joints[3] - plan.start[3]).abs() < 1e-9));
    let swing = of(2).next_back().unwrap().joints[3] - of(1).next_back().unwrap().joints[3];
    assert!(swing.abs() > 150.0, "C swings by {swing} deg");
    assert!(of(2).any(|b| b.limited_by == Some(3)));
    judge(&job);
}

#[test]
fn an_arm_goes_round_in_one_branch_and_reaches_every_pose() {
    let (job, plan) = plan(&text_of("arm-path")).unwrap();
    let poses = poses(&job);

    assert_eq!(plan.branch, Some(0));
    for (index, row) in poses.rows.iter().enumerate().skip(1) {
        let end = plan.blocks.iter().rfind(|b| b.segment == index - 1);
        let tool = poses
            .machine
            .forward
            .at(&end.unwrap().joints.map(f64::to_radians));
        assert!(distance(tool.tip, row.tip) < 1e-6, "pose {index}");
        assert!(angle_deg(tool.axis, row.axis) < 1e-6, "pose {index}");
        let across = angle_deg(tool.across.unwrap(), row.across.unwrap());
        assert!(across < 1e-6, "pose {index}");
    }
    judge(&job);
}

#[test]
fn a_side_of_a_two_sided_machine_takes_the_joints_of_the_specification() {
    let (job, plan) = plan(&text_of("two-sided")).unwrap();
    let at = |segment: usize| {
        plan.blocks
            .iter()
            .rfind(|b| b.segment == segment)
            .unwrap()
            .joints
    };

    // Section 9, M4, side 1: x = -400, 0 and 500 are the poses 5, 25 and 50.
    let row = [159.85, 550.0, -70.562795575, -5.739170477];
    all_near(&at(4), &row, 6, "x = -400");
    all_near(&at(24), &[600.0, 550.0, -48.5, 0.0], 6, "x = 0");
    let row = [1150.1875, 550.0, -83.022101631, 7.180755781];
    all_near(&at(49), &row, 6, "x = 500");
    judge(&job);
}

#[test]
fn both_sides_of_the_five_axis_pair_take_the_joints_of_the_specification() {
    // Section 9, M5: P = (100, 50, -2), n = (.1, .05, .99), wall 1.5. Side 2 sees x and z negated.
    let n = [0.1f64, 0.05, 0.99];
    let size = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    let n = n.map(|x| x / size);
    let mill: Vec<f64> = (0..3)
        .map(|i| [100.0, 50.0, -2.0][i] + 1.5 * n[i])
        .collect();
    let five = |text: &str, side: &str| {
        let text = with_line(text, "pair", "pair = \"m5\"");
        let text = with_line(&text, "side", &format!("side = \"{side}\""));
        let text = with_line(
            &text,
            "steps_per_unit",
            "steps_per_unit = [400, 400, 800, 5000, 5000]",
        );
        let text = with_line(&text, "max_rate", "max_rate = [300, 300, 100, 20, 20]");
        let text = with_line(
            &text,
            "acceleration",
            "acceleration = [1500, 1500, 1000, 200, 200]",
        );
        let text = with_line(&text, "jerk", "jerk = [30000, 30000, 20000, 8000, 8000]");
        with_line(
            &text,
            "travel",
            "travel = [[-1300, 1300], [-100, 1000], [-200, 200], [-30, 30], [-30, 30]]",
        )
    };
    let first = [mill[0], mill[1], mill[2], n[0], n[1], n[2]];
    let mut second = first;
    second[1] += 1.0;
    let text = with_poses(&five(&text_of("two-sided"), "mill"), &[&first, &second]);
    let row = [
        746.329306955,
        520.149692299,
        -53.339861142,
        5.767888898,
        -2.876656294,
    ];
    all_near(&plan(&text).unwrap().1.start, &row, 6, "mill");

    let first = [-100.0, 50.0, 2.0, n[0], -n[1], n[2]];
    let mut second = first;
    second[1] += 1.0;
    let text = with_poses(&five(&text_of("two-sided"), "support"), &[&first, &second]);
    let row = [
        -655.828692469,
        480.929307413,
        -50.704055442,
        5.767888898,
        -2.876656294,
    ];
    all_near(&plan(&text).unwrap().1.start, &row, 6, "support");
}

#[test]
fn a_four_axis_side_takes_a_direction_that_it_cannot_reach_as_near_as_it_can_and_says_by_how_much()
{
    // Section 9, M4, the row with a residual of 2.876656294 deg.
    let n = Vector::new(0.1f64, 0.05, 0.99).unit(0.1).unwrap();
    let at = |y: f64| {
        let p = Vector::new(100.0, y, -2.0) + n * 1.5;
        [p.x, p.y, p.z, n.x, n.y, n.z]
    };
    let text = with_poses(&text_of("two-sided"), &[&at(50.0), &at(80.0)]);
    let (job, plan) = plan(&text).unwrap();

    let row = [740.350040484, 500.075279050, -52.534599207, 5.767888898];
    all_near(&plan.start, &row, 6, "joints");
    near(plan.residual, 2.876656294, 6, "residual");
    judge(&job);
}

#[test]
fn the_best_choice_goes_where_the_nearest_is_trapped_by_a_limit() {
    // Section 9, path choice.
    let head = text_of("pole-crossing");
    let head = with_line(&head, "primary_point", "");
    let head = with_line(&head, "secondary_point", "");
    let head = with_line(
        &head,
        "travel",
        "travel = [[-300, 300], [-300, 300], [-200, 200], [-270, 270], [-110, 25]]",
    );
    let head = with_line(&head, "near", "near = [0, 0, 0, 0, 5]");
    let trap = with_poses(
        &head,
        &[
            &[0.0, 0.0, 0.0, 0.05, -0.2, 0.97],
            &[5.0, 0.0, 0.0, 0.1, -0.4, 0.9],
            &[10.0, 0.0, 0.0, 0.1, -0.6, 0.75],
        ],
    );
    let best = with_line(&trap, "feed", "feed = 1500\nchoice = \"best\"");

    let error = plan(&trap).unwrap_err();
    assert_eq!(
        (error.name, error.key.as_deref()),
        ("Reconfigure", Some("path.poses[2]"))
    );

    let (job, plan) = plan(&best).unwrap();
    all_near(&plan.start[3..], &[-165.963757, -11.998611], 6, "pose 0");
    let end = |segment| {
        plan.blocks
            .iter()
            .rfind(|b| b.segment == segment)
            .unwrap()
            .joints
    };
    all_near(&end(0)[3..], &[-165.963757, -24.613598], 6, "pose 1");
    all_near(&end(1)[3..], &[-170.537678, -39.043262], 6, "pose 2");
    judge(&job);
}

#[test]
fn a_machine_of_ones_own_and_inverse_time_are_the_same_as_the_preset_and_the_feed() {
    let text = text_of("frustum");
    let (_, preset) = plan(&text).unwrap();
    let own = "model = \"five-axis\"\nclass = \"mixed\"\nprimary_axis = [0, 0, 2]\nsecondary_axis = [0, 1, 1]\nsecondary_point = [0, 0, 350]";
    let own = with_line(&text, "model", own);
    // A side of 500 mm at 1000 mm/min takes half a minute.
    let own = with_line(&own, "feed", "inverse_time = 2");
    let (_, own) = plan(&own).unwrap();

    assert_eq!(own.blocks.len(), preset.blocks.len());
    for (a, b) in own.blocks.iter().zip(&preset.blocks) {
        all_near(&a.joints, &b.joints, 9, "joints");
    }
    near(own.blocks[0].duration, 30.0, 9, "a side");
    // Here the corners have half a minute for each of their halves, too: no joint is too slow for that.
    near(own.duration(), 12.0 * 30.0, 9, "all");
}

/// The generic side of the mirror milling specification, section 9: work chain X, B; tool chain Y, A and a quill W.
const CHAIN: &str = r#"
kind = "poses"
[machine]
model = "chain"
steps_per_unit = [1000, 4000, 1000, 4000, 1000]
max_rate = [100, 30, 100, 30, 100]
acceleration = [1000, 400, 1000, 400, 1000]
jerk = [20000, 10000, 20000, 10000, 20000]
travel = [[-200, 200], [-90, 90], [-200, 200], [-90, 90], [-200, 200]]
[[joint]]
name = "X"
carries = "work"
motion = "linear"
axis = [1, 0, 0]
[[joint]]
name = "B"
carries = "work"
motion = "rotary"
axis = [0, 1, 0]
point = [0, 0, -100]
[[joint]]
name = "Y"
carries = "tool"
motion = "linear"
axis = [0, 1, 0]
[[joint]]
name = "A"
carries = "tool"
motion = "rotary"
axis = [1, 0, 0]
point = [0, 0, 300]
[[joint]]
name = "W"
carries = "tool"
motion = "linear"
axis = [0, 0, 1]
[path]
feed = 2000
poses = [
[20, 30, 40, 0.2, 0.1, 0.97],
[60, 10, 30, -0.1, 0.2, 0.97],
[0, 0, 0, 0, 0, 1],
]
"#;

#[test]
fn a_chain_of_any_joints_is_solved_followed_and_run() {
    let (job, plan) = plan(CHAIN).unwrap();

    let row = [
        8.683325557,
        -11.650299438,
        56.135343378,
        -5.765552190,
        39.838442057,
    ];
    all_near(&plan.start, &row, 6, "the printed solution");
    all_near(&plan.blocks.last().unwrap().joints, &[0.0; 5], 6, "home");
    judge(&job);
}

#[test]
fn poses_of_a_csv_file_run_as_those_written_in_the_job_do_and_their_errors_name_its_lines() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let job = folder.join("csv-job.toml");
    let write = |csv: &str| std::fs::write(folder.join("poses.csv"), csv).unwrap();
    let (head, _) = CHAIN.split_once("poses = [").unwrap();
    std::fs::write(&job, format!("{head}file = \"poses.csv\"\n")).unwrap();
    let load = || Job::load(&job);
    write(
        "# a head\nX,Y,Z,I,J,K,F\n20,30,40,.2,.1,.97,\n\n60,10,30,-.1,.2,.97,1000\n0,0,0,0,0,1,\n",
    );

    let loaded = load().unwrap();
    let from_file = Plan::of(&loaded, poses(&loaded)).unwrap();
    let (_, from_job) = plan(CHAIN).unwrap();
    assert_eq!(from_file.blocks.len(), from_job.blocks.len());
    for (a, b) in from_file.blocks.iter().zip(&from_job.blocks) {
        assert_eq!(a.joints, b.joints);
        let slower = if a.segment == 0 { 2.0 } else { 1.0 };
        assert!((a.duration - slower * b.duration).abs() < 1e-12);
    }

    for (csv, line, name) in [
        (
            "X,Y,Z,I,J,Q\n1,2,3,0,0,1\n1,2,4,0,0,1\n",
            Some(1),
            "UnknownField",
        ),
        ("X,Y,Z,I,J\n1,2,3,0,0\n", Some(1), "MissingField"),
        (
            "X,Y,Z,I,J,K\n1,2,3,0,0,1\n1,2,x,0,0,1\n",
            Some(3),
            "WrongType",
        ),
        (
            "X,Y,Z,I,J,K\n1,2,3,0,0,1\n1,2,inf,0,0,1\n",
            Some(3),
            "NotFinite",
        ),
        (
            "X,Y,Z,I,J,K\n1,2,3,0,0,1\n1,2,3,0,0\n",
            Some(3),
            "WrongType",
        ),
        (
            "X,Y,Z,I,J,K,F\n1,2,3,0,0,1,5\n1,2,4,0,0,1,0\n",
            Some(3),
            "OutOfRange",
        ),
        (
            "X,Y,Z,I,J,K\n1,2,3,0,0,1\n\n# no axis\n1,2,4,0,0,0\n",
            Some(5),
            "BadDirection",
        ),
        ("X,Y,Z,I,J,K\n1,2,3,0,0,1\n", Some(2), "OutOfRange"),
        ("", None, "OutOfRange"),
    ] {
        write(csv);
        let error = load().unwrap_err();
        assert_eq!(
            (error.name, error.place.map(|p| p.line)),
            (name, line),
            "{error}"
        );
        assert!(error.file.ends_with("poses.csv"), "{error}");
    }
    std::fs::remove_file(folder.join("poses.csv")).unwrap();
    let error = load().unwrap_err();
    assert_eq!(
        (error.name, error.key.as_deref()),
        ("BadFile", Some("path.file")),
        "{error}"
    );
    assert!(error.detail.contains("poses.csv cannot be read"), "{error}");
    // What shows only when the path is followed names its line as well.
    write("X,Y,Z,I,J,K\n20,30,40,.2,.1,.97\n20,30,40,.2,.1,-.97\n");
    let error = run::run(&load().unwrap(), &mut |_, _| {}).unwrap_err();
    assert_eq!(error.place.map(|p| p.line), Some(3), "{error}");
}

#[test]
fn what_a_machine_cannot_do_is_refused_by_name_at_its_pose_before_anything_moves() {
    let s45 = text_of("frustum");
    let head = text_of("pole-crossing");
    let arm = text_of("arm-path");
    let side = text_of("two-sided");
    let up = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    // On a table the work hangs on the axis that swings: beside the pole no chord is short enough.
    let table = with_line(&head, "model", "model = \"table_ac\"");
    let table = with_line(
        &table,
        "travel",
        "travel = [[-300, 300], [-300, 300], [-200, 200], [-110, 110], [-720, 720]]",
    );
    let beside_pole = with_poses(
        &with_line(&table, "near", ""),
        &[
            &[-60.0, 50.0, 0.0, -0.3, 5e-5, 1.0],
            &[60.0, 50.0, 0.0, 0.3, 5e-5, 1.0],
        ],
    );
    let wrist = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
    let far = [500.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
    for (text, name, key, words) in [
        // The reachable band of the slanted machine ends at 90 degrees; the gap is printed in the specification.
        (
            with_poses(&s45, &[&up, &[0.0, 0.0, 0.0, 0.9, 0.3, -0.1]]),
            "Unreachable",
            "path.poses[1]",
            "6.017285 deg",
        ),
        (
            with_poses(&s45, &[&[0.0, 0.0, 0.0, 0.9, 0.3, -0.1], &up]),
            "Unreachable",
            "path.poses[0]",
            "6.017285 deg",
        ),
        (
            with_poses(&s45, &[&up, &[0.0, 0.0, 0.0, 0.0, 0.0, -1.0]]),
            "AntiParallel",
            "path.poses[1]",
            "half a turn",
        ),
        (
            with_poses(&s45, &[&up, &[500.0, 0.0, 0.0, 0.0, 0.0, 1.0]]),
            "OutOfTravel",
            "path.poses[1]",
            "X would leave its travel of -400 to 400",
        ),
        (
            with_poses(&s45, &[&up, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]),
            "BadDirection",
            "path.poses[1]",
            "shorter",
        ),
        (beside_pole, "Coarse", "path.poses[1]", "4096 parts"),
        (
            with_line(
                &head,
                "travel",
                "travel = [[-300, 300], [-300, 300], [-200, 200], [-360, 360], [-10, 110]]",
            ),
            "Reconfigure",
            "path.poses[1]",
            "another solution",
        ),
        // Both ends are within, the middle is not.
        (
            with_line(
                &head,
                "travel",
                "travel = [[-300, 300], [-300, 300], [-200, -2], [-360, 360], [-110, 110]]",
            ),
            "OutOfTravel",
            "path.poses[1]",
            "between pose 0 and pose 1, at 0.5",
        ),
        (
            with_poses(&arm, &[&wrist, &far]),
            "NoBranch",
            "path.poses[1]",
            "branch 0: Unreachable",
        ),
        (
            with_poses(
                &arm,
                &[&wrist, &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]],
            ),
            "BadPose",
            "path.poses[1]",
            "right angles",
        ),
        (
            with_line(&side, "side", "side = \"both\""),
            "TooManyJoints",
            "machine.side",
            "8 joints",
        ),
        (
            with_line(&side, "feed", ""),
            "MissingField",
            "path.poses[1]",
            "no feed",
        ),
        (
            with_line(&side, "tip_tolerance", "tip_tolerance = 0"),
            "OutOfRange",
            "path.tip_tolerance",
            "greater than 0",
        ),
        (
            with_line(&side, "model", "model = \"three-axis\""),
            "UnknownName",
            "machine.model",
            "\"arm\"",
        ),
        (
            with_line(
                &s45,
                "model",
                "model = \"head_ca\"\nsecondary_axis = [0, 0, 1]",
            ),
            "ParallelAxes",
            "machine.secondary_axis",
            "parallel",
        ),
        (
            CHAIN.replace("axis = [0, 0, 1]\n", "axis = [0, 0, 0]\n"),
            "BadAxis",
            "joint[4].axis",
            "direction",
        ),
        (
            CHAIN.replace(
                "[60, 10, 30, -0.1, 0.2, 0.97]",
                "[60, 900, 30, -0.1, 0.2, 0.97]",
            ),
            "OutOfTravel",
            "path.poses[1]",
            "Y would leave",
        ),
    ] {
        let refused = parse(&text).and_then(|job| run::run(&job, &mut |_, _| {}).map(|_| ()));
        let error = refused.expect_err(name);
        assert_eq!(
            (error.name, error.key.as_deref()),
            (name, Some(key)),
            "{error}"
        );
        assert!(error.detail.contains(words), "{error}");
        assert!(error.place.is_some(), "{error}");
    }
}

#[test]
fn the_nearer_a_path_comes_to_the_pole_the_longer_it_takes_and_no_joint_is_too_fast() {
    let head = text_of("pole-crossing");
    let mut before = 0.0;
    for off in [0.2, 0.05, 0.01, 0.002] {
        let a = [-60.0, 0.0, 0.0, -0.3, off, 1.0];
        let b = [60.0, 0.0, 0.0, 0.3, off, 1.0];
        let (job, plan) = plan(&with_poses(&head, &[&a, &b])).unwrap();

        let joints = &poses(&job).machine.joints;
        let mut at = plan.start;
        for block in &plan.blocks {
            for (i, joint) in joints.iter().enumerate() {
                let speed = (block.joints[i] - at[i]).abs() / block.duration;
                assert!(
                    speed <= joint.limits.max_rate * (1.0 + 1e-9),
                    "{}",
                    joint.name
                );
            }
            at = block.joints;
        }
        let time = plan.duration();
        assert!(time > before, "{off}: {time} s");
        before = time;
    }
}

/// Largest errors along the chords of a followed course, looked at in many places: tip [mm], angle [rad].
fn strayed<M, const N: usize>(
    machine: &M,
    ends: &[<M::Course as Course<f64>>::End],
    set: M::Set,
    tolerance: Tolerance<f64>,
    off: impl Fn(&Joints<N, f64>, &M::Course, f64) -> (f64, f64),
) -> Option<(f64, f64, usize)>
where
    M: Guide<N, f64>,
{
    let mut follower = Follower::new(machine, tolerance, ends[0], set).ok()?;
    let (mut tip, mut angle, mut count) = (0.0f64, 0.0f64, 0);
    let mut from = set;
    for pair in ends.windows(2) {
        follower.push(pair[1], None, Feed::Tip(10.0)).ok()?;
        let course = M::Course::new(pair[0], pair[1])?;
        let mut u0 = 0.0;
        while let Some(block) = follower.next_block() {
            let change = machine.change(&from, &block.set);
            let start = machine.joints(&from);
            if block.flags.coarse || block.flags.reconfigure {
                return None;
            }
            for k in 1..40 {
                let part = f64::from(k) / 40.0;
                let q = start.zip_map(&change, |q, change| q + change * part);
                let (p, a) = off(&q, &course, u0 + (block.u - u0) * part);
                tip = tip.max(p);
                angle = angle.max(a);
            }
            from = block.set;
            u0 = block.u;
            count += 1;
        }
    }
    Some((tip, angle, count))
}

#[test]
fn chords_of_arms_and_chains_keep_their_tolerances_everywhere_between_their_ends() {
    let mut random = Random::new(45);
    let tolerance = Tolerance {
        tip: 0.01,
        axis: 0.05f64.to_radians(),
        subdivide: true,
    };

    // An arm between random joints of one branch.
    let (mut walked, mut blocks) = (0, 0);
    for _ in 0..120 {
        let mut joints = || {
            let degrees = [
                random.within(-60.0, 60.0),
                random.within(-110.0, -50.0),
                random.within(-20.0, 60.0),
                random.within(-60.0, 60.0),
                random.within(25.0, 100.0),
                random.within(-90.0, 90.0),
            ];
            Joints(degrees.map(f64::to_radians))
        };
        let (a, b) = (joints(), joints());
        let arm = Arm::<f64>::er3b();
        let guide = OneBranch {
            arm,
            branch: arm.branch_of(&a),
            tool: Pose {
                rotation: Rotation::about(Vector::Y, 0.3),
                p: Vector::new(10.0, -20.0, 110.0),
            },
            work: Pose {
                rotation: Rotation::about(Vector::Z, 0.2),
                p: Vector::new(300.0, 20.0, 100.0),
            },
            speeds: None,
        };
        if guide.branch != arm.branch_of(&b) {
            continue;
        }
        let ends = [guide.forward(&a), guide.forward(&b)];
        let set = ArmSet {
            q: a,
            pose: ends[0],
        };
        let found = strayed(&guide, &ends, set, tolerance, |q, way: &PoseWay<f64>, u| {
            let (at, wanted) = (guide.forward(q), Course::at(way, u));
            let turn = rotation_vector(at.rotation * wanted.rotation.transposed());
            ((at.p - wanted.p).norm(), turn.norm())
        });
        if let Some((tip, angle, count)) = found {
            assert!(
                tip <= tolerance.tip && angle <= tolerance.axis,
                "{tip} mm, {angle} rad"
            );
            walked += 1;
            blocks += count;
        }
    }
    assert!(
        walked > 30 && blocks > 1000,
        "{walked} moves, {blocks} blocks"
    );

    // A chain with a table that turns, a quill and a head.
    let along = |carries, axis| Joint::linear(carries, axis).unwrap();
    let about = |carries, axis, z| {
        let at = Vector::new(0.0, 0.0, z);
        Joint::rotary(carries, axis, at, 0.0).unwrap()
    };
    let chain = Chain::<5, f64>::new([
        along(Carries::Work, Vector::X),
        about(Carries::Work, Vector::Y, -100.0),
        along(Carries::Tool, Vector::Y),
        about(Carries::Tool, Vector::X, 300.0),
        along(Carries::Tool, Vector::Z),
    ]);
    let guide = Paced {
        machine: chain,
        speeds: None,
    };
    let (mut walked, mut blocks) = (0, 0);
    for _ in 0..60 {
        let mut cl = || {
            let p = Vector::new(
                random.within(-80.0, 80.0),
                random.within(-80.0, 80.0),
                random.within(-40.0, 40.0),
            );
            let v = Vector::new(random.within(-0.5, 0.5), random.within(-0.5, 0.5), 1.0);
            ClPoint::new(p, v).unwrap()
        };
        let ends = [cl(), cl(), cl()];
        let target = inverse::Target::TipAxis {
            p: ends[0].p(),
            o: ends[0].v(),
        };
        let q = chain.inverse(&target, &Joints::default(), &inverse::Tolerance::default());
        let set = ChainSet {
            q: q.expect("within reach").q,
            at: ends[0],
            singular: false,
        };
        let found = strayed(&guide, &ends, set, tolerance, |q, way: &Way<f64>, u| {
            let ((p, v), wanted) = (chain.tip(q), way.at(u));
            ((p - wanted.p()).norm(), v.angle_to(wanted.v()))
        });
        let (tip, angle, count) = found.expect("nothing stands in the way");
        assert!(
            tip <= tolerance.tip && angle <= tolerance.axis,
            "{tip} mm, {angle} rad"
        );
        walked += 1;
        blocks += count;
    }
    assert!(
        walked == 60 && blocks > 1000,
        "{walked} moves, {blocks} blocks"
    );
}

#[test]
fn in_single_precision_an_arm_follows_the_same_path_within_its_tolerance() {
    let exact = Arm::<f64>::er3b();
    let tool = |p: f64| Vector::new(0.0, 0.0, p);
    let start = Joints([10.0, -70.0, 10.0, 20.0, 60.0, -30.0f64].map(f64::to_radians));
    let end = Joints([-10.0, -80.0, 25.0, 0.0, 50.0, 10.0f64].map(f64::to_radians));
    let guide = OneBranch {
        arm: Arm::<f32>::er3b(),
        branch: exact.branch_of(&start),
        tool: Pose {
            rotation: Rotation::IDENTITY,
            p: Vector::new(0.0f32, 0.0, 110.0),
        },
        work: Pose::IDENTITY,
        speeds: Some(Joints([1.0f32; 6])),
    };
    let narrow = |q: &Joints<6, f64>| Joints(q.0.map(|q| q as f32));
    let ends = [guide.forward(&narrow(&start)), guide.forward(&narrow(&end))];
    let set = ArmSet {
        q: narrow(&start),
        pose: ends[0],
    };
    let tolerance = Tolerance {
        tip: 0.05f32,
        axis: 0.002,
        subdivide: true,
    };
    let mut follower = Follower::new(&guide, tolerance, ends[0], set).unwrap();
    assert!(follower.push(ends[1], None, Feed::Tip(20.0)).unwrap());
    let mut from = start;
    let way = {
        let flange = |q| {
            let pose = exact.forward(q);
            Pose {
                p: pose.apply(tool(110.0)),
                ..pose
            }
        };
        PoseWay::new(flange(&start), flange(&end)).unwrap()
    };
    let (mut u0, mut count) = (0.0, 0);
    while let Some(block) = follower.next_block() {
        let to = Joints(block.joints.0.map(f64::from));
        let u1 = f64::from(block.u);
        for k in 0..=20 {
            let part = f64::from(k) / 20.0;
            let q = from.zip_map(&to, |a, b| a + (b - a) * part);
            let tip = exact.forward(&q).apply(tool(110.0));
            let wanted = Course::at(&way, u0 + (u1 - u0) * part).p;
            assert!((tip - wanted).norm() < 0.051, "{}", (tip - wanted).norm());
        }
        assert!(!block.flags.coarse && block.duration > 0.0);
        (from, u0, count) = (to, u1, count + 1);
    }
    assert!(count > 3);
    let off = from.zip_map(&end, |a, b| (a - b).abs());
    assert!(off.0.iter().all(|q| *q < 1e-5), "{off:?}");
}

#[test]
fn the_measure_sees_what_is_wrong_with_the_pulses() {
    // A machine whose head is 0.1 mm longer than the one that was solved for misses its path, and the measure says so.
    let (job, _) = plan(CHAIN).unwrap();
    let outcome = run_job(&job);
    let start = outcome.poses.as_ref().unwrap().start;
    let mut other = poses(&job).clone();
    let good = Measured::of(&other, &outcome.trace, start);
    if let Forward::Serial(serial) = &mut other.machine.forward {
        serial.tip[2] += 0.1;
    }

    let bad = Measured::of(&other, &outcome.trace, start);

    assert!(good.tip < 0.012, "{} mm", good.tip);
    assert!((0.09..0.13).contains(&bad.tip), "{} mm", bad.tip);
}
