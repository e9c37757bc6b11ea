//! Table of causes, `causes.toml`.

use std::sync::LazyLock;

use erard::instrument::from_toml::from_toml;
use serde::Deserialize;

use crate::regulate::{KnownScrew, known_screw};

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
    /// Place in the trade's order of work, from 1 for friction to leads.
    pub order: u32,
    /// Change in a simulated action.
    pub(super) change: Change,
    /// Size of the change in a light, a plain and a heavy case.
    pub(super) amounts: [f64; 3],
    /// Largest change that is met, if it is beyond the heavy case.
    pub(super) beyond: Option<Beyond>,
    /// Quick test that distinguishes it from the other causes.
    pub test: String,
    /// Cure.
    pub cure: String,
    /// Source in the literature.
    pub source: String,
}

impl Cause {
    /// Reading that is this cause, of springs, leverage, hammers and leads: nobody is sent to work on what was read and
    /// is in its range. Other screws are turned within their ranges to bring another reading in, and too little lead
    /// has no such end: `None`.
    pub(super) fn own_line(&self) -> Option<&'static str> {
        match self.key.as_str() {
            "spring_weak" | "spring_strong" => Some("repetition_spring_m_per_s"),
            "hammer_heavy" | "hammer_light" => Some("strike_weight_g"),
            "ratio_high" | "ratio_low" => Some("strike_weight_ratio"),
            "leads_many" => Some("front_weight_g"),
            _ => None,
        }
    }

    /// Returns the cause whose screw is set again after the largest change, and its amount.
    pub(super) fn set_again(&self) -> Option<(&'static Cause, f64)> {
        let again = self.beyond.as_ref()?.set_again.as_ref()?;
        Some((causes().iter().find(|cause| cause.key == again.cause)?, again.amount))
    }
}

/// Changes larger than the heavy case of the table.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Beyond {
    /// Reading that the cause sets.
    pub line: String,
    /// Largest change of it that is met, in its unit.
    pub to: f64,
    /// Amount of the cause that makes it.
    pub amount: f64,
    /// Screw that is then set again, because nobody leaves it where it is.
    pub set_again: Option<SetAgain>,
}

/// A screw that is set again after a large change.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SetAgain {
    /// Cause that turns it.
    pub cause: String,
    /// Amount of that cause.
    pub amount: f64,
}

/// Cause without a model: a sentence with a test of ten seconds.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// Name in JSON.
    pub key: String,
    /// Name at the bench.
    pub name: String,
    /// Readings that send you there when they are out of their ranges.
    pub(super) if_out: Vec<String>,
    /// Side of the reading that is the cause's own sign.
    pub(super) own_sign: Option<Side>,
    /// Test of ten seconds.
    pub test: String,
    /// Cure.
    pub cure: String,
    /// Source.
    pub source: String,
}

/// Side of a usual range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Side {
    /// Below it.
    Low,
    /// Above it.
    High,
}

/// What a cause changes in a simulated action.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub(super) enum Change {
    /// Friction of a pivot, by a factor.
    Friction(Pivot),
    /// Friction coefficient at the knuckle, by an increase.
    Knuckle,
    /// Setting of a screw along its reference, m; of a spring as a share of its torque.
    Screw(&'static KnownScrew),
    /// Mass of the hammer, g.
    Hammer,
    /// Front weight of the key, g.
    FrontWeight,
    /// Place of the capstan line, mm.
    Capstan,
}

/// A part on a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pivot {
    Key,
    Hammer,
    Whippen,
}

impl TryFrom<String> for Change {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Ok(match text.as_str() {
            "friction:key" => Change::Friction(Pivot::Key),
            "friction:hammer" => Change::Friction(Pivot::Hammer),
            "friction:whippen" => Change::Friction(Pivot::Whippen),
            "knuckle" => Change::Knuckle,
            "hammer" => Change::Hammer,
            "front_weight" => Change::FrontWeight,
            "capstan" => Change::Capstan,
            other => {
                let screw = other.strip_prefix("screw:").and_then(known_screw);
                Change::Screw(screw.ok_or_else(|| format!("unknown change `{other}`"))?)
            }
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    format: String,
    cause: Vec<Cause>,
    look: Vec<Look>,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let table: Table = from_toml(include_str!("causes.toml")).expect("the built-in causes read");
    assert_eq!(table.format, "erard-causes/1");
    table
});

/// Returns all causes.
#[must_use]
pub fn causes() -> &'static [Cause] {
    &TABLE.cause
}

/// Returns all causes without a model.
#[must_use]
pub fn looks() -> &'static [Look] {
    &TABLE.look
}
