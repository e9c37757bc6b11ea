//! A press of the dynamic model, slow enough that only geometry matters: a check of the kinematics.
//!
//! The remaining difference is due to the play and the felts, which take up the first tenths of a millimetre, and to
//! the change of the felts' compression as the forces vary.

use crate::three_lever::{DiscLevers, LeverTrain};
use moreau::Settings;

use erard::instrument::Instrument;
use erard::player::motion;
use erard::run::{Setup, SimulationError, simulate};
use erard::stroke::least_jerk;

/// Simulated time, s. The hammer on its felts swings at about 10 Hz after it has been set in motion, and dry friction
/// on a moving pivot does not damp that; over eight seconds the swing dies away while the key goes a few tenths of a
/// millimetre.
const DURATION_S: f64 = 8.0;
/// Step, s: 100 steps per swing at 100 Hz, with the engine's second-order scheme.
const STEP_S: f64 = 100e-6;
/// Every so many steps are kept: 4000 rows, two micrometres of the key apart.
const RECORD_EVERY: u64 = 20;
/// How far beyond the end of the comparison the finger goes, m: to show what happens there.
const BEYOND_M: f64 = 1.0e-3;
/// Leverage is a difference over this half-width of key travel, m: a hundredth of the dip, ten times what is left of a
/// swing.
const HALF_WINDOW_M: f64 = 1e-4;
/// The parts are in touch once the head has risen by so much, m: a fiftieth of the blow.
const TAKEN_UP_RISE_M: f64 = 1e-3;

/// Result of a slow press.
#[derive(Debug, Clone, PartialEq)]
pub struct SlowPress {
    /// Travel of the key's front along its arc, m, per row of the run; increasing except for rounding.
    pub key_m: Vec<f64>,
    /// Rise of the strike point, m, per row of the run.
    pub head_rise_m: Vec<f64>,
    /// Key travel at which the jack's toe touched the let-off button, m; `None` if it did not.
    pub toe_contact_key_m: Option<f64>,
}

/// Agreement of kinematics and slow press, from where play is taken up to let-off.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// Key travel of each comparison, m.
    pub key_m: Vec<f64>,
    /// Leverage of the dynamic model over that of the geometry at the same key travel, minus 1, per comparison.
    pub deviation: Vec<f64>,
    /// Largest absolute deviation.
    pub worst: f64,
}

/// Presses an instrument slowly, to slightly beyond key travel `to_m` (m). The finger is soft and only pushes, so that
/// the leverage is computed from the motion of the key itself.
///
/// # Errors
/// Returns the error of the simulation.
pub fn slow_press(instrument: &Instrument, levers: &DiscLevers, to_m: f64) -> Result<SlowPress, SimulationError> {
    let depth = to_m + BEYOND_M;
    let finger = |t: f64| {
        let [way, rate] = least_jerk(t / DURATION_S);
        [depth * way, depth * rate / DURATION_S]
    };
    let setup = Setup {
        settings: Settings::new(STEP_S),
        record_every: Some(RECORD_EVERY),
        ledger: false,
        ..Setup::new(DURATION_S)
    };
    // The levers that it is compared with are rigid.
    let instrument = &instrument.locked();
    let run = simulate(instrument, &motion(finger), &setup, &mut |_| true)?;
    let angles = instrument.roles.key.map_or(&[][..], |key| &run.bodies[key].angle_rad);
    let rest = angles.first().copied().unwrap_or(0.0);
    let key_m: Vec<f64> = angles.iter().map(|angle| (angle - rest) * levers.key_front).collect();
    let toe_contact_key_m = run.events.toe_contact_s.and_then(|t| {
        let row = run.time_s.partition_point(|&time| time < t);
        key_m.get(row).copied()
    });
    Ok(SlowPress { key_m, head_rise_m: run.hammer_rise_m, toe_contact_key_m })
}

impl SlowPress {
    /// Returns the leverage at key travel `key_m` (m): rise of the head over travel of the key, in a window around it.
    /// `None` if the key did not pass through the whole window.
    #[must_use]
    pub fn leverage(&self, key_m: f64) -> Option<f64> {
        let rise = |travel: f64| {
            let row = self.key_m.partition_point(|&key| key < travel);
            let (after, before) = (*self.key_m.get(row)?, *self.key_m.get(row.checked_sub(1)?)?);
            let part = (travel - before) / (after - before);
            Some(self.head_rise_m[row - 1] + part * (self.head_rise_m[row] - self.head_rise_m[row - 1]))
        };
        Some((rise(key_m + HALF_WINDOW_M)? - rise(key_m - HALF_WINDOW_M)?) / (2.0 * HALF_WINDOW_M))
    }

    /// Returns the key travel at which play and felts are taken up and the head is rising, m; `None` if the head did
    /// not rise so far.
    #[must_use]
    pub fn taken_up_key_m(&self) -> Option<f64> {
        let row = self.head_rise_m.iter().position(|&rise| rise > TAKEN_UP_RISE_M)?;
        self.key_m.get(row).copied()
    }

    /// Compares leverages at least every twentieth of a millimetre, from where play is taken up to where the toe
    /// touches, or to `let_off_m` (m) if that is earlier or there is no toe. `None` if no range remains.
    #[must_use]
    pub fn agreement(&self, train: &LeverTrain, let_off_m: f64) -> Option<Agreement> {
        const EVERY_M: f64 = 5e-5;
        let from = self.taken_up_key_m()? + HALF_WINDOW_M;
        let to = self.toe_contact_key_m.unwrap_or(let_off_m).min(let_off_m) - HALF_WINDOW_M;
        if from >= to {
            return None;
        }
        let steps = ((to - from) / EVERY_M).ceil() as usize;
        let poses = train.stroke(from, to, steps).poses;
        let (key_m, deviation): (Vec<f64>, Vec<f64>) =
            poses.iter().filter_map(|pose| Some((pose.key, self.leverage(pose.key)? / pose.leverage - 1.0))).unzip();
        let worst = deviation.iter().fold(0.0, |worst: f64, d| worst.max(d.abs()));
        (!key_m.is_empty()).then_some(Agreement { key_m, deviation, worst })
    }
}
