//! Display of goals' values.

use erard::parameter::{Bare, NumberError, Quantity};

use super::Goal;

/// Returns the factor from SI to the displayed unit of a goal, and the unit: mm, mm/s or %.
pub fn unit(goal: Goal) -> (f64, &'static str) {
    match goal.quantity() {
        Quantity::Speed => Quantity::Speed.unit("mm/s").map_or((1.0, ""), |unit| (1.0 / unit.si, unit.symbol)),
        quantity => quantity.shown(),
    }
}

/// Formats a goal's value with its unit.
pub fn show(goal: Goal, value: f64) -> String {
    let (factor, unit) = unit(goal);
    format!("{} {unit}", (value * factor * 1e4).round() / 1e4)
}

/// Reads a value with or without a unit, to m, m/s, or a share.
///
/// # Errors
/// The expected text.
pub fn parse_value(goal: Goal, text: &str) -> Result<f64, String> {
    let quantity = goal.quantity();
    let what = match quantity {
        Quantity::Speed => "a speed",
        Quantity::Share => "a share of the dip",
        _ => "a length",
    };
    let [least, most] = goal.limits();
    let range = || format!("{what} from {} to {} (units: {})", show(goal, least), show(goal, most), quantity.known());
    match quantity.read(text, Bare::In(unit(goal).1)) {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(_) | Err(NumberError::Text { .. } | NumberError::Unit { .. }) => Err(range()),
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_with_and_without_units() {
        let close = |goal, text, expected: f64| {
            let value = parse_value(goal, text).unwrap();
            assert!((value - expected).abs() < 1e-12, "{text}: {value}");
        };
        close(Goal::Dip, "10mm", 10e-3);
        close(Goal::Dip, " 10 mm", 10e-3);
        close(Goal::Dip, "10", 10e-3);
        close(Goal::Dip, "1cm", 10e-3);
        close(Goal::Dip, "0.01 m", 10e-3);
        close(Goal::Blow, "1.75in", 44.45e-3);
        close(Goal::Blow, "1 3/4\"", 44.45e-3);
        close(Goal::RepetitionSpring, "200mm/s", 0.2);
        close(Goal::RepetitionSpring, "0.2 m/s", 0.2);
        close(Goal::DamperStart, "50%", 0.5);
        for (goal, text) in [
            (Goal::Dip, "ten"),
            (Goal::Dip, ""),
            (Goal::Dip, "10 mm/s"),
            (Goal::Dip, "100mm"),
            (Goal::Dip, "-10mm"),
            (Goal::Dip, "nan"),
            (Goal::Dip, "inf"),
            (Goal::DamperStart, "100%"),
            (Goal::DamperStart, "5mm"),
        ] {
            assert!(parse_value(goal, text).is_err(), "{text}");
        }
        assert_eq!(
            parse_value(Goal::Dip, "ten").unwrap_err(),
            "a length from 3 mm to 14 mm (units: m, dm, cm, mm, um, nm, in, mil, ft)"
        );
    }
}
