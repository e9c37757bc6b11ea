//! The command `erard`: arguments, progress, diagnostics, figures, files.
//!
//! No physics here: poses, forces and instants come from [`erard::run::Run`]; these modules only ask for them, draw them and
//! write them down.

#![deny(clippy::print_stdout, reason = "`say!` does not panic when the reader has gone away")]

pub mod cli_reference;
pub mod command;
pub mod failure;
pub mod keyboard;
pub mod kinematics;
pub mod measure;
pub mod output;
pub mod progress;
pub mod regulate;
pub mod report;
pub mod study;
pub mod summary;
pub mod table;
