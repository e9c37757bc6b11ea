//! A whole keyboard: every tick of 88 keys timed by itself.

use std::time::Instant;

use moreau::Settings;
use serde_json::{Value, json};

use super::STEP_S;
use super::latency::{Histogram, Latency};
use erard::Progress;
use erard::instrument::Instrument;
use erard::keyboard::tremolo::{TEN, Tremolo};
use erard::keyboard::{KEYS, Keyboard, Keys};

/// Times of a keyboard under so many fingers. A tick is one step of all keys that are awake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ticks {
    /// Times of single ticks.
    pub times: Latency,
    /// Mean time of a tick, ns.
    pub mean_ns: f64,
    /// Keys awake, on average.
    pub awake_mean: f64,
    /// Most keys awake.
    pub awake_max: u32,
    /// Of four neighbouring keys, how many are awake on average where one is: what lanes could gain.
    pub awake_of_four: f64,
    /// Ticks that took longer than the time that they simulate.
    pub over_budget: u64,
}

/// Lanes of a group.
const FOUR: usize = 4;
/// Ticks between two questions whether to go on.
const ASK_EVERY: usize = 1 << 10;

/// The built-in keyboard's 88 instruments.
///
/// # Panics
/// If the built-in file cannot be read, which a test rules out.
pub fn keyboard() -> Vec<Instrument> {
    let keyboard = Keyboard::builtin("concert-grand").expect("built in");
    keyboard.instruments().expect("every key is an instrument")
}

impl Ticks {
    /// Times so many ticks of a tremolo with so many fingers: 0 leaves all keys asleep. `None` where `progress` ended
    /// the work.
    ///
    /// # Panics
    /// If a key does not come to rest.
    pub fn measure(
        instruments: &[Instrument],
        fingers: usize,
        ticks: usize,
        progress: &mut Progress<'_>,
    ) -> Option<Self> {
        let keys = Keys::at_rest(instruments, Settings::new(STEP_S)).expect("every key comes to rest");
        let mut tremolo = Tremolo::new(keys, fingers);
        let mut histogram = Histogram::new();
        let (mut sum_ns, mut stepped, mut groups) = (0, 0, 0);
        let (mut awake_max, mut over_budget, mut unconverged) = (0, 0, 0);
        for n in 0..ticks {
            if n % ASK_EVERY == 0 && !progress(n as f64 / ticks as f64) {
                return None;
            }
            let start = Instant::now();
            let tick = tremolo.tick();
            let ns = start.elapsed().as_nanos() as u64;
            histogram.add(ns);
            sum_ns += ns;
            stepped += u64::from(tick.stepped);
            awake_max = awake_max.max(tick.stepped);
            unconverged += u64::from(tick.unconverged + tick.non_finite);
            over_budget += u64::from(ns as f64 > STEP_S * 1e9);
            let awake = |key: usize| tremolo.keys().is_awake(key).unwrap_or(false);
            groups += (1..=KEYS).step_by(FOUR).filter(|&first| (first..first + FOUR).any(awake)).count() as u64;
        }
        Some(Ticks {
            times: Latency { unconverged_steps: unconverged, ..histogram.latency() },
            mean_ns: sum_ns as f64 / ticks as f64,
            awake_mean: stepped as f64 / ticks as f64,
            awake_max,
            awake_of_four: stepped as f64 / groups.max(1) as f64,
            over_budget,
        })
    }

    /// The time of a tick that it simulates over the one that it takes on average.
    pub fn real_time_factor(&self) -> f64 {
        STEP_S * 1e9 / self.mean_ns
    }
}

/// Measures; `None` where `progress` ended the work.
pub(crate) fn measure(instruments: &[Instrument], ticks: usize, progress: &mut Progress<'_>) -> Option<Value> {
    let tremolo = Ticks::measure(instruments, TEN, ticks, &mut |share| progress(0.5 * share))?;
    let asleep = Ticks::measure(instruments, 0, ticks, &mut |share| progress(0.5 + 0.1 * share))?;
    // With all keys awake a tick takes several times as long.
    let all = Ticks::measure(instruments, KEYS, ticks / 5, &mut |share| progress(0.6 + 0.4 * share))?;
    Some(json!({
        "keyboard_real_time_factor": tremolo.real_time_factor(),
        "keyboard_ticks_timed": tremolo.times.steps,
        "keyboard_tick_ns_p50": tremolo.times.p50_ns,
        "keyboard_tick_ns_p99": tremolo.times.p99_ns,
        "keyboard_tick_ns_p9999": tremolo.times.p9999_ns,
        "keyboard_tick_ns_max": tremolo.times.max_ns,
        "keyboard_ticks_over_budget": tremolo.over_budget,
        "keyboard_awake_mean": tremolo.awake_mean,
        "keyboard_awake_max": tremolo.awake_max,
        "keyboard_all_keys_real_time_factor": all.real_time_factor(),
        "keyboard_asleep_tick_ns_p50": asleep.times.p50_ns,
    }))
}
