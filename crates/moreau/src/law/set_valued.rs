//! F = k g^r (1 + eta Sign(dg/dt)), (C7) of the book, the sign set-valued at rest. A pressed felt that is held is
//! locked: it does not give at all until its load changes by more than eta of it.
//!
//! The first factor is a rate part. The sign is a law of the one-step problem: `dry_felts.rs` gives the zone one along
//! its row G with the bound h eta times that, as `laws.rs` gives a zone with Coulomb friction one along its slip row.

use super::hook::Law;
use super::number::{LAW_NUMBERS, LawNumber, Range};
use crate::real::Real;

/// F = k g^r (1 + eta Sign(dg/dt)). The memory is the dry part of the force over the last step, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetValued<T> {
    /// eta, 1, below 1.
    pub eta: T,
}

/// eta, for this law and for those that soften it.
pub(crate) const ETA: LawNumber = LawNumber::needed("eta", "dry_loss", "1", Range::Part).loss().means(
    "Dry loss eta of F = k g^r (1 + eta Sign(dg/dt)), from 0 to below 1 (in files at most 0.99): the part of k g^r \
     that opposes the motion, however slow. A felt loses 2 eta / (1 + eta) of the work of its compression, and with \
     `dry_slip` (s) only (1 - s) / (1 + s) of that. Without `dry_slip` the loss is set-valued: a felt that \
     is held does not yield at all to small changes of its load.",
);

impl<T: Real> Law<T> for SetValued<T> {
    const NUMBERS: &'static [LawNumber] = &[ETA];
    const REMEMBERS: usize = 1;

    fn numbers(&self) -> [T; LAW_NUMBERS] {
        [self.eta, T::ZERO, T::ZERO]
    }

    fn with([eta, ..]: [T; LAW_NUMBERS]) -> Self {
        SetValued { eta }
    }

    fn set_valued(&self) -> Option<T> {
        Some(self.eta)
    }

    fn largest(&self) -> T {
        T::ONE + self.eta
    }
}
