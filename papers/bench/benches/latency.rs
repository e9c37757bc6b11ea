//! The worst step, not the mean: every one of ten million steps of random playing timed by itself, and as many grands'
//! steps side by side in the lanes of the batch, each with a player of its own.
//!
//! `cargo bench -p erard-bench --bench latency`, `-- --steps N` for fewer. Times include the clock's own reading
//! (printed). The slowest steps by the clock are those that the operating system interrupts; the slowest by work
//! (Newton iterations, active sets) is printed beside, because it repeats.

use erard_bench::Effort;
use erard_bench::latency::{Latency, clock_ns, of_group_steps, of_steps};
use moreau_kernels::Lanes;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let steps: u64 = arguments.iter().position(|a| a == "--steps").map_or(Effort::USUAL.single_steps, |at| {
        let steps = arguments.get(at + 1).and_then(|v| v.parse().ok());
        steps.filter(|steps| *steps >= 8).expect("--steps needs a number of at least 8")
    });
    let goes_on = "nobody interrupts";
    let one = of_steps(steps, &mut |_| true).expect(goes_on);
    let lanes = Lanes::most();
    let group = of_group_steps(steps / lanes.count() as u64, lanes, &mut |_| true).expect(goes_on);
    println!("{:<26} {:>12} {:>12}", "", "one grand", format!("{} at once", lanes.count()));
    println!("{:<26} {:>12} {:>12}", "steps_timed", one.steps, group.steps);
    for (name, time) in TIMES {
        println!("{name:<26} {:>12} {:>12}", time(&one), time(&group));
    }
    println!("{:<26} {:>12} {:>12}", "steps_not_converged", one.unconverged_steps, group.unconverged_steps);
    println!("{:<26} {:>12}", "newton_iterations_max", one.newton_iterations_max);
    println!("{:<26} {:>12}", "active_sets_max", one.active_sets_max);
    println!("{:<26} {:>12}", "clock_ns", clock_ns());
}

/// A time of a latency, ns.
type Time = fn(&Latency) -> u64;

const TIMES: [(&str, Time); 4] = [
    ("step_ns_p50", |l| l.p50_ns),
    ("step_ns_p99", |l| l.p99_ns),
    ("step_ns_p9999", |l| l.p9999_ns),
    ("step_ns_max", |l| l.max_ns),
];
