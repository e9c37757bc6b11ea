//! A stroke that a sensor behind the balance pin recorded drives the key there.

use erard::Progress;
use erard::instrument::Instrument;
use erard::player;
use erard::recording::{Butterworth, interpolated};
use erard::run::{Run, Setup, SimulationError, simulate};
use erard::stroke::PositionSeries;

/// Runs in which the sinking of the pivot is found, at most. Each leaves a fifth of the error of the one before: heel
/// and punching in series.
const MOST_RUNS: usize = 6;
/// Change of the sinking from one run to the next at which it is known, m: a fiftieth of what the sensors of the
/// packaged recordings are known to.
const KNOWN_M: f64 = 4e-6;
/// Frequency up to which the sinking is taken off the readings, Hz. It follows the load; above, a key of 0.14 kg swings
/// on its punching (some 160 Hz under its own weight and the stack's), which the readings do not determine.
const FOLLOWS_HZ: f64 = 80.0;

/// An action that the key's back drives.
pub(super) struct KeyBack {
    /// The action, driven on the first piece of its key.
    pub instrument: Instrument,
    /// See [`Instrument::key_back_misreads`].
    misreads: f64,
    /// Name of the key's first piece.
    key: Option<String>,
}

impl KeyBack {
    pub fn of(instrument: &Instrument) -> Self {
        let driven = instrument.driven_at_key_back();
        let key = driven.roles.key.map(|key| driven.bodies[key].name.clone());
        KeyBack { instrument: driven, misreads: instrument.key_back_misreads(), key }
    }

    /// Plays readings that are referred to the front, m downward, and looks at `time_s`, `rate_hz` a second. The pivot
    /// of a key that lies sinks under a load, and the sensor sees that with the other sign than the driven point; how
    /// far it sinks is known after a run only. So it is taken off the readings and played again, until it is the same.
    pub fn play(
        &self,
        readings: &PositionSeries,
        (time_s, rate_hz): (&[f64], f64),
        setup: &Setup,
        progress: &mut Progress<'_>,
    ) -> Result<Run, SimulationError> {
        let path = readings.drive();
        let mut of_run = |n: usize, share: f64| progress((n as f64 + share) / MOST_RUNS as f64);
        let mut run = simulate(&self.instrument, &player::rigid(&path), setup, &mut |share| of_run(0, share))?;
        let rise = |run: &Run| {
            let lift = run.lifts.iter().find(|lift| Some(&lift.name) == self.key.as_ref())?;
            let rise = interpolated(&run.time_s, &lift.lift_m, time_s);
            let rise: Vec<f64> = rise.iter().map(|m| m - rise[0]).collect();
            Some(Butterworth::low_pass(4, FOLLOWS_HZ, rate_hz)?.forth_and_back(&rise))
        };
        let Some(mut risen) = rise(&run) else { return Ok(run) };
        for n in 1..MOST_RUNS {
            let paths = time_s.iter().zip(&risen).map(|(&t, rise)| path(t)[0] - self.misreads * rise);
            let Ok(corrected) = PositionSeries::new(time_s.to_vec(), paths.collect()) else { break };
            let drive = corrected.drive();
            run = simulate(&self.instrument, &player::rigid(&drive), setup, &mut |share| of_run(n, share))?;
            let now = rise(&run).unwrap_or_default();
            let changed = risen.iter().zip(&now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            risen = now;
            if changed < KNOWN_M {
                break;
            }
        }
        Ok(run)
    }
}
