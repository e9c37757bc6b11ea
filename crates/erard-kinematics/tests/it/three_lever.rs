//! The piano's three levers: known numbers, moves, regulation, and where they stop.

use erard_kinematics::linkage::StopKind;
use erard_kinematics::three_lever::{Move, Regulation, Stroke, StrokePose, ThreeLever, ThreeLeverError};

/// A tenth of a millimetre short of let-off for the C7F-like set.
const STROKE: f64 = 0.0081;

fn stroke(levers: ThreeLever, steps: usize) -> Stroke {
    let stroke = levers.assemble().unwrap().stroke(0.0, STROKE, steps);
    assert_eq!(stroke.stop, None);
    stroke
}

fn at(levers: ThreeLever, key: f64) -> StrokePose {
    let stroke = levers.assemble().unwrap().stroke(key, key, 0);
    stroke.poses[0]
}

fn most(stroke: &Stroke, what: fn(&StrokePose) -> f64) -> f64 {
    stroke.poses.iter().map(|pose| what(pose).abs()).fold(0.0, f64::max)
}

/// At rest: k = 90 degrees, w = 0, h = -19.44 degrees, S1 = -142.23, S2 = 79.09 mm,
/// as estimated with the lengths. These were rounded to 0.01 mm, which turns the
/// hammer by 0.01 / 17 rad, 0.03 degrees: hence 0.02 degrees and 0.01 mm.
#[test]
fn rest_pose() {
    let rest = ThreeLever::c7f_like().assemble().unwrap().rest();
    assert!((rest.k.to_degrees() - 90.0).abs() < 1e-12);
    assert!(rest.w.abs() < 1e-12);
    assert!((rest.h.to_degrees() + 19.44).abs() < 0.02, "{}", rest.h.to_degrees());
    assert!((rest.s1 + 0.14223).abs() < 1e-5 && (rest.s2 - 0.07909).abs() < 1e-5);
    assert_eq!((rest.key, rest.capstan_sliding, rest.head_rise), (0.0, 0.0, 0.0));
}

/// An independent solution gave leverage 6.27 / 5.61 / 5.13 / 4.75 at key 1.25 /
/// 3.25 / 5.25 / 7.25 mm. They are the head's *rise* over the key front's travel,
/// in steps of 1 mm centred there: so all four agree to their last digit (0.005).
#[test]
fn leverage_per_millimetre_step() {
    let train = ThreeLever::c7f_like().assemble().unwrap();
    for (key, expected) in [(1.25, 6.27), (3.25, 5.61), (5.25, 5.13), (7.25, 4.75)] {
        let ends = train.stroke((key - 0.5) * 1e-3, (key + 0.5) * 1e-3, 1).poses;
        let leverage = (ends[1].head_rise - ends[0].head_rise) / 1e-3;
        println!("{key} mm: {leverage:.4}");
        assert!((leverage - expected).abs() < 0.005, "{key} mm: {leverage}");
    }
}

/// The instantaneous leverage, from the Jacobian, is within the curvature of a 1 mm
/// step of those numbers (0.003) plus their rounding (0.005).
#[test]
fn leverage_from_the_jacobian() {
    for (key, expected) in [(1.25, 6.27), (3.25, 5.61), (5.25, 5.13), (7.25, 4.75)] {
        let leverage = at(ThreeLever::c7f_like(), key * 1e-3).leverage;
        println!("{key} mm: {leverage:.4}");
        assert!((leverage - expected).abs() < 0.008, "{key} mm: {leverage}");
    }
}

/// Leverage is the derivative of the rise: central differences over 2 x 1 µm err by
/// h² times a third derivative of order 1e5 / m², 1e-7, and by rounding 1e-16 / 1e-6.
#[test]
fn leverage_agrees_with_differences() {
    let train = ThreeLever::c7f_like().assemble().unwrap();
    for i in 1..80 {
        let key = f64::from(i) * 1e-4;
        let poses = train.stroke(key - 1e-6, key + 1e-6, 2).poses;
        let difference = (poses[2].head_rise - poses[0].head_rise) / 2e-6;
        assert!((poses[1].leverage - difference).abs() < 1e-6);
    }
}

/// The capstan slides at most 0.07 mm, the knuckle 0.82 mm (each to its last digit),
/// and both come back before the stroke ends: the contacts cross the lines of centres.
#[test]
fn sliding() {
    let stroke = stroke(ThreeLever::c7f_like(), 200);
    let capstan = most(&stroke, |p| p.capstan_sliding);
    let knuckle = most(&stroke, |p| p.knuckle_sliding);
    println!("capstan {:.4} mm, knuckle {:.4} mm", capstan * 1e3, knuckle * 1e3);
    assert!((capstan - 0.07e-3).abs() < 0.005e-3);
    assert!((knuckle - 0.82e-3).abs() < 0.005e-3);
    assert!(capstan < knuckle / 10.0, "far below");
}

/// Leverage falls through the stroke in all three cases; it is lower with the
/// capstan 10 mm toward the player and higher with the knuckle 3 mm toward the
/// hammer's pivot, at every key position.
#[test]
fn moves_change_the_leverage() {
    let as_is = ThreeLever::c7f_like();
    let moved = |part| as_is.moved(&[part], Regulation::Regulated).unwrap();
    let cases = [as_is, moved(Move::Capstan(-0.010)), moved(Move::Knuckle(-0.003))];
    let [as_is, capstan, knuckle] = cases.map(|levers| stroke(levers, 100));
    for case in [&as_is, &capstan, &knuckle] {
        assert!(case.poses.windows(2).all(|two| two[1].leverage < two[0].leverage));
        assert!(most(case, |p| p.capstan_sliding) < 0.3 * most(case, |p| p.knuckle_sliding));
    }
    for ((as_is, capstan), knuckle) in as_is.poses.iter().zip(&capstan.poses).zip(&knuckle.poses) {
        assert!(capstan.leverage < 0.9 * as_is.leverage);
        assert!(knuckle.leverage > 1.1 * as_is.leverage);
    }
}

/// Regulation keeps the hammer's rest position to rounding (1e-12 rad), whatever was
/// moved; without it a knuckle moved in lets the hammer sink.
#[test]
fn regulation_keeps_the_hammer_at_rest() {
    let as_is = ThreeLever::c7f_like();
    let rest = as_is.assemble().unwrap().rest().h;
    for part in [
        Move::Capstan(-0.010),
        Move::Knuckle(-0.003),
        Move::CapstanHeight(0.001),
        Move::HeelDepth(0.002),
        Move::KnuckleDepth(0.001),
        Move::JackHeight(-0.001),
        Move::WhippenPivot(0.002, -0.001),
        Move::HammerPivot(-0.002, 0.001),
    ] {
        let moved = as_is.moved(&[part], Regulation::Regulated).unwrap();
        let h = moved.assemble().unwrap().rest().h;
        assert!((h - rest).abs() < 1e-12, "{part:?}");
    }
    let sunk = as_is.moved(&[Move::Knuckle(-0.003)], Regulation::AsMoved).unwrap();
    assert_eq!(sunk.lengths.l2, as_is.lengths.l2);
    assert!(sunk.assemble().unwrap().rest().h < rest - 0.05);
}

/// A capstan moved 10 mm along a level heel changes two lever arms by 10 mm each
/// and nothing else: key arm 142.23 to 132.23 mm, heel arm 63 to 73 mm, and the
/// leverage at rest by the product of both, exactly (small angles do not enter).
#[test]
fn capstan_move_changes_two_arms() {
    let as_is = ThreeLever::c7f_like();
    let moved = as_is.moved(&[Move::Capstan(-0.010)], Regulation::Regulated).unwrap();
    let [before, after] = [as_is, moved].map(|levers| levers.assemble().unwrap().rest());
    assert!((after.s1 - before.s1 - 0.010).abs() < 1e-12);
    assert!((moved.lengths.l2 - as_is.lengths.l2).abs() < 1e-12);
    let ratio = (132.23 / 73.0) / (142.23 / 63.0);
    assert!((after.leverage / before.leverage - ratio).abs() < 1e-12);
}

/// The six classical arms at rest are those the lengths were estimated from
/// (Overs: 145/265 x 92.5/65 x 138/20.5 = 5.24) to half a percent, and so the product.
#[test]
fn classical_lever_arms() {
    let levers = ThreeLever::c7f_like();
    let arms = levers.lever_arms(&levers.assemble().unwrap().rest());
    println!("{arms:?} {:.3}", arms.product());
    for (arm, published) in [
        (arms.key_front, 265.0),
        (arms.key_back, 145.0),
        (arms.whippen_heel, 65.0),
        (arms.whippen_jack, 92.5),
        (arms.hammer_knuckle, 20.5),
        (arms.hammer_head, 138.0),
    ] {
        assert!((arm * 1e3 / published - 1.0).abs() < 0.005, "{arm} {published}");
    }
    assert!((arms.product() / 5.24 - 1.0).abs() < 0.01);
}

/// Every pose closes its loops to 1e-12 of the largest length, and one Newton step
/// from the predicted pose is enough at 40 µm of key travel (the work is part of the
/// claim: a Jacobian entry gone wrong would need more).
#[test]
fn residuals_and_work() {
    let stroke = stroke(ThreeLever::c7f_like(), 200);
    let worst = most(&stroke, |p| p.residual);
    println!("worst residual {worst:.1e}");
    assert!(worst < 1e-12);
    assert!(stroke.poses.iter().all(|pose| pose.iterations <= 2));
}

/// Pressed far beyond what the levers can follow, the stroke names the key position
/// where it stops and keeps what it has. The end of reach is where the trigonometric
/// solution has none: 42 whole millimetres can be reached, 42 more micrometres not.
#[test]
fn unreachable_key_position() {
    let train = ThreeLever::c7f_like().assemble().unwrap();
    let stroke = train.stroke(0.0, 0.080, 80);
    let stop = stroke.stop.unwrap();
    println!("at {:.6} mm: {}", stop.key * 1e3, stop.stop);
    assert_eq!(stop.stop.kind, StopKind::Unreachable);
    assert!(stop.key > stroke.poses.last().unwrap().key && stop.key < 0.042);
    assert_eq!(stroke.poses.len(), 42);
    // Just short of it poses exist, just beyond they do not.
    let near = train.stroke(0.0, stop.key - 1e-9, 10);
    assert_eq!(near.stop, None);
    assert!(train.stroke(0.0, stop.key + 1e-9, 10).stop.is_some());
}

/// Let-off at 1.5 mm from the string after a blow of 46 mm: the key position found
/// by driving the hammer is where the key-driven stroke has that rise (1e-12 m).
#[test]
fn key_position_of_a_head_rise() {
    let levers = ThreeLever::c7f_like();
    let key = levers.assemble().unwrap().key_travel_at_rise(0.0445).unwrap();
    println!("let-off at {:.4} mm", key * 1e3);
    assert!((at(levers, key).head_rise - 0.0445).abs() < 1e-12);
    assert!(matches!(levers.assemble().unwrap().key_travel_at_rise(1.0), Err(ThreeLeverError::NoSuchRise(_))));
}

/// Levers that do not reach each other, or a length that is no number, are errors
/// that name the contact or the length.
#[test]
fn bad_levers_are_named() {
    let mut far = ThreeLever::c7f_like();
    far.lengths.l2 = 0.2;
    let error = far.assemble().unwrap_err().to_string();
    assert!(error.contains("capstan contact cannot be made at k = 1.570796"), "{error}");
    let mut missing = ThreeLever::c7f_like();
    missing.lengths.l7 = f64::NAN;
    assert_eq!(missing.assemble().unwrap_err(), ThreeLeverError::NotFinite("L7"));
}
