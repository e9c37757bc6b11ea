//! A data set in words and as JSON.

use erard::keyboard::note_name;
use erard_piece::scan::{Case, Strike, Truth};
use serde_json::{Value, json};

use super::{Scanned, percent, profile_name, scan_name};
use crate::table::{Table, many};

/// `scan.json`: what the files hold, and where the numbers come from.
pub(crate) fn json(scanned: &Scanned<'_>, readings: &[usize]) -> Value {
    let scans: Vec<Value> = scanned
        .sensors
        .iter()
        .zip(readings)
        .map(|(sensor, readings)| {
            json!({
                "file": scan_name(sensor),
                "profile": profile_name(sensor),
                "bits": sensor.bits,
                "rate_hz": sensor.rate_hz,
                "noise_percent": percent(sensor),
                "readings": readings,
            })
        })
        .collect();
    let keys: Vec<Value> = scanned
        .played
        .iter()
        .map(|key| {
            let instrument = &scanned.instruments[key - 1];
            json!({
                "key": key,
                "name": note_name(*key),
                "travel_mm": 1e3 * scanned.travels_m[key - 1],
                "digest": format!("{:016x}", instrument.digest()),
            })
        })
        .collect();
    let cases: Vec<Value> = counted(scanned)
        .into_iter()
        .map(|(case, windows, strikes, again)| {
            json!({ "case": case, "windows": windows, "impact_count": strikes, "again": again })
        })
        .collect();
    let (place, one) =
        if scanned.are_hammers { ("at the shanks", "hammer") } else { ("under the keys' fronts", "key") };
    let [files, profiles] = if scanned.contacts.is_empty() {
        [
            format!(
                "scan-*.csv: readings of sensors {place}, as `erard live` reads them; a {one} is sent while it is off its \
                 rest, and 30 ms before and after"
            ),
            format!("profile-*.toml: the readings at the two stops of each {one}, for `erard live --calibration`"),
        ]
    } else {
        [
            "scan-*.csv: edges of contacts under the keys' fronts, as `erard live` reads them".to_owned(),
            "profile-*.toml: hammer speeds by the time between contacts, of the file's own grand, for `erard live \
             --calibration`"
                .to_owned(),
        ]
    };
    json!({
        "format": "erard-scan/1",
        "about": [
            &files,
            &profiles,
            "truth.csv: strikes of hammers on strings, from the simulated actions; `again` 1: the hammer bounced",
            "windows.csv: what was played when; a window without strikes is one in which no note belongs",
        ],
        "piece": scanned.piece,
        "shift_s": scanned.score.map(|score| score.shift_s),
        "keyboard": scanned.asked,
        "keyboard_name": scanned.keyboard.name,
        "sample": scanned.sample,
        "technicians_scatter": scanned.has_scatter,
        "seed": scanned.seed,
        "truth": "truth.csv",
        "windows": "windows.csv",
        "scans": scans,
        "keys": keys,
        "cases": cases,
    })
}

/// Of each case, in the order in which they are played: its windows, strikes, and those that are bounces.
fn counted(scanned: &Scanned<'_>) -> Vec<(&'static str, usize, usize, usize)> {
    let names = std::iter::once(PIECE).chain(Case::ALL.map(Case::name));
    let of = |case: &'static str| {
        let windows = &scanned.truth.windows;
        let own: Vec<&Strike> =
            scanned.truth.strikes.iter().filter(|strike| windows[strike.window].case == case).collect();
        let again = own.iter().filter(|strike| strike.again).count();
        (case, windows.iter().filter(|window| window.case == case).count(), own.len() - again, again)
    };
    names.map(of).filter(|(_, windows, ..)| *windows > 0).collect()
}

/// The case of the windows of a piece.
const PIECE: &str = "piece";
/// Sensors of the first lines: more of them are counted.
const FIRST_SENSORS: usize = 3;

/// What was played on which keyboard.
pub(crate) fn heading(scanned: &Scanned<'_>) -> String {
    let piece = scanned.piece.as_ref().map_or(String::new(), |piece| format!("{piece} on "));
    let (keys, sensors) = (many(scanned.played.len(), "key"), many(scanned.sensors.len(), "sensor"));
    format!("{piece}{} - {keys}, {sensors}", scanned.keyboard.name)
}

/// The first lines: the truth, and what each sensor sent.
pub(crate) fn headlines(scanned: &Scanned<'_>, readings: &[usize]) -> Vec<String> {
    let Truth { windows, strikes } = scanned.truth;
    let cases: Vec<usize> = (0..windows.len()).filter(|index| windows[*index].case != PIECE).collect();
    let silent = cases.iter().filter(|index| strikes.iter().all(|strike| strike.window != **index)).count();
    let bounces = strikes.iter().filter(|strike| strike.again).count();
    let notes = scanned.score.map_or(0, |score| score.notes.len());
    let played = [(notes, "note"), (cases.len(), "motion")];
    let played: Vec<String> =
        played.iter().filter(|(count, _)| *count > 0).map(|(count, what)| many(*count, what)).collect();
    let mut lines = vec![
        format!("Played: {}.", played.join(" and ")),
        format!(
            "Truth: {} of hammers on strings, and {} after them.",
            many(strikes.len() - bounces, "impact"),
            many(bounces, "bounce")
        ),
    ];
    if !cases.is_empty() {
        lines.push(format!("Motions without an impact: {silent}. A note found in one of them is false."));
    }
    let what = if scanned.contacts.is_empty() { "reading" } else { "edge" };
    let sent = scanned.sensors.iter().zip(readings).take(FIRST_SENSORS);
    lines.extend(sent.map(|(sensor, count)| format!("{}: {}", scan_name(sensor), many(*count, what))));
    if scanned.sensors.len() > FIRST_SENSORS {
        lines.push(format!("and {} in scan.json", many(scanned.sensors.len() - FIRST_SENSORS, "sensor")));
    }
    lines
}

/// A row for each kind of motion.
pub(crate) fn text(scanned: &Scanned<'_>) -> String {
    let rows: Vec<Vec<String>> = counted(scanned)
        .into_iter()
        .map(|(case, windows, strikes, again)| {
            vec![case.to_owned(), windows.to_string(), strikes.to_string(), again.to_string()]
        })
        .collect();
    Table::of(["case", "played", "impacts", "bounces"], rows).to_string()
}
