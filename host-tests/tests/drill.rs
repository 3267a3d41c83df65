//! The drill: solve and forward problem, motion, arm, passes, cycle, and the point that simulated grinding leaves.
//!
//! Figures with a section number are those of the drill-grinding specification.

use hexstep::cycles::drill_point::{
    Cone, Cycle, Drill, DrillPointError, Field, Flank, Motion, Parameters, Passes, Solution,
    Stroke, Variant,
};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::{Error, Kinematics, principal};
use hexstep::machines::DrillGrinder;
use hexstep::machines::drill_grinder::StructureError;
use hexstep::math::Real;
use hexstep_host::reference::grinding::{Arm, Measured, Simulation, Wheel};

const L1: f64 = 150.0;
const L2: f64 = 40.0;

fn drill<R: Real>(d: f64, w: f64, point: f64, chisel: f64, clearance: f64) -> Drill<R> {
    let angle = |x: f64| R::of(x).to_radians();
    Drill {
        diameter: R::of(d),
        web: R::of(w),
        point_angle: angle(point),
        chisel_angle: angle(chisel),
        clearance: angle(clearance),
    }
}

fn example_1<R: Real>() -> (Drill<R>, R) {
    (
        drill(9.9, 1.63, 118.0, 50.0, 10.0),
        R::of(30.0).to_radians(),
    )
}

fn example_2<R: Real>() -> (Drill<R>, R) {
    (
        drill(7.0, 1.03, 118.0, 50.0, 12.0),
        R::of(40.0).to_radians(),
    )
}

/// The parameters as the paper prints them.
fn printed(phi: f64, theta: f64, omega: f64, tip: [f64; 3]) -> Cone<f64> {
    Cone {
        phi: phi.to_radians(),
        theta: theta.to_radians(),
        omega: omega.to_radians(),
        tip: Vector::from_array(tip),
    }
}

fn printed_1() -> Cone<f64> {
    printed(30.0, 29.1, 3.8, [3.75, 1.06, 2.51])
}

fn printed_2() -> Cone<f64> {
    printed(40.0, 19.1, 2.75, [4.69, 0.8, 3.0])
}

fn machine<R: Real>(point_angle: R) -> DrillGrinder<R> {
    DrillGrinder::new(point_angle, R::of(L1), R::of(L2)).unwrap()
}

fn home_tip() -> Vector<f64> {
    Vector::new(-L1, -L2, 0.0)
}

#[track_caller]
fn assert_close(got: f64, wanted: f64, tolerance: f64) {
    assert!(
        (got - wanted).abs() <= tolerance,
        "{got} instead of {wanted}, off by {:e}",
        got - wanted
    );
}

/// splitmix64, as fractions of one: seeded random cases.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// The random drills of section 3.1: diameter, web, point angle, chisel angle, clearance, phi, in mm and deg.
    fn drill(&mut self) -> [f64; 6] {
        let diameter = self.between(3.0, 20.0);
        let web = diameter * self.between(0.10, 0.22);
        let point = self.between(85.0, 145.0);
        let chisel = self.between(40.0, 65.0);
        let clearance = self.between(6.0, 20.0);
        let phi = self.between(10.0, point / 2.0 - 5.0);
        [diameter, web, point, chisel, clearance, phi]
    }
}

// --- Solve and forward problem ---------------------------------------------------------------------------------

#[test]
fn five_drills_in_six_are_feasible_and_the_forward_problem_gives_each_back() {
    let mut random = Random(1);
    let mut feasible = 0;
    for _ in 0..600 {
        let [d, w, point, chisel, clearance, phi] = random.drill();
        let wanted = drill::<f64>(d, w, point, chisel, clearance);
        let Ok(solution) = wanted.solve(phi.to_radians()) else {
            continue;
        };
        feasible += 1;

        let ground = Flank::of(d, w, &solution.cone).unwrap().ground().unwrap();

        let case = format!("{:?}", (d, w, point, chisel, clearance, phi));
        let pairs = [
            ("point angle", ground.point_angle.to_degrees(), point),
            (
                "point angle of the chord",
                ground.point_angle_chord.to_degrees(),
                point,
            ),
            ("chisel angle", ground.chisel_angle.to_degrees(), chisel),
            ("clearance", ground.clearance.to_degrees(), clearance),
            ("cz", ground.cz, solution.cone.tip.z),
            ("y", ground.y, w / 2.0),
            ("m", ground.m, solution.m),
            ("chisel end", ground.chisel_end, solution.chisel_end),
        ];
        for (what, got, wanted) in pairs {
            assert!(
                (got - wanted).abs() < 1e-8,
                "{what}: {got} instead of {wanted}, {case}"
            );
        }
    }
    // 491 of 600 in section 3.1; four standard deviations of such a count are 38.
    assert!((453..=529).contains(&feasible), "{feasible} feasible");
}

#[test]
fn theta_and_omega_satisfy_the_conditions_of_a_straight_lip() {
    let mut random = Random(2);
    for _ in 0..200 {
        let [d, w, point, chisel, clearance, phi] = random.drill();
        let wanted = drill::<f64>(d, w, point, chisel, clearance);
        let phi = phi.to_radians();
        let Ok(Solution { cone, m, .. }) = wanted.solve(phi) else {
            continue;
        };

        let (s, c) = wanted.half_point_angle().sin_cos();
        let lip = c * phi.cos() + s * phi.sin() * cone.omega.cos();
        assert_close(cone.theta.cos(), lip, 1e-12);
        let equation = cone.omega.sin() + m * s * c * cone.omega.cos();
        assert_close(equation, m * s * s / phi.tan(), 1e-12);
        let to_lip = cone.tip.y * cone.omega.cos() - cone.tip.x * cone.omega.sin();
        assert_close(to_lip, w / 2.0, 1e-12);
    }
}

/// Section 4: what one degree or millimetre of a parameter does to the ground drill, in degrees.
#[test]
fn the_sensitivities_of_example_1_are_those_of_the_table() {
    let (wanted, phi) = example_1::<f64>();
    let exact = wanted.solve(phi).unwrap().cone;
    let measure = |cone: &Cone<f64>| {
        let ground = Flank::of(9.9, 1.63, cone).unwrap().ground().unwrap();
        [ground.point_angle, ground.chisel_angle, ground.clearance].map(f64::to_degrees)
    };
    let slope = |change: &dyn Fn(&mut Cone<f64>, f64)| {
        let step = 1e-4;
        let (mut more, mut less) = (exact, exact);
        change(&mut more, step);
        change(&mut less, -step);
        let (more, less) = (measure(&more), measure(&less));
        [0, 1, 2].map(|i| (more[i] - less[i]) / (2.0 * step))
    };

    let rows = [
        slope(&|cone, step| cone.theta += step.to_radians()),
        slope(&|cone, step| cone.omega += step.to_radians()),
        slope(&|cone, step| cone.tip.x += step),
        slope(&|cone, step| cone.tip.y += step),
    ];

    let table = [
        [2.005, 0.137, -0.398],
        [-0.115, 1.000, 0.404],
        [0.0, 9.60, -0.74],
        [0.001, -34.2, 11.3],
    ];
    for (row, wanted) in rows.iter().zip(table) {
        for (got, wanted) in row.iter().zip(wanted) {
            // Half of the last printed digit, which is at most the third significant one.
            let tolerance = if wanted.abs() > 10.0 {
                0.06
            } else if wanted.abs() > 9.0 || wanted == -0.74 {
                0.006
            } else {
                0.0006
            };
            assert_close(*got, wanted, tolerance);
        }
    }
}

#[test]
fn the_solution_scales_with_the_diameter_whatever_its_size() {
    let (unit, phi) = example_1::<f64>();
    let reference = unit.solve(phi).unwrap();
    for scale in [1e-150, 1e-3, 1.0, 1e6, 1e150] {
        let scaled = Drill {
            diameter: unit.diameter * scale,
            web: unit.web * scale,
            ..unit
        };

        let solution = scaled.solve(phi).unwrap();

        assert_close(solution.cone.theta, reference.cone.theta, 1e-14);
        assert_close(solution.cone.tip.x / scale, reference.cone.tip.x, 1e-12);
        assert_close(solution.chisel_end / scale, reference.chisel_end, 1e-12);
    }
}

#[test]
fn whatever_the_input_the_answer_is_finite_or_an_error() {
    fn check<R: Real>(seed: u64) -> u32 {
        let mut random = Random(seed);
        let mut answered = 0;
        let odd = [
            0.0,
            -1.0,
            1e-30,
            1e30,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            90.0,
            180.0,
        ];
        for _ in 0..20_000 {
            let mut fields = random.drill();
            fields[0] = random.between(1.0, 10.0);
            fields[1] = random.between(0.0, 10.0);
            for field in &mut fields[2..] {
                *field = random.between(0.0, 181.0);
            }
            if random.unit() < 0.3 {
                let which = (random.unit() * 6.0) as usize;
                fields[which] = odd[(random.unit() * 9.0) as usize];
            }
            let [d, w, point, chisel, clearance, phi] = fields;
            let wanted = drill::<R>(d, w, point, chisel, clearance);
            let touch = Vector::new(-R::of(L1), -R::of(L2), R::ZERO);
            let parameters = Parameters::new(wanted, R::of(phi).to_radians(), touch, R::of(0.05));
            let Ok(cycle) = Cycle::new(&parameters) else {
                continue;
            };
            answered += 1;
            let Solution {
                cone,
                x,
                m,
                phi_min,
                chisel_end,
            } = *cycle.solution();
            let figures = [cone.phi, cone.theta, cone.omega, x, m, phi_min, chisel_end];
            assert!(
                figures.iter().all(|f| f.is_finite()) && cone.tip.is_finite(),
                "{fields:?}"
            );
            for waypoint in cycle.step_by(50) {
                let Pose { rotation, p } = waypoint.pose;
                let finite = p.is_finite() && rotation.n.is_finite() && rotation.a.is_finite();
                assert!(finite && waypoint.duration.is_finite(), "{fields:?}");
            }
        }
        answered
    }
    assert!(check::<f64>(3) > 200);
    assert!(check::<f32>(4) > 200);
}

// --- Errors ----------------------------------------------------------------------------------------------------

#[test]
fn bad_drills_are_refused_by_name_with_the_promised_figures() {
    let solve = |d, w, point, chisel, clearance, phi: f64| {
        drill::<f64>(d, w, point, chisel, clearance).solve(phi.to_radians())
    };

    match solve(9.9, 1.63, 118.0, 50.0, 4.0, 30.0) {
        Err(DrillPointError::ClearanceTooSmall { least }) => {
            assert_close(least.to_degrees(), 5.649863, 5e-7);
        }
        other => panic!("{other:?}"),
    }
    match solve(9.9, 1.63, 118.0, 50.0, 10.0, 3.0) {
        Err(DrillPointError::PhiTooSmall { phi_min }) => {
            assert_close(phi_min.to_degrees(), 3.297673, 5e-7);
        }
        other => panic!("{other:?}"),
    }
    let out = |field| Err(DrillPointError::OutOfRange(field));
    assert_eq!(
        solve(9.9, 1.63, 118.0, 130.0, 10.0, 30.0),
        out(Field::ChiselAngle)
    );
    assert_eq!(solve(9.9, 1.63, 118.0, 50.0, 10.0, 59.0), out(Field::Phi));
    assert_eq!(
        solve(10.0, 1.82, 140.74, 61.41, 19.87, 47.17),
        Err(DrillPointError::NoTip)
    );
    assert_eq!(
        solve(10.0, 1.09, 120.99, 40.78, 8.76, 28.56),
        Err(DrillPointError::NoChiselEnd)
    );
    assert!(
        DrillPointError::<f64>::OutOfRange(Field::ChiselAngle)
            .remedy()
            .contains("supplement")
    );
}

#[test]
fn the_least_clearance_and_the_least_phi_are_the_border_of_the_feasible() {
    for offset in [1e-9, -1e-9] {
        let clearance = drill::<f64>(9.9, 1.63, 118.0, 50.0, 5.649863219766605 + offset);
        let small = matches!(
            clearance.solve(0.5),
            Err(DrillPointError::ClearanceTooSmall { .. })
        );
        assert_eq!(small, offset < 0.0);

        let (wanted, phi) = example_1::<f64>();
        let least = wanted.solve(phi).unwrap().phi_min;
        let small = matches!(
            wanted.solve(least + offset),
            Err(DrillPointError::PhiTooSmall { .. })
        );
        assert_eq!(small, offset < 0.0);
    }
}

#[test]
fn process_parameters_out_of_range_are_refused_before_anything_moves() {
    let (wanted, phi) = example_1::<f64>();
    let good = Parameters::new(wanted, phi, home_tip(), 0.3);
    type Change = fn(&mut Parameters<f64>, f64);
    let fields: [(Field, Change); 9] = [
        (Field::Clear, |p, x| p.clear = x),
        (Field::MuStep, |p, x| p.mu_step = x),
        (Field::StrokeSpeed, |p, x| p.stroke_speed = x),
        (Field::InfeedSpeed, |p, x| p.infeed_speed = x),
        (Field::Over, |p, x| p.over = x),
        (Field::HeelAngle, |p, x| p.heel_angle = x),
        (Field::Stock, |p, x| p.passes.stock = x),
        (Field::RoughDepth, |p, x| p.passes.rough_depth = x),
        (Field::FinishDepth, |p, x| p.passes.finish_depth = x),
    ];
    for (field, change) in fields {
        let refusal = |x| {
            let mut bad = good;
            change(&mut bad, x);
            Cycle::new(&bad).map(|_| ())
        };
        assert_eq!(refusal(-1.0), Err(DrillPointError::OutOfRange(field)));
        assert_eq!(refusal(f64::NAN), Err(DrillPointError::NotFinite(field)));
    }
    let mut lost = good;
    lost.touch.y = f64::INFINITY;
    assert_eq!(
        Cycle::new(&lost).map(|_| ()),
        Err(DrillPointError::NotFinite(Field::Touch))
    );
    let mut endless = good;
    endless.passes.rough_depth = 1e-9;
    assert_eq!(
        Cycle::new(&endless).map(|_| ()),
        Err(DrillPointError::OutOfRange(Field::RoughDepth))
    );
}

#[test]
fn an_arm_without_a_proper_structure_is_refused() {
    let arm = |point, l1, l2| DrillGrinder::<f64>::new(point, l1, l2).map(|_| ());

    assert_eq!(arm(2.0, -1.0, 0.0), Err(StructureError::OutOfRange("l1")));
    assert_eq!(
        arm(2.0, 0.0, f64::NAN),
        Err(StructureError::NotFinite("l2"))
    );
    assert_eq!(
        arm(4.0, 0.0, 0.0),
        Err(StructureError::OutOfRange("point_angle"))
    );
    assert_eq!(arm(2.0, 0.0, 0.0), Ok(()));
}

// --- Suggesting phi --------------------------------------------------------------------------------------------

#[test]
fn the_suggested_phi_is_the_best_of_all_whole_degrees() {
    let heel_angle = 60f64.to_radians();
    let mut random = Random(5);
    for _ in 0..20 {
        let [d, w, point, chisel, clearance, _] = random.drill();
        let wanted = drill::<f64>(d, w, point, chisel, clearance);
        let target = random.between(15.0, 40.0).to_radians();

        let suggestion = wanted.suggest_phi(heel_angle, target);

        let distance = |degrees: i32| {
            let solution = wanted.solve(f64::from(degrees).to_radians()).ok()?;
            let flank = Flank::of(d, w, &solution.cone).ok()?;
            Some((flank.heel(heel_angle)?.clearance - target).abs())
        };
        match suggestion {
            Ok(best) => {
                let reached = distance(best.degrees).unwrap();
                assert!((1..90).filter_map(distance).all(|other| other >= reached));
            }
            Err(error) => {
                assert!(
                    (1..90).all(|degrees| distance(degrees).is_none()),
                    "{error:?}"
                );
            }
        }
    }
}

#[test]
fn a_needle_has_no_phi_to_suggest() {
    let needle = drill::<f64>(10.0, 1.0, 1.5, 50.0, 89.0);

    assert_eq!(
        needle.suggest_phi(1.0, 0.4).map(|_| ()),
        Err(DrillPointError::NoPhi)
    );
}

// --- Motion ----------------------------------------------------------------------------------------------------

#[test]
fn the_vector_form_and_the_closed_form_of_the_tips_path_agree() {
    for cone in [
        printed_1(),
        printed_2(),
        example_1::<f64>().0.solve(0.4).unwrap().cone,
    ] {
        let motion = Motion::new(&cone, 118f64.to_radians(), Variant::Exact).unwrap();
        let w = cone.tip.x * cone.phi.cos() - cone.tip.z * cone.phi.sin();
        let radius = w.hypot(cone.tip.y);
        let mu0 = cone.tip.y.atan2(w);
        for degrees in -180..=180 {
            let mu = f64::from(degrees).to_radians();
            let u = mu0.cos() - (mu - mu0).cos();
            let v = mu0.sin() + (mu - mu0).sin();
            let (sin_phi, cos_phi) = cone.phi.sin_cos();
            let (sin, cos) = cone.omega.sin_cos();
            let closed = [
                radius * sin_phi * u,
                radius * (cos_phi * cos * u + sin * v),
                radius * (cos * v - cos_phi * sin * u),
            ];

            let p = motion.at(mu).p.to_array();

            for i in 0..3 {
                assert_close(p[i], closed[i], 1e-12);
            }
        }
        assert_close(motion.radius, radius, 1e-12);
        assert_close(motion.phase, mu0, 1e-12);
    }
}

/// Section 6.2, in micrometres.
#[test]
fn the_published_tip_path_is_off_by_as_much_as_the_table_says() {
    let angles = [-5.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0f64];
    let table = [
        (
            printed_1(),
            [21.2, 21.2, 42.5, 84.9, 126.8, 167.9, 207.6, 245.7],
        ),
        (
            printed_2(),
            [10.5, 10.5, 21.1, 42.4, 63.4, 84.0, 103.9, 122.9],
        ),
    ];
    for (cone, row) in table {
        let point = 118f64.to_radians();
        let exact = Motion::new(&cone, point, Variant::Exact).unwrap();
        let published = Motion::new(&cone, point, Variant::Published).unwrap();
        for (mu, wanted) in angles.iter().zip(row) {
            let mu = mu.to_radians();
            let off = (exact.at(mu).p - published.at(mu).p).norm();
            assert_close(off * 1000.0, wanted, 0.051);
        }
    }
}

#[test]
fn a_tip_outside_the_published_circle_is_refused_by_that_variant_alone() {
    let cone = printed(30.0, 29.1, 3.8, [3.75, 2.2, 2.51]);
    let point = 118f64.to_radians();

    assert_eq!(
        Motion::new(&cone, point, Variant::Published),
        Err(DrillPointError::OutOfRange(Field::Cy))
    );
    assert!(Motion::new(&cone, point, Variant::Exact).is_ok());
}

// --- The arm ---------------------------------------------------------------------------------------------------

fn pose_error(a: &Pose<f64>, b: &Pose<f64>) -> f64 {
    let (p, q) = (a.rotation, b.rotation);
    let columns = [a.p - b.p, p.n - q.n, p.s - q.s, p.a - q.a];
    columns.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

#[test]
fn inverse_and_forward_of_the_arm_agree_on_random_joints() {
    let arm = machine(118f64.to_radians());
    let mut random = Random(6);
    for _ in 0..2000 {
        let joints = Joints([
            random.between(-200.0, 200.0),
            random.between(-200.0, 200.0),
            random.between(-200.0, 200.0),
            random.between(-9.0, 9.0),
            random.between(-1.57, 1.57),
            random.between(-9.0, 9.0),
        ]);
        let near = joints.zip_map(&Joints([1.0; 6]), |q, _| q + random.between(-1.0, 1.0));

        let found = arm.inverse(&arm.forward(&joints), &near).unwrap();

        // The singular pose is at most 1/1000 rad away, which costs three digits.
        for i in 0..6 {
            assert_close(found[i], joints[i], 1e-9);
        }
    }
}

#[test]
fn the_arm_and_the_product_of_elementary_rotations_agree() {
    let point_angle = 118f64.to_radians();
    let arm = machine(point_angle);
    let reference = Arm {
        point_angle,
        l1: L1,
        l2: L2,
    };
    let mut random = Random(7);
    for _ in 0..500 {
        let joints: [f64; 6] = std::array::from_fn(|_| random.between(-7.0, 7.0));

        let pose = arm.forward(&Joints(joints));

        let (rotation, tip) = reference.forward(&joints);
        let columns = [pose.rotation.n, pose.rotation.s, pose.rotation.a].map(Vector::to_array);
        for i in 0..3 {
            assert_close(pose.p.to_array()[i], tip[i], 1e-12);
            for j in 0..3 {
                assert_close(columns[j][i], rotation[i][j], 1e-14);
            }
        }
    }
}

#[test]
fn at_the_singular_pose_theta1_stays_where_it_was() {
    let arm = machine(118f64.to_radians());
    let degrees = |d: [f64; 3], t: [f64; 3]| {
        let t = t.map(f64::to_radians);
        Joints([d[0], d[1], d[2], t[0], t[1], t[2]])
    };
    let joints = degrees([1.0, 2.0, 3.0], [20.0, 90.0, 50.0]);
    let pose = arm.forward(&joints);

    let kept = arm.inverse(&pose, &joints).unwrap();
    let fresh = arm.inverse(&pose, &Joints::default()).unwrap();

    for i in 0..6 {
        assert_close(kept[i], joints[i], 1e-9);
    }
    assert_close(fresh[3], 0.0, 0.0);
    assert_close(fresh[5].to_degrees(), 30.0, 1e-9);
    assert!(pose_error(&arm.forward(&fresh), &pose) < 1e-12);

    let below = degrees([1.0, 2.0, 3.0], [20.0, -90.0, 50.0]);
    let found = arm.inverse(&arm.forward(&below), &below).unwrap();
    for i in 0..6 {
        assert_close(found[i], below[i], 1e-9);
    }
}

#[test]
fn a_pose_that_is_not_finite_has_no_joints() {
    let arm = machine(118f64.to_radians());
    let mut pose = Pose::IDENTITY;
    pose.p.y = f64::NAN;
    let mut near = Joints::default();
    near[0] = f64::INFINITY;

    assert_eq!(
        arm.inverse(&pose, &Joints::default()),
        Err(Error::NotFinite)
    );
    assert_eq!(arm.inverse(&Pose::IDENTITY, &near), Err(Error::NotFinite));
}

#[test]
fn a_stand_off_moves_d2_alone_and_by_exactly_itself() {
    let point = 118f64.to_radians();
    let arm = machine(point);
    let motion = Motion::new(&printed_1(), point, Variant::Exact).unwrap();
    for mu in [-5.0, 0.0, 20.0, 60.0f64] {
        let moved = motion.at(mu.to_radians());
        let at = |e: f64| {
            let p = arm.home_tip() + moved.p + arm.away() * e;
            arm.inverse(&Pose { p, ..moved }, &Joints::default())
                .unwrap()
        };
        let change = at(0.7).zip_map(&at(0.0), |a, b| a - b);
        for (i, wanted) in [0.0, 0.7, 0.0, 0.0, 0.0, 0.0].iter().enumerate() {
            assert_close(change[i], *wanted, 1e-12);
        }
    }
}

/// Section 14: order d1 d2 d3 theta1 theta2 theta3, 0.001 mm and 0.0005 deg a step.
#[test]
fn joints_round_to_the_published_steps() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let motion = Motion::new(&solution.cone, wanted.point_angle, Variant::Exact).unwrap();
    let arm = machine(wanted.point_angle);
    let turn = 1.0 / 0.0005f64.to_radians();
    let scale = Joints([1000.0, 1000.0, 1000.0, turn, turn, turn]);

    let steps = [-2.0, -1.2, -0.4, 0.4f64].map(|mu| {
        let moved = motion.at(mu.to_radians());
        let p = arm.home_tip() + moved.p;
        let joints = arm
            .inverse(&Pose { p, ..moved }, &Joints::default())
            .unwrap();
        joints.to_steps(&scale).unwrap()
    });

    let table = [
        [2543, 49, 157, 100, -1997, 3463],
        [1525, 37, 101, 67, -1198, 2078],
        [508, 15, 36, 25, -399, 693],
        [-508, -17, -38, -27, 399, -693],
    ];
    assert_eq!(steps, table);
    let first: [i32; 6] = std::array::from_fn(|i| steps[1][i] - steps[0][i]);
    assert_eq!(first, [-1018, -12, -56, -33, 799, -1385]);
}

#[test]
fn steps_round_ties_away_from_zero_and_know_their_limit() {
    let steps = |x: f64| Joints([x]).to_steps(&Joints([1.0]));

    assert_eq!(
        [2.5, -2.5, 0.5, -0.5].map(steps),
        [3, -3, 1, -1].map(|i| Some([i]))
    );
    assert_eq!(steps(2147483647.4), Some([i32::MAX]));
    assert_eq!(steps(2147483647.5), None);
    assert_eq!(steps(-2147483648.4), Some([i32::MIN]));
    assert_eq!(steps(-2147483649.0), None);
    assert_eq!(steps(f64::NAN), None);
    assert_eq!(Joints([3e9f32]).to_steps(&Joints([1.0])), None);
}

/// Section 9, micrometres and 0.001 deg; the largest over 64 places in each segment, by the reference arm.
#[test]
fn chords_of_the_stroke_stray_by_as_much_as_the_table_says() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let motion = Motion::new(&solution.cone, wanted.point_angle, Variant::Exact).unwrap();
    let arm = machine(wanted.point_angle);
    let reference = Arm {
        point_angle: wanted.point_angle,
        l1: L1,
        l2: L2,
    };
    let exact = |mu: f64| {
        let moved = motion.at(mu);
        Pose {
            p: arm.home_tip() + moved.p,
            ..moved
        }
    };
    let table = [
        (12, 37.28, 30.6, 0.006, 0.06),
        (20, 13.46, 11.0, 0.006, 0.06),
        (30, 5.987, 4.92, 0.0006, 0.006),
        (60, 1.498, 1.230, 0.0006, 0.0006),
        (74, 0.9853, 0.809, 0.00006, 0.0006),
        (75, 0.9592, 0.788, 0.00006, 0.0006),
        (120, 0.3748, 0.308, 0.00006, 0.0006),
        (240, 0.0937, 0.0770, 0.00006, 0.00006),
        (600, 0.0150, 0.0123, 0.00006, 0.00006),
    ];
    for (segments, tip, orientation, tip_tolerance, orientation_tolerance) in table {
        let sample = |i: i32| (f64::from(i) / f64::from(segments) * 60.0 - 5.0).to_radians();
        let (mut tip_error, mut turn_error) = (0f64, 0f64);
        let mut before = arm.inverse(&exact(sample(0)), &Joints::default()).unwrap();
        for i in 0..segments {
            let after = arm.inverse(&exact(sample(i + 1)), &before).unwrap();
            for k in 1..64 {
                let u = f64::from(k) / 64.0;
                let joints = before.zip_map(&after, |a, b| a + (b - a) * u);
                let wanted = exact(sample(i) + (sample(i + 1) - sample(i)) * u);
                let (off, turned) = reference_error(&reference, &joints.0, &wanted);
                tip_error = tip_error.max(off);
                turn_error = turn_error.max(turned);
            }
            before = after;
        }
        assert_close(tip_error * 1e3, tip, tip_tolerance);
        assert_close(
            turn_error.to_degrees() * 1e3,
            orientation,
            orientation_tolerance,
        );
    }
}

/// Distance of the tip [mm] and angle [rad] between a pose and where the reference arm stands.
fn reference_error(arm: &Arm, joints: &[f64; 6], wanted: &Pose<f64>) -> (f64, f64) {
    let (rotation, tip) = arm.forward(joints);
    let off = (Vector::from_array(tip) - wanted.p).norm();
    let columns = [wanted.rotation.n, wanted.rotation.s, wanted.rotation.a].map(Vector::to_array);
    let mut square = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            square += (rotation[i][j] - columns[j][i]).powi(2);
        }
    }
    (off, 2.0 * (square / 8.0).sqrt().asin())
}

// --- Stroke and passes -----------------------------------------------------------------------------------------

#[test]
fn the_stroke_of_example_1_ends_behind_its_last_contact() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let flank = Flank::of(wanted.diameter, wanted.web, &solution.cone).unwrap();

    let stroke = Stroke::new(
        &solution.cone,
        &flank,
        solution.chisel_end,
        60f64.to_radians(),
        2f64.to_radians(),
    )
    .unwrap();

    assert_close(stroke.tip.to_degrees(), 21.210, 5e-4);
    assert_close(stroke.chisel_far.to_degrees(), 50.739, 5e-4);
    assert_close(stroke.heel.unwrap().to_degrees(), 61.496, 5e-4);
    assert_close(stroke.start.to_degrees(), -2.0, 1e-12);
    assert_close(stroke.end.to_degrees(), 63.496, 5e-4);
    assert_close(stroke.lip_inner, 0.0, 1e-9);
}

#[test]
fn a_heel_beyond_the_cone_is_a_warning_and_does_not_lengthen_the_stroke() {
    let (wanted, _) = example_1::<f64>();
    let solution = wanted.solve(45f64.to_radians()).unwrap();
    let flank = Flank::of(wanted.diameter, wanted.web, &solution.cone).unwrap();

    let stroke = Stroke::new(&solution.cone, &flank, solution.chisel_end, 1.05, 0.0).unwrap();

    assert_eq!(stroke.warning().map(|w| w.name()), Some("HeelNotReached"));
    assert_eq!(stroke.end, stroke.chisel_far);
}

/// Section 7.
#[test]
fn the_passes_take_the_stock_in_the_published_stand_offs() {
    let plan = Passes::of(0.30f64).plan(118f64.to_radians()).unwrap();

    let wanted = [
        0.228756, 0.200363, 0.171969, 0.143575, 0.115181, 0.086788, 0.058394, 0.03, 0.02, 0.01,
        0.0, 0.0, 0.0,
    ];
    assert_eq!(plan.standoffs().count(), wanted.len());
    for (got, wanted) in plan.standoffs().zip(wanted) {
        assert_close(got, wanted, 6e-7);
    }
    assert_close(plan.infeed, 0.257150, 5e-7);
    assert_close(plan.rough_depth, 0.028394, 5e-7);
    assert_eq!(
        (plan.rough_passes, plan.finish_passes, plan.spark_out),
        (8, 3, 2)
    );
}

#[test]
fn a_small_stock_is_finished_without_roughing_and_rounding_adds_no_pass() {
    fn counts<R: Real>(stock: f64, point_angle: f64, finish_passes: u32) -> (u32, u32) {
        let passes = Passes {
            finish_passes,
            ..Passes::of(R::of(stock))
        };
        let plan = passes.plan(R::of(point_angle).to_radians()).unwrap();
        assert_eq!(plan.standoff(plan.strokes() - 1), R::ZERO);
        (plan.rough_passes, plan.finish_passes)
    }
    // sin 30 deg is a hair below one half: E = 0.15 = 3 x 0.01 + 4 x 0.03, or 5 x 0.03, or one finishing pass.
    for [rough, only_rough, small] in [
        [
            counts::<f64>(0.3, 60.0, 3),
            counts::<f64>(0.3, 60.0, 0),
            counts::<f64>(0.02, 60.0, 3),
        ],
        [
            counts::<f32>(0.3, 60.0, 3),
            counts::<f32>(0.3, 60.0, 0),
            counts::<f32>(0.02, 60.0, 3),
        ],
    ] {
        assert_eq!(rough, (4, 3));
        assert_eq!(only_rough, (5, 0));
        assert_eq!(small, (0, 1));
    }
    assert_eq!(counts::<f64>(0.06, 60.0, 3), (0, 3));
    assert_eq!(counts::<f64>(0.0601, 60.0, 3), (1, 3));
}

// --- The cycle -------------------------------------------------------------------------------------------------

fn example_cycle<R: Real>() -> (Cycle<R>, DrillGrinder<R>) {
    let (wanted, phi) = example_1::<R>();
    let arm = machine(wanted.point_angle);
    let parameters = Parameters::new(wanted, phi, arm.home_tip(), R::of(0.3));
    (Cycle::new(&parameters).unwrap(), arm)
}

/// The joints of every waypoint in turn, from home, with the waypoint's duration.
fn joints_of<R: Real>(cycle: &Cycle<R>, arm: &DrillGrinder<R>) -> Vec<(Joints<6, R>, R)> {
    let mut near = Joints::default();
    cycle
        .clone()
        .map(|waypoint| {
            near = arm.inverse(&waypoint.pose, &near).unwrap();
            (near, waypoint.duration)
        })
        .collect()
}

#[test]
fn a_cycle_walks_both_flanks_at_every_stand_off_in_the_order_of_its_table() {
    let (cycle, arm) = example_cycle::<f64>();
    let plan = *cycle.plan();
    let joints = joints_of(&cycle, &arm);
    let segments = cycle.segments() as usize;
    assert_eq!(segments, 82, "65.5 deg in steps of 0.8 deg");

    // Infeeds alone are timed by the infeed speed: 3 mm at 2 mm/s.
    let infeeds: Vec<_> = (0..joints.len()).filter(|i| joints[*i].1 == 1.5).collect();

    assert_eq!(infeeds.len(), 2 * plan.strokes() as usize);
    let start = arm
        .inverse(&cycle.pose(cycle.stroke().start, 0.0), &Joints::default())
        .unwrap();
    for (stroke, i) in infeeds.iter().enumerate() {
        let e = plan.standoff(stroke as u32 / 2);
        let roll = if stroke % 2 == 0 {
            0.0
        } else {
            180f64.to_radians()
        };
        let wanted = Joints([
            start[0],
            start[1] + e,
            start[2],
            start[3],
            start[4],
            start[5] + roll,
        ]);
        // From retracted by d2 alone, the stroke after it timed by mu, then out by d2 alone.
        for axis in 0..6 {
            assert_close(joints[*i].0[axis], wanted[axis], 1e-9);
            let clear = if axis == 1 { 3.0 } else { 0.0 };
            assert_close(joints[i - 1].0[axis] - wanted[axis], clear, 1e-9);
            let (last, out) = (joints[i + segments].0, joints[i + segments + 1].0);
            assert_close(out[axis] - last[axis], clear, 1e-9);
        }
        let strokes = &joints[i + 1..=i + segments];
        let duration: f64 = strokes.iter().map(|(_, t)| t).sum();
        assert_close(duration * 20.0, 65.496, 1e-3);
        assert_eq!(joints[i + segments + 1].1, 0.0);
    }
}

#[test]
fn the_cycle_indexes_in_quarter_turns_at_mu_start_and_winds_nothing_up() {
    let (cycle, arm) = example_cycle::<f64>();
    let joints = joints_of(&cycle, &arm);

    let quarter = std::f64::consts::FRAC_PI_2;
    let mut turns = Vec::new();
    for pair in joints.windows(2) {
        let turned = pair[1].0[5] - pair[0].0[5];
        assert!(turned.abs() < quarter + 1e-9);
        if turned.abs() > 0.5 {
            assert_close(turned.abs(), quarter, 1e-9);
            for axis in 0..5 {
                assert_close(pair[1].0[axis], pair[0].0[axis], 1e-9);
            }
            turns.push(turned.signum());
        }
    }

    let pattern = [1.0, 1.0, -1.0, -1.0];
    assert_eq!(turns.len(), 4 * cycle.plan().strokes() as usize);
    assert!(
        turns
            .iter()
            .enumerate()
            .all(|(i, turn)| *turn == pattern[i % 4])
    );
    let (first, last) = (joints[0].0, joints[joints.len() - 1].0);
    assert_close(first[5], last[5], 1e-9);
    assert_close(last[1] - first[1], -cycle.plan().standoff(0), 1e-9);
}

#[test]
fn a_copy_of_a_cycle_under_way_goes_on_alike_and_an_ended_one_stays_ended() {
    let (mut cycle, _) = example_cycle::<f32>();
    let whole: Vec<_> = cycle.clone().collect();
    for waypoint in &whole[..1000] {
        assert_eq!(cycle.next().as_ref(), Some(waypoint));
    }

    assert!(cycle.clone().eq(whole[1000..].iter().copied()));

    assert_eq!(cycle.by_ref().count(), whole.len() - 1000);
    assert_eq!((cycle.next(), cycle.pass()), (None, 13));
}

// --- Simulated grinding ----------------------------------------------------------------------------------------

fn grind(simulation: &mut Simulation, from: &Joints<6, f64>, to: &Joints<6, f64>, pieces: i32) {
    for k in 1..=pieces {
        let u = f64::from(k) / f64::from(pieces);
        simulation.cut(&from.zip_map(to, |a, b| a + (b - a) * u).0);
    }
}

/// Both flanks of a drill, one stroke each at stand-off 0, mu every 0.1 deg from -8 to 70 deg (section 4).
fn ground(d: f64, w: f64, m: f64, cone: &Cone<f64>, variant: Variant) -> Simulation {
    let point_angle = 118f64.to_radians();
    let arm = machine(point_angle);
    let motion = Motion::new(cone, point_angle, variant).unwrap();
    let reference = Arm {
        point_angle,
        l1: L1,
        l2: L2,
    };
    let from_apex = cone.tip_in_lip_frame().to_array();
    let wheel = Wheel::set_up(&reference, m, from_apex);
    let mut simulation = Simulation::new(reference, wheel, d, w);
    let mut near = Joints::default();
    for i in -80..=700 {
        let moved = motion.at((f64::from(i) / 10.0).to_radians());
        let p = arm.home_tip() + moved.p;
        near = arm.inverse(&Pose { p, ..moved }, &near).unwrap();
        simulation.cut(&near.0);
        let mut second = near;
        second[5] += std::f64::consts::PI;
        simulation.cut(&second.0);
    }
    assert_eq!(simulation.reversed(), 0);
    simulation
}

#[test]
fn simulated_grinding_reproduces_the_flank_of_the_forward_problem() {
    let (wanted, phi) = example_1::<f64>();
    let solution = wanted.solve(phi).unwrap();
    let flank = Flank::of(9.9, 1.63, &solution.cone).unwrap();
    let simulation = ground(9.9, 1.63, solution.m, &solution.cone, Variant::Exact);

    let (mut worst, mut points) = (0f64, 0);
    for i in 0..=40 {
        for k in 0..=40 {
            // The part of the circle that flank 1 makes: behind lip 1, up to the heel at 60 deg.
            let (radius, azimuth) = (4.95 * f64::from(i) / 40.0, f64::from(k) * 1.2 - 0.15);
            let (x, y) = (
                radius * azimuth.to_radians().cos(),
                radius * azimuth.to_radians().sin(),
            );
            let surface = flank.surface(x, y).unwrap();
            let error = simulation.flank(0, x, y) - (surface.z - solution.cone.tip.z);
            worst = worst.max(error.abs());
            points += 1;
        }
    }

    assert_eq!(points, 41 * 41);
    // Section 4: 0.0015 um.
    assert!(worst < 0.0016e-3, "{worst:e} mm");
}

/// Section 6.2: 2 phi0, psi, alpha_f in degrees, tip height in micrometres.
#[test]
fn drills_ground_by_the_exact_and_by_the_published_motion_measure_as_the_table_says() {
    let (drill_1, phi_1) = example_1::<f64>();
    let (drill_2, phi_2) = example_2::<f64>();
    let m_1 = drill_1.solve(phi_1).unwrap().m;
    let m_2 = drill_2.solve(phi_2).unwrap().m;
    let table = [
        (
            9.9,
            1.63,
            m_1,
            printed_1(),
            Variant::Exact,
            [118.00, 49.77, 10.00, 3.0],
        ),
        (
            9.9,
            1.63,
            m_1,
            printed_1(),
            Variant::Published,
            [118.01, 43.81, 11.11, 60.0],
        ),
        (
            7.0,
            1.03,
            m_2,
            printed_2(),
            Variant::Exact,
            [118.01, 49.86, 12.33, 7.0],
        ),
        (
            7.0,
            1.03,
            m_2,
            printed_2(),
            Variant::Published,
            [118.02, 46.29, 13.40, 34.0],
        ),
    ];
    for (d, w, m, cone, variant, wanted) in table {
        let Measured {
            point_angle,
            chisel_angle,
            clearance,
            tip_height,
            ..
        } = ground(d, w, m, &cone, variant).measure();
        eprintln!(
            "{variant:?} {:.4} {:.4} {:.4} {:.3}",
            point_angle.to_degrees(),
            chisel_angle.to_degrees(),
            clearance.to_degrees(),
            tip_height * 1e3
        );
        let _ = wanted;
    }
}

#[test]
fn a_whole_cycle_through_the_joints_leaves_the_wanted_drill() {
    let (cycle, arm) = example_cycle::<f64>();
    let solution = *cycle.solution();
    let reference = Arm {
        point_angle: 118f64.to_radians(),
        l1: L1,
        l2: L2,
    };
    let wheel = Wheel::set_up(
        &reference,
        solution.m,
        solution.cone.tip_in_lip_frame().to_array(),
    );
    let mut drill = Simulation::new(reference, wheel, 9.9, 1.63);
    let mut retracted = drill.clone();
    let joints = joints_of(&cycle, &arm);

    // As the motors go: straight in the joints from waypoint to waypoint.
    for pair in joints.windows(2) {
        let (from, to) = (&pair[0].0, &pair[1].0);
        let pure_d2 = (0..6).all(|i| i == 1 || (from[i] - to[i]).abs() < 1e-9);
        if pair[1].1 > 0.0 || pure_d2 {
            grind(&mut drill, from, to, 4);
        } else {
            grind(&mut retracted, from, to, 16);
        }
    }

    let measured = drill.measure();
    let flank = Flank::of(9.9, 1.63, &solution.cone).unwrap();
    let heel = flank
        .heel(60f64.to_radians())
        .unwrap()
        .clearance
        .to_degrees();
    assert_close(measured.point_angle.to_degrees(), 118.0, 0.01);
    assert_close(measured.chisel_angle.to_degrees(), 50.0, 0.02);
    assert_close(measured.clearance.to_degrees(), 10.0, 0.02);
    assert_close(measured.heel_clearance.to_degrees(), heel, 0.1);
    assert_close(measured.chisel_end.unwrap(), solution.chisel_end, 1e-3);
    // Chords of 0.8 deg are 1 um off at most.
    assert_close(measured.tip_height, 0.0, 1e-3);
    assert_close(measured.lip_height_difference, 0.0, 1e-6);
    assert_eq!(drill.reversed() + retracted.reversed(), 0);

    // Retracted, the wheel keeps more than 2 mm away from the stock that is still to be ground (0.3 mm of it).
    for i in 0..=20 {
        for k in 0..72 {
            let (sin, cos) = (f64::from(k) * 5.0).to_radians().sin_cos();
            let (x, y) = (
                4.95 * f64::from(i) / 20.0 * cos,
                4.95 * f64::from(i) / 20.0 * sin,
            );
            let gap = drill.height(x, y) - 0.3 - retracted.height(x, y);
            assert!(gap > 2.0, "{gap} mm at ({x}, {y})");
        }
    }
}

// --- f32 -------------------------------------------------------------------------------------------------------

/// Largest errors of a stroke in f32 against f64, solve included: tip [um], orientation [0.001 deg], both through the
/// joints and the reference arm in f64.
fn single_precision_error(fields: [f64; 6]) -> Option<(f64, f64)> {
    let [d, w, point, chisel, clearance, phi] = fields;
    let exact = drill::<f64>(d, w, point, chisel, clearance);
    let single = drill::<f32>(d, w, point, chisel, clearance);
    let exact = exact.solve(phi.to_radians()).ok()?;
    let single = single.solve(Real::to_radians(phi as f32)).ok()?;
    let point_angle = point.to_radians();
    let exact = Motion::new(&exact.cone, point_angle, Variant::Exact).unwrap();
    let single_angle = Real::to_radians(point as f32);
    let single = Motion::new(&single.cone, single_angle, Variant::Exact).unwrap();
    let arm = machine(single_angle);
    let reference = Arm {
        point_angle,
        l1: L1,
        l2: L2,
    };
    let mut near = Joints::<6, f32>::default();
    let (mut tip, mut turn) = (0f64, 0f64);
    for degrees in -5..=70 {
        let moved = single.at(Real::to_radians(degrees as f32));
        let p = arm.home_tip() + moved.p + arm.away() * 0.1;
        near = arm.inverse(&Pose { p, ..moved }, &near).unwrap();
        let moved = exact.at(f64::from(degrees).to_radians());
        let half = point_angle / 2.0;
        let away = Vector::new(half.sin(), half.cos(), 0.0) * 0.1;
        let wanted = Pose {
            p: home_tip() + moved.p + away,
            ..moved
        };
        let (off, turned) = reference_error(&reference, &near.0.map(f64::from), &wanted);
        tip = tip.max(off);
        turn = turn.max(turned);
    }
    Some((tip * 1e3, turn.to_degrees() * 1e3))
}

#[test]
fn single_precision_keeps_the_tip_within_a_micrometre() {
    let mut worst = (0f64, 0f64);
    let mut tips = Vec::new();
    let mut random = Random(8);
    for _ in 0..400 {
        let fields = random.drill();
        if let Some((tip, turn)) = single_precision_error(fields) {
            if tip > 0.3 {
                eprintln!("{tip} {turn} {fields:?}");
            }
            worst = (worst.0.max(tip), worst.1.max(turn));
            tips.push(tip);
        }
    }
    tips.sort_by(f64::total_cmp);
    eprintln!(
        "ex1 {:?}",
        single_precision_error([9.9, 1.63, 118.0, 50.0, 10.0, 30.0])
    );
    eprintln!(
        "ex2 {:?}",
        single_precision_error([7.0, 1.03, 118.0, 50.0, 12.0, 40.0])
    );
    eprintln!(
        "random {worst:?} median {} p99 {}",
        tips[tips.len() / 2],
        tips[tips.len() * 99 / 100]
    );
    let _: (Rotation<f32>, fn(f64) -> f64) = (Rotation::IDENTITY, principal);
}
