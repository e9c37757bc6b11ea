//! The engine's own rows: error of the hammer speed and seconds at several steps and tolerances, and the held note.

use std::time::Instant;

use moreau::Settings;
use moreau_kernels::Lanes;
use serde_json::{Value, json};

use super::play::{Action, HOLD_N, HOLD_S, LOOSE, SCALES, Steps};

/// Steps of the rows, s.
const STEPS_S: [f64; 15] = [
    1000e-6, 700e-6, 500e-6, 450e-6, 400e-6, 375e-6, 350e-6, 300e-6, 250e-6, 200e-6, 100e-6, 50e-6, 25e-6, 12.5e-6,
    6.25e-6,
];
/// Step of the converged reference, s: a 128th of the finest row.
const REFERENCE_STEP_S: f64 = 6.25e-6 / 128.0;
/// So many of them in a quick run.
const QUICK_STEPS: usize = 12;
/// Blows in a batch: each factor once in every lane.
const MAX_LANES: usize = 16;
const HOLD_STEPS_S: [f64; 3] = [100e-6, 50e-6, 25e-6];

/// Tolerances of the rows with adaptive steps.
const TOLERANCES: [f64; 7] = [1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
const HOLD_TOLERANCES: [f64; 2] = [1e-3, 1e-5];

/// The settings that are played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chosen {
    /// All of them.
    All,
    /// Fewer, and fewer repetitions.
    Quick,
    /// One alone.
    One(Steps),
}

impl Chosen {
    /// Fixed steps, usual and loose in turn, and so many repetitions of each.
    fn fixed(self, repetitions: usize) -> (Vec<Steps>, usize) {
        let each = |steps: &[f64]| steps.iter().flat_map(|&step| [Steps::Fixed(step), Steps::Loose(step)]).collect();
        match self {
            Chosen::All => (each(&STEPS_S), repetitions),
            Chosen::Quick => (each(&STEPS_S[..QUICK_STEPS]), 3),
            Chosen::One(steps) => (vec![steps], repetitions),
        }
    }
}

/// Prints a row for every step and tolerance, and the reference, which is the same engine at a far finer step.
pub fn blows<const B: usize, const Z: usize, const N: usize>(action: &Action<B, Z, N>, chosen: Chosen) {
    let tolerances = match chosen {
        Chosen::All => &TOLERANCES[..],
        Chosen::Quick => &TOLERANCES[..5],
        Chosen::One(_) => &[],
    };
    if !tolerances.is_empty() {
        row(action, "reference", Steps::Fixed(REFERENCE_STEP_S), 1);
    }
    let (fixed, repetitions) = chosen.fixed(9);
    for steps in fixed.into_iter().chain(tolerances.iter().map(|&tolerance| Steps::Controlled(tolerance))) {
        row(action, "blow", steps, repetitions);
    }
}

/// What a row is of.
fn named(task: &str, steps: Steps) -> serde_json::Map<String, Value> {
    let row = match steps {
        Steps::Fixed(step_s) | Steps::FixedOrRest(step_s) => {
            eprintln!("erard: {task}, step {:.3} us", step_s * 1e6);
            json!({ "task": task, "peer": "Erard", "step_s": step_s })
        }
        Steps::Loose(step_s) => {
            eprintln!("erard: {task}, step {:.3} us, Newton's tolerance loosened", step_s * 1e6);
            json!({ "task": task, "peer": "Erard", "step_s": step_s, "newton_tolerance": LOOSE })
        }
        Steps::Controlled(tolerance) => {
            eprintln!("erard: {task}, tolerance {tolerance:e}");
            json!({ "task": task, "peer": "Erard", "method": "controlled", "tolerance": tolerance })
        }
    };
    row.as_object().cloned().unwrap_or_default()
}

/// One blow of a row: its factor, the strike's speed and instant, what it took.
fn blow(scale: f64, strike: Option<[f64; 2]>, seconds: f64, steps: u64) -> Value {
    json!({
        "scale": scale,
        "speed_m_per_s": strike.map(|s| s[0]),
        "contact_s": strike.map(|s| s[1]),
        "seconds": seconds,
        "steps": steps,
    })
}

fn row<const B: usize, const Z: usize, const N: usize>(
    action: &Action<B, Z, N>,
    task: &str,
    steps: Steps,
    repetitions: usize,
) {
    let mut row = named(task, steps);
    let blows: Vec<_> = SCALES
        .iter()
        .map(|&scale| {
            let mut runs: Vec<_> =
                (0..repetitions).map(|_| action.play(steps, action.force(scale), &[action.press_s])).collect();
            runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
            let best = &runs[0];
            blow(scale, best.strike, best.seconds, best.steps)
        })
        .collect();
    row.insert("blows".to_owned(), Value::from(blows));
    println!("{}", Value::from(row));
}

/// Prints a row for every step, of blows side by side in the lanes of as many cores as this process may use. A blow's
/// seconds are those of all, over their number.
pub fn batches<const B: usize, const Z: usize, const N: usize>(action: &Action<B, Z, N>, chosen: Chosen) {
    let (fixed, repetitions) = chosen.fixed(15);
    for lanes in [Lanes::most(), Lanes::most_single()].map(|lanes| action.lanes(lanes)) {
        for &steps in &fixed {
            batch(action, lanes, &steps.settings(), repetitions);
        }
    }
}

fn batch<const B: usize, const Z: usize, const N: usize>(
    action: &Action<B, Z, N>,
    lanes: Lanes,
    settings: &Settings<f64>,
    repetitions: usize,
) {
    let step_s = settings.step;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let precision = if lanes.is_single() { "single" } else { "double" };
    eprintln!(
        "erard: batch, {} lanes of {precision} precision on {cores} cores, step {:.3} us",
        lanes.count(),
        step_s * 1e6
    );
    // Neighbours in the lanes differ.
    let groups: Vec<Vec<f64>> = (0..SCALES.len())
        .map(|first| (0..MAX_LANES).map(|lane| SCALES[(first + lane) % SCALES.len()]).collect())
        .collect();
    let (mut best_s, mut strikes) = (f64::INFINITY, Vec::new());
    for _ in 0..repetitions {
        let ready = std::sync::Barrier::new(cores);
        let played: Vec<_> = std::thread::scope(|scope| {
            let play = || {
                let groups = groups.iter().flat_map(|scales| scales.chunks(lanes.count()));
                let assembled: Vec<_> = groups.map(|scales| (action.together(settings, lanes), scales)).collect();
                ready.wait();
                let start = Instant::now();
                let play = |(group, scales)| action.play_together(group, step_s, scales);
                let strikes: Vec<_> = assembled.into_iter().flat_map(play).collect();
                (strikes, start.elapsed().as_secs_f64())
            };
            let others: Vec<_> = (1..cores).map(|_| scope.spawn(play)).collect();
            let own = play();
            others.into_iter().filter_map(|thread| thread.join().ok()).chain([own]).collect()
        });
        assert_eq!(played.len(), cores, "a thread failed");
        let slowest_s = played.iter().map(|(_, seconds)| *seconds).fold(0.0, f64::max);
        best_s = best_s.min(slowest_s / (cores * groups.len() * MAX_LANES) as f64);
        strikes = played.into_iter().flat_map(|(strikes, _)| strikes).collect();
    }
    // The first blow of every group: each factor once.
    let blows: Vec<_> = SCALES
        .iter()
        .zip(strikes.chunks(MAX_LANES))
        .map(|(&scale, group)| blow(scale, group[0], best_s, (action.press_s / step_s).ceil() as u64))
        .collect();
    let mut row = json!({
        "task": "blow", "peer": "Erard", "batch_cores": cores, "lanes": lanes.count(), "precision": precision,
        "step_s": step_s, "blows": blows,
    });
    if settings.tolerance == LOOSE {
        row["newton_tolerance"] = json!(LOOSE);
    }
    println!("{row}");
}

/// Prints the held note's row for every step.
pub fn holds<const B: usize, const Z: usize, const N: usize>(action: &Action<B, Z, N>, quick: bool) {
    let fixed = if quick { &HOLD_STEPS_S[1..2] } else { &HOLD_STEPS_S[..] };
    let controlled = if quick { &HOLD_TOLERANCES[..1] } else { &HOLD_TOLERANCES[..] };
    let [from, until] = HOLD_S;
    let instants: Vec<f64> = (0..=90).map(|k| from + (until - from) * f64::from(k) / 90.0).collect();
    let fixed = fixed.iter().map(|&step| Steps::FixedOrRest(step));
    for steps in fixed.chain(controlled.iter().map(|&tolerance| Steps::Controlled(tolerance))) {
        let mut row = named("hold", steps);
        let played = action.play(steps, |_| HOLD_N, &instants);
        row.insert("angles_rad".to_owned(), Value::from(played.angles_rad));
        row.insert("seconds".to_owned(), Value::from(played.seconds));
        row.insert("steps".to_owned(), Value::from(played.steps));
        println!("{}", Value::from(row));
    }
}
