//! Scatter that a technician leaves: keys of one piano differ within what can be read and set on the bench.

use super::random::deviation;
use crate::measure::MeasureError;
use crate::worklist::{ReadingQuantity, Work};
use erard::Progress;
use erard::instrument::Instrument;

/// Varies a key in place as a technician would leave it: every distance set by a screw, the strike weight and the
/// friction weight deviate by about the precision of a technician's reading ([`ReadingQuantity::precision`]: let-off
/// and drop 0.25 mm, dip 0.1 mm, strike weight 0.1 g), nine times out of ten by less. The turn of a screw is the first
/// guess of the regulation, so the distances themselves scatter somewhat more or less.
///
/// The deviations depend on the sample's number, the key and the quantity only, and have the same bits on every
/// machine. Screws that an instrument does not have are left out.
///
/// # Errors
/// Errors of weighing, because friction is set with a weight on the key; an interruption by `progress`.
pub fn technicians_scatter(
    instrument: &mut Instrument,
    sample: u32,
    key: usize,
    progress: &mut Progress<'_>,
) -> Result<(), MeasureError> {
    for quantity in ReadingQuantity::ALL {
        let by = quantity.precision() * deviation(sample, 0, &format!("technician: {}", quantity.key()), key);
        match quantity {
            ReadingQuantity::StrikeWeight => Work::Hammer { by_g: by }.carry_out(instrument, progress)?,
            ReadingQuantity::FrictionWeight => Work::Friction { by_g: by }.carry_out(instrument, progress)?,
            _ => turn(instrument, quantity, by),
        }
    }
    Ok(())
}

/// Turns the screw of a quantity to change it by about `by`, in the sheet's unit.
fn turn(instrument: &mut Instrument, quantity: ReadingQuantity, by: f64) {
    let Some((known, effect)) = quantity.goal().and_then(|goal| goal.screws().next()) else { return };
    let Some(screw) = instrument.screw(known.name) else { return };
    let turned = &instrument.screws[screw];
    let [least, most] = known.limits(instrument, turned);
    let by = by / quantity.factor() / effect * known.sense(turned);
    let setting = (turned.setting + by).clamp(least.min(turned.setting), most.max(turned.setting));
    // A spring's range ends before it is turned around.
    let _ = instrument.turn(screw, setting);
}
