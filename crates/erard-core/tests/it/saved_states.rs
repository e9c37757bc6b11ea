//! Saved states belong to an instrument's numbers: not to its name, to its notes, or to the order in its file.

use std::collections::BTreeSet;

use crate::common::{grand, rigid_grand};
use erard::assembly::{describe, probes};
use erard::instrument::{BridgeMode, Bushing, Dwell, Felt, InstrumentFields, InstrumentFile, with_numbers};
use erard::keyboard::Keyboard;
use erard::{Action, Input, Instrument};
use moreau::{Elastoplastic, Hereditary, Loss, SetValued};
use toml::{Table, Value};

/// What the step is given, as text, without names: an independent way to see whether a change changes a step.
fn given(instrument: &Instrument) -> String {
    let (mechanism, probes) = (describe::<f64>(instrument), probes(instrument));
    let strings = instrument.has_yielding_strings().then(|| {
        let bridge = if instrument.roles.rigid_bridge { &[][..] } else { &instrument.bridge_modes };
        format!("{:?}{bridge:?}{:?}", instrument.strings, instrument.roles.pedal)
    });
    format!("{mechanism:?}{probes:?}{strings:?}").replace("-0.0", "0.0")
}

fn table(name: &str) -> Table {
    Instrument::builtin_text(name).expect("built in").parse().expect("TOML")
}

fn read(table: &Table) -> Instrument {
    Instrument::parse(&table.to_string(), "changed").unwrap_or_else(|error| panic!("{error}"))
}

fn each<'a>(table: &'a mut Table, list: &str) -> impl Iterator<Item = &'a mut Table> {
    table.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().filter_map(Value::as_table_mut)
}

/// The file with its lists the other way round.
fn reversed(name: &str) -> Instrument {
    let mut text = table(name);
    let lists: Vec<&mut Vec<Value>> = text.iter_mut().filter_map(|(_, value)| value.as_array_mut()).collect();
    assert!(lists.len() >= 4);
    lists.into_iter().for_each(|list| list.reverse());
    read(&text)
}

/// Another name, another label, a note, another order, a default that is written: the same instrument.
#[test]
fn what_changes_no_step_keeps_the_identity() {
    for name in ["concert-grand", "concert-grand-strings"] {
        let own = Instrument::builtin(name).unwrap();
        let same = |what: &str, other: &Instrument| assert_eq!(other.digest(), own.digest(), "{name}: {what}");
        let mut text = table(name);
        text["name"] = "mine".into();
        text.insert("description".to_owned(), "a description".into());
        same("name", &read(&text));
        each(&mut text, "zone").for_each(|zone| drop(zone.insert("label".to_owned(), "a label".into())));
        each(&mut text, "body").for_each(|body| {
            let mass = body["mass_g"].as_table_mut().expect("a mass with its source");
            mass.insert("note".to_owned(), "another note".into());
        });
        text.remove("part");
        text["roles"].as_table_mut().unwrap().remove("check");
        same("notes, labels, parts, roles of events", &read(&text));
        same("order", &reversed(name));

        let mut text = table(name);
        let mut written = 0;
        let mut write = |table: &mut Table, key: &str, value: Value| {
            if !table.contains_key(key) {
                table.insert(key.to_owned(), value);
                written += 1;
            }
        };
        for body in each(&mut text, "body") {
            write(body, "hinged_on", "ground".into());
            for key in ["angle_deg", "friction_torque_N_m", "viscous_N_m_s"] {
                write(body, key, 0.0.into());
            }
            write(body, "bend", false.into());
        }
        for zone in each(&mut text, "zone") {
            write(zone, "friction_coefficient", 0.0.into());
            write(zone["disc"].as_table_mut().unwrap(), "radius_mm", 0.0.into());
        }
        each(&mut text, "string").for_each(|string| write(string, "detuned_cents", 0.0.into()));
        write(text["roles"].as_table_mut().unwrap(), "rigid_bridge", false.into());
        assert!(written > 20, "{written}");
        same("defaults", &read(&text));
    }
    let mut negative = grand();
    let zero = negative.zones.iter().position(|zone| zone.disc_radius_m == 0.0).expect("a point");
    negative.edit(|fields| fields.zones[zero].disc_radius_m = -0.0).unwrap();
    assert_eq!(negative.digest(), grand().digest(), "zero has one sign");
}

/// Every fifth number of a file: the identity changes if and only if what the step is given does.
#[test]
fn numbers_that_change_a_step_change_the_identity() {
    identity_changes_with_the_step(5);
}

#[test]
#[ignore = "ci: every number of a file"]
fn every_number_that_changes_a_step_changes_the_identity() {
    identity_changes_with_the_step(1);
}

/// One of so many numbers is changed.
fn identity_changes_with_the_step(of: usize) {
    // With the bridge that moves, so that everything that is described is in force.
    let text = Instrument::builtin_text("concert-grand-strings").unwrap();
    let text = text.replace("rigid_bridge = true", "rigid_bridge = false");
    let file = InstrumentFile::parse(&text, "strings").unwrap();
    assert!(!file.instrument.roles.rigid_bridge && !file.instrument.bridge_modes.is_empty());
    let (own, own_given) = (file.instrument.digest(), given(&file.instrument));
    let (mut changed, mut kept) = (0, BTreeSet::new());
    let numbers = file.provenance.numbers.iter().filter(|number| !number.key.starts_with("part."));
    for number in numbers.step_by(of) {
        for (which, value) in number.values.iter().enumerate() {
            let read = |value: f64| {
                let text = with_numbers(&text, &[(&number.key, which, value)]).expect("it is there");
                Instrument::parse(&text, "changed").ok()
            };
            // One of both is within its limits.
            let other = read(value * (1.0 + 1e-4) + 1e-6).or_else(|| read(value * (1.0 - 1e-4) - 1e-6));
            let other = other.unwrap_or_else(|| panic!("{}", number.key));
            let differs = given(&other) != own_given;
            assert_eq!(other.digest() != own, differs, "{} {which}", number.key);
            changed += usize::from(differs);
            if !differs {
                kept.insert(number.key.rsplit('.').next().expect("a key").to_owned());
            }
        }
    }
    println!("{changed} numbers change a step; not: {kept:?}");
    assert!(changed * of > 200, "{changed}");
    // What is only looked at; and directions, which are made unit vectors.
    let expected = ["thickness_mm", "turn_deg", "normal", "direction"].map(str::to_owned);
    assert!(kept.iter().all(|key| expected.contains(key)), "{kept:?}");
}

/// Every pair of every built-in instrument has a path of its own, and a value.
#[test]
fn every_pair_has_its_path() {
    let mut all = BTreeSet::new();
    for name in Instrument::builtin_names() {
        let instrument = Instrument::builtin(name).unwrap();
        let pairs = instrument.parameters();
        assert!(pairs.is_sorted() && pairs.windows(2).all(|two| two[0].0 != two[1].0), "{name}");
        assert!(pairs.iter().all(|(_, value)| value.is_finite() && *value != 0.0), "{name}");
        assert!(all.insert(instrument.digest()), "{name}");
    }
    let keyboard = Keyboard::builtin("concert-grand").unwrap();
    assert_ne!(keyboard.key(40).unwrap().digest(), keyboard.key(41).unwrap().digest());
    let grand = Instrument::builtin("concert-grand-strings").unwrap();
    let value = |path: &str| grand.parameters().iter().find(|(found, _)| found == path).map(|(_, value)| *value);
    let hammer = grand.bodies.iter().find(|body| body.name == "hammer").unwrap();
    assert_eq!(value("body.hammer.mass_kg"), Some(hammer.mass_kg));
    let heel = grand.zones.iter().find(|zone| zone.name == "capstan_heel").unwrap();
    assert_eq!(value("zone.capstan_heel.felt.stiffness_N_per_m_r"), Some(heel.felt.stiffness));
    assert_eq!(value("roles.key.key"), Some(1.0));
}

fn felt(loss: Loss<f64>) -> Felt {
    Felt { stiffness: 1e9, exponent: 2.5, loss, thickness_m: None }
}

/// With a bushing at the first body's pivot.
fn with_bushing(fields: &InstrumentFields, n_s_per_m: f64) -> InstrumentFields {
    let instrument = Instrument::new(fields.clone()).unwrap();
    (*instrument.with_bushing(0, Bushing::Cloth { n_per_m: 1e5, n_s_per_m }).unwrap()).clone()
}

/// The laws and parts that no built-in instrument has: each changes the identity, and each of its numbers does.
#[test]
fn optional_laws_change_the_identity() {
    type Change = fn(&mut InstrumentFields);
    let changes: [(&str, Vec<Change>); 6] = [
        (
            "a pivot's friction at rest",
            vec![
                |i| i.bodies[0].dwell = Some(Dwell { ratio: 1.5, time_s: 1.0 }),
                |i| i.bodies[0].dwell = Some(Dwell { ratio: 1.6, time_s: 1.0 }),
                |i| i.bodies[0].dwell = Some(Dwell { ratio: 1.5, time_s: 2.0 }),
            ],
        ),
        ("a zone's friction at rest", vec![|i| i.zones[0].dwell = Some(Dwell { ratio: 1.5, time_s: 1.0 })]),
        (
            "other laws of a felt",
            vec![
                |i| i.zones[0].felt = felt(Loss::hunt_crossley(0.5)),
                |i| i.zones[0].felt = felt(SetValued { eta: 0.5 }.into()),
                |i| i.zones[0].felt = felt(Elastoplastic { damping: 0.0, eta: 0.5, slip: 0.1 }.into()),
                |i| i.zones[0].felt = felt(Hereditary { relaxed: 0.5, time: 1e-3 }.into()),
                |i| i.zones[0].felt = felt(Hereditary { relaxed: 0.5, time: 2e-3 }.into()),
            ],
        ),
        (
            "a bridge that moves",
            vec![
                |i| {
                    i.bridge_modes.push(BridgeMode {
                        name: "a".into(),
                        mass_kg: 1.0,
                        frequency_hz: 90.0,
                        loss_factor: 0.1,
                        horizontal: 0.0,
                    })
                },
                |i| {
                    i.bridge_modes.push(BridgeMode {
                        name: "a".into(),
                        mass_kg: 1.0,
                        frequency_hz: 91.0,
                        loss_factor: 0.1,
                        horizontal: 0.0,
                    })
                },
                |i| {
                    i.bridge_modes.push(BridgeMode {
                        name: "a".into(),
                        mass_kg: 1.1,
                        frequency_hz: 90.0,
                        loss_factor: 0.1,
                        horizontal: 0.0,
                    })
                },
                |i| {
                    i.bridge_modes.push(BridgeMode {
                        name: "a".into(),
                        mass_kg: 1.0,
                        frequency_hz: 90.0,
                        loss_factor: 0.2,
                        horizontal: 0.0,
                    })
                },
            ],
        ),
        ("a bushing", vec![|i| *i = with_bushing(i, 0.0), |i| *i = with_bushing(i, 1.0)]),
        (
            "roles",
            vec![
                |i| i.roles.rigid_string = true,
                |i| i.roles.pedal = None,
                |i| i.roles.hammer = Some(0),
                |i| i.roles.string = Some(0),
                |i| i.bodies[0].parent = None,
                |i| i.zones[0].disc_body = None,
            ],
        ),
    ];
    let mut own = Instrument::builtin("concert-grand-strings").unwrap();
    own.edit(|fields| fields.roles.rigid_bridge = false).unwrap();
    let mut found = BTreeSet::from([own.digest()]);
    for (what, changes) in changes {
        for (n, change) in changes.iter().enumerate() {
            let mut other = own.clone();
            other.edit(change).unwrap();
            if given(&other) != given(&own) {
                assert!(found.insert(other.digest()), "{what} {n}");
            } else {
                assert_eq!(other.digest(), own.digest(), "{what} {n}");
            }
        }
    }
    assert!(found.len() > 18, "{}", found.len());
    own.edit(|fields| fields.roles.rigid_bridge = true).unwrap();
    let mut unused = own.clone();
    unused
        .edit(|fields| {
            fields.bridge_modes.push(BridgeMode {
                name: "a".into(),
                mass_kg: 1.0,
                frequency_hz: 90.0,
                loss_factor: 0.1,
                horizontal: 0.0,
            });
            fields.zones[0].felt.thickness_m = Some(1.0);
        })
        .unwrap();
    assert_eq!(unused.digest(), own.digest(), "what is described and not in force");
}

/// A state goes on in an instrument whose file has another order: every body where it was, and the same motion to
/// rounding.
#[test]
fn a_state_goes_on_in_another_order() {
    for (name, rigid_bridge) in
        [("concert-grand", true), ("concert-grand-strings", true), ("concert-grand-strings", false)]
    {
        let (mut own, mut other) = (Instrument::builtin(name).unwrap(), reversed(name));
        assert_ne!(own.bodies[0].name, other.bodies[0].name);
        for instrument in [&mut own, &mut other] {
            instrument.edit(|fields| fields.roles.rigid_bridge = rigid_bridge).unwrap();
        }
        let (mut here, mut there) = (Action::new(&own).unwrap(), Action::new(&other).unwrap());
        // Into the impact, where strings move and zones rub.
        while here.impact().is_none() {
            here.step(Input::Force(6.0));
        }
        for _ in 0..10 {
            here.step(Input::Force(6.0));
        }
        let state = here.save();
        there.restore(&state).unwrap();
        assert_eq!(there.save(), state);
        let places = |action: &Action, instrument: &Instrument| {
            let mut all: Vec<(String, u64)> =
                instrument.bodies.iter().zip(action.angles()).map(|(b, q)| (b.name.clone(), q.to_bits())).collect();
            all.sort();
            all
        };
        assert_eq!(places(&here, &own), places(&there, &other));
        for _ in 0..400 {
            let (a, b) = (here.step(Input::Force(6.0)), there.step(Input::Force(6.0)));
            assert!(
                (a.key_m - b.key_m).abs() < 1e-9 && (a.hammer_rise_m - b.hammer_rise_m).abs() < 1e-9,
                "{a:?} {b:?}"
            );
        }
    }
}

/// What is turned by a screw is another instrument, whose states are refused; turned back, it is the same.
#[test]
fn screws_are_numbers() {
    let own = rigid_grand();
    let mut turned = own.clone();
    let screw = turned.screw("let_off").unwrap();
    let setting = turned.screws[screw].setting;
    assert!(turned.turn(screw, setting + 1e-4));
    assert_ne!(turned.digest(), own.digest());
    let state = Action::new(&own).unwrap().save();
    assert!(Action::new(&turned).unwrap().restore(&state).is_err());
}
