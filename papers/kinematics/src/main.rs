//! The program `erard-kinematics`: leverage and sliding over the key's travel, from the geometry alone.
//!
//! A program on the command's library: the levers come from `erard-levers`, files and figures go the way of all results
//! of the command.

#![deny(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "`say!` and `tell!` neither panic nor let names steer a terminal"
)]

mod command;
mod figures;
mod moves;
mod summary;
mod table;

use std::process::ExitCode;

use erard_levers::{Case, Digest};
use moreau_linkage::three_lever::{Stroke, StrokePose};

fn main() -> ExitCode {
    command::run()
}

/// One case as it was asked for: the design as it is, or with parts moved.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    /// Its name in files, as on the command line: `capstan=-10mm`; [`moves::UNMOVED`] for the design as it is.
    pub name: String,
    /// Its name for people: `capstan −10 mm`.
    pub label: String,
    /// The levers.
    pub case: Case,
    /// From rest to let-off.
    pub digest: Digest,
    /// The poses that were asked for, as far as they could be reached.
    pub stroke: Stroke,
}

impl Shown {
    /// Place of the capstan's contact as the surfaces slide, m: S1, less what a disc rolls.
    pub(crate) fn s1(&self, pose: &StrokePose) -> f64 {
        self.stroke.rest.s1 + pose.capstan_sliding
    }

    /// The same of the knuckle's contact: S2.
    pub(crate) fn s2(&self, pose: &StrokePose) -> f64 {
        self.stroke.rest.s2 + pose.knuckle_sliding
    }
}
