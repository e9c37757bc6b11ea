//! The note on a chip: digests, instructions per step, memory. Told through semihosting.

#![no_std]
#![no_main]

#[path = "../clock.rs"]
mod clock;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use erard_firmware::{Grand, STEP_S, Work, play};
use moreau::Scalar;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

#[inline(never)]
fn run<T: Scalar>(name: &str) {
    let Ok(mut grand) = Grand::<T>::new(T::from_f64(STEP_S)) else { return };
    let (mut sum, mut worst, mut slow, mut count) = (0_u64, 0_u64, Work::default(), 0_u64);
    let note = play(&mut grand, &mut |step| {
        let mut work = Work::default();
        let instructions = clock::instructions(|| work = step());
        if instructions > worst {
            (worst, slow) = (instructions, work);
        }
        sum += instructions;
        count += 1;
    });
    hprintln!(
        "{} {:016x} mean {} worst {} in step {} of {} iterations and {} active sets; object {} bytes",
        name,
        note.digest,
        sum / count,
        worst,
        slow.step,
        slow.newton,
        slow.solver,
        size_of::<Grand<T>>()
    );
}

#[entry]
fn main() -> ! {
    let Some(own) = cortex_m::Peripherals::take() else { panic!() };
    clock::start(own.SYST);
    let single = clock::stack_bytes(|| run::<f32>("f32"));
    hprintln!("f32 stack {} bytes", single);
    if cfg!(feature = "double") {
        let double = clock::stack_bytes(|| run::<f64>("f64"));
        hprintln!("f64 stack {} bytes", double);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
