//! Random instruments under random strokes: `cargo run --release -p erard-core --example robustness [COUNT [FIRST
//! [THETA [STEP_US]]]]`, ten thousand from 0 at theta = 1/2 and 50 us unless told otherwise. Progress on stderr; a seed
//! in the report makes the same instrument again.

extern crate erard_core as erard;

#[path = "../tests/common/mod.rs"]
mod common;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use common::perturb::{Fate, play};
use common::{USUAL_STEP_S, grand};
use moreau::Settings;

/// Simulated time of a stroke, s.
const DURATION_S: f64 = 0.4;

fn all(first: u64, count: u64, theta: f64, step_s: f64) -> Vec<Fate> {
    let (grand, settings) = (grand(), Settings { theta, ..Settings::new(step_s) });
    let (next, fates) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    let start = Instant::now();
    let workers = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let n = next.fetch_add(1, Ordering::Relaxed);
                    if n >= count {
                        break;
                    }
                    let fate = play(&grand, first + n, settings, DURATION_S);
                    fates.lock().expect("no other worker has panicked").push(fate);
                    if n % 100 == 99 {
                        eprintln!("{} of {count}, {:.0} s", n + 1, start.elapsed().as_secs_f64());
                    }
                }
            });
        }
    });
    let mut fates = fates.into_inner().expect("no worker has panicked");
    fates.sort_by_key(|f| f.seed);
    fates
}

fn worst(title: &str, fates: &[Fate], by: impl Fn(&Fate) -> f64) {
    let mut order: Vec<&Fate> = fates.iter().collect();
    order.sort_by(|a, b| by(b).total_cmp(&by(a)));
    println!("{title}:");
    for f in order.iter().take(8).take_while(|f| by(f) > 0.0) {
        println!(
            "  seed {:6}: {:9.3e}   unconverged {} of {}, residual {:.1e}, gain {:.1e}, settled in {:.2} s",
            f.seed,
            by(f),
            f.unconverged,
            f.steps,
            f.residual,
            f.gain,
            f.settling_s
        );
    }
}

fn main() {
    let mut numbers = std::env::args().skip(1).map(|a| a.parse::<f64>().expect("a number"));
    let (count, first) = (numbers.next().unwrap_or(1e4) as u64, numbers.next().unwrap_or(0.0) as u64);
    let (theta, step_s) = (numbers.next().unwrap_or(0.5), numbers.next().map_or(USUAL_STEP_S, |us| us * 1e-6));
    let fates = all(first, count, theta, step_s);
    let sum = |f: fn(&Fate) -> u64| fates.iter().map(f).sum::<u64>();
    let (steps, unconverged) = (sum(|f| f.steps), sum(|f| f.unconverged));
    println!(
        "{} instruments, {steps} steps, {:.3} Newton iterations a step",
        fates.len(),
        sum(|f| f.newton) as f64 / steps as f64
    );
    println!("not finite: {}; no rest found: {}", sum(|f| u64::from(f.not_finite)), sum(|f| u64::from(f.restless)));
    println!(
        "unconverged steps: {unconverged} ({:.2e} of all), in {} instruments",
        unconverged as f64 / steps as f64,
        sum(|f| u64::from(f.unconverged > 0))
    );
    let mut residuals: Vec<f64> = fates.iter().map(|f| f.residual).collect();
    residuals.sort_by(f64::total_cmp);
    let at = |share: f64| residuals[((residuals.len() - 1) as f64 * share) as usize];
    println!("energy residual: median {:.1e}, 99 % below {:.1e}, largest {:.1e}", at(0.5), at(0.99), at(1.0));
    println!("smallest dissipation term: {:e} J", fates.iter().map(|f| f.smallest_term).fold(0.0, f64::min));
    worst("most unconverged steps", &fates, |f| f.unconverged as f64);
    worst("largest energy residual", &fates, |f| f.residual);
    worst("largest energy gain", &fates, |f| f.gain);
    worst("longest settling, s", &fates, |f| f.settling_s);
}
