//! Five-axis machines as 4x4 matrices from unit quaternions, and seeded random machines and poses.
//!
//! Shares no formula with the library, only its plain values.

use hexstep::geometry::{Rotation, Vector};
use hexstep::machines::five_axis::{Class, Definition, PRESETS, direction, preset};

use super::matrix::{about, inverted, multiply, translation};
pub use super::matrix::{angle_deg, distance};

/// Tip and axis of joints [mm, rad]: 4x4 matrices of each axis from unit quaternions, inverted and multiplied.
pub fn reference_forward(m: &Definition<f64>, q: &[f64; 5]) -> ([f64; 3], [f64; 3]) {
    let mut shift = [0.0; 3];
    for (direction, x) in m.linear.iter().zip(q) {
        let norm = distance(direction.to_array(), [0.0; 3]);
        for (shift, d) in shift.iter_mut().zip(direction.to_array()) {
            *shift += d / norm * x;
        }
    }
    let moved = translation(shift);
    let x1 = about(m.n1.to_array(), m.q1.to_array(), q[3]);
    let x2 = about(m.n2.to_array(), m.q2.to_array(), q[4]);
    let one = translation([0.0; 3]);
    let (head, table) = match m.class {
        Class::Head => (multiply(&x1, &x2), one),
        Class::Table => (one, multiply(&x1, &x2)),
        Class::Mixed => (x2, x1),
    };
    let (n, s, a) = (m.rw.n, m.rw.s, m.rw.a);
    let work = [
        [n.x, s.x, a.x, m.w0.x],
        [n.y, s.y, a.y, m.w0.y],
        [n.z, s.z, a.z, m.w0.z],
        [0.0, 0.0, 0.0, 1.0],
    ];
    // work frame <- base: inverse of (table * work).
    let back = inverted(&multiply(&table, &work));
    let tool = multiply(&back, &multiply(&moved, &head));
    let norm = distance(m.v1.to_array(), [0.0; 3]);
    let apply = |x: [f64; 3], w: f64| {
        std::array::from_fn(|i| (0..3).map(|j| tool[i][j] * x[j]).sum::<f64>() + tool[i][3] * w)
    };
    (
        apply(m.t0.to_array(), 1.0),
        apply(m.v1.to_array().map(|x| x / norm), 0.0),
    )
}

/// Machines of all classes, axes and tool along any direction, pivots to 1000 mm.
pub fn random_machine(random: &mut Random, i: usize) -> Definition<f64> {
    let base = preset::<f64>(PRESETS[i % 13]).unwrap();
    loop {
        let definition = Definition {
            n1: random.vector(),
            n2: random.vector(),
            q1: random.vector() * 1000.0,
            q2: random.vector() * 1000.0,
            v1: random.vector(),
            t0: random.vector() * 1000.0,
            w0: random.vector() * 1000.0,
            rw: random.frame(),
            linear: {
                // Not quite at right angles, and left-handed as often as not.
                let Rotation { n, s, a } = random.frame();
                let sign = random.within(-1.0, 1.0).signum();
                [n, s, a * sign].map(|axis| axis + random.vector() * 0.1)
            },
            limits: [None; 5],
            ..base
        };
        let sines = [
            unit(definition.n1.to_array())
                .cross(unit(definition.n2.to_array()))
                .norm(),
            unit(definition.n2.to_array())
                .cross(unit(definition.v1.to_array()))
                .norm(),
            unit(definition.n1.to_array())
                .cross(unit(definition.v1.to_array()))
                .norm(),
        ];
        if sines.iter().all(|s| *s > 0.2) {
            return definition;
        }
    }
}

/// xorshift64*: seeded, the same everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11;
        lo + (hi - lo) * bits as f64 / (1u64 << 53) as f64
    }

    pub fn frame(&mut self) -> Rotation<f64> {
        let n = unit(self.vector().to_array());
        let a = unit(n.cross(self.vector()).to_array());
        Rotation {
            n,
            s: a.cross(n),
            a,
        }
    }

    /// In the unit ball, not near its centre.
    pub fn vector(&mut self) -> Vector<f64> {
        loop {
            let v = vector([
                self.within(-1.0, 1.0),
                self.within(-1.0, 1.0),
                self.within(-1.0, 1.0),
            ]);
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v;
            }
        }
    }
}

pub fn widen(v: Vector<f32>) -> Vector<f64> {
    vector(v.to_array().map(f64::from))
}

pub fn narrow(m: &Definition<f64>) -> Definition<f32> {
    let v = |v: Vector<f64>| vector(v.to_array().map(|x| x as f32));
    Definition {
        class: m.class,
        n1: v(m.n1),
        n2: v(m.n2),
        q1: v(m.q1),
        q2: v(m.q2),
        v1: v(m.v1),
        t0: v(m.t0),
        w0: v(m.w0),
        rw: Rotation {
            n: v(m.rw.n),
            s: v(m.rw.s),
            a: v(m.rw.a),
        },
        linear: m.linear.map(v),
        limits: m.limits.map(|l| l.map(|l| l.map(|x| x as f32))),
        weights: m.weights.map(|x| x as f32),
        speeds: None,
    }
}

/// What is left of a machine in f32; its unit vectors are unit again in f64.
pub fn round_machine(m: &Definition<f64>) -> Definition<f64> {
    let m = narrow(m);
    Definition {
        class: m.class,
        n1: widen(m.n1),
        n2: widen(m.n2),
        q1: widen(m.q1),
        q2: widen(m.q2),
        v1: widen(m.v1),
        t0: widen(m.t0),
        w0: widen(m.w0),
        rw: {
            let n = unit(widen(m.rw.n).to_array());
            let a = unit(n.cross(widen(m.rw.s)).to_array());
            Rotation {
                n,
                s: a.cross(n),
                a,
            }
        },
        linear: m.linear.map(widen),
        limits: m.limits.map(|l| l.map(|l| l.map(f64::from))),
        weights: m.weights.map(f64::from),
        speeds: None,
    }
}

pub fn random_pose(random: &mut Random) -> (Vector<f64>, Vector<f64>) {
    (random.vector() * 1000.0, unit(random.vector().to_array()))
}

fn vector<R: hexstep::math::Real>(x: [R; 3]) -> Vector<R> {
    Vector::from_array(x)
}

fn unit(x: [f64; 3]) -> Vector<f64> {
    direction(vector(x), "v").expect("direction")
}
