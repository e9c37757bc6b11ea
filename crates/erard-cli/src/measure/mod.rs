//! The outputs of `erard measure`: the table, the figures, the page.

pub(crate) mod figures;
pub(crate) mod headlines;
mod lines;
pub(crate) mod page;
pub(crate) mod rows;
pub(crate) mod table;

pub(crate) use lines::{shown, usual};

use erard::player::RestPose;
use erard::trust::worst_of_each;
use erard_workshop::measure::Sheet;

/// Why presses of a sheet cannot be trusted: of every kind and part how many, and the worst of them.
pub(crate) fn doubts(sheet: &Sheet) -> Vec<String> {
    let presses = sheet.timing.len() + sheet.dynamic_range.len();
    worst_of_each(sheet.warnings.iter().map(|doubt| &doubt.warning))
        .into_iter()
        .map(|(count, worst)| {
            let during = sheet.warnings.iter().find(|doubt| doubt.warning == *worst).map_or("", |doubt| &doubt.during);
            format!("{count} of {presses} presses; the worst, {during}: {worst}")
        })
        .collect()
}

/// One action that was measured.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    /// Label that distinguishes it from the others.
    pub label: String,
    /// The action, where it rests.
    pub rest: RestPose,
    /// Its sheet.
    pub sheet: Sheet,
}
