//! A law of one's own, from a file of points.

use std::path::Path;

use crate::failure::Failure;
use crate::session::Session;

/// The points of a file.
pub(crate) struct LawPoints {
    /// The file's name, as messages show it.
    pub name: String,
    pub points: Vec<[f64; 2]>,
    /// Their lines, from 1.
    pub lines: Vec<usize>,
}

/// The points of a law of one's own: two numbers a line below a head, such as `raw,mm`. Empty lines and lines that
/// begin with `#` are left out.
///
/// # Errors
/// Where it cannot be read, with what `option` expects, and where a line holds something else.
pub(crate) fn law_points(
    session: &mut Session,
    option: &str,
    path: &Path,
    head: &str,
    expected: &str,
) -> Result<LawPoints, Failure> {
    let (name, bytes) = session
        .inputs
        .bytes(path)
        .map_err(|error| Failure::Usage(format!("{option}: expected {expected} or a file of points; {error}")))?;
    let text = erard::instrument::utf8(&bytes, &name)?;
    let wrong = |line: usize, what: &str| Failure::Usage(format!("{name}, line {line}: {what}"));
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if index == 0 && line != head {
            return Err(wrong(1, &format!("expected the head `{head}`")));
        }
        if index == 0 || line.is_empty() || line.starts_with('#') {
            continue;
        }
        let numbers: Option<Vec<f64>> = line.split(',').map(|text| text.trim().parse().ok()).collect();
        let Some([from, to]) = numbers.as_deref().and_then(|numbers| <[f64; 2]>::try_from(numbers).ok()) else {
            return Err(wrong(index + 1, &format!("found `{line:.40}`; expected two numbers, as in `{head}`")));
        };
        points.push([from, to]);
        lines.push(index + 1);
    }
    session.provenance.used("law", &name, Some(&name), &bytes);
    Ok(LawPoints { name, points, lines })
}
