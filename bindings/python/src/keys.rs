//! The keys of a keyboard, played together, from Python.

use std::sync::{Mutex, MutexGuard, PoisonError};

use erard::instrument_spec::InstrumentSpec;
use erard::key::{EXPECTED, key_named};
use erard::keyboard::Keys as Player;
use erard::player::{Hand, Reading as Now, Snapshot};
use erard::strings::Strings;
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;

use crate::action::{Reading, driven, input};
use crate::fault::{self, failed, wrong, wrong_argument};
use crate::setup::Steps;

/// Number of steps between two checks for signals.
const PORTION: usize = 1000;

/// A key as a caller names it: its number, or its note or number as text.
#[derive(FromPyObject)]
pub(crate) enum Key {
    Number(i64),
    Text(String),
}

impl Key {
    /// Returns the number of the key, 1 to 88; `argument` is named in the error.
    pub(crate) fn number(&self, argument: &str) -> PyResult<usize> {
        let text = match self {
            Key::Number(number) => number.to_string(),
            Key::Text(text) => text.clone(),
        };
        key_named(&text).ok_or_else(|| wrong_argument(argument, format!("found {text}, expected {EXPECTED}")))
    }
}

/// Keys of a keyboard. Two threads may step them: one waits for the other.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Keys {
    player: Mutex<Player>,
    hand: Option<Hand>,
    /// Time on the keys' clock when they were made and at rest, s.
    began_s: f64,
}

impl Keys {
    fn lock(&self, py: Python<'_>) -> MutexGuard<'_, Player> {
        self.player.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    fn has(player: &Player, key: &Key) -> PyResult<usize> {
        let key = key.number("key")?;
        if key <= player.count() {
            return Ok(key);
        }
        Err(wrong_argument("key", format!("found {key}, expected 1 to {}", player.count())))
    }
}

#[pymethods]
impl Keys {
    #[new]
    fn new(py: Python<'_>, asked: &str, steps: Steps) -> PyResult<Self> {
        let keyboard =
            asked.parse().and_then(|asked: InstrumentSpec| asked.keyboard()).map_err(|error| fault::asked(&error))?;
        let instruments = py.detach(|| keyboard.instruments()).map_err(|error| fault::file(&error))?;
        let first = instruments.first().ok_or_else(|| wrong("the keyboard has no key"))?;
        let (settings, hand) = (steps.settings(first)?, steps.hand()?);
        steps.setup(first, 0.0, 1.0)?.check().map_err(|error| fault::simulation(&error))?;
        let mut player = py
            .detach(|| Player::at_rest(&instruments, settings))
            .map_err(|error| wrong(format!("{}, key {}: {}", keyboard.name, error.key, error.error)))?;
        if let Some(hand) = &hand {
            for key in 1..=player.count() {
                player.place_hand(key, hand.start_m, hand.start_m_per_s).map_err(wrong)?;
            }
        }
        let began_s = player.time_s();
        Ok(Keys { player: Mutex::new(player), hand, began_s })
    }

    fn count(&self, py: Python<'_>) -> usize {
        self.lock(py).count()
    }

    fn awake(&self, py: Python<'_>) -> usize {
        self.lock(py).awake()
    }

    fn step_s(&self, py: Python<'_>) -> f64 {
        self.lock(py).settings().step
    }

    fn time_s(&self, py: Python<'_>) -> f64 {
        self.lock(py).time_s() - self.began_s
    }

    #[pyo3(signature = (key, force, motion, rigid))]
    fn drive(
        &self,
        py: Python<'_>,
        key: Key,
        force: Option<f64>,
        motion: Option<(f64, f64)>,
        rigid: Option<(f64, f64)>,
    ) -> PyResult<()> {
        let input = driven(self.hand, input(force, motion, rigid)?)?;
        let mut player = self.lock(py);
        let key = Self::has(&player, &key)?;
        player.drive(key, input).map_err(wrong)
    }

    fn place_hand(&self, py: Python<'_>, key: Key, position_m: f64, velocity_m_per_s: f64) -> PyResult<()> {
        if self.hand.is_none() {
            return Err(wrong("these keys have no hands; expected some that were made with `hand=erard.Hand()`"));
        }
        let mut player = self.lock(py);
        let key = Self::has(&player, &key)?;
        player.place_hand(key, position_m, velocity_m_per_s).map_err(wrong)
    }

    fn set_pedal(&self, py: Python<'_>, lift_m: f64) {
        self.lock(py).set_pedal(lift_m);
    }

    /// Takes steps and returns the impacts in them: key, time (s), total hammer speed (m/s).
    fn step(&self, py: Python<'_>, steps: usize) -> PyResult<Vec<(usize, f64, f64)>> {
        let (mut impacts, mut left) = (Vec::new(), steps);
        while left > 0 {
            // A signal's handler may step the keys itself: nothing is locked then.
            py.check_signals()?;
            let portion = left.min(PORTION);
            left -= portion;
            // Without Python's lock, so that other threads go on.
            py.detach(|| {
                let mut player = self.player.lock().unwrap_or_else(PoisonError::into_inner);
                for _ in 0..portion {
                    if player.step().non_finite > 0 {
                        return Err("a number became infinite; that key is where it was before the step");
                    }
                    let new = player.impacts().iter();
                    impacts.extend(new.map(|b| (b.key, b.impact.time_s - self.began_s, b.impact.hammer_speed_m_per_s)));
                }
                Ok(())
            })
            .map_err(failed)?;
        }
        Ok(impacts)
    }

    fn reading(&self, py: Python<'_>, key: Key) -> PyResult<Reading> {
        let player = self.lock(py);
        let key = Self::has(&player, &key)?;
        let now: Now = player.reading(key).map_err(wrong)?;
        let impact = now.impact.map(|one| (one.time_s - self.began_s, one.hammer_speed_m_per_s));
        Ok(Reading::of(
            player.time_s() - self.began_s,
            &now,
            impact,
            player.strings(key).map_err(wrong)?.map_or(0.0, Strings::bridge_n),
        ))
    }

    fn bridge_n(&self, py: Python<'_>) -> f64 {
        self.lock(py).bridge_n()
    }

    /// Returns the complete state of a key as bytes, in the format of an action's.
    fn save<'py>(&self, py: Python<'py>, key: Key) -> PyResult<Bound<'py, PyBytes>> {
        let player = self.lock(py);
        let key = Self::has(&player, &key)?;
        Ok(PyBytes::new(py, &player.save(key).map_err(wrong)?.to_vec()))
    }

    fn restore(&self, py: Python<'_>, key: Key, saved: &[u8]) -> PyResult<()> {
        let snapshot = Snapshot::from_bytes(saved).map_err(wrong)?;
        let mut player = self.lock(py);
        let key = Self::has(&player, &key)?;
        player.restore(key, &snapshot).map_err(wrong)
    }
}
