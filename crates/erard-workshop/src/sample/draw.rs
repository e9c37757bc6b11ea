//! Numbers of a sample: each with a spread deviates from the file's.

use super::random::deviation;
use erard::instrument::{CitedNumber, FileNumber, InstrumentFile, Spread, with_numbers};
use erard::parameter::ten_digits;

/// Share of its thickness at which a felt's force is kept when its exponent deviates.
const SIZED_AT: f64 = 0.05;
/// Compression at which that force is kept if the file has no thickness, m.
const SIZED_AT_M: f64 = 1e-4;

/// Returns the text of a file with its numbers drawn, not yet adjusted on the bench; `None` if no number has a spread.
/// All numbers that are `together` get the same deviation.
#[must_use]
pub fn drawn(file: &InstrumentFile, text: &str, sample: u32, attempt: u32) -> Option<String> {
    let numbers = &file.provenance.numbers;
    let mut changes: Vec<(&str, usize, f64)> = Vec::new();
    for number in numbers {
        let Some(citation) = &number.citation else { continue };
        let Some(spread) = citation.spread.filter(|spread| !is_exact(*spread)) else { continue };
        let name = citation.together.as_deref().unwrap_or(&number.key);
        for (component, value) in number.values.iter().enumerate() {
            let by = deviation(sample, attempt, name, component);
            let new = match spread {
                Spread::PlusMinus(most) => value + by * most,
                Spread::Factor(most) => value * libm::pow(most, by),
            };
            changes.push((&number.key, component, new));
        }
    }
    if changes.is_empty() {
        return None;
    }
    keep_the_sizing(numbers, &mut changes);
    let written: Vec<(&str, usize, f64)> =
        changes.iter().map(|(key, which, value)| (*key, *which, ten_digits(*value))).collect();
    with_numbers(text, &written)
}

fn is_exact(spread: Spread) -> bool {
    match spread {
        Spread::PlusMinus(by) => by == 0.0,
        Spread::Factor(by) => by == 1.0,
    }
}

/// F = k g^r: with another r, k changes so that the force at that compression stays.
fn keep_the_sizing<'a>(numbers: &'a [CitedNumber], changes: &mut Vec<(&'a str, usize, f64)>) {
    let value =
        |key: &str| numbers.iter().find(|number| number.key == key).and_then(|number| number.values.first().copied());
    let zone_of = |(key, _, new): &(&'a str, usize, f64)| Some((FileNumber::FELT_EXPONENT.part_of(key)?, *key, *new));
    let exponents: Vec<(&str, &str, f64)> = changes.iter().filter_map(zone_of).collect();
    for (zone, key, new) in exponents {
        let Some(old) = value(key) else { continue };
        let thickness = FileNumber::FELT_THICKNESS.path(zone);
        let depth_m = value(&thickness).map_or(SIZED_AT_M, |mm| 1e-3 * mm * SIZED_AT);
        let stiffness = FileNumber::FELT_STIFFNESS.path(zone);
        let factor = libm::pow(depth_m, old - new);
        if let Some((_, _, k)) = changes.iter_mut().find(|(key, ..)| *key == stiffness) {
            *k *= factor;
        } else if let Some(number) = numbers.iter().find(|number| number.key == stiffness) {
            changes.push((&number.key, 0, number.values[0] * factor));
        }
    }
}
