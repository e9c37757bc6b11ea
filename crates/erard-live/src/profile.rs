//! The profile of a device: its sensors' law and the two stops of each key.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use erard::instrument::from_toml::from_toml;
use erard::keyboard::KEYS;
use serde::Deserialize;

use crate::contact_table::rounded;
use crate::contacts::{ContactFault, ContactLaw, MAX_CONTACTS, Point, SpeedTable};
pub use crate::converter::{Converter, Stops};
use crate::hammers::HammerKey;
pub use crate::hammers::Release;
use crate::sensor::Law;

/// Format name, the first entry of a profile.
pub const FORMAT: &str = "erard-sensors/1";

/// The profile of a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// What its sensors sense.
    pub sensed: Sensed,
    /// The sensors' law.
    pub law: Law,
    /// The sensed travel between the stops, m.
    pub travel_m: f64,
    /// Whether polyphonic pressure is the key's depth.
    pub pressure_is_depth: bool,
    /// The stops of keys, by number from 1.
    pub keys: BTreeMap<usize, Stops>,
}

/// Kind of a device's sensors.
#[derive(Debug, Clone, PartialEq)]
pub enum Sensed {
    /// The whole travel of each key.
    Keys,
    /// Two or three contacts under each key. Law, travel and stops are not used.
    Contacts(Box<ContactLaw>),
    /// The travel of each hammer's head from its rest to the string or the stop rail, and, where there is a second
    /// sensor at the key or the damper, what it senses and its stops, by the key's number from 1.
    Hammers(Option<(Release, BTreeMap<usize, Stops>)>),
}

/// Fault of a profile.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileFault {
    /// It cannot be read.
    #[error("line {line}: {what}")]
    Toml {
        /// Line, from 1.
        line: usize,
        /// Fault, in words.
        what: String,
    },
    /// A number or word.
    #[error("`{key}` is {found}; expected {expected}")]
    Value {
        /// Key of the entry.
        key: String,
        /// The text found.
        found: String,
        /// Expected text.
        expected: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    sensed: Option<String>,
    travel_mm: Option<f64>,
    #[serde(default)]
    polyphonic_pressure_is_depth: bool,
    law: Option<Law>,
    contacts: Option<ContactsEntry>,
    release: Option<ReleaseEntry>,
    #[serde(default)]
    key: Vec<KeyEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ReleaseEntry {
    travel_mm: f64,
    off_mm: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ContactsEntry {
    depths_mm: Vec<f64>,
    scan_period_us: f64,
    #[serde(default)]
    scan_phases_us: Vec<f64>,
    bounce_ms: f64,
    off: usize,
    table: Vec<TableEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TableEntry {
    from: usize,
    points: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyEntry {
    number: usize,
    rest: f64,
    pressed: f64,
    release_rest: Option<f64>,
    release_pressed: Option<f64>,
}

impl Profile {
    /// Reads a profile.
    ///
    /// # Errors
    /// [`ProfileFault`].
    pub fn parse(text: &str) -> Result<Self, ProfileFault> {
        let file: File =
            from_toml(text).map_err(|error| ProfileFault::Toml { line: error.line(text), what: error.message })?;
        let wrong = |key: &str, found: String, expected| ProfileFault::Value { key: key.to_owned(), found, expected };
        if file.format != FORMAT {
            return Err(wrong("format", format!("\"{}\"", file.format), "\"erard-sensors/1\""));
        }
        if let Some(contacts) = file.contacts {
            if file.travel_mm.is_some() || file.law.is_some() || file.release.is_some() || !file.key.is_empty() {
                let what = "contacts alone, without `travel_mm`, `law` and `key`";
                return Err(wrong("contacts", "beside a travel, a law or keys".into(), what));
            }
            return Ok(Profile::of_contacts(contacts.law()?));
        }
        let missing = || "missing".to_owned();
        let law = file.law.ok_or_else(|| wrong("law", missing(), "a [law], or [contacts]"))?;
        let travel_mm = file.travel_mm.ok_or_else(|| wrong("travel_mm", missing(), "a number from 0.5 to 100"))?;
        if !(0.5..=100.0).contains(&travel_mm) {
            return Err(wrong("travel_mm", travel_mm.to_string(), "a number from 0.5 to 100"));
        }
        law.check().map_err(|fault| wrong("law", fault.to_string(), "a sound law"))?;
        let is_hammers = match file.sensed.as_deref() {
            None | Some("keys") => false,
            Some("hammers") => true,
            Some(other) => return Err(wrong("sensed", format!("\"{other}\""), "\"keys\" or \"hammers\"")),
        };
        let (mut keys, mut releases) = (BTreeMap::new(), BTreeMap::new());
        for KeyEntry { number, rest, pressed, release_rest, release_pressed } in file.key {
            if !(1..=KEYS).contains(&number) || keys.contains_key(&number) {
                return Err(wrong("key.number", number.to_string(), "1 to 88, each once"));
            }
            if !(rest.is_finite() && pressed.is_finite() && rest != pressed) {
                let found = format!("{rest} up and {pressed} down");
                return Err(wrong(&format!("key {number}"), found, "two different finite readings"));
            }
            keys.insert(number, Stops { rest, pressed });
            match (release_rest, release_pressed) {
                (None, None) => {}
                (Some(rest), Some(pressed)) if rest != pressed && rest.is_finite() && pressed.is_finite() => {
                    releases.insert(number, Stops { rest, pressed });
                }
                (rest, pressed) => {
                    let found = format!("{rest:?} up and {pressed:?} down");
                    return Err(wrong(&format!("release of key {number}"), found, "two different finite readings"));
                }
            }
        }
        if keys.is_empty() {
            return Err(wrong("key", "missing".into(), "at least one [[key]]"));
        }
        let (travel_m, pressure_is_depth) = (1e-3 * travel_mm, file.polyphonic_pressure_is_depth);
        let release = file.release.map(|ReleaseEntry { travel_mm, off_mm }| {
            let is_sound = (0.5..=100.0).contains(&travel_mm) && off_mm > 0.0 && off_mm < travel_mm;
            let found = || format!("travel_mm {travel_mm}, off_mm {off_mm}");
            let release = Release { travel_m: 1e-3 * travel_mm, off_m: 1e-3 * off_mm };
            let expected = "a travel of 0.5 to 100 mm, and off_mm within it";
            is_sound.then_some(release).ok_or_else(|| wrong("release", found(), expected))
        });
        let release = release.transpose()?;
        if release.is_some() == releases.is_empty() || release.is_some() && !is_hammers {
            let expected =
                "[release] and the keys' release_rest and release_pressed together, with sensed = \"hammers\"";
            return Err(wrong("release", format!("of {} keys", releases.len()), expected));
        }
        let hammers = Sensed::Hammers(release.map(|release| (release, releases)));
        let sensed = if is_hammers { hammers } else { Sensed::Keys };
        Ok(Profile { sensed, law, travel_m, pressure_is_depth, keys })
    }

    /// The profile of a device with contacts.
    #[must_use]
    pub fn of_contacts(law: ContactLaw) -> Self {
        let sensed = Sensed::Contacts(Box::new(law));
        Profile { sensed, law: Law::Linear {}, travel_m: 0.0, pressure_is_depth: false, keys: BTreeMap::new() }
    }

    /// Its text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = format!("format = \"{FORMAT}\"\n");
        let mm = |m: f64| (1e9 * m).round() / 1e6;
        if let Sensed::Contacts(law) = &self.sensed {
            out.push_str(&contacts_text(law));
            return out;
        }
        // Nothing that is written to a string fails.
        let release = match &self.sensed {
            Sensed::Hammers(release) => {
                let _ =
                    writeln!(out, "# Hammers: rest and pressed are a head's readings at its rest and at its string.");
                let _ = writeln!(out, "sensed = \"hammers\"");
                release.as_ref()
            }
            _ => None,
        };
        let _ = writeln!(out, "# The sensed place's way between its two stops.");
        let _ = writeln!(out, "travel_mm = {}", mm(self.travel_m));
        let _ = writeln!(out, "# Whether polyphonic pressure of this device is the key's depth, not a force.");
        let _ = writeln!(out, "polyphonic_pressure_is_depth = {}\n\n[law]", self.pressure_is_depth);
        let _ = match &self.law {
            Law::Linear {} => writeln!(out, "kind = \"linear\""),
            Law::Cny70 {} => writeln!(out, "kind = \"cny70\""),
            Law::Hall { nearest_mm, at_rest } => {
                writeln!(out, "kind = \"hall\"\nnearest_mm = {nearest_mm}\nat_rest = {at_rest}")
            }
            Law::Table { points } => {
                writeln!(out, "kind = \"table\"\n# Share of the reading's range, share of the travel.")
                    .and_then(|()| writeln!(out, "points = {points:?}"))
            }
        };
        if let Some((Release { travel_m, off_m }, _)) = release {
            let _ =
                writeln!(out, "\n# The second sensor, at the key or the damper, and its travel where the damper lies.");
            let _ = writeln!(out, "[release]\ntravel_mm = {}\noff_mm = {}", mm(*travel_m), mm(*off_m));
        }
        for (number, Stops { rest, pressed }) in &self.keys {
            let _ = writeln!(out, "\n[[key]]\nnumber = {number}\nrest = {rest}\npressed = {pressed}");
            if let Some(Stops { rest, pressed }) = release.and_then(|(_, stops)| stops.get(number)) {
                let _ = writeln!(out, "release_rest = {rest}\nrelease_pressed = {pressed}");
            }
        }
        out
    }

    /// Returns the converter of a key's readings; `None` for a key without stops.
    #[must_use]
    pub fn converter(&self, key: usize) -> Option<Converter<f64, Vec<[f64; 2]>>> {
        let stops = *self.keys.get(&key)?;
        Some(Converter::new(self.law.clone(), stops, self.travel_m))
    }

    /// Returns a hammer at rest; `None` for a key without stops, and for a profile of other sensors.
    #[must_use]
    pub fn hammer(&self, key: usize) -> Option<HammerKey<Vec<[f64; 2]>>> {
        let Sensed::Hammers(release) = &self.sensed else { return None };
        let release = release.as_ref().and_then(|(release, stops)| {
            Some((Converter::new(Law::Linear {}, *stops.get(&key)?, release.travel_m), *release))
        });
        Some(HammerKey::new(self.converter(key)?, release))
    }
}

impl ContactsEntry {
    /// The contacts' law.
    fn law(self) -> Result<ContactLaw, ProfileFault> {
        let wrong = |key: &str, found: String, expected| ProfileFault::Value { key: key.to_owned(), found, expected };
        let count = self.depths_mm.len();
        if !(2..=MAX_CONTACTS).contains(&count) {
            return Err(wrong("contacts.depths_mm", format!("{count} depths"), "two or three, the upper one first"));
        }
        let phases = self.scan_phases_us.len();
        if phases != 0 && phases != count {
            return Err(wrong("contacts.scan_phases_us", format!("{phases} phases"), "one for each contact"));
        }
        let padded = |all: &[f64], unit: f64| {
            let mut padded = [0.0; MAX_CONTACTS];
            padded.iter_mut().zip(all).for_each(|(one, given)| *one = unit * given);
            padded
        };
        let mut tables: [Option<SpeedTable>; MAX_CONTACTS - 1] = [None; MAX_CONTACTS - 1];
        for TableEntry { from, points } in &self.table {
            let is_upper = (1..count).contains(from);
            let Some(table) = from.checked_sub(1).and_then(|upper| tables.get_mut(upper)).filter(|_| is_upper) else {
                return Err(wrong("contacts.table.from", from.to_string(), "a contact above the lowest one, from 1"));
            };
            let points: Vec<Point> = points.iter().map(|numbers| point(numbers)).collect::<Option<_>>().ok_or_else(
                || {
                    let expected = "[between_ms, hammer_speed_m_per_s], then from the contact to the impact, ms, and the \
                                    touch's error, counts, where they are known";
                    wrong("contacts.table.points", format!("{points:?}"), expected)
                },
            )?;
            let made = SpeedTable::new(&points);
            *table = Some(made.map_err(|fault| wrong("contacts.table.points", fault.to_string(), "a sound table"))?);
        }
        let given: Vec<SpeedTable> = tables[..count - 1].iter().flatten().copied().collect();
        let (Some(first), true) = (given.first(), given.len() == count - 1) else {
            let expected = "one for each contact above the lowest one";
            return Err(wrong("contacts.table", format!("{} tables", given.len()), expected));
        };
        let law = ContactLaw {
            depths_m: padded(&self.depths_mm, 1e-3),
            count,
            tables: std::array::from_fn(|upper| *given.get(upper).unwrap_or(first)),
            period_s: 1e-6 * self.scan_period_us,
            phases_s: padded(&self.scan_phases_us, 1e-6),
            bounce_s: 1e-3 * self.bounce_ms,
            off: self.off.wrapping_sub(1),
        };
        law.check().map_err(|fault| {
            let key = match fault {
                ContactFault::Depth(_) => "contacts.depths_mm",
                ContactFault::Off(_) => "contacts.off",
                _ => "contacts",
            };
            wrong(key, fault.to_string(), "sound contacts")
        })?;
        Ok(law)
    }
}

/// A point of a table: time between the contacts, ms, hammer speed, m/s, and, where they are known, the time from the
/// lowest contact to the impact, ms, and the error of touch, counts.
fn point(numbers: &[f64]) -> Option<Point> {
    let of = |i: usize| numbers.get(i).copied();
    let is_sound = (2..=4).contains(&numbers.len()) && numbers.iter().all(|number| number.is_finite());
    Some(Point {
        between_s: 1e-3 * of(0).filter(|_| is_sound)?,
        hammer_speed_m_per_s: of(1)?,
        delay_s: 1e-3 * of(2).unwrap_or(0.0),
        touch_counts: of(3).unwrap_or(0.0),
    })
}

fn contacts_text(law: &ContactLaw) -> String {
    let list = |all: &[f64], unit: f64| all[..law.count].iter().map(|one| rounded(*one, unit)).collect::<Vec<_>>();
    let mut out = String::from("\n[contacts]\n# Depths of the key's front at which they close, the upper one first.\n");
    // Nothing that is written to a string fails.
    let _ = writeln!(out, "depths_mm = {:?}", list(&law.depths_m, 1e-3));
    let _ = writeln!(out, "# Period of the scan, and how long after its time stamp each contact is read.");
    let _ = writeln!(out, "scan_period_us = {:?}", rounded(law.period_s, 1e-6));
    let _ = writeln!(out, "scan_phases_us = {:?}", list(&law.phases_s, 1e-6));
    let _ = writeln!(out, "# Changes within this time after an edge are bounces.");
    let _ = writeln!(out, "bounce_ms = {:?}", rounded(law.bounce_s, 1e-3));
    let _ = writeln!(out, "# A note ends as this contact opens.\noff = {}", law.off + 1);
    for (upper, table) in law.tables().iter().enumerate() {
        let points: Vec<[f64; 4]> = table
            .points()
            .iter()
            .map(|point| {
                let Point { between_s, hammer_speed_m_per_s, delay_s, touch_counts } = *point;
                let [between_ms, delay_ms] = [between_s, delay_s].map(|s| rounded(s, 1e-3));
                [between_ms, rounded(hammer_speed_m_per_s, 1.0), delay_ms, rounded(touch_counts, 1.0)]
            })
            .collect();
        let _ =
            writeln!(out, "\n# From a contact to the lowest one, a point each: time between them, ms; hammer speed,");
        let _ =
            writeln!(out, "# m/s; from the lowest contact to the impact, ms; error of touch, counts of velocity. A");
        let _ = writeln!(out, "# maker's own table replaces this line: [[ms, m/s], [ms, m/s], ...]");
        let _ = writeln!(out, "[[contacts.table]]\nfrom = {}\npoints = {points:?}", upper + 1);
    }
    out
}
