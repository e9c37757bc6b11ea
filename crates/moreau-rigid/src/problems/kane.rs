//! Problem 18: Kane's paradox. The tip of a double pendulum of two uniform rods meets a rough floor; restitution and
//! friction 0.5.
//!
//! By Newton's law the impact creates energy, with a single contact. By Stronge's law it loses energy: the slip stops
//! while the contact is still being compressed, and reverses. Both references are derived by hand in the two angles and
//! share nothing with the engine, which has two bodies of three coordinates and two hinges.

use crate::{Body, Contact, Energies, ImpactLaw, Joint, JointKind, Model, StepReport, Surface};
use moreau::GROUND;

use super::row::{Expected, ProblemRow};
use super::run::{Run, at};

/// Angles from the downward vertical, rad, and their rates, rad/s; rods of 1 m and 1 kg.
const ANGLE: [f64; 2] = [0.53, 0.48];
const RATE: [f64; 2] = [-1.3, -1.0];
const E: f64 = 0.5;
const MU: f64 = 0.5;

/// The impact in the two angles: the tip's mobilities (normal, mixed, tangential), its velocity before, the kinetic
/// energy before.
struct Tip {
    nn: f64,
    nt: f64,
    tt: f64,
    un: f64,
    ut: f64,
    energy: f64,
}

fn tip() -> Tip {
    let [(s1, c1), (s2, c2)] = ANGLE.map(f64::sin_cos);
    let [w1, w2] = RATE;
    // Mass matrix of the angles: 1/3 + 1, 1/2 cos(a - b), 1/3.
    let (a, b, d) = (4.0 / 3.0, 0.5 * (ANGLE[0] - ANGLE[1]).cos(), 1.0 / 3.0);
    let det = a * d - b * b;
    let inverse = |x: [f64; 2], y: [f64; 2]| (x[0] * (d * y[0] - b * y[1]) + x[1] * (a * y[1] - b * y[0])) / det;
    let (n, t) = ([s1, s2], [c1, c2]);
    Tip {
        nn: inverse(n, n),
        nt: inverse(n, t),
        tt: inverse(t, t),
        un: n[0] * w1 + n[1] * w2,
        ut: t[0] * w1 + t[1] * w2,
        energy: 0.5 * (a * w1 * w1 + 2.0 * b * w1 * w2 + d * w2 * w2),
    }
}

/// Newton: the tip sticks (checked) and parts with e times its speed. Velocity after, and energy after over energy
/// before.
fn newton(tip: &Tip) -> ([f64; 2], f64) {
    let (a, b) = (-(1.0 + E) * tip.un, -tip.ut);
    let det = tip.nn * tip.tt - tip.nt * tip.nt;
    let (pn, pt) = ((a * tip.tt - b * tip.nt) / det, (b * tip.nn - a * tip.nt) / det);
    if !(pn > 0.0 && pt.abs() < MU * pn) {
        return ([f64::NAN; 2], f64::NAN);
    }
    // Work of an impulse: its product with the mean velocity.
    let work = pn * 0.5 * (tip.un - E * tip.un) + pt * 0.5 * tip.ut;
    ([-E * tip.un, 0.0], 1.0 + work / tip.energy)
}

/// Stronge, in the space of the normal impulse P: the tip slips backward first, friction mu P forward, du_n/dP = c1,
/// du_t/dP = k1; the slip stops at P1, before the compression ends, and begins again forward since sticking would need
/// more than mu: c2, k2. The compression ends at P2; the work that it took is given back times e2.
fn stronge(tip: &Tip) -> ([f64; 2], f64) {
    let (c1, k1) = (tip.nn + MU * tip.nt, tip.nt + MU * tip.tt);
    let (c2, k2) = (tip.nn - MU * tip.nt, tip.nt - MU * tip.tt);
    let p1 = -tip.ut / k1;
    let at_stop = tip.un + c1 * p1;
    let as_assumed = tip.ut < 0.0 && p1 > 0.0 && at_stop < 0.0 && k2 > 0.0 && c2 > 0.0;
    if !as_assumed {
        return ([f64::NAN; 2], f64::NAN);
    }
    let taken = -0.5 * (tip.un + at_stop) * p1 + 0.5 * at_stop * at_stop / c2;
    let parting = E * (2.0 * c2 * taken).sqrt();
    let slip = k2 * (parting - at_stop) / c2;
    // Friction: mu P forward against the backward slip, then mu P backward against the forward one.
    let rubbed = MU * p1 * 0.5 * tip.ut - MU * ((parting - at_stop) / c2) * 0.5 * slip;
    ([parting, slip], 1.0 + (rubbed - taken * (1.0 - E * E)) / tip.energy)
}

/// One step of the engine: the tip's velocity after, energy after over energy before, the report's work over the energy
/// before.
fn strike(angle: [f64; 2], rate: [f64; 2], law: ImpactLaw, h: f64) -> ([f64; 2], f64, f64, StepReport<f64>) {
    let rod = Body { mass: 1.0, inertia: 1.0 / 12.0 };
    let bodies = [rod, rod];
    let hinge = |first, at_first, second, at_second| Joint {
        kind: JointKind::Hinge,
        first,
        at_first,
        second,
        at_second,
        dry: 0.0,
        viscous: 0.0,
        rate: None,
    };
    let [(s1, c1), (s2, c2)] = angle.map(f64::sin_cos);
    // The floor is where the tip is.
    let height = c1 + c2 - 1e-14;
    let joints = [hinge(GROUND, [0.0, height], 0, [0.0, 0.5]), hinge(0, [0.0, -0.5], 1, [0.0, 0.5])];
    let contacts = [Contact {
        disc_body: 1,
        center: [0.0, -0.5],
        radius: 0.0,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: E,
        kinetic: MU,
        limit: MU,
        belt: 0.0,
    }];
    let model = Model::new(&bodies, &joints, &[], &contacts, [0.0, 0.0]).expect("sound");
    let [w1, w2] = rate;
    let start = [
        (at(0.5 * s1, height - 0.5 * c1, angle[0]), [0.5 * c1 * w1, 0.5 * s1 * w1, w1]),
        (at(s1 + 0.5 * s2, height - c1 - 0.5 * c2, angle[1]), [c1 * w1 + 0.5 * c2 * w2, s1 * w1 + 0.5 * s2 * w2, w2]),
    ];
    let mut run = Run::<2, 8>::new(model, h, &start);
    run.settings.impact_law = law;
    let before = Energies::of(&model, &run.state).total();
    let report = run.step();
    let after = Energies::of(&model, &run.state).total();
    let [a, b] = [0, 1].map(|i| run.state.velocity[i][2]);
    ([s1 * a + s2 * b, c1 * a + c2 * b], run.value(after / before), report.impact_energy / before, report)
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let tip = tip();
    let h = 1e-9;
    let mut rows = Vec::new();
    for (name, law, (u, energy)) in
        [("Newton", ImpactLaw::Newton, newton(&tip)), ("Stronge", ImpactLaw::Stronge, stronge(&tip))]
    {
        let (ours, ratio, told, report) = strike(ANGLE, RATE, law, h);
        let because =
            "the rods turn by 1e-9 s times some rad/s, and their angles differ by 0.05 only, which counts squared";
        rows.push(ProblemRow::new(format!("{name}: tip parts with"), "m/s", u[0], ours[0], 1e-6, because));
        rows.push(ProblemRow::new(format!("{name}: tip slips with"), "m/s", u[1], ours[1], 1e-6, because));
        rows.push(ProblemRow::new(format!("{name}: energy after over before"), "", energy, ratio, 1e-5, because));
        let because = "what the report tells is the work of the contact's impulses";
        rows.push(ProblemRow::new(
            format!("{name}: gain that the report tells"),
            "",
            energy - 1.0,
            told,
            1e-5,
            because,
        ));
        if law == ImpactLaw::Stronge {
            rows.push(ProblemRow::bounded(
                "Stronge: increments in the space of impulses",
                Expected::AtMost(4.0),
                if report.impact_ended { f64::from(report.impact_increments) } else { f64::NAN },
                "three straight parts, and a look that finds nothing left: found exactly, not by small increments",
            ));
        }
    }
    let (mut newton, mut stronge, mut impacts) = (0.0_f64, 0.0_f64, 0);
    for i in 0..4000 {
        // A lattice over poses and rates, without pattern: parts of multiples of irrational numbers.
        let part = |x: f64| (f64::from(i) * x).fract() - 0.5;
        let angle = [2.4 * part(2.0_f64.sqrt()), 2.4 * part(3.0_f64.sqrt())];
        let rate = [4.0 * part(5.0_f64.sqrt()), 10.0 * part(7.0_f64.sqrt())];
        let closing = -(angle[0].sin() * rate[0] + angle[1].sin() * rate[1]);
        // Rods in one line do not move their tip along it.
        if closing > 0.05 && (angle[0] - angle[1]).abs() > 0.02 {
            impacts += 1;
            newton = newton.max(strike(angle, rate, ImpactLaw::Newton, h).1);
            let (_, energy, told, _) = strike(angle, rate, ImpactLaw::Stronge, h);
            stronge = stronge.max(energy).max(1.0 + told);
            if energy.is_nan() {
                stronge = f64::NAN;
            }
        }
    }
    let mut bound = |what: &str, expected, ours, because| rows.push(ProblemRow::bounded(what, expected, ours, because));
    bound("impacts in other poses", Expected::AtLeast(1000.0), f64::from(impacts), "half of them close");
    bound("Newton: largest energy after over before", Expected::AtLeast(2.0), newton, "the paradox is no accident");
    bound(
        "Stronge: the same",
        Expected::AtMost(1.0 + 1e-6),
        stronge,
        "takes by construction; the rods' turning in the step",
    );
    rows
}
