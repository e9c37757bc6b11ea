//! An instrument's indices stay in range: whatever a program writes, it is refused by its field.

use erard::Instrument;
use erard::instrument::{DamperFelt, DrawnPart, InstrumentFields, Material, ScrewAction};

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
