//! The planner judged by what it commands: limits, contour, time, ends, holds, overrides, stops.

use fixed::types::I32F32;
use hexstep::planner::{Limits, PathSetting, Planner, Sample};

/// xorshift64*, seeded.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }
    /// 0 .. 1
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }
    /// Evenly over orders of magnitude.
    fn scale(&mut self, lo: f64, hi: f64) -> f64 {
        (self.between(lo.ln(), hi.ln())).exp()
    }
    fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

#[derive(Clone)]
struct Program<const N: usize> {
    limits: Limits<N>,
    path: PathSetting<N>,
    /// Targets [steps] with least durations [s].
    blocks: Vec<([i32; N], f32)>,
}

/// What is asked of the planner while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    Hold,
    Resume,
    Feed(f32),
    Rapid(f32),
    Stop,
    Trim(usize, i32),
}

/// Runs a program to its end; events at given samples. Pushes whenever there is room.
fn run<const N: usize>(program: &Program<N>, events: &[(usize, Event)]) -> (Vec<[f64; N]>, Planner<N>) {
    let mut planner = Planner::new(program.limits, [0; N]);
    planner.set_path(program.path).unwrap();
    let samples = go_on(&mut planner, program, events);
    (samples, planner)
}

fn go_on<const N: usize>(planner: &mut Planner<N>, program: &Program<N>, events: &[(usize, Event)]) -> Vec<[f64; N]> {
    let mut blocks = program.blocks.iter().peekable();
    let mut events = events.iter().peekable();
    let mut samples = vec![planner.position().map(|p| p.to_num::<f64>())];
    let mut stopped = false;
    loop {
        while let Some((target, duration)) = blocks.peek() {
            if stopped || planner.push(*target, *duration).is_err() {
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
            }
        }
        match planner.next() {
            Some(Sample { position, .. }) => {
                samples.push(position.map(|p: I32F32| p.to_num::<f64>()))
            }
            None if planner.is_held() => match events.peek() {
                // Time passes while it is held.
                Some(_) => samples.push(*samples.last().unwrap()),
                None => planner.resume(),
            },
            None => break,
        }
        assert!(samples.len() < 4_000_000, "never ends: {} blocks left", planner.len());
    }
    samples
}

/// Largest velocity, acceleration and jerk as shares of the limits, by differences of the samples.
fn shares<const N: usize>(samples: &[[f64; N]], limits: &Limits<N>) -> [f64; 3] {
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

/// Largest weighted distance of the samples from the polygon [mm], following it forward.
fn contour<const N: usize>(samples: &[[f64; N]], program: &Program<N>) -> f64 {
    let w = program.path.weight().map(f64::from);
    let mut vertices = vec![[0.0; N]];
    vertices.extend(program.blocks.iter().map(|b| b.0.map(|p| f64::from(p) )));
    for v in &mut vertices {
        for i in 0..N {
            v[i] *= w[i];
        }
    }
    let distance = |p: &[f64; N], k: usize| {
        let (a, b) = (&vertices[k], &vertices[k + 1]);
        let (mut along, mut length) = (0.0, 0.0);
        for i in 0..N {
            along += (p[i] - a[i]) * (b[i] - a[i]);
            length += (b[i] - a[i]) * (b[i] - a[i]);
        }
        let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
        let mut sum = 0.0;
        for i in 0..N {
            let d = p[i] - a[i] - t * (b[i] - a[i]);
            sum += d * d;
        }
        sum.sqrt()
    };
    let mut worst = 0.0f64;
    let mut at = 0usize;
    for s in samples {
        let mut p = *s;
        for i in 0..N {
            p[i] *= w[i];
        }
        let window = at.saturating_sub(3)..(at + 120).min(vertices.len() - 1);
        let (best, k) = window
            .map(|k| (distance(&p, k), k))
            .fold((f64::MAX, at), |m, x| if x.0 < m.0 - 1e-12 { x } else { m });
        at = k.max(at);
        worst = worst.max(best);
    }
    worst
}

fn random_limits(r: &mut Random) -> Limits<6> {
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
fn random_program(seed: u64) -> Program<6> {
    let mut r = Random::new(seed);
    let limits = random_limits(&mut r);
    let mut weight = [0.0; 6];
    for w in &mut weight {
        *w = r.scale(0.0005, 0.02) as f32;
    }
    let tolerance = [0.0, 0.003, 0.01, 0.03, 0.3][r.below(5)];
    let path = PathSetting::new(weight, tolerance).unwrap();
    let count = 2 + r.scale(1.0, 499.0) as usize;
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
            feed = if r.unit() < 0.4 { 0.0 } else { r.scale(0.02, 1.5) };
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
        q = q.map(|x| x.round());
        // Duration from the slowest joint's rated time.
        let rated = (0..6).map(|i| (q[i] - before[i]).abs() / f64::from(limits.velocity()[i])).fold(0.0, f64::max);
        let duration = if feed > 0.0 { rated / feed } else { 0.0 };
        blocks.push((q.map(|x| x as i32), duration as f32));
    }
    Program { limits, path, blocks }
}

#[test]
fn probe_figures() {
    let mut hist = [[0u32; 4]; 3];
    let mut squeezed = 0;
    for seed in 1..=300 {
        let program = random_program(seed);
        let (samples, planner) = run(&program, &[]);
        let s = shares(&samples, &program.limits);
        let e = contour(&samples, &program);
        let step = program.path.weight().iter().map(|w| f64::from(w * w)).sum::<f64>().sqrt();
        let end = program.blocks.last().unwrap().0.map(f64::from);
        squeezed += planner.counters().squeezed;
        let ok = *samples.last().unwrap() == end;
        for k in 0..3 { hist[k][if s[k] <= 1.001 { 0 } else if s[k] <= 1.02 { 1 } else if s[k] <= 1.1 { 2 } else { 3 }] += 1; }
        if !ok || s[0] > 1.02 || s[1] > 1.02 || s[2] > 1.1 || e > f64::from(program.path.tolerance()) + 0.5 * step {
            println!("seed {seed}: n {} v {:.3} a {:.3} j {:.3} tol {} err {:.5} step {:.4} end {ok} samples {} {:?}", program.blocks.len(), s[0], s[1], s[2], program.path.tolerance(), e, step, samples.len(), planner.counters());
        }
    }
    println!("{hist:?} squeezed {squeezed}");
}

#[test]
fn probe_events() {
    let (mut worst, mut bad) = ([0.0f64; 3], 0);
    let mut squeezed = 0;
    for seed in std::env::var("SEEDS").map(|s| s.split(',').map(|x| x.parse().unwrap()).collect::<Vec<u64>>()).unwrap_or((1..=250).collect()) {
        let mut r = Random::new(seed + 1000);
        let mut program = random_program(seed);
        program.blocks.truncate(120);
        let (plain, _) = run(&program, &[]);
        let mut events = Vec::new();
        let mut at = 0;
        let stop = seed % 5 == 0;
        for _ in 0..r.below(12) {
            at += r.below(1 + plain.len() / 3);
            match r.below(3) {
                0 => {
                    events.push((at, Event::Hold));
                    at += r.below(300);
                    events.push((at, Event::Resume));
                }
                1 => events.push((at, Event::Feed(r.between(0.1, 2.0) as f32))),
                _ => events.push((at, Event::Rapid(r.between(0.1, 1.0) as f32))),
            }
        }
        if stop {
            events.push((at, Event::Stop));
        }
        let (samples, planner) = run(&program, &events);
        let s = shares(&samples, &program.limits);
        let e = contour(&samples, &program);
        let step = program.path.weight().iter().map(|w| f64::from(w * w)).sum::<f64>().sqrt();
        let end = program.blocks.last().unwrap().0.map(f64::from);
        let ok = if stop { samples.last().unwrap().iter().all(|x| x.fract() == 0.0) } else { *samples.last().unwrap() == end };
        if planner.counters().squeezed > 0 { println!("seed {seed} squeezed {} worst {s:?}", planner.counters().squeezed); }
        squeezed += planner.counters().squeezed;
        for k in 0..3 { worst[k] = worst[k].max(s[k]); }
        if !ok || s[0] > 1.02 || s[1] > 1.02 || s[2] > 1.1 || e > f64::from(program.path.tolerance()) + 0.5 * step {
            bad += 1;
            println!("seed {seed}: n {} v {:.3} a {:.3} j {:.3} tol {} err {:.5} step {:.4} end {ok} samples {} {:?}", program.blocks.len(), s[0], s[1], s[2], program.path.tolerance(), e, step, samples.len(), planner.counters());
        }
    }
    println!("events: worst {worst:?} bad {bad} squeezed {squeezed}");
}

/// Least time of a jerk-limited move over `l` from rest to rest.
fn optimum(l: f64, v: f64, a: f64, j: f64) -> f64 {
    let ramp = |v: f64| if v * j < a * a { 2.0 * (v / j).sqrt() } else { v / a + a / j };
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

fn program_optimum(program: &Program<6>) -> f64 {
    let mut q = [0.0; 6];
    let mut sum = 0.0;
    for (t, d) in &program.blocks {
        let (mut v, mut a, mut j) = (f64::MAX, f64::MAX, f64::MAX);
        for i in 0..6 {
            let m = (f64::from(t[i]) - q[i]).abs();
            if m > 0.0 {
                v = v.min(f64::from(program.limits.velocity()[i]) / m);
                a = a.min(f64::from(program.limits.acceleration()[i]) / m);
                j = j.min(f64::from(program.limits.jerk()[i]) / m);
            }
        }
        if *d > 0.0 {
            v = v.min(1.0 / f64::from(*d));
        }
        if v < f64::MAX {
            sum += optimum(1.0, v, a, j);
        }
        q = t.map(f64::from);
    }
    sum
}

#[test]
fn probe_times() {
    // Single moves.
    let mut r = Random::new(5);
    for share in [0.1, 0.2, 0.5, 1.0, 2.0, 10.0] {
        let (mut worst, mut ms) = (0.0f64, 0.0f64);
        for _ in 0..40 {
            let limits = random_limits(&mut r);
            let target = [0; 6].map(|_| r.between(-1.0, 1.0));
            let (mut a, mut j) = (f64::MAX, f64::MAX);
            for i in 0..6 {
                a = a.min(f64::from(limits.acceleration()[i]) / target[i].abs());
                j = j.min(f64::from(limits.jerk()[i]) / target[i].abs());
            }
            let l = share * 2.0 * a * a * a / j / j;
            let target = target.map(|t| (t * l).round() as i32);
            let path = PathSetting::new([0.003; 6], 0.01).unwrap();
            let program = Program { limits, path, blocks: vec![(target, 0.0)] };
            let (samples, _) = run(&program, &[]);
            let best = program_optimum(&program);
            let t = (samples.len() - 1) as f64 * 1e-3;
            worst = worst.max((t - 1e-3) / best);
            ms = ms.max(t - best);
        }
        println!("single {share}: worst {worst:.4} (less one sample), {ms:.5} s over");
    }
    // Zigzags.
    for tolerance in [0.003, 0.01, 0.03, 0.1, 0.3] {
        let (mut worst, mut gain) = (0.0f64, 0.0);
        let mut out = String::new();
        for seed in 1..=30 {
            let mut r = Random::new(seed + 77);
            let limits = random_limits(&mut r);
            let path = PathSetting::new([1.0 / 320.0; 6], tolerance).unwrap();
            let size = r.scale(30.0, 20_000.0);
            let mut q = [0.0f64; 6];
            let blocks = (0..60).map(|_| {
                for x in &mut q { *x += r.between(-size, size); }
                (q.map(|x| x.round() as i32), 0.0)
            }).collect();
            let program = Program { limits, path, blocks };
            let (samples, p) = run(&program, &[]);
            let best = program_optimum(&program);
            let t = (samples.len() - 1) as f64 * 1e-3;
            if t / best > 0.98 { out += &format!(" {seed}:{:.3} size {size:.0} {t:.3}s;", t / best); }
            worst = worst.max(t / best);
            gain += best / t / 30.0;
            assert_eq!(p.counters().squeezed, 0);
        }
        println!("zigzag {tolerance}: worst {worst:.4} mean gain {gain:.3} {out}");
    }
    // Circle of 10 000 chords, r 50 mm at 320 steps/mm.
    for (feed, a, j, tol) in [(50.0, 3000.0, 1e5, 0.01), (100.0, 3000.0, 1e5, 0.01), (200.0, 3000.0, 2e5, 0.01), (100.0, 1000.0, 3e4, 0.01), (100.0, 3000.0, 1e5, 0.003), (100.0, 3000.0, 1e5, 0.05)] {
        let spm = 320.0;
        let limits = Limits::new([400.0 * spm as f32; 6], [a * spm as f32; 6], [j * spm as f32; 6]).unwrap();
        let path = PathSetting::new([1.0 / 320.0; 6], tol).unwrap();
        let n = 10_000;
        let radius = 50.0 * spm;
        let chord = 2.0 * std::f64::consts::PI * 50.0 / n as f64;
        let blocks = (1..=n).map(|k| {
            let t = k as f64 / n as f64 * 2.0 * std::f64::consts::PI;
            let q = [radius * (t.cos() - 1.0), radius * t.sin(), 0.0, 0.0, 0.0, 0.0];
            (q.map(|x: f64| x.round() as i32), (chord / feed) as f32)
        }).collect();
        let program = Program { limits, path, blocks };
        let (samples, p) = run(&program, &[]);
        let t = (samples.len() - 1) as f64 * 1e-3;
        let length = 2.0 * std::f64::consts::PI * 50.0;
        let ideal = length / feed + feed / f64::from(a) + f64::from(a) / f64::from(j);
        println!("circle feed {feed} a {a} j {j} tol {tol}: {:.4} shares {:?} contour {:.5} {:?}", t / ideal, shares(&samples, &limits), contour(&samples, &program), p.counters());
    }
    println!("size {}", std::mem::size_of::<Planner<6>>());
}
