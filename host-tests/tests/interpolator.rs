//! The step interrupt's arithmetic against the rule of the paper, and the books of the foreground against both.

use fixed::types::I32F32;
use hexstep::stepper::{
    CountError, CountLine, Interpolator, Preset, Rule, SegmentQueue, Segmenter, Shared, StepMode,
    StepPort, StepTimer, Timing,
};
use proptest::prelude::*;

const HZ: u32 = 168_000_000;

/// Remembers what the pins did, tick by tick, with the time of the tick.
#[derive(Default)]
struct Pins {
    mode: StepMode,
    now: u64,
    period: u64,
    tick: u64,
    levels: u32,
    directions: u32,
    /// (time, tick, motor, negative), and the length of the tick before
    steps: Vec<(u64, u64, usize, bool)>,
    lengths: Vec<u64>,
    length: u64,
    /// (time, tick, motors that changed)
    turns: Vec<(u64, u64, u32)>,
    ends: Vec<(u64, usize)>,
}

impl StepPort for Pins {
    fn emit(&mut self, levels: u32) {
        let changed = levels ^ self.levels;
        let edges = match self.mode {
            StepMode::Pulse => changed & levels,
            StepMode::BothEdge => changed,
        };
        for motor in 0..8 {
            if edges >> motor & 1 != 0 {
                self.steps.push((
                    self.now,
                    self.tick,
                    motor,
                    self.directions >> motor & 1 != 0,
                ));
                self.lengths.push(self.length.max(self.period));
            }
            if self.mode == StepMode::Pulse && changed & !levels & 1 << motor != 0 {
                self.ends.push((self.now, motor));
            }
        }
        self.levels = levels;
    }
    fn direct(&mut self, directions: u32) {
        self.turns
            .push((self.now, self.tick, directions ^ self.directions));
        self.directions = directions;
    }
}

struct Timer(u64);
impl StepTimer for Timer {
    fn set_period(&mut self, counts: u32) {
        self.0 = counts.into();
    }
}

/// One interpolator with its pins: the smallest board there is.
struct Bench<'a, const N: usize> {
    interpolator: Interpolator<'a, N>,
    pins: Pins,
    timer: Timer,
}

impl<const N: usize> Bench<'_, N> {
    /// As SysTick does it: the period written now counts from the wrap after the next one.
    fn tick(&mut self) {
        self.interpolator.tick(&mut self.pins, &mut self.timer);
        self.pins.now += self.pins.period;
        self.pins.length = self.pins.period;
        self.pins.period = self.timer.0;
        self.pins.tick += 1;
    }
}

/// Gives `body` a segmenter, the sending end of a queue and a bench on the other end.
fn with_bench<const N: usize, R>(
    timing: Timing,
    shared: &Shared,
    body: impl FnOnce(
        &mut Segmenter<N>,
        &mut hexstep::stepper::SegmentSender<'_, N>,
        &mut Bench<'_, N>,
    ) -> R,
) -> R {
    let mut queue = SegmentQueue::<N>::new();
    let (mut sender, receiver) = queue.split();
    let mut segmenter = Segmenter::<N>::new(timing);
    let mut bench = Bench {
        interpolator: Interpolator::new(receiver, shared, timing.mode, timing.floor_period),
        pins: Pins {
            mode: timing.mode,
            period: timing.floor_period.into(),
            ..Pins::default()
        },
        timer: Timer(timing.floor_period.into()),
    };
    body(&mut segmenter, &mut sender, &mut bench)
}

fn timing(mode: StepMode) -> Timing {
    Timing::from_ns(HZ, 2000, 5000, 5000, mode)
}

/// Runs a line of counts to its end; returns the step masks of the line's own ticks, and the end positions.
fn run_line<const N: usize>(line: CountLine<N>, timing: Timing) -> (Vec<u8>, [i32; N], Pins) {
    let shared = Shared::new();
    let mut line = line;
    let (ticks, period) = (line.ticks(), line.period());
    with_bench::<N, _>(timing, &shared, |segmenter, sender, bench| {
        while !line.feed(segmenter, sender) {
            bench.tick();
        }
        while !sender.is_empty() {
            bench.tick();
        }
        for _ in 0..3 {
            bench.tick();
        }
        assert_eq!(shared.starved(), 0);
        let pins = std::mem::take(&mut bench.pins);
        let mut masks = vec![0u8; ticks as usize];
        // The queue was filled before tick 0, so the preset's ticks come first; what a tick computes, the next puts out.
        let first = u64::from(timing.setup.div_ceil(period).max(1)) + 1;
        for (_, tick, motor, _) in &pins.steps {
            masks[(tick - first) as usize] |= 1 << motor;
        }
        (masks, segmenter.counts(), pins)
    })
}

#[test]
fn the_worked_example_of_the_paper_steps_as_printed() {
    let m = [7, 3, -5, 1, 0, 2];
    let columns: Vec<u8> = Rule::new(&m, 0, Preset::Published).unwrap().collect();

    let row = |motor: usize| columns.iter().map(|c| c >> motor & 1).collect::<Vec<_>>();
    assert_eq!(row(0), [1, 1, 1, 1, 1, 1, 1]);
    assert_eq!(row(1), [0, 1, 0, 1, 0, 1, 0]);
    assert_eq!(row(2), [1, 1, 0, 1, 1, 1, 0]);
    assert_eq!(row(3), [0, 0, 0, 0, 0, 1, 0]);
    assert_eq!(row(4), [0; 7]);
    assert_eq!(row(5), [0, 0, 1, 0, 0, 1, 0]);
}

#[test]
fn the_rule_refuses_counts_beyond_its_range() {
    assert!(Rule::new(&[i64::MIN], 0, Preset::Published).is_none());
    assert!(Rule::new(&[1 << 62], 0, Preset::Published).is_some());
    assert!(Rule::new(&[(1 << 62) + 1], 0, Preset::Published).is_none());
    assert!(Rule::new(&[5, 9], 8, Preset::Published).is_none());
    assert_eq!(Rule::new(&[0, 0], 0, Preset::Published).unwrap().count(), 0);
}

#[test]
fn the_rule_is_exact_closed_even_and_on_the_line() {
    for max in 1u64..60 {
        for r in 0..=max {
            for preset in [Preset::Published, Preset::Centred] {
                let mut rule = Rule::new(&[r as i64], max, preset).unwrap();
                let start = rule.accumulators()[0] as f64;
                let mut steps = Vec::new();
                for k in 1..=max {
                    if rule.next().unwrap() != 0 {
                        steps.push(k);
                    }
                    let deviation = steps.len() as f64 - (k * r) as f64 / max as f64;
                    let (lo, hi) = match preset {
                        Preset::Published => (-1.0 + r as f64 / max as f64, r as f64 / max as f64),
                        Preset::Centred => (-0.5, 0.5),
                    };
                    assert!(
                        deviation >= lo - 1e-12 && deviation <= hi + 1e-12,
                        "{r}/{max} at {k}"
                    );
                }
                assert_eq!(rule.next(), None);
                assert_eq!(steps.len() as u64, r, "exact");
                assert_eq!(rule.accumulators()[0] as f64, start, "closed");
                for pair in steps.windows(2) {
                    let gap = pair[1] - pair[0];
                    assert!(gap == max / r || gap == max.div_ceil(r), "even: {r}/{max}");
                }
            }
        }
    }
}

/// The carry form as the theorem states it, started at its own increment.
fn carry_form(r: u64, max: u64) -> impl Iterator<Item = bool> {
    let inc = (r << 32).div_ceil(max) as u32;
    let mut acc = inc;
    (0..max).map(move |_| {
        let (sum, carry) = acc.overflowing_add(inc);
        acc = sum;
        carry
    })
}

#[test]
fn the_carry_form_steps_when_the_rule_steps_for_every_small_move() {
    for max in 2u64..=200 {
        for r in 0..max {
            let rule = Rule::new(&[r as i64], max, Preset::Published)
                .unwrap()
                .map(|m| m != 0);
            assert!(rule.eq(carry_form(r, max)), "{r}/{max}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn the_carry_form_steps_when_the_rule_steps_up_to_16_bits(max in 2u64..=65535, share in 0.0f64..1.0) {
        let r = ((max as f64 * share) as u64).min(max - 1);
        let rule = Rule::new(&[r as i64], max, Preset::Published).unwrap().map(|m| m != 0);
        prop_assert!(rule.eq(carry_form(r, max)));
    }

    #[test]
    fn a_line_of_counts_steps_as_the_rule_oversampled(
        m in proptest::array::uniform6(-3000i32..3000),
        rate in 2_000u64..200_000,
        centred: bool,
        both_edge: bool,
    ) {
        let timing = timing(if both_edge { StepMode::BothEdge } else { StepMode::Pulse });
        let preset = if centred { Preset::Centred } else { Preset::Published };
        let largest = m.iter().map(|m| m.unsigned_abs()).max().unwrap() as u64;
        let duration = (largest * HZ as u64 / rate).max(1000);
        let line = CountLine::new(m, duration, preset, &timing, &[0; 6]).unwrap();
        let max = line.ticks() as u64;

        let (masks, counts, _) = run_line(line, timing);

        prop_assert_eq!(counts, m);
        let expected: Vec<u8> = Rule::new(&m.map(i64::from), max, preset).unwrap().collect();
        prop_assert_eq!(masks, expected);
    }
}

#[test]
fn one_six_and_eight_motors_run_their_lines_exactly() {
    fn check<const N: usize>(m: [i32; N]) {
        for mode in [StepMode::Pulse, StepMode::BothEdge] {
            let line =
                CountLine::new(m, 80_000_000, Preset::Published, &timing(mode), &[0; N]).unwrap();
            let (_, counts, pins) = run_line(line, timing(mode));
            assert_eq!(counts, m);
            let mut seen = [0i32; N];
            for (_, _, motor, negative) in pins.steps {
                seen[motor] += if negative { -1 } else { 1 };
            }
            assert_eq!(seen, m);
        }
    }
    check([-12_345]);
    check([7, 3, -5, 1, 0, 2]);
    check([100_000, 61_803, -38_197, 23_607, -14_590, 9_017]);
    check([1000, -999, 998, -997, 1, 0, -1, 500]);
}

#[test]
fn a_line_of_counts_is_refused_beyond_its_range_and_speed() {
    let t = timing(StepMode::Pulse);
    let line = |m, duration| {
        CountLine::new(m, duration, Preset::Published, &t, &[0; 2]).map(|l| l.ticks())
    };

    assert!(matches!(
        line([1 << 24, 0], 1 << 60),
        Err(CountError::OutOfRange { motor: 0, .. })
    ));
    assert!(matches!(
        line([0, i32::MIN], 1 << 60),
        Err(CountError::OutOfRange { motor: 1, .. })
    ));
    assert!(
        matches!(line([1000, 0], 1000), Err(CountError::TooFast { least }) if least == 2 * 1000 * 336)
    );
    assert!(matches!(
        line([1000, 0], 1 << 40),
        Err(CountError::TooSlow { .. })
    ));
    assert_eq!(line([0, 0], 5), Ok(0));
    let far = CountLine::new([1, 0], 1_000_000, Preset::Published, &t, &[i32::MAX, 0]);
    assert!(matches!(far, Err(CountError::Overflow { motor: 0 })));
}

/// A smooth seeded path of N motors with many reversals: sums of sines, in steps, sampled every millisecond.
struct Path<const N: usize> {
    parts: [[(f64, f64, f64); 3]; N],
    seconds: f64,
}

impl<const N: usize> Path<N> {
    fn seeded(seed: u64, top_rate: f64, seconds: f64) -> Self {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut random = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let parts = std::array::from_fn(|_| {
            std::array::from_fn(|_| {
                let w = 2.0 + 30.0 * random();
                (
                    top_rate * random() / 3.0 / w,
                    w,
                    std::f64::consts::TAU * random(),
                )
            })
        });
        Self { parts, seconds }
    }

    /// Steps at time t, eased in and out so that the path starts and ends at rest on whole steps.
    fn at(&self, t: f64) -> [f64; N] {
        let u = (t / self.seconds).clamp(0.0, 1.0);
        let ease = (1.0 - (2.0 * std::f64::consts::PI * u).cos()) / 2.0;
        self.parts.map(|parts| {
            parts
                .iter()
                .map(|(a, w, p)| a * (w * t + p).sin())
                .sum::<f64>()
                * ease
        })
    }
}

/// Runs commanded positions, one a millisecond, the last one at rest; returns the pins and the counts of the books.
fn run_samples<const N: usize>(
    timing: Timing,
    shared: &Shared,
    samples: usize,
    at: impl Fn(usize) -> [f64; N],
) -> (Pins, [i32; N]) {
    with_bench::<N, _>(timing, shared, |segmenter, sender, bench| {
        for k in 1..=samples {
            let q = at(k).map(I32F32::from_num);
            let mut tries = 0;
            loop {
                match segmenter.advance(&q, timing.hz / 1000, k == samples, sender) {
                    Ok(true) => break,
                    Ok(false) => tries += 1,
                    Err(_) => bench.tick(),
                }
                assert!(tries < 50, "never arrives");
            }
        }
        while !sender.is_empty() {
            bench.tick();
        }
        bench.tick();
        bench.tick();
        assert_eq!(shared.starved(), 0);
        (std::mem::take(&mut bench.pins), segmenter.counts())
    })
}

fn run_path<const N: usize>(path: &Path<N>, timing: Timing, shared: &Shared) -> Pins {
    let samples = (path.seconds * 1000.0) as usize;
    let (pins, counts) = run_samples(timing, shared, samples, |k| {
        path.at(k as f64 / 1000.0)
            .map(|q| if k == samples { 0.0 } else { q })
    });
    assert_eq!(counts, [0; N]);
    pins
}

/// Runs a path; checks every edge against the commanded polyline; returns the worst distance in ticks, and the share above
/// 1.15 ticks.
fn follow<const N: usize>(path: &Path<N>, timing: Timing) -> (f64, f64) {
    let millisecond = timing.hz / 1000;
    let samples = (path.seconds * 1000.0) as usize;
    let pins = run_path(path, timing, &Shared::new());
    let at = |k: usize| {
        if k == samples {
            [0.0; N]
        } else {
            path.at(k as f64 / 1000.0)
        }
    };
    let commanded: Vec<[f64; N]> = (0..=samples).map(at).collect();

    // The first segment is loaded in tick 0; what it computes there goes out one tick later.
    let mut count = [0i64; N];
    let mut worst = 0f64;
    let mut over = 0;
    let start = f64::from(timing.floor_period);
    for ((time, _, motor, negative), length) in pins.steps.iter().zip(&pins.lengths) {
        // The edge between count c and c + 1 lies at c + 1/2.
        let edge = if *negative {
            count[*motor] as f64 - 0.5
        } else {
            count[*motor] as f64 + 0.5
        };
        count[*motor] += if *negative { -1 } else { 1 };
        let t = (*time as f64 - start) / f64::from(millisecond);
        // Nearest crossing of the edge by the commanded polyline, looked for within two samples.
        let k = t.floor() as i64;
        let mut best = f64::INFINITY;
        for j in (k - 2).max(0)..(k + 3).min(samples as i64) {
            let (a, b) = (
                commanded[j as usize][*motor],
                commanded[j as usize + 1][*motor],
            );
            if (a - edge) * (b - edge) <= 0.0 && a != b {
                let crossing = j as f64 + (edge - a) / (b - a);
                best = best.min((t - crossing).abs());
            }
        }
        let tick = *length as f64 / f64::from(millisecond);
        let late = (best / tick).min(99.0);
        over += usize::from(late > 1.15);
        worst = worst.max(late);
    }
    assert_eq!(count, [0; N]);
    (worst, over as f64 / pins.steps.len().max(1) as f64)
}

/// A tick stands for the stretch of time that it begins, so an edge is up to one tick early; timer counts are whole,
/// which adds up to an eighth of a tick within a segment.
#[test]
fn every_edge_of_a_smooth_path_comes_within_a_tick_of_its_crossing() {
    for seed in 1..=6 {
        for (rate, bound) in [(30.0, 1.001), (400.0, 1.001), (3000.0, 1.15)] {
            let t = Timing::from_ns(HZ, 2000, 0, 0, StepMode::Pulse);
            let (worst, _) = follow(&Path::<6>::seeded(seed, rate, 1.0), t);
            assert!(worst <= bound, "seed {seed}, {rate} steps/s: {worst} ticks");
        }
    }
}

/// Millions of steps per second squared, and dozens of reversals: there a slow motor near its turning point is a
/// fraction of a thousandth of a step beside its line, which may be two ticks in time.
#[test]
fn a_violent_path_keeps_its_edges_within_two_ticks_and_nearly_all_within_one() {
    for seed in 1..=4 {
        for (rate, mode) in [
            (40_000.0, StepMode::Pulse),
            (200_000.0, StepMode::Pulse),
            (200_000.0, StepMode::BothEdge),
        ] {
            let t = Timing::from_ns(HZ, 2000, 0, 0, mode);
            let (worst, over) = follow(&Path::<6>::seeded(seed, rate, 1.0), t);
            assert!(
                worst <= 2.0 && over <= 1e-3,
                "seed {seed}, {rate} steps/s: {worst} ticks, {over} above 1.15"
            );
        }
    }
}

/// Holds every direction change to the times of the drivers, edge by edge; how many there were.
#[track_caller]
fn assert_direction_times(pins: &Pins, t: &Timing, case: &str) -> usize {
    let mut turned: [Option<u64>; 8] = [None; 8];
    let mut stepped: [Option<u64>; 8] = [None; 8];
    let mut turns = pins.turns.iter().peekable();
    let turn = |(at, _, changed): &(u64, u64, u32),
                turned: &mut [Option<u64>; 8],
                stepped: &[Option<u64>; 8]| {
        for i in (0..8).filter(|i| changed >> i & 1 != 0) {
            turned[i] = Some(*at);
            let held = stepped[i].map_or(u64::MAX, |s| at - s);
            assert!(
                held >= u64::from(t.hold.max(1)),
                "{case}: motor {i} held for {held} of {} counts",
                t.hold
            );
        }
    };
    for (time, _, motor, _) in &pins.steps {
        // A step of the same instant came first.
        while let Some(next) = turns.next_if(|t| t.0 < *time) {
            turn(next, &mut turned, &stepped);
        }
        let setup = turned[*motor].map_or(u64::MAX, |at| time - at);
        assert!(
            setup >= u64::from(t.setup),
            "{case}: motor {motor} set up for {setup} of {} counts",
            t.setup
        );
        stepped[*motor] = Some(*time);
    }
    for next in turns {
        turn(next, &mut turned, &stepped);
    }
    pins.turns.len()
}

/// Both ends of both settings, and between; below a tick, a few ticks, and one and two whole samples.
const DIRECTION_US: [u32; 5] = [0, 1, 24, 400, 1000];

#[test]
fn directions_are_set_up_before_and_held_after_every_step_of_a_violent_path() {
    fn check<const N: usize>(mode: StepMode, setup: u32, hold: u32) {
        let t = Timing::from_ns(HZ, 1000, setup * 1000, hold * 1000, mode);
        let mut turns = 0;
        for (seed, rate) in [(1, 30.0), (2, 3000.0), (3, 100_000.0), (4, 340_000.0)] {
            let case = format!("{N} motors, {mode:?}, {setup} + {hold} us, {rate} steps/s");

            // Ends at the counts that it began with, or the run fails.
            let pins = run_path(&Path::<N>::seeded(seed, rate, 1.0), t, &Shared::new());

            turns += assert_direction_times(&pins, &t, &case);
        }
        assert!(turns > 100);
    }
    for mode in [StepMode::Pulse, StepMode::BothEdge] {
        for setup in DIRECTION_US {
            for hold in DIRECTION_US {
                check::<6>(mode, setup, hold);
                check::<8>(mode, setup, hold);
            }
        }
    }
}

/// The worst for a wait that only knows its own segment: a motor turns round at next to no speed in long ticks, and the
/// next sample is fast, in short ones.
#[test]
fn a_wait_outlasts_its_segment_whatever_the_next_one_does() {
    for mode in [StepMode::Pulse, StepMode::BothEdge] {
        for (setup, hold) in [(900, 500), (1000, 1000), (400, 0), (24, 24), (0, 400)] {
            let t = Timing::from_ns(HZ, 1000, setup * 1000, hold * 1000, mode);
            for way in [1.0, 3.0, 40.0, 170.0] {
                let (mut q, samples) = ([0.0f64; 6], 400);
                let mut targets = Vec::new();
                for k in 0..samples {
                    let slow = k % 7 < 3;
                    for (i, q) in q.iter_mut().enumerate() {
                        let sign = if (k / 7 + i) % 2 == 0 { 1.0 } else { -1.0 };
                        // Motor 5 leads all the time, so that ticks are short although the others are slow.
                        let own = if i == 5 { 150.0 } else { way };
                        *q += sign * if slow && i != 5 { 0.6 } else { own };
                    }
                    targets.push(q);
                }
                targets.push(q.map(f64::round));

                let (pins, counts) =
                    run_samples::<6>(t, &Shared::new(), targets.len(), |k| targets[k - 1]);

                assert_eq!(counts.map(f64::from), q.map(f64::round));
                let case = format!("{mode:?}, {setup} + {hold} us, {way} steps a sample");
                assert!(assert_direction_times(&pins, &t, &case) > 20);
            }
        }
    }
}

#[test]
fn lines_of_counts_and_moves_between_them_keep_the_direction_times() {
    let mut state = 0x1234_5678_9ABC_DEF1_u64;
    let mut random = move |below: u64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 20) % below
    };
    for mode in [StepMode::Pulse, StepMode::BothEdge] {
        for setup in DIRECTION_US {
            for hold in DIRECTION_US {
                let t = Timing::from_ns(HZ, 2000, setup * 1000, hold * 1000, mode);
                let shared = Shared::new();
                with_bench::<6, _>(t, &shared, |segmenter, sender, bench| {
                    for _ in 0..30 {
                        let from = segmenter.counts();
                        let way: [i32; 6] = std::array::from_fn(|_| random(61) as i32 - 30);
                        let longest = way.iter().map(|m| m.unsigned_abs()).max().unwrap() as u64;
                        if random(4) == 0 {
                            let to = std::array::from_fn(|i| I32F32::from_num(from[i] + way[i]));
                            let mut tries = 0;
                            while segmenter.advance(&to, HZ / 1000, true, sender) != Ok(true) {
                                bench.tick();
                                tries += 1;
                                assert!(tries < 100_000, "never arrives");
                            }
                        } else {
                            // From the fastest to a tick at the floor.
                            let rate = [200_000, 90_000, 20_000, 1000][random(4) as usize];
                            let duration = longest * u64::from(HZ) / rate + 1;
                            let mut line =
                                CountLine::new(way, duration, Preset::Published, &t, &from)
                                    .unwrap();
                            while !line.feed(segmenter, sender) {
                                bench.tick();
                            }
                        }
                        if random(3) == 0 {
                            while !sender.is_empty() {
                                bench.tick();
                            }
                            (0..random(3)).for_each(|_| bench.tick());
                        }
                        assert_eq!(
                            segmenter.counts(),
                            std::array::from_fn(|i| from[i] + way[i])
                        );
                    }
                    while !sender.is_empty() {
                        bench.tick();
                    }
                    (0..5).for_each(|_| bench.tick());
                    assert_eq!(shared.starved(), 0);
                    let made: [i32; 6] = std::array::from_fn(|i| {
                        let own = bench.pins.steps.iter().filter(|s| s.2 == i);
                        own.map(|s| if s.3 { -1 } else { 1 }).sum()
                    });
                    assert_eq!(made, segmenter.counts());
                    let case = format!("{mode:?}, {setup} + {hold} us");
                    assert_direction_times(&bench.pins, &t, &case);
                });
            }
        }
    }
}

#[test]
fn a_pulse_is_one_tick_wide_and_never_shorter_than_the_step_pulse_time() {
    let t = Timing::from_ns(HZ, 2500, 0, 0, StepMode::Pulse);
    let pins = run_path(&Path::<6>::seeded(3, 190_000.0, 0.5), t, &Shared::new());

    assert!(pins.steps.len() > 1000);
    assert_eq!(pins.steps.len(), pins.ends.len());
    let mut open = [0; 6];
    let mut steps = pins.steps.iter().peekable();
    for (end, motor) in &pins.ends {
        while let Some((time, _, m, _)) = steps.next_if(|s| s.0 < *end) {
            open[*m] = *time;
        }
        assert!(end - open[*motor] >= u64::from(t.least_period));
    }
}

#[test]
fn the_leader_of_a_constant_speed_steps_evenly_and_its_equal_steps_with_it() {
    for rate in [57.3, 777.7, 12_345.6, 20_250.0, 60_000.1, 199_999.0] {
        for mode in [StepMode::Pulse, StepMode::BothEdge] {
            let shared = Shared::new();
            let t = Timing::from_ns(HZ, 2000, 0, 0, mode);
            let samples = 600;
            let (pins, counts) = run_samples::<6>(t, &shared, samples, |k| {
                let s = rate * k as f64 / 1000.0;
                let s = if k == samples { s.round() } else { s };
                [s, s, -s * 0.618, s * 0.1, 0.0, -s * 0.999]
                    .map(|q| if k == samples { q.round() } else { q })
            });

            assert_eq!(counts[0], counts[1]);
            let times = |m: usize| {
                pins.steps
                    .iter()
                    .filter(|s| s.2 == m)
                    .map(|s| s.0)
                    .collect::<Vec<_>>()
            };
            let (leader, equal) = (times(0), times(1));
            assert!(leader == equal, "equal motors in step at {rate}/s");
            // The first millisecond has no speed before it to be constant with, and the last ends exactly.
            let run = &leader[leader.len() / 50 + 2..leader.len() - leader.len() / 50 - 2];
            let gaps: Vec<f64> = run.windows(2).map(|w| (w[1] - w[0]) as f64).collect();
            let (lo, hi) = gaps
                .iter()
                .fold((f64::MAX, 0f64), |(lo, hi), g| (lo.min(*g), hi.max(*g)));
            assert!(hi / lo <= 1.01, "gaps {lo}..{hi} at {rate}/s, {mode:?}");
        }
    }
}

#[test]
fn a_dry_queue_in_motion_is_counted_and_one_at_rest_is_not() {
    let shared = Shared::new();
    with_bench::<6, _>(
        timing(StepMode::Pulse),
        &shared,
        |segmenter, sender, bench| {
            let q = [5; 6].map(I32F32::from_num);
            segmenter.advance(&q, 168_000, false, sender).unwrap();
            for _ in 0..100 {
                bench.tick();
            }
            assert_eq!(shared.starved(), 1);
        },
    );

    let shared = Shared::new();
    run_samples::<6>(timing(StepMode::Pulse), &shared, 3, |k| [k as f64; 6]);
    assert_eq!(shared.starved(), 0);
}

#[test]
fn a_latch_tells_the_positions_of_its_tick_and_a_stop_leaves_no_step_behind() {
    let shared = Shared::new();
    with_bench::<6, _>(
        timing(StepMode::Pulse),
        &shared,
        |segmenter, sender, bench| {
            for k in 1..=20 {
                let q =
                    [40.0, -33.0, 21.0, -7.5, 0.1, 12.0].map(|v| I32F32::from_num(v * k as f64));
                segmenter.advance(&q, 168_000, false, sender).unwrap();
            }
            for _ in 0..500 {
                bench.tick();
            }
            shared.latch();
            assert_eq!(shared.latched(), None);
            bench.tick();
            let latched = segmenter.positions_at(shared.latched().unwrap()).unwrap();
            let count = |pins: &Pins, motor| {
                let own = pins.steps.iter().filter(|s| s.2 == motor);
                own.map(|s| if s.3 { -1 } else { 1 }).sum::<i32>()
            };
            for i in 0..6 {
                // Steps put out up to and with this tick.
                assert_eq!(
                    (latched[i] + I32F32::from_num(0.5)).floor().to_num::<i32>(),
                    count(&bench.pins, i)
                );
            }

            shared.stop();
            bench.tick();
            assert!(shared.is_halted());
            let stopped = shared.latched().unwrap();
            let steps = bench.pins.steps.len();
            while !sender.is_empty() {
                bench.tick();
            }
            shared.release();
            segmenter.recover(stopped, sender).unwrap();
            for _ in 0..5 {
                bench.tick();
            }
            assert_eq!(bench.pins.steps.len(), steps, "no step after the stop");
            let counts = segmenter.counts();
            for i in 0..6 {
                assert_eq!(counts[i], count(&bench.pins, i));
            }

            let home = [I32F32::ZERO; 6];
            while !segmenter.advance(&home, 1_680_000, true, sender).unwrap() {}
            for _ in 0..5000 {
                bench.tick();
            }
            for i in 0..6 {
                assert_eq!(count(&bench.pins, i), 0, "motor {i} is back");
            }
        },
    );
}
