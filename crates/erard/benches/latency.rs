//! The worst step, not the mean: every one of ten million steps of random playing timed by itself, and as many grands' steps four at a
//! time in the lanes of the batch, each with a player of its own.
//!
//! `cargo bench -p erard --bench latency`, `-- --steps N` for fewer. Times include the clock's own reading (printed). The slowest
//! steps by the clock are those that the operating system interrupts; the slowest by work (Newton iterations, active sets) is printed
//! beside, because it repeats.

use batch::WIDTH;
use erard::bench::Effort;
use erard::bench::latency::{Latencies, of_group_steps, of_steps};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let steps: u64 = arguments.iter().position(|a| a == "--steps").map_or(Effort::USUAL.single_steps, |at| {
        let steps = arguments.get(at + 1).and_then(|v| v.parse().ok());
        steps.filter(|steps| *steps >= WIDTH as u64).expect("--steps needs a number of at least 4")
    });
    let goes_on = "nobody interrupts";
    let one = of_steps(steps, &mut |_| true).expect(goes_on);
    let four = of_group_steps(steps / WIDTH as u64, &mut |_| true).expect(goes_on);
    let latencies = serde_json::to_value(Latencies::new(&one, &four)).expect("plain numbers");
    for (name, value) in latencies.as_object().into_iter().flatten() {
        println!("{name} {value}");
    }
}
