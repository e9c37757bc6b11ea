//! Built-in touches from gentle to loud, by hands of 50, 200 and 1000 g: travel time of the hammer, single impacts, and
//! the influence of the hand.

use moreau::Settings;

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, bending};
use erard::instrument::Instrument;
use erard::level::{HOLD_N, HandKind, LevelError, Reference};
use erard::run::{Run, Setup, SimulationError, press_by_hand};
use erard::stroke::{RISE_S, Touch};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Duration, s.
const HELD_S: f64 = 0.7;
/// Levels from gentle to loud.
const STEPS: usize = 24;
/// The gentlest and the loudest hammer speed, m/s.
const SPEEDS_M_PER_S: [f64; 2] = [0.4, 5.0];
/// Masses of the hands, kg. 200 g is the built-in one.
const MASSES_KG: [f64; 3] = [0.05, 0.2, 1.0];
const OWN_KG: f64 = 0.2;
/// Audible speed of a second impact, m/s.
const HEARD_M_PER_S: f64 = 0.1;
/// Limit of [`roughness`] for a smooth curve: a tenth of its whole range.
const SMOOTH: f64 = 0.1;
/// Flight time of a thrown hammer, ms: a hammer let off at a millimetre or two needs a few.
const THROWN_MS: f64 = 8.0;

/// Results of a touch.
struct Touched {
    louder: f64,
    speed_m_per_s: f64,
    travel_ms: f64,
    ahead_ms: f64,
    /// Time from let-off to the string, ms.
    flight_ms: f64,
    /// The fastest impact after the first, m/s.
    second_m_per_s: f64,
    is_checked: bool,
}

impl Touched {
    fn of(louder: f64, run: &Run) -> Self {
        let events = &run.events;
        let ms = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(f64::NAN, |(a, b)| (a - b) * 1e3);
        Touched {
            louder,
            speed_m_per_s: events.hammer_speed_m_per_s().unwrap_or(f64::NAN),
            travel_ms: ms(events.hammer_contact_s(), events.key_start_s),
            ahead_ms: ms(events.key_bottom_s, events.hammer_contact_s()),
            flight_ms: ms(events.hammer_contact_s(), events.let_off_s),
            second_m_per_s: events.impacts.iter().skip(1).map(|one| one.hammer_speed_m_per_s).fold(0.0, f64::max),
            is_checked: events.check_s.is_some(),
        }
    }
}

/// Plays a level by a kind of hand; `None` if no hand of the kind reaches it.
fn played(
    instrument: &Instrument,
    reference: &mut Reference,
    kind: HandKind,
    speed_m_per_s: f64,
) -> Result<Option<Touched>, ReproduceError> {
    let solved = match reference.solve(kind, speed_m_per_s, &mut |_| true) {
        Ok(solved) => solved,
        Err(LevelError::OutOfReach { .. } | LevelError::Jump { .. }) => return Ok(None),
        Err(error) => return Err(ReproduceError::Instrument(error.to_string())),
    };
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(20), ..Setup::new(HELD_S) };
    let run: Result<Run, SimulationError> = press_by_hand(instrument, &solved.held(), &setup, &mut |_| true);
    Ok(Some(Touched::of(solved.louder, &run?)))
}

fn name(kind: HandKind) -> String {
    format!("{}, {:.0} g", kind.touch.name(), kind.mass_kg * 1e3)
}

fn claims(kind: &str, steps: &[Touched]) -> [Claim; 2] {
    let own = |says: String, measured: String, holds| Claim::new("this program", says, measured, holds);
    let all = steps.len();
    let single = steps.iter().filter(|touched| touched.second_m_per_s < HEARD_M_PER_S).count();
    let values: [fn(&Touched) -> f64; 1] = [|t| t.travel_ms];
    let roughest =
        values.into_iter().map(|value| roughness(&steps.iter().map(value).collect::<Vec<_>>())).fold(0.0, f64::max);
    [
        own(
            format!("{kind}: no second impact above {HEARD_M_PER_S} m/s"),
            format!("{} of {all} levels have one", all - single),
            single == all,
        ),
        own(
            format!("{kind}: the travel time changes smoothly from level to level"),
            format!(
                "no value departs from the middle of its neighbours by more than {:.0} % of its range",
                100.0 * roughest
            ),
            roughest < SMOOTH,
        ),
    ]
}

/// Describes levels at which the hammer is thrown off the jack instead of carried to let-off.
fn thrown(kind: &str, steps: &[Touched]) -> Option<String> {
    let thrown: Vec<&Touched> = steps.iter().filter(|touched| touched.flight_ms > THROWN_MS).collect();
    let longest_ms = thrown.iter().map(|touched| touched.flight_ms).fold(0.0, f64::max);
    let (first, last) = (thrown.first()?, thrown.last()?);
    Some(format!(
        "{kind}: {} of {} levels, from {:.2} to {:.2} m/s, are played by a hammer that the first jerk throws off the jack; it flies for {longest_ms:.0} ms at most.",
        thrown.len(),
        steps.len(),
        first.speed_m_per_s,
        last.speed_m_per_s
    ))
}

/// Largest departure of a value from the mean of its neighbours, as a share of the whole range.
fn roughness(values: &[f64]) -> f64 {
    let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let bend = values.windows(3).map(|w| (w[1] - 0.5 * (w[0] + w[2])).abs()).fold(0.0, f64::max);
    bend / (most - least)
}

/// Travel time at a hammer speed, interpolated between the two nearest levels, ms.
fn travel_at(steps: &[Touched], speed_m_per_s: f64) -> Option<f64> {
    let pair = steps
        .windows(2)
        .find(|pair| pair[0].speed_m_per_s <= speed_m_per_s && speed_m_per_s <= pair[1].speed_m_per_s)?;
    let share = (speed_m_per_s / pair[0].speed_m_per_s).ln() / (pair[1].speed_m_per_s / pair[0].speed_m_per_s).ln();
    Some(pair[0].travel_ms + share * (pair[1].travel_ms - pair[0].travel_ms))
}

/// Hammer speeds of the comparison, m/s.
const COMPARED_M_PER_S: [f64; 5] = [0.5, 0.79, 1.99, 3.15, 4.9];

pub(super) fn section(asked: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let instrument = &bending(asked)?;
    let mut reference =
        Reference::new(instrument, &mut |_| true).map_err(|error| ReproduceError::Instrument(error.to_string()))?;
    let mut section = Section {
        text: vec![format!(
            "Pressed: the hand rests on the key, and its muscle's force rises within {:.0} ms. Struck: the hand arrives with a speed, and its muscle presses on. For {STEPS} \
             hammer speeds from {} to {} m/s, in equal ratios, the force or the speed is found. When the hammer is at the string the force goes to {HOLD_N} N. W. Goebl, R. Bresin \
             and A. Galembo (J. Acoust. Soc. Am. 118 (2005) 1154; read in its abstract and in quotations only) found that the travel time from finger-key to hammer-string \
             depends on the hammer's speed and clearly on the touch, and little on the piano: 20 ms to some 200 ms, the struck touch about 20 ms sooner at equal loudness. \
             Here the travel time counts from the key's start, 0.1 mm down: the finger of a pressed touch has rested on the key before.",
            1e3 * RISE_S,
            SPEEDS_M_PER_S[0],
            SPEEDS_M_PER_S[1]
        )],
        ..Section::default()
    };
    let mut table = Table::new(
        "Every fifth level and the last",
        &[
            "touch",
            "its number (N, m/s)",
            "hammer (m/s)",
            "key start to hammer (ms)",
            "hammer before key bottom (ms)",
            "second impact (m/s)",
            "checked",
        ],
    );
    let values: [fn(&Touched) -> f64; 2] = [|t| t.travel_ms, |t| t.ahead_ms];
    let labels = ["key start to hammer (ms)", "hammer before key bottom (ms)"];
    let mut curves: [Vec<ChartCurve>; 2] = [Vec::new(), Vec::new()];
    let touches = [Touch::Pressed, Touch::Struck];
    let kinds = touches.into_iter().flat_map(|touch| MASSES_KG.map(|mass_kg| HandKind::new(touch, mass_kg)));
    let mut all: Vec<(HandKind, Vec<Touched>)> = Vec::new();
    for (k, kind) in kinds.enumerate() {
        let mut steps = Vec::new();
        for n in 0..STEPS {
            tell(progress, (k as f64 + n as f64 / STEPS as f64) / (2.0 * MASSES_KG.len() as f64))?;
            let [from, to] = SPEEDS_M_PER_S;
            let speed_m_per_s = from * (to / from).powf(n as f64 / (STEPS - 1) as f64);
            steps.extend(played(instrument, &mut reference, kind, speed_m_per_s)?);
        }
        let name = name(kind);
        if kind.mass_kg == OWN_KG {
            section.claims.extend(claims(&name, &steps));
        }
        if kind.touch == Touch::Struck {
            section.text.extend(thrown(&name, &steps));
        }
        for (curve, value) in curves.iter_mut().zip(values) {
            curve.push(ChartCurve {
                label: name.clone(),
                x: steps.iter().map(|touched| touched.speed_m_per_s).collect(),
                y: steps.iter().map(value).collect(),
                colour: k,
                mark: Dash::Points,
            });
        }
        for touched in steps.iter().step_by(5).chain(steps.last()) {
            table.row([
                name.clone(),
                format!("{:.3}", touched.louder),
                format!("{:.2}", touched.speed_m_per_s),
                format!("{:.1}", touched.travel_ms),
                format!("{:.2}", touched.ahead_ms),
                format!("{:.2}", touched.second_m_per_s),
                if touched.is_checked { "yes" } else { "no" }.into(),
            ]);
        }
        all.push((kind, steps));
    }
    section.tables.push(compared(&all));
    section.tables.push(table);
    let panels = curves.into_iter().zip(labels).map(|(curves, label)| ChartPanel {
        y_label: label.into(),
        y_log: label.starts_with("key start"),
        y_range: None,
        curves,
    });
    section.charts.push(Chart {
        title: "From gentle to loud".into(),
        caption: format!("{STEPS} levels of each hand, held"),
        x_label: "hammer speed (m/s)".into(),
        x_log: true,
        panels: panels.collect(),
    });
    Ok(section)
}

/// Table of travel times of all hands at the speeds of the levels.
fn compared(all: &[(HandKind, Vec<Touched>)]) -> Table {
    let mut table = Table::new(
        "Travel time from key start to the string, ms; published: 20 to some 200, struck about 20 sooner at mf",
        &["hammer (m/s)", "hand (g)", "pressed", "struck", "struck sooner by"],
    );
    for speed_m_per_s in COMPARED_M_PER_S {
        for mass_kg in MASSES_KG {
            let of = |touch: Touch| {
                let (_, steps) = all.iter().find(|(kind, _)| *kind == HandKind::new(touch, mass_kg))?;
                travel_at(steps, speed_m_per_s)
            };
            let [pressed, struck] = [Touch::Pressed, Touch::Struck].map(of);
            let shown = |ms: Option<f64>| ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.1}"));
            table.row([
                format!("{speed_m_per_s}"),
                format!("{:.0}", mass_kg * 1e3),
                shown(pressed),
                shown(struck),
                shown(pressed.zip(struck).map(|(a, b)| a - b)),
            ]);
        }
    }
    table
}
