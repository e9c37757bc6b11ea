//! What makes a note fall fast and then slowly: each cause alone, then all together, on one string and on three.

use super::super::impact::tell;
use super::super::{Claim, Progress, ReproduceError, Section, Table};
use super::NAME;
use erard::instrument::{Instrument, InstrumentFields};
use erard::keyboard::{Keyboard, note_name};
use erard_workshop::listen::Shape;
use erard_workshop::validate::{SOUND_SPEED_M_PER_S as SPEED_M_PER_S, heard};

/// Keys: a single string, and three.
const KEYS: [usize; 2] = [4, 40];
const DURATION_S: f64 = 6.0;

/// What acts: the moving bridge, unisons apart in pitch, strings struck unevenly, bridge modes that move askew, the
/// blow's angle.
type Causes = [bool; 5];

/// Rows: each cause alone on a moving bridge, and all.
const ROWS: [(&str, Causes); 7] = [
    ("none: the bridge is rigid", [false; 5]),
    ("the bridge moves, vertically", [true, false, false, false, false]),
    ("and unisons are mistuned", [true, true, false, false, false]),
    ("and strings are struck unevenly", [true, false, true, false, false]),
    ("and the bridge moves askew", [true, false, false, true, false]),
    ("and the blow has an angle", [true, false, false, false, true]),
    ("all of them", [true; 5]),
];

/// Takes the causes that do not act out of an instrument.
fn reduce(fields: &mut InstrumentFields, [bridge, unisons, shares, askew, angle]: Causes) {
    fields.roles.rigid_bridge = !bridge;
    let count = fields.strings.len() as f64;
    let mean_n = fields.strings.iter().map(|string| string.tension_n).sum::<f64>() / count;
    for string in &mut fields.strings {
        if !unisons {
            string.bending_n_m2 *= mean_n / string.tension_n;
            string.tension_n = mean_n;
        }
        if !shares {
            string.strike_share = 1.0;
        }
        // A string that nothing moves sideways stays in its plane: its second direction is left out.
        string.strike_angle_rad = match string.strike_angle_rad {
            Some(own) if angle => Some(own),
            Some(_) if askew => Some(0.0),
            _ => None,
        };
    }
    if !askew {
        fields.bridge_modes.iter_mut().for_each(|mode| mode.horizontal = 0.0);
    }
}

pub(in crate::subjects) fn section(_: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let wrong = |error: String| ReproduceError::Instrument(error);
    let keyboard = Keyboard::builtin(NAME).map_err(|error| wrong(error.to_string()))?;
    let mut section = Section {
        text: vec![format!(
            "Notes of the built-in keyboard with strings, {SPEED_M_PER_S} m/s at the string, pedal down, {DURATION_S} s of the force on the bridge, measured as `erard listen` does. Times are to -10, -20 and -40 dB."
        )],
        ..Section::default()
    };
    let heads = ["cause", "t10, s", "t20, s", "t40, s", "early, dB/s", "late, dB/s", "break, dB", "shape"];
    for (n, key) in KEYS.into_iter().enumerate() {
        let instrument = keyboard.key(key).map_err(|error| wrong(error.to_string()))?;
        let mut table = Table::new(format!("{}, {} string(s)", note_name(key), instrument.strings.len()), &heads);
        let mut shapes = Vec::new();
        for (m, (name, causes)) in ROWS.into_iter().enumerate() {
            tell(progress, (n * ROWS.len() + m) as f64 / (KEYS.len() * ROWS.len()) as f64)?;
            // One string is neither in unison nor struck unevenly.
            if instrument.strings.len() == 1 && (causes[1] != causes[2]) {
                continue;
            }
            let mut variant = instrument.clone();
            variant.edit(|fields| reduce(fields, causes)).map_err(|error| wrong(error.to_string()))?;
            let note =
                heard(&variant, key, SPEED_M_PER_S, DURATION_S, &mut |_| true).map_err(|e| wrong(e.to_string()))?;
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
        let is_two = |row: Option<&Shape>| row == Some(&Shape::TwoStages);
        section.claims.push(Claim::new(
            "G. Weinreich, JASA 62 (1977) 1474",
            format!("{}: one line on a rigid bridge, two stages with all causes", note_name(key)),
            shapes.iter().map(|shape| shape.name()).collect::<Vec<_>>().join(", "),
            shapes.first().is_some_and(|shape| *shape != Shape::TwoStages) && is_two(shapes.last()),
        ));
    }
    Ok(section)
}
