//! The command `erard`: arguments, progress, diagnostics, figures, files.
//!
//! No physics here: poses, forces and instants come from [`erard::run::Run`]; these modules only ask for them, draw
//! them and write them down.

#![deny(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "`print_line!` and `warn!` neither panic nor let names steer a terminal"
)]

pub mod answer;
#[cfg(feature = "listen")]
mod audio;
mod cache;
pub mod command;
mod compare;
mod diagnose;
mod excerpt;
pub mod failure;
mod fit;
mod heard;
pub mod identity;
pub mod inputs;
mod inside;
pub mod instruments;
mod keyboard;
mod kinematics;
mod law_points;
mod live;
mod measure;
mod names;
mod number;
pub mod output;
mod paper;
mod play;
pub mod printer;
pub mod progress;
mod recordings;
mod regulate;
mod scan;
pub mod session;
mod sheet;
mod signals;
mod small_plot;
mod spectrogram;
mod stages;
mod study;
mod suggest;
mod summary;
pub mod table;
mod units;
mod wav;
mod weigh;
mod zstandard;
