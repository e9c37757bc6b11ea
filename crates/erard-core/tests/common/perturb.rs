//! Random instruments and random strokes, each made from one number, so that a bad one can be made again.

use erard::instrument::{Curve, Instrument, Vec2};
use erard::mechanism::{open_ledger, update_energies};
use erard::player::equilibrium::EquilibriumError;
use erard::player::{Action, Input};
use erard::stroke::{Cursor, NUANCES, Series, Touch};
use moreau::{Ledger, Settings, StepOutcome};

use super::tremolo;

/// splitmix64: every seed, also 0, 1, 2 ..., begins a sequence of its own. Not a library's, whose sequences change with
/// its versions: a seed is the name of an instrument, by which it is spoken of and made again.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0xd134_2543_de82_ef95))
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [a, b).
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// One of n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// A factor between 1/x and x, uniform in its logarithm.
    pub fn factor(&mut self, x: f64) -> f64 {
        x.powf(self.between(-1.0, 1.0))
    }
}

/// Every length +-10 % (each coordinate and radius by itself), masses, friction torques, friction coefficients and
/// springs times or over 2, felts' stiffness times or over 3, damping times or over 2. An inertia follows its mass and
/// the square of its lengths, so that it stays that of a possible body. Nothing is regulated again: most of these would
/// not leave the workshop.
pub fn perturbed(grand: &Instrument, seed: u64) -> Instrument {
    let mut i = grand.clone();
    let mut r = Random::new(seed);
    fn length(r: &mut Random, p: &mut Vec2) {
        p.iter_mut().for_each(|x| *x *= r.between(0.9, 1.1));
    }
    // The arm of a pin is a device: its length is none of the instrument's, nor where the body lies on it.
    let is_device: Vec<bool> = (0..grand.bodies.len()).map(|body| grand.is_arm(body)).collect();
    i.edit(|fields| {
        for (k, body) in fields.bodies.iter_mut().enumerate() {
            if is_device[k] {
                body.friction_torque_n_m *= r.factor(2.0);
                continue;
            }
            let square = |c: Vec2| c[0] * c[0] + c[1] * c[1];
            let own = body.inertia_kg_m2 - body.mass_kg * square(body.center_of_mass_m);
            let (mass, size) = (r.factor(2.0), r.between(0.9, 1.1));
            if !body.parent.is_some_and(|parent| is_device[parent]) {
                length(&mut r, &mut body.pivot_m);
            }
            length(&mut r, &mut body.center_of_mass_m);
            body.mass_kg *= mass;
            body.inertia_kg_m2 = own * mass * size * size + body.mass_kg * square(body.center_of_mass_m);
            body.friction_torque_n_m *= r.factor(2.0);
            body.viscous_n_m_s *= r.factor(2.0);
        }
        for spring in &mut fields.springs {
            spring.torque_n_m *= r.factor(2.0);
            spring.stiffness_n_m_per_rad *= r.factor(2.0);
        }
        for zone in &mut fields.zones {
            length(&mut r, &mut zone.disc_center_m);
            zone.disc_radius_m *= r.between(0.9, 1.1);
            match &mut zone.curve {
                Curve::Line { point_m, .. } => length(&mut r, point_m),
                Curve::Segment { from_m, to_m, rounding_m } => {
                    length(&mut r, from_m);
                    length(&mut r, to_m);
                    *rounding_m *= r.between(0.9, 1.1);
                }
                Curve::Disc { center_m, radius_m } => {
                    length(&mut r, center_m);
                    *radius_m *= r.between(0.9, 1.1);
                }
            }
            zone.felt.stiffness *= r.factor(3.0);
            zone.felt.scale_loss(r.factor(2.0));
            zone.friction_coefficient *= r.factor(2.0);
        }
        length(&mut r, &mut fields.roles.key_front_m);
        fields.finger.stiffness_n_per_m *= r.factor(3.0);
        fields.finger.damping_n_s_per_m *= r.factor(2.0);
    })
    .expect("numbers only");
    i
}

/// The outcome of one random instrument.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fate {
    /// Its seed.
    pub seed: u64,
    /// Steps of the stroke.
    pub steps: u64,
    /// Number of these that did not converge.
    pub unconverged: u64,
    /// Newton iterations.
    pub newton: u64,
    /// Simulated time that it took to come to rest before the stroke, s.
    pub settling_s: f64,
    /// Largest |residual| of the energy balance at any time, over the energy that had been turned over by then (work
    /// put in, stored at the start, lost).
    pub residual: f64,
    /// Largest gain: stored + lost - start - work, where positive, over the same.
    pub gain: f64,
    /// Smallest dissipation term, J.
    pub smallest_term: f64,
    /// No rest was found to start from although no felt was pressed to half its thickness; it was played from where it
    /// was then.
    pub restless: bool,
    /// A number became infinite or not a number.
    pub not_finite: bool,
}

/// What moves the key.
enum Stroke {
    Force(Box<dyn Fn(f64) -> f64>),
    Motion(Box<dyn Fn(f64) -> [f64; 2]>),
    Rigid(Box<dyn Fn(f64) -> [f64; 2]>),
}

/// A random stroke: steps of force, built-in strokes as force, as motion and as imposed motion, repetition.
fn stroke(r: &mut Random) -> Stroke {
    let touch = if r.below(2) == 0 { Touch::Pressed } else { Touch::Struck };
    let series = Series::builtin(NUANCES[r.below(5)], touch).expect("built in");
    let (force, position) = (series.force.expect("has one"), series.position.expect("has one"));
    let at = move |t: f64| {
        let (y, v, _) = position.at(t, &mut Cursor::default());
        [y, v]
    };
    match r.below(5) {
        0 => {
            let (newtons, until) = (0.3 + 40.0 * r.unit().powi(2), r.between(0.02, 0.3));
            Stroke::Force(Box::new(move |t| if t < until { newtons } else { 0.0 }))
        }
        1 => Stroke::Force(Box::new(move |t| force.at(t, &mut Cursor::default()))),
        2 => Stroke::Motion(Box::new(at)),
        3 => Stroke::Rigid(Box::new(at)),
        _ => {
            let (top, bottom, frequency) = (r.between(0.0, 5e-3), r.between(6e-3, 11e-3), r.between(2.0, 14.0));
            Stroke::Motion(Box::new(move |t| tremolo(top, bottom, frequency, t)))
        }
    }
}

/// Every so many steps stock is taken of the energy.
const STOCK: u64 = 20;

/// Plays a random stroke on a random instrument. Never panics, or the test has found something.
pub fn play(grand: &Instrument, seed: u64, settings: Settings<f64>, duration_s: f64) -> Fate {
    play_on(&perturbed(grand, seed), seed, settings, duration_s)
}

/// Further searches for a rest, at most.
const SEARCHES: usize = 3;

/// Plays a random stroke on an instrument.
pub fn play_on(instrument: &Instrument, seed: u64, settings: Settings<f64>, duration_s: f64) -> Fate {
    let mut r = Random::new(seed ^ 0x5eed_0000_0000_0000);
    let stroke = stroke(&mut r);
    let mut fate = Fate { seed, ..Fate::default() };
    let mut action = Action::as_drawn(instrument, settings).expect("a valid instrument assembles");
    // A search gives up after so much work. What still creeps then, e.g. a jack that wedges a whippen, is searched on
    // from there.
    let search = |action: &mut Action| action.settle(instrument, Input::Free, &mut |_| true);
    let mut found = search(&mut action);
    for _ in 0..SEARCHES {
        if matches!(found, Err(EquilibriumError::NoRest { .. })) {
            found = search(&mut action);
        }
    }
    match found {
        Ok(time) => fate.settling_s = time,
        Err(EquilibriumError::NoRest { .. } | EquilibriumError::Unsolved { .. }) => {
            // A hammer wedged in its check by hundreds of newtons, a jack between its stops: felts of so much loss
            // creep on by 1e-6 to 1e-9 rad/s, slower by half every second.
            let is_wedged = instrument.zones.iter().enumerate().any(|(z, zone)| {
                zone.felt.thickness_m.is_some_and(|thick| action.mechanism().compression(z) > 0.5 * thick)
            });
            fate.restless = !is_wedged;
        }
        Err(_) => {
            fate.not_finite = true;
            return fate;
        }
    }
    action.set_reference_pose(instrument);
    let mut ledger = open_ledger(action.mechanism_mut());
    let (h, theta) = (settings.step, settings.theta);
    fate.steps = (duration_s / h) as u64;
    for n in 0..fate.steps {
        let t = n as f64 * h;
        let input = match &stroke {
            Stroke::Force(f) => Input::Force(f(t + theta * h)),
            Stroke::Motion(p) => {
                let [y, velocity] = p(t + theta * h);
                Input::Motion { position_m: y, velocity_m_per_s: velocity }
            }
            Stroke::Rigid(p) => {
                let [position_m, velocity_m_per_s] = p(t + h);
                Input::Rigid { position_m, velocity_m_per_s }
            }
        };
        match action.step(input).outcome {
            StepOutcome::Converged => {}
            StepOutcome::IterationLimit => fate.unconverged += 1,
            StepOutcome::NonFinite | StepOutcome::TooManyLaws => {
                fate.not_finite = true;
                return fate;
            }
        }
        fate.newton += u64::from(action.mechanism().readout().output.report.newton);
        action.mechanism().record_energy(&mut ledger);
        if n % STOCK == STOCK - 1 {
            update_energies(action.mechanism(), &mut ledger);
            fate.update_energies(&ledger);
        }
    }
    fate
}

impl Fate {
    fn update_energies(&mut self, ledger: &Ledger) {
        let turnover = ledger.drive_work_in + ledger.dissipated() + ledger.start.felt + ledger.start.spring.abs();
        let share = ledger.residual() / turnover.max(1e-6);
        self.residual = self.residual.max(share.abs());
        self.gain = self.gain.max(share);
        self.smallest_term = self.smallest_term.min(ledger.smallest_term);
    }
}
