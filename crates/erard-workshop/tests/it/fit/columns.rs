//! Columns of a fit, and the meaning of fitted parameters on the bench.

use erard_workshop::distances;
use erard_workshop::fit::DoubtKind;

use super::*;

/// Noise of a vibrometer on the hammer's head, m/s.
const SPEED_NOISE: f64 = 0.01;

/// A stroke of a grand with a heavier hammer; force and hammer speed were recorded.
fn speeds(until_s: f64) -> Recording {
    let heavier = varied(&[("body.hammer.mass", 1.05)]);
    let (stroke, _) = Stroke::curve("mf", Touch::Pressed, None).unwrap().unwrap();
    let inputs = stroke.inputs(&heavier.finger).unwrap();
    let setup = Setup { record_every: Some(1), ..Setup::new(until_s) };
    let run = simulate(&heavier, inputs.as_ref(), &setup, &mut |_| true).unwrap();
    let mut rng = Rng::with_seed(5);
    let mut text = String::from("time_s,force_N,Hammer speed (mm/s)\n");
    for row in (0..run.time_s.len()).step_by(5) {
        let speed = 1e3 * (run.hammer_rise_m_per_s[row] + SPEED_NOISE * normal(&mut rng));
        text += &format!("{},{},{speed}\n", run.time_s[row], run.force_n[row]);
    }
    Recording::read(text.as_bytes(), "synthetic", &Columns::default()).unwrap()
}

/// The speed in a run is the rate of the rise: central differences of the rise, to second order in the step, away from
/// impacts.
#[test]
fn the_hammer_s_speed_is_the_rate_of_its_rise() {
    let (stroke, _) = Stroke::curve("mf", Touch::Pressed, None).unwrap().unwrap();
    let grand = file().instrument;
    let inputs = stroke.inputs(&grand.finger).unwrap();
    let setup = Setup { record_every: Some(1), ..Setup::new(0.12) };
    let run = simulate(&grand, inputs.as_ref(), &setup, &mut |_| true).unwrap();
    let impact_s = run.events.hammer_contact_s().unwrap();
    let mut fastest: f64 = 0.0;
    for row in 1..run.time_s.len() - 1 {
        if run.time_s[row] > impact_s - 1e-3 {
            break;
        }
        let rate =
            (run.hammer_rise_m[row + 1] - run.hammer_rise_m[row - 1]) / (run.time_s[row + 1] - run.time_s[row - 1]);
        assert!((rate - run.hammer_rise_m_per_s[row]).abs() < 0.02, "{}: {rate}", run.time_s[row]);
        fastest = fastest.max(rate);
    }
    // The event's impact speed is the speed at the string.
    let impact = run.events.hammer_speed_m_per_s().unwrap();
    assert!(fastest > 0.9 * impact && fastest < 1.1 * impact, "{fastest} {impact}");
}

/// Fitted to the hammer's speed alone, the mass is found; the impact is found in the speed, too.
#[test]
fn the_hammer_s_speed_is_a_column() {
    let mut asks = asks(&["body.hammer.mass"]);
    asks.sigma = vec![("hammer_rise_m_per_s".to_owned(), SPEED_NOISE), ("force_N".to_owned(), 0.0)];
    asks.plan.restarts = 1;
    let whole = speeds(0.12);
    let found = fit(std::slice::from_ref(&whole), &asks).unwrap();
    assert_eq!(found.channels[0].title, "hammer_rise_m_per_s");
    assert!(found.doubts.iter().any(|doubt| doubt.kind == DoubtKind::BeyondImpact), "{:?}", found.doubts);
    // It is fastest as it reaches the string.
    let speeds_m_per_s = &whole.channels[1].values;
    let fastest = (0..speeds_m_per_s.len()).max_by(|a, b| speeds_m_per_s[*a].total_cmp(&speeds_m_per_s[*b])).unwrap();
    let found = fit(&[speeds(whole.time_s[fastest] + 3e-3)], &asks).unwrap();
    let (x, std) = (found.x[0], found.std[0]);
    assert!((x - 1.05).abs() < 4.0 * std && std < 0.01, "{x} +- {std}");
    assert!((found.channels[0].rms / SPEED_NOISE - 1.0).abs() < 0.2, "{:?}", found.channels[0]);
    assert_eq!(found.doubts, []);
}

/// `body.hammer.mass` is not a strike weight and `let_off` not a distance: the report gives the bench values of the
/// fitted instrument instead.
#[test]
fn names_that_mislead_are_explained() {
    let (_, _, found) = &*FITTED;
    let [mass, let_off] = &found.meanings[..] else { panic!("{:?}", found.meanings) };
    let fitted = varied(&[("body.hammer.mass", found.x[0]), ("let_off", found.x[3])]);
    let hammer = fitted.bodies.iter().find(|body| body.name == "hammer").unwrap();
    // The whole hammer turns about one pin: its moment over the strike point's distance.
    let scale_g = 1e3 * hammer.mass_kg * hammer.center_of_mass_m[0] / fitted.roles.hammer_strike_point_m[0];
    assert_eq!((mass.name.as_str(), mass.quantity, mass.unit), ("body.hammer.mass", "strike weight", "g"));
    assert!((mass.value / scale_g - 1.0).abs() < 1e-9, "{mass:?} {scale_g}");
    assert!((mass.value / mass.before / found.x[0] - 1.0).abs() < 1e-9, "{mass:?}");
    assert!((mass.std / mass.value / (found.std[0] / found.x[0]) - 1.0).abs() < 0.01, "{mass:?}");
    let names: Vec<(&str, f64)> = TRUE.iter().map(|(name, _)| *name).zip(found.x.iter().copied()).collect();
    let measured = distances::measure(&varied(&names), &distances::Protocol::default(), &mut |_| true).unwrap();
    assert_eq!((let_off.name.as_str(), let_off.unit), ("let_off", "mm"));
    assert!((let_off.value - 1e3 * measured.let_off_m.unwrap()).abs() < 1e-6, "{let_off:?} {measured:?}");
    assert!(let_off.std > 0.0 && (let_off.value - let_off.before).abs() > 3.0 * let_off.std, "{let_off:?}");
}
