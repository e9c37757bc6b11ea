//! Newton-Raphson on generated equations against textbook solutions.

use std::f64::consts::PI;

use crate::common::{add_four_bar, angle_error, four_bar, slider_crank};
use crate::textbook::{FourBar, SliderCrank};
use erard_kinematics::linkage::{Direction, Length, Linkage, LinkageMechanism, Pose};

fn pose(mechanism: &LinkageMechanism, values: &[(&str, f64)]) -> Pose {
    let mut pose = mechanism.zero_pose();
    for &(symbol, value) in values {
        pose.set(mechanism.coordinate(symbol).expect(symbol), value);
    }
    pose
}

fn get(mechanism: &LinkageMechanism, pose: &Pose, symbol: &str) -> f64 {
    pose.value(mechanism.coordinate(symbol).expect(symbol))
}

const CRANK_ROCKER: FourBar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };

/// Walks a four-bar through a whole turn of its crank and returns the largest
/// error of any angle (rad) and the largest relative error of any rate.
fn four_bar_errors(bar: FourBar, side: f64, steps: u32) -> (f64, f64) {
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    let first = bar.pose(0.0, side).unwrap();
    let guess = pose(&mechanism, &[("t3", first.t3 + 0.02), ("t4", first.t4 - 0.02)]);
    let mut walk = mechanism.walk(guess).unwrap();
    let turn = (0..=steps).map(|i| 2.0 * PI * f64::from(i) / f64::from(steps));
    let sweep = walk.sweep(turn.clone());
    assert_eq!(sweep.stop, None);
    let (mut angle, mut rate): (f64, f64) = (0.0, 0.0);
    for (t2, swept) in turn.zip(&sweep.poses) {
        assert!(swept.report.residual < 1e-12);
        let exact = bar.pose(t2, side).unwrap();
        let (d3, d4) = bar.rates(t2, exact);
        angle = angle
            .max(angle_error(get(&mechanism, &swept.pose, "t3"), exact.t3))
            .max(angle_error(get(&mechanism, &swept.pose, "t4"), exact.t4));
        rate = rate
            .max((swept.rates[1] - d3).abs() / (1.0 + d3.abs()))
            .max((swept.rates[2] - d4).abs() / (1.0 + d4.abs()));
    }
    (angle, rate)
}

/// A crank-rocker through a full turn, on both branches, follows the intersection
/// of circles. Both round at 1e-16 times a condition number near 10: 1e-12 leaves
/// three digits to spare.
#[test]
fn four_bar_follows_the_circles() {
    for side in [1.0, -1.0] {
        let (angle, rate) = four_bar_errors(CRANK_ROCKER, side, 360);
        println!("side {side}: angles {angle:.1e} rad, rates {rate:.1e}");
        assert!(angle < 1e-12 && rate < 1e-12, "{angle:.1e} {rate:.1e}");
    }
}

/// Any crank-rocker that stays clear of its change points, in steps of 18
/// degrees, coarse for a prediction along the tangent. The sine of
/// the transmission angle stays above 0.2, which keeps the condition number
/// below about 100 and 1e-12 fair.
#[test]
fn any_crank_rocker() {
    let mut random = fastrand::Rng::with_seed(1);
    let mut tried = 0;
    while tried < 256 {
        let mut within = |least: f64, most: f64| least + (most - least) * random.f64();
        let bar = FourBar { a: within(0.05, 0.15), b: within(0.2, 0.6), c: within(0.2, 0.6), d: within(0.2, 0.6) };
        let FourBar { a, b, c, d } = bar;
        let clear = [d - a, d + a].iter().all(|reach| {
            let cosine = (b * b + c * c - reach * reach) / (2.0 * b * c);
            cosine.abs() < 0.98
        });
        if !clear {
            continue;
        }
        tried += 1;
        for side in [1.0, -1.0] {
            let (angle, rate) = four_bar_errors(bar, side, 20);
            assert!(angle < 1e-12 && rate < 1e-11, "{a} {b} {c} {d}: {angle:.1e} {rate:.1e}");
        }
    }
}

/// A slider-crank through a full turn, in line and offset, follows its closed form
/// to 1e-12 rad and m; the slider's rate per radian as well.
#[test]
fn slider_crank_follows_its_closed_form() {
    for e in [0.0, 0.03, -0.05] {
        let exact = SliderCrank { r: 0.1, l: 0.27, e };
        let mut built = slider_crank(exact);
        built.linkage.prescribe_angle(built.bodies[0]);
        let mechanism = built.linkage.assemble().unwrap();
        let (p, x) = exact.pose(0.0).unwrap();
        let mut walk = mechanism.walk(pose(&mechanism, &[("p", p), ("x", x)])).unwrap();
        let turn = (0..=100).map(|i| 2.0 * PI * f64::from(i) / 100.0);
        let sweep = walk.sweep(turn.clone());
        assert_eq!(sweep.poses.len(), 101);
        for (t, swept) in turn.zip(&sweep.poses) {
            let (p, x) = exact.pose(t).unwrap();
            assert!(angle_error(get(&mechanism, &swept.pose, "p"), p) < 1e-12);
            assert!((get(&mechanism, &swept.pose, "x") - x).abs() < 1e-12);
            assert!((swept.rates[2] - exact.slider_rate(t).unwrap()).abs() < 1e-12);
        }
    }
}

/// The same linkage driven by its slider gives the same poses: which coordinate
/// is prescribed is a matter of data. (Away from the dead centres, to 1e-12.)
#[test]
fn slider_crank_driven_by_its_slider() {
    let exact = SliderCrank { r: 0.1, l: 0.27, e: 0.0 };
    let mut built = slider_crank(exact);
    built.linkage.prescribe_sliding(built.slide.unwrap());
    let mechanism = built.linkage.assemble().unwrap();
    let (p, x) = exact.pose(0.5).unwrap();
    let mut walk = mechanism.walk(pose(&mechanism, &[("t", 0.5), ("p", p), ("x", x)])).unwrap();
    for i in 0..=20 {
        let t = 0.5 + 0.1 * f64::from(i);
        let (p, x) = exact.pose(t).unwrap();
        walk.advance(&[x]).unwrap();
        assert!(angle_error(get(&mechanism, walk.pose(), "t"), t) < 1e-12);
        assert!(angle_error(get(&mechanism, walk.pose(), "p"), p) < 1e-12);
    }
}

/// Watt's second six-bar: two four-bars in series share a ternary rocker, so its
/// closed form is the four-bar's, twice. Angles to 1e-12.
#[test]
fn six_bar_with_two_loops_sharing_a_body() {
    let first = CRANK_ROCKER;
    // The rocker's second arm lags by 90 degrees; the second ground pivot is level.
    let second = FourBar { a: 0.12, b: 0.3, c: 0.25, d: 0.33 };
    let mut m = Linkage::new();
    let (bodies, middle) = add_four_bar(&mut m, first);
    let [p, e, f, g] =
        [("p", second.a), ("e", second.b), ("f", second.c), ("g", second.d)].map(|(n, v)| m.length(n, v));
    let link = m.body("link", "t5");
    let output = m.body("output", "t6");
    let elbow = m.point(bodies[2], "elbow", Length::Zero, -p);
    let end = m.point(link, "end", e, Length::Zero);
    let toe = m.point(output, "toe", f, Length::Zero);
    let far = m.point_from(middle, "far again", g, Length::Zero);
    m.revolute("E", elbow, m.origin(link));
    m.revolute("F", end, toe);
    m.revolute("G", far, m.origin(output));
    m.prescribe_angle(bodies[0]);
    let mechanism = m.assemble().unwrap();
    assert_eq!(mechanism.closures().len(), 2);

    let exact = |t2: f64| {
        let one = first.pose(t2, 1.0)?;
        let two = second.pose(one.t4 - PI / 2.0, 1.0)?;
        Some([one.t3, one.t4, two.t3, two.t4])
    };
    let [t3, t4, t5, t6] = exact(0.0).unwrap();
    let guess = pose(&mechanism, &[("t3", t3), ("t4", t4), ("t5", t5), ("t6", t6)]);
    let mut walk = mechanism.walk(guess).unwrap();
    assert_eq!(mechanism.mobility(walk.pose()).degrees_of_freedom, 1);
    for i in 0..=200 {
        let t2 = 2.0 * PI * f64::from(i) / 200.0;
        walk.advance(&[t2]).unwrap();
        assert!(walk.report().residual < 1e-12);
        for (symbol, exact) in ["t3", "t4", "t5", "t6"].iter().zip(exact(t2).unwrap()) {
            let ours = get(&mechanism, walk.pose(), symbol);
            assert!(angle_error(ours, exact) < 1e-12, "{symbol} at {t2}");
        }
    }
}

/// A Scotch yoke, with two prismatic joints in one loop: the yoke moves as the
/// cosine of the crank, exactly. 1e-15 m is the rounding of one product.
#[test]
fn scotch_yoke_is_a_cosine() {
    let mut m = Linkage::new();
    let r = m.length("r", 0.1);
    let crank = m.body("crank", "t");
    let block = m.slider("block");
    let yoke = m.slider("yoke");
    let tip = m.point(crank, "tip", r, Length::Zero);
    m.revolute("main", m.origin(m.ground()), m.origin(crank));
    m.revolute("pin", tip, m.origin(block));
    m.prismatic("slot", "y", m.origin(yoke), Direction::Y, m.origin(block));
    m.prismatic("guide", "x", m.origin(m.ground()), Direction::X, m.origin(yoke));
    m.prescribe_angle(crank);
    let mechanism = m.assemble().unwrap();
    let printed: Vec<String> = mechanism.equations().iter().map(ToString::to_string).collect();
    assert_eq!(printed, ["r cos t - x = 0", "r sin t - y = 0"]);
    let mut walk = mechanism.walk(mechanism.zero_pose()).unwrap();
    for i in 0..=60 {
        let t = 0.1 * f64::from(i);
        walk.advance(&[t]).unwrap();
        assert!((get(&mechanism, walk.pose(), "x") - 0.1 * t.cos()).abs() < 1e-15);
        let (rates, accelerations) = walk.rates_and_accelerations(&[1.0]);
        // Coordinates: t, y, x.
        assert!((rates[2] + 0.1 * t.sin()).abs() < 1e-15);
        assert!((accelerations[2] + 0.1 * t.cos()).abs() < 1e-15);
    }
}

/// First and second derivatives from the Jacobian agree with central differences
/// of the poses. With a step of 1e-4 rad these err by h²/6 times a third derivative
/// of order 10 (2e-8), the second ones also by rounding 1e-16/h² (1e-8): 1e-6 covers both.
#[test]
fn derivatives_agree_with_differences() {
    let mut built = four_bar(CRANK_ROCKER);
    built.linkage.prescribe_angle(built.bodies[0]);
    let mechanism = built.linkage.assemble().unwrap();
    let first = CRANK_ROCKER.pose(0.0, 1.0).unwrap();
    let guess = pose(&mechanism, &[("t3", first.t3), ("t4", first.t4)]);
    let mut walk = mechanism.walk(guess).unwrap();
    let step = 1e-4;
    for i in 0..60 {
        let t2 = 0.1 * f64::from(i);
        let mut at = |t: f64| {
            walk.advance(&[t]).unwrap();
            walk.pose().values().to_vec()
        };
        let (before, here, after) = (at(t2 - step), at(t2), at(t2 + step));
        walk.advance(&[t2]).unwrap();
        let (rates, accelerations) = walk.rates_and_accelerations(&[1.0]);
        for j in 0..3 {
            let first = (after[j] - before[j]) / (2.0 * step);
            let second = (after[j] - 2.0 * here[j] + before[j]) / (step * step);
            assert!((rates[j] - first).abs() < 1e-6, "{} {first}", rates[j]);
            assert!((accelerations[j] - second).abs() < 1e-6, "{} {second}", accelerations[j]);
        }
    }
}

/// A point's velocity through the Jacobian is that of its differences, and the
/// joint between coupler and rocker is one place seen from both. Differences err
/// by 1e-9, positions by rounding.
#[test]
fn points_move_as_their_bodies_do() {
    let mut built = four_bar(CRANK_ROCKER);
    built.linkage.prescribe_angle(built.bodies[0]);
    let c = built.linkage.joints()[2].clone();
    let mechanism = built.linkage.assemble().unwrap();
    let first = CRANK_ROCKER.pose(0.7, 1.0).unwrap();
    let guess = pose(&mechanism, &[("t2", 0.7), ("t3", first.t3), ("t4", first.t4)]);
    let mut walk = mechanism.walk(guess).unwrap();
    let rates = walk.rates(&[1.0]).to_vec();
    let here = walk.pose().clone();
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    assert!(gap(mechanism.position(&here, c.a), mechanism.position(&here, c.b)) < 1e-15);
    let velocity = mechanism.velocity(&here, &rates, c.a);
    assert!(gap(velocity, mechanism.velocity(&here, &rates, c.b)) < 1e-15);
    let step = 1e-5;
    walk.advance(&[0.7 + step]).unwrap();
    let after = mechanism.position(walk.pose(), c.a);
    walk.advance(&[0.7 - step]).unwrap();
    let before = mechanism.position(walk.pose(), c.a);
    let difference = [0, 1].map(|i| (after[i] - before[i]) / (2.0 * step));
    assert!(gap(velocity, difference) < 1e-9);
}
