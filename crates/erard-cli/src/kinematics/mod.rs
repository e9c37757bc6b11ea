//! What `erard kinematics` makes of the cases that it is asked for: table, figures, summary.

pub(crate) mod figures;
pub(crate) mod moves;
pub(crate) mod summary;
pub(crate) mod table;

use erard_workshop::kinematics::{Case, Digest};
use moreau_linkage::three_lever::{Stroke, StrokePose};

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
