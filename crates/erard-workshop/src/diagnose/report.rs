//! The answer: judged readings, possible causes, the next measurement, and quantities derived from the weights.

use super::belief::{Belief, Row};
use super::bench::friction_of_swings;
use super::cause::{Cause, causes};
use super::effect::{BALANCE, FEATURES, FRICTION, N, of_known, precision};
use super::entry::{Known, at, entries, usual_range};
use super::geometry::Geometry;
use super::next::next;
use crate::measure::usual::usual;

/// Causes below this probability are not named.
const LEAST: f64 = 0.03;
/// Largest number of causes named.
const MAX_LINES: usize = 6;
/// Least information of a suggested measurement, bits.
const LEAST_BITS: f64 = 0.05;

/// Place of a reading relative to its usual range.
#[derive(Debug, Clone, PartialEq)]
pub enum Standing {
    /// Inside.
    Inside,
    /// Outside by no more than the reading's error.
    Doubtful,
    /// Outside.
    Out,
    /// There is no usual range.
    NoRange,
    /// The usual range is not this key's, with the reason.
    NotJudged(&'static str),
}

/// A reading, or a quantity derived from readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Name in tables.
    pub name: &'static str,
    /// Name at the bench.
    pub label: &'static str,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// Number of decimals shown.
    pub decimals: usize,
    /// Value as read; `None` if the event did not happen.
    pub value: Option<f64>,
    /// Usual range at the key, with infinite values for open ends.
    pub usual: Option<[f64; 2]>,
    /// Position relative to the usual range.
    pub standing: Standing,
}

/// A cause with its probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// The cause.
    pub cause: &'static Cause,
    /// Probability, 0 to 1, under the estimates of `causes.toml`.
    pub probability: f64,
    /// Case: 1 light, 2 plain, 3 heavy.
    pub case: f64,
    /// Readings that it explains: those that it changes by more than their precision, with the estimated change.
    pub explains: Vec<(&'static str, f64)>,
}

/// The most informative measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// The reading to take, as in tables; D and U come together.
    pub name: &'static str,
    /// Name at the bench.
    pub label: &'static str,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// Number of decimals shown.
    pub decimals: usize,
    /// Protocol of the reading.
    pub how: &'static str,
    /// Information expected from it, bits.
    pub bits: f64,
    /// Expected value under the likeliest combinations of causes, the likeliest first.
    pub would_read: Vec<(Vec<&'static Cause>, f64)>,
}

/// The answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Diagnosis {
    /// The key, from 1.
    pub key: usize,
    /// The readings in the order of the sheet, with balance weight, friction weight and leverage derived from them.
    pub lines: Vec<Judged>,
    /// Causes, the likeliest first; empty if no reading is out of its range by more than its error.
    pub causes: Vec<Ranked>,
    /// Probability that none of the table's causes fits.
    pub something_else: f64,
    /// Reading to take next; `None` if no reading would be informative.
    pub next: Option<Suggestion>,
    /// Leverage and inertia.
    pub geometry: Geometry,
}

impl Diagnosis {
    /// Whether some reading is surely out of its range.
    #[must_use]
    pub fn is_work(&self) -> bool {
        self.lines.iter().any(|line| line.standing == Standing::Out)
    }
}

/// Diagnoses a key from its readings.
#[must_use]
pub fn diagnose(known: &Known, key: usize) -> Diagnosis {
    let geometry = Geometry::of(known, key);
    let lines = lines(known, key, &geometry);
    let mut diagnosis = Diagnosis { key, lines, causes: Vec::new(), something_else: 0.0, next: None, geometry };
    if !diagnosis.is_work() {
        return diagnosis;
    }
    let belief = Belief::of(key, rows(known, key, &diagnosis.geometry));
    let of = belief.of_causes();
    let mut order: Vec<usize> = (0..of.len()).filter(|cause| of[*cause] >= LEAST).collect();
    order.sort_by(|a, b| of[*b].total_cmp(&of[*a]));
    if order.is_empty() {
        order = (0..of.len()).max_by(|a, b| of[*a].total_cmp(&of[*b])).into_iter().collect();
    }
    order.truncate(MAX_LINES);
    diagnosis.causes = order
        .into_iter()
        .map(|cause| {
            let (case, change) = belief.case_and_change(cause);
            Ranked { cause: &causes()[cause], probability: of[cause], case, explains: explained(known, &change) }
        })
        .collect();
    diagnosis.something_else = belief.of_other_and_none()[0];
    let features = of_known(known);
    let is_known = |feature: usize| {
        let not_caught = feature == at::CHECK && known.is_not_caught;
        features[feature].is_some() || not_caught || (feature == at::HAMMER_FLANGE && known.at(at::SWINGS).is_some())
    };
    diagnosis.next = next(&belief, is_known).filter(|next| next.bits >= LEAST_BITS).map(|next| {
        let entry = &entries()[next.feature];
        let would_read = next
            .would_read
            .into_iter()
            .take(4)
            .map(|(all, value)| (all.into_iter().map(|cause| &causes()[cause]).collect(), value));
        let (name, label, how) = match next.feature {
            FRICTION => ("down_weight_g", "down-weight and up-weight (friction)", entries()[at::DOWN].how),
            _ => (entry.name, entry.label, entry.how),
        };
        Suggestion {
            name,
            label,
            unit: entry.unit,
            decimals: entry.decimals,
            how,
            bits: next.bits,
            would_read: would_read.collect(),
        }
    });
    diagnosis
}

/// Readings explained by a change.
fn explained(known: &Known, change: &[Option<f64>; N]) -> Vec<(&'static str, f64)> {
    let features = of_known(known);
    let mut of: Vec<(f64, &'static str, f64)> = (0..N)
        .filter(|feature| features[*feature].is_some())
        .filter_map(|feature| {
            let by = change[feature]?;
            (by.abs() > precision(feature)).then_some((by.abs() / precision(feature), FEATURES[feature], by))
        })
        .collect();
    of.sort_by(|a, b| b.0.total_cmp(&a.0));
    of.into_iter().take(4).map(|(_, name, by)| (name, by)).collect()
}

/// The readings as rows of the probability model.
fn rows(known: &Known, key: usize, geometry: &Geometry) -> Vec<Row> {
    let features = of_known(known);
    let mut rows: Vec<Row> = (0..N)
        .filter(|feature| *feature < 2 || entries()[*feature].not_judged(key).is_none())
        .filter_map(|feature| Some(Row::of(feature, features[feature]?)))
        .collect();
    match (known.at(at::DOWN), known.at(at::UP)) {
        (Some(down), None) => {
            rows.push(Row { of: vec![(BALANCE, 1.0), (FRICTION, 1.0)], value: down, error: 0.6 });
        }
        (None, Some(up)) => rows.push(Row { of: vec![(BALANCE, 1.0), (FRICTION, -1.0)], value: up, error: 0.6 }),
        _ => {}
    }
    if known.is_not_caught {
        rows.push(Row::not_caught());
    }
    let is_natural = entries()[at::FRONT].not_judged(key).is_none();
    if let (None, Some(front), true) = (known.at(at::FRONT), geometry.front_weight_g, is_natural) {
        let error = (front.high - front.low) / libm::sqrt(12.0);
        rows.push(Row { of: vec![(at::FRONT, 1.0)], value: 0.5 * (front.low + front.high), error });
    }
    if let (None, Some(swings)) = (known.at(at::HAMMER_FLANGE), known.at(at::SWINGS)) {
        let strike_g = known.at(at::STRIKE).unwrap_or_else(|| {
            let [low, high] = usual("strike_weight_g").map_or([None; 2], |range| range.at(key));
            0.5 * (low.unwrap_or(8.0) + high.unwrap_or(10.0))
        });
        let [low, high] = friction_of_swings(swings, strike_g);
        let error = (high - low) / libm::sqrt(12.0);
        rows.push(Row { of: vec![(at::HAMMER_FLANGE, 1.0)], value: 0.5 * (low + high), error });
    }
    rows
}

fn lines(known: &Known, key: usize, geometry: &Geometry) -> Vec<Judged> {
    let mut lines = Vec::new();
    for (index, entry) in entries().iter().enumerate() {
        let not_there = index == at::CHECK && known.is_not_caught;
        let value = known.at(index);
        if value.is_some() || not_there {
            let usual = entry.range(key);
            let standing = match (entry.not_judged(key), usual, value) {
                (Some(why), ..) => Standing::NotJudged(why),
                (None, None, _) => Standing::NoRange,
                (None, Some(_), None) => Standing::Out,
                (None, Some(range), Some(value)) => stands(value, range, entry.precision, entry.decimals),
            };
            let (name, label, unit, decimals) = (entry.name, entry.label, entry.unit, entry.decimals);
            lines.push(Judged { name, label, unit, decimals, value, usual, standing });
        }
        if index == at::UP {
            for (name, label, value) in [
                ("balance_weight_g", "balance weight (D+U)/2", known.balance_g()),
                ("friction_weight_g", "friction weight (D-U)/2", known.friction_g()),
            ] {
                let usual = usual_range(name, key);
                if let (Some(value), Some(range)) = (value, usual) {
                    let standing = stands(value, range, 1.0, 1);
                    lines.push(Judged { name, label, unit: "g", decimals: 1, value: Some(value), usual, standing });
                }
            }
        }
        if let (at::RATIO, None, Some(ratio)) = (index, value, geometry.ratio) {
            let usual = entry.range(key);
            let middle = 0.5 * (ratio.low + ratio.high);
            let standing = match (entry.not_judged(key), usual) {
                (Some(why), _) => Standing::NotJudged(why),
                (None, Some(range)) => stands(middle, range, 0.5 * (ratio.high - ratio.low), entry.decimals),
                (None, None) => Standing::NoRange,
            };
            let label = "leverage R by the equation of balance";
            lines.push(Judged { name: entry.name, label, unit: "", decimals: 2, value: Some(middle), usual, standing });
        }
    }
    lines
}

/// Place of a reading relative to its range, both as rounded for display.
fn stands(value: f64, [low, high]: [f64; 2], precision: f64, decimals: usize) -> Standing {
    let scale = libm::pow(10.0, decimals as f64);
    let read = |x: f64| if x.is_finite() { (x * scale).round() / scale } else { x };
    let beyond = (read(low) - read(value)).max(read(value) - read(high));
    if beyond <= 0.0 {
        Standing::Inside
    } else if beyond <= precision + 1e-9 {
        Standing::Doubtful
    } else {
        Standing::Out
    }
}
