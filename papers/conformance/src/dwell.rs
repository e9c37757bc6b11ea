//! Problem 26: dry friction that grows during sticking, of a pivot and of a sliding contact.
//!
//! A body on a hinge, J = 1.5e-4 kg m2, kinetic friction c = 2e-3 N m, static friction 1.5 c, tau = 0.2 s: after a rest
//! of t it holds c (1 + 0.5 (1 - exp(-t/tau))). The contact's friction has the same moment.

use moreau::{
    Body, ContactCurve, Description, DescriptionPart, Dwell, Exponent, Felt, GROUND, Loss, Settings, Site, SiteInput,
    State, StepOutcome, Workspace, Zone, step,
};

use moreau_rigid::problems::{Expected, ProblemRow};

const INERTIA: f64 = 1.5e-4;
const KINETIC: f64 = 2e-3;
const RATIO: f64 = 1.5;
const TAU: f64 = 0.2;
const H: f64 = 1e-4;

/// Place of the friction.
#[derive(Clone, Copy)]
enum At {
    Pivot,
    Contact,
}

/// Returns the angle after a load (N m, of the time in s) for `duration`, s, and the time at which it first moved, s.
fn loaded(at: At, duration: f64, load: impl Fn(f64) -> f64) -> [f64; 2] {
    let dry = if matches!(at, At::Pivot) { KINETIC } else { 0.0 };
    let body = Body { inertia: INERTIA, dry, ..Body::inert() };
    // A point at 1 m below the pivot, 1 mm within a floor that pushes with k g^2 = 1 N: its friction has a lever of the
    // same length.
    let zone = Zone {
        disc_body: 0,
        center: [0.0, -1.0],
        radius: 0.0,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [0.0, -0.999], normal: [0.0, 1.0] },
        felt: Felt { stiffness: 1e6, exponent: Exponent::new(2.0), loss: Loss::quadratic(0.0) },
        // It slides on the floor, 999 mm below the pivot.
        friction: Some(KINETIC / 0.999),
    };
    let part = if matches!(at, At::Pivot) { DescriptionPart::Body(0) } else { DescriptionPart::Zone(0) };
    let zones: &[Zone<f64>] = if matches!(at, At::Pivot) { &[] } else { &[zone] };
    let site = Site { body: 0, point: [1.0, 0.0], direction: [0.0, 1.0], stiffness: 0.0, damping: 0.0 };
    let dwells = [Dwell { part, ratio: RATIO, time: TAU }];
    let description =
        Description { bodies: &[body], zones, dwells: &dwells, site: Some(site), ..Description::default() };
    let model = description.compile::<1, 1>().expect("sound");
    let (settings, mut state) = (Settings::new(H), State::at_rest([0.0]));
    let (mut workspace, mut moved, mut sound) = (Workspace::<f64, 1, 1, 3>::new(), f64::INFINITY, true);
    for n in 0..(duration / H).round() as u32 {
        let middle = (f64::from(n) + 0.5) * H;
        let report = step(&model, &settings, &SiteInput::Force(load(middle)), &mut state, &mut workspace);
        sound &= report.outcome == StepOutcome::Converged;
        if state.angle[0].abs() > 1e-12 {
            moved = moved.min(f64::from(n) * H);
        }
    }
    if sound { [state.angle[0], moved] } else { [f64::NAN; 2] }
}

/// Time at which a load growing by `rate` N m/s reaches the static friction, s.
fn lets_go(rate: f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..100 {
        let t = 0.5 * (low + high);
        if rate * t < KINETIC * (1.0 + (RATIO - 1.0) * -(-t / TAU).exp_m1()) { low = t } else { high = t }
    }
    0.5 * (low + high)
}

/// Gonthier's bristle (Y. Gonthier, J. McPhee, C. Lange, J.-C. Piedboeuf, Multibody System Dynamics 11 (2004) 209-233)
/// in place of the pivot's law, under half of the kinetic friction and a tremor of a quarter of it at 50 Hz, for
/// `duration`, s. Returns the creep of the body while it should stick, rad. Runge-Kutta method of order 4 at 5 us; the
/// bristle bends by a milliradian at the kinetic friction, and is critically damped.
fn bristle_creeps(duration: f64) -> f64 {
    let stiffness = KINETIC / 1e-3;
    let damping = 2.0 * (stiffness * INERTIA).sqrt();
    // Below this speed, rad/s, it counts as sticking.
    let slow = 1e-2;
    let load = |t: f64| KINETIC * (0.5 + 0.25 * (2.0 * std::f64::consts::PI * 50.0 * t).sin());
    let rates = |t: f64, [_, v, z]: [f64; 3]| {
        let stick = (-(v / slow) * (v / slow)).exp();
        let kinetic = KINETIC * (v / slow).clamp(-1.0, 1.0);
        let z_rate = stick * v + (1.0 - stick) * (kinetic - stiffness * z) / damping;
        let friction = (stiffness * z + damping * z_rate).clamp(-RATIO * KINETIC, RATIO * KINETIC);
        [v, (load(t) - friction) / INERTIA, z_rate]
    };
    let (h, mut y) = (5e-6, [0.0; 3]);
    let mut first = 0.0;
    for n in 0..(duration / h) as u32 {
        let t = f64::from(n) * h;
        let at = |y: [f64; 3], k: [f64; 3], s: f64| [0, 1, 2].map(|i| y[i] + s * k[i]);
        let k1 = rates(t, y);
        let k2 = rates(t + 0.5 * h, at(y, k1, 0.5 * h));
        let k3 = rates(t + 0.5 * h, at(y, k2, 0.5 * h));
        let k4 = rates(t + h, at(y, k3, h));
        y = [0, 1, 2].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        // After it has bent under the load: a whole number of the tremor's periods.
        if n == (1.0 / h) as u32 {
            first = y[0];
        }
    }
    y[0] - first
}

/// Problem 26.
pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for (at, place) in [(At::Pivot, "pivot"), (At::Contact, "contact")] {
        let name = |s: &str| format!("{place}: {s}");
        for rate in [0.5e-3, 4e-3, 4e-2] {
            let exact = lets_go(rate);
            let [_, moved] = loaded(at, 1.2 * exact + 0.01, |t| rate * t);
            let because = "the load is seen at the middle of a step, the friction as it was at its start";
            let quantity = name(&format!("load grows by {rate} N m/s: lets go"));
            rows.push(ProblemRow::new(quantity, "s", exact, moved, 2.0 * H, because));
        }
        // A load of 1.2 c after a rest of t: it holds from t = -tau ln(1 - 0.2/0.5) on.
        let exact = -TAU * (1.0 - 0.2 / (RATIO - 1.0)).ln();
        let (mut slips, mut holds) = (0.0, 1.0);
        while holds - slips > 0.5 * H {
            let rest = 0.5 * (slips + holds);
            let [angle, _] = loaded(at, rest + 1.0, |t| if t < rest { 0.0 } else { 1.2 * KINETIC });
            if angle == 0.0 { holds = rest } else { slips = rest }
        }
        let because = "to a step";
        rows.push(ProblemRow::new(
            name("rest after which 1.2 of the kinetic friction is held"),
            "s",
            exact,
            holds,
            2.0 * H,
            because,
        ));
        let [angle, _] = loaded(at, 10.0, |t| if t < 1.0 { 0.0 } else { 1.45 * KINETIC });
        rows.push(ProblemRow::new(
            name("angle after 9 s under 1.45 of it"),
            "rad",
            0.0,
            angle,
            0.0,
            "exactly zero: no creep",
        ));
        let [angle, _] = loaded(at, 1.002, |t| if t < 1.0 { 0.0 } else { 1.6 * KINETIC });
        let exact = 0.5 * 0.6 * KINETIC / INERTIA * 0.002 * 0.002;
        // The floor's force has a lever as soon as the body turns: 2 ms are short compared with sqrt(J/1 N m) = 12 ms.
        let because = "what slips has the kinetic friction from the first step on";
        rows.push(ProblemRow::new(
            name("angle after 2 ms under 1.6 of it"),
            "rad",
            exact,
            angle,
            1e-2 * exact,
            because,
        ));
    }
    let because = "for comparison: a law that is not set-valued creeps where this one stands still";
    let creeps = bristle_creeps(10.0).abs();
    rows.push(ProblemRow::bounded(
        "Gonthier's bristle under a trembling load: creeps in 9 s, rad",
        Expected::AtLeast(1e-5),
        creeps,
        because,
    ));
    let quantity = "this law under the same load: moves in 9 s, rad";
    let omega = 2.0 * std::f64::consts::PI * 50.0;
    let [angle, _] = loaded(At::Pivot, 10.0, |t| KINETIC * (0.5 + 0.25 * (omega * t).sin()));
    rows.push(ProblemRow::bounded(quantity, Expected::AtMost(0.0), angle.abs(), "it sticks, to the bit"));
    rows
}
