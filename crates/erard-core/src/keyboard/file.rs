//! Reading keyboard files: from text, from disk, or built in.

use std::path::{Path, PathBuf};

use toml::de::DeTable;
use toml_edit::{DocumentMut, Item};

use super::format::{AbsentToml, AddedMassToml, FORMAT, FactorToml, KeyboardToml, PointToml, ShiftToml};
use super::grading::{Absence, Graded, Grading, MASS_NUMBERS};
use super::grading_curve::{Between, GradingCurve, GradingPoint};
use super::{KEYS, Keyboard};
use crate::files::format_fault;
use crate::instrument::convert::key_number;
use crate::instrument::edit::{find, numbers};
use crate::instrument::error::Fault;
use crate::instrument::file::{check_size, read_bytes, utf8, whole_file};
use crate::instrument::from_toml::from_toml;
use crate::instrument::locate::dress;
use crate::instrument::quantity::{At, NumberKind};
use crate::instrument::reader::{DIRECTION, LENGTH_MM, Reader, title};
use crate::instrument::schema::schema_of;
use crate::instrument::serde_fault::serde_fault;
use crate::instrument::{FileError, Instrument, InstrumentFile};
use crate::key::key_named;

/// The keyboards that come with the program, by name.
const BUILTIN: [(&str, &str); 3] = [
    ("concert-grand", include_str!("../../keyboards/concert-grand.toml")),
    ("heavy-touch", include_str!("../../keyboards/heavy-touch.toml")),
    ("concert-grand-strings", include_str!("../../keyboards/concert-grand-strings.toml")),
];

/// There is no built-in keyboard of that name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no built-in keyboard `{name}`; built in are {}", Keyboard::builtin_names().collect::<Vec<_>>().join(", "))]
pub struct UnknownKeyboard {
    /// The name that was asked for.
    pub name: String,
}

impl Keyboard {
    /// Reads the text of a keyboard file. `file_name` appears in errors only; an instrument that is not built in is
    /// looked for in `folder`.
    ///
    /// # Errors
    /// The first thing that is wrong in it or in the instrument's file, with line, key, what was found and what was
    /// expected.
    pub fn parse(text: &str, file_name: &str, folder: &Path) -> Result<Self, Box<FileError>> {
        let file = Self::read(text, file_name)?;
        let base = file.instrument.as_str();
        let wrong = |message: String| dress(file_name, text, Fault::at(file.instrument.span(), message, instruments()));
        let (base_path, base_name, base_text) = match Instrument::builtin_text(base) {
            Some(text) => (None, base.to_owned(), text.to_owned()),
            None => {
                let path = folder.join(base);
                let (name, bytes) = read_bytes(&path).map_err(|error| wrong(error.message.clone()))?;
                // A base that is no instrument is that file's own fault. But what a keyboard file points to outside its
                // folder may be anything, and nobody asked to see it: not a word of that is shown.
                let foreign = !is_within(&path, folder);
                let hidden = |error: Box<FileError>| match foreign {
                    false => error,
                    true => wrong(format!(
                        "no instrument: `erard check` says of that file what is wrong (line {})",
                        error.line
                    )),
                };
                let text = utf8(&bytes, &name).map_err(hidden)?.to_owned();
                InstrumentFile::parse(&text, &name).map_err(hidden)?;
                (Some(path), name, text)
            }
        };
        Self::around_base(file, [text, file_name], base_path, &base_name, base_text)
    }

    /// Reads the text of a keyboard file whose base instrument is this text, whatever the file calls it: both are kept
    /// together elsewhere. `file_name` appears in errors only.
    ///
    /// # Errors
    /// As [`Keyboard::parse`].
    pub fn parse_around(text: &str, file_name: &str, base_text: &str) -> Result<Self, Box<FileError>> {
        let file = Self::read(text, file_name)?;
        let base_name = file.instrument.to_string();
        InstrumentFile::parse(base_text, &base_name)?;
        Self::around_base(file, [text, file_name], None, &base_name, base_text.to_owned())
    }

    fn read(text: &str, file_name: &str) -> Result<KeyboardToml, Box<FileError>> {
        check_size(text, file_name, "a keyboard, starting with its `format`")?;
        from_toml(text).map_err(|error| dress(file_name, text, reworded(serde_fault(&error, text), text)))
    }

    fn around_base(
        file: KeyboardToml,
        [text, file_name]: [&str; 2],
        base_path: Option<PathBuf>,
        base_name: &str,
        base_text: String,
    ) -> Result<Self, Box<FileError>> {
        let mut base: DocumentMut =
            base_text.parse().map_err(|error| whole_file(base_name, format!("cannot be edited: {error}"), ""))?;
        let (base_key, gradings, absences) =
            convert(&file, &mut base).map_err(|fault| dress(file_name, text, fault))?;
        Ok(Keyboard {
            name: file.name.trim().to_owned(),
            description: file.description.unwrap_or_default(),
            file_name: file_name.to_owned(),
            base_text,
            base_path,
            base_key,
            gradings,
            absences,
            sources: file.sources,
        })
    }

    /// Reads a keyboard file from disk.
    ///
    /// # Errors
    /// As [`Keyboard::parse`], and where the file cannot be read or is not UTF-8.
    pub fn load(path: &Path) -> Result<Self, Box<FileError>> {
        let (name, bytes) = read_bytes(path)?;
        Self::parse_bytes(&bytes, &name, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads the bytes of a keyboard file, which must be UTF-8 (a byte order mark is allowed).
    ///
    /// # Errors
    /// As [`Keyboard::parse`], and where the bytes are not UTF-8.
    pub fn parse_bytes(bytes: &[u8], file_name: &str, folder: &Path) -> Result<Self, Box<FileError>> {
        Self::parse(utf8(bytes, file_name)?, file_name, folder)
    }

    /// A built-in keyboard, e.g. `concert-grand`.
    ///
    /// # Errors
    /// [`UnknownKeyboard`]: there is none of that name.
    pub fn builtin(name: &str) -> Result<Self, UnknownKeyboard> {
        // A test reads every one of them.
        let found = Self::builtin_text(name).and_then(|text| Self::parse(text, name, Path::new("")).ok());
        found.ok_or_else(|| UnknownKeyboard { name: name.to_owned() })
    }

    /// The TOML text of a built-in keyboard.
    #[must_use]
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// The names that [`Keyboard::builtin`] knows.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }
}

/// Whether the text of a TOML file says that it is a keyboard, of whatever version.
#[must_use]
pub fn is_keyboard(text: &str) -> bool {
    format_of(text).is_some_and(|format| format.starts_with("erard-keyboard"))
}

fn format_of(text: &str) -> Option<String> {
    // Without a document to edit, which takes several times the memory of what is read.
    let document = DeTable::parse(text).ok()?;
    document.get_ref().get("format")?.get_ref().as_str().map(str::to_owned)
}

/// What serde says, in the words of a keyboard file.
fn reworded(mut fault: Fault, text: &str) -> Fault {
    if format_of(text).is_some_and(|format| format.starts_with("erard-instrument")) {
        fault.message = "this key belongs to an instrument, and a keyboard is expected here".to_owned();
        fault.expected = format!("`format = \"{FORMAT}\"`, or the file given as an instrument");
    }
    fault
}

/// The JSON Schema of keyboard files: what `keyboards/keyboard.schema.json` holds.
#[must_use]
pub fn json_schema() -> String {
    schema_of::<KeyboardToml>()
}

/// Whether a path leads to a file in a folder or below it, by whatever links.
fn is_within(path: &Path, folder: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    matches!((path.canonicalize(), folder.canonicalize()), (Ok(path), Ok(folder)) if path.starts_with(&folder))
}

fn instruments() -> String {
    let names: Vec<&str> = Instrument::builtin_names().collect();
    format!("an instrument file beside this one, or one of {}", names.join(", "))
}

/// The key of the base instrument, and the gradings.
fn convert(file: &KeyboardToml, base: &mut DocumentMut) -> Result<(usize, Vec<Grading>, Vec<Absence>), Fault> {
    if file.format.as_str() != FORMAT {
        let fault = format_fault(file.format.as_str(), FORMAT);
        return Err(Fault::at(file.format.span(), fault, format!("\"{FORMAT}\"")));
    }
    title(&file.name, "a keyboard")?;
    let base_key = key_number(&file.instrument_key)?;
    let own = base.get("key").and_then(Item::as_value).map(|key| key.as_str().map_or(key.to_string(), str::to_owned));
    if let Some(own) = own
        && key_named(&own) != Some(base_key)
    {
        let own = own.trim();
        let expected = format!("{own}, the `key` of the instrument's file");
        return Err(Fault::at(file.instrument_key.span(), "the instrument is that of another key", expected));
    }
    let mut reader = Reader::new(&file.sources);
    let mut gradings = Vec::new();
    for grading in &file.added_mass {
        gradings.push(added_mass(grading, &mut reader, base, base_key)?);
    }
    for grading in &file.factor {
        gradings.push(factor(grading, &reader, base, base_key)?);
    }
    for grading in &file.shift {
        gradings.push(shift(grading, &mut reader, base, base_key)?);
    }
    let absences = file.absent.iter().map(|absent| absence(absent, base, base_key)).collect::<Result<_, _>>()?;
    Ok((base_key, gradings, absences))
}

fn absence(file: &AbsentToml, base: &mut DocumentMut, base_key: usize) -> Result<Absence, Fault> {
    for path in &file.tables {
        let segments: Vec<&str> = path.split('.').collect();
        let listed = base.get(segments[0]).is_some_and(Item::is_array_of_tables);
        let named = segments.len() > 1 && find(base.as_table_mut(), &[segments[0], segments[1], "name"]).is_some();
        let within = match segments[..] {
            [_, _] => true,
            [_, _, _] => find(base.as_table_mut(), &segments).is_some_and(|item| item.is_table_like()),
            _ => false,
        };
        if !(listed && named && within) {
            let expected = "the list and the name of a table of the instrument's file, as in `string.right`, or of a table in it, as in `string.right.damper`";
            return Err(Fault::at(path.span(), "the instrument has no such table", expected));
        }
    }
    let [first, last] = &*file.keys;
    let keys = [first, last].map(|key| key_named(&key.0).unwrap_or(0));
    if !(keys[0] >= 1 && keys[0] <= keys[1] && keys[1] <= KEYS) {
        let expected = format!("[first, last] from 1 to {KEYS}");
        return Err(Fault::at(file.keys.span(), "not keys of a piano", expected));
    }
    if (keys[0]..=keys[1]).contains(&base_key) {
        let expected = format!("keys without {base_key}, the `instrument_key`");
        return Err(Fault::at(file.keys.span(), "the instrument's own key would differ from the instrument", expected));
    }
    Ok(Absence {
        name: title(&file.name, "an absence")?,
        tables: file.tables.iter().map(|path| path.to_string()).collect(),
        keys,
    })
}

fn added_mass(
    file: &AddedMassToml,
    reader: &mut Reader,
    base: &mut DocumentMut,
    base_key: usize,
) -> Result<Grading, Fault> {
    for number in MASS_NUMBERS {
        let path = number.path(&file.body);
        if find(base.as_table_mut(), &path.split('.').collect::<Vec<_>>()).is_none() {
            return Err(Fault::at(file.body.span(), "no such body", "the name of a body of the instrument"));
        }
    }
    let at_mm = reader.pair(&file.at_mm, LENGTH_MM)?;
    let curve = curve(&file.mass_g, reader, base_key, 0.0, Between::Linear)?;
    Ok(Grading {
        name: title(&file.name, "a grading")?,
        graded: Graded::AddedMass { body: file.body.to_string(), at_mm },
        curve,
    })
}

fn factor(file: &FactorToml, reader: &Reader, base: &mut DocumentMut, base_key: usize) -> Result<Grading, Fault> {
    let numbers = file.numbers.iter().map(|path| path_of(path, base, 1)).collect::<Result<_, _>>()?;
    let curve = curve(&file.factor, reader, base_key, 1.0, Between::Logarithmic)?;
    Ok(Grading { name: title(&file.name, "a grading")?, graded: Graded::Factor { numbers }, curve })
}

fn shift(file: &ShiftToml, reader: &mut Reader, base: &mut DocumentMut, base_key: usize) -> Result<Grading, Fault> {
    let points = file.points.iter().map(|path| path_of(path, base, 2)).collect::<Result<_, _>>()?;
    let direction = reader.direction(&file.direction, DIRECTION)?;
    let curve = curve(&file.by_mm, reader, base_key, 0.0, Between::Linear)?;
    Ok(Grading { name: title(&file.name, "a grading")?, graded: Graded::Shift { points, direction }, curve })
}

/// A path to this many numbers in the instrument.
fn path_of(path: &At<String>, base: &mut DocumentMut, count: usize) -> Result<String, Fault> {
    let what = if count == 1 { "a number" } else { "a point" };
    let segments: Vec<&str> = path.split('.').collect();
    match find(base.as_table_mut(), &segments).and_then(|item| numbers(item, path)) {
        Some(found) if found.len() == count => Ok(path.to_string()),
        _ => Err(Fault::at(
            path.span(),
            format!("the instrument has no {} there", &what[2..]),
            format!("the dotted path of {what} in the instrument's file, as in `zone.string.felt.exponent`"),
        )),
    }
}

/// A curve that is `neutral` at the base instrument's own key.
fn curve<T: NumberKind>(
    file: &At<Vec<PointToml<T>>>,
    reader: &Reader,
    base_key: usize,
    neutral: f64,
    between: Between,
) -> Result<GradingCurve, Fault> {
    let mut points: Vec<GradingPoint> = Vec::new();
    for point in file.iter() {
        let key = key_number(&point.key)?;
        if points.last().is_some_and(|last| last.key >= key) {
            return Err(Fault::at(point.key.span(), "the points stand out of order", "keys that ascend"));
        }
        let value = point.value.numbers()[0];
        if !value.is_finite() {
            return Err(Fault::at(point.value.span(), "not a finite number", T::EXPECTED));
        }
        if between == Between::Logarithmic && value <= 0.0 {
            return Err(Fault::at(point.value.span(), "a factor must be greater than 0", T::EXPECTED));
        }
        let citation = match (&point.source, point.certainty) {
            (Some(source), Some(certainty)) => Some(reader.citation(source, certainty, None, point.note.as_deref())?),
            (Some(source), None) => {
                return Err(Fault::at(source.span(), "a source without a certainty", "`certainty = ...` beside it"));
            }
            (None, _) => None,
        };
        points.push(GradingPoint { key, value, citation });
    }
    let curve = GradingCurve { points, between };
    if curve.at(base_key) == neutral {
        return Ok(curve);
    }
    // Not a number, too, where there are no points.
    let expected = format!("{neutral} at key {base_key}, the `instrument_key`");
    Err(Fault::at(file.span(), "the instrument's own key would differ from the instrument", expected)
        .found(format!("{} at key {base_key}", curve.at(base_key))))
}
