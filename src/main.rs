#![no_std]
#![no_main]
mod boards;
use boards::BOARD;
use boards::stm32f407::{clock::Clock, contexts, log::LogSender, serial};
use cortex_m_rt::entry;
use stm32f4::stm32f407 as chip;

#[entry]
fn main() -> ! {
    let Some(chip) = chip::Peripherals::take() else {
        panic!()
    };
    let Some(mut core) = cortex_m::Peripherals::take() else {
        panic!()
    };
    BOARD.configure(&chip.RCC);
    let clock = Clock::start(&chip.RCC, &chip.FLASH, &chip.PWR, BOARD.crystal_hz);
    serial::start(
        &chip.USART1,
        &chip.RCC,
        &clock,
        BOARD.serial_transmit,
        BOARD.serial_receive,
    );
    let mut log = LogSender::start(chip.USART2, &chip.RCC, &clock, BOARD.log_transmit);
    serial::unmask(&mut core.NVIC);
    defmt::info!("started {=str}", BOARD.name);
    serial::send(b"\r\nGrbl 1.1h ['$' for help]\r\n");
    if clock.fault.is_some() {
        serial::send(b"[MSG:Clock fallback]\r\n");
    }
    core.SYST.set_reload(4199);
    core.SYST.clear_current();
    core.SYST
        .set_clock_source(cortex_m::peripheral::syst::SystClkSource::Core);
    core.SYST.enable_interrupt();
    core.SYST.enable_counter();
    loop {
        serial::poll();
        log.poll();
        if let Some(b) = contexts::next_byte() {
            if b == b'!' {
                panic!()
            }
            serial::send(&[b]);
        }
        cortex_m::asm::wfi();
    }
}
