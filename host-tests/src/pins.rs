//! Virtual pins: `embedded_hal` output pins whose port is a byte of memory.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use std::cell::Cell;

/// One pin of a port of memory: a bit of a byte.
pub struct Pin<'a> {
    port: &'a Cell<u8>,
    bit: u8,
}

impl<'a> Pin<'a> {
    /// The first N pins of a port, pin i at bit i.
    pub fn all<const N: usize>(port: &'a Cell<u8>) -> [Self; N] {
        const { assert!(N <= 8, "a port of memory has eight bits") };
        std::array::from_fn(|i| Self { port, bit: 1 << i })
    }
}

impl ErrorType for Pin<'_> {
    type Error = Infallible;
}

impl OutputPin for Pin<'_> {
    #[inline(always)]
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.port.set(self.port.get() & !self.bit);
        Ok(())
    }

    #[inline(always)]
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.port.set(self.port.get() | self.bit);
        Ok(())
    }
}
