//! Reading linkage files: from text, from disk, or built in.

use std::path::Path;

use crate::three_lever::{Lengths, ThreeLever};

use super::case::{Design, LetOff};
use super::format::{KIND, LinkageToml};
use erard::instrument::FileError;
use erard::instrument::error::Fault;
use erard::instrument::file::{check_size, read_bytes, utf8};
use erard::instrument::from_toml::from_toml;
use erard::instrument::locate::dress;
use erard::instrument::quantity::{Num, NumberKind};
use erard::instrument::reader::{LENGTH_MM, Limits, MM_PER_M, Reader, title};
use erard::instrument::schema::schema_of;
use erard::instrument::serde_fault::serde_fault;

/// Hammer blow where a file says nothing, m: the middle of published regulation, 44 to 49 mm.
const USUAL_BLOW_M: f64 = 0.046;
/// Let-off below the string where a file says nothing, m: as the maker's guides have it for the middle of the keyboard.
pub(super) const USUAL_LET_OFF_M: f64 = 0.0015;

/// The linkages that come with the program, by name.
const BUILTIN: [(&str, &str); 2] = [
    ("c7f-like", include_str!("../linkages/c7f-like.toml")),
    ("steinway-o-like", include_str!("../linkages/steinway-o-like.toml")),
];

/// Contents of a checked linkage file.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkageFile {
    /// Name shown in summaries; the file's own name if the file states none.
    pub name: String,
    /// Levers, in SI units.
    pub levers: ThreeLever,
    /// Blow distance, from the hammer's rest to the string, m.
    pub blow_m: f64,
    /// Let-off distance, from the string down to the hammer at let-off, m.
    pub let_off_m: f64,
}

impl LinkageFile {
    /// Reads the text of a linkage file. `file_name` appears in errors, and as the name where there is none.
    ///
    /// # Errors
    /// The first thing that is wrong, with line, key, what was found and what was expected.
    pub(crate) fn parse(text: &str, file_name: &str) -> Result<Self, Box<FileError>> {
        check_size(text, file_name, "a linkage, starting with `kind = \"three-lever\"`")?;
        let file: LinkageToml =
            from_toml(text).map_err(|error| dress(file_name, text, reworded(serde_fault(&error, text))))?;
        convert(&file, file_name).map_err(|fault| dress(file_name, text, fault))
    }

    /// Reads the bytes of a linkage file, which must be UTF-8 (a byte order mark is allowed). `file_name` appears in
    /// errors, and as the name if the file states none.
    ///
    /// # Errors
    /// Returns the first fault with line, key, what was found and what is expected; also if the bytes are not UTF-8.
    pub fn parse_bytes(bytes: &[u8], file_name: &str) -> Result<Self, Box<FileError>> {
        Self::parse(utf8(bytes, file_name)?, file_name)
    }

    /// Reads a linkage file from disk.
    ///
    /// # Errors
    /// Returns the errors of [`LinkageFile::parse_bytes`], or an error if the file cannot be read.
    pub fn load(path: &Path) -> Result<Self, Box<FileError>> {
        let (name, bytes) = read_bytes(path)?;
        Self::parse_bytes(&bytes, &name)
    }

    /// Returns a built-in linkage, e.g. `c7f-like`; `None` if there is none of that name.
    pub fn builtin(name: &str) -> Option<Self> {
        let (name, text) = BUILTIN.iter().find(|(known, _)| *known == name)?;
        // A test reads every one of them.
        Self::parse(text, name).ok()
    }

    /// Returns the names of the built-in linkages.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// Returns the TOML text of a built-in linkage; `None` if there is none of that name.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Returns the design: the levers and their let-off.
    ///
    /// # Errors
    /// Returns an error if the levers do not reach each other at rest.
    pub fn design(&self) -> Result<Design, crate::three_lever::ThreeLeverError> {
        let rest = self.levers.assemble()?.rest_head_height();
        let below = format!("hammer head {:.1} mm below the string", self.let_off_m * MM_PER_M);
        Ok(Design {
            name: self.name.clone(),
            levers: self.levers.into(),
            let_off: Some(LetOff { head_height_m: rest + self.blow_m - self.let_off_m, name: "let-off", what: below }),
        })
    }
}

/// Returns the JSON Schema of linkage files, the content of `linkages/linkage.schema.json`.
pub fn json_schema() -> String {
    schema_of::<LinkageToml>()
}

/// What serde says, in the words of a linkage file.
fn reworded(mut fault: Fault) -> Fault {
    match fault.child_key.as_deref() {
        Some("format" | "body") => {
            fault.message = "this key belongs to an instrument, and a linkage is expected here".to_owned();
            fault.expected = format!("`kind = \"{KIND}\"`, or the file given as an instrument");
        }
        Some("kind") if fault.message.ends_with("missing") => fault.expected = format!("`kind = \"{KIND}\"`"),
        Some(table @ ("lengths_mm" | "key" | "hammer")) if fault.message.ends_with("missing") => {
            fault.expected = format!("a table [{table}]");
        }
        Some(key) if key.starts_with('L') && fault.message.ends_with("missing") => {
            fault.expected = format!("`{key} = ...`, a length in mm");
        }
        _ => {}
    }
    fault
}

fn convert(file: &LinkageToml, file_name: &str) -> Result<LinkageFile, Fault> {
    if file.kind.as_str() != KIND {
        return Err(Fault::at(file.kind.span(), "not a kind of linkage that is known", format!("\"{KIND}\"")));
    }
    let mut reader = Reader::new(&file.sources);
    let mut lengths = [0.0; 10];
    for (metres, length) in lengths.iter_mut().zip(file.lengths_mm.all()) {
        *metres = reader.scalar(length, LENGTH_MM)? / MM_PER_M;
    }
    let positive = Limits::between(1e-3, 1e4, "mm");
    let levers = ThreeLever {
        lengths: Lengths::from(lengths),
        key_front: reader.scalar(&file.key.front_mm, positive)? / MM_PER_M,
        key_rest: reader.scalar(&file.key.rest_deg, Limits::symmetric(360.0, "degrees"))?.to_radians(),
        head: reader.point_m(&file.hammer.head_mm, LENGTH_MM)?,
    };
    let (mut blow_m, mut let_off_m) = (USUAL_BLOW_M, USUAL_LET_OFF_M);
    if let Some(regulation) = &file.regulation {
        if let Some(blow) = &regulation.blow_mm {
            blow_m = reader.scalar(blow, positive)? / MM_PER_M;
        }
        if let Some(let_off) = &regulation.let_off_mm {
            let_off_m = reader.scalar(let_off, Limits::up_to(1e4, "mm"))? / MM_PER_M;
        }
        if let_off_m >= blow_m {
            let span = |number: &Option<Num<_>>| number.as_ref().map(value_span);
            let at = span(&regulation.let_off_mm).or(regulation.blow_mm.as_ref().map(value_span));
            return Err(Fault::at(
                at.unwrap_or_else(|| regulation.span()),
                "the hammer would be let off before it moves",
                format!("a let-off distance below the blow, {} mm", blow_m * MM_PER_M),
            ));
        }
    }
    let name = file.name.as_ref().map_or_else(|| Ok(file_name.to_owned()), |name| title(name, "a linkage"))?;
    Ok(LinkageFile { name, levers, blow_m, let_off_m })
}

fn value_span<T: NumberKind>(number: &Num<T>) -> std::ops::Range<usize> {
    number.value_span()
}
