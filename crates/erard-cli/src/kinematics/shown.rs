//! A case as it is shown.

use erard_kinematics::three_lever::{Stroke, StrokePose};
use erard_kinematics::{Case, Digest};

/// A requested case: the design as it is, or with parts moved.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    /// Name in files, as on the command line: `capstan=-10mm`; [`super::moves::UNMOVED`] for the design as it is.
    pub name: String,
    /// Display name: `capstan −10 mm`.
    pub label: String,
    /// The levers.
    pub case: Case,
    /// From rest to let-off.
    pub digest: Digest,
    /// The requested poses, as far as they can be reached.
    pub stroke: Stroke,
}

impl Shown {
    /// Place of the capstan's contact by sliding, m: S1 without the rolling of a disc.
    pub(crate) fn s1(&self, pose: &StrokePose) -> f64 {
        self.stroke.rest.s1 + pose.capstan_sliding
    }

    /// Place of the knuckle's contact by sliding, m: S2 without the rolling of a disc.
    pub(crate) fn s2(&self, pose: &StrokePose) -> f64 {
        self.stroke.rest.s2 + pose.knuckle_sliding
    }
}
