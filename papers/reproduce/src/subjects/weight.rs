//! A weight laid on the key and taken off: without muscle or assumptions about a hand. It can be filmed on any grand
//! with a telephone.
//!
//! The weight touches the key as metal does: on a fingertip it would bounce by itself.

use moreau::Settings;

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, bending};
use erard::instrument::{Finger, Instrument};
use erard::player::Hand;
use erard::run::{Run, Setup, press_by_hand};
use erard::stroke::{HandStroke, Muscle};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Weights, kg.
const WEIGHTS_KG: [f64; 5] = [0.1, 0.15, 0.2, 0.3, 0.5];
const SHOWN_KG: f64 = 0.3;
/// Contact of a metal weight and the key's cover. An estimate; a stiffer one gives the same.
const METAL: Finger = Finger { stiffness_n_per_m: 1e6, damping_n_s_per_m: 300.0 };
/// Other contacts under the weight: a soft pad, a firm one, and one stiffer than the metal's.
const CONTACTS: [(&str, Finger); 3] = [
    ("a soft pad", Finger { stiffness_n_per_m: 1e5, damping_n_s_per_m: 100.0 }),
    ("a firm pad", Finger { stiffness_n_per_m: 3e5, damping_n_s_per_m: 300.0 }),
    ("ten times as stiff", Finger { stiffness_n_per_m: 1e7, damping_n_s_per_m: 1e3 }),
];
/// Time at which the weight is taken off, and end, s.
const OFF_S: f64 = 0.5;
const END_S: f64 = 0.9;
/// Distance above its last place at which a key has not reached it, m.
const LEFT_M: f64 = 0.05e-3;
/// Requirements of a good key: largest distance from its punching, m, and time to its last place, s.
const ASKED: (f64, f64) = (0.3e-3, 0.030);

/// Effect of a weight.
struct Laid {
    run: Run,
    /// Rise of the key from its first contact with the punching, m; 0 if it stays.
    leaves_m: f64,
    /// Its distance from there until the weight is taken off, m.
    stays_m: f64,
    /// Time from the first contact until the key is in that place, s.
    until_s: f64,
}

impl Laid {
    fn new(instrument: &Instrument, weight_kg: f64) -> Result<Self, ReproduceError> {
        let force_n = weight_kg * instrument.gravity_m_per_s2;
        let laid = HandStroke {
            hand: Hand { mass_kg: weight_kg, ..Hand::default() },
            muscle: Muscle::Steady { force_n },
            relaxes: None,
            leaves: None,
        };
        let setup =
            Setup { settings: Settings::new(STEP_S), record_every: Some(4), ledger: false, ..Setup::new(END_S) };
        let run = press_by_hand(instrument, &laid.letting_go(OFF_S), &setup, &mut |_| true)?;
        let Some(bottom_s) = run.events.key_bottom_s.filter(|&bottom_s| bottom_s < OFF_S) else {
            return Ok(Laid { run, leaves_m: f64::NAN, stays_m: f64::NAN, until_s: f64::NAN });
        };
        let rows = |s: f64| run.time_s.partition_point(|&t| t < s);
        let (from, to) = (rows(bottom_s), rows(OFF_S));
        let met_m = run.key_m[from];
        let leaves_m = met_m - run.key_m[from..to].iter().copied().fold(met_m, f64::min);
        let end_m = run.key_m[to - 1];
        let off = run.key_m[from..to].iter().rposition(|&key_m| end_m - key_m > LEFT_M);
        let until_s = off.map_or(0.0, |row| run.time_s[from + row] - bottom_s);
        Ok(Laid { run, leaves_m, stays_m: (met_m - end_m).max(0.0), until_s })
    }
}

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let grand = bending(asked)?;
    let header = [
        "weight (g)",
        "contact",
        "hammer (m/s)",
        "key bottom (ms)",
        "leaves it by (mm)",
        "stays off it (mm)",
        "in its place after (ms)",
    ];
    let mut table = Table::new("A weight laid on the key", &header);
    let mut section = Section::default();
    let metal = WEIGHTS_KG.map(|weight_kg| (weight_kg, "metal", METAL));
    let others = CONTACTS.map(|(name, contact)| (SHOWN_KG, name, contact));
    let cases: Vec<_> = metal.into_iter().chain([(SHOWN_KG, "the fingertip", grand.finger)]).chain(others).collect();
    for (n, (weight_kg, name, contact)) in cases.iter().copied().enumerate() {
        tell(progress, n as f64 / cases.len() as f64)?;
        let mut touched = grand.clone();
        touched.edit(|fields| fields.finger = contact)?;
        let laid = Laid::new(&touched, weight_kg)?;
        let events = &laid.run.events;
        let shown = |value: Option<f64>, digits: usize| value.map_or("-".into(), |value| format!("{value:.digits$}"));
        let number = |value: f64| Some(value).filter(|value| value.is_finite());
        table.row([
            format!("{:.0}", 1e3 * weight_kg),
            name.to_owned(),
            shown(events.hammer_speed_m_per_s(), 2),
            shown(events.key_bottom_s.map(|s| 1e3 * s), 0),
            shown(number(1e3 * laid.leaves_m), 2),
            shown(number(1e3 * laid.stays_m), 2),
            shown(number(1e3 * laid.until_s), 0),
        ]);
        if (weight_kg, contact) == (SHOWN_KG, METAL) {
            section.claims.push(Claim::new(
                "asked of a good key",
                format!(
                    "{:.0} g laid on the key: it leaves its punching by less than {:.1} mm, and is in its last place within {:.0} ms",
                    1e3 * weight_kg,
                    1e3 * ASKED.0,
                    1e3 * ASKED.1
                ),
                format!(
                    "by {:.2} mm, in its last place after {:.0} ms, {:.2} mm above it",
                    1e3 * laid.leaves_m,
                    1e3 * laid.until_s,
                    1e3 * laid.stays_m
                ),
                laid.leaves_m < ASKED.0 && laid.until_s < ASKED.1,
            ));
            section.charts.push(chart(&laid.run));
        }
    }
    section.text.push(format!(
        "The weight stands on the resting key and is let go; at {:.0} ms it is taken off within 2 ms. Distances are from where the key first meets its punching. \
         Metal on the key's cover: {:.0} N/mm and {:.0} N s/m, an estimate.",
        1e3 * OFF_S,
        1e-3 * METAL.stiffness_n_per_m,
        METAL.damping_n_s_per_m
    ));
    section.tables.push(table);
    Ok(section)
}

fn chart(run: &Run) -> Chart {
    let panel = |y_label: &str, label: &str, values: &[f64], colour| ChartPanel {
        y_label: y_label.into(),
        y_log: false,
        y_range: None,
        curves: vec![ChartCurve {
            label: label.into(),
            x: run.time_s.iter().map(|t| 1e3 * t).collect(),
            y: values.iter().map(|m| 1e3 * m).collect(),
            colour,
            mark: Dash::Solid,
        }],
    };
    Chart {
        title: format!("A weight of {:.0} g laid on the key and taken off", 1e3 * SHOWN_KG),
        caption: format!("Laid on at 0, taken off at {:.0} ms", 1e3 * OFF_S),
        x_label: "time (ms)".into(),
        x_log: false,
        panels: vec![
            panel("key front, down (mm)", "key", &run.key_m, 0),
            panel("hammer, up (mm)", "hammer", &run.hammer_rise_m, 1),
        ],
    }
}
