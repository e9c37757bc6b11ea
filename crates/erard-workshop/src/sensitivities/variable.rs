//! A number of an instrument as a variable of derivatives.

use erard::gradient::{Direction, GradientError};
use erard::instrument::{Instrument, with_numbers};
use erard::parameter::{NameError, Parameter, Quantity, acting_number, file_unit, known_name};
use thiserror::Error;

/// Half the difference, in units of [`Parameter::vary`], for the map from a number to the mechanism's numbers, which is
/// smooth and mostly linear. Of a factor.
const HALF: f64 = 1e-4;
/// Half the difference for a screw, m, rad or N m.
const HALF_TURN: f64 = 1e-5;
/// Half the window for differences of the rest: of a factor, and of a screw, m, rad or N m.
const REST: f64 = 1e-5;
/// See [`REST`].
const REST_TURN: f64 = 1e-7;

/// A number of an instrument, with its unit and its usual change.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name in `study --vary`.
    pub name: String,
    /// Unit of the derivatives: `mm`, `degrees` or `N mm` of a screw, `%` of a parameter, the file's own unit of a
    /// number of the file, `N` of the force.
    pub per: &'static str,
    /// Value in that unit, if there is one; a parameter is 100 %.
    pub value: Option<f64>,
    /// Usual change in that unit, by which effects are compared.
    pub usual: f64,
    /// Half the window of the differences, and the coarser one for weighing.
    pub window: f64,
    /// See `window`.
    pub weighing: f64,
    /// Direction to first order.
    pub(super) direction: Direction,
    target: Target,
}

#[derive(Debug, Clone, PartialEq)]
enum Target {
    Parameter(Parameter, f64),
    Number {
        text: String,
        path: String,
        which: usize,
        value: f64,
    },
    Force,
    /// Two instruments, and the distance of each from the own one.
    Between(Box<[Instrument; 2]>, f64),
}

/// Reason why a number cannot be a variable.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum VariableError {
    /// The name is unknown.
    #[error(
        "unknown name `{name}`; expected {known}, force (with a constant force), or the path of a number in the file, e.g. `body.hammer.mass_g` or `zone.string.disc.center_mm.x`"
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// Known names.
        known: String,
    },
    /// The name does nothing in this instrument.
    #[error(transparent)]
    Idle(NameError),
    /// The number is at an end of its range.
    #[error("`{name}` has no derivative here, because it cannot change a little in both directions: {why}")]
    Stuck {
        /// Name of the number.
        name: String,
        /// Reason.
        why: String,
    },
}

impl Variable {
    /// Returns all named parameters of an instrument ([`Parameter::all`]) that can be changed to both sides.
    pub fn all(instrument: &Instrument) -> Vec<Variable> {
        let plain = instrument.clone().without_outlines();
        let all = Parameter::all(&plain).into_iter();
        all.filter_map(|(name, parameter)| Self::parameter(&plain, name, parameter).ok()).collect()
    }

    /// Finds a variable by its name: a parameter, `force`, or the path of a number in the instrument's text.
    ///
    /// # Errors
    /// See [`VariableError`].
    pub fn named(instrument: &Instrument, text: &str, name: &str) -> Result<Variable, VariableError> {
        let plain = instrument.clone().without_outlines();
        let all = Parameter::all(&plain);
        let name = known_name(name, &all, text);
        let name = name.as_str();
        if let Some((name, parameter)) = all.iter().find(|(known, _)| known == name) {
            return Self::parameter(&plain, name.clone(), parameter.clone());
        }
        if name == "force" {
            let direction = Direction::force();
            return Ok(Variable {
                name: name.to_owned(),
                per: "N",
                value: None,
                usual: 0.1,
                window: 0.02,
                weighing: 0.02,
                direction,
                target: Target::Force,
            });
        }
        let number = acting_number(&plain, text, name).map_err(VariableError::Idle)?;
        number.map(|number| Self::number(text, name, number)).unwrap_or_else(|| {
            if let Err(error @ NameError::Idle { .. }) = Parameter::named(&plain, name) {
                return Err(VariableError::Idle(error));
            }
            let known: Vec<&str> = all.iter().map(|(known, _)| known.as_str()).collect();
            Err(VariableError::Unknown { name: name.to_owned(), known: known.join(", ") })
        })
    }

    /// Makes the direction between two instruments whose numbers are `apart` units from each other.
    ///
    /// # Errors
    /// [`VariableError::Stuck`], if they have different parts.
    pub fn between(name: &str, low: &Instrument, high: &Instrument, apart: f64) -> Result<Variable, VariableError> {
        let direction = Direction::between(low, high, apart)
            .map_err(|error| VariableError::Stuck { name: name.to_owned(), why: error.to_string() })?;
        Ok(Variable {
            name: name.to_owned(),
            per: unit_of(name),
            value: None,
            usual: apart,
            window: apart,
            weighing: apart,
            direction,
            target: Target::Between(
                Box::new([low, high].map(|instrument| instrument.clone().without_outlines())),
                0.5 * apart,
            ),
        })
    }

    fn parameter(plain: &Instrument, name: String, parameter: Parameter) -> Result<Self, VariableError> {
        let (per_si, per, usual, window) = match &parameter {
            Parameter::Screw { action, .. } => {
                let (per_si, unit) = action.shown_unit();
                let torque = action.quantity() == Quantity::Torque;
                (per_si, unit, 0.1, if torque { 0.02 } else { 0.01 })
            }
            _ => (100.0, "%", 1.0, 0.5),
        };
        let half = if parameter.is_factor() { HALF } else { HALF_TURN };
        let at = |by: f64| {
            let mut varied = plain.clone();
            let value = if parameter.is_factor() { 1.0 + by } else { by };
            parameter.vary(&mut varied, value).is_ok().then_some(varied)
        };
        let stuck = |why: String| VariableError::Stuck { name: name.clone(), why };
        let (Some(low), Some(high)) = (at(-half), at(half)) else {
            return Err(stuck("it is at an end of its range".to_owned()));
        };
        let direction = Direction::between(&low, &high, 2.0 * half * per_si)
            .map_err(|error: GradientError| stuck(error.to_string()))?;
        let value = parameter.is_factor().then_some(100.0);
        let weighing = if parameter.is_factor() { 2.0 * window } else { 5.0 * window };
        Ok(Variable {
            name,
            per,
            value,
            usual,
            window,
            weighing,
            direction,
            target: Target::Parameter(parameter, per_si),
        })
    }

    fn number(text: &str, name: &str, (path, which, value): (String, usize, f64)) -> Result<Self, VariableError> {
        let per = unit_of(name);
        let length = per == "mm" || per == "deg";
        let half = if length { 1e-3 } else { 1e-4 * value.abs().max(1e-12) };
        let (usual, window) = if length { (0.1, 0.01) } else { (0.01 * value.abs(), 0.005 * value.abs()) };
        let target = Target::Number { text: text.to_owned(), path, which, value };
        let stuck = |why: String| VariableError::Stuck { name: name.to_owned(), why };
        let at = |by: f64| read(&target, by).map_err(&stuck);
        let direction =
            Direction::between(&at(-half)?, &at(half)?, 2.0 * half).map_err(|error| stuck(error.to_string()))?;
        Ok(Variable {
            name: name.to_owned(),
            per,
            value: Some(value),
            usual,
            window,
            weighing: 4.0 * window,
            direction,
            target: target.clone(),
        })
    }

    /// A bare number in units of [`Variable::per`]: for a parameter the value of `study --vary` (a turn in m, rad or N
    /// m; a factor), for a number of the file the number itself, for the force 1 N.
    pub fn per_bare_number(&self) -> f64 {
        match &self.target {
            Target::Parameter(_, per_si) => *per_si,
            Target::Number { .. } | Target::Force | Target::Between(..) => 1.0,
        }
    }

    /// Value for elasticities, in its unit; `None` if a relative change is meaningless.
    pub(crate) fn relative(&self) -> Option<f64> {
        self.value.filter(|value| *value != 0.0 && self.per != "mm" && self.per != "deg")
    }

    /// Half the window for differences of the rest, in the variable's unit: so narrow that the search for the rest goes
    /// through the same switches at both ends, and wide against rounding.
    pub(super) fn rest_half(&self) -> f64 {
        match &self.target {
            Target::Parameter(parameter, per_si) => per_si * if parameter.is_factor() { REST } else { REST_TURN },
            Target::Number { .. } if self.per == "mm" || self.per == "deg" => 1e3 * REST_TURN,
            Target::Number { value, .. } => REST * value.abs().max(1e-12),
            Target::Force => 0.0,
            Target::Between(_, half) => *half,
        }
    }

    /// Whether the variable is the force, not a number of the instrument.
    pub(crate) fn is_force(&self) -> bool {
        self.target == Target::Force
    }

    /// The instrument with the number changed by `by` units; `None` if that is impossible.
    pub(super) fn at(&self, instrument: &Instrument, by: f64) -> Option<Instrument> {
        match &self.target {
            Target::Parameter(parameter, per_si) => {
                let mut varied = instrument.clone();
                let si = by / per_si;
                let by = if parameter.is_factor() { 1.0 + si } else { si };
                parameter.vary(&mut varied, by).is_ok().then_some(varied)
            }
            Target::Force => Some(instrument.clone()),
            Target::Between(sides, half) => {
                let [low, high] = &**sides;
                ((by.abs() - half).abs() < 1e-9 * half).then(|| if by < 0.0 { low.clone() } else { high.clone() })
            }
            number => read(number, by).ok(),
        }
    }
}

/// The instrument of a text with one number changed.
fn read(target: &Target, by: f64) -> Result<Instrument, String> {
    let Target::Number { text, path, which, value } = target else {
        return Err("it names no number of the file".to_owned());
    };
    let new = with_numbers(text, &[(path, *which, value + by)]).ok_or("it is not there")?;
    let read = Instrument::parse(&new, "the varied instrument").map_err(|error| error.to_string())?;
    Ok(read.without_outlines())
}

/// Unit at the end of a path in the file; `1` without one.
fn unit_of(name: &str) -> &'static str {
    file_unit(name).1.map_or("1", |unit| unit.symbol)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number of the file has the unit at the end of its path, and a name that does nothing is refused.
    #[test]
    fn numbers_of_the_file_have_their_units() {
        let text = Instrument::builtin_text("concert-grand").unwrap();
        let grand = Instrument::builtin("concert-grand").unwrap();
        for (name, per) in [
            ("zone.string.felt.stiffness_N_per_m_r", "N/m^r"),
            ("body.hammer.mass_g", "g"),
            ("spring.key_bending.stiffness_N_m_per_rad", "N m/rad"),
            ("zone.capstan_heel.disc.center_mm.x", "mm"),
            ("zone.check.friction_coefficient", "1"),
        ] {
            assert_eq!(Variable::named(&grand, text, name).unwrap().per, per, "{name}");
        }
        for end in ["friction", "friction_torque_N_m"] {
            let error = Variable::named(&grand, text, &format!("body.key.{end}")).unwrap_err().to_string();
            assert!(error.contains(&format!("type `body.key_back.{end}`")), "{error}");
        }
    }
}
