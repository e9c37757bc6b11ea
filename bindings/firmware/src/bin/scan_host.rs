//! The recorded scan on this machine: what a chip must send, a line for each message: the frame that it follows, and
//! its bytes. With an argument in steps of so many microseconds instead.

use erard_firmware::{LONG_STEP_S, Scanned};
use erard_midi::Message;

fn main() {
    let asked_us = std::env::args().nth(1).map(|us| us.parse::<f64>().expect("a step in microseconds"));
    let step_s = asked_us.map_or(LONG_STEP_S, |us| 1e-6 * us);
    let mut scan = Scanned::<f32>::new(step_s).expect("the grand is sound");
    let mut frame = 0;
    let tell = |frame: usize, message: Message| println!("midi {frame} {:02x?}", message.bytes());
    while scan.frame(&mut |message| tell(frame, message)) {
        frame += 1;
    }
    let rest = scan.keys().iter().filter(|key| key.is_asleep()).count();
    scan.end(&mut |message| tell(frame, message));
    println!("steps {}", scan.keys().iter().map(|key| key.steps()).sum::<u64>());
    println!("at rest {rest}");
}
