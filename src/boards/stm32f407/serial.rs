//! USART1, the protocol's line: bytes in by interrupt, bytes out by interrupt and by polling.
//!
//! Receiving: the interrupt takes each byte within its 87 us at 115200 baud and hands it on. Sending: the
//! foreground puts bytes into a ring; the interrupt empties it when the transmitter is free. The foreground polls as
//! well, which starts the sending, and keeps it up where the transmitter raises no interrupt (QEMU 7.2).

use core::cell::RefCell;
use critical_section::Mutex;
use heapless::Deque;
use hexstep::protocol::Receiver;
use stm32f4::stm32f407::{self as chip, interrupt};

use super::clock::Clock;
use super::handover::Handover;
use super::pins::Pin;
use super::priority;

/// Bytes that may wait to be sent. The controller keeps its answers until there is room, so this only has to bridge
/// the time between two turns of the foreground: 64 bytes are 5.5 ms.
const CAPACITY: usize = 64;
/// Alternate function 7 is USART1 to USART3 on every pin that has it.
const USART_FUNCTION: u32 = 7;
const BAUD: u32 = 115_200;

static RECEIVER: Handover<Receiver<'static>> = Handover::new();

static WAITING: Mutex<RefCell<Deque<u8, CAPACITY>>> = Mutex::new(RefCell::new(Deque::new()));

/// Starts USART1 at 115200 baud 8N1. From now on every received byte goes to `receiver`.
pub fn start(
    usart: chip::USART1,
    rcc: &chip::RCC,
    nvic: &mut chip::NVIC,
    clock: &Clock,
    (transmit, receive): (Pin, Pin),
    receiver: Receiver<'static>,
) {
    // SAFETY: the interrupt is enabled further down, and once, because the peripheral is handed over.
    unsafe { RECEIVER.give(receiver) };
    rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
    let _ = rcc.apb2enr().read();
    transmit.make_alternate(USART_FUNCTION);
    receive.make_alternate(USART_FUNCTION);
    // SAFETY: with 16-fold oversampling every divider from 16 up is valid, and both bus clocks give at least 138.
    usart
        .brr()
        .write(|w| unsafe { w.bits(clock.apb2_divider(BAUD)) });
    usart.cr1().write(|w| {
        let w = w.te().enabled().re().enabled();
        w.rxneie().enabled().ue().enabled()
    });
    // SAFETY (both): the priority is at or below the mask of critical sections, on which their soundness rests, and
    // everything the handler uses is in place.
    unsafe {
        nvic.set_priority(chip::Interrupt::USART1, priority::SERIAL);
        cortex_m::peripheral::NVIC::unmask(chip::Interrupt::USART1);
    }
}

/// Queues `byte` for sending; `false` while there is no room. Never waits.
pub fn send(byte: u8) -> bool {
    critical_section::with(|token| WAITING.borrow(token).borrow_mut().push_back(byte).is_ok())
}

/// Moves one waiting byte to the transmitter if that is free. Never waits.
pub fn poll() {
    critical_section::with(|token| {
        // SAFETY: sending registers are only touched here, inside a critical section.
        let usart = unsafe { chip::USART1::steal() };
        if usart.sr().read().txe().bit_is_set() {
            match WAITING.borrow(token).borrow_mut().pop_front() {
                Some(byte) => {
                    usart.dr().write(|w| w.dr().set(byte.into()));
                    usart.cr1().modify(|_, w| w.txeie().enabled());
                }
                None => {
                    usart.cr1().modify(|_, w| w.txeie().disabled());
                }
            }
        }
    });
}

/// Serial interrupt, priority 0x40. Deadline: one byte time, 87 us or 14 600 cycles, after which the next byte
/// overwrites this one; it is longer than the step interrupt can delay it.
#[interrupt]
fn USART1() {
    // SAFETY: reading the data register is done by this handler alone.
    let usart = unsafe { chip::USART1::steal() };
    if usart.sr().read().rxne().bit_is_set() {
        let byte = usart.dr().read().bits() as u8;
        // SAFETY: called by this handler alone, which `start` enables after the value is in place.
        let receiver = unsafe { RECEIVER.owned() };
        receiver.receive(byte);
    }
    poll();
}

/// Sends `message` with interrupts off, dropping what was waiting. Gives up on a transmitter that never gets free.
pub fn send_last_words(message: &str) {
    /// Looks at the flag: a byte takes 14 600 cycles, a look at least four.
    const PATIENCE: u32 = 10_000;
    // SAFETY: interrupts are off for good and the caller never returns to the code it interrupted.
    let usart = unsafe { chip::USART1::steal() };
    for byte in message.bytes() {
        if !(0..PATIENCE).any(|_| usart.sr().read().txe().bit_is_set()) {
            return;
        }
        usart.dr().write(|w| w.dr().set(byte.into()));
    }
}
