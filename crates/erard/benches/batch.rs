//! Many grands at once: one after the other, four in the lanes of one core, and in lanes on all cores, in turn within one run.
//!
//! `cargo bench -p erard --bench batch`, `-- --rounds N` for more or fewer than 21. Two loads: a parameter study (the same note on
//! grands of other weight and stiffness) and a fortissimo tremolo in which every lane is in another phase of its stroke. Times are per
//! step of one grand; a ratio is one of medians.

use erard::bench::{Effort, Load, Times, instruction_sets, load_times};
use erard::cores;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let rounds: usize = arguments.iter().position(|a| a == "--rounds").map_or(Effort::USUAL.rounds, |at| {
        let rounds = arguments.get(at + 1).and_then(|v| v.parse().ok());
        rounds.filter(|rounds| *rounds > 0).expect("--rounds needs a number")
    });
    let (steps, groups) = (Effort::USUAL.steps, Effort::USUAL.groups_per_core * cores::count());
    println!("{} cores; {}", cores::count(), instruction_sets().join(", "));
    let loads = [("parameter study", Load::parameter_study(groups, steps)), ("tremolo", Load::tremolo(groups, steps))];
    for (name, load) in &loads {
        let times = load_times(load, rounds, &mut |_| true).expect("nobody interrupts");
        let lanes = if load.in_lanes() { "4 in lanes, one core" } else { "4 one by one (no lanes here)" };
        println!("\n{name}: {rounds} rounds of {steps} steps\n");
        println!(
            "  {:<30} {:>12} {:>12} {:>12} {:>8}",
            "ns a step of one grand", "median", "quartile", "quartile", "speed"
        );
        for (what, times, speed) in [
            ("one after the other, one core", times.one_by_one, 1.0),
            (lanes, times.lanes, times.speedup_per_core()),
            ("in lanes, all cores", times.all_cores, times.speedup_all_cores()),
        ] {
            let Times { median, lower_quartile, upper_quartile, .. } = times;
            println!("  {what:<30} {median:>12.1} {lower_quartile:>12.1} {upper_quartile:>12.1} {speed:>7.2}x");
        }
    }
}
