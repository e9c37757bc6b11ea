//! Hysteresis loop: force against displacement of a key moved so slowly that only weights, springs, felts and dry
//! friction remain.

use moreau::{Settings, StepOutcome};

use super::MeasureError;
use erard::Progress;
use erard::mechanism::Halving;
use erard::player::{AtRest, Input, motion};
use erard::run::{Setup, SimulationError, simulate_at_rest};
use erard::stroke::least_jerk;

/// Time of the press, and of the return, s. The hammer on its felts swings at about 10 Hz, which dry friction on a
/// moving pivot does not damp; over eight seconds a few hundredths of a newton remain of it.
const WAY_S: f64 = 8.0;
/// Rest at the turning point, s.
const TURN_S: f64 = 0.3;
/// Step, s: the key creeps; a sixteenth of it changes no down-weight or up-weight by more than 0.0002 g (on the three
/// built-in grands and five drawn ones).
const STEP_S: f64 = 400e-6;
/// Steps per recorded row: 4000 rows in each direction, two and a half micrometres of the key apart.
const RECORD_EVERY: u64 = 5;
/// Half-width of key travel over which forces are averaged, m: this removes the hammer's swing, and flattens a peak,
/// whose slopes are some grams per millimetre, by less than a tenth of a gram.
const HALF_WINDOW_M: f64 = 0.05e-3;

/// A slow press and return.
#[derive(Debug, Clone, PartialEq)]
pub struct SlowLoop {
    /// The press.
    pub down: SlowWay,
    /// The return, in the order of time: from the turning point to rest.
    pub up: SlowWay,
    /// Steps that did not converge.
    pub unconverged_steps: u64,
}

/// One direction of a slow loop.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SlowWay {
    /// Travel of the key front from rest, m, down positive.
    pub key_m: Vec<f64>,
    /// Force of the finger on the key front, N, down positive.
    pub force_n: Vec<f64>,
    /// Rise of the strike point from rest, m.
    pub head_m: Vec<f64>,
}

/// Moves a soft finger slowly to `depth_m` below the key's rest, and back.
///
/// # Errors
/// Errors of the simulation; an interruption.
pub fn slow_loop(action: &dyn AtRest, depth_m: f64, progress: &mut Progress<'_>) -> Result<SlowLoop, MeasureError> {
    let finger = |t: f64| {
        let ([down, down_rate], [up, up_rate]) = (least_jerk(t / WAY_S), least_jerk((t - WAY_S - TURN_S) / WAY_S));
        [depth_m * (down - up), depth_m * (down_rate - up_rate) / WAY_S]
    };
    let setup = Setup {
        settings: Settings::new(STEP_S),
        record_every: Some(RECORD_EVERY),
        ledger: false,
        // As for weights (`trial.rs`): nothing sounds.
        halving: Halving::Never,
        ..Setup::new(2.0 * WAY_S + TURN_S)
    };
    let rest = action.pose(progress).map_err(SimulationError::from)?;
    let run = simulate_at_rest(&rest, &motion(finger), &setup, &mut |_| progress(0.0))?;
    let way = |from: f64, to: f64| {
        let rows = run.time_s.partition_point(|&t| t < from)..run.time_s.partition_point(|&t| t <= to);
        SlowWay {
            key_m: run.key_m[rows.clone()].to_vec(),
            force_n: run.force_n[rows.clone()].to_vec(),
            head_m: run.hammer_rise_m.get(rows).unwrap_or_default().to_vec(),
        }
    };
    Ok(SlowLoop {
        down: way(0.0, WAY_S),
        up: way(WAY_S + TURN_S, f64::INFINITY),
        unconverged_steps: run.work.unconverged_steps,
    })
}

/// Moves a soft finger slowly to `depth_m` below the key's rest, until one of some zones touches. Returns the touching
/// zones and the travel of the key front, m. Most of a slow loop, and its costliest part, lies beyond that point.
///
/// # Errors
/// Errors of the simulation; an interruption.
pub(crate) fn first_touch(
    action: &dyn AtRest,
    depth_m: f64,
    zones: &[usize],
    progress: &mut Progress<'_>,
) -> Result<Option<(Vec<usize>, f64)>, MeasureError> {
    let settings = Settings::new(STEP_S);
    let mut action = action.pose(progress).and_then(|rest| rest.action(settings)).map_err(SimulationError::from)?;
    action.halve(Halving::Never);
    let steps = (WAY_S / STEP_S).round() as u64;
    for n in 0..=steps {
        if n.is_multiple_of(RECORD_EVERY) {
            let mut touch = Vec::new();
            for &zone in zones {
                if action.contact_force(zone)? > 0.0 {
                    touch.push(zone);
                }
            }
            if !touch.is_empty() {
                return Ok(Some((touch, action.reading().key_m)));
            }
            if !progress(0.0) {
                return Err(SimulationError::Interrupted.into());
            }
        }
        let [share, rate] = least_jerk((n as f64 * STEP_S + settings.theta * STEP_S) / WAY_S);
        let finger = Input::Motion { position_m: depth_m * share, velocity_m_per_s: depth_m * rate / WAY_S };
        if action.step(finger).outcome == StepOutcome::NonFinite {
            return Err(SimulationError::NonFinite { time_s: action.time_s() }.into());
        }
    }
    Ok(None)
}

impl SlowLoop {
    /// Work of the loop, J: the area between press and return.
    #[must_use]
    pub(crate) fn lost_j(&self) -> f64 {
        let work = |way: &SlowWay| {
            let rows = way.key_m.windows(2).zip(way.force_n.windows(2));
            rows.map(|(key, force)| 0.5 * (force[0] + force[1]) * (key[1] - key[0])).sum::<f64>()
        };
        work(&self.down) + work(&self.up)
    }
}

impl SlowWay {
    /// Mean force around key travel `key_m`, N; `None` outside the recorded travel.
    #[must_use]
    pub fn force(&self, key_m: f64) -> Option<f64> {
        let near = self.key_m.iter().zip(&self.force_n).filter(|(key, _)| (*key - key_m).abs() <= HALF_WINDOW_M);
        let (sum, count) = near.fold((0.0, 0_u32), |(sum, count), (_, force)| (sum + force, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }

    /// Key travel and mean force on a grid from `from_m` to `to_m`, every fiftieth of a millimetre.
    pub(crate) fn smoothed(&self, from_m: f64, to_m: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        const EVERY_M: f64 = 2e-5;
        let points = ((to_m - from_m) / EVERY_M).floor().max(0.0) as usize;
        (0..=points).map(move |i| from_m + i as f64 * EVERY_M).filter_map(|key| Some((key, self.force(key)?)))
    }
}
