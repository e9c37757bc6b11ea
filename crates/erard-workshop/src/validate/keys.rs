//! Values of keys in bass and treble, from the keyboard of middle C: effective inertia, and friction weight.

use super::Skipped;
use crate::measure::norms::lines;
use crate::measure::{MeasureError, measure_some};
use erard::Progress;
use erard::keyboard::Keyboard;

/// Lines of the sheet, each with two keys: E2 and E7, and the first and the last.
const ASKED: [(&str, [usize; 2]); 2] = [("effective_inertia_kg", [20, 80]), ("friction_weight_g", [1, 88])];

/// Names for rows; each ends with its unit.
pub(super) const NAMES: [&str; 5] = [
    "effective_inertia_e2_kg",
    "effective_inertia_e7_kg",
    "friction_weight_a0_g",
    "friction_weight_c8_g",
    "friction_weight_a0_over_c8",
];

/// Values in the order of [`NAMES`], each in its unit; `None` without a keyboard.
pub(super) fn measure(
    keyboard: Option<&Keyboard>,
    progress: &mut Progress<'_>,
) -> Result<Option<[Option<f64>; 5]>, MeasureError> {
    let Some(keyboard) = keyboard else { return Ok(None) };
    let mut found = [None; 5];
    let asked = ASKED.iter().flat_map(|(line, keys)| keys.iter().map(move |key| (*line, *key)));
    for (found, (name, key)) in found.iter_mut().zip(asked) {
        let Some(line) = lines().find(|line| line.key == name) else { continue };
        if let Ok(instrument) = keyboard.key(key) {
            *found = measure_some(&instrument, &[line], progress)?.first().copied().flatten();
        }
    }
    found[4] = found[2].zip(found[3]).map(|(bass, treble)| bass / treble);
    Ok(Some(found))
}

/// Value of one of [`NAMES`], or why it is skipped; `None` for another name.
pub(super) fn value(name: &str, found: Option<[Option<f64>; 5]>) -> Option<Result<Option<f64>, Skipped>> {
    let which = NAMES.iter().position(|known| *known == name)?;
    Some(found.map(|found| found[which]).ok_or(Skipped::NoKeyboard))
}
