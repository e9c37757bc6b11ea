//! The closure equations are derived, not written down: from the graph of any
//! linkage, with the user's own names.

use std::collections::BTreeSet;

use erard_kinematics::linkage::{Direction, Equation, Length, Linkage, LinkageMechanism, latex_align};
use erard_kinematics::three_lever::{Drive, ThreeLever};

fn printed(mechanism: &LinkageMechanism) -> Vec<String> {
    mechanism.equations().iter().map(Equation::to_string).collect()
}

/// The signed terms of `a + b - c = 0` as a set, signs relative to the first of
/// the alphabet: two prints are equal here if they state the same equation.
fn terms(equation: &str) -> BTreeSet<String> {
    let sum = equation.strip_suffix(" = 0").expect("ends in = 0");
    let mut signed = Vec::new();
    let mut sign = '+';
    for word in sum.replace(" + ", " |+|").replace(" - ", " |-|").split('|') {
        match word.trim() {
            "+" => sign = '+',
            "-" => sign = '-',
            term => signed.push((term.to_owned(), sign)),
        }
    }
    let (_, first) = signed.iter().min().expect("not empty").clone();
    signed.iter().map(|(term, sign)| format!("{}{term}", if *sign == first { '+' } else { '-' })).collect()
}

/// Equations (1) to (4) of the kinematic model, as its readers know them.
const PAPER: [&str; 4] = [
    "L2 cos k - L3 cos w - L4 sin w - S1 sin k - L1 = 0",
    "L2 sin k - L3 sin w + L4 cos w + S1 cos k - L5 = 0",
    "L8 cos h - L7 sin w + L9 sin h + S2 cos w - L6 = 0",
    "L8 sin h + L7 cos w - L9 cos h + S2 sin w + L10 = 0",
];

/// The program derives the paper's four equations from the piano's linear graph,
/// term by term and sign by sign, whatever the order.
#[test]
fn three_levers_give_the_papers_equations() {
    let mechanism = ThreeLever::c7f_like().linkage(Drive::Key).assemble().unwrap();
    let ours = printed(&mechanism);
    assert_eq!(ours.len(), 4);
    for (ours, paper) in ours.iter().zip(PAPER) {
        assert_eq!(terms(ours), terms(paper));
        assert_eq!(terms(ours).len(), 5);
    }
}

/// The tree takes the five pins, so each loop is closed by the sliding joint whose
/// coordinate it brings in, and passes two levers and the ground.
#[test]
fn the_slides_are_the_chords() {
    let mechanism = ThreeLever::c7f_like().linkage(Drive::Key).assemble().unwrap();
    let linkage = mechanism.linkage();
    let loops: Vec<(&str, Vec<&str>)> = (mechanism.closures().iter())
        .map(|closure| {
            let chord = &linkage.joints()[closure.chord.index()];
            let bodies = closure.bodies.iter();
            let names = bodies.map(|body| linkage.bodies()[body.index()].name.as_str());
            (chord.name.as_str(), names.collect())
        })
        .collect();
    assert_eq!(
        loops,
        [
            ("capstan slide", vec!["ground", "key", "capstan slider", "whippen"]),
            ("knuckle slide", vec!["ground", "whippen", "knuckle slider", "hammer"]),
        ]
    );
    let graph = mechanism.graph();
    assert_eq!(graph.chords().count(), 2);
    // Nodes less one: the branches of a spanning tree.
    assert_eq!(graph.edges().len() - 2, linkage.points().len() - 1);
}

/// They even come out in the paper's order, from the general ordering rule.
#[test]
fn three_levers_print_in_the_papers_order() {
    let mechanism = ThreeLever::c7f_like().linkage(Drive::Key).assemble().unwrap();
    assert_eq!(printed(&mechanism), PAPER);
    assert_eq!(
        latex_align(mechanism.equations()).lines().nth(4).unwrap(),
        r"  L_{8} \sin h + L_{7} \cos w - L_{9} \cos h + S_{2} \sin w + L_{10} &= 0"
    );
}

/// The comparison above can fail: one turned sign is noticed.
#[test]
fn a_turned_sign_is_noticed() {
    let turned = PAPER[0].replace("- S1", "+ S1");
    assert_ne!(terms(&turned), terms(PAPER[0]));
}

/// The text follows the data: renamed and mirrored levers give renamed and
/// mirrored equations.
#[test]
fn the_text_comes_from_the_graph() {
    let mut m = Linkage::new();
    let [arm, lift] = [m.length("arm", 0.1), m.length("lift", 0.02)];
    let pin = m.length("pin", 0.3);
    let lever = m.body("lever", "alpha");
    let plate = m.body("plate", "beta");
    let at = m.point(m.ground(), "at", pin, Length::Zero);
    m.revolute("left", m.origin(m.ground()), m.origin(lever));
    m.revolute("right", at, m.origin(plate));
    let edge = m.point(lever, "edge", Length::Zero, -lift);
    let nose = m.point(plate, "nose", -arm, Length::Zero);
    m.contact("touch", "slip", edge, Direction::X, nose);
    m.prescribe_angle(lever);
    let mechanism = m.assemble().unwrap();
    assert_eq!(
        printed(&mechanism),
        [
            "arm cos beta + lift sin alpha + slip cos alpha - pin = 0",
            "arm sin beta - lift cos alpha + slip sin alpha = 0",
        ]
    );
    assert_eq!(
        mechanism.equations()[0].latex(),
        r"\mathrm{arm} \cos \beta + \mathrm{lift} \sin \alpha + \mathrm{slip} \cos \alpha - \mathrm{pin} = 0"
    );
}

/// A four-bar gives the textbook's loop equation.
#[test]
fn four_bar() {
    let mut m = Linkage::new();
    let [a, b, c, d] = [("a", 0.1), ("b", 0.25), ("c", 0.3), ("d", 0.35)].map(|(n, v)| m.length(n, v));
    let [crank, coupler, rocker] = [("crank", "t2"), ("coupler", "t3"), ("rocker", "t4")].map(|(n, s)| m.body(n, s));
    let [tip, joint, knee] =
        [(crank, a), (coupler, b), (rocker, c)].map(|(body, length)| m.point(body, "end", length, Length::Zero));
    let far = m.point(m.ground(), "far", d, Length::Zero);
    m.revolute("A", m.origin(m.ground()), m.origin(crank));
    m.revolute("B", tip, m.origin(coupler));
    m.revolute("C", joint, knee);
    m.revolute("D", far, m.origin(rocker));
    m.prescribe_angle(crank);
    let mechanism = m.assemble().unwrap();
    assert_eq!(printed(&mechanism), ["a cos t2 + b cos t3 - c cos t4 - d = 0", "a sin t2 + b sin t3 - c sin t4 = 0",]);
    assert_eq!(mechanism.closures()[0].bodies.len(), 4);
}

/// A slider on a line at a named angle, and a constant without a name: the angle
/// appears under its name, the constant as its value.
#[test]
fn slider_crank_on_an_inclined_line() {
    let mut m = Linkage::new();
    let r = m.length("r", 0.1);
    let l = m.number(0.25);
    let beta = m.angle("beta", 0.2);
    let crank = m.body("crank", "t");
    let rod = m.body("rod", "p");
    let block = m.slider("block");
    let tip = m.point(crank, "tip", r, Length::Zero);
    let end = m.point(rod, "end", l, Length::Zero);
    m.revolute("main", m.origin(m.ground()), m.origin(crank));
    m.revolute("big end", tip, m.origin(rod));
    m.revolute("small end", end, m.origin(block));
    m.prismatic("cylinder", "s", m.origin(m.ground()), beta, m.origin(block));
    m.prescribe_angle(crank);
    let mechanism = m.assemble().unwrap();
    assert_eq!(
        printed(&mechanism),
        ["r cos t + 0.25 cos p - s cos beta = 0", "r sin t + 0.25 sin p - s sin beta = 0",]
    );
}

/// A slide at a constant angle on a moving body shows the sum of the angles.
#[test]
fn a_named_angle_on_a_moving_body() {
    let mut m = Linkage::new();
    let r = m.length("r", 0.1);
    let d = m.length("d", 0.3);
    let beta = m.angle("beta", 0.2);
    let crank = m.body("crank", "t");
    let arm = m.body("arm", "p");
    let tip = m.point(crank, "tip", r, Length::Zero);
    let far = m.point(m.ground(), "far", d, Length::Zero);
    m.revolute("main", m.origin(m.ground()), m.origin(crank));
    m.revolute("far", far, m.origin(arm));
    m.contact("slot", "s", m.origin(arm), -beta + Direction::MINUS_Y, tip);
    m.prescribe_angle(crank);
    let mechanism = m.assemble().unwrap();
    assert_eq!(printed(&mechanism), ["r cos t - s sin(p - beta) - d = 0", "r sin t + s cos(p - beta) = 0",]);
}

/// Two loops that share the ground and a ternary rocker (Watt's second six-bar):
/// two circuits, each as short as a four-bar's.
#[test]
fn six_bar_has_two_short_loops() {
    let mut m = Linkage::new();
    let [a, b, c, d] = [("a", 0.1), ("b", 0.25), ("c", 0.3), ("d", 0.35)].map(|(n, v)| m.length(n, v));
    let [p, q, e, f, g] = [("p", 0.1), ("q", 0.1), ("e", 0.3), ("f", 0.2), ("g", 0.3)].map(|(n, v)| m.length(n, v));
    let bodies = ["t2", "t3", "t4", "t5", "t6"].map(|s| m.body(s, s));
    let [crank, coupler, ternary, link, output] = bodies;
    let tip = m.point(crank, "tip", a, Length::Zero);
    let joint = m.point(coupler, "joint", b, Length::Zero);
    let knee = m.point(ternary, "knee", c, Length::Zero);
    let elbow = m.point(ternary, "elbow", p, -q);
    let end = m.point(link, "end", e, Length::Zero);
    let toe = m.point(output, "toe", f, Length::Zero);
    let middle = m.point(m.ground(), "middle", d, Length::Zero);
    let far = m.point_from(middle, "far", g, Length::Zero);
    m.revolute("A", m.origin(m.ground()), m.origin(crank));
    m.revolute("B", tip, m.origin(coupler));
    m.revolute("C", joint, knee);
    m.revolute("D", middle, m.origin(ternary));
    m.revolute("E", elbow, m.origin(link));
    m.revolute("F", end, toe);
    m.revolute("G", far, m.origin(output));
    m.prescribe_angle(crank);
    let mechanism = m.assemble().unwrap();
    assert_eq!(
        printed(&mechanism),
        [
            "a cos t2 + b cos t3 - c cos t4 - d = 0",
            "a sin t2 + b sin t3 - c sin t4 = 0",
            "p cos t4 + e cos t5 - f cos t6 + q sin t4 - g = 0",
            "p sin t4 + e sin t5 - f sin t6 - q cos t4 = 0",
        ]
    );
}
