//! Programs, runs of the planner, and what is measured on its samples.

use fixed::types::I32F32;
use hexstep::planner::{Limits, PathSetting, Planner, Sample};
use rsruckig::prelude::*;

/// xorshift64*, seeded.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }
    /// 0 .. 1
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
    /// Evenly over orders of magnitude.
    pub fn scale(&mut self, lo: f64, hi: f64) -> f64 {
        (self.between(lo.ln(), hi.ln())).exp()
    }
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

#[derive(Clone)]
pub struct Program<const N: usize> {
    pub limits: Limits<N>,
    pub path: PathSetting<N>,
    /// Targets [steps] with least durations [s].
    pub blocks: Vec<([f64; N], f32)>,
}

/// What is asked of the planner while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    Hold,
    Resume,
    Feed(f32),
    Rapid(f32),
    Stop,
    Trim(usize, i32),
    /// The input brings nothing for so many samples.
    Pause(usize),
}

/// Targets in steps, as the planner takes them.
pub fn fractional<const N: usize>(target: [f64; N]) -> [I32F32; N] {
    target.map(I32F32::from_num)
}

pub fn whole<const N: usize>(target: [i32; N]) -> [I32F32; N] {
    target.map(I32F32::from_num)
}

/// Runs a program to its end; events at given samples. Pushes whenever there is room.
pub fn run<const N: usize>(
    program: &Program<N>,
    events: &[(usize, Event)],
) -> (Vec<[f64; N]>, Planner<N>) {
    let mut planner = Planner::new(program.limits, [0; N]);
    planner.set_path(program.path).unwrap();
    let samples = go_on(&mut planner, program, events);
    (samples, planner)
}

pub fn go_on<const N: usize>(
    planner: &mut Planner<N>,
    program: &Program<N>,
    events: &[(usize, Event)],
) -> Vec<[f64; N]> {
    let mut blocks = program.blocks.iter().peekable();
    let mut events = events.iter().peekable();
    let mut samples = vec![planner.position().map(|p| p.to_num::<f64>())];
    let mut stopped = false;
    let mut paused = 0;
    loop {
        while let Some((target, duration)) = blocks.peek() {
            if stopped
                || samples.len() < paused
                || planner.push(fractional(*target), *duration).is_err()
            {
                break;
            }
            blocks.next();
        }
        while let Some((_, event)) = events.next_if(|e| e.0 <= samples.len()) {
            match event {
                Event::Hold => planner.hold(),
                Event::Resume => planner.resume(),
                Event::Feed(f) => planner.set_feed_override(*f).unwrap(),
                Event::Rapid(f) => planner.set_rapid_override(*f).unwrap(),
                Event::Stop => {
                    planner.stop();
                    stopped = true;
                }
                Event::Trim(joint, steps) => {
                    planner.set_trim(*joint, *steps);
                }
                Event::Pause(n) => paused = samples.len() + n,
            }
        }
        match planner.next() {
            Some(Sample { position, .. }) => {
                samples.push(position.map(|p: I32F32| p.to_num::<f64>()))
            }
            None if samples.len() < paused => samples.push(*samples.last().unwrap()),
            None if planner.is_held() => match events.peek() {
                // Time passes while it is held.
                Some(_) => samples.push(*samples.last().unwrap()),
                None => planner.resume(),
            },
            None => break,
        }
        assert!(
            samples.len() < 4_000_000,
            "never ends: {} blocks left",
            planner.len()
        );
    }
    samples
}

/// Largest velocity, acceleration and jerk as shares of the limits, by differences of the samples.
pub fn shares<const N: usize>(samples: &[[f64; N]], limits: &Limits<N>) -> [f64; 3] {
    let mut worst = [0.0f64; 3];
    // At rest before and after.
    let at = |k: i64, i: usize| samples[k.clamp(0, samples.len() as i64 - 1) as usize][i];
    for k in 0..samples.len() as i64 + 3 {
        for i in 0..N {
            let (q3, q2, q1, q0) = (at(k - 3, i), at(k - 2, i), at(k - 1, i), at(k, i));
            let v = (q0 - q1) * 1e3 / f64::from(limits.velocity()[i]);
            let a = (q0 - 2.0 * q1 + q2) * 1e6 / f64::from(limits.acceleration()[i]);
            let j = (q0 - 3.0 * q1 + 3.0 * q2 - q3) * 1e9 / f64::from(limits.jerk()[i]);
            for (w, x) in worst.iter_mut().zip([v, a, j]) {
                *w = w.max(x.abs());
            }
        }
    }
    worst
}

/// Whether the samples follow the polygon forward, each within `most` [mm] of the stretch it has come to; else the first
/// that does not, and its distance.
pub fn follows<const N: usize>(
    samples: &[[f64; N]],
    program: &Program<N>,
    most: f64,
) -> Result<(), (usize, f64)> {
    let weighted = |q: &[f64; N]| -> [f64; N] {
        std::array::from_fn(|i| q[i] * f64::from(program.path.weight()[i]))
    };
    let mut vertices = vec![[0.0; N]];
    vertices.extend(program.blocks.iter().map(|b| weighted(&b.0)));
    let distance = |p: &[f64; N], a: &[f64; N], b: &[f64; N]| {
        let (mut along, mut length) = (0.0, 0.0);
        for i in 0..N {
            along += (p[i] - a[i]) * (b[i] - a[i]);
            length += (b[i] - a[i]) * (b[i] - a[i]);
        }
        let t = if length > 0.0 {
            (along / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (0..N)
            .map(|i| (p[i] - a[i] - t * (b[i] - a[i])).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    // The earliest stretch that will do: if any way forward exists, this one does.
    let mut at = 0usize;
    for (number, sample) in samples.iter().enumerate() {
        let p = weighted(sample);
        let mut nearest = f64::MAX;
        let found = (at..vertices.len() - 1).find(|k| {
            let d = distance(&p, &vertices[*k], &vertices[*k + 1]);
            nearest = nearest.min(d);
            d <= most
        });
        at = found.ok_or((number, nearest))?;
    }
    Ok(())
}

pub fn random_limits(r: &mut Random) -> Limits<6> {
    let mut v = [0.0; 6];
    let mut a = [0.0; 6];
    let mut j = [0.0; 6];
    for i in 0..6 {
        v[i] = r.scale(2_000.0, 150_000.0) as f32;
        a[i] = (f64::from(v[i]) / r.scale(0.03, 0.5)) as f32;
        j[i] = (f64::from(a[i]) / r.scale(0.005, 0.1)) as f32;
    }
    Limits::new(v, a, j).unwrap()
}

/// Blocks of all kinds: zigzags, smooth chords, single steps, repeated points, reversals, long moves.
pub fn random_program(seed: u64) -> Program<6> {
    let mut r = Random::new(seed);
    let limits = random_limits(&mut r);
    let mut weight = [0.0; 6];
    for w in &mut weight {
        *w = r.scale(0.0005, 0.02) as f32;
    }
    let tolerance = [0.0, 0.003, 0.01, 0.03, 0.3][r.below(5)];
    let path = PathSetting::new(weight, tolerance).unwrap();
    let count = 2 + r.scale(1.0, 499.0) as usize;
    // Every third program has targets between steps.
    let between = seed.is_multiple_of(3);
    let mut blocks = Vec::new();
    let mut q = [0.0f64; 6];
    let mut kind = 0;
    let mut left = 0;
    let (mut size, mut phase, mut turn, mut feed) = (0.0, 0.0, 0.0, 0.0);
    let mut centre = [0.0; 6];
    while blocks.len() < count {
        if left == 0 {
            kind = r.below(5);
            left = 1 + r.below(60);
            size = r.scale(3.0, 20_000.0);
            turn = r.scale(0.005, 0.5);
            feed = if r.unit() < 0.4 {
                0.0
            } else {
                r.scale(0.02, 1.5)
            };
            phase = 0.0;
            centre = q;
        }
        left -= 1;
        let before = q;
        match kind {
            // A zigzag in all joints.
            0 => {
                for x in &mut q {
                    *x += r.between(-size, size);
                }
            }
            // A smooth curve in all joints.
            1 | 2 => {
                phase += turn;
                for i in 0..6 {
                    let w = 0.4 + 0.2 * i as f64;
                    q[i] = centre[i] + size * ((phase * w + i as f64).sin() - (i as f64).sin());
                }
            }
            // One joint there and back.
            3 => {
                let i = r.below(6);
                q[i] += if left % 2 == 0 { size } else { -size };
            }
            // Single steps.
            _ => {
                let i = r.below(6);
                q[i] += [-1.0, 0.0, 1.0][r.below(3)];
            }
        }
        if !between {
            q = q.map(f64::round);
        }
        // Duration from the slowest joint's rated time.
        let rated = (0..6)
            .map(|i| (q[i] - before[i]).abs() / f64::from(limits.velocity()[i]))
            .fold(0.0, f64::max);
        // No longer than five seconds, for the sake of the test's own time.
        let duration = if feed > 0.0 {
            (rated / feed).min(5.0)
        } else {
            0.0
        };
        blocks.push((q, duration as f32));
    }
    // It ends on whole steps: otherwise a little move to them comes on top.
    if let Some(last) = blocks.last_mut() {
        last.0 = last.0.map(f64::round);
    }
    Program {
        limits,
        path,
        blocks,
    }
}

pub fn step_length<const N: usize>(program: &Program<N>) -> f64 {
    let sum: f64 = program.path.weight().iter().map(|w| f64::from(w * w)).sum();
    sum.sqrt()
}

/// Limits, contour and end of one run, by the table of motion.md.
#[track_caller]
pub fn check(
    seed: u64,
    program: &Program<6>,
    samples: &[[f64; 6]],
    planner: &Planner<6>,
    end: [f64; 6],
) {
    let s = shares(samples, &program.limits);
    assert!(
        s[0] <= 1.02 && s[1] <= 1.02 && s[2] <= 1.10,
        "seed {seed}: shares of the limits {s:?}"
    );
    // Half a step of each joint remains for the pulses.
    let most = f64::from(program.path.tolerance()) + 0.5 * step_length(program);
    assert_eq!(
        follows(samples, program, most),
        Ok(()),
        "seed {seed}, {most} mm allowed"
    );
    assert_eq!(*samples.last().unwrap(), end, "seed {seed}");
    assert_eq!(planner.counters().squeezed, 0, "seed {seed}");
    assert!(planner.is_idle(), "seed {seed}");
}

pub fn end_of(program: &Program<6>) -> [f64; 6] {
    program
        .blocks
        .last()
        .map_or([0.0; 6], |b| b.0.map(|p| (p + 0.5).floor()))
}

/// A few in every build; `HEXSTEP_LONG=1` runs a thousand, `HEXSTEP_SEED=n` one.
pub fn seeds(few: u64) -> std::ops::RangeInclusive<u64> {
    if let Some(seed) = std::env::var("HEXSTEP_SEED")
        .ok()
        .and_then(|s| s.parse().ok())
    {
        return seed..=seed;
    }
    1..=if std::env::var_os("HEXSTEP_LONG").is_some() {
        1000
    } else {
        few
    }
}

/// Path speed at each sample [mm/ms].
pub fn speeds(samples: &[[f64; 6]], program: &Program<6>) -> Vec<f64> {
    let w = program.path.weight();
    samples
        .windows(2)
        .map(|s| {
            let sum: f64 = (0..6)
                .map(|i| ((s[1][i] - s[0][i]) * f64::from(w[i])).powi(2))
                .sum();
            sum.sqrt()
        })
        .collect()
}

/// A long smooth curve at constant feed: 20 mm circles in two joints with chords of 1 mm.
pub fn circles(feed: f64) -> Program<6> {
    let limits = Limits::new([100_000.0; 6], [960_000.0; 6], [32e6; 6]).unwrap();
    let path = PathSetting::new([1.0 / 320.0; 6], 0.01).unwrap();
    let blocks = (1..=1500)
        .map(|k| {
            let t = f64::from(k) * 0.05;
            let q = [
                6400.0 * (t.cos() - 1.0),
                6400.0 * t.sin(),
                320.0 * t,
                0.0,
                0.0,
                0.0,
            ];
            (q.map(f64::round), (1.0 / feed) as f32)
        })
        .collect();
    Program {
        limits,
        path,
        blocks,
    }
}

/// Least time of a jerk-limited move over `l` from rest to rest.
pub fn optimum(l: f64, v: f64, a: f64, j: f64) -> f64 {
    let ramp = |v: f64| {
        if v * j < a * a {
            2.0 * (v / j).sqrt()
        } else {
            v / a + a / j
        }
    };
    if v * ramp(v) <= l {
        return l / v + ramp(v);
    }
    let (mut lo, mut hi) = (0.0, v);
    for _ in 0..100 {
        let m = 0.5 * (lo + hi);
        if m * ramp(m) <= l { lo = m } else { hi = m }
    }
    2.0 * ramp(lo)
}

/// The blocks of a program, each from rest to rest at its optimum, at no more than its programmed speed [s].
pub fn rest_to_rest(program: &Program<6>) -> f64 {
    let mut from = [0.0; 6];
    let mut sum = 0.0;
    for (target, duration) in &program.blocks {
        let slowest = |limit: &[f32; 6]| {
            (0..6)
                .map(|i| f64::from(limit[i]) / (target[i] - from[i]).abs())
                .fold(f64::MAX, f64::min)
        };
        if *target != from {
            let programmed = match *duration {
                0.0 => f64::MAX,
                duration => 1.0 / f64::from(duration),
            };
            let limits = &program.limits;
            sum += optimum(
                1.0,
                slowest(limits.velocity()).min(programmed),
                slowest(limits.acceleration()),
                slowest(limits.jerk()),
            );
        }
        from = *target;
    }
    sum
}

/// A straight move from rest to rest, and what is the least along it: velocity, acceleration and jerk as shares of its way.
pub struct Single {
    pub program: Program<6>,
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
}

impl Single {
    /// One of random direction and limits, `share` of 2 a^3/j^2 long; `None` if that is less than half a step.
    pub fn random(r: &mut Random, share: f64) -> Option<Self> {
        let limits = random_limits(r);
        let way = [0; 6].map(|_| r.between(-1.0, 1.0));
        let slowest = |limit: &[f32; 6], way: &[f64; 6]| {
            (0..6)
                .map(|i| f64::from(limit[i]) / way[i].abs())
                .fold(f64::MAX, f64::min)
        };
        let (a, j) = (
            slowest(limits.acceleration(), &way),
            slowest(limits.jerk(), &way),
        );
        let l = share * 2.0 * a * a * a / j / j;
        let target = way.map(|t| (t * l).round());
        if target == [0.0; 6] {
            return None;
        }
        // Along the straight line to the whole steps.
        let way = target;
        Some(Self {
            program: Program {
                limits,
                path: PathSetting::new([0.003; 6], 0.01).unwrap(),
                blocks: vec![(target, 0.0)],
            },
            velocity: slowest(limits.velocity(), &way),
            acceleration: slowest(limits.acceleration(), &way),
            jerk: slowest(limits.jerk(), &way),
        })
    }

    /// The time-optimal jerk-limited profile's time, by another hand [s].
    pub fn best(&self) -> f64 {
        let mut input = InputParameter::<1>::new(None);
        input.target_position[0] = 1.0;
        input.max_velocity[0] = self.velocity;
        input.max_acceleration[0] = self.acceleration;
        input.max_jerk[0] = self.jerk;
        let mut trajectory = Trajectory::<1>::new(None);
        Ruckig::<1, ThrowErrorHandler>::new(None, 0.001)
            .calculate(&input, &mut trajectory)
            .unwrap();
        trajectory.get_duration()
    }
}

/// Forty short blocks with sharp corners, in all joints.
pub fn zigzag(seed: u64, tolerance: f32) -> Program<6> {
    let mut r = Random::new(seed + 77);
    let limits = random_limits(&mut r);
    let size = r.scale(30.0, 20_000.0);
    let mut q = [0.0f64; 6];
    let blocks = (0..40)
        .map(|_| {
            for x in &mut q {
                *x += r.between(-size, size);
            }
            (q.map(f64::round), 0.0)
        })
        .collect();
    Program {
        limits,
        path: PathSetting::new([1.0 / 320.0; 6], tolerance).unwrap(),
        blocks,
    }
}

/// Time of samples from rest to rest [s].
pub fn time(samples: &[[f64; 6]]) -> f64 {
    (samples.len() - 1) as f64 * 1e-3
}
