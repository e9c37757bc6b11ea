//! The keyboard in real time: every tick of 88 keys (50 us of simulated time) timed by itself, from all keys asleep to all 88 playing.
//!
//! `cargo bench -p erard --bench keyboard`, `-- --ticks N` for another number of ticks per line. The budget of a tick is the time that
//! it simulates. Times include the clock's own reading (printed); the slowest ticks by the clock are those that the operating system
//! interrupts, the most keys that were ever awake stand beside them, because that repeats.

mod common;

use std::time::Instant;

use common::STEP_S;
use erard::keyboard::tremolo::{TEN, Tremolo};
use erard::keyboard::{KEYS, Keyboard, Keys};
use moreau::Settings;

/// Lanes of a group: stepped together, four neighbours would have to be worth it. Beside the times stands how many of them are awake
/// where one is: below 4/3 even lanes that are three times as fast gain nothing.
const FOUR: usize = 4;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let ticks: usize = arguments
        .iter()
        .position(|a| a == "--ticks")
        .map_or(200_000, |at| arguments.get(at + 1).and_then(|v| v.parse().ok()).expect("--ticks needs a number"));
    let keyboard = Keyboard::builtin("concert-grand").expect("built in");
    let instruments = keyboard.instruments().expect("every key is an instrument");
    let clock = (0..1000).map(|_| Instant::now().elapsed().as_nanos()).min().unwrap_or(0);
    println!("ticks_timed {ticks}");
    println!("tick_budget_ns {:.0}", STEP_S * 1e9);
    println!("clock_ns {clock}");
    for (name, fingers) in [("asleep", 0), ("one_key", 1), ("tremolo", TEN), ("all_keys", KEYS)] {
        let keys = Keys::at_rest(&instruments, Settings::new(STEP_S)).expect("every key comes to rest");
        let mut tremolo = Tremolo::new(keys, fingers);
        let mut ns = vec![0u64; ticks];
        let (mut stepped, mut groups, mut most, mut bad) = (0u64, 0u64, 0, 0);
        for time in &mut ns {
            let start = Instant::now();
            let tick = tremolo.tick();
            *time = start.elapsed().as_nanos() as u64;
            stepped += u64::from(tick.stepped);
            most = most.max(tick.stepped);
            bad += tick.unconverged + tick.non_finite;
            let awake = |key: usize| tremolo.keys().is_awake(key);
            groups += (1..=KEYS).step_by(FOUR).filter(|&first| (first..first + FOUR).any(awake)).count() as u64;
        }
        let mean = ns.iter().sum::<u64>() as f64 / ticks as f64;
        let late = ns.iter().filter(|&&ns| ns as f64 > STEP_S * 1e9).count();
        ns.sort_unstable();
        let quantile = |share: f64| ns[((share * ticks as f64) as usize).min(ticks - 1)];
        println!("{name}_awake_mean {:.2}", stepped as f64 / ticks as f64);
        println!("{name}_awake_max {most}");
        println!("{name}_awake_of_four {:.2}", stepped as f64 / groups.max(1) as f64);
        for (quantity, share) in [("p50", 0.5), ("p99", 0.99), ("p9999", 0.9999), ("max", 1.0)] {
            println!("{name}_tick_ns_{quantity} {}", quantile(share));
        }
        println!("{name}_tick_ns_mean {mean:.0}");
        println!("{name}_real_time_factor_median {:.1}", STEP_S * 1e9 / quantile(0.5) as f64);
        println!("{name}_real_time_factor_mean {:.1}", STEP_S * 1e9 / mean);
        println!("{name}_ticks_over_budget {late}");
        println!("{name}_steps_not_converged {bad}");
    }
}
