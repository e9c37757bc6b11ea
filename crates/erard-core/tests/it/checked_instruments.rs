//! An instrument's indices stay in range: whatever a program writes, it is refused by its field.

use erard::damper::DamperHeights;
use erard::grand::{Parts, falling_moment_n_m, front_weight_g, pedal_down, strike_weight_g, whippen_weight_g};
use erard::instrument::{Bushing, DamperFelt, DrawnPart, InstrumentFields, Material, ScrewAction};
use erard::keyboard::{Keyboard, Keys};
use erard::parameter::{Change as Typed, Parameter};
use erard::{Action, Input, Instrument, Settings, one_dof};

use crate::common::{USUAL_STEP_S, grand};

type Change = fn(&mut InstrumentFields);

/// Every field with an index, and a change that puts it out of range.
const WRONG: [(&str, Change); 26] = [
    ("bodies[0].parent", |i| i.bodies[0].parent = Some(0)),
    ("bodies[1].parent", |i| i.bodies[1].parent = Some(99)),
    ("bodies[0].parent", |i| i.bodies.swap(0, 1)),
    ("springs[0].body", |i| i.springs[0].body = 99),
    ("zones[0].disc_body", |i| i.zones[0].disc_body = Some(99)),
    ("zones[1].curve_body", |i| i.zones[1].curve_body = Some(usize::MAX)),
    ("strings[2].damper.zone", |i| i.strings[2].damper = Some(DamperFelt { zone: 99, middle_m: 0.1, length_m: 0.01 })),
    ("screws[0].action.zone", |i| i.screws[0].action = ScrewAction::Disc { zone: 99, direction: [1.0, 0.0] }),
    ("screws[0].action.zone", |i| i.screws[0].action = ScrewAction::Curve { zone: 99, direction: [1.0, 0.0] }),
    ("screws[1].action.zone", |i| i.screws[1].action = ScrewAction::Turn { zone: 99 }),
    ("screws[1].action.spring", |i| i.screws[1].action = ScrewAction::Spring { spring: 99 }),
    ("parts[0].body", |i| {
        let outline_m = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let (name, body, material) = ("stick".to_owned(), Some(99), Material::Wood);
        i.parts = vec![DrawnPart { name, body, material, outline_m, smooth: false }];
    }),
    ("roles.key", |i| i.roles.key = Some(99)),
    ("roles.hammer", |i| i.roles.hammer = Some(99)),
    ("roles.key_bottom", |i| i.roles.key_bottom = Some(99)),
    ("roles.string", |i| i.roles.string = Some(99)),
    ("roles.pedal", |i| i.roles.pedal = Some(99)),
    ("roles.let_off", |i| i.roles.let_off = Some(99)),
    ("roles.check", |i| i.roles.check = Some(99)),
    ("roles.knuckle[0]", |i| i.roles.knuckle[0] = 99),
    ("roles.transmits[0]", |i| i.roles.transmits = vec![99]),
    ("roles.stops[1]", |i| i.roles.stops = vec![0, 99]),
    ("springs[0].body", |i| i.bodies.truncate(1)),
    ("zones[0].disc_body", |i| (i.bodies, i.springs) = (Vec::new(), Vec::new())),
    ("strings[0].damper.zone", |i| i.zones.clear()),
    ("screws[0].action.spring", |i| {
        i.springs.clear();
        i.screws.retain(|screw| matches!(screw.action, ScrewAction::Spring { .. }));
    }),
];

#[test]
fn no_index_leaves_its_range() {
    let own = Instrument::builtin("concert-grand-strings").unwrap();
    for (n, (field, change)) in WRONG.into_iter().enumerate() {
        let mut changed = own.clone();
        let error = changed.edit(change).expect_err(field);
        assert_eq!(error.field, field, "{n}: {error}");
        assert!(error.to_string().starts_with(&format!("`{field}` is {}; expected ", error.found)), "{error}");
        assert_eq!(changed, own, "{field}: a refused change changes nothing");
        let mut fields = (*own).clone();
        change(&mut fields);
        assert_eq!(Instrument::new(fields), Err(error), "{field}");
    }
}

/// What was checked goes on to work: an edited instrument plays, one of checked fields is the same.
#[test]
fn what_is_in_range_is_taken() {
    let own = Instrument::builtin("concert-grand").unwrap();
    assert_eq!(Instrument::new((*own).clone()).as_ref(), Ok(&own));
    let mut edited = own.clone();
    let before = edited.edit(|fields| std::mem::replace(&mut fields.springs[0].body, 0)).unwrap();
    assert_ne!(edited, own);
    edited.edit(|fields| fields.springs[0].body = before).unwrap();
    assert_eq!(edited, own);
    let bare = own.clone().without_outlines();
    assert!(bare.parts.is_empty() && bare.digest() == own.digest());
}

/// An index or a key that does not exist is an error that names it and how many there are, in every function that takes
/// one. Nothing changes then.
#[test]
fn indices_that_callers_pass_are_checked() {
    let grand = grand();
    let (bodies, zones) = (grand.bodies.len(), grand.zones.len());
    let told = |error: &dyn std::fmt::Display, what: &str, found: usize, count: usize, first: usize| {
        let expected = format!("found {what} {found}, expected one of {count}, counted from {first}");
        assert!(error.to_string().ends_with(&expected), "{error}");
    };
    let no_body = |error: &dyn std::fmt::Display| told(error, "body", bodies, bodies, 0);
    let no_zone = |error: &dyn std::fmt::Display| told(error, "zone", zones, zones, 0);
    let cloth = Bushing::Cloth { n_per_m: 1e5, n_s_per_m: 0.0 };
    // The last of each is there.
    assert!(grand.first_piece(bodies - 1).is_ok() && grand.with_bushing(bodies - 1, cloth).is_ok());
    no_body(&grand.first_piece(bodies).unwrap_err());
    no_body(&grand.on_first_piece(bodies).unwrap_err());
    no_body(&grand.is_same_part(0, bodies).unwrap_err());
    no_body(&grand.is_same_part(bodies, 0).unwrap_err());
    no_body(&grand.with_bushing(bodies, cloth).unwrap_err());
    no_body(&falling_moment_n_m(&grand, bodies).unwrap_err());
    told(&grand.first_piece(usize::MAX).unwrap_err(), "body", usize::MAX, bodies, 0);

    let parts = Parts::of(&grand).unwrap();
    let (damper_zone, damper) = parts.damper.expect("the grand has a damper");
    no_zone(&pedal_down(&grand, &Parts { damper: Some((zones, damper)), ..parts.clone() }).unwrap_err());
    no_body(&front_weight_g(&grand, &Parts { key: bodies, ..parts.clone() }, 0.2).unwrap_err());
    no_body(&strike_weight_g(&grand, &Parts { hammer: bodies, ..parts.clone() }).unwrap_err());
    no_body(&whippen_weight_g(&grand, &Parts { whippen: bodies, ..parts.clone() }, 0.1).unwrap_err());
    // The parts of a grand in an instrument of one mass.
    let small = one_dof::reduce(&grand).unwrap().instrument;
    told(&pedal_down(&small, &parts).unwrap_err(), "zone", damper_zone, small.zones.len(), 0);
    told(&strike_weight_g(&small, &parts).unwrap_err(), "body", parts.hammer, small.bodies.len(), 0);

    let (springs, screws) = (grand.springs.len(), grand.screws.len());
    let action = grand.screws[0].action.clone();
    for (parameter, what, index) in [
        (Parameter::Mass(bodies), "body", bodies),
        (Parameter::PivotFriction(bodies), "body", bodies),
        (Parameter::Torque(springs), "spring", springs),
        (Parameter::SpringStiffness(springs), "spring", springs),
        (Parameter::Stiffness(zones), "zone", zones),
        (Parameter::Damping(zones), "zone", zones),
        (Parameter::Friction(zones), "zone", zones),
        (Parameter::Screw { screw: screws, action }, "screw", screws),
    ] {
        let missing = |error: &dyn std::fmt::Display| told(error, what, index, index, 0);
        let mut varied = grand.clone();
        missing(&parameter.vary(&mut varied, 1.0).unwrap_err());
        assert_eq!(varied, grand);
        missing(&parameter.name(&grand).unwrap_err());
        missing(&parameter.quantity(&grand).unwrap_err());
        missing(&parameter.trade_bare(&grand).unwrap_err());
        missing(&parameter.by(&grand, Typed::Multiply(2.0)).unwrap_err());
        missing(&parameter.value(&grand).unwrap_err());
        missing(&parameter.path(&grand).unwrap_err());
        missing(&parameter.paths(&grand).unwrap_err());
        missing(&parameter.numbers(&grand, 1.0, "").unwrap_err());
    }

    let strung = Instrument::builtin("concert-grand-strings").unwrap();
    let (bodies, zones) = (strung.bodies.len(), strung.zones.len());
    let mut action = Action::new(&strung).unwrap();
    assert!(action.contact_force(zones - 1).is_ok() && action.point(Some(bodies - 1), [0.0; 2]).is_ok());
    let no_zone = |error: &dyn std::fmt::Display| told(error, "zone", zones, zones, 0);
    no_zone(&action.contact_force(zones).unwrap_err());
    no_zone(&action.tangential_force(zones).unwrap_err());
    no_zone(&action.compression(zones).unwrap_err());
    told(&action.point(Some(bodies), [0.0; 2]).unwrap_err(), "body", bodies, bodies, 0);
    told(&action.add_velocity(bodies, 1.0).unwrap_err(), "body", bodies, bodies, 0);
    let strings = action.strings().unwrap();
    let count = strung.strings.len();
    told(&strings.shape_m(count, 0.1).unwrap_err(), "string", count, count, 0);
    assert!(strings.shape_m(count - 1, 0.1).is_ok() && strings.partial(count, 1).is_none());

    let mut keys = Keys::at_rest(&[grand.clone(), grand.clone()], Settings::new(USUAL_STEP_S)).unwrap();
    let saved = keys.save(2).unwrap();
    for key in [0, 3, usize::MAX] {
        let no_key = |error: &dyn std::fmt::Display| told(error, "key", key, 2, 1);
        no_key(&keys.is_awake(key).unwrap_err());
        no_key(&keys.drive(key, Input::Force(1.0)).unwrap_err());
        no_key(&keys.impose(key, 0.0, 0.0).unwrap_err());
        no_key(&keys.place_hand(key, 0.0, 0.0).unwrap_err());
        no_key(&keys.reading(key).unwrap_err());
        no_key(&keys.string_force(key).unwrap_err());
        no_key(&keys.strings(key).expect_err("no such key"));
        no_key(&keys.finger_force_n(key).unwrap_err());
        no_key(&keys.key_m(key).unwrap_err());
        no_key(&keys.angles(key).unwrap_err());
        no_key(&keys.velocities(key).unwrap_err());
        no_key(&keys.save(key).unwrap_err());
        no_key(&keys.mechanism_state(key).unwrap_err());
        no_key(&keys.save_strings(key, &mut |_, _| {}).unwrap_err());
        no_key(&keys.restore(key, &saved).unwrap_err());
        no_key(&DamperHeights::new(&[grand.clone(), grand.clone()]).of(key).unwrap_err());
    }
    assert_eq!(keys.awake(), 0);
    let keyboard = Keyboard::builtin("concert-grand").unwrap();
    for key in [0, 89, usize::MAX] {
        for error in [keyboard.key(key).unwrap_err(), keyboard.key_file(key).map(|_| ()).unwrap_err()] {
            let told = error.to_string();
            assert!(told.contains("expected a number from 1 to 88, or a note from A0 to C8"), "{key}: {told}");
        }
    }
    assert!(keys.reading(1).is_ok() && keys.restore(2, &saved).is_ok());
}
