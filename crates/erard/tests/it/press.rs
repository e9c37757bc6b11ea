//! A press as described to [`Press`] is the core's, to the bit.

use erard::{
    Action, Error, Halving, Hand, HandKind, Input, Instrument, Pedal, PositionOf, Prescribed, Press, Run, Series,
    Settings, SimulationError, Stroke, Touch,
};
use erard_core::level::{DURATION_S, LEVELS, MASS_KG, Reference};
use erard_core::run::{Setup, press, press_by_hand, simulate, simulate_from};

fn grand() -> Instrument {
    Instrument::builtin("concert-grand").unwrap()
}

/// Every number of a run, as bits: its series, its events, its energy balance.
fn bits(run: &Run) -> Vec<u64> {
    let events = &run.events;
    let instants = [events.key_start_s, events.toe_contact_s, events.let_off_s, events.key_bottom_s, events.check_s];
    let impacts = events.impacts.iter().flat_map(|one| [one.time_s, one.hammer_speed_m_per_s]);
    let ledger = run.ledger.iter().flat_map(|l| [l.now.total(), l.drive_work, l.pivot_dry, l.felt_damping, l.coulomb]);
    let columns = run.columns();
    let series = columns.iter().flat_map(|(_, values)| values.iter().copied());
    let instants = instants.into_iter().map(|instant| instant.unwrap_or(f64::NAN));
    series.chain(instants).chain(impacts).chain(ledger).chain([run.peak_force_n]).map(f64::to_bits).collect()
}

#[track_caller]
fn same(described: Result<Run, Error>, core: Result<Run, SimulationError>) {
    let (described, core) = (described.unwrap(), core.unwrap());
    assert!(described.time_s.len() > 100 && bits(&described) == bits(&core));
}

#[test]
fn a_constant_force_is_that_of_the_core() {
    let grand = grand();
    let core = press(&grand, &|_| Input::Force(5.0), &Setup::of(&grand, 0.6));
    same(Press::new(&grand).force(5.0).run(), core);
    // The comparison can fail: a thousandth of a newton is another run.
    let other = Press::new(&grand).force(5.001).run().unwrap();
    assert!(bits(&other) != bits(&Press::new(&grand).force(5.0).run().unwrap()));
    // The last one counts.
    let twice = Press::new(&grand).force(1.0).force(5.0).duration(0.05).run();
    same(twice, press(&grand, &|_| Input::Force(5.0), &Setup::of(&grand, 0.05)));
}

#[test]
fn a_level_is_that_of_the_core() {
    let grand = grand();
    let solved = |kind: HandKind, speed_m_per_s: f64| {
        let mut reference = Reference::new(&grand, &mut |_| true).unwrap();
        reference.solve(kind, speed_m_per_s, &mut |_| true).unwrap().whole()
    };
    let mf = LEVELS.iter().find(|(name, _)| *name == "mf").unwrap().1;
    let core = |kind, speed_m_per_s, duration_s| {
        press_by_hand(&grand, &solved(kind, speed_m_per_s), &Setup::of(&grand, duration_s), &mut |_| true)
    };
    same(Press::new(&grand).level("mf").run(), core(HandKind::new(Touch::Pressed, MASS_KG), mf, DURATION_S));
    let struck = HandKind::new(Touch::Struck, 0.1);
    let described = Press::new(&grand).hammer_speed(2.5).hand_kind(struck).duration(0.1).run();
    same(described, core(struck, 2.5, 0.1));
}

#[test]
fn a_stroke_and_a_drive_are_those_of_the_core() {
    let grand = grand();
    let (curve, _) = Stroke::curve("mf", Touch::Struck, None).unwrap().unwrap();
    let inputs = curve.inputs(&grand.finger).unwrap();
    let setup = Setup { start_s: curve.start_s, ..Setup::of(&grand, curve.duration_s) };
    same(Press::new(&grand).stroke(&curve).run(), press(&grand, &inputs, &setup));

    // A recording of the fingertip, half of it; and through a hand.
    let series = Series::parse("time_s,position_m\n0,0\n0.04,0.008\n0.1,0.01\n", "test").unwrap();
    let (recorded, _) =
        Stroke::recorded("finger".into(), series, PositionOf::Fingertip, Some(Prescribed::Motion)).unwrap();
    let inputs = recorded.inputs(&grand.finger).unwrap();
    let setup = Setup { start_s: 0.01, ..Setup::of(&grand, 0.08) };
    same(Press::new(&grand).stroke(&recorded).start(0.01).duration(0.08).run(), press(&grand, &inputs, &setup));
    let hand = Hand { mass_kg: 0.15, ..Hand::default() };
    let setup = Setup { hand: Some(hand), ..Setup::of(&grand, 0.08) };
    same(Press::new(&grand).stroke(&recorded).hand(hand).duration(0.08).run(), press(&grand, &inputs, &setup));

    // A function, with everything that can be set.
    let drive = |t: f64| Input::Force(if t < 0.03 { 8.0 } else { 0.0 });
    let settings = Settings::new(1e-4);
    let setup = Setup { settings, record_every: Some(3), ledger: false, ..Setup::new(0.08) };
    let described = Press::new(&grand).drive(drive).duration(0.08).settings(settings).record_every(3);
    let (described, core) = (described.without_energy_balance().run().unwrap(), press(&grand, &drive, &setup).unwrap());
    assert!(
        bits(&described) == bits(&core) && described.ledger.is_none() && described.time_s.len() == core.time_s.len()
    );
    let setup = Setup { tolerance: Some(1e-4), ..Setup::of(&grand, 0.08) };
    same(Press::new(&grand).drive(drive).duration(0.08).tolerance(1e-4).run(), press(&grand, &drive, &setup));
}

#[test]
fn strings_a_pedal_and_a_saved_state_are_those_of_the_core() {
    let strung = Instrument::builtin("concert-grand-strings").unwrap();
    let pedal = Pedal::held(7e-3);
    let setup = Setup { pedal, halving: Halving::Further(1), ..Setup::of(&strung, 0.06) };
    let described = Press::new(&strung).force(6.0).duration(0.06).pedal(pedal).halving(Halving::Further(1));
    same(described.run(), press(&strung, &|_| Input::Force(6.0), &setup));

    let grand = grand();
    let mut action = Action::new(&grand).unwrap();
    for _ in 0..300 {
        action.step(Input::Force(5.0));
    }
    let state = action.save();
    let (drive, setup) = (|_: f64| Input::Force(5.0), Setup::of(&grand, 0.05));
    same(
        Press::new(&grand).drive(drive).duration(0.05).restore(&state).run(),
        simulate_from(&grand, &state, &drive, &setup, &mut |_| true),
    );
}

/// `run` refuses a missing setting and two that contradict each other before it computes anything; the error names
/// what is expected.
#[test]
fn what_is_missing_or_contradictory_is_refused() {
    let grand = grand();
    let state = Action::new(&grand).unwrap().save();
    let new = || Press::new(&grand).progress(|_| panic!("nothing is computed"));
    let kind = HandKind::new(Touch::Struck, 0.2);
    for (press, fault, expected) in [
        (new(), "nothing plays the key", "`level`"),
        (new().drive(|_| Input::Free), "no end of its own", "`duration`"),
        (new().level("mezzo"), "no level `mezzo`", "pp, p, mf, f or ff"),
        (new().level("mf").hand(Hand::default()), "gives another", "one of them"),
        (new().force(5.0).hand_kind(kind), "`hand_kind` without a level", "`hand`"),
        (new().level("mf").restore(&state), "from rest", "one of them"),
        (new().force(5.0).restore(&state).tolerance(1e-4), "adaptive steps", "`tolerance`"),
        (new().force(-1.0), "a constant force of -1 N", "0 to 10000 N"),
        (new().force(f64::NAN), "a constant force of NaN N", "0 to 10000 N"),
    ] {
        let error = press.run().unwrap_err();
        let said = error.to_string();
        assert!(matches!(error, Error::Press { .. }), "{said}");
        let (found, wanted) = said.split_once("; expected ").unwrap();
        assert!(found.contains(fault) && wanted.contains(expected), "{said}");
    }
    // Every level that the core knows is one that the message names.
    let said = new().level("?").run().unwrap_err().to_string();
    assert!(LEVELS.iter().all(|(name, _)| said.contains(name)), "{said}");
}

/// The core's errors arrive with their own text, and an interruption is one.
#[test]
fn errors_are_the_core_s() {
    let grand = grand();
    let theirs = simulate(&grand, &|_| Input::Force(5.0), &Setup::of(&grand, -1.0), &mut |_| true).unwrap_err();
    let ours = Press::new(&grand).force(5.0).duration(-1.0).run().unwrap_err();
    assert!(matches!(ours, Error::Run(SimulationError::Duration { .. })) && ours.to_string() == theirs.to_string());
    let ended = Press::new(&grand).force(5.0).progress(|_| false).run().unwrap_err();
    assert!(ended.is_interruption() && !ours.is_interruption());
    let ended = Press::new(&grand).level("mf").progress(|_| false).run().unwrap_err();
    assert!(ended.is_interruption(), "{ended}");
    let read = |name: &str| -> Result<Run, Error> { Press::new(&Instrument::builtin(name)?).force(5.0).run() };
    let error = read("spinet").unwrap_err();
    assert!(matches!(error, Error::Instrument(_)) && error.to_string().contains("`spinet`"), "{error}");
}
