//! The tests of what reproduces the papers: one program, so that it is linked once.

#[path = "../../../../crates/erard-cli/tests/it/common/schema.rs"]
mod schema;
#[cfg(unix)]
#[path = "../../../../crates/erard-cli/tests/it/common/signals.rs"]
mod signals;

mod claims;
mod program;
