//! A change of a number, as typed.

use super::number::NumberError;
use super::{Bare, Quantity};

/// Change of a number, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// New value: `=9.4g`, `9.4g`.
    Set(f64),
    /// Difference from the present value: `+0.8g`, `-0.2mm`.
    Add(f64),
    /// Factor of the present value: `x1.05`, `*1.05`.
    Multiply(f64),
}

impl Change {
    /// Reads a change. A value with a sign is a difference; `=` before it makes it a value.
    ///
    /// # Errors
    /// See [`NumberError`].
    pub fn read(text: &str, quantity: Quantity, bare: Bare) -> Result<Self, NumberError> {
        let text = text.trim();
        if let Some(factor) = text.strip_prefix(['x', 'X', '*', '\u{d7}']) {
            let factor = Quantity::Number.read(factor, Bare::Si);
            return factor.map(Change::Multiply).map_err(|_| NumberError::Text {
                found: text.to_owned(),
                expected: "a factor, e.g. `x1.05`".to_owned(),
            });
        }
        if let Some(value) = text.strip_prefix('=') {
            return quantity.read(value, bare).map(Change::Set);
        }
        let typed = quantity.typed(text, bare).map_err(|error| match error {
            NumberError::Text { found, expected } => NumberError::Text {
                found,
                expected: format!("{expected}: a value, a change with its sign (`+2`, `-2`) or a factor (`x1.05`)"),
            },
            error => error,
        })?;
        Ok(if typed.is_signed { Change::Add(typed.si) } else { Change::Set(typed.si) })
    }

    /// Changed value of a present one, both in SI units.
    #[must_use]
    pub fn of(self, present: f64) -> f64 {
        match self {
            Change::Set(value) => value,
            Change::Add(by) => present + by,
            Change::Multiply(factor) => present * factor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_set_added_or_multiplied() {
        let read = |text: &str| Change::read(text, Quantity::Mass, Bare::In("g"));
        for (text, grams) in [
            ("9.4g", 9.4),
            ("=9.4g", 9.4),
            ("= 9.4", 9.4),
            ("9.4", 9.4),
            ("+0.8g", 9.8),
            ("-0.2 g", 8.8),
            ("\u{2212}0,2", 8.8),
            ("=-0.2g", -0.2),
            ("x1.05", 9.45),
            ("*1.05", 9.45),
            ("\u{d7}2", 18.0),
            ("+1oz", 9.0 + 28.349_523_125),
        ] {
            let value = read(text).unwrap_or_else(|error| panic!("{text}: {error}")).of(9e-3);
            assert!((value - 1e-3 * grams).abs() < 1e-15, "{text}: {value}");
        }
        for text in ["", "x", "x2g", "*", "=", "+", "heavy", "9.4mm", "1,500", "=+-1"] {
            assert!(read(text).is_err(), "{text}");
        }
        assert_eq!(read("-0").unwrap(), Change::Add(0.0));
    }
}
