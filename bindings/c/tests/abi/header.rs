//! The header is made from the source, never by hand: `.ci/regenerate header` rewrites it.

use std::path::Path;

const SOURCES: [&str; 16] = [
    "version.rs",
    "outcome.rs",
    "status.rs",
    "text.rs",
    "reading.rs",
    "action.rs",
    "keyboard.rs",
    "halving.rs",
    "board.rs",
    "board_contacts.rs",
    "simulated_contacts.rs",
    "board_hammers.rs",
    "instrument.rs",
    "workshop.rs",
    "event_detector.rs",
    "stroke.rs",
];

const FIRST: &str = "\
/* liberard: the grand piano action, stepped from outside. Made from bindings/c/src by cbindgen: do not edit.
 *
 * Units are SI. Key and finger are positive downward (pushing), the hammer upward.
 *
 * Ownership: an object belongs to the caller until its free function is called. A char* that is not const belongs to
 * the caller until erard_text_free. A const char* belongs to the library. Any pointer may be NULL: a call that needs it
 * then reports ERARD_STATUS_NULL and does nothing.
 *
 * Real time: functions marked \"Real time: yes\" never allocate, lock, or call the system, and do a bounded amount of
 * work. All others may.
 *
 * Threads: objects are independent. Any thread may use an object, but only one at a time; the library does not lock it.
 *
 * Structs: set the first field of a struct to its size before you pass it: `ErardReading reading = {.struct_size = sizeof
 * reading};`. In an array the size of the first element holds for all. Later versions add fields at the end of a struct
 * only. A header and a library of different versions therefore work together: the library writes the fields that both
 * know and sets the others of your struct to 0; of an input it reads the fields that both know and takes those missing
 * as 0. It returns ERARD_STATUS_STRUCT and does nothing if the size is none of this struct's, or if a field of an input
 * that it does not know is not 0.
 *
 * Errors: a status below 0 means that nothing has changed (for the one exception see erard_keyboard_step).
 * erard_last_error describes errors of functions that are not for real time.
 *
 * The floating-point environment must be the default one (round to nearest). Denormal numbers: the library neither sets
 * nor clears the processor's flush-to-zero mode. Either mode works; the README gives the cost of each. */
";

fn generated() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml reads");
    config.header = Some(FIRST.trim_end().to_owned());
    let builder = SOURCES.iter().fold(cbindgen::Builder::new().with_config(config), |builder, source| {
        builder.with_src(root.join("src").join(source))
    });
    let mut header = Vec::new();
    builder.generate().expect("cbindgen reads the source").write(&mut header);
    String::from_utf8(header).expect("UTF-8")
}

#[test]
fn header_is_that_of_the_source() {
    crate::generated::is_current("bindings/c/include/erard.h", generated(), "header");
}

/// Every function that the library exports is in the header, and what the header says can be used in real time is what
/// is called so in the source.
#[test]
fn header_has_every_function() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = generated();
    let mut functions = 0;
    for source in SOURCES {
        let text = std::fs::read_to_string(root.join("src").join(source)).expect("it reads");
        for line in text.lines() {
            let Some((_, rest)) = line.split_once("extern \"C\" fn ") else { continue };
            if !line.starts_with("pub") {
                continue;
            }
            let name = rest.split('(').next().unwrap_or_default();
            assert!(header.contains(&format!("{name}(")), "{name} is not in the header");
            functions += 1;
        }
    }
    assert!(functions > 40, "{functions} functions");
}
