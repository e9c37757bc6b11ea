//! The tests of the kernels: one program, so that it is linked once. The library has no unit tests: for them the steps
//! of every size would be compiled a second time, which takes minutes.

use std::fs;
use std::path::Path;

mod lanes;

/// Cargo runs no unit tests of this library (`test = false`), so that no file may have some.
#[test]
fn no_file_has_unit_tests() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let folders = [source.clone(), source.join("lanes")];
    for file in folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap()).map(|entry| entry.unwrap().path()) {
        if file.is_file() {
            let has_tests = fs::read_to_string(&file).unwrap().contains("#[test]");
            assert!(!has_tests, "{}: see tests/it/main.rs", file.display());
        }
    }
}
