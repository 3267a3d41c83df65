//! What the foreground needs from hardware. A board of memory implements it on the host.

/// A board, as seen by the foreground; none of these waits.
pub trait Board {
    /// Counts per second of the step timer.
    const TICK_HZ: u32;

    /// Hands a byte to the serial line; `false` while it has no room.
    fn send(&mut self, byte: u8) -> bool;
    /// Switches all motor drivers on or off.
    fn enable_drivers(&mut self, on: bool);
    /// New step mode of the interpolator; called with the motors at rest only.
    fn set_step_mode(&mut self, mode: crate::stepper::StepMode);
    /// Whether the probe touches now.
    fn touches(&self) -> bool {
        false
    }
    /// Why the clock does not run as it should, in words, if so: every time would be wrong.
    fn clock_fault(&self) -> Option<&'static str> {
        None
    }
}
