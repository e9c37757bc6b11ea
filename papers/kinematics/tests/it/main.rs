//! The tests of the program: one of their own, so that it is linked once.

#[path = "../../../../crates/erard-cli/tests/it/common/mod.rs"]
mod common;

mod program;

/// What the tests run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_erard-kinematics");
