//! The unit tests of `src/flight.rs`, compiled beside the library: as tests of the library they would have the steps of every size compiled a second
//! time, which takes minutes.

use std::fs;
use std::path::Path;

use moreau_sizes::Marks;

#[allow(dead_code, reason = "the tests use a part of it")]
#[path = "../src/flight.rs"]
mod flight;

/// Cargo runs no unit tests of this library (`test = false`), so that no other file may have some.
#[test]
fn no_other_file_has_unit_tests() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for file in fs::read_dir(source).unwrap().map(|entry| entry.unwrap().path()) {
        let has_tests = fs::read_to_string(&file).unwrap().contains("#[test]");
        assert_eq!(has_tests, file.ends_with("flight.rs"), "{}: see tests/flight.rs", file.display());
    }
}
