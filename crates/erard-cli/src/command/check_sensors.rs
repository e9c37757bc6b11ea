//! The report of `erard check` on what `live`, `calibrate` and `play` read: streams and profiles of sensors, laws, MIDI
//! files.

use std::collections::BTreeSet;
use std::io::BufReader;
use std::path::Path;

use erard_live::profile::{Profile, Sensed};
use erard_live::stream::{Fault, Head, Of, Reader, SensorUnit};
use erard_midi::{Law, file};
use erard_piece::Score;
use serde_json::Value;

use super::calibrate::{CONTACT_HEAD, RULER_HEAD, own_speeds, own_table};
use super::checked::checked;
use super::play::{LAW_HEAD, MAX_BYTES};
use crate::failure::Failure;
use crate::inputs::shown;
use crate::law_points::law_points;
use crate::live::feed::lines_of;
use crate::print_line;
use crate::session::Session;
use crate::table::many;

/// A stream or a law, by the first line of a table; `None` for another table.
pub(super) fn table(session: &mut Session, path: &Path, beginning: &str) -> Result<Option<Value>, Failure> {
    let mut lines = beginning.lines().map(|line| line.trim().trim_start_matches('\u{feff}'));
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or_default();
    let name = shown(path);
    Ok(Some(match first {
        RULER_HEAD => {
            own_table(session, path)?;
            law(session, &name, "law of a sensor", "erard calibrate --sensor-law")
        }
        CONTACT_HEAD => {
            own_speeds(session, path)?;
            law(session, &name, "table of contacts", "erard calibrate --contact-table")
        }
        LAW_HEAD => {
            let read = law_points(session, "--law", path, LAW_HEAD, "a law")?;
            Law::table(&read.points).map_err(|fault| Failure::Usage(format!("{name}: {fault}")))?;
            law(session, &name, "law of velocities", "erard play --law")
        }
        head => match (Head::parse(head), Reader::of_rows(head, 1.0)) {
            (Ok(head), _) => stream(session, path, &name, Reader::new(head), None)?,
            (Err(_), Ok(rows)) => stream(session, path, &name, rows, Some(head))?,
            (Err(_), Err(_)) => return Ok(None),
        },
    }))
}

fn law(session: &mut Session, name: &str, kind: &str, option: &str) -> Value {
    print_line!(session, "{name}: a {kind}, for `{option} {name}`");
    checked(kind, name, None, [])
}

/// A stream; of rows without times its header.
fn stream(
    session: &mut Session,
    path: &Path,
    name: &str,
    mut reader: Reader,
    rows: Option<&str>,
) -> Result<Value, Failure> {
    let unread = |error: std::io::Error| Failure::Usage(format!("{name}: cannot be read: {error}"));
    let input = session.inputs.open(path).map_err(unread)?;
    let (mut keys, mut samples, mut has_begun) = (BTreeSet::new(), 0, false);
    let (mut malformed, mut ends_s): (Vec<(usize, Fault)>, Option<[f64; 2]>) = (Vec::new(), None);
    for (index, line) in lines_of(BufReader::new(input)).enumerate() {
        let line = line.map_err(unread)?;
        if !has_begun && rows.is_some_and(|head| line.trim().trim_start_matches('\u{feff}') == head) {
            has_begun = true;
            continue;
        }
        match reader.received(&line) {
            Ok(all) => {
                // The first line that counts is the header.
                has_begun |= reader.take_restart();
                for sample in all.iter().filter(|_| has_begun) {
                    samples += 1;
                    let [from_s, to_s] = ends_s.unwrap_or([sample.time_s; 2]);
                    ends_s = Some([from_s.min(sample.time_s), to_s.max(sample.time_s)]);
                    if let Of::Key(key) | Of::Contact(key, _) | Of::Release(key) = sample.of {
                        keys.insert(key);
                    }
                }
            }
            Err(fault) => malformed.push((index + 1, fault)),
        }
    }
    let what = match reader.quantity() {
        SensorUnit::Millimetres => "travels of keys, mm",
        SensorUnit::Newtons => "forces on keys, N",
        SensorUnit::Raw => "raw readings",
        SensorUnit::Pressure => "polyphonic pressures",
        SensorUnit::Contacts => "edges of contacts",
    };
    let rate = if rows.is_some() { " --rate HZ" } else { "" };
    print_line!(session, "{name}: a stream of sensors, {what}, for `erard live {name}{rate}`");
    print_line!(session);
    // To a microsecond.
    let [from_s, to_s] = ends_s.unwrap_or_default().map(|s| (1e6 * s).round() / 1e6);
    let span = if rows.is_some() { "without times".to_owned() } else { format!("{from_s} to {to_s} s") };
    print_line!(session, "  {} of {}, {span}", many(samples, "sample"), many(keys.len(), "key"));
    if let Some((line, fault)) = malformed.first() {
        print_line!(session, "  {} lines are no samples; the first, line {line}: {fault}", malformed.len());
    }
    let counts = [("samples", samples), ("keys", keys.len()), ("malformed_lines", malformed.len())];
    Ok(checked("stream of sensors", name, None, counts))
}

/// A profile of sensors.
pub(super) fn profile(session: &mut Session, name: &str, text: &str) -> Result<Value, Failure> {
    let profile = Profile::parse(text).map_err(|fault| Failure::Usage(format!("{name}: {fault}")))?;
    let keys = profile.keys.len();
    let (what, count) = match &profile.sensed {
        Sensed::Contacts(law) => (format!("{} contacts a key", law.count), ("contacts", law.count)),
        Sensed::Hammers(None) => (format!("{}, without a sensor of releases", many(keys, "hammer")), ("keys", keys)),
        Sensed::Hammers(Some((_, second))) => {
            (format!("{}, {} with a sensor of releases", many(keys, "hammer"), second.len()), ("keys", keys))
        }
        Sensed::Keys => (format!("{}, {} mm", many(keys, "key"), 1e3 * profile.travel_m), ("keys", keys)),
    };
    print_line!(session, "{name}: a profile of sensors, for `erard live --calibration {name}`");
    print_line!(session);
    print_line!(session, "  {what}");
    Ok(checked("profile of sensors", name, None, [count]))
}

/// A MIDI file.
pub(super) fn piece(session: &mut Session, path: &Path) -> Result<Value, Failure> {
    let name = shown(path);
    let wrong = |what: String| Failure::Usage(format!("{name}: {what}"));
    let bytes = session.inputs.beginning(path, MAX_BYTES + 1);
    let bytes = bytes.map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let piece = file::read(&bytes).map_err(|error| wrong(error.to_string()))?;
    let score = Score::of(&piece, &Law::GOEBL);
    let keys: BTreeSet<usize> = piece.notes.iter().map(|note| note.key).collect();
    print_line!(session, "{name}: a MIDI file, for `erard play {name}`");
    print_line!(session);
    print_line!(
        session,
        "  {} on {}, {} of pedals, {:.1} s",
        many(piece.notes.len(), "note"),
        many(keys.len(), "key"),
        many(piece.pedals.len(), "position"),
        piece.duration_s()
    );
    for remark in &score.remarks {
        print_line!(session, "  {remark}");
    }
    let counts = [("notes", piece.notes.len()), ("keys", keys.len()), ("pedals", piece.pedals.len())];
    let mut checked = checked("MIDI file", &name, None, counts);
    checked["remarks"] = score.remarks.clone().into();
    Ok(checked)
}
