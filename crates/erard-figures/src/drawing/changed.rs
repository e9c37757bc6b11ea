//! Numbers that were changed while the note beside them still speaks of what they were: a mark in the picture, and a
//! line below it.

use super::carried;
use super::outline::MM;
use super::piece::Carrier;
use crate::picture::{Geometry, Group, Node, Shape, Words};
use erard::instrument::{Instrument, OutlivedNote, Placement, ScrewAction, Vec2};

/// Height of the letters of the lines below a picture, and from line to line, mm of the picture.
pub(super) const SIZE: f64 = 4.4;
pub(super) const LINE: f64 = 6.0;
/// Width of an average letter against its height.
const LETTER: f64 = 0.6;
/// Most numbers that are marked in a picture.
const MAX_LABELS: usize = 9;

/// A number whose note speaks of what it was before it was changed.
#[derive(Debug, Clone, PartialEq)]
pub struct ChangedNote {
    /// The body (`None`: the ground) and the point in its frame, m, that the number belongs to; `None` where it has no
    /// place.
    pub place: Option<(Option<usize>, Vec2)>,
    /// The changed number, and its note.
    pub text: String,
}

impl ChangedNote {
    /// Those of an instrument's file.
    #[must_use]
    pub fn all(instrument: &Instrument, outlived: &[OutlivedNote]) -> Vec<Self> {
        let numbers = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        let of = |one: &OutlivedNote| {
            let note = one.number.citation.as_ref().and_then(|citation| citation.note.as_deref()).unwrap_or_default();
            ChangedNote {
                place: place(instrument, &one.number.key),
                text: format!(
                    "{} is {} ({} in {}); no longer true: \u{201c}{note}\u{201d}",
                    one.number.key,
                    numbers(&one.number.values),
                    numbers(&one.was),
                    one.builtin
                ),
            }
        };
        outlived.iter().map(of).collect()
    }
}

/// Where a number belongs, by its path in the file.
fn place(instrument: &Instrument, key: &str) -> Option<(Option<usize>, Vec2)> {
    let mut path = key.split('.');
    let (kind, name) = (path.next()?, path.next()?);
    let disc = |zone: usize| instrument.zones.get(zone).map(|zone| (zone.disc_body, zone.disc_center_m));
    let pivot = |body: usize| (body < instrument.bodies.len()).then_some((Some(body), [0.0; 2]));
    match kind {
        "body" => {
            let body = instrument.bodies.iter().position(|body| body.name == name)?;
            if path.next().is_some_and(|what| what.starts_with("center_of_mass")) {
                return Some((Some(body), instrument.bodies[body].center_of_mass_m));
            }
            pivot(body)
        }
        "zone" => disc(instrument.zones.iter().position(|zone| zone.name == name)?),
        "spring" => pivot(instrument.springs.get(instrument.springs.iter().position(|s| s.name == name)?)?.body),
        "screw" => match instrument.screws.iter().find(|screw| screw.name == name)?.action {
            ScrewAction::Disc { zone, .. } | ScrewAction::Curve { zone, .. } | ScrewAction::Turn { zone, .. } => {
                disc(zone)
            }
            ScrewAction::Spring { spring, .. } => pivot(instrument.springs.get(spring)?.body),
        },
        "finger" => Some((instrument.roles.key, instrument.roles.key_front_m)),
        _ => None,
    }
}

/// The marks: a ring with the number of its line at every place, moving with its body; nothing where none was changed.
#[must_use]
pub(crate) fn changed_marks(instrument: &Instrument, changed: &[ChangedNote], placed: &[Placement]) -> Vec<Node> {
    if changed.is_empty() {
        return Vec::new();
    }
    let drawn = instrument.drawn();
    let mut marks = Vec::new();
    let mut taken: Vec<Vec2> = Vec::new();
    for (index, note) in changed.iter().enumerate().take(MAX_LABELS) {
        let Some((body, point_m)) = note.place else { continue };
        let drawn_m = body.map_or(point_m, |body| drawn[body].to_world(point_m));
        let carrier = body.map_or(Carrier::Ground, |body| Carrier::Point { body, point_m, drawn_m, is_guided: false });
        let [mut x, y] = [drawn_m[0] * MM, -drawn_m[1] * MM];
        // Several numbers of one place stand in a row.
        while taken.iter().any(|other| (other[0] - x).hypot(other[1] - y) < 5.0) {
            x += 5.2;
        }
        taken.push([x, y]);
        let nodes = vec![
            Shape::of_class("mark", Geometry::Circle(Some([x, y]), 2.4)),
            Words::node("mark-number", [x, y + 1.45], [], &(index + 1).to_string()),
        ];
        marks.push(Node::Group(Group { carried: carried(&carrier, placed), nodes, ..Group::default() }));
    }
    vec![Node::Group(Group { class: "marks", nodes: marks, ..Group::default() })]
}

/// The lines below a picture of a width, mm.
pub(super) fn lines(changed: &[ChangedNote], width: f64) -> Vec<String> {
    let room = ((width / (LETTER * SIZE)) as usize).max(20);
    let mut lines: Vec<String> = Vec::new();
    for (index, note) in changed.iter().enumerate().take(MAX_LABELS) {
        let mut line = format!("changed ({}):", index + 1);
        for word in note.text.split(' ') {
            if line.chars().count() + 1 + word.chars().count() > room {
                lines.push(std::mem::replace(&mut line, "    ".to_owned()));
            }
            line.push(' ');
            line.push_str(word);
        }
        lines.push(line);
    }
    if changed.len() > MAX_LABELS {
        lines.push(format!("and {} more: erard check names them", changed.len() - MAX_LABELS));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::super::{PoseOptions, pose_picture};
    use super::*;
    use erard::instrument::InstrumentFile;

    fn moved() -> InstrumentFile {
        let text = Instrument::builtin_text("concert-grand").unwrap();
        let file = InstrumentFile::builtin("concert-grand").unwrap();
        let number = file.provenance.numbers.iter().find(|n| n.key == "zone.capstan_heel.disc.center_mm").unwrap();
        let (mut lines, from): (Vec<String>, _) = (text.lines().map(str::to_owned).collect(), number.values[0]);
        let line = &mut lines[number.line - 1];
        let changed = line.replacen(&from.to_string(), &(from - 10.0).to_string(), 1);
        assert_ne!(*line, changed);
        *line = changed;
        InstrumentFile::parse(&lines.join("\n"), "moved").unwrap()
    }

    /// A capstan that was moved is marked where it is now, and the line says what its note said; an instrument as it
    /// comes has no mark.
    #[test]
    fn a_note_that_became_untrue_is_marked_where_it_belongs() {
        let file = moved();
        let changed = ChangedNote::all(&file.instrument, &file.provenance.outlived_notes());
        let [one] = &changed[..] else { panic!("{changed:?}") };
        let zone = file.instrument.zones.iter().find(|zone| zone.name == "capstan_heel").unwrap();
        assert_eq!(one.place, Some((zone.disc_body, zone.disc_center_m)));
        let angles = file.instrument.drawn_angles();
        let svg = pose_picture(
            &file.instrument,
            &angles,
            &PoseOptions { changed: changed.clone(), ..PoseOptions::default() },
        )
        .svg();
        let mark = svg.split("<circle class=\"mark\"").nth(1).unwrap();
        let value = |name: &str| -> f64 {
            mark.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
        };
        let at = file.instrument.placements(&angles)[zone.disc_body.unwrap()].to_world(zone.disc_center_m);
        assert!((value("cx") - at[0] * MM).abs() < 0.01 && (value("cy") + at[1] * MM).abs() < 0.01, "{mark}");
        let text: String =
            svg.split("class=\"changed-note\"").skip(1).map(|part| part.split('<').next().unwrap()).collect();
        assert!(
            text.contains("capstan_heel.disc.center_mm") && text.contains("no longer") && text.contains("145"),
            "{text}"
        );
        let plain = pose_picture(&file.instrument, &angles, &PoseOptions::default()).svg();
        assert!(!plain.contains("class=\"mark\"") && !plain.contains("<text class=\"changed-note\""));
        // Every kind of number has its place, and names that are not there have none.
        for (key, known) in [
            ("body.hammer.mass_g", true),
            ("body.hammer.center_of_mass_mm", true),
            ("spring.repetition.torque_N_m", true),
            ("screw.let_off.setting_mm", true),
            ("finger.stiffness_N_per_m", true),
            ("body.nothing.mass_g", false),
            ("gravity_m_s2", false),
        ] {
            assert_eq!(place(&file.instrument, key).is_some(), known, "{key}");
        }
    }

    #[test]
    fn lines_keep_within_the_picture() {
        let long = ChangedNote { place: None, text: "a word of a note ".repeat(40) };
        let all = lines(&vec![long; 12], 300.0);
        assert!(all.iter().all(|line| line.chars().count() as f64 * LETTER * SIZE <= 300.0 + 30.0), "{all:?}");
        assert_eq!(all.last().unwrap(), "and 3 more: erard check names them");
    }
}
