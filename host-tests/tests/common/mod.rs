//! What several test files share: lines said to machines, a seeded generator, and matrices that share no code with the
//! library.
#![allow(dead_code)]

pub mod emulator;

use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep_host::emulator::Pulses;
use hexstep_host::machine::Machine;
use hexstep_host::trace::Trace;

/// Says each line as soon as the one before is answered, and runs to rest; the pulses since the trace was last taken.
#[track_caller]
pub fn pulses_of_lines<const N: usize>(machine: &mut Machine<'_, N>, lines: &[String]) -> Pulses {
    Pulses::of_trace(&trace_of_lines(machine, lines))
}

/// The same, with all that the pins did.
#[track_caller]
pub fn trace_of_lines<const N: usize>(machine: &mut Machine<'_, N>, lines: &[String]) -> Trace<N> {
    for line in lines {
        machine.say(line);
        let mut answer = String::new();
        while !answer.ends_with("ok\r\n") {
            assert!(!answer.contains("error"), "{line}: {answer}");
            machine.step();
            answer += &machine.heard();
        }
    }
    machine.run_to_rest();
    machine.run(3);
    machine.take_trace()
}

/// Lines for one motor: steps, acceleration, jerk, rate, travel.
fn axis_lines(motor: usize, values: [i32; 6]) -> impl Iterator<Item = String> {
    let numbers = [100, 120, 800, 110, 1040, 1050].into_iter();
    let lines = numbers.zip(values);
    lines.map(move |(number, value)| format!("${}={value}", number + motor))
}

/// Lines that make six motors those of an ER3B with a tool of 160 mm, its work where the delivered jobs have it.
pub fn arm_lines() -> Vec<String> {
    let mut lines: Vec<String> = [
        "$1012=1",
        "$KIN=ARM6R",
        "$KIN.TOOL=160",
        "$KIN.WORK=310,0,200",
        "$1003=0.05",
    ]
    .map(String::from)
    .into();
    let axes = [
        // steps, deg/min, deg/s2, deg/s3, travel
        (2500, 3600, 400, 10_000, -175, 175),
        (2500, 3600, 400, 10_000, -142, 64),
        (2500, 3600, 400, 10_000, -73, 165),
        (2000, 4500, 600, 15_000, -178, 178),
        (2000, 4500, 600, 15_000, -132, 132),
        (1500, 5400, 800, 20_000, -720, 720),
    ];
    lines.extend((0..6).map(|i| format!("$11{i}=1")));
    for (i, (steps, rate, acceleration, jerk, lower, upper)) in axes.into_iter().enumerate() {
        lines.extend(axis_lines(
            i,
            [steps, acceleration, jerk, rate, lower, upper],
        ));
    }
    lines
}

/// Lines that make eight motors those of the two-sided machine M4.
pub fn pair_lines() -> Vec<String> {
    let mut lines: Vec<String> = ["$1012=1", "$1003=0.01"].map(String::from).into();
    let axes = [
        // steps, mm or deg per min, s2, s3, travel of the mill and of the support
        (400, 18_000, 1500, 30_000, [-100, 1300], [-1300, 100]),
        (400, 18_000, 1500, 30_000, [-100, 1000], [-100, 1000]),
        (800, 6000, 1000, 20_000, [-200, 200], [-200, 200]),
        (5000, 1200, 200, 8000, [-30, 30], [-30, 30]),
    ];
    lines.extend((0..8).map(|i| format!("$11{i}=1")));
    for (i, (steps, rate, acceleration, jerk, mill, support)) in axes.into_iter().enumerate() {
        for (motor, [lower, upper]) in [(i, mill), (i + 4, support)] {
            lines.extend(axis_lines(
                motor,
                [steps, acceleration, jerk, rate, lower, upper],
            ));
        }
    }
    lines
}

/// splitmix64: the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [lo, hi).
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * (self.word() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.word() % n as u64) as usize
    }

    /// Uniform in 0 .. n.
    pub fn whole(&mut self, n: i64) -> i64 {
        self.below(n as usize) as i64
    }

    pub fn direction(&mut self) -> Vector<f64> {
        loop {
            let v = self.point(1.0);
            let n = v.dot(v);
            if (0.01..=1.0).contains(&n) {
                return v * (1.0 / n.sqrt());
            }
        }
    }

    /// Each coordinate within +-size.
    pub fn point(&mut self, size: f64) -> Vector<f64> {
        Vector::new(
            self.between(-size, size),
            self.between(-size, size),
            self.between(-size, size),
        )
    }

    pub fn rotation(&mut self) -> Rotation<f64> {
        let n = self.direction();
        loop {
            if let Some(a) = n.cross(self.direction()).unit(0.1) {
                return Rotation {
                    n,
                    s: a.cross(n),
                    a,
                };
            }
        }
    }

    pub fn pose(&mut self, size: f64) -> Pose<f64> {
        Pose {
            rotation: self.rotation(),
            p: self.point(size),
        }
    }
}

pub fn rounded(v: Vector<f64>) -> Vector<f32> {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

pub fn widened(v: Vector<f32>) -> Vector<f64> {
    Vector::new(v.x.into(), v.y.into(), v.z.into())
}

pub fn rounded_rotation(r: Rotation<f64>) -> Rotation<f32> {
    Rotation {
        n: rounded(r.n),
        s: rounded(r.s),
        a: rounded(r.a),
    }
}

pub fn rounded_pose(pose: Pose<f64>) -> Pose<f32> {
    Pose {
        rotation: rounded_rotation(pose.rotation),
        p: rounded(pose.p),
    }
}

pub fn widened_pose(pose: Pose<f32>) -> Pose<f64> {
    Pose {
        rotation: Rotation {
            n: widened(pose.rotation.n),
            s: widened(pose.rotation.s),
            a: widened(pose.rotation.a),
        },
        p: widened(pose.p),
    }
}

/// 4x4, row by row: the reference's own arithmetic.
pub type Matrix = [[f64; 4]; 4];

pub const UNIT: Matrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

pub fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// The exponential of a twist matrix by its series, scaled and squared: no sine, no cosine, no Rodrigues.
pub fn exponential(v: Vector<f64>, w: Vector<f64>, theta: f64) -> Matrix {
    let squarings = 12;
    let k = theta / f64::from(1u32 << squarings);
    let (v, w) = (v * k, w * k);
    let x = [
        [0.0, -w.z, w.y, v.x],
        [w.z, 0.0, -w.x, v.y],
        [-w.y, w.x, 0.0, v.z],
        [0.0; 4],
    ];
    // exp(x) - 1, so that squaring loses nothing against the 1.
    let mut term = x;
    let mut sum = x;
    for n in 2..12 {
        term = times(&term, &x);
        term.iter_mut().flatten().for_each(|e| *e /= f64::from(n));
        for (s, t) in sum.iter_mut().flatten().zip(term.iter().flatten()) {
            *s += t;
        }
    }
    for _ in 0..squarings {
        let square = times(&sum, &sum);
        for (s, q) in sum.iter_mut().flatten().zip(square.iter().flatten()) {
            *s = 2.0 * *s + q;
        }
    }
    for (i, row) in sum.iter_mut().enumerate() {
        row[i] += 1.0;
    }
    sum
}

pub fn matrix(pose: &Pose<f64>) -> Matrix {
    let Pose {
        rotation: Rotation { n, s, a },
        p,
    } = *pose;
    [
        [n.x, s.x, a.x, p.x],
        [n.y, s.y, a.y, p.y],
        [n.z, s.z, a.z, p.z],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

pub fn rigid_inverse(m: &Matrix) -> Matrix {
    let mut inverse = UNIT;
    for i in 0..3 {
        for j in 0..3 {
            inverse[i][j] = m[j][i];
        }
        inverse[i][3] = -(0..3).map(|k| m[k][i] * m[k][3]).sum::<f64>();
    }
    inverse
}

/// A point (`h` = 1) or a direction (`h` = 0) through a matrix.
pub fn through(m: &Matrix, v: Vector<f64>, h: f64) -> Vector<f64> {
    let row = |i: usize| m[i][0] * v.x + m[i][1] * v.y + m[i][2] * v.z + m[i][3] * h;
    Vector::new(row(0), row(1), row(2))
}

/// Largest difference of two poses, element by element.
pub fn difference(a: &Pose<f64>, b: &Pose<f64>) -> f64 {
    let (a, b) = (matrix(a), matrix(b));
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}
