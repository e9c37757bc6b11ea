//! The engine's own rows: error of the hammer speed and seconds at several steps, and the held note.

use moreau::Settings;
use serde_json::json;

use super::play::{Action, BLOW_S, HOLD_N, HOLD_S, SCALES};

/// Steps of the rows, s.
const STEPS_S: [f64; 9] = [200e-6, 150e-6, 125e-6, 100e-6, 75e-6, 50e-6, 25e-6, 12.5e-6, 6.25e-6];
/// Step of the converged reference, s: a 128th of the finest row.
const REFERENCE_STEP_S: f64 = 6.25e-6 / 128.0;
const HOLD_STEPS_S: [f64; 3] = [100e-6, 50e-6, 25e-6];

/// Prints a row for every step, and the reference, which is the same engine at a far finer step.
pub fn blows(action: &Action, quick: bool) {
    row(action, "reference", REFERENCE_STEP_S, 1);
    let (steps, repetitions) = if quick { (&STEPS_S[..7], 3) } else { (&STEPS_S[..], 9) };
    for &step in steps {
        row(action, "blow", step, repetitions);
    }
}

fn row(action: &Action, task: &str, step_s: f64, repetitions: usize) {
    eprintln!("erard: {task}, step {:.3} us", step_s * 1e6);
    let settings = Settings::new(step_s);
    let blows: Vec<_> = SCALES
        .iter()
        .map(|&scale| {
            let mut runs: Vec<_> =
                (0..repetitions).map(|_| action.play(&settings, action.force(scale), &[BLOW_S])).collect();
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
    println!("{}", json!({ "task": task, "peer": "Erard", "step_s": step_s, "blows": blows }));
}

/// Prints the held note's row for every step.
pub fn holds(action: &Action, quick: bool) {
    let steps = if quick { &HOLD_STEPS_S[1..2] } else { &HOLD_STEPS_S[..] };
    for &step_s in steps {
        eprintln!("erard: held note, step {:.3} us", step_s * 1e6);
        let [from, until] = HOLD_S;
        let instants: Vec<f64> = (0..=90).map(|k| from + (until - from) * f64::from(k) / 90.0).collect();
        let played = action.play(&Settings::new(step_s), |_| HOLD_N, &instants);
        let row = json!({
            "task": "hold",
            "peer": "Erard",
            "step_s": step_s,
            "angles_rad": played.angles_rad,
            "seconds": played.seconds,
            "steps": played.steps,
        });
        println!("{row}");
    }
}
