//! A trace -> what each motor did, beside what it may do: a table, and charts over time.

use super::{Cell, Report};
use crate::job::{AxisLimits, MOTORS, unit};
use crate::plot::{Chart, Waves, colour, number};
use crate::trace::{Change, Motion, MotorStatistics, TICK_HZ, Trace, seconds};
use hexstep::stepper::Timing;

/// What is to be shown of a motor, and in which unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    pub name: String,
    /// `"mm"`, `"deg"` or `"steps"`.
    pub unit: &'static str,
    pub steps_per_unit: f64,
    /// [steps/s], [steps/s2] and [steps/s3], where there is a limit.
    pub largest_rate: Option<f64>,
    pub largest_acceleration: Option<f64>,
    pub largest_jerk: Option<f64>,
}

impl Channel {
    /// The motors of a job, with the limits of its `[machine]`.
    pub fn of_axes(axes: &[AxisLimits; 6]) -> [Self; 6] {
        std::array::from_fn(|motor| {
            let axis = &axes[motor];
            let steps = axis.steps_per_unit;
            Self {
                name: MOTORS[motor].into(),
                unit: unit(motor),
                steps_per_unit: steps,
                largest_rate: Some(axis.max_rate * steps),
                largest_acceleration: Some(axis.acceleration * steps),
                largest_jerk: Some(axis.jerk * steps),
            }
        })
    }
}

/// What the trace says of one motor.
#[derive(Clone, Debug)]
pub struct MotorFigures {
    pub channel: Channel,
    pub statistics: MotorStatistics,
    pub motion: Motion,
    /// Largest values rebuilt over the window [steps/s], [steps/s2] and [steps/s3].
    pub rate: f64,
    pub acceleration: f64,
    pub jerk: f64,
}

/// The figures of all motors, and those of the pulses themselves.
#[derive(Clone, Debug)]
pub struct Motors {
    pub figures: Vec<MotorFigures>,
    /// Window over which speeds and accelerations were rebuilt [s].
    pub window: f64,
    /// Half steps that a motor may be from where its last pulse leaves it: one, or two where it may rest between steps.
    pub half_steps: f64,
}

/// What says that limits count as kept although a value lies above them.
pub const ALLOWED: &str = "Where a motor starts, stops or turns, its first pulse tells of half a step at once; \
    acceleration and jerk are judged with what that can look like in the window, which is less the finer the steps are. \
    Limits count as kept within 2 %, jerk, which corners may have, within 10 %, and half a step on top, a whole one where \
    motors may rest between steps: a value above its limit stands beside what is allowed.";

/// A limit counts as kept within this share of it: 2 % (motion.md), and 10 % for jerk, which corners may have.
pub const TOLERANCE: f64 = 1.02;
pub const JERK_TOLERANCE: f64 = 1.10;

/// Where a motor starts, stops or turns, its first edge tells of half a step at once. Within a window w of there, what
/// the fit makes of half a step is not told from motion: so many steps / w^2 of acceleration (3 · 5/2 · 4 times half a
/// step times the largest integral of the second Legendre polynomial, 1/sqrt 27), and steps / w^3 of jerk
/// (15 · 7/2 · 8 times half a step times 1/8 from the third).
const HALF_STEP_ACCELERATION: f64 = 2.9;
const HALF_STEP_JERK: f64 = 26.3;

/// What can be read off a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    Position,
    Speed,
    Acceleration,
    Jerk,
}

impl Quantity {
    pub const ALL: [Self; 4] = [Self::Position, Self::Speed, Self::Acceleration, Self::Jerk];

    /// Its list of a motion.
    pub(super) fn of(self, motion: &Motion) -> &[f64] {
        match self {
            Self::Position => &motion.position,
            Self::Speed => &motion.speed,
            Self::Acceleration => &motion.acceleration,
            Self::Jerk => &motion.jerk,
        }
    }

    /// Its name, and what follows the joint's unit.
    fn told(self) -> (&'static str, &'static str) {
        match self {
            Self::Position => ("position", ""),
            Self::Speed => ("speed", "/s"),
            Self::Acceleration => ("acceleration", "/s²"),
            Self::Jerk => ("jerk", "/s³"),
        }
    }
}

/// What is judged of a motor by its limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Limited {
    /// Steps over [`RATE_GAPS`](crate::trace::RATE_GAPS) gaps.
    Rate,
    Speed,
    Acceleration,
    Jerk,
}

impl Limited {
    const ALL: [Self; 4] = [Self::Rate, Self::Speed, Self::Acceleration, Self::Jerk];

    /// The largest value and its limit [steps, s].
    fn of(self, f: &MotorFigures) -> (f64, Option<f64>) {
        let c = &f.channel;
        match self {
            Self::Rate => (f.statistics.largest_rate, c.largest_rate),
            Self::Speed => (f.rate, c.largest_rate),
            Self::Acceleration => (f.acceleration, c.largest_acceleration),
            Self::Jerk => (f.jerk, c.largest_jerk),
        }
    }

    fn quantity(self) -> Quantity {
        match self {
            Self::Rate | Self::Speed => Quantity::Speed,
            Self::Acceleration => Quantity::Acceleration,
            Self::Jerk => Quantity::Jerk,
        }
    }

    fn digits(self) -> usize {
        match self {
            Self::Rate | Self::Speed => 2,
            Self::Acceleration | Self::Jerk => 0,
        }
    }
}

/// A window for motors with these limits [s]: shorter than the ramps of acceleration of those that move, which it would
/// round off, but as long as can be, for the noise of the jerk falls with its third power.
pub fn window_for<const N: usize>(axes: &[AxisLimits; N], moves: [bool; N]) -> f64 {
    let rises = axes.iter().zip(moves).filter(|(_, moves)| *moves);
    let shortest = rises.map(|(axis, _)| axis.acceleration / axis.jerk);
    (0.6 * shortest.fold(f64::INFINITY, f64::min)).clamp(0.01, 0.04)
}

/// How a run ended, in a line of a summary.
pub fn told_end(is_exact: bool, starved: u32) -> String {
    let end = if is_exact {
        "every motor exactly at its commanded count"
    } else {
        "MOTORS NOT AT THEIR COMMANDED COUNTS"
    };
    format!("end      {end}; queue ran dry {starved} times")
}

/// The same in a table.
pub fn end_cell(is_exact: bool) -> Cell {
    if is_exact {
        "every motor exactly at its commanded count".into()
    } else {
        Cell::Judged("motors not at their commanded counts".into(), false)
    }
}

impl Motors {
    pub fn told_steps(&self, ticks: u64) -> String {
        let (steps, ticks) = (number(self.steps() as f64, 0), number(ticks as f64, 0));
        format!("{steps} in {ticks} ticks")
    }

    /// What was put out, and how fast it was simulated in `wall` [s], in a line of a summary.
    pub fn told_pulses(&self, ticks: u64, wall: f64) -> String {
        format!(
            "pulses   {} steps in {} ticks; simulated in {wall:.2} s, {:.1} million ticks/s",
            number(self.steps() as f64, 0),
            number(ticks as f64, 0),
            ticks as f64 / wall / 1e6
        )
    }

    /// The pins where most motors of a stretch of time [s] step, counts, and the least times at the pins.
    pub fn pulse_section<const N: usize>(
        &self,
        report: &mut Report,
        trace: &Trace<N>,
        names: &[String; N],
        (first, last): (f64, f64),
        timing: &Timing,
    ) {
        report.section("Pulses");
        let from = busiest(trace, first, last);
        report.figure(
            &pulse_trains(trace, names, "Pins", from, from + MILLISECOND),
            "A millisecond in which as many motors step as in any that was looked at. All pins of a tick change together.",
        );
        self.counts_table(report);
        self.timing_table(report, timing.least_period, timing.setup, timing.hold);
    }

    /// A table of all motors for a summary: steps, end, and the largest values beside their limits; `first` heads it.
    pub fn limits_in_lines(&self, first: &str) -> Vec<String> {
        let mut lines = vec![format!(
            "{first:<10}{:>12}{:>12}{:>26}{:>26}{:>28}",
            "steps", "end", "speed of limit /s", "acceleration", "jerk"
        )];
        for f in &self.figures {
            let (c, s) = (&f.channel, &f.statistics);
            let scale = c.steps_per_unit;
            let beside = |value: f64, limit: Option<f64>, digits: usize| {
                // As it was written in the job: without the rounding of the way here.
                let limit = (limit.unwrap_or(0.0) / scale * 1e9).round() / 1e9;
                format!("{:.digits$} of {limit} {}", value / scale, c.unit)
            };
            let over = if self.keeps_limits(f) { "" } else { "  OVER" };
            lines.push(format!(
                "{:<10}{:>12}{:>12}{:>26}{:>26}{:>28}{over}",
                c.name,
                s.steps(),
                s.position,
                beside(f.rate, c.largest_rate, 2),
                beside(f.acceleration, c.largest_acceleration, 0),
                beside(f.jerk, c.largest_jerk, 0),
            ));
        }
        lines
    }

    /// Reads the trace twice: for the statistics, and for the motions.
    pub fn of<const N: usize>(trace: &Trace<N>, channels: &[Channel; N], window: f64) -> Self {
        let statistics = trace.statistics();
        let motions = Motion::rebuild_all(trace, window).into_iter().enumerate();
        let figures = motions.map(|(motor, motion)| MotorFigures {
            channel: channels[motor].clone(),
            statistics: statistics[motor],
            rate: Motion::largest(&motion.speed),
            acceleration: Motion::largest(&motion.acceleration),
            jerk: Motion::largest(&motion.jerk),
            motion,
        });
        Self {
            figures: figures.collect(),
            window,
            half_steps: 1.0,
        }
    }

    /// Steps of all motors.
    pub fn steps(&self) -> u64 {
        self.figures.iter().map(|f| f.statistics.steps()).sum()
    }

    /// Counts, range, gaps.
    pub fn counts_table(&self, report: &mut Report) {
        let rows: Vec<Vec<Cell>> = self
            .figures
            .iter()
            .map(|f| {
                let s = &f.statistics;
                let scale = f.channel.steps_per_unit;
                let range = format!(
                    "{} … {} {}",
                    number(s.lowest as f64 / scale, 3),
                    number(s.highest as f64 / scale, 3),
                    f.channel.unit
                );
                vec![
                    Cell::Text(f.channel.name.clone()),
                    whole(s.forward as i64),
                    whole(s.backward as i64),
                    whole(s.position),
                    Cell::Number(range),
                    whole(s.reversals as i64),
                    microseconds(s.least_gap),
                ]
            })
            .collect();
        report.table(
            "Steps",
            &[
                "motor",
                "forward",
                "backward",
                "end",
                "range",
                "reversals",
                "least gap [µs]",
            ],
            &rows,
        );
    }

    /// Rates and accelerations beside their limits.
    pub fn limits_table(&self, report: &mut Report) {
        let beside = |f: &MotorFigures, limited: Limited, scale: f64, digits: usize| {
            let (value, limit) = limited.of(f);
            let told = |value: f64| number(value / scale, digits);
            match (limit, self.allowed(f, limited)) {
                (Some(limit), Some(allowed)) => {
                    let mut text = format!("{} of {}", told(value), told(limit));
                    if value > limit {
                        text.push_str(&format!(", allowed {}", told(allowed)));
                    }
                    Cell::Judged(text, value <= allowed)
                }
                _ => Cell::Number(told(value)),
            }
        };
        let jerks = self
            .figures
            .iter()
            .any(|f| f.channel.largest_jerk.is_some());
        let rows: Vec<Vec<Cell>> = self
            .figures
            .iter()
            .map(|f| {
                let (c, scale) = (&f.channel, f.channel.steps_per_unit);
                let mut row = vec![
                    Cell::Text(format!("{} [{}]", c.name, c.unit)),
                    beside(f, Limited::Rate, 1e3, 2),
                    beside(f, Limited::Speed, scale, 2),
                    beside(f, Limited::Acceleration, scale, 0),
                ];
                if jerks {
                    row.push(beside(f, Limited::Jerk, scale, 0));
                }
                row
            })
            .collect();
        let mut head = vec![
            "motor",
            "rate [1000 steps/s]",
            "speed [/s]",
            "acceleration [/s²]",
        ];
        if jerks {
            head.push("jerk [/s³]");
        }
        let caption = format!(
            "Largest values, rebuilt from the pulses over {:.0} ms (the rate over 64 gaps), and limits",
            self.window * 1e3
        );
        report.table(&caption, &head, &rows);
        report.text(ALLOWED);
        if let Some(worst) = self.worst() {
            report.text(&format!("Exceeded: {worst}."));
        }
    }

    /// Whether a motor's step rate and its rebuilt speed, acceleration and jerk keep its limits, as far as pulses tell.
    pub fn keeps_limits(&self, f: &MotorFigures) -> bool {
        let keeps = |limited: &Limited| {
            let allowed = self.allowed(f, *limited);
            allowed.is_none_or(|allowed| limited.of(f).0 <= allowed)
        };
        Limited::ALL.iter().all(keeps)
    }

    /// Whether all motors do.
    pub fn keep_limits(&self) -> bool {
        self.figures.iter().all(|f| self.keeps_limits(f))
    }

    /// Up to where a limit counts as kept [steps, s]: the limit, its share, and what half a step looks like.
    fn allowed(&self, f: &MotorFigures, limited: Limited) -> Option<f64> {
        let limit = limited.of(f).1?;
        Some(match limited {
            Limited::Rate | Limited::Speed => limit * TOLERANCE,
            Limited::Acceleration => {
                limit * TOLERANCE + self.half_steps * HALF_STEP_ACCELERATION / self.window.powi(2)
            }
            Limited::Jerk => {
                limit * JERK_TOLERANCE + self.half_steps * HALF_STEP_JERK / self.window.powi(3)
            }
        })
    }

    /// The limit that is exceeded by the largest share of what is allowed, in words: which motor, by how much, when, and
    /// where all of them were then.
    pub fn worst(&self) -> Option<String> {
        let mut worst: Option<(f64, &MotorFigures, Limited, f64)> = None;
        for f in &self.figures {
            for limited in Limited::ALL {
                let Some(allowed) = self.allowed(f, limited) else {
                    continue;
                };
                let share = limited.of(f).0 / allowed;
                if share > worst.map_or(1.0, |held| held.0) {
                    worst = Some((share, f, limited, allowed));
                }
            }
        }
        let (_, f, limited, allowed) = worst?;
        let (value, limit) = limited.of(f);
        let (scale, digits) = (f.channel.steps_per_unit, limited.digits());
        let (name, per) = limited.quantity().told();
        let list = limited.quantity().of(&f.motion);
        let largest = |a: &usize, b: &usize| list[*a].abs().total_cmp(&list[*b].abs());
        let k = (0..list.len()).max_by(largest)?;
        let places = self.figures.iter().map(|f| {
            let at = f.motion.position.get(k).copied().unwrap_or(0.0);
            format!(
                "{} {}",
                f.channel.name,
                number(at / f.channel.steps_per_unit, 3)
            )
        });
        Some(format!(
            "{} has {} {}{per} of {name} for {} ({} allowed in a window of {} ms) at {} s, where {}",
            f.channel.name,
            number(value / scale, digits),
            f.channel.unit,
            number(limit.unwrap_or(0.0) / scale, digits),
            number(allowed / scale, digits),
            number(self.window * 1e3, 0),
            number(f.motion.time(k), 3),
            places.collect::<Vec<_>>().join(", ")
        ))
    }

    /// How the limits stand, in a line of a summary.
    pub fn told_limits(&self) -> String {
        match self.worst() {
            None => "limits   kept by every motor, as far as pulses tell".into(),
            Some(worst) => format!("limits   EXCEEDED: {worst}"),
        }
    }

    /// The same in a table.
    pub fn limits_cell(&self) -> Cell {
        match self.worst() {
            None => "kept by every motor, as far as pulses tell".into(),
            Some(worst) => Cell::Judged(format!("exceeded: {worst}"), false),
        }
    }

    /// Pulse widths and direction times beside what the drivers ask for [counts].
    pub fn timing_table(&self, report: &mut Report, pulse: u32, setup: u32, hold: u32) {
        let beside = |value: Option<u64>, least: u32| match value {
            Some(value) => Cell::Judged(number(seconds(value) * 1e6, 2), value >= u64::from(least)),
            None => Cell::Number("–".into()),
        };
        let rows: Vec<Vec<Cell>> = self
            .figures
            .iter()
            .map(|f| {
                let s = &f.statistics;
                vec![
                    Cell::Text(f.channel.name.clone()),
                    beside(s.least_high, pulse),
                    beside(s.least_low, pulse),
                    beside(s.least_setup, setup),
                    beside(s.least_hold, hold),
                ]
            })
            .collect();
        let asked = |counts: u32| number(seconds(u64::from(counts)) * 1e6, 2);
        report.table(
            "Least times at the pins [µs]",
            &[
                "motor",
                &format!("pulse high (≥ {})", asked(pulse)),
                &format!("pulse low (≥ {})", asked(pulse)),
                &format!("direction set-up (≥ {})", asked(setup)),
                &format!("direction hold (≥ {})", asked(hold)),
            ],
            &rows,
        );
    }

    /// Positions of some motors over a stretch of time [s].
    pub fn position_chart(&self, title: &str, motors: &[usize], from: f64, to: f64) -> String {
        self.together(title, Quantity::Position, motors, from, to)
            .svg()
    }

    /// Speeds of some motors, as large as they are: limits that are far away would flatten them.
    pub fn speed_chart(&self, title: &str, motors: &[usize], from: f64, to: f64) -> String {
        self.together(title, Quantity::Speed, motors, from, to)
            .size(860.0, 170.0)
            .svg()
    }

    fn together(
        &self,
        title: &str,
        quantity: Quantity,
        motors: &[usize],
        from: f64,
        to: f64,
    ) -> Chart {
        let unit = motors.first().map_or("", |m| self.figures[*m].channel.unit);
        let (name, per) = quantity.told();
        let mut chart =
            Chart::new(title, "time [s]", &format!("{name} [{unit}{per}]")).x_range(from, to);
        for motor in motors {
            let f = &self.figures[*motor];
            let scale = f.channel.steps_per_unit;
            let list = quantity.of(&f.motion);
            let points = stretch(&f.motion, list, from, to);
            chart = chart.line(
                &f.channel.name,
                colour(*motor),
                points.map(|(t, x)| (t, x / scale)),
            );
        }
        chart
    }

    /// One quantity of one motor over a stretch of time, its limits drawn in; positions without, travel is in the table.
    pub fn chart(&self, motor: usize, quantity: Quantity, from: f64, to: f64) -> String {
        let f = &self.figures[motor];
        let c = &f.channel;
        let list = quantity.of(&f.motion);
        let limit = match quantity {
            Quantity::Position => None,
            Quantity::Speed => c.largest_rate,
            Quantity::Acceleration => c.largest_acceleration,
            Quantity::Jerk => c.largest_jerk,
        };
        let (name, per) = quantity.told();
        let scale = c.steps_per_unit;
        let points = stretch(&f.motion, list, from, to);
        let mut chart = Chart::new(
            &format!("{}: {name}", c.name),
            "time [s]",
            &format!("{}{per}", c.unit),
        )
        .size(860.0, 160.0)
        .x_range(from, to)
        .line(&c.name, colour(motor), points.map(|(t, y)| (t, y / scale)));
        if let Some(limit) = limit {
            chart = chart
                .limit("limit", limit / scale)
                .limit("", -limit / scale);
        }
        chart.svg()
    }

    /// Step rate of one motor over a stretch of time, its limit drawn in.
    pub fn rate_chart(&self, motor: usize, from: f64, to: f64) -> String {
        let f = &self.figures[motor];
        let title = format!("{}: step rate", f.channel.name);
        let points = stretch(&f.motion, &f.motion.speed, from, to);
        let mut chart = Chart::new(&title, "time [s]", "1000 steps/s")
            .size(860.0, 170.0)
            .x_range(from, to)
            .line(
                &f.channel.name,
                colour(motor),
                points.map(|(t, v)| (t, v * 1e-3)),
            );
        if let Some(limit) = f.channel.largest_rate {
            chart = chart.limit("limit", limit * 1e-3).limit("", -limit * 1e-3);
        }
        chart.svg()
    }

    /// Acceleration of some motors as shares of their limits over a stretch of time.
    pub fn acceleration_chart(&self, title: &str, motors: &[usize], from: f64, to: f64) -> String {
        let mut chart = Chart::new(title, "time [s]", "share of the limit")
            .size(860.0, 220.0)
            .x_range(from, to)
            .limit("limit", 1.0)
            .limit("", -1.0);
        for motor in motors {
            let f = &self.figures[*motor];
            let Some(limit) = f.channel.largest_acceleration else {
                continue;
            };
            let points = stretch(&f.motion, &f.motion.acceleration, from, to);
            chart = chart.line(
                &f.channel.name,
                colour(*motor),
                points.map(|(t, a)| (t, a / limit)),
            );
        }
        chart.svg()
    }
}

/// Length of the stretch of time in which pins are shown [counts], and how many such stretches are looked at, at most.
const MILLISECOND: u64 = TICK_HZ / 1000;
const STRETCHES: usize = 200;

/// Beginning of the millisecond between two times [s] in which most motors step, and of those that are alike the one
/// nearest to the middle [counts]. Looked at are those that begin at a step, spread evenly over all steps.
fn busiest<const N: usize>(trace: &Trace<N>, first: f64, last: f64) -> u64 {
    let count = |t: f64| (t.max(0.0) * TICK_HZ as f64) as u64;
    let (first, last) = (count(first), count(last));
    let mut starts: Vec<u64> = Vec::new();
    let mut stride = 1;
    let between = trace.pulses_from(first);
    for (index, pulse) in between.take_while(|p| p.time <= last).enumerate() {
        if index % stride == 0 {
            starts.push(pulse.time);
        }
        if starts.len() > STRETCHES {
            // Every other of them; the first stays.
            let mut place = 0;
            starts.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            stride *= 2;
        }
    }
    let middle = first.midpoint(last);
    let stretch = |start: u64| {
        // A little ahead of its first step.
        let from = start.saturating_sub(MILLISECOND / 20);
        let shown = trace.pulses_from(from);
        let shown = shown.take_while(|pulse| pulse.time < from + MILLISECOND);
        let motors = shown.fold(0u8, |motors, pulse| motors | pulse.motors);
        (
            motors.count_ones(),
            std::cmp::Reverse(from.abs_diff(middle)),
            from,
        )
    };
    let best = starts.into_iter().map(stretch).max();
    best.map_or(middle, |best| best.2)
}

/// Samples from `from` to `to` [s].
fn stretch<'a>(
    motion: &'a Motion,
    list: &'a [f64],
    from: f64,
    to: f64,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let index = |t: f64| ((t - motion.start) / motion.cell).clamp(0.0, list.len() as f64) as usize;
    let (first, last) = (index(from), (index(to) + 2).min(list.len()));
    (first..last).map(|i| (motion.time(i), list[i]))
}

/// Step and direction pins of all motors that have a name from `from` to `to` [counts], as a logic analyser shows them.
pub fn pulse_trains<const N: usize>(
    trace: &Trace<N>,
    names: &[String; N],
    title: &str,
    from: u64,
    to: u64,
) -> String {
    let microseconds = |time: u64| (time as f64 - from as f64) * 1e6 / TICK_HZ as f64;
    let (state, events) = trace.events_from(from);
    let mut steps: [Vec<(f64, bool)>; N] = std::array::from_fn(|_| Vec::new());
    let mut directions = steps.clone();
    let (mut levels, mut mask) = (state.levels, state.directions);
    for event in events.take_while(|event| event.time <= to) {
        let (old, new, lanes) = match event.change {
            Change::Levels(new) => (std::mem::replace(&mut levels, new), new, &mut steps),
            Change::Directions(new) => (std::mem::replace(&mut mask, new), new, &mut directions),
            Change::Enable(_) => continue,
        };
        for (motor, lane) in lanes.iter_mut().enumerate() {
            if (old ^ new) >> motor & 1 == 1 {
                lane.push((microseconds(event.time), new >> motor & 1 == 1));
            }
        }
    }
    let label = format!("time [µs] after {} s", number(seconds(from), 6));
    let mut waves = Waves::new(title, &label, 0.0, microseconds(to));
    for motor in 0..N {
        let bit = |mask: u8| mask >> motor & 1 == 1;
        let name = &names[motor];
        if name.is_empty() {
            continue;
        }
        waves = waves
            .lane(
                &format!("step {name}"),
                colour(motor),
                bit(state.levels),
                steps[motor].drain(..),
            )
            .lane(
                &format!("dir {name}"),
                "#8a929b",
                bit(state.directions),
                directions[motor].drain(..),
            );
    }
    waves.svg()
}

fn whole(count: i64) -> Cell {
    Cell::Number(number(count as f64, 0))
}

fn microseconds(counts: Option<u64>) -> Cell {
    Cell::Number(counts.map_or("–".into(), |counts| number(seconds(counts) * 1e6, 2)))
}
