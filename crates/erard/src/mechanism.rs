//! An instrument's mechanism, of any size, behind one interface: what [`crate::Action`] plays.

pub use moreau_sizes::{InputDuring, Mechanism, Saved, Size, View};

use moreau::{ModelError, Settings};

use crate::assembly::{describe, marks};
use crate::instrument::Instrument;

/// Assembles an instrument into the smallest engine size that holds it, at the angles as drawn.
///
/// # Errors
/// [`ModelError`] if no size holds it.
pub fn mechanism(instrument: &Instrument, settings: Settings<f64>) -> Result<Box<dyn Mechanism>, ModelError> {
    moreau_sizes::mechanism(&describe(instrument), &marks(instrument), settings)
}
