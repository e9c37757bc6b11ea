//! Reads single values: numbers, with their limits and provenance, and names, which must exist or be new.

use std::collections::BTreeMap;
use std::ops::Range;

use super::error::Fault;
use super::provenance::{Certainty, Citation, Source, Spread};
use super::quantity::{At, FileQuantity, Num, NumberKind};
use super::{Instrument, Vec2};
use crate::files::steers;

/// Millimetres in a metre. Dividing by it rounds correctly: 142.23 mm is the same bits as 0.14223 m.
pub const MM_PER_M: f64 = 1000.0;
/// Grams in a kilogram.
pub(crate) const G_PER_KG: f64 = 1000.0;

/// Longest name, characters: names become titles of columns.
const MAX_NAME_LENGTH: usize = 40;

/// Plausible range of a number: a value outside is taken for a slip of the pen. The ranges are wide enough for an anvil
/// and for a watch.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// Unit, for the message.
    pub unit: &'static str,
}

impl Limits {
    /// From minus `most` to `most`.
    pub const fn symmetric(most: f64, unit: &'static str) -> Self {
        Self { least: -most, most, unit }
    }
    /// From 0 to `most`.
    pub const fn up_to(most: f64, unit: &'static str) -> Self {
        Self { least: 0.0, most, unit }
    }
    /// From `least` (above 0) to `most`.
    pub const fn between(least: f64, most: f64, unit: &'static str) -> Self {
        Self { least, most, unit }
    }
}

/// A number for the provenance. Its key is found later from its span.
pub struct ReadNumber {
    pub span: Range<usize>,
    pub values: Vec<f64>,
    pub citation: Option<Citation>,
}

/// Reads values and keeps a record of the numbers.
pub struct Reader<'a> {
    sources: &'a BTreeMap<String, Source>,
    /// All numbers read so far.
    pub numbers: Vec<ReadNumber>,
}

impl<'a> Reader<'a> {
    pub fn new(sources: &'a BTreeMap<String, Source>) -> Self {
        Self { sources, numbers: Vec::new() }
    }

    /// Reads a scalar within `limits`, in the file's unit.
    pub fn scalar<T: NumberKind>(&mut self, number: &Num<T>, limits: impl Into<Limits>) -> Result<f64, Fault> {
        self.checked(number, limits.into())?;
        Ok(number.kind().numbers()[0])
    }

    /// Reads a scalar that may be absent; it is 0 then.
    pub(crate) fn scalar_or_zero<T: NumberKind>(
        &mut self,
        number: Option<&Num<T>>,
        limits: impl Into<Limits>,
    ) -> Result<f64, Fault> {
        number.map_or(Ok(0.0), |number| self.scalar(number, limits))
    }

    /// Reads a pair within `limits`, in the file's unit.
    pub(crate) fn pair<T: NumberKind>(&mut self, number: &Num<T>, limits: impl Into<Limits>) -> Result<Vec2, Fault> {
        self.checked(number, limits.into())?;
        let numbers = number.kind().numbers();
        Ok([numbers[0], numbers[1]])
    }

    /// Reads a point in millimetres and returns it in metres.
    pub fn point_m<T: NumberKind>(&mut self, number: &Num<T>, limits: impl Into<Limits>) -> Result<Vec2, Fault> {
        Ok(self.pair(number, limits)?.map(|mm| mm / MM_PER_M))
    }

    /// Reads a direction of any length but zero and returns a unit vector.
    pub(crate) fn direction<T: NumberKind>(
        &mut self,
        number: &Num<T>,
        limits: impl Into<Limits>,
    ) -> Result<Vec2, Fault> {
        let [x, y] = self.pair(number, limits)?;
        let length = libm::hypot(x, y);
        if length < 1e-6 {
            return Err(Fault::at(number.value_span(), "a direction must have a length", "two numbers, not both 0"));
        }
        Ok([x / length, y / length])
    }

    fn checked<T: NumberKind>(&mut self, number: &Num<T>, limits: Limits) -> Result<(), Fault> {
        let values = number.kind().numbers();
        for &value in values {
            self.check_value(value, number.value_span(), T::EXPECTED, limits)?;
        }
        let citation = match &**number {
            FileQuantity::Bare(_) => None,
            FileQuantity::Cited(cited) => {
                let spread = match (&cited.spread, &cited.spread_factor) {
                    (Some(_), Some(factor)) => {
                        return Err(Fault::at(
                            factor.span(),
                            "found both `spread` and `spread_factor`",
                            "one of the two",
                        ));
                    }
                    (Some(spread), None) => {
                        let limits = Limits::up_to(1e18, "");
                        self.check_value(spread.0, spread.span(), "a spread that is not negative", limits)?;
                        Some(Spread::PlusMinus(spread.0))
                    }
                    (None, Some(factor)) => {
                        let limits = Limits::between(1.0, 1e6, "");
                        self.check_value(factor.0, factor.span(), "a factor of at least 1", limits)?;
                        Some(Spread::Factor(factor.0))
                    }
                    (None, None) => None,
                };
                if let Some(together) = cited.together.as_ref().filter(|_| spread.is_none()) {
                    let expected = "`spread` or `spread_factor` beside it";
                    return Err(Fault::at(together.span(), "`together` needs a spread", expected));
                }
                let citation = self.citation(&cited.source, cited.certainty, spread, cited.note.as_deref())?;
                Some(Citation { together: cited.together.as_ref().map(|name| name.to_string()), ..citation })
            }
        };
        self.numbers.push(ReadNumber { span: number.span(), values: values.to_vec(), citation });
        Ok(())
    }

    fn check_value(&self, value: f64, span: Range<usize>, expected: &str, limits: Limits) -> Result<(), Fault> {
        let Limits { least, most, unit } = limits;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        if !value.is_finite() {
            return Err(Fault::at(span, "not a finite number", expected));
        }
        if value < 0.0 && least >= 0.0 {
            return Err(Fault::at(span, "must not be negative", expected));
        }
        if value == 0.0 && least > 0.0 {
            return Err(Fault::at(span, "must not be zero", expected));
        }
        if value < least {
            return Err(Fault::at(span, "too small", format!("at least {}{unit}", round(least))));
        }
        if value > most {
            return Err(Fault::at(span, "too large", format!("at most {}{unit}", round(most))));
        }
        Ok(())
    }

    /// Checks a corner of an outline, mm, and returns it in metres.
    pub(crate) fn corner_m(&self, corner_mm: Vec2, span: Range<usize>) -> Result<Vec2, Fault> {
        for value in corner_mm {
            self.check_value(value, span.clone(), "numbers [x, y]", LENGTH_MM)?;
        }
        Ok(corner_mm.map(|mm| mm / MM_PER_M))
    }

    /// Returns a citation after checking that its source exists.
    pub(crate) fn citation(
        &self,
        source: &At<String>,
        certainty: Certainty,
        spread: Option<Spread>,
        note: Option<&str>,
    ) -> Result<Citation, Fault> {
        if !self.sources.contains_key(source.as_str()) {
            let expected = one_of(self.sources.keys().map(String::as_str), "an entry of [sources]");
            return Err(Fault::at(source.span(), "no such source", expected));
        }
        Ok(Citation { source: source.to_string(), certainty, spread, together: None, note: note.map(str::to_owned) })
    }
}

/// Limits of lengths and coordinates: ten metres, far beyond any action.
pub const LENGTH_MM: Limits = Limits::symmetric(1e4, "mm");
/// Limits of a direction's coordinates; its length does not count.
pub(crate) const DIRECTION: Limits = Limits::symmetric(1e6, "");

/// Checks a new name for a body, spring, zone, string or screw: it must be fit for a column title and not taken.
pub(crate) fn new_name<'n>(
    name: &At<String>,
    what: &str,
    taken: impl IntoIterator<Item = &'n str>,
) -> Result<String, Fault> {
    let expected = format!("1 to {MAX_NAME_LENGTH} lower-case letters, digits and underscores, starting with a letter");
    let well_formed = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.len() <= MAX_NAME_LENGTH
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    if !well_formed {
        return Err(Fault::at(name.span(), format!("not a name for a {what}"), expected));
    }
    if taken.into_iter().any(|other| other == name.as_str()) {
        return Err(Fault::at(name.span(), format!("there are two {}", plural(what)), "a name of its own"));
    }
    Ok(name.to_string())
}

/// Longest name or label for people, characters: it must fit on one line of a figure.
pub(crate) const MAX_TITLE_LENGTH: usize = 120;

/// Checks a name or label for people: one line, not empty. Returns it without the blanks around it.
pub fn title(name: &At<String>, what: &str) -> Result<String, Fault> {
    let trimmed = name.trim();
    let wrong = |message: String, expected: String| Err(Fault::at(name.span(), message, expected));
    if trimmed.is_empty() {
        return wrong(format!("{what} needs a name"), "a name".to_owned());
    }
    if trimmed.chars().count() > MAX_TITLE_LENGTH {
        return wrong("too long for a name".to_owned(), format!("at most {MAX_TITLE_LENGTH} characters"));
    }
    if trimmed.chars().any(|c| c.is_control() || steers(c)) {
        return wrong(
            "a name holds a control character".to_owned(),
            "letters, digits and punctuation on one line".to_owned(),
        );
    }
    Ok(trimmed.to_owned())
}

fn plural(what: &str) -> String {
    format!("{} of this name", if what == "body" { "bodies".to_owned() } else { format!("{what}s") })
}

/// Returns the index of a name in a list of names.
pub(crate) fn index_of<'n>(
    name: &At<String>,
    what: &str,
    names: impl Iterator<Item = &'n str> + Clone,
) -> Result<usize, Fault> {
    names.clone().position(|other| other == name.as_str()).ok_or_else(|| {
        Fault::at(name.span(), format!("no such {what}"), one_of(names, &format!("the name of a {what}")))
    })
}

/// Returns the index of a named body; `None` for `ground`.
pub(crate) fn body_or_ground(name: &At<String>, instrument: &Instrument) -> Result<Option<usize>, Fault> {
    if name.as_str() == GROUND {
        return Ok(None);
    }
    let names = instrument.bodies.iter().map(|body| body.name.as_str());
    index_of(name, "body", names.clone()).map(Some).map_err(|mut fault| {
        fault.expected = one_of(names.chain([GROUND]), "a body or `ground`");
        fault
    })
}

/// Name of the world in a file.
pub(crate) const GROUND: &str = "ground";

/// Formats a limit as a person writes it.
fn round(limit: f64) -> String {
    if (1e-3..1e6).contains(&limit.abs()) { format!("{limit}") } else { format!("{limit:e}") }
}

/// Returns the names as "one of `a`, `b`", or `otherwise` when there are none.
fn one_of<'n>(names: impl Iterator<Item = &'n str>, otherwise: &str) -> String {
    let names: Vec<String> = names.take(40).map(|name| format!("`{name}`")).collect();
    match names.as_slice() {
        [] => format!("{otherwise}, but there are none"),
        [name] => name.clone(),
        _ => format!("one of {}", names.join(", ")),
    }
}
