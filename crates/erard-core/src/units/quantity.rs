//! Physical quantities with their units.

use std::f64::consts::PI;

/// Unit of a quantity.
#[derive(Debug, PartialEq)]
pub struct Unit {
    /// Usual symbol, as shown: `mm`, `N m/rad`.
    pub symbol: &'static str,
    /// SI value of one unit.
    pub si: f64,
    /// End of the names of parameters and columns in this unit, without the underscore before it: `mm`,
    /// `N_m_per_rad`; empty if no name ends with it.
    pub suffix: &'static str,
    /// Other names, in lower case.
    pub also: &'static [&'static str],
}

/// Physical quantity of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// Number without a unit: a ratio, a coefficient, a count.
    Number,
    /// Share of something, 1 for all of it; also in per cent.
    Share,
    /// In metres.
    Length,
    /// In radians.
    Angle,
    /// In kilograms.
    Mass,
    /// Force stated by the mass whose weight it is under standard gravity, as technicians weigh keys; in kilograms.
    Weight,
    /// In newtons.
    Force,
    /// In seconds.
    Time,
    /// In metres per second.
    Speed,
    /// In radians per second.
    AngularSpeed,
    /// In radians per second squared.
    AngularAcceleration,
    /// In metres per second squared.
    Acceleration,
    /// In hertz.
    Frequency,
    /// In joules.
    Energy,
    /// Moment of inertia, kg m2.
    Inertia,
    /// In newton metres.
    Torque,
    /// In newton metres per radian.
    AngularStiffness,
    /// In newton metre seconds per radian.
    AngularDamping,
    /// In newtons per metre.
    Stiffness,
    /// In newton seconds per metre.
    Damping,
    /// Stiffness of a felt with exponent r, N/m^r.
    FeltStiffness,
    /// Damping of a felt, N s/m3.
    FeltDamping,
    /// Seconds per metre.
    Slowness,
    /// Mass per length, kg/m.
    LineDensity,
    /// Compliance, m/N.
    Compliance,
    /// Reciprocal of a time, 1/s.
    Rate,
    /// Interval of pitch, in cents.
    Pitch,
}

/// Standard gravity, m/s2, by definition. The weight of a gram does not depend on an instrument's gravity.
const GRAVITY: f64 = 9.806_65;
/// Pound, kg, by definition.
const POUND: f64 = 0.453_592_37;
/// Ounce, kg, by definition.
const OUNCE: f64 = POUND / 16.0;
/// Inch, m, by definition.
const INCH: f64 = 0.025_4;

const fn unit(si: f64, symbol: &'static str, suffix: &'static str, also: &'static [&'static str]) -> Unit {
    Unit { symbol, si, suffix, also }
}

const SHARES: &[Unit] = &[unit(1.0, "1", "share", &[]), unit(1e-2, "%", "percent", &["percent", "per cent", "pct"])];

const LENGTHS: &[Unit] = &[
    unit(1.0, "m", "m", &["meter", "meters", "metre", "metres"]),
    unit(1e-1, "dm", "", &[]),
    unit(1e-2, "cm", "cm", &["centimeter", "centimeters", "centimetre", "centimetres"]),
    unit(1e-3, "mm", "mm", &["millimeter", "millimeters", "millimetre", "millimetres"]),
    unit(
        1e-6,
        "um",
        "um",
        &["\u{b5}m", "\u{3bc}m", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"],
    ),
    unit(1e-9, "nm", "", &["nanometer", "nanometers", "nanometre", "nanometres"]),
    unit(INCH, "in", "in", &["inch", "inches", "\"", "\u{2033}", "\u{201d}", "''"]),
    unit(1e-3 * INCH, "mil", "", &["mils", "thou"]),
    unit(12.0 * INCH, "ft", "", &["foot", "feet"]),
];

const ANGLES: &[Unit] = &[
    unit(1.0, "rad", "rad", &["radian", "radians"]),
    unit(PI / 180.0, "deg", "deg", &["degree", "degrees", "\u{b0}"]),
    unit(1e-3, "mrad", "", &["milliradian", "milliradians"]),
];

const MASSES: &[Unit] = &[
    unit(1.0, "kg", "kg", &["kilogram", "kilograms"]),
    unit(1e-3, "g", "g", &["gram", "grams", "gramme", "grammes", "gr"]),
    unit(1e-6, "mg", "", &["milligram", "milligrams"]),
    unit(OUNCE, "oz", "", &["ounce", "ounces"]),
    unit(POUND, "lb", "", &["lbs", "pound", "pounds"]),
];

const WEIGHTS: &[Unit] = &[
    unit(1.0, "kg", "kg", &["kilogram", "kilograms", "kgf", "kp", "kilopond"]),
    unit(1e-3, "g", "g", &["gram", "grams", "gramme", "grammes", "gr", "gf", "p", "pond"]),
    unit(OUNCE, "oz", "", &["ounce", "ounces", "ozf"]),
    unit(POUND, "lb", "", &["lbs", "pound", "pounds", "lbf"]),
    unit(1.0 / GRAVITY, "N", "", &["newton", "newtons"]),
    unit(1e-2 / GRAVITY, "cN", "", &["centinewton", "centinewtons"]),
    unit(1e-3 / GRAVITY, "mN", "", &["millinewton", "millinewtons"]),
];

/// Grams, pounds and the like mean their weight.
const FORCES: &[Unit] = &[
    unit(1.0, "N", "N", &["newton", "newtons"]),
    unit(1e-3, "mN", "mN", &["millinewton", "millinewtons"]),
    unit(1e-2, "cN", "", &["centinewton", "centinewtons"]),
    unit(10.0, "daN", "", &["decanewton", "decanewtons"]),
    unit(1e3, "kN", "", &["kilonewton", "kilonewtons"]),
    unit(1e-3 * GRAVITY, "gf", "gf", &["g", "gram", "grams", "gramme", "grammes", "gr", "p", "pond"]),
    unit(GRAVITY, "kgf", "", &["kg", "kilogram", "kilograms", "kp", "kilopond"]),
    unit(POUND * GRAVITY, "lbf", "", &["lb", "lbs", "pound", "pounds"]),
    unit(OUNCE * GRAVITY, "ozf", "", &["oz", "ounce", "ounces"]),
    unit(1e-5, "dyn", "", &["dyne", "dynes"]),
];

const TIMES: &[Unit] = &[
    unit(1.0, "s", "s", &["sec", "secs", "second", "seconds"]),
    unit(1e-3, "ms", "ms", &["msec", "millisecond", "milliseconds"]),
    unit(1e-6, "us", "us", &["\u{b5}s", "\u{3bc}s", "usec", "microsecond", "microseconds"]),
    unit(1e-9, "ns", "", &["nanosecond", "nanoseconds"]),
    unit(60.0, "min", "", &["minute", "minutes"]),
    unit(3600.0, "h", "", &["hour", "hours"]),
];

const SPEEDS: &[Unit] = &[
    unit(1.0, "m/s", "m_per_s", &["m_per_s", "ms-1", "ms^-1", "mps"]),
    unit(1e-2, "cm/s", "cm_per_s", &["cm_per_s"]),
    unit(1e-3, "mm/s", "mm_per_s", &["mm_per_s"]),
    unit(INCH, "in/s", "", &["in_per_s"]),
];

const ANGULAR_SPEEDS: &[Unit] =
    &[unit(1.0, "rad/s", "rad_per_s", &["rad_per_s"]), unit(PI / 180.0, "deg/s", "deg_per_s", &["\u{b0}/s"])];
const ANGULAR_ACCELERATIONS: &[Unit] = &[unit(1.0, "rad/s2", "rad_per_s2", &["rad/s^2"])];
const ACCELERATIONS: &[Unit] = &[unit(1.0, "m/s2", "m_s2", &["m/s^2", "m_per_s2"])];
const FREQUENCIES: &[Unit] = &[unit(1.0, "Hz", "Hz", &["hertz"]), unit(1e3, "kHz", "kHz", &["kilohertz"])];
const ENERGIES: &[Unit] = &[unit(1.0, "J", "J", &["joule", "joules"]), unit(1e-3, "mJ", "mJ", &[])];
const INERTIAS: &[Unit] = &[
    unit(1.0, "kg m2", "kg_m2", &["kgm^2"]),
    unit(1e-3, "g m2", "", &["gm^2"]),
    unit(1e-7, "g cm2", "", &["gcm^2"]),
    unit(1e-9, "g mm2", "g_mm2", &["gmm^2"]),
    unit(1e-6, "kg mm2", "", &["kgmm^2"]),
];
const TORQUES: &[Unit] = &[
    unit(1.0, "N m", "N_m", &[]),
    unit(1e-2, "N cm", "", &[]),
    unit(1e-3, "N mm", "N_mm", &["mnm"]),
    unit(1e-5 * GRAVITY, "gf cm", "", &["gcm"]),
    unit(1e-6 * GRAVITY, "gf mm", "", &["gmm"]),
];
const ANGULAR_STIFFNESSES: &[Unit] =
    &[unit(1.0, "N m/rad", "N_m_per_rad", &[]), unit(1e-3, "N mm/rad", "", &[]), unit(180.0 / PI, "N m/deg", "", &[])];
const ANGULAR_DAMPINGS: &[Unit] = &[unit(1.0, "N m s/rad", "N_m_s", &["nms"]), unit(1e-3, "N mm s/rad", "", &["nmms"])];
const STIFFNESSES: &[Unit] =
    &[unit(1.0, "N/m", "N_per_m", &[]), unit(1e3, "N/mm", "N_per_mm", &["kn/m"]), unit(1e6, "N/um", "", &[])];
const DAMPINGS: &[Unit] = &[unit(1.0, "N s/m", "N_s_per_m", &["ns/m"]), unit(1e-3, "mN s/m", "", &[])];
const FELT_STIFFNESSES: &[Unit] = &[unit(1.0, "N/m^r", "N_per_m_r", &[])];
const FELT_DAMPINGS: &[Unit] = &[unit(1.0, "N s/m3", "N_s_per_m3", &["ns/m^3"])];
const SLOWNESSES: &[Unit] = &[unit(1.0, "s/m", "s_per_m", &[])];
const LINE_DENSITIES: &[Unit] =
    &[unit(1.0, "kg/m", "kg_per_m", &[]), unit(1e-3, "g/m", "g_per_m", &[]), unit(1e-1, "g/cm", "", &[])];
const COMPLIANCES: &[Unit] = &[unit(1.0, "m/N", "m_per_N", &[]), unit(1e-3, "mm/N", "mm_per_N", &["um/mn"])];
const RATES: &[Unit] = &[unit(1.0, "1/s", "per_s", &["s-1", "s^-1"])];
const PITCHES: &[Unit] = &[unit(1.0, "cents", "cents", &["cent", "ct"])];

impl Quantity {
    /// All quantities.
    pub const ALL: [Quantity; 27] = [
        Quantity::Number,
        Quantity::Share,
        Quantity::Length,
        Quantity::Angle,
        Quantity::Mass,
        Quantity::Weight,
        Quantity::Force,
        Quantity::Time,
        Quantity::Speed,
        Quantity::AngularSpeed,
        Quantity::AngularAcceleration,
        Quantity::Acceleration,
        Quantity::Frequency,
        Quantity::Energy,
        Quantity::Inertia,
        Quantity::Torque,
        Quantity::AngularStiffness,
        Quantity::AngularDamping,
        Quantity::Stiffness,
        Quantity::Damping,
        Quantity::FeltStiffness,
        Quantity::FeltDamping,
        Quantity::Slowness,
        Quantity::LineDensity,
        Quantity::Compliance,
        Quantity::Rate,
        Quantity::Pitch,
    ];

    /// Units of the quantity, the SI unit first; none of a number without a unit.
    #[must_use]
    pub const fn units(self) -> &'static [Unit] {
        match self {
            Quantity::Number => &[],
            Quantity::Share => SHARES,
            Quantity::Length => LENGTHS,
            Quantity::Angle => ANGLES,
            Quantity::Mass => MASSES,
            Quantity::Weight => WEIGHTS,
            Quantity::Force => FORCES,
            Quantity::Time => TIMES,
            Quantity::Speed => SPEEDS,
            Quantity::AngularSpeed => ANGULAR_SPEEDS,
            Quantity::AngularAcceleration => ANGULAR_ACCELERATIONS,
            Quantity::Acceleration => ACCELERATIONS,
            Quantity::Frequency => FREQUENCIES,
            Quantity::Energy => ENERGIES,
            Quantity::Inertia => INERTIAS,
            Quantity::Torque => TORQUES,
            Quantity::AngularStiffness => ANGULAR_STIFFNESSES,
            Quantity::AngularDamping => ANGULAR_DAMPINGS,
            Quantity::Stiffness => STIFFNESSES,
            Quantity::Damping => DAMPINGS,
            Quantity::FeltStiffness => FELT_STIFFNESSES,
            Quantity::FeltDamping => FELT_DAMPINGS,
            Quantity::Slowness => SLOWNESSES,
            Quantity::LineDensity => LINE_DENSITIES,
            Quantity::Compliance => COMPLIANCES,
            Quantity::Rate => RATES,
            Quantity::Pitch => PITCHES,
        }
    }

    /// Symbol of the SI unit; empty for a number without a unit.
    #[must_use]
    pub fn si_unit(self) -> &'static str {
        self.units().first().map_or("", |unit| unit.symbol)
    }

    /// Exponents of kg, m, s and rad in the SI unit; `None` of a pitch, which has no SI unit.
    #[must_use]
    pub const fn dimension(self) -> Option<[i32; 4]> {
        Some(match self {
            Quantity::Number | Quantity::Share => [0, 0, 0, 0],
            Quantity::Length => [0, 1, 0, 0],
            Quantity::Angle => [0, 0, 0, 1],
            Quantity::Mass | Quantity::Weight => [1, 0, 0, 0],
            Quantity::Force => [1, 1, -2, 0],
            Quantity::Time => [0, 0, 1, 0],
            Quantity::Speed => [0, 1, -1, 0],
            Quantity::AngularSpeed => [0, 0, -1, 1],
            Quantity::AngularAcceleration => [0, 0, -2, 1],
            Quantity::Acceleration => [0, 1, -2, 0],
            Quantity::Frequency | Quantity::Rate => [0, 0, -1, 0],
            Quantity::Energy => [1, 2, -2, 0],
            Quantity::Inertia => [1, 2, 0, 0],
            Quantity::Torque => [1, 2, -2, 0],
            Quantity::AngularStiffness => [1, 2, -2, -1],
            Quantity::AngularDamping => [1, 2, -1, -1],
            Quantity::Stiffness => [1, 0, -2, 0],
            Quantity::Damping => [1, 0, -1, 0],
            Quantity::FeltDamping => [1, -2, -1, 0],
            Quantity::Slowness => [0, -1, 1, 0],
            Quantity::LineDensity => [1, -1, 0, 0],
            Quantity::Compliance => [-1, 0, 2, 0],
            // The exponent of the metre is the felt's own.
            Quantity::FeltStiffness | Quantity::Pitch => return None,
        })
    }

    /// Unit in which technicians read the quantity; `None` of a number without a unit.
    #[must_use]
    pub fn trade_unit(self) -> Option<&'static Unit> {
        let symbol = match self {
            Quantity::Share => "%",
            Quantity::Length => "mm",
            Quantity::Angle => "deg",
            Quantity::Mass | Quantity::Weight => "g",
            Quantity::Time => "ms",
            Quantity::Torque => "N mm",
            Quantity::LineDensity => "g/m",
            _ => return self.units().first(),
        };
        self.unit(symbol)
    }

    /// Unit in which technicians read the quantity, and the number of these in an SI unit.
    #[must_use]
    pub fn shown(self) -> (f64, &'static str) {
        self.trade_unit().map_or((1.0, ""), |unit| (1.0 / unit.si, unit.symbol))
    }

    /// Finds a unit by its symbol or another of its names, in any spelling of blanks, dots and capitals. Capitals that
    /// change the meaning are refused: `MN` is not `mN`.
    #[must_use]
    pub fn unit(self, text: &str) -> Option<&'static Unit> {
        let text = joined(text.trim_end_matches('.'));
        // A meganewton is not a millinewton, a megasecond no millisecond.
        if text.chars().count() == 2 && text.starts_with('M') {
            return None;
        }
        let small = text.to_lowercase();
        let is_called = |unit: &&Unit| {
            let symbol = joined(unit.symbol).to_lowercase();
            symbol == small || unit.also.iter().any(|name| joined(name) == small)
        };
        if text.is_empty() { None } else { self.units().iter().find(is_called) }
    }

    /// Symbols of all units, for messages: `m, cm, mm`.
    #[must_use]
    pub fn known(self) -> String {
        self.units().iter().map(|unit| unit.symbol).collect::<Vec<_>>().join(", ")
    }

    /// Quantity and unit of a parameter's or column's name, by the unit at its end: `mass_g`, `center_mm.x`. The
    /// longest end that is a unit counts. `None` if the name ends with none.
    #[must_use]
    pub fn of_name(name: &str) -> Option<(Quantity, &'static Unit)> {
        let name = name.trim_end_matches(".x").trim_end_matches(".y");
        // Columns of screws: `back_check_angle_degrees`.
        let name = name.strip_suffix("_degrees").map_or(name, |_| name.trim_end_matches("rees"));
        // A weight's names look like a mass's.
        let all = Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Weight);
        let units = all.flat_map(|quantity| quantity.units().iter().map(move |unit| (quantity, unit)));
        let fits = |unit: &Unit| {
            let before = name.strip_suffix(unit.suffix).filter(|_| !unit.suffix.is_empty());
            before.is_some_and(|before| before.ends_with('_') && before.len() > 1)
        };
        units.filter(|(_, unit)| fits(unit)).max_by_key(|(_, unit)| unit.suffix.len())
    }
}

/// A unit's text without what people write differently: `N·m` and `N m` are one unit.
fn joined(text: &str) -> String {
    let text: String =
        text.chars().filter(|c| !matches!(c, ' ' | '\u{a0}' | '\u{202f}' | '\u{b7}' | '*' | '.')).collect();
    text.replace('\u{b2}', "2").replace('\u{b3}', "3")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against numbers from elsewhere: NIST SP 811 (2008), appendix B.8, to the digits it prints.
    #[test]
    fn factors_are_those_of_the_tables() {
        for (quantity, unit, table) in [
            (Quantity::Force, "kgf", 9.806_65),
            (Quantity::Force, "kp", 9.806_65),
            (Quantity::Force, "gf", 9.806_65e-3),
            (Quantity::Force, "lbf", 4.448_222),
            (Quantity::Force, "ozf", 2.780_139e-1),
            (Quantity::Force, "dyn", 1e-5),
            (Quantity::Mass, "oz", 2.834_952e-2),
            (Quantity::Mass, "lb", 4.535_924e-1),
            (Quantity::Length, "inch", 2.54e-2),
            (Quantity::Length, "mil", 2.54e-5),
            (Quantity::Length, "ft", 3.048e-1),
            (Quantity::Length, "\u{b5}m", 1e-6),
            (Quantity::Length, "micron", 1e-6),
            (Quantity::Time, "min", 60.0),
            (Quantity::Time, "h", 3600.0),
            (Quantity::Time, "\u{3bc}s", 1e-6),
            (Quantity::Time, "Milliseconds", 1e-3),
            (Quantity::Angle, "\u{b0}", 1.745_329e-2),
        ] {
            let factor = quantity.unit(unit).unwrap_or_else(|| panic!("{unit} is not known")).si;
            assert!((factor / table - 1.0).abs() < 1e-6, "{unit}: {factor} {table}");
        }
    }

    /// Exact by definition.
    #[test]
    fn inches_ounces_and_gram_weights_are_exact() {
        let si = |quantity: Quantity, unit: &str| quantity.unit(unit).unwrap().si;
        assert_eq!(si(Quantity::Length, "in"), 25.4e-3);
        assert_eq!(si(Quantity::Mass, "oz"), 28.349_523_125e-3);
        assert!((si(Quantity::Force, "gf") * 1e3 - 9.806_65).abs() < 2e-15);
        assert_eq!(si(Quantity::Weight, "N") * GRAVITY, 1.0);
    }

    /// What would be wrong by a factor of 1e9 is not guessed.
    #[test]
    fn capitals_that_matter() {
        assert_eq!(Quantity::Force.unit("MN"), None);
        assert_eq!(Quantity::Time.unit("MS"), None);
        assert_eq!(Quantity::Force.unit("mn").unwrap().symbol, "mN");
        assert_eq!(Quantity::Length.unit("MM"), None);
        assert_eq!(Quantity::Length.unit("Mm"), None);
        assert_eq!(Quantity::Force.unit("V"), None);
        assert_eq!(Quantity::Number.unit("mm"), None);
        assert!(Quantity::Length.known().starts_with("m, dm, cm, mm"));
    }

    /// No name means two units of one quantity, the SI unit is first, and every quantity is listed once.
    #[test]
    fn units_are_distinct() {
        for (n, quantity) in Quantity::ALL.into_iter().enumerate() {
            assert!(!Quantity::ALL[..n].contains(&quantity));
            let units = quantity.units();
            assert!(units.first().is_none_or(|unit| unit.si == 1.0), "{quantity:?}");
            for unit in units {
                for name in unit.also.iter().chain([&unit.symbol]) {
                    let found = quantity.unit(name).unwrap_or_else(|| panic!("{quantity:?} {name}"));
                    assert_eq!(found.symbol, unit.symbol, "{quantity:?} {name}");
                }
            }
        }
    }

    #[test]
    fn names_end_with_their_units() {
        for (name, quantity, unit) in [
            ("body.hammer.mass_g", Quantity::Mass, "g"),
            ("zone.capstan_heel.disc.center_mm.x", Quantity::Length, "mm"),
            ("zone.string.felt.stiffness_N_per_m_r", Quantity::FeltStiffness, "N/m^r"),
            ("zone.string.felt.damping_N_s_per_m3", Quantity::FeltDamping, "N s/m3"),
            ("body.key.inertia_kg_m2", Quantity::Inertia, "kg m2"),
            ("spring.repetition.torque_N_m", Quantity::Torque, "N m"),
            ("spring.key_bending.stiffness_N_m_per_rad", Quantity::AngularStiffness, "N m/rad"),
            ("gravity_m_s2", Quantity::Acceleration, "m/s2"),
            ("body.key_back.viscous_N_m_s", Quantity::AngularDamping, "N m s/rad"),
            ("hammer_rise_m_per_s", Quantity::Speed, "m/s"),
            ("key_rad_per_s", Quantity::AngularSpeed, "rad/s"),
            ("strings.mass_g_per_m", Quantity::LineDensity, "g/m"),
            ("strings.loss_per_s", Quantity::Rate, "1/s"),
            ("force_N", Quantity::Force, "N"),
            ("back_check_angle_degrees", Quantity::Angle, "deg"),
        ] {
            let (found, own) = Quantity::of_name(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!((found, own.symbol), (quantity, unit), "{name}");
        }
        for name in ["zone.jack_knuckle.friction_coefficient", "string_modes", "loss_factor", "m", "_m"] {
            assert_eq!(Quantity::of_name(name), None, "{name}");
        }
    }
}
