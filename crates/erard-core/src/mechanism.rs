//! An instrument's mechanism, of any size, behind one interface, which [`crate::Action`] steps.

pub use moreau_kernels::{
    Halving, Impact, InputDuring, Mechanism, Observation, Readout, Saved, Size, StatePart, StepOutput, Stepping,
    Surfaces, TellNumbers, open_ledger, update_energies,
};

use moreau::{ModelError, Settings};

use crate::assembly::{describe, probes};
use crate::instrument::Instrument;
use crate::strings::Strings;

/// Smallest step that an action takes, s: below it the rounding of a position sum exceeds what the step improves.
pub(crate) const SMALLEST_STEP_S: f64 = 1e-8;
/// Largest step that an action takes, s: a fortissimo impact lasts two of them.
pub(crate) const MAX_STEP_S: f64 = 1e-3;

/// Assembles an instrument into the smallest engine size that holds it, at the angles as drawn.
///
/// # Errors
/// [`ModelError`] if no size holds it.
pub fn mechanism(instrument: &Instrument, settings: Settings<f64>) -> Result<Box<dyn Mechanism>, ModelError> {
    let strings = Strings::of(instrument).map(|strings| Box::new(strings) as Box<dyn Surfaces>);
    moreau_kernels::mechanism(&describe(instrument), &probes(instrument), settings, strings)
}
