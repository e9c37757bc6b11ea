//! An action with what to do about it.

use erard_workshop::worklist::Worklist;

use crate::measure::Measured;
use crate::paper::PageHeader;
use crate::units::Lengths;

/// An action with what to do about it.
#[derive(Debug)]
pub(crate) struct AdvisedInstrument<'a> {
    /// The action, and what was measured.
    pub measured: &'a Measured,
    /// What to do.
    pub list: Worklist,
    /// A drawing of it.
    pub drawing: String,
    /// What stands at the head.
    pub page_header: &'a PageHeader,
    /// How lengths are shown.
    pub lengths: Lengths,
}

/// One thing to do: what, how far, and why.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(crate) struct Task {
    /// What is worked on: `drop screw`.
    pub what: String,
    /// Which way and how far.
    pub by: String,
    /// What it does.
    #[serde(rename = "for")]
    pub for_: String,
    /// What could be done instead.
    pub instead: Option<String>,
    /// What to read before the next line.
    pub then: Option<String>,
    /// What every line reads then, by the keys of measure.json.
    #[serde(rename = "readings_after")]
    pub readings: serde_json::Value,
}
