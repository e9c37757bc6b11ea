//! The worst step, not the mean: every step of random playing timed by itself.

use std::time::Instant;

use fastrand::Rng;
use moreau::{Settings, SiteInput, StepOutcome};
use moreau_kernels::Lanes;
use serde_json::{Value, json};

use super::grand::{STEP_S, described, group, instrument};
use erard::Progress;
use erard::mechanism::{Stepping, mechanism};

/// How long single steps took, ns; the clock's own reading is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latency {
    /// Steps timed.
    pub steps: u64,
    /// Half of the steps took less.
    pub p50_ns: u64,
    /// 99 of 100 took less.
    pub p99_ns: u64,
    /// 9999 of 10 000 took less.
    pub p9999_ns: u64,
    /// The slowest one: by the clock, that is the operating system's.
    pub max_ns: u64,
    /// Most Newton iterations of a step: the slowest one by work, which repeats; 0 where it is not counted.
    pub newton_iterations_max: u32,
    /// Most sets (or sweeps) of the one-step problem in a step, likewise.
    pub active_sets_max: u32,
    /// Steps that reached an iteration limit.
    pub unconverged_steps: u64,
}

/// Of single steps and of group steps.
pub(crate) fn report(one: &Latency, group: &Latency) -> Value {
    json!({
        "steps_timed": one.steps,
        "step_ns_p50": one.p50_ns,
        "step_ns_p99": one.p99_ns,
        "step_ns_p9999": one.p9999_ns,
        "step_ns_max": one.max_ns,
        "group_steps_timed": group.steps,
        "group_step_ns_p50": group.p50_ns,
        "group_step_ns_p99": group.p99_ns,
        "group_step_ns_p9999": group.p9999_ns,
        "group_step_ns_max": group.max_ns,
        "clock_ns": clock_ns(),
        "newton_iterations_max": one.newton_iterations_max,
        "active_sets_max": one.active_sets_max,
        "unconverged_steps": one.unconverged_steps + group.unconverged_steps,
    })
}

/// Somebody who plays at random: strokes of up to 40 N, held for 10 to 200 ms; every second time the key is let go.
struct RandomPlayer {
    random: Rng,
    force_n: f64,
    left: u32,
}

impl RandomPlayer {
    fn new(seed: u64) -> Self {
        RandomPlayer { random: Rng::with_seed(seed), force_n: 0.0, left: 0 }
    }

    fn next(&mut self) -> SiteInput<f64> {
        if self.left == 0 {
            let random = &mut self.random;
            self.force_n = if self.force_n > 0.0 { 0.0 } else { 0.5 + 39.5 * random.f64() * random.f64() };
            self.left = 200 + (3800.0 * random.f64()) as u32;
        }
        self.left -= 1;
        SiteInput::Force(self.force_n)
    }
}

/// Seed of the first player.
const SEED: u64 = 0x9E37_79B9_7F4A_7C15;

/// Nanoseconds below which the histogram is exact; what is slower is kept one by one.
const BINS: usize = 1 << 16;

/// Times of single things, exact to the nanosecond.
pub(super) struct Histogram {
    bins: Vec<u64>,
    slow: Vec<u64>,
    count: u64,
}

impl Histogram {
    pub(crate) fn new() -> Self {
        Histogram { bins: vec![0; BINS], slow: Vec::new(), count: 0 }
    }

    pub(crate) fn add(&mut self, ns: u64) {
        self.count += 1;
        match self.bins.get_mut(ns as usize) {
            Some(bin) => *bin += 1,
            None => self.slow.push(ns),
        }
    }

    /// The time that the `share` fastest stay below, ns.
    fn quantile(&self, share: f64) -> u64 {
        let rank = (share * self.count as f64) as u64;
        let mut seen = 0;
        for (ns, n) in self.bins.iter().enumerate() {
            seen += n;
            if seen > rank {
                return ns as u64;
            }
        }
        self.slow.get((rank - seen) as usize).or(self.slow.last()).copied().unwrap_or(0)
    }

    pub(crate) fn latency(mut self) -> Latency {
        self.slow.sort_unstable();
        let fast = self.bins.iter().rposition(|&n| n > 0).map_or(0, |ns| ns as u64);
        Latency {
            steps: self.count,
            p50_ns: self.quantile(0.5),
            p99_ns: self.quantile(0.99),
            p9999_ns: self.quantile(0.9999),
            max_ns: self.slow.last().copied().unwrap_or(fast),
            newton_iterations_max: 0,
            active_sets_max: 0,
            unconverged_steps: 0,
        }
    }
}

/// Steps between two questions whether to go on.
const ASK_EVERY: u64 = 1 << 14;

/// Times single steps of the grand; `None` where `progress` ended the work.
///
/// # Panics
/// If a number becomes infinite.
pub fn of_steps(steps: u64, progress: &mut Progress<'_>) -> Option<Latency> {
    let mut grand = mechanism(&instrument(), Settings::new(STEP_S)).expect("assembles");
    grand.configure(Stepping { may_rest: false, ..*grand.readout().stepping });
    let (mut player, mut histogram) = (RandomPlayer::new(SEED), Histogram::new());
    let (mut newton, mut sets, mut unconverged) = (0, 0, 0);
    for n in 0..steps {
        if n % ASK_EVERY == 0 && !progress(n as f64 / steps as f64) {
            return None;
        }
        let input = player.next();
        let start = Instant::now();
        let report = grand.step(&input).report;
        histogram.add(start.elapsed().as_nanos() as u64);
        assert_ne!(report.outcome, StepOutcome::NonFinite);
        unconverged += u64::from(report.outcome == StepOutcome::IterationLimit);
        newton = newton.max(report.newton);
        sets = sets.max(report.solver);
    }
    Some(Latency {
        newton_iterations_max: newton,
        active_sets_max: sets,
        unconverged_steps: unconverged,
        ..histogram.latency()
    })
}

/// Times steps of as many grands as there are lanes, each with a player of its own; `None` where `progress` ended the
/// work.
///
/// # Panics
/// If a number becomes infinite.
pub fn of_group_steps(steps: u64, lanes: Lanes, progress: &mut Progress<'_>) -> Option<Latency> {
    let (rest, count) = (described(&instrument()).expect("comes to rest"), lanes.count());
    let mut group = group(&vec![&rest; count], &Settings::new(STEP_S), lanes);
    let mut players: Vec<RandomPlayer> =
        (0..count).map(|i| RandomPlayer::new(SEED.wrapping_mul(2 * i as u64 + 1))).collect();
    let (mut inputs, mut outcomes) = (vec![SiteInput::Free; count], vec![StepOutcome::Converged; count]);
    let (mut histogram, mut unconverged) = (Histogram::new(), 0);
    for n in 0..steps {
        if n % ASK_EVERY == 0 && !progress(n as f64 / steps as f64) {
            return None;
        }
        for (input, player) in inputs.iter_mut().zip(&mut players) {
            *input = player.next();
        }
        let start = Instant::now();
        group.step(&inputs, &mut outcomes);
        histogram.add(start.elapsed().as_nanos() as u64);
        assert!(!outcomes.contains(&StepOutcome::NonFinite));
        unconverged += u64::from(outcomes.contains(&StepOutcome::IterationLimit));
    }
    Some(Latency { unconverged_steps: unconverged, ..histogram.latency() })
}

/// The shortest time that the clock can tell, ns: it is in every latency.
pub fn clock_ns() -> u64 {
    (0..1000).map(|_| Instant::now().elapsed().as_nanos() as u64).min().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A known distribution, with values in and beyond the bins.
    #[test]
    fn quantiles_of_a_known_distribution() {
        let mut histogram = Histogram::new();
        (0..10_000).for_each(|ns| histogram.add(ns));
        (0..2).for_each(|k| histogram.add(1_000_000 - k));
        let latency = histogram.latency();
        assert_eq!((latency.steps, latency.p50_ns, latency.p99_ns), (10_002, 5_001, 9_901));
        assert_eq!((latency.p9999_ns, latency.max_ns), (999_999, 1_000_000));
    }
}
