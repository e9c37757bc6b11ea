//! The papers' figures and claims about the grand action, computed anew.
//!
//! It uses the command's library: [`subjects`] computes claims, tables and curves, `page` shows them on one page,
//! [`command`] is the command line of `erard-reproduce`.

#![deny(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "`print_line!` and `warn!` neither panic nor let names steer a terminal"
)]

pub mod command;
mod page;
pub mod subjects;
