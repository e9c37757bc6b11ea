//! Problem 25: Stulov's hereditary felt, compressed along a prescribed path.
//!
//! F = Q (u - z), u = g^r, dz/dt = (eps u - z)/tau, Q = k/(1 - eps). With f = Q (eps u - z) = Q tau dz/dt the loss of a
//! cycle is the integral of f dg, because k g^r returns its work. f' = Q eps u' - f/tau is a filter linear in u, so
//! that closed forms exist for a periodic g.

use std::f64::consts::PI;

use moreau::{
    Body, ContactCurve, Description, Energies, Exponent, Felt, GROUND, Hereditary, Ledger, Loss, Settings, Site,
    SiteInput, State, StepOutcome, Workspace, Zone, step,
};

use crate::felt::{ARM, throw_at};
use moreau_rigid::problems::{Expected, Order, ProblemRow};

const K: f64 = 4e4;
/// eps and tau, s.
const RELAXED: f64 = 0.4;
const TAU: f64 = 2e-3;

/// A felt pressed by a rigid drive with the velocity of `path` (m, of the time in s). Returns the drive's work in the
/// last period, J, which is the loop's area, and the ledger's residual over it. The body at the end of a long arm has
/// almost no inertia.
fn driven(r: f64, period: f64, periods: u32, h: f64, path: impl Fn(f64) -> f64) -> [f64; 2] {
    let body = Body { mass: 1e-9, center_of_mass: [0.0, -ARM], inertia: 1e-9 * ARM * ARM, ..Body::inert() };
    let loss = Loss::Hereditary(Hereditary { relaxed: RELAXED, time: TAU });
    let zone = Zone {
        disc_body: 0,
        center: [0.0, -ARM],
        radius: 0.0,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [0.0, 0.0], normal: [-1.0, 0.0] },
        felt: Felt { stiffness: K, exponent: Exponent::new(r), loss },
        friction: None,
    };
    let site = Site { body: 0, point: [0.0, -ARM], direction: [1.0, 0.0], stiffness: 0.0, damping: 0.0 };
    let description = Description { bodies: &[body], zones: &[zone], site: Some(site), ..Description::default() };
    let model = description.compile::<1, 1>().expect("sound");
    let settings = Settings { tolerance: 1e-12, ..Settings::new(h) };
    let mut workspace = Workspace::<f64, 1, 1, 2>::new();
    let mut state = State::at_rest([(path(0.0) / ARM).asin()]);
    let steps = (period / h).round() as u32;
    let mut ledger = Ledger::open(&model, &state);
    let (mut position, mut velocity, mut sound) = (path(0.0), 0.0, true);
    for n in 0..periods * steps {
        if n == (periods - 1) * steps {
            ledger = Ledger::open(&model, &state);
        }
        let before = state.clone();
        // The scheme's displacement in a step is h times the mean of the velocities at its ends.
        let next = path(f64::from(n + 1) * h);
        velocity = 2.0 * (next - position) / h - velocity;
        position = next;
        let report = step(&model, &settings, &SiteInput::Rigid { velocity }, &mut state, &mut workspace);
        sound &= report.outcome == StepOutcome::Converged;
        ledger.record(&model, &settings, &before, &state, &workspace);
    }
    ledger.update_energies(&model, &state);
    let kinetic = |e: &Energies| e.kinetic;
    let work = ledger.drive_work - (kinetic(&ledger.now) - kinetic(&ledger.start));
    if sound { [work, ledger.residual().abs() / work.abs()] } else { [f64::NAN; 2] }
}

/// g = a (1 - cos wt) + b: u's part at the frequency w is -U cos wt with U = a for r = 1 and U = 2 a (a + b) for r = 2;
/// no other part does work against dg. The filter shifts its phase.
fn sinusoidal(r: f64, a: f64, b: f64, w: f64) -> f64 {
    let first = if r == 1.0 { a } else { 2.0 * a * (a + b) };
    PI * a * first * K / (1.0 - RELAXED) * RELAXED * w * TAU / (1.0 + (w * TAU).powi(2))
}

/// g rises with v for T and falls as fast, r = 1: f tends to v Q eps tau from its value at the turn, and has the same
/// size at both turns.
fn triangular(v: f64, t: f64) -> f64 {
    2.0 * K / (1.0 - RELAXED) * RELAXED * TAU * v * v * (t - 2.0 * TAU * (t / (2.0 * TAU)).tanh())
}

/// Problem 25.
pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    let because = "second order in a thousandth of the period";
    // Pressed all the time: with such a large b it never pulls.
    let (a, b) = (2e-4, 6e-4);
    for (r, period) in [(1.0, 5e-3), (1.0, 2e-2), (2.0, 5e-3), (2.0, 2e-2)] {
        let w = 2.0 * PI / period;
        let exact = sinusoidal(r, a, b, w);
        let [work, residual] = driven(r, period, 12, 1e-3 * period, |t| a * (1.0 - (w * t).cos()) + b);
        let name = |s: &str| format!("r = {r}, sinusoidal, {} ms: {s}", 1e3 * period);
        rows.push(ProblemRow::new(name("area of the loop"), "J", exact, work, 2e-5 * exact, because));
        rows.push(ProblemRow::new(name("energy residual over it"), "", 0.0, residual, 2e-5, because));
    }
    for half in [1e-3, 5e-3] {
        let v = 2.0 * a / half;
        let exact = triangular(v, half);
        let path = |t: f64| {
            let phase = (t / half) % 2.0;
            b + 2.0 * a * if phase < 1.0 { phase } else { 2.0 - phase }
        };
        let [work, _] = driven(1.0, 2.0 * half, 24, 1e-3 * half, path);
        let quantity = format!("r = 1, triangular, {} ms up: area of the loop", 1e3 * half);
        let because = "exact where u runs linearly: what is left are turns within a rounded step";
        rows.push(ProblemRow::new(quantity, "J", exact, work, 2e-5 * exact, because));
    }
    let loss = Loss::Hereditary(Hereditary { relaxed: 0.9, time: 1e-4 });
    let throw = |h: f64| throw_at(1.0, 5e7, 2.0, loss, h);
    let fine = throw(2.5e-7).rebound;
    let order = Order::halving(3.2e-5, 4, |h| (throw(h).rebound - fine).abs());
    let because = "the memory is exact for a compression that runs as g^r; it begins and ends smoothly";
    rows.push(ProblemRow::new("thrown at, r = 2: order of the rebound", "", 2.0, order.observed(), 0.4, because));
    let because = "what the felt holds it loses while it forgets";
    rows.push(ProblemRow::new("thrown at, h = 1 us: energy residual", "", 0.0, throw(1e-6).residual, 1e-5, because));
    let least = throw(5e-5).smallest_loss;
    let because = "of no exact sign in a step, as the mean of g^r is not that of a straight line";
    rows.push(ProblemRow::bounded(
        "thrown at, h = 50 us: smallest loss of a step, J",
        Expected::AtLeast(-1e-7),
        least,
        because,
    ));
    rows
}
