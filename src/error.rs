//! Errors and alarms, by the numbers that hosts know (Grbl 1.1 and grblHAL).

/// A line was refused; nothing moved, nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Error {
    BadNumber = 2,
    UnknownCommand = 3,
    Negative = 4,
    PulseTooShort = 6,
    NotIdle = 8,
    Locked = 9,
    LineTooLong = 11,
    StepRate = 12,
    BeyondTravel = 15,
    NotPositive = 19,
    Unsupported = 20,
    InvalidTarget = 33,
    ValueRange = 52,
    Unavailable = 53,
    SystemLocked = 56,
}

impl Error {
    pub const fn number(self) -> u8 {
        self as u8
    }
}

/// The machine is locked until it is told otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Alarm {
    /// Reset, or a dry queue, while the motors moved: the position is in doubt.
    StoppedInMotion = 3,
    /// The probe touches before its move has begun; the position is kept.
    ProbeTouchesAtStart = 4,
}

impl Alarm {
    pub const fn number(self) -> u8 {
        self as u8
    }
}
