//! Numbers as people write them, and units in which they are shown.

use erard::instrument::Instrument;
use erard::stroke::Role;
use erard_workshop::fit::COLUMNS;
use erard_workshop::regulate::screw_unit;
use erard_workshop::study::{Change, Parameter, varied};

/// The column of a channel.
pub(crate) fn column(role: Role) -> &'static str {
    COLUMNS.iter().find(|(_, own, _)| *own == role).map_or("time_s", |(column, ..)| column)
}

/// A bound or a start as it was written, in SI units or as a factor: of a screw its turn, in its unit where none is
/// said; of a parameter a factor, or what it shall be with its unit.
///
/// # Errors
/// What was expected.
pub(crate) fn value(instrument: &Instrument, text: &str, name: &str, written: &str) -> Result<f64, String> {
    let written = written.trim();
    let number: Option<f64> = written.parse().ok();
    // Who varies it says that it is not there.
    let Some((_, parameter)) = Parameter::all(instrument).into_iter().find(|(known, _)| known == name) else {
        return number.ok_or_else(|| format!("found `{written}`, expected a number"));
    };
    if let Parameter::Screw { action, .. } = &parameter {
        let (per_si, unit) = screw_unit(action);
        let bare =
            written.strip_suffix(unit).or_else(|| written.strip_suffix(&unit.replace(' ', ""))).unwrap_or(written);
        let turn: Option<f64> = bare.trim().parse().ok();
        return turn.map(|turn| turn / per_si).ok_or_else(|| {
            format!("found `{written}`, expected a change of the screw in {unit}, e.g. `-0.5{}`", unit.replace(' ', ""))
        });
    }
    if let Some(factor) = number {
        return Ok(factor);
    }
    let changed = varied(text, &instrument.name, &[(name.to_owned(), Change::Text(written.to_owned()))]);
    let changed = changed.map_err(|error| format!("{error}; a bare number is a factor"))?.instrument;
    Ok(parameter.value(&changed) / parameter.value(instrument))
}

/// The unit in which an SI value is shown, and how many of these an SI unit is.
pub(crate) fn unit_shown(si: &'static str) -> (f64, &'static str) {
    match si {
        "kg" => (1e3, "g"),
        "m" => (1e3, "mm"),
        "rad" => (180.0 / std::f64::consts::PI, "degrees"),
        "N m" => (1e3, "N mm"),
        other => (1.0, other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_with_and_without_units() {
        let text = Instrument::builtin_text("concert-grand").unwrap();
        let grand = Instrument::builtin("concert-grand").unwrap();
        let mass =
            Parameter::all(&grand).into_iter().find(|(name, _)| name == "body.hammer.mass").unwrap().1.value(&grand);
        for (name, written, expected) in [
            ("let_off", "-1", -1e-3),
            ("let_off", "0.5mm", 5e-4),
            ("let_off", " -0.5 mm ", -5e-4),
            ("repetition_spring", "2N mm", 2e-3),
            ("body.hammer.mass", "0.9", 0.9),
            ("body.hammer.mass", "10g", 10e-3 / mass),
            ("body.hammer.mass", "+1 g", 1.0 + 1e-3 / mass),
            ("nobody", "3", 3.0),
        ] {
            let found = value(&grand, text, name, written).unwrap();
            assert!((found - expected).abs() < 1e-12, "{name} {written}: {found} {expected}");
        }
        for (name, written, told) in
            [("let_off", "1g", "in mm"), ("body.hammer.mass", "3 mm", "units: kg, g"), ("nobody", "x", "a number")]
        {
            let error = value(&grand, text, name, written).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
    }
}
