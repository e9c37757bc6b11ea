//! Writes changed numbers, such as the settings of screws, to the text of an instrument file. All other text, comments
//! and layout stay.

use toml_edit::DocumentMut;

use super::Instrument;
use super::edit::{cite, find, numbers, set, source_name};

/// Author of the new settings in the file's own list of sources.
const AUTHOR: &str = "erard regulate";
/// Name of the source of the new settings, unless it is taken.
const SOURCE: &str = "regulated";

/// Reason why a file cannot be rewritten. The text was read successfully before, so none of these is the user's
/// mistake.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// The text is not TOML.
    #[error("the instrument file cannot be rewritten: {0}")]
    Toml(#[from] toml_edit::TomlError),
    /// The text has no setting of this screw.
    #[error("the instrument file cannot be rewritten: it has no setting of screw `{0}`")]
    NoSetting(String),
    /// The text has no number at this path.
    #[error("the instrument file cannot be rewritten: it has no number `{0}`")]
    NoNumber(String),
}

impl Instrument {
    /// Returns `text`, the file that this instrument was read from, with the present settings of the screws. Only
    /// settings that differ are changed: each becomes a cited number with `note`, and their common source gets `title`.
    ///
    /// Settings are rounded to 0.1 um, 0.0001 degrees or 1 uN m.
    ///
    /// # Errors
    /// See [`RewriteError`].
    pub fn rewrite(&self, text: &str, title: &str, note: &str) -> Result<String, RewriteError> {
        let form = Form::of(text);
        let mut document: DocumentMut = form.plain(text).parse()?;
        let source = source_name(&document, SOURCE, AUTHOR);
        let mut changed = false;
        for screw in &self.screws {
            let (key, setting) = screw.action.in_file(screw.setting);
            let missing = || RewriteError::NoSetting(screw.name.clone());
            let path = ["screw", screw.name.as_str(), key];
            let item = find(document.as_table_mut(), &path).ok_or_else(missing)?;
            if numbers(item, key).as_deref() != Some(&[setting]) {
                set(item, setting, &source, note);
                changed = true;
            }
        }
        if changed {
            cite(&mut document, &source, title, AUTHOR);
        }
        Ok(form.dressed(&document.to_string()))
    }
}

/// Returns the text of an instrument file with some numbers changed. Each change is the path of a single number (see
/// [`super::numbers_at`]), its new value in the file's own unit, and a note. Each becomes a cited number; their common
/// source is named after `stem` and has `author` and `title`. Comments and layout stay.
///
/// # Errors
/// See [`RewriteError`].
pub fn cited(
    text: &str,
    changes: &[(String, f64, String)],
    stem: &str,
    author: &str,
    title: &str,
) -> Result<String, RewriteError> {
    let form = Form::of(text);
    let mut document: DocumentMut = form.plain(text).parse()?;
    let source = source_name(&document, stem, author);
    for (path, value, note) in changes {
        let segments: Vec<&str> = path.split('.').collect();
        let item = find(document.as_table_mut(), &segments).filter(|item| numbers(item, path).is_some());
        set(item.ok_or_else(|| RewriteError::NoNumber(path.clone()))?, *value, &source, note);
    }
    if !changes.is_empty() {
        cite(&mut document, &source, title, author);
    }
    Ok(form.dressed(&document.to_string()))
}

/// Features of a text that `toml_edit` drops.
#[derive(Debug, Clone, Copy)]
struct Form {
    byte_order_mark: bool,
    /// Whether most lines end with carriage return and line feed.
    crlf: bool,
}

impl Form {
    fn of(text: &str) -> Self {
        let (all, crlf) = (text.matches('\n').count(), text.matches("\r\n").count());
        Form { byte_order_mark: text.starts_with('\u{feff}'), crlf: 2 * crlf > all }
    }

    fn plain(self, text: &str) -> String {
        text.trim_start_matches('\u{feff}').replace("\r\n", "\n")
    }

    fn dressed(self, plain: &str) -> String {
        let text = if self.crlf { plain.replace('\n', "\r\n") } else { plain.to_owned() };
        if self.byte_order_mark { format!("\u{feff}{text}") } else { text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(text: &str, turns: &[(&str, f64)]) -> (Instrument, String) {
        let mut instrument = Instrument::parse(text, "test").unwrap();
        for &(name, setting) in turns {
            let screw = instrument.screw(name).unwrap();
            assert!(instrument.turn(screw, setting));
        }
        let text = instrument.rewrite(text, "a title", "a note").unwrap();
        (instrument, text)
    }

    /// Lines of `a` that `b` does not have, and lines of `b` that `a` does not have.
    fn changed(a: &str, b: &str) -> (Vec<String>, Vec<String>) {
        let (a, b): (Vec<&str>, Vec<&str>) = (a.lines().collect(), b.lines().collect());
        let gone = a.iter().filter(|line| !b.contains(line)).map(|l| (*l).to_owned()).collect();
        let new = b.iter().filter(|line| !a.contains(line)).map(|l| (*l).to_owned()).collect();
        (gone, new)
    }

    /// Two settings of the grand: two lines change and a source is added; every other line, comments included, stays.
    /// What is read back has the same screws to the bit.
    #[test]
    fn only_the_settings_change() {
        let text = Instrument::builtin_text("concert-grand-rigid").unwrap();
        let (instrument, new) = turned(
            text,
            &[("let_off", 0.2834 / 1e3), ("repetition_spring", -0.002), ("back_check_angle", 2_f64.to_radians())],
        );
        let (gone, added) = changed(text, &new);
        assert!(gone.iter().all(|line| line.starts_with("setting_")), "{gone:?}");
        let added = added.join("\n");
        assert!(
            added.contains(
                "setting_mm = { value = 0.2834, source = \"regulated\", certainty = \"estimate\", note = \"a note\" }"
            ),
            "{added}"
        );
        assert!(
            added.contains("setting_N_m = { value = -0.002,") && added.contains("setting_deg = { value = 2.0,"),
            "{added}"
        );
        assert!(added.contains("[sources.regulated]\ntitle = \"a title\""), "{added}");
        assert_eq!(new.lines().count(), text.lines().count() + 4);
        let read = Instrument::parse(&new, "new").unwrap();
        assert_eq!(read.screws, instrument.screws);
        // Once more: the same source, one title.
        let again = instrument.rewrite(&new, "another title", "a note").unwrap();
        assert_eq!(again, new, "nothing to change, nothing changed");
    }

    /// Numbers changed by their paths are cited and all other text stays. A path that does not exist is an error.
    #[test]
    fn numbers_become_cited_ones() {
        let text = Instrument::builtin_text("concert-grand-rigid").unwrap();
        let change = |path: &str, value: f64| (path.to_owned(), value, "a note".to_owned());
        let changes = [change("body.hammer.mass_g", 11.5), change("zone.string.felt.stiffness_N_per_m_r", 2e10)];
        let new = cited(text, &changes, "mine", "me", "a title").unwrap();
        let (gone, added) = changed(text, &new);
        assert_eq!(gone.len(), 2, "{gone:?}");
        let added = added.join("\n");
        assert!(
            added.contains("mass_g = { value = 11.5, source = \"mine\", certainty = \"estimate\", note = \"a note\" }"),
            "{added}"
        );
        assert!(added.contains("[sources.mine]\ntitle = \"a title\"\nauthor = \"me\""), "{added}");
        let read = Instrument::parse(&new, "new").unwrap();
        let hammer = read.bodies.iter().find(|body| body.name == "hammer").unwrap();
        assert!((hammer.mass_kg - 11.5e-3).abs() < 1e-15);
        for path in ["body.drummer.mass_g", "screw.nobody.setting_mm"] {
            let error = cited(text, &[change(path, 1.0)], "mine", "me", "a title").unwrap_err();
            assert!(error.to_string().contains(path), "{error}");
        }
    }

    /// Line ends and byte order marks of other systems stay.
    #[test]
    fn written_elsewhere() {
        let unix = Instrument::builtin_text("concert-grand-rigid").unwrap();
        let windows = format!("\u{feff}{}", unix.replace('\n', "\r\n"));
        let turns = [("let_off", 0.2834 / 1e3)];
        let ((_, plain), (_, new)) = (turned(unix, &turns), turned(&windows, &turns));
        assert_eq!(new, format!("\u{feff}{}", plain.replace('\n', "\r\n")));
    }

    /// Bare numbers, comments behind them, inline tables, a source of the same name by somebody else.
    #[test]
    fn other_ways_to_write_it() {
        let base = "format = \"erard-instrument/1\"\nname = \"x\"\ngravity_m_s2 = 9.81\n\
            spring = [{ name = \"coil\", body = \"a\", torque_N_m = 1, stiffness_N_m_per_rad = 0 }]\n\
            body = [{ name = \"a\", pivot_mm = [0, 0], mass_g = 1, inertia_kg_m2 = 1, center_of_mass_mm = [0, 0] }]\n";
        let tables = format!(
            "{base}[sources.regulated]\ntitle = \"mine\"\n[[screw]]\nname = \"s\"\nspring = \"coil\"\nsetting_N_m = 0 # my own\n"
        );
        let (_, new) = turned(&tables, &[("s", 0.25)]);
        assert!(new.contains("setting_N_m = { value = 0.25, source = \"regulated-2\","), "{new}");
        assert!(new.contains("} # my own\n") && new.contains("title = \"mine\""), "{new}");
        assert_eq!(Instrument::parse(&new, "new").unwrap().screws[0].setting, 0.25);

        let inline =
            base.replace("spring = [", "screw = [{ name = \"s\", spring = \"coil\", setting_N_m = 0 }]\nspring = [");
        let (_, new) = turned(&inline, &[("s", 0.25)]);
        assert_eq!(Instrument::parse(&new, "new").unwrap_or_else(|e| panic!("{e}\n{new}")).screws[0].setting, 0.25);
    }
}
