//! What each front offers: every name in the table is looked up in that front's interface, and the table in the book is
//! the one that is made from here: `.ci/regenerate fronts` rewrites it.

use std::path::Path;

use erard::Instrument;
use erard::keyboard::Keyboard;
use erard_workshop::fmu::Unit;

const FRONTS: [&str; 6] = ["Rust", "Python", "C", "C++", "FMU", "studio"];

/// Nothing of the kind.
const NO: &str = "";

/// What is offered, and by which name in each front.
const TABLE: [(&str, [&str; 6]); 12] = [
    (
        "a hand: mass and muscle",
        ["Input::Hand", "Hand", "ERARD_INPUT_HAND", "place_hand", "hand_mass", "erard_stroke_new"],
    ),
    (
        "joints of its finger",
        ["Joints", "joints_m_per_n", "joints_m_per_n", "ErardInput", "joints_compliance", "erard_stroke_builtin"],
    ),
    (
        "the key front's own motion",
        ["Input::Rigid", "rigid", "erard_action_step_rigid", "rigid", "position", "erard_action_step_rigid"],
    ),
    (
        "sustain pedal",
        ["Action::set_pedal", "set_pedal", "erard_action_set_pedal", "set_pedal", "pedal", "erard_action_set_pedal"],
    ),
    (
        "88 keys played together",
        ["Keys::step", "Keys", "erard_keyboard_step", "Keyboard", "key[40].force", "erard_keyboard_step"],
    ),
    (
        "keyboards with strings, by name",
        ["Keyboard::builtin", "keyboard", "erard_keyboard_builtin", "builtin", "--keyboard", "erard_keyboard_builtin"],
    ),
    (
        "force on the string",
        ["Reading::string_n", "string_n", "string_n", "reading", "string_force", "erard_action_read"],
    ),
    (
        "force on the bridge",
        [
            "Strings::bridge_n",
            "bridge_n",
            "erard_action_bridge_force",
            "bridge_force",
            "bridge_force",
            "erard_keyboard_total_bridge_force",
        ],
    ),
    (
        "sound before the board",
        ["Keys::pressure_pa", NO, "erard_keyboard_pressure", "pressure", NO, "erard_keyboard_pressure"],
    ),
    ("saved states", ["Action::save", "save", "erard_action_save", "save", "fmi2GetFMUstate", "erard_action_save"]),
    (
        "causes from one's own readings of a key",
        ["diagnose", "diagnose", "erard_diagnose", "diagnose", NO, "erard_diagnose"],
    ),
    (
        "a body's mass with its inertia, by one name",
        ["Parameter::Mass", "vary", "erard_instrument_vary", "vary", "body.hammer.mass", "erard_instrument_with_dials"],
    ),
];

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Whether a word stands in a text by itself.
fn has_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(is_part) && !text[at + word.len()..].starts_with(is_part))
}

/// The texts in which a front's names stand.
fn interface(front: &str) -> String {
    let all = |paths: &[&str]| paths.iter().map(|path| read(path)).collect::<Vec<_>>().join("\n");
    match front {
        "Rust" => all(&[
            "crates/erard-core/src/player/action.rs",
            "crates/erard-core/src/player/input.rs",
            "crates/erard-core/src/keyboard/keys.rs",
            "crates/erard-core/src/keyboard/file.rs",
            "crates/erard-core/src/strings/modal/reading.rs",
            "crates/erard-core/src/parameter/register.rs",
            "crates/erard-workshop/src/diagnose/report.rs",
        ]),
        "Python" => all(&[
            "bindings/python/python/erard/_erard.pyi",
            "bindings/python/python/erard/_keys.py",
            "bindings/python/python/erard/_action.py",
            "bindings/python/python/erard/_common.py",
            "bindings/python/python/erard/_diagnose.py",
            "bindings/python/python/erard/_instrument.py",
        ]),
        "C" => read("bindings/c/include/erard.h"),
        "C++" => read("bindings/c/include/erard.hpp"),
        // The variables of both kinds of unit, the standard's functions, and how the command packs a unit.
        "FMU" => {
            let base = Instrument::builtin_text("concert-grand-strings").unwrap();
            let keyboard = Keyboard::builtin_text("concert-grand-strings").unwrap();
            let units = [Unit::of_instrument(base).unwrap(), Unit::of_keyboard(keyboard, base).unwrap()];
            let names = units.iter().flat_map(|unit| &unit.variables).map(|variable| variable.name.as_str());
            let files = all(&["bindings/c/src/fmi.rs", "crates/erard-cli/src/command/help/fmu.txt"]);
            names.chain([files.as_str()]).collect::<Vec<_>>().join("\n")
        }
        "studio" => read("studio/src/engine/library.ts"),
        other => panic!("{other}"),
    }
}

fn made() -> String {
    let mut out = format!("| | {} |\n|---|{}\n", FRONTS.join(" | "), "---|".repeat(FRONTS.len()));
    for (what, names) in TABLE {
        let cells = names.map(|name| if name == NO { "no".to_owned() } else { format!("`{name}`") });
        out += &format!("| {what} | {} |\n", cells.join(" | "));
    }
    out
}

#[test]
fn every_front_has_what_the_book_says() {
    for (place, front) in FRONTS.iter().enumerate() {
        let text = interface(front);
        for (what, names) in TABLE {
            let name = names[place];
            for part in name.split("::").filter(|part| *part != NO) {
                assert!(has_word(&text, part), "{front}, {what}: there is no `{name}`");
            }
        }
    }
}

#[test]
fn the_books_table_is_this_one() {
    const PATH: &str = "book/src/builders.md";
    const BEGIN: &str = "<!-- fronts -->\n";
    const END: &str = "<!-- end of fronts -->";
    let book = read(PATH);
    let (before, rest) = book.split_once(BEGIN).expect("the table's beginning");
    let (_, after) = rest.split_once(END).expect("the table's end");
    crate::generated::is_current(PATH, format!("{before}{BEGIN}{}{END}{after}", made()), "fronts");
}
