//! Log frames on USART2, for `defmt-print`: written to a ring, sent byte by byte when the foreground has time.
//!
//! Logging never waits and never masks the step interrupt. A frame that does not fit is dropped as a whole, so that
//! the reader never sees half a frame.

use core::cell::RefCell;
use critical_section::Mutex;
use stm32f4::stm32f407 as chip;

use super::clock::Clock;
use super::pins::Pin;

/// Ring capacity [bytes]: about thirty short frames.
const CAPACITY: usize = 512;
/// Alternate function 7 is USART1 to USART3 on every pin that has it.
const USART_FUNCTION: u32 = 7;
const BAUD: u32 = 115_200;

struct Ring {
    bytes: [u8; CAPACITY],
    /// Next byte to send, and number of bytes waiting in complete frames.
    head: usize,
    complete: usize,
    /// Bytes of the frame being written, behind the complete ones.
    open: usize,
    /// The frame being written does not fit and will be dropped.
    overflow: bool,
}

impl Ring {
    const fn new() -> Self {
        Self {
            bytes: [0; CAPACITY],
            head: 0,
            complete: 0,
            open: 0,
            overflow: false,
        }
    }

    fn append(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let length = self.complete + self.open;
            match self.bytes.get_mut((self.head + length) % CAPACITY) {
                Some(slot) if length < CAPACITY => {
                    *slot = byte;
                    self.open += 1;
                }
                _ => self.overflow = true,
            }
        }
    }

    fn close_frame(&mut self) {
        if !self.overflow {
            self.complete += self.open;
        }
        self.open = 0;
        self.overflow = false;
    }

    fn pop(&mut self) -> Option<u8> {
        if self.complete == 0 {
            return None;
        }
        let byte = self.bytes.get(self.head).copied();
        self.head = (self.head + 1) % CAPACITY;
        self.complete -= 1;
        byte
    }
}

struct Shared {
    ring: Ring,
    encoder: defmt::Encoder,
    /// Mask to restore when the frame is closed.
    restore: critical_section::RestoreState,
}

static SHARED: Mutex<RefCell<Shared>> = Mutex::new(RefCell::new(Shared {
    ring: Ring::new(),
    encoder: defmt::Encoder::new(),
    restore: critical_section::RestoreState::invalid(),
}));

#[defmt::global_logger]
struct Logger;

/// Runs `action` on the shared state; only called while the frame's critical section is held.
fn with_shared(action: impl FnOnce(&mut Shared)) {
    // SAFETY: `Logger::acquire` has entered the critical section and `release` has not left it yet.
    let token = unsafe { critical_section::CriticalSection::new() };
    // The borrow ends within this function and nothing called meanwhile logs, so it is never refused.
    if let Ok(mut shared) = SHARED.borrow(token).try_borrow_mut() {
        action(&mut shared);
    }
}

// SAFETY: a frame is written inside one critical section from `acquire` to `release`, so frames cannot interleave.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: released in `release`, which defmt calls exactly once after `acquire`, in the same context.
        let restore = unsafe { critical_section::acquire() };
        with_shared(|shared| {
            shared.restore = restore;
            let Shared { ring, encoder, .. } = shared;
            encoder.start_frame(|bytes| ring.append(bytes));
        });
    }

    unsafe fn flush() {}

    unsafe fn release() {
        let mut restore = critical_section::RestoreState::invalid();
        with_shared(|shared| {
            let Shared { ring, encoder, .. } = &mut *shared;
            encoder.end_frame(|bytes| ring.append(bytes));
            ring.close_frame();
            restore = shared.restore;
        });
        // SAFETY: `restore` is what `acquire` returned for this frame.
        unsafe { critical_section::release(restore) };
    }

    unsafe fn write(bytes: &[u8]) {
        with_shared(|shared| {
            let Shared { ring, encoder, .. } = shared;
            encoder.write(bytes, |encoded| ring.append(encoded));
        });
    }
}

/// The sending half, polled by the foreground.
pub struct LogSender {
    usart: chip::USART2,
}

impl LogSender {
    /// Starts USART2 for sending at 115200 baud 8N1.
    pub fn start(usart: chip::USART2, rcc: &chip::RCC, clock: &Clock, transmit: Pin) -> Self {
        rcc.apb1enr().modify(|_, w| w.usart2en().enabled());
        let _ = rcc.apb1enr().read();
        transmit.make_alternate(USART_FUNCTION);
        // SAFETY: with 16-fold oversampling every divider from 16 up is valid, and both bus clocks give at least 138.
        usart
            .brr()
            .write(|w| unsafe { w.bits(clock.apb1_divider(BAUD)) });
        usart.cr1().write(|w| w.te().enabled().ue().enabled());
        Self { usart }
    }

    /// Sends one byte if the transmitter is free and a byte is waiting. Never waits.
    pub fn poll(&mut self) {
        if self.usart.sr().read().txe().bit_is_set() {
            let byte = critical_section::with(|token| SHARED.borrow(token).borrow_mut().ring.pop());
            if let Some(byte) = byte {
                self.usart.dr().write(|w| w.dr().set(byte.into()));
            }
        }
    }
}
