//! The unit for simulators, as a simulator uses it: by fmpy, where that is there; its functions called one by one are
//! in `fmi.py`.

use std::path::Path;
use std::process::Command;

use erard::instrument::InstrumentFile;
use erard::keyboard::{Keyboard, Keys};
use erard::parameter::{ParameterChange, varied};
use erard::player::HandInput;
use erard::{Action, Input, Instrument, Settings};
use erard_workshop::fmu::Unit;

use crate::not_run::not_run;
use crate::programs::library;

/// Where Python has fmpy: `ERARD_FMPY` names that Python, or it is the one on the path.
fn python() -> Option<String> {
    let named = std::env::var("ERARD_FMPY").ok();
    let python = named.unwrap_or_else(|| "python3".into());
    let has = Command::new(&python).args(["-c", "import fmpy"]).output().is_ok_and(|output| output.status.success());
    if !has {
        not_run(&format!("{python} has no fmpy"));
    }
    has.then_some(python)
}

/// fmpy validates the unit and plays it: the impact is the native one's at communication steps of 50 us and 1 ms,
/// parameters act, states come back; a hand and the pedal act, and the strings are heard as
/// natively; a keyboard's unit plays a chord.
#[test]
fn fmpy_plays_it() {
    let Some(python) = python() else { return };
    // Units, unpacked: what `erard fmu` packs (its own test looks at the archive).
    let unpacked = |unit: &Unit| {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        };
        write("modelDescription.xml", unit.model_description().as_bytes());
        for (path, text) in unit.resources() {
            write(path, text.as_bytes());
        }
        write("binaries/linux64/erard.so", &std::fs::read(library("liberard_c.so")).unwrap());
        folder
    };
    let unit = |name: &str| {
        let text = Instrument::builtin_text(name).unwrap();
        (unpacked(&Unit::of_instrument(text).unwrap()), text, InstrumentFile::parse(text, name).unwrap())
    };
    let (folder, text, file) = unit("concert-grand");
    let (strung, _, strings) = unit("concert-grand-strings");
    // A hand presses the one whose strings sound, the pedal down: the force on the bridge after each millisecond.
    let mut action = Action::new(&strings.instrument).unwrap();
    let hand = HandInput { mass_kg: 0.3, force_n: 7.0, damping_n_s_per_m: 2.0, ..HandInput::default() };
    action.set_pedal(0.007);
    let mut heard = String::new();
    for n in 1..=3600 {
        action.step(Input::Hand(hand));
        if n % 24 == 0 {
            heard += &format!("{:?}\n", action.strings().unwrap().bridge_n());
        }
    }
    std::fs::write(strung.path().join("heard.txt"), heard).unwrap();

    // A chord on the keyboard.
    let base = Instrument::builtin_text("concert-grand-strings").unwrap();
    let keyboard = Keyboard::builtin("concert-grand-strings").unwrap();
    let own = Keyboard::builtin_text("concert-grand-strings").unwrap();
    let chord = unpacked(&Unit::of_keyboard(own, base).unwrap());
    let step_s = strings.instrument.usual_step_s();
    let mut keys = Keys::at_rest(&keyboard.instruments().unwrap(), Settings::new(step_s)).unwrap();
    keys.set_pedal(0.007);
    [40, 44, 47].into_iter().for_each(|key| keys.drive(key, Input::Force(6.0)).unwrap());
    let mut heard = String::new();
    for n in 1..=2400 {
        keys.step();
        if n % 24 == 0 {
            heard += &format!("{:?} {:?}\n", keys.bridge_n(), keys.reading(44).unwrap().key_m);
        }
    }
    std::fs::write(chord.path().join("heard.txt"), heard).unwrap();

    let impact = |instrument: &Instrument| {
        let mut action = Action::new(instrument).unwrap();
        for _ in 0..6000 {
            action.step(Input::Force(5.0));
            if let Some(impact) = action.impact() {
                return impact;
            }
        }
        panic!("no impact");
    };
    // A little heavier, and let off earlier.
    let mass_g = 1.05 * erard::instrument::numbers_at(text, "body.hammer.mass_g").unwrap()[0];
    let changes = [("body.hammer.mass_g", 0, mass_g), ("screw.let_off.setting_mm", 0, -0.5)];
    let heavier = erard::instrument::with_numbers(text, &changes);
    let expected = [impact(&file.instrument), impact(&Instrument::parse(&heavier.unwrap(), "heavier").unwrap())];
    // A heavier hammer with its inertia, by one parameter: to the bit what the command's `--vary` plays.
    let hammer = file.instrument.bodies.iter().find(|body| body.name == "hammer").unwrap();
    let mass_kg = 1.05 * hammer.mass_kg;
    let change = [("body.hammer.mass".to_owned(), ParameterChange::Text(format!("= {mass_kg:?} kg")))];
    let whole = impact(&varied(text, "whole", &change).unwrap().instrument);
    let line = format!("{mass_kg:?} {:?} {:?}", whole.hammer_speed_m_per_s, whole.time_s);
    std::fs::write(folder.path().join("mass.txt"), line).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/abi/fmi.py");
    let mut run = Command::new(python);
    run.arg(script).arg(folder.path()).arg(format!("{mass_g:?}"));
    for impact in expected {
        run.arg(format!("{:?}", impact.hammer_speed_m_per_s)).arg(format!("{:?}", impact.time_s));
    }
    run.arg(strung.path()).arg(chord.path());
    let output = run.output().expect("it runs");
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    println!("{said}");
    assert!(output.status.success(), "{said}");
}
