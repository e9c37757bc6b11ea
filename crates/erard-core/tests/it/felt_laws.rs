//! Felts with a dry loss, and felts with an internal state, in the whole action: the energy balance closes, rest is
//! rest, solvers agree, states can be saved.

use crate::common::perturb::{Random, perturbed, play_on};
use crate::common::{Play, USUAL_STEP_S, grand};
use erard::instrument::{Dwell, Felt, Instrument};
use erard::parameter::Parameter;
use erard::player::{Action, Input};
use erard::stroke::Touch;
use moreau::{Elastoplastic, Hereditary, Loss, SetValued, Settings, Solver};

type Law = fn(&mut Felt);

const SET_VALUED: [(&str, Law); 2] =
    [("set-valued", |felt| lose_by_sides(felt, 0.3)), ("set-valued, less", |felt| lose_by_sides(felt, 0.1))];

/// With the stiffness that the built-in felt shows under load.
fn lose_by_sides(felt: &mut Felt, eta: f64) {
    if let Loss::Iwan(iwan) = felt.loss {
        felt.stiffness *= 1.0 + iwan.eta;
    }
    felt.loss = SetValued { eta }.into();
}

const LAWS: [(&str, Law); 3] = [
    ("elastoplastic", |felt| felt.loss = Elastoplastic { damping: 0.0, eta: 0.3, slip: 0.2 }.into()),
    ("elastoplastic beside b", |felt| {
        felt.loss = Elastoplastic { damping: felt.loss.viscous(1.0, 0.0), eta: 0.3, slip: 0.1 }.into();
    }),
    ("hereditary", |felt| felt.loss = Hereditary { relaxed: 0.5, time: 1e-3 }.into()),
];

fn with(law: Law) -> Instrument {
    let mut instrument = grand();
    instrument.edit(|fields| fields.zones.iter_mut().for_each(|zone| law(&mut zone.felt))).unwrap();
    instrument
}

/// Whole notes: every step converges, the energy balance closes as it does with the papers' loss, and no loss is a
/// gain.
#[test]
fn the_balance_closes() {
    for (name, law) in LAWS {
        let instrument = with(law);
        for play in [Play::Stroke("f", Touch::Pressed), Play::Stroke("mf", Touch::Struck), Play::ForceStep(12.0, 0.6)] {
            let run = play.run(&instrument, Settings::new(USUAL_STEP_S), 1.0);
            let ledger = run.ledger.as_ref().unwrap();
            println!(
                "{name}, {play:?}: residual {:.1e}, felts {:.2e} J, smallest {:.1e}, {} Newton iterations, {} unconverged, {:?} m/s",
                ledger.residual_relative(),
                ledger.felt_damping,
                ledger.smallest_term,
                run.work.newton_iterations,
                run.work.unconverged_steps,
                run.events.hammer_speed_m_per_s()
            );
            assert_eq!(run.work.unconverged_steps, 0, "{name}");
            assert!(ledger.residual_relative() < 3e-4, "{name}: {:.1e}", ledger.residual_relative());
            // An elastoplastic felt's loss is a difference of energies, and rounded as such; Stulov's has a sign to
            // second order in the step only.
            let least = if name == "hereditary" { -1e-4 * ledger.felt_damping } else { -1e-15 };
            assert!(ledger.smallest_term >= least, "{name}: {:.1e}", ledger.smallest_term);
            assert!(run.events.hammer_speed_m_per_s().is_some_and(|speed| speed > 1.0), "{name}");
        }
    }
}

/// The set-valued loss locks what the felts hold, and in a whole action more felts than there are freedoms. There the
/// step does not always find its laws' sides: it says so, the note is played all the same, and the hammer's speed is
/// known to two thousandths. That is one of the reasons for the elastoplastic law (`docs/notes/felt-losses.md`); a
/// single felt has none of it (problem 23).
#[test]
fn a_set_valued_loss_plays_but_not_every_step_is_settled() {
    for (name, law) in SET_VALUED {
        let mut instrument = with(law);
        let edited = instrument.edit(|fields| {
            for zone in fields.zones.iter_mut().filter(|z| ["capstan_heel", "lever_knuckle"].contains(&z.name.as_str()))
            {
                zone.friction_coefficient = 0.0;
            }
        });
        edited.unwrap();
        let run = |solver| {
            let settings = Settings { solver, ..Settings::new(USUAL_STEP_S) };
            Play::Stroke("f", Touch::Pressed).run(&instrument, settings, 1.0)
        };
        let runs = [Solver::ActiveSet, Solver::ProjectedGaussSeidel].map(run);
        for run in &runs {
            let ledger = run.ledger.as_ref().unwrap();
            println!(
                "{name}: residual {:.1e}, {} of {} steps unconverged, {:?} m/s",
                ledger.residual_relative(),
                run.work.unconverged_steps,
                run.work.steps,
                run.events.hammer_speed_m_per_s()
            );
            assert!(ledger.residual_relative() < 1e-2, "{name}");
        }
        let speeds = runs.each_ref().map(|run| run.events.hammer_speed_m_per_s().unwrap());
        assert!(runs[0].work.unconverged_steps * 15 < runs[0].work.steps, "{name}");
        assert!((speeds[0] / speeds[1] - 1.0).abs() < 2e-3, "{name}: {speeds:?}");
    }
}

/// A held note stands still to the bit, and a released action too.
#[test]
fn rest_is_rest() {
    for (name, law) in LAWS.into_iter().chain(SET_VALUED) {
        let mut action = Action::with(&with(law), Settings::new(USUAL_STEP_S)).unwrap();
        for force_n in [12.0, 0.0] {
            for _ in 0..20_000 {
                action.step(Input::Force(force_n));
            }
            let held = action.angles().to_vec();
            for _ in 0..20_000 {
                action.step(Input::Force(force_n));
            }
            for (before, now) in held.iter().zip(action.angles()) {
                assert_eq!(before.to_bits(), now.to_bits(), "{name} under {force_n} N: {before} {now}");
            }
        }
    }
}

/// Two solvers that share no code give one motion. Where felts are locked their forces are not unique, the velocities
/// are.
#[test]
fn solvers_agree_on_the_motion() {
    for (name, law) in LAWS {
        let instrument = with(law);
        let speed = |solver| {
            let settings = Settings { solver, ..Settings::new(USUAL_STEP_S) };
            let run = Play::Stroke("mf", Touch::Pressed).run(&instrument, settings, 0.3);
            run.events.hammer_speed_m_per_s().unwrap()
        };
        let speeds = [Solver::ActiveSet, Solver::ProjectedGaussSeidel].map(speed);
        assert!((speeds[0] / speeds[1] - 1.0).abs() < 1e-6, "{name}: {speeds:?}");
    }
}

/// A snapshot in the middle of a note holds all that the following steps depend on.
#[test]
fn a_note_goes_on_from_a_snapshot() {
    for (name, law) in LAWS {
        let instrument = with(law);
        let mut action = Action::with(&instrument, Settings::new(USUAL_STEP_S)).unwrap();
        let mut other = Action::with(&instrument, Settings::new(USUAL_STEP_S)).unwrap();
        for n in 0..2_000 {
            action.step(Input::Force(9.0));
            if n == 700 {
                other.restore(&action.save()).unwrap();
            } else if n > 700 {
                other.step(Input::Force(9.0));
            }
        }
        assert_eq!(action.angles(), other.angles(), "{name}");
    }
}

/// Random instruments, every felt with a loss of its own: nothing breaks, no step is left unconverged, no loss is a
/// gain.
#[test]
fn nothing_breaks_at_random() {
    nothing_breaks(0..12);
}

#[test]
#[ignore = "ci: 120 random instruments"]
fn nothing_of_much_breaks_at_random() {
    nothing_breaks(0..120);
}

fn nothing_breaks(seeds: std::ops::Range<u64>) {
    let (grand, settings) = (grand(), Settings::new(USUAL_STEP_S));
    let (mut steps, mut unconverged) = (0, 0);
    for seed in seeds {
        let (mut instrument, mut r) = (perturbed(&grand, seed), Random::new(seed + 1_000_000));
        instrument
            .edit(|fields| {
                for zone in &mut fields.zones {
                    let felt = &mut zone.felt;
                    let damping = match r.below(3) {
                        0 => continue,
                        1 => felt.loss.viscous(1.0, 0.0),
                        _ => 0.0,
                    };
                    felt.loss = Elastoplastic { damping, eta: r.between(0.05, 0.6), slip: r.between(0.05, 0.5) }.into();
                }
            })
            .unwrap();
        let fate = play_on(&instrument, seed, settings, 0.4);
        assert!(!fate.not_finite && !fate.restless, "{seed}: {fate:?}");
        assert!(fate.gain < 1e-2 && fate.residual < 1e-2, "{seed}: {fate:?}");
        // A difference of energies is rounded: some of these felts hold a joule.
        assert!(fate.smallest_term >= -1e-13, "{seed}: {fate:?}");
        (steps, unconverged) = (steps + fate.steps, unconverged + fate.unconverged);
    }
    println!("{unconverged} of {steps} steps unconverged");
    assert_eq!(unconverged, 0, "of {steps} steps");
}

/// Friction that grows at rest: whole notes with it at every pivot and every sliding contact, as hard to move as the
/// estimates say.
#[test]
fn friction_that_grows_at_rest_plays() {
    let mut instrument = grand();
    let dwell = Some(Dwell { ratio: 1.3, time_s: 0.2 });
    instrument
        .edit(|fields| {
            fields.bodies.iter_mut().filter(|body| body.friction_torque_n_m > 0.0).for_each(|body| body.dwell = dwell);
            fields.zones.iter_mut().filter(|zone| zone.friction_coefficient > 0.0).for_each(|zone| zone.dwell = dwell);
        })
        .unwrap();
    for solver in [Solver::ActiveSet, Solver::ProjectedGaussSeidel] {
        let settings = Settings { solver, ..Settings::new(USUAL_STEP_S) };
        let run = Play::Stroke("mf", Touch::Pressed).run(&instrument, settings, 1.0);
        let ledger = run.ledger.as_ref().unwrap();
        println!(
            "{solver:?}: {:?} m/s, residual {:.1e}",
            run.events.hammer_speed_m_per_s(),
            ledger.residual_relative()
        );
        assert!(run.work.unconverged_steps == 0 || solver == Solver::ProjectedGaussSeidel);
        assert!(ledger.residual_relative() < 3e-4 && ledger.smallest_term >= 0.0);
        assert!(run.events.hammer_speed_m_per_s().is_some_and(|speed| speed > 1.0));
    }
    // What rested takes more force to move: the hammer leaves its rest later, under a force that grows by 1 N in 0.1 s.
    // On a nailed key: one that lies sinks into its punching before it turns, and turns the shank by that.
    let nailed = |instrument: &Instrument| instrument.nailed(crate::common::body(instrument, "key_back")).unwrap();
    let shank = crate::common::body(&nailed(&instrument), "shank");
    let moves_at = |instrument: &Instrument, rest_s: f64| {
        let mut action = Action::with(&nailed(instrument), Settings::new(USUAL_STEP_S)).unwrap();
        let mut n = 0.0;
        for _ in 0..(rest_s / USUAL_STEP_S) as u32 {
            action.step(Input::Force(0.0));
        }
        let start = action.angles()[shank];
        while (action.angles()[shank] - start).abs() < 1e-8 {
            action.step(Input::Force(n));
            n += 10.0 * USUAL_STEP_S;
            assert!(n < 3.0);
        }
        n
    };
    let [plain, at_once, later] =
        [(&grand(), 3.0), (&instrument, 0.0), (&instrument, 3.0)].map(|(i, s)| moves_at(i, s));
    println!("moves at {at_once} N, after 3 s at {later} N, without growth at {plain} N");
    // The key's own pin alone grows by that; half of it, and more, is still to come when the force comes at once.
    let key = crate::common::body(&instrument, "key_back");
    let grown_n = 0.3 * instrument.bodies[key].friction_torque_n_m / instrument.roles.key_front_m[0].abs();
    assert!(later > plain + grown_n && later > at_once + 0.5 * grown_n, "{grown_n}");
}

/// A bushing is an option of the file: a body and a spring more, and locked it is the instrument that it was.
#[test]
fn bushings() {
    let text = Instrument::builtin_text("concert-grand").unwrap();
    let at = text.find("name = \"whippen\"").unwrap();
    let with = format!("{}bushing_N_per_m = 1e5\nbushing_N_s_per_m = 5\n{}", &text[..at], &text[at..]);
    let read = |text: &str| Instrument::parse(text, "a file").unwrap();
    let (without, with) = (read(text), read(&with));
    assert_eq!(with.bodies.len(), without.bodies.len() + 1);
    assert_eq!(with.springs.len(), without.springs.len() + 1);
    let (locked, rigid) = (with.locked(), without.locked());
    assert_eq!((locked.bodies.len(), &locked.springs), (rigid.bodies.len(), &rigid.springs));
    assert_eq!((&locked.zones, &locked.roles), (&rigid.zones, &rigid.roles));
    for (a, b) in locked.bodies.iter().zip(&rigid.bodies) {
        assert_eq!((&a.name, a.parent, a.mass_kg, a.inertia_kg_m2), (&b.name, b.parent, b.mass_kg, b.inertia_kg_m2));
        let apart = (a.pivot_m[0] - b.pivot_m[0]).hypot(a.pivot_m[1] - b.pivot_m[1]);
        assert!(apart < 1e-15, "{}: {apart}", a.name);
    }
    let speed = |instrument: &Instrument| {
        let run = Play::Stroke("mf", Touch::Pressed).run(instrument, Settings::new(USUAL_STEP_S), 0.5);
        assert_eq!(run.work.unconverged_steps, 0);
        run.events.hammer_speed_m_per_s().unwrap()
    };
    let (soft, hard) = (speed(&with), speed(&without));
    println!("{soft} m/s with the bushing, {hard} without");
    assert!((soft / hard - 1.0).abs() < 0.03 && soft != hard);
}

/// Friction along the key's pin, N, where it must not bear a part of the weight.
const SLIPPERY_N: f64 = 0.02;

/// The concert grand with its key lying on a punching of the balance rail, on a pin that is almost free, and with its
/// key nailed there, on the punching all the same.
fn lying_and_nailed() -> [Instrument; 2] {
    let line = "pin_friction_N = { value = 0.3,";
    let text = Instrument::builtin_text("concert-grand").unwrap();
    assert_eq!(text.matches(line).count(), 1);
    let lying = text.replacen(line, &format!("pin_friction_N = {{ value = {SLIPPERY_N},"), 1);
    let at = text.find(line).unwrap();
    let nailed = text[..at].to_owned() + text[at..].split_once('\n').unwrap().1;
    [lying, nailed].map(|text| Instrument::parse(&text, "a file").unwrap())
}

/// The arm of a pivot that lies is a device: what can be varied is what the nailed key has, and the punching's two.
#[test]
fn an_arm_is_no_part_whose_numbers_vary() {
    let names = |instrument: &Instrument| -> Vec<String> {
        Parameter::all(instrument)
            .into_iter()
            .map(|(name, _)| name)
            .filter(|name| !name.contains("balance_rail"))
            .collect()
    };
    let [lying, nailed] = lying_and_nailed();
    assert_eq!(names(&lying), names(&nailed));
    assert_eq!(Parameter::all(&lying).len(), names(&lying).len() + 2);
    let nailed = |lying: &Instrument| lying.nailed(crate::common::body(lying, "key_back")).unwrap();
    assert_eq!(nailed(&lying), nailed(&grand()));
}

/// A pivot that lies is a body more, and locked it is the instrument with a nailed key. At rest the punching bears what
/// statics says: the weights of the key and of what it carries, less what the cloth of the back rail bears. No law of
/// the punching takes part in that.
#[test]
fn a_lying_pivot_bears_what_statics_says() {
    let [lying, nailed] = lying_and_nailed();
    assert_eq!((lying.bodies.len(), lying.springs.len()), (nailed.bodies.len() + 1, nailed.springs.len()));
    let (locked, rigid) = (lying.locked(), nailed.locked());
    assert_eq!((&locked.zones, &locked.roles, &locked.springs), (&rigid.zones, &rigid.roles, &rigid.springs));
    for (a, b) in locked.bodies.iter().zip(&rigid.bodies) {
        assert_eq!((&a.name, a.parent, a.mass_kg, a.inertia_kg_m2), (&b.name, b.parent, b.mass_kg, b.inertia_kg_m2));
        assert!((a.pivot_m[0] - b.pivot_m[0]).hypot(a.pivot_m[1] - b.pivot_m[1]) < 1e-15, "{}", a.name);
    }
    let run = Play::ForceStep(0.0, 0.1).run(&lying, Settings::new(USUAL_STEP_S), 0.1);
    let force = |name: &str| run.zones.iter().find(|zone| zone.name == name).unwrap().normal_n[0];
    let (_, key) = lying.lying().next().unwrap();
    let on_key = |body: Option<usize>| body.is_some_and(|body| lying.is_same_part(body, key).unwrap());
    let pieces = (0..lying.bodies.len()).filter(|&body| on_key(Some(body)));
    let weight_n = lying.gravity_m_per_s2 * pieces.map(|body| lying.bodies[body].mass_kg).sum::<f64>();
    // All zones of the key are level at rest: heel, check and damper press down on it, cloth and punching up.
    let (mut down_n, mut up_n) = (weight_n, 0.0);
    for zone in lying.zones.iter().filter(|zone| on_key(zone.disc_body) || on_key(zone.curve_body)) {
        let is_held = zone.disc_body.is_none() || zone.curve_body.is_none();
        *(if is_held { &mut up_n } else { &mut down_n }) += force(&zone.name);
    }
    println!("{up_n} N up, {down_n} N down; {} N on the punching", force("balance_rail"));
    // The pin's own weight lies on the punching, too; its friction and the dry torque at the arm of 1 m are free.
    let (pin_n, free_n) = (1e-3 * lying.gravity_m_per_s2, SLIPPERY_N + lying.bodies[key].friction_torque_n_m);
    assert!((up_n - down_n - pin_n).abs() < free_n + 0.002 * down_n && force("balance_rail") > 2.0);
    let lift_m = run.lifts[0].lift_m[0];
    assert!(lift_m.abs() < 0.02e-3, "the punching is drawn compressed by what it bears: {lift_m} m");
}
