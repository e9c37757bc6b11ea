//! Energy balance of a running action.

use moreau::Ledger;

use crate::mechanism::{Mechanism, open_ledger, update_energies};

/// An observer that keeps the energy balance of an action: opened where it is, updated after every step, closed at the
/// end.
#[derive(Debug, Clone)]
pub struct LedgerBook {
    ledger: Ledger,
    rested: bool,
}

impl LedgerBook {
    /// Opens the ledger here.
    pub(crate) fn open(mechanism: &mut dyn Mechanism) -> Self {
        LedgerBook { ledger: open_ledger(mechanism), rested: false }
    }

    /// After every step; `rests`: it changed nothing.
    pub(crate) fn observe(&mut self, rests: bool, mechanism: &dyn Mechanism) {
        // A step that was left out has nothing to book, nor has one that changed nothing after another.
        if !(self.rested && rests) {
            mechanism.record_energy(&mut self.ledger);
        }
        self.rested = rests;
    }

    /// All energy that can have become motion up to here, J ([`Ledger::given`]).
    pub(crate) fn given(&self, mechanism: &dyn Mechanism) -> f64 {
        self.clone().close(mechanism).given()
    }

    /// The ledger up to here.
    pub(crate) fn close(mut self, mechanism: &dyn Mechanism) -> Ledger {
        update_energies(mechanism, &mut self.ledger);
        self.ledger
    }
}
