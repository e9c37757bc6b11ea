//! The table of published measurements, `validation/published.toml`.

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use super::grands::Curves;
use super::{Verdict, values};
use crate::measure::norms::MIDDLE_C;
use crate::measure::usual::usual;
use erard::instrument::from_toml::from_toml;
use erard::instrument::{Certainty, Source};

/// The built-in table.
const BUILTIN: &str = include_str!("../../validation/published.toml");
const FORMAT: &str = "erard-published/2";

/// The table.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Groups of rows by name, in words. Groups are independent of one another; rows of one group are not.
    pub groups: BTreeMap<String, String>,
    /// Sources by name.
    pub sources: BTreeMap<String, Source>,
    /// The rows, those of curves after those that are written one by one.
    pub rows: Vec<PublishedRow>,
}

/// The table as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    format: String,
    groups: BTreeMap<String, String>,
    sources: BTreeMap<String, Source>,
    row: Vec<PublishedRow>,
    #[serde(default)]
    curves: Vec<Curves>,
}

/// Whether a row tests the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PublishedKind {
    /// The instrument was built, weighed or regulated to this number.
    Set,
    /// A prediction of the model.
    Predicted,
}

impl PublishedKind {
    /// Name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            PublishedKind::Set => "set",
            PublishedKind::Predicted => "predicted",
        }
    }
}

/// Published number.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedRow {
    /// Identifier, unique.
    pub name: String,
    /// Name of the quantity, for display.
    pub quantity: String,
    /// Name of its group.
    pub group: String,
    /// Whether the row tests the model.
    pub kind: PublishedKind,
    /// Quantity by which the instrument was set to the number; only for [`PublishedKind::Set`].
    pub set_by: Option<String>,
    /// Simulated value for the comparison, one of [`super::names`]; `None` if the model has none.
    pub measure: Option<String>,
    /// The quantity under a constant force, one of [`super::names`]: shown with the row, not counted.
    pub beside: Option<String>,
    /// Unit of all its numbers; empty for ratios.
    pub unit: String,
    /// Single published number, if it is not a range.
    pub number: Option<f64>,
    /// Published value in words, if neither range nor number gives it.
    pub published: Option<String>,
    /// The range is the usual one of middle C ([`crate::measure::usual`]).
    #[serde(default)]
    pub usual: bool,
    /// Lower end of the range that counts as met.
    pub at_least: Option<f64>,
    /// Upper end of the range that counts as met.
    pub at_most: Option<f64>,
    /// Name of its source.
    pub source: String,
    /// Certainty.
    pub certainty: Certainty,
    /// Method of the simulation, and any part of the range that is our own.
    pub how: String,
    /// Likely reason of a miss.
    pub if_missed: Option<String>,
}

/// Reason why a table cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PublishedError {
    /// The file is not a table of this format.
    #[error("{0}")]
    Syntax(String),
    /// A row contradicts itself or the rest of the table.
    #[error("row `{row}`: {what}")]
    Row {
        /// Name of the row.
        row: String,
        /// Error and expected text.
        what: String,
    },
}

impl Published {
    /// Returns the built-in table.
    ///
    /// # Panics
    /// Never: a test reads it.
    #[must_use]
    pub fn builtin() -> Self {
        Self::parse(BUILTIN).expect("the built-in table reads")
    }

    /// Reads a table.
    ///
    /// # Errors
    /// See [`PublishedError`].
    pub fn parse(text: &str) -> Result<Self, PublishedError> {
        let written: Written = from_toml(text).map_err(|error| PublishedError::Syntax(error.in_line(text)))?;
        if written.format != FORMAT {
            return Err(PublishedError::Syntax(format!("`format` is `{}`; expected `{FORMAT}`", written.format)));
        }
        let Written { groups, sources, row: mut rows, curves, .. } = written;
        for curves in &curves {
            rows.extend(curves.rows().map_err(|(row, what)| PublishedError::Row { row, what })?);
        }
        let mut table = Published { groups, sources, rows };
        for row in table.rows.iter_mut().filter(|row| row.usual) {
            row.take_usual()?;
        }
        for (index, row) in table.rows.iter().enumerate() {
            let wrong = |what: String| Err(PublishedError::Row { row: row.name.clone(), what });
            if table.rows[..index].iter().any(|other| other.name == row.name) {
                return wrong("the table already has this name; expected another".into());
            }
            if !table.groups.contains_key(&row.group) {
                return wrong(format!("`group` is `{}`; expected one of `groups`", row.group));
            }
            if (row.kind == PublishedKind::Set) != row.set_by.is_some() {
                return wrong(format!(
                    "`kind` is `{}`; expected `set_by` of rows that are set, and of no other",
                    row.kind.name()
                ));
            }
            if !table.sources.contains_key(&row.source) {
                return wrong(format!("`source` is `{}`; expected one of `sources`", row.source));
            }
            for (key, name) in [("measure", &row.measure), ("beside", &row.beside)] {
                if let Some(name) = name
                    && !values::names().any(|known| known == name)
                {
                    let known: Vec<&str> = values::names().collect();
                    return wrong(format!("`{key}` is `{name}`; expected one of {}", known.join(", ")));
                }
            }
            let ordered = row.at_least.is_none_or(|low| row.at_most.is_none_or(|high| low < high));
            let finite = [row.at_least, row.at_most, row.number].into_iter().flatten().all(f64::is_finite);
            if !ordered || !finite {
                return wrong("expected finite numbers, `at_least` below `at_most`".into());
            }
            if row.measure.is_some() && row.is_open() && row.published.is_none() {
                return wrong("expected `at_least` or `at_most`, or `published` to say that there is none".into());
            }
        }
        Ok(table)
    }
}

impl PublishedRow {
    /// Takes ranges from the table of usual ranges.
    fn take_usual(&mut self) -> Result<(), PublishedError> {
        let wrong = |what: &str| Err(PublishedError::Row { row: self.name.clone(), what: what.into() });
        if !self.is_open() {
            return wrong(
                "`usual` takes its range from the table of usual ones; expected no `at_least` and no `at_most`",
            );
        }
        let Some(range) = self.measure.as_deref().and_then(usual) else {
            return wrong("`usual` expects a `measure` that has a usual range");
        };
        [self.at_least, self.at_most] = range.at(MIDDLE_C);
        Ok(())
    }

    /// Whether no range was published.
    #[must_use]
    pub(crate) fn is_open(&self) -> bool {
        self.at_least.is_none() && self.at_most.is_none()
    }

    /// Returns the verdict on a simulated value.
    #[must_use]
    pub fn judge(&self, simulated: Option<f64>) -> Verdict {
        let Some(simulated) = simulated.filter(|x| x.is_finite()) else { return Verdict::Absent };
        match (self.at_least, self.at_most) {
            (None, None) => Verdict::Open { simulated },
            (Some(low), _) if simulated < low => Verdict::Missed { simulated, by: simulated - low },
            (_, Some(high)) if simulated > high => Verdict::Missed { simulated, by: simulated - high },
            _ => Verdict::Met { simulated },
        }
    }

    /// Whether a band of values, from low to high, is too wide to decide whether the row is met: wider than a two-sided
    /// range that it overlaps, or across the end of a one-sided one. A band inside the range, or outside it, decides.
    #[must_use]
    pub fn is_undecided(&self, [low, high]: [f64; 2]) -> bool {
        match (self.at_least, self.at_most) {
            (Some(least), Some(most)) => high - low > most - least && low <= most && high >= least,
            (Some(end), None) | (None, Some(end)) => low < end && end < high,
            (None, None) => false,
        }
    }

    /// Distance of a simulated value from the middle of the range over half its width: 1 at either end. `None` without
    /// a value or without two ends.
    #[must_use]
    pub fn z(&self, verdict: &Verdict) -> Option<f64> {
        let (Verdict::Met { simulated } | Verdict::Missed { simulated, .. }) = verdict else { return None };
        let [low, high] = [self.at_least?, self.at_most?];
        Some((2.0 * simulated - low - high) / (high - low))
    }

    /// Published value: words, number or range.
    #[must_use]
    pub fn range(&self) -> String {
        let number = |x: f64| format!("{x}");
        match (&self.published, self.number, self.at_least, self.at_most) {
            (Some(words), ..) => words.clone(),
            (None, Some(x), ..) => number(x),
            (None, None, Some(low), Some(high)) => format!("{}-{}", number(low), number(high)),
            (None, None, Some(low), None) => format!("at least {}", number(low)),
            (None, None, None, Some(high)) => format!("at most {}", number(high)),
            (None, None, None, None) => String::new(),
        }
    }
}
