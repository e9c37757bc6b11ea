//! The recorded scan on a chip: bytes of MIDI, instructions of every frame, memory. Told through semihosting.

#![no_std]
#![no_main]

#[path = "../clock.rs"]
mod clock;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use erard_firmware::{FRAMES, Key, Keys, LONG_STEP_S, Scanned};
use erard_midi::Message;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {}
}

/// Messages of a frame that are printed once it has been counted; more than come of ten keys in one.
const ROOM: usize = 64;

#[inline(never)]
fn run() {
    let Some(mut scan) = Scanned::<f32>::new(LONG_STEP_S) else { return };
    for frame in 0..=FRAMES {
        let (mut messages, mut count) = ([None::<Message>; ROOM], 0);
        let mut keep = |message: Message| {
            if let Some(place) = messages.get_mut(count) {
                *place = Some(message);
            }
            count += 1;
        };
        let before: u64 = scan.keys().iter().map(Key::steps).sum();
        let instructions = clock::instructions(|| {
            if !scan.frame(&mut keep) {
                scan.end(&mut keep);
            }
        });
        let steps = scan.keys().iter().map(Key::steps).sum::<u64>() - before;
        messages.iter().flatten().for_each(|message| hprintln!("midi {} {:02x?}", frame, message.bytes()));
        if count > ROOM {
            hprintln!("{} messages in a frame", count);
        }
        if frame < FRAMES {
            hprintln!("frame {} {} {}", frame, steps, instructions);
        }
    }
    let steps: u64 = scan.keys().iter().map(Key::steps).sum();
    let unconverged: u32 = scan.keys().iter().map(Key::unconverged).sum();
    hprintln!("steps {}", steps);
    hprintln!("unconverged {}", unconverged);
    hprintln!("a key {} bytes, all share {} bytes", size_of::<Key<f32>>(), size_of::<Keys<f32>>());
}

#[entry]
fn main() -> ! {
    let Some(own) = cortex_m::Peripherals::take() else { panic!() };
    clock::start(own.SYST);
    let stack = clock::stack_bytes(run);
    hprintln!("stack {} bytes with ten keys and what they share", stack);
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}
