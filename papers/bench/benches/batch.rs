//! Many grands at once: one after the other, in four lanes of one core, in eight of single precision, and in four on
//! all cores, in turn within one run.
//!
//! `cargo bench -p erard-bench --bench batch`, `-- --rounds N` for more or fewer than 21. Two loads: a parameter study
//! (the same note on grands of other weight and stiffness) and a fortissimo tremolo in which every lane is in another
//! phase of its stroke. Times are per step of one grand; a ratio is one of medians.

use erard_bench::{Effort, Load, Times, instruction_sets, load_times};
use erard_workshop::cores;
use moreau_kernels::Lanes;

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
        println!("\n{name}: {rounds} rounds of {steps} steps\n");
        println!(
            "  {:<30} {:>12} {:>12} {:>12} {:>8}",
            "ns a step of one grand", "median", "quartile", "quartile", "speed"
        );
        let mut rows = vec![("one after the other, one core".to_owned(), times.one_by_one)];
        let single = |lanes: &Lanes| if lanes.is_single() { " of single precision" } else { "" };
        let named = |(lanes, times): &(Lanes, Times)| (format!("lanes: {}{}", lanes.count(), single(lanes)), *times);
        rows.extend(times.lanes.iter().map(named));
        rows.push((format!("lanes: {}, all cores", Lanes::most().count()), times.all_cores));
        for (what, row) in rows {
            let Times { median, lower_quartile, upper_quartile, .. } = row;
            let speed = times.one_by_one.median / median;
            println!("  {what:<30} {median:>12.1} {lower_quartile:>12.1} {upper_quartile:>12.1} {speed:>7.2}x");
        }
    }
}
