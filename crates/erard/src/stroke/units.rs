//! Units as people write them, and their SI values.

/// Physical quantity of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// In seconds.
    Time,
    /// In newtons.
    Force,
    /// In metres.
    Length,
    /// In metres per second.
    Speed,
}

/// Standard gravity, m/s2, by definition, for the weight of a gram.
const GRAVITY: f64 = 9.806_65;
/// A pound, kg, by definition.
const POUND: f64 = 0.453_592_37;
const INCH: f64 = 0.025_4;

/// Value of the unit in SI, its usual name, and its other names, in lower case.
type Unit = (f64, &'static str, &'static [&'static str]);

const TIMES: &[Unit] = &[
    (1.0, "s", &["sec", "secs", "second", "seconds"]),
    (1e-3, "ms", &["msec", "millisecond", "milliseconds"]),
    (1e-6, "us", &["\u{b5}s", "\u{3bc}s", "usec", "microsecond", "microseconds"]),
    (1e-9, "ns", &["nanosecond", "nanoseconds"]),
    (60.0, "min", &["minute", "minutes"]),
    (3600.0, "h", &["hour", "hours"]),
];

/// Grams, pounds and the like mean their weight.
const FORCES: &[Unit] = &[
    (1.0, "N", &["newton", "newtons"]),
    (1e-3, "mN", &["millinewton", "millinewtons"]),
    (1e-2, "cN", &["centinewton", "centinewtons"]),
    (10.0, "daN", &["decanewton", "decanewtons"]),
    (1e3, "kN", &["kilonewton", "kilonewtons"]),
    (1e-3 * GRAVITY, "gf", &["g", "gram", "grams", "gramme", "grammes", "gr", "p", "pond"]),
    (GRAVITY, "kgf", &["kg", "kilogram", "kilograms", "kp", "kilopond"]),
    (POUND * GRAVITY, "lbf", &["lb", "lbs", "pound", "pounds"]),
    (POUND * GRAVITY / 16.0, "ozf", &["oz", "ounce", "ounces"]),
    (1e-5, "dyn", &["dyne", "dynes"]),
];

const LENGTHS: &[Unit] = &[
    (1.0, "m", &["meter", "meters", "metre", "metres"]),
    (1e-1, "dm", &[]),
    (1e-2, "cm", &["centimeter", "centimeters", "centimetre", "centimetres"]),
    (1e-3, "mm", &["millimeter", "millimeters", "millimetre", "millimetres"]),
    (
        1e-6,
        "um",
        &["\u{b5}m", "\u{3bc}m", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"],
    ),
    (1e-9, "nm", &["nanometer", "nanometers", "nanometre", "nanometres"]),
    (INCH, "in", &["inch", "inches", "\""]),
    (1e-3 * INCH, "mil", &["mils", "thou"]),
    (12.0 * INCH, "ft", &["foot", "feet"]),
];

const SPEEDS: &[Unit] = &[
    (1.0, "m/s", &["m_per_s", "m s-1", "m s^-1", "mps"]),
    (1e-2, "cm/s", &["cm_per_s"]),
    (1e-3, "mm/s", &["mm_per_s"]),
];

impl Quantity {
    fn units(self) -> &'static [Unit] {
        match self {
            Quantity::Time => TIMES,
            Quantity::Force => FORCES,
            Quantity::Length => LENGTHS,
            Quantity::Speed => SPEEDS,
        }
    }

    /// Value of a unit in SI, and its usual name; capitals and a final full stop do not matter.
    pub fn unit(self, text: &str) -> Option<(f64, &'static str)> {
        let text = text.trim().trim_end_matches('.');
        // A meganewton is not a millinewton, a megasecond no millisecond.
        if text.len() == 2 && text.starts_with('M') {
            return None;
        }
        let small = text.to_lowercase();
        let named = |(_, name, others): &&Unit| name.to_lowercase() == small || others.contains(&small.as_str());
        self.units().iter().find(named).map(|&(factor, name, _)| (factor, name))
    }

    /// The unit in which people read it, and the number of these in an SI unit.
    pub fn shown(self) -> (f64, &'static str) {
        match self {
            Quantity::Time => (1e3, "ms"),
            Quantity::Force => (1.0, "N"),
            Quantity::Length => (1e3, "mm"),
            Quantity::Speed => (1.0, "m/s"),
        }
    }

    /// The usual names of all units, for messages.
    pub(super) fn known(self) -> String {
        self.units().iter().map(|(_, name, _)| *name).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against numbers from elsewhere: NIST SP 811 (2008), appendix B.8, to the digits it prints.
    #[test]
    fn factors_are_those_of_the_tables() {
        let close = |quantity: Quantity, unit: &str, table: f64| {
            let (factor, _) = quantity.unit(unit).unwrap_or_else(|| panic!("{unit} is not known"));
            assert!((factor / table - 1.0).abs() < 1e-6, "{unit}: {factor} {table}");
        };
        for (unit, table) in [
            ("kgf", 9.806_65),
            ("kp", 9.806_65),
            ("gf", 9.806_65e-3),
            ("lbf", 4.448_222),
            ("ozf", 2.780_139e-1),
            ("dyn", 1e-5),
        ] {
            close(Quantity::Force, unit, table);
        }
        for (unit, table) in
            [("inch", 2.54e-2), ("mil", 2.54e-5), ("ft", 3.048e-1), ("\u{b5}m", 1e-6), ("micron", 1e-6)]
        {
            close(Quantity::Length, unit, table);
        }
        for (unit, table) in [("min", 60.0), ("h", 3600.0), ("\u{3bc}s", 1e-6), ("Milliseconds", 1e-3)] {
            close(Quantity::Time, unit, table);
        }
    }

    /// What would be wrong by a factor of 1e9 is not guessed.
    #[test]
    fn capitals_that_matter() {
        assert_eq!(Quantity::Force.unit("MN"), None);
        assert_eq!(Quantity::Time.unit("MS"), None);
        assert_eq!(Quantity::Force.unit("mn"), Some((1e-3, "mN")));
        assert_eq!(Quantity::Length.unit("MM"), None);
        assert_eq!(Quantity::Length.unit("Mm"), None);
        assert_eq!(Quantity::Force.unit("V"), None);
        assert!(Quantity::Length.known().starts_with("m, dm, cm, mm"));
    }
}
