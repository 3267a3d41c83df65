//! What happens when the program cannot go on: drivers off, step pins inactive, one message, halt.
//!
//! Panics and hard faults both end here, and both stop the step interrupt first.

use super::serial;
use crate::boards::BOARD;

/// Ends the program in the safe state.
fn halt(message: &str) -> ! {
    cortex_m::interrupt::disable();
    BOARD.make_safe();
    serial::send_last_words(message);
    loop {
        // Interrupts are off: nothing wakes the core but a debugger or a reset.
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    halt("\r\n[MSG:Panic, drivers off, restart the controller]\r\n")
}

// The fault may be a stack overflow: SP then points below the RAM, and the first push of an ordinary handler would
// fault again and lock the core up with the drivers on. So SP is reloaded before anything is pushed.
core::arch::global_asm!(
    ".section .HardFault, \"ax\", %progbits",
    ".global HardFault",
    ".type HardFault, %function",
    ".thumb_func",
    "HardFault:",
    "ldr r0, =_stack_start",
    "msr msp, r0",
    "b {after}",
    ".ltorg",
    ".size HardFault, . - HardFault",
    after = sym after_hard_fault,
);

extern "C" fn after_hard_fault() -> ! {
    halt("\r\n[MSG:Hard fault, drivers off, restart the controller]\r\n")
}
