//! Every key on the technician's bench: hammers, leads and touch weights over the keyboard.

use crate::cores;
use crate::measure::MeasureError;
use crate::measure::weights::{LoopWeights, Touch, by_loop, free_way, on_the_scale};
use crate::test_press::{TestPress, test_press};
use erard::Progress;
use erard::grand::{Parts, pedal_down};
use erard::instrument::Instrument;
use erard::keyboard::note_name;
use erard::player::AtRest;

/// A key on the bench.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct WeighedKey {
    /// Number of the key, from 1.
    pub key: usize,
    /// Note name, e.g. `C4`.
    pub note: String,
    /// Its weights, or the reason why it cannot be weighed.
    pub weights: Result<Weights, String>,
}

impl WeighedKey {
    /// Reason why the key has no weights, or why some of them, or its hammer speed, are missing.
    #[must_use]
    pub fn error(&self) -> Option<String> {
        let weights = match &self.weights {
            Ok(weights) => weights,
            Err(error) => return Some(error.clone()),
        };
        // The string first: the key was played before it was weighed. A hammer that nothing stops may not come back.
        if weights.test_press.hammer_speed_m_per_s.is_none() {
            return Some("pressed mezzo forte, the hammer does not reach the string".to_owned());
        }
        let sinks = weights.touch.balance_weight_g().is_some();
        (!sinks).then(|| "in a slow loop the key does not sink, or does not come up".to_owned())
    }
}

/// Weights of a key.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// Mass of the hammer with its shank, g.
    pub hammer_mass_g: f64,
    /// Weight of the strike point on the scale, the hammer on its pin and its shank level, g.
    pub strike_weight_g: f64,
    /// Weight of the key's front on the scale, the key level on its balance pin, g.
    pub front_weight_g: f64,
    /// Down-weight and up-weight from a slow loop, dampers lifted, g.
    pub touch: Touch,
    /// One mezzo forte press: hammer speed, and reasons why the press cannot be trusted.
    pub test_press: TestPress,
}

/// Weighs keys, each given with its number. `progress` receives the share done, and ends the work by returning false.
/// A key that cannot be weighed does not stop the others.
///
/// # Errors
/// An interruption, or the first key's error if none can be weighed.
pub fn weigh(keys: &[(usize, Instrument)], progress: &mut Progress<'_>) -> Result<Vec<WeighedKey>, MeasureError> {
    let weigh =
        |(_, instrument): &(usize, Instrument), progress: &mut Progress<'_>| match weigh_key(instrument, progress) {
            Err(error) if error.is_interruption() => Err(error),
            found => Ok(found),
        };
    let mut found: Vec<Result<Weights, MeasureError>> = cores::map(keys, cores::count(), progress, weigh)?;
    if found.iter().all(Result::is_err) && !found.is_empty() {
        return Err(found.swap_remove(0).err().unwrap_or(MeasureError::Lost));
    }
    let rows = keys.iter().zip(found).map(|((key, _), weights)| WeighedKey {
        key: *key,
        note: note_name(*key),
        weights: weights.map_err(|error| error.to_string()),
    });
    Ok(rows.collect())
}

/// A key's weights from a slow loop, dampers lifted, and its free travel, m.
fn loop_weights(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<(LoopWeights, f64), MeasureError> {
    let parts = Parts::of(instrument)?;
    let lifted = pedal_down(instrument, &parts)?;
    let lifted = &*lifted.pose(progress)?;
    let way = free_way(lifted, &parts, progress)?;
    Ok((by_loop(lifted, way.end_m, progress)?, way.end_m))
}

/// Down-weight and up-weight from a slow loop, dampers lifted.
pub(crate) fn touch(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Touch, MeasureError> {
    Ok(loop_weights(instrument, progress)?.0.touch)
}

/// A scale that remembers what it weighed: an action that comes back is not weighed again.
#[derive(Debug, Default)]
pub(crate) struct Scale {
    known: Vec<(Instrument, Touch)>,
}

impl Scale {
    /// Down-weight and up-weight as [`touch`] finds them.
    pub(crate) fn touch(
        &mut self,
        instrument: &Instrument,
        progress: &mut Progress<'_>,
    ) -> Result<Touch, MeasureError> {
        if let Some((_, known)) = self.known.iter().find(|(known, _)| known == instrument) {
            return Ok(*known);
        }
        let found = touch(instrument, progress)?;
        self.known.push((instrument.clone(), found));
        Ok(found)
    }
}

fn weigh_key(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Weights, MeasureError> {
    let (weights, way_m) = loop_weights(instrument, progress)?;
    let (scale, _) = on_the_scale(instrument, way_m, weights.decided_m)?;
    let rigid = instrument.locked();
    Ok(Weights {
        test_press: test_press(instrument, progress)?,
        // Rounded to remove the rounding errors of a sum.
        hammer_mass_g: (rigid.bodies[Parts::of(&rigid)?.hammer].mass_kg * 1e12).round() / 1e9,
        strike_weight_g: scale.strike_weight_g,
        front_weight_g: scale.front_weight_g,
        touch: weights.touch,
    })
}
