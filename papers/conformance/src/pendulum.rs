//! Problem 4: a double pendulum without friction, in the engine's tree and as rigid bodies with two hinges.

use moreau::{Body, Description, GROUND, Settings};
use moreau_rigid::{self as rigid, Joint, JointKind};

use crate::mechanism::Mechanism;
use moreau_rigid::problems::{Order, ProblemRow};
use moreau_rigid::problems::{Run, at};

/// Masses, kg, and lengths, m, of two uniform bars.
const M1: f64 = 0.3;
const M2: f64 = 0.2;
const L1: f64 = 0.4;
const L2: f64 = 0.15;
const G: f64 = 9.81;
/// Initial angles from the vertical, rad; at rest.
const START: [f64; 2] = [1.0, -0.5];

/// Number of times at which a run is compared, every tenth of a second: a single one may be good by chance.
const INSTANTS: u32 = 20;

/// Angles at all times, and the largest change of energy at one of them.
struct Swung {
    angles: Vec<[f64; 2]>,
    gain: f64,
}

fn tree(h: f64, theta: f64) -> Swung {
    let bar = |mass: f64, length: f64| Body {
        mass,
        center_of_mass: [0.0, -0.5 * length],
        inertia: mass * length * length / 3.0,
        ..Body::inert()
    };
    let bodies = [bar(M1, L1), Body { parent: 0, pivot: [0.0, -L1], ..bar(M2, L2) }];
    let model = Description { bodies: &bodies, gravity: G, ..Description::default() }.compile().expect("sound");
    let settings = Settings { theta, tolerance: 1e-12, ..Settings::new(h) };
    let mut m = Mechanism::<2, 0, 1>::new(model, START, [0.0; 2], settings);
    let start = moreau::Energies::of(&m.model, &m.state).total();
    let mut swung = Swung { angles: Vec::new(), gain: 0.0 };
    for _ in 0..INSTANTS {
        m.run(0.1);
        swung.angles.push(m.state.angle.map(|a| m.value(a)));
        let gain = moreau::Energies::of(&m.model, &m.state).total() - start;
        swung.gain = m.value(swung.gain.max(gain.abs()));
    }
    swung
}

fn rigid(h: f64, theta: f64) -> Swung {
    let bar = |mass: f64, length: f64| rigid::Body { mass, inertia: mass * length * length / 12.0 };
    let bodies = [bar(M1, L1), bar(M2, L2)];
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
    let joints = [hinge(GROUND, [0.0; 2], 0, [0.0, 0.5 * L1]), hinge(0, [0.0, -0.5 * L1], 1, [0.0, 0.5 * L2])];
    let model = rigid::Model::new(&bodies, &joints, &[], &[], [0.0, -G]).expect("sound");
    let along = |l: f64, angle: f64| [l * angle.sin(), -l * angle.cos()];
    let (a, b) = (along(L1, START[0]), along(0.5 * L2, START[1]));
    let start = [(at(0.5 * a[0], 0.5 * a[1], START[0]), [0.0; 3]), (at(a[0] + b[0], a[1] + b[1], START[1]), [0.0; 3])];
    let mut run = Run::<2, 6>::new(model, h, &start);
    run.settings.theta = theta;
    let energy = rigid::Energies::of(&model, &run.state).total();
    let mut swung = Swung { angles: Vec::new(), gain: 0.0 };
    for i in 1..=INSTANTS {
        run.until(0.1 * f64::from(i));
        swung.angles.push([0, 1].map(|i| run.value(run.state.placement[i].angle)));
        let gain = rigid::Energies::of(&model, &run.state).total() - energy;
        swung.gain = run.value(swung.gain.max(gain.abs()));
    }
    swung
}

/// Lagrange's equations of two uniform bars, by classical Runge-Kutta of order 4 with steps of 20 us, whose own error
/// is below 1e-12: (J1 + m2 l1^2) a'' + m2 l1 c2 cos(a - b) b'' + m2 l1 c2 sin(a - b) b'^2 + (m1 c1 + m2 l1) g sin a =
/// 0, J2 b'' + m2 l1 c2 cos(a - b) a'' - m2 l1 c2 sin(a - b) a'^2 + m2 c2 g sin b = 0
fn reference() -> Vec<[f64; 2]> {
    let (j1, j2) = (M1 * L1 * L1 / 3.0, M2 * L2 * L2 / 3.0);
    let (c1, c2) = (0.5 * L1, 0.5 * L2);
    let rate = |y: [f64; 4]| {
        let [a, b, u, w] = y;
        let d = a - b;
        let k = M2 * L1 * c2;
        let (m11, m12, m22) = (j1 + M2 * L1 * L1, k * d.cos(), j2);
        let r1 = -k * d.sin() * w * w - (M1 * c1 + M2 * L1) * G * a.sin();
        let r2 = k * d.sin() * u * u - M2 * c2 * G * b.sin();
        let det = m11 * m22 - m12 * m12;
        [u, w, (r1 * m22 - m12 * r2) / det, (m11 * r2 - m12 * r1) / det]
    };
    let shifted = |y: [f64; 4], k: [f64; 4], s: f64| core::array::from_fn(|i| y[i] + s * k[i]);
    let h = 2e-5;
    let mut y = [START[0], START[1], 0.0, 0.0];
    let mut angles = Vec::new();
    for i in 1..=5000 * INSTANTS {
        let k1 = rate(y);
        let k2 = rate(shifted(y, k1, h / 2.0));
        let k3 = rate(shifted(y, k2, h / 2.0));
        let k4 = rate(shifted(y, k3, h));
        y = core::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        if i % 5000 == 0 {
            angles.push([y[0], y[1]]);
        }
    }
    angles
}

type Engine = fn(f64, f64) -> Swung;

/// Order 2 at theta = 1/2 and 1 at theta = 1, of the angles and of the energy.
pub(crate) fn rows() -> Vec<ProblemRow> {
    let exact = reference();
    let mut rows = Vec::new();
    for (name, engine) in [("tree", tree as Engine), ("rigid bodies", rigid as Engine)] {
        for (theta, expected) in [(0.5, 2.0), (1.0, 1.0)] {
            let runs: Vec<Swung> = (0..4).map(|k| engine(4e-4 * 0.5_f64.powi(k), theta)).collect();
            let error = |swung: &Swung| {
                swung.angles.iter().zip(&exact).fold(0.0, |most: f64, (ours, exact)| {
                    most.max((ours[0] - exact[0]).abs()).max((ours[1] - exact[1]).abs())
                })
            };
            let label = |s: &str| format!("{name}, theta {theta}: order of the {s}");
            for (what, errors, within) in [
                ("angles over 2 s", runs.iter().map(error).collect(), 0.1),
                ("energy's change", runs.iter().map(|run| run.gain).collect(), 0.2),
            ] {
                let order = Order::of(4e-4, errors);
                let because = "slope over three halvings from 0.4 ms";
                rows.push(ProblemRow::new(label(what), "", expected, order.observed(), within, because));
            }
        }
    }
    rows
}
