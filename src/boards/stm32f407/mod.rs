//! STM32F405/F407 at 168 MHz: clocks, pins, step timer, serial line, log, safe state.
//!
//! | file | what |
//! |---|---|
//! | `clock` | crystal and PLL with bounded waits, fallback reported |
//! | `pins` | pin tables and the stores that move pins |
//! | `priority` | who may interrupt whom; the critical section |
//! | `handover` | giving a value to an interrupt for good |
//! | `step_interrupt` | SysTick: the interpolator's ticks |
//! | `serial` | USART1, the protocol's line |
//! | `log` | USART2, log frames |
//! | `safe_state` | panic and hard fault |

mod clock;
mod handover;
mod log;
pub mod pins;
mod priority;
mod safe_state;
mod serial;
mod step_interrupt;

use hexstep::board::Board;
use hexstep::protocol::Receiver;
use hexstep::stepper::{Interpolator, StepMode};
use stm32f4::stm32f407 as chip;

use super::{BOARD, MOTORS};
use clock::{CORE_HZ, Clock, ClockFault};
use log::LogSender;

/// Tick while the motors rest: 40 kHz [timer counts].
pub const REST_PERIOD: u32 = CORE_HZ / hexstep::stepper::Timing::FLOOR_HZ;

/// The running hardware, as far as the foreground has to do with it.
pub struct Hardware {
    log: LogSender,
    clock_fault: Option<ClockFault>,
}

impl Hardware {
    /// Starts everything, drivers off: pins first, then clocks, serial line and log, and the step interrupt last.
    /// `None` when it has been started before. Out of line: the pin tables are on the stack first, for a while only.
    #[inline(never)]
    pub fn start(
        receiver: Receiver<'static>,
        interpolator: Interpolator<'static, MOTORS>,
    ) -> Option<Self> {
        let chip = chip::Peripherals::take()?;
        let mut core = cortex_m::Peripherals::take()?;
        BOARD.configure(&chip.RCC);
        let clock = Clock::start(&chip.RCC, &chip.FLASH, &chip.PWR, BOARD.crystal_hz);
        serial::start(
            chip.USART1,
            &chip.RCC,
            &mut core.NVIC,
            &clock,
            (BOARD.serial_transmit, BOARD.serial_receive),
            receiver,
        );
        let log = LogSender::start(chip.USART2, &chip.RCC, &clock, BOARD.log_transmit);
        match clock.fault {
            None => defmt::info!("{=str}: started", BOARD.name),
            Some(fault) => defmt::warn!("{=str}: {=str}", BOARD.name, fault.text()),
        }
        step_interrupt::start(core.SYST, &mut core.SCB, interpolator, REST_PERIOD);
        Some(Self {
            log,
            clock_fault: clock.fault,
        })
    }

    /// Moves what waits to be sent. Never waits.
    pub fn poll(&mut self) {
        serial::poll();
        self.log.poll();
    }

    /// Sleeps until the next interrupt, a tick later at most.
    pub fn sleep(&self) {
        cortex_m::asm::wfi();
    }
}

impl Board for Hardware {
    const TICK_HZ: u32 = CORE_HZ;

    fn send(&mut self, byte: u8) -> bool {
        serial::send(byte)
    }

    fn enable_drivers(&mut self, on: bool) {
        defmt::info!("drivers on: {=bool}", on);
        BOARD.enable_drivers(on);
    }

    fn set_step_mode(&mut self, mode: StepMode) {
        step_interrupt::set_mode(mode);
    }

    fn clock_fault(&self) -> Option<&'static str> {
        self.clock_fault.map(ClockFault::text)
    }
}
