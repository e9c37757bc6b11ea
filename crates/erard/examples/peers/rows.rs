//! The engine's own rows: error of the hammer speed and seconds at several steps and tolerances, and the held note.

use serde_json::{Value, json};

use super::play::{Action, BLOW_S, HOLD_N, HOLD_S, SCALES, Steps};

/// Steps of the rows, s.
const STEPS_S: [f64; 11] = [200e-6, 150e-6, 125e-6, 120e-6, 110e-6, 100e-6, 75e-6, 50e-6, 25e-6, 12.5e-6, 6.25e-6];
/// Step of the converged reference, s: a 128th of the finest row.
const REFERENCE_STEP_S: f64 = 6.25e-6 / 128.0;
const HOLD_STEPS_S: [f64; 3] = [100e-6, 50e-6, 25e-6];

/// Tolerances of the rows with controlled steps.
const TOLERANCES: [f64; 7] = [1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
const HOLD_TOLERANCES: [f64; 2] = [1e-3, 1e-5];

/// Prints a row for every step and tolerance, and the reference, which is the same engine at a far finer step.
pub fn blows(action: &Action, quick: bool) {
    row(action, "reference", Steps::Fixed(REFERENCE_STEP_S), 1);
    let (steps, repetitions) = if quick { (&STEPS_S[..9], 3) } else { (&STEPS_S[..], 9) };
    for &step in steps {
        row(action, "blow", Steps::Fixed(step), repetitions);
    }
    for &tolerance in if quick { &TOLERANCES[..5] } else { &TOLERANCES[..] } {
        row(action, "blow", Steps::Controlled(tolerance), repetitions);
    }
}

/// What a row is of.
fn named(task: &str, steps: Steps) -> serde_json::Map<String, Value> {
    let row = match steps {
        Steps::Fixed(step_s) => {
            eprintln!("erard: {task}, step {:.3} us", step_s * 1e6);
            json!({ "task": task, "peer": "Erard", "step_s": step_s })
        }
        Steps::Controlled(tolerance) => {
            eprintln!("erard: {task}, tolerance {tolerance:e}");
            json!({ "task": task, "peer": "Erard", "method": "controlled", "tolerance": tolerance })
        }
    };
    row.as_object().cloned().unwrap_or_default()
}

fn row(action: &Action, task: &str, steps: Steps, repetitions: usize) {
    let mut row = named(task, steps);
    let blows: Vec<_> = SCALES
        .iter()
        .map(|&scale| {
            let mut runs: Vec<_> =
                (0..repetitions).map(|_| action.play(steps, action.force(scale), &[BLOW_S])).collect();
            runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
            let best = &runs[0];
            json!({
                "scale": scale,
                "speed_m_s": best.strike.map(|s| s[0]),
                "contact_s": best.strike.map(|s| s[1]),
                "seconds": best.seconds,
                "steps": best.steps,
            })
        })
        .collect();
    row.insert("blows".to_owned(), Value::from(blows));
    println!("{}", Value::from(row));
}

/// Prints the held note's row for every step.
pub fn holds(action: &Action, quick: bool) {
    let fixed = if quick { &HOLD_STEPS_S[1..2] } else { &HOLD_STEPS_S[..] };
    let controlled = if quick { &HOLD_TOLERANCES[..1] } else { &HOLD_TOLERANCES[..] };
    let [from, until] = HOLD_S;
    let instants: Vec<f64> = (0..=90).map(|k| from + (until - from) * f64::from(k) / 90.0).collect();
    let fixed = fixed.iter().map(|&step| Steps::Fixed(step));
    for steps in fixed.chain(controlled.iter().map(|&tolerance| Steps::Controlled(tolerance))) {
        let mut row = named("hold", steps);
        let played = action.play(steps, |_| HOLD_N, &instants);
        row.insert("angles_rad".to_owned(), Value::from(played.angles_rad));
        row.insert("seconds".to_owned(), Value::from(played.seconds));
        row.insert("steps".to_owned(), Value::from(played.steps));
        println!("{}", Value::from(row));
    }
}
