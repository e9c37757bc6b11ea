//! Problems 23, 24 and 27: felts with a rate-independent loss. A mass of 10 g thrown at a felt, and one resting on it.

use moreau::{
    Body, ContactCurve, Description, Elastoplastic, Exponent, Felt, GROUND, Iwan, Loss, SetValued, Settings, Zone,
};

use crate::felt::{ARM, MASS, throw_at, throw_from};
use crate::mechanism::Mechanism;
use moreau_rigid::problems::{Expected, Order, ProblemRow};

/// Felts with the stiffness of an action's: exponent and k.
const FELTS: [(f64, f64); 3] = [(2.0, 5e7), (2.5, 3e9), (3.0, 1e11)];

/// Closed forms after an arrival with 1/2 m v^2 = E, at any speed. F = k g^r (1 + eta Sign(dg/dt)) takes (1 + eta) W
/// for a compression G, with W = k G^(r+1)/(r+1), and returns (1 - eta) W. With a spring in series with the slider,
/// `slip` as in [`Loss::Elastoplastic`], the return begins with the spring, and the loss is 2 eta W (1 - slip)/(1 +
/// slip): in x = g^((r+1)/2) the loop is a triangle's two sides and the diagonal of a parallelogram. Sliders in
/// parallel lose the mean of that over their slips. Returns the speed of rebound over that of arrival; compression, m;
/// loss as a share of E.
fn dry_exact(r: f64, k: f64, eta: f64, slips: &[f64], speed: f64) -> [f64; 3] {
    let mean = slips.iter().map(|slip| (1.0 - slip) / (1.0 + slip)).sum::<f64>() / slips.len() as f64;
    let lost = 2.0 * eta / (1.0 + eta) * mean;
    let compression = ((r + 1.0) * MASS * speed * speed / (2.0 * k * (1.0 + eta))).powf(1.0 / (r + 1.0));
    [(1.0 - lost).sqrt(), compression, lost]
}

fn throws(loss: impl Fn(f64) -> Loss<f64>, slips: &[f64]) -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    let because = "second order: a few 1e-7 at h = 1 us where it is smooth, and h2/T2 where the felt turns";
    for ((r, k), eta) in FELTS.into_iter().zip([0.3, 0.15, 0.6]) {
        for speed in [0.1, 1.0, 3.0] {
            let [rebound, compression, lost] = dry_exact(r, k, eta, slips, speed);
            let t = throw_at(speed, k, r, loss(eta), 1e-6);
            let name = |s: &str| format!("r = {r}, eta = {eta}, {speed} m/s: {s}");
            rows.push(ProblemRow::new(name("rebound over arrival"), "", rebound, t.rebound / speed, 6e-6, because));
            rows.push(ProblemRow::new(
                name("largest compression"),
                "m",
                compression,
                t.compression,
                6e-6 * compression,
                because,
            ));
            let energy = 0.5 * MASS * speed * speed;
            rows.push(ProblemRow::new(name("loss over energy"), "", lost, t.lost / energy, 1e-5, because));
            rows.push(ProblemRow::new(name("energy residual, relative"), "", 0.0, t.residual, 6e-6, because));
        }
    }
    // Steps from a thousandth of the contact to all of it: a felt never gains energy.
    let mut least: f64 = 0.0;
    for h in [2e-6, 1e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3] {
        for (r, k) in FELTS {
            for speed in [0.05, 0.3, 1.0, 2.7] {
                least = least.min(throw_at(speed, k, r, loss(0.4), h).smallest_loss / (0.5 * MASS * speed * speed));
            }
        }
    }
    let because = "no step of any length gives energy: rounding";
    let quantity = "smallest loss of a step, h from 2 us to 5 ms, over the energy";
    rows.push(ProblemRow::bounded(quantity, Expected::AtLeast(-1e-12), least, because));
    // The phase of turning and slipping within a step is random: the largest error for eight distances to the felt.
    let exact = dry_exact(2.0, 5e7, 0.3, slips, 1.0)[0];
    let order = Order::halving(3.2e-5, 4, |h| {
        let error = |n: u32| {
            let ahead = (20.0 + f64::from(n) / 8.0) * h;
            (throw_from(ahead, 1.0, 5e7, 2.0, loss(0.3), h).rebound - exact).abs()
        };
        (0..8).map(error).fold(0.0, f64::max)
    });
    let because = "the force is a mean over the step, also where the felt turns or slips";
    rows.push(ProblemRow::new("r = 2: order of the rebound, h from 32 us", "", 2.0, order.observed(), 0.3, because));
    rows
}

/// Rebound over arrival and largest compression, m, of a felt with sliders and b beside its spring, by the Runge-Kutta
/// method of fourth order on the written branches: pressing F = (1 + eta) k g^r + b g^2 dg/dt; returning from X = x(G)
/// slider i is stretched by max(s_i X - (X - x), -s_i x) in x = g^m, m = (r + 1)/2.
fn damped_exact(r: f64, k: f64, b: f64, eta: f64, slips: &[f64], speed: f64) -> [f64; 2] {
    let (m, share) = (f64::midpoint(r, 1.0), eta / slips.len() as f64);
    let x = |g: f64| g.max(0.0).powf(m);
    // After `deepest` the felt opens.
    let acceleration = |g: f64, v: f64, deepest: Option<f64>| {
        let stretched = |slip: &f64| {
            let e = deepest.map_or(slip * x(g), |top| (slip * x(top) - (x(top) - x(g))).max(-slip * x(g)));
            share / slip * e
        };
        let elastic = k / m * (x(g) + slips.iter().map(stretched).sum::<f64>()) * m * g.max(0.0).powf(m - 1.0);
        // A felt never pulls: released, one with r = 3 lags behind.
        -(elastic + b * g * g * v).max(0.0) / MASS
    };
    let step = |[g, v]: [f64; 2], h: f64, deepest: Option<f64>| {
        let slope = |[g, v]: [f64; 2]| [v, acceleration(g, v, deepest)];
        let ahead = |[dg, dv]: [f64; 2], h: f64| [g + h * dg, v + h * dv];
        let first = slope([g, v]);
        let second = slope(ahead(first, 0.5 * h));
        let third = slope(ahead(second, 0.5 * h));
        let fourth = slope(ahead(third, h));
        let mean = |i: usize| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0;
        [g + h * mean(0), v + h * mean(1)]
    };
    let (h, mut at) = (1e-7, [0.0, speed]);
    // Ends at the turning point and at separation, each by a partial last step.
    while at[1] > 0.0 {
        let next = step(at, h, None);
        at = if next[1] > 0.0 { next } else { [step(at, h * at[1] / (at[1] - next[1]), None)[0], 0.0] };
    }
    let deepest = at[0];
    while at[0] > 0.0 {
        at = step(at, h, Some(deepest));
    }
    [-at[1] / speed, deepest]
}

/// Throws at felts that also lose by b.
fn damped_throws(loss: impl Fn(f64, f64) -> Loss<f64>, slips: &[f64]) -> Vec<ProblemRow> {
    let because = "second order: a few 1e-7 at h = 1 us; the reference is good to 1e-8";
    let felts = [(2.0, 5e7, 3e7, 0.3), (3.0, 1e11, 4e7, 0.15)];
    let rows = felts.map(|(r, k, b, eta)| {
        let [rebound, compression] = damped_exact(r, k, b, eta, slips, 1.0);
        let t = throw_at(1.0, k, r, loss(b, eta), 1e-6);
        let name = |s: &str| format!("r = {r}, eta = {eta}, b = {b:.0e}: {s}");
        [
            ProblemRow::new(name("rebound over arrival"), "", rebound, t.rebound, 6e-6, because),
            ProblemRow::new(name("largest compression"), "m", compression, t.compression, 6e-6 * compression, because),
        ]
    });
    rows.into_iter().flatten().collect()
}

/// A mass resting on a felt (r = 2) under a load of 1 N, with an impulse that gives it the speed `push`, m/s: at the
/// end of an arm as in [`crate::felt`].
fn standing(loss: Loss<f64>, push: f64) -> (Mechanism<1, 1, 2>, f64) {
    let (k, load) = (5e7, 1.0);
    let depth = f64::sqrt(load / k);
    let gravity = load / MASS;
    let body = Body { mass: MASS, center_of_mass: [ARM, 0.0], inertia: MASS * ARM * ARM, ..Body::inert() };
    let zone = Zone {
        disc_body: 0,
        center: [ARM, 0.0],
        radius: 0.0,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [0.0, depth], normal: [0.0, 1.0] },
        felt: Felt { stiffness: k, exponent: Exponent::new(2.0), loss },
        friction: None,
    };
    let description = Description { bodies: &[body], zones: &[zone], gravity, ..Description::default() };
    let settings = Settings { tolerance: 1e-12, ..Settings::new(1e-6) };
    let model = description.compile::<1, 1>().expect("sound");
    (Mechanism::new(model, [0.0], [push / ARM], settings), depth)
}

/// Problem 23.
pub(crate) fn set_valued() -> Vec<ProblemRow> {
    let mut rows = throws(|eta| Loss::SetValued(SetValued { eta }), &[0.0]);
    let (mut m, _) = standing(Loss::SetValued(SetValued { eta: 0.2 }), 0.0);
    m.run(0.05);
    let moved = m.value(m.state.angle[0] * ARM);
    let because = "locked: the felt holds any load within eta of its own";
    rows.push(ProblemRow::new("held felt, way in 50 ms", "m", 0.0, moved, 0.0, because));
    let (mut m, depth) = standing(Loss::SetValued(SetValued { eta: 0.2 }), -1e-4);
    m.run(0.05);
    // The push's energy over the loss: (1 + eta) k g^2 against the load, until it stops; to first order in the small
    // displacement.
    let way = MASS * 1e-8 / (2.0 * 0.2 * 1.0);
    let because = "the way is so short that the felt is as stiff as at its start: (way / depth)";
    let moved = m.value(-m.state.angle[0] * ARM);
    rows.push(ProblemRow::new(
        "held felt, way after a push",
        "m",
        way,
        moved,
        3.0 * way * way / depth + 2e-12,
        because,
    ));
    let speed = m.value(m.state.velocity[0] * ARM);
    rows.push(ProblemRow::new(
        "its speed then",
        "m/s",
        0.0,
        speed,
        1e-20,
        "what sticks without a dry pivot is still to rounding",
    ));
    rows
}

/// Problem 24.
pub(crate) fn elastoplastic() -> Vec<ProblemRow> {
    let (eta, slip) = (0.3, 0.2);
    let mut rows = throws(|eta| Loss::Elastoplastic(Elastoplastic { damping: 0.0, eta, slip }), &[slip]);
    rows.extend(damped_throws(|damping, eta| Loss::Elastoplastic(Elastoplastic { damping, eta, slip }), &[slip]));
    // After a small push the felt vibrates on its spring and its slider's spring, without loss, about its depth at
    // rest. There dF/dg = 2 k g + K (dx/dg)^2 = k g (2 + 3/2 eta/slip) for r = 2, with the slider's spring slack.
    let (mut m, depth) = standing(Loss::Elastoplastic(Elastoplastic { damping: 0.0, eta, slip }), 1e-5);
    let stiffness = 5e7 * depth * (2.0 + 1.5 * eta / slip);
    let period = 2.0 * std::f64::consts::PI * (MASS / stiffness).sqrt();
    let (mut crossings, mut first, mut last, mut largest) = (0, None, 0.0, 0.0_f64);
    while m.time < 0.2 {
        let before = m.state.angle[0];
        m.step();
        let now = m.state.angle[0];
        if before < 0.0 && now >= 0.0 {
            last = m.time - m.settings.step * now / (now - before);
            first = first.or(Some(last));
            crossings += 1;
        }
        if m.time > 0.19 {
            largest = largest.max(now.abs() * ARM);
        }
    }
    let ours = m.value((last - first.unwrap_or(f64::NAN)) / f64::from(crossings - 1));
    let because = "swings of a thousandth of the depth: the felt's curvature counts with their square";
    rows.push(ProblemRow::new("held felt, period of a small vibration", "s", period, ours, 1e-5 * period, because));
    let amplitude = 1e-5 * period / (2.0 * std::f64::consts::PI);
    let because = "no loss within the slider's bound; the felt is stiffer inward than outward";
    rows.push(ProblemRow::new(
        "its amplitude after 0.2 s",
        "m",
        amplitude,
        m.value(largest),
        3e-3 * amplitude,
        because,
    ));
    rows
}

/// Speed of rebound over that of arrival of 10 g thrown at `speed`, m/s, at a felt with a stiffness k, an exponent and
/// a loss; steps of `h` s.
#[must_use]
pub fn thrown_back(speed: f64, k: f64, r: f64, loss: Loss<f64>, h: f64) -> f64 {
    throw_at(speed, k, r, loss, h).rebound / speed
}

/// Problem 27.
pub(crate) fn sliders_in_parallel() -> Vec<ProblemRow> {
    let slips = [0.1, 0.2, 0.3, 0.4];
    let mut rows = throws(|eta| Loss::Iwan(Iwan { damping: 0.0, eta, slip: 0.4 }), &slips);
    rows.extend(damped_throws(|damping, eta| Loss::Iwan(Iwan { damping, eta, slip: 0.4 }), &slips));
    rows
}
