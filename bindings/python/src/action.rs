//! An action that is stepped from Python.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use erard::instrument::Instrument as Inner;
use erard::player::{self, Action as Player, Hand, Input, Snapshot};
use erard::strings::Strings;
use erard::stroke::Prescribed;
use erard::{SimulationError, StepOutcome};
use numpy::{PyArray1, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::{PyBytes, PyDict};

use crate::fault::{self, failed, wrong, wrong_argument};
use crate::instrument::Instrument;
use crate::press::array;
use crate::setup::Steps;
use crate::stroke::sampled;

/// Most steps of sampled forces: an hour of the usual ones.
const MAX_STEPS: f64 = 7.2e7;

/// Grand action. Two threads may step it: one waits for the other.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Action {
    pub(crate) player: Mutex<Player>,
    instrument: Arc<Inner>,
    pub(crate) hand: Option<Hand>,
}

/// Reading after a step, SI units; key and finger positive downward, the hammer upward.
#[pyclass(frozen, module = "erard._erard", get_all, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct Reading {
    time_s: f64,
    key_m: f64,
    key_m_per_s: f64,
    finger_force_n: f64,
    hammer_rise_m: f64,
    hammer_rise_m_per_s: f64,
    string_n: f64,
    hand_m: f64,
    hand_m_per_s: f64,
    bridge_n: f64,
    converged: bool,
    /// Time (s) and total hammer speed (m/s) of the impact in this step; `None` without an impact.
    impact: Option<(f64, f64)>,
}

/// Fields of a reading, in order.
type Parts = (f64, f64, f64, f64, f64, f64, f64, f64, f64, f64, bool, Option<(f64, f64)>);

#[pymethods]
impl Reading {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        time_s: f64,
        key_m: f64,
        key_m_per_s: f64,
        finger_force_n: f64,
        hammer_rise_m: f64,
        hammer_rise_m_per_s: f64,
        string_n: f64,
        hand_m: f64,
        hand_m_per_s: f64,
        bridge_n: f64,
        converged: bool,
        impact: Option<(f64, f64)>,
    ) -> Self {
        Reading {
            time_s,
            key_m,
            key_m_per_s,
            finger_force_n,
            hammer_rise_m,
            hammer_rise_m_per_s,
            string_n,
            hand_m,
            hand_m_per_s,
            bridge_n,
            converged,
            impact,
        }
    }

    /// Arguments of the constructor, for pickling.
    fn __getnewargs__(&self) -> Parts {
        let Self { time_s, key_m, key_m_per_s, finger_force_n, hammer_rise_m, hammer_rise_m_per_s, string_n, .. } =
            *self;
        let Self { hand_m, hand_m_per_s, bridge_n, converged, impact, .. } = *self;
        (
            time_s,
            key_m,
            key_m_per_s,
            finger_force_n,
            hammer_rise_m,
            hammer_rise_m_per_s,
            string_n,
            hand_m,
            hand_m_per_s,
            bridge_n,
            converged,
            impact,
        )
    }

    fn __repr__(&self) -> String {
        format!(
            "Reading(time_s={:.6}, key_m={:.6}, finger_force_n={:.3}, hammer_rise_m={:.6}, hammer_rise_m_per_s={:.4})",
            self.time_s, self.key_m, self.finger_force_n, self.hammer_rise_m, self.hammer_rise_m_per_s
        )
    }
}

impl Reading {
    /// Makes a reading at a time, s, with the impact in its step and the force on the bridge, N.
    pub(crate) fn of(time_s: f64, now: &player::Reading, impact: Option<(f64, f64)>, bridge_n: f64) -> Self {
        Reading {
            time_s,
            key_m: now.key_m,
            key_m_per_s: now.key_m_per_s,
            finger_force_n: now.finger_force_n,
            hammer_rise_m: now.hammer_rise_m,
            hammer_rise_m_per_s: now.hammer_rise_m_per_s,
            string_n: now.string_n,
            hand_m: now.hand_m,
            hand_m_per_s: now.hand_m_per_s,
            bridge_n,
            converged: now.outcome == StepOutcome::Converged,
            impact,
        }
    }
}

fn reading(player: &Player) -> Reading {
    let impact = player.impact().map(|impact| (impact.time_s, impact.hammer_speed_m_per_s));
    Reading::of(player.time_s(), &player.reading(), impact, player.strings().map_or(0.0, Strings::bridge_n))
}

/// Input from a force, a fingertip's motion or a prescribed key motion (position and velocity); free if none is given.
pub(crate) fn input(force: Option<f64>, motion: Option<(f64, f64)>, rigid: Option<(f64, f64)>) -> PyResult<Input> {
    let (name, input) = match (force, motion, rigid) {
        (None, None, None) => return Ok(Input::Free),
        (Some(force), None, None) => ("force", Input::Force(force)),
        (None, Some((position_m, velocity_m_per_s)), None) => {
            ("motion", Input::Motion { position_m, velocity_m_per_s })
        }
        (None, None, Some((position_m, velocity_m_per_s))) => ("rigid", Input::Rigid { position_m, velocity_m_per_s }),
        _ => return Err(wrong("expected one of force, motion and rigid, or none of them")),
    };
    player::check(&input).map_err(|error| wrong_argument(name, error))?;
    Ok(input)
}

/// Drive of the key: the input itself, or the hand that it moves.
pub(crate) fn driven(hand: Option<Hand>, input: Input) -> PyResult<Input> {
    hand.map_or(Ok(input), |hand| hand.input(&input).map_err(wrong))
}

impl Action {
    /// The forces of samples `dt` s apart in the steps from now on, each at the instant within its step that a run
    /// takes.
    fn at_steps(&self, py: Python<'_>, forces: &[f64], dt: f64) -> PyResult<Vec<f64>> {
        let series = sampled(Prescribed::Force, forces, dt, "force")?.force;
        let Some(series) = series else { return Ok(Vec::new()) };
        let settings = *self.lock(py).settings();
        let lasts_s = dt * (forces.len() - 1) as f64;
        let steps = (lasts_s / settings.step + 1e-9).floor();
        if steps > MAX_STEPS {
            let found = format!("found {lasts_s} s of samples, {steps:.0} steps");
            return Err(wrong_argument("dt", format!("{found}; expected at most {MAX_STEPS:.0}")));
        }
        let force_n = series.drive();
        Ok((0..steps as u64).map(|n| force_n(n as f64 * settings.step + settings.theta * settings.step)).collect())
    }
}

#[pymethods]
impl Action {
    #[new]
    fn new(py: Python<'_>, instrument: &Instrument, steps: Steps) -> PyResult<Self> {
        let settings = steps.settings(&instrument.inner)?;
        let inner = instrument.inner.clone();
        steps.setup(&inner, 0.0, 1.0)?.check().map_err(|error: SimulationError| fault::simulation(&error))?;
        let hand = steps.hand()?;
        let mut player = py.detach(|| Player::with(&inner, settings)).map_err(|error| fault::action(&error))?;
        if let Some(hand) = &hand {
            player.place_hand(hand.start_m, hand.start_m_per_s);
        }
        Ok(Action { player: Mutex::new(player), instrument: inner, hand })
    }

    /// Returns the step length, s.
    fn step_s(&self) -> f64 {
        self.player.lock().unwrap_or_else(std::sync::PoisonError::into_inner).settings().step
    }

    #[pyo3(signature = (force, motion, rigid))]
    fn step(
        &self,
        py: Python<'_>,
        force: Option<f64>,
        motion: Option<(f64, f64)>,
        rigid: Option<(f64, f64)>,
    ) -> PyResult<Reading> {
        let input = driven(self.hand, input(force, motion, rigid)?)?;
        let mut player = self.lock(py);
        player.step(input);
        if player.reading().outcome == StepOutcome::NonFinite {
            return Err(failed("a number became infinite; the action is where it was before the step"));
        }
        Ok(reading(&player))
    }

    /// Places the hand, m below the key front's rest, with a velocity, m/s, down positive.
    fn place_hand(&self, py: Python<'_>, position_m: f64, velocity_m_per_s: f64) -> PyResult<()> {
        if self.hand.is_none() {
            return Err(wrong("this action has no hand; expected one that was made with `hand=erard.Hand()`"));
        }
        self.lock(py).place_hand(position_m, velocity_m_per_s);
        Ok(())
    }

    /// Sets the target lift of the sustain pedal's rail, m.
    fn set_pedal(&self, py: Python<'_>, lift_m: f64) {
        self.lock(py).set_pedal(lift_m);
    }

    /// Takes one step for each force, N. With `dt`: forces `dt` s apart from now on, between which a stroke file's
    /// cubics interpolate; as many steps as end by the last one.
    #[pyo3(signature = (forces, dt))]
    fn play<'py>(
        &self,
        py: Python<'py>,
        forces: PyReadonlyArray1<'py, f64>,
        dt: Option<f64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let forces = forces.as_slice().map_err(wrong)?;
        for (at, force) in forces.iter().enumerate() {
            player::check(&Input::Force(*force))
                .map_err(|error| wrong_argument("force", format!("sample {at}: {error}")))?;
        }
        let forces = match dt {
            Some(dt) => self.at_steps(py, forces, dt)?,
            None => forces.to_vec(),
        };
        let mut columns: [Vec<f64>; 5] = Default::default();
        for portion in forces.chunks(4096) {
            // A signal's handler may step the action itself: nothing is locked then.
            py.check_signals()?;
            let inputs: Vec<Input> =
                portion.iter().map(|force| driven(self.hand, Input::Force(*force))).collect::<PyResult<_>>()?;
            // Without Python's lock, so that other threads go on.
            py.detach(|| {
                let mut player = self.player.lock().unwrap_or_else(PoisonError::into_inner);
                for input in inputs {
                    let now = player.step(input);
                    let row = [player.time_s(), now.key_m, now.hammer_rise_m, now.hammer_rise_m_per_s, now.string_n];
                    columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
                }
            });
        }
        let all = PyDict::new(py);
        for (name, values) in
            ["time_s", "key_m", "hammer_rise_m", "hammer_rise_m_per_s", "string_N"].into_iter().zip(columns)
        {
            all.set_item(name, array(py, values))?;
        }
        Ok(all)
    }

    fn reading(&self, py: Python<'_>) -> Reading {
        reading(&self.lock(py))
    }

    fn angles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.lock(py).angles().to_pyarray(py)
    }

    fn velocities<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.lock(py).velocities().to_pyarray(py)
    }

    fn contact_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let player = self.lock(py);
        let forces = (0..self.instrument.zones.len()).map(|zone| player.contact_force(zone));
        let forces: Vec<f64> = forces.collect::<Result<_, _>>().map_err(wrong)?;
        Ok(forces.to_pyarray(py))
    }

    /// Returns the complete state as bytes.
    fn save<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.lock(py).save().to_vec())
    }

    fn restore(&self, py: Python<'_>, saved: &[u8]) -> PyResult<()> {
        let snapshot = Snapshot::from_bytes(saved).map_err(wrong)?;
        self.lock(py).restore(&snapshot).map_err(wrong)
    }
}

impl Action {
    /// Locks the action. Waits without Python's lock, so that the thread that holds the action can finish.
    fn lock(&self, py: Python<'_>) -> MutexGuard<'_, Player> {
        self.player.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }
}
