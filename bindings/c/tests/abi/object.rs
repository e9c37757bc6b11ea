//! The code that the real-time functions can reach in the compiled library, followed from call to call: no allocation,
//! no lock, no system call; no panic in this interface or in the player, and in the engine's step none but the checks
//! of array bounds, whose indices the compiled model holds.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use crate::not_run::not_run;
use crate::programs::library;

/// Where it begins: what the functions of the interface call, and the engine behind its dynamic call.
const PLAY: [&str; 6] = ["4step17h", "7advance17h", "4save17h", "7restore17h", "5reset17h", "8contacts17h"];
const ENGINE: [&str; 5] = ["4step17h", "4save17h", "7restore17h", "12normal_force17h", "7readout17h"];

/// What may be reached outside: mathematics, and copies.
const PURE: [&str; 4] = ["memcpy", "memset", "memmove", "4libm"];
/// The checks of array bounds.
const BOUNDS: [&str; 2] = ["panic_bounds_check", "slice_index_fail"];
/// Given back is what steps of controlled length take, which this interface does not have.
const GIVEN_BACK: [&str; 2] = ["__rust_dealloc", "__rdl_dealloc"];

fn any(name: &str, parts: &[&str]) -> bool {
    parts.iter().any(|part| name.contains(part))
}

/// The name of the function whose section this is: each has one of its own.
fn function_of(section: &str) -> &str {
    let name = section.strip_prefix(".text.").unwrap_or(section);
    ["unlikely.", "cold.", "hot."].iter().find_map(|prefix| name.strip_prefix(prefix)).unwrap_or(name)
}

/// From each function to all that its code names: by the symbols of the objects and the relocations of their sections,
/// for to disassemble them takes thirty times as long.
fn calls(folder: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let mut calls: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for object in std::fs::read_dir(folder).expect("it reads") {
        let object = object.expect("it reads").path();
        let listed = Command::new("objdump").args(["-t", "-r", "-w"]).arg(object).output().expect("it runs");
        let listed = String::from_utf8_lossy(&listed.stdout);
        // The symbols come first.
        let mut functions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        let mut section = None;
        for line in listed.lines() {
            if let Some((of, name)) = line.split_once('\t').filter(|(of, _)| of.contains(" F ")) {
                let own = of.split_whitespace().last().unwrap_or_default();
                let name = name.split_whitespace().last().unwrap_or_default();
                // What another object defines has no section here.
                if own.starts_with(".text") {
                    let names = [name, function_of(own)];
                    functions.entry(own).or_default().extend(names);
                    for name in names {
                        calls.entry(name.to_owned()).or_default();
                    }
                }
            } else if let Some(of) = line.strip_prefix("RELOCATION RECORDS FOR [") {
                section = of.strip_suffix("]:").filter(|of| of.starts_with(".text"));
            } else if let (Some(section), Some((_, kind))) = (section, line.split_once(" R_X86_64_")) {
                let named = kind.split_whitespace().nth(1).unwrap_or_default();
                let named = named.split("+0x").next().unwrap_or_default().split("-0x").next().unwrap_or_default();
                // A function of the same object is named by its section.
                let named = function_of(named);
                // Constants without a name are data, as those in sections of data are.
                if !named.starts_with('.') && !named.starts_with("anon.") && !named.is_empty() {
                    for function in functions.get(section).expect("a section of code has a function") {
                        calls.entry((*function).to_owned()).or_default().insert(named.to_owned());
                    }
                }
            }
        }
    }
    calls
}

#[test]
fn real_time_functions_reach_nothing_else() {
    let tools = ["ar", "objdump"].iter().all(|tool| Command::new(tool).arg("--version").output().is_ok());
    if !tools || !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        not_run("no ar and objdump for x86-64");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let archive = library("liberard_c.a");
    let members = Command::new("ar").arg("t").arg(&archive).output().expect("it runs");
    let members = String::from_utf8(members.stdout).expect("names");
    let own = members
        .lines()
        .filter(|name| any(name, &["erard_c.", "erard_core-", "erard_core.", "moreau_kernels-", "moreau-"]));
    let status = Command::new("ar").arg("x").arg(&archive).args(own).current_dir(folder.path()).status();
    assert!(status.expect("it runs").success());

    let calls = calls(folder.path());
    let is_play = |name: &&String| name.contains("4play4Play") && PLAY.iter().any(|end| name.contains(end));
    let is_engine = |name: &&String| {
        name.contains("moreau_kernels..engine..Engine")
            && any(name, &["Mechanism", "Observation"])
            && ENGINE.iter().any(|end| name.contains(end))
    };
    let (play, engine) = (calls.keys().filter(is_play).count(), calls.keys().filter(is_engine).count());
    // Five sizes of the engine.
    assert_eq!(
        (play, engine % ENGINE.len()),
        (PLAY.len(), 0),
        "{play} functions of the interface, {engine} of the engine"
    );
    assert!(engine >= 5 * ENGINE.len(), "{engine}");

    let mut seen: BTreeSet<&str> = BTreeSet::new();
    let mut next: Vec<&str> =
        calls.keys().filter(|name| is_play(name) || is_engine(name)).map(String::as_str).collect();
    let (mut outside, mut checks, mut functions) = (BTreeSet::new(), 0, 0);
    while let Some(name) = next.pop() {
        if !seen.insert(name) {
            continue;
        }
        let Some(named) = calls.get(name) else {
            outside.insert(name);
            continue;
        };
        functions += 1;
        let panics: Vec<_> = named.iter().filter(|called| any(called, &BOUNDS)).collect();
        checks += usize::from(!panics.is_empty());
        assert!(
            panics.is_empty() || name.contains("moreau"),
            "{name} may panic: {panics:?}, and it is no function of the engine"
        );
        next.extend(named.iter().map(String::as_str));
    }
    println!("{functions} functions are reached, {checks} of them check array bounds; outside: {outside:?}");
    let unexpected: Vec<_> =
        outside.iter().filter(|name| !any(name, &PURE) && !any(name, &BOUNDS) && !any(name, &GIVEN_BACK)).collect();
    let callers: Vec<_> = seen
        .iter()
        .filter(|name| calls.get(**name).is_some_and(|named| unexpected.iter().any(|u| named.contains(**u))))
        .collect();
    assert!(unexpected.is_empty(), "{unexpected:?}, from {callers:?}");
    assert!(outside.iter().any(|name| name.contains("memcpy")) && functions > 100, "it has looked");
}
