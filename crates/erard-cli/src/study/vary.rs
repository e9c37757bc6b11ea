//! `--vary let_off=-1mm..1mm:41`: what is varied, from where to where, in how many steps.

use erard::instrument::{Instrument, with_numbers};
use erard::keyboard::{Between, Graded, KEYS, Keyboard, key_named, keys_named};
use erard::stroke::MAX_FORCE_N;
use erard_workshop::regulate::screw_unit;
use erard_workshop::study::{Parameter, known_name, nearest, number_of};

/// What a value is given to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Target {
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
pub(crate) enum Source {
    /// An instrument's text.
    Text(String),
    /// A keyboard, and the key that is played where keys are not varied (`None`: its own instrument's).
    Keyboard(Box<Keyboard>, Option<usize>),
}

impl Source {
    /// The text of the instrument: of a keyboard, that of a key, or of its own.
    fn text(&self, key: Option<usize>) -> String {
        match self {
            Source::Text(text) => text.clone(),
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
    /// What the reader says of such an instrument.
    pub(crate) fn instrument(&self, axes: &[Axis], indices: &[usize]) -> Option<Result<Instrument, String>> {
        let each = || axes.iter().zip(indices);
        let key = each().find(|(axis, _)| axis.target == Target::Key).map(|(axis, &i)| axis.shown[i] as usize);
        let changes: Vec<(&str, usize, f64)> = each()
            .filter_map(|(axis, &i)| match &axis.target {
                Target::Number(path, which) => Some((path.as_str(), *which, axis.shown[i])),
                _ => None,
            })
            .collect();
        let gradings: Vec<(usize, Option<usize>, f64)> = each()
            .filter_map(|(axis, &i)| match axis.target {
                Target::Grading(index, point) => Some((index, point, axis.shown[i])),
                _ => None,
            })
            .collect();
        if key.is_none() && changes.is_empty() && gradings.is_empty() {
            return None;
        }
        let name = match key {
            Some(key) => format!("key {key}"),
            None => "the varied instrument".to_owned(),
        };
        let text = with_numbers(&self.graded(key, &gradings), &changes)
            .ok_or_else(|| "a number that is varied is not there".to_owned());
        Some(text.and_then(|text| Instrument::parse(&text, &name).map_err(|error| error.to_string())))
    }
}

/// One `--vary`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// As it was asked for, e.g. `let_off`.
    pub name: String,
    /// Of the shown values, e.g. `mm`; empty for a factor.
    pub unit: &'static str,
    /// As shown: in `unit`.
    pub shown: Vec<f64>,
    /// The shown value of one SI unit.
    pub per_si: f64,
    /// The target that receives them.
    pub target: Target,
}

/// The names of the force and of the key.
const FORCE: &str = "force";
/// Most degrees that a screw turns a curve.
const MOST_TURNED_DEG: f64 = 90.0;
const KEY: &str = "key";
/// What the name of a grading of a keyboard begins with.
pub(crate) const GRADING: &str = "grading.";
/// Most values of one axis.
const MOST: usize = 100_000;

impl Axis {
    /// Reads the value of `--vary` for an instrument.
    ///
    /// # Errors
    /// One sentence that says what is wrong and what would be right.
    pub(crate) fn parse(text: &str, instrument: &Instrument, source: &Source) -> Result<Self, String> {
        let (name, values) = text
            .split_once('=')
            .ok_or_else(|| format!("`{text}`: expected a name, `=`, and values such as `let_off=-1mm..1mm:41`"))?;
        let all = Parameter::all(instrument);
        let name = known_name(name, &all, &source.text(None));
        let name = name.as_str();
        if name == KEY {
            return Self::keys(values);
        }
        let (target, per_si, unit, suffixes): (Target, f64, &str, &[&str]) = if name == FORCE {
            (Target::Force, 1.0, "N", &["N"])
        } else if let Some(grading) = name.strip_prefix(GRADING) {
            let (target, unit) = grading_of(grading, source)?;
            (target, 1.0, unit, if unit == "g" { &["g"] } else { &["mm"] })
        } else if let Some((path, which, _)) = number_of(&source.text(None), name) {
            (Target::Number(path, which), 1.0, "", &[])
        } else {
            let Some((_, parameter)) = all.iter().find(|(known, _)| known == name) else {
                return Err(format!(
                    "--vary: unknown name `{name}`, nearest {}; expected a screw or parameter, {FORCE}, {KEY} or {GRADING}NAME (of a keyboard), or the path of a number in the file, e.g. `body.hammer.mass_g`",
                    nearest(name, all.iter().map(|(known, _)| known))
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
                let is_number = matches!(target, Target::Number(..));
                let kind = match unit {
                    "" if is_number => "a number".to_owned(),
                    "" => "a factor".to_owned(),
                    unit => format!("a number of {unit}"),
                };
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

    /// Keys of a keyboard: `1..88`, `1..88:12`, `1,40,88`.
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
        let shown = keys.into_iter().map(|key| key as f64).collect();
        Ok(Axis { name: KEY.to_owned(), unit: "", shown, per_si: 1.0, target: Target::Key })
    }

    /// A value in SI units, or the factor.
    pub(crate) fn si(&self, index: usize) -> f64 {
        self.shown[index] / self.per_si
    }

    /// The name of its column: with the unit, as all columns.
    pub(crate) fn column(&self) -> String {
        if matches!(self.target, Target::Key | Target::Number(..)) {
            return self.name.clone();
        }
        let unit = self.unit.replace(' ', "_");
        if unit.is_empty() { format!("{}_factor", self.name) } else { format!("{}_{unit}", self.name) }
    }

    fn allows(&self, shown: f64) -> bool {
        match &self.target {
            Target::Force => (0.0..=MAX_FORCE_N).contains(&shown),
            // The reader of the file knows what can be.
            Target::Key | Target::Number(..) | Target::Grading(..) => true,
            Target::Parameter(parameter) => {
                let [least, most] = parameter.range();
                (least * self.per_si..=most * self.per_si).contains(&shown)
            }
        }
    }

    fn allowed(&self) -> String {
        match &self.target {
            Target::Force => format!("from 0 to {MAX_FORCE_N} N: a finger pushes the key down, and cannot pull it up"),
            Target::Key | Target::Number(..) | Target::Grading(..) => "a number".into(),
            Target::Parameter(parameter) if parameter.is_factor() => "a factor from 0.001 to 1000".into(),
            Target::Parameter(_) if self.unit == "degrees" => format!("at most {MOST_TURNED_DEG} degrees either way"),
            Target::Parameter(_) => format!("at most {} {}", 0.1 * self.per_si, self.unit),
        }
    }
}

/// A grading of a keyboard by its name: the whole; with `.` and the number of a key behind it, its point there.
fn grading_of(name: &str, source: &Source) -> Result<(Target, &'static str), String> {
    let Source::Keyboard(keyboard, _) = source else {
        return Err(format!(
            "`{GRADING}{name}`: only a keyboard has gradings; vary {KEY} too, or use --instrument concert-grand:key=88"
        ));
    };
    let place = |name: &str| keyboard.gradings.iter().position(|grading| grading.name == name);
    if let Some(index) = place(name) {
        return Ok((Target::Grading(index, None), ""));
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
    let unit = match grading.graded {
        Graded::AddedMass { .. } => "g",
        Graded::Factor { .. } => "",
        Graded::Shift { .. } => "mm",
    };
    Ok((Target::Grading(index, Some(at)), unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read() -> Source {
        Source::Text(Instrument::builtin_text("concert-grand").unwrap().to_owned())
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
        // What cannot be is said by the reader of such a file.
        let axes = [Axis::parse("body.hammer.mass_g=-3,1", &grand(), &read()).unwrap()];
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
        let whole = Axis::parse(&format!("grading.{}=0,0.5,1", grading.name), &grand(), &source).unwrap();
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
        let axis = Axis::parse("let_off=-1mm..1mm:5", &grand(), &read()).unwrap();
        assert_eq!(axis.shown, [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!((axis.column().as_str(), axis.si(0)), ("let_off_mm", -1e-3));
        let axis = Axis::parse("body.hammer.mass=0.8, 1 ,1.25", &grand(), &read()).unwrap();
        assert_eq!((axis.shown.as_slice(), axis.column().as_str()), (&[0.8, 1.0, 1.25][..], "body.hammer.mass_factor"));
        let axis = Axis::parse("force=1N..20:3", &grand(), &read()).unwrap();
        assert_eq!((axis.shown.as_slice(), axis.column().as_str()), (&[1.0, 10.5, 20.0][..], "force_N"));
        let axis = Axis::parse("back_check_angle=-2deg..2 degrees:2", &grand(), &read()).unwrap();
        assert!((axis.si(1) - 2.0_f64.to_radians()).abs() < 1e-15);
    }

    /// Whatever is wrong is named, and what would be right.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("let_off", "such as `let_off=-1mm..1mm:41`"),
            ("let_of=1mm..2mm:3", "nearest `let_off`"),
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
            let error = Axis::parse(text, &grand(), &read()).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
