//! Tests that need a tool which is missing say so where the last lines of `.ci/run` list it.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// Notes that the running test, or a part of it, was left out for this reason.
pub fn not_run(reason: &str) {
    println!("not run: {reason}");
    // A test's thread has the test's name.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let list = Path::new(env!("CARGO_TARGET_TMPDIR")).join("not-run.txt");
    let mut list =
        OpenOptions::new().create(true).append(true).open(list).expect("the folder for tests' files is there");
    // In one call, for other tests write here, too.
    list.write_all(format!("{}::{test}: {reason}\n", env!("CARGO_PKG_NAME")).as_bytes()).expect("it is written");
}
