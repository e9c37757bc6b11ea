//! One action: a step, a whole press, and a pose of the levers.

use std::hint::black_box;

use erard_kinematics::three_lever::ThreeLever;
use moreau::Settings;
use serde_json::{Value, json};

use super::{Effort, STEP_S, Timed, grand, in_turn, instrument, press};
use erard::Progress;
use erard::player;
use erard::run::{Setup, simulate};
use erard::stroke::{Series, Touch};

/// Time that the press goes on after its stroke, s.
const AFTERWARDS_S: f64 = 0.2;
/// Poses of a key's travel of 8 mm.
const POSES: usize = 1000;

/// Measures; `None` where `progress` ended the work.
///
/// # Panics
/// If what is built in cannot be simulated.
pub(crate) fn measure(effort: &Effort, progress: &mut Progress<'_>) -> Option<Value> {
    let (grand, settings) = (grand(), Settings::new(STEP_S));
    let instrument = instrument();
    let series = Series::builtin("mf", Touch::Pressed).expect("built in");
    let duration_s = series.end_s() - series.start_s() + AFTERWARDS_S;
    let setup = Setup { settings, start_s: series.start_s(), ..Setup::new(duration_s) };
    let drive = player::force(series.force.as_ref().expect("has a force").drive());
    let levers = ThreeLever::c7f_like().assemble().expect("built in");
    let mut poses = Vec::with_capacity(POSES);
    let mut subjects = [
        Timed {
            count: effort.steps as f64,
            go: Box::new(|| {
                black_box(press(black_box(&grand), &settings, effort.steps));
            }),
        },
        Timed {
            count: 1.0,
            go: Box::new(|| {
                let run = simulate(&instrument, &drive, &setup, &mut |_| true);
                black_box(run.expect("the built-in grand plays"));
            }),
        },
        Timed {
            count: POSES as f64,
            go: Box::new(|| {
                assert!(levers.stroke_into(0.0, 0.008, POSES - 1, &mut poses).is_none());
                black_box(&poses);
            }),
        },
    ];
    let times = in_turn(effort.rounds, &mut subjects, progress)?;
    let [step, press, pose] = times[..] else { return None };
    Some(json!({
        "step_ns_median": step.median,
        "step_ns_spread": step.spread(),
        "real_time_factor": STEP_S * 1e9 / step.median,
        "press_ms_median": press.median * 1e-6,
        "press_ms_spread": press.spread(),
        "press_real_time_factor": duration_s * 1e9 / press.median,
        "kinematics_pose_ns_median": pose.median,
        "kinematics_pose_ns_spread": pose.spread(),
    }))
}
