//! Giving a value to an interrupt for good.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

/// A place from which one interrupt handler takes what it owns, without a lock.
pub struct Handover<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: the callers of `give` and `owned` promise that the two never overlap and that only one handler calls `owned`.
unsafe impl<T: Send> Sync for Handover<T> {}

impl<T> Handover<T> {
    pub const fn new() -> Self {
        Self(UnsafeCell::new(MaybeUninit::uninit()))
    }

    /// Puts the value in place.
    ///
    /// # Safety
    /// The interrupt whose handler calls [`Handover::owned`] must not be enabled yet.
    pub unsafe fn give(&self, value: T) {
        // SAFETY: the handler cannot run, so nothing else refers to the cell.
        unsafe { (*self.0.get()).write(value) };
    }

    /// What the handler owns.
    ///
    /// # Safety
    /// Only after [`Handover::give`], and only for one interrupt handler, once per run of it (a handler cannot interrupt
    /// itself), or for code during which that handler cannot run.
    #[inline(always)]
    #[allow(clippy::mut_from_ref)] // The promise above is what `&mut self` would check.
    pub unsafe fn owned(&self) -> &mut T {
        // SAFETY: the value is in place and the reference the only one, as the caller promises.
        unsafe { (*self.0.get()).assume_init_mut() }
    }
}
