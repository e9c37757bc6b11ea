//! Instruments with some numbers changed by name.

use super::register::{file_unit, idle_number};
use super::{Bare, Change, FileNumber, NameError, NumberError, Parameter, Quantity, Unit, canonical_name};
use crate::index::IndexError;
use crate::instrument::{Certainty, FileError, Instrument, InstrumentFile, Spread, numbers_at, with_numbers};
use thiserror::Error;

/// What a caller wants of a number.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterChange {
    /// New value in SI units; of a number of the file whose path ends with its unit, in that unit.
    Value(f64),
    /// As typed ([`Change::read`]): `8.7 g` is the new value, `+0.8 g` and `-0.2 mm` are added, `x1.5` is a factor, and
    /// `=-0.2 mm` is a new value with a sign. A number without a unit is in the unit of [`ParameterChange::Value`].
    Text(String),
    /// As [`ParameterChange::Text`], in a field in which a person types: a number without a unit is in the unit in
    /// which technicians read it ([`Parameter::trade_bare`]).
    Field(String),
}

/// Reason why a number cannot be changed so.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// The name is unknown.
    #[error("{0}, or the path of a number in the file, e.g. `body.hammer.mass_g`")]
    Unknown(NameError),
    /// The name does nothing in this instrument.
    #[error(transparent)]
    Idle(NameError),
    /// The text cannot be read.
    #[error("`{name}`: {error}")]
    Value {
        /// Name of the changed number.
        name: String,
        /// What is wrong.
        error: NumberError,
    },
    /// Out of range.
    #[error("`{name}`: `{found}` is out of range; expected {expected}")]
    Range {
        /// Name of the changed number.
        name: String,
        /// Found text.
        found: String,
        /// Possible range.
        expected: String,
    },
    /// The parameter is another instrument's.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// Error of the reader in the changed file.
    #[error(transparent)]
    File(#[from] Box<FileError>),
}

impl From<NameError> for ChangeError {
    fn from(error: NameError) -> Self {
        match error {
            NameError::Unknown { .. } => ChangeError::Unknown(error),
            NameError::Idle { .. } => ChangeError::Idle(error),
        }
    }
}

impl std::fmt::Display for ParameterChange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ParameterChange::Value(x) => write!(f, "{x}"),
            ParameterChange::Text(text) | ParameterChange::Field(text) => f.write_str(text),
        }
    }
}

impl ParameterChange {
    /// Reads the change of a number of some quantity, in SI units; `bare` is the unit without one.
    fn read(&self, name: &str, quantity: Quantity, bare: Bare) -> Result<Change, ChangeError> {
        let text = match self {
            ParameterChange::Value(value) if value.is_finite() => {
                return Ok(Change::Set(value * bare.unit(quantity).map_or(1.0, |(si, _)| si)));
            }
            ParameterChange::Value(value) => value.to_string(),
            ParameterChange::Text(text) | ParameterChange::Field(text) => text.clone(),
        };
        Change::read(&text, quantity, bare).map_err(|error| ChangeError::Value { name: name.to_owned(), error })
    }
}

/// Entry of the register: a parameter of an instrument, with its uncertainty and source in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Name of the parameter ([`Parameter::all`]).
    pub name: String,
    /// The parameter.
    pub parameter: Parameter,
    /// Physical quantity.
    pub quantity: Quantity,
    /// Value of the parameter, in SI units.
    pub value: f64,
    /// Uncertainty stated in the file, as arguments of [`Parameter::vary`]: turns in m, rad or N m, or factors. `None`
    /// if the file states none.
    pub spread: Option<[f64; 2]>,
    /// Certainty stated in the file; `None` for a bare number.
    pub certainty: Option<Certainty>,
    /// Path in the file.
    pub path: String,
}

/// Returns the register of an instrument: all parameters that can be changed by name.
#[must_use]
pub fn register(file: &InstrumentFile) -> Vec<Entry> {
    let instrument = &file.instrument;
    let all = Parameter::all(instrument).into_iter();
    all.map(|(name, parameter)| {
        let path = parameter.path_in(instrument);
        let number = file.provenance.numbers.iter().find(|number| number.key == path);
        let citation = number.and_then(|number| number.citation.as_ref());
        let own = number.and_then(|number| number.values.first().copied());
        let spread = citation.and_then(|citation| citation.spread).zip(own).and_then(|(spread, own)| {
            spread_of(&parameter, spread, own).filter(|[low, high]| low.is_finite() && high.is_finite() && low < high)
        });
        Entry {
            value: parameter.value_in(instrument),
            quantity: parameter.quantity_in(instrument),
            certainty: citation.map(|citation| citation.certainty),
            name,
            parameter,
            spread,
            path,
        }
    })
    .collect()
}

/// Converts the file's spread, in the file's unit about its own number, to turns or factors.
fn spread_of(parameter: &Parameter, spread: Spread, own: f64) -> Option<[f64; 2]> {
    match (parameter, spread) {
        (Parameter::Screw { action, .. }, Spread::PlusMinus(by)) => {
            let si = action.file_unit().si;
            Some([-by * si, by * si])
        }
        (Parameter::Screw { .. }, Spread::Factor(_)) => None,
        (_, Spread::PlusMinus(by)) => {
            let share = (by / own).abs();
            // A factor is positive.
            Some([(1.0 - share).max(1e-3), 1.0 + share])
        }
        (_, Spread::Factor(factor)) => Some([1.0 / factor, factor]),
    }
}

/// Returns the instrument of a file's text with some numbers changed, one after the other: screws and parameters by
/// their names ([`Parameter::all`]), any other number by its path in the file.
///
/// # Errors
/// See [`ChangeError`].
pub fn varied(
    text: &str,
    file_name: &str,
    changes: &[(String, ParameterChange)],
) -> Result<InstrumentFile, ChangeError> {
    varied_of(&InstrumentFile::parse(text, file_name)?, text, file_name, changes)
}

/// [`varied`] for a file already read from this text: named parameters are changed without reading it again.
///
/// # Errors
/// See [`ChangeError`].
pub fn varied_of(
    read: &InstrumentFile,
    text: &str,
    file_name: &str,
    changes: &[(String, ParameterChange)],
) -> Result<InstrumentFile, ChangeError> {
    let all = Parameter::all(&read.instrument);
    let (new, of_parameters) = with_changed_numbers(&read.instrument, text, changes)?;
    let mut file = match new {
        Some(new) => InstrumentFile::parse(&new, file_name)?,
        None => read.clone(),
    };
    for (name, change) in &of_parameters {
        if let Some((_, parameter)) = all.iter().find(|(known, _)| known == name) {
            vary(&mut file.instrument, name, parameter, change)?;
        }
    }
    Ok(file)
}

/// Makes those changes that are of numbers of the file by their paths, in the text of this instrument. Returns the new
/// text, `None` if nothing in it changes, and the other changes, which are of parameters, in order.
///
/// # Errors
/// See [`ChangeError`].
#[allow(clippy::type_complexity)]
pub fn with_changed_numbers(
    instrument: &Instrument,
    text: &str,
    changes: &[(String, ParameterChange)],
) -> Result<(Option<String>, Vec<(String, ParameterChange)>), ChangeError> {
    let all = Parameter::all(instrument);
    let mut numbers: Vec<(String, usize, f64)> = Vec::new();
    let mut of_parameters = Vec::new();
    for (name, change) in changes {
        let name = known_name(name, &all, text);
        if all.iter().any(|(known, _)| *known == name) {
            of_parameters.push((name, change.clone()));
            continue;
        }
        let (path, which, now) = number_or_fault(instrument, text, &name)?;
        let earlier = numbers.iter().rev().find(|(p, w, _)| *p == path && *w == which).map(|(.., value)| *value);
        numbers.push((path, which, of_file(&name, change, earlier.unwrap_or(now))?));
    }
    let changed: Vec<(&str, usize, f64)> = numbers.iter().map(|(p, w, v)| (p.as_str(), *w, *v)).collect();
    let new = (!changed.is_empty()).then(|| with_numbers(text, &changed).unwrap_or_else(|| text.to_owned()));
    Ok((new, of_parameters))
}

/// Finds a number of the file by its path, of a point by `.x` or `.y` after it: path, component and value.
#[must_use]
pub fn number_of(text: &str, name: &str) -> Option<(String, usize, f64)> {
    FileNumber::of_path(name)?;
    if let Some([value]) = numbers_at(text, name).as_deref() {
        return Some((name.to_owned(), 0, *value));
    }
    let (path, axis) = name.rsplit_once('.')?;
    let which = ["x", "y"].iter().position(|known| *known == axis)?;
    let values = numbers_at(text, path).filter(|values| values.len() == 2)?;
    Some((path.to_owned(), which, values[which]))
}

/// [`number_of`] for the file of an instrument, if the instrument depends on the number.
///
/// # Errors
/// [`NameError::Idle`] of a number that does nothing.
#[allow(clippy::type_complexity)]
pub fn acting_number(
    instrument: &Instrument,
    text: &str,
    name: &str,
) -> Result<Option<(String, usize, f64)>, NameError> {
    let found = number_of(text, name);
    let has = |path: &str| number_of(text, path).map(|(.., value)| value);
    match found.as_ref().and_then(|_| idle_number(instrument, name, has)) {
        Some(error) => Err(error),
        None => Ok(found),
    }
}

/// [`acting_number`], or why the name is neither that of a number nor a parameter's.
fn number_or_fault(instrument: &Instrument, text: &str, name: &str) -> Result<(String, usize, f64), ChangeError> {
    acting_number(instrument, text, name)?.ok_or_else(|| match Parameter::named(instrument, name) {
        Err(error) => error.into(),
        Ok((name, _)) => unreachable!("{name} is a parameter"),
    })
}

/// Value of a number of the file after a change in SI units, both in the file's unit, to fifteen digits as typed.
#[must_use]
pub fn in_file_unit(change: Change, now: f64, unit: Option<&'static Unit>) -> f64 {
    let si = unit.map_or(1.0, |unit| unit.si);
    let new = match change {
        Change::Set(value) => value / si,
        Change::Add(by) => now + by / si,
        Change::Multiply(factor) => now * factor,
    };
    format!("{new:.14e}").parse().unwrap_or(new)
}

/// Changes a number of the file, in the file's unit.
fn of_file(name: &str, wanted: &ParameterChange, now: f64) -> Result<f64, ChangeError> {
    if let ParameterChange::Value(value) = wanted
        && value.is_finite()
    {
        return Ok(*value);
    }
    let (quantity, unit) = file_unit(name);
    let bare = unit.map_or(Bare::Si, |unit| Bare::In(unit.symbol));
    Ok(in_file_unit(wanted.read(name, quantity, bare)?, now, unit))
}

/// Returns the text of an instrument's file with one number changed as by [`varied`], to ten digits: the mass of a body
/// with its inertia (`body.hammer.mass`), all numbers of a felt's damping, a screw, or a number by its path.
///
/// # Errors
/// See [`ChangeError`]. A screw without a setting in the file is refused: there is no number to change.
pub fn varied_text(text: &str, file_name: &str, name: &str, change: &ParameterChange) -> Result<String, ChangeError> {
    let mut instrument = Instrument::parse(text, file_name)?;
    let all = Parameter::all(&instrument);
    let name = known_name(name, &all, text);
    let numbers: Vec<(String, usize, f64)> = match all.iter().find(|(known, _)| *known == name) {
        Some((_, parameter)) => {
            let drawn = instrument.clone();
            let by = vary(&mut instrument, &name, parameter, change)?;
            parameter.numbers(&drawn, by, text)?.into_iter().map(|(path, value)| (path, 0, value)).collect()
        }
        None => {
            let (path, which, now) = number_or_fault(&instrument, text, &name)?;
            vec![(path, which, of_file(&name, change, now)?)]
        }
    };
    let changes: Vec<(&str, usize, f64)> = numbers.iter().map(|(path, which, v)| (path.as_str(), *which, *v)).collect();
    let new = with_numbers(text, &changes).filter(|_| !changes.is_empty()).ok_or_else(|| ChangeError::Range {
        expected: format!("the file to hold it: {}", changes.first().map_or("a number", |(path, ..)| path)),
        found: change.to_string(),
        name,
    })?;
    Instrument::parse(&new, file_name)?;
    Ok(new)
}

/// Changes a parameter of an instrument. Returns the argument of [`Parameter::vary`].
fn vary(
    instrument: &mut Instrument,
    name: &str,
    parameter: &Parameter,
    wanted: &ParameterChange,
) -> Result<f64, ChangeError> {
    let quantity = parameter.quantity(instrument)?;
    let bare = if matches!(wanted, ParameterChange::Field(_)) { parameter.trade_bare(instrument)? } else { Bare::Si };
    let by = parameter.by(instrument, wanted.read(name, quantity, bare)?)?;
    let range = out_of_range(instrument, name, parameter, wanted)?;
    let [least, most] = parameter.range();
    if !(least..=most).contains(&by) || parameter.vary(instrument, by).is_err() {
        return Err(range);
    }
    Ok(by)
}

fn out_of_range(
    instrument: &Instrument,
    name: &str,
    parameter: &Parameter,
    wanted: &ParameterChange,
) -> Result<ChangeError, IndexError> {
    let [least, most] = parameter.range();
    let unit = parameter.quantity(instrument)?.si_unit();
    let expected = if parameter.is_factor() {
        let now = parameter.value(instrument)?;
        format!("a positive value from {least} to {most} times {now:e} {unit}")
    } else {
        format!("at most {most:.4} {unit} either way, and a spring that does not turn around")
    };
    let expected = expected.trim_end().to_owned();
    Ok(ChangeError::Range { name: name.to_owned(), found: wanted.to_string(), expected })
}

/// Returns a name as typed if it is a parameter's, or the path of a number in the file's text; else with regional words
/// replaced by this program's.
#[must_use]
pub fn known_name(name: &str, all: &[(String, Parameter)], text: &str) -> String {
    let name = name.trim();
    let is_known = all.iter().any(|(known, _)| known == name) || number_of(text, name).is_some();
    if is_known { name.to_owned() } else { canonical_name(name) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> &'static str {
        Instrument::builtin_text("concert-grand").unwrap()
    }

    fn with(changes: &[(&str, ParameterChange)]) -> Result<Instrument, ChangeError> {
        let changes: Vec<(String, ParameterChange)> =
            changes.iter().map(|(name, change)| ((*name).to_owned(), change.clone())).collect();
        varied(text(), "grand", &changes).map(|file| file.instrument)
    }

    fn written(name: &str, text: &str) -> Result<Instrument, ChangeError> {
        with(&[(name, ParameterChange::Text(text.to_owned()))])
    }

    /// Values, differences and factors are applied as typed; a number is the value in SI units.
    #[test]
    fn numbers_change_as_they_say() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        // Regional words; what a file itself calls so stays.
        assert_eq!(written("set_off", "-0.2 mm").unwrap(), written("let_off", "-0.2 mm").unwrap());
        let mass = |name: &str| with(&[(name, ParameterChange::Text("= 10 g".to_owned()))]);
        assert_eq!(mass("body.wippen.mass_g").unwrap(), mass("body.whippen.mass_g").unwrap());
        let wippen = text().replace("\"whippen\"", "\"wippen\"");
        assert_eq!(known_name("body.wippen.mass_g", &[], &wippen), "body.wippen.mass_g");
        let all = Parameter::all(&grand);
        let value = |instrument: &Instrument, name: &str| {
            all.iter().find(|(known, _)| known == name).unwrap().1.value(instrument).unwrap()
        };
        let now = |name: &str| value(&grand, name);
        let mass = now("body.hammer.mass");
        for (name, text, expected) in [
            ("let_off", "-0.2 mm", now("let_off") - 2e-4),
            ("let_off", "0.3mm", 3e-4),
            ("let_off", "= -0.3 mm", -3e-4),
            ("body.hammer.mass", "8.7 g", 8.7e-3),
            ("body.hammer.mass", "+0.8 g", mass + 0.8e-3),
            ("body.hammer.mass", "x1.5", mass * 1.5),
            ("body.whippen.friction", "2 N mm", 2e-3),
            ("zone.string.stiffness", "*0.5", now("zone.string.stiffness") * 0.5),
        ] {
            let found = value(&written(name, text).unwrap(), name);
            assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{name} {text}: {found} {expected}");
        }
        for (name, parameter) in &all {
            let by = if parameter.is_factor() { 1.25 } else { 1e-4 };
            let mut studied = grand.clone();
            parameter.vary(&mut studied, by).unwrap();
            let by = if parameter.is_factor() { "x1.25" } else { "+1e-4" };
            assert_eq!(written(name, by).unwrap(), studied, "{name}");
            // A number is the new value, in SI units.
            let wanted = parameter.value(&studied).unwrap();
            let set = with(&[(name, ParameterChange::Value(wanted))]).unwrap();
            assert!((parameter.value(&set).unwrap() - wanted).abs() <= 1e-15 * wanted.abs().max(1e-3), "{name}");
        }
        // The same change twice is applied twice; numbers of the file go by their paths.
        let twice = ParameterChange::Text("+0.5 g".into());
        let heavy = with(&[("body.hammer.mass", twice.clone()), ("body.hammer.mass", twice)]).unwrap();
        assert!((value(&heavy, "body.hammer.mass") - mass - 1e-3).abs() < 1e-15);
        let own = written("body.hammer.mass_g", "+0.5 g").unwrap();
        assert!((value(&own, "body.hammer.mass") - mass - 0.5e-3).abs() < 1e-15);
    }

    /// A text with a changed parameter reads as the varied instrument: the mass with its inertia.
    #[test]
    fn a_changed_text_is_the_varied_instrument() {
        for (name, change) in [
            ("body.hammer.mass", "*1.05"),
            ("body.hammer.mass", "+0.8 g"),
            ("let_off", "-0.2 mm"),
            ("set_off", "0.3mm"),
        ] {
            let change = ParameterChange::Text(change.to_owned());
            let new = varied_text(text(), "grand", name, &change).unwrap();
            let (read, wanted) = (Instrument::parse(&new, "new").unwrap(), with(&[(name, change)]).unwrap());
            for (a, b) in read.bodies.iter().zip(&wanted.bodies) {
                assert!((a.mass_kg / b.mass_kg - 1.0).abs() < 1e-9 || a.mass_kg == b.mass_kg, "{name}: {}", a.name);
                assert!((a.inertia_kg_m2 / b.inertia_kg_m2 - 1.0).abs() < 1e-9, "{name}: {}", a.name);
            }
            for (a, b) in read.screws.iter().zip(&wanted.screws) {
                assert!((a.setting - b.setting).abs() < 1e-12, "{name}: {}", a.name);
            }
            assert_ne!(new, text());
        }
        let own = varied_text(text(), "grand", "body.hammer.mass_g", &ParameterChange::Text("= 9 g".into())).unwrap();
        assert_eq!(numbers_at(&own, "body.hammer.mass_g"), Some(vec![9.0]));
        for (name, change) in [("body.drummer.mass", "*2"), ("body.hammer.mass", "-200 g"), ("let_off", "3 g")] {
            assert!(
                varied_text(text(), "grand", name, &ParameterChange::Text(change.into())).is_err(),
                "{name} {change}"
            );
        }
    }

    /// Every quantity's path leads to its number, so that its source and its spread are found.
    #[test]
    fn every_quantity_stands_in_the_file() {
        let file = InstrumentFile::parse(text(), "grand").unwrap();
        let all = register(&file);
        assert_eq!(all.len(), Parameter::all(&file.instrument).len());
        for quantity in &all {
            let number = file.provenance.numbers.iter().find(|number| number.key == quantity.path);
            // A screw as drawn has no setting in the file.
            assert!(number.is_some() || quantity.value == 0.0, "{}", quantity.path);
            if let Some([low, high]) = quantity.spread {
                assert!(low < high, "{}", quantity.name);
            }
        }
        assert!(all.iter().filter(|quantity| quantity.spread.is_some()).count() > 10);
    }

    /// Errors state what was found and what is expected.
    #[test]
    fn what_is_wrong_is_named() {
        for (name, text, told) in [
            ("letof", "1 mm", "`let_off`"),
            ("let_off", "1 g", "`g` is not one of its units; expected m, dm, cm, mm"),
            ("let_off", "1", "out of range"),
            ("let_off", "+1", "out of range"),
            ("let_off", "nan mm", "expected a length"),
            ("body.key.friction", "2 N mm", "type `body.key_back.friction`"),
            ("body.key.friction_torque_N_m", "x2", "type `body.key_back.friction_torque_N_m`"),
            ("let_off", "200 mm", "out of range"),
            ("body.hammer.mass", "-200 g", "out of range"),
            ("body.hammer.mass", "*0", "out of range"),
            ("body.hammer.mass", "", "a factor"),
            ("body.hammer.mass_g", "3 mm", "`mm` is not one of its units"),
            ("body.hammer.mass_g", "= -3 g", "mass_g"),
        ] {
            let error = written(name, text).unwrap_err().to_string();
            assert!(error.contains(told), "{name} {text}: {error}");
        }
        assert!(with(&[("let_off", ParameterChange::Value(f64::NAN))]).is_err());
        let all = Parameter::all(&Instrument::builtin("concert-grand").unwrap());
        let (friction, _) =
            all.iter().find(|(name, _)| name.starts_with("zone.") && name.ends_with(".friction")).unwrap();
        assert!(written(friction, "0.2 mm").unwrap_err().to_string().contains("expected a number"));
        assert_eq!(written(friction, "=0.2").unwrap(), written(friction, "0.2").unwrap());
    }
}
