//! Axes of a study (`let_off=-1mm..1mm:41`): what is varied, from where to where, in how many steps.

use erard::IndexError;
use erard::instrument::{Instrument, InstrumentFile, with_numbers};
use erard::keyboard::{Between, KEYS, Keyboard, key_named, keys_named};
use erard::parameter::{
    Bare, Change, ChangeError, NameError, Parameter, ParameterChange, Quantity, Sweep, acting_number, file_unit,
    in_file_unit, known_name, number_of, varied_of,
};
use erard::stroke::MAX_FORCE_N;

/// What a value is given to.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A number of the instrument.
    Parameter(Parameter),
    /// The constant force on the key.
    Force,
    /// Which key of a keyboard.
    Key,
    /// A number of the instrument's file: its path, and which of the numbers there.
    Number(String, usize),
    /// A grading of the keyboard's file: its place there, and which of its points; `None`: the whole, times a factor.
    Grading(usize, Option<usize>),
}

/// What is varied, as it was read.
#[derive(Debug)]
pub enum Source {
    /// The text of an instrument's file, and earlier changes of its parameters.
    Text {
        /// The text.
        text: String,
        /// Changes of parameters by their names; numbers of the file stand changed in the text.
        changes: Vec<(String, ParameterChange)>,
    },
    /// A keyboard, and the key that is played where keys are not varied (`None`: its own instrument's).
    Keyboard(Box<Keyboard>, Option<usize>),
}

impl Source {
    /// An instrument's text, as it is.
    pub fn of_text(text: impl Into<String>) -> Self {
        Source::Text { text: text.into(), changes: Vec::new() }
    }

    /// The text of the instrument: of a keyboard, that of a key, or of its own.
    fn text(&self, key: Option<usize>) -> String {
        match self {
            Source::Text { text, .. } => text.clone(),
            Source::Keyboard(keyboard, own) => keyboard.key_text(key.or(*own).unwrap_or(keyboard.base_key)),
        }
    }

    /// The text with the keyboard's gradings varied.
    fn graded(&self, key: Option<usize>, gradings: &[(usize, Option<usize>, f64)]) -> String {
        match self {
            Source::Keyboard(keyboard, own) if !gradings.is_empty() => {
                let mut keyboard = keyboard.clone();
                for &(index, point, value) in gradings {
                    let curve = &mut keyboard.gradings[index].curve;
                    let between = curve.between;
                    for (at, one) in curve.points.iter_mut().enumerate() {
                        match (point, between) {
                            (Some(point), _) if point == at => one.value = value,
                            (Some(_), _) => {}
                            // Times a factor is what it differs by: a mass or a way from 0, a ratio by its logarithm
                            // from 1.
                            (None, Between::Linear) => one.value *= value,
                            (None, Between::Logarithmic) => one.value = one.value.powf(value),
                        }
                    }
                }
                keyboard.key_text(key.or(*own).unwrap_or(keyboard.base_key))
            }
            _ => self.text(key),
        }
    }

    /// The instrument with one value of every axis that changes its text; `None` where no axis does.
    ///
    /// # Errors
    /// What the reader reports about such an instrument.
    pub(crate) fn instrument(&self, axes: &[Axis], indices: &[usize]) -> Option<Result<Instrument, String>> {
        let each = || axes.iter().zip(indices);
        let key = each().find(|(axis, _)| axis.target == Target::Key).map(|(axis, &i)| axis.shown[i] as usize);
        let numbers: Vec<(&str, usize, &Axis, usize)> = each()
            .filter_map(|(axis, &i)| match &axis.target {
                Target::Number(path, which) => Some((path.as_str(), *which, axis, i)),
                _ => None,
            })
            .collect();
        let gradings: Vec<(usize, Option<usize>, f64)> = each()
            .filter_map(|(axis, &i)| match axis.target {
                Target::Grading(index, point) => Some((index, point, axis.shown[i])),
                _ => None,
            })
            .collect();
        if key.is_none() && numbers.is_empty() && gradings.is_empty() {
            return None;
        }
        let name = match key {
            Some(key) => format!("key {key}"),
            None => "the varied instrument".to_owned(),
        };
        let text = self.graded(key, &gradings);
        let changed = |(path, which, axis, i): (_, _, &Axis, usize)| {
            let (.., now) = number_of(&text, &axis.name)?;
            let value = match axis.changes[i] {
                // In the file's unit already, to the last bit.
                Change::Set(_) => axis.shown[i],
                change => in_file_unit(change, now, file_unit(&axis.name).1),
            };
            Some((path, which, value))
        };
        let changes: Option<Vec<(&str, usize, f64)>> = numbers.into_iter().map(changed).collect();
        let text = changes
            .and_then(|changes| with_numbers(&text, &changes))
            .ok_or_else(|| "a number that is varied is not there".to_owned());
        Some(text.and_then(|text| self.read(&text, &name)))
    }

    /// Reads a text of this source, and makes the earlier changes.
    fn read(&self, text: &str, name: &str) -> Result<Instrument, String> {
        match self {
            Source::Text { changes, .. } if !changes.is_empty() => {
                let file = InstrumentFile::parse(text, name).map_err(|error| error.to_string())?;
                let changed = varied_of(&file, text, name, changes).map_err(|error| error.to_string())?;
                Ok(changed.instrument)
            }
            _ => Instrument::parse(text, name).map_err(|error| error.to_string()),
        }
    }
}

/// What the shown values of an axis are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// Values: of a screw its setting, of a key its number.
    Value,
    /// Differences from the present value.
    Difference,
    /// Factors.
    Factor,
}

/// A name and its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// As it was asked for, e.g. `let_off`.
    pub name: String,
    /// Of the shown values, e.g. `mm`; empty for a factor.
    pub unit: &'static str,
    /// End of the column's name, e.g. `mm`, `N_per_m_r`.
    suffix: String,
    kind: Kind,
    /// As shown: in `unit`.
    pub shown: Vec<f64>,
    /// The changes that make them, in SI units.
    pub changes: Vec<Change>,
    /// The target that receives them.
    pub target: Target,
}

/// The names of the force and of the key.
const FORCE: &str = "force";
const KEY: &str = "key";
/// What the name of a grading of a keyboard begins with.
pub const GRADING: &str = "grading.";

/// As a person would write it: the last digits of a sum mean nothing.
fn as_written(shown: f64) -> f64 {
    (shown * 1e9).round() / 1e9
}

/// Most strokes of a study: their rows are held in memory.
pub const MAX_STROKES: usize = 2_000_000;

impl Axis {
    /// Reads all values of `--vary` for an instrument.
    ///
    /// # Errors
    /// One sentence that says what is wrong and what would be right.
    pub fn parse_all(texts: &[String], instrument: &Instrument, source: &Source) -> Result<Vec<Self>, String> {
        let axes: Vec<Axis> =
            texts.iter().map(|text| Axis::parse(text, instrument, source)).collect::<Result<_, _>>()?;
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|other| other.name == axis.name) {
                return Err(format!("--vary: `{}` is given twice", axis.name));
            }
        }
        if Axis::combinations(&axes).is_none_or(|strokes| strokes > MAX_STROKES) {
            return Err(format!("--vary: more than {MAX_STROKES} strokes; expected fewer values"));
        }
        Ok(axes)
    }

    /// Returns the number of combinations of the axes' values; `None` if a `usize` cannot hold it.
    #[must_use]
    pub fn combinations(axes: &[Self]) -> Option<usize> {
        axes.iter().try_fold(1_usize, |product, axis| product.checked_mul(axis.shown.len()))
    }

    /// Makes an axis of values in SI units, or of a number of the file in the file's own unit. A value out of range
    /// makes a variant that fails.
    ///
    /// # Errors
    /// A name that is neither a parameter's nor the path of a number in the file.
    pub fn of_values(
        name: &str,
        values: Vec<f64>,
        instrument: &Instrument,
        source: &Source,
    ) -> Result<Self, ChangeError> {
        let all = Parameter::all(instrument);
        let text = source.text(None);
        let name = known_name(name, &all, &text);
        let number = acting_number(instrument, &text, &name)?;
        let target = match (all.into_iter().find(|(known, _)| *known == name), number) {
            (Some((_, parameter)), _) => Target::Parameter(parameter),
            (None, Some((path, which, _))) => Target::Number(path, which),
            (None, None) => Target::Parameter(Parameter::named(instrument, &name)?.1),
        };
        let (unit, suffix, si) = match &target {
            Target::Parameter(parameter) => {
                let unit = parameter.quantity(instrument)?.si_unit();
                (unit, unit.replace(' ', "_"), 1.0)
            }
            _ => {
                let unit = file_unit(&name).1;
                unit.map_or(("", String::new(), 1.0), |unit| (unit.symbol, unit.suffix.to_owned(), unit.si))
            }
        };
        let changes = values.iter().map(|value| Change::Set(value * si)).collect();
        Ok(Axis { name, unit, suffix, kind: Kind::Value, shown: values, changes, target })
    }

    /// Makes the axis of constant forces, N.
    #[must_use]
    pub fn of_forces(forces_n: Vec<f64>) -> Self {
        let changes = forces_n.iter().map(|force_n| Change::Set(*force_n)).collect();
        Axis {
            name: FORCE.to_owned(),
            unit: "N",
            suffix: "N".to_owned(),
            kind: Kind::Value,
            shown: forces_n,
            changes,
            target: Target::Force,
        }
    }

    /// Reads a value of `--vary` for an instrument.
    ///
    /// # Errors
    /// One sentence that says what is wrong and what would be right.
    pub fn parse(text: &str, instrument: &Instrument, source: &Source) -> Result<Self, String> {
        let (name, values) = text
            .split_once('=')
            .ok_or_else(|| format!("`{text}`: expected a name, `=`, and values such as `let_off=-1mm..1mm:41`"))?;
        let all = Parameter::all(instrument);
        let text = source.text(None);
        let name = known_name(name, &all, &text);
        let name = name.as_str();
        if name == KEY {
            return Self::keys(values);
        }
        let wrong = |error: &dyn std::fmt::Display| format!("`--vary {name}`: {error}");
        let number = || acting_number(instrument, &text, name).map_err(|error| format!("--vary: {error}"));
        let axis = if name == FORCE {
            Self::values(name, values, Target::Force, Quantity::Force, "N").map_err(|error| wrong(&error))?
        } else if let Some(grading) = name.strip_prefix(GRADING) {
            let (target, quantity, unit) = grading_of(grading, source)?;
            if matches!(target, Target::Grading(_, None)) {
                Self::factors(name, values, target).map_err(|error| wrong(&error))?
            } else {
                Self::values(name, values, target, quantity, unit).map_err(|error| wrong(&error))?
            }
        } else if let Some((path, which, now)) = number()? {
            Self::of_number(name, values, (path, which), now).map_err(|error| wrong(&error))?
        } else {
            let (name, parameter) = Parameter::named(instrument, name).map_err(|error| match error {
                NameError::Unknown { nearest, .. } => format!(
                    "--vary: unknown name `{name}`, nearest {nearest}; expected a screw or parameter, {FORCE}, {KEY} or {GRADING}NAME (of a keyboard), or the path of a number in the file, e.g. `body.hammer.mass_g`"
                ),
                error => format!("--vary: {error}"),
            })?;
            Self::of_parameter(&name, values, &parameter, instrument).map_err(|error| wrong(&error))?
        };
        match (0..axis.shown.len()).find(|at| !axis.allows(instrument, *at)) {
            Some(at) => {
                let found = format!("{} {}", axis.shown[at], axis.unit);
                let expected = axis.allowed(instrument).map_err(|error| error.to_string())?;
                Err(format!("`--vary {name}`: {} is out of range; expected {expected}", found.trim()))
            }
            None => Ok(axis),
        }
    }

    /// Values of what has no present value: a sign belongs to them.
    fn values(
        name: &str,
        values: &str,
        target: Target,
        quantity: Quantity,
        unit: &'static str,
    ) -> Result<Self, String> {
        let bare = if unit.is_empty() { Bare::Si } else { Bare::In(unit) };
        let values = values.trim();
        let values = if values.starts_with('=') { values.to_owned() } else { format!("={values}") };
        let sweep = Sweep::read(&values, quantity, bare).map_err(|error| error.to_string())?;
        let si = quantity.unit(unit).map_or(1.0, |unit| unit.si);
        let shown = sweep.changes.iter().map(|change| as_written(change.of(0.0) / si)).collect();
        let suffix = unit.replace(' ', "_");
        Ok(Axis {
            name: name.to_owned(),
            unit,
            suffix,
            kind: if unit.is_empty() { Kind::Factor } else { Kind::Value },
            shown,
            changes: sweep.changes,
            target,
        })
    }

    /// Factors only.
    fn factors(name: &str, values: &str, target: Target) -> Result<Self, String> {
        let sweep = Sweep::read(values, Quantity::Number, Bare::Si).map_err(|error| error.to_string())?;
        let shown = sweep.changes.iter().map(|change| match change {
            Change::Multiply(factor) => Ok(*factor),
            _ => Err(format!("found `{}`, expected factors, as in `x0,x0.5,x1` or `x0..1:5`", values.trim())),
        });
        let shown = shown.collect::<Result<_, _>>()?;
        let (unit, suffix, kind) = ("", String::new(), Kind::Factor);
        Ok(Axis { name: name.to_owned(), unit, suffix, kind, shown, changes: sweep.changes, target })
    }

    /// A number of the file, in the file's unit.
    fn of_number(name: &str, values: &str, (path, which): (String, usize), now: f64) -> Result<Self, String> {
        let (quantity, unit) = file_unit(name);
        let bare = unit.map_or(Bare::Si, |unit| Bare::In(unit.symbol));
        let sweep = Sweep::read(values, quantity, bare).map_err(|error| error.to_string())?;
        let shown = |change: &Change| match *change {
            Change::Set(_) => in_file_unit(*change, now, unit),
            Change::Add(by) => in_file_unit(Change::Set(by), now, unit),
            Change::Multiply(factor) => factor,
        };
        let shown = sweep.changes.iter().map(shown).collect();
        let suffix = unit.map_or("", |unit| unit.suffix).to_owned();
        let (kind, target) = (kind_of(&sweep), Target::Number(path, which));
        Ok(Axis { name: name.to_owned(), unit: "", suffix, kind, shown, changes: sweep.changes, target })
    }

    /// A screw, or another parameter.
    fn of_parameter(name: &str, values: &str, parameter: &Parameter, instrument: &Instrument) -> Result<Self, String> {
        let foreign = |error: IndexError| error.to_string();
        let quantity = parameter.quantity(instrument).map_err(foreign)?;
        let bare = parameter.trade_bare(instrument).map_err(foreign)?;
        let sweep = Sweep::read(values, quantity, bare).map_err(|error| error.to_string())?;
        let target = Target::Parameter(parameter.clone());
        if let Parameter::Screw { action, .. } = parameter {
            let (per_si, unit) = action.shown_unit();
            let setting = parameter.value(instrument).map_err(foreign)?;
            // Shown as typed, and turned by what is shown.
            let each = sweep.changes.iter().map(|change| match *change {
                Change::Set(value) => {
                    let shown = as_written(value * per_si);
                    (shown, Change::Set(shown / per_si))
                }
                Change::Add(by) => {
                    let by = as_written(by * per_si);
                    (as_written(setting * per_si + by), Change::Add(by / per_si))
                }
                Change::Multiply(_) => (as_written(change.of(setting) * per_si), *change),
            });
            let (shown, changes) = each.unzip();
            let suffix = unit.replace(' ', "_");
            return Ok(Axis { name: name.to_owned(), unit, suffix, kind: Kind::Value, shown, changes, target });
        }
        let trade = quantity.trade_unit();
        let si = trade.map_or(1.0, |unit| unit.si);
        let shown = sweep.changes.iter().map(|change| match *change {
            Change::Multiply(factor) => factor,
            Change::Set(by) | Change::Add(by) => as_written(by / si),
        });
        let (shown, kind) = (shown.collect(), kind_of(&sweep));
        let unit = if kind == Kind::Factor { "" } else { trade.map_or("", |unit| unit.symbol) };
        let suffix = trade.map_or("", |unit| unit.suffix).to_owned();
        Ok(Axis { name: name.to_owned(), unit, suffix, kind, shown, changes: sweep.changes, target })
    }

    /// Keys of a keyboard: `1..88`, `A0..C8:12`, `1,C4,88`.
    fn keys(values: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "`--vary {KEY}={values}`: expected keys from 1 to {KEYS} or notes from A0 to C8, as in `{KEY}=1..88`, `{KEY}=A0..C8:12` or `{KEY}=1,40,88`"
            )
        };
        let (range, count) = match values.rsplit_once(':') {
            Some((range, count)) => (range, Some(count.trim().parse::<usize>().ok().ok_or_else(wrong)?)),
            None => (values, None),
        };
        let keys: Vec<usize> = match (range.split_once(".."), count) {
            (Some((from, to)), count) => {
                let (from, to) = key_named(from).zip(key_named(to)).ok_or_else(wrong)?;
                let all = to.checked_sub(from).ok_or_else(wrong)? + 1;
                let count = count.unwrap_or(all);
                if !(2..=all).contains(&count) {
                    return Err(wrong());
                }
                (0..count).map(|i| from + i * (to - from) / (count - 1)).collect()
            }
            (None, None) => keys_named(range).map_err(|_| wrong())?,
            _ => return Err(wrong()),
        };
        let shown: Vec<f64> = keys.into_iter().map(|key| key as f64).collect();
        let changes = shown.iter().map(|key| Change::Set(*key)).collect();
        let (unit, suffix, kind) = ("", String::new(), Kind::Value);
        Ok(Axis { name: KEY.to_owned(), unit, suffix, kind, shown, changes, target: Target::Key })
    }

    /// A value of the force, N.
    pub(crate) fn force_n(&self, index: usize) -> f64 {
        self.shown[index]
    }

    /// The argument of [`Parameter::vary`] for an instrument.
    ///
    /// # Errors
    /// The instrument has no such part.
    pub(crate) fn by(&self, parameter: &Parameter, instrument: &Instrument, index: usize) -> Result<f64, IndexError> {
        parameter.by(instrument, self.changes[index])
    }

    /// Reason why there is no such variant.
    pub(crate) fn refusal(&self, parameter: &Parameter, index: usize, by: f64) -> String {
        if let Change::Set(_) = self.changes[index] {
            return format!("{} cannot be varied to {} {}", self.name, self.shown[index], self.unit)
                .trim_end()
                .to_owned();
        }
        let (by, unit) = match parameter {
            Parameter::Screw { action, .. } => (as_written(by * action.shown_unit().0), self.unit),
            _ => (self.shown[index], self.unit),
        };
        format!("{} cannot be varied by {by} {unit}", self.name).trim_end().to_owned()
    }

    /// The name of its column: with the unit, as all columns.
    pub fn column(&self) -> String {
        let suffix = if self.suffix.is_empty() { String::new() } else { format!("_{}", self.suffix) };
        // A number of the file has its unit in its path already.
        let name = match self.target {
            Target::Key => return self.name.clone(),
            Target::Number(..) if self.kind == Kind::Value => return self.name.clone(),
            Target::Number(..) => self.name.strip_suffix(&suffix).unwrap_or(&self.name),
            _ => &self.name,
        };
        match self.kind {
            Kind::Value => format!("{name}{suffix}"),
            Kind::Difference => format!("{name}_change{suffix}"),
            Kind::Factor => format!("{name}_factor"),
        }
    }

    fn allows(&self, instrument: &Instrument, index: usize) -> bool {
        match &self.target {
            Target::Force => (0.0..=MAX_FORCE_N).contains(&self.shown[index]),
            // The reader of the file knows what can be.
            Target::Key | Target::Number(..) | Target::Grading(..) => true,
            Target::Parameter(parameter) => {
                let [least, most] = parameter.range();
                self.by(parameter, instrument, index).is_ok_and(|by| (least..=most).contains(&by))
            }
        }
    }

    fn allowed(&self, instrument: &Instrument) -> Result<String, IndexError> {
        let parameter = match &self.target {
            Target::Force => {
                return Ok(format!("from 0 to {MAX_FORCE_N} N: a finger pushes the key down, and cannot pull it up"));
            }
            Target::Key | Target::Number(..) | Target::Grading(..) => return Ok("a number".into()),
            Target::Parameter(parameter) => parameter,
        };
        let [least, most] = parameter.range();
        Ok(match parameter {
            Parameter::Screw { action, .. } => {
                let (per_si, unit) = action.shown_unit();
                format!("at most {} {unit} either way", as_written(most * per_si))
            }
            _ => {
                let quantity = parameter.quantity(instrument)?;
                let (si, unit) = quantity.trade_unit().map_or((1.0, ""), |unit| (unit.si, unit.symbol));
                let now = parameter.value(instrument)? / si;
                let expected = format!(
                    "a factor from {least} to {most}, which is {:.3e} to {:.3e} {unit}",
                    least * now,
                    most * now
                );
                expected.trim_end().to_owned()
            }
        })
    }
}

/// Whether a sweep's changes are values, differences or factors.
fn kind_of(sweep: &Sweep) -> Kind {
    match sweep.changes.first() {
        Some(Change::Multiply(_)) => Kind::Factor,
        Some(Change::Add(_)) => Kind::Difference,
        _ => Kind::Value,
    }
}

/// A grading of a keyboard by its name: the whole; with `.` and the number of a key behind it, its point there.
fn grading_of(name: &str, source: &Source) -> Result<(Target, Quantity, &'static str), String> {
    let Source::Keyboard(keyboard, _) = source else {
        return Err(format!(
            "`{GRADING}{name}`: only a keyboard has gradings; vary {KEY} too, or use --instrument concert-grand:key=88"
        ));
    };
    let place = |name: &str| keyboard.gradings.iter().position(|grading| grading.name == name);
    if let Some(index) = place(name) {
        return Ok((Target::Grading(index, None), Quantity::Number, ""));
    }
    let point = name.rsplit_once('.').and_then(|(grading, key)| Some((place(grading)?, key)));
    let Some((index, key)) = point else {
        let known: Vec<&str> = keyboard.gradings.iter().map(|grading| grading.name.as_str()).collect();
        return Err(format!(
            "`{GRADING}{name}`: the keyboard has no grading of that name; expected one of `{}`, with `.KEY` at the end for one point",
            known.join("`, `")
        ));
    };
    let grading = &keyboard.gradings[index];
    let keys = || grading.curve.points.iter().map(|point| point.key);
    let at = key_named(key).and_then(|key| keys().position(|own| own == key && own != keyboard.base_key));
    let Some(at) = at else {
        let known: Vec<String> = keys().filter(|key| *key != keyboard.base_key).map(|key| key.to_string()).collect();
        return Err(format!(
            "`{GRADING}{name}`: `{}` has no point at key `{key}`; expected one of {} (key {} is the instrument itself and cannot vary)",
            grading.name,
            known.join(", "),
            keyboard.base_key
        ));
    };
    // A curve is in the units of its file, which are those of technicians.
    let quantity = grading.graded.quantity();
    Ok((Target::Grading(index, Some(at)), quantity, quantity.shown().1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::keyboard::Graded;

    fn read() -> Source {
        Source::of_text(Instrument::builtin_text("concert-grand").unwrap())
    }

    /// Keys, numbers of the file and coordinates are read, and make the instruments that they say.
    #[test]
    fn keys_and_numbers_are_varied() {
        let keyboard = Source::Keyboard(Box::new(Keyboard::builtin("concert-grand").unwrap()), None);
        let keys = Axis::parse("key=1..88:4", &grand(), &keyboard).unwrap();
        assert_eq!((keys.shown.as_slice(), keys.column().as_str()), (&[1.0, 30.0, 59.0, 88.0][..], "key"));
        assert_eq!(Axis::parse("key=1..88", &grand(), &keyboard).unwrap().shown.len(), 88);
        let mass = Axis::parse("body.hammer.mass_g=4.6..4.8:3", &grand(), &keyboard).unwrap();
        assert_eq!(mass.column(), "body.hammer.mass_g");
        let axes = [keys, mass];
        let one = keyboard.instrument(&axes, &[3, 2]).unwrap().unwrap();
        let hammer = one.bodies.iter().find(|body| body.name == "hammer").unwrap();
        assert!(one.name.contains("key 88") && (hammer.mass_kg - 4.8e-3).abs() < 1e-12);
        let x = Axis::parse("zone.capstan_heel.disc.center_mm.x=140,145", &grand(), &read()).unwrap();
        assert_eq!(x.target, Target::Number("zone.capstan_heel.disc.center_mm".into(), 0));
        for wrong in ["key=0..88", "key=1..89", "key=9..2", "key=1..5:9", "key=H4"] {
            assert!(Axis::parse(wrong, &grand(), &keyboard).unwrap_err().contains("keys from 1 to 88"), "{wrong}");
        }
        let notes = Axis::parse("key=A0,C8,a4", &grand(), &keyboard).unwrap();
        assert_eq!(notes.shown, [1.0, 88.0, 49.0]);
        // What cannot be is said by the reader of such a file.
        let axes = [Axis::parse("body.hammer.mass_g==-3,1", &grand(), &read()).unwrap()];
        assert!(read().instrument(&axes, &[0]).unwrap().unwrap_err().contains("mass_g"));
    }

    /// A grading as a whole and at one of its points makes the keys that it says; a keyboard's own key stays its
    /// instrument.
    #[test]
    fn gradings_are_varied() {
        let keyboard = Keyboard::builtin("concert-grand").unwrap();
        let index = keyboard
            .gradings
            .iter()
            .position(|g| matches!(g.graded, Graded::AddedMass { ref body, .. } if body == "hammer"));
        let grading = keyboard.gradings[index.unwrap()].clone();
        let last = grading.curve.points.last().unwrap().clone();
        let mass = |instrument: &Instrument| {
            instrument.bodies.iter().find(|body| body.name == "hammer").unwrap().mass_kg * 1e3
        };
        let source = Source::Keyboard(Box::new(keyboard.clone()), Some(last.key));
        let own = mass(&keyboard.key(keyboard.base_key).unwrap());
        let whole = Axis::parse(&format!("grading.{}=x0,x0.5,x1", grading.name), &grand(), &source).unwrap();
        assert_eq!(whole.column(), format!("grading.{}_factor", grading.name));
        let axes = [whole];
        for (i, factor) in [0.0, 0.5, 1.0].into_iter().enumerate() {
            let key = source.instrument(&axes, &[i]).unwrap().unwrap();
            assert!((mass(&key) - own - factor * last.value).abs() < 1e-5, "{factor}: {}", mass(&key));
        }
        let point = Axis::parse(&format!("grading.{}.{}=-1g,-2", grading.name, last.key), &grand(), &source).unwrap();
        assert_eq!(point.column(), format!("grading.{}.{}_g", grading.name, last.key));
        let axes = [Axis::parse(&format!("key={},{}", keyboard.base_key, last.key), &grand(), &source).unwrap(), point];
        assert!((mass(&source.instrument(&axes, &[1, 1]).unwrap().unwrap()) - own + 2.0).abs() < 1e-5);
        assert!((mass(&source.instrument(&axes, &[0, 1]).unwrap().unwrap()) - own).abs() < 1e-9);
        for (wrong, source, told) in [
            ("grading.nothing=1,2", &source, "has no grading of that name"),
            (&format!("grading.{}.2=1,2", grading.name)[..], &source, "no point at key `2`"),
            (&format!("grading.{}.{}=1,2", grading.name, keyboard.base_key), &source, "is the instrument itself"),
            (&format!("grading.{}=1,2", grading.name), &read(), "only a keyboard has gradings"),
            (&format!("grading.{}=0.5,1", grading.name), &source, "expected factors"),
        ] {
            let error = Axis::parse(wrong, &grand(), source).unwrap_err();
            assert!(error.contains(told), "{wrong}: {error}");
        }
    }

    fn grand() -> Instrument {
        Instrument::builtin("concert-grand").unwrap()
    }

    #[test]
    fn ranges_and_lists_are_read() {
        let axis = |text: &str| Axis::parse(text, &grand(), &read()).unwrap_or_else(|error| panic!("{text}: {error}"));
        let screw = axis("let_off=-1mm..1mm:5");
        // Its setting in the file is 0.0538 mm.
        assert_eq!(screw.shown, [-0.9462, -0.4462, 0.0538, 0.5538, 1.0538]);
        assert_eq!((screw.column().as_str(), screw.changes[0]), ("let_off_mm", Change::Add(-1e-3)));
        let angle = axis("back_check_angle=-2deg..2 degrees:2");
        assert_eq!(angle.column(), "back_check_angle_degrees");
        assert_eq!(angle.changes[1], Change::Add(2.0 / (180.0 / std::f64::consts::PI)));
        for (text, column, shown) in [
            ("body.hammer.mass=x0.8, x1 ,x1.25", "body.hammer.mass_factor", vec![0.8, 1.0, 1.25]),
            ("body.hammer.mass=*0.8,1.25", "body.hammer.mass_factor", vec![0.8, 1.25]),
            ("body.hammer.mass=4.5,5g,0.2oz", "body.hammer.mass_g", vec![4.5, 5.0, 5.669_904_625]),
            ("body.hammer.mass=+0.8g", "body.hammer.mass_change_g", vec![0.8]),
            ("body.hammer.mass=-0.8,0,0.8g", "body.hammer.mass_change_g", vec![-0.8, 0.0, 0.8]),
            ("body.hammer.mass_g=+0.8,-1", "body.hammer.mass_change_g", vec![0.8, -1.0]),
            ("body.hammer.mass_g=5g", "body.hammer.mass_g", vec![5.0]),
            ("zone.string.stiffness=*2", "zone.string.stiffness_factor", vec![2.0]),
            ("zone.string.stiffness=2e8", "zone.string.stiffness_N_per_m_r", vec![2e8]),
            ("let_off=0.004in", "let_off_mm", vec![0.1016]),
            ("let_off=\u{2212}0.2", "let_off_mm", vec![-0.1462]),
            ("set_off=+0.2", "let_off_mm", vec![0.2538]),
            ("body.wippen.mass=x2", "body.whippen.mass_factor", vec![2.0]),
            ("force=1N..20:3", "force_N", vec![1.0, 10.5, 20.0]),
            ("force=100gf", "force_N", vec![0.980_665]),
        ] {
            let found = axis(text);
            assert_eq!(found.column(), column, "{text}");
            assert_eq!(found.shown, shown, "{text}");
        }
    }

    /// Values, differences and factors of a mass make the instruments that they say; a screw's values are settings.
    #[test]
    fn changes_are_counted_from_the_instrument() {
        let one = |text: &str| {
            let axis = Axis::parse(text, &grand(), &read()).unwrap();
            let Target::Parameter(parameter) = &axis.target else { panic!("{text}") };
            let mut varied = grand();
            let by = axis.by(parameter, &varied, 0).unwrap();
            parameter.vary(&mut varied, by).unwrap();
            parameter.value(&varied).unwrap()
        };
        let mass = Parameter::named(&grand(), "body.hammer.mass").unwrap().1.value(&grand()).unwrap();
        for (text, expected) in [
            ("body.hammer.mass=x1.25", 1.25 * mass),
            ("body.hammer.mass=+0.8g", mass + 0.8e-3),
            ("body.hammer.mass=5", 5e-3),
            ("let_off=0.3", 0.3e-3),
        ] {
            assert!((one(text) - expected).abs() < 1e-15, "{text}");
        }
    }

    /// Rows of `name, text, command, other`: what the command, and what C and Python make of a text for the grand.
    const TYPED: &str = include_str!("../../../erard-core/tests/typed.tsv");

    #[test]
    fn typed_texts_are_read_as_the_table_says() {
        let mut tried = 0;
        for row in TYPED.lines().skip(1) {
            let [name, text, expected, _] = row.split('\t').collect::<Vec<_>>().try_into().expect("four columns");
            let found = Axis::parse(&format!("{name}={text}"), &grand(), &read());
            let (kind, told) = expected.split_once(' ').expect("two words");
            let change = match (kind, found) {
                ("no", Err(error)) => {
                    assert!(error.contains(told), "{row}: {error}");
                    tried += 1;
                    continue;
                }
                (_, Ok(axis)) if kind != "no" => axis.changes[0],
                (_, found) => panic!("{row}: {found:?}"),
            };
            let number: f64 = told.parse().unwrap();
            let (kind, value) = match change {
                Change::Set(value) => ("set", value),
                Change::Add(by) => ("add", by),
                Change::Multiply(factor) => ("times", factor),
            };
            assert!(expected.starts_with(kind) && (value - number).abs() <= 1e-12, "{row}: {change:?}");
            tried += 1;
        }
        assert!(tried > 40, "{tried}");
    }

    /// Rows of `instrument, name, text, command, other, path, file_si`, generated from the register: every name, unit
    /// and spelling.
    const REGISTERED: &str = include_str!("../../../erard-core/tests/typed-register.tsv");

    #[test]
    fn the_register_is_read_as_the_table_says() {
        let mut tried = 0;
        for instrument in Instrument::builtin_names() {
            let grand = Instrument::builtin(instrument).unwrap();
            let source = Source::of_text(Instrument::builtin_text(instrument).unwrap());
            for row in REGISTERED.lines().filter(|row| row.split('\t').next() == Some(instrument)) {
                let [_, name, text, expected, ..] = row.split('\t').collect::<Vec<_>>()[..] else { panic!("{row}") };
                if expected == "-" {
                    continue;
                }
                let found = Axis::parse(&format!("{name}={text}"), &grand, &source);
                let (kind, told) = expected.split_once(' ').expect("two words");
                tried += 1;
                match (kind, found) {
                    ("no", Err(error)) => assert!(error.contains(told), "{row}: {error}"),
                    (_, Ok(axis)) if kind != "no" => {
                        let (found, value) = match axis.changes[0] {
                            Change::Set(value) => ("set", value),
                            Change::Add(by) => ("add", by),
                            Change::Multiply(factor) => ("times", factor),
                        };
                        let wanted: f64 = told.parse().unwrap();
                        let is_close = (value - wanted).abs() <= 1e-8 * wanted.abs();
                        assert!(found == kind && is_close, "{row}: {:?}", axis.changes);
                    }
                    (_, found) => panic!("{row}: {found:?}"),
                }
            }
        }
        assert!(tried > 400, "{tried}");
    }

    /// Every unit, by each of its names, of every registered number of every built-in instrument.
    #[test]
    fn every_unit_of_every_number_is_read() {
        let mut tried = 0;
        for file in Instrument::builtin_names() {
            let grand = Instrument::builtin(file).unwrap();
            let source = Source::of_text(Instrument::builtin_text(file).unwrap());
            let text = source.text(None);
            for (name, parameter) in Parameter::all(&grand) {
                let quantity = parameter.quantity(&grand).unwrap();
                let wanted = if parameter.is_factor() { 1.01 * parameter.value(&grand).unwrap() } else { 1e-4 };
                for unit in quantity.units() {
                    for symbol in unit.also.iter().chain([&unit.symbol]) {
                        let typed = format!("={:e} {symbol}", wanted / unit.si);
                        // The text of the file is read once for all.
                        assert_eq!(known_name(&name, &[(name.clone(), parameter.clone())], &text), name);
                        let axis = Axis::of_parameter(&name, &typed, &parameter, &grand)
                            .unwrap_or_else(|error| panic!("{name} {typed}: {error}"));
                        let Change::Set(found) = axis.changes[0] else { panic!("{name} {typed}") };
                        assert!((found / wanted - 1.0).abs() < 1e-6, "{file}: {name} {typed}: {found}");
                        tried += 1;
                    }
                }
            }
        }
        assert!(tried > 1000, "{tried}");
    }

    /// Whatever is wrong is named, and what would be right.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("let_off", "such as `let_off=-1mm..1mm:41`"),
            ("let_of=1mm..2mm:3", "nearest `let_off`"),
            ("let_off=1mm..2mm", "FROM..TO:COUNT"),
            ("let_off=1mm:3", "FROM..TO:COUNT"),
            ("let_off=1g..2mm:3", "`g` is not one of its units"),
            ("let_off=..2mm:3", "a length"),
            ("let_off=1mm..2mm:1", "from 2 to 100000"),
            ("let_off=1mm..2mm:many", "FROM..TO:COUNT"),
            ("let_off=1mm..200mm:3", "out of range"),
            ("let_off=nan..2mm:3", "a length"),
            ("let_off=0,5mm,1mm", "type `0.5mm, 1mm`"),
            ("let_off=1,-1", "values and changes are mixed"),
            ("body.hammer.mass=0..2:3", "a factor from 0.001 to 1000"),
            ("body.hammer.mass=x0..2:3", "a factor from 0.001 to 1000"),
            ("body.hammer.mass=one", "a mass"),
            ("body.key.friction=x2", "type `body.key_back.friction`"),
            ("body.key.friction_torque_N_m=x2", "type `body.key_back.friction_torque_N_m`"),
            ("zone.key_front.line.normal.y=x2", "type `zone.key_front.line.normal.x`"),
            ("sample=2", "unknown name `sample`"),
            ("force=1e9", "out of range"),
            ("force=-1", "out of range"),
            ("back_check_angle=1e9", "at most 90 degrees either way"),
            ("back_check_angle=-91deg..0deg:3", "at most 90 degrees either way"),
        ] {
            let error = Axis::parse(text, &grand(), &read()).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
