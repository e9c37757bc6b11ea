//! The command `erard`: arguments, progress, diagnostics, figures, files.
//!
//! No physics here: poses, forces and instants come from [`erard::run::Run`]; these modules only ask for them, draw them and
//! write them down.

#![deny(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "`say!` and `tell!` neither panic nor let names steer a terminal"
)]

pub mod answer;
pub mod cli_reference;
pub mod command;
pub mod compare;
mod excerpt;
pub mod failure;
pub mod fit;
pub mod identity;
pub mod inputs;
pub mod inside;
pub mod keyboard;
pub mod kinematics;
pub mod measure;
pub mod output;
pub mod paper;
pub mod progress;
pub mod recordings;
pub mod regulate;
pub mod say;
pub mod sheet;
pub mod signals;
pub mod small_plot;
pub mod spectrogram;
pub mod study;
pub mod summary;
pub mod table;
pub mod units;
pub mod wav;
pub mod weigh;
mod zstandard;
