//! Table of causes, `causes.toml`.

use std::sync::LazyLock;

use serde::Deserialize;

/// A cause of faults, with its quick test and its cure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cause {
    /// Name in JSON.
    pub key: String,
    /// Name at the bench.
    pub name: String,
    /// Prior odds: frequency of the cause, an estimate.
    pub common: f64,
    /// Change in a simulated action.
    pub(super) change: String,
    /// Size of the change in a light, a plain and a heavy case.
    pub(super) amounts: [f64; 3],
    /// Quick test that distinguishes it from the other causes.
    pub test: String,
    /// Cure.
    pub cure: String,
    /// Source in the literature.
    pub source: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    format: String,
    cause: Vec<Cause>,
}

static CAUSES: LazyLock<Vec<Cause>> = LazyLock::new(|| {
    let table: Table = toml::from_str(include_str!("causes.toml")).expect("the built-in causes read");
    assert_eq!(table.format, "erard-causes/1");
    table.cause
});

/// Returns all causes.
#[must_use]
pub fn causes() -> &'static [Cause] {
    &CAUSES
}
