//! What `erard measure` makes of the sheets: the table, the figures, the page.

pub mod figures;
pub mod page;
pub mod rows;
pub mod table;

use erard::instrument::Instrument;
use erard_workshop::measure::Sheet;

/// One action that was measured.
#[derive(Debug, Clone)]
pub struct Measured {
    /// What it is called beside the others.
    pub label: String,
    /// The action.
    pub instrument: Instrument,
    /// Its sheet.
    pub sheet: Sheet,
}
