//! The register of parameters against the instruments: every name acts, and identity, files and register list the same
//! numbers.

use std::collections::BTreeSet;

use erard::instrument::{Instrument, InstrumentFile};
use erard::parameter::{NameError, Parameter, Quantity, register};

fn files() -> Vec<InstrumentFile> {
    Instrument::builtin_names().map(|name| InstrumentFile::builtin(name).unwrap()).collect()
}

/// Ends of paths of the numbers that have names, in SI units. Screws are applied to these.
const NAMED: [&str; 6] = [
    ".mass_kg",
    ".friction_torque_N_m",
    ".torque_N_m",
    ".stiffness_N_m_per_rad",
    ".felt.stiffness_N_per_m_r",
    ".friction_coefficient",
];

/// Every registered number of every built-in instrument changes the mechanism, and has its own quantity and path.
#[test]
fn every_name_acts() {
    for file in files() {
        let grand = &file.instrument;
        let all = register(&file);
        let names: BTreeSet<&str> = all.iter().map(|entry| entry.name.as_str()).collect();
        let paths: BTreeSet<&str> = all.iter().map(|entry| entry.path.as_str()).collect();
        assert_eq!((names.len(), paths.len()), (all.len(), all.len()), "{}", grand.name);
        for entry in &all {
            let mut varied = grand.clone();
            let by = if entry.parameter.is_factor() { 1.07 } else { 1.7e-5 };
            assert!(entry.parameter.vary(&mut varied, by), "{}: {}", grand.name, entry.name);
            assert_ne!(varied.digest(), grand.digest(), "{}: {} does nothing", grand.name, entry.name);
            assert_eq!(Parameter::named(grand, &entry.name).unwrap().1, entry.parameter);
            let own = Quantity::of_name(&entry.path).map_or(Quantity::Number, |(quantity, _)| quantity);
            assert_eq!(own, entry.quantity, "{}", entry.path);
        }
    }
}

/// The dry torque of a bend is no pivot's friction: no result depends on it, and its name is refused with the one that
/// acts.
#[test]
fn idle_names_are_refused_with_those_that_act() {
    let mut idle = BTreeSet::new();
    for file in files() {
        let grand = &file.instrument;
        for body in grand.bodies.iter().filter(|body| body.friction_torque_n_m > 0.0) {
            let name = format!("body.{}.friction", body.name);
            match Parameter::named(grand, &name) {
                Ok(_) => assert!(!body.is_bend, "{}: {name}", grand.name),
                Err(NameError::Idle { acts, .. }) => {
                    assert!(body.is_bend && Parameter::named(grand, &acts).is_ok(), "{}: {name} {acts}", grand.name);
                    idle.insert(format!("{name} -> {acts}"));
                }
                Err(error) => assert!(body.is_bend, "{}: {error}", grand.name),
            }
        }
    }
    assert!(idle.contains("body.key.friction -> body.key_back.friction"), "{idle:?}");
    assert!(idle.contains("body.hammer.friction -> body.shank.friction"), "{idle:?}");
}

/// Identity, files and register list the same numbers, both ways.
#[test]
fn identity_files_and_register_agree() {
    let is_part = |path: &str| ["body.", "spring.", "zone."].iter().any(|start| path.starts_with(start));
    let is_named = |path: &str| is_part(path) && NAMED.iter().any(|end| path.ends_with(end));
    for file in files() {
        let grand = &file.instrument;
        let bends: Vec<String> = grand
            .bodies
            .iter()
            .filter(|body| body.is_bend)
            .map(|body| format!("body.{}.friction_torque_N_m", body.name))
            .collect();
        let all = register(&file);
        let si = |path: &str| path.replace(".mass_g", ".mass_kg");
        let registered: BTreeSet<String> = all.iter().map(|entry| si(&entry.path)).collect();
        let identity: BTreeSet<String> = grand.parameters().into_iter().map(|(path, _)| path).collect();
        for path in identity.iter().filter(|path| is_named(path) && !bends.contains(path)) {
            assert!(registered.contains(path), "{}: {path} is not in the register", grand.name);
        }
        for entry in all.iter().filter(|entry| entry.parameter.is_factor()) {
            assert!(identity.contains(&si(&entry.path)), "{}: {} changes no step", grand.name, entry.path);
        }
        for number in &file.provenance.numbers {
            let path = si(&number.key);
            if path.starts_with("part.") || bends.contains(&path) || number.values.first() == Some(&0.0) {
                continue;
            }
            if is_named(&path) || path.starts_with("screw.") && path.contains(".setting_") {
                assert!(registered.contains(&path), "{}: {path} is not in the register", grand.name);
            }
        }
        let written: BTreeSet<&str> = file.provenance.numbers.iter().map(|number| number.key.as_str()).collect();
        for entry in &all {
            let is_made =
                grand.bodies.iter().any(|body| body.is_bend && entry.name.contains(&format!(".{}.", body.name)));
            let is_written = written.contains(entry.path.as_str()) || entry.value == 0.0 || is_made;
            assert!(is_written, "{}: {} is not in the file", grand.name, entry.path);
        }
    }
}

/// Every number of the built-in files has a unit at the end of its path that the register knows, or is a plain number.
#[test]
fn every_number_of_a_file_has_its_quantity() {
    let mut plain = BTreeSet::new();
    for file in files() {
        for number in &file.provenance.numbers {
            if Quantity::of_name(&number.key).is_none() {
                plain.insert(number.key.rsplit('.').next().unwrap_or_default().to_owned());
            }
        }
    }
    let known = [
        "direction",
        "exponent",
        "friction_coefficient",
        "inharmonicity",
        "iwan_loss",
        "iwan_slip",
        "loss_factor",
        "normal",
        "static_friction_ratio",
    ];
    let unknown: Vec<&String> = plain.iter().filter(|key| !known.contains(&key.as_str())).collect();
    assert!(unknown.is_empty(), "no unit: {unknown:?}");
}
