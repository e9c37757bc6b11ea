//! Fitted parameters, their bounds and their scales.

use erard::IndexError;
use erard::instrument::{Instrument, InstrumentFile};
use erard::parameter::{Change, Entry, NameError, Parameter, Quantity, nearest, register};

use super::FitError;

/// A spread with at least this ratio of upper to lower end is the file's uncertainty of a parameter; a narrower one is
/// the range over grands of this kind, and another piano may lie outside.
const KNOWN_TO_A_FACTOR: f64 = 2.3;
/// Bounds of a factor whose uncertainty is not in the file.
const USUAL_FACTORS: [f64; 2] = [0.2, 5.0];
/// Bounds of a screw's turn, as a share of its range.
const USUAL_TURN: f64 = 0.02;

/// A fitted parameter. Its value is that of `study --vary` in SI units: a screw's turn in m, rad or N m, or a factor.
/// The solver works on a scaled value: the logarithm of a factor, or a turn as a share of half its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct FitParameter {
    /// Name of the parameter ([`Parameter::all`]).
    pub name: String,
    /// The parameter.
    pub parameter: Parameter,
    /// Value in the instrument at the start of the fit, in SI units.
    pub value: f64,
    /// Physical quantity.
    pub quantity: Quantity,
    /// Lower bound, a turn or a factor.
    pub low: f64,
    /// Upper bound, a turn or a factor.
    pub high: f64,
}

impl FitParameter {
    /// SI unit; empty for a coefficient.
    pub fn unit(&self) -> &'static str {
        self.quantity.si_unit()
    }

    /// Displayed unit, and how many of it one SI unit is.
    pub fn shown_unit(&self) -> (f64, &'static str) {
        match &self.parameter {
            Parameter::Screw { action, .. } => action.shown_unit(),
            _ => self.quantity.shown(),
        }
    }

    fn scale(&self) -> f64 {
        (self.high - self.low) / 2.0
    }

    /// Returns the solver's value of a turn or factor.
    pub fn to_solver(&self, x: f64) -> f64 {
        if self.parameter.is_factor() { x.ln() } else { x / self.scale() }
    }

    /// Returns the turn or factor of a solver's value.
    #[allow(clippy::wrong_self_convention, reason = "the inverse of `to_solver` needs the parameter's scale")]
    pub(crate) fn from_solver(&self, p: f64) -> f64 {
        if self.parameter.is_factor() { p.exp() } else { p * self.scale() }
    }

    /// Derivative of the turn or factor by the solver's value.
    pub(crate) fn slope(&self, p: f64) -> f64 {
        if self.parameter.is_factor() { p.exp() } else { self.scale() }
    }

    /// [`FitParameter::slope`] for an instrument that already has the value, i.e. at factor 1.
    pub(super) fn slope_from_itself(&self) -> f64 {
        if self.parameter.is_factor() { 1.0 } else { self.scale() }
    }

    /// Half the distance between the bounds, in solver's values.
    pub(crate) fn width(&self) -> f64 {
        (self.to_solver(self.high) - self.to_solver(self.low)) / 2.0
    }

    /// Bounds of the solver's value.
    pub(crate) fn bounds(&self) -> [f64; 2] {
        [self.to_solver(self.low), self.to_solver(self.high)]
    }

    /// Converts a turn or factor to SI units.
    pub fn si(&self, x: f64) -> f64 {
        if self.parameter.is_factor() { self.value * x } else { self.value + x }
    }

    /// Converts a deviation of a turn or factor to SI units.
    pub fn si_error(&self, x: f64, error: f64) -> f64 {
        if self.parameter.is_factor() { (self.value * x).abs() * error / x } else { error }
    }

    /// Converts a change of the instrument's number to a turn or a factor.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub fn outer_of(&self, instrument: &Instrument, change: Change) -> Result<f64, IndexError> {
        self.parameter.by(instrument, change)
    }

    /// Turn or factor that leaves the instrument unchanged.
    pub(crate) fn unchanged(&self) -> f64 {
        if self.parameter.is_factor() { 1.0 } else { 0.0 }
    }

    /// Whether a turn or factor is at a bound.
    pub fn is_at_a_bound(&self, x: f64) -> bool {
        (x - self.low).abs().min((x - self.high).abs()) < 1e-3 * (self.high - self.low)
    }
}

/// Values by name.
pub type PerName<T> = Vec<(String, T)>;

/// Returns the parameters to fit by name, with bounds: as given, else the uncertainty stated in the file, else default
/// ones.
///
/// # Errors
/// An unknown or repeated name, or invalid bounds.
pub fn fit_parameters(
    file: &InstrumentFile,
    names: &[String],
    bounds: &PerName<[f64; 2]>,
) -> Result<Vec<FitParameter>, FitError> {
    let known = register(file);
    let mut found: Vec<FitParameter> = Vec::new();
    for name in names {
        let own = known
            .iter()
            .find(|quantity| quantity.name == *name)
            .ok_or_else(|| unknown(&file.instrument, name, &known))?;
        if found.iter().any(|other| other.name == *name) {
            return Err(FitError::argument("parameters", format!("`{name}` is given twice; expected once")));
        }
        found.push(parameter(own, bounds)?);
    }
    if found.is_empty() {
        return Err(FitError::argument("parameters", "found none, expected one name or more, each once"));
    }
    match bounds.iter().find(|(name, _)| !names.contains(name)) {
        Some((name, _)) => Err(FitError::argument("bounds", format!("{name} is not varied"))),
        None => Ok(found),
    }
}

fn parameter(own: &Entry, bounds: &PerName<[f64; 2]>) -> Result<FitParameter, FitError> {
    let [least, most] = own.parameter.range();
    let usual = || {
        let screw = [-USUAL_TURN * most, USUAL_TURN * most];
        let usual = if own.parameter.is_factor() { USUAL_FACTORS } else { screw };
        own.spread.filter(|[low, high]| high / low >= KNOWN_TO_A_FACTOR || *low < 0.0).unwrap_or(usual)
    };
    let given = bounds.iter().find(|(name, _)| *name == own.name).map(|(_, bounds)| *bounds);
    let [low, high] = given.unwrap_or_else(usual);
    if !(low.is_finite() && high.is_finite() && least <= low && low < high && high <= most) {
        let unit = if own.parameter.is_factor() { "times" } else { own.quantity.si_unit() };
        let expected = format!("expected two increasing numbers from {least:.4} to {most:.4} {unit}");
        return Err(FitError::argument("bounds", format!("{} from {low} to {high}; {expected}", own.name)));
    }
    // A file may state an uncertainty wider than a run allows.
    Ok(FitParameter {
        name: own.name.clone(),
        parameter: own.parameter.clone(),
        value: own.value,
        quantity: own.quantity,
        low,
        high,
    })
}

fn unknown(instrument: &Instrument, name: &str, known: &[Entry]) -> FitError {
    if let Err(error @ NameError::Idle { .. }) = Parameter::named(instrument, name) {
        return FitError::argument("parameters", error.to_string());
    }
    let is_number = known.iter().any(|one| one.path == name);
    let what = if is_number {
        "is a number of the file; expected a screw or a parameter"
    } else {
        "cannot be fitted: unknown name; expected one of"
    };
    let message = format!(
        "`{name}` {what}{}, nearest {}",
        if is_number { String::new() } else { format!(" {} names", known.len()) },
        nearest(name, known.iter().map(|one| &one.name))
    );
    FitError::argument("parameters", message)
}

/// Returns the instrument with these turns and factors; `None` if it cannot have them.
pub(super) fn varied(instrument: &Instrument, parameters: &[FitParameter], values: &[f64]) -> Option<Instrument> {
    let mut varied = instrument.clone();
    let all = parameters.iter().zip(values).all(|(one, value)| {
        let [least, most] = one.parameter.range();
        (least..=most).contains(value) && one.parameter.vary(&mut varied, *value).is_ok()
    });
    all.then_some(varied)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grand() -> InstrumentFile {
        InstrumentFile::builtin("concert-grand-rigid").unwrap()
    }

    fn names(all: &[&str]) -> Vec<String> {
        all.iter().map(|name| (*name).to_owned()).collect()
    }

    /// A factor is scaled by its logarithm, a screw by its bounds; both values and their slopes agree.
    #[test]
    fn counts_are_one_both_ways() {
        let bounds = vec![("let_off".to_owned(), [-1e-3, 3e-3])];
        let found = fit_parameters(&grand(), &names(&["body.hammer.mass", "let_off"]), &bounds).unwrap();
        assert_eq!((found[1].low, found[1].high, found[1].width()), (-1e-3, 3e-3, 1.0));
        for (one, x) in [(&found[0], 1.07), (&found[1], 4e-4)] {
            let p = one.to_solver(x);
            assert!((one.from_solver(p) - x).abs() < 1e-15);
            let slope = (one.from_solver(p + 1e-6) - one.from_solver(p - 1e-6)) / 2e-6;
            assert!((slope / one.slope(p) - 1.0).abs() < 1e-8);
            assert!(
                one.low < one.unchanged()
                    && one.unchanged() < one.high
                    && !one.is_at_a_bound(x)
                    && one.is_at_a_bound(one.high)
            );
        }
        let mass = found[0].value;
        assert!(
            (found[0].si(1.1) - 1.1 * mass).abs() < 1e-15 && (found[0].si_error(1.1, 0.01) - 0.01 * mass).abs() < 1e-15
        );
    }

    /// Errors state what was found and what is expected.
    #[test]
    fn what_is_wrong_is_named() {
        let message = |asked: &[&str], bounds: &[(&str, [f64; 2])]| {
            let bounds: PerName<[f64; 2]> = bounds.iter().map(|(name, b)| ((*name).to_owned(), *b)).collect();
            fit_parameters(&grand(), &names(asked), &bounds).unwrap_err().to_string()
        };
        for (asked, bounds, expected) in [
            (&[][..], &[][..], "one name or more"),
            (&["leton"], &[], "nearest `let_off`"),
            (&["body.hammer.mass_g"], &[], "number of the file"),
            (&["let_off", "let_off"], &[], "twice"),
            (&["let_off"], &[("let_off", [1e-3, -1e-3])], "increasing"),
            (&["let_off"], &[("let_off", [f64::NAN, 1e-3])], "increasing"),
            (&["let_off"], &[("let_off", [-1.0, 1.0])], "to 0.1"),
            (&["let_off"], &[("drop", [0.0, 1e-3])], "drop is not varied"),
        ] {
            let message = message(asked, bounds);
            assert!(message.contains(expected), "{message}");
        }
    }
}
