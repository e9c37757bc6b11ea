//! The table of typed texts that command, Python, C and studio are held against, generated from the register: every
//! name, with every unit of its quantity, and every spelling. Its numbers come from the definitions of the units below
//! and not from the reader.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use erard::instrument::{InstrumentFile, numbers_at};
use erard::parameter::{Entry, NameError, Parameter, Quantity, aliases, canonical_name, register};
use erard::{Instrument, parameter};

use crate::common::generated::is_current;

/// Standard gravity, m/s2; inch, m; avoirdupois pound, kg: all by definition.
const G: f64 = 9.806_65;
const IN: f64 = 0.0254;
const LB: f64 = 0.453_592_37;
const OZ: f64 = 0.028_349_523_125;
const DEG: f64 = PI / 180.0;

/// Every name of every unit, and the SI value of one.
#[rustfmt::skip]
const UNITS: &[(Quantity, &[(f64, &str)])] = &[
    (Quantity::Number, &[]),
    (Quantity::Share, &[(1.0, "1"), (0.01, "%|percent|per cent|pct")]),
    (Quantity::Length, &[
        (1.0, "m|meter|meters|metre|metres"), (0.1, "dm"), (0.01, "cm|centimeter|centimeters|centimetre|centimetres"),
        (1e-3, "mm|millimeter|millimeters|millimetre|millimetres"), (1e-9, "nm|nanometer|nanometers|nanometre|nanometres"),
        (1e-6, "um|\u{b5}m|\u{3bc}m|micron|microns|micrometer|micrometers|micrometre|micrometres"),
        (IN, "in|inch|inches|\"|\u{2033}|\u{201d}|''"), (IN / 1e3, "mil|mils|thou"), (12.0 * IN, "ft|foot|feet"),
    ]),
    (Quantity::Angle, &[(1.0, "rad|radian|radians"), (DEG, "deg|degree|degrees|\u{b0}"), (1e-3, "mrad|milliradian|milliradians")]),
    (Quantity::Mass, &[
        (1.0, "kg|kilogram|kilograms"), (1e-3, "g|gram|grams|gramme|grammes|gr"), (1e-6, "mg|milligram|milligrams"),
        (OZ, "oz|ounce|ounces"), (LB, "lb|lbs|pound|pounds"),
    ]),
    (Quantity::Weight, &[
        (1.0, "kg|kilogram|kilograms|kgf|kp|kilopond"), (1e-3, "g|gram|grams|gramme|grammes|gr|gf|p|pond"),
        (OZ, "oz|ounce|ounces|ozf"), (LB, "lb|lbs|pound|pounds|lbf"), (1.0 / G, "N|newton|newtons"),
        (0.01 / G, "cN|centinewton|centinewtons"), (1e-3 / G, "mN|millinewton|millinewtons"),
    ]),
    (Quantity::Force, &[
        (1.0, "N|newton|newtons"), (1e-3, "mN|millinewton|millinewtons"), (0.01, "cN|centinewton|centinewtons"),
        (10.0, "daN|decanewton|decanewtons"), (1e3, "kN|kilonewton|kilonewtons"), (1e-5, "dyn|dyne|dynes"),
        (1e-3 * G, "gf|g|gram|grams|gramme|grammes|gr|p|pond"), (G, "kgf|kg|kilogram|kilograms|kp|kilopond"),
        (LB * G, "lbf|lb|lbs|pound|pounds"), (OZ * G, "ozf|oz|ounce|ounces"),
    ]),
    (Quantity::Time, &[
        (1.0, "s|sec|secs|second|seconds"), (1e-3, "ms|msec|millisecond|milliseconds"), (60.0, "min|minute|minutes"),
        (1e-6, "us|\u{b5}s|\u{3bc}s|usec|microsecond|microseconds"), (1e-9, "ns|nanosecond|nanoseconds"),
        (3600.0, "h|hour|hours"),
    ]),
    (Quantity::Speed, &[
        (1.0, "m/s|m_per_s|ms-1|ms^-1|mps"), (0.01, "cm/s|cm_per_s"), (1e-3, "mm/s|mm_per_s"), (IN, "in/s|in_per_s"),
    ]),
    (Quantity::AngularSpeed, &[(1.0, "rad/s|rad_per_s"), (DEG, "deg/s|\u{b0}/s")]),
    (Quantity::AngularAcceleration, &[(1.0, "rad/s2|rad/s^2")]),
    (Quantity::Acceleration, &[(1.0, "m/s2|m/s^2|m_per_s2")]),
    (Quantity::Frequency, &[(1.0, "Hz|hertz"), (1e3, "kHz|kilohertz")]),
    (Quantity::Energy, &[(1.0, "J|joule|joules"), (1e-3, "mJ")]),
    (Quantity::Inertia, &[
        (1.0, "kg m2|kgm^2"), (1e-3, "g m2|gm^2"), (1e-7, "g cm2|gcm^2"), (1e-9, "g mm2|gmm^2"), (1e-6, "kg mm2|kgmm^2"),
    ]),
    (Quantity::Torque, &[
        (1.0, "N m"), (0.01, "N cm"), (1e-3, "N mm|mnm"), (1e-5 * G, "gf cm|gcm"), (1e-6 * G, "gf mm|gmm"),
    ]),
    (Quantity::AngularStiffness, &[(1.0, "N m/rad"), (1e-3, "N mm/rad"), (1.0 / DEG, "N m/deg")]),
    (Quantity::AngularDamping, &[(1.0, "N m s/rad|nms"), (1e-3, "N mm s/rad|nmms")]),
    (Quantity::Stiffness, &[(1.0, "N/m"), (1e3, "N/mm|kn/m"), (1e6, "N/um")]),
    (Quantity::Damping, &[(1.0, "N s/m|ns/m"), (1e-3, "mN s/m")]),
    (Quantity::FeltStiffness, &[(1.0, "N/m^r")]),
    (Quantity::FeltDamping, &[(1.0, "N s/m3|ns/m^3")]),
    (Quantity::Slowness, &[(1.0, "s/m")]),
    (Quantity::LineDensity, &[(1.0, "kg/m"), (1e-3, "g/m"), (0.1, "g/cm")]),
    (Quantity::Compliance, &[(1.0, "m/N"), (1e-3, "mm/N|um/mn")]),
    (Quantity::Rate, &[(1.0, "1/s|s-1|s^-1")]),
    (Quantity::Pitch, &[(1.0, "cents|cent|ct")]),
];

/// Names of a quantity's units, the usual ones first, each with the SI value of one.
fn units(quantity: Quantity) -> Vec<(&'static str, f64)> {
    let (_, units) = UNITS.iter().find(|(own, _)| *own == quantity).expect("every quantity is listed");
    let names = |first: bool| {
        units.iter().flat_map(move |(si, names)| {
            names.split('|').enumerate().filter(move |(n, _)| (*n == 0) == first).map(|(_, name)| (name, *si))
        })
    };
    names(true).chain(names(false)).collect()
}

/// SI value of one of a unit.
fn si(quantity: Quantity, name: &str) -> f64 {
    units(quantity).iter().find(|(own, _)| *own == name).unwrap_or_else(|| panic!("{quantity:?} {name}")).1
}

fn usual_count(quantity: Quantity) -> usize {
    UNITS.iter().find(|(own, _)| *own == quantity).map_or(0, |(_, units)| units.len())
}

/// A value to six digits, as a person would type it.
fn digits(value: f64) -> String {
    format!("{}", format!("{value:.5e}").parse::<f64>().unwrap())
}

struct Table {
    rows: Vec<String>,
}

impl Table {
    #[allow(clippy::too_many_arguments)]
    fn row(&mut self, at: &Place, text: &str, command: &str, other: &str) {
        let Place { instrument, name, path, file_si } = at;
        self.rows.push(format!("{instrument}\t{name}\t{text}\t{command}\t{other}\t{path}\t{file_si:e}"));
    }

    /// The same of all fronts.
    fn all(&mut self, at: &Place, text: &str, expected: &str) {
        self.row(at, text, expected, expected);
    }

    fn set(&mut self, at: &Place, (unit, si): (&str, f64), wanted: f64) {
        let typed = digits(wanted / si);
        let value: f64 = typed.parse().unwrap();
        // A value with a sign needs `=`, or it is a change.
        let sign = if value < 0.0 { "=" } else { "" };
        self.all(at, &format!("{sign}{typed} {unit}"), &format!("set {:e}", value * si));
    }
}

/// A number: its instrument, the name that is typed, its path in the file (empty where the file's number is another),
/// and the SI value of one of the file's unit.
struct Place {
    instrument: &'static str,
    name: String,
    path: String,
    file_si: f64,
}

/// A value unlike the present one that the number may have.
fn wanted(entry: &Entry) -> f64 {
    match entry.quantity {
        _ if entry.parameter.is_factor() => 1.01 * entry.value,
        // A degree: studies keep nine decimals of it.
        Quantity::Angle => 1.7e-2,
        _ => 1.7e-4,
    }
}

/// How a bare value is taken by those who read SI units.
fn bare(entry: &Entry, value: f64) -> String {
    let [least, most] = entry.parameter.range();
    let by = if entry.parameter.is_factor() { value / entry.value } else { value - entry.value };
    if (least..=most).contains(&by) { format!("set {value:e}") } else { "no out of range".to_owned() }
}

/// Texts of one number: signs, factors, commas, bare values, and what is refused.
fn spellings(table: &mut Table, at: &Place, entry: &Entry) {
    let quantity = entry.quantity;
    let trade = quantity.trade_unit().map_or("", |unit| unit.symbol);
    let one = if trade.is_empty() { 1.0 } else { si(quantity, trade) };
    let value = digits(wanted(entry) / one);
    let in_si: f64 = value.parse::<f64>().unwrap() * one;
    let step = digits(0.01 * wanted(entry) / one);
    let by: f64 = step.parse::<f64>().unwrap() * one;
    for text in [format!("={value}{trade}"), format!("= {value} {trade}"), format!(" {value} {trade} ")] {
        table.all(at, text.trim_end_matches('\t'), &format!("set {in_si:e}"));
    }
    for (sign, expected) in [("+", by), ("-", -by), ("\u{2212}", -by)] {
        table.all(at, &format!("{sign}{step} {trade}"), &format!("add {expected:e}"));
    }
    for factor in ["x1.05", "X1.05", "*1.05", "\u{d7}1.05"] {
        table.all(at, factor, "times 1.05");
    }
    // A list, for the command.
    table.row(at, "x1,05", "-", "times 1.05");
    table.all(at, "-0", "add 0");
    table.all(at, &format!("-0 {trade}"), "add 0");
    // A number without a unit: the command has the trade's, the others SI.
    let other = bare(entry, value.parse().unwrap());
    table.row(at, &value, &format!("set {in_si:e}"), &other);
    // A decimal comma; the command asks for a list.
    if let Some((whole, part)) = value.split_once('.').filter(|(_, part)| part.len() != 3 && !trade.is_empty()) {
        let list = format!("no type `{whole}.{part} {trade}`");
        table.row(at, &format!("{whole},{part} {trade}"), &list, &format!("set {in_si:e}"));
    }
    table.row(at, &format!("1,500{trade}"), "-", "no may be 1.500");
    for text in ["ten", "nan", "inf", "-", "=", "--1", "0x10"] {
        table.all(at, text, "no expected");
    }
    table.all(at, "x", "no a factor");
    table.all(at, "x2 mm", "no a factor");
    // A unit of another quantity.
    let foreign = if quantity == Quantity::Length { "g" } else { "mm" };
    let refused = if trade.is_empty() { "no expected a number" } else { "no is not one of its units" };
    table.all(at, &format!("1 {foreign}"), refused);
    if quantity == Quantity::Mass {
        table.all(at, "7 1/2 g", "set 7.5e-3");
        table.all(at, "8-1/2g", "set 8.5e-3");
    }
}

fn made() -> String {
    let mut table = Table { rows: vec!["instrument\tname\ttext\tcommand\tother\tpath\tfile_si".to_owned()] };
    let mut named: BTreeSet<&'static str> = BTreeSet::new();
    for instrument in ["concert-grand", "concert-grand-strings"] {
        let text = Instrument::builtin_text(instrument).unwrap();
        let file = InstrumentFile::builtin(instrument).unwrap();
        if instrument == "concert-grand" {
            registered(&mut table, &mut named, instrument, &file, text);
        }
        // Other quantities by the path of a number of the file.
        for number in &file.provenance.numbers {
            let Some((quantity, unit)) = Quantity::of_name(&number.key) else { continue };
            let ([value], Some([_])) = (&number.values[..], numbers_at(text, &number.key).as_deref()) else { continue };
            if *value <= 0.0 || !named.insert(quantity.name()) {
                continue;
            }
            let own = si(quantity, unit.symbol);
            let at = Place { instrument, name: number.key.clone(), path: number.key.clone(), file_si: own };
            for unit in units(quantity) {
                table.set(&at, unit, value * own);
            }
            table.all(&at, &digits(*value), &format!("set {:e}", digits(*value).parse::<f64>().unwrap() * own));
            table.all(&at, "1 parsec", "no is not one of its units");
        }
    }
    table.rows.join("\n") + "\n"
}

fn registered(
    table: &mut Table,
    named: &mut BTreeSet<&'static str>,
    instrument: &'static str,
    file: &InstrumentFile,
    text: &str,
) {
    let grand = &file.instrument;
    for entry in register(file) {
        if numbers_at(text, &entry.path).is_none() {
            continue;
        }
        let file_si = Quantity::of_name(&entry.path).map_or(1.0, |(quantity, unit)| si(quantity, unit.symbol));
        // A spring's torque has a screw's part in it: the number of the file is another.
        let is_own = numbers_at(text, &entry.path).is_some_and(|own| {
            own.first().is_some_and(|own| (own * file_si - entry.value).abs() < 1e-9 * entry.value.abs().max(1e-9))
        });
        let path = if is_own { entry.path.clone() } else { String::new() };
        let place = |name: &str| Place { instrument, name: name.to_owned(), path: path.clone(), file_si };
        let at = place(&entry.name);
        let is_first = named.insert(entry.quantity.name());
        // One number of each quantity has every name of every unit, the others the usual ones.
        let count = if is_first { usize::MAX } else { usual_count(entry.quantity) };
        for unit in units(entry.quantity).into_iter().take(count) {
            table.set(&at, unit, wanted(&entry));
        }
        if entry.quantity == Quantity::Number {
            let value = digits(wanted(&entry));
            table.all(&at, &value, &format!("set {:e}", value.parse::<f64>().unwrap()));
        }
        if is_first {
            spellings(table, &at, &entry);
        }
        for alias in aliases(&entry.name).iter().filter(|alias| canonical_name(alias) == entry.name) {
            table.all(&place(alias), "x1.05", "times 1.05");
        }
    }
    // Names of the hinges at which parts bend do nothing.
    for body in grand.bodies.iter().filter(|body| body.is_bend) {
        let name = format!("body.{}.friction", body.name);
        if let Err(NameError::Idle { acts, .. }) = Parameter::named(grand, &name) {
            let at = Place { instrument, name, path: String::new(), file_si: 1.0 };
            table.all(&at, "x2", &format!("no type `{acts}`"));
        }
    }
    for name in ["let_of", "body.hammer.mas", "zone.check.fricton", "spring.repetition"] {
        let at = Place { instrument, name: name.to_owned(), path: String::new(), file_si: 1.0 };
        table.all(&at, "x2", "no nearest");
    }
}

/// The units of the register are those of the definitions, by every name.
#[test]
fn units_are_as_defined() {
    for quantity in Quantity::ALL {
        let defined: BTreeSet<String> = units(quantity).iter().map(|(name, _)| (*name).to_owned()).collect();
        let own = quantity.units().iter().flat_map(|unit| unit.also.iter().chain([&unit.symbol]));
        let own: BTreeSet<String> = own.map(|name| (*name).to_owned()).collect();
        assert_eq!(own, defined, "{quantity:?}");
        for (name, si) in units(quantity) {
            let found = quantity.read(&format!("1 {name}"), parameter::Bare::Refused).unwrap();
            assert!((found / si - 1.0).abs() < 1e-14, "{quantity:?} {name}: {found} {si}");
        }
    }
}

#[test]
fn the_table_is_the_generated_one() {
    is_current("crates/erard-core/tests/typed-register.tsv", made(), "typed-table");
}
