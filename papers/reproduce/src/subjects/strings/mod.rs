//! Strings that throw the hammer back, over the compass and the loudness; two stages of decay over a moving bridge;
//! convergence of an impact, and its energy balance.

pub(super) mod aftersound;
mod books;
mod convergence;
pub(super) mod head;
pub(super) mod residual;

use super::impact::tell;
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::keyboard::{Keyboard, note_name};
use erard::{Action, Input};
use erard_workshop::first_impact::{STEP_S, action_at_rest, first_impact};

/// Keyboard and instrument of this subject.
const NAME: &str = "concert-grand-strings";
/// Keys: A0, C2, C4, C6, C8.
const KEYS: [usize; 5] = [1, 16, 40, 64, 88];
/// Constant forces on the key, N: pp to ff.
const FORCES: [(&str, f64); 5] = [("pp", 0.8), ("p", 2.0), ("mf", 4.0), ("f", 8.0), ("ff", 18.0)];
/// Published contact times at mf, ms: key, text, range (a third about a single number, or the source's own), source. No
/// numbers were found for other levels, for the largest force or for the return over the compass (`validate` has the
/// same rows).
const PUBLISHED: [(usize, &str, [f64; 2], &str); 3] = [
    (1, "about 3.7, bass 4 to 5", [3.0, 5.0], "KTH lectures; A. Chaigne's measurements"),
    (40, "about 2", [1.33, 2.67], "KTH lectures"),
    (88, "about 0.5, C7 under 1", [0.33, 0.67], "KTH lectures; A. Chaigne's measurements"),
];
pub(super) fn section(_: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let wrong = |error: String| ReproduceError::Instrument(error);
    let keyboard = Keyboard::builtin(NAME).map_err(|error| wrong(error.to_string()))?;
    let mut section = Section {
        text: vec![
            "The built-in keyboard with strings under constant forces. Contact is counted from the hammer's first touch to its last within 10 ms, waves that come back and \
             part hammer and string for a moment among it; return is the hammer's speed at the end, and its share of the speed before. Numbers were published for contact at mf; for other marks, for the largest force and for the return none was found."
                .into(),
        ],
        ..Section::default()
    };
    let mut table = Table::new(
        "Impacts over the compass",
        &[
            "note",
            "force, N",
            "hammer, m/s",
            "contact, ms",
            "pulses",
            "peak, N",
            "return, m/s",
            "share",
            "published contact, ms",
            "published peak and return",
        ],
    );
    let mut mf = Vec::new();
    let mut peaks = Vec::new();
    for (n, key) in KEYS.into_iter().enumerate() {
        let instrument = keyboard.key(key).map_err(|error| wrong(error.to_string()))?;
        for (m, (loud, force_n)) in FORCES.into_iter().enumerate() {
            tell(progress, 0.4 * (n * FORCES.len() + m) as f64 / (KEYS.len() * FORCES.len()) as f64)?;
            let mut action = rest(&instrument)?;
            let found = first_impact(&mut action, force_n);
            let cells = match &found {
                Some(b) => vec![
                    format!("{:.2}", b.speed_m_per_s),
                    format!("{:.2}", 1e3 * b.contact_s),
                    b.pulses.to_string(),
                    format!("{:.1}", b.peak_n),
                    format!("{:.2}", b.back_m_per_s),
                    format!("{:.2}", b.back_m_per_s / b.speed_m_per_s),
                ],
                None => vec!["does not sound".into()],
            };
            let cells =
                cells.into_iter().chain(std::iter::repeat_n(String::new(), if found.is_some() { 0 } else { 5 }));
            let judged =
                PUBLISHED.iter().find(|(of, ..)| (*of, "mf") == (key, loud)).map(|(_, says, [least, most], _)| {
                    let holds = found.as_ref().is_some_and(|b| (*least..=*most).contains(&(1e3 * b.contact_s)));
                    format!("{says}: {}", if holds { "met" } else { "missed" })
                });
            let cells = cells.chain([judged.unwrap_or_else(|| "none found".into()), "none found".into()]);
            table.row([note_name(key), format!("{force_n} ({loud})")].into_iter().chain(cells));
            if let (Some(b), "mf") = (&found, loud) {
                mf.push((key, b.contact_s * 1e3));
            }
            if let (Some(b), 40) = (&found, key) {
                peaks.push((b.speed_m_per_s, b.peak_n));
            }
        }
    }
    section.tables.push(table);
    for (key, says, range, source) in PUBLISHED {
        if let Some((_, found)) = mf.iter().find(|(one, _)| *one == key) {
            section.claims.push(Claim::new(
                source,
                format!("contact of {} at mf: {says} ms", note_name(key)),
                format!("{found:.2} ms"),
                (range[0]..=range[1]).contains(found),
            ));
        }
    }
    if let (Some(first), Some(last)) = (peaks.first(), peaks.last()) {
        let exponent = (last.1 / first.1).ln() / (last.0 / first.0).ln();
        section.claims.push(Claim::new(
            "this program",
            "C4: the peak grows with more than the first power of the hammer's speed, so that loud notes are shorter and brighter",
            format!("{:.1} N at {:.2} m/s, {:.0} N at {:.2} m/s: power {exponent:.2}", first.1, first.0, last.1, last.0),
            exponent > 1.0,
        ));
    }
    inharmonicity(&keyboard, &mut section)?;
    bridge(&mut section, progress)?;
    let grand = super::builtin(NAME)?;
    // Partials by themselves, which a bridge that moves would mix.
    let mut rigid = grand.clone();
    rigid.edit(|fields| fields.roles.rigid_bridge = true)?;
    convergence::add(&rigid, &mut section, &mut |share| progress(0.7 + 0.25 * share))?;
    books::add(&grand, &mut section, &mut |share| progress(0.95 + 0.05 * share))?;
    Ok(section)
}

/// Young's measurements of six pianos, from the abstract: 1.2 cents in the second partial of middle C, twice that for
/// every eight semitones above it.
fn inharmonicity(keyboard: &Keyboard, section: &mut Section) -> Result<(), ReproduceError> {
    // Cents are 1200/ln 2 times B n^2/2.
    let per_b = 1200.0 / std::f64::consts::LN_2 * 0.5 * 4.0;
    let mut table = Table::new("Inharmonicity of plain strings", &["note", "B", "B after Young (1952)", "of it"]);
    let mut worst: f64 = 1.0;
    for key in [40, 52, 64, 76, 88] {
        let instrument = keyboard.key(key).map_err(|error| ReproduceError::Instrument(error.to_string()))?;
        let Some(string) = instrument.strings.last() else { continue };
        let (own, young) = (string.inharmonicity(), 1.2 / per_b * f64::exp2((key as f64 - 40.0) / 8.0));
        worst = if (own / young).ln().abs() > worst.ln().abs() { own / young } else { worst };
        table.row([note_name(key), format!("{own:.2e}"), format!("{young:.2e}"), format!("{:.2}", own / young)]);
    }
    section.tables.push(table);
    section.claims.push(Claim::new(
        "R. W. Young, JASA 24 (1952) 267",
        "middle C: 1.2 cents in the second partial, doubled every eight semitones above",
        format!("at most {:.0} % from it, C4 to C8", 100.0 * (worst - 1.0).abs()),
        (0.67..=1.5).contains(&worst),
    ));
    Ok(())
}

fn rest(instrument: &Instrument) -> Result<Action, ReproduceError> {
    action_at_rest(instrument).map_err(|error| ReproduceError::Simulation(error.into()))
}

/// Level of the force on the bridge over 20 ms, dB.
fn level_db(action: &mut Action, input: Input) -> f64 {
    let steps = (20e-3 / STEP_S) as usize;
    let (mut squares, mut sum) = (0.0, 0.0);
    for _ in 0..steps {
        action.step(input);
        let n = action.strings().map_or(0.0, erard::strings::Strings::bridge_n);
        (squares, sum) = (squares + n * n, sum + n);
    }
    let mean = sum / steps as f64;
    10.0 * (squares / steps as f64 - mean * mean).max(1e-30).log10()
}

/// Decay of C4's first second and of its fifth, over a fixed and over a moving bridge.
fn bridge(section: &mut Section, progress: &mut Progress) -> Result<(), ReproduceError> {
    let mut instrument = super::builtin(NAME)?;
    let mut table = Table::new("Decay of C4, held, dB/s", &["bridge", "from 0.3 s to 0.8 s", "from 4.5 s to 5 s"]);
    let mut rates = Vec::new();
    for (n, (name, rigid)) in [("stands still", true), ("moves", false)].into_iter().enumerate() {
        tell(progress, 0.65 + 0.025 * n as f64)?;
        instrument.edit(|fields| fields.roles.rigid_bridge = rigid).expect("numbers alone");
        let mut action = rest(&instrument)?;
        let held = Input::Force(5.0);
        let mut level_after = |steps: usize| {
            for _ in 0..steps {
                action.step(held);
            }
            level_db(&mut action, held)
        };
        let levels = [level_after(6000), level_after(9600), level_after(73_600), level_after(9600)];
        let own = [(levels[0] - levels[1]) / 0.5, (levels[2] - levels[3]) / 0.5];
        table.row([name.to_owned(), format!("{:.1}", own[0]), format!("{:.1}", own[1])]);
        rates.push(own);
    }
    section.tables.push(table);
    section.claims.push(Claim::new(
        "G. Weinreich, JASA 62 (1977) 1474",
        "strings of a note that feel each other through the bridge decay in two stages; without it none is claimed",
        format!(
            "first {:.1} dB/s, then {:.1}; over a bridge that stands still {:.1} and {:.1}",
            rates[1][0], rates[1][1], rates[0][0], rates[0][1]
        ),
        rates[1][0] > 1.3 * rates[1][1] && rates[1][0] > rates[0][0],
    ));
    Ok(())
}
