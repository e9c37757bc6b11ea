//! The note on a chip: digests, instructions per step, memory. Told through semihosting.

#![no_std]
#![no_main]

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use erard_firmware::{Grand, STEP_S, Work, play};
use moreau::Scalar;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

/// With QEMU's `-icount shift=0` an instruction takes a nanosecond, and the clock of these machines ticks at 25 MHz:
/// every 40 instructions.
const PER_TICK: u64 = 40;
/// What the stack is painted with before it is used.
const PAINT: u32 = 0xa11d_a7a5;
/// So much of the stack is painted: more than any run needs.
const PAINTED_BYTES: usize = 256 * 1024;

#[inline(never)]
fn run<T: Scalar>(name: &str) {
    let Ok(mut grand) = Grand::<T>::new(T::from_f64(STEP_S)) else { return };
    let (mut sum, mut worst, mut slow, mut count) = (0_u64, 0_u64, Work::default(), 0_u64);
    let note = play(&mut grand, &mut |step| {
        let before = SYST::get_current();
        let work = step();
        // It counts down, in 24 bits.
        let ticks = u64::from(before.wrapping_sub(SYST::get_current()) & 0x00ff_ffff);
        if ticks > worst {
            (worst, slow) = (ticks, work);
        }
        sum += ticks;
        count += 1;
    });
    hprintln!(
        "{} {:016x} mean {} worst {} in step {} of {} iterations and {} active sets; object {} bytes",
        name,
        note.digest,
        sum * PER_TICK / count,
        worst * PER_TICK,
        slow.step,
        slow.newton,
        slow.solver,
        size_of::<Grand<T>>()
    );
}

/// Paints the stack below, and afterwards finds how far it was used.
#[inline(never)]
fn measured(work: fn()) -> usize {
    let here = cortex_m::register::msp::read() as usize;
    let (top, bottom) = ((here - 256) & !3, (here - PAINTED_BYTES) & !3);
    for place in (bottom..top).step_by(4) {
        // SAFETY: the stack's own memory, below all that is in use.
        unsafe { core::ptr::write_volatile(place as *mut u32, PAINT) };
    }
    work();
    // SAFETY: as above.
    let untouched =
        (bottom..top).step_by(4).take_while(|place| unsafe { core::ptr::read_volatile(*place as *const u32) } == PAINT);
    here - bottom - 4 * untouched.count()
}

#[entry]
fn main() -> ! {
    let Some(mut own) = cortex_m::Peripherals::take() else { panic!() };
    own.SYST.set_clock_source(SystClkSource::Core);
    own.SYST.set_reload(0x00ff_ffff);
    own.SYST.clear_current();
    own.SYST.enable_counter();
    let single = measured(|| run::<f32>("f32"));
    hprintln!("f32 stack {} bytes", single);
    if cfg!(feature = "double") {
        let double = measured(|| run::<f64>("f64"));
        hprintln!("f64 stack {} bytes", double);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
