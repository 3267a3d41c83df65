//! Levels -> pins. A tick hands over the levels of all step pins at once, and each port changes in one store.
//!
//! [`RegisterPort`] is for boards: a table from the levels to the set/reset word of each port, built once from the
//! pin map. [`PinPort`] is for any other board and for the host: N `embedded_hal` output pins.
#![deny(clippy::float_arithmetic, clippy::integer_division)]

use core::convert::Infallible;
use embedded_hal::digital::OutputPin;

/// The pins of the motors, as the step interrupt sees them: levels in, nothing out, no way to fail.
///
/// A tick that does both puts out the levels first. No direction changes in the tick of a step of its own motor.
pub trait StepPort {
    /// Puts out the levels of all step pins; bit i is motor i, a set bit is the active level.
    fn emit(&mut self, levels: u32);
    /// Puts out all directions; a set bit means towards negative.
    fn direct(&mut self, directions: u32);
}

/// The timer whose wrap calls the step interrupt.
pub trait StepTimer {
    /// Ticks come `counts` timer counts apart, from the wrap after the next one on.
    fn set_period(&mut self, counts: u32);
}

/// A register of which bits 0..16 set pins of a port and bits 16..32 reset them (STM32: BSRR).
pub trait SetResetRegister {
    fn write(&mut self, word: u32);
}

/// One pin of a motor: which of the board's registers, and which bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinAt {
    /// Index into the registers of the [`RegisterPort`].
    pub register: usize,
    /// Number of the pin within its port, 0 ..= 15.
    pub pin: u8,
    /// Whether a set level is the low voltage.
    pub inverted: bool,
}

/// Step pins on `S` registers and direction pins on `D`, driven by a table of `LEN = 2^N` rows each.
pub struct RegisterPort<W, const S: usize, const D: usize, const LEN: usize> {
    step_registers: [W; S],
    direction_registers: [W; D],
    steps: [[u32; S]; LEN],
    directions: [[u32; D]; LEN],
}

impl<W: SetResetRegister, const S: usize, const D: usize, const LEN: usize>
    RegisterPort<W, S, D, LEN>
{
    /// The tables for the pins of motors 0, 1, ...; a pin whose register does not exist is left out.
    pub fn new(
        step_registers: [W; S],
        step_pins: &[PinAt],
        direction_registers: [W; D],
        direction_pins: &[PinAt],
    ) -> Self {
        const { assert!(LEN.is_power_of_two() && LEN <= 256, "one row for each mask") };
        Self {
            step_registers,
            direction_registers,
            steps: table(step_pins),
            directions: table(direction_pins),
        }
    }
}

impl<W: SetResetRegister, const S: usize, const D: usize, const LEN: usize> StepPort
    for RegisterPort<W, S, D, LEN>
{
    #[inline(always)]
    fn emit(&mut self, levels: u32) {
        // The mask of LEN - 1 keeps the row inside the table without a check.
        let row = &self.steps[levels as usize & (LEN - 1)];
        store(&mut self.step_registers, row);
    }

    #[inline(always)]
    fn direct(&mut self, directions: u32) {
        let row = &self.directions[directions as usize & (LEN - 1)];
        store(&mut self.direction_registers, row);
    }
}

/// One store for each port, as many as eight motors can lie on. Written out: a loop over more than two ports stays one
/// where the rest of the program is compiled for size, and costs as much again as its stores.
#[inline(always)]
fn store<W: SetResetRegister, const P: usize>(registers: &mut [W; P], row: &[u32; P]) {
    const { assert!(P <= 8, "a motor has one step pin") };
    macro_rules! each_port {
        ($($number:literal),*) => {
            $(if let (Some(register), Some(word)) = (registers.get_mut($number), row.get($number)) {
                register.write(*word);
            })*
        };
    }
    each_port!(0, 1, 2, 3, 4, 5, 6, 7);
}

/// The set/reset words of every mask: pins of set bits go active, all others inactive.
fn table<const P: usize, const LEN: usize>(pins: &[PinAt]) -> [[u32; P]; LEN] {
    core::array::from_fn(|mask| {
        let mut row = [0; P];
        for (motor, at) in pins.iter().enumerate() {
            let active = mask >> motor & 1 != 0;
            let high = active != at.inverted;
            if let Some(word) = row.get_mut(at.register) {
                *word |= 1 << (u32::from(at.pin & 15) + if high { 0 } else { 16 });
            }
        }
        row
    })
}

/// Step and direction pins behind `embedded_hal`, one store a pin.
pub struct PinPort<S, D, const N: usize> {
    pub steps: [S; N],
    pub directions: [D; N],
}

impl<S, D, const N: usize> StepPort for PinPort<S, D, N>
where
    S: OutputPin<Error = Infallible>,
    D: OutputPin<Error = Infallible>,
{
    #[inline(always)]
    fn emit(&mut self, levels: u32) {
        set_all(&mut self.steps, levels);
    }

    #[inline(always)]
    fn direct(&mut self, directions: u32) {
        set_all(&mut self.directions, directions);
    }
}

#[inline(always)]
fn set_all<P: OutputPin<Error = Infallible>, const N: usize>(pins: &mut [P; N], levels: u32) {
    for (i, pin) in pins.iter_mut().enumerate() {
        // The error type has no value, so there is nothing to handle.
        let Ok(()) = pin.set_state((levels >> i & 1 != 0).into());
    }
}
