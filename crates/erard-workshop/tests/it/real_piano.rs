//! Comparison with a real action: the recorded key of a Kawai KG-3C (`recordings/README.md`) drives the model, and its
//! hammer is compared. Only the model's screws were turned, to the distances of the slow stroke.

use std::path::Path;

use erard::instrument::Instrument;
use erard::recording::{LowPass, Preparation, prepare};
use erard::run::Setup;
use erard::stroke::{PositionOf, Prescribed, Recording};
use erard_workshop::compare::{Choice, Comparison, Which, compare_chosen};
use erard_workshop::distances::Protocol;
use erard_workshop::regulate::{Goal, regulate};
use erard_workshop::validate::Published;
use moreau::Settings;

/// Regulated like the recorded one. No mass, felt or friction is changed.
fn regulated() -> Instrument {
    let steinway = Instrument::builtin("steinway-o").unwrap();
    let found = [(Goal::Blow, 50.8), (Goal::Dip, 11.7), (Goal::LetOff, 3.8), (Goal::Drop, 2.2), (Goal::Check, 18.0)];
    let goals = found.map(|(goal, mm)| (goal, 1e-3 * mm)).to_vec();
    regulate(&steinway, &goals, &Protocol::default(), &mut |_| true).unwrap().instrument
}

/// The recorded key drives the model's, where the sensor was: behind the balance pin.
fn led(instrument: &Instrument, stroke: &str, low_pass_hz: f64) -> Comparison {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../erard-core/recordings/kawai-kg-3c-{stroke}.csv"));
    let text = std::fs::read(file).unwrap();
    let recording = Recording::read(text.as_slice(), stroke, &erard::stroke::Columns::default()).unwrap();
    let preparation = Preparation { low_pass: LowPass::At(low_pass_hz), ..Preparation::default() };
    let series = prepare(&recording, &preparation).unwrap().series;
    let setup = Setup { settings: Settings::new(50e-6), ledger: false, ..Setup::new(1.0) };
    let (drives, models) = (vec![Prescribed::Rigid], vec![Which::Action]);
    let choice = Choice { position_of: PositionOf::KeyBack, drives, models, ..Choice::default() };
    compare_chosen(instrument, &series, &choice, &setup, &mut |_| true).unwrap()
}

/// Measured and simulated rise of the hammer, mm.
fn hammers(comparison: &Comparison) -> [Vec<f64>; 2] {
    let trial = comparison.trial(Prescribed::Rigid, Which::Action).unwrap();
    let measured = comparison.measured_hammer_rise_m.as_ref().unwrap();
    [measured, &trial.hammer_rise_m].map(|metres| metres.iter().map(|rise| 1e3 * rise).collect())
}

/// Time at which a series first reaches a value, ms.
fn reaches(comparison: &Comparison, series: &[f64], value: f64) -> f64 {
    1e3 * comparison.time_s[series.iter().position(|at| *at >= value).unwrap()]
}

#[test]
fn a_slow_press_lifts_the_hammer_as_far() {
    let comparison = led(&regulated(), "slow", 20.0);
    let [measured, simulated] = hammers(&comparison);
    let key_mm: Vec<f64> = comparison.measured_position_m.as_ref().unwrap().iter().map(|at| 1e3 * at).collect();
    // Where the key's sensor is reliable, and before let-off.
    let until = key_mm.iter().position(|at| *at > 7.0).unwrap();
    let rows = || (0..until).filter(|row| key_mm[*row] > 2.0);
    let ratio = |hammer: &[f64]| {
        rows().map(|row| key_mm[row] * hammer[row]).sum::<f64>() / rows().map(|row| key_mm[row].powi(2)).sum::<f64>()
    };
    let ratios = [&measured, &simulated].map(|hammer| ratio(hammer));
    let square: f64 = rows().map(|row| (measured[row] - simulated[row]).powi(2)).sum();
    let rms = (square / rows().count() as f64).sqrt();
    let top = |hammer: &[f64]| hammer.iter().copied().fold(0.0, f64::max);
    println!(
        "mm of hammer per mm of key {ratios:.2?}; {rms:.2} mm apart up to let-off; let off at {:.1} and {:.1} mm",
        top(&measured),
        top(&simulated)
    );
    assert!((ratios[1] / ratios[0] - 1.0).abs() < 0.03, "{ratios:?}");
    assert!(rms < 1.0, "{rms}");
    // Let-off was regulated for this with the front driven; finding it with the recorded key as well is not implied.
    assert!((top(&measured) - top(&simulated)).abs() < 0.8);
}

#[test]
fn medium_and_fast_strokes_throw_the_hammer() {
    let instrument = regulated();
    // The fast hammer is early by 3.5 ms, a miss: the train yields or loses too little (`erard-reproduce --only
    // train-felts`).
    for (stroke, least, early_ms, faster) in [("medium", 0.99, 2.5, 1.1), ("fast", 0.95, 4.0, 1.2)] {
        let comparison = led(&instrument, stroke, 250.0);
        let explained =
            comparison.trial(Prescribed::Rigid, Which::Action).unwrap().hammer_errors.as_ref().unwrap().explained;
        let [measured, simulated] = hammers(&comparison);
        let [from, to] = [10.0, 45.0].map(|mm| [&measured, &simulated].map(|hammer| reaches(&comparison, hammer, mm)));
        let speeds = [0, 1].map(|which| 35.0 / (to[which] - from[which]));
        println!(
            "{stroke}: {:.1} % of the hammer's variance explained; 45 mm at {to:.1?} ms, 10 to 45 mm at {speeds:.2?} m/s",
            100.0 * explained
        );
        assert!(explained > least, "{stroke}: {explained}");
        assert!((to[0] - to[1]).abs() < early_ms, "{stroke}: {to:?}");
        assert!((0.9..faster).contains(&(speeds[1] / speeds[0])), "{stroke}: {speeds:?}");
        // Held by the back check, each at its own place, of a key that is not quite as deep.
        let held = |hammer: &[f64]| hammer[hammer.len() - 800];
        assert!((held(&measured) - held(&simulated)).abs() < 4.0, "{} {}", held(&measured), held(&simulated));
    }
}

fn recorded(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../erard-core/recordings").join(name);
    std::fs::read_to_string(file).unwrap()
}

/// Cells of a recorded table, without its heading.
fn cells(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().skip(1).map(|line| line.split(',').collect())
}

/// Quantile by linear interpolation between the sorted values.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = share * (values.len() - 1) as f64;
    let below = at.floor() as usize;
    values[below] + (at - below as f64) * (values[(below + 1).min(values.len() - 1)] - values[below])
}

/// Values of a column in the rows that hold, by the heading of a recorded table.
fn column(text: &str, of: &str, holds: &[(&str, &str)]) -> Vec<f64> {
    let heading: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at = |name: &str| heading.iter().position(|known| *known == name).unwrap();
    let rows = cells(text).filter(|row| holds.iter().all(|(name, value)| row[at(name)] == *value));
    rows.map(|row| row[at(of)].parse().unwrap()).collect()
}

/// The ranges of the rows on releases and on hammers that come home are made of the recordings that judge, by the rules
/// of `validation/README.md`: the span, or 10 to 90 %, and what the recording does not resolve.
#[test]
fn recordings_give_the_published_ranges() {
    let (releases, hammers) = (recorded("kawai-kg-3c-releases.csv"), recorded("kawai-kg-3c-hammers.csv"));
    let published = Published::builtin();
    let check = |name: &str, [low, high]: [f64; 2], unresolved: [f64; 2], digits: f64| {
        let row = published.rows.iter().find(|row| row.name == name).unwrap();
        let ends = [low - unresolved[0], high + unresolved[1]].map(|end| (end * digits).round() / digits);
        assert_eq!([row.at_least.unwrap(), row.at_most.unwrap()], ends, "{name}");
    };
    let span = |values: &[f64]| {
        [values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(0.0, f64::max)]
    };
    let of = |name: &str, kind: &str| column(&releases, name, &[("role", "judge"), ("kind", kind)]);
    for (row, name, unresolved, digits) in [
        ("let_go_home", "home_ms", 0.5, 10.0),
        ("let_go_humps", "humps", 0.5, 10.0),
        ("let_go_first_top", "first_ms", 1.0, 10.0),
        ("let_go_second_top", "second_ms", 1.0, 10.0),
        ("let_go_first_height", "first_mm", 0.2, 100.0),
        ("let_go_second_height", "second_mm", 0.2, 100.0),
    ] {
        let values = of(name, "let go");
        assert_eq!(values.len(), 3);
        check(row, span(&values), [unresolved; 2], digits);
    }
    let speed = span(&of("speed_m_per_s", "let go"));
    check("let_go_speed", speed, speed.map(|end| 0.05 * end), 1000.0);
    for (row, name, unresolved, digits) in
        [("led_up_home", "home_ms", 0.5, 10.0), ("led_up_rebound", "rebound_mm", 0.2, 100.0)]
    {
        let mut values = of(name, "led up");
        assert_eq!(values.len(), 20);
        let most = [0.1, 0.9].map(|share| (quantile(&mut values, share) * digits).round() / digits);
        check(row, most, [unresolved; 2], digits);
    }
    for (row, name) in
        [("hammer_sinks", "sinks_ms"), ("hammer_bounces", "bounces_ms"), ("hammer_bounces_again", "bounces_again_ms")]
    {
        let values = column(&hammers, name, &[("role", "judge")]);
        assert_eq!(values.len(), 6);
        check(row, span(&values), [1.0; 2], 10.0);
    }
}

/// Every recorded stroke is used either to choose or to judge; those that were read for judging are cut from the source
/// at the listed places, and none has both uses.
#[test]
fn strokes_choose_or_judge() {
    let split = recorded("split.csv");
    let strokes: Vec<Vec<&str>> = cells(&split).filter(|row| row[1] == "two").collect();
    assert!(strokes.iter().all(|row| ["choose", "judge"].contains(&row[5])));
    let span = |row: &[&str]| [2, 3].map(|column| row[column].parse::<f64>().unwrap());
    for (n, one) in strokes.iter().enumerate() {
        for other in &strokes[..n] {
            let ([a, b], [c, d]) = (span(one), span(other));
            assert!(b <= c || d <= a, "{} and {}", one[0], other[0]);
        }
    }
    let raw = recorded("kawai-kg-3c-judge-raw.csv");
    let cut = strokes.iter().filter(|row| row[4] == "kawai-kg-3c-judge-raw.csv");
    assert_eq!(cut.clone().count(), 5);
    for row in cut {
        let times: Vec<f64> = cells(&raw).filter(|cut| cut[0] == row[0]).map(|cut| cut[1].parse().unwrap()).collect();
        let [from, to] = span(row);
        assert!((times[0] - from).abs() < 1e-3 && (times[times.len() - 1] - to).abs() < 1e-3, "{}", row[0]);
        assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 0.5e-3).abs() < 1e-9), "{}", row[0]);
    }
}
