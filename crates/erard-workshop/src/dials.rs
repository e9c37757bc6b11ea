//! Quantities that a technician adjusts at the bench or a designer changes, each with its unit and its range: the
//! screws of the file, and designers' common numbers. A page shows them as sliders.
//!
//! A dial changes numbers of the instrument's file only: the result is a file again, which its reader checks.

use erard::grand::Parts;
use erard::instrument::{Instrument, InstrumentFile, ScrewAction, Vec2, with_numbers};
use erard::parameter::{Bare, Change, FileNumber, NumberError, Parameter, Quantity, in_file_unit};
use serde::Serialize;

use crate::regulate::known_screw;

/// Group of dials in a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Group {
    /// The screws of the file.
    Screws,
    /// Places of parts.
    Places,
    /// Masses.
    Weights,
    /// Felts and springs.
    Felts,
    /// Pivots and rubbing surfaces.
    Friction,
}

/// A slider: name, value with unit, range, and the numbers of the file that it changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dial {
    /// Name, unique in the instrument: a screw's own, else e.g. `knuckle`.
    pub name: String,
    /// Name at the bench.
    pub label: String,
    /// Effect of a larger value.
    pub note: String,
    /// Group in the list.
    pub group: Group,
    /// Unit: `mm`, `deg`, `g`, `N mm`, or `x` for a factor that is 1 in the file.
    pub unit: &'static str,
    /// Significant decimals.
    pub decimals: usize,
    /// Value in this instrument.
    pub value: f64,
    /// Lower end of its range.
    pub from: f64,
    /// Upper end of its range.
    pub to: f64,
    #[serde(skip)]
    kind: Kind,
}

/// Numbers of the file, by path and component.
type Numbers = Vec<(String, usize, f64)>;

#[derive(Debug, Clone, PartialEq)]
enum Kind {
    /// The number itself; the dial's value times this factor is in the file's unit.
    Itself(String, f64),
    /// All of them change by the same difference as the first.
    Together(Numbers),
    /// All of them are multiplied by the same factor.
    Times(Numbers),
    /// The first takes the dial's value, the others change in proportion.
    InProportion(Numbers),
    /// Adds a lead of the dial's mass at a place of a body with this mass (g), centre of mass (mm) and inertia (kg m2).
    Lead { body: String, at_mm: Vec2, mass_g: f64, centre_mm: Vec2, inertia_kg_m2: f64 },
    /// A horizontal place at this distance from another one, on this side of it, with this difference in height.
    Distance { path: String, to_mm: Vec2, height_mm: f64, side: f64 },
}

/// Range of felts and friction in both directions, as a factor.
const FACTOR: f64 = 3.0;
/// Place of a new lead, mm in front of the balance pin: the mean of the built-in grand's (0.62 and 0.55 of 265 mm).
const LEAD_AT_MM: f64 = 155.0;

/// Returns all dials of an instrument; only its screws if it is no grand action.
#[must_use]
pub fn dials(file: &InstrumentFile) -> Vec<Dial> {
    let mut all: Vec<Dial> = (0..file.instrument.screws.len()).filter_map(|screw| of_screw(file, screw)).collect();
    if let Ok(parts) = Parts::of(&file.instrument) {
        all.extend(places(file, &parts));
        all.extend(weights(file, &parts));
        all.extend(felts(file));
        all.extend(springs(file, &parts));
        all.extend(friction(file));
    }
    all
}

/// Returns the file's text with dials set: names and values. Every dial counts from `file`, whatever the others.
///
/// # Errors
/// A line that names the unknown dial, or the exceeded range.
pub fn with_dials(file: &InstrumentFile, text: &str, wanted: &[(String, f64)]) -> Result<String, String> {
    let all = dials(file);
    let mut changes: Numbers = Vec::new();
    for (name, value) in wanted {
        let dial = find(&all, name)?;
        dial.check(*value)?;
        changes.extend(dial.changes(*value));
    }
    let borrowed: Vec<(&str, usize, f64)> =
        changes.iter().map(|(path, which, value)| (path.as_str(), *which, *value)).collect();
    with_numbers(text, &borrowed).ok_or_else(|| "the text does not hold the numbers of its instrument".to_owned())
}

/// Reason why a typed text is no value of a dial.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DialError {
    /// There is no such dial.
    #[error("{0}")]
    Unknown(String),
    /// The text is no change of the dial.
    #[error("`{name}`: {error}")]
    Text {
        /// Name of the dial.
        name: String,
        /// What is wrong.
        error: NumberError,
    },
    /// The value is out of the dial's range.
    #[error("{0}")]
    Range(String),
}

/// Returns the value of a dial after a typed change ([`Change::read`]); a number without a unit is in the dial's unit.
///
/// # Errors
/// See [`DialError`].
pub fn typed_value(file: &InstrumentFile, name: &str, text: &str) -> Result<f64, DialError> {
    let all = dials(file);
    let dial = find(&all, name).map_err(DialError::Unknown)?;
    // A factor of the file's number is a number without a unit.
    let own = Quantity::ALL.into_iter().find_map(|quantity| Some((quantity, quantity.unit(dial.unit)?)));
    let (quantity, bare) =
        own.map_or((Quantity::Number, Bare::Si), |(quantity, unit)| (quantity, Bare::In(unit.symbol)));
    let change =
        Change::read(text, quantity, bare).map_err(|error| DialError::Text { name: name.to_owned(), error })?;
    let value = tidy(in_file_unit(change, dial.value, own.map(|(_, unit)| unit)));
    dial.check(value).map_err(DialError::Range)?;
    Ok(value)
}

fn find<'d>(all: &'d [Dial], name: &str) -> Result<&'d Dial, String> {
    all.iter().find(|dial| dial.name == name).ok_or_else(|| {
        let known = all.iter().map(|dial| dial.name.as_str()).collect::<Vec<_>>().join(", ");
        format!("there is no dial `{name}`; expected one of {known}")
    })
}

impl Dial {
    /// Checks that a value is within the range.
    fn check(&self, value: f64) -> Result<(), String> {
        let Dial { name, from, to, unit, .. } = self;
        let slack = 1e-9 * (to - from);
        if (from - slack..=to + slack).contains(&value) {
            return Ok(());
        }
        Err(format!("`{name}` is {value} {unit}; expected a number from {from} to {to} {unit}"))
    }

    /// Returns the numbers of the file for a value, in the file's own units.
    #[must_use]
    fn changes(&self, value: f64) -> Numbers {
        let by = value - self.value;
        match &self.kind {
            Kind::Itself(path, units) => vec![(path.clone(), 0, tidy(value * units))],
            Kind::Together(numbers) => moved(numbers, |old| old + by),
            Kind::Times(numbers) => moved(numbers, |old| old * value),
            Kind::InProportion(numbers) => moved(numbers, |old| old * value / self.value),
            Kind::Lead { body, at_mm, mass_g, centre_mm, inertia_kg_m2 } => {
                let mass = mass_g + value;
                let centre = |k: usize| (mass_g * centre_mm[k] + value * at_mm[k]) / mass;
                let arm2_m2 = 1e-6 * (at_mm[0] * at_mm[0] + at_mm[1] * at_mm[1]);
                vec![
                    (FileNumber::BODY_MASS.path(body), 0, tidy(mass)),
                    (FileNumber::BODY_CENTER.path(body), 0, tidy(centre(0))),
                    (FileNumber::BODY_CENTER.path(body), 1, tidy(centre(1))),
                    (FileNumber::BODY_INERTIA.path(body), 0, tidy(inertia_kg_m2 + 1e-3 * value * arm2_m2)),
                ]
            }
            Kind::Distance { path, to_mm, height_mm, side } => {
                let across = (value * value - height_mm * height_mm).max(0.0).sqrt();
                vec![(path.clone(), 0, tidy(to_mm[0] + side * across))]
            }
        }
    }
}

fn moved(numbers: &Numbers, new: impl Fn(f64) -> f64) -> Numbers {
    numbers.iter().map(|(path, which, old)| (path.clone(), *which, tidy(new(*old)))).collect()
}

/// Rounds to nine digits, as in a file, to remove the rounding errors of sums.
fn tidy(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// Returns a number of the file in its own unit.
fn number(file: &InstrumentFile, path: &str, which: usize) -> Option<f64> {
    let numbers = &file.provenance.numbers;
    numbers.iter().find(|number| number.key == path).and_then(|number| number.values.get(which)).copied()
}

fn numbers(file: &InstrumentFile, paths: impl IntoIterator<Item = (String, usize)>) -> Option<Numbers> {
    let found: Option<Numbers> =
        paths.into_iter().map(|(path, which)| number(file, &path, which).map(|value| (path, which, value))).collect();
    found.filter(|found| !found.is_empty())
}

/// The numbers of the file that a parameter changes.
fn of_parameter(file: &InstrumentFile, parameter: &Parameter) -> Option<Numbers> {
    numbers(file, parameter.paths(&file.instrument).ok()?.into_iter().map(|path| (path, 0)))
}

/// Returns a name as spoken: `let_off` becomes `let-off`.
fn spoken(name: &str) -> String {
    const HYPHENED: [(&str, &str); 3] =
        [("let off", "let-off"), ("back rail", "back-rail"), ("balance rail", "balance-rail")];
    HYPHENED.iter().fold(name.replace('_', " "), |text, (from, to)| text.replace(from, to))
}

fn of_screw(file: &InstrumentFile, index: usize) -> Option<Dial> {
    let instrument = &file.instrument;
    let screw = &instrument.screws[index];
    let known = known_screw(&screw.name);
    let limits = known.map(|known| known.limits(instrument, screw));
    let quantity = screw.action.quantity();
    let (si, _) = screw.action.shown_unit();
    let shown = quantity.trade_unit()?;
    let decimals = if quantity == Quantity::Length { 2 } else { 1 };
    // The dial of a spring is in N mm, its file in N m.
    let units = shown.si / screw.action.file_unit().si;
    let path = Parameter::Screw { screw: index, action: screw.action.clone() }.path(instrument).ok()?;
    let value = number(file, &path, 0)? / units;
    let [from, to] = limits.map_or([value - 2.0, value + 2.0], |limits| limits.map(|limit| limit * si));
    Some(Dial {
        name: screw.name.clone(),
        label: known
            .and_then(|known| known.sets)
            .map_or_else(|| spoken(&screw.name), |what| format!("{} ({what})", spoken(&screw.name))),
        note: screw.label.clone(),
        group: Group::Screws,
        unit: shown.symbol,
        decimals,
        value,
        from: from.min(value),
        to: to.max(value),
        kind: Kind::Itself(path, units),
    })
}

struct Look {
    name: &'static str,
    label: &'static str,
    note: &'static str,
    group: Group,
    unit: &'static str,
    decimals: usize,
}

impl Look {
    fn dial(&self, value: f64, [from, to]: [f64; 2], kind: Kind) -> Dial {
        let Look { name, label, note, group, unit, decimals } = *self;
        Dial { name: name.into(), label: label.into(), note: note.into(), group, unit, decimals, value, from, to, kind }
    }
}

fn places(file: &InstrumentFile, parts: &Parts) -> Vec<Dial> {
    let i = &file.instrument;
    let rides_on = |part: usize, body: Option<usize>| body.is_some_and(|body| root(i, body) == root(i, part));
    let mut all = Vec::new();
    let place = |name, label, note| Look { name, label, note, group: Group::Places, unit: "mm", decimals: 1 };
    let capstan =
        i.zones.iter().find(|zone| rides_on(parts.key, zone.disc_body) && zone.curve_body == Some(parts.whippen));
    if let Some(zone) = capstan
        && let Some(found) = numbers(file, [(FileNumber::DISC_CENTER.path(&zone.name), 0)])
    {
        let at = found[0].2;
        let look = place(
            "capstan",
            "capstan, from the balance pin",
            "moves the capstan to the back: a lighter hammer feels heavier, and flies higher for the dip",
        );
        all.push(look.dial(at, [at - 8.0, at + 8.0], Kind::Together(found)));
    }
    let knuckle = i.roles.knuckle.iter().map(|&zone| (FileNumber::DISC_CENTER.path(&i.zones[zone].name), 0));
    if let Some(found) = numbers(file, knuckle) {
        let at = found[0].2;
        let look = place(
            "knuckle",
            "knuckle, from the hammer's centre",
            "moves the knuckle outward: less leverage, a lighter touch, less blow",
        );
        all.push(look.dial(at, [at - 2.0, at + 2.0], Kind::Together(found)));
    }
    let hammer_root = &i.bodies[root(i, parts.hammer)];
    let whippen = &i.bodies[parts.whippen];
    if whippen.parent.is_none() {
        let path = FileNumber::BODY_PIVOT.path(&whippen.name);
        let [to, own] = [hammer_root.pivot_m, whippen.pivot_m].map(|pivot| pivot.map(|c| 1e3 * c));
        let [x, y] = [own[0] - to[0], own[1] - to[1]];
        let spread = x.hypot(y);
        let look = place(
            "spread",
            "spread, whippen's to hammer's centre",
            "moves the whippens away from the hammers' centres: the jack stands elsewhere under the knuckle",
        );
        let kind = Kind::Distance { path, to_mm: to, height_mm: y, side: x.signum() };
        all.push(look.dial(spread, [spread - 2.0, spread + 2.0], kind));
    }
    all
}

fn weights(file: &InstrumentFile, parts: &Parts) -> Vec<Dial> {
    let i = &file.instrument;
    let mut all = Vec::new();
    let look = |name, label, note| Look { name, label, note, group: Group::Weights, unit: "g", decimals: 1 };
    if let Some(found) = of_parameter(file, &Parameter::Mass(parts.hammer)) {
        let mass = found[0].2;
        let look = look(
            "hammer",
            "hammer, with what bends of its shank",
            "a heavier hammer: every gram is five to six on the key",
        );
        all.push(look.dial(mass, [0.5 * mass, 1.6 * mass], Kind::InProportion(found)));
    }
    let key = &i.bodies[parts.key];
    let of_key = |own: FileNumber, which: usize| number(file, &own.path(&key.name), which);
    if let (Some(mass_g), Some(x), Some(y), Some(inertia_kg_m2)) = (
        of_key(FileNumber::BODY_MASS, 0),
        of_key(FileNumber::BODY_CENTER, 0),
        of_key(FileNumber::BODY_CENTER, 1),
        of_key(FileNumber::BODY_INERTIA, 0),
    ) {
        let front_mm = i.roles.key_front_m.map(|c| 1e3 * c);
        let pivot = i.drawn()[parts.key].pivot_m.map(|c| 1e3 * c);
        // On the line from the pin to the key's front, half-way up the stick.
        let at_mm = [-LEAD_AT_MM - pivot[0], 0.5 * front_mm[1]];
        let least = -0.25 * mass_g;
        let look = look(
            "leads",
            "leads, 155 mm before the balance pin",
            "more lead in the key: a lower down-weight and up-weight, and more inertia",
        );
        let kind = Kind::Lead { body: key.name.clone(), at_mm, mass_g, centre_mm: [x, y], inertia_kg_m2 };
        all.push(look.dial(0.0, [least.max(-15.0), 30.0], kind));
    }
    all
}

fn felts(file: &InstrumentFile) -> Vec<Dial> {
    let i = &file.instrument;
    let mut all = Vec::new();
    let mut felt = |zone: Option<usize>, look: Look| {
        if let Some(found) = zone.and_then(|zone| of_parameter(file, &Parameter::Stiffness(zone))) {
            all.push(look.dial(1.0, [1.0 / FACTOR, FACTOR], Kind::Times(found)));
        }
    };
    let look = |name, label, note| Look { name, label, note, group: Group::Felts, unit: "x", decimals: 2 };
    felt(
        i.roles.string,
        look("hammer_felt", "hammer felt's stiffness", "a harder hammer: a shorter contact with the string"),
    );
    let knuckle = i.roles.knuckle.first().copied();
    felt(knuckle, look("knuckle_felt", "knuckle's stiffness", "a softer knuckle: the hammer follows the key later"));
    felt(
        i.roles.key_bottom,
        look("front_felt", "front punching's stiffness", "a softer key bottom: more dip under a firm finger"),
    );
    felt(i.roles.check, look("check_felt", "back check's stiffness", "a softer leather: the hammer is caught lower"));
    all
}

/// Dials of springs that no screw turns, and of flexible parts.
fn springs(file: &InstrumentFile, parts: &Parts) -> Vec<Dial> {
    let i = &file.instrument;
    let turned = |spring: usize| {
        i.screws.iter().any(|screw| matches!(screw.action, ScrewAction::Spring { spring: own } if own == spring))
    };
    let dial = |index: usize| {
        let spring = &i.springs[index];
        let whose = root(i, spring.body);
        let (name, parameter, label, note) = if !i.bodies[spring.body].is_bend {
            let note = "a stronger spring: its part is back sooner, and more is felt of it";
            let label = format!("{} spring's torque", spoken(&spring.name));
            (format!("{}_spring", spring.name), Parameter::Torque(index), label, note)
        } else if whose == root(i, parts.key) {
            let note = "a stiffer key: its front goes less far before the hammer moves";
            (spring.name.clone(), Parameter::SpringStiffness(index), "key's stiffness in bending".to_owned(), note)
        } else if whose == root(i, parts.hammer) {
            let note = "a stiffer shank: the head lags less behind its root when the hammer is thrown hard";
            (
                spring.name.clone(),
                Parameter::SpringStiffness(index),
                "hammer shank's stiffness in bending".to_owned(),
                note,
            )
        } else {
            return None;
        };
        let found = of_parameter(file, &parameter).filter(|found| found[0].2 != 0.0)?;
        Some(Dial {
            name,
            label,
            note: note.into(),
            group: Group::Felts,
            unit: "x",
            decimals: 2,
            value: 1.0,
            from: 1.0 / FACTOR,
            to: FACTOR,
            kind: Kind::Times(found),
        })
    };
    (0..i.springs.len()).filter(|&index| !turned(index)).filter_map(dial).collect()
}

fn friction(file: &InstrumentFile) -> Vec<Dial> {
    let i = &file.instrument;
    let pivots = Parameter::all(i).into_iter().filter(|(_, own)| matches!(own, Parameter::PivotFriction(_)));
    let pivots = pivots.filter_map(|(_, own)| Some((own.path(i).ok()?, 0)));
    let look = |name, label, note| Look { name, label, note, group: Group::Friction, unit: "x", decimals: 2 };
    let mut all = Vec::new();
    if let Some(found) = numbers(file, pivots) {
        let look = look("pivots", "friction of all pivots", "tighter pins: down-weight up, up-weight down");
        all.push(look.dial(1.0, [1.0 / FACTOR, FACTOR], Kind::Times(found)));
    }
    let rubbing = i.roles.knuckle.iter().filter_map(|&zone| Some((Parameter::Friction(zone).path(i).ok()?, 0)));
    if let Some(found) = numbers(file, rubbing.filter(|(path, _)| number(file, path, 0).is_some_and(|mu| mu > 0.0))) {
        let look =
            look("knuckle_friction", "friction at the knuckle", "rougher jack or knuckle: more is felt at let-off");
        all.push(look.dial(1.0, [1.0 / FACTOR, 2.0], Kind::Times(found)));
    }
    all
}

/// The body hinged on the ground at the end of a body's chain.
fn root(instrument: &Instrument, mut body: usize) -> usize {
    while let Some(parent) = instrument.bodies[body].parent {
        body = parent;
    }
    body
}
