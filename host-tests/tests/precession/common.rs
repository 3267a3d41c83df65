//! What the parts share: the specification's paths, printed figures, a seeded generator.

pub use crate::shared::Random;
use hexstep::cycles::precession::{Contact, Cycle, Parameters, Reference, Stance};
use hexstep::geometry::Vector;
use hexstep::math::Real;

pub type V = Vector<f64>;

pub fn v(x: f64, y: f64, z: f64) -> V {
    Vector::new(x, y, z)
}

/// Whether `got` is the printed figure, to the last of its decimals.
#[track_caller]
pub fn printed(figure: &str, got: f64) {
    let decimals = figure.split_once('.').map_or(0, |(_, d)| d.len() as i32);
    let wanted: f64 = figure.parse().unwrap();
    let half_digit = 0.5001 * 10f64.powi(-decimals);
    assert!((wanted - got).abs() <= half_digit, "{got} is not {figure}");
}

/// The same for three figures, separated by blanks.
#[track_caller]
pub fn printed_vector(figures: &str, got: V) {
    let figures: Vec<&str> = figures.split_whitespace().collect();
    assert_eq!(figures.len(), 3);
    for (figure, got) in figures.iter().zip(got.to_array()) {
        printed(figure, got);
    }
}

/// Angle between two vectors [deg], accurate for small ones.
pub fn angle(a: V, b: V) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

/// The distance of two phases on the circle [deg].
pub fn phase_distance(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(360.0);
    d.min(360.0 - d)
}

pub fn rounded<R: Real>(u: V) -> Vector<R> {
    Vector::new(R::of(u.x), R::of(u.y), R::of(u.z))
}

pub fn widened<R: Real>(u: Vector<R>) -> V {
    v(u.x.to_f64(), u.y.to_f64(), u.z.to_f64())
}

/// Section 8: the paper's data with a chord of 0.05 mm and steps of 0.5 s.
pub fn process<R: Real>() -> Parameters<R> {
    Parameters {
        eps: R::of(0.05),
        ..Parameters::default()
    }
}

pub fn path<R: Real>(points: impl IntoIterator<Item = (V, V)>) -> Vec<Contact<R>> {
    let contact = |(p, n)| Contact {
        p: rounded(p),
        n: rounded(n),
    };
    points.into_iter().map(contact).collect()
}

pub fn flat<R: Real>(points: &[[f64; 2]]) -> Vec<Contact<R>> {
    path(points.iter().map(|[x, y]| (v(*x, *y, 0.0), Vector::Z)))
}

/// Section 8: a convex cylinder of radius 300 with its axis along y.
pub fn cylinder<R: Real>() -> Vec<Contact<R>> {
    path((-6..=6).map(|i| {
        let (sin, cos) = (5.0 * f64::from(i)).to_radians().sin_cos();
        (v(300.0 * sin, 0.0, 300.0 * cos - 300.0), v(sin, 0.0, cos))
    }))
}

pub const ZIGZAG: [[f64; 2]; 4] = [[0.0, 0.0], [30.0, 0.0], [30.0, 2.0], [0.0, 2.0]];

pub fn stances<R: Real>(parameters: &Parameters<R>, path: &[Contact<R>]) -> Vec<Stance<R>> {
    Cycle::new(parameters, path).unwrap().stances().collect()
}

pub fn counts<R: Real>(parameters: &Parameters<R>, path: &[Contact<R>]) -> Vec<u32> {
    let cycle = Cycle::new(parameters, path).unwrap();
    cycle.segments().map(|segment| segment.steps()).collect()
}

pub const REFERENCES: [Reference; 2] = [Reference::Transport, Reference::FeedLocked];

impl Random {
    /// A path with corners, reversals, repeated points and turns on the spot, its normals any way but opposite.
    pub fn path(&mut self, points: usize) -> Vec<(V, V)> {
        let mut path = vec![(self.point(300.0), self.direction())];
        while path.len() < points {
            let (p, n) = path[path.len() - 1];
            let before = path[path.len().saturating_sub(2)].0;
            let turned = n + self.direction() * self.between(0.0, 0.9);
            let turned = turned * (1.0 / turned.norm());
            let next = match self.word() % 6 {
                0 => (p, turned),
                1 => (p, n),
                2 => (before, turned),
                3 => (p + self.point(10.0), n),
                _ => (p + self.point(10.0), turned),
            };
            path.push(next);
        }
        path
    }
}
