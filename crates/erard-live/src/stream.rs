//! The text that a sender writes: a header, then a line for each sample.
//!
//! ```text
//! time_us,key,raw
//! 1203340,40,3121
//! 1203340,sustain,0.75
//! ```
//!
//! Contacts send their edges: the contact, from 1 for the upper one, and whether it has closed.
//!
//! ```text
//! time_us,key,contact,state
//! 1203340,40,1,made
//! 1209341,40,2,made
//! ```
//!
//! A device that senses hammers may have a second sensor for each key, at the key or the damper: `40:release` in the
//! place of the key.
//!
//! The header names the clock (`time_s`, or `time_us` of 32 bits that wraps around) and the sensed quantity: `mm` of
//! the sensed place, `N` at the key's front, `raw` readings of a converter, or `pressure`, the polyphonic pressure 0 to
//! 127 of a device that uses it for depth. A key is a number from 1 (the lowest A) to 88, or a note (`A0`); `sustain`,
//! `sostenuto` and `soft` are pedals, from 0 (up) to 1 (down). Times do not descend; a header in between begins a new
//! clock. A sender may omit keys at rest; it sends a key off its rest at the full rate. Blank lines and lines that
//! begin with `#` are left out.

use erard::keyboard::key_named;
use erard_midi::message::{SOFT, SOSTENUTO, SUSTAIN};

/// Longest line, bytes; longer input without a line's end is discarded.
pub const MAX_LINE_LENGTH: usize = 256;

/// SensorUnit of a stream's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorUnit {
    /// Travel of the sensed place from its rest, mm, positive as the key goes down.
    Millimetres,
    /// Force on the key's front, N, down positive.
    Newtons,
    /// A converter's reading.
    Raw,
    /// Polyphonic pressure of MIDI, 0 to 127.
    Pressure,
    /// Edges of contacts.
    Contacts,
}

/// A stream's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Head {
    in_microseconds: bool,
    /// Sensed quantity.
    pub quantity: SensorUnit,
}

/// Content of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The sender's clock, s.
    pub time_s: f64,
    /// The key or pedal of the sample.
    pub of: Of,
    /// The number.
    pub value: f64,
}

/// Key or pedal of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// A key's, from 1.
    Key(usize),
    /// A key's, from 1, and one of its contacts, from 0 for the upper one; the value is 1 as it closes, 0 as it opens.
    Contact(usize, usize),
    /// A key's, from 1, by the second sensor of a device that senses hammers.
    Release(usize),
    /// A pedal's, by its controller.
    Pedal(u8),
}

/// Fault of a line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The line is not a sample.
    #[error("found `{found}`; expected three fields: time, key, value")]
    Fields {
        /// The line, cut off.
        found: String,
    },
    /// The last line ends in a number, and no line's end follows.
    #[error("found `{found}` and no line's end: its number may be cut off; expected a line's end")]
    NoEnd {
        /// The line, cut off.
        found: String,
    },
    /// A field is no finite number.
    #[error("{field} is `{found}`; expected a number")]
    Number {
        /// The field: time or value.
        field: &'static str,
        /// The text found.
        found: String,
    },
    /// The line is not an edge of a contact.
    #[error("found `{found}`; expected four fields: time, key, contact, `made` or `open`")]
    EdgeFields {
        /// The line, cut off.
        found: String,
    },
    /// There is no such contact, or no such state of one.
    #[error("{field} is `{found}`; expected {expected}")]
    Edge {
        /// The field: contact or state.
        field: &'static str,
        /// The text found.
        found: String,
        /// The texts expected.
        expected: &'static str,
    },
    /// There is no such key.
    #[error("key is `{found}`; expected 1 to 88, a note from A0 to C8, `sustain`, `sostenuto` or `soft`")]
    Key {
        /// The text found.
        found: String,
    },
    /// A row of readings has another number of cells than the header.
    #[error("{found} cells; expected {expected}, as in the header")]
    Cells {
        /// Cells of the row.
        found: usize,
        /// Cells of the header.
        expected: usize,
    },
    /// The header of rows without times is invalid.
    #[error(
        "the first line is `{found}`; expected, with a rate, the keys of the columns, such as `40,41` or `C4,40:release`, \
         or `key,raw`, and no time"
    )]
    RowsHead {
        /// The line, cut off.
        found: String,
    },
    /// The header is invalid.
    #[error(
        "the first line is `{found}`; expected a header such as `time_s,key,mm`: `time_s` or `time_us`, `key`, and `mm`, \
         `N`, `raw` or `pressure`; or `time_us,key,contact,state`"
    )]
    Head {
        /// The line, cut off.
        found: String,
    },
}

/// The beginning of the text found, without control characters.
fn cut(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(40).collect()
}

fn pedal_named(text: &str) -> Option<Of> {
    match text {
        "sustain" => Some(Of::Pedal(SUSTAIN)),
        "sostenuto" => Some(Of::Pedal(SOSTENUTO)),
        "soft" => Some(Of::Pedal(SOFT)),
        _ => None,
    }
}

/// A key by its number or note; also a whole number that a table of numbers holds as `4.0e+01`.
fn key_of(text: &str) -> Result<usize, Fault> {
    let whole = || text.parse::<f64>().ok().filter(|key| key.fract() == 0.0 && (1.0..=88.0).contains(key));
    key_named(text).or_else(|| whole().map(|key| key as usize)).ok_or_else(|| Fault::Key { found: cut(text) })
}

/// A pedal, a key, or a key's second sensor.
fn of_named(text: &str) -> Result<Of, Fault> {
    match (pedal_named(text), text.strip_suffix(":release")) {
        (Some(pedal), _) => Ok(pedal),
        (None, Some(key)) => key_of(key).map(Of::Release),
        (None, None) => key_of(text).map(Of::Key),
    }
}

impl Head {
    /// Reads a header.
    ///
    /// # Errors
    /// [`Fault::Head`].
    pub fn parse(line: &str) -> Result<Self, Fault> {
        let wrong = || Fault::Head { found: cut(line) };
        let fields: Vec<&str> = line.trim().trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        let [clock, "key", ref quantity @ ..] = fields[..] else { return Err(wrong()) };
        let in_microseconds = match clock {
            "time_s" => false,
            "time_us" => true,
            _ => return Err(wrong()),
        };
        let quantity = match quantity {
            ["mm"] => SensorUnit::Millimetres,
            ["N"] => SensorUnit::Newtons,
            ["raw"] => SensorUnit::Raw,
            ["pressure"] => SensorUnit::Pressure,
            ["contact", "state"] => SensorUnit::Contacts,
            _ => return Err(wrong()),
        };
        Ok(Head { in_microseconds, quantity })
    }
}

/// Columns of rows without times.
#[derive(Debug, Clone, PartialEq)]
enum Columns {
    /// A key, and its value.
    KeyAndValue,
    /// A value for each of these.
    Each(Vec<Of>),
}

/// Rows without times, at a fixed rate.
#[derive(Debug, Clone)]
struct Rows {
    columns: Columns,
    rate_hz: f64,
    /// Rows so far: of each key, or of all.
    counts: Vec<(Option<Of>, u64)>,
}

impl Rows {
    /// The instant of the next row, s: of a key's, or of all.
    fn time_s(&mut self, of: Option<Of>) -> f64 {
        let index = self.counts.iter().position(|(own, _)| *own == of).unwrap_or_else(|| {
            self.counts.push((of, 0));
            self.counts.len() - 1
        });
        let count = &mut self.counts[index].1;
        *count += 1;
        (*count - 1) as f64 / self.rate_hz
    }
}

/// Reads the lines after a header; remembers how often a clock of 32 bits has wrapped around.
#[derive(Debug, Clone)]
pub struct Reader {
    head: Head,
    before_us: Option<f64>,
    has_restarted: bool,
    rows: Option<Rows>,
}

impl Reader {
    /// Makes a reader for the lines after a header.
    #[must_use]
    pub fn new(head: Head) -> Self {
        Reader { head, before_us: None, has_restarted: false, rows: None }
    }

    /// Makes a reader for rows without times, such as those of a converter's log, at a rate, Hz. The header names the
    /// key of each column (`40`, `C4`, `40:release`, `sustain`), whose readings are raw; or it is `key,raw`, `key,mm`,
    /// `key,N` or `key,pressure`, and every key has a reading at each instant.
    ///
    /// # Errors
    /// [`Fault::RowsHead`].
    pub fn of_rows(line: &str, rate_hz: f64) -> Result<Self, Fault> {
        let line = line.trim().trim_start_matches('\u{feff}');
        let wrong = || Fault::RowsHead { found: cut(line) };
        let titles: Vec<&str> = line.split(',').map(str::trim).collect();
        let (head, columns) = match titles[..] {
            ["key", _] => (Head::parse(&format!("time_s,{line}")).map_err(|_| wrong())?, Columns::KeyAndValue),
            _ => {
                let all = titles.iter().map(|title| of_named(title)).collect::<Result<_, _>>();
                let quantity = SensorUnit::Raw;
                (Head { in_microseconds: false, quantity }, Columns::Each(all.map_err(|_| wrong())?))
            }
        };
        let rows = Some(Rows { columns, rate_hz, counts: Vec::new() });
        Ok(Reader { head, before_us: None, has_restarted: false, rows })
    }

    /// Reads a line with its end, as it came. At the end of a stream that breaks off nothing tells a number that was
    /// cut off (3 of 3499, a key at its bottom) from a whole one: such a line is no sample. A contact's edge ends in a
    /// word, which is whole or none.
    ///
    /// # Errors
    /// [`Fault`], with the reason: [`Fault::NoEnd`] for such a line.
    pub fn received(&mut self, line: &str) -> Result<Vec<Sample>, Fault> {
        let samples = self.samples(line)?;
        let is_whole = line.ends_with('\n') || samples.iter().all(|one| matches!(one.of, Of::Contact(..)));
        if is_whole { Ok(samples) } else { Err(Fault::NoEnd { found: cut(line) }) }
    }

    /// Reads a line of any kind: no sample for one without content, several of a row. An empty cell of a row has none.
    ///
    /// # Errors
    /// [`Fault`], with the reason.
    pub fn samples(&mut self, line: &str) -> Result<Vec<Sample>, Fault> {
        let Some(rows) = &mut self.rows else { return Ok(self.line(line)?.into_iter().collect()) };
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            return Ok(Vec::new());
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |text: &str| {
            let found = text.parse().ok().filter(|number: &f64| number.is_finite());
            found.ok_or_else(|| Fault::Number { field: "value", found: cut(text) })
        };
        match (&rows.columns, &cells[..]) {
            (Columns::KeyAndValue, [of, value]) => {
                let (of, value) = (of_named(of)?, number(value)?);
                let time_s = rows.time_s(Some(of));
                Ok(vec![Sample { time_s, of, value }])
            }
            (Columns::KeyAndValue, _) => Err(Fault::Cells { found: cells.len(), expected: 2 }),
            (Columns::Each(all), _) => {
                let all = all.clone();
                // A row that cannot be read takes its time all the same.
                let time_s = rows.time_s(None);
                if cells.len() != all.len() {
                    return Err(Fault::Cells { found: cells.len(), expected: all.len() });
                }
                let filled = all.into_iter().zip(&cells).filter(|(_, cell)| !cell.is_empty());
                filled.map(|(of, cell)| Ok(Sample { time_s, of, value: number(cell)? })).collect()
            }
        }
    }

    /// Whether the header has come again since the last question: the sender has begun anew.
    pub fn take_restart(&mut self) -> bool {
        std::mem::take(&mut self.has_restarted)
    }

    /// Sensed quantity.
    #[must_use]
    pub fn quantity(&self) -> SensorUnit {
        self.head.quantity
    }

    /// Reads a line; `None` for one without content.
    ///
    /// # Errors
    /// [`Fault`], with the reason.
    pub fn line(&mut self, line: &str) -> Result<Option<Sample>, Fault> {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            return Ok(None);
        }
        if let Ok(head) = Head::parse(line)
            && head.quantity == self.head.quantity
        {
            *self = Reader { has_restarted: true, ..Reader::new(head) };
            return Ok(None);
        }
        let fields: Vec<&str> = line.splitn(5, ',').map(str::trim).collect();
        let is_contacts = self.head.quantity == SensorUnit::Contacts;
        let number = |field: &'static str, text: &str| {
            let found = text.parse().ok().filter(|number: &f64| number.is_finite());
            found.ok_or_else(|| Fault::Number { field, found: cut(text) })
        };
        let (time, of, value) = match fields[..] {
            [time, of, contact, state] if is_contacts && pedal_named(of).is_none() => {
                let wrong = |field, found: &str, expected| Fault::Edge { field, found: cut(found), expected };
                let time = number("time", time)?;
                let contact = ["1", "2", "3"].iter().position(|one| *one == contact);
                let contact = contact.ok_or_else(|| wrong("contact", fields[2], "1 (the upper one), 2 or 3"))?;
                let closes = match state {
                    "made" => 1.0,
                    "open" => 0.0,
                    other => return Err(wrong("state", other, "`made` or `open`")),
                };
                (time, Of::Contact(key_of(of)?, contact), closes)
            }
            [time, of, value] if pedal_named(of).is_some() || !is_contacts => {
                let (time, value) = (number("time", time)?, number("value", value)?);
                (time, of_named(of)?, value)
            }
            _ if is_contacts => return Err(Fault::EdgeFields { found: cut(line) }),
            _ => return Err(Fault::Fields { found: cut(line) }),
        };
        let time_s = if self.head.in_microseconds { self.unwrapped_s(time) } else { time };
        Ok(Some(Sample { time_s, of, value }))
    }

    /// The instant of a clock of 32 bits that is nearest to the last one: it goes on where it wraps around, and a stamp
    /// that is wrong changes nothing for the next.
    fn unwrapped_s(&mut self, time_us: f64) -> f64 {
        const WRAP_US: f64 = 4_294_967_296.0;
        let before_us = self.before_us.unwrap_or(time_us);
        let now_us = time_us + WRAP_US * ((before_us - time_us) / WRAP_US).round();
        self.before_us = Some(now_us);
        1e-6 * now_us
    }
}
