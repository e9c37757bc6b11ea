//! `--move capstan=-10mm`: the moved part, and its distance.

use erard::parameter::{Bare, Quantity};
use erard_kinematics::three_lever::Move;

use crate::suggest::meant;

/// Name of the case in which nothing is moved.
pub(crate) const UNMOVED: &str = "unmoved";
/// Display name of this case.
pub(crate) const AS_IT_IS: &str = "as it is";

/// Largest move, mm: an action is half a metre long, its parts are shorter.
const MAX_MOVE_MM: f64 = 200.0;

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
    // Between semicolons, commas are decimal.
    for one in text.split(if text.contains(';') { ';' } else { ',' }) {
        let (part, distance) = one
            .split_once('=')
            .ok_or_else(|| format!("`{one}`: expected a part, `=` and a distance, such as `capstan=-10mm`"))?;
        let (part, distance) = (part.trim(), distance.trim());
        let (name, make) = PARTS.into_iter().find(|(name, _)| *name == part).ok_or_else(|| {
            let known: Vec<&str> = PARTS.iter().map(|(name, _)| *name).collect();
            let meant = meant(part, known.iter().copied());
            format!("unknown part `{part}`; expected one of {}{meant}", known.join(", "))
        })?;
        let metres = Quantity::Length.read(distance, Bare::Refused).map_err(|error| format!("`{part}`: {error}"))?;
        // As a person would write it.
        let mm = (metres * 1e12).round() / 1e9;
        if mm.abs() > MAX_MOVE_MM {
            return Err(format!("`{one}`: expected a distance of at most {MAX_MOVE_MM} mm"));
        }
        if names.iter().any(|known: &String| known.starts_with(&format!("{name}="))) {
            return Err(format!("`{name}` is moved twice in `{text}`"));
        }
        names.push(format!("{name}={mm}mm"));
        labels.push(format!("{} {}{} mm", name.replace('-', " "), if mm < 0.0 { "−" } else { "+" }, mm.abs()));
        moves.push(make(metres));
    }
    Ok(MoveOption { name: names.join(" "), label: labels.join(", "), moves })
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
        assert_eq!(parse("capstan=-1cm; knuckle=\u{2212}3,0 mm").unwrap().moves, both.moves);
    }

    /// Errors state what was found and what is expected.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("capstan", "such as `capstan=-10mm`"),
            ("", "such as `capstan=-10mm`"),
            ("capstan=-10", "`-10mm`"),
            ("capstan=-10kg", "`kg` is not one of its units"),
            ("capstan=", "expected a length"),
            ("capstan=mm", "expected a length"),
            ("capstan=tenmm", "expected a length"),
            ("capstan=nanmm", "expected a length"),
            ("capstan=infmm", "expected a length"),
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
