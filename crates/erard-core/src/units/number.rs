//! A number with its unit, as typed.

use thiserror::Error;

use super::{Quantity, Unit};

/// Unit of a number that is typed without one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bare {
    /// The SI unit, as everywhere in C and Python.
    Si,
    /// The unit with this symbol, as an option's help says.
    In(&'static str),
    /// No number without a unit is accepted.
    Refused,
}

impl Bare {
    /// SI value of one, and the unit's symbol; `None` if a number needs its unit.
    pub(crate) fn unit(self, quantity: Quantity) -> Option<(f64, &'static str)> {
        match self {
            Bare::Refused if quantity == Quantity::Number => Some((1.0, "")),
            Bare::Refused => None,
            Bare::Si => Some((1.0, quantity.si_unit())),
            Bare::In(symbol) => Some(quantity.unit(symbol).map_or((1.0, ""), |unit| (unit.si, unit.symbol))),
        }
    }
}

/// Reason why a text is no number of a quantity.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NumberError {
    /// The text is no number.
    #[error("found `{found}`, expected {expected}")]
    Text {
        /// Found text.
        found: String,
        /// Expected text.
        expected: String,
    },
    /// The unit is not one of the quantity.
    #[error("found `{found}`: `{unit}` is not one of its units; expected {known}")]
    Unit {
        /// Found text.
        found: String,
        /// Its unit.
        unit: String,
        /// Units of the quantity.
        known: String,
    },
    /// A unit is needed.
    #[error("found `{found}` without a unit; type for example `{example}` (units: {known})")]
    NoUnit {
        /// Found text.
        found: String,
        /// The text with a unit.
        example: String,
        /// Units of the quantity.
        known: String,
    },
    /// A comma that may be a decimal one or one of thousands.
    #[error("found `{found}`, which may be {decimal} or {thousands}; type one of these")]
    Comma {
        /// Found text.
        found: String,
        /// As a decimal comma.
        decimal: String,
        /// As a comma of thousands.
        thousands: String,
    },
    /// A decimal comma in a list.
    #[error("found `{found}`: commas separate the values of a list; type `{dots}` or `{semicolons}`")]
    List {
        /// Found text.
        found: String,
        /// With decimal points.
        dots: String,
        /// With semicolons between the values.
        semicolons: String,
    },
    /// Values and changes in one list.
    #[error(
        "found `{found}`, in which values and changes are mixed; give every one a sign (`+`, `-`), or `=`, or neither"
    )]
    Mixed {
        /// Found text.
        found: String,
    },
    /// A list or range of the wrong form.
    #[error("found `{found}`, expected FROM..TO:COUNT with a count from 2 to {most}, or values with commas")]
    Range {
        /// Found text.
        found: String,
        /// Largest count.
        most: usize,
    },
}

impl NumberError {
    /// Found text.
    #[must_use]
    pub fn found(&self) -> &str {
        match self {
            NumberError::Text { found, .. }
            | NumberError::Unit { found, .. }
            | NumberError::NoUnit { found, .. }
            | NumberError::Comma { found, .. }
            | NumberError::List { found, .. }
            | NumberError::Mixed { found }
            | NumberError::Range { found, .. } => found,
        }
    }
}

/// A text that was read: its value in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Typed {
    /// Value in SI units.
    pub si: f64,
    /// Value as typed.
    pub value: f64,
    /// Whether it has a sign of its own.
    pub is_signed: bool,
    /// Unit as typed; `None` without one.
    pub unit: Option<&'static Unit>,
}

impl Quantity {
    /// Reads a value with or without its unit, in SI units: `9.4g`, `0.4 in`, `1 7/8"`, `-0,5 mm`, `50%`. A decimal
    /// comma is read as a point, U+2212 as a minus. Minus zero is zero.
    ///
    /// # Errors
    /// [`NumberError`]: the text is no finite number, its unit is none of this quantity, or it has none where one is
    /// needed.
    pub fn read(self, text: &str, bare: Bare) -> Result<f64, NumberError> {
        self.typed(text, bare).map(|typed| typed.si)
    }

    /// Reads a value as [`Quantity::read`] does, in the unit with this symbol, which is also that of a number without a
    /// unit. A value typed in this unit is returned to the bit.
    ///
    /// # Errors
    /// See [`NumberError`].
    pub fn read_in(self, text: &str, symbol: &'static str) -> Result<f64, NumberError> {
        self.typed_in(text, symbol, Bare::In(symbol))
    }

    /// Reads a value with its unit as [`Quantity::read_in`] does; a number without a unit is refused.
    ///
    /// # Errors
    /// See [`NumberError`].
    pub(crate) fn read_with_unit(self, text: &str, symbol: &'static str) -> Result<f64, NumberError> {
        self.typed_in(text, symbol, Bare::Refused)
    }

    fn typed_in(self, text: &str, symbol: &'static str, bare: Bare) -> Result<f64, NumberError> {
        let typed = self.typed(text, bare)?;
        let own = self.unit(symbol);
        if typed.unit.is_none() || typed.unit == own {
            return Ok(typed.value);
        }
        Ok(typed.si / own.map_or(1.0, |unit| unit.si))
    }

    /// [`Quantity::read`] with what else is known of the text.
    pub(super) fn typed(self, text: &str, bare: Bare) -> Result<Typed, NumberError> {
        let found = text.trim();
        let Some((value, length, is_fraction)) = leading_number(found)? else {
            return Err(NumberError::Text { found: found.to_owned(), expected: self.expected(bare) });
        };
        let rest = found[length..].trim();
        let (si, unit) = if rest.is_empty() {
            match bare.unit(self) {
                // Fractions are of inches: as millimetres they would be wrong by 25.
                Some(_) if is_fraction && self == Quantity::Length => return Err(self.no_unit(found, "in")),
                Some((si, _)) => (si, None),
                None => return Err(self.no_unit(found, self.trade_unit().map_or("", |unit| unit.symbol))),
            }
        } else {
            let unit = self.unit(rest).ok_or_else(|| match self.units() {
                [] => NumberError::Text { found: found.to_owned(), expected: self.expected(bare) },
                _ => NumberError::Unit { found: found.to_owned(), unit: rest.to_owned(), known: self.known() },
            })?;
            (unit.si, Some(unit))
        };
        // Plus zero: minus zero becomes zero.
        let si = to_si(value, si) + 0.0;
        if !si.is_finite() {
            return Err(NumberError::Text { found: found.to_owned(), expected: self.expected(bare) });
        }
        Ok(Typed { si, value: value + 0.0, is_signed: found.starts_with(['+', '-', '\u{2212}']), unit })
    }

    fn no_unit(self, found: &str, unit: &str) -> NumberError {
        NumberError::NoUnit { found: found.to_owned(), example: format!("{found}{unit}"), known: self.known() }
    }

    /// Describes what is accepted: "a length, e.g. `2mm` (units: m, mm; without one: mm)".
    #[must_use]
    pub fn expected(self, bare: Bare) -> String {
        let name = self.name();
        match (self.trade_unit(), bare.unit(self)) {
            (None, _) => format!("{name}, e.g. `0.2`"),
            (Some(unit), Some((_, own))) if !own.is_empty() && own != "1" => {
                format!("{name}, e.g. `2{}` (units: {}; without one: {own})", unit.symbol, self.known())
            }
            (Some(unit), _) => format!("{name}, e.g. `2{}` (units: {})", unit.symbol, self.known()),
        }
    }

    /// Name of the quantity with its article.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Quantity::Number => "a number",
            Quantity::Share => "a share",
            Quantity::Length => "a length",
            Quantity::Angle => "an angle",
            Quantity::Mass => "a mass",
            Quantity::Weight => "a weight",
            Quantity::Force => "a force",
            Quantity::Time => "a time",
            Quantity::Speed => "a speed",
            Quantity::AngularSpeed => "an angular speed",
            Quantity::AngularAcceleration => "an angular acceleration",
            Quantity::Acceleration => "an acceleration",
            Quantity::Frequency => "a frequency",
            Quantity::Energy => "an energy",
            Quantity::Inertia => "a moment of inertia",
            Quantity::Torque => "a torque",
            Quantity::AngularStiffness => "a stiffness in rotation",
            Quantity::AngularDamping => "a damping in rotation",
            Quantity::Stiffness | Quantity::FeltStiffness => "a stiffness",
            Quantity::Damping | Quantity::FeltDamping => "a damping",
            Quantity::Slowness => "a loss",
            Quantity::LineDensity => "a mass per length",
            Quantity::Compliance => "a compliance",
            Quantity::Rate => "a rate",
            Quantity::Pitch => "an interval",
        }
    }
}

/// Value in SI units. If the unit is a decimal part of the SI unit, divides by the number of these in it, which rounds
/// once: `100us` is 1e-4 s to the bit.
fn to_si(value: f64, unit: f64) -> f64 {
    let parts = (1.0 / unit).round();
    if parts > 1.0 && (parts * unit - 1.0).abs() < 1e-12 { value / parts } else { value * unit }
}

/// Number at the beginning of a text, its length in bytes, and whether it is a fraction: `-1.5e-3`, `1,5`, `7/8`,
/// `1 7/8`, `1-7/8`. `None` if there is none.
fn leading_number(text: &str) -> Result<Option<(f64, usize, bool)>, NumberError> {
    let unsigned = text.strip_prefix(['+', '-', '\u{2212}']).map_or(text, str::trim_start);
    let sign = if text.starts_with(['-', '\u{2212}']) { -1.0 } else { 1.0 };
    let before = text.len() - unsigned.len();
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let whole = digits(unsigned);
    let ends = |length: usize| before + length;
    // A fraction, alone or after whole units.
    let fraction = |text: &str| -> Option<(f64, usize)> {
        let above = digits(text);
        let below = digits(text[above..].strip_prefix('/')?);
        let [upper, lower] = [&text[..above], &text[above + 1..above + 1 + below]].map(|part| part.parse::<f64>());
        let (upper, lower) = (upper.ok()?, lower.ok()?);
        (lower > 0.0).then_some((upper / lower, above + 1 + below))
    };
    if let Some((value, length)) = fraction(unsigned) {
        return Ok(Some((sign * value, ends(length), true)));
    }
    let glyph = |text: &str| -> Option<(f64, usize)> {
        const GLYPHS: [(char, f64); 7] = [
            ('\u{bd}', 0.5),
            ('\u{bc}', 0.25),
            ('\u{be}', 0.75),
            ('\u{215b}', 0.125),
            ('\u{215c}', 0.375),
            ('\u{215d}', 0.625),
            ('\u{215e}', 0.875),
        ];
        let first = text.chars().next()?;
        GLYPHS.iter().find(|(glyph, _)| *glyph == first).map(|(glyph, value)| (*value, glyph.len_utf8()))
    };
    if let Some((value, length)) = glyph(unsigned) {
        return Ok(Some((sign * value, ends(length), true)));
    }
    if whole > 0 {
        let rest = &unsigned[whole..];
        let further = rest.trim_start_matches([' ', '\u{a0}', '\u{202f}']);
        let further = if further.len() == rest.len() { rest.strip_prefix('-').unwrap_or(rest) } else { further };
        if let Some((value, length)) = fraction(further).or_else(|| glyph(further)).filter(|(value, _)| *value < 1.0) {
            let units: f64 = unsigned[..whole].parse().unwrap_or(f64::NAN);
            return Ok(Some((sign * (units + value), ends(whole + (rest.len() - further.len()) + length), true)));
        }
    }
    // A decimal number, with a point or a comma.
    let mut end = whole;
    let mut tail = 0;
    let has_comma = unsigned[end..].starts_with(',');
    if unsigned[end..].starts_with(['.', ',']) {
        tail = digits(&unsigned[end + 1..]);
        if whole + tail > 0 && !(has_comma && (tail == 0 || whole == 0)) {
            end += 1 + tail;
        }
    }
    if whole + tail == 0 {
        return Ok(None);
    }
    if has_comma {
        let rest = &unsigned[end..];
        let again = rest.starts_with(['.', ',']);
        let [units, parts] = [&unsigned[..whole], &unsigned[(whole + 1).min(end)..end]];
        // `1,500` may be 1.5 or 1500; `0,500` cannot.
        if again || (tail == 3 && (1..=3).contains(&whole) && !units.starts_with('0')) {
            return Err(NumberError::Comma {
                found: text.to_owned(),
                decimal: format!("{}{units}.{parts}{}", &text[..before], if again { "" } else { rest }),
                thousands: format!("{}{}", &text[..before], unsigned.replace(',', "")),
            });
        }
    }
    let exponent = unsigned[end..].strip_prefix(['e', 'E']).and_then(|rest| {
        let signed = rest.strip_prefix(['+', '-']).map_or(0, |_| 1);
        let length = digits(&rest[signed..]);
        (length > 0).then_some(1 + signed + length)
    });
    end += exponent.unwrap_or(0);
    let value: Option<f64> = unsigned[..end].replace(',', ".").parse().ok();
    Ok(value.map(|value| (sign * value, ends(end), false)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(quantity: Quantity, text: &str, bare: Bare, expected: f64) {
        let value = quantity.read(text, bare).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!((value - expected).abs() <= 1e-15 * expected.abs(), "{text}: {value} {expected}");
    }

    #[test]
    fn values_are_read_with_their_units() {
        for (text, mm) in [
            ("10mm", 10.0),
            (" 10 mm ", 10.0),
            ("10", 10.0),
            ("1cm", 10.0),
            ("0.01 m", 10.0),
            ("250 um", 0.25),
            ("0.4in", 0.4 * 25.4),
            ("0.4 inch.", 0.4 * 25.4),
            ("1 7/8in", 1.875 * 25.4),
            ("1-7/8\"", 1.875 * 25.4),
            ("1/16\"", 25.4 / 16.0),
            ("2 1/2 in", 2.5 * 25.4),
            ("1\u{215e}\u{2033}", 1.875 * 25.4),
            ("1,5", 1.5),
            ("0,500mm", 0.5),
            ("12,25 mm", 12.25),
            ("-0.2", -0.2),
            ("\u{2212}0.2 mm", -0.2),
            ("+0.2", 0.2),
            ("1e-1", 0.1),
            (".5", 0.5),
            ("5.", 5.0),
        ] {
            close(Quantity::Length, text, Bare::In("mm"), 1e-3 * mm);
        }
        close(Quantity::Force, "58gf", Bare::Si, 58e-3 * 9.806_65);
        close(Quantity::Weight, "2oz", Bare::In("g"), 56.699_046_25e-3);
        close(Quantity::Weight, "0.5 N", Bare::In("g"), 0.5 / 9.806_65);
        close(Quantity::Time, "50us", Bare::Si, 50e-6);
        close(Quantity::Share, "50%", Bare::Si, 0.5);
        close(Quantity::Angle, "2\u{b0}", Bare::Refused, 2.0_f64.to_radians());
        close(Quantity::Torque, "2Nmm", Bare::Refused, 2e-3);
        close(Quantity::Number, "0.3", Bare::Refused, 0.3);
        assert!(Quantity::Length.read("-0", Bare::Si).unwrap().is_sign_positive());
    }

    #[test]
    fn values_in_their_own_unit_keep_their_bits() {
        for text in ["58", "58.1g", "0.3 g"] {
            let own: f64 = text.trim_end_matches([' ', 'g']).parse().unwrap();
            assert_eq!(Quantity::Weight.read_in(text, "g").unwrap().to_bits(), own.to_bits(), "{text}");
        }
        assert!((Quantity::Length.read_in("0.4in", "mm").unwrap() - 10.16).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in [
            "", "ten", "nan", "inf", "-inf", "infinity", "1e999", "mm", "1..2", "--1", "1/0in", "0x10", "1 2mm", ",5",
            "5,",
        ] {
            assert!(Quantity::Length.read(text, Bare::In("mm")).is_err(), "{text}");
        }
        for (quantity, text, bare, told) in [
            (Quantity::Length, "1 g", Bare::Si, "`g` is not one of its units; expected m, dm, cm, mm"),
            (Quantity::Length, "1,500", Bare::In("mm"), "may be 1.500 or 1500"),
            (Quantity::Length, "-1,500 mm", Bare::In("mm"), "may be -1.500 mm or -1500 mm"),
            (Quantity::Length, "1,500,000", Bare::In("mm"), "1500000"),
            (Quantity::Length, "1 7/8", Bare::In("mm"), "type for example `1 7/8in`"),
            (Quantity::Mass, "9.4", Bare::Refused, "type for example `9.4g`"),
            (Quantity::Number, "0.2 mm", Bare::Refused, "expected a number"),
            (Quantity::Force, "1 MN", Bare::Si, "not one of its units"),
        ] {
            let error = quantity.read(text, bare).unwrap_err().to_string();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
