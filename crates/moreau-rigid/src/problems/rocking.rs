//! Problem 17: Housner's rocking block. A slender block rocks on its corners, on a floor too rough for slip.
//!
//! About a corner I0 theta'' = -m g R sin(alpha - theta) while theta > 0, where R is the half diagonal, alpha its angle
//! to the vertical and I0 = 4/3 m R2. When the other corner lands, angular momentum about it is conserved: the rate is
//! multiplied by 1 - 3/2 sin2 alpha (Housner 1963).

use crate::{Body, Model, PolygonContact, StepOutcome};
use moreau::GROUND;

use super::row::{Expected, ProblemRow};
use super::run::{Run, at};

const G: f64 = 9.81;
/// Half width and height, m.
const HALF: [f64; 2] = [0.1, 0.4];
const MASS: f64 = 3.0;
/// More than (1 + 3 s2) / (3 s c) = 1.67, s and c of alpha: a corner that slid on with a finite force could not stay on
/// the floor.
const MU: f64 = 2.0;

struct Rocked {
    /// Instants of the landings, s.
    landings: Vec<f64>,
    /// Rates after and before the first of them.
    ratio: f64,
    /// Steps that were called Painleve's.
    paradoxes: u32,
    /// Largest way of the corner that it rocks on before the first landing, m.
    crept: f64,
}

fn rock([x, y]: [f64; 2], restitution: f64, start: f64, h: f64, duration: f64) -> Rocked {
    let bodies = [Body { mass: MASS, inertia: MASS * (x * x + y * y) / 3.0 }];
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let floor = [[-5.0, -1.0], [5.0, -1.0], [5.0, 0.0], [-5.0, 0.0]];
    let contacts = [PolygonContact {
        first: 0,
        first_corners: &corners,
        second: GROUND,
        second_corners: &floor,
        restitution,
        kinetic: MU,
        limit: MU,
    }];
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -G]).and_then(|m| m.with_polygons(&contacts)).expect("sound");
    // On its right corner, turned clockwise.
    let (s, c) = start.sin_cos();
    let place = at(-x * c + y * s, x * s + y * c - 1e-15, -start);
    let mut run = Run::<1, 4>::new(model, h, &[(place, [0.0; 3])]);
    let mut rocked = Rocked { landings: Vec::new(), ratio: f64::NAN, paradoxes: 0, crept: 0.0 };
    let steps = (duration / h) as u32;
    for _ in 0..steps {
        let before = (run.state.placement[0].angle, run.state.velocity[0][2]);
        let report = run.step();
        if report.outcome == StepOutcome::Painleve {
            rocked.paradoxes += 1;
            run.sound = true;
        }
        let (angle, rate) = (run.state.placement[0].angle, run.state.velocity[0][2]);
        if rocked.landings.is_empty() {
            rocked.crept = rocked.crept.max(run.state.placement[0].point([x, -y])[0].abs());
        }
        if before.0 * angle < 0.0 {
            rocked.landings.push(run.time() - h * angle / (angle - before.0));
        }
        // The rate jumps in the step whose middle is past the landing.
        if rocked.ratio.is_nan() && rate.abs() < 0.97 * before.1.abs() && before.1.abs() > 0.1 {
            rocked.ratio = rate / before.1;
        }
    }
    rocked.crept = run.value(rocked.crept);
    rocked
}

/// R, alpha and p2 = m g R / I0.
fn geometry() -> (f64, f64, f64) {
    let [x, y] = HALF;
    let r = x.hypot(y);
    (r, x.atan2(y), 3.0 * G / (4.0 * r))
}

/// Time from rest at `start` to the upright: the integral of 1/theta' with theta'2 = 2 p2 (cos(alpha - start) -
/// cos(alpha - theta)), by Simpson's rule in s, theta = start - s2, which takes the root out.
fn quarter(start: f64) -> f64 {
    let (_, alpha, p2) = geometry();
    let a = alpha - start;
    let integrand = |s: f64| {
        if s == 0.0 {
            return 2.0 / (2.0 * p2 * a.sin()).sqrt();
        }
        2.0 * s / (4.0 * p2 * (a + 0.5 * s * s).sin() * (0.5 * s * s).sin()).sqrt()
    };
    let (n, end) = (2000, start.sqrt());
    let d = end / f64::from(n);
    let inner: f64 = (1..n).map(|k| if k % 2 == 1 { 4.0 } else { 2.0 } * integrand(f64::from(k) * d)).sum();
    (integrand(0.0) + inner + integrand(end)) * d / 3.0
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let (_, alpha, p2) = geometry();
    let start = 0.5 * alpha;
    let ratio = 1.0 - 1.5 * alpha.sin().powi(2);
    // After the landing it rises until its energy is that of the amplitude.
    let landing2 = 2.0 * p2 * ((alpha - start).cos() - alpha.cos());
    let next = alpha - (alpha.cos() + landing2 * ratio * ratio / (2.0 * p2)).acos();
    let mut rows = Vec::new();
    for h in [1e-3, 1e-4] {
        let rocked = rock(HALF, 0.0, start, h, 4.0);
        let name = |s: &str| format!("{s}, h = {h:.0e}");
        let landing = |i: usize| rocked.landings.get(i).copied().unwrap_or(f64::NAN);
        let because =
            "interpolated in a step whose rate may have fallen by a tenth: a tenth of half a step, and of order h2";
        rows.push(ProblemRow::new(name("first landing"), "s", quarter(start), landing(0), 0.1 * h, because));
        let because = "gravity in the step of the landing: p2 sin alpha h = 4.3 h rad/s of 0.9";
        rows.push(ProblemRow::new(name("rate after it over rate before"), "", ratio, rocked.ratio, 6.0 * h, because));
        let because =
            "a part 6 h of the rate moves the amplitude and its 0.5 s by no more; the landings are known to a step";
        rows.push(ProblemRow::new(
            name("from the first to the second"),
            "s",
            2.0 * quarter(next),
            landing(1) - landing(0),
            6.0 * h,
            because,
        ));
        let because = "sticks at every step's end; between them the way is a chord: (rate h)2/8 of 0.4 m, added up";
        rows.push(ProblemRow::new(
            name("the corner's way until it lands"),
            "m",
            0.0,
            rocked.crept,
            0.05 * h * h,
            because,
        ));
        rows.push(ProblemRow::bounded(
            &name("landings in 4 s"),
            Expected::AtLeast(8.0),
            rocked.landings.len() as f64,
            "it goes on rocking",
        ));
        rows.push(ProblemRow::bounded(
            &name("steps called Painleve's"),
            Expected::AtMost(0.0),
            f64::from(rocked.paradoxes),
            "nothing slips when it lands",
        ));
        // As wide as high: it rebounds, and slips where it lands.
        let rocked = rock([HALF[1]; 2], 0.3, 0.25 * std::f64::consts::FRAC_PI_4, h, 4.0);
        rows.push(ProblemRow::bounded(
            &name("a square that rebounds: steps called Painleve's"),
            Expected::AtMost(0.0),
            f64::from(rocked.paradoxes),
            "its friction is beyond 1.67, but landings are collisions",
        ));
    }
    rows
}
