//! Puts a cause into a simulated action, or removes it.

use erard::Progress;
use erard::grand::Anatomy;
use erard::instrument::Instrument;
use erard::parameter::Parameter;

use super::cause::{Cause, Change, Pivot};
use crate::measure::MeasureError;
use crate::regulate::KnownScrew;
use crate::worklist::Work;

/// Returns the amount of a cause in a case: 1 is the light one of `causes.toml`, 2 the plain one, 3 the heavy one, 4
/// the largest that is met, with linear interpolation between them. The unit is that of `amounts` there.
#[must_use]
pub fn injected_amount(cause: &Cause, case: f64) -> f64 {
    let [light, plain, heavy] = cause.amounts;
    let largest = cause.beyond.as_ref().map_or(heavy, |beyond| beyond.amount);
    match case {
        case if case <= 2.0 => light + (plain - light) * (case - 1.0),
        case if case <= 3.0 => plain + (heavy - plain) * (case - 2.0),
        case => heavy + (largest - heavy) * (case - 3.0).min(1.0),
    }
}

/// Returns an action with this amount of a cause added or, with `undo`, removed.
///
/// # Errors
/// If the instrument is no grand action.
pub fn inject(
    instrument: &Instrument,
    cause: &Cause,
    amount: f64,
    undo: bool,
    progress: &mut Progress<'_>,
) -> Result<Instrument, MeasureError> {
    let mut changed = instrument.clone();
    let signed = if undo { -amount } else { amount };
    match cause.change {
        Change::Friction(pivot) => {
            let anatomy = Anatomy::find(instrument)?;
            let body = match pivot {
                Pivot::Key => anatomy.key,
                Pivot::Hammer => anatomy.hammer,
                Pivot::Whippen => anatomy.whippen,
            };
            let factor = if undo { 1.0 / amount } else { amount };
            // The table's factors are positive.
            let _ = Parameter::PivotFriction(instrument.first_piece(body)?).vary(&mut changed, factor);
        }
        Change::Knuckle => {
            let zone = Anatomy::find(instrument)?.jack_knuckle;
            changed.edit(|fields| {
                let friction = &mut fields.zones[zone].friction_coefficient;
                *friction = (*friction + signed).max(0.0);
            })?;
        }
        Change::Screw(known) => turn(&mut changed, known, signed),
        Change::Hammer => Work::Hammer { by_g: signed }.carry_out(&mut changed, progress)?,
        Change::FrontWeight => Work::FrontWeight { by_g: signed }.carry_out(&mut changed, progress)?,
        Change::Capstan => Work::Capstan { by_mm: signed }.carry_out(&mut changed, progress)?,
    }
    Ok(changed)
}

/// Returns an action with a case of a cause, beyond the heavy one with the screw that is then set again, or with `undo`
/// without them.
///
/// # Errors
/// If the instrument is no grand action.
pub fn inject_case(
    instrument: &Instrument,
    cause: &Cause,
    case: f64,
    undo: bool,
    progress: &mut Progress<'_>,
) -> Result<Instrument, MeasureError> {
    let amount = injected_amount(cause, case);
    let changed = inject(instrument, cause, amount, undo, progress)?;
    match cause.set_again().filter(|_| case > 3.0) {
        // The farther the cause goes, the farther that screw follows it.
        Some((again, whole)) => inject(&changed, again, whole * amount / injected_amount(cause, 4.0), undo, progress),
        None => Ok(changed),
    }
}

/// Turns a screw in the direction of technicians' words; a spring by a share of its torque.
fn turn(instrument: &mut Instrument, known: &KnownScrew, by: f64) {
    let Some(screw) = instrument.screw(known.name) else { return };
    let turned = &instrument.screws[screw];
    let by = match turned.action {
        erard::instrument::ScrewAction::Spring { spring } => {
            // A share of the drawn torque, so that the same share back undoes it.
            by * (instrument.springs[spring].torque_n_m.abs() - turned.setting)
        }
        _ => by * known.sense(turned),
    };
    let setting = turned.setting + by;
    let _ = instrument.turn(screw, setting);
}
