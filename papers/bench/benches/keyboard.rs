//! The keyboard in real time: every tick of 88 keys (50 us of simulated time) timed by itself, from all keys asleep to
//! all 88 playing.
//!
//! `cargo bench -p erard-bench --bench keyboard`, `-- --ticks N` for another number of ticks per line. The budget of a
//! tick is the time that it simulates. Times include the clock's own reading (printed); the slowest ticks by the clock
//! are those that the operating system interrupts, the largest number of keys awake is printed too, because that
//! repeats. Beside them, a key awake over its bare step ([`erard_bench::OverBare`]), as a ratio of medians in turn
//! within the run; and a recorded press with its energy balance over the bare steps of the same note.
//!
//! Lanes of four neighbours would have to be worth it: beside the times stands how many of four are awake where one is.
//! Below 4/3 even lanes that are three times as fast gain nothing.

use erard::Instrument;
use erard::keyboard::KEYS;
use erard::keyboard::tremolo::TEN;
use erard_bench::latency::clock_ns;
use erard_bench::{Effort, OverBare, STEP_S, Ticks, keyboard};

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
    let grand = Instrument::builtin("concert-grand").expect("built in");
    let press = OverBare::of_recorded_press(&grand, &Effort::USUAL, &mut |_| true);
    let [every, moving] = press.expect("nobody interrupts");
    let keys = |fingers| OverBare::of_keys(&instruments, fingers, &Effort::USUAL, &mut |_| true);
    let [ten, all] = [TEN, KEYS].map(|fingers| keys(fingers).expect("nobody interrupts"));
    for (name, measured) in [
        ("recorded_press", every),
        ("recorded_press_not_left_out", moving),
        ("tremolo_key", ten),
        ("all_keys_key", all),
    ] {
        println!("{name}_steps_a_round {:.0}", measured.steps);
        for (what, times) in [("bare_step", measured.bare), ("step", measured.whole)] {
            let [low, high] = [times.lower_quartile, times.upper_quartile];
            println!("{name}_{what}_ns {:.0} (quartiles {low:.0} {high:.0})", times.median);
        }
        println!("{name}_over_bare_step {:.2}", measured.ratio());
    }
}
