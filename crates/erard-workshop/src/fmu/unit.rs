//! Contents of a unit, with its parameters applied.

use erard::Instrument;
use erard::instrument::{FileError, InstrumentFile, with_numbers};
use erard::keyboard::Keyboard;
use erard::saved::{FNV1A, fnv1a};

use super::{INSTRUMENT, KEYBOARD, Role, Variable, keyboard_variables, variables};
use erard::parameter::Parameter;

/// An instrument or a keyboard, with the variables for a simulator.
#[derive(Debug)]
pub struct Unit {
    /// Name of the instrument or keyboard.
    pub name: String,
    /// Description of the unit; may be empty.
    pub description: String,
    /// Variables in the order of the description.
    pub variables: Vec<Variable>,
    /// The instrument, or the base instrument of the keyboard.
    file: InstrumentFile,
    text: String,
    /// The keyboard, and the text of its file.
    keyboard: Option<(Keyboard, String)>,
}

impl Unit {
    /// Reads the unit of an instrument from the text of its file.
    ///
    /// # Errors
    /// See [`InstrumentFile::parse`].
    pub fn of_instrument(text: &str) -> Result<Self, Box<FileError>> {
        let file = InstrumentFile::parse(text, INSTRUMENT)?;
        Ok(Unit {
            name: file.instrument.name.clone(),
            description: file.description.clone(),
            variables: variables(&file, text),
            file,
            text: text.to_owned(),
            keyboard: None,
        })
    }

    /// Reads the unit of a keyboard from the texts of its file and of its base instrument's.
    ///
    /// # Errors
    /// See [`Keyboard::parse`].
    pub fn of_keyboard(text: &str, base_text: &str) -> Result<Self, Box<FileError>> {
        let file = InstrumentFile::parse(base_text, INSTRUMENT)?;
        let keyboard = Keyboard::parse_around(text, KEYBOARD, base_text)?;
        Ok(Unit {
            name: keyboard.name.clone(),
            description: keyboard.description.clone(),
            variables: keyboard_variables(&file, base_text),
            file,
            text: base_text.to_owned(),
            keyboard: Some((keyboard, text.to_owned())),
        })
    }

    /// Whether the unit is a keyboard.
    #[must_use]
    pub fn is_keyboard(&self) -> bool {
        self.keyboard.is_some()
    }

    /// Iterates over paths and texts of the archive's files other than the description and the library.
    pub fn resources(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let keyboard = self.keyboard.as_ref().map(|(_, text)| (KEYBOARD, text.as_str()));
        [(INSTRUMENT, self.text.as_str())].into_iter().chain(keyboard)
    }

    /// Returns an identifier of these files and this version of the numbering, in FMI's notation.
    #[must_use]
    pub fn guid(&self) -> String {
        let version = concat!("erard-fmu/3 ", env!("CARGO_PKG_VERSION"));
        let texts = || self.resources().flat_map(|(_, text)| text.bytes());
        let [a, b] = [FNV1A, 0x9e37_79b9_7f4a_7c15].map(|seed| fnv1a(seed, version.bytes().chain(texts())));
        let hex = format!("{a:016x}{b:016x}");
        format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
    }

    /// Makes the instruments for values of the variables, in their order: one, or those of all keys of the keyboard.
    ///
    /// # Errors
    /// A line that names the impossible parameter, or the error in the file with it.
    pub fn instruments(&self, values: &[f64]) -> Result<Vec<Instrument>, String> {
        let mut changes: Vec<(String, usize, f64)> = Vec::new();
        for (variable, value) in self.changed(values) {
            if let Role::Number(number, place) = variable.role {
                changes.push((self.file.provenance.numbers[number].key.clone(), place, value));
            }
        }
        let Some((keyboard, _)) = &self.keyboard else {
            let mut instrument = match self.text_with(&changes)? {
                None => self.file.instrument.clone(),
                Some(text) => Instrument::parse(&text, INSTRUMENT).map_err(|error| error.to_string())?,
            };
            for (parameter, factor) in self.masses(values, &changes, &instrument)? {
                parameter.vary(&mut instrument, factor).map_err(|error| error.to_string())?;
            }
            return Ok(vec![instrument]);
        };
        for (parameter, factor) in self.masses(values, &changes, &self.file.instrument)? {
            let numbers =
                parameter.numbers(&self.file.instrument, factor, &self.text).map_err(|error| error.to_string())?;
            changes.extend(numbers.into_iter().map(|(path, value)| (path, 0, value)));
        }
        let changed = match self.text_with(&changes)? {
            None => return keyboard.instruments().map_err(|error| error.to_string()),
            Some(text) => keyboard.around(text).map_err(|error| error.to_string())?,
        };
        changed.instruments().map_err(|error| error.to_string())
    }

    /// Returns the text with other numbers; `None` if there are none.
    fn text_with(&self, changes: &[(String, usize, f64)]) -> Result<Option<String>, String> {
        if changes.is_empty() {
            return Ok(None);
        }
        let changes: Vec<(&str, usize, f64)> =
            changes.iter().map(|(path, place, value)| (path.as_str(), *place, *value)).collect();
        let text = with_numbers(&self.text, &changes).ok_or("a parameter has no place in the instrument's text")?;
        Ok(Some(text))
    }

    /// Variables with another value than at the start.
    fn changed<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = (&'a Variable, f64)> {
        let all = self.variables.iter().zip(values.iter().copied());
        all.filter(|(variable, value)| variable.start != Some(*value))
    }

    /// Returns changed masses of bodies, with their inertias, as factors. A body whose own numbers are changed as well
    /// is refused, because two parameters would set its mass.
    fn masses(
        &self,
        values: &[f64],
        changes: &[(String, usize, f64)],
        instrument: &Instrument,
    ) -> Result<Vec<(Parameter, f64)>, String> {
        let mut all = Vec::new();
        for (variable, mass_kg) in self.changed(values) {
            let Role::Mass(body) = variable.role else { continue };
            let Variable { name, .. } = variable;
            let parameter = Parameter::Mass(body);
            let own = parameter.paths(instrument).map_err(|error| error.to_string())?;
            if let Some((path, ..)) = changes.iter().find(|(path, ..)| own.contains(path)) {
                return Err(format!(
                    "`{name}` and `{path}` are both set: set the mass with its inertia, or each by itself"
                ));
            }
            let drawn_kg = parameter.value(instrument).map_err(|error| error.to_string())?;
            let (factor, [least, most]) = (mass_kg / drawn_kg, parameter.range());
            if !(least..=most).contains(&factor) {
                return Err(format!("`{name}` is {mass_kg} kg; expected {least} to {most} times {drawn_kg} kg"));
            }
            all.push((parameter, factor));
        }
        Ok(all)
    }
}
