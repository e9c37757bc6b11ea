//! The one-degree-of-freedom model against the six bodies that it is derived from.

use crate::common::{Play, USUAL_STEP_S, grand, rigid_grand};
use erard::assembly::assemble;
use erard::grand::{Parts, front_weight_g};
use erard::instrument::Instrument;
use erard::one_dof::reduce;
use erard::player;
use erard::player::Action;
use erard::run::{Setup, simulate};
use moreau::{Energies, Settings, State};

/// Arm of the key front, m.
const ARM_M: f64 = 0.265;

/// Force at the key front under an imposed motion, with its instants.
fn force_of(instrument: &Instrument, motion: &dyn Fn(f64) -> [f64; 2], duration_s: f64) -> (Vec<f64>, Vec<f64>) {
    let setup = Setup { settings: Settings::new(USUAL_STEP_S), ..Setup::new(duration_s) };
    let run = simulate(instrument, &player::rigid(motion), &setup, &mut |_| true).unwrap();
    (run.time_s, run.force_n)
}

/// Static force down and up at a depth, N, from a slow journey of 5 mm/s (viscous forces below 1e-5 N).
fn slow(instrument: &Instrument, depth: f64) -> [f64; 2] {
    const V: f64 = 5e-3;
    let turn = 0.8;
    let motion = |t: f64| if t < turn { [V * t, V] } else { [V * (2.0 * turn - t), -V] };
    let (time, force) = force_of(instrument, &motion, 2.0 * turn);
    let mean = |middle: f64| {
        let near: Vec<f64> =
            time.iter().zip(&force).filter(|(t, _)| (*t - middle).abs() < 0.03).map(|(_, f)| *f).collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    [mean(depth / V), mean(2.0 * turn - depth / V)]
}

/// The moment alpha and the friction c_d that virtual power gives, against forces measured on the six bodies. What
/// rubs is loaded by the stack, so that friction grows with the stack's force S at the key front: down and up it is
/// S e^f and S e^-f, of which the key's own weight W at the front carries a part. The balance force is the
/// geometric mean of D + W and U + W less W, friction half the difference of D and U. The levers' ratio falls over
/// the stroke (by 3 % per mm), so that the forces at 1, 2 and 3 mm are extrapolated to rest; what is left is of
/// second order in the ratio's change over those 2 mm, (6 %)^2: below 1 %. Friction needs 8 %: at rest the lever
/// carries the hammer alone, while in motion the jack takes 0.05 N of it (0.25 of it over a slip of 0.08 m per
/// radian: 4 % of the friction), and what moves down presses a little harder than what moves up spares.
#[test]
fn moment_and_friction_are_those_of_the_mechanism() {
    let grand = grand();
    let one = reduce(&grand).unwrap();
    let forces = [1e-3, 2e-3, 3e-3].map(|depth| slow(&grand, depth));
    let locked = grand.locked();
    let own = 1e-3 * locked.gravity_m_per_s2 * front_weight_g(&locked, &Parts::of(&locked).unwrap(), ARM_M).unwrap();
    let [a, b, c] = forces.map(|[down, up]| ((down + own) * (up + own)).sqrt() - own);
    let balance = (4.0 * a + b - 2.0 * c) / 3.0;
    let [a, b, c] = forces.map(|[down, up]| (down - up) / 2.0);
    let friction = (4.0 * a + b - 2.0 * c) / 3.0;
    let (alpha, dry) = (-one.moment_n_m / ARM_M, one.instrument.bodies[0].friction_torque_n_m / ARM_M);
    println!("balance {balance:.4} N, alpha / arm {alpha:.4} N; friction {friction:.4} N, c_d / arm {dry:.4} N");
    assert!((balance / alpha - 1.0).abs() < 0.01, "{balance} {alpha}");
    assert!((friction / dry - 1.0).abs() < 0.08, "{friction} {dry}");
    // And the one-body mechanism itself gives back what it was made from (its finger moves on a circle: 1e-3).
    let [down, up] = slow(&one.instrument, 2e-3);
    assert!(((down + up) / 2.0 / alpha - 1.0).abs() < 1e-3);
    assert!(((down - up) / 2.0 / dry - 1.0).abs() < 1e-3);
}

/// J and alpha once more from first principles, body by body, at the rest pose: J = sum (I - m c^2) r^2 + m |v|^2 with
/// v the velocity of the centre of mass per unit key velocity, and alpha the loss of gravity's and the springs' energy
/// per unit key angle, by central differences of 1e-4 rad. The engine's mass matrix knows nothing of centres of mass'
/// velocities: agreement is to rounding for J, to the differences' 1e-8 for alpha.
#[test]
fn inertia_and_moment_from_first_principles() {
    let grand = rigid_grand();
    let one = reduce(&grand).unwrap();
    let action = Action::with(&grand, Settings::new(USUAL_STEP_S)).unwrap();
    let rest = action.mechanism();
    let r = &one.ratios;
    let along = |row: Vec<f64>| row.iter().zip(r).map(|(a, b)| a * b).sum::<f64>();
    let mut inertia = 0.0;
    for (i, body) in grand.bodies.iter().enumerate() {
        let c = body.center_of_mass_m;
        let [vx, vy] = [[1.0, 0.0], [0.0, 1.0]].map(|n| along(rest.velocity_row(i, c, n)));
        let own = body.inertia_kg_m2 - body.mass_kg * (c[0] * c[0] + c[1] * c[1]);
        inertia += own * r[i] * r[i] + body.mass_kg * (vx * vx + vy * vy);
    }
    assert!((inertia / one.inertia_kg_m2 - 1.0).abs() < 1e-12, "{inertia} {}", one.inertia_kg_m2);

    let model = assemble::<f64, 6, 14>(&grand).unwrap();
    let energy = |turn: f64| {
        let angle = core::array::from_fn(|i| rest.readout().angles[i] + turn * r[i]);
        let e = Energies::of(&model, &State::<f64, 6, 14>::at_rest(angle));
        e.gravity + e.spring
    };
    let moment = -(energy(1e-4) - energy(-1e-4)) / 2e-4;
    assert!((moment / one.moment_n_m - 1.0).abs() < 1e-6, "{moment} {}", one.moment_n_m);
}

/// In motion: under the softest force the six bodies take as long as the one to 4 mm of depth, where the damper comes
/// in. By what the reduction leaves out the six are faster: the ratio falls (mean inertia 10 % less, balance force 5 %
/// less, which is 6 % more of net force), and the key is free of the rest for the first quarter of a millimetre, while
/// the felts close. Together at most 25 % of the square of the time, which is what inertia over net force decides.
#[test]
fn both_models_take_as_long() {
    let grand = grand();
    let one = reduce(&grand).unwrap().instrument;
    let time = |instrument: &Instrument| {
        let run = Play::ForceStep(0.8, 1.0).run(instrument, Settings::new(USUAL_STEP_S), 0.2);
        run.time_s[run.key_m.iter().position(|y| *y > 4e-3).unwrap()]
    };
    let square = (time(&grand) / time(&one)).powi(2);
    println!("(time to 4 mm, six bodies over one)^2 = {square:.3}");
    assert!((0.75..1.0).contains(&square), "{square}");
}

/// The reduced instrument goes through the same calls, for every drive: it is pressed, meets key bottom, and, let go,
/// comes home to within what its friction and the back-rail cloth hold, as in `playing.rs`.
#[test]
fn the_same_calls_run_the_reduced_model() {
    use erard::stroke::Touch::{Pressed, Struck};
    let one = reduce(&grand()).unwrap().instrument;
    let plays =
        [Play::ForceStep(5.0, 0.3), Play::Stroke("mf", Pressed), Play::Motion("f", Struck), Play::Rigid("p", Pressed)];
    for play in plays {
        let run = play.run(&one, Settings::new(USUAL_STEP_S), 2.0);
        let last = run.time_s.len() - 1;
        assert!(run.events.key_start_s < run.events.key_bottom_s, "{play:?}");
        assert!(run.events.key_bottom_s.is_some() && run.events.hammer_contact_s().is_none(), "{play:?}");
        // A finger that stays on the key where its recording ends keeps the key there.
        if !matches!(play, Play::Motion(..) | Play::Rigid(..)) {
            assert!(
                run.key_m[last].abs() < crate::common::key_rests_within_m(&grand()),
                "{play:?}: {}",
                run.key_m[last]
            );
        }
        assert_eq!((run.bodies.len(), run.work.unconverged_steps), (1, 0), "{play:?}");
        assert!(
            run.ledger.as_ref().unwrap().residual_relative() < 1e-3,
            "{play:?}: {:e}",
            run.ledger.as_ref().unwrap().residual_relative()
        );
    }
}
