//! Problem 14: a four-bar and a slider-crank that turn for 100 s without friction or gravity. Every joint is a pair of
//! equalities.

use std::f64::consts::TAU;

use crate::{Body, Energies, Joint, JointKind, Model};
use moreau::GROUND;

use super::closed_forms::{FourBar, SliderCrank};
use super::row::{Order, ProblemRow};
use super::run::{Run, at};

const BAR: FourBar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };
const CRANK: SliderCrank = SliderCrank { r: 0.1, l: 0.3, e: 0.02 };
/// Crank angle and speed at the start, rad and rad/s.
const START: [f64; 2] = [0.4, 6.0];
/// Mass of the bars, kg/m, and of the slider, kg.
const PER_METRE: f64 = 2.0;
const SLIDER: f64 = 0.4;

fn bar(length: f64) -> Body<f64> {
    let mass = PER_METRE * length;
    Body { mass, inertia: mass * length * length / 12.0 }
}

/// Returns the angle between two directions, from 0 to a half turn, rad.
fn apart(a: f64, b: f64) -> f64 {
    let turned = (a - b).rem_euclid(TAU);
    turned.min(TAU - turned)
}

fn hinge(first: usize, at_first: [f64; 2], second: usize, at_second: [f64; 2]) -> Joint<f64> {
    Joint { kind: JointKind::Hinge, first, at_first, second, at_second, dry: 0.0, viscous: 0.0, rate: None }
}

/// What a run of a loop shows.
struct Turned {
    /// Largest opening of a joint over the run, m or rad.
    drift: f64,
    /// Largest deviation of the other bodies from the closed form at the same crank angle, rad or m.
    deviation: f64,
    /// Crank angle at the end, rad.
    angle: f64,
    /// Largest relative change of the energy.
    energy: f64,
}

fn turn<const B: usize, const N: usize>(
    mut run: Run<'_, B, N>,
    duration: f64,
    deviation: impl Fn(&Run<'_, B, N>) -> f64,
) -> Turned {
    let mut turned = Turned { drift: f64::INFINITY, deviation: f64::INFINITY, angle: f64::NAN, energy: f64::NAN };
    if !run.state.assemble(&run.model, 1e-13) {
        return turned;
    }
    turned = Turned { drift: 0.0, deviation: 0.0, angle: 0.0, energy: 0.0 };
    let start = Energies::of(&run.model, &run.state).total();
    let steps = (duration / run.settings.step).round() as u32;
    for _ in 0..steps {
        run.step();
        turned.drift = turned.drift.max(run.state.drift(&run.model));
        turned.deviation = turned.deviation.max(deviation(&run));
        let energy = Energies::of(&run.model, &run.state).total();
        turned.energy = turned.energy.max((energy / start - 1.0).abs());
        if !run.sound {
            break;
        }
    }
    turned.angle = run.state.placement[0].angle;
    for x in [&mut turned.drift, &mut turned.deviation, &mut turned.angle, &mut turned.energy] {
        *x = run.value(*x);
    }
    turned
}

/// Velocity of a bar's middle with a given end and angle, per rad of the crank.
fn middle(end: [f64; 2], length: f64, angle: f64, end_rate: [f64; 2], rate: f64) -> ([f64; 2], [f64; 3]) {
    let (s, c) = angle.sin_cos();
    let half = 0.5 * length;
    ([end[0] + half * c, end[1] + half * s], [end_rate[0] - half * s * rate, end_rate[1] + half * c * rate, rate])
}

/// Places and rates (per rad of the crank) of the four-bar's bars, from the closed form.
fn four_bar_pose(angle: f64) -> [([f64; 2], f64, [f64; 3]); 3] {
    let pose = BAR.pose(angle, 1.0).expect("the crank turns fully");
    let (coupler, rocker) = BAR.rates(angle, pose);
    let (s, c) = angle.sin_cos();
    let crank = middle([0.0; 2], BAR.a, angle, [0.0; 2], 1.0);
    let link = middle([BAR.a * c, BAR.a * s], BAR.b, pose.t3, [-BAR.a * s, BAR.a * c], coupler);
    let rock = middle([BAR.d, 0.0], BAR.c, pose.t4, [0.0; 2], rocker);
    [(crank.0, angle, crank.1), (link.0, pose.t3, link.1), (rock.0, pose.t4, rock.1)]
}

/// The same for the slider-crank: crank, rod, slider.
fn slider_crank_pose(angle: f64) -> [([f64; 2], f64, [f64; 3]); 3] {
    let (rod, x) = CRANK.pose(angle).expect("the rod is long enough");
    let rod_rate = -CRANK.r * angle.cos() / (CRANK.l * rod.cos());
    let (s, c) = angle.sin_cos();
    let crank = middle([0.0; 2], CRANK.r, angle, [0.0; 2], 1.0);
    let link = middle([CRANK.r * c, CRANK.r * s], CRANK.l, rod, [-CRANK.r * s, CRANK.r * c], rod_rate);
    let rate = CRANK.slider_rate(angle).expect("as above");
    [(crank.0, angle, crank.1), (link.0, rod, link.1), ([x, CRANK.e], 0.0, [rate, 0.0, 0.0])]
}

type Pose = fn(f64) -> [([f64; 2], f64, [f64; 3]); 3];

fn start(pose: Pose) -> [(crate::Placement<f64>, [f64; 3]); 3] {
    pose(START[0]).map(|(p, angle, rate)| (at(p[0], p[1], angle), rate.map(|r| r * START[1])))
}

/// The largest difference between where the bodies are and where the closed form has them at the same crank angle.
fn off(pose: Pose, run: &Run<'_, 3, 12>) -> f64 {
    let places = &run.state.placement;
    let expected = pose(places[0].angle);
    places.iter().zip(expected).fold(0.0, |most: f64, (q, (p, angle, _))| {
        most.max((q.at[0] - p[0]).hypot(q.at[1] - p[1])).max(apart(q.angle, angle))
    })
}

fn four_bar_bodies() -> [Body<f64>; 3] {
    [bar(BAR.a), bar(BAR.b), bar(BAR.c)]
}

fn slider_crank_bodies() -> [Body<f64>; 3] {
    [bar(CRANK.r), bar(CRANK.l), Body { mass: SLIDER, inertia: 1e-3 }]
}

fn four_bar(h: f64, duration: f64) -> Turned {
    let [a, b, c] = [BAR.a, BAR.b, BAR.c].map(|length| 0.5 * length);
    let bodies = four_bar_bodies();
    let joints = [
        hinge(GROUND, [0.0, 0.0], 0, [-a, 0.0]),
        hinge(0, [a, 0.0], 1, [-b, 0.0]),
        hinge(GROUND, [BAR.d, 0.0], 2, [-c, 0.0]),
        hinge(1, [b, 0.0], 2, [c, 0.0]),
    ];
    let model = Model::new(&bodies, &joints, &[], &[], [0.0, 0.0]).expect("sound");
    turn(Run::new(model, h, &start(four_bar_pose)), duration, |run| off(four_bar_pose, run))
}

fn slider_crank(h: f64, duration: f64) -> Turned {
    let (r, l) = (0.5 * CRANK.r, 0.5 * CRANK.l);
    let bodies = slider_crank_bodies();
    let slide = JointKind::Slide { axis: [1.0, 0.0], angle: 0.0 };
    let joints = [
        hinge(GROUND, [0.0, 0.0], 0, [-r, 0.0]),
        hinge(0, [r, 0.0], 1, [-l, 0.0]),
        hinge(1, [l, 0.0], 2, [0.0, 0.0]),
        Joint {
            kind: slide,
            first: GROUND,
            at_first: [0.0, CRANK.e],
            second: 2,
            at_second: [0.0; 2],
            dry: 0.0,
            viscous: 0.0,
            rate: None,
        },
    ];
    let model = Model::new(&bodies, &joints, &[], &[], [0.0, 0.0]).expect("sound");
    turn(Run::new(model, h, &start(slider_crank_pose)), duration, |run| off(slider_crank_pose, run))
}

/// Crank angle after a time. The energy, 1/2 I(angle) rate2, is constant, so that t is an integral of sqrt(I) over the
/// angle; it is solved for the angle by steps of the fourth order (Runge-Kutta), small enough for 1e-12.
fn crank_angle(bodies: &[Body<f64>; 3], pose: Pose, duration: f64) -> f64 {
    let inertia = |angle: f64| {
        bodies.iter().zip(pose(angle)).fold(0.0, |sum, (body, (_, _, v))| {
            sum + body.mass * (v[0] * v[0] + v[1] * v[1]) + body.inertia * v[2] * v[2]
        })
    };
    let momentum = inertia(START[0]).sqrt() * START[1];
    let rate = |angle: f64| momentum / inertia(angle).sqrt();
    let steps = 20_000;
    let h = duration / f64::from(steps);
    let mut angle = START[0];
    for _ in 0..steps {
        let k1 = rate(angle);
        let k2 = rate(angle + 0.5 * h * k1);
        let k3 = rate(angle + 0.5 * h * k2);
        let k4 = rate(angle + h * k3);
        angle += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    angle
}

type Case = (&'static str, fn(f64, f64) -> Turned, [Body<f64>; 3], Pose);

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    let cases: [Case; 2] = [
        ("four-bar", four_bar, four_bar_bodies(), four_bar_pose),
        ("slider-crank", slider_crank, slider_crank_bodies(), slider_crank_pose),
    ];
    for (name, run, bodies, pose) in cases {
        let long = run(1e-3, 100.0);
        rows.push(ProblemRow::new(
            format!("{name}: largest opening of a joint in 100 s, h = 1e-3"),
            "m, rad",
            0.0,
            long.drift,
            1e-10,
            "asked for; the projection closes to 1e-13",
        ));
        let because = "the opening over the sine between the bars, and rounding of a thousand rad";
        rows.push(ProblemRow::new(
            format!("{name}: largest deviation from the closed form in 100 s"),
            "m, rad",
            0.0,
            long.deviation,
            1e-11,
            because,
        ));
        let reference = crank_angle(&bodies, pose, 2.0);
        let turns: Vec<Turned> = (0..4).map(|k| run(4e-3 * 0.5_f64.powi(k), 2.0)).collect();
        for (what, error, within) in [
            ("crank's angle after 2 s", turns.iter().map(|t| (t.angle - reference).abs()).collect::<Vec<f64>>(), 0.1),
            ("largest change of energy", turns.iter().map(|t| t.energy).collect(), 0.15),
        ] {
            let order = Order::of(4e-3, error);
            let quantity = format!("{name}: order of the {what}, h from 4 ms");
            rows.push(ProblemRow::new(quantity, "", 2.0, order.observed(), within, "slope over three halvings"));
        }
    }
    rows
}
