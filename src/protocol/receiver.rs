//! The serial interrupt's half: real-time bytes become flags, the rest goes into the byte queue.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

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

    pub const fn new() -> Self {
        Self {
            flags: AtomicU32::new(0),
            feed: AtomicU8::new(100),
            rapid: AtomicU8::new(100),
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
}

impl<'a> Receiver<'a> {
    pub fn new(queue: heapless::spsc::Producer<'a, u8>, flags: &'a RealTime) -> Self {
        Self { queue, flags }
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
            0x80.. => {}
            b'\r' | b'\n' | 0x08 | 0x20..=0x7f if self.queue.enqueue(byte).is_err() => {
                self.flags.raise(RealTime::OVERFLOW);
            }
            _ => {}
        }
    }
}
