//! The serial interrupt's half: real-time bytes become flags, the rest goes into the byte queue.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Bytes that can wait for the foreground; hosts that count characters are told one less.
pub const RECEIVE: usize = 1024;

/// From the serial interrupt to the foreground.
pub type ByteQueue = heapless::spsc::Queue<u8, RECEIVE>;

/// Flags that the serial interrupt raises and the foreground takes.
#[derive(Debug, Default)]
pub struct RealTime(AtomicU32);

impl RealTime {
    pub const STATUS: u32 = 1;
    pub const RESET: u32 = 2;
    pub const HOLD: u32 = 4;
    pub const RESUME: u32 = 8;
    /// A byte found no room in the queue.
    pub const OVERFLOW: u32 = 16;

    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    pub fn raise(&self, flag: u32) {
        self.0.fetch_or(flag, Relaxed);
    }

    /// Whether the flag was raised; it is lowered.
    pub fn take(&self, flag: u32) -> bool {
        self.0.fetch_and(!flag, Relaxed) & flag != 0
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
            0x80.. => {}
            b'\r' | b'\n' | 0x08 | 0x20..=0x7f if self.queue.enqueue(byte).is_err() => {
                self.flags.raise(RealTime::OVERFLOW);
            }
            _ => {}
        }
    }
}
