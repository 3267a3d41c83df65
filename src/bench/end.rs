//! How the emulator is told that every function has been called.

use core::hint::black_box;

#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
pub fn bench_end() {
    black_box(());
}
