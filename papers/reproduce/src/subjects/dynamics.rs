//! From gentle to loud in thirty steps: every touch is one blow that is checked, and what is measured of it changes
//! smoothly.

use moreau::Settings;

use super::blow::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, bending};
use erard::instrument::Instrument;
use erard::run::Run;
use erard::run::{HandStroke, press_by_hand};
use erard::run::{Setup, SimulationError};

/// s.
const STEP_S: f64 = 50e-6;
/// Held so long, s.
const HELD_S: f64 = 0.7;
/// What holds the key after the blow, N.
const HOLD_N: f64 = 3.0;
/// Steps from gentle to loud.
const STEPS: usize = 30;
/// The gentlest and the loudest: for a hand that is led, in so many s; for a force that rises, N/s; for a finger that
/// arrives, m/s.
const LED_S: [f64; 2] = [0.25, 0.08];
const RISES_N_S: [f64; 2] = [40.0, 1500.0];
const ARRIVES_M_S: [f64; 2] = [0.12, 1.6];
/// What two neighbouring steps may differ by more than the mean of their own neighbours' differences, for a curve that
/// is called smooth: a tenth of its whole range.
const SMOOTH: f64 = 0.1;

/// A hammer that flies for so long was thrown, ms: let off at a millimetre or two it takes a few.
const THROWN_MS: f64 = 8.0;

/// A kind of touch, from gentle to loud.
struct Kind {
    name: &'static str,
    ends: [f64; 2],
    gesture: fn(f64) -> HandStroke,
    is_led: bool,
    colour: usize,
}

const KINDS: [Kind; 3] = [
    Kind { name: "led", ends: LED_S, gesture: HandStroke::led, is_led: true, colour: 0 },
    Kind { name: "pressed", ends: RISES_N_S, gesture: HandStroke::pressed, is_led: false, colour: 1 },
    Kind { name: "struck", ends: ARRIVES_M_S, gesture: HandStroke::struck, is_led: false, colour: 2 },
];

/// What came of a touch.
struct Touched {
    louder: f64,
    speed_m_s: f64,
    travel_ms: f64,
    ahead_ms: f64,
    /// From let-off to the string.
    flight_ms: f64,
    blows: usize,
    is_checked: bool,
}

impl Touched {
    fn of(louder: f64, run: &Run) -> Self {
        let events = &run.events;
        let ms = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(f64::NAN, |(a, b)| (a - b) * 1e3);
        Touched {
            louder,
            speed_m_s: events.hammer_speed_m_s().unwrap_or(f64::NAN),
            travel_ms: ms(events.hammer_contact_s(), events.key_start_s),
            ahead_ms: ms(events.key_bottom_s, events.hammer_contact_s()),
            flight_ms: ms(events.hammer_contact_s(), events.let_off_s),
            blows: events.impacts.len(),
            is_checked: events.check_s.is_some(),
        }
    }
}

fn played(instrument: &Instrument, kind: &Kind, louder: f64) -> Result<Touched, SimulationError> {
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(20), ..Setup::new(HELD_S) };
    let gesture = (kind.gesture)(louder);
    let gesture = if kind.is_led { gesture } else { gesture.relaxing_at_the_blow(instrument, &setup, HOLD_N)? };
    Ok(Touched::of(louder, &press_by_hand(instrument, &gesture, &setup, &mut |_| true)?))
}

/// What is asked of a kind: one blow, checked, and smooth curves.
fn claims(kind: &str, steps: &[Touched]) -> [Claim; 3] {
    let own = |says: String, measured: String, holds| Claim::new("this program", says, measured, holds);
    let all = steps.len();
    let single = steps.iter().filter(|touched| touched.blows == 1).count();
    let unchecked = steps.iter().filter(|touched| !touched.is_checked);
    let fastest = unchecked.clone().map(|touched| touched.speed_m_s).fold(0.0, f64::max);
    let checked = all - unchecked.count();
    let except = if checked == all { String::new() } else { format!("; all that are faster than {fastest:.2} m/s") };
    let values: [fn(&Touched) -> f64; 3] = [|t| t.travel_ms, |t| t.ahead_ms, |t| t.speed_m_s];
    let roughest =
        values.into_iter().map(|value| roughness(&steps.iter().map(value).collect::<Vec<_>>())).fold(0.0, f64::max);
    [
        own(format!("{kind}: every touch sounds once"), format!("{single} of {all}"), single == all),
        own(format!("{kind}: every blow is checked"), format!("{checked} of {all}{except}"), checked == all),
        own(
            format!("{kind}: travel time, key bottom and speed change smoothly from step to step"),
            format!(
                "no value departs from the middle of its neighbours by more than {:.0} % of its range",
                100.0 * roughest
            ),
            roughest < SMOOTH,
        ),
    ]
}

/// Where the hammer is thrown off the jack, and no longer carried to let-off.
fn thrown(kind: &str, steps: &[Touched]) -> Option<String> {
    let is_thrown = |touched: &&Touched| touched.flight_ms > THROWN_MS;
    let first = steps.iter().find(is_thrown)?;
    let last = steps.iter().rfind(|touched| !is_thrown(touched))?;
    Some(format!(
        "{kind}: up to {:.2} m/s of the finger the jack carries the hammer to let-off; from {:.2} m/s on the blow throws the hammer off the jack, which \
         then flies for {:.0} ms. Where one gives way to the other the same hammer speed comes of two touches.",
        last.louder, first.louder, first.flight_ms
    ))
}

/// The largest departure of a value from the middle of its neighbours, as a share of the whole range.
fn roughness(values: &[f64]) -> f64 {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let bend = values.windows(3).map(|w| (w[1] - 0.5 * (w[0] + w[2])).abs()).fold(0.0, f64::max);
    bend / (most - least)
}

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let instrument = &bending(asked)?;
    let mut section = Section {
        text: vec![format!(
            "Three touches from gentle to loud in {STEPS} steps of equal ratio: a hand that is led down in {} to {} s, a hand of 0.2 kg whose force rises by {} \
             to {} N/s, a finger of 0.1 kg that arrives at the key with {} to {} m/s. The last two relax to {HOLD_N} N when the hammer is at the string. All \
             are held for {HELD_S} s. Technicians try the back check with a mezzo-forte blow (Southwest Pianos, Repetition lever spring adjustment); no source was found that asks \
             the softest of blows to be caught: their hammer comes to rest on the repetition lever, above the check.",
            LED_S[0], LED_S[1], RISES_N_S[0], RISES_N_S[1], ARRIVES_M_S[0], ARRIVES_M_S[1]
        )],
        ..Section::default()
    };
    let mut table = Table::new(
        "Every fifth step and the last",
        &[
            "touch",
            "its number",
            "hammer (m/s)",
            "key start to hammer (ms)",
            "hammer before key bottom (ms)",
            "blows",
            "checked",
        ],
    );
    let values: [fn(&Touched) -> f64; 2] = [|t| t.travel_ms, |t| t.ahead_ms];
    let labels = ["key start to hammer (ms)", "hammer before key bottom (ms)"];
    let mut curves: [Vec<ChartCurve>; 2] = [Vec::new(), Vec::new()];
    for (k, kind) in KINDS.iter().enumerate() {
        let mut steps = Vec::new();
        for n in 0..STEPS {
            tell(progress, (k as f64 + n as f64 / STEPS as f64) / KINDS.len() as f64)?;
            let [from, to] = kind.ends;
            let louder = from * (to / from).powf(n as f64 / (STEPS - 1) as f64);
            steps.push(played(instrument, kind, louder)?);
        }
        section.claims.extend(claims(kind.name, &steps));
        section.text.extend(thrown(kind.name, &steps));
        for (curve, value) in curves.iter_mut().zip(values) {
            curve.push(ChartCurve {
                label: kind.name.into(),
                x: steps.iter().map(|touched| touched.speed_m_s).collect(),
                y: steps.iter().map(value).collect(),
                colour: kind.colour,
                mark: Dash::Points,
            });
        }
        for touched in steps.iter().step_by(5).chain(steps.last()) {
            table.row([
                kind.name.to_owned(),
                format!("{:.3}", touched.louder),
                format!("{:.2}", touched.speed_m_s),
                format!("{:.1}", touched.travel_ms),
                format!("{:.2}", touched.ahead_ms),
                touched.blows.to_string(),
                if touched.is_checked { "yes" } else { "no" }.into(),
            ]);
        }
    }
    section.tables.push(table);
    let panels = curves.into_iter().zip(labels).map(|(curves, label)| ChartPanel {
        y_label: label.into(),
        y_log: label.starts_with("key start"),
        y_range: None,
        curves,
    });
    section.charts.push(Chart {
        title: "From gentle to loud".into(),
        caption: format!("{STEPS} touches of each kind, held"),
        x_label: "hammer speed (m/s)".into(),
        x_log: true,
        panels: panels.collect(),
    });
    Ok(section)
}
