//! From the instrument of one key to the instruments of all: what a grading does to an instrument file.
//!
//! It changes the file's numbers and not those in SI units, because a key's instrument is then a file like any other:
//! it is checked by the same reader, every number says where it comes from, and it can be written down, measured and
//! regulated. [`graded_text`] is that file; [`GradedDocument`] reads the same instrument from the base's parsed text,
//! without writing the key's.

use std::collections::BTreeMap;

use toml_edit::{Array, DocumentMut, Item, value};

use super::grading_curve::GradingCurve;
use super::{Keyboard, is_sharp, note_name};
use crate::instrument::convert::convert;
use crate::instrument::edit::{cite, find, numbers, set, source_name};
use crate::instrument::from_toml::{Document, Replaced};
use crate::instrument::reader::MAX_TITLE_LENGTH;
use crate::instrument::{FileNumber, Instrument};
use crate::parameter::Quantity;

/// Who the source of graded numbers is, in the instrument's own list of sources.
const AUTHOR: &str = "erard keyboard";
/// The source's name, unless it is taken.
const SOURCE: &str = "graded";
/// Digits to which graded numbers are written: a part in a million.
const DIGITS: usize = 6;
/// The numbers of a body that an added mass changes.
pub(super) const MASS_NUMBERS: [FileNumber; 3] =
    [FileNumber::BODY_MASS, FileNumber::BODY_INERTIA, FileNumber::BODY_CENTER];

/// A quantity that differs from key to key.
#[derive(Debug, Clone, PartialEq)]
pub struct Grading {
    /// Name, for people.
    pub name: String,
    /// The graded numbers.
    pub graded: Graded,
    /// By how much over the keyboard.
    pub curve: GradingCurve,
}

/// Tables of the instrument that some keys do not have.
#[derive(Debug, Clone, PartialEq)]
pub struct Absence {
    /// Name, for people.
    pub name: String,
    /// Each by its list and name in the instrument file, as in `string.right`, and its own name where it stands in
    /// another, as in `string.right.damper`.
    pub tables: Vec<String>,
    /// The first and the last key without them.
    pub keys: [usize; 2],
}

/// The numbers that a grading changes.
#[derive(Debug, Clone, PartialEq)]
pub enum Graded {
    /// A point mass, g, is added to a body.
    AddedMass {
        /// The body.
        body: String,
        /// Where, in the body's own frame, mm.
        at_mm: [f64; 2],
    },
    /// Numbers are multiplied.
    Factor {
        /// Their dotted paths in the instrument file.
        numbers: Vec<String>,
    },
    /// Points are moved, mm.
    Shift {
        /// Their dotted paths in the instrument file.
        points: Vec<String>,
        /// The unit direction of a positive shift.
        direction: [f64; 2],
    },
}

impl Graded {
    /// Physical quantity of a point of the grading's curve.
    #[must_use]
    pub fn quantity(&self) -> Quantity {
        match self {
            Graded::AddedMass { .. } => Quantity::Mass,
            Graded::Factor { .. } => Quantity::Number,
            Graded::Shift { .. } => Quantity::Length,
        }
    }
}

/// The name of a key's instrument.
fn title(keyboard: &Keyboard, key: usize) -> String {
    format!("{}, key {key} ({})", keyboard.name, note_name(key))
}

/// The tables that a key lacks.
fn absent(keyboard: &Keyboard, key: usize) -> Vec<&str> {
    let absent = keyboard.absences.iter().filter(|absence| (absence.keys[0]..=absence.keys[1]).contains(&key));
    absent.flat_map(|absence| &absence.tables).map(String::as_str).collect()
}

/// The text of a key's instrument file, from the base instrument's. Numbers that the key does not change keep their
/// bits and their sources. `None` if a number that is graded is not there.
pub(super) fn graded_text(keyboard: &Keyboard, mut document: DocumentMut, key: usize) -> Option<String> {
    document["name"] = value(title(keyboard, key));
    // The reader refuses what is no key.
    document["key"] = value(i64::try_from(key).unwrap_or(i64::MAX));
    if let Some(roles) = document.get_mut("roles").and_then(Item::as_table_like_mut) {
        // A file that says nothing has a natural.
        if is_sharp(key) {
            roles.insert("sharp", value(true));
        } else {
            roles.remove("sharp");
        }
    }
    for table in absent(keyboard, key) {
        remove(&mut document, table)?;
    }
    let mut old = |path: &str| numbers(find(document.as_table_mut(), &segments(path))?, path);
    let changed = Changed::of(keyboard, key, &mut old)?;
    let title =
        format!("Graded for key {key} from the instrument of key {}, by {}", keyboard.base_key, keyboard.file_name);
    changed.write(&mut document, key, &title)?;
    Some(document.to_string())
}

/// The base instrument's file, parsed once for all keys.
pub(super) struct GradedDocument<'a> {
    keyboard: &'a Keyboard,
    document: Document<'a>,
}

impl<'a> GradedDocument<'a> {
    /// `None` if the base's text is not TOML.
    pub(super) fn parse(keyboard: &'a Keyboard) -> Option<Self> {
        Some(GradedDocument { keyboard, document: Document::parse(&keyboard.base_text).ok()? })
    }

    /// The instrument of [`graded_text`]. `None` where that has a fault.
    pub(super) fn instrument(&'a self, key: usize) -> Option<Instrument> {
        let GradedDocument { keyboard, document } = self;
        let mut replaced = Replaced::default();
        for table in absent(keyboard, key) {
            document.remove(table, &mut replaced)?;
        }
        let changed = Changed::of(keyboard, key, &mut |path| document.numbers(path))?;
        for (path, change) in &changed.0 {
            document.replace(path, &change.written(), &mut replaced)?;
        }
        let (mut instrument, _) = convert(&document.read(&replaced).ok()?).ok()?;
        instrument.fields.name = title(keyboard, key);
        if instrument.name.chars().count() > MAX_TITLE_LENGTH {
            return None;
        }
        instrument.fields.roles.is_sharp = document.find("roles").is_some() && is_sharp(key);
        instrument.fields.origin.key = Some(key);
        Some(instrument)
    }
}

/// Takes a table out of its list; `None` if it is not there.
fn remove(document: &mut DocumentMut, path: &str) -> Option<()> {
    let mut segments = path.splitn(3, '.');
    let (list, name, within) = (segments.next()?, segments.next()?, segments.next());
    let tables = document.get_mut(list)?.as_array_of_tables_mut()?;
    let place = tables.iter().position(|table| table.get("name").and_then(Item::as_str) == Some(name))?;
    match within {
        None => {
            tables.remove(place);
        }
        Some(key) => {
            tables.get_mut(place)?.remove(key)?;
        }
    }
    Some(())
}

/// The numbers that a key changes, by path, with what they were and which gradings changed them.
#[derive(Default)]
struct Changed(BTreeMap<String, Change>);

struct Change {
    old: Vec<f64>,
    new: Vec<f64>,
    by: Vec<String>,
}

impl Change {
    /// The new numbers as they are written.
    fn written(&self) -> Vec<f64> {
        self.new.iter().map(|&x| significant(x)).collect()
    }
}

/// The numbers of the base instrument's file at a path.
type Old<'a> = &'a mut dyn FnMut(&str) -> Option<Vec<f64>>;

impl Changed {
    /// `None` if a number that is graded is not there.
    fn of(keyboard: &Keyboard, key: usize, old: Old<'_>) -> Option<Self> {
        // Numbers of what is not there are not graded.
        let absent = absent(keyboard, key);
        let is_there = |path: &&String| !absent.iter().any(|table| path.starts_with(&format!("{table}.")));
        let mut changed = Changed::default();
        for Grading { name, graded, curve } in &keyboard.gradings {
            let by = curve.at(key);
            match graded {
                Graded::AddedMass { body, at_mm } if by != 0.0 => {
                    changed.add_mass(old, body, by, *at_mm, name)?;
                }
                Graded::Factor { numbers } if by != 1.0 => {
                    for path in numbers.iter().filter(is_there) {
                        changed.number(old, path, name, |old| vec![old[0] * by])?;
                    }
                }
                Graded::Shift { points, direction } if by != 0.0 => {
                    for path in points.iter().filter(is_there) {
                        let moved = |old: &[f64]| vec![old[0] + by * direction[0], old[1] + by * direction[1]];
                        changed.number(old, path, name, moved)?;
                    }
                }
                _ => {}
            }
        }
        Some(changed)
    }

    /// Mass, centre of mass and inertia about the pivot (the frame's origin) of a body with a point mass more.
    fn add_mass(&mut self, old: Old<'_>, body: &str, added_g: f64, at_mm: [f64; 2], name: &str) -> Option<()> {
        let [mass, inertia, center] = MASS_NUMBERS.map(|number| number.path(body));
        let old_g = self.value(old, &mass)?[0];
        let new_g = old_g + added_g;
        self.number(old, &mass, name, |_| vec![new_g])?;
        self.number(old, &center, name, |old| {
            old.iter().zip(at_mm).map(|(old, at)| (old_g * old + added_g * at) / new_g).collect()
        })?;
        let square_m2 = 1e-6 * (at_mm[0] * at_mm[0] + at_mm[1] * at_mm[1]);
        self.number(old, &inertia, name, |old| vec![old[0] + 1e-3 * added_g * square_m2])
    }

    fn value(&self, old: Old<'_>, path: &str) -> Option<Vec<f64>> {
        self.0.get(path).map_or_else(|| old(path), |change| Some(change.new.clone()))
    }

    fn number(&mut self, old: Old<'_>, path: &str, name: &str, change: impl FnOnce(&[f64]) -> Vec<f64>) -> Option<()> {
        let before = self.value(old, path)?;
        let entry =
            self.0.entry(path.to_owned()).or_insert(Change { old: before.clone(), new: Vec::new(), by: Vec::new() });
        entry.new = change(&before);
        entry.by.push(name.to_owned());
        Some(())
    }

    fn write(&self, document: &mut DocumentMut, key: usize, title: &str) -> Option<()> {
        if self.0.is_empty() {
            return Some(());
        }
        let source = source_name(document, SOURCE, AUTHOR);
        for (path, change) in &self.0 {
            let Change { old, by, .. } = change;
            let old: Vec<String> = old.iter().map(f64::to_string).collect();
            let note = format!("{} in the file it is graded from; key {key}: {}", old.join(", "), by.join(", "));
            let item = find(document.as_table_mut(), &segments(path))?;
            match change.written()[..] {
                [single] => set(item, single, &source, &note),
                ref new => set(item, Array::from_iter(new.iter().copied()), &source, &note),
            }
        }
        cite(document, &source, title, AUTHOR);
        Some(())
    }
}

fn segments(path: &str) -> Vec<&str> {
    path.split('.').collect()
}

/// Rounded to six digits: the result does not depend on the last bits of a logarithm.
fn significant(x: f64) -> f64 {
    format!("{x:.*e}", DIGITS - 1).parse().unwrap_or(x)
}
