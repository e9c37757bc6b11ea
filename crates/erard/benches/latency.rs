//! The worst step, not the mean: every one of ten million steps of random playing timed by itself.
//!
//! `cargo bench -p erard --bench latency`, `-- --steps N` for fewer. Times include the clock's own reading (printed). The slowest
//! steps by the clock are those that the operating system interrupts; the slowest by work (Newton iterations, active sets) is printed
//! beside, because it repeats.

mod common;

use std::time::Instant;

use common::{GrandScratch, STEP_S, grand};
use moreau::{Input, Outcome, Settings, step};

/// A small deterministic generator (xorshift64*), uniform in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Nanoseconds below which the histogram is exact; what is slower is kept one by one.
const BINS: usize = 1 << 16;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let steps: u64 = arguments
        .iter()
        .position(|a| a == "--steps")
        .map_or(10_000_000, |at| arguments.get(at + 1).and_then(|v| v.parse().ok()).expect("--steps needs a number"));
    let ((model, mut state), settings) = (grand(), Settings::new(STEP_S));
    let mut scratch = GrandScratch::new();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let (mut bins, mut slow) = (vec![0u64; BINS], Vec::new());
    let (mut force, mut left) = (0.0, 0u32);
    let (mut most_newton, mut most_sets, mut limited) = (0, 0, 0u64);
    for _ in 0..steps {
        if left == 0 {
            // Blows of up to 40 N, held for 10 to 200 ms; every second time the key is let go.
            force = if force > 0.0 { 0.0 } else { 0.5 + 39.5 * random.next() * random.next() };
            left = 200 + (3800.0 * random.next()) as u32;
        }
        left -= 1;
        let start = Instant::now();
        let report = step(&model, &settings, &Input::Force(force), &mut state, &mut scratch);
        let ns = start.elapsed().as_nanos() as u64;
        match bins.get_mut(ns as usize) {
            Some(bin) => *bin += 1,
            None => slow.push(ns),
        }
        assert_ne!(report.outcome, Outcome::NonFinite);
        limited += u64::from(report.outcome == Outcome::IterationLimit);
        most_newton = most_newton.max(report.newton);
        most_sets = most_sets.max(report.solver);
    }
    slow.sort_unstable();
    let quantile = |share: f64| {
        let rank = (share * steps as f64) as u64;
        let mut seen = 0;
        for (ns, n) in bins.iter().enumerate() {
            seen += n;
            if seen > rank {
                return ns as u64;
            }
        }
        slow.get((rank - seen) as usize).or(slow.last()).copied().unwrap_or(0)
    };
    let clock = (0..1000).map(|_| Instant::now().elapsed().as_nanos()).min().unwrap_or(0);
    println!("steps_timed {steps}");
    println!("clock_ns {clock}");
    for (name, share) in [("p50", 0.5), ("p99", 0.99), ("p9999", 0.9999)] {
        println!("step_ns_{name} {}", quantile(share));
    }
    let max = slow.last().copied().or_else(|| bins.iter().rposition(|&n| n > 0).map(|ns| ns as u64)).unwrap_or(0);
    println!("step_ns_max {max}");
    println!("newton_iterations_max {most_newton}");
    println!("active_sets_max {most_sets}");
    println!("steps_not_converged {limited}");
}
