//! The tests of the kernels: one program, so that it is linked once.
//!
//! The unit tests of `src/impact.rs` are compiled here, beside the library: as tests of the library they would have the
//! steps of every size compiled a second time, which takes minutes.

use std::fs;
use std::path::Path;

use moreau_kernels::Probes;

#[allow(dead_code, reason = "the tests use a part of it")]
#[path = "../../src/impact.rs"]
mod impact;
mod lanes;

/// Cargo runs no unit tests of this library (`test = false`), so that no other file may have some.
#[test]
fn no_other_file_has_unit_tests() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let folders = [source.clone(), source.join("lanes")];
    for file in folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap()).map(|entry| entry.unwrap().path()) {
        if file.is_file() {
            let has_tests = fs::read_to_string(&file).unwrap().contains("#[test]");
            assert_eq!(has_tests, file.ends_with("impact.rs"), "{}: see tests/it/main.rs", file.display());
        }
    }
}
