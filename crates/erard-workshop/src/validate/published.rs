//! The table of published measurements, `validation/published.toml`.

use std::collections::BTreeMap;

use serde::Deserialize;
use thiserror::Error;

use super::grands::{Case, LEVELS_M_PER_S, Timing, cases, grands, published_ms};
use super::{Verdict, values};
use crate::measure::norms::MIDDLE_C;
use crate::measure::usual::usual;
use erard::instrument::from_toml::from_toml;
use erard::instrument::{Certainty, Source};
use erard::stroke::Touch;

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

/// Rows that are made of curves: one for every touch and level.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Curves {
    /// Beginning of the rows' names; touch and level follow.
    name: String,
    /// What is compared, for display.
    quantity: String,
    group: String,
    kind: PublishedKind,
    set_by: Option<String>,
    timing: Timing,
    /// Hammer speeds of pressed and of struck rows, m/s.
    pressed_m_per_s: Vec<f64>,
    struck_m_per_s: Vec<f64>,
    /// Grands whose curves make the range; with one, the others say how wide it is.
    grands: Vec<String>,
    /// What the source does not resolve: a share of the value, and ms.
    #[serde(default)]
    unresolved_share: f64,
    #[serde(default)]
    unresolved_ms: f64,
    source: String,
    certainty: Certainty,
    how: String,
    if_missed: Option<String>,
}

impl Curves {
    /// The rows.
    ///
    /// # Errors
    /// Name of the rows and what is wrong.
    fn rows(&self) -> Result<Vec<PublishedRow>, (String, String)> {
        let wrong = |what: String| (self.name.clone(), what);
        let known = grands();
        if let Some(other) = self.grands.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(wrong(format!("`grands` has `{other}`; expected of {}", known.join(", "))));
        }
        if self.grands.is_empty() {
            return Err(wrong(format!("`grands` is empty; expected of {}", known.join(", "))));
        }
        let of = |touch: Touch, speeds: &[f64]| {
            speeds.iter().map(move |&speed_m_per_s| Case { touch, speed_m_per_s }).collect::<Vec<_>>()
        };
        let asked = [of(Touch::Pressed, &self.pressed_m_per_s), of(Touch::Struck, &self.struck_m_per_s)].concat();
        asked.into_iter().map(|case| self.row(case).map_err(wrong)).collect()
    }

    fn row(&self, case: Case) -> Result<PublishedRow, String> {
        if !cases().any(|known| known == case) {
            let levels: Vec<String> = LEVELS_M_PER_S.iter().map(f64::to_string).collect();
            return Err(format!(
                "{} at {} m/s; expected {} m/s, struck from {} on",
                case.touch.name(),
                case.speed_m_per_s,
                levels.join(", "),
                levels[1]
            ));
        }
        let at = |grand: &str| published_ms(grand, case.touch, self.timing, case.speed_m_per_s).unwrap_or(f64::NAN);
        let own: Vec<f64> = self.grands.iter().map(|grand| at(grand)).collect();
        let low = own.iter().copied().fold(f64::INFINITY, f64::min);
        let high = own.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // Around one grand the range reaches as far as the others lie from it: a row that a real grand misses is no
        // test.
        let apart = match own[..] {
            [one] => grands().into_iter().map(|other| (at(other) - one).abs()).fold(0.0, f64::max),
            _ => 0.0,
        };
        let beyond = |end: f64| apart + self.unresolved_share * end.abs() + self.unresolved_ms;
        let hundredths = |ms: f64| (100.0 * ms).round() / 100.0;
        let values: Vec<String> = own.iter().map(|ms| format!("{ms:.1}")).collect();
        Ok(PublishedRow {
            name: format!("{}_{}_{}", self.name, case.touch.name(), case.level()),
            quantity: format!("{}, {}, {} m/s", self.quantity, case.touch.name(), case.speed_m_per_s),
            group: self.group.clone(),
            kind: self.kind,
            set_by: self.set_by.clone(),
            measure: Some(case.measure(self.timing)),
            beside: None,
            unit: "ms".into(),
            number: None,
            published: Some(format!("{} ({})", values.join(", "), self.grands.join(", "))),
            usual: false,
            at_least: Some(hundredths(low - beyond(low))),
            at_most: Some(hundredths(high + beyond(high))),
            source: self.source.clone(),
            certainty: self.certainty,
            how: self.how.clone(),
            if_missed: self.if_missed.clone(),
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Every grand of the source lies in the range of every row that is made of it, and of the row around one other.
    #[test]
    fn no_real_grand_misses_a_row() {
        let of = |grands: &[&str], unresolved_share: f64| Curves {
            name: "x".into(),
            quantity: "x".into(),
            group: "x".into(),
            kind: PublishedKind::Predicted,
            set_by: None,
            timing: Timing::Travel,
            pressed_m_per_s: LEVELS_M_PER_S.to_vec(),
            struck_m_per_s: LEVELS_M_PER_S[1..].to_vec(),
            grands: grands.iter().map(|&grand| grand.into()).collect(),
            unresolved_share,
            unresolved_ms: 0.0,
            source: "x".into(),
            certainty: Certainty::Read,
            how: "x".into(),
            if_missed: None,
        };
        for curves in [of(&grands(), 0.0), of(&["Boesendorfer SE290"], 0.0)] {
            let rows = curves.rows().unwrap();
            assert_eq!(rows.len(), 13);
            for (row, case) in rows.iter().zip(cases()) {
                for grand in grands() {
                    let ms = published_ms(grand, case.touch, Timing::Travel, case.speed_m_per_s).unwrap();
                    let range = row.at_least.unwrap() - 0.01..=row.at_most.unwrap() + 0.01;
                    assert!(range.contains(&ms), "{}: {ms} of {grand} in {range:?}", row.name);
                }
            }
        }
        let two = of(&["Steinway C", "Yamaha Disklavier"], 0.1).rows().unwrap();
        // 98.57 x 2^-0.7147 and 89.41 x 2^-0.5959, a tenth beyond.
        assert_eq!((two[4].at_least, two[4].at_most), (Some(53.24), Some(66.07)));
        assert!(of(&["Bechstein"], 0.0).rows().unwrap_err().1.contains("`Bechstein`"));
        let other = Curves { pressed_m_per_s: vec![0.6], ..of(&["Steinway C"], 0.0) };
        assert!(other.rows().unwrap_err().1.contains("pressed at 0.6 m/s; expected 0.5, 0.7"));
    }
}
