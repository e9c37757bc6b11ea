//! Contact time of hammer and string: compared with published times, and what determines it.

use super::impact::tell;
use super::strings::head;
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::{Instrument, InstrumentFields};
use erard::keyboard::{Keyboard, note_name};
use erard::{Action, Input};

/// Keyboard of this subject.
const NAME: &str = "concert-grand-strings";
const MIDDLE: usize = 40;
/// Keys: A0, C1, C4, C7, C8.
const KEYS: [usize; 5] = [1, 4, MIDDLE, 76, 88];
/// Hammer speeds of pp, mf, ff in `validation/published.toml`, m/s.
const SPEEDS_M_PER_S: [f64; 3] = [0.5, 1.99, 5.0];
/// Time after the first touch over which a contact is recorded, s.
const FOLLOWED_S: f64 = 10e-3;
/// Share of the peak force above which contact is also counted.
const LEVEL: f64 = 0.1;
/// Step of a head alone, s.
const HEAD_STEP_S: f64 = 2e-6;
/// Published contact times: key, text, range, ms. The constant after it is the ratio of ff to mf.
const PUBLISHED_MS: [(usize, &str, [f64; 2]); 5] = [
    (1, "3.7 (A0's felt was chosen by it)", [3.33, 4.07]),
    (4, "4 to 5", [4.0, 5.0]),
    (MIDDLE, "about 2", [1.33, 2.67]),
    (76, "under 1", [0.0, 1.0]),
    (88, "about 0.5", [0.33, 0.67]),
];
const FF_OVER_MF: [f64; 2] = [0.75, 0.88];

fn wrong(error: impl ToString) -> ReproduceError {
    ReproduceError::Instrument(error.to_string())
}

/// Contact times, s: from the first touch to the last within 10 ms, and while the force is above a tenth of its peak.
#[derive(Debug, Clone, Copy)]
struct Contact {
    touch_s: f64,
    above_s: f64,
}

impl Contact {
    /// Computes them from the ends of steps and the forces in them.
    fn of(series: &[[f64; 2]]) -> Option<Contact> {
        let peak_n = series.iter().fold(0.0, |most: f64, [_, n]| most.max(*n));
        let lasts = |least_n: f64| {
            let first = series.iter().position(|[_, n]| *n > least_n)?;
            let soon = |row: &[f64; 2]| row[0] < series[first][0] + FOLLOWED_S;
            let last = series.iter().rposition(|row| row[1] > least_n && soon(row))?;
            // A step's force acts from the end of the one before.
            Some(series[last][0] - series[first.saturating_sub(1)][0])
        };
        Some(Contact { touch_s: lasts(0.0)?, above_s: lasts(LEVEL * peak_n)? })
    }
}

/// Throws the hammer of a key at rest, its dampers up, to reach the string at about this speed. Returns the actual
/// speed and the contact.
fn thrown(instrument: &Instrument, speed_m_per_s: f64) -> Result<(f64, Contact), ReproduceError> {
    let mut action = Action::new(instrument).map_err(wrong)?;
    if action.strings().is_some_and(|strings| strings.pedal_m().is_some()) {
        action.set_pedal(7e-3);
        action.settle(instrument, Input::Free, &mut |_| true).map_err(wrong)?;
    }
    // Compensates roughly for gravity and friction on the way up; the head turns about the shank's pin.
    let rad_per_s = (1.04 * speed_m_per_s * speed_m_per_s + 1.22).sqrt() / 0.1386;
    let mut body = instrument.roles.hammer;
    while let Some(one) = body {
        action.add_velocity(one, rad_per_s).map_err(wrong)?;
        body = instrument.bodies[one].parent;
    }
    let (mut series, mut struck) = (Vec::new(), None);
    for _ in 0..5000 {
        action.mechanism_mut().step_in_parts(&mut |_, _, _| moreau::SiteInput::Free, &mut |m, _| {
            let now = m.readout();
            struck = struck.or(now.output.impact);
            series.push([now.now_s, now.output.zone_n]);
        });
        let now_s = action.time_s();
        if struck.is_some_and(|impact: erard::Impact| now_s > impact.time_s + FOLLOWED_S) {
            break;
        }
    }
    let contact = Contact::of(&series).ok_or_else(|| wrong("the hammer does not touch the string"))?;
    Ok((struck.map_or(f64::NAN, |impact| impact.hammer_speed_m_per_s), contact))
}

/// A head alone before C4's strings.
fn alone(head: &Instrument, speed_m_per_s: f64) -> Result<Contact, ReproduceError> {
    let mut m = head::thrown(head, HEAD_STEP_S, speed_m_per_s)?;
    let mut series = vec![[0.0, 0.0]];
    for n in 1..=(FOLLOWED_S / HEAD_STEP_S) as usize {
        m.step(&moreau::SiteInput::Free);
        series.push([n as f64 * HEAD_STEP_S, m.normal_force(0)]);
    }
    Contact::of(&series).ok_or_else(|| wrong("the head does not touch the string"))
}

pub(super) fn section(_: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let keyboard = Keyboard::builtin(NAME).map_err(|error| wrong(error.to_string()))?;
    let key = |key: usize| keyboard.key(key).map_err(wrong);
    let mut section = Section {
        text: vec![
            "Hammers of the keyboard with strings, thrown at their strings. A contact lasts from the first touch to the last within 10 ms, as an electrical contact sees it; beside it the time for \
             which the force is above a tenth of its peak. Published: A. Askenfelt and E. Jansson (KTH lectures) for A0, C4, C8 at mf and for C4's shortening from mf to ff, A. Chaigne for C1 and C7."
                .into(),
        ],
        ..Section::default()
    };
    let mut table = Table::new(
        "Contact of hammer and string, ms",
        &["note", "pp", "mf", "ff", "published, mf", "pp / mf", "ff / mf", "ff / mf above a tenth"],
    );
    let mut middle = 0.0;
    for (n, number) in KEYS.into_iter().enumerate() {
        tell(progress, 0.4 * n as f64 / KEYS.len() as f64)?;
        let instrument = key(number)?;
        let found = SPEEDS_M_PER_S.map(|speed_m_per_s| thrown(&instrument, speed_m_per_s));
        let [pp, mf, ff] = found;
        let [pp, mf, ff] = [pp?.1, mf?.1, ff?.1];
        let (_, says, range) = PUBLISHED_MS.into_iter().find(|(of, ..)| *of == number).unwrap_or((0, "", [0.0; 2]));
        let met = (range[0]..=range[1]).contains(&(1e3 * mf.touch_s));
        table.row([
            note_name(number),
            format!("{:.2}", 1e3 * pp.touch_s),
            format!("{:.2}", 1e3 * mf.touch_s),
            format!("{:.2}", 1e3 * ff.touch_s),
            format!("{says}: {}", if met { "met" } else { "missed" }),
            format!("{:.2}", pp.touch_s / mf.touch_s),
            format!("{:.2}", ff.touch_s / mf.touch_s),
            format!("{:.2}", ff.above_s / mf.above_s),
        ]);
        if number == MIDDLE {
            middle = ff.touch_s / mf.touch_s;
        }
    }
    section.tables.push(table);
    section.claims.push(Claim::new(
        "KTH lectures",
        format!("C4's contact at ff is {} to {} of that at mf", FF_OVER_MF[0], FF_OVER_MF[1]),
        format!("{middle:.2}"),
        (FF_OVER_MF[0]..=FF_OVER_MF[1]).contains(&middle),
    ));
    variants(&key(MIDDLE)?, &mut section, &mut |share| progress(0.4 + 0.3 * share))?;
    felts_of_a0(&key(1)?, &mut section, &mut |share| progress(0.7 + 0.3 * share))?;
    Ok(section)
}

/// A change of the head before C4's strings.
type Change = (&'static str, fn(&mut InstrumentFields));

/// Changes with a possible effect on C4's contact.
const CHANGES: [Change; 12] = [
    ("as in the file", |_| {}),
    ("felt half as stiff", |head| head.zones[0].felt.stiffness *= 0.5),
    ("felt four times as stiff", |head| head.zones[0].felt.stiffness *= 4.0),
    // Same stiffness at 0.4 mm.
    ("exponent 3.5", |head| {
        head.zones[0].felt.stiffness *= 0.4e-3_f64.powf(2.5 - 3.5);
        head.zones[0].felt.exponent = 3.5;
    }),
    ("felt four times as lossy", |head| {
        let loss = head.zones[0].felt.loss.viscous(1.0, 0.0);
        head.zones[0].felt.loss = moreau::Loss::quadratic(4.0 * loss);
    }),
    ("head of 8 g", |head| head.bodies[0].inertia_kg_m2 = 8e-3),
    ("head of 7 g", |head| head.bodies[0].inertia_kg_m2 = 7e-3),
    ("head of 6 g", |head| head.bodies[0].inertia_kg_m2 = 6e-3),
    ("struck at 0.08 of its length", |head| head.strings.iter_mut().for_each(|one| one.strike_m = 0.08 * one.length_m)),
    ("struck at 0.16", |head| head.strings.iter_mut().for_each(|one| one.strike_m = 0.16 * one.length_m)),
    ("struck at 0.23", |head| head.strings.iter_mut().for_each(|one| one.strike_m = 0.23 * one.length_m)),
    ("strings that stand still", |head| head.roles.rigid_string = true),
];

fn variants(c4: &Instrument, section: &mut Section, progress: &mut Progress) -> Result<(), ReproduceError> {
    let mut table = Table::new(
        "A head alone at C4's strings: what decides the contact",
        &["variant", "pp, ms", "mf, ms", "ff, ms", "ff / mf"],
    );
    let (mut own, mut still) = (0.0, 0.0);
    for (n, (name, change)) in CHANGES.into_iter().enumerate() {
        tell(progress, n as f64 / CHANGES.len() as f64)?;
        let mut head = head::before(c4)?;
        head.edit(change)?;
        let mut found = [0.0; 3];
        for (found, speed_m_per_s) in found.iter_mut().zip(SPEEDS_M_PER_S) {
            *found = alone(&head, speed_m_per_s)?.touch_s;
        }
        let ratio = found[2] / found[1];
        (own, still) = (if n == 0 { ratio } else { own }, ratio);
        table.row(
            [name.to_owned()]
                .into_iter()
                .chain(found.map(|s| format!("{:.2}", 1e3 * s)))
                .chain([format!("{ratio:.2}")]),
        );
    }
    section.tables.push(table);
    let speeds = SPEEDS_M_PER_S[2] / SPEEDS_M_PER_S[1];
    let closed = speeds.powf(-(2.5 - 1.0) / (2.5 + 1.0));
    section.claims.push(Claim::new(
        "this program",
        "on a wall the contact would shorten as v^(-(p - 1)/(p + 1)), to 0.67 from mf to ff; on strings it does so much less, because the waves that come back from the string's near end part hammer and string, and their time does not depend on loudness",
        format!("{still:.3} on strings that stand still, {closed:.3} in closed form without losses; {own:.2} on strings"),
        (still / closed - 1.0).abs() < 0.02 && own > 1.2 * still,
    ));
    Ok(())
}

/// The felts that A0 and C1 would need.
fn felts_of_a0(a0: &Instrument, section: &mut Section, progress: &mut Progress) -> Result<(), ReproduceError> {
    let zone = a0.roles.string.ok_or_else(|| wrong("there is no string"))?;
    let mut table = Table::new("A0's contact at mf over its felt's stiffness", &["stiffness", "contact, ms"]);
    let mut points = Vec::new();
    for (n, factor) in [0.5, 0.7, 1.0, 1.4, 2.0].into_iter().enumerate() {
        tell(progress, n as f64 / 5.0)?;
        let mut softer = a0.clone();
        softer.edit(|fields| fields.zones[zone].felt.stiffness *= factor)?;
        let (_, contact) = thrown(&softer, SPEEDS_M_PER_S[1])?;
        table.row([format!("x {factor}"), format!("{:.2}", 1e3 * contact.touch_s)]);
        points.push((factor, contact.touch_s));
    }
    section.tables.push(table);
    let power = (points[4].1 / points[0].1).ln() / (points[4].0 / points[0].0).ln();
    section.claims.push(Claim::new(
        "this program",
        "in the bass the felt decides: the contact goes with a power of its stiffness near that on a wall, -1/(p + 1) = -0.31",
        format!("power {power:.2}"),
        (-0.45..=-0.2).contains(&power),
    ));
    Ok(())
}
