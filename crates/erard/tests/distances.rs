//! The technician's distances against what geometry and felts say without any simulation.

mod common;

use common::grand;
use erard::instrument::Instrument;
use erard::regulation::{Distances, Protocol, measure};

/// The grand with some of its screws turned (mm), measured.
fn measured(turns_mm: &[(&str, f64)]) -> Distances {
    let mut grand = grand();
    for (screw, by_mm) in turns_mm {
        let screw = grand.screw(screw).unwrap();
        assert!(grand.turn(screw, by_mm * 1e-3));
    }
    measure(&grand, &Protocol::default(), &mut || true).unwrap()
}

fn difference(a: Option<f64>, b: Option<f64>) -> f64 {
    a.unwrap() - b.unwrap()
}

/// Dip: the punching lies 9.6 mm down, and a firm 5 N less what the action takes (0.3 to 1 N) compresses its felt by
/// (F / 3e9)^(1/2.5) = 0.27 to 0.31 mm; the key's own rest is within 0.03 mm of its drawn one.
#[test]
fn dip_is_the_punching_and_its_felt() {
    let dip_mm = measured(&[]).dip_m.unwrap() * 1e3;
    assert!((9.84..9.94).contains(&dip_mm), "{dip_mm}");
    let thicker = measured(&[("front_punching", 0.5)]).dip_m.unwrap() * 1e3;
    // Punching and finger have the same arm, so that the dip shrinks by what the punching grows.
    assert!((dip_mm - thicker - 0.5).abs() < 2e-3, "{dip_mm} {thicker}");
}

/// The string is not touched on a slow key: raising it adds as much to blow and let-off, and moves nothing else.
#[test]
fn the_string_moves_blow_and_let_off_alone() {
    let before = measured(&[("drop", 0.3)]);
    let after = measured(&[("drop", 0.3), ("string_height", 1.0)]);
    assert!((difference(after.blow_m, before.blow_m) - 1e-3).abs() < 1e-9);
    assert!((difference(after.let_off_m, before.let_off_m) - 1e-3).abs() < 1e-9);
    for of in [|d: &Distances| d.dip_m, |d: &Distances| d.drop_m, |d: &Distances| d.aftertouch_m] {
        assert!((difference(of(&after), of(&before))).abs() < 1e-9, "{before:?} {after:?}");
    }
}

/// After let-off the knuckle rests on the lever, and the lever's front on the drop screw, 54 mm from the lever's pivot; the
/// knuckle touches it 37 mm from there, 14.4 mm before the hammer's pin and 138.6 mm of strike point. So the drop grows by
/// 37/54 x 138.6/14.4 = 6.6 mm per mm of screw at rest, less near let-off, where the knuckle's arm is longer (up to 17.7 mm,
/// its whole length: 5.4).
#[test]
fn the_drop_screw_lowers_the_hammer_by_its_levers() {
    let (less, more) = (measured(&[("drop", 0.3)]), measured(&[("drop", 0.5)]));
    let gain = difference(more.drop_m, less.drop_m) / 0.2e-3;
    assert!((5.2..6.7).contains(&gain), "{gain}");
    assert_eq!(measured(&[("drop", -1.0)]).drop_m, Some(0.0), "out of reach, it leaves the hammer up");
}

/// As drawn, the knuckle's middle is at 112.43 + 17 cos(19.4388) - 4.8 sin(19.4388) = 126.86 mm and the jack's edge at
/// 205.23 - 77.9 + 1 = 128.33 mm: 1.47 mm. Felts give a few hundredths. The lever is drawn level with the jack, and its tail
/// 0.1 mm above the stop, so that its spring lifts its front by 37/20 x 0.1 mm = 0.19 mm at least, and by what the stop's felt
/// gives to 0.028 N m at 20 mm (1.4 N: 0.12 mm, or 0.22 mm at the front).
#[test]
fn jack_and_lever_stand_where_they_are_drawn() {
    let d = measured(&[]);
    assert!((d.jack_position_m.unwrap() * 1e3 - 1.47).abs() < 0.05, "{d:?}");
    assert!((d.lever_height_m.unwrap() * 1e3 - 0.41).abs() < 0.05, "{d:?}");
    let moved = measured(&[("jack_position", 0.2)]);
    assert!(difference(moved.jack_position_m, d.jack_position_m) > 0.1e-3, "further under the knuckle");
}

/// A stronger spring lifts the hammer faster; a weak one does not lift it at all; a check too far away catches nothing.
#[test]
fn what_does_not_happen_is_none() {
    let mut grand = grand();
    let spring = grand.screw("repetition_spring").unwrap();
    let speed = |grand: &Instrument| measure(grand, &Protocol::default(), &mut || true).unwrap().spring_m_s.unwrap();
    let usual = speed(&grand);
    assert!(grand.turn(spring, 2e-3));
    assert!(speed(&grand) > usual * 1.05);
    assert!(grand.turn(spring, -10e-3));
    assert!(speed(&grand) < 0.01);
    let far = measured(&[("back_check", -3.0)]);
    assert_eq!((far.check_m, far.repetition_rise_m, far.spring_m_s), (None, None, None));
}
