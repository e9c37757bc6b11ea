//! The keyboard in real time: every tick of 88 keys (50 us of simulated time) timed by itself, from all keys asleep to
//! all 88 playing.
//!
//! `cargo bench -p erard --bench keyboard`, `-- --ticks N` for another number of ticks per line. The budget of a tick
//! is the time that it simulates. Times include the clock's own reading (printed); the slowest ticks by the clock are
//! those that the operating system interrupts, the largest number of keys awake is printed too, because that repeats.
//! Lanes of four neighbours would have to be worth it: beside the times stands how many of four are awake where one is.
//! Below 4/3 even lanes that are three times as fast gain nothing.

use erard::keyboard::KEYS;
use erard::keyboard::tremolo::TEN;
use erard_workshop::benchmarks::latency::clock_ns;
use erard_workshop::benchmarks::{Effort, STEP_S, Ticks, keyboard};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let ticks: usize = arguments.iter().position(|a| a == "--ticks").map_or(Effort::USUAL.ticks, |at| {
        let ticks = arguments.get(at + 1).and_then(|v| v.parse().ok());
        ticks.filter(|ticks| *ticks > 0).expect("--ticks needs a number")
    });
    let instruments = keyboard();
    println!("ticks_timed {ticks}");
    println!("tick_budget_ns {:.0}", STEP_S * 1e9);
    println!("clock_ns {}", clock_ns());
    for (name, fingers) in [("asleep", 0), ("one_key", 1), ("tremolo", TEN), ("all_keys", KEYS)] {
        let measured = Ticks::measure(&instruments, fingers, ticks, &mut |_| true).expect("nobody interrupts");
        let times = &measured.times;
        println!("{name}_awake_mean {:.2}", measured.awake_mean);
        println!("{name}_awake_max {}", measured.awake_max);
        println!("{name}_awake_of_four {:.2}", measured.awake_of_four);
        for (quantity, ns) in
            [("p50", times.p50_ns), ("p99", times.p99_ns), ("p9999", times.p9999_ns), ("max", times.max_ns)]
        {
            println!("{name}_tick_ns_{quantity} {ns}");
        }
        println!("{name}_tick_ns_mean {:.0}", measured.mean_ns);
        println!("{name}_real_time_factor_median {:.1}", STEP_S * 1e9 / times.p50_ns as f64);
        println!("{name}_real_time_factor_mean {:.1}", measured.real_time_factor());
        println!("{name}_ticks_over_budget {}", measured.over_budget);
        println!("{name}_steps_not_converged {}", times.unconverged_steps);
    }
}
