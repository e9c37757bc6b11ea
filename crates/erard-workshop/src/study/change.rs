//! Changes of an instrument's parameters as typed: `+0.8 g`, `8.7 g`, `*1.5`.

use erard::instrument::{
    Certainty, FileError, Instrument, InstrumentFile, ScrewAction, Spread, numbers_at, with_numbers,
};
use thiserror::Error;

use super::Parameter;
use crate::regional::canonical_name;

/// Change of a number.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// As in `study --vary`: the turn of a screw, m, rad or N m; the factor of another parameter; the new value of a
    /// number of the file.
    Number(f64),
    /// As typed: `8.7 g` is the new value, `+0.8 g` and `-0.2 mm` are added, `*1.5` is a factor, and `= -0.2 mm` is a
    /// new value with a sign or without a unit.
    Text(String),
}

/// Reason why a number cannot be changed so.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ChangeError {
    /// The name is unknown.
    #[error("unknown name `{name}`; {nearest}, or the path of a number in the file, e.g. `body.hammer.mass_g`")]
    Unknown {
        /// Requested name.
        name: String,
        /// Similar names.
        nearest: String,
    },
    /// The text cannot be read.
    #[error("`{name}`: found `{found}`, expected {expected}")]
    Value {
        /// Name of the changed number.
        name: String,
        /// Found text.
        found: String,
        /// Expected text.
        expected: String,
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
    /// Error of the reader in the changed file.
    #[error(transparent)]
    File(#[from] Box<FileError>),
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Change::Number(x) => write!(f, "{x}"),
            Change::Text(text) => f.write_str(text),
        }
    }
}

/// Parameter that can be varied, with its uncertainty and source in the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Name of the parameter ([`Parameter::all`]).
    pub name: String,
    /// The parameter.
    pub parameter: Parameter,
    /// Value of the parameter, in `unit`.
    pub value: f64,
    /// SI unit; empty for a coefficient.
    pub unit: &'static str,
    /// Uncertainty stated in the file, in the form of [`Change::Number`]: turns in m, rad or N m, or factors. `None` if
    /// the file states none.
    pub spread: Option<[f64; 2]>,
    /// Certainty stated in the file; `None` for a bare number.
    pub certainty: Option<Certainty>,
    /// Path in the file.
    pub path: String,
}

/// Returns all parameters of an instrument that can be varied by name.
pub fn quantities(file: &InstrumentFile) -> Vec<Quantity> {
    let instrument = &file.instrument;
    let all = Parameter::all(instrument).into_iter();
    all.map(|(name, parameter)| {
        let path = parameter.path(instrument);
        let number = file.provenance.numbers.iter().find(|number| number.key == path);
        let citation = number.and_then(|number| number.citation.as_ref());
        let own = number.and_then(|number| number.values.first().copied());
        let spread = citation.and_then(|citation| citation.spread).zip(own).and_then(|(spread, own)| {
            spread_of(&parameter, spread, own).filter(|[low, high]| low.is_finite() && high.is_finite() && low < high)
        });
        Quantity {
            value: parameter.value(instrument),
            unit: units(instrument, &parameter).first().map_or("", |(unit, _)| unit),
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
            let si = match action {
                ScrewAction::Disc { .. } | ScrewAction::Curve { .. } => 1e-3,
                ScrewAction::Turn { .. } => std::f64::consts::PI / 180.0,
                ScrewAction::Spring { .. } => 1.0,
            };
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

/// Accepted units of a parameter, with the SI value of each, the SI unit first.
fn units(instrument: &Instrument, parameter: &Parameter) -> &'static [(&'static str, f64)] {
    const LENGTHS: &[(&str, f64)] = &[("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("in", 25.4e-3)];
    const ANGLES: &[(&str, f64)] = &[
        ("rad", 1.0),
        ("deg", std::f64::consts::PI / 180.0),
        ("degrees", std::f64::consts::PI / 180.0),
        ("°", std::f64::consts::PI / 180.0),
    ];
    const MASSES: &[(&str, f64)] = &[("kg", 1.0), ("g", 1e-3)];
    const TORQUES: &[(&str, f64)] = &[("N m", 1.0), ("N mm", 1e-3), ("mN m", 1e-3)];
    match parameter {
        Parameter::Screw { action, .. } => match action {
            ScrewAction::Disc { .. } | ScrewAction::Curve { .. } => LENGTHS,
            ScrewAction::Turn { .. } => ANGLES,
            ScrewAction::Spring { .. } => TORQUES,
        },
        Parameter::Mass(_) => MASSES,
        Parameter::PivotFriction(_) | Parameter::Torque(_) => TORQUES,
        Parameter::SpringStiffness(_) => &[("N m/rad", 1.0)],
        Parameter::Stiffness(_) => &[("N/m^r", 1.0)],
        Parameter::Damping(i) => match instrument.zones[*i].felt.first_loss().map(|(number, _)| number.unit) {
            Some("N s/m3") => &[("N s/m3", 1.0), ("N s/m^3", 1.0)],
            Some("s/m") => &[("s/m", 1.0)],
            _ => &[],
        },
        Parameter::Friction(_) => &[],
    }
}

/// Change requested by a text.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted {
    Value(f64),
    Difference(f64),
    Factor(f64),
}

impl Wanted {
    /// Reads a change; a value without a unit needs `=`, so that a coefficient is not mistaken for a factor.
    fn read(text: &str, units: &[(&str, f64)]) -> Option<Self> {
        let text = text.trim();
        if let Some(factor) = text.strip_prefix('*') {
            return number(factor.trim()).map(Wanted::Factor);
        }
        let (absolute, rest) = match text.strip_prefix('=') {
            Some(rest) => (true, rest.trim()),
            None => (false, text),
        };
        // The longest prefix that is a number: units begin with letters that also occur in numbers.
        let (value, unit) = (1..=rest.len())
            .rev()
            .filter(|end| rest.is_char_boundary(*end))
            .find_map(|end| Some((number(&rest[..end])?, rest[end..].trim())))?;
        let close = |unit: &str| unit.replace([' ', '\u{b7}', '.'], "");
        let si = match unit {
            "" if absolute || rest.starts_with(['+', '-']) => (units.is_empty()).then_some(1.0),
            "" => None,
            unit => units.iter().find(|(known, _)| close(known) == close(unit)).map(|(_, si)| *si),
        }?;
        let value = value * si;
        Some(if !absolute && rest.starts_with(['+', '-']) { Wanted::Difference(value) } else { Wanted::Value(value) })
    }

    /// Applies the change to a value.
    fn from(self, value: f64) -> f64 {
        match self {
            Wanted::Value(wanted) => wanted,
            Wanted::Difference(by) => value + by,
            Wanted::Factor(factor) => value * factor,
        }
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim_end().parse().ok().filter(|x: &f64| x.is_finite())
}

/// Returns the instrument of a file's text with some numbers changed, one after the other: screws and parameters by
/// their names ([`Parameter::all`]), any other number by its path in the file.
///
/// # Errors
/// See [`ChangeError`].
pub fn varied(text: &str, file_name: &str, changes: &[(String, Change)]) -> Result<InstrumentFile, ChangeError> {
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
    changes: &[(String, Change)],
) -> Result<InstrumentFile, ChangeError> {
    let mut file = read.clone();
    let all = Parameter::all(&file.instrument);
    let changes: Vec<(String, &Change)> =
        changes.iter().map(|(name, change)| (known_name(name, &all, text), change)).collect();
    let find = |name: &str| all.iter().find(|(known, _)| known == name).map(|(_, parameter)| parameter);
    let mut numbers: Vec<(String, usize, f64)> = Vec::new();
    for (name, change) in changes.iter().filter(|(name, _)| find(name).is_none()) {
        let (path, which, now) = number_of(text, name).ok_or_else(|| unknown(name, &all))?;
        let earlier = numbers.iter().rev().find(|(p, w, _)| *p == path && *w == which).map(|(.., value)| *value);
        numbers.push((path, which, of_file(name, change, earlier.unwrap_or(now))?));
    }
    if !numbers.is_empty() {
        let changes: Vec<(&str, usize, f64)> = numbers.iter().map(|(p, w, v)| (p.as_str(), *w, *v)).collect();
        let new = with_numbers(text, &changes).unwrap_or_else(|| text.to_owned());
        file = InstrumentFile::parse(&new, file_name)?;
    }
    for (name, change) in &changes {
        if let Some(parameter) = find(name) {
            vary(&mut file.instrument, name, parameter, change)?;
        }
    }
    Ok(file)
}

/// Finds a number of the file by its path, of a point by `.x` or `.y` after it: path, component and value.
pub fn number_of(text: &str, name: &str) -> Option<(String, usize, f64)> {
    if let Some([value]) = numbers_at(text, name).as_deref() {
        return Some((name.to_owned(), 0, *value));
    }
    let (path, axis) = name.rsplit_once('.')?;
    let which = ["x", "y"].iter().position(|known| *known == axis)?;
    let values = numbers_at(text, path).filter(|values| values.len() == 2)?;
    Some((path.to_owned(), which, values[which]))
}

/// Units accepted for a number of the file: only its own, at the end of its key.
fn own_unit(name: &str) -> &'static [(&'static str, f64)] {
    let key = name.trim_end_matches(".x").trim_end_matches(".y");
    const UNITS: [(&str, &[(&str, f64)]); 6] = [
        ("_mm", &[("mm", 1.0)]),
        ("_kg_m2", &[("kg m2", 1.0)]),
        ("_deg", &[("deg", 1.0)]),
        ("_g", &[("g", 1.0)]),
        ("_N_m", &[("N m", 1.0)]),
        ("_N_per_m", &[("N/m", 1.0)]),
    ];
    UNITS.iter().find(|(ending, _)| key.ends_with(ending)).map_or(&[], |(_, units)| units)
}

/// Changes a number of the file, in the file's unit.
fn of_file(name: &str, change: &Change, now: f64) -> Result<f64, ChangeError> {
    let text = match change {
        Change::Number(value) if value.is_finite() => return Ok(*value),
        Change::Number(value) => value.to_string(),
        Change::Text(text) => text.clone(),
    };
    let units = own_unit(name);
    match Wanted::read(&text, units) {
        Some(wanted) => Ok(wanted.from(now)),
        None => Err(ChangeError::Value { name: name.to_owned(), found: text, expected: expected(units) }),
    }
}

/// Describes the accepted text.
fn expected(units: &[(&str, f64)]) -> String {
    let names: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
    // The trade's own unit is second where there is one.
    match names.get(1).or(names.first()) {
        Some(unit) => format!(
            "a value with its unit (`2 {unit}`), a difference with its sign (`+2 {unit}`) or a factor (`*1.5`); units: {}",
            names.join(", ")
        ),
        None => "`= 0.2` (a value), `+0.2` (a difference) or `*1.5` (a factor)".to_owned(),
    }
}

/// Returns the text of an instrument's file with one number changed as by [`varied`], to ten digits: the mass of a body
/// with its inertia (`body.hammer.mass`), all numbers of a felt's damping, a screw, or a number by its path.
///
/// # Errors
/// See [`ChangeError`]. A screw without a setting in the file is refused: there is no number to change.
pub fn varied_text(text: &str, file_name: &str, name: &str, change: &Change) -> Result<String, ChangeError> {
    let mut instrument = Instrument::parse(text, file_name)?;
    let all = Parameter::all(&instrument);
    let name = known_name(name, &all, text);
    let numbers: Vec<(String, usize, f64)> = match all.iter().find(|(known, _)| *known == name) {
        Some((_, parameter)) => {
            let drawn = instrument.clone();
            let by = vary(&mut instrument, &name, parameter, change)?;
            parameter.numbers(&drawn, by, text).into_iter().map(|(path, value)| (path, 0, value)).collect()
        }
        None => {
            let (path, which, now) = number_of(text, &name).ok_or_else(|| unknown(&name, &all))?;
            vec![(path, which, of_file(&name, change, now)?)]
        }
    };
    let changes: Vec<(&str, usize, f64)> = numbers.iter().map(|(path, which, v)| (path.as_str(), *which, *v)).collect();
    let new = with_numbers(text, &changes).filter(|_| !changes.is_empty()).ok_or_else(|| ChangeError::Value {
        expected: format!("the file to hold it: {}", changes.first().map_or("a number", |(path, ..)| path)),
        found: change.to_string(),
        name,
    })?;
    Instrument::parse(&new, file_name)?;
    Ok(new)
}

/// Changes a parameter of an instrument. Returns the argument of [`Parameter::vary`].
fn vary(instrument: &mut Instrument, name: &str, parameter: &Parameter, change: &Change) -> Result<f64, ChangeError> {
    let units = units(instrument, parameter);
    let now = parameter.value(instrument);
    let by = match change {
        Change::Number(by) if by.is_finite() => *by,
        Change::Text(text) if Wanted::read(text, units).is_some() => match Wanted::read(text, units) {
            Some(Wanted::Factor(factor)) if parameter.is_factor() => factor,
            Some(wanted) if parameter.is_factor() => wanted.from(now) / now,
            Some(wanted) => wanted.from(now) - now,
            None => f64::NAN,
        },
        change => {
            let found = change.to_string();
            return Err(ChangeError::Value { name: name.to_owned(), found, expected: expected(units) });
        }
    };
    let [least, most] = parameter.range();
    let out_of_range = || {
        let unit = units.first().map_or("", |(unit, _)| unit);
        let expected = if parameter.is_factor() {
            format!("a positive value from {least} to {most} times {now:e} {unit}")
        } else {
            format!("at most {most:.4} {unit} either way, and a spring that does not turn around")
        };
        ChangeError::Range { name: name.to_owned(), found: change.to_string(), expected: expected.replace(" ,", ",") }
    };
    if !(least..=most).contains(&by) || !parameter.vary(instrument, by) {
        return Err(out_of_range());
    }
    Ok(by)
}

/// Returns a name as typed if it is a parameter's, or the path of a number in the file's text; else with regional words
/// replaced by this program's.
#[must_use]
pub fn known_name(name: &str, all: &[(String, Parameter)], text: &str) -> String {
    let name = name.trim();
    let is_known = all.iter().any(|(known, _)| known == name) || number_of(text, name).is_some();
    if is_known { name.to_owned() } else { canonical_name(name) }
}

fn unknown(name: &str, all: &[(String, Parameter)]) -> ChangeError {
    let nearest = nearest(name, all.iter().map(|(known, _)| known));
    ChangeError::Unknown {
        name: name.to_owned(),
        nearest: format!("expected one of {} names, nearest {nearest}", all.len()),
    }
}

/// Returns the three known names most similar to one.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let mut near: Vec<(f64, &String)> = known.map(|known| (strsim::jaro_winkler(name, known), known)).collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    near.iter().take(3).map(|(_, name)| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> &'static str {
        Instrument::builtin_text("concert-grand").unwrap()
    }

    fn with(changes: &[(&str, Change)]) -> Result<Instrument, ChangeError> {
        let changes: Vec<(String, Change)> =
            changes.iter().map(|(name, change)| ((*name).to_owned(), change.clone())).collect();
        varied(text(), "grand", &changes).map(|file| file.instrument)
    }

    fn written(name: &str, text: &str) -> Result<Instrument, ChangeError> {
        with(&[(name, Change::Text(text.to_owned()))])
    }

    /// Values, differences and factors are applied as typed; a bare number does the same as in a study, to the bit.
    #[test]
    fn numbers_change_as_they_say() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        // Regional words; what a file itself calls so stays.
        assert_eq!(written("set_off", "-0.2 mm").unwrap(), written("let_off", "-0.2 mm").unwrap());
        let mass = |name: &str| with(&[(name, Change::Text("= 10 g".to_owned()))]);
        assert_eq!(mass("body.wippen.mass_g").unwrap(), mass("body.whippen.mass_g").unwrap());
        let wippen = text().replace("\"whippen\"", "\"wippen\"");
        assert_eq!(known_name("body.wippen.mass_g", &[], &wippen), "body.wippen.mass_g");
        let all = Parameter::all(&grand);
        let value = |instrument: &Instrument, name: &str| {
            all.iter().find(|(known, _)| known == name).unwrap().1.value(instrument)
        };
        let now = |name: &str| value(&grand, name);
        let mass = now("body.hammer.mass");
        for (name, text, expected) in [
            ("let_off", "-0.2 mm", now("let_off") - 2e-4),
            ("let_off", "0.3mm", 3e-4),
            ("let_off", "= -0.3 mm", -3e-4),
            ("body.hammer.mass", "8.7 g", 8.7e-3),
            ("body.hammer.mass", "+0.8 g", mass + 0.8e-3),
            ("body.hammer.mass", "*1.5", mass * 1.5),
            ("body.key.friction", "2 N mm", 2e-3),
            ("zone.string.stiffness", "*0.5", now("zone.string.stiffness") * 0.5),
        ] {
            let found = value(&written(name, text).unwrap(), name);
            assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{name} {text}: {found} {expected}");
        }
        for (name, parameter) in &all {
            let by = if parameter.is_factor() { 1.25 } else { 1e-4 };
            let mut studied = grand.clone();
            assert!(parameter.vary(&mut studied, by));
            assert_eq!(with(&[(name, Change::Number(by))]).unwrap(), studied, "{name}");
        }
        // The same change twice is applied twice; numbers of the file go by their paths.
        let twice = Change::Text("+0.5 g".into());
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
            let change = Change::Text(change.to_owned());
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
        let own = varied_text(text(), "grand", "body.hammer.mass_g", &Change::Text("= 9 g".into())).unwrap();
        assert_eq!(numbers_at(&own, "body.hammer.mass_g"), Some(vec![9.0]));
        for (name, change) in [("body.drummer.mass", "*2"), ("body.hammer.mass", "-200 g"), ("let_off", "3 g")] {
            assert!(varied_text(text(), "grand", name, &Change::Text(change.into())).is_err(), "{name} {change}");
        }
    }

    /// Every quantity's path leads to its number, so that its source and its spread are found.
    #[test]
    fn every_quantity_stands_in_the_file() {
        let file = InstrumentFile::parse(text(), "grand").unwrap();
        let all = quantities(&file);
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
            ("let_off", "1 g", "units: m, mm"),
            ("let_off", "1", "with its unit"),
            ("let_off", "+1", "with its unit"),
            ("let_off", "nan mm", "with its unit"),
            ("let_off", "200 mm", "out of range"),
            ("body.hammer.mass", "-200 g", "out of range"),
            ("body.hammer.mass", "*0", "out of range"),
            ("body.hammer.mass", "", "a factor"),
            ("body.hammer.mass_g", "3 kg", "units: g"),
            ("body.hammer.mass_g", "= -3 g", "mass_g"),
        ] {
            let error = written(name, text).unwrap_err().to_string();
            assert!(error.contains(told), "{name} {text}: {error}");
        }
        assert!(with(&[("let_off", Change::Number(f64::NAN))]).is_err());
        let friction = Parameter::all(&Instrument::builtin("concert-grand").unwrap());
        let friction =
            friction.iter().find(|(name, _)| name.starts_with("zone.") && name.ends_with(".friction")).unwrap();
        assert!(written(&friction.0, "0.2").unwrap_err().to_string().contains("`= 0.2`"));
        assert!(written(&friction.0, "= 0.2").is_ok());
    }
}
