//! Usual ranges of the technician's numbers, `validation/usual.toml`: one table for the sheet, its flags and the rows
//! of `validate`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use erard::instrument::from_toml::from_toml;
use erard::keyboard::is_sharp;
use serde::Deserialize;

/// The built-in table.
const BUILTIN: &str = include_str!("../../validation/usual.toml");
const FORMAT: &str = "erard-usual/1";
/// Keys of a piano.
const KEYS: usize = 88;

static TABLE: LazyLock<BTreeMap<String, UsualRange>> =
    LazyLock::new(|| parse(BUILTIN).expect("the built-in table of usual ranges reads"));

/// Usual range, with its source.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UsualRange {
    #[serde(rename = "at_least")]
    low: Option<Limit>,
    #[serde(rename = "at_most")]
    high: Option<Limit>,
    /// End below which it is a fault, if that is not `at_least`.
    fault_below: Option<Limit>,
    /// End above which it is a fault, if that is not `at_most`.
    fault_above: Option<Limit>,
    /// Ends that are no fault.
    #[serde(default)]
    no_fault: Vec<End>,
    /// Source, with any derivation from it.
    pub source: String,
}

/// A side of a usual range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum End {
    Low,
    High,
}

/// One end of a usual range.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
enum Limit {
    /// One bound for all keys.
    All(f64),
    /// At some keys, ascending, linear between them and constant beyond the first and the last.
    ByKey(Vec<(usize, f64)>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    format: String,
    usual: BTreeMap<String, UsualRange>,
}

/// Usual range of a line of the sheet, by its key; `None` without one.
#[must_use]
pub(crate) fn usual(key: &str) -> Option<&'static UsualRange> {
    TABLE.get(key)
}

/// Ratio of a sharp over that of the naturals beside it: 1.07 to 1.10 in published tables.
const SHARP: f64 = 1.085;

/// Factor of the usual ratio at a key: a sharp is shorter than a natural.
#[must_use]
pub(crate) fn ratio_factor(key: usize) -> f64 {
    if is_sharp(key) { SHARP } else { 1.0 }
}

/// Ratios of a key beyond which it is a fault, from low to high.
#[must_use]
pub(crate) fn ratio_range(key: usize) -> [f64; 2] {
    let [low, high] = usual("strike_weight_ratio_weights").map_or([None; 2], |range| range.faults(key));
    [low.unwrap_or(0.0), high.unwrap_or(f64::INFINITY)].map(|end| end * ratio_factor(key))
}

/// All keys with a usual range.
#[cfg(test)]
pub(super) fn keys() -> impl Iterator<Item = &'static str> {
    TABLE.keys().map(String::as_str)
}

/// Checks a table of usual ranges and returns the number of sheet lines in it.
///
/// # Errors
/// The error, its place and what is expected.
pub fn check(text: &str) -> Result<usize, String> {
    parse(text).map(|table| table.len())
}

fn parse(text: &str) -> Result<BTreeMap<String, UsualRange>, String> {
    let table: Table = from_toml(text).map_err(|error| error.in_line(text))?;
    if table.format != FORMAT {
        return Err(format!("`format` is `{}`; expected `{FORMAT}`", table.format));
    }
    for (key, range) in &table.usual {
        let fault = |what: &str| Err(format!("`usual.{key}`: {what}"));
        if range.low.is_none() && range.high.is_none() {
            return fault("expected `at_least` or `at_most`");
        }
        let limits = [&range.low, &range.high, &range.fault_below, &range.fault_above];
        if limits.into_iter().flatten().any(|limit| !limit.is_sound()) {
            return fault("expected a finite number, or pairs of a key from 1 to 88, ascending, and a finite number");
        }
        if (1..=KEYS).any(|at| matches!(range.at(at), [Some(low), Some(high)] if low >= high)) {
            return fault("expected `at_least` below `at_most`");
        }
        let is_narrower = |at: usize| {
            let ([low, high], [fault_low, fault_high]) = (range.at(at), range.faults(at));
            low.zip(fault_low).is_some_and(|(low, fault)| fault > low)
                || high.zip(fault_high).is_some_and(|(high, fault)| fault < high)
        };
        if (1..=KEYS).any(is_narrower) {
            return fault("expected `fault_below` and `fault_above` outside the range");
        }
    }
    Ok(table.usual)
}

impl UsualRange {
    /// Range at a key, 1 to 88, from low to high; either end may be open.
    #[must_use]
    pub(crate) fn at(&self, key: usize) -> [Option<f64>; 2] {
        [&self.low, &self.high].map(|limit| limit.as_ref().and_then(|limit| limit.at(key)))
    }

    /// Ends at a key beyond which it is a fault, from low to high; an end that is no fault is open.
    #[must_use]
    pub(crate) fn faults(&self, key: usize) -> [Option<f64>; 2] {
        let of = |own: &Option<Limit>, usual: &Option<Limit>, end: End| {
            let limit = own.as_ref().or(usual.as_ref()).filter(|_| !self.no_fault.contains(&end));
            limit.and_then(|limit| limit.at(key))
        };
        [of(&self.fault_below, &self.low, End::Low), of(&self.fault_above, &self.high, End::High)]
    }

    /// Whether the range differs from bass to treble.
    #[must_use]
    pub(crate) fn depends_on_the_key(&self) -> bool {
        [&self.low, &self.high].into_iter().flatten().any(|limit| matches!(limit, Limit::ByKey(_)))
    }
}

impl Limit {
    fn at(&self, key: usize) -> Option<f64> {
        let points = match self {
            Limit::All(value) => return Some(*value),
            Limit::ByKey(points) => points,
        };
        let after = points.partition_point(|(at, _)| *at <= key);
        let &(left, from) = points.get(after.saturating_sub(1))?;
        Some(match points.get(after) {
            Some(&(right, to)) if key > left => from + (to - from) * (key - left) as f64 / (right - left) as f64,
            _ => from,
        })
    }

    fn is_sound(&self) -> bool {
        match self {
            Limit::All(value) => value.is_finite(),
            Limit::ByKey(points) => {
                let fits = |(key, value): &(usize, f64)| (1..=KEYS).contains(key) && value.is_finite();
                !points.is_empty() && points.iter().all(fits) && points.windows(2).all(|pair| pair[0].0 < pair[1].0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::norms::lines;
    use crate::measure::range::HARDLY_HEARD_M_PER_S;

    /// Every range belongs to a line of the sheet; numbers that are both in code and in the table agree.
    #[test]
    fn ranges_are_those_of_lines() {
        for key in keys() {
            assert!(lines().any(|line| line.key == key), "{key}");
        }
        assert_eq!(usual("double_strike_m_per_s").unwrap().at(40), [None, Some(HARDLY_HEARD_M_PER_S)]);
    }

    /// Errors of a damaged table state their place.
    #[test]
    fn damaged_tables_are_refused() {
        let told = |body: &str| parse(&format!("format = \"{FORMAT}\"\n[usual.dip_mm]\nsource = \"s\"\n{body}"));
        assert!(told("at_least = 9.5\nat_most = [[40, 11], [88, 12]]").is_ok());
        for (body, what) in [
            ("", "expected `at_least` or `at_most`"),
            ("at_most = 11\nfault_above = 10", "outside the range"),
            ("at_least = nan", "finite number"),
            ("at_least = []", "finite number"),
            ("at_least = [[40, 1], [40, 2]]", "ascending"),
            ("at_least = [[89, 1]]", "1 to 88"),
            ("at_least = 2\nat_most = [[1, 3], [88, 1]]", "below `at_most`"),
            ("low = 2", "unknown field"),
        ] {
            let error = told(body).unwrap_err();
            assert!(error.contains(what), "{body}: {error}");
        }
        assert!(parse("format = \"x\"\n[usual]").unwrap_err().contains(FORMAT));
    }
}
