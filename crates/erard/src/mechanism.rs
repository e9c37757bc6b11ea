//! An instrument's mechanism, of any size, behind one interface: what [`crate::Action`] plays.

pub use moreau_kernels::{InputDuring, Mechanism, Saved, Size, Surfaces, TellNumbers, View};

use moreau::{ModelError, Settings};

use crate::assembly::{describe, marks};
use crate::instrument::Instrument;
use crate::strings::Strings;

/// Assembles an instrument into the smallest engine size that holds it, at the angles as drawn.
///
/// # Errors
/// [`ModelError`] if no size holds it.
pub fn mechanism(instrument: &Instrument, settings: Settings<f64>) -> Result<Box<dyn Mechanism>, ModelError> {
    let mut mechanism = moreau_kernels::mechanism(&describe(instrument), &marks(instrument), settings)?;
    if let Some(strings) = Strings::of(instrument, settings.step) {
        mechanism.set_surfaces(Box::new(strings));
    }
    Ok(mechanism)
}
