//! What the tests of five-axis machines and of following share.

use hexstep::geometry::Vector;
use hexstep::joints::Joints;
use hexstep::kinematics::ClPoint;
use hexstep::kinematics::follow::{Block, Feed, Follower, Refusal, Refused, Tolerance};
use hexstep::machines::five_axis::{
    self, Class, Definition, Error, FiveAxis, Solution, Turned, preset,
};
use hexstep::math::Real;
use hexstep_host::reference::five_axis::{angle_deg, distance, reference_forward};

/// F 1000 mm/min.
pub const FEED: f64 = 1000.0 / 60.0;

pub fn vector<R: Real>(x: [R; 3]) -> Vector<R> {
    Vector::from_array(x)
}

pub fn unit(x: [f64; 3]) -> Vector<f64> {
    five_axis::direction(vector(x), "v").expect("direction")
}

pub fn cl(p: [f64; 3], v: [f64; 3]) -> ClPoint<f64> {
    ClPoint::new(vector(p), vector(v)).expect("CL point")
}

pub fn angles(degrees: [f64; 2]) -> [Turned<f64>; 2] {
    degrees.map(|a| Turned::from_total(a.to_radians()))
}

pub fn limits(rotary: [[f64; 2]; 2]) -> [Option<[f64; 2]>; 5] {
    let [primary, secondary] = rotary.map(|l| Some(l.map(f64::to_radians)));
    [None, None, None, primary, secondary]
}

pub fn degrees(joints: &Joints<5, f64>) -> [f64; 5] {
    let Joints([x, y, z, a, b]) = *joints;
    [x, y, z, a.to_degrees(), b.to_degrees()]
}

pub fn tolerance(tip: f64, axis_deg: f64) -> Tolerance<f64> {
    Tolerance {
        tip,
        axis: axis_deg.to_radians(),
        subdivide: true,
    }
}

/// `found` printed with `digits` decimals is `printed`.
#[track_caller]
pub fn near(found: f64, printed: f64, digits: i32, what: &str) {
    let unit = 10f64.powi(-digits);
    assert!(
        (found - printed).abs() <= 0.5001 * unit,
        "{what}: {found:.12} is not {printed}"
    );
}

#[track_caller]
pub fn all_near(found: &[f64], printed: &[f64], digits: i32, what: &str) {
    assert_eq!(found.len(), printed.len());
    for (found, printed) in found.iter().zip(printed) {
        near(*found, *printed, digits, what);
    }
}

/// The pivots of section 9's table of machines.
pub fn with_pivots(name: &str) -> Definition<f64> {
    let base = preset::<f64>(name).expect("preset");
    if name == "s45" {
        return base;
    }
    let (q1, q2) = match base.class {
        Class::Head => ([0.0, 0.0, 250.0], [10.0, 0.0, 200.0]),
        Class::Table => ([0.0, 0.0, -50.0], [0.0, 20.0, -50.0]),
        Class::Mixed => ([0.0, 0.0, -50.0], [10.0, 0.0, 200.0]),
    };
    Definition {
        q1: vector(q1),
        q2: vector(q2),
        w0: vector([5.0, -8.0, 12.0]),
        ..base
    }
}

/// Section 9's path: 13 CL points about the frustum.
pub fn frustum() -> Vec<ClPoint<f64>> {
    let s = (100.0f64 / 500.0).atan();
    let turned = |angle: f64, [x, y, z]: [f64; 3]| {
        let (sin, cos) = angle.to_radians().sin_cos();
        [x * cos - y * sin, x * sin + y * cos, z]
    };
    let axis = [-s.sin(), 0.0, s.cos()];
    let foot = |y: f64| [250.0 + 10.0 * s.cos(), y, 10.0 * s.sin()];
    let mut path = vec![cl(foot(-250.0), axis)];
    for side in 0..4 {
        let at = 90.0 * f64::from(side);
        path.push(cl(turned(at, foot(250.0)), turned(at, axis)));
        // About the vertical corner edge at (250, 250).
        let [x, y, z] = turned(45.0, [10.0 * s.cos(), 0.0, 10.0 * s.sin()]);
        path.push(cl(
            turned(at, [250.0 + x, 250.0 + y, z]),
            turned(at + 45.0, axis),
        ));
        path.push(cl(turned(at + 90.0, foot(-250.0)), turned(at + 90.0, axis)));
    }
    path
}

pub fn trap() -> (Definition<f64>, Vec<ClPoint<f64>>) {
    let mut definition = preset::<f64>("head_ca").unwrap();
    definition.limits = limits([[-270.0, 270.0], [-110.0, 25.0]]);
    let path = vec![
        cl([0.0, 0.0, 0.0], [0.05, -0.2, 0.97]),
        cl([5.0, 0.0, 0.0], [0.1, -0.4, 0.9]),
        cl([10.0, 0.0, 0.0], [0.1, -0.6, 0.75]),
    ];
    (definition, path)
}

pub type Followed = Result<Vec<Block<5, f64, Solution<f64>>>, Refused<f64, Error<f64>>>;

/// All blocks of a path after its first point, greedy choice.
pub fn follow(
    definition: &Definition<f64>,
    path: &[ClPoint<f64>],
    tip: f64,
    axis_deg: f64,
    previous: [f64; 2],
) -> Followed {
    let machine = FiveAxis::new(definition).expect("machine");
    let at = |why| Refused {
        segment: 0,
        u: 0.0,
        why,
    };
    let start = machine
        .inverse(path[0].p(), path[0].v(), &angles(previous))
        .map_err(|error| at(Refusal::Machine(error)))?;
    let mut follower =
        Follower::new(&machine, tolerance(tip, axis_deg), path[0], start).map_err(at)?;
    let mut blocks = Vec::new();
    for to in &path[1..] {
        follower.push(*to, None, Feed::Tip(FEED))?;
        blocks.extend(std::iter::from_fn(|| follower.next_block()));
    }
    Ok(blocks)
}

/// The point at `u` of a straight line and a great circle.
pub fn between(path: &[ClPoint<f64>], u: f64) -> ClPoint<f64> {
    let (a, b) = (path[0], path[1]);
    let w = angle_deg(a.v().to_array(), b.v().to_array()).to_radians();
    let v = if w < 1e-9 {
        b.v()
    } else {
        a.v() * (((1.0 - u) * w).sin() / w.sin()) + b.v() * ((u * w).sin() / w.sin())
    };
    ClPoint::new(a.p() + (b.p() - a.p()) * u, v).unwrap()
}

/// Largest errors of the linear joint move, tip [mm] and axis [deg], at u = 1/n .. (n-1)/n.
pub fn true_errors(
    definition: &Definition<f64>,
    (from, a): (&ClPoint<f64>, &Solution<f64>),
    (to, b): (&ClPoint<f64>, &Solution<f64>),
    samples: u32,
) -> (f64, f64) {
    let (mut tip, mut axis) = (0f64, 0f64);
    for i in 1..samples {
        let u = f64::from(i) / f64::from(samples);
        let (qa, qb) = (a.joints(), b.joints());
        let q: [f64; 5] = std::array::from_fn(|j| qa[j] + (qb[j] - qa[j]) * u);
        let (p, v) = reference_forward(definition, &q);
        let wanted = between(&[*from, *to], u);
        tip = tip.max(distance(p, wanted.p().to_array()));
        axis = axis.max(angle_deg(v, wanted.v().to_array()));
    }
    (tip, axis)
}
