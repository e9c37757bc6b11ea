//! Register of an instrument's numbers that can be changed by name.

use crate::index::IndexError;
use crate::instrument::reader::MM_PER_M;
use crate::instrument::{FileNumber, Instrument, ScrewAction, numbers_at};
use thiserror::Error;

use super::{Bare, Change, Quantity, Unit, canonical_name};

/// Largest turn of a curve by a screw, rad.
const MAX_TURN_RAD: f64 = std::f64::consts::FRAC_PI_2;
/// Largest displacement by a screw, m, or change of a spring's torque, N m.
const MAX_SCREW: f64 = 0.1;

impl ScrewAction {
    /// Physical quantity of the screw's setting.
    #[must_use]
    pub fn quantity(&self) -> Quantity {
        self.file_number().quantity().0
    }

    /// Number of files that holds the setting.
    #[must_use]
    pub const fn file_number(&self) -> FileNumber {
        match self {
            ScrewAction::Disc { .. } | ScrewAction::Curve { .. } => FileNumber::SCREW_LENGTH,
            ScrewAction::Turn { .. } => FileNumber::SCREW_ANGLE,
            ScrewAction::Spring { .. } => FileNumber::SCREW_TORQUE,
        }
    }

    /// Unit of the setting in files: mm, deg or N m.
    #[must_use]
    pub fn file_unit(&self) -> &'static Unit {
        self.file_number().quantity().1.unwrap_or_else(|| unreachable!("every screw has a unit"))
    }

    /// Key of a setting in files, and the setting in the file's unit, rounded to 0.1 um, 0.0001 degrees or 1 uN m.
    pub(crate) fn in_file(&self, setting: f64) -> (&'static str, f64) {
        let to_digits = |x: f64, per_unit: f64| (x * per_unit).round() / per_unit;
        let setting = match self.quantity() {
            Quantity::Length => to_digits(setting * 1e3, 1e4),
            Quantity::Angle => to_digits(setting.to_degrees(), 1e4),
            _ => to_digits(setting, 1e6),
        };
        (self.file_number().key, setting)
    }

    /// Rounds a setting to the digits of files, as their reader converts them.
    #[must_use]
    pub fn rounded(&self, setting: f64) -> f64 {
        let (_, in_file) = self.in_file(setting);
        match self.quantity() {
            Quantity::Length => in_file / MM_PER_M,
            Quantity::Angle => in_file.to_radians(),
            _ => in_file,
        }
    }

    /// Displayed unit of the setting, and how many of it one SI unit is: mm, degrees or N mm.
    #[must_use]
    pub fn shown_unit(&self) -> (f64, &'static str) {
        match self.quantity() {
            Quantity::Angle => (180.0 / std::f64::consts::PI, "degrees"),
            quantity => quantity.shown(),
        }
    }
}

impl FileNumber {
    /// Physical quantity, and the unit in files; no unit of a plain number.
    #[must_use]
    pub fn quantity(&self) -> (Quantity, Option<&'static Unit>) {
        file_unit(self.key)
    }
}

/// Quantity of a number of the file by the end of its path, and its unit there; `None` for a number without a unit.
#[must_use]
pub fn file_unit(path: &str) -> (Quantity, Option<&'static Unit>) {
    Quantity::of_name(path).map_or((Quantity::Number, None), |(quantity, unit)| (quantity, Some(unit)))
}

/// Reason why a name is no parameter of an instrument.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NameError {
    /// The name is unknown.
    #[error("unknown name `{name}`; expected one of {count} names, nearest {nearest}")]
    Unknown {
        /// Requested name.
        name: String,
        /// Number of known names.
        count: usize,
        /// Similar names.
        nearest: String,
    },
    /// Changing the number does nothing.
    #[error("`{name}` does nothing in this instrument: {why}; type `{acts}`")]
    Idle {
        /// Requested name.
        name: String,
        /// Why nothing depends on it.
        why: &'static str,
        /// What acts: a name, or a line of the file.
        acts: String,
    },
}

/// Reason why [`Parameter::vary`] changes nothing.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum VaryError {
    /// The instrument has no such part: the parameter is another instrument's.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// The factor is not positive, or not finite.
    #[error("found the factor {found}, expected a positive number")]
    Factor {
        /// Factor found.
        found: f64,
    },
    /// The screw cannot be turned by so much.
    #[error("the screw cannot be turned by {found}, expected a finite number by which no spring turns around")]
    Turn {
        /// Turn found, m, rad or N m.
        found: f64,
    },
}

/// A number of an instrument that can be changed by name.
///
/// The index is that of a list of the instrument. Every method compares it with the instrument that it gets: one with
/// too few parts is an [`IndexError`].
#[derive(Debug, Clone, PartialEq)]
pub enum Parameter {
    /// A screw, turned from its setting, m, rad or N m.
    Screw {
        /// Index.
        screw: usize,
        /// Part that it moves, which determines the unit.
        action: ScrewAction,
    },
    /// A body's mass and inertia, times a factor.
    Mass(usize),
    /// The dry friction torque of a body's pivot, times a factor.
    PivotFriction(usize),
    /// A spring's torque as drawn, times a factor.
    Torque(usize),
    /// A spring's stiffness, times a factor.
    SpringStiffness(usize),
    /// A felt's stiffness, times a factor.
    Stiffness(usize),
    /// A felt's damping, times a factor.
    Damping(usize),
    /// A zone's friction coefficient, times a factor.
    Friction(usize),
}

impl Parameter {
    /// Returns every parameter of an instrument with its name: screws by their own, the others as in
    /// `body.hammer.mass`, `body.whippen.friction`, `spring.repetition.torque`, `spring.key_bending.stiffness`,
    /// `zone.string.stiffness`, `zone.check.damping`, `zone.check.friction`.
    #[must_use]
    pub fn all(instrument: &Instrument) -> Vec<(String, Parameter)> {
        let screws = instrument.screws.iter().enumerate();
        let mut all: Vec<Parameter> =
            screws.map(|(screw, one)| Parameter::Screw { screw, action: one.action.clone() }).collect();
        for (i, body) in instrument.bodies.iter().enumerate().filter(|(i, _)| !instrument.is_arm(*i)) {
            all.push(Parameter::Mass(i));
            // A bend's dry torque only lets it come to rest; no result depends on it.
            if body.friction_torque_n_m > 0.0 && !body.is_bend {
                all.push(Parameter::PivotFriction(i));
            }
        }
        for (i, spring) in instrument.springs.iter().enumerate() {
            if spring.torque_n_m != 0.0 {
                all.push(Parameter::Torque(i));
            }
            if spring.stiffness_n_m_per_rad > 0.0 && !instrument.is_arm(spring.body) {
                all.push(Parameter::SpringStiffness(i));
            }
        }
        for (i, zone) in instrument.zones.iter().enumerate() {
            all.push(Parameter::Stiffness(i));
            if zone.felt.loss.is_lossy() {
                all.push(Parameter::Damping(i));
            }
            if zone.friction_coefficient > 0.0 {
                all.push(Parameter::Friction(i));
            }
        }
        all.into_iter().map(|parameter| (parameter.name_in(instrument), parameter)).collect()
    }

    /// Checks that the instrument has the part whose number it is.
    fn check(&self, instrument: &Instrument) -> Result<(), IndexError> {
        let (what, index, count) = match *self {
            Parameter::Screw { screw, .. } => ("screw", screw, instrument.screws.len()),
            Parameter::Mass(i) | Parameter::PivotFriction(i) => ("body", i, instrument.bodies.len()),
            Parameter::Torque(i) | Parameter::SpringStiffness(i) => ("spring", i, instrument.springs.len()),
            Parameter::Stiffness(i) | Parameter::Damping(i) | Parameter::Friction(i) => {
                ("zone", i, instrument.zones.len())
            }
        };
        IndexError::check(what, index, count)
    }

    // Those that end with `_in` are called where the instrument has the part.

    /// Name of the part whose number it is.
    fn part<'i>(&self, instrument: &'i Instrument) -> &'i str {
        match *self {
            Parameter::Screw { screw, .. } => &instrument.screws[screw].name,
            Parameter::Mass(i) | Parameter::PivotFriction(i) => &instrument.bodies[i].name,
            Parameter::Torque(i) | Parameter::SpringStiffness(i) => &instrument.springs[i].name,
            Parameter::Stiffness(i) | Parameter::Damping(i) | Parameter::Friction(i) => &instrument.zones[i].name,
        }
    }

    /// Name of the parameter, as in [`Parameter::all`].
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn name(&self, instrument: &Instrument) -> Result<String, IndexError> {
        self.check(instrument)?;
        Ok(self.name_in(instrument))
    }

    fn name_in(&self, instrument: &Instrument) -> String {
        let (list, what) = match self {
            Parameter::Screw { .. } => return self.part(instrument).to_owned(),
            Parameter::Mass(_) => ("body", "mass"),
            Parameter::PivotFriction(_) => ("body", "friction"),
            Parameter::Torque(_) => ("spring", "torque"),
            Parameter::SpringStiffness(_) => ("spring", "stiffness"),
            Parameter::Stiffness(_) => ("zone", "stiffness"),
            Parameter::Damping(_) => ("zone", "damping"),
            Parameter::Friction(_) => ("zone", "friction"),
        };
        format!("{list}.{}.{what}", self.part(instrument))
    }

    /// Number of files that holds the value; of a felt's damping the first number of its loss, `None` without a loss.
    fn file_number(&self, instrument: &Instrument) -> Option<FileNumber> {
        Some(match *self {
            Parameter::Screw { ref action, .. } => action.file_number(),
            Parameter::Mass(_) => FileNumber::BODY_MASS,
            Parameter::PivotFriction(_) => FileNumber::BODY_FRICTION,
            Parameter::Torque(_) => FileNumber::SPRING_TORQUE,
            Parameter::SpringStiffness(_) => FileNumber::SPRING_STIFFNESS,
            Parameter::Stiffness(_) => FileNumber::FELT_STIFFNESS,
            Parameter::Damping(i) => FileNumber::of_law(instrument.zones[i].felt.first_loss()?.0),
            Parameter::Friction(_) => FileNumber::ZONE_FRICTION,
        })
    }

    /// Finds a parameter by its name; regional words are read as this program's.
    ///
    /// # Errors
    /// [`NameError`].
    pub fn named(instrument: &Instrument, name: &str) -> Result<(String, Parameter), NameError> {
        let all = Self::all(instrument);
        let find = |name: &str| all.iter().find(|(known, _)| known == name).cloned();
        let name = name.trim();
        let own = canonical_name(name);
        if let Some(found) = find(name).or_else(|| find(&own)) {
            return Ok(found);
        }
        Err(idle(instrument, &own).unwrap_or_else(|| NameError::Unknown {
            name: name.to_owned(),
            count: all.len(),
            nearest: nearest(name, all.iter().map(|(known, _)| known)),
        }))
    }

    /// Physical quantity of the parameter's value.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn quantity(&self, instrument: &Instrument) -> Result<Quantity, IndexError> {
        self.check(instrument)?;
        Ok(self.quantity_in(instrument))
    }

    pub(super) fn quantity_in(&self, instrument: &Instrument) -> Quantity {
        self.file_number(instrument).map_or(Quantity::Number, |number| number.quantity().0)
    }

    /// Unit in which technicians read the value; the command takes a number without a unit in it.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn trade_bare(&self, instrument: &Instrument) -> Result<Bare, IndexError> {
        Ok(self.quantity(instrument)?.trade_unit().map_or(Bare::Si, |unit| Bare::In(unit.symbol)))
    }

    /// Argument of [`Parameter::vary`] that makes a change, in SI units: the turn of a screw, or a factor.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn by(&self, instrument: &Instrument, change: Change) -> Result<f64, IndexError> {
        let now = self.value(instrument)?;
        Ok(match (self.is_factor(), change) {
            (false, Change::Add(by)) => by,
            (true, Change::Multiply(factor)) => factor,
            (false, change) => change.of(now) - now,
            (true, change) => change.of(now) / now,
        })
    }

    /// Whether [`Parameter::vary`] takes factors, which must be positive, rather than turns.
    #[must_use]
    pub fn is_factor(&self) -> bool {
        !matches!(self, Parameter::Screw { .. })
    }

    /// Range of arguments for [`Parameter::vary`], in SI units or as a factor. The reader of files has narrower limits.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        match self {
            // The largest turn of a curve by a file's own setting.
            Parameter::Screw { action, .. } if action.quantity() == Quantity::Angle => [-MAX_TURN_RAD, MAX_TURN_RAD],
            // Metres; a spring's torque is also limited by its sign.
            Parameter::Screw { .. } => [-MAX_SCREW, MAX_SCREW],
            _ => [1e-3, 1e3],
        }
    }

    /// Returns the value in an instrument, in SI units: a screw's setting, a mass, a torque, a felt's stiffness or
    /// damping, a coefficient.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn value(&self, instrument: &Instrument) -> Result<f64, IndexError> {
        self.check(instrument)?;
        Ok(self.value_in(instrument))
    }

    pub(super) fn value_in(&self, instrument: &Instrument) -> f64 {
        match *self {
            Parameter::Screw { screw, .. } => instrument.screws[screw].setting,
            Parameter::Mass(i) => instrument.bodies[i].mass_kg,
            Parameter::PivotFriction(i) => instrument.bodies[i].friction_torque_n_m,
            Parameter::Torque(i) => instrument.springs[i].torque_n_m,
            Parameter::SpringStiffness(i) => instrument.springs[i].stiffness_n_m_per_rad,
            Parameter::Stiffness(i) => instrument.zones[i].felt.stiffness,
            Parameter::Damping(i) => instrument.zones[i].felt.first_loss().map_or(0.0, |(_, value)| value),
            Parameter::Friction(i) => instrument.zones[i].friction_coefficient,
        }
    }

    /// Path of the parameter's number in the instrument's file; empty of the damping of a felt without a loss.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn path(&self, instrument: &Instrument) -> Result<String, IndexError> {
        self.check(instrument)?;
        Ok(self.path_in(instrument))
    }

    pub(super) fn path_in(&self, instrument: &Instrument) -> String {
        self.file_number(instrument).map_or_else(String::new, |number| number.path(self.part(instrument)))
    }

    /// Paths of all numbers of the instrument's file that [`Parameter::vary`] changes: with a body's mass its inertia,
    /// with a felt's damping each number of its loss.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn paths(&self, instrument: &Instrument) -> Result<Vec<String>, IndexError> {
        self.check(instrument)?;
        Ok(self.paths_in(instrument))
    }

    fn paths_in(&self, instrument: &Instrument) -> Vec<String> {
        let part = self.part(instrument);
        match *self {
            Parameter::Mass(_) => [FileNumber::BODY_MASS, FileNumber::BODY_INERTIA].map(|own| own.path(part)).into(),
            Parameter::Damping(i) => {
                let losses = instrument.zones[i].felt.loss.table().iter().filter(|number| number.is_loss);
                losses.map(|number| FileNumber::of_law(number).path(part)).collect()
            }
            _ => vec![self.path_in(instrument)],
        }
    }

    /// Returns the numbers of the file after [`Parameter::vary`], by their paths, in the file's units, to ten digits.
    /// `text` is the file of this instrument.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn numbers(&self, instrument: &Instrument, value: f64, text: &str) -> Result<Vec<(String, f64)>, IndexError> {
        let path = self.path(instrument)?;
        let own = |path: &str| numbers_at(text, path).and_then(|numbers| numbers.first().copied());
        let scaled = |path: String| own(&path).map(|number| (path, ten_digits(number * value)));
        Ok(match *self {
            Parameter::Screw { ref action, .. } => {
                let setting = self.value_in(instrument) + value;
                vec![(path, ten_digits(setting / action.file_unit().si))]
            }
            // The torque may include a screw's part, which the file states separately.
            Parameter::Torque(_) => {
                let more = self.value_in(instrument) * (value - 1.0);
                vec![(path.clone(), ten_digits(own(&path).unwrap_or(0.0) + more))]
            }
            Parameter::Damping(i) => {
                let mut varied = instrument.zones[i].felt;
                varied.scale_loss(value);
                let numbers =
                    varied.loss.table().iter().zip(varied.loss.numbers()).filter(|(number, _)| number.is_loss);
                let new = numbers.map(|(number, value)| value * number.units_per_si);
                let all = self.paths_in(instrument).into_iter().zip(new);
                all.filter(|(path, _)| own(path).is_some()).map(|(path, value)| (path, ten_digits(value))).collect()
            }
            _ => self.paths_in(instrument).into_iter().filter_map(scaled).collect(),
        })
    }

    /// Varies an instrument: turns the screw by `value` (m, rad, N m) or multiplies by it.
    ///
    /// # Errors
    /// A spring's torque would change its sign, a factor is not positive, or the instrument has no such part; the
    /// instrument is then unchanged.
    pub fn vary(&self, instrument: &mut Instrument, value: f64) -> Result<(), VaryError> {
        self.check(instrument)?;
        if self.is_factor() && !(value.is_finite() && value > 0.0) {
            return Err(VaryError::Factor { found: value });
        }
        match *self {
            Parameter::Screw { screw, .. } => {
                let setting = instrument.screws[screw].setting + value;
                if !instrument.turn(screw, setting) {
                    return Err(VaryError::Turn { found: value });
                }
            }
            Parameter::Mass(i) => {
                instrument.fields.bodies[i].mass_kg *= value;
                instrument.fields.bodies[i].inertia_kg_m2 *= value;
            }
            Parameter::PivotFriction(i) => instrument.fields.bodies[i].friction_torque_n_m *= value,
            Parameter::Torque(i) => instrument.fields.springs[i].torque_n_m *= value,
            Parameter::SpringStiffness(i) => instrument.fields.springs[i].stiffness_n_m_per_rad *= value,
            Parameter::Stiffness(i) => instrument.fields.zones[i].felt.stiffness *= value,
            Parameter::Damping(i) => instrument.fields.zones[i].felt.scale_loss(value),
            Parameter::Friction(i) => instrument.fields.zones[i].friction_coefficient *= value,
        }
        Ok(())
    }
}

/// Whether a number describes the bridge's modes.
fn is_of_bridge(number: &FileNumber) -> bool {
    number.table.starts_with("bridge_mode.") || number.table.starts_with("board.")
}

/// Why nothing depends on the dry friction of a bend, which only lets it come to rest.
const IS_A_BEND: &str = "it is the hinge at which the part bends";

/// Reason why a number of the file does nothing in this instrument, by its path, of a point with `.x` or `.y` at the
/// end; `None` if it acts. `has` says whether the file holds a number at a path, and which.
pub(super) fn idle_number(instrument: &Instrument, path: &str, has: impl Fn(&str) -> Option<f64>) -> Option<NameError> {
    let number = FileNumber::of_path(path)?;
    let (point, axis) = match path.rsplit_once('.') {
        Some((point, axis @ ("x" | "y"))) => (point, axis),
        _ => (path, ""),
    };
    let part = number.part_of(point)?;
    let idle = |why, acts| Some(NameError::Idle { name: path.to_owned(), why, acts });
    match number {
        FileNumber::BODY_FRICTION | FileNumber::BODY_STATIC_RATIO | FileNumber::BODY_DWELL => {
            let body = instrument.bodies.iter().position(|body| body.name == part && body.is_bend)?;
            idle(IS_A_BEND, number.path(&instrument.bodies[instrument.first_piece_of(body)].name))
        }
        FileNumber::LINE_NORMAL | FileNumber::SCREW_DIRECTION => {
            let other = format!("{point}.{}", if axis == "x" { "y" } else { "x" });
            let is_alone = !axis.is_empty() && has(&other) == Some(0.0);
            if is_alone { idle("only the direction counts, not its length", other) } else { None }
        }
        _ if number.table.starts_with("string.") && !instrument.has_yielding_strings() => {
            idle("the string is held rigid", "rigid_string = false".to_owned())
        }
        _ if is_of_bridge(&number) && instrument.roles.rigid_bridge => {
            idle("the bridge is held rigid", "rigid_bridge = false".to_owned())
        }
        _ if is_of_bridge(&number) && !instrument.has_yielding_strings() => {
            idle("the string is held rigid", "rigid_string = false".to_owned())
        }
        FileNumber::STRING_DIAMETER => {
            let acts = [FileNumber::STRING_MASS, FileNumber::STRING_INHARMONICITY].map(|number| number.path(part));
            let is_replaced = acts.iter().all(|path| has(path).is_some());
            let [mass, _] = acts;
            if is_replaced { idle("the file states what follows from it, mass and inharmonicity", mass) } else { None }
        }
        _ => None,
    }
}

/// The name that acts instead of the dry torque of a bend; `None` if the name is no such torque.
fn idle(instrument: &Instrument, name: &str) -> Option<NameError> {
    let body = name.strip_prefix("body.")?.strip_suffix(".friction")?;
    let body = instrument.bodies.iter().position(|own| own.name == body)?;
    let acts = &instrument.bodies[instrument.first_piece_of(body)];
    let is_idle = instrument.bodies[body].is_bend && !acts.is_bend && acts.friction_torque_n_m > 0.0;
    is_idle.then(|| NameError::Idle {
        name: name.to_owned(),
        why: IS_A_BEND,
        acts: format!("body.{}.friction", acts.name),
    })
}

/// Returns the three known names most similar to one.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let mut near: Vec<(f64, &String)> = known.map(|known| (strsim::jaro_winkler(name, known), known)).collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0));
    near.iter().take(3).map(|(_, name)| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Rounds to ten digits, so that products look as typed.
#[must_use]
pub fn ten_digits(x: f64) -> f64 {
    format!("{x:.9e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::cited;

    /// Changing the numbers in the file equals varying the instrument, for every parameter of every built-in instrument
    /// that is played.
    #[test]
    fn numbers_of_the_file_are_what_is_varied() {
        for name in ["concert-grand", "concert-grand-rigid", "concert-grand-strings"] {
            let text = Instrument::builtin_text(name).unwrap();
            let grand = Instrument::parse(text, name).unwrap();
            for (name, parameter) in Parameter::all(&grand) {
                let mut varied = grand.clone();
                parameter.vary(&mut varied, if parameter.is_factor() { 1.07 } else { 1.7e-5 }).unwrap();
                let by = if parameter.is_factor() { 1.07 } else { 1.7e-5 };
                let numbers = parameter.numbers(&grand, by, text).unwrap();
                let changes: Vec<_> =
                    numbers.into_iter().map(|(path, value)| (path, value, String::from("n"))).collect();
                let new = cited(text, &changes, "s", "a", "t").unwrap_or_else(|error| panic!("{name}: {error}"));
                let read = Instrument::parse(&new, "new").unwrap_or_else(|error| panic!("{name}: {error}"));
                for (other, own) in Parameter::all(&varied) {
                    let (wanted, found) = (own.value(&varied).unwrap(), own.value(&read).unwrap());
                    assert!((wanted - found).abs() < 1e-9 * wanted.abs() + 1e-15, "{name}: {other} {wanted} {found}");
                }
                let inertias = varied.bodies.iter().zip(&read.bodies);
                assert!(
                    inertias.into_iter().all(|(a, b)| (a.inertia_kg_m2 / b.inertia_kg_m2 - 1.0).abs() < 1e-9),
                    "{name}"
                );
            }
        }
    }

    /// Every parameter has a name of its own and changes the instrument; a factor of one and no turn change nothing.
    #[test]
    fn every_parameter_varies_something() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let all = Parameter::all(&grand);
        let mut names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
        assert!(names.contains(&"let_off") && names.contains(&"body.hammer.mass"), "{names:?}");
        for (name, parameter) in &all {
            let (mut varied, mut same) = (grand.clone(), grand.clone());
            assert!(parameter.vary(&mut varied, 1e-4).is_ok() && varied != grand, "{name}");
            let nothing = if parameter.is_factor() { 1.0 } else { 0.0 };
            assert!(parameter.vary(&mut same, nothing).is_ok() && same == grand, "{name}");
            let mut unchanged = grand.clone();
            assert!(parameter.vary(&mut unchanged, f64::NAN).is_err() && unchanged == grand, "{name}");
        }
    }
}
