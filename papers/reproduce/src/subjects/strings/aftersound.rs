//! What makes a note of three strings fall fast and then slowly: each cause alone on the built-in soundboard, then all
//! together.

use super::super::impact::tell;
use super::super::{Claim, Progress, ReproduceError, Section, Table};
use super::NAME;
use erard::instrument::{Instrument, InstrumentFields};
use erard_workshop::listen::Shape;
use erard_workshop::validate::{SOUND_SPEED_M_PER_S, heard};

/// Key of the instrument file.
const KEY: usize = 40;
const DURATION_S: f64 = 8.0;

/// What acts: the moving bridge, unisons apart in pitch, strings struck unevenly, bridge modes that move askew, the
/// blow's angle.
type Causes = [bool; 5];

/// Rows: each cause alone on a moving bridge, and all.
const ROWS: [(&str, Causes); 7] = [
    ("none: the bridge is rigid", [false; 5]),
    ("the bridge moves vertically", [true, false, false, false, false]),
    ("and unisons are mistuned", [true, true, false, false, false]),
    ("and strings are struck unevenly", [true, false, true, false, false]),
    ("and the bridge moves askew", [true, false, false, true, false]),
    ("and the blow has an angle", [true, false, false, false, true]),
    ("all of them", [true; 5]),
];

/// Leaves an instrument the causes that act.
fn set(fields: &mut InstrumentFields, [bridge, unisons, shares, askew, angle]: Causes) {
    fields.roles.rigid_bridge = !bridge;
    if !askew {
        fields.bridge_modes.iter_mut().for_each(|mode| mode.horizontal = 0.0);
    }
    let Some(middle) = fields.strings.get(1).cloned() else { return };
    for string in &mut fields.strings {
        if !unisons {
            (string.tension_n, string.bending_n_m2) = (middle.tension_n, middle.bending_n_m2);
        }
        if !shares {
            string.strike_share = 1.0;
        }
        // A string that nothing moves sideways has no second direction.
        string.strike_angle_rad = string.strike_angle_rad.filter(|_| angle).or(askew.then_some(0.0));
    }
}

pub(in crate::subjects) fn section(_: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let wrong = |error: String| ReproduceError::Instrument(error);
    let instrument = super::super::builtin(NAME)?;
    let mut section = Section {
        text: vec![format!(
            "C4 of the built-in instrument with strings, on its soundboard: {SOUND_SPEED_M_PER_S} m/s at the string, pedal down, {DURATION_S} s of the force on the bridge, measured as `erard listen` does. Times are to -10, -20 and -40 dB."
        )],
        ..Section::default()
    };
    let heads = ["cause", "t10, s", "t20, s", "t40, s", "early, dB/s", "late, dB/s", "break, dB", "shape"];
    let mut table = Table::new("C4, each cause alone and all together", &heads);
    let mut shapes = Vec::new();
    for (n, (name, causes)) in ROWS.into_iter().enumerate() {
        tell(progress, n as f64 / ROWS.len() as f64)?;
        let mut variant = instrument.clone();
        variant.edit(|fields| set(fields, causes)).map_err(|error| wrong(error.to_string()))?;
        let note = heard(&variant, KEY, SOUND_SPEED_M_PER_S, DURATION_S, &mut |_| true);
        let note = note.map_err(|error| wrong(error.to_string()))?;
        let seconds = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.2}"));
        let [t10, t20, t40] = note.fall_s.map(seconds);
        let mut cells = vec![name.to_owned(), t10, t20, t40];
        if let Some(decay) = note.decay {
            let is_two = decay.shape == Shape::TwoStages;
            let late = |x: f64| if is_two { format!("{x:.1}") } else { "-".to_owned() };
            cells.push(format!("{:.1}", decay.first_db_per_s()));
            cells.extend([late(decay.late_db_per_s), late(decay.break_db), decay.shape.name().to_owned()]);
            shapes.push(decay.shape);
        }
        table.row(cells);
    }
    section.tables.push(table);
    let is_two = |row: usize| shapes.get(row) == Some(&Shape::TwoStages);
    section.claims.push(Claim::new(
        "G. Weinreich, JASA 62 (1977) 1474",
        "C4 falls in one line on a rigid bridge and where unisons are alike and move in one direction; in two stages where they are mistuned, or where they move in two directions",
        shapes.iter().map(|shape| shape.name()).collect::<Vec<_>>().join(", "),
        shapes.len() == ROWS.len() && [2, 4, 6].into_iter().all(is_two) && ![0, 1, 3, 5].into_iter().any(is_two),
    ));
    Ok(section)
}
