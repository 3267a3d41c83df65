//! A board's pins as data: [`Pin`], [`MotorPins`], [`BoardPins`], and what the chip does with them.
//!
//! Levels: step and direction pins start low, drivers are enabled by a low level and start disabled.

use stm32f4::stm32f407 as chip;

/// A GPIO port of the chip; the number is its place in the address map.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(dead_code)] // A board uses the ports it is wired to.
pub enum Port {
    A,
    B,
    C,
    D,
    E,
    F,
    G,
    H,
    I,
}

impl Port {
    const COUNT: usize = 9;

    /// The port's registers. One block describes all ports: they have the same layout and differ in reset values alone.
    fn registers(self) -> &'static chip::gpioi::RegisterBlock {
        let base = chip::GPIOA::ptr() as usize + 0x400 * self as usize;
        // SAFETY: the reference manual (RM0090, memory map) places ports A to I at intervals of 0x400 from GPIOA on,
        // and `self as usize` is at most 8. Registers are only reached through volatile accesses.
        unsafe { &*(base as *const chip::gpioi::RegisterBlock) }
    }
}

/// One pin, e.g. `Pin::new(Port::E, 9)` for PE9.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    pub port: Port,
    pub number: u8,
}

impl Pin {
    /// Pin `number`, 0 to 15, of `port`; a larger number does not compile in a constant.
    pub const fn new(port: Port, number: u8) -> Self {
        assert!(number < 16);
        Self { port, number }
    }

    /// Puts the pin high or low in one store that touches no other pin of the port.
    pub fn write(self, high: bool) {
        let half = if high { 0 } else { 16 };
        SetReset::of(self.port).store(1 << (u32::from(self.number) + half));
    }

    /// Push-pull output at `level`. The level is written before the mode, so the pin never shows another one.
    fn make_output(self, level: bool) {
        self.write(level);
        self.set_field(Field::Mode, 0b01);
    }

    /// Input with pull-up, as switches to ground need it.
    fn make_input(self) {
        self.set_field(Field::Pull, 0b01);
        self.set_field(Field::Mode, 0b00);
    }

    /// Hands the pin to peripheral function `function`, 0 to 15 (data sheet, alternate function mapping).
    pub(super) fn make_alternate(self, function: u32) {
        let registers = self.port.registers();
        let shift = 4 * (u32::from(self.number) & 7);
        let merged = |bits: u32| (bits & !(0xF << shift)) | (function << shift);
        // SAFETY (both): every four-bit value is an alternate function number; the other pins' bits are kept.
        if self.number < 8 {
            registers
                .afrl()
                .modify(|r, w| unsafe { w.bits(merged(r.bits())) });
        } else {
            registers
                .afrh()
                .modify(|r, w| unsafe { w.bits(merged(r.bits())) });
        }
        self.set_field(Field::Pull, 0b01);
        self.set_field(Field::Mode, 0b10);
    }

    fn set_field(self, field: Field, value: u32) {
        let registers = self.port.registers();
        let shift = 2 * u32::from(self.number);
        let merged = |bits: u32| (bits & !(0b11 << shift)) | (value << shift);
        // SAFETY (both): every two-bit value is a mode, and none but 0b11 (never used here) is reserved as a pull.
        match field {
            Field::Mode => registers
                .moder()
                .modify(|r, w| unsafe { w.bits(merged(r.bits())) }),
            Field::Pull => registers
                .pupdr()
                .modify(|r, w| unsafe { w.bits(merged(r.bits())) }),
        };
    }
}

enum Field {
    Mode,
    Pull,
}

/// The set/reset register of a port: bits 0..=15 of a word put pins high, bits 16..=31 put pins low, others stay.
#[derive(Clone, Copy)]
pub struct SetReset(&'static chip::gpioi::BSRR);

// SAFETY: the register is write-only and a store to it is one access, so any context may use any copy.
unsafe impl Send for SetReset {}

impl SetReset {
    pub fn of(port: Port) -> Self {
        Self(port.registers().bsrr())
    }

    #[inline(always)]
    pub fn store(self, word: u32) {
        // SAFETY: every word is valid, and the store needs no read before it, so two contexts that write different
        // pins of one port cannot disturb each other.
        self.0.write(|w| unsafe { w.bits(word) });
    }
}

/// The pins of one motor.
pub struct MotorPins {
    pub step: Pin,
    pub direction: Pin,
    /// Driver enable, active low.
    pub enable: Pin,
    pub end_stop: Pin,
}

/// All a board is, seen from here.
pub struct BoardPins<const N: usize> {
    pub name: &'static str,
    /// Crystal frequency [Hz], a whole number of MHz.
    pub crystal_hz: u32,
    pub motors: [MotorPins; N],
    /// USART1: the protocol.
    pub serial_transmit: Pin,
    pub serial_receive: Pin,
    /// USART2: log frames.
    pub log_transmit: Pin,
}

/// The ports that some pins lie on, each once, in the order of the pins; the first `count` places count.
pub struct Ports<const N: usize> {
    pub ports: [Port; N],
    pub count: usize,
}

impl<const N: usize> BoardPins<N> {
    pub const fn step_ports(&self) -> Ports<N> {
        let mut pins = [self.motors[0].step; N];
        let mut i = 0;
        while i < N {
            pins[i] = self.motors[i].step;
            i += 1;
        }
        ports_of(pins)
    }

    pub const fn direction_ports(&self) -> Ports<N> {
        let mut pins = [self.motors[0].direction; N];
        let mut i = 0;
        while i < N {
            pins[i] = self.motors[i].direction;
            i += 1;
        }
        ports_of(pins)
    }

    /// Powers the ports and puts every pin into its safe state: drivers off, step and direction low.
    pub fn configure(&self, rcc: &chip::RCC) {
        const ALL_PORTS: u32 = (1 << Port::COUNT) - 1;
        // SAFETY: bits 0 to 8 of this register enable ports A to I and nothing else.
        rcc.ahb1enr()
            .modify(|r, w| unsafe { w.bits(r.bits() | ALL_PORTS) });
        // The port's clock runs two bus cycles after the enabling store (errata 2.1.6): read back before use.
        let _ = rcc.ahb1enr().read();
        for motor in &self.motors {
            motor.enable.make_output(true);
            motor.step.make_output(false);
            motor.direction.make_output(false);
            motor.end_stop.make_input();
        }
    }

    /// Switches all drivers on or off.
    pub fn enable_drivers(&self, on: bool) {
        for motor in &self.motors {
            motor.enable.write(!on);
        }
    }

    /// What must hold after a panic or a hard fault: drivers off, step pins inactive. Needs no state, cannot fail.
    pub fn make_safe(&self) {
        for motor in &self.motors {
            motor.enable.write(true);
            motor.step.write(false);
        }
    }
}

const fn ports_of<const N: usize>(pins: [Pin; N]) -> Ports<N> {
    let mut ports = [pins[0].port; N];
    let mut count = 0;
    let mut i = 0;
    while i < N {
        let mut known = false;
        let mut k = 0;
        while k < count {
            known |= ports[k] as u8 == pins[i].port as u8;
            k += 1;
        }
        if !known {
            ports[count] = pins[i].port;
            count += 1;
        }
        i += 1;
    }
    Ports { ports, count }
}
