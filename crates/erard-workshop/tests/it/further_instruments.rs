//! The other built-in instruments: their published arms, regulation and playing.

use crate::common::{Play, USUAL_STEP_S};
use erard::instrument::{Curve, Instrument, Vec2};
use erard::parameter::Quantity;
use erard_workshop::distances::{Protocol, measure};
use erard_workshop::regulate::Goal;
use moreau::Settings;

const FURTHER: [&str; 2] = ["steinway-o", "heavy-touch"];

fn builtin(name: &str) -> Instrument {
    Instrument::builtin(name).unwrap_or_else(|_| panic!("{name} reads"))
}

fn length([x, y]: Vec2) -> f64 {
    x.hypot(y)
}

/// The six lever arms as drawn (screws turned back), m: key to the capstan's contact and to its front, whippen to the
/// knuckle's contact on the jack and to the heel, hammer to the strike point and to the knuckle's contact. The last is
/// laid out like the published 20.5 mm in the concert grand: the jack pushes one millimetre behind the middle of the
/// knuckle.
fn arms(instrument: &Instrument) -> [f64; 6] {
    let mut drawn = instrument.clone();
    for screw in 0..drawn.screws.len() {
        assert!(drawn.turn(screw, 0.0));
    }
    let zone = |name: &str| drawn.zones.iter().find(|zone| zone.name == name).unwrap();
    let body = |name: &str| drawn.bodies.iter().find(|body| body.name == name).unwrap();
    let (capstan, jack, string) = (zone("capstan_heel"), zone("jack_knuckle"), zone("string"));
    let Curve::Line { point_m: heel, .. } = capstan.curve else { panic!("the heel is a line") };
    let [x, y] = capstan.disc_center_m;
    let (hammer, whippen) = (body("hammer"), body("whippen"));
    let ([a, b], r) = (jack.disc_center_m, jack.disc_radius_m);
    let (sin, cos) = hammer.angle_rad.sin_cos();
    let pin = [hammer.pivot_m[0] - whippen.pivot_m[0], hammer.pivot_m[1] - whippen.pivot_m[1]];
    let on_jack = [pin[0] + a * cos - b * sin, pin[1] + a * sin + b * cos - r];
    [
        length([x, y + capstan.disc_radius_m]),
        -drawn.roles.key_front_m[0],
        length(on_jack),
        length(heel),
        length(string.disc_center_m),
        length([a + 1e-3, r - b]),
    ]
}

/// Delacour's arms of a Steinway O, to half a millimetre: 125/233, 93.5/67, 138.2/20.81, together 4.97.
#[test]
fn the_steinway_has_its_published_arms() {
    let found = arms(&builtin("steinway-o").locked());
    let published = [125.0, 233.0, 93.5, 67.0, 138.2, 20.81].map(|mm| mm * 1e-3);
    for (found, published) in found.iter().zip(published) {
        assert!((found - published).abs() < 0.5e-3, "{found} {published}");
    }
    let leverage = |arms: [f64; 6]| arms[0] / arms[1] * arms[2] / arms[3] * arms[4] / arms[5];
    assert!((leverage(found) - 4.97).abs() < 0.03, "{}", leverage(found));
    // 6.5 half-way, where the grand's 5.24 give 5.6: 12 to 18 % more.
    let [grand, heavy] = ["concert-grand", "heavy-touch"].map(|name| leverage(arms(&builtin(name).locked())));
    assert!((grand - 5.24).abs() < 0.05, "{grand}: Overs gives 5.24");
    assert!((1.12..1.18).contains(&(heavy / grand)), "{heavy} {grand}");
}

/// Both are shipped regulated: every norm is met without turning a screw. They check within the usual range, 12 to 15
/// mm, at the 15 mm that was the norm when they were regulated.
#[test]
fn they_ship_regulated() {
    for name in FURTHER {
        let distances = measure(&builtin(name), &Protocol::default(), &mut |_| true).unwrap();
        for (goal, target) in Goal::norms() {
            let off = (goal.of(&distances).unwrap() - target).abs();
            let allowed = match goal.quantity() {
                _ if goal == Goal::Check => 1.5e-3,
                Quantity::Speed => 0.02 * target,
                Quantity::Share => 0.01,
                _ => 0.05e-3,
            };
            assert!(off <= allowed, "{name}: {} is off by {off}: {distances:?}", goal.name());
        }
    }
}

/// Each lets off, strikes once and is checked, from soft to loud; the same force throws the heavy hammer more slowly.
/// At 20 N the hammers are still pushed when they reach the string.
#[test]
fn they_play() {
    let mut speeds = Vec::new();
    for name in ["concert-grand", "steinway-o", "heavy-touch"] {
        let instrument = builtin(name);
        for force in [2.0, 5.0, 20.0] {
            let run = Play::ForceStep(force, 0.5).run(&instrument, Settings::new(USUAL_STEP_S), 0.5);
            let e = &run.events;
            assert!(e.toe_contact_s.is_some() && e.toe_contact_s < e.hammer_contact_s(), "{name}, {force} N: {e:?}");
            // 20 N at once compress the knuckle and bend the shank so far that the jack still pushes at the impact.
            let let_off_s = e.let_off_s.or(e.hammer_contact_s()).unwrap();
            let most = if force > 19.0 { 2e-4 } else { 0.0 };
            assert!(let_off_s - e.hammer_contact_s().unwrap() <= most, "{name}, {force} N: {e:?}");
            assert!(force > 19.0 || e.let_off_s.is_some(), "{name}, {force} N: {e:?}");
            assert_eq!(e.impacts.len(), 1, "{name}, {force} N: {e:?}");
            assert!(e.check_s.is_some(), "{name}, {force} N");
            assert_eq!(run.work.unconverged_steps, 0, "{name}, {force} N");
            if force == 5.0 {
                speeds.push(e.hammer_speed_m_per_s().unwrap());
            }
        }
    }
    assert!(speeds[2] < 0.9 * speeds[1], "{speeds:?}");
}

/// The Steinway repeats at eight strokes a second without the key coming home, between 3 mm and its dip of 10 mm and a
/// tenth.
#[test]
fn the_steinway_repeats() {
    let play = Play::Tremolo { top: 3e-3, bottom: 10.1e-3, frequency: 8.0 };
    let run = play.run(&builtin("steinway-o"), Settings::new(USUAL_STEP_S), 2.0);
    assert_eq!(run.events.impacts.len(), 16, "{:?}", run.events.impacts);
}
