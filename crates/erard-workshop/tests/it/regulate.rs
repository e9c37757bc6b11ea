//! Regulation as in the trade: a mis-set action is put right, and unreachable goals are reported.

use std::sync::LazyLock;

use crate::common::{Play, USUAL_STEP_S, rigid_grand};
use erard::instrument::{Instrument, ScrewAction};
use erard::parameter::Quantity;
use erard_workshop::distances::{DistanceError, Protocol, measure};
use erard_workshop::measure::norms::lines;
use erard_workshop::regulate::{Goal, Miss, RegulateError, Regulated, Specification, known_screw, regulate};
use moreau::Settings;

/// Turns screws by these amounts: mm, or a share of the torque for the spring.
fn turn_on(instrument: &mut Instrument, turns: &[(&str, f64)]) {
    for &(name, by) in turns {
        let screw = instrument.screw(name).unwrap();
        let by = if name == "repetition_spring" { by * instrument.springs[0].torque_n_m.abs() } else { by * 1e-3 };
        let setting = instrument.screws[screw].setting + by;
        assert!(instrument.turn(screw, setting), "{name}");
    }
}

fn regulated(instrument: &Instrument, specification: &Specification) -> Regulated {
    regulate(instrument, specification, &Protocol::default(), &mut |_| true).unwrap()
}

/// The grand regulated to the norms, the start of several tests.
static NORMAL: LazyLock<Regulated> = LazyLock::new(|| regulated(&rigid_grand(), &Goal::norms()));

/// A regulated grand mis-set: let-off 5 mm or more, no drop to speak of, dip 8 mm, a spring too weak to lift the
/// hammer, a check too far to catch it.
fn mis_set() -> Instrument {
    let mut instrument = NORMAL.instrument.clone();
    turn_on(
        &mut instrument,
        &[
            ("let_off", -0.9),
            ("drop", -1.0),
            ("front_punching", 2.0),
            ("repetition_spring", -0.2),
            ("back_check", -2.5),
        ],
    );
    instrument
}

/// Impacts in two seconds at eight strokes a second, from 3 mm to the bottom (and a tenth of a millimetre of fingertip
/// further), without full release. The margin is small: a finger that stops a tenth short of the bottom misses some.
fn blows_at_eight_hertz(instrument: &Instrument, dip_m: f64) -> usize {
    let play = Play::Tremolo { top: 3e-3, bottom: dip_m + 0.1e-3, frequency: 8.0 };
    play.run(instrument, Settings::new(USUAL_STEP_S), 2.0).events.impacts.len()
}

/// A mis-set action meets every norm again, to 0.05 mm and 2 %, and repeats at 8 Hz, which it did not before.
#[test]
fn a_mis_set_action_is_put_right() {
    let wrong = mis_set();
    let before = measure(&wrong, &Protocol::default(), &mut |_| true).unwrap();
    assert!(before.let_off_m.unwrap() > 5e-3 && before.drop_m.unwrap() < 0.3e-3, "{before:?}");
    assert!((before.dip_m.unwrap() - 8e-3).abs() < 0.1e-3, "{before:?}");
    let mut nearer = wrong.clone();
    turn_on(&mut nearer, &[("back_check", 2.5)]);
    let weak = measure(&nearer, &Protocol::default(), &mut |_| true).unwrap();
    assert!(
        before.check_m.is_none() && weak.repetition_spring_m_per_s.is_none_or(|speed| speed < 0.1),
        "{before:?} {weak:?}"
    );
    assert_ne!(blows_at_eight_hertz(&wrong, before.dip_m.unwrap()), 16);

    let regulated = regulated(&wrong, &Goal::norms());
    println!("{} simulations in {} rounds: {:?}", regulated.simulations, regulated.rounds, regulated.after);
    assert!(regulated.all_met(), "{:?}", regulated.achieved);
    // Measured anew, without values kept by the search.
    let after = measure(&regulated.instrument, &Protocol::default(), &mut |_| true).unwrap();
    for (goal, target) in Goal::norms() {
        let off = (goal.of(&after).unwrap() - target).abs();
        let allowed = match goal {
            Goal::RepetitionSpring => 0.02 * target,
            Goal::DamperStart => 0.01,
            _ => 0.05e-3,
        };
        assert!(off <= allowed, "{}: {after:?}", goal.name());
    }
    assert_eq!(after.unconverged_steps, 0);
    assert_eq!(blows_at_eight_hertz(&regulated.instrument, after.dip_m.unwrap()), 16);
}

/// A regulated action is left alone: one round, no screw.
#[test]
fn a_regulated_action_is_left_alone() {
    let once = &*NORMAL;
    let twice = regulated(&once.instrument, &Goal::norms());
    assert!(twice.turned.iter().all(|t| (t.setting[1] - t.setting[0]).abs() < 0.02e-3), "{:?}", twice.turned);
    assert!(twice.all_met() && twice.rounds <= 2, "{:?}", twice.achieved);
    assert!(twice.simulations < once.simulations);
}

/// Only the given goals are regulated. A string 1 mm higher adds 1 mm to blow and let-off; the let-off button alone
/// restores the let-off.
#[test]
fn one_goal_turns_one_screw() {
    let mut instrument = NORMAL.instrument.clone();
    turn_on(&mut instrument, &[("string_height", 1.0)]);
    let regulated = regulated(&instrument, &vec![(Goal::LetOff, 1.5e-3)]);
    let names: Vec<&str> = regulated.turned.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names, ["let_off"]);
    assert_eq!(regulated.turned[0].way, "up");
    assert!((regulated.after.let_off_m.unwrap() - 1.5e-3).abs() < 0.05e-3);
    assert!((regulated.after.blow_m.unwrap() - 47e-3).abs() < 0.1e-3);
}

/// A screw counted the other way in a file is turned the other way, with the same distances.
#[test]
#[ignore = "ci: another regulation"]
fn a_file_may_count_the_other_way() {
    let text = Instrument::builtin_text("concert-grand-rigid").unwrap();
    let lowers = text.replace("direction = { value = [0, -1],", "direction = { value = [0, 1],");
    assert_ne!(text, lowers);
    let other = Instrument::parse(&lowers, "other.toml").unwrap();
    let (a, b) = (&*NORMAL, &regulated(&other, &Goal::norms()));
    assert!(b.all_met());
    let drop = |r: &Regulated| r.turned.iter().find(|t| t.name == "drop").unwrap().clone();
    assert!((drop(a).setting[1] + drop(b).setting[1]).abs() < 0.02e-3, "{:?} {:?}", drop(a), drop(b));
    assert_eq!(drop(a).way, drop(b).way);
}

/// Goals that geometry does not allow are reported, with the nearest value: a dip of 3 mm needs more than 3 mm of
/// punchings and 2 mm of cloth; a hammer checked 15 mm below the string has no 20 mm to rise.
#[test]
fn a_dip_that_cannot_be_met_is_said_so() {
    let far = regulated(&rigid_grand(), &vec![(Goal::Dip, 3e-3), (Goal::Blow, 46e-3)]);
    let [blow, dip] = &far.achieved[..] else { panic!("{:?}", far.achieved) };
    assert_eq!((blow.goal, &blow.miss, dip.goal), (Goal::Blow, &None, Goal::Dip));
    let Some(Miss::EndOfRange(screws)) = &dip.miss else { panic!("{dip:?}") };
    assert_eq!(screws, &["front_punching", "back_rail_cloth"]);
    let nearest_mm = dip.after.unwrap() * 1e3;
    assert!((3.5..7.0).contains(&nearest_mm), "all that the punchings and the cloth give: {dip:?}");
}

#[test]
#[ignore = "ci: two regulations with the check"]
fn a_rise_that_cannot_be_met_is_said_so() {
    let mut goals = Goal::norms();
    goals.push((Goal::RepetitionRise, 20e-3));
    let rise = regulated(&rigid_grand(), &goals);
    for achieved in &rise.achieved {
        assert_eq!(achieved.miss.is_some(), achieved.goal == Goal::RepetitionRise, "{achieved:?}");
    }
    // Without a check distance to keep, the check itself is moved for it.
    let free =
        regulated(&rigid_grand(), &vec![(Goal::LetOff, 1.5e-3), (Goal::Drop, 1.5e-3), (Goal::RepetitionRise, 10e-3)]);
    assert!(free.all_met(), "{:?}", free.achieved);
}

/// No goal of the trade stands on the end of the range that judges it: a tenth of the range is between them, and a
/// digit that is read.
#[test]
fn goals_lie_inside_their_own_ranges() {
    let mut held = 0;
    for (goal, norm) in Goal::norms() {
        let (scale, unit) = match goal.quantity() {
            Quantity::Length => (1e3, "mm"),
            Quantity::Speed => (1.0, "m_per_s"),
            _ => (1.0, "share"),
        };
        let key = format!("{}_{unit}", goal.name().replace([' ', '-'], "_"));
        let line = lines().find(|line| line.key == key).unwrap_or_else(|| panic!("{key} is no line of the sheet"));
        for number in [1, 40, 88] {
            let [Some(low), Some(high)] = line.range(number) else { panic!("{key} has no range at key {number}") };
            let room = (0.1 * (high - low)).max(10_f64.powi(-(line.decimals as i32)));
            let value = scale * norm;
            // A thousandth of the room for rounding.
            let is_inside = value - low > 0.999 * room && high - value > 0.999 * room;
            assert!(is_inside, "{key} at key {number}: {value} in {low} to {high}");
            held += 1;
        }
    }
    assert_eq!(held, 27, "nine goals with a norm at three keys");
}

/// The spring's own torque limits how far it can be loosened; every screw stays in its range.
#[test]
#[ignore = "ci: three regulations to the ends of ranges"]
fn screws_stay_in_their_range() {
    for goals in [vec![(Goal::RepetitionSpring, 2.0)], vec![(Goal::LetOff, 20e-3)], vec![(Goal::Check, 40e-3)]] {
        let end = regulated(&rigid_grand(), &goals);
        assert!(!end.all_met(), "{:?}", end.achieved);
        for turned in &end.turned {
            let [from, to] = known_screw(&turned.name).unwrap().range;
            // A spring's in shares of its torque.
            let unit = match turned.action {
                ScrewAction::Spring { spring } => rigid_grand().springs[spring].torque_n_m.abs(),
                _ => 1.0,
            };
            let most = unit * to.max(-from);
            assert!(turned.setting[1].abs() <= most * 1.0001, "{turned:?}");
        }
    }
}

#[test]
fn what_is_missing_is_named() {
    let mut without = rigid_grand();
    without.edit(|fields| fields.screws.retain(|screw| screw.name != "drop")).unwrap();
    let error = regulate(&without, &Goal::norms(), &Protocol::default(), &mut |_| true).unwrap_err();
    assert_eq!(error.to_string(), "the instrument has no screw for drop: it needs one called `drop`");

    let stopped = regulate(&rigid_grand(), &Goal::norms(), &Protocol::default(), &mut |status| status.simulations < 5);
    assert!(matches!(stopped, Err(RegulateError::Measure(DistanceError::Interrupted))));
}
