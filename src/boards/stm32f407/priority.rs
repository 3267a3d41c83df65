//! Interrupt priorities, and the critical section that never masks the step interrupt.
//!
//! | priority | who |
//! |---|---|
//! | 0x00 | SysTick: the step interrupt, never masked |
//! | 0x10 | mask of every critical section |
//! | 0x40 | USART1: received bytes, bytes to send |
//!
//! A critical section raises BASEPRI to 0x10. That keeps out every interrupt but the step interrupt, which in turn
//! neither logs nor enters a critical section: it owns what it touches, apart from lock-free queues and atomics.

use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::register::{basepri, basepri_max};

pub const STEP: u8 = 0x00;
const CRITICAL_SECTION: u8 = 0x10;
pub const SERIAL: u8 = 0x40;

struct MaskBelowStep;
critical_section::set_impl!(MaskBelowStep);

// SAFETY: between `acquire` and `release` no other context that may enter a critical section can run: there is one
// core, the foreground and every interrupt but the step interrupt are at or below the mask, and the step interrupt
// enters none. `basepri_max` only ever raises the mask and `release` restores the former one, so sections nest.
unsafe impl critical_section::Impl for MaskBelowStep {
    unsafe fn acquire() -> critical_section::RawRestoreState {
        let former = basepri::read();
        basepri_max::write(CRITICAL_SECTION);
        compiler_fence(Ordering::SeqCst);
        former
    }

    unsafe fn release(former: critical_section::RawRestoreState) {
        compiler_fence(Ordering::SeqCst);
        // SAFETY: `former` is what `acquire` of this section has read.
        unsafe { basepri::write(former) };
    }
}
