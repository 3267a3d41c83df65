//! Bring-up: runs lines of counts.
#![no_std]
#![no_main]
mod boards;
use boards::stm32f407::{clock::Clock, log::LogSender, serial, step_interrupt};
use boards::{BOARD, MOTORS};
use cortex_m_rt::entry;
use hexstep::stepper::*;
use stm32f4::stm32f407 as chip;

static SHARED: Shared = Shared::new();

#[entry]
fn main() -> ! {
    static mut SEGMENTS: SegmentQueue<MOTORS> = SegmentQueue::new();
    static mut BYTES: heapless::spsc::Queue<u8, 128> = heapless::spsc::Queue::new();
    static mut SEGMENTER: Option<Segmenter<MOTORS>> = None;
    let Some(chip) = chip::Peripherals::take() else {
        panic!()
    };
    let Some(mut core) = cortex_m::Peripherals::take() else {
        panic!()
    };
    let (mut sender, receiver) = SEGMENTS.split();
    let (byte_in, mut bytes) = BYTES.split();
    BOARD.configure(&chip.RCC);
    let clock = Clock::start(&chip.RCC, &chip.FLASH, &chip.PWR, BOARD.crystal_hz);
    serial::start(
        chip.USART1,
        &chip.RCC,
        &mut core.NVIC,
        &clock,
        (BOARD.serial_transmit, BOARD.serial_receive),
        byte_in,
    );
    let mut log = LogSender::start(chip.USART2, &chip.RCC, &clock, BOARD.log_transmit);
    defmt::info!("started {=str}", BOARD.name);
    let timing = Timing::from_ns(168_000_000, 1000, 200, 200, StepMode::Pulse);
    let interpolator = Interpolator::new(receiver, &SHARED, StepMode::Pulse, timing.floor_period);
    step_interrupt::start(core.SYST, &mut core.SCB, interpolator, timing.floor_period);
    serial::send(b"\r\nGrbl 1.1h ['$' for help]\r\n");
    if clock.fault.is_some() {
        serial::send(b"[MSG:Clock fallback]\r\n");
    }
    let segmenter = SEGMENTER.insert(Segmenter::new(timing));
    let mut line = None;
    loop {
        serial::poll();
        log.poll();
        if let Some(b) = bytes.dequeue() {
            let counts = match b {
                b'1' => Some([100000; 6]),
                b'2' => Some([100000, 61803, 38197, 23607, 14590, 9017]),
                b'3' => Some([100000, 0, 0, 0, 0, 0]),
                b'4' => Some([-100000, 100000, 100000, 0, 0, 0]),
                b'!' => panic!(),
                _ => None,
            };
            if let Some(c) = counts {
                BOARD.enable_drivers(true);
                line = CountLine::new(
                    c,
                    100000 * 600,
                    Preset::Published,
                    &timing,
                    &segmenter.counts(),
                )
                .ok();
                serial::send(if line.is_some() {
                    b"ok\r\n"
                } else {
                    b"error:1\r\n"
                });
            }
            if b == b'?' {
                serial::send(if line.is_none() && sender.len() == 0 {
                    b"<Idle>\r\n"
                } else {
                    b"<Run>\r\n"
                });
            }
        }
        if let Some(l) = &mut line {
            if l.feed(segmenter, &mut sender) {
                line = None;
            }
        }
        cortex_m::asm::wfi();
    }
}
