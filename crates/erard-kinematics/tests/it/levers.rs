//! Kinematics from a linkage file and from an instrument file, and what the dynamic model has to say about it.

use std::time::Instant;

use erard::instrument::{Curve, Instrument, InstrumentFields};
use erard_kinematics::three_lever::{Levers, Move, Regulation, ThreeLever};
use erard_kinematics::{Derived, LinkageFile, derive, json_schema, slow_press};

fn grand() -> Instrument {
    Instrument::builtin("concert-grand-rigid").expect("built in")
}

fn derived() -> Derived {
    derive(&grand()).expect("three levers")
}

#[test]
fn the_shipped_schema_is_the_generated_one() {
    crate::generated::is_current(
        "crates/erard-kinematics/linkages/linkage.schema.json",
        json_schema(),
        "linkage-schema",
    );
}

/// The shipped files are the sets that the linkage crate is tested with, to the last bit, and name their schema.
#[test]
fn shipped_linkages() {
    for (name, levers) in [("c7f-like", ThreeLever::c7f_like()), ("steinway-o-like", ThreeLever::steinway_o_like())] {
        let file = LinkageFile::builtin(name).expect("built in");
        let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
        let (ours, theirs) = (file.levers.lengths.to_array(), levers.lengths.to_array());
        assert!(ours.into_iter().zip(theirs).all(|(a, b)| close(a, b)), "{name}");
        assert!(close(file.levers.key_front, levers.key_front) && close(file.levers.key_rest, levers.key_rest));
        assert_eq!((file.blow_m, file.let_off_m), (0.046, 0.0015));
        let text = LinkageFile::builtin_text(name).expect("a text");
        assert_eq!(text.lines().next(), Some("#:schema ./linkage.schema.json"));
        file.design().expect("levers that reach each other");
    }
    assert_eq!(LinkageFile::builtin_names().count(), 2);
    assert!(LinkageFile::builtin("d-like").is_none());
}

/// The levers derived from the concert grand rest where the instrument rests, but for the play of 0.06 mm under the
/// knuckle, which turns the hammer by 0.06 / 14.4 rad (the knuckle's horizontal arm).
#[test]
fn derived_levers_rest_as_the_instrument_does() {
    let derived = derived();
    println!("{derived:#?}");
    let rest = derived.levers.assemble().unwrap().rest();
    assert!((rest.k - std::f64::consts::FRAC_PI_2).abs() < 1e-3, "the key's front is up");
    assert!((rest.w - derived.levers.near[0]).abs() < 1e-12);
    let sunk = derived.levers.near[1] - rest.h;
    assert!((0.003..0.006).contains(&sunk), "{sunk}");
    assert_eq!((derived.capstan_zone.as_str(), derived.knuckle_zone.as_str()), ("capstan_heel", "jack_knuckle"));
    assert!(derived.notes.iter().any(|note| note.contains("jack top - knuckle is open by 0.06 mm")));
}

/// Contact tangency: the lengths are the start set's own numbers, with the discs' radii. Felts (0.18 mm at the capstan)
/// and the whippen's lean on them (0.18 mm over 65 mm, 2.8 mrad, over the 142 mm of the key's back arm) are all that
/// stands between: 0.6 mm.
#[test]
fn derived_lengths_are_the_instruments() {
    let lengths = derived().lengths.lengths.to_array().map(|l| l * 1e3);
    // As drawn, the knuckle by its centre: L7 reaches 5 mm above the jack's top, L8 and L9 to (17, -4.8).
    let drawn = [205.23, 28.32, -63.0, 16.18, 44.5, 92.8, -53.37, 17.0, 4.8, 63.6];
    println!("{lengths:?}");
    for (i, (got, want)) in lengths.into_iter().zip(drawn).enumerate() {
        assert!((got - want).abs() < 0.6, "L{}: {got} {want}", i + 1);
    }
}

/// The same rest and, there, the same leverage as with the discs (exactly: the same tangents); later the fixed
/// contact of the capstan tells, by less than 2 %.
#[test]
fn derived_lengths_are_close_to_the_discs() {
    let derived = derived();
    let [discs, lengths] =
        [derived.levers.into(), Levers::from(derived.lengths)].map(|levers: Levers| levers.assemble().unwrap());
    let [a, b] = [&discs, &lengths].map(|train| train.stroke(0.0, 0.005, 50).poses);
    assert!((a[0].leverage / b[0].leverage - 1.0).abs() < 1e-9, "{} {}", a[0].leverage, b[0].leverage);
    assert!((a[0].h - b[0].h).abs() < 1e-9);
    let worst = a.iter().zip(&b).map(|(a, b)| (b.leverage / a.leverage - 1.0).abs()).fold(0.0, f64::max);
    println!("worst {:.3} %", worst * 100.0);
    assert!(worst < 0.02, "{worst}");
}

/// Must-show 4: the instrument's kinematics and a slow motion-driven press of its dynamic model have the same leverage,
/// to 2 %, from where play and felts are taken up until the jack's toe meets its button.
#[test]
fn agrees_with_a_slow_press() {
    let (grand, derived) = (grand(), derived());
    let train = derived.levers.assemble().unwrap();
    let let_off = derived.design.case(&[], Regulation::Regulated).unwrap().let_off_key_m.expect("let-off");
    let start = Instant::now();
    let press = slow_press(&grand, &derived.levers, let_off).expect("a run");
    println!("{:?}", start.elapsed());
    let agreement = press.agreement(&train, let_off).expect("a range");
    for (key, deviation) in agreement.key_m.iter().zip(&agreement.deviation).step_by(8) {
        println!("{:.2} mm {:+.2} %", key * 1e3, deviation * 100.0);
    }
    println!("worst {:.2} %, toe {:?}, geometry {let_off}", agreement.worst * 100.0, press.toe_contact_key_m);
    assert!(agreement.worst < 0.02, "{}", agreement.worst);
    assert!(agreement.key_m[0] < 1e-3 && *agreement.key_m.last().unwrap() > 4.5e-3, "most of the way");
    // The geometry also knows where the toe meets the button (a tenth of a millimetre: the felts on the way).
    assert!((press.toe_contact_key_m.expect("touched") - let_off).abs() < 2e-4);
}

/// One file changed, both seen: the knuckle moved in the instrument file is the knuckle moved as a `Move`, regulation
/// aside, and the dynamics follows.
#[test]
fn a_changed_instrument_changes_both() {
    let mut changed = grand();
    changed
        .edit(|fields| {
            for zone in fields.zones.iter_mut().filter(|zone| zone.name.ends_with("_knuckle")) {
                zone.disc_center_m[0] -= 0.002;
            }
        })
        .unwrap();
    let derived = derive(&changed).expect("three levers");
    let train = derived.levers.assemble().unwrap();
    let moved = self::derived().levers.moved(&[Move::Knuckle(-0.002)], Regulation::AsMoved).unwrap();
    let [ours, theirs] = [train.rest().leverage, moved.assemble().unwrap().rest().leverage];
    // The felts settle differently under the steeper hammer: 1 %.
    assert!((ours / theirs - 1.0).abs() < 0.01, "{ours} {theirs}");
    let let_off = derived.design.case(&[], Regulation::Regulated).unwrap().let_off_key_m.expect("let-off");
    let agreement =
        slow_press(&changed, &derived.levers, let_off).unwrap().agreement(&train, let_off).expect("a range");
    // There is more play now (under the knuckle), and the hammer swings on its felts longer after it.
    let late = agreement.key_m.iter().zip(&agreement.deviation).filter(|(key, _)| **key > 1.6e-3);
    let worst = late.map(|(_, deviation)| deviation.abs()).fold(0.0, f64::max);
    println!("worst {:.2} %", worst * 100.0);
    // The capstan's felt gives 0.18 mm at rest and less as the ratio falls: what comes back of it lifts the hammer too,
    // by 1 %.
    assert!(worst < 0.03, "{worst}");
}

/// What is not three levers is named.
#[test]
fn what_lacks_three_levers_says_so() {
    let told = |change: fn(&mut InstrumentFields)| {
        let mut instrument = grand();
        instrument.edit(change).unwrap();
        derive(&instrument).expect_err("no three levers").to_string()
    };
    assert!(told(|i| i.roles.key = None).contains("names no key"));
    assert!(told(|i| i.roles.hammer = None).contains("names no hammer"));
    assert!(told(|i| i.roles.knuckle.clear()).contains("roles.knuckle"));
    assert!(told(|i| i.roles.key_front_m[0] = 0.2).contains("behind its pivot"));
    assert!(
        told(|i| {
            let zone = i.zones.iter_mut().find(|zone| zone.name == "capstan_heel").expect("a capstan");
            zone.curve = Curve::Disc { center_m: [-0.063, 0.0], radius_m: 0.016 };
        })
        .contains("`capstan_heel` is a disc on a disc")
    );
}

/// Without a let-off button the hammer is let off the usual distance below the string.
#[test]
fn let_off_without_a_button() {
    let mut grand = grand();
    grand.edit(|fields| fields.roles.let_off = None).unwrap();
    let derived = derive(&grand).expect("three levers");
    assert_eq!(derived.design.let_off.as_ref().expect("a string").what, "hammer head 1.5 mm below the string");
    grand.edit(|fields| fields.roles.string = None).unwrap();
    assert_eq!(derive(&grand).expect("three levers").design.let_off, None);
}
