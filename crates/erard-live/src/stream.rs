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

/// Reads the lines after a header; remembers how often a clock of 32 bits has wrapped around.
#[derive(Debug, Clone)]
pub struct Reader {
    head: Head,
    before_us: Option<f64>,
    has_restarted: bool,
}

impl Reader {
    /// Makes a reader for the lines after a header.
    #[must_use]
    pub fn new(head: Head) -> Self {
        Reader { head, before_us: None, has_restarted: false }
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
        let pedal = |of: &str| match of {
            "sustain" => Some(Of::Pedal(SUSTAIN)),
            "sostenuto" => Some(Of::Pedal(SOSTENUTO)),
            "soft" => Some(Of::Pedal(SOFT)),
            _ => None,
        };
        let key = |text: &str| key_named(text).ok_or_else(|| Fault::Key { found: cut(text) });
        let (time, of, value) = match fields[..] {
            [time, of, contact, state] if is_contacts && pedal(of).is_none() => {
                let wrong = |field, found: &str, expected| Fault::Edge { field, found: cut(found), expected };
                let time = number("time", time)?;
                let contact = ["1", "2", "3"].iter().position(|one| *one == contact);
                let contact = contact.ok_or_else(|| wrong("contact", fields[2], "1 (the upper one), 2 or 3"))?;
                let closes = match state {
                    "made" => 1.0,
                    "open" => 0.0,
                    other => return Err(wrong("state", other, "`made` or `open`")),
                };
                (time, Of::Contact(key(of)?, contact), closes)
            }
            [time, of, value] if pedal(of).is_some() || !is_contacts => {
                let (time, value) = (number("time", time)?, number("value", value)?);
                (time, pedal(of).map_or_else(|| key(of).map(Of::Key), Ok)?, value)
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
