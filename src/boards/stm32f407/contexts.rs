//! Bring-up: bytes to the foreground.
use super::pins::{Port, set_reset};
use core::cell::RefCell;
use cortex_m_rt::exception;
use critical_section::Mutex;
use heapless::Deque;

static BYTES: Mutex<RefCell<Deque<u8, 64>>> = Mutex::new(RefCell::new(Deque::new()));

pub fn on_byte(byte: u8) {
    critical_section::with(|t| {
        let _ = BYTES.borrow(t).borrow_mut().push_back(byte);
    });
}
pub fn next_byte() -> Option<u8> {
    critical_section::with(|t| BYTES.borrow(t).borrow_mut().pop_front())
}
#[exception]
fn SysTick() {
    static mut N: u32 = 0;
    *N = N.wrapping_add(1);
    let e = if *N & 1 == 0 { 1 << 9 } else { 1 << 25 };
    let d = if *N & 2 == 0 { 1 << 15 } else { 1 << 31 };
    set_reset(Port::E, e);
    set_reset(Port::D, d);
}
