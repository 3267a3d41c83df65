//! Offsets of the motors while programs run: from `$TRIM` lines, from real-time bytes, and from a stream of readings.
//!
//! ```text
//! $TRIM=Z0.05 ----------------------------> asked [mm, deg] --+
//! 0xA8 .. 0xAF --> RealTime --------------> asked             +--> planner's trims [steps]
//! 0xA6, 8 digits --> RealTime --> Trimmer --> Pair::trim -----+
//!                                    `-- fault: feed hold
//! ```
//!
//! The stream is for the two-sided machine with four joints a side: X1 Y1 Z1 B1 X2 Y2 Z2 B2 on eight motors. Its tick
//! stands in the motion's own time, between two samples of a path that moves, so both sides get the same offset in the same sample; a tick's
//! change is spread over the samples to the next one. Amount and rate are looked at when it begins, so the planner's own
//! bounds never hold one side back behind the other.

use super::answers::LONGEST_ANSWER;
use super::{Controller, Job};
use crate::board::Board;
use crate::cycles::mirror_trim::{Parameters, Trimmer};
use crate::error::Error;
use crate::joints::Joints;
use crate::machines::two_sided::Pair;
use crate::math::Real;
use crate::program::processes::Processes;
use crate::protocol::RealTime;
use crate::settings::LETTERS;

/// Joints of a side.
const SIDE: usize = 4;

/// Room that what is said unasked needs.
const ANSWER: usize = 160;

/// One fine step of a trim: 1 um or 0.001 deg.
const FINE: f32 = 0.001;

/// What a stream of readings needs. Times in s, lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// Milliseconds between two ticks, 1 ..= 100.
    pub period: i32,
    pub tau: f32,
    pub amount: f32,
    pub rate: f32,
    pub gate: f32,
    pub miss_max: u32,
}

/// A stream of readings that trims both sides.
pub(super) struct Stream {
    trimmer: Trimmer<f32>,
    pair: Pair<SIDE, SIDE, f32>,
    period: i32,
    /// Samples to the next tick.
    left: i32,
    /// Offset along the normal at the tick before [mm]; the way to the present one is spread over the period.
    before: f32,
    said: bool,
}

/// The trims in force, as they were asked for.
pub(super) struct Trims<const N: usize> {
    /// [mm or deg]
    asked: [f32; N],
    stream: Option<Stream>,
    /// The selected motor's offset is to be told.
    say: bool,
}

impl<const N: usize> Trims<N> {
    pub const fn new() -> Self {
        Self {
            asked: [0.0; N],
            stream: None,
            say: false,
        }
    }
}

impl<B: Board, const N: usize, P: Processes<N>> Controller<'_, B, N, P> {
    /// What the operator's bytes ask for.
    pub(super) fn serve_trims(&mut self) -> bool {
        if self.answers.room() < ANSWER {
            return false;
        }
        let freeze = self.flags.take(RealTime::TRIM_FREEZE);
        let zero = self.flags.take(RealTime::TRIM_ZERO);
        let touched = self.flags.take(RealTime::TRIM);
        let asked = freeze || zero || touched;
        if asked && self.alarm.is_none() {
            self.change_trims(freeze, zero);
            self.trims.say = true;
        }
        // What nobody has asked for with a line must not keep lines from being taken.
        let says = self.trims.say && self.answers.room() >= LONGEST_ANSWER + ANSWER;
        if says {
            self.trims.say = false;
            self.say_trim(self.flags.selected_trim());
        }
        asked || says
    }

    fn change_trims(&mut self, freeze: bool, zero: bool) {
        if freeze || zero {
            self.trims.stream = None;
        }
        if freeze {
            self.freeze_trims();
        }
        if zero {
            self.zero_trims();
        }
        for motor in 0..N {
            let steps = self.flags.take_trim(motor);
            // A stream's offsets are its own.
            if steps != 0 && self.trims.stream.is_none() && self.settings.trim_share() > 0.0 {
                let before = self.trims.asked.get(motor).copied().unwrap_or_default();
                let most = self.most_trim(motor);
                let wanted = (before + steps as f32 * FINE).clamp(-most, most);
                let _ = self.ask_trim(motor, wanted);
            }
        }
    }

    /// `$TRIM=<axis><value>`: an offset [mm or deg], absolutely.
    pub(super) fn trim(&mut self, motor: usize, value: f32) -> Result<(), Error> {
        self.trims_allowed()?;
        let most = self.most_trim(motor);
        if !(-most..=most).contains(&value) {
            self.answers.line(format_args!(
                "[MSG:OutOfRange trim {}: expected at most {} either way, see ${}]",
                letter(motor),
                crate::program::words::Decimal(most),
                1030 + motor
            ));
            return Err(Error::ValueRange);
        }
        self.ask_trim(motor, value)
    }

    /// `$TRIM=0`: all offsets go to zero, and a stream ends.
    pub(super) fn remove_trims(&mut self) {
        self.trims.stream = None;
        self.zero_trims();
    }

    /// `$TRIM`: the offsets asked for [mm or deg].
    pub(super) fn list_trims(&mut self) {
        use core::fmt::Write;
        let _ = self.answers.write_str("[TRIM:");
        for (motor, value) in self.trims.asked.iter().enumerate() {
            let comma = if motor == 0 { "" } else { "," };
            let _ = write!(self.answers, "{comma}{}", Places(*value));
        }
        self.answers.line(format_args!("]"));
    }

    /// `$TRIM=ON,...`: from now on readings trim both sides of a two-sided machine.
    pub(super) fn follow(&mut self, follow: Follow) -> Result<(), Error> {
        self.trims_allowed()?;
        if self.is_moving() || self.planner.is_held() {
            return Err(Error::NotIdle);
        }
        // Of eight motors, the last one of each side turns.
        if N != 2 * SIDE || self.settings.turning() != 0b1000_1000 {
            self.answers.line(format_args!(
                "[MSG:Trim: expected a two-sided machine, X Y Z B twice, see $376]"
            ));
            return Err(Error::Unavailable);
        }
        if !(1..=100).contains(&follow.period) {
            return Err(self.bad_limit("period", "1 to 100 ms"));
        }
        let dt = follow.period as f32 * 0.001;
        let trimmer = Trimmer::new(&Parameters {
            dt,
            tau: follow.tau,
            amount: follow.amount,
            rate: follow.rate,
            gate: follow.gate,
            miss_max: follow.miss_max,
        })
        .map_err(|bad| self.bad_limit(bad.0, "a number above 0"))?;
        for motor in 0..N {
            if self.settings.turning() >> motor & 1 != 0 {
                continue;
            }
            let steps = self.settings.steps_per_unit().get(motor).copied();
            let steps = steps.unwrap_or_default();
            if follow.amount > self.most_trim(motor) {
                return Err(self.bad_limit("amount", "no more than $1030 to $1036 allow"));
            }
            if follow.rate * steps > self.planner.trim_rate(motor) {
                return Err(self.bad_limit(
                    "rate",
                    "no more than the share $1013 of $110, $120, $800 allows",
                ));
            }
        }
        let pair = self.processes.pair(&self.scale(), &mut self.answers)?;
        self.zero_trims();
        // Older than the stream.
        let _ = self.flags.take_reading();
        self.trims.stream = Some(Stream {
            trimmer,
            pair,
            period: follow.period,
            left: 0,
            before: 0.0,
            said: false,
        });
        Ok(())
    }

    /// `$TRIM=OFF`: offsets stay as they are.
    pub(super) fn unfollow(&mut self) {
        if self.trims.stream.take().is_some() {
            self.freeze_trims();
        }
    }

    /// Behind a sample: one tick of the stream, when it is due, and the offsets of the next sample.
    pub(super) fn tick_trims(&mut self) {
        if N != 2 * SIDE {
            return;
        }
        let Some(stream) = &mut self.trims.stream else {
            return;
        };
        if stream.left == 0 {
            stream.left = stream.period;
            stream.before = stream.trimmer.out();
            stream.trimmer.tick(self.flags.take_reading());
        }
        stream.left -= 1;
        let way = stream.trimmer.out() - stream.before;
        let out = stream.trimmer.out() - way * stream.left as f32 / stream.period as f32;
        let position = self.planner.position();
        let scale = self.settings.steps_per_joint_unit();
        let side = |first: usize| {
            Joints(core::array::from_fn(|i| {
                let steps = position.get(first + i).map_or(0.0, |p| p.to_num::<f32>());
                steps / scale.get(first + i).copied().unwrap_or(1.0)
            }))
        };
        let (mill, support) = (side(0), side(SIDE));
        let (_, normal) = stream.pair.mill().forward(&mill);
        let trim = stream.pair.trim(normal, out, (&mill, &support)).ok();
        let faulty = stream.trimmer.is_faulty() || trim.is_none();
        let says = faulty && !stream.said && self.answers.room() >= ANSWER;
        stream.said |= says;
        if let Some(trim) = trim {
            for (motor, value) in trim.mill.0.iter().chain(&trim.support.0).enumerate() {
                let steps = scale.get(motor).map_or(0.0, |scale| *value * scale);
                let steps = Real::round(steps) as i32;
                if steps != self.planner.trim(motor) {
                    self.planner.set_trim(motor, steps);
                }
                if let Some(asked) = self.trims.asked.get_mut(motor) {
                    *asked = *value;
                }
            }
        }
        if faulty {
            self.hold();
        }
        if says {
            self.answers.line(format_args!(
                "[MSG:Trim fault: no reading in time, offset held; 0xAE lets the program go on without]"
            ));
        }
    }

    /// The planner has begun anew: what was an offset is part of the position now, and a stream starts from zero.
    pub(super) fn restart_trims(&mut self) {
        self.trims.asked = [0.0; N];
        if let Some(stream) = &mut self.trims.stream {
            stream.trimmer.reset();
            stream.left = 0;
            stream.before = 0.0;
            stream.said = false;
        }
    }

    /// The same, and a stream ends.
    pub(super) fn forget_trims(&mut self) {
        self.trims = Trims::new();
    }

    /// After a soft reset at rest.
    pub(super) fn absorb_trims(&mut self) {
        if self.trims.asked.iter().any(|trim| *trim != 0.0) || self.trims.stream.is_some() {
            self.planner.reset(self.segmenter.counts());
            self.forget_trims();
        }
    }

    fn trims_allowed(&mut self) -> Result<(), Error> {
        if self.alarm.is_some() {
            return Err(Error::Locked);
        }
        if self.settings.trim_share() <= 0.0 {
            self.answers.line(format_args!(
                "[MSG:Trim: expected a share of the motors' limits, see $1013]"
            ));
            return Err(Error::Unavailable);
        }
        Ok(())
    }

    /// Sets an offset that is within its bound.
    fn ask_trim(&mut self, motor: usize, value: f32) -> Result<(), Error> {
        if matches!(self.job, Job::None) && self.planner.is_idle() {
            self.may_move()?;
            self.switch_on();
        }
        let scale = self.settings.steps_per_unit().get(motor).copied();
        let steps = Real::round(value * scale.unwrap_or_default()) as i32;
        let taken = self.planner.set_trim(motor, steps);
        if let Some(asked) = self.trims.asked.get_mut(motor) {
            *asked = if taken == steps { value } else { 0.0 };
        }
        Ok(())
    }

    fn zero_trims(&mut self) {
        for motor in 0..N {
            let is_set = self.trims.asked.get(motor).is_some_and(|trim| *trim != 0.0);
            if is_set {
                let _ = self.ask_trim(motor, 0.0);
            }
        }
    }

    /// Every offset stays where it is now, on a whole step.
    fn freeze_trims(&mut self) {
        self.planner.freeze_trims();
        let scale = self.settings.steps_per_unit();
        for (motor, asked) in self.trims.asked.iter_mut().enumerate() {
            let steps = self.planner.trim(motor) as f32;
            *asked = scale.get(motor).map_or(0.0, |scale| steps / scale);
        }
    }

    /// Largest offset of a motor [mm or deg].
    fn most_trim(&self, motor: usize) -> f32 {
        let bound = self.settings.trim_bound().get(motor).copied();
        let scale = self.settings.steps_per_unit().get(motor).copied();
        bound.unwrap_or(0) as f32 / scale.unwrap_or(1.0)
    }

    fn say_trim(&mut self, motor: usize) {
        let value = self.trims.asked.get(motor).copied().unwrap_or_default();
        let sign = if value >= 0.0 { "+" } else { "" };
        self.answers.line(format_args!(
            "[MSG:Trim {} {sign}{}]",
            letter(motor),
            Places(value)
        ));
    }

    fn bad_limit(&mut self, name: &str, expected: &str) -> Error {
        self.answers
            .line(format_args!("[MSG:BadLimit {name}: expected {expected}]"));
        Error::ValueRange
    }
}

pub(super) fn letter(motor: usize) -> char {
    LETTERS
        .as_bytes()
        .get(motor)
        .map_or('?', |byte| char::from(*byte))
}

/// A number with four places.
struct Places(f32);

impl core::fmt::Display for Places {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        // The largest trim is some ten thousand steps; the cast saturates beyond any.
        let parts = Real::round(self.0 * 10_000.0) as i32;
        let sign = if parts < 0 { "-" } else { "" };
        let size = parts.unsigned_abs();
        write!(out, "{sign}{}.{:04}", size / 10_000, size % 10_000)
    }
}
