//! What ships reads, says where every number comes from, and means what the start set says.

use std::path::Path;

use erard::instrument::{Certainty, Curve, Instrument, InstrumentFile, ScrewAction};

fn grand() -> Instrument {
    Instrument::builtin("concert-grand").expect("the built-in grand reads")
}

/// Six bodies, as drawn by the start set.
fn rigid() -> Instrument {
    Instrument::builtin("concert-grand-rigid").expect("the built-in grand reads")
}

fn body(instrument: &Instrument, name: &str) -> usize {
    instrument.bodies.iter().position(|body| body.name == name).expect("a body of this name")
}

fn zone(instrument: &Instrument, name: &str) -> usize {
    instrument.zones.iter().position(|zone| zone.name == name).expect("a zone of this name")
}

/// World coordinates as drawn, mm, of a point given in a body's frame.
fn world_mm(instrument: &Instrument, body: Option<usize>, point_m: [f64; 2]) -> [f64; 2] {
    let Some(body) = body else {
        return point_m.map(|x| x * 1000.0);
    };
    let body = &instrument.bodies[body];
    let (sin, cos) = body.angle_rad.sin_cos();
    let turned = [cos * point_m[0] - sin * point_m[1], sin * point_m[0] + cos * point_m[1]];
    // The parents of the grand's children are drawn upright; only then can pivots be added like this.
    let pivot = world_mm(instrument, body.parent, body.pivot_m);
    [pivot[0] + turned[0] * 1000.0, pivot[1] + turned[1] * 1000.0]
}

#[test]
fn every_built_in_instrument_reads() {
    let mut count = 0;
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).expect("a text");
        InstrumentFile::parse(text, name).unwrap_or_else(|error| panic!("{error}"));
        assert!(Instrument::builtin(name).is_ok());
        count += 1;
    }
    assert!(count > 0);
    let error = Instrument::builtin("harpsichord").unwrap_err().to_string();
    assert!(error.contains("`harpsichord`") && error.contains("concert-grand"), "{error}");
}

#[test]
fn the_built_in_text_is_the_file_on_disk() {
    for name in Instrument::builtin_names() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("instruments/{name}.toml"));
        assert_eq!(InstrumentFile::load(&path).ok(), InstrumentFile::builtin(name), "{name}");
    }
}

#[test]
fn the_grands_have_their_bodies_and_zones() {
    let three = ["jack_knuckle", "let_off_button", "check"];
    for (name, bodies, zones, rub) in [
        ("concert-grand-rigid", &["key", "whippen", "jack", "lever", "hammer", "damper"][..], 14, &three[..]),
        (
            "concert-grand",
            &["key_back_pin", "key_back", "key", "whippen", "jack", "lever", "shank", "hammer", "damper"][..],
            17,
            &["capstan_heel", "jack_knuckle", "lever_knuckle", "let_off_button", "check"][..],
        ),
    ] {
        let grand = Instrument::builtin(name).expect("it reads");
        let names: Vec<&str> = grand.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names, bodies);
        assert_eq!(grand.zones.len(), zones);
        let with_friction: Vec<&str> =
            grand.zones.iter().filter(|zone| zone.friction_coefficient > 0.0).map(|zone| zone.name.as_str()).collect();
        assert_eq!(with_friction, rub);
        assert_eq!(grand.bodies[body(&grand, "jack")].parent, Some(body(&grand, "whippen")));
        assert_eq!(grand.bodies[body(&grand, "lever")].parent, Some(body(&grand, "whippen")));
    }
}

/// The pieces of what bends are the parts that they were made from, to the digits that their file has, but for a lead
/// of 3 g in the key, 190 mm before its pin: what rubs under load asks for it.
#[test]
fn locked_the_grand_is_the_rigid_one() {
    let (rigid, locked) = (rigid(), grand().locked());
    for (a, b) in locked.bodies.iter().zip(&rigid.bodies) {
        assert_eq!(a.name, b.name);
        let mut b = b.clone();
        if b.name == "key" {
            let (lead_kg, at_m) = (3e-3, [-0.19, 0.01]);
            let mass_kg = b.mass_kg + lead_kg;
            b.center_of_mass_m =
                core::array::from_fn(|k| (b.mass_kg * b.center_of_mass_m[k] + lead_kg * at_m[k]) / mass_kg);
            b.inertia_kg_m2 += lead_kg * (at_m[0] * at_m[0] + at_m[1] * at_m[1]);
            b.mass_kg = mass_kg;
        }
        assert!((a.mass_kg - b.mass_kg).abs() < 1e-9, "{}", a.name);
        assert!((a.inertia_kg_m2 / b.inertia_kg_m2 - 1.0).abs() < 1e-4, "{}", a.name);
        for axis in 0..2 {
            assert!((a.center_of_mass_m[axis] - b.center_of_mass_m[axis]).abs() < 1e-5, "{}", a.name);
        }
    }
}

/// Walks the raw TOML, so that a number which the reader forgot to record would still be found.
#[test]
fn every_number_carries_a_source_and_a_certainty() {
    fn is_number(value: &toml::Value) -> bool {
        match value {
            toml::Value::Integer(_) | toml::Value::Float(_) => true,
            toml::Value::Array(array) => array.iter().any(is_number),
            _ => false,
        }
    }
    fn walk(path: &str, value: &toml::Value, sources: &toml::Table, cited: &mut usize) {
        match value {
            toml::Value::Table(table) if table.contains_key("value") => {
                let source = table.get("source").and_then(toml::Value::as_str);
                assert!(source.is_some_and(|source| sources.contains_key(source)), "{path} names no source");
                assert!(table.contains_key("certainty"), "{path} has no certainty");
                *cited += 1;
            }
            // One source covers an outline.
            toml::Value::Table(table) if table.contains_key("outline_mm") => {
                assert!(table.contains_key("source") && table.contains_key("certainty"), "{path} has no source");
                *cited += 1;
            }
            toml::Value::Table(table) => {
                table.iter().for_each(|(key, value)| walk(&format!("{path}.{key}"), value, sources, cited));
            }
            toml::Value::Array(array) if !is_number(value) => {
                array.iter().enumerate().for_each(|(i, value)| walk(&format!("{path}[{i}]"), value, sources, cited));
            }
            // A seed measures nothing.
            value => assert!(!is_number(value) || path.ends_with(".seed"), "{path} is a bare number"),
        }
    }
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).expect("a text");
        let table: toml::Table = toml::from_str(text).expect("TOML");
        let sources = table["sources"].as_table().expect("sources");
        let mut cited = 0;
        walk("", &toml::Value::Table(table.clone()), sources, &mut cited);
        assert!(cited > 150, "{name}: only {cited} numbers");

        // The reader recorded the same numbers, each under its own key.
        let provenance = InstrumentFile::parse(text, "").expect("reads").provenance;
        assert_eq!(provenance.bare().count(), 0, "{name}");
        assert_eq!(provenance.numbers.len(), cited, "{name}");
        let mut keys: Vec<&str> = provenance.numbers.iter().map(|number| number.key.as_str()).collect();
        keys.sort_unstable();
        keys.dedup();
        assert!(keys.len() > 150, "{name}");
        let pin = ["body.shank.friction_torque_N_m", "body.hammer.friction_torque_N_m"];
        let friction = pin.iter().find_map(|key| provenance.numbers.iter().find(|number| number.key == *key));
        let citation = friction.and_then(|number| number.citation.as_ref()).expect("cited");
        assert_eq!((citation.source.as_str(), citation.certainty), ("renner", Certainty::SecondHand), "{name}");
    }
}

/// The start set gives children's points relative to the whippen's pivot B; here they are back in that form.
#[test]
fn points_land_where_the_start_set_has_them() {
    let grand = rigid();
    let b = [205.23, 44.5];
    let close = |got: [f64; 2], want: [f64; 2], tolerance: f64| {
        assert!((got[0] - want[0]).hypot(got[1] - want[1]) < tolerance, "got {got:?}, want {want:?}");
    };
    for (name, at) in [("jack", [-85.0, 2.0]), ("lever", [-42.0, 30.0])] {
        let pivot = world_mm(&grand, Some(body(&grand, name)), [0.0, 0.0]);
        close(pivot, [b[0] + at[0], b[1] + at[1]], 1e-9);
    }
    for (name, at) in [("whippen", [-50.0, 10.0]), ("jack", [-85.0, 22.0]), ("lever", [-65.0, 35.0])] {
        let index = body(&grand, name);
        let center = world_mm(&grand, Some(index), grand.bodies[index].center_of_mass_m);
        close(center, [b[0] + at[0], b[1] + at[1]], 1e-9);
    }
    let damper = body(&grand, "damper");
    close(world_mm(&grand, Some(damper), grand.bodies[damper].center_of_mass_m), [264.0, 40.0], 1e-9);

    for (name, at) in [
        ("let_off_button", [b[0] - 109.0, b[1] + 6.0]),
        ("jack_rest", [b[0] - 80.0, b[1] + 30.0]),
        ("lever_stop", [b[0] - 22.0, b[1] + 27.0]),
        ("drop_screw", [b[0] - 96.0, b[1] + 52.0]),
        ("key_damper", [235.0, 22.0]),
        ("damper_rest", [255.0, 40.0]),
        ("capstan_heel", [142.23, 18.32]),
    ] {
        let zone = &grand.zones[zone(&grand, name)];
        close(world_mm(&grand, zone.disc_body, zone.disc_center_m), at, 1e-9);
    }
    let jack_top = &grand.zones[zone(&grand, "jack_knuckle")];
    let Curve::Segment { from_m, to_m, .. } = jack_top.curve else { panic!("the jack's top must end") };
    close(world_mm(&grand, jack_top.curve_body, from_m), [b[0] - 85.0, b[1] + 47.37], 1e-9);
    close(world_mm(&grand, jack_top.curve_body, to_m), [b[0] - 77.9, b[1] + 47.37], 1e-9);
}

/// The compression of each felt as drawn, worked out by hand from the start set and the five distances moved since (the
/// shank's sine and cosine to 1e-6).
#[test]
fn compressions_as_drawn_have_the_right_size_and_sign() {
    let grand = rigid();
    for (name, compression_mm) in [
        ("key_front", -9.18),
        // The cloth under the key's end is compressed, not free: point at -5, line at -4.9.
        ("key_back_rail", 0.1),
        ("capstan_heel", 0.0),
        ("lever_knuckle", -0.05),
        ("let_off_button", -5.14),
        ("jack_rest", 0.0),
        ("lever_stop", -0.05),
        ("drop_screw", -5.88),
        ("string", -45.4),
        ("hammer_rest", -4.0),
        ("key_damper", -4.4),
        ("damper_rest", 0.0),
    ] {
        let zone = &grand.zones[zone(&grand, name)];
        let Curve::Line { point_m, normal } = zone.curve else { panic!("{name} is no line") };
        let point = world_mm(&grand, zone.curve_body, point_m);
        let center = world_mm(&grand, zone.disc_body, zone.disc_center_m);
        let distance = normal[0] * (center[0] - point[0]) + normal[1] * (center[1] - point[1]);
        let compression = zone.disc_radius_m * 1000.0 - distance;
        assert!((compression - compression_mm).abs() < 0.03, "{name}: {compression} mm, expected {compression_mm} mm");
    }
}

/// Lever's front (at negative x of its pivot) up, jack's top back against a rest behind it: both clockwise.
#[test]
fn springs_push_against_the_stops_that_hold_them() {
    let grand = rigid();
    for (spring, stop) in [("repetition", "lever_stop"), ("jack", "jack_rest")] {
        let spring = grand.springs.iter().find(|other| other.name == spring).expect("a spring");
        let stop = &grand.zones[zone(&grand, stop)];
        assert_eq!(stop.disc_body, Some(spring.body));
        let Curve::Line { normal, .. } = stop.curve else { panic!("a stop is a line") };
        // Turning along the spring's torque must move the point into the wood, against the line's normal.
        let sense = spring.torque_n_m.signum();
        let velocity = [-sense * stop.disc_center_m[1], sense * stop.disc_center_m[0]];
        assert!(velocity[0] * normal[0] + velocity[1] * normal[1] < 0.0);
    }
}

#[test]
fn screws_are_drawn_at_zero_and_turn_what_they_say() {
    let mut grand = rigid();
    let names: Vec<&str> = grand.screws.iter().map(|screw| screw.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "capstan_height",
            "let_off",
            "drop",
            "repetition_spring",
            "jack_position",
            "lever_height",
            "back_check",
            "back_check_angle",
            "front_punching",
            "back_rail_cloth",
            "string_height",
            "damper_timing"
        ]
    );
    assert!(grand.screws.iter().all(|screw| screw.setting == 0.0 && !screw.label.is_empty()));

    let drawn = grand.clone();
    let let_off = grand.screw("let_off").expect("a let-off button");
    assert!(grand.turn(let_off, 0.5e-3));
    let button = zone(&grand, "let_off_button");
    let Curve::Line { point_m, .. } = grand.zones[button].curve else { panic!("a line") };
    assert!((point_m[1] - 0.05614).abs() < 1e-12);
    assert!(grand.turn(let_off, 0.0));
    let Curve::Line { point_m, .. } = grand.zones[button].curve else { panic!("a line") };
    assert!((point_m[1] - 0.05564).abs() < 1e-12);

    let spring = grand.screw("repetition_spring").expect("a repetition spring");
    assert!(grand.turn(spring, 0.002));
    assert!((grand.springs[0].torque_n_m + 0.0365).abs() < 1e-12, "tighter is further from zero");
    assert!(!grand.turn(spring, -0.0345), "a spring cannot be turned around");
    assert!(!grand.turn(spring, f64::NAN));
    assert!((grand.springs[0].torque_n_m + 0.0365).abs() < 1e-12, "and is then left alone");
    assert!(!grand.turn(grand.screws.len(), 0.0));

    let Curve::Line { point_m: drawn_at, .. } = grand.zones[zone(&grand, "check")].curve else { panic!("a line") };
    let lean = grand.screw("back_check_angle").expect("a back check that leans");
    assert!(grand.turn(lean, 2_f64.to_radians()));
    let bend = grand.screw("back_check").expect("and that bends");
    assert!(grand.turn(bend, 1e-3));
    let check = &grand.zones[zone(&grand, "check")];
    let Curve::Line { point_m, normal } = check.curve else { panic!("a line") };
    // Its face stood at 70 degrees: the normal pointed 160 degrees from the back, and now 162.
    assert!((normal[1].atan2(normal[0]).to_degrees() - 162.0).abs() < 5e-3, "{normal:?}");
    assert!((drawn_at[0] - point_m[0] - 1e-3).abs() < 1e-12, "turned about its own point, then moved");

    for (index, screw) in drawn.screws.iter().enumerate() {
        let mut turned = drawn.clone();
        assert!(turned.turn(index, 1e-3), "{}", screw.name);
        let moved = drawn.zones != turned.zones || drawn.springs != turned.springs;
        assert!(moved, "{} turns nothing", screw.name);
        if let ScrewAction::Disc { direction, .. } | ScrewAction::Curve { direction, .. } = screw.action {
            assert!((direction[0].hypot(direction[1]) - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_mechanism_that_is_no_piano_reads_too() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/instruments/escapement.toml");
    let file = InstrumentFile::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let clock = &file.instrument;
    // The file declares the pallet before the pendulum that carries it.
    let names: Vec<&str> = clock.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["pendulum", "pallet", "lever"]);
    assert_eq!(clock.bodies[1].parent, Some(0));
    assert_eq!(clock.zones[0].disc_body, Some(1));
    assert!(matches!(clock.zones[0].curve, Curve::Disc { .. }));
    assert_eq!(clock.zones[1].curve_body, None);
    assert!(matches!(clock.zones[1].curve, Curve::Line { normal: [0.0, 1.0], .. }), "normals are normalised");
    assert_eq!(clock.zones[1].label, "bench");
    assert_eq!(clock.springs[0].body, 1);
    assert_eq!((clock.roles.key, clock.finger.stiffness_n_per_m), (None, 0.0));
    assert!(file.provenance.bare().count() > 20);
}
