//! A formula or a seed -> the points of a contest. All begin at rest at 0; coordinates are rounded to 1e-5 mm or deg, so
//! that every system reads the same numbers.
//!
//! The random moves are those of NumPy's generator, kept as a table; turns of the six-axis contests come from a generator
//! of our own.

use std::f64::consts::TAU;

/// A path, how fast it is to be run, and what is asked of it.
#[derive(Clone, Debug)]
pub struct Contest {
    pub name: &'static str,
    pub what: &'static str,
    /// Joints: three in mm, three in deg.
    pub points: Vec<[f64; 6]>,
    /// [mm/min]
    pub feed: f64,
    /// Longest time at the first of [`JERKS`](super::JERKS), and at the second [s].
    pub goals: Option<[f64; 2]>,
    /// Time that no motion with the first jerk is known to fall below [s], and where it comes from.
    pub bound: Option<(f64, &'static str)>,
    pub steady: Steady,
}

/// Where the feed is constant if the path is run well: there its ripple is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steady {
    Nowhere,
    /// Between these shares of each of so many legs of equal length.
    Legs(u32, f64, f64),
    /// Where the first joint is between these places.
    Between(f64, f64),
}

/// LinuxCNC's trapezoid is allowed to be this much faster where jerk hardly limits.
const BEHIND: f64 = 1.03;

const RANDOM: &str = include_str!("../../cases/duel/e-random.csv");

/// All contests, those of three axes first.
pub fn contests() -> Vec<Contest> {
    let goals = |first: f64, trapezoid: f64| Some([first, BEHIND * trapezoid]);
    let three = [
        Contest {
            name: "a-circle",
            what: "circle r 20, 10 000 chords, 50 mm/s",
            points: circle(20.0, 10_000, 1),
            feed: 3000.0,
            goals: goals(2.66, 2.574),
            bound: Some((2.61, "feed and ramps")),
            steady: Steady::Legs(1, 0.2, 0.8),
        },
        Contest {
            name: "b-circle",
            what: "circle r 5, 72 chords a turn, 3 turns, 100 mm/s",
            points: circle(5.0, 72, 3),
            feed: 6000.0,
            goals: goals(1.60, 1.564),
            bound: Some((1.37, "without jerk")),
            steady: Steady::Legs(1, 0.2, 0.8),
        },
        Contest {
            name: "c-raster",
            what: "raster over a wave, 0.1 mm chords, 66.7 mm/s",
            points: raster(),
            feed: 4000.0,
            goals: goals(20.3, 17.676),
            bound: Some((19.7, "feed, rest at row ends")),
            steady: Steady::Between(10.0, 40.0),
        },
        Contest {
            name: "d-zig90",
            what: "zigzag of 2 mm, 90 deg",
            points: zigzag(100, 2.0, 90.0),
            feed: 6000.0,
            goals: goals(11.6, 7.717),
            bound: Some((10.7, "best in the tube")),
            steady: Steady::Nowhere,
        },
        Contest {
            name: "d-zig135",
            what: "zigzag of 2 mm, 135 deg",
            points: zigzag(100, 2.0, 135.0),
            feed: 6000.0,
            goals: goals(11.6, 8.832),
            bound: Some((10.4, "best in the tube")),
            steady: Steady::Nowhere,
        },
        Contest {
            name: "e-random",
            what: "500 random moves of 0.02 to 1 mm",
            points: table(RANDOM),
            feed: 3000.0,
            goals: goals(22.5, 11.194),
            bound: Some((20.8, "a motion that exists")),
            steady: Steady::Nowhere,
        },
        Contest {
            name: "f-square",
            what: "square of 100 mm, 166.7 mm/s",
            points: square(100.0),
            feed: 10_000.0,
            goals: goals(3.16, 3.064),
            bound: Some((3.10, "best in the tube")),
            steady: Steady::Legs(4, 0.4, 0.6),
        },
        Contest {
            name: "g-star",
            what: "star of 36 legs of 40 mm, 170 deg",
            points: star(36, 40.0, 170.0),
            feed: 6000.0,
            goals: goals(18.4, 17.7),
            bound: Some((17.7, "best in the tube")),
            steady: Steady::Legs(36, 0.45, 0.55),
        },
    ];
    let six = SIX.iter().zip(&three).zip(0u64..);
    let six = six.map(|((name, contest), seed)| turned(contest, name, 71 + seed));
    let six: Vec<Contest> = six.collect();
    three.into_iter().chain(six).collect()
}

/// Names of the contests with all six joints, in the order of those with three.
const SIX: [&str; 8] = [
    "a-circle-six",
    "b-circle-six",
    "c-raster-six",
    "d-zig90-six",
    "d-zig135-six",
    "e-random-six",
    "f-square-six",
    "g-star-six",
];

/// To 1e-5.
fn rounded(at: [f64; 6]) -> [f64; 6] {
    at.map(|x| {
        let x = (x * 1e5).round() / 1e5;
        // No minus zero in a file.
        if x == 0.0 { 0.0 } else { x }
    })
}

fn flat(x: f64, y: f64) -> [f64; 6] {
    rounded([x, y, 0.0, 0.0, 0.0, 0.0])
}

fn circle(r: f64, chords: usize, turns: usize) -> Vec<[f64; 6]> {
    let at = |k: usize| {
        let (s, c) = (TAU * k as f64 / chords as f64).sin_cos();
        flat(r * c - r, r * s)
    };
    (1..=chords * turns).map(at).collect()
}

/// Rows of 50 mm, 0.5 mm apart, there and back over a wave.
fn raster() -> Vec<[f64; 6]> {
    let rows = (0..20).flat_map(|row| {
        (0..=500).map(move |k| {
            let x = f64::from(if row % 2 == 0 { k } else { 500 - k }) / 10.0;
            let y = 0.5 * f64::from(row);
            rounded([x, y, 2.0 * (x / 5.0).sin(), 0.0, 0.0, 0.0])
        })
    });
    rows.skip(1).collect()
}

/// Corners to the left and to the right in turn.
fn zigzag(corners: usize, leg: f64, degrees: f64) -> Vec<[f64; 6]> {
    let (s, c) = (0.5 * degrees).to_radians().sin_cos();
    let (mut x, mut y) = (0.0, 0.0);
    let legs = (0..=corners).map(|k| {
        x += leg * c;
        y += if k % 2 == 0 { leg * s } else { -leg * s };
        flat(x, y)
    });
    legs.collect()
}

fn square(side: f64) -> Vec<[f64; 6]> {
    [(side, 0.0), (side, side), (0.0, side), (0.0, 0.0)]
        .map(|(x, y)| flat(x, y))
        .to_vec()
}

fn star(legs: usize, leg: f64, degrees: f64) -> Vec<[f64; 6]> {
    let (mut x, mut y) = (0.0, 0.0);
    let legs = (0..legs).map(|k| {
        let (s, c) = (degrees * k as f64).to_radians().sin_cos();
        x += leg * c;
        y += leg * s;
        flat(x, y)
    });
    legs.collect()
}

/// Rows of three numbers; what cannot be read is not there, and a test counts them.
fn table(text: &str) -> Vec<[f64; 6]> {
    let row = |line: &str| {
        let mut cells = line.split(',').map(|cell| cell.trim().parse().ok());
        let [x, y, z] = [cells.next()??, cells.next()??, cells.next()??];
        Some([x, y, z, 0.0, 0.0, 0.0])
    };
    text.lines().filter_map(row).collect()
}

/// The same path while three joints turn: on chords along slow waves of the way, at corners by as much a leg.
fn turned(contest: &Contest, name: &'static str, seed: u64) -> Contest {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
    let ways: Vec<f64> = {
        let mut from = [0.0; 6];
        let mut way = 0.0;
        let along = contest.points.iter().map(|at| {
            let squares = at.iter().zip(&from).map(|(a, b)| (a - b).powi(2));
            way += squares.sum::<f64>().sqrt();
            from = *at;
            way
        });
        along.collect()
    };
    let length = ways.last().copied().unwrap_or(0.0);
    let is_smooth = !matches!(contest.steady, Steady::Nowhere) && contest.points.len() > 100;
    let waves = [0; 3].map(|_| (1.0 + 4.0 * random.unit(), 1.0 + 2.0 * random.unit()));
    let mut turn = [0.0; 3];
    let mut before = 0.0;
    let points = contest.points.iter().zip(ways).map(|(at, way)| {
        for (turn, (degrees, periods)) in turn.iter_mut().zip(waves) {
            if is_smooth {
                *turn = degrees * (TAU * periods * way / length).sin();
            } else {
                // Up to half a degree for a millimetre, and not more than five for a leg.
                *turn += (random.unit() - 0.5) * (way - before).min(10.0);
            }
        }
        before = way;
        let [x, y, z, ..] = *at;
        rounded([x, y, z, turn[0], turn[1], turn[2]])
    });
    Contest {
        name,
        points: points.collect(),
        goals: None,
        bound: None,
        ..contest.clone()
    }
}

/// xorshift64*
struct Random(u64);

impl Random {
    /// 0 .. 1
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
}
