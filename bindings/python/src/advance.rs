//! Many actions stepped at once, each under its own input for a while: the lanes of a closed loop.

use std::collections::HashSet;

use erard::StepOutcome;
use erard::player::Input;
use erard::run::SimulationError;
use erard::strings::Strings;
use erard_workshop::cores;
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::action::{Action, driven, input};
use crate::fault::{self, wrong, wrong_argument};
use crate::watch::watched;

/// Columns of results after some steps. `finger_force_mean_n` is the mean over the steps; `impact_time_s` and
/// `hammer_speed_m_per_s` belong to the last impact, nan without one.
const COLUMNS: [&str; 15] = [
    "time_s",
    "key_m",
    "key_m_per_s",
    "finger_force_n",
    "finger_force_mean_n",
    "hammer_rise_m",
    "hammer_rise_m_per_s",
    "string_n",
    "bridge_n",
    "hand_m",
    "hand_m_per_s",
    "impact_count",
    "impact_time_s",
    "hammer_speed_m_per_s",
    "failed",
];

/// Number of steps that is worth a thread: starting a thread takes as long as some hundred steps.
const STEPS_PER_THREAD: u64 = 4000;

/// Takes `steps` steps of each action under its row of `values`: a force, N (one column), or a fingertip or key motion,
/// m and m/s (two columns), which continues at its velocity. Returns columns of results with one row for each action.
/// An action whose numbers become infinite has failed and stays as it was before that step.
#[pyfunction]
pub(crate) fn advance<'py>(
    py: Python<'py>,
    actions: Vec<Bound<'py, Action>>,
    kind: &str,
    values: PyReadonlyArray2<'py, f64>,
    steps: u64,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    let given = values.as_array();
    let width = if kind == "force" { 1 } else { 2 };
    if given.dim() != (actions.len(), width) {
        let expected = format!("expected ({}, {width})", actions.len());
        return Err(wrong_argument(kind, format!("found shape {:?}, {expected}", given.dim())));
    }
    let mut seen = HashSet::new();
    let mut lanes: Vec<(&Action, Input)> = Vec::with_capacity(actions.len());
    for (lane, (action, row)) in actions.iter().zip(given.rows()).enumerate() {
        if !seen.insert(action.as_ptr()) {
            return Err(wrong(format!("lane {lane}: the action is in another lane, too; expected each once")));
        }
        let action = action.get();
        let asked = match kind {
            "force" => input(Some(row[0]), None, None),
            "motion" => input(None, Some((row[0], row[1])), None),
            "rigid" => input(None, None, Some((row[0], row[1]))),
            found => Err(wrong_argument("kind", format!("found {found}, expected force, motion or rigid"))),
        };
        lanes.push((action, driven(action.hand, asked?)?));
    }
    let worth = steps.saturating_mul(lanes.len() as u64) / STEPS_PER_THREAD + 1;
    let threads = threads.unwrap_or_else(cores::count).min(usize::try_from(worth).unwrap_or(usize::MAX));
    let rows = watched(
        py,
        None,
        |going| {
            cores::map(&lanes, threads, going, |(action, input), _| {
                Ok::<_, SimulationError>(action.advance(*input, steps))
            })
        },
        fault::simulation,
    )?;
    let all = PyDict::new(py);
    for (column, name) in COLUMNS.into_iter().enumerate() {
        let values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        all.set_item(name, values.into_pyarray(py))?;
    }
    Ok(all)
}

impl Action {
    /// Takes steps under one input, without Python's lock.
    fn advance(&self, input: Input, steps: u64) -> [f64; COLUMNS.len()] {
        let mut player = self.player.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let h = player.settings().step;
        let (mut sum_n, mut impacts, mut last, mut failed) = (0.0, 0.0, [f64::NAN; 2], 0.0);
        for n in 0..steps {
            let now = player.step(input.later(n as f64 * h, h));
            if now.outcome == StepOutcome::NonFinite {
                failed = 1.0;
                break;
            }
            sum_n += now.finger_force_n;
            if let Some(impact) = player.impact() {
                impacts += 1.0;
                last = [impact.time_s, impact.hammer_speed_m_per_s];
            }
        }
        let now = player.reading();
        let mean_n = if steps == 0 { now.finger_force_n } else { sum_n / steps as f64 };
        [
            player.time_s(),
            now.key_m,
            now.key_m_per_s,
            now.finger_force_n,
            mean_n,
            now.hammer_rise_m,
            now.hammer_rise_m_per_s,
            now.string_n,
            player.strings().map_or(0.0, Strings::bridge_n),
            now.hand_m,
            now.hand_m_per_s,
            impacts,
            last[0],
            last[1],
            failed,
        ]
    }
}
