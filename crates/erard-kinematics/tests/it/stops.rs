//! Singular and unreachable poses: located, named, and never a wrong answer.

use std::f64::consts::PI;

use crate::common::{angle_error, four_bar, slider_crank};
use crate::textbook::{FourBar, SliderCrank};
use erard_kinematics::linkage::{LinkageMechanism, Pose, StartError, StopKind};

fn pose(mechanism: &LinkageMechanism, values: &[(&str, f64)]) -> Pose {
    let mut pose = mechanism.zero_pose();
    for &(symbol, value) in values {
        pose.set(mechanism.coordinate(symbol).expect(symbol), value);
    }
    pose
}

/// A slider pushed past the dead centre of its crank stops at r + l. The pose is
/// solved to 1e-14 of the largest length, the bisection ends at 1e-14 of the way:
/// 1e-12 m is a hundred times both.
#[test]
fn slider_stops_at_the_dead_centre() {
    let exact = SliderCrank { r: 0.1, l: 0.27, e: 0.0 };
    let mut built = slider_crank(exact);
    built.linkage.prescribe_sliding(built.slide.unwrap());
    let mechanism = built.linkage.assemble().unwrap();
    let (p, x) = exact.pose(1.0).unwrap();
    let mut walk = mechanism.walk(pose(&mechanism, &[("t", 1.0), ("p", p), ("x", x)])).unwrap();
    let sweep = walk.sweep((0..=10).map(|i| x + 0.01 * f64::from(i)));
    let stop = sweep.stop.unwrap();
    println!("{stop}; off by {:.1e} m", stop.at[0].1 - 0.37);
    assert_eq!(stop.kind, StopKind::Unreachable);
    assert_eq!(stop.at[0].0, "x");
    assert!((stop.at[0].1 - 0.37).abs() < 1e-12);
    // What could be computed is kept, and right.
    assert_eq!(sweep.poses.len(), ((0.37 - x) / 0.01) as usize + 1);
    for swept in &sweep.poses {
        let t = swept.pose.value(mechanism.coordinate("t").unwrap());
        let (_, x) = exact.pose(t).unwrap();
        assert!((x - swept.pose.value(mechanism.coordinate("x").unwrap())).abs() < 1e-12);
        assert!(t > 0.0, "never beyond the dead centre");
    }
}

/// A double rocker stops where coupler and rocker are in line: within 1e-12 rad of
/// the law of cosines, on both branches.
#[test]
fn four_bar_stops_at_its_toggle() {
    let bar = FourBar { a: 0.3, b: 0.2, c: 0.25, d: 0.35 };
    let limit = bar.dead_centres()[0].unwrap();
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    for side in [1.0, -1.0] {
        let exact = bar.pose(0.8, side).unwrap();
        let guess = pose(&mechanism, &[("t2", 0.8), ("t3", exact.t3), ("t4", exact.t4)]);
        let mut walk = mechanism.walk(guess).unwrap();
        let stop = walk.advance(&[PI]).unwrap_err();
        println!("{stop}; off by {:.1e} rad", stop.at[0].1 - limit);
        assert_eq!(stop.kind, StopKind::Unreachable);
        assert!((stop.at[0].1 - limit).abs() < 1e-12);
        // The walk stands at the last good pose and can go back, on its own branch.
        walk.advance(&[0.8]).unwrap();
        assert!(angle_error(walk.pose().values()[1], exact.t3) < 1e-12);
    }
}

/// A parallelogram folded flat may open as a parallelogram or as an
/// anti-parallelogram: a singular pose, at exactly half a turn. Steps of 0.1 rad
/// jump over it; the changed sign of the determinant gives it away. The two
/// branches part by an angle that grows with the distance, so it is located
/// to the root of rounding at worst; 1e-7 rad is asked.
#[test]
fn parallelogram_stops_at_its_change_point() {
    let bar = FourBar { a: 0.1, b: 0.3, c: 0.1, d: 0.3 };
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    let mut walk = mechanism.walk(pose(&mechanism, &[("t2", 1.0), ("t4", 1.0)])).unwrap();
    let sweep = walk.sweep((0..40).map(|i| 1.0 + 0.1 * f64::from(i)));
    let stop = sweep.stop.unwrap();
    println!("{stop}; off by {:.1e} rad", stop.at[0].1 - PI);
    assert_eq!(stop.kind, StopKind::Singular);
    assert!((stop.at[0].1 - PI).abs() < 1e-7);
    assert_eq!(sweep.poses.len(), 22);
    for swept in &sweep.poses {
        let [t2, t3, t4] = [0, 1, 2].map(|i| swept.pose.values()[i]);
        assert!(t3.abs() < 1e-12 && (t4 - t2).abs() < 1e-12);
    }
}

/// A first guess for which no pose exists is an error with its residual, and so is
/// one that is not a number.
#[test]
fn no_first_pose() {
    let bar = FourBar { a: 0.1, b: 0.1, c: 0.1, d: 0.5 };
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    for start in [1.0, f64::NAN] {
        let error = mechanism.walk(pose(&mechanism, &[("t2", start)])).unwrap_err();
        println!("{error}");
        assert!(matches!(error, StartError::NoPose(_)));
    }
}

/// A target that is not a number moves nothing and does not spread.
#[test]
fn not_a_number_is_contained() {
    let bar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    let exact = bar.pose(1.0, 1.0).unwrap();
    let guess = pose(&mechanism, &[("t2", 1.0), ("t3", exact.t3), ("t4", exact.t4)]);
    let mut walk = mechanism.walk(guess).unwrap();
    let before = walk.pose().clone();
    let stop = walk.advance(&[f64::NAN]).unwrap_err();
    assert_eq!((stop.kind, stop.at[0].1), (StopKind::NoConvergence, 1.0));
    assert_eq!(walk.pose(), &before);
    walk.advance(&[1.1]).unwrap();
}

/// Newton-Raphson converges quadratically: each relative residual is at most a
/// constant times the square of the one before, down to rounding. For these
/// lengths the constant (half the second derivative over the smallest singular
/// value, squared) is below 10; an error in one entry of the Jacobian would make
/// convergence linear and break it.
#[test]
fn convergence_is_quadratic() {
    let bar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    let exact = bar.pose(1.0, 1.0).unwrap();
    let guess = pose(&mechanism, &[("t2", 1.0), ("t3", exact.t3 + 0.3), ("t4", exact.t4 - 0.3)]);
    let walk = mechanism.walk(guess).unwrap();
    let history = walk.residual_history();
    println!("{history:?}");
    assert!(history.len() <= 6);
    let before_rounding = history.windows(2).filter(|pair| pair[0] > 1e-7);
    assert!(before_rounding.clone().count() >= 3);
    for pair in before_rounding {
        assert!(pair[1] < 10.0 * pair[0] * pair[0], "{history:?}");
    }
}

/// A step over most of a turn is halved until it can be followed, and arrives where
/// small steps arrive (1e-12 rad).
#[test]
fn large_steps_are_halved() {
    let bar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    let exact = bar.pose(0.0, -1.0).unwrap();
    let guess = pose(&mechanism, &[("t3", exact.t3), ("t4", exact.t4)]);
    let mut walk = mechanism.walk(guess).unwrap();
    walk.advance(&[6.0]).unwrap();
    let exact = bar.pose(6.0, -1.0).unwrap();
    assert!(angle_error(walk.pose().values()[1], exact.t3) < 1e-12);
    assert!(angle_error(walk.pose().values()[2], exact.t4) < 1e-12);
}
