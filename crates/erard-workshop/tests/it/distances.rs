//! The technician's distances against values computed from geometry and felts without simulation.

use crate::common::rigid_grand;
use erard::instrument::{Curve, Felt, Instrument};
use erard::player::{RestKind, RestPose};
use erard_workshop::distances::{Distances, Protocol, measure};
use erard_workshop::measure::weights::on_the_scale;

/// The grand with some of its screws turned (mm), measured.
fn measured(turns_mm: &[(&str, f64)]) -> Distances {
    measure(&turned(turns_mm), &Protocol::default(), &mut |_| true).unwrap()
}

fn measured_as_drawn(turns_mm: &[(&str, f64)]) -> Distances {
    let drawn = RestPose::of(&turned(turns_mm), RestKind::AsDrawn, &mut |_| true).unwrap();
    measure(&drawn, &Protocol::default(), &mut |_| true).unwrap()
}

fn turned(turns_mm: &[(&str, f64)]) -> Instrument {
    let mut grand = rigid_grand();
    for (screw, by_mm) in turns_mm {
        let screw = grand.screw(screw).unwrap();
        assert!(grand.turn(screw, by_mm * 1e-3));
    }
    grand
}

fn difference(a: Option<f64>, b: Option<f64>) -> f64 {
    a.unwrap() - b.unwrap()
}

/// A zone's line: its point and felt, as the file has them.
fn line(instrument: &Instrument, name: &str) -> ([f64; 2], Felt) {
    let zone = instrument.zones.iter().find(|zone| zone.name == name).unwrap();
    let Curve::Line { point_m, .. } = zone.curve else { panic!("{name} is no line") };
    (point_m, zone.felt)
}

/// Dip: to the punching's line, plus the compression of its felt, by F = k g^r, under a firm 5 N less the force taken
/// by the action (0.3 to 1.1 N); the key's rest is within 0.03 mm of its drawn one.
#[test]
fn dip_is_the_punching_and_its_felt() {
    let (point_m, felt) = line(&rigid_grand(), "key_front");
    let compressed = |force: f64| (force / felt.stiffness).powf(1.0 / felt.exponent);
    let dip_m = measured(&[]).dip_m.unwrap();
    let [least, most] = [compressed(3.9) - 0.03e-3, compressed(4.7) + 0.03e-3].map(|g| g - point_m[1]);
    assert!((least..most).contains(&dip_m), "{least} {dip_m} {most}");
    let thicker = measured(&[("front_punching", 0.5)]).dip_m.unwrap();
    // Punching and finger have the same arm: the dip decreases by the punching's increase, except for the action's
    // share of the 5 N at another depth: 0.3 N more or less are 6 % of the force, and of the felt's compression 6 % /
    // r.
    let breathing = compressed(5.0) * 0.06 / felt.exponent;
    assert!((dip_m - thicker - 0.5e-3).abs() < breathing, "{dip_m} {thicker} {breathing}");
}

/// A slow key does not touch the string: raising it increases blow and let-off equally, and changes nothing else. To
/// the last digit from where the drawing settles; a blow comes back a little later from a higher string.
#[test]
fn the_string_moves_blow_and_let_off_alone() {
    let [before, after] = [&[("drop", 0.6)][..], &[("drop", 0.6), ("string_height", 1.0)]].map(measured_as_drawn);
    assert!((difference(after.blow_m, before.blow_m) - 1e-3).abs() < 1e-9);
    assert!((difference(after.let_off_m, before.let_off_m) - 1e-3).abs() < 1e-9);
    for of in [|d: &Distances| d.dip_m, |d: &Distances| d.drop_m, |d: &Distances| d.aftertouch_m] {
        assert!((difference(of(&after), of(&before))).abs() < 1e-9, "{before:?} {after:?}");
    }
    let [before, after] = [&[("drop", 0.6)][..], &[("drop", 0.6), ("string_height", 1.0)]].map(measured);
    for of in [|d: &Distances| d.blow_m, |d: &Distances| d.let_off_m] {
        assert!((difference(of(&after), of(&before)) - 1e-3).abs() < 5e-5, "{before:?} {after:?}");
    }
}

/// Each turn of the capstan moves the blow of an action that has been played by what the levers make of it: its rise
/// times the hammer's ratio over the key's. From the pose as drawn turns differ by a factor of seven, because the
/// knuckle stays where friction caught it on the way down from the drawing.
#[test]
fn the_blow_follows_the_capstan() {
    const TURN_MM: f64 = 0.05;
    let slopes = |measured: fn(&[(&str, f64)]) -> Distances| {
        let blows: Vec<f64> =
            (-4..=4).map(|k| measured(&[("capstan_height", TURN_MM * f64::from(k))]).blow_m.unwrap()).collect();
        blows.windows(2).map(|two| 1e3 * (two[0] - two[1])).collect::<Vec<f64>>()
    };
    let grand = rigid_grand();
    let (scale, ratio) = on_the_scale(&grand, 6e-3, [1e-3, 5e-3]).unwrap();
    let expected = TURN_MM * ratio.at_rest / scale.key_ratio;
    let (played, drawn) = (slopes(measured), slopes(measured_as_drawn));
    println!("{expected:.3} mm expected; as played {played:.3?}, as drawn {drawn:.3?}");
    assert!(played.iter().all(|slope| (slope / expected - 1.0).abs() < 0.25), "{expected}: {played:?}");
    assert!(drawn.iter().any(|slope| (slope / expected - 1.0).abs() > 0.5), "{expected}: {drawn:?}");
}

/// After let-off the knuckle rests on the lever, and the lever's front on the drop screw, 54 mm from the lever's pivot;
/// the knuckle touches it 37 mm from there, 14.4 mm before the hammer's pin and 138.6 mm of strike point. So the drop
/// grows by 37/54 x 138.6/14.4 = 6.6 mm per mm of screw at rest, less near let-off, where the knuckle's arm is longer
/// (up to 17.7 mm, its whole length: 5.4).
#[test]
fn the_drop_screw_lowers_the_hammer_by_its_levers() {
    let (less, more) = (measured(&[("drop", 0.6)]), measured(&[("drop", 0.8)]));
    let gain = difference(more.drop_m, less.drop_m) / 0.2e-3;
    assert!((5.2..6.7).contains(&gain), "{gain}");
    assert_eq!(measured(&[("drop", -2.0)]).drop_m, Some(0.0), "out of reach, it leaves the hammer up");
}

/// The knuckle's middle and the jack's edge from the file's drawing: the hammer's pin and the shank's direction, and
/// the chain whippen - jack, which is upright. Felts yield a few hundredths. A screw that moves the jack's rest by 0.2
/// mm, 28 mm up from the jack's pivot, moves its top, 45 mm up, by 0.32 mm.
#[test]
fn the_jack_stands_where_it_is_drawn() {
    let grand = rigid_grand();
    let zone = grand.zones.iter().find(|zone| zone.name == "jack_knuckle").unwrap();
    let body = |name: &str| grand.bodies.iter().find(|body| body.name == name).unwrap();
    let (hammer, whippen, jack) = (body("hammer"), body("whippen"), body("jack"));
    let Curve::Segment { to_m, rounding_m, .. } = zone.curve else { panic!("the jack's top ends") };
    let ([a, b], (sin, cos)) = (zone.disc_center_m, hammer.angle_rad.sin_cos());
    let knuckle = hammer.pivot_m[0] + a * cos - b * sin;
    let edge = whippen.pivot_m[0] + jack.pivot_m[0] + to_m[0] + rounding_m;
    let d = measured(&[]);
    assert!((d.jack_position_m.unwrap() - (edge - knuckle)).abs() < 0.1e-3, "{d:?} {}", edge - knuckle);
    let moved = measured(&[("jack_position", 0.2)]);
    let by = difference(moved.jack_position_m, d.jack_position_m);
    assert!((0.25e-3..0.6e-3).contains(&by), "further under the knuckle, and the knuckle a little with it: {by}");
}

/// With the hammer lifted off, the lever rests on its stop alone. Its tail is drawn 20 mm and its contact with the
/// knuckle 37 mm from its pivot: a stop 0.1 mm lower lets the contact rise by 0.185 mm.
#[test]
fn the_lever_rises_as_its_stop_is_lowered() {
    let (before, after) = (measured(&[]), measured(&[("lever_height", 0.1)]));
    let by = difference(after.lever_height_m, before.lever_height_m);
    assert!((by - 0.185e-3).abs() < 0.01e-3, "{by}");
}

/// A stronger spring lifts the hammer faster; a weak one does not lift it at all; a check too far away catches nothing.
#[test]
fn what_does_not_happen_is_none() {
    let mut grand = rigid_grand();
    let spring = grand.screw("repetition_spring").unwrap();
    let speed = |grand: &Instrument| {
        measure(grand, &Protocol::default(), &mut |_| true).unwrap().repetition_spring_m_per_s.unwrap()
    };
    let usual = speed(&grand);
    let torque = grand.springs[0].torque_n_m.abs();
    assert!(grand.turn(spring, 0.1 * torque));
    assert!(speed(&grand) > usual * 1.05);
    assert!(grand.turn(spring, -0.4 * torque));
    assert!(speed(&grand) < 0.01);
    let far = measured(&[("back_check", -4.0)]);
    assert_eq!((far.check_m, far.repetition_rise_m, far.repetition_spring_m_per_s), (None, None, None));
}
