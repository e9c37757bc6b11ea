//! Reads and changes numbers in the text of an instrument file by their dotted paths, for callers that vary them.

use toml_edit::{DocumentMut, Item, Value};

use super::edit::{find, numbers};

/// Returns the numbers at a dotted path, such as `body.hammer.mass_g` (one) or `zone.string.disc.center_mm` (two), in
/// the file's own units; the entries of a list are distinguished by their `name`. `None` if the path leads to no
/// number.
#[must_use]
pub fn numbers_at(text: &str, path: &str) -> Option<Vec<f64>> {
    numbers_at_each(text, [path]).pop().flatten()
}

/// Returns the numbers at each of these paths, as [`numbers_at`] does. The text is parsed once.
#[must_use]
pub fn numbers_at_each<'a>(text: &str, paths: impl IntoIterator<Item = &'a str>) -> Vec<Option<Vec<f64>>> {
    let mut document: Option<DocumentMut> = text.parse().ok();
    let mut at = |path: &str| {
        let segments: Vec<&str> = path.split('.').collect();
        find(document.as_mut()?.as_table_mut(), &segments).and_then(|item| numbers(item, path))
    };
    paths.into_iter().map(&mut at).collect()
}

/// Returns the text with some numbers changed. Each change is a path, the index of the number there (from 0), and the
/// new value in the file's own unit. Sources and notes stay as they are, so use the result for computing and do not
/// save it. `None` if a number does not exist.
#[must_use]
pub fn with_numbers(text: &str, changes: &[(&str, usize, f64)]) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    for (path, which, value) in changes {
        let segments: Vec<&str> = path.split('.').collect();
        let item = find(document.as_table_mut(), &segments)?;
        numbers(item, path)?.get(*which)?;
        let place = number_of(item)?;
        let old = match place {
            Value::Array(array) => array.get_mut(*which)?,
            single => single,
        };
        *old = (*value).into();
    }
    Some(document.to_string())
}

/// Returns the bare value of a number that may be cited.
fn number_of(item: &mut Item) -> Option<&mut Value> {
    if item.as_table_like().is_some() {
        return item.as_table_like_mut()?.get_mut("value")?.as_value_mut();
    }
    item.as_value_mut()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::Instrument;

    /// A number and a coordinate of the built-in grand are found, changed, and read back as the instrument; the rest is
    /// the same.
    #[test]
    fn numbers_are_found_and_changed() {
        let text = Instrument::builtin_text("concert-grand-rigid").unwrap();
        let grand = Instrument::builtin("concert-grand-rigid").unwrap();
        assert_eq!(numbers_at(text, "body.hammer.mass_g"), Some(vec![11.2]));
        let center = numbers_at(text, "zone.capstan_heel.disc.center_mm").unwrap();
        assert_eq!(center.len(), 2);
        let moved = with_numbers(
            text,
            &[("body.hammer.mass_g", 0, 12.0), ("zone.capstan_heel.disc.center_mm", 0, center[0] - 3.0)],
        );
        let varied = Instrument::parse(&moved.unwrap(), "varied").unwrap();
        let hammer = grand.bodies.iter().position(|body| body.name == "hammer").unwrap();
        let zone = grand.zones.iter().position(|zone| zone.name == "capstan_heel").unwrap();
        assert!((varied.bodies[hammer].mass_kg - 12e-3).abs() < 1e-12);
        assert!((grand.zones[zone].disc_center_m[0] - varied.zones[zone].disc_center_m[0] - 3e-3).abs() < 1e-12);
        assert_eq!(grand.zones[zone].disc_center_m[1], varied.zones[zone].disc_center_m[1]);
        let both = numbers_at_each(text, ["body.drummer.mass_g", "body.hammer.mass_g"]);
        assert_eq!(both, [None, Some(vec![11.2])]);
        for path in ["body.hammer", "body.drummer.mass_g", "name", "zone.string.felt.softness", ""] {
            assert_eq!(numbers_at(text, path), None, "{path}");
            assert_eq!(with_numbers(text, &[(path, 0, 1.0)]), None, "{path}");
        }
        assert_eq!(with_numbers(text, &[("body.hammer.mass_g", 1, 1.0)]), None);
    }
}
