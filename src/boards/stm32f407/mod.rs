//! STM32F405/F407 at 168 MHz: clocks, pins, step timer, serial line, log, safe state.
//!
//! | file | what |
//! |---|---|
//! | `clock` | crystal and PLL with bounded waits, fallback reported |
//! | `pins` | pin tables and the stores that move pins |
//! | `priority` | who may interrupt whom; the critical section |
//! | `step_interrupt` | SysTick: the interpolator's ticks |
//! | `serial` | USART1, the protocol's line |
//! | `log` | USART2, log frames |
//! | `safe_state` | panic and hard fault |

pub mod clock;
mod handover;
pub mod log;
pub mod pins;
pub mod priority;
mod safe_state;
pub mod serial;
pub mod step_interrupt;
