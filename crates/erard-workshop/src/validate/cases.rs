//! Published pianos, `validation/cases.toml`: their readings, diagnosed, against what technicians concluded or found.

use std::collections::BTreeMap;

use erard::instrument::from_toml::from_toml;
use serde::Deserialize;

use crate::diagnose::{Diagnosis, Known, diagnose, readings};

/// The built-in table.
const BUILTIN: &str = include_str!("../../validation/cases.toml");
const FORMAT: &str = "erard-cases/1";
/// First cause of a key without work.
pub const NOTHING: &str = "nothing";
/// First cause of a key whose readings do not decide.
const UNDECIDED: &str = "undecided";
/// Any work, in a list of harmful causes.
const ANY: &str = "any";

/// Use of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CaseUse {
    /// It was looked at while the ranking was changed.
    Choose,
    /// It is run when the ranking is finished.
    Judge,
}

impl CaseUse {
    /// Name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        if self == CaseUse::Choose { "choose" } else { "judge" }
    }
}

/// Basis of what a case calls right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// The state after the work is known.
    Result,
    /// An expert's word.
    Conclusion,
    /// Numbers at which somebody aims.
    Standard,
    /// A cause that this program planted.
    Planted,
}

impl Basis {
    /// Name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Basis::Result => "result",
            Basis::Conclusion => "conclusion",
            Basis::Standard => "standard",
            Basis::Planted => "planted",
        }
    }
}

/// A published piano.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Identifier, unique.
    pub name: String,
    /// The piano, and any complaint.
    pub piano: String,
    /// Author, place and date.
    pub source: String,
    /// How much of the source was read.
    pub read: String,
    /// Whether the case chooses or judges.
    #[serde(rename = "use")]
    pub used: CaseUse,
    /// Basis of its conclusion.
    pub basis: Basis,
    /// Conclusion, or result of the work.
    pub concluded: String,
    /// Causes that may be named first: keys of causes, `nothing`, `undecided`.
    pub acceptable: Vec<String>,
    /// Causes that must be named as well.
    #[serde(default)]
    pub also: Vec<String>,
    /// Causes whose cure would be wrong or harmful; `any` for every cause.
    pub harmful: Vec<String>,
    /// How the readings were entered, where the source has no single number.
    pub note: Option<String>,
    /// Its keys.
    #[serde(rename = "key")]
    pub keys: Vec<CaseKey>,
}

/// A key of a case.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseKey {
    /// The key, from 1.
    pub key: usize,
    /// Readings by name, numbers or words.
    pub readings: BTreeMap<String, Reading>,
}

/// A reading, as typed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Reading {
    /// A number in the unit of the reading's name.
    Number(f64),
    /// A word.
    Word(String),
}

impl std::fmt::Display for Reading {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Reading::Number(number) => number.fmt(f),
            Reading::Word(word) => word.fmt(f),
        }
    }
}

/// Verdict on a diagnosis of a case's key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CaseVerdict {
    /// Harmful work is named.
    Harmful,
    /// Another cause is named first, or one that must be named is not.
    Missed,
    /// The first cause is acceptable, and no harmful work is named.
    Met,
}

impl CaseVerdict {
    /// Name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            CaseVerdict::Harmful => "harmful",
            CaseVerdict::Missed => "missed",
            CaseVerdict::Met => "met",
        }
    }
}

/// Diagnosis of a case's key.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseResult {
    /// The key, from 1.
    pub key: usize,
    /// What is named first.
    pub first: String,
    /// Probability of that cause; `None` without one.
    pub probability: Option<f64>,
    /// All causes whose work is named, in order.
    pub named: Vec<String>,
    /// Those of them that are harmful.
    pub harmful: Vec<String>,
    /// Verdict.
    pub verdict: CaseVerdict,
}

/// The table of cases.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cases {
    format: String,
    /// The cases, in the order of the file.
    #[serde(rename = "case")]
    pub cases: Vec<Case>,
}

impl Cases {
    /// Returns the built-in table.
    ///
    /// # Panics
    /// Never: a test reads it.
    #[must_use]
    pub fn builtin() -> Self {
        Self::parse(BUILTIN).expect("the built-in cases read")
    }

    /// Reads a table.
    ///
    /// # Errors
    /// The error, its place and what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let table: Cases = from_toml(text).map_err(|error| error.in_line(text))?;
        if table.format != FORMAT {
            return Err(format!("`format` is `{}`; expected `{FORMAT}`", table.format));
        }
        for (at, case) in table.cases.iter().enumerate() {
            let fault = |what: String| Err(format!("case `{}`: {what}", case.name));
            if table.cases[..at].iter().any(|other| other.name == case.name) {
                return fault("the name is taken; expected another".to_owned());
            }
            if case.acceptable.is_empty() || case.keys.is_empty() {
                return fault("expected an acceptable first cause, and a key".to_owned());
            }
            if let Some(both) = case.acceptable.iter().chain(&case.also).find(|one| case.harmful.contains(one)) {
                return fault(format!("`{both}` is acceptable and harmful; expected one of them"));
            }
            for key in &case.keys {
                if let Err(error) = key.known() {
                    return fault(format!("key {}: {error}", key.key));
                }
            }
        }
        Ok(table)
    }
}

impl CaseKey {
    /// Returns the readings as the diagnosis takes them.
    ///
    /// # Errors
    /// The first error, with what is expected.
    pub fn known(&self) -> Result<Known, String> {
        if !(1..=88).contains(&self.key) {
            return Err("expected a key from 1 to 88".to_owned());
        }
        let mut known = Known::default();
        for (name, value) in &self.readings {
            let entry = readings().find(|entry| entry.name == name);
            let entry = entry.ok_or_else(|| format!("unknown reading `{name}`"))?;
            let wrong = |expected| format!("{name} = {value}: expected {expected}");
            known.enter(entry, &value.to_string()).map_err(wrong)?;
        }
        known.settle(self.key).and_then(|()| known.check()).map_err(|error| error.to_string())?;
        if known.is_empty() { Err("expected a reading".to_owned()) } else { Ok(known) }
    }
}

impl Case {
    /// Diagnoses the keys of the case.
    ///
    /// # Errors
    /// An impossible reading; not for a table that was read.
    pub fn run(&self) -> Result<Vec<CaseResult>, String> {
        self.keys.iter().map(|key| Ok(self.judge(key.key, &diagnose(&key.known()?, key.key)))).collect()
    }

    /// Judges a diagnosis of one of its keys.
    fn judge(&self, key: usize, found: &Diagnosis) -> CaseResult {
        let look = found.looks.first().filter(|_| found.is_look).map(|look| look.key.clone());
        let causes = found.causes.iter().map(|ranked| ranked.cause.key.clone());
        let named: Vec<String> = look.into_iter().chain(causes).collect();
        let none = if found.is_work() { UNDECIDED } else { NOTHING };
        let first = named.first().cloned().unwrap_or_else(|| none.to_owned());
        let is_harmful = |cause: &&String| self.harmful.iter().any(|one| one == ANY || one == *cause);
        let harmful: Vec<String> = named.iter().filter(is_harmful).cloned().collect();
        let is_met = self.acceptable.contains(&first) && self.also.iter().all(|one| named.contains(one));
        let verdict = match (harmful.is_empty(), is_met) {
            (false, _) => CaseVerdict::Harmful,
            (true, false) => CaseVerdict::Missed,
            (true, true) => CaseVerdict::Met,
        };
        let probability = found.causes.first().map(|ranked| ranked.probability).filter(|_| !found.is_look);
        CaseResult { key, first, probability, named, harmful, verdict }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table reads; about half of its cases judge; a case that was planted or whose result is known is no opinion.
    #[test]
    fn the_table() {
        let cases = Cases::builtin().cases;
        let judging = cases.iter().filter(|case| case.used == CaseUse::Judge).count();
        assert!(cases.len() >= 25 && 3 * judging >= cases.len(), "{judging} of {}", cases.len());
        let of = |basis: Basis| cases.iter().filter(|case| case.basis == basis).count();
        assert!(of(Basis::Result) >= 5 && of(Basis::Planted) >= 5, "{} {}", of(Basis::Result), of(Basis::Planted));
    }

    /// Errors name the case and what is expected.
    #[test]
    fn damaged_tables_are_refused() {
        let with = |acceptable: &str, key: &str| {
            format!(
                "format = \"{FORMAT}\"\n[[case]]\nname = \"a\"\npiano = \"p\"\nsource = \"s\"\nread = \"whole\"\nuse = \"choose\"\n\
                 basis = \"result\"\nconcluded = \"c\"\nacceptable = [{acceptable}]\nharmful = [\"dip_deep\"]\nkey = [{key}]\n"
            )
        };
        let good = "{ key = 40, readings = { down_weight_g = 50 } }";
        assert!(Cases::parse(&with("\"nothing\"", good)).is_ok());
        for (acceptable, key, told) in [
            ("", good, "case `a`: expected an acceptable first cause"),
            ("\"dip_deep\"", good, "`dip_deep` is acceptable and harmful"),
            ("\"nothing\"", "{ key = 89, readings = { drop_mm = 1 } }", "key 89: expected a key from 1 to 88"),
            ("\"nothing\"", "{ key = 40, readings = { colour = 1 } }", "unknown reading `colour`"),
            ("\"nothing\"", "{ key = 40, readings = { drop_mm = -1 } }", "drop_mm = -1: expected a number from 0"),
            ("\"nothing\"", "{ key = 40, readings = {} }", "expected a reading"),
        ] {
            let error = Cases::parse(&with(acceptable, key)).unwrap_err();
            assert!(error.contains(told), "{acceptable} {key}: {error}");
        }
    }

    /// Harmful work counts wherever it is named, and what must be named too is asked for.
    #[test]
    fn verdicts() {
        let case = |acceptable: &[&str], also: &[&str], harmful: &[&str]| {
            let list = |of: &[&str]| of.iter().map(|one| (*one).to_owned()).collect::<Vec<_>>();
            let mut case = Cases::builtin().cases.swap_remove(0);
            (case.acceptable, case.also, case.harmful) = (list(acceptable), list(also), list(harmful));
            case
        };
        let mut known = Known::default();
        known.set("let_off_mm", Some(4.0));
        let wide = diagnose(&known, 40);
        let verdict = |case: Case| case.judge(40, &wide).verdict;
        assert_eq!(wide.causes[0].cause.key, "let_off_wide");
        assert_eq!(verdict(case(&["let_off_wide"], &[], &[])), CaseVerdict::Met);
        assert_eq!(verdict(case(&["let_off_wide"], &["leads_few"], &[])), CaseVerdict::Missed);
        assert_eq!(verdict(case(&["let_off_wide"], &[], &["any"])), CaseVerdict::Harmful);
        assert_eq!(verdict(case(&["dip_deep"], &[], &[])), CaseVerdict::Missed);
        let nothing = diagnose(&Known::default(), 40);
        assert_eq!(case(&["nothing"], &[], &["any"]).judge(40, &nothing).verdict, CaseVerdict::Met);
    }
}
