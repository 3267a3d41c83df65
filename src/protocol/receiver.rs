//! The serial interrupt's half: real-time bytes become flags, the rest goes into the byte queue.

use super::reading::{self, Record};
use crate::settings::MOST_AXES;
use core::sync::atomic::{AtomicI32, AtomicU8, AtomicU32, Ordering::Relaxed};

/// Bytes that can wait for the foreground; hosts that count characters are told one less.
pub const RECEIVE: usize = 1024;

/// From the serial interrupt to the foreground.
pub type ByteQueue = heapless::spsc::Queue<u8, RECEIVE>;

/// What interrupts below the step interrupt tell the foreground: flags that they raise and it takes, and the overrides.
#[derive(Debug)]
pub struct RealTime {
    flags: AtomicU32,
    /// [percent]
    feed: AtomicU8,
    rapid: AtomicU8,
    /// Fine steps asked for since they were last taken, and which motor the next ones are for, of how many.
    trims: [AtomicI32; MOST_AXES],
    selected: AtomicU8,
    motors: AtomicU8,
    /// The last reading since one was taken: bit 16 and its value; 0 if there is none.
    reading: AtomicU32,
}

impl Default for RealTime {
    fn default() -> Self {
        Self::new()
    }
}

impl RealTime {
    pub const STATUS: u32 = 1;
    pub const RESET: u32 = 2;
    pub const HOLD: u32 = 4;
    pub const RESUME: u32 = 8;
    /// A byte found no room in the queue.
    pub const OVERFLOW: u32 = 16;
    pub const JOG_CANCEL: u32 = 32;
    /// The probe has touched; raised by the pin's interrupt, which has asked for the positions first.
    pub const TOUCH: u32 = 64;

    /// Trims have been changed, or another motor selected.
    pub const TRIM: u32 = 128;
    /// Trims stay where they are.
    pub const TRIM_FREEZE: u32 = 256;
    /// All trims go to zero.
    pub const TRIM_ZERO: u32 = 512;

    const READING: u32 = 1 << 16;

    pub const fn new() -> Self {
        Self {
            flags: AtomicU32::new(0),
            feed: AtomicU8::new(100),
            rapid: AtomicU8::new(100),
            trims: [const { AtomicI32::new(0) }; MOST_AXES],
            selected: AtomicU8::new(0),
            motors: AtomicU8::new(1),
            reading: AtomicU32::new(0),
        }
    }

    pub fn raise(&self, flag: u32) {
        self.flags.fetch_or(flag, Relaxed);
    }

    /// Whether the flag was raised; it is lowered.
    pub fn take(&self, flag: u32) -> bool {
        self.flags.fetch_and(!flag, Relaxed) & flag != 0
    }

    /// Feed override (10 to 200) and rapid override (25, 50 or 100) [percent].
    pub fn overrides(&self) -> (u8, u8) {
        (self.feed.load(Relaxed), self.rapid.load(Relaxed))
    }

    pub fn reset_overrides(&self) {
        self.feed.store(100, Relaxed);
        self.rapid.store(100, Relaxed);
    }

    /// How many motors can be selected for trims.
    pub fn set_motors(&self, motors: u8) {
        self.motors.store(motors.max(1), Relaxed);
    }

    /// Fine steps asked for a motor since they were last taken.
    pub fn take_trim(&self, motor: usize) -> i32 {
        self.trims
            .get(motor)
            .map_or(0, |steps| steps.swap(0, Relaxed))
    }

    /// The motor that trims are for.
    pub fn selected_trim(&self) -> usize {
        self.selected.load(Relaxed).into()
    }

    /// The newest reading since the last one was taken [mm].
    pub fn take_reading(&self) -> Option<f32> {
        let word = self.reading.swap(0, Relaxed);
        let value = (word & Self::READING != 0).then_some(word as u16 as i16)?;
        reading::millimetres(value)
    }

    fn read(&self, value: i16) {
        let word = Self::READING | u32::from(value as u16);
        self.reading.store(word, Relaxed);
    }

    fn change_trim(&self, steps: i32) {
        if let Some(trim) = self.trims.get(self.selected_trim()) {
            trim.fetch_add(steps, Relaxed);
        }
        self.raise(Self::TRIM);
    }

    /// Only the serial interrupt changes it.
    fn select_trim(&self, next: bool) {
        let (selected, motors) = (self.selected.load(Relaxed), self.motors.load(Relaxed));
        let last = motors.saturating_sub(1);
        let selected = match next {
            true if selected >= last => 0,
            true => selected + 1,
            false if selected == 0 => last,
            false => selected - 1,
        };
        self.selected.store(selected, Relaxed);
        self.raise(Self::TRIM);
    }

    /// What was asked for before counts no more.
    fn drop_trims(&self, flag: u32) {
        for trim in &self.trims {
            trim.store(0, Relaxed);
        }
        self.raise(flag);
    }

    /// Only the serial interrupt changes it, so load and store need not be one.
    fn change_feed(&self, percent: i16) {
        let feed = i16::from(self.feed.load(Relaxed)) + percent;
        self.feed.store(feed.clamp(10, 200) as u8, Relaxed);
    }
}

/// Owned by the serial interrupt.
pub struct Receiver<'a> {
    queue: heapless::spsc::Producer<'a, u8>,
    flags: &'a RealTime,
    record: Record,
}

impl<'a> Receiver<'a> {
    pub fn new(queue: heapless::spsc::Producer<'a, u8>, flags: &'a RealTime) -> Self {
        Self {
            queue,
            flags,
            record: Record::default(),
        }
    }

    /// One byte, as it arrives. Bytes from 0x80 on never reach a line: senders encode overrides as UTF-8.
    pub fn receive(&mut self, byte: u8) {
        match byte {
            0x18 => self.flags.raise(RealTime::RESET),
            b'?' | 0x80 => self.flags.raise(RealTime::STATUS),
            b'!' | 0x82 => self.flags.raise(RealTime::HOLD),
            b'~' | 0x81 => self.flags.raise(RealTime::RESUME),
            0x85 => self.flags.raise(RealTime::JOG_CANCEL),
            0x90 => self.flags.feed.store(100, Relaxed),
            0x91 => self.flags.change_feed(10),
            0x92 => self.flags.change_feed(-10),
            0x93 => self.flags.change_feed(1),
            0x94 => self.flags.change_feed(-1),
            0x95 => self.flags.rapid.store(100, Relaxed),
            0x96 => self.flags.rapid.store(50, Relaxed),
            0x97 => self.flags.rapid.store(25, Relaxed),
            0xA8 => self.flags.change_trim(1),
            0xA9 => self.flags.change_trim(-1),
            0xAA => self.flags.change_trim(10),
            0xAB => self.flags.change_trim(-10),
            0xAC => self.flags.select_trim(true),
            0xAD => self.flags.select_trim(false),
            0xAE => self.flags.drop_trims(RealTime::TRIM_FREEZE),
            0xAF => self.flags.drop_trims(RealTime::TRIM_ZERO),
            reading::BEGIN => self.record.begin(),
            reading::DIGIT..=0xBF => {
                if let Some(value) = self.record.push(byte - reading::DIGIT) {
                    self.flags.read(value);
                }
            }
            0x80.. => {}
            b'\r' | b'\n' | 0x08 | 0x20..=0x7f if self.queue.enqueue(byte).is_err() => {
                self.flags.raise(RealTime::OVERFLOW);
            }
            _ => {}
        }
    }
}
