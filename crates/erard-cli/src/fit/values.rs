//! Numbers as people write them.

use erard::instrument::Instrument;
use erard::parameter::{Bare, Change, Parameter, Quantity, Sweep};
use erard::stroke::Role;
use erard_workshop::fit::COLUMNS;

/// The column of a channel.
pub(crate) fn column(role: Role) -> &'static str {
    COLUMNS.iter().find(|(_, own, _)| *own == role).map_or("time_s", |(column, ..)| column)
}

/// A start as typed, as the argument of [`Parameter::vary`]: a screw's turn, m, rad or N m, or a factor.
///
/// # Errors
/// What was expected.
pub(crate) fn value(instrument: &Instrument, name: &str, typed: &str) -> Result<f64, String> {
    let [value] = read(instrument, name, |parameter| {
        let (quantity, bare) = quantity_and_bare(instrument, parameter)?;
        Ok([Change::read(typed, quantity, bare).map_err(|error| error.to_string())?])
    })?;
    Ok(value)
}

/// Two bounds `LOW..HIGH` as typed, as arguments of [`Parameter::vary`].
///
/// # Errors
/// What was expected.
pub(crate) fn bounds(instrument: &Instrument, name: &str, typed: &str) -> Result<[f64; 2], String> {
    read(instrument, name, |parameter| {
        let (quantity, bare) = quantity_and_bare(instrument, parameter)?;
        Sweep::read_ends(typed, quantity, bare).map_err(|error| error.to_string())
    })
}

fn read<const N: usize>(
    instrument: &Instrument,
    name: &str,
    read: impl Fn(&Parameter) -> Result<[Change; N], String>,
) -> Result<[f64; N], String> {
    let (_, parameter) = Parameter::named(instrument, name).map_err(|error| error.to_string())?;
    let mut by = [0.0; N];
    for (by, change) in by.iter_mut().zip(read(&parameter)?) {
        *by = parameter.by(instrument, change).map_err(|error| error.to_string())?;
    }
    Ok(by)
}

fn quantity_and_bare(instrument: &Instrument, parameter: &Parameter) -> Result<(Quantity, Bare), String> {
    let quantity = parameter.quantity(instrument);
    quantity.and_then(|quantity| Ok((quantity, parameter.trade_bare(instrument)?))).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_with_and_without_units() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let mass = Parameter::named(&grand, "body.hammer.mass").unwrap().1.value(&grand).unwrap();
        for (name, typed, expected) in [
            ("let_off", "-1", -1e-3),
            ("let_off", "+0.5mm", 5e-4),
            // From the setting in the file, 0.0538 mm.
            ("let_off", "0.5mm", 4.462e-4),
            ("set_off", " -0.5 mm ", -5e-4),
            ("repetition_spring", "+2N mm", 2e-3),
            ("body.hammer.mass", "x0.9", 0.9),
            ("body.hammer.mass", "10g", 10e-3 / mass),
            ("body.hammer.mass", "10", 10e-3 / mass),
            ("body.hammer.mass", "+1 g", 1.0 + 1e-3 / mass),
        ] {
            let found = value(&grand, name, typed).unwrap();
            assert!((found - expected).abs() < 1e-12, "{name} {typed}: {found} {expected}");
        }
        for (name, typed, told) in [
            ("let_off", "1g", "`g` is not one of its units"),
            ("body.hammer.mass", "3 mm", "expected kg, g"),
            ("nobody", "x2", "unknown name `nobody`"),
            ("body.key.friction", "x2", "type `body.key_back.friction`"),
        ] {
            let error = value(&grand, name, typed).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
        assert_eq!(bounds(&grand, "let_off", "-1mm..1mm").unwrap(), [-1e-3, 1e-3]);
        assert_eq!(bounds(&grand, "body.hammer.mass", "x0.9..1.2").unwrap(), [0.9, 1.2]);
        assert!(bounds(&grand, "let_off", "1mm").unwrap_err().contains("LOW..HIGH"));
    }
}
