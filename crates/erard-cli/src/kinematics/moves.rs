//! `--move capstan=-10mm`: the moved part, and its distance.

use erard_kinematics::three_lever::Move;

/// Name of the case in which nothing is moved.
pub(crate) const UNMOVED: &str = "unmoved";
/// Display name of this case.
pub(crate) const AS_IT_IS: &str = "as it is";

/// Largest move, mm: an action is half a metre long, its parts are shorter.
const FARTHEST_MM: f64 = 200.0;

/// Makes the move of a part by a distance, m.
type Make = fn(f64) -> Move;

/// Parts that can be moved: name on the command line, and move.
const PARTS: [(&str, Make); 10] = [
    ("capstan", Move::Capstan),
    ("knuckle", Move::Knuckle),
    ("capstan-height", Move::CapstanHeight),
    ("heel-depth", Move::HeelDepth),
    ("knuckle-depth", Move::KnuckleDepth),
    ("jack-height", Move::JackHeight),
    ("whippen-x", |x| Move::WhippenPivot(x, 0.0)),
    ("whippen-y", |y| Move::WhippenPivot(0.0, y)),
    ("hammer-x", |x| Move::HammerPivot(x, 0.0)),
    ("hammer-y", |y| Move::HammerPivot(0.0, y)),
];

/// One `--move`: one part moved, or several at once, separated by commas.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MoveOption {
    /// Name in files: `capstan=-10mm`, several separated by a blank.
    pub name: String,
    /// Display name: `capstan −10 mm`.
    pub label: String,
    /// The moves.
    pub moves: Vec<Move>,
}

/// Reads the value of `--move`.
///
/// # Errors
/// One sentence with what was found and what is expected.
pub(crate) fn parse(text: &str) -> Result<MoveOption, String> {
    let (mut names, mut labels, mut moves) = (Vec::new(), Vec::new(), Vec::new());
    for one in text.split(',') {
        let (part, distance) = one
            .split_once('=')
            .ok_or_else(|| format!("`{one}`: expected a part, `=` and a distance, such as `capstan=-10mm`"))?;
        let (part, distance) = (part.trim(), distance.trim());
        let (name, make) = PARTS.into_iter().find(|(name, _)| *name == part).ok_or_else(|| {
            let known: Vec<&str> = PARTS.iter().map(|(name, _)| *name).collect();
            format!("unknown part `{part}`; expected one of {}", known.join(", "))
        })?;
        let number = distance.strip_suffix("mm").map(str::trim_end).ok_or_else(|| {
            format!("`{distance}` has no unit that is known; write millimetres as `{part}={}mm`", bare_number(distance))
        })?;
        let mm: f64 = number.parse().map_err(|_| format!("`{number}` is not a number, in `{one}`"))?;
        if mm.is_nan() || mm.abs() > FARTHEST_MM {
            return Err(format!("`{one}`: expected a distance of at most {FARTHEST_MM} mm"));
        }
        if names.iter().any(|known: &String| known.starts_with(&format!("{name}="))) {
            return Err(format!("`{name}` is moved twice in `{text}`"));
        }
        names.push(format!("{name}={mm}mm"));
        labels.push(format!("{} {}{} mm", name.replace('-', " "), if mm < 0.0 { "−" } else { "+" }, mm.abs()));
        moves.push(make(mm / 1000.0));
    }
    Ok(MoveOption { name: names.join(" "), label: labels.join(", "), moves })
}

/// The number in a distance, for the advice; -10 if there is none.
fn bare_number(distance: &str) -> &str {
    let end = distance.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(distance.len());
    if distance[..end].parse::<f64>().is_ok() { &distance[..end] } else { "-10" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_are_read() {
        let capstan = parse("capstan=-10mm").unwrap();
        assert_eq!((capstan.name.as_str(), capstan.label.as_str()), ("capstan=-10mm", "capstan −10 mm"));
        assert_eq!(capstan.moves, [Move::Capstan(-0.010)]);
        assert_eq!(parse("knuckle= +1.5 mm").unwrap().name, "knuckle=1.5mm");
        let both = parse("capstan=-10mm,knuckle=-3mm").unwrap();
        assert_eq!(both.moves, [Move::Capstan(-0.010), Move::Knuckle(-0.003)]);
        assert_eq!(both.name, "capstan=-10mm knuckle=-3mm");
    }

    /// Errors state what was found and what is expected.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("capstan", "such as `capstan=-10mm`"),
            ("", "such as `capstan=-10mm`"),
            ("capstan=-10", "`capstan=-10mm`"),
            ("capstan=-10cm", "`capstan=-10mm`"),
            ("capstan=", "has no unit"),
            ("capstan=mm", "is not a number"),
            ("capstan=tenmm", "is not a number"),
            ("capstan=nanmm", "at most 200 mm"),
            ("capstan=infmm", "at most 200 mm"),
            ("capstan=-1e9mm", "at most 200 mm"),
            ("pedal=1mm", "expected one of capstan, knuckle"),
            ("capstan=1mm,capstan=2mm", "moved twice"),
            ("capstan=1mm,", "such as `capstan=-10mm`"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
