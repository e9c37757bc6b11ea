//! Pin reactions obey Newton's laws, and what is lost is lost somewhere.

use crate::common::energy_audit::EnergyAudit;
use crate::common::{USUAL_STEP_S, grand};
use erard::instrument::{Body, Finger, Instrument, InstrumentFields, Origin, Roles, Vec2};
use erard::mechanism::Mechanism;
use erard::player::{Action, Input, Losses, Observer, ReactionRecorder, Reactions};
use erard::run::{Setup, simulate_observed};
use erard::stroke::{Series, Touch};
use moreau::{Loss, Settings};

/// A physical pendulum that is let go level: one body on the ground, without friction.
fn pendulum() -> Instrument {
    let fields = InstrumentFields {
        name: "pendulum".into(),
        gravity_m_per_s2: 9.81,
        bodies: vec![Body {
            name: "bob".into(),
            parent: None,
            pivot_m: [0.3, 0.2],
            angle_rad: 0.0,
            mass_kg: 0.5,
            inertia_kg_m2: 0.02,
            center_of_mass_m: [0.15, 0.0],
            friction_torque_n_m: 0.0,
            viscous_n_m_s: 0.0,
            dwell: None,
            is_bend: false,
            turn_rad: None,
        }],
        springs: Vec::new(),
        zones: Vec::new(),
        roles: Roles::default(),
        strings: Vec::new(),
        bridge_modes: Vec::new(),
        finger: Finger::default(),
        screws: Vec::new(),
        parts: Vec::new(),
        origin: Origin::default(),
    };
    Instrument::new(fields).unwrap()
}

/// At every angle phi below the level, omega^2 = 2 m g l sin(phi) / J and alpha = -m g l cos(phi) / J; so the pin
/// carries, along the pendulum toward the pin, m g sin(phi) + m l omega^2, and across it m g cos(phi) (1 - m l^2 / J).
/// To 1e-6 of the weight at 50 us.
#[test]
fn a_pendulum_hangs_on_its_pin() {
    let pendulum = pendulum();
    let body = &pendulum.bodies[0];
    let (m, j, l, g) = (body.mass_kg, body.inertia_kg_m2, body.center_of_mass_m[0], pendulum.gravity_m_per_s2);
    let settings = Settings { tolerance: 1e-13, ..Settings::new(USUAL_STEP_S) };
    let mut action = Action::as_drawn(&pendulum, settings).unwrap();
    let mut reactions = Reactions::open(&pendulum, action.mechanism());
    let mut worst = 0.0_f64;
    for _ in 0..6000 {
        let before = action.angles()[0];
        action.step(Input::Free);
        reactions.observe(action.mechanism());
        // The step's forces belong to its middle.
        let phi = -0.5 * (before + action.angles()[0]);
        let along = m * g * phi.sin() + m * l * (2.0 * m * g * l * phi.sin() / j);
        let across = m * g * phi.cos() * (1.0 - m * l * l / j);
        // From the bob to the pin, and upward across it.
        let (to_pin, up) = ([-phi.cos(), phi.sin()], [phi.sin(), phi.cos()]);
        let expected: Vec2 = [0, 1].map(|axis| along * to_pin[axis] + across * up[axis]);
        let found = reactions.pin_n()[0];
        worst = worst.max((found[0] - expected[0]).hypot(found[1] - expected[1]) / (m * g));
        let alpha = -m * g * l * phi.cos() / j;
        let found = reactions.acceleration_rad_per_s2()[0];
        assert!((found - alpha).abs() < 1e-9 * m * g * l / j, "{phi}: {found} {alpha}");
        assert!(reactions.moment_n_m()[0].abs() < 1e-10 * m * g * l, "{phi}");
    }
    println!("a pendulum's pin is off by {worst:.1e} of its weight at most");
    assert!(worst < 1e-6, "{worst:e}");
}

/// Every step of a stroke, looked at from outside: forces as they acted, positions where the steps ended.
struct Witness {
    instrument: Instrument,
    reactions: Reactions,
    /// Sum of all forces on each body in each step: pins by [`Reactions`], all else summed here.
    force: Vec<Vec<Vec2>>,
    /// Centres of mass after each step, and before the first.
    center: Vec<Vec<Vec2>>,
    /// What Euler's law leaves over in each step.
    moment: Vec<Vec<f64>>,
    step_s: f64,
}

impl Witness {
    fn of(grand: &Instrument, stroke: &str, settings: Settings<f64>, duration_s: f64) -> Self {
        let series = Series::builtin(stroke, Touch::Pressed).unwrap();
        let force = series.force.as_ref().unwrap().drive();
        let start_s = series.start_s();
        let setup = Setup { settings, start_s, ledger: false, ..Setup::new(duration_s) };
        let mut witness = Witness {
            reactions: Reactions::open(grand, Action::as_drawn(grand, settings).unwrap().mechanism()),
            instrument: grand.clone(),
            force: Vec::new(),
            center: Vec::new(),
            moment: Vec::new(),
            step_s: settings.step,
        };
        simulate_observed(grand, &move |t| Input::Force(force(t)), &setup, &mut witness, &mut |_| true).unwrap();
        witness
    }

    fn centers(&self, m: &dyn Mechanism) -> Vec<Vec2> {
        let bodies = self.instrument.bodies.iter().enumerate();
        bodies.map(|(i, body)| m.point(Some(i), body.center_of_mass_m)).collect()
    }
}

impl Observer for Witness {
    fn begin(&mut self, _: f64, m: &dyn Mechanism) {
        self.reactions = Reactions::open(&self.instrument, m);
        self.center.push(self.centers(m));
    }

    fn step(&mut self, _: f64, _: bool, m: &dyn Mechanism) {
        self.reactions.observe(m);
        let pins = self.reactions.pin_n();
        let mut sum: Vec<Vec2> =
            self.instrument.bodies.iter().map(|b| [0.0, -b.mass_kg * self.instrument.gravity_m_per_s2]).collect();
        let mut push = |body: Option<usize>, by: Vec2, sign: f64| {
            if let Some(body) = body {
                sum[body] = [sum[body][0] + sign * by[0], sum[body][1] + sign * by[1]];
            }
        };
        for (i, body) in self.instrument.bodies.iter().enumerate() {
            push(Some(i), pins[i], 1.0);
            push(body.parent, pins[i], -1.0);
        }
        for (z, zone) in self.instrument.zones.iter().enumerate() {
            let Some(c) = &m.readout().contacts[z] else { continue };
            let t = m.readout().tangential_forces[z];
            let by = [c.force * c.normal[0] + t * c.normal[1], c.force * c.normal[1] - t * c.normal[0]];
            push(zone.disc_body, by, 1.0);
            push(zone.curve_body, by, -1.0);
        }
        push(self.instrument.roles.key, [0.0, -m.readout().output.drive_n], 1.0);
        self.force.push(sum);
        self.center.push(self.centers(m));
        self.moment.push(self.reactions.moment_n_m().to_vec());
    }
}

/// Newton's second law, body by body: all forces, the pins' among them, against mass times the second difference of
/// where the centres of mass were. Differences over two steps belong to the mean of the forces of both. What is left is
/// of the differences' second order: it falls by more than a factor of ten from 50 us to 12.5 us (16 where nothing
/// begins or ends between), and is below 1e-4 of the body's largest force.
#[test]
fn forces_are_mass_times_the_differences_of_positions() {
    let off = [1.0, 0.25].map(|part| {
        let w = Witness::of(&grand(), "f", Settings { tolerance: 1e-13, ..Settings::new(part * USUAL_STEP_S) }, 0.08);
        let h = w.step_s;
        let mut worst = Vec::new();
        for (i, body) in w.instrument.bodies.iter().enumerate() {
            let mass = body.mass_kg;
            let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
            for n in 1..w.force.len() {
                let [a, b, c] = [n - 1, n, n + 1].map(|k| w.center[k][i]);
                let off = [0, 1].map(|axis| {
                    let mean = 0.5 * (w.force[n - 1][i][axis] + w.force[n][i][axis]);
                    largest = largest.max(mean.abs());
                    mean - mass * (c[axis] - 2.0 * b[axis] + a[axis]) / (h * h)
                });
                sum += off[0] * off[0] + off[1] * off[1];
                count += 1.0;
            }
            // Of all the body's forces, pins included, for they cancel in the sum.
            worst.push((sum / f64::max(count, 1.0)).sqrt() / largest);
        }
        worst
    });
    println!(
        "root mean square of F - m a, of the largest F, body by body, at 50 and 12.5 us: {:?} {:?}",
        off[0], off[1]
    );
    for (coarse, fine) in off[0].iter().zip(&off[1]) {
        assert!(*fine < 1e-4 && *fine < coarse / 10.0, "{off:?}");
    }
}

/// Momentum: over a stroke, the impulses of weight, finger, ground and pins on each body are what its momentum has
/// changed by, from positions.
#[test]
fn impulses_are_changes_of_momentum() {
    let w = Witness::of(&grand(), "ff", Settings { tolerance: 1e-13, ..Settings::new(0.25 * USUAL_STEP_S) }, 0.06);
    let h = w.step_s;
    let steps = w.force.len();
    for (i, body) in w.instrument.bodies.iter().enumerate() {
        let mut largest = 0.0_f64;
        let mut impulse = [0.0; 2];
        for force in &w.force[1..] {
            for axis in 0..2 {
                impulse[axis] += force[i][axis] * h;
                largest = largest.max(impulse[axis].abs());
            }
        }
        for (axis, impulse) in impulse.into_iter().enumerate() {
            let velocity = |n: usize| (w.center[n][i][axis] - w.center[n - 1][i][axis]) / h;
            // From the middle of the first step to that of the last: half of each one's force.
            let between = impulse + 0.5 * h * (w.force[0][i][axis] - w.force[steps - 1][i][axis]);
            let change = body.mass_kg * (velocity(steps) - velocity(1));
            assert!((between - change).abs() < 1e-4 * largest, "{}: {between:e} {change:e} {largest:e}", body.name);
        }
    }
}

/// Euler's law about each pin, which the reactions were not made from. The damper, which carries nothing and rubs on
/// nothing, obeys it to rounding. The engine takes inertia's couplings and the direction of rubbing at the pose that it
/// predicts for the step, so that on the others some 1e-5 of moments of several N m is left at 50 us (the whippen under
/// a key that bends has most), and less than a tenth of that, or 1e-8, at a quarter of the step. In felts with sliders,
/// which give at instants inside a step, it falls more slowly than with the square of the step: to less than a quarter.
#[test]
fn moments_about_the_pins_balance() {
    let mut smooth = grand();
    smooth
        .edit(|fields| {
            for zone in &mut fields.zones {
                zone.felt.loss = Loss::quadratic(zone.felt.loss.viscous(1.0, 0.0));
            }
        })
        .unwrap();
    moments_balance(&smooth, 10.0);
    moments_balance(&grand(), 4.0);
}

fn moments_balance(instrument: &Instrument, falls: f64) {
    let left = [1.0, 0.25].map(|part| {
        let w = Witness::of(instrument, "f", Settings { tolerance: 1e-13, ..Settings::new(part * USUAL_STEP_S) }, 0.08);
        (0..w.instrument.bodies.len())
            .map(|i| w.moment.iter().fold(0.0_f64, |worst, step| worst.max(step[i].abs())))
            .collect::<Vec<f64>>()
    });
    println!("largest moment left over, N m, body by body, at 50 and 12.5 us: {:?} {:?}", left[0], left[1]);
    for (coarse, fine) in left[0].iter().zip(&left[1]) {
        assert!(*coarse < 1e-4 && (*fine < coarse / falls || *fine < 1e-8), "{left:?}");
    }
    let damper = crate::common::body(&grand(), "damper");
    assert!(left.iter().all(|left| left[damper] < 1e-12), "{left:?}");
}

/// Keeps both books.
struct Books {
    instrument: Instrument,
    losses: Option<Losses>,
}

impl Observer for Books {
    fn begin(&mut self, _: f64, m: &dyn Mechanism) {
        self.losses = Some(Losses::open(&self.instrument, m));
    }

    fn step(&mut self, _: f64, _: bool, m: &dyn Mechanism) {
        self.losses.as_mut().unwrap().observe(m);
    }
}

/// What all pins and contacts have lost is what the engine's ledger says was lost, kind by kind, to rounding; and no
/// loss is a gain.
#[test]
fn losses_add_up_to_the_ledger() {
    let grand = grand();
    for stroke in ["pp", "mf", "ff"] {
        let series = Series::builtin(stroke, Touch::Struck).unwrap();
        let force = series.force.as_ref().unwrap().drive();
        let setup = Setup { start_s: series.start_s(), ..Setup::new(0.6) };
        let mut books = Books { instrument: grand.clone(), losses: None };
        let run =
            simulate_observed(&grand, &move |t| Input::Force(force(t)), &setup, &mut books, &mut |_| true).unwrap();
        let (ledger, losses) = (run.ledger.unwrap(), books.losses.unwrap());
        let sums = [
            (ledger.pivot_dry, losses.pins().iter().map(|pin| pin.dry_j).sum::<f64>()),
            (ledger.pivot_viscous, losses.pins().iter().map(|pin| pin.viscous_j).sum()),
            (ledger.felt_damping, losses.contacts().iter().map(|contact| contact.felt_j).sum()),
            (ledger.coulomb, losses.contacts().iter().map(|contact| contact.sliding_j).sum()),
        ];
        for (booked, summed) in sums {
            assert!((summed - booked).abs() < 1e-10 * booked, "{stroke}: {sums:?}");
        }
        assert!(losses.pins().iter().all(|pin| pin.dry_j >= 0.0 && pin.viscous_j >= 0.0));
        assert!(losses.contacts().iter().all(|contact| contact.felt_j >= 0.0 && contact.sliding_j >= 0.0));
    }
}

/// Where the error is controlled the same holds: losses add up to the ledger, which books the same halves of steps,
/// kind by kind. Steps are of any length there; what books that are kept from outside say of sliding, with the slip at
/// the ends of steps, agrees the better the smaller the error.
#[test]
fn controlled_steps_lose_what_the_ledger_says() {
    let grand = grand();
    let series = Series::builtin("f", Touch::Struck).unwrap();
    let sliding = [1e-4, 1e-7].map(|tolerance| {
        let force = series.force.as_ref().unwrap().drive();
        let drive = move |t| Input::Force(force(t));
        let setup = Setup { start_s: series.start_s(), tolerance: Some(tolerance), ..Setup::new(0.4) };
        let mut books = Books { instrument: grand.clone(), losses: None };
        let run = simulate_observed(&grand, &drive, &setup, &mut books, &mut |_| true).unwrap();
        let mut audit = EnergyAudit::new(&grand, &drive);
        simulate_observed(&grand, &drive, &setup, &mut audit, &mut |_| true).unwrap();
        let (ledger, losses) = (run.ledger.unwrap(), books.losses.unwrap());
        for (booked, summed) in [
            (ledger.pivot_dry, losses.pins().iter().map(|pin| pin.dry_j).sum::<f64>()),
            (ledger.pivot_viscous, losses.pins().iter().map(|pin| pin.viscous_j).sum()),
            (ledger.felt_damping, losses.contacts().iter().map(|contact| contact.felt_j).sum()),
            (ledger.coulomb, losses.contacts().iter().map(|contact| contact.sliding_j).sum()),
        ] {
            assert!((summed - booked).abs() < 1e-10 * booked, "{tolerance:e}: {summed:e} {booked:e}");
        }
        let [dry, viscous, _, sliding] = audit.lost_j();
        for (booked, outside) in [(ledger.pivot_dry, dry), (ledger.pivot_viscous, viscous)] {
            assert!((outside - booked).abs() < 1e-10 * booked, "{tolerance:e}: {outside:e} {booked:e}");
        }
        (sliding - ledger.coulomb).abs() / ledger.coulomb
    });
    println!("sliding losses, from outside and booked, differ by {sliding:?} of them at tolerances 1e-4 and 1e-7");
    assert!(sliding[0] < 1e-3 && sliding[1] < sliding[0] / 3.0, "{sliding:?}");
}

/// Pin reactions of a run whose error is controlled, against those of fixed steps, pin by pin and row by row: the two
/// schemes share the laws and nothing of how long steps are. Fixed steps come nearer to it as they are made shorter (by
/// the root of the mean square, for where a felt is met one row differs by what the force grows in a step).
#[test]
fn reactions_of_controlled_steps_are_the_limit_of_short_steps() {
    let grand = crate::common::rigid_grand();
    let series = Series::rigid("f", Touch::Pressed).unwrap();
    let play = |settings: Settings<f64>, record_every: u64, tolerance: Option<f64>| {
        let force = series.force.as_ref().unwrap().drive();
        let setup = Setup {
            settings,
            start_s: series.start_s(),
            record_every: Some(record_every),
            tolerance,
            ledger: false,
            ..Setup::new(0.08)
        };
        let mut recorder = ReactionRecorder::new(&grand);
        let run =
            simulate_observed(&grand, &move |t| Input::Force(force(t)), &setup, &mut recorder, &mut |_| true).unwrap();
        (run, recorder.into_series())
    };
    let (limit_run, limit) = play(Settings::new(USUAL_STEP_S), 1, Some(1e-6));
    let off = [1, 8].map(|finer| {
        let (run, pins) = play(Settings::new(USUAL_STEP_S / finer as f64), finer, None);
        assert_eq!(run.time_s.len(), limit_run.time_s.len());
        pins.iter()
            .zip(&limit)
            .map(|(fixed, controlled)| {
                let (mut sum, mut scale) = (0.0, 0.0_f64);
                for ((x, y), (cx, cy)) in
                    fixed.pin_x_n.iter().zip(&fixed.pin_y_n).zip(controlled.pin_x_n.iter().zip(&controlled.pin_y_n))
                {
                    sum += (x - cx).powi(2) + (y - cy).powi(2);
                    scale = scale.max(cx.hypot(*cy));
                }
                (sum / fixed.pin_x_n.len() as f64).sqrt() / scale
            })
            .collect::<Vec<f64>>()
    });
    println!(
        "pins, root mean square from the controlled run, of the largest force: at 50 us {:?}, at 6.25 us {:?}",
        off[0], off[1]
    );
    for (coarse, fine) in off[0].iter().zip(&off[1]) {
        assert!(*fine < 2e-3 && *fine < coarse / 3.0, "{off:?}");
    }
}
