//! Effective inertia of keys in bass and treble, from the keyboard of middle C.

use super::Skipped;
use crate::measure::norms::lines;
use crate::measure::{MeasureError, measure_some};
use erard::Progress;
use erard::keyboard::Keyboard;

/// E2 and E7.
const PLACES: [usize; 2] = [20, 80];

/// Names for rows; each ends with its unit.
pub(super) const NAMES: [&str; 2] = ["effective_inertia_e2_kg", "effective_inertia_e7_kg"];

/// Effective inertias, kg, in the order of [`NAMES`]; `None` without a keyboard.
pub(super) fn measure(
    keyboard: Option<&Keyboard>,
    progress: &mut Progress<'_>,
) -> Result<Option<[Option<f64>; 2]>, MeasureError> {
    let Some(keyboard) = keyboard else { return Ok(None) };
    let Some(line) = lines().find(|line| line.key == "effective_inertia_kg") else { return Ok(None) };
    let mut found = [None; 2];
    for (found, key) in found.iter_mut().zip(PLACES) {
        if let Ok(instrument) = keyboard.key(key) {
            *found = measure_some(&instrument, &[line], progress)?.first().copied().flatten();
        }
    }
    Ok(Some(found))
}

/// Value of one of [`NAMES`], or why it is skipped; `None` for another name.
pub(super) fn value(name: &str, found: Option<[Option<f64>; 2]>) -> Option<Result<Option<f64>, Skipped>> {
    let which = NAMES.iter().position(|known| *known == name)?;
    Some(found.map(|found| found[which]).ok_or(Skipped::NoKeyboard))
}
