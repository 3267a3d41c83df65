//! The examples, random drills, and what several files measure with.

use hexstep::cycles::drill_point::{Cone, Cycle, Drill, Parameters};
use hexstep::geometry::{Pose, Vector};
use hexstep::joints::Joints;
use hexstep::kinematics::Kinematics;
use hexstep::machines::DrillGrinder;
use hexstep::math::Real;
use hexstep_host::reference::grinding::Arm;

pub const L1: f64 = 150.0;
pub const L2: f64 = 40.0;

pub fn drill<R: Real>(d: f64, w: f64, point: f64, chisel: f64, clearance: f64) -> Drill<R> {
    let angle = |x: f64| R::of(x).to_radians();
    Drill {
        diameter: R::of(d),
        web: R::of(w),
        point_angle: angle(point),
        chisel_angle: angle(chisel),
        clearance: angle(clearance),
    }
}

pub fn example_1<R: Real>() -> (Drill<R>, R) {
    (
        drill(9.9, 1.63, 118.0, 50.0, 10.0),
        R::of(30.0).to_radians(),
    )
}

pub fn example_2<R: Real>() -> (Drill<R>, R) {
    (
        drill(7.0, 1.03, 118.0, 50.0, 12.0),
        R::of(40.0).to_radians(),
    )
}

/// The parameters as the paper prints them.
pub fn printed(phi: f64, theta: f64, omega: f64, tip: [f64; 3]) -> Cone<f64> {
    Cone {
        phi: phi.to_radians(),
        theta: theta.to_radians(),
        omega: omega.to_radians(),
        tip: Vector::from_array(tip),
    }
}

pub fn printed_1() -> Cone<f64> {
    printed(30.0, 29.1, 3.8, [3.75, 1.06, 2.51])
}

pub fn printed_2() -> Cone<f64> {
    printed(40.0, 19.1, 2.75, [4.69, 0.8, 3.0])
}

pub fn machine<R: Real>(point_angle: R) -> DrillGrinder<R> {
    DrillGrinder::new(point_angle, R::of(L1), R::of(L2)).unwrap()
}

pub fn home_tip() -> Vector<f64> {
    Vector::new(-L1, -L2, 0.0)
}

#[track_caller]
pub fn assert_close(got: f64, wanted: f64, tolerance: f64) {
    assert!(
        (got - wanted).abs() <= tolerance,
        "{got} instead of {wanted}, off by {:e}",
        got - wanted
    );
}

/// splitmix64, as fractions of one: seeded random cases.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// The random drills of section 3.1: diameter, web, point angle, chisel angle, clearance, phi, in mm and deg.
    pub fn drill(&mut self) -> [f64; 6] {
        let diameter = self.between(3.0, 20.0);
        let web = diameter * self.between(0.10, 0.22);
        let point = self.between(85.0, 145.0);
        let chisel = self.between(40.0, 65.0);
        let clearance = self.between(6.0, 20.0);
        let phi = self.between(10.0, point / 2.0 - 5.0);
        [diameter, web, point, chisel, clearance, phi]
    }
}

/// Distance of the tip [mm] and angle [rad] between a pose and where the reference arm stands.
pub fn reference_error(arm: &Arm, joints: &[f64; 6], wanted: &Pose<f64>) -> (f64, f64) {
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

pub fn example_cycle<R: Real>() -> (Cycle<R>, DrillGrinder<R>) {
    let (wanted, phi) = example_1::<R>();
    let arm = machine(wanted.point_angle);
    let parameters = Parameters::new(wanted, phi, arm.home_tip(), R::of(0.3));
    (Cycle::new(&parameters).unwrap(), arm)
}

/// The joints of every waypoint in turn, from home, with the waypoint's duration.
pub fn joints_of<R: Real>(cycle: &Cycle<R>, arm: &DrillGrinder<R>) -> Vec<(Joints<6, R>, R)> {
    let mut near = Joints::default();
    cycle
        .clone()
        .map(|waypoint| {
            near = arm.inverse(&waypoint.pose, &near).unwrap();
            (near, waypoint.duration)
        })
        .collect()
}
