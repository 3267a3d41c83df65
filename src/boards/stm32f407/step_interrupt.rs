//! The step interrupt: SysTick at the highest priority, and the pins and the timer behind the interpolator's traits.
//!
//! SysTick is the step timer because its reload register is double-buffered by nature (a value written in the handler
//! counts from the next wrap), it has no flag to clear, and it stands in no bus queue.

use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::exception;
use hexstep::stepper::port::PinAt;
use hexstep::stepper::{Interpolator, RegisterPort, SetResetRegister, StepMode, StepTimer};

use super::handover::Handover;
use super::pins::{BoardPins, Pin, Port, SetReset};
use super::priority;
use crate::boards::{BOARD, MOTORS};

/// Step pins lie on this many ports, direction pins on that many; each costs one store.
const STEP_PORTS: usize = BOARD.step_ports().count;
const DIRECTION_PORTS: usize = BOARD.direction_ports().count;

type Pins = RegisterPort<SetReset, STEP_PORTS, DIRECTION_PORTS, { 1 << MOTORS }>;

/// What the handler owns. In this order: the interpolator stays within reach of one base register, whatever the size of
/// the tables behind it.
#[repr(C)]
struct Context {
    interpolator: Interpolator<'static, MOTORS>,
    pins: Pins,
}

static CONTEXT: Handover<Context> = Handover::new();

impl SetResetRegister for SetReset {
    #[inline(always)]
    fn write(&mut self, word: u32) {
        self.store(word);
    }
}

struct ReloadRegister;

impl StepTimer for ReloadRegister {
    #[inline(always)]
    fn set_period(&mut self, counts: u32) {
        // SAFETY: the reload register belongs to the step interrupt once it runs. The timer has 24 bits; the longest
        // period is that of the tick floor, 4200 counts.
        unsafe { (*SYST::PTR).rvr.write(counts.wrapping_sub(1) & 0x00FF_FFFF) };
    }
}

/// Starts the ticks. Takes the timer's registers for good, so it can happen once only.
pub fn start(
    mut timer: SYST,
    scb: &mut SCB,
    interpolator: Interpolator<'static, MOTORS>,
    first_period: u32,
) {
    let context = Context {
        interpolator,
        pins: pins(&BOARD),
    };
    // SAFETY: the timer is not running yet (it was handed over), so the handler cannot run meanwhile.
    unsafe { CONTEXT.give(context) };
    // SAFETY: the handler takes no critical section, so it may run above their mask.
    unsafe { scb.set_priority(SystemHandler::SysTick, priority::STEP) };
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(first_period.wrapping_sub(1));
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

/// Changes the step mode of the interpolator; with the motors at rest only, since ticks stand still meanwhile.
pub fn set_mode(mode: StepMode) {
    const TICK_INTERRUPT: u32 = 1 << 1;
    // SAFETY: after `start` the timer's control register is written here alone; the handler writes the reload register.
    unsafe { (*SYST::PTR).csr.modify(|bits| bits & !TICK_INTERRUPT) };
    // A wrap just before may have left the interrupt pending; it would then run once more.
    SCB::clear_pendst();
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    // SAFETY: the handler cannot run: its interrupt is off and not pending. The reference ends before it is on again.
    unsafe { CONTEXT.owned() }.interpolator.set_mode(mode);
    // SAFETY: as above; the register is as `start` left it but for this bit.
    unsafe { (*SYST::PTR).csr.modify(|bits| bits | TICK_INTERRUPT) };
}

/// Step interrupt. Deadline: the present period, 240 counts at the highest rate. Cost: see `cargo xtask bench`,
/// `isr_w1_instructions` and `isr_w1_cycles_model`. A tick that comes late moves all motors late, together; none is
/// lost unless two are due at once.
#[exception]
fn SysTick() {
    // SAFETY: called by this handler alone, which is enabled at the end of `start`, after the value is in place.
    let context = unsafe { CONTEXT.owned() };
    context
        .interpolator
        .tick(&mut context.pins, &mut ReloadRegister);
}

fn pins(board: &BoardPins<MOTORS>) -> Pins {
    let step_ports = board.step_ports();
    let direction_ports = board.direction_ports();
    let at = |pin: Pin, ports: &[Port]| PinAt {
        register: ports
            .iter()
            .position(|port| *port == pin.port)
            .unwrap_or(usize::MAX),
        pin: pin.number,
        inverted: false,
    };
    RegisterPort::new(
        core::array::from_fn(|i| SetReset::of(step_ports.ports[i])),
        &board
            .motors
            .each_ref()
            .map(|motor| at(motor.step, &step_ports.ports)),
        core::array::from_fn(|i| SetReset::of(direction_ports.ports[i])),
        &board
            .motors
            .each_ref()
            .map(|motor| at(motor.direction, &direction_ports.ports)),
    )
}
