//! Degrees of freedom, over- and under-constraint: distinguished and explained.

use std::f64::consts::PI;

use crate::common::{add_four_bar, four_bar, slider_crank};
use crate::textbook::{FourBar, SliderCrank};
use erard_kinematics::linkage::{
    AssembleError, Direction, Length, Linkage, LinkageMechanism, Pose, Redundancy, StartError, Verdict,
};

fn pose(mechanism: &LinkageMechanism, values: &[(&str, f64)]) -> Pose {
    let mut pose = mechanism.zero_pose();
    for &(symbol, value) in values {
        pose.set(mechanism.coordinate(symbol).expect(symbol), value);
    }
    pose
}

/// A parallelogram with a third crank, `lean` metres longer than the others.
fn three_cranks(lean: f64) -> Linkage {
    let bar = FourBar { a: 0.1, b: 0.3, c: 0.1, d: 0.3 };
    let mut m = Linkage::new();
    let (bodies, _) = add_four_bar(&mut m, bar);
    let half = m.length("half", 0.15);
    let third = m.length("third", 0.1 + lean);
    let extra = m.body("third crank", "t5");
    let base = m.point(m.ground(), "half way", half, Length::Zero);
    let middle = m.point(bodies[1], "half way along the coupler", half, Length::Zero);
    let end = m.point(extra, "end", third, Length::Zero);
    m.revolute("E", base, m.origin(extra));
    m.revolute("F", end, middle);
    m.prescribe_angle(bodies[0]);
    m
}

/// A parallelogram with a third parallel crank moves although Grübler's count says
/// that it cannot: one equation of the second loop is redundant, and said to be.
/// Its poses are known: the coupler stays level, all cranks turn alike (1e-12).
#[test]
fn over_constrained_but_mobile() {
    let mechanism = three_cranks(0.0).assemble().unwrap();
    let at = |t: f64| pose(&mechanism, &[("t2", t), ("t4", t), ("t5", t)]);
    let mobility = mechanism.mobility(&at(1.0));
    assert_eq!(mobility.grubler, 0);
    assert_eq!(mobility.degrees_of_freedom, 1);
    assert!(mobility.over_constrained());
    assert_eq!(mobility.verdict(), Verdict::Determined);
    assert!(matches!(mobility.redundant.as_slice(), [Redundancy::Equation { circuit: 2, .. }]));
    let words = mobility.to_string();
    println!("{words}");
    assert!(words.contains("Over-constrained: equation (4), y of loop 2"), "{words}");

    let mut walk = mechanism.walk(at(0.5)).unwrap();
    for i in 0..=20 {
        let t = 0.5 + 0.1 * f64::from(i);
        walk.advance(&[t]).unwrap();
        for (symbol, exact) in [("t3", 0.0), ("t4", t), ("t5", t)] {
            let ours = walk.pose().value(mechanism.coordinate(symbol).unwrap());
            assert!((ours - exact).abs() < 1e-12, "{symbol} = {ours} at {t}");
        }
        assert!(walk.rates(&[1.0])[3] - 1.0 < 1e-12);
    }
}

/// The same with a third crank 5 mm too long does not fit at the prescribed angle:
/// no pose, instead of a compromise.
#[test]
fn over_constrained_and_contradictory() {
    let mechanism = three_cranks(0.005).assemble().unwrap();
    let guess = pose(&mechanism, &[("t2", 1.0), ("t4", 1.0), ("t5", 1.0)]);
    let error = mechanism.walk(guess).unwrap_err();
    println!("{error}");
    assert!(matches!(error, StartError::NoPose(report) if report.residual > 1e-4));
}

/// A five-bar has two degrees of freedom; with one prescribed it is under-constrained,
/// the free coordinate is named, and prescribing a second one cures it.
#[test]
fn under_constrained() {
    let five_bar = |drives: usize| {
        let mut m = Linkage::new();
        let l = m.length("l", 0.2);
        let d = m.length("d", 0.3);
        let bars: Vec<_> = ["p", "q", "r", "s"].iter().map(|s| m.body(s, s)).collect();
        let ends: Vec<_> = bars.iter().map(|&b| m.point(b, "end", l, Length::Zero)).collect();
        let far = m.point(m.ground(), "far", d, Length::Zero);
        m.revolute("A", m.origin(m.ground()), m.origin(bars[0]));
        m.revolute("B", ends[0], m.origin(bars[1]));
        m.revolute("C", ends[1], ends[2]);
        m.revolute("D", m.origin(bars[2]), ends[3]);
        m.revolute("E", far, m.origin(bars[3]));
        for &bar in [bars[0], bars[3]].iter().take(drives) {
            m.prescribe_angle(bar);
        }
        m.assemble().unwrap()
    };
    let guess = [("p", 1.3), ("q", 1.0), ("r", PI - 1.0), ("s", PI - 1.3)];

    let one = five_bar(1);
    let StartError::NotDetermined(mobility) = one.walk(pose(&one, &guess)).unwrap_err() else {
        panic!("a pose exists, it is only not determined");
    };
    println!("{mobility}");
    assert_eq!(mobility.verdict(), Verdict::UnderConstrained);
    assert_eq!((mobility.degrees_of_freedom, mobility.free.as_slice()), (2, &["q".to_owned()][..]));
    assert!(!mobility.over_constrained());
    assert!(mobility.to_string().contains("with p prescribed, q can still be chosen freely"));

    let two = five_bar(2);
    let mut walk = two.walk(pose(&two, &guess)).unwrap();
    walk.advance(&[1.4, PI - 1.5]).unwrap();
    assert!(two.residual(walk.pose()) < 1e-12);
}

/// Crank and rocker both prescribed: over-driven, and the excess drive is named.
#[test]
fn over_driven() {
    let bar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };
    let mut built = four_bar(bar);
    built.linkage.prescribe_angle(built.bodies[0]);
    built.linkage.prescribe_angle(built.bodies[2]);
    let mechanism = built.linkage.assemble().unwrap();
    let exact = bar.pose(1.0, 1.0).unwrap();
    let guess = pose(&mechanism, &[("t2", 1.0), ("t3", exact.t3), ("t4", exact.t4)]);
    let mobility = mechanism.mobility(&guess);
    println!("{mobility}");
    assert_eq!(mobility.verdict(), Verdict::OverDriven);
    assert_eq!(mobility.excess, ["t4"]);
    assert!(matches!(mechanism.walk(guess), Err(StartError::NotDetermined(_))));
}

/// A slider-crank at its dead centre, driven by the slider: the counts are right but
/// the pose is singular. Driven by the crank, the same pose is a pose like any other.
#[test]
fn dead_centre_depends_on_the_drive() {
    let exact = SliderCrank { r: 0.1, l: 0.27, e: 0.0 };
    let mut by_slider = slider_crank(exact);
    by_slider.linkage.prescribe_sliding(by_slider.slide.unwrap());
    let by_slider = by_slider.linkage.assemble().unwrap();
    let at = |m: &LinkageMechanism| pose(m, &[("t", 0.0), ("p", 0.0), ("x", 0.37)]);
    let mobility = by_slider.mobility(&at(&by_slider));
    println!("{mobility}");
    assert_eq!(mobility.verdict(), Verdict::Singular);
    assert_eq!(mobility.degrees_of_freedom, 1);

    let mut by_crank = slider_crank(exact);
    by_crank.linkage.prescribe_angle(by_crank.bodies[0]);
    let by_crank = by_crank.linkage.assemble().unwrap();
    assert_eq!(by_crank.mobility(&at(&by_crank)).verdict(), Verdict::Determined);
}

/// Two wedges between floor and wall: three prismatic joints whose constant angles
/// repeat each other. Mobile, and the repeated angle is reported.
#[test]
fn wedges_repeat_an_angle() {
    let wedges = |misfit: f64| {
        let mut m = Linkage::new();
        let slope = m.angle("slope", 0.3);
        let shim = m.angle("shim", misfit);
        let low = m.slider("lower wedge");
        let high = m.slider("upper wedge");
        let low_at = m.prismatic("floor", "x", m.origin(m.ground()), Direction::X, m.origin(low));
        m.prismatic("slope face", "s", m.origin(low), slope, m.origin(high));
        m.prismatic_turned("wall", "y", m.origin(m.ground()), Direction::Y, m.origin(high), shim);
        m.prescribe_sliding(low_at);
        m.assemble()
    };
    let mechanism = wedges(0.0).unwrap();
    let mut walk = mechanism.walk(mechanism.zero_pose()).unwrap();
    let mobility = mechanism.mobility(walk.pose());
    println!("{mobility}");
    assert_eq!((mobility.grubler, mobility.degrees_of_freedom), (0, 1));
    assert!(matches!(mobility.redundant.as_slice(), [Redundancy::Angle { .. }]));
    // The lower wedge pushed by x lifts the upper one by -x tan(slope).
    walk.advance(&[-0.02]).unwrap();
    let y = walk.pose().value(mechanism.coordinate("y").unwrap());
    assert!((y - 0.02 * 0.3f64.tan()).abs() < 1e-15);

    assert!(matches!(wedges(0.01), Err(AssembleError::ContradictoryAngles(_))));
}

/// What is wrong with the data is said in the user's names.
#[test]
fn bad_data_is_named() {
    let bar = FourBar { a: 0.1, b: 0.25, c: f64::NAN, d: 0.35 };
    let error = four_bar(bar).linkage.assemble().unwrap_err();
    assert_eq!(error.to_string(), "the constant c is not a finite number");

    let mut loose = four_bar(FourBar { c: 0.3, ..bar }).linkage;
    loose.body("idler", "t9");
    let error = loose.assemble().unwrap_err();
    assert!(error.to_string().contains("body `idler` is not connected to the ground"), "{error}");

    let mut twice = four_bar(FourBar { c: 0.3, ..bar }).linkage;
    twice.length("t2", 0.1);
    assert_eq!(twice.assemble().unwrap_err(), AssembleError::RepeatedSymbol("t2".into()));

    let mut ground = four_bar(FourBar { c: 0.3, ..bar }).linkage;
    ground.prescribe_angle(ground.ground());
    assert_eq!(ground.assemble().unwrap_err(), AssembleError::NotACoordinate("ground".into()));
}
