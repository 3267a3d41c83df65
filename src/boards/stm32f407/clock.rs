//! Clock start: crystal and PLL to 168 MHz with bounded waits, or the internal oscillator and a report of why.
//!
//! ```text
//! crystal -- /M = 1 MHz --> x336 --> /2 = 168 MHz core --> /4 = 42 MHz APB1
//!                                                      \-> /2 = 84 MHz APB2
//! ```
//!
//! No wait is without an end: a board with a broken crystal must still answer on its serial line, and the emulator
//! has no oscillators at all. Registers and order follow RM0090, sections 5.1.4, 3.5.1 and 7.

use stm32f4::stm32f407 as chip;

/// Core clock after a full start [Hz]; the step timer counts at this rate.
pub const CORE_HZ: u32 = 168_000_000;
/// Frequency of the internal oscillator [Hz], the core clock after a fallback.
const INTERNAL_HZ: u32 = 16_000_000;
/// How often a ready flag is looked at before giving up. A look takes at least four cycles of the 16 MHz oscillator,
/// so 100 000 looks are at least 25 ms; the data sheet names 2 ms for the crystal and 0.3 ms for the PLL.
const PATIENCE: u32 = 100_000;

/// Why the clock start fell back to the internal oscillator.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum ClockFault {
    /// The core could not be taken off the clock that a bootloader has left it on.
    Internal,
    /// The crystal did not start.
    Crystal,
    /// The PLL did not lock.
    Pll,
    /// The core did not switch over to the PLL.
    Switch,
}

impl ClockFault {
    /// What to tell the operator.
    pub fn text(self) -> &'static str {
        match self {
            Self::Internal => "internal oscillator silent",
            Self::Crystal => "crystal silent, running on the internal oscillator",
            Self::Pll => "PLL not locked, running on the internal oscillator",
            Self::Switch => "no switch to the PLL, running on the internal oscillator",
        }
    }
}

/// What the clock start came to.
#[derive(Clone, Copy)]
pub struct Clock {
    /// Clock of the bus of USART1 [Hz].
    pub apb2_hz: u32,
    /// Clock of the bus of USART2 [Hz].
    pub apb1_hz: u32,
    /// `None` after a full start. Otherwise time is wrong by a factor of ten, and motion is refused.
    pub fault: Option<ClockFault>,
}

impl Clock {
    /// Starts the clocks from a crystal of `crystal_hz`, a whole number of MHz between 2 and 63.
    pub fn start(rcc: &chip::RCC, flash: &chip::FLASH, pwr: &chip::PWR, crystal_hz: u32) -> Self {
        match Self::start_pll(rcc, flash, pwr, crystal_hz) {
            Ok(()) => Self {
                apb2_hz: CORE_HZ / 2,
                apb1_hz: CORE_HZ / 4,
                fault: None,
            },
            Err(fault) => {
                rcc.cfgr()
                    .modify(|_, w| w.sw().hsi().ppre1().div1().ppre2().div1());
                Self {
                    apb2_hz: INTERNAL_HZ,
                    apb1_hz: INTERNAL_HZ,
                    fault: Some(fault),
                }
            }
        }
    }

    /// Divider of USART1 for `baud`, to the nearest whole number.
    pub fn apb2_divider(&self, baud: u32) -> u16 {
        ((self.apb2_hz + baud / 2) / baud) as u16
    }

    /// Divider of USART2 for `baud`, to the nearest whole number.
    pub fn apb1_divider(&self, baud: u32) -> u16 {
        ((self.apb1_hz + baud / 2) / baud) as u16
    }

    fn start_pll(
        rcc: &chip::RCC,
        flash: &chip::FLASH,
        pwr: &chip::PWR,
        crystal_hz: u32,
    ) -> Result<(), ClockFault> {
        // A bootloader may have left the core on the PLL, which can then not be set up anew.
        rcc.cr().modify(|_, w| w.hsion().on());
        if !becomes(|| rcc.cr().read().hsirdy().is_ready()) {
            return Err(ClockFault::Internal);
        }
        rcc.cfgr().modify(|_, w| w.sw().hsi());
        if !becomes(|| rcc.cfgr().read().sws().is_hsi()) {
            return Err(ClockFault::Internal);
        }
        rcc.cr().modify(|_, w| w.hseon().on());
        if !becomes(|| rcc.cr().read().hserdy().is_ready()) {
            return Err(ClockFault::Crystal);
        }
        // Above 144 MHz the regulator must be in scale 1 (the reset state, written in case a bootloader changed it).
        rcc.apb1enr().modify(|_, w| w.pwren().enabled());
        let _ = rcc.apb1enr().read();
        pwr.cr().modify(|_, w| w.vos().set_bit());

        let to_one_mhz = (crystal_hz / 1_000_000).clamp(2, 63) as u8;
        rcc.cr().modify(|_, w| w.pllon().off());
        // SAFETY (the three fields): M is 2..=63, N is 50..=432, Q is 2..=15, the ranges of RM0090 7.3.2.
        rcc.pllcfgr().write(|w| unsafe {
            w.pllsrc()
                .hse()
                .pllm()
                .bits(to_one_mhz)
                .plln()
                .bits(336)
                .pllp()
                .div2()
                .pllq()
                .bits(7)
        });
        rcc.cr().modify(|_, w| w.pllon().on());
        if !becomes(|| rcc.cr().read().pllrdy().is_ready()) {
            return Err(ClockFault::Pll);
        }
        // Flash needs five wait states at 168 MHz and 3.3 V; they must be in force before the switch.
        flash.acr().write(|w| {
            w.latency()
                .ws5()
                .prften()
                .enabled()
                .icen()
                .enabled()
                .dcen()
                .enabled()
        });
        if !becomes(|| flash.acr().read().latency().is_ws5()) {
            return Err(ClockFault::Switch);
        }
        rcc.cfgr()
            .modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2());
        rcc.cfgr().modify(|_, w| w.sw().pll());
        if !becomes(|| rcc.cfgr().read().sws().is_pll()) {
            return Err(ClockFault::Switch);
        }
        Ok(())
    }
}

/// Whether `condition` becomes true within [`PATIENCE`] looks.
fn becomes(condition: impl Fn() -> bool) -> bool {
    (0..PATIENCE).any(|_| condition())
}
