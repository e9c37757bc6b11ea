//! Dampers over the compass: weight on each string, time to silence it, and travel of the pedal's rail between a damped
//! string and a free one.

use std::f64::consts::PI;

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::{Instrument, PianoString};
use erard::keyboard::{Keyboard, note_name};
use erard::player::Snapshot;
use erard::strings::Strings;
use erard::{Action, Input};

/// Keyboard and instrument of this subject.
const NAME: &str = "concert-grand-strings";
/// Key of the instrument file.
const MIDDLE: usize = 40;
/// Keys: neighbours with different numbers of strings, up to the last damper.
const KEYS: [usize; 9] = [1, 8, 9, 20, 21, 30, MIDDLE, 54, 68];
/// Keys for half-pedalling, and lifts of the rail, mm.
const HALF_KEYS: [usize; 3] = [1, MIDDLE, 68];
const LIFTS_MM: [f64; 15] = [0.0, 1.8, 1.9, 2.0, 2.04, 2.1, 2.2, 2.3, 2.4, 2.5, 2.6, 2.7, 2.8, 3.0, 4.0];
/// Earlier felt of all strings: N/m^2 and N s/m^3.
const STIFF: [f64; 2] = [6.667e6, 2.667e7];
/// Lift of the rail that takes the dampers off the strings, m.
const UP_M: f64 = 7e-3;
/// Force of the stroke, N; times at which the key is released and the rail goes down, s.
const FORCE_N: f64 = 5.0;
const RELEASED_S: f64 = 0.25;
const LOWERED_S: f64 = 0.35;
/// Longest recordings of a note, s.
const MOST_S: [f64; 2] = [2.5, 0.8];
/// Highest partials counted, Hz.
const UP_TO_HZ: f64 = 5e3;
/// Decay at which a tone is gone, dB.
const GONE_DB: f64 = 60.0;
/// Partials that begin within this of the strongest are compared, dB.
const HEARD_DB: f64 = 40.0;
/// Usable travel of the rail: T60 above this multiple of the damped one, and below this share of the free one.
const USABLE: [f64; 2] = [2.0, 0.5];
/// T60 of bass strings from general experience, s.
const BASS_S: [f64; 2] = [0.5, 1.5];

fn wrong(error: impl ToString) -> ReproduceError {
    ReproduceError::Instrument(error.to_string())
}

/// A note with raised dampers, just before they fall.
struct Note {
    action: Action,
    sounding: Snapshot,
}

/// Decay of a note: T60 of all partials and of the first alone, s; the number of the longest partial among those that
/// began within 40 dB of the strongest; and whether it was gone in the recorded time, else T60 is extrapolated.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Decay {
    all_s: f64,
    first_s: f64,
    longest: usize,
    gone: bool,
}

impl Note {
    fn new(instrument: &Instrument) -> Result<Self, ReproduceError> {
        let mut action = Action::new(instrument).map_err(wrong)?;
        action.set_pedal(UP_M);
        let steps = |s: f64| (s / instrument.usual_step_s()).round() as u32;
        for _ in 0..steps(RELEASED_S) {
            action.step(Input::Force(FORCE_N));
        }
        for _ in steps(RELEASED_S)..steps(LOWERED_S) {
            action.step(Input::Free);
        }
        let sounding = action.save();
        Ok(Note { action, sounding })
    }

    /// Returns the decay once the rail is at a lift: from the dampers' first touch, or from the rail's arrival.
    fn decay(&mut self, instrument: &Instrument, lift_m: f64, most_s: f64) -> Result<Decay, ReproduceError> {
        let action = &mut self.action;
        action.restore(&self.sounding).map_err(wrong)?;
        action.set_pedal(lift_m);
        let step_s = instrument.usual_step_s();
        let waits = ((UP_M - lift_m) / erard::strings::PEDAL_M_PER_S / step_s).ceil() as u32;
        for _ in 0..waits {
            action.step(Input::Free);
            if action.strings().is_some_and(|strings| strings.damper_n().any(|force_n| force_n > 0.0)) {
                break;
            }
        }
        let strings = action.strings().ok_or_else(|| wrong("there are no strings"))?;
        let partials = partials(strings);
        let window_s = 1.0 / strings.strings()[0].partial_hz(1);
        let steps = (window_s / step_s).ceil() as u32;
        // Levels of all partials, and of each number.
        let most = partials.iter().map(|partial| partial.n as usize).max().unwrap_or(0);
        let mut levels: Vec<Vec<f64>> = vec![Vec::new(); most + 1];
        while levels[0].len() as f64 * window_s < most_s {
            let mut sums = vec![0.0; most + 1];
            for _ in 0..steps {
                action.step(Input::Free);
                for partial in &partials {
                    let own = action.strings().map_or(0.0, |strings| partial.squared_n2(strings));
                    sums[0] += own;
                    sums[partial.n as usize] += own;
                }
            }
            for (level, sum) in levels.iter_mut().zip(sums) {
                level.push(10.0 * f64::max(sum, 1e-300).log10());
            }
            let [first, .., last] = levels[0][..] else { continue };
            if last < first - GONE_DB - 20.0 {
                break;
            }
        }
        let (all_s, gone) = t60_s(&levels[0], window_s);
        let heard = levels[1..].iter().map(|level| level[0]).fold(f64::NEG_INFINITY, f64::max) - HEARD_DB;
        let lasts = |n: &usize| t60_s(&levels[*n], window_s).0;
        let longest = (1..=most).filter(|n| levels[*n][0] > heard).max_by(|a, b| lasts(a).total_cmp(&lasts(b)));
        Ok(Decay { all_s, first_s: lasts(&1), longest: longest.unwrap_or(0), gone })
    }
}

/// A string's partial.
struct Partial {
    string: usize,
    n: u32,
    /// Force on the bridge per velocity, N s/m.
    per_m_per_s: f64,
}

impl Partial {
    /// Squared force on the bridge, N^2, by its velocity, so that its rest position has no effect.
    fn squared_n2(&self, strings: &Strings) -> f64 {
        let [_, v] = strings.partial(self.string, self.n).unwrap_or_default();
        (self.per_m_per_s * v) * (self.per_m_per_s * v)
    }
}

/// Returns all strings' partials up to 5 kHz.
fn partials(strings: &Strings) -> Vec<Partial> {
    let of = |(index, string): (usize, &PianoString)| {
        let string = string.clone();
        (1..=string.partials_below(UP_TO_HZ).max(1)).map(move |n| {
            let order = f64::from(n);
            let per_m =
                string.tension_n * (1.0 + string.inharmonicity() * order * order) * order * PI / string.length_m;
            Partial { string: index, n, per_m_per_s: per_m / (2.0 * PI * string.partial_hz(n)) }
        })
    };
    strings.strings().iter().enumerate().flat_map(of).collect()
}

/// Time after which levels, each over a window of one period, stay 60 dB below the first one, s, and whether they do;
/// else extrapolated.
fn t60_s(levels: &[f64], window_s: f64) -> (f64, bool) {
    let gone = levels[0] - GONE_DB;
    let above = levels.iter().rposition(|db| *db > gone).unwrap_or(0);
    if let Some(below) = levels.get(above + 1) {
        let share = (levels[above] - gone) / (levels[above] - below);
        return ((above as f64 + share) * window_s, true);
    }
    let fell = levels[0] - levels[above];
    (GONE_DB * above as f64 * window_s / fell.max(1e-3), false)
}

/// The same key with another's damper: its weight, felts and their length, its lever hanging alike.
fn with_damper_of(own: &Instrument, other: &Instrument) -> Instrument {
    let mut changed = own.clone();
    if let Some(damper) = own.bodies.iter().position(|body| body.name == "damper") {
        changed.edit(|fields| fields.bodies[damper] = other.bodies[damper].clone()).expect("numbers alone");
    }
    let Some(given) = other.strings.iter().find_map(|string| string.damper) else { return changed };
    changed
        .edit(|fields| {
            for string in &mut fields.strings {
                let Some(damper) = &mut string.damper else { continue };
                damper.length_m = given.length_m;
                fields.zones[damper.zone].felt = other.zones[given.zone].felt;
                fields.zones[damper.zone].curve = other.zones[given.zone].curve;
            }
        })
        .expect("numbers alone");
    changed
}

/// Damper on a string at rest: force, N, compression of its felt, m, and its dashpot, N s/m.
fn lying(instrument: &Instrument) -> Result<[f64; 3], ReproduceError> {
    let action = Action::new(instrument).map_err(wrong)?;
    let found = action.strings().and_then(|strings| strings.damper_n().next());
    let damper = instrument.strings.iter().find_map(|string| string.damper);
    let (Some(force_n), Some(damper)) = (found, damper) else { return Err(wrong("there is no damper")) };
    let felt = &instrument.zones[damper.zone].felt;
    let pressed_m = (force_n / felt.stiffness).powf(1.0 / felt.exponent);
    Ok([force_n, pressed_m, felt.loss.viscous(pressed_m, force_n)])
}

pub(super) fn section(_: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let keyboard = Keyboard::builtin(NAME).map_err(|error| wrong(error.to_string()))?;
    // What dampers do to strings that end on a bridge that stands still.
    let key = |key: usize| -> Result<Instrument, ReproduceError> {
        let mut instrument = keyboard.key(key).map_err(wrong)?;
        instrument.edit(|fields| fields.roles.rigid_bridge = true)?;
        Ok(instrument)
    };
    let mut section = Section {
        text: vec![format!(
            "Notes of {FORCE_N} N with the pedal down, on a bridge that stands still; the key is let go, then the pedal, and from the dampers' first touch the force of all partials below 5 kHz on the bridge is \
             followed (by the velocity of each, over one period of the first after the other). T60 is when it stays 60 dB below what it was; the partial that lasts longest has a node near the felt's middle. The felts, their weights and their lengths are estimates: no \
             measurement of a damper's felt and no published table of decay under dampers was found. In general experience a bass string is silent 0.5 to 1.5 s after its key is let go."
        )],
        ..Section::default()
    };
    over_the_compass(&key, &mut section, &mut |share| progress(0.5 * share))?;
    half_pedal(&key, &mut section, &mut |share| progress(0.5 + 0.5 * share))?;
    Ok(section)
}

fn over_the_compass(
    key: &dyn Fn(usize) -> Result<Instrument, ReproduceError>,
    section: &mut Section,
    progress: &mut Progress,
) -> Result<(), ReproduceError> {
    let middle = key(MIDDLE)?;
    let mut table = Table::new(
        "Notes under their dampers",
        &[
            "note",
            "strings",
            "felt, mm",
            "on each, mN",
            "pressed, mm",
            "c / Z",
            "T60, s",
            "1st partial, s",
            "longest",
            "with C4's, s",
        ],
    );
    let mut found = Vec::new();
    for (n, number) in KEYS.into_iter().enumerate() {
        tell(progress, n as f64 / KEYS.len() as f64)?;
        let instrument = key(number)?;
        let string = &instrument.strings[0];
        let [force_n, pressed_m, dashpot] = lying(&instrument)?;
        let impedance = (string.tension_n * string.mass_kg_per_m).sqrt();
        let own = Note::new(&instrument)?.decay(&instrument, 0.0, MOST_S[0])?;
        let other = with_damper_of(&instrument, &middle);
        let alike = Note::new(&other)?.decay(&other, 0.0, MOST_S[0])?;
        let length_m = string.damper.map_or(f64::NAN, |damper| damper.length_m);
        table.row([
            note_name(number),
            instrument.strings.len().to_string(),
            format!("{:.0}", 1e3 * length_m),
            format!("{:.0}", 1e3 * force_n),
            format!("{:.2}", 1e3 * pressed_m),
            format!("{:.2}", dashpot / impedance),
            format!("{:.2}", own.all_s),
            format!("{:.2}", own.first_s),
            own.longest.to_string(),
            format!("{}{:.2}", if alike.gone { "" } else { "> " }, if alike.gone { alike.all_s } else { MOST_S[0] }),
        ]);
        found.push((number, own, dashpot / impedance));
    }
    section.tables.push(table);
    let bass: Vec<&(usize, Decay, f64)> = found.iter().filter(|(number, ..)| *number <= 20).collect();
    section.claims.push(Claim::new(
        "general experience",
        format!("strings of the bass are silent {} to {} s after their dampers fall", BASS_S[0], BASS_S[1]),
        bass.iter()
            .map(|(n, own, _)| format!("{} {:.2} s (partial {} is the last)", note_name(*n), own.all_s, own.longest))
            .collect::<Vec<_>>()
            .join(", "),
        bass.iter().all(|(_, own, _)| own.gone && (BASS_S[0]..=BASS_S[1]).contains(&own.all_s)),
    ));
    section.claims.push(Claim::new(
        "this program",
        "no dashpot is beyond 2 Z, at which it takes half of a wave that passes, the most it can; a stronger one would only hold the string still",
        found.iter().map(|(n, _, share)| format!("{} {share:.2}", note_name(*n))).collect::<Vec<_>>().join(", "),
        found.iter().all(|(.., share)| (0.2..2.0).contains(share)),
    ));
    Ok(())
}

/// Lifts between which T60 goes from twice the damped one to half the free one, mm.
fn usable_mm(t60: &[f64]) -> Option<[f64; 2]> {
    let at = |wanted_s: f64| {
        let after = t60.iter().position(|t| *t >= wanted_s).filter(|after| *after > 0)?;
        let share = (wanted_s / t60[after - 1]).ln() / (t60[after] / t60[after - 1]).ln();
        Some(LIFTS_MM[after - 1] + share * (LIFTS_MM[after] - LIFTS_MM[after - 1]))
    };
    Some([at(USABLE[0] * t60[0])?, at(USABLE[1] * t60[t60.len() - 1])?])
}

fn half_pedal(
    key: &dyn Fn(usize) -> Result<Instrument, ReproduceError>,
    section: &mut Section,
    progress: &mut Progress,
) -> Result<(), ReproduceError> {
    let mut instruments = Vec::new();
    for number in HALF_KEYS {
        instruments.push((note_name(number), key(number)?));
    }
    // The earlier felt of all strings, with the string lower by the difference in compression.
    let mut stiff = key(MIDDLE)?;
    let [force_n, pressed_m, _] = lying(&stiff)?;
    let dampers: Vec<usize> = stiff.strings.iter().filter_map(|string| string.damper).map(|one| one.zone).collect();
    for zone in dampers {
        let stiffen = |fields: &mut erard::instrument::InstrumentFields| {
            let zone = &mut fields.zones[zone];
            zone.felt.stiffness = STIFF[0];
            zone.felt.loss = moreau::Loss::quadratic(STIFF[1]);
            if let erard::instrument::Curve::Line { point_m, .. } = &mut zone.curve {
                point_m[1] += (force_n / STIFF[0]).sqrt() - pressed_m;
            }
        };
        stiff.edit(stiffen)?;
    }
    instruments.push((format!("{}, felt 18 times as stiff", note_name(MIDDLE)), stiff));
    let mut header = vec!["lift of the rail, mm".to_owned()];
    header.extend(instruments.iter().map(|(name, _)| name.clone()));
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = Table::new("T60 with the pedal half down, s", &header);
    let (mut curves, mut told, mut usable) = (Vec::new(), Vec::new(), Vec::new());
    for (n, (name, instrument)) in instruments.iter().enumerate() {
        let mut note = Note::new(instrument)?;
        let mut t60 = Vec::new();
        for (m, mm) in LIFTS_MM.into_iter().enumerate() {
            tell(progress, (n * LIFTS_MM.len() + m) as f64 / (instruments.len() * LIFTS_MM.len()) as f64)?;
            t60.push(note.decay(instrument, 1e-3 * mm, MOST_S[1])?.all_s);
        }
        let travel = usable_mm(&t60);
        told.push(match travel {
            Some([from, to]) => format!("{name}: {from:.2} to {to:.2} mm, {:.2} mm", to - from),
            None => format!("{name}: none"),
        });
        usable.push(travel.map_or(0.0, |[from, to]| to - from));
        curves.push(t60);
    }
    for (m, mm) in LIFTS_MM.into_iter().enumerate() {
        table.row([format!("{mm}")].into_iter().chain(curves.iter().map(|t60| format!("{:.2}", t60[m]))));
    }
    section.tables.push(table);
    section.claims.push(Claim::new(
        "this program",
        "half-damping comes out of the contact: the rail's travel from twice the damped T60 to half the free one is nearly what the felt is pressed by, and a soft felt has more than twice a stiff one's",
        told.join("; "),
        usable[..3].iter().all(|mm| *mm > 0.2) && usable[1] > 2.0 * usable[3],
    ));
    section.charts.push(Chart {
        title: "T60 with the pedal half down".into(),
        caption: "The rail has 2 mm of lost motion; above 0.8 s the time is what the first 0.8 s lead to".into(),
        x_label: "lift of the rail (mm)".into(),
        x_log: false,
        panels: vec![ChartPanel {
            y_label: "T60 (s)".into(),
            y_log: true,
            y_range: None,
            curves: curves
                .into_iter()
                .zip(&instruments)
                .enumerate()
                .map(|(colour, (y, (name, _)))| ChartCurve {
                    label: name.clone(),
                    x: LIFTS_MM[1..].to_vec(),
                    y: y[1..].to_vec(),
                    colour,
                    mark: Dash::Solid,
                })
                .collect(),
        }],
    });
    Ok(())
}
