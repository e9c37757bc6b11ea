//! An instrument's mechanism, of any size, behind one interface: what [`crate::Action`] plays.

pub use moreau_kernels::{
    Impact, InputDuring, Mechanism, Observation, Readout, Saved, Size, StepOutput, Stepping, Surfaces, open_ledger,
    take_stock,
};

use moreau::{ModelError, Settings};

use crate::assembly::{describe, probes};
use crate::instrument::Instrument;
use crate::strings::Strings;

/// Assembles an instrument into the smallest engine size that holds it, at the angles as drawn.
///
/// # Errors
/// [`ModelError`] if no size holds it.
pub fn mechanism(instrument: &Instrument, settings: Settings<f64>) -> Result<Box<dyn Mechanism>, ModelError> {
    let strings = Strings::of(instrument, settings.step).map(|strings| Box::new(strings) as Box<dyn Surfaces>);
    moreau_kernels::mechanism(&describe(instrument), &probes(instrument), settings, strings)
}
