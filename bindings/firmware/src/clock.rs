//! Counts instructions in QEMU, and finds how far a stack was used.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// With QEMU's `-icount shift=0` an instruction takes a nanosecond, and the clock of these machines ticks at 25 MHz:
/// every 40 instructions.
const PER_TICK: u64 = 40;
/// What the stack is painted with before it is used.
const PAINT: u32 = 0xa11d_a7a5;
/// So much of the stack is painted: more than any run needs.
const PAINTED_BYTES: usize = 256 * 1024;

/// Starts the clock.
pub fn start(mut clock: SYST) {
    clock.set_clock_source(SystClkSource::Core);
    clock.set_reload(0x00ff_ffff);
    clock.clear_current();
    clock.enable_counter();
}

/// Instructions that something takes, at most 600 million.
pub fn instructions(work: impl FnOnce()) -> u64 {
    let before = SYST::get_current();
    work();
    // It counts down, in 24 bits.
    u64::from(before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff) * PER_TICK
}

/// Paints the stack below, and afterwards finds how far it was used.
#[inline(never)]
pub fn stack_bytes(work: fn()) -> usize {
    let here = cortex_m::register::msp::read() as usize;
    let (top, bottom) = ((here - 256) & !3, (here - PAINTED_BYTES) & !3);
    for place in (bottom..top).step_by(4) {
        // SAFETY: `place` is aligned to four bytes and lies in the stack's own memory, 256 bytes or more below all that
        // is in use.
        unsafe { core::ptr::write_volatile(place as *mut u32, PAINT) };
    }
    work();
    // SAFETY: `place` is aligned to four bytes and lies in the memory that was painted above.
    let untouched =
        (bottom..top).step_by(4).take_while(|place| unsafe { core::ptr::read_volatile(*place as *const u32) } == PAINT);
    here - bottom - 4 * untouched.count()
}
