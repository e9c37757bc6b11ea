//! `--vary let_off=-1mm..1mm:41`: what is varied, from where to where, in how many steps.

use erard::instrument::Instrument;
use erard::stroke::MAX_FORCE_N;
use erard_workshop::study::Parameter;

use crate::regulate::screw_unit;

/// What a value is given to.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A number of the instrument.
    Parameter(Parameter),
    /// The constant force on the key.
    Force,
}

/// One `--vary`.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// As it was asked for, e.g. `let_off`.
    pub name: String,
    /// Of the shown values, e.g. `mm`; empty for a factor.
    pub unit: &'static str,
    /// As shown: in `unit`.
    pub shown: Vec<f64>,
    /// The shown value of one SI unit.
    pub per_si: f64,
    /// What they are given to.
    pub target: Target,
}

/// The name of the force.
const FORCE: &str = "force";
/// Most degrees that a screw turns a curve.
const MOST_TURNED_DEG: f64 = 90.0;
/// Most values of one axis.
const MOST: usize = 100_000;

impl Axis {
    /// Reads the value of `--vary` for an instrument.
    ///
    /// # Errors
    /// One sentence that says what is wrong and what would be right.
    pub fn parse(text: &str, instrument: &Instrument) -> Result<Self, String> {
        let (name, values) = text
            .split_once('=')
            .ok_or_else(|| format!("`{text}`: expected a name, `=`, and values such as `let_off=-1mm..1mm:41`"))?;
        let name = name.trim();
        let (target, per_si, unit, suffixes): (Target, f64, &str, &[&str]) = if name == FORCE {
            (Target::Force, 1.0, "N", &["N"])
        } else {
            let all = Parameter::all(instrument);
            let Some((_, parameter)) = all.iter().find(|(known, _)| known == name) else {
                let known: Vec<&str> = all.iter().map(|(known, _)| known.as_str()).collect();
                return Err(format!(
                    "`{name}` is nothing that can be varied here; expected {FORCE}, {}",
                    known.join(", ")
                ));
            };
            let (per_si, unit) = match parameter {
                Parameter::Screw { action, .. } => screw_unit(action),
                _ => (1.0, ""),
            };
            let suffixes: &[&str] = match unit {
                "mm" => &["mm"],
                "degrees" => &["degrees", "deg"],
                "N mm" => &["N mm", "Nmm"],
                _ => &[],
            };
            (Target::Parameter(parameter.clone()), per_si, unit, suffixes)
        };
        let number = |text: &str| {
            let text = text.trim();
            let bare = suffixes.iter().find_map(|suffix| text.strip_suffix(suffix)).unwrap_or(text).trim_end();
            let value = bare.parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| {
                let kind = if unit.is_empty() { "a factor".to_owned() } else { format!("a number of {unit}") };
                format!("`{text}` in `--vary {name}`: expected {kind}")
            })
        };
        let (range, count) = match values.rsplit_once(':') {
            Some((range, count)) => (range, Some(count.trim())),
            None => (values, None),
        };
        let shown = match (range.split_once(".."), count) {
            (Some((from, to)), Some(count)) => {
                let count = count.parse().ok().filter(|count| (2..=MOST).contains(count));
                let count =
                    count.ok_or_else(|| format!("`--vary {text}`: expected 2 to {MOST} values after the `:`"))?;
                let (from, to) = (number(from)?, number(to)?);
                let at = |i: usize| {
                    let share = i as f64 / (count - 1) as f64;
                    // As a person would write it: the sum's last digits mean nothing.
                    (((1.0 - share) * from + share * to) * 1e9).round() / 1e9
                };
                (0..count).map(at).collect()
            }
            (None, None) => range.split(',').map(number).collect::<Result<Vec<f64>, _>>()?,
            _ => {
                return Err(format!(
                    "`--vary {text}`: expected FROM..TO:COUNT, such as `{name}=1{u}..2{u}:5`, or values with commas",
                    u = suffixes.first().copied().unwrap_or_default()
                ));
            }
        };
        let axis = Axis { name: name.to_owned(), unit, shown, per_si, target };
        match axis.shown.iter().find(|value| !axis.allows(**value)) {
            Some(value) => Err(format!("`--vary {name}`: {value} {unit} is out of range; expected {}", axis.allowed())),
            None => Ok(axis),
        }
    }

    /// A value in SI units, or the factor.
    pub fn si(&self, index: usize) -> f64 {
        self.shown[index] / self.per_si
    }

    /// The name of its column: with the unit, as all columns.
    pub fn column(&self) -> String {
        let unit = self.unit.replace(' ', "_");
        if unit.is_empty() { format!("{}_factor", self.name) } else { format!("{}_{unit}", self.name) }
    }

    fn allows(&self, shown: f64) -> bool {
        match &self.target {
            Target::Force => shown.abs() <= MAX_FORCE_N,
            Target::Parameter(parameter) if parameter.is_factor() => (1e-3..=1e3).contains(&shown),
            // As far as a file's own setting may turn a curve.
            Target::Parameter(_) if self.unit == "degrees" => shown.abs() <= MOST_TURNED_DEG,
            // Metres; a spring's torque has its own limit beside this one, its sign.
            Target::Parameter(_) => (shown / self.per_si).abs() <= 0.1,
        }
    }

    fn allowed(&self) -> String {
        match &self.target {
            Target::Force => format!("at most {MAX_FORCE_N} N"),
            Target::Parameter(parameter) if parameter.is_factor() => "a factor from 0.001 to 1000".into(),
            Target::Parameter(_) if self.unit == "degrees" => format!("at most {MOST_TURNED_DEG} degrees either way"),
            Target::Parameter(_) => format!("at most {} {}", 0.1 * self.per_si, self.unit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grand() -> Instrument {
        Instrument::builtin("concert-grand").unwrap()
    }

    #[test]
    fn ranges_and_lists_are_read() {
        let axis = Axis::parse("let_off=-1mm..1mm:5", &grand()).unwrap();
        assert_eq!(axis.shown, [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!((axis.column().as_str(), axis.si(0)), ("let_off_mm", -1e-3));
        let axis = Axis::parse("body.hammer.mass=0.8, 1 ,1.25", &grand()).unwrap();
        assert_eq!((axis.shown.as_slice(), axis.column().as_str()), (&[0.8, 1.0, 1.25][..], "body.hammer.mass_factor"));
        let axis = Axis::parse("force=1N..20:3", &grand()).unwrap();
        assert_eq!((axis.shown.as_slice(), axis.column().as_str()), (&[1.0, 10.5, 20.0][..], "force_N"));
        let axis = Axis::parse("back_check_angle=-2deg..2 degrees:2", &grand()).unwrap();
        assert!((axis.si(1) - 2.0_f64.to_radians()).abs() < 1e-15);
    }

    /// Whatever is wrong is named, and what would be right.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("let_off", "such as `let_off=-1mm..1mm:41`"),
            ("letoff=1mm..2mm:3", "expected force, "),
            ("let_off=1mm..2mm", "FROM..TO:COUNT"),
            ("let_off=1mm:3", "FROM..TO:COUNT"),
            ("let_off=1cm..2mm:3", "a number of mm"),
            ("let_off=..2mm:3", "a number of mm"),
            ("let_off=1mm..2mm:1", "2 to 100000 values"),
            ("let_off=1mm..2mm:many", "2 to 100000 values"),
            ("let_off=1mm..200mm:3", "out of range"),
            ("let_off=nan..2mm:3", "a number of mm"),
            ("body.hammer.mass=0..2:3", "a factor from 0.001 to 1000"),
            ("body.hammer.mass=one", "expected a factor"),
            ("force=1e9", "out of range"),
            ("back_check_angle=1e9", "at most 90 degrees either way"),
            ("back_check_angle=-91deg..0deg:3", "at most 90 degrees either way"),
        ] {
            let error = Axis::parse(text, &grand()).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
